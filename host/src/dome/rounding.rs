use super::mapping::Mapping;
use super::mirror::Mirror;
use super::near_field::{NearField, px_4096};
use glam::{DVec2, DVec3, Vec2, Vec3};
use schemars::JsonSchema;
use serde::Serialize;
use shisen_core::capture::{self, SpheroidMirror};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Rings of the picture along which rays are traced, and rays a ring.
const RINGS: u32 = 64;
const SPOKES: u32 = 16;

/// The direction from the world's origin to the eye: along no axis.
const AWAY: DVec3 = DVec3::new(0.6, -0.48, 0.64);

/// The errors of a mirror by its size: near field and rounding (section 5.4), in pixels of a picture
/// of 4096². The nearest surface is a sphere of radius 1 about the eye, which is at the screen's
/// centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SizeErrors {
    /// The mirror's equatorial radius.
    pub size: f64,
    /// From the world's origin to the eye.
    pub offset: f64,
    /// The largest displacement of the surface without rounding; null if the mirror reaches it.
    pub near_field_px: Option<f64>,
    /// The most that single precision adds if the mirror is traced in its own frame.
    pub rounding_px: f64,
    /// The most that it adds if camera and mirror are objects in the world's coordinates; null if
    /// no ray meets the mirror.
    pub world_px: Option<f64>,
    /// The share of rays that miss the mirror in the world, 0 to 1.
    pub world_missed: f64,
}

/// Returns the errors of a mirror of radius `size` (above 0) at `offset` (0 or more) from the
/// world's origin, both in distances to the nearest surface. `near` is the picture from the
/// screen's centre. They are measured against the same optics in double precision.
///
/// # Errors
/// A mirror that cannot be had in single precision.
pub fn size_errors(
    near: &NearField,
    size: f64,
    offset: f64,
) -> Result<SizeErrors, capture::MirrorError> {
    let (mirror, mapping) = (near.mirror, near.mapping);
    let single = mirror.single()?;
    let parameters = mirror.parameters();
    let eye = (AWAY * offset).as_vec3();
    let world = World::new(&single, eye, size as f32);
    // The origin of the mirror's frame; its pole is along −Z.
    let centre = eye + Vec3::Z * (size * parameters.c1) as f32;
    let distance = 1.0 / size;
    let is_outside = near.check(distance).is_ok();
    let mut errors = SizeErrors {
        size,
        offset,
        near_field_px: is_outside.then(|| near.largest(distance).px_4096()),
        rounding_px: 0.0,
        world_px: None,
        world_missed: 0.0,
    };
    let eye = eye.as_dvec3();
    for ring in 0..RINGS {
        let rho = (f64::from(ring) + 0.5) / f64::from(RINGS);
        for spoke in 0..SPOKES {
            let turn = (f64::from(spoke) + 0.37 * f64::from(ring)) / f64::from(SPOKES);
            let (sin, cos) = libm::sincos(4.0 * FRAC_PI_2 * turn);
            let pixel = DVec2::new(rho * cos, rho * sin).as_vec2();
            let truth = true_ray(&mirror, mapping, pixel, eye, size);
            let Some(seen) = single_ray(&single, mapping, pixel, centre, size as f32) else {
                continue;
            };
            let off = px_4096(angle_between(seen.met_from(eye), truth.met_from(eye)));
            errors.rounding_px = errors.rounding_px.max(off);
            match world.ray(mapping, &single, pixel) {
                Some(seen) => {
                    let off = px_4096(angle_between(seen.met_from(eye), truth.met_from(eye)));
                    errors.world_px = Some(errors.world_px.unwrap_or(0.0).max(off));
                }
                None => errors.world_missed += 1.0 / f64::from(RINGS * SPOKES),
            }
        }
    }
    Ok(errors)
}

#[derive(Debug, Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
}

impl Ray {
    fn of(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin: origin.as_dvec3(),
            direction: direction.as_dvec3(),
        }
    }

    /// Returns where it meets the nearest surface, from the eye: behind, for rays that start
    /// outside.
    fn met_from(self, eye: DVec3) -> DVec3 {
        let start = self.origin - eye;
        let direction = self.direction.normalize();
        let half = start.dot(direction);
        let inside = 1.0 - start.length_squared();
        start + direction * ((half * half + inside).max(0.0).sqrt() - half)
    }
}

