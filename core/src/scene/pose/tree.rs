//! Trees fitted to boxes that have changed.

use crate::scene::format::{LEAF, Node};

/// An axis-aligned box: least and greatest corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    /// Returns the box around this one and a point.
    pub(super) fn with(self, point: [f32; 3]) -> Self {
        self.union(Self {
            low: point,
            high: point,
        })
    }

    pub(super) fn union(mut self, other: Self) -> Self {
        for (low, other) in self.low.iter_mut().zip(other.low) {
            *low = low.min(other);
        }
        for (high, other) in self.high.iter_mut().zip(other.high) {
            *high = high.max(other);
        }
        self
    }

    /// Returns the largest magnitude of a coordinate.
    pub(super) fn extent(self) -> f32 {
        let corners = [self.low, self.high];
        let coordinates = corners.iter().flatten();
        coordinates.fold(0.0, |extent, c| extent.max(c.abs()))
    }

    pub(super) fn half_area(self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| self.high[axis % 3] - self.low[axis % 3]);
        x * y + y * z + z * x
    }
}

impl<const W: usize> Node<W> {
    /// A node without children.
    pub const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; W],
            [f32::NEG_INFINITY; W],
            [f32::INFINITY; W],
            [f32::NEG_INFINITY; W],
            [f32::INFINITY; W],
            [f32::NEG_INFINITY; W],
        ],
        child: [0; W],
        order: [0; W],
    };

    /// Sets the box of a lane, which is taken modulo the width.
    pub fn set_bounds(&mut self, lane: usize, low: [f32; 3], high: [f32; 3]) {
        for (axis, (low, high)) in low.into_iter().zip(high).enumerate() {
            self.planes[2 * axis % 6][lane % W] = low;
            self.planes[(2 * axis + 1) % 6][lane % W] = high;
        }
    }

    /// Returns the box around all children.
    pub(super) fn bounds(&self) -> Bounds {
        let least = |plane: usize| self.planes[plane % 6].iter().copied();
        let low = [0, 2, 4].map(|plane| least(plane).fold(f32::INFINITY, f32::min));
        let high = [1, 3, 5].map(|plane| least(plane).fold(f32::NEG_INFINITY, f32::max));
        Bounds { low, high }
    }

    /// Sets [`order`](Self::order) by the boxes: for rays of each octant the lanes whose centres lie
    /// farthest along the octant's diagonal first, and lanes without a child before them.
    pub fn set_order(&mut self) {
        let bits = W.trailing_zeros();
        let mut centres = [[f64::NAN; 3]; W];
        for (lane, centre) in centres.iter_mut().enumerate() {
            if !self.is_empty_lane(lane) {
                *centre = [0, 1, 2].map(|axis: usize| {
                    let [low, high] = [2 * axis, 2 * axis + 1].map(|plane| self.planes[plane % 6]);
                    f64::from(low[lane % W]) + f64::from(high[lane % W])
                });
            }
        }
        self.order = [0; W];
        // An octant, and the opposite one.
        for octant in 0..4 {
            let keys = centres.map(|[x, y, z]| {
                let x = if octant & 1 == 0 { x } else { -x };
                let y = if octant & 2 == 0 { y } else { -y };
                x + y + z
            });
            let mut ranks = [[0_u32; W]; 2];
            for (lane, own) in keys.iter().enumerate() {
                for (before, other) in keys.iter().enumerate().take(lane) {
                    // An empty lane's key is NaN, which compares as false.
                    let is_empty = other.is_nan();
                    let farther = [is_empty || other >= own, is_empty || other <= own];
                    for (ranks, farther) in ranks.iter_mut().zip(farther) {
                        ranks[if farther { lane } else { before } % W] += 1;
                    }
                }
            }
            for (octant, ranks) in [octant, 7 - octant].into_iter().zip(ranks) {
                let mut word = 0;
                for (lane, rank) in (0..).zip(ranks) {
                    word |= lane << (rank * bits);
                }
                if W == 8 {
                    self.order[octant % W] = word;
                } else {
                    self.order[octant / 2 % W] |= word << (octant % 2 * 16);
                }
            }
        }
    }
}

/// Fits a tree to the boxes of its leaves, from the last node to the first. Its nodes are numbered
/// from `first` on. Returns the sum of its boxes' half areas.
pub(super) fn refit<const W: usize>(
    nodes: &mut [Node<W>],
    first: u32,
    mut of_leaf: impl FnMut(u32) -> Bounds,
) -> f32 {
    let mut areas = 0.0;
    for number in (0..nodes.len()).rev() {
        let Some(mut node) = nodes.get(number).copied() else {
            break;
        };
        for lane in 0..W {
            if node.is_empty_lane(lane) {
                continue;
            }
            let child = node.child[lane % W];
            let bounds = if child & LEAF != 0 {
                of_leaf(child)
            } else {
                let below = child
                    .checked_sub(first)
                    .and_then(|at| nodes.get(at as usize));
                below.map_or(Bounds::EMPTY, Node::bounds)
            };
            node.set_bounds(lane, bounds.low, bounds.high);
            areas += bounds.half_area();
        }
        node.set_order();
        if let Some(place) = nodes.get_mut(number) {
            *place = node;
        }
    }
    areas
}
