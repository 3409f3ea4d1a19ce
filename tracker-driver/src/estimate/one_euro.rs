//! The One-Euro filter on directions (Casiez, Roussel and Vogel, "1 € filter:
//! a simple speed-based low-pass filter for noisy input in interactive
//! systems", 2012): a low pass whose corner rises with the speed.

use core::f32::consts::TAU;
use glam::Vec3;
use shisen_core::numeric::{max, min, normalize, sqrt};

/// How the filter behaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OneEuroConfig {
    /// The corner at rest, Hz; 0.01 to 1000. Lower is steadier and later.
    pub least_cutoff: f32,
    /// The rise of the corner with speed, Hz per radian per second; 0 to 10,000.
    pub beta: f32,
    /// The corner of the speed's own low pass, Hz; 0.01 to 1000.
    pub speed_cutoff: f32,
}

impl Default for OneEuroConfig {
    /// For gaze in a room: 5 Hz at rest, 60 Hz at 30°/s. The delay at rest,
    /// 30 ms, is not felt there, since nothing moves.
    fn default() -> Self {
        Self {
            least_cutoff: 5.0,
            beta: 100.0,
            speed_cutoff: 5.0,
        }
    }
}

/// A filter's state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OneEuro {
    config: OneEuroConfig,
    state: Option<State>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    measured: Vec3,
    filtered: Vec3,
    /// Chord lengths per second, which for small steps are radians.
    velocity: Vec3,
    /// Seconds.
    delay: f32,
}

impl OneEuro {
    /// The least and the longest step, seconds.
    const STEPS: (f32, f32) = (1.0e-9, 1.0e6);

    /// Returns a filter that has seen nothing. Numbers outside the ranges at
    /// [`OneEuroConfig`] are moved to the nearest that is in it, NaN to the least.
    pub(super) const fn new(config: OneEuroConfig) -> Self {
        Self {
            config: OneEuroConfig {
                least_cutoff: within(config.least_cutoff, 0.01, 1000.0),
                beta: within(config.beta, 0.0, 10_000.0),
                speed_cutoff: within(config.speed_cutoff, 0.01, 1000.0),
            },
            state: None,
        }
    }

    /// Returns the next unit vector, `step` seconds after the one before; the first
    /// passes as it is. What is not finite or far from unit length, and a `step`
    /// that is not above 10⁻⁹ s, changes nothing; a step is 10⁶ s at most.
    pub(super) fn filter(&mut self, measured: Vec3, step: f32) -> Vec3 {
        // The bound is on the square of the length.
        if !(measured.dot(measured) <= 4.0) {
            return self.state.map_or(measured, |state| state.filtered);
        }
        let Some(state) = &mut self.state else {
            self.state = Some(State {
                measured,
                filtered: measured,
                velocity: Vec3::ZERO,
                delay: 0.0,
            });
            return measured;
        };
        let (least, longest) = Self::STEPS;
        if !(step > least) {
            return state.filtered;
        }
        let step = step.min(longest);
        let velocity = (measured - state.measured) / step;
        let share = share(self.config.speed_cutoff, step);
        state.velocity += (velocity - state.velocity) * share;
        let speed = sqrt(state.velocity.dot(state.velocity));
        let share = self::share(self.config.least_cutoff + self.config.beta * speed, step);
        let sum = state.filtered + (measured - state.filtered) * share;
        state.measured = measured;
        state.filtered = normalize(sum).unwrap_or(measured);
        // How late a steady movement comes out: the geometric series of the
        // shares.
        state.delay = step * (1.0 - share) / share;
        state.filtered
    }

    /// Returns how late a steady movement comes out at present, seconds.
    pub(super) fn group_delay(&self) -> f32 {
        self.state.map_or(0.0, |state| state.delay)
    }

    /// Starts again at the next vector, as after a saccade or a gap.
    pub(super) fn reset(&mut self) {
        self.state = None;
    }
}

/// Returns the nearest number of a range; the least for NaN.
const fn within(number: f32, least: f32, most: f32) -> f32 {
    min(max(number, least), most)
}

