//! How the cost of ours grows with triangles, instances, lights, pixels and threads.

use super::clock::cpu_median;
use super::command::Shisen;
use super::contender::{Contender, RaySet, Subject};
use super::meshes::{normalised, torus};
use super::rays::{Random, incoherent, pinhole, to_rays};
use super::report::{Report, Row};
use glam::{DAffine3, DVec3};
use shisen::bake::Baked;
use shisen::live::quantiles::median;
use shisen::picture::chart::{Axis, Chart, Corner, Line, Names, Note};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Background, Object, Scene, Shape};
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::trace::{MeshTracer, Tracer, TraversalStack};
use shisen_peers_interface::{Hit, Task};
use std::error::Error;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;
use std::thread::available_parallelism;

struct Curve {
    name: &'static str,
    points: Vec<(f64, f64)>,
}

#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Pixels along the edge of a picture, and the root of the number of other rays.
    pub side: u32,
    pub quick: bool,
    pub rounds: usize,
}

/// Returns rays that see a mesh of radius 10, and rays from all around.
fn ray_sets(mesh: &TriangleMesh, side: u32, seed: u64) -> [RaySet; 2] {
    let count = (side * side) as usize;
    [
        RaySet {
            name: "primary",
            rays: pinhole(side, 0.55),
            side: side as usize,
        },
        RaySet {
            name: "incoherent",
            rays: incoherent(mesh, count, &mut Random::new(seed)),
            side: 0,
        },
    ]
}

/// Millions of rays a second, and steps a ray, of both kinds of rays.
struct Growth([Curve; 2], [Curve; 2]);

impl Growth {
    fn new() -> Self {
        let curve = |name| Curve {
            name,
            points: Vec::new(),
        };
        let [rates, steps] = [0; 2].map(|_| ["primary", "incoherent"].map(curve));
        Self(rates, steps)
    }

    /// Adds what rays took where there is so much of something.
    fn push(&mut self, kind: usize, at: f64, rays: usize, seconds: f64, steps: u64) {
        let rays = rays as f64;
        self.0[kind].points.push((at, 1.0e-6 * rays / seconds));
        self.1[kind].points.push((at, steps as f64 / rays));
    }

    fn add(
        &self,
        report: &mut Report,
        out: &Path,
        axis: (&'static str, &'static str),
        notes: Vec<Note>,
    ) -> Result<(), Box<dyn Error>> {
        let Self(rates, steps) = self;
        let rate = ("rays a second", "Mrays/s");
        add(report, out, axis, rate, rates, notes)?;
        add(
            report,
            out,
            axis,
            ("steps a ray", "steps"),
            steps,
            Vec::new(),
        )
    }
}

/// Measures against triangles of one mesh.
pub fn triangles(
    contenders: &[Contender],
    extent: Extent,
    out: &Path,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let default = contenders
        .iter()
        .find(|contender| contender.is_default() && contender.task == Task::Nearest)
        .ok_or("ours is not among the contenders")?;
    let mut growth = Growth::new();
    let mut sizes = Vec::new();
    for doubling in (0..=10).step_by(if extent.quick { 2 } else { 1 }) {
        // 1,024 to 1,048,576 triangles, twice as long around as across.
        let across = 16u32 << (doubling / 2);
        let around = (1u32 << (doubling + 9)) / across;
        let mesh = normalised(torus(around, across), 10.0);
        let sets = ray_sets(&mesh, extent.side, report.seed);
        let subject = Subject::new("torus", mesh)?;
        let count = subject.mesh.triangles.len() as f64;
        sizes.push((count, subject.baked.as_bytes().len() as f64));
        let opened = default.open(&subject).ok_or("ours has no tree")?;
        let scene = subject.baked.scene();
        let tracer = MeshTracer::new(&scene, 0, Simd::detect()).ok_or("no mesh")?;
        for (kind, set) in sets.iter().enumerate() {
            let mut hits = vec![Hit::MISS; set.rays.len()];
            opened.trace(set, &mut hits);
            let seconds = cpu_median(extent.rounds, || opened.trace(set, &mut hits));
            let mut stack = TraversalStack::EMPTY;
            let rays = to_rays(&set.rays);
            let steps = rays.iter().map(|ray| tracer.nearest(ray, &mut stack).1);
            growth.push(kind, count, rays.len(), seconds, steps.sum());
        }
    }
    for Curve { name, points } in &growth.1 {
        let what = format!(
            "{name} rays: steps at 1 M triangles / what a logarithm through the fewer says"
        );
        report.at_most(what, beyond_logarithm(points), 1.1);
    }
    let notes = cache_notes(&sizes, &report.caches, &growth.0[0].points);
    growth.add(report, out, ("triangles", "triangles of one mesh"), notes)
}

