use super::SpheroidMirror;
use crate::numeric::{sin_cos, sqrt};
use core::f32::consts::FRAC_PI_2;
use glam::Vec3;

/// Which point of the screen a dome master's pixel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mapping {
    /// The paper's: the picture is the screen, and θ is `r_d` but for the error
    /// that the mirror was chosen to keep small.
    #[default]
    Screen,
    /// The screen's point whose θ is the pixel's: a true dome master,
    /// reflected at the mirror all the same.
    Exact,
}

/// A line of sight after the mirror, in the axes of [`capture`](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Where the mirror is hit: equatorial radii from its centre. Error
    /// ≤ 2.5·10⁻⁷ of its distance, for axis ratios from 0.5.
    pub point: Vec3,
    /// Where the line of sight goes from there: of unit length, within
    /// 4·10⁻⁷. Error ≤ a thousandth of a pixel of a picture of 4096², for axis
    /// ratios from 0.5.
    pub direction: Vec3,
}

impl SpheroidMirror {
    /// The line of sight of a dome master's pixel, u to the right and v
    /// upwards; `None` outside the unit disc and for NaN.
    ///
    /// With [`Mapping::Exact`] the angle to the zenith is π/2·√(u² + v²),
    /// within a thousandth of a pixel of a picture of 4096².
    pub fn pixel(&self, u: f32, v: f32, mapping: Mapping) -> Option<Reflection> {
        let radius = sqrt(u * u + v * v);
        // NaN fails the comparison too.
        if !(radius <= 1.0) {
            return None;
        }
        Some(match mapping {
            Mapping::Screen => self.reflect(u * self.b1, v * self.b1),
            Mapping::Exact => self.reflect_exactly(u, v, radius),
        })
    }

    /// The line of sight through a point of the screen, x to the right and y
    /// upwards, in equatorial radii, at most b₁ from its centre
    /// ([`screen_radius`](Self::screen_radius)); `None` outside and for NaN.
    pub fn screen_point(&self, x: f32, y: f32) -> Option<Reflection> {
        (sqrt(x * x + y * y) <= self.b1).then(|| self.reflect(x, y))
    }

    /// The line of sight to (u, v) of a true dome master, `radius` from its
    /// centre. By the law of reflection its direction is known before the
    /// mirror's point is.
    fn reflect_exactly(&self, u: f32, v: f32, radius: f32) -> Reflection {
        let theta = radius * FRAC_PI_2;
        let slope = self.slope_of(theta);
        let h = sqrt(self.a * self.a + slope * slope);
        let (sin, cos) = sin_cos(theta);
        let (x, y) = if radius > 0.0 {
            (u / radius, v / radius)
        } else {
            (0.0, 0.0)
        };
        let b = slope / h;
        Reflection {
            point: Vec3::new(x * b, y * b, -self.a * (self.a / h)),
            direction: Vec3::new(x * sin, y * sin, -cos),
        }
    }

    /// The line of sight through (x, y) of the screen.
    ///
    /// It starts at the screen, not at the viewpoint, so that a far viewpoint
    /// costs no bits: (x, y, c₁) + s·(−k·x, −k·y, 1) is on the mirror at the
    /// root s of A·s² + 2·B·s + C that is not below 0. C is not above 0 and B
    /// above it, so the root is no difference. The reflected direction is the
    /// incoming one turned by twice the normal's angle, as a product of
    /// complex numbers.
    fn reflect(&self, x: f32, y: f32) -> Reflection {
        let Self { a, k, c1, b1, .. } = *self;
        let squared = x * x + y * y;
        let r = sqrt(squared);
        let steep = k * k * squared + 1.0 / (a * a);
        let half = c1 / (a * a) - k * squared;
        let inside = (b1 - r) * (b1 + r);
        let s = inside / (half + sqrt(half * half + steep * inside));
        // What is left of x and y at the mirror.
        let left = 1.0 - k * s;
        let along = (c1 + s) / (a * a);
        let across = r * left;
        let difference = (along - across) * (along + across);
        let outwards = 2.0 * along * left + k * difference;
        let forwards = difference - 2.0 * k * squared * left * along;
        let length = (along * along + across * across) * sqrt(1.0 + k * k * squared);
        Reflection {
            point: Vec3::new(x * left, y * left, -(c1 + s)),
            direction: Vec3::new(x * outwards, y * outwards, -forwards) / length,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMED: [SpheroidMirror; 5] = [
        SpheroidMirror::PAPER_PARALLEL,
        SpheroidMirror::PAPER_SPHERE,
        SpheroidMirror::PAPER_SPHEROID,
        SpheroidMirror::BEST_PARALLEL,
        SpheroidMirror::BEST,
    ];

    #[test]
    fn the_centre_is_the_zenith_and_the_rim_is_upright() {
        for mirror in NAMED {
            for mapping in [Mapping::Screen, Mapping::Exact] {
                let pixel = |u, v| mirror.pixel(u, v, mapping).unwrap();
                let zenith = pixel(0.0, 0.0);
                assert!((zenith.direction - Vec3::NEG_Z).length() < 3.0e-7);
                let pole = Vec3::NEG_Z * mirror.axis_ratio();
                assert!((zenith.point - pole).length() < 3.0e-7 * mirror.axis_ratio());
                for side in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
                    let rim = pixel(side.x, side.y);
                    assert!((rim.direction - side).length() < 1.0e-6, "{rim:?}");
                    let screen = side * mirror.screen_radius() - Vec3::Z * mirror.screen_distance();
                    assert!((rim.point - screen).length() < 1.0e-6, "{rim:?}");
                }
            }
        }
    }

    #[test]
    fn a_pixel_by_the_papers_mapping_is_a_point_of_the_screen() {
        for mirror in NAMED {
            let b1 = mirror.screen_radius();
            let pixel = mirror.pixel(0.25, -0.5, Mapping::Screen);
            assert_eq!(pixel, mirror.screen_point(0.25 * b1, -0.5 * b1));
        }
    }

    #[test]
    fn what_is_outside_the_disc_is_not_seen() {
        for mirror in NAMED {
            for (u, v) in [
                (1.0f32.next_up(), 0.0),
                (0.8, -0.7),
                (f32::NAN, 0.0),
                (0.0, f32::INFINITY),
                (f32::MAX, f32::MAX),
            ] {
                assert_eq!(mirror.pixel(u, v, Mapping::Screen), None);
                assert_eq!(mirror.pixel(u, v, Mapping::Exact), None);
                assert_eq!(mirror.screen_point(u, v), None);
            }
        }
    }

    #[test]
    fn the_smallest_pixels_are_next_to_the_zenith() {
        for mirror in NAMED {
            for tiny in [f32::from_bits(1), f32::MIN_POSITIVE, 1.0e-20] {
                for mapping in [Mapping::Screen, Mapping::Exact] {
                    let found = mirror.pixel(tiny, -tiny, mapping).unwrap();
                    assert!((found.direction - Vec3::NEG_Z).length() < 3.0e-7);
                }
            }
        }
    }
}
