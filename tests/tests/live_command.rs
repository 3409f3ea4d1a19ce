//! `shisen run`, and what measures it: what they report, and what they do where a tracker,
//! a window or a budget is not as it should be.
#![cfg(unix)]

use super::tracker_command::{await_file, record, start, start_on_line};
use glam::{Quat, Vec3};
use serde_json::{Value, json};
use shisen_tests::command::{count, folder, line, number, refusal, refused, report, says, shisen};
use shisen_tests::sizes::cases;
use shisen_tracker::decoder::{Control, ControlState, Message, Text};
use shisen_tracker::link::Encoder;
use shisen_tracker::sample::{Reading, Sample};
use shisen_tracker::time::Micros;
use std::f32::consts::FRAC_PI_2;
use std::fs;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Returns the objects of a log, a line each.
fn logged(folder: &Path) -> Vec<Value> {
    let log = fs::read_to_string(folder.join("log")).expect("a log");
    let records = log
        .lines()
        .map(|line| serde_json::from_str(line).expect("an object"));
    records.collect()
}

/// Returns what a command says on standard error, and its report.
fn warned(folder: &Path, words: &str) -> (Value, String) {
    let said = shisen_tests::command::run(folder, &format!("{words} --json"));
    (said.objects().remove(0), said.err)
}

#[test]
fn the_command_follows_the_mock_and_reports() {
    let folder = folder();
    // Wherever the viewer looks in the meantime, less than a frame needs.
    let words = "run --scene A --tracker mock:seed=3 --hz 100 --budget 40000steps --frames 40 --size 48 \
                 --report log --view png";
    let report = report(folder.path(), words);
    says(
        &report,
        json!({
            "frames": 40,
            "over_budget_frames": 0,
            "frames_with_unfinished_fovea": 0,
            "budget_steps": 40_000,
        }),
    );
    assert!(
        number(&report, "lowered_share") > 0.5 && count(&report, "samples") > 10,
        "{report}"
    );
    for quantile in ["p50", "p95", "p99"] {
        assert!(number(&report["motion_to_wall_ms"], quantile) > 0.0);
    }
    let stages = report["stages"].as_object().expect("stages");
    assert_eq!(stages.len(), 7);
    for (leg, stage) in stages {
        let classes: Vec<(f64, u64)> =
            serde_json::from_value(report["histograms"][leg].clone()).expect("a histogram");
        let frames: u64 = classes.iter().map(|class| class.1).sum();
        assert_eq!(frames, stage["frames"].as_u64().unwrap_or(0), "{leg}");
        assert!(classes.is_sorted_by_key(|class| class.0), "{leg}");
    }
    let rungs = report["rungs"].as_array().expect("rungs").iter();
    assert_eq!(rungs.map(|rung| count(rung, "frames")).sum::<u64>(), 40);

    let records = logged(folder.path());
    assert_eq!(records.len(), 40);
    let mut presented = 0;
    for (number, record) in records.iter().enumerate() {
        assert_eq!(record["frame"], number);
        assert!(
            count(record, "steps") <= count(record, "budget_steps"),
            "{record}"
        );
        let times = ["arrive", "latch", "first_ray", "done", "present"];
        let times = times.map(|key| record[format!("{key}_us")].as_u64().unwrap_or(0));
        // No two frames in one refresh.
        assert!(times.is_sorted() && times[4] > presented, "{record}");
        presented = times[4];
        assert!(
            record["late"] == true || times[4] >= count(record, "due_us"),
            "{record}"
        );
    }
    let picture = fs::read(folder.path().join("shisen-out/frame-000039.png"));
    assert!(picture.expect("a picture").starts_with(b"\x89PNG"));
}

/// A tracker that ends leaves all walls to be made as well as what was looked at, which
/// needs much more from one frame to the next, and may be more than there is.
#[test]
fn a_gaze_that_is_lost_leaves_no_hole_where_it_was() {
    let folder = folder();
    record(folder.path(), "mock", "gaze.csv", 200);
    let words = "run --scene A --tracker replay:gaze.csv --size 48 --budget 40000steps --hz 100 \
                 --frames 150 --report log";
    let report = report(folder.path(), words);
    let lost = logged(folder.path()).into_iter();
    let lost = lost.filter(|record| record["state"] == "full quality");
    assert!(lost.count() > 20);
    assert_eq!(report["frames_with_unfinished_fovea"], 0, "{report}");
    assert_eq!(report["over_budget_frames"], 0, "{report}");
}

