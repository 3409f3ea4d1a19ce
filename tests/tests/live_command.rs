//! `shisen run`, and what measures it: what they report, and what they do where a tracker,
//! a window or a budget is not as it should be.

use serde_json::Value;
use shisen_tests::command::{evidence, shisen};
use shisen_tests::sizes::cases;
use std::fs;
#[cfg(unix)]
use std::process::Stdio;
#[cfg(unix)]
use std::{net::TcpListener, time::Duration};

/// Runs the command, which ends with this code and says this.
fn fails(arguments: &[&str], code: i32, said: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let output = command.arg("run").args(arguments).assert().code(code);
    let words = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    let words: Vec<&str> = words.split_whitespace().collect();
    assert!(words.join(" ").contains(said), "{arguments:?}: {words:?}");
}

#[test]
fn the_command_follows_the_mock_and_reports() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    // Wherever the viewer looks in the meantime, less than a frame needs.
    let budget = ["--budget", "40000steps", "--frames", "40", "--size", "48"];
    let command = command.args(["run", "--tracker", "mock:seed=3", "--hz", "100"]);
    let command = command.args(budget).args(["--record", "log", "--json"]);
    let output = command.args(["--view", "png"]).assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    assert_eq!(report["frames"], 40);
    assert_eq!(report["over_budget_frames"], 0);
    assert_eq!(report["frames_with_unfinished_fovea"], 0);
    assert_eq!(report["budget_steps"], 40_000);
    assert!(
        report["lowered_share"].as_f64().expect("a share") > 0.5,
        "{report}"
    );
    assert!(report["samples"].as_u64().expect("samples") > 10);
    for quantile in ["p50", "p95", "p99"] {
        assert!(
            report["motion_to_wall_ms"][quantile]
                .as_f64()
                .expect("a time")
                > 0.0
        );
    }
    let stages = report["stages"].as_object().expect("stages");
    assert_eq!(stages.len(), 7);
    for (leg, stage) in stages {
        let classes = report["histograms"][leg].as_array().expect("a histogram");
        let of = |class: &Value| {
            (
                class[0].as_f64().expect("ms"),
                class[1].as_u64().expect("frames"),
            )
        };
        let frames: u64 = classes.iter().map(|class| of(class).1).sum();
        assert_eq!(frames, stage["frames"].as_u64().unwrap_or(0), "{leg}");
        assert!(classes.is_sorted_by_key(|class| of(class).0), "{leg}");
    }
    let rungs = report["rungs"].as_array().expect("rungs");
    let frames: u64 = rungs
        .iter()
        .map(|rung| rung["frames"].as_u64().expect("a count"))
        .sum();
    assert_eq!(frames, 40);

    let log = fs::read_to_string(folder.path().join("log")).expect("a log");
    let records: Vec<Value> = log
        .lines()
        .map(|line| serde_json::from_str(line).expect("an object"))
        .collect();
    assert_eq!(records.len(), 40);
    let mut presented = 0;
    for (number, record) in records.iter().enumerate() {
        assert_eq!(record["frame"], number);
        assert!(
            record["steps"].as_u64() <= record["budget_steps"].as_u64(),
            "{record}"
        );
        let times = [
            "arrive_us",
            "latch_us",
            "first_ray_us",
            "done_us",
            "present_us",
        ];
        let times = times.map(|key| record[key].as_u64().unwrap_or(0));
        assert!(times.is_sorted(), "{record}");
        // No two frames in one refresh.
        assert!(times[4] > presented, "{record}");
        presented = times[4];
        let late = record["late"].as_bool().expect("a verdict");
        assert!(
            late || times[4] >= record["due_us"].as_u64().expect("a time"),
            "{record}"
        );
    }
    let path = folder.path().join("shisen-out/frame-000039.png");
    let picture = fs::read(path).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG"));
}

