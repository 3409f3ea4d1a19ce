//! Frames of the paper's scene A before its three walls, for two eyes that look
//! at one of its animals.

use super::{Bench, Cause, PictureDifference, Ring, Sight};
use glam::{DVec3, Vec3};
use serde_json::Value;
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer, Wall};
use shisen::picture::Picture;
use shisen::render::{self, Filling, Frame, Observer, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::show::overview::net;
use shisen_core::frame::{LevelOfDetail, View};
use shisen_core::gaze::{Acuity, Gaze, LineOfSight, VisualField};

/// The place of the animal above the middle of the front wall, metres.
const LOOKED_AT: Vec3 = Vec3::new(0.0, 1.05, -3.0);

/// The room, and the two eyes in it.
pub(super) struct Room {
    pub(super) cave: Cave,
    pub(super) options: Options,
    line_of_sight: LineOfSight,
    /// The sights of the pictures of a frame, in its order.
    sights: Vec<Sight>,
    pub(super) near: CloseUp,
}

/// A screen of its own for the place that is looked at: the walls have a dozen pixels where
/// a viewer sees best.
pub(super) struct CloseUp {
    cave: Cave,
    sights: Vec<Sight>,
}

/// Pixels a side of a close-up: 500 of them and more within 1°.
pub(super) const CLOSE_UP: u32 = 200;

impl CloseUp {
    /// Returns a close-up for viewers that look along `forward`, not upwards, past the middle of
    /// the head: 5° all round the point they look at; `size` is in pixels a side.
    pub(super) fn new(forward: Vec3, eyes: &[Observer], size: u32) -> Result<Self, Cause> {
        let forward = forward.as_dvec3().normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        // A metre ahead; an eye may be a few centimetres from the middle.
        let half = 5f64.to_radians().tan() + 0.04;
        let corner = |x: f64, y: f64| forward + (right * x + up * y) * half;
        let wall = Wall::new(
            "close-up",
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(-1.0, 1.0),
            [size; 2],
        )?;
        let mut sights = Vec::new();
        for eye in eyes {
            let view = render::view(&wall, eye)?;
            sights.push(Sight::new(&view, forward.as_vec3()));
        }
        let cave = Cave::new(vec![wall])?;
        Ok(Self { cave, sights })
    }

    pub(super) fn frame(
        &self,
        baked: &Baked,
        eyes: &[Observer],
        options: &Options,
        filling: Filling<'_>,
    ) -> Result<Frame, Cause> {
        rendered(&self.cave, baked, eyes, options, filling)
    }

    pub(super) fn error(&self, found: &Frame, truth: &Frame) -> PictureDifference {
        error(&self.sights, pictures(found), truth)
    }

    /// Returns the pixels within 1° of the line of sight, of the eye with fewest.
    pub(super) fn pixels_in_the_fovea(&self) -> usize {
        let pixels = self.sights.iter().map(|sight| sight.pixels(Ring::Fovea));
        pixels.min().unwrap_or(0)
    }
}

#[derive(Clone, Copy)]
pub(super) struct Way<'w> {
    pub(super) depth: u8,
    pub(super) samples: u16,
    pub(super) lod: Option<Follow>,
    pub(super) filling: Filling<'w>,
}

#[derive(Clone, Copy)]
pub(super) struct Lod {
    pub(super) field: VisualField,
    pub(super) bounces: bool,
    pub(super) faces: bool,
}

/// What follows the gaze.
#[derive(Clone, Copy)]
pub(super) enum Follow {
    /// The paper's levels, or some of what they choose.
    Levels(Lod),
    /// The size of detail, by an acuity.
    Acuity(Acuity),
}

impl Lod {
    /// The paper's method.
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
        lod: Some(Follow::Levels(Lod::PAPER)),
        ..Self::FULL
    };

    pub(super) fn settings(&self) -> Vec<(&'static str, Value)> {
        let mut settings = vec![
            ("depth", self.depth.into()),
            ("samples", self.samples.into()),
            ("lod", self.lod.is_some().into()),
        ];
        match &self.lod {
            None => {}
            Some(Follow::Acuity(acuity)) => {
                settings.push(("acuity_slope", f64::from(acuity.slope()).into()));
            }
            Some(Follow::Levels(lod)) => {
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
        }
        if let Filling::Capture(capture) = &self.filling {
            settings.push(("capture_size", capture.size.into()));
        }
        settings
    }
}

impl Room {
    /// `size` is in pixels a side of a wall.
    pub(super) fn new(bench: &Bench<'_>, size: u32) -> Result<Self, Cause> {
        let cave = Cave::built_in(BuiltInCave::ThreeWall, [size; 2])?;
        let line_of_sight = LineOfSight::new(Vec3::ZERO, LOOKED_AT, Vec3::Y)?;
        let mut room = Self {
            cave,
            options: bench.options(),
            line_of_sight,
            sights: Vec::new(),
            near: CloseUp::new(
                line_of_sight.forward(),
                &observers(line_of_sight, None),
                CLOSE_UP,
            )?,
        };
        let forward = line_of_sight.forward();
        let sights = room.views(None)?.into_iter();
        room.sights = sights.map(|(view, _)| Sight::new(&view, forward)).collect();
        Ok(room)
    }

