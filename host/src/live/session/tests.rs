//! What becomes of frames where something takes longer than a refresh.

use super::*;
use crate::bake::Baked;
use crate::cave::{BuiltInCave, Cave, Eye, Viewer};
use crate::live::latency::Leg;
use crate::live::swap::{Alone, Gathered, Share, Waits};
use crate::live::with_engine;
use crate::render::Options;
use crate::scene::builtin::grid;
use crate::tracker::calibration::estimation;
use crate::tracker::{Feed, Spec};
use shisen_core::frame::Spectrum;
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::GazeEstimator;

/// Refreshes a second.
const HZ: u32 = 100;

/// What takes so many microseconds of a frame: nothing has a number before the first
/// one that is shown.
struct Delays {
    order: fn(Option<u64>) -> u64,
    swap: fn(u64) -> u64,
    present: fn(u64) -> u64,
}

const NONE: Delays = Delays {
    order: |_| 0,
    swap: |_| 0,
    present: |_| 0,
};

fn pause(microseconds: u64) {
    std::thread::sleep(Duration::from_micros(microseconds));
}

/// One machine that takes its time.
struct Slow<'d> {
    delays: &'d Delays,
    shown: u64,
    alone: Alone,
}

impl SwapLock for Slow<'_> {
    fn share(&self) -> Share {
        self.alone.share()
    }

    fn order(&mut self, order: &Order) -> Result<(), SwapError> {
        let is_shown = order.purpose == Purpose::Shown;
        pause((self.delays.order)(is_shown.then_some(self.shown)));
        self.alone.order(order)
    }

    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        self.alone.obey()
    }

    fn gather(&mut self, own: &Done) -> Result<Gathered, SwapError> {
        self.alone.gather(own)
    }

    fn swap(&mut self, frame: u64) -> Result<(), SwapError> {
        pause((self.delays.swap)(self.shown));
        self.shown += 1;
        self.alone.swap(frame)
    }

    fn end(&mut self) -> Result<(), SwapError> {
        self.alone.end()
    }

    fn waits(&self) -> Option<Waits<'_>> {
        self.alone.waits()
    }
}

/// Looks at frames that take their time to show.
struct Watcher<'d> {
    delays: &'d Delays,
    /// Where the viewer was first taken to look.
    first: Option<Vec3>,
    records: Vec<FrameRecord>,
}

impl Stage<8> for Watcher<'_> {
    fn observe(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> bool {
        self.first.get_or_insert(look.forward);
        *eyes = vec![Observer::new(Eye::Left, Viewer::default().eye(Eye::Left))];
        true
    }

    fn present(&mut self, _: &Engine<'_, '_, 8>, _: &Look, _: &[Observer]) {
        pause((self.delays.present)(self.records.len() as u64));
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        self.records.push(record.clone());
        true
    }
}

/// Frames that follow a tracker, and what was said of each.
fn play(
    settings: SessionSettings,
    delays: &Delays,
    tracker: &str,
) -> (SessionReport, Vec<FrameRecord>) {
    let spec: Spec = tracker.parse().unwrap();
    let feed = Feed::open(&spec).unwrap();
    let head = HeadPose {
        position: Vec3::ZERO,
        orientation: glam::Quat::IDENTITY,
    };
    let config = estimation(&spec, feed.senses(&spec), head, None);
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
    let of = |engine: &mut Engine<'_, '_, 8>| {
        let mut watcher = Watcher {
            delays,
            first: None,
            records: Vec::new(),
        };
        let mut lock = Slow {
            delays,
            shown: 0,
            alone: Alone,
        };
        let by_steps = matches!(settings.budget, FrameBudget::Steps(_));
        if by_steps {
            // Samples come.
            pause(50_000);
        }
        let report = run(engine, &tracker, &settings, &mut watcher, &mut lock).unwrap();
        if by_steps {
            assert_eq!(watcher.first, Some(Vec3::NEG_Z));
        }
        (report, watcher.records)
    };
    let (report, records) =
        with_engine(scene, &cave, &eyes, &options, None, Share::ALL, of).unwrap();
    adds_up(&report, &records, 1_000_000 / u64::from(settings.hz));
    (report, records)
}

#[test]
fn what_a_budget_of_steps_begins_with_is_no_matter_of_the_clock() {
    let settings = SessionSettings {
        budget: FrameBudget::Steps(2_000),
        ..settings(5)
    };
    let (_, records) = play(settings, &NONE, "mock");
    // What follows is the mock's, which looks nearly there.
    assert!(records.iter().any(|record| record.forward[2] > -1.0));
}

fn settings(frames: u64) -> SessionSettings {
    SessionSettings {
        hz: HZ,
        frames: Some(frames),
        ..SessionSettings::default()
    }
}

