//! `FreeD`, message D1: the position and angles of a camera, which may be a head's.
//!
//! A datagram is 29 bytes, big-endian, to a UDP port that is agreed on; it has no time:
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | D1 |
//! | 1 | camera, the sample's sensor |
//! | 2, 5, 8 | i24 pan, tilt, roll, 1/32768 degree |
//! | 11, 14, 17 | i24 x, y, z, 1/64 mm |
//! | 20, 23 | u24 zoom, focus |
//! | 26 | u16 any |
//! | 28 | 40 less the sum of all before, modulo 256 |
//!
//! +X points right, +Y forward, from where pan grows to the right, and +Z up; tilt grows up, roll
//! clockwise as seen from behind. Of random bytes of this length and first byte 1/256 passes.

use super::{count_bytes, hand_over};
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::head::axes::{Axes, from_euler_degrees};
use crate::sample::{Reading, Sample};
use crate::time::Micros;
use crate::valid;
use glam::Vec3;

/// Bytes of a datagram.
pub const LENGTH: usize = 29;
/// The first byte.
const KIND: u8 = 0xD1;

/// Decodes the datagrams of one sender.
#[derive(Debug, Clone, Default)]
pub struct FreeD {
    counts: Counts,
}

impl FreeD {
    /// Returns a decoder that has seen no datagram.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Decoder for FreeD {
    /// Takes one whole datagram.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        hand_over(&mut self.counts, bytes.len(), sink, |sink| {
            sink(Event::Sample(read(bytes, arrival)?));
            Ok(())
        });
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn reset(&mut self) {}
}

fn read(bytes: &[u8], arrival: Micros) -> Result<Sample, DropReason> {
    let bytes: &[u8; LENGTH] = bytes.try_into().map_err(|_| DropReason::Length)?;
    let [KIND, sensor, values @ ..] = bytes else {
        return Err(DropReason::Unknown);
    };
    let sum = bytes.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
    if sum != 0x40 {
        return Err(DropReason::Checksum);
    }
    let mut numbers = [0.0; 6];
    for (number, &[high, middle, low]) in numbers.iter_mut().zip(values.as_chunks().0) {
        *number = (i32::from_be_bytes([high, middle, low, 0]) >> 8) as f32;
    }
    let [pan, tilt, roll, x, y, z] = numbers;
    let angle = |steps: f32| valid::within(steps / 32_768.0, 180.0);
    let turn = from_euler_degrees(angle(pan)?, angle(tilt)?, angle(roll)?)?;
    let metres = valid::position(Vec3::new(x, z, -y) / 64_000.0)?;
    let mut sample = Sample::arrived(arrival);
    sample.sensor = *sensor;
    sample.head.position = Some(Reading::tracked(metres));
    sample.head.orientation = Some(Reading::tracked(Axes::FORWARD_RIGHT_DOWN.orientation(turn)));
    Ok(sample)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::capture::faults;
    use crate::testing::{events, samples, thrown};

    /// Camera 1; 10.5, −3.25 and 0.5 degrees; 1234.5, −250.25 and 1600 mm.
    const VECTOR: [u8; LENGTH] = [
        0xD1, 0x01, 0x05, 0x40, 0x00, 0xFE, 0x60, 0x00, 0x00, 0x40, 0x00, 0x01, 0x34, 0xA0, 0xFF,
        0xC1, 0x70, 0x01, 0x90, 0x00, 0x00, 0x03, 0xE8, 0x00, 0x07, 0xD0, 0x00, 0x00, 0x33,
    ];

    #[test]
    fn vector_decodes_to_its_values() {
        let sample = samples(&mut FreeD::new(), &VECTOR)[0];
        assert_eq!(sample.sensor, 1);
        let place = sample.head.position.unwrap().value;
        assert!(place.distance(Vec3::new(1.2345, 1.6, 0.25025)) < 1e-6);
        let turn = sample.head.orientation.unwrap().value;
        let front = turn * Vec3::NEG_Z;
        assert!((front.x.atan2(-front.z).to_degrees() - 10.5).abs() < 1e-4);
        assert!((front.y.asin().to_degrees() + 3.25).abs() < 1e-4);
        // The right side goes down.
        assert!((turn * Vec3::X).y < 0.0);
        // The sum does not notice two faults; the angle does.
        let mut beyond = VECTOR;
        (beyond[2], beyond[28]) = (0x64, 0x33_u8.wrapping_sub(0x64 - 0x05));
        let found = events(&mut FreeD::new(), &beyond);
        assert_eq!(found, [thrown(29, DropReason::OutOfRange)]);
    }

    #[test]
    fn every_fault_costs_its_datagram() {
        assert_eq!(faults(FreeD::new, &[&VECTOR[..]; 3]), 0);
    }
}
