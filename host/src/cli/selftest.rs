//! `shisen selftest`: the hard cases, and how the naive way does at them.

use super::failure::{Failure, Fault};
use super::print;
use super::progress::Progress;
use clap::Args;
use serde::Serialize;
use shisen::selftest::{self, Effort, Outcome, Row};
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tries the tracer on hard cases, against exact references
///
/// Each case draws inputs on which a formula goes wrong in single precision
/// when it is written down as in the textbook: origins ten million radii away,
/// rays through the corners of closed meshes, light at the critical angle. It
/// gives the largest error of what is built in and that of the naive way on
/// the same inputs; where that is within the bound as well, the case is a control.
/// The exit code is 1 where an error is above its bound.
///
/// With --json, one object: quick, passed and failed (how many cases did), and
/// cases: group, name, hard (what is hard about it), unit (what the errors
/// are), reference, naive (the naive way), passed, error, bound, `naive_error` and
/// control (whether the naive way is within the bound, too) each. An error is null
/// where something was no number, or where a verdict was wrong beyond doubt.
///
/// Examples:
///   shisen selftest
///   shisen selftest refraction --json
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Arguments {
    /// Only cases whose name has this in it
    #[arg(value_name = "PART")]
    part: Option<String>,
    /// A twenty-fifth of the inputs
    #[arg(long)]
    quick: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What the cases measured.
#[derive(Debug, Serialize)]
struct Report {
    quick: bool,
    passed: usize,
    failed: usize,
    cases: Vec<Row>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let part = arguments.part.as_deref().unwrap_or_default();
    let total = selftest::selected(part).count();
    if total == 0 {
        let message = format!("no case has {part} in its name: `shisen selftest` runs all of them");
        return Err(Failure::usage(&message));
    }
    let effort = if arguments.quick {
        Effort::Quick
    } else {
        Effort::Full
    };
    let progress = Progress::new(arguments.quiet);
    let done = AtomicUsize::new(0);
    let outcomes = selftest::run(effort, part, || {
        progress.show(done.fetch_add(1, Ordering::Relaxed) + 1, total);
    });
    progress.finish();
    let failed = outcomes.iter().filter(|outcome| !outcome.passed()).count();
    let report = Report {
        quick: arguments.quick,
        passed: total - failed,
        failed,
        cases: outcomes.iter().map(Outcome::row).collect(),
    };
    print(&report, arguments.json)?;
    if failed > 0 {
        return Err(Fault::HardCases { failed, total }.into());
    }
    Ok(())
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut group = "";
        for row in &self.cases {
            if row.group != group {
                group = row.group;
                writeln!(f, "{group:<40}     ours    bound    naive")?;
            }
            let verdict = match (row.passed, row.control) {
                (false, _) => "  FAILED",
                (true, true) => "  control",
                (true, false) => "",
            };
            writeln!(
                f,
                "  {:<38} {} {} {}{verdict}",
                row.name,
                Number(row.error),
                Number(row.bound),
                Number(row.naive_error),
            )?;
            if !row.passed {
                writeln!(f, "    {}; error: {}", row.hard, row.unit)?;
            }
        }
        write!(f, "{} passed, {} failed", self.passed, self.failed)
    }
}

/// To three digits, eight wide.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(x) = *self;
        if x == 0.0 {
            f.pad(&format!("{:>8}", 0))
        } else if !x.is_finite() {
            f.pad("   wrong")
        } else if (0.01..1.0e5).contains(&x) {
            let digits = if x < 10.0 { 2 } else { usize::from(x < 100.0) };
            f.pad(&format!("{x:>8.digits$}"))
        } else {
            f.pad(&format!("{x:>8.1e}"))
        }
    }
}
