//! A baked scene that moves: its instances and meshes as at a time, without another bake.

use super::AnyScene;
use super::tree::{self, Bounds};
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::Pose;
use crate::scene::{self, Shape};
use glam::DAffine3;
use obvhs::BvhBuildParams;
use shisen_core::scene::format::{Instance, LeafBlock, Mesh, Node};
use shisen_core::scene::{PoseError, Poses, Scene, Tables};
use zerocopy::FromZeros as _;

/// A tree is built anew once its cost has grown by this factor.
const MOST_COST: f32 = 1.5;

/// The places for new trees, as a multiple of those of the mesh's baked tree.
const SPARE: usize = 2;

/// The memory of what moves in a scene.
#[derive(Debug)]
pub struct StageMemory<const W: usize = 8> {
    top: Vec<Node<W>>,
    instances: Vec<Instance>,
    nodes: Vec<Node<W>>,
    leaves: Vec<LeafBlock<W>>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    positions: Vec<[f32; 3]>,
    meshes: Vec<Mesh>,
}

/// A scene that moves. Hits are those of a bake of [`scene::Scene::at`] the same time.
#[derive(Debug)]
pub struct Stage<'s, const W: usize = 8> {
    poses: Poses<'s, 's, W>,
    source: &'s scene::Scene,
    pose: Pose,
    trees: Vec<DeformingTree>,
}

/// A baked scene, and what was baked where something in it moves.
#[derive(Debug, Clone, Copy)]
pub struct Staged<'s> {
    /// As it was baked.
    pub scene: AnyScene<'s>,
    /// The scene that was baked, if it moves.
    pub moving: Option<&'s scene::Scene>,
}

impl<'s> From<AnyScene<'s>> for Staged<'s> {
    fn from(scene: AnyScene<'s>) -> Self {
        Self {
            scene,
            moving: None,
        }
    }
}

/// The tree of a mesh that deforms.
#[derive(Debug, Clone)]
struct DeformingTree {
    /// Number of the mesh in the baked scene.
    mesh: usize,
    /// Corners of its triangles, as they were baked.
    triangles: Vec<[u32; 3]>,
    /// The vertices that baking has repeated, for other tangents: the numbers of the originals.
    repeated: Vec<u32>,
    /// Its cost when it was built; `None` before it is known.
    cost: Option<f32>,
    /// Whether there is no memory for another one.
    is_last: bool,
}

impl DeformingTree {
    fn new<const W: usize>(scene: &Scene<'_, W>, number: usize, source: &TriangleMesh) -> Self {
        let mesh = &scene.meshes()[number];
        let triangles = &scene.records().triangles[mesh.first_triangle as usize..];
        let triangles = triangles.iter().take(mesh.triangle_count as usize);
        let triangles: Vec<[u32; 3]> = triangles.map(|triangle| triangle.corners).collect();
        let own = source.positions.len();
        let mut repeated = vec![0; mesh.normal_count as usize - own];
        for (corner, original) in triangles
            .iter()
            .zip(&source.triangles)
            .flat_map(|(a, b)| a.iter().zip(b))
        {
            if let Some(further) = (*corner as usize).checked_sub(own) {
                repeated[further] = *original;
            }
        }
        Self {
            mesh: number,
            triangles,
            repeated,
            cost: None,
            is_last: W != 8,
        }
    }
}

impl<const W: usize> StageMemory<W> {
    /// Returns enough memory for a scene and for new trees of the meshes that deform.
    pub fn of(scene: &Scene<'_, W>, source: &scene::Scene) -> Self {
        let zeroed = |count: usize| vec![[0.0; 3]; count];
        let mut memory = Self {
            top: vec![Node::EMPTY; scene.top_nodes()],
            instances: vec![Instance::new_zeroed(); scene.instances().len()],
            nodes: Vec::new(),
            leaves: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            positions: Vec::new(),
            meshes: Vec::new(),
        };
        let deforming = source.motion.deforming();
        let baked =
            deforming.filter_map(|mesh| scene.meshes().get(baked_mesh(scene, source, mesh)?));
        let spare = baked.fold(None, |spare: Option<[usize; 2]>, mesh| {
            let [nodes, leaves] = spare.unwrap_or_default();
            let [more_nodes, more_leaves] = [mesh.node_count, mesh.leaf_count];
            Some([
                nodes + SPARE * more_nodes as usize,
                leaves + SPARE * more_leaves as usize,
            ])
        });
        if let Some([spare_nodes, spare_leaves]) = spare {
            let (nodes, leaves, _) = scene.sizes();
            memory.nodes = vec![Node::EMPTY; nodes + spare_nodes];
            memory.normals = zeroed(scene.vertices());
            memory.tangents = vec![[0.0; 4]; scene.tangents()];
            memory.meshes = vec![Mesh::new_zeroed(); scene.meshes().len()];
            if W == 8 {
                memory.leaves = vec![LeafBlock::EMPTY; leaves + spare_leaves];
            } else {
                memory.positions = zeroed(scene.vertices());
            }
        }
        memory
    }
}