/// A tracker that dies: no frame after it says anything of latency.
#[test]
fn a_tracker_that_is_killed_adds_nothing_to_latencies() {
    let folder = folder();
    let mock = start_on_line(folder.path(), "tracker serve mock --as link --to tracker");
    let spec = "serial:tracker?protocol=link&hold_after=0.1&widen_after=0.2&head_after=0.4&\
                full_after=0.6";
    let words = format!(
        "run --scene A --tracker {spec} --hz 50 --size 24 --budget 20000steps --frames 120 --view png \
         --report log --json"
    );
    let mut run = start(folder.path(), &words);
    await_file(&folder.path().join("shisen-out/frame-000030.png"));
    drop(mock);
    let report: Value = serde_json::from_str(&run.finish()).expect("an object");
    let records = logged(folder.path());
    let (followed, others): (Vec<_>, Vec<_>) = records
        .iter()
        .partition(|record| record["follows_gaze"] == true);
    assert!(followed.len() > 10 && others.len() > 10, "{records:?}");
    assert_eq!(report["frames_without_gaze"], others.len());
    let times = followed
        .iter()
        .map(|one| count(one, "present_us") - count(one, "sample_us"));
    let longest = times.max().expect("a frame") as f64 * 1.0e-3;
    for leg in ["sample_to_arrive", "arrive_to_first_ray", "motion_to_wall"] {
        assert_eq!(report["stages"][leg]["frames"], followed.len(), "{leg}");
    }
    let most = number(&report["motion_to_wall_ms"], "most");
    assert!((most / longest - 1.0).abs() < 2.0e-3, "{most} {longest}");
    let age = |record: &Value| count(record, "latch_us") - count(record, "arrive_us");
    assert!(
        followed.iter().all(|record| age(record) <= 200_000),
        "{followed:?}"
    );
    // Its last sample is known all the same, and how old it is.
    let last = records.last().expect("a frame");
    says(
        last,
        json!({ "follows_gaze": false, "state": "full quality" }),
    );
    assert!(age(last) > 200_000, "{last}");
}

/// Ctrl-C ends a run that has no end, with its report and its record.
#[test]
fn an_interrupt_ends_it_with_a_report() {
    let folder = folder();
    let words = "run --scene A --size 16 --hz 60 --view png --report log --json";
    let mut run = start(folder.path(), words);
    await_file(&folder.path().join("shisen-out/frame-000003.png"));
    let report: Value = serde_json::from_str(&run.interrupt()).expect("an object");
    assert!(count(&report, "frames") >= 4, "{report}");
    // No frame is cut short.
    let records = logged(folder.path());
    assert_eq!(report["frames"], records.len());
    assert!(
        records.iter().all(|record| record["present_us"].is_u64()),
        "{records:?}"
    );
    // Before anything is shown, too: what is measured at first takes seconds.
    let words = "run --scene A --size 512 --samples 4 --view png --out empty --json";
    let mut run = start(folder.path(), words);
    await_file(&folder.path().join("empty"));
    let report: Value = serde_json::from_str(&run.interrupt()).expect("an object");
    assert_eq!(report["frames"], 0, "{report}");
}

