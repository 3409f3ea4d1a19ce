//! Instances that move and meshes that deform: the parts of a scene that this changes are in the
//! caller's memory, and its trees are refitted there.
//!
//! [`Poses::scene`] is traced like any other scene. Its hits are those of a scene that is baked at
//! the same poses.

mod deform;
mod tree;

use super::Scene;
use super::format::{INDEX, Instance, Node, kind};
use crate::shape::Ray;
use deform::Taken;
pub use deform::{Deformed, Tables};
use glam::{DAffine3, DMat3, DVec3};
use thiserror::Error;
use tree::{Bounds, refit};

/// Rounding of a map into an instance's frame and back, in units of the largest number involved.
const MAP_SLACK: f64 = 64.0 * 5.960_464_477_539_063e-8;

/// Why a pose is not taken. The scene is as it was before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum PoseError {
    #[error("the memory for {what} has {found} places, and the scene needs {needed}")]
    Memory {
        what: &'static str,
        found: usize,
        needed: usize,
    },
    #[error("there is no instance {instance} (counted from 0)")]
    NoInstance { instance: usize },
    #[error(
        "instance {instance} (counted from 0) is placed by a map that cannot be undone, or beyond \
         1e12 m"
    )]
    Transform { instance: usize },
    #[error("there is no mesh {mesh} (counted from 0) without polygon levels")]
    NoMesh { mesh: usize },
    #[error("mesh {mesh} (counted from 0) is deformed by {found} vertices, and has {needed}")]
    Vertices {
        mesh: usize,
        found: usize,
        needed: usize,
    },
    #[error(
        "vertex {vertex} of mesh {mesh} (both counted from 0) lies farther than 1e12 m from the origin or is not a number"
    )]
    Vertex { mesh: usize, vertex: usize },
    #[error("the new tree of mesh {mesh} (counted from 0) is no tree over its triangles")]
    NotATree { mesh: usize },
}

/// A scene whose instances can be moved. The caller owns the memory; nothing is allocated.
#[derive(Debug)]
pub struct Poses<'s, 'm, const W: usize = 8> {
    scene: Scene<'s, W>,
    top: &'m mut [Node<W>],
    instances: &'m mut [Instance],
    extent: f32,
    tables: Option<Taken<'m, W>>,
}

impl<'s, 'm, const W: usize> Poses<'s, 'm, W> {
    /// Returns a scene's instances where the scene has them. `top` needs
    /// [`top_nodes`](Scene::top_nodes) places, `instances` as many as there are
    /// [instances](Scene::instances); further places are not used.
    ///
    /// # Errors
    /// [`PoseError::Memory`].
    pub fn new(
        scene: Scene<'s, W>,
        top: &'m mut [Node<W>],
        instances: &'m mut [Instance],
    ) -> Result<Self, PoseError> {
        Ok(Self {
            top: copied("nodes", scene.top, top)?,
            instances: copied("instances", scene.instances, instances)?,
            extent: scene.extent,
            scene,
            tables: None,
        })
    }

    /// Places an instance. [`refit`](Self::refit) follows after all instances are placed. The
    /// instance is traced without its cover.
    ///
    /// # Errors
    /// An instance that the scene does not have; a map that cannot be undone or leads too far.
    pub fn set(&mut self, instance: usize, world_from_object: &DAffine3) -> Result<(), PoseError> {
        let found = self.instances.get(instance);
        let mut moved = *found.ok_or(PoseError::NoInstance { instance })?;
        let local = self.local(&moved);
        let placed = moved.place(world_from_object, local.low, local.high);
        placed.ok_or(PoseError::Transform { instance })?;
        if let Some(place) = self.instances.get_mut(instance) {
            *place = moved;
        }
        Ok(())
    }

    /// Fits the tree over instances to where they are; returns the steps taken: one for each of
    /// its nodes.
    pub fn refit(&mut self) -> u64 {
        let instances = &*self.instances;
        let of_leaf = |child: u32| {
            let instance = instances.get((child & INDEX) as usize);
            instance.map_or(Bounds::EMPTY, |one| Bounds {
                low: one.low,
                high: one.high,
            })
        };
        refit(self.top, 0, of_leaf);
        let root = self.top.get(self.scene.header.root as usize);
        self.extent = root.map_or(0.0, |root| root.bounds().extent());
        self.top.len() as u64
    }

