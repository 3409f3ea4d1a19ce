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

use crate::table::Table;
use clap::Subcommand;
use serde_json::Value;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print_text;

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

/// Prints a report: its object, or else its text.
pub(super) fn print(json: bool, object: &Value, text: &str) -> Result<(), Failure> {
    print_text(&if json {
        object.to_string()
    } else {
        text.to_owned()
    })
}

/// Adds numbers of objects to their table, each by its name, its path in the object, a factor
/// and its digits after the point.
fn numbers<'e>(table: Table<'e, Value>, fields: &[(&str, &str, f64, usize)]) -> Table<'e, Value> {
    fields
        .iter()
        .fold(table, |table, &(name, path, factor, digits)| {
            table.number(name, digits, |object| {
                Some(factor * object.pointer(path)?.as_f64()?)
            })
        })
}

fn list<'r>(report: &'r Value, key: &str) -> &'r [Value] {
    report[key].as_array().map_or(&[], Vec::as_slice)
}

fn text(object: &Value, key: &str) -> String {
    object[key].as_str().unwrap_or_default().to_owned()
}
