//! Meshes whose vertices move.

use super::tree::{Bounds, refit};
use super::{PoseError, Poses, copied, map_of};
use crate::numeric::normalize;
use crate::scene::Scene;
use crate::scene::format::{INDEX, Instance, LEAF, LeafBlock, Mesh, Node, Triangle, kind};
use crate::scene::validate::can_replace;
use crate::shape::Ray;
use glam::Vec3;

/// The memory for the tables of meshes that deform: each has at least as many places as the scene's
/// own table. [`Poses::replant`] puts trees into further ones.
#[derive(Debug)]
pub struct Tables<'m, const W: usize = 8> {
    /// As many as [`Scene::sizes`] says.
    pub nodes: &'m mut [Node<W>],
    /// As many as [`Scene::sizes`] says in the fast layout; none in the compact one.
    pub leaves: &'m mut [LeafBlock<W>],
    /// Normals, one for each of the [vertices](Scene::vertices).
    pub normals: &'m mut [[f32; 3]],
    /// As many as there are [tangents](Scene::tangents).
    pub tangents: &'m mut [[f32; 4]],
    /// Positions of the vertices in the compact layout; none in the fast one.
    pub positions: &'m mut [[f32; 3]],
    /// As many as there are [meshes](Scene::meshes).
    pub meshes: &'m mut [Mesh],
}

/// How a mesh was deformed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deformed {
    /// Steps taken: one for each node of its tree and for each triangle.
    pub steps: u64,
    /// The cost of its tree: half areas of all boxes, relative to the whole one's. Where this has
    /// grown, a [new tree](Poses::replant) would be faster to trace.
    pub cost: f32,
}

/// The tables, and how much of them is taken.
#[derive(Debug)]
pub(super) struct Taken<'m, const W: usize> {
    tables: Tables<'m, W>,
    nodes: usize,
    leaves: usize,
}

