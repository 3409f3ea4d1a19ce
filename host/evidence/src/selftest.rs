//! Hard cases: where a textbook's formula goes wrong in single precision.
//!
//! Every case names its reference, measures the error of the built-in way and that of the
//! naive way on the same inputs (for [`FRAMES`], of which no textbook has a way, on
//! the reference frame), and has a bound that fails it.
//! Inputs are drawn from stated seeds, so that a case is the same everywhere.

/// A table of cases: error, reference and naive way of those that follow; of each its name,
/// bound, measurement and what is hard about it.
macro_rules! cases {
    ($([$error:expr, $reference:expr, $naive:expr]:
        $($name:literal, $bound:expr, $measure:expr, $hard:literal;)+)+) => {
        &[$($($crate::selftest::Case {
            name: $name,
            hard: $hard,
            error: $error,
            reference: $reference,
            naive: $naive,
            bound: $bound,
            measure: $measure,
        },)+)+]
    };
}

mod boxes;
mod capture;
mod distant;
mod exact;
mod frames;
mod gaze;
mod input;
mod meshes;
mod numbers;
mod refraction;
mod screens;
mod secondary;
mod spheroids;
mod time;
mod triangles;

pub(crate) use input::Inputs;

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;

/// How many inputs each case is given, and how much [`tradeoff`](crate::tradeoff) measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Enough to see a formula break: seconds, without optimisation too. Small pictures,
    /// few settings, three times each or more.
    Quick,
    /// All of them, such as ten million rays at closed meshes. Pictures and settings as
    /// they are used, five times each or more.
    Full,
}

impl Effort {
    /// Returns the first or the second value.
    pub(crate) fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }

    /// Returns the count for this effort, given that of the full run.
    fn of(self, full: usize) -> usize {
        match self {
            Self::Quick => full.div_ceil(25),
            Self::Full => full,
        }
    }
}

/// A hard case.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Case {
    /// The name, unique among all cases.
    pub name: &'static str,
    /// The reason why the inputs are hard.
    pub hard: &'static str,
    /// The kind of error, with its unit.
    #[serde(rename = "unit")]
    pub error: &'static str,
    /// The reference of the error.
    pub reference: &'static str,
    /// The naive way.
    pub naive: &'static str,
    /// The largest error that passes.
    pub bound: f64,
    #[serde(skip)]
    measure: fn(Effort) -> Option<Errors>,
}

/// The largest errors of a case, or its numbers of wrong verdicts; infinite where a result was
/// not a number, or where a verdict (hit or miss, one side or the other) was wrong beyond doubt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// The error of the built-in way.
    pub ours: f64,
    /// The error of the naive way.
    pub naive: f64,
    verdicts: usize,
}

impl Errors {
    const NONE: Self = Self::new(0.0, 0.0);

    pub(crate) const fn new(ours: f64, naive: f64) -> Self {
        Self {
            ours,
            naive,
            verdicts: 0,
        }
    }

    fn ours(&mut self, error: f64) {
        self.ours = worse(self.ours, error);
    }

    fn naive(&mut self, error: f64) {
        self.naive = worse(self.naive, error);
    }

    fn wrong(&mut self, ours: bool, naive: bool) {
        self.verdicts += 1;
        self.ours += f64::from(u8::from(ours));
        self.naive += f64::from(u8::from(naive));
    }

    /// Counts a ray that met nothing where neither way may miss.
    fn lost(&mut self) -> Option<()> {
        self.wrong(true, true);
        None
    }

    /// `None` with fewer than `least` verdicts, as none of next to none is wrong.
    fn of_at_least(self, least: f64) -> Option<Self> {
        (self.verdicts as f64 >= least).then_some(self)
    }
}

/// What a case measured, for people and programs.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Row {
    /// The name of the case's group.
    pub group: &'static str,
    /// The case.
    #[serde(flatten)]
    pub case: &'static Case,
    /// Whether the error is within its bound.
    pub passed: bool,
    /// The error of the built-in way; null if a result was not a number, or a verdict was wrong
    /// beyond doubt.
    #[schemars(with = "Option<f64>")]
    pub error: f64,
    /// The error of the naive way; null likewise.
    #[schemars(with = "Option<f64>")]
    pub naive_error: f64,
    /// Whether the naive way is within the bound, too. Such a control shows that nothing is
    /// lost on easy inputs, or the price of a guarantee elsewhere.
    pub control: bool,
}

