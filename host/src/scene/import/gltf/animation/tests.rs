use crate::scene::import::gltf::parse;
use crate::scene::import::gltf::tests::glb;
use crate::scene::import::{ImportError, Model};
use crate::scene::motion::Playing;
use crate::scene::{Object, Scene, Shape};
use glam::{DVec3, Vec3};
use std::fmt::Write as _;
use std::path::Path;

/// A still triangle, one that slides and morphs, and a strip of two squares on two joints, of which
/// the second turns by a right angle within 2 s.
const MOVING: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"mesh":1,"scale":[1,1,-1]},
{"mesh":2,"skin":0,"translation":[7,7,7]},{"children":[4]},{"translation":[1,0,0]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]},
{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}]},
{"primitives":[{"attributes":{"POSITION":2,"NORMAL":3,"JOINTS_0":4,"WEIGHTS_0":5},"mode":5}]}],
"skins":[{"joints":[3,4],"inverseBindMatrices":6}],
"animations":[{"name":"bend","channels":[{"sampler":0,"target":{"node":4,"path":"rotation"}},
{"sampler":1,"target":{"node":1,"path":"weights"}}],
"samplers":[{"input":7,"output":8},{"input":7,"output":9,"interpolation":"STEP"}]},
{"name":"slide","channels":[{"sampler":0,"target":{"node":1,"path":"translation"}}],
"samplers":[{"input":7,"output":10}]}],"accessors":["#;

/// Returns the file and its bytes.
fn moving() -> (String, Vec<u8>) {
    let strip: Vec<f32> = (0..6)
        .flat_map(|n| [(n / 2) as f32, (n % 2) as f32, 0.0])
        .collect();
    let bound = |x| {
        [
            [1., 0., 0., 0., 0., 1., 0., 0.],
            [0., 0., 1., 0., x, 0., 0., 1.],
        ]
        .concat()
    };
    let half = std::f32::consts::FRAC_1_SQRT_2;
    // The middle hangs on both joints alike, but for rounding.
    let weights = [
        [255, 0],
        [255, 0],
        [127, 127],
        [127, 127],
        [0, 255],
        [0, 255],
    ];
    let floats: [(&str, usize, Vec<f32>); 9] = [
        ("VEC3", 3, vec![0., 0., 0., 1., 0., 0., 0., 1., 0.]),
        ("VEC3", 3, vec![0., 0., 0., 0., 0., 0., 0., 0., 2.]),
        ("VEC3", 6, strip),
        ("VEC3", 6, [0., 0., 1.].repeat(6)),
        ("MAT4", 2, [bound(0.), bound(-1.)].concat()),
        ("SCALAR", 2, vec![0., 2.]),
        ("VEC4", 2, vec![0., 0., 0., 1., 0., 0., half, half]),
        ("SCALAR", 2, vec![0.5, 1.]),
        ("VEC3", 2, vec![0., 0., 0., 4., 0., 0.]),
    ];
    let floats = floats.map(|(kind, count, all)| {
        let bytes = all.iter().flat_map(|number| number.to_le_bytes());
        (kind, 5126, count, bytes.collect())
    });
    let mut accessors: Vec<(&str, u32, usize, Vec<u8>)> = floats.to_vec();
    let weights = weights.iter().flat_map(|[a, b]| [*a, *b, 0, 0]).collect();
    accessors.insert(4, ("VEC4", 5121, 6, [0, 1, 0, 0].repeat(6)));
    accessors.insert(5, ("VEC4\",\"normalized\":true,\"x\":\"", 5121, 6, weights));
    let (mut json, mut views, mut bytes) = (MOVING.to_owned(), String::new(), Vec::new());
    for (number, (kind, component, count, own)) in accessors.iter().enumerate() {
        let comma = if number == 0 { "" } else { "," };
        let view = format!(r#"{comma}{{"bufferView":{number},"componentType":{component}"#);
        write!(json, r#"{view},"count":{count},"type":"{kind}"}}"#).unwrap();
        let (offset, length) = (bytes.len(), own.len());
        let place = format!(r#""byteOffset":{offset},"byteLength":{length}"#);
        write!(views, r#"{comma}{{"buffer":0,{place}}}"#).unwrap();
        bytes.extend(own);
    }
    let length = bytes.len();
    write!(
        json,
        r#"],"bufferViews":[{views}],"buffers":[{{"byteLength":{length}}}]}}"#
    )
    .unwrap();
    (json, bytes)
}

fn read(from: &str, to: &str) -> Result<Model, ImportError> {
    let (json, bytes) = moving();
    assert!(json.contains(from), "{from}");
    parse(
        Path::new("a.glb"),
        &glb(&json.replacen(from, to, 1), &bytes),
    )
}

fn scene(playing: &Playing) -> Scene {
    let Model {
        mesh,
        mut rig,
        unused,
        ..
    } = read("{", "{").unwrap();
    assert!(unused.is_empty(), "{unused}");
    rig.play(playing);
    let mut scene = Scene {
        meshes: vec![mesh],
        objects: vec![Object::new(Shape::Mesh(0))],
        ..Scene::default()
    };
    scene.animate(0, rig);
    scene
}

#[track_caller]
fn assert_places(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    let near = |(a, b): (&[f32; 3], &[f32; 3])| Vec3::from(*a).abs_diff_eq(Vec3::from(*b), 1.0e-6);
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(near),
        "{found:?}"
    );
}

#[test]
fn joints_and_weights_deform_as_their_closed_forms_say() {
    let scene = scene(&Playing::First);
    assert_eq!(
        (scene.duration(), scene.objects.len(), scene.meshes.len()),
        (2.0, 3, 3)
    );
    // 3 s are 1 s again: the second joint has turned by 45°, and the targets weigh a half.
    let still = scene.at(3.0);
    let [fixed, morphed, strip] = &still.meshes[..] else {
        panic!("three parts")
    };
    assert_places(
        &fixed.positions,
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    );
    assert_places(
        &morphed.positions,
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]],
    );
    // Without normals in the file it is flat, in its own frame.
    let slope = std::f32::consts::FRAC_1_SQRT_2;
    assert_places(&morphed.normals, &[[0.0, -slope, slope]; 3]);
    let turned = |along: f32, up: f32| [1.0 + slope * (along - up), slope * (along + up), 0.0];
    let middle = |up: f32| {
        let mean = 0.5 * (Vec3::new(1.0, up, 0.0) + Vec3::from(turned(0.0, up)));
        mean.to_array()
    };
    let expected = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        middle(0.0),
        middle(1.0),
        turned(1.0, 0.0),
        turned(1.0, 1.0),
    ];
    assert_places(&strip.positions, &expected);
    assert!(still.motion.is_empty() && still.meshes.iter().all(|mesh| mesh.validate().is_ok()));
    // The pose of a memory used again is the same.
    let mut pose = scene.pose(0.5);
    scene.pose_into(3.0, &mut pose);
    assert_eq!(pose, scene.pose(3.0));
    assert_eq!(pose.meshes[1].1.positions, strip.positions);
}

#[test]
fn only_what_plays_moves() {
    let named = |name: &str| scene(&Playing::Named(name.to_owned()));
    let slide = named("slide");
    // The strip stays with the still triangle; the other is mirrored by its node.
    assert_eq!(
        (slide.objects.len(), slide.meshes[0].triangles.len()),
        (2, 5)
    );
    assert_eq!(slide.meshes[1].triangles, [[0, 1, 2]]);
    let pose = slide.pose(1.0);
    let [(1, map)] = pose.objects[..] else {
        panic!("{pose:?}")
    };
    assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(3.0, 1.0, -1.0));
    assert!(pose.meshes.is_empty());
    let all = scene(&Playing::All);
    assert_eq!(all.pose(1.0).objects, pose.objects);
    assert_eq!(all.pose(1.0).meshes.len(), 2);
    let mut stopped = all.clone();
    stopped.stop();
    for still in [named("x"), scene(&Playing::None)] {
        assert!(still.motion.is_empty() && still.duration() == 0.0);
        assert_eq!((still.meshes.len(), still.motion.clips().len()), (1, 2));
        assert_eq!(still.meshes[0], read("{", "{").unwrap().mesh);
        assert_eq!(
            stopped.objects[1].world_from_object.matrix3.z_axis,
            DVec3::NEG_Z
        );
    }
}

