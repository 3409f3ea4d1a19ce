//! What shows outside the visual field, where the gaze skips rays.

use crate::cave::Wall;
use crate::cave::look::ViewDirection;
use crate::cli::arguments::lod::LodArguments;
use crate::cli::prelude::*;
use crate::render::CaptureOptions;

/// `--fill`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fill {
    /// The scene's background, as in the paper
    Background,
    /// What the frame before shows there, with a smooth border
    Previous,
    /// The surroundings, captured through mirrored spheroids at the head, with a smooth border;
    /// at a lowered quality only a part of them is captured anew in a frame
    Capture,
}

named!(Fill { Background => "background", Previous => "previous", Capture => "capture" });

impl Fill {
    /// Checks that rays are skipped, and that nothing was `given` for a capture that is not made.
    pub fn check(self, lod: &LodArguments, given: Option<&str>) -> Result<(), Failure> {
        if self != Self::Background && (!lod.is_on() || lod.is_foveated()) {
            return Err(misuse!(
                "--fill is for --lod paper or paper-ellipse: with --lod {} no ray is skipped",
                lod.name()
            ));
        }
        match given {
            Some(argument) if self != Self::Capture => Err(misuse!(
                "{argument} is for --fill capture: nothing else is captured"
            )),
            _ => Ok(()),
        }
    }
}

#[derive(Debug, Clone, Copy, Args)]
pub struct CaptureDetail {
    /// Pixels along each side of a captured hemisphere [default: 128]
    #[arg(id = "fill-size", long = "fill-size", value_name = "PIXELS",
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    size: Option<u32>,
    /// Level of detail of captured rays, 0 to 1. It limits the faces of meshes, and the bounces
    /// to this part of --depth, rounded down: without bounces mirrors show nothing
    /// [default: 0.34]
    #[arg(id = "fill-level", long = "fill-level", value_name = "LEVEL",
          value_parser = within::<f32>(0.0..=1.0, "a level of detail from 0 to 1"))]
    level: Option<f32>,
}

impl CaptureDetail {
    pub fn options(&self) -> CaptureOptions {
        let default = CaptureOptions::default();
        CaptureOptions {
            size: self.size.unwrap_or(default.size),
            level: self.level.unwrap_or(default.level),
            ..default
        }
    }

    /// Returns the first of these arguments that was given.
    pub fn given(&self) -> Option<&'static str> {
        let size = self.size.map(|_| "--fill-size");
        size.or(self.level.map(|_| "--fill-level"))
    }
}

#[derive(Debug, Args)]
pub struct CaptureArguments {
    #[command(flatten)]
    detail: CaptureDetail,
    /// Limit of the steps of a capture. What they do not reach shows the background
    /// [default: no limit]
    #[arg(id = "fill-steps", long = "fill-steps", value_name = "N",
          value_parser = whole::<u64>(0..))]
    steps: Option<u64>,
}

impl CaptureArguments {
    pub fn options(&self) -> CaptureOptions {
        CaptureOptions {
            steps: self.steps,
            ..self.detail.options()
        }
    }
}

#[derive(Debug, Args)]
pub struct FillArguments {
    /// What shows where the gaze skips rays. Capture and previous imply --lod paper unless
    /// another --lod is given
    #[arg(long, value_enum, default_value = "background")]
    pub fill: Fill,
    #[command(flatten)]
    pub capture: CaptureArguments,
    /// Where the viewer looked in the frame before, as in --look, for --fill previous
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    previous_look: Option<ViewDirection>,
}

impl FillArguments {
    /// Checks that these arguments go together; returns where the viewer of the frame before looked,
    /// for --fill previous.
    pub fn looked(&self, lod: &LodArguments) -> Result<Option<ViewDirection>, Failure> {
        let steps = self.capture.steps.map(|_| "--fill-steps");
        let given = self.capture.detail.given().or(steps);
        self.fill.check(lod, given)?;
        match (self.fill, self.previous_look) {
            (Fill::Previous, None) => Err(misuse!(
                "--fill previous needs --previous-look DIRECTION: where the viewer looked in the \
                 frame before"
            )),
            (Fill::Background | Fill::Capture, Some(_)) => Err(misuse!(
                "--previous-look is for --fill previous: nothing else shows an earlier frame"
            )),
            (_, looked) => Ok(looked),
        }
    }
}
