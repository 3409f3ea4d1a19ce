//! From bytes to the content of a frame and back: delimiters, COBS, CRC.

use super::{HEADER_LENGTH, VERSION};
use crate::decoder::DropReason;
use core::marker::PhantomData;
use crc::{CRC_16_IBM_3740, Crc};
use heapless::Vec;

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
const CRC_LENGTH: usize = 2;

/// Both words of bits, the sensor, and every field of a sample.
const LONGEST_BODY: usize = 4 + 4 + 1 + 8 + 8 + 4 + 12 + 16 + 12 + 3 * (12 + 12 + 4 + 4) + 8;
const LONGEST_CONTENT: usize = HEADER_LENGTH + LONGEST_BODY + CRC_LENGTH;

/// Most bytes of a frame, with both its delimiters; COBS adds one byte below 254.
pub const LONGEST_FRAME: usize = LONGEST_CONTENT + 3;
const _: () = assert!(LONGEST_CONTENT < 254);

/// Bytes that form no frame are reported after this many at the latest.
const LONGEST_RUN: u32 = 256;

const DELIMITER: u8 = 0;

/// The bytes of a frame.
pub type Frame = Vec<u8, LONGEST_FRAME>;

/// A frame that is being written, in its own place.
#[derive(Debug, Clone)]
pub(super) struct Content(Frame);

/// Bytes of a frame before its content.
const LEAD: usize = 2;

impl Content {
    /// With nothing in it.
    pub(super) fn new() -> Self {
        let mut frame = Frame::new();
        // The second byte will say where the first zero was.
        let _ = frame.extend_from_slice(&[DELIMITER; LEAD]);
        Self(frame)
    }

    /// Appends bytes; all fit, as no content is longer than a sample's.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        let _ = self.0.extend_from_slice(bytes);
    }

    /// Returns the frame.
    pub(super) fn finish(mut self) -> Frame {
        let crc = CRC.checksum(self.0.get(LEAD..).unwrap_or_default());
        self.push(&crc.to_le_bytes());
        // Each zero becomes the distance to the next, the end being one too.
        let mut next = 0u8;
        for byte in self.0.iter_mut().skip(1).rev() {
            next = next.wrapping_add(1);
            if *byte == DELIMITER {
                *byte = next;
                next = 0;
            }
        }
        let _ = self.0.push(DELIMITER);
        self.0
    }
}

/// The bytes between two delimiters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Received<'f> {
    /// How many bytes, without the delimiters.
    pub(super) bytes: u32,
    /// Their content without the CRC, and that.
    pub(super) content: Result<(&'f [u8], u16), DropReason>,
}

/// The frame that is coming in.
#[derive(Debug, Clone, Default)]
pub(super) struct Frames {
    content: Vec<u8, LONGEST_CONTENT>,
    /// How many bytes there are since the delimiter.
    bytes: u32,
    /// How many bytes there are before the next that counts some.
    left: u8,
    /// It holds more than a frame can.
    too_long: bool,
    /// Its delimiter has come: the next byte is another frame's.
    ended: bool,
}

impl Frames {
    /// Takes the next byte; the frame that it ends, or a run of bytes that form none.
    pub(super) fn push(&mut self, byte: u8) -> Option<Received<'_>> {
        if self.ended {
            *self = Self::default();
        }
        if byte == DELIMITER {
            self.ended = true;
            return (self.bytes > 0).then(|| Received {
                bytes: self.bytes,
                content: self.content(),
            });
        }
        if self.left > 0 {
            self.left -= 1;
            self.too_long |= self.content.push(byte).is_err();
        } else {
            // No zero stands before the first block.
            if self.bytes > 0 {
                self.too_long |= self.content.push(0).is_err();
            }
            self.left = byte - 1;
        }
        self.bytes += 1;
        if self.bytes < LONGEST_RUN {
            return None;
        }
        let bytes = core::mem::take(&mut self.bytes);
        Some(Received {
            bytes,
            content: Err(DropReason::Length),
        })
    }

    /// Once its delimiter has come.
    fn content(&self) -> Result<(&[u8], u16), DropReason> {
        if self.too_long {
            return Err(DropReason::Length);
        }
        if self.left > 0 {
            return Err(DropReason::Truncated);
        }
        let (bytes, crc) = self
            .content
            .split_last_chunk::<CRC_LENGTH>()
            .ok_or(DropReason::Length)?;
        let crc = u16::from_le_bytes(*crc);
        if CRC.checksum(bytes) != crc {
            return Err(DropReason::Checksum);
        }
        Ok((bytes, crc))
    }

    /// Forgets an incomplete frame; returns its number of bytes.
    pub(super) fn reset(&mut self) -> u32 {
        let bytes = if self.ended { 0 } else { self.bytes };
        *self = Self::default();
        bytes
    }
}

