//! The needs of frames by the direction of the gaze.

use crate::live::quality::Quality;
use glam::Vec3;

/// Cells along each edge of a cube around the viewer: about 11° each.
const SIDE: usize = 8;

/// How fast the need of a rung in a cell follows frames that need less.
const FORGETTING: f64 = 0.25;

/// How fast the need of a rung in a cell follows frames of other rungs there.
const FORGETTING_OTHERS: f64 = 0.0005;

const RUNGS: usize = Quality::LADDER.len();

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cell(usize);

impl Cell {
    pub(super) fn new(direction: Vec3) -> Self {
        let axis = direction.abs().max_position();
        let along = direction[axis];
        let [across, up] = [1, 2].map(|other| {
            let slope = direction[(axis + other) % 3] / along.abs();
            // A cast turns numbers below 0 and NaN into 0.
            ((slope * 0.5 + 0.5) * SIDE as f32) as usize
        });
        let face = 2 * axis + usize::from(along < 0.0);
        let place = |cell: usize| cell.min(SIDE - 1);
        Self((face * SIDE + place(up)) * SIDE + place(across))
    }
}

#[derive(Debug, Clone)]
pub(super) struct NeedsByGaze {
    /// Needs, with the frame in which they were last learned.
    cells: Vec<([f64; RUNGS], u64)>,
    frame: u64,
    /// Frames for which they are known.
    memory: u64,
}

impl NeedsByGaze {
    pub(super) fn new() -> Self {
        Self {
            cells: vec![([0.0; RUNGS], 0); 6 * SIDE * SIDE],
            frame: 0,
            memory: u64::MAX,
        }
    }

    pub(super) const fn forget_in(&mut self, frames: u64) {
        self.memory = frames;
    }

    /// Returns the cells that are not forgotten.
    fn remembered(&self) -> impl Iterator<Item = &[f64; RUNGS]> {
        let is_known = |learned: u64| self.frame - learned <= self.memory;
        let cells = self.cells.iter();
        cells.filter_map(move |(rungs, learned)| is_known(*learned).then_some(rungs))
    }

    fn cell(&self, cell: Cell) -> Option<[f64; RUNGS]> {
        let (rungs, learned) = self.cells.get(cell.0)?;
        (self.frame - learned <= self.memory).then_some(*rungs)
    }

    /// Returns the rungs that were seen in a cell, from the best on, with their needs.
    pub(super) fn known(&self, cell: Cell) -> impl Iterator<Item = (usize, f64)> {
        let rungs = self.cell(cell).unwrap_or([0.0; RUNGS]);
        let all = rungs.into_iter().enumerate();
        all.filter(|&(_, need)| need > 0.0)
    }

    /// Returns the need of the rung below relative to this one's, over all cells in which both were
    /// seen.
    pub(super) fn ratio(&self, rung: usize) -> Option<f64> {
        let (mut own, mut below) = (0.0, 0.0);
        for rungs in self.remembered() {
            if let Some(&[one, next]) = rungs.get(rung..rung + 2)
                && one > 0.0
                && next > 0.0
            {
                (own, below) = (own + one, below + next);
            }
        }
        (own > 0.0).then(|| below / own)
    }

    /// Returns the need of the best rung in a cell, or else the mean over the cells where it was
    /// seen.
    pub(super) fn best_need(&self, cell: Cell) -> Option<f64> {
        let best = |rungs: &[f64; RUNGS]| rungs.first().copied().filter(|&need| need > 0.0);
        self.cell(cell).as_ref().and_then(best).or_else(|| {
            let needs = self.remembered().filter_map(best);
            let (count, sum) =
                needs.fold((0.0, 0.0), |(count, sum), need| (count + 1.0, sum + need));
            (count > 0.0).then(|| sum / count)
        })
    }

    /// Learns the need of a rung in a cell; `expected` says what each rung needs by that.
    pub(super) fn learn(&mut self, cell: Cell, rung: usize, expected: impl Fn(usize) -> f64) {
        let is_forgotten = self.cell(cell).is_none();
        self.frame += 1;
        let Some((known, learned)) = self.cells.get_mut(cell.0) else {
            return;
        };
        *learned = self.frame;
        if is_forgotten {
            *known = [0.0; RUNGS];
        }
        for (other, known) in known.iter_mut().enumerate() {
            let need = expected(other);
            if other == rung {
                *known = need.max(*known + FORGETTING * (need - *known));
            } else if *known > 0.0 {
                *known += FORGETTING_OTHERS * (need - *known);
            }
        }
    }
}
