//! The camera of a dome master and what it sees, from arguments.

use super::arguments::{ConfigChoice, MappingChoice};
use crate::cli::arguments::number_within;
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use clap::Args;
use shisen::bake::BakedScene;
use shisen::dome::{Named, NearField, effective_viewpoint};
use shisen::render::{self, DomePicture, Options};
use shisen::scene::Scene;
use shisen::scene::builtin::grid;
use shisen::scene::camera::DomeCamera;
use shisen::with_scene;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use shisen_core::shape::Spheroid;
use std::str::FromStr;

/// Which mirror, and how it is looked at.
#[derive(Debug, Args)]
pub(super) struct MirrorChoice {
    /// A mirror of the paper's Table 1, or the best there is
    #[arg(long, value_name = "NAME", value_enum, default_value = "paper-1")]
    config: ConfigChoice,
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
    mirror_size: f32,
    /// Which point of the mirror's axis is where the picture is taken from:
    /// screen (the screen's centre), best (which keeps parallax least), or a
    /// distance from the screen's centre towards the zenith, in equatorial radii
    #[arg(
        long,
        value_name = "screen|best|RADII",
        default_value = "screen",
        allow_hyphen_values = true
    )]
    viewpoint: Viewpoint,
    /// Nearest surroundings for --viewpoint best: equatorial radii [default: the
    /// grid's distance, else 100]
    #[arg(long, value_name = "RADII", allow_hyphen_values = true, value_parser = distance)]
    nearest: Option<f64>,
}

/// `--viewpoint`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Viewpoint {
    Screen,
    Best,
    /// Equatorial radii from the screen's centre towards the zenith.
    At(f64),
}

impl FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "screen" => Ok(Self::Screen),
            "best" => Ok(Self::Best),
            number => number
                .parse()
                .ok()
                .filter(|radii| (-100.0..=100.0).contains(radii))
                .map(Self::At)
                .ok_or_else(|| "give screen, best, or radii from -100 to 100".to_owned()),
        }
    }
}

/// A mirror with its viewpoint, or none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    pub(super) projection: DomeProjection,
    /// The mirror's name; `None` without one.
    pub(super) config: Option<Named>,
    /// Of the mirror: metres.
    pub(super) radius: f32,
    /// From the screen's centre towards the zenith, equatorial radii.
    pub(super) viewpoint: f64,
}

impl MirrorChoice {
    /// What they ask for; `field_of_view` is that without a mirror, radians, and
    /// `grid` the distance of the grid, equatorial radii.
    ///
    /// # Errors
    /// Of usage, where there is no such mirror, or no best viewpoint.
    pub(super) fn optics(
        &self,
        mirrored: bool,
        field_of_view: f32,
        grid: Option<f64>,
    ) -> Result<Optics, Failure> {
        let radius = self.mirror_size;
        let Some(mapping) = self.mapping.0.core() else {
            return Ok(Optics {
                projection: DomeProjection::Equidistant { field_of_view },
                config: None,
                radius,
                viewpoint: 0.0,
            });
        };
        let double = self.config.0.mirror();
        if let Some(distance) = grid {
            // Its centre is the screen's.
            let near = NearField::new(double, self.mapping.0);
            near.check(distance)
                .map_err(|error| Failure::usage(&error.to_string()))?;
        }
        let viewpoint = match self.viewpoint {
            Viewpoint::Screen => 0.0,
            Viewpoint::At(offset) => offset,
            Viewpoint::Best => {
                let nearest = self.nearest.or(grid).unwrap_or(DISTANCE);
                let near = NearField::new(double, self.mapping.0);
                effective_viewpoint(&near, nearest)
                    .map_err(|error| Failure::usage(&error.to_string()))?
                    .offset
            }
        };
        let mirror = double
            .single()
            .map_err(|error| Failure::usage(&error.to_string()))?;
        Ok(Optics {
            projection: DomeProjection::Mirror(MirrorCamera {
                mirror,
                mapping,
                radius,
                viewpoint: mirror.screen_distance() + viewpoint as f32,
                mirrored,
            }),
            config: Some(self.config.0),
            radius,
            viewpoint,
        })
    }
}

/// How far away the grid is unless somebody asks: equatorial radii.
pub(super) const DISTANCE: f64 = 100.0;

impl Optics {
    /// The built-in grid, `distance` of the mirror's radii around the screen's
    /// centre of a camera.
    ///
    /// # Errors
    /// Of usage, where that is no sphere.
    pub(super) fn grid(&self, distance: f64, camera: &DomeCamera) -> Result<Scene, Failure> {
        let radius = distance * f64::from(self.radius);
        let (least, most) = Spheroid::RADII;
        if !(f64::from(least)..=f64::from(most)).contains(&radius) {
            return Err(Failure::usage(&format!(
                "the grid is {distance} mirror radii of {} m away, {radius:e} m: give --distance \
                 and --mirror-size whose product is from {least:e} to {most:e}",
                self.radius
            )));
        }
        let mut scene = grid(radius as f32);
        let zenith = camera.zenith.normalize_or_zero();
        let screen = camera.position - zenith * (self.viewpoint * f64::from(self.radius));
        for object in &mut scene.objects {
            object.world_from_object.translation = screen;
        }
        Ok(scene)
    }
}

/// `--distance`: mirror radii.
pub(super) fn distance(text: &str) -> Result<f64, String> {
    number_within(text, 1.0e-3, 1.0e12)
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
    let picture = with_scene!(baked, |scene| render::dome(
        &scene, view, None, options, &show
    ));
    progress.finish();
    Ok(picture?)
}
