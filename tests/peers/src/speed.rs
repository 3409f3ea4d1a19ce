//! Rays a second, on the same rays in the same run.

use super::clock::{by, cpu_seconds};
use super::contender::{Contender, Opened, RaySet, Subject};
use super::measure::in_turns;
use super::rays::{Random, bounce, incoherent, pinhole};
use super::report::{Report, Row};
use shisen_peers_interface::{Hit, NONE, Task};
use std::convert::Infallible;

/// The largest distance of hits that count as the same, in units of the mesh, whose radius
/// is 10.
const SAME: f32 = 1.0e-4;

/// Pictures, with the tangents of half their fields: around the whole object, and close to it.
const FIELDS: [(&str, f64); 2] = [("primary", 0.55), ("zoom", 0.12)];

/// A contender with its tree and the hits that it found.
struct Runner<'s> {
    contender: &'s Contender,
    opened: Opened<'s>,
    hits: Vec<Hit>,
}

/// How many times as fast as a peer ours is, with one kind of rays on one mesh.
struct Ratio {
    task: Task,
    what: &'static str,
    peer: String,
    default: Option<f64>,
    native: Option<f64>,
}

/// Returns the four kinds of rays.
fn ray_sets(subject: &Subject, side: u32, seed: u64, ours: &Opened) -> Vec<RaySet> {
    let pictures = FIELDS.map(|(name, half_width)| RaySet {
        name,
        rays: pinhole(side, half_width),
        side: side as usize,
    });
    let mut random = Random::new(seed);
    let count = (side * side) as usize;
    let mut hits = vec![Hit::MISS; count];
    ours.trace(&pictures[0], &mut hits);
    let hits: Vec<_> = hits
        .iter()
        .map(|hit| (hit.triangle != NONE).then_some((hit.t, hit.triangle)))
        .collect();
    let others = [
        ("incoherent", incoherent(&subject.mesh, count, &mut random)),
        (
            "bounce",
            bounce(&subject.mesh, &pictures[0].rays, &hits, count, &mut random),
        ),
    ];
    let others = others.map(|(name, rays)| RaySet {
        name,
        rays,
        side: 0,
    });
    pictures.into_iter().chain(others).collect()
}

/// Measures all contenders on all meshes, and what they found.
pub fn measure(
    contenders: &[Contender],
    subjects: &[Subject],
    side: u32,
    rounds: usize,
    seed: u64,
    report: &mut Report,
) {
    let mut ratios = Vec::new();
    for subject in subjects {
        let mut runners = open(contenders, subject, report);
        let Some(first) = runners
            .iter()
            .position(|runner| runner.contender.is_default())
        else {
            continue;
        };
        let sets = ray_sets(subject, side, seed, &runners[first].opened);
        for set in &sets {
            for task in [Task::Nearest, Task::Any, Task::Picture] {
                if task != Task::Picture || set.side != 0 {
                    ratios.extend(one_kind(&mut runners, task, subject, set, rounds, report));
                }
            }
        }
    }
    // By part, in the order of their first rows.
    let parts: Vec<_> = report.rows.iter().map(|row| row.part).collect();
    let first = |part| parts.iter().position(|other| *other == part);
    report.rows.sort_by_key(|row| first(row.part));
    marks(&ratios, report);
}

/// Opens all contenders, and reports the times.
fn open<'s>(
    contenders: &'s [Contender],
    subject: &'s Subject,
    report: &mut Report,
) -> Vec<Runner<'s>> {
    let mut runners = Vec::new();
    for contender in contenders {
        let mut opened = None;
        let seconds = by(cpu_seconds, || opened = contender.open(subject));
        let Some(opened) = opened else {
            let Contender { name, mode, .. } = contender;
            report
                .failures
                .push(format!("{name} {mode}: no tree of {}", subject.name));
            continue;
        };
        // Ours was baked before.
        if !contender.is_ours() && contender.task == Task::Nearest {
            report.rows.push(Row {
                value: 1.0e3 * seconds,
                unit: "cpu ms",
                ..contender.row("build", &subject.name, "tree")
            });
        }
        runners.push(Runner {
            contender,
            opened,
            hits: Vec::new(),
        });
    }
    runners
}

