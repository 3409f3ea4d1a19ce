//! What tracing relies on, checked once.

mod tree;

use super::format::{
    ALIGNMENT, COVER_NODES, Header, Instance, LARGEST_SIDE, LeafBlock, Light, MAGIC, Material,
    Mesh, NO_COLOURS, NO_MATERIAL, NO_MEDIUM, NO_TANGENTS, NO_TEXTURE, Node, Table, Texture,
    VERSION, checksum, effect, kind, light, reading, texture, wrap,
};
use super::{EffectSet, STACK_ENTRIES, Scene, SceneError};
use crate::shape::{Ray, Slabs, Spheroid};
use core::ops::{Range, RangeInclusive};
use glam::Vec3;
use tree::{Tree, check_tree};
use zerocopy::{FromBytes, Immutable, KnownLayout};

/// Returns the header, and the scene's own bytes of what may be more.
pub(super) fn header<const W: usize>(bytes: &[u8]) -> Result<(&Header, &[u8]), SceneError> {
    let truncated = |needed| SceneError::Truncated {
        needed,
        found: bytes.len() as u64,
    };
    let Some(first) = bytes.get(..size_of::<Header>()) else {
        // A prefix that is not the magic number means: not a scene.
        let prefix = bytes.len().min(MAGIC.len());
        return Err(match (bytes.get(..prefix), MAGIC.get(..prefix)) {
            (Some(found), Some(magic)) if found == magic => truncated(size_of::<Header>() as u64),
            _ => SceneError::NotAScene,
        });
    };
    if !first.starts_with(&MAGIC) {
        return Err(SceneError::NotAScene);
    }
    let header =
        Header::ref_from_bytes(first).map_err(|_| SceneError::Misaligned { needed: ALIGNMENT })?;
    if header.version != VERSION {
        return Err(SceneError::Version {
            found: header.version,
            supported: VERSION,
        });
    }
    let needed = truncated(u64::from(header.byte_len));
    let own = bytes.get(..header.byte_len as usize).ok_or(needed)?;
    let computed = checksum(own, header.byte_len).ok_or(needed)?;
    if computed != header.checksum {
        return Err(SceneError::Checksum {
            stored: header.checksum,
            computed,
        });
    }
    if header.width != W as u32 {
        return Err(SceneError::Width {
            found: header.width,
            expected: W as u32,
        });
    }
    Ok((header, own))
}

/// Returns the records of a table among a scene's own bytes.
pub(super) fn table<'a, T>(
    own: &'a [u8],
    table: Table,
    name: &'static str,
) -> Result<&'a [T], SceneError>
where
    T: FromBytes + Immutable + KnownLayout,
{
    let wrong = SceneError::Table {
        name,
        offset: table.offset,
        count: table.count,
    };
    let from = own
        .get(table.offset as usize..)
        .filter(|_| (table.offset as usize).is_multiple_of(ALIGNMENT))
        .ok_or(wrong)?;
    <[T]>::ref_from_prefix_with_elems(from, table.count as usize)
        .map(|(records, _)| records)
        .map_err(|_| wrong)
}

/// Meridians that a quarter turn may have.
const GRATICULE_DIVISIONS: RangeInclusive<u32> = 1..=900;

/// The widest that lines may be: radians.
const GRATICULE_WIDEST: f32 = 0.5;

/// Farthest coordinate of a vertex on a texture, in its sides.
const FARTHEST_COORDINATE: f32 = 1.0e5;

/// Numbers of a texture's map.
const TEXTURE_MAP: RangeInclusive<f32> = -1.0e6..=1.0e6;

/// How many rungs a ladder of polygon levels may have; 1 is no ladder.
const RUNGS: RangeInclusive<u32> = 1..=64;

/// The number of a record, for the errors in it.
#[derive(Clone, Copy)]
struct Record(u32);

impl Record {
    const fn value(self, what: &'static str) -> SceneError {
        let Self(record) = self;
        SceneError::Value { what, record }
    }

    const fn index(self, what: &'static str, index: u32) -> SceneError {
        let Self(record) = self;
        SceneError::Index {
            what,
            record,
            index,
        }
    }

    fn has(self, what: &'static str, is_valid: bool) -> Result<(), SceneError> {
        is_valid.then_some(()).ok_or(self.value(what))
    }

    /// Checks that an index is one of a table of `length` records.
    fn names(self, what: &'static str, index: u32, length: usize) -> Result<(), SceneError> {
        let is_valid = (index as usize) < length;
        is_valid.then_some(()).ok_or(self.index(what, index))
    }

