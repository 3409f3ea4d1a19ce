//! Pieces of a recorded stream: a time of arrival (u64, microseconds), a length
//! (u32), the bytes; little-endian. A piece of length 0 is the end.

use shisen_tracker::time::Micros;

/// Adds a piece.
pub fn push(stream: &mut Vec<u8>, arrival: Micros, bytes: &[u8]) {
    let length = u32::try_from(bytes.len()).expect("pieces are short");
    stream.extend_from_slice(&arrival.0.to_le_bytes());
    stream.extend_from_slice(&length.to_le_bytes());
    stream.extend_from_slice(bytes);
}

/// Returns the pieces of a stream.
pub fn pieces(mut stream: &[u8]) -> impl Iterator<Item = (Micros, &[u8])> {
    std::iter::from_fn(move || {
        let (arrival, rest) = stream.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let (bytes, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        stream = rest;
        let arrival = Micros(u64::from_le_bytes(*arrival));
        (!bytes.is_empty()).then_some((arrival, bytes))
    })
}
