//! Meshes that joints and morph targets deform.

use crate::scene::import::flat_normal;
use glam::{DAffine3, Mat3, Mat4, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The vertices of a deformed mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deformed {
    /// One a vertex, as [`TriangleMesh::positions`](crate::scene::mesh::TriangleMesh::positions).
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one a vertex.
    pub normals: Vec<[f32; 3]>,
}

/// By how much one vertex moves and its normal turns at the weight 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delta {
    /// The number of the vertex.
    pub vertex: u32,
    /// Change of its position.
    pub position: [f32; 3],
    /// Change of its normal.
    pub normal: [f32; 3],
}

/// How a mesh deforms: morph targets first, then joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deform {
    /// Vertices before it.
    pub positions: Vec<[f32; 3]>,
    /// Normals before it.
    pub normals: Vec<[f32; 3]>,
    /// Vertices whose triangles, three vertices each, are flat, and whether the front of these is
    /// where their corners go clockwise.
    pub flat: Vec<(Range<usize>, bool)>,
    /// Each joint's node, if it has one, and the map of the mesh into its frame.
    pub joints: Vec<(Option<usize>, Mat4)>,
    /// Joints with weights that sum to 1, of each vertex in turn; empty without a skin.
    pub influences: Vec<(u32, f32)>,
    /// Where the influences of each vertex end.
    pub ends: Vec<u32>,
    /// The vertices that each morph target moves.
    pub targets: Vec<Vec<Delta>>,
    /// Weights of the targets while no clip changes them.
    pub weights: Vec<f32>,
    /// The node whose clips change the weights.
    pub weighed_by: Option<usize>,
}

/// Vertices that one thread deforms at a time.
const CHUNK: usize = 2048;

impl Deform {
    /// Writes the vertices for nodes that stand at `maps` and for weights of targets.
    pub(super) fn apply(&self, maps: &[DAffine3], weights: &[f32], deformed: &mut Deformed) {
        let Deformed { positions, normals } = deformed;
        positions.clone_from(&self.positions);
        normals.clone_from(&self.normals);
        morph(&self.targets, weights, positions, normals);
        let joints = self.joints.iter().map(|(node, bound)| {
            let map = node.map_or(DAffine3::IDENTITY, |node| maps[node]);
            glam::DMat4::from(map).as_mat4() * *bound
        });
        let joints: Vec<Mat4> = joints.collect();
        let chunks = positions.par_chunks_mut(CHUNK);
        let chunks = chunks.zip(normals.par_chunks_mut(CHUNK)).enumerate();
        chunks.for_each(|(chunk, (positions, normals))| {
            for (own, (position, normal)) in positions.iter_mut().zip(normals).enumerate() {
                let mut turned = Vec3::from_array(*normal);
                if !self.ends.is_empty() {
                    let map = self.skinned(chunk * CHUNK + own, &joints);
                    *position = map.transform_point3(Vec3::from_array(*position)).to_array();
                    turned = normal_matrix(map) * turned;
                }
                *normal = turned.normalize_or(Vec3::Y).to_array();
            }
        });
        for (vertices, is_mirrored) in &self.flat {
            let (corners, _) = positions[vertices.clone()].as_chunks::<3>();
            let (normals, _) = normals[vertices.clone()].as_chunks_mut::<3>();
            for (&[a, b, c], normals) in corners.iter().zip(normals) {
                let front = if *is_mirrored { [a, c, b] } else { [a, b, c] };
                *normals = [flat_normal(front); 3];
            }
        }
    }

    /// Returns the mean of the maps of a vertex's joints by their weights.
    fn skinned(&self, vertex: usize, joints: &[Mat4]) -> Mat4 {
        let first = vertex.checked_sub(1).map_or(0, |before| self.ends[before]);
        let own = &self.influences[first as usize..self.ends[vertex] as usize];
        own.iter().fold(Mat4::ZERO, |sum, &(joint, weight)| {
            sum + joints.get(joint as usize).copied().unwrap_or_default() * weight
        })
    }
}

/// Moves vertices and turns normals, of which there may be none, as morph targets say.
pub(in crate::scene) fn morph(
    targets: &[Vec<Delta>],
    weights: &[f32],
    positions: &mut [[f32; 3]],
    normals: &mut [[f32; 3]],
) {
    for (target, &weight) in targets.iter().zip(weights) {
        for delta in target.iter().filter(|_| weight != 0.0) {
            let vertex = delta.vertex as usize;
            let position = positions.get_mut(vertex).map(|to| (to, delta.position));
            let normal = normals.get_mut(vertex).map(|to| (to, delta.normal));
            for (to, by) in position.into_iter().chain(normal) {
                *to = (Vec3::from_array(*to) + weight * Vec3::from_array(by)).to_array();
            }
        }
    }
}

/// Turns normals as `transform` turns surfaces: its cofactors, which exist
/// also where its inverse does not, without the sign of a reflection.
pub(in crate::scene) fn normal_matrix(transform: Mat4) -> Mat3 {
    let m = Mat3::from_mat4(transform);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(
        m.y_axis.cross(m.z_axis) * sign,
        m.z_axis.cross(m.x_axis) * sign,
        m.x_axis.cross(m.y_axis) * sign,
    )
}
