use super::*;
use crate::scene::texture::tests::grey_png;

fn mesh(bytes: &[u8]) -> Result<TriangleMesh, ImportError> {
    Ok(parse(Path::new("a.ply"), bytes)?.mesh)
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
        ("obj\n".to_owned(), "a.ply:1: not a PLY"),
        (ascii(&["3 0 1 4"]), "names vertex 4, but"),
        (ascii(&["3 0 -1 2"]), "names vertex -1, but"),
        (ascii(&["2 0 1"]), "no triangles"),
        (ascii(&["3 0 1"]), "a.ply:15: the file is cut off"),
        (whole.replace("double z", "double w"), "'z'"),
        (ascii(&["3 0 1 2.5"]), "names vertex -1, but"),
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

#[test]
fn corners_of_faces_have_places_and_textures_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ply");
    std::fs::write(folder.path().join("my a.png"), grey_png(&[77])).unwrap();
    let faces = [
        "3 0 1 2 6 0 0 1 0 1 1 0",
        "3 0 2 3 6 0 0 .5 1 0 1 1",
        "3 1 2 3 0 -1",
    ];
    let lists = "property list uchar float texcoord\nproperty int texnumber\nend_header";
    let names = "comment TextureFile my a.png\ncomment TextureFile b.png\nformat";
    let text = ascii(&faces).replace("end_header", lists);
    let text = text.replace("format", names);
    let Model { mesh, unused, .. } = parse(&path, text.as_bytes()).unwrap();
    let places = mesh.triangles.as_flattened().iter();
    let places: Vec<_> = places.map(|v| mesh.coordinates[*v as usize]).collect();
    let first = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert_eq!(places[..3], first);
    assert_eq!(
        places[3..],
        [
            [0.0, 0.0],
            [0.5, 1.0],
            [0.0, 1.0],
            [0.0; 2],
            [0.0; 2],
            [0.0; 2]
        ]
    );
    // The first corner is the same one in two faces.
    assert_eq!(mesh.positions.len(), 8);
    assert_eq!(mesh.triangle_materials, [0, 1, 2]);
    let textured = mesh.materials.iter().map(|one| one.texture.is_some());
    assert!(textured.eq([true, false, false]));
    assert_eq!(unused.names(), ["the texture b.png (which is not there)"]);
}

#[test]
fn faces_have_colours_of_their_own() {
    let colours = "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header";
    let text =
        ascii(&["3 0 1 2 255 -nan(ind) 0", "3 0 2 3 0 0 255"]).replace("end_header", colours);
    let mesh = mesh(text.as_bytes()).unwrap();
    let seen = mesh.triangles.as_flattened().iter();
    let seen: Vec<_> = seen.map(|v| mesh.colours[*v as usize]).collect();
    let [red, blue] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(seen, [red, red, red, blue, blue, blue]);
    assert!(mesh.materials[0].vertex_colours);
}
