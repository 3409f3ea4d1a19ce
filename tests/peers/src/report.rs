//! Measurements as a table for people and as files for programs.

use super::contender::locked;
use super::table::Table;
use serde::Serialize;
use shisen::files::write_atomically;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// One measurement.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Row {
    /// The part of the program that measured it.
    pub part: &'static str,
    /// The mesh or scene.
    pub subject: String,
    /// The rays, or another quantity.
    pub what: String,
    /// The peer.
    pub peer: String,
    /// The peer's mode.
    pub mode: String,
    /// The peer's version.
    pub version: String,
    /// Instructions and lanes.
    pub simd: String,
    /// The median.
    pub value: f64,
    /// The unit of the value.
    pub unit: &'static str,
    /// How many times as fast ours is in the default build.
    pub default_ratio: Option<f64>,
    /// The same of the native build.
    pub native_ratio: Option<f64>,
    /// The number of rays with another hit than ours.
    pub differ: Option<u64>,
    /// Number of rays.
    pub rays: Option<u64>,
}

impl Row {
    /// A row of a part with nothing else filled in.
    pub fn of_part(part: &'static str) -> Self {
        Self {
            part,
            value: f64::NAN,
            ..Self::default()
        }
    }

    /// A number of ours.
    pub fn of_ours(part: &'static str, value: f64, unit: &'static str) -> Self {
        Self {
            peer: "Shisen".to_owned(),
            version: locked("shisen"),
            value,
            unit,
            ..Self::of_part(part)
        }
    }
}

/// A mark that is met or missed.
#[derive(Debug, Clone, Serialize)]
pub struct Mark {
    /// The quantity.
    pub what: String,
    /// The measured value.
    pub measured: f64,
    /// The mark.
    pub mark: f64,
    /// Whether it is met at the mark and above, or at the mark and below.
    pub at_least: bool,
    /// Whether it is met.
    pub met: bool,
}

/// A peer that is not measured.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    /// The peer.
    pub peer: String,
    /// The reason.
    pub reason: String,
}

/// The results of a run.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    /// The processor's name, as the system gives it.
    pub processor: String,
    /// Its caches of data: level and bytes.
    pub caches: Vec<(u32, u64)>,
    /// Rounds of a median.
    pub rounds: usize,
    /// The seed of random rays.
    pub seed: u64,
    /// Measurements.
    pub rows: Vec<Row>,
    /// Marks.
    pub marks: Vec<Mark>,
    /// Peers that were not measured.
    pub missing: Vec<Missing>,
    /// Rays of ours that are lost, and paths of ours that differ.
    pub failures: Vec<String>,
    /// Charts in the folder.
    pub charts: Vec<String>,
}

impl Report {
    /// Adds a mark that is met at `mark` and above.
    pub fn at_least(&mut self, what: impl Into<String>, measured: f64, mark: f64) {
        self.mark(what.into(), measured, mark, true);
    }

    /// Adds a mark that is met at `mark` and below.
    pub fn at_most(&mut self, what: impl Into<String>, measured: f64, mark: f64) {
        self.mark(what.into(), measured, mark, false);
    }

    fn mark(&mut self, what: String, measured: f64, mark: f64, at_least: bool) {
        let met = if at_least {
            measured >= mark
        } else {
            measured <= mark
        };
        self.marks.push(Mark {
            what,
            measured,
            mark,
            at_least,
            met,
        });
    }

    /// The tables.
    pub fn text(&self) -> String {
        let mut text = String::new();
        let ratio = |ratio: Option<f64>| ratio.map_or(String::new(), |r| format!("{r:.2}"));
        // Writing to a string does not fail.
        for rows in self.rows.chunk_by(|a, b| a.part == b.part) {
            let table = Table::new(rows)
                .text("subject", |row| row.subject.clone())
                .text("what", |row| row.what.clone())
                .text("peer", |row| {
                    format!("{} {} {}", row.peer, row.version, row.mode)
                })
                .text("median", |row| {
                    format!("{} {}", number(row.value), row.unit)
                })
                .text("default/", |row| ratio(row.default_ratio))
                .text("native/", |row| ratio(row.native_ratio))
                .text("other hits", |row| match (row.differ, row.rays) {
                    (Some(differ), Some(rays)) => format!("{differ} of {rays}"),
                    (None, Some(rays)) => format!("of {rays}"),
                    _ => String::new(),
                })
                .text("", |row| row.simd.clone());
            let _ = writeln!(text, "\n{}\n{table:#}", rows[0].part);
        }
        let marks = Table::new(&self.marks)
            .text("marks", |mark| mark.what.clone())
            .text("measured", |mark| number(mark.measured))
            .text("", |mark| {
                let side = if mark.at_least { "at least" } else { "at most" };
                format!("{side} {}", number(mark.mark))
            })
            .text("", |mark| {
                if mark.met { "met" } else { "MISSED" }.to_owned()
            });
        let _ = writeln!(text, "\n{marks:#}");
        for Missing { peer, reason } in &self.missing {
            let _ = writeln!(text, "not measured: {peer}: {reason}");
        }
        for failure in &self.failures {
            let _ = writeln!(text, "FAILED: {failure}");
        }
        text
    }

    /// The rows, CSV.
    ///
    /// # Errors
    /// What the system reports.
    pub fn write_csv(&self, path: &Path) -> io::Result<()> {
        write_atomically(path, |file| {
            let mut table = csv::Writer::from_writer(file);
            for row in &self.rows {
                table.serialize(row)?;
            }
            table.flush()
        })
    }
}

/// Three digits or more.
fn number(value: f64) -> String {
    match value.abs() {
        magnitude if magnitude >= 1000.0 || value.fract() == 0.0 => format!("{value:.0}"),
        magnitude if magnitude >= 100.0 => format!("{value:.1}"),
        magnitude if magnitude >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_met_or_missed() {
        let mut report = Report::default();
        report.at_least("rays", 1.0, 1.0);
        report.at_least("rays", 0.99, 1.0);
        report.at_most("bake", 149.0, 150.0);
        report.at_most("bake", f64::NAN, 150.0);
        let met: Vec<_> = report.marks.iter().map(|mark| mark.met).collect();
        assert_eq!(met, [true, false, true, false]);
        assert_eq!(report.text().matches("MISSED").count(), 2);
    }

    #[test]
    fn numbers_have_three_digits() {
        let written = [12345.6, 123.45, 12.345, 0.12345, 0.0].map(number);
        assert_eq!(written, ["12346", "123.5", "12.35", "0.123", "0"]);
    }
}