#[test]
fn budgets_that_are_too_small_are_counted_and_told() {
    let folder = folder();
    let words = "run --scene A --budget 1steps --frames 5 --size 16 --lod foveated --samples 5";
    let (report, said) = warned(folder.path(), words);
    assert_eq!(report["frames_with_unfinished_fovea"], 5, "{report}");
    for told in ["the budget is too small", "8 rays a pixel instead of 5"] {
        assert_eq!(said.matches(told).count(), 1, "{said}");
    }
    // Where a refresh leaves more time than the budget, no frame is late, and all are over
    // their time.
    let words = "run --scene A --hz 10 --budget 0.1ms --frames 8 --report log";
    let (report, said) = warned(folder.path(), words);
    assert_eq!(report["over_time_frames"], 8, "{report}");
    assert_eq!(report["over_budget_frames"], 0, "{report}");
    assert!(count(&report, "late_frames") < 8, "{report}");
    for record in logged(folder.path()) {
        assert_eq!(record["budget_us"], 100, "{record}");
        let is_longer = count(&record, "done_us") - count(&record, "latch_us") > 100;
        assert_eq!(record["over_time"], is_longer, "{record}");
    }
    assert_eq!(said.matches("the budget is too short").count(), 1, "{said}");
}

/// A head that is outside of the room from the first sample on.
#[test]
fn an_eye_that_sees_no_wall_at_first_has_blind_frames() {
    let words = "run --scene A --tracker mock:delay=0 --head 0,0,-1.4999 --frames 10 --size 32";
    let report = report(folder().path(), words);
    assert_eq!(report["frames"], 10, "{report}");
    assert!(count(&report, "blind_frames") > 0, "{report}");
}

