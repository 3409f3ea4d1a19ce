//! What tracing relies on, checked once.

mod tree;

use super::format::{
    ALIGNMENT, COVER_NODES, Header, Instance, LARGEST_SIDE, Light, MAGIC, MOST_LIGHT_SAMPLES,
    Material, Mesh, NO_MATERIAL, NO_MEDIUM, NO_TEXTURE, Table, Texture, VERSION, checksum, effect,
    kind, light, texture,
};
use super::{EffectSet, STACK_ENTRIES, Scene, SceneError};
use crate::shape::{Ray, Slabs, Spheroid};
use core::ops::{Range, RangeInclusive};
use tree::{Tree, check_tree};
use zerocopy::{FromBytes, Immutable, KnownLayout};

/// The header, and the scene's own bytes of what may be more.
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

/// The records of a table among a scene's own bytes.
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

/// Farthest that a vertex may be from a texture's lower left corner, in its
/// sides: an f32 has some two digits of a side left there.
const FARTHEST_COORDINATE: f32 = 1.0e5;

/// Cells or copies of a texture in a unit of coordinates.
const REPEATS: RangeInclusive<f32> = 1.0e-3..=1.0e4;

/// How many rungs a ladder of polygon levels may have; 1 is no ladder.
const RUNGS: RangeInclusive<u32> = 1..=64;

/// Checks every index and every value that tracing relies on.
pub(super) fn contents<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let header = scene.header;
    let fields = header.background;
    let values = [fields.zenith, fields.horizon, fields.nadir, header.ambient];
    within(
        values.as_flattened(),
        0.0..=1.0e12,
        "a background or ambient colour",
        0,
    )?;
    within(&[fields.alpha], 0.0..=1.0, "the background's alpha", 0)?;
    within(
        &[header.extent],
        0.0..=Slabs::LARGEST_EXTENT,
        "the scene's extent",
        0,
    )?;
    check_tables(scene)?;
    for (record, position) in scene.positions.iter().enumerate() {
        let range = -Ray::FARTHEST..=Ray::FARTHEST;
        within(position, range, "a vertex position", record as u32)?;
    }
    for (record, coordinate) in scene.coordinates.iter().enumerate() {
        let range = -FARTHEST_COORDINATE..=FARTHEST_COORDINATE;
        within(coordinate, range, "a texture coordinate", record as u32)?;
    }
    for (record, texture) in scene.textures.iter().enumerate() {
        check_texture(texture, scene.texels.len(), record as u32)?;
    }
    for (record, material) in scene.materials.iter().enumerate() {
        check_material(material, record as u32)?;
        check_textured(material, scene.textures, record as u32)?;
        let index = material.medium;
        if index != NO_MEDIUM && index as usize >= scene.media.len() {
            return Err(SceneError::Index {
                what: "medium",
                record: record as u32,
                index,
            });
        }
        if material.effects & effect::DISPERSION != 0
            && (index == NO_MEDIUM || material.effects & effect::REFRACTION == 0)
        {
            return Err(SceneError::Value {
                what: "a dispersive material's medium",
                record: record as u32,
            });
        }
    }
    for (record, medium) in scene.media.iter().enumerate() {
        medium.check().map_err(|_| SceneError::Value {
            what: "a medium's coefficients",
            record: record as u32,
        })?;
    }
    for (record, light) in scene.lights.iter().enumerate() {
        check_light(light, record as u32)?;
    }
    let mut deepest = 0;
    if !RUNGS.contains(&header.rungs) {
        let what = "the scene's number of polygon levels";
        return Err(SceneError::Value { what, record: 0 });
    }
    let mut finer = None;
    for (record, mesh) in scene.meshes.iter().enumerate() {
        let record = record as u32;
        check_rung(header.rungs, finer, mesh, record)?;
        // The rungs of a ladder share their triangles.
        if finer.is_none() {
            check_triangles(scene, mesh, record)?;
        }
        deepest = deepest.max(check_mesh(scene, mesh, record)?);
        finer = (mesh.rungs > 1).then_some(mesh);
    }
    if finer.is_some() {
        let mesh = scene.meshes.len() as u32;
        return Err(SceneError::Ladder {
            mesh: mesh.saturating_sub(1),
        });
    }
    for (record, instance) in scene.instances.iter().enumerate() {
        check_instance(scene, instance, record as u32)?;
    }
    let top = Tree {
        nodes: 0..header.top_nodes,
        leaves: 0..scene.instances.len() as u32,
        mesh: None,
    };
    let (needed, _) = check_tree(scene, &top, header.root)?;
    let needed = deepest + needed;
    if needed > STACK_ENTRIES as u32 || header.stack_entries < needed {
        return Err(SceneError::TooDeep {
            needed,
            limit: header.stack_entries.min(STACK_ENTRIES as u32),
        });
    }
    check_effects(scene)
}

