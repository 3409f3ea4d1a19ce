//! `obvhs`: both of its trees, by its slowest and best build.

use super::library::{Trace, contender};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use shisen_peers_interface::{Contender, Hit, Task};
use std::time::Duration;

const SIMD: &std::ffi::CStr = c"native build, SSE, 4 wide";
pub(crate) const CWBVH: Contender =
    contender::<Built<CwBvh>>(c"obvhs", c"CwBvh, slowest build", SIMD, Task::Nearest);
pub(crate) const BVH2: Contender =
    contender::<Built<Bvh2>>(c"obvhs", c"Bvh2, slowest build", SIMD, Task::Nearest);

/// A tree, and its triangles in the order of the tree.
struct Built<T> {
    tree: T,
    triangles: Vec<Triangle>,
}

fn triangles(corners: &[[[f32; 3]; 3]]) -> Vec<Triangle> {
    let triangle = |corners: &[[f32; 3]; 3]| {
        let [v0, v1, v2] = corners.map(Into::into);
        Triangle { v0, v1, v2 }
    };
    corners.iter().map(triangle).collect()
}

fn ordered(indices: &[u32], triangles: &[Triangle]) -> Vec<Triangle> {
    indices.iter().map(|&i| triangles[i as usize]).collect()
}

fn ray(&[a, b, c, d, e, f]: &[f32; 6]) -> Ray {
    Ray::new_inf([a, b, c].into(), [d, e, f].into())
}

/// Returns the number that a hit's triangle has in the mesh; hits count in the order of the tree.
fn hit(found: &RayHit, indices: &[u32]) -> Hit {
    if found.t.is_finite() {
        Hit {
            triangle: indices[found.primitive_id as usize],
            t: found.t,
        }
    } else {
        Hit::MISS
    }
}

macro_rules! trace {
    ($tree:ty, $build:path) => {
        impl Trace for Built<$tree> {
            fn open(corners: &'static [[[f32; 3]; 3]], _: &'static [u8]) -> Option<Self> {
                let triangles = triangles(corners);
                let params = BvhBuildParams::very_slow_build();
                let tree = $build(&triangles, params, &mut Duration::default());
                let triangles = ordered(&tree.primitive_indices, &triangles);
                Some(Self { tree, triangles })
            }

            fn trace(&self, rays: &[[f32; 6]], _: usize, hits: &mut [Hit]) {
                for (raw, out) in rays.iter().zip(hits) {
                    let mut found = RayHit::none();
                    let test = |ray: &Ray, id: usize| self.triangles[id].intersect(ray);
                    self.tree.ray_traverse(ray(raw), &mut found, test);
                    *out = hit(&found, &self.tree.primitive_indices);
                }
            }
        }
    };
}

trace!(CwBvh, build_cwbvh_from_tris);
trace!(Bvh2, build_bvh2_from_tris);
