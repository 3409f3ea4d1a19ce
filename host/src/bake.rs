//! From a scene in memory to the bytes that the core traces: trees, tables, polygon levels.
//!
//! [`Baked`] is for a layout that is known at compile time, [`BakedScene`] for one that is not.
//! [`simplify`] makes the coarser levels of meshes: closed meshes stay closed.

pub mod simplify;

mod blob;
mod cover;
mod environment;
mod fit;
mod instance;
mod layout;
mod levels;
mod light;
mod material;
mod nested;
mod stage;
mod tangents;
mod tree;

pub use layout::{AnyScene, BakedScene, Layout};
pub use stage::{Stage, StageMemory, Staged};

use crate::bake::simplify::{Ladder, PolygonLevels};
use crate::scene::material::Material;
use crate::scene::mesh::{MeshError, TriangleMesh};
use crate::scene::{Object, Scene, Shape};
use blob::{AlignedBytes, Tables, positive_zero};
use cover::Cover;
use instance::instance;
use light::{background, light};
use material::Textures;
use rayon::prelude::*;
use shisen_core::scene::SceneError;
use shisen_core::scene::format::{
    self, IdLeaf, Instance, LeafBlock, MOST_NESTED, NO_COLOURS, NO_MATERIAL, NO_TANGENTS, Node,
};
use shisen_core::shape::Spheroid;
use shisen_core::{Runs, Simd};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use thiserror::Error;
use tree::{Bounds, WideTree};

/// A baked scene of one layout: the bytes of `shisen_core::scene`, aligned for use in place.
#[derive(Debug, Clone, PartialEq)]
#[doc(hidden)]
pub struct Baked<const W: usize = 8> {
    bytes: AlignedBytes,
}

/// Hears how many parts of a bake are done, and how many there are.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// Why a scene cannot be baked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages are the docs")]
pub enum BakeError {
    #[error("mesh {mesh} (counted from 0) cannot be used")]
    Mesh {
        mesh: usize,
        #[source]
        source: MeshError,
    },
    #[error("the scene has no objects")]
    NoObjects,
    #[error("object {object} (counted from 0) names {what} {index}, which the scene does not have")]
    Missing {
        object: usize,
        what: &'static str,
        index: usize,
    },
    #[error(
        "object {object} (counted from 0) has a texture, but its mesh has no texture coordinates"
    )]
    NoCoordinates { object: usize },
    #[error(
        "object {object} (counted from 0) is placed by a map that cannot be undone, or too far away \
         (coordinates may be up to {:e} m)",
        TriangleMesh::FARTHEST
    )]
    Transform { object: usize },
    #[error(
        "object {object} (counted from 0) has a radius outside {:e} to {:e} m",
        Spheroid::RADII.0,
        Spheroid::RADII.1
    )]
    Radius { object: usize },
    #[error(
        "material {material} (counted from 0) has a priority, but only the first {MOST_NESTED} can: in \
         a scene file they are in the order of their names, so give it one that sorts first"
    )]
    Nested { material: usize },
    #[error("the scene holds a value that the tracer refuses: {0}")]
    Refused(#[from] SceneError),
    #[error(
        "the scene would take at least {bytes} bytes baked, and may take 4 GiB: leave parts of it \
         out, or give its meshes fewer triangles"
    )]
    TooLarge { bytes: u64 },
}

