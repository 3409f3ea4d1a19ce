//! The device's end of a line: samples out, as a device writes them, and the
//! host's commands in.

use super::protocol::Protocol;
use super::pty::Pty;
use shisen_tracker::mock::{Line, Source};
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
    let mut line = Line::new(source, protocol.format());
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
        line.hear(&heard[..count], now, &mut |answer| {
            answers.extend_from_slice(answer);
        });
        if !answers.is_empty() {
            pty.send(&answers)?;
        }
        while let Some(record) = line.poll(now) {
            sent += u64::from(pty.send(record.bytes())?);
        }
        std::thread::sleep(Duration::from_micros(500));
    }
}
