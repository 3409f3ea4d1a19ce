//! The cells of a mesh, found by where they lie.

use glam::DVec2;

/// A grid of nodes with two places each, between which cells map bilinearly.
#[derive(Debug)]
pub(crate) struct Cells {
    size: [usize; 2],
    flaws: Flaws,
    at: Bins,
    places: Bins,
}

/// What is odd about a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Flaws {
    /// Nodes that are not drawn although others on all four sides are.
    pub(crate) holes: usize,
    /// Cells that are turned over although most are not.
    pub(crate) folds: usize,
}

/// A point in a cell.
pub(crate) struct Found {
    /// Nodes at its corners: upper left, upper right, lower left, lower right.
    nodes: [usize; 4],
    /// Their weights.
    weights: [f64; 4],
}

impl Found {
    /// Returns the mean of nodes' numbers.
    pub(crate) fn mean<T>(&self, values: &[T]) -> T
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
    {
        let corners = self.nodes.into_iter().zip(self.weights);
        corners.map(|(node, weight)| values[node] * weight).sum()
    }
}

impl Cells {
    /// Indexes cells of nodes in rows; those with a NaN, and those farther than a picture's size
    /// outside it, have no cells. `None` where each covers many others: it is noise.
    pub(crate) fn new(size: [usize; 2], at: Vec<DVec2>, places: Vec<DVec2>) -> Option<Self> {
        let is_near = |place: DVec2| (place - 0.5).abs().max_element() <= 1.5;
        let is_drawn = |cell: usize| {
            let corners = corners(size, cell);
            corners
                .iter()
                .all(|node| is_near(at[*node]) && is_near(places[*node]))
        };
        let cells: Vec<u32> = (0..(size[0] - 1) * (size[1] - 1))
            .filter(|cell| is_drawn(*cell))
            .map(|cell| cell as u32)
            .collect();
        Some(Self {
            size,
            flaws: Flaws::of(size, &places, &cells),
            at: Bins::new(size, at, &cells)?,
            places: Bins::new(size, places, &cells)?,
        })
    }

    /// Returns what is odd about the mesh.
    pub(crate) const fn flaws(&self) -> Flaws {
        self.flaws
    }

    /// Returns where a point of the projector's picture is in the screen's.
    pub(crate) fn place(&self, at: DVec2) -> Option<DVec2> {
        Some(self.at(at)?.mean(&self.places.points))
    }

    /// Returns the point of the projector's picture that lights a place in the screen's.
    pub(crate) fn lighting(&self, place: DVec2) -> Option<DVec2> {
        Some(self.places.find(self.size, place)?.mean(&self.at.points))
    }

    /// Returns the cell that a point of the projector's picture is in.
    pub(crate) fn at(&self, at: DVec2) -> Option<Found> {
        self.at.find(self.size, at)
    }
}

impl Flaws {
    fn of(size: [usize; 2], places: &[DVec2], cells: &[u32]) -> Self {
        let is_drawn = |node: usize| !places[node].is_nan();
        // From the first to the last drawn node of each row and of each column.
        let [along, down] = [(1, size[0]), (size[0], size[1])].map(|(step, count)| {
            let lines = size[0] * size[1] / count;
            let line = move |line: usize| {
                let first = if step == 1 { line * count } else { line };
                let mut drawn = (0..count).filter(|at| is_drawn(first + at * step));
                let least = drawn.next().unwrap_or(count);
                least..drawn.next_back().unwrap_or(least)
            };
            (0..lines).map(line).collect::<Vec<_>>()
        });
        let is_hole = |node: &usize| {
            let (column, row) = (node % size[0], node / size[0]);
            !is_drawn(*node) && along[row].contains(&column) && down[column].contains(&row)
        };
        let is_over = |cell: &&u32| {
            let [a, b, c, d] = corners(size, **cell as usize).map(|node| places[node]);
            (d - a).perp_dot(c - b) < 0.0
        };
        let over = cells.iter().filter(is_over).count();
        Self {
            holes: (0..places.len()).filter(is_hole).count(),
            folds: over.min(cells.len() - over),
        }
    }
}

fn corners(size: [usize; 2], cell: usize) -> [usize; 4] {
    let (row, column) = (cell / (size[0] - 1), cell % (size[0] - 1));
    let first = row * size[0] + column;
    [first, first + 1, first + size[0], first + size[0] + 1]
}

