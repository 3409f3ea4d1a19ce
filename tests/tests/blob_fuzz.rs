//! Damaged scenes: each is refused, or traces without a panic in bounded
//! time.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::scene::environment::{Environment, Radiance};
use shisen::scene::material::{Alpha, Cover, Graticule, Material, Microfacets, NormalMap};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture, Wrap};
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::frame::{Budget, Workspace};
use shisen_core::scene::format::{ALIGNMENT, Header, seal};
use shisen_core::scene::{self, SceneError};
use shisen_core::shape::Ray;
use shisen_core::spectrum::Medium;
use shisen_core::trace::{MeshTracer, Tracer, TraversalStack};
use shisen_core::{Runs, Simd};
use shisen_tests::meshes::icosphere;
use shisen_tests::rays::Random;
use shisen_tests::scenes::{empty, object};
use shisen_tests::sizes::cases;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Returns a mesh with all that meshes can have, and a material with data in an image.
fn tetrahedron(image: &Texture) -> TriangleMesh {
    TriangleMesh {
        positions: vec![
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ],
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        coordinates: vec![[0.0, 0.0], [1.0, 0.0], [0.5, 2.0], [-3.0, 1.0]],
        second_coordinates: vec![[0.5, 0.5], [1.0, -1.0], [0.0, 7.0], [3.0, 0.0]],
        tangents: vec![
            [1.0, 0.0, 0.0, 1.0],
            [0.0, -1.0, 0.0, -1.0],
            [0.0, 0.0, 1.0, 1.0],
            [0.6, 0.0, 0.8, -1.0],
        ],
        colours: vec![[1.0; 3], [0.0, 0.5, 1.0], [0.9, 0.8, 0.7], [0.2; 3]],
        materials: vec![Material {
            texture: Some(Texture::new(
                Pattern::Checker([[0.9; 3], [0.1; 3]]),
                [3.0, 2.0],
            )),
            microfacets: Some(Microfacets {
                metalness: 0.9,
                roughness: 0.3,
                texture: Some(Texture {
                    wrap: [Wrap::Mirror, Wrap::Clamp],
                    nearest: true,
                    second_coordinates: true,
                    ..image.clone()
                }),
            }),
            alpha: Some(Alpha {
                opacity: 0.9,
                texture: Some(image.clone()),
                cover: Cover::Mask(0.5),
            }),
            normal_map: Some(NormalMap {
                texture: image.clone(),
                scale: 0.5,
            }),
            vertex_colours: true,
            ..Material::default()
        }],
        triangle_materials: vec![0; 4],
        ..TriangleMesh::default()
    }
}

/// Returns everything that a scene can have, little of each.
// Longer than 80 lines: it is a table of values.
pub(super) fn small_scene() -> Scene {
    let texels = [[255, 9, 0, 255], [3, 200, 50, 100]];
    let image = Image::with_alpha(2, 1, &texels).expect("an image");
    let image = Texture::new(Pattern::Image(Arc::new(image)), [1.0, 5.0]);
    let tetrahedron = tetrahedron(&image);
    let globe = Material {
        emission: [0.5; 3],
        texture: Some(image.clone()),
        emission_texture: Some(image),
        ..Material::default()
    };
    let glass = Material {
        transmission: [0.9; 3],
        absorption: [0.1, 0.2, 0.3],
        medium: Some(Medium::SF11),
        priority: 2,
        ..Material::default()
    };
    let chrome = Material {
        mirror: [0.8; 3],
        graticule: Some(Graticule {
            divisions: 9,
            width: 0.05,
        }),
        specular: [0.5; 3],
        ..Material::default()
    };
    let object = |shape, material, at: [f64; 3]| {
        let place = DAffine3::from_translation(DVec3::from(at));
        object(shape, material, place)
    };
    let spheroid = Shape::Spheroid {
        equatorial_radius: 0.7,
        polar_radius: 0.4,
    };
    let sky = [[0.1, 0.2, 0.9], [3.0, 0.5, 0.0], [0.3; 3], [0.0, 70.0, 0.1]];
    let sky = Radiance::new([2, 2], sky.to_vec()).expect("a picture");
    Scene {
        environment: Some(Environment {
            image: Arc::new(sky),
            yaw: 1.0,
            strength: 0.5,
        }),
        meshes: vec![tetrahedron, icosphere(0)],
        materials: vec![glass, chrome, globe],
        objects: vec![
            Object {
                material: None,
                ..object(Shape::Mesh(0), 0, [0.0, 0.0, -3.0])
            },
            Object {
                smooth: true,
                ..object(Shape::Mesh(1), 1, [1.5, 0.0, -4.0])
            },
            object(Shape::Mesh(1), 0, [-1.5, 0.5, -4.0]),
            object(spheroid, 0, [0.0, 0.0, -1.5]),
            object(spheroid, 2, [0.5, 1.0, -2.5]),
        ],
        lights: vec![
            Light::Spot {
                position: DVec3::new(0.0, 3.0, 0.0),
                direction: DVec3::new(0.0, -3.0, -3.0),
                cone: [0.4, 0.7],
                colour: [9.0; 3],
                inverse_square: true,
            },
            Light::Directional {
                direction: DVec3::new(1.0, -2.0, -1.0),
                colour: [0.5; 3],
            },
            Light::Rectangle {
                centre: DVec3::new(0.0, 2.0, -3.0),
                right: DVec3::new(-0.5, 0.0, 0.0),
                up: DVec3::new(0.0, 0.0, -0.5),
                colour: [5.0; 3],
                samples: 2,
                two_sided: true,
            },
        ],
        background: Background::uniform([0.2; 3]),
        ambient: [0.1; 3],
        ..empty()
    }
}

