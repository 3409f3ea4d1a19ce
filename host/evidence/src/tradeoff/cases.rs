//! What single precision loses where formulas are hard: the cases of
//! [`crate::selftest`].

use super::{Bench, Section, Topic};
use crate::selftest::{self, Effort, Outcome};
use std::sync::atomic::{AtomicUsize, Ordering};

pub(super) fn section(bench: &Bench<'_>) -> Section {
    let effort = bench.effort;
    let total = selftest::selected("").count();
    let done = AtomicUsize::new(0);
    let outcomes = selftest::run(effort, "", || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (bench.progress)(done as f64 / total as f64);
    });
    let better = |one: &&Outcome| one.errors.ours < one.errors.naive;
    let failed: Vec<&str> = outcomes
        .iter()
        .filter(|one| !one.passed())
        .map(|one| one.case.name)
        .collect();
    let choice = if failed.is_empty() {
        format!(
            "Single precision is enough: all {total} cases keep to their bounds, and {} of them \
             are nearer to their references than the textbook's way, which keeps to the bounds of \
             {}, the controls.",
            outcomes.iter().filter(better).count(),
            outcomes.iter().filter(|one| one.is_control()).count(),
        )
    } else {
        format!(
            "Of {total} cases {} do not keep to their bounds: {}.",
            failed.len(),
            failed.join(", ")
        )
    };
    let about = about(effort);
    let mut section = Section::new(Topic::Cases, "Hard cases", about, Vec::new());
    section.choice = choice;
    section.hard_cases = outcomes.iter().map(Outcome::row).collect();
    section
}

/// What is measured, and how.
fn about(effort: Effort) -> String {
    let inputs = match effort {
        Effort::Quick => {
            "a twenty-fifth of the inputs of shisen-evidence selftest, where a case has many of them, and \
             frames of fewer pixels"
        }
        Effort::Full => "all inputs of shisen-evidence selftest",
    };
    format!(
        "Where a formula in single precision goes wrong when it is written down as in the \
         textbook (naive), and what this tracer makes of it (ours), each against a reference in \
         double precision or better, or a closed form: the largest error of {inputs}; and the \
         bound that fails the case."
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_run_says_that_it_has_fewer_inputs() {
        let [quick, full] = [Effort::Quick, Effort::Full].map(about);
        let quick_says = "error of a twenty-fifth of the inputs of shisen-evidence selftest, where";
        assert!(quick.contains(quick_says), "{quick}");
        assert!(
            full.contains("error of all inputs of shisen-evidence selftest; and"),
            "{full}"
        );
    }
}