/// Standard error is a full pipe.
#[test]
fn frames_go_on_where_nobody_reads_what_is_told() {
    let folder = folder();
    let run = "run --scene A --tracker mock:rate=10000 --frames 60 --size 24 --hz 60 --json";
    let full = "(yes | head -c 1000000) >&2 & sleep 1";
    let mut command = std::process::Command::new("sh");
    let command = command.current_dir(folder.path());
    let command = command.args(["-c", &format!("{full}; exec \"$0\" {run}")]);
    let command = command.arg(shisen(folder.path()).get_program());
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut run = super::tracker_command::Running(child.expect("it starts"));
    let begun = Instant::now();
    while run.0.try_wait().expect("its state").is_none() {
        assert!(
            begun.elapsed() < Duration::from_mins(2),
            "it waits for a reader"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    let report: Value = serde_json::from_str(&run.finish()).expect("an object");
    assert_eq!(report["frames"], 60, "{report}");
    assert!(count(&report, "passed_over_samples") > 0, "{report}");
}

/// Half of what frames take without a budget, by steps and by the clock.
#[test]
fn frames_at_half_of_what_they_take_are_whole_and_in_time() {
    let frames = cases("frames at half of what they take", 40, 200);
    let report = report(folder().path(), &format!("bench budget --frames {frames}"));
    let free = &report["free"];
    let half = count(free, "steps") / 2;
    assert_eq!(report["runs"][0]["budget"], format!("{half}steps"));
    assert_eq!(free["frames"], frames.div_ceil(10));
    for run in [&report["runs"][0], &report["runs"][1]] {
        assert_eq!(run["frames"], frames, "{report}");
        assert_eq!(run["over_budget_frames"], 0, "{report}");
        let share = number(run, "late_frames") / frames as f64;
        assert!((share - number(run, "late_share")).abs() < 1.0e-12);
        // A refresh is half of the time, and not by much less.
        let refresh = 1.0e3 / number(run, "hz");
        let half = 0.5 * number(free, "milliseconds");
        assert!(
            (0.5 * half..=half.max(1.0) * 1.000_001).contains(&refresh),
            "{report}"
        );
    }
    // Beside other tests, that of the clock says nothing of quality.
    assert_eq!(
        report["runs"][0]["frames_with_unfinished_fovea"], 0,
        "{report}"
    );
    assert!(
        number(&report["runs"][0], "lowered_share") > 0.5,
        "{report}"
    );
}

/// An X server takes the connection and says nothing.
#[test]
fn a_window_system_that_hangs_is_told() {
    let silent = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    let port = silent.local_addr().expect("an address").port();
    let display = port.checked_sub(6_000).expect("a high port");
    let folder = folder();
    let mut command = line(
        folder.path(),
        "run --scene A --view window --size 16 --frames 1",
    );
    command.env("DISPLAY", format!("127.0.0.1:{display}"));
    let said = refusal(command.timeout(Duration::from_mins(1)), 1);
    assert!(said.contains("does not answer"), "{said}");
}

/// A tracker that sends ten times as much as any does.
#[test]
fn a_flood_is_thinned_and_told() {
    let folder = folder();
    let words =
        "run --scene A --tracker mock:rate=10000 --size 24 --hz 60 --frames 90 --report log";
    let (report, said) = warned(folder.path(), words);
    let count = |key: &str| count(&report, key);
    assert!(count("samples") > 10_000, "{report}");
    // All of the first quarter of a second, and one of ten after it.
    let used = count("samples") - count("passed_over_samples");
    assert!(used * 2 < count("samples"), "{report}");
    assert!(used * 1_000 > count("samples") * 90, "{report}");
    assert_eq!(said.matches("one of 10 samples is").count(), 1, "{said}");
    // No gaze lies about, and none is lost.
    assert!(
        number(&report["stages"]["arrive_to_latch"], "p50") < 10.0,
        "{report}"
    );
    let mut records = logged(folder.path()).into_iter().skip(5);
    assert!(records.all(|record| record["state"] != "full quality"));
    assert_eq!(
        count("frames") + count("repeated_refreshes"),
        count("refreshes"),
        "{report}"
    );
}

/// Another program's wand, over VRPN: pushed all the way, and pointing to the left.
#[test]
fn a_wand_flies_the_viewer_where_it_points() {
    let folder = folder();
    let mut encoder = Encoder::new();
    let mut recording = Vec::new();
    let mut sample = Sample::arrived(Micros(0));
    sample.head.position = Some(Reading::tracked(Vec3::ZERO));
    sample.head.orientation = Some(Reading::tracked(Quat::from_rotation_y(FRAC_PI_2)));
    for step in 0..1_000 {
        let text = format!("arrival {}", 50_000 * step);
        let pushed = Control {
            sensor: 0,
            number: 1,
            state: ControlState::Axis(1.0),
            device_time: None,
        };
        for message in [
            Message::Text(Text::new(text.as_bytes())),
            Message::Control(pushed),
        ] {
            recording.extend_from_slice(&encoder.message(&message));
            if let Message::Text(_) = message {
                recording.extend_from_slice(&encoder.sample(&sample));
            }
        }
    }
    fs::write(folder.path().join("wand"), recording).expect("a recording");
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    drop(listener);
    let words = format!("tracker serve replay:wand --as vrpn?name=Wand0 --to 127.0.0.1:{port}");
    let server = start(folder.path(), &words);
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let words = format!(
        "run --scene grid --tracker mock:still=1 --size 16 --hz 30 --frames 45 --report log \
         --navigate vrpn:Wand0@127.0.0.1:{port}?speed=3&head=0"
    );
    let (report, said) = warned(folder.path(), &words);
    let places: Vec<Vec<f64>> = logged(folder.path())
        .iter()
        .map(|record| serde_json::from_value(record["place"].clone()).expect("four numbers"))
        .collect();
    let [x, y, z, yaw] = places[44][..] else {
        panic!("{places:?}");
    };
    // 45 frames last 1.5 s or more, and the first few may come before the wand is heard.
    assert!(x < -3.0 && yaw == 0.0, "{places:?}");
    assert!(y.abs() + z.abs() < 1.0e-3 * x.abs(), "{places:?}");
    assert_eq!(report["sources"][1]["role"], "wand", "{said}");
    drop(server);
}

/// The default of the paper's scenes: what the budget is, what was needed, and how often
/// it bound.
#[test]
fn a_scaled_budget_says_what_it_is_of_what_frames_need() {
    let check = || {
        let report = report(folder().path(), "run --scene D --size 48 --frames 60");
        assert_eq!(report["budget"], "paper-scaled");
        let [least, most] =
            [0, 1].map(|place| report["plain_parts"][place].as_f64().expect("a part"));
        // Table 2 has .203 s and .484 s of .532 s.
        assert!(least >= 0.203 / 0.532 - 1.0e-6, "{report}");
        assert!(most <= 0.484 / 0.532 + 1.0e-6, "{report}");
        let last = number(&report, "budget_ms") / number(&report, "plain_ms");
        assert!((least - 1.0e-6..=most + 1.0e-6).contains(&last), "{report}");
        assert!(number(&report, "needed_share") > 0.0, "{report}");
        // A frame is of full quality, or lowered.
        let full = number(&report["rungs"][0], "frames");
        let lowered = number(&report, "lowered_share") * number(&report, "frames");
        assert!(
            (full + lowered - number(&report, "frames")).abs() < 1.0e-6,
            "{report}"
        );
        lowered
    };
    // Frames of D for a gaze to the front need more than the paper's part of one in full.
    // Other work while that one is measured makes it seem dearer: hardly time and again.
    assert!((0..5).any(|_| check() > 0.0), "the budget never binds");
}

#[test]
fn bad_input_is_told() {
    refused(
        folder().path(),
        2,
        "
        run --budget 33 => 33 has no unit: give 33ms or 33steps
        run --budget 0steps => out of range
        run --hz 0 => 1 to 1000
        run --scene grid --budget paper => A to D of the paper's Table 2
        run --frames 0 => give a whole number from 1
        run --tracker nothing => --tracker
        run --cluster => --features cluster
        run --cluster --view window => --view none or png
        run --cluster --view png --stereo anaglyph => leave one
        run --swap-timeout 3 => --cluster",
    );
    refused(
        folder().path(),
        1,
        "
        run --report no/such/folder/log => cannot write
        run --tracker serial:/dev/shisen-gone?protocol=fastrak => shisen-gone",
    );
}

/// A disk that fills up ends the run, and does not take its report along.
#[cfg(target_os = "linux")]
#[test]
fn a_record_that_cannot_be_written_leaves_the_report() {
    let words =
        "run --scene grid --size 16 --hz 200 --frames 20 --budget off --report /dev/full --json";
    let output = line(folder().path(), words).output().expect("it starts");
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).expect("an object");
    assert_eq!(report["frames"], 20);
    let said = String::from_utf8(output.stderr).expect("text");
    assert!(said.contains("/dev/full"), "{said}");
}

#[test]
fn latency_is_measured_over_a_line() {
    let folder = folder();
    let words = "bench latency --rates 1000 --seconds 1 --size 24 --hz 50 --out out";
    let report = report(folder.path(), words);
    let runs = report["runs"].as_array().expect("runs");
    assert_eq!(runs.len(), 2);
    let mut all = 0;
    for (run, latch) in runs.iter().zip(["early", "late"]) {
        says(run, json!({ "tracker_hz": 1_000, "latch": latch }));
        let frames = count(run, "frames");
        all += frames;
        assert!((5..=60).contains(&frames), "{run}");
        let p50 = |leg: &str| {
            let stage = &run["stages"][leg];
            // The first frames may be before the first sample.
            let counted = count(stage, "frames");
            assert!(counted <= frames && counted + 25 >= frames, "{run}");
            number(stage, "p50")
        };
        assert!(p50("motion_to_wall") > p50("arrive_to_first_ray"), "{run}");
        assert!(p50("motion_to_wall") >= p50("first_ray_to_done"), "{run}");
        if latch == "late" {
            // Frames begin with a sample: what the loop adds is a wake-up and their plan.
            let most = cases("microseconds from arrival to first ray", 2_000, 1_000);
            assert!(p50("arrive_to_first_ray") * 1e3 < most as f64, "{run}");
        }
    }
    // Such frames take a small part of 20 ms.
    let gain = number(&report["gains"][0], "motion_to_wall_ms");
    assert!(gain > 2.0, "{report}");
    let read =
        |name: &str| fs::read_to_string(folder.path().join("out").join(name)).expect("a file");
    assert!(read("latency.svg").contains("1000 Hz, late latch"));
    assert!(read("legs.svg").contains("Legs at 1000 Hz, late latch"));
    // Each frame, its stages one after another.
    let table = read("frames.csv");
    assert_eq!(table.lines().count() as u64, all + 1);
    for row in table.lines().skip(1) {
        let times = row
            .split(',')
            .skip(3)
            .take(6)
            .filter_map(|t| t.parse().ok());
        let times: Vec<u64> = times.collect();
        assert!(times.len() >= 4 && times.is_sorted(), "{row}");
    }
}
