//! The walk down one tree, closest children first.
//!
//! Machines without vector registers also test every axis of all children: a ray enters most
//! children of a node, so leaving a test at the first axis does not pay.

use super::stack::{TraversalStack, Work};
use crate::numeric::map3;
use crate::scene::format::{INDEX, LEAF, Node};
use crate::shape::Slabs;
use crate::simd::Lanes;

/// Visits the leaves of a tree.
pub(super) trait Visitor<const W: usize> {
    /// Returns the farthest distance that still counts. It only shrinks.
    fn limit(&self) -> f32;

    /// Tests a leaf that the ray enters at `near`. True ends the walk.
    fn leaf<L: Lanes<W>>(&mut self, lanes: L, child: u32, near: f32, path: &mut Path<'_>) -> bool;
}

/// The memory of a walk and its limited count of steps.
pub(super) struct Path<'s> {
    pub(super) stack: &'s mut TraversalStack,
    /// The first free entry of the stack.
    pub(super) base: usize,
    /// The most stack entries in use.
    pub(super) deepest: u32,
    /// Most steps, and the steps left.
    most: u64,
    left: u64,
}

impl<'s> Path<'s> {
    #[inline(always)]
    pub(super) const fn new(stack: &'s mut TraversalStack, most: u64) -> Self {
        Self {
            stack,
            base: 0,
            deepest: 0,
            most,
            left: most,
        }
    }

    /// Takes some steps. If fewer are left, takes those and returns false.
    #[inline(always)]
    pub(super) const fn take(&mut self, steps: u64) -> bool {
        let left = self.left.checked_sub(steps);
        self.left = match left {
            Some(left) => left,
            None => 0,
        };
        left.is_some()
    }

    #[inline(always)]
    pub(super) const fn work(&self) -> Work {
        Work {
            steps: self.most.wrapping_sub(self.left),
            deepest: self.deepest,
        }
    }
}

/// Visits all leaves that the ray enters within the visitor's limit; true if the visitor ended
/// the walk. Each node of a checked tree is visited at most once.
// Longer than 80 lines: one loop, whose vectors stay in registers.
#[inline(always)]
pub(super) fn walk<const W: usize, L: Lanes<W>, V: Visitor<W>>(
    lanes: L,
    nodes: &[Node<W>],
    root: u32,
    slabs: &Slabs,
    visitor: &mut V,
    path: &mut Path<'_>,
) -> bool {
    let (rx, nx, fx) = coefficients(lanes, slabs, 0);
    let (ry, ny, fy) = coefficients(lanes, slabs, 1);
    let (rz, nz, fz) = coefficients(lanes, slabs, 2);
    let octant = slabs.octant();
    let start = lanes.splat(0.0);
    let base = path.base;
    let near_planes = map3([0, 1, 2], |axis| slabs.near_plane(axis));
    let far_planes = map3([0, 1, 2], |axis| slabs.far_plane(axis));
    let mut top = base;
    let mut current = root;
    loop {
        let Some(node) = nodes.get(current as usize).filter(|_| path.take(1)) else {
            return false;
        };
        let near_x = distance(lanes, node, near_planes[0], rx, nx);
        let near_y = distance(lanes, node, near_planes[1], ry, ny);
        let near_z = distance(lanes, node, near_planes[2], rz, nz);
        let far_x = distance(lanes, node, far_planes[0], rx, fx);
        let far_y = distance(lanes, node, far_planes[1], ry, fy);
        let far_z = distance(lanes, node, far_planes[2], rz, fz);
        // Never NaN, and only compared.
        let near = lanes.greater(lanes.greater(near_x, near_y), lanes.greater(near_z, start));
        let far = lanes.lesser(
            lanes.lesser(far_x, far_y),
            lanes.lesser(far_z, lanes.splat(visitor.limit())),
        );
        let hit = lanes.le(near, far);
        let hits = lanes.bits(hit);
        // A single child that is a node needs no order either.
        if hits.is_power_of_two() {
            let child = node.child[hits.trailing_zeros() as usize & (W - 1)];
            if child & LEAF == 0 {
                current = child;
                continue;
            }
        }
        // The walk goes on with the nearest child without pushing it.
        let mut nearest = None;
        // Without children hit there is nothing to sort.
        if hits != 0 {
            // The stack of a checked scene is never full.
            let free = path
                .stack
                .distances
                .get_mut(top..)
                .and_then(<[f32]>::first_chunk_mut::<W>)
                .zip(
                    path.stack
                        .children
                        .get_mut(top..)
                        .and_then(<[u32]>::first_chunk_mut::<W>),
                );
            let Some((distances, children)) = free else {
                return false;
            };
            let (count, last) = lanes.compress(
                hit,
                node.order(octant),
                near,
                &node.child,
                distances,
                children,
            );
            // At least one: an order names each lane.
            top += count - 1;
            nearest = Some(node.child[last & (W - 1)]);
            path.deepest = path.deepest.max(top as u32);
        }
        current = loop {
            let child = match nearest.take() {
                Some(child) => child,
                None if top == base => return false,
                None => {
                    top -= 1;
                    let (Some(&near), Some(&child)) =
                        (path.stack.distances.get(top), path.stack.children.get(top))
                    else {
                        return false;
                    };
                    if near > visitor.limit() {
                        continue;
                    }
                    child
                }
            };
            if child & LEAF == 0 {
                break child;
            }
            let Some(&near) = path.stack.distances.get(top) else {
                return false;
            };
            path.base = top;
            let over = visitor.leaf(lanes, child, near, path);
            path.base = base;
            if over {
                return true;
            }
        };
    }
}

/// Returns where a ray crosses one of the six planes of each child.
#[inline(always)]
fn distance<const W: usize, L: Lanes<W>>(
    lanes: L,
    node: &Node<W>,
    plane: usize,
    reciprocal: L::F,
    offset: L::F,
) -> L::F {
    // At most 5: the remainder shows that to the compiler without a branch.
    let planes = lanes.load(&node.planes[plane.min(5)]);
    lanes.sub(lanes.mul(planes, reciprocal), offset)
}

/// Returns a ray's numbers for one axis, in every lane. Not a closure: the compiler might not
/// inline one.
#[inline(always)]
fn coefficients<const W: usize, L: Lanes<W>>(
    lanes: L,
    slabs: &Slabs,
    axis: usize,
) -> (L::F, L::F, L::F) {
    let (reciprocal, near, far) = slabs.coefficients(axis);
    (lanes.splat(reciprocal), lanes.splat(near), lanes.splat(far))
}

/// Returns the index of the record that a leaf reference names.
#[inline(always)]
pub(super) const fn leaf_index(child: u32) -> u32 {
    child & INDEX
}
