//! One frame, one hash, with a level of detail.

use super::{GAZES, eyes, frame, levels, lod, scenes};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::scene::Scene;
use shisen_core::Simd;
use shisen_core::frame::Mode;
use shisen_tests::meshes::meshes;
use shisen_tests::sizes::cases;
use shisen_tests::ways::{assert_same, options};

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
            (4, 13, Simd::PORTABLE),
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
