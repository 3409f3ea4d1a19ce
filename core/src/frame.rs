//! STUB for the command: constants and counts of the tile renderer.

/// The most reflections and refractions one after another.
pub const MAX_DEPTH: u8 = 16;
/// The most samples a pixel.
pub const MAX_SAMPLES: u16 = 4096;

/// What tracing took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Rays from the eye.
    pub primary: u64,
    /// Mirrored rays.
    pub reflected: u64,
    /// Refracted rays.
    pub refracted: u64,
    /// Rays to lights.
    pub shadow: u64,
    /// Nodes visited and primitives tested.
    pub steps: u64,
    /// The most traversal stack entries in use.
    pub deepest_stack: u32,
}
