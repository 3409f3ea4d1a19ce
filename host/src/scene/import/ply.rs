//! PLY, ASCII and binary.

use std::path::Path;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::{
    ImportError, Place, claim, fan, no_vertex, syntax, unit_normals, usable_coordinates, validated,
};
use crate::scene::mesh::TriangleMesh;

/// Names of texture coordinates: across, and up.
const COORDINATES: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

/// Names of the list of a face's corners.
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

#[derive(Default)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    coordinate: [f32; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let slot = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            _ if COORDINATES.iter().any(|[u, _]| *u == name) => &mut self.coordinate[0],
            _ if COORDINATES.iter().any(|[_, v]| *v == name) => &mut self.coordinate[1],
            _ => return PropertyAccessResult::Ignored,
        };
        match property.to_f32_lossy() {
            Some(value) => {
                *slot = value;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
            list.into_iter().map(Into::into).collect()
        }
        if !CORNER_LISTS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => wide(list),
            Property::ListUChar(list) => wide(list),
            Property::ListShort(list) => wide(list),
            Property::ListUShort(list) => wide(list),
            Property::ListInt(list) => wide(list),
            Property::ListUInt(list) => wide(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, ImportError> {
    let fault = |error| malformed(path, &error);
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(fault)?;
    check_claims(path, &header, reader.get_ref().len())?;
    let (has_normals, has_coordinates) = check_properties(path, &header)?;
    let mut mesh = TriangleMesh::default();
    let mut faces = Vec::new();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let vertices: Vec<Vertex> = Parser::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
                mesh.positions = vertices.iter().map(|v| v.position).collect();
                if has_normals {
                    mesh.normals = unit_normals(vertices.iter().map(|v| v.normal).collect());
                }
                if has_coordinates {
                    let coordinates = vertices.iter().map(|v| v.coordinate).collect();
                    mesh.coordinates = usable_coordinates(coordinates);
                }
            }
            "face" => {
                faces = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
            }
        }
    }
    triangulate(path, &faces, &mut mesh)?;
    validated(mesh, path, |_| None)
}

fn malformed(path: &Path, error: &ParseError) -> ImportError {
    let message = error.to_string();
    // The message starts with the line's number again, quotes the line and
    // ends with the cause; a grammar's cause is of use to programmers only.
    let summary = message.lines().next().unwrap_or_default();
    let summary = summary
        .strip_prefix("Line ")
        .and_then(|rest| rest.split_once(": "))
        .map_or(summary, |(_, summary)| summary);
    let cause = message.rsplit_once("Error: ");
    let cause = cause.map(|(_, cause)| cause.lines().next().unwrap_or(cause));
    let cause = cause.filter(|cause| !cause.starts_with("ParseError"));
    let problem = format!("not a valid PLY file: {}", cause.unwrap_or(summary));
    let line = error.line();
    syntax(Place { path, line }, problem)
}

fn size(scalar: &ScalarType) -> u128 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Returns the fewest bytes that one element takes.
fn least_size(element: &ElementDef, encoding: Encoding) -> u128 {
    let properties = element.properties.values();
    let least = match encoding {
        // A digit and a blank or a line break each.
        Encoding::Ascii => 2 * properties.len() as u128,
        Encoding::BinaryBigEndian | Encoding::BinaryLittleEndian => properties
            .map(|property| match &property.data_type {
                PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
            })
            .sum(),
    };
    least.max(1)
}

/// Refuses counts in the header that the payload cannot hold, before anything is allocated by them.
fn check_claims(path: &Path, header: &Header, payload: usize) -> Result<(), ImportError> {
    let mut claimed = 0;
    for element in header.elements.values() {
        claimed += element.count as u128 * least_size(element, header.encoding);
        // The last line may lack its break.
        if claimed > payload as u128 + 1 {
            let (count, name) = (element.count, &element.name);
            let what = format!("the header's element count of {count} for '{name}'");
            return Err(claim(path, &what, claimed, payload));
        }
    }
    Ok(())
}

/// Checks that vertices and faces have what a mesh needs; returns whether there are normals and
/// texture coordinates.
fn check_properties(path: &Path, header: &Header) -> Result<(bool, bool), ImportError> {
    let missing = |what: &str| {
        let problem = format!("the header declares no {what}, as a triangle mesh needs");
        syntax(path, problem)
    };
    let element = |name: &str| {
        let element = header.elements.get(name);
        element.ok_or_else(|| missing(&format!("element '{name}'")))
    };
    let vertex = element("vertex")?;
    for name in ["x", "y", "z"] {
        if !vertex.properties.contains_key(name) {
            return Err(missing(&format!("property '{name}' of 'vertex'")));
        }
    }
    let face = element("face")?;
    let is_corner_list = |name: &&str| {
        let property = face.properties.get(*name);
        property.is_some_and(|property| {
            let PropertyType::List(_, scalar) = &property.data_type else {
                return false;
            };
            !matches!(scalar, ScalarType::Float | ScalarType::Double)
        })
    };
    if !CORNER_LISTS.iter().any(is_corner_list) {
        return Err(missing("list of integers 'vertex_indices' of 'face'"));
    }
    let has = |names: &[&str]| {
        let mut names = names.iter();
        names.all(|&name| vertex.properties.contains_key(name))
    };
    // Two pairs would overwrite each other.
    let pairs = COORDINATES.iter().filter(|pair| has(&pair[..]));
    Ok((has(&["nx", "ny", "nz"]), pairs.count() == 1))
}