impl<'s, const W: usize> Stage<'s, W> {
    /// Returns a baked scene as it stands at 0 s. `source` is the scene that was baked.
    ///
    /// # Errors
    /// A pose that the core refuses: see [`PoseError`].
    pub fn new(
        scene: Scene<'s, W>,
        source: &'s scene::Scene,
        memory: &'s mut StageMemory<W>,
    ) -> Result<Self, PoseError> {
        let deforming = source.motion.deforming();
        let trees = deforming.filter_map(|mesh| {
            let number = baked_mesh(&scene, source, mesh)?;
            Some(DeformingTree::new(&scene, number, &source.meshes[mesh]))
        });
        let trees: Vec<DeformingTree> = trees.collect();
        let mut poses = Poses::new(scene, &mut memory.top, &mut memory.instances)?;
        if !trees.is_empty() {
            poses = poses.with_tables(Tables {
                nodes: &mut memory.nodes,
                leaves: &mut memory.leaves,
                normals: &mut memory.normals,
                tangents: &mut memory.tangents,
                positions: &mut memory.positions,
                meshes: &mut memory.meshes,
            })?;
        }
        let mut stage = Self {
            poses,
            source,
            pose: Pose::default(),
            trees,
        };
        stage.set_time(0.0)?;
        Ok(stage)
    }

    /// Moves everything to where it is at a time in seconds. Where a tree has become slow to trace,
    /// builds it anew.
    ///
    /// # Errors
    /// A pose that the core refuses: see [`PoseError`].
    pub fn set_time(&mut self, time: f64) -> Result<(), PoseError> {
        self.source.pose_into(time, &mut self.pose);
        for ((_, shape), tree) in self.pose.meshes.iter_mut().zip(&mut self.trees) {
            for all in [&mut shape.positions, &mut shape.normals] {
                for &vertex in &tree.repeated {
                    all.push(all[vertex as usize]);
                }
            }
            let cost = (self.poses).deform(tree.mesh, &shape.positions, &shape.normals)?;
            let built = *tree.cost.get_or_insert(cost.cost);
            if cost.cost <= MOST_COST * built || tree.is_last {
                continue;
            }
            let bounds = |corners: &[u32; 3]| {
                Bounds::of_points(corners.map(|corner| shape.positions[corner as usize]))
            };
            let boxes: Vec<Bounds> = tree.triangles.iter().map(bounds).collect();
            let new = tree::build_with::<W>(&boxes, W, BvhBuildParams::fast_build());
            let leaves: Vec<_> = new.leaves.iter().map(leaf_of).collect();
            match self.poses.replant(tree.mesh, &new.nodes, &leaves) {
                // The tree that there is goes on.
                Err(PoseError::Memory { .. } | PoseError::NotATree { .. }) => tree.is_last = true,
                replanted => replanted?,
            }
            let cost = (self.poses).deform(tree.mesh, &shape.positions, &shape.normals)?;
            tree.cost = Some(cost.cost);
        }
        for (object, map) in &self.pose.objects {
            self.poses.set(*object, map)?;
        }
        self.poses.refit();
        Ok(())
    }

    /// Returns where the objects that move are, by their numbers; `None` where meshes deform, so that
    /// they are not all that moves.
    pub fn objects(&self) -> Option<&[(usize, DAffine3)]> {
        self.trees.is_empty().then_some(&*self.pose.objects)
    }

    /// Returns the scene as it is now.
    pub fn scene(&self) -> Scene<'_, W> {
        self.poses.scene()
    }
}

/// Returns the number that a mesh has in the baked scene; `None` where no object shows it.
fn baked_mesh<const W: usize>(
    scene: &Scene<'_, W>,
    source: &scene::Scene,
    mesh: usize,
) -> Option<usize> {
    let objects = source.objects.iter();
    let shown = objects
        .zip(scene.instances())
        .find(|(object, _)| object.shape == Shape::Mesh(mesh));
    shown.map(|(_, instance)| instance.geometry as usize)
}

/// Returns a leaf of some triangles, whose corners are not known yet.
fn leaf_of<const W: usize>(triangles: &[u32]) -> LeafBlock<W> {
    let mut block = LeafBlock::EMPTY;
    for (place, triangle) in block.ids.iter_mut().zip(triangles) {
        *place = *triangle;
    }
    block
}
