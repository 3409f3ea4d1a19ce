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

pub(crate) const NEAREST: Contender =
    contender::<Ours<{ Task::Nearest as u8 }>>(c"Shisen", MODE, SIMD, Task::Nearest);
pub(crate) const ANY: Contender =
    contender::<Ours<{ Task::Any as u8 }>>(c"Shisen", MODE, SIMD, Task::Any);
pub(crate) const PICTURE: Contender =
    contender::<Ours<{ Task::Picture as u8 }>>(c"Shisen", TILES, SIMD, Task::Picture);

const ANY_TASK: u8 = Task::Any as u8;
const PICTURE_TASK: u8 = Task::Picture as u8;

/// The tracer for a [`Task`].
struct Ours<const TASK: u8>(MeshTracer<'static>);

fn ray(&[a, b, c, d, e, f]: &[f32; 6]) -> Option<Ray> {
    Ray::new(Vec3::new(a, b, c), Vec3::new(d, e, f))
}

impl<const TASK: u8> Trace for Ours<TASK> {
    fn open(_: &'static [[[f32; 3]; 3]], baked: &'static [u8]) -> Option<Self> {
        MeshTracer::new(&Scene::from_bytes(baked).ok()?, 0, Simd::detect()).map(Self)
    }

    fn trace(&self, rays: &[[f32; 6]], side: usize, hits: &mut [Hit]) {
        match TASK {
            ANY_TASK => any(&self.0, rays, hits),
            PICTURE_TASK => picture(&self.0, rays, side, hits),
            _ => nearest(&self.0, rays, hits),
        }
    }
}

fn nearest(tracer: &MeshTracer<'_>, rays: &[[f32; 6]], hits: &mut [Hit]) {
    let (mut stack, mut hits) = (TraversalStack::EMPTY, hits.iter_mut());
    tracer.nearest_of_each(rays.iter().map(ray), &mut stack, |nearest| {
        if let Some(hit) = hits.next() {
            *hit = nearest.map_or(Hit::MISS, |hit| Hit {
                triangle: hit.triangle,
                t: hit.t,
            });
        }
    });
}

fn any(tracer: &MeshTracer<'_>, rays: &[[f32; 6]], hits: &mut [Hit]) {
    const MET: Hit = Hit {
        triangle: 0,
        t: 0.0,
    };
    let (mut stack, mut hits) = (TraversalStack::EMPTY, hits.iter_mut());
    tracer.any_of_each(rays.iter().map(ray), &mut stack, |any| {
        if let Some(hit) = hits.next() {
            *hit = if any { MET } else { Hit::MISS };
        }
    });
}

fn picture(tracer: &MeshTracer<'_>, rays: &[[f32; 6]], side: usize, hits: &mut [Hit]) {
    let mut stack = TraversalStack::EMPTY;
    for top in (0..rays.len() / side).step_by(8) {
        for left in (0..side).step_by(8) {
            let first = top * side + left;
            let [a, b, c, ..] = rays[first];
            let tile = TileRays::new(Vec3::new(a, b, c), |column, row| {
                let [.., d, e, f] = rays[first + row * side + column];
                Vec3::new(d, e, f)
            });
            let (found, _) = tracer.nearest_of_tile(&tile, &mut stack);
            for (row, column) in (0..8).flat_map(|row| (0..8).map(move |column| (row, column))) {
                let hit = found.at(column, row);
                hits[first + row * side + column] = hit.map_or(Hit::MISS, |hit| Hit {
                    triangle: hit.on.triangle,
                    t: hit.on.t,
                });
            }
        }
    }
}
