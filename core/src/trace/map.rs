//! Points and directions through the maps of instances.

use crate::simd::{Lanes, dot};
use glam::Vec3;

/// Returns a point or a direction through a baked map: columns, then translation.
#[inline(always)]
pub(crate) fn map_vector(map: &[[f32; 3]; 4], v: Vec3) -> Vec3 {
    let [x, y, z, _] = *map;
    Vec3::from_array(x) * v.x + Vec3::from_array(y) * v.y + Vec3::from_array(z) * v.z
}

#[inline(always)]
pub(crate) fn map_point(map: &[[f32; 3]; 4], p: Vec3) -> Vec3 {
    map_vector(map, p) + Vec3::from_array(map[3])
}

/// Returns one component of directions through a baked map.
#[inline(always)]
pub(super) fn map_component<const W: usize, L: Lanes<W>>(
    l: L,
    map: &[[f32; 3]; 4],
    axis: usize,
    v: [L::F; 3],
) -> L::F {
    let axis = axis % 3;
    let row = Vec3::new(map[0][axis], map[1][axis], map[2][axis]);
    dot(l, row, v)
}
