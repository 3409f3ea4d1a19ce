//! Makes the budget sheet of a README: what the firmware takes, and its limits.
//!
//!     cargo run -p shisen-tests --bin budget -- LIMITS MEASURED README COMPILER
//!
//! LIMITS is `tests/firmware/limits.toml`, whose table `budget` has the limits; MEASURED has
//! a name and a number in each line, and the last line of a name counts; COMPILER is the
//! version that built the images. `tests/firmware/run` starts this.
//!
//! A row above its limit is a failure. With `SHISEN_REWRITE=1` the sheet is written into the
//! README. The figures depend on the compiler and the mesh, which the sheet names.

use shisen_tests::limits::limits;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;

/// An error's text.
type Wrong = String;

/// The rows: the name in both files, and the text in the sheet. Rows after the blank line may have
/// no limit, since they differ from run to run.
const ROWS: &str = "\
flash: Flash: one protocol, all effects but dispersion, bytes
flash_with_dispersion: The same with dispersion, bytes
ram: Static memory without the buffers of pixels and of the order of tiles, bytes
stack: Stack by the call graph, an interrupt included, bytes
primary_ray: Primary ray of scene A at full detail, before shading, mean of the front wall
primary_ray_alone: The same without a test of its block
primary_ray_that_hits: The same where it hits
primary_ray_that_misses: The same where it misses
shaded_hit: Shading of a hit with its rays to lights, without bounces
level_of_a_pixel: Level of a pixel, as the renderer chooses it in blocks
level_of_a_ray: Level of a single ray

stack_painted: Most stack used in test runs, bytes
record: Tracker record: decoding, clock, estimator
byte_to_gaze: From a record's last byte to the start of the next frame, tracker at 120 Hz
gaze_to_tile: From the start of that frame to its first 16×16 tile
latency_at_120_hz: From a record's last byte to that tile, tracker at 120 Hz
latency_at_1000_hz: The same, tracker at 1,000 Hz
restart: The same, where the eyes leap by more than 5° while a frame is rendered";

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

fn run(path: &str, measured: &str, readme: &str, compiler: &str) -> Result<String, Wrong> {
    let with_cow = std::env::var_os("SHISEN_COW").is_some();
    let mesh = if with_cow {
        "the paper's cow"
    } else {
        "the built-in quadruped"
    };
    let (sheet, above) = sheet(&limits(path, "budget")?, &read_measured(measured)?)?;
    let sheet = format!("{sheet}\nMeasured with {compiler} and {mesh}.");
    if !above.is_empty() {
        return Err(format!("above the limit: {}\n{sheet}", above.join(", ")));
    }
    if std::env::var("SHISEN_REWRITE").is_ok_and(|value| value == "1") {
        let text = read(readme)?;
        let parts = text.split_once(BEGIN).zip(text.split_once(END));
        let ((before, _), (_, after)) = parts.ok_or_else(|| format!("{readme} has no sheet"))?;
        let text = format!("{before}{BEGIN}\n{sheet}\n{END}{after}");
        std::fs::write(readme, text).map_err(|error| format!("{readme}: {error}"))?;
    }
    Ok(sheet)
}

fn read(path: &str) -> Result<String, Wrong> {
    std::fs::read_to_string(path).map_err(|error| format!("{path} cannot be read: {error}"))
}

fn read_measured(path: &str) -> Result<BTreeMap<String, u64>, Wrong> {
    let number = |line: &str| {
        let (name, number) = line.split_once(' ')?;
        Some((name.to_owned(), number.trim().parse().ok()?))
    };
    let text = read(path)?;
    let lines = text.lines();
    let named = lines
        .map(|line| number(line).ok_or_else(|| format!("{path}: `{line}` is no name and number")));
    named.collect()
}

/// Returns the sheet as text, and the names of the rows above their limits.
fn sheet<'r>(
    limits: &BTreeMap<String, u64>,
    measured: &BTreeMap<String, u64>,
) -> Result<(String, Vec<&'r str>), Wrong> {
    let mut text = String::from(
        "| In instructions, unless a row says bytes | Measured | Limit |\n|---|---:|---:|\n",
    );
    let (mut above, mut is_settled) = (Vec::new(), true);
    for row in ROWS.lines() {
        let Some((key, what)) = row.split_once(": ") else {
            is_settled = false;
            continue;
        };
        let found = *measured
            .get(key)
            .ok_or_else(|| format!("{key} was not measured"))?;
        let limit = limits.get(key).copied();
        if limit.is_some_and(|limit| found > limit) {
            above.push(key);
        }
        let limit = match limit {
            None if is_settled => return Err(format!("{key} has no limit")),
            limit => limit.map_or_else(|| "–".to_owned(), grouped),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {what} | {} | {limit} |", grouped(found));
    }
    Ok((text, above))
}

/// Writes a number in groups of three digits.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<_> = groups.map(|group| String::from_utf8_lossy(group)).collect();
    groups.join(",")
}
