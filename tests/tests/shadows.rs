//! Where shadow rays start: no face shades itself, and what stands on it still does.

use glam::{DAffine3, DQuat, DVec3};
use shisen::bake::Baked;
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Light, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Pixel, Workspace};
use shisen_core::scene::EffectSet;
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::meshes::{faceted, gridded_cube, icosphere};
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object, sphere};
use shisen_tests::sizes::cases;

/// Returns a scene of one mesh under a light, which is all that lights it.
fn lone(mesh: TriangleMesh, map: DAffine3, towards: DVec3) -> Scene {
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    scene.background.alpha = 0.0;
    scene.meshes = vec![mesh];
    scene.objects = vec![object(Shape::Mesh(0), 0, map)];
    scene.materials = vec![Material {
        diffuse: [1.0; 3],
        ..Material::default()
    }];
    scene.lights.push(Light::Directional {
        direction: -towards,
        colour: [1.0; 3],
    });
    scene
}

/// Calls `look` with what each of some rays sees.
fn look(scene: &Scene, rays: impl Iterator<Item = Ray>, mut look: impl FnMut(usize, &Ray, Pixel)) {
    let baked = Baked::<8>::new(scene).expect("a scene");
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    for (number, ray) in rays.enumerate() {
        let pixel = tracer.radiance(&ray, &mut budget, &mut workspace);
        look(number, &ray, pixel);
    }
}

#[test]
fn no_face_of_a_convex_body_shades_itself() {
    let mut random = Random::new(7);
    let count = cases("bodies whose faces might shade themselves", 60, 600);
    for body in 0..count {
        let mesh = match body % 3 {
            0 => faceted(&gridded_cube(1 + random.below(5) as u32)),
            1 => faceted(&gridded_cube(1)),
            _ => faceted(&icosphere(2)),
        };
        let size = 10.0f64.powf(random.range(-2.0, 5.0));
        let flat = DVec3::new(1.0, random.range(0.05, 1.0), 1.0);
        let turned = match body % 4 {
            0 => DQuat::IDENTITY,
            _ => DQuat::from_scaled_axis(DVec3::from(random.direction()) * 3.0),
        };
        let away = DVec3::from(random.direction()) * size * random.range(0.0, 3.0);
        let map = DAffine3::from_scale_rotation_translation(flat * size, turned, away);
        // Half of the lights graze a face of the cubes.
        let height = 10.0f64.powf(random.range(-4.0, 0.0));
        let towards = match body % 2 {
            0 => {
                turned
                    * (DVec3::new(random.range(-1.0, 1.0), 0.0, random.range(-1.0, 1.0))
                        + height * DVec3::Y)
            }
            _ => DVec3::from(random.direction()),
        };
        let scene = lone(mesh, map, towards);
        let rays: Vec<Ray> = (0..2_000)
            .map(|_| {
                let eye = map.transform_point3(4.0 * DVec3::from(random.direction()));
                let at = map.transform_point3(DVec3::from(random.direction()));
                Ray::new(eye.as_vec3(), (at - eye).as_vec3()).expect("a ray")
            })
            .collect();
        let baked = Baked::<8>::new(&scene).expect("a scene");
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
        let unshaded = tracer.without(EffectSet::SHADOWS);
        let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
        let mut wrong = 0;
        for ray in &rays {
            let lit = tracer.radiance(ray, &mut budget, &mut workspace);
            let expected = unshaded.radiance(ray, &mut budget, &mut workspace);
            wrong += usize::from(lit != expected);
        }
        assert_eq!(wrong, 0, "body {body}: {map}, light {towards}");
    }
}

#[test]
fn the_shadow_of_a_ball_does_not_depend_on_the_size_of_the_floor() {
    // The ball hangs a millimetre over the floor, whose middle is elsewhere.
    let shadow = |size: f64| {
        let floor = faceted(&gridded_cube(1));
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::new(size, 1.0, size),
            DQuat::IDENTITY,
            DVec3::new(0.2 * size, -2.7, 0.1 * size),
        );
        let mut scene = lone(floor, map, DVec3::new(0.5, 1.0, 0.3));
        scene.objects.push(sphere(0.1, 0, [0.0, -1.599, -3.0]));
        let mut black = 0u32;
        let rays = (0..10_000).map(|n| {
            let (x, z) = (f64::from(n % 100), f64::from(n / 100));
            let at = DVec3::new(0.01 * x - 0.6, -1.7, 0.01 * z - 3.6);
            Ray::new([0.0; 3].into(), at.as_vec3()).expect("a ray")
        });
        look(&scene, rays, |_, _, pixel| {
            black += u32::from(pixel.green == 0.0);
        });
        black
    };
    let expected = shadow(10.0);
    assert!(expected > 200, "{expected} black pixels");
    for size in [1.0e3, 1.0e4, 1.0e5] {
        // Points on it are known within some millimetres along it.
        let found = shadow(size);
        assert!(
            found.abs_diff(expected) < 8,
            "a floor of {size} m: {found} of {expected}"
        );
    }
}

#[test]
fn light_on_a_coarse_smooth_ball_fades_as_on_a_fine_one() {
    let view = |subdivisions: u32| {
        let mut mesh = icosphere(subdivisions);
        mesh.normals = mesh.positions.clone();
        let scene = lone(mesh, DAffine3::IDENTITY, DVec3::new(1.0, 0.3, 0.2));
        let rays = (0..90_000).map(|n| {
            let (x, y) = (f32::from((n % 300) as u16), f32::from((n / 300) as u16));
            let origin = [(x - 150.0) / 160.0, (y - 150.0) / 160.0, 4.0];
            Ray::new(origin.into(), [0.0, 0.0, -1.0].into()).expect("a ray")
        });
        let mut seen = Vec::new();
        look(&scene, rays, |_, _, pixel| seen.push(pixel));
        seen
    };
    let (coarse, fine) = (view(2), view(6));
    let both = coarse
        .iter()
        .zip(&fine)
        .filter(|(a, b)| a.alpha * b.alpha > 0.0);
    let differences: Vec<f32> = both.map(|(a, b)| (a.green - b.green).abs()).collect();
    let count = differences.len() as f32;
    let mean = differences.iter().sum::<f32>() / count;
    let black = differences.iter().filter(|d| **d > 0.2).count();
    assert!(
        count > 50_000.0 && mean < 0.03 && black == 0,
        "mean {mean}, {black} black"
    );
}
