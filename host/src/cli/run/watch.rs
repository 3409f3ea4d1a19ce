//! The window of `--view window`, and the thread that draws it.
//!
//! The loop and the window share no lock that either waits for. The window asks for a
//! frame when it has the time for one; the loop copies the next into the buffer that
//! comes with the asking, and goes on. Frames that nobody has asked for are counted,
//! and not copied.

mod presenter;

use super::watched::{Command, Watched};
use crate::cave::Cave;
use crate::cli::output::failure::Failure;
use crate::live::FrameRecord;
use crate::show::dashboard::{About, Dashboard, Frame, Latency};
use crate::show::stereo::Stereo;
use crate::show::window::Window;
use glam::Vec3;
use presenter::{Ending, Presenter};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Latencies that are shown at most.
const REMEMBERED: usize = 240;

/// Commands that wait at most: keys that are pressed faster are lost.
const COMMANDS: usize = 16;

/// How long the window may take to end: a server that hangs keeps it.
const PATIENCE: Duration = Duration::from_secs(1);

/// What both threads know.
#[derive(Debug, Default)]
struct Shared {
    /// Where the mouse says the viewer looks.
    gaze: Mutex<Option<Vec3>>,
    over: AtomicBool,
    shown: AtomicU64,
    dropped: AtomicU64,
}

/// The loop's end of a window.
pub(super) struct Watch {
    shared: Arc<Shared>,
    /// A buffer for a frame, where the window wants one: that of an older frame, or
    /// none yet.
    wanted: Receiver<Option<Box<Frame>>>,
    frames: SyncSender<Box<Frame>>,
    commands: Receiver<Command>,
    thread: Option<JoinHandle<Ending>>,
    ending: Option<Ending>,
    /// The frame that is being copied.
    next: Option<Box<Frame>>,
    about: Arc<About>,
    latencies: VecDeque<Latency>,
}

impl Watch {
    /// Opens a window for the screens of a room, whose screenshots go to a folder.
    ///
    /// # Errors
    /// A window or a thread that there is not.
    pub(super) fn open(cave: &Cave, stereo: Stereo, folder: &Path) -> Result<Self, Failure> {
        let window = Window::open("Shisen", Dashboard::SIZE)?;
        let shared = Arc::new(Shared::default());
        let (ask, wanted) = sync_channel(1);
        let (frames, taken) = sync_channel(1);
        let (command, commands) = sync_channel(COMMANDS);
        let mut presenter = Presenter::new(
            window,
            Arc::clone(&shared),
            (ask, taken, command),
            folder.to_owned(),
        );
        let cave = cave.clone();
        let thread = std::thread::Builder::new()
            .name("window".to_owned())
            .spawn(move || presenter.run(&cave, stereo))
            .map_err(Failure::from_error)?;
        Ok(Self {
            shared,
            wanted,
            frames,
            commands,
            thread: Some(thread),
            ending: None,
            next: None,
            about: Arc::new(About {
                scene: String::new(),
                lod: String::new(),
                fill: String::new(),
                hz: 1,
                budget: String::new(),
            }),
            latencies: VecDeque::with_capacity(REMEMBERED),
        })
    }

    /// Before the first frame of a scene.
    pub(super) fn begin(&mut self, about: About) {
        self.about = Arc::new(about);
    }

    /// Says what fills where the gaze skips rays.
    pub(super) fn set_fill(&mut self, fill: &str) {
        let mut about = (*self.about).clone();
        fill.clone_into(&mut about.fill);
        self.about = Arc::new(about);
    }

    /// Whether the window has time for a frame.
    pub(super) fn is_wanted(&mut self) -> bool {
        if self.next.is_some() {
            return true;
        }
        match self.wanted.try_recv() {
            Ok(buffer) => {
                self.next = Some(buffer.unwrap_or_else(|| Box::new(self.empty())));
                true
            }
            Err(TryRecvError::Empty) => false,
            Err(TryRecvError::Disconnected) => {
                self.end();
                false
            }
        }
    }

    /// The frame that is wanted, to be filled in.
    pub(super) fn frame(&mut self) -> Option<&mut Frame> {
        self.next.as_deref_mut()
    }

    /// Hears of a frame that was seen: the one that was wanted goes to the window.
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

    /// Where the mouse says the viewer looks, if it does.
    pub(super) fn gaze(&self) -> Option<Vec3> {
        *lock(&self.shared.gaze)
    }

    /// What a key asks for, if any was pressed.
    pub(super) fn command(&mut self) -> Option<Command> {
        self.commands.try_recv().ok()
    }

    /// Whether it is there.
    pub(super) fn is_open(&self) -> bool {
        self.thread
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
    }

    /// Whether somebody closed it.
    pub(super) fn was_closed(&mut self) -> bool {
        if !self.is_open() {
            self.end();
        }
        self.ending == Some(Ending::Closed)
    }

    /// Ends it, unless a server that hangs keeps it.
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

    /// Takes notice of its end.
    fn end(&mut self) {
        if let Some(thread) = self.thread.take() {
            // One that panicked has said so.
            self.ending = Some(thread.join().unwrap_or(Ending::Gone));
            // A mouse that is gone points nowhere.
            *lock(&self.shared.gaze) = None;
        }
    }

    /// To be filled in.
    fn empty(&self) -> Frame {
        Frame {
            about: Arc::clone(&self.about),
            pictures: Vec::new(),
            eyes: Vec::new(),
            head: shisen_core::gaze::HeadPose::IDENTITY,
            tiles: Vec::new(),
            record: FrameRecord::default(),
            latencies: Vec::with_capacity(REMEMBERED),
        }
    }
}

fn lock<T>(one: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    one.lock().unwrap_or_else(PoisonError::into_inner)
}