/// A tracker that ends leaves all walls to be made as well as what was looked at, which
/// needs much more from one frame to the next, and may be more than there is.
#[test]
fn a_gaze_that_is_lost_leaves_no_hole_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = ["tracker", "record", "mock", "--seconds", "0.4", "gaze.csv"];
    shisen(folder.path()).args(record).assert().success();
    for budget in ["40000steps", "50000steps"] {
        let mut command = shisen(folder.path());
        let command = command.args(["run", "--tracker", "replay:gaze.csv", "--size", "48"]);
        let command = command.args(["--budget", budget, "--hz", "100", "--frames", "150"]);
        let output = command.args(["--record", "log", "--json"]).assert();
        let report: Value =
            serde_json::from_slice(&output.success().get_output().stdout).expect("an object");
        let log = fs::read_to_string(folder.path().join("log")).expect("a log");
        let lost = log.lines().filter(|line| line.contains("full quality"));
        assert!(lost.count() > 20, "{log}");
        assert_eq!(report["frames_with_unfinished_fovea"], 0, "{log}");
        assert_eq!(report["over_budget_frames"], 0, "{report}");
    }
}

/// A tracker that dies: no frame after it says anything of latency.
#[cfg(unix)]
#[test]
fn a_tracker_that_is_killed_adds_nothing_to_latencies() {
    use super::tracker_command::{start, start_on_line};
    use std::io::Read;
    let folder = tempfile::tempdir().expect("a folder");
    let line = ["tracker", "mock", "--as", "link", "--pty", "tracker"];
    let mock = start_on_line(folder.path(), &line);
    let spec = "serial:tracker?protocol=link&hold_after=0.1&widen_after=0.2&head_after=0.4&\
                full_after=0.6";
    let mut run = ["run", "--tracker", spec, "--hz", "50", "--size", "24"].to_vec();
    run.extend(["--budget", "20000steps", "--frames", "150", "--view", "png"]);
    run.extend(["--record", "log", "--json"]);
    let mut run = start(folder.path(), &run);
    let shown = folder.path().join("shisen-out/frame-000050.png");
    let begun = std::time::Instant::now();
    while !shown.exists() {
        assert!(begun.elapsed() < Duration::from_mins(1), "no frame");
        std::thread::sleep(Duration::from_millis(5));
    }
    drop(mock);
    let mut said = String::new();
    let mut stdout = run.0.stdout.take().expect("what it says");
    stdout.read_to_string(&mut said).expect("text");
    assert!(run.0.wait().expect("an end").success());
    let report: Value = serde_json::from_str(&said).expect("an object");
    let log = fs::read_to_string(folder.path().join("log")).expect("a log");
    let records = log
        .lines()
        .map(|line| serde_json::from_str(line).expect("an object"));
    let records: Vec<Value> = records.collect();
    let at = |record: &Value, key: &str| record[key].as_u64().expect("a time");
    let (followed, others): (Vec<_>, Vec<_>) = records
        .iter()
        .partition(|record| record["follows_gaze"] == true);
    assert!(followed.len() > 10 && others.len() > 10, "{log}");
    assert_eq!(report["frames_without_gaze"], others.len() as u64);
    let times = followed
        .iter()
        .map(|record| at(record, "present_us") - at(record, "sample_us"));
    let longest = times.max().expect("a frame") as f64 * 1.0e-3;
    for leg in ["sample_to_arrive", "arrive_to_first_ray", "motion_to_wall"] {
        assert_eq!(
            report["stages"][leg]["frames"],
            followed.len() as u64,
            "{leg}"
        );
    }
    let most = report["motion_to_wall_ms"]["most"]
        .as_f64()
        .expect("a time");
    assert!((most / longest - 1.0).abs() < 2.0e-3, "{most} {longest}");
    for record in &followed {
        assert!(
            at(record, "latch_us") - at(record, "arrive_us") <= 200_000,
            "{record}"
        );
    }
    // Its last sample is known all the same, and how old it is.
    let last = records.last().expect("a frame");
    assert_eq!(
        (&last["follows_gaze"], &last["state"]),
        (&false.into(), &"full quality".into())
    );
    assert!(
        at(last, "latch_us") - at(last, "arrive_us") > 200_000,
        "{last}"
    );
}

