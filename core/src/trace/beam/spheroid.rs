//! A spheroid, by the lines of a square that meet it.

use super::paper::{Ink, Paper, SurfaceId, Surfaces};
use super::samples::{Form, ROW_BLOCKS, Range, Samples, at_row};
use super::{Beam, Placed};
use crate::numeric::{map3, max, sqrt};
use crate::scene::format::Instance;
use crate::simd::{Kernel, Lanes};
use crate::trace::map::{map_point, map_vector};
use glam::Vec3;

/// A spheroid: the image of a unit ball.
pub(super) struct Spheroid<'d, P> {
    pub(super) samples: &'d Samples,
    pub(super) beam: &'d Beam,
    pub(super) placed: &'d Placed,
    pub(super) instance: &'d Instance,
    pub(super) number: f32,
    pub(super) paper: &'d mut P,
    pub(super) surfaces: &'d Surfaces,
    pub(super) id: SurfaceId,
}

/// Where a line from a plane towards a light is half-way through a spheroid: above the plane if
/// Σ −p · (l w − p) is positive, by component and place.
struct Above {
    point: [Form; 3],
    towards: [Form; 3],
}

impl<P: Paper> Kernel<8> for Spheroid<'_, P> {
    /// Whether it is seen.
    type Output = bool;

    // Longer than 80 lines: its numbers stay in registers.
    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> bool {
        let (axes, centre) = (&self.placed.axes, self.placed.origin);
        let Some(range) = outline(axes, centre, self.samples) else {
            return false;
        };
        let mut above = None;
        if let Some(plane) = &self.beam.plane {
            let [a, b, c] = self.placed.heights;
            let high = sqrt(a * a + b * b + c * c);
            let height = self.placed.height - plane.least;
            if height + high <= 0.0 {
                return false;
            }
            if height - high < 0.0 {
                above = Some(self.above());
            }
        }
        let products = [
            axes[1].cross(axes[2]),
            axes[2].cross(axes[0]),
            axes[0].cross(axes[1]),
        ];
        let moments = axes.map(|axis| centre.cross(axis));
        let across = products.map(|n| n.dot(centre));
        let along = products[0] * across[0] + products[1] * across[1] + products[2] * across[2];
        let determinant = axes[0].dot(products[0]).abs();
        let id = || self.id;
        let ink = Ink {
            number: self.number,
            id: &id,
            surfaces: self.surfaces,
        };
        let zero = l.splat(0.0);
        let mut used = false;
        for row in range.rows.0..range.rows.1 {
            let of = |form: Form| at_row(l, form, self.samples, row);
            let n = [of(products[0]), of(products[1]), of(products[2])];
            let m = [of(moments[0]), of(moments[1]), of(moments[2])];
            for block in range.blocks.0..range.blocks.1 {
                let x = (2 * block) as f32;
                let to = |start: L::F, form: Form| l.add(start, l.splat(form.x * x));
                let g = squares(
                    l,
                    [
                        to(n[0], products[0]),
                        to(n[1], products[1]),
                        to(n[2], products[2]),
                    ],
                );
                let f = l.sub(
                    g,
                    squares(
                        l,
                        [
                            to(m[0], moments[0]),
                            to(m[1], moments[1]),
                            to(m[2], moments[2]),
                        ],
                    ),
                );
                let mut inside = l.le(zero, f);
                if l.bits(inside) == 0 {
                    continue;
                }
                let mut w = zero;
                if !P::IS_SHADOW {
                    let h = to(of(along), along);
                    let half = l.mul(l.splat(determinant), l.sqrt(l.greater(f, zero)));
                    let (first, second) = (l.sub(h, half), l.add(h, half));
                    let root = l.select(l.le(first, zero), second, first);
                    w = l.div(g, root);
                    inside = l.and(inside, l.le(l.splat(f32::MIN_POSITIVE), root));
                } else if let Some(above) = &above {
                    let mut sum = zero;
                    for axis in 0..3 {
                        let p = to(of(above.point[axis]), above.point[axis]);
                        let t = to(of(above.towards[axis]), above.towards[axis]);
                        sum = l.add(sum, l.mul(p, t));
                    }
                    inside = l.and(inside, l.le(sum, zero));
                }
                if l.bits(inside) != 0 {
                    used |= self
                        .paper
                        .take(l, ROW_BLOCKS * row + block, inside, w, &ink);
                }
            }
        }
        used
    }
}

