//! The camera of a dome master and what it sees, from arguments.

use super::arguments::{ConfigChoice, MappingChoice};
use crate::bake::BakedScene;
use crate::cli::arguments::{number, number_within};
use crate::cli::output::failure::Failure;
use crate::cli::output::progress::Progress;
use crate::dome::{Named, NearField, effective_viewpoint};
use crate::render::{self, DomePicture, Options};
use crate::scene::Scene;
use crate::scene::builtin::grid;
use crate::scene::camera::DomeCamera;
use crate::with_scene;
use clap::Args;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use shisen_core::shape::Spheroid;
use std::str::FromStr;

/// Which mirror, and how it is looked at.
#[derive(Debug, Args)]
pub(super) struct MirrorChoice {
    /// A mirror of the paper's Table 1, or the best there is [default: paper-1]
    #[arg(long, value_name = "NAME", value_enum)]
    config: Option<ConfigChoice>,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    pub(super) mapping: MappingChoice,
    /// Equatorial radius of the mirror: metres, from 1e-9 to 1e6 [default: 0.001]
    #[arg(
        long,
        value_name = "METRES",
        allow_hyphen_values = true,
        value_parser = number::<f32>
    )]
    mirror_size: Option<f32>,
    /// Which point of the mirror's axis is where the picture is taken from:
    /// screen (the screen's centre), best (which keeps parallax least), or a
    /// distance from the screen's centre towards the zenith, in equatorial radii
    /// [default: screen]
    #[arg(long, value_name = "screen|best|RADII", allow_hyphen_values = true)]
    viewpoint: Option<Viewpoint>,
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

/// Of a mirror unless somebody asks: metres.
const RADIUS: f32 = 1.0e-3;

impl MirrorChoice {
    /// The first of those that only a mirror has which was given, beside a grid, whose
    /// distance is in the mirror's radii.
    fn given(&self, grid: Option<f64>) -> Option<&'static str> {
        let config = self.config.map(|_| "--config");
        let size = self.mirror_size.filter(|_| grid.is_none());
        let size = size.map(|_| "--mirror-size");
        config.or(size).or(self.viewpoint.map(|_| "--viewpoint"))
    }

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
        let radius = self.mirror_size.unwrap_or(RADIUS);
        let viewpoint = self.viewpoint.unwrap_or(Viewpoint::Screen);
        if self.nearest.is_some() && viewpoint != Viewpoint::Best {
            return Err(Failure::usage(
                "--nearest is for --viewpoint best: no other depends on the surroundings",
            ));
        }
        let Some(mapping) = self.mapping.0.core() else {
            if let Some(argument) = self.given(grid) {
                return Err(Failure::usage(&format!(
                    "{argument} is for --mapping mirror or exact: by true there is no mirror"
                )));
            }
            return Ok(Optics {
                projection: DomeProjection::Equidistant { field_of_view },
                config: None,
                radius,
                viewpoint: 0.0,
            });
        };
        let ConfigChoice(named) = self.config.unwrap_or(ConfigChoice(Named::Paper1));
        let double = named.mirror();
        if let Some(distance) = grid {
            // Its centre is the screen's.
            let near = NearField::new(double, self.mapping.0);
            near.check(distance)
                .map_err(|error| Failure::usage(&error.to_string()))?;
        }
        let viewpoint = match viewpoint {
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
            config: Some(named),
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
