//! A walking animal as a glTF file: the quadruped on ten joints, in a walk of a second.

use glam::{Mat4, Quat, Vec3};
use serde_json::{Value, json};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::quadruped::quadruped;
use std::collections::HashMap;
use std::f32::consts::TAU;

/// Keys of a track.
const KEYS: u16 = 16;

/// Where the joints are in the animal's frame (+X ahead), and on which they hang: the body, hips and
/// shoulders, knees, the neck and the tail.
const JOINTS: [([f32; 3], Option<usize>); 11] = [
    ([0.0, 0.0, 0.0], None),
    ([1.95, -0.5, 0.72], Some(0)),
    ([1.95, -0.5, -0.72], Some(0)),
    ([-2.5, -0.9, 0.82], Some(0)),
    ([-2.5, -0.9, -0.82], Some(0)),
    ([2.05, -1.95, 0.72], Some(1)),
    ([2.05, -1.95, -0.72], Some(2)),
    ([-3.2, -2.0, 0.8], Some(3)),
    ([-3.2, -2.0, -0.8], Some(4)),
    ([2.5, 1.0, 0.0], Some(0)),
    ([-3.6, 1.3, 0.0], Some(0)),
];

/// Returns 0 before `from`, 1 after `to`, and something between them between.
fn step(from: f32, to: f32, at: f32) -> f32 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns four joints of a vertex and their weights.
fn influences([x, y, z]: [f32; 3]) -> ([u8; 4], [f32; 4]) {
    let side = u8::from(z < 0.0);
    let below = step(-0.7, -1.5, y);
    let (fore, hind) = (below * step(1.1, 1.5, x), below * step(-2.0, -2.4, x));
    let tail = step(-3.7, -4.0, x) * step(0.4, 0.3, z.abs());
    let (leg, of_leg) = if tail > 0.0 {
        (10, tail)
    } else if fore > 0.0 {
        (1 + side, fore)
    } else if hind > 0.0 {
        (3 + side, hind)
    } else {
        (9, step(2.3, 3.6, x) * step(-1.0, 0.0, y))
    };
    let below_knee = if leg < 5 { step(-1.8, -2.2, y) } else { 0.0 };
    let weights = [
        1.0 - of_leg,
        of_leg * (1.0 - below_knee),
        of_leg * below_knee,
        0.0,
    ];
    ([0, leg, if leg < 5 { leg + 4 } else { 0 }, 0], weights)
}

/// Returns how far a joint is turned about the animal's side at a share of the walk: radians.
fn angle(joint: usize, share: f32) -> f32 {
    // One foot after another.
    let phase = [0.0, 0.0, 0.5, 0.75, 0.25, 0.0, 0.5, 0.75, 0.25, 0.0, 0.0][joint];
    let turn = TAU * (share + phase);
    match joint {
        0 => 0.0,
        1..=4 => 0.38 * turn.sin(),
        5 | 6 => -0.45 * (0.5 + 0.5 * turn.cos()),
        7 | 8 => 0.4 * (0.5 + 0.5 * turn.cos()),
        9 => 0.1 * (2.0 * turn).sin(),
        _ => 0.25 * turn.sin(),
    }
}