/// Returns the ratio of the last number to the one of a + b·ln x there, which is fitted by least
/// squares to the lower half of the places.
fn beyond_logarithm(points: &[(f64, f64)]) -> f64 {
    let half = &points[..points.len().div_ceil(2)];
    let count = half.len() as f64;
    let mean_x = half.iter().map(|(x, _)| x.ln()).sum::<f64>() / count;
    let mean_y = half.iter().map(|(_, y)| y).sum::<f64>() / count;
    let up: f64 = half
        .iter()
        .map(|(x, y)| (x.ln() - mean_x) * (y - mean_y))
        .sum();
    let across: f64 = half.iter().map(|(x, _)| (x.ln() - mean_x).powi(2)).sum();
    points.last().map_or(f64::NAN, |(x, y)| {
        y / (mean_y + up / across * (x.ln() - mean_x))
    })
}

/// Notes on a line where a baked mesh is as large as each cache.
fn cache_notes(sizes: &[(f64, f64)], caches: &[(u32, u64)], line: &[(f64, f64)]) -> Vec<Note> {
    let mut notes = Vec::new();
    for &(level, bytes) in caches {
        let crossing = sizes
            .windows(2)
            .zip(line.windows(2))
            .find(|(sizes, _)| (sizes[0].1..sizes[1].1).contains(&(bytes as f64)));
        if let Some((sizes, line)) = crossing {
            let part = (bytes as f64 / sizes[0].1).ln() / (sizes[1].1 / sizes[0].1).ln();
            let between = |a: f64, b: f64| a * (b / a).powf(part);
            notes.push(Note {
                at: (
                    between(sizes[0].0, sizes[1].0),
                    between(line[0].1, line[1].1),
                ),
                text: format!("| L{level} full, {} KiB", bytes / 1024),
                side: Corner::UpperRight,
            });
        }
    }
    notes
}

/// Measures against instances of one mesh.
pub fn instances(extent: Extent, out: &Path, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let mesh = normalised(shisen::scene::quadruped::quadruped(), 1.0);
    let mut growth = Growth::new();
    let places: &[u32] = if extent.quick {
        &[1, 3, 10]
    } else {
        &[1, 2, 3, 4, 5, 7, 10]
    };
    for &edge in places {
        // A cube of them, as large as one alone.
        let cell = 12.0 / f64::from(edge);
        let at = |i: u32| (f64::from(i) + 0.5) * cell - 6.0;
        let number = |i: u32| DVec3::new(at(i % edge), at(i / edge % edge), at(i / edge / edge));
        let object = |i| Object {
            shape: Shape::Mesh(0),
            material: None,
            world_from_object: DAffine3::from_translation(number(i))
                * DAffine3::from_rotation_y(f64::from(i))
                * DAffine3::from_scale(DVec3::splat(0.5 * cell)),
            casts_shadow: true,
            smooth: true,
        };
        let scene = Scene {
            objects: (0..edge * edge * edge).map(object).collect(),
            background: Background::uniform([0.0; 3]),
            ..shisen::bake::lone_mesh(mesh.clone())
        };
        let count = scene.objects.len() as f64;
        let baked = Baked::<8>::new(&scene)?;
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
        let around = normalised(torus(16, 16), 10.0);
        for (kind, set) in ray_sets(&around, extent.side, report.seed)
            .iter()
            .enumerate()
        {
            let rays = to_rays(&set.rays);
            let mut workspace = Workspace::new();
            let seconds = cpu_median(extent.rounds, || {
                workspace.statistics = Default::default();
                for ray in &rays {
                    let mut budget = Budget::UNLIMITED.clone();
                    std::hint::black_box(tracer.nearest(ray, &mut budget, &mut workspace));
                }
            });
            let steps = workspace.statistics.steps;
            growth.push(kind, count, rays.len(), seconds, steps);
        }
    }
    let axis = ("instances", "instances of one mesh");
    growth.add(report, out, axis, Vec::new())
}

