//! The messages of one direction of a connection.

use super::{HEADER_BYTES, LONGEST_BODY, MOST_NAME_BYTES, SENDER, TYPE};
use crate::sample::Sample;
use crate::time::Micros;
use glam::{Quat, Vec3};
use heapless::Vec;

/// Most bytes of a message that [`Encoder`] writes.
pub const LONGEST_ENCODED: usize = HEADER_BYTES + LONGEST_BODY;

/// Bytes of a pose.
const POSE_BYTES: usize = 64;

/// Writes messages and counts them.
#[derive(Debug, Clone, Default)]
pub struct Encoder {
    sequence: u32,
}

impl Encoder {
    /// Returns an encoder whose first message has count 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns a message of these ids at this time since 1970, with its padding; of a body that is
    /// too long only the first 1,032 bytes.
    pub fn message(
        &mut self,
        time: Micros,
        [sender, kind]: [i32; 2],
        body: &[u8],
    ) -> Vec<u8, LONGEST_ENCODED> {
        let body = body.get(..LONGEST_BODY).unwrap_or(body);
        let words = [
            (HEADER_BYTES + body.len()) as u32,
            (time.0 / 1_000_000) as u32,
            (time.0 % 1_000_000) as u32,
            sender as u32,
            kind as u32,
            self.sequence,
        ];
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = words.into_iter().flat_map(u32::to_be_bytes);
        let mut message: Vec<u8, LONGEST_ENCODED> = bytes.chain(body.iter().copied()).collect();
        let padded = message.len().next_multiple_of(8);
        // It fits: the longest body is a multiple of 8.
        let _ = message.resize(padded, 0);
        message
    }

    /// Returns the description of a sender; a name is cut at [`MOST_NAME_BYTES`].
    pub fn sender(&mut self, time: Micros, id: i32, name: &str) -> Vec<u8, LONGEST_ENCODED> {
        self.description(time, [id, SENDER], name)
    }

    /// Returns the description of a type, cut likewise.
    pub fn kind(&mut self, time: Micros, id: i32, name: &str) -> Vec<u8, LONGEST_ENCODED> {
        self.description(time, [id, TYPE], name)
    }

    fn description(&mut self, time: Micros, ids: [i32; 2], name: &str) -> Vec<u8, LONGEST_ENCODED> {
        let name = name.as_bytes();
        let name = name.get(..MOST_NAME_BYTES).unwrap_or(name);
        let length = (name.len() as u32 + 1).to_be_bytes();
        let body = length.into_iter().chain(name.iter().copied()).chain([0]);
        let body: Vec<u8, { MOST_NAME_BYTES + 5 }> = body.collect();
        self.message(time, ids, &body)
    }

    /// Returns the pose of a sample; what it lacks is the origin and no rotation.
    pub fn pose(
        &mut self,
        time: Micros,
        ids: [i32; 2],
        sample: &Sample,
    ) -> Vec<u8, LONGEST_ENCODED> {
        let place = sample.head.position.map_or(Vec3::ZERO, |p| p.value);
        let turn = sample.head.orientation.map_or(Quat::IDENTITY, |q| q.value);
        let sensor = [i32::from(sample.sensor); 2];
        let sensor = sensor.into_iter().flat_map(i32::to_be_bytes);
        let numbers = place.to_array().into_iter().chain(turn.to_array());
        let numbers = numbers.flat_map(|number| f64::from(number).to_be_bytes());
        let body: Vec<u8, POSE_BYTES> = sensor.chain(numbers).collect();
        self.message(time, ids, &body)
    }
}
