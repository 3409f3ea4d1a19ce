//! Blocks of 64 rays from one eye, traced together.
//!
//! One interval test for each node discards the children that no ray of the block
//! can enter; eight rays at a time test the others. A ray takes the same tests as
//! when traced alone, so its hit is the same, bit for bit; only culling is
//! coarser, and never discards a child that a ray enters.
//!
//! Rays go together only if their directions have the same signs and, in the frame of a mesh,
//! the same main axis. Other instances, and shapes that are not meshes, go on a list and
//! are traced ray by ray afterwards; the nearest hit does not depend on the order.

mod may_hit;
mod search;
mod slabs;
mod walk;

use super::hit::{Hit, MeshHit};
use crate::numeric::{map3, max};
use crate::shape::Ray;
use glam::Vec3;
use heapless::Vec;
pub(super) use may_hit::{MOST_NODES, MayHit};
pub(super) use search::{ALL_INSTANCES, TileInMeshSearch, TileSearch};

/// Number of groups in a tile, and of rays in a group.
const EIGHT: usize = 8;

/// A number for each ray, by group, then lane.
type PerRay = [[f32; EIGHT]; EIGHT];

/// Returns the three numbers of one ray.
#[inline(always)]
fn of_ray([x, y, z]: &[PerRay; 3], group: usize, lane: usize) -> [f32; 3] {
    map3([x, y, z], |numbers| numbers[group % EIGHT][lane % EIGHT])
}

/// Returns the three numbers of each ray of a group.
#[inline(always)]
fn of_group([x, y, z]: &[PerRay; 3], group: usize) -> [&[f32; EIGHT]; 3] {
    map3([x, y, z], |numbers| &numbers[group % EIGHT])
}

/// 8×8 rays from one point, by column and row.
#[derive(Debug, Clone)]
pub struct TileRays {
    origin: Vec3,
    direction: [PerRay; 3],
    rungs: Rungs,
}

/// The rungs of the ladders of polygon levels that rays see.
#[derive(Debug, Clone)]
enum Rungs {
    /// One rung for all rays.
    Equal(u8),
    /// The least and the greatest rung, then each ray's by group and lane, or [`NOT_TRACED`].
    Own(u8, u8, [[u8; EIGHT]; EIGHT]),
}

/// Rung of a ray that is not traced.
pub(crate) const NOT_TRACED: u8 = u8::MAX;

/// Returns the group and lane of a place: a group is four columns wide and two rows high.
#[inline(always)]
const fn place(column: usize, row: usize) -> (usize, usize) {
    ((row & 6) | (column >> 2 & 1), (row & 1) << 2 | (column & 3))
}

impl TileRays {
    /// Number of groups, each of eight neighbouring rays.
    pub(crate) const GROUPS: usize = EIGHT;

    /// Returns the columns and rows of a group's rays.
    pub(crate) fn places_of_group(group: usize) -> impl Iterator<Item = (usize, usize)> {
        (0..EIGHT).map(move |lane| ((group & 1) << 2 | (lane & 3), (group & 6) | lane >> 2))
    }

    /// Returns rays from `origin` along `direction(column, row)`, each from 0 to 7,
    /// through the finest meshes.
    #[inline(always)]
    pub fn new(origin: Vec3, mut direction: impl FnMut(usize, usize) -> Vec3) -> Self {
        let mut rays = Self::without_directions(origin);
        for row in 0..EIGHT {
            let mut components = [[0.0; EIGHT]; 3];
            for column in 0..EIGHT {
                let [x, y, z] = direction(column, row).to_array();
                components[0][column] = x;
                components[1][column] = y;
                components[2][column] = z;
            }
            rays.set_row(row, &components);
        }
        rays
    }

    /// Returns rays from `origin` whose rows are still to be set.
    #[inline(always)]
    pub(crate) const fn without_directions(origin: Vec3) -> Self {
        Self {
            origin,
            direction: [[[0.0; EIGHT]; EIGHT]; 3],
            rungs: Rungs::Equal(0),
        }
    }

