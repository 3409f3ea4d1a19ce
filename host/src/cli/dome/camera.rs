//! The camera of a dome master and what it sees, from arguments.

use super::arguments::{ConfigChoice, MappingChoice};
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use clap::Args;
use glam::DVec3;
use shisen::bake::BakedScene;
use shisen::dome::{Mapping, Named};
use shisen::render::{self, DomePicture, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::grid;
use shisen::scene::camera::DomeCamera;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use shisen_core::shape::Spheroid;
use std::str::FromStr;

/// Which mirror, and how it is looked at.
#[derive(Debug, Args)]
pub(super) struct MirrorChoice {
    /// A mirror of the paper's Table 1, or the best there is
    #[arg(long, value_name = "NAME", value_enum, default_value = "paper-1")]
    pub(super) config: ConfigChoice,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    pub(super) mapping: MappingChoice,
    /// Equatorial radius of the mirror: metres, from 1e-9 to 1e6
    #[arg(
        long,
        value_name = "METRES",
        default_value_t = 1.0e-3,
        allow_hyphen_values = true
    )]
    pub(super) mirror_size: f32,
    /// Which point of the mirror's axis is where the picture is taken from:
    /// screen (the screen's centre), or a distance from there towards the
    /// zenith, in equatorial radii
    #[arg(
        long,
        value_name = "screen|RADII",
        default_value = "screen",
        allow_hyphen_values = true
    )]
    pub(super) viewpoint: Viewpoint,
}

/// `--viewpoint`: equatorial radii from the screen's centre towards the zenith.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Viewpoint(pub(super) f32);

impl FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "screen" => Ok(Self(0.0)),
            number => number
                .parse()
                .ok()
                .filter(|radii| (-100.0..=100.0).contains(radii))
                .map(Self)
                .ok_or_else(|| "give screen, or radii from -100 to 100".to_owned()),
        }
    }
}

impl MirrorChoice {
    /// The projection that they ask for; `field_of_view` is that without a
    /// mirror, radians.
    pub(super) fn projection(&self, mirrored: bool, field_of_view: f32) -> DomeProjection {
        match self.mapping.0.core() {
            None => DomeProjection::Equidistant { field_of_view },
            Some(mapping) => {
                let mirror = self.config.0.core();
                DomeProjection::Mirror(MirrorCamera {
                    mirror,
                    mapping,
                    radius: self.mirror_size,
                    viewpoint: mirror.screen_distance() + self.viewpoint.0,
                    mirrored,
                })
            }
        }
    }

    /// The mirror in use, by name.
    pub(super) fn config(&self) -> Option<Named> {
        (self.mapping.0 != Mapping::True).then_some(self.config.0)
    }

    /// The screen's centre of a camera: metres.
    fn screen(&self, camera: &DomeCamera) -> DVec3 {
        let offset = match self.mapping.0 {
            Mapping::True => 0.0,
            Mapping::Mirror | Mapping::Exact => f64::from(self.viewpoint.0 * self.mirror_size),
        };
        camera.position - camera.zenith.normalize_or_zero() * offset
    }

    /// The built-in grid, `distance` of the mirror's radii around the screen's
    /// centre of a camera.
    ///
    /// # Errors
    /// Of usage, where that is no sphere.
    pub(super) fn grid(&self, distance: f64, camera: &DomeCamera) -> Result<Scene, Failure> {
        let radius = distance * f64::from(self.mirror_size);
        let (least, most) = Spheroid::RADII;
        if !(f64::from(least)..=f64::from(most)).contains(&radius) {
            return Err(Failure::usage(&format!(
                "the grid is {distance} mirror radii of {} m away, {radius:e} m: give --distance \
                 and --mirror-size whose product is from {least:e} to {most:e}",
                self.mirror_size
            )));
        }
        let mut scene = grid(radius as f32);
        for object in &mut scene.objects {
            object.world_from_object.translation = self.screen(camera);
        }
        Ok(scene)
    }
}

/// `--distance`: mirror radii.
pub(super) fn distance(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|distance| (1.0e-3..=1.0e12).contains(distance))
        .ok_or_else(|| "give mirror radii from 0.001 to 1e12, such as 100".to_owned())
}

/// The rays of a picture.
///
/// # Errors
/// Of usage, where there are none such.
pub(super) fn view(
    projection: DomeProjection,
    camera: &DomeCamera,
    size: u32,
) -> Result<View, Failure> {
    View::dome(projection, camera.pose(), size).map_err(|error| Failure::usage(&error.to_string()))
}

/// Traces one.
///
/// # Errors
/// A picture that is too large, threads that cannot be started.
pub(super) fn trace(
    baked: &BakedScene,
    view: &View,
    options: &Options,
    quiet: bool,
) -> Result<DomePicture, Failure> {
    let progress = Progress::new(quiet);
    let show = |done, total| progress.show(done, total);
    let picture = match baked {
        BakedScene::Fast(baked) => render::dome(&baked.scene(), view, None, options, &show),
        BakedScene::Compact(baked) => render::dome(&baked.scene(), view, None, options, &show),
    };
    progress.finish();
    picture.map_err(Failure::from_error)
}
