//! The bytes of a baked scene.
//!
//! Little-endian, one [`Header`] and sixteen tables that it points to, each
//! aligned to [`ALIGNMENT`]. The format's version is its own, apart from the
//! crate's; any change to a record here raises it.

pub mod light;

use core::mem::offset_of;
pub use light::Light;
use xxhash_rust::xxh32::xxh32;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

#[cfg(target_endian = "big")]
compile_error!("scenes are little-endian and used in place: big-endian targets are not supported");

/// The first eight bytes of every scene.
pub const MAGIC: [u8; 8] = *b"SHISEN\r\n";

/// Raised by any change to the records in this module.
pub const VERSION: u32 = 7;

/// Bytes to which a blob and each of its tables are aligned.
pub const ALIGNMENT: usize = 32;

/// A child reference with this bit set names a leaf, else a node.
pub const LEAF: u32 = 1 << 31;

/// Where in a leaf reference the number of its primitives less one begins.
pub const COUNT_SHIFT: u32 = 28;

/// The part of a child reference that is an index.
pub const INDEX: u32 = (1 << COUNT_SHIFT) - 1;

/// Most nodes of an instance's cover: three of eight children after one another.
pub const COVER_NODES: u32 = 1 + 8 + 64;

/// No material of its own: the mesh's triangles say.
pub const NO_MATERIAL: u32 = u32::MAX;

/// No texture: the material's colours are those of its whole surface.
pub const NO_TEXTURE: u32 = u32::MAX;

/// No colours of vertices.
pub const NO_COLOURS: u32 = u32::MAX;

/// No tangents of vertices.
pub const NO_TANGENTS: u32 = u32::MAX;

/// Roughness of microfacets from which on no ray shows what they mirror, but the blurred background.
pub const ROUGH: f32 = 0.4;

/// No medium: one index of refraction for all wavelengths.
pub const NO_MEDIUM: u32 = u32::MAX;

/// Where a table is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Table {
    /// Bytes from the start of the blob.
    pub offset: u32,
    /// Records.
    pub count: u32,
}

/// The background: the colour of a ray that meets nothing. A gradient by the height of its direction,
/// linear RGB, or an image in its place.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Background {
    /// Straight up.
    pub zenith: [f32; 3],
    /// Coverage, 0 to 1.
    pub alpha: f32,
    /// Level.
    pub horizon: [f32; 3],
    /// Index of an image with [`reading::SHARED_EXPONENT`], or [`NO_TEXTURE`]: from left to right a
    /// turn about +Y, its middle to −Z and further right to +X; from −Y at the bottom to +Y.
    pub image: u32,
    /// Straight down.
    pub nadir: [f32; 3],
    /// The turn of the image from −Z towards −X: −1 to 1 turns.
    pub turn: f32,
}

/// The start of a blob.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// XXH32, seed 0, of all that follows this field, to `byte_len`.
    pub checksum: u32,
    /// [`VERSION`].
    pub version: u32,
    /// Children of a node: 8 or 4.
    pub width: u32,
    /// Bytes of the whole blob.
    pub byte_len: u32,
    /// Node at the root of the tree over instances.
    pub root: u32,
    /// Largest magnitude of a coordinate of an instance's box: metres.
    pub extent: f32,
    /// Traversal stack that the deepest ray needs, both levels together.
    pub stack_entries: u32,
    /// Nodes that belong to the tree over instances; they come first.
    pub top_nodes: u32,
    /// [`Node`]s.
    pub nodes: Table,
    /// [`LeafBlock`]s.
    pub leaves: Table,
    /// [`Mesh`]es.
    pub meshes: Table,
    /// [`Instance`]s.
    pub instances: Table,
    /// [`Material`]s.
    pub materials: Table,
    /// [`Light`]s.
    pub lights: Table,
    /// [`Triangle`]s.
    pub triangles: Table,
    /// Vertex normals: unit vectors.
    pub normals: Table,
    /// Past all instances.
    pub background: Background,
    /// Light from everywhere, linear RGB.
    pub ambient: [f32; 3],
    /// Leaves of four lanes: triangle numbers alone, see [`IdLeaf`].
    pub id_leaves: Table,
    /// Vertex positions, which those leaves look up; one a normal.
    pub positions: Table,
    /// Meshes of a ladder of polygon levels, the full one included; 1 where
    /// there are none.
    pub rungs: u32,
    /// Bits of [`EffectSet`](super::EffectSet): what the records ask for, by
    /// [`EffectSet::of_records`](super::EffectSet::of_records).
    pub effects: u32,
    /// Zero.
    pub reserved: u32,
    /// Where vertices are on textures: u to the right and v up, 0 to 1 from
    /// the lower left corner to the upper right one, or beyond.
    pub coordinates: Table,
    /// [`Texture`]s.
    pub textures: Table,
    /// [`Texel`]s of images, row by row from their tops.
    pub texels: Table,
    /// [`Medium`](crate::spectrum::Medium)s.
    pub media: Table,
    /// Colours of vertices: linear RGB, 0 to 1.
    pub colours: Table,
    /// Tangents of vertices, for normal maps: unit vectors the way that u grows, and 1, or −1 where
    /// v grows against the cross product of normal and tangent.
    pub tangents: Table,
    /// Zero.
    pub reserved2: [u32; 4],
}