impl<P> Spheroid<'_, P> {
    #[inline(never)]
    fn above(&self) -> Above {
        let none = Above {
            point: [Vec3::ZERO; 3],
            towards: [Vec3::ZERO; 3],
        };
        let Some(plane) = &self.beam.plane else {
            return none;
        };
        let map = &self.instance.object_from_world;
        let [equatorial, polar] = self.instance.radii;
        let scale = Vec3::new(1.0 / equatorial, 1.0 / polar, 1.0 / equatorial);
        // A point of the plane times w is eye · w + direction · height; w and height have one sign.
        let height = plane.distance - plane.normal.dot(self.beam.eye);
        let sign = if height < 0.0 { -1.0 } else { 1.0 };
        let weight = Vec3::from_array(
            self.beam
                .columns
                .map(|column| plane.normal.dot(column) * sign),
        );
        let eye = map_point(map, self.beam.eye) * scale;
        let columns = self
            .beam
            .columns
            .map(|column| map_vector(map, column) * scale * (height * sign));
        let point: [Form; 3] = map3([0, 1, 2], |axis: usize| {
            Vec3::new(columns[0][axis], columns[1][axis], columns[2][axis]) + weight * eye[axis]
        });
        let towards = if plane.is_directional {
            let light = map_vector(map, plane.light) * scale;
            map3([0, 1, 2], |axis: usize| weight * light[axis])
        } else {
            let light = map_point(map, plane.light) * scale;
            map3([0, 1, 2], |axis: usize| weight * light[axis] - point[axis])
        };
        Above { point, towards }
    }
}

#[inline(always)]
fn squares<L: Lanes<8>>(l: L, [x, y, z]: [L::F; 3]) -> L::F {
    l.add(l.add(l.mul(x, x), l.mul(y, y)), l.mul(z, z))
}

/// Returns where the outline of a ball's image lies; `None` outside the square.
#[inline(always)]
fn outline(axes: &[Vec3; 3], centre: Vec3, samples: &Samples) -> Option<Range> {
    let row = |axis: usize| Vec3::new(axes[0][axis], axes[1][axis], axes[2][axis]);
    let deep = row(2);
    let square = deep.dot(deep);
    let under = centre.z * centre.z - square;
    if !(under > 0.0 && centre.z > 0.0) {
        return (centre.z + sqrt(square) > 0.0).then_some(Range::all(samples.side));
    }
    // Tangents at right angles to an axis: roots of a quadratic whose discriminant is a difference.
    let extent = |axis: usize| {
        let own = row(axis);
        let v = own * centre.z - deep * centre[axis];
        let n = own.cross(deep);
        let middle = centre[axis] * centre.z - own.dot(deep);
        let half = sqrt(max(v.dot(v) - n.dot(n), 0.0));
        ((middle - half) / under, (middle + half) / under)
    };
    let ((left, right), (top, bottom)) = (extent(0), extent(1));
    let last = samples.side as f32;
    if !(right >= 0.0 && left <= last && bottom >= 0.0 && top <= last) {
        return None;
    }
    let inner = |(low, high): (f32, f32)| (low + samples.margin, high - samples.margin);
    let ((left, right), (top, bottom)) = (inner((left, right)), inner((top, bottom)));
    if right < 0.0 || bottom < 0.0 {
        return None;
    }
    Some(Range::new((left, right), (top, bottom), samples.side))
}
