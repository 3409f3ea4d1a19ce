//! What a ray meets, and the light that comes back along it.

mod background;
pub(crate) mod budget;
pub(crate) mod dispersion;
mod graticule;
mod hit;
mod leaves;
pub(crate) mod ledger;
mod mesh;
mod optics;
mod row;
mod sample;
mod search;
pub(crate) mod shading;
mod soft_light;
mod stack;
mod surface;
mod texture;
mod tile;
mod tracer;
mod walk;
pub(crate) mod workspace;
mod world;

pub(crate) use background::Colours;
pub(crate) use budget::Budget;
pub(crate) use dispersion::Balance;
pub use hit::{Hit, MeshHit};
pub(crate) use ledger::Ledger;
pub use mesh::MeshTracer;
pub use optics::{Refraction, reflect, refract};
pub(crate) use row::{RowHits, RowRays};
pub(crate) use sample::Sample;
pub use stack::TraversalStack;
pub(crate) use tile::NOT_TRACED;
pub use tile::{TileHits, TileRays};
pub use tracer::Tracer;
pub(crate) use workspace::{Pixel, RayDetail, Workspace};
