//! What frames needed where the gaze went.

use crate::live::quality::Quality;
use glam::Vec3;

/// Cells along each edge of a cube around the viewer: about 11° each.
const SIDE: usize = 8;

/// How much of what a frame needed less than frames before it, with the gaze in the same
/// cell, is taken for what the next one there will need.
const FORGETTING: f64 = 0.25;

/// How much of what a frame of another quality is expected to need, with the gaze in the
/// same cell, is taken for what it will: what is around the viewer may have changed since
/// there was one, half a minute ago.
const FORGETTING_OTHERS: f64 = 0.0005;

/// Qualities.
const RUNGS: usize = Quality::LADDER.len();

/// A cell of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cell(usize);

impl Cell {
    /// The cell of a direction, which is not zero; of what is no direction, any.
    pub(super) fn of(direction: Vec3) -> Self {
        let axis = direction.abs().max_position();
        let along = direction[axis];
        let [across, up] = [1, 2].map(|other| {
            let slope = direction[(axis + other) % 3] / along.abs();
            // A cast cuts off what is below 0, and makes 0 of NaN.
            ((slope * 0.5 + 0.5) * SIDE as f32) as usize
        });
        let face = 2 * axis + usize::from(along < 0.0);
        let place = |cell: usize| cell.min(SIDE - 1);
        Self((face * SIDE + place(up)) * SIDE + place(across))
    }
}

/// Steps that frames needed, by the gaze's cell and the quality's rung.
#[derive(Debug, Clone)]
pub(super) struct Places(Vec<[f64; RUNGS]>);

impl Places {
    /// Nobody has looked anywhere.
    pub(super) fn new() -> Self {
        Self(vec![[0.0; RUNGS]; 6 * SIDE * SIDE])
    }

    /// What is known of frames with the gaze there: rungs, from the best on, and needs.
    pub(super) fn known(&self, cell: Cell) -> impl Iterator<Item = (usize, f64)> {
        let rungs = self.0.get(cell.0).copied().unwrap_or([0.0; RUNGS]);
        let all = rungs.into_iter().enumerate();
        all.filter(|&(_, need)| need > 0.0)
    }

    /// What frames of the rung below one need as a part of what its own do, by all cells in
    /// which both are known: the dearer they are there, the more these count. `None` where
    /// there are none.
    pub(super) fn ratio(&self, rung: usize) -> Option<f64> {
        let both = self
            .0
            .iter()
            .filter_map(|rungs| match rungs.get(rung..rung + 2) {
                Some(&[own, below]) if own > 0.0 && below > 0.0 => Some((own, below)),
                _ => None,
            });
        let (own, below) = both.fold((0.0, 0.0), |sums, both| (sums.0 + both.0, sums.1 + both.1));
        (own > 0.0).then(|| below / own)
    }

    /// What frames of the best rung need with the gaze there: what they needed, or else what
    /// they did in the middle of the other cells. `None` before there was one.
    pub(super) fn of_best(&self, cell: Cell) -> Option<f64> {
        let of = |rungs: &[f64; RUNGS]| rungs.first().copied().filter(|&need| need > 0.0);
        self.0.get(cell.0).and_then(of).or_else(|| {
            let needs = self.0.iter().filter_map(of);
            let (count, sum) =
                needs.fold((0.0, 0.0), |(count, sum), need| (count + 1.0, sum + need));
            (count > 0.0).then(|| sum / count)
        })
    }

    /// Takes what a frame of a rung needed, and what others are expected to by that.
    pub(super) fn learn(&mut self, cell: Cell, rung: usize, expected: impl Fn(usize) -> f64) {
        let Some(known) = self.0.get_mut(cell.0) else {
            return;
        };
        for (of, known) in known.iter_mut().enumerate() {
            let need = expected(of);
            if of == rung {
                *known = need.max(*known + FORGETTING * (need - *known));
            } else if *known > 0.0 {
                *known += FORGETTING_OTHERS * (need - *known);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_has_a_cell_and_neighbours_share_it() {
        let mut met = std::collections::HashSet::new();
        for x in -40..=40 {
            for y in -40..=40 {
                for z in [-40, 40] {
                    let [a, b, c] = [x, y, z].map(|part| part as f32);
                    for direction in [Vec3::new(a, b, c), Vec3::new(b, c, a), Vec3::new(c, a, b)] {
                        let cell = Cell::of(direction);
                        assert_eq!(cell, Cell::of(direction * 1.0e-3));
                        met.insert(cell.0);
                    }
                }
            }
        }
        assert!(met.iter().all(|&cell| cell < 6 * SIDE * SIDE));
        assert_eq!(met.len(), 6 * SIDE * SIDE);
        let ahead = Vec3::new(0.05, 0.05, -1.0);
        assert_eq!(Cell::of(ahead), Cell::of(Vec3::new(0.1, 0.1, -1.0)));
        assert_ne!(Cell::of(ahead), Cell::of(Vec3::new(0.4, 0.05, -1.0)));
        assert_ne!(Cell::of(ahead), Cell::of(-ahead));
        for none in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::splat(1.0e-45)] {
            assert!(Cell::of(none).0 < 6 * SIDE * SIDE);
        }
    }

    #[test]
    fn more_counts_at_once_and_less_after_a_while() {
        let mut places = Places::new();
        let cell = Cell::of(Vec3::NEG_Z);
        let need = |places: &Places, rung: usize| {
            let mut known = places.known(cell);
            known.find(|&(of, _)| of == rung).map(|(_, need)| need)
        };
        assert_eq!(need(&places, 4), None);
        places.learn(cell, 4, |_| 100.0);
        assert_eq!(need(&places, 4), Some(100.0));
        places.learn(cell, 4, |_| 60.0);
        assert_eq!(need(&places, 4), Some(90.0));
        for _ in 0..20 {
            places.learn(cell, 4, |_| 60.0);
        }
        assert!((need(&places, 4).unwrap() - 60.0).abs() < 0.5);
        assert_eq!(places.known(Cell::of(Vec3::X)).count(), 0);
        assert_eq!(places.ratio(4), None);
        // What is known of others stays for longer.
        places.learn(cell, 5, |_| 30.0);
        assert_eq!(places.known(cell).count(), 2);
        for _ in 0..400 {
            places.learn(cell, 5, |of| [20.0, 40.0][usize::from(of == 4)]);
        }
        assert!((55.0..59.0).contains(&need(&places, 4).unwrap()));
        assert!((need(&places, 5).unwrap() - 20.0).abs() < 1.0);
    }

    #[test]
    fn dear_places_count_for_more_than_cheap_ones() {
        let mut places = Places::new();
        let (cheap, dear) = (Cell::of(Vec3::NEG_Z), Cell::of(Vec3::X));
        for (cell, rung, need) in [
            (cheap, 8, 80.0),
            (cheap, 9, 20.0),
            (dear, 8, 920.0),
            (dear, 9, 730.0),
        ] {
            places.learn(cell, rung, |_| need);
        }
        let elsewhere = Cell::of(Vec3::Y);
        places.learn(elsewhere, 9, |_| 900.0);
        assert!((places.ratio(8).unwrap() - 0.75).abs() < 1.0e-3);
        assert_eq!(places.ratio(9), None);
        // The best is as dear wherever it has been seen, and elsewhere as in the middle.
        assert_eq!(places.of_best(cheap), None);
        places.learn(cheap, 0, |_| 1000.0);
        places.learn(dear, 0, |_| 1200.0);
        assert_eq!(places.of_best(dear), Some(1200.0));
        assert_eq!(places.of_best(elsewhere), Some(1100.0));
    }
}
