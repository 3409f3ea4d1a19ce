//! What polygon levels cost: rungs of a ladder beside meshes of as many faces
//! alone, and beside what was not built, one tree over the versions of several
//! rungs. `cargo bench -p shisen-tests --bench levels`, optionally with
//! `-- FILE.obj` for a mesh of one's own.
//!
//! The shared tree is as good as it could be: built like any other, and the
//! faces that a rung does not have cost nothing, since they are blanked out of
//! its leaves, and subtrees without any other out of its nodes.

use shisen::bake::{Baked, lone_mesh};
use shisen::mesh::TriangleMesh;
use shisen::simplify::{Ladder, PolygonLevels};
use shisen_core::Simd;
use shisen_core::scene::format::{Header, INDEX, LEAF, LeafBlock, Mesh, Node, Table};
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TraversalStack};
use shisen_tests::meshes::normalised;
use shisen_tests::rays::{Random, RawRay, incoherent, pinhole};
use std::collections::HashSet;
use std::mem::offset_of;
use std::path::Path;
use std::time::Instant;
use xxhash_rust::xxh32::xxh32;

const REPEAT: usize = 7;
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
    // By set, then contender: sums of logarithms of times.
    let mut sums = [[0.0; 6]; 2];
    let mut tree_bytes = [0; 6];
    let shared: Vec<Vec<Baked>> = GROUPS
        .iter()
        .map(|&size| {
            let groups = ladder.rungs().chunks(size);
            groups
                .map(|rungs| part(&ladder, &rungs.concat()).1)
                .collect()
        })
        .collect();
    for (place, trees) in shared.iter().enumerate() {
        tree_bytes[2 + place] = trees.iter().map(size_of_trees).sum();
    }
    tree_bytes[1] = size_of_trees(&baked);
    for (number, rung) in ladder.rungs().iter().enumerate() {
        let alone = part(&ladder, rung).1;
        tree_bytes[0] += size_of_trees(&alone);
        let blanked: Vec<Baked> = GROUPS
            .iter()
            .zip(&shared)
            .map(|(&size, trees)| {
                let group = number / size;
                let rungs = &ladder.rungs()[group * size..(group + 1) * size];
                let versions = part(&ladder, &rungs.concat()).0;
                let alive: HashSet<u32> = rung.iter().copied().collect();
                blank(&trees[group], |id| !alive.contains(&versions[id as usize]))
            })
            .collect();
        let mut scenes = vec![(alone.scene(), 0), (baked.scene(), number)];
        scenes.extend(blanked.iter().map(|baked| (baked.scene(), 0)));
        for ((_, rays), sums) in sets.iter().zip(&mut sums) {
            let mut times = [const { Vec::new() }; 6];
            let mut hits = HashSet::new();
            for _ in 0..REPEAT {
                for ((scene, mesh), times) in scenes.iter().zip(&mut times) {
                    let tracer = MeshTracer::new(scene, *mesh, Simd::detect()).expect("a mesh");
                    times.push(seconds(&mut || {
                        hits.insert(trace(&tracer, rays));
                    }));
                }
            }
            assert_eq!(hits.len(), 1, "all trees hold the same faces");
            for (times, sum) in times.into_iter().zip(sums) {
                *sum += sorted(times.into_iter())[REPEAT / 2].ln();
            }
        }
    }
    println!("time a ray, geometric mean of all rungs; mesh alone = 1");
    println!(
        "{:>20} {:>8} {:>10} {:>14}",
        "", "zoom", "incoherent", "bytes of trees"
    );
    let names = ["mesh alone", "rung of the ladder"].map(String::from);
    let groups = GROUPS.map(|size| format!("tree of {size} rungs"));
    for (place, name) in names.iter().chain(&groups).enumerate() {
        let [zoom, incoherent] = sums.map(|s| ((s[place] - s[0]) / RUNGS as f64).exp());
        println!(
            "{name:>20} {zoom:8.3} {incoherent:10.3} {:14}",
            tree_bytes[place]
        );
    }
    let slower = sums.map(|s| ((s[1] - s[0]) / RUNGS as f64).exp() <= 1.05);
    println!(
        "a rung costs at most 1.05 times its mesh alone: {}",
        slower == [true; 2]
    );
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

/// Hits and the sum of their distances.
fn trace(tracer: &MeshTracer<'_>, rays: &[Ray]) -> (usize, u64) {
    let mut stack = TraversalStack::EMPTY;
    let hits = rays
        .iter()
        .filter_map(|ray| tracer.nearest(ray, &mut stack).0);
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
