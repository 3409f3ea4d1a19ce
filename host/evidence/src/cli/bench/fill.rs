//! `shisen-evidence bench fill`: what it costs to show something where the gaze skips
//! rays, and how far that is from what is there.

use super::cells::{Rows, Title};
use super::frames::{FrameArguments, Frames, Look, Way};
use super::table2::STATES;
use clap::Args;
use glam::Quat;
use serde::Serialize;
use shisen::cli::arguments::filling::CaptureArguments;
use shisen::cli::arguments::turn;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::live::quantiles::median;
use shisen::render::{self, CaptureOptions, Filling, Frame};
use shisen::scene::builtin::PaperScene;
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

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    turn: f32,
    fill_size: u32,
    cells: Vec<Cell>,
}

/// One scene, looked at one way.
#[derive(Debug, Serialize)]
struct Cell {
    scene: &'static str,
    state: usize,
    plain_seconds: f64,
    outside_pixels: u64,
    fills: Vec<Fill>,
}

/// One way to fill it.
#[derive(Debug, Serialize)]
struct Fill {
    mode: &'static str,
    seconds: f64,
    capture_seconds: f64,
    capture_steps: u64,
    outside_rms: Option<f64>,
    outside_psnr: Option<f64>,
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let capture = arguments.capture.options();
    let mut cells = Vec::new();
    for scene in [PaperScene::A, PaperScene::B, PaperScene::C, PaperScene::D] {
        let of_scene = frames.frames(scene)?;
        for (state, (forward, up)) in (1..).zip(STATES) {
            let look = Look { forward, up };
            let before = Look {
                forward: Quat::from_axis_angle(up, arguments.turn.to_radians()) * forward,
                up,
            };
            let measured = Measured::new(&of_scene, look, before, capture, frames.repeat)?;
            cells.push(measured.cell(&of_scene, scene, state)?);
        }
    }
    let report = Report {
        title: frames.title(),
        turn: arguments.turn,
        fill_size: capture.size,
        cells,
    };
    print(&report, arguments.json)
}

/// The names of the ways, in the order of their turns.
const MODES: [&str; 3] = ["background", "capture", "previous"];

/// The frames of a cell, of each mode the last, and all times.
struct Measured {
    look: Look,
    plain: Frame,
    plain_seconds: f64,
    filled: Vec<(Frame, f64, f64)>,
}

impl Measured {
    fn new(
        of: &Frames,
        look: Look,
        before: Look,
        capture: CaptureOptions,
        repeat: u32,
    ) -> Result<Self, Failure> {
        let background = Filling::Background;
        let previous = of.frame(Way::Lod, before, background)?;
        let fillings = [
            background,
            Filling::Capture(capture),
            Filling::Previous(&previous),
        ];
        let plain = of.frame(Way::Plain, look, background)?;
        let mut plain_seconds = vec![plain.seconds];
        let mut times = [const { (Vec::new(), Vec::new()) }; MODES.len()];
        let mut last = [const { None }; MODES.len()];
        for _ in 0..repeat {
            plain_seconds.push(of.frame(Way::Plain, look, background)?.seconds);
            for (number, filling) in fillings.into_iter().enumerate() {
                let frame = of.frame(Way::Lod, look, filling)?;
                times[number].0.push(frame.seconds);
                let captured = frame.capture.as_ref().map_or(0.0, |one| one.seconds);
                times[number].1.push(captured);
                last[number] = Some(frame);
            }
        }
        let mut filled = Vec::new();
        for (frame, (seconds, captured)) in last.into_iter().zip(times) {
            let frame = match frame {
                Some(frame) => frame,
                None => of.frame(Way::Lod, look, background)?,
            };
            filled.push((frame, median(seconds), median(captured)));
        }
        Ok(Self {
            look,
            plain,
            plain_seconds: median(plain_seconds),
            filled,
        })
    }

    fn cell(self, of: &Frames, scene: PaperScene, state: usize) -> Result<Cell, Failure> {
        let mut outside_pixels = 0;
        let mut fills = Vec::new();
        for (mode, (frame, seconds, capture_seconds)) in MODES.into_iter().zip(&self.filled) {
            let error = of.outside_error(self.look, frame, &self.plain)?;
            outside_pixels = error.pixels();
            fills.push(Fill {
                mode,
                seconds: *seconds,
                capture_seconds: *capture_seconds,
                capture_steps: frame.capture.as_ref().map_or(0, |one| one.statistics.steps),
                outside_rms: error.root_mean_square(),
                outside_psnr: error.psnr(),
            });
        }
        Ok(Cell {
            scene: scene.name(),
            state,
            plain_seconds: self.plain_seconds,
            outside_pixels,
            fills,
        })
    }
}

impl Frames {
    fn outside_error(
        &self,
        look: Look,
        found: &Frame,
        full: &Frame,
    ) -> Result<OutsideDifference, Failure> {
        let mut error = OutsideDifference::default();
        let mut pictures = found.pictures.iter().zip(&full.pictures);
        for wall in &self.cave.walls {
            for observer in Self::observers(Way::Lod, look)? {
                let view = render::view(wall, &observer)?;
                if let (Some((found, full)), Some(lod)) = (pictures.next(), &observer.lod) {
                    error.add(&view, lod, &found.picture, &full.picture);
                }
            }
        }
        Ok(error)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, hemispheres of {}² pixels, {}° turned; milliseconds a frame, and codes of \
             255 from full tracing outside the field",
            self.title, self.fill_size, self.turn
        )?;
        let fill = |cell: &Cell, number: usize, of: fn(&Fill) -> Option<f64>| {
            cell.fills.get(number).and_then(of)
        };
        let mut table = Rows::new(f, &self.cells, 22, |c| (c.scene, c.state))?;
        table.numbers("plain", 2, |c| Some(1e3 * c.plain_seconds))?;
        for (number, mode) in MODES.into_iter().enumerate() {
            table.numbers(mode, 2, |c| fill(c, number, |f| Some(1e3 * f.seconds)))?;
        }
        table.numbers("of which the capture", 2, |c| {
            fill(c, 1, |f| Some(1e3 * f.capture_seconds))
        })?;
        for (number, mode) in MODES.into_iter().enumerate() {
            let name = format!("error, {mode}");
            table.numbers(&name, 1, |c| fill(c, number, |f| f.outside_rms))?;
        }
        table.numbers("pixels outside", 0, |c| Some(c.outside_pixels as f64))
    }
}