/// They are what shading is chosen by.
fn check_effects<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let stored = scene.header.effects;
    let asked = EffectSet::of_records(&scene.records()).bits();
    if stored == asked {
        Ok(())
    } else {
        Err(SceneError::Effects { stored, asked })
    }
}

/// Leaves are of one kind, by the width, and what either looks up is there.
fn check_tables<const W: usize>(scene: &Scene<'_, W>) -> Result<(), SceneError> {
    let header = scene.header;
    let ((name, other), positions) = if W == 8 {
        (("leaves of numbers", header.id_leaves), 0)
    } else {
        (("leaves", header.leaves), header.normals.count)
    };
    let lengths = [
        (name, other.count, 0),
        ("positions", header.positions.count, positions),
    ];
    match lengths
        .iter()
        .find(|(_, found, expected)| found != expected)
    {
        Some(&(name, found, expected)) => Err(SceneError::Count {
            name,
            found,
            expected,
        }),
        None => Ok(()),
    }
}

fn finite(values: &[f32], what: &'static str, record: u32) -> Result<(), SceneError> {
    if values.iter().all(|value| value.is_finite()) {
        Ok(())
    } else {
        Err(SceneError::Value { what, record })
    }
}

fn within(
    values: &[f32],
    range: RangeInclusive<f32>,
    what: &'static str,
    record: u32,
) -> Result<(), SceneError> {
    if values.iter().all(|value| range.contains(value)) {
        Ok(())
    } else {
        Err(SceneError::Value { what, record })
    }
}

fn check_material(m: &Material, record: u32) -> Result<(), SceneError> {
    let reflectances = [m.diffuse, m.specular, m.mirror, m.transmission];
    within(
        reflectances.as_flattened(),
        0.0..=1.0,
        "a material's reflectance",
        record,
    )?;
    within(
        &m.absorption,
        0.0..=1.0e6,
        "a material's absorption",
        record,
    )?;
    within(
        &[m.shininess],
        1.0..=1.0e4,
        "a material's shininess",
        record,
    )?;
    within(
        &[m.index_of_refraction],
        0.01..=100.0,
        "an index of refraction",
        record,
    )?;
    let lines = if m.effects & effect::GRATICULE == 0 {
        m.graticule_divisions == 0 && m.graticule_width == 0.0
    } else {
        GRATICULE_DIVISIONS.contains(&m.graticule_divisions)
            && m.graticule_width > 0.0
            && m.graticule_width <= GRATICULE_WIDEST
    };
    if !lines {
        let what = "a material's meridians and parallels";
        return Err(SceneError::Value { what, record });
    }
    let what = "a material's emission";
    within(&m.emission, 0.0..=1.0e12, what, record)?;
    let shines = m.emission.iter().any(|&c| c > 0.0);
    if shines == (m.effects & effect::EMISSION != 0) {
        Ok(())
    } else {
        Err(SceneError::Value { what, record })
    }
}

/// Whether a material's texture is there, and of the kind that it says.
fn check_textured(m: &Material, textures: &[Texture], record: u32) -> Result<(), SceneError> {
    let asked = m.effects & (effect::CHECKER_TEXTURE | effect::IMAGE_TEXTURE);
    let expected = if m.texture == NO_TEXTURE {
        0
    } else {
        match textures.get(m.texture as usize) {
            Some(texture) => texture.effect(),
            None => {
                return Err(SceneError::Index {
                    what: "texture",
                    record,
                    index: m.texture,
                });
            }
        }
    };
    if asked == expected {
        Ok(())
    } else {
        let what = "a material's kind of texture";
        Err(SceneError::Value { what, record })
    }
}