    pub(super) fn observers(&self, lod: Option<Follow>) -> [Observer; 2] {
        observers(self.line_of_sight, lod)
    }

    /// Returns the view and the observer of each picture of a frame, in its order.
    pub(super) fn views(&self, lod: Option<Follow>) -> Result<Vec<(View, Observer)>, Cause> {
        let mut views = Vec::new();
        for screen in self.cave.screens() {
            for observer in self.observers(lod) {
                views.push((render::view(screen, &observer)?, observer));
            }
        }
        Ok(views)
    }

    fn options(&self, way: &Way<'_>) -> Options {
        let mut options = self.options;
        options.settings.depth = way.depth;
        options.settings.samples = way.samples;
        options
    }

    pub(super) fn near_frame(&self, baked: &Baked, way: &Way<'_>) -> Result<Frame, Cause> {
        let eyes = self.observers(way.lod);
        self.near
            .frame(baked, &eyes, &self.options(way), way.filling)
    }

    pub(super) fn frame(&self, baked: &Baked, way: &Way<'_>) -> Result<Frame, Cause> {
        let eyes = self.observers(way.lod);
        rendered(&self.cave, baked, &eyes, &self.options(way), way.filling)
    }

    pub(super) fn error<'p>(
        &self,
        found: impl Iterator<Item = &'p Picture>,
        truth: &'p Frame,
    ) -> PictureDifference {
        error(&self.sights, found, truth)
    }

    /// Returns the left eye's walls unfolded; pictures are in the order of a frame's.
    pub(super) fn unfold(&self, pictures: &[Picture]) -> Result<Picture, Cause> {
        let of_left = pictures.iter().step_by(Eye::STEREO.len());
        let screens: Vec<_> = self.cave.screens().zip(of_left).collect();
        Ok(net::unfold(&screens)?)
    }

    /// Returns pixels a degree at the middle of a wall.
    pub(super) fn pixels_per_degree(&self) -> f32 {
        let each = self.sights.iter().map(Sight::pixels_per_degree);
        each.fold(f32::INFINITY, f32::min)
    }
}

fn observers(line_of_sight: LineOfSight, lod: Option<Follow>) -> [Observer; 2] {
    let viewer = Viewer::default();
    Eye::STEREO.map(|eye| {
        let plain = Observer::new(eye, viewer.eye(eye));
        match lod {
            None => plain,
            Some(Follow::Levels(lod)) => Observer {
                lod: Some(LevelOfDetail {
                    gaze: Gaze::new(line_of_sight, lod.field),
                    bounces: lod.bounces,
                    faces: lod.faces,
                }),
                ..plain
            },
            Some(Follow::Acuity(acuity)) => {
                Observer::foveated(eye, plain.place, (line_of_sight, acuity), 0.0)
            }
        }
    })
}

fn rendered(
    cave: &Cave,
    baked: &Baked,
    eyes: &[Observer],
    options: &Options,
    filling: Filling<'_>,
) -> Result<Frame, Cause> {
    let (scene, quiet) = (baked.scene().into(), |_, _| {});
    Ok(render::cave_filled(
        scene, cave, eyes, options, filling, &quiet,
    )?)
}

/// Returns the error of pictures, which are in the order of a frame's.
fn error<'p>(
    sights: &[Sight],
    found: impl Iterator<Item = &'p Picture>,
    truth: &'p Frame,
) -> PictureDifference {
    let pairs = sights.iter().zip(found.zip(pictures(truth)));
    let pairs: Vec<_> = pairs
        .map(|(sight, (found, truth))| (sight, found, truth))
        .collect();
    PictureDifference::new(&pairs)
}

pub(super) fn pictures(frame: &Frame) -> impl Iterator<Item = &Picture> {
    frame.pictures.iter().map(|one| &one.picture)
}

pub(super) fn scene(bench: &Bench<'_>) -> Result<Scene, Cause> {
    Ok(paper_scene(PaperScene::A, bench.mesh.clone())?)
}

/// Scene A with the polygon levels that `shisen cave` gives it.
pub(super) fn baked(bench: &Bench<'_>) -> Result<Baked, Cause> {
    with_faces(&scene(bench)?, PolygonLevels::FEWEST_FACES, u32::MAX, RUNGS)
}

/// The default number of polygon levels.
pub(super) const RUNGS: u32 = shisen::bake::Layout::Fast.polygon_levels();

/// Bakes a scene with levels of `min` to `max` faces, or as many as there are.
pub(super) fn with_faces(scene: &Scene, min: u32, max: u32, rungs: u32) -> Result<Baked, Cause> {
    let levels = PolygonLevels::new(min..=max, rungs)?;
    Ok(Baked::with_levels(scene, &levels)?)
}
