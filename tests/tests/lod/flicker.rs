//! What a gaze that moves smoothly changes on the walls while nothing else
//! does. Plain tracing would change nothing; what it changes when the head
//! moves as smoothly says how much that is.

use super::{GAZES, empty_scene, frame, level, levels, lod, places, samples, views};
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

const FRAMES: usize = 60;

/// As the display shows it, with what is known of each pixel.
#[derive(Clone, Copy)]
struct Shown {
    codes: [u8; 3],
    is_traced: bool,
    is_hit: bool,
}

/// What is rendered again and again: a scene with nothing behind it, where
/// what covers a pixel hits something, and what is then put behind.
struct Stage<'s> {
    cut_out: CoreScene<'s, 8>,
    background: CoreScene<'s, 8>,
    side: u32,
}

impl Stage<'_> {
    fn shown(&self, observer: &Observer) -> Vec<Shown> {
        let (size, options) = ([self.side; 2], samples(1));
        let render = |scene| frame(scene, size, slice::from_ref(observer), &options).pictures;
        let (found, behind) = (render(&self.cut_out), render(&self.background));
        let views = views(size, slice::from_ref(observer));
        let mut all = Vec::with_capacity(views.len() * (self.side * self.side) as usize);
        for (number, (view, _)) in views.iter().enumerate() {
            for at in places(view) {
                let of = |pictures: &[shisen::render::WallPicture]| {
                    pictures[number].picture.pixel(at.0, at.1).expect("a pixel")
                };
                let (seen, behind) = (of(&found), of(&behind));
                assert!(seen[3] == 0.0 || seen[3] == 1.0, "it is no glass");
                let is_hit = seen[3] == 1.0;
                let [red, green, blue, _] = if is_hit { seen } else { behind };
                let lod = observer.lod.as_ref();
                all.push(Shown {
                    codes: [red, green, blue].map(srgb_from_linear),
                    is_traced: lod.is_none_or(|lod| level(lod, view, at) > 0.0),
                    is_hit,
                });
            }
        }
        all
    }

    /// How many traced pixels hit something and have a traced neighbour that
    /// does not, or the other way round.
    fn silhouette(&self, shown: &[Shown]) -> usize {
        let side = self.side as usize;
        let walls = shown.chunks_exact(side * side);
        let is_on_it = |wall: &[Shown], number: usize| {
            let (x, y) = (number % side, number / side);
            let mut around = Vec::new();
            around.extend((x > 0).then(|| number - 1));
            around.extend((x + 1 < side).then(|| number + 1));
            around.extend((y > 0).then(|| number - side));
            around.extend((y + 1 < side).then(|| number + side));
            let differs =
                |&other: &usize| wall[other].is_traced && wall[other].is_hit != wall[number].is_hit;
            wall[number].is_traced && around.iter().any(differs)
        };
        walls
            .map(|wall| {
                let all = 0..wall.len();
                all.filter(|&number| is_on_it(wall, number)).count()
            })
            .sum()
    }
}

/// What changes from one frame to the next, among pixels traced in both.
#[derive(Debug, Clone, Copy)]
struct Change {
    /// Mean over pixels and channels, in codes of 0 to 255.
    mean: f64,
    /// Pixels that hit something in one frame only, as a share of those along
    /// silhouettes.
    flips: f64,
}

impl Change {
    fn between(stage: &Stage<'_>, before: &[Shown], after: &[Shown]) -> Self {
        let (mut sum, mut pixels, mut flips) = (0.0, 0, 0);
        for (a, b) in before.iter().zip(after) {
            if a.is_traced && b.is_traced {
                pixels += 1;
                flips += u32::from(a.is_hit != b.is_hit);
                for (a, b) in a.codes.iter().zip(b.codes) {
                    sum += f64::from(a.abs_diff(b));
                }
            }
        }
        Self {
            mean: sum / f64::from(3 * pixels),
            flips: f64::from(flips) / stage.silhouette(before) as f64,
        }
    }
}

/// A sequence's changes.
struct Changes {
    mean: f64,
    median: f64,
    most: f64,
    flips: f64,
    most_flips: f64,
}

