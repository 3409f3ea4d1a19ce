use super::SpheroidMirror;
use crate::numeric::{sines_and_cosines, sqrt};
use crate::simd::{Lanes, Portable};
use core::f32::consts::FRAC_PI_2;
use glam::Vec3;

/// Which point of the screen a dome master's pixel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mapping {
    /// The paper's: the picture is the screen, and θ is `r_d` but for a small error.
    #[default]
    Screen,
    /// The screen's point whose θ is the pixel's: a true dome master, by the mirror all the same.
    Exact,
}

/// A line of sight after the mirror, in the axes of [`capture`](super).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Where the mirror is hit: equatorial radii from its centre. Error
    /// ≤ 3·10⁻⁷ of its distance, for axis ratios from 0.5.
    pub point: Vec3,
    /// Where the line of sight goes from there: of unit length, within 4·10⁻⁷. Error ≤ a thousandth
    /// of a pixel of a picture of 4096², for axis ratios from 0.5.
    pub direction: Vec3,
}

impl SpheroidMirror {
    /// Returns the line of sight of a dome master's pixel, u to the right and v
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
        let pixel = [[u], [v], [radius]];
        let start = self.exact_start();
        Some(Reflection::of_lane(
            self.pixels(Portable, pixel, mapping, start),
        ))
    }

    /// [`pixel`](Self::pixel) in every lane: (u, v), √(u² + v²).
    #[inline(always)]
    pub(crate) fn pixels<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        pixel: [L::F; 3],
        mapping: Mapping,
        start: [f32; 3],
    ) -> Reflections<L::F> {
        match mapping {
            Mapping::Screen => {
                let [u, v, _] = pixel;
                let b1 = l.splat(self.b1);
                self.reflections(l, l.mul(u, b1), l.mul(v, b1))
            }
            Mapping::Exact => self.exact_reflections(l, pixel, start),
        }
    }

    /// Returns the lines of sight to (u, v) of a true dome master, `radius` from its centre.
    #[inline(always)]
    fn exact_reflections<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        [u, v, radius]: [L::F; 3],
        start: [f32; 3],
    ) -> Reflections<L::F> {
        let a = l.splat(self.a);
        let theta = l.mul(radius, l.splat(FRAC_PI_2));
        let (sin, cos) = sines_and_cosines(l, theta);
        let slope = self.slopes(l, theta, (sin, cos), start);
        let h = l.sqrt(l.add(l.splat(self.a * self.a), l.mul(slope, slope)));
        let centre = l.le(radius, l.splat(0.0));
        let x = l.select(centre, l.splat(0.0), l.div(u, radius));
        let y = l.select(centre, l.splat(0.0), l.div(v, radius));
        let b = l.div(slope, h);
        Reflections {
            point: [
                l.mul(x, b),
                l.mul(y, b),
                l.mul(l.splat(-self.a), l.div(a, h)),
            ],
            direction: [l.mul(x, sin), l.mul(y, sin), l.mul(l.splat(-1.0), cos)],
        }
    }

    /// Returns the lines of sight through (x, y) of the screen, which start there.
    #[inline(always)]
    fn reflections<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        x: L::F,
        y: L::F,
    ) -> Reflections<L::F> {
        let Self { a, k, c1, b1, .. } = *self;
        let (one, two) = (l.splat(1.0), l.splat(2.0));
        let (k1, kk, c1, b1) = (l.splat(k), l.splat(k * k), l.splat(c1), l.splat(b1));
        let flat = l.splat(1.0 / (a * a));
        let squared = l.add(l.mul(x, x), l.mul(y, y));
        let r = l.sqrt(squared);
        let steep = l.add(l.mul(kk, squared), flat);
        let half = l.sub(l.mul(c1, flat), l.mul(k1, squared));
        let inside = l.mul(l.sub(b1, r), l.add(b1, r));
        let root = l.sqrt(l.add(l.mul(half, half), l.mul(steep, inside)));
        let s = l.div(inside, l.add(half, root));
        // What is left of x and y at the mirror.
        let left = l.sub(one, l.mul(k1, s));
        let height = l.add(c1, s);
        let along = l.mul(height, flat);
        let across = l.mul(r, left);
        let difference = l.mul(l.sub(along, across), l.add(along, across));
        let outwards = l.mul(l.mul(two, along), left);
        let outwards = l.add(outwards, l.mul(k1, difference));
        let turned = l.mul(l.mul(l.mul(l.mul(two, k1), squared), left), along);
        let backwards = l.sub(turned, difference);
        let length = l.add(l.mul(along, along), l.mul(across, across));
        let length = l.mul(length, l.sqrt(l.add(one, l.mul(kk, squared))));
        let outwards = l.div(outwards, length);
        Reflections {
            point: [l.mul(x, left), l.mul(y, left), l.mul(l.splat(-1.0), height)],
            direction: [
                l.mul(x, outwards),
                l.mul(y, outwards),
                l.div(backwards, length),
            ],
        }
    }
}

/// [`Reflection`]s, a lane each.
#[derive(Clone, Copy)]
pub(crate) struct Reflections<F> {
    pub(crate) point: [F; 3],
    pub(crate) direction: [F; 3],
}

impl Reflection {
    fn of_lane(lanes: Reflections<[f32; 1]>) -> Self {
        let vector = |[[x], [y], [z]]: [[f32; 1]; 3]| Vec3::new(x, y, z);
        Self {
            point: vector(lanes.point),
            direction: vector(lanes.direction),
        }
    }
}
