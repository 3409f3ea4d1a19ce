//! Makes the budget sheets of a README: what the firmware and the C library take, and their limits.
//!
//!     cargo run -p shisen-tests --bin budget -- SHEET LIMITS MEASURED README COMPILER
//!
//! SHEET is `budget` or `library`, also the table of the limits in LIMITS,
//! `tests/firmware/limits.toml`; MEASURED has a name and a number in each line, and the last line
//! of a name counts; COMPILER is the version that built the images. `tests/firmware/run` and
//! `tests/capi/run` start this.
//!
//! A row above its limit is a failure. With `SHISEN_REWRITE=1` the sheet is written into the
//! README. The figures depend on the compiler and the mesh, which the sheet names.

use shisen_tests::limits::limits;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;

/// An error's text.
type Wrong = String;

/// The rows of the firmware: the name in both files, and the text in the sheet. Rows after the
/// blank line may have no limit, since they differ from run to run.
const FIRMWARE: &str = "\
flash: Flash: one protocol, all effects but dispersion, bytes
flash_with_dispersion: The same with dispersion, bytes
static: Static memory, bytes
static_with_dispersion: The same with dispersion, bytes
ram: Static memory without the buffers of pixels and of the order of tiles, bytes
stack: Stack by the call graph, an interrupt included, bytes
stack_with_dispersion: The same with dispersion, bytes
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

/// The rows of the C library.
const LIBRARY: &str = "\
library_flash: Flash: one protocol, all effects but dispersion, bytes
library_flash_of_all: Flash of all protocols, dispersion and functions, bytes
library_handles: Memory of the example's handles, which the caller gives, bytes
library_stack: Most stack used in a frame, bytes";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, limits, measured, readme, compiler] = arguments.as_slice() else {
        eprintln!("give: SHEET LIMITS MEASURED README COMPILER");
        return ExitCode::from(2);
    };
    match run(name, limits, measured, readme, compiler) {
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

fn run(
    name: &str,
    path: &str,
    measured: &str,
    readme: &str,
    compiler: &str,
) -> Result<String, Wrong> {
    let with_cow = std::env::var_os("SHISEN_COW").is_some();
    let (rows, mesh) = match name {
        "library" => (LIBRARY, ""),
        _ if with_cow => (FIRMWARE, " and the paper's cow"),
        _ => (FIRMWARE, " and the built-in quadruped"),
    };
    let (sheet, above) = sheet(rows, &limits(path, name)?, &read_measured(measured)?)?;
    let sheet = format!("{sheet}\nMeasured with {compiler}{mesh}.");
    if !above.is_empty() {
        return Err(format!("above the limit: {}\n{sheet}", above.join(", ")));
    }
    if std::env::var("SHISEN_REWRITE").is_ok_and(|value| value == "1") {
        let text = read(readme)?;
        let [begin, end] = [
            format!("<!-- {name} sheet: "),
            format!("<!-- end of the {name} sheet -->"),
        ];
        // The line that begins it says which command writes it.
        let found = text.split_once(&begin).and_then(|(before, rest)| {
            let (command, rest) = rest.split_once('\n')?;
            Some((before, command, rest.split_once(&end)?.1))
        });
        let (before, command, after) =
            found.ok_or_else(|| format!("{readme} has no sheet {name}"))?;
        let text = format!("{before}{begin}{command}\n{sheet}\n{end}{after}");
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
    rows: &'r str,
    limits: &BTreeMap<String, u64>,
    measured: &BTreeMap<String, u64>,
) -> Result<(String, Vec<&'r str>), Wrong> {
    let mut text = String::from(
        "| In instructions, unless a row says bytes | Measured | Limit |\n|---|---:|---:|\n",
    );
    let (mut above, mut is_settled) = (Vec::new(), true);
    for row in rows.lines() {
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
