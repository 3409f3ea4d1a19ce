//! Closest hits on one thread by each path of the tracer, on the same rays, in turns in one run.
//! `cargo bench -p shisen-tests --bench paths`, optionally with `-- FILE.obj` for another mesh.

use shisen::bake::{Baked, lone_mesh};
use shisen_core::Simd;
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TileRays, TraversalStack};
use shisen_evidence::measure::{Timed, in_turns, timed};
use shisen_evidence::table::Table;
use shisen_tests::meshes::{icosphere, normalised};
use shisen_tests::rays::{Random, RawRay, bounce, incoherent, pinhole, to_rays};
use std::convert::Infallible;
use std::path::Path;

const REPEAT: usize = 7;

fn main() {
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mesh = file.map_or_else(
        || icosphere(4),
        |path| {
            shisen::scene::import::load(Path::new(&path))
                .expect("a mesh file")
                .mesh
        },
    );
    let mesh = normalised(mesh, 10.0);
    println!("{} triangles", mesh.triangles.len());
    let baked = Baked::<8>::new(&lone_mesh(mesh.clone())).expect("bakes");
    let compact = Baked::<4>::new(&lone_mesh(mesh.clone())).expect("bakes");
    let (scene, compact) = (baked.scene(), compact.scene());
    let detected = MeshTracer::new(&scene, 0, Simd::detect()).expect("a mesh");
    let portable = MeshTracer::new(&scene, 0, Simd::PORTABLE).expect("a mesh");
    let four = MeshTracer::new(&compact, 0, Simd::PORTABLE).expect("a mesh");

    let mut random = Random::new(1);
    let primary = pinhole(1024, 0.55);
    let mut stack = TraversalStack::EMPTY;
    let hit = |ray| detected.nearest(ray, &mut stack).0;
    let hits = to_rays(&primary);
    let hits = hits.iter().map(hit);
    let hits: Vec<_> = hits.map(|hit| Some((hit?.t, hit?.triangle))).collect();
    let sets = [
        ("zoom", pinhole(1024, 0.12)),
        ("incoherent", incoherent(&mesh, 1 << 20, &mut random)),
        (
            "bounce",
            bounce(&mesh, &primary, &hits, 1 << 20, &mut random),
        ),
        ("primary", primary),
    ];
    let columns = [Simd::detect().name(), "portable", "4 wide", "8x8 tile"];
    let mut rows = Vec::new();
    for (name, raw) in &sets {
        let rays = to_rays(raw);
        // Only pictures come in blocks.
        let tiles = if matches!(*name, "zoom" | "primary") {
            to_tiles(raw)
        } else {
            Vec::new()
        };
        let paths: [&dyn Fn() -> u32; 4] = [
            &|| one_by_one(&detected, &rays),
            &|| one_by_one(&portable, &rays),
            &|| one_by_one(&four, &rays),
            &|| in_tiles(&detected, &tiles),
        ];
        let times = in_turns(&paths, REPEAT, |path| Ok::<_, Infallible>(timed(path)));
        let times = times.expect("no path fails");
        let rate = |time: &Timed<u32>| rays.len() as f64 / time.median() / 1e6;
        let rates: Vec<f64> = times.iter().map(rate).collect();
        rows.push((*name, rates, !tiles.is_empty()));
    }
    let mut table = Table::new(&rows).text("rays", |row| row.0.to_owned());
    for (number, column) in columns.into_iter().enumerate() {
        table = table.number(column, 2, |(_, rates, is_tiled)| {
            (number < 3 || *is_tiled).then_some(rates[number])
        });
    }
    table = table.number("tile/single", 2, |(_, rates, is_tiled)| {
        is_tiled.then(|| rates[3] / rates[0])
    });
    println!("Mrays/s, median of {REPEAT}, one thread\n{table:#}");
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
