//! Blocks of 64 rays from one eye, through the scene together.
//!
//! One interval test a node discards the children that no ray of the block can
//! enter; those left are tested by eight rays at a time. Every ray's own test
//! is the one that it would take alone, so its hit is the same, bit for bit;
//! only culling is coarser, and conservatively so.
//!
//! Rays go together only where their directions have the same signs and, in
//! the frame of a mesh, the same main axis. Instances in whose frame they do
//! not, and shapes that are not meshes, are put on a list and traced ray by
//! ray afterwards, which changes nothing: the nearest hit does not depend on
//! the order of visit.

mod search;
mod slabs;
mod walk;

use super::hit::{Hit, MeshHit};
use crate::numeric::max;
use crate::shape::Ray;
use glam::Vec3;
use heapless::Vec;
pub(super) use search::{ALL_INSTANCES, TileInMeshSearch, TileSearch};

/// Groups of a tile, and rays of a group.
const EIGHT: usize = 8;

/// One number for each ray: by group, then lane.
type PerRay = [[f32; EIGHT]; EIGHT];

/// 8×8 rays from one point, by column and row.
#[derive(Debug, Clone)]
pub struct TileRays {
    origin: Vec3,
    direction: [PerRay; 3],
}

/// Group and lane of a place in the tile: a group is four columns wide and
/// two rows high, so that its rays are close together.
#[inline(always)]
const fn place(column: usize, row: usize) -> (usize, usize) {
    ((row & 6) | (column >> 2 & 1), (row & 1) << 2 | (column & 3))
}

impl TileRays {
    /// Rays from `origin` along `direction(column, row)`, each from 0 to 7.
    #[inline(always)]
    pub fn new(origin: Vec3, mut direction: impl FnMut(usize, usize) -> Vec3) -> Self {
        let mut rays = Self {
            origin,
            direction: [[[0.0; EIGHT]; EIGHT]; 3],
        };
        for row in 0..EIGHT {
            for column in 0..EIGHT {
                let (group, lane) = place(column, row);
                let components = direction(column, row).to_array();
                for (rows, component) in rays.direction.iter_mut().zip(components) {
                    rows[group][lane] = component;
                }
            }
        }
        rays
    }

    /// The ray at a place, or `None` where it cannot be traced.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Ray> {
        let (group, lane) = place(column, row);
        self.ray(group, lane)
    }

    #[inline(always)]
    pub(super) fn ray(&self, group: usize, lane: usize) -> Option<Ray> {
        let [x, y, z] = &self.direction;
        let (g, l) = (group % EIGHT, lane % EIGHT);
        Ray::new(self.origin, Vec3::new(x[g][l], y[g][l], z[g][l]))
    }
}

/// Instances to be traced ray by ray: number and the groups that reach it.
type Deferred = Vec<(u32, u8), 16>;

/// What the rays of a tile have found.
#[derive(Debug, Clone)]
pub struct TileHits {
    t: PerRay,
    triangle: [[u32; EIGHT]; EIGHT],
    leaf: [[u32; EIGHT]; EIGHT],
    lane: [[u8; EIGHT]; EIGHT],
    instance: [[u32; EIGHT]; EIGHT],
    /// The farthest hit of each group.
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

    /// The nearest hit of the ray at a place, columns and rows from 0 to 7.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Hit> {
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

    /// Takes a hit where it is nearer by (t, instance, triangle).
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
