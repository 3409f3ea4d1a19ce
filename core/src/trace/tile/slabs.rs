use super::{EIGHT, PerRay, TileRays, of_group};
use crate::numeric::{UNIT_ROUNDOFF, largest_number, map3, max, min};
use crate::shape::{Ray, Slabs};
use crate::simd::Lanes;
use glam::Vec3;

/// The interval that the rays of a tile span.
pub(super) struct Span {
    pub(super) origin: [f32; 3],
    /// 1 where directions are negative on an axis.
    pub(super) negative: [usize; 3],
    /// For each axis the least and the greatest reciprocal, and the widening of boxes.
    pub(super) interval: [(f32, f32, f32); 3],
}

impl Span {
    /// Bounds for all rays with directions between those of `corners`; `None` where signs differ,
    /// one is next to zero, or one is no [`Ray`].
    pub(super) fn between(origin: Vec3, corners: &[Vec3; 4], extent: f32) -> Option<Self> {
        let mut largest = 0.0;
        for corner in corners {
            let ray = Ray::new(origin, *corner)?;
            largest = max(largest, largest_number(ray.direction()));
        }
        // No ray's own component is replaced by a least one: see TileSlabs.
        let least = max(largest * Slabs::LEAST_SHARE, Slabs::LEAST_COMPONENT);
        let (mut lows, mut highs) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for corner in corners {
            let extremes = lows.iter_mut().zip(&mut highs);
            for ((low, high), component) in extremes.zip(corner.to_array()) {
                (*low, *high) = (min(*low, component), max(*high, component));
            }
        }
        let mut span = Self {
            origin: origin.to_array(),
            negative: [0; 3],
            interval: [(0.0, 0.0, 0.0); 3],
        };
        for axis in 0..3 {
            let (low, high) = (lows[axis], highs[axis]);
            span.negative[axis] = if low > least {
                0
            } else if high < -least {
                1
            } else {
                return None;
            };
            span.set(axis, (1.0 / high, 1.0 / low), delta(origin, extent));
        }
        Some(span)
    }

    fn set(&mut self, axis: usize, (low, high): (f32, f32), delta: f32) {
        // Twice a ray's own slack: here the origin is subtracted first, whose
        // rounding a ray's own test does not have.
        self.interval[axis] = (low, high, 2.0 * delta * max(high, -low));
    }

    #[inline(always)]
    pub(super) fn octant(&self) -> usize {
        self.negative[0] | self.negative[1] << 1 | self.negative[2] << 2
    }
}

/// Distance that rounding may move a plane by, as in [`Slabs`].
#[inline(always)]
fn delta(origin: Vec3, extent: f32) -> f32 {
    Slabs::SLACK * UNIT_ROUNDOFF * max(extent, largest_number(origin))
}

/// [`Slabs`] of all rays of a tile, and the interval that the searching ones span.
pub(super) struct TileSlabs {
    pub(super) span: Span,
    pub(super) reciprocal: [PerRay; 3],
    pub(super) near: [PerRay; 3],
    pub(super) far: [PerRay; 3],
}