    fn within(
        self,
        what: &'static str,
        values: &[f32],
        range: RangeInclusive<f32>,
    ) -> Result<(), SceneError> {
        self.has(what, values.iter().all(|value| range.contains(value)))
    }

    fn finite(self, what: &'static str, values: &[f32]) -> Result<(), SceneError> {
        self.has(what, values.iter().all(|value| value.is_finite()))
    }
}

fn numbered<T>(records: &[T]) -> impl Iterator<Item = (Record, &T)> {
    (0..).map(Record).zip(records)
}

/// Checks every index and every value that tracing relies on.
pub(super) fn contents<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let header = scene.header;
    let fields = header.background;
    let colours = [fields.zenith, fields.horizon, fields.nadir, header.ambient];
    let (own, what) = (Record(0), "a background or ambient colour");
    own.within(what, colours.as_flattened(), 0.0..=1.0e12)?;
    own.within("the background's alpha", &[fields.alpha], 0.0..=1.0)?;
    own.within("the background's turn", &[fields.turn], -1.0..=1.0)?;
    let extents = 0.0..=Slabs::LARGEST_EXTENT;
    own.within("the scene's extent", &[header.extent], extents)?;
    check_tables(scene)?;
    for (record, position) in numbered(scene.positions) {
        let range = -Ray::FARTHEST..=Ray::FARTHEST;
        record.within("a vertex position", position, range)?;
    }
    for (record, coordinate) in numbered(scene.coordinates) {
        let range = -FARTHEST_COORDINATE..=FARTHEST_COORDINATE;
        record.within("a texture coordinate", coordinate, range)?;
    }
    for (record, colour) in numbered(scene.colours) {
        record.within("a vertex colour", colour, 0.0..=1.0)?;
    }
    for (record, &[x, y, z, side]) in numbered(scene.tangents) {
        let is_unit = (x * x + y * y + z * z - 1.0).abs() < 1.0e-3;
        record.has("a tangent", is_unit && side.abs() == 1.0)?;
    }
    for (record, texture) in numbered(scene.textures) {
        check_texture(texture, scene.texels.len(), record)?;
    }
    check_environment(scene)?;
    for (record, material) in numbered(scene.materials) {
        check_material(material, record)?;
        check_textured(material, scene.textures, record)?;
        if material.medium != NO_MEDIUM {
            record.names("medium", material.medium, scene.media.len())?;
        }
        let disperses = material.effects & effect::DISPERSION != 0;
        let may = material.medium != NO_MEDIUM && material.effects & effect::REFRACTION != 0;
        record.has("a dispersive material's medium", !disperses || may)?;
    }
    for (record, medium) in numbered(scene.media) {
        record.has("a medium's coefficients", medium.check().is_ok())?;
    }
    for (record, light) in numbered(scene.lights) {
        check_light(light, record)?;
    }
    let mut deepest = 0;
    let has_rungs = RUNGS.contains(&header.rungs);
    own.has("the scene's number of polygon levels", has_rungs)?;
    let mut finer = None;
    for (record, mesh) in numbered(scene.meshes) {
        check_rung(header.rungs, finer, mesh, record)?;
        // The rungs of a ladder share their triangles.
        if finer.is_none() {
            check_triangles(scene, mesh, record)?;
        }
        deepest = deepest.max(check_mesh(scene, mesh, record)?);
        finer = (mesh.rungs > 1).then_some(mesh);
    }
    if finer.is_some() {
        let mesh = (scene.meshes.len() as u32).saturating_sub(1);
        return Err(SceneError::Ladder { mesh });
    }
    for (record, instance) in numbered(scene.instances) {
        check_instance(scene, instance, record)?;
    }
    let (needed, _) = check_tree(scene, &top_tree(scene), header.root)?;
    let needed = deepest + needed;
    if needed > STACK_ENTRIES as u32 || header.stack_entries < needed {
        return Err(SceneError::TooDeep {
            needed,
            limit: header.stack_entries.min(STACK_ENTRIES as u32),
        });
    }
    check_effects(scene)
}

/// The background's image is there and of its kind, and no texel is brighter than a light may be.
fn check_environment<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let (own, number) = (Record(0), scene.header.background.image);
    if number == NO_TEXTURE {
        return Ok(());
    }
    let image = scene.textures.get(number as usize);
    let image = image.ok_or(own.index("texture", number))?;
    let is_light = image.reading & reading::SHARED_EXPONENT != 0;
    own.has(
        "the background's image",
        is_light && image.kind == texture::IMAGE,
    )?;
    let (first, count) = (image.first_texel as usize, image.level(image.levels).1);
    let texels = scene.texels.iter().skip(first).take(count as usize);
    let bright = texels.map(|&[.., exponent]| exponent).max();
    let is_finite = bright.is_none_or(|most| most <= reading::MOST_EXPONENT);
    own.has("the background's image", is_finite)
}