impl Changes {
    fn of(
        name: &str,
        stage: &Stage<'_>,
        frames: usize,
        observer: impl Fn(f64) -> Observer,
    ) -> Self {
        let mut changes = Vec::new();
        let mut before = stage.shown(&observer(0.0));
        let silhouette = stage.silhouette(&before);
        for number in 1..frames {
            let after = stage.shown(&observer(number as f64));
            changes.push(Change::between(stage, &before, &after));
            before = after;
        }
        let mut means: Vec<f64> = changes.iter().map(|change| change.mean).collect();
        means.sort_by(f64::total_cmp);
        let count = changes.len();
        let flips = changes.iter().map(|change| change.flips);
        let found = Self {
            mean: means.iter().sum::<f64>() / count as f64,
            median: means[count / 2],
            most: means[count - 1],
            flips: flips.clone().sum::<f64>() / count as f64,
            most_flips: flips.fold(0.0, f64::max),
        };
        println!(
            "{name}: a frame changes {:.4} of 255 a pixel, median {:.4}, at most {:.4}; \
             of {silhouette} pixels along silhouettes {:.3} %, at most {:.3} %",
            found.mean,
            found.median,
            found.most,
            100.0 * found.flips,
            100.0 * found.most_flips
        );
        found
    }
}

/// Along X and down, so that the border of the central field crosses animals
/// on two walls.
fn turned(number: f64) -> Vec3 {
    let yaw = DQuat::from_axis_angle(DVec3::new(0.2, -1.0, 0.1).normalize(), radians(number));
    (yaw * DVec3::new(-0.1, -0.15, -1.0)).as_vec3()
}

/// A quarter of a degree a frame.
fn radians(number: f64) -> f64 {
    (0.25 * number).to_radians()
}

fn assert_steady(name: &str, scene: &Scene, side: u32) {
    let mut cut_out = scene.clone();
    cut_out.background.alpha = 0.0;
    let cut_out = Baked::with_levels(&cut_out, &levels()).expect("a scene");
    let background = Baked::new(&empty_scene(scene.background)).expect("a scene");
    // Once: a scene is checked whenever it is taken out of its bytes.
    let stage = Stage {
        cut_out: cut_out.scene(),
        background: background.scene(),
        side,
    };
    let still = Observer::new(Eye::Centre, DVec3::ZERO);
    let gaze = Changes::of(&format!("{name}, gaze moves"), &stage, FRAMES, |number| {
        Observer {
            lod: Some(lod((turned(number), GAZES[0].1))),
            ..still
        }
    });
    // What is 3 m away then moves as far, seen from the eye, as the line of
    // sight does above. Some frames are enough: they are much alike.
    let head = Changes::of(
        &format!("{name}, plain, head moves"),
        &stage,
        10,
        |number| {
            let place = DVec3::X * (3.0 * radians(number - 5.0).tan());
            Observer::new(Eye::Centre, place)
        },
    );
    let none = Changes::of(&format!("{name}, plain, nothing moves"), &stage, 2, |_| {
        still
    });
    assert_eq!((none.most, none.most_flips), (0.0, 0.0));
    println!("{name}: {:.4} of the head's changes", gaze.mean / head.mean);
    // It does change something, or nothing was measured.
    assert!(gaze.mean > 0.0);
    assert!(gaze.mean <= MEAN && gaze.most <= MOST, "{name}");
    assert!(
        gaze.flips <= FLIPS && gaze.most_flips <= MOST_FLIPS,
        "{name}"
    );
    assert!(gaze.mean < 0.1 * head.mean && gaze.flips < 0.1 * head.flips);
    // Where next to nothing changes, three times as much is no pop.
    let least = 0.05 * head.median;
    assert!(gaze.most <= (4.0 * gaze.median).max(least), "a frame pops");
}

/// A frame's mean change of a pixel, in codes of 0 to 255: of all frames, and
/// of the one that changes most.
const MEAN: f64 = 0.06;
const MOST: f64 = 0.12;

/// The share of pixels along silhouettes that a frame moves: of all frames,
/// and of the one that moves most.
const FLIPS: f64 = 0.001;
const MOST_FLIPS: f64 = 0.005;

#[test]
fn a_smoothly_moving_gaze_makes_nothing_flicker() {
    let side = cases("pixels a side, 60 frames", 80, 256) as u32;
    for (name, mesh) in meshes() {
        // Mirrors and clay.
        for which in [PaperScene::A, PaperScene::B] {
            let scene = paper_scene(which, mesh.clone()).expect("a scene");
            assert_steady(&format!("{name}, {}, {side}²", which.name()), &scene, side);
        }
    }
}
