use super::*;
use std::f64::consts::FRAC_PI_2;

/// Returns three vertices, three normals and three indices of 16 bits.
pub(in crate::scene::import) fn triangle_bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    for number in [0.0_f32, 0.0, 1.0].repeat(3) {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([0, 0, 1, 0, 2, 0]);
    bytes
}

pub(in crate::scene::import) fn triangle_json(node: &str, buffer: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"children":[1]}},{{"mesh":0{node}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2,"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0.25,1],"roughnessFactor":0.1}}}}],
"accessors":[
{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}},
{{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":36}},
{{"buffer":0,"byteOffset":72,"byteLength":6}}],
"buffers":[{{"byteLength":78{buffer}}}]}}"#
    )
}

pub(in crate::scene::import) fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let glb = gltf::Glb {
        header: gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: json.as_bytes().into(),
        bin: Some(bin.into()),
    };
    glb.to_vec().unwrap()
}

pub(super) fn mesh(json: &str) -> Result<TriangleMesh, ImportError> {
    Ok(parse(Path::new("a.glb"), &glb(json, &triangle_bytes()))?.mesh)
}

#[test]
fn applies_the_transforms_of_nodes() {
    let node = r#","translation":[5,0,0],"scale":[2,2,4]"#;
    let moved = mesh(&triangle_json(node, "")).unwrap();
    assert_eq!(moved.positions[1], [7.0, 0.0, 0.0]);
    assert_eq!(moved.triangles, [[0, 1, 2]]);
    assert_eq!(moved.normals, [[0.0, 0.0, 1.0]; 3]);
    let mirrored = mesh(&triangle_json(r#","scale":[1,1,-3]"#, "")).unwrap();
    assert_eq!(mirrored.triangles, [[0, 2, 1]]);
    assert_eq!(mirrored.normals, [[0.0, 0.0, -1.0]; 3]);
    let node = r#","extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}"#;
    let many = mesh(&triangle_json(node, "")).unwrap();
    assert_eq!(many.positions[4], [2.0, 0.0, 0.0], "the second of three");
}

#[test]
fn reads_primitives_without_indices_normals_and_material() {
    let json = triangle_json("", "")
        .replace(r#","indices":2,"material":0"#, "")
        .replace(r#","NORMAL":1"#, "");
    let mesh = mesh(&json).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    // Flat, as the specification demands.
    assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(mesh.triangle_materials, [1]);
    let default = &mesh.materials[1];
    assert_eq!(
        (default.diffuse, default.microfacets.is_some()),
        ([1.0; 3], true)
    );
}

#[test]
fn reads_sparse_accessors() {
    let json = triangle_json("", "").replace(
        r#""type":"VEC3","min""#,
        r#""type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"byteOffset":2,
        "componentType":5123},"values":{"bufferView":1}},"min""#,
    );
    assert_eq!(mesh(&json).unwrap().positions[1], [0.0, 0.0, 1.0]);
}

#[test]
fn reads_embedded_and_external_buffers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.gltf");
    std::fs::write(folder.path().join("a b.bin"), triangle_bytes()).unwrap();
    let read = |uri: &str| {
        let json = triangle_json("", &format!(r#","uri":"{uri}""#));
        Ok::<_, ImportError>(parse(&path, json.as_bytes())?.mesh)
    };
    let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\
                AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAABAAIA";
    std::fs::write(folder.path().join("5%.bin"), triangle_bytes()).unwrap();
    std::fs::create_dir(folder.path().join("x")).unwrap();
    for uri in ["a%20b.bin", "x/../a b.bin", "5%.bin", data] {
        assert_eq!(read(uri).unwrap().triangles, [[0, 1, 2]]);
    }
    for uri in [
        "b.bin",
        "%ff.bin",
        "%f",
        "http://a/b.bin",
        "data:,x",
        "..",
        "../a b.bin",
    ] {
        read(uri).unwrap_err();
    }
}

#[test]
fn strips_and_fans_become_triangles() {
    let of_mode = |mode: u32, json: String| {
        let json = json.replace(r#""indices":2"#, &format!(r#""indices":2,"mode":{mode}"#));
        mesh(&json).unwrap().triangles
    };
    assert_eq!(of_mode(6, triangle_json("", "")), [[0, 1, 2]]);
    // The corners 0, 0, 1, 0, 2 and 0: triangles that join strips have no area.
    let bytes = triangle_json("", "").replace(r#"5123,"count":3"#, r#"5121,"count":6"#);
    assert_eq!(of_mode(5, bytes), [[1, 0, 2]]);
    let pointed = triangle_json("", "").replace(r#","NORMAL":1"#, "");
    assert!(mesh(&pointed.replace("5123", "5121")).is_err());
}

#[test]
fn extensions_that_are_not_read_refuse_nothing_but_compressed_geometry() {
    let required = |name: &str| {
        let from = r#""scene":0,"#;
        let used = format!(r#""extensionsUsed":["{name}"],"extensionsRequired":["{name}"],{from}"#);
        parse(
            Path::new("a.glb"),
            &glb(
                &triangle_json("", "").replace(from, &used),
                &triangle_bytes(),
            ),
        )
    };
    for name in [
        "KHR_lights_punctual",
        "KHR_materials_unlit",
        "ACME_unheard_of",
    ] {
        required(name).unwrap();
    }
    let error = required("KHR_draco_mesh_compression").unwrap_err();
    assert!(error.to_string().contains("Draco"), "{error}");
}

#[test]
fn a_skin_takes_its_pose_and_not_its_nodes_place() {
    // All vertices hang on one joint, which stands at 0, 5, 0 below a node that is elsewhere.
    let json = triangle_json(r#","skin":0,"translation":[9,9,9]"#, "")
        .replace(r#"{"children":[1]}"#, r#"{"children":[1,2]}"#)
        .replace(r#""meshes""#, r#""skins":[{"joints":[2]}],"meshes""#)
        .replace(
            r#""translation":[9,9,9]}]"#,
            r#""translation":[9,9,9]},{"translation":[0,5,0]}]"#,
        );
    assert_eq!(mesh(&json).unwrap().positions[1], [1.0, 5.0, 0.0]);
    // Weights of zero.
    let json = json
        .replace(r#""NORMAL":1"#, r#""NORMAL":1,"JOINTS_0":3,"WEIGHTS_0":3"#)
        .replace(
            r#""type":"SCALAR"}"#,
            r#""type":"SCALAR"},
            {"bufferView":0,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}"#,
        );
    let model = parse(Path::new("a.glb"), &glb(&json, &triangle_bytes())).unwrap();
    assert_eq!(model.mesh.positions[1], [1.0, 5.0, 0.0]);
    assert_eq!(
        model.unused.names(),
        ["3 sets of joint weights that do not add up to 1"]
    );
}

#[test]
fn a_camera_stands_where_its_node_does() {
    // It looks up by 30°, to -X, from 1, 2, 3.
    let node = r#","camera":0,"name":"side","matrix":[0,0,-2,0,1,1.7320508,0,0,1.7320508,-1,0,0,
        1,2,3,1]"#;
    let json = triangle_json(node, "").replace(
        r#""scene":0,"#,
        r#""scene":0,"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":1}}],"#,
    );
    let model = parse(Path::new("a.glb"), &glb(&json, &triangle_bytes())).unwrap();
    assert!(model.unused.is_empty(), "{}", model.unused);
    let camera = &model.cameras[0];
    assert_eq!(camera.name, "side");
    assert_eq!(camera.position, DVec3::new(1.0, 2.0, 3.0));
    let looks = |found: DVec3, x, y, z| (found - DVec3::new(x, y, z)).length() < 1.0e-6;
    assert!(
        looks(camera.look(), 0.0, 0.5, -0.75_f64.sqrt()),
        "{}",
        camera.look()
    );
    let scene = crate::scene::Scene::of_model(model.clone(), Some(2.0), None, Some(camera));
    let place = scene.objects[0].world_from_object;
    assert!(looks(
        place.transform_point3(camera.position),
        0.0,
        0.0,
        0.0
    ));
    assert!(looks(
        place.transform_point3(DVec3::new(0.0, 3.0, 3.0)),
        0.0,
        2.0,
        -2.0
    ));
    // Straight down the top of the picture is ahead.
    let down = Camera {
        orientation: DQuat::from_rotation_y(1.0) * DQuat::from_rotation_x(-FRAC_PI_2),
        ..camera.clone()
    };
    let ahead = down.front_from_model() * (down.orientation * DVec3::Y);
    assert!(looks(ahead, 0.0, 0.0, -1.0), "{ahead}");
}

#[test]
fn what_several_nodes_share_counts_once() {
    let lamp = r#""extensions":{"KHR_lights_punctual":{"light":0}}"#;
    let json = triangle_json(&format!(",{lamp}"), "")
        .replace(r#"{"children":[1]}"#, r#"{"children":[1,2]}"#)
        .replace("}}}],\n", &format!("}}}}}},{{\"mesh\":0,{lamp}}}],\n"))
        .replace(r#""material":0}]"#, r#""material":0},{"attributes":{"POSITION":0},"mode":0}]"#)
        .replace(
            r#""scene":0,"#,
            r#""scene":0,"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{"innerConeAngle":2}}]}},"#,
        );
    let model = parse(Path::new("a.glb"), &glb(&json, &triangle_bytes())).unwrap();
    assert_eq!((model.mesh.triangles.len(), model.lights.len()), (2, 2));
    let told = model.unused.to_string();
    assert!(told.ends_with(", 1 surface of points or lines"), "{told}");
    assert!(
        told.contains("1 cone of spot lights whose angles"),
        "{told}"
    );
}

#[test]
fn tells_what_is_wrong() {
    for (from, to, message) in [
        ("\"count\":3", "\"count\":2", "names vertex 2"),
        ("{\"mesh", "{\"scale\":[1e39,1,1],\"mesh", "no number"),
        ("\"count\":3", "\"count\":4", "accessor 0 takes 48 bytes"),
        ("\"count\":3", "\"count\":4000000000", "cut off"),
        ("\"byteLength\":78", "\"byteLength\":2000000000", "cut off"),
        (":36}", ":36,\"byteStride\":4}", "every 4"),
        ("\"POSITION\":0", "\"POSITION\":9", "among the file's 3"),
        ("5123", "5126", "has to be"),
        ("\"children\":[1]", "\"children\":[0]", "parent"),
        ("\"indices\":2", "\"indices\":2,\"mode\":1", "no triangles"),
        ("2.0", "2.0\",", "not a valid glTF"),
        ("2.0", "1.0", "glTF 1.0"),
    ] {
        let json = triangle_json("", "");
        assert!(json.contains(from));
        let error = mesh(&json.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(message), "{to}: {error}");
    }
}

#[test]
fn tells_a_cut_off_header() {
    let whole = glb(&triangle_json("", ""), &triangle_bytes());
    let mut long = whole.clone();
    long[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut short = whole.clone();
    short[8..12].fill(0);
    for bytes in [&long[..], &short, &whole[..11], &whole[..whole.len() - 1]] {
        parse(Path::new("a.glb"), bytes).unwrap_err();
    }
}

/// Returns a file of `triangle_json` with compressed views, and its binary chunk; `indices` says
/// how the last is compressed.
pub(in crate::scene::import) fn compressed(exponents: bool, indices: &str) -> (String, Vec<u8>) {
    use meshopt::EncodeExpMode::Separate;
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let filtered = meshopt::encode_filter_exp(&positions, 15, Separate);
    let normals = meshopt::encode_filter_oct::<i8>(&[[0.0, 0.0, 1.0, 0.0]; 3], 8);
    let (first, filter) = if exponents {
        (meshopt::encode_vertex_buffer(&filtered), "EXPONENTIAL")
    } else {
        (meshopt::encode_vertex_buffer(&positions), "NONE")
    };
    let last = match indices {
        "TRIANGLES" => meshopt::encode_index_buffer(&[0, 1, 2], 3),
        _ => meshopt::encode_index_sequence(&[0, 1, 2], 3),
    };
    let mut json = triangle_json("", "")
        .replace(r#""buffer":0"#, r#""buffer":1"#)
        .replace(
            r#"1,"componentType":5126"#,
            r#"1,"componentType":5120,"normalized":true"#,
        )
        .replace(
            r#"6,"byteLength":36"#,
            r#"6,"byteLength":12,"byteStride":4"#,
        )
        .replace(
            r#"[{"byteLength":78}]"#,
            r#"[{"byteLength":1},{"byteLength":78}]"#,
        );
    let mut all = Vec::new();
    let normals = meshopt::encode_vertex_buffer(&normals);
    for (before, stream, stride, mode) in [
        (
            r#"1,"byteLength":36"#,
            first,
            12,
            format!(r#""ATTRIBUTES","filter":"{filter}""#),
        ),
        (
            r#""byteStride":4"#,
            normals,
            4,
            r#""ATTRIBUTES","filter":"OCTAHEDRAL""#.to_owned(),
        ),
        (r#""byteLength":6"#, last, 2, format!("\"{indices}\"")),
    ] {
        let (offset, stream) = (all.len(), stream.unwrap());
        let length = stream.len();
        let own = format!(
            r#"{before},"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{offset},
            "byteLength":{length},"byteStride":{stride},"mode":{mode},"count":3}}}}"#
        );
        json = json.replace(before, &own);
        all.extend(stream);
    }
    (json, all)
}

#[test]
fn compressed_views_are_decoded() {
    let plain = mesh(&triangle_json("", "")).unwrap();
    let read = |(json, all): (String, Vec<u8>)| parse(Path::new("a.glb"), &glb(&json, &all));
    assert_eq!(read(compressed(false, "TRIANGLES")).unwrap().mesh, plain);
    assert_eq!(read(compressed(true, "INDICES")).unwrap().mesh, plain);
    for (from, to, says) in [
        ("\"TRIANGLES", "\"X", "buffer view 2: EXT"),
        ("\"count\":3}", "\"count\":300000}", "buffer view 0 is not"),
        ("\"count\":3}", "\"count\":1000000000}", "more than"),
        (
            "\"byteStride\":12",
            "\"byteStride\":14",
            "buffer view 0 is not",
        ),
        (
            "\"byteStride\":2",
            "\"byteStride\":3",
            "buffer view 2 is not",
        ),
        ("OCTAHEDRAL", "QUATERNION", "buffer view 1 is not"),
        ("{\"buffer\":0", "{\"buffer\":7", "buffer view 0 takes"),
    ] {
        let (json, all) = compressed(false, "TRIANGLES");
        let read = read((json.replace(from, to), all));
        let error = read.map_or_else(|error| error.to_string(), |of| of.unused.to_string());
        assert!(error.contains(says), "{to}: {error}");
    }
}

fn changed(from: &str, to: &str) -> Result<Model, ImportError> {
    let json = triangle_json("", "").replacen(from, to, 1);
    parse(Path::new("a.glb"), &glb(&json, &triangle_bytes()))
}

#[test]
fn what_is_wrong_and_no_geometry_is_left_out_and_named() {
    let cases = r#""material":0 => "material":9 => meshes[0].primitives[0].material
[1,0.5,0.25,1] => [1,0.5,0.25] => materials[0].pbrMetallicRoughness.baseColorFactor
"scene":0 => "scene":7 => scene (
{"asset" => {"cameras":[{"type":"odd"}],"asset" => cameras[0]
{"asset" => {"samplers":[{"magFilter":1}],"asset" => samplers[0].magFilter
{"asset" => {"textures":[{"source":3}],"asset" => textures[0].source
{"asset" => {"images":[{"bufferView":8}],"asset" => images[0].bufferView
{"asset" => {"extensionsUsed":["FOO_bar"],"asset" => the extension FOO_bar
{"asset" => {"animations":[{"channels":[{"sampler":0,"target":{}}]}],"asset" => 1 animation
{"asset" => {"extensions":{"KHR_lights_punctual":{"lights":[{"type":"rect"}]}},"asset" => lights[0]
"NORMAL":1 => "NORMAL":1,"_FOO":1 =>
"NORMAL":1 => "NORMAL":1,"UV0":1 => the attribute UV0
"NORMAL":1 => "NORMAL":2 => accessor 2 is Scalar
"byteLength":36}, => "byteLength":36,"target":0}, => bufferViews[0].target
{"mesh":0 => {"name":7,"mesh":0 => nodes[1].name
"scene":0,"scenes":[{"nodes":[0]}], => =>
{"asset" => {"extras":3,"asset" =>
"scene":0,"scenes":[{ => "scene":1,"scenes":[{},{ => 1 scene besides the first"#;
    for case in cases.lines() {
        let parts: Vec<&str> = case.split(" =>").map(str::trim).collect();
        let model = changed(parts[0], parts[1]).unwrap();
        let unused = model.unused.to_string();
        assert_eq!(model.mesh.triangles.len(), 1, "{case}");
        // Without a name it is legal, and nothing to be shown.
        let is_told = unused.contains(parts[2]) && unused.is_empty() == parts[2].is_empty();
        assert!(is_told, "{case}: {unused}");
    }
    let odd = parse(Path::new("a.gltf"), b"[3]").unwrap_err().to_string();
    assert!(odd.contains("not a valid glTF"), "{odd}");
}

#[test]
fn vertices_veils_metals_and_masks_are_as_their_materials_say() {
    let plain =
        r#"{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,1],"roughnessFactor":0.1}}"#;
    let material = |json: &str| {
        let coloured =
            triangle_json("", "").replacen("\"NORMAL\":1", "\"NORMAL\":1,\"COLOR_0\":1", 1);
        mesh(&coloured.replacen(plain, json, 1)).unwrap().materials[0].clone()
    };
    // Vertices colour no emission of what is lit.
    let black =
        r#"{"emissiveFactor":[0,1,0],"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1]}}"#;
    assert!(!material(black).vertex_colours);
    let veil = r#"{"alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{}},"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}}"#;
    let veil = material(veil);
    let opacity = veil.alpha.as_ref().map(|alpha| alpha.opacity);
    assert_eq!((veil.emission, opacity), ([1.0; 3], Some(0.25)));
    let gold = r#"{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[0,0,0,1],"specularFactor":[1,0.75,0.25],"glossinessFactor":1}}}"#;
    let gold = material(gold);
    assert_eq!(gold.microfacets.map(|facets| facets.metalness), Some(1.0));
    assert!((gold.diffuse[1] - 0.75).abs() < 1e-6, "{:?}", gold.diffuse);
    let hidden = r#"{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}}"#;
    assert!(changed(plain, hidden).is_err());
}
