//! A simulated tracker at a serial port on `embedded-io`: one board plays the
//! device for another, or for itself over a looped line.

use super::CHUNK;
use crate::mock::{Line, Source};
use crate::sample::Sample;
use crate::time::Micros;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use heapless::Deque;

/// Bytes that wait until the port takes them: a few records.
const WAITING: usize = 512;

/// The device's end of a line at a port, served without waiting.
///
/// What a host says is heard, and answered; records that there is no room for, as
/// the port is slower than they come, are dropped whole and counted.
#[derive(Debug, Clone)]
pub struct DeviceEnd<S> {
    line: Line<S>,
    waiting: Deque<u8, WAITING>,
    sent: u64,
    dropped: u64,
}

impl<S: Source<Item = Sample>> DeviceEnd<S> {
    /// Of this device.
    pub const fn new(line: Line<S>) -> Self {
        Self {
            line,
            waiting: Deque::new(),
            sent: 0,
            dropped: 0,
        }
    }

    /// The device.
    pub const fn line(&self) -> &Line<S> {
        &self.line
    }

    /// Records and answers that were handed to the port, or wait for it.
    pub const fn sent(&self) -> u64 {
        self.sent
    }

    /// Records and answers that there was no room for.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Reads what the port has received by `now`, at most `most` bytes or a few
    /// more, and writes what the port takes of what is due; to be called again
    /// before long.
    ///
    /// # Errors
    /// Those of the port; what was not written yet waits for the next call.
    pub fn serve<P>(&mut self, port: &mut P, now: Micros, most: usize) -> Result<(), P::Error>
    where
        P: Read + ReadReady + Write + WriteReady,
    {
        let mut heard = 0;
        let mut chunk = [0; CHUNK];
        while heard < most && port.read_ready()? {
            let read = port.read(&mut chunk)?;
            if read == 0 {
                break;
            }
            heard += read;
            let (waiting, sent, dropped) = (&mut self.waiting, &mut self.sent, &mut self.dropped);
            let bytes = chunk.get(..read).unwrap_or_default();
            self.line.hear(bytes, now, &mut |answer| {
                *(if queue(waiting, answer) {
                    &mut *sent
                } else {
                    &mut *dropped
                }) += 1;
            });
        }
        self.write(port)?;
        while let Some(record) = self.line.poll(now) {
            if queue(&mut self.waiting, record.bytes()) {
                self.sent += 1;
            } else {
                self.dropped += 1;
            }
            self.write(port)?;
        }
        Ok(())
    }

    fn write<P: Write + WriteReady>(&mut self, port: &mut P) -> Result<(), P::Error> {
        loop {
            let (first, _) = self.waiting.as_slices();
            if first.is_empty() || !port.write_ready()? {
                return Ok(());
            }
            let written = port.write(first)?;
            if written == 0 {
                return Ok(());
            }
            for _ in 0..written {
                let _ = self.waiting.pop_front();
            }
        }
    }
}

