use super::super::parse;
use super::super::tests::{mesh, triangle_bytes, triangle_json};
use super::*;
use crate::scene::texture::tests::{grey_and_alpha_png, grey_png, texels};

#[test]
fn textures_are_those_of_the_first_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.png"), grey_png(&[99])).unwrap();
    let mut bytes = triangle_bytes();
    let tangents = [[0.0, 0.0, -2.0, -1.0], [1.0, 0.0, 0.0, 1.0], [0.0; 4]];
    let places = [0.0_f32, 1.0, 1.0, 1.0, 0.0, 0.25];
    for number in places.iter().chain(tangents.as_flattened()) {
        bytes.extend(number.to_le_bytes());
    }
    // Aligned anew: the indices before take six bytes.
    let at = triangle_bytes().len();
    std::fs::write(folder.path().join("a.bin"), &bytes).unwrap();
    let read = |texture: &str, uri: &str| {
        let mut json = triangle_json("", r#","uri":"a.bin""#).replace(":78", ":150");
        let source = if uri == "b.ktx2" {
            r#""extensions":{"KHR_texture_basisu":{"source":0}}"#
        } else {
            r#""source":0"#
        };
        let images = format!(r#""images":[{{"uri":"{uri}"}}],"textures":[{{{source}}}],"#);
        for (before, added) in [
            (r#""NORMAL":1"#, r#","TEXCOORD_0":3,"TANGENT":4"#),
            (
                r#""type":"SCALAR"}"#,
                r#",{"bufferView":3,"componentType":5126,"count":3,"type":"VEC2"},
                   {"bufferView":4,"componentType":5126,"count":3,"type":"VEC4"}"#,
            ),
            (
                r#""byteLength":6}"#,
                &format!(
                    r#",{{"buffer":0,"byteOffset":{at},"byteLength":24}},
                       {{"buffer":0,"byteOffset":{},"byteLength":48}}"#,
                    at + 24
                ),
            ),
            (
                r#""roughnessFactor":0.1"#,
                &format!(r#","baseColorTexture":{texture}"#),
            ),
            (r#""scene":0,"#, &images),
        ] {
            json = json.replace(before, &format!("{before}{added}"));
        }
        parse(&folder.path().join("a.gltf"), json.as_bytes()).unwrap()
    };
    let mesh = read(r#"{"index":0}"#, "a%20b.png").mesh;
    assert_eq!(mesh.coordinates, [[0.0, 0.0], [1.0, 0.0], [0.0, 0.75]]);
    assert_eq!(texels(&mesh.materials[0]), [[99, 99, 99, 255]]);
    // A path of another computer; another set of coordinates; no image; none at all.
    assert_eq!(read(r#"{"index":0}"#, "/x/../a b.png").mesh, mesh);
    let moved = read(
        r#"{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],"scale":[2,4]}}}"#,
        "a%20b.png",
    );
    let texture = moved.mesh.materials[0].texture.clone().unwrap();
    assert_eq!(texture.map, [[2.0, 0.0], [0.0, 4.0], [0.5, -3.25]]);
    let bumpy = read(
        r#"{"index":0}},"normalTexture":{"index":0,"scale":0.5,"extensions":{
        "KHR_texture_transform":{"offset":[0.5,0.25],"scale":[2,4]}}},"extras":{"a":0"#,
        "a%20b.png",
    );
    let map = bumpy.mesh.materials[0].normal_map.as_ref().unwrap();
    assert_eq!((map.scale, map.texture.map), (0.5, texture.map));
    // Tangents get unit length; baking makes the one that has no direction.
    let expected = [[0.0, 0.0, -1.0, -1.0], [1.0, 0.0, 0.0, 1.0], [0.0; 4]];
    assert_eq!(bumpy.mesh.tangents, expected);
    assert!(bumpy.unused.is_empty() && moved.mesh.tangents.is_empty());
    for (texture, uri, says) in [
        (
            r#"{"index":0,"texCoord":2}"#,
            "a%20b.png",
            "1 texture on further coordinates than two",
        ),
        (
            r#"{"index":0}"#,
            "b.png",
            "the texture b.png (which is not there)",
        ),
        (
            r#"{"index":0}"#,
            "b.ktx2",
            "the texture b.ktx2 (in KTX2, which is not read)",
        ),
    ] {
        let model = read(texture, uri);
        assert_eq!(model.mesh.materials[0].texture, None);
        assert_eq!(model.unused.names(), [says]);
    }
    let veiled = grey_and_alpha_png(&[99, 255, 99, 254]);
    std::fs::write(folder.path().join("veiled.png"), veiled).unwrap();
    for (mode, uri, cover) in [
        ("MASK", "veiled.png", Some(Cover::Mask(0.5))),
        ("BLEND", "veiled.png", Some(Cover::Blend)),
        ("OPAQUE", "veiled.png", None),
        ("BLEND", "a%20b.png", None),
        ("MASK", "a%20b.png", None),
    ] {
        let texture = format!(r#"{{"index":0}}}},"alphaMode":"{mode}","extras":{{"a":0"#);
        let material = read(&texture, uri).mesh.materials.swap_remove(0);
        assert_eq!(material.alpha.map(|of| of.cover), cover, "{mode}");
    }
}

#[test]
fn materials_are_metal_glass_veils_lamps_or_dull() {
    let of = |to: &str| {
        let json = triangle_json("", "").replace(r#""roughnessFactor":0.1}"#, to);
        mesh(&json).unwrap().materials.swap_remove(0)
    };
    let metalness = |of: &Material| of.microfacets.as_ref().unwrap().metalness;
    let metal = of(r#""roughnessFactor":0.1}"#);
    assert_eq!(metal.diffuse, [1.0, 0.5, 0.25]);
    let expected = Microfacets {
        metalness: 1.0,
        roughness: 0.1,
        texture: None,
    };
    assert_eq!(metal.microfacets, Some(expected));
    let glass = of(r#""metallicFactor":0},"extensions":{
        "KHR_materials_transmission":{"transmissionFactor":0.75},"KHR_materials_ior":{"ior":1.33},
        "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":2,
        "attenuationColor":[1,0.5,1]}}"#);
    assert_eq!(metalness(&glass), 0.0);
    assert_eq!(glass.transmission, [0.75, 0.375, 0.1875]);
    assert_eq!(glass.diffuse, [0.25, 0.125, 0.0625]);
    assert_eq!(glass.index_of_refraction, 1.33);
    assert_eq!(glass.medium, None);
    assert!((glass.absorption[1] - 0.5 * 2.0_f32.ln()).abs() < 1.0e-6);
    let prism = |dispersion: f32| {
        of(&format!(
            r#""metallicFactor":0}},"extensions":{{"KHR_materials_ior":{{"ior":1.7}},
            "KHR_materials_volume":{{"thicknessFactor":1}},
            "KHR_materials_transmission":{{"transmissionFactor":1}},
            "KHR_materials_dispersion":{{"dispersion":{dispersion}}}}}"#
        ))
    };
    let medium = prism(0.5).medium.unwrap();
    let (index, abbe) = (medium.index(587.6), medium.abbe().unwrap());
    assert!(
        (index - 1.7).abs() < 1.0e-4 && (abbe - 40.0).abs() < 0.1,
        "{index}, {abbe}"
    );
    assert_eq!([prism(0.0).medium, prism(1.0e3).medium], [None; 2]);
    let thin = of(r#""metallicFactor":0},"extensions":{
        "KHR_materials_transmission":{"transmissionFactor":1}}"#);
    assert!((thin.index_of_refraction - 1.0) < 1.0e-5 && thin.transmission[1] == 0.5);
    let older = of(
        r#""metallicFactor":1},"extensions":{"KHR_materials_pbrSpecularGlossiness":{
        "diffuseFactor":[1,0.5,0.25,1],"specularFactor":[0.04,0.04,0.04],"glossinessFactor":0.5}}"#,
    );
    assert_eq!(older.diffuse, [1.0, 0.5, 0.25]);
    assert_eq!(older.specular, [0.04; 3]);
    assert_eq!(metalness(&older), 0.0);
    let odd = of(r#""metallicFactor":0},"extensions":{"KHR_materials_ior":{"ior":0.005}}"#);
    assert_eq!(odd.index_of_refraction, 0.01);
    let lamp = of(
        r#""metallicFactor":0},"emissiveFactor":[1,0.5,0],"extensions":{
        "KHR_materials_emissive_strength":{"emissiveStrength":4}}"#,
    );
    assert_eq!(lamp.emission, [4.0, 2.0, 0.0]);
    let unlit = of(r#""metallicFactor":0},"extensions":{"KHR_materials_unlit":{}}"#);
    assert_eq!(
        (unlit.diffuse, unlit.emission),
        ([0.0; 3], [1.0, 0.5, 0.25])
    );
    let veil = triangle_json("", "")
        .replace("0.25,1]", "0.25,0.5]")
        .replace(
            r#""roughnessFactor":0.1}"#,
            r#""metallicFactor":0},"alphaMode":"BLEND""#,
        );
    let veil = &mesh(&veil).unwrap().materials[0];
    assert_eq!(
        (veil.diffuse, veil.alpha.as_ref().map(|alpha| alpha.opacity)),
        ([1.0, 0.5, 0.25], Some(0.5))
    );
    assert_eq!(veil.index_of_refraction, 1.0);
}
