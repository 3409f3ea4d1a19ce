//! The numbers of a report as a table for programs.

use super::Report;
use serde_json::Value;

const HEAD: &str = "section,comparison,series,name,settings,measure,error,seconds,spread,steps,\
                    best_by_time,best_by_steps";

/// CSV with a row for each error of each point: section, comparison, series, name,
/// settings (`name=value`, between semicolons), measure, error (empty for no number), seconds,
/// spread (between the quartiles), steps (empty where none are counted), and whether the point
/// is on the front of error and time, and of error and steps. Then a row for each way of each
/// hard case (comparison: its group; series: built in, bound or textbook; no error where it was
/// infinite), and one for each tile: the error is the share of the steps with which it is whole.
///
/// # Errors
/// The errors of the writer.
pub(crate) fn csv(report: &Report) -> Result<String, csv::Error> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record(HEAD.split(','))?;
    let cell = |error: Option<f64>| error.map_or(String::new(), |error| error.to_string());
    for section in &report.sections {
        for comparison in &section.comparisons {
            for point in &comparison.points {
                let settings = point.settings.iter();
                let settings = settings.map(|(key, value)| format!("{key}={}", plain(value)));
                let settings = settings.collect::<Vec<_>>().join(";");
                for (measure, error) in comparison.measures.iter().zip(&point.errors) {
                    rows.write_record([
                        section.id,
                        comparison.id,
                        point.series,
                        &point.name,
                        &settings,
                        measure.id,
                        &cell(*error),
                        &point.seconds.to_string(),
                        &point.spread.to_string(),
                        &point.steps.map_or(String::new(), |steps| steps.to_string()),
                        &point.best_by_time.to_string(),
                        &point.best_by_steps.to_string(),
                    ])?;
                }
            }
        }
    }
    for section in &report.sections {
        // Without a cost.
        let mut row = |texts: [&str; 6]| {
            let cells = [section.id].into_iter().chain(texts).chain([""; 5]);
            rows.write_record(cells)
        };
        for outcome in &section.hard_cases {
            let case = outcome.case;
            for (way, error) in [
                ("built in", outcome.error),
                ("bound", case.bound),
                ("textbook", outcome.naive_error),
            ] {
                let error = cell(Some(error).filter(|error| error.is_finite()));
                let settings = format!("control={}", outcome.control);
                row([outcome.group, way, case.name, &settings, case.error, &error])?;
            }
        }
        for tile in &section.tiles {
            let (picture, x, y) = (tile.picture, tile.x, tile.y);
            let settings = format!("picture={picture};x={x};y={y}");
            let name = format!("tile {picture} {x} {y}");
            let percent = tile.percent.to_string();
            row([
                "tiles",
                "tiles",
                &name,
                &settings,
                "budget_percent",
                &percent,
            ])?;
        }
    }
    let bytes = rows.into_inner().map_err(csv::IntoInnerError::into_error)?;
    // All of it was written as text.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns a setting as people write it.
pub(super) fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
