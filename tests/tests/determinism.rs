//! One frame, one hash: whatever the threads, tiles, layout, instruction set
//! and mode, and however often rendering is interrupted.
//!
//! Instruction sets are AVX2, where the processor has it, and what the compiler makes
//! of portable code, on x86-64 SSE2. One number at a time, `tests/capi/run` compares
//! a frame and a dome master by the same hash: of a build without vectors, and on a
//! Cortex-M7.

use crate::blob_fuzz::small_scene;
use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::render::{Frame, Options};
use shisen::scene::builtin::{PaperScene, paper_scene, prism, spheres};
use shisen::scene::material::Material;
use shisen::scene::{Background, Scene, Shape};
use shisen_core::frame::{
    Budget, Mode, Outcome, Pixel, Renderer, Settings, Statistics, Tile, TileError, TileJob, View,
    Workspace,
};
use shisen_core::{Runs, Simd};
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

fn frame<const W: usize>(baked: &Baked<W>, side: u32, options: &Options) -> Frame
where
    Simd: Runs<W>,
{
    scenes::frame(baked, &three_walls(side), &both_eyes(), options)
}

/// Renders the scene in every way and compares; `side` pixels a wall.
fn assert_one_hash(name: &str, scene: &Scene, side: u32, tiles: &[u32]) {
    let Paths { fast, compact } = Paths::new(scene);
    let reference = frame(&fast, side, &options(1, 32, Mode::Single, Simd::PORTABLE));
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
            (8, frame(&fast, side, &options)),
            (4, frame(&compact, side, &options)),
        ] {
            let way = format!("{name}, {width} wide, {options:?}");
            assert_same(&way, &found, &reference, (width, &options));
        }
    }
}

#[test]
fn papers_scenes_have_one_hash() {
    for (name, mesh) in meshes() {
        for which in PaperScene::ALL {
            let scene = paper_scene(which, mesh.clone()).expect("a scene");
            let name = format!("{name}, {}", which.name());
            assert_one_hash(&name, &scene, 48, &[13, 8, 256]);
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
fn textures_and_soft_light_have_one_hash() {
    assert_one_hash("textures", &small_scene(), 48, &[13, 8, 256]);
}

#[test]
fn wavelengths_have_one_hash() {
    // A comb, unless somebody asks for something else.
    assert_one_hash("prism", &prism(), 48, &[13, 8, 256]);
    assert_one_hash("spheres", &spheres(), 48, &[13, 8, 256]);
}

pub(crate) const SIDE: u32 = 27;

/// A view whose edges are no edges of blocks. The axis of its screen goes
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

/// Calls a job of a tile with so many steps a call until it is finished; returns pixels, total
/// statistics and the most steps of a call beyond its budget.
pub(crate) fn in_instalments<const W: usize>(
    renderer: &Renderer<'_, W>,
    view: &View,
    tile: Tile,
    budget: u64,
) -> (Vec<Pixel>, Statistics, u64)
where
    Simd: Runs<W>,
{
    let mut pixels = vec![Pixel::default(); (tile.width * tile.height) as usize];
    let mut workspace = Workspace::new();
    let mut job = TileJob::new(tile);
    let (mut most_over, mut calls) = (0, 0);
    loop {
        let before = workspace.statistics.steps;
        let mut left = Budget::steps(budget);
        let outcome = job.render(renderer, view, &mut pixels, &mut left, &mut workspace);
        let steps = workspace.statistics.steps - before;
        assert_eq!(
            left.left(),
            budget.saturating_sub(steps),
            "the budget counts all steps"
        );
        most_over = most_over.max(steps.saturating_sub(budget));
        calls += 1;
        if outcome.expect("a tile of the view") == Outcome::Finished {
            assert!(job.is_finished());
            return (pixels, workspace.statistics, most_over);
        }
        assert!(left.is_spent(), "stopped with budget left");
        assert!(calls <= tile.width * tile.height * 15, "no progress");
    }
}

#[test]
fn interrupted_rendering_gives_the_same_pixels_within_the_budget() {
    let scene = glass_and_mirrors();
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let tile = tile([3, 5, 21, 19]);
    for (mode, samples) in MODES.into_iter().flat_map(|mode| [(mode, 1), (mode, 5)]) {
        let settings = ways::settings(mode, samples);
        let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
        let whole = in_instalments(&renderer, &view(), tile, u64::MAX);
        assert_eq!(whole.2, 0);
        // What one pixel costs alone, and a block with one sample of each.
        let alone = |samples: u16, side: u32| {
            let settings = Settings {
                mode: Mode::Single,
                samples,
                ..settings
            };
            let alone = Renderer::new(baked.scene(), Simd::detect(), settings);
            let places = (0..SIDE).step_by(side as usize);
            places
                .clone()
                .flat_map(|y| places.clone().map(move |x| (x, y)))
                .map(|(x, y)| {
                    let part = scenes::tile([x, y, side.min(SIDE - x), side.min(SIDE - y)]);
                    in_instalments(&alone, &view(), part, u64::MAX).1.steps
                })
                .max()
                .unwrap_or(0)
        };
        let allowed = match mode {
            Mode::Single => alone(samples, 1),
            Mode::Tile => alone(samples, 1) + alone(1, 8),
        };
        for budget in [1, 7, 1000] {
            let (pixels, statistics, most_over) = in_instalments(&renderer, &view(), tile, budget);
            assert_eq!(pixels, whole.0, "{mode:?}, {budget} steps a call");
            assert!(statistics.rays() >= whole.1.rays());
            if mode == Mode::Single {
                assert_eq!(
                    statistics, whole.1,
                    "{budget} steps a call: work done twice"
                );
            }
            assert!(
                most_over <= allowed,
                "{mode:?}: {most_over} over {budget}, {allowed} allowed"
            );
        }
    }
}

#[test]
fn a_spent_budget_renders_nothing() {
    let baked = Baked::<8>::new(&glass_and_mirrors()).expect("a scene");
    let tile = tile([0, 0, 9, 9]);
    for mode in MODES {
        let settings = ways::settings(mode, 1);
        let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
        let untouched = Pixel {
            red: -1.0,
            ..Pixel::default()
        };
        let mut pixels = [untouched; 81];
        let mut workspace = Workspace::new();
        let mut job = TileJob::new(tile);
        let mut spent = Budget::steps(0);
        let outcome = job.render(&renderer, &view(), &mut pixels, &mut spent, &mut workspace);
        assert_eq!(outcome, Ok(Outcome::BudgetSpent));
        assert_eq!(pixels, [untouched; 81]);
        assert_eq!(workspace.statistics, Statistics::default());
        assert_eq!(job, TileJob::new(tile));
        // Finished jobs stay so, at no cost, and touch nothing.
        let mut all = Budget::UNLIMITED;
        let done = job.render(&renderer, &view(), &mut pixels, &mut all, &mut workspace);
        assert_eq!(done, Ok(Outcome::Finished));
        let mut again = [untouched; 81];
        let done = job.render(&renderer, &view(), &mut again, &mut spent, &mut workspace);
        assert_eq!(done, Ok(Outcome::Finished));
        assert_eq!(again, [untouched; 81]);
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
