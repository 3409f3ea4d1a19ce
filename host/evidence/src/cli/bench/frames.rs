//! Frames of the paper's scenes with and without level of detail, in turns.

use super::print;
use clap::Args;
use glam::Vec3;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer, Wall};
use shisen::cli::arguments::source::{BUILT_IN_MESH, Source};
use shisen::cli::arguments::{EffectArguments, LevelArguments, ModelArguments, SceneName, threads};
use shisen::cli::numbers::whole;
use shisen::cli::output::counted;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::progress::Ticker;
use shisen::render::{self, Filling, Frame, Observer, Options};
use shisen::scene::builtin::PaperScene;
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Acuity, Gaze, LineOfSight, VisualField};
use std::fmt;
use std::num::NonZeroUsize;

#[derive(Debug, Args)]
pub(super) struct FrameArguments {
    #[command(flatten)]
    model: ModelArguments,
    /// Threads to trace on [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Pixels along each side of a wall
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    pub(super) size: u32,
    /// How often to render each frame
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = whole::<u32>(1..=1_000))]
    pub(super) repeat: u32,
    #[command(flatten)]
    levels: LevelArguments,
    #[command(flatten)]
    effects: EffectArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) struct Frames {
    pub(super) scene: BakedScene,
    pub(super) cave: Cave,
    pub(super) options: Options,
}

/// A way to follow the gaze.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// Everything in full.
    Plain,
    /// The paper's method.
    Lod,
    /// The paper's rays, each in full.
    Cut,
    /// The paper's rays with all faces. Where these are as many as without, the difference
    /// is the cost of levels and of the choice by them.
    Levels,
    /// Detail as large as the eye sees.
    Foveated,
}

/// The viewer's line of sight and the direction up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) forward: Vec3,
    pub(super) up: Vec3,
}

/// States 1 and 2 of the paper: the viewer looks at the front wall, or at the floor.
const STATES: [Look; 2] = [
    Look {
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
    },
    Look {
        forward: Vec3::NEG_Y,
        up: Vec3::NEG_Z,
    },
];

/// A scene of the paper and a state of its viewer.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Cell {
    /// Scene of the paper: A, B, C or D.
    pub(super) scene: &'static str,
    /// What the viewer looks at: 1 the front wall, 2 the floor.
    pub(super) state: usize,
}

/// The name of the cell, such as A1.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.scene, self.state)
    }
}

/// A report with the arguments of its frames.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct WithFrames<R> {
    /// Threads that trace.
    threads: usize,
    /// Pixels along each side of a wall.
    size: u32,
    /// The mesh's file as given, or quadruped.
    mesh: String,
    #[serde(flatten)]
    report: R,
}

impl FrameArguments {
    /// Prints a report with these frames in it: its object, or else its text after theirs.
    pub(super) fn print(&self, report: impl Serialize, text: &str) -> Result<(), Failure> {
        let (size, threads) = (self.size, self.options().threads);
        let mesh = self.model.mesh.as_ref();
        let mesh = mesh.map_or(BUILT_IN_MESH.to_owned(), |path| path.display().to_string());
        let counted = counted(threads as u64, "thread");
        let text = format!("{mesh}, {size} × {size} pixels × 6, {counted}{text}");
        let report = WithFrames {
            threads,
            size,
            mesh,
            report,
        };
        print(self.json, &report, &text)
    }

    fn options(&self) -> Options {
        let mut options = Options {
            effects: self.effects.effects,
            ..Options::default()
        };
        if let Some(threads) = self.threads {
            options.threads = threads.get();
        }
        options
    }

    /// Measures a cell for each scene of the paper and each state, counted from 1.
    ///
    /// # Errors
    /// A scene that cannot be read, baked or traced, and the errors of `cell`.
    pub(super) fn cells<C>(
        &self,
        mut cell: impl FnMut(&Frames, Cell, Look) -> Result<C, Failure>,
    ) -> Result<Vec<C>, Failure> {
        let mut cells = Vec::new();
        for scene in PaperScene::ALL {
            let frames = self.frames(scene)?;
            for (state, look) in (1..).zip(STATES) {
                let scene = scene.name();
                cells.push(cell(&frames, Cell { scene, state }, look)?);
            }
        }
        Ok(cells)
    }

    /// Bakes a scene of the paper.
    ///
    /// # Errors
    /// A scene that cannot be read, baked or traced.
    pub(super) fn frames(&self, scene: PaperScene) -> Result<Frames, Failure> {
        let source = Source::load(&SceneName::Paper(scene), &self.model)?;
        let levels = self.levels.polygon_levels(Layout::Fast)?;
        let ticker = Ticker::start(format!("baking {}", source.shown.scene), true);
        Ok(Frames {
            scene: source.baked(Layout::Fast, Some(&levels), &ticker)?.baked,
            cave: Cave::built_in(BuiltInCave::ThreeWall, [self.size; 2])?,
            options: self.options(),
        })
    }
}

impl Frames {
    /// Renders a frame.
    ///
    /// # Errors
    /// A line of sight without a direction; threads that cannot be had.
    pub(super) fn frame(
        &self,
        way: Way,
        look: Look,
        filling: Filling<'_>,
    ) -> Result<Frame, Failure> {
        let eyes = Self::observers(way, look)?;
        let (cave, options) = (&self.cave, &self.options);
        let quiet = |_, _| {};
        Ok(render::cave_filled(
            self.scene.scene(),
            cave,
            &eyes,
            options,
            filling,
            &quiet,
        )?)
    }

    /// Returns the two eyes.
    ///
    /// # Errors
    /// A line of sight without a direction.
    pub(super) fn observers(way: Way, look: Look) -> Result<[Observer; 2], Failure> {
        let Look { forward, up } = look;
        let sight = LineOfSight::new(Vec3::ZERO, forward, up).map_err(Failure::from_error)?;
        let mut lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        lod.bounces = way != Way::Cut;
        lod.faces = way == Way::Lod;
        let viewer = Viewer::default();
        Ok(Eye::STEREO.map(|eye| match way {
            Way::Plain => Observer::new(eye, viewer.eye(eye)),
            Way::Foveated => {
                Observer::foveated(eye, viewer.eye(eye), (sight, Acuity::GUENTER), 0.0)
            }
            Way::Lod | Way::Cut | Way::Levels => Observer {
                lod: Some(lod),
                ..Observer::new(eye, viewer.eye(eye))
            },
        }))
    }
}
