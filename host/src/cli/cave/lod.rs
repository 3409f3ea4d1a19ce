//! What the level of detail of `shisen cave` did.

use super::report::{Captured, Field, Fill, Lod};
use super::{Arguments, Frames};
use crate::cave::Screen;
use crate::cli::arguments::levels::Level;
use crate::cli::prelude::*;
use crate::picture::Picture;
use crate::render::{self, Frame, Observer};
use crate::show::lod;
use crate::show::lod::{Coverage, OutsideDifference};
use crate::show::overview::net;
use shisen_core::frame::Spectrum;

/// Reports what the level of detail did in a frame, by the same frame without it. `images` are the
/// files of its capture.
pub(super) fn report(
    arguments: &Arguments,
    frames: &Frames<'_>,
    observers: &[Observer],
    [frame, full]: [&Frame; 2],
    images: Vec<String>,
) -> Result<Lod, Failure> {
    let mut field = Vec::new();
    let mut error = OutsideDifference::default();
    let mut pictures = frame.pictures.iter().zip(&full.pictures);
    for screen in frames.cave.screens() {
        for observer in observers {
            let both = pictures.next();
            let Some(lod) = &observer.lod else { continue };
            let view = render::view(screen, observer)?;
            if let Some((found, full)) = both {
                error.add(&view, lod, &found.picture, &full.picture);
            }
            field.push(Field {
                wall: screen.name().to_owned(),
                eye: observer.eye.name(),
                coverage: Coverage::new(&view, lod, arguments.tracing.depth),
            });
        }
    }
    let levels = Level::of(frames.baked);
    let faces = |levels: &[Level]| levels.iter().map(|level| level.faces).collect();
    Ok(Lod {
        mode: arguments.lod.name(),
        faces: Level::by_mesh(&levels).map(faces).collect(),
        field,
        fill: Fill {
            mode: arguments.fill.fill,
            outside_pixels: error.pixels(),
            outside_rms: error.root_mean_square(),
            outside_psnr: error.psnr(),
            capture: frame.capture.as_ref().map(|capture| Captured {
                size: capture.hemispheres[0].width,
                seconds: capture.seconds,
                rays: capture.statistics.into(),
                steps: capture.statistics.steps,
                images,
            }),
        },
        full_seconds: full.seconds,
        full_steps: full.statistics.steps,
        full_rays: full.statistics.into(),
    })
}

/// Turns the level of detail off, and says so, where the eye resolves each pixel.
pub(super) fn check_acuity(frames: &Frames<'_>, observers: &mut [Observer]) -> Result<(), Failure> {
    if observers.iter().all(|one| one.foveation.is_none()) {
        return Ok(());
    }
    let mut resolves_all = true;
    with_scene!(frames.baked.scene(), |scene| {
        for observer in &*observers {
            let renderer = render::renderer(&scene, observer, frames.options, Spectrum::Rgb);
            let renderer = renderer.or_fail()?;
            for screen in frames.cave.screens() {
                resolves_all &= renderer.resolves_all(&render::view(screen, observer)?);
            }
        }
    });
    if resolves_all {
        warn(
            "the acuity is finer than a pixel everywhere: every pixel is traced in full, as with \
             --lod off; give a coarser --acuity or more pixels",
        );
        for observer in observers {
            observer.foveation = None;
        }
    }
    Ok(())
}

/// Pictures of what one eye's level of detail did, walls unfolded.
pub(in crate::cli) struct LodPictures {
    /// The level of each pixel, or how many pixels are one.
    pub(super) levels: Picture,
    /// The faces that each pixel's rays see.
    pub(super) polygons: Picture,
    /// The difference from full tracing.
    pub(super) difference: Picture,
}

impl LodPictures {
    /// Makes the pictures of the first eye, for a frame and the same frame without level of detail;
    /// `None` if it has no level of detail.
    pub(super) fn of_first(
        frames: &Frames<'_>,
        observers: &[Observer],
        [frame, full]: [&Frame; 2],
    ) -> Result<Option<Self>, Failure> {
        let first = observers.first();
        let follows = |one: &&Observer| one.lod.is_some() || one.foveation.is_some();
        let Some(observer) = first.filter(follows) else {
            return Ok(None);
        };
        let (mut levels, mut polygons, mut difference) = (Vec::new(), Vec::new(), Vec::new());
        with_scene!(frames.baked.scene(), |scene| {
            let renderer = render::renderer(&scene, observer, frames.options, Spectrum::Rgb);
            let renderer = renderer.or_fail()?;
            for (number, screen) in frames.cave.screens().enumerate() {
                let view = render::view(screen, observer)?;
                let found = match &observer.lod {
                    Some(lod) => lod::levels(&view, lod),
                    None => lod::units(&renderer, &view),
                };
                levels.push((screen, found.or_fail()?));
                let found = lod::polygons(&scene, &renderer, &view);
                polygons.push((screen, found.or_fail()?));
                let mut both = frame.pictures.iter().zip(&full.pictures);
                if let Some((a, b)) =
                    both.find(|(one, _)| one.wall == number && one.eye == observer.eye)
                {
                    let found = lod::difference(&a.picture, &b.picture);
                    difference.push((screen, found.or_fail()?));
                }
            }
        });
        Ok(Some(Self {
            levels: unfold(&levels)?,
            polygons: unfold(&polygons)?,
            difference: unfold(&difference)?,
        }))
    }
}

fn unfold(screens: &[(Screen<'_>, Picture)]) -> Result<Picture, Failure> {
    let screens = screens.iter().map(|(screen, picture)| (*screen, picture));
    net::unfold(&screens.collect::<Vec<_>>()).or_fail()
}