    /// Sets the components of the eight directions of a row, 0 to 7.
    #[inline(always)]
    pub(crate) fn set_row(&mut self, row: usize, components: &[[f32; EIGHT]; 3]) {
        for axis in 0..3 {
            // Four columns are next to each other: see `place`.
            for half in 0..2 {
                let (group, lane) = place(4 * half, row);
                for column in 0..4 {
                    self.direction[axis][group][lane + column] =
                        components[axis][4 * half + column];
                }
            }
        }
    }

    /// Returns the same rays through the meshes of a rung.
    #[must_use]
    pub const fn on_rung(mut self, rung: u8) -> Self {
        self.rungs = Rungs::Equal(rung);
        self
    }

    /// Returns the same rays, each on its own rung, by row, then column, or `NOT_TRACED`.
    pub(crate) fn on_rungs(mut self, rungs: &[[u8; EIGHT]; EIGHT]) -> Self {
        let mut own = [[NOT_TRACED; EIGHT]; EIGHT];
        for (row, rungs) in rungs.iter().enumerate() {
            // As in `set_row`.
            for half in 0..2 {
                let (group, lane) = place(4 * half, row);
                for column in 0..4 {
                    own[group][lane + column] = rungs[4 * half + column];
                }
            }
        }
        let (mut least, mut most, mut all) = (NOT_TRACED, 0, true);
        for rung in own.into_iter().flatten() {
            // `NOT_TRACED` is above all rungs.
            least = least.min(rung);
            most = most.max(if rung == NOT_TRACED { 0 } else { rung });
            all &= rung != NOT_TRACED;
        }
        self.rungs = if all && least == most {
            Rungs::Equal(least)
        } else {
            Rungs::Own(least, most, own)
        };
        self
    }

    /// Returns the rung that a ray sees; `None` for a ray that is not traced.
    #[inline(always)]
    pub(super) fn rung(&self, group: usize, lane: usize) -> Option<u8> {
        match &self.rungs {
            Rungs::Equal(rung) => Some(*rung),
            Rungs::Own(_, _, own) => {
                Some(own[group % EIGHT][lane % EIGHT]).filter(|&rung| rung != NOT_TRACED)
            }
        }
    }

    /// Returns the groups with a ray for which `test` holds.
    #[inline(always)]
    fn groups_with(own: &[[u8; EIGHT]; EIGHT], test: impl Fn(u8) -> bool) -> u8 {
        let mut groups = 0;
        for group in 0..EIGHT {
            let mut any = false;
            for lane in 0..EIGHT {
                any |= test(own[group][lane]);
            }
            groups |= u8::from(any) << group;
        }
        groups
    }

    /// Returns the groups with a ray that is traced.
    #[inline(always)]
    fn groups(&self) -> u8 {
        match &self.rungs {
            Rungs::Equal(_) => u8::MAX,
            Rungs::Own(_, _, own) => Self::groups_with(own, |rung| rung != NOT_TRACED),
        }
    }

    /// Returns the ray at a place, columns and rows from 0 to 7; `None` if it cannot be
    /// traced.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Ray> {
        if column >= EIGHT || row >= EIGHT {
            return None;
        }
        let (group, lane) = place(column, row);
        self.ray(group, lane)
    }

    #[inline(always)]
    pub(super) fn ray(&self, group: usize, lane: usize) -> Option<Ray> {
        let direction = Vec3::from_array(of_ray(&self.direction, group, lane));
        Ray::new(self.origin, direction)
    }
}

/// Instances to trace ray by ray: number, and a bit for each group that reaches it.
type Deferred = Vec<(u32, u8), 16>;

/// The hits of the rays of a tile.
#[derive(Debug, Clone)]
pub struct TileHits {
    t: PerRay,
    triangle: [[u32; EIGHT]; EIGHT],
    leaf: [[u32; EIGHT]; EIGHT],
    lane: [[u8; EIGHT]; EIGHT],
    instance: [[u32; EIGHT]; EIGHT],
    /// Distance of the farthest hit of each group.
    limit: [f32; EIGHT],
    pub(super) deferred: Deferred,
}

