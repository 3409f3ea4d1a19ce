//! The triangles of a leaf, set up eight at a time and drawn one by one.

use super::Placed;
use super::paper::{Ink, Paper, SurfaceId, Surfaces};
use super::samples::{Form, ROW_BLOCKS, Range, Samples, at_row};
use crate::numeric::map3;
use crate::simd::{Kernel, Lanes};
use glam::Vec3;

/// Corners of eight triangles: corner, axis, lane.
pub(super) type Corners = [[[f32; 8]; 3]; 3];

/// Depth under which a corner is not in front of the eye.
const BEHIND: f32 = 1.0e-4;

/// The triangles of a leaf.
pub(super) struct Triangles<'d, P, I> {
    pub(super) samples: &'d Samples,
    pub(super) placed: &'d Placed,
    /// Least height of what casts a shadow.
    pub(super) least: f32,
    pub(super) corners: &'d Corners,
    pub(super) count: usize,
    /// The number of the first that is seen.
    pub(super) number: f32,
    pub(super) paper: &'d mut P,
    pub(super) surfaces: &'d Surfaces,
    pub(super) id: &'d I,
}

impl<P: Paper, I: Fn(usize) -> SurfaceId> Kernel<8> for Triangles<'_, P, I> {
    /// A bit for each triangle that is seen.
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes<8>>(mut self, l: L) -> u32 {
        let [p, q, r] = self.corners_in_picture(l);
        let around = Around::new(l, &[p, q, r], self.samples);
        let mut seen = around.seen & ((1u32 << self.count) - 1);
        let heights = if P::IS_SHADOW {
            let heights = self.heights(l);
            let [a, b, c] = heights;
            seen &= !l.bits(l.le(l.greater(l.greater(a, b), c), l.splat(0.0)));
            store(l, heights)
        } else {
            [[0.0; 8]; 3]
        };
        if seen == 0 {
            return 0;
        }
        let [e, f, g] = [cross(l, q, r), cross(l, r, p), cross(l, p, q)];
        let [x, y, z] = [l.mul(e[0], p[0]), l.mul(e[1], p[1]), l.mul(e[2], p[2])];
        let determinant = l.store(l.add(l.add(x, y), z));
        let edges = [store(l, e), store(l, f), store(l, g)];
        let mut used = 0;
        while seen != 0 {
            let lane = seen.trailing_zeros() as usize & 7;
            seen &= seen - 1;
            let volume = determinant[lane];
            if !(volume.abs() > 0.0) {
                continue;
            }
            let sign = if volume < 0.0 { -1.0 } else { 1.0 };
            let forms = map3(edges, |[x, y, z]: [[f32; 8]; 3]| {
                Vec3::new(x[lane] * sign, y[lane] * sign, z[lane] * sign)
            });
            let last = if P::IS_SHADOW {
                let [a, b, c] = map3([0, 1, 2], |n: usize| forms[n] * heights[n][lane]);
                a + b + c
            } else {
                (forms[0] + forms[1] + forms[2]) / volume.abs()
            };
            let (range, depths) = around.of(lane, self.samples.side);
            if self.draw(l, &forms, last, depths, range, lane) {
                used |= 1 << lane;
                self.number += 1.0;
            }
        }
        used
    }
}

/// Where triangles are in the picture, at most.
struct Around {
    left: [f32; 8],
    right: [f32; 8],
    top: [f32; 8],
    bottom: [f32; 8],
    nearest: [f32; 8],
    farthest: [f32; 8],
    /// Those that may be in it, and those that reach behind the eye: a bit for each.
    seen: u32,
    is_near: u32,
}

impl Around {
    #[inline(always)]
    fn new<L: Lanes<8>>(l: L, corners: &[[L::F; 3]; 3], samples: &Samples) -> Self {
        let [p, q, r] = corners;
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let nearest = l.lesser(l.lesser(p[2], q[2]), r[2]);
        let farthest = l.greater(l.greater(p[2], q[2]), r[2]);
        let [pw, qw, rw] = [l.div(one, p[2]), l.div(one, q[2]), l.div(one, r[2])];
        let [px, qx, rx] = [l.mul(p[0], pw), l.mul(q[0], qw), l.mul(r[0], rw)];
        let [py, qy, ry] = [l.mul(p[1], pw), l.mul(q[1], qw), l.mul(r[1], rw)];
        let margin = l.splat(samples.margin);
        let left = l.add(l.lesser(l.lesser(px, qx), rx), margin);
        let right = l.sub(l.greater(l.greater(px, qx), rx), margin);
        let top = l.add(l.lesser(l.lesser(py, qy), ry), margin);
        let bottom = l.sub(l.greater(l.greater(py, qy), ry), margin);
        let side = l.splat(samples.side as f32);
        let across = l.and(l.le(zero, right), l.le(left, side));
        let down = l.and(l.le(zero, bottom), l.le(top, side));
        let is_near = l.le(nearest, l.splat(BEHIND));
        let is_around = l.or(is_near, l.and(across, down));
        Self {
            left: l.store(l.greater(left, zero)),
            right: l.store(l.greater(right, zero)),
            top: l.store(l.greater(top, zero)),
            bottom: l.store(l.greater(bottom, zero)),
            nearest: l.store(nearest),
            farthest: l.store(farthest),
            seen: l.bits(l.and(is_around, l.le(zero, farthest))),
            is_near: l.bits(is_near),
        }
    }