/// They are what shading is chosen by.
fn check_effects<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let stored = scene.header.effects;
    let asked = EffectSet::of_records(&scene.records()).bits();
    let is_so = (stored == asked).then_some(());
    is_so.ok_or(SceneError::Effects { stored, asked })
}

/// Leaves are of one kind, by the width, and what either looks up is there.
fn check_tables<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let header = scene.header;
    let ((name, other), positions) = if W == 8 {
        (("leaves of numbers", header.id_leaves), 0)
    } else {
        (("leaves", header.leaves), header.normals.count)
    };
    let found = header.positions.count;
    for (name, found, expected) in [(name, other.count, 0), ("positions", found, positions)] {
        if found != expected {
            return Err(SceneError::Count {
                name,
                found,
                expected,
            });
        }
    }
    Ok(())
}

fn check_material(m: &Material, record: Record) -> Result<(), SceneError> {
    let reflectances = [m.diffuse, m.specular, m.mirror, m.transmission];
    let shares = reflectances.as_flattened();
    record.within("a material's reflectance", shares, 0.0..=1.0)?;
    record.within("a material's absorption", &m.absorption, 0.0..=1.0e6)?;
    record.within("a material's shininess", &[m.shininess], 1.0..=1.0e4)?;
    let index = [m.index_of_refraction];
    record.within("an index of refraction", &index, 0.01..=100.0)?;
    let lines = if m.effects & effect::GRATICULE == 0 {
        m.graticule_divisions == 0 && m.graticule_width == 0.0
    } else {
        GRATICULE_DIVISIONS.contains(&m.graticule_divisions)
            && m.graticule_width > 0.0
            && m.graticule_width <= GRATICULE_WIDEST
    };
    record.has("a material's meridians and parallels", lines)?;
    let shares = [m.metalness, m.roughness, m.alpha_cutoff, m.opacity];
    record.within("a material's microfacets or alpha", &shares, 0.0..=1.0)?;
    let asked = m.effects & (effect::MICROFACETS | effect::ALPHA);
    let is_asked = asked != 0 || shares == [0.0; 4];
    record.has("a material's microfacets or alpha", is_asked)?;
    let scale = [m.normal_scale];
    record.within("a material's normal map", &scale, -1.0e3..=1.0e3)?;
    let what = "a material's emission";
    record.within(what, &m.emission, 0.0..=1.0e12)?;
    let shines = m.emission.iter().any(|&c| c > 0.0);
    record.has(what, shines == (m.effects & effect::EMISSION != 0))
}

/// Returns whether a material's textures are there, and of the kinds that it says.
fn check_textured(m: &Material, textures: &[Texture], record: Record) -> Result<(), SceneError> {
    let kinds = effect::CHECKER_TEXTURE | effect::IMAGE_TEXTURE | effect::TEXTURE_LEVELS;
    let asked = m.effects & kinds;
    let mut expected = 0;
    let textures_of = [
        m.texture,
        m.emission_texture,
        m.metal_texture,
        m.alpha_texture,
        m.normal_texture,
    ];
    for number in textures_of {
        if number != NO_TEXTURE {
            let texture = textures.get(number as usize);
            let texture = texture.ok_or(record.index("texture", number))?;
            let is_colour = texture.reading & reading::SHARED_EXPONENT == 0;
            record.has("a material's kind of texture", is_colour)?;
            expected |= texture.effects();
        }
    }
    record.has("a material's kind of texture", asked == expected)?;
    let is_mapped = m.effects & effect::NORMAL_MAP != 0;
    let map = textures.get(m.normal_texture as usize);
    let is_so = match map {
        Some(map) => is_mapped && map.kind == texture::IMAGE,
        None => !is_mapped && m.normal_scale == 0.0,
    };
    record.has("a material's normal map", is_so)
}