impl<const W: usize> Baked<W>
where
    Simd: Runs<W>,
{
    /// Bakes a scene for nodes of `W` children. The same scene always gives the same bytes.
    ///
    /// # Errors
    /// A mesh, an object or a number of bytes that the core would refuse.
    pub fn new(scene: &Scene) -> Result<Self, BakeError> {
        Self::bake(scene, None, &|_, _| ())
    }

    /// As [`new`](Self::new), with each mesh at several polygon levels.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_levels(scene: &Scene, levels: &PolygonLevels) -> Result<Self, BakeError> {
        Self::bake(scene, Some(levels), &|_, _| ())
    }

    /// `progress` hears how many levels and trees are made.
    fn bake(
        scene: &Scene,
        levels: Option<&PolygonLevels>,
        progress: &Progress<'_>,
    ) -> Result<Self, BakeError> {
        for (mesh, source) in scene.meshes.iter().enumerate() {
            let checked = source.validate();
            checked.map_err(|source| BakeError::Mesh { mesh, source })?;
        }
        check_size::<W>(scene)?;
        let shown = shown(scene);
        // A level is made, and so is its tree.
        let deforming: Vec<usize> = scene.motion.deforming().collect();
        let levels_of = |mesh: usize| levels.filter(|_| !deforming.contains(&mesh));
        let parts = |(number, mesh): (usize, &TriangleMesh)| {
            2 * levels_of(number).map_or(1, |levels| levels.rungs_of(mesh))
        };
        let total = scene.meshes.iter().enumerate().map(parts).sum::<u32>() as usize;
        let done = AtomicUsize::new(0);
        let tell = || progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
        let prepared = shown
            .par_iter()
            .enumerate()
            .map(|(number, source)| Prepared::new(source, levels_of(number), &tell));
        let meshes: Vec<Prepared<'_, W>> = prepared.collect();
        let mut tables = Tables::<W>::default();
        let mut textures = Textures::default();
        for (material, source) in scene.materials.iter().enumerate() {
            if source.priority > 0 && material >= MOST_NESTED {
                return Err(BakeError::Nested { material });
            }
            tables.add_material(source, &mut textures);
        }
        // The tree over instances comes first, whose size is known only once the instances are.
        let mut placed = Vec::new();
        for (number, object) in scene.objects.iter().enumerate() {
            let (mut instance, slack) = instance(scene, number, object)?;
            if let Shape::Mesh(mesh) = object.shape {
                // Past the rungs of all meshes before it.
                let before = meshes[..mesh].iter().map(Prepared::rungs).sum::<usize>();
                instance.geometry = before as u32;
            }
            placed.push((instance, slack));
        }
        if placed.is_empty() {
            return Err(BakeError::NoObjects);
        }
        let bounds = |&(Instance { low, high, .. }, _): &(Instance, f64)| Bounds { low, high };
        let boxes: Vec<Bounds> = placed.iter().map(bounds).collect();
        let top = tree::build::<W>(&boxes, 1);
        let trees = meshes.iter().flat_map(|mesh| mesh.trees.values());
        let deepest = trees.map(|tree| tree.stack_entries).max();
        let stack_entries = top.stack_entries + deepest.unwrap_or(0);
        tables.top_nodes = top.nodes.len() as u32;
        for mut node in top.nodes {
            // Leaves of this tree name instances, not leaf blocks.
            for child in &mut node.child {
                if *child & format::LEAF != 0 {
                    let leaf = (*child & format::INDEX) as usize;
                    *child = format::LEAF | top.leaves.get(leaf)[0];
                }
            }
            tables.nodes.push(node);
        }
        for (object, (instance, slack)) in scene.objects.iter().zip(&mut placed) {
            if let Shape::Mesh(mesh) = object.shape {
                let Prepared { ladder, cover, .. } = &meshes[mesh];
                let positions = &ladder.versions().positions;
                let cover = cover.placed(positions, &object.world_from_object, *slack);
                instance.cover = tables.add_nodes(&cover, 0);
                instance.cover_nodes = cover.len() as u32;
            }
        }
        tables.rungs = meshes.iter().map(Prepared::rungs).max().unwrap_or(1) as u32;
        let mut ladders = Vec::with_capacity(meshes.len());
        for Prepared { ladder, trees, .. } in meshes {
            tables.add_mesh(ladders.len(), &ladder, trees, &mut textures);
            ladders.push(ladder);
        }
        tables.lights = scene.lights.iter().map(light).collect();
        tables.extent = extent(boxes.iter().flat_map(|b| [b.low, b.high]));
        tables.instances = placed.into_iter().map(|(instance, _)| instance).collect();
        tables.ambient = scene.ambient;
        tables.stack_entries = stack_entries as u32;
        tables.add_default_material();
        let has_priorities = tables.materials.iter().any(|one| one.priority > 0);
        if !has_priorities && nested::may_nest(scene, &boxes) {
            tables.nest_materials();
        }
        let mut background = background(&scene.background);
        if let Some(environment) = &scene.environment {
            background.image = tables.add_environment(environment);
            background.turn = environment.yaw / TAU;
        }
        let baked = Self {
            bytes: tables.into_bytes(background, &ladders)?,
        };
        // The core checks it once here, so that `scene` cannot fail.
        baked.try_scene()?;
        Ok(baked)
    }

    /// Returns the bytes, as they go to a file or to flash.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_bytes()
    }

    /// Takes the bytes of a scene file, aligning them.
    ///
    /// # Errors
    /// What the core finds wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneError> {
        Self::from_aligned(AlignedBytes::copy_of(bytes)).map_err(|(_, fault)| fault)
    }

    /// The error has the bytes back.
    fn from_aligned(bytes: AlignedBytes) -> Result<Self, (AlignedBytes, SceneError)> {
        let baked = Self { bytes };
        match baked.try_scene().map(drop) {
            Ok(()) => Ok(baked),
            Err(fault) => Err((baked.bytes, fault)),
        }
    }

    fn try_scene(&self) -> Result<shisen_core::scene::Scene<'_, W>, SceneError> {
        shisen_core::scene::Scene::from_bytes(self.as_bytes())
    }

    /// Returns the scene in these bytes.
    ///
    /// # Panics
    /// Never: the bytes were checked when this value was made.
    pub fn scene(&self) -> shisen_core::scene::Scene<'_, W> {
        self.try_scene().expect("checked when it was made")
    }
}

