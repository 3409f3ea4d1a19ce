//! Trees of boxes: whether they are trees, and how deep.

use super::Record;
use crate::scene::format::{COUNT_SHIFT, INDEX, LEAF, Mesh};
use crate::scene::{STACK_ENTRIES, Scene, SceneError};
use core::ops::Range;
use heapless::Vec;

/// Returns whether `order` names each of `W` lanes once.
fn is_permutation<const W: usize>(order: u32) -> bool {
    let bits = W.trailing_zeros();
    let named = (0..W as u32).fold(0u32, |named, place| {
        named | 1 << (order >> (place * bits) & (W as u32 - 1))
    });
    named == (1 << W) - 1
}

/// Numbers of stack entries are kept in bytes.
const _: () = assert!(STACK_ENTRIES <= u8::MAX as usize);

/// What a tree may refer to.
pub(super) struct Tree<'m> {
    pub(super) nodes: Range<u32>,
    pub(super) leaves: Range<u32>,
    /// The mesh whose triangles its leaves hold, and its number; `None` for other trees.
    pub(super) mesh: Option<(&'m Mesh, Record)>,
}

impl Tree<'_> {
    /// Returns whether a leaf of this many triangles holds them and no others.
    fn check_leaf<const W: usize>(
        &self,
        scene: &Scene<'_, W>,
        leaf: u32,
        count: u32,
    ) -> Result<(), SceneError> {
        let Some((mesh, record)) = self.mesh else {
            return Ok(());
        };
        let ids = if W == 8 {
            scene.leaves.get(leaf as usize).map(|block| &block.ids[..])
        } else {
            scene.id_leaves.get(leaf as usize).map(|ids| &ids[..])
        };
        let Some(ids) = ids else {
            return Err(record.index("leaf", leaf));
        };
        let wrong = |(lane, id): (usize, &u32)| {
            let filled = lane < count as usize;
            (filled && *id >= mesh.triangle_count) || (!filled && *id != u32::MAX)
        };
        match ids.iter().enumerate().find(|&entry| wrong(entry)) {
            Some((_, &id)) => Err(record.index("triangle", id)),
            None => Ok(()),
        }
    }
}

/// Walks a tree once. Returns the most stack entries that any order needs, and its primitives.
// Not inlined: keeps its stack frame out of the callers'.
#[inline(never)]
pub(super) fn check_tree<const W: usize>(
    scene: &Scene<'_, W>,
    tree: &Tree<'_>,
    root: u32,
) -> Result<(u32, u32), SceneError> {
    if !tree.nodes.contains(&root) {
        return Err(Record(0).index("root node", root));
    }
    let too_deep = |needed| SceneError::TooDeep {
        needed,
        limit: STACK_ENTRIES as u32,
    };
    // Nodes still to visit, each with the entries that lie below it at worst: no
    // more than those that there are.
    let mut pending: Vec<u32, STACK_ENTRIES> = Vec::new();
    let mut entries: Vec<u8, STACK_ENTRIES> = Vec::new();
    let _ = pending.push(root);
    let _ = entries.push(0);
    let mut visited = 0u32;
    let mut leaves = 0;
    let mut deepest = 0;
    let mut primitives = 0u32;
    while let Some((number, below)) = pending.pop().zip(entries.pop()) {
        let below = u32::from(below);
        visited += 1;
        let node = scene.nodes.get(number as usize);
        let Some(node) = node.filter(|_| visited as usize <= tree.nodes.len()) else {
            return Err(SceneError::NotATree { node: number });
        };
        let used = |lane: usize| !node.is_empty_lane(lane);
        let children = (0..W).filter(|&lane| used(lane)).count() as u32;
        if !(0..8).all(|octant| is_permutation::<W>(node.order(octant))) {
            return Err(SceneError::NotATree { node: number });
        }
        // Traversal writes whole vectors: W entries from the top are touched.
        deepest = deepest.max(below + W as u32);
        for (lane, &child) in node.child.iter().enumerate() {
            let index = child & INDEX;
            if child & LEAF != 0 {
                let count = (child >> COUNT_SHIFT & 7) + 1;
                let fits = count as usize <= if tree.mesh.is_none() { 1 } else { W };
                // As many as there are: no ray looks into one again and again.
                leaves += 1;
                let known = tree.leaves.contains(&index) && leaves <= tree.leaves.len();
                if !known || !fits {
                    return Err(Record(number).index("leaf", index));
                }
                tree.check_leaf(scene, index, count)?;
                primitives = primitives.saturating_add(count);
            } else if used(lane) {
                if !tree.nodes.contains(&child) || child <= number {
                    return Err(SceneError::NotATree { node: number });
                }
                let needed = below + children.saturating_sub(1);
                if needed > STACK_ENTRIES as u32
                    || pending.push(child).is_err()
                    || entries.push(needed as u8).is_err()
                {
                    return Err(too_deep(needed + W as u32));
                }
            } else if child != 0 {
                return Err(SceneError::NotATree { node: number });
            }
        }
    }
    if deepest > STACK_ENTRIES as u32 {
        return Err(too_deep(deepest));
    }
    Ok((deepest, primitives))
}
