//! The record of each frame and the report of a session.

use crate::live::governor::Allowance;
use crate::live::latency::{FrameRecord, Latencies};
use crate::live::quality::Quality;
use crate::live::swap::{Order, Waits};
use hdrhistogram::Histogram;
use schemars::JsonSchema;
use serde::Serialize;

/// The report of a session.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct SessionReport {
    /// Frames shown.
    pub frames: u64,
    /// Frames that missed their refresh, or the end of a longer budget.
    pub late_frames: u64,
    /// Frames that took more steps than their budget of steps.
    pub over_budget_frames: u64,
    /// Frames that took longer than their budget of time, from taking the gaze to the last pixel.
    pub over_time_frames: u64,
    /// Frames with an unfinished tile within 5° of the line of sight, or of the head's direction
    /// if the gaze is lost.
    pub frames_with_unfinished_fovea: u64,
    /// Frames with an unfinished tile.
    pub frames_with_unfinished_tiles: u64,
    /// Frames below full quality.
    #[serde(skip)]
    pub lowered_frames: u64,
    /// Changes of quality from a frame to the next.
    pub quality_changes: u64,
    /// Frames by rung.
    #[serde(skip)]
    pub rungs: [u64; Quality::LADDER.len()],
    /// Frames whose head was where a screen is not seen: that screen was dark, or, where none is
    /// seen, the eyes stayed in place.
    pub blind_frames: u64,
    /// Frames without a tracker sample: before the first one, after the tracker was silent for
    /// longer than a gaze is held, or with eyes that it did not see. They have no latency.
    pub frames_without_gaze: u64,
    /// Samples of the tracker.
    pub samples: u64,
    /// Samples not used, because a sensor sent 2,000 a second or more.
    pub passed_over_samples: u64,
    /// Refreshes until the last frame.
    pub refreshes: u64,
    /// Seconds of a frame in full; `None` unless the budget is a part of it.
    #[serde(skip)]
    pub plain_seconds: Option<f64>,
    /// Median of the steps that frames took.
    pub median_steps: u64,
    /// Median share of the budget that frames took; null without a budget.
    pub spent_share: Option<f64>,
    /// Median share of the budget's steps that frames of full quality would take, as far as known.
    pub needed_share: Option<f64>,
    /// Least and greatest part of a full frame's time that was a budget, or null.
    pub plain_parts: Option<[f64; 2]>,
    /// The last frame's budget.
    #[serde(skip)]
    pub allowance: Allowance,
    /// Latencies of each stage.
    #[serde(skip)]
    pub latencies: Latencies,
    /// Time from the first frame to the last.
    pub seconds: f64,
    /// The last frame that was shown.
    #[serde(skip)]
    pub last: Option<Order>,
    /// Hashes of that frame's pictures, rendered without a limit; empty with one machine.
    #[serde(skip)]
    pub hashes: Vec<u64>,
    /// The waits of machines for each other; `None` with one machine.
    #[serde(skip)]
    pub waits: Option<Waits>,
}

impl SessionReport {
    pub(super) fn record_part(&mut self) {
        if let (Allowance::Time(time), Some(plain)) = (self.allowance, self.plain_seconds) {
            let part = time.as_secs_f64() / plain;
            let [least, most] = self.plain_parts.unwrap_or([part; 2]);
            self.plain_parts = Some([least.min(part), most.max(part)]);
        }
    }

    pub(super) fn count(&mut self, frame: &FrameRecord) {
        let by_steps = frame.budget_steps.filter(|_| frame.budget_us.is_none());
        let over = by_steps.is_some_and(|steps| frame.steps > steps);
        self.frames += 1;
        self.refreshes = frame.refresh;
        self.late_frames += u64::from(frame.late);
        self.over_budget_frames += u64::from(over);
        self.over_time_frames += u64::from(frame.over_time);
        self.frames_with_unfinished_fovea += u64::from(frame.unfinished_fovea);
        self.frames_with_unfinished_tiles += u64::from(frame.unfinished_tiles > 0);
        self.frames_without_gaze += u64::from(!frame.follows_gaze);
        self.lowered_frames += u64::from(frame.rung > 0);
        self.rungs[frame.rung] += 1;
        self.latencies.record(frame);
    }
}

const MOST: u64 = 1_000_000_000;

/// A histogram of the parts of their budgets that frames took, which takes no memory while it is filled.
pub(super) struct Shares(Option<Histogram<u64>>);

impl Shares {
    pub(super) fn new() -> Self {
        // Never an error: the bounds are constants.
        Self(Histogram::new_with_bounds(1, MOST, 3).ok())
    }

    pub(super) fn record(&mut self, share: f64) {
        if let Some(shares) = &mut self.0 {
            shares.saturating_record((share * 1.0e6) as u64);
        }
    }

    pub(super) fn median(&self) -> Option<f64> {
        let shares = self.0.as_ref().filter(|shares| !shares.is_empty())?;
        // The lower end of its class, so that a budget that was kept is not 1.0004.
        let median = shares.lowest_equivalent(shares.value_at_quantile(0.5));
        Some(median as f64 * 1.0e-6)
    }
}