fn triangulate(path: &Path, faces: &[Face], mesh: &mut TriangleMesh) -> Result<(), ImportError> {
    let vertices = mesh.positions.len();
    let mut corners = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        corners.clear();
        for &index in &face.corners {
            match u32::try_from(index) {
                Ok(corner) if (corner as usize) < vertices => corners.push(corner),
                _ => {
                    let face = format!("face {number} (counted from 0)");
                    return Err(no_vertex(path, &face, index, [0, vertices as i64 - 1]));
                }
            }
        }
        if corners.len() < 3 {
            let problem = format!(
                "face {number} (counted from 0) has {} corners, but a face needs three",
                corners.len()
            );
            return Err(syntax(path, problem));
        }
        mesh.triangles.extend(fan(&corners));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(bytes: &[u8]) -> Result<TriangleMesh, ImportError> {
        parse(Path::new("a.ply"), bytes)
    }

    fn ascii(faces: &[&str]) -> String {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
             property double z\nelement face {}\nproperty list uchar int vertex_indices\n\
             end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n{}\n",
            faces.len(),
            faces.join("\n")
        )
    }

    #[test]
    fn reads_both_endiannesses_with_normals_and_skips_the_rest() {
        for (order, big) in [("binary_big_endian", true), ("binary_little_endian", false)] {
            for list in ["vertex_index", "vertex_indices"] {
                let mut bytes = format!(
                    "ply\nformat {order} 1.0\ncomment a\nelement camera 1\nproperty short f\n\
                     element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                     property float nx\nproperty float ny\nproperty float nz\n\
                     property uchar red\nelement face 1\nproperty uchar flags\n\
                     property list int ushort {list}\nend_header\n"
                )
                .into_bytes();
                let mut put = |little: &[u8]| {
                    if big {
                        bytes.extend(little.iter().rev());
                    } else {
                        bytes.extend(little);
                    }
                };
                put(&5_i16.to_le_bytes());
                for [x, y] in [[0.0_f32, 0.0], [1.0, 0.0], [0.0, 1.5]] {
                    for number in [x, y, 0.0, 0.0, 0.0, 3.0] {
                        put(&number.to_le_bytes());
                    }
                    put(&[200]);
                }
                put(&[7]);
                put(&3_i32.to_le_bytes());
                for corner in [0_u16, 1, 2] {
                    put(&corner.to_le_bytes());
                }
                let read = mesh(&bytes).unwrap();
                assert_eq!(read.triangles, [[0, 1, 2]]);
                assert_eq!(read.positions[2], [0.0, 1.5, 0.0]);
                assert_eq!(read.normals, [[0.0, 0.0, 1.0]; 3]);
                for length in 0..bytes.len() {
                    mesh(&bytes[..length]).unwrap_err();
                }
            }
        }
    }

    #[test]
    fn places_on_a_texture_go_by_several_names() {
        for [u, v] in COORDINATES {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n\
                 property float {u}\nproperty float y\nproperty float z\n\
                 property float {v}\nelement face 1\n\
                 property list uchar int vertex_indices\nend_header\n\
                 0 0.5 0 0 0.25\n1 0.75 0 0 0\n0 0 1 0 1\n3 0 1 2\n"
            );
            let read = mesh(text.as_bytes()).unwrap();
            assert_eq!(read.coordinates, [[0.5, 0.25], [0.75, 0.0], [0.0, 1.0]]);
            assert_eq!(read.positions[2], [0.0, 1.0, 0.0]);
        }
    }

    #[test]
    fn tells_what_is_wrong() {
        let whole = ascii(&["3 0 1 2"]);
        for (text, says) in [
            ("obj\n".to_owned(), "a.ply:1: not a valid PLY"),
            (ascii(&["3 0 1 4"]), "names vertex 4, but"),
            (ascii(&["3 0 -1 2"]), "names vertex -1, but"),
            (ascii(&["2 0 1"]), "2 corners"),
            (
                ascii(&["3 0 1"]),
                "a.ply:14: not a valid PLY file: Expected",
            ),
            (whole.replace("double z", "double w"), "'z'"),
            (whole.replace("uchar int", "uchar float"), "integers"),
            (whole.replace("1 1 0", "1 1e999 0"), "finite"),
        ] {
            let fault = mesh(text.as_bytes()).unwrap_err().to_string();
            assert!(fault.contains(says), "{fault}");
        }
    }

    #[test]
    fn refuses_counts_that_the_file_cannot_hold() {
        let text = ascii(&["3 0 1 2"]);
        for claim in ["2000000000", "18446744073709551615"] {
            for format in ["ascii", "binary_little_endian"] {
                let text = text
                    .replace("vertex 4", &format!("vertex {claim}"))
                    .replace("ascii", format);
                let error = mesh(text.as_bytes()).unwrap_err().to_string();
                assert!(error.contains("cut off or damaged"), "{error}");
            }
        }
    }
}
