use crate::scene::STACK_ENTRIES;

/// Children still to visit: a little over 1 KiB of the caller's memory, neither allocated nor
/// cleared for each ray.
#[derive(Debug, Clone)]
pub struct TraversalStack {
    pub(super) distances: [f32; STACK_ENTRIES],
    pub(super) children: [u32; STACK_ENTRIES],
    /// Which groups of a tile enter the child.
    pub(super) groups: [u8; STACK_ENTRIES],
}

impl TraversalStack {
    /// An empty stack.
    pub const EMPTY: Self = Self {
        distances: [0.0; STACK_ENTRIES],
        children: [0; STACK_ENTRIES],
        groups: [0; STACK_ENTRIES],
    };
}

impl Default for TraversalStack {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The work of a traversal.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Work {
    /// Nodes visited and primitives tested.
    pub(crate) steps: u64,
    pub(crate) deepest: u32,
}
