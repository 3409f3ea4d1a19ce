//! Frames with a level of detail: what they show, and that nothing but the scene,
//! the view and the gaze decides them.

mod cost;
pub(crate) mod cracks;
mod flicker;
mod foveated;
mod odd_scenes;
mod rungs;

use glam::{DVec3, Vec3};
use shisen::bake::simplify::PolygonLevels;
use shisen::bake::{AnyScene, Layout};
use shisen::cave::{BuiltInCave, Cave};
use shisen::render::gaze_reference::{self, Limits};
use shisen::render::{self, Frame, Observer, Options, cave};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Background, Object, Scene};
use shisen_core::frame::{Budget, LevelOfDetail, View, Workspace};
use shisen_core::gaze::Boundary;
use shisen_core::trace::Tracer;
use shisen_core::{Runs, Simd};
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::{both_eyes, empty, levels as levels_of, sphere};

/// Directions of sight, and what is up for the viewer: the paper's two, and
/// oblique ones that put borders of the field across walls and corners.
const GAZES: [(Vec3, Vec3); 5] = [
    (Vec3::NEG_Z, Vec3::Y),
    (Vec3::NEG_Y, Vec3::NEG_Z),
    (Vec3::new(0.7, -0.4, -0.6), Vec3::Y),
    (Vec3::new(-0.3, 0.2, -1.0), Vec3::new(0.5, 1.0, 0.1)),
    (Vec3::new(1.0, -0.9, 0.8), Vec3::new(-0.4, 0.3, 1.0)),
];

fn lod((forward, up): (Vec3, Vec3)) -> LevelOfDetail {
    shisen_tests::scenes::lod(Vec3::ZERO, forward, up)
}

/// 500 faces to all in as many rungs as `shisen cave` takes.
fn levels() -> PolygonLevels {
    levels_of(Layout::Fast.polygon_levels())
}

/// Returns both eyes, at the room's centre, with one line of sight or none.
fn eyes(lod: Option<LevelOfDetail>) -> [Observer; 2] {
    both_eyes().map(|eye| Observer { lod, ..eye })
}

fn frame<'s>(
    scene: impl Into<AnyScene<'s>>,
    size: [u32; 2],
    eyes: &[Observer],
    options: &Options,
) -> Frame {
    cave(scene.into(), &room(size), eyes, options, &|_, _| {}).expect("a frame")
}

fn room(size: [u32; 2]) -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, size).expect("a room")
}

fn samples(samples: u16) -> Options {
    let mut options = Options::default();
    options.settings.samples = samples;
    options
}

/// Returns the rays of each wall for each eye, in a frame's order.
fn views(size: [u32; 2], eyes: &[Observer]) -> Vec<(View, Observer)> {
    let view = |wall, eye: &Observer| (render::view(wall, eye).expect("a view"), *eye);
    let walls = room(size).walls;
    walls
        .iter()
        .flat_map(|wall| eyes.iter().map(move |eye| view(wall, eye)))
        .collect()
}

fn places(view: &View) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (columns, rows) = (view.columns(), view.rows());
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

/// Through a pixel's centre.
fn direction(view: &View, (x, y): (u32, u32)) -> Vec3 {
    view.direction(x as f32, y as f32).expect("a direction")
}

/// Returns the level of a pixel's centre.
fn level(lod: &LevelOfDetail, view: &View, at: (u32, u32)) -> f32 {
    let direction = direction(view, at);
    lod.gaze.level(direction).expect("a direction")
}

/// Returns the same line of sight in f64, by the paper's equations written once more.
fn reference((forward, up): (Vec3, Vec3)) -> gaze_reference::Gaze {
    let (forward, up) = (forward.as_dvec3(), up.as_dvec3());
    gaze_reference::Gaze::new(forward, up, Limits::PAPER, Boundary::Printed)
        .expect("a line of sight")
}

/// Returns a pixel by the reference.
fn exact_sight(gaze: &gaze_reference::Gaze, view: &View, at: (u32, u32)) -> gaze_reference::Sight {
    let direction = direction(view, at).as_dvec3();
    gaze.sight(direction).expect("a direction")
}

