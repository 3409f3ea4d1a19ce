//! Ours beside other ray tracers, in one run: see `run` beside this.

mod clock;
mod command;
mod contender;
#[path = "../../../host/evidence/src/measure.rs"]
#[allow(dead_code, reason = "shared with the evidence")]
mod measure;
#[path = "../../src/meshes.rs"]
#[allow(dead_code, reason = "shared with the tests")]
mod meshes;
mod povray;
mod product;
#[path = "../../src/rays.rs"]
#[allow(dead_code, reason = "shared with the tests")]
mod rays;
mod report;
mod speed;
#[path = "../../../host/evidence/src/table.rs"]
#[allow(dead_code, reason = "shared with the evidence")]
mod table;
mod watertight;

use clap::{Parser, ValueEnum};
use command::Shisen;
use contender::{Contender, Subject};
use report::{Missing, Report};
use shisen::scene::mesh::TriangleMesh;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Ours beside other ray tracers: rays a second and what hits differ
///
/// `run` builds what this needs and starts it. The exit code is 1 if a ray of ours is lost,
/// paths of ours differ, or something cannot be measured at all. Speed that misses its mark is
/// reported, and is no failure.
///
/// With --json, one object: processor, rounds, seed, rows,
/// marks, missing (peer and reason) and failures. A row has part, subject, what,
/// peer, mode, version, simd, value, unit, `default_ratio` and `native_ratio` (how many
/// times as fast as this row ours is, by build), differ (rays whose hits are not ours)
/// and rays; a mark has what, measured, mark, `at_least` and met. The tables go to
/// standard error then.
#[derive(Debug, Parser)]
struct Arguments {
    /// OBJ, PLY or glTF files; without, an animal and a sphere that are made
    #[arg(long, value_name = "FILE")]
    mesh: Vec<PathBuf>,
    /// Fewer rays and rounds
    #[arg(long)]
    quick: bool,
    /// Parts to measure
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART,…",
          default_values_t = Part::value_variants().to_vec())]
    only: Vec<Part>,
    /// Seed of random rays
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The folder for peers.csv, peers.json and pictures
    #[arg(long, value_name = "DIR", default_value = "shisen-out/peers")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Libraries of contenders
    #[arg(long, value_name = "FILE")]
    contenders: Vec<PathBuf>,
    /// The command shisen
    #[arg(long, value_name = "FILE", default_value = "shisen")]
    shisen: PathBuf,
    /// The command shisen-evidence
    #[arg(long, value_name = "FILE", default_value = "shisen-evidence")]
    evidence: PathBuf,
    /// The program povray; without, pictures are not compared
    #[arg(long, value_name = "FILE")]
    povray: Option<PathBuf>,
    /// A peer that is not there, and the reason
    #[arg(long, value_name = "WHO=WHY")]
    missing: Vec<String>,
}

/// A part of the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Rays a second.
    Rays,
    /// Rays lost inside closed meshes.
    Watertight,
    /// Two threads, checking a scene and baking one.
    Alone,
    /// Whole pictures, beside POV-Ray.
    Pictures,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(report) if report.failures.is_empty() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Returns the mesh of a file, with the file's name.
fn load(path: &Path) -> Result<(String, TriangleMesh), Box<dyn Error>> {
    let model = shisen::scene::import::load(path)
        .map_err(|error| format!("{}: {error}", path.display()))?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok((name.into_owned(), model.mesh))
}

fn run(arguments: &Arguments) -> Result<Report, Box<dyn Error>> {
    let meshes = if arguments.mesh.is_empty() {
        vec![
            ("animal".to_owned(), shisen::scene::quadruped::quadruped()),
            ("sphere".to_owned(), meshes::icosphere(5)),
        ]
    } else {
        let paths = arguments.mesh.iter();
        paths.map(|path| load(path)).collect::<Result<_, _>>()?
    };
    let subjects = meshes.into_iter();
    let subjects = subjects
        .map(|(name, mesh)| Subject::new(name, meshes::normalised(mesh, 10.0)))
        .collect::<Result<Vec<_>, _>>()?;
    let mut contenders = Vec::new();
    let mut report = Report {
        processor: processor(),
        rounds: if arguments.quick { 3 } else { 7 },
        seed: arguments.seed,
        ..Report::default()
    };
    for path in &arguments.contenders {
        match Contender::load(path) {
            Ok(loaded) => contenders.extend(loaded),
            Err(reason) => report.missing.push(Missing {
                peer: path.display().to_string(),
                reason: reason.to_string(),
            }),
        }
    }
    for missing in &arguments.missing {
        let (peer, reason) = missing.split_once('=').unwrap_or((missing, ""));
        report.missing.push(Missing {
            peer: peer.to_owned(),
            reason: reason.to_owned(),
        });
    }
    let asked = |part| arguments.only.contains(&part);
    std::fs::create_dir_all(&arguments.out)?;
    if asked(Part::Rays) {
        let side = if arguments.quick { 512 } else { 1024 };
        let rounds = report.rounds;
        speed::measure(
            &contenders,
            &subjects,
            side,
            rounds,
            arguments.seed,
            &mut report,
        );
    }
    if asked(Part::Watertight) {
        let count = if arguments.quick { 250_000 } else { 5_000_000 };
        watertight::measure(&contenders, count, arguments.seed, &mut report)?;
    }
    let ours = measure_ours(arguments, &subjects, &mut report);
    report.write_csv(&arguments.out.join("peers.csv"))?;
    let json = serde_json::to_string_pretty(&report)?;
    shisen::files::write_atomically(&arguments.out.join("peers.json"), |file| {
        file.write_all(json.as_bytes())
    })?;
    if arguments.json {
        eprint!("{}", report.text());
        println!("{json}");
    } else {
        print!("{}", report.text());
    }
    ours.map(|()| report)
}

/// Measures the parts that need no library of a peer.
fn measure_ours(
    arguments: &Arguments,
    subjects: &[Subject],
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let asked = |part| arguments.only.contains(&part);
    let [shisen, evidence] =
        [&arguments.shisen, &arguments.evidence].map(|path| Shisen(path.clone()));
    let folder = tempfile::tempdir()?;
    let out = std::path::absolute(&arguments.out)?;
    if asked(Part::Alone) {
        for subject in subjects {
            product::bake_and_check(subject, report)?;
        }
        if let Some(subject) = subjects.first() {
            let count = if arguments.quick { 1 << 18 } else { 1 << 20 };
            product::two_threads(&evidence, subject, count, folder.path(), report)?;
        }
    }
    if let (true, Some(povray), Some(subject)) =
        (asked(Part::Pictures), &arguments.povray, subjects.first())
    {
        let size = if arguments.quick { 512 } else { 2048 };
        povray::measure(&shisen, povray, subject, size, &out, report)?;
    }
    Ok(())
}

/// Returns the processor's name, where the system says it.
fn processor() -> String {
    let all = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = all.lines().find_map(|line| line.strip_prefix("model name"));
    let name = name.map_or("", |name| name.trim_start_matches(['\t', ' ', ':']));
    if name.is_empty() {
        std::env::consts::ARCH.to_owned()
    } else {
        name.to_owned()
    }
}