fn true_ray(mirror: &Mirror, mapping: Mapping, pixel: Vec2, eye: DVec3, size: f64) -> Ray {
    let b1 = mirror.parameters().b1;
    let rho = pixel.as_dvec2().length().min(1.0);
    let screen = match mapping {
        Mapping::Mirror => rho,
        Mapping::Exact => mirror.r_d(rho * FRAC_PI_2) * FRAC_2_PI,
        Mapping::True => {
            let (sin, cos) = libm::sincos(rho * FRAC_PI_2);
            let outwards = pixel.as_dvec2().normalize_or_zero() * sin;
            return Ray {
                origin: eye,
                direction: outwards.extend(-cos),
            };
        }
    };
    let point = pixel.as_dvec2().normalize_or_zero() * (screen * b1);
    let (point, direction) = mirror.reflect(point);
    let from_screen = point + DVec3::Z * mirror.parameters().c1;
    Ray {
        origin: eye + from_screen * size,
        direction,
    }
}

/// Returns the core's ray, its origin put into the world in single precision.
fn single_ray(
    mirror: &SpheroidMirror,
    mapping: Mapping,
    pixel: Vec2,
    centre: Vec3,
    size: f32,
) -> Option<Ray> {
    let Some(mapping) = mapping.core() else {
        let direction = capture::fisheye_equidistant(pixel.x, pixel.y, std::f32::consts::PI)?;
        let eye = centre - Vec3::Z * (size * mirror.screen_distance());
        return Some(Ray::of(eye, direction));
    };
    let seen = mirror.pixel(pixel.x, pixel.y, mapping)?;
    Some(Ray::of(centre + seen.point * size, seen.direction))
}

/// Camera, screen and mirror as objects of a world in single precision.
struct World {
    centre: Vec3,
    /// The screen's centre, where the eye is.
    screen: Vec3,
    viewpoint: Option<Vec3>,
    half_width: f32,
    squeeze: Vec3,
}

impl World {
    fn new(mirror: &SpheroidMirror, eye: Vec3, size: f32) -> Self {
        let centre = eye + Vec3::Z * (size * mirror.screen_distance());
        let polar = size * mirror.axis_ratio();
        let equatorial = 1.0 / (size * size);
        Self {
            centre,
            screen: eye,
            viewpoint: mirror.viewpoint().map(|p| centre - Vec3::Z * (size * p)),
            half_width: size * mirror.screen_radius(),
            squeeze: Vec3::new(equatorial, equatorial, 1.0 / (polar * polar)),
        }
    }

    /// Returns the reflected ray of a pixel; `None` if it misses the mirror.
    fn ray(&self, mapping: Mapping, mirror: &SpheroidMirror, pixel: Vec2) -> Option<Ray> {
        let point = match mapping {
            Mapping::Mirror => pixel,
            Mapping::Exact => {
                let rho = pixel.length().min(1.0);
                let r_d = mirror.r_d(rho * std::f32::consts::FRAC_PI_2)?;
                pixel * (r_d * std::f32::consts::FRAC_2_PI / rho)
            }
            Mapping::True => {
                let direction =
                    capture::fisheye_equidistant(pixel.x, pixel.y, std::f32::consts::PI)?;
                return Some(Ray::of(self.screen, direction));
            }
        };
        let on_screen = self.screen + (point * self.half_width).extend(0.0);
        let (origin, sight) = match self.viewpoint {
            Some(viewpoint) => (viewpoint, (on_screen - viewpoint).normalize_or_zero()),
            None => (on_screen, Vec3::Z),
        };
        let from_centre = origin - self.centre;
        let a = (sight * self.squeeze).dot(sight);
        let b = (from_centre * self.squeeze).dot(sight);
        let c = (from_centre * self.squeeze).dot(from_centre) - 1.0;
        let discriminant = b * b - a * c;
        if !(discriminant >= 0.0 && a > 0.0) {
            return None;
        }
        let met = origin + sight * ((-b - discriminant.sqrt()) / a);
        let normal = ((met - self.centre) * self.squeeze).try_normalize()?;
        Some(Ray::of(met, sight - normal * (2.0 * sight.dot(normal))))
    }
}

fn angle_between(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}
