//! Warns of budgets that are too small for the least quality.

use crate::cli::arguments::lod::Choice;
use crate::live::{FrameRecord, Quality};
use shisen_core::gaze::VisualField;

/// Fewest frames over their time for a warning: one or two may have been held up.
const FEWEST: u64 = 5;

/// Least part of the frames of lowered quality that are over their time for a warning: one of these.
const ONE_OF: u64 = 4;

/// Least part of the visual field that frames show without advice: one of these.
const SHOWN_ONE_OF: f64 = 10.0;

/// Warns once if frames show little of the visual field, if a frame of the least quality is not
/// finished within its steps, and if frames of lowered quality are over their time. These need not
/// be of the least quality: frames always get the steps that it needs, into which a better one may
/// fit.
#[derive(Debug, Default)]
pub(super) struct Shortfall {
    /// What follows the gaze.
    lod: Choice,
    frames: u64,
    /// Sum of the parts of the visual field that frames show.
    shown: f64,
    warned_of_field: bool,
    warned_of_steps: bool,
    warned_of_time: bool,
    /// Frames of lowered quality.
    lowered: u64,
    /// Those of them that were over their time.
    over_time: u64,
}

impl Shortfall {
    pub(super) fn of(lod: Choice) -> Self {
        Self {
            lod,
            ..Self::default()
        }
    }

    /// Returns the mean part of the visual field that frames show; none without frames.
    pub(super) fn shown(&self) -> Option<f64> {
        (self.frames > 0).then(|| self.shown / self.frames as f64)
    }

    /// Returns what is missing and what would help, if that is most of the picture.
    pub(super) fn advice(&self) -> Option<String> {
        let shown = self.shown().filter(|shown| shown * SHOWN_ONE_OF < 1.0)?;
        let percent = match 100.0 * shown {
            ..1.0 => "less than 1 %".to_owned(),
            percent => format!("{percent:.0} %"),
        };
        if self.lod == Choice::Foveated {
            return Some(format!(
                "most of the picture is squares of one colour: the budget finishes {percent} of \
                 it; give smaller pictures with --size or a larger --budget"
            ));
        }
        Some(format!(
            "most of the picture is missing: the budget shows {percent} of the visual field; give \
             smaller pictures with --size, --lod foveated or a larger --budget"
        ))
    }

    /// Returns the advice at the end, if it was not given yet.
    pub(super) fn end(&self) -> Option<String> {
        self.advice().filter(|_| !self.warned_of_field)
    }

    /// Takes a frame's record; returns a warning if one is due.
    pub(super) fn hear(&mut self, record: &FrameRecord) -> Option<String> {
        let (all, unfinished) = (record.tiles.max(1), record.unfinished_tiles);
        let finished = all.saturating_sub(unfinished) as f64 / all as f64;
        let quality = Quality::LADDER[record.rung];
        let field = match self.lod {
            Choice::Off | Choice::Foveated => 1.0,
            Choice::Paper | Choice::PaperEllipse => quality.field_left(VisualField::PAPER),
        };
        self.frames += 1;
        self.shown += finished * field;
        if self.frames >= FEWEST && !self.warned_of_field {
            let advice = self.advice();
            self.warned_of_field = advice.is_some();
            if advice.is_some() {
                return advice;
            }
        }
        if record.rung == 0 {
            return None;
        }
        self.lowered += 1;
        self.over_time += u64::from(record.over_time);
        let is_least = record.rung + 1 == Quality::LADDER.len();
        if record.unfinished_fovea && is_least && !self.warned_of_steps {
            self.warned_of_steps = true;
            return Some(format!(
                "the budget is too small for the region that the viewer looks at: frame {} takes \
                 about {} steps in the least quality, and may take {}; give a larger --budget, a \
                 lower --hz or a smaller --size",
                record.frame,
                record.need_steps,
                record.budget_steps.unwrap_or(record.need_steps),
            ));
        }
        let is_common = self.over_time >= FEWEST && self.over_time * ONE_OF >= self.lowered;
        let budget = record.budget_us.filter(|_| record.over_time)?;
        if !is_common || self.warned_of_time {
            return None;
        }
        self.warned_of_time = true;
        let milliseconds = |microseconds: u64| 1.0e-3 * microseconds as f64;
        Some(format!(
            "the budget is too short: {} of {} frames of lowered quality took longer, frame {} \
             {:.2} ms instead of {:.2} ms; give a larger --budget, a lower --hz or a smaller \
             --size",
            self.over_time,
            self.lowered,
            record.frame,
            milliseconds(record.done_us.saturating_sub(record.latch_us)),
            milliseconds(budget),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Choice::{Foveated, Off, Paper, PaperEllipse};

    const LEAST: usize = Quality::LADDER.len() - 1;

    /// Returns a frame that takes a time of its 2 ms.
    fn frame(rung: usize, done_us: u64) -> FrameRecord {
        FrameRecord {
            rung,
            done_us,
            budget_us: Some(2_000),
            over_time: done_us > 2_000,
            ..FrameRecord::default()
        }
    }

    type Frames<'a> = &'a dyn Fn(u64) -> FrameRecord;

    #[test]
    fn each_shortfall_is_told_once() {
        let half = |i: u64| frame(1, if i.is_multiple_of(2) { 3_400 } else { 1_900 });
        let seldom = |i: u64| frame(1, if i % 10 == 9 { 3_000 } else { 1_000 });
        let missing = |unfinished_tiles, rung| FrameRecord {
            tiles: 20,
            unfinished_tiles,
            ..frame(rung, 1_000)
        };
        let hole = |over_time| FrameRecord {
            unfinished_fovea: true,
            need_steps: 900,
            budget_steps: Some(1),
            over_time,
            ..frame(LEAST, 1_000)
        };
        let times = "5 of 9 frames of lowered quality took longer, frame 0 3.40 ms instead of 2.00";
        let steps = "900 steps in the least quality, and may take 1;";
        let most = "shows 5 % of the visual field; give smaller pictures with --size, --lod fov";
        let narrowed = "the budget shows less than 1 % of the visual field; give smaller";
        let cases: [(Choice, Frames<'_>, &[&str]); 10] = [
            (Foveated, &half, &[times]),
            // Full quality will be lowered, and one frame in ten was held up.
            (Foveated, &|_| frame(0, 9_000), &[]),
            (Foveated, &seldom, &[]),
            (Off, &|_| missing(19, 0), &[most]),
            (Paper, &|_| missing(17, 0), &[]),
            // A narrowed field is missing, too.
            (Off, &|_| missing(0, LEAST), &[]),
            (Foveated, &|_| missing(0, LEAST), &[]),
            (PaperEllipse, &|_| missing(0, LEAST), &[narrowed]),
            (Foveated, &|_| hole(false), &[steps]),
            (Foveated, &|_| hole(true), &[steps, "too short"]),
        ];
        for (lod, record, expected) in cases {
            let mut shortfall = Shortfall::of(lod);
            let warnings = (0..100).filter_map(|i| shortfall.hear(&record(i)));
            let warnings: Vec<_> = warnings.collect();
            assert_eq!(warnings.len(), expected.len(), "{warnings:?}");
            for (warning, expected) in warnings.iter().zip(expected) {
                assert!(warning.contains(expected), "{warning}");
            }
        }
    }
}
