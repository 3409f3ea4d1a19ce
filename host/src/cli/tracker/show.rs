//! Shows targets on the terminal, one after another.

use crate::cli::output::terminal_size;
use crate::tracker::calibration::TimedTarget;
use shisen_tracker::estimate::Screen;
use shisen_tracker::time::Micros;
use std::io::{self, Write};

/// Time until the first target, and of each target.
const STEP: Micros = Micros::from_millis(2_000);
/// Places of targets, as parts of the terminal's width and height.
const GRID: [f32; 3] = [0.1, 0.5, 0.9];

pub(super) struct Shown {
    /// Targets, and column and row of each from 0.
    targets: Vec<(TimedTarget, [u16; 2])>,
    /// The target on the screen.
    drawn: Option<usize>,
}

impl Shown {
    /// Plans the targets from `now` on; `None` if standard error is no terminal.
    pub(super) fn new(screen: &Screen, now: Micros) -> Option<Self> {
        let targets = on_cells(screen, terminal_size()?, now.after(STEP));
        Some(Self {
            targets,
            drawn: None,
        })
    }

    pub(super) fn targets(&self) -> Vec<TimedTarget> {
        self.targets.iter().map(|(target, _)| *target).collect()
    }

    /// Draws the target that is due.
    pub(super) fn show(&mut self, now: Micros) {
        let due = |(target, _): &(TimedTarget, _)| now >= target.start && now < target.end;
        let due = self.targets.iter().position(due);
        if due == self.drawn {
            return;
        }
        self.drawn = due;
        if let Some((_, [column, row])) = due.map(|due| self.targets[due]) {
            // Clears the screen and hides the cursor. Rows and columns count from 1.
            let (row, column) = (row + 1, column + 1);
            draw(&format!("\x1b[2J\x1b[?25l\x1b[{row};{column}H+"));
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        if self.drawn.is_some() {
            draw("\x1b[2J\x1b[H\x1b[?25h");
        }
    }
}

fn draw(what: &str) {
    // Where standard error is closed, nobody is left to look.
    let mut stderr = io::stderr();
    let _ = write!(stderr, "{what}").and_then(|()| stderr.flush());
}

/// Targets in the middle of cells of a terminal that fills `screen`, from `start` on.
fn on_cells(screen: &Screen, size: [u16; 2], start: Micros) -> Vec<(TimedTarget, [u16; 2])> {
    let mut targets = Vec::new();
    let mut start = start;
    for down in GRID {
        for along in GRID {
            let cell = |part: f32, count: u16| (part * f32::from(count)) as u16;
            let cells = [cell(along, size[0]), cell(down, size[1])];
            let part = |i: usize| (f32::from(cells[i]) + 0.5) / f32::from(size[i]);
            let place = screen.place(glam::Vec2::new(part(0), part(1)) * screen.size);
            let end = start.after(STEP);
            targets.push((TimedTarget { start, end, place }, cells));
            start = end;
        }
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn targets_are_where_their_cells_are() {
        let screen = Screen {
            corner: Vec3::new(-1.0, 0.5, -1.0),
            right: Vec3::X,
            down: Vec3::NEG_Y,
            size: Vec2::new(2.0, 1.0),
        };
        let targets = on_cells(&screen, [81, 25], Micros(7));
        assert_eq!(targets.len(), 9);
        let (first, cell) = targets[0];
        assert_eq!(cell, [8, 2]);
        let expected = Vec3::new(-1.0 + 2.0 * 8.5 / 81.0, 0.5 - 2.5 / 25.0, -1.0);
        assert!(first.place.distance(expected) < 1e-6);
        assert_eq!(first.start, Micros(7));
        for pair in targets.windows(2) {
            assert_eq!(pair[0].0.end, pair[1].0.start);
        }
    }
}
