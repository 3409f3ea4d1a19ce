//! Boxes in the room around all parts of an instance that rays can meet.

use super::tree::{self, Bounds, WideTree};
use crate::scene::mesh::TriangleMesh;
use glam::{DAffine3, DVec3};
use obvhs::BvhBuildParams;
use shisen_core::scene::format::{COVER_NODES, LEAF, Node};

const DEPTH: usize = 3;

/// The top of a tree over a mesh, parents before children, the root first.
pub(super) struct Cover<const W: usize> {
    /// Children are numbered from 0, nodes and leaves each by themselves.
    nodes: Vec<Node<W>>,
    leaves: Vec<Vec<u32>>,
}

impl<const W: usize> Cover<W> {
    /// Makes the cover of a mesh that has no tree over all of its triangles.
    pub(super) fn new(mesh: &TriangleMesh) -> Self {
        let triangles = 0..mesh.triangles.len();
        let boxes: Vec<Bounds> = triangles.map(|t| Bounds::of_triangle(mesh, t)).collect();
        Self::of(
            &tree::build_with(&boxes, 1, BvhBuildParams::fast_build()),
            mesh,
        )
    }

    /// Returns the top of a tree over all triangles of a mesh.
    pub(super) fn of(tree: &WideTree<W>, mesh: &TriangleMesh) -> Self {
        let mut cover = Self {
            nodes: vec![tree.nodes[0]],
            leaves: Vec::new(),
        };
        let mut level = 0..1;
        for depth in 1..=DEPTH {
            let next = cover.nodes.len();
            for number in level {
                for lane in 0..W {
                    if cover.nodes[number].is_empty_lane(lane) {
                        continue;
                    }
                    let child = cover.nodes[number].child[lane];
                    cover.nodes[number].child[lane] = if depth == DEPTH || child & LEAF != 0 {
                        let triangles = tree.primitives(child);
                        let corners = triangles.flat_map(|t| mesh.triangles[t as usize]);
                        let mut vertices: Vec<u32> = corners.collect();
                        vertices.sort_unstable();
                        vertices.dedup();
                        cover.leaves.push(vertices);
                        LEAF | (cover.leaves.len() - 1) as u32
                    } else {
                        cover.nodes.push(tree.nodes[child as usize]);
                        (cover.nodes.len() - 1) as u32
                    };
                }
            }
            level = next..cover.nodes.len();
        }
        debug_assert!(cover.nodes.len() <= COVER_NODES as usize);
        cover
    }

    /// Returns the cover in the room, with every box `slack` metres larger on all sides than its
    /// contents.
    pub(super) fn placed(
        &self,
        positions: &[[f32; 3]],
        world_from_object: &DAffine3,
        slack: f64,
    ) -> Vec<Node<W>> {
        let place = |vertex: &u32| {
            let position = positions[*vertex as usize].map(f64::from);
            world_from_object.transform_point3(DVec3::from(position))
        };
        let leaves: Vec<Bounds> = self
            .leaves
            .iter()
            .map(|vertices| Bounds::around(vertices.iter().map(place), slack))
            .collect();
        let mut nodes = self.nodes.clone();
        let mut bounds = vec![Bounds::EMPTY; nodes.len()];
        for number in (0..nodes.len()).rev() {
            let node = &mut nodes[number];
            for lane in (0..W).filter(|&lane| !self.nodes[number].is_empty_lane(lane)) {
                let child = node.child[lane];
                let of_child = if child & LEAF == 0 {
                    bounds[child as usize]
                } else {
                    leaves[(child & !LEAF) as usize]
                };
                node.set_bounds(lane, of_child.low, of_child.high);
                bounds[number] = bounds[number].union(of_child);
            }
            node.set_order();
        }
        nodes
    }
}
