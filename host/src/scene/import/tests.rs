use super::*;

const OBJ: &[u8] = b"mtllib none\nv 0 0 0\nv 1 0 .5\nv 1 1e1 0\nvn 0 0 1\nvt 0 0\nusemtl a\n\
    f 1/1/1 2//1 3//1\nf -1 -2 \\\n-3\n";
const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";

fn binary_ply() -> Vec<u8> {
    let text = String::from_utf8_lossy(PLY).replace("ascii", "binary_little_endian");
    let header = text.find("0 0 0\n").unwrap();
    let mut bytes = text.as_bytes()[..header].to_vec();
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.push(3);
    bytes.extend([0_i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
    bytes
}

type Parse = fn(&Path, &[u8]) -> Result<Model, ImportError>;

/// A file with one damaged or missing byte gives a valid mesh or an error.
fn survives_mutation(parse: Parse, bytes: &[u8]) {
    let path = Path::new("nowhere/a");
    parse(path, bytes).unwrap();
    let check = |bytes: &[u8]| match parse(path, bytes) {
        Ok(model) => model.mesh.validate().unwrap(),
        Err(error) => assert!(!error.to_string().is_empty()),
    };
    for length in 0..bytes.len() {
        check(&bytes[..length]);
    }
    let mut mutated = bytes.to_vec();
    for at in 0..bytes.len() {
        for flip in (0..8).map(|bit| 1 << bit).chain([0xff]) {
            mutated[at] = bytes[at] ^ flip;
            check(&mutated);
        }
        for byte in *b"09-.\n \\{\"" {
            mutated[at] = byte;
            check(&mutated);
        }
        mutated[at] = bytes[at];
    }
}

#[test]
fn damaged_files_are_no_crash() {
    survives_mutation(obj::parse, OBJ);
    survives_mutation(ply::parse, PLY);
    survives_mutation(ply::parse, &binary_ply());
    survives_mutation(vtp::parse, &vtp::tests::files()[6]);
    let json = gltf::tests::triangle_json(r#","rotation":[0,0,0,1]"#, "");
    survives_mutation(
        gltf::parse,
        &gltf::tests::glb(&json, &gltf::tests::triangle_bytes()),
    );
}

#[test]
fn the_extension_tells_the_format_in_any_case() {
    let folder = tempfile::tempdir().unwrap();
    let glb = gltf::tests::glb(
        &gltf::tests::triangle_json("", ""),
        &gltf::tests::triangle_bytes(),
    );
    for (name, bytes) in [("a.OBJ", OBJ), ("a.Ply", PLY), ("a.GLB", &glb)] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(load(&path).unwrap().mesh.positions.len(), 3);
    }
    for name in ["a.step", "a", ".obj"] {
        let error = load(&folder.path().join(name)).unwrap_err();
        assert!(
            error
                .help()
                .unwrap()
                .to_string()
                .contains(".obj, .ply, .stl, .vtp, .gltf or .glb")
        );
    }
}

#[test]
fn materials_come_from_the_library_beside_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let faces = "f 1 2 3\nusemtl red\nf 1 2 3\nusemtl unheard of\nf 1 2 3\n";
    let text = format!("mtllib my own.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    std::fs::write(&path, text).unwrap();
    let bare = load(&path).unwrap();
    assert!(bare.mesh.materials.is_empty());
    let told = [
        "the material library my (which is not there)",
        "the material library own.mtl (which is not there)",
        "2 materials that no library has",
    ];
    assert_eq!(bare.unused.names(), told);
    let library = folder.path().join("my own.mtl");
    std::fs::write(&library, b"\xff\xfen\0").unwrap();
    let told = load(&path).unwrap().unused.names().remove(0);
    assert!(told.contains("UTF-16"), "{told}");
    std::fs::write(&library, "newmtl red\nKd 1 0 0\n").unwrap();
    let painted = load(&path).unwrap().mesh;
    assert_eq!(painted.triangle_materials, [1, 0, 1]);
    assert_eq!(painted.materials[0].diffuse, [1.0, 0.0, 0.0]);
}
