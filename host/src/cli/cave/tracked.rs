//! The gaze of frames that follow a tracker.

use crate::cli::prelude::*;
use crate::cli::tracker::{Interrupt, Opened, TrackerName, names};
use crate::live::LiveTracker;
use crate::tracker::{Feed, Notice, Role, TrackerEvent};
use shisen_core::gaze::HeadPose;
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::Estimate;
use shisen_tracker::time::Micros;

#[derive(Debug, Args)]
pub(super) struct TrackerArguments {
    /// Tracker to follow in place of --look and --head-report, whose origin is at --head: mock,
    /// mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME, hid:VENDOR:PRODUCT, replay:FILE
    /// or one on the network (see `shisen tracker --help`), or head=SPEC and, in a --tracker of its
    /// own, gaze=SPEC. Frame k is shown k + 1 refreshes after the start. Ctrl-C ends the command with
    /// the frames that are done
    #[arg(long, value_name = "SPEC",
          conflicts_with_all = ["look", "head_report", "up", "fixate", "fill"])]
    pub(super) tracker: Vec<TrackerName>,
    #[arg(
        long,
        value_name = "TOML",
        requires = "tracker",
        help = "File of `shisen tracker calibrate`, or with a [screen]; its [room_from_tracker] \
                  counts before --head"
    )]
    calibration: Option<PathBuf>,
    /// Frames to render
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tracker",
          value_parser = whole::<u64>(1..=100_000))]
    pub(super) frames: u64,
    /// Frames shown per second
    #[arg(long, value_name = "HZ", default_value_t = 60, requires = "tracker",
          value_parser = whole::<u64>(1..=1_000))]
    pub(super) hz: u64,
}

/// Longest wait for the first sample, after a reset if there is one.
const PATIENCE: Micros = Micros::from_millis(5_000);

/// Says where the viewer looks, frame after frame.
pub(super) struct Follower {
    source: Source,
    hz: u64,
    /// When frame 0 is due.
    start: Micros,
}

enum Source {
    /// A device. It is read while frames are traced, so that samples keep their times of arrival.
    Device(LiveTracker),
    /// A simulation or recording, which is read up to any time.
    Given(Box<Opened>),
}

impl Follower {
    /// Opens a tracker whose origin is at `head`, and waits for the first sample of a device.
    pub(super) fn new(
        trackers: &[TrackerName],
        arguments: &TrackerArguments,
        head: HeadPose,
        room: &Cave,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut given = Opened::new(
            trackers,
            arguments.calibration.as_deref(),
            head,
            room,
            false,
        )?;
        let hz = arguments.hz;
        if !given
            .sources
            .iter()
            .any(|(source, _)| source.feed.is_live())
        {
            let (start, source) = (given.feed().begin(), Source::Given(Box::new(given)));
            return Ok(Self { source, hz, start });
        }
        let mut since = Micros(0);
        while given.take(Micros(0)) == 0 && !interrupt.came() {
            let now = given.feed().now();
            if given
                .sources
                .iter()
                .any(|(source, _)| source.feed.is_resetting())
            {
                since = now;
            }
            if now.since(since) > PATIENCE {
                let name = names(trackers);
                let message = format!("no sample came from {name} in {} s", PATIENCE.seconds());
                let help = "see what comes with `shisen tracker monitor SPEC`";
                return Err(Fault::new(message, help).into());
            }
        }
        let start = given.feed().now();
        let source = Source::Device(given.listen()?);
        Ok(Self { source, hz, start })
    }

    /// Returns where the viewer looks when frame `number` is shown, by all samples that came until
    /// one refresh before.
    pub(super) fn frame(&mut self, number: u64) -> Estimate {
        let refresh = |count: u64| Micros(count * 1_000_000 / self.hz);
        let due = self.start.after(refresh(number));
        let shown = self.start.after(refresh(number + 1));
        match &mut self.source {
            Source::Device(tracker) => {
                while tracker.now() < due {
                    std::thread::sleep(Duration::from_micros(200));
                }
                // A frame that begins late is shown late.
                let late = tracker.now().since(due);
                tracker.latch(shown.after(late)).estimate
            }
            Source::Given(given) => {
                while given.take(due) > 0 {}
                given.gaze.estimator.estimate(shown, &mut |_| {})
            }
        }
    }
}

impl Opened {
    /// Returns the feed whose clock is the viewer's.
    fn feed(&self) -> &Feed {
        &self.sources[0].0.feed
    }

