//! Frames that follow a tracker.

use crate::cli::arguments::whole;
use crate::cli::output::counted;
use crate::cli::output::failure::{Failure, Fault};
use crate::cli::tracker::{Happenings, Interrupt, TrackerName};
use crate::live::{LiveTracker, TrackerEvent};
use crate::tracker::calibration::{Calibrated, estimation};
use crate::tracker::{Feed, Notice};
use clap::Args;
use miette::Diagnostic;
use serde::Serialize;
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
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
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tracker", value_parser = whole::<u64>(1..=100_000))]
    pub(super) frames: u64,
    /// Frames shown per second
    #[arg(long, value_name = "HZ", default_value_t = 60, requires = "tracker", value_parser = whole::<u64>(1..=1_000))]
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

/// Where the viewer looks, frame after frame.
pub(super) struct Follower {
    source: Source,
    hz: u64,
    /// When frame 0 is due.
    start: Micros,
}

/// Where samples come from.
enum Source {
    /// A device, which is read while frames are traced: what waits in a line is of times
    /// that nobody knows any more.
    Device(LiveTracker),
    /// What is simulated or recorded, up to whatever time is asked for.
    Given(Box<Given>),
}

struct Given {
    feed: Feed,
    clock: ClockEstimator,
    estimator: GazeEstimator,
    happenings: Happenings,
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
        let mut given = Given {
            feed,
            estimator: GazeEstimator::new(config).map_err(Failure::from_error)?,
            clock: ClockEstimator::new(spec.clock()).map_err(Failure::from_error)?,
            happenings: Happenings::default(),
        };
        let hz = arguments.hz;
        if !given.feed.is_live() {
            let (start, source) = (given.feed.begin(), Source::Given(Box::new(given)));
            return Ok(Self { source, hz, start });
        }
        let mut since = Micros(0);
        while given.listen(Micros(0)) == 0 && !interrupt.came() {
            if given.feed.is_resetting() {
                since = given.feed.now();
            }
            if given.feed.now().since(since) > PATIENCE {
                return Err(Nothing {
                    spec: name.to_string(),
                }
                .into());
            }
        }
        let start = given.feed.now();
        let Given {
            feed,
            clock,
            estimator,
            mut happenings,
        } = given;
        let tell = move |happening| happenings.tell(happening);
        let tracker =
            LiveTracker::start(feed, clock, estimator, tell).map_err(Failure::from_error)?;
        let source = Source::Device(tracker);
        Ok(Self { source, hz, start })
    }

    /// Where the viewer looks when frame `number` is shown: of all samples
    /// that came until a refresh before.
    pub(super) fn frame(&mut self, number: u64) -> Estimate {
        let refresh = |count: u64| Micros(count * 1_000_000 / self.hz);
        let due = self.start.after(refresh(number));
        let shown = self.start.after(refresh(number + 1));
        match &mut self.source {
            Source::Device(tracker) => {
                while tracker.now() < due {
                    std::thread::sleep(Duration::from_micros(200));
                }
                // A frame that could not be begun in time is shown later.
                let late = tracker.now().since(due);
                tracker.latch(shown.after(late)).estimate
            }
            Source::Given(given) => {
                while given.listen(due) > 0 {}
                given.estimator.estimate(shown, &mut |_| {})
            }
        }
    }
}

