//! Meshes from files: Wavefront OBJ, PLY and glTF 2.0.

use crate::files::{Fault, UNREAD};
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::{Image, ImageError, Pattern, Texture};
use glam::Vec3;
use miette::Diagnostic;
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt;
use std::hash::Hash;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;

mod gltf;
mod obj;
mod ply;

/// A file, and a line in it where one is known.
#[derive(Clone, Copy)]
struct Place<'p> {
    path: &'p Path,
    line: Option<usize>,
}

impl<'p> From<&'p Path> for Place<'p> {
    fn from(path: &'p Path) -> Self {
        Self { path, line: None }
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.line.map_or(Ok(()), |line| write!(f, ":{line}"))
    }
}

/// Why a file gives no mesh: what is wrong, where, and what to do.
#[derive(Debug, Error, Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub struct ImportError(Fault);

/// Reads a triangle mesh. The extension, in upper or lower case, decides the format.
///
/// Polygons become fans of triangles around their first corner, and triangles keep the file's
/// order. Normals are made unit length; a mesh with a normal that has no direction, or with normals
/// at only some of its vertices, comes without any. So does one with texture coordinates at only
/// some of its vertices, or with one beyond [`TriangleMesh::FARTHEST_COORDINATE`], and without
/// coordinates it has no textures. Textures are PNG files; others are not read. They multiply the
/// diffuse reflectance.
///
/// - `.obj`: groups and objects become one mesh. Without normals and texture
///   coordinates the vertices are the file's, in its order; with either, each
///   position with its normal and `vt` is one vertex, in order of first use. Only the first three
///   numbers of a `v` count, and two of a `vt`. Lines, points and curves are skipped. The
///   materials come from the `.mtl` files named in it, as far as these exist: `Kd` and `Ks` are
///   the diffuse and specular reflectance, `Ns` the shininess and `Ni` the index of refraction,
///   `map_Kd` the texture; `illum` 3, 5 or 8 makes `Ks` the mirror reflectance, too. The light
///   that `d` (or 1 - `Tr`) does not stop is transmitted, filtered by `Tf`, and dims `Kd`;
///   `illum` 4, 6, 7 or 9 without `d` and `Tr` transmits `Tf`, or all.
/// - `.ply`: ASCII and binary, either endianness; `x`, `y`, `z`, optionally
///   `nx`, `ny`, `nz`, and `s`, `t` or `u`, `v` or `texture_u`, `texture_v`;
///   faces from `vertex_indices` or `vertex_index`.
/// - `.gltf` and `.glb`: every triangle primitive in the default scene (or the
///   first), in world space. The base colour, with its texture where that uses
///   the first set of coordinates, is the diffuse reflectance; a
///   metalness of 0.5 or more at a roughness of 0.3 or less makes it the
///   mirror reflectance instead. `KHR_materials_transmission`, `_ior` and
///   `_volume` give transmission, index of refraction and absorption.
///
/// # Errors
/// If the file cannot be read, is not of the format that its extension
/// promises, or holds no mesh that passes [`TriangleMesh::validate`].
pub fn load(path: &Path) -> Result<TriangleMesh, ImportError> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    let parse = match extension.as_deref() {
        Some("obj") => obj::parse,
        Some("ply") => ply::parse,
        Some("gltf" | "glb") => gltf::parse,
        _ => {
            let problem = "the file name's extension names no mesh format";
            return Err(fault(path, problem, "export as .obj, .ply, .gltf or .glb"));
        }
    };
    parse(path, &read(path)?)
}

fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    crate::files::read(path).map_err(|fault| unread(path, &fault))
}

/// Returns what is wrong, where, and what to do.
fn fault<'p>(place: impl Into<Place<'p>>, problem: impl fmt::Display, advice: &str) -> ImportError {
    let message = format!("{}: {problem}", place.into());
    ImportError(Fault::new(message, advice))
}

fn unread(path: &Path, error: &std::io::Error) -> ImportError {
    fault(path, error, UNREAD)
}

