//! `shisen-evidence bench`: how fast it is.

pub(super) mod budget;
pub(super) mod fill;
pub(super) mod foveated;
pub(super) mod frames;
#[cfg(unix)]
pub(super) mod latency;
pub(super) mod motion;
pub(super) mod rays;
pub(super) mod spectrum;
pub(super) mod sweep;
pub(super) mod table2;

use clap::Subcommand;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print_text;
use shisen::cli::play::Prepared;

/// Measures speed
#[derive(Debug, Subcommand)]
pub(super) enum Bench {
    Rays(rays::Arguments),
    Motion(motion::Arguments),
    Table2(table2::Arguments),
    Sweep(sweep::Arguments),
    Fill(fill::Arguments),
    Foveated(foveated::Arguments),
    Spectrum(spectrum::Arguments),
    Budget(Box<budget::Arguments>),
    #[cfg(unix)]
    Latency(Box<latency::Arguments>),
}

pub(super) fn run(bench: &Bench) -> Result<(), Failure> {
    match bench {
        Bench::Rays(arguments) => rays::run(arguments),
        Bench::Motion(arguments) => motion::run(arguments),
        Bench::Table2(arguments) => table2::run(arguments),
        Bench::Sweep(arguments) => sweep::run(arguments),
        Bench::Fill(arguments) => fill::run(arguments),
        Bench::Foveated(arguments) => foveated::run(arguments),
        Bench::Spectrum(arguments) => spectrum::run(arguments),
        Bench::Budget(arguments) => budget::run(arguments),
        #[cfg(unix)]
        Bench::Latency(arguments) => latency::run(arguments),
    }
}

/// Prints a report: its object, or else its text.
pub(super) fn print(json: bool, report: &impl Serialize, text: &str) -> Result<(), Failure> {
    if !json {
        return print_text(text);
    }
    print_text(&serde_json::to_string(report).map_err(Failure::from_error)?)
}

/// What frames that follow a tracker show, and how they are rendered.
#[derive(Debug, Serialize, JsonSchema)]
struct Surroundings {
    /// The scene's letter or name, or the path as given.
    scene: String,
    /// The mesh of a built-in scene, or null.
    mesh: Option<String>,
    /// Pixels along each side of a wall whose file does not say.
    size: u32,
    /// Threads that trace.
    threads: usize,
    /// Instruction set that traces: avx2 or portable.
    simd: &'static str,
    /// What follows the gaze: off, paper, paper-ellipse or foveated.
    lod: &'static str,
}

impl Surroundings {
    fn new(prepared: &Prepared) -> Self {
        Self {
            scene: prepared.shown.scene.clone(),
            mesh: prepared.shown.mesh.clone(),
            size: prepared.arguments.room.size,
            threads: prepared.options.threads,
            simd: prepared.simd().name(),
            lod: prepared.arguments.lod.name(),
        }
    }
}
