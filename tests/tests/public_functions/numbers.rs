//! Hostile numbers for a case: one plan after another says which number stands
//! in which of its positions.

use glam::{DVec3, Mat3, Quat, Vec2, Vec3};
use shisen_tests::rays::Random;
use std::any::Any;
use std::fmt::Debug;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What breaks arithmetic, in either precision: what `f32` does not hold is its
/// nearest there, zero or infinite.
const HOSTILE: [f64; 29] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    5.0e-324,
    -5.0e-324,
    1.0e-310,
    -1.0e-310,
    f64::MIN_POSITIVE,
    -f64::MIN_POSITIVE,
    1.0e-45,
    -1.0e-45,
    1.0e-40,
    -1.0e-40,
    f32::MIN_POSITIVE as f64,
    -f32::MIN_POSITIVE as f64,
    1.0,
    -1.0,
    1.0e18,
    -1.0e18,
    1.0e30,
    -1.0e30,
    f32::MAX as f64,
    f32::MIN as f64,
    1.0e300,
    -1.0e300,
    f64::MAX,
    f64::MIN,
];

/// A use of one public function.
pub(super) type Case = fn(&mut Numbers);

/// Which number stands in a position.
#[derive(Debug, Clone)]
enum Plan {
    Sane,
    All(f64),
    One(usize, f64),
    Mixed(Random),
}

/// The numbers of one run of a case.
pub(super) struct Numbers {
    plan: Plan,
    given: Vec<f64>,
    sane: bool,
}

impl Numbers {
    /// The next position's number; `sane` is one that the function is made for.
    pub(super) fn next(&mut self, sane: f32) -> f32 {
        let number = self.choose(f64::from(sane), &mut |random| {
            f64::from(f32::from_bits(random.below(1 << 32) as u32))
        });
        number as f32
    }

    /// Likewise in the host's precision.
    pub(super) fn wide(&mut self, sane: f64) -> f64 {
        self.choose(sane, &mut |random| {
            let [high, low] = [0; 2].map(|_: u64| random.below(1 << 32) as u64);
            f64::from_bits(high << 32 | low)
        })
    }

    fn choose(&mut self, sane: f64, any: &mut dyn FnMut(&mut Random) -> f64) -> f64 {
        let number = match &mut self.plan {
            Plan::All(number) => *number,
            Plan::One(position, number) if *position == self.given.len() => *number,
            Plan::Sane | Plan::One(..) => sane,
            Plan::Mixed(random) => match random.below(8) {
                0..5 => sane,
                5..7 => HOSTILE[random.below(HOSTILE.len())],
                _ => any(random),
            },
        };
        self.sane &= number.to_bits() == sane.to_bits();
        self.given.push(number);
        number
    }

    pub(super) fn vec2(&mut self, sane: [f32; 2]) -> Vec2 {
        Vec2::from(sane.map(|number| self.next(number)))
    }

    pub(super) fn vec3(&mut self, sane: [f32; 3]) -> Vec3 {
        Vec3::from(sane.map(|number| self.next(number)))
    }

    pub(super) fn dvec3(&mut self, sane: [f64; 3]) -> DVec3 {
        DVec3::from(sane.map(|number| self.wide(number)))
    }

    pub(super) fn quat(&mut self) -> Quat {
        Quat::from_array([0.0, 0.0, 0.0, 1.0].map(|number| self.next(number)))
    }

    pub(super) fn mat3(&mut self, sane: Mat3) -> Mat3 {
        Mat3::from_cols_array(&sane.to_cols_array().map(|number| self.next(number)))
    }

    /// Whether every number so far is finite, and no farther from zero.
    pub(super) fn within(&self, most: f32) -> bool {
        self.given
            .iter()
            .all(|number| number.abs() <= f64::from(most))
    }

    /// Whether every number so far is the one that the function is made for.
    pub(super) fn are_sane(&self) -> bool {
        self.sane
    }
}

/// Every number of it is finite, as its fields are printed.
#[track_caller]
pub(super) fn finite(result: &(impl Debug + ?Sized)) {
    let text = format!("{result:?}");
    let is_word = |c: char| !c.is_ascii_alphanumeric();
    let broken = text
        .split(is_word)
        .any(|word| word == "NaN" || word == "inf");
    assert!(!broken, "not finite: {text}");
}

/// A finite result, or an error that says something.
#[track_caller]
pub(super) fn finite_or_error<T: Debug, E: std::error::Error>(result: Result<T, E>) -> Option<T> {
    match result {
        Ok(result) => {
            finite(&result);
            Some(result)
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            None
        }
    }
}

/// Runs a case with sane numbers, with each hostile one in all positions and, if it is
/// to be, in each alone, and with mixtures. What goes wrong first, if anything does.
pub(super) fn torment(case: Case, alone: bool, mixtures: usize) -> Result<(), String> {
    let positions = run(case, &Plan::Sane)?;
    for number in HOSTILE {
        run(case, &Plan::All(number))?;
        for position in (0..positions).filter(|_| alone) {
            run(case, &Plan::One(position, number))?;
        }
    }
    for seed in 0..mixtures {
        run(case, &Plan::Mixed(Random::new(seed as u64)))?;
    }
    Ok(())
}

/// How many positions there were.
fn run(case: Case, plan: &Plan) -> Result<usize, String> {
    let mut numbers = Numbers {
        plan: plan.clone(),
        given: Vec::new(),
        sane: true,
    };
    let outcome = catch_unwind(AssertUnwindSafe(|| case(&mut numbers)));
    outcome.map(|()| numbers.given.len()).map_err(|panic| {
        let message = message(&*panic);
        format!("{message}\n    of {:?}, by {plan:?}", numbers.given)
    })
}

/// What a panic says.
pub(super) fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("a panic")
}
