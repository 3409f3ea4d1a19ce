//! The numbers of a report as a table for programs.

use super::Report;
use serde_json::Value;

/// CSV, a row for each error of each point: section, comparison, series, name,
/// settings (`name=value`, between semicolons), measure, error (empty where there
/// is no such number), seconds, spread (of these, between quartiles), steps (empty where none are counted), and whether
/// the point is on the front of error and time, and of error and steps. Then a row for
/// each way of each hard case (comparison: its group; series: built in, bound or
/// textbook; no error where it was infinite), and one for each tile of the frame whose
/// steps are counted out: the error is the share of the steps with which it is whole.
///
/// # Errors
/// Whatever the writer says.
pub fn csv(report: &Report) -> Result<String, csv::Error> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record([
        "section",
        "comparison",
        "series",
        "name",
        "settings",
        "measure",
        "error",
        "seconds",
        "spread",
        "steps",
        "best_by_time",
        "best_by_steps",
    ])?;
    for section in &report.sections {
        for comparison in &section.comparisons {
            for point in &comparison.points {
                let settings: Vec<String> = point
                    .settings
                    .iter()
                    .map(|(key, value)| format!("{key}={}", plain(value)))
                    .collect();
                for (measure, error) in comparison.measures.iter().zip(&point.errors) {
                    rows.write_record([
                        section.id,
                        comparison.id,
                        point.series,
                        &point.name,
                        &settings.join(";"),
                        measure.id,
                        &error.map_or(String::new(), |error| error.to_string()),
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
        for case in &section.hard_cases {
            for (way, error) in [
                ("built in", case.error),
                ("bound", case.bound),
                ("textbook", case.naive_error),
            ] {
                let error = if error.is_finite() {
                    error.to_string()
                } else {
                    String::new()
                };
                let settings = format!("control={}", case.control);
                rows.write_record([
                    section.id, case.group, way, case.name, &settings, case.unit, &error, "", "",
                    "", "", "",
                ])?;
            }
        }
        for tile in &section.tiles {
            let settings = format!("picture={};x={};y={}", tile.picture, tile.x, tile.y);
            let name = format!("tile {} {} {}", tile.picture, tile.x, tile.y);
            rows.write_record([
                section.id,
                "tiles",
                "tiles",
                &name,
                &settings,
                "budget_percent",
                &tile.percent.to_string(),
                "",
                "",
                "",
                "",
                "",
            ])?;
        }
    }
    let bytes = rows.into_inner().map_err(csv::IntoInnerError::into_error)?;
    // All of it was written as text.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A setting as people write it.
pub(super) fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::page::tests::report;
    use super::*;

    #[test]
    fn every_error_of_every_point_has_a_row() {
        let report = report();
        let text = csv(&report).unwrap();
        let mut rows = csv::Reader::from_reader(text.as_bytes());
        let columns = rows.headers().unwrap().len();
        let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
        let comparisons = report.sections.iter().flat_map(|one| &one.comparisons);
        let points: usize = comparisons
            .map(|one| one.points.len() * one.measures.len())
            .sum();
        // A hard case's three ways, and a tile.
        assert!(points > 0 && rows.len() == points + 3 + 1, "{text}");
        assert!(rows.iter().all(|row| row.len() == columns));
        assert_eq!(&rows[0][4], "depth=3;method=a & b");
        assert_eq!(&rows[0][6], "0.25");
        // No number, no text.
        assert_eq!(&rows[1][6], "");
        let ways: Vec<[&str; 3]> = rows[points..points + 3]
            .iter()
            .map(|row| [&row[2], &row[3], &row[6]])
            .collect();
        assert_eq!(
            ways,
            [
                ["built in", "sphere-far", "0.5"],
                ["bound", "sphere-far", "1"],
                ["textbook", "sphere-far", ""],
            ]
        );
        let tile = &rows[points + 3];
        assert_eq!([&tile[4], &tile[6]], ["picture=1;x=16;y=32", "35"]);
    }
}
