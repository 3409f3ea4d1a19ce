//! Numbers that break arithmetic, for tests: every function gives a typed error or a finite
//! result.

use crate::shape::Ray;
use core::fmt::Debug;
use glam::{Mat3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::format;
use std::vec::Vec;

/// Numbers that break arithmetic, each used with both signs.
const WORST: [f32; 10] = [
    f32::NAN,
    f32::INFINITY,
    0.0,
    1.0e-45,
    f32::MIN_POSITIVE,
    0.5,
    1.0,
    1.0e18,
    1.0e30,
    f32::MAX,
];

/// The numbers of one run of a test.
#[derive(Debug, Clone)]
pub(crate) struct Numbers {
    /// The number that replaces the usual one at each position, if any.
    instead: Vec<Option<f32>>,
    given: Vec<f32>,
}

impl Numbers {
    /// Returns the number of the next position; `usual` is one that the function is made for.
    pub(crate) fn next(&mut self, usual: f32) -> f32 {
        let position = self.given.len() % self.instead.len();
        let number = self.instead[position].unwrap_or(usual);
        self.given.push(number);
        number
    }

    pub(crate) fn vector(&mut self, usual: [f32; 3]) -> Vec3 {
        Vec3::from(usual.map(|number| self.next(number)))
    }

    pub(crate) fn matrix(&mut self, usual: Mat3) -> Mat3 {
        Mat3::from_cols_array(&usual.to_cols_array().map(|number| self.next(number)))
    }

    /// Returns whether every number so far is finite and at most this far from zero.
    pub(crate) fn within(&self, most: f32) -> bool {
        self.given.iter().all(|number| number.abs() <= most)
    }
}

/// Runs a test with usual numbers, with each of the worst alone, and with mixtures.
pub(crate) fn with_hostile_numbers(test: impl Fn(&mut Numbers)) {
    let run = |instead| {
        let given = Vec::new();
        test(&mut Numbers { instead, given });
    };
    run(Vec::from([None]));
    for number in WORST.into_iter().flat_map(|number| [number, -number]) {
        run(Vec::from([Some(number)]));
    }
    let number = prop_oneof![
        6 => Just(None),
        2 => (select(&WORST[..]), 0..2).prop_map(|(n, sign)| Some(if sign == 0 { n } else { -n })),
        1 => proptest::num::f32::ANY.prop_map(Some),
    ];
    let config = Config {
        cases: if cfg!(miri) { 4 } else { 512 },
        failure_persistence: None,
        ..Config::default()
    };
    let random = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let tested = TestRunner::new_with_rng(config, random).run(&vec(number, 29), |instead| {
        run(instead);
        Ok(())
    });
    if let Err(error) = tested {
        panic!("{error}");
    }
}

/// Checks that every number of a result is finite, by its `Debug` text.
#[track_caller]
pub(crate) fn finite(result: &(impl Debug + ?Sized)) {
    let text = format!("{result:?}");
    let mut words = text.split(|c: char| !c.is_ascii_alphanumeric());
    assert!(!words.any(|word| word == "NaN" || word == "inf"), "{text}");
}

/// Checks that a result is finite, or an error with a text.
#[track_caller]
pub(crate) fn finite_or_error<T: Debug, E: core::error::Error>(result: Result<T, E>) -> Option<T> {
    match result {
        Ok(result) => {
            finite(&result);
            Some(result)
        }
        Err(error) => {
            assert!(!format!("{error}").is_empty());
            None
        }
    }
}

/// Returns a ray, if the numbers make one.
pub(crate) fn a_ray(n: &mut Numbers) -> Option<Ray> {
    Ray::new(n.vector([0.1, 0.2, 0.3]), n.vector([0.05, -0.02, -1.0]))
}

#[track_caller]
pub(crate) fn is_unit(v: &Vec3) {
    assert!((v.length() - 1.0).abs() <= 2.0e-6, "{v}");
}
