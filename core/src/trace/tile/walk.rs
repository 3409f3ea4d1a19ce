use super::slabs::{Span, TileSlabs};
use super::{EIGHT, TileHits};
use crate::numeric::{map3, max};
use crate::scene::format::{LEAF, Node};
use crate::simd::Lanes;
use crate::trace::walk::Path;

/// Visits the leaves of a tree that some groups of a tile enter.
pub(super) trait TileVisitor {
    /// Returns the hits, which bound how far each group searches.
    fn hits(&mut self) -> &mut TileHits;
    /// Prefetches a leaf that will be visited.
    fn expect<L: Lanes<EIGHT>>(&self, l: L, child: u32);
    fn leaf<L: Lanes<EIGHT>>(&mut self, l: L, child: u32, groups: u8, path: &mut Path<'_>);
}

/// Returns a node's planes in `N` lanes; lanes past its width are empty.
#[inline(always)]
fn widened<const W: usize, const N: usize>(planes: &[[f32; W]; 6], plane: usize) -> [f32; N] {
    let empty = if plane & 1 == 0 {
        f32::INFINITY
    } else {
        f32::NEG_INFINITY
    };
    let mut lanes = [empty; N];
    for (lane, &value) in lanes.iter_mut().zip(&planes[plane % 6]) {
        *lane = value;
    }
    lanes
}

/// The interval that the rays of a tile span, ready for a node's children.
pub(super) struct Interval<F> {
    origin: [F; 3],
    reciprocal: [(F, F); 3],
    slack: [F; 3],
}

impl<F: Copy> Interval<F> {
    #[inline(always)]
    pub(super) fn new<const N: usize, L: Lanes<N, F = F>>(l: L, span: &Span) -> Self {
        Self {
            origin: map3(span.origin, |o| l.splat(o)),
            reciprocal: map3(span.interval, |(low, high, _)| {
                (l.splat(low), l.splat(high))
            }),
            slack: map3(span.interval, |(_, _, slack)| l.splat(slack)),
        }
    }

    /// Returns the children that a ray may enter before `limit`, and a lower bound of the distances.
    #[inline(always)]
    pub(super) fn children<const W: usize, const N: usize, L: Lanes<N, F = F>>(
        &self,
        l: L,
        node: &Node<W>,
        span: &Span,
        limit: f32,
    ) -> (u32, [f32; N]) {
        let (mut near, mut far) = (l.splat(0.0), l.splat(limit));
        for axis in 0..3 {
            let (low, high) = self.reciprocal[axis];
            let negative = span.negative[axis];
            let n = l.load(&widened(&node.planes, 2 * axis + negative));
            let f = l.load(&widened(&node.planes, 2 * axis + 1 - negative));
            let (n, f) = (l.sub(n, self.origin[axis]), l.sub(f, self.origin[axis]));
            // Only compared, and never NaN: reciprocals are not 0, slack is finite.
            let n = l.lesser(l.mul(n, low), l.mul(n, high));
            let f = l.greater(l.mul(f, low), l.mul(f, high));
            near = l.greater(near, l.sub(n, self.slack[axis]));
            far = l.lesser(far, l.add(f, self.slack[axis]));
        }
        (l.bits(l.le(near, far)), l.store(near))
    }
}

/// Returns the groups among `active` with a ray that enters the child in `lane`.
#[inline(always)]
fn groups_that_enter<const W: usize, L: Lanes<EIGHT>>(
    l: L,
    node: &Node<W>,
    lane: usize,
    slabs: &TileSlabs,
    hits: &TileHits,
    active: u8,
) -> u8 {
    let planes = |far: usize| {
        map3([0, 1, 2], |axis: usize| {
            node.planes[(2 * axis + (slabs.span.negative[axis] ^ far)) % 6][lane]
        })
    };
    let (near, far) = (planes(0), planes(1));
    let mut entered = 0;
    for group in 0..EIGHT {
        if active >> group & 1 != 0 {
            let (near, far) = slabs.of_group(l, group, near, far);
            let near = l.max(near, l.splat(0.0));
            let far = l.min(far, l.load(&hits.t[group]));
            entered |= u8::from(l.bits(l.le(near, far)) != 0) << group;
        }
    }
    entered
}

/// Returns the groups among `groups` whose farthest hit is at `near` or behind.
#[inline(always)]
fn groups_within(hits: &TileHits, groups: u8, near: f32) -> u8 {
    let mut within = 0;
    for group in 0..EIGHT {
        let reaches = groups >> group & 1 != 0 && near <= hits.limit[group];
        within |= u8::from(reaches) << group;
    }
    within
}

/// Visits all leaves that any ray of `groups` enters, each node at most once.
// Longer than 80 lines: one loop, whose vectors stay in registers.
#[inline(always)]
pub(super) fn walk_tile<const W: usize, L: Lanes<EIGHT>, V: TileVisitor>(
    l: L,
    nodes: &[Node<W>],
    root: u32,
    slabs: &TileSlabs,
    groups: u8,
    visitor: &mut V,
    path: &mut Path<'_>,
) {
    let interval = Interval::new(l, &slabs.span);
    let octant = slabs.span.octant();
    let lane_bits = W.trailing_zeros();
    let base = path.base;
    let mut top = base;
    let mut current = root;
    let mut active = groups;
    loop {
        let Some(node) = nodes.get(current as usize).filter(|_| path.take(1)) else {
            return;
        };
        let hits = visitor.hits();
        let mut limit = 0.0;
        for group in 0..EIGHT {
            if active >> group & 1 != 0 {
                limit = max(limit, hits.limit[group]);
            }
        }
        let (candidates, near) = interval.children(l, node, &slabs.span, limit);
        let mut order = node.order(octant);
        // The list is usually empty.
        let places = if candidates == 0 { 0 } else { W };
        for _ in 0..places {
            let lane = order as usize & (W - 1);
            order >>= lane_bits;
            if candidates >> lane & 1 == 0 {
                continue;
            }
            let entered = groups_that_enter(l, node, lane, slabs, visitor.hits(), active);
            if entered == 0 {
                continue;
            }
            let (Some(distance), Some(child), Some(groups)) = (
                path.stack.distances.get_mut(top),
                path.stack.children.get_mut(top),
                path.stack.groups.get_mut(top),
            ) else {
                return;
            };
            *distance = near[lane];
            *child = node.child[lane];
            *groups = entered;
            // The cache does not keep the meshes of all rungs from tile to tile.
            if *child & LEAF != 0 {
                visitor.expect(l, *child);
            } else if let Some(node) = nodes.get(*child as usize) {
                l.prefetch(node);
            }
            top += 1;
        }
        path.deepest = path.deepest.max(top as u32);
        current = loop {
            if top == base {
                return;
            }
            top -= 1;
            let (Some(&near), Some(&child), Some(&entered)) = (
                path.stack.distances.get(top),
                path.stack.children.get(top),
                path.stack.groups.get(top),
            ) else {
                return;
            };
            // Hits found since the push may be nearer.
            active = groups_within(visitor.hits(), entered, near);
            if active == 0 {
                continue;
            }
            if child & LEAF == 0 {
                break child;
            }
            path.base = top;
            visitor.leaf(l, child, active, path);
            path.base = base;
        };
    }
}
