//! The live loop's frames: what they are, what they take, and what is never
//! missing.

use glam::Vec3;
use serde_json::Value;
use shisen::bake::{Baked, Layout};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::live::{Allowance, Engine, Governor, Quality, Share, Taken, with_engine};
use shisen::render::{self, Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::simplify::PolygonLevels;
use shisen_core::Simd;
use shisen_core::frame::{LevelOfDetail, Renderer, Settings, Spectrum};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_tests::command::shisen;
use shisen_tests::meshes::icosphere;
use shisen_tests::sizes::cases;
use std::fs;
#[cfg(unix)]
use std::process::Stdio;
#[cfg(unix)]
use std::{net::TcpListener, time::Duration};

const SIDE: u32 = 64;

fn baked() -> Baked<8> {
    let scene = paper_scene(PaperScene::A, icosphere(4)).expect("a scene");
    let levels = PolygonLevels::new(
        PolygonLevels::FEWEST_FACES..=u32::MAX,
        Layout::Fast.polygon_levels(),
    );
    Baked::with_levels(&scene, &levels.expect("levels")).expect("a baked scene")
}

/// Both eyes of one who looks from front to floor and to the right, over 60 frames.
fn eyes(frame: u32) -> Vec<Observer> {
    let part = (frame % 60) as f32 / 60.0 * std::f32::consts::TAU;
    let forward = Vec3::new(0.6 * part.sin(), -0.5 + 0.7 * part.cos(), -1.0);
    let viewer = Viewer::default();
    let observer = |eye: Eye| {
        let place = viewer.eye(eye);
        let sight = LineOfSight::new(place.as_vec3(), forward, Vec3::Y).expect("a sight");
        let gaze = Gaze::new(sight, VisualField::PAPER);
        Observer {
            lod: Some(LevelOfDetail::new(gaze)),
            ..Observer::new(eye, place)
        }
    };
    Eye::STEREO.map(observer).to_vec()
}

fn options(threads: usize, tile: u32) -> Options {
    Options {
        threads,
        tile,
        ..Options::default()
    }
}

fn with<R>(
    baked: &Baked<8>,
    options: &Options,
    run: impl FnOnce(&mut Engine<'_, '_, 8>) -> R,
) -> R {
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).expect("a room");
    let scene = baked.scene();
    with_engine(
        (scene, Spectrum::default()),
        &cave,
        &eyes(0),
        options,
        None,
        Share::ALL,
        run,
    )
    .expect("an engine")
}

fn hashes(engine: &Engine<'_, '_, 8>) -> Vec<u64> {
    let mut pictures = engine.pictures().expect("pictures");
    engine.copy(&mut pictures);
    pictures
        .iter()
        .map(shisen::picture::Picture::hash)
        .collect()
}

/// A millisecond for so many steps.
const fn taken(steps: u64) -> Taken {
    Taken {
        steps,
        seconds: 1.0e-3,
    }
}

#[test]
fn a_frame_without_a_budget_is_the_frame() {
    let baked = baked();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).expect("a room");
    with(&baked, &options(2, 24), |engine| {
        for number in [0, 17, 31] {
            let eyes = eyes(number);
            let frame = engine.render(&eyes, &Quality::FULL, None).expect("a frame");
            assert_eq!((frame.unfinished, frame.rounds), (0, 1));
            let whole = render::cave(&baked.scene(), &cave, &eyes, &options(1, 32), &|_, _| {});
            let whole = whole.expect("a frame");
            assert_eq!(frame.statistics.rays(), whole.statistics.rays());
            let whole: Vec<u64> = whole
                .pictures
                .iter()
                .map(|one| one.picture.hash())
                .collect();
            assert_eq!(hashes(engine), whole);
        }
    });
}

/// What machines render of a frame is, put together, what one renders.
#[test]
fn shares_of_a_frame_are_the_frame() {
    let baked = baked();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).expect("a room");
    let whole = with(&baked, &options(2, 24), |engine| {
        engine
            .render(&eyes(17), &Quality::FULL, None)
            .expect("a frame");
        hashes(engine)
    });
    for ranks in [2, 3, 6] {
        let mut together = Vec::new();
        for rank in 0..ranks {
            let share = Share::new(rank, ranks).expect("a share");
            let scene = (baked.scene(), Spectrum::default());
            let (eyes, options) = (eyes(17), options(1, 32));
            let own = with_engine(scene, &cave, &eyes, &options, None, share, |engine| {
                engine.render(&eyes, &Quality::FULL, None).expect("a frame");
                engine.hashes().expect("pictures")
            });
            together.extend(own.expect("an engine"));
        }
        assert_eq!(together, whole, "{ranks}");
    }
}

