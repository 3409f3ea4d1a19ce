//! `shisen-evidence bench rays`: how fast rays are traced.

use super::print;
use clap::Args;
use glam::Vec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::bake::{Baked, Layout, lone_mesh};
use shisen::cli::arguments::source::{Told, load_mesh};
use shisen::cli::arguments::{SimdChoice, threads};
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::files::Fault;
use shisen::files::write_atomically;
use shisen::live::quantiles::median;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TraversalStack};
use shisen_core::{Runs, Simd};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Rays that a thread takes at a time: some milliseconds of work.
const CHUNK: usize = 1 << 14;

const RAY_BYTES: usize = 24;

/// Traces a file of rays against one mesh
///
/// The rays are little-endian f32, six a ray: origin x, y, z and direction
/// x, y, z; there is no header. A ray with a value that is not finite or
/// without a direction hits nothing.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// An OBJ, PLY or glTF file
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// The file of rays
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,
    /// Threads to trace on
    #[arg(long, value_name = "N", default_value = "1", value_parser = threads)]
    threads: NonZeroUsize,
    /// How often to trace all rays
    #[arg(long, value_name = "N", default_value_t = 7,
          value_parser = whole::<u32>(1..=10_000))]
    repeat: u32,
    /// Write what each ray hit: u32 triangle, counted from 0 in the file's
    /// order, or 0xFFFFFFFF; f32 distance in units of the direction, or
    /// infinity; both little-endian
    #[arg(long, value_name = "FILE")]
    hits: Option<PathBuf>,
    /// Instruction set to use
    #[arg(long, value_enum, default_value = "auto")]
    simd: SimdChoice,
    /// Layout to trace
    #[arg(long, value_enum, default_value = "fast")]
    layout: Layout,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// How fast the rays were traced.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Millions of rays a second.
    mrays_per_second: Rates,
    /// Number of rays.
    rays: usize,
    /// Number of rays that hit.
    hits: usize,
    /// Nodes visited and triangles tested, per ray.
    steps_per_ray: f64,
    /// Time to bake the mesh, seconds.
    build_seconds: f64,
    /// Instruction set that traces: avx2 or portable.
    simd: &'static str,
    /// Threads that trace.
    threads: usize,
    /// How often all rays were traced.
    repeat: u32,
    /// Layout of the baked mesh: fast or compact.
    layout: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Rates {
    /// The median.
    median: f64,
    /// The lowest.
    min: f64,
    /// The highest.
    max: f64,
}

/// A ray's triangle and distance.
type RayHit = (u32, f32);

const MISS: RayHit = (u32::MAX, f32::INFINITY);

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let rays = read_rays(&arguments.rays)?;
    let mesh = load_mesh(&arguments.mesh, &mut Told::default())?;
    let (report, text, hits) = match arguments.layout {
        Layout::Fast => measure::<8>(arguments, mesh, &rays)?,
        Layout::Compact => measure::<4>(arguments, mesh, &rays)?,
    };
    if let Some(path) = &arguments.hits {
        write_atomically(path, |file| {
            hits.iter().try_for_each(|(triangle, t)| {
                file.write_all(&triangle.to_le_bytes())?;
                file.write_all(&t.to_le_bytes())
            })
        })
        .map_err(Fault::write(path))?;
    }
    print(arguments.json, &report, &text)
}

/// Returns the rays of a file; `None` for those that cannot be traced.
fn read_rays(path: &Path) -> Result<Vec<Option<Ray>>, Fault> {
    let shown = path.display();
    let bytes = shisen::files::read(path).map_err(|reason| {
        let message = format!("cannot read the rays in {shown}: {reason}");
        let help = "give the path of a file of rays, each six little-endian f32";
        Fault::new(message, help)
    })?;
    if bytes.is_empty() || bytes.len() % RAY_BYTES != 0 {
        let count = bytes.len();
        return Err(Fault::new(
            format!("{shown} has {count} bytes, which is not a whole number of rays, or none"),
            "a ray takes 24 bytes: origin x, y, z and direction x, y, z as little-endian f32; \
             there is no header",
        ));
    }
    let (rays, _) = bytes.as_chunks::<RAY_BYTES>();
    Ok(rays.iter().map(ray).collect())
}

fn ray(bytes: &[u8; RAY_BYTES]) -> Option<Ray> {
    let (numbers, _) = bytes.as_chunks::<4>();
    let vector = |first: usize| {
        Vec3::from_array(std::array::from_fn(|axis| {
            numbers
                .get(first + axis)
                .map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes))
        }))
    };
    Ray::new(vector(0), vector(3))
}

fn measure<const W: usize>(
    arguments: &Arguments,
    mesh: TriangleMesh,
    rays: &[Option<Ray>],
) -> Result<(Report, String, Vec<RayHit>), Failure>
where
    Simd: Runs<W>,
{
    let threads = arguments.threads.get();
    let simd = arguments.simd.path();
    let start = Instant::now();
    let baked = Baked::<W>::new(&lone_mesh(mesh)).map_err(Failure::from_error)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let scene = baked.scene();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|reason| {
            let message = format!("cannot start {threads} threads: {reason}");
            Fault::new(message, "ask for fewer with --threads")
        })?;
    let mut hits = vec![MISS; rays.len()];
    let mut steps = 0;
    let mut rates = Vec::new();
    // A baked mesh has mesh number 0: without one there is nothing to trace.
    if let Some(tracer) = MeshTracer::new(&scene, 0, simd) {
        for _ in 0..arguments.repeat {
            let start = Instant::now();
            steps = pool.install(|| trace(&tracer, rays, &mut hits));
            rates.push(rays.len() as f64 / start.elapsed().as_secs_f64() / 1.0e6);
        }
    }
    rates.sort_by(f64::total_cmp);
    let end = |rate: Option<&f64>| rate.copied().unwrap_or_default();
    let (min, max) = (end(rates.first()), end(rates.last()));
    let median = median(rates);
    let (simd, layout) = (arguments.layout.simd(simd).name(), arguments.layout.name());
    let hit = hits.iter().filter(|hit| **hit != MISS).count();
    let (rays, steps) = (rays.len(), steps as f64 / rays.len() as f64);
    let text = format!(
        "{median:.2} million rays a second ({min:.2} to {max:.2}) on {threads} threads, {simd}, \
         {layout} layout\n{rays} rays, {hit} hits, {steps:.1} steps a ray; built in \
         {build_seconds:.2} s"
    );
    let report = Report {
        mrays_per_second: Rates { median, min, max },
        rays,
        hits: hit,
        steps_per_ray: steps,
        build_seconds,
        simd,
        threads,
        repeat: arguments.repeat,
        layout,
    };
    Ok((report, text, hits))
}

/// Traces all rays and returns the steps it took.
fn trace<const W: usize>(
    tracer: &MeshTracer<'_, W>,
    rays: &[Option<Ray>],
    hits: &mut [RayHit],
) -> u64
where
    Simd: Runs<W>,
{
    rays.par_chunks(CHUNK)
        .zip(hits.par_chunks_mut(CHUNK))
        .map_init(
            || TraversalStack::EMPTY,
            |stack, (rays, hits)| {
                let mut hits = hits.iter_mut();
                tracer.nearest_of_each(rays.iter().copied(), stack, |nearest| {
                    if let Some(hit) = hits.next() {
                        *hit = nearest.map_or(MISS, |hit| (hit.triangle, hit.t));
                    }
                })
            },
        )
        .sum()
}
