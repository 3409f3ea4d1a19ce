//! One frame, one hash, with a level of detail.

use super::{GAZES, eyes, frame, levels, lod, mixed_scene, scenes};
use crate::determinism::{SIDE, in_instalments, view};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::scene::Scene;
use shisen_core::Simd;
use shisen_core::frame::{Mode, Pixel, Renderer};
use shisen_tests::meshes::meshes;
use shisen_tests::rays::Random;
use shisen_tests::scenes::tile;
use shisen_tests::sizes::cases;
use shisen_tests::ways::{self, assert_same, options};

const MODES: [Mode; 2] = [Mode::Single, Mode::Tile];

fn assert_one_hash(name: &str, scene: &Scene, gaze: (Vec3, Vec3), size: [u32; 2]) {
    let fast = Baked::<8>::with_levels(scene, &levels()).expect("a scene");
    let compact = Baked::<4>::with_levels(scene, &levels()).expect("a scene");
    let eyes = eyes(Some(lod(gaze)));
    let single = options(1, 32, Mode::Single, Simd::PORTABLE);
    // Once: a scene is checked whenever it is taken out of its bytes.
    let (fast, compact) = (fast.scene(), compact.scene());
    let reference = frame(&fast, size, &eyes, &single);
    for mode in MODES {
        for (threads, tile, simd) in [
            (1, 8, Simd::detect()),
            (4, 8, Simd::PORTABLE),
            (4, 13, Simd::detect()),
            (1, 13, Simd::PORTABLE),
            (4, 32, Simd::detect()),
            (1, 1024, Simd::detect()),
        ] {
            let options = options(threads, tile, mode, simd);
            for (width, found) in [
                (8, frame(&fast, size, &eyes, &options)),
                (4, frame(&compact, size, &eyes, &options)),
            ] {
                let way = format!("{name}, {gaze:?}, {width} wide, {options:?}");
                assert_same(&way, &found, &reference, (width, &options));
            }
        }
    }
}

#[test]
fn frames_have_one_hash() {
    let every = cases("every nth scene", 2, 1);
    for (name, mesh) in meshes() {
        let ways = scenes(&mesh).into_iter().zip(GAZES).enumerate();
        for (number, (scene, gaze)) in ways.step_by(every) {
            let name = format!("{name}, {}", scene.name);
            // Some of whole blocks only.
            let size = if number == 2 { [48; 2] } else { [37, 44] };
            assert_one_hash(&name, &scene, gaze, size);
        }
    }
}

/// The border of the central field, and that of the whole field, through the
/// view.
const THROUGH_THE_VIEW: [(Vec3, Vec3); 2] = [
    (Vec3::new(0.6, 0.1, -1.0), Vec3::new(0.1, 1.0, 0.3)),
    (Vec3::new(0.9, 1.0, 0.1), Vec3::new(0.1, 1.0, 0.3)),
];

#[test]
fn neither_tiles_nor_their_order_change_a_pixel() {
    let scene = mixed_scene(shisen::scene::quadruped::quadruped());
    let baked = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
    let whole = tile([0, 0, SIDE, SIDE]);
    let mut random = Random::new(0x0_0DE5);
    for (gaze, mode) in THROUGH_THE_VIEW
        .into_iter()
        .flat_map(|gaze| MODES.map(|mode| (gaze, mode)))
    {
        let settings = ways::settings(mode, 1);
        let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
        let renderer = renderer.with_level_of_detail(lod(gaze));
        let (expected, ..) = in_instalments(&renderer, &view(), whole, u64::MAX);
        for side in [1, 5, 8, 11, 16] {
            // Tiles need not be of one size, nor at multiples of it.
            let edges: Vec<u32> = [0].into_iter().chain((2..SIDE).step_by(side)).collect();
            let mut tiles = Vec::new();
            for (row, &y) in edges.iter().enumerate() {
                for (column, &x) in edges.iter().enumerate() {
                    let end = |number: usize| edges.get(number + 1).copied().unwrap_or(SIDE);
                    tiles.push(tile([x, y, end(column) - x, end(row) - y]));
                }
            }
            for _ in 0..3 {
                for last in (1..tiles.len()).rev() {
                    tiles.swap(last, random.below(last + 1));
                }
                let mut found = vec![Pixel::default(); expected.len()];
                for &tile in &tiles {
                    let (pixels, ..) = in_instalments(&renderer, &view(), tile, u64::MAX);
                    let rows = pixels.chunks_exact(tile.width as usize);
                    for (y, row) in (tile.y..).zip(rows) {
                        let first = (y * SIDE + tile.x) as usize;
                        found[first..][..row.len()].copy_from_slice(row);
                    }
                }
                assert!(
                    found == expected,
                    "{gaze:?}, {mode:?}, {side} pixels a side"
                );
            }
        }
    }
}
