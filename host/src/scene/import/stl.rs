//! STL, ASCII and binary: triangles without common vertices.

use super::{
    ImportError, Model, Place, Unused, claim, finished, flat_normal, syntax, three_floats,
};
use crate::scene::mesh::TriangleMesh;
use std::path::Path;

/// Bytes before the triangles of a binary file: a text, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, corners, attribute.
const RECORD: usize = 50;

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Model, ImportError> {
    let mut unused = Unused::default();
    let count = bytes.get(80..).and_then(|rest| rest.first_chunk());
    let count = count.map(|&count| u32::from_le_bytes(count));
    let claimed = count.map(|count| HEADER as u128 + u128::from(count) * RECORD as u128);
    // Records may begin with the word, too, but have zeros soon.
    let start = &bytes[..bytes.len().min(512)];
    let word = start.trim_ascii_start().first_chunk();
    let is_solid = word.is_some_and(|word: &[u8; 5]| word.eq_ignore_ascii_case(b"solid"));
    let is_text = is_solid && !start.contains(&0);
    let corners = if is_text {
        from_text(path, &String::from_utf8_lossy(bytes))?
    } else {
        match claimed {
            Some(claimed) if claimed <= bytes.len() as u128 => {}
            Some(claimed) => return Err(claim(path, "its triangles", claimed, bytes.len())),
            None => return Err(syntax(path, "too short for an STL file")),
        }
        let records = &bytes[HEADER..][..RECORD * count.unwrap_or(0) as usize];
        from_records(records, &mut unused)
    };
    let mut mesh = TriangleMesh::default();
    for triangle in corners.chunks_exact(3) {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend_from_slice(triangle);
        let normal = flat_normal([triangle[0], triangle[1], triangle[2]]);
        mesh.normals.extend([normal; 3]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    finished(path, mesh, unused)
}

fn from_records(records: &[u8], unused: &mut Unused) -> Vec<[f32; 3]> {
    let (records, _) = records.as_chunks::<RECORD>();
    let mut corners = Vec::with_capacity(3 * records.len());
    let mut attributes = 0;
    for record in records {
        let (numbers, attribute) = record.as_chunks::<4>();
        let number = |place: usize| f32::from_le_bytes(numbers[place]);
        for corner in [3, 6, 9] {
            corners.push([number(corner), number(corner + 1), number(corner + 2)]);
        }
        attributes += u64::from(attribute != [0; 2]);
    }
    unused.add("attribute{s} of faces", attributes);
    corners
}

fn from_text(path: &Path, text: &str) -> Result<Vec<[f32; 3]>, ImportError> {
    let (mut corners, mut has_end) = (Vec::new(), false);
    for (line, number) in text.lines().zip(1..) {
        let line = line.trim();
        let line_at = Place {
            path,
            line: Some(number),
        };
        let keyword = line.split_whitespace().next();
        let keyword = keyword.map(str::to_ascii_lowercase);
        has_end |= keyword.as_deref() == Some("endsolid");
        match keyword.as_deref() {
            Some("vertex") => {
                let problem = "a vertex needs three numbers";
                let words = line.split_whitespace().skip(1);
                let corner = three_floats(words).ok_or_else(|| syntax(line_at, problem))?;
                corners.push(corner);
            }
            Some("endfacet" | "endsolid") if corners.len() % 3 != 0 => {
                return Err(syntax(line_at, "a facet has no three vertices"));
            }
            _ => {}
        }
    }
    if corners.len() % 3 == 0 && has_end {
        Ok(corners)
    } else {
        Err(syntax(path, "the file is cut off: it has no endsolid"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                        vertex 0 1.5e0 0\nendloop\nendfacet\nendsolid a\n";

    #[test]
    fn text_and_records_give_the_same_flat_faces() {
        let text = parse(Path::new("a.stl"), TEXT.as_bytes()).unwrap();
        let upper = parse(Path::new("a.stl"), TEXT.to_uppercase().as_bytes());
        assert_eq!(upper.unwrap(), text);
        assert_eq!(text.mesh.positions[2], [0.0, 1.5, 0.0]);
        assert_eq!(text.mesh.normals, [[0.0, 0.0, 1.0]; 3]);
        // As some programs begin records.
        let mut records = b"solid".to_vec();
        records.resize(80, b' ');
        records.extend(1_u32.to_le_bytes());
        let numbers = [0.0_f32; 3]
            .into_iter()
            .chain([0., 0., 0., 1., 0., 0., 0., 1.5, 0.]);
        records.extend(numbers.flat_map(f32::to_le_bytes));
        records.extend([0; 2]);
        assert_eq!(parse(Path::new("a.stl"), &records).unwrap(), text);
        *records.last_mut().unwrap() = 1;
        let coloured = parse(Path::new("a.stl"), &records).unwrap();
        assert_eq!(coloured.unused.names(), ["1 attribute of faces"]);
        records.pop();
        let cut = parse(Path::new("a.stl"), &records[..]).unwrap_err();
        assert!(cut.to_string().contains("cut off"), "{cut}");
        for (wrong, says) in [("1.5e0", "a.stl:6: "), ("endsolid", "cut off")] {
            let error = parse(Path::new("a.stl"), TEXT.replace(wrong, "x").as_bytes());
            let error = error.unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
