//! Rays and the shapes they meet.
//!
//! Distances along a ray are in units of its direction's length: a hit at
//! `t` is at `origin + t·direction`.

mod bounds;
mod ray;
mod spheroid;
mod triangle;

pub use bounds::Slabs;
pub use ray::Ray;
pub use spheroid::{Spheroid, SpheroidHits};
pub(crate) use triangle::Shear;
pub use triangle::{Triangle, TriangleHit};
