//! What the central field and the outside show.

use super::{
    GAZES, bits, empty_scene, exact_sight, eyes, frame, is_on_a_border, level, levels, lod,
    mixed_scene, places, reference, samples, scenes, views,
};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::render::{Frame, Options, renderer};
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::frame::{LevelOfDetail, Spectrum};
use shisen_core::gaze::Zone;
use shisen_core::scene::Scene as CoreScene;
use shisen_tests::meshes::{icosphere, meshes};

/// A scene with a ladder, without, and what is left where nothing is met. The
/// plain scene is baked by itself: a ladder must not change its top.
struct Stage {
    name: String,
    ladder: Baked<8>,
    plain: Baked<8>,
    nothing: Baked<8>,
}

/// How many pixels were compared of which level.
#[derive(Debug, Default, Clone, Copy)]
struct Compared {
    central: u64,
    outside: u64,
    /// So close to a border of the field that rounding decides.
    undecided: u64,
    all: u64,
}

impl Stage {
    fn new(name: &str, scene: &Scene) -> Self {
        // Coverage is compared, too.
        let mut scene = scene.clone();
        scene.background.alpha = 0.25;
        Self {
            name: format!("{name}, {}", scene.name),
            ladder: Baked::with_levels(&scene, &levels()).expect("a scene"),
            plain: Baked::new(&scene).expect("a scene"),
            nothing: Baked::new(&empty_scene(scene.background)).expect("a scene"),
        }
    }

    /// Compares, at every pixel of level 1, with plain tracing, and at every
    /// one of level 0 with an empty scene.
    fn compare(&self, gaze: (Vec3, Vec3), size: [u32; 2], options: &Options) -> Compared {
        // Once: a scene is checked whenever it is taken out of its bytes.
        let ladder = self.ladder.scene();
        let (eyes, none) = (eyes(Some(lod(gaze))), eyes(None));
        let exact = reference(gaze);
        let with = frame(&ladder, size, &eyes, options);
        let without = frame(&self.plain.scene(), size, &none, options);
        let missed = frame(&self.nothing.scene(), size, &none, options);
        let mut compared = Compared::default();
        let mut traced = 0;
        for (number, (view, eye)) in views(size, &eyes).iter().enumerate() {
            let renderer = renderer(&ladder, eye, options, Spectrum::Rgb).unwrap();
            let full = renderer.tracer().detail();
            for (x, y) in places(view) {
                let at = |frame: &Frame| {
                    bits(frame.pictures[number].picture.pixel(x, y).expect("a pixel"))
                };
                let what = || {
                    format!(
                        "{}, {gaze:?}, {size:?}, picture {number}, {x} {y}",
                        self.name
                    )
                };
                let detail = renderer.detail(view, x, y);
                let sight = exact_sight(&exact, view, (x, y));
                traced += u64::from(detail.is_some());
                compared.all += 1;
                if is_on_a_border(&sight) {
                    compared.undecided += 1;
                    continue;
                }
                assert_eq!(detail.is_some(), sight.level > 0.0, "{}", what());
                match sight.zone {
                    Zone::Central => {
                        compared.central += 1;
                        assert_eq!(detail, Some(full), "{}", what());
                        assert_eq!(at(&with), at(&without), "{}", what());
                    }
                    Zone::Peripheral => {}
                    Zone::Outside => {
                        compared.outside += 1;
                        assert_eq!(at(&with), at(&missed), "{}", what());
                    }
                }
            }
        }
        let rays = traced * u64::from(options.settings.samples);
        assert_eq!(
            with.statistics.primary, rays,
            "{}, {gaze:?}, {size:?}",
            self.name
        );
        compared
    }
}

