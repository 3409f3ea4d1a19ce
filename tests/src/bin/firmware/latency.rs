//! From the last byte of a new gaze to the first tile that follows it.

use crate::{Bench, PaperScene, Wrong, check, paper};
use shisen_tracker::mock::{Format, Wire};

/// Instructions of a millisecond of a processor of 400 MHz that takes one a cycle.
const MILLISECOND: f64 = 400e3;

impl Bench {
    /// Scene A, and a tracker that moves: at 120 Hz and at 1,000.
    pub(crate) fn latency(&self) -> Result<String, Wrong> {
        let scene = paper(PaperScene::A);
        let mut said = Vec::new();
        for (rate, row) in [("120", "latency_at_120_hz"), ("1000", "latency_at_1000_hz")] {
            let spec = format!("mock:seed=5&rate={rate}").parse();
            let spec = spec.map_err(|error: shisen::tracker::SpecError| error.to_string())?;
            let shisen::tracker::Spec::Mock(spec) = spec else {
                return Err("no mock".to_owned());
            };
            let tracker = shisen::tracker::simulated(&spec).map_err(|error| error.to_string())?;
            let mut run = self.run(
                scene.as_bytes(),
                Some(Box::new(Wire::new(tracker, Format::Link))),
            );
            run.frames = 6;
            // The line is looked at often, as a board with a fast tracker would.
            run.rendering.slice = 500;
            let watched = self.same(&scene, run)?;
            let done = watched.frames.iter().filter_map(|frame| frame.done);
            let done: Vec<_> = done.filter(|done| done.latency > 0).collect();
            check(done.len() >= 3, "hardly a frame had a new gaze")?;
            let most = |of: fn(&shisen_tracker::link::display::FrameDone) -> u32| {
                u64::from(done.iter().map(of).max().unwrap_or(0))
            };
            let waited = most(|done| done.age);
            let to_tile = most(|done| done.latency - done.age);
            let sent = most(|done| done.sent - done.age);
            let all = most(|done| done.latency);
            let least = u64::from(done.iter().map(|done| done.latency).min().unwrap_or(0));
            let limit = self.limits.gaze_to_tile;
            check(
                to_tile <= limit,
                &format!("{to_tile} instructions from gaze to tile, more than {limit}"),
            )?;
            let ms = |instructions: u64| instructions as f64 / MILLISECOND;
            said.push(format!(
                "at {rate} Hz {all} instructions ({:.2} ms) at most and {least} at least: up to {waited} \
                 ({:.2} ms) while the frame before is finished, then up to {to_tile} ({:.2} ms) from \
                 gaze to tile, {sent} until it is sent",
                ms(all),
                ms(waited),
                ms(to_tile),
            ));
            self.measured.add(&[(row, all)])?;
            if rate == "120" {
                self.measured
                    .add(&[("gaze_to_tile", to_tile), ("byte_to_gaze", waited)])?;
            }
        }
        Ok(said.join("; "))
    }
}
