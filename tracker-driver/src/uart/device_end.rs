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

/// The device's end of a line at a port, served without waiting: it hears and answers the host.
/// Records that the port has no room for are dropped whole and counted.
#[derive(Debug, Clone)]
pub struct DeviceEnd<S> {
    line: Line<S>,
    queue: Queue,
}

/// What waits for the port, and what became of all that was to be sent.
#[derive(Debug, Clone)]
struct Queue {
    waiting: Deque<u8, WAITING>,
    sent: u64,
    dropped: u64,
}

impl<S: Source<Item = Sample>> DeviceEnd<S> {
    /// Returns the end of this device's line.
    pub const fn new(line: Line<S>) -> Self {
        Self {
            line,
            queue: Queue {
                waiting: Deque::new(),
                sent: 0,
                dropped: 0,
            },
        }
    }

    /// Returns the device.
    pub const fn line(&self) -> &Line<S> {
        &self.line
    }

    /// Records and answers that were handed to the port, or wait for it.
    pub const fn sent(&self) -> u64 {
        self.queue.sent
    }

    /// Records and answers that there was no room for.
    pub const fn dropped(&self) -> u64 {
        self.queue.dropped
    }

    /// Reads what the port has received by `now`, `most` bytes or a few more, and writes what
    /// it takes of what is due; to be called again before long.
    ///
    /// # Errors
    /// Those of the port; what was not written yet waits for the next call.
    pub fn serve<P>(&mut self, port: &mut P, now: Micros, most: usize) -> Result<(), P::Error>
    where
        P: Read + ReadReady + Write + WriteReady,
    {
        let Self { line, queue } = self;
        let mut heard = 0;
        let mut chunk = [0; CHUNK];
        while heard < most && port.read_ready()? {
            let read = port.read(&mut chunk)?;
            if read == 0 {
                break;
            }
            heard += read;
            let bytes = chunk.get(..read).unwrap_or_default();
            line.hear(bytes, now, &mut |answer| queue.push(answer));
        }
        queue.write(port)?;
        while let Some(record) = line.poll(now) {
            queue.push(record.bytes());
            queue.write(port)?;
        }
        Ok(())
    }
}

impl Queue {
    /// Has all of it wait, or, where it has no room, none.
    fn push(&mut self, bytes: &[u8]) {
        if bytes.len() > WAITING - self.waiting.len() {
            self.dropped += 1;
            return;
        }
        self.sent += 1;
        for &byte in bytes {
            let _ = self.waiting.push_back(byte);
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Script;
    use crate::decoder::{Decoder, Event};
    use crate::head::fastrak::{self, Config, Fastrak};
    use crate::mock::TrackerConfig;
    use crate::protocol::Protocol;
    use crate::uart::doubles::End;
    use crate::uart::{Due, HostEnd, drain};
    use embedded_io::ErrorKind;
    use std::vec::Vec;

    /// A command is written as the port takes it, none of it twice.
    #[test]
    fn a_host_does_not_wait_for_its_port() {
        let mut script = Script::sending(b"first");
        script.speed(9_600).send(b"second");
        script.expect(crate::command::Awaited::Sample, crate::command::PATIENCE);
        let mut host = HostEnd::new(Fastrak::new(Config::default()), script);
        let mut near = End::default();
        let mut ms = 0;
        let mut serve = |near: &mut End| {
            ms += 1;
            host.serve(near, Micros::from_millis(ms), 64, &mut |_| {})
        };
        let said = |near: &mut End| {
            std::mem::take(&mut near.sent)
                .into_iter()
                .collect::<Vec<_>>()
        };
        assert_eq!(serve(&mut near), Ok(Due::Room));
        near.room = 3;
        assert_eq!(serve(&mut near), Ok(Due::Room));
        assert_eq!(said(&mut near), b"fir");
        near.broken = true;
        assert_eq!(serve(&mut near), Err(ErrorKind::BrokenPipe));
        (near.broken, near.room) = (false, 3);
        // All is with the port: only now may its speed be changed.
        assert_eq!(serve(&mut near), Ok(Due::Speed(9_600)));
        assert_eq!(said(&mut near), b"st");
        near.room = 1_000;
        assert_eq!(serve(&mut near), Ok(Due::Wait(Micros::from_millis(1_005))));
        assert_eq!(said(&mut near), b"second");
        let failed = loop {
            match serve(&mut near).unwrap() {
                Due::Failed(failure) => break failure,
                Due::Wait(_) | Due::Speed(_) => {}
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(failed, crate::command::Failure::Silent);
        assert_eq!(said(&mut near), b"firstsecond".repeat(2));
        host.say(fastrak::stop());
        let done = host.serve(&mut near, Micros::from_millis(ms), 64, &mut |_| {});
        assert_eq!((done, said(&mut near)), (Ok(Due::Nothing), b"c".into()));
    }

    /// A line that is too slow loses whole records, none of them in part.
    #[test]
    fn what_has_no_room_is_dropped_whole() {
        let config = Config::default();
        let tracker = crate::testing::tracker(TrackerConfig::default(), 5);
        let line = Line::new(tracker, &Protocol::Fastrak(config.clone()));
        let (mut device, mut decoder) = (DeviceEnd::new(line), Fastrak::new(config));
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
}
