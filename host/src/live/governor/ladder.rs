//! The ladder of qualities: their needs relative to each other, and the current rung.

use super::places::{Cell, NeedsByGaze};
use crate::live::quality::Quality;
use glam::Vec3;

const RECENT: usize = 6;

/// The largest part of a budget that is planned, so that a dearer frame is still finished.
const PLANNED: f64 = 0.88;

/// Share of the budget that a better quality may need at most before it is chosen.
const ROOM_TO_RISE: f64 = 0.75;

/// The frames in a row with room for more before quality rises by a rung.
pub(super) const FRAMES_TO_RISE: u32 = 20;

/// The least budget of a frame as a multiple of the least quality's need.
const AT_LEAST: f64 = 2.0;

/// The first guess at the ratios, about those of scene A; the true ones are learned.
const RATIOS: Ratios = [
    0.95, 0.9, 0.7, 0.95, 0.7, 0.8, 0.6, 0.6, 0.75, 0.6, 0.6, 0.6, 0.6,
];

/// The most that the best rung's estimated need may differ from the last seen, as a factor.
const MOST_CHANGE: f64 = 2.0;

/// The least ratio of a quality's need to that of the one above.
const LEAST_RATIO: f64 = 0.05;

/// The least weight of a newly seen ratio.
const LEARNING: f64 = 0.25;

/// The need of each quality relative to the one above.
type Ratios = [f64; Quality::LADDER.len() - 1];

#[derive(Debug, Clone)]
pub(super) struct Ladder {
    pub(super) rung: usize,
    ratios: Ratios,
    seen: [u32; Quality::LADDER.len() - 1],
    /// Rungs and needs of the newest frames; the newest is at `newest`.
    recent: [(usize, f64); RECENT],
    newest: usize,
    best: f64,
    last: Option<Cell>,
    needs: NeedsByGaze,
    cell: Option<Cell>,
    calm: u32,
}

impl Ladder {
    pub(super) fn new() -> Self {
        Self {
            rung: 0,
            ratios: RATIOS,
            seen: [0; Quality::LADDER.len() - 1],
            recent: [(0, 0.0); RECENT],
            newest: 0,
            best: 0.0,
            last: None,
            needs: NeedsByGaze::new(),
            cell: None,
            calm: 0,
        }
    }

    pub(super) fn forget_in(&mut self, frames: u64) {
        self.needs.forget_in(frames);
    }

    pub(super) fn look(&mut self, forward: Vec3) {
        self.cell = Some(Cell::new(forward));
    }

    pub(super) fn forget_newest(&mut self) {
        self.recent = [(self.rung, 0.0); RECENT];
    }

    /// Returns the need of a rung relative to another's.
    fn ratio(&self, rung: usize, other: usize) -> f64 {
        let between = |from: usize, to: usize| -> f64 {
            let ratios = self.ratios.get(from..to).unwrap_or_default();
            ratios.iter().product()
        };
        if other <= rung {
            between(other, rung)
        } else {
            between(rung, other).recip()
        }
    }

    /// Returns the same in the cell of the next frame's gaze, as far as rungs near both were seen
    /// there.
    fn ratio_here(&self, rung: usize, other: usize) -> f64 {
        let there = |rung: usize| self.cell.map_or(0.0, |cell| self.there(cell, rung));
        match there(other) {
            of_other if of_other > 0.0 => there(rung) / of_other,
            _ => self.ratio(rung, other),
        }
    }

    /// Returns the need of a rung by the newest frames: the most of the last few. 0 before the
    /// first.
    fn recent(&self, rung: usize) -> f64 {
        let needs = self.recent.iter();
        let needs = needs.map(|&(of, need)| need * self.ratio_here(rung, of));
        needs.fold(0.0, f64::max)
    }

    /// Returns the need of the best rung, by the gaze's cell or else the newest frames. 0 before
    /// the first.
    pub(super) fn best_need(&self) -> f64 {
        if let Some(need) = self.cell.and_then(|cell| self.needs.best_need(cell)) {
            return need;
        }
        let recent = self.recent(0);
        if self.best > 0.0 {
            recent.clamp(self.best / MOST_CHANGE, self.best * MOST_CHANGE)
        } else {
            recent
        }
    }

