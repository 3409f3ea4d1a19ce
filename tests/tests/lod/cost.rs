//! How many faces rays meet, and in how many steps.

use super::{
    GAZES, exact_sight, eyes, frame, is_on_a_border, levels, levels_of, lod, places, reference,
    samples, views,
};
use glam::{DVec3, Vec3};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::render::{Options, renderer};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::frame::{Mode, Spectrum};
use shisen_core::gaze::Zone;
use shisen_tests::meshes::{meshes, torus};
use shisen_tests::sizes::cases;

fn in_mode(mode: Mode) -> Options {
    let mut options = Options::default();
    options.settings.mode = mode;
    options
}

#[test]
fn faces_are_those_of_equation_10_to_five_hundredths() {
    let stride = cases("every nth pixel of large views", 117, 7);
    let with_default = meshes().into_iter().map(|(name, mesh)| (name, mesh, 16));
    for (name, mesh, rungs) in with_default.chain([("torus", torus(60, 30), 64)]) {
        let scene = paper_scene(PaperScene::A, mesh).expect("a scene");
        let baked = Baked::<8>::with_levels(&scene, &levels_of(rungs)).expect("a scene");
        let scene = baked.scene();
        assert_eq!(scene.meshes().len(), rungs as usize);
        let faces = |rung: u8| f64::from(scene.meshes()[usize::from(rung)].faces);
        let (min, max) = (f64::from(PolygonLevels::FEWEST_FACES), faces(0));
        for side in [60, 256, 1024] {
            let stride = if side > 128 { stride } else { 1 };
            // As a share of the range of faces, with its level; all pixels, and central ones.
            let (mut largest, mut traced, mut central) = ((0.0, 0.0), 0, 0);
            for gaze in GAZES {
                // One eye: the other's field is all but the same.
                let eyes = &eyes(Some(lod(gaze)))[..1];
                let exact = reference(gaze);
                for (view, eye) in views([side; 2], eyes) {
                    let renderer = renderer(&scene, &eye, &samples(1), Spectrum::Rgb).unwrap();
                    for at in places(&view).step_by(stride) {
                        let Some(detail) = renderer.detail(&view, at.0, at.1) else {
                            continue;
                        };
                        traced += 1;
                        let sight = exact_sight(&exact, &view, at);
                        let seen = faces(detail.rung);
                        if sight.zone == Zone::Central && !is_on_a_border(&sight) {
                            assert_eq!(seen, max, "a central pixel, {at:?}");
                            central += 1;
                            continue;
                        }
                        let wanted = sight.level * (max - min) + min;
                        let share = (seen - wanted).abs() / (max - min);
                        if share > largest.0 {
                            largest = (share, sight.level);
                        }
                    }
                }
            }
            assert!(traced > 1000 && central > 0 && central < traced);
            // Five hundredths of the range, to the last face.
            assert!(
                largest.0 <= 0.05,
                "{name}, {rungs} rungs, {side}²: {largest:?}"
            );
        }
    }
}

/// `count` directions spread evenly over the sphere (Fibonacci's spiral).
fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |number| {
        let y = 1.0 - (2 * number + 1) as f64 / count as f64;
        let (s, c) = (golden * number as f64).sin_cos();
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * c, y, r * s).as_vec3()
    })
}

/// Returns some of 200 directions; for scenes that are before the front wall only, more of those
/// within 24° of its middle, too: that is where most of them is seen.
fn looks(which: PaperScene, stride: usize) -> Vec<Vec3> {
    let is_ahead = matches!(which, PaperScene::C | PaperScene::D);
    let is_front = |forward: &Vec3| is_ahead && forward.dot(Vec3::NEG_Z) > 0.91;
    let chosen = directions(200).enumerate();
    let chosen = chosen.filter(|(number, forward)| number % stride == 0 || is_front(forward));
    chosen.map(|(_, forward)| forward).collect()
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn no_gaze_is_dearer_than_plain_tracing() {
    let stride = cases("every nth of 200 lines of sight", 41, 5);
    let mut dearer = Vec::new();
    for ((name, mesh), which) in meshes()
        .into_iter()
        .flat_map(|one| PaperScene::ALL.map(|which| (one.clone(), which)))
    {
        let scene = paper_scene(which, mesh).expect("a scene");
        let plain = Baked::<8>::new(&scene).expect("a scene");
        let ladder = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
        let (plain, ladder) = (plain.scene(), ladder.scene());
        // Ray by ray is slow, and every one of its rays costs less.
        for (mode, side) in [(Mode::Tile, 256), (Mode::Single, 64)] {
            let what = format!("{name}, {}, {mode:?}, {side}²", which.name());
            let (size, options) = ([side; 2], in_mode(mode));
            let mut all = frame(plain, size, &eyes(None), &options).statistics;
            // Ray by ray it counts that blocks are spared by covers, which hold all levels of a
            // mesh: a gaze is held against the same scene, which is held against the one
            // without levels.
            if mode == Mode::Single {
                let in_full = frame(ladder, size, &eyes(None), &options).statistics;
                assert_eq!(in_full.rays(), all.rays(), "{what}");
                assert!(in_full.steps as f64 <= 1.02 * all.steps as f64, "{what}");
                all = in_full;
            }
            for forward in looks(which, stride) {
                let up = if forward.y.abs() < 0.9 {
                    Vec3::Y
                } else {
                    Vec3::NEG_Z
                };
                let eyes = eyes(Some(lod((forward, up))));
                let found = frame(ladder, size, &eyes, &options).statistics;
                assert!(found.rays() <= all.rays(), "{what}, towards {forward}");
                if found.steps > all.steps {
                    let ratio = found.steps as f64 / all.steps as f64;
                    dearer.push(format!("{what}, towards {forward}: {ratio:.4}"));
                }
            }
        }
    }
    assert!(dearer.is_empty(), "{dearer:?}");
}
