//! What frames needed where the gaze went.

use glam::Vec3;

/// Cells along each edge of a cube around the viewer: about 11° each.
const SIDE: usize = 8;

/// How much of what a frame needed less than frames before it, with the gaze in the same
/// cell, is taken for what the next one there will need.
const FORGETTING: f64 = 0.25;

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

/// Steps that frames needed, as of the best quality, by the gaze's cell.
#[derive(Debug, Clone)]
pub(super) struct Places([f64; 6 * SIDE * SIDE]);

impl Places {
    /// Nobody has looked anywhere.
    pub(super) const NEW: Self = Self([0.0; 6 * SIDE * SIDE]);

    /// What frames with the gaze there needed; 0 where there was none.
    pub(super) fn need(&self, cell: Cell) -> f64 {
        self.0.get(cell.0).copied().unwrap_or_default()
    }

    /// Takes a frame's.
    pub(super) fn learn(&mut self, cell: Cell, need: f64) {
        if let Some(known) = self.0.get_mut(cell.0) {
            *known = need.max(*known + FORGETTING * (need - *known));
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
        let mut places = Places::NEW;
        let cell = Cell::of(Vec3::NEG_Z);
        assert_eq!(places.need(cell), 0.0);
        places.learn(cell, 100.0);
        assert_eq!(places.need(cell), 100.0);
        places.learn(cell, 60.0);
        assert_eq!(places.need(cell), 90.0);
        for _ in 0..20 {
            places.learn(cell, 60.0);
        }
        assert!((places.need(cell) - 60.0).abs() < 0.5);
        assert_eq!(places.need(Cell::of(Vec3::X)), 0.0);
    }
}