    /// Takes what came until a time of the viewer's; returns the number of samples.
    fn take(&mut self, until: Micros) -> u64 {
        let (gaze, begin) = (&mut self.gaze, self.sources[0].0.feed.begin());
        let mut samples = 0;
        for (source, announcer) in &mut self.sources {
            let (feed, intake) = (&mut source.feed, &mut source.intake);
            let mut troubles = Vec::new();
            let now = feed.now();
            let own = feed.begin().after(until.since(begin));
            feed.poll(own, &mut |notice| match notice {
                Notice::Decoded(event) => match event {
                    Event::Sample(sample) => {
                        let arrival = sample.arrival;
                        let taken = intake.take(&sample, &mut |event| announcer.announce(event));
                        if let Some((sample, time)) = taken {
                            gaze.push(intake.role(), &sample, time, &mut |event| {
                                announcer.announce(TrackerEvent::Gaze(event, arrival));
                            });
                        }
                        samples += 1;
                    }
                    Event::Message(message) => {
                        if intake.role() != Role::Head {
                            gaze.estimator.on_message(&message, &mut |_| {});
                        }
                        announcer.announce(TrackerEvent::Device(message, now));
                    }
                    _ => {}
                },
                Notice::Trouble(trouble) => troubles.push(trouble),
                Notice::Offset { at, offset } => intake.set_offset(at, offset),
                other => announcer.announce(TrackerEvent::Feed(other)),
            });
            let counts = feed.counts();
            for trouble in troubles {
                announcer.announce(TrackerEvent::Trouble(trouble, counts));
            }
        }
        samples
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::tracker::pty::Pty;
    use crate::tracker::serve::serve;
    use crate::tracker::{MockSpec, simulated};
    use shisen_tracker::estimate::State;
    use shisen_tracker::head::hatire::{Config, FRAME_BYTES};
    use shisen_tracker::sample::Sample;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// Returns a follower of the device on a line.
    fn follower(line: &Path, protocol: &str) -> Follower {
        let name = format!("serial:{}?protocol={protocol}", line.display());
        let arguments = TrackerArguments {
            tracker: Vec::new(),
            calibration: None,
            frames: 1,
            hz: 60,
        };
        let interrupt = Interrupt::watched();
        let trackers = [name.parse().unwrap()];
        let room = Cave::new(Vec::new()).unwrap_or_else(|_| panic!("no walls"));
        let head = HeadPose::IDENTITY;
        let follower = Follower::new(&trackers, &arguments, head, &room, &interrupt);
        follower.unwrap_or_else(|_| panic!("it says something"))
    }

    fn device(follower: &Follower) -> &LiveTracker {
        match &follower.source {
            Source::Device(tracker) => tracker,
            Source::Given(_) => panic!("it is a device"),
        }
    }

    #[test]
    fn samples_during_a_slow_frame_keep_their_times() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut pty = Pty::open(&path).unwrap();
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        let sender = std::thread::spawn(move || {
            let spec = MockSpec {
                rate: 250,
                seed: 4,
                ..MockSpec::default()
            };
            let (source, protocol) = (simulated(&spec).unwrap(), "link".parse().unwrap());
            let goes_on = &mut |_| !until.load(Ordering::Relaxed);
            serve(&mut pty, source, &protocol, None, goes_on)
        });
        let mut follower = follower(&path, "link");
        let count = |follower: &Follower| {
            let tracker = device(follower);
            tracker.latch(tracker.now()).samples
        };
        for number in 0..4 {
            let before = count(&follower);
            std::thread::sleep(Duration::from_millis(1_300));
            let estimate = follower.frame(number);
            let samples = count(&follower);
            assert!(samples > before + 200, "{samples} {before}");
            // The mock blinks.
            let known = matches!(estimate.state, State::Fresh | State::Hold);
            assert!(estimate.blink || known, "{estimate:?}");
        }
        over.store(true, Ordering::Relaxed);
        sender.join().unwrap().unwrap();
    }

    #[test]
    fn a_burst_counts_whole() {
        const RECORDS: u64 = 400;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut pty = Pty::open(&path).unwrap();
        let record = Config::default().encode(&Sample::arrived(Micros(0)));
        let begun = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&begun);
        let sender = std::thread::spawn(move || {
            while !until.load(Ordering::Relaxed) {
                pty.send(&record).unwrap();
                std::thread::sleep(Duration::from_millis(5));
            }
            pty
        });
        let follower = follower(&path, "hatire");
        let tracker = device(&follower);
        begun.store(true, Ordering::Relaxed);
        let mut pty = sender.join().unwrap();
        // Until the line is empty.
        std::thread::sleep(Duration::from_millis(200));
        let before = tracker.counts().samples;
        for _ in 0..RECORDS {
            assert!(pty.send(&record).unwrap());
        }
        // One read takes 4096 bytes.
        assert!(RECORDS * FRAME_BYTES as u64 > 2 * 4_096);
        let sent = Instant::now();
        while tracker.counts().samples < before + RECORDS && sent.elapsed().as_secs() < 5 {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(tracker.counts().samples, before + RECORDS);
    }
}
