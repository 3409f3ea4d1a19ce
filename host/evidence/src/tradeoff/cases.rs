//! What single precision loses in the hard cases of [`crate::selftest`].

use super::{Bench, Cause, Section};
use crate::selftest::{self, Row};
use std::sync::atomic::{AtomicUsize, Ordering};

#[expect(clippy::unnecessary_wraps, reason = "a section as the others are")]
pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let effort = bench.effort;
    let total = selftest::selected("").count();
    let done = AtomicUsize::new(0);
    let rows = selftest::run(effort, "", || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (bench.progress)(done as f64 / total as f64);
    });
    let better = |one: &&Row| one.error < one.naive_error;
    let failed: Vec<&str> = rows
        .iter()
        .filter(|one| !one.passed)
        .map(|one| one.case.name)
        .collect();
    let choice = if failed.is_empty() {
        format!(
            "Single precision is enough: all {total} cases keep to their bounds, and {} of them \
             are nearer to their references than the textbook's way, which keeps to the bounds of \
             {}, the controls.",
            rows.iter().filter(better).count(),
            rows.iter().filter(|one| one.control).count(),
        )
    } else {
        format!(
            "Of {total} cases {} do not keep to their bounds: {}.",
            failed.len(),
            failed.join(", ")
        )
    };
    let inputs = effort.pick(
        "a twenty-fifth of the inputs of shisen-evidence selftest, where a case has many of them, \
         and frames of fewer pixels",
        "all inputs of shisen-evidence selftest",
    );
    let about = format!(
        "Where a textbook's formula goes wrong in single precision (naive), and what this tracer \
         makes of it (ours), each against a reference in double precision or better, or a closed \
         form: the largest error of {inputs}; and the bound that fails the case."
    );
    let mut section = Section::new("cases", "Hard cases", about, Vec::new());
    section.choice = choice;
    section.hard_cases = rows;
    Ok(section)
}