#[test]
fn a_budget_is_kept_and_threads_change_nothing() {
    let baked = baked();
    // From less than a tile's to more than all.
    for steps in [1, 3_000, 20_000, 60_000, 150_000, 10_000_000] {
        let run = |threads: usize| {
            with(&baked, &options(threads, 16), |engine| {
                let mut frames = Vec::new();
                for number in 0..6 {
                    let eyes = eyes(7 * number);
                    let frame = engine.render(&eyes, &Quality::FULL, Some(steps));
                    let frame = frame.expect("a frame");
                    assert!(frame.steps <= steps, "{} of {steps}", frame.steps);
                    assert_eq!(frame.steps, frame.statistics.steps);
                    frames.push((frame.steps, frame.unfinished, hashes(engine)));
                }
                frames
            })
        };
        let one = run(1);
        assert_eq!(one, run(2), "{steps}");
        assert_eq!(one, run(5), "{steps}");
        // What is not finished is at the rim, and little or nothing where all fits.
        let unfinished: Vec<usize> = one.iter().map(|frame| frame.1).collect();
        assert_eq!(
            unfinished.iter().all(|&count| count == 0),
            steps == 10_000_000
        );
    }
}

/// A pixel of many samples takes more than a block of single ones.
#[test]
fn a_budget_is_kept_by_pixels_of_many_samples() {
    let baked = baked();
    for samples in [64, 256, 1_024] {
        let mut options = options(2, 16);
        options.settings.samples = samples;
        with(&baked, &options, |engine| {
            for steps in [20_000, 50_000, 200_000, 1_000_000] {
                for number in 0..4 {
                    let frame = engine.render(&eyes(11 * number), &Quality::FULL, Some(steps));
                    let frame = frame.expect("a frame");
                    let taken = frame.steps;
                    assert!(taken <= steps, "{samples}: {taken} of {steps}");
                    // Most of it is used, where there is enough for a pixel.
                    let is_enough = steps >= 200 * u64::from(samples) * 16;
                    assert!(
                        !is_enough || taken > steps / 4,
                        "{samples}: {taken} of {steps}"
                    );
                }
            }
        });
    }
}