/// What single precision may be off: levels, and radians.
const ROUNDING: f64 = 5.0e-6;

/// Returns whether rounding decides which zone a ray is in.
fn is_on_a_border(sight: &gaze_reference::Sight) -> bool {
    let near = |radius: f64| (sight.l - radius).abs() < ROUNDING;
    near(Limits::PAPER.central) || near(sight.big_l)
}

fn bits(pixel: [f32; 4]) -> [u32; 4] {
    pixel.map(f32::to_bits)
}

/// Eight animals, and shapes without polygons among them: glass, mirrors and
/// clay in turn, smooth and flat, so that each is seen in and through others.
fn mixed_scene(mesh: TriangleMesh) -> Scene {
    let mut scene = paper_scene(PaperScene::A, mesh).expect("a scene");
    scene.background.alpha = 0.25;
    let clay = paper_scene(PaperScene::B, icosphere(0))
        .expect("a scene")
        .materials
        .remove(0);
    let glass = Material {
        diffuse: [0.0; 3],
        transmission: [0.9, 0.95, 1.0],
        absorption: [0.3, 0.2, 0.0],
        ..Material::default()
    };
    scene.materials.extend([glass, clay]);
    for (number, object) in scene.objects.iter_mut().enumerate() {
        object.smooth = number % 2 == 0;
        object.material = Some([2, 0, 1, 2, 2][number % 5]);
    }
    // Large mirrors behind the animals, a glass body before them.
    for (place, radius, material) in [
        (DVec3::new(0.0, 0.0, -7.0), 3.0, 0),
        (DVec3::new(7.5, 0.0, 0.0), 3.5, 0),
        (DVec3::new(-1.0, -6.0, 0.0), 3.0, 0),
        (DVec3::new(0.4, -0.2, -1.9), 0.3, 1),
    ] {
        scene.objects.push(sphere(radius, material, place));
    }
    scene
}

/// Returns the paper's scenes and the mixed one.
fn scenes(mesh: &TriangleMesh) -> Vec<Scene> {
    let mut scenes: Vec<Scene> = PaperScene::ALL
        .map(|which| paper_scene(which, mesh.clone()).expect("a scene"))
        .into();
    scenes.push(Scene {
        name: "mixed".into(),
        ..mixed_scene(mesh.clone())
    });
    scenes
}

/// Returns a scene with the same background and nothing that a ray from the room
/// meets.
fn empty_scene(background: Background) -> Scene {
    Scene {
        objects: vec![Object {
            material: None,
            ..sphere(1.0e-3, 0, [-1.0e5, 2.0e5, 3.0e5])
        }],
        background,
        ..empty()
    }
}

/// Returns where in its pixel each sample lies: Hammersley's points, centred.
fn offsets(samples: u16) -> Vec<(f32, f32)> {
    let bits = samples.next_power_of_two().trailing_zeros();
    let radical_inverse = |sample: u16| {
        let digits = (0..bits).map(|bit| u32::from(sample >> bit & 1) << (bits - 1 - bit));
        (digits.sum::<u32>() as f32 + 0.5) / (1u32 << bits) as f32
    };
    let along = |sample: u16| (f32::from(sample) + 0.5) / f32::from(samples);
    (0..samples)
        .map(|sample| (along(sample) - 0.5, radical_inverse(sample) - 0.5))
        .collect()
}

/// Returns a pixel, ray by ray.
fn pixel<const W: usize>(
    tracer: &Tracer<'_, W>,
    view: &View,
    (x, y): (u32, u32),
    samples: u16,
) -> [f32; 4]
where
    Simd: Runs<W>,
{
    let mut sum = [0.0; 4];
    for (dx, dy) in offsets(samples) {
        let ray = view.ray(x as f32 + dx, y as f32 + dy).expect("a ray");
        let mut budget = Budget::UNLIMITED;
        let found = tracer.radiance(&ray, &mut budget, &mut Workspace::new());
        let found = [found.red, found.green, found.blue, found.alpha];
        for (sum, found) in sum.iter_mut().zip(found) {
            *sum += found;
        }
    }
    sum.map(|sum| sum * (1.0 / f32::from(samples)))
}
