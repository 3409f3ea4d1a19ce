//! Two eyes by turns: the left one at even refreshes, the right one at odd ones.
//!
//! The last whole pair is always queued for the next [`AHEAD`] refreshes, so that a late frame
//! repeats a pair rather than an eye. A newer pair takes the places that the older one still had.

use std::collections::VecDeque;

/// Refreshes for which pictures are queued.
pub(super) const AHEAD: u64 = 6;

/// Refreshes that are remembered, and wrong ones among them from which a pane is blanked.
const REMEMBERED: u64 = 60;
const MOST_WRONG: usize = 3;

/// The pair that is shown, and what was seen of it.
#[derive(Debug, Default)]
pub(super) struct Turns {
    /// The pixmaps of the left eye and of the right one; none before the first pair.
    pair: Option<[u32; 2]>,
    serial: u32,
    /// The last refresh that has a picture.
    last: u64,
    /// The newest refresh that was seen, and its eye.
    seen: Option<(u64, u64)>,
    /// Refreshes that showed the wrong eye, the newest last.
    wrong: VecDeque<u64>,
    pub(super) wrong_count: u64,
    pub(super) is_blank: bool,
}

/// A pixmap to present at a refresh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) pixmap: u32,
    pub(super) serial: u32,
    pub(super) refresh: u64,
}

/// What was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    Blanked,
    Unblanked,
}

/// Returns the serial number of an eye's picture in a frame.
pub(super) const fn serial(frame: u32, eye: u64) -> u32 {
    frame.wrapping_shl(1) | (eye & 1) as u32
}

impl Turns {
    /// Queues a newer pair, from an even refresh on.
    pub(super) fn renew(&mut self, pair: [u32; 2], frame: u32, from: u64) -> Vec<Turn> {
        self.pair = Some(pair);
        self.serial = frame;
        let last = self.last.max(from + AHEAD - 1);
        self.last = last;
        (from..=last)
            .filter_map(|refresh| self.turn(refresh))
            .collect()
    }

    fn turn(&self, refresh: u64) -> Option<Turn> {
        let eye = refresh & 1;
        Some(Turn {
            pixmap: self.pair?[eye as usize],
            serial: serial(self.serial, eye),
            refresh,
        })
    }

    /// Takes that an eye was shown at a refresh. Returns what is to be queued, and what changes.
    pub(super) fn see(&mut self, serial: u32, refresh: u64) -> (Vec<Turn>, Option<Change>) {
        let eye = u64::from(serial & 1);
        let before = self
            .seen
            .replace((refresh, eye))
            .filter(|&(at, _)| at < refresh);
        if let Some((at, eye)) = before {
            // Until now the eye before stayed.
            let held = (at + 1..refresh).rev().take(REMEMBERED as usize);
            self.note(held.filter(|held| held & 1 != eye));
        }
        self.note(
            Some(refresh)
                .filter(|refresh| refresh & 1 != eye)
                .into_iter(),
        );
        while self
            .wrong
            .front()
            .is_some_and(|&at| at + REMEMBERED < refresh)
        {
            self.wrong.pop_front();
        }
        let change = match (self.is_blank, self.wrong.len()) {
            (false, MOST_WRONG..) => Some(Change::Blanked),
            (true, 0) => Some(Change::Unblanked),
            _ => None,
        };
        self.is_blank ^= change.is_some();
        let first = self.last.max(refresh) + 1;
        self.last = self.last.max(refresh + AHEAD);
        let turns = (first..=self.last).filter_map(|refresh| self.turn(refresh));
        (turns.collect(), change)
    }

    fn note(&mut self, refreshes: impl Iterator<Item = u64>) {
        for refresh in refreshes {
            self.wrong.push_back(refresh);
            self.wrong_count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_frame_repeats_a_pair_and_a_wrong_eye_is_counted() {
        let mut turns = Turns::default();
        let queued = turns.renew([10, 11], 1, 100);
        let pixmaps: Vec<u32> = queued.iter().map(|turn| turn.pixmap).collect();
        assert_eq!(pixmaps, [10, 11, 10, 11, 10, 11]);
        for refresh in 100..106 {
            let (more, change) = turns.see(serial(1, refresh & 1), refresh);
            let [turn] = more[..] else {
                panic!("{more:?}");
            };
            assert_eq!(
                (turn.refresh, turn.pixmap),
                (refresh + AHEAD, [10, 11][(refresh & 1) as usize])
            );
            assert_eq!(change, None);
        }
        // A newer pair takes the places that are left.
        let queued = turns.renew([20, 21], 2, 108);
        assert_eq!(
            queued.first().map(|turn| (turn.refresh, turn.pixmap)),
            Some((108, 20))
        );
        assert_eq!(
            queued.last().map(|turn| (turn.refresh, turn.pixmap)),
            Some((113, 21))
        );
        // A refresh was missed: the left eye was held over a right one's.
        turns.see(serial(1, 0), 106);
        turns.see(serial(2, 0), 108);
        assert_eq!((turns.wrong_count, turns.is_blank), (1, false));
        // A right eye's picture came late, and again.
        turns.see(serial(2, 1), 110);
        assert_eq!(turns.wrong_count, 3);
        assert!(turns.is_blank);
        let seen = (111..180).map(|refresh| turns.see(serial(2, refresh & 1), refresh).1);
        assert_eq!(seen.flatten().collect::<Vec<_>>(), [Change::Unblanked]);
    }
}
