//! Measures how much the picture changes when only the gaze moves. In plain
//! tracing nothing would change; its change under an equal movement of the head
//! is the scale.

use super::{GAZES, frame, level, levels, lod, places, samples, views};
use glam::{DQuat, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::cave::Eye;
use shisen::picture::srgb_from_linear;
use shisen::render::Observer;
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::scene::Scene as CoreScene;
use shisen_tests::meshes::meshes;
use shisen_tests::sizes::cases;
use std::slice;

const FRAMES: usize = 40;

/// A displayed pixel: its sRGB codes, and whether it is traced.
type Shown = ([u8; 3], bool);

struct Stage<'s> {
    scene: CoreScene<'s, 8>,
    side: u32,
}

impl Stage<'_> {
    fn shown(&self, observer: &Observer) -> Vec<Shown> {
        let size = [self.side; 2];
        let eyes = slice::from_ref(observer);
        let pictures = frame(self.scene, size, eyes, &samples(1)).pictures;
        let mut all = Vec::new();
        for ((view, _), picture) in views(size, eyes).iter().zip(pictures) {
            for at in places(view) {
                let [red, green, blue, _] = picture.picture.pixel(at.0, at.1).expect("a pixel");
                let lod = observer.lod.as_ref();
                let is_traced = lod.is_none_or(|lod| level(lod, view, at) > 0.0);
                all.push(([red, green, blue].map(srgb_from_linear), is_traced));
            }
        }
        all
    }

    /// Returns the change from each frame to the next, sorted: the mean over the channels of the
    /// pixels traced in both, in codes of 0 to 255.
    fn changes(&self, frames: usize, observer: impl Fn(f64) -> Observer) -> Vec<f64> {
        let shown: Vec<_> = (0..frames)
            .map(|number| self.shown(&observer(number as f64)))
            .collect();
        let change = |pair: &[Vec<Shown>]| {
            let both = pair[0].iter().zip(&pair[1]).filter(|(a, b)| a.1 && b.1);
            let (mut sum, mut count) = (0.0, 0);
            for (a, b) in both.flat_map(|(a, b)| a.0.into_iter().zip(b.0)) {
                sum += f64::from(a.abs_diff(b));
                count += 1;
            }
            sum / f64::from(count)
        };
        let mut changes: Vec<f64> = shown.windows(2).map(change).collect();
        changes.sort_by(f64::total_cmp);
        changes
    }
}

/// Returns the gaze of a frame, which moves along X and down, so that the border
/// of the central field crosses animals on two walls.
fn turned(number: f64) -> Vec3 {
    let yaw = DQuat::from_axis_angle(DVec3::new(0.2, -1.0, 0.1).normalize(), radians(number));
    (yaw * DVec3::new(-0.1, -0.15, -1.0)).as_vec3()
}

/// Returns the gaze's angle in a frame: a quarter of a degree each.
fn radians(number: f64) -> f64 {
    (0.25 * number).to_radians()
}

fn assert_steady(name: &str, scene: &Scene, side: u32) {
    let baked = Baked::with_levels(scene, &levels()).expect("a scene");
    let stage = Stage {
        scene: baked.scene(),
        side,
    };
    let still = Observer::new(Eye::Centre, DVec3::ZERO);
    let gaze = stage.changes(FRAMES, |number| Observer {
        lod: Some(lod((turned(number), GAZES[0].1))),
        ..still
    });
    // An object 3 m away then moves by the same angle, seen from the eye, as the
    // line of sight above. Few frames are enough: their changes are alike.
    let head = stage.changes(10, |number| {
        let place = DVec3::X * (3.0 * radians(number - 5.0).tan());
        Observer::new(Eye::Centre, place)
    });
    assert_eq!(stage.changes(2, |_| still), [0.0]);
    let mean = |changes: &[f64]| changes.iter().sum::<f64>() / changes.len() as f64;
    let median = |changes: &[f64]| changes[changes.len() / 2];
    let most = gaze[gaze.len() - 1];
    println!(
        "{name}: {:.4}, at most {most:.4}; head {:.4}",
        mean(&gaze),
        mean(&head)
    );
    // The picture must change, or nothing was measured.
    assert!(
        mean(&gaze) > 0.0 && mean(&gaze) <= MEAN && most <= MOST,
        "{name}"
    );
    assert!(mean(&gaze) < 0.1 * mean(&head), "{name}");
    // Where hardly anything changes, three times that is not visible.
    assert!(
        most <= (4.0 * median(&gaze)).max(0.05 * median(&head)),
        "a frame pops"
    );
}

/// Returns the mean of the changes, and the largest, in codes of 0 to 255.
const MEAN: f64 = 0.06;
const MOST: f64 = 0.12;

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn a_smoothly_moving_gaze_makes_nothing_flicker() {
    let side = cases("pixels a side", 64, 128) as u32;
    for (name, mesh) in meshes() {
        // Mirrors and clay.
        for which in [PaperScene::A, PaperScene::B] {
            let scene = paper_scene(which, mesh.clone()).expect("a scene");
            assert_steady(&format!("{name}, {}, {side}²", which.name()), &scene, side);
        }
    }
}