/// Returns a mesh with each triangle cut into four, as often as asked.
fn divided(mut mesh: TriangleMesh, times: u32) -> TriangleMesh {
    for _ in 0..times {
        let mut middles = HashMap::new();
        let mut finer = Vec::with_capacity(4 * mesh.triangles.len());
        for [a, b, c] in std::mem::take(&mut mesh.triangles) {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [a, b] = [a, b].map(|v| Vec3::from(mesh.positions[v as usize]));
                    mesh.positions.push(a.midpoint(b).to_array());
                    mesh.positions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        mesh.triangles = finer;
        mesh.normals.clear();
    }
    mesh
}

/// The file while it is written.
#[derive(Default)]
struct Glb {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Glb {
    /// Adds an accessor; returns its number.
    fn add(&mut self, bytes: &[u8], count: usize, kind: (&str, u32), more: &Value) -> usize {
        let (view, offset) = (self.views.len(), self.bytes.len());
        self.views
            .push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut accessor =
            json!({"bufferView": view, "componentType": kind.1, "count": count, "type": kind.0});
        for (key, value) in more.as_object().into_iter().flatten() {
            accessor[key] = value.clone();
        }
        self.accessors.push(accessor);
        view
    }

    fn floats(&mut self, kind: &str, values: &[f32], width: usize, more: &Value) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, values.len() / width, (kind, 5126), more)
    }

    /// Returns the bytes of the file, whose description lacks its buffers.
    fn finish(self, mut document: Value) -> Vec<u8> {
        document["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        document["bufferViews"] = self.views.into();
        document["accessors"] = self.accessors.into();
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut file = b"glTF".to_vec();
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        for word in [2, total as u32, text.len() as u32, 0x4E4F_534A] {
            file.extend(word.to_le_bytes());
        }
        file.extend(text);
        for word in [self.bytes.len() as u32, 0x004E_4942] {
            file.extend(word.to_le_bytes());
        }
        file.extend(self.bytes);
        file
    }
}

/// Returns the bytes of a binary glTF file, whose triangles are cut into four as often as asked.
pub fn walker(divisions: u32) -> Vec<u8> {
    let mesh = divided(quadruped(), divisions);
    let mut file = Glb::default();
    let (low, high) = mesh.bounds();
    let none = Value::Null;
    let positions = mesh.positions.as_flattened();
    let position = file.floats("VEC3", positions, 3, &json!({"min": low, "max": high}));
    let normal = file.floats("VEC3", mesh.vertex_normals().as_flattened(), 3, &none);
    let (joints, weights): (Vec<_>, Vec<_>) = mesh
        .positions
        .iter()
        .map(|&place| influences(place))
        .unzip();
    let count = joints.len();
    let joints = file.add(joints.as_flattened(), count, ("VEC4", 5121), &none);
    let weights = file.floats("VEC4", weights.as_flattened(), 4, &none);
    let corners = mesh.triangles.as_flattened();
    let bytes: Vec<u8> = corners
        .iter()
        .flat_map(|corner| corner.to_le_bytes())
        .collect();
    let indices = file.add(&bytes, corners.len(), ("SCALAR", 5125), &none);
    let unbound =
        JOINTS.map(|(place, _)| Mat4::from_translation(-Vec3::from(place)).to_cols_array());
    let unbound = file.floats("MAT4", unbound.as_flattened(), 16, &none);
    let share = |key: u16| f32::from(key) / f32::from(KEYS);
    let times: Vec<f32> = (0..=KEYS).map(share).collect();
    let times = file.floats("SCALAR", &times, 1, &json!({"min": [0.0], "max": [1.0]}));
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for joint in 1..JOINTS.len() {
        let turn = |key: u16| Quat::from_rotation_z(angle(joint, share(key))).to_array();
        let turns: Vec<[f32; 4]> = (0..=KEYS).map(turn).collect();
        let output = file.floats("VEC4", turns.as_flattened(), 4, &none);
        let target = json!({"node": joint + 1, "path": "rotation"});
        channels.push(json!({"sampler": samplers.len(), "target": target}));
        samplers.push(json!({"input": times, "output": output}));
    }
    let mut nodes = vec![json!({"name": "animal", "mesh": 0, "skin": 0})];
    for (number, (place, parent)) in JOINTS.iter().enumerate() {
        let from = parent.map_or(Vec3::ZERO, |parent| JOINTS[parent].0.into());
        let below: Vec<usize> = (0..JOINTS.len())
            .filter(|&other| JOINTS[other].1 == Some(number))
            .map(|other| other + 1)
            .collect();
        let mut node = json!({"translation": (Vec3::from(*place) - from).to_array()});
        if !below.is_empty() {
            node["children"] = below.into();
        }
        nodes.push(node);
    }
    let hide = json!({"pbrMetallicRoughness": {
        "baseColorFactor": [0.55, 0.33, 0.2, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.7
    }});
    let attributes =
        json!({"POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let joints: Vec<usize> = (1..=JOINTS.len()).collect();
    file.finish(json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": nodes,
        "materials": [hide],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0}]}],
        "skins": [{"joints": joints, "inverseBindMatrices": unbound}],
        "animations": [{"name": "walk", "channels": channels, "samplers": samplers}]
    }))
}
