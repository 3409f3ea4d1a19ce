//! Faults of baked scenes and their errors: words out of range, tables that do not fit.

use super::blob_fuzz::{Aligned, bake, rays, small_scene, try_out};
use shisen::bake::Baked;
use shisen_core::scene::SceneError;
use shisen_core::scene::format::{
    self, ALIGNMENT, Background, Header, IdLeaf, Instance, Mesh, Table, Texel, Triangle, VERSION,
    seal,
};
use shisen_core::{Runs, Simd};
use std::mem::offset_of;
use zerocopy::FromBytes as _;

/// Returns what the core says of a scene whose bytes were changed and sealed again.
fn changed<const W: usize>(
    baked: &Baked<W>,
    change: impl FnOnce(&mut [u8]),
) -> Result<(), SceneError>
where
    Simd: Runs<W>,
{
    let mut copy = Aligned::new(baked.as_bytes());
    change(copy.bytes());
    seal(copy.bytes());
    try_out::<W>(copy.bytes(), "changed", &rays(24))
}

/// Returns the same with `word` at byte `at`.
fn with_word<const W: usize>(baked: &Baked<W>, at: usize, word: u32) -> Result<(), SceneError>
where
    Simd: Runs<W>,
{
    changed(baked, |bytes| {
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    })
}

/// Returns where the field of a record is.
fn field<T>(table: Table, record: usize, field: usize) -> usize {
    table.offset as usize + record * size_of::<T>() + field
}

