//! `shisen-evidence bench fill`: the cost of filling the part of the walls that the gaze skips,
//! and how far the filling is from full tracing.

use super::frames::{Cell, FrameArguments, Frames, Look, Way};
use crate::measure::{Timed, in_turns};
use crate::table::Table;
use clap::Args;
use glam::Quat;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::arguments::filling::CaptureArguments;
use shisen::cli::arguments::turn;
use shisen::cli::output::failure::Failure;
use shisen::live::quantiles::median;
use shisen::render::{self, Filling, Frame};
use shisen::show::lod::OutsideDifference;

/// What fills the part of the walls that the gaze skips
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the
/// floor (state 2), three walls for two eyes: the background, as in the paper, a
/// capture of the surroundings through mirrored spheroids at the head, and the
/// frame before, in which the viewer looked to one side by --turn. Frames are
/// rendered in turns; times are medians.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    #[command(flatten)]
    capture: CaptureArguments,
    /// How far to the left the viewer looked in the frame before: degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0, value_parser = turn)]
    turn: f32,
}

/// What fills the part of the walls that the gaze skips.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// How far to the left the viewer looked in the frame before, degrees.
    turn: f32,
    /// Pixels along each side of a captured hemisphere.
    fill_size: u32,
    /// Scenes and states.
    cells: Vec<FilledCell>,
}

/// The fillings of a scene in a state.
#[derive(Debug, Serialize, JsonSchema)]
struct FilledCell {
    #[serde(flatten)]
    cell: Cell,
    /// Time of a frame in full, seconds.
    plain_seconds: f64,
    /// Pixels outside of the visual field.
    outside_pixels: u64,
    /// Fillings: background, capture and previous.
    fills: Vec<Fill>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Fill {
    /// What fills: background, capture or previous.
    mode: &'static str,
    /// Time of a frame, seconds.
    seconds: f64,
    /// Time of its capture, seconds.
    capture_seconds: f64,
    /// Steps of its capture.
    capture_steps: u64,
    /// Root mean square difference to full tracing outside of the visual field, of 255 codes;
    /// null if no pixel is outside.
    outside_rms: Option<f64>,
    /// The same as a ratio of signal to noise, decibels; null likewise, or if nothing differs.
    outside_psnr: Option<f64>,
}

const MODES: [&str; 3] = ["background", "capture", "previous"];

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cells = arguments.frames.cells(|frames, cell, look| {
        let (plain, measured) = arguments.measure(frames, look)?;
        let (mut outside_pixels, mut fills) = (0, Vec::new());
        for (mode, (time, captures)) in MODES.into_iter().zip(measured) {
            let error = outside_difference(frames, look, &time.first, &plain.first)?;
            outside_pixels = error.pixels();
            let capture = time.first.capture.as_ref();
            fills.push(Fill {
                mode,
                seconds: time.median(),
                capture_seconds: median(captures),
                capture_steps: capture.map_or(0, |one| one.statistics.steps),
                outside_rms: error.root_mean_square(),
                outside_psnr: error.psnr(),
            });
        }
        Ok(FilledCell {
            cell,
            plain_seconds: plain.median(),
            outside_pixels,
            fills,
        })
    })?;
    let table = Table::new(&cells)
        .text("", |one| one.cell.to_string())
        .number("plain", 2, |one| 1e3 * one.plain_seconds)
        .number(MODES[0], 2, |one| 1e3 * one.fills[0].seconds)
        .number(MODES[1], 2, |one| 1e3 * one.fills[1].seconds)
        .number(MODES[2], 2, |one| 1e3 * one.fills[2].seconds)
        .number("time of the capture alone", 2, |one| {
            1e3 * one.fills[1].capture_seconds
        })
        .number("error, background", 1, |one| one.fills[0].outside_rms)
        .number("error, capture", 1, |one| one.fills[1].outside_rms)
        .number("error, previous", 1, |one| one.fills[2].outside_rms)
        .count("pixels outside", |one| one.outside_pixels);
    let (size, turn) = (arguments.capture.options().size, arguments.turn);
    let text = format!(
        ", hemispheres of {size}² pixels, {turn}° turned; milliseconds a frame, and codes of 255 \
         from full tracing outside the field\n{table}"
    );
    let report = Report {
        turn,
        fill_size: size,
        cells,
    };
    arguments.frames.print(report, &text)
}

/// The frames of a filling, and the seconds of their captures.
type Filled = (Timed<Frame>, Vec<f64>);

impl Arguments {
    /// Returns the plain frame and the frame of each filling.
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

/// Returns the difference of a frame from the plain one outside of the visual field.
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
