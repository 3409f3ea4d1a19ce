//! Samples of a square of pixels, and what lies between them.

mod batch;
mod cell;
mod grid;
mod piece;

use super::begun::Begun;
use super::block::spread;
use super::tile::{BLOCK, Target};
use super::view::{Kind, Screen, View};
use super::{LevelOfDetail, Renderer};
use crate::gaze::Region;
use crate::numeric::{max, min};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Hit, Pixel, RayDetail, Workspace};
use batch::{Batch, TOGETHER};
pub(super) use cell::Cell;
use grid::Grid;
pub(super) use piece::Piece;

/// Most steps of the finest samples along a square's side.
const STEPS: usize = 16;

/// Number of times that the distance of samples is halved where they differ.
const HALVINGS: u32 = 2;

/// Contrast (difference by sum) between neighbouring samples above which more are taken.
const CONTRAST: f32 = 0.15;
/// Difference of light that is never seen, added to the allowed contrast.
const UNSEEN: f32 = 0.01;

/// What a sample sees.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    pixel: Pixel,
    /// The instance, [`MISSED`] or [`SKIPPED`].
    class: u32,
}

/// Past all objects: every pixel knows what it sees there.
const MISSED: u32 = u32::MAX;

/// Outside the visual field, or a dome master's rim.
const SKIPPED: u32 = u32::MAX - 1;

/// The samples of a square.
pub(super) struct Lattice {
    grid: Grid,
    /// Samples by row, then column, of the finest grid.
    nodes: [[Node; STEPS + 1]; STEPS + 1],
}

/// Which pixels of a square are traced.
enum Field {
    All,
    /// A bit for each traced pixel of its blocks of 8×8, by row, then column.
    Some([[u64; 4]; 4]),
}

/// How a square is rendered.
struct Seeing<'r, 'a, const W: usize> {
    renderer: &'r Renderer<'a, W>,
    view: &'r View,
    lod: &'r LevelOfDetail,
    /// Where the square lies in the field.
    region: Region,
    /// Whether the whole square counts as lying in the field.
    is_inside: bool,
}

impl Node {
    const SKIPPED: Self = Self {
        pixel: Pixel::NONE,
        class: SKIPPED,
    };

    fn class_of(hit: Option<&Hit>) -> u32 {
        hit.map_or(MISSED, |hit| hit.instance)
    }
}

impl Lattice {
    /// Renders a piece whose samples are apart; false where the budget ends before the last.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    pub(super) fn render<const W: usize>(
        piece: Piece,
        renderer: &Renderer<'_, W>,
        view: &View,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        if begun.cell.is_none() {
            piece.show_background(renderer, view, target);
        }
        let Some(lod) = &renderer.lod else {
            return true;
        };
        let region = piece.region(lod, view);
        let seeing = Seeing {
            renderer,
            view,
            lod,
            region,
            is_inside: match region {
                Region::Central | Region::Traced(_) => true,
                Region::Outside => false,
                Region::Mixed => piece.is_inside(lod, view),
            },
        };
        if seeing.region == Region::Outside {
            return true;
        }
        let mut grid = Grid::new(piece);
        if !begun.cell.is_none() {
            return seeing.render_cells(&grid, begun, budget, workspace, target);
        }
        let (steps, mut step) = (grid.steps(), grid.coarsest());
        let mut blocks = [0u16; STEPS];
        for row in (0..steps).step_by(step) {
            for column in (0..steps).step_by(step) {
                grid.request((column, row), step, &mut blocks);
            }
        }
        if let (Kind::Screen(screen), Some(_)) = (view.kind(), renderer.together)
            && !piece.may_hit(renderer, screen, budget, workspace)
        {
            workspace.statistics.primary += seeing.rays(&mut grid);
            return true;
        }
        let mut lattice = Self {
            grid,
            nodes: [[Node::SKIPPED; STEPS + 1]; STEPS + 1],
        };
        let field = seeing.field(&piece);
        loop {
            if !lattice.trace(&seeing, budget, workspace) {
                if renderer.settings.samples == 1 {
                    return false;
                }
                begun.cell = Cell::first(&lattice.grid);
                return !budget.is_exhausted()
                    && seeing.render_cells(&lattice.grid, begun, budget, workspace, target);
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
                        fill(&lattice.grid, &corners, (column, row), step, &field, target);
                    }
                }
            }
            if parts == [0; STEPS] {
                return true;
            }
            (blocks, step) = (parts, half);
        }
    }

    fn node(&self, column: usize, row: usize) -> &Node {
        &self.nodes[row % (STEPS + 1)][column % (STEPS + 1)]
    }

    /// The corner samples of a block of `step` steps a side.
    fn corners(&self, (column, row): (usize, usize), step: usize) -> [&Node; 4] {
        let (right, below) = (column + step, row + step);
        [
            self.node(column, row),
            self.node(right, row),
            self.node(column, below),
            self.node(right, below),
        ]
    }

    /// Traces the requested samples. False where the budget ends before.
    fn trace<const W: usize>(
        &mut self,
        seeing: &Seeing<'_, '_, W>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        let mut batch = Batch::NONE;
        let mut from = 0;
        loop {
            let next = self.grid.next(&mut from);
            if let Some((column, row)) = next {
                let place = self.grid.place(column, row);
                if let Some(detail) = seeing.detail(place) {
                    batch.push((column as u8, row as u8), place, detail);
                }
            }
            if next.is_none() || batch.count == TOGETHER {
                if !seeing.trace(&mut batch, budget, workspace) {
                    return false;
                }
                self.take(&mut batch);
            }
            if next.is_none() {
                return true;
            }
        }
    }

    /// Stores what a batch has seen.
    fn take(&mut self, batch: &mut Batch) {
        for (&(column, row), seen) in batch.nodes.iter().zip(&batch.seen).take(batch.count) {
            let (column, row) = (usize::from(column), usize::from(row));
            self.nodes[row % (STEPS + 1)][column % (STEPS + 1)] = *seen;
        }
        batch.count = 0;
    }
}

