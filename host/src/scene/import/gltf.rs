//! glTF 2.0, as JSON with external or embedded buffers and as GLB.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;
use std::rc::Rc;

use glam::{Mat3, Mat4, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, Node, Primitive, Semantic, buffer, json, mesh::Mode};
use serde::Deserialize;

use super::{
    ImportError, Textures, bounded, bounded_colour, claim, fault, syntax, unit_normals, unusable,
    usable_coordinates, validated,
};
use crate::scene::material::Material;
use crate::scene::mesh::{MeshError, TriangleMesh};

/// Metalness from which a smooth surface is a mirror.
const METALLIC: f32 = 0.5;
/// Roughness up to which a metallic surface is a mirror.
const SMOOTH: f32 = 0.3;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ImportError> {
    let (json, blob) = split(path, bytes)?;
    let document = document(path, &json)?;
    let importer = Importer {
        path,
        buffers: buffers(path, &document, blob)?,
    };
    let mesh = importer.scene(&document)?;
    validated(mesh, path, |_| None)
}

type Chunks<'a> = (Cow<'a, [u8]>, Option<Vec<u8>>);

fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Chunks<'a>, ImportError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    if bytes.get(4..8) == Some(&[1, 0, 0, 0]) {
        return Err(outdated(path, "1.0"));
    }
    // The parser subtracts the header's length unchecked.
    let claimed = bytes
        .get(8..)
        .and_then(|rest| rest.first_chunk())
        .map_or(0, |&length| u32::from_le_bytes(length));
    if claimed < 12 {
        return Err(syntax(path, "the GLB header is cut off"));
    }
    if u64::from(claimed) > bytes.len() as u64 {
        let what = "the GLB header's length";
        return Err(claim(path, what, claimed.into(), bytes.len()));
    }
    let glb = gltf::Glb::from_slice(bytes).map_err(|error| malformed(path, &error))?;
    Ok((glb.json, glb.bin.map(Cow::into_owned)))
}

fn malformed(path: &Path, error: &gltf::Error) -> ImportError {
    syntax(path, format!("not a valid glTF 2.0 file: {error}"))
}

/// Returns the error of a file of the first glTF, whose tables are others.
fn outdated(path: &Path, version: &str) -> ImportError {
    let problem = format!("this is glTF {version}, but glTF 2.0 is needed");
    fault(path, problem, "export the mesh again as glTF 2.0")
}

/// The part of a file that all versions of glTF have.
#[derive(Deserialize)]
struct Versioned {
    asset: json::Asset,
}

fn document(path: &Path, json: &[u8]) -> Result<Document, ImportError> {
    let version = json::deserialize::from_slice(json).map(|of: Versioned| of.asset.version);
    if let Some(version) = version.ok().filter(|version| version.starts_with("1.")) {
        return Err(outdated(path, &version));
    }
    let root: json::Root =
        json::deserialize::from_slice(json).map_err(|error| malformed(path, &error.into()))?;
    // The validator looks positions up before it has checked their index.
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let accessors = root.accessors.len();
    if primitives.any(|p| p.attributes.values().any(|i| i.value() >= accessors)) {
        return Err(syntax(
            path,
            format!("a primitive names an accessor that is not among the file's {accessors}"),
        ));
    }
    Document::from_json(root).map_err(|error| malformed(path, &error))
}

/// Returns the bytes of each buffer; buffers with the same URI share them.
fn buffers(
    path: &Path,
    document: &Document,
    mut blob: Option<Vec<u8>>,
) -> Result<Vec<Rc<Vec<u8>>>, ImportError> {
    let mut by_uri = HashMap::new();
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let number = buffer.index();
        let bytes = match buffer.source() {
            buffer::Source::Bin => {
                let problem = "has neither a URI nor a binary chunk";
                let bytes = blob.take().map(Rc::new);
                bytes.ok_or_else(|| syntax(path, format!("buffer {number} {problem}")))?
            }
            buffer::Source::Uri(uri) => match by_uri.entry(uri) {
                Entry::Occupied(known) => Rc::clone(known.get()),
                Entry::Vacant(new) => Rc::clone(new.insert(Rc::new(read_uri(path, uri)?))),
            },
        };
        if buffer.length() > bytes.len() {
            let what = format!("the length of buffer {number}");
            return Err(claim(path, &what, buffer.length() as u128, bytes.len()));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// Reads a `data:` URI or a file relative to the document's.
fn read_uri(path: &Path, uri: &str) -> Result<Vec<u8>, ImportError> {
    if uri.starts_with("data:") {
        return buffer::Data::from_source(buffer::Source::Uri(uri), None)
            .map(|data| data.0)
            .map_err(|error| malformed(path, &error));
    }
    let name = percent_decoded(uri).filter(|name| !name.contains("://"));
    let Some(name) = name else {
        return Err(syntax(
            path,
            format!("the buffer URI '{uri}' is neither data nor the name of a local file"),
        ));
    };
    super::read(&path.with_file_name(name))
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2)?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend(part.get(2..)?.as_bytes());
    }
    String::from_utf8(bytes).ok()
}

