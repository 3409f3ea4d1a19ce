//! Samples of a square of pixels, and the pixels between them.

mod batch;
mod cell;
mod grid;

use super::begun::{Cell, MISSED, Node, SKIPPED, Work};
use super::tile::{BLOCK, Piece, Target, spread};
use super::view::{Kind, Screen, View};
use super::{LevelOfDetail, Renderer};
use crate::gaze::Region;
use crate::numeric::{max, min};
use crate::simd::{Runs, Simd};
use crate::trace::{Pixel, RayDetail};
use batch::{Batch, TOGETHER};
use grid::Grid;

/// Most steps of the finest samples along a square's side.
const STEPS: usize = 16;

/// Number of times that the distance of samples is halved where they differ.
const HALVINGS: u32 = 2;

/// Contrast (difference by sum) between neighbouring samples above which more are taken.
const CONTRAST: f32 = 0.15;
/// Difference of light that is never seen, added to the allowed contrast.
const UNSEEN: f32 = 0.01;

/// The samples of a square.
struct Lattice {
    grid: Grid,
    /// Samples by row, then column, of the finest grid.
    nodes: [[Node; STEPS + 1]; STEPS + 1],
}

/// The traced pixels of a square.
enum Field {
    All,
    /// A bit for each traced pixel of its blocks of 8×8, by row, then column.
    Some([[u64; 4]; 4]),
}

/// Renders the pieces of a square of pixels.
pub(super) struct SquareRenderer<'r, 'a, const W: usize> {
    renderer: &'r Renderer<'a, W>,
    view: &'r View,
    lod: &'r LevelOfDetail,
    /// Where the square lies in the field.
    region: Region,
    /// Whether the whole square counts as lying in the field.
    is_inside: bool,
}

impl Lattice {
    fn node(&self, column: usize, row: usize) -> &Node {
        &self.nodes[row % (STEPS + 1)][column % (STEPS + 1)]
    }

    /// Returns the corner samples of a block of `step` steps a side.
    fn corners(&self, (column, row): (usize, usize), step: usize) -> [&Node; 4] {
        let (right, below) = (column + step, row + step);
        [
            self.node(column, row),
            self.node(right, row),
            self.node(column, below),
            self.node(right, below),
        ]
    }

    fn take(&mut self, batch: &mut Batch) {
        for (&(column, row), seen) in batch.nodes.iter().zip(&batch.seen).take(batch.count) {
            let (column, row) = (usize::from(column), usize::from(row));
            self.nodes[row % (STEPS + 1)][column % (STEPS + 1)] = *seen;
        }
        batch.count = 0;
    }
}

/// Returns whether the corners of a block see different objects, or very different light.
fn differs(corners: &[&Node; 4]) -> bool {
    let mut traced = corners.iter().filter(|node| node.class != SKIPPED);
    let Some(first) = traced.next() else {
        return false;
    };
    let of = |node: &Node| [node.pixel.red, node.pixel.green, node.pixel.blue];
    let (mut least, mut most) = (of(first), of(first));
    for node in traced {
        if node.class != first.class {
            return true;
        }
        for (channel, light) in of(node).into_iter().enumerate() {
            least[channel] = min(least[channel], light);
            most[channel] = max(most[channel], light);
        }
    }
    first.class != MISSED
        && least
            .iter()
            .zip(&most)
            .any(|(least, most)| most - least > CONTRAST * (most + least) + UNSEEN)
}

/// Fills the piece's part of a block from the samples at its corners.
fn fill(
    grid: &Grid,
    corners: &[&Node; 4],
    (column, row): (usize, usize),
    step: usize,
    field: &Field,
    target: &mut Target<'_>,
) {
    if corners.iter().all(|node| node.class >= SKIPPED) {
        return;
    }
    let alike = corners.iter().all(|node| node.class == corners[0].class);
    let Grid { piece, unit, .. } = grid;
    let side = step as u32 * unit;
    let (x, y) = grid.place(column, row);
    let tile = piece.tile;
    let (left, right) = (x.max(tile.x), (x + side).min(tile.x + tile.width));
    let (top, bottom) = (y.max(tile.y), (y + side).min(tile.y + tile.height));
    let share = 1.0 / side as f32;
    for row in top..bottom {
        let down = (row - y) as f32 * share;
        let start = (target.y + (row - tile.y) as usize) * target.width + target.x;
        let start = start + (left - tile.x) as usize;
        let pixels = target
            .pixels
            .get_mut(start..start + (right - left) as usize);
        let pixels = (left..right).zip(pixels.unwrap_or_default());
        if alike && matches!(field, Field::All) {
            let [a, b, c, d] = corners.map(|node| node.pixel);
            let (first, last) = (between(a, c, down), between(b, d, down));
            for (column, pixel) in pixels {
                *pixel = between(first, last, (column - x) as f32 * share);
            }
            continue;
        }
        for (column, pixel) in pixels {
            let right = (column - x) as f32 * share;
            if !field.has(piece, (column, row)) {
                continue;
            }
            if let Some(seen) = seen_between(corners, right, down) {
                *pixel = seen;
            }
        }
    }
}

