//! Sessions in which something takes longer than a refresh.

use super::*;
use crate::bake::Baked;
use crate::cave::{BuiltInCave, Cave, Eye, Viewer};
use crate::live::latency::Leg;
use crate::live::swap::Share;
use crate::live::with_engine;
use crate::render::Options;
use crate::scene::builtin::grid;
use crate::tracker::calibration::estimation;
use crate::tracker::{Feed, Spec};
use shisen_core::frame::Spectrum;
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::GazeEstimator;

/// One machine that takes this long more for each order.
struct Slow(Duration);

impl SwapLock for Slow {
    fn order(&mut self, _: &Order) -> Result<(), SwapError> {
        std::thread::sleep(self.0);
        Ok(())
    }
}

#[derive(Default)]
struct Watcher {
    first: Option<Vec3>,
    records: Vec<FrameRecord>,
}

impl Display<8> for Watcher {
    fn observe(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> bool {
        self.first.get_or_insert(look.forward);
        *eyes = vec![Observer::new(Eye::Left, Viewer::default().eye(Eye::Left))];
        true
    }

    fn present(&mut self, _: &Engine<'_, '_, 8>, _: &Look, _: &[Observer]) {}

    fn after(&mut self, record: &FrameRecord) -> bool {
        self.records.push(record.clone());
        true
    }
}

/// Plays frames that follow a tracker.
fn play(
    settings: SessionSettings,
    delay: Duration,
    tracker: &str,
) -> (SessionReport, Vec<FrameRecord>) {
    let spec: Spec = tracker.parse().unwrap();
    let feed = Feed::open(&spec).unwrap();
    let config = estimation(&spec, feed.senses(&spec), HeadPose::IDENTITY, None);
    let estimator = GazeEstimator::new(config).unwrap();
    let clock = ClockEstimator::new(spec.clock()).unwrap();
    let tracker = LiveTracker::start(feed, clock, estimator, |_| {}).unwrap();
    let baked = Baked::new(&grid(2.0)).unwrap();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [8; 2]).unwrap();
    let eyes = [Observer::new(Eye::Left, Viewer::default().eye(Eye::Left))];
    let options = Options {
        threads: 1,
        ..Options::default()
    };
    let scene = (baked.scene(), Spectrum::default());
    let session = |engine: &mut Engine<'_, '_, 8>| {
        let mut watcher = Watcher::default();
        let mut lock = Slow(delay);
        let by_steps = matches!(settings.budget, FrameBudget::Steps(_));
        if by_steps {
            // Samples come.
            std::thread::sleep(Duration::from_millis(50));
        }
        let report = run(engine, &tracker, &settings, &mut watcher, &mut lock).unwrap();
        // Frames of a budget of steps do not depend on what has come.
        assert!(!by_steps || watcher.first == Some(Vec3::NEG_Z));
        (report, watcher.records)
    };
    let played = with_engine(scene, &cave, &eyes, &options, None, Share::ALL, session);
    let (report, records) = played.unwrap();
    check(&report, &records, 1_000_000 / u64::from(settings.hz));
    (report, records)
}

fn settings(hz: u32, frames: u64) -> SessionSettings {
    SessionSettings {
        hz,
        frames: Some(frames),
        ..SessionSettings::default()
    }
}

/// Each frame has a refresh of its own, the first after it was done or a later one, and the
/// report counts what the records say.
fn check(report: &SessionReport, records: &[FrameRecord], period: u64) {
    let mut refresh = 0;
    for record in records {
        assert!(record.refresh > refresh && record.due_refresh > refresh);
        refresh = record.refresh;
        assert_eq!(record.late, record.refresh > record.due_refresh);
        let shown = record.due_us + period * record.refresh - period * record.due_refresh;
        // Times are whole microseconds.
        assert!(record.done_us <= shown + 2, "{record:?}");
        assert!(record.present_us + 2 >= shown, "{record:?}");
    }
    let count = |is: fn(&FrameRecord) -> bool| {
        let counted = records.iter().filter(|record| is(record));
        counted.count() as u64
    };
    let followed = count(|record| record.follows_gaze);
    assert_eq!(report.frames, records.len() as u64);
    assert_eq!(report.refreshes, refresh);
    assert_eq!(report.late_frames, count(|record| record.late));
    assert_eq!(report.over_time_frames, count(|record| record.over_time));
    assert_eq!(report.frames_without_gaze, report.frames - followed);
    for leg in [Leg::SampleToArrive, Leg::MotionToWall] {
        let summary = report.latencies.summary(leg);
        assert_eq!(summary.map_or(0, |summary| summary.frames), followed);
    }
}

/// The median over pairs of successive frames.
fn median(records: &[FrameRecord], of: fn(&[FrameRecord]) -> u64) -> u64 {
    let mut all: Vec<u64> = records.windows(2).map(of).collect();
    all.sort_unstable();
    all[all.len() / 2]
}

fn gap(records: &[FrameRecord]) -> u64 {
    median(records, |pair| pair[1].refresh - pair[0].refresh)
}

/// Microseconds from when a frame is shown until the next takes the gaze.
fn wait(records: &[FrameRecord]) -> u64 {
    median(records, |pair| pair[1].latch_us - pair[0].present_us)
}

const TRACKER: &str = "mock:rate=1000";

#[test]
fn frames_longer_than_a_refresh_skip_some_and_take_the_gaze_late() {
    // Delays of the system are short beside such refreshes.
    let settings = settings(25, 12);
    let delay = Duration::from_millis(96);
    let (report, late) = play(settings, delay, TRACKER);
    assert_eq!((report.late_frames, gap(&late)), (12, 3));
    let latch = Latch::Early;
    let (_, early) = play(SessionSettings { latch, ..settings }, delay, TRACKER);
    assert_eq!(gap(&early), 3);
    let waits = [wait(&late), wait(&early)];
    assert!(waits[0] > waits[1] + 4_000, "{waits:?}");
    // Frames of three refreshes keep such a budget.
    let budget = FrameBudget::Time(Duration::from_millis(120));
    let (report, records) = play(SessionSettings { budget, ..settings }, delay, TRACKER);
    assert_eq!(gap(&records), 3);
    assert!(report.late_frames < 4, "{}", report.late_frames);
}

#[test]
fn a_budget_of_steps_does_not_depend_on_the_clock() {
    let settings = SessionSettings {
        budget: FrameBudget::Steps(2_000),
        ..settings(100, 5)
    };
    let (_, records) = play(settings, Duration::ZERO, "mock");
    // Later frames follow the mock, which looks elsewhere.
    assert!(records.iter().any(|record| record.forward[2] > -1.0));
}
