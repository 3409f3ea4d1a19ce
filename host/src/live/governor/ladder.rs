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

/// What the qualities of the ladder are taken to cost beside the best before anything is
/// known: a guess, with which the first frames begin. What they do cost is learned.
const COSTS: [f64; Quality::LADDER.len()] = [
    1.0, 0.98, 0.95, 0.85, 0.75, 0.6, 0.4, 0.3, 0.25, 0.2, 0.12, 0.06,
];

/// What is known of the qualities for frames of one kind, and which one these have.
#[derive(Debug, Clone)]
pub(super) struct Ladder {
    rung: usize,
    /// What each rung costs beside the best.
    costs: [f64; Quality::LADDER.len()],
    /// Of which of these more is known than a guess.
    seen: [bool; Quality::LADDER.len()],
    /// Needs of the newest frames as of the best rung; the newest is at `newest`.
    needs: [f64; RECENT],
    newest: usize,
    /// The rung and the need of the newest frame, and where its gaze was.
    last: Option<(usize, f64, Option<Cell>)>,
    /// Needs by where the gaze was, likewise.
    places: Places,
    /// Where the next frame's gaze is.
    cell: Option<Cell>,
    calm: u32,
}

impl Ladder {
    /// Nothing is known.
    pub(super) const NEW: Self = Self {
        rung: 0,
        costs: COSTS,
        seen: [false; Quality::LADDER.len()],
        needs: [0.0; RECENT],
        newest: 0,
        last: None,
        places: Places::NEW,
        cell: None,
        calm: 0,
    };

    /// The rung that frames have.
    pub(super) const fn rung(&self) -> usize {
        self.rung
    }

    /// Where the next frame's gaze is.
    pub(super) fn look(&mut self, forward: Vec3) {
        self.cell = Some(Cell::of(forward));
    }

    /// What the best rung needs, by the newest frames: the most of the last few. 0 where
    /// nothing is known.
    pub(super) fn recent(&self) -> f64 {
        self.needs.iter().copied().fold(0.0, f64::max)
    }

    /// What a rung needs: the most of the last few frames, and of those whose gaze was
    /// where the next one's is.
    pub(super) fn need(&self, rung: usize) -> f64 {
        let there = self.cell.map_or(0.0, |cell| self.places.need(cell));
        self.recent().max(there) * self.costs[rung]
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
        // What rungs cost beside each other is seen where the rung has changed; the
        // rungs around move along. Where the gaze has changed, too, what is known of
        // frames there counts.
        if let Some((before, of_before, cell)) = self.last
            && before != rung
            && of_before > 0.0
            && need > 0.0
        {
            let there = self.cell.filter(|_| cell != self.cell);
            let there = there.map_or(0.0, |cell| self.places.need(cell));
            let seen = if there > 0.0 {
                need / there
            } else {
                self.costs[before] * need / of_before
            };
            let known = self.costs[rung];
            let is_known = std::mem::replace(&mut self.seen[rung], true);
            self.costs[rung] = if is_known { 0.5 * (known + seen) } else { seen };
            self.keep_in_order(rung);
        }
        self.last = Some((rung, need, self.cell));
        self.newest = (self.newest + 1) % RECENT;
        let of_best = need / self.costs[rung];
        self.needs[self.newest] = of_best;
        if let Some(cell) = self.cell {
            self.places.learn(cell, of_best);
        }
    }

    /// A worse rung costs no more than a better one.
    fn keep_in_order(&mut self, rung: usize) {
        let cost = self.costs[rung].clamp(1.0e-3, 1.0);
        self.costs[rung] = cost;
        for (number, one) in self.costs.iter_mut().enumerate() {
            *one = if number < rung {
                one.max(cost)
            } else {
                one.min(cost)
            };
        }
        self.costs[0] = 1.0;
    }
}
