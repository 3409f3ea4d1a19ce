//! Frames of the paper's scenes with and without level of detail, in turns.

use super::cells::Title;
use clap::Args;
use glam::Vec3;
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer, Wall};
use shisen::cli::arguments::source::{BUILT_IN_MESH, Loaded, Source, bake};
use shisen::cli::arguments::{EffectArguments, LevelArguments, Model, SceneName, threads, whole};
use shisen::cli::output::failure::Failure;
use shisen::render::{self, Filling, Frame, Observer, Options};
use shisen::scene::builtin::PaperScene;
use shisen::with_scene;
use shisen_core::frame::{LevelOfDetail, Statistics};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use std::num::NonZeroUsize;

/// What frames to measure.
#[derive(Debug, Args)]
pub(super) struct FrameArguments {
    #[command(flatten)]
    model: Model,
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
}

/// The frames of one scene.
pub(super) struct Frames {
    pub(super) scene: BakedScene,
    pub(super) cave: Cave,
    pub(super) options: Options,
}

/// How detail follows the gaze in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// Not at all.
    Plain,
    /// The paper's.
    Lod,
    /// The paper's rays, each in full.
    Cut,
    /// The paper's rays with all faces. Where these are as many as without, what
    /// is left is what levels and the choice by them cost.
    Levels,
    /// Fewer rays in the periphery.
    Foveated,
}

impl FrameArguments {
    /// What they are called.
    pub(super) fn title(&self) -> Title {
        Title {
            threads: self.options().threads,
            size: self.size,
            mesh: match &self.model.mesh {
                Some(path) => path.display().to_string(),
                None => BUILT_IN_MESH.to_owned(),
            },
        }
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

    /// A scene of the paper, ready.
    ///
    /// # Errors
    /// Whatever keeps it from being traced.
    pub(super) fn frames(&self, scene: PaperScene) -> Result<Frames, Failure> {
        let source = Source::load(&SceneName::Paper(scene), &self.model)?;
        let levels = self.levels.polygon_levels(Layout::Fast)?;
        let scene = match source.scene {
            Loaded::Baked(baked) => baked,
            Loaded::Described(scene) => bake(&scene, &source.name, Layout::Fast, Some(&levels))?,
        };
        Ok(Frames {
            scene,
            cave: Cave::built_in(BuiltInCave::ThreeWall, [self.size; 2])?,
            options: self.options(),
        })
    }
}

/// Where the viewer looks, and what is up then.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) forward: Vec3,
    pub(super) up: Vec3,
}

impl Frames {
    /// Renders one: seconds, rays and steps.
    ///
    /// # Errors
    /// A line of sight that is none; threads that cannot be had.
    pub(super) fn render(
        &self,
        way: Way,
        forward: Vec3,
        up: Vec3,
    ) -> Result<(f64, Statistics), Failure> {
        let frame = self.frame(way, Look { forward, up }, Filling::Background)?;
        Ok((frame.seconds, frame.statistics))
    }

    /// Renders one.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub(super) fn frame(
        &self,
        way: Way,
        look: Look,
        filling: Filling<'_>,
    ) -> Result<Frame, Failure> {
        let eyes = Self::observers(way, look)?;
        let (cave, options) = (&self.cave, &self.options);
        let quiet = |_, _| {};
        Ok(with_scene!(&self.scene, |scene| render::cave_filled(
            &scene, cave, &eyes, options, filling, &quiet
        ))?)
    }

    /// The two eyes, with what follows their gaze.
    ///
    /// # Errors
    /// A line of sight that is none.
    pub(super) fn observers(way: Way, look: Look) -> Result<[Observer; 2], Failure> {
        let Look { forward, up } = look;
        let sight = LineOfSight::new(Vec3::ZERO, forward, up).map_err(Failure::from_error)?;
        let mut lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        lod.bounces = way != Way::Cut;
        lod.faces = way == Way::Lod;
        let viewer = Viewer::default();
        Ok(Eye::STEREO.map(|eye| match way {
            Way::Plain => Observer::new(eye, viewer.eye(eye)),
            Way::Foveated => Observer::foveated(eye, viewer.eye(eye), sight, 0.0),
            Way::Lod | Way::Cut | Way::Levels => Observer {
                lod: Some(lod),
                ..Observer::new(eye, viewer.eye(eye))
            },
        }))
    }
}
