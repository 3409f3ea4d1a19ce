//! How late a tracker is, and after how long its data are stale, and count as stuck, as
//! `key=seconds` of a `SPEC` says it.

use super::settings::Options;
use super::spec::SpecError;
use shisen_tracker::clock::ClockConfig;
use shisen_tracker::estimate::EstimatorConfig;
use shisen_tracker::time::Micros;

/// Times of an [`EstimatorConfig`] and its
/// [`FallbackConfig`](shisen_tracker::estimate::FallbackConfig) that somebody gave; the
/// keys are the names of their fields. And the least delay of a [`ClockConfig`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Times {
    given: [Option<Time>; KEYS.len()],
    delay: Option<Micros>,
}

/// A time that was given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Time {
    After(Micros),
    /// What is compared with it is believed.
    Never,
}

/// What a key sets.
#[derive(Clone, Copy)]
enum Field {
    Time(fn(&mut EstimatorConfig) -> &mut Micros),
    /// One that can be never, too.
    Option(fn(&mut EstimatorConfig) -> &mut Option<Micros>),
}

const KEYS: [(&str, Field); 10] = [
    ("stuck_after", Field::Option(|c| &mut c.stuck_after)),
    (
        "head_stuck_after",
        Field::Option(|c| &mut c.head_stuck_after),
    ),
    ("hold_after", Field::Time(|c| &mut c.fallback.hold_after)),
    ("widen_after", Field::Time(|c| &mut c.fallback.widen_after)),
    ("head_after", Field::Time(|c| &mut c.fallback.head_after)),
    ("full_after", Field::Time(|c| &mut c.fallback.full_after)),
    (
        "head_hold_after",
        Field::Time(|c| &mut c.fallback.head_hold_after),
    ),
    (
        "head_widen_after",
        Field::Time(|c| &mut c.fallback.head_widen_after),
    ),
    (
        "head_full_after",
        Field::Time(|c| &mut c.fallback.head_full_after),
    ),
    (
        "longest_blink",
        Field::Time(|c| &mut c.fallback.longest_blink),
    ),
];

/// The keys, for a person.
pub(super) const ALLOWED: &str = "stuck_after=S|never, head_stuck_after=S|never, hold_after=S, \
                                  widen_after=S, head_after=S, full_after=S, head_hold_after=S, \
                                  head_widen_after=S, head_full_after=S, longest_blink=S, \
                                  delay=S";

/// The longest time that any of them can be, seconds.
const LONGEST: f64 = 60.0;

/// The longest delay, seconds.
const MOST_DELAY: f64 = 1.0;

/// So many seconds, up to the most.
fn seconds(value: &str, most: f64) -> Option<Micros> {
    let seconds: f64 = value.parse().ok()?;
    // NaN is in no range.
    let is_time = (0.0..=most).contains(&seconds);
    is_time.then(|| Micros((seconds * 1.0e6).round() as u64))
}

impl Times {
    /// Takes those of the options that are times.
    ///
    /// # Errors
    /// A value that is no time, or one that the estimator refuses.
    pub(super) fn take(options: &mut Options<'_>) -> Result<Self, SpecError> {
        let mut times = Self::default();
        for ((key, field), time) in KEYS.into_iter().zip(&mut times.given) {
            let (can_never, allowed) = match field {
                Field::Option(_) => (true, "seconds from 0.05 to 60, such as 0.25, or never"),
                Field::Time(_) => (false, "seconds from 0 to 60, such as 0.25"),
            };
            *time = options.one_of(key, allowed, |value| {
                if can_never && value == "never" {
                    return Some(Time::Never);
                }
                seconds(value, LONGEST).map(Time::After)
            })?;
        }
        let allowed = "seconds from 0 to 1, such as 0.008";
        times.delay = options.one_of("delay", allowed, |value| seconds(value, MOST_DELAY))?;
        let mut config = EstimatorConfig::default();
        times.set(&mut config);
        config.check().map_err(SpecError::Times)?;
        Ok(times)
    }

    /// Of a tracker that is late by so much at least, and nothing else.
    pub fn late(delay: Micros) -> Self {
        Self {
            delay: Some(delay),
            ..Self::default()
        }
    }

    /// How late its samples are at least, where that was given.
    pub const fn delay(&self) -> Option<Micros> {
        self.delay
    }

    /// How to read the clock of a tracker that is as late as that, or as `usual`.
    pub fn clock(&self, usual: Micros) -> ClockConfig {
        ClockConfig {
            least_delay: self.delay.unwrap_or(usual),
            ..ClockConfig::default()
        }
    }

    /// Puts those that were given into a configuration.
    pub fn set(&self, config: &mut EstimatorConfig) {
        for ((_, field), time) in KEYS.into_iter().zip(self.given) {
            match (field, time) {
                (Field::Time(field), Some(Time::After(time))) => *field(config) = time,
                (Field::Option(field), Some(time)) => {
                    *field(config) = match time {
                        Time::After(time) => Some(time),
                        Time::Never => None,
                    }
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::spec::Spec;
    use super::*;

    fn config_of(spec: &str) -> EstimatorConfig {
        let spec: Spec = spec.parse().unwrap();
        let mut config = EstimatorConfig::default();
        spec.times().set(&mut config);
        config
    }

    #[test]
    fn each_key_sets_its_field_behind_every_kind_of_tracker() {
        for tracker in [
            "mock:",
            "serial:/dev/ttyUSB0?protocol=fastrak&",
            "hid:1532:0b00?",
            "replay:a?",
        ] {
            let times = "stuck_after=1.5&head_stuck_after=never&hold_after=0.1&widen_after=0.25&\
                         head_after=1&full_after=4&head_hold_after=0.01&head_widen_after=0.02&\
                         head_full_after=0.75&longest_blink=0";
            let config = config_of(&format!("{tracker}{times}"));
            let mut expected = EstimatorConfig {
                stuck_after: Some(Micros(1_500_000)),
                head_stuck_after: None,
                ..EstimatorConfig::default()
            };
            let fallback = &mut expected.fallback;
            fallback.hold_after = Micros(100_000);
            fallback.widen_after = Micros(250_000);
            fallback.head_after = Micros(1_000_000);
            fallback.full_after = Micros(4_000_000);
            fallback.head_hold_after = Micros(10_000);
            fallback.head_widen_after = Micros(20_000);
            fallback.head_full_after = Micros(750_000);
            fallback.longest_blink = Micros(0);
            assert_eq!(config, expected, "{tracker}");
            assert_eq!(
                config_of(&tracker[..tracker.len() - 1]),
                EstimatorConfig::default()
            );
        }
        let late: Spec = "serial:a?protocol=link&delay=0.1".parse().unwrap();
        assert_eq!(late.clock().least_delay, Micros(100_000));
        assert_eq!(
            "hid:1532:0b00".parse::<Spec>().unwrap().clock(),
            ClockConfig::default()
        );
        assert!("mock:delay=1.1".parse::<Spec>().is_err());
        assert!(
            KEYS.iter()
                .all(|(key, _)| ALLOWED.contains(&format!("{key}=S")))
        );
    }
}
