//! What is wrong with a blob, and what to do about it.

use core::fmt;

/// Why a blob is not a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SceneError {
    /// Shorter than it says, or than a header.
    Truncated {
        /// Bytes that it should have.
        needed: u64,
        /// Bytes that it has.
        found: u64,
    },
    /// Not at an address that its records can be used at.
    Misaligned {
        /// Bytes to align to.
        needed: usize,
    },
    /// Does not start like a scene.
    NotAScene,
    /// Baked by another version of the format.
    Version {
        /// In the blob.
        found: u32,
        /// That this core reads.
        supported: u32,
    },
    /// Baked for nodes of another width.
    Width {
        /// In the blob.
        found: u32,
        /// That was asked for.
        expected: u32,
    },
    /// Damaged since it was baked.
    Checksum {
        /// In the header.
        stored: u32,
        /// Of the bytes.
        computed: u32,
    },
    /// A table that is not inside the blob, or not aligned.
    Table {
        /// Which.
        name: &'static str,
        /// Its offset: bytes.
        offset: u32,
        /// Its length: records.
        count: u32,
    },
    /// A table of another length than the layout or another table gives it.
    Count {
        /// Which.
        name: &'static str,
        /// Records that it has.
        found: u32,
        /// Records that it should have.
        expected: u32,
    },
    /// An index past its table, or into a part that is another's.
    Index {
        /// What it should name.
        what: &'static str,
        /// Number of the record that has it.
        record: u32,
        /// The index.
        index: u32,
    },
    /// A node whose child is not after it, or that two nodes share.
    NotATree {
        /// The node.
        node: u32,
    },
    /// A tree that the traversal stack could not hold.
    TooDeep {
        /// Entries needed.
        needed: u32,
        /// Entries there are.
        limit: u32,
    },
    /// A mesh that says it is a rung of a ladder of polygon levels, and does
    /// not fit the mesh before it or the scene.
    Ladder {
        /// The mesh.
        mesh: u32,
    },
    /// Another set of effects than its records ask for.
    Effects {
        /// In the header.
        stored: u32,
        /// Of the records.
        asked: u32,
    },
    /// A value that is NaN, infinite, or outside its range.
    Value {
        /// Which.
        what: &'static str,
        /// Number of the record that has it.
        record: u32,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Truncated { needed, found } => {
                write!(f, "the scene is cut off: {found} bytes of {needed}")
            }
            Self::Misaligned { needed } => {
                write!(
                    f,
                    "the scene is not at an address that is a multiple of {needed}"
                )
            }
            Self::NotAScene => f.write_str("this is not a baked scene"),
            Self::Version { found, supported } => write!(
                f,
                "the scene has format version {found}, this tracer reads {supported}: bake it again"
            ),
            Self::Width { found, expected } => write!(
                f,
                "the scene was baked with {found} children a node, this tracer was built for {expected}"
            ),
            Self::Checksum { stored, computed } => write!(
                f,
                "the scene is damaged: its checksum is {computed:08x}, it should be {stored:08x}"
            ),
            Self::Table {
                name,
                offset,
                count,
            } => write!(
                f,
                "the table of {name} ({count} records at byte {offset}) is not inside the scene"
            ),
            Self::Count {
                name,
                found,
                expected,
            } => write!(
                f,
                "the table of {name} has {found} records, it should have {expected}"
            ),
            Self::Index {
                what,
                record,
                index,
            } => {
                write!(
                    f,
                    "record {record} names {what} {index}, which is not its to name"
                )
            }
            Self::NotATree { node } => write!(f, "node {node} is not part of a tree"),
            Self::TooDeep { needed, limit } => write!(
                f,
                "tracing would need a stack of {needed} entries, there are {limit}"
            ),
            Self::Ladder { mesh } => write!(
                f,
                "mesh {mesh} does not fit the ladder of polygon levels that it is said to be part of"
            ),
            Self::Effects { stored, asked } => write!(
                f,
                "the scene is said to ask for the effects {stored:#x}, its records ask for {asked:#x}"
            ),
            Self::Value { what, record } => {
                write!(f, "record {record} has {what} out of range or not a number")
            }
        }
    }
}

impl core::error::Error for SceneError {}
