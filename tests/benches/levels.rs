//! The cost of polygon levels: rungs of a ladder beside meshes of as many faces alone.
//! `cargo bench -p shisen-tests --bench levels`, optionally with `-- FILE.obj` for another mesh.
//!
//! In a mixture each ray is of a rung of its own, and all rungs compete for the caches; it is
//! measured beside the mean of the levels: the same rays rung after rung, each on a mesh alone.
//! "Neighbours" is the mixture of a viewer: the rows of a picture, whose level falls from the
//! middle to the sides from 1 to 0. "Mixed" is the worst one: each ray is of another rung than
//! the one before it. The neighbours are measured in tiles of 8×8, too, as a renderer sends them:
//! beside the same tiles on each mesh alone, by the share of their rays on that mesh.

use glam::Vec3;
use shisen::bake::simplify::{Ladder, PolygonLevels};
use shisen::bake::{Baked, lone_mesh};
use shisen::scene::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, LevelOfDetail, Outcome, Pixel, Renderer, Settings, TileJob, View, Workspace,
};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField, VisualFieldLimits};
use shisen_core::scene::Scene;
use shisen_core::scene::format::{LeafBlock, Node};
use shisen_core::shape::Ray;
use shisen_core::trace::{MeshTracer, TraversalStack};
use shisen_evidence::measure::{in_turns, timed};
use shisen_evidence::table::Table;
use shisen_tests::meshes::normalised;
use shisen_tests::rays::{Random, incoherent, pinhole, to_rays};
use shisen_tests::scenes::tile;
use std::collections::HashSet;
use std::convert::Infallible;
use std::hint::black_box;
use std::path::Path;

const REPEAT: usize = 11;
const RUNGS: usize = 16;
/// Pixels a side of the picture, and of the tiles.
const SIDE: u32 = 512;
const TILE: u32 = 8;
/// The tangent of half the picture's field.
const HALF_WIDTH: f64 = 0.12;

fn main() {
    let file = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    let mesh = file.map_or_else(shisen::scene::quadruped::quadruped, |path| {
        shisen::scene::import::load(Path::new(&path)).expect("a mesh file")
    });
    let mesh = normalised(mesh, 10.0);
    let levels = PolygonLevels::new(500..=u32::MAX, RUNGS as u32).expect("levels");
    let scene = lone_mesh(mesh.clone());
    let bake = || Baked::<8>::with_levels(&scene, &levels).expect("bakes");
    let bake_time = ratios_in_turns(1, |_| seconds(&mut || drop(bake()))).1;
    let (ladder_time, ladder) = timed(|| Ladder::new(&mesh, &levels).expect("a ladder"));
    let baked = bake();
    let faces: Vec<usize> = ladder.rungs().iter().map(Vec::len).collect();
    println!(
        "{} versions of the triangles of {RUNGS} rungs, {} bytes, baked in {:.0} ms ({:.0} to \
         simplify); faces: {faces:?}",
        ladder.versions().triangles.len(),
        baked.as_bytes().len(),
        1e3 * bake_time,
        1e3 * ladder_time,
    );
    let zoom = to_rays(&pinhole(SIDE, HALF_WIDTH));
    let incoherent = to_rays(&incoherent(&mesh, 1 << 18, &mut Random::new(1)));
    let view = view(&zoom);
    let lod = LevelOfDetail::new(gaze(&view));
    let neighbours = neighbours(&zoom, &lod.gaze);
    let changes = neighbours.windows(2).filter(|two| two[0].1 != two[1].1);
    println!(
        "of {} neighbours 1 in {:.0} is of another rung than the one before",
        neighbours.len(),
        neighbours.len() as f64 / changes.count() as f64
    );
    let contenders = contenders(&ladder, &baked);
    println!("tracing");
    let fixed = [&zoom, &incoherent].map(|rays| fixed(&contenders, rays));
    let mixed =
        [neighbours, in_turn(&zoom), in_turn(&incoherent)].map(|rays| mixed(&contenders, &rays));
    let rows: Vec<usize> = (0..contenders.len()).collect();
    let table = Table::new(&rows)
        .text("", |&row| contenders[row].name.to_owned())
        .number("zoom", 3, |&row| Some(fixed[0][row]))
        .number("neighbours", 3, |&row| Some(mixed[0][row]))
        .number("mixed", 3, |&row| Some(mixed[1][row]))
        .number("incoherent", 3, |&row| Some(fixed[1][row]))
        .number("mixed", 3, |&row| Some(mixed[2][row]))
        .count("bytes of trees", |&row| contenders[row].bytes as u64);
    println!("time a ray, mesh alone = 1: geometric mean of all rungs, and mixtures\n{table:#}");
    let tiles = tiles(&contenders, &view, lod);
    println!("neighbours in tiles, mean of the levels = 1: {tiles:.3}");
    let within = fixed.iter().all(|ratios| ratios[LADDER] <= 1.05);
    println!("a rung costs at most 1.05 times its mesh alone: {within}");
}

