//! The documented example, and faults at their lines.

use super::*;
use crate::files::description::tests::{check_faults, line_of};
use crate::picture::Picture;
use crate::scene::Light;
use crate::scene::material::Cover;
use crate::scene::texture::tests::{grey_png, texels};
use miette::Diagnostic;
use shisen_core::spectrum::Medium;
use std::convert::Infallible;
use std::f32::consts::PI;

const EXAMPLE: &str = include_str!("../example.toml");

/// 4 wide, 2 high, 2 deep, its least corner at the origin.
fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 2.0],
        ],
        coordinates: vec![[0.0; 2]; 4],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..TriangleMesh::default()
    }
}

fn read(text: &str) -> Result<Scene, Located<SceneFault>> {
    Scene::from_toml(text, "lawn.toml", Path::new("scenes"), |_| {
        Ok::<_, Infallible>(tetrahedron())
    })
}

#[test]
fn the_documented_example_is_a_scene() {
    let mut sources = Vec::new();
    let scene = Scene::from_toml(EXAMPLE, "lawn.toml", Path::new("scenes"), |source| {
        sources.push(source.clone());
        Ok::<_, Infallible>(tetrahedron())
    })
    .unwrap();
    // By name: animal before cow and floor, chrome before glass.
    assert_eq!(
        sources,
        [
            MeshSource::BuiltIn(BuiltInMesh::Quadruped),
            MeshSource::File("scenes/meshes/cow.obj".into()),
            MeshSource::BuiltIn(BuiltInMesh::Square),
        ]
    );
    assert_eq!(scene.name, "chrome on a lawn");
    let [brass, chrome, glass, globe, _, prism, tiles] = &scene.materials[..] else {
        panic!("seven materials were described");
    };
    let facets = brass.microfacets.as_ref().unwrap();
    assert_eq!((facets.metalness, facets.roughness), (1.0, 0.3));
    assert_eq!((brass.specular, glass.priority), ([0.04; 3], 2));
    let alpha = tiles.alpha.as_ref().unwrap();
    assert_eq!(
        (&alpha.texture, alpha.cover),
        (&tiles.texture, Cover::Mask(0.5))
    );
    assert_eq!((chrome.shininess, glass.shininess), (200.0, 32.0));
    let lines = globe.graticule.unwrap();
    assert_eq!((lines.divisions, lines.width), (9, 0.3f32.to_radians()));
    let flint = Medium::named("sf11").unwrap().index(588.0);
    assert_eq!(prism.medium.map(|m| m.index(588.0)), Some(flint));
    assert_eq!(
        tiles.texture.as_ref().unwrap().map,
        [[8.0, 0.0], [0.0, 8.0], [0.0; 2]]
    );
    assert_eq!(scene.camera.frames(), 120);
    let [cow, animal, sphere, spheroid, floor] = &scene.objects[..] else {
        panic!("five objects were described");
    };
    assert_eq!((floor.shape, floor.material), (Shape::Mesh(2), Some(6)));
    assert_eq!((animal.shape, animal.material), (Shape::Mesh(0), None));
    assert!(sphere.casts_shadow && !spheroid.casts_shadow);
    // The cow's box is centred on its place and 2 m wide.
    let placed = cow.world_from_object;
    let centre = placed.transform_point3(DVec3::new(2.0, 1.0, 1.0));
    assert!((centre - DVec3::new(0.0, 1.0, -3.0)).length() < 1e-12);
    let across = placed.transform_vector3(DVec3::new(4.0, 0.0, 0.0));
    assert!((across.length() - 2.0).abs() < 1e-12);
    let rectangle = Light::Rectangle {
        centre: DVec3::new(0.0, 3.0, -3.0),
        right: DVec3::new(-0.6, 0.0, 0.0),
        up: DVec3::new(0.0, 0.0, -0.3),
        colour: [9.0, 9.0, 8.0],
        samples: 16,
        two_sided: false,
    };
    assert_eq!(scene.lights[1], rectangle);
}

