//! opentrack's "UDP over network": a head's position and angles.
//!
//! A datagram to UDP port [`PORT`] is 48 bytes, f64 little-endian: x, y, z in centimetres, then yaw,
//! pitch and roll in degrees. It has neither a time nor a check. By opentrack's own page +X points
//! right, +Y up and +Z forward, yaw grows to the right and pitch up; many senders differ, for
//! which [`Config::reversed`] is.

use super::{count_bytes, hand_over};
use crate::decoder::{Counts, Decoder, Event};
use crate::head::axes::{Axes, euler_degrees, from_euler_degrees};
use crate::link::body::Body;
use crate::sample::{Head, Reading, Sample};
use crate::time::Micros;
use crate::valid;
use glam::{Quat, Vec3};

/// The usual UDP port.
pub const PORT: u16 = 4_242;
/// Bytes of a datagram.
pub const LENGTH: usize = 48;
/// The farthest position, in metres along each axis.
const FARTHEST: f32 = 10.0;

/// How a sender's numbers are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Config {
    /// Whether x, y, z, yaw, pitch and roll grow the other way.
    pub reversed: [bool; 6],
}

/// Decodes the datagrams of one sender.
#[derive(Debug, Clone, Default)]
pub struct Opentrack {
    config: Config,
    counts: Counts,
}

impl Opentrack {
    /// Returns a decoder of a sender that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            counts: Counts::default(),
        }
    }
}

impl Decoder for Opentrack {
    /// Takes one whole datagram.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        let config = self.config;
        hand_over(&mut self.counts, bytes.len(), sink, |sink| {
            let mut numbers = [0.0; 6];
            let mut body = Body(bytes);
            for (number, reversed) in numbers.iter_mut().zip(config.reversed) {
                let value = f64::from_le_bytes(body.take()?) as f32;
                *number = if reversed { -value } else { value };
            }
            body.end()?;
            let [x, y, z, yaw, pitch, roll] = numbers;
            let metres = valid::place(Vec3::new(x, y, -z) * 0.01, FARTHEST)?;
            let turn = from_euler_degrees(yaw, pitch, roll)?;
            let turn = Axes::FORWARD_RIGHT_DOWN.orientation(turn);
            let mut sample = Sample::arrived(arrival);
            sample.head.position = Some(Reading::tracked(metres));
            sample.head.orientation = Some(Reading::tracked(turn));
            sink(Event::Sample(sample));
            Ok(())
        });
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn reset(&mut self) {}
}

/// Returns the datagram of a head's pose; what a sample lacks is 0. `None` for one that has neither.
pub fn encode(head: &Head) -> Option<[u8; LENGTH]> {
    if head.position.is_none() && head.orientation.is_none() {
        return None;
    }
    let place = head.position.map_or(Vec3::ZERO, |place| place.value) * 100.0;
    let turn = head.orientation.map_or(Quat::IDENTITY, |turn| turn.value);
    let angles = euler_degrees(Axes::FORWARD_RIGHT_DOWN.device_orientation(turn));
    let numbers = [place.x, place.y, -place.z].into_iter().chain(angles);
    let mut datagram = [0; LENGTH];
    for (to, number) in datagram.as_chunks_mut().0.iter_mut().zip(numbers) {
        *to = f64::from(number).to_le_bytes();
    }
    Some(datagram)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::DropReason;
    use crate::testing::{events, samples, thrown};
    use std::vec::Vec;

    fn datagram(numbers: [f64; 6]) -> Vec<u8> {
        numbers.into_iter().flat_map(f64::to_le_bytes).collect()
    }

    #[test]
    fn numbers_are_centimetres_and_degrees() {
        let bytes = datagram([1.5, -2.25, 10.0, -30.0, 5.5, 0.0]);
        assert_eq!(
            bytes[..16],
            [0, 0, 0, 0, 0, 0, 0xF8, 0x3F, 0, 0, 0, 0, 0, 0, 2, 0xC0]
        );
        let head = samples(&mut Opentrack::default(), &bytes)[0].head;
        let place = head.position.unwrap().value;
        assert!(place.distance(Vec3::new(0.015, -0.0225, -0.1)) < 1e-7);
        let front = head.orientation.unwrap().value * Vec3::NEG_Z;
        assert!((front.x.atan2(-front.z).to_degrees() + 30.0).abs() < 1e-4);
        assert!((front.y.asin().to_degrees() - 5.5).abs() < 1e-4);
        let again = encode(&head).unwrap();
        for (sent, read) in again.as_chunks().0.iter().zip(bytes.as_chunks().0) {
            assert!((f64::from_le_bytes(*sent) - f64::from_le_bytes(*read)).abs() < 1e-4);
        }
        let reversed = [false, false, true, true, false, false];
        let head = samples(&mut Opentrack::new(Config { reversed }), &bytes)[0].head;
        let front = head.orientation.unwrap().value * Vec3::NEG_Z;
        assert!(head.position.unwrap().value.z > 0.0 && front.x > 0.0);
    }

    #[test]
    fn what_is_no_head_is_dropped() {
        use DropReason::{Length, OutOfRange};
        let good = datagram([0.0; 6]);
        for (bytes, reason) in [
            (good[..47].to_vec(), Length),
            ([&good[..], &[0]].concat(), Length),
            (Vec::new(), Length),
            (
                datagram([f64::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0]),
                OutOfRange,
            ),
            (datagram([1_001.0, 0.0, 0.0, 0.0, 0.0, 0.0]), OutOfRange),
            (datagram([0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0]), OutOfRange),
            (datagram([0.0, 0.0, 0.0, 1e308, 0.0, 0.0]), OutOfRange),
        ] {
            let found = events(&mut Opentrack::default(), &bytes);
            assert_eq!(found, [thrown(bytes.len() as u32, reason)]);
        }
    }
}
