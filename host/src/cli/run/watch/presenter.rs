//! The window's own thread.

use super::{Shared, lock};
use crate::cave::Cave;
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{make_writable, metadata};
use crate::cli::output::warn;
use crate::cli::play::Change;
use crate::cli::run::watched::Command;
use crate::scene::builtin::PaperScene;
use crate::show::dashboard::{Canvas, Dashboard, Frame, PlaceMapError, Status, ViewName};
use crate::show::stereo::Stereo;
use crate::show::window::{Event, Window, WindowError};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

/// Between frames at least: the window is there to be looked at by the way, and
/// drawing takes the processor from tracing.
const LEAST: Duration = Duration::from_millis(33);

/// How much sooner than the window everything else is given the processor.
#[cfg(target_os = "linux")]
const NICE: i32 = 15;

/// How long keys wait at most.
const POLL: Duration = Duration::from_millis(8);

/// How a window came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Frames ended.
    Over,
    /// Somebody closed it.
    Closed,
    /// Its server went away, or memory did.
    Gone,
}

type Ends = (
    SyncSender<Option<Box<Frame>>>,
    Receiver<Box<Frame>>,
    SyncSender<Command>,
);

/// What draws.
pub(super) struct Presenter {
    window: Window,
    shared: Arc<Shared>,
    ask: SyncSender<Option<Box<Frame>>>,
    frames: Receiver<Box<Frame>>,
    commands: SyncSender<Command>,
    folder: PathBuf,
    status: Status,
    /// The mouse is the gaze until it is not; or as long as its button is held.
    follows: bool,
    held: bool,
    pointer: (u32, u32),
    screenshots: u32,
    /// Something is to be seen that is not drawn yet.
    stale: bool,
}

/// Why drawing ends.
enum Trouble {
    Window(WindowError),
    Drawing(PlaceMapError),
}

impl From<WindowError> for Trouble {
    fn from(error: WindowError) -> Self {
        Self::Window(error)
    }
}

impl From<PlaceMapError> for Trouble {
    fn from(error: PlaceMapError) -> Self {
        Self::Drawing(error)
    }
}

impl Presenter {
    pub(super) fn new(
        window: Window,
        shared: Arc<Shared>,
        (ask, frames, commands): Ends,
        folder: PathBuf,
    ) -> Self {
        Self {
            window,
            shared,
            ask,
            frames,
            commands,
            folder,
            status: Status {
                message: Some("preparing".to_owned()),
                ..Status::default()
            },
            follows: false,
            held: false,
            pointer: (0, 0),
            screenshots: 0,
            stale: true,
        }
    }

    /// The thread's life.
    pub(super) fn run(&mut self, cave: &Cave, stereo: Stereo) -> Ending {
        let why = match self.present(cave, stereo) {
            Ok(ending) => return ending,
            Err(Trouble::Window(error)) => error.to_string(),
            Err(Trouble::Drawing(error)) => error.to_string(),
        };
        warn(&format!("{why}; frames go on without a window"));
        Ending::Gone
    }

