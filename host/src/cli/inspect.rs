//! `shisen inspect`: what is in a baked scene.

use crate::bake::BakedScene;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source;
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::with_scene;
use clap::Args;
use serde::Serialize;
use shisen_core::scene::Scene;
use shisen_core::scene::format::{
    Header, IdLeaf, Instance, LeafBlock, Light, Material, Mesh, Node, Table, Texel, Texture,
    Triangle,
};
use shisen_core::spectrum::Medium;
use std::fmt;
use std::path::PathBuf;
use zerocopy::FromBytes;

/// Shows what is in a baked scene, and checks it
///
/// With --json, one object: path, layout (fast or compact), version of the
/// format, bytes, tables (name, records, bytes each), instances, materials,
/// lights, triangles (each mesh once, at its finest), levels (mesh, faces and
/// bytes of each polygon level of each mesh), `stack_entries` (the most that a
/// ray can need) and `bytes_per_triangle` (of the whole scene; null without
/// triangles).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// What `shisen bake` wrote
    scene: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What is in a baked scene.
#[derive(Debug, Serialize)]
struct Report {
    path: String,
    layout: &'static str,
    version: u32,
    bytes: u64,
    tables: Vec<TableReport>,
    instances: u32,
    materials: u32,
    lights: u32,
    triangles: usize,
    levels: Vec<Level>,
    stack_entries: u32,
    bytes_per_triangle: Option<f64>,
}

#[derive(Debug, Serialize)]
struct TableReport {
    name: &'static str,
    records: u32,
    bytes: u64,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let baked = source::load_baked(&arguments.scene)?;
    let path = arguments.scene.display().to_string();
    print(&Report::new(path, &baked), arguments.json)
}

impl Report {
    fn new(path: String, baked: &BakedScene) -> Self {
        with_scene!(baked, |scene| Self::of(path, baked, &scene))
    }

    fn of<const W: usize>(path: String, baked: &BakedScene, scene: &Scene<'_, W>) -> Self {
        let tables = tables::<W>(baked.as_bytes());
        let levels = Level::of(baked);
        let triangles = Level::finest_faces(&levels);
        let length = u64::from(scene.byte_len());
        Self {
            path,
            layout: baked.layout().name(),
            version: shisen_core::scene::format::VERSION,
            bytes: length,
            tables,
            instances: scene.instances().len() as u32,
            materials: scene.materials().len() as u32,
            lights: scene.lights().len() as u32,
            triangles,
            levels,
            stack_entries: scene.stack_entries(),
            bytes_per_triangle: (triangles > 0).then(|| length as f64 / triangles as f64),
        }
    }
}

/// The tables in the order of the header; none where the bytes have no
/// header.
fn tables<const W: usize>(bytes: &[u8]) -> Vec<TableReport> {
    let Ok((header, _)) = Header::read_from_prefix(bytes) else {
        return Vec::new();
    };
    let table = |name, table: Table, record_bytes: usize| TableReport {
        name,
        records: table.count,
        bytes: u64::from(table.count) * record_bytes as u64,
    };
    // One of the two kinds of leaves is empty.
    let leaves = if W == 8 {
        table("leaves", header.leaves, size_of::<LeafBlock<W>>())
    } else {
        table("leaves", header.id_leaves, size_of::<IdLeaf>())
    };
    vec![
        table("nodes", header.nodes, size_of::<Node<W>>()),
        leaves,
        table("meshes", header.meshes, size_of::<Mesh>()),
        table("instances", header.instances, size_of::<Instance>()),
        table("materials", header.materials, size_of::<Material>()),
        table("lights", header.lights, size_of::<Light>()),
        table("triangles", header.triangles, size_of::<Triangle>()),
        table("normals", header.normals, size_of::<[f32; 3]>()),
        table("positions", header.positions, size_of::<[f32; 3]>()),
        table("coordinates", header.coordinates, size_of::<[f32; 2]>()),
        table("textures", header.textures, size_of::<Texture>()),
        table("media", header.media, size_of::<Medium>()),
        table("texels", header.texels, size_of::<Texel>()),
    ]
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            path,
            layout,
            version,
            bytes,
            stack_entries,
            ..
        } = self;
        writeln!(
            f,
            "{path}: {layout} layout, format version {version}, {bytes} bytes"
        )?;
        for TableReport {
            name,
            records,
            bytes,
        } in &self.tables
        {
            writeln!(f, "{name:>12} {records:>10} records {bytes:>12} bytes")?;
        }
        let ladders = Level::by_mesh(&self.levels).filter(|levels| levels.len() > 1);
        for levels in ladders {
            writeln!(f, "polygon levels of mesh {}:", levels[0].mesh)?;
            for level in levels {
                writeln!(f, "{level}")?;
            }
        }
        if let Some(each) = self.bytes_per_triangle {
            writeln!(f, "{each:.1} bytes a triangle, all tables together")?;
        }
        write!(f, "traversal stack: {stack_entries} entries at most")
    }
}
