//! What accuracy costs: every setting that trades error for time, with both.
//!
//! A report has a section for each topic; a section has comparisons, whose points are
//! measured on the same work. A point is on its comparison's Pareto front where no other one
//! is as good in one of error and cost and better in the other. Times are medians of at least
//! three, taken in turns; steps are exact.

mod budget;
mod capture;
mod cases;
mod effects;
mod frames;
mod front;
mod gaze;
mod latency;
mod metrics;
mod page;
mod precision;
mod records;
mod spectrum;

pub use front::pareto_front;
pub use metrics::{PictureDifference, Quality, Ring, Sight};
pub(crate) use page::html;
pub(crate) use records::csv;

use crate::measure::{Timed, in_turns_while, timed};
use crate::selftest::{Effort, Row};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use shisen::picture::Picture;
use shisen::picture::chart::Chart;
use shisen::render::Options;
use shisen::scene::mesh::TriangleMesh;
use std::error::Error;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Topic {
    pub(crate) id: &'static str,
    measure: fn(&Bench<'_>) -> Result<Section, Cause>,
}

impl Topic {
    /// All topics, in the order of the report.
    pub(crate) const ALL: [Self; 8] = [
        Self::new("gaze", gaze::section),
        Self::new("capture", capture::section),
        Self::new("spectrum", spectrum::section),
        Self::new("budget", budget::section),
        Self::new("precision", precision::section),
        Self::new("effects", effects::section),
        Self::new("latency", latency::section),
        Self::new("cases", cases::section),
    ];

    const fn new(id: &'static str, measure: fn(&Bench<'_>) -> Result<Section, Cause>) -> Self {
        Self { id, measure }
    }

    /// Measures the topic.
    ///
    /// # Errors
    /// What keeps a frame from being rendered: memory, threads, a mesh that
    /// cannot be scaled or has no such polygon levels.
    pub(crate) fn measure(self, bench: &Bench<'_>) -> Result<Section, TradeoffError> {
        let section = self.id;
        (self.measure)(bench).map_err(|source| TradeoffError { section, source })
    }
}

#[derive(Debug, Error)]
#[error("the section \"{section}\" of the report cannot be measured")]
pub(crate) struct TradeoffError {
    section: &'static str,
    source: Cause,
}

type Cause = Box<dyn Error + Send + Sync>;

pub(crate) struct Bench<'b> {
    pub(crate) effort: Effort,
    pub(crate) threads: usize,
    pub(crate) mesh: &'b TriangleMesh,
    /// Receives the share of the section that is done, 0 to 1.
    pub(crate) progress: &'b (dyn Fn(f64) + Sync),
}

const MOST_ROUNDS: usize = 25;

impl Bench<'_> {
    fn options(&self) -> Options {
        Options {
            threads: self.threads,
            ..Options::default()
        }
    }

    /// Measures all ways in turns, several times each; `from` and `to` are the shares of the
    /// section that are done before and after it.
    fn in_turns<W, T>(
        &self,
        ways: &[W],
        (from, to): (f64, f64),
        mut run: impl FnMut(&W) -> Result<(f64, T), Cause>,
    ) -> Result<Vec<Timed<T>>, Cause> {
        let (least, patience) = self.effort.pick((3, 0.5), (5, 15.0));
        let start = Instant::now();
        // Short times are less sure: measured more often.
        let has_time = || start.elapsed().as_secs_f64() < patience;
        let goes_on = |round| round < least || (round < MOST_ROUNDS && has_time());
        let mut done = 0.0;
        in_turns_while(ways, goes_on, |way| {
            let found = run(way)?;
            done += 1.0;
            let share = f64::min(done / (least * ways.len()) as f64, 1.0);
            (self.progress)(from + (to - from) * share);
            Ok(found)
        })
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Report {
    /// The program's version.
    pub(crate) version: &'static str,
    /// Whether pictures were small and settings few.
    pub(crate) quick: bool,
    /// Threads that trace.
    pub(crate) threads: usize,
    /// Instruction set that traces: avx2 or portable.
    pub(crate) simd: String,
    /// How the program was built.
    pub(crate) build: Build,
    /// The mesh's file as given, or quadruped.
    pub(crate) mesh: String,
    /// Time of the whole run, seconds.
    pub(crate) seconds: f64,
    /// Sections, in the order of the page.
    pub(crate) sections: Vec<Section>,
}

/// What times depend on beside the machine's speed.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Build {
    /// Cargo's profile, and the level of optimisation.
    pub(crate) profile: String,
    /// Whether the program is optimised for speed, without the checks of development.
    /// Otherwise nothing is chosen by times.
    pub(crate) optimised: bool,
    /// `SHISEN_COMMIT` when the program was built, or null.
    pub(crate) commit: Option<&'static str>,
    /// What the processor has of sse2, avx, avx2, fma and avx512f.
    pub(crate) cpu_features: Vec<&'static str>,
}

impl Build {
    /// [`Build::optimised`] of this program.
    const OPTIMISED: bool =
        matches!(env!("SHISEN_OPT_LEVEL").as_bytes(), b"2" | b"3") && !cfg!(debug_assertions);

