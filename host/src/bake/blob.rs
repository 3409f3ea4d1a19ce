//! The tables of a scene, and the bytes that they become.

use super::BakeError;
use super::simplify::Ladder;
use super::tree::Leaves;
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::Image;
use shisen_core::scene::format::{
    ALIGNMENT, Background, Header, IdLeaf, Instance, LeafBlock, Light, MAGIC, Material, Mesh, Node,
    Table, Texel, Texture, Triangle, VERSION, seal,
};
use shisen_core::scene::{EffectSet, Records};
use shisen_core::spectrum::Medium;
use std::io::{self, Read};
use std::mem::take;
use std::sync::Arc;
use zerocopy::{FromBytes, FromZeros as _, Immutable, IntoBytes, KnownLayout};

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
    fn zeroed(length: usize) -> Self {
        // Its pages are taken only as they are written.
        let blocks = Block::new_vec_zeroed(length.div_ceil(ALIGNMENT)).expect("enough memory");
        Self { blocks, length }
    }

    pub(super) fn copy_of(bytes: &[u8]) -> Self {
        let mut copy = Self::zeroed(bytes.len());
        copy.as_mut_bytes().copy_from_slice(bytes);
        copy
    }

    fn as_mut_bytes(&mut self) -> &mut [u8] {
        &mut self.blocks.as_mut_bytes()[..self.length]
    }

    pub(super) fn read(from: &mut impl Read, length: usize) -> io::Result<Self> {
        let mut bytes = Self::zeroed(length);
        from.read_exact(bytes.as_mut_bytes())?;
        Ok(bytes)
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
    /// Leaves of trees, with the numbers of their meshes.
    pub(super) leaves: Vec<(usize, Leaves)>,
    pub(super) leaf_count: u32,
    pub(super) meshes: Vec<Mesh>,
    pub(super) instances: Vec<Instance>,
    pub(super) materials: Vec<Material>,
    pub(super) lights: Vec<Light>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) coordinates: Vec<[f32; 2]>,
    pub(super) textures: Vec<Texture>,
    /// Each image once with its coarser levels, or texels alone, and the number of all.
    pub(super) images: Vec<(Option<Arc<Image>>, Vec<Texel>)>,
    pub(super) texels: u32,
    pub(super) media: Vec<Medium>,
    pub(super) colours: Vec<[f32; 3]>,
    pub(super) tangents: Vec<[f32; 4]>,
    pub(super) rungs: u32,
    pub(super) ambient: [f32; 3],
}