/// A message that one side of a link sends: the content of a frame.
pub trait LinkMessage: Sized {
    /// Reads the message of a frame's kind and body.
    ///
    /// # Errors
    /// Another side's kind, or a body that does not fit it.
    fn read(kind: u8, body: &[u8]) -> Result<Self, DropReason>;
}

/// The decoder of one side's messages; it counts and skips damaged and other frames.
#[derive(Debug, Clone)]
pub struct Listener<T> {
    frames: Frames,
    dropped: u32,
    messages: PhantomData<T>,
}

impl<T: LinkMessage> Listener<T> {
    /// Returns a decoder that has received nothing.
    #[allow(
        clippy::new_without_default,
        reason = "a derived default would ask for one of T"
    )]
    pub fn new() -> Self {
        Self {
            frames: Frames::default(),
            dropped: 0,
            messages: PhantomData,
        }
    }

    /// Takes the next bytes and hands their messages to `sink`.
    pub fn feed(&mut self, bytes: &[u8], sink: &mut dyn FnMut(T)) {
        for &byte in bytes {
            let Some(Received { content, .. }) = self.frames.push(byte) else {
                continue;
            };
            let read = content.and_then(|(content, _)| match content {
                [VERSION, kind, _, body @ ..] => T::read(*kind, body),
                _ => Err(DropReason::Unknown),
            });
            match read {
                Ok(it) => sink(it),
                Err(_) => self.dropped = self.dropped.saturating_add(1),
            }
        }
    }

    /// Returns the number of frames that were skipped.
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn received(bytes: &[u8]) -> std::vec::Vec<(u32, Result<std::vec::Vec<u8>, DropReason>)> {
        let mut frames = Frames::default();
        bytes
            .iter()
            .filter_map(|&byte| {
                let received = frames.push(byte)?;
                Some((
                    received.bytes,
                    received.content.map(|content| content.0.to_vec()),
                ))
            })
            .collect()
    }

    #[test]
    fn the_crc_is_the_catalogues() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29B1);
    }

    #[test]
    fn zeros_are_encoded_away() {
        for content in [
            &[0, 0, 0][..],
            &[1, 2, 3],
            &[0, 1, 0],
            &[],
            &[7; LONGEST_CONTENT - CRC_LENGTH],
            &[0; LONGEST_CONTENT - CRC_LENGTH],
        ] {
            let mut written = Content::new();
            written.push(content);
            let frame = written.finish();
            assert_eq!((frame[0], frame[frame.len() - 1]), (0, 0));
            assert!(frame[1..frame.len() - 1].iter().all(|&byte| byte != 0));
            assert_eq!(frame.len(), content.len() + CRC_LENGTH + 3);
            let expected = (frame.len() as u32 - 2, Ok(content.to_vec()));
            assert_eq!(received(&frame), [expected]);
        }
    }

    #[test]
    fn damage_is_named() {
        let of = |bytes: &[u8]| received(bytes).remove(0).1.unwrap_err();
        assert_eq!(of(&[3, 1, 0]), DropReason::Truncated);
        assert_eq!(of(&[2, 1, 0]), DropReason::Length);
        assert_eq!(of(&[5, 1, 2, 3, 4, 0]), DropReason::Checksum);
        assert_eq!(of(&[&[1; 200][..], &[0]].concat()), DropReason::Length);
        assert_eq!(received(&[0, 0, 0]), []);
    }

    #[test]
    fn a_line_without_delimiters_is_told_of() {
        let found = received(&[&[9; 600][..], &[0]].concat());
        assert_eq!(
            found,
            [256, 256, 88].map(|bytes| (bytes, Err(DropReason::Length)))
        );
    }
}
