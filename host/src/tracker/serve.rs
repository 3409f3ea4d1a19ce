//! The device's end of a line: samples out, as a device writes them, and the
//! host's commands in.

use super::protocol::Protocol;
use super::pty::Pty;
use shisen_tracker::mock::{Device, Source, Wire};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::io;
use std::time::{Duration, Instant};

/// Serves a line from a source of samples by the clock on the wall, for as
/// long as `goes_on` says so; it is told the time and how many records were sent.
///
/// # Errors
/// Those of the line.
pub fn serve(
    pty: &mut Pty,
    source: impl Source<Item = Sample>,
    protocol: &Protocol,
    goes_on: &mut dyn FnMut(Micros, u64) -> bool,
) -> io::Result<()> {
    let mut wire = Wire::new(source, protocol.format().clone());
    let mut device = Device::new(protocol.format());
    let start = Instant::now();
    let mut sent = 0;
    loop {
        let now = Micros(start.elapsed().as_micros() as u64);
        if !goes_on(now, sent) {
            return Ok(());
        }
        let mut heard = [0; 256];
        let count = pty.receive(&mut heard)?;
        let mut answers = Vec::new();
        device.feed(&heard[..count], now, &mut |answer| {
            answers.extend_from_slice(answer);
        });
        if device.format() != wire.format() {
            wire.set_format(device.format().clone());
        }
        if !answers.is_empty() {
            pty.send(&answers)?;
        }
        while let Some(sample) = wire.source().poll(now) {
            let measured = device.measure(&sample);
            if let Some(chunk) = measured.and_then(|sample| wire.encode(&sample)) {
                sent += u64::from(pty.send(chunk.bytes())?);
            }
        }
        std::thread::sleep(Duration::from_micros(500));
    }
}
