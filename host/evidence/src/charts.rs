//! Parts of charts.

use shisen::picture::chart::{Axis, Line};
use std::ops::Range;

/// A line with a name.
pub(crate) fn line(
    name: impl Into<String>,
    colour: usize,
    points: impl IntoIterator<Item = (f64, Option<f64>)>,
) -> Line {
    Line {
        name: name.into(),
        points: points.into_iter().collect(),
        colour,
        faint: false,
        dots: false,
    }
}

/// A linear axis with a name in files and a label.
pub(crate) fn linear((name, label): (&'static str, &'static str), range: Range<f64>) -> Axis {
    Axis {
        name,
        label,
        range,
        logarithmic: false,
    }
}
