//! Charts that commands write, and what they say of them.

use crate::cli::output::failure::{Failure, Fault};
use crate::picture::chart::Chart;
use serde::Serialize;
use std::path::Path;

/// A chart and its files, by their paths: the folder as given, and their names.
#[derive(Debug, Serialize)]
pub(super) struct Figure {
    /// Of the files, without their endings.
    pub(super) name: String,
    pub(super) title: String,
    /// What x and y are, as in the numbers' file.
    pub(super) x: &'static str,
    pub(super) y: &'static str,
    pub(super) csv: String,
    pub(super) svg: String,
    pub(super) lines: Vec<Line>,
}

/// Numbers of a line.
#[derive(Debug, Serialize)]
pub(super) struct Line {
    pub(super) name: String,
    pub(super) x: Vec<f64>,
    /// None where there is no such number.
    pub(super) y: Vec<Option<f64>>,
}

impl Figure {
    /// Writes a chart's picture and numbers to a folder that exists.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(folder: &Path, name: &str, chart: Chart) -> Result<Self, Failure> {
        let csv = folder.join(format!("{name}.csv"));
        chart.write_csv(&csv).map_err(Fault::write(&csv))?;
        let svg = folder.join(format!("{name}.svg"));
        chart.write_svg(&svg).map_err(Fault::write(&svg))?;
        let lines = chart.lines.into_iter().map(|line| {
            let (x, y) = line.points.into_iter().unzip();
            Line {
                name: line.name,
                x,
                y,
            }
        });
        Ok(Self {
            name: name.to_owned(),
            x: chart.x.name,
            y: chart.y.name,
            csv: csv.display().to_string(),
            svg: svg.display().to_string(),
            lines: lines.collect(),
            title: chart.title,
        })
    }
}
