//! A serial port on `embedded-io`, served without waiting.
//!
//! - [`HostEnd`] commands the device and reads it, a step of a loop at a time;
//! - [`drain`] only reads, where there is nothing to say or nothing to say it with;
//! - `DeviceEnd`, with the feature `mock`, is the other end of the line, played by a
//!   simulated device.

#[cfg(any(feature = "mock", test))]
mod device_end;
#[cfg(test)]
mod doubles;
mod host_end;

#[cfg(any(feature = "mock", test))]
pub use device_end::DeviceEnd;
pub use host_end::{Due, HostEnd};

use crate::decoder::{Decoder, Event};
use crate::time::Micros;
use embedded_io::{Read, ReadReady};

/// Bytes that are read at once.
const CHUNK: usize = 32;

/// Feeds what a port has received by `now` to a decoder, until nothing is ready, the port is at
/// its end, or `most` bytes or a few more have been read. Returns how many were; `most` or more
/// means that there may be others.
///
/// # Errors
/// Those of the port. The decoder forgets the record under way, and the next call goes on.
pub fn drain<P: Read + ReadReady>(
    port: &mut P,
    decoder: &mut (impl Decoder + ?Sized),
    now: Micros,
    most: usize,
    sink: &mut dyn FnMut(Event),
) -> Result<usize, P::Error> {
    let mut total = 0;
    let mut chunk = [0; CHUNK];
    let mut read_some = || -> Result<usize, P::Error> {
        Ok(if port.read_ready()? {
            port.read(&mut chunk)
                .inspect(|&read| decoder.feed(chunk.get(..read).unwrap_or_default(), now, sink))?
        } else {
            0
        })
    };
    while total < most {
        match read_some() {
            Ok(0) => break,
            Ok(read) => total += read,
            Err(error) => {
                decoder.reset();
                return Err(error);
            }
        }
    }
    Ok(total)
}

#[cfg(test)]
mod tests {
    use super::doubles::End;
    use super::*;
    use crate::eye::asl::{Asl, LONGEST_FRAME};
    use embedded_io::ErrorKind;

    const FRAME: [u8; LONGEST_FRAME] = [
        0x80, 0x00, 0x7F, 0x01, 0x70, 0x00, 0x7F, 0x56, 0x7B, 0x01, 0x2C, 0x01,
    ];

    fn drained(
        port: &mut End,
        decoder: &mut Asl,
        most: usize,
    ) -> (Result<usize, ErrorKind>, usize) {
        let mut samples = 0;
        let read = drain(port, decoder, Micros(5), most, &mut |event| {
            if let Event::Sample(sample) = event {
                assert_eq!(sample.arrival, Micros(5));
                samples += 1;
            }
        });
        (read, samples)
    }

    fn port(bytes: &[u8]) -> End {
        End {
            received: bytes.iter().copied().collect(),
            ..End::default()
        }
    }

    /// A fast line does not hold the caller up, nor one that has ended.
    #[test]
    fn what_is_ready_is_read() {
        let (mut port, mut decoder) = (port(&FRAME.repeat(100)), Asl::default());
        assert_eq!(drained(&mut port, &mut decoder, 100).0, Ok(128));
        assert_eq!(
            drained(&mut port, &mut decoder, 5_000),
            (Ok(1_200 - 128), 90)
        );
        assert_eq!(drained(&mut port, &mut decoder, 1_000), (Ok(0), 0));
        port.ended = true;
        assert_eq!(drained(&mut port, &mut decoder, usize::MAX), (Ok(0), 0));
    }

    #[test]
    fn after_an_overrun_the_decoder_begins_anew() {
        let (mut port, mut decoder) = (port(&FRAME[..7]), Asl::default());
        assert_eq!(drained(&mut port, &mut decoder, 1_000), (Ok(7), 0));
        port.received.extend(&FRAME[7..]);
        port.received.extend(FRAME.repeat(2));
        port.broken = true;
        let overrun = Err(ErrorKind::BrokenPipe);
        assert_eq!(drained(&mut port, &mut decoder, 1_000), (overrun, 0));
        port.broken = false;
        assert_eq!(drained(&mut port, &mut decoder, 1_000), (Ok(29), 2));
    }
}
