//! What shows where the gaze skips rays, as it is asked for.

use crate::cave::Wall;
use crate::cave::look::ViewDirection;
use crate::cli::arguments::whole;
use crate::cli::output::failure::Failure;
use crate::render::CaptureOptions;
use clap::{Args, ValueEnum};

/// How finely to capture the surroundings.
#[derive(Debug, Clone, Copy, Args)]
pub struct CaptureDetail {
    /// Of a capture, pixels along each side of a hemisphere [default: 128]
    #[arg(id = "fill-size", long = "fill-size", value_name = "PIXELS",
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    size: Option<u32>,
    /// Of a capture, the level of detail of its rays, 0 to 1, which limits their
    /// bounces, to those of level 1 times it, rounded down, and the faces of meshes:
    /// mirrors show nothing at a level without bounces [default: 0.34]
    #[arg(id = "fill-level", long = "fill-level", value_name = "LEVEL", value_parser = level)]
    level: Option<f32>,
}

impl CaptureDetail {
    /// What was asked for.
    pub fn options(&self) -> CaptureOptions {
        let default = CaptureOptions::default();
        CaptureOptions {
            size: self.size.unwrap_or(default.size),
            level: self.level.unwrap_or(default.level),
            ..default
        }
    }

    /// The first of them that was given.
    pub fn given(&self) -> Option<&'static str> {
        let size = self.size.map(|_| "--fill-size");
        size.or(self.level.map(|_| "--fill-level"))
    }
}

/// Refuses what is said of a capture where none is made.
///
/// # Errors
/// Of usage: what was `given`.
pub fn refuse_detail(given: Option<&str>) -> Result<(), Failure> {
    match given {
        Some(argument) => Err(Failure::usage(&format!(
            "{argument} is for --fill capture: nothing else is captured"
        ))),
        None => Ok(()),
    }
}

/// How to capture the surroundings.
#[derive(Debug, Args)]
pub struct CaptureArguments {
    #[command(flatten)]
    detail: CaptureDetail,
    /// Of a capture, the most steps that it may take; what they do not
    /// reach shows the background [default: as many as it needs]
    #[arg(id = "fill-steps", long = "fill-steps", value_name = "N",
          value_parser = whole::<u64>(0..))]
    steps: Option<u64>,
}

fn level(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(level) if (0.0..=1.0).contains(&level) => Ok(level),
        _ => Err("give a level of detail from 0 to 1".to_owned()),
    }
}

impl CaptureArguments {
    /// What was asked for.
    pub fn options(&self) -> CaptureOptions {
        CaptureOptions {
            steps: self.steps,
            ..self.detail.options()
        }
    }

    /// The first of them that was given.
    fn given(&self) -> Option<&'static str> {
        let steps = self.steps.map(|_| "--fill-steps");
        self.detail.given().or(steps)
    }
}

/// What shows where the gaze skips rays.
#[derive(Debug, Args)]
pub struct FillArguments {
    /// With --lod, what shows where the gaze skips rays. Anything but the background makes
    /// --lod paper where that is not given
    #[arg(long, value_enum, default_value = "background")]
    fill: Choice,
    #[command(flatten)]
    capture: CaptureArguments,
    /// With --fill previous, where the viewer looked in the frame before, as
    /// --look
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    previous_look: Option<ViewDirection>,
}

/// `--fill`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Choice {
    /// What a ray sees that meets nothing: the paper's
    Background,
    /// The surroundings, captured once a frame through mirrored spheroids at
    /// the head, with a smooth blend at the border
    Capture,
    /// What the frame before shows there, with a smooth blend at the border
    Previous,
}

/// What to fill with.
#[derive(Debug, Clone, Copy)]
pub enum Wanted {
    /// The background.
    Background,
    /// A capture.
    Capture(CaptureOptions),
    /// A frame that is looked at along this.
    Previous(ViewDirection),
}

impl Wanted {
    /// As it is written on a command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Background => "background",
            Self::Capture(_) => "capture",
            Self::Previous(_) => "previous",
        }
    }
}

impl FillArguments {
    /// What was asked for.
    ///
    /// # Errors
    /// Of usage: what does not go together.
    pub fn wanted(&self, lod_is_on: bool) -> Result<Wanted, Failure> {
        if self.fill != Choice::Background && !lod_is_on {
            return Err(Failure::usage(
                "--fill is for --lod paper, paper-ellipse or foveated: with --lod off no ray is skipped",
            ));
        }
        if self.fill != Choice::Capture {
            refuse_detail(self.capture.given())?;
        }
        if self.previous_look.is_some() && self.fill != Choice::Previous {
            return Err(Failure::usage(
                "--previous-look is for --fill previous: nothing else shows an earlier frame",
            ));
        }
        match (self.fill, self.previous_look) {
            (Choice::Background, _) => Ok(Wanted::Background),
            (Choice::Capture, _) => Ok(Wanted::Capture(self.capture.options())),
            (Choice::Previous, Some(look)) => Ok(Wanted::Previous(look)),
            (Choice::Previous, None) => Err(Failure::usage(
                "--fill previous needs --previous-look DIRECTION: where the viewer looked in the \
                 frame before",
            )),
        }
    }
}
