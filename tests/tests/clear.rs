//! Holes and veils by a texture's alpha, and the shadows of what light comes through.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::scene::material::{Alpha, Cover, Material, Microfacets};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::scene::EffectSet;
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object};
use std::sync::Arc;

/// Returns a square 1 m over a white floor of 100 m, under the sun, which shines straight down.
fn over_floor(cover: Material) -> Scene {
    let lift = DAffine3::from_translation(DVec3::Y);
    let floor = DAffine3::from_scale(DVec3::splat(100.0));
    let floor = object(Shape::Mesh(0), 1, floor);
    Scene {
        ambient: [0.0; 3],
        background: Background::uniform([0.0; 3]),
        meshes: vec![TriangleMesh::square()],
        materials: vec![
            cover,
            Material {
                diffuse: [1.0; 3],
                ..Material::default()
            },
        ],
        objects: vec![object(Shape::Mesh(0), 0, lift), floor],
        lights: vec![Light::Directional {
            direction: DVec3::NEG_Y,
            colour: [1.0; 3],
        }],
        ..empty()
    }
}

/// Returns what is seen from a place in a direction, on each path.
fn seen(paths: &Paths, from: DVec3, towards: DVec3) -> Vec3 {
    let ray = Ray::new(from.as_vec3(), towards.as_vec3()).expect("a ray");
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let fast = Tracer::new(paths.fast.scene(), Simd::detect(), 4);
    let compact = Tracer::new(paths.compact.scene(), Simd::PORTABLE, 4);
    let found = fast.radiance(&ray, &mut budget, &mut workspace);
    assert_eq!(found, compact.radiance(&ray, &mut budget, &mut workspace));
    Vec3::new(found.red, found.green, found.blue)
}

/// Returns an image of 8 × 8 texels, red, whose alpha is given.
fn leaf(alpha: impl Fn(usize, usize) -> u8) -> Texture {
    let texels: Vec<[u8; 4]> = (0..64)
        .map(|at| [255, 0, 0, alpha(at % 8, at / 8)])
        .collect();
    let image = Image::with_alpha(8, 8, &texels).expect("sides");
    Texture {
        nearest: true,
        ..Texture::new(Pattern::Image(Arc::new(image)), [1.0; 2])
    }
}

#[test]
fn a_leaf_covers_and_shades_what_its_alpha_says() {
    let is_there = |x: usize, y: usize| (x * x + 3 * y) % 5 < 2;
    let texture = leaf(|x, y| if is_there(x, y) { 255 } else { 80 });
    let scene = over_floor(Material {
        diffuse: [1.0; 3],
        texture: Some(texture.clone()),
        alpha: Some(Alpha {
            opacity: 1.0,
            texture: Some(texture),
            cover: Cover::Mask(0.5),
        }),
        ..Material::default()
    });
    let paths = Paths::new(&scene);
    let effects = paths.fast.scene().effects();
    assert!(effects.contains(EffectSet::ALPHA | EffectSet::CLEAR_SHADOWS));
    let mut random = Random::new(11);
    for _ in 0..4_000 {
        // 1 m along x and z, its middle at the origin; images have their first row at −z.
        let (u, v) = (random.range(0.0, 1.0), random.range(0.0, 1.0));
        let at = DVec3::new(u - 0.5, 1.0, v - 0.5);
        let covers = is_there((u * 8.0) as usize, (v * 8.0) as usize);
        let red = Vec3::X;
        let from_above = seen(&paths, at + DVec3::Y, DVec3::NEG_Y);
        assert_eq!(from_above, if covers { red } else { Vec3::ONE }, "{u} {v}");
        // The floor under it, seen from between the two.
        let on_floor = seen(&paths, at - 0.9 * DVec3::Y, DVec3::NEG_Y);
        assert_eq!(on_floor, if covers { Vec3::ZERO } else { Vec3::ONE });
    }
}

#[test]
fn a_veil_shows_and_shades_as_far_as_it_is_opaque() {
    for (alpha, opacity) in [(255, 1.0), (102, 1.0), (255, 0.3), (51, 0.5), (0, 1.0)] {
        let texture = leaf(|_, _| alpha);
        let scene = over_floor(Material {
            diffuse: [1.0; 3],
            transmission: [1.0; 3],
            index_of_refraction: 1.0,
            texture: Some(texture.clone()),
            alpha: Some(Alpha {
                opacity,
                texture: Some(texture),
                cover: Cover::Blend,
            }),
            ..Material::default()
        });
        let paths = Paths::new(&scene);
        let opacity = f32::from(alpha) / 255.0 * opacity;
        let start = DVec3::new(0.1, 2.0, 0.2);
        let lit = seen(&paths, start - 1.9 * DVec3::Y, DVec3::NEG_Y);
        assert!(
            (lit - (1.0 - opacity)).abs().max_element() < 1e-5,
            "{opacity} {lit}"
        );
        let through = seen(&paths, start, DVec3::NEG_Y);
        let expected = Vec3::X * opacity + (1.0 - opacity) * lit;
        assert!(
            (through - expected).abs().max_element() < 1e-5,
            "{opacity} {through}"
        );
    }
}

