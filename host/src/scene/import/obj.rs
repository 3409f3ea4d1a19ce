//! Wavefront OBJ, and its material libraries.
//!
//! The geometry is scanned here rather than by `tobj`, which renumbers the
//! vertices in order of first use, splits them between groups and reports no
//! line numbers; the materials are read by `tobj`.

mod library;

use super::{
    ImportError, Place, Textures, fan, fault, no_vertex, syntax, unit_normals, unusable,
    usable_coordinates, validated,
};
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use library::{load_library, texture, whitted};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::str::FromStr;

/// A corner of a face, indices counted from 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    coordinate: Option<u32>,
    normal: Option<u32>,
}

#[derive(Default)]
struct Geometry {
    positions: Vec<[f32; 3]>,
    coordinates: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// Triangulated, in the file's order.
    triangles: Vec<[Corner; 3]>,
    /// For each triangle, the face that it is a part of.
    faces: Vec<u32>,
    lines: Vec<Option<usize>>,
    /// For each face, its place in `names`.
    materials: Vec<usize>,
    /// The names of materials in use, one after another; before the first `usemtl` it is empty.
    names: Vec<String>,
    libraries: Vec<String>,
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ImportError> {
    let geometry = Geometry::scan(path, &String::from_utf8_lossy(bytes))?;
    let mut mesh = TriangleMesh::default();
    geometry.index(path, &mut mesh)?;
    geometry.paint(path, &mut mesh)?;
    validated(mesh, path, |triangle| {
        let face = *geometry.faces.get(triangle)?;
        *geometry.lines.get(face as usize)?
    })
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

fn three_floats<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f32; 3]> {
    let mut numbers = words.map_while(|word| f32::from_str(word).ok());
    Some([numbers.next()?, numbers.next()?, numbers.next()?])
}

impl Geometry {
    fn scan(path: &Path, text: &str) -> Result<Self, ImportError> {
        let mut geometry = Self::default();
        geometry.names.push(String::new());
        let mut corners = Vec::new();
        for (line, statement) in statements(text) {
            let line = Some(line);
            let at = Place { path, line };
            let trimmed = statement.trim();
            let (keyword, rest) = trimmed
                .split_once(char::is_whitespace)
                .unwrap_or((trimmed, ""));
            let words = rest
                .split_whitespace()
                .take_while(|word| !word.starts_with('#'));
            match keyword {
                "v" => {
                    let problem = "a vertex needs three coordinates that are numbers";
                    let position = three_floats(words).ok_or_else(|| syntax(at, problem))?;
                    TriangleMesh::check_position(position)
                        .map_err(|fault| unusable(at, format_args!("the vertex {fault}")))?;
                    geometry.positions.push(position);
                }
                "vn" => {
                    let problem = "a normal needs three numbers";
                    let normal = three_floats(words).ok_or_else(|| syntax(at, problem));
                    geometry.normals.push(normal?);
                }
                "vt" => {
                    let problem = "a texture coordinate needs a number or two";
                    let mut numbers = words.map_while(|word| f32::from_str(word).ok());
                    let u = numbers.next().ok_or_else(|| syntax(at, problem))?;
                    let v = numbers.next().unwrap_or(0.0);
                    geometry.coordinates.push([u, v]);
                }
                "f" => {
                    corners.clear();
                    for word in words {
                        corners.push(geometry.corner(at, word)?);
                    }
                    geometry.add_face(at, &corners)?;
                }
                "usemtl" => geometry.names.push(rest.trim().to_owned()),
                "mtllib" if !rest.trim().is_empty() => {
                    geometry.libraries.push(rest.trim().to_owned());
                }
                _ => {}
            }
        }
        if geometry.positions.is_empty() && geometry.lines.is_empty() {
            let problem = "no line describes a vertex or a face: is this an OBJ file?";
            let advice = "export the mesh as .obj, .ply, .gltf or .glb";
            return Err(fault(path, problem, advice));
        }
        Ok(geometry)
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`. Negative indices count back
    /// from the latest; whether positive ones exist shows at the end only.
    fn corner(&self, at: Place<'_>, word: &str) -> Result<Corner, ImportError> {
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
        let normal = match normal {
            Some(Ok(index)) => {
                let known = from_zero(index, self.normals.len());
                Some(known.ok_or_else(|| self.no_normal(at, index))?)
            }
            _ => None,
        };
        // An index out of range counts as absent: some files name coordinates without having any.
        let coordinate = match texture {
            Some(Ok(index)) => from_zero(index, self.coordinates.len()),
            _ => None,
        };
        Ok(Corner {
            position,
            coordinate,
            normal,
        })
    }

    fn no_vertex(&self, at: Place<'_>, index: i64) -> ImportError {
        no_vertex(at, "the face", index, [1, self.positions.len() as i64])
    }

    fn no_normal(&self, at: Place<'_>, index: i64) -> ImportError {
        let known = self.normals.len();
        let problem = format!("the face names normal {index}, but the file has {known}");
        syntax(at, problem)
    }

    fn add_face(&mut self, at: Place<'_>, corners: &[Corner]) -> Result<(), ImportError> {
        if corners.len() < 3 {
            let problem = format!("a face needs three corners, but has {}", corners.len());
            return Err(syntax(at, problem));
        }
        let face = self.lines.len() as u32;
        self.lines.push(at.line);
        self.materials.push(self.names.len() - 1);
        let fan = fan(corners);
        self.faces.resize(self.faces.len() + fan.len(), face);
        self.triangles.extend(fan);
        Ok(())
    }

    fn index(&self, path: &Path, mesh: &mut TriangleMesh) -> Result<(), ImportError> {
        let mut every_corner_has_a_normal = true;
        for (corners, &face) in self.triangles.iter().zip(&self.faces) {
            let line = self.lines[face as usize];
            let at = Place { path, line };
            for corner in corners {
                if corner.position as usize >= self.positions.len() {
                    let index = i64::from(corner.position) + 1;
                    return Err(self.no_vertex(at, index));
                }
                match corner.normal {
                    Some(normal) if normal as usize >= self.normals.len() => {
                        return Err(self.no_normal(at, i64::from(normal) + 1));
                    }
                    Some(_) => {}
                    None => every_corner_has_a_normal = false,
                }
            }
        }
        let corners = self.triangles.as_flattened();
        let is_known = |place: u32| (place as usize) < self.coordinates.len();
        let is_placed = |corner: &Corner| corner.coordinate.is_some_and(is_known);
        let has_coordinates = corners.iter().all(is_placed)
            && !usable_coordinates(self.coordinates.clone()).is_empty();
        let triangles = self.triangles.iter();
        let whole = TriangleMesh {
            positions: self.positions.clone(),
            triangles: triangles.map(|three| three.map(|c| c.position)).collect(),
            ..TriangleMesh::default()
        };
        if !every_corner_has_a_normal && !has_coordinates {
            *mesh = whole;
            return Ok(());
        }
        // A seam of the texture is no edge of the surface: where the file has no normals, both
        // sides get those of the whole mesh.
        let own = if every_corner_has_a_normal {
            Vec::new()
        } else {
            whole.vertex_normals().into_owned()
        };
        let mut vertices = HashMap::new();
        let mut normals = Vec::new();
        for corners in &self.triangles {
            mesh.triangles.push(corners.map(|corner| {
                let corner = Corner {
                    coordinate: corner.coordinate.filter(|_| has_coordinates),
                    normal: corner.normal.filter(|_| every_corner_has_a_normal),
                    ..corner
                };
                *vertices.entry(corner).or_insert_with(|| {
                    let vertex = mesh.positions.len() as u32;
                    let position = corner.position as usize;
                    mesh.positions.push(self.positions[position]);
                    mesh.coordinates
                        .extend(corner.coordinate.map(|c| self.coordinates[c as usize]));
                    normals.push(match corner.normal {
                        Some(normal) => self.normals[normal as usize],
                        None => own[position],
                    });
                    vertex
                })
            }));
        }
        mesh.normals = unit_normals(normals);
        Ok(())
    }

    /// Fills in the materials. Faces whose material no library has get the default one.
    fn paint(&self, path: &Path, mesh: &mut TriangleMesh) -> Result<(), ImportError> {
        let mut places = HashMap::new();
        let mut textures = Textures::new();
        for library in &self.libraries {
            let library = path.with_file_name(library);
            for material in load_library(&library)? {
                places.insert(material.name.clone(), mesh.materials.len() as u32);
                let texture = match &material.diffuse_texture {
                    Some(map) if !mesh.coordinates.is_empty() => {
                        texture(&mut textures, &library, map)?
                    }
                    _ => None,
                };
                mesh.materials.push(Material {
                    texture,
                    ..whitted(&material)
                });
            }
        }
        if mesh.materials.is_empty() {
            return Ok(());
        }
        let fallback = mesh.materials.len() as u32;
        let place = |name: &String| places.get(name).copied().unwrap_or(fallback);
        let by_name: Vec<u32> = self.names.iter().map(place).collect();
        let of_face = |&face: &u32| by_name[self.materials[face as usize]];
        mesh.triangle_materials = self.faces.iter().map(of_face).collect();
        if mesh.triangle_materials.contains(&fallback) {
            mesh.materials.push(Material::default());
        }
        Ok(())
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
mod tests {
    use super::*;
    use crate::scene::texture::tests::{grey_png, texels};

    fn mesh(text: &str) -> Result<TriangleMesh, ImportError> {
        parse(Path::new("a.obj"), text.as_bytes())
    }

    fn fault(text: &str) -> String {
        mesh(text).unwrap_err().to_string()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn polygons_become_fans_also_with_relative_indices_and_joined_lines() {
        for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/1 2/2 \\\n 3/3 4/4 # x"] {
            let mesh = mesh(&format!("{SQUARE}{face}\n")).unwrap();
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        }
    }

    #[test]
    fn splits_vertices_at_their_normals() {
        let normals = "vn 0 0 2\nvn 0 1 0\n";
        let text = format!("{SQUARE}{normals}f 1//1 2//1 3//1\nf 1//2 3//1 4//1\n");
        let split = mesh(&text).unwrap();
        assert_eq!(split.triangles, [[0, 1, 2], [3, 2, 4]]);
        assert_eq!(split.normals[0], [0.0, 0.0, 1.0]);
        let partly = mesh(&format!("{SQUARE}{normals}f 1//1 2//1 3\n")).unwrap();
        assert!(partly.normals.is_empty());
    }

    #[test]
    fn splits_vertices_at_seams_of_a_texture_but_not_their_normals() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0.5\nvt 0.25\n";
        let split = mesh(&format!("{text}f 1/1 2/2 3/3\nf 2/1 1/1 4/3\n")).unwrap();
        assert_eq!(split.triangles, [[0, 1, 2], [3, 0, 4]]);
        let places = [[0.0, 0.0], [1.0, 0.5], [0.25, 0.0], [0.0, 0.0], [0.25, 0.0]];
        assert_eq!(split.coordinates, places);
        assert_eq!(split.positions[1], split.positions[3]);
        assert_eq!(split.normals[1], split.normals[3]);
        // Only some corners, one that is not there, one that is far out.
        for face in ["f 1/1 2/2 3", "f 1/1 2/2 3/4"] {
            let without = mesh(&format!("{text}{face}\n")).unwrap();
            assert!(without.coordinates.is_empty() && without.normals.is_empty());
            assert_eq!(without.positions.len(), 4);
        }
        let far = mesh(&format!("{text}vt 1e9 0\nf 1/1 2/2 3/3\n")).unwrap();
        assert!(far.coordinates.is_empty());
        assert!(fault(&format!("{text}vt x\n")).starts_with("a.obj:8: "));
    }

    #[test]
    fn textures_are_those_of_the_library_where_the_mesh_is_on_them() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).unwrap();
        write("a.png", &grey_png(&[77]));
        write("b.jpg", b"\xff\xd8\xff");
        let library = "newmtl a\nmap_Kd -s 1 1 1 a.png\nnewmtl b\nmap_Kd b.jpg\n\
                       newmtl c\nmap_Kd a.png\n";
        write("a.mtl", library.as_bytes());
        let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nmtllib a.mtl\nusemtl a\n";
        let path = folder.path().join("a.obj");
        let read = |face: &str| parse(&path, format!("{corners}{face}\n").as_bytes());
        let with = read("f 1/1 2/1 3/1").unwrap();
        assert_eq!(texels(&with.materials[0]), [[77, 77, 77, 0]]);
        let [a, b, c] = [0, 1, 2].map(|i| with.materials[i].texture.as_ref());
        assert_eq!((a, b), (c, None));
        let without = read("f 1 2 3").unwrap();
        assert!(without.materials.iter().all(|m| m.texture.is_none()));
        write("a.mtl", b"newmtl a\nmap_Kd c.png\n");
        let error = read("f 1/1 2/1 3/1").unwrap_err();
        assert!(error.to_string().contains("c.png"), "{error}");
    }

    #[test]
    fn tells_the_line_and_the_fault() {
        assert!(fault("v 0 0\n").starts_with("a.obj:1: "));
        assert!(fault("Dear all,\n").contains("is this an OBJ file?"));
        let (least, most) = (i64::MIN.to_string(), i64::MAX.to_string());
        let beyond = ["5", "0", "-5", &least, &most];
        let beyond = beyond.map(|i| (format!("f 1 2 {i}"), format!("vertex {i}, but")));
        let others = [
            ("f 1 2 3 1", "twice"),
            ("f 1//7 2//7 3//7", "normal 7"),
            ("f 1 2", "three corners"),
            ("f 1 2 3/1/1/1", "no corner"),
            ("f 1 2 /3", "no corner"),
            ("v 1 1e13 0", "the vertex is farther out"),
        ];
        let others = others.map(|(face, says)| (face.to_owned(), says.to_owned()));
        for (face, says) in beyond.into_iter().chain(others) {
            let fault = fault(&format!("{SQUARE}{face}\n"));
            let is_told = fault.starts_with("a.obj:5: ") && fault.contains(&says);
            assert!(is_told, "{fault}");
        }
    }
}
