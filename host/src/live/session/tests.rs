//! Sessions in which something takes longer than a refresh.

use super::*;
use crate::bake::{AnyScene, Baked};
use crate::cave::{BuiltInCave, Cave, Eye, Viewer};
use crate::live::latency::Leg;
use crate::live::swap::Share;
use crate::live::with_engine;
use crate::render::Options;
use crate::scene::builtin::grid;
use crate::tracker::calibration::estimation;
use crate::tracker::{ComposedGaze, Feed, Intake, Role, Source, Spec};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::GazeEstimator;

/// Delays of the order and of the swap of a frame that is shown: microseconds.
type Delays = fn(u64) -> [u64; 2];

const NONE: Delays = |_| [0; 2];

fn pause(microseconds: u64) {
    std::thread::sleep(Duration::from_micros(microseconds));
}

struct Slow {
    delays: Delays,
    shown: u64,
}

impl SwapLock for Slow {
    // Warm-up frames take as long as the first one.
    fn order(&mut self, _: &Order) -> Result<(), SwapError> {
        pause((self.delays)(self.shown)[0]);
        Ok(())
    }

    fn swap(&mut self, _: u64) -> Result<(), SwapError> {
        pause((self.delays)(self.shown)[1]);
        self.shown += 1;
        Ok(())
    }
}

/// A display that keeps all records.
#[derive(Default)]
struct Watcher(Vec<FrameRecord>);

impl Display for Watcher {
    fn after(&mut self, record: &FrameRecord) -> bool {
        self.0.push(record.clone());
        true
    }
}

fn play(
    settings: SessionSettings,
    delays: Delays,
    tracker: &str,
) -> (SessionReport, Vec<FrameRecord>) {
    let spec: Spec = tracker.parse().unwrap();
    let feed = Feed::open(&spec).unwrap();
    let config = estimation(&spec, feed.senses(&spec), HeadPose::IDENTITY, None);
    let estimator = GazeEstimator::new(config).unwrap();
    let clock = ClockEstimator::new(spec.clock()).unwrap();
    let tracker = {
        let intake = Intake::new(Role::All, clock, &spec, None);
        let source = (
            Source { feed, intake },
            Box::new(|_| {}) as crate::live::Report,
        );
        LiveTracker::start(vec![source], ComposedGaze::new(estimator), None).unwrap()
    };
    let baked = Baked::<8>::new(&grid(2.0)).unwrap();
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [8; 2]).unwrap();
    let eyes = [Observer::new(Eye::Left, Viewer::default().eye(Eye::Left))];
    let options = Options {
        threads: 1,
        ..Options::default()
    };
    let scene = AnyScene::from(baked.scene());
    let by_steps = matches!(settings.budget, FrameBudget::Steps(_));
    if by_steps {
        // Samples come.
        pause(50_000);
    }
    let mut first = None;
    let mut observe = |look: &Look, seen: &mut Vec<Observer>| {
        first.get_or_insert(look.forward);
        *seen = eyes.to_vec();
        true
    };
    let (mut watcher, mut lock) = (Watcher::default(), Slow { delays, shown: 0 });
    let session = |engine: &mut dyn Engine| {
        run(
            engine,
            &tracker,
            &settings,
            &mut observe,
            &mut watcher,
            &mut lock,
        )
        .unwrap()
    };
    let played = with_engine(scene, &cave, &eyes, &options, None, Share::ALL, session);
    let (report, Watcher(records)) = (played.unwrap(), watcher);
    // Frames of a budget of steps do not depend on what has come.
    assert!(!by_steps || first == Some(Vec3::NEG_Z));
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

/// Each frame has a refresh of its own after it was done, and the report counts the records.
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
        let times = [record.latch_us, record.first_ray_us, record.done_us];
        assert!(times.is_sorted(), "{record:?}");
        if let (Some(sample), Some(arrive)) = (record.sample_us, record.arrive_us) {
            assert!(sample <= arrive && arrive <= record.latch_us, "{record:?}");
        }
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
    assert_eq!(report.rungs.iter().sum::<u64>(), report.frames);
    let refreshes = report.seconds * 1.0e6 / period as f64;
    assert!(refreshes >= refresh as f64 - 0.01, "{refreshes} {refresh}");
}

