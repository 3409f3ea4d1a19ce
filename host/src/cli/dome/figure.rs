//! Charts that commands write, and their reports.

use crate::cli::prelude::*;
use crate::picture::chart::{Axis, Chart, Corner, Line, Names};

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Figure {
    /// Name of the files, without extensions.
    pub(super) name: String,
    /// Title of the chart.
    pub(super) title: String,
    /// Name of the x axis.
    x: &'static str,
    /// Name of the y axis.
    y: &'static str,
    /// File of the numbers.
    csv: String,
    /// File of the picture.
    svg: String,
    /// Lines of the chart.
    lines: Vec<Numbers>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Numbers {
    /// Name of the line.
    name: String,
    /// The x values.
    x: Vec<f64>,
    /// The y values; null where there is no number.
    y: Vec<Option<f64>>,
}

impl Figure {
    /// Writes a chart's picture and numbers to a folder that exists.
    pub(super) fn write(folder: &Path, name: &str, chart: Chart) -> Result<Self, Failure> {
        let csv = folder.join(format!("{name}.csv"));
        chart.write_csv(&csv).map_err(Fault::write(&csv))?;
        let svg = folder.join(format!("{name}.svg"));
        chart.write_svg(&svg).map_err(Fault::write(&svg))?;
        let lines = chart.lines.into_iter().map(|line| {
            let name = line.name;
            let (x, y) = line.points.into_iter().unzip();
            Numbers { name, x, y }
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

pub(super) fn logarithmic(axis: Axis) -> Axis {
    Axis {
        logarithmic: true,
        ..axis
    }
}

/// Returns a chart whose lines are named in a corner.
pub(super) fn chart(
    title: impl Into<String>,
    [x, y]: [Axis; 2],
    lines: Vec<Line>,
    names: Corner,
) -> Chart {
    Chart {
        title: title.into(),
        x,
        y,
        lines,
        names: Names::In(names),
        notes: Vec::new(),
    }
}