fn check_texture(t: &Texture, texels: usize, record: u32) -> Result<(), SceneError> {
    let wrong = |what| SceneError::Value { what, record };
    within(&t.repeats, REPEATS, "a texture's repeats", record)?;
    let colours = t.colours.as_flattened();
    within(colours, 0.0..=1.0, "a texture's colours", record)?;
    let sides = [t.width, t.height];
    match t.kind {
        texture::CHECKER if sides == [0; 2] && t.first_texel == 0 => Ok(()),
        texture::IMAGE if sides.iter().all(|side| (1..=LARGEST_SIDE).contains(side)) => {
            if colours.iter().any(|&channel| channel != 0.0) {
                return Err(wrong("a texture's colours"));
            }
            // Sides of this many texels do not overflow.
            part(t.first_texel, t.width * t.height, texels)
                .map(|_| ())
                .ok_or(SceneError::Index {
                    what: "texel",
                    record,
                    index: t.first_texel,
                })
        }
        texture::CHECKER | texture::IMAGE => Err(wrong("a texture's size")),
        _ => Err(wrong("a texture's kind")),
    }
}

fn check_light(light: &Light, record: u32) -> Result<(), SceneError> {
    within(&light.colour, 0.0..=1.0e12, "a light's colour", record)?;
    within(&light.place, -1.0e12..=1.0e12, "a light's place", record)?;
    let size = [light.right, light.up];
    within(
        size.as_flattened(),
        -1.0e6..=1.0e6,
        "a light's size",
        record,
    )?;
    let what = match light.kind {
        light::POINT | light::POINT_INVERSE_SQUARE | light::DIRECTIONAL => {
            let is_small = light.samples == 0 && light.right == [0.0; 3] && light.up == [0.0; 3];
            (!is_small).then_some("a light's size")
        }
        light::RECTANGLE | light::TWO_SIDED_RECTANGLE => {
            let may_be = (1..=MOST_LIGHT_SAMPLES).contains(&light.samples);
            (!may_be).then_some("a light's number of samples")
        }
        _ => Some("a light's kind"),
    };
    what.map_or(Ok(()), |what| Err(SceneError::Value { what, record }))
}

/// `start..start + count` if it lies within a table of `length` records.
fn part(start: u32, count: u32, length: usize) -> Option<Range<u32>> {
    let end = start.checked_add(count)?;
    (end as usize <= length).then_some(start..end)
}

/// Whether a mesh is the rung below `finer`, or where there is none, the
/// first of as many as the scene's ladders have, or no ladder at all.
fn check_rung(
    rungs: u32,
    finer: Option<&Mesh>,
    mesh: &Mesh,
    record: u32,
) -> Result<(), SceneError> {
    let shared = |mesh: &Mesh| {
        (
            mesh.first_triangle,
            mesh.triangle_count,
            mesh.first_normal,
            mesh.normal_count,
            mesh.first_coordinate,
            mesh.coordinate_count,
        )
    };
    let fits = match finer {
        Some(finer) => {
            mesh.rungs.checked_add(1) == Some(finer.rungs) && shared(mesh) == shared(finer)
        }
        None => mesh.rungs == 1 || mesh.rungs == rungs,
    };
    if fits {
        Ok(())
    } else {
        Err(SceneError::Ladder { mesh: record })
    }
}

