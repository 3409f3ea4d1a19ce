//! What accuracy costs: every setting that trades error for time, with both.
//!
//! A [`Report`] has a [`Section`] for each [`Topic`]; a section has
//! [`Comparison`]s, whose points are measured on the same work and can be held
//! against each other. Of the points of a comparison some are on its Pareto
//! front: no other is as good in one of error and cost and better in the other.
//! Times are medians of at least three, taken in turns; steps are exact.

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
mod spectrum;
mod table;

pub use front::pareto_front;
pub use metrics::{PictureDifference, Quality, Ring, Sight};
pub use page::html;
pub use table::csv;

use crate::selftest::{Effort, Row};
use serde::Serialize;
use serde_json::{Map, Value};
use shisen::live::quantiles::{median, quartiles};
use shisen::picture::Picture;
use shisen::picture::chart::Chart;
use shisen::render::Options;
use shisen::scene::mesh::TriangleMesh;
use std::error::Error;
use std::fmt;
use std::time::Instant;
use thiserror::Error;

/// What an error or a time is a price of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topic {
    /// Detail that follows the gaze.
    Gaze,
    /// Dome masters through a mirror.
    Capture,
    /// Wavelengths.
    Spectrum,
    /// Steps that a frame may take.
    Budget,
    /// Single precision.
    Precision,
    /// What scenes ask for.
    Effects,
    /// Where the viewer will look.
    Latency,
    /// Where single precision is not enough for the textbook's formulas.
    Cases,
}

impl Topic {
    /// All of them, in the order of the report.
    pub const ALL: [Self; 8] = [
        Self::Gaze,
        Self::Capture,
        Self::Spectrum,
        Self::Budget,
        Self::Precision,
        Self::Effects,
        Self::Latency,
        Self::Cases,
    ];

    /// As the command line and files have it.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Gaze => "gaze",
            Self::Capture => "capture",
            Self::Spectrum => "spectrum",
            Self::Budget => "budget",
            Self::Precision => "precision",
            Self::Effects => "effects",
            Self::Latency => "latency",
            Self::Cases => "cases",
        }
    }

    /// Measures it.
    ///
    /// # Errors
    /// What keeps a frame from being rendered: memory, threads, a mesh that
    /// cannot be scaled or has no such polygon levels.
    pub fn measure(self, bench: &Bench<'_>) -> Result<Section, TradeoffError> {
        let section = match self {
            Self::Gaze => gaze::section(bench),
            Self::Capture => capture::section(bench),
            Self::Spectrum => spectrum::section(bench),
            Self::Budget => budget::section(bench),
            Self::Precision => precision::section(bench),
            Self::Effects => effects::section(bench),
            Self::Latency => latency::section(bench),
            Self::Cases => Ok(cases::section(bench)),
        };
        section.map_err(|source| TradeoffError {
            section: self.id(),
            source,
        })
    }
}

/// Why a section could not be measured.
#[derive(Debug, Error)]
#[error("the section \"{section}\" of the report cannot be measured")]
pub struct TradeoffError {
    section: &'static str,
    source: Cause,
}

/// Whatever is wrong.
type Cause = Box<dyn Error + Send + Sync>;

/// What sections are measured with.
pub struct Bench<'b> {
    /// How much to measure.
    pub effort: Effort,
    /// Threads, 1 or more.
    pub threads: usize,
    /// That built-in scenes show.
    pub mesh: &'b TriangleMesh,
    /// Told what share of the section is done, 0 to 1.
    pub progress: &'b (dyn Fn(f64) + Sync),
}

impl fmt::Debug for Bench<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bench")
            .field("effort", &self.effort)
            .field("threads", &self.threads)
            .finish_non_exhaustive()
    }
}

