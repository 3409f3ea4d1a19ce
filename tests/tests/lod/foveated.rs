//! Detail as large as the eye sees: one frame whatever renders it, no holes, and thin things, edges
//! and shadows as many samples show them.

use super::{GAZES, direction, eyes, frame, mixed_scene, places, room, views};
use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use shisen::bake::Baked;
use shisen::cave::{BuiltInCave, Cave, Eye};
use shisen::live::FOVEA;
use shisen::picture::srgb_from_linear;
use shisen::render::{self, Observer, Options};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Pattern, Texture};
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, LARGEST_UNIT, Mode, Outcome, Pixel, Renderer, TileJob, View, Workspace,
};
use shisen_core::gaze::{Acuity, LineOfSight};
use shisen_tests::meshes::{gridded_cube, icosphere};
use shisen_tests::rays::Random;
use shisen_tests::scenes::{bits, both_eyes, empty, object, pixels_with, sphere, tile};
use shisen_tests::ways::{options, settings};
use std::array::from_fn;
use std::f64::consts::TAU;

const SIDE: u32 = 256;

/// How many times as fast acuity falls on a wall of [`SIDE`]² pixels, for the sizes of one of 1024².
const STEEPER: f32 = 4.0;

fn sight((forward, up): (Vec3, Vec3)) -> LineOfSight {
    LineOfSight::new(Vec3::ZERO, forward, up).expect("a line of sight")
}

/// Returns both eyes, whose acuity falls `times` as fast as usual.
fn foveated(gaze: (Vec3, Vec3), times: f32) -> [Observer; 2] {
    let seen = (sight(gaze), Acuity::GUENTER.steeper(times));
    both_eyes().map(|eye| Observer::foveated(eye.eye, eye.place, seen, 0.0))
}

fn renderer<'a>(baked: &'a Baked<8>, samples: u16, eye: &Observer) -> Renderer<'a> {
    let settings = settings(Mode::Tile, samples);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    match eye.foveation {
        Some(foveation) => renderer.with_foveation(foveation.sight, foveation.acuity),
        None => renderer,
    }
}

fn placed(scale: impl Into<DVec3>, turn: DQuat, place: impl Into<DVec3>) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(scale.into(), turn, place.into())
}

/// Returns a scene with a square (mesh 0), lights and materials: 0 and 1 checkered, 2 black, then
/// white, orange and a mirror.
fn furnished(light: Light, repeats: [[f32; 2]; 2]) -> Scene {
    let checkered = repeats.map(|repeats| Material {
        texture: Some(Texture::new(
            Pattern::Checker([[0.8; 3], [0.3, 0.3, 0.35]]),
            repeats,
        )),
        ..Material::default()
    });
    let plain = [[0.03; 3], [0.9, 0.85, 0.8], [0.85, 0.4, 0.05], [0.1; 3]];
    let mut plain = plain.map(|diffuse| Material {
        diffuse,
        ..Material::default()
    });
    plain[3].mirror = [0.8; 3];
    Scene {
        meshes: vec![TriangleMesh::square(), gridded_cube(1), icosphere(3)],
        materials: checkered.into_iter().chain(plain).collect(),
        lights: vec![light],
        background: Background {
            zenith: [0.25, 0.45, 0.85],
            horizon: [0.9, 0.9, 0.85],
            nadir: [0.12, 0.2, 0.08],
            alpha: 1.0,
        },
        ambient: [0.1, 0.1, 0.12],
        ..empty()
    }
}

fn sun() -> Light {
    Light::Directional {
        direction: DVec3::new(0.4, -1.0, -0.6),
        colour: [0.9; 3],
    }
}

/// Returns a place so many degrees off the front wall's middle, `distance` behind it.
fn place(random: &mut Random, (least, most): (f64, f64), distance: f64) -> DVec3 {
    let (y, x) = random.range(0.0, TAU).sin_cos();
    let out = random.range(least, most).to_radians().tan();
    DVec3::new(out * x, out * y, -1.0) * distance
}

/// Returns half the width of something 0.3 to 3 pixels wide.
fn half_width(random: &mut Random, distance: f64) -> f64 {
    random.range(0.3, 3.0) * distance / f64::from(SIDE)
}

