use super::*;
use crate::scene::texture::tests::{grey_png, texels};

fn model(text: &str) -> Result<Model, ImportError> {
    parse(Path::new("a.obj"), text.as_bytes())
}

fn mesh(text: &str) -> TriangleMesh {
    model(text).unwrap().mesh
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_become_fans_also_with_relative_indices_and_joined_lines() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/1 2/2 \\\n 3/3 4/4 # x"] {
        let mesh = mesh(&format!("{SQUARE}{face}\n"));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }
}

#[test]
fn splits_vertices_at_their_normals() {
    let normals = "vn 0 0 2\nvn 0 1 0\nvn x\n";
    let text = format!("{SQUARE}{normals}f 1//1 2//1 3//1\nf 1//2 3//1 4//1\n");
    let split = mesh(&text);
    assert_eq!(split.triangles, [[0, 1, 2], [3, 2, 4]]);
    assert_eq!(split.normals[0], [0.0, 0.0, 1.0]);
    // Without a normal, with one that is none, and with one that is not there.
    let partly = model(&format!("{SQUARE}{normals}f 1//2 2 3//3 4//7\n")).unwrap();
    assert_eq!(partly.mesh.normals[0], [0.0, 1.0, 0.0]);
    assert_eq!(partly.mesh.normals[1..], [[0.0, 0.0, 1.0]; 3]);
    let told = ["1 normal that faces name and the file lacks"];
    assert_eq!(partly.unused.names(), told);
}

#[test]
fn normals_are_the_means_of_smoothing_groups_and_flat_without() {
    let roof = "v 0 0 0\nv 1 1 0\nv 0 0 -1\nv 1 1 -1\nv 2 0 0\nv 2 0 -1\n";
    let faces =
        |first: &str, second: &str| mesh(&format!("{roof}{first}f 1 2 4 3\n{second}f 2 5 6 4\n"));
    let smooth = faces("", "");
    assert!(smooth.normals.is_empty() && smooth.positions.len() == 6);
    assert_eq!(faces("s 1\n", ""), smooth);
    for flat in [
        faces("s off\n", ""),
        faces("s 0\n", ""),
        faces("s 1\n", "s 2\n"),
    ] {
        assert_eq!(flat.positions.len(), 8);
        assert!(
            flat.normals.iter().all(|normal| normal[0].abs() > 0.7),
            "{flat:?}"
        );
    }
}

#[test]
fn what_is_seen_from_both_sides_is_there_once() {
    let once = mesh(&format!("{SQUARE}f 1 2 3 4\n"));
    assert_eq!(mesh(&format!("{SQUARE}f 1 2 3 4\nf 2 1 4 3\n")), once);
}

#[test]
fn splits_vertices_at_seams_of_a_texture_but_not_their_normals() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0.5\nvt 0.25\n";
    let split = mesh(&format!("{text}f 1/1 2/2 3/3\nf 2/1 1/1 4/3\n"));
    assert_eq!(split.triangles, [[0, 1, 2], [3, 0, 4]]);
    let places = [[0.0, 0.0], [1.0, 0.5], [0.25, 0.0], [0.0, 0.0], [0.25, 0.0]];
    assert_eq!(split.coordinates, places);
    assert_eq!(split.positions[1], split.positions[3]);
    assert_eq!(split.normals[1], split.normals[3]);
    // One that is not there, one that is not given, one that is far out, one that is none.
    for (face, told) in [
        (
            "f 1/2 2/2 3/9",
            Some("1 texture coordinate that faces name and the file lacks"),
        ),
        ("f 1/2 2/2 3", None),
        (
            "vt 1e9 0\nf 1/2 2/2 3/4",
            Some("1 texture coordinate out of range"),
        ),
        (
            "vt x\nf 1/2 2/2 3/4",
            Some("1 texture coordinate out of range"),
        ),
    ] {
        let partly = model(&format!("{text}{face}\n")).unwrap();
        assert_eq!(
            partly.mesh.coordinates,
            [[1.0, 0.5], [1.0, 0.5], [0.0, 0.0]]
        );
        assert_eq!(partly.unused.names(), Vec::from_iter(told));
    }
}