/// Ctrl-C ends a run that has no end, with its report and its record.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_with_a_report() {
    use super::tracker_command::{interrupt, start};
    use std::io::Read;
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = start(
        folder.path(),
        &[
            "run", "--size", "16", "--hz", "60", "--view", "png", "--record", "log", "--json",
        ],
    );
    let shown = folder.path().join("shisen-out/frame-000003.png");
    let begun = std::time::Instant::now();
    while !shown.exists() {
        assert!(begun.elapsed() < Duration::from_mins(1), "no frame");
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(&run);
    let mut said = String::new();
    let mut stdout = run.0.stdout.take().expect("what it says");
    stdout.read_to_string(&mut said).expect("text");
    assert_eq!(run.0.wait().expect("an end").code(), Some(0));
    assert_eq!(said.lines().count(), 1, "{said}");
    let report: Value = serde_json::from_str(&said).expect("an object");
    let frames = report["frames"].as_u64().expect("frames");
    assert!(frames >= 4, "{report}");
    // No frame is cut short.
    let log = fs::read_to_string(folder.path().join("log")).expect("a log");
    assert_eq!(log.lines().count() as u64, frames);
    for line in log.lines() {
        let record: Value = serde_json::from_str(line).expect("an object");
        assert!(record["present_us"].is_u64(), "{record}");
    }
}

#[test]
fn what_is_looked_at_is_missed_only_by_budgets_that_say_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--budget", "1steps", "--frames", "5", "--size", "16"]);
    let output = command.arg("--json").assert().success();
    let output = output.get_output();
    let report: Value = serde_json::from_slice(&output.stdout).expect("an object");
    assert_eq!(report["frames_with_unfinished_fovea"], 5, "{report}");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("the budget is too small").count(), 1, "{said}");
}

/// Where a refresh leaves more time than the budget, no frame is late, and all are over
/// their time.
#[test]
fn times_shorter_than_the_least_quality_are_counted_and_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--hz", "10", "--budget", "0.1ms", "--frames", "20"]);
    let output = command
        .args(["--record", "log", "--json"])
        .assert()
        .success();
    let output = output.get_output();
    let report: Value = serde_json::from_slice(&output.stdout).expect("an object");
    assert_eq!(report["over_time_frames"], 20, "{report}");
    assert_eq!(report["over_budget_frames"], 0, "{report}");
    assert!(report["late_frames"].as_u64() < Some(20), "{report}");
    let log = fs::read_to_string(folder.path().join("log")).expect("a log");
    for line in log.lines() {
        let record: Value = serde_json::from_str(line).expect("an object");
        assert_eq!(record["budget_us"], 100, "{record}");
        let at = |key: &str| record[key].as_u64().expect("a time");
        let is_longer = at("done_us") - at("latch_us") > 100;
        assert_eq!(record["over_time"], is_longer, "{record}");
    }
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("the budget is too short").count(), 1, "{said}");
}

/// What is given up takes time as well. Where that counted against the next frame's
/// steps, there were none left after a few.
#[test]
fn a_time_that_is_too_short_is_used_all_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--hz", "60", "--frames", "120", "--json"]);
    let output = command.assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    assert!(report["median_steps"].as_u64() > Some(1_000), "{report}");
}

/// Times that are too short for anything: what is looked at is there.
#[test]
fn no_fovea_is_cut_where_time_is_short() {
    for (budget, frames, hz) in [("0.1ms", "40", "60"), ("0.5ms", "150", "200")] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut command = shisen(folder.path());
        let command = command.args(["run", "--size", "256", "--hz", hz, "--budget", budget]);
        let command = command.args(["--frames", frames, "--json"]);
        let output = command.assert().success();
        let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
        assert_eq!(report["frames_with_unfinished_fovea"], 0, "{report}");
        assert_eq!(report["over_budget_frames"], 0, "{report}");
    }
}