impl<const W: usize> Tables<W> {
    /// Writes the tables, and forgets each when it is written.
    pub(super) fn into_bytes(
        mut self,
        background: Background,
        ladders: &[Ladder<'_>],
    ) -> Result<AlignedBytes, BakeError> {
        let mut end = size_of::<Header>() as u64;
        // A scene has one of two kinds of leaves.
        let count = self.leaf_count as usize;
        let (blocks, id_leaves) = if W == 8 { (count, 0) } else { (0, count) };
        let effects = EffectSet::of_records(&Records {
            instances: &self.instances,
            meshes: &self.meshes,
            triangles: &self.triangles,
            materials: &self.materials,
            lights: &self.lights,
            background: &background,
        });
        // The fields are in the order of the tables.
        let header = Header {
            magic: MAGIC,
            checksum: 0,
            version: VERSION,
            width: W as u32,
            byte_len: 0,
            root: 0,
            extent: self.extent,
            stack_entries: self.stack_entries,
            top_nodes: self.top_nodes,
            nodes: place(&mut end, &self.nodes),
            leaves: place_as_many::<LeafBlock<W>>(&mut end, blocks),
            meshes: place(&mut end, &self.meshes),
            instances: place(&mut end, &self.instances),
            materials: place(&mut end, &self.materials),
            lights: place(&mut end, &self.lights),
            triangles: place(&mut end, &self.triangles),
            normals: place(&mut end, &self.normals),
            background,
            ambient: self.ambient,
            id_leaves: place_as_many::<IdLeaf>(&mut end, id_leaves),
            positions: place(&mut end, &self.positions),
            rungs: self.rungs,
            effects: effects.bits(),
            reserved: 0,
            coordinates: place(&mut end, &self.coordinates),
            textures: place(&mut end, &self.textures),
            texels: place_as_many::<Texel>(&mut end, self.texels as usize),
            media: place(&mut end, &self.media),
            colours: place(&mut end, &self.colours),
            tangents: place(&mut end, &self.tangents),
            reserved2: [0; 4],
        };
        let byte_len = u32::try_from(end).map_err(|_| BakeError::TooLarge { bytes: end })?;
        let header = Header { byte_len, ..header };
        let mut aligned = AlignedBytes::zeroed(end as usize);
        let bytes = aligned.as_mut_bytes();
        bytes[..size_of::<Header>()].copy_from_slice(header.as_bytes());
        // Nodes and leaves are generic in width: their fields are arrays of
        // words, written one by one.
        let mut at = header.nodes.offset as usize;
        for node in take(&mut self.nodes) {
            for field in [
                node.planes.as_bytes(),
                node.child.as_bytes(),
                node.order.as_bytes(),
            ] {
                put(bytes, &mut at, field);
            }
        }
        let mut at = if W == 8 {
            header.leaves
        } else {
            header.id_leaves
        }
        .offset as usize;
        for (mesh, leaves) in take(&mut self.leaves) {
            for leaf in leaves.iter() {
                if W == 8 {
                    let leaf = leaf_block::<W>(ladders[mesh].versions(), leaf);
                    put(bytes, &mut at, leaf.corners.as_bytes());
                    put(bytes, &mut at, leaf.ids.as_bytes());
                } else {
                    put(bytes, &mut at, id_leaf(leaf).as_bytes());
                }
            }
        }
        write(bytes, header.meshes, self.meshes);
        write(bytes, header.instances, self.instances);
        write(bytes, header.materials, self.materials);
        write(bytes, header.lights, self.lights);
        write(bytes, header.triangles, self.triangles);
        write(bytes, header.normals, self.normals);
        write(bytes, header.positions, self.positions);
        write(bytes, header.coordinates, self.coordinates);
        write(bytes, header.textures, self.textures);
        let mut at = header.texels.offset as usize;
        for (image, levels) in &self.images {
            let own = image.as_ref().map_or(&[][..], |image| image.texels());
            put(bytes, &mut at, own.as_bytes());
            put(bytes, &mut at, levels.as_bytes());
        }
        write(bytes, header.media, self.media);
        write(bytes, header.colours, self.colours);
        write(bytes, header.tangents, self.tangents);
        seal(bytes);
        Ok(aligned)
    }
}

/// Returns where a table goes, and moves the end behind it.
fn place<T>(end: &mut u64, records: &[T]) -> Table {
    place_as_many::<T>(end, records.len())
}

fn place_as_many<T>(end: &mut u64, count: usize) -> Table {
    let offset = end.next_multiple_of(ALIGNMENT as u64);
    *end = offset + (count * size_of::<T>()) as u64;
    // Saturated values cannot reach a file: the length is checked first.
    Table {
        offset: u32::try_from(offset).unwrap_or(u32::MAX),
        count: u32::try_from(count).unwrap_or(u32::MAX),
    }
}

fn put(bytes: &mut [u8], at: &mut usize, field: &[u8]) {
    bytes[*at..][..field.len()].copy_from_slice(field);
    *at += field.len();
}

#[expect(
    clippy::needless_pass_by_value,
    reason = "its memory is free afterwards"
)]
fn write<T: IntoBytes + Immutable>(bytes: &mut [u8], table: Table, records: Vec<T>) {
    put(bytes, &mut (table.offset as usize), records.as_bytes());
}

/// Leaves no −0 behind, so that equal vertices have equal bits.
pub(super) fn positive_zero(coordinate: f32) -> f32 {
    coordinate + 0.0
}

fn id_leaf(triangles: &[u32]) -> IdLeaf {
    std::array::from_fn(|lane| triangles.get(lane).copied().unwrap_or(u32::MAX))
}

fn leaf_block<const W: usize>(mesh: &TriangleMesh, triangles: &[u32]) -> LeafBlock<W> {
    let mut block = LeafBlock::EMPTY;
    for (lane, &triangle) in triangles.iter().enumerate() {
        block.ids[lane] = triangle;
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle as usize][corner] as usize;
            for axis in 0..3 {
                let position = mesh.positions[vertex][axis];
                block.corners[corner][axis][lane] = positive_zero(position);
            }
        }
    }
    block
}
