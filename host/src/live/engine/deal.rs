//! Steps for tiles.

use super::LiveTile;
use super::threads::lock;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps that a group may take above its allotment, until more has been seen: the
/// dearest block's primary rays, or a pixel's whole tree.
const LEAST_EXCESS: u64 = 2_048;

/// How many times as much where squares of pixels share their samples: most squares'.
const TIMES_OF_SQUARES: u64 = 2;

/// Where a budget is an end, the part of it that is set aside for a group at most: one that
/// is smaller than what groups may take still goes to the first.
const LEAST_PART_ASIDE: u64 = 4;

/// Samples a pixel from which on a pixel's trees may take more than that: so many times as
/// much, then, as it has times these samples.
const FEW_SAMPLES: u64 = 16;

/// What a group is dealt, in what is set aside for it: so much of a budget is not in
/// use at once.
const SHARE_OF_EXCESS: u64 = 8;

/// In how many groups a budget is dealt out at least, where they are smaller than
/// that: for threads to share.
const LEAST_GROUPS: u64 = 32;

/// What a group is dealt all the same, in what is set aside for it: of a small budget
/// at most a third is set aside.
const LEAST_SHARE: u64 = 2;

/// What is expected, in the unit in which it is known how many times as much is dealt.
const WHOLE: u64 = 1 << 8;

/// Of what is expected, the least that is dealt to those who are dealt anything: a gaze
/// that moves on makes tiles a little dearer.
const LEAST_TIMES: u64 = WHOLE * 9 / 8;

/// And the most.
const MOST_TIMES: u64 = WHOLE << 8;

/// Of what is left, the part that is kept where there is more than is expected: some may
/// take more above their share than is set aside for them.
const CUSHION: u64 = 8;

/// Tiles next to each other in the order, that one thread renders one after another:
/// what one leaves is the next one's.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Of the order. Those that are finished are skipped.
    pub(super) tiles: Range<usize>,
    /// What they may take together.
    pub(super) allotment: u64,
    /// What they may take above it, to end what they have begun: no step more.
    pub(super) overrun: u64,
}

/// Deals out all that each unfinished tile may need, to each on its own.
pub(super) fn everything<'t>(
    tiles: impl Iterator<Item = &'t Mutex<LiveTile>>,
    groups: &mut Vec<Group>,
) {
    groups.clear();
    for (at, tile) in tiles.enumerate() {
        if !lock(tile).job.is_finished() {
            groups.push(Group {
                tiles: at..at + 1,
                allotment: u64::MAX,
                overrun: u64::MAX,
            });
        }
    }
}

/// What unfinished tiles are expected to take still.
pub(super) fn expected<'t>(tiles: impl Iterator<Item = &'t Mutex<LiveTile>>) -> u64 {
    let unfinished = tiles.map(lock).filter(|tile| !tile.job.is_finished());
    unfinished.map(|tile| tile.still()).sum()
}

/// Deals out a budget.
pub(super) struct Dealer {
    /// The most that a group is expected to take above its allotment.
    excess: u64,
    /// The frame's budget, where it is an end: no group takes more than what is set aside
    /// for it then, whatever it has begun.
    kept: Option<u64>,
}

impl Dealer {
    /// Of pixels of so many samples.
    pub(super) const fn new(samples: u16) -> Self {
        let times = samples as u64 / FEW_SAMPLES;
        let excess = LEAST_EXCESS * if times > 1 { times } else { 1 };
        Self { excess, kept: None }
    }

    /// Squares of pixels share their samples.
    pub(super) fn expect_squares(&mut self) {
        self.excess = self.excess.max(LEAST_EXCESS * TIMES_OF_SQUARES);
    }

    /// A frame begins, whose budget is an end that is kept or not.
    pub(super) const fn begin(&mut self, kept: Option<u64>) {
        self.kept = kept;
    }

    /// What is set aside for each group.
    fn aside(&self) -> u64 {
        let most = self.kept.map_or(u64::MAX, |steps| steps / LEAST_PART_ASIDE);
        self.excess.min(most)
    }

    /// Takes notice of what was taken too much.
    pub(super) fn look_at(&mut self, excess: &AtomicU64) {
        // What comes next may be half as dear again; what was broken off is dearer.
        let most = excess.load(Ordering::SeqCst) * 3 / 2;
        self.excess = self.excess.max(most);
    }