impl Bench<'_> {
    /// As frames are rendered.
    fn options(&self) -> Options {
        Options {
            threads: self.threads,
            ..Options::default()
        }
    }

    /// Measures each way several times, all of them in turns: the times, and what
    /// the first one gave beside them. `share` is the part of
    /// the section that this is, from and to.
    fn in_turns<W, T>(
        &self,
        ways: &[W],
        (from, to): (f64, f64),
        mut run: impl FnMut(&W) -> Result<(f64, T), Cause>,
    ) -> Result<Vec<(Time, T)>, Cause> {
        let (least, patience) = self.effort.pick((3, 0.5), (5, 15.0));
        let start = Instant::now();
        let mut seconds = vec![Vec::new(); ways.len()];
        let mut first = Vec::new();
        let mut round = 0;
        // What is over soon is measured more often: short times are less sure.
        while round < least || (round < MOST_ROUNDS && start.elapsed().as_secs_f64() < patience) {
            for (number, way) in ways.iter().enumerate() {
                let (time, found) = run(way)?;
                seconds[number].push(time);
                if round == 0 {
                    first.push(found);
                }
                let done = (round * ways.len() + number + 1) as f64;
                let by_rounds = done / (least * ways.len()) as f64;
                let share = by_rounds.min(1.0);
                (self.progress)(from + (to - from) * share);
            }
            round += 1;
        }
        Ok(seconds.into_iter().map(Time::new).zip(first).collect())
    }
}

/// What several times of the same work come to: seconds.
#[derive(Debug, Clone, Copy)]
struct Time {
    median: f64,
    /// From the first quartile to the third.
    spread: f64,
}

impl Time {
    fn new(seconds: Vec<f64>) -> Self {
        let [low, high] = quartiles(seconds.clone());
        Self {
            median: median(seconds),
            spread: high - low,
        }
    }
}

/// How often anything is measured at most.
const MOST_ROUNDS: usize = 25;

/// Everything that was measured in one run.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Of the program.
    pub version: &'static str,
    /// Whether it was the short run.
    pub quick: bool,
    /// Threads.
    pub threads: usize,
    /// The instruction set.
    pub simd: String,
    /// Of the program and what it runs on.
    pub build: Build,
    /// What built-in scenes show.
    pub mesh: String,
    /// The whole run.
    pub seconds: f64,
    /// In the order of [`Topic::ALL`].
    pub sections: Vec<Section>,
}

/// What times depend on beside the machine's speed.
#[derive(Debug, Serialize)]
pub struct Build {
    /// Cargo's, and the level of optimisation.
    pub profile: String,
    /// Whether its times are those of a program in use: optimised for speed, and
    /// without the checks of one in development. Where not, nothing is chosen by them.
    pub optimised: bool,
    /// What `SHISEN_COMMIT` was when the program was built.
    pub commit: Option<&'static str>,
    /// Of the processor that runs it, as far as the program asks for them.
    pub cpu_features: Vec<&'static str>,
}

impl Build {
    /// [`Build::optimised`] of this program.
    const OPTIMISED: bool =
        matches!(env!("SHISEN_OPT_LEVEL").as_bytes(), b"2" | b"3") && !cfg!(debug_assertions);

    /// Of this program, here.
    pub fn this() -> Self {
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
        Self {
            profile: format!("{}, opt-level {level}", env!("SHISEN_PROFILE")),
            optimised: Self::OPTIMISED,
            commit: option_env!("SHISEN_COMMIT"),
            cpu_features: features
                .iter()
                .filter(|one| one.1)
                .map(|one| one.0)
                .collect(),
        }
    }
}

/// The price of one kind of accuracy.
#[derive(Debug, Serialize)]
pub struct Section {
    /// As [`Topic::id`].
    pub id: &'static str,
    /// For people.
    pub title: &'static str,
    /// What was measured, and how: a paragraph.
    pub about: String,
    /// What to choose: that of its first comparison.
    pub choice: String,
    /// The most important one first.
    pub comparisons: Vec<Comparison>,
    /// What has an error but no price: of [`Topic::Cases`] alone.
    pub hard_cases: Vec<Row>,
    /// Which parts of a frame pay: of [`Topic::Budget`] alone.
    pub tiles: Vec<TilePrice>,
    /// What numbers do not show.
    #[serde(skip)]
    pub pictures: Vec<Figure>,
}

