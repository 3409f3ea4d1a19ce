//! Wavefront OBJ, and its material libraries.

mod library;

use super::polygon::{Polygons, twins};
use super::{
    EXPORT, ImportError, Model, Place, Textures, Unused, decoded, fault, finished, no_vertex,
    syntax, three_floats, without_comment,
};
use crate::scene::material::{Alpha, Material, NormalMap};
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::Texture;
use glam::DVec3;
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::str::FromStr;

/// A corner of a face, indices counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    coordinate: Option<u32>,
    normal: Normal,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Normal {
    /// One of the file's.
    Own(u32),
    /// The mean of the faces around the position that are in a smoothing group.
    Smooth(u32),
    /// That of a face, by its number.
    Flat(u32),
}

#[derive(Default)]
struct Geometry {
    positions: Vec<[f32; 3]>,
    /// One a position, as sRGB codes them from 0 to 1; empty if none has one.
    colours: Vec<[f32; 3]>,
    coordinates: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// The corners of all faces, in the file's order.
    corners: Vec<Corner>,
    /// For each face, where its corners end.
    ends: Vec<usize>,
    /// For each face, its line.
    lines: Vec<Option<usize>>,
    /// For each face, its place in `names`.
    materials: Vec<usize>,
    /// The names of materials in use, one after another; before the first `usemtl` it is empty.
    names: Vec<String>,
    libraries: Vec<String>,
    /// The current smoothing group; 0 is none.
    group: u32,
    unused: Unused,
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Model, ImportError> {
    let mut geometry = Geometry::scan(path, &String::from_utf8_lossy(bytes))?;
    geometry.check(path)?;
    let (mesh, faces) = geometry.mesh();
    let mut unused = std::mem::take(&mut geometry.unused);
    let mesh = geometry.painted(path, mesh, &faces, &mut unused);
    finished(path, mesh, unused)
}

/// Returns the file's statements with their lines. A backslash joins two lines, but
/// not after a comment, where it is a drawing or a path.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().zip(1..);
    std::iter::from_fn(move || {
        let (first, line) = lines.next()?;
        let start = first.strip_suffix('\\');
        let Some(start) = start.filter(|start| !start.trim_start().starts_with('#')) else {
            return Some((line, Cow::Borrowed(first)));
        };
        let mut joined = start.to_owned();
        for (next, _) in lines.by_ref() {
            joined.push(' ');
            let part = next.strip_suffix('\\');
            joined.push_str(part.unwrap_or(next));
            if part.is_none() {
                break;
            }
        }
        Some((line, Cow::Owned(joined)))
    })
}

impl Geometry {
    fn scan(path: &Path, text: &str) -> Result<Self, ImportError> {
        let mut geometry = Self {
            // Files without groups are smooth.
            group: 1,
            names: vec![String::new()],
            ..Self::default()
        };
        for (line, statement) in statements(text) {
            let line = Some(line);
            let at = Place { path, line };
            let trimmed = statement.trim();
            let (keyword, rest) = trimmed
                .split_once(char::is_whitespace)
                .unwrap_or((trimmed, ""));
            let rest = without_comment(rest);
            let words = rest.split_whitespace();
            match keyword {
                "v" => {
                    let problem = "a vertex needs three coordinates that are numbers";
                    let position = three_floats(words.clone());
                    let position = position.ok_or_else(|| syntax(at, problem))?;
                    if let Some(colour) = three_floats(words.skip(3)) {
                        geometry.colours.resize(geometry.positions.len(), [1.0; 3]);
                        geometry.colours.push(colour);
                    }
                    geometry.positions.push(position);
                }
                // What is no normal gets one at the end.
                "vn" => {
                    let normal = three_floats(words).unwrap_or_default();
                    geometry.normals.push(normal);
                }
                "vt" => {
                    let mut numbers = words.map_while(|word| f32::from_str(word).ok());
                    let u = numbers.next().unwrap_or(f32::NAN);
                    let v = numbers.next().unwrap_or(0.0);
                    geometry.coordinates.push([u, v]);
                }
                "f" => geometry.add_face(at, words)?,
                "s" => {
                    // "off" is no number.
                    geometry.group = rest.parse().unwrap_or(0);
                }
                "usemtl" => geometry.names.push(rest.to_owned()),
                "mtllib" if !rest.is_empty() => geometry.libraries.push(rest.to_owned()),
                "l" => geometry.unused.add("line{s}", 1),
                "p" => geometry.unused.add("point{s}", 1),
                "curv" | "curv2" => geometry.unused.add("curve{s}", 1),
                "surf" => geometry.unused.add("curved surface{s}", 1),
                _ => {}
            }
        }
        if geometry.positions.is_empty() && geometry.lines.is_empty() {
            let problem = "no line describes a vertex or a face: is this an OBJ file?";
            return Err(fault(path, problem, EXPORT));
        }
        Ok(geometry)
    }