/// A head that is outside of the room from the first sample on.
#[test]
fn who_sees_no_wall_at_first_has_blind_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--tracker", "mock:delay=0", "--head", "0,0,-1.4999"]);
    let command = command.args(["--frames", "10", "--size", "32", "--json"]);
    let output = command.assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    assert_eq!(report["frames"], 10, "{report}");
    assert!(report["blind_frames"].as_u64() > Some(0), "{report}");
}

/// Before anything is shown, too.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_what_is_measured_before_the_first_frame() {
    use super::tracker_command::{interrupt, start};
    use std::io::Read;
    let folder = tempfile::tempdir().expect("a folder");
    let mut run = start(
        folder.path(),
        &["run", "--size", "512", "--samples", "4", "--json"],
    );
    // What is measured takes much longer.
    std::thread::sleep(Duration::from_secs(4));
    interrupt(&run);
    let mut said = String::new();
    let mut stdout = run.0.stdout.take().expect("what it says");
    stdout.read_to_string(&mut said).expect("text");
    assert_eq!(run.0.wait().expect("an end").code(), Some(0));
    let report: Value = serde_json::from_str(&said).expect("an object");
    assert_eq!(report["frames"], 0, "{report}");
}

/// Whoever reads what is told may have stopped to.
#[cfg(unix)]
#[test]
fn frames_go_on_where_nobody_reads_what_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = "run --tracker mock:rate=10000 --frames 60 --size 24 --hz 60 --json";
    let full = "(yes | head -c 1000000) >&2 & sleep 1";
    let mut command = std::process::Command::new("sh");
    let command = command.current_dir(folder.path());
    let command = command.args(["-c", &format!("{full}; exec \"$0\" {run}")]);
    let command = command.arg(shisen(folder.path()).get_program());
    let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    let begun = std::time::Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("its state") {
            break status;
        }
        if begun.elapsed() > Duration::from_mins(4) {
            child.kill().expect("an end");
            panic!("it waits for whom it tells something");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(status.success());
    let mut said = String::new();
    let mut stdout = child.stdout.take().expect("what it says");
    std::io::Read::read_to_string(&mut stdout, &mut said).expect("text");
    let report: Value = serde_json::from_str(&said).expect("an object");
    assert_eq!(report["frames"], 60, "{report}");
    assert!(report["passed_over_samples"].as_u64() > Some(0), "{report}");
}

/// Half of what frames take without a budget, by steps and by the clock.
#[test]
fn frames_at_half_of_what_they_take_are_whole_and_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = cases("frames at half of what they take", 40, 500);
    let mut command = evidence(folder.path());
    let command = command.args(["bench", "budget", "--json", "--frames", &frames.to_string()]);
    let output = command.assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    println!("{report}");
    let number = |of: &Value, key: &str| of[key].as_f64().expect("a number");
    let [by_steps, by_the_clock] = report["runs"].as_array().expect("runs").as_slice() else {
        panic!("two runs: {report}")
    };
    let half = report["free"]["steps"].as_u64().expect("steps") / 2;
    assert_eq!(by_steps["budget"], format!("{half}steps"));
    assert_eq!(report["free"]["frames"], frames.div_ceil(10) as u64);
    for run in [by_steps, by_the_clock] {
        assert_eq!(run["frames"], frames as u64, "{report}");
        assert_eq!(run["over_budget_frames"], 0, "{report}");
        let share = number(run, "late_frames") / frames as f64;
        assert!((share - number(run, "late_share")).abs() < 1.0e-12);
        // A refresh is half of the time, and not by much less.
        let refresh = 1.0e3 / number(run, "hz");
        let half = 0.5 * number(&report["free"], "milliseconds");
        assert!(
            (0.5 * half..=half.max(1.0) * 1.000_001).contains(&refresh),
            "{report}"
        );
    }
    assert_eq!(by_steps["frames_with_unfinished_fovea"], 0, "{report}");
    assert!(number(by_steps, "lowered_share") > 0.5, "{report}");
    // So few frames, beside other tests that take the time they were measured by, say
    // nothing of the clock.
    if frames == 10_000 {
        assert_eq!(by_the_clock["frames_with_unfinished_fovea"], 0, "{report}");
        assert!(number(by_the_clock, "lowered_share") > 0.5, "{report}");
        assert!(
            by_the_clock["late_frames"].as_u64() <= Some(100),
            "{report}"
        );
    }
}

