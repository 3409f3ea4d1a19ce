//! Eye and head trackers: bytes in, samples out, and from those where somebody looks at
//! the time of display.
//!
//! Each protocol has a module that knows how its bytes are laid out and which
//! axes its device uses, and hands over the samples of [`sample`], whose axes
//! are the same for all of them. Reading a port, waiting for a report and
//! stamping it with a time are the caller's: the decoders run as they are in
//! firmware and on a host.
//!
//! ```
//! use shisen_tracker::decoder::{Decoder, Event};
//! use shisen_tracker::head::hatire::{Config, Hatire};
//! use shisen_tracker::time::Micros;
//!
//! let mut decoder = Hatire::new(Config::default());
//! // The noise is dropped, and said; then a whole frame, of a head that is level.
//! let mut bytes = [0; 35];
//! bytes[..7].copy_from_slice(b"noise\xAA\xAA");
//! bytes[33..].copy_from_slice(b"\x55\x55");
//! let (mut dropped, mut samples) = (0, 0);
//! decoder.feed(&bytes, Micros(1_000), &mut |event| match event {
//!     Event::Sample(sample) => samples += u32::from(sample.head.orientation.is_some()),
//!     Event::Dropped(what) => dropped += what.bytes,
//!     _ => {}
//! });
//! assert_eq!((dropped, samples), (5, 1));
//! ```
//!
//! The folder `examples` goes on from there: `gaze_from_bytes` makes a line of sight of
//! samples, `uart_loop` is a firmware's loop over a port that also tells the device what
//! to send (`uart::HostEnd`), `mock_tracker` has the simulated viewer. How the driver
//! stands to the rest is on the first page of the crate `shisen`.
//!
//! # Where things are
//!
//! In the order in which data go:
//!
//! | Module | What |
//! |---|---|
//! | `uart`, `i2c`, `serial`, `hid::device` | transports, each behind a feature |
//! | [`decoder`] | what all decoders have in common |
//! | [`head`] | head trackers: Polhemus, `InterSense`, Ascension, Hatire, OSVR HDK |
//! | [`eye`] | eye trackers on a serial line |
//! | [`hid`] | eye and head trackers of HID usage page 0x12, by their report descriptor |
//! | [`link`] | boards that speak our own link, and displays that do |
//! | [`protocol`] | any of these devices, chosen at run time |
//! | [`sample`], [`time`] | what comes out of a decoder: heads, eyes, and when |
//! | [`clock`] | from a device's times to the caller's clock |
//! | [`estimate`] | the line of sight at the time of display, and how sure it is |
//! | [`command`] | the way back: what makes a device send |
//! | `mock` | a simulated viewer in front of any of these devices |
//!
//! # What holds everywhere
//!
//! - No allocation, no `unsafe`, and in decoders no input or output.
//! - No panic, whatever bytes come in.
//! - Work in proportion to the bytes handed in, and memory that never grows.
//! - A report is decoded whole or refused with an error that says why; what
//!   the device did not send is `None`, never a made-up value.
//!
//! # Features
//!
//! None is on by default; `serial` and `hid` need the standard library, and a host.
//!
//! | Feature | What it adds |
//! |---|---|
//! | `uart` | `uart`: a serial port, on `embedded-io` |
//! | `i2c-hid` | `i2c`: HID over I²C, on `embedded-hal` |
//! | `serial` | `serial`: a serial port, by `serialport` |
//! | `hid` | `hid::device`: USB devices, by `hidapi` |
//! | `mock` | `mock`: the simulated viewer, its faults, and the bytes of every protocol |
//! | `defmt` | `defmt::Format` of what there is to be said |
//!
//! # What it does not do
//!
//! No pictures of cameras; and nobody is shown what to look at: targets of a
//! [calibration](estimate::Calibration) are the caller's (`shisen tracker calibrate` has
//! them). No device has been at hand: decoders have been tested by mocks.
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
pub mod protocol;
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
