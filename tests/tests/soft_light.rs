//! Rectangles of light against closed forms: the form factor of a rectangle for
//! a small patch that faces it, whole and behind an edge.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Light, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Mode, Renderer, View};
use shisen_tests::scenes::{self, empty, object};
use shisen_tests::ways;
use std::f64::consts::PI;

/// Half the sides of the light, along x and along z: metres.
const HALF: [f64; 2] = [0.6, 0.4];
/// Height of the light above the floor: metres.
const HEIGHT: f64 = 2.0;
const REFLECTANCE: f64 = 0.5;
const RADIANCE: f64 = 3.0;
/// Pixels a side of a picture of one place.
const SIDE: u32 = 16;

/// Returns what a patch sees of a rectangle that is parallel to it, one corner straight
/// above it, `a` by `b` at distance 1: the share of all that it could see
/// (Howell's catalogue, B-4). Odd in both.
fn corner(a: f64, b: f64) -> f64 {
    let part = |a: f64, b: f64| {
        let root = (1.0 + a * a).sqrt();
        a / root * (b / root).atan()
    };
    (part(a, b) + part(b, a)) / (2.0 * PI)
}

/// Returns the share that a patch at (x, z) below sees of [x0, x1] × [z0, z1].
fn form_factor([x, z]: [f64; 2], [x0, x1]: [f64; 2], [z0, z1]: [f64; 2], height: f64) -> f64 {
    let to = |a: f64, b: f64| corner((a - x) / height, (b - z) / height);
    to(x1, z1) - to(x0, z1) - to(x1, z0) + to(x0, z0)
}

/// Returns a square that looks up.
fn square(centre: DVec3, side: f64) -> Object {
    let map = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(side));
    Object {
        smooth: true,
        ..object(Shape::Mesh(0), 0, map)
    }
}

/// Returns a floor below a light, `samples` points of which are looked at.
fn scene(samples: u32, two_sided: bool) -> Scene {
    Scene {
        meshes: vec![TriangleMesh::square()],
        materials: vec![Material {
            diffuse: [REFLECTANCE as f32; 3],
            ..Material::default()
        }],
        objects: vec![square(DVec3::ZERO, 40.0)],
        lights: vec![Light::Rectangle {
            centre: DVec3::new(0.0, HEIGHT, 0.0),
            right: DVec3::new(-HALF[0], 0.0, 0.0),
            up: DVec3::new(0.0, 0.0, -HALF[1]),
            colour: [RADIANCE as f32; 3],
            samples,
            two_sided,
        }],
        ambient: [0.0; 3],
        ..empty()
    }
}

/// Many pixels of one place, which is seen from below the light at a slant.
fn pixels(scene: &Scene, place: DVec3) -> Vec<f64> {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let settings = ways::settings(Mode::Tile, 1);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    let eye = place + DVec3::new(0.0, place.y.signum() * 0.4 + 0.5, 0.7);
    let (right, down) = (Vec3::X * 1e-6, Vec3::Y * -1e-6);
    let first = (place - eye).as_vec3();
    let view = View::new(eye.as_vec3(), first, right, down, [SIDE; 2]).expect("a view");
    let pixels = scenes::pixels(&renderer, &view);
    pixels.iter().map(|pixel| f64::from(pixel.green)).collect()
}

fn mean(pixels: &[f64]) -> f64 {
    pixels.iter().sum::<f64>() / pixels.len() as f64
}

fn rms_error(pixels: &[f64], expected: f64) -> f64 {
    let squares: Vec<f64> = pixels.iter().map(|p| (p - expected).powi(2)).collect();
    mean(&squares).sqrt()
}

#[test]
fn energy_is_that_of_the_form_factor() {
    // A patch that sees nothing else, by the integral over the hemisphere.
    let everything = form_factor([0.0; 2], [-1e6, 1e6], [-1e6, 1e6], 1.0);
    assert!((everything - 1.0).abs() < 1e-5);
    let sides = [[-HALF[0], HALF[0]], [-HALF[1], HALF[1]]];
    let mut before = f64::INFINITY;
    for samples in [1, 4, 16, 64] {
        let scene = scene(samples, false);
        let mut worst = 0f64;
        for (x, z) in [(0.0, 0.0), (0.5, -0.3), (2.0, 1.0), (-5.0, 0.2)] {
            let expected = REFLECTANCE * RADIANCE * form_factor([x, z], sides[0], sides[1], HEIGHT);
            let found = pixels(&scene, DVec3::new(x, 0.0, z));
            let off = (mean(&found) / expected - 1.0).abs();
            let rms = rms_error(&found, expected) / expected;
            // Four deviations of a mean of 256.
            assert!(off < 0.25 * rms + 1e-4, "{samples} at {x}, {z}: {off}");
            worst = worst.max(rms);
        }
        // Strata: faster than the square root of their number.
        assert!(worst < 0.45 * before, "{samples}: {worst} after {before}");
        before = worst;
    }
    assert!(before < 6e-3, "{before}");
}

#[test]
fn a_penumbra_is_as_wide_and_as_dark_as_geometry_says() {
    let mut errors = Vec::new();
    for samples in [1, 4, 16, 64] {
        let mut scene = scene(samples, false);
        // Half-way up, with an edge along z at x = 0.
        scene
            .objects
            .push(square(DVec3::new(-10.0, 0.5 * HEIGHT, 0.0), 20.0));
        let full = form_factor([0.0; 2], [-HALF[0], HALF[0]], [-HALF[1], HALF[1]], HEIGHT);
        let full = REFLECTANCE * RADIANCE * full;
        let mut worst = 0f64;
        for tenth in -12..=12 {
            let x = f64::from(tenth) / 10.0 * HALF[0];
            // The edge hides what is left of its picture in the light's plane.
            let from = (-x).clamp(-HALF[0], HALF[0]);
            let share = form_factor([x, 0.0], [from, HALF[0]], [-HALF[1], HALF[1]], HEIGHT);
            let expected = REFLECTANCE * RADIANCE * share;
            let found = pixels(&scene, DVec3::new(x, 0.0, 0.0));
            let off = (mean(&found) - expected).abs() / full;
            let tolerance = 0.08 / f64::from(samples);
            assert!(off < tolerance, "{samples} at {x}: {off}");
            if x < -HALF[0] {
                assert_eq!(mean(&found), 0.0, "in the umbra at {x}");
            }
            worst = worst.max(rms_error(&found, expected) / full);
        }
        errors.push(worst);
    }
    assert!(
        errors.windows(2).all(|pair| pair[1] < 0.62 * pair[0]),
        "{errors:?}"
    );
    assert!(errors[3] < 0.05, "{errors:?}");
}

#[test]
fn light_goes_to_one_side_or_to_both() {
    let [below, behind, both] =
        [(false, false), (false, true), (true, true)].map(|(two_sided, is_turned)| {
            let mut scene = scene(16, two_sided);
            if let Light::Rectangle { up, .. } = &mut scene.lights[0]
                && is_turned
            {
                *up = -*up;
            }
            mean(&pixels(&scene, DVec3::ZERO))
        });
    assert!(below > 0.01);
    assert_eq!(behind, 0.0);
    assert!((below - both).abs() < 0.02 * below, "{below}, {both}");
}
