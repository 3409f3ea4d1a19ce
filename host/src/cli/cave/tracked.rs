//! Frames that follow a tracker.

use super::super::failure::{Failure, Fault};
use super::super::tracker::{
    Happenings, Interrupt, TrackerName, warn_of_sensors, whole, with_drops,
};
use super::super::warn;
use clap::Args;
use miette::Diagnostic;
use serde::Serialize;
use shisen::tracker::calibration::{Calibrated, estimation};
use shisen::tracker::{Feed, Notice};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::{Estimate, GazeEstimator};
use shisen_tracker::time::Micros;
use std::path::PathBuf;
use std::time::Duration;
use thiserror::Error;

/// Which tracker, and when its frames are shown.
#[derive(Debug, Args)]
pub(super) struct TrackerArguments {
    /// Follow a tracker in place of --look and --head-report: mock,
    /// mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME,
    /// hid:VENDOR:PRODUCT or replay:FILE; --head is where its origin is. Frame
    /// k is shown k + 1 refreshes after the start; Ctrl-C ends with those that
    /// are done
    #[arg(long, value_name = "SPEC", conflicts_with_all = ["look", "head_report", "up", "fixate", "fill"])]
    pub(super) tracker: Option<TrackerName>,
    /// What `shisen tracker calibrate` wrote for it, or a file with its [screen];
    /// its [`room_from_tracker`] counts before --head
    #[arg(long, value_name = "TOML", requires = "tracker")]
    calibration: Option<PathBuf>,
    /// Frames to render
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tracker",
          allow_negative_numbers = true, value_parser = whole::<1, 100_000>)]
    pub(super) frames: u64,
    /// Frames shown per second
    #[arg(long, value_name = "HZ", default_value_t = 60, requires = "tracker",
          allow_negative_numbers = true, value_parser = whole::<1, 1_000>)]
    pub(super) hz: u64,
}

/// A tracker that says nothing.
#[derive(Debug, Error, Diagnostic)]
#[error("no sample came from {spec} in {} s", PATIENCE.0 / 1_000_000)]
#[diagnostic(help("see what comes with `shisen tracker monitor '{spec}'`"))]
struct Nothing {
    spec: String,
}

/// How long a device may take to say something; after its reset, if it is reset.
const PATIENCE: Micros = Micros::from_millis(5_000);

/// How often a device is read before a frame, if it always has more to say.
const MOST_READS: usize = 64;

/// Where the viewer looks, frame after frame.
pub(super) struct Follower {
    feed: Feed,
    clock: ClockEstimator,
    estimator: GazeEstimator,
    happenings: Happenings,
    hz: u64,
    /// When frame 0 is due.
    start: Micros,
}

impl Follower {
    /// Of a tracker whose origin is at `head`. A device is waited for until it
    /// has said something, or an end is asked for.
    ///
    /// # Errors
    /// A tracker that is none, or says nothing.
    pub(super) fn new(
        name: &TrackerName,
        arguments: &TrackerArguments,
        head: HeadPose,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let spec = &name.spec;
        let calibration = arguments.calibration.as_deref();
        let calibrated = calibration.map(|path| Calibrated::load(path, spec));
        let calibrated = calibrated.transpose()?;
        let feed = Feed::open(spec)?;
        let config = estimation(spec, feed.senses(spec), head, calibrated.as_ref());
        let estimator = GazeEstimator::new(config).map_err(Failure::from_error)?;
        let clock = ClockEstimator::new(ClockConfig::default()).map_err(Failure::from_error)?;
        let mut follower = Self {
            start: feed.begin(),
            feed,
            clock,
            estimator,
            happenings: Happenings::default(),
            hz: arguments.hz,
        };
        if follower.feed.is_live() {
            let mut since = Micros(0);
            while follower.listen(Micros(0)) == 0 && !interrupt.came() {
                if follower.feed.is_resetting() {
                    since = follower.feed.now();
                }
                if follower.feed.now().since(since) > PATIENCE {
                    return Err(Nothing {
                        spec: name.to_string(),
                    }
                    .into());
                }
            }
            follower.start = follower.feed.now();
        }
        Ok(follower)
    }

    /// Takes what came by then; how many samples there were.
    fn listen(&mut self, until: Micros) -> u64 {
        let Self {
            feed,
            clock,
            estimator,
            happenings,
            ..
        } = self;
        let mut samples = 0;
        let mut troubles = Vec::new();
        let say = |what: Option<String>| {
            if let Some(what) = what {
                warn(&what);
            }
        };
        let now = feed.now();
        feed.poll(until, &mut |notice| match notice {
            Notice::Decoded(event) => match event {
                Event::Sample(sample) => {
                    let arrival = sample.arrival;
                    let stamp = clock.stamp(&sample, &mut |event| {
                        say(happenings.of_clock(&event, arrival));
                    });
                    estimator.push(&sample, stamp.time, &mut |event| {
                        warn_of_sensors(&event);
                        say(happenings.of_gaze(&event, arrival));
                    });
                    samples += 1;
                }
                Event::Message(message) => {
                    estimator.on_message(&message, &mut |_| {});
                    say(happenings.of_device(&message, now));
                }
                _ => {}
            },
            Notice::Trouble(trouble) => troubles.push(trouble),
            other => say(Happenings::of_feed(&other)),
        });
        for trouble in troubles {
            warn(&with_drops(&trouble, &feed.counts()));
        }
        samples
    }

