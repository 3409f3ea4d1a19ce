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
    pub part: &'static str,
    pub subject: String,
    /// The rays, or another quantity.
    pub what: String,
    pub peer: String,
    pub mode: String,
    pub version: String,
    /// Instructions and lanes.
    pub simd: String,
    pub value: f64,
    pub unit: &'static str,
    /// How many times as fast ours is in the default build.
    pub default_ratio: Option<f64>,
    pub native_ratio: Option<f64>,
    /// The number of rays with another hit than ours.
    pub differ: Option<u64>,
    pub rays: Option<u64>,
}

impl Row {
    /// Returns a row of a part with nothing else filled in.
    pub fn of_part(part: &'static str) -> Self {
        Self {
            part,
            value: f64::NAN,
            ..Self::default()
        }
    }

    /// Returns a number of ours.
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
    pub what: String,
    pub measured: f64,
    pub mark: f64,
    /// Whether it is met at the mark and above, or at the mark and below.
    pub at_least: bool,
    pub met: bool,
}

/// A peer that is not measured.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    pub peer: String,
    pub reason: String,
}

/// The results of a run.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    /// The processor's name, as the system gives it.
    pub processor: String,
    pub rounds: usize,
    pub seed: u64,
    pub rows: Vec<Row>,
    pub marks: Vec<Mark>,
    pub missing: Vec<Missing>,
    /// Rays of ours that are lost, and paths of ours that differ.
    pub failures: Vec<String>,
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

    /// Returns the tables.
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

    /// Returns the rows, CSV.
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

/// Returns three digits or more.
fn number(value: f64) -> String {
    match value.abs() {
        magnitude if magnitude >= 1000.0 || value.fract() == 0.0 => format!("{value:.0}"),
        magnitude if magnitude >= 100.0 => format!("{value:.1}"),
        magnitude if magnitude >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
