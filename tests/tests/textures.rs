//! Textures: the colours at known places, against what is worked out in f64.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::simplify::PolygonLevels;
use shisen::bake::{BakeError, Baked};
use shisen::scene::material::Material;
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Object, Scene, Shape};
use shisen_core::frame::{Budget, Renderer, Settings, View, Workspace};
use shisen_core::scene::EffectSet;
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_core::{Runs, Simd};
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object, pixels};
use std::sync::Arc;

const FIRST: [f32; 3] = [0.9, 0.8, 0.1];
const SECOND: [f32; 3] = [0.6, 0.05, 0.0];

fn checker(repeats: [f32; 2]) -> Texture {
    Texture::new(Pattern::Checker([FIRST, SECOND]), repeats)
}

fn image(width: u32, height: u32) -> Texture {
    let texels: Vec<[u8; 3]> = (0..width * height)
        .map(|i| [(37 * i) as u8, (91 * i + 5) as u8, !(13 * i) as u8])
        .collect();
    Texture::new(
        Pattern::Image(Arc::new(Image::new(width, height, &texels).expect("sides"))),
        [1.0; 2],
    )
}

/// Returns one object of white times a texture, lit from everywhere alike.
fn scene(shape: Shape, meshes: Vec<TriangleMesh>, texture: Texture, map: DAffine3) -> Scene {
    let object = object(shape, 0, map);
    Scene {
        meshes,
        materials: vec![Material {
            diffuse: [1.0; 3],
            texture: Some(texture),
            ..Material::default()
        }],
        objects: vec![Object {
            smooth: true,
            ..object
        }],
        ..empty()
    }
}

fn floor(texture: Texture, map: DAffine3) -> Scene {
    scene(Shape::Mesh(0), vec![TriangleMesh::square()], texture, map)
}

fn look<const W: usize>(
    scene: &shisen_core::scene::Scene<'_, W>,
    simd: Simd,
    origin: DVec3,
    direction: DVec3,
) -> Vec3
where
    Simd: Runs<W>,
{
    seen(&Tracer::new(*scene, simd, 0), origin, direction)
}

fn seen<const W: usize>(tracer: &Tracer<'_, W>, origin: DVec3, direction: DVec3) -> Vec3
where
    Simd: Runs<W>,
{
    let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).expect("a ray");
    let pixel = tracer.radiance(&ray, &mut { Budget::UNLIMITED }, &mut Workspace::new());
    Vec3::new(pixel.red, pixel.green, pixel.blue)
}

