//! The triangles that a mesh's leaves hold, in either layout.

use crate::numeric::map3;
use crate::scene::Scene;
use crate::scene::format::{self, IdLeaf, LeafBlock, Mesh, Node};
use crate::shape::Triangle;
use glam::Vec3;

/// A mesh of a scene, with what tracing it needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshView<'a, const W: usize> {
    pub(crate) nodes: &'a [Node<W>],
    pub(crate) leaves: Leaves<'a, W>,
    pub(crate) root: u32,
    pub(crate) extent: f32,
}

impl<'a, const W: usize> MeshView<'a, W> {
    #[inline(always)]
    pub(crate) fn new(scene: &Scene<'a, W>, mesh: &Mesh) -> Self {
        Self {
            nodes: scene.nodes,
            leaves: Leaves::new(scene, mesh),
            root: mesh.root,
            extent: mesh.extent,
        }
    }
}

/// The leaves of a mesh: corners in 8-wide trees, triangle numbers in 4-wide ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaves<'a, const W: usize> {
    blocks: &'a [LeafBlock<W>],
    numbers: &'a [IdLeaf],
    triangles: &'a [format::Triangle],
    positions: &'a [[f32; 3]],
}

impl<'a, const W: usize> Leaves<'a, W> {
    #[inline(always)]
    pub(crate) fn new(scene: &Scene<'a, W>, mesh: &Mesh) -> Self {
        Self {
            blocks: scene.leaves,
            numbers: scene.id_leaves,
            triangles: part(scene.triangles, mesh.first_triangle, mesh.triangle_count),
            positions: part(scene.positions, mesh.first_normal, mesh.normal_count),
        }
    }

    /// Returns a leaf that holds corners.
    #[inline(always)]
    pub(crate) fn block(&self, leaf: u32) -> Option<&'a LeafBlock<W>> {
        self.blocks.get(leaf as usize)
    }

    /// Returns a leaf of either kind.
    #[inline(always)]
    pub(crate) fn leaf(&self, leaf: u32) -> Option<Leaf<'a, W>> {
        let block = self.block(leaf);
        let ids = if W == 8 {
            &block?.ids
        } else {
            self.numbers.get(leaf as usize)?.first_chunk()?
        };
        Some(Leaf {
            leaves: *self,
            block,
            ids,
        })
    }

    /// Returns the corners of a triangle of a leaf that holds numbers; `None` for an empty lane.
    #[inline(always)]
    pub(crate) fn corners(&self, id: u32) -> Option<[&'a [f32; 3]; 3]> {
        let [a, b, c] = self.triangles.get(id as usize)?.corners;
        Some([
            self.positions.get(a as usize)?,
            self.positions.get(b as usize)?,
            self.positions.get(c as usize)?,
        ])
    }
}

/// The triangles of one leaf.
#[derive(Clone, Copy)]
pub(crate) struct Leaf<'a, const W: usize> {
    leaves: Leaves<'a, W>,
    block: Option<&'a LeafBlock<W>>,
    /// Their numbers; `u32::MAX` where empty.
    pub(crate) ids: &'a [u32; W],
}

impl<const W: usize> Leaf<'_, W> {
    /// Returns the triangle in a lane, which is taken modulo the width.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: u32) -> Option<Triangle> {
        if W == 8 {
            Some(self.block?.triangle(lane))
        } else {
            let id = self.ids[lane as usize & (W - 1)];
            let corners = self.leaves.corners(id)?;
            Some(Triangle(map3(corners, |&c| Vec3::from_array(c))))
        }
    }
}

impl<const W: usize> LeafBlock<W> {
    /// Returns the triangle in a lane, which is taken modulo the width.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: u32) -> Triangle {
        let lane = lane as usize & (W - 1);
        Triangle(map3([0, 1, 2], |corner| {
            let [x, y, z] = &self.corners[corner];
            Vec3::new(x[lane], y[lane], z[lane])
        }))
    }
}

/// Returns `count` records from `first` on; an empty slice if there are fewer.
#[inline(always)]
fn part<T>(records: &[T], first: u32, count: u32) -> &[T] {
    records
        .get(first as usize..)
        .and_then(|rest| rest.get(..count as usize))
        .unwrap_or_default()
}
