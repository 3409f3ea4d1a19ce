//! stream FILE: half a second of the simulated tracker, 120 times a second, over
//! our link, as a line brings it: a few bytes at a time.

use shisen_capi_tests::push;
use shisen_tracker::mock::{Source, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::time::Micros;
use std::error::Error;

/// Bytes of a piece, as a buffer of a serial line has them.
const BYTES: usize = 16;
/// That a piece takes on a line of 115,200 baud.
const PIECE: Micros = Micros(1_389);
const DURATION: Micros = Micros(500_000);

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("usage: stream FILE")?;
    let config = TrackerConfig {
        rate: 120,
        ..TrackerConfig::default()
    };
    let tracker = Tracker::new(config, Viewer::new(ViewerConfig::default(), 1), 1)?;
    let mut wire = Wire::new(tracker, Protocol::Link);
    let mut stream = Vec::new();
    while let Some(record) = wire.poll(DURATION) {
        let count = record.bytes().len().div_ceil(BYTES) as u64;
        for (number, bytes) in (1..).zip(record.bytes().chunks(BYTES)) {
            let left = Micros((count - number) * PIECE.0);
            push(&mut stream, record.arrival.since(left), bytes);
        }
    }
    push(&mut stream, Micros(0), &[]);
    std::fs::write(&file, stream).map_err(|error| format!("cannot write {file}: {error}"))?;
    Ok(())
}
