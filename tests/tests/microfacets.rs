//! Metal and rough surfaces against the textbook's formulas in f64, and against energy's conservation.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::scene::material::{Material, Microfacets};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Background, Light, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object};
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

const GOLD: Vec3 = Vec3::new(0.9, 0.6, 0.2);

/// Returns a floor of microfacets in the dark.
fn floor(base: Vec3, metalness: f32, roughness: f32) -> Scene {
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    scene.meshes = vec![TriangleMesh::square()];
    scene.objects = vec![object(Shape::Mesh(0), 0, DAffine3::IDENTITY)];
    scene.materials = vec![Material {
        diffuse: base.to_array(),
        specular: [0.04; 3],
        microfacets: Some(Microfacets {
            metalness,
            roughness,
            texture: None,
        }),
        ..Material::default()
    }];
    scene
}

/// Returns what is seen of the floor from a direction.
fn seen(scene: &Scene, from: DVec3, depth: u8) -> Vec3 {
    let Paths { fast, compact } = Paths::new(scene);
    let at = Vec3::new(0.1, 0.0, 0.2);
    let ray = Ray::new(at + from.as_vec3(), -from.as_vec3()).expect("a ray");
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let fast = Tracer::new(fast.scene(), Simd::detect(), depth);
    let compact = Tracer::new(compact.scene(), Simd::PORTABLE, depth);
    let found = fast.radiance(&ray, &mut budget, &mut workspace);
    let other = compact.radiance(&ray, &mut budget, &mut workspace);
    assert_eq!(found, other);
    Vec3::new(found.red, found.green, found.blue)
}

/// Returns a direction above the floor.
fn towards(sine: f64, turn: f64) -> DVec3 {
    DVec3::new(
        sine * turn.cos(),
        (1.0 - sine * sine).max(0.0).sqrt(),
        sine * turn.sin(),
    )
}

/// Calls `met` with each of the directions from which a lobe of this α mirrors light towards
/// `eye`, and its solid angle.
fn lobe(alpha: f64, eye: DVec3, mut met: impl FnMut(DVec3, f64)) {
    const SIDE: usize = 96;
    // The normals of the microfacets, by the share of them that is steeper.
    let cosine = |share: f64| (share / (1.0 + (alpha * alpha - 1.0) * (1.0 - share))).sqrt();
    for row in 0..SIDE {
        let at = |place: f64| cosine((1.0 - place / SIDE as f64).powi(4));
        let place = row as f64;
        let (from, middle, to) = (at(place), at(place + 0.5), at(place + 1.0));
        for column in 0..SIDE {
            let turn = TAU * (column as f64 + 0.5) / SIDE as f64;
            let facet = towards((1.0 - middle * middle).sqrt(), turn);
            let facing = facet.dot(eye);
            let light = 2.0 * facing * facet - eye;
            if facing > 0.0 && light.y > 0.0 {
                met(light, 4.0 * facing * (from - to) * TAU / SIDE as f64);
            }
        }
    }
}

#[test]
fn a_white_furnace_is_neither_dimmed_nor_heated() {
    for (roughness, least) in [
        (0.1, 0.97),
        (0.3, 0.97),
        (0.5, 0.97),
        (0.75, 0.9),
        (1.0, 0.9),
    ] {
        for cosine in [0.2, 0.5, 0.8, 1.0] {
            let eye = towards((1.0_f64 - cosine * cosine).sqrt(), 0.7);
            for (metalness, depth) in [(0.0, 1), (1.0, 0), (1.0, 1)] {
                let mut scene = floor(Vec3::ONE, metalness, roughness);
                scene.ambient = [1.0; 3];
                scene.background = Background::uniform([1.0; 3]);
                let found = seen(&scene, eye, depth);
                assert!(
                    (found - 1.0).abs().max_element() < 1e-5,
                    "{roughness} {found}"
                );
            }
            let mut scene = floor(Vec3::ONE, 1.0, roughness);
            lobe(f64::from(roughness).powi(2), eye, |light, angle| {
                scene.lights.push(Light::Directional {
                    direction: -light,
                    colour: [(angle * FRAC_1_PI) as f32; 3],
                });
            });
            let found = seen(&scene, eye, 0).x;
            assert!(
                found >= least && found <= 1.002,
                "{roughness} {cosine}: {found}"
            );
        }
    }
}

/// Returns π times the light that GGX sends on, for a light of irradiance 1 on a face towards it,
/// without bounces between microfacets.
fn textbook(f0: f64, roughness: f64, light: DVec3, eye: DVec3) -> f64 {
    let squared = roughness.powi(4);
    let half = (light + eye).normalize();
    let fresnel = f0 + (1.0 - f0) * (1.0 - light.dot(half)).powi(5);
    let many = squared / (PI * (half.y * half.y * (squared - 1.0) + 1.0).powi(2));
    let hidden = |to: DVec3| {
        let tangent = (1.0 - to.y * to.y) / (to.y * to.y);
        0.5 * ((1.0 + squared * tangent).sqrt() - 1.0)
    };
    let masking = 1.0 / (1.0 + hidden(light) + hidden(eye));
    PI * fresnel * many * masking / (4.0 * light.y * eye.y) * light.y
}