fn needle(random: &mut Random, degrees: (f64, f64)) -> Object {
    let distance = random.range(2.6, 5.0);
    let shape = Shape::Spheroid {
        equatorial_radius: half_width(random, distance) as f32,
        polar_radius: random.range(0.1, 0.4) as f32,
    };
    let turn = DQuat::from_rotation_z(random.range(0.0, 3.0));
    let centre = place(random, degrees, distance);
    object(shape, 2, DAffine3::from_rotation_translation(turn, centre))
}

/// Returns a scene, and thin dark things for it: balls over bent ground, and needles.
fn needles() -> (Scene, Vec<Object>) {
    let light = Light::Point {
        position: DVec3::new(2.5, 4.0, 1.0),
        colour: [1.0; 3],
        inverse_square: false,
    };
    let mut scene = furnished(light, [[30.0, 20.0]; 2]);
    let ground = Shape::Spheroid {
        equatorial_radius: 14.0,
        polar_radius: 0.4,
    };
    let below = DAffine3::from_translation(DVec3::new(0.0, -1.8, -6.0));
    scene.objects = vec![object(ground, 3, below)];
    let random = &mut Random::new(7);
    for number in 0..30 {
        let (distance, radius) = (random.range(2.6, 6.0), random.range(0.02, 0.25) as f32);
        let centre = place(random, (0.0, 45.0), distance);
        scene.objects.push(sphere(radius, 3 + number % 3, centre));
    }
    (
        scene,
        (0..150).map(|_| needle(random, (14.0, 45.0))).collect(),
    )
}

/// Does the same: balls of polygons between a checkered floor and wall, and pickets.
fn pickets() -> (Scene, Vec<Object>) {
    let mut scene = furnished(sun(), [[40.0, 16.0], [50.0, 14.0]]);
    let floor = placed([14.0, 1.0, 6.0], DQuat::IDENTITY, [0.0, -1.5, -4.0]);
    let wall = placed(
        [14.0, 1.0, 4.0],
        DQuat::from_rotation_x(1.5),
        [0.0, 0.4, -5.5],
    );
    let on_square = |material, at| object(Shape::Mesh(0), material, at);
    scene.objects = vec![on_square(0, floor), on_square(1, wall)];
    let random = &mut Random::new(11);
    for _ in 0..16 {
        let (distance, radius) = (random.range(3.0, 5.0), random.range(0.05, 0.25));
        let centre = place(random, (0.0, 40.0), distance);
        let at = placed([radius; 3], DQuat::IDENTITY, centre);
        scene.objects.push(Object {
            smooth: true,
            ..object(Shape::Mesh(2), 4, at)
        });
    }
    let picket = |number| {
        let size = [half_width(random, 4.2), random.range(0.5, 1.5), 0.005];
        let turn = DQuat::from_rotation_z(random.range(-0.03, 0.03));
        let x = 0.14 * f64::from(number - 30);
        object(
            Shape::Mesh(1),
            2,
            placed(size, turn, [x, random.range(-0.6, 0.6), -4.2]),
        )
    };
    (scene, (0..60).map(picket).collect())
}

fn together((mut scene, thin): (Scene, Vec<Object>)) -> Scene {
    scene.objects.extend(thin);
    scene
}

/// Returns many turned cubes of flat polygons around the viewer, in a room of one colour.
fn closed_room() -> Scene {
    let mut scene = pickets().0;
    scene.lights.extend(needles().0.lights);
    scene.meshes.extend([gridded_cube(2), gridded_cube(5)]);
    let random = &mut Random::new(3);
    scene.objects = vec![object(
        Shape::Mesh(4),
        3,
        placed([7.0; 3], DQuat::from_rotation_y(0.3), [0.0; 3]),
    )];
    for _ in 0..300 {
        let [x, y, z] = from_fn(|_| random.range(0.0, TAU));
        let turn = DQuat::from_euler(EulerRot::XYZ, x, y, z);
        let centre = DVec3::from(random.direction()) * random.range(2.0, 5.0);
        scene.objects.push(object(
            Shape::Mesh(3),
            4,
            placed([random.range(0.05, 0.3); 3], turn, centre),
        ));
    }
    scene
}

