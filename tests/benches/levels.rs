//! What polygon levels cost: rungs of a ladder beside meshes of as many faces
//! alone, and beside what was not built, one tree over the versions of several
//! rungs. `cargo bench -p shisen-tests --bench levels`, optionally with
//! `-- FILE.obj` for a mesh of one's own.
//!
//! The shared tree is as good as it could be: built like any other, and the
//! faces that a rung does not have cost nothing, since they are blanked out of
//! its leaves, and subtrees without any other out of its nodes.
//!
//! In the mixture each ray is of another rung than the one before it, so that
//! all rungs compete for the caches; it is measured beside the same rays rung
//! after rung, each on a mesh alone. The shared tree, which is but one, is not
//! charged for mixing.

use shisen::bake::{Baked, lone_mesh};
use shisen::mesh::TriangleMesh;
use shisen::simplify::{Ladder, PolygonLevels};
use shisen_core::Simd;
use shisen_core::scene::Scene;
use shisen_core::scene::format::{Header, INDEX, LEAF, LeafBlock, Mesh, Node, Table};
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TraversalStack};
use shisen_tests::meshes::normalised;
use shisen_tests::rays::{Random, RawRay, incoherent, pinhole};
use std::collections::HashSet;
use std::hint::black_box;
use std::mem::offset_of;
use std::path::Path;
use std::time::Instant;
use xxhash_rust::xxh32::xxh32;

const REPEAT: usize = 11;
const RUNGS: usize = 16;
/// How many rungs share a tree.
const GROUPS: [usize; 4] = [2, 4, 8, 16];

fn main() {
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mesh = file.map_or_else(shisen::quadruped::quadruped, |path| {
        shisen::import::load(Path::new(&path)).expect("a mesh file")
    });
    let mesh = normalised(mesh, 10.0);
    let levels = PolygonLevels::new(500..=u32::MAX, RUNGS as u32).expect("levels");
    let scene = lone_mesh(mesh.clone());
    let bake = || Baked::<8>::with_levels(&scene, &levels).expect("bakes");
    let times = sorted((0..REPEAT).map(|_| seconds(&mut || drop(bake()))));
    let ladder_time = seconds(&mut || drop(Ladder::new(&mesh, &levels)));
    let ladder = Ladder::new(&mesh, &levels).expect("a ladder");
    let baked = bake();
    let faces: Vec<usize> = ladder.rungs().iter().map(Vec::len).collect();
    println!(
        "{} versions of the triangles of {RUNGS} rungs, {} bytes, baked in {:.0} ms ({:.0} to \
         simplify); faces: {faces:?}",
        ladder.versions().triangles.len(),
        baked.as_bytes().len(),
        1e3 * times[REPEAT / 2],
        1e3 * ladder_time,
    );
    let sets = [
        ("zoom", to_rays(&pinhole(512, 0.12))),
        (
            "incoherent",
            to_rays(&incoherent(&mesh, 1 << 18, &mut Random::new(1))),
        ),
    ];
    let contenders = contenders(&ladder, &baked);
    let measured = sets.each_ref().map(|(name, rays)| {
        println!("tracing {name} rays");
        (fixed(&contenders, rays), mixed(&contenders, rays))
    });
    println!("time a ray, mesh alone = 1: geometric mean of all rungs, and mixed");
    println!(
        "{:>20} {:>8} {:>8} {:>10} {:>8} {:>14}",
        "", "zoom", "mixed", "incoherent", "mixed", "bytes of trees"
    );
    for (place, Contender { name, bytes, .. }) in contenders.iter().enumerate() {
        let [zoom, incoherent] = measured.each_ref().map(|(fixed, _)| fixed[place]);
        let [zoom_mixed, incoherent_mixed] = measured.each_ref().map(|(_, mixed)| mixed[place]);
        println!(
            "{name:>20} {zoom:8.3} {zoom_mixed:8.3} {incoherent:10.3} {incoherent_mixed:8.3} \
             {bytes:14}"
        );
    }
    let within = measured.iter().all(|(fixed, _)| fixed[LADDER] <= 1.05);
    println!("a rung costs at most 1.05 times its mesh alone: {within}");
}

/// A way to store the rungs.
struct Contender {
    name: String,
    /// Of all its trees.
    bytes: usize,
    /// For each rung a scene, and which of its meshes that rung is.
    rungs: Vec<(Baked, usize)>,
}

