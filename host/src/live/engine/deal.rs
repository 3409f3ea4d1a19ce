//! Allots a budget of steps to tiles, which stay from frame to frame.

use crate::live::lock;
use crate::picture::tile_hash;
use shisen_core::frame::{Pixel, Tile, TileJob};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// Least excess: steps above its allotment that a group may take before frames show a larger need.
const LEAST_EXCESS: u64 = 2_048;

/// Multiple of [`LEAST_EXCESS`] that a group may take where squares of pixels share samples.
const SQUARES_FACTOR: u64 = 2;

/// At most one part in this many of a hard budget is set aside for a group.
const LEAST_PART_ASIDE: u64 = 4;

/// Samples a pixel up to which [`LEAST_EXCESS`] holds; it grows in proportion above.
const FEW_SAMPLES: u64 = 16;

/// The largest allotment of a group as a multiple of what is set aside for it.
const SHARE_OF_EXCESS: u64 = 8;

/// The least number of groups, for threads to share, where groups are smaller than that.
const LEAST_GROUPS: u64 = 32;

/// The smallest allotment of a full group as a multiple of what is set aside for it.
const LEAST_SHARE: u64 = 2;

/// Fixed-point one (8 fractional bits) for the ratio of an allotment to the expected steps.
const ONE: u64 = 1 << 8;

/// The least ratio: a gaze that moves makes tiles a little dearer.
const LEAST_RATIO: u64 = ONE * 9 / 8;

const MOST_RATIO: u64 = ONE << 8;

/// One part in this many of a surplus is kept for groups that take more than is set aside.
const CUSHION: u64 = 8;

/// Expected steps of a pixel of which nothing is known.
const UNKNOWN_PIXEL: u64 = 16;

pub(super) struct LiveTile {
    pub(super) part: usize,
    pub(super) job: TileJob,
    pub(super) pixels: Vec<Pixel>,
    pub(super) spent: u64,
    pub(super) expected: u64,
    /// The pixels that it kept when it was given up.
    pub(super) kept: Option<u32>,
    /// The hash of its pixels, where it was finished while hashes are asked for.
    pub(super) hash: Option<u64>,
}

impl LiveTile {
    pub(super) fn new(part: usize, tile: Tile) -> Self {
        let area = tile.width as usize * tile.height as usize;
        Self {
            part,
            job: TileJob::new(tile),
            pixels: vec![Pixel::default(); area],
            spent: 0,
            expected: area as u64 * UNKNOWN_PIXEL,
            kept: None,
            hash: None,
        }
    }

    /// Not inlined: most frames are not hashed.
    #[inline(never)]
    pub(super) fn keep_hash(&mut self) {
        self.hash = Some(tile_hash([self.pixels.as_slice()]));
    }

    /// Returns the steps still expected; for a tile that took more than expected, as many again.
    pub(super) const fn expected_rest(&self) -> u64 {
        if self.spent < self.expected {
            self.expected - self.spent
        } else {
            self.spent
        }
    }
}

pub(super) struct Group {
    pub(super) tiles: Range<usize>,
    /// The steps that the tiles may take together.
    pub(super) allotment: u64,
    pub(super) overrun: u64,
}

impl Group {
    pub(super) const fn unlimited(tile: usize) -> Self {
        Self {
            tiles: tile..tile + 1,
            allotment: u64::MAX,
            overrun: u64::MAX,
        }
    }
}

pub(super) fn unlimited<'t>(
    tiles: impl Iterator<Item = &'t Mutex<LiveTile>>,
    groups: &mut Vec<Group>,
) {
    groups.clear();
    for (at, tile) in tiles.enumerate() {
        if !lock(tile).job.is_finished() {
            groups.push(Group::unlimited(at));
        }
    }
}

pub(super) fn expected<'t>(tiles: impl Iterator<Item = &'t Mutex<LiveTile>>) -> u64 {
    let unfinished = tiles.map(lock).filter(|tile| !tile.job.is_finished());
    unfinished.map(|tile| tile.expected_rest()).sum()
}

pub(super) struct Dealer {
    /// The most steps that a group is expected to take above its allotment.
    excess: u64,
    /// The frame's budget, if hard: no group may exceed what is set aside for it.
    pub(super) hard_limit: Option<u64>,
}

impl Dealer {
    pub(super) fn new(samples: u16) -> Self {
        let excess = LEAST_EXCESS * (u64::from(samples) / FEW_SAMPLES).max(1);
        let hard_limit = None;
        Self { excess, hard_limit }
    }

    pub(super) fn expect_squares(&mut self) {
        self.excess = self.excess.max(LEAST_EXCESS * SQUARES_FACTOR);
    }

    fn aside(&self) -> u64 {
        let part = self.hard_limit.map(|steps| steps / LEAST_PART_ASIDE);
        self.excess.min(part.unwrap_or(u64::MAX))
    }

    pub(super) fn note_excess(&mut self, excess: &AtomicU64) {
        // The next may be half as dear again; one that was broken off is dearer.
        let most = excess.load(Ordering::SeqCst) * 3 / 2;
        self.excess = self.excess.max(most);
    }

    /// Deals unfinished tiles what they are expected to need, from the first on, as long as
    /// steps are left; what no tile is expected to need goes to all in proportion. A budget
    /// is only checked before each block or square, so a group may take a little more than
    /// its allotment: that much is set aside for each, and a hard budget allows no more.
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

    /// Deals to few tiles, in the smallest groups: idle threads find no other work.
    pub(super) fn deal_finely<'t>(
        &self,
        left: u64,
        tiles: impl Iterator<Item = &'t Mutex<LiveTile>> + Clone,
        groups: &mut Vec<Group>,
    ) {
        self.deal_groups(left, LEAST_SHARE * self.aside(), tiles, groups);
    }

    /// Deals to groups whose expected steps reach `full`.
    fn deal_groups<'t>(
        &self,
        mut left: u64,
        full: u64,
        tiles: impl Iterator<Item = &'t Mutex<LiveTile>> + Clone,
        groups: &mut Vec<Group>,
    ) {
        groups.clear();
        let (aside, expected) = (self.aside(), expected(tiles.clone()));
        // The part that is not set aside, in full groups.
        let to_groups = (left - left / CUSHION) / (full + aside).max(1) * full;
        let times = to_groups.saturating_mul(ONE) / expected.max(1);
        let times = times.clamp(LEAST_RATIO, MOST_RATIO);
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
                    overrun: self.hard_limit.map_or(u64::MAX, |_| aside),
                });
            }
            let Some(group) = groups.last_mut() else {
                return;
            };
            let expected = tile.expected_rest();
            let allotment = (expected.saturating_mul(times) / ONE).min(left);
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
