//! The window of `--view window`, and the thread that draws it.
//!
//! The loop of frames never waits for the window. The window asks for a frame when it has time;
//! the loop copies its next frame into the buffer that comes with the request. It only counts
//! frames without a request.

#[cfg_attr(not(all(unix, feature = "window")), path = "watch/no_presenter.rs")]
mod presenter;

pub(super) use presenter::{is_possible, refresh};

use crate::cli::play::Change;
use crate::cli::prelude::*;
use crate::live::{FrameRecord, lock};
use crate::show::dashboard::{About, Frame, Latency};
use crate::show::stereo::Stereo;
use crate::tracker::Steering;
use glam::Vec3;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// Most latencies shown.
const REMEMBERED: usize = 240;

/// Most commands that wait: keys that are pressed faster are lost.
const COMMANDS: usize = 16;

/// Longest wait for the end of the window, whose server may hang.
const PATIENCE: Duration = Duration::from_secs(1);

/// What a key of the window asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Command {
    Change(Change),
    /// The next way to fill in where the gaze skips rays.
    Fill,
    End,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct Watched {
    /// Frames shown.
    pub(super) shown: u64,
    /// Frames not shown, for lack of time or after the window's end.
    pub(super) dropped: u64,
    /// Whether the window was open at the end.
    pub(super) is_open: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// There were no more frames.
    Over,
    /// Somebody closed it.
    Closed,
    /// Its server went away, or memory ran out.
    Gone,
}

/// The window's ends of the channels.
struct Ends {
    ask: SyncSender<Option<Box<Frame>>>,
    frames: Receiver<Box<Frame>>,
    commands: SyncSender<Command>,
}

/// What both threads share.
#[derive(Debug, Default)]
struct Shared {
    /// The direction at which the mouse points.
    gaze: Mutex<Option<Vec3>>,
    keys: Mutex<SteeringKeys>,
    over: AtomicBool,
    shown: AtomicU64,
    dropped: AtomicU64,
}

/// The keys that steer: Home, Left, Up, Right, Down, Page Up and Page Down.
#[derive(Debug, Default)]
struct SteeringKeys {
    held: [bool; 7],
    pressed: [bool; 7],
}

impl SteeringKeys {
    fn set(&mut self, key: usize, held: bool) {
        if let Some(key) = self.held.get_mut(key) {
            *key = held;
        }
        if let Some(key) = self.pressed.get_mut(key) {
            *key |= held;
        }
    }

    fn take(&mut self) -> Steering {
        let mut keys = std::mem::take(&mut self.pressed);
        for (key, held) in keys.iter_mut().zip(self.held) {
            *key |= held;
        }
        let [is_homeward, left, up, right, down, page_up, page_down] = keys;
        let pull = |to: bool, fro: bool| f32::from(i8::from(to) - i8::from(fro));
        Steering {
            forward: pull(up, down),
            turn: pull(right, left),
            rise: pull(page_up, page_down),
            pointing: None,
            is_homeward,
        }
    }
}

/// The loop's end of a window.
pub(super) struct Watch {
    shared: Arc<Shared>,
    /// The window's requests, each with the buffer of an older frame if there is one.
    wanted: Receiver<Option<Box<Frame>>>,
    frames: SyncSender<Box<Frame>>,
    pub(super) commands: Receiver<Command>,
    thread: Option<JoinHandle<Ending>>,
    ending: Option<Ending>,
    /// The frame that is being copied.
    next: Option<Box<Frame>>,
    about: Arc<About>,
    latencies: VecDeque<Latency>,
}

impl Watch {
    /// Opens a window for the screens of a room. Its screenshots go to a folder.
    pub(super) fn open(cave: &Cave, stereo: Stereo, folder: &Path) -> Result<Self, Failure> {
        let shared = Arc::new(Shared::default());
        let (ask, wanted) = sync_channel(1);
        let (frames, taken) = sync_channel(1);
        let (command, commands) = sync_channel(COMMANDS);
        let ends = Ends {
            ask,
            frames: taken,
            commands: command,
        };
        let thread = presenter::start(cave, stereo, folder, Arc::clone(&shared), ends)?;
        Ok(Self {
            shared,
            wanted,
            frames,
            commands,
            thread: Some(thread),
            ending: None,
            next: None,
            about: Arc::default(),
            latencies: VecDeque::with_capacity(REMEMBERED),
        })
    }

    pub(super) fn begin(&mut self, about: About) {
        self.about = Arc::new(about);
    }

    pub(super) fn set_fill(&mut self, fill: &str) {
        let mut about = (*self.about).clone();
        fill.clone_into(&mut about.fill);
        self.about = Arc::new(about);
    }

    /// Returns the frame to be filled in, if the window has time for one.
    pub(super) fn wanted(&mut self) -> Option<&mut Frame> {
        if self.next.is_none() {
            match self.wanted.try_recv() {
                Ok(buffer) => self.next = Some(buffer.unwrap_or_default()),
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => self.end(),
            }
        }
        self.next.as_deref_mut()
    }

    /// Takes a frame's record, and sends the requested frame to the window.
    pub(super) fn hear(&mut self, record: &FrameRecord) {
        if self.latencies.len() == REMEMBERED {
            self.latencies.pop_front();
        }
        let sample = record.sample_us;
        self.latencies.push_back(Latency {
            milliseconds: sample
                .map(|sample| record.present_us.saturating_sub(sample) as f32 * 1.0e-3),
            late: record.late,
        });
        let sent = self.next.take().is_some_and(|mut frame| {
            frame.record.clone_from(record);
            frame.about = Arc::clone(&self.about);
            frame.latencies.clear();
            frame.latencies.extend(&self.latencies);
            self.frames.try_send(frame).is_ok()
        });
        if !sent {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Returns the direction at which the mouse points, if it is the gaze.
    pub(super) fn gaze(&self) -> Option<Vec3> {
        *lock(&self.shared.gaze)
    }

    /// Returns where keys steer the viewer that are held, or were pressed since the last call.
    pub(super) fn steering(&self) -> Steering {
        lock(&self.shared.keys).take()
    }

    pub(super) fn is_open(&self) -> bool {
        let thread = self.thread.as_ref();
        thread.is_some_and(|thread| !thread.is_finished())
    }

    pub(super) fn was_closed(&mut self) -> bool {
        if !self.is_open() {
            self.end();
        }
        self.ending == Some(Ending::Closed)
    }

    /// Ends the window, unless its server hangs.
    pub(super) fn finish(mut self) -> Watched {
        let is_open = self.is_open();
        self.shared.over.store(true, Ordering::Relaxed);
        let last = Instant::now() + PATIENCE;
        while self.is_open() && Instant::now() < last {
            std::thread::sleep(Duration::from_millis(5));
        }
        if !self.is_open() {
            self.end();
        }
        Watched {
            shown: self.shared.shown.load(Ordering::Relaxed),
            dropped: self.shared.dropped.load(Ordering::Relaxed),
            is_open,
        }
    }

    /// Notes the window's end.
    fn end(&mut self) {
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so.
            self.ending = Some(thread.join().unwrap_or(Ending::Gone));
            *lock(&self.shared.gaze) = None;
            *lock(&self.shared.keys) = SteeringKeys::default();
        }
    }
}
