//! A firmware's loop: a tracker at a serial port is told what to send, and read, a step at
//! a time.
//!
//! ```sh
//! cargo run -p shisen-tracker --features mock,uart --example uart_loop
//! ```
//!
//! The port is one on `embedded-io`. Here it is two queues, at whose other end the mock
//! plays a FASTRAK that was left in another format; on a board it is the chip's, and
//! `now` its timer. Each turn of the loop takes a millisecond, in which the line passes 11
//! bytes. Nothing in it waits.

use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use shisen_tracker::decoder::{Decoder as _, Event};
use shisen_tracker::head::fastrak::{Config, Fastrak};
use shisen_tracker::head::polhemus::{Family, Format, ItemList};
use shisen_tracker::mock::{Line, Tracker, TrackerConfig, Viewer, ViewerConfig};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::time::Micros;
use shisen_tracker::uart::{DeviceEnd, Due, HostEnd};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::error::Error;

/// What a port of 115,200 baud passes in a millisecond.
const BYTES_PER_MS: usize = 11;
/// Most bytes that a turn of the loop reads.
const MOST: usize = 64;

/// A port: what it has received, and what it is to send.
#[derive(Default)]
struct Port {
    received: VecDeque<u8>,
    sent: VecDeque<u8>,
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.received.is_empty())
    }
}

impl Read for Port {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let count = buffer.len().min(self.received.len());
        for (to, from) in buffer.iter_mut().zip(self.received.drain(..count)) {
            *to = from;
        }
        Ok(count)
    }
}

impl WriteReady for Port {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.sent.len() < BYTES_PER_MS)
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let count = bytes.len().min(BYTES_PER_MS - self.sent.len());
        self.sent.extend(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // What the board asks for: positions and quaternions, in binary. The device was left
    // with positions and angles in ASCII.
    let wanted = Config::new(ItemList::new(Family::Fastrak, Format::Binary, &[2, 11, 0])?);
    let left = Config::new(ItemList::new(Family::Fastrak, Format::Ascii, &[2, 4, 1])?);
    let mut tracker = HostEnd::new(Fastrak::new(wanted.clone()), wanted.start(false));
    let mut port = Port::default();

    let viewer = Viewer::new(ViewerConfig::default(), 7);
    let config = TrackerConfig {
        rate: 120,
        ..TrackerConfig::default()
    };
    let head = Tracker::new(config, viewer, 7)?;
    let mut device = DeviceEnd::new(Line::new(head, &Protocol::Fastrak(left)));
    let mut far = Port::default();

    let (mut samples, mut set_up) = (0, None);
    for ms in 0..3_000 {
        let now = Micros::from_millis(ms);
        device.serve(&mut far, now, MOST)?;
        port.received.append(&mut far.sent);

        let due = tracker.serve(&mut port, now, MOST, &mut |event| match event {
            // What came before it was set up may be in other units.
            Event::Sample(_) if set_up.is_some() => samples += 1,
            Event::Message(message) => println!("the device says {message:?}"),
            _ => {}
        })?;
        if set_up.is_none() && tracker.is_complete() {
            set_up = Some(ms);
        }
        match due {
            // On a board: flush the port, then set its speed.
            Due::Speed(baud) => println!("the line changes to {baud} baud"),
            Due::Failed(failure) => return Err(failure.into()),
            Due::Room | Due::Wait(_) | Due::Nothing => {}
        }

        far.received.append(&mut port.sent);
    }
    let set_up = set_up.ok_or("it was not set up")?;
    let dropped = tracker.decoder().counts().dropped_bytes;
    println!("set up after {set_up} ms; {samples} samples since, {dropped} bytes dropped");
    assert!(samples > 300);
    Ok(())
}