fn median(records: &[FrameRecord], of: fn(&[FrameRecord]) -> u64) -> u64 {
    let mut all: Vec<u64> = records.windows(2).map(of).collect();
    all.sort_unstable();
    all[all.len() / 2]
}

/// Refreshes from a frame to the next one.
fn gap(records: &[FrameRecord]) -> u64 {
    median(records, |pair| pair[1].refresh - pair[0].refresh)
}

/// Returns microseconds from when a frame is shown until the next takes the gaze.
fn wait(records: &[FrameRecord]) -> u64 {
    median(records, |pair| pair[1].latch_us - pair[0].present_us)
}

const TRACKER: &str = "mock:rate=1000";

#[test]
fn frames_longer_than_a_refresh_skip_some_and_take_the_gaze_late() {
    // Delays of the system are short beside such refreshes.
    let settings = settings(25, 12);
    let delays: Delays = |_| [84_000, 0];
    let (report, late) = play(settings, delays, TRACKER);
    assert_eq!((report.late_frames, gap(&late)), (12, 3));
    let latch = Latch::Early;
    let (_, early) = play(SessionSettings { latch, ..settings }, delays, TRACKER);
    assert_eq!(gap(&early), 3);
    let waits = [wait(&late), wait(&early)];
    assert!(waits[0] > waits[1] + 4_000, "{waits:?}");
    // Frames of three refreshes keep such a budget.
    let budget = FrameBudget::Time(Duration::from_millis(120));
    let (report, records) = play(SessionSettings { budget, ..settings }, delays, TRACKER);
    assert_eq!(gap(&records), 3);
    assert!(report.late_frames < 4, "{}", report.late_frames);
}

#[test]
fn a_frame_that_is_held_up_is_late_and_the_next_ones_are_not() {
    let held_up: [Delays; 2] = [
        |frame| [if frame == 20 { 55_000 } else { 0 }, 0],
        // This machine is done but another is not.
        |frame| [0, if frame == 20 { 55_000 } else { 0 }],
    ];
    for delays in held_up {
        // A busy machine holds up others, too: one of three runs is quiet.
        let is_quiet = (0..3).any(|_| {
            let (_, records) = play(settings(100, 40), delays, TRACKER);
            assert!(records[20].late, "{:?}", records[20]);
            let skipped = records[20].refresh - records[19].refresh;
            assert!(skipped >= 6, "{skipped}");
            [gap(&records[20..]), gap(&records[..20])] == [1; 2]
        });
        assert!(is_quiet, "frames after one that was held up were late, too");
    }
}

#[test]
fn one_stall_lowers_no_quality() {
    let delays: Delays = |frame| [if frame == 20 { 1_500_000 } else { 0 }, 0];
    let settings = SessionSettings {
        budget: FrameBudget::Time(Duration::from_millis(50)),
        ..settings(20, 40)
    };
    let (_, records) = play(settings, delays, TRACKER);
    assert!(records[20].late);
    assert!(records[19..].iter().all(|record| record.rung == 0));
}

#[test]
fn a_late_tracker_is_as_late_as_it_says() {
    let (report, records) = play(settings(100, 60), NONE, "mock:rate=1000&delay=0.035");
    let age = |record: &FrameRecord| Some(record.arrive_us? - record.sample_us?);
    let mut ages: Vec<u64> = records.iter().filter_map(age).skip(5).collect();
    ages.sort_unstable();
    // A busy machine takes some of them up late.
    assert!(
        ages[0] >= 34_000 && ages[ages.len() / 2] < 37_000,
        "{ages:?}"
    );
    let summary = |leg: Leg| report.latencies.summary(leg).unwrap();
    let to_wall = summary(Leg::MotionToWall);
    assert!(to_wall.least >= 35.0, "{to_wall:?}");
    // The loop adds nothing to that.
    assert!(summary(Leg::ArriveToFirstRay).p50 < 10.0);
}

#[test]
fn a_budget_of_steps_does_not_depend_on_the_clock() {
    let settings = SessionSettings {
        budget: FrameBudget::Steps(2_000),
        ..settings(100, 5)
    };
    let (_, records) = play(settings, NONE, "mock");
    // Later frames follow the mock, which looks elsewhere.
    assert!(records.iter().any(|record| record.forward[2] > -1.0));
}
