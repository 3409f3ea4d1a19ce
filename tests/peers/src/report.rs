//! What was measured, as a table for people and as files for programs.

use serde::Serialize;
use shisen::files::write_atomically;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// One measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Which part of the program measured it.
    pub part: &'static str,
    /// The mesh or scene.
    pub subject: String,
    /// The rays, or what else was measured.
    pub what: String,
    /// Whose.
    pub peer: String,
    /// How.
    pub mode: String,
    /// Which version.
    pub version: String,
    /// Instructions and lanes.
    pub simd: String,
    /// The median.
    pub value: f64,
    /// The unit of the value.
    pub unit: &'static str,
    /// How many times as good ours is in the default build; of Mrays/s and of
    /// seconds alike, above 1 ours is ahead.
    pub default_ratio: Option<f64>,
    /// The same of the native build.
    pub native_ratio: Option<f64>,
    /// Rays whose hit is another than ours.
    pub differ: Option<u64>,
    /// Number of rays.
    pub rays: Option<u64>,
}

impl Row {
    /// A row of a part in which nothing else is filled in.
    pub fn of_part(part: &'static str) -> Self {
        Self {
            part,
            subject: String::new(),
            what: String::new(),
            peer: String::new(),
            mode: String::new(),
            version: String::new(),
            simd: String::new(),
            value: f64::NAN,
            unit: "",
            default_ratio: None,
            native_ratio: None,
            differ: None,
            rays: None,
        }
    }
}

/// A mark that is met or missed.
#[derive(Debug, Clone, Serialize)]
pub struct Mark {
    /// What was measured.
    pub what: String,
    /// What was measured.
    pub measured: f64,
    /// The mark.
    pub mark: f64,
    /// Whether it is met from there up, or from there down.
    pub at_least: bool,
    /// Whether it is met.
    pub met: bool,
}

/// Somebody who is not measured.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    /// Who.
    pub peer: String,
    /// Why.
    pub reason: String,
}

/// All that a run found.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    /// The processor's name, as the system gives it.
    pub processor: String,
    /// Its caches of data: level and bytes.
    pub caches: Vec<(u32, u64)>,
    /// Rounds that medians are of.
    pub rounds: usize,
    /// Where random rays begin.
    pub seed: u64,
    /// Measurements.
    pub rows: Vec<Row>,
    /// Marks.
    pub marks: Vec<Mark>,
    /// Peers that were not measured.
    pub missing: Vec<Missing>,
    /// What must not be: rays of ours that are lost, or paths of ours that differ.
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
        let width = |of: fn(&Row) -> usize| self.rows.iter().map(of).max().unwrap_or(0).max(4);
        let subjects = width(|row| row.subject.chars().count());
        let whats = width(|row| row.what.chars().count());
        // Writing to a string does not fail.
        let mut last = "";
        for row in &self.rows {
            if row.part != last {
                let _ = writeln!(
                    text,
                    "\n{}\n{:<subjects$} {:<whats$} {:<46} {:>10} {:<8} {:>8} {:>8} {:>18}",
                    row.part,
                    "of",
                    "what",
                    "who",
                    "median",
                    "",
                    "default/",
                    "native/",
                    "other hits"
                );
                last = row.part;
            }
            let ratio = |ratio: Option<f64>| ratio.map_or(String::new(), |r| format!("{r:.2}"));
            let who = format!("{} {} {}", row.peer, row.version, row.mode);
            let differ = match (row.differ, row.rays) {
                (Some(differ), Some(rays)) => format!("{differ} of {rays}"),
                (None, Some(rays)) => format!("of {rays}"),
                _ => String::new(),
            };
            let line = format!(
                "{:<subjects$} {:<whats$} {who:<46} {:>10} {:<8} {:>8} {:>8} {differ:>18}",
                row.subject,
                row.what,
                number(row.value),
                row.unit,
                ratio(row.default_ratio),
                ratio(row.native_ratio),
            );
            let _ = writeln!(text, "{}  {}", line, row.simd);
        }
        if !self.marks.is_empty() {
            let _ = writeln!(text, "\nmarks");
        }
        for mark in &self.marks {
            let _ = writeln!(
                text,
                "{:<6} {:>9}, {} {:<8} {}",
                if mark.met { "met" } else { "MISSED" },
                number(mark.measured),
                if mark.at_least { "at least" } else { "at most" },
                number(mark.mark),
                mark.what
            );
        }
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
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let optional = |number: Option<String>| number.unwrap_or_default();
        write_atomically(path, |file| {
            file.write_all(
                b"part,subject,what,peer,mode,version,simd,value,unit,default_ratio,native_ratio,differ,rays\n",
            )?;
            for row in &self.rows {
                let texts = [
                    row.part,
                    &row.subject,
                    &row.what,
                    &row.peer,
                    &row.mode,
                    &row.version,
                    &row.simd,
                ];
                let numbers = [
                    row.value.to_string(),
                    quoted(row.unit),
                    optional(row.default_ratio.map(|n| n.to_string())),
                    optional(row.native_ratio.map(|n| n.to_string())),
                    optional(row.differ.map(|n| n.to_string())),
                    optional(row.rays.map(|n| n.to_string())),
                ];
                let cells: Vec<_> = texts.into_iter().map(quoted).chain(numbers).collect();
                writeln!(file, "{}", cells.join(","))?;
            }
            Ok(())
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