/// sRGB's decoding, in f64.
fn linear(code: u8) -> f64 {
    let c = f64::from(code) / 255.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

fn texel(texture: &Texture, column: u32, row: u32) -> Vec3 {
    let Pattern::Image(image) = &texture.pattern else {
        panic!("not an image")
    };
    let [r, g, b, _] = image.texels()[(row * image.width() + column) as usize];
    Vec3::new(linear(r) as f32, linear(g) as f32, linear(b) as f32)
}

#[track_caller]
fn assert_near(found: Vec3, expected: Vec3, tolerance: f32) {
    let error = (found - expected).abs().max_element();
    assert!(error <= tolerance, "{found}, expected {expected}");
}

#[test]
fn a_checkered_floor_is_that_of_brute_force() {
    let (side, cells) = (40.0, [40.0f64, 16.0]);
    let map = DAffine3::from_translation(DVec3::new(0.3, -1.5, -4.0))
        * DAffine3::from_rotation_y(0.4)
        * DAffine3::from_scale(DVec3::splat(side));
    let scene = floor(checker(cells.map(|c| c as f32)), map);
    let Paths { fast, compact } = Paths::new(&scene);
    let asked = EffectSet::CHECKER_TEXTURE | EffectSet::TEXTURE_LEVELS;
    assert_eq!(fast.scene().effects(), asked);
    let object_from_world = map.inverse();
    let mut random = Random::new(11);
    let (mut compared, mut near_a_border) = (0, 0);
    while compared < 4000 {
        let towards = DVec3::from(random.direction());
        let eye = DVec3::new(0.1, 0.2, 0.3).as_vec3().as_dvec3();
        let direction = towards.as_vec3().as_dvec3();
        let (o, d) = (
            object_from_world.transform_point3(eye),
            object_from_world.transform_vector3(direction),
        );
        let at = o - d * (o.y / d.y);
        if d.y >= 0.0 || at.x.abs() > 0.499 || at.z.abs() > 0.499 {
            continue;
        }
        compared += 1;
        let places = [(at.x + 0.5) * cells[0], (0.5 - at.z) * cells[1]];
        // Rounding of the ray and of the weights, at most 30 m away.
        if places.iter().any(|p| (p - p.round()).abs() < 1e-4) {
            near_a_border += 1;
            continue;
        }
        let odd = places.map(f64::floor).iter().sum::<f64>().rem_euclid(2.0);
        let expected = Vec3::from(if odd == 1.0 { SECOND } else { FIRST });
        for simd in [Simd::detect(), Simd::PORTABLE] {
            for found in [
                look(&fast.scene(), simd, eye, direction),
                look(&compact.scene(), simd, eye, direction),
            ] {
                assert_eq!(found, expected, "at {places:?}");
            }
        }
    }
    assert!(near_a_border < compared / 500, "{near_a_border}");
}

#[test]
fn texels_have_their_colours_in_their_middles() {
    let down = DVec3::NEG_Y;
    let above = |u: f64, v: f64| DVec3::new(u - 0.5, 1.0, 0.5 - v);
    let picture = image(7, 4);
    let pictured = floor(picture.clone(), DAffine3::IDENTITY);
    let baked = Baked::<4>::new(&pictured).expect("a scene");
    let asked = EffectSet::IMAGE_TEXTURE | EffectSet::TEXTURE_LEVELS;
    assert_eq!(baked.scene().effects(), asked);
    let seen = |u, v| look(&baked.scene(), Simd::detect(), above(u, v), down);
    for column in 0..7 {
        for row in 0..4 {
            // Rows go down, v goes up.
            let u = (f64::from(column) + 0.5) / 7.0;
            let v = 1.0 - (f64::from(row) + 0.5) / 4.0;
            assert_near(seen(u, v), texel(&picture, column, row), 4e-6);
        }
    }
    // At an edge half of the texel opposite shows.
    let v = 1.0 - 1.5 / 4.0;
    let half = (texel(&picture, 0, 1) + texel(&picture, 6, 1)) * 0.5;
    assert_near(seen(1e-7, v), half, 1e-5);
    assert_near(seen(1.0 - 1e-7, v), half, 1e-5);
    let between = (texel(&picture, 2, 1) + texel(&picture, 3, 1)) * 0.5;
    assert_near(seen(3.0 / 7.0, v), between, 1e-5);
}

/// Returns a square of `cells` a side, in the middle of which u jumps by one: vertices
/// are there twice.
fn seamed_square(cells: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let half = cells / 2;
    for (first, last, shift) in [(0, half, 0.0), (half, cells, 1.0)] {
        let start = mesh.positions.len() as u32;
        let columns = last - first + 1;
        for row in 0..=cells {
            for column in first..=last {
                let [u, v] = [column, row].map(|i| i as f32 / cells as f32);
                mesh.positions.push([u - 0.5, 0.0, 0.5 - v]);
                mesh.normals.push([0.0, 1.0, 0.0]);
                mesh.coordinates.push([u + shift, v]);
            }
        }
        for row in 0..cells {
            for column in 0..columns - 1 {
                let a = start + row * columns + column;
                let [b, c, d] = [a + 1, a + columns + 1, a + columns];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

#[test]
fn coarser_rungs_keep_the_texture_also_at_seams() {
    let mesh = seamed_square(32);
    let square = scene(
        Shape::Mesh(0),
        vec![mesh],
        checker([8.0; 2]),
        DAffine3::IDENTITY,
    );
    let levels = PolygonLevels::new(8..=2048, 4).expect("levels");
    let baked = Baked::<8>::with_levels(&square, &levels).expect("a scene");
    assert_eq!(baked.scene().rungs(), 4);
    let faces = baked.scene().meshes()[3].faces;
    assert!(faces <= 16, "{faces}");
    let mut random = Random::new(5);
    for _ in 0..2000 {
        let [u, v] = [0, 1].map(|_| f64::from(random.below(8 * 64) as u32) / (8.0 * 64.0));
        let (u, v) = (u + 1.0 / 1024.0, v + 1.0 / 1024.0);
        let odd = ((u * 8.0).floor() + (v * 8.0).floor()) % 2.0 == 1.0;
        let expected = Vec3::from(if odd { SECOND } else { FIRST });
        let origin = DVec3::new(u - 0.5, 1.0, 0.5 - v);
        for rung in 0..4 {
            let tracer = Tracer::new(baked.scene(), Simd::detect(), 0).at_rung(rung);
            let found = seen(&tracer, origin, DVec3::NEG_Y);
            assert_eq!(found, expected, "rung {rung} at {u}, {v}");
        }
    }
}

#[test]
fn emission_shows_outside_and_with_its_texture() {
    let mut lamp = floor(checker([2.0, 1.0]), DAffine3::IDENTITY);
    lamp.ambient = [0.0; 3];
    lamp.materials[0].diffuse = [0.0; 3];
    lamp.materials[0].emission_texture = lamp.materials[0].texture.take();
    lamp.materials[0].emission = [3.0, 2.0, 1.0];
    let baked = Baked::<8>::new(&lamp).expect("a scene");
    let asked = EffectSet::EMISSION | EffectSet::CHECKER_TEXTURE | EffectSet::TEXTURE_LEVELS;
    assert_eq!(baked.scene().effects(), asked);
    let lit = |origin, direction| look(&baked.scene(), Simd::detect(), origin, direction);
    let first = Vec3::new(3.0, 2.0, 1.0) * Vec3::from(FIRST);
    assert_near(lit(DVec3::new(-0.2, 1.0, 0.1), DVec3::NEG_Y), first, 1e-6);
    assert_eq!(lit(DVec3::new(-0.2, -1.0, 0.1), DVec3::Y), Vec3::ZERO);
    // Without the effects a surface is plain, and dark.
    let without = |effects: EffectSet| {
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 0).without(effects);
        seen(&tracer, DVec3::new(0.2, 1.0, 0.1), DVec3::NEG_Y)
    };
    let plain = without(EffectSet::CHECKER_TEXTURE);
    assert_eq!(plain, Vec3::new(3.0, 2.0, 1.0));
    assert_eq!(without(EffectSet::EMISSION), Vec3::ZERO);
}

#[test]
fn vertices_have_second_coordinates_and_colours() {
    let picture = image(2, 2);
    let mut square = floor(
        Texture {
            second_coordinates: true,
            nearest: true,
            ..picture.clone()
        },
        DAffine3::IDENTITY,
    );
    let mesh = &mut square.meshes[0];
    mesh.second_coordinates = std::mem::replace(&mut mesh.coordinates, vec![[0.0; 2]; 4]);
    mesh.colours = vec![[1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0; 3]];
    square.materials[0].vertex_colours = true;
    let above = DVec3::new(0.25, 1.0, 0.1);
    // In the triangle of the corners 0, 1 and 2: 1/4, 7/20 and 2/5 of each.
    let colour = Vec3::new(1.0, 0.25, 0.4);
    let texel = texel(&picture, 1, 1);
    let Paths { fast, compact } = Paths::new(&square);
    for found in [
        look(&fast.scene(), Simd::detect(), above, DVec3::NEG_Y),
        look(&compact.scene(), Simd::PORTABLE, above, DVec3::NEG_Y),
    ] {
        assert_near(found, texel * colour, 1e-6);
    }
    // A surface that only shines has the colours in its light.
    let material = &mut square.materials[0];
    material.emission = std::mem::take(&mut material.diffuse);
    material.texture = None;
    let baked = Baked::<8>::new(&square).expect("a scene");
    let found = look(&baked.scene(), Simd::detect(), above, DVec3::NEG_Y);
    assert_near(found, colour, 1e-6);
}

#[test]
fn a_pixel_sees_the_mean_of_its_footprint() {
    // Half of the texels are white: from afar all is grey, and near by it is not.
    let mut random = Random::new(9);
    let texels: Vec<[u8; 3]> = (0..256 * 128)
        .map(|_| [if random.below(2) == 0 { 255 } else { 0 }; 3])
        .collect();
    let noise = Image::new(256, 128, &texels).expect("sides");
    let noise = Texture::new(Pattern::Image(Arc::new(noise)), [1.0; 2]);
    let checker = Texture::new(Pattern::Checker([[1.0; 3], [0.0; 3]]), [256.0, 256.0]);
    for (texture, texel) in [(noise, 1.0 / 181.0), (checker, 1.0 / 256.0)] {
        let scene = floor(texture, DAffine3::IDENTITY);
        let baked = Baked::<8>::new(&scene).expect("a scene");
        // A view straight down, of 16 × 16 pixels that are this wide on the floor.
        for (width, spread) in [(4.0, 0.11), (8.0, 0.06), (0.5, 0.6)] {
            let step = (width * texel) as f32;
            let settings = Settings::default();
            let renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
            let view = View::new(
                Vec3::new(0.003, 1.0, 0.003),
                Vec3::new(-8.0 * step, -1.0, -8.0 * step),
                Vec3::X * step,
                Vec3::Z * step,
                [16; 2],
            );
            let view = view.expect("a view");
            let seen = pixels(&renderer, &view);
            let seen: Vec<f64> = seen.iter().map(|pixel| f64::from(pixel.red)).collect();
            let mean = seen.iter().sum::<f64>() / 256.0;
            let square = seen.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / 256.0;
            let found = square.sqrt();
            if width > 1.0 {
                assert!(
                    (mean - 0.5).abs() < 0.03 && found < spread,
                    "{width}: {mean} {found}"
                );
            } else {
                assert!(found > 0.25, "{width}: {found}");
            }
        }
    }
}

#[test]
fn a_texture_on_a_mesh_without_coordinates_is_refused() {
    let mut scene = floor(image(1, 1), DAffine3::IDENTITY);
    scene.meshes[0].coordinates.clear();
    assert_eq!(
        Baked::<8>::new(&scene),
        Err(BakeError::NoCoordinates { object: 0 })
    );
    scene.meshes[0].coordinates = vec![[f32::NAN; 2]; 4];
    assert!(matches!(
        Baked::<8>::new(&scene),
        Err(BakeError::Mesh { mesh: 0, .. })
    ));
}
