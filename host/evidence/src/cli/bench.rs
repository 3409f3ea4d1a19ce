//! `shisen-evidence bench`: how fast it is.

mod budget;
mod fill;
mod foveated;
mod frames;
#[cfg(unix)]
mod latency;
mod rays;
mod spectrum;
mod sweep;
mod table2;

use clap::Subcommand;
use shisen::cli::output::failure::Failure;

/// Measures speed
#[derive(Debug, Subcommand)]
pub(super) enum Bench {
    Rays(rays::Arguments),
    Table2(table2::Arguments),
    Sweep(sweep::Arguments),
    Fill(fill::Arguments),
    Foveated(foveated::Arguments),
    Spectrum(spectrum::Arguments),
    Budget(Box<budget::Arguments>),
    #[cfg(unix)]
    Latency(Box<latency::Arguments>),
}

/// Runs the command.
pub(super) fn run(bench: &Bench) -> Result<(), Failure> {
    match bench {
        Bench::Rays(arguments) => rays::run(arguments),
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
