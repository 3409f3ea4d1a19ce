//! Wide trees over boxes: built binary by `obvhs`, then collapsed.

use crate::scene::mesh::TriangleMesh;
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use shisen_core::scene::STACK_ENTRIES;
use shisen_core::scene::format::{COUNT_SHIFT, INDEX, LEAF, Node};
use std::time::Duration;

/// An axis-aligned box: least and greatest corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    /// Returns whether two boxes have a point in common.
    pub(super) fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// Returns the box of a mesh's triangle.
    pub(super) fn of_triangle(mesh: &TriangleMesh, number: usize) -> Self {
        Self::of_points(mesh.triangles[number].map(|c| mesh.positions[c as usize]))
    }

    /// Returns the box of a triangle's corners.
    pub(super) fn of_points(corners: [[f32; 3]; 3]) -> Self {
        corners.into_iter().fold(Self::EMPTY, |bounds, corner| {
            bounds.union(Self {
                low: corner,
                high: corner,
            })
        })
    }

    /// Returns the box of some points and `slack` around them, rounded outwards.
    pub(super) fn around(points: impl Iterator<Item = DVec3>, slack: f64) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            (low, high) = (low.min(point), high.max(point));
        }
        Self {
            low: (low - slack).to_array().map(|c| (c as f32).next_down()),
            high: (high + slack).to_array().map(|c| (c as f32).next_up()),
        }
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self {
            low: std::array::from_fn(|a| self.low[a].min(other.low[a])),
            high: std::array::from_fn(|a| self.high[a].max(other.high[a])),
        }
    }

    fn half_area(self) -> f64 {
        let [x, y, z] = std::array::from_fn(|a| f64::from(self.high[a]) - f64::from(self.low[a]));
        x * y + y * z + z * x
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.low.into(), self.high.into())
    }
}

/// A tree with up to `W` children a node and up to `leaf_size` primitives a leaf.
#[derive(Debug, Clone)]
pub(super) struct WideTree<const W: usize> {
    /// Parents before children; the root is the first. Indices are this tree's own, from 0.
    pub(super) nodes: Vec<Node<W>>,
    pub(super) leaves: Leaves,
    /// Stack entries that traversal may need.
    pub(super) stack_entries: usize,
}

/// The primitives of each leaf, ascending.
#[derive(Debug, Clone, Default)]
pub(super) struct Leaves {
    primitives: Vec<u32>,
    /// Where each leaf ends.
    ends: Vec<u32>,
}

impl Leaves {
    pub(super) const fn len(&self) -> usize {
        self.ends.len()
    }

    pub(super) fn get(&self, leaf: usize) -> &[u32] {
        let start = leaf.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.primitives[start as usize..self.ends[leaf] as usize]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|leaf| self.get(leaf))
    }

    /// Gives each primitive the number that `of` has for it.
    pub(super) fn rename(&mut self, of: &[u32]) {
        for primitive in &mut self.primitives {
            *primitive = of[*primitive as usize];
        }
    }

    fn push(&mut self, mut primitives: Vec<u32>) {
        primitives.sort_unstable();
        self.primitives.append(&mut primitives);
        self.ends.push(self.primitives.len() as u32);
    }
}

impl<const W: usize> WideTree<W> {
    pub(super) fn primitives(&self, child: u32) -> impl Iterator<Item = u32> {
        let mut pending = vec![child];
        let mut found = Vec::new();
        while let Some(child) = pending.pop() {
            if child & LEAF != 0 {
                found.extend_from_slice(self.leaves.get((child & INDEX) as usize));
            } else {
                let node = &self.nodes[child as usize];
                let used = (0..W).filter(|&lane| !node.is_empty_lane(lane));
                pending.extend(used.map(|lane| node.child[lane]));
            }
        }
        found.into_iter()
    }
}

/// Most primitives that get the best tree. Beyond them its building takes longer than its rays save.
const THOROUGH: usize = 1 << 17;

/// Builds over the boxes of primitives, of which there is at least one.
pub(super) fn build<const W: usize>(boxes: &[Bounds], leaf_size: usize) -> WideTree<W> {
    let effort = if boxes.len() <= THOROUGH {
        BvhBuildParams::very_slow_build()
    } else {
        BvhBuildParams::fast_build()
    };
    build_with(boxes, leaf_size, effort)
}

