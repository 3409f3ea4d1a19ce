//! Head trackers.
//!
//! | Module | Device |
//! |---|---|
//! | [`fastrak`] | Polhemus FASTRAK and what speaks its language: `InterSense` IS-600, IS-900 (serial) |
//! | [`liberty`] | Polhemus Liberty, Patriot, Latus (serial, binary) |
//! | [`flock`] | Ascension Flock of Birds, laserBIRD (serial) |
//! | [`hatire`] | Hatire head trackers of hobbyists (serial) |
//! | [`osvr_hdk`] | the head tracker of the OSVR Hacker Dev Kit (USB HID) |
//!
//! [`polhemus`] holds the lists of items that the first two have in common,
//! [`axes`] what a device's frame has to do with [`Head`](crate::sample::Head)'s.

pub mod axes;
pub mod fastrak;
pub mod flock;
pub mod hatire;
pub mod liberty;
pub mod osvr_hdk;
pub mod polhemus;
