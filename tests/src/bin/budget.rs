//! The budget sheet of a README: what the firmware takes beside what it may.
//!
//!     cargo run -p shisen-tests --bin budget -- LIMITS MEASURED README COMPILER
//!
//! LIMITS is `tests/firmware/limits.toml`, whose table `budget` has a limit for each
//! row; MEASURED has a name and a number a line; COMPILER is what the images were
//! built with. `tests/firmware/run` starts this.
//!
//! A row above its limit is a failure. With `SHISEN_REWRITE=1` the sheet is written into the
//! README. The figures depend on the compiler and the mesh, which the sheet names.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;

/// What is wrong, in words.
type Wrong = String;

/// A row of the sheet.
struct Row {
    /// Its name in both files.
    key: &'static str,
    /// What it is, for a reader.
    what: &'static str,
    /// Whether it must have a limit: it is the same in each run of an image.
    settled: bool,
}

const fn row(key: &'static str, what: &'static str) -> Row {
    Row {
        key,
        what,
        settled: true,
    }
}

const fn varying(key: &'static str, what: &'static str) -> Row {
    Row {
        settled: false,
        ..row(key, what)
    }
}

const ROWS: [Row; 18] = [
    row(
        "flash",
        "Flash: one protocol, all effects but dispersion, bytes",
    ),
    row("flash_with_dispersion", "The same with dispersion, bytes"),
    row(
        "ram",
        "Static memory without room for pixels and the order of tiles, bytes",
    ),
    row(
        "stack",
        "Stack by the call graph, an interrupt included, bytes",
    ),
    varying("stack_painted", "Stack that runs were seen to take, bytes"),
    row(
        "primary_ray",
        "Primary ray of scene A in full, before shading, mean of the front wall",
    ),
    row("primary_ray_alone", "The same without a test of its block"),
    row("primary_ray_that_hits", "The same where it hits"),
    row("primary_ray_that_misses", "The same where it misses"),
    row(
        "shaded_hit",
        "Shading of a hit with its rays to lights, without bounces",
    ),
    row(
        "level_of_a_pixel",
        "Level of a pixel, as the renderer chooses it in blocks",
    ),
    row("level_of_a_ray", "Level of a single ray"),
    varying("record", "Tracker record: decoding, clock, estimator"),
    varying(
        "byte_to_gaze",
        "Last byte of a record to its frame, whose turn it must be",
    ),
    varying(
        "gaze_to_tile",
        "From there to the first 16×16 tile that follows the gaze",
    ),
    varying("latency_at_120_hz", "Both together, tracker at 120 Hz"),
    varying("latency_at_1000_hz", "Both together, tracker at 1,000 Hz"),
    varying(
        "restart",
        "Both together, where the eyes leap by more than 5° while a frame is rendered",
    ),
];

const BEGIN: &str = "<!-- budget sheet: SHISEN_REWRITE=1 SHISEN_COW=cow.obj tests/firmware/run -->";
const END: &str = "<!-- end of the budget sheet -->";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [limits, measured, readme, compiler] = arguments.as_slice() else {
        eprintln!("give: LIMITS MEASURED README COMPILER");
        return ExitCode::from(2);
    };
    match run(limits, measured, readme, compiler) {
        Ok(sheet) => {
            println!("{sheet}");
            ExitCode::SUCCESS
        }
        Err(wrong) => {
            eprintln!("budget: {wrong}");
            ExitCode::FAILURE
        }
    }
}

fn run(limits: &str, measured: &str, readme: &str, compiler: &str) -> Result<String, Wrong> {
    let limits = read_limits(limits)?;
    let measured = read_measured(measured)?;
    let mesh = if std::env::var_os("SHISEN_COW").is_some() {
        "the paper's cow"
    } else {
        "the built-in quadruped"
    };
    let made_with = format!("Measured with {compiler} and {mesh}.");
    let sheet = sheet(&measured, &limits, &made_with)?;
    exceeded(&measured, &limits).map_err(|wrong| format!("{wrong}\n{sheet}"))?;
    if std::env::var("SHISEN_REWRITE").is_ok_and(|value| value == "1") {
        write(readme, &sheet)?;
    }
    Ok(sheet)
}

