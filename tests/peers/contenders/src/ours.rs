//! This project's core.

use super::library::{Trace, contender};
use glam::Vec3;
use shisen_core::Simd;
use shisen_core::scene::Scene;
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TileRays, TraversalStack};
use shisen_peers_interface::{Contender, Hit, Task};
use std::ffi::CStr;

/// The native build has all of this processor's instructions where the compiler
/// chooses them; the other asks the processor, as the command does.
const MODE: &CStr = if cfg!(target_feature = "avx2") {
    c"native build"
} else {
    c"default build"
};
const TILES: &CStr = if cfg!(target_feature = "avx2") {
    c"native build, 8x8 tiles"
} else {
    c"default build, 8x8 tiles"
};
const SIMD: &CStr = c"AVX2, 8 wide";

pub(crate) const NEAREST: Contender = contender::<Nearest>(c"Shisen", MODE, SIMD, Task::Nearest);
pub(crate) const ANY: Contender = contender::<Any>(c"Shisen", MODE, SIMD, Task::Any);
pub(crate) const PICTURE: Contender = contender::<Picture>(c"Shisen", TILES, SIMD, Task::Picture);

struct Nearest(MeshTracer<'static>);
struct Any(MeshTracer<'static>);
struct Picture(MeshTracer<'static>);

fn tracer(baked: &'static [u8]) -> Option<MeshTracer<'static>> {
    MeshTracer::new(&Scene::from_bytes(baked).ok()?, 0, Simd::detect())
}

fn ray(&[a, b, c, d, e, f]: &[f32; 6]) -> Option<Ray> {
    Ray::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
}

impl Trace for Nearest {
    fn open(_: &'static [[[f32; 3]; 3]], baked: &'static [u8]) -> Option<Self> {
        tracer(baked).map(Self)
    }

    fn trace(&self, rays: &[[f32; 6]], _: usize, hits: &mut [Hit]) {
        let (mut stack, mut hits) = (TraversalStack::EMPTY, hits.iter_mut());
        self.0.nearest_of_each(rays.iter().map(ray), &mut stack, |nearest| {
            if let Some(hit) = hits.next() {
                *hit = nearest.map_or(Hit::MISS, |hit| Hit {
                    triangle: hit.triangle,
                    t: hit.t,
                });
            }
        });
    }
}

impl Trace for Any {
    fn open(_: &'static [[[f32; 3]; 3]], baked: &'static [u8]) -> Option<Self> {
        tracer(baked).map(Self)
    }

    fn trace(&self, rays: &[[f32; 6]], _: usize, hits: &mut [Hit]) {
        let (mut stack, mut hits) = (TraversalStack::EMPTY, hits.iter_mut());
        self.0.any_of_each(rays.iter().map(ray), &mut stack, |any| {
            if let Some(hit) = hits.next() {
                *hit = if any {
                    Hit {
                        triangle: 0,
                        t: 0.0,
                    }
                } else {
                    Hit::MISS
                };
            }
        });
    }
}

impl Trace for Picture {
    fn open(_: &'static [[[f32; 3]; 3]], baked: &'static [u8]) -> Option<Self> {
        tracer(baked).map(Self)
    }

    fn trace(&self, rays: &[[f32; 6]], side: usize, hits: &mut [Hit]) {
        let mut stack = TraversalStack::EMPTY;
        for top in (0..rays.len() / side).step_by(8) {
            for left in (0..side).step_by(8) {
                let first = top * side + left;
                let [a, b, c, ..] = rays[first];
                let tile = TileRays::new(Vec3::new(a, b, c), |column, row| {
                    let [.., d, e, f] = rays[first + row * side + column];
                    Vec3::new(d, e, f)
                });
                let (found, _) = self.0.nearest_of_tile(&tile, &mut stack);
                for (row, column) in (0..8).flat_map(|row| (0..8).map(move |column| (row, column)))
                {
                    hits[first + row * side + column] =
                        found.at(column, row).map_or(Hit::MISS, |hit| Hit {
                            triangle: hit.on.triangle,
                            t: hit.on.t,
                        });
                }
            }
        }
    }
}
