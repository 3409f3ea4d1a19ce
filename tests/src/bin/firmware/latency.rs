//! From the last byte of a new gaze to the first tile that follows it.

use crate::{Bench, Wrong, mock, record, sent};
use glam::Vec3;
use shisen_tests::firmware::TrackerBytes;
use shisen_tracker::link::Encoder;
use shisen_tracker::link::display::FrameDone;
use shisen_tracker::time::Micros;

/// Instructions of a millisecond of a processor of 400 MHz that takes one a cycle.
const MILLISECOND: f64 = 400e3;

impl Bench {
    /// Scene A, and a tracker that moves: at 120 Hz and at 1,000.
    pub(crate) fn latency(&self) -> Result<String, Wrong> {
        let mut said = Vec::new();
        for (rate, row) in [("120", "latency_at_120_hz"), ("1000", "latency_at_1000_hz")] {
            let tracker = mock(&format!("mock:seed=5&rate={rate}"))?;
            let watched = self.scene_a(tracker, |run| {
                run.frames = 6;
                // The line is looked at often, as a board with a fast tracker would.
                run.rendering.slice = 500;
            })?;
            let done = watched.frames.iter().filter_map(|frame| frame.done);
            let done: Vec<_> = done.filter(|done| done.latency > 0).collect();
            ensure!(done.len() >= 3, "hardly a frame had a new gaze");
            let most =
                |of: fn(&FrameDone) -> u32| u64::from(done.iter().map(of).max().unwrap_or(0));
            let waited = most(|done| done.age);
            let to_tile = most(|done| done.latency - done.age);
            let sent = most(|done| done.sent - done.age);
            let all = most(|done| done.latency);
            let least = u64::from(done.iter().map(|done| done.latency).min().unwrap_or(0));
            let limit = self.limits.gaze_to_tile;
            ensure!(
                to_tile <= limit,
                "{to_tile} instructions from gaze to tile, more than {limit}"
            );
            let ms = |instructions: u64| instructions as f64 / MILLISECOND;
            said.push(format!(
                "at {rate} Hz {all} instructions ({:.2} ms) at most and {least} at least: up to {waited} \
                 ({:.2} ms) while the frame before is finished, then up to {to_tile} ({:.2} ms) from \
                 gaze to tile, {sent} until it is sent",
                ms(all),
                ms(waited),
                ms(to_tile),
            ));
            self.measured.add(row, all)?;
            if rate == "120" {
                self.measured.add("gaze_to_tile", to_tile)?;
                self.measured.add("byte_to_gaze", waited)?;
            }
        }
        Ok(said.join("; "))
    }

    /// Returns a viewer whose eyes leap while frames are rendered: these are cut short, and the
    /// next ones begin where the viewer looks.
    pub(crate) fn restarts(&self) -> Result<String, Wrong> {
        let run = |frames, restart_angle: f32| {
            let watched = self.scene_a(leaps(), |run| {
                run.frames = frames;
                (run.rendering.slice, run.rendering.restart_angle) = (500, restart_angle);
            })?;
            let done = watched.frames.iter().map(|frame| frame.done);
            let done: Vec<FrameDone> = done.collect::<Option<_>>().ok_or("no end")?;
            ensure!(
                done.iter().all(|one| one.cut_short || one.whole == TILES),
                "a frame has not the tiles that it says"
            );
            Ok::<_, Wrong>(done)
        };
        let never = run(6, 0.0)?;
        ensure!(
            never.iter().all(|done| !done.cut_short),
            "a frame was cut short, and none should be"
        );
        // Frames begin anew a few times.
        let done = run(24, 5f32.to_radians())?;
        let after_a_cut = done.windows(2).filter(|pair| pair[0].cut_short);
        let latencies: Vec<u64> = after_a_cut.map(|pair| pair[1].latency.into()).collect();
        ensure!(latencies.len() >= 3, "hardly a frame was cut short");
        ensure!(!latencies.contains(&0), "a frame was cut short for nothing");
        let most = latencies.iter().copied().max().unwrap_or(0);
        let limit = self.limits.restart;
        ensure!(
            most <= limit,
            "{most} instructions from a leap's last byte to its tile, more than {limit}"
        );
        // Eyes that are elsewhere in each record: no more than three in a row.
        let restless = run(12, 1e-6)?;
        let in_a_row = restless.split(|done| !done.cut_short).map(<[_]>::len);
        let in_a_row = in_a_row.max().unwrap_or(0);
        ensure!(in_a_row == 3, "{in_a_row} were cut short in a row");
        self.measured.add("restart", most)?;
        Ok(format!(
            "of {} frames {} were cut short; {most} instructions ({:.2} ms) at most from the last \
             byte to the first tile",
            done.len(),
            latencies.len(),
            most as f64 / MILLISECOND,
        ))
    }
}

/// Tiles of a frame of three walls of 64² pixels.
const TILES: u32 = 48;

/// Returns a viewer at rest whose eyes leap from one side to the other, and a tracker at 120 Hz.
fn leaps() -> TrackerBytes {
    /// Records from leap to leap.
    const STAY: u64 = 11;
    let step = Micros(8_333);
    let mut encoder = Encoder::new();
    sent(step, move |time| {
        let is_left = (time.0 / step.0 / STAY).is_multiple_of(2);
        let gaze = Vec3::new(if is_left { -0.3 } else { 0.3 }, 0.0, -1.0);
        record(&mut encoder, time, Vec3::ZERO, glam::Quat::IDENTITY, gaze)
    })
}
