//! How something moves, from its last few places.

use crate::time::Micros;
use glam::Vec3;
use heapless::{Deque, Vec};

/// The newest `N` places and their times; a new one takes the oldest's place.
///
/// What has not come yet is not written to: a history is made in no time, and
/// where it is to stay.
#[derive(Debug, Clone)]
pub(super) struct History<T, const N: usize> {
    entries: Deque<(Micros, T), N>,
}

impl<T: Copy, const N: usize> History<T, N> {
    pub(super) const fn new() -> Self {
        Self {
            entries: Deque::new(),
        }
    }

    /// Times ascend: the caller sees to it. Of several at one time the last is
    /// kept.
    pub(super) fn push(&mut self, time: Micros, value: T) {
        if let Some(newest) = self.entries.back_mut().filter(|(last, _)| *last == time) {
            newest.1 = value;
            return;
        }
        if self.entries.is_full() {
            self.entries.pop_front();
        }
        // There is room now.
        let _ = self.entries.push_back((time, value));
    }

    pub(super) fn clear(&mut self) {
        self.entries.clear();
    }

    /// From the newest to the oldest.
    pub(super) fn newest_first(&self) -> impl Iterator<Item = (Micros, T)> + Clone + '_ {
        let (older, newer) = self.entries.as_slices();
        newer.iter().rev().chain(older.iter().rev()).copied()
    }

    pub(super) fn newest(&self) -> Option<(Micros, T)> {
        self.entries.back().copied()
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
    /// `None` of places at one time.
    fn through(places: impl Iterator<Item = (f32, Vec3)> + Clone) -> Option<Self> {
        let (mut count, mut time, mut place) = (0.0f32, 0.0f32, Vec3::ZERO);
        for (t, p) in places.clone() {
            count += 1.0;
            time += t;
            place += p;
        }
        if count < 2.0 {
            return None;
        }
        let (time, place) = (time / count, place / count);
        let (mut spread, mut common, mut square) = (0.0f32, Vec3::ZERO, 0.0f32);
        for (t, p) in places {
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

/// The slope of the least squares line through places at their times, in
/// seconds; `None` of places at one time.
pub(super) fn slope(places: impl Iterator<Item = (f32, Vec3)> + Clone) -> Option<Vec3> {
    Line::through(places).map(|line| line.slope)
}

/// Places that [`steady_velocity`] looks at: all that a history keeps.
pub(super) const MOST_PLACES: usize = 128;

/// The velocity of something that moves steadily; zero of what rests,
/// trembles or has just made a step.
///
/// The places' older and newer half each have a slope. Their mean is the
/// velocity, their difference is how little it is worth, be it for noise or
/// for a step, which only one of them sees; the velocity shrinks by it as
/// James's and Stein's estimator does. It also shrinks as the newest quarter
/// departs from it by more than the noise explains, since something that
/// stops shows there first, and where it is itself no more than noise. Below `least` per second it is zero.
///
/// Of more than [`MOST_PLACES`] only the newest, which come first, count.
// Not a part of its callers: it takes 2 KiB of stack, which others behind them
// would have to add to.
#[inline(never)]
pub(super) fn steady_velocity(places: impl Iterator<Item = (f32, Vec3)>, least: f32) -> Vec3 {
    // Once: they can be costly to make. Not collected, which would take the memory
    // twice.
    let mut all: Vec<(f32, Vec3), MOST_PLACES> = Vec::new();
    for place in places.take(MOST_PLACES) {
        let _ = all.push(place);
    }
    steady_velocity_of(&all, least)
}

fn steady_velocity_of(places: &[(f32, Vec3)], least: f32) -> Vec3 {
    /// Pure noise gives the mean's square a quarter of the difference's; this
    /// is four times as much.
    const CAUTION: f32 = 1.0;
    let (Some(newest), Some(oldest)) = (places.first(), places.last()) else {
        return Vec3::ZERO;
    };
    let places = places.iter().copied();
    let middle = 0.5 * (newest.0 + oldest.0);
    let newer = Line::through(places.clone().filter(|(t, _)| *t >= middle));
    let older = Line::through(places.clone().filter(|(t, _)| *t <= middle));
    let Some((newer, older)) = newer.zip(older) else {
        return Vec3::ZERO;
    };
    let mean = (newer.slope + older.slope) * 0.5;
    let difference = newer.slope - older.slope;
    let square = mean.dot(mean);
    // Rises from 0 at the least speed to 1 at twice that.
    let fast = (shisen_core::numeric::sqrt(square) / least - 1.0).clamp(0.0, 1.0);
    let sure = (1.0 - CAUTION * difference.dot(difference) / square.max(1.0e-20)).clamp(0.0, 1.0);
    // Of one component of a place. Each line takes up two places' worth of
    // freedom; what is below a micrometre or microradian is rounding.
    let freedom = (newer.count + older.count - 4.0).max(1.0);
    let noise = (0.5 * (newer.rest + older.rest) / freedom).max(1.0e-12);
    // Squares in units of their variance: 2 on average where there is only
    // noise, 6 in one of twenty cases, 9 in one of a hundred.
    let variance = 0.25 * noise * (1.0 / newer.spread + 1.0 / older.spread);
    let clear = (square / variance / 6.0 - 1.0).clamp(0.0, 1.0);
    let quarter = 0.5 * (newest.0 + middle);
    let last = Line::through(places.filter(|(t, _)| *t >= quarter));
    let goes_on = last.map_or(1.0, |last| {
        let departs = last.slope - mean;
        let departure = departs.dot(departs) * last.spread / noise;
        ((9.0 - departure) / 5.0).clamp(0.0, 1.0)
    });
    mean * (fast * sure * clear * goes_on)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_keeps_the_newest() {
        let mut history = History::<u8, 3>::new();
        assert_eq!(history.newest(), None);
        for i in 1..=5 {
            history.push(Micros(i.into()), i);
        }
        assert!(history.newest_first().map(|(_, v)| v).eq([5, 4, 3]));
        history.clear();
        assert_eq!(history.newest_first().count(), 0);
        history.push(Micros(9), 9);
        assert!(history.newest_first().eq([(Micros(9), 9)]));
    }

    #[test]
    fn only_what_moves_steadily_has_a_velocity() {
        let times = || (0..20).map(|i| -0.005 * i as f32);
        let steady = steady_velocity(times().map(|t| (t, Vec3::X * (3.0 * t + 1.0))), 0.1);
        assert!((steady - 3.0 * Vec3::X).length() < 1e-4, "{steady}");
        // A step, wherever it is.
        for at in 1..19 {
            let step = |i: usize| if i < at { 1.0 } else { 0.0 };
            let places = times().enumerate().map(|(i, t)| (t, Vec3::X * step(i)));
            let found = steady_velocity(places, 0.1);
            assert!(found.length() < 1e-4, "{at}: {found}");
        }
        let slow = steady_velocity(times().map(|t| (t, Vec3::Y * 0.09 * t)), 0.1);
        assert_eq!(slow, Vec3::ZERO);
        assert_eq!(steady_velocity([].into_iter(), 0.1), Vec3::ZERO);
        let at_once = [(0.0, Vec3::X), (0.0, Vec3::Y)];
        assert_eq!(steady_velocity(at_once.into_iter(), 0.1), Vec3::ZERO);
    }
}
