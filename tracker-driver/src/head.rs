//! Head trackers. [`polhemus`] holds the lists of items that FASTRAK and Liberty have in common,
//! [`axes`] what a device's frame has to do with [`Head`](crate::sample::Head)'s.

pub mod axes;
pub mod fastrak;
pub mod flock;
pub mod hatire;
pub mod liberty;
pub mod osvr_hdk;
pub mod polhemus;
