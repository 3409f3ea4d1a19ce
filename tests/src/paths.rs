//! One scene on every instruction set and in both layouts.

use shisen::bake::Baked;
use shisen::scene::Scene;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::{Hit, MeshHit, MeshTracer, Tracer, TraversalStack};
use shisen_core::{Runs, Simd};

/// A scene baked in both layouts.
#[derive(Debug)]
pub struct Paths {
    /// Eight wide.
    pub fast: Baked<8>,
    /// Four wide.
    pub compact: Baked<4>,
}

/// A search for the nearest hit, and what to call it in a message.
pub type Search<'a, T> = (String, Box<dyn FnMut(&Ray) -> Option<T> + 'a>);

impl Paths {
    /// Bakes the scene twice.
    pub fn new(scene: &Scene) -> Self {
        Self {
            fast: Baked::new(scene).expect("a scene that can be baked"),
            compact: Baked::new(scene).expect("a scene that can be baked"),
        }
    }

    /// Returns the nearest triangle of the first mesh, in its own frame.
    pub fn in_mesh(&self) -> Vec<Search<'_, MeshHit>> {
        let both = |simd| [in_mesh(&self.fast, simd), in_mesh(&self.compact, simd)];
        [Simd::detect(), Simd::PORTABLE]
            .into_iter()
            .flat_map(both)
            .collect()
    }

    /// Returns the nearest hit in the scene.
    pub fn in_scene(&self) -> Vec<Search<'_, Hit>> {
        let both = |simd| [in_scene(&self.fast, simd), in_scene(&self.compact, simd)];
        [Simd::detect(), Simd::PORTABLE]
            .into_iter()
            .flat_map(both)
            .collect()
    }
}

fn in_mesh<const W: usize>(baked: &Baked<W>, simd: Simd) -> Search<'_, MeshHit>
where
    Simd: Runs<W>,
{
    let tracer = MeshTracer::new(&baked.scene(), 0, simd).expect("a scene with a mesh");
    let mut stack = TraversalStack::EMPTY;
    let search = move |ray: &Ray| tracer.nearest(ray, &mut stack).0;
    (format!("{} {W} wide", simd.name()), Box::new(search))
}

fn in_scene<const W: usize>(baked: &Baked<W>, simd: Simd) -> Search<'_, Hit>
where
    Simd: Runs<W>,
{
    let tracer = Tracer::new(baked.scene(), simd, 0);
    let mut workspace = Workspace::new();
    let search =
        move |ray: &Ray| tracer.nearest(ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
    (format!("{} {W} wide", simd.name()), Box::new(search))
}
