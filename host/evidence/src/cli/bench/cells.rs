//! Tables with a column for each of the paper's scenes and gazes.

use serde::Serialize;
use shisen::cli::output::counted;
use std::fmt;

/// What frames were rendered, as a report and a table's first line begin.
#[derive(Debug, Serialize)]
pub(super) struct Title {
    pub(super) threads: usize,
    /// Pixels along each side of a wall.
    pub(super) size: u32,
    pub(super) mesh: String,
}

impl fmt::Display for Title {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            mesh,
            size,
            threads,
        } = self;
        let threads = counted(*threads as u64, "thread");
        write!(f, "{mesh}, {size} × {size} pixels × 6, {threads}")
    }
}

/// The rows of a table, as they are written.
pub(super) struct Rows<'f, 'b, 'c, C> {
    f: &'f mut fmt::Formatter<'b>,
    cells: &'c [C],
    /// Characters of a row's name.
    width: usize,
}

impl<'f, 'b, 'c, C> Rows<'f, 'b, 'c, C> {
    /// Writes the columns' names: the letter of a cell's scene, and its gaze, 1 or 2.
    pub(super) fn new(
        f: &'f mut fmt::Formatter<'b>,
        cells: &'c [C],
        width: usize,
        of: impl Fn(&C) -> (&'static str, usize),
    ) -> Result<Self, fmt::Error> {
        write!(f, "{:width$}", "")?;
        for cell in cells {
            let (scene, state) = of(cell);
            write!(f, "{:>9}", format!("{scene}{state}"))?;
        }
        Ok(Self { f, cells, width })
    }

    /// Writes a row.
    pub(super) fn row(&mut self, name: &str, value: impl Fn(&C) -> String) -> fmt::Result {
        let Self { f, cells, width } = self;
        write!(f, "\n{name:width$}", width = *width)?;
        cells
            .iter()
            .try_for_each(|cell| write!(f, "{:>9}", value(cell)))
    }

    /// The same of numbers: `-` where there is none.
    pub(super) fn numbers(
        &mut self,
        name: &str,
        digits: usize,
        value: impl Fn(&C) -> Option<f64>,
    ) -> fmt::Result {
        self.row(name, |cell| match value(cell) {
            Some(value) => format!("{value:.digits$}"),
            None => "-".to_owned(),
        })
    }
}
