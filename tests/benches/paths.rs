//! Closest hits on one thread by each path there is for them, on the same rays,
//! interleaved in one run. `cargo bench -p shisen-tests --bench paths`,
//! optionally with `-- FILE.obj` for a mesh of one's own.

use shisen::bake::{Baked, lone_mesh};
use shisen_core::Simd;
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TileRays, TraversalStack};
use shisen_tests::meshes::{icosphere, normalised};
use shisen_tests::rays::{Random, RawRay, bounce, incoherent, pinhole};
use std::path::Path;
use std::time::Instant;

const REPEAT: usize = 7;

fn main() {
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mesh = file.map_or_else(
        || icosphere(4),
        |path| shisen::scene::import::load(Path::new(&path)).expect("a mesh file"),
    );
    let mesh = normalised(mesh, 10.0);
    println!("{} triangles", mesh.triangles.len());
    let start = Instant::now();
    let baked = Baked::<8>::new(&lone_mesh(mesh.clone())).expect("bakes");
    println!(
        "baked in {:?}, {} bytes",
        start.elapsed(),
        baked.as_bytes().len()
    );
    let compact = Baked::<4>::new(&lone_mesh(mesh.clone())).expect("bakes");
    let (scene, compact) = (baked.scene(), compact.scene());
    let detected = MeshTracer::new(&scene, 0, Simd::detect()).expect("a mesh");
    let portable = MeshTracer::new(&scene, 0, Simd::PORTABLE).expect("a mesh");
    let four = MeshTracer::new(&compact, 0, Simd::PORTABLE).expect("a mesh");

    let mut random = Random::new(1);
    let primary = pinhole(1024, 0.55);
    let mut stack = TraversalStack::EMPTY;
    let hits: Vec<_> = to_rays(&primary)
        .iter()
        .map(|ray| {
            detected
                .nearest(ray, &mut stack)
                .0
                .map(|hit| (hit.t, hit.triangle))
        })
        .collect();
    let sets = [
        ("zoom", pinhole(1024, 0.12)),
        ("incoherent", incoherent(&mesh, 1 << 20, &mut random)),
        (
            "bounce",
            bounce(&mesh, &primary, &hits, 1 << 20, &mut random),
        ),
        ("primary", primary),
    ];
    println!("Mrays/s, median of {REPEAT}, one thread");
    println!(
        "{:>10} {:>9} {:>9} {:>9} {:>9} {:>11}",
        "rays",
        Simd::detect().name(),
        "portable",
        "4 wide",
        "8x8 tile",
        "tile/single",
    );
    for (name, raw) in &sets {
        let rays = to_rays(raw);
        // Only pictures come in blocks.
        let tiles = if matches!(*name, "zoom" | "primary") {
            to_tiles(raw)
        } else {
            Vec::new()
        };
        let contenders: [&dyn Fn() -> u32; 4] = [
            &|| one_by_one(&detected, &rays),
            &|| one_by_one(&portable, &rays),
            &|| one_by_one(&four, &rays),
            &|| in_tiles(&detected, &tiles),
        ];
        let rate = interleaved(&contenders).map(|seconds| rays.len() as f64 / seconds / 1e6);
        print!("{name:>10}");
        print_row(&rate, !tiles.is_empty());
    }
}

fn print_row(rate: &[f64; 4], tiled: bool) {
    for (number, rate) in rate.iter().enumerate() {
        if number == 3 && !tiled {
            print!(" {:>9}", "-");
        } else {
            print!(" {rate:9.2}");
        }
    }
    if tiled {
        print!(" {:11.2}", rate[3] / rate[0]);
    }
    println!();
}

/// The median seconds of each contender, who take turns.
fn interleaved<const N: usize>(contenders: &[&dyn Fn() -> u32; N]) -> [f64; N] {
    let mut times = [[0.0; REPEAT]; N];
    for round in 0..REPEAT {
        for (contender, times) in contenders.iter().zip(&mut times) {
            let start = Instant::now();
            std::hint::black_box(contender());
            times[round] = start.elapsed().as_secs_f64();
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[REPEAT / 2]
    })
}

fn in_tiles(tracer: &MeshTracer<'_>, tiles: &[TileRays]) -> u32 {
    let mut stack = TraversalStack::EMPTY;
    tiles
        .iter()
        .map(|tile| {
            let (hits, _) = tracer.nearest_of_tile(tile, &mut stack);
            (0..64).filter(|i| hits.at(i % 8, i / 8).is_some()).count() as u32
        })
        .sum()
}

fn one_by_one<const W: usize>(tracer: &MeshTracer<'_, W>, rays: &[Ray]) -> u32
where
    Simd: shisen_core::Runs<W>,
{
    let mut stack = TraversalStack::EMPTY;
    rays.iter()
        .filter(|ray| tracer.nearest(ray, &mut stack).0.is_some())
        .count() as u32
}

/// Blocks of 8×8 pixels of a picture of 1024².
fn to_tiles(raw: &[RawRay]) -> Vec<TileRays> {
    (0..128 * 128)
        .map(|tile| {
            let first = tile / 128 * 8 * 1024 + tile % 128 * 8;
            let [a, b, c, ..] = raw[first];
            TileRays::new([a, b, c].into(), |column, row| {
                let [.., d, e, f] = raw[first + row * 1024 + column];
                [d, e, f].into()
            })
        })
        .collect()
}

fn to_rays(raw: &[RawRay]) -> Vec<Ray> {
    raw.iter()
        .map(|&[a, b, c, d, e, f]| Ray::new([a, b, c].into(), [d, e, f].into()).expect("finite"))
        .collect()
}