    pub(crate) fn this() -> Self {
        #[cfg(target_arch = "x86_64")]
        let features = [
            ("sse2", std::is_x86_feature_detected!("sse2")),
            ("avx", std::is_x86_feature_detected!("avx")),
            ("avx2", std::is_x86_feature_detected!("avx2")),
            ("fma", std::is_x86_feature_detected!("fma")),
            ("avx512f", std::is_x86_feature_detected!("avx512f")),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let features: [(&str, bool); 0] = [];
        let level = env!("SHISEN_OPT_LEVEL");
        let there = features.iter().filter(|(_, is_there)| *is_there);
        Self {
            profile: format!("{}, opt-level {level}", env!("SHISEN_PROFILE")),
            optimised: Self::OPTIMISED,
            commit: option_env!("SHISEN_COMMIT"),
            cpu_features: there.map(|(name, _)| *name).collect(),
        }
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Section {
    /// The name in files.
    pub(crate) id: &'static str,
    /// The heading on the page.
    pub(crate) title: &'static str,
    /// What is measured, and how.
    pub(crate) about: String,
    /// The setting to choose: a sentence, of the first comparison unless said otherwise.
    pub(crate) choice: String,
    /// Comparisons.
    pub(crate) comparisons: Vec<Comparison>,
    /// Errors without a price, in the section cases alone.
    pub(crate) hard_cases: Vec<Row>,
    /// The tiles of a frame, in the section budget alone.
    pub(crate) tiles: Vec<TilePrice>,
    #[serde(skip)]
    pictures: Vec<Figure>,
}

impl Section {
    fn new(
        id: &'static str,
        title: &'static str,
        about: impl Into<String>,
        comparisons: Vec<Comparison>,
    ) -> Self {
        let choice = comparisons.first().map(|first| first.choice.clone());
        Self {
            id,
            title,
            about: about.into(),
            choice: choice.unwrap_or_default(),
            comparisons,
            hard_cases: Vec::new(),
            tiles: Vec::new(),
            pictures: Vec::new(),
        }
    }
}

/// The steps that a tile of a frame takes.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct TilePrice {
    /// The picture of the frame: screen by screen, the left eye's first.
    pub(crate) picture: usize,
    /// Column of its first pixel.
    pub(crate) x: u32,
    /// Row of its first pixel.
    pub(crate) y: u32,
    /// The least measured share of the frame's steps with which the tile is whole.
    pub(crate) percent: u32,
}

/// A picture in linear light under its caption.
type Figure = (String, Picture);

/// Points that were measured on the same work, against the same truth.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Comparison {
    /// The name in files.
    pub(crate) id: &'static str,
    /// The heading on the page.
    pub(crate) title: &'static str,
    /// What is measured, and how.
    pub(crate) about: String,
    /// The kinds of a point's errors. Less of the first is better; the front is by it.
    pub(crate) measures: Vec<Measure>,
    /// The limit of the first measure that counts as no error.
    pub(crate) limit: Limit,
    /// Another limit, stricter or looser, for which the choice names the best setting, too; or
    /// null.
    pub(crate) other_limit: Option<Limit>,
    /// The setting to choose: a sentence that follows from the points.
    pub(crate) choice: String,
    /// Settings and what they cost.
    pub(crate) points: Vec<Point>,
    /// Charts beside the ones that every comparison has.
    #[serde(skip)]
    pub(crate) charts: Vec<Chart>,
    #[serde(skip)]
    pub(crate) logarithmic: bool,
}

/// An error up to which a setting is as good as the truth.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Limit {
    /// The error of the first measure.
    pub(crate) error: f64,
    /// Why it counts as none.
    pub(crate) because: &'static str,
}

const fn limit(error: f64, because: &'static str) -> Limit {
    Limit { error, because }
}

/// A kind of error.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct Measure {
    /// The name in files.
    pub(crate) id: &'static str,
    /// The name for people, with its unit.
    pub(crate) label: &'static str,
}

const fn measure(id: &'static str, label: &'static str) -> Measure {
    Measure { id, label }
}

#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Point {
    /// The group of settings that it belongs to.
    pub(crate) series: &'static str,
    /// Short; unique in its comparison.
    pub(crate) name: String,
    /// The settings by their names.
    pub(crate) settings: Map<String, Value>,
    /// The errors by the comparison's measures; null where there is no such number, as the
    /// signal-to-noise ratio of equal pictures.
    pub(crate) errors: Vec<Option<f64>>,
    /// Median time, seconds.
    pub(crate) seconds: f64,
    /// The time between the quartiles, seconds.
    pub(crate) spread: f64,
    /// Number of steps; null where none are counted.
    pub(crate) steps: Option<u64>,
    /// Whether no other point is as good in the first error and in time, and better in one.
    pub(crate) best_by_time: bool,
    /// Whether no other point is so by steps; false where none are counted.
    pub(crate) best_by_steps: bool,
}

impl Point {
    fn new(
        series: &'static str,
        name: impl Into<String>,
        settings: impl IntoIterator<Item = (&'static str, Value)>,
    ) -> Self {
        let settings = settings.into_iter();
        let settings = settings.map(|(key, value)| (key.to_owned(), value));
        Self {
            series,
            name: name.into(),
            settings: settings.collect(),
            errors: Vec::new(),
            seconds: 0.0,
            spread: 0.0,
            steps: None,
            best_by_time: false,
            best_by_steps: false,
        }
    }

    fn measured<T>(self, errors: Vec<Option<f64>>, time: &Timed<T>, steps: Option<u64>) -> Self {
        Self {
            errors,
            seconds: time.median(),
            spread: time.spread(),
            steps,
            ..self
        }
    }

    /// Returns the first error; infinity for no number.
    fn error(&self) -> f64 {
        let first = self.errors.first().copied().flatten();
        first.unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
fn quick_bench(mesh: &TriangleMesh) -> Bench<'_> {
    Bench {
        effort: Effort::Quick,
        threads: 1,
        mesh,
        progress: &|_| (),
    }
}
