//! USB and I²C human interface devices, by what their report descriptor says.
//!
//! Reports come whole: each is one call, and begins with its report id where
//! the device uses ids, as `hidraw`, hidapi and HID over I²C hand it over.

mod descriptor;
#[cfg(feature = "hid")]
pub mod device;
pub mod eye_tracker;
mod usages;
