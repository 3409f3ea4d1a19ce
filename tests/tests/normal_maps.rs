//! Normal maps against the surfaces that they stand for.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::{BakeError, Baked};
use shisen::scene::material::{Material, NormalMap};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Light, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_tests::paths::Paths;
use shisen_tests::scenes::{empty, object};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Returns an image of normals: along u, along v, and outwards.
fn image(side: u32, normal: impl Fn(f32, f32) -> Vec3) -> Texture {
    let at = |n: u32| (n as f32 + 0.5) / side as f32;
    let texels = (0..side).flat_map(|row| (0..side).map(move |column| (column, row)));
    let texels = texels.map(|(column, row)| {
        let code = |part: f32| (0.5f32.mul_add(part, 0.5) * 255.0).round() as u8;
        normal(at(column), 1.0 - at(row)).to_array().map(code)
    });
    let texels: Vec<[u8; 3]> = texels.collect();
    let image = Image::new(side, side, &texels).expect("sides");
    Texture::new(Pattern::Image(Arc::new(image)), [1.0; 2])
}

/// Returns a smooth object in light from the right and the front, of a material with a normal map.
fn scene(shape: Shape, mesh: TriangleMesh, texture: Option<Texture>) -> Scene {
    let mut scene = empty();
    scene.ambient = [0.0; 3];
    scene.meshes = vec![mesh];
    scene.objects = vec![Object {
        casts_shadow: false,
        smooth: true,
        ..object(shape, 0, DAffine3::IDENTITY)
    }];
    scene.materials = vec![Material {
        diffuse: [0.6; 3],
        specular: [0.4; 3],
        normal_map: texture.map(|texture| NormalMap {
            texture,
            scale: 1.0,
        }),
        ..Material::default()
    }];
    scene.lights = vec![Light::Directional {
        direction: DVec3::new(-0.8, -1.0, -0.5),
        colour: [1.0; 3],
    }];
    scene
}

/// Returns what rays along a direction through some places see.
fn seen(scene: &Scene, places: &[Vec3], direction: Vec3) -> Vec<f32> {
    let Paths { fast, compact } = Paths::new(scene);
    let (mut budget, mut workspace) = (Budget::UNLIMITED, Workspace::new());
    let fast = Tracer::new(fast.scene(), Simd::detect(), 1);
    let compact = Tracer::new(compact.scene(), Simd::PORTABLE, 1);
    let mut red = |place: &Vec3| {
        let ray = Ray::new(*place - 2.0 * direction, direction).expect("a ray");
        let found = fast.radiance(&ray, &mut budget, &mut workspace);
        assert_eq!(found, compact.radiance(&ray, &mut budget, &mut workspace));
        found.red
    };
    places.iter().map(&mut red).collect()
}

/// Returns how the waves rise along u and v.
fn slope(u: f32, v: f32) -> [f32; 2] {
    let (along, across) = (2.0 * TAU * u, 3.0 * TAU * v);
    let height = 0.02;
    [
        height * 2.0 * TAU * along.cos() * across.cos(),
        -height * 3.0 * TAU * along.sin() * across.sin(),
    ]
}