#[test]
fn animations_move_objects_in_place_of_their_own_keys() {
    let text = r#"
[meshes.m]
file = "m.obj"
[[object]]
name = "it"
mesh = "m"
normalise = true
position = [0, 7, 0]
yaw_degrees = 10
scale = 2
[[animation]]
object = "it"
times = [1, 3]
rotation_degrees = [[0, 0, 0], [360, 0, 0]]
position = [[0, 0, 0], [0, 4, 0]]
[[animation]]
object = "it"
spin = { seconds_per_turn = -4 }
"#;
    let scene = read(text).unwrap();
    assert_eq!(scene.duration(), 4.0);
    // The box's corner, half a metre to the left and twice as large, from its centre.
    let corner = |scene: &Scene| {
        let map = scene.objects[0].world_from_object;
        map.transform_point3(DVec3::new(0.0, 1.0, 1.0))
    };
    let near =
        |found: DVec3, x, y, z| assert!((found - DVec3::new(x, y, z)).length() < 1e-12, "{found}");
    near(corner(&scene), -1.0, 0.0, 0.0);
    // A quarter turn by keys, and the spin's three eighths back.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    near(corner(&scene.at(1.5)), -half, 1.0, -half);
}

#[test]
fn the_least_scene_is_one_object() {
    let scene = read("[[object]]\nsphere = { radius = 1 }\nscale = [1, 2, 3]").unwrap();
    assert_eq!((scene.name.as_str(), scene.lights.len()), ("lawn", 0));
    assert_eq!(scene.background, Background::uniform([0.0; 3]));
    assert_eq!(
        scene.objects[0].world_from_object.matrix3,
        glam::DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))
    );
    let error = read("ambient = [1, 1, 1]").unwrap_err();
    assert!(error.to_string().contains("no objects") && error.line().is_none());
}