fn header<const W: usize>(baked: &Baked<W>) -> Header
where
    Simd: Runs<W>,
{
    Header::read_from_prefix(baked.as_bytes())
        .expect("a header")
        .0
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
fn words_out_of_range_have_their_error() {
    let baked = Baked::<8>::new(&small_scene()).expect("a scene");
    let header = header(&baked);
    let material = |record, at| field::<format::Material>(header.materials, record, at);
    let texture = |record, at| field::<format::Texture>(header.textures, record, at);
    let light = |record, at| field::<format::Light>(header.lights, record, at);
    let mesh = |at| field::<Mesh>(header.meshes, 0, at);
    let kind_of_texture = offset_of!(format::Material, texture);
    let divisions = offset_of!(format::Material, graticule_divisions);
    let line_width = offset_of!(format::Material, graticule_width);
    let emission = offset_of!(format::Material, emission);
    let first = offset_of!(format::Texture, first_texel);
    let width = offset_of!(format::Texture, width);
    let map = offset_of!(format::Texture, map);
    let wrap = offset_of!(format::Texture, wrap);
    let metal = offset_of!(format::Material, metalness);
    let emission_texture = offset_of!(format::Material, emission_texture);
    let colour = mesh(offset_of!(Mesh, first_colour));
    let tangent = mesh(offset_of!(Mesh, first_tangent));
    let image = offset_of!(Header, background) + offset_of!(Background, image);
    let Table { offset, count } = header.texels;
    let last_texel = offset as usize + (count as usize - 1) * size_of::<Texel>();
    let tangents = header.tangents.offset as usize;
    let normals = offset_of!(format::Material, normal_scale);
    let colours = offset_of!(format::Texture, colours);
    let samples = offset_of!(format::Light, samples);
    let right = offset_of!(format::Light, right);
    let up = offset_of!(format::Light, up);
    let count = mesh(offset_of!(Mesh, coordinate_count));
    let media = header.media.offset as usize;
    let coordinates = header.coordinates.offset as usize;
    let [nan, over, far] = [f32::NAN, 1.01, 1.0e7].map(f32::to_bits);
    let [wide, thin] = [0.6f32, 0.1].map(f32::to_bits);
    // The second of the materials has lines, the first of the textures is the image: those of the
    // scene come before those of meshes.
    let lines = "a material's meridians and parallels";
    let (kind, size) = ("a material's kind of texture", "a texture's size");
    let (light_size, number) = ("a light's size", "a light's number of samples");
    let (shine, mapped) = ("a material's emission", "a texture's map");
    let coloured = "a texture's colours";
    let facets = "a material's microfacets or alpha";
    let bumps = "a material's normal map";
    let first_coordinate = mesh(offset_of!(Mesh, first_coordinate));
    let light_kind = offset_of!(format::Light, kind);
    let medium = offset_of!(format::Material, medium);
    for (at, word, expected) in [
        (material(1, divisions), 901, value(lines, 1)),
        (material(1, line_width), wide, value(lines, 1)),
        (material(1, line_width), 0, value(lines, 1)),
        (material(0, divisions), 1, value(lines, 0)),
        (material(0, line_width), thin, value(lines, 0)),
        (material(2, kind_of_texture), 5, index("texture", 2, 5)),
        (material(2, kind_of_texture), 4, value(kind, 2)),
        (image, 5, index("texture", 0, 5)),
        (image, 0, value("the background's image", 0)),
        (last_texel, u32::MAX, value("the background's image", 0)),
        (material(2, kind_of_texture), 1, value(kind, 2)),
        (material(0, kind_of_texture), 0, value(kind, 0)),
        (material(2, emission), nan, value(shine, 2)),
        (material(1, emission), over, value(shine, 1)),
        (texture(0, 0), 2, value("a texture's kind", 0)),
        (texture(0, 0), 0, value(size, 0)),
        (texture(1, 0), 1, value(size, 1)),
        (texture(0, width), 8193, value(size, 0)),
        (texture(0, width), 8192, index("texel", 0, 0)),
        (texture(0, first), 9, index("texel", 0, 9)),
        (texture(1, first), 1, value(size, 1)),
        (texture(0, map), far, value(mapped, 0)),
        (texture(0, map + 4), nan, value(mapped, 0)),
        (texture(0, wrap), 3, value("a texture's wrapping", 0)),
        (material(2, emission_texture), 5, index("texture", 2, 5)),
        (material(0, metal), thin, value(facets, 0)),
        (colour, 1, index("colour", 0, 1)),
        (tangent, 1, index("tangent", 0, 1)),
        (tangents, nan, value("a tangent", 0)),
        (tangents + 12, thin, value("a tangent", 0)),
        (material(0, normals), thin, value(bumps, 0)),
        (texture(0, colours), over, value(coloured, 0)),
        (coordinates + 4, far, value("a texture coordinate", 0)),
        (first_coordinate, 1, index("coordinate", 0, 1)),
        (count, 3, index("coordinate", 0, 0)),
        (light(2, samples), 65, value(number, 2)),
        (light(2, right), nan, value(light_size, 2)),
        (light(0, samples), 1, value(light_size, 0)),
        (light(1, right), over, value("a light's cone", 1)),
        (light(0, up), 0, value("a light's cone", 0)),
        (light(2, light_kind), 5, value("a light's kind", 2)),
        (material(0, medium), 1, index("medium", 0, 1)),
        // Its range.
        (media, nan, value("a medium's coefficients", 0)),
    ] {
        let found = with_word(&baked, at, word);
        assert_eq!(found, Err(expected), "{word:#x} at byte {at}");
    }
    for (at, word) in [
        (material(1, divisions), 900),
        (material(1, line_width), 0.5f32.to_bits()),
        (light(2, samples), 64),
        // A mesh without coordinates has its texture's first colour.
        (count, 0),
    ] {
        let found = with_word(&baked, at, word);
        assert_eq!(found, Ok(()), "{word:#x} at byte {at}");
    }
}

#[test]
fn leaves_of_numbers_name_triangles_and_those_name_vertices() {
    let baked = Baked::<4>::new(&small_scene()).expect("a scene");
    let header = header(&baked);
    let [tetrahedron, icosahedron] = [0, 1].map(|mesh| baked.scene().meshes()[mesh]);
    let refused = |at: usize, word: u32| with_word(&baked, at, word).expect_err("a wrong word");

    // The last leaf is one of the icosahedron's twenty triangles.
    let leaves = header.id_leaves;
    let last = leaves.offset as usize + (leaves.count as usize - 1) * size_of::<IdLeaf>();
    for number in [20, u32::MAX] {
        assert_eq!(refused(last, number), index("triangle", 1, number));
    }
    assert_eq!(with_word(&baked, last, 19), Ok(()));
    let bytes = baked.as_bytes();
    let mut words = (leaves.offset as usize..last + size_of::<IdLeaf>()).step_by(4);
    let empty = words
        .find(|&at| bytes[at..at + 4] == [0xff; 4])
        .expect("an empty lane");
    let SceneError::Index { what, index: 0, .. } = refused(empty, 0) else {
        panic!("an empty lane was taken");
    };
    assert_eq!(what, "triangle");

    let first = header.triangles.offset as usize + offset_of!(Triangle, corners);
    let second = first + 4 * size_of::<Triangle>();
    for (mesh, at, record) in [(tetrahedron, first, 0), (icosahedron, second, 1)] {
        for corner in 0..3 {
            let number = mesh.normal_count;
            let found = refused(at + 4 * corner, number);
            assert_eq!(found, index("vertex", record, number));
            assert_eq!(with_word(&baked, at + 4 * corner, number - 1), Ok(()));
        }
    }
    // Without normals there are no positions either, nor coordinates.
    let normals = field::<Mesh>(header.meshes, 1, offset_of!(Mesh, normal_count));
    let found = refused(normals, 0);
    assert!(
        matches!(found, SceneError::Index { what: "vertex", .. }),
        "{found:?}"
    );

    let z = header.positions.offset as usize + size_of::<[f32; 3]>() + 8;
    for bad in [f32::NAN, f32::NEG_INFINITY, 1.0001e12] {
        let found = refused(z, bad.to_bits());
        assert_eq!(found, value("a vertex position", 1), "{bad}");
    }
    assert_eq!(with_word(&baked, z, (-1e12_f32).to_bits()), Ok(()));
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
        let refused = with_word(&baked, table + offset_of!(Table, count), count);
        // One record more may also be past the end of the scene.
        let outside =
            matches!(refused, Err(SceneError::Table { name: table, .. }) if table == name);
        assert!(refused == Err(error) || outside, "{W} wide: {refused:?}");
    }
    let (normals, positions) = (offset_of!(Header, normals), offset_of!(Header, positions));
    let numbers = offset_of!(Header, id_leaves);
    check::<8>(numbers, 1, "leaves of numbers", [1, 0]);
    check::<8>(positions, 1, "positions", [1, 0]);
    check::<4>(offset_of!(Header, leaves), 1, "leaves", [1, 0]);
    // Four corners of a tetrahedron, twelve of an icosahedron.
    for count in [0, 15] {
        check::<4>(positions, count, "positions", [count, 16]);
        check::<4>(normals, count, "positions", [16, count]);
    }
}