/// Returns the square that has the waves.
fn waves() -> TriangleMesh {
    const SIDE: u32 = 100;
    let mut mesh = TriangleMesh::default();
    for (row, column) in (0..=SIDE).flat_map(|row| (0..=SIDE).map(move |column| (row, column))) {
        let [u, v] = [column, row].map(|n| n as f32 / SIDE as f32);
        let height = 0.02 * (2.0 * TAU * u).sin() * (3.0 * TAU * v).cos();
        let [along, across] = slope(u, v);
        mesh.positions.push([u - 0.5, height, 0.5 - v]);
        let normal = Vec3::new(-along, 1.0, across).normalize();
        mesh.normals.push(normal.to_array());
        if row < SIDE && column < SIDE {
            let a = row * (SIDE + 1) + column;
            let (b, c, d) = (a + 1, a + SIDE + 2, a + SIDE + 1);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn a_normal_map_shows_the_surface_that_it_is_of() {
    let places: Vec<Vec3> = (0..40)
        .flat_map(|row| (0..40).map(move |column| (row, column)))
        .map(|(row, column)| Vec3::new(row as f32 / 41.3 - 0.48, 0.0, column as f32 / 41.7 - 0.47))
        .collect();
    let expected = seen(&scene(Shape::Mesh(0), waves(), None), &places, Vec3::NEG_Y);
    let normal = |u, v| {
        let [along, across] = slope(u, v);
        Vec3::new(-along, -across, 1.0).normalize()
    };
    let mut mirrored = TriangleMesh::square();
    for [u, _] in &mut mirrored.coordinates {
        *u = 1.0 - *u;
    }
    let turned = |u, v| normal(1.0 - u, v) * Vec3::new(-1.0, 1.0, 1.0);
    for (mesh, map) in [
        (TriangleMesh::square(), image(256, normal)),
        (mirrored, image(256, turned)),
    ] {
        let found = seen(
            &scene(Shape::Mesh(0), mesh, Some(map)),
            &places,
            Vec3::NEG_Y,
        );
        let differences = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        let mean = differences.clone().sum::<f32>() / found.len() as f32;
        let most = differences.fold(0.0, f32::max);
        assert!(mean < 4e-3 && most < 3e-2, "{mean} {most}");
    }
    let flat = seen(
        &scene(Shape::Mesh(0), TriangleMesh::square(), None),
        &places,
        Vec3::NEG_Y,
    );
    let change = flat.iter().zip(&expected).map(|(a, b)| (a - b).abs());
    assert!(change.sum::<f32>() / flat.len() as f32 > 0.05);
}

/// Returns what is seen head-on of a surface with this normal.
fn lit(normal: Vec3, from: Vec3) -> f32 {
    let light = Vec3::new(0.8, 1.0, 0.5).normalize();
    let half = (light + from).normalize();
    0.6 * normal.dot(light) + 0.4 * normal.dot(half).powi(32)
}

#[test]
fn a_mirrored_texture_leans_the_other_way_from_its_seam_on() {
    let lean = Vec3::new(0.4, 0.2, (1.0f32 - 0.2).sqrt());
    // Two squares beside each other, which share the corners of their seam.
    let corner = |x: f32, z: f32| ([x, 0.0, z], [x.abs(), 0.5 - z]);
    let corners = [-0.5, 0.0, 0.5].map(|x| [corner(x, 0.5), corner(x, -0.5)]);
    let corners = corners.as_flattened();
    let mesh = TriangleMesh {
        positions: corners.iter().map(|corner| corner.0).collect(),
        coordinates: corners.iter().map(|corner| corner.1).collect(),
        triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
        ..TriangleMesh::default()
    };
    let places = [-0.4, -0.01, 0.01, 0.4].map(|x| Vec3::new(x, 0.0, 0.1));
    let found = seen(
        &scene(Shape::Mesh(0), mesh, Some(image(4, |_, _| lean))),
        &places,
        Vec3::NEG_Y,
    );
    for (found, side) in found.into_iter().zip([-1.0, -1.0, 1.0, 1.0]) {
        let expected = lit(Vec3::new(side * lean.x, lean.z, -lean.y), Vec3::Y);
        assert!((found - expected).abs() < 0.01, "{found} {expected}");
    }
    // East and north of a sphere.
    let sphere = scene(
        Shape::Sphere { radius: 1.0 },
        TriangleMesh::square(),
        Some(image(4, |_, _| lean)),
    );
    let found = seen(&sphere, &[Vec3::ZERO], Vec3::NEG_Z)[0];
    let expected = lit(lean, Vec3::Z);
    assert!((found - expected).abs() < 0.01, "{found} {expected}");
}

#[test]
fn a_normal_map_needs_texture_coordinates() {
    let mut bare = TriangleMesh::square();
    bare.coordinates.clear();
    let map = image(4, |_, _| Vec3::Z);
    let refused = Baked::<8>::new(&scene(Shape::Mesh(0), bare, Some(map)));
    assert_eq!(refused.err(), Some(BakeError::NoCoordinates { object: 0 }));
}
