//! `shisen-evidence tradeoff`: what every setting that trades error for time costs.

use super::bench;
use crate::selftest::Effort;
use crate::tradeoff::{self, Bench, Build, Report, Topic};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::arguments::source::{BUILT_IN_MESH, Told, load_mesh};
use shisen::cli::arguments::threads;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::picture_files::make_writable;
use shisen::cli::output::progress::Progress;
use shisen::files::Fault;
use shisen::files::write_atomically;
use shisen::scene::quadruped::quadruped;
use shisen_core::Simd;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Measures what accuracy costs in time: a page of charts
///
/// Renders the same work with many settings, in turns, and compares each with the
/// truth: how detail follows the gaze, dome masters by mirrors, wavelengths, the
/// steps of a frame, single precision, effects, how far ahead the gaze is predicted,
/// and the hard cases of `shisen-evidence selftest`. Writes tradeoff.html, which needs no
/// other file, and its numbers as tradeoff.csv and tradeoff.json. Times are medians of at
/// least three; run it on a machine that does nothing else. In full it takes ten minutes on
/// two processors (--only leaves sections out).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Small pictures and few settings, for less than a minute
    #[arg(long)]
    quick: bool,
    /// Measure these sections alone
    #[arg(long, value_name = "SECTION", value_parser = topic(), num_args = 1.., value_delimiter = ',')]
    only: Vec<Topic>,
    /// Mesh of the paper's scene: an OBJ, PLY or glTF file [default: a quadruped
    /// that is built in]
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// Threads to trace on [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Folder of the files; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A report and its files.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Written {
    #[serde(flatten)]
    report: Report,
    /// Path of the page.
    html: String,
    /// Path of the numbers as a table.
    csv: String,
    /// Path of this object.
    json: String,
}

fn topic() -> impl TypedValueParser<Value = Topic> {
    PossibleValuesParser::new(Topic::ALL.map(|topic| topic.id)).try_map(|id| {
        let mut all = Topic::ALL.into_iter();
        all.find(|topic| topic.id == id).ok_or("no such section")
    })
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mesh, mesh_name) = match &arguments.mesh {
        Some(path) => (
            load_mesh(path, &mut Told::default())?,
            path.display().to_string(),
        ),
        None => (quadruped(), BUILT_IN_MESH.to_owned()),
    };
    make_writable(&arguments.out)?;
    let available = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = arguments.threads.map_or_else(available, NonZeroUsize::get);
    let only = &arguments.only;
    let is_asked = |topic: &Topic| only.is_empty() || only.iter().any(|asked| asked.id == topic.id);
    let topics: Vec<Topic> = Topic::ALL.into_iter().filter(is_asked).collect();
    let start = Instant::now();
    let effort = if arguments.quick {
        Effort::Quick
    } else {
        Effort::Full
    };
    let progress = Progress::of_uneven_parts(arguments.quiet || arguments.json);
    let mut sections = Vec::new();
    for (number, topic) in topics.iter().enumerate() {
        let show = |share: f64| {
            let done = PARTS as f64 * (number as f64 + share) / topics.len() as f64;
            progress.show(done as usize, PARTS);
        };
        let bench = Bench {
            effort,
            threads,
            mesh: &mesh,
            progress: &show,
        };
        sections.push(topic.measure(&bench).map_err(Failure::from_error)?);
    }
    progress.finish();
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        quick: arguments.quick,
        threads,
        simd: Simd::detect().name().to_owned(),
        build: Build::this(),
        mesh: mesh_name,
        seconds: start.elapsed().as_secs_f64(),
        sections,
    };
    let written = write(report, &arguments.out)?;
    let choices = written.report.sections.iter();
    let choices = choices.map(|one| format!("{}: {}\n", one.title, one.choice));
    let text = choices.collect::<String>() + &written.html;
    bench::print(arguments.json, &written, &text)
}

const PARTS: usize = 1_000;

/// Writes all three files.
fn write(report: Report, folder: &Path) -> Result<Written, Failure> {
    let path = |ending: &str| folder.join(format!("tradeoff.{ending}"));
    let write = |ending: &str, text: &str| {
        let path = path(ending);
        write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(Fault::write(&path))
    };
    let html = tradeoff::html(&report).map_err(Failure::from_error)?;
    write("html", &html)?;
    write("csv", &tradeoff::csv(&report).map_err(Failure::from_error)?)?;
    let [html, csv, json] = ["html", "csv", "json"].map(|one| path(one).display().to_string());
    let written = Written {
        report,
        html,
        csv,
        json,
    };
    let text = serde_json::to_string_pretty(&written).map_err(Failure::from_error)?;
    write("json", &text)?;
    Ok(written)
}
