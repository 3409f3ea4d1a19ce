//! The camera of a dome master.

use crate::bake::AnyScene;
use crate::cli::output::progress::Progress;
use crate::cli::prelude::*;
use crate::dome::{Mapping, Named, NearField, effective_viewpoint};
use crate::render::{self, DomePicture, Options};
use crate::scene::Scene;
use crate::scene::builtin::grid;
use crate::scene::camera::DomeCamera;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use shisen_core::shape::Spheroid;

#[derive(Debug, Args)]
pub(super) struct MirrorChoice {
    /// Mirror of the paper's Table 1, or the best one [default: paper-1]
    #[arg(long, value_name = "NAME", value_enum)]
    config: Option<Named>,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    pub(super) mapping: Mapping,
    /// Equatorial radius of the mirror, from 1e-9 to 1e6 metres [default: 0.001]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true, value_parser = number::<f32>)]
    mirror_size: Option<f32>,
    /// Point of the mirror's axis from which the picture is taken: screen (the screen's centre),
    /// best (for the least parallax), or a distance from the screen's centre towards the zenith in
    /// equatorial radii [default: screen]
    #[arg(long, value_name = "screen|best|RADII", allow_hyphen_values = true,
          value_parser = viewpoint)]
    viewpoint: Option<Viewpoint>,
    /// Nearest surroundings for --viewpoint best, equatorial radii [default: the grid's distance,
    /// else 100]
    #[arg(long, value_name = "RADII", value_parser = distance)]
    nearest: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Viewpoint {
    Best,
    /// Equatorial radii from the screen's centre towards the zenith.
    At(f64),
}

fn viewpoint(text: &str) -> Result<Viewpoint, String> {
    let radii = within(-100.0..=100.0, "screen, best, or radii from -100 to 100");
    match text.trim() {
        "screen" => Ok(Viewpoint::At(0.0)),
        "best" => Ok(Viewpoint::Best),
        number => radii(number).map(Viewpoint::At),
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    pub(super) projection: DomeProjection,
    /// `None` without a mirror.
    pub(super) config: Option<Named>,
    /// Radius of the mirror, metres.
    pub(super) radius: f32,
    /// Viewpoint from the screen's centre towards the zenith, equatorial radii.
    pub(super) viewpoint: f64,
}

/// Default radius of a mirror, metres.
const RADIUS: f32 = 1.0e-3;

impl MirrorChoice {
    /// Returns the first argument that was given and makes sense only with a mirror. A grid's
    /// distance needs the mirror's size, too.
    fn given(&self, grid: Option<f64>) -> Option<&'static str> {
        let config = self.config.map(|_| "--config");
        let size = self.mirror_size.filter(|_| grid.is_none());
        let size = size.map(|_| "--mirror-size");
        config.or(size).or(self.viewpoint.map(|_| "--viewpoint"))
    }

    /// Returns the projection. Without a mirror it has `field_of_view`, radians. `grid` is the
    /// distance of the grid, equatorial radii.
    pub(super) fn optics(
        &self,
        mirrored: bool,
        field_of_view: f32,
        grid: Option<f64>,
    ) -> Result<Optics, Failure> {
        let radius = self.mirror_size.unwrap_or(RADIUS);
        let viewpoint = self.viewpoint.unwrap_or(Viewpoint::At(0.0));
        if self.nearest.is_some() && viewpoint != Viewpoint::Best {
            return Err(misuse!(
                "--nearest is for --viewpoint best: no other depends on the surroundings"
            ));
        }
        let Some(mapping) = self.mapping.core() else {
            if let Some(argument) = self.given(grid) {
                return Err(misuse!(
                    "{argument} is for --mapping mirror or exact: with true there is no mirror"
                ));
            }
            return Ok(Optics {
                projection: DomeProjection::Equidistant { field_of_view },
                config: None,
                radius,
                viewpoint: 0.0,
            });
        };
        let named = self.config.unwrap_or(Named::Paper1);
        let double = named.mirror();
        let near = NearField::new(double, self.mapping);
        if let Some(distance) = grid {
            // The grid's centre is the screen's.
            near.check(distance).or_misuse()?;
        }
        let viewpoint = match viewpoint {
            Viewpoint::At(offset) => offset,
            Viewpoint::Best => {
                let nearest = self.nearest.or(grid).unwrap_or(DISTANCE);
                effective_viewpoint(&near, nearest).or_misuse()?.offset
            }
        };
        let mirror = double.single().or_misuse()?;
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

/// Default distance of the grid, equatorial radii.
pub(super) const DISTANCE: f64 = 100.0;

impl Optics {
    /// Returns the built-in grid, at a distance in mirror radii from the screen's centre.
    pub(super) fn grid(&self, distance: f64, camera: &DomeCamera) -> Result<Scene, Failure> {
        let radius = distance * f64::from(self.radius);
        let (least, most) = Spheroid::RADII;
        if !(f64::from(least)..=f64::from(most)).contains(&radius) {
            return Err(misuse!(
                "the grid is {distance} mirror radii of {} m away, {radius:e} m: give --distance \
                 and --mirror-size whose product is from {least:e} to {most:e}",
                self.radius
            ));
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

/// `--distance`, mirror radii.
pub(super) fn distance(text: &str) -> Result<f64, String> {
    let expected = "mirror radii from 0.001 to 1e12, such as 100";
    within(1.0e-3..=1.0e12, expected)(text)
}

pub(super) fn view(
    projection: DomeProjection,
    camera: &DomeCamera,
    size: u32,
) -> Result<View, Failure> {
    View::dome(projection, camera.pose(), size).or_misuse()
}

pub(super) fn trace(
    scene: AnyScene<'_>,
    view: &View,
    options: &Options,
    quiet: bool,
) -> Result<DomePicture, Failure> {
    let progress = Progress::new(quiet);
    let show = |done, total| progress.show(done, total);
    let picture = render::dome(scene, view, None, options, &show);
    progress.finish();
    Ok(picture?)
}
