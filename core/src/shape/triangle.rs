use super::{Ray, Slabs};
use crate::numeric::{difference_of_products, map3, max, min};
use glam::Vec3;

/// A triangle by its corners: metres. Both sides are hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle(pub [Vec3; 3]);

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Distance in units of the ray's direction, 0 or more.
    pub t: f32,
    /// Weights of the three corners: none negative, sum 1 within 3 ulp. The
    /// point they give is in the triangle whatever was rounded.
    pub weights: [f32; 3],
}

/// A ray's axes and shear that turn it into the unit vector along z (Woop, Benthin & Wald
/// 2013, "Watertight Ray/Triangle Intersection").
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shear {
    /// The ray's main axis last.
    pub(crate) axes: [usize; 3],
    /// Factors of a point's main component: for the other two, and for its distance.
    pub(crate) factors: [f32; 3],
    /// The ray's origin along the axes.
    pub(crate) origin: [f32; 3],
}

impl Shear {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Self {
        let (o, d) = (ray.origin(), ray.direction());
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        // Ties go to the first axis. Woop's swap for the winding is left out:
        // both sides are hit, and sheared x and y only change places.
        let main = (x >= y && x >= z, y >= z);
        let [dx, dy, dz] = turned(d.to_array(), main);
        Self {
            axes: turned([0, 1, 2], main),
            factors: [dx / dz, dy / dz, 1.0 / dz],
            origin: turned(o.to_array(), main),
        }
    }
}

/// Returns three components, the main axis' last: the first's, else the second's.
#[inline(always)]
fn turned<T>([x, y, z]: [T; 3], (first, second): (bool, bool)) -> [T; 3] {
    if first {
        [y, z, x]
    } else if second {
        [z, x, y]
    } else {
        [x, y, z]
    }
}

/// A triangle in the sheared frame of a ray.
#[derive(Clone, Copy)]
struct Sheared {
    x: [f32; 3],
    y: [f32; 3],
    z: [f32; 3],
}

impl Triangle {
    /// Watertight closest-hit test, for corners no farther out than [`Ray::FARTHEST`] and an
    /// `extent` that they are within (metres).
    ///
    /// Edges and corners belong to every triangle that shares them: of a closed mesh no ray goes
    /// between two triangles. The corners are moved by rounding, at most 10·2⁻²⁴·M (see
    /// [`Slabs`]), each corner the same way in all its triangles; apart from that the decision
    /// is exact: f32 edge functions cannot turn their sign, and zeros are decided by integers.
    ///
    /// A triangle that the ray sees exactly edge-on is not hit, nor one whose moved corners have
    /// no area. `t` is not less than where the ray enters the triangle's own box, so that the
    /// least `t` does not depend on which boxes were visited first.
    pub fn intersect(&self, ray: &Ray, extent: f32) -> Option<TriangleHit> {
        let (slabs, shear) = (Slabs::new(ray, extent), Shear::new(ray));
        let [a, b, c] = &map3(self.0, |corner| corner.to_array());
        let t = Self::distance([a, b, c], &shear, &slabs, f32::INFINITY)?;
        Some(TriangleHit {
            t,
            weights: self.weights(ray),
        })
    }

    /// [`Self::intersect`]'s distance for a ready ray; `None` farther than `limit`.
    #[inline(always)]
    pub(crate) fn distance(
        corners: [&[f32; 3]; 3],
        shear: &Shear,
        slabs: &Slabs,
        limit: f32,
    ) -> Option<f32> {
        let sheared = Sheared::new(corners, shear);
        let edges = sheared.edges();
        let least = min(edges[0], min(edges[1], edges[2]));
        let most = max(edges[0], max(edges[1], edges[2]));
        if !(least >= 0.0 || most <= 0.0) {
            return None;
        }
        let triangle = Self(map3(corners, |&c| Vec3::from_array(c)));
        let t = if least == 0.0 || most == 0.0 {
            // A copy: the shear itself need not be in memory for this.
            triangle.exact_distance(&{ *shear })?
        } else {
            sheared.distance(edges, shear)
        };
        // The box can only move it on.
        if t > limit {
            return None;
        }
        triangle.clamp_to_box(t, slabs)
    }

    #[inline(always)]
    fn sheared(&self, shear: &Shear) -> Sheared {
        let [a, b, c] = &map3(self.0, |corner| corner.to_array());
        Sheared::new([a, b, c], shear)
    }

