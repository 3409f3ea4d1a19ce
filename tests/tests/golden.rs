//! Results of the commands, held to the bits that they had: pictures, blobs, tables, tracker
//! samples and reports without times, as hashes in `golden.txt`.
//!
//! `SHISEN_REWRITE=1 cargo test -p shisen-tests --test all golden` writes the file anew: do it
//! only for a change that means to change results, in a commit of its own.

use serde_json::Value;
use shisen_tests::command::{evidence, shisen};
use shisen_tests::meshes::write_ball;
use shisen_tests::png_file::PngFile;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// Keys of a report whose values are times, their ratios, or the machine's.
const UNSTEADY: &[&str] = &[
    "bookkeeping",
    "each",
    "mean_time",
    "ratio",
    "mrays_per_second",
    "same_error",
    "simd",
    "speedup",
    "threads",
    "time_ratio",
    "worst_time",
];

fn is_unsteady(key: &str) -> bool {
    UNSTEADY.contains(&key) || key.contains("seconds") || key.ends_with("_ms")
}

fn without_times(value: Value) -> Value {
    match value {
        Value::Object(object) => object
            .into_iter()
            .filter(|(key, _)| !is_unsteady(key))
            .map(|(key, value)| (key, without_times(value)))
            .collect(),
        Value::Array(values) => values.into_iter().map(without_times).collect(),
        other => other,
    }
}

/// Returns the hash of a file's content: of a picture its pixels, of JSON lines what is no time.
fn hash_of(name: &str, bytes: &[u8]) -> u64 {
    let mut hasher = Xxh3::new();
    if Path::new(name)
        .extension()
        .is_some_and(|kind| kind == "png")
    {
        let picture = PngFile::decode(bytes);
        let form = (picture.width, picture.height, picture.channels);
        hasher.update(format!("({}, {}, {:?}8)", form.0, form.1, form.2).as_bytes());
        hasher.update(&picture.bytes);
    } else {
        match std::str::from_utf8(bytes) {
            Ok(text) => {
                for line in text.lines() {
                    let line = serde_json::from_str(line).map_or_else(
                        |_| line.to_owned(),
                        |value| without_times(value).to_string(),
                    );
                    hasher.update(line.as_bytes());
                }
            }
            Err(_) => hasher.update(bytes),
        }
    }
    hasher.digest()
}

fn write_inputs(folder: &Path) {
    write_ball(folder);
    let rays: Vec<u8> = (0..100)
        .flat_map(|i| [0.0, 0.0, 9.0, i as f32 * 1e-3, 0.0, -1.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    fs::write(folder.join("rays.bin"), rays).expect("a file");
    for (name, text) in [
        ("lawn.toml", include_str!("golden/lawn.toml")),
        ("room.toml", include_str!("golden/room.toml")),
        ("hall.toml", include_str!("golden/hall.toml")),
        ("back.toml", include_str!("golden/back.toml")),
    ] {
        fs::write(folder.join(name), text).expect("a file");
    }
}

/// Lists every file in a folder and the folders in it, by its path from there.
fn files_in(folder: &Path, from: &Path, found: &mut Vec<(String, PathBuf)>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files_in(&path, from, found);
        } else {
            let name = path.strip_prefix(from).expect("within").to_string_lossy();
            found.push((name.replace('\\', "/"), path));
        }
    }
}

/// Runs a line of commands, joined by `&&`, in a folder of its own, and describes what came of
/// it: a hash a file, and one of what was printed.
fn run(line: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    write_inputs(folder.path());
    let mut before = Vec::new();
    files_in(folder.path(), folder.path(), &mut before);
    let mut printed = Vec::new();
    for command in line.split(" && ") {
        let (command, input) = command.split_once(" <<< ").unwrap_or((command, ""));
        let (program, arguments) = command.split_once(' ').expect("a program");
        let mut command = match program {
            "shisen" => shisen(folder.path()),
            "shisen-evidence" => evidence(folder.path()),
            other => panic!("no program {other}"),
        };
        let command = command.args(arguments.split(' ')).write_stdin(input);
        let output = command.assert().success().get_output().stdout.clone();
        printed.extend(output);
    }
    let mut told = format!("{line}\n");
    if !printed.is_empty() {
        writeln!(told, "  printed {:016x}", hash_of("", &printed)).expect("text");
    }
    let mut files = Vec::new();
    files_in(folder.path(), folder.path(), &mut files);
    files.retain(|file| !before.contains(file));
    files.sort();
    for (name, path) in files {
        let hash = hash_of(&name, &fs::read(path).expect("a file"));
        writeln!(told, "  {name} {hash:016x}").expect("text");
    }
    told
}

#[test]
fn results_are_what_they_were() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/golden.txt");
    let expected = fs::read_to_string(&path).expect("golden.txt");
    let lines = expected.lines().filter(|line| !line.starts_with(' '));
    let lines: Vec<&str> = lines.collect();
    // Two halves at once: those of even numbers, and the others.
    let half = |first: usize| lines[first..].iter().copied().step_by(2).map(run).collect();
    let [even, odd]: [Vec<String>; 2] = std::thread::scope(|scope| {
        let odd = scope.spawn(|| half(1));
        [half(0), odd.join().expect("the odd lines")]
    });
    let found: String = (0..lines.len())
        .map(|number| [&even, &odd][number % 2][number / 2].as_str())
        .collect();
    if std::env::var_os("SHISEN_REWRITE").is_some_and(|value| value == "1") {
        fs::write(&path, found).expect("golden.txt");
        return;
    }
    let differs: Vec<_> = found
        .lines()
        .zip(expected.lines())
        .filter(|(found, expected)| found != expected)
        .collect();
    assert!(found == expected, "{differs:#?}");
}