    /// Where the viewer looks when frame `number` is shown: of all samples
    /// that came until a refresh before.
    pub(super) fn frame(&mut self, number: u64) -> Estimate {
        let refresh = |count: u64| Micros(count * 1_000_000 / self.hz);
        let due = self.start.after(refresh(number));
        let shown = self.start.after(refresh(number + 1));
        // A device that sent while the last frame was traced has more to say
        // than one read takes.
        for _ in 0..MOST_READS {
            if self.listen(due) == 0 {
                break;
            }
        }
        while self.feed.is_live() && self.feed.now() < due {
            self.listen(due);
            std::thread::sleep(Duration::from_micros(200));
        }
        // A frame that could not be begun in time is shown later.
        let late = if self.feed.is_live() {
            self.feed.now().since(due)
        } else {
            Micros(0)
        };
        self.estimator.estimate(shown.after(late), &mut |_| {})
    }
}

/// Frames that followed a tracker.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) tracker: String,
    pub(super) hz: u64,
    pub(super) frames: Vec<FrameReport>,
    /// Of tracing alone.
    pub(super) seconds: f64,
    pub(super) threads: usize,
    pub(super) size: u32,
    pub(super) scene: String,
}

/// One of them.
#[derive(Debug, Serialize)]
pub(super) struct FrameReport {
    frame: u64,
    shown_us: u64,
    head: HeadReport,
    gaze: [f32; 3],
    state: &'static str,
    widen: f32,
    blink: bool,
    gaze_age_us: Option<u64>,
    frame_hash: String,
    images: Vec<String>,
}

#[derive(Debug, Serialize)]
struct HeadReport {
    position: [f32; 3],
    orientation: [f32; 4],
}

impl FrameReport {
    pub(super) fn new(
        frame: u64,
        estimate: &Estimate,
        frame_hash: String,
        images: Vec<String>,
    ) -> Self {
        Self {
            frame,
            shown_us: estimate.for_time.0,
            head: HeadReport {
                position: estimate.head.position.to_array(),
                orientation: estimate.head.orientation.to_array(),
            },
            gaze: estimate.line_of_sight.forward().to_array(),
            state: estimate.state.name(),
            widen: estimate.widen,
            blink: estimate.blink,
            gaze_age_us: estimate.gaze_age.map(|age| age.0),
            frame_hash,
            images,
        }
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for one in &self.frames {
            let [x, y, z] = one.gaze;
            writeln!(
                f,
                "frame {}: gaze {x:.4} {y:.4} {z:.4}, {}, {}",
                one.frame, one.state, one.frame_hash
            )?;
        }
        let count = self.frames.len();
        let plural = if count == 1 { "" } else { "s" };
        write!(
            f,
            "{count} frame{plural} of scene {} along {} at {} Hz, {:.3} s of tracing",
            self.scene, self.tracker, self.hz, self.seconds
        )
    }
}

/// The folder of frame `number` within `folder`; made where it does not exist.
///
/// # Errors
/// A folder that cannot be made.
pub(super) fn folder(folder: &std::path::Path, number: u64) -> Result<std::path::PathBuf, Failure> {
    let path = folder.join(format!("frame-{number:05}"));
    match std::fs::create_dir_all(&path) {
        Ok(()) => Ok(path),
        Err(reason) => Err(Fault::OutputFolder { path, reason }.into()),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use shisen::tracker::pty::Pty;
    use shisen_tracker::head::hatire::{Config, FRAME_BYTES};
    use shisen_tracker::sample::Sample;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// All that has come while the last frame was traced counts for the next, also
    /// where one read does not take it.
    #[test]
    fn a_frame_has_all_that_has_come() {
        const RECORDS: u64 = 400;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut pty = Pty::open(&path).unwrap();
        let record = Config::default().encode(&Sample::arrived(Micros(0)));
        let begun = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&begun);
        let device = std::thread::spawn(move || {
            while !until.load(Ordering::Relaxed) {
                pty.send(&record).unwrap();
                std::thread::sleep(Duration::from_millis(5));
            }
            pty
        });
        let name = format!("serial:{}?protocol=hatire", path.display());
        let name: TrackerName = name.parse().unwrap();
        let arguments = TrackerArguments {
            tracker: None,
            calibration: None,
            frames: 1,
            hz: 60,
        };
        let interrupt = Interrupt::new();
        let follower = Follower::new(&name, &arguments, HeadPose::IDENTITY, &interrupt);
        let Ok(mut follower) = follower else {
            panic!("it says something");
        };
        begun.store(true, Ordering::Relaxed);
        let mut pty = device.join().unwrap();
        follower.frame(0);
        let before = follower.feed.counts().samples;
        for _ in 0..RECORDS {
            assert!(pty.send(&record).unwrap());
        }
        // One read takes 4096 bytes.
        assert!(RECORDS * FRAME_BYTES as u64 > 2 * 4_096);
        follower.frame(0);
        assert_eq!(follower.feed.counts().samples, before + RECORDS);
    }
}