/// Returns the same, the larger mesh at three levels of 20 to 8 faces.
pub(super) fn bake<const W: usize>() -> Baked<W>
where
    Simd: Runs<W>,
{
    let levels = PolygonLevels::new(8..=20, 3).expect("levels");
    let baked = Baked::with_levels(&small_scene(), &levels).expect("a scene");
    let rungs: Vec<u32> = baked.scene().meshes().iter().map(|m| m.rungs).collect();
    assert_eq!(rungs, [1, 3, 2, 1]);
    baked
}

/// Bytes at an aligned address, and one byte of room behind them.
#[derive(Clone)]
pub(super) struct Aligned {
    memory: Vec<u8>,
    start: usize,
    length: usize,
}

impl Aligned {
    pub(super) fn new(bytes: &[u8]) -> Self {
        let mut memory = vec![0; bytes.len() + 2 * ALIGNMENT];
        let start = memory.as_ptr().align_offset(ALIGNMENT);
        memory[start..start + bytes.len()].copy_from_slice(bytes);
        Self {
            memory,
            start,
            length: bytes.len(),
        }
    }

    pub(super) fn bytes(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.start + self.length]
    }
}

pub(super) fn rays(count: usize) -> Vec<Ray> {
    let mut random = Random::new(3);
    let mut rays = Vec::new();
    while rays.len() < count {
        let origin = Vec3::from(random.direction().map(|c| (c * 2.0) as f32));
        let target = Vec3::new(0.0, 0.0, -3.0) + Vec3::from(random.direction().map(|c| c as f32));
        let direction = match rays.len() % 8 {
            0 => Vec3::new(0.0, -0.0, -1.0),
            1 => (target - origin) * 1e-17,
            2 => (target - origin) * 1e15,
            _ => target - origin,
        };
        let origin = if rays.len() % 9 == 0 {
            origin * 1e11
        } else {
            origin
        };
        rays.extend(Ray::new(origin, direction));
    }
    rays
}

/// Traces rays of all kinds. Panics where a step count passes its bound.
fn trace<const W: usize>(scene: scene::Scene<'_, W>, simd: Simd, rays: &[Ray])
where
    Simd: Runs<W>,
{
    let depth = 3;
    let (nodes, _, _) = scene.sizes();
    // A lane of a node is a leaf block of eight triangles or an instance.
    let in_mesh = (nodes * (1 + 8 * W)) as u64;
    let in_scene = (nodes * (1 + W)) as u64 * (1 + in_mesh);
    // Each hit leaves two rays and one to each light, or to each of its points.
    let to_lights = scene.lights().iter().map(|light| light.samples.max(1));
    let in_tree = 15 * (1 + u64::from(to_lights.sum::<u32>())) * in_scene;
    let tracer = Tracer::new(scene, simd, depth);
    let mut workspace = Workspace::new();
    let mut stack = TraversalStack::EMPTY;
    let mut steps = |what: &str, bound: u64, work: &mut dyn FnMut(&mut Budget, &mut Workspace)| {
        let before = workspace.statistics.steps;
        work(&mut Budget::UNLIMITED.clone(), &mut workspace);
        let steps = workspace.statistics.steps - before;
        assert!(steps <= bound, "{what}: {steps} steps, at most {bound}");
    };
    for ray in rays {
        steps("radiance", in_tree, &mut |budget, workspace| {
            tracer.radiance(ray, budget, workspace);
        });
        steps("nearest", in_scene, &mut |budget, workspace| {
            tracer.nearest(ray, budget, workspace);
        });
        for limit in [1.0, f32::INFINITY] {
            steps("occluded", in_scene, &mut |budget, workspace| {
                tracer.is_occluded(ray, limit, budget, workspace);
            });
        }
        for mesh in 0..scene.meshes().len() {
            let tracer = MeshTracer::new(&scene, mesh, simd).expect("one of its meshes");
            let (_, steps) = tracer.nearest(ray, &mut stack);
            assert!(steps <= in_mesh, "{steps} steps in a mesh");
        }
    }
}

/// Loads and traces; says whether it was a scene.
pub(super) fn try_out<const W: usize>(
    bytes: &[u8],
    what: &str,
    rays: &[Ray],
) -> Result<(), SceneError>
where
    Simd: Runs<W>,
{
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let scene = scene::Scene::<W>::from_bytes(bytes)?;
        trace(scene, Simd::detect(), rays);
        Ok(())
    }));
    outcome.unwrap_or_else(|_| panic!("{W} wide, {what}: a panic"))
}