/// An X server takes the connection and says nothing.
#[cfg(unix)]
#[test]
fn a_window_system_that_hangs_is_told() {
    let port = |listener: &TcpListener| listener.local_addr().expect("an address").port();
    let silent = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    let display = port(&silent).checked_sub(6_000).expect("a high port");
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--view", "window", "--size", "16", "--frames", "1"]);
    let command = command.env("DISPLAY", format!("127.0.0.1:{display}"));
    let output = command.timeout(Duration::from_mins(1)).assert().code(1);
    let words = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    let words: Vec<&str> = words.split_whitespace().collect();
    assert!(words.join(" ").contains("does not answer"), "{words:?}");
}

/// A tracker that sends ten times as much as any does: by itself, and over a line.
#[test]
fn a_flood_is_thinned_and_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--tracker", "mock:rate=10000", "--size", "24"]);
    let command = command.args(["--hz", "60", "--frames", "90", "--record", "log", "--json"]);
    let output = command.assert().success();
    let output = output.get_output();
    let report: Value = serde_json::from_slice(&output.stdout).expect("an object");
    let count = |key: &str| report[key].as_u64().expect("a count");
    assert!(count("samples") > 10_000, "{report}");
    // All of the first quarter of a second, and one of ten after it.
    let used = count("samples") - count("passed_over_samples");
    assert!(used * 2 < count("samples"), "{report}");
    assert!(used * 1_000 > count("samples") * 90, "{report}");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.matches("one of 10 samples is").count(), 1, "{said}");
    // No gaze lies about, and none is lost.
    assert!(
        report["stages"]["arrive_to_latch"]["p50"].as_f64() < Some(10.0),
        "{report}"
    );
    let log = fs::read_to_string(folder.path().join("log")).expect("a log");
    let state = |line: &str| -> Value {
        let record: Value = serde_json::from_str(line).expect("an object");
        record["state"].clone()
    };
    assert!(
        log.lines()
            .skip(5)
            .all(|line| state(line) != "full quality"),
        "{log}"
    );
    let (frames, refreshes) = (count("frames"), count("refreshes"));
    assert_eq!(frames + count("repeated_refreshes"), refreshes, "{report}");
    #[cfg(unix)]
    {
        let mut command = evidence(folder.path());
        let command = command.args(["bench", "latency", "--rates", "10000", "--seconds", "1"]);
        let output = command
            .args(["--size", "24", "--hz", "60", "--json"])
            .assert();
        let report: Value =
            serde_json::from_slice(&output.success().get_output().stdout).expect("an object");
        for run in report["runs"].as_array().expect("runs") {
            let count = |key: &str| run[key].as_u64().expect("a count");
            // What a busy machine does not read in time is lost on the line.
            assert!(count("samples") > 2_000, "{run}");
            assert!(count("passed_over_samples") * 2 > count("samples"), "{run}");
            let least = run["stages"]["motion_to_wall"]["least"].as_f64();
            // The simulated tracker is 8 ms late.
            assert!(least > Some(7.9), "{run}");
        }
    }
}

/// The default of the paper's scenes: what the budget is, what was needed, and how often
/// it bound.
#[test]
fn a_scaled_budget_says_what_it_is_of_what_frames_need() {
    // Frames of D for a gaze to the front need more than the paper's part of one in full.
    // Whoever takes the processors while that one is measured, and not later, makes it
    // seem dearer: hardly time and again.
    let bound = (0..5).any(|_| scaled_budget()["lowered_share"].as_f64() > Some(0.0));
    assert!(bound, "{}", scaled_budget());
}