/// Returns the weight of a new value at a corner frequency: 1/(1 + τ/step), τ = 1/(2π·cutoff).
fn share(cutoff: f32, step: f32) -> f32 {
    let turn = TAU * cutoff * step;
    turn / (1.0 + turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// Returns the paper's algorithm as it stands, in f64.
    fn reference(config: OneEuroConfig, inputs: &[(Vec3, f32)]) -> Vec<[f64; 3]> {
        let alpha = |cutoff: f64, step: f64| {
            let tau = 1.0 / (std::f64::consts::TAU * cutoff);
            1.0 / (1.0 + tau / step)
        };
        let mut last: Option<([f64; 3], [f64; 3], [f64; 3])> = None;
        inputs
            .iter()
            .map(|(x, step)| {
                let (x, step) = (x.to_array().map(f64::from), f64::from(*step));
                let next = last.map_or((x, x, [0.0; 3]), |(before, y, dx)| {
                    let a = alpha(config.speed_cutoff.into(), step);
                    let dx: [f64; 3] =
                        std::array::from_fn(|i| a * (x[i] - before[i]) / step + (1.0 - a) * dx[i]);
                    let speed = dx.iter().map(|d| d * d).sum::<f64>().sqrt();
                    let cutoff = f64::from(config.least_cutoff) + f64::from(config.beta) * speed;
                    let a = alpha(cutoff, step);
                    let y: [f64; 3] = std::array::from_fn(|i| a * x[i] + (1.0 - a) * y[i]);
                    let length = y.iter().map(|c| c * c).sum::<f64>().sqrt();
                    (x, y.map(|c| c / length), dx)
                });
                last = Some(next);
                next.1
            })
            .collect()
    }

    #[test]
    fn it_is_the_papers_filter() {
        let count = if cfg!(miri) { 20 } else { 5_000 };
        let mut state = 1u32;
        let inputs: Vec<_> = (0..count)
            .map(|i| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = (state >> 8) as f32 / 16_777_216.0 - 0.5;
                // A saccade back and forth each half second.
                let x = if i / 250 % 2 == 0 { 0.0 } else { 0.2 } + 0.002 * noise;
                let step = 0.002 + 0.0005 * noise;
                (normalize(Vec3::new(x, 0.1 * x, -1.0)).unwrap(), step)
            })
            .collect();
        for config in [
            OneEuroConfig::default(),
            OneEuroConfig {
                least_cutoff: 1.0,
                beta: 0.0,
                speed_cutoff: 1.0,
            },
            OneEuroConfig {
                least_cutoff: 20.0,
                beta: 3_000.0,
                speed_cutoff: 50.0,
            },
        ] {
            let mut filter = OneEuro::new(config);
            let exact = reference(config, &inputs);
            for ((input, step), exact) in inputs.iter().zip(exact) {
                let found = filter.filter(*input, *step).to_array();
                for (found, exact) in found.iter().zip(exact) {
                    assert!((f64::from(*found) - exact).abs() < 1e-6, "{config:?}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn whatever_comes_in_what_comes_out_is_finite(
            beta in prop::num::f32::ANY,
            cutoff in prop::num::f32::ANY,
            inputs in prop::collection::vec((prop::num::f32::ANY, prop::num::f32::ANY), 1..9),
        ) {
            let mut filter = OneEuro::new(OneEuroConfig {
                least_cutoff: cutoff,
                beta,
                speed_cutoff: cutoff,
            });
            for (x, step) in inputs {
                let measured = Vec3::new(x, 0.2, -0.97);
                let filtered = filter.filter(measured, step);
                prop_assert!(filtered.is_finite() || !measured.is_finite(), "{filtered}");
                prop_assert!(filter.group_delay().is_finite());
            }
        }
    }

    #[test]
    fn a_reset_and_a_step_of_nothing() {
        let mut filter = OneEuro::new(OneEuroConfig::default());
        assert_eq!(filter.filter(Vec3::X, 0.01), Vec3::X);
        assert_eq!(filter.filter(Vec3::Y, 0.0), Vec3::X);
        assert_eq!(filter.filter(Vec3::Y, f32::NAN), Vec3::X);
        filter.reset();
        assert_eq!(filter.filter(Vec3::Y, 0.01), Vec3::Y);
    }
}