#[test]
fn a_frame_has_one_hash() {
    let scenes = [
        mixed_scene(icosphere(3)),
        together(needles()),
        together(pickets()),
        closed_room(),
    ];
    let mut faults = Vec::new();
    for (number, scene) in scenes.iter().enumerate() {
        let fast = Baked::<8>::new(scene).expect("a scene");
        let compact = Baked::<4>::new(scene).expect("a scene");
        for (gaze, samples) in [(GAZES[0], 1), (GAZES[4], 6)] {
            let (size, eyes) = ([61, 50], foveated(gaze, 16.0));
            let mut hashes = Vec::new();
            for (threads, side, mode, simd, wide) in [
                (1, 32, Mode::Single, Simd::PORTABLE, 8),
                (2, 8, Mode::Tile, Simd::detect(), 4),
                (1, 13, Mode::Single, Simd::PORTABLE, 4),
                (3, 64, Mode::Tile, Simd::detect(), 8),
            ] {
                let mut options = options(threads, side, mode, simd);
                options.settings.samples = samples;
                let found = if wide == 8 {
                    frame(fast.scene(), size, &eyes, &options)
                } else {
                    frame(compact.scene(), size, &eyes, &options)
                };
                hashes.push(found.hash());
                if found.hash() != hashes[0] {
                    faults.push(format!(
                        "scene {number}, {samples} samples, tiles of {side}, {wide} wide"
                    ));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn an_unknown_gaze_is_rendered_more_finely() {
    let baked = Baked::<8>::new(&closed_room()).expect("a scene");
    let [eye, _] = eyes(None);
    let seen = (sight(GAZES[0]), Acuity::GUENTER);
    let known = |widen| Observer::foveated(eye.eye, eye.place, seen, widen);
    let ahead = Some(seen.0.forward());
    assert_eq!(
        known(4.0),
        Observer { ahead, ..eye },
        "everything is traced"
    );
    let [exact, vague] = [0.0, 0.2].map(|widen| renderer(&baked, 1, &known(widen)));
    let mut finer = 0;
    for (view, _) in views([512; 2], &[eye]) {
        for (x, y) in places(&view).filter(|(x, y)| x % 8 == 0 && y % 8 == 0) {
            let units = (exact.unit(&view, x, y), vague.unit(&view, x, y));
            assert!(units.1 <= units.0, "{x} {y}: {units:?}");
            finer += u32::from(units.1 < units.0);
        }
    }
    assert!(finer > 1_000, "{finer}");
}

#[test]
fn units_are_a_quarter_of_what_the_eye_resolves() {
    let baked = Baked::<8>::new(&closed_room()).expect("a scene");
    let at_middles = |view: &View| places(view).filter(|(x, y)| x % 16 == 7 && y % 16 == 7);
    let mut units = [0; 9];
    for gaze in GAZES {
        let seen = views([1024; 2], &foveated(gaze, 1.0));
        let renderers: Vec<_> = seen
            .iter()
            .map(|(_, eye)| renderer(&baked, 1, eye))
            .collect();
        for ((view, _), renderer) in seen.iter().zip(&renderers) {
            for (x, y) in at_middles(view) {
                let unit = renderer.unit(view, x, y);
                units[unit as usize] += 1;
                assert!(unit.is_power_of_two() && unit <= LARGEST_UNIT, "{unit}");
                let [own, right, below] =
                    [(x, y), (x + 1, y), (x, y + 1)].map(|at| direction(view, at).normalize());
                let angle = own.angle_between(sight(gaze).forward());
                assert!(unit == 1 || angle > FOVEA, "{x} {y}");
                // The geometric mean of a pixel's sides, as chords.
                let pixel = ((right - own).length() * (below - own).length()).sqrt();
                let most = 0.25 * Acuity::GUENTER.least_angle(angle);
                assert!(unit == 1 || unit as f32 * pixel <= most, "{x} {y}: {unit}");
            }
        }
        // The right eye sees a direction 64 mm farther to the right on the front wall.
        let pairs: Vec<_> = at_middles(&seen[0].0)
            .filter(|(x, _)| *x < 1000)
            .map(|(x, y)| {
                let left = renderers[0].unit(&seen[0].0, x, y);
                (left, renderers[1].unit(&seen[1].0, x + 22, y))
            })
            .collect();
        let same = pairs.iter().filter(|(a, b)| a == b).count();
        assert!(20 * same > 17 * pairs.len(), "{same} of {}", pairs.len());
        assert!(pairs.iter().all(|(a, b)| a.max(b) <= &(2 * a.min(b))));
    }
    assert!(
        [1, 2, 4].iter().all(|unit| units[*unit] > 1_000),
        "{units:?}"
    );
}

#[test]
fn walls_around_the_viewer_have_no_hole() {
    let mut scene = closed_room();
    scene.background = Background {
        alpha: 0.0,
        ..Background::default()
    };
    scene.materials.truncate(1);
    (scene.lights, scene.ambient) = (Vec::new(), [1.0; 3]);
    scene.materials[0] = Material {
        diffuse: [0.25, 0.5, 0.75],
        ..Material::default()
    };
    let cube = Cave::built_in(BuiltInCave::Cube, [125; 2]).expect("a room");
    for (number, gaze) in GAZES.into_iter().enumerate() {
        // Walls finer than pixels, and coarser ones, alone.
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.1, 0.7 * number as f64, 0.2);
        scene.meshes = vec![gridded_cube([1, 3, 7, 40, 150][number])];
        scene.objects = vec![object(
            Shape::Mesh(0),
            0,
            placed([3.0; 3], turn, [0.3, 0.1, -0.2]),
        )];
        let baked = Baked::<8>::new(&scene).expect("a scene");
        let seen = render::cave(
            baked.scene().into(),
            &cube,
            &foveated(gaze, 8.0),
            &Options::default(),
            &|_, _| {},
        );
        for picture in seen.expect("a frame").pictures {
            let wrong = picture.picture.core_pixels().iter().filter(|pixel| {
                **pixel
                    != Pixel {
                        red: 0.25,
                        green: 0.5,
                        blue: 0.75,
                        alpha: 1.0,
                    }
            });
            assert_eq!(
                wrong.count(),
                0,
                "{gaze:?}, {} {}",
                picture.wall,
                picture.eye
            );
        }
    }
}

/// A facet that rises from another at a small angle hides no light from itself.
#[test]
fn a_valley_has_no_shadow_of_its_own() {
    let light = Light::Point {
        position: [0.0, 3.0, 2.0].into(),
        colour: [0.9; 3],
        inverse_square: false,
    };
    let mut scene = furnished(light, [[1.0; 2]; 2]);
    let rises = [(-4.0, 0.0), (0.3, 0.0), (4.0, 0.04)];
    let positions = rises.map(|(x, rise)| [-4.0, -1.0].map(|z| [x, rise - 1.0, z]));
    scene.meshes = vec![TriangleMesh {
        positions: positions.concat(),
        triangles: vec![[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]],
        ..TriangleMesh::default()
    }];
    scene.objects = vec![object(Shape::Mesh(0), 3, DAffine3::IDENTITY)];
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let [one, seen] = [false, true].map(|is| in_codes(&picture(&baked, 4, &eye(0, is)).0));
    let off = one.iter().zip(&seen).map(|(a, b)| (a - b).abs());
    let off = off.sum::<Vec3>() / one.len() as f32;
    assert!(off.max_element() < 1.0, "{off} codes");
}

const RINGS: [(f32, f32); 4] = [(0.0, 15.0), (15.0, 25.0), (25.0, 35.0), (35.0, 60.0)];

const FRAMES: u32 = 4;

/// Returns the eye in a frame: it slides to the right.
fn eye(frame: u32, is_foveated: bool) -> Observer {
    let (place, acuity) = (
        DVec3::X * 0.005 * f64::from(frame),
        Acuity::GUENTER.steeper(STEEPER),
    );
    if is_foveated {
        Observer::foveated(Eye::Centre, place, (sight(GAZES[0]), acuity), 0.0)
    } else {
        Observer::new(Eye::Centre, place)
    }
}

fn picture(baked: &Baked<8>, samples: u16, eye: &Observer) -> (Vec<Pixel>, u64) {
    let view = render::view(&room([SIDE; 2]).walls[0], eye).expect("a view");
    let mut workspace = Workspace::new();
    let pixels = pixels_with(&renderer(baked, samples, eye), &view, &mut workspace);
    (pixels, workspace.statistics.lit)
}

fn light(pixel: &Pixel) -> Vec3 {
    Vec3::new(pixel.red, pixel.green, pixel.blue)
}

/// Returns the mean of each unit's pixels.
fn averaged(pixels: &[Pixel], units: &[u32]) -> Vec<Vec3> {
    let mean = |(number, unit): (usize, &u32)| {
        let (unit, side) = (*unit as usize, SIDE as usize);
        let (x, y) = (number % side / unit * unit, number / side / unit * unit);
        let all = (0..unit * unit).map(|n| light(&pixels[(y + n / unit) * side + x + n % unit]));
        all.sum::<Vec3>() / (unit * unit) as f32
    };
    units.iter().enumerate().map(mean).collect()
}

fn codes(lights: &[Vec3]) -> Vec<Vec3> {
    lights
        .iter()
        .map(|light| {
            Vec3::from(
                light
                    .to_array()
                    .map(|light| f32::from(srgb_from_linear(light))),
            )
        })
        .collect()
}

fn in_codes(pixels: &[Pixel]) -> Vec<Vec3> {
    codes(&pixels.iter().map(light).collect::<Vec<_>>())
}

/// What is compared of a scene, by rings.
struct Rings(Vec<usize>);

impl Rings {
    fn mean(&self, of: impl Fn(usize) -> f32) -> [f32; 4] {
        from_fn(|ring| {
            let all = || (0..self.0.len()).filter(|n| self.0[*n] == ring);
            all().map(&of).sum::<f32>() / all().count() as f32
        })
    }
}

#[test]
fn hard_scenes_look_as_with_many_samples() {
    let of_eye = eye(0, true);
    let view = render::view(&room([SIDE; 2]).walls[0], &of_eye).expect("a view");
    let ring = |at| {
        let angle = direction(&view, at).angle_between(Vec3::NEG_Z).to_degrees();
        RINGS
            .iter()
            .position(|ring| angle < ring.1)
            .expect("a ring")
    };
    let rings = Rings(places(&view).map(ring).collect());
    let [pb, nb] = [pickets().0, needles().0];
    for (name, bare, full, most_lit) in [
        ("needles", nb, together(needles()), 0.6),
        ("pickets", pb, together(pickets()), 0.5),
    ] {
        let bare = Baked::<8>::new(&bare).expect("a scene");
        let baked = Baked::<8>::new(&full).expect("a scene");
        let sizes = renderer(&baked, 1, &of_eye);
        let units: Vec<u32> = places(&view)
            .map(|(x, y)| sizes.unit(&view, x, y))
            .collect();
        let frames = |samples, foveated| -> Vec<_> {
            (0..FRAMES)
                .map(|frame| picture(&baked, samples, &eye(frame, foveated)))
                .collect()
        };
        let (truth, one, seen) = (frames(16, false), frames(1, false), frames(1, true));
        assert!(picture(&baked, 1, &of_eye) == seen[0], "a still eye");
        let lit = [&one, &seen].map(|frames| frames[0].1);
        let share = lit[1] as f64 / lit[0] as f64;
        assert!(share < most_lit, "{name}: {share} of the points lit");
        let back = averaged(&picture(&bare, 16, &eye(0, false)).0, &units);
        let of = |pixels: &[Pixel]| averaged(pixels, &units);
        let (full, found) = (of(&truth[0].0), of(&seen[0].0));
        let of = |frames: &[(Vec<Pixel>, u64)]| -> Vec<_> {
            let pictures = frames.iter().map(|frame| codes(&of(&frame.0)));
            pictures.collect()
        };
        let [truth, one, seen] = [&truth, &one, &seen].map(|frames| of(frames));
        let off =
            |of: &[Vec<Vec3>]| rings.mean(|n| (of[0][n] - truth[0][n]).abs().element_sum() / 3.0);
        let flicker = |of: &[Vec<Vec3>]| {
            rings.mean(|n| {
                let off: Vec<f32> = of
                    .iter()
                    .zip(&truth)
                    .map(|(of, truth)| (of[n] - truth[n]).element_sum() / 3.0)
                    .collect();
                let count = off.len() as f32;
                let mean = off.iter().sum::<f32>() / count;
                (off.iter().map(|off| (off - mean).powi(2)).sum::<f32>() / count).sqrt()
            })
        };
        let energy = |of: &[Vec3]| {
            rings.mean(|n| {
                let is_dark = full[n].element_sum() < 0.9 * back[n].element_sum();
                f32::from(u8::from(is_dark)) * (back[n] - of[n]).element_sum().powi(2)
            })
        };
        let (off, off_one) = (off(&seen), off(&one));
        let (flicker, flicker_one) = (flicker(&seen), flicker(&one));
        let (kept, all) = (energy(&found), energy(&full));
        println!("{name}: off {off:.2?}, one sample {off_one:.2?}");
        println!("{name}: flicker {flicker:.2?}, one sample {flicker_one:.2?}");
        println!("{name}: energy {kept:.4?} of {all:.4?}; {lit:?} points lit");
        for ring in 0..4 {
            assert!(
                off[ring] < 4.5 && off[ring] < 1.2 * off_one[ring],
                "{name}, ring {ring}"
            );
            assert!(
                flicker[ring] < 1.1 * flicker_one[ring].max(1.0),
                "{name}, ring {ring}"
            );
            assert!(kept[ring] >= 0.95 * all[ring], "{name}, ring {ring}");
        }
    }
}

#[test]
fn textures_of_what_shines_are_smooth_and_in_place() {
    let mut scene = furnished(sun(), [[40.0, 12.0]; 2]);
    scene.materials[0].specular = [0.04; 3];
    let wall = DQuat::from_rotation_x(1.5);
    let wall = placed([14.0, 1.0, 8.0], wall, [0.0, 0.4, -5.5]);
    scene.objects = vec![object(Shape::Mesh(0), 0, wall)];
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let plain = Observer::new(Eye::Centre, DVec3::ZERO);
    let seen = (sight(GAZES[0]), Acuity::GUENTER);
    let foveated = Observer::foveated(Eye::Centre, DVec3::ZERO, seen, 0.0);
    let pictures = [(16, &plain), (1, &plain), (1, &foveated)];
    let [truth, one, seen] =
        pictures.map(|(samples, eye)| in_codes(&picture(&baked, samples, eye).0));
    let off = |of: &[Vec3]| -> Vec3 { of.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum() };
    let [one, seen] = [&one, &seen].map(|of| off(of).element_sum());
    assert!(seen < 0.6 * one, "{seen} codes, {one} of one sample");
}

/// Renders a tile in calls of `budget`.
fn in_calls(renderer: &Renderer<'_>, view: &View, budget: Budget) -> (Vec<Pixel>, u32) {
    let (width, height) = (view.columns(), view.rows());
    let mut pixels = vec![Pixel::default(); (width * height) as usize];
    let (mut job, mut workspace) = (TileJob::new(tile([0, 0, width, height])), Workspace::new());
    for calls in 1.. {
        let mut budget = budget;
        let outcome = job.render(renderer, view, &mut pixels, &mut budget, &mut workspace);
        if outcome == Ok(Outcome::Finished) {
            return (pixels, calls);
        }
    }
    unreachable!("the calls have an end")
}

#[test]
fn ten_thousand_needles_in_a_tile_are_rendered_step_by_step() {
    let (mut scene, _) = needles();
    let random = &mut Random::new(5);
    scene
        .objects
        .extend((0..10_000).map(|_| needle(random, (0.0, 20.0))));
    let baked = Baked::<8>::new(&scene).expect("a scene");
    let view = render::view(&room([64; 2]).walls[0], &eye(0, true)).expect("a view");
    let [seen, one, truth] = [(1, true), (1, false), (16, false)]
        .map(|(samples, is_foveated)| renderer(&baked, samples, &eye(0, is_foveated)));
    let (whole, _) = in_calls(&seen, &view, Budget::UNLIMITED);
    let (parts, calls) = in_calls(&seen, &view, Budget::steps(1));
    assert!(bits(&whole) == bits(&parts) && calls >= 4, "{calls} calls");
    let truth = in_calls(&truth, &view, Budget::UNLIMITED).0;
    let off = |of: &[Pixel]| {
        of.iter()
            .zip(&truth)
            .map(|(of, truth)| (light(of) - light(truth)).abs().element_sum())
            .sum::<f32>()
    };
    let off = [
        off(&whole),
        off(&in_calls(&one, &view, Budget::UNLIMITED).0),
    ];
    println!("{off:?} off");
    assert!(off[0] < 0.8 * off[1]);
}