/// Returns the error of a length or count beyond the end of the file.
fn claim(path: &Path, what: &str, claimed: u128, available: usize) -> ImportError {
    let problem = format!(
        "the file is cut off or damaged: {what} takes {claimed} bytes at least, but only \
         {available} are there"
    );
    fault(path, problem, "export the mesh again")
}

fn syntax<'p>(place: impl Into<Place<'p>>, problem: impl AsRef<str>) -> ImportError {
    let problem = problem.as_ref().trim_end_matches('.');
    fault(place, problem, "correct it there, or export the mesh again")
}

/// Returns the error of a file without faults whose mesh cannot be used.
fn unusable<'p>(place: impl Into<Place<'p>>, error: impl fmt::Display) -> ImportError {
    let advice = "repair the mesh in a modelling program and export it again";
    fault(place, error, advice)
}

/// Returns the error of a face that names a vertex which does not exist.
fn no_vertex<'p>(
    place: impl Into<Place<'p>>,
    face: &str,
    index: i64,
    [first, last]: [i64; 2],
) -> ImportError {
    let problem =
        format!("{face} names vertex {index}, but the vertices go from {first} to {last}");
    syntax(place, problem)
}

/// Validates the mesh, whose faces name known vertices; `line_of` returns the line of a triangle
/// where it is known.
fn validated(
    mesh: TriangleMesh,
    path: &Path,
    line_of: impl FnOnce(usize) -> Option<usize>,
) -> Result<TriangleMesh, ImportError> {
    mesh.validate()
        .map_err(|fault| match fault.triangle.and_then(line_of) {
            None => unusable(path, fault),
            line => unusable(Place { path, line }, "the face names a vertex twice"),
        })?;
    Ok(mesh)
}

struct Textures<K> {
    /// Bytes that further images may take.
    left: u64,
    images: HashMap<K, Option<Arc<Image>>>,
}

impl<K: Hash + Eq> Textures<K> {
    fn new() -> Self {
        Self {
            left: Image::MOST_BYTES,
            images: HashMap::new(),
        }
    }

    /// Returns the texture with an image, which `read` has the bytes of, if that is a PNG file.
    fn get<'b>(
        &mut self,
        key: K,
        path: &Path,
        read: impl FnOnce() -> Result<Cow<'b, [u8]>, ImportError>,
    ) -> Result<Option<Texture>, ImportError> {
        let image = match self.images.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let bytes = read()?;
                let image = Image::is_png(&bytes)
                    .then(|| Image::from_png(path, &bytes, &mut self.left))
                    .transpose();
                let image = image.map_err(|ImageError(fault)| ImportError(fault))?;
                new.insert(image.map(Arc::new))
            }
        };
        Ok(image.clone().map(|image| Texture {
            pattern: Pattern::Image(image),
            repeats: [1.0; 2],
        }))
    }
}

/// Returns the normals at unit length; empty if one of them has no direction.
fn unit_normals(mut normals: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    for normal in &mut normals {
        match Vec3::from_array(*normal).try_normalize() {
            Some(unit) => *normal = unit.to_array(),
            None => return Vec::new(),
        }
    }
    normals
}

/// Returns the texture coordinates; empty if one of them is out of range or NaN.
fn usable_coordinates(coordinates: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    let limit = TriangleMesh::FARTHEST_COORDINATE;
    let usable = |place: &[f32; 2]| place.iter().all(|c| c.abs() <= limit);
    if coordinates.iter().all(usable) {
        coordinates
    } else {
        Vec::new()
    }
}

/// Returns the triangles of a polygon, around its first corner.
fn fan<C: Copy>(corners: &[C]) -> Vec<[C; 3]> {
    let edges = corners[1..].windows(2);
    edges.map(|edge| [corners[0], edge[0], edge[1]]).collect()
}

/// `value` within the range; its lower end for NaN.
fn bounded(value: f32, low: f32, high: f32) -> f32 {
    if value.is_nan() {
        low
    } else {
        value.clamp(low, high)
    }
}

fn bounded_colour(colour: [f32; 3]) -> [f32; 3] {
    colour.map(|channel| bounded(channel, 0.0, 1.0))
}

#[cfg(test)]
mod tests;