#[test]
fn each_fault_of_the_whole_has_its_error() {
    let baked = bake::<8>();
    let load = |bytes: &[u8]| try_out::<8>(bytes, "whole", &rays(24));

    // What follows is not the scene's.
    let longer = [baked.as_bytes(), &[0xA5; 77]].concat();
    assert_eq!(load(Aligned::new(&longer).bytes()), Ok(()));
    for offset in [1, 2, 4, 8, 16] {
        let shifted = [&vec![0; offset], baked.as_bytes()].concat();
        let found = load(&Aligned::new(&shifted).bytes()[offset..]);
        let error = SceneError::Misaligned { needed: ALIGNMENT };
        assert_eq!(found, Err(error), "{offset}");
    }
    let found = changed(&baked, |bytes| bytes[0] = b's');
    assert_eq!(found, Err(SceneError::NotAScene));
    let (found, supported) = (VERSION + 1, VERSION);
    let error = SceneError::Version { found, supported };
    assert_eq!(with_word(&baked, 12, found), Err(error));
    let (found, expected) = (4, 8);
    let error = SceneError::Width { found, expected };
    assert_eq!(load(bake::<4>().as_bytes()), Err(error));
    let mut damaged = Aligned::new(baked.as_bytes());
    *damaged.bytes().last_mut().expect("a byte") ^= 1;
    let found = load(damaged.bytes());
    assert!(matches!(found, Err(SceneError::Checksum { .. })));

    // Seven children leave one lane empty, which rays must not enter for a
    // widening that is infinite: it would lead back to its own node.
    let mut seven = small_scene();
    seven.objects = vec![seven.objects[3].clone(); 7];
    let seven = Baked::<8>::new(&seven).expect("a scene");
    let found = with_word(&seven, 28, f32::MAX.to_bits());
    assert_eq!(found, Err(value("the scene's extent", 0)));
    // The empty lane made a copy of another: an eighth leaf in a scene of
    // seven instances, as a tree would have that names one again and again.
    let found = changed(&seven, |bytes| {
        let node = u32::from_le_bytes([bytes[40], bytes[41], bytes[42], bytes[43]]) as usize;
        let empty = (0..8).find(|lane| bytes[node + 192 + 4 * lane..][..4] == [0; 4]);
        let empty = empty.expect("a lane without a child");
        for row in 0..7 {
            let at = |lane: usize| node + 32 * row + 4 * lane;
            let full = at((empty + 1) % 8);
            bytes.copy_within(full..full + 4, at(empty));
        }
    });
    assert!(
        matches!(found, Err(SceneError::Index { what: "leaf", .. })),
        "{found:?}"
    );
}

#[test]
fn rungs_that_make_no_ladder_are_refused() {
    let baked = bake::<8>();
    let header = header(&baked);
    let rungs = offset_of!(Header, rungs);
    let mesh = |number, at| field::<Mesh>(header.meshes, number, at);
    let geometry = offset_of!(Instance, geometry);
    let instance = |number| field::<Instance>(header.instances, number, geometry);
    let ladder = |mesh| SceneError::Ladder { mesh };
    let levels = "the scene's number of polygon levels";
    let faces = "a mesh's number of faces";
    let of_mesh = offset_of!(Mesh, rungs);
    let meshes = offset_of!(Header, meshes) + offset_of!(Table, count);
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
        (instance(1), 2, index("mesh", 1, 2)),
        (instance(1), 4, index("mesh", 1, 4)),
        // A scene that ends within a ladder.
        (meshes, 3, ladder(2)),
    ] {
        let found = with_word(&baked, place, word);
        assert_eq!(found, Err(expected), "{word} at byte {place}");
    }
}
