//! What a ray meets, and the light that comes back along it.

mod background;
mod budget;
mod dispersion;
mod graticule;
mod hit;
mod leaves;
mod ledger;
mod mesh;
mod optics;
mod row;
mod sample;
mod shading;
mod soft_light;
mod stack;
mod surface;
mod texture;
mod tile;
mod tracer;
mod walk;
mod world;

pub(crate) use background::Colours;
pub use budget::{Budget, Statistics};
pub(crate) use dispersion::Balance;
pub use dispersion::{Spectrum, SpectrumError};
#[cfg(test)]
pub(crate) use graticule::BETWEEN as BETWEEN_LINES;
pub use hit::{Hit, MeshHit};
pub use ledger::{Entry, Ledger};
pub use mesh::MeshTracer;
pub use optics::{Refraction, reflect, refract};
pub(crate) use row::{RowHits, RowRays};
pub(crate) use sample::Sample;
pub use stack::TraversalStack;
pub(crate) use tile::NOT_TRACED;
pub use tile::{TileHits, TileRays};
pub use tracer::{LEAST_WEIGHT, MAX_DEPTH, Pixel, RayDetail, Tracer, Workspace};