#[test]
fn the_shadow_of_a_slab_of_glass_is_that_of_fresnel_and_beer() {
    const ABSORPTION: [f32; 3] = [0.5, 1.0, 4.0];
    const TRANSMISSION: [f32; 3] = [0.9, 1.0, 0.8];
    for (index, degrees) in [(1.5_f64, 0.0_f64), (1.5, 40.0), (1.5, 70.0), (1.0, 30.0)] {
        let mut scene = over_floor(Material {
            diffuse: [0.0; 3],
            transmission: TRANSMISSION,
            absorption: ABSORPTION,
            index_of_refraction: index as f32,
            ..Material::default()
        });
        // A box of 0.3 m, 20 m wide.
        let size = DVec3::new(20.0, 0.3, 20.0);
        scene.meshes.push(shisen_tests::meshes::faceted(
            &shisen_tests::meshes::gridded_cube(1),
        ));
        let place = DAffine3::from_scale_rotation_translation(
            size / 2.0,
            glam::DQuat::IDENTITY,
            2.0 * DVec3::Y,
        );
        scene.objects[0] = object(Shape::Mesh(1), 0, place);
        let (sin, cos) = degrees.to_radians().sin_cos();
        scene.lights[0] = Light::Directional {
            direction: DVec3::new(sin, -cos, 0.0),
            colour: [1.0; 3],
        };
        let found = seen(&Paths::new(&scene), 0.5 * DVec3::Y, DVec3::NEG_Y);
        let inside = (1.0 - (sin / index).powi(2)).sqrt();
        let s = ((cos - index * inside) / (cos + index * inside)).powi(2);
        let p = ((inside - index * cos) / (inside + index * cos)).powi(2);
        let border = 1.0 - 0.5 * (s + p);
        for channel in 0..3 {
            let own = f64::from(TRANSMISSION[channel]) * border;
            let along = -f64::from(ABSORPTION[channel]) * 0.3 / cos;
            let expected = cos * own * own * along.exp();
            let difference = (f64::from(found[channel]) - expected).abs();
            assert!(difference < 1e-4, "{index} {degrees}: {found} {expected}");
        }
        // Glass asks for its shadow alone, too; what casts none asks for none.
        scene.objects[1].casts_shadow = false;
        let baked = Baked::<8>::new(&scene).expect("a scene");
        let asked = EffectSet::SHADOWS | EffectSet::CLEAR_SHADOWS;
        assert!(baked.scene().effects().contains(asked));
        scene.objects[0] = Object {
            casts_shadow: false,
            ..scene.objects[0].clone()
        };
        let baked = Baked::<8>::new(&scene).expect("a scene");
        assert!(!baked.scene().effects().contains(EffectSet::CLEAR_SHADOWS));
        let lit = seen(&Paths::new(&scene), 0.5 * DVec3::Y, DVec3::NEG_Y);
        assert!((lit - cos as f32).abs().max_element() < 1e-5);
    }
}

#[test]
fn shadows_of_a_body_in_another_are_those_of_its_own_borders() {
    let of = |index_of_refraction: f32, priority: u32, absorption: f32| Material {
        diffuse: [0.0; 3],
        transmission: [1.0; 3],
        absorption: [absorption; 3],
        index_of_refraction,
        priority,
        ..Material::default()
    };
    // 0.1 m of water in 0.3 m of glass; with a lower priority the glass fills it.
    for (priority, glass, reflected) in [(2, 0.2, (0.17_f64 / 2.83).powi(2)), (0, 0.3, 0.0)] {
        let mut scene = over_floor(of(1.5, 1, 2.0));
        scene.materials.push(of(1.33, priority, 0.0));
        scene.meshes.push(shisen_tests::meshes::faceted(
            &shisen_tests::meshes::gridded_cube(1),
        ));
        let slab = |material, thickness: f64| {
            let size = DVec3::new(20.0, thickness, 20.0);
            let place = DAffine3::from_translation(2.0 * DVec3::Y);
            object(
                Shape::Mesh(1),
                material,
                place * DAffine3::from_scale(size / 2.0),
            )
        };
        scene.objects[0] = slab(0, 0.3);
        scene.objects.push(slab(2, 0.1));
        let found = seen(&Paths::new(&scene), 0.5 * DVec3::Y, DVec3::NEG_Y);
        let expected = (0.96 * (1.0 - reflected)).powi(2) * (-2.0_f64 * glass).exp();
        assert!(
            (f64::from(found.x) - expected).abs() < 1e-5,
            "{found} {expected}"
        );
    }
}

#[test]
fn veils_take_no_bounce_and_mirror() {
    let veil = Material {
        diffuse: [0.0; 3],
        transmission: [1.0; 3],
        index_of_refraction: 1.0,
        alpha: Some(Alpha {
            opacity: 0.1,
            texture: None,
            cover: Cover::Blend,
        }),
        ..Material::default()
    };
    // More than there are bounces; the sun comes through all of them, too.
    let mut scene = over_floor(veil.clone());
    for layer in 1..10 {
        let lift = DAffine3::from_translation((1.0 + 0.01 * f64::from(layer)) * DVec3::Y);
        scene.objects.push(object(Shape::Mesh(0), 0, lift));
    }
    let found = seen(&Paths::new(&scene), 2.0 * DVec3::Y, DVec3::NEG_Y);
    assert!((found.x - 0.9_f32.powi(20)).abs() < 1e-5, "{found}");
    let mut scene = over_floor(Material {
        diffuse: [0.8, 0.4, 0.2],
        alpha: Some(Alpha {
            opacity: 0.5,
            texture: None,
            cover: Cover::Blend,
        }),
        microfacets: Some(Microfacets {
            metalness: 1.0,
            roughness: 0.0,
            texture: None,
        }),
        ..veil
    });
    scene.background = Background::uniform([1.0; 3]);
    scene.materials[1].diffuse = [0.0; 3];
    scene.lights.clear();
    let found = seen(&Paths::new(&scene), 2.0 * DVec3::Y, DVec3::NEG_Y);
    let expected = Vec3::new(0.4, 0.2, 0.1);
    assert!((found - expected).abs().max_element() < 0.01, "{found}");
}