impl Row {
    pub(crate) fn new(group: &'static str, case: &'static Case, errors: Errors) -> Self {
        Self {
            group,
            case,
            passed: errors.ours <= case.bound,
            error: errors.ours,
            naive_error: errors.naive,
            control: errors.naive <= case.bound,
        }
    }
}

/// The group of whole frames, on every path through the tracer.
pub const FRAMES: &str = "frames";

/// All groups of cases and their names, in the order of a ray's life.
pub const GROUPS: [(&str, &[Case]); 13] = [
    ("spheroids", spheroids::CASES),
    ("triangles", triangles::CASES),
    ("meshes", meshes::CASES),
    ("distant meshes", distant::CASES),
    ("boxes", boxes::CASES),
    ("secondary rays", secondary::CASES),
    ("visual field", gaze::CASES),
    ("capture", capture::CASES),
    ("refraction", refraction::CASES),
    ("screens", screens::CASES),
    ("time and budget", time::CASES),
    (FRAMES, frames::CASES),
    ("numbers", numbers::CASES),
];

/// Runs the cases whose name has `part` in it, on all threads, and returns their rows in
/// order; calls `done` at the end of each.
pub fn run(effort: Effort, part: &str, done: impl Fn() + Sync) -> Vec<Row> {
    let cases: Vec<_> = selected(part).collect();
    let run = |&(group, case): &(&'static str, &'static Case)| {
        let errors = (case.measure)(effort).unwrap_or(BROKEN);
        done();
        Row::new(group, case, errors)
    };
    cases.par_iter().map(run).collect()
}

/// Returns the cases whose name has `part` in it, each with its group.
pub fn selected(part: &str) -> impl Iterator<Item = (&'static str, &'static Case)> {
    let all = GROUPS.into_iter();
    let all = all.flat_map(|(group, cases)| cases.iter().map(move |case| (group, case)));
    all.filter(move |(_, case)| case.name.contains(part))
}

/// Draws inputs from a seed, `count` times, and gathers the largest errors. The result of
/// `check` is ignored: `None` skips an input.
fn largest<R>(
    seed: u64,
    count: usize,
    check: impl FnMut(&mut Inputs, &mut Errors) -> R,
) -> Option<Errors> {
    wrong(seed, count, 0.0, check)
}

/// Draws inputs likewise, and counts wrong verdicts. The case is broken with fewer than `least`
/// verdicts for each input.
fn wrong<R>(
    seed: u64,
    count: usize,
    least: f64,
    mut check: impl FnMut(&mut Inputs, &mut Errors) -> R,
) -> Option<Errors> {
    let (mut inputs, mut errors) = (Inputs::new(seed), Errors::NONE);
    for _ in 0..count {
        let _ = check(&mut inputs, &mut errors);
    }
    errors.of_at_least(least * count as f64)
}

pub(crate) fn worse(so_far: f64, error: f64) -> f64 {
    if error.is_nan() {
        f64::INFINITY
    } else {
        so_far.max(error.abs())
    }
}

const BROKEN: Errors = Errors::new(f64::INFINITY, f64::INFINITY);

/// 2⁻²⁴: half the distance from 1 to the next f32, what one rounding costs.
const UNIT: f64 = 1.0 / 16_777_216.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_the_largest_and_need_inputs() {
        let mut worst = Errors::NONE;
        for error in [-2.0, 1.0] {
            worst.ours(error);
        }
        for error in [f64::NAN, 3.0] {
            worst.naive(error);
        }
        assert_eq!(worst, Errors::new(2.0, f64::INFINITY));
        let of = |least| wrong(1, 2, least, |_, verdicts| verdicts.wrong(false, true));
        assert!(of(1.0).is_some_and(|found| (found.ours, found.naive) == (0.0, 2.0)));
        assert_eq!(of(1.5), None);
    }

    #[test]
    fn a_case_fails_beyond_its_bound_and_without_a_number() {
        let case = &spheroids::CASES[0];
        let passes = |ours| Row::new("", case, Errors::new(ours, 0.0)).passed;
        assert!(passes(case.bound) && !passes(case.bound * 1.01));
        assert!(!passes(f64::INFINITY) && !passes(f64::NAN));
    }
}