impl<'m, const W: usize> Poses<'_, 'm, W> {
    /// Returns the same poses, with meshes that can be deformed.
    ///
    /// # Errors
    /// [`PoseError::Memory`].
    pub fn with_tables(mut self, tables: Tables<'m, W>) -> Result<Self, PoseError> {
        let scene = &self.scene;
        let Tables {
            nodes,
            leaves,
            normals,
            tangents,
            positions,
            meshes,
        } = tables;
        copied("nodes", scene.nodes, nodes)?;
        copied("leaves", scene.leaves, leaves)?;
        self.tables = Some(Taken {
            nodes: scene.nodes.len(),
            leaves: scene.leaves.len(),
            tables: Tables {
                nodes,
                leaves,
                normals: copied("normals", scene.normals, normals)?,
                tangents: copied("tangents", scene.tangents, tangents)?,
                positions: copied("positions", scene.positions, positions)?,
                meshes: copied("meshes", scene.meshes, meshes)?,
            },
        });
        Ok(self)
    }

    /// Gives the vertices of a mesh new positions, in its own frame, and normals; fits its tree and
    /// the boxes of its instances, which lose their covers. Its tangents turn as little as the
    /// normals ask for. [`refit`](Self::refit) follows after all meshes and instances are as they
    /// should be.
    ///
    /// # Errors
    /// A mesh that the scene does not have, or that has polygon levels; another number of vertices
    /// than it has; numbers beyond [`Ray::FARTHEST`].
    pub fn deform(
        &mut self,
        mesh: usize,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<Deformed, PoseError> {
        let record = self.plain_mesh(mesh)?;
        let needed = record.normal_count as usize;
        for found in [positions.len(), normals.len()] {
            if found != needed {
                return Err(PoseError::Vertices {
                    mesh,
                    found,
                    needed,
                });
            }
        }
        let mut bounds = Bounds::EMPTY;
        for (vertex, (position, normal)) in positions.iter().zip(normals).enumerate() {
            let numbers = position.iter().chain(normal);
            if !numbers.copied().all(|n| n.abs() <= Ray::FARTHEST) {
                return Err(PoseError::Vertex { mesh, vertex });
            }
            bounds = bounds.with(*position);
        }
        let instances = self.instances.iter();
        for (instance, placed) in instances.enumerate().filter(|(_, one)| shows(one, mesh)) {
            let fits = enclosed(placed, bounds).is_some();
            fits.then_some(())
                .ok_or(PoseError::Transform { instance })?;
        }
        for placed in self.instances.iter_mut().filter(|one| shows(one, mesh)) {
            *placed = enclosed(placed, bounds).unwrap_or(*placed);
        }
        let deformed = self.reshape(mesh, &record, positions, normals);
        deformed.ok_or(PoseError::NoMesh { mesh })
    }

    /// Writes what [`deform`](Self::deform) has checked.
    fn reshape(
        &mut self,
        mesh: usize,
        record: &Mesh,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Option<Deformed> {
        let scene = &self.scene;
        let tables = &mut self.tables.as_mut()?.tables;
        let vertices = record.first_normal as usize..;
        for (place, normal) in tables
            .normals
            .get_mut(vertices.clone())?
            .iter_mut()
            .zip(normals)
        {
            *place = *normal;
        }
        let tangents = scene.tangents.get(record.first_tangent as usize..);
        let places = tables.tangents.get_mut(record.first_tangent as usize..);
        let before = scene.normals.get(record.first_normal as usize..);
        let before = before.unwrap_or_default().iter().zip(normals);
        let of_vertices = tangents.unwrap_or_default().iter().zip(before);
        for (place, (tangent, (before, now))) in
            places.unwrap_or_default().iter_mut().zip(of_vertices)
        {
            *place = turned(*tangent, *before, *now);
        }
        // The fast layout has none.
        let places = tables.positions.get_mut(vertices).unwrap_or_default();
        for (place, position) in places.iter_mut().zip(positions) {
            *place = position.map(positive_zero);
        }
        let triangles = scene.triangles.get(record.first_triangle as usize..)?;
        let triangles = triangles.get(..record.triangle_count as usize)?;
        let (first, count) = (record.first_node as usize, record.node_count as usize);
        let nodes = tables.nodes.get_mut(first..)?.get_mut(..count)?;
        let areas = refit(nodes, record.first_node, |child| {
            let leaf = (child & INDEX) as usize;
            if let Some(block) = tables.leaves.get_mut(leaf) {
                return block.reshape(triangles, positions);
            }
            let ids = scene.id_leaves.get(leaf).into_iter().flatten();
            let corners = ids.filter_map(|&id| corners(triangles, positions, id));
            corners.flatten().fold(Bounds::EMPTY, Bounds::with)
        });
        let root = tables.nodes.get(record.root as usize)?.bounds();
        let place = tables.meshes.get_mut(mesh)?;
        place.extent = root.extent();
        let whole = root.half_area();
        Some(Deformed {
            steps: u64::from(record.node_count) + u64::from(record.faces),
            cost: if whole > 0.0 { areas / whole } else { 0.0 },
        })
    }

    /// Gives a mesh another tree, of the fast layout, whose root is its first node and whose children
    /// are numbered from 0; [`deform`](Self::deform) follows, and puts corners into its leaves. The
    /// tree takes the place of the one before, or free places of the tables.
    ///
    /// # Errors
    /// A mesh that the scene does not have, or that has polygon levels; too little memory; nodes or
    /// leaves that are no tree over the mesh, or too deep a one.
    pub fn replant(
        &mut self,
        mesh: usize,
        nodes: &[Node<W>],
        leaves: &[LeafBlock<W>],
    ) -> Result<(), PoseError> {
        let mut record = self.plain_mesh(mesh)?;
        if !can_replace(&self.scene, &record, nodes, leaves) {
            return Err(PoseError::NotATree { mesh });
        }
        let Some(taken) = &mut self.tables else {
            return Err(PoseError::NoMesh { mesh });
        };
        let is_new =
            nodes.len() > record.node_count as usize || leaves.len() > record.leaf_count as usize;
        if is_new {
            record.first_node = taken.nodes as u32;
            record.first_leaf = taken.leaves as u32;
            record.node_count = nodes.len() as u32;
            record.leaf_count = leaves.len() as u32;
        }
        record.root = record.first_node;
        let Tables {
            nodes: all_nodes,
            leaves: all_leaves,
            meshes,
            ..
        } = &mut taken.tables;
        let memory = |what, found, first: u32, count: usize| PoseError::Memory {
            what,
            found,
            needed: first as usize + count,
        };
        let (first, found) = (record.first_node, all_nodes.len());
        let from = all_nodes.get_mut(first as usize..);
        let places = from.and_then(|from| from.get_mut(..nodes.len()));
        let node_places = places.ok_or(memory("nodes", found, first, nodes.len()))?;
        let (first, found) = (record.first_leaf, all_leaves.len());
        let from = all_leaves.get_mut(first as usize..);
        let places = from.and_then(|from| from.get_mut(..leaves.len()));
        let leaf_places = places.ok_or(memory("leaves", found, first, leaves.len()))?;
        for (place, node) in node_places.iter_mut().zip(nodes) {
            *place = node.moved(record.first_node, record.first_leaf);
        }
        for (place, leaf) in leaf_places.iter_mut().zip(leaves) {
            *place = *leaf;
        }
        if is_new {
            taken.nodes += nodes.len();
            taken.leaves += leaves.len();
        }
        if let Some(place) = meshes.get_mut(mesh) {
            *place = record;
        }
        Ok(())
    }

    /// Returns a mesh that has no polygon levels.
    fn plain_mesh(&self, mesh: usize) -> Result<Mesh, PoseError> {
        let taken = self.tables.as_ref();
        let meshes = taken.map_or(&[][..], |taken| &*taken.tables.meshes);
        let before = mesh.checked_sub(1).and_then(|before| meshes.get(before));
        let is_last_level = before.is_some_and(|before| before.rungs > 1);
        let found = meshes.get(mesh);
        let found = found.filter(|found| found.rungs == 1 && !is_last_level);
        found.copied().ok_or(PoseError::NoMesh { mesh })
    }
}

impl<const W: usize> Taken<'_, W> {
    /// Returns a scene with these tables.
    pub(super) fn scene<'t>(&'t self, scene: &Scene<'t, W>) -> Scene<'t, W> {
        let tables = &self.tables;
        Scene {
            nodes: tables.nodes,
            leaves: tables.leaves,
            normals: tables.normals,
            tangents: tables.tangents,
            positions: tables.positions,
            meshes: tables.meshes,
            ..*scene
        }
    }
}