    /// Returns the scene with its instances and meshes as they are now.
    pub fn scene(&self) -> Scene<'_, W> {
        let scene = Scene {
            top: self.top,
            instances: self.instances,
            extent: self.extent,
            ..self.scene
        };
        match &self.tables {
            Some(tables) => tables.scene(&scene),
            None => scene,
        }
    }

    /// Returns the box of an instance's shape in its own frame.
    fn local(&self, instance: &Instance) -> Bounds {
        if instance.kind == kind::SPHEROID {
            let [equatorial, polar] = instance.radii;
            return Bounds {
                low: [-equatorial, -polar, -equatorial],
                high: [equatorial, polar, equatorial],
            };
        }
        let scene = self.scene();
        let mesh = scene.meshes.get(instance.geometry as usize);
        let root = mesh.and_then(|mesh| scene.nodes.get(mesh.root as usize));
        root.map_or(Bounds::EMPTY, Node::bounds)
    }
}

impl<const W: usize> Scene<'_, W> {
    /// Returns the number of nodes of the tree over instances.
    pub const fn top_nodes(&self) -> usize {
        self.top.len()
    }
}

impl Instance {
    /// Places a shape whose box in its own frame is from `low` to `high`: sets the maps, their
    /// condition and the box in the room. Removes its cover. Returns by how many metres that box is
    /// wider than the shape; `None`, and changes nothing, where the map cannot be undone or leads
    /// beyond [`Ray::FARTHEST`].
    pub fn place(
        &mut self,
        world_from_object: &DAffine3,
        low: [f32; 3],
        high: [f32; 3],
    ) -> Option<f64> {
        let map = *world_from_object;
        if !map.is_finite() || !map.matrix3.determinant().is_normal() {
            return None;
        }
        let inverse = map.inverse();
        if !inverse.is_finite() {
            return None;
        }
        // An ill-conditioned map magnifies what rounding does in its other frame.
        let condition = norm(&map.matrix3) * norm(&inverse.matrix3);
        let slack = self.enclose(&map, condition, low, high)?;
        self.condition = condition as f32;
        self.object_from_world = columns(&inverse);
        self.world_from_object = columns(&map);
        Some(slack)
    }

    /// Sets the box in the room; returns its slack, or `None` where it is too far away.
    fn enclose(
        &mut self,
        map: &DAffine3,
        condition: f64,
        low: [f32; 3],
        high: [f32; 3],
    ) -> Option<f64> {
        let [low, high] = [low, high].map(|corner| DVec3::from_array(corner.map(f64::from)));
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for x in [low.x, high.x] {
            for y in [low.y, high.y] {
                for z in [low.z, high.z] {
                    let corner = map.transform_point3(DVec3::new(x, y, z));
                    (least, most) = (least.min(corner), most.max(corner));
                }
            }
        }
        let farthest = least.abs().max(most.abs()).max_element();
        if !(farthest <= f64::from(Ray::FARTHEST)) {
            return None;
        }
        let translation = map.translation.abs().max_element();
        let slack = MAP_SLACK * condition * farthest.max(translation);
        self.low = (least - slack).to_array().map(|c| (c as f32).next_down());
        self.high = (most + slack).to_array().map(|c| (c as f32).next_up());
        (self.cover, self.cover_nodes) = (0, 0);
        Some(slack)
    }
}

/// Copies records into memory that may have further places; returns the places taken.
fn copied<'m, T: Copy>(
    what: &'static str,
    from: &[T],
    to: &'m mut [T],
) -> Result<&'m mut [T], PoseError> {
    let found = to.len();
    let memory = PoseError::Memory {
        what,
        found,
        needed: from.len(),
    };
    let places = to.get_mut(..from.len()).ok_or(memory)?;
    for (place, record) in places.iter_mut().zip(from) {
        *place = *record;
    }
    Ok(places)
}

fn norm(matrix: &DMat3) -> f64 {
    let squares = matrix.to_cols_array().map(|c| c * c);
    libm::sqrt(squares.iter().sum())
}

fn columns(map: &DAffine3) -> [[f32; 3]; 4] {
    map.to_cols_array_2d()
        .map(|column| column.map(|c| c as f32))
}

/// Returns the map of which an instance has the columns.
fn map_of(instance: &Instance) -> DAffine3 {
    let columns = instance.world_from_object;
    DAffine3::from_cols_array_2d(&columns.map(|column| column.map(f64::from)))
}
