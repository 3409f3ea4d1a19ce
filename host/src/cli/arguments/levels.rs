//! The polygon levels that a baked scene has: for reports, and what to warn of.

use crate::bake::simplify::{PolygonLevels, Topology};
use crate::cli::prelude::*;
use crate::scene::Scene as Described;
use shisen_core::scene::Scene;
use shisen_core::scene::format::{IdLeaf, LeafBlock, Mesh, Node};

/// A mesh at one of its levels.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Level {
    /// Number of the mesh, from 0.
    pub mesh: usize,
    /// Faces of the mesh at this level.
    pub faces: u32,
    /// Bytes of this level alone, its tree and its record, without what all levels share.
    pub bytes: usize,
}

impl Level {
    /// Returns the levels of all meshes, the finest of each first.
    pub fn of(baked: &BakedScene) -> Vec<Self> {
        with_scene!(baked.scene(), |scene| Self::all(&scene))
    }

    fn all<const W: usize>(scene: &Scene<'_, W>) -> Vec<Self> {
        let leaf_bytes = if W == 4 {
            size_of::<IdLeaf>()
        } else {
            size_of::<LeafBlock<W>>()
        };
        // A level that equals the finer one before it shares its tree.
        let mut levels = Vec::new();
        let mut mesh = 0;
        let mut finer: Option<&Mesh> = None;
        for record in scene.meshes() {
            let finer_rung = finer.filter(|finer| finer.rungs > 1);
            let repeats = finer_rung.is_some_and(|finer| finer.root == record.root);
            let tree = if repeats {
                0
            } else {
                record.node_count as usize * size_of::<Node<W>>()
                    + record.leaf_count as usize * leaf_bytes
            };
            mesh += usize::from(finer.is_some() && finer_rung.is_none());
            levels.push(Self {
                mesh,
                faces: record.faces,
                bytes: tree + size_of::<Mesh>(),
            });
            finer = Some(record);
        }
        levels
    }

    /// Returns warnings of meshes that do not deform, whose levels are not as coarse as asked or may
    /// not fit each other.
    /// Vertices at which parts touch do no harm: every level stays closed.
    pub fn warnings(scene: &Described, asked: &PolygonLevels, baked: &BakedScene) -> Vec<String> {
        let mut warnings = Vec::new();
        let made = Self::of(baked);
        let meshes = scene.meshes.iter().zip(Self::by_mesh(&made)).enumerate();
        for (number, (mesh, made)) in meshes.filter(|(_, (mesh, _))| asked.apply_to(mesh)) {
            if scene.motion.deforming().any(|one| one == number) {
                continue;
            }
            let mesh_number = format!("mesh {number} (counted from 0)");
            let faces_asked = asked.asked_of(mesh.triangles.len());
            let which = [("finest", made.first()), ("coarsest", made.last())];
            for ((which, level), asked) in which.into_iter().zip(faces_asked) {
                let faces = level.map_or(0, |level| level.faces as usize);
                // A collapse may leave one face more.
                if faces > asked + 1 {
                    warnings.push(format!(
                    "{mesh_number} has {faces} faces at its {which} level, not {asked}: with fewer \
                     it would change how it hangs together. Weld its vertices, or ask for no fewer \
                     with --faces MIN..MAX"
                ));
                }
            }
            let Topology {
                open_edges,
                crowded_edges,
            } = Topology::of(mesh);
            if open_edges > 0 {
                warnings.push(format!(
                "{mesh_number} is not closed: {open_edges} edges are open. Along them its coarser \
                 levels may cover less than finer ones, and light may pass"
            ));
            }
            if crowded_edges > 0 {
                warnings.push(format!(
                "{mesh_number} has {crowded_edges} edges of more than two faces. Parts that touch \
                 there may come apart at coarser levels"
            ));
            }
        }
        warnings
    }

    pub fn by_mesh(levels: &[Self]) -> impl Iterator<Item = &[Self]> {
        levels.chunk_by(|a, b| a.mesh == b.mesh)
    }

    pub fn finest_faces(levels: &[Self]) -> usize {
        let finest = Self::by_mesh(levels).map(|levels| levels[0].faces);
        finest.map(|faces| faces as usize).sum()
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { faces, bytes, .. } = self;
        write!(f, "{faces:>10} faces   {bytes:>12} bytes")
    }
}