/// An inner node: the boxes of up to `W` children.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Node<const W: usize> {
    /// −x, +x, −y, +y, −z, +z, a lane a child: metres. Lanes without a child
    /// are +∞ to −∞.
    pub planes: [[f32; W]; 6],
    /// [`LEAF`], a count and an index, or the index of a node, which is
    /// greater than this node's own. Lanes without a child are 0.
    pub child: [u32; W],
    /// The order in which to stack the children, farthest first, for rays of
    /// each of the eight octants: see [`Node::order`].
    pub order: [u32; W],
}

impl<const W: usize> Node<W> {
    /// Returns whether a lane has no child: its box is +∞ to −∞ on every axis, which
    /// no ray enters, NaN in the others' arithmetic or not.
    pub fn is_empty_lane(&self, lane: usize) -> bool {
        self.planes.iter().enumerate().all(|(plane, lanes)| {
            let empty = if plane & 1 == 0 {
                f32::INFINITY
            } else {
                f32::NEG_INFINITY
            };
            lanes.get(lane) == Some(&empty)
        })
    }

    /// Returns the lane numbers for an octant (bit `a` set where the direction is
    /// negative on axis `a`), first in the lowest bits. Eight lanes take three
    /// bits each and an octant a word; four take two bits each and an octant
    /// half a word.
    #[inline(always)]
    pub fn order(&self, octant: usize) -> u32 {
        if W == 8 {
            self.order[octant & (W - 1)]
        } else {
            self.order[(octant >> 1) & (W - 1)] >> ((octant & 1) * 16)
        }
    }
}

/// Up to `W` triangles of a mesh, by ascending id.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct LeafBlock<const W: usize> {
    /// Corner, axis, lane: metres in the mesh's frame. NaN where empty.
    pub corners: [[[f32; W]; 3]; 3],
    /// Triangle numbers within the mesh, in its file's order; `u32::MAX`
    /// where empty.
    pub ids: [u32; W],
}

impl<const W: usize> LeafBlock<W> {
    /// A leaf without triangles.
    pub const EMPTY: Self = Self {
        corners: [[[f32::NAN; W]; 3]; 3],
        ids: [u32::MAX; W],
    };
}

/// A leaf of the compact layout: up to four triangle numbers of a mesh,
/// ascending; `u32::MAX` where empty. Corners are looked up by the triangle's
/// record, so that the rungs of a ladder share them.
pub type IdLeaf = [u32; 4];

/// A mesh.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Mesh {
    /// Node at the root.
    pub root: u32,
    /// First node.
    pub first_node: u32,
    /// Nodes.
    pub node_count: u32,
    /// First leaf block.
    pub first_leaf: u32,
    /// Leaf blocks.
    pub leaf_count: u32,
    /// First record of [`Triangle`].
    pub first_triangle: u32,
    /// Triangles.
    pub triangle_count: u32,
    /// First vertex normal.
    pub first_normal: u32,
    /// Vertex normals; 0 where the mesh has none.
    pub normal_count: u32,
    /// Largest magnitude of a coordinate: the mesh's units.
    pub extent: f32,
    /// Meshes from this one on that are the same surface with ever fewer
    /// faces, itself included. They share triangles and normals.
    pub rungs: u32,
    /// Faces that a ray may meet; `triangle_count` counts those of all rungs.
    pub faces: u32,
    /// First of its coordinates on textures.
    pub first_coordinate: u32,
    /// Coordinates: one or two a vertex normal, the second ones after the first, or 0 where the
    /// mesh has none.
    pub coordinate_count: u32,
    /// First of its vertices' colours, one a vertex normal; or [`NO_COLOURS`].
    pub first_colour: u32,
    /// First of its vertices' tangents, one a vertex normal; or [`NO_TANGENTS`].
    pub first_tangent: u32,
}