impl TileHits {
    pub(super) const NONE: Self = Self {
        t: [[f32::INFINITY; EIGHT]; EIGHT],
        triangle: [[u32::MAX; EIGHT]; EIGHT],
        leaf: [[u32::MAX; EIGHT]; EIGHT],
        lane: [[0; EIGHT]; EIGHT],
        instance: [[u32::MAX; EIGHT]; EIGHT],
        limit: [f32::INFINITY; EIGHT],
        deferred: Vec::new(),
    };

    /// Returns the hits before any search; a ray that is not traced has a hit that none replaces.
    pub(super) fn none_of(rays: &TileRays) -> Self {
        let mut hits = Self::NONE;
        if let Rungs::Own(_, _, own) = &rays.rungs {
            let groups = TileRays::groups_with(own, |rung| rung == NOT_TRACED);
            hits.exclude(groups, |group, lane| own[group][lane] == NOT_TRACED);
        }
        hits
    }

    /// Excludes those rays of some groups from the search for which `rays(group, lane)` holds.
    #[inline(always)]
    fn exclude(&mut self, groups: u8, rays: impl Fn(usize, usize) -> bool) {
        self.restore(&[[-1.0; EIGHT]; EIGHT], groups, rays);
    }

    /// Includes these rays again, with their hits before the exclusion.
    #[inline(always)]
    fn restore(&mut self, t: &PerRay, groups: u8, rays: impl Fn(usize, usize) -> bool) {
        for group in 0..EIGHT {
            if groups >> group & 1 == 0 {
                continue;
            }
            for lane in 0..EIGHT {
                if rays(group, lane) {
                    self.t[group][lane] = t[group][lane];
                }
            }
            self.update_limit(group);
        }
    }

    /// Returns the nearest hit of the ray at a place, columns and rows from 0 to 7.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Hit> {
        if column >= EIGHT || row >= EIGHT {
            return None;
        }
        let (group, lane) = place(column, row);
        let hit = self.get(group, lane);
        (hit.instance != u32::MAX).then_some(hit)
    }

    #[inline(always)]
    pub(super) fn get(&self, group: usize, lane: usize) -> Hit {
        let (g, l) = (group % EIGHT, lane % EIGHT);
        Hit {
            instance: self.instance[g][l],
            on: MeshHit {
                t: self.t[g][l],
                triangle: self.triangle[g][l],
                leaf: self.leaf[g][l],
                lane: u32::from(self.lane[g][l]),
            },
        }
    }

    /// Keeps a hit if it is nearer, by (t, instance, triangle).
    #[inline(always)]
    fn take_nearer(&mut self, group: usize, lane: usize, hit: Hit) {
        let (g, l) = (group % EIGHT, lane % EIGHT);
        let t = self.t[g][l];
        if hit.on.t < t
            || (hit.on.t == t
                && (hit.instance, hit.on.triangle) < (self.instance[g][l], self.triangle[g][l]))
        {
            self.t[g][l] = hit.on.t;
            self.triangle[g][l] = hit.on.triangle;
            self.leaf[g][l] = hit.on.leaf;
            self.lane[g][l] = hit.on.lane as u8;
            self.instance[g][l] = hit.instance;
        }
    }

    pub(super) fn set(&mut self, group: usize, lane: usize, hit: Hit) {
        self.t[group % EIGHT][lane % EIGHT] = f32::INFINITY;
        self.instance[group % EIGHT][lane % EIGHT] = u32::MAX;
        self.triangle[group % EIGHT][lane % EIGHT] = u32::MAX;
        self.take_nearer(group, lane, hit);
    }

    #[inline(always)]
    fn update_limit(&mut self, group: usize) {
        let g = group % EIGHT;
        self.limit[g] = self.t[g].into_iter().fold(0.0, max);
    }
}