/// Returns one mesh as a scene of its own, in its own frame.
pub fn lone_mesh(mesh: TriangleMesh) -> Scene {
    Scene {
        name: "mesh".into(),
        meshes: vec![mesh],
        objects: vec![Object {
            smooth: false,
            ..Object::new(Shape::Mesh(0))
        }],
        ..Scene::default()
    }
}

/// Refuses a scene whose meshes would take more bytes than a scene may, before trees are built. It
/// estimates that leaves are filled to seven eighths, and that a node is for `4 * W` triangles.
fn check_size<const W: usize>(scene: &Scene) -> Result<(), BakeError> {
    let leaf = if W == 8 {
        size_of::<LeafBlock<8>>()
    } else {
        size_of::<IdLeaf>()
    };
    let tree = leaf * 8 / (7 * W) + size_of::<Node<W>>() / (4 * W);
    let triangle = (size_of::<format::Triangle>() + tree) as u64;
    let meshes = scene.meshes.iter().map(|mesh| {
        mesh.triangles.len() as u64 * triangle + size_of_val(mesh.positions.as_slice()) as u64
    });
    let bytes = meshes.sum();
    match u32::try_from(bytes) {
        Ok(_) => Ok(()),
        Err(_) => Err(BakeError::TooLarge { bytes }),
    }
}

/// Returns the meshes, with tangents where an object shows a normal map on them, and without
/// coordinates where none shows a texture.
fn shown(scene: &Scene) -> Vec<Cow<'_, TriangleMesh>> {
    let meshes = scene.meshes.par_iter().enumerate();
    meshes
        .map(|(number, mesh)| {
            let places = |object: &&Object| object.shape == Shape::Mesh(number);
            let material = |object: &Object| scene.materials.get(object.material?);
            let objects = scene.objects.iter().filter(places);
            let materials: Vec<Option<&Material>> = objects.map(material).collect();
            if !mesh.coordinates.is_empty() && materials.iter().any(|one| mesh.shows_texture(*one))
            {
                return tangents::with_tangents(mesh, &materials);
            }
            if mesh.coordinates.is_empty() && mesh.tangents.is_empty() {
                return Cow::Borrowed(mesh);
            }
            Cow::Owned(TriangleMesh {
                coordinates: Vec::new(),
                second_coordinates: Vec::new(),
                tangents: Vec::new(),
                ..mesh.clone()
            })
        })
        .collect()
}

/// The parts of a baked mesh that do not depend on where it stands.
struct Prepared<'m, const W: usize> {
    ladder: Ladder<'m>,
    /// Trees of rungs, by their numbers; none for a rung that is like the one before.
    trees: BTreeMap<usize, WideTree<W>>,
    cover: Cover<W>,
}