    /// Reads corners such as `v`, `v/vt`, `v//vn` or `v/vt/vn`. Negative indices count back
    /// from the latest; whether positive ones exist shows at the end only.
    fn add_face<'w>(
        &mut self,
        at: Place<'_>,
        words: impl Iterator<Item = &'w str>,
    ) -> Result<(), ImportError> {
        let first = self.corners.len();
        let face = self.lines.len() as u32;
        for word in words {
            let corner = self.corner(at, word, face)?;
            // The same position twice is an edge without length.
            let last = self.corners[first..].last();
            if last.is_none_or(|last| last.position != corner.position) {
                self.corners.push(corner);
            }
        }
        let corners = &self.corners[first..];
        if corners.len() > 1 && corners[0].position == corners[corners.len() - 1].position {
            self.corners.pop();
        }
        if self.corners.len() - first < 3 {
            self.corners.truncate(first);
            self.unused.add("face{s} without area", 1);
            return Ok(());
        }
        self.ends.push(self.corners.len());
        self.lines.push(at.line);
        self.materials.push(self.names.len() - 1);
        Ok(())
    }

    fn corner(&self, at: Place<'_>, word: &str, face: u32) -> Result<Corner, ImportError> {
        let mut fields = word.split('/');
        let mut index = || {
            let field = fields.next().unwrap_or_default();
            (!field.is_empty()).then(|| i64::from_str(field))
        };
        let (position, texture, normal) = (index(), index(), index());
        let (Some(Ok(position)), None | Some(Ok(_)), None | Some(Ok(_)), None) =
            (&position, &texture, &normal, fields.next())
        else {
            return Err(syntax(
                at,
                format!("'{word}' is no corner of a face, such as 7, 7/1, 7//2 or 7/1/2"),
            ));
        };
        let position = from_zero(*position, self.positions.len())
            .ok_or_else(|| self.no_vertex(at, *position))?;
        // Some files name normals and coordinates without having any.
        let known = |index: Option<Result<i64, _>>, count| from_zero(index?.ok()?, count);
        Ok(Corner {
            position,
            coordinate: known(texture, self.coordinates.len()),
            normal: match (known(normal, self.normals.len()), self.group) {
                (Some(normal), _) => Normal::Own(normal),
                (None, 0) => Normal::Flat(face),
                (None, group) => Normal::Smooth(group),
            },
        })
    }

    fn no_vertex(&self, at: Place<'_>, index: i64) -> ImportError {
        no_vertex(at, "the face", index, [1, self.positions.len() as i64])
    }

    /// Refuses faces that name positions which do not exist; other indices become none.
    fn check(&mut self, path: &Path) -> Result<(), ImportError> {
        let mut missing = [0, 0];
        let mut first = 0;
        for (&end, &line) in self.ends.iter().zip(&self.lines) {
            for corner in &mut self.corners[first..end] {
                if corner.position as usize >= self.positions.len() {
                    let index = i64::from(corner.position) + 1;
                    let last = self.positions.len() as i64;
                    return Err(no_vertex(
                        Place { path, line },
                        "the face",
                        index,
                        [1, last],
                    ));
                }
                if let Normal::Own(normal) = corner.normal
                    && normal as usize >= self.normals.len()
                {
                    corner.normal = Normal::Smooth(1);
                    missing[0] += 1;
                }
                if let Some(place) = corner.coordinate
                    && place as usize >= self.coordinates.len()
                {
                    corner.coordinate = None;
                    missing[1] += 1;
                }
            }
            first = end;
        }
        self.unused
            .add("normal{s} that faces name and the file lacks", missing[0]);
        self.unused.add(
            "texture coordinate{s} that faces name and the file lacks",
            missing[1],
        );
        Ok(())
    }

    /// Returns the corners of all triangles, and for each triangle its face.
    fn triangles(&self) -> (Vec<[Corner; 3]>, Vec<u32>) {
        let twins = twins(&self.corners, &self.ends, |corner| corner.position);
        let mut polygons = Polygons::default();
        let (mut triangles, mut faces) = (Vec::new(), Vec::new());
        let mut first = 0;
        for ((&end, is_twin), face) in self.ends.iter().zip(twins).zip(0..) {
            let corners = &self.corners[first..end];
            first = end;
            let has_own = |corner: &Corner| matches!(corner.normal, Normal::Own(_));
            if is_twin && !corners.iter().any(has_own) {
                continue;
            }
            let place = |corner: Corner| self.positions[corner.position as usize];
            polygons.cut(corners, place, |triangle| {
                triangles.push(triangle);
                faces.push(face);
            });
        }
        (triangles, faces)
    }

    /// Returns the mesh without materials, and for each triangle its face.
    fn mesh(&self) -> (TriangleMesh, Vec<u32>) {
        let (triangles, faces) = self.triangles();
        let corners = triangles.as_flattened();
        let has_coordinates = corners.iter().any(|corner| corner.coordinate.is_some());
        let first = corners.first().map(|corner| corner.normal);
        let is_smooth = matches!(first, Some(Normal::Smooth(_)))
            && corners.iter().all(|corner| Some(corner.normal) == first);
        let mut mesh = TriangleMesh::default();
        let mut colours = self.colours.clone();
        if !colours.is_empty() {
            colours.resize(self.positions.len(), [1.0; 3]);
        }
        for colour in &mut colours {
            *colour = colour.map(decoded);
        }
        if is_smooth && !has_coordinates {
            mesh.colours = colours;
            mesh.positions.clone_from(&self.positions);
            let triangles = triangles.iter();
            mesh.triangles = triangles.map(|three| three.map(|c| c.position)).collect();
            return (mesh, faces);
        }
        let computed = self.computed_normals(&triangles);
        let mut vertices = HashMap::new();
        for corners in triangles {
            mesh.triangles.push(corners.map(|corner| {
                *vertices.entry(corner).or_insert_with(|| {
                    let vertex = mesh.positions.len() as u32;
                    mesh.positions
                        .push(self.positions[corner.position as usize]);
                    let colour = colours.get(corner.position as usize);
                    mesh.colours.extend(colour);
                    mesh.normals.push(match corner.normal {
                        Normal::Own(normal) => self.normals[normal as usize],
                        other => computed[&(corner.position, other)],
                    });
                    if has_coordinates {
                        let place = corner.coordinate.map(|c| self.coordinates[c as usize]);
                        mesh.coordinates.push(place.unwrap_or_default());
                    }
                    vertex
                })
            }));
        }
        (mesh, faces)
    }

    /// Returns the normals of corners that have none of their own, by position: as
    /// [`TriangleMesh::vertex_normals`], for each smoothing group and flat face. A seam of a texture
    /// is no edge of the surface.
    fn computed_normals(&self, triangles: &[[Corner; 3]]) -> HashMap<(u32, Normal), [f32; 3]> {
        let mut sums: HashMap<_, DVec3> = HashMap::new();
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| {
                let position = self.positions[corner.position as usize];
                DVec3::from(position.map(f64::from))
            });
            let normal = (b - a).cross(c - a);
            for corner in corners {
                if !matches!(corner.normal, Normal::Own(_)) {
                    *sums.entry((corner.position, corner.normal)).or_default() += normal;
                }
            }
        }
        let unit = |sum: DVec3| sum.normalize_or(DVec3::Y).as_vec3().to_array();
        sums.into_iter()
            .map(|(key, sum)| (key, unit(sum)))
            .collect()
    }

    /// Fills in the materials. Faces whose material no library has get the default one.
    fn painted(
        &self,
        path: &Path,
        mut mesh: TriangleMesh,
        faces: &[u32],
        unused: &mut Unused,
    ) -> TriangleMesh {
        let mut places = HashMap::new();
        let mut textures = Textures::new();
        for (library, text) in library::read_all(path, &self.libraries, unused) {
            for described in library::parse(&text, unused) {
                let name = described.material.name.clone();
                places.insert(name, mesh.materials.len() as u32);
                let library::Described {
                    material,
                    texture,
                    emission_texture,
                    normal_texture,
                    alpha_texture,
                } = &described;
                let maps = [texture, emission_texture, normal_texture, alpha_texture];
                let [texture, emission_texture, normals, alpha] = maps.map(|map| match map {
                    Some(_) if mesh.coordinates.is_empty() => {
                        unused.add("texture{s} of faces without texture coordinates", 1);
                        None
                    }
                    Some(map) => map.read(&library, &mut textures, unused),
                    None => None,
                });
                let material = material.clone();
                mesh.materials.push(Material {
                    texture,
                    emission_texture,
                    normal_map: normals.map(|texture| NormalMap {
                        texture,
                        scale: 1.0,
                    }),
                    alpha: material.alpha.map(|of| Alpha {
                        texture: alpha.map(Texture::into_opacity),
                        ..of
                    }),
                    vertex_colours: !mesh.colours.is_empty(),
                    ..material
                });
            }
        }
        let fallback = mesh.materials.len() as u32;
        let mut lacking = HashSet::new();
        let of_face = |&face: &u32| {
            let name = &self.names[self.materials[face as usize]];
            let place = places.get(name).copied();
            if place.is_none() && !name.is_empty() {
                lacking.insert(name);
            }
            place.unwrap_or(fallback)
        };
        let materials: Vec<u32> = faces.iter().map(of_face).collect();
        unused.add("material{s} that no library has", lacking.len() as u64);
        if fallback == 0 && !mesh.colours.is_empty() {
            mesh.paint_by_vertices();
        }
        if fallback > 0 {
            if materials.contains(&fallback) {
                mesh.materials.push(Material {
                    vertex_colours: !mesh.colours.is_empty(),
                    ..Material::default()
                });
            }
            mesh.triangle_materials = materials;
        }
        mesh
    }
}

/// Returns an OBJ index counted from 0, where `count` items come before it.
fn from_zero(index: i64, count: usize) -> Option<u32> {
    let from_zero = if index < 0 {
        index.checked_add(i64::try_from(count).ok()?)?
    } else {
        index - 1
    };
    u32::try_from(from_zero).ok()
}

#[cfg(test)]
mod tests;
