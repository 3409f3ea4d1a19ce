//! Models from files: Wavefront OBJ, PLY, STL, VTK's XML (`.vtp`) and glTF 2.0.

use crate::files::{Fault, UNREAD, read_within};
use crate::scene::Light;
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::Rig;
use crate::scene::texture::Image;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use glam::{DVec3, Vec3};
use miette::Diagnostic;
use palette::Srgb;
use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt;
use std::hash::Hash;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use thiserror::Error;

mod camera;
mod gltf;
mod number;
mod obj;
mod ply;
mod polygon;
mod stl;
mod unused;
mod vtp;

pub use camera::Camera;
pub use unused::Unused;

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

impl ImportError {
    /// Returns what is wrong, without the name of the file.
    fn without(&self, file: &Path) -> String {
        let whole = self.to_string();
        let rest = whole.strip_prefix(&format!("{}: ", file.display()));
        rest.unwrap_or(&whole).to_owned()
    }
}

/// What a file describes.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Its surfaces.
    pub mesh: TriangleMesh,
    /// Its lights, in the same units.
    pub lights: Vec<Light>,
    /// Its cameras.
    pub cameras: Vec<Camera>,
    /// The quantity that its vertices' colours show, if they show one.
    pub scalar: Option<Scalar>,
    /// What of it moves. The mesh has all of it, at rest.
    pub rig: Rig,
    /// What it has besides, and no picture shows.
    pub unused: Unused,
}

impl From<TriangleMesh> for Model {
    /// Nothing but the mesh.
    fn from(mesh: TriangleMesh) -> Self {
        Self {
            mesh,
            lights: Vec::new(),
            cameras: Vec::new(),
            scalar: None,
            rig: Rig::default(),
            unused: Unused::default(),
        }
    }
}

/// A quantity that colours show, from dark violet to yellow.
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar {
    /// The name that its file gives it.
    pub name: String,
    /// Its least finite number, in the file's unit.
    pub least: f32,
    /// Its greatest finite number.
    pub greatest: f32,
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, least, greatest) = (&self.name, self.least, self.greatest);
        write!(f, "{name} from {least} (violet) to {greatest} (yellow)")
    }
}

/// Extensions of the files that [`load`] reads, in lower case.
pub const EXTENSIONS: [&str; 6] = ["obj", "ply", "gltf", "glb", "stl", "vtp"];

/// What to do about a file that is not a model.
pub(crate) const EXPORT: &str = "export as .obj, .ply, .stl, .vtp, .gltf or .glb";