/// As `check_faults` reads them.
const FAULTS: &str = r#"
ambient = [0.1, 0.1 | ambient = [-0.1, 0.1 | `ambient` is -0.1
ambient | ambiant | unknown key `ambiant`
alpha = 1.0 | alpha = 1.01 | from 0 to 1
shininess = 200 | shininess = 0 | from 1 to 10000
index_of_refraction = 1.52 | index_of_refraction = nan | 0.01 to 100
builtin = "quadruped" | builtin = "quadripod" | no built-in mesh
mesh = "cow" | mesh = "crow" | no mesh "crow"
material = "glass" | material = "gloss" | no material "gloss"
scale = 2 | scale = [1, 1] | `scale` must be a number or [x, y, z]
scale = 2 | scale = [1, 1, 1, 1] | `scale` must be a number or [x, y, z]
index_of_refraction = 1.52 | index_of_refraction = "x" | `index_of_refraction` must be a number, not "x"
sphere = { radius = 0.5 } | sphere = { radius = true } | `radius` must be a number, not true
position = [0, 1.0, -3.0] | position = [0, 1.0] | `position` must be three numbers
position = [0, 1.0, -3.0] | position = [0, "a", 1] | a value of `position` must be a number, not "a"
builtin = "quadruped" | builtin = 5 | `builtin` must be text in quotes, not 5
[[light]] | [[light] | this is not valid TOML
builtin = "quadruped" | builtin = "quadruped | this is not valid TOML
radius = 0.5 | radios = 0.5 | unknown key `radios`
position = [0, 1.6, -2] | | the key `position` is missing | *
scale = 2 | scale = [1, -1, 1] | `scale` is -1
position = [0, 1.0, -3.0] | position = [0, 1e7, 0] | `position` is 10000000
yaw_degrees = -15 | yaw_degrees = 361 | from -360 to 360
normals = "smooth" | normals = "smoth" | no kind of normals
radius = 0.5 | radius = 0 | `radius` is 0
casts_shadow = false | normalise = true | `normalise` is for
casts_shadow = false | normals = "flat" | `normals` is for
type = "point" | type = "laser" | no type of light "laser"
cone_degrees = [20, 30] | cone_degrees = [0, 0] | `cone_degrees` are 0 and 0
cone_degrees = [20, 30] | cone_degrees = [20, 91] | `cone_degrees` is 91
cone_degrees = [20, 30] | | a spot needs `cone_degrees` | type = "spot"
direction = [0.3, -1, -0.2] | direction = [0, 0, -0.0] | is zero
samples = 16 | samples = 65 | `samples` is 65
samples = 16 | samples = 1.5 | whole number
size = [1.2, 0.6] | size = [1.2, 0] | `size` is 0
up = [0, 0, -1] | up = [0, 3, 0] | `up` is zero or along
emission = [9 | emission = [-9 | `emission` is -9
texture = "tiles" | texture = "tile" | no texture
medium = "flint" | medium = "flnt" | no medium
repeats = [8, 8] | repeats = [8, 0] | `repeats` is 0
[0.9, 0.9, 0.9] | [0.9, 1.1, 0.9] | `colours` is 1.1
form = 2 | form = 3 | `form` is 3
range_nm = [390, | range_nm = [1, | `range_nm` is 1
coefficients = [0, | coefficients = [ | 6 coefficients
[390, 2500] | [110, 2500] | has a pole at 116 | [media.flint]
frame = 120 | frame = 1 | is not after | # a smooth
frame = 120 | frame = 0 | `frame` is 0
frame = 120 | | needs `frame` | position = [0, 1.6, -2]
divisions = 9 | divisions = 0 | `divisions` is 0 | graticule
width_degrees = 0.3 | width_degrees = nan | `width_degrees` is NaN | graticule
"directional" | "point" | `direction` is for spots, directional lights and rectangles only | direction = [0.3
"point" | "directional" | `position` is for point lights, spots and rectangles only | position = [0, 2.5
position = [0, 2.5, 0.5] | | a point light needs `position` | type = "point"
direction = [0.3, -1, -0.2] | inverse_square = false | `inverse_square` is for point lights and spots only
direction = [0.3, -1, -0.2] | | a directional light needs `direction` | type = "directional"
nadir   = [0.12, 0.20, 0.08] | | the background has either | *
alpha = 1.0 | colour = [0, 0, 0] | the background has either | *
checker = { | file = "no.png"\nchecker = { | a texture has one of | [textures.tiles]
medium = "flint" | medium = "flint"\nindex_of_refraction = 1.5 | a material has at most one of
file = "meshes/cow.obj" | | a mesh has one of | [meshes.cow]
builtin = | file = "a.ply"\nbuiltin = | a mesh has one of | [meshes.floor]
sphere = { radius = 0.5 } | | an object has one of | *
mesh = "cow" | mesh = "cow"\nsphere = { radius = 1 } | an object has one of | *
yaw_degrees = -15 | yaw_degrees = 0\nrotation_degrees = [0, 0, 0] | an object has at most one of | *
texture = "tiles" | index_of_refraction = 1.5 | `index_of_refraction` is for materials
texture = "tiles" | medium = "water" | `medium` is for materials
texture = "tiles" | absorption = [0, 0, 0] | `absorption` is for materials
texture = "tiles" | normal_texture = "tiles" | is a checker, not an image
alpha = 1.0 | image = "sky.exr" | the background has either | *
alpha = 1.0 | yaw_degrees = 90 | `yaw_degrees` is for a background with an `image` only
alpha = 1.0 | strength = 2 | `strength` is for a background with an `image` only
texture = "tiles" | normal_scale = 1 | `normal_scale` is for materials
object = "animal" | object = "anmal" | no object "anmal"
times = [0, 1.5, 3] | times = [0, 3, 1.5] | key 2 at 1.5 s, and not at 3 s or later
spin = { axis = [0, 1, 0], seconds_per_turn = 8 } | times = [0]\nposition = [[0, 0, 0]] | two animations of one property | *
times = [0, 1.5, 3] | times = [] | has 3 keys, `times` 0
times = [0, 1.5, 3] | | an animation has either | *
interpolation = "cubic" | spin = { seconds_per_turn = 2 } | an animation has either | *
interpolation = "cubic" | interpolation = "cubik" | no interpolation "cubik"
seconds_per_turn = 8 | seconds_per_turn = 0 | neither is zero | *
normalise = true | name = "animal" | two objects are called "animal" | # for an [[animation]]
"#;

#[test]
fn faults_point_at_their_line_and_help() {
    check_faults(EXAMPLE, FAULTS, read);
}

#[test]
fn images_that_cannot_be_had_are_named_at_their_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("good.png"), grey_png(&[9; 2])).unwrap();
    let read = |name: &str| {
        let text = format!(
            "[textures.one]\nfile = \"{name}\"\n[materials.one]\ntexture = \"one\"\n\
             normal_texture = \"one\"\nnormal_scale = 0.5\n[[object]]\nsphere = {{ radius = 1 }}\nmaterial = \"one\"\n"
        );
        let mesh = |_: &MeshSource| Ok::<_, Infallible>(tetrahedron());
        Scene::from_toml(&text, "a.toml", folder.path(), mesh)
    };
    let scene = read("good.png").unwrap();
    assert_eq!(texels(&scene.materials[0]), [[9, 9, 9, 255]; 2]);
    let normals = scene.materials[0].normal_map.as_ref().unwrap();
    let texture = scene.materials[0].texture.as_ref();
    assert_eq!((Some(&normals.texture), normals.scale), (texture, 0.5));
    for name in ["none.png", "."] {
        let error = read(name).unwrap_err();
        assert!(error.to_string().contains("the texture \"one\""), "{error}");
        assert_eq!(error.line(), Some(1), "{name}");
    }
}

#[test]
fn a_background_can_be_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut picture = Picture::new(4, 2).unwrap();
    for x in 0..4 {
        picture.set_pixel(x, 0, [2.0, f32::NAN, 0.5, 1.0]);
    }
    picture
        .write_exr(&folder.path().join("a.exr"), &[])
        .unwrap();
    std::fs::write(folder.path().join("b.exr"), b"\x76\x2f\x31\x01").unwrap();
    let read = |name: &str| {
        let text = format!(
            "[background]\nimage = \"{name}\"\nyaw_degrees = 180\nstrength = 3\n\
             [[object]]\nsphere = {{ radius = 1 }}\n"
        );
        let mesh = |_: &MeshSource| Ok::<_, Infallible>(tetrahedron());
        Scene::from_toml(&text, "a.toml", folder.path(), mesh)
    };
    let scene = read("a.exr").unwrap();
    let environment = scene.environment.as_ref().unwrap();
    assert_eq!(environment.image.sides(), [4, 2]);
    assert_eq!(environment.image.pixels()[3], [2.0, 0.0, 0.5]);
    assert_eq!(environment.image.replaced(), 4);
    assert_eq!((environment.yaw, environment.strength), (PI, 3.0));
    assert_eq!(
        (scene.ambient, scene.background.zenith),
        ([3.0, 0.0, 0.75], [6.0, 0.0, 1.5])
    );
    for (name, says) in [
        ("none.exr", "no such file"),
        ("b.exr", "no picture of the channels R, G and B"),
    ] {
        let error = read(name).unwrap_err();
        let causes = std::iter::successors(Some(&error as &dyn std::error::Error), |e| e.source());
        let said: Vec<String> = causes.map(ToString::to_string).collect();
        assert!(said.concat().contains(says), "{said:?}");
        assert_eq!(error.line(), Some(1), "{name}");
    }
}

#[test]
fn a_name_without_a_table_is_helped_with_its_table() {
    let error = read("[[object]]\nmesh = \"cow\"").unwrap_err();
    let help = Diagnostic::help(&error).unwrap().to_string();
    assert!(help.contains("no mesh: add [meshes.cow]"), "{help}");
}

#[test]
fn meshes_that_cannot_be_loaded_or_used_are_named() {
    type Load = fn() -> Result<TriangleMesh, std::io::Error>;
    let cases: [(Load, &str, &str); 4] = [
        (
            || Err(std::io::ErrorKind::NotFound.into()),
            "mesh \"animal\" cannot be loaded",
            "[meshes.animal]",
        ),
        (
            || Ok(TriangleMesh::default()),
            "mesh \"animal\" cannot be used",
            "[meshes.animal]",
        ),
        (
            || {
                let mut point = tetrahedron();
                point.positions = vec![[1.0; 3]; 4];
                Ok(point)
            },
            "the mesh is a point",
            "normalise = true",
        ),
        (
            || {
                let mut bare = tetrahedron();
                bare.coordinates.clear();
                Ok(bare)
            },
            "no texture coordinates",
            "material = \"tiles\"",
        ),
    ];
    for (load, says, place) in cases {
        let error = Scene::from_toml(EXAMPLE, "a.toml", Path::new(""), |_| load()).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
        assert_eq!(error.line(), Some(line_of(EXAMPLE, place)), "{error}");
    }
}
