//! Damaged scenes: each is refused, or traces without a panic in bounded
//! time.

use glam::{DAffine3, DVec3, Vec3};
use shisen::bake::Baked;
use shisen::bake::simplify::PolygonLevels;
use shisen::scene::camera::CameraPath;
use shisen::scene::material::{Graticule, Material};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::texture::{Image, Pattern, Texture};
use shisen::scene::{Background, Light, Object, Scene, Shape};
use shisen_core::frame::{Budget, Workspace};
use shisen_core::scene::format::{
    self, ALIGNMENT, Header, IdLeaf, Instance, Mesh, Table, Triangle, VERSION, effect, seal,
};
use shisen_core::scene::{self, SceneError};
use shisen_core::shape::Ray;
use shisen_core::spectrum::Medium;
use shisen_core::trace::{MeshTracer, Tracer, TraversalStack};
use shisen_core::{Runs, Simd};
use shisen_tests::meshes::icosphere;
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;
use std::mem::offset_of;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use zerocopy::FromBytes as _;

/// Everything that a scene can have, little of each.
pub(crate) fn small_scene() -> Scene {
    let tetrahedron = TriangleMesh {
        positions: vec![
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ],
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        coordinates: vec![[0.0, 0.0], [1.0, 0.0], [0.5, 2.0], [-3.0, 1.0]],
        materials: vec![Material {
            texture: Some(Texture {
                pattern: Pattern::Checker([[0.9; 3], [0.1; 3]]),
                repeats: [3.0, 2.0],
            }),
            ..Material::default()
        }],
        triangle_materials: vec![0; 4],
        ..TriangleMesh::default()
    };
    let image = Image::new(2, 1, &[[255, 9, 0], [3, 200, 50]]).expect("an image");
    let globe = Material {
        emission: [0.5; 3],
        texture: Some(Texture {
            pattern: Pattern::Image(Arc::new(image)),
            repeats: [1.0, 5.0],
        }),
        ..Material::default()
    };
    let glass = Material {
        transmission: [0.9; 3],
        absorption: [0.1, 0.2, 0.3],
        medium: Some(Medium::SF11),
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
    let object = |shape, material, at: [f64; 3], smooth| Object {
        shape,
        material,
        world_from_object: DAffine3::from_translation(DVec3::from(at)),
        casts_shadow: true,
        smooth,
    };
    let spheroid = Shape::Spheroid {
        equatorial_radius: 0.7,
        polar_radius: 0.4,
    };
    Scene {
        name: "small".into(),
        meshes: vec![tetrahedron, icosphere(0)],
        materials: vec![glass, chrome, globe],
        objects: vec![
            object(Shape::Mesh(0), None, [0.0, 0.0, -3.0], false),
            object(Shape::Mesh(1), Some(1), [1.5, 0.0, -4.0], true),
            object(Shape::Mesh(1), Some(0), [-1.5, 0.5, -4.0], false),
            object(spheroid, Some(0), [0.0, 0.0, -1.5], false),
            object(spheroid, Some(2), [0.5, 1.0, -2.5], false),
        ],
        lights: vec![
            Light::Point {
                position: DVec3::new(0.0, 3.0, 0.0),
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
        camera: CameraPath::default(),
    }
}

/// The same, the larger mesh at three levels of 20 to 8 faces.
fn bake<const W: usize>() -> Baked<W>
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
struct Aligned {
    memory: Vec<u8>,
    start: usize,
    length: usize,
}

impl Aligned {
    fn new(bytes: &[u8]) -> Self {
        let mut memory = vec![0; bytes.len() + 2 * ALIGNMENT];
        let start = memory.as_ptr().align_offset(ALIGNMENT);
        memory[start..start + bytes.len()].copy_from_slice(bytes);
        Self {
            memory,
            start,
            length: bytes.len(),
        }
    }

    fn bytes(&mut self) -> &mut [u8] {
        &mut self.memory[self.start..self.start + self.length]
    }
}

fn rays(count: usize) -> Vec<Ray> {
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

/// Rays of all kinds. Panics where a step count passes its bound.
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
fn try_out<const W: usize>(bytes: &[u8], what: &str, rays: &[Ray]) -> Result<(), SceneError>
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

/// Damages one byte at a time, as `damage` says how.
fn damage_every_byte<const W: usize>(name: &str, damage: &[fn(u8) -> u8])
where
    Simd: Runs<W>,
{
    let baked = bake::<W>();
    let original = baked.as_bytes().to_vec();
    let rays = rays(cases("rays a damaged scene", 15, 200));
    assert_eq!(try_out::<W>(baked.as_bytes(), "whole", &rays), Ok(()));
    let mut copy = Aligned::new(&original);
    let (mut refused, mut traced) = (0, 0);
    // All of the header; of the tables, whose records are many of a kind, each byte of some.
    let apart = 8 - cases("of eight bytes of a table", 1, 7);
    let places = (0..original.len()).filter(|at| *at < size_of::<Header>() || at % apart == 0);
    for place in places {
        for (number, damage) in damage.iter().enumerate() {
            let damaged = damage(original[place]);
            if damaged == original[place] {
                continue;
            }
            let what = format!("{name}: byte {place} is {damaged:#x} (damage {number})");
            let bytes = copy.bytes();
            bytes[place] = damaged;
            let as_is = try_out::<W>(bytes, &what, &rays);
            assert!(as_is.is_err(), "{W} wide, {what}: taken for a whole scene");
            seal(bytes);
            match try_out::<W>(bytes, &what, &rays) {
                Ok(()) => traced += 1,
                Err(_) => refused += 1,
            }
            bytes.copy_from_slice(&original);
        }
    }
    // Both must come up, or one of the two was not tested.
    assert!(
        refused > 100 && traced > 100,
        "{refused} refused, {traced} traced"
    );
}

const BITS: [fn(u8) -> u8; 8] = [
    |b| b ^ 1,
    |b| b ^ 2,
    |b| b ^ 4,
    |b| b ^ 8,
    |b| b ^ 16,
    |b| b ^ 32,
    |b| b ^ 64,
    |b| b ^ 128,
];

const VALUES: [fn(u8) -> u8; 5] = [|_| 0, |_| 0xff, |_| 0x7f, |_| 0x80, |b| b.wrapping_add(1)];

#[test]
fn every_bit_of_the_fast_layout() {
    damage_every_byte::<8>("bits", &BITS);
}

#[test]
fn every_bit_of_the_compact_layout() {
    damage_every_byte::<4>("bits", &BITS);
}

#[test]
fn every_byte_of_the_fast_layout() {
    damage_every_byte::<8>("values", &VALUES);
}

#[test]
fn every_byte_of_the_compact_layout() {
    damage_every_byte::<4>("values", &VALUES);
}

/// Several words at once: what single bits cannot break together.
#[test]
fn words_replaced_together() {
    const WORDS: [u32; 10] = [
        0,
        1,
        7,
        0x7fff_ffff,
        0x8000_0000,
        0xffff_ffff,
        0x7f80_0000,
        0xff80_0000,
        0x7f7f_ffff,
        0x0000_0001,
    ];
    let baked = bake::<4>();
    let original = baked.as_bytes().to_vec();
    let rays = rays(24);
    let mut copy = Aligned::new(&original);
    let words = original.len() / 4;
    let mut traced = 0;
    for case in 0..cases("scenes with words replaced", 5_000, 100_000) {
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
    assert!(traced > 1000, "{traced}");
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
        let expected = if length == 0 {
            matches!(error, SceneError::Truncated { .. } | SceneError::NotAScene)
        } else {
            matches!(error, SceneError::Truncated { found, .. } if found == length as u64)
        };
        assert!(expected, "{length} bytes: {error:?}");
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

/// What the core says of a scene in which `word` was written at byte `at`.
fn with_word<const W: usize>(baked: &Baked<W>, at: usize, word: u32) -> Result<(), SceneError>
where
    Simd: Runs<W>,
{
    let mut copy = Aligned::new(baked.as_bytes());
    copy.bytes()[at..at + 4].copy_from_slice(&word.to_le_bytes());
    seal(copy.bytes());
    try_out::<W>(copy.bytes(), &format!("{word:#x} at byte {at}"), &rays(24))
}

#[test]
fn lines_have_a_number_and_a_width_where_there_are_any() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    let (header, _) = Header::read_from_prefix(baked.as_bytes()).expect("a header");
    let what = "a material's meridians and parallels";
    let materials = baked.scene().materials();
    for (record, material) in (0..).zip(materials) {
        let at = header.materials.offset as usize + record as usize * size_of::<format::Material>();
        let divisions = at + offset_of!(format::Material, graticule_divisions);
        let width = at + offset_of!(format::Material, graticule_width);
        let lines = material.effects & effect::GRATICULE != 0;
        let bad = [
            (divisions, u32::from(!lines)),
            (divisions, 901),
            (width, f32::NAN.to_bits()),
            (width, 0.6f32.to_bits()),
            (width, (-0.1f32).to_bits()),
            (width, if lines { 0 } else { 0.1f32.to_bits() }),
        ];
        for (at, word) in bad {
            let found = with_word(&baked, at, word);
            assert_eq!(found, Err(SceneError::Value { what, record }), "{word:#x}");
        }
        if lines {
            assert_eq!(with_word(&baked, divisions, 900), Ok(()));
            assert_eq!(with_word(&baked, width, 0.5f32.to_bits()), Ok(()));
        }
    }
    let with_lines = materials.iter().filter(|m| m.graticule_divisions == 9);
    assert_eq!(with_lines.count(), 1);
}

/// Where the field of a record is.
fn field<T>(table: Table, record: usize, field: usize) -> usize {
    table.offset as usize + record * size_of::<T>() + field
}

/// Damages one word after another: what is in it, and the error.
fn assert_refused(baked: &Baked<8>, damages: &[(usize, u32, SceneError)]) {
    for &(at, word, expected) in damages {
        let found = with_word(baked, at, word);
        assert_eq!(found, Err(expected), "{word:#x} at byte {at}");
    }
}

const fn value(what: &'static str, record: u32) -> SceneError {
    SceneError::Value { what, record }
}

const fn index(what: &'static str, record: u32, index: u32) -> SceneError {
    SceneError::Index {
        what,
        record,
        index,
    }
}

#[test]
fn textures_and_where_meshes_are_on_them_are_checked() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    let (header, _) = Header::read_from_prefix(baked.as_bytes()).expect("a header");
    let material = |record, at| {
        let at = if at == 0 {
            offset_of!(format::Material, texture)
        } else {
            offset_of!(format::Material, emission)
        };
        field::<format::Material>(header.materials, record, at)
    };
    let texture = |record, at| field::<format::Texture>(header.textures, record, at);
    let mesh = |at| field::<Mesh>(header.meshes, 0, at);
    let count = mesh(offset_of!(Mesh, coordinate_count));
    let first = offset_of!(format::Texture, first_texel);
    let width = offset_of!(format::Texture, width);
    let repeats = offset_of!(format::Texture, repeats);
    let colours = offset_of!(format::Texture, colours);
    // The image comes first: materials of the scene before those of meshes.
    let (image, checker) = (0, 1);
    let of_texture = "a material's kind of texture";
    let emission = "a material's emission";
    let (size, repeated) = ("a texture's size", "a texture's repeats");
    let coloured = "a texture's colours";
    let [nan, over, far] = [f32::NAN, 1.01, 1.0e6].map(f32::to_bits);
    let damages = [
        (material(2, 0), 2, index("texture", 2, 2)),
        (material(2, 0), checker, value(of_texture, 2)),
        (material(2, 0), u32::MAX, value(of_texture, 2)),
        (material(0, 0), image, value(of_texture, 0)),
        (material(2, 1), nan, value(emission, 2)),
        (material(1, 1), over, value(emission, 1)),
        (texture(0, 0), 2, value("a texture's kind", 0)),
        (texture(0, 0), 0, value(size, 0)),
        (texture(1, 0), 1, value(size, 1)),
        (texture(0, width), 0, value(size, 0)),
        (texture(0, width), 8193, value(size, 0)),
        (texture(0, width), 3, index("texel", 0, 0)),
        (texture(0, first), 1, index("texel", 0, 1)),
        (texture(0, first), u32::MAX, index("texel", 0, u32::MAX)),
        (texture(1, first), 1, value(size, 1)),
        (texture(0, repeats), 0, value(repeated, 0)),
        (texture(0, repeats + 4), nan, value(repeated, 0)),
        (texture(0, colours), over, value(coloured, 0)),
        (texture(1, colours + 20), over, value(coloured, 1)),
        (
            header.coordinates.offset as usize + 4,
            far,
            value("a texture coordinate", 0),
        ),
        (
            mesh(offset_of!(Mesh, first_coordinate)),
            1,
            index("coordinate", 0, 1),
        ),
        (count, 3, index("coordinate", 0, 0)),
    ];
    assert_refused(&baked, &damages);
    // A mesh without coordinates has its texture's first colour.
    assert_eq!(with_word(&baked, count, 0), Ok(()));
}

#[test]
fn large_lights_and_media_are_checked() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    let (header, _) = Header::read_from_prefix(baked.as_bytes()).expect("a header");
    let light = |record, at| field::<format::Light>(header.lights, record, at);
    let medium =
        field::<format::Material>(header.materials, 0, offset_of!(format::Material, medium));
    let samples = offset_of!(format::Light, samples);
    let right = offset_of!(format::Light, right);
    let kind = offset_of!(format::Light, kind);
    let [nan, over] = [f32::NAN, 1.01].map(f32::to_bits);
    let (size, number) = ("a light's size", "a light's number of samples");
    let damages = [
        (light(2, samples), 0, value(number, 2)),
        (light(2, samples), 65, value(number, 2)),
        (light(2, right), nan, value(size, 2)),
        (light(0, samples), 1, value(size, 0)),
        (light(1, right), over, value(size, 1)),
        (light(2, kind), 5, value("a light's kind", 2)),
        (medium, 1, index("medium", 0, 1)),
        // Its range.
        (
            header.media.offset as usize,
            nan,
            value("a medium's coefficients", 0),
        ),
    ];
    assert_refused(&baked, &damages);
    assert_eq!(with_word(&baked, light(2, samples), 64), Ok(()));
}

#[test]
fn leaves_of_numbers_name_triangles_and_those_name_vertices() {
    let baked = Baked::<4>::new(&small_scene()).expect("a scene");
    let (header, _) = Header::read_from_prefix(baked.as_bytes()).expect("a header");
    let scene = baked.scene();
    let [tetrahedron, icosahedron] = [scene.meshes()[0], scene.meshes()[1]];
    assert_eq!(tetrahedron.triangle_count, 4);
    let refused = |at: usize, word: u32| with_word(&baked, at, word).expect_err("a wrong word");

    // The last leaf is one of the icosahedron's twenty triangles.
    let leaves = header.id_leaves;
    let last = leaves.offset as usize + (leaves.count as usize - 1) * size_of::<IdLeaf>();
    let what = "triangle";
    let error = |index| SceneError::Index {
        what,
        record: 1,
        index,
    };
    assert_eq!(refused(last, 20), error(20));
    assert_eq!(refused(last, u32::MAX), error(u32::MAX));
    assert_eq!(with_word(&baked, last, 19), Ok(()));
    let bytes = baked.as_bytes();
    let empty = (leaves.offset as usize..)
        .step_by(4)
        .find(|&at| bytes[at..at + 4] == [0xff; 4]);
    let empty = empty.expect("a leaf with an empty lane");
    assert!(empty < last + size_of::<IdLeaf>());
    assert!(matches!(
        refused(empty, 0),
        SceneError::Index {
            what: "triangle",
            index: 0,
            ..
        }
    ));

    let what = "vertex";
    let first = header.triangles.offset as usize + offset_of!(Triangle, corners);
    let second = first + 4 * size_of::<Triangle>();
    for (mesh, at, record) in [(tetrahedron, first, 0), (icosahedron, second, 1)] {
        for corner in 0..3 {
            let index = mesh.normal_count;
            let error = SceneError::Index {
                what,
                record,
                index,
            };
            assert_eq!(refused(at + 4 * corner, index), error);
            assert_eq!(with_word(&baked, at + 4 * corner, index - 1), Ok(()));
        }
    }
    // Without normals there are no positions either, nor coordinates.
    let normals = field::<Mesh>(header.meshes, 1, offset_of!(Mesh, normal_count));
    assert!(matches!(
        refused(normals, 0),
        SceneError::Index { what: "vertex", .. }
    ));

    let what = "a vertex position";
    let second = header.positions.offset as usize + size_of::<[f32; 3]>();
    for bad in [f32::NAN, f32::NEG_INFINITY, 1.0001e12, -1e30] {
        let error = SceneError::Value { what, record: 1 };
        assert_eq!(refused(second + 8, bad.to_bits()), error, "{bad}");
    }
    assert_eq!(with_word(&baked, second + 8, (-1e12_f32).to_bits()), Ok(()));
}

#[test]
fn each_layout_has_its_own_leaves_and_tables_of_a_length() {
    fn check<const W: usize>(table: usize, count: u32, name: &'static str, lengths: [u32; 2])
    where
        Simd: Runs<W>,
    {
        let baked = Baked::<W>::new(&small_scene()).expect("a scene");
        let [found, expected] = lengths;
        let error = SceneError::Count {
            name,
            found,
            expected,
        };
        let at = table + offset_of!(Table, count);
        let refused = with_word(&baked, at, count);
        // One record more may also be past the end of the scene.
        let outside =
            matches!(refused, Err(SceneError::Table { name: table, .. }) if table == name);
        assert!(refused == Err(error) || outside, "{W} wide: {refused:?}");
    }
    check::<8>(
        offset_of!(Header, id_leaves),
        1,
        "leaves of numbers",
        [1, 0],
    );
    check::<8>(offset_of!(Header, positions), 1, "positions", [1, 0]);
    check::<4>(offset_of!(Header, leaves), 1, "leaves", [1, 0]);
    // Four corners of a tetrahedron, twelve of an icosahedron.
    for count in [0, 15] {
        check::<4>(
            offset_of!(Header, positions),
            count,
            "positions",
            [count, 16],
        );
        check::<4>(offset_of!(Header, normals), count, "positions", [16, count]);
    }
}

#[test]
fn each_fault_of_the_whole_has_its_error() {
    let baked = bake::<8>();
    let rays = rays(24);
    let load = |bytes: &[u8]| try_out::<8>(bytes, "whole", &rays);

    let mut longer = baked.as_bytes().to_vec();
    longer.extend([0xA5; 77]);
    assert_eq!(
        load(Aligned::new(&longer).bytes()),
        Ok(()),
        "what follows is not the scene's"
    );

    for offset in [1, 2, 4, 8, 16] {
        let mut shifted = vec![0; offset];
        shifted.extend_from_slice(baked.as_bytes());
        let mut shifted = Aligned::new(&shifted);
        let found = load(&shifted.bytes()[offset..]);
        assert_eq!(
            found,
            Err(SceneError::Misaligned { needed: ALIGNMENT }),
            "{offset}"
        );
    }

    let mut other = Aligned::new(baked.as_bytes());
    other.bytes()[0] = b's';
    assert_eq!(load(other.bytes()), Err(SceneError::NotAScene));

    let mut other = Aligned::new(baked.as_bytes());
    let found = VERSION + 1;
    other.bytes()[12..16].copy_from_slice(&found.to_le_bytes());
    seal(other.bytes());
    let supported = VERSION;
    assert_eq!(
        load(other.bytes()),
        Err(SceneError::Version { found, supported })
    );

    let compact = bake::<4>();
    let expected = SceneError::Width {
        found: 4,
        expected: 8,
    };
    assert_eq!(load(compact.as_bytes()), Err(expected));

    // Seven children leave one lane empty, which rays must not enter for a
    // widening that is infinite: it would lead back to its own node.
    let mut seven = small_scene();
    seven.objects = vec![seven.objects[3].clone(); 7];
    let seven = Baked::<8>::new(&seven).expect("a scene");
    let mut other = Aligned::new(seven.as_bytes());
    other.bytes()[28..32].copy_from_slice(&f32::MAX.to_le_bytes());
    seal(other.bytes());
    let what = "the scene's extent";
    assert_eq!(
        load(other.bytes()),
        Err(SceneError::Value { what, record: 0 })
    );

    // The empty lane made a copy of another: an eighth leaf in a scene of
    // seven instances, as a tree would have that names one again and again.
    let mut other = Aligned::new(seven.as_bytes());
    let bytes = other.bytes();
    let node = u32::from_le_bytes([bytes[40], bytes[41], bytes[42], bytes[43]]) as usize;
    let empty = (0..8).find(|lane| bytes[node + 192 + 4 * lane..][..4] == [0; 4]);
    let empty = empty.expect("a lane without a child");
    for row in 0..7 {
        let at = |lane: usize| node + 32 * row + 4 * lane;
        let full = at((empty + 1) % 8);
        bytes.copy_within(full..full + 4, at(empty));
    }
    seal(bytes);
    let found = load(other.bytes());
    assert!(
        matches!(found, Err(SceneError::Index { what: "leaf", .. })),
        "{found:?}"
    );

    let mut other = Aligned::new(baked.as_bytes());
    let last = other.bytes().len() - 1;
    other.bytes()[last] ^= 1;
    let found = load(other.bytes());
    assert!(
        matches!(found, Err(SceneError::Checksum { .. })),
        "{found:?}"
    );
}

#[test]
fn rungs_that_make_no_ladder_are_refused() {
    let original = bake::<8>();
    let table = |field: usize| {
        let bytes = original.as_bytes()[field..][..4]
            .try_into()
            .expect("a word");
        u32::from_le_bytes(bytes) as usize
    };
    let rungs = offset_of!(Header, rungs);
    let mesh = |number: usize, field: usize| {
        table(offset_of!(Header, meshes)) + number * size_of::<Mesh>() + field
    };
    let instance = |number: usize| {
        let first = table(offset_of!(Header, instances));
        first + number * size_of::<Instance>() + offset_of!(Instance, geometry)
    };
    let value = |what, record| SceneError::Value { what, record };
    let ladder = |mesh| SceneError::Ladder { mesh };
    let not_its_mesh = |record, index| SceneError::Index {
        what: "mesh",
        record,
        index,
    };
    let levels = "the scene's number of polygon levels";
    let faces = "a mesh's number of faces";
    let of_mesh = offset_of!(Mesh, rungs);
    for (place, word, expected) in [
        (rungs, 0, value(levels, 0)),
        (rungs, 65, value(levels, 0)),
        // As many as no ladder has.
        (rungs, 4, ladder(1)),
        (rungs, 1, ladder(1)),
        // A ladder that starts too early or too late, breaks off or goes on.
        (mesh(0, of_mesh), 0, ladder(0)),
        (mesh(0, of_mesh), 2, ladder(0)),
        (mesh(0, of_mesh), 3, ladder(1)),
        (mesh(1, of_mesh), 1, ladder(2)),
        (mesh(2, of_mesh), 1, ladder(2)),
        (mesh(2, of_mesh), u32::MAX, ladder(2)),
        (mesh(3, of_mesh), 3, ladder(3)),
        (mesh(3, offset_of!(Mesh, first_triangle)), 3, ladder(3)),
        (mesh(2, offset_of!(Mesh, triangle_count)), 1, ladder(2)),
        (mesh(2, offset_of!(Mesh, first_normal)), 0, ladder(2)),
        (mesh(3, offset_of!(Mesh, normal_count)), 0, ladder(3)),
        (mesh(0, offset_of!(Mesh, faces)), 5, value(faces, 0)),
        (mesh(3, offset_of!(Mesh, faces)), 20, value(faces, 3)),
        // Only the finest rung is placed.
        (instance(1), 2, not_its_mesh(1, 2)),
        (instance(1), 4, not_its_mesh(1, 4)),
    ] {
        let mut damaged = Aligned::new(original.as_bytes());
        let bytes = damaged.bytes();
        bytes[place..place + 4].copy_from_slice(&word.to_le_bytes());
        seal(bytes);
        let found = try_out::<8>(bytes, "a ladder", &[]);
        assert_eq!(found, Err(expected), "{word} at byte {place}");
    }
    // A scene that ends within a ladder.
    let mut damaged = Aligned::new(original.as_bytes());
    let bytes = damaged.bytes();
    let count = offset_of!(Header, meshes) + offset_of!(Table, count);
    bytes[count..count + 4].copy_from_slice(&3u32.to_le_bytes());
    seal(bytes);
    assert_eq!(try_out::<8>(bytes, "a ladder", &[]), Err(ladder(2)));
}
