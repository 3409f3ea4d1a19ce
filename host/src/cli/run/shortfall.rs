//! Budgets that are too small for the least quality.

use crate::cli::output::counted;
use crate::live::{FrameRecord, Quality};

/// Frames over their time before that is told: one or two may have been held up.
const FEWEST: u64 = 5;

/// Of the frames of lowered quality one of so many is over its time, at least, where
/// that is told.
const ONE_OF: u64 = 4;

/// Tells once that frames of the least quality are not finished within their budget, or
/// nothing of one is, and once that those of lowered quality are not in time. These need
/// not be of the least: as many steps as that needs are given whatever the time, and a
/// better one may fit into them.
#[derive(Debug, Default)]
pub(super) struct Shortfall {
    /// Whether it was told that steps are too few.
    of_steps: bool,
    /// Whether it was told that time is too short.
    of_time: bool,
    /// Frames of lowered quality.
    lowered: u64,
    /// Those of them that took longer than they might.
    over_time: u64,
}

impl Shortfall {
    /// Hears of a frame; what is to be told, if anything is.
    pub(super) fn hear(&mut self, record: &FrameRecord) -> Option<String> {
        let is_nothing = record.tiles > 0 && record.unfinished_tiles == record.tiles;
        if let Some(steps) = record.budget_steps.filter(|_| is_nothing && !self.of_steps) {
            self.of_steps = true;
            return Some(format!(
                "the budget is too small: of frame {} no tile is finished in {}; give a larger \
                 --budget",
                record.frame,
                counted(steps, "step"),
            ));
        }
        if record.rung == 0 {
            return None;
        }
        self.lowered += 1;
        self.over_time += u64::from(record.over_time);
        let is_least = record.rung + 1 == Quality::LADDER.len();
        if record.unfinished_fovea && is_least && !self.of_steps {
            self.of_steps = true;
            return Some(format!(
                "the budget is too small for what is looked at: of the least quality frame {} \
                 takes about {} steps, and may take {}; give a larger --budget, a lower --hz or a \
                 smaller --size",
                record.frame,
                record.need_steps,
                record.budget_steps.unwrap_or(record.need_steps),
            ));
        }
        let is_common = self.over_time >= FEWEST && self.over_time * ONE_OF >= self.lowered;
        let budget = record.budget_us.filter(|_| record.over_time)?;
        if !is_common || self.of_time {
            return None;
        }
        self.of_time = true;
        let milliseconds = |microseconds: u64| 1.0e-3 * microseconds as f64;
        Some(format!(
            "the budget is too short: of lowered quality {} of {} frames took longer, frame {} \
             {:.2} ms where it may take {:.2} ms; give a larger --budget, a lower --hz or a \
             smaller --size",
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

    const LEAST: usize = Quality::LADDER.len() - 1;

    /// One that takes so long of 2 ms.
    fn frame(rung: usize, done_us: u64) -> FrameRecord {
        FrameRecord {
            rung,
            done_us,
            budget_us: Some(2_000),
            over_time: done_us > 2_000,
            ..FrameRecord::default()
        }
    }

    /// What is told of frames.
    fn told(frames: impl IntoIterator<Item = FrameRecord>) -> Vec<String> {
        let mut shortfall = Shortfall::default();
        let told = frames.into_iter().filter_map(|one| shortfall.hear(&one));
        told.collect()
    }

    #[test]
    fn times_that_are_too_short_are_told_once() {
        let half = |number: u64| {
            frame(
                LEAST,
                if number.is_multiple_of(2) {
                    3_400
                } else {
                    1_900
                },
            )
        };
        let told_of_half = told((0..100).map(half));
        assert_eq!(told_of_half.len(), 1, "{told_of_half:?}");
        let said = "5 of 9 frames took longer, frame 0 3.40 ms where it may take 2.00 ms";
        assert!(told_of_half[0].contains(said), "{told_of_half:?}");
        // Full quality will be lowered, and one in ten was held up.
        assert!(told((0..100).map(|_| frame(0, 9_000))).is_empty());
        let seldom = |number: u64| frame(LEAST, if number % 10 == 9 { 3_000 } else { 1_000 });
        assert!(told((0..1_000).map(seldom)).is_empty());
    }

    #[test]
    fn frames_of_nothing_are_told_once_whatever_their_quality() {
        let nothing = |unfinished_tiles| FrameRecord {
            tiles: 6,
            unfinished_tiles,
            budget_steps: Some(2_000),
            ..FrameRecord::default()
        };
        let told_of_nothing = told((0..10).map(|_| nothing(6)));
        assert_eq!(told_of_nothing.len(), 1, "{told_of_nothing:?}");
        assert!(told_of_nothing[0].contains("2000 steps"));
        assert!(told([nothing(5)]).is_empty());
    }

    #[test]
    fn holes_where_one_looks_are_told_once() {
        let hole = || FrameRecord {
            unfinished_fovea: true,
            need_steps: 900,
            budget_steps: Some(1),
            ..frame(LEAST, 1_000)
        };
        let told_of_holes = told((0..10).map(|_| hole()));
        assert_eq!(told_of_holes.len(), 1, "{told_of_holes:?}");
        assert!(told_of_holes[0].contains("900 steps, and may take 1;"));
        let both = told((0..10).map(|_| FrameRecord {
            over_time: true,
            ..hole()
        }));
        assert_eq!(both.len(), 2, "{both:?}");
    }
}
