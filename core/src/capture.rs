//! A dome master: all directions of half a space in one round picture.
//!
//! The centre of a dome master is the dome's zenith, its rim the dome's
//! spring line, and the distance from the centre is the angle from the zenith
//! (equation 1). [`SpheroidMirror`] is Miura's method: a camera looks at the pole
//! of a mirrored spheroid. [`fisheye_equidistant`], [`fisheye_equisolid`] and
//! [`mirror_ball`] are mappings of ideal lenses and of a mirror ball.
//!
//! Equation numbers are those of Miura, "A Simple Method to Create Dome
//! Master for Full Dome Visualization" (JAXA-RR-16-007), in the order of the
//! text: 37 is θ of β by perspective, 45 `r_d` by parallel projection.
//!
//! # Axes
//! The camera's: +X to the right of the picture, +Y to its top, −Z, forward,
//! to its centre; right-handed. −Z is the dome's zenith and the mirror's axis,
//! from its centre through the pole that is looked at. For a dome over a room
//! (+Y up, −Z forward) with the front at the bottom of the picture, turn the
//! camera a quarter about +X: (x, y, z) becomes (x, −z, y).
//!
//! A photograph of a mirror is flipped. Here left and right are as a viewer under
//! the dome sees them: each ray takes the mirrored direction.
//!
//! Pixels are (u, v), u to the right and v upwards, in the unit disc: the rim
//! is u² + v² = 1. Lengths are in equatorial radii of the mirror.

mod fisheye;
mod mapping;
mod mirror;
mod reflection;

pub(crate) use fisheye::equidistant;
pub use fisheye::{fisheye_equidistant, fisheye_equisolid, mirror_ball};
pub use mapping::MirrorPoint;
pub use mirror::{MirrorError, SpheroidMirror};
pub use reflection::{Mapping, Reflection};
