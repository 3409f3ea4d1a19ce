//! What a ray meets, and the light that comes back along it.

mod hit;
mod mesh;
mod stack;
mod walk;
mod world;

pub use hit::{Hit, MeshHit};
pub use mesh::MeshTracer;
pub use stack::{STACK_ENTRIES, TraversalStack};
