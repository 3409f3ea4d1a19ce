//! The level of detail that `shisen cave` is asked for, and what it did.

use super::super::arguments::LevelArguments;
use super::super::failure::Failure;
use super::super::filling::Wanted;
use super::super::levels::Level;
use super::super::warn;
use super::report::{Captured, Field, Fill, Lod};
use clap::{Args, ValueEnum};
use glam::DVec3;
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, Eye, Screen};
use shisen::lod::{Coverage, OutsideError};
use shisen::look::Point;
use shisen::picture::Picture;
use shisen::render::{self, Frame, Observer, Options};
use shisen::simplify::PolygonLevels;
use shisen::{lod, net};
use shisen_core::frame::{LevelOfDetail, Spectrum};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField, VisualFieldLimits};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};

/// How detail follows the gaze.
#[derive(Debug, Args)]
pub(super) struct LodArguments {
    /// What follows the gaze: detail falls with the distance from the line of
    /// sight, and nothing outside the visual field is traced. Polygon levels
    /// are those that the scene was baked with, or else as --faces and --levels
    /// say [default: off, or paper with a --fill that is not the background]
    #[arg(long, value_enum, default_value = "off", hide_default_value = true,
          default_value_ifs = [("fill", "capture", "paper"), ("fill", "previous", "paper")])]
    lod: Choice,
    #[command(flatten)]
    levels: LevelArguments,
    /// What is up for the gaze that --lod follows [default: as --look and
    /// --head-report say]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<Point>,
    /// A point that both eyes look at, metres, in the room: with --lod each
    /// then has a line of sight of its own [default: one for both, along
    /// --look]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    fixate: Option<Point>,
}

/// `--lod`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Choice {
    /// Nothing: everything is traced in full
    Off,
    /// The paper's levels, with the border of the field as it prints it
    Paper,
    /// The paper's levels, with the border of the field as the half-ellipses
    /// that it describes
    PaperEllipse,
}

impl Choice {
    /// As it is written on a command line.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Paper => "paper",
            Self::PaperEllipse => "paper-ellipse",
        }
    }
}

impl LodArguments {
    /// The polygon levels to bake in the layout for hosts, where any are asked
    /// for.
    ///
    /// # Errors
    /// Of usage: levels without a gaze that they could follow.
    pub(super) fn polygon_levels(&self) -> Result<Option<PolygonLevels>, Failure> {
        match self.levels.given() {
            _ if self.is_on() => self.levels.polygon_levels(Layout::Fast).map(Some),
            Some(argument) => Err(Failure::usage(&format!(
                "{argument} is for --lod paper or paper-ellipse: with --lod off all rays see \
                 every face"
            ))),
            None => Ok(None),
        }
    }

    /// Whether a scene that was baked before, in the file `name`, can be
    /// rendered as asked. Warns where nothing in it has polygon levels.
    ///
    /// # Errors
    /// Of usage: levels for a scene that has its own.
    pub(super) fn accept(&self, baked: &BakedScene, name: &str) -> Result<(), Failure> {
        if let Some(argument) = self.levels.given() {
            return Err(Failure::usage(&format!(
                "{argument} is for scenes that are not baked yet, and {name} is: its polygon \
                 levels are chosen when baking, with `shisen bake --faces MIN..MAX --levels N`"
            )));
        }
        let levels = Level::of(baked);
        let has_ladder = Level::by_mesh(&levels).any(|levels| levels.len() > 1);
        if self.is_on() && !has_ladder && !levels.is_empty() {
            warn(&format!(
                "all rays see the same polygons: {name} was baked without polygon levels. Bake it \
                 again with `shisen bake --levels N`"
            ));
        }
        Ok(())
    }

    /// The eyes, with what follows their gaze. Without `--up` and `--fixate`
    /// the viewer looks along `forward` and holds `up` up. The field is wider
    /// by `widen`, radians; from π on there is no end to it, and nothing
    /// follows the gaze.
    ///
    /// # Errors
    /// Of usage: a line of sight that is none, or a gaze that nothing follows.
    pub(super) fn observers(
        &self,
        eyes: &[(Eye, DVec3)],
        (forward, up): (DVec3, DVec3),
        widen: f32,
    ) -> Result<Vec<Observer>, Failure> {
        let given = self.fixate.map(|_| "--fixate");
        if let (Some(argument), false) = (given.or(self.up.map(|_| "--up")), self.is_on()) {
            return Err(Failure::usage(&format!(
                "{argument} is for --lod paper or paper-ellipse: with --lod off nothing follows \
                 the gaze"
            )));
        }
        let up = self.up.map_or(up, |up| up.0);
        let boundary = match self.lod {
            Choice::Off => None,
            Choice::Paper => Some(Boundary::Printed),
            Choice::PaperEllipse => Some(Boundary::Ellipse),
        };
        let field = widened(widen);
        eyes.iter()
            .map(|&(eye, place)| {
                let forward = self.fixate.map_or(forward, |point| point.0 - place);
                let line = LineOfSight::new(place.as_vec3(), forward.as_vec3(), up.as_vec3())
                    .map_err(|error| Failure::usage(&error.to_string()))?;
                let lod = boundary.zip(field).map(|(boundary, field)| {
                    LevelOfDetail::new(Gaze::new(line, field.with_boundary(boundary)))
                });
                Ok(Observer { eye, place, lod })
            })
            .collect()
    }

