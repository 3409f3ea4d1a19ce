//! `shisen-evidence tradeoff`: what every setting that trades error for time costs.

use crate::selftest::Effort;
use crate::tradeoff::{self, Bench, Build, Report, Topic};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use serde::Serialize;
use shisen::cli::arguments::source::{BUILT_IN_MESH, load_mesh};
use shisen::cli::arguments::threads;
use shisen::cli::output::failure::{Failure, Fault};
use shisen::cli::output::picture_files::make_writable;
use shisen::cli::output::print;
use shisen::cli::output::progress::Progress;
use shisen::files::write_atomically;
use shisen::scene::quadruped::quadruped;
use shisen_core::Simd;
use std::fmt;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Measures what accuracy costs in time: a page of charts
///
/// Renders the same work with many settings, in turns, and compares each with the
/// truth: how detail follows the gaze, dome masters by mirrors, wavelengths, the
/// steps of a frame, single precision, effects, how far ahead the gaze is predicted,
/// and the hard cases of `shisen-evidence selftest`. Writes tradeoff.html, which needs no
/// other file, and its numbers as tradeoff.csv and
/// tradeoff.json. Times are medians of at least three; run it on a machine that
/// does nothing else. In full it takes ten minutes on two processors (--only leaves
/// sections out).
///
/// With --json, what is in tradeoff.json, and the paths of the files. One object:
/// version, quick, threads, simd, build (profile, optimised: whether anything is chosen by
/// its times, commit, where `SHISEN_COMMIT` told
/// it to the build, and `cpu_features`), mesh, seconds (of the whole run), html, csv
/// and json (paths), sections: id, title, about, choice (a sentence) and comparisons:
/// id, title, about, choice, limit (error, of the first measure, that counts as
/// none, and because), `other_limit` (null, or another one, for which the choice names the
/// best setting, too), measures (id and label each) and points: series, name,
/// settings, errors (by measures; null where there is no such number), seconds,
/// spread (of the times, between their quartiles), steps (null where none are counted), `best_by_time` and `best_by_steps` (whether
/// the point is on the Pareto front of the first measure and time, or steps); and
/// `hard_cases`, in the section cases alone, as `shisen-evidence selftest --json` has them;
/// tiles, in the section budget alone: picture, x, y and percent (of the steps, with
/// which the tile is whole).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Small pictures and few settings, for less than a minute
    #[arg(long)]
    quick: bool,
    /// Measure these sections alone
    #[arg(long, value_name = "SECTION", value_enum, num_args = 1.., value_delimiter = ',')]
    only: Vec<TopicChoice>,
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

/// `--only`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct TopicChoice(Topic);

impl ValueEnum for TopicChoice {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [TopicChoice; Topic::ALL.len()] = {
            let mut all = [TopicChoice(Topic::Gaze); Topic::ALL.len()];
            let mut number = 0;
            while number < all.len() {
                all[number] = TopicChoice(Topic::ALL[number]);
                number += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.0.id()))
    }
}

/// What was measured, and where it is.
#[derive(Debug, Serialize)]
struct Written {
    #[serde(flatten)]
    report: Report,
    html: String,
    csv: String,
    json: String,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mesh, mesh_name) = match &arguments.mesh {
        Some(path) => (load_mesh(path)?, path.display().to_string()),
        None => (quadruped(), BUILT_IN_MESH.to_owned()),
    };
    make_writable(&arguments.out)?;
    let available = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = arguments.threads.map_or_else(available, NonZeroUsize::get);
    let topics: Vec<Topic> = Topic::ALL
        .into_iter()
        .filter(|&topic| arguments.only.is_empty() || arguments.only.contains(&TopicChoice(topic)))
        .collect();
    let start = Instant::now();
    let effort = if arguments.quick {
        Effort::Quick
    } else {
        Effort::Full
    };
    let progress = Progress::of_uneven_parts(arguments.quiet || arguments.json);
    let total = weight_of(&topics, effort);
    let mut sections = Vec::new();
    for (number, topic) in topics.iter().enumerate() {
        let show = |share: f64| {
            let own = share * weight_of(&[*topic], effort);
            let done = (weight_of(&topics[..number], effort) + own) / total;
            progress.show((PARTS * done) as usize, PARTS as usize);
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
    print(&write(report, &arguments.out)?, arguments.json)
}

/// Of the whole run, for the bar.
const PARTS: f64 = 1e3;

/// How much of the bar sections are: seconds of processor time on one machine, which need
/// not be those of another.
fn weight_of(topics: &[Topic], effort: Effort) -> f64 {
    let of = |topic: &Topic| match topic {
        Topic::Gaze => (7.6, 257.0),
        Topic::Capture => (3.0, 306.0),
        Topic::Spectrum => (21.7, 580.0),
        Topic::Budget => (1.1, 29.0),
        Topic::Precision => (0.3, 35.0),
        Topic::Effects => (5.6, 88.0),
        Topic::Latency => (2.5, 151.0),
        Topic::Cases => (1.3, 369.0),
    };
    let weights = topics.iter().map(of);
    weights
        .map(|(quick, full): (f64, f64)| match effort {
            Effort::Quick => quick,
            Effort::Full => full,
        })
        .sum()
}

/// Writes all three files.
fn write(report: Report, folder: &Path) -> Result<Written, Failure> {
    let path = |ending: &str| folder.join(format!("tradeoff.{ending}"));
    let write = |ending: &str, text: &str| {
        let path = path(ending);
        write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(Fault::write(&path))
    };
    write(
        "html",
        &tradeoff::html(&report).map_err(Failure::from_error)?,
    )?;
    write("csv", &tradeoff::csv(&report).map_err(Failure::from_error)?)?;
    let name = |ending: &str| path(ending).display().to_string();
    let written = Written {
        html: name("html"),
        csv: name("csv"),
        json: name("json"),
        report,
    };
    write(
        "json",
        &serde_json::to_string_pretty(&written).map_err(Failure::from_error)?,
    )?;
    Ok(written)
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for section in &self.report.sections {
            writeln!(f, "{}: {}", section.title, section.choice)?;
        }
        write!(f, "{}", self.html)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_have_as_much_of_the_bar_as_of_the_time() {
        for effort in [Effort::Quick, Effort::Full] {
            let each = Topic::ALL.map(|topic| weight_of(&[topic], effort));
            assert!(each.iter().all(|&weight| weight > 0.0), "{each:?}");
            let whole = weight_of(&Topic::ALL, effort);
            assert!((each.iter().sum::<f64>() - whole).abs() < 1e-9 * whole);
        }
        let of = |topic| weight_of(&[topic], Effort::Full);
        assert!(of(Topic::Capture) > 5.0 * of(Topic::Budget));
    }
}