/// Where the meshes alone are among the contenders, and where the ladder is.
const ALONE: usize = 0;
const LADDER: usize = 1;

fn contenders(ladder: &Ladder<'_>, baked: &Baked) -> Vec<Contender> {
    let alone: Vec<Baked> = ladder.rungs().iter().map(|r| part(ladder, r).1).collect();
    let mut contenders = vec![
        Contender {
            name: "mesh alone".into(),
            bytes: alone.iter().map(size_of_trees).sum(),
            rungs: alone.into_iter().map(|baked| (baked, 0)).collect(),
        },
        Contender {
            name: "rung of the ladder".into(),
            bytes: size_of_trees(baked),
            rungs: (0..RUNGS).map(|rung| (baked.clone(), rung)).collect(),
        },
    ];
    contenders.extend(GROUPS.map(|size| {
        let mut bytes = 0;
        let mut rungs = Vec::new();
        for group in ladder.rungs().chunks(size) {
            let (versions, tree) = part(ladder, &group.concat());
            bytes += size_of_trees(&tree);
            rungs.extend(group.iter().map(|rung| {
                let alive: HashSet<u32> = rung.iter().copied().collect();
                let is_dead = |id: u32| !alive.contains(&versions[id as usize]);
                (blank(&tree, is_dead), 0)
            }));
        }
        let name = format!("tree of {size} rungs");
        Contender { name, bytes, rungs }
    }));
    contenders
}

/// Time of each contender by that of the meshes alone, where all rays are of
/// the same rung: the geometric mean of all rungs.
fn fixed(contenders: &[Contender], rays: &[Ray]) -> Vec<f64> {
    let mut sums = vec![0.0; contenders.len()];
    for rung in 0..RUNGS {
        let mut hits = HashSet::new();
        let ratios = in_turns(contenders.len(), |place| {
            let (scene, mesh) = &contenders[place].rungs[rung];
            let scene = scene.scene();
            let tracer = tracer(&scene, *mesh);
            seconds(&mut || {
                hits.insert(trace(&[tracer], rays.iter()));
            })
        });
        assert_eq!(hits.len(), 1, "all trees hold the same faces");
        for (sum, ratio) in sums.iter_mut().zip(ratios) {
            *sum += ratio.ln();
        }
    }
    sums.iter().map(|sum| (sum / RUNGS as f64).exp()).collect()
}

/// Time of each contender by that of the meshes alone, where no two rays in a
/// row are of the same rung. That of all but the ladder is the time of the
/// same rays rung after rung.
fn mixed(contenders: &[Contender], rays: &[Ray]) -> Vec<f64> {
    let ladder = contenders[LADDER].rungs[0].0.scene();
    let tracers: Vec<_> = (0..RUNGS).map(|rung| tracer(&ladder, rung)).collect();
    in_turns(contenders.len(), |place| {
        if place == LADDER {
            return seconds(&mut || {
                black_box(trace(&tracers, rays.iter()));
            });
        }
        let rungs = contenders[place].rungs.iter().enumerate();
        rungs
            .map(|(number, (scene, mesh))| {
                let scene = scene.scene();
                let tracer = tracer(&scene, *mesh);
                seconds(&mut || {
                    black_box(trace(&[tracer], rays.iter().skip(number).step_by(RUNGS)));
                })
            })
            .sum()
    })
}

/// Measures one contender after the other, again and again: the medians of
/// what each takes by what the meshes alone take in the same turn.
fn in_turns(contenders: usize, mut time: impl FnMut(usize) -> f64) -> Vec<f64> {
    let mut ratios = vec![Vec::new(); contenders];
    for _ in 0..REPEAT {
        let times: Vec<f64> = (0..contenders).map(&mut time).collect();
        for (ratios, time) in ratios.iter_mut().zip(&times) {
            ratios.push(time / times[ALONE]);
        }
    }
    let median = |ratios: Vec<f64>| sorted(ratios.into_iter())[REPEAT / 2];
    ratios.into_iter().map(median).collect()
}

fn tracer<'a>(scene: &'a Scene<'a, 8>, mesh: usize) -> MeshTracer<'a> {
    MeshTracer::new(scene, mesh, Simd::detect()).expect("a mesh")
}

