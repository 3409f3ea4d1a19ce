//! Closest hits on one thread: this core beside `obvhs`, on the same rays,
//! interleaved in one run. `cargo bench -p shisen-tests --bench peers`,
//! optionally with `-- FILE.obj` for a mesh of one's own.

use obvhs::BvhBuildParams;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as PeerRay, RayHit};
use obvhs::triangle::Triangle as PeerTriangle;
use shisen::bake::{Baked, lone_mesh};
use shisen::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TileRays, TraversalStack};
use shisen_tests::meshes::{icosphere, normalised};
use shisen_tests::rays::{Random, RawRay, bounce, incoherent, pinhole};
use std::time::{Duration, Instant};

const REPEAT: usize = 7;

fn main() {
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mesh = file.map_or_else(|| icosphere(4), |path| read_obj(&path));
    let mesh = normalised(mesh, 10.0);
    println!("{} triangles", mesh.triangles.len());
    let start = Instant::now();
    let baked = Baked::<8>::new(&lone_mesh(mesh.clone())).expect("bakes");
    println!(
        "ours: baked in {:?}, {} bytes",
        start.elapsed(),
        baked.as_bytes().len()
    );
    let compact = Baked::<4>::new(&lone_mesh(mesh.clone())).expect("bakes");
    let (scene, compact) = (baked.scene(), compact.scene());
    let avx2 = MeshTracer::new(&scene, 0, Simd::detect()).expect("a mesh");
    let portable = MeshTracer::new(&scene, 0, Simd::PORTABLE).expect("a mesh");
    let four = MeshTracer::new(&compact, 0, Simd::PORTABLE).expect("a mesh");

    let triangles: Vec<PeerTriangle> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t.map(|i| mesh.positions[i as usize].into());
            PeerTriangle { v0, v1, v2 }
        })
        .collect();
    let mut build = Duration::ZERO;
    let peer = build_cwbvh_from_tris(&triangles, BvhBuildParams::very_slow_build(), &mut build);
    let peer_triangles: Vec<PeerTriangle> = peer
        .primitive_indices
        .iter()
        .map(|&i| triangles[i as usize])
        .collect();
    println!("obvhs: built in {build:?}");

    let mut random = Random::new(1);
    let primary = pinhole(1024, 0.55);
    let mut stack = TraversalStack::EMPTY;
    let hits: Vec<_> = to_rays(&primary)
        .iter()
        .map(|ray| {
            avx2.nearest(ray, &mut stack)
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
    println!("Mrays/s, median of {REPEAT}, one thread; ratio: ours / obvhs");
    for (name, raw) in &sets {
        let rays = to_rays(raw);
        let peer_rays: Vec<PeerRay> = raw
            .iter()
            .map(|&[a, b, c, d, e, f]| PeerRay::new_inf([a, b, c].into(), [d, e, f].into()))
            .collect();
        let tiles = matches!(*name, "zoom" | "primary").then(|| to_tiles(raw));
        let mut times = vec![Vec::new(); 5];
        let mut counts = [0u32; 5];
        for _ in 0..REPEAT {
            for (i, tracer) in [&avx2, &portable].into_iter().enumerate() {
                times[i].push(timed(|| counts[i] = ours(tracer, &rays)));
            }
            times[2].push(timed(|| counts[2] = ours(&four, &rays)));
            times[3].push(timed(|| {
                counts[3] = peer_rays
                    .iter()
                    .filter(|ray| {
                        let mut hit = RayHit::none();
                        peer.ray_traverse(**ray, &mut hit, |ray, id| {
                            peer_triangles[id].intersect(ray)
                        })
                    })
                    .count() as u32;
            }));
            if let Some(tiles) = &tiles {
                times[4].push(timed(|| {
                    let mut stack = TraversalStack::EMPTY;
                    counts[4] = tiles
                        .iter()
                        .map(|tile| {
                            let (hits, _) = avx2.nearest_of_tile(tile, &mut stack);
                            (0..64).filter(|i| hits.at(i % 8, i / 8).is_some()).count() as u32
                        })
                        .sum();
                }));
            }
        }
        let rate = |i: usize| {
            let mut sorted = times[i].clone();
            sorted.sort_by(f64::total_cmp);
            if sorted.is_empty() {
                return f64::NAN;
            }
            rays.len() as f64 / sorted[REPEAT / 2] / 1e6
        };
        println!(
            "{name:>10}: {} {:6.2}  portable {:6.2}  4 wide {:6.2}  obvhs {:6.2}  ratio {:.2}  tile {:6.2} ({:.2} of single) hits {counts:?}",
            Simd::detect().name(),
            rate(0),
            rate(1),
            rate(2),
            rate(3),
            rate(0) / rate(3),
            rate(4),
            rate(4) / rate(0),
        );
    }
}

fn ours<const W: usize>(tracer: &MeshTracer<'_, W>, rays: &[Ray]) -> u32
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

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn to_rays(raw: &[RawRay]) -> Vec<Ray> {
    raw.iter()
        .map(|&[a, b, c, d, e, f]| Ray::new([a, b, c].into(), [d, e, f].into()).expect("finite"))
        .collect()
}

fn read_obj(path: &str) -> TriangleMesh {
    let text = std::fs::read_to_string(path).expect("an OBJ file");
    let mut mesh = TriangleMesh::default();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["v", x, y, z, ..] => mesh.positions.push([x, y, z].map(|c| c.parse().unwrap())),
            ["f", a, b, c] => mesh
                .triangles
                .push([a, b, c].map(|i| i.split('/').next().unwrap().parse::<u32>().unwrap() - 1)),
            _ => {}
        }
    }
    mesh
}