/// Builds the same way, with less effort.
pub(super) fn build_with<const W: usize>(
    boxes: &[Bounds],
    leaf_size: usize,
    effort: BvhBuildParams,
) -> WideTree<W> {
    let parameters = BvhBuildParams {
        pre_split: false,
        max_prims_per_leaf: 1,
        ..effort
    };
    let mut build_time = Duration::ZERO;
    let bvh = build_bvh2(boxes, parameters, &mut build_time);
    let binary = Binary::from_bvh2(&bvh, boxes);
    drop(bvh);
    let tree = collapse(&binary, leaf_size);
    if tree.stack_entries <= STACK_ENTRIES / 2 {
        return tree;
    }
    // Nested boxes can make a tree that is a list. Halving the same sequence
    // of primitives is never deeper than its logarithm.
    collapse(&Binary::balanced(&binary.primitives(0), boxes), leaf_size)
}

/// A tree of nodes with two children. Of two children the second and all below it come first, right
/// after their parent.
struct Binary {
    nodes: Vec<BinaryNode>,
}

struct BinaryNode {
    bounds: Bounds,
    /// Children, or a leaf's primitive twice.
    below: [u32; 2],
    /// Primitives below it; 1 for a leaf.
    primitives: u32,
}

impl BinaryNode {
    fn children(&self) -> Option<[usize; 2]> {
        (self.primitives > 1).then(|| self.below.map(|child| child as usize))
    }
}

impl Binary {
    fn from_bvh2(bvh: &Bvh2, boxes: &[Bounds]) -> Self {
        Self::grow(0, boxes, |number: usize| {
            let node = &bvh.nodes[number];
            let first = node.first_index as usize;
            if node.is_leaf() {
                Err(bvh.primitive_indices[first])
            } else {
                Ok([first, first + 1])
            }
        })
    }

    /// Halves `order` again and again.
    fn balanced(order: &[u32], boxes: &[Bounds]) -> Self {
        Self::grow(order, boxes, |part| match part {
            [primitive] => Err(*primitive),
            _ => Ok(part.split_at(part.len() / 2).into()),
        })
    }

    /// Grows a tree from its root: `split` makes two children of a part, or a leaf with a primitive.
    fn grow<T>(root: T, boxes: &[Bounds], split: impl Fn(T) -> Result<[T; 2], u32>) -> Self {
        let mut nodes: Vec<BinaryNode> = Vec::with_capacity(2 * boxes.len());
        let mut pending = vec![(root, None::<(usize, usize)>)];
        while let Some((part, parent)) = pending.pop() {
            let number = nodes.len();
            if let Some((parent, side)) = parent {
                nodes[parent].below[side] = number as u32;
            }
            nodes.push(match split(part) {
                Err(primitive) => BinaryNode {
                    bounds: boxes[primitive as usize],
                    below: [primitive; 2],
                    primitives: 1,
                },
                Ok([left, right]) => {
                    pending.push((left, Some((number, 0))));
                    pending.push((right, Some((number, 1))));
                    BinaryNode {
                        bounds: Bounds::EMPTY,
                        below: [0; 2],
                        primitives: 2,
                    }
                }
            });
        }
        for number in (0..nodes.len()).rev() {
            if let Some([left, right]) = nodes[number].children() {
                nodes[number].bounds = nodes[left].bounds.union(nodes[right].bounds);
                nodes[number].primitives = nodes[left].primitives + nodes[right].primitives;
            }
        }
        Self { nodes }
    }

    fn primitives(&self, node: usize) -> Vec<u32> {
        let mut found = Vec::with_capacity(self.nodes[node].primitives as usize);
        let mut pending = vec![node];
        while let Some(number) = pending.pop() {
            match self.nodes[number].children() {
                None => found.push(self.nodes[number].below[0]),
                Some([left, right]) => pending.extend([right, left]),
            }
        }
        found
    }
}

/// The cheapest ways to stand for a subtree: Ylitie, Karras & Laine 2017, "Efficient Incoherent
/// Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.
struct Plan<const W: usize> {
    /// For each node and each number `i + 1` of children that it may give its parent: how many
    /// of them its left subtree gives; 0 where one child fewer costs no more.
    left: Vec<[u8; W]>,
    leaf: Vec<bool>,
}

