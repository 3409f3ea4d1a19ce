//! The rest of an interrupted square, cell by cell: a cell lies between four samples.

use super::grid::Grid;
use super::{SquareRenderer, differs, fill};
use crate::frame::begun::{Cell, Node, Work};
use crate::simd::{Runs, Simd};

impl Cell {
    pub(super) const fn is_none(&self) -> bool {
        self.step == 0
    }

    pub(super) fn first(grid: &Grid) -> Self {
        Self::NONE.with_shared(0, 0, grid.coarsest() as u8)
    }

    /// Another cell, with the corners that it shares with this one.
    fn with_shared(&self, column: u8, row: u8, step: u8) -> Self {
        let mut other = Self {
            column,
            row,
            step,
            ..Self::NONE
        };
        for number in 0..4 {
            let is_shared =
                |own: &usize| self.has(*own) && self.corner(*own) == other.corner(number);
            if let Some(node) = (0..4).find(is_shared).and_then(|own| self.corners.get(own)) {
                other.set(number, *node);
            }
        }
        other
    }

    /// Returns the cell after this one and all of its parts; `None` after a square's last.
    fn next(&self, grid: &Grid) -> Option<Self> {
        let (coarsest, steps) = (grid.coarsest() as u8, grid.steps() as u8);
        let (mut column, mut row, mut step) = (self.column, self.row, self.step);
        // The quarters of a larger cell, row by row.
        while step < coarsest {
            if column & step == 0 {
                return Some(self.with_shared(column + step, row, step));
            }
            column -= step;
            if row & step == 0 {
                return Some(self.with_shared(column, row + step, step));
            }
            row -= step;
            step *= 2;
        }
        if column + step < steps {
            Some(self.with_shared(column + step, row, step))
        } else if row + step < steps {
            Some(self.with_shared(0, row + step, step))
        } else {
            None
        }
    }

    fn corner(&self, number: usize) -> (usize, usize) {
        let right = usize::from(self.step) * (number & 1);
        let below = usize::from(self.step) * (number >> 1);
        (
            usize::from(self.column) + right,
            usize::from(self.row) + below,
        )
    }

    fn has(&self, corner: usize) -> bool {
        self.known >> corner & 1 != 0
    }

    fn set(&mut self, corner: usize, node: Node) {
        self.corners[corner % 4] = node;
        self.known |= 1 << corner;
    }
}

impl<const W: usize> SquareRenderer<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Renders the cells of a square from the one begun on. False where the budget ends before.
    pub(super) fn render_cells(&self, grid: &Grid, work: &mut Work<'_>) -> bool {
        let field = self.field(&grid.piece);
        loop {
            let Cell {
                column, row, step, ..
            } = work.begun.cell;
            let (at, side) = ((column.into(), row.into()), step.into());
            if grid.meets(at, side) {
                if !self.trace_corners(grid, work) {
                    return false;
                }
                let corners = work.begun.cell.corners.each_ref();
                if step > 1 && differs(&corners) {
                    work.begun.cell = work.begun.cell.with_shared(column, row, step / 2);
                    continue;
                }
                fill(grid, &corners, at, side, &field, &mut work.target);
            }
            match work.begun.cell.next(grid) {
                Some(next) => work.begun.cell = next,
                None => return true,
            }
        }
    }

    /// Traces the missing corners; false where the budget ends before the last sample.
    fn trace_corners(&self, grid: &Grid, work: &mut Work<'_>) -> bool {
        let samples = self.renderer.settings.samples;
        for corner in 0..4 {
            let cell = &work.begun.cell;
            if cell.has(corner) {
                continue;
            }
            let (column, row) = cell.corner(corner);
            let place = grid.place(column, row);
            let mut node = cell.corners[corner];
            if let Some(detail) = self.detail(place) {
                while work.begun.samples < samples {
                    if work.begun.is_interrupted(work.budget) {
                        return false;
                    }
                    let seen = self.see(place, detail, work.begun.samples, work);
                    if work.budget.is_exhausted() {
                        return false;
                    }
                    let seen = seen.unwrap_or(Node::SKIPPED);
                    if work.begun.samples == 0 {
                        node.class = seen.class;
                        work.begun.cell.corners[corner] = node;
                    }
                    work.begun.add(seen.pixel, work.workspace);
                }
                node.pixel = work.begun.take_pixel(samples);
            }
            work.begun.cell.set(corner, node);
            if work.budget.is_spent() {
                return false;
            }
        }
        true
    }
}