/// What a short session of scene D says of itself.
fn scaled_budget() -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--scene", "D", "--size", "48", "--frames", "60"]);
    let output = command.arg("--json").assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    let number = |key: &str| report[key].as_f64().expect("a number");
    assert_eq!(report["budget"], "paper-scaled");
    let [least, most] = [0, 1].map(|place| report["plain_parts"][place].as_f64().expect("a part"));
    // Table 2 has .203 s and .484 s of .532 s.
    assert!(
        least >= 0.203 / 0.532 - 1.0e-6 && most <= 0.484 / 0.532 + 1.0e-6,
        "{report}"
    );
    let last = number("budget_ms") / number("plain_ms");
    assert!((least - 1.0e-6..=most + 1.0e-6).contains(&last), "{report}");
    assert!(number("needed_share") > 0.0, "{report}");
    // A frame is of full quality, or lowered.
    let full = report["rungs"][0]["frames"].as_f64().expect("a count");
    let lowered = number("lowered_share") * number("frames");
    assert!(
        (full + lowered - number("frames")).abs() < 1.0e-6,
        "{report}"
    );
    report
}

/// In words.
#[test]
fn a_budget_that_binds_nothing_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    for (budget, binds) in [("1000000000steps", false), ("10000steps", true)] {
        let mut command = shisen(folder.path());
        let command = command.args(["run", "--budget", budget, "--size", "48", "--frames", "5"]);
        let output = command.assert().success();
        let said = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
        let is_more = said.contains("this budget is more than a frame of full quality needs");
        assert_eq!(is_more, !binds, "{said}");
        assert_eq!(said.contains("quality lowered in 0.0%"), !binds, "{said}");
    }
}

#[test]
fn bad_input_is_told() {
    for (arguments, said) in [
        (
            &["--budget", "33"][..],
            "33 has no unit: give 33ms or 33steps",
        ),
        (&["--budget", "0steps"], "out of range"),
        (&["--hz", "0"], "1 to 1000"),
        (&["--scene", "grid"], "give --hz or --budget"),
        (
            &["--scene", "grid", "--budget", "paper"],
            "A to D of the paper's Table 2",
        ),
        (&["--frames", "0"], "give a whole number from 1"),
        (&["--tracker", "nothing"], "--tracker"),
        (&["--cluster"], "--features cluster"),
        (&["--cluster", "--view", "window"], "--view none or png"),
        (
            &["--cluster", "--view", "png", "--stereo", "anaglyph"],
            "leave one",
        ),
        (&["--swap-timeout", "3"], "--cluster"),
    ] {
        fails(arguments, 2, said);
    }
    fails(&["--record", "no/such/folder/log"], 1, "cannot write");
    let gone = "serial:/dev/shisen-gone?protocol=fastrak";
    fails(&["--tracker", gone], 1, "shisen-gone");
}

/// A disk that fills up ends the run, and does not take its report along.
#[cfg(target_os = "linux")]
#[test]
fn a_record_that_cannot_be_written_leaves_the_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = shisen(folder.path());
    let command = command.args(["run", "--size", "16", "--hz", "200", "--frames", "20"]);
    let command = command.args(["--budget", "off", "--record", "/dev/full", "--json"]);
    let output = command.assert().code(1).get_output().clone();
    let report: Value = serde_json::from_slice(&output.stdout).expect("an object");
    assert_eq!(report["frames"], 20);
    let said = String::from_utf8(output.stderr).expect("text");
    assert!(said.contains("/dev/full"), "{said}");
}

