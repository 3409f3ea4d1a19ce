//! How something moves, from its last few places.

use crate::time::Micros;
use glam::Vec3;
use heapless::Deque;

/// The newest `N` places and their times. Making one writes to none of them.
#[derive(Debug, Clone)]
pub(super) struct History<T, const N: usize> {
    /// The low half of each time and its place, oldest first; none is 71 minutes older.
    entries: Deque<(u32, T), N>,
    newest: Micros,
}

impl<T: Copy, const N: usize> History<T, N> {
    pub(super) const fn new() -> Self {
        Self {
            entries: Deque::new(),
            newest: Micros(0),
        }
    }

    /// Times ascend: the caller sees to it. The last of several at one time is kept.
    pub(super) fn push(&mut self, time: Micros, value: T) {
        if let Some(newest) = self.entries.back_mut().filter(|_| self.newest == time) {
            newest.1 = value;
            return;
        }
        if self.entries.is_full() {
            self.entries.pop_front();
        }
        while let Some(&(oldest, _)) = self.entries.front()
            && time.since(self.whole(oldest)).0 > u32::MAX.into()
        {
            self.entries.pop_front();
        }
        // There is room now.
        let _ = self.entries.push_back((time.0 as u32, value));
        self.newest = time;
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Returns the time of which this is the low half.
    fn whole(&self, low: u32) -> Micros {
        let age = (self.newest.0 as u32).wrapping_sub(low);
        Micros(self.newest.0.wrapping_sub(age.into()))
    }

    /// From the newest to the oldest.
    pub(super) fn newest_first(&self) -> impl Iterator<Item = (Micros, T)> + Clone + '_ {
        let (older, newer) = self.entries.as_slices();
        let newest_first = newer.iter().rev().chain(older.iter().rev());
        newest_first.map(|&(low, value)| (self.whole(low), value))
    }

    pub(super) fn newest(&self) -> Option<(Micros, T)> {
        let value = self.entries.back().map(|&(_, value)| value);
        value.map(|value| (self.newest, value))
    }
}

impl<const N: usize> History<Vec3, N> {
    /// Moves all of them by so much.
    pub(super) fn shift(&mut self, by: Vec3) {
        for (_, place) in &mut self.entries {
            *place += by;
        }
    }

    /// Returns the place at a time before the newest: between those around it, or the oldest.
    pub(super) fn before(&self, time: Micros) -> Option<Vec3> {
        let mut after: Option<(Micros, Vec3)> = None;
        for (at, place) in self.newest_first() {
            if let (true, Some((end, to))) = (at <= time, after) {
                let share = time.since(at).seconds() / end.since(at).seconds();
                return Some(place + (to - place) * share);
            }
            after = Some((at, place));
            if at <= time {
                break;
            }
        }
        after.map(|(_, place)| place)
    }

    /// Returns the newest `count` of them, as seen from `origin`.
    pub(super) fn places(&self, count: usize, origin: Vec3) -> Places<'_> {
        let (older, newer) = self.entries.as_slices();
        Places {
            older,
            newer,
            now: self.newest.0 as u32,
            origin,
            count,
        }
    }
}

/// The newest places of a history of any length: code that reads them is compiled once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places<'h> {
    /// The measurement before all of `newer`.
    older: &'h [(u32, Vec3)],
    newer: &'h [(u32, Vec3)],
    /// The low half of the newest's time.
    now: u32,
    origin: Vec3,
    count: usize,
}

impl Places<'_> {
    /// Returns seconds after the newest, at most zero, and places; from the newest to the oldest.
    fn newest_first(&self) -> impl Iterator<Item = (f32, Vec3)> + '_ {
        let newest_first = self.newer.iter().rev().chain(self.older.iter().rev());
        newest_first.take(self.count).map(|&(low, place)| {
            let age = self.now.wrapping_sub(low) as f32 * 1.0e-6;
            (-age, place - self.origin)
        })
    }
}

/// From one time to another, seconds; below zero where `to` is earlier.
pub(super) fn seconds(from: Micros, to: Micros) -> f32 {
    if to >= from {
        to.since(from).seconds()
    } else {
        -from.since(to).seconds()
    }
}

/// A least squares line through places at their times, in seconds.
#[derive(Debug, Clone, Copy)]
struct Line {
    slope: Vec3,
    /// The sum of the squared distances of the times from their mean.
    spread: f32,
    /// The sum of the squared distances of the places from the line.
    rest: f32,
    count: f32,
}