    fn present(&mut self, cave: &Cave, stereo: Stereo) -> Result<Ending, Trouble> {
        // Linux has a priority for each thread, other systems one for all of them.
        // Where the system does not let it, the window takes what it takes.
        #[cfg(target_os = "linux")]
        let _ = rustix::process::setpriority_process(None, NICE);
        let mut dashboard = Dashboard::new(cave, stereo)?;
        let [width, height] = Dashboard::SIZE;
        let mut canvas = Canvas::new(width, height);
        let mut newest: Option<Box<Frame>> = None;
        let mut spare = None;
        let mut asked = false;
        let mut drawn = Instant::now();
        loop {
            while let Some(event) = self.window.event()? {
                match event {
                    Event::Closed => return Ok(Ending::Closed),
                    Event::Size { width, height } if canvas.size() != [width, height] => {
                        canvas = Canvas::new(width, height);
                        self.stale = true;
                    }
                    Event::Key('s') => self.screenshot(&canvas),
                    event => self.take(event, &mut dashboard),
                }
            }
            if self.shared.over.load(Ordering::Relaxed) {
                return Ok(Ending::Over);
            }
            if !asked && !self.status.paused && drawn.elapsed() >= LEAST {
                // There is room for the one that is asked for.
                asked = self.ask.try_send(spare.take()).is_ok();
            }
            match self.frames.recv_timeout(POLL) {
                Ok(frame) => {
                    if newest
                        .as_ref()
                        .is_none_or(|old| !Arc::ptr_eq(&old.about, &frame.about))
                    {
                        self.status.message = None;
                    }
                    spare = newest.replace(frame);
                    asked = false;
                    self.stale = true;
                    self.shared.shown.fetch_add(1, Ordering::Relaxed);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(Ending::Over),
            }
            if std::mem::take(&mut self.stale) {
                self.status.dropped = self.shared.dropped.load(Ordering::Relaxed);
                self.draw(&mut dashboard, &mut canvas, newest.as_deref())?;
                drawn = Instant::now();
            }
        }
    }

    fn draw(
        &mut self,
        dashboard: &mut Dashboard<'_>,
        canvas: &mut Canvas,
        newest: Option<&Frame>,
    ) -> Result<(), Trouble> {
        let Some(frame) = newest else {
            dashboard.wait(canvas, &self.status);
            return Ok(self.window.show(canvas)?);
        };
        for turn in 0..dashboard.turns() {
            dashboard.draw(canvas, frame, &self.status, turn)?;
            self.window.show(canvas)?;
        }
        let (x, y) = self.pointer;
        let mut gaze = lock(&self.shared.gaze);
        *gaze = match dashboard.direction(x, y, frame) {
            _ if !self.status.mouse => None,
            // Where there is no screen the gaze stays where it was.
            None => *gaze,
            Some(direction) => Some(direction),
        };
        Ok(())
    }

    fn take(&mut self, event: Event, dashboard: &mut Dashboard<'_>) {
        match event {
            Event::Mouse { x, y } => self.pointer = (x, y),
            Event::Button(held) => self.held = held,
            Event::Key(key) => self.key(key, dashboard),
            Event::Size { .. } | Event::Exposed | Event::Closed => {}
        }
        self.status.mouse = self.follows || self.held;
        self.stale |= self.status.mouse || !matches!(event, Event::Mouse { .. });
    }

    fn key(&mut self, key: char, dashboard: &mut Dashboard<'_>) {
        self.status.message = None;
        match key {
            'v' => {
                dashboard.view = match dashboard.view {
                    ViewName::Net => ViewName::Viewer,
                    ViewName::Viewer => ViewName::Net,
                }
            }
            'h' => dashboard.levels = !dashboard.levels,
            't' => dashboard.tiles = !dashboard.tiles,
            'm' => self.follows = !self.follows,
            ' ' => self.status.paused = !self.status.paused,
            'f' => self.ask_for(Command::Fill, "another fill"),
            'l' => self.ask_for(Command::Change(Change::Detail), "another level of detail"),
            'q' | '\u{1b}' => self.ask_for(Command::End, "the end"),
            letter => {
                let named = |scene: &PaperScene| {
                    scene
                        .name()
                        .eq_ignore_ascii_case(letter.encode_utf8(&mut [0; 4]))
                };
                if let Some(scene) = PaperScene::ALL.into_iter().find(named) {
                    let what = format!("scene {}", scene.name());
                    self.ask_for(Command::Change(Change::Scene(scene)), &what);
                }
            }
        }
    }

    fn ask_for(&mut self, command: Command, what: &str) {
        // The picture that is paused is not the new one.
        self.status.paused = false;
        self.status.message = Some(match self.commands.try_send(command) {
            Ok(()) => format!("preparing {what}"),
            Err(_) => "too many keys".to_owned(),
        });
    }

    fn screenshot(&mut self, canvas: &Canvas) {
        self.screenshots += 1;
        let name = format!("window-{:06}.png", self.screenshots);
        let path = self.folder.join(name);
        let written = make_writable(&self.folder)
            .map_err(Failure::from)
            .and_then(|()| {
                let notes = metadata("the window of shisen run".to_owned());
                canvas.write_png(&path, &notes).map_err(Failure::from_error)
            });
        self.status.message = Some(match written {
            Ok(()) => path.display().to_string(),
            Err(failure) => {
                let _ = failure.print();
                "no screenshot".to_owned()
            }
        });
        self.stale = true;
    }
}