fn check_triangles<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    record: u32,
) -> Result<(), SceneError> {
    let outside = |what, index| SceneError::Index {
        what,
        record,
        index,
    };
    let triangles = part(
        mesh.first_triangle,
        mesh.triangle_count,
        scene.triangles.len(),
    )
    .ok_or(outside("triangle", mesh.first_triangle))?;
    part(mesh.first_normal, mesh.normal_count, scene.normals.len())
        .ok_or(outside("normal", mesh.first_normal))?;
    part(
        mesh.first_coordinate,
        mesh.coordinate_count,
        scene.coordinates.len(),
    )
    .filter(|_| mesh.coordinate_count == 0 || mesh.coordinate_count == mesh.normal_count)
    .ok_or(outside("coordinate", mesh.first_coordinate))?;
    for triangle in scene
        .triangles
        .get(triangles.start as usize..triangles.end as usize)
        .unwrap_or_default()
    {
        // Corners have positions by the same numbers, if not normals.
        if (W == 4 || mesh.normal_count > 0)
            && let Some(&index) = triangle.corners.iter().find(|&&c| c >= mesh.normal_count)
        {
            return Err(outside("vertex", index));
        }
        if triangle.material as usize >= scene.materials.len() {
            return Err(outside("material", triangle.material));
        }
    }
    Ok(())
}

fn check_mesh<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    record: u32,
) -> Result<u32, SceneError> {
    let outside = |what, index| SceneError::Index {
        what,
        record,
        index,
    };
    let nodes = part(mesh.first_node, mesh.node_count, scene.nodes.len())
        .ok_or(outside("node", mesh.first_node))?;
    let leaf_count = scene.leaves.len() + scene.id_leaves.len();
    let leaves = part(mesh.first_leaf, mesh.leaf_count, leaf_count)
        .ok_or(outside("leaf", mesh.first_leaf))?;
    within(
        &[mesh.extent],
        0.0..=Slabs::LARGEST_EXTENT,
        "a mesh's extent",
        record,
    )?;
    let tree = Tree {
        nodes,
        leaves,
        mesh: Some((mesh, record)),
    };
    let (needed, faces) = check_tree(scene, &tree, mesh.root)?;
    if faces != mesh.faces {
        let what = "a mesh's number of faces";
        return Err(SceneError::Value { what, record });
    }
    Ok(needed)
}

fn check_instance<const W: usize>(
    scene: &Scene<'_, W>,
    instance: &Instance,
    record: u32,
) -> Result<(), SceneError> {
    let outside = |what, index| SceneError::Index {
        what,
        record,
        index,
    };
    let maps = [instance.object_from_world, instance.world_from_object];
    finite(
        maps.as_flattened().as_flattened(),
        "an instance's map",
        record,
    )?;
    finite(&instance.low, "an instance's box", record)?;
    finite(&instance.high, "an instance's box", record)?;
    within(
        &[instance.condition],
        1.0..=1.0e12,
        "an instance's condition",
        record,
    )?;
    check_cover(scene, instance, record)?;
    if instance.material != NO_MATERIAL && instance.material as usize >= scene.materials.len() {
        return Err(outside("material", instance.material));
    }
    match instance.kind {
        kind::MESH => match scene.meshes.get(instance.geometry as usize) {
            // The finest rung of a ladder, or a mesh without one.
            Some(mesh) if mesh.rungs == 1 || mesh.rungs == scene.header.rungs => Ok(()),
            _ => Err(outside("mesh", instance.geometry)),
        },
        kind::SPHEROID if instance.material == NO_MATERIAL => {
            Err(outside("material", instance.material))
        }
        kind::SPHEROID if Spheroid::new(instance.radii[0], instance.radii[1]).is_some() => Ok(()),
        kind::SPHEROID => Err(SceneError::Value {
            what: "a spheroid's radii",
            record,
        }),
        _ => Err(SceneError::Value {
            what: "an instance's kind",
            record,
        }),
    }
}

fn check_cover<const W: usize>(
    scene: &Scene<'_, W>,
    instance: &Instance,
    record: u32,
) -> Result<(), SceneError> {
    if instance.cover_nodes == 0 {
        return Ok(());
    }
    let nodes = part(instance.cover, instance.cover_nodes, scene.nodes.len())
        .filter(|_| instance.cover_nodes <= COVER_NODES)
        .ok_or(SceneError::Index {
            what: "cover",
            record,
            index: instance.cover,
        })?;
    let tree = Tree {
        nodes,
        leaves: 0..COVER_NODES * W as u32,
        mesh: None,
    };
    check_tree(scene, &tree, instance.cover).map(|_| ())
}