impl Line {
    /// Through those whose times are in a range. `None` of places at one time.
    #[inline(never)]
    fn through(places: &Places<'_>, from: f32, to: f32) -> Option<Self> {
        let places = || {
            let all = places.newest_first();
            all.filter(|(t, _)| *t >= from && *t <= to)
        };
        let (mut count, mut time, mut place) = (0.0f32, 0.0f32, Vec3::ZERO);
        for (t, p) in places() {
            count += 1.0;
            time += t;
            place += p;
        }
        if count < 2.0 {
            return None;
        }
        let (time, place) = (time / count, place / count);
        let (mut spread, mut common, mut square) = (0.0f32, Vec3::ZERO, 0.0f32);
        for (t, p) in places() {
            let (t, p) = (t - time, p - place);
            spread += t * t;
            common += p * t;
            square += p.dot(p);
        }
        let slope = common / spread;
        (spread > 1.0e-12 && slope.is_finite()).then_some(Self {
            slope,
            spread,
            rest: (square - slope.dot(common)).max(0.0),
            count,
        })
    }
}

/// Returns the slope of the least squares line through places; `None` of places at one time.
pub(super) fn slope(places: &Places<'_>) -> Option<Vec3> {
    Line::through(places, f32::NEG_INFINITY, 0.0).map(|line| line.slope)
}

/// Returns the velocity of something that moves steadily; zero of what rests,
/// trembles or has just made a step.
///
/// The mean of the slopes of the older and the newer half. It shrinks by their difference, as
/// James's and Stein's estimator does: that is noise, or a step, which only one of them sees. It
/// shrinks as the newest quarter is slower than noise explains, where a stop shows first, and
/// where it is no more than noise itself. Below `least` per second it is zero.
#[inline(never)]
pub(super) fn steady_velocity(places: &Places<'_>, least: f32) -> Vec3 {
    /// Pure noise gives the mean's square a quarter of the difference's; this is four times that.
    const CAUTION: f32 = 1.0;
    let Some((oldest, _)) = places.newest_first().last() else {
        return Vec3::ZERO;
    };
    let middle = 0.5 * oldest;
    let newer = Line::through(places, middle, 0.0);
    let older = Line::through(places, oldest, middle);
    let Some((newer, older)) = newer.zip(older) else {
        return Vec3::ZERO;
    };
    let mean = (newer.slope + older.slope) * 0.5;
    let difference = newer.slope - older.slope;
    let square = mean.dot(mean);
    // Rises from 0 at the least speed to 1 at twice that.
    let fast = (shisen_core::numeric::sqrt(square) / least - 1.0).clamp(0.0, 1.0);
    let sure = (1.0 - CAUTION * difference.dot(difference) / square.max(1.0e-20)).clamp(0.0, 1.0);
    // The variance of one component of a place. Each line takes up two places' worth of
    // freedom; what is below a micrometre or microradian is rounding.
    let freedom = (newer.count + older.count - 4.0).max(1.0);
    let noise = (0.5 * (newer.rest + older.rest) / freedom).max(1.0e-12);
    // Squares in units of their variance: 2 on average where there is only
    // noise, 6 in one of twenty cases, 9 in one of a hundred.
    let variance = 0.25 * noise * (1.0 / newer.spread + 1.0 / older.spread);
    let clear = (square / variance / 9.0 - 1.0).clamp(0.0, 1.0);
    let last = Line::through(places, 0.5 * middle, 0.0);
    let goes_on = last.map_or(1.0, |last| {
        // Along its own way: what goes faster, or aside, does not stop.
        let slower = (mean - last.slope).dot(mean).max(0.0);
        let slower = slower * slower / square.max(1.0e-20) * last.spread / noise;
        ((9.0 - slower) / 5.0).clamp(0.0, 1.0)
    });
    mean * (fast * sure * clear * goes_on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_whole_across_a_wrap_of_their_low_half() {
        let mut history = History::<u8, 4>::new();
        let wrap = 5 << 32;
        let times = [wrap - 7, wrap - 1, wrap, wrap + 3].map(Micros);
        for (value, time) in (0..).zip(times) {
            history.push(time, value);
        }
        let found: std::vec::Vec<_> = history.newest_first().map(|(t, _)| t).collect();
        assert_eq!(found, [times[3], times[2], times[1], times[0]]);
        // What is too old to be told from something newer is forgotten.
        let later = Micros(times[2].0 + u64::from(u32::MAX));
        history.push(later, 9);
        assert!(
            history
                .newest_first()
                .eq([(later, 9), (times[3], 3), (times[2], 2)])
        );
        history.push(Micros(u64::MAX), 10);
        assert!(history.newest_first().eq([(Micros(u64::MAX), 10)]));
    }
}
