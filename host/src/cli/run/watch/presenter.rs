//! The window's own thread.

use super::{Command, Ending, Ends, Shared, SteeringKeys, lock};
use crate::cli::play::Change;
use crate::cli::prelude::*;
use crate::scene::builtin::PaperScene;
use crate::show::dashboard::{Canvas, Dashboard, Frame, Status, ViewName};
use crate::show::stereo::Stereo;
use crate::show::window::{Event, Window};
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::thread::JoinHandle;

/// Least time between two frames: drawing takes the processor from tracing.
const LEAST: Duration = Duration::from_millis(33);

/// Priority of the window's thread below all others.
#[cfg(target_os = "linux")]
const NICE: i32 = 15;

/// Longest wait of a key.
const POLL: Duration = Duration::from_millis(8);

struct Presenter {
    window: Window,
    shared: Arc<Shared>,
    ends: Ends,
    folder: PathBuf,
    status: Status,
    /// Whether the mouse is the gaze.
    follows: bool,
    /// Whether the mouse is the gaze because its button is held.
    held: bool,
    pointer: (u32, u32),
    screenshots: u32,
    /// Whether something has to be drawn.
    stale: bool,
}

/// Opens a window for the screens of a room, and draws on a thread of its own. Screenshots go to
/// `folder`.
pub(super) fn start(
    cave: &Cave,
    stereo: Stereo,
    folder: &Path,
    shared: Arc<Shared>,
    ends: Ends,
) -> Result<JoinHandle<Ending>, Failure> {
    let mut presenter = Presenter {
        window: Window::open("Shisen", Dashboard::SIZE)?,
        shared,
        ends,
        folder: folder.to_owned(),
        status: Status {
            message: Some("preparing".to_owned()),
            ..Status::default()
        },
        follows: false,
        held: false,
        pointer: (0, 0),
        screenshots: 0,
        stale: true,
    };
    let cave = cave.clone();
    let run = move || {
        presenter.present(&cave, stereo).unwrap_or_else(|error| {
            warn(&format!("{error}; frames go on without a window"));
            Ending::Gone
        })
    };
    let thread = std::thread::Builder::new().name("window".to_owned());
    thread.spawn(run).or_fail()
}

/// Returns whether there may be a window.
pub(in crate::cli::run) fn is_possible() -> bool {
    std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty())
}

/// Returns the refreshes per second of the display, if it says.
pub(in crate::cli::run) fn refresh() -> Option<u32> {
    Window::refresh()
}

impl Presenter {
    fn present(&mut self, cave: &Cave, stereo: Stereo) -> Result<Ending, Box<dyn Error>> {
        // On Linux each thread has its priority. If the system refuses, the window keeps its own.
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
                    Event::Size(width, height) if canvas.size() != [width, height] => {
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
                // The channel has room for one request.
                asked = self.ends.ask.try_send(spare.take()).is_ok();
            }
            match self.ends.frames.recv_timeout(POLL) {
                Ok(frame) => {
                    let is_same = |old: &Frame| Arc::ptr_eq(&old.about, &frame.about);
                    if !newest.as_deref().is_some_and(is_same) {
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
    ) -> Result<(), Box<dyn Error>> {
        let Some(frame) = newest else {
            Dashboard::wait(canvas, &self.status);
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
            // Beside the screens the gaze stays where it was.
            None => *gaze,
            Some(direction) => Some(direction),
        };
        Ok(())
    }

    fn take(&mut self, event: Event, dashboard: &mut Dashboard<'_>) {
        match event {
            Event::Mouse(x, y) => self.pointer = (x, y),
            Event::Button(held) => self.held = held,
            Event::Key(key) => self.key(key, dashboard),
            Event::Steering(key, held) => lock(&self.shared.keys).set(key, held),
            Event::Unfocused => *lock(&self.shared.keys) = SteeringKeys::default(),
            Event::Size(..) | Event::Exposed | Event::Closed => {}
        }
        self.status.mouse = self.follows || self.held;
        self.stale |= self.status.mouse || !matches!(event, Event::Mouse(..));
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
                if let Ok(scene) = letter.to_string().parse::<PaperScene>() {
                    let what = format!("scene {}", scene.name());
                    self.ask_for(Command::Change(Change::Scene(scene)), &what);
                }
            }
        }
    }

    fn ask_for(&mut self, command: Command, what: &str) {
        // A paused window would not show the change.
        self.status.paused = false;
        self.status.message = Some(match self.ends.commands.try_send(command) {
            Ok(()) => format!("preparing {what}"),
            Err(_) => "too many keys".to_owned(),
        });
    }

    fn screenshot(&mut self, canvas: &Canvas) {
        self.screenshots += 1;
        let name = format!("window-{:06}.png", self.screenshots);
        let path = self.folder.join(name);
        let notes = metadata("the window of shisen run".to_owned());
        let written = make_writable(&self.folder).map_err(Failure::from);
        let written = written.and_then(|()| canvas.write_png(&path, &notes).or_fail());
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
