use super::slabs::Span;
use super::walk::Interval;
use crate::scene::Scene;
use crate::scene::format::{LEAF, Node};
use crate::simd::{Kernel, Lanes};
use crate::trace::walk::leaf_index;
use glam::Vec3;

/// Whether rays from one point with directions between four corners may meet anything, by the
/// boxes of the tree over instances and of the instances' covers.
pub(in crate::trace) struct MayHit<'r, 'a, const W: usize> {
    pub(in crate::trace) scene: &'r Scene<'a, W>,
    pub(in crate::trace) origin: Vec3,
    pub(in crate::trace) corners: &'r [Vec3; 4],
    /// Most nodes to visit; the answer is then that rays may hit.
    pub(in crate::trace) most: u64,
}

/// Most nodes after one another.
const DEPTH: usize = 6;

/// Most nodes to visit.
pub(in crate::trace) const MOST_NODES: u64 = 16;

impl<const W: usize> Kernel<W> for MayHit<'_, '_, W> {
    /// The answer, and the number of nodes visited.
    type Output = (bool, u64);

    #[inline(always)]
    fn run<L: Lanes<W>>(self, l: L) -> (bool, u64) {
        let Some(span) = Span::between(self.origin, self.corners, self.scene.extent) else {
            return (true, 0);
        };
        let interval = Interval::new(l, &span);
        // Nodes from the root down, each with its unvisited children.
        let mut path = [(0, 0); DEPTH];
        let (mut depth, mut steps) = (0, 0);
        let mut next = self.scene.header.root;
        loop {
            let (Some(node), Some(place)) = (self.node(next), path.get_mut(depth)) else {
                return (true, steps);
            };
            if steps == self.most {
                return (true, steps);
            }
            steps += 1;
            *place = (next, interval.children(l, node, &span, f32::INFINITY).0);
            depth += 1;
            let child = loop {
                let Some((number, lanes)) = depth.checked_sub(1).and_then(|d| path.get_mut(d))
                else {
                    return (false, steps);
                };
                if *lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize & (W - 1);
                    *lanes &= *lanes - 1;
                    break self.child(*number, lane);
                }
                depth -= 1;
            };
            match child {
                Some(child) => next = child,
                None => return (true, steps),
            }
        }
    }
}

impl<const W: usize> MayHit<'_, '_, W> {
    /// Returns a node of the tree over instances, or of a cover.
    #[inline(always)]
    fn node(&self, number: u32) -> Option<&Node<W>> {
        let top = self.scene.top.get(number as usize);
        top.or_else(|| self.scene.nodes.get(number as usize))
    }

    /// Returns the node below a lane of another, or an instance's cover, if there is one.
    #[inline(always)]
    fn child(&self, node: u32, lane: usize) -> Option<u32> {
        let child = *self.node(node)?.child.get(lane)?;
        if child & LEAF == 0 {
            return Some(child);
        }
        if node as usize >= self.scene.top.len() {
            return None;
        }
        let instance = self.scene.instances.get(leaf_index(child) as usize)?;
        (instance.cover_nodes > 0).then_some(instance.cover)
    }
}
