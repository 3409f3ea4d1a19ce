//! Meshes from files: Wavefront OBJ, PLY and glTF 2.0.

use std::fmt;
use std::path::{Path, PathBuf};

use glam::Vec3;
use thiserror::Error;

use crate::scene::mesh::{MeshError, TriangleMesh};
use crate::scene::texture::ImageError;

mod gltf;
mod obj;
mod ply;

/// A file, and a line in it where one is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1; none for binary files and for faults of the
    /// file as a whole.
    pub line: Option<usize>,
}

impl Place {
    fn line(path: &Path, line: usize) -> Self {
        Self {
            path: path.to_owned(),
            line: Some(line),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        match self.line {
            Some(line) => write!(f, ":{line}"),
            None => Ok(()),
        }
    }
}

/// Why a file gives no mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ImportError {
    /// An extension of no known format.
    #[error(
        "{}: the file name's extension names no mesh format; export as .obj, .ply, .gltf or .glb",
        .path.display()
    )]
    UnknownFormat { path: PathBuf },
    /// A file that is not there or cannot be read.
    #[error("{}: {fault}; check the file's name and permissions", .path.display())]
    Read {
        path: PathBuf,
        fault: std::io::Error,
    },
    /// Contents that are not the format's.
    #[error("{place}: {}; correct it there, or export the mesh again", problem.trim_end_matches('.'))]
    Syntax { place: Place, problem: String },
    /// A length or count beyond the end of the file.
    #[error(
        "{place}: {what} takes {claimed} bytes at least, but only {available} are there; \
         the file is cut off or damaged: export the mesh again"
    )]
    Claim {
        place: Place,
        what: String,
        claimed: u128,
        available: u64,
    },
    /// A face with a vertex that does not exist.
    #[error(
        "{place}: face {face} (counted from 0) names vertex {index}, but the vertices \
         go from {first} to {last}; correct it there, or export the mesh again"
    )]
    VertexOutOfRange {
        place: Place,
        /// The face, counted from 0 in the file's order.
        face: usize,
        index: i64,
        first: i64,
        last: i64,
    },
    /// A texture of one of its materials that cannot be loaded.
    #[error(transparent)]
    Texture(#[from] ImageError),
    /// A file without faults whose mesh cannot be used.
    #[error("{place}: {fault}; repair the mesh in a modelling program and export it again")]
    Mesh { place: Place, fault: MeshError },
}

/// Reads a triangle mesh. The extension, in upper or lower case, decides the format.
///
/// Polygons become fans of triangles around their first corner, and triangles
/// keep the file's order. Normals are made unit length; a mesh with a normal
/// that has no direction, or with normals at only some of its vertices, comes
/// without any. So does one with texture coordinates at only some of its
/// vertices, or with one beyond [`TriangleMesh::FARTHEST_COORDINATE`], and
/// without coordinates it has no textures. Textures are PNG files; others are
/// not read. They multiply the diffuse reflectance.
///
/// - `.obj`: groups and objects become one mesh. Without normals and texture
///   coordinates the vertices are the file's, in its order; with either, each
///   position with its normal and `vt` is one vertex, in order of first use.
///   Only the first three numbers of a `v` count, and two of a `vt`. Lines, points and curves are skipped. The materials come
///   from the `.mtl` files named in it, as far as these exist: `Kd` and
///   `Ks` are the diffuse and specular reflectance, `Ns` the shininess and
///   `Ni` the index of refraction, `map_Kd` the texture; `illum` 3, 5 or 8 makes `Ks` the mirror
///   reflectance too. What `d` (or 1 - `Tr`) leaves of the light is
///   transmitted, filtered by `Tf`, and dims `Kd`; `illum` 4, 6, 7 or 9
///   without `d` and `Tr` transmits `Tf`, or all.
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
            return Err(ImportError::UnknownFormat {
                path: path.to_owned(),
            });
        }
    };
    parse(path, &read(path)?)
}

fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    crate::files::read(path).map_err(|fault| ImportError::Read {
        path: path.to_owned(),
        fault,
    })
}

impl From<&Path> for Place {
    fn from(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            line: None,
        }
    }
}

fn claim(path: &Path, what: impl Into<String>, claimed: u128, available: usize) -> ImportError {
    ImportError::Claim {
        place: path.into(),
        what: what.into(),
        claimed,
        available: available as u64,
    }
}

fn syntax(place: impl Into<Place>, problem: impl Into<String>) -> ImportError {
    ImportError::Syntax {
        place: place.into(),
        problem: problem.into(),
    }
}

/// Validates the mesh; `line_of` returns the line of a triangle where it is known.
fn validated(
    mesh: TriangleMesh,
    path: &Path,
    line_of: impl Fn(usize) -> Option<usize>,
) -> Result<TriangleMesh, ImportError> {
    match mesh.validate() {
        Ok(()) => Ok(mesh),
        Err(fault) => {
            let line = match fault {
                MeshError::IndexOutOfRange { triangle, .. }
                | MeshError::RepeatedVertex { triangle, .. } => line_of(triangle),
                _ => None,
            };
            let path = path.to_owned();
            Err(ImportError::Mesh {
                place: Place { path, line },
                fault,
            })
        }
    }
}

/// The normals at unit length; empty if one of them has no direction.
fn unit_normals(mut normals: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    for normal in &mut normals {
        match Vec3::from_array(*normal).try_normalize() {
            Some(unit) => *normal = unit.to_array(),
            None => return Vec::new(),
        }
    }
    normals
}

/// The texture coordinates; empty if one of them is out of range or NaN.
fn usable_coordinates(coordinates: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    let limit = TriangleMesh::FARTHEST_COORDINATE;
    let usable = |place: &[f32; 2]| place.iter().all(|c| c.abs() <= limit);
    if coordinates.iter().all(usable) {
        coordinates
    } else {
        Vec::new()
    }
}

/// The triangles of a polygon, around its first corner.
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