/// Base64 with or without its padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Reads a model. The extension, in upper or lower case, decides the format.
///
/// Triangles keep the file's order. Polygons are cut in their own plane: around their first corner
/// where they are convex. Faces without area by their corners are left out, and so is a face that
/// is another one turned over, where the file has no normals. Normals are made unit length; a
/// vertex without one has the mean of its faces. A vertex without a place on textures is at 0, 0.
/// Textures are PNG and JPEG files.
///
/// - `.obj`: groups and objects become one mesh. Without normals and texture
///   coordinates the vertices are the file's, in its order; with either, each
///   position with its normal and `vt` is one vertex, in order of first use. Numbers four to six of a
///   `v` are a colour as sRGB codes it; two of a `vt` count. Faces without normals are smooth within their
///   smoothing group, and flat where it is off. Lines, points and curves are not shown. The
///   materials come from the `.mtl` files named in it: `Kd` and `Ks` are
///   the diffuse and specular reflectance, `Ke` the emission, `Ns` the shininess and `Ni` the index
///   of refraction, `map_Kd` and `map_Ke` the textures, `norm` the normal map; `illum` 3, 5 or 8 makes `Ks` the mirror reflectance, too.
///   The light that `d` (or 1 - `Tr`) does not stop is transmitted, filtered by `Tf`, and dims
///   `Kd`; `illum` 4, 6, 7 or 9 without `d` and `Tr` transmits `Tf`, or all.
/// - `.ply`: ASCII and binary, either endianness; `x`, `y`, `z`, optionally
///   `nx`, `ny`, `nz`, and `s`, `t` or `u`, `v` or `texture_u`, `texture_v`;
///   colours of vertices or faces as sRGB codes them from `red`, `green`, `blue` or `r`, `g`, `b`;
///   faces from `vertex_indices` or `vertex_index`, or `tristrips`; textures of `comment
///   TextureFile`, by `texnumber`, where vertices or the faces' `texcoord` say.
/// - `.stl`: ASCII and binary, flat.
/// - `.vtp`: polygons and strips of all pieces, in text, base64 or raw bytes, also compressed by
///   zlib. Colours show the active scalar of the points, else of the cells, else the first, in
///   viridis over its finite range; three or four numbers of `UInt8` are colours as sRGB codes them.
/// - `.gltf` and `.glb`: every triangle primitive in the default scene (or the
///   first), in world space, skins and morph targets at rest. Animations move nodes, skins and the
///   weights of morph targets; the first one plays. The base colour is the diffuse
///   reflectance, and with metalness and roughness that of
///   [microfacets](crate::scene::material::Microfacets);
///   blending by its alpha shows what is straight behind. `KHR_materials_transmission`, `_ior`,
///   `_dispersion` and `_volume` give transmission (of a thin wall where there is no volume), index of
///   refraction, its change with the wavelength and absorption, `_unlit` emission alone,
///   `_pbrSpecularGlossiness` the diffuse and specular reflectance and the shininess.
///   Textures of colour, metal, emission and normals may use two sets of coordinates. Tangents are the
///   file's, or by `MikkTSpace`. Primitives without normals are flat. Buffer views may be compressed with meshopt, not with Draco.
///
/// # Errors
/// If the file cannot be read or is larger than [`MOST`](crate::files::MOST), is not of the format
/// that its extension promises, or holds no mesh that passes [`TriangleMesh::validate`].
pub fn load(path: &Path) -> Result<Model, ImportError> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    let parse = match extension.as_deref() {
        Some("obj") => obj::parse,
        Some("ply") => ply::parse,
        Some("stl") => stl::parse,
        Some("vtp") => vtp::parse,
        Some("gltf" | "glb") => gltf::parse,
        _ => {
            let problem = "the file name's extension names no format of meshes";
            return Err(fault(path, problem, EXPORT));
        }
    };
    let bytes = read(path)?;
    if is_utf16(&bytes) {
        let problem = "this is text in UTF-16";
        return Err(fault(path, problem, "save it as UTF-8 with a text editor"));
    }
    parse(path, bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes))
}

/// Returns whether bytes begin with the mark of text in UTF-16.
fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff")
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
    let advice = match error.kind() {
        ErrorKind::FileTooLarge => "simplify the mesh, or export it in parts",
        _ => UNREAD,
    };
    fault(path, error, advice)
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

/// Leaves out what cannot be drawn of a mesh, whose faces name known vertices, and checks the rest.
fn finished(path: &Path, mut mesh: TriangleMesh, mut unused: Unused) -> Result<Model, ImportError> {
    let places = mesh.positions.iter();
    let are_places: Vec<bool> = places
        .map(|place| TriangleMesh::check_position(*place).is_ok())
        .collect();
    let exists = |three: &[u32; 3]| three.iter().all(|v| are_places[*v as usize]);
    if are_places.contains(&false) && mesh.triangles.iter().any(exists) {
        let count = retain(&mut mesh, exists);
        unused.add(
            "face{s} with a vertex that is no number or too far out",
            count,
        );
        let some = mesh.positions[mesh.triangles[0][0] as usize];
        for (position, is_place) in mesh.positions.iter_mut().zip(are_places) {
            if !is_place {
                *position = some;
            }
        }
    }
    let has_area = |&[a, b, c]: &[u32; 3]| a != b && b != c && a != c;
    let count = retain(&mut mesh, has_area);
    unused.add("face{s} without area", count);
    if !mesh.normals.is_empty() {
        complete_normals(&mut mesh);
    }
    let limit = TriangleMesh::FARTHEST_COORDINATE;
    let mut out_of_range = 0;
    for set in [&mut mesh.coordinates, &mut mesh.second_coordinates] {
        for place in set {
            if !place.iter().all(|c| c.abs() <= limit) {
                *place = [0.0; 2];
                out_of_range += 1;
            }
        }
    }
    unused.add("texture coordinate{s} out of range", out_of_range);
    for colour in &mut mesh.colours {
        *colour = bounded_colour(*colour);
    }
    mesh.validate().map_err(|fault| unusable(path, fault))?;
    Ok(Model {
        unused,
        ..mesh.into()
    })
}