#[test]
fn textures_are_those_of_the_library_where_the_mesh_is_on_them() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| std::fs::write(folder.path().join(name), text).unwrap();
    write("a.png", &grey_png(&[77]));
    write("b.jpg", b"\xff\xd8\xff");
    let library = "newmtl a\nmap_Kd -s 1 1 1 C:\\x\\a.png\nnewmtl b\nmap_Kd b.jpg\n\
                   newmtl c\nmap_Kd a.png\nnewmtl d\nmap_Kd c.png\n";
    write("a.mtl", library.as_bytes());
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nmtllib a.mtl\nusemtl a\n";
    let path = folder.path().join("a.obj");
    let read = |face: &str| parse(&path, format!("{corners}{face}\n").as_bytes()).unwrap();
    let with = read("f 1/1 2/1 3/1");
    let materials = &with.mesh.materials;
    assert_eq!(texels(&materials[0]), texels(&materials[2]));
    assert!(materials[1].texture.is_none() && materials[3].texture.is_none());
    let [odd, missing] = &with.unused.names()[..] else {
        panic!("{:?}", with.unused)
    };
    assert!(
        odd.starts_with("the texture b.jpg (not a whole JPEG"),
        "{odd}"
    );
    assert_eq!(missing, "the texture c.png (which is not there)");
    let without = read("f 1 2 3");
    let names = without.unused.names();
    assert_eq!(names, ["4 textures of faces without texture coordinates"]);
}

#[test]
fn libraries_are_named_in_many_ways() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    for (name, colour) in [
        ("r.mtl", "newmtl r\nKd 1 0 0\n"),
        ("g g.mtl", "newmtl g\nKd 0 1 0\nmap_Kd a.png\n"),
    ] {
        std::fs::write(folder.path().join(name), colour).unwrap();
    }
    std::fs::write(folder.path().join("a.png"), grey_png(&[77])).unwrap();
    for statements in [
        "mtllib g g.mtl # exported\nmtllib r.mtl",
        "mtllib \"g g.mtl\"\nmtllib .\\r.mtl",
        "mtllib D:\\models\\g g.mtl\nmtllib none.mtl r.mtl",
    ] {
        let text =
            format!("{statements}\n{SQUARE}vt 0 0\nusemtl r # red\nf 1/1 2 3\nusemtl g\nf 1 3 4\n");
        let mesh = parse(&path, text.as_bytes()).unwrap().mesh;
        let colours = mesh.triangle_materials.iter();
        let colours: Vec<_> = colours
            .map(|&m| mesh.materials[m as usize].diffuse)
            .collect();
        assert_eq!(colours, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{statements}");
        assert!(mesh.materials.iter().any(|one| one.texture.is_some()));
    }
}

#[test]
fn what_has_no_area_is_left_out() {
    for face in ["f 1 2 2 3", "f 1 2 3 1", "f 1 2 3\nf 1 2\nf 1 1 2\nf 1 2 1"] {
        let model = model(&format!("{SQUARE}{face}\n")).unwrap();
        assert_eq!(model.mesh.triangles, [[0, 1, 2]], "{face}");
        let told = face.contains('\n').then_some("3 faces without area");
        assert_eq!(model.unused.names(), Vec::from_iter(told), "{face}");
    }
}

#[test]
fn a_vertex_that_is_no_number_takes_its_faces_alone() {
    let odd = model(&format!("{SQUARE}v nan 0 0\nf 1 2 3\nf 1 2 5\n")).unwrap();
    assert_eq!(odd.mesh.triangles, [[0, 1, 2]]);
    let told = ["1 face with a vertex that is no number or too far out"];
    assert_eq!(odd.unused.names(), told);
}

#[test]
fn tells_the_line_and_the_fault() {
    let fault = |text: &str| model(text).unwrap_err().to_string();
    assert!(fault("v 0 0\n").starts_with("a.obj:1: "));
    assert!(fault("Dear all,\n").contains("is this an OBJ file?"));
    let (least, most) = (i64::MIN.to_string(), i64::MAX.to_string());
    let beyond = ["5", "0", "-5", &least, &most];
    let beyond = beyond.map(|i| (format!("f 1 2 {i}"), format!("vertex {i}, but")));
    let others = [("f 1 2 3/1/1/1", "no corner"), ("f 1 2 /3", "no corner")];
    let others = others.map(|(face, says)| (face.to_owned(), says.to_owned()));
    for (face, says) in beyond.into_iter().chain(others) {
        let fault = fault(&format!("{SQUARE}{face}\n"));
        let is_told = fault.starts_with("a.obj:5: ") && fault.contains(&says);
        assert!(is_told, "{fault}");
    }
}