/// Whether the corners of a block see different things, or very different light.
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

/// Fills the piece's part of a block with what its corners see.
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
    let (left, right) = (x.max(piece.x), (x + side).min(piece.x + piece.columns));
    let (top, bottom) = (y.max(piece.y), (y + side).min(piece.y + piece.rows));
    let share = 1.0 / side as f32;
    for row in top..bottom {
        let down = (row - y) as f32 * share;
        let start = (target.y + (row - piece.y) as usize) * target.width + target.x;
        let start = start + (left - piece.x) as usize;
        let pixels = target
            .pixels
            .get_mut(start..start + (right - left) as usize);
        let pixels = (left..right).zip(pixels.unwrap_or_default());
        if alike && matches!(field, Field::All) {
            let [a, b, c, d] = corners.map(|node| &node.pixel);
            let (first, last) = (between(a, c, down), between(b, d, down));
            for (column, pixel) in pixels {
                *pixel = between(&first, &last, (column - x) as f32 * share);
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
fn between(none: &Pixel, all: &Pixel, share: f32) -> Pixel {
    let mix = |none: f32, all: f32| none + (all - none) * share;
    Pixel {
        red: mix(none.red, all.red),
        green: mix(none.green, all.green),
        blue: mix(none.blue, all.blue),
        alpha: mix(none.alpha, all.alpha),
    }
}

/// What is seen between four corners: `None` past all objects.
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
            sum.red += node.pixel.red * share;
            sum.green += node.pixel.green * share;
            sum.blue += node.pixel.blue * share;
            sum.alpha += node.pixel.alpha * share;
            all += share;
        }
    }
    // On an edge, where the only corner of this class has no share.
    if !(all > 0.0) {
        let seen = corners.iter().find(|node| node.class == class);
        return seen.map(|node| node.pixel);
    }
    let share = 1.0 / all;
    Some(Pixel {
        red: sum.red * share,
        green: sum.green * share,
        blue: sum.blue * share,
        alpha: sum.alpha * share,
    })
}

impl Piece {
    /// The pixels at the corners of its square's samples.
    fn corners(&self) -> [(u32, u32); 4] {
        let ((x, y), side) = (self.corner, self.side);
        [(x, y), (x + side, y), (x, y + side), (x + side, y + side)]
    }

    /// Whether any sample of the square may hit anything.
    fn may_hit<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        screen: &Screen,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        let around = spread(renderer.settings.samples);
        let ((x, y), side) = (self.corner, self.side);
        let [left, top] = [x, y].map(|first| first as f32 - around);
        let [right, below] = [x + side, y + side].map(|last| last as f32 + around);
        let corners = [(left, top), (right, top), (left, below), (right, below)];
        let corners = corners.map(|(x, y)| screen.direction(x, y));
        renderer
            .tracer
            .may_hit(screen.eye, &corners, budget, workspace)
    }

    /// Where the samples of its square lie in the field.
    fn region(&self, lod: &LevelOfDetail, view: &View) -> Region {
        let Kind::Screen(screen) = view.kind() else {
            return Region::Mixed;
        };
        let corners = self.corners();
        let corners = corners.map(|(x, y)| screen.direction(x as f32, y as f32));
        lod.gaze.region_between(&corners)
    }

    /// Whether nine points of its square are in the field: cheaper than all levels.
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

impl<const W: usize> Seeing<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Whether the budget ends here. One sample a pixel is finished once it is begun.
    fn ends(&self, budget: &Budget) -> bool {
        budget.is_exhausted() || self.renderer.settings.samples > 1 && budget.is_spent()
    }

    /// Detail of the pixel at a place, which may be past the view's borders.
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

    /// Number of rays that the requested samples take.
    fn rays(&self, grid: &mut Grid) -> u64 {
        let (mut rays, mut from) = (0, 0);
        while let Some((column, row)) = grid.next(&mut from) {
            let detail = self.detail(grid.place(column, row));
            rays += u64::from(detail.is_some());
        }
        rays * u64::from(self.renderer.settings.samples)
    }

    /// Which pixels of a square are traced.
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
    /// Whether it has a pixel of the view.
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