/// Whether all of it had room; if not, none of it waits.
fn queue(waiting: &mut Deque<u8, WAITING>, bytes: &[u8]) -> bool {
    if bytes.len() > WAITING - waiting.len() {
        return false;
    }
    bytes.iter().all(|&byte| waiting.push_back(byte).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Action, Session};
    use crate::decoder::{Decoder, Event};
    use crate::head::fastrak::{self, Fastrak};
    use crate::head::polhemus::{Family, Format as Written, ItemList};
    use crate::mock::{Format, Tracker, TrackerConfig, Viewer, ViewerConfig};
    use crate::uart::drain;
    use embedded_io::{ErrorKind, ErrorType};
    use std::collections::VecDeque;
    use std::vec::Vec;

    /// One end of a line that takes `room` more bytes.
    #[derive(Default)]
    struct End {
        received: VecDeque<u8>,
        sent: VecDeque<u8>,
        room: usize,
        broken: bool,
    }

    impl ErrorType for End {
        type Error = ErrorKind;
    }

    impl ReadReady for End {
        fn read_ready(&mut self) -> Result<bool, ErrorKind> {
            Ok(!self.received.is_empty())
        }
    }

    impl Read for End {
        fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
            assert!(
                !self.received.is_empty(),
                "the port was read while it was not ready"
            );
            let count = buffer.len().min(self.received.len());
            for byte in &mut buffer[..count] {
                *byte = self.received.pop_front().unwrap();
            }
            Ok(count)
        }
    }

    impl WriteReady for End {
        fn write_ready(&mut self) -> Result<bool, ErrorKind> {
            Ok(self.room > 0 || self.broken)
        }
    }

    impl Write for End {
        fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
            if self.broken {
                return Err(ErrorKind::BrokenPipe);
            }
            assert!(self.room > 0, "the port was written while it was not ready");
            let count = bytes.len().min(self.room);
            self.sent.extend(&bytes[..count]);
            self.room -= count;
            Ok(count)
        }

        fn flush(&mut self) -> Result<(), ErrorKind> {
            Ok(())
        }
    }

    /// Position and quaternion, in binary.
    fn config() -> fastrak::Config {
        let items = ItemList::new(Family::Fastrak, Written::Binary, &[2, 11, 0]);
        fastrak::Config::new(items.unwrap())
    }

    fn device(config: &fastrak::Config) -> DeviceEnd<Tracker<'static>> {
        let viewer = Viewer::new(ViewerConfig::default(), 5);
        let tracker = Tracker::new(TrackerConfig::default(), viewer, 5).unwrap();
        DeviceEnd::new(Line::new(tracker, &Format::Fastrak(config.clone())))
    }

    /// A host sets the device up over two ports and stops it, all by this crate.
    #[test]
    fn a_host_at_the_other_end_is_served() {
        let config = config();
        let mut device = device(&config);
        let (mut far, mut near) = (End::default(), End::default());
        let mut decoder = Fastrak::new(config.clone());
        let mut session = Session::new(config.start(false));
        let mut samples = Vec::new();
        let mut stopped_at = None;
        for ms in 0..3_000 {
            let now = Micros::from_millis(ms);
            if let Action::Send(bytes) = session.poll(now) {
                far.received.extend(bytes);
            }
            // 115,200 baud.
            far.room = 11;
            device.serve(&mut far, now, 64).unwrap();
            near.received.append(&mut far.sent);
            drain(&mut near, &mut decoder, now, 64, &mut |event| {
                session.on_event(&event);
                if let Event::Sample(sample) = event {
                    samples.push(sample.arrival);
                }
            })
            .unwrap();
            if ms == 2_000 {
                assert_eq!(session.poll(now), Action::Done);
                assert!(device.line().device().streams());
                session = Session::new(fastrak::stop());
            }
            if !device.line().device().streams() && ms > 2_000 {
                stopped_at = stopped_at.or(Some(now));
            }
        }
        let stopped = stopped_at.unwrap();
        assert!(stopped <= Micros::from_millis(2_002), "{stopped:?}");
        assert!(samples.len() > 200, "{}", samples.len());
        // What waited is all that came after it.
        let last = *samples.last().unwrap();
        assert!(last < stopped.after(Micros::from_millis(60)), "{last:?}");
        assert_eq!(decoder.counts().dropped_bytes, 0);
    }

    /// A line that is too slow loses whole records, none of them in part.
    #[test]
    fn what_has_no_room_is_dropped_whole() {
        let config = config();
        let mut device = device(&config);
        let mut decoder = Fastrak::new(config);
        let (mut far, mut near) = (End::default(), End::default());
        let mut samples = 0;
        for ms in 0..5_000 {
            far.room = 1;
            device.serve(&mut far, Micros::from_millis(ms), 64).unwrap();
            near.received.append(&mut far.sent);
            drain(
                &mut near,
                &mut decoder,
                Micros::from_millis(ms),
                64,
                &mut |event| {
                    samples += u64::from(matches!(event, Event::Sample(_)));
                },
            )
            .unwrap();
        }
        assert!(device.dropped() > 1_000, "{}", device.dropped());
        assert!(samples > 100 && samples <= device.sent(), "{samples}");
        assert_eq!(decoder.counts().dropped_bytes, 0);
    }

    #[test]
    fn an_error_of_the_port_is_handed_on_and_loses_nothing() {
        let mut device = device(&config());
        let mut far = End {
            broken: true,
            ..End::default()
        };
        let now = Micros::from_millis(10);
        assert_eq!(device.serve(&mut far, now, 64), Err(ErrorKind::BrokenPipe));
        (far.broken, far.room) = (false, 10_000);
        device.serve(&mut far, now, 64).unwrap();
        assert_eq!(device.dropped(), 0);
        assert_eq!(&far.sent.make_contiguous()[..2], b"01");
    }
}
