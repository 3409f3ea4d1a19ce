//! What is wrong with a blob, and what to do about it.

/// Why a blob is not a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneError {
    /// Shorter than it says, or than a header.
    #[error("the scene is cut off: {found} bytes of {needed}")]
    Truncated { needed: u64, found: u64 },
    /// Not at an address that its records can be used at.
    #[error("the scene is not at an address that is a multiple of {needed}")]
    Misaligned { needed: usize },
    /// Does not start like a scene.
    #[error("this is not a baked scene")]
    NotAScene,
    /// Baked by another version of the format.
    #[error("the scene has format version {found}, this tracer reads {supported}: bake it again")]
    Version { found: u32, supported: u32 },
    /// Baked for nodes of another width.
    #[error(
        "the scene was baked with {found} children a node, this tracer was built for {expected}"
    )]
    Width { found: u32, expected: u32 },
    /// Damaged since it was baked.
    #[error("the scene is damaged: its checksum is {computed:08x}, it should be {stored:08x}")]
    Checksum { stored: u32, computed: u32 },
    /// A table that is not inside the blob, or not aligned.
    #[error("the table of {name} ({count} records at byte {offset}) is not inside the scene")]
    Table {
        name: &'static str,
        offset: u32,
        count: u32,
    },
    /// A table of another length than the layout or another table gives it.
    #[error("the table of {name} has {found} records, it should have {expected}")]
    Count {
        name: &'static str,
        found: u32,
        expected: u32,
    },
    /// An index past its table, or into a part that is another's.
    #[error("record {record} names {what} {index}, which is not its to name")]
    Index {
        what: &'static str,
        record: u32,
        index: u32,
    },
    /// A node whose child is not after it, or that two nodes share.
    #[error("node {node} is not part of a tree")]
    NotATree { node: u32 },
    /// A tree that the traversal stack could not hold.
    #[error("tracing would need a stack of {needed} entries, there are {limit}")]
    TooDeep { needed: u32, limit: u32 },
    /// A rung of a ladder of polygon levels that does not fit the mesh before it or the scene.
    #[error("mesh {mesh} does not fit the ladder of polygon levels that it is said to be part of")]
    Ladder { mesh: u32 },
    /// Another set of effects than its records ask for.
    #[error("the scene is said to ask for the effects {stored:#x}, its records ask for {asked:#x}")]
    Effects { stored: u32, asked: u32 },
    /// A value that is NaN, infinite, or outside its range.
    #[error("record {record} has {what} out of range or not a number")]
    Value { what: &'static str, record: u32 },
}
