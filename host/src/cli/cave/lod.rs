//! What the level of detail of `shisen cave` did.

use super::report::{Captured, Field, Fill, Lod};
use crate::bake::BakedScene;
use crate::cave::{Cave, Screen};
use crate::cli::arguments::filling::Wanted;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::lod::LodArguments;
use crate::cli::output::failure::Failure;
use crate::picture::Picture;
use crate::render::{self, Frame, Observer, Options};
use crate::show::lod;
use crate::show::lod::{Coverage, OutsideDifference};
use crate::show::overview::net;
use shisen_core::frame::{LevelOfDetail, Spectrum};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};

/// What it did, `full` being the same frame without.
///
/// # Errors
/// A wall that cannot be seen.
pub(super) fn report(
    arguments: &LodArguments,
    baked: &BakedScene,
    cave: &Cave,
    observers: &[Observer],
    depth: u8,
    full: &Frame,
    filled: Filled<'_>,
) -> Result<Lod, Failure> {
    let mut field = Vec::new();
    let mut error = OutsideDifference::default();
    let mut pictures = filled.frame.pictures.iter().zip(&full.pictures);
    for screen in cave.screens() {
        for observer in observers {
            let both = pictures.next();
            let Some(lod) = &observer.lod else { continue };
            let view = render::view(screen, observer)?;
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
        mode: arguments.name(),
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
    /// The level of each pixel, or how far apart its samples are.
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
            let view = render::view(screen, observer)?;
            let made = |picture: Result<Picture, _>| {
                picture
                    .map(|picture| (screen, picture))
                    .map_err(Failure::from_error)
            };
            levels.push(made(match observer.acuity {
                Some(_) => lod::sampling(&renderer, &view),
                None => lod::levels(&view, lod),
            })?);
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
