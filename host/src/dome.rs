//! Domes on a desk: which mirror takes the truest dome master, in f64.
//!
//! [`Mirror`] is what [`shisen_core::capture::SpheroidMirror`] is measured
//! against, [`optimum`] and [`best`] design one. Equation numbers are those of
//! Miura, "A Simple Method to Create Dome Master for Full Dome
//! Visualization", as in [`shisen_core::capture`]. Lengths are in equatorial
//! radii of the mirror, angles in radians.

mod design;
mod mapping;
mod mirror;
mod named;

pub use design::{Design, Extremum, best, optimum};
pub use mapping::Mapping;
pub use mirror::{Mirror, Parameters, Projection};
pub use named::Named;