/// Changes of the file, and what is told of them.
const WRONG: &str = r#"7,"componentType":5126,"count":2 => 7,"componentType":5126,"count":0 => "bend": channel 0 has no keys
"input":7,"output":8 => "input":7,"output":7 => has to be Vec4
"input":7,"output":9 => "input":8,"output":9 => accessor 8
"input":7,"output":9 => "input":7,"output":7 => -
"STEP" => "CUBICSPLINE" => channel 1 has 2 numbers for its keys, which need 6
[3,4],"inv => [3],"inv => joints of vertices beyond those of their skin
"node":4 => "node":9 => 1 animation channel of unknown nodes or properties
"node":4,"path":"rotation" => "path":"pointer" => 1 animation channel of unknown nodes or properties
"node":4,"path":"rotation" => "node":0,"path":"weights" => no morph targets
"sampler":1,"target":{"node":1,"path":"weights"} => "sampler":0,"target":{"node":4,"path":"rotation"} => 1 animation channel of a property that another one moves
"sampler":1 => "sampler":5 => animations[0]
{"children":[4]} => {"children":[4,3]} => 1 animation channel of nodes outside the scene
{"mesh":0} => {"mesh":0,"children":[4]} => more than one parent"#;

#[test]
fn what_is_wrong_in_animations_is_told() {
    for case in WRONG.lines() {
        let [from, to, says] = case.split(" => ").collect::<Vec<_>>()[..] else {
            panic!("{case}")
        };
        let told = read(from, to);
        let told = told.map_or_else(|error| error.to_string(), |model| model.unused.to_string());
        let expected = told.contains(says.trim_matches('-'))
            && told.is_empty() == says.trim_matches('-').is_empty();
        assert!(expected, "{case}: {told}");
    }
    let (json, mut bytes) = moving();
    let back = bytes
        .windows(8)
        .rposition(|eight| eight == [0.0_f32, 2.0].map(f32::to_le_bytes).as_flattened());
    bytes[back.unwrap()..][..4].copy_from_slice(&3.0_f32.to_le_bytes());
    let error = parse(Path::new("a.glb"), &glb(&json, &bytes))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains(r#""bend": channel 0 has key 1 at 2 s, and not at 3 s or later"#),
        "{error}"
    );
}