/// Measures frames of scene A, or of its animal, against lights, pixels of a wall and threads.
pub fn frames(
    shisen: &Shisen,
    extent: Extent,
    folder: &Path,
    out: &Path,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let pictures = folder.join("frames");
    let pictures = pictures.to_string_lossy();
    // Millions of rays of all kinds a second, and seconds a frame.
    let frame = |arguments: &[String]| -> Result<(f64, f64), Box<dyn Error>> {
        let mut all = vec!["cave", "--eyes", "1", "--quiet", "--out", &pictures];
        all.extend(arguments.iter().map(String::as_str));
        let mut seconds = Vec::new();
        let mut rays = 0.0;
        for _ in 0..extent.rounds {
            let report = shisen.report(&all)?;
            seconds.push(report["seconds"].as_f64().ok_or("no seconds")?);
            let counts = report["rays"].as_object().ok_or("no rays")?;
            rays = counts.values().filter_map(serde_json::Value::as_f64).sum();
        }
        let seconds = median(seconds);
        Ok((1.0e-6 * rays / seconds, seconds))
    };
    let arguments = |words: &str| -> Vec<String> { words.split(' ').map(str::to_owned).collect() };
    let mut measure = |axis, places: &[usize], arguments: &dyn Fn(usize) -> Vec<String>| {
        let (mut rates, mut times) = (Vec::new(), Vec::new());
        for &place in places {
            let (rate, seconds) = frame(&arguments(place))?;
            rates.push((place as f64, rate));
            times.push((place as f64, 1.0e3 * seconds));
        }
        for (name, points, quantity) in [
            ("rays of all kinds", rates, ("rays a second", "Mrays/s")),
            ("a frame", times, ("time of a frame", "ms")),
        ] {
            let curves = [Curve { name, points }];
            add(report, out, axis, quantity, &curves, Vec::new())?;
        }
        Ok::<_, Box<dyn Error>>(())
    };
    let size = if extent.quick { "128" } else { "256" };
    let lights: &[usize] = if extent.quick {
        &[1, 4, 16]
    } else {
        &[1, 2, 4, 8, 16, 32, 64]
    };
    for &count in lights {
        std::fs::write(folder.join(format!("lights-{count}.toml")), lit_by(count))?;
    }
    measure(("lights", "point lights"), lights, &|count| {
        let scene = folder.join(format!("lights-{count}.toml"));
        let mut arguments = arguments(&format!("--threads 1 --size {size} --scene"));
        arguments.push(scene.to_string_lossy().into_owned());
        arguments
    })?;
    let edges: &[usize] = if extent.quick {
        &[64, 256]
    } else {
        &[64, 128, 256, 512, 1024]
    };
    measure(("pixels", "pixels along a wall's edge"), edges, &|edge| {
        arguments(&format!("--threads 1 --size {edge}"))
    })?;
    let most = available_parallelism().map_or(1, NonZeroUsize::get);
    let threads: Vec<_> = (1..=most)
        .filter(|n| n.is_power_of_two() || *n == most)
        .collect();
    // Long frames: a thread that is woken for its first one begins it late.
    let size = if extent.quick { "512" } else { "1024" };
    measure(("threads", "threads"), &threads, &|count| {
        arguments(&format!("--size {size} --threads {count}"))
    })
}

/// Returns an animal on a floor, with lights around it.
fn lit_by(lights: usize) -> String {
    let mut scene =
        "[meshes.animal]\nbuiltin = \"quadruped\"\n\n[meshes.floor]\nbuiltin = \"square\"\n\n\
         [[object]]\nmesh = \"animal\"\nnormalise = true\nscale = 2\nposition = [0, 0, -3]\n\n\
         [[object]]\nmesh = \"floor\"\nscale = 20\nposition = [0, -1, 0]\n"
            .to_owned();
    for light in 0..lights {
        let (sine, cosine) = (std::f64::consts::TAU * light as f64 / lights as f64).sin_cos();
        let bright = 1.0 / lights as f64;
        // Writing to a string does not fail.
        let _ = write!(
            scene,
            "\n[[light]]\ntype = \"point\"\nposition = [{}, 3, {}]\ncolour = [{bright}, {bright}, {bright}]\n",
            3.0 * cosine,
            3.0 * sine - 3.0
        );
    }
    scene
}

/// Adds rows, and writes a chart with both axes logarithmic.
fn add(
    report: &mut Report,
    out: &Path,
    (axis, label): (&'static str, &'static str),
    (quantity, unit): (&'static str, &'static str),
    curves: &[Curve],
    notes: Vec<Note>,
) -> Result<(), Box<dyn Error>> {
    for curve in curves {
        for &(at, value) in &curve.points {
            report.rows.push(Row {
                subject: at.to_string(),
                what: format!("{} by {axis}", curve.name),
                mode: quantity.to_owned(),
                ..Row::of_ours("how cost grows", value, unit)
            });
        }
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let scale = |name, label, number: fn(&(f64, f64)) -> f64| {
        let low = points().map(number).fold(f64::INFINITY, f64::min);
        let high = points().map(number).fold(0.0, f64::max);
        Axis {
            name,
            label,
            range: 0.8 * low..1.25 * high,
            logarithmic: true,
        }
    };
    let chart = Chart {
        title: format!("{quantity}, by {label}"),
        x: scale(axis, label, |point| point.0),
        y: scale(unit, unit, |point| point.1),
        lines: curves
            .iter()
            .enumerate()
            .map(|(colour, curve)| Line {
                name: curve.name.to_owned(),
                points: curve.points.iter().map(|&(x, y)| (x, Some(y))).collect(),
                colour,
                faint: false,
                dots: false,
            })
            .collect(),
        names: Names::In(Corner::LowerLeft),
        notes,
    };
    let name = format!("{axis}-{}.svg", unit.replace('/', "-per-"));
    chart.write_svg(&out.join(&name))?;
    report.charts.push(name);
    Ok(())
}
