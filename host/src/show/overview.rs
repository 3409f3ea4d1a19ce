//! All screens in one picture: unfolded into a [`net`], or as the [`viewer`] sees them.

pub mod net;
pub mod viewer;
