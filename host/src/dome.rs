//! Domes on a desk: which mirror takes the truest dome master, in f64.
//!
//! [`Mirror`] is what [`shisen_core::capture::SpheroidMirror`] is measured
//! against, [`optimum`] and [`best`] design one. Equation numbers are those of
//! Miura, "A Simple Method to Create Dome Master for Full Dome
//! Visualization", as in [`shisen_core::capture`]. Lengths are in equatorial
//! radii of the mirror, angles in radians.
//!
//! # Near field
//! The paper leaves a trade-off open (section 5.4): surroundings near the
//! mirror are displaced, which a smaller mirror cures, but a small mirror in a
//! large scene has few bits left of its shape. [`size_errors`] measures both.
//! Displacement falls as the mirror's size; and where the mirror is traced in
//! its own frame and its centre added to where its rays start, what rounding
//! costs does not grow, so a mirror of 10⁻⁶ of the distance to the nearest
//! surface has neither (`shisen dome nearfield --mapping exact`: below a
//! thousandth of a pixel at 4096, beside what the eye's own place is rounded
//! by). For larger mirrors [`effective_viewpoint`] is where the eye should be.
//!
//! What remains: the rays of a mirror do not meet in one point, so from the
//! best viewpoint, too, surroundings at D radii are displaced in proportion to
//! 1/D, by more than half of what is seen from the screen's centre. A mirror
//! that is as large as its surroundings are near, one that a photograph shows
//! for example, has no viewpoint that would be right for all of the picture.
//! By the paper's mapping its own error remains at any distance; the exact
//! mapping has none.

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
