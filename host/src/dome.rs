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
mod near_field;
mod rounding;
mod viewpoint;

pub use design::{Design, Extremum, best, local_optima, optimum};
pub use mapping::Mapping;
pub use mirror::{Mirror, MirrorError, Parameters, Projection};
pub use named::Named;
pub use near_field::{Displacement, NearField, NearestError, px_4096};
pub use rounding::{SizeErrors, size_errors};
pub use viewpoint::{Viewpoint, effective_viewpoint};
