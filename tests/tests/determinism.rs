//! One frame, one hash: whatever the threads, tiles, layout, instruction set and mode.
//!
//! Instruction sets are AVX2, where the processor has it, and SSE2 or what else the compiler
//! makes of portable code; `tests/capi/run` compares with a Cortex-M7 and a build without vectors.

use crate::blob_fuzz::small_scene;
use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::{AnyScene, Baked};
use shisen::render::{Frame, Options};
use shisen::scene::builtin::{PaperScene, paper_scene, spheres};
use shisen::scene::material::Material;
use shisen::scene::{Background, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, Mode, Outcome, Pixel, Renderer, Settings, TileError, TileJob, View, Workspace,
};
use shisen_tests::meshes::{icosphere, meshes};
use shisen_tests::paths::Paths;
use shisen_tests::scenes::{self, both_eyes, object, three_walls, tile};
use shisen_tests::ways::{self, assert_same, options};

const MODES: [Mode; 2] = [Mode::Single, Mode::Tile];

/// Glass, mirrors and a spheroid around the viewer, one thing beside another.
pub(crate) fn glass_and_mirrors() -> Scene {
    let mut scene = paper_scene(PaperScene::A, icosphere(3)).expect("a scene");
    scene.materials.push(Material {
        diffuse: [0.0; 3],
        transmission: [0.9, 0.95, 1.0],
        absorption: [0.3, 0.2, 0.0],
        ..Material::default()
    });
    scene.background = Background {
        alpha: 0.25,
        ..scene.background
    };
    for (number, object) in scene.objects.iter_mut().enumerate() {
        object.smooth = number % 2 == 0;
        object.material = Some(number % 3 % 2);
    }
    for x in [-1.0, 0.4, 1.3] {
        let spheroid = Shape::Spheroid {
            equatorial_radius: 0.5,
            polar_radius: 0.8,
        };
        let place =
            DAffine3::from_rotation_x(x) * DAffine3::from_translation(DVec3::new(x, -0.2, -1.8));
        scene
            .objects
            .push(object(spheroid, usize::from(x > 0.0), place));
    }
    scene
}

fn frame(scene: AnyScene<'_>, side: u32, options: &Options) -> Frame {
    scenes::frame(scene, &three_walls(side), &both_eyes(), options)
}

/// Renders the scene in every way and compares; `side` pixels a wall.
fn assert_one_hash(name: &str, scene: &Scene, side: u32, tiles: &[u32]) {
    let Paths { fast, compact } = Paths::new(scene);
    let reference = frame(
        fast.scene().into(),
        side,
        &options(1, 32, Mode::Single, Simd::PORTABLE),
    );
    let mut ways = Vec::new();
    for mode in MODES {
        for simd in [Simd::detect(), Simd::PORTABLE] {
            ways.extend(tiles.iter().map(|&tile| (2, tile, mode, simd)));
        }
        ways.extend([1, 3].map(|threads| (threads, tiles[0], mode, Simd::detect())));
    }
    for (threads, tile, mode, simd) in ways {
        let options = options(threads, tile, mode, simd);
        for (width, found) in [
            (8, frame(fast.scene().into(), side, &options)),
            (4, frame(compact.scene().into(), side, &options)),
        ] {
            let way = format!("{name}, {width} wide, {options:?}");
            assert_same(&way, &found, &reference, width, &options);
        }
    }
}

#[test]
fn papers_scenes_have_one_hash() {
    for (name, mesh) in meshes() {
        for which in PaperScene::ALL {
            let scene = paper_scene(which, mesh.clone()).expect("a scene");
            let name = format!("{name}, {}", which.name());
            assert_one_hash(&name, &scene, 32, &[13, 8, 256]);
        }
    }
}

#[test]
fn glass_has_one_hash() {
    let scene = glass_and_mirrors();
    assert_one_hash("glass", &scene, 48, &[13, 8, 256]);
    assert_one_hash("glass", &scene, 9, &[1, 2, 100]);
}

#[test]
fn textures_soft_light_and_wavelengths_have_one_hash() {
    assert_one_hash("textures", &small_scene(), 32, &[13, 8, 256]);
    // A comb of wavelengths, as no other dispersion is asked for.
    assert_one_hash("spheres", &spheres(), 32, &[13, 8, 256]);
}

pub(crate) const SIDE: u32 = 27;

/// Returns a view whose edges are no edges of blocks. The axis of its screen goes
/// through the middle of a block: rays of it have all signs.
pub(crate) fn view() -> View {
    let step = 2.0 / SIDE as f32;
    let first = Vec3::new(-1.0 + 0.5 * step, 1.0 - 0.5 * step, -1.0);
    View::new(
        Vec3::new(0.01, 0.02, 0.03),
        first,
        Vec3::X * step,
        Vec3::NEG_Y * step,
        [SIDE; 2],
    )
    .expect("a view")
}

#[test]
fn a_spent_budget_renders_nothing_and_a_finished_job_costs_nothing() {
    let baked = Baked::<8>::new(&glass_and_mirrors()).expect("a scene");
    let untouched = [Pixel::default(); 81];
    for mode in MODES {
        let renderer = Renderer::new(baked.scene(), Simd::detect(), ways::settings(mode, 1));
        let mut job = TileJob::new(tile([0, 0, 9, 9]));
        let mut workspace = Workspace::new();
        let mut render = |mut budget: Budget, pixels: &mut [Pixel]| {
            job.render(&renderer, &view(), pixels, &mut budget, &mut workspace)
        };
        let mut pixels = untouched;
        let spent = render(Budget::steps(0), &mut pixels);
        assert_eq!((spent, pixels), (Ok(Outcome::BudgetSpent), untouched));
        let done = render(Budget::UNLIMITED, &mut pixels);
        assert!(done == Ok(Outcome::Finished) && pixels != untouched);
        let mut again = untouched;
        let done = render(Budget::steps(0), &mut again);
        assert_eq!((done, again), (Ok(Outcome::Finished), untouched));
    }
}

#[test]
fn tiles_that_are_none_are_refused() {
    let baked = Baked::<8>::new(&glass_and_mirrors()).expect("a scene");
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let render = |place: [u32; 4], room: usize| {
        TileJob::new(tile(place)).render(
            &renderer,
            &view(),
            &mut vec![Pixel::default(); room],
            &mut Budget::UNLIMITED.clone(),
            &mut Workspace::new(),
        )
    };
    for outside in [
        [0, 0, 0, 1],
        [0, 0, 1, 0],
        [SIDE, 0, 1, 1],
        [0, SIDE - 1, 1, 2],
        [u32::MAX, 0, 2, 1],
        [1, 0, u32::MAX, 1],
    ] {
        assert_eq!(render(outside, 4), Err(TileError::Outside), "{outside:?}");
    }
    let wrong = TileError::Pixels {
        needed: 4,
        given: 5,
    };
    assert_eq!(render([0, 0, 2, 2], 5), Err(wrong));
    assert_eq!(render([SIDE - 2, SIDE - 2, 2, 2], 4), Ok(Outcome::Finished));
}