    /// Returns the blocks that a triangle may be in, and its least and most 1/t.
    #[inline(always)]
    fn of(&self, lane: usize, side: u32) -> (Range, (f32, f32)) {
        if self.is_near >> lane & 1 != 0 {
            return (Range::all(side), (0.0, f32::INFINITY));
        }
        let across = (self.left[lane], self.right[lane]);
        let down = (self.top[lane], self.bottom[lane]);
        let depths = (1.0 / self.farthest[lane], 1.0 / self.nearest[lane]);
        (Range::new(across, down, side), depths)
    }
}

impl<P: Paper, I: Fn(usize) -> SurfaceId> Triangles<'_, P, I> {
    /// Returns the corners' places in the picture, times their depths, and the depths.
    #[inline(always)]
    fn corners_in_picture<L: Lanes<8>>(&self, l: L) -> [[L::F; 3]; 3] {
        let (axes, origin) = (&self.placed.axes, self.placed.origin);
        let mut at = [[l.splat(0.0); 3]; 3];
        for (at, corner) in at.iter_mut().zip(self.corners) {
            for (axis, at) in at.iter_mut().enumerate() {
                let factors = [axes[0][axis], axes[1][axis], axes[2][axis]];
                *at = combined(l, factors, corner, origin[axis]);
            }
        }
        at
    }

    /// Returns the corners' heights over the least of what casts a shadow.
    #[inline(always)]
    fn heights<L: Lanes<8>>(&self, l: L) -> [L::F; 3] {
        let start = self.placed.height - self.least;
        let mut heights = [l.splat(0.0); 3];
        for (height, corner) in heights.iter_mut().zip(self.corners) {
            *height = combined(l, self.placed.heights, corner, start);
        }
        heights
    }

    #[inline(always)]
    fn draw<L: Lanes<8>>(
        &mut self,
        l: L,
        forms: &[Form; 3],
        last: Form,
        (least, most): (f32, f32),
        range: Range,
        lane: usize,
    ) -> bool {
        let id = || (self.id)(lane);
        let ink = Ink {
            number: self.number,
            id: &id,
            surfaces: self.surfaces,
        };
        let zero = l.splat(0.0);
        let (least, most) = (l.splat(least), l.splat(most));
        let mut used = false;
        for row in range.rows.0..range.rows.1 {
            let [a, b, c] = [
                at_row(l, forms[0], self.samples, row),
                at_row(l, forms[1], self.samples, row),
                at_row(l, forms[2], self.samples, row),
            ];
            let w = at_row(l, last, self.samples, row);
            for block in range.blocks.0..range.blocks.1 {
                let x = (2 * block) as f32;
                let a = l.add(a, l.splat(forms[0].x * x));
                let b = l.add(b, l.splat(forms[1].x * x));
                let c = l.add(c, l.splat(forms[2].x * x));
                let inside = l.le(zero, l.min(a, l.min(b, c)));
                if l.bits(inside) == 0 {
                    continue;
                }
                let w = l.add(w, l.splat(last.x * x));
                let (inside, w) = if P::IS_SHADOW {
                    (l.and(inside, l.le(zero, w)), w)
                } else {
                    (inside, l.min(l.max(w, least), most))
                };
                used |= self
                    .paper
                    .take(l, ROW_BLOCKS * row + block, inside, w, &ink);
            }
        }
        used
    }
}

#[inline(always)]
fn combined<L: Lanes<8>>(l: L, [a, b, c]: [f32; 3], [x, y, z]: &[[f32; 8]; 3], start: f32) -> L::F {
    let [x, y, z] = [l.load(x), l.load(y), l.load(z)];
    let sum = l.add(l.mul(l.splat(a), x), l.mul(l.splat(b), y));
    l.add(l.add(sum, l.mul(l.splat(c), z)), l.splat(start))
}

#[inline(always)]
fn cross<L: Lanes<8>>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    map3([(1, 2), (2, 0), (0, 1)], |(i, j): (usize, usize)| {
        l.sub(l.mul(a[i], b[j]), l.mul(a[j], b[i]))
    })
}

#[inline(always)]
fn store<L: Lanes<8>>(l: L, [x, y, z]: [L::F; 3]) -> [[f32; 8]; 3] {
    [l.store(x), l.store(y), l.store(z)]
}