/// Puts the sheet in place of the one in a file.
fn write(readme: &str, sheet: &str) -> Result<(), Wrong> {
    let text = read(readme)?;
    let (before, rest) = text
        .split_once(BEGIN)
        .ok_or_else(|| format!("{readme} has no line {BEGIN}"))?;
    let (_, after) = rest
        .split_once(END)
        .ok_or_else(|| format!("{readme} has no line {END}"))?;
    let text = format!("{before}{BEGIN}\n{sheet}\n{END}{after}");
    std::fs::write(readme, text).map_err(|error| format!("{readme}: {error}"))
}

fn read(path: &str) -> Result<String, Wrong> {
    std::fs::read_to_string(path).map_err(|error| format!("{path} cannot be read: {error}"))
}

fn read_limits(path: &str) -> Result<BTreeMap<String, u64>, Wrong> {
    let all: toml::Table = read(path)?
        .parse()
        .map_err(|error| format!("{path}: {error}"))?;
    let budget = all.get("budget").and_then(toml::Value::as_table);
    let budget = budget.ok_or_else(|| format!("{path} has no table budget"))?;
    let limit = |(key, value): (&String, &toml::Value)| {
        let number = value
            .as_integer()
            .and_then(|number| u64::try_from(number).ok());
        let number = number.ok_or_else(|| format!("{path}: {key} is no number"))?;
        Ok((key.clone(), number))
    };
    budget.iter().map(limit).collect()
}

/// The last of each name counts.
fn read_measured(path: &str) -> Result<BTreeMap<String, u64>, Wrong> {
    let mut measured = BTreeMap::new();
    for line in read(path)?.lines() {
        let number = line
            .split_once(' ')
            .and_then(|(name, number)| Some((name.to_owned(), number.trim().parse().ok()?)));
        let (name, number) =
            number.ok_or_else(|| format!("{path}: `{line}` is no name and number"))?;
        measured.insert(name, number);
    }
    Ok(measured)
}

fn exceeded(measured: &BTreeMap<String, u64>, limits: &BTreeMap<String, u64>) -> Result<(), Wrong> {
    let is_beyond = |row: &&Row| {
        let limit = limits.get(row.key);
        limit.is_some_and(|limit| measured.get(row.key) > Some(limit))
    };
    let beyond = ROWS.iter().filter(is_beyond);
    let names: Vec<_> = beyond.map(|row| row.key).collect();
    if names.is_empty() {
        Ok(())
    } else {
        Err(format!("above the limit: {}", names.join(", ")))
    }
}

/// The sheet as it stands in the file.
fn sheet(
    measured: &BTreeMap<String, u64>,
    limits: &BTreeMap<String, u64>,
    made_with: &str,
) -> Result<String, Wrong> {
    let mut text = String::from(
        "| In instructions, if not said otherwise | Measured | Limit |\n|---|---:|---:|\n",
    );
    for Row { key, what, settled } in &ROWS {
        let found = measured
            .get(*key)
            .ok_or_else(|| format!("{key} was not measured"))?;
        let limit = limits.get(*key).map(|&limit| grouped(limit));
        let limit = match limit {
            None if *settled => return Err(format!("{key} has no limit")),
            limit => limit.unwrap_or_else(|| "–".to_owned()),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {what} | {} | {limit} |", grouped(*found));
    }
    let _ = write!(text, "\n{made_with}");
    Ok(text)
}

/// In groups of three digits.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<_> = groups.map(|group| String::from_utf8_lossy(group)).collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(value: u64) -> BTreeMap<String, u64> {
        ROWS.iter().map(|row| (row.key.to_owned(), value)).collect()
    }

    #[test]
    fn a_row_above_its_limit_is_named() {
        let (mut measured, limits) = (numbers(10), numbers(10));
        assert_eq!(exceeded(&measured, &limits), Ok(()));
        measured.insert("flash".to_owned(), 11);
        assert_eq!(
            exceeded(&measured, &limits),
            Err("above the limit: flash".to_owned())
        );
    }

    #[test]
    fn what_was_not_measured_is_no_row() {
        let mut measured = numbers(1);
        measured.remove("shaded_hit");
        let wrong = sheet(&measured, &numbers(1), "").unwrap_err();
        assert_eq!(wrong, "shaded_hit was not measured");
    }
}