fn check_texture(t: &Texture, texels: usize, record: Record) -> Result<(), SceneError> {
    record.within("a texture's map", t.map.as_flattened(), TEXTURE_MAP)?;
    let is_known = t.wrap.iter().all(|&way| way <= wrap::CLAMP);
    record.has("a texture's wrapping", is_known)?;
    let colours = t.colours.as_flattened();
    record.within("a texture's colours", colours, 0.0..=1.0)?;
    let sides = [t.width, t.height];
    match t.kind {
        texture::CHECKER if sides == [0; 2] && t.first_texel == 0 && t.levels == 0 => Ok(()),
        texture::IMAGE if sides.iter().all(|side| (1..=LARGEST_SIDE).contains(side)) => {
            let has_none = colours.iter().all(|&channel| channel == 0.0);
            record.has("a texture's colours", has_none)?;
            let most = u32::BITS - sides[0].max(sides[1]).leading_zeros();
            record.has("a texture's levels", (1..=most).contains(&t.levels))?;
            // Sides of this many texels do not overflow.
            part(t.first_texel, t.level(t.levels).1, texels)
                .map(|_| ())
                .ok_or(record.index("texel", t.first_texel))
        }
        texture::CHECKER | texture::IMAGE => Err(record.value("a texture's size")),
        _ => Err(record.value("a texture's kind")),
    }
}

fn check_light(light: &Light, record: Record) -> Result<(), SceneError> {
    record.within("a light's colour", &light.colour, 0.0..=1.0e12)?;
    record.within("a light's place", &light.place, -1.0e12..=1.0e12)?;
    let size = [light.right, light.up];
    record.within("a light's size", size.as_flattened(), -1.0e6..=1.0e6)?;
    match light.kind {
        light::POINT | light::POINT_INVERSE_SQUARE | light::DIRECTIONAL => {
            let axis = Vec3::from_array(light.right);
            let is_spot = light.kind != light::DIRECTIONAL
                && (axis.dot(axis) - 1.0).abs() < 1.0e-3
                && light.up[0] > 0.0
                && light.up[2] == 0.0;
            let has_none = axis == Vec3::ZERO && light.up == [0.0; 3];
            record.has("a light's cone", has_none || is_spot)?;
            record.has("a light's size", light.samples == 0)
        }
        light::RECTANGLE | light::TWO_SIDED_RECTANGLE => {
            let is_known = (1..=light::MOST_SAMPLES).contains(&light.samples);
            record.has("a light's number of samples", is_known)
        }
        _ => Err(record.value("a light's kind")),
    }
}

/// `start..start + count` if it lies within a table of `length` records.
fn part(start: u32, count: u32, length: usize) -> Option<Range<u32>> {
    let end = start.checked_add(count)?;
    (end as usize <= length).then_some(start..end)
}

/// Returns whether a mesh is the rung below `finer`, or without one begins a ladder or has none.
fn check_rung(
    rungs: u32,
    finer: Option<&Mesh>,
    mesh: &Mesh,
    record: Record,
) -> Result<(), SceneError> {
    let shared = |mesh: &Mesh| {
        (
            mesh.first_triangle,
            mesh.triangle_count,
            mesh.first_normal,
            mesh.normal_count,
            mesh.first_coordinate,
            mesh.coordinate_count,
            mesh.first_colour,
            mesh.first_tangent,
        )
    };
    let fits = match finer {
        Some(finer) => {
            mesh.rungs.checked_add(1) == Some(finer.rungs) && shared(mesh) == shared(finer)
        }
        None => mesh.rungs == 1 || mesh.rungs == rungs,
    };
    let Record(mesh) = record;
    fits.then_some(()).ok_or(SceneError::Ladder { mesh })
}

fn check_triangles<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    record: Record,
) -> Result<(), SceneError> {
    let (first, count) = (mesh.first_triangle, mesh.triangle_count);
    let triangles = part(first, count, scene.triangles.len());
    let triangles = triangles.ok_or(record.index("triangle", first))?;
    let (first, normals) = (mesh.first_normal, mesh.normal_count);
    part(first, normals, scene.normals.len()).ok_or(record.index("normal", first))?;
    let (first, count) = (mesh.first_coordinate, mesh.coordinate_count);
    part(first, count, scene.coordinates.len())
        .filter(|_| count == 0 || count == normals || normals.checked_mul(2) == Some(count))
        .ok_or(record.index("coordinate", first))?;
    if mesh.first_colour != NO_COLOURS {
        let colours = part(mesh.first_colour, normals, scene.colours.len());
        colours.ok_or(record.index("colour", mesh.first_colour))?;
    }
    if mesh.first_tangent != NO_TANGENTS {
        let tangents = part(mesh.first_tangent, normals, scene.tangents.len());
        tangents.ok_or(record.index("tangent", mesh.first_tangent))?;
    }
    let triangles = triangles.start as usize..triangles.end as usize;
    for triangle in scene.triangles.get(triangles).unwrap_or_default() {
        // Corners have positions by the same numbers, if not normals.
        if (W == 4 || normals > 0)
            && let Some(&index) = triangle.corners.iter().find(|&&c| c >= normals)
        {
            return Err(record.index("vertex", index));
        }
        record.names("material", triangle.material, scene.materials.len())?;
    }
    Ok(())
}

