//! Eye and head trackers: decodes bytes into samples, and estimates from them where the
//! viewer looks at the time of display.
//!
//! Each protocol has a module that decodes its bytes into the samples of [`sample`], whose
//! axes are the same for all devices. The caller reads the port, waits for reports and
//! stamps them with a time, so the decoders run in firmware and on a host.
//!
//! | Device | Module | Bytes a record | Transport |
//! |---|---|---|---|
//! | Polhemus FASTRAK, `InterSense` IS-600, IS-900 | [`head::fastrak`] | 32; others by the list of items | serial |
//! | Polhemus Liberty, Patriot, Latus | [`head::liberty`] | 41; others by the list of items | serial |
//! | Ascension Flock of Birds, laserBIRD | [`head::flock`] | 14; 6 to 25 by the mode | serial, 38,400 baud |
//! | Hatire | [`head::hatire`] | 30 | serial, 115,200 baud |
//! | OSVR HDK | [`head::osvr_hdk`] | 16 or 32 | USB HID |
//! | ISCAN | [`eye::iscan`] | 12; 4 to 14 by the outputs | serial, 115,200 baud |
//! | ASL EYE-TRAC 5000, 6000 | [`eye::asl`] | 12 or 10 | serial, 57,600 baud |
//! | `AdHawk` | [`eye::adhawk`] | up to 128 | serial or SPI |
//! | HID eye and head trackers | [`hid::eye_tracker`] | 65; others by the descriptor | USB HID, HID over I²C |
//! | boards that speak our own link | [`link`] | up to 181 | serial |
//! | VRPN, `DTrack`, `NatNet`, LSL, opentrack, `FreeD` | [`net`] | any | TCP, UDP |
//!
//! ```
//! use shisen_tracker::decoder::{Decoder, Event};
//! use shisen_tracker::head::hatire::{Config, Hatire};
//! use shisen_tracker::time::Micros;
//!
//! let mut decoder = Hatire::new(Config::default());
//! // The noise is dropped and reported; a whole frame of a level head follows.
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
//! In `examples`, `gaze_from_bytes` turns samples into a line of sight, `uart_loop` is a firmware's
//! loop over a port that also sets the device up (`uart::HostEnd`), `mock_tracker` runs the
//! simulated viewer.
//!
//! Bytes go from a transport (`uart`, `i2c`, `serial`, `hid::device`, each behind a feature) to a
//! [`decoder`]; its [`Sample`](sample::Sample)s get the caller's time from a [`clock`] and become a
//! line of sight in an [`estimate`]. A [`protocol`] is any of the devices, chosen at run time;
//! [`command`] sends commands to the device; `mock` is a simulated viewer in front of any device.
//!
//! # What holds everywhere
//!
//! - No allocation, no `unsafe`, and in decoders no input or output.
//! - No panic, whatever bytes come in.
//! - Work in proportion to the bytes handed in, and memory that never grows.
//! - A report is decoded whole or refused with a reason; a value that was not sent is `None`.
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
//! | `defmt` | `defmt::Format` for samples, events and errors |
//!
//! # What it does not do
//!
//! It reads no camera pictures and shows no targets: the caller shows those of a
//! [calibration](estimate::Calibration). The decoders were tested with mocks only, never with a
//! real device; those of [`net`] also with what VRPN's server and LSL's outlets sent.
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
pub mod net;
pub mod protocol;
mod rotation;
pub mod sample;
#[cfg(feature = "serial")]
pub mod serial;
mod stream;
#[cfg(test)]
mod testing;
pub mod time;
#[cfg(any(feature = "uart", test))]
pub mod uart;
mod valid;
#[cfg(test)]
mod wrong_speed;