/// One who looks around, whose frames are governed by steps: from the qualities to the
/// pixels all is the same, whoever renders it.
#[test]
fn governed_frames_are_the_same_on_any_number_of_threads() {
    let baked = baked();
    let run = |threads: usize| {
        with(&baked, &options(threads, 16), |engine| {
            let mut governor = Governor::new();
            let full = engine.render(&eyes(0), &Quality::FULL, None);
            let need = full.expect("a frame").steps;
            let all = governor.decide(Allowance::Unlimited);
            governor.learn(&all, need, taken(need));
            let mut frames = Vec::new();
            for number in 0..90 {
                let sight = eyes(number)[0].lod.map(|lod| lod.gaze.line_of_sight());
                governor.follow(sight.map(|sight| sight.forward()));
                let decision = governor.decide(Allowance::Steps(need / 3));
                let frame = engine.render(&eyes(number), &decision.quality, decision.steps);
                let frame = frame.expect("a frame");
                governor.learn(&decision, frame.need, taken(frame.steps));
                let pictures = if number % 10 == 0 {
                    hashes(engine)
                } else {
                    Vec::new()
                };
                frames.push((decision.rung, frame.steps, frame.unfinished, pictures));
            }
            frames
        })
    };
    let one = run(1);
    assert!(one.iter().all(|frame| frame.0 > 0));
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

/// Where time is short, what is looked at is there all the same; and where steps are
/// enough, nothing is different.
#[test]
fn a_fovea_is_whole_whatever_there_is() {
    let baked = baked();
    for steps in [0, 1, 3_000, 20_000, 10_000_000] {
        let run = |threads: usize, whole: bool| {
            with(&baked, &options(threads, 16), |engine| {
                let mut cut = 0;
                let mut frames = Vec::new();
                for number in 0..6 {
                    let eyes = eyes(7 * number);
                    let (quality, steps) = (&Quality::FULL, Some(steps));
                    let frame = if whole {
                        engine.render_whole_fovea(&eyes, quality, steps)
                    } else {
                        engine.render(&eyes, quality, steps)
                    };
                    let frame = frame.expect("a frame");
                    cut += usize::from(frame.unfinished_fovea);
                    frames.push((frame.steps, frame.unfinished, hashes(engine)));
                }
                (cut, frames)
            })
        };
        let whole = run(1, true);
        assert_eq!(whole, run(3, true), "{steps}");
        assert_eq!(whole.0, 0, "{steps}");
        let (cut, as_far) = run(2, false);
        if steps < 3_000 {
            assert_eq!(cut, 6, "{steps}");
            // No more than that.
            assert!(whole.1.iter().all(|frame| frame.1 > 0), "{steps}");
        }
        if steps > 1_000_000 {
            assert_eq!(whole.1, as_far);
        }
    }
}

/// Where the gaze has jumped to what is dearer than was known, the rim lacks what that
/// takes.
#[test]
fn steps_that_are_enough_for_the_fovea_are_spent_on_it_first() {
    let baked = baked();
    let jumps = [0, 17, 31, 3, 25, 12];
    let needs: Vec<u64> = with(&baked, &options(2, 16), |engine| {
        let need = |&number| {
            let frame = engine.render_whole_fovea(&eyes(number), &Quality::FULL, Some(0));
            frame.expect("a frame").steps
        };
        jumps.iter().map(need).collect()
    });
    with(&baked, &options(2, 16), |engine| {
        let mut unfinished = 0;
        for (&number, need) in jumps.iter().zip(needs) {
            // What is set aside for what blocks may take is not spent.
            let steps = need + 40_000;
            let frame = engine.render(&eyes(number), &Quality::FULL, Some(steps));
            let frame = frame.expect("a frame");
            assert!(!frame.unfinished_fovea, "{number}: {frame:?}");
            unfinished += frame.unfinished;
        }
        assert!(unfinished > 0);
    });
}

/// Rounds cost time: threads wait for each other at the end of each.
#[test]
fn who_looks_at_the_same_has_frames_of_one_round() {
    let baked = baked();
    with(&baked, &options(2, 16), |engine| {
        let full = engine.render(&eyes(0), &Quality::FULL, None);
        let steps = full.expect("a frame").steps;
        let mut frame = |number: u32, quality: &Quality| {
            let frame = engine.render(&eyes(number), quality, Some(2 * steps));
            let frame = frame.expect("a frame");
            assert!(frame.unfinished == 0, "{number}: {frame:?}");
            frame.rounds
        };
        for _ in 0..4 {
            assert_eq!(frame(0, &Quality::FULL), 1);
        }
        // Elsewhere, or otherwise, what is looked at comes first.
        assert!(frame(20, &Quality::FULL) > 1);
        assert_eq!(frame(20, &Quality::FULL), 1);
        assert!(frame(20, &Quality::LADDER[2]) > 1);
        assert_eq!(frame(20, &Quality::LADDER[2]), 1);
    });
}

#[test]
fn half_of_what_is_needed_finishes_what_is_looked_at() {
    let baked = baked();
    let count = cases("frames at half of the need", 400, 10_000) as u32;
    with(&baked, &options(2, 16), |engine| {
        let mut needs: Vec<u64> = (0..60)
            .map(|frame| {
                let frame = engine.render(&eyes(frame), &Quality::FULL, None);
                frame.expect("a frame").steps
            })
            .collect();
        needs.sort_unstable();
        let steps = needs[30] / 2;
        let mut governor = Governor::new();
        let (mut changes, mut unfinished, mut before) = (0, 0, 0);
        for number in 0..count {
            let sight = eyes(number)[0].lod.map(|lod| lod.gaze.line_of_sight());
            governor.follow(sight.map(|sight| sight.forward()));
            let decision = governor.decide(Allowance::Steps(steps));
            let frame = engine.render(&eyes(number), &decision.quality, decision.steps);
            let frame = frame.expect("a frame");
            assert!(frame.steps <= steps, "frame {number}: {}", frame.steps);
            assert!(!frame.unfinished_fovea, "frame {number}: {frame:?}");
            governor.learn(&decision, frame.need, taken(frame.steps));
            unfinished += u32::from(frame.unfinished > 0);
            changes += u32::from(decision.rung != before);
            before = decision.rung;
        }
        // It binds, and quality seldom changes: the viewer looks around once in 60
        // frames, and needs twice as much at one place as at another.
        assert!(before > 0);
        assert!(changes * 10 < count, "{changes} changes in {count} frames");
        assert!(
            unfinished * 20 < count,
            "{unfinished} unfinished of {count} frames"
        );
    });
}

/// Walls as large as people have them, at a half and a tenth of what they need.
#[test]
fn large_walls_are_finished_where_one_looks() {
    let baked = baked();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [1024; 2]).expect("a room");
    let viewer = Viewer::default();
    let foveated = |frame: u32| -> Vec<Observer> {
        let sights = eyes(frame).into_iter().filter_map(|eye| eye.lod);
        let pairs = sights.zip(Eye::STEREO);
        let see = pairs.map(|(lod, eye)| {
            Observer::foveated(eye, viewer.eye(eye), lod.gaze.line_of_sight(), 0.0)
        });
        see.collect()
    };
    let scene = (baked.scene(), Spectrum::default());
    for (name, eyes) in [
        ("paper", &eyes as &dyn Fn(u32) -> _),
        ("foveated", &foveated),
    ] {
        let play = |engine: &mut Engine<'_, '_, 8>| {
            for part in [2, 10] {
                let full = engine.render(&eyes(0), &Quality::FULL, None);
                let need = full.expect("a frame").steps;
                let steps = need / part;
                let mut governor = Governor::new();
                let mut rung = 0;
                // As a session begins: what a frame takes is known.
                let all = governor.decide(Allowance::Unlimited);
                governor.learn(&all, need, taken(need));
                for number in 0..8 {
                    let decision = governor.decide(Allowance::Steps(steps));
                    let frame = engine.render(&eyes(number), &decision.quality, decision.steps);
                    let frame = frame.expect("a frame");
                    assert!(
                        frame.steps <= steps,
                        "{name}, {part}, frame {number}: {frame:?}"
                    );
                    assert!(
                        !frame.unfinished_fovea,
                        "{name}, {part}, frame {number}: {frame:?}"
                    );
                    governor.learn(&decision, frame.need, taken(frame.steps));
                    rung = decision.rung;
                }
                assert!(rung > 0, "{name}, {part}");
            }
        };
        let (eyes, options) = (eyes(0), options(2, 32));
        with_engine(scene, &cave, &eyes, &options, None, Share::ALL, play).expect("an engine");
    }
}

