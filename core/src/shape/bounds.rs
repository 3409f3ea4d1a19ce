use super::Ray;
use crate::numeric::{UNIT_ROUNDOFF, greater, largest_number, lesser, map3, smallest_number};
use glam::Vec3;

/// A ray made ready for slab tests against boxes, conservatively: a box whose contents the ray
/// meets, as the triangle test of this core decides it, is never missed (Ize 2013, "Robust BVH
/// Ray Traversal", by another bound).
///
/// Per axis the ray meets plane b at `b·r − c`, r the direction's reciprocal; widening `c` by
/// δ·|r| moves the planes apart by δ in space. With u = 2⁻²⁴ and M the larger of the scene's
/// farthest coordinate and the origin's, the triangle test displaces vertices by at most 10·u·M,
/// and this arithmetic rounds by at most 7·u·M; δ = 32·u·M covers both. Directions are clamped
/// away from zero so that no product is 0·∞ or overflows.
///
/// Every step is monotone in the planes: a box inside another is entered, as computed, no
/// earlier and left no later, so that results do not depend on the order of visit.
#[derive(Debug, Clone, Copy)]
pub struct Slabs {
    reciprocal: [f32; 3],
    near: [f32; 3],
    far: [f32; 3],
    /// Per axis 1 where the direction is negative.
    negative: [usize; 3],
}

impl Slabs {
    /// The least magnitude of a clamped component, whose reciprocal overflows no product.
    pub(crate) const LEAST_COMPONENT: f32 = 1.0e-26;

    /// The least share of the largest component that a component counts as.
    pub(crate) const LEAST_SHARE: f32 = 1.0e-18;

    /// Extents up to this keep the widening of all planes finite, so that a
    /// box from +∞ to −∞ is never entered.
    pub const LARGEST_EXTENT: f32 = 1.0e17;

    /// Multiples of u·M by which boxes are widened.
    pub const SLACK: f32 = 32.0;

    /// Prepares `ray` for boxes whose coordinates are at most `extent` in
    /// magnitude (metres), up to [`LARGEST_EXTENT`](Self::LARGEST_EXTENT).
    #[inline(always)]
    pub fn new(ray: &Ray, extent: f32) -> Self {
        let (o, d) = (ray.origin(), ray.direction());
        let least = greater(largest_number(d) * Self::LEAST_SHARE, Self::LEAST_COMPONENT);
        let mut reciprocal = Vec3::new(1.0 / d.x, 1.0 / d.y, 1.0 / d.z);
        if smallest_number(d) < least {
            reciprocal = clamped_reciprocal(d, least);
        }
        let delta = Self::SLACK * UNIT_ROUNDOFF * greater(extent, largest_number(o));
        let centre = o * reciprocal;
        let slack = reciprocal.abs() * delta;
        let sign = |d: f32| usize::from(d.is_sign_negative());
        Self {
            reciprocal: reciprocal.to_array(),
            near: (centre + slack).to_array(),
            far: (centre - slack).to_array(),
            negative: [sign(d.x), sign(d.y), sign(d.z)],
        }
    }

    /// From what [`new`](Self::new) has computed elsewhere.
    #[inline(always)]
    pub(crate) fn from_parts(
        reciprocal: [f32; 3],
        near: [f32; 3],
        far: [f32; 3],
        negative: [usize; 3],
    ) -> Self {
        Self {
            reciprocal,
            near,
            far,
            // Known to be 0 or 1: no plane is out of range.
            negative: map3(negative, |negative| negative & 1),
        }
    }

    /// 0 to 7: bit `a` is set where the direction is negative on axis `a`.
    #[inline(always)]
    pub(crate) fn octant(&self) -> usize {
        self.negative[0] | self.negative[1] << 1 | self.negative[2] << 2
    }

    #[inline(always)]
    pub(crate) fn is_negative(&self, axis: usize) -> bool {
        self.negative[axis] != 0
    }

    /// Returns which of the six planes (−x, +x, −y, +y, −z, +z) is nearer on `axis`.
    #[inline(always)]
    pub(crate) fn near_plane(&self, axis: usize) -> usize {
        2 * axis + self.negative[axis]
    }

    /// Returns which of the six planes is farther on `axis`.
    #[inline(always)]
    pub(crate) fn far_plane(&self, axis: usize) -> usize {
        2 * axis + (1 - self.negative[axis])
    }

    /// Reciprocal of the direction on `axis`, and offsets of near and far planes.
    #[inline(always)]
    pub(crate) fn coefficients(&self, axis: usize) -> (f32, f32, f32) {
        (self.reciprocal[axis], self.near[axis], self.far[axis])
    }

    /// Returns where the ray enters and leaves the box, widened as described; empty
    /// where the first is greater. Not clipped to the ray's start. Infinite
    /// where planes are, never NaN for planes that are not.
    #[inline(always)]
    pub fn interval(&self, low: Vec3, high: Vec3) -> (f32, f32) {
        let planes = [low.x, high.x, low.y, high.y, low.z, high.z];
        let near = |axis| planes[self.near_plane(axis)] * self.reciprocal[axis] - self.near[axis];
        let far = |axis| planes[self.far_plane(axis)] * self.reciprocal[axis] - self.far[axis];
        (
            greater(greater(near(0), near(1)), near(2)),
            lesser(lesser(far(0), far(1)), far(2)),
        )
    }
}

/// Slabs for a direction with components nearer to zero than `least`, which count as that.
// Not inlined: it is rare, and most rays do not have to wait for `least`.
#[cold]
#[inline(never)]
fn clamped_reciprocal(d: Vec3, least: f32) -> Vec3 {
    let clamped = |d: f32| greater(d.abs(), least).copysign(d);
    Vec3::new(1.0 / clamped(d.x), 1.0 / clamped(d.y), 1.0 / clamped(d.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{a_ray, finite, with_hostile_numbers};

    #[test]
    fn axis_parallel_rays_on_a_face_are_inside() {
        let (low, high) = (Vec3::splat(-1.0), Vec3::splat(1.0));
        for zero in [0.0, -0.0] {
            let ray = Ray::new(Vec3::new(1.0, 0.0, 5.0), Vec3::new(zero, zero, -1.0)).unwrap();
            let (near, far) = Slabs::new(&ray, 1.0).interval(low, high);
            assert!(near <= far && near < 4.001 && far > 5.999, "{near} {far}");
            let ray = Ray::new(Vec3::new(1.001, 0.0, 5.0), Vec3::new(zero, zero, -1.0)).unwrap();
            let (near, far) = Slabs::new(&ray, 1.0).interval(low, high);
            assert!(near > far);
        }
    }

    #[test]
    fn intervals_of_any_rays_and_boxes_are_numbers() {
        with_hostile_numbers(|n| {
            let Some(ray) = a_ray(n) else {
                return;
            };
            // NaN is no extent: the ray's own start counts.
            let extent = n.next(10.0).abs().min(Slabs::LARGEST_EXTENT);
            let slabs = Slabs::new(&ray, extent);
            finite(&slabs);
            let (near, far) = slabs.interval(Vec3::INFINITY, Vec3::NEG_INFINITY);
            assert!(near > far, "{near} {far}");
            let (near, far) = slabs.interval(Vec3::NEG_INFINITY, Vec3::INFINITY);
            assert!(near <= far, "{near} {far}");
            let (low, high) = (n.vector([-1.0; 3]), n.vector([1.0; 3]));
            let (near, far) = slabs.interval(low, high);
            let inside = |v: Vec3| v.abs().max_element() <= extent;
            assert!(!(inside(low) && inside(high) && (near.is_nan() || far.is_nan())));
        });
    }
}