/// A way to store the rungs.
struct Contender {
    name: &'static str,
    /// Bytes of all its trees.
    bytes: usize,
    /// The scene and the mesh number of each rung.
    rungs: Vec<(Baked, usize)>,
}

/// The places of the meshes alone and of the ladder among the contenders.
const ALONE: usize = 0;
const LADDER: usize = 1;

fn contenders(ladder: &Ladder<'_>, baked: &Baked) -> Vec<Contender> {
    let alone: Vec<Baked> = ladder.rungs().iter().map(|r| part(ladder, r)).collect();
    vec![
        Contender {
            name: "mesh alone",
            bytes: alone.iter().map(size_of_trees).sum(),
            rungs: alone.into_iter().map(|baked| (baked, 0)).collect(),
        },
        Contender {
            name: "rung of the ladder",
            bytes: size_of_trees(baked),
            rungs: (0..RUNGS).map(|rung| (baked.clone(), rung)).collect(),
        },
    ]
}

/// The time of each contender over that of the meshes alone, with all rays of the same rung: the
/// geometric mean of all rungs.
fn fixed(contenders: &[Contender], rays: &[Ray]) -> Vec<f64> {
    let mut sums = vec![0.0; contenders.len()];
    for rung in 0..RUNGS {
        let mut hits = HashSet::new();
        let (ratios, _) = ratios_in_turns(contenders.len(), |place| {
            let (scene, mesh) = &contenders[place].rungs[rung];
            let scene = scene.scene();
            let tracer = tracer(&scene, *mesh);
            seconds(&mut || {
                hits.insert(trace(rays.iter().map(|ray| (ray, &tracer))));
            })
        });
        assert_eq!(hits.len(), 1, "both hold the same faces");
        for (sum, ratio) in sums.iter_mut().zip(ratios) {
            *sum += ratio.ln();
        }
    }
    sums.iter().map(|sum| (sum / RUNGS as f64).exp()).collect()
}

/// The time of each contender over that of the meshes alone, for rays with a rung each. The
/// ladder traces them in their order, the others rung after rung.
fn mixed(contenders: &[Contender], rays: &[(Ray, usize)]) -> Vec<f64> {
    let ladder = contenders[LADDER].rungs[0].0.scene();
    let tracers: Vec<_> = (0..RUNGS).map(|rung| tracer(&ladder, rung)).collect();
    let by_rung: Vec<Vec<Ray>> = (0..RUNGS)
        .map(|rung| {
            let of_rung = rays.iter().filter(|(_, own)| *own == rung);
            of_rung.map(|(ray, _)| *ray).collect()
        })
        .collect();
    let mut hits = HashSet::new();
    let (ratios, _) = ratios_in_turns(contenders.len(), |place| {
        let (mut count, mut sum) = (0, 0);
        let mut add = |(more, further)| {
            count += more;
            sum += further;
        };
        let time = if place == LADDER {
            let rays = || rays.iter().map(|(ray, rung)| (ray, &tracers[*rung]));
            seconds(&mut || add(trace(rays())))
        } else {
            let rungs = contenders[place].rungs.iter().zip(&by_rung);
            rungs
                .map(|((scene, mesh), rays)| {
                    let scene = scene.scene();
                    let tracer = tracer(&scene, *mesh);
                    seconds(&mut || add(trace(rays.iter().map(|ray| (ray, &tracer)))))
                })
                .sum()
        };
        hits.insert((count, sum));
        time
    });
    assert_eq!(hits.len(), 1, "both hold the same faces");
    ratios
}

/// Rays each of another rung than the one before it.
fn in_turn(rays: &[Ray]) -> Vec<(Ray, usize)> {
    rays.iter().copied().zip((0..RUNGS).cycle()).collect()
}

/// The rays of a picture that the gaze has traced, and the rung of each.
fn neighbours(picture: &[Ray], gaze: &Gaze) -> Vec<(Ray, usize)> {
    let mut rays = Vec::new();
    for ray in picture {
        let level = gaze.level(ray.direction()).expect("a direction");
        if level > 0.0 {
            let rung = ((1.0 - level) * (RUNGS - 1) as f32).round();
            rays.push((*ray, rung as usize));
        }
    }
    rays
}

/// A gaze at the middle of a picture: the innermost third is central, and the field ends at the
/// sides.
fn gaze(view: &View) -> Gaze {
    let middle = (SIDE - 1) as f32 / 2.0;
    let direction = view.direction(middle, middle).expect("a direction");
    let sight = LineOfSight::new(view.eye(), direction, Vec3::Y);
    let side = HALF_WIDTH.atan() as f32;
    let limits = VisualFieldLimits {
        central: side / 3.0,
        up: side,
        down: side,
        left: side,
        right: side,
    };
    let field = VisualField::new(limits, Boundary::Ellipse);
    Gaze::new(sight.expect("a line of sight"), field.expect("a field"))
}

/// The view whose pixels are the rays of a picture.
fn view(picture: &[Ray]) -> View {
    let direction = |column: u32, row: u32| picture[(row * SIDE + column) as usize].direction();
    let last = SIDE - 1;
    let first = direction(0, 0);
    let step = |corner: Vec3| (corner - first) / last as f32;
    let (column, row) = (step(direction(last, 0)), step(direction(0, last)));
    View::new(picture[0].origin(), first, column, row, [SIDE; 2]).expect("a view")
}

