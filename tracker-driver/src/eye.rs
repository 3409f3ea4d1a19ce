//! Eye trackers that send a stream of bytes.
//!
//! Each has a decoder, the bytes that start and stop it, and an `encode` that
//! writes a sample as the device would, for the mock and for tests.

pub mod adhawk;
pub mod asl;
pub mod iscan;
