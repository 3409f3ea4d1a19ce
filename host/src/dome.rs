//! Mirrors for dome masters: which takes the truest picture, in f64.
//!
//! By Miura, "A Simple Method to Create Dome Master for Full Dome Visualization": a camera looks
//! at the pole of a mirrored spheroid, and what it sees is nearly a dome master. [`optimum`]
//! finds the best viewpoint for an axis ratio, [`best`] the best mirror of all; [`Named`] has the
//! paper's three mirrors and the best. [`Mapping`] says how pixels become directions: as the
//! mirror has them, with the mirror's own error corrected, or without a mirror. Equation numbers
//! are the paper's, lengths in equatorial radii of the mirror, angles in radians.
//!
//! ```
//! use shisen::dome::{Projection, optimum};
//!
//! let design = optimum(1.288, Projection::Parallel)?;
//! assert!((design.error_percent - 0.1254).abs() < 1e-4);
//! # Ok::<(), shisen::dome::MirrorError>(())
//! ```
//!
//! # Near field
//! Surroundings near the mirror are displaced, because its rays start around the viewpoint and
//! not in it (section 5.4): less, the smaller the mirror is. [`NearField`] measures by how much;
//! [`effective_viewpoint`] finds where the eye should be.

mod design;
mod mapping;
mod mirror;
mod named;
mod near_field;
mod rounding;
mod search;

pub use design::{Design, Extremum, best, local_optima, optimum};
pub use mapping::Mapping;
pub use mirror::{Mirror, MirrorError, Parameters, Projection};
pub use named::Named;
pub use near_field::{
    Displacement, NearField, NearestError, Viewpoint, effective_viewpoint, px_4096,
};
pub use rounding::{SizeErrors, size_errors};