/// Each frame has a refresh of its own, the first after it was done or a later one, and
/// what is counted is what they say.
fn adds_up(report: &SessionReport, records: &[FrameRecord], period: u64) {
    assert_eq!(report.frames, records.len() as u64);
    let mut refresh = 0;
    for record in records {
        assert!(record.refresh > refresh, "{record:?}");
        // At the earliest.
        assert!(record.due_refresh > refresh, "{record:?}");
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
    assert_eq!(report.refreshes, refresh);
    let late = records.iter().filter(|record| record.late).count();
    assert_eq!(report.late_frames, late as u64);
    let followed = records.iter().filter(|record| record.follows_gaze).count();
    assert_eq!(report.frames_without_gaze, report.frames - followed as u64);
    let counted = |leg: Leg| report.latencies.of(leg).map_or(0, |of| of.frames);
    for leg in [
        Leg::SampleToArrive,
        Leg::ArriveToFirstRay,
        Leg::MotionToWall,
    ] {
        assert_eq!(counted(leg), followed as u64);
    }
    let over_time = records.iter().filter(|record| record.over_time).count();
    assert_eq!(report.over_time_frames, over_time as u64);
    assert_eq!(report.rungs.iter().sum::<u64>(), report.frames);
    let refreshes = report.seconds * 1.0e6 / period as f64;
    assert!(refreshes >= refresh as f64 - 0.01, "{refreshes} {refresh}");
}

fn median(of: impl Iterator<Item = u64>) -> u64 {
    let mut of: Vec<u64> = of.collect();
    of.sort_unstable();
    of[of.len() / 2]
}

/// Refreshes from a frame to the next one.
fn gap(records: &[FrameRecord]) -> u64 {
    median(
        records
            .windows(2)
            .map(|pair| pair[1].refresh - pair[0].refresh),
    )
}

/// Microseconds from when a frame is shown until the next takes the gaze.
fn wait(records: &[FrameRecord]) -> u64 {
    let pairs = records.windows(2);
    median(pairs.map(|pair| pair[1].latch_us - pair[0].present_us))
}

const TRACKER: &str = "mock:rate=1000";

#[test]
fn frames_longer_than_a_refresh_skip_some_and_take_the_gaze_late() {
    // Of a display so slow that what holds a thread up is little beside its refreshes.
    let refresh = 1_000_000 / 25;
    let settings = SessionSettings {
        hz: 25,
        ..settings(12)
    };
    let delays = Delays {
        order: |_| 96_000,
        ..NONE
    };
    let (report, late) = play(settings, &delays, TRACKER);
    assert_eq!(report.late_frames, 12);
    assert_eq!(gap(&late), 3);
    let (_, early) = play(
        SessionSettings {
            latch: Latch::Early,
            ..settings
        },
        &delays,
        TRACKER,
    );
    assert_eq!(gap(&early), 3);
    assert!(
        wait(&late) > wait(&early) + 4_000,
        "{} {}",
        wait(&late),
        wait(&early)
    );
    // A budget of three refreshes is kept by frames that take as many.
    let (report, records) = play(
        SessionSettings {
            budget: FrameBudget::Time(Duration::from_micros(3 * refresh)),
            ..settings
        },
        &delays,
        TRACKER,
    );
    assert_eq!(gap(&records), 3);
    assert!(report.late_frames < 4, "{}", report.late_frames);
}

#[test]
fn a_frame_that_is_held_up_is_late_and_the_next_ones_are_not() {
    for delays in [
        Delays {
            order: |frame| if frame == Some(20) { 55_000 } else { 0 },
            ..NONE
        },
        // When it is done, but not all others are.
        Delays {
            swap: |frame| if frame == 20 { 55_000 } else { 0 },
            ..NONE
        },
    ] {
        let (_, records) = play(settings(40), &delays, TRACKER);
        assert!(records[20].late, "{:?}", records[20]);
        let skipped = records[20].refresh - records[19].refresh;
        assert!(skipped >= 6, "{skipped}");
        assert_eq!(gap(&records[20..]), 1);
        assert_eq!(gap(&records[..20]), 1);
    }
}

#[test]
fn whoever_shows_frames_slowly_makes_none_of_them_late() {
    let delays = Delays {
        present: |_| 15_500,
        ..NONE
    };
    let (report, records) = play(settings(30), &delays, TRACKER);
    assert_eq!(gap(&records), 2);
    assert!(report.late_frames < 10, "{}", report.late_frames);
}

#[test]
fn one_stall_lowers_no_quality() {
    let delays = Delays {
        order: |frame| if frame == Some(20) { 1_500_000 } else { 0 },
        ..NONE
    };
    let settings = SessionSettings {
        hz: 20,
        budget: FrameBudget::Time(Duration::from_millis(50)),
        ..settings(40)
    };
    let (_, records) = play(settings, &delays, TRACKER);
    assert!(records[20].late);
    assert_eq!(records[19].rung, 0);
    let rungs: Vec<usize> = records[21..].iter().map(|record| record.rung).collect();
    assert!(rungs.iter().all(|&rung| rung == 0), "{rungs:?}");
}

#[test]
fn a_tracker_later_than_a_frame_is_as_late_as_it_says() {
    let (report, records) = play(settings(60), &NONE, "mock:rate=1000&delay=0.035");
    let age = |record: &FrameRecord| Some(record.arrive_us? - record.sample_us?);
    let ages: Vec<u64> = records.iter().filter_map(age).collect();
    assert!(ages.len() > 10, "{records:?}");
    let mut ages = ages[5..].to_vec();
    ages.sort_unstable();
    assert!(ages[0] >= 34_000, "{ages:?}");
    // A machine with other work takes some of them up late.
    assert!(ages[ages.len() / 2] < 37_000, "{ages:?}");
    let of = |leg: Leg| report.latencies.of(leg).unwrap();
    assert!(
        of(Leg::MotionToWall).least >= 35.0,
        "{:?}",
        of(Leg::MotionToWall)
    );
    // Nothing of that is added by the loop.
    assert!(of(Leg::ArriveToFirstRay).p50 < 10.0);
}