struct Importer<'a> {
    path: &'a Path,
    buffers: Vec<Rc<Vec<u8>>>,
}

impl Importer<'_> {
    fn buffer(&self, buffer: &gltf::Buffer<'_>) -> Option<&[u8]> {
        Some(self.buffers.get(buffer.index())?.as_slice())
    }

    fn fault(&self, problem: impl AsRef<str>) -> ImportError {
        syntax(self.path, problem)
    }

    fn scene(&self, document: &Document) -> Result<TriangleMesh, ImportError> {
        let mut mesh = TriangleMesh::default();
        let scene = document
            .default_scene()
            .or_else(|| document.scenes().next());
        let mut open: Vec<(Node<'_>, Mat4)> = scene
            .iter()
            .flat_map(gltf::Scene::nodes)
            .map(|node| (node, Mat4::IDENTITY))
            .collect();
        // The last is taken first: this keeps the document's order.
        open.reverse();
        let mut visited = vec![false; document.nodes().len()];
        while let Some((node, parent)) = open.pop() {
            if std::mem::replace(&mut visited[node.index()], true) {
                return Err(self.fault(format!(
                    "node {} has more than one parent, but nodes must form trees",
                    node.index()
                )));
            }
            let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                self.add_primitive(&primitive, transform, &mut mesh)?;
            }
            let first_child = open.len();
            open.extend(node.children().map(|child| (child, transform)));
            open[first_child..].reverse();
        }
        // A primitive lacks them.
        if mesh.normals.len() < mesh.positions.len() {
            mesh.normals.clear();
        }
        if mesh.coordinates.len() < mesh.positions.len() {
            mesh.coordinates.clear();
        }
        mesh.normals = unit_normals(mesh.normals);
        mesh.coordinates = usable_coordinates(mesh.coordinates);
        paint(document, &mut mesh);
        if !mesh.coordinates.is_empty() {
            self.add_textures(document, &mut mesh)?;
        }
        Ok(mesh)
    }

    /// Appends a primitive's triangles. Those without a material get `u32::MAX` for now.
    fn add_primitive(
        &self,
        primitive: &Primitive<'_>,
        transform: Mat4,
        mesh: &mut TriangleMesh,
    ) -> Result<(), ImportError> {
        match primitive.mode() {
            Mode::Triangles => {}
            Mode::TriangleStrip | Mode::TriangleFan => {
                let problem = "a primitive is a triangle strip or fan";
                return Err(fault(self.path, problem, "export it as separate triangles"));
            }
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Ok(()),
        }
        let reader = primitive.reader(|buffer| self.buffer(&buffer));
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            return Ok(());
        };
        let first = mesh.positions.len();
        let count = accessor.count();
        let vectors = (Dimensions::Vec3, &[DataType::F32][..]);
        let positions = self.items(&accessor, vectors, || reader.read_positions())?;
        // Any number of nodes may share the accessors.
        if count > (3 * TriangleMesh::MOST_TRIANGLES).saturating_sub(first) {
            return Err(self.too_many(first.saturating_add(count) / 3));
        }
        mesh.positions
            .extend(positions.map(|p| transform.transform_point3(Vec3::from_array(p)).to_array()));
        let normals = primitive.get(&Semantic::Normals);
        if let Some(accessor) = normals.filter(|normals| normals.count() == count) {
            let matrix = normal_matrix(transform);
            let normals = self.items(&accessor, vectors, || reader.read_normals())?;
            let turned = normals.map(|n| (matrix * Vec3::from_array(n)).to_array());
            mesh.normals.extend(turned);
        }
        let places = primitive.get(&Semantic::TexCoords(0));
        if let Some(accessor) = places.filter(|places| places.count() == count) {
            let types = [DataType::U8, DataType::U16, DataType::F32];
            let read = || reader.read_tex_coords(0);
            let coordinates = self.items(&accessor, (Dimensions::Vec2, &types), read)?;
            // glTF counts v from the top.
            let turned = coordinates.into_f32().map(|[u, v]| [u, 1.0 - v]);
            // After a primitive without coordinates, these would be at the wrong vertices.
            if mesh.coordinates.len() == first {
                mesh.coordinates.extend(turned);
            }
        }
        let mirrored = transform.determinant() < 0.0;
        self.add_triangles(primitive, count, mirrored, mesh)?;
        let material = primitive.material().index().unwrap_or(usize::MAX);
        mesh.triangle_materials
            .resize(mesh.triangles.len(), material as u32);
        Ok(())
    }

    /// Adds the textures of base colours that are on the first coordinates and are PNG files.
    fn add_textures(
        &self,
        document: &Document,
        mesh: &mut TriangleMesh,
    ) -> Result<(), ImportError> {
        let mut textures = Textures::new();
        for (material, painted) in document.materials().zip(&mut mesh.materials) {
            let base = material.pbr_metallic_roughness().base_color_texture();
            if let Some(info) = base.filter(|info| info.tex_coord() == 0) {
                let source = info.texture().source();
                let image = || self.image(&source);
                painted.texture = textures.get(source.index(), self.path, image)?;
            }
        }
        Ok(())
    }

    fn image(&self, image: &gltf::Image<'_>) -> Result<Cow<'_, [u8]>, ImportError> {
        Ok(match image.source() {
            gltf::image::Source::Uri { uri, .. } => Cow::Owned(read_uri(self.path, uri)?),
            gltf::image::Source::View { view, .. } => {
                let buffer = self.buffer(&view.buffer()).unwrap_or_default();
                let end = view.offset().checked_add(view.length());
                let bytes = end.and_then(|end| buffer.get(view.offset()..end));
                Cow::Borrowed(bytes.ok_or_else(|| {
                    let claimed = view.offset() as u128 + view.length() as u128;
                    let what = format!("buffer view {}", view.index());
                    claim(self.path, &what, claimed, buffer.len())
                })?)
            }
        })
    }

    fn add_triangles(
        &self,
        primitive: &Primitive<'_>,
        count: usize,
        mirrored: bool,
        mesh: &mut TriangleMesh,
    ) -> Result<(), ImportError> {
        let triangles = primitive.indices().map_or(count, |a| a.count()) / 3;
        let before = mesh.triangles.len();
        if triangles > TriangleMesh::MOST_TRIANGLES - before {
            return Err(self.too_many(before.saturating_add(triangles)));
        }
        let indices: Vec<u32> = match primitive.indices() {
            None => (0..count as u32).collect(),
            Some(accessor) => {
                let reader = primitive.reader(|buffer| self.buffer(&buffer));
                let types = [DataType::U8, DataType::U16, DataType::U32];
                let read = || reader.read_indices();
                let indices = self.items(&accessor, (Dimensions::Scalar, &types), read)?;
                indices.into_u32().collect()
            }
        };
        let (corners, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(self.fault(format!(
                "a primitive has {} corners, which is no multiple of three",
                indices.len()
            )));
        }
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= count) {
            return Err(self.fault(format!(
                "a primitive names vertex {index} (counted from 0), but has {count}"
            )));
        }
        let first = (mesh.positions.len() - count) as u32;
        mesh.triangles.extend(corners.iter().map(|corners| {
            let [a, b, c] = corners.map(|index| first + index);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    fn too_many(&self, count: usize) -> ImportError {
        unusable(self.path, MeshError::too_many(count))
    }

    /// Reads an accessor, once it is certain that it has one of the types and that all of it is
    /// there.
    fn items<T>(
        &self,
        accessor: &Accessor<'_>,
        (dimensions, types): (Dimensions, &[DataType]),
        read: impl FnOnce() -> Option<T>,
    ) -> Result<T, ImportError> {
        let number = accessor.index();
        let found = (accessor.dimensions(), accessor.data_type());
        if found.0 != dimensions || !types.contains(&found.1) {
            let asked = types.last().unwrap_or(&DataType::F32);
            return Err(self.fault(format!(
                "accessor {number} is {:?} of {:?}, but has to be {dimensions:?} of {asked:?}",
                found.0, found.1
            )));
        }
        let count = accessor.count();
        let size = accessor.size();
        match accessor.view() {
            Some(view) => self.check_view(number, &view, accessor.offset(), count, size)?,
            // All zero but for the sparse items.
            None if count > TriangleMesh::MOST_TRIANGLES => {
                return Err(self.too_many(count));
            }
            None => {}
        }
        if let Some(sparse) = accessor.sparse() {
            let count = sparse.count();
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_size = indices.index_type().size();
            self.check_view(number, &indices.view(), indices.offset(), count, index_size)?;
            self.check_view(number, &values.view(), values.offset(), count, size)?;
        }
        read().ok_or_else(|| self.fault(format!("accessor {number} does not fit its buffer")))
    }

    /// Checks that `count` items of `size` bytes lie inside the view, and the
    /// view inside its buffer.
    fn check_view(
        &self,
        accessor: usize,
        view: &buffer::View<'_>,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<(), ImportError> {
        let stride = view.stride().unwrap_or(size);
        if stride < size || count == 0 {
            return Err(self.fault(format!(
                "accessor {accessor} has {count} items of {size} bytes every {stride} bytes"
            )));
        }
        let items = offset as u128 + (count as u128 - 1) * stride as u128 + size as u128;
        let view_end = view.offset() as u128 + view.length() as u128;
        let buffer = self.buffer(&view.buffer()).map_or(0, <[u8]>::len);
        for (what, claimed, available) in [
            (format!("accessor {accessor}"), items, view.length()),
            (format!("buffer view {}", view.index()), view_end, buffer),
        ] {
            if claimed > available as u128 {
                return Err(claim(self.path, &what, claimed, available));
            }
        }
        Ok(())
    }
}

/// Turns normals as `transform` turns surfaces: its cofactors, which exist
/// also where its inverse does not, without the sign of a reflection.
fn normal_matrix(transform: Mat4) -> Mat3 {
    let m = Mat3::from_mat4(transform);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(
        m.y_axis.cross(m.z_axis) * sign,
        m.z_axis.cross(m.x_axis) * sign,
        m.x_axis.cross(m.y_axis) * sign,
    )
}

/// Fills in the materials; triangles without one get the default, and a mesh
/// without any stays without.
fn paint(document: &Document, mesh: &mut TriangleMesh) {
    mesh.materials = document.materials().map(|m| whitted(&m)).collect();
    let fallback = mesh.materials.len() as u32;
    if fallback == 0 {
        mesh.triangle_materials.clear();
        return;
    }
    for material in &mut mesh.triangle_materials {
        *material = (*material).min(fallback);
    }
    if mesh.triangle_materials.contains(&fallback) {
        mesh.materials.push(Material::default());
    }
}

/// Maps a material onto Whitted's terms, as [`super::load`] documents.
fn whitted(material: &gltf::Material<'_>) -> Material {
    let default = Material::default();
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    let base = bounded_colour([r, g, b]);
    let metalness = bounded(pbr.metallic_factor(), 0.0, 1.0);
    let roughness = bounded(pbr.roughness_factor(), 0.0, 1.0);
    let transmission = material
        .transmission()
        .map_or(0.0, |t| bounded(t.transmission_factor(), 0.0, 1.0));
    let is_mirror = metalness >= METALLIC && roughness <= SMOOTH;
    // Dielectrics reflect about 4 % head-on, metals their own colour.
    let specular = base.map(|channel| 0.04 + (channel - 0.04) * metalness);
    // The exponent whose lobe is as wide as the microfacets' of this roughness.
    let alpha = roughness * roughness;
    let shininess = 2.0 / (alpha * alpha).max(f32::MIN_POSITIVE) - 2.0;
    // 0 is the extension's mark for a surface without Fresnel's terms.
    let index = material.ior();
    let index = index.filter(|index| *index > 0.0 && index.is_finite());
    Material {
        diffuse: if is_mirror {
            [0.0; 3]
        } else {
            base.map(|channel| channel * (1.0 - transmission))
        },
        specular,
        shininess: bounded(shininess, 1.0, 10_000.0),
        mirror: if is_mirror { base } else { default.mirror },
        transmission: base.map(|channel| channel * transmission),
        index_of_refraction: index.unwrap_or(default.index_of_refraction),
        absorption: material
            .volume()
            .filter(|volume| volume.thickness_factor() > 0.0)
            .map_or(default.absorption, |volume| absorption(&volume)),
        ..default
    }
}

/// Beer's coefficients from the colour that white light has after a distance.
fn absorption(volume: &gltf::material::Volume<'_>) -> [f32; 3] {
    let distance = volume.attenuation_distance();
    if distance.is_finite() && distance > 0.0 {
        // Black would be absorbed without end.
        let colour = volume.attenuation_color();
        colour.map(|channel| bounded(-bounded(channel, 1.0e-4, 1.0).ln() / distance, 0.0, 1.0e6))
    } else {
        [0.0; 3]
    }
}

#[cfg(test)]
pub(super) mod tests;