/// The time of the ladder over the mean of the levels, for a view in tiles.
fn tiles(contenders: &[Contender], view: &View, lod: LevelOfDetail) -> f64 {
    let renderer =
        |scene| Renderer::new(scene, Simd::detect(), Settings::default()).with_level_of_detail(lod);
    let ladder = renderer(contenders[LADDER].rungs[0].0.scene());
    let places = (0..SIDE).step_by(TILE as usize);
    let places = places
        .clone()
        .flat_map(|y| places.clone().map(move |x| (x, y)));
    // The tiles, and their rays on each rung.
    let tiles: Vec<_> = places
        .map(|(x, y)| {
            let mut rays = [0; RUNGS];
            for (x, y) in (y..y + TILE).flat_map(|y| (x..x + TILE).map(move |x| (x, y))) {
                if let Some(detail) = ladder.detail(view, x, y) {
                    rays[usize::from(detail.rung)] += 1;
                }
            }
            ((x, y), rays)
        })
        .filter(|(_, rays)| *rays != [0; RUNGS])
        .collect();
    let several = tiles.iter().filter(|(_, rays)| {
        let rungs = rays.iter().filter(|rays| **rays > 0);
        rungs.count() > 1
    });
    let (several, all) = (several.count(), tiles.len());
    println!("{several} of {all} tiles see several rungs");
    let (ratios, _) = ratios_in_turns(2, |place| {
        if place == LADDER {
            let times = tiles.iter().map(|&(at, _)| time_of_tile(&ladder, view, at));
            return times.sum();
        }
        let rungs = contenders[ALONE].rungs.iter().enumerate();
        rungs
            .map(|(rung, (scene, _))| {
                let alone = renderer(scene.scene());
                let tiles = tiles.iter().filter(|(_, rays)| rays[rung] > 0);
                let times = tiles.map(|&(at, rays)| {
                    let share = f64::from(rays[rung]) / f64::from(rays.iter().sum::<u32>());
                    share * time_of_tile(&alone, view, at)
                });
                times.sum::<f64>()
            })
            .sum()
    });
    ratios[LADDER]
}

fn time_of_tile(renderer: &Renderer<'_>, view: &View, (x, y): (u32, u32)) -> f64 {
    let tile = tile([x, y, TILE, TILE]);
    let mut pixels = [Pixel::default(); (TILE * TILE) as usize];
    let mut workspace = Workspace::new();
    let mut budget = Budget::UNLIMITED;
    let mut job = TileJob::new(tile);
    let time = seconds(&mut || {
        let outcome = job.render(renderer, view, &mut pixels, &mut budget, &mut workspace);
        assert_eq!(outcome, Ok(Outcome::Finished));
    });
    black_box(pixels);
    time
}

/// Times contenders in turns: the medians of their times over those of the meshes alone in the
/// same turn, and the median time of the first.
fn ratios_in_turns(contenders: usize, mut time: impl FnMut(usize) -> f64) -> (Vec<f64>, f64) {
    let places: Vec<usize> = (0..contenders).collect();
    let times = in_turns(&places, REPEAT, |&place| {
        Ok::<_, Infallible>((time(place), ()))
    });
    let times = times.expect("no contender fails");
    let ratios = times.iter().map(|one| one.ratio_to(&times[ALONE]));
    (ratios.collect(), times[ALONE].median())
}

fn tracer<'a>(scene: &'a Scene<'a, 8>, mesh: usize) -> MeshTracer<'a> {
    MeshTracer::new(scene, mesh, Simd::detect()).expect("a mesh")
}

/// Some triangles of all versions, baked as a mesh.
fn part(ladder: &Ladder<'_>, triangles: &[u32]) -> Baked {
    let mut triangles = triangles.to_vec();
    triangles.sort_unstable();
    let mesh = TriangleMesh {
        triangles: triangles
            .iter()
            .map(|&t| ladder.versions().triangles[t as usize])
            .collect(),
        triangle_materials: Vec::new(),
        ..ladder.versions().clone()
    };
    Baked::new(&lone_mesh(mesh)).expect("bakes")
}

fn size_of_trees(baked: &Baked) -> usize {
    let (nodes, leaves, _) = baked.scene().sizes();
    nodes * size_of::<Node<8>>() + leaves * size_of::<LeafBlock<8>>()
}

/// Hits and the sum of their distances, of rays each by its tracer.
fn trace<'r>(rays: impl Iterator<Item = (&'r Ray, &'r MeshTracer<'r>)>) -> (usize, u64) {
    let mut stack = TraversalStack::EMPTY;
    let hits = rays.filter_map(|(ray, tracer)| tracer.nearest(ray, &mut stack).0);
    hits.fold((0, 0), |(count, sum), hit| {
        (count + 1, sum + u64::from(hit.t.to_bits()))
    })
}

fn seconds(work: &mut dyn FnMut()) -> f64 {
    timed(work).0
}