impl TileSlabs {
    /// Bounds for the rays of `groups` that still search; `None` where signs differ or are zero.
    // Longer than 80 lines: signs, intervals and planes of each ray, axis by axis.
    #[inline(always)]
    pub(super) fn new<L: Lanes<EIGHT>>(
        l: L,
        rays: &TileRays,
        groups: u8,
        extent: f32,
        nearest: &PerRay,
    ) -> Option<Self> {
        let o = rays.origin;
        let delta = delta(o, extent);
        let zero = l.splat(0.0);
        let mut slabs = Self {
            span: Span {
                origin: o.to_array(),
                negative: [0; 3],
                interval: [(0.0, 0.0, 0.0); 3],
            },
            reciprocal: [[[0.0; EIGHT]; EIGHT]; 3],
            near: [[[0.0; EIGHT]; EIGHT]; 3],
            far: [[[0.0; EIGHT]; EIGHT]; 3],
        };
        for axis in 0..3 {
            let mut positive = 0xff;
            let mut negative = 0xff;
            for (group, direction) in rays.direction[axis].iter().enumerate() {
                if groups >> group & 1 == 0 {
                    continue;
                }
                let direction = l.load(direction);
                positive &= !l.bits(l.le(direction, zero));
                negative &= !l.bits(l.le(zero, direction));
            }
            // Not a comparison of signs: zeros of either sign fail both.
            slabs.span.negative[axis] = match (positive & 0xff, negative & 0xff) {
                (0xff, _) => 0,
                (_, 0xff) => 1,
                _ => return None,
            };
        }
        let magnitude = |axis: usize, x: L::F| {
            if slabs.span.negative[axis] == 0 {
                x
            } else {
                l.sub(zero, x)
            }
        };
        let mut extremes = [(l.splat(f32::INFINITY), l.splat(f32::NEG_INFINITY)); 3];
        for group in 0..EIGHT {
            if groups >> group & 1 == 0 {
                continue;
            }
            let d = map3(of_group(&rays.direction, group), |d| l.load(d));
            let m = map3([0, 1, 2], |axis: usize| magnitude(axis, d[axis]));
            let largest = l.max(m[0], l.max(m[1], m[2]));
            let least = l.max(
                l.mul(largest, l.splat(Slabs::LEAST_SHARE)),
                l.splat(Slabs::LEAST_COMPONENT),
            );
            let looks = l.le(zero, l.load(&nearest[group]));
            for axis in 0..3 {
                let clamped = magnitude(axis, l.max(m[axis], least));
                let reciprocal = l.div(l.splat(1.0), clamped);
                let centre = l.mul(l.splat(slabs.span.origin[axis]), reciprocal);
                let slack = l.mul(magnitude(axis, reciprocal), l.splat(delta));
                slabs.reciprocal[axis][group] = l.store(reciprocal);
                slabs.near[axis][group] = l.store(l.add(centre, slack));
                slabs.far[axis][group] = l.store(l.sub(centre, slack));
                let (low, high) = extremes[axis];
                extremes[axis] = (
                    l.select(looks, l.min(low, reciprocal), low),
                    l.select(looks, l.max(high, reciprocal), high),
                );
            }
        }
        for axis in 0..3 {
            let (low, high) = extremes[axis];
            let low = l.store(low).into_iter().fold(f32::INFINITY, min);
            let high = l.store(high).into_iter().fold(f32::NEG_INFINITY, max);
            slabs.span.set(axis, (low, high), delta);
        }
        Some(slabs)
    }

    /// Near and far distance of a box for the rays of a group, not clipped.
    #[inline(always)]
    pub(super) fn of_group<L: Lanes<EIGHT>>(
        &self,
        l: L,
        group: usize,
        near: [f32; 3],
        far: [f32; 3],
    ) -> (L::F, L::F) {
        let g = group % EIGHT;
        let at = |plane: f32, axis: usize, offset: &[PerRay; 3]| {
            let reciprocal = l.load(&self.reciprocal[axis][g]);
            l.sub(l.mul(l.splat(plane), reciprocal), l.load(&offset[axis][g]))
        };
        let near = |axis: usize| at(near[axis], axis, &self.near);
        let far = |axis: usize| at(far[axis], axis, &self.far);
        (
            l.max(l.max(near(0), near(1)), near(2)),
            l.min(l.min(far(0), far(1)), far(2)),
        )
    }

    /// Returns least and greatest corner as nearer and farther planes.
    #[inline(always)]
    pub(super) fn planes(&self, low: [f32; 3], high: [f32; 3]) -> ([f32; 3], [f32; 3]) {
        let pick = |axis: usize, far: usize| {
            if self.span.negative[axis] == far {
                low[axis]
            } else {
                high[axis]
            }
        };
        (
            map3([0, 1, 2], |a| pick(a, 0)),
            map3([0, 1, 2], |a| pick(a, 1)),
        )
    }
}
