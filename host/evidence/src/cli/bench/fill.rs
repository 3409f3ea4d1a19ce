//! `shisen-evidence bench fill`: the cost of filling the part of the walls that the gaze skips,
//! and how far the filling is from full tracing.

use super::frames::{FrameArguments, Frames, Look, Title, Way};
use crate::measure::{Timed, in_turns};
use crate::table::Table;
use clap::Args;
use glam::Quat;
use serde::Serialize;
use shisen::cli::arguments::filling::CaptureArguments;
use shisen::cli::arguments::turn;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::live::quantiles::median;
use shisen::render::{self, Filling, Frame};
use shisen::show::lod::OutsideDifference;
use std::fmt;

/// What fills the part of the walls that the gaze skips
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the
/// floor (state 2), three walls for two eyes: the background, as in the paper, a
/// capture of the surroundings through mirrored spheroids at the head, and the
/// frame before, in which the viewer looked to one side by --turn. Frames are
/// rendered in turns; times are medians.
///
/// With --json, one object: threads, size, mesh, turn (degrees), `fill_size` and
/// cells: for each scene and state `plain_seconds`, `outside_pixels` and fills:
/// for each mode (background, capture, previous) seconds, `capture_seconds`,
/// `capture_steps`, `outside_rms` (root mean square difference to full tracing
/// outside the visual field, of 255 codes) and `outside_psnr` (decibels; both
/// null where no pixel is outside).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    #[command(flatten)]
    capture: CaptureArguments,
    /// How far to the left the viewer looked in the frame before: degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0, value_parser = turn)]
    turn: f32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    turn: f32,
    fill_size: u32,
    cells: Vec<Cell>,
}

/// A scene and a state.
#[derive(Debug, Serialize)]
struct Cell {
    scene: &'static str,
    state: usize,
    plain_seconds: f64,
    outside_pixels: u64,
    fills: Vec<Fill>,
}

#[derive(Debug, Serialize)]
struct Fill {
    mode: &'static str,
    seconds: f64,
    capture_seconds: f64,
    capture_steps: u64,
    outside_rms: Option<f64>,
    outside_psnr: Option<f64>,
}

/// The names of the fillings, in the order of their turns.
const MODES: [&str; 3] = ["background", "capture", "previous"];

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let report = Report {
        title: arguments.frames.title(),
        turn: arguments.turn,
        fill_size: arguments.capture.options().size,
        cells: arguments.frames.cells(|frames, scene, state, look| {
            let (plain, fills) = arguments.measure(frames, look)?;
            let difference = |frame: &Frame| outside_difference(frames, look, frame, &plain.first);
            let mut cell = Cell {
                scene: scene.name(),
                state,
                plain_seconds: plain.median(),
                outside_pixels: 0,
                fills: Vec::new(),
            };
            for (mode, (time, captures)) in MODES.into_iter().zip(fills) {
                let error = difference(&time.first)?;
                cell.outside_pixels = error.pixels();
                let capture = time.first.capture.as_ref();
                cell.fills.push(Fill {
                    mode,
                    seconds: time.median(),
                    capture_seconds: median(captures),
                    capture_steps: capture.map_or(0, |one| one.statistics.steps),
                    outside_rms: error.root_mean_square(),
                    outside_psnr: error.psnr(),
                });
            }
            Ok(cell)
        })?,
    };
    print(&report, arguments.json)
}

/// The frames of a filling, and the seconds of their captures.
type Filled = (Timed<Frame>, Vec<f64>);

impl Arguments {
    /// The plain frame and the frame of each filling.
    fn measure(&self, frames: &Frames, look: Look) -> Result<(Timed<Frame>, Vec<Filled>), Failure> {
        let background = Filling::Background;
        let before = Look {
            forward: Quat::from_axis_angle(look.up, self.turn.to_radians()) * look.forward,
            up: look.up,
        };
        let previous = frames.frame(Way::Lod, before, background)?;
        let ways = [
            (Way::Plain, background),
            (Way::Lod, background),
            (Way::Lod, Filling::Capture(self.capture.options())),
            (Way::Lod, Filling::Previous(&previous)),
        ];
        let mut captures = Vec::new();
        let timed = in_turns(&ways, self.frames.repeat as usize, |&(way, filling)| {
            let frame = frames.frame(way, look, filling)?;
            captures.push(frame.capture.as_ref().map_or(0.0, |one| one.seconds));
            Ok::<_, Failure>((frame.seconds, frame))
        })?;
        let mut timed = timed.into_iter();
        let Some(plain) = timed.next() else {
            unreachable!("one round or more")
        };
        let own = |number| captures.iter().skip(number).step_by(ways.len()).copied();
        let filled = (1..).zip(timed);
        let filled = filled.map(|(number, time)| (time, own(number).collect()));
        Ok((plain, filled.collect()))
    }
}

/// The difference of a frame from the plain one outside of the visual field.
fn outside_difference(
    frames: &Frames,
    look: Look,
    found: &Frame,
    plain: &Frame,
) -> Result<OutsideDifference, Failure> {
    let mut error = OutsideDifference::default();
    let mut pictures = found.pictures.iter().zip(&plain.pictures);
    for wall in &frames.cave.walls {
        for observer in Frames::observers(Way::Lod, look)? {
            let view = render::view(wall, &observer)?;
            if let (Some((found, plain)), Some(lod)) = (pictures.next(), &observer.lod) {
                error.add(&view, lod, &found.picture, &plain.picture);
            }
        }
    }
    Ok(error)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(&self.cells)
            .text("", |c| format!("{}{}", c.scene, c.state))
            .number("plain", 2, |c| Some(1e3 * c.plain_seconds));
        for (number, mode) in MODES.into_iter().enumerate() {
            table = table.number(mode, 2, |c| Some(1e3 * c.fills[number].seconds));
        }
        table = table.number("time of the capture alone", 2, |c| {
            Some(1e3 * c.fills[1].capture_seconds)
        });
        for (number, mode) in MODES.into_iter().enumerate() {
            table = table.number(format!("error, {mode}"), 1, |c| c.fills[number].outside_rms);
        }
        table = table.count("pixels outside", |c| c.outside_pixels);
        write!(
            f,
            "{}, hemispheres of {}² pixels, {}° turned; milliseconds a frame, and codes of \
             255 from full tracing outside the field\n{table}",
            self.title, self.fill_size, self.turn
        )
    }
}
