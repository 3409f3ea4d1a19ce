//! What frames were, and what all of them came to.

use crate::live::governor::Allowance;
use crate::live::latency::Latencies;
use crate::live::quality::Quality;
use crate::live::swap::Order;
use hdrhistogram::Histogram;
use serde::Serialize;

/// A frame, as it was. Times are microseconds since the tracker was opened.
#[derive(Debug, Clone, Default, Serialize)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "a table's columns, each by itself"
)]
pub struct FrameRecord {
    /// From 0.
    pub frame: u64,
    /// When it was to be on the walls: at its refresh, or at the one that ends its
    /// budget, where that is longer.
    pub due_us: u64,
    /// The number of that refresh, from 1.
    pub due_refresh: u64,
    /// The number of the refresh at which it was on the walls.
    pub refresh: u64,
    /// When its newest sample was measured.
    pub sample_us: Option<u64>,
    /// When that came.
    pub arrive_us: Option<u64>,
    /// When the gaze was taken.
    pub latch_us: u64,
    /// When the first ray started.
    pub first_ray_us: u64,
    /// When the last pixel was there.
    pub done_us: u64,
    /// When it was on the walls.
    pub present_us: u64,
    /// Whether that was at a later refresh than it was due.
    pub late: bool,
    /// Between the eyes: metres, in the room.
    pub position: [f32; 3],
    /// The line of sight.
    pub forward: [f32; 3],
    /// How much of the gaze could be relied on.
    pub state: &'static str,
    /// Whether the gaze follows the newest sample: it is known, and the tracker was not
    /// silent for longer than a gaze is held.
    pub follows_gaze: bool,
    /// What it might take from taking the gaze to the last pixel; null where its budget
    /// was no time.
    pub budget_us: Option<u64>,
    /// Whether that took longer.
    pub over_time: bool,
    /// Steps that it might take; null where there was no end. Where these are what its
    /// time was taken for, what is looked at may have taken it beyond them.
    pub budget_steps: Option<u64>,
    /// Steps that it took.
    pub steps: u64,
    /// Steps that all of it would have taken, as far as is known.
    pub need_steps: u64,
    /// The rung of quality, from 0.
    pub rung: usize,
    /// Tiles.
    pub tiles: usize,
    /// Tiles that the budget did not finish.
    pub unfinished_tiles: usize,
    /// Whether one of these is within 5° of the line of sight. Where the gaze is lost that
    /// is the head's direction, which steps are dealt out from: the viewer may look at any
    /// of the others, too.
    pub unfinished_fovea: bool,
}

/// What a session came to.
#[derive(Debug, Clone)]
pub struct SessionReport {
    /// Frames shown.
    pub frames: u64,
    /// Frames that were not there when they were due.
    pub late_frames: u64,
    /// Frames that took more steps than they might, where the budget is of steps.
    pub over_budget_frames: u64,
    /// Frames that took longer, from taking the gaze to the last pixel, than their budget
    /// says, where that is a time: also those that were there at their refresh.
    pub over_time_frames: u64,
    /// Frames with a tile within 5° of the line of sight that was not finished; where the
    /// gaze is lost, of the head's direction.
    pub frames_with_unfinished_fovea: u64,
    /// Frames with any tile that was not finished.
    pub frames_with_unfinished_tiles: u64,
    /// Frames in which quality was lowered.
    pub lowered_frames: u64,
    /// How often quality changed from a frame to the next.
    pub quality_changes: u64,
    /// Frames by rung.
    pub rungs: [u64; Quality::LADDER.len()],
    /// Frames in which the viewer could not see a screen, and the eyes stayed where
    /// they were.
    pub blind_frames: u64,
    /// Frames that followed no gaze: before the first sample, after a tracker went silent
    /// for longer than a gaze is held, or with eyes that are not seen. They are in no
    /// latency from a sample on.
    pub frames_without_gaze: u64,
    /// Samples of the tracker.
    pub samples: u64,
    /// Those of them that were not used, as there were too many.
    pub passed_over: u64,
    /// Refreshes from the first one to that of the last frame.
    pub refreshes: u64,
    /// A frame without level of detail, where a budget was scaled by it: seconds.
    pub plain_seconds: Option<f64>,
    /// Steps of a frame, the median.
    pub median_steps: u64,
    /// Of the budget, what frames took of it, the median: of time from taking the gaze
    /// to the last pixel, or of steps. `None` where there was no end.
    pub spent_share: Option<f64>,
    /// Of the steps that the budget came to, what frames of full quality would have taken
    /// as far as is known, the median. `None` where there was no end.
    pub needed_share: Option<f64>,
    /// The least and the most of [`plain_seconds`](Self::plain_seconds) that a frame's
    /// allowance was; `None` where it is no part of these.
    pub plain_parts: Option<[f64; 2]>,
    /// The last allowance that was made.
    pub allowance: Allowance,
    /// What each stage took.
    pub latencies: Latencies,
    /// From the first frame to the last: seconds.
    pub seconds: f64,
    /// The last frame that was shown.
    pub last: Option<Order>,
    /// What the pictures of all machines hash to where that frame is rendered without
    /// an end of steps; none where there is one machine.
    pub hashes: Vec<u64>,
    /// How long the others were waited for: microseconds; `None` where there is one
    /// machine.
    pub waited: Option<Histogram<u64>>,
    /// How much longer the last of them took to be ready than the first, likewise.
    pub spread: Option<Histogram<u64>>,
}

impl SessionReport {
    /// Before the first frame.
    pub(super) fn new() -> Self {
        Self {
            frames: 0,
            late_frames: 0,
            over_budget_frames: 0,
            over_time_frames: 0,
            frames_with_unfinished_fovea: 0,
            frames_with_unfinished_tiles: 0,
            lowered_frames: 0,
            quality_changes: 0,
            rungs: [0; Quality::LADDER.len()],
            blind_frames: 0,
            frames_without_gaze: 0,
            samples: 0,
            passed_over: 0,
            refreshes: 0,
            plain_seconds: None,
            median_steps: 0,
            spent_share: None,
            needed_share: None,
            plain_parts: None,
            allowance: Allowance::Unlimited,
            latencies: Latencies::new(),
            seconds: 0.0,
            last: None,
            hashes: Vec::new(),
            waited: None,
            spread: None,
        }
    }

    /// Notes what part of a frame in full the allowance is.
    pub(super) fn note_part(&mut self) {
        if let (Allowance::Time(time), Some(plain)) = (self.allowance, self.plain_seconds) {
            let part = time.as_secs_f64() / plain;
            let [least, most] = self.plain_parts.unwrap_or([part; 2]);
            self.plain_parts = Some([least.min(part), most.max(part)]);
        }
    }

    /// Counts a frame that was shown.
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
    }
}
