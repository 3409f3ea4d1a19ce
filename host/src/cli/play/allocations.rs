//! Tests that frames take no memory after the first ones.
//!
//! The allocator of this program's tests counts what all threads take, with a simulated tracker, a
//! decoder and a serial port. Other tests run at the same time, so a process of its own renders.

use super::{Change, LiveArguments, TimeArguments, live_lod};
use crate::live::{Display, FrameRecord, SessionSettings, SingleMachine};
use crate::render::CaptureOptions;
use crate::tracker::pty::Pty;
use crate::tracker::serve::serve;
use crate::tracker::{Feed, MockSpec, Notice, Spec, simulated};
use clap::Parser;
use shisen_tracker::decoder::Event;
use shisen_tracker::serial::Serial;
use std::alloc::{GlobalAlloc, Layout, System};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The system's allocator, with a count.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often memory was taken.
static TAKEN: AtomicU64 = AtomicU64::new(0);

#[allow(unsafe_code, reason = "every allocator is unsafe")]
// SAFETY: the system's allocator does everything.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::SeqCst);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::SeqCst);
        // SAFETY: as the caller promises.
        unsafe { System.realloc(memory, layout, size) }
    }
}

/// Frames before memory is counted, and while it is.
const WARM_UP: u64 = 40;
const COUNTED: u64 = 80;

/// Set for the process that renders.
const ALONE: &str = "SHISEN_COUNTS_ALLOCATIONS";

/// Counts how often frames take memory.
#[derive(Default)]
struct Auditor {
    frames: u64,
    before: u64,
    taken: u64,
}

impl Display for Auditor {
    fn after(&mut self, _: &FrameRecord) -> bool {
        self.frames += 1;
        let taken = TAKEN.load(Ordering::SeqCst);
        if self.frames == WARM_UP {
            self.before = taken;
        }
        self.taken = taken - self.before;
        self.frames < WARM_UP + COUNTED
    }
}

#[derive(Parser)]
#[command(mut_arg("lod", live_lod))]
struct Line {
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    time: TimeArguments,
}

/// Returns how often frames that follow a tracker took memory.
fn taken(arguments: &[&str], capture: Option<CaptureOptions>, tracker: &Spec) -> u64 {
    let usual = ["frames", "--size", "32", "--threads", "2", "--hz", "200"];
    let is_whole = |argument: &&str| ["off", "foveated"].contains(argument);
    let few: &[_] = if arguments.iter().any(is_whole) {
        &[]
    } else {
        &["--levels", "3"]
    };
    let line = Line::parse_from(usual.iter().chain(arguments).chain(few));
    let live = line.live.changed(Change::Capture(capture));
    let prepared = live.prepare(&line.time).unwrap();
    let tracker = live
        .listen(&[tracker.clone().into()], &prepared.cave)
        .unwrap();
    let settings = prepared.settings(SessionSettings::default());
    let mut auditor = Auditor::default();
    let played = prepared.play(&tracker, &settings, &mut auditor, &mut SingleMachine);
    let report = played.unwrap().report;
    assert_eq!(report.frames, WARM_UP + COUNTED);
    assert!(report.samples > 0, "nothing was said");
    auditor.taken
}

/// Checks a serial port that is silent and that sends, its feed, and frames that follow it.
fn serial_ports_take_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tracker");
    let mut pty = Pty::open(&path).unwrap();
    let mut port = Serial::open(path.to_str().unwrap(), 115_200).unwrap();
    let mut buffer = [0; 64];
    let begun = Instant::now();
    let before = TAKEN.load(Ordering::SeqCst);
    for _ in 0..50 {
        assert_eq!(port.read(&mut buffer).unwrap(), 0);
    }
    // Each of them waited.
    assert!(begun.elapsed() >= Duration::from_millis(100));
    for _ in 0..50 {
        assert!(pty.send(b"what came").unwrap());
        assert_eq!(port.read(&mut buffer).unwrap(), 9);
    }
    let after = TAKEN.load(Ordering::SeqCst);
    assert_eq!(after - before, 0, "by a port");
    drop((port, pty));
    let mut pty = Pty::open(&path).unwrap();
    let over = AtomicBool::new(false);
    let spec = format!("serial:{}?protocol=hatire", path.display());
    let spec: Spec = spec.parse().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let tracker = simulated(&MockSpec::default()).unwrap();
            let protocol = "hatire".parse().unwrap();
            let goes_on = &mut |_| !over.load(Ordering::SeqCst);
            serve(&mut pty, tracker, &protocol, None, goes_on).unwrap();
        });
        let mut feed = Feed::open(&spec).unwrap();
        let mut samples = 0;
        let mut before = 0;
        while samples < 400 {
            let now = feed.now();
            feed.poll(now, &mut |notice| {
                samples += u64::from(matches!(notice, Notice::Decoded(Event::Sample(_))));
            });
            if samples <= 200 {
                before = TAKEN.load(Ordering::SeqCst);
            }
        }
        assert_eq!(TAKEN.load(Ordering::SeqCst) - before, 0, "by a feed");
        drop(feed);
        assert_eq!(taken(&[], None, &spec), 0, "from a serial port");
        over.store(true, Ordering::SeqCst);
    });
}

#[test]
fn frames_take_no_memory() {
    if std::env::var_os(ALONE).is_none() {
        let own = std::env::current_exe().unwrap();
        let name = "cli::play::allocations::frames_take_no_memory";
        let child = Command::new(own)
            .args(["--exact", name, "--test-threads=1", "--nocapture"])
            .env(ALONE, "1")
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&child.stdout);
        assert!(said.contains("1 passed"), "{said}{child:?}");
        return;
    }
    let so_far = || TAKEN.load(Ordering::SeqCst);
    let before = so_far();
    drop(Box::new(before));
    assert!(so_far() > before, "it counts");
    let mock: Spec = "mock:seed=4".parse().unwrap();
    for arguments in [
        &["--lod", "paper"][..],
        &["--lod", "paper-ellipse", "--budget", "40000steps"],
        &["--lod", "foveated", "--budget", "40000steps"],
        &["--lod", "off", "--budget", "off"],
        &["--budget", "paper-scaled"],
    ] {
        assert_eq!(taken(arguments, None, &mock), 0, "{arguments:?}");
    }
    let capture = CaptureOptions {
        size: 16,
        ..CaptureOptions::default()
    };
    assert_eq!(taken(&[], Some(capture), &mock), 0, "with a capture");
    let bytes: Spec = "mock:as=fastrak".parse().unwrap();
    assert_eq!(taken(&[], None, &bytes), 0, "from a decoder");
    serial_ports_take_no_memory();
}
