//! The times of a `SPEC`: how late a tracker is, and after how long its data are stale or
//! stuck.

use super::settings::Options;
use crate::files::Fault;
use shisen_tracker::estimate::{EstimatorConfig, FallbackConfig};
use shisen_tracker::time::Micros;

/// Times of an [`EstimatorConfig`], and the least delay of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Times {
    /// By key; `None` where it was not given.
    given: [Option<Micros>; KEYS.len()],
    /// The least delay of samples.
    pub(super) delay: Option<Micros>,
}

/// The options of every tracker that are times, in seconds (`S`).
pub(super) const TIMES: &str = "stuck_after=S|never, head_stuck_after=S|never, hold_after=S, \
                                widen_after=S, head_after=S, full_after=S, head_hold_after=S, \
                                head_widen_after=S, head_full_after=S, longest_blink=S, delay=S";

/// The field that a key sets.
#[derive(Clone, Copy)]
enum Field {
    Fallback(fn(&mut FallbackConfig) -> &mut Micros),
    /// One that can also be `never`.
    Stuck(fn(&mut EstimatorConfig) -> &mut Option<Micros>),
}

use Field::{Fallback, Stuck};

const KEYS: [(&str, Field); 10] = [
    ("stuck_after", Stuck(|c| &mut c.stuck_after)),
    ("head_stuck_after", Stuck(|c| &mut c.head_stuck_after)),
    ("hold_after", Fallback(|c| &mut c.hold_after)),
    ("widen_after", Fallback(|c| &mut c.widen_after)),
    ("head_after", Fallback(|c| &mut c.head_after)),
    ("full_after", Fallback(|c| &mut c.full_after)),
    ("head_hold_after", Fallback(|c| &mut c.head_hold_after)),
    ("head_widen_after", Fallback(|c| &mut c.head_widen_after)),
    ("head_full_after", Fallback(|c| &mut c.head_full_after)),
    ("longest_blink", Fallback(|c| &mut c.longest_blink)),
];

const NEVER: Micros = Micros(u64::MAX);

/// Reads seconds from 0 to `most`.
fn seconds(value: &str, most: f64) -> Option<Micros> {
    let seconds: f64 = value.parse().ok()?;
    // NaN is in no range.
    let is_time = (0.0..=most).contains(&seconds);
    is_time.then(|| Micros((seconds * 1.0e6).round() as u64))
}

impl Times {
    pub(super) fn take(options: &mut Options<'_>) -> Result<Self, Fault> {
        let mut times = Self::default();
        for ((key, field), time) in KEYS.into_iter().zip(&mut times.given) {
            let (can_never, allowed) = match field {
                Stuck(_) => (true, "seconds from 0.05 to 60, such as 0.25, or never"),
                Fallback(_) => (false, "seconds from 0 to 60, such as 0.25"),
            };
            options.set(time, key, allowed, |value| {
                let never = (can_never && value == "never").then_some(NEVER);
                never.or_else(|| seconds(value, 60.0))
            })?;
        }
        let allowed = "seconds from 0 to 1, such as 0.008";
        options.set(&mut times.delay, "delay", allowed, |value| {
            seconds(value, 1.0)
        })?;
        let mut config = EstimatorConfig::default();
        times.set(&mut config);
        config.check().map_err(|reason| {
            Fault::new(
                reason.to_string(),
                format!("the times are seconds: {TIMES}"),
            )
        })?;
        Ok(times)
    }

    /// Returns the least delay of samples, if it was given.
    pub const fn delay(&self) -> Option<Micros> {
        self.delay
    }

    /// Puts the times into a configuration.
    pub fn set(&self, config: &mut EstimatorConfig) {
        for ((_, field), time) in KEYS.into_iter().zip(self.given) {
            match (field, time) {
                (Fallback(field), Some(time)) => *field(&mut config.fallback) = time,
                (Stuck(field), Some(time)) => {
                    *field(config) = (time != NEVER).then_some(time);
                }
                (_, None) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::Spec;

    #[test]
    fn each_key_sets_its_field_for_every_kind_of_tracker() {
        let mut expected = EstimatorConfig {
            stuck_after: Some(Micros(1_500_000)),
            head_stuck_after: None,
            ..EstimatorConfig::default()
        };
        expected.fallback = FallbackConfig {
            hold_after: Micros(100_000),
            widen_after: Micros(250_000),
            head_after: Micros(1_000_000),
            full_after: Micros(4_000_000),
            head_hold_after: Micros(10_000),
            head_widen_after: Micros(20_000),
            head_full_after: Micros(750_000),
            longest_blink: Micros(0),
            ..expected.fallback
        };
        let times = "stuck_after=1.5&head_stuck_after=never&hold_after=0.1&widen_after=0.25&\
                     head_after=1&full_after=4&head_hold_after=0.01&head_widen_after=0.02&\
                     head_full_after=0.75&longest_blink=0&delay=0.1";
        let serial = "serial:a?protocol=fastrak&";
        for tracker in ["mock:", serial, "hid:1532:0b00?", "replay:a?"] {
            let spec: Spec = format!("{tracker}{times}").parse().unwrap();
            let mut config = EstimatorConfig::default();
            spec.times.set(&mut config);
            assert_eq!(config, expected, "{tracker}");
            assert_eq!(spec.clock().least_delay, Micros(100_000));
        }
        assert!("mock:delay=1.1".parse::<Spec>().is_err());
        let mut keys = KEYS.iter();
        assert!(keys.all(|(key, _)| TIMES.contains(&format!("{key}=S"))));
    }
}