    /// Whether anything follows the gaze.
    pub(super) fn is_on(&self) -> bool {
        self.lod != Choice::Off
    }

    /// What it did, `full` being the same frame without.
    ///
    /// # Errors
    /// A wall that cannot be seen.
    pub(super) fn report(
        &self,
        baked: &BakedScene,
        cave: &Cave,
        observers: &[Observer],
        depth: u8,
        full: &Frame,
        filled: Filled<'_>,
    ) -> Result<Lod, Failure> {
        let mut field = Vec::new();
        let mut error = OutsideError::default();
        let mut pictures = filled.frame.pictures.iter().zip(&full.pictures);
        for screen in cave.screens() {
            for observer in observers {
                let both = pictures.next();
                let Some(lod) = &observer.lod else { continue };
                let view = render::view(screen, observer).map_err(Failure::from_error)?;
                let coverage = Coverage::new(&view, lod, depth);
                if let Some((found, full)) = both {
                    error.add(&view, lod, &found.picture, &full.picture);
                }
                field.push(Field {
                    wall: screen.name().to_owned(),
                    eye: observer.eye.name(),
                    central: coverage.central,
                    peripheral: coverage.peripheral,
                    outside: coverage.outside,
                    mean_level: coverage.mean_level,
                    mean_bounces: coverage.mean_bounces,
                });
            }
        }
        let levels = Level::of(baked);
        let ladders = Level::by_mesh(&levels);
        Ok(Lod {
            mode: self.lod.name(),
            faces: ladders
                .map(|levels| levels.iter().map(|level| level.faces).collect())
                .collect(),
            field,
            fill: Fill {
                mode: filled.wanted.name(),
                outside_pixels: error.pixels(),
                outside_rms: error.root_mean_square(),
                outside_psnr: error.psnr(),
                capture: filled.frame.capture.as_ref().map(|capture| Captured {
                    size: capture.hemispheres[0].width,
                    seconds: capture.seconds,
                    rays: capture.statistics.into(),
                    steps: capture.statistics.steps,
                    images: filled.images,
                }),
            },
            full_seconds: full.seconds,
            full_steps: full.statistics.steps,
            full_rays: full.statistics.into(),
        })
    }
}

/// The paper's field, wider by so much all round as directions go; none where
/// that is everything.
fn widened(by: f32) -> Option<VisualField> {
    use std::f32::consts::{FRAC_PI_2, PI};
    if by >= PI {
        return None;
    }
    let field = VisualField::PAPER;
    let limits = field.limits();
    let wide = VisualFieldLimits {
        // Levels fall from here to the limits, which have to be farther.
        central: (limits.central + by).min(1.5),
        up: (limits.up + by).min(FRAC_PI_2),
        down: (limits.down + by).min(FRAC_PI_2),
        left: (limits.left + by).min(PI),
        right: (limits.right + by).min(PI),
    };
    Some(VisualField::new(wide, field.boundary()).unwrap_or(field))
}

/// A frame in which something shows where the gaze skipped rays.
pub(super) struct Filled<'f> {
    /// What.
    pub(super) wanted: Wanted,
    /// The frame.
    pub(super) frame: &'f Frame,
    /// Files of what was captured.
    pub(super) images: Vec<String>,
}

/// What one eye's level of detail did, walls unfolded.
pub(super) struct LodPictures {
    /// The level of each pixel.
    pub(super) levels: Picture,
    /// The faces that each pixel's rays see.
    pub(super) polygons: Picture,
    /// Against full tracing.
    pub(super) difference: Picture,
}

impl LodPictures {
    /// Of `frame`, whose like without level of detail is `full`, for one eye.
    ///
    /// # Errors
    /// A picture that cannot be made.
    pub(super) fn new<const W: usize>(
        scene: &Scene<'_, W>,
        cave: &Cave,
        (observer, lod): (&Observer, &LevelOfDetail),
        options: &Options,
        (frame, full): (&Frame, &Frame),
    ) -> Result<Self, Failure>
    where
        Simd: Runs<W>,
    {
        let renderer = render::renderer(scene, observer, options, Spectrum::Rgb)
            .map_err(Failure::from_error)?;
        let (mut levels, mut polygons, mut difference) = (Vec::new(), Vec::new(), Vec::new());
        for (number, screen) in cave.screens().enumerate() {
            let view = render::view(screen, observer).map_err(Failure::from_error)?;
            let made = |picture: Result<Picture, _>| {
                picture
                    .map(|picture| (screen, picture))
                    .map_err(Failure::from_error)
            };
            levels.push(made(lod::levels(&view, lod))?);
            polygons.push(made(lod::polygons(scene, &renderer, &view))?);
            let of = |frame: &Frame| {
                let mut pictures = frame.pictures.iter();
                pictures
                    .find(|one| one.wall == number && one.eye == observer.eye)
                    .map(|one| one.picture.clone())
            };
            if let (Some(a), Some(b)) = (of(frame), of(full)) {
                difference.push(made(lod::difference(&a, &b))?);
            }
        }
        Ok(Self {
            levels: unfold(&levels)?,
            polygons: unfold(&polygons)?,
            difference: unfold(&difference)?,
        })
    }
}

fn unfold(screens: &[(Screen<'_>, Picture)]) -> Result<Picture, Failure> {
    let screens: Vec<_> = screens
        .iter()
        .map(|(screen, picture)| (*screen, picture))
        .collect();
    net::unfold(&screens).map_err(Failure::from_error)
}