impl<const W: usize> Plan<W> {
    fn new(tree: &Binary, leaf_size: usize) -> Self {
        let count = tree.nodes.len();
        let mut plan = Self {
            left: vec![[0; W]; count],
            leaf: vec![false; count],
        };
        // The costs of nodes whose parents come next, with at most `i + 1` children for the parent.
        // A right child's is above its sibling's.
        let mut costs: Vec<[f64; W]> = Vec::new();
        for (number, node) in tree.nodes.iter().enumerate().rev() {
            // To visit a node or a leaf is one vector operation, however many lanes are in use.
            let area = node.bounds.half_area();
            let as_leaf = if node.primitives as usize <= leaf_size {
                area
            } else {
                f64::INFINITY
            };
            let mut child = || {
                let is_inner = node.primitives > 1;
                is_inner.then(|| costs.pop()).flatten()
            };
            let (Some(right), Some(left)) = (child(), child()) else {
                costs.push([as_leaf; W]);
                plan.leaf[number] = true;
                continue;
            };
            let split = |slots: usize| {
                (1..slots)
                    .map(|k| (left[k - 1] + right[slots - k - 1], k as u8))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .unwrap_or((f64::INFINITY, 1))
            };
            let (below, k) = split(W);
            let as_node = below + area;
            let (mut cost, mut choice) = ([0.0; W], [0; W]);
            // The last place holds the split among the node's own children.
            choice[W - 1] = k;
            cost[0] = as_leaf.min(as_node);
            for slots in 2..W {
                let (spread, k) = split(slots);
                if spread < cost[slots - 2] {
                    (cost[slots - 1], choice[slots - 1]) = (spread, k);
                } else {
                    cost[slots - 1] = cost[slots - 2];
                }
            }
            plan.leaf[number] = as_leaf <= as_node;
            plan.left[number] = choice;
            costs.push(cost);
        }
        plan
    }

    fn children(&self, tree: &Binary, number: usize) -> Vec<usize> {
        let mut found = Vec::with_capacity(W);
        let Some([left, right]) = tree.nodes[number].children() else {
            return vec![number];
        };
        let k = self.left[number][W - 1] as usize;
        let mut pending = vec![(right, W - k), (left, k)];
        while let Some((node, mut slots)) = pending.pop() {
            while slots > 1 && self.left[node][slots - 1] == 0 {
                slots -= 1;
            }
            match tree.nodes[node].children() {
                Some([left, right]) if slots > 1 => {
                    let k = self.left[node][slots - 1] as usize;
                    pending.push((right, slots - k));
                    pending.push((left, k));
                }
                _ => found.push(node),
            }
        }
        found
    }
}

fn collapse<const W: usize>(binary: &Binary, leaf_size: usize) -> WideTree<W> {
    let plan = Plan::<W>::new(binary, leaf_size);
    let mut tree = WideTree {
        nodes: Vec::new(),
        leaves: Leaves::default(),
        stack_entries: 0,
    };
    // Binary node, where its number goes, and stack entries below it.
    let mut pending = vec![(0usize, None, 0usize)];
    while let Some((source, parent, below)) = pending.pop() {
        let number = tree.nodes.len();
        let children = plan.children(binary, source);
        let mut node = Node::EMPTY;
        tree.stack_entries = tree.stack_entries.max(below + W);
        for (lane, &child) in children.iter().enumerate() {
            let Bounds { low, high } = binary.nodes[child].bounds;
            node.set_bounds(lane, low, high);
            if plan.leaf[child] {
                let primitives = binary.primitives(child);
                let count = primitives.len() as u32 - 1;
                node.child[lane] = LEAF | count << COUNT_SHIFT | tree.leaves.len() as u32;
                tree.leaves.push(primitives);
            } else {
                pending.push((child, Some((number, lane)), below + children.len() - 1));
            }
        }
        node.set_order();
        tree.nodes.push(node);
        if let Some((parent, lane)) = parent {
            let parent: &mut Node<W> = &mut tree.nodes[parent];
            parent.child[lane] = number as u32;
        }
    }
    tree
}
