//! The tables of a scene, and the bytes that they become.

use super::BakeError;
use shisen_core::scene::format::{
    ALIGNMENT, Background, Header, IdLeaf, Instance, LeafBlock, Light, MAGIC, Material, Mesh, Node,
    Table, Texel, Texture, Triangle, VERSION, seal,
};
use shisen_core::scene::{EffectSet, Records};
use shisen_core::spectrum::Medium;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Bytes at an address that scenes can be used at.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AlignedBytes {
    blocks: Vec<Block>,
    length: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
struct Block([u8; ALIGNMENT]);

impl AlignedBytes {
    pub(super) fn copy_of(bytes: &[u8]) -> Self {
        let mut blocks = vec![Block([0; ALIGNMENT]); bytes.len().div_ceil(ALIGNMENT)];
        blocks.as_mut_bytes()[..bytes.len()].copy_from_slice(bytes);
        Self {
            blocks,
            length: bytes.len(),
        }
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.blocks.as_bytes()[..self.length]
    }
}

#[derive(Default)]
pub(super) struct Tables<const W: usize> {
    pub(super) top_nodes: u32,
    pub(super) extent: f32,
    pub(super) stack_entries: u32,
    pub(super) nodes: Vec<Node<W>>,
    pub(super) leaves: Vec<LeafBlock<W>>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) instances: Vec<Instance>,
    pub(super) materials: Vec<Material>,
    pub(super) lights: Vec<Light>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) id_leaves: Vec<IdLeaf>,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) coordinates: Vec<[f32; 2]>,
    pub(super) textures: Vec<Texture>,
    pub(super) texels: Vec<Texel>,
    pub(super) media: Vec<Medium>,
    pub(super) colours: Vec<[f32; 3]>,
    pub(super) rungs: u32,
    pub(super) ambient: [f32; 3],
}

impl<const W: usize> Tables<W> {
    pub(super) fn into_bytes(self, background: Background) -> Result<AlignedBytes, BakeError> {
        let mut bytes = vec![0; size_of::<Header>()];
        // Nodes and leaves are generic in width: their fields are arrays of
        // words, written one by one.
        let nodes = append(&mut bytes, self.nodes.len(), |bytes| {
            for node in &self.nodes {
                bytes.extend_from_slice(node.planes.as_bytes());
                bytes.extend_from_slice(node.child.as_bytes());
                bytes.extend_from_slice(node.order.as_bytes());
            }
        });
        let leaves = append(&mut bytes, self.leaves.len(), |bytes| {
            for leaf in &self.leaves {
                bytes.extend_from_slice(leaf.corners.as_bytes());
                bytes.extend_from_slice(leaf.ids.as_bytes());
            }
        });
        // The fields are in the order of the tables.
        let mut header = Header {
            magic: MAGIC,
            checksum: 0,
            version: VERSION,
            width: W as u32,
            byte_len: 0,
            root: 0,
            extent: self.extent,
            stack_entries: self.stack_entries,
            top_nodes: self.top_nodes,
            nodes,
            leaves,
            meshes: append_records(&mut bytes, &self.meshes),
            instances: append_records(&mut bytes, &self.instances),
            materials: append_records(&mut bytes, &self.materials),
            lights: append_records(&mut bytes, &self.lights),
            triangles: append_records(&mut bytes, &self.triangles),
            normals: append_records(&mut bytes, &self.normals),
            background,
            ambient: self.ambient,
            id_leaves: append_records(&mut bytes, &self.id_leaves),
            positions: append_records(&mut bytes, &self.positions),
            rungs: self.rungs,
            effects: EffectSet::of_records(&Records {
                instances: &self.instances,
                meshes: &self.meshes,
                triangles: &self.triangles,
                materials: &self.materials,
                lights: &self.lights,
            })
            .bits(),
            reserved: 0,
            coordinates: append_records(&mut bytes, &self.coordinates),
            textures: append_records(&mut bytes, &self.textures),
            texels: append_records(&mut bytes, &self.texels),
            media: append_records(&mut bytes, &self.media),
            colours: append_records(&mut bytes, &self.colours),
            reserved2: [0; 6],
        };
        header.byte_len = u32::try_from(bytes.len()).map_err(|_| BakeError::TooLarge {
            bytes: bytes.len() as u64,
        })?;
        bytes[..size_of::<Header>()].copy_from_slice(header.as_bytes());
        seal(&mut bytes);
        Ok(AlignedBytes::copy_of(&bytes))
    }
}

fn append(bytes: &mut Vec<u8>, count: usize, write: impl FnOnce(&mut Vec<u8>)) -> Table {
    bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
    let offset = bytes.len();
    write(bytes);
    // Saturated values cannot reach a header: the length is checked first.
    Table {
        offset: u32::try_from(offset).unwrap_or(u32::MAX),
        count: u32::try_from(count).unwrap_or(u32::MAX),
    }
}

fn append_records<T: IntoBytes + Immutable>(bytes: &mut Vec<u8>, records: &[T]) -> Table {
    append(bytes, records.len(), |bytes| {
        bytes.extend_from_slice(records.as_bytes());
    })
}