impl<const W: usize> Node<W> {
    /// Returns the node of a tree whose first node and leaf have these numbers instead of 0.
    #[must_use]
    pub fn moved(mut self, first_node: u32, first_leaf: u32) -> Self {
        for lane in 0..W {
            let is_used = !self.is_empty_lane(lane);
            let child = &mut self.child[lane % W];
            if *child & LEAF != 0 {
                *child = child.wrapping_add(first_leaf);
            } else if is_used {
                *child = child.wrapping_add(first_node);
            }
        }
        self
    }
}

impl<const W: usize> LeafBlock<W> {
    /// Takes the corners of its triangles; returns the box around them.
    fn reshape(&mut self, triangles: &[Triangle], positions: &[[f32; 3]]) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for lane in 0..W {
            let Some(corners) = corners(triangles, positions, self.ids[lane % W]) else {
                continue;
            };
            for (places, corner) in self.corners.iter_mut().zip(corners) {
                for (place, coordinate) in places.iter_mut().zip(corner) {
                    place[lane % W] = positive_zero(coordinate);
                }
                bounds = bounds.with(corner);
            }
        }
        bounds
    }
}

/// Returns the corners of a triangle; `None` for an empty lane.
fn corners(triangles: &[Triangle], positions: &[[f32; 3]], id: u32) -> Option<[[f32; 3]; 3]> {
    let [a, b, c] = triangles.get(id as usize)?.corners;
    let position = |vertex: u32| positions.get(vertex as usize).copied();
    Some([position(a)?, position(b)?, position(c)?])
}

fn shows(instance: &Instance, mesh: usize) -> bool {
    instance.kind == kind::MESH && instance.geometry as usize == mesh
}

/// Returns an instance with the box of a shape whose own box has changed.
fn enclosed(instance: &Instance, bounds: Bounds) -> Option<Instance> {
    let mut enclosed = *instance;
    let condition = f64::from(instance.condition);
    enclosed.enclose(&map_of(instance), condition, bounds.low, bounds.high)?;
    Some(enclosed)
}

/// Returns a tangent after the smallest turn that brings a normal from where it was to where it is.
fn turned([x, y, z, side]: [f32; 4], before: [f32; 3], now: [f32; 3]) -> [f32; 4] {
    let (tangent, before, now) = (Vec3::new(x, y, z), before.into(), Vec3::from_array(now));
    let axis = Vec3::cross(before, now);
    let cosine = before.dot(now);
    let once = axis.cross(tangent);
    let turned = tangent + once + axis.cross(once) / (1.0 + cosine);
    // Opposite normals say of no turn that it is the smallest.
    let turned = if cosine > -0.99 {
        normalize(turned)
    } else {
        None
    };
    turned.unwrap_or(tangent).extend(side).to_array()
}

/// Leaves no −0 behind, so that equal vertices have equal bits.
fn positive_zero(coordinate: f32) -> f32 {
    coordinate + 0.0
}
