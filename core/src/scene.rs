//! A read-only scene over one aligned blob of bytes: flash, file or array.
//!
//! [`Scene::from_bytes`] checks the blob once; what it returns borrows the
//! bytes for ever after. After it returns `Ok`, tracing cannot panic, read
//! out of range or loop without end, whatever the bytes were: every index is
//! in its table, every tree is a tree and fits the traversal stack.

mod effects;
mod error;
pub mod format;
mod pose;
mod validate;

use crate::spectrum::Medium;
use crate::{Runs, Simd};
pub use effects::{EffectSet, Records};
pub use error::SceneError;
use format::{
    Background, Header, IdLeaf, Instance, LeafBlock, Light, Material, Mesh, Node, Texel, Texture,
    Triangle,
};
pub use pose::{Deformed, PoseError, Poses, Tables};

/// Children of nodes that wait at once while a ray goes through the deepest trees that
/// there may be: scenes that could need more are refused when they are loaded.
pub const STACK_ENTRIES: usize = 128;

/// A checked scene, whose nodes and leaves are `W` wide: 8 in the fast layout for hosts, 4 in the
/// compact one for microcontrollers. Both give the same pictures.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a, const W: usize = 8> {
    pub(crate) header: &'a Header,
    /// The tree over instances: the first nodes, or those of poses.
    pub(crate) top: &'a [Node<W>],
    /// Largest magnitude of a coordinate of an instance's box: metres.
    pub(crate) extent: f32,
    pub(crate) nodes: &'a [Node<W>],
    pub(crate) leaves: &'a [LeafBlock<W>],
    pub(crate) meshes: &'a [Mesh],
    pub(crate) instances: &'a [Instance],
    pub(crate) materials: &'a [Material],
    pub(crate) lights: &'a [Light],
    pub(crate) triangles: &'a [Triangle],
    pub(crate) normals: &'a [[f32; 3]],
    pub(crate) id_leaves: &'a [IdLeaf],
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) coordinates: &'a [[f32; 2]],
    pub(crate) textures: &'a [Texture],
    pub(crate) texels: &'a [Texel],
    pub(crate) media: &'a [Medium],
    pub(crate) colours: &'a [[f32; 3]],
    pub(crate) tangents: &'a [[f32; 4]],
}

/// A scene in the fast layout.
pub type FastScene<'a> = Scene<'a, 8>;

/// A scene in the compact layout.
pub type CompactScene<'a> = Scene<'a, 4>;

impl<'a, const W: usize> Scene<'a, W> {
    /// Checks a baked scene and borrows it. Bytes past the scene's own
    /// length are ignored, so a flash region may be passed whole.
    ///
    /// # Errors
    /// [`SceneError`] says what is wrong and at which byte or record.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, SceneError>
    where
        Simd: Runs<W>,
    {
        <Simd as Runs<W>>::checked(bytes)
    }

    pub(crate) fn checked(bytes: &'a [u8]) -> Result<Self, SceneError> {
        let (header, own) = validate::header::<W>(bytes)?;
        let nodes: &[Node<W>] = validate::table(own, header.nodes, "nodes")?;
        let scene = Self {
            header,
            top: nodes.get(..header.top_nodes as usize).unwrap_or_default(),
            extent: header.extent,
            nodes,
            leaves: validate::table(own, header.leaves, "leaves")?,
            meshes: validate::table(own, header.meshes, "meshes")?,
            instances: validate::table(own, header.instances, "instances")?,
            materials: validate::table(own, header.materials, "materials")?,
            lights: validate::table(own, header.lights, "lights")?,
            triangles: validate::table(own, header.triangles, "triangles")?,
            normals: validate::table(own, header.normals, "normals")?,
            id_leaves: validate::table(own, header.id_leaves, "leaves of numbers")?,
            positions: validate::table(own, header.positions, "positions")?,
            coordinates: validate::table(own, header.coordinates, "coordinates")?,
            textures: validate::table(own, header.textures, "textures")?,
            texels: validate::table(own, header.texels, "texels")?,
            media: validate::table(own, header.media, "media")?,
            colours: validate::table(own, header.colours, "colours")?,
            tangents: validate::table(own, header.tangents, "tangents")?,
        };
        validate::contents(&scene)?;
        Ok(scene)
    }

    /// Returns what a ray sees that meets nothing.
    pub const fn background(&self) -> &'a Background {
        &self.header.background
    }

    /// Returns the placed shapes.
    pub const fn instances(&self) -> &'a [Instance] {
        self.instances
    }

    /// Returns the meshes that instances place.
    pub const fn meshes(&self) -> &'a [Mesh] {
        self.meshes
    }

    /// Returns meshes of a ladder of polygon levels, the full one included; 1 where
    /// the scene was baked without.
    pub const fn rungs(&self) -> u8 {
        self.header.rungs as u8
    }

    /// Returns a mesh as rays of a rung see it: itself where it has no such rung.
    #[inline(always)]
    pub(crate) fn mesh_at(&self, geometry: u32, rung: u8) -> Option<&'a Mesh> {
        let full = self.meshes.get(geometry as usize)?;
        let rung = u32::from(rung);
        if rung == 0 || rung >= full.rungs {
            return Some(full);
        }
        self.meshes.get(geometry.checked_add(rung)? as usize)
    }

    /// Returns the materials.
    pub const fn materials(&self) -> &'a [Material] {
        self.materials
    }

    /// Returns what transparent materials are made of.
    pub const fn media(&self) -> &'a [Medium] {
        self.media
    }

    /// Returns the lights.
    pub const fn lights(&self) -> &'a [Light] {
        self.lights
    }

    /// Returns the effects that it asks for.
    pub const fn effects(&self) -> EffectSet {
        EffectSet::from_bits_truncate(self.header.effects)
    }

    /// Returns what it asks them by.
    pub const fn records(&self) -> Records<'a> {
        Records {
            instances: self.instances,
            meshes: self.meshes,
            triangles: self.triangles,
            materials: self.materials,
            lights: self.lights,
            background: &self.header.background,
        }
    }

    /// Counts of nodes, leaves and triangles, all meshes together.
    pub const fn sizes(&self) -> (usize, usize, usize) {
        // One of the two kinds of leaves is empty.
        let leaves = self.leaves.len() + self.id_leaves.len();
        (self.nodes.len(), leaves, self.triangles.len())
    }

    /// Returns how many vertices the meshes have, all together.
    pub const fn vertices(&self) -> usize {
        self.normals.len()
    }

    /// Returns how many tangents the vertices of meshes with normal maps have, all together.
    pub const fn tangents(&self) -> usize {
        self.tangents.len()
    }

    /// Returns bytes that the scene takes.
    pub const fn byte_len(&self) -> u32 {
        self.header.byte_len
    }

    /// Returns the most entries of the traversal stack that any ray can use.
    pub const fn stack_entries(&self) -> u32 {
        self.header.stack_entries
    }
}
