use super::Ray;
use crate::numeric::{DoubleFloat, quadratic_roots, scale_to_one, sqrt};
use glam::Vec3;

/// An ellipsoid of revolution about the Y axis, centred on the origin; a
/// sphere where both radii are equal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spheroid {
    equatorial: f32,
    polar: f32,
}

/// Where a line meets a spheroid, in the order of the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpheroidHits {
    /// The two distances in units of the ray's direction; negative behind
    /// the ray's start.
    pub t: [f32; 2],
}

impl Spheroid {
    /// Radii outside 10⁻⁶ to 10⁶ m lose bits in the products formed here.
    pub const RADII: (f32, f32) = (1.0e-6, 1.0e6);

    /// From this many radii away on, f32 cannot tell whether a line passes.
    pub(crate) const FAR: f32 = 64.0;

    /// |l|² of lines that pass by clearly, and up to how many radii away.
    pub(crate) const CLEAR: (f32, f32) = (2.0, 5.0e5);

    /// Returns a spheroid of two radii in metres, across and along its axis, or
    /// `None` where one is outside [`RADII`](Self::RADII) or NaN.
    pub fn new(equatorial_radius: f32, polar_radius: f32) -> Option<Self> {
        let usable = |radius: f32| radius >= Self::RADII.0 && radius <= Self::RADII.1;
        (usable(equatorial_radius) && usable(polar_radius)).then_some(Self {
            equatorial: equatorial_radius,
            polar: polar_radius,
        })
    }

    /// Returns a spheroid from radii that were checked when their scene was loaded.
    #[inline(always)]
    pub(crate) const fn of_checked([equatorial, polar]: [f32; 2]) -> Self {
        Self { equatorial, polar }
    }

    /// Returns both intersections of the line with the surface, `None` where it passes by.
    ///
    /// On the unit sphere the discriminant is 1 − |l|², l the line's closest point to the centre
    /// (Haines, Günther & Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection",
    /// Ray Tracing Gems 2019, chapter 7). Error of a hit point, relative to the radii, for
    /// origins R radii away: at most 8·2⁻²⁴·(1 + min(R, 64)) across the line of sight, and
    /// 8·2⁻²⁴·(1 + R) along it.
    pub fn intersect(&self, ray: &Ray) -> Option<SpheroidHits> {
        let scale = Vec3::new(self.equatorial, self.polar, self.equatorial);
        let (o, d) = (ray.origin() / scale, ray.direction() / scale);
        // A direction of any length, brought to about 1: a·c stays in range.
        let length = sqrt(d.dot(d));
        let unit = d / length;
        if !(length > 0.0 && unit.is_finite()) {
            return None;
        }
        let half = o.dot(unit);
        let closest = o - unit * half;
        let squared = closest.dot(closest);
        let distance = sqrt(o.dot(o));
        let discriminant = if Self::is_unsure(squared, distance) {
            self.clearance_from_far(ray.origin(), ray.direction())
        } else {
            1.0 - squared
        };
        // |o|² − 1 as a product: exact to rounding near the surface.
        let c = (distance - 1.0) * (distance + 1.0);
        let (t0, t1) = quadratic_roots(1.0, half, c, discriminant)?;
        Some(SpheroidHits {
            t: [t0 / length, t1 / length],
        })
    }

    /// Returns whether |l|², computed in f32 from this many radii away, may decide wrongly.
    #[inline(always)]
    fn is_unsure(squared: f32, distance: f32) -> bool {
        distance >= Self::FAR && !(squared >= Self::CLEAR.0 && distance <= Self::CLEAR.1)
    }

    /// 1 − |l|² of a line with a far origin, by o × d in twice as many digits.
    #[cold]
    #[inline(never)]
    pub(crate) fn clearance_from_far(self, origin: Vec3, direction: Vec3) -> f32 {
        let (e, p) = (self.equatorial, self.polar);
        // Scaled so that products with coordinates stay in range.
        let Some(direction) = scale_to_one(direction) else {
            return f32::NAN;
        };
        let (o, d) = (origin.to_array(), direction.to_array());
        let moment = |i: usize, j: usize| {
            let minus = DoubleFloat::product(o[j], d[i]).negate();
            DoubleFloat::product(o[i], d[j]).add(minus).rounded()
        };
        let moment = Vec3::new(
            moment(1, 2) / e / p,
            moment(2, 0) / e / e,
            moment(0, 1) / e / p,
        );
        let speed = direction / Vec3::new(e, p, e);
        let closest = moment / sqrt(speed.dot(speed));
        1.0 - closest.dot(closest)
    }

    /// Returns the unit outward normal at a point near the surface, by the gradient
    /// of (x² + z²)/e² + y²/p². Up along the axis at the centre.
    pub fn normal(&self, point: Vec3) -> Vec3 {
        let (e, p) = (self.equatorial, self.polar);
        // Times e·p, which keeps the components of one magnitude.
        let gradient = Vec3::new(point.x * (p / e), point.y * (e / p), point.z * (p / e));
        crate::numeric::normalize(gradient).unwrap_or(Vec3::Y)
    }

    /// Returns the point moved along its radius onto the surface, within 4 ulp of
    /// the radii; unchanged at the centre and where it is not finite.
    pub fn project(&self, point: Vec3) -> Vec3 {
        let scale = Vec3::new(self.equatorial, self.polar, self.equatorial);
        crate::numeric::normalize(point / scale).map_or(point, |unit| unit * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{a_ray, finite, is_unit, with_hostile_numbers};

    #[test]
    fn radii_have_a_range() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 1.0e-7, 1.0e7] {
            assert_eq!(Spheroid::new(bad, 1.0), None);
            assert_eq!(Spheroid::new(1.0, bad), None);
        }
    }

    #[test]
    fn spheroids_of_any_numbers_give_finite_hits_and_normals() {
        with_hostile_numbers(|n| {
            let (ray, point) = (a_ray(n), n.vector([0.3, 0.1, -0.2]));
            let Some(spheroid) = Spheroid::new(n.next(0.5), n.next(2.0)) else {
                return;
            };
            if let Some(hits) = ray.and_then(|ray| spheroid.intersect(&ray)) {
                finite(&hits);
                assert!(hits.t[0] <= hits.t[1], "{hits:?}");
            }
            is_unit(&spheroid.normal(point));
            assert!(spheroid.project(point).is_finite() || !point.is_finite());
        });
    }
}