#[cfg(unix)]
#[test]
fn latency_is_measured_over_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = evidence(folder.path());
    let command = command.args(["bench", "latency", "--rates", "250,1000", "--seconds", "1"]);
    let command = command.args(["--size", "24", "--hz", "50", "--out", "out", "--json"]);
    let output = command.assert().success();
    let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
    let runs = report["runs"].as_array().expect("runs");
    // Linux says so of each thread, as long as it is there.
    if cfg!(target_os = "linux") {
        let told = |run: &Value| run["involuntary_switches"].is_u64();
        assert!(runs.iter().all(told), "{report}");
    }
    let ways: Vec<(&Value, &Value)> = runs
        .iter()
        .map(|run| (&run["tracker_hz"], &run["latch"]))
        .collect();
    assert_eq!(ways.len(), 4);
    for (number, (rate, latch)) in ways.into_iter().enumerate() {
        assert_eq!(rate, [250, 250, 1_000, 1_000][number]);
        assert_eq!(latch, ["early", "late"][number % 2]);
    }
    for run in runs {
        let frames = run["frames"].as_u64().expect("frames");
        assert!((5..=60).contains(&frames), "{run}");
        let of = |leg: &str| {
            let stage = &run["stages"][leg];
            // The first frames may be before the first sample.
            let counted = stage["frames"].as_u64().expect("frames");
            assert!(counted <= frames && counted + 25 >= frames, "{run}");
            stage["p50"].as_f64().expect("a time")
        };
        assert!(of("motion_to_wall") > of("arrive_to_first_ray"), "{run}");
        assert!(of("motion_to_wall") >= of("first_ray_to_done"), "{run}");
        if run["latch"] == "late" {
            // Frames begin with a sample: what the loop adds is a wake-up and their plan.
            let most = cases("microseconds from arrival to first ray", 2_000, 1_000);
            assert!(of("arrive_to_first_ray") * 1e3 < most as f64, "{run}");
        }
    }
    let gains = report["gains"].as_array().expect("gains");
    assert_eq!(gains.len(), 2);
    for gain in gains {
        // Such frames take a small part of 20 ms.
        let gain = gain["motion_to_wall_ms"].as_f64().expect("a time");
        assert!(gain > 2.0, "{report}");
    }
    let csv = fs::read_to_string(folder.path().join("out/latency.csv")).expect("a table");
    let mut counted = 0;
    for line in csv.lines().skip(1) {
        let [_, _, leg, _, frames] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        if leg == "done_to_present" {
            counted += frames.parse::<u64>().expect("a count");
        }
    }
    let frames: u64 = runs
        .iter()
        .map(|run| run["frames"].as_u64().unwrap_or(0))
        .sum();
    assert_eq!(counted, frames);
    let svg = fs::read_to_string(folder.path().join("out/latency.svg")).expect("a chart");
    assert!(svg.contains("1000 Hz, late latch"));
    let svg = fs::read_to_string(folder.path().join("out/legs.svg")).expect("a chart");
    assert!(svg.contains("Legs at 1000 Hz, late latch") && svg.contains("arrive to latch"));
    // Each frame, its stages one after another.
    let table = fs::read_to_string(folder.path().join("out/frames.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len() as u64, frames + 1);
    assert_eq!(rows[0][3..5], ["sample_us", "arrive_us"]);
    for row in &rows[1..] {
        let known = row[3..9].iter().filter(|time| !time.is_empty());
        let times: Vec<u64> = known.map(|time| time.parse().expect("a time")).collect();
        assert!(times.len() >= 4 && times.is_sorted(), "{row:?}");
    }
}

/// What qualities differ by where pixels are left out, or a capture is taken anew.
#[test]
fn a_lower_quality_is_told_in_full() {
    let folder = tempfile::tempdir().expect("a folder");
    for (way, expected) in [
        (&["--lod", "foveated"][..], " times as coarse\n"),
        (&["--fill", "capture"], "% of the capture anew\n"),
    ] {
        let mut command = shisen(folder.path());
        let command = command.args(["run", "--size", "24", "--hz", "100", "--frames", "5"]);
        let command = command.args(["--budget", "4000steps"]).args(way);
        let output = command.assert().success().get_output().stdout.clone();
        let text = String::from_utf8(output).expect("text");
        assert!(text.contains(expected), "{text}");
    }
}
