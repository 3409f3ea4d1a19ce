//! Eye and head tracker decoders: bytes in, samples out.
//!
//! Each protocol has a module that knows how its bytes are laid out and which
//! axes its device uses, and hands over the samples of [`sample`], whose axes
//! are the same for all of them. Reading a port, waiting for a report and
//! stamping it with a time are the caller's: the decoders run as they are in
//! firmware and on a host.
//!
//! Every decoder keeps to these rules:
//!
//! - no allocation, no `unsafe`, no input or output;
//! - no panic, whatever bytes come in;
//! - work in proportion to the bytes handed in, and memory that never grows;
//! - a report is decoded whole or refused with an error that says why; what
//!   the device did not send is `None`, never a made-up value.
//!
//! | Module | Device |
//! |---|---|
//! | [`head`] | head trackers: Polhemus, `InterSense`, Ascension, Hatire, OSVR HDK |
//! | [`eye`] | eye trackers on a serial line |
//! | [`hid`] | eye and head trackers of HID usage page 0x12, by their report descriptor |
//! | [`link`] | boards that speak our own link |
//!
//! All of them are a [`decoder::Decoder`]. What has to be said to a device to
//! make it send, [`command`] says.
//!
//! After them, [`clock`] brings a device's times to the caller's clock, and
//! [`estimate`] makes the line of sight at the time of display. The feature
//! `mock` has a simulated viewer in front of any of these devices.
//!
//! The folder `examples` has all of it: `gaze_from_bytes` for what a device on a serial
//! line says, `uart_loop` for a firmware's loop over a port that also tells the device what
//! to send (`uart::HostEnd`), `mock_tracker` for the simulated viewer.
//!
//! The transports are here too, each behind a feature: in firmware `i2c`
//! (`i2c-hid`) for HID over I²C and `uart` (`uart`) for a serial port; on a
//! host, with its standard library, `serial` (`serial`) and `hid::device`
//! (`hid`).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "hid", feature = "serial"))]
extern crate std;

pub mod clock;
pub mod command;
pub mod decoder;
pub mod estimate;
pub mod eye;
pub mod head;
pub mod hid;
#[cfg(any(feature = "i2c-hid", test))]
pub mod i2c;
pub mod link;
#[cfg(any(test, feature = "mock"))]
pub mod mock;
mod rotation;
pub mod sample;
#[cfg(feature = "serial")]
pub mod serial;
mod stream;
#[cfg(test)]
mod strength;
#[cfg(test)]
mod testing;
pub mod time;
#[cfg(any(feature = "uart", test))]
pub mod uart;
mod valid;
#[cfg(test)]
mod wrong_speed;
