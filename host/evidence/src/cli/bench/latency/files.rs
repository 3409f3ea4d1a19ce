//! The files of frames that follow a tracker.

use super::Run;
use shisen::files::write_atomically;
use shisen::live::Leg;
use shisen::picture::chart::{Axis, Chart, Corner, Line, Names};
use std::fmt::Write as _;
use std::io;
use std::path::Path;

pub(super) fn write(folder: &Path, runs: &[Run]) -> io::Result<Vec<String>> {
    let mut paths = Vec::new();
    for (name, text) in [("frames.csv", frames(runs)), ("latency.csv", classes(runs))] {
        let path = folder.join(name);
        write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
        paths.push(path.display().to_string());
    }
    for (name, chart) in [
        ("latency.svg", motion_to_wall(runs)),
        ("legs.svg", legs(runs)),
    ] {
        let path = folder.join(name);
        chart.write_svg(&path)?;
        paths.push(path.display().to_string());
    }
    Ok(paths)
}

/// Returns the times of each stage of each frame, by the tracker's clock.
fn frames(runs: &[Run]) -> String {
    let mut text = "tracker_hz,latch,frame,sample_us,arrive_us,latch_us,first_ray_us,done_us,\
                    present_us,late\n"
        .to_owned();
    for run in runs {
        for record in &run.records {
            let [sample, arrive] = [record.sample_us, record.arrive_us]
                .map(|time| time.map_or(String::new(), |time| time.to_string()));
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "{},{},{},{sample},{arrive},{},{},{},{},{}",
                run.tracker_hz,
                run.latch,
                record.frame,
                record.latch_us,
                record.first_ray_us,
                record.done_us,
                record.present_us,
                record.late
            );
        }
    }
    text
}

/// Returns the histograms of all legs.
fn classes(runs: &[Run]) -> String {
    let mut text = "tracker_hz,latch,leg,milliseconds,frames\n".to_owned();
    for run in runs {
        for leg in Leg::ALL {
            for (milliseconds, frames) in run.report.latencies.classes(leg) {
                let (hz, latch, name) = (run.tracker_hz, run.latch, leg.name());
                let _ = writeln!(text, "{hz},{latch},{name},{milliseconds:.6},{frames}");
            }
        }
    }
    text
}

/// Returns the part of the frames that is on the walls within a time.
fn motion_to_wall(runs: &[Run]) -> Chart {
    let named = runs.iter().map(|run| {
        let name = format!("{} Hz, {} latch", run.tracker_hz, run.latch);
        (name, run, Leg::MotionToWall)
    });
    within("From a movement of the eye to the wall".to_owned(), named)
}

/// Returns the part of the frames that has each leg behind it within a time, of the run with most
/// samples.
fn legs(runs: &[Run]) -> Chart {
    // The last of equal runs takes the gaze late.
    let run = runs.iter().max_by_key(|run| run.tracker_hz);
    let title = run.map_or(String::new(), |run| {
        format!("Legs at {} Hz, {} latch", run.tracker_hz, run.latch)
    });
    let legs = |run| Leg::ALL.map(|leg| (leg.name().replace('_', " "), run, leg));
    within(title, run.into_iter().flat_map(legs))
}

/// Returns the part of the frames that took no longer than a time.
fn within<'r>(title: String, named: impl Iterator<Item = (String, &'r Run, Leg)>) -> Chart {
    let line = |(colour, (name, run, leg)): (usize, (String, &Run, Leg))| {
        let all = run.report.latencies.summary(leg);
        let all = all.map_or(1.0, |times| times.frames as f64);
        let mut so_far = 0;
        let points = run.report.latencies.classes(leg);
        let points = points.map(|(milliseconds, frames)| {
            so_far += frames;
            (milliseconds, Some(so_far as f64 / all))
        });
        Line::new(name, colour, points)
    };
    let lines: Vec<Line> = named.enumerate().map(line).collect();
    let ends = lines.iter().filter_map(|line| line.points.last());
    let slowest = ends
        .map(|(milliseconds, _)| *milliseconds)
        .fold(1.0, f64::max);
    Chart {
        title,
        x: Axis::linear("milliseconds", "milliseconds", 0.0..1.05 * slowest),
        y: Axis::linear("frames", "part of the frames", 0.0..1.0),
        lines,
        names: Names::In(Corner::LowerRight),
        notes: Vec::new(),
    }
}