/// Keeps some triangles, with their materials; returns the number of others.
fn retain(mesh: &mut TriangleMesh, is_kept: impl Fn(&[u32; 3]) -> bool) -> u64 {
    let kept: Vec<bool> = mesh.triangles.iter().map(is_kept).collect();
    let others = kept.iter().filter(|kept| !**kept).count();
    if others > 0 {
        let (mut of_triangles, mut of_materials) = (kept.iter(), kept.iter());
        mesh.triangles
            .retain(|_| of_triangles.next() == Some(&true));
        let materials = &mut mesh.triangle_materials;
        materials.retain(|_| of_materials.next() == Some(&true));
    }
    others as u64
}

/// Makes normals unit length; one without a direction becomes the mean of the faces around it.
fn complete_normals(mesh: &mut TriangleMesh) {
    let mut normals = std::mem::take(&mut mesh.normals);
    let mut own = None;
    for (vertex, normal) in normals.iter_mut().enumerate() {
        *normal = match Vec3::from_array(*normal).try_normalize() {
            Some(unit) => unit.to_array(),
            None => own.get_or_insert_with(|| mesh.vertex_normals().into_owned())[vertex],
        };
    }
    mesh.normals = normals;
}

/// The images of a model, each read once.
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

    /// Returns an image, which `read` has the bytes of; none, and a kind of `unused`, if it cannot
    /// be shown.
    fn get<'b>(
        &mut self,
        key: K,
        name: &str,
        unused: &mut Unused,
        read: impl FnOnce() -> Result<Cow<'b, [u8]>, String>,
    ) -> Option<Arc<Image>> {
        let image = match self.images.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let image = read().and_then(|bytes| Image::decode(&bytes, &mut self.left));
                let image = image.map_err(|reason| {
                    unused.add(format!("the texture {name} ({reason})"), 1);
                });
                new.insert(image.ok().map(Arc::new))
            }
        };
        image.clone()
    }
}

impl Textures<String> {
    /// Returns the image that a file names: where its name says, else beside that file.
    fn beside(&mut self, file: &Path, name: &str, unused: &mut Unused) -> Option<Arc<Image>> {
        let read = || Ok(read_one_of(&beside(file, name))?.into());
        self.get(name.to_owned(), name, unused, read)
    }
}

/// Returns where a file may be that another names, perhaps with a path of another computer.
fn beside(file: &Path, name: &str) -> [PathBuf; 2] {
    let name = name.replace('\\', "/");
    let last = name.rsplit('/').next().unwrap_or(&name);
    [file.with_file_name(&name), file.with_file_name(last)]
}

/// What is wrong with a file that another names and that does not exist.
const NOT_THERE: &str = "which is not there";

/// Returns the bytes of the first of several image files that is there.
fn read_one_of(paths: &[PathBuf]) -> Result<Vec<u8>, String> {
    read_one_within(paths, Image::MOST_BYTES >> 20)
}

/// Returns the bytes of the first of several files that is there, of up to `most` MiB.
fn read_one_within(paths: &[PathBuf], most: u64) -> Result<Vec<u8>, String> {
    let mut all = paths.iter().map(|path| read_within(path, most));
    let found = all.find(|read| !matches!(read, Err(fault) if fault.kind() == ErrorKind::NotFound));
    let none = || Err(ErrorKind::NotFound.into());
    found
        .unwrap_or_else(none)
        .map_err(|fault| match fault.kind() {
            ErrorKind::NotFound => NOT_THERE.to_owned(),
            _ => fault.to_string(),
        })
}

/// Returns the normal of a triangle, at unit length; up where it has no area.
pub(super) fn flat_normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| DVec3::from(corner.map(f64::from)));
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
    normal.as_vec3().to_array()
}

/// Returns a statement's words up to a comment, which a blank precedes.
fn without_comment(words: &str) -> &str {
    let mut marks = words.match_indices('#').map(|(at, _)| at);
    let starts = |&at: &usize| words[..at].ends_with(char::is_whitespace) || at == 0;
    words[..marks.find(starts).unwrap_or(words.len())].trim()
}

fn three_floats<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    let mut numbers = words.map_while(|word| f32::from_str(word).ok());
    Some([numbers.next()?, numbers.next()?, numbers.next()?])
}

/// Returns the light of an sRGB code from 0 to 1.
fn decoded(code: f32) -> f32 {
    Srgb::<f32>::new(code, 0.0, 0.0).into_linear().red
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