/// Blends from `none` (share 0) to `all` (share 1).
#[inline(always)]
fn between(none: Pixel, all: Pixel, share: f32) -> Pixel {
    none.zip(all, |none, all| none + (all - none) * share)
}

/// Returns the pixel between four corners; `None` if they see no object there.
fn seen_between(corners: &[&Node; 4], right: f32, down: f32) -> Option<Pixel> {
    let (left, up) = (1.0 - right, 1.0 - down);
    let shares = [left * up, right * up, left * down, right * down];
    let mut nearest = (0.0, SKIPPED);
    for (node, share) in corners.iter().zip(shares) {
        if node.class != SKIPPED && (nearest.1 == SKIPPED || share > nearest.0) {
            nearest = (share, node.class);
        }
    }
    let (_, class) = nearest;
    if class >= SKIPPED {
        return None;
    }
    let (mut sum, mut all) = (Pixel::default(), 0.0);
    for (node, share) in corners.iter().zip(shares) {
        if node.class == class {
            sum = sum.zip(node.pixel, |sum, own| sum + own * share);
            all += share;
        }
    }
    // On an edge where the only corner of this class has no share.
    if !(all > 0.0) {
        let seen = corners.iter().find(|node| node.class == class);
        return seen.map(|node| node.pixel);
    }
    let share = 1.0 / all;
    Some(sum.zip(sum, |sum, _| sum * share))
}

impl Piece {
    /// Returns the pixels at the corners of its square's samples.
    fn corners(&self) -> [(u32, u32); 4] {
        let ((x, y), side) = (self.corner, self.side);
        [(x, y), (x + side, y), (x, y + side), (x + side, y + side)]
    }

    /// Returns where the samples of its square lie in the field.
    fn region(&self, lod: &LevelOfDetail, view: &View) -> Region {
        let Kind::Screen(screen) = view.kind() else {
            return Region::Mixed;
        };
        let corners = self.corners();
        let corners = corners.map(|(x, y)| screen.direction(x as f32, y as f32));
        lod.gaze.region_between(&corners)
    }

    /// Returns whether nine points of its square are in the field: cheaper than all levels.
    fn is_inside(&self, lod: &LevelOfDetail, view: &View) -> bool {
        let ((x, y), half) = (self.corner, self.side / 2);
        (0..9u32).all(|number| {
            let (x, y) = (x + number % 3 * half, y + number / 3 * half);
            let direction = view.direction(x as f32, y as f32);
            let level = direction.and_then(|direction| lod.gaze.level(direction));
            level.is_some_and(|level| level > 0.0)
        })
    }
}