/// Nodes, and bins of cells by their bounds: about as many bins as cells.
#[derive(Debug)]
struct Bins {
    points: Vec<DVec2>,
    least: DVec2,
    /// Bins a unit.
    scale: DVec2,
    /// Columns and rows of bins.
    count: [usize; 2],
    /// Where a bin's cells start.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl Bins {
    /// Most cells a bin, in the mean.
    const MOST: usize = 64;

    fn new(size: [usize; 2], points: Vec<DVec2>, cells: &[u32]) -> Option<Self> {
        let bounds = |cell: u32| {
            let corners = corners(size, cell as usize).map(|node| points[node]);
            let least = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
            let most = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
            (least, most)
        };
        let (least, most) = cells.iter().fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(least, most), cell| {
                let (low, high) = bounds(*cell);
                (least.min(low), most.max(high))
            },
        );
        let count = size.map(|side| side - 1);
        let extent = (most - least).max(DVec2::splat(f64::MIN_POSITIVE));
        let scale = DVec2::new(count[0] as f64, count[1] as f64) / extent;
        let bins = Self {
            points: Vec::new(),
            least,
            scale,
            count,
            starts: Vec::new(),
            cells: Vec::new(),
        };
        // Counted, then filled from each bin's end.
        let each = |cell: u32, run: &mut dyn FnMut(usize)| {
            let (low, high) = bounds(cell);
            let ([left, top], [right, bottom]) = (bins.bin(low), bins.bin(high));
            for row in top..=bottom {
                (left..=right).for_each(|column| run(row * count[0] + column));
            }
        };
        let sizes = cells.iter().map(|&cell| {
            let (low, high) = bounds(cell);
            let ([left, top], [right, bottom]) = (bins.bin(low), bins.bin(high));
            (right - left + 1) * (bottom - top + 1)
        });
        if sizes.sum::<usize>() > Self::MOST * count[0] * count[1] + 4_096 {
            return None;
        }
        let mut starts = vec![0u32; count[0] * count[1] + 1];
        for cell in cells {
            each(*cell, &mut |bin| starts[bin] += 1);
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut filled = vec![0; sum as usize];
        for cell in cells {
            each(*cell, &mut |bin| {
                starts[bin] -= 1;
                filled[starts[bin] as usize] = *cell;
            });
        }
        Some(Self {
            points,
            starts,
            cells: filled,
            ..bins
        })
    }

    /// Returns the bin of a point; the nearest for points outside.
    fn bin(&self, point: DVec2) -> [usize; 2] {
        let place = (point - self.least) * self.scale;
        [0, 1].map(|axis| (place[axis] as usize).min(self.count[axis] - 1))
    }

    fn find(&self, size: [usize; 2], point: DVec2) -> Option<Found> {
        let [column, row] = self.bin(point);
        let bin = row * self.count[0] + column;
        let cells = &self.cells[self.starts[bin] as usize..self.starts[bin + 1] as usize];
        cells.iter().find_map(|cell| {
            let nodes = corners(size, *cell as usize);
            let DVec2 { x, y } = within(nodes.map(|node| self.points[node]), point)?;
            let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
            Some(Found { nodes, weights })
        })
    }
}

/// Returns the shares of a cell's width and height at which a point is, by Newton's method; `None`
/// outside.
fn within([a, b, c, d]: [DVec2; 4], point: DVec2) -> Option<DVec2> {
    /// How far outside a cell a point still counts as inside, so that none is between two.
    const SEAM: f64 = 1.0e-9;
    let twist = a - b - c + d;
    let mut share = DVec2::splat(0.5);
    for _ in 0..12 {
        let off = a + share.x * (b - a) + share.y * (c - a) + share.x * share.y * twist - point;
        let across = b - a + share.y * twist;
        let down = c - a + share.x * twist;
        let step = DVec2::new(off.perp_dot(down), across.perp_dot(off)) / across.perp_dot(down);
        share -= step;
        if !step.is_finite() {
            return None;
        }
        if step.abs().max_element() < 1.0e-13 {
            break;
        }
    }
    let is_inside = (share - 0.5).abs().max_element() <= 0.5 + SEAM;
    is_inside.then(|| share.clamp(DVec2::ZERO, DVec2::ONE))
}
