//! What the qualities cost beside each other, and which one frames have.

use super::places::{Cell, Places};
use crate::live::quality::Quality;
use glam::Vec3;

/// How many of the newest frames say what the next one will need.
const RECENT: usize = 6;

/// The part of a budget that frames are planned to take at most, so that one that
/// turns out dearer is still finished.
const PLANNED: f64 = 0.88;

/// The part that a better quality must fit into before it is taken.
const ROOM_TO_RISE: f64 = 0.75;

/// How many frames have to have had room before quality rises by a rung.
pub(super) const CALM: u32 = 20;

/// What frames have at least where time says that there is less, in what the least
/// quality needs: so much that what neighbouring tiles may take above their share is in it.
const AT_LEAST: f64 = 2.0;

/// What a frame of each quality takes at first as a part of what one of the quality above
/// does: about what it is in scene A. What it is here is learned.
const RATIOS: Ratios = [
    0.95, 0.9, 0.7, 0.95, 0.7, 0.8, 0.6, 0.6, 0.75, 0.6, 0.6, 0.6, 0.6,
];

/// How many times as much as a frame of the best quality others are taken to need, by
/// where gazes go: what rungs far from it take says little.
const MOST_CHANGE: f64 = 2.0;

/// The least part of a frame of the quality above that one is taken to need.
const LEAST_RATIO: f64 = 0.05;

/// How much of what is seen of a ratio is taken at least, where as much was seen before.
const LEARNING: f64 = 0.25;

/// Between each quality and the one above.
type Ratios = [f64; Quality::LADDER.len() - 1];

/// What is known of the qualities for frames of one kind, and which one these have.
#[derive(Debug, Clone)]
pub(super) struct Ladder {
    rung: usize,
    /// What each rung but the first takes as a part of the one above.
    ratios: Ratios,
    /// How often each of these was seen.
    seen: [u32; Quality::LADDER.len() - 1],
    /// Rungs and needs of the newest frames; the newest is at `newest`.
    recent: [(usize, f64); RECENT],
    newest: usize,
    /// What the newest frame of the best rung needed; 0 before there was one.
    best: f64,
    /// Where the newest frame's gaze was.
    last: Option<Cell>,
    /// Needs by where the gaze was.
    places: Places,
    /// Where the next frame's gaze is.
    cell: Option<Cell>,
    calm: u32,
}

impl Ladder {
    /// Nothing is known.
    pub(super) fn new() -> Self {
        Self {
            rung: 0,
            ratios: RATIOS,
            seen: [0; Quality::LADDER.len() - 1],
            recent: [(0, 0.0); RECENT],
            newest: 0,
            best: 0.0,
            last: None,
            places: Places::new(),
            cell: None,
            calm: 0,
        }
    }

    /// The rung that frames have.
    pub(super) const fn rung(&self) -> usize {
        self.rung
    }

    /// Where the next frame's gaze is.
    pub(super) fn look(&mut self, forward: Vec3) {
        self.cell = Some(Cell::of(forward));
    }

    /// The newest frames are of no concern for the next: their gazes were elsewhere.
    pub(super) fn forget_newest(&mut self) {
        self.recent = [(self.rung, 0.0); RECENT];
    }

    /// What a rung takes as a part of what another does.
    fn ratio(&self, rung: usize, other: usize) -> f64 {
        let between = |from: usize, to: usize| -> f64 {
            let between = self.ratios.get(from..to).unwrap_or_default();
            between.iter().product()
        };
        if other <= rung {
            between(other, rung)
        } else {
            between(rung, other).recip()
        }
    }

    /// The same where the next frame's gaze is, as far as it has been there: what was seen
    /// of both rungs, or of rungs near them.
    fn ratio_here(&self, rung: usize, other: usize) -> f64 {
        let there = |rung: usize| self.cell.map_or(0.0, |cell| self.there(cell, rung));
        match there(other) {
            of_other if of_other > 0.0 => there(rung) / of_other,
            _ => self.ratio(rung, other),
        }
    }

    /// What a rung needs, by the newest frames: the most of the last few. 0 where
    /// nothing is known.
    pub(super) fn recent(&self, rung: usize) -> f64 {
        let needs = self.recent.iter();
        let needs = needs.map(|&(of, need)| need * self.ratio_here(rung, of));
        needs.fold(0.0, f64::max)
    }

    /// What the best rung needs: what it needed where the gaze is, or else wherever it has
    /// been. Of frames that follow no gaze, by the newest ones; at most so many times as much
    /// as the newest frame of it needed, or as small a part of that. 0 where nothing is known.
    pub(super) fn of_best(&self) -> f64 {
        if let Some(need) = self.cell.and_then(|cell| self.places.of_best(cell)) {
            return need;
        }
        let recent = self.recent(0);
        if self.best > 0.0 {
            recent.clamp(self.best / MOST_CHANGE, self.best * MOST_CHANGE)
        } else {
            recent
        }
    }

    /// What a rung needs where the gaze goes, by the nearest rung that is known there. 0
    /// where nothing is.
    fn there(&self, cell: Cell, rung: usize) -> f64 {
        let known = self.places.known(cell);
        let nearest = known.min_by_key(|&(of, _)| of.abs_diff(rung));
        nearest.map_or(0.0, |(of, need)| need * self.ratio(rung, of))
    }

    /// What a rung needs: the most of the last few frames, and of those whose gaze was
    /// where the next one's is.
    pub(super) fn need(&self, rung: usize) -> f64 {
        let there = self.cell.map_or(0.0, |cell| self.there(cell, rung));
        self.recent(rung).max(there)
    }

    /// Whether what a rung needs is such a part of some steps at most.
    fn fits(&self, rung: usize, steps: f64, part: f64) -> bool {
        self.need(rung) <= steps * part
    }

    /// Steps with which the least quality is whole.
    pub(super) fn least(&self) -> u64 {
        (AT_LEAST * self.need(Quality::LADDER.len() - 1)) as u64
    }

    /// Chooses the rung of the next frame, which may take so many steps.
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
        if self.calm >= CALM {
            self.rise(steps);
        }
    }

    /// Takes the rung above where there is room for it; whether there was.
    pub(super) fn rise(&mut self, steps: f64) -> bool {
        let better = self.rung.checked_sub(1);
        let better = better.filter(|&better| self.fits(better, steps, ROOM_TO_RISE));
        if let Some(better) = better {
            self.rung = better;
            self.calm = 0;
        }
        better.is_some()
    }

    /// What all of a frame at a rung would have taken.
    pub(super) fn learn(&mut self, rung: usize, need: f64) {
        // What rungs take beside each other is seen where the rung has changed and the
        // gaze is where it was, or where it was once.
        let (before, of_before) = self.recent[self.newest];
        let before = if self.last == self.cell {
            Some((before, of_before))
        } else {
            let known = self.cell.map(|cell| self.places.known(cell));
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
            self.places.learn(cell, rung, |other| need * ratios[other]);
            // What is known of places says more than the last place that was looked at.
            for (rung, ratio) in self.ratios.iter_mut().enumerate() {
                if let Some(seen) = self.places.ratio(rung) {
                    *ratio = seen.clamp(LEAST_RATIO, 1.0);
                }
            }
        }
    }

    /// What a rung took as a part of what another did. Between them all have their part
    /// of what that differs by; a worse rung takes no more than a better one.
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