impl Given {
    /// Takes what came by then; how many samples there were.
    fn listen(&mut self, until: Micros) -> u64 {
        let Self {
            feed,
            clock,
            estimator,
            happenings,
        } = self;
        let mut samples = 0;
        let mut troubles = Vec::new();
        let now = feed.now();
        feed.poll(until, &mut |notice| match notice {
            Notice::Decoded(event) => match event {
                Event::Sample(sample) => {
                    let arrival = sample.arrival;
                    let stamp = clock.stamp(&sample, &mut |event| {
                        happenings.tell(TrackerEvent::Clock(event, arrival));
                    });
                    estimator.push(&sample, stamp.time, &mut |event| {
                        happenings.tell(TrackerEvent::Gaze(event, arrival));
                    });
                    samples += 1;
                }
                Event::Message(message) => {
                    estimator.on_message(&message, &mut |_| {});
                    happenings.tell(TrackerEvent::Device(message, now));
                }
                _ => {}
            },
            Notice::Trouble(trouble) => troubles.push(trouble),
            other => happenings.tell(TrackerEvent::Feed(other)),
        });
        let counts = feed.counts();
        for trouble in troubles {
            happenings.tell(TrackerEvent::Trouble(trouble, counts));
        }
        samples
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
        write!(
            f,
            "{} of scene {} along {} at {} Hz, {:.3} s of tracing",
            counted(self.frames.len() as u64, "frame"),
            self.scene,
            self.tracker,
            self.hz,
            self.seconds
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
    use crate::tracker::pty::Pty;
    use crate::tracker::serve::{Begin, serve};
    use crate::tracker::{MockSpec, ProtocolSpec, simulated};
    use shisen_tracker::estimate::State;
    use shisen_tracker::head::hatire::{Config, FRAME_BYTES};
    use shisen_tracker::sample::Sample;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// Along the device on a line.
    fn follower(line: &Path, protocol: &str) -> Follower {
        let name = format!("serial:{}?protocol={protocol}", line.display());
        let name: TrackerName = name.parse().unwrap();
        let arguments = TrackerArguments {
            tracker: None,
            calibration: None,
            frames: 1,
            hz: 60,
        };
        let interrupt = Interrupt::watched();
        let follower = Follower::new(&name, &arguments, HeadPose::IDENTITY, &interrupt);
        follower.unwrap_or_else(|_| panic!("it says something"))
    }

    /// Frames that take longer than a tracker's samples are apart, by far: what comes in
    /// the meantime keeps its times.
    #[test]
    fn what_comes_during_a_slow_frame_keeps_its_times() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut pty = Pty::open(&path).unwrap();
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        let device = std::thread::spawn(move || {
            let spec = MockSpec {
                rate: 250,
                seed: 4,
                ..MockSpec::default()
            };
            let protocol: ProtocolSpec = "link".parse().unwrap();
            let source = simulated(&spec).unwrap();
            serve(&mut pty, source, &protocol, Begin::AtOnce, &mut |_| {
                !until.load(Ordering::Relaxed)
            })
        });
        let mut follower = follower(&path, "link");
        let Source::Device(tracker) = &follower.source else {
            panic!("it is a device");
        };
        let mut samples = tracker.latch(tracker.now()).samples;
        for number in 0..4 {
            std::thread::sleep(Duration::from_millis(1_300));
            let estimate = follower.frame(number);
            let Source::Device(tracker) = &follower.source else {
                panic!("it is a device");
            };
            let so_far = tracker.latch(tracker.now()).samples;
            assert!(so_far > samples + 200, "{so_far} {samples}");
            samples = so_far;
            // The mock blinks.
            if !estimate.blink {
                assert!(
                    matches!(estimate.state, State::Fresh | State::Hold),
                    "{estimate:?}"
                );
            }
        }
        over.store(true, Ordering::Relaxed);
        device.join().unwrap().unwrap();
    }

    /// All that comes in one burst while a frame is traced counts, also where one read
    /// does not take it.
    #[test]
    fn a_burst_counts_whole() {
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
        let Source::Device(tracker) = follower(&path, "hatire").source else {
            panic!("it is a device");
        };
        begun.store(true, Ordering::Relaxed);
        let mut pty = device.join().unwrap();
        // What is still on the line.
        std::thread::sleep(Duration::from_millis(200));
        let before = tracker.counts().samples;
        for _ in 0..RECORDS {
            assert!(pty.send(&record).unwrap());
        }
        // One read takes 4096 bytes.
        assert!(RECORDS * FRAME_BYTES as u64 > 2 * 4_096);
        let sent = std::time::Instant::now();
        while tracker.counts().samples < before + RECORDS && sent.elapsed().as_secs() < 5 {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(tracker.counts().samples, before + RECORDS);
    }
}