    /// Returns the distance by exact signs of the edge functions; `None` for a miss.
    #[cold]
    #[inline(never)]
    pub(crate) fn exact_distance(&self, shear: &Shear) -> Option<f32> {
        let sheared = self.sheared(shear);
        let edges = sheared.exact_edges();
        let same_side = edges.iter().all(|&e| e >= 0.0) || edges.iter().all(|&e| e <= 0.0);
        let largest = max(edges[0].abs(), max(edges[1].abs(), edges[2].abs()));
        if !same_side || largest == 0.0 {
            return None;
        }
        // Relative to the largest, so that products do not underflow.
        Some(sheared.distance(map3(edges, |e| e / largest), shear))
    }

    /// `t`, or where the ray enters the triangle's box; `None` behind the start or for NaN.
    #[inline(always)]
    pub(crate) fn clamp_to_box(&self, t: f32, slabs: &Slabs) -> Option<f32> {
        let (low, high) = self.bounds();
        let (near, far) = slabs.interval(low, high);
        // + 0.0 turns −0 into 0, so that equal distances have equal bits.
        let clamped = max(near, t) + 0.0;
        (t >= 0.0 && far >= 0.0).then_some(clamped)
    }

    /// Returns least and greatest corner of its box.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        let [a, b, c] = self.0;
        (lesser(lesser(a, b), c), greater(greater(a, b), c))
    }

    /// Returns the weights of the corners at the point that the ray meets.
    pub(crate) fn weights(&self, ray: &Ray) -> [f32; 3] {
        let edges = self.sheared(&Shear::new(ray)).exact_edges();
        let edges = map3(edges, f32::abs);
        let largest = max(edges[0], max(edges[1], edges[2]));
        if largest == 0.0 {
            return [1.0, 0.0, 0.0];
        }
        let edges = map3(edges, |e| e / largest);
        let sum = edges[0] + edges[1] + edges[2];
        map3(edges, |e| e / sum)
    }
}

impl Sheared {
    #[inline(always)]
    fn new(corners: [&[f32; 3]; 3], shear: &Shear) -> Self {
        // They are: it spares checks.
        let [kx, ky, kz] = map3(shear.axes, |axis| axis.min(2));
        let [sx, sy, _] = shear.factors;
        let [ox, oy, oz] = shear.origin;
        let z = map3(corners, |c| c[kz] - oz);
        let x = map3(corners, |c| c[kx] - ox);
        let y = map3(corners, |c| c[ky] - oy);
        let sheared = |from: [f32; 3], by: f32| {
            [
                from[0] - by * z[0],
                from[1] - by * z[1],
                from[2] - by * z[2],
            ]
        };
        Self {
            x: sheared(x, sx),
            y: sheared(y, sy),
            z,
        }
    }

    /// Returns twice the signed areas between each edge and the ray, opposite corner 0, 1, 2.
    #[inline(always)]
    fn edges(&self) -> [f32; 3] {
        let ([ax, bx, cx], [ay, by, cy]) = (self.x, self.y);
        [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax]
    }

    fn exact_edges(&self) -> [f32; 3] {
        let ([ax, bx, cx], [ay, by, cy]) = (self.x, self.y);
        [
            difference_of_products(cx, by, cy, bx),
            difference_of_products(ax, cy, ay, cx),
            difference_of_products(bx, ay, by, ax),
        ]
    }

    #[inline(always)]
    fn distance(&self, edges: [f32; 3], shear: &Shear) -> f32 {
        let [u, v, w] = edges;
        let [az, bz, cz] = self.z;
        let determinant = (u + v) + w;
        // Divided first: the reciprocal of a short direction times a far
        // triangle's sum overflows.
        ((u * az + v * bz) + w * cz) / determinant * shear.factors[2]
    }
}

/// Component by component, with this core's rule for equal and NaN operands.
#[inline(always)]
fn lesser(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(min(a.x, b.x), min(a.y, b.y), min(a.z, b.z))
}

#[inline(always)]
fn greater(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(max(a.x, b.x), max(a.y, b.y), max(a.z, b.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{a_ray, finite, with_hostile_numbers};

    #[test]
    fn hits_of_any_rays_and_triangles_are_finite() {
        with_hostile_numbers(|n| {
            let ray = a_ray(n);
            let corners = [[-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]];
            let triangle = Triangle(corners.map(|corner| n.vector(corner)));
            let is_near = |corner: &Vec3| corner.abs().max_element() <= Ray::FARTHEST;
            if let Some(hit) = ray.and_then(|ray| triangle.intersect(&ray, n.next(3.0)))
                && triangle.0.iter().all(is_near)
            {
                finite(&hit);
                let weights = hit.weights.iter();
                assert!(hit.t >= 0.0 && weights.clone().all(|w| (0.0..=1.0).contains(w)));
            }
        });
    }
}