/// Kinds of shape: the values of [`Instance::kind`].
pub mod kind {
    /// A mesh, by [`geometry`](super::Instance::geometry).
    pub const MESH: u32 = 0;
    /// A spheroid about its own Y axis, by [`radii`](super::Instance::radii).
    pub const SPHEROID: u32 = 1;
}

/// The bits of [`Instance::flags`].
pub mod flag {
    /// Blocks light. Where clear shadows are carried out, its materials say how much of it.
    pub const OCCLUDES: u32 = 1;
    /// Normals are interpolated between vertices.
    pub const SMOOTH: u32 = 2;
    /// Has a clear shadow: some of its materials have holes or let light through.
    pub const VEILS: u32 = 4;
}

/// A placed shape.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Instance {
    /// One of [`kind`].
    pub kind: u32,
    /// Index of the mesh; 0 for other kinds.
    pub geometry: u32,
    /// Index of the material, or [`NO_MATERIAL`].
    pub material: u32,
    /// Bits of [`flag`].
    pub flags: u32,
    /// Equatorial and polar radius: the shape's units.
    pub radii: [f32; 2],
    /// Product of the norms of the two maps, which rounding in the object's
    /// frame is magnified by: 1 or more.
    pub condition: f32,
    /// The first node of its cover, and its root: a tree of boxes in the room, around all that rays
    /// of any rung may meet. Its leaves are numbered from 0 and name nothing.
    pub cover: u32,
    /// Columns of a 3×3 matrix, then the translation: from metres to the shape's units.
    pub object_from_world: [[f32; 3]; 4],
    /// Columns of a 3×3 matrix, then the translation: from the shape's units to metres.
    pub world_from_object: [[f32; 3]; 4],
    /// Least corner of its box, widened for the rounding of the two maps: metres, in
    /// the world.
    pub low: [f32; 3],
    /// Greatest corner: metres, in the world.
    pub high: [f32; 3],
    /// Number of nodes of the cover, up to [`COVER_NODES`]; 0 without a cover.
    pub cover_nodes: u32,
    /// Zero.
    pub reserved: u32,
}

/// The bits of [`Material::effects`]: what a surface asks for; under 2¹⁶.
pub mod effect {
    /// Diffuse or specular light from light sources.
    pub const LIT: u32 = 1;
    /// Mirror reflection.
    pub const REFLECTION: u32 = 2;
    /// Refraction.
    pub const REFRACTION: u32 = 4;
    /// Beer's absorption.
    pub const ABSORPTION: u32 = 8;
    /// Meridians and parallels: the surface is opaque and black between them.
    pub const GRATICULE: u32 = 16;
    /// A texture that is a checker.
    pub const CHECKER_TEXTURE: u32 = 32;
    /// A texture that is an image.
    pub const IMAGE_TEXTURE: u32 = 64;
    /// Light of its own.
    pub const EMISSION: u32 = 128;
    /// Refraction by the wavelength: of what has a [`medium`](super::Material::medium).
    pub const DISPERSION: u32 = 256;
    /// Microfacets: [`metalness`](super::Material::metalness) and
    /// [`roughness`](super::Material::roughness) instead of `shininess` and `mirror`.
    pub const MICROFACETS: u32 = 512;
    /// Colours of a mesh's vertices, which multiply what textures do, or the emission of a surface
    /// without diffuse reflectance.
    pub const VERTEX_COLOURS: u32 = 1024;
    /// [`opacity`](super::Material::opacity), alone or by a texture's alpha.
    pub const ALPHA: u32 = 2048;
    /// Textures that are read as coarsely as a ray's footprint is large: images with several
    /// [`levels`](super::Texture::levels), and checkers.
    pub const TEXTURE_LEVELS: u32 = 4096;
    /// [`priority`](super::Material::priority) among clear bodies within one another.
    pub const NESTED_MEDIA: u32 = 8192;
    /// [`normal_texture`](super::Material::normal_texture): normals that an image bends.
    pub const NORMAL_MAP: u32 = 16384;
}

