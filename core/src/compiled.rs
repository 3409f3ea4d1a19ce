//! The tracer compiled for each width of a scene's nodes, once, in this crate.
//!
//! A generic function is compiled in every crate that names its parameters. The functions here are
//! not generic, and the public functions of renderers, tracers and tiles call them, so that no
//! other crate compiles the tracer again.

use crate::frame::{Outcome, Renderer, Settings, Tile, TileError, TileJob, View};
use crate::gaze::{Acuity, LineOfSight};
use crate::scene::{EffectSet, Scene, SceneError};
use crate::shape::Ray;
use crate::simd::{self, Simd};
use crate::trace::{Budget, Hit, Ledger, Pixel, Tracer, Workspace};

/// Sets of effects that shading is compiled for in this crate, besides the set of all effects; the
/// smallest first. The unit tests of this crate compile the set of all effects alone.
pub const COMPILED: [EffectSet; 2] = if cfg!(test) {
    [EffectSet::ALL; 2]
} else {
    [
        EffectSet::SHADOWS.union(EffectSet::REFLECTION),
        EffectSet::WHITTED,
    ]
};

macro_rules! compiled {
    ($(
        fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $output:ty $body:block
    )*) => {
        /// The node widths that scenes are baked in: 8, the fast layout, and 4, the compact one.
        /// [`Simd`] implements it for both, and nothing else can.
        #[allow(
            missing_docs,
            reason = "the functions behind the public ones of their names"
        )]
        pub trait Runs<const W: usize>: simd::Runs<W> {
            $(
                #[doc(hidden)]
                fn $name($($argument: $type),*) -> $output;
            )*
        }

        const _: () = {
            const W: usize = 8;
            impl Runs<W> for Simd {
                $(fn $name($($argument: $type),*) -> $output $body)*
            }
        };

        const _: () = {
            const W: usize = 4;
            impl Runs<W> for Simd {
                $(fn $name($($argument: $type),*) -> $output $body)*
            }
        };
    };
}

compiled! {
    fn checked(bytes: &[u8]) -> Result<Scene<'_, W>, SceneError> {
        Scene::checked(bytes)
    }
    fn renderer(scene: Scene<'_, W>, simd: Simd, settings: Settings) -> Renderer<'_, W> {
        Renderer::for_effects::<{ EffectSet::ALL.bits() }>(scene, simd, settings)
    }
    fn smallest(
        scene: Scene<'_, W>,
        simd: Simd,
        settings: Settings,
        wanted: EffectSet,
    ) -> Renderer<'_, W> {
        const FIRST: u32 = COMPILED[0].bits();
        const SECOND: u32 = COMPILED[1].bits();
        match COMPILED.iter().position(|set| set.contains(wanted)) {
            Some(0) => Renderer::for_effects::<FIRST>(scene, simd, settings),
            Some(_) => Renderer::for_effects::<SECOND>(scene, simd, settings),
            None => <Simd as Runs<W>>::renderer(scene, simd, settings),
        }
    }
    fn foveated(renderer: Renderer<'_, W>, sight: LineOfSight, acuity: Acuity) -> Renderer<'_, W> {
        renderer.foveated(sight, acuity)
    }
    fn render(
        job: &mut TileJob,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Result<Outcome, TileError> {
        job.render_by(renderer, view, pixels, budget, workspace)
    }
    fn give_up(
        job: &mut TileJob,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
    ) -> Result<(), TileError> {
        job.give_up_by(renderer, view, pixels)
    }
    fn account(
        renderer: &Renderer<'_, W>,
        view: &View,
        tile: Tile,
        pixels: &mut [Pixel],
        ledger: &mut Ledger,
        workspace: &mut Workspace,
    ) -> Result<(), TileError> {
        renderer.enter(view, tile, pixels, ledger, workspace)
    }
    fn tracer(scene: Scene<'_, W>, simd: Simd, depth: u8) -> Tracer<'_, W> {
        Tracer::for_effects::<{ EffectSet::ALL.bits() }>(scene, simd, depth)
    }
    fn nearest(
        tracer: &Tracer<'_, W>,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        let rung = tracer.detail().rung;
        tracer.searcher.nearest_on(rung, ray, budget, workspace)
    }
    fn is_occluded(
        tracer: &Tracer<'_, W>,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let rung = tracer.detail().rung;
        tracer.searcher.is_occluded_on(rung, ray, limit, budget, workspace)
    }
}
