//! `shisen-evidence selftest`: the hard cases, and how the naive way does at them.

use crate::selftest::{self, Effort, FRAMES, Outcome, Row};
use clap::Args;
use serde::Serialize;
use shisen::cli::output::failure::{Failure, Fault};
use shisen::cli::output::progress::Progress;
use shisen::cli::output::{print, say};
use shisen_core::Simd;
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tries the tracer on hard cases, against exact references
///
/// Each case draws inputs on which a formula goes wrong in single precision
/// when it is written down as in the textbook: origins ten million radii away,
/// rays through the corners of closed meshes, light at the critical angle. It
/// gives the largest error of what is built in and that of the naive way on
/// the same inputs (of frames: of the frame that they are compared with); where that is within the bound as well, the case is a control.
/// The exit code is 1 where an error is above its bound.
///
/// Frames are compared by AVX2 and by portable code, which is the compiler's SSE2 on x86-64.
/// Where the processor has no AVX2 there is portable code alone, and a note says so.
///
/// With --json, one object: quick, simd (the fastest path of this processor: avx2 or
/// portable), `paths_compared` (of frames: portable, and avx2 where it is there; empty
/// where none of the cases is of frames), passed and failed (how many cases did), and
/// cases: group, name, hard (what is hard about it), unit (what the errors
/// are), reference, naive (the naive way), passed, error, bound, `naive_error` and
/// control (whether the naive way is within the bound, too) each. An error is null
/// where something was no number, or where a verdict was wrong beyond doubt.
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

/// What the cases measured.
#[derive(Debug, Serialize)]
struct Report {
    quick: bool,
    simd: &'static str,
    paths_compared: Vec<&'static str>,
    passed: usize,
    failed: usize,
    cases: Vec<Row>,
}

/// Runs the command.
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
    let outcomes = selftest::run(effort, part, || {
        progress.show(done.fetch_add(1, Ordering::Relaxed) + 1, total);
    });
    progress.finish();
    let failed = outcomes.iter().filter(|outcome| !outcome.passed()).count();
    let cases: Vec<Row> = outcomes.iter().map(Outcome::row).collect();
    let simd = Simd::detect().name();
    let paths_compared = paths_compared(&cases, simd);
    if paths_compared == [PORTABLE] {
        say(NO_AVX2);
    }
    let report = Report {
        quick: arguments.quick,
        simd,
        paths_compared,
        passed: total - failed,
        failed,
        cases,
    };
    print(&report, arguments.json)?;
    if failed > 0 {
        return Err(Fault::HardCases { failed, total }.into());
    }
    Ok(())
}

const PORTABLE: &str = Simd::PORTABLE.name();

/// Where a comparison of paths has one path.
const NO_AVX2: &str = "note: no AVX2 here: frames are compared on portable code alone, by modes, \
                       trees and numbers of threads; a processor with AVX2 compares both";

/// The instruction sets on which frames were compared, where `simd` is the fastest.
fn paths_compared(cases: &[Row], simd: &'static str) -> Vec<&'static str> {
    if cases.iter().all(|row| row.group != FRAMES) {
        Vec::new()
    } else if simd == PORTABLE {
        vec![PORTABLE]
    } else {
        vec![PORTABLE, simd]
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_avx2_one_path_is_compared_with_itself() {
        let of = |part| {
            let all = selftest::selected(part).map(|case| {
                let errors = selftest::Errors {
                    ours: 0.0,
                    naive: 0.0,
                };
                Outcome { case, errors }.row()
            });
            all.collect::<Vec<_>>()
        };
        assert_eq!(paths_compared(&of("frame-on"), PORTABLE), ["portable"]);
        assert_eq!(paths_compared(&of(""), "avx2"), ["portable", "avx2"]);
        assert!(paths_compared(&of("refraction"), "avx2").is_empty());
    }
}