/// A surface, in Whitted's terms, linear RGB.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Material {
    /// Lambertian reflectance; with [`effect::MICROFACETS`] that of what is no metal, and the colour
    /// of what is.
    pub diffuse: [f32; 3],
    /// Blinn-Phong exponent.
    pub shininess: f32,
    /// Blinn-Phong highlight; with [`effect::MICROFACETS`] the share that what is no metal reflects
    /// head-on.
    pub specular: [f32; 3],
    /// Relative to the surroundings: 0.01 to 100.
    pub index_of_refraction: f32,
    /// Mirror reflectance.
    pub mirror: [f32; 3],
    /// Bits of [`effect`].
    pub effects: u32,
    /// Share of refracted light let through.
    pub transmission: [f32; 3],
    /// Index of the texture that `diffuse` is multiplied by, and `transmission` unless the index of
    /// refraction is 1; or [`NO_TEXTURE`].
    pub texture: u32,
    /// Per metre.
    pub absorption: [f32; 3],
    /// Meridians, and parallels, of a quarter turn about the shape's own Y
    /// axis: 1 to 900 with [`effect::GRATICULE`], else 0.
    pub graticule_divisions: u32,
    /// Width of each line, seen from the shape's origin: radians, above 0 to 0.5 with
    /// [`effect::GRATICULE`], else 0.
    pub graticule_width: f32,
    /// Light of its own, the same in all directions outside; it lights nothing
    /// else.
    pub emission: [f32; 3],
    /// Index of the medium that it is made of, whose index of refraction at
    /// the d line is `index_of_refraction`, or [`NO_MEDIUM`].
    pub medium: u32,
    /// Index of the texture that `emission` is multiplied by, or [`NO_TEXTURE`].
    pub emission_texture: u32,
    /// Index of the texture whose blue `metalness` is multiplied by, and its green `roughness`; or
    /// [`NO_TEXTURE`].
    pub metal_texture: u32,
    /// Share of metal: 0 to 1 with [`effect::MICROFACETS`], else 0.
    pub metalness: f32,
    /// The square root of the microfacets' α: 0 to 1 with [`effect::MICROFACETS`], else 0.
    pub roughness: f32,
    /// Index of the texture whose alpha `opacity` is multiplied by, or [`NO_TEXTURE`].
    pub alpha_texture: u32,
    /// Opacity under which there is a hole and above which the surface is opaque; 0 for a surface
    /// that is seen as far as it is opaque. 0 to 1 with [`effect::ALPHA`], else 0.
    pub alpha_cutoff: f32,
    /// Opacity: 0 to 1 with [`effect::ALPHA`], else 0.
    pub opacity: f32,
    /// Which of several clear bodies fills the place that they share: that of the highest number.
    /// Above 0 with [`effect::NESTED_MEDIA`], else 0.
    pub priority: u32,
    /// Index of the image whose red, green and blue, from −1 to 1, are the parts of the normal along
    /// the tangent, along the bitangent and along the vertices' own normal, or [`NO_TEXTURE`].
    pub normal_texture: u32,
    /// Factor for the first two parts: −1,000 to 1,000 with [`effect::NORMAL_MAP`], else 0.
    pub normal_scale: f32,
    /// Zero.
    pub reserved2: [u32; 5],
}

/// The values of [`Texture::kind`].
pub mod texture {
    /// Cells of two colours in turn.
    pub const CHECKER: u32 = 0;
    /// Texels.
    pub const IMAGE: u32 = 1;
}

/// How an image goes on beyond coordinates of 0 to 1: the values of [`Texture::wrap`].
pub mod wrap {
    /// The same again.
    pub const REPEAT: u32 = 0;
    /// Every second time turned over.
    pub const MIRROR: u32 = 1;
    /// As at its border.
    pub const CLAMP: u32 = 2;
}

/// The bits of [`Texture::reading`].
pub mod reading {
    /// The nearest texel alone; without it, the four around are interpolated.
    pub const NEAREST: u32 = 1;
    /// Codes are data, 0 to 1; without it, sRGB.
    pub const LINEAR: u32 = 2;
    /// By a mesh's second coordinates, where it has them.
    pub const SECOND: u32 = 4;
    /// Red, green and blue count times 2^(alpha − 136), and not at all up to an alpha of 9: an image
    /// of the background. Each texel of a level is the mean over as wide an angle as it is high.
    pub const SHARED_EXPONENT: u32 = 8;
    /// The highest alpha of such a texel.
    pub const MOST_EXPONENT: u8 = 168;
}