#[test]
fn the_central_field_is_plain_and_the_outside_background() {
    let mut sum = Compared::default();
    let mut add = |found: Compared| {
        assert!(found.central > 0 && found.outside > 0, "{found:?}");
        sum.central += found.central;
        sum.outside += found.outside;
        sum.undecided += found.undecided;
        sum.all += found.all;
    };
    for (name, mesh) in meshes() {
        let stages: Vec<Stage> = scenes(&mesh)
            .iter()
            .map(|scene| Stage::new(name, scene))
            .collect();
        for (stage, gaze) in stages.iter().zip(GAZES.into_iter().cycle()) {
            for (size, samples_a_pixel) in [([64, 64], 1), ([19, 23], 4)] {
                add(stage.compare(gaze, size, &samples(samples_a_pixel)));
            }
        }
        // Every gaze over the scene that has everything in it.
        for gaze in GAZES {
            add(stages[4].compare(gaze, [45, 37], &samples(1)));
        }
    }
    let ball = Stage::new("icosphere", &mixed_scene(icosphere(4)));
    // So fine that blocks across the border of the central field share a mesh.
    add(ball.compare(GAZES[3], [256, 256], &samples(1)));
    println!("{sum:?}");
    assert!(sum.undecided * 10_000 < sum.all, "{sum:?}");
}

/// The paper's rays, with less or nothing taken off them.
fn assert_traced_in_full(what: &str, lod: LevelOfDetail, found: &Frame, expected: &Frame) {
    let size = [47, 43];
    let mut traced = 0;
    for (number, (view, _)) in views(size, &eyes(Some(lod))).iter().enumerate() {
        for at in places(view) {
            let of = |frame: &Frame| frame.pictures[number].picture.pixel(at.0, at.1);
            if level(&lod, view, at) > 0.0 {
                traced += 1;
                assert_eq!(of(found), of(expected), "{what}, picture {number}, {at:?}");
            }
        }
    }
    assert!(traced > 1000, "{what}: {traced}");
}

#[test]
fn what_is_not_asked_for_is_not_taken_off() {
    let (size, options) = ([47, 43], samples(1));
    let scene = mixed_scene(shisen::scene::quadruped::quadruped());
    let plain = Baked::<8>::new(&scene).expect("a scene");
    let ladder = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
    let (plain, ladder) = (plain.scene(), ladder.scene());
    let render = |scene: &CoreScene<'_, 8>, lod| frame(scene, size, &eyes(lod), &options);
    let full = render(&plain, None);
    for gaze in GAZES {
        let of = |bounces, faces| LevelOfDetail {
            bounces,
            faces,
            ..lod(gaze)
        };
        // Neither bounces nor faces: the field alone is cut.
        let cut = of(false, false);
        let found = render(&ladder, Some(cut));
        assert_traced_in_full("cut", cut, &found, &full);
        // Without a ladder, faces can be asked for in vain.
        let faces = of(false, true);
        let found = render(&plain, Some(faces));
        assert_traced_in_full("faces, no ladder", faces, &found, &full);
        // And bounces alone are the same with and without a ladder.
        let bounces = of(true, false);
        let found = render(&ladder, Some(bounces));
        assert_eq!(found.hash(), render(&plain, Some(bounces)).hash());
        // Each of the two does something.
        let hashes = [
            found.hash(),
            render(&ladder, Some(cut)).hash(),
            render(&ladder, Some(faces)).hash(),
            render(&ladder, Some(lod(gaze))).hash(),
        ];
        for (number, hash) in hashes.iter().enumerate() {
            assert!(!hashes[..number].contains(hash), "{gaze:?}: {hashes:?}");
        }
    }
}

#[test]
fn as_many_rays_as_the_paper_s_field_has() {
    // Counted in f64 at 256², from the paper's equations.
    let scene = paper_scene(PaperScene::D, icosphere(2)).expect("a scene");
    let baked = Baked::<8>::new(&scene).expect("a scene");
    for (gaze, expected) in [(GAZES[0], 210_684), (GAZES[1], 203_466)] {
        let eyes = eyes(Some(lod(gaze)));
        let found = frame(&baked.scene(), [256; 2], &eyes, &samples(1));
        assert_eq!(found.statistics.primary, expected, "{gaze:?}");
    }
}