impl<'r, 'a, const W: usize> SquareRenderer<'r, 'a, W>
where
    Simd: Runs<W>,
{
    /// Renders a piece with a stride above 1; returns false if the budget ends before the last
    /// sample.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    pub(super) fn render(
        piece: Piece,
        renderer: &'r Renderer<'a, W>,
        view: &'r View,
        work: &mut Work<'_>,
    ) -> bool {
        if work.begun.cell.is_none() {
            renderer.show_background(view, piece.tile, &mut work.target);
        }
        let Some(lod) = &renderer.lod else {
            return true;
        };
        let region = piece.region(lod, view);
        let seeing = Self {
            renderer,
            view,
            lod,
            region,
            is_inside: match region {
                Region::Central | Region::Traced(_) => true,
                Region::Outside => return true,
                Region::Mixed => piece.is_inside(lod, view),
            },
        };
        let mut grid = Grid::new(piece);
        if !work.begun.cell.is_none() {
            return seeing.render_cells(&grid, work);
        }
        let (steps, mut step) = (grid.steps(), grid.coarsest());
        let mut blocks = [0u16; STEPS];
        for row in (0..steps).step_by(step) {
            for column in (0..steps).step_by(step) {
                grid.request((column, row), step, &mut blocks);
            }
        }
        if let (Kind::Screen(screen), Some(_)) = (view.kind(), renderer.together)
            && !seeing.may_hit(&piece, screen, work)
        {
            work.workspace.statistics.primary += seeing.rays(&mut grid);
            return true;
        }
        let mut lattice = Lattice {
            grid,
            nodes: [[Node::SKIPPED; STEPS + 1]; STEPS + 1],
        };
        let field = seeing.field(&piece);
        loop {
            if !seeing.trace_lattice(&mut lattice, work) {
                if renderer.settings.samples == 1 {
                    return false;
                }
                work.begun.cell = Cell::first(&lattice.grid);
                return !work.budget.is_exhausted() && seeing.render_cells(&lattice.grid, work);
            }
            let half = step / 2;
            let mut parts = [0u16; STEPS];
            for row in (0..steps).step_by(step) {
                for column in (0..steps).step_by(step) {
                    if blocks[row % STEPS] >> column & 1 == 0 {
                        continue;
                    }
                    let corners = lattice.corners((column, row), step);
                    if half > 0 && differs(&corners) {
                        for (right, below) in [(0, 0), (half, 0), (0, half), (half, half)] {
                            let part = (column + right, row + below);
                            lattice.grid.request(part, half, &mut parts);
                        }
                    } else {
                        let (grid, target) = (&lattice.grid, &mut work.target);
                        fill(grid, &corners, (column, row), step, &field, target);
                    }
                }
            }
            if parts == [0; STEPS] {
                return true;
            }
            (blocks, step) = (parts, half);
        }
    }

    /// Returns whether any sample of a square may hit anything.
    fn may_hit(&self, piece: &Piece, screen: &Screen, work: &mut Work<'_>) -> bool {
        let around = spread(self.renderer.settings.samples);
        let ((x, y), side) = (piece.corner, piece.side);
        let [left, top] = [x, y].map(|first| first as f32 - around);
        let [right, below] = [x + side, y + side].map(|last| last as f32 + around);
        let corners = screen.corners_between((left, top), (right, below));
        let tracer = &self.renderer.tracer;
        tracer.may_hit(screen.eye, &corners, work.budget, work.workspace)
    }

    /// Traces the requested samples; returns false if the budget ends before the last.
    fn trace_lattice(&self, lattice: &mut Lattice, work: &mut Work<'_>) -> bool {
        let mut batch = Batch::NONE;
        let mut from = 0;
        loop {
            let next = lattice.grid.next(&mut from);
            if let Some((column, row)) = next {
                let place = lattice.grid.place(column, row);
                if let Some(detail) = self.detail(place) {
                    batch.push((column as u8, row as u8), place, detail);
                }
            }
            if next.is_none() || batch.count == TOGETHER {
                if !self.trace(&mut batch, work) {
                    return false;
                }
                lattice.take(&mut batch);
            }
            if next.is_none() {
                return true;
            }
        }
    }

    /// Returns whether the budget ends here. With one sample a pixel, a begun pixel is finished.
    fn ends(&self, work: &Work<'_>) -> bool {
        let budget = &*work.budget;
        budget.is_exhausted() || self.renderer.settings.samples > 1 && budget.is_spent()
    }

    /// Returns the detail of a pixel, which may be past the view's borders.
    fn detail(&self, (x, y): (u32, u32)) -> Option<RayDetail> {
        let most = self.renderer.most;
        match self.region {
            Region::Outside => None,
            Region::Central => Some(most),
            _ if self.is_inside && !self.lod.bounces && !self.lod.faces => Some(most),
            _ => {
                let view = self.view;
                let (x, y) = (x.min(view.columns() - 1), y.min(view.rows() - 1));
                let block = self.renderer.block_detail(Region::Mixed, view, x, y);
                block.at(x % BLOCK, y % BLOCK)
            }
        }
    }

    /// Returns the number of rays that the requested samples take.
    fn rays(&self, grid: &mut Grid) -> u64 {
        let (mut rays, mut from) = (0, 0);
        while let Some((column, row)) = grid.next(&mut from) {
            let detail = self.detail(grid.place(column, row));
            rays += u64::from(detail.is_some());
        }
        rays * u64::from(self.renderer.settings.samples)
    }

    /// Returns the traced pixels of a square.
    fn field(&self, piece: &Piece) -> Field {
        if self.is_inside {
            return Field::All;
        }
        let mut blocks = [[0; 4]; 4];
        let (left, top) = piece.corner;
        for (row, blocks) in (0u32..).zip(&mut blocks) {
            for (column, block) in (0u32..).zip(blocks) {
                let (x, y) = (left + BLOCK * column, top + BLOCK * row);
                if BLOCK * column.max(row) < piece.side {
                    let view = self.view;
                    *block = self.renderer.block_traced(Region::Mixed, view, x, y);
                }
            }
        }
        Field::Some(blocks)
    }
}

impl Field {
    /// Returns whether a pixel of the view is in the piece.
    fn has(&self, piece: &Piece, (x, y): (u32, u32)) -> bool {
        match self {
            Self::All => true,
            Self::Some(blocks) => {
                let (column, row) = (x - piece.corner.0, y - piece.corner.1);
                let block = blocks[(row / BLOCK) as usize % 4][(column / BLOCK) as usize % 4];
                block >> (BLOCK * (row % BLOCK) + column % BLOCK) & 1 != 0
            }
        }
    }
}