/// The materials, the first ones, whose clear bodies can be within one another.
pub const MOST_NESTED: usize = 254;

/// Most levels of an image: those of the largest.
pub const MOST_LEVELS: u32 = 14;

/// Most texels of an image along either side.
pub const LARGEST_SIDE: u32 = 8192;

/// Colours over a surface.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Texture {
    /// One of [`texture`].
    pub kind: u32,
    /// Texels from left to right: 1 to [`LARGEST_SIDE`]; 0 for other kinds.
    pub width: u32,
    /// The same from top to bottom.
    pub height: u32,
    /// The image's first texel; 0 for other kinds.
    pub first_texel: u32,
    /// From a surface's coordinates to its own, of which 1 is a cell of a checker or an image:
    /// where u goes, where v goes, and where the origin is.
    pub map: [[f32; 2]; 3],
    /// Colours of a checker's cells, linear RGB, 0 to 1: of the cell with its lower left
    /// corner at 0, 0, and of those beside it. Zero for other kinds.
    pub colours: [[f32; 3]; 2],
    /// How it goes on, across and up: values of [`wrap`]; 0 for other kinds.
    pub wrap: [u32; 2],
    /// Bits of [`reading`].
    pub reading: u32,
    /// Images of half the sides each, rounded down but never 0, that follow one another from the
    /// first texel on: 1 for the image alone; 0 for other kinds.
    pub levels: u32,
    /// Zero.
    pub reserved: [u32; 4],
}

impl Texture {
    /// Returns its bits among [`effect`].
    pub const fn effects(&self) -> u32 {
        match (self.kind, self.levels) {
            (texture::IMAGE, ..=1) => effect::IMAGE_TEXTURE,
            (texture::IMAGE, _) => effect::IMAGE_TEXTURE | effect::TEXTURE_LEVELS,
            _ => effect::CHECKER_TEXTURE | effect::TEXTURE_LEVELS,
        }
    }

    /// Returns the sides of a level of an image, and its first texel among the image's own.
    pub fn level(&self, level: u32) -> ([u32; 2], u32) {
        let (mut sides, mut first) = ([self.width, self.height], 0_u32);
        for _ in 0..level.min(MOST_LEVELS) {
            first = first.wrapping_add(sides[0].wrapping_mul(sides[1]));
            sides = sides.map(|side| (side / 2).max(1));
        }
        (sides, first)
    }
}

/// Red, green, blue and alpha of an image.
pub type Texel = [u8; 4];

/// A triangle's data for shading, beside its corners.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Triangle {
    /// Numbers of its corners' normals within the mesh, and of their positions
    /// where leaves hold numbers.
    pub corners: [u32; 3],
    /// Index of its material.
    pub material: u32,
}

/// Bytes before those that the checksum is of.
const UNCHECKED: usize = offset_of!(Header, checksum) + size_of::<u32>();

/// Returns the checksum that a blob's header should have; `None` where the blob is too short.
pub(super) fn checksum(blob: &[u8], byte_len: u32) -> Option<u32> {
    let checked = blob.get(UNCHECKED..byte_len as usize)?;
    (checked.len() >= size_of::<Header>() - UNCHECKED).then(|| xxh32(checked, 0))
}

/// Gives a changed scene its checksum: the last thing to do with it. False if the bytes are
/// fewer than their header says, or than a header.
pub fn seal(blob: &mut [u8]) -> bool {
    let word = |at: usize| at..at + size_of::<u32>();
    let length = blob.get(word(offset_of!(Header, byte_len)));
    let length = length.and_then(|bytes| bytes.try_into().ok());
    let sum = length.and_then(|bytes| checksum(blob, u32::from_le_bytes(bytes)));
    let place = blob.get_mut(word(offset_of!(Header, checksum)));
    match sum.zip(place) {
        Some((sum, place)) => {
            place.copy_from_slice(&sum.to_le_bytes());
            true
        }
        None => false,
    }
}

const _: () = {
    assert!(size_of::<Header>() == 256);
    assert!(size_of::<Node<8>>() == 256 && size_of::<Node<4>>() == 128);
    assert!(size_of::<LeafBlock<8>>() == 320 && size_of::<LeafBlock<4>>() == 160);
    assert!(size_of::<Mesh>() == 64);
    assert!(size_of::<Instance>() == 160);
    assert!(size_of::<Material>() == 160);
    assert!(size_of::<Light>() == 64);
    assert!(size_of::<Texture>() == 96);
};