// Longer than 80 lines: it measures, checks and reports each contender in turn.
fn one_kind(
    runners: &mut [Runner],
    task: Task,
    subject: &Subject,
    set: &RaySet,
    rounds: usize,
    report: &mut Report,
) -> Vec<Ratio> {
    // The reference: nearest hits by the default build.
    let truth = {
        let ours = |runner: &&mut Runner| {
            runner.contender.is_default() && runner.contender.task == Task::Nearest
        };
        let Some(runner) = runners.iter_mut().find(ours) else {
            return Vec::new();
        };
        let mut hits = vec![Hit::MISS; set.rays.len()];
        runner.opened.trace(set, &mut hits);
        hits
    };
    let mut runners: Vec<_> = runners
        .iter_mut()
        .filter(|runner| runner.contender.task == task)
        .collect();
    for runner in &mut runners {
        // Touches the pages.
        runner.hits = vec![Hit::MISS; set.rays.len()];
        runner.opened.trace(set, &mut runner.hits);
    }
    let places: Vec<usize> = (0..runners.len()).collect();
    let Ok(times) = in_turns(&places, rounds, |&place| {
        let Runner { opened, hits, .. } = &mut *runners[place];
        Ok::<_, Infallible>((by(cpu_seconds, || opened.trace(set, hits)), ()))
    });
    let ours = |default: bool| {
        let contenders = runners.iter().map(|runner| runner.contender);
        let mut numbered = contenders.zip(&times);
        let is = |one: &Contender| one.is_ours() && one.is_default() == default;
        numbered.find(|(one, _)| is(one)).map(|(_, time)| time)
    };
    let (default, native) = (ours(true), ours(false));
    let mut ratios = Vec::new();
    for (runner, theirs) in runners.iter().zip(&times) {
        let contender = runner.contender;
        let pairs = set.rays.iter().zip(truth.iter().zip(&runner.hits));
        let is_same = |&(ray, (a, b)): &(&[f32; 6], (&Hit, &Hit))| {
            if contender.is_ours() {
                is_exactly(task, a, b)
            } else {
                is_about(task, ray, a, b)
            }
        };
        let differ = pairs.filter(|pair| !is_same(pair)).count();
        if contender.is_ours() && differ != 0 {
            report.failures.push(format!(
                "{} {}: {differ} hits of {} {} rays are not those of single rays in the default build",
                contender.name, contender.mode, subject.name, set.name
            ));
        }
        let default_ratio = default.map(|ours| theirs.ratio_to(ours));
        let native_ratio = native.map(|ours| theirs.ratio_to(ours));
        let part = match task {
            Task::Nearest => "nearest hit, single rays",
            Task::Any => "any hit, single rays",
            Task::Picture => "nearest hit, pictures",
        };
        report.rows.push(Row {
            value: set.rays.len() as f64 / theirs.median() / 1.0e6,
            default_ratio,
            native_ratio,
            differ: Some(differ as u64),
            unit: "Mrays/s",
            rays: Some(set.rays.len() as u64),
            ..contender.row(part, &subject.name, set.name)
        });
        ratios.push(Ratio {
            task,
            what: set.name,
            peer: format!("{} {}", contender.name, contender.mode),
            default: default_ratio,
            native: native_ratio,
        });
    }
    ratios
}

/// Returns whether two paths of ours found the same, bit for bit.
fn is_exactly(task: Task, a: &Hit, b: &Hit) -> bool {
    match task {
        Task::Any => (a.triangle == NONE) == (b.triangle == NONE),
        Task::Nearest | Task::Picture => a.triangle == b.triangle && a.t.to_bits() == b.t.to_bits(),
    }
}

/// Returns whether two found the same triangle, or hits in about the same place.
fn is_about(task: Task, ray: &[f32; 6], a: &Hit, b: &Hit) -> bool {
    if task == Task::Any || a.triangle == NONE || b.triangle == NONE {
        return (a.triangle == NONE) == (b.triangle == NONE);
    }
    let length = ray[3..].iter().map(|c| c * c).sum::<f32>().sqrt();
    a.triangle == b.triangle || (a.t - b.t).abs() * length <= SAME
}

/// Sets the marks: geometric means of the meshes.
fn marks(ratios: &[Ratio], report: &mut Report) {
    let embree = "Embree robust";
    let tinybvh = "tinybvh BVH8_CPU, spatial splits";
    let native = "Shisen native build";
    for (task, peer, marks) in [
        (Task::Nearest, embree, [1.0; 4]),
        (Task::Nearest, tinybvh, [0.95, 0.95, 1.0, 1.0]),
        (Task::Nearest, native, [0.9; 4]),
        (Task::Any, native, [0.9; 4]),
        (Task::Picture, "Embree robust, packets of 16", [1.0; 4]),
        (Task::Any, embree, [1.0; 4]),
    ] {
        let kinds = ["primary", "zoom", "incoherent", "bounce"];
        let rays = match task {
            Task::Nearest => "rays",
            Task::Any => "rays, any hit",
            Task::Picture => "rays in tiles",
        };
        let is_native = peer == tinybvh;
        let build = if is_native { "native" } else { "default" };
        for (what, mark) in kinds.into_iter().zip(marks) {
            let is_own = |one: &&Ratio| one.task == task && one.what == what && one.peer == peer;
            let own = ratios.iter().filter(is_own);
            let own = own.filter_map(|one| if is_native { one.native } else { one.default });
            let logarithms: Vec<f64> = own.map(f64::ln).collect();
            if !logarithms.is_empty() {
                let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
                let what = format!("{what} {rays}: {build} build / {peer}");
                report.at_least(what, mean.exp(), mark);
            }
        }
    }
}