fn check_mesh<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    record: Record,
) -> Result<u32, SceneError> {
    let nodes = part(mesh.first_node, mesh.node_count, scene.nodes.len())
        .ok_or(record.index("node", mesh.first_node))?;
    let leaf_count = scene.leaves.len() + scene.id_leaves.len();
    let leaves = part(mesh.first_leaf, mesh.leaf_count, leaf_count)
        .ok_or(record.index("leaf", mesh.first_leaf))?;
    let extents = 0.0..=Slabs::LARGEST_EXTENT;
    record.within("a mesh's extent", &[mesh.extent], extents)?;
    let tree = Tree {
        nodes,
        leaves,
        mesh: Some((mesh, record)),
    };
    let (needed, faces) = check_tree(scene, &tree, mesh.root)?;
    record.has("a mesh's number of faces", faces == mesh.faces)?;
    Ok(needed)
}

/// Returns whether a tree whose root is its first node can take the place of a mesh's own.
pub(super) fn can_replace<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    nodes: &[Node<W>],
    leaves: &[LeafBlock<W>],
) -> bool {
    let given = Scene {
        nodes,
        leaves,
        ..*scene
    };
    let own = Tree {
        nodes: 0..nodes.len() as u32,
        leaves: 0..leaves.len() as u32,
        mesh: Some((mesh, Record(0))),
    };
    let entries = |scene: &Scene<'_, W>, tree: &Tree<'_>, root: u32| {
        check_tree(scene, tree, root).map_or(STACK_ENTRIES as u32, |(needed, _)| needed)
    };
    let above = entries(scene, &top_tree(scene), scene.header.root);
    entries(&given, &own, 0) + above <= STACK_ENTRIES as u32
}

/// Returns the tree over instances.
fn top_tree<const W: usize>(scene: &Scene<'_, W>) -> Tree<'static> {
    Tree {
        nodes: 0..scene.header.top_nodes,
        leaves: 0..scene.instances.len() as u32,
        mesh: None,
    }
}

fn check_instance<const W: usize>(
    scene: &Scene<'_, W>,
    instance: &Instance,
    record: Record,
) -> Result<(), SceneError> {
    let maps = [instance.object_from_world, instance.world_from_object];
    let numbers = maps.as_flattened().as_flattened();
    record.finite("an instance's map", numbers)?;
    record.finite("an instance's box", &instance.low)?;
    record.finite("an instance's box", &instance.high)?;
    let condition = [instance.condition];
    record.within("an instance's condition", &condition, 1.0..=1.0e12)?;
    check_cover(scene, instance, record)?;
    let material = instance.material;
    if material != NO_MATERIAL {
        record.names("material", material, scene.materials.len())?;
    }
    match instance.kind {
        kind::MESH => match scene.meshes.get(instance.geometry as usize) {
            // The finest rung of a ladder, or a mesh without one.
            Some(mesh) if mesh.rungs == 1 || mesh.rungs == scene.header.rungs => Ok(()),
            _ => Err(record.index("mesh", instance.geometry)),
        },
        kind::SPHEROID if material == NO_MATERIAL => Err(record.index("material", material)),
        kind::SPHEROID => {
            let [equatorial, polar] = instance.radii;
            let spheroid = Spheroid::new(equatorial, polar);
            record.has("a spheroid's radii", spheroid.is_some())
        }
        _ => Err(record.value("an instance's kind")),
    }
}

fn check_cover<const W: usize>(
    scene: &Scene<'_, W>,
    instance: &Instance,
    record: Record,
) -> Result<(), SceneError> {
    let (first, count) = (instance.cover, instance.cover_nodes);
    if count == 0 {
        return Ok(());
    }
    let nodes = part(first, count, scene.nodes.len())
        .filter(|_| count <= COVER_NODES)
        .ok_or(record.index("cover", first))?;
    let tree = Tree {
        nodes,
        leaves: 0..COVER_NODES * W as u32,
        mesh: None,
    };
    check_tree(scene, &tree, first).map(|_| ())
}