#[test]
fn a_highlight_is_that_of_the_textbook() {
    let mut random = Random::new(3);
    for _ in 0..400 {
        let mut direction = || towards(random.range(0.0, 0.99), random.range(0.0, TAU));
        let (light, eye) = (direction(), direction());
        let roughness = random.range(0.1, 0.6);
        let mut scene = floor(GOLD, 1.0, roughness as f32);
        scene.lights.push(Light::Directional {
            direction: -light,
            colour: [1.0; 3],
        });
        let found = seen(&scene, eye, 0);
        for channel in 0..3 {
            // What bounces among microfacets adds up to a quarter to it.
            let expected = textbook(f64::from(GOLD[channel]), roughness, light, eye);
            let ratio = f64::from(found[channel]) / expected;
            assert!(
                (0.98..1.4).contains(&ratio),
                "{roughness} {light} {eye}: {ratio}"
            );
            let most = if roughness < 0.3 { 1.1 } else { 1.4 };
            assert!(ratio < most, "{roughness} {light} {eye}: {ratio}");
        }
    }
}

#[test]
fn rough_metal_mirrors_the_background_blurred_and_smooth_metal_what_is_there() {
    let background = Background {
        zenith: [0.2, 0.4, 0.8],
        horizon: [0.9, 0.8, 0.6],
        nadir: [0.0; 3],
        ..Background::uniform([0.0; 3])
    };
    for roughness in [0.0, 0.15, 0.45, 0.7, 1.0] {
        for cosine in [0.3, 0.7, 1.0_f64] {
            let eye = towards((1.0 - cosine * cosine).sqrt(), 2.0);
            let mut scene = floor(GOLD, 1.0, roughness);
            scene.background = background;
            let found = seen(&scene, eye, 1);
            // The same under a sky of its mean colour over the lobe.
            let (mut mean, mut all) = (Vec3::ZERO, 0.0);
            let [low, high] = [background.horizon, background.zenith].map(Vec3::from);
            // Around the direction that is mirrored, as seen head-on.
            let mirrored = towards((1.0 - cosine * cosine).sqrt(), 2.0 + PI);
            let across = mirrored.any_orthonormal_vector();
            let along = mirrored.cross(across);
            lobe(
                f64::from(roughness.max(0.01)).powi(2),
                DVec3::Y,
                |light, angle| {
                    let facets = textbook(1.0, f64::from(roughness.max(0.01)), light, DVec3::Y);
                    let to = light.y * mirrored + light.x * across + light.z * along;
                    let far = if to.y > 0.0 { high } else { Vec3::ZERO };
                    let weight = (facets * angle) as f32;
                    mean += weight * (low + (far - low) * to.y.abs() as f32);
                    all += weight;
                },
            );
            scene.background = Background::uniform((mean / all).to_array());
            let expected = seen(&scene, eye, 1);
            let difference = (found - expected).abs().max_element();
            assert!(
                difference < 0.06,
                "{roughness} {cosine}: {found}, {expected}"
            );
        }
    }
    // A room is not dark for what is rough in it.
    let mut room = floor(GOLD, 1.0, 1.0);
    room.ambient = [0.5; 3];
    assert!(seen(&room, DVec3::Y, 1).min_element() > 0.03);
}

#[test]
fn a_texture_says_where_it_is_metal_and_how_rough() {
    // Green 128 is half of the roughness, blue 51 a fifth of the metal.
    let data = Image::new(1, 1, &[[7, 128, 51]]).expect("sides");
    let mut textured = floor(GOLD, 1.0, 0.9);
    let facets = textured.materials[0].microfacets.as_mut();
    facets.expect("microfacets").texture =
        Some(Texture::new(Pattern::Image(Arc::new(data)), [1.0; 2]));
    let mut plain = floor(GOLD, 0.2, 0.9 * 128.0 / 255.0);
    for scene in [&mut textured, &mut plain] {
        scene.background = Background::uniform([0.3, 0.5, 0.7]);
        scene.lights.push(Light::Directional {
            direction: DVec3::new(0.2, -1.0, 0.3),
            colour: [1.0; 3],
        });
    }
    let eye = towards(0.3, 1.0);
    let (found, expected) = (seen(&textured, eye, 1), seen(&plain, eye, 1));
    assert!((found - expected).abs().max_element() < 1e-6);
    let baked = Baked::<8>::new(&plain).expect("a scene");
    assert!(
        baked
            .scene()
            .effects()
            .names()
            .any(|name| name == "microfacets")
    );
}