#[test]
fn fewer_faces_are_those_of_a_level() {
    let baked = baked();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).expect("a room");
    let wall = cave.screens().next().expect("a wall");
    let [left, _] = eyes(3)[..] else {
        panic!("two eyes")
    };
    let view = render::view(wall, &left).expect("a view");
    let lod = left.lod.expect("a level of detail");
    let plain = Renderer::<8>::new(baked.scene(), Simd::detect(), Settings::default());
    let last = baked.scene().rungs() - 1;
    for (level, fewest) in [
        (1.0, 0),
        (0.5, last.div_ceil(2)),
        (0.0, last),
        (-1.0, last),
        (2.0, 0),
    ] {
        let fewer = plain.with_faces_of_level(level);
        let (own, full) = (
            fewer.with_level_of_detail(lod),
            plain.with_level_of_detail(lod),
        );
        let mut seen = [0; 2];
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            assert_eq!(fewer.detail(&view, x, y).expect("a pixel").rung, fewest);
            let (own, full) = (own.detail(&view, x, y), full.detail(&view, x, y));
            let Some((own, full)) = own.zip(full) else {
                assert_eq!(own, full);
                continue;
            };
            assert_eq!((own.depth, own.rung), (full.depth, full.rung.max(fewest)));
            seen[usize::from(own.rung > full.rung)] += 1;
        }
        assert!(seen[0] > 0 || fewest == last, "{seen:?}");
        assert_eq!(seen[1] > 0, fewest > 0, "{seen:?}");
    }
}

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
    let frames = cases("frames at half of what they take", 100, 10_000);
    let mut command = shisen(folder.path());
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

/// Of an X server that takes the connection and says nothing.
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
        let mut command = shisen(folder.path());
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
        (&["--budget", "33"][..], "33 of what: give 33ms or 33steps"),
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
    let mut command = shisen(folder.path());
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
    }
    assert_eq!(report["gains"].as_array().expect("gains").len(), 2);
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