    /// Returns the need of a rung in a cell, from the nearest rung seen there; 0 if no rung was.
    fn there(&self, cell: Cell, rung: usize) -> f64 {
        let known = self.needs.known(cell);
        let nearest = known.min_by_key(|&(of, _)| of.abs_diff(rung));
        nearest.map_or(0.0, |(of, need)| need * self.ratio(rung, of))
    }

    /// Returns the need of a rung: the most by the newest frames and by frames in the gaze's cell.
    fn need(&self, rung: usize) -> f64 {
        let there = self.cell.map_or(0.0, |cell| self.there(cell, rung));
        self.recent(rung).max(there)
    }

    fn fits(&self, rung: usize, steps: f64, part: f64) -> bool {
        self.need(rung) <= steps * part
    }

    /// Returns steps that are enough for all of the least quality.
    pub(super) fn least(&self) -> u64 {
        (AT_LEAST * self.need(Quality::LADDER.len() - 1)) as u64
    }

    pub(super) fn choose(&mut self, steps: f64) {
        let last = Quality::LADDER.len() - 1;
        let mut rungs = 0..=last;
        let affordable = rungs.find(|&rung| self.fits(rung, steps, PLANNED));
        let affordable = affordable.unwrap_or(last);
        if affordable > self.rung {
            self.rung = affordable;
            self.calm = 0;
            return;
        }
        let better = self.rung.checked_sub(1);
        if !better.is_some_and(|better| self.fits(better, steps, ROOM_TO_RISE)) {
            self.calm = 0;
            return;
        }
        self.calm += 1;
        if self.calm >= FRAMES_TO_RISE {
            self.rise(steps);
        }
    }

    pub(super) fn rise(&mut self, steps: f64) -> bool {
        let better = self.rung.checked_sub(1);
        let better = better.filter(|&better| self.fits(better, steps, ROOM_TO_RISE));
        if let Some(better) = better {
            self.rung = better;
            self.calm = 0;
        }
        better.is_some()
    }

    pub(super) fn learn(&mut self, rung: usize, need: f64) {
        // A ratio is seen where the rung has changed and the gaze is in a cell where it was
        // before.
        let (before, of_before) = self.recent[self.newest];
        let before = if self.last == self.cell {
            Some((before, of_before))
        } else {
            let known = self.cell.map(|cell| self.needs.known(cell));
            let known = known.into_iter().flatten();
            known.min_by_key(|&(of, _)| of.abs_diff(rung))
        };
        if let Some((before, of_before)) = before
            && before != rung
            && of_before > 0.0
            && need > 0.0
        {
            self.learn_ratio(rung, before, need / of_before);
        }
        self.last = self.cell;
        self.newest = (self.newest + 1) % RECENT;
        self.recent[self.newest] = (rung, need);
        if rung == 0 {
            self.best = need;
        }
        if let Some(cell) = self.cell {
            let ratios: [f64; Quality::LADDER.len()] =
                std::array::from_fn(|other| self.ratio(other, rung));
            self.needs.learn(cell, rung, |other| need * ratios[other]);
            // All cells say more than the last one.
            for (rung, ratio) in self.ratios.iter_mut().enumerate() {
                if let Some(seen) = self.needs.ratio(rung) {
                    *ratio = seen.clamp(LEAST_RATIO, 1.0);
                }
            }
        }
    }

    /// Learns the need of a rung relative to another's; the rungs between share the difference.
    fn learn_ratio(&mut self, rung: usize, other: usize, seen: f64) {
        let expected = self.ratio(rung, other);
        let (from, to) = (rung.min(other), rung.max(other));
        let sign = if other < rung { 1.0 } else { -1.0 };
        let each = sign * (seen / expected).ln() / (to - from) as f64;
        let between = self.ratios.iter_mut().zip(&mut self.seen);
        for (ratio, seen) in between.skip(from).take(to - from) {
            let learning = f64::from(*seen + 1).recip().max(LEARNING);
            *ratio = (*ratio * (each * learning).exp()).clamp(LEAST_RATIO, 1.0);
            *seen += 1;
        }
    }
}