/// Some versions, ascending and each once, and baked as a mesh.
fn part(ladder: &Ladder<'_>, triangles: &[u32]) -> (Vec<u32>, Baked) {
    let mut triangles = triangles.to_vec();
    triangles.sort_unstable();
    triangles.dedup();
    let mesh = TriangleMesh {
        triangles: triangles
            .iter()
            .map(|&t| ladder.versions().triangles[t as usize])
            .collect(),
        triangle_materials: Vec::new(),
        ..ladder.versions().clone()
    };
    (triangles, Baked::new(&lone_mesh(mesh)).expect("bakes"))
}

fn size_of_trees(baked: &Baked) -> usize {
    let (nodes, leaves, _) = baked.scene().sizes();
    nodes * size_of::<Node<8>>() + leaves * size_of::<LeafBlock<8>>()
}

/// A scene of one mesh without some of its triangles, in the same tree.
fn blank(baked: &Baked, is_dead: impl Fn(u32) -> bool) -> Baked {
    let mut bytes = baked.as_bytes().to_vec();
    let table = |field: usize| word(baked.as_bytes(), field + offset_of!(Table, offset)) as usize;
    let nodes = table(offset_of!(Header, nodes));
    let leaves = table(offset_of!(Header, leaves));
    let mesh = table(offset_of!(Header, meshes));
    let count = word(&bytes, offset_of!(Header, nodes) + offset_of!(Table, count)) as usize;
    let first = word(&bytes, offset_of!(Header, top_nodes)) as usize;
    let mut faces = 0;
    let mut is_empty = vec![true; count];
    // Children come after their parents.
    for number in (first..count).rev() {
        let node = nodes + number * size_of::<Node<8>>();
        for lane in 0..8 {
            let at = node + offset_of!(Node<8>, child) + 4 * lane;
            let child = word(&bytes, at);
            let dead = if child & LEAF != 0 {
                let leaf = leaves + (child & INDEX) as usize * size_of::<LeafBlock<8>>();
                let alive = blank_leaf(&mut bytes[leaf..], &is_dead);
                if alive > 0 {
                    faces += (child >> 28 & 7) + 1;
                }
                alive == 0
            } else {
                child == 0 || is_empty[child as usize]
            };
            if dead {
                set(&mut bytes, at, 0);
                for plane in 0..6 {
                    let empty = [f32::INFINITY, f32::NEG_INFINITY][plane % 2];
                    set(&mut bytes, node + 32 * plane + 4 * lane, empty.to_bits());
                }
            }
            is_empty[number] &= dead;
        }
    }
    set(&mut bytes, mesh + offset_of!(Mesh, faces), faces);
    let checksum = xxh32(&bytes[12..], 0);
    set(&mut bytes, offset_of!(Header, checksum), checksum);
    Baked::from_bytes(&bytes).expect("a scene")
}

/// Takes triangles out of a leaf; returns how many are left.
fn blank_leaf(leaf: &mut [u8], is_dead: impl Fn(u32) -> bool) -> usize {
    let mut alive = 0;
    for lane in 0..8 {
        let id = word(leaf, offset_of!(LeafBlock<8>, ids) + 4 * lane);
        if id == u32::MAX {
            continue;
        }
        if is_dead(id) {
            for coordinate in 0..9 {
                set(leaf, 32 * coordinate + 4 * lane, f32::NAN.to_bits());
            }
        } else {
            alive += 1;
        }
    }
    alive
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn set(bytes: &mut [u8], at: usize, word: u32) {
    bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
}

/// Hits and the sum of their distances, of rays by one tracer after the other.
fn trace<'r>(tracers: &[MeshTracer<'_>], rays: impl Iterator<Item = &'r Ray>) -> (usize, u64) {
    let mut stack = TraversalStack::EMPTY;
    let hits = rays
        .zip(tracers.iter().cycle())
        .filter_map(|(ray, tracer)| tracer.nearest(ray, &mut stack).0);
    hits.fold((0, 0), |(count, sum), hit| {
        (count + 1, sum + u64::from(hit.t.to_bits()))
    })
}

fn seconds(work: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn sorted(times: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    times
}

fn to_rays(raw: &[RawRay]) -> Vec<Ray> {
    raw.iter()
        .map(|&[a, b, c, d, e, f]| Ray::new([a, b, c].into(), [d, e, f].into()).expect("finite"))
        .collect()
}
