//! When the next sample comes.

use shisen_tracker::time::Micros;

/// Of a mean that follows what is measured, the part that the newest has in it.
const NEWEST: u64 = 8;

/// Of the mean time between samples, the part by which the next may come sooner.
const SOONER: u64 = 8;

/// So many times the mean, a time between samples is an interruption, which says nothing of
/// the next.
const INTERRUPTION: u64 = 4;

/// Of samples, how they come.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rhythm {
    newest: Option<Micros>,
    /// Between two, in the mean over the newest: nanoseconds. 0 where it is not known.
    between: u64,
}

impl Rhythm {
    /// None has come.
    pub(super) const NEW: Self = Self {
        newest: None,
        between: 0,
    };

    /// One came then.
    pub(super) fn hear(&mut self, came: Micros) {
        let before = self.newest.replace(came);
        let Some(since) = before.map(|before| came.since(before).0.saturating_mul(1_000)) else {
            return;
        };
        if self.between == 0 {
            self.between = since;
        } else if since <= self.between.saturating_mul(INTERRUPTION) {
            self.between = self.between - self.between / NEWEST + since / NEWEST;
        }
    }

    /// Whether no other is expected until then. One that should have come still may.
    pub(super) fn is_last_before(&self, until: Micros) -> bool {
        let soonest = self.between - self.between / SOONER;
        self.between > 0
            && self
                .newest
                .is_some_and(|newest| newest.0.saturating_add(soonest / 1_000) > until.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After samples so many milliseconds apart, until how long after the last of them no
    /// other is expected: milliseconds.
    fn alone(apart: impl IntoIterator<Item = u64>) -> u64 {
        let mut rhythm = Rhythm::NEW;
        let mut now = Micros(5_000_000);
        let later = |now: Micros, by: u64| Micros(now.0 + 1_000 * by);
        rhythm.hear(now);
        for apart in apart {
            now = later(now, apart);
            rhythm.hear(now);
        }
        let until = |after: &u64| rhythm.is_last_before(later(now, *after));
        (0..1_000).take_while(until).count() as u64
    }

    #[test]
    fn the_next_is_expected_a_little_before_its_time() {
        assert_eq!(alone([16; 40]), 14);
        assert_eq!(alone([100; 40]), 88);
        // Nothing is known after one, and any other may come.
        assert_eq!(alone([]), 0);
        assert_eq!(alone([100]), 88);
    }

    #[test]
    fn it_follows_a_rate_and_no_interruption() {
        assert_eq!(alone([16; 40].into_iter().chain([700])), 14);
        let slower = alone([16; 40].into_iter().chain([32; 40]));
        assert!((27..=28).contains(&slower), "{slower}");
        let faster = alone([32; 40].into_iter().chain([16; 40]));
        assert!((14..=15).contains(&faster), "{faster}");
        // All at once: what lay in a buffer.
        let buffered = alone([16; 40].into_iter().chain([0; 3]).chain([16; 40]));
        assert_eq!(buffered, 14);
    }

    #[test]
    fn times_have_no_end() {
        let mut rhythm = Rhythm::NEW;
        for time in [0, u64::MAX, 0, u64::MAX, u64::MAX] {
            rhythm.hear(Micros(time));
            assert!(!rhythm.is_last_before(Micros(u64::MAX)));
        }
    }
}