    /// Gives unfinished tiles what they are expected to need, from the first on, as
    /// long as there is something left; and all the same part more, or as many times as
    /// much, of what no tile is expected to need. A budget is looked at before each block
    /// or square only, so that a group may take a little more than it is given: that much
    /// is set aside for each, and where a budget is an end it is the most.
    pub(super) fn deal<'t>(
        &self,
        left: u64,
        tiles: impl Iterator<Item = &'t Mutex<LiveTile>> + Clone,
        groups: &mut Vec<Group>,
    ) {
        let aside = self.aside();
        let full = (left / LEAST_GROUPS).clamp(LEAST_SHARE * aside, SHARE_OF_EXCESS * aside);
        self.deal_groups(left, full, tiles, groups);
    }

    /// The same to few tiles, in groups as small as they can be: there is nothing after
    /// these for threads that have done theirs.
    pub(super) fn deal_finely<'t>(
        &self,
        left: u64,
        tiles: impl Iterator<Item = &'t Mutex<LiveTile>> + Clone,
        groups: &mut Vec<Group>,
    ) {
        self.deal_groups(left, LEAST_SHARE * self.aside(), tiles, groups);
    }

    /// Deals to groups that are full when they have so much of what is expected.
    fn deal_groups<'t>(
        &self,
        mut left: u64,
        full: u64,
        tiles: impl Iterator<Item = &'t Mutex<LiveTile>> + Clone,
        groups: &mut Vec<Group>,
    ) {
        groups.clear();
        let (aside, expected) = (self.aside(), expected(tiles.clone()));
        // Of each full group and what is set aside for it.
        let to_groups = (left - left / CUSHION) / (full + aside).max(1) * full;
        let times = to_groups.saturating_mul(WHOLE) / expected.max(1);
        let times = times.clamp(LEAST_TIMES, MOST_TIMES);
        let mut open = None;
        for (at, tile) in tiles.enumerate() {
            let tile = lock(tile);
            if tile.job.is_finished() {
                continue;
            }
            if open.is_none() {
                if left <= aside {
                    return;
                }
                left -= aside;
                groups.push(Group {
                    tiles: at..at,
                    allotment: 0,
                    overrun: self.kept.map_or(u64::MAX, |_| aside),
                });
            }
            let Some(group) = groups.last_mut() else {
                return;
            };
            let expected = tile.still();
            let allotment = (expected.saturating_mul(times) / WHOLE).min(left);
            left -= allotment;
            group.tiles.end = at + 1;
            group.allotment += allotment;
            let has = open.unwrap_or(0) + expected;
            open = (has < full).then_some(has);
            if left == 0 {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_core::frame::Tile;

    fn tiles(count: u32, expected: u64) -> Vec<Mutex<LiveTile>> {
        let tile = |number| {
            let mut tile = LiveTile::new(
                0,
                Tile {
                    x: 16 * number,
                    y: 0,
                    width: 16,
                    height: 16,
                },
            );
            tile.expected = expected;
            Mutex::new(tile)
        };
        (0..count).map(tile).collect()
    }

    #[test]
    fn what_is_set_aside_leaves_most_of_a_budget() {
        let tiles = tiles(54, 900);
        let dealer = Dealer::new(1);
        let mut groups = Vec::new();
        for budget in (4 * LEAST_EXCESS..400_000).step_by(997) {
            dealer.deal(budget, tiles.iter(), &mut groups);
            let dealt: u64 = groups.iter().map(|group| group.allotment).sum();
            let aside = groups.len() as u64 * dealer.aside();
            assert!(dealt + aside <= budget, "{dealt} and {aside} of {budget}");
            let needed = 54 * 900;
            let least = (budget / 2).min(needed);
            assert!(
                dealt >= least,
                "{dealt} of {budget} in {} groups",
                groups.len()
            );
            let mut next = 0;
            for group in &groups {
                assert_eq!(group.tiles.start, next, "{groups:?}");
                next = group.tiles.end;
            }
        }
    }

    #[test]
    fn what_nobody_is_expected_to_need_is_dealt_to_all_alike() {
        let tiles = tiles(54, 900);
        let dealer = Dealer::new(1);
        let mut groups = Vec::new();
        for (budget, least) in [(80_000, 1.0), (200_000, 2.5), (1 << 50, 200.0)] {
            dealer.deal(budget, tiles.iter(), &mut groups);
            let each = |group: &Group| group.allotment as f64 / (900 * group.tiles.len()) as f64;
            let all: Vec<f64> = groups.iter().map(each).collect();
            let (fewest, most) = all
                .iter()
                .fold((f64::MAX, 0.0_f64), |(fewest, most), &one| {
                    (fewest.min(one), most.max(one))
                });
            assert!(most < 1.01 * fewest, "{budget}: {all:?}");
            assert!(fewest >= least, "{budget}: {all:?}");
            assert_eq!(groups.last().map(|group| group.tiles.end), Some(54));
        }
        // Few, and small, groups for few tiles.
        dealer.deal_finely(1 << 50, tiles.iter().take(8), &mut groups);
        let lengths: Vec<usize> = groups.iter().map(|group| group.tiles.len()).collect();
        assert_eq!(lengths, [5, 3]);
    }
}