impl<'m, const W: usize> Prepared<'m, W> {
    /// Trees of finer rungs are built while coarser rungs are still to be made, one after another,
    /// and while the cover is.
    fn new(
        mesh: &'m TriangleMesh,
        levels: Option<&PolygonLevels>,
        tell: &(dyn Fn() + Sync),
    ) -> Self {
        let (built, trees) = mpsc::channel();
        let (ladder, cover) = rayon::in_place_scope(|scope| {
            let each = |number: usize, versions: &TriangleMesh, rung: &[u32]| {
                let bounds = |&triangle: &u32| Bounds::of_triangle(versions, triangle as usize);
                let boxes: Vec<Bounds> = rung.iter().map(bounds).collect();
                let (rung, built) = (rung.to_vec(), built.clone());
                tell();
                scope.spawn(move |_| {
                    let mut tree = tree::build(&boxes, W);
                    drop(boxes);
                    tree.leaves.rename(&rung);
                    tell();
                    // Received below, once all are built.
                    drop(built.send((number, tree)));
                });
            };
            let ladder = Ladder::with_each(mesh, levels, each);
            let has_levels = ladder.rungs().len() > 1;
            let cover = has_levels.then(|| Cover::new(ladder.versions()));
            (ladder, cover)
        });
        drop(built);
        let trees: BTreeMap<usize, WideTree<W>> = trees.into_iter().collect();
        let cover = cover.unwrap_or_else(|| Cover::of(&trees[&0], ladder.versions()));
        Self {
            ladder,
            trees,
            cover,
        }
    }

    fn rungs(&self) -> usize {
        self.ladder.rungs().len()
    }
}

fn extent(points: impl Iterator<Item = [f32; 3]>) -> f32 {
    points.flatten().fold(0.0, |extent, c| extent.max(c.abs()))
}

impl<const W: usize> Tables<W> {
    /// Adds the nodes of a tree, whose leaves start at `first_leaf`; returns the number of the first.
    fn add_nodes(&mut self, nodes: &[Node<W>], first_leaf: u32) -> u32 {
        let first = self.nodes.len() as u32;
        self.nodes
            .extend(nodes.iter().map(|node| node.moved(first, first_leaf)));
        first
    }

    fn add_mesh(
        &mut self,
        number: usize,
        ladder: &Ladder<'_>,
        mut trees: BTreeMap<usize, WideTree<W>>,
        textures: &mut Textures,
    ) {
        let mesh = ladder.versions();
        let first_triangle = self.triangles.len() as u32;
        let first_normal = self.normals.len() as u32;
        let first_coordinate = self.coordinates.len() as u32;
        let first_material = self.materials.len() as u32;
        for (number, &corners) in mesh.triangles.iter().enumerate() {
            // Resolved to the default material once all materials are there.
            let material = mesh
                .triangle_materials
                .get(number)
                .map_or(NO_MATERIAL, |m| first_material + m);
            self.triangles.push(format::Triangle { corners, material });
        }
        for source in &mesh.materials {
            self.add_material(source, textures);
        }
        self.normals.extend_from_slice(&mesh.vertex_normals());
        self.coordinates.extend_from_slice(&mesh.coordinates);
        self.coordinates.extend_from_slice(&mesh.second_coordinates);
        let first_colour = if mesh.colours.is_empty() {
            NO_COLOURS
        } else {
            self.colours.len() as u32
        };
        self.colours.extend_from_slice(&mesh.colours);
        let first_tangent = if mesh.tangents.is_empty() {
            NO_TANGENTS
        } else {
            self.tangents.len() as u32
        };
        self.tangents.extend_from_slice(&mesh.tangents);
        if W == 4 {
            let positions = mesh.positions.iter();
            self.positions
                .extend(positions.map(|p| p.map(positive_zero)));
        }
        let extent = extent(mesh.positions.iter().copied());
        let count = ladder.rungs().len();
        for (rung, faces) in ladder.rungs().iter().enumerate() {
            let rungs = (count - rung) as u32;
            let Some(tree) = trees.remove(&rung) else {
                let finer = *self.meshes.last().expect("the rung before");
                self.meshes.push(format::Mesh { rungs, ..finer });
                continue;
            };
            let (first_leaf, leaf_count) = (self.leaf_count, tree.leaves.len() as u32);
            let first_node = self.add_nodes(&tree.nodes, first_leaf);
            self.leaf_count += leaf_count;
            self.leaves.push((number, tree.leaves));
            self.meshes.push(format::Mesh {
                root: first_node,
                first_node,
                node_count: tree.nodes.len() as u32,
                first_leaf,
                leaf_count,
                first_triangle,
                triangle_count: mesh.triangles.len() as u32,
                first_normal,
                normal_count: mesh.positions.len() as u32,
                extent,
                rungs,
                faces: faces.len() as u32,
                first_coordinate,
                coordinate_count: (mesh.coordinates.len() + mesh.second_coordinates.len()) as u32,
                first_colour,
                first_tangent,
            });
        }
    }
}
