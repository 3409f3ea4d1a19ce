//! Frames of the paper's scene A before its three walls, for two eyes that look
//! at one of its animals.

use super::{Bench, Cause, PictureError, Sight};
use crate::bake::Baked;
use crate::cave::{BuiltInCave, Cave, Eye, Viewer};
use crate::net;
use crate::picture::Picture;
use crate::render::{self, Filling, Frame, Observer, Options};
use crate::scene::Scene;
use crate::scene::builtin::{PaperScene, paper_scene};
use crate::simplify::PolygonLevels;
use glam::Vec3;
use serde_json::Value;
use shisen_core::frame::{LevelOfDetail, View};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};

/// The animal above the middle of the front wall: metres.
const LOOKED_AT: Vec3 = Vec3::new(0.0, 1.05, -3.0);

/// The room, and how its walls are seen.
pub(super) struct Room {
    pub(super) cave: Cave,
    pub(super) options: Options,
    line_of_sight: LineOfSight,
    /// Of each picture of a frame, in its order.
    sights: Vec<Sight>,
}

/// One way to render a frame.
#[derive(Clone, Copy)]
pub(super) struct Way<'w> {
    pub(super) depth: u8,
    pub(super) samples: u16,
    pub(super) lod: Option<Lod>,
    pub(super) filling: Filling<'w>,
}

/// What follows the gaze.
#[derive(Clone, Copy)]
pub(super) struct Lod {
    pub(super) field: VisualField,
    pub(super) bounces: bool,
    pub(super) faces: bool,
}

impl Lod {
    /// The paper's.
    pub(super) const PAPER: Self = Self {
        field: VisualField::PAPER,
        bounces: true,
        faces: true,
    };
}

impl Way<'_> {
    /// Everything in full, as `shisen cave` does unless asked.
    pub(super) const FULL: Self = Self {
        depth: 3,
        samples: 1,
        lod: None,
        filling: Filling::Background,
    };

    /// The paper's method.
    pub(super) const PAPER: Self = Self {
        lod: Some(Lod::PAPER),
        ..Self::FULL
    };

    /// For reports.
    pub(super) fn settings(&self) -> Vec<(&'static str, Value)> {
        let mut settings = vec![
            ("depth", self.depth.into()),
            ("samples", self.samples.into()),
            ("lod", self.lod.is_some().into()),
        ];
        if let Some(lod) = &self.lod {
            let limits = lod.field.limits();
            let degrees = |angle: f32| Value::from(f64::from(angle.to_degrees().round()));
            settings.extend([
                ("bounces_follow", lod.bounces.into()),
                ("faces_follow", lod.faces.into()),
                ("central_degrees", degrees(limits.central)),
                ("up_degrees", degrees(limits.up)),
                ("side_degrees", degrees(limits.right)),
            ]);
        }
        if let Filling::Capture(capture) = &self.filling {
            settings.push(("capture_size", capture.size.into()));
        }
        settings
    }
}

impl Room {
    /// With walls of so many pixels a side.
    pub(super) fn new(bench: &Bench<'_>, size: u32) -> Result<Self, Cause> {
        let cave = Cave::built_in(BuiltInCave::ThreeWall, [size; 2])?;
        let line_of_sight = LineOfSight::new(Vec3::ZERO, LOOKED_AT, Vec3::Y)?;
        let mut room = Self {
            cave,
            options: bench.options(),
            line_of_sight,
            sights: Vec::new(),
        };
        let forward = line_of_sight.forward();
        let sights = room.views(None)?.into_iter();
        room.sights = sights.map(|(view, _)| Sight::new(&view, forward)).collect();
        Ok(room)
    }

    /// The two eyes.
    pub(super) fn observers(&self, lod: Option<Lod>) -> [Observer; 2] {
        let viewer = Viewer::default();
        Eye::STEREO.map(|eye| Observer {
            lod: lod.map(|lod| LevelOfDetail {
                gaze: Gaze::new(self.line_of_sight, lod.field),
                bounces: lod.bounces,
                faces: lod.faces,
            }),
            ..Observer::new(eye, viewer.eye(eye))
        })
    }

    /// Each picture of a frame, in its order: its rays, and who sees it.
    pub(super) fn views(&self, lod: Option<Lod>) -> Result<Vec<(View, Observer)>, Cause> {
        let mut views = Vec::new();
        for screen in self.cave.screens() {
            for observer in self.observers(lod) {
                views.push((render::view(screen, &observer)?, observer));
            }
        }
        Ok(views)
    }

    /// Renders one.
    pub(super) fn frame(&self, baked: &Baked, way: &Way<'_>) -> Result<Frame, Cause> {
        let mut options = self.options;
        options.settings.depth = way.depth;
        options.settings.samples = way.samples;
        let eyes = self.observers(way.lod);
        let (scene, quiet) = (baked.scene(), |_, _| {});
        let frame = render::cave_filled(&scene, &self.cave, &eyes, &options, way.filling, &quiet)?;
        Ok(frame)
    }

    /// How far a frame is off another.
    pub(super) fn error<'p>(
        &self,
        found: impl Iterator<Item = &'p Picture>,
        truth: &'p Frame,
    ) -> PictureError {
        let truth = truth.pictures.iter().map(|one| &one.picture);
        let pairs = self.sights.iter().zip(found.zip(truth));
        let pairs: Vec<_> = pairs
            .map(|(sight, (found, truth))| (sight, found, truth))
            .collect();
        PictureError::new(&pairs)
    }

    /// What the left eye sees of something, unfolded; pictures in the order of a
    /// frame's.
    pub(super) fn unfold(&self, pictures: &[Picture]) -> Result<Picture, Cause> {
        let of_left = pictures.iter().step_by(Eye::STEREO.len());
        let screens: Vec<_> = self.cave.screens().zip(of_left).collect();
        Ok(net::unfold(&screens)?)
    }

    /// Pixels a degree at the middle of a wall.
    pub(super) fn pixels_per_degree(&self) -> f32 {
        let of = self.sights.iter().map(Sight::pixels_per_degree);
        of.fold(f32::INFINITY, f32::min)
    }
}

/// All pictures of a frame.
pub(super) fn pictures(frame: &Frame) -> impl Iterator<Item = &Picture> {
    frame.pictures.iter().map(|one| &one.picture)
}

/// Scene A with the bench's mesh.
pub(super) fn scene(bench: &Bench<'_>) -> Result<Scene, Cause> {
    Ok(paper_scene(PaperScene::A, bench.mesh.clone())?)
}

/// Scene A with the polygon levels that `shisen cave` gives it.
pub(super) fn baked(bench: &Bench<'_>) -> Result<Baked, Cause> {
    with_faces(&scene(bench)?, PolygonLevels::FEWEST_FACES, u32::MAX, RUNGS)
}

/// Polygon levels unless asked for.
pub(super) const RUNGS: u32 = crate::bake::Layout::Fast.polygon_levels();

/// With faces from `min` to `max`, or as many as there are, in so many levels.
pub(super) fn with_faces(scene: &Scene, min: u32, max: u32, rungs: u32) -> Result<Baked, Cause> {
    let levels = PolygonLevels::new(min..=max, rungs)?;
    Ok(Baked::with_levels(scene, &levels)?)
}