impl Section {
    fn new(topic: Topic, title: &'static str, about: String, of: Vec<Comparison>) -> Self {
        let choice = of.first().map(|first| first.choice.clone());
        Self {
            id: topic.id(),
            title,
            about,
            choice: choice.unwrap_or_default(),
            comparisons: of,
            hard_cases: Vec::new(),
            tiles: Vec::new(),
            pictures: Vec::new(),
        }
    }
}

/// What a tile of a frame takes to be whole.
#[derive(Debug, Clone, Serialize)]
pub struct TilePrice {
    /// Of the frame: screen by screen, the left eye's first.
    pub picture: usize,
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// The least of the measured shares of the steps that the frame needs with
    /// which the tile shows all that it should.
    pub percent: u32,
}

/// A picture and what it shows.
#[derive(Debug)]
pub struct Figure {
    /// Under it.
    pub caption: String,
    /// Linear light.
    pub picture: Picture,
}

/// Points that were measured on the same work, against the same truth.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Unique in its section.
    pub id: &'static str,
    /// For people.
    pub title: &'static str,
    /// What is compared with what: a paragraph.
    pub about: String,
    /// What [`Point::errors`] are, in their order; the first is the one that the
    /// front is by, and less of it is better.
    pub measures: Vec<Measure>,
    /// What counts as none of the first measure, and why.
    pub limit: Limit,
    /// Another limit, stricter or looser, for which the choice names the best, too.
    pub other_limit: Option<Limit>,
    /// What to choose: a sentence that follows from the points.
    pub choice: String,
    /// In the order in which they were asked for.
    pub points: Vec<Point>,
    /// Beside the ones that every comparison has.
    #[serde(skip)]
    pub charts: Vec<Chart>,
    /// Whether charts show errors by their logarithm.
    #[serde(skip)]
    pub logarithmic: bool,
}

/// An error up to which a setting is as good as the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Limit {
    /// Of the first measure.
    pub error: f64,
    /// Why.
    pub because: &'static str,
}

/// A kind of error.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Measure {
    /// In files.
    pub id: &'static str,
    /// For people, with its unit.
    pub label: &'static str,
}

const fn measure(id: &'static str, label: &'static str) -> Measure {
    Measure { id, label }
}

/// A setting: how far off it is, and what it costs.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Which settings go together.
    pub series: &'static str,
    /// Short; unique in its comparison.
    pub name: String,
    /// What was set, by name.
    pub settings: Map<String, Value>,
    /// By [`Comparison::measures`]; none where there is no such number, as the
    /// signal-to-noise ratio of equal pictures.
    pub errors: Vec<Option<f64>>,
    /// Median wall-clock time.
    pub seconds: f64,
    /// Of the times that it is the median of, from the first quartile to the
    /// third: seconds.
    pub spread: f64,
    /// The error of each of several details, the same ones of all points, which tell how
    /// much of a difference is chance; none where chance has no part in it.
    #[serde(skip)]
    pub of_details: Vec<f64>,
    /// Exact, where steps are counted.
    pub steps: Option<u64>,
    /// Whether it is on the front of error and time.
    pub best_by_time: bool,
    /// Whether it is on the front of error and steps.
    pub best_by_steps: bool,
}

impl Point {
    fn new(
        series: &'static str,
        name: impl Into<String>,
        settings: impl IntoIterator<Item = (&'static str, Value)>,
    ) -> Self {
        let settings = settings.into_iter();
        Self {
            series,
            name: name.into(),
            settings: settings
                .map(|(key, value)| (key.to_owned(), value))
                .collect(),
            errors: Vec::new(),
            seconds: 0.0,
            spread: 0.0,
            steps: None,
            of_details: Vec::new(),
            best_by_time: false,
            best_by_steps: false,
        }
    }

    /// By the measure that the front is by.
    fn error(&self) -> f64 {
        self.errors
            .first()
            .copied()
            .flatten()
            .unwrap_or(f64::INFINITY)
    }
}

/// How long something takes, with what it gives.
fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let found = run();
    (start.elapsed().as_secs_f64(), found)
}
