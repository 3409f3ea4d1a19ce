//! A picture as the background, against the gradient and against means over it.

use glam::{DAffine3, Vec3};
use shisen::scene::environment::{Environment, Radiance};
use shisen::scene::material::{Material, Microfacets};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Background, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Returns the direction of a place on a picture: shares from the left and from the top.
fn direction([u, down]: [f32; 2]) -> Vec3 {
    let (sine, cosine) = (PI * down).sin_cos();
    let turn = TAU * (u - 0.5);
    Vec3::new(sine * turn.sin(), cosine, -sine * turn.cos())
}

/// Returns a floor of rough white metal in the dark, under a picture.
fn scene(height: usize, colour: impl Fn(Vec3) -> [f32; 3]) -> Scene {
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    scene.meshes = vec![TriangleMesh::square()];
    scene.objects = vec![object(Shape::Mesh(0), 0, DAffine3::IDENTITY)];
    scene.materials = vec![Material {
        diffuse: [1.0; 3],
        microfacets: Some(Microfacets {
            metalness: 1.0,
            roughness: 0.5,
            texture: None,
        }),
        ..Material::default()
    }];
    let at = |n: usize, of: usize| (n as f32 + 0.5) / of as f32;
    let width = 2 * height;
    let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let pixels = places.map(|(x, y)| colour(direction([at(x, width), at(y, height)])));
    let image = Radiance::new([width, height], pixels.collect()).expect("sides");
    scene.environment = Some(Environment {
        image: Arc::new(image),
        yaw: 0.0,
        strength: 1.0,
    });
    scene
}

/// Returns what rays see from a place.
fn seen(scene: &Scene, from: Vec3, directions: &[Vec3]) -> Vec<Vec3> {
    let Paths { fast, compact } = Paths::new(scene);
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let fast = Tracer::new(fast.scene(), Simd::detect(), 1);
    let compact = Tracer::new(compact.scene(), Simd::PORTABLE, 1);
    let mut light = |direction: &Vec3| {
        let ray = Ray::new(from, *direction).expect("a ray");
        let found = fast.radiance(&ray, &mut budget, &mut workspace);
        assert_eq!(found, compact.radiance(&ray, &mut budget, &mut workspace));
        Vec3::new(found.red, found.green, found.blue)
    };
    directions.iter().map(&mut light).collect()
}

/// Returns some directions, unit length.
fn directions(count: usize, seed: u64) -> Vec<Vec3> {
    let mut random = Random::new(seed);
    let mut part = move || random.range(-1.0, 1.0) as f32;
    let all = std::iter::repeat_with(|| Vec3::new(part(), part(), part()));
    let all = all.filter_map(Vec3::try_normalize);
    all.take(count).collect()
}

#[test]
fn a_picture_of_the_gradient_is_the_gradient() {
    let background = Background {
        zenith: [0.2, 0.4, 4.0],
        horizon: [0.9, 0.8, 0.6],
        nadir: [0.1, 0.05, 0.01],
        ..Background::uniform([0.0; 3])
    };
    let colour = |direction: Vec3| {
        let [far, level] = if direction.y > 0.0 {
            [background.zenith, background.horizon]
        } else {
            [background.nadir, background.horizon]
        };
        [0, 1, 2].map(|n| level[n] + (far[n] - level[n]) * direction.y.abs())
    };
    let picture = scene(256, colour);
    let gradient = Scene {
        environment: None,
        background,
        ..picture.clone()
    };
    let (high, away) = (Vec3::splat(1.0e3), directions(500, 1));
    let both = seen(&picture, high, &away);
    for (found, expected) in both.into_iter().zip(seen(&gradient, high, &away)) {
        let error = (found - expected).abs().max_element();
        assert!(error < expected.max_element() / 128.0, "{found} {expected}");
    }
}

#[test]
fn light_is_seen_where_it_comes_from() {
    let axes = [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    for axis in axes {
        let mut scene = scene(64, |at| [if at.dot(axis) > 0.99 { 9.0 } else { 0.0 }; 3]);
        let high = Vec3::splat(1.0e3);
        for (other, found) in axes.iter().zip(seen(&scene, high, &axes)) {
            let expected = if *other == axis { 9.0 } else { 0.0 };
            assert!(
                (found - expected).abs().max_element() < 0.04,
                "{axis} {other}: {found}"
            );
        }
        // What is in front goes to the left.
        let turned = scene.environment.as_mut().expect("a picture");
        (turned.yaw, turned.strength) = (FRAC_PI_2, 2.0);
        let left = Vec3::new(axis.z, axis.y, -axis.x);
        let found = seen(&scene, high, &[left])[0];
        assert!((found - 18.0).abs().max_element() < 0.08, "{axis}: {found}");
    }
}

#[test]
fn rough_metal_shows_the_mean_over_its_lobe() {
    let colour = |at: Vec3| {
        let wave = 0.3 * (5.0 * at.x).sin() * (4.0 * at.z).cos();
        [0.5 + wave, 0.5 + 0.5 * at.y.max(0.0), 0.4]
    };
    let mut scene = scene(128, colour);
    let around = directions(20_000, 5);
    for roughness in [0.45, 0.7, 1.0_f32] {
        scene.materials[0].microfacets = Some(Microfacets {
            metalness: 1.0,
            roughness,
            texture: None,
        });
        let squared = roughness.powi(4);
        for eye in [Vec3::Y, Vec3::new(0.5, 0.7, -0.3).normalize()] {
            let mirrored = Vec3::new(-eye.x, eye.y, -eye.z);
            let (mut mean, mut all) = (Vec3::ZERO, 0.0);
            for light in around.iter().filter(|light| light.dot(mirrored) > 0.0) {
                let cosine = light.dot(mirrored);
                // Of a facet half-way between, as many as GGX has.
                let facing = 0.5 * (1.0 + cosine);
                let many = squared / (facing * (squared - 1.0) + 1.0).powi(2);
                mean += Vec3::from(colour(*light)) * (many * cosine);
                all += many * cosine;
            }
            let found = seen(&scene, eye, &[-eye])[0];
            let uniform = Scene {
                environment: None,
                background: Background::uniform((mean / all).to_array()),
                ..scene.clone()
            };
            let expected = seen(&uniform, eye, &[-eye])[0];
            let error = (found - expected).abs().max_element();
            assert!(error < 0.06, "{roughness} {eye}: {found} {expected}");
        }
    }
}
