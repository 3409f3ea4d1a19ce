//! What to do when the gaze is no longer known: a ladder, one rung after
//! another as the newest sample ages.

use crate::time::Micros;

/// How much can be relied on. Worse is greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// Gaze and head are new enough.
    Fresh,
    /// The last gaze is held: a blink, a reflection, a few lost samples.
    Hold,
    /// The gaze is about where it was: the field of full detail widens.
    Widened,
    /// Where the eyes look is not known; the head faces the line of sight.
    HeadDirection,
    /// Nothing is known: full detail everywhere.
    FullQuality,
}

impl State {
    /// All of them, from the best.
    pub const ALL: [Self; 5] = [
        Self::Fresh,
        Self::Hold,
        Self::Widened,
        Self::HeadDirection,
        Self::FullQuality,
    ];

    /// In words, for a report.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fresh => "fresh",
            Self::Hold => "hold",
            Self::Widened => "widened",
            Self::HeadDirection => "head direction",
            Self::FullQuality => "full quality",
        }
    }
}

/// From what age on, at the time of display, which rung is taken. The ages of
/// the gaze ascend, up to 60 s, and so do those of the head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FallbackConfig {
    /// Gaze: [`State::Hold`].
    pub hold_after: Micros,
    /// Gaze: [`State::Widened`].
    pub widen_after: Micros,
    /// Gaze: [`State::HeadDirection`].
    pub head_after: Micros,
    /// Gaze: [`State::FullQuality`].
    pub full_after: Micros,
    /// Whether a gaze without end of age, or that never came, is the head's direction as long as the
    /// head is known: where another tracker measures that.
    pub keeps_head: bool,
    /// The widening from `head_after` on, radians, 0 to π; it grows from `widen_after` on.
    pub widen_by: f32,
    /// Head: [`State::Hold`], or worse.
    pub head_hold_after: Micros,
    /// Head: [`State::Widened`], or worse.
    pub head_widen_after: Micros,
    /// Head: [`State::FullQuality`].
    pub head_full_after: Micros,
    /// How long a blink holds the gaze, whatever its age; up to 5 s.
    pub longest_blink: Micros,
}

impl Default for FallbackConfig {
    /// Gaze 80 ms, 200 ms, 1.2 s, 3 s; widened by 20°; head 80 ms, 200 ms,
    /// 500 ms; blinks up to 900 ms.
    fn default() -> Self {
        Self {
            hold_after: Micros(80_000),
            widen_after: Micros(200_000),
            head_after: Micros(1_200_000),
            full_after: Micros(3_000_000),
            keeps_head: false,
            widen_by: 0.349_066,
            head_hold_after: Micros(80_000),
            head_widen_after: Micros(200_000),
            head_full_after: Micros(500_000),
            longest_blink: Micros(900_000),
        }
    }
}

/// What is known of one source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Age {
    /// It is not used.
    Unused,
    /// It never came.
    Never,
    /// It is this old.
    Of(Micros),
}

/// Returns the rung for the ages, and how far the field of full detail is widened, radians.
pub(super) fn rung(config: &FallbackConfig, gaze: Age, head: Age, blink: bool) -> (State, f32) {
    let is_old = |age: Micros| age >= config.full_after && !blink;
    let (of_gaze, gaze_widens) = match gaze {
        // There is only the head's direction.
        Age::Unused => (State::HeadDirection, config.widen_by),
        Age::Never if config.keeps_head => (State::HeadDirection, config.widen_by),
        Age::Of(age) if config.keeps_head && is_old(age) => (State::HeadDirection, config.widen_by),
        Age::Never => (State::FullQuality, 0.0),
        Age::Of(age) if is_old(age) => (State::FullQuality, 0.0),
        Age::Of(age) if blink && age >= config.hold_after => (State::Hold, 0.0),
        Age::Of(age) if age >= config.head_after => (State::HeadDirection, config.widen_by),
        Age::Of(age) if age >= config.widen_after => {
            let part = share(age, config.widen_after, config.head_after);
            (State::Widened, config.widen_by * part)
        }
        Age::Of(age) if age >= config.hold_after => (State::Hold, 0.0),
        Age::Of(_) => (State::Fresh, 0.0),
    };
    let (of_head, head_widens) = match head {
        Age::Never => (State::FullQuality, 0.0),
        Age::Of(age) if age >= config.head_full_after => (State::FullQuality, 0.0),
        Age::Of(age) if age >= config.head_widen_after => {
            let part = share(age, config.head_widen_after, config.head_full_after);
            (State::Widened, config.widen_by * part)
        }
        Age::Of(age) if age >= config.head_hold_after => (State::Hold, 0.0),
        Age::Unused | Age::Of(_) => (State::Fresh, 0.0),
    };
    let state = of_gaze.max(of_head);
    let widen = if state == State::FullQuality {
        core::f32::consts::PI
    } else {
        gaze_widens.max(head_widens)
    };
    (state, widen)
}

/// Returns how far an age is from one to another, up to 1.
fn share(age: Micros, from: Micros, to: Micros) -> f32 {
    (age.since(from).seconds() / to.since(from).seconds().max(1.0e-6)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rungs_follow_the_ages() {
        let config = FallbackConfig::default();
        let at = |gaze_ms, head_ms, blink| {
            let age = |ms| Age::Of(Micros::from_millis(ms));
            rung(&config, age(gaze_ms), age(head_ms), blink)
        };
        for (gaze, head, blink, state) in [
            (0, 0, false, State::Fresh),
            (79, 79, false, State::Fresh),
            (80, 0, false, State::Hold),
            (0, 80, false, State::Hold),
            (200, 0, false, State::Widened),
            (0, 200, false, State::Widened),
            (1_200, 0, false, State::HeadDirection),
            (3_000, 0, false, State::FullQuality),
            (0, 500, false, State::FullQuality),
            (10, 0, true, State::Fresh),
            (880, 0, true, State::Hold),
            (880, 300, true, State::Widened),
        ] {
            assert_eq!(at(gaze, head, blink).0, state, "{gaze} {head} {blink}");
        }
        assert_eq!(at(0, 0, false).1, 0.0);
        assert!((at(700, 0, false).1 - 0.5 * config.widen_by).abs() < 1e-6);
        assert_eq!(at(1_300, 0, false).1, config.widen_by);
        assert_eq!(at(9_000, 0, false).1, core::f32::consts::PI);
        let never = rung(&config, Age::Never, Age::Unused, false);
        assert_eq!(never.0, State::FullQuality);
        let head_only = rung(&config, Age::Unused, Age::Of(Micros(0)), false);
        assert_eq!(head_only, (State::HeadDirection, config.widen_by));
    }
}
