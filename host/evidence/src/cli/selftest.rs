//! `shisen-evidence selftest`: the hard cases, and how the naive way does at them.

use super::bench;
use crate::selftest::{self, Effort, FRAMES, Row};
use crate::table::Table;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::progress::Progress;
use shisen::cli::output::say;
use shisen::files::Fault;
use shisen_core::Simd;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tries the tracer on hard cases, against exact references
///
/// Each case draws inputs on which a textbook's formula goes wrong in single precision:
/// origins ten million radii away, rays through the corners of closed meshes, light at the
/// critical angle. It gives the largest error of the built-in way and that of the naive way on
/// the same inputs (for frames, on the reference frame). A case whose naive way is within the
/// bound as well is a control. The exit code is 1 where an error is above its bound.
///
/// Frames are compared by AVX2 and by portable code, which is the compiler's SSE2 on x86-64.
/// A processor without AVX2 has portable code alone, and a note says so.
#[derive(Debug, Args)]
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

/// What the hard cases gave.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// Whether each case had a twenty-fifth of its inputs.
    quick: bool,
    /// The processor's fastest instruction set that traces: avx2 or portable.
    simd: &'static str,
    /// Instruction sets on which frames were compared; empty without cases of frames.
    paths_compared: Vec<&'static str>,
    /// Number of cases within their bounds.
    passed: usize,
    /// Number of cases beyond their bounds.
    failed: usize,
    /// Cases.
    cases: Vec<Row>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let part = arguments.part.as_deref().unwrap_or_default();
    let total = selftest::selected(part).count();
    if total == 0 {
        let message =
            format!("no case has {part} in its name: `shisen-evidence selftest` runs all of them");
        return Err(Failure::usage(&message));
    }
    let effort = if arguments.quick {
        Effort::Quick
    } else {
        Effort::Full
    };
    let progress = Progress::new(arguments.quiet);
    let done = AtomicUsize::new(0);
    let cases = selftest::run(effort, part, || {
        progress.show(done.fetch_add(1, Ordering::Relaxed) + 1, total);
    });
    progress.finish();
    let failed = cases.iter().filter(|row| !row.passed).count();
    let simd = Simd::detect().name();
    let paths_compared = paths_compared(&cases, simd);
    if paths_compared == [PORTABLE] {
        say(NO_AVX2);
    }
    let text = described(&cases, failed);
    let report = Report {
        quick: arguments.quick,
        simd,
        paths_compared,
        passed: total - failed,
        failed,
        cases,
    };
    bench::print(arguments.json, &report, &text)?;
    if failed > 0 {
        return Err(Fault::new(
            format!("{failed} of {total} hard cases exceed their error bounds"),
            "this build computes other results than the one that was tested: build it again with \
             the compiler's default settings; if the cases still fail, report the table above",
        )
        .into());
    }
    Ok(())
}

const PORTABLE: &str = Simd::PORTABLE.name();

const NO_AVX2: &str = "note: no AVX2 here: frames are compared on portable code alone, by modes, \
                       trees and numbers of threads; a processor with AVX2 compares both";

/// Returns the instruction sets on which frames were compared, where `simd` is the fastest.
fn paths_compared(cases: &[Row], simd: &'static str) -> Vec<&'static str> {
    if cases.iter().all(|row| row.group != FRAMES) {
        Vec::new()
    } else if simd == PORTABLE {
        vec![PORTABLE]
    } else {
        vec![PORTABLE, simd]
    }
}

fn described(cases: &[Row], failed: usize) -> String {
    let verdict = |row: &Row| match (row.passed, row.control) {
        (false, _) => "FAILED".to_owned(),
        (true, true) => "control".to_owned(),
        (true, false) => String::new(),
    };
    let mut text = String::new();
    for cases in cases.chunk_by(|a, b| a.group == b.group) {
        let table = Table::new(cases)
            .text(cases[0].group, |row| format!("  {:<38}", row.case.name))
            .text("ours", |row| number(row.error))
            .text("bound", |row| number(row.case.bound))
            .text("naive", |row| number(row.naive_error))
            .text("", verdict);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{table:#}");
        for case in cases.iter().filter(|row| !row.passed).map(|row| row.case) {
            let _ = writeln!(
                text,
                "    {}: {}; error: {}",
                case.name, case.hard, case.error
            );
        }
    }
    let _ = write!(text, "{} passed, {failed} failed", cases.len() - failed);
    text
}

fn number(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else if !x.is_finite() {
        "wrong".to_owned()
    } else if (0.01..1.0e5).contains(&x) {
        let digits = if x < 10.0 { 2 } else { usize::from(x < 100.0) };
        format!("{x:.digits$}")
    } else {
        format!("{x:.1e}")
    }
}
