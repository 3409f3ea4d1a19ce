//! Measurements of ours alone: two threads, checking a scene, baking one.

use super::clock::{cpu_median, cpu_seconds};
use super::command::Shisen;
use super::contender::{RaySet, Subject};
use super::rays::{Random, incoherent};
use super::report::{Report, Row};
use shisen::bake::simplify::PolygonLevels;
use shisen::bake::{BakeError, Baked, Layout};
use shisen::live::quantiles::median;
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::scene::Scene;
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::process::Stdio;
use std::time::Instant;

/// The default number of polygon levels.
const RUNGS: u32 = Layout::Fast.polygon_levels();

/// Baking has another mark above so many triangles.
const LARGE: usize = 20_000;

fn row(subject: &str, what: &str, value: f64, unit: &'static str) -> Row {
    Row {
        subject: subject.to_owned(),
        what: what.to_owned(),
        ..Row::of_ours("ours alone", value, unit)
    }
}

/// Bakes scene A with all its levels, and checks it.
pub fn bake_and_check(subject: &Subject, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let rounds = report.rounds;
    let scene = paper_scene(PaperScene::A, subject.mesh.clone())?;
    let faces = subject.mesh.triangles.len() as u32;
    let levels = PolygonLevels::new(PolygonLevels::FEWEST_FACES..=faces.max(500), RUNGS)?;
    let (mut walls, mut processors, mut baked) = (Vec::new(), Vec::new(), None);
    for _ in 0..rounds {
        let (wall, processor) = (Instant::now(), cpu_seconds());
        baked = Some(Baked::<8>::with_levels(&scene, &levels)?);
        walls.push(1.0e3 * wall.elapsed().as_secs_f64());
        processors.push(1.0e3 * (cpu_seconds() - processor));
    }
    let baked = baked.ok_or(BakeError::NoObjects)?;
    let bytes = baked.as_bytes();
    // Many times a turn: one check is too short for the clock.
    let times = 20;
    let check = cpu_median(rounds, || {
        for _ in 0..times {
            black_box(Scene::<8>::from_bytes(black_box(bytes)).is_ok());
        }
    }) / f64::from(times);
    let name = &subject.name;
    let (wall, processor) = (median(walls), median(processors));
    report.rows.extend([
        row(name, "bake, all threads", wall, "ms"),
        row(name, "bake", processor, "cpu ms"),
        row(name, "baked bytes", bytes.len() as f64, "bytes"),
        row(name, "check", 1.0e3 * check, "cpu ms"),
    ]);
    let gigabytes = 1.0e-9 * bytes.len() as f64 / check;
    report.at_least(format!("{name}: scene A checked, GB/s"), gigabytes, 1.0);
    let large = subject.mesh.triangles.len() > LARGE;
    if !large {
        report.at_most(format!("{name}: scene A checked, ms"), 1.0e3 * check, 5.0);
    }
    let mark = if large { 5000.0 } else { 150.0 };
    let what = format!("{name}: scene A baked with {RUNGS} levels, ms on all threads");
    report.at_most(what, wall, mark);
    Ok(())
}

/// Compares one process of two threads with two processes of one: incoherent rays, by wall
/// time.
pub fn two_threads(
    evidence: &Shisen,
    subject: &Subject,
    count: usize,
    folder: &Path,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let set = RaySet {
        name: "incoherent",
        rays: incoherent(&subject.mesh, count, &mut Random::new(report.seed)),
        side: 0,
    };
    let (mesh, rays) = (folder.join("mesh.obj"), folder.join("rays.bin"));
    let bytes: Vec<_> = set
        .rays
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    std::fs::write(&rays, bytes)?;
    subject.write_obj(&mesh)?;
    let repeat = report.rounds.to_string();
    let command = |threads: &str| {
        let mut command =
            evidence.command(["bench", "rays", "--repeat", &repeat, "--threads", threads]);
        command.arg("--mesh").arg(&mesh).arg("--rays").arg(&rays);
        command
    };
    let rate = |output: &[u8]| -> Result<f64, Box<dyn Error>> {
        let report: serde_json::Value = serde_json::from_slice(output)?;
        let rate = report["mrays_per_second"]["median"].as_f64();
        rate.ok_or_else(|| "bench rays says no rate".into())
    };
    let (mut together, mut apart, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..report.rounds {
        together.push(rate(&super::command::run(&mut command("2"))?.stdout)?);
        let start = || command("1").stdout(Stdio::piped()).spawn();
        let pair = [start()?, start()?];
        let mut sum = 0.0;
        for process in pair {
            sum += rate(&process.wait_with_output()?.stdout)?;
        }
        apart.push(sum);
        ratios.push(together[together.len() - 1] / sum);
    }
    let name = &subject.name;
    report.rows.extend([
        row(name, "two threads", median(together), "Mrays/s"),
        row(name, "two processes", median(apart), "Mrays/s"),
    ]);
    let what = format!("{name}, {} rays: two threads / two processes", set.name);
    report.at_least(what, median(ratios), 0.95);
    Ok(())
}