/// Returns what one byte may become.
fn damages_of(byte: u8) -> impl Iterator<Item = u8> {
    let flipped = (0..8).map(move |bit| byte ^ 1 << bit);
    flipped.chain([0, 0xff, 0x7f, 0x80, byte.wrapping_add(1)])
}

/// Damages one byte at a time.
fn damage_every_byte<const W: usize>()
where
    Simd: Runs<W>,
{
    let baked = bake::<W>();
    let original = baked.as_bytes();
    let rays = rays(cases("rays a damaged scene", 10, 40));
    assert_eq!(try_out::<W>(original, "whole", &rays), Ok(()));
    let mut copy = Aligned::new(original);
    let (mut refused, mut traced) = (0, 0);
    // All of the header; of the tables, whose records are many of a kind, each byte of some.
    let apart = 8 - cases("of eight bytes of a table", 1, 7);
    let places = (0..original.len()).filter(|at| *at < size_of::<Header>() || at % apart == 0);
    let damages = |at: usize| damages_of(original[at]).map(move |damaged| (at, damaged));
    for (place, damaged) in places.flat_map(damages) {
        if damaged == original[place] {
            continue;
        }
        let what = format!("byte {place} is {damaged:#x}");
        let bytes = copy.bytes();
        bytes[place] = damaged;
        let unsealed = try_out::<W>(bytes, &what, &rays);
        assert!(
            unsealed.is_err(),
            "{W} wide, {what}: taken for a whole scene"
        );
        seal(bytes);
        let is_scene = try_out::<W>(bytes, &what, &rays).is_ok();
        *(if is_scene { &mut traced } else { &mut refused }) += 1;
        bytes.copy_from_slice(original);
    }
    // Both must come up, or one of the two was not tested.
    assert!(
        refused > 100 && traced > 100,
        "{refused} refused, {traced} traced"
    );
}

#[test]
fn every_byte_of_the_fast_layout() {
    damage_every_byte::<8>();
}

#[test]
fn every_byte_of_the_compact_layout() {
    damage_every_byte::<4>();
}

/// Several words at once: what single bits cannot break together.
#[test]
fn words_replaced_together() {
    const INFINITE: u32 = f32::INFINITY.to_bits();
    const WORDS: [u32; 9] = [
        0,
        1,
        7,
        1 << 31,
        !0,
        !0 >> 1,
        INFINITE,
        INFINITE | 1 << 31,
        INFINITE - 1,
    ];
    let original = bake::<4>().as_bytes().to_vec();
    let rays = rays(24);
    let mut copy = Aligned::new(&original);
    let words = original.len() / 4;
    let mut traced = 0;
    for case in 0..cases("scenes with words replaced", 2_000, 20_000) {
        let seed = 0xF0_0000 + case as u64;
        let mut random = Random::new(seed);
        let bytes = copy.bytes();
        for _ in 0..=random.below(4) {
            // Past magic, checksum, version, width and length.
            let at = 4 * (6 + random.below(words - 6));
            let word = match random.below(3) {
                0 => WORDS[random.below(WORDS.len())],
                1 => random.below(40) as u32,
                _ => {
                    let other = 4 * random.below(words);
                    u32::from_le_bytes([0, 1, 2, 3].map(|i| original[other + i]))
                }
            };
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        seal(bytes);
        traced += usize::from(try_out::<4>(bytes, &format!("seed {seed:#x}"), &rays).is_ok());
        bytes.copy_from_slice(&original);
    }
    assert!(traced > 400, "{traced}");
}

fn every_length<const W: usize>()
where
    Simd: Runs<W>,
{
    let baked = bake::<W>();
    let whole = baked.as_bytes();
    for length in 0..whole.len() {
        let mut cut = Aligned::new(&whole[..length]);
        let error = try_out::<W>(cut.bytes(), "cut off", &[]).expect_err("a scene cut off");
        let expected =
            matches!(error, SceneError::Truncated { found, .. } if found == length as u64);
        assert!(expected || length == 0, "{length} bytes: {error:?}");
        // A header that owns up to it.
        if length >= 24 {
            let bytes = cut.bytes();
            bytes[20..24].copy_from_slice(&(length as u32).to_le_bytes());
            seal(bytes);
            assert!(
                try_out::<W>(bytes, "cut off", &[]).is_err(),
                "{length} bytes"
            );
        }
    }
}

#[test]
fn every_truncation_is_refused() {
    every_length::<8>();
    every_length::<4>();
}
