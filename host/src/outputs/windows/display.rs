//! A display that shows outputs, an X server or a graphics card: a thread that carries out requests,
//! and one that listens.
//!
//! Who renders frames waits for neither: a display that hangs or goes away is told of, and the
//! frames of others go on.

use super::pane::{Pane, Sheets};
use super::turns::{Change, Turn};
use crate::live::lock;
use crate::show::window::WindowError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Messages that wait to be sent: more mean that the display hangs.
const WAITING: usize = 64;

/// How long the end of a thread is waited for.
const PATIENCE: Duration = Duration::from_millis(500);

/// What to do for a pane, by its number.
pub(super) enum Request {
    /// Puts rows of pixels into a pixmap, by the shared segment or else in the message.
    Fill(usize, Arc<Sheets>, usize),
    /// Presents a pixmap at a refresh.
    Present(usize, Turn),
    /// Presents two pixmaps by turns, from an even refresh on.
    Pair {
        pane: usize,
        pair: [u32; 2],
        frame: u32,
        from: u64,
    },
    /// Copies a pixmap to a window now: for servers without Present.
    Copy {
        pane: usize,
        pixmap: u32,
        size: [u16; 2],
    },
    End,
}

/// What a display says.
#[derive(Debug)]
pub(super) enum Heard {
    /// A frame of a pane was shown at a refresh, or passed over for a newer one.
    Shown {
        server: usize,
        pane: usize,
        serial: u32,
        at: Instant,
        refresh: u64,
        skipped: bool,
    },
    /// Something to be told.
    Said(String),
    /// The display has gone.
    Gone(usize, String),
}

/// How pixels get to a display.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MemoryWay {
    /// In shared memory that is the pixmap.
    Pixmap,
    /// In shared memory that is copied to the pixmap.
    Copied,
    /// In messages.
    Sent,
}

/// What differs between an X server and a graphics card.
pub(super) trait Display: Send + Sync + 'static {
    fn name(&self) -> &str;

    fn pane(&self, number: usize) -> &Pane;

    fn memory(&self) -> MemoryWay {
        MemoryWay::Pixmap
    }

    /// Returns whether frames are presented at a refresh and completions told.
    fn has_present(&self) -> bool {
        true
    }

    /// Returns whether all panes count the same refreshes.
    fn has_one_clock(&self) -> bool;

    /// Shows a pixmap at its refresh, or at the first one after it.
    fn present(&self, number: usize, turn: Turn) -> Result<(), WindowError>;

    /// Carries out a request that is no presentation.
    fn carry_out(&self, _: Request) -> Result<(), WindowError> {
        Ok(())
    }

    /// Sends what waits to be sent.
    fn flush(&self) -> Result<(), WindowError> {
        Ok(())
    }

    /// Tells of what happens, until it is over.
    fn hear(&self, heard: &Sender<Heard>, over: &AtomicBool) -> Result<(), WindowError>;

    /// Presents each eye's picture at its turn, or black.
    fn queue(&self, number: usize, queued: &[Turn], is_blank: bool) -> Result<(), WindowError> {
        let pane = self.pane(number);
        let sheets = pane.sheets();
        let black = sheets.and_then(|sheets| Some(sheets.all.last()?.pixmap));
        for &turn in queued {
            let pixmap = black.filter(|_| is_blank).unwrap_or(turn.pixmap);
            pane.note_reader(pixmap, true);
            self.present(number, Turn { pixmap, ..turn })?;
        }
        self.flush()
    }

    /// Takes that an eye was shown at its turn, and queues the next ones.
    fn take_turn(
        &self,
        number: usize,
        serial: u32,
        refresh: u64,
        heard: &Sender<Heard>,
    ) -> Result<(), WindowError> {
        let pane = self.pane(number);
        let Some(turns) = &pane.turns else {
            return Ok(());
        };
        let mut turns = lock(turns);
        let (queued, change) = turns.see(serial, refresh);
        let screen = &pane.output.show;
        let said = change.map(|change| match change {
            Change::Blanked => format!(
                "\"{screen}\" showed the wrong eye in 3 of 60 refreshes: it is dark until the \
                 eyes keep their turns; a machine with less to do, or --stereo side-by-side, does"
            ),
            Change::Unblanked => format!("the eyes of \"{screen}\" keep their turns again"),
        });
        if let Some(said) = said {
            let _ = heard.send(Heard::Said(said));
        }
        self.queue(number, &queued, turns.is_blank)
    }
}

/// Carries out requests until the last.
fn serve(display: &dyn Display, due: &Receiver<Request>) -> Result<(), WindowError> {
    while let Ok(request) = due.recv() {
        match request {
            Request::Present(pane, turn) => display.present(pane, turn)?,
            Request::Pair {
                pane,
                pair,
                frame,
                from,
            } => {
                if let Some(turns) = &display.pane(pane).turns {
                    let mut turns = lock(turns);
                    let queued = turns.renew(pair, frame, from);
                    display.queue(pane, &queued, turns.is_blank)?;
                }
            }
            Request::End => return display.carry_out(request),
            Request::Fill(..) | Request::Copy { .. } => display.carry_out(request)?,
        }
        display.flush()?;
    }
    Ok(())
}

/// A display and its threads.
pub(super) struct Server {
    pub(super) display: Arc<dyn Display>,
    requests: SyncSender<Request>,
    threads: Vec<JoinHandle<()>>,
    over: Arc<AtomicBool>,
    /// Whether it did not answer in time.
    pub(super) silent: bool,
    pub(super) gone: bool,
}

impl Server {
    /// Starts the threads of a display. What happens goes to `heard`, with the display's number.
    pub(super) fn start(
        number: usize,
        display: Arc<dyn Display>,
        heard: &Sender<Heard>,
    ) -> Result<Self, WindowError> {
        let (requests, due) = sync_channel(WAITING);
        let over = Arc::new(AtomicBool::new(false));
        let (sender, listener, end) = (Arc::clone(&display), Arc::clone(&display), over.clone());
        let (said, more) = (heard.clone(), heard.clone());
        let threads = [
            spawn("display", move || {
                if let Err(error) = serve(&*sender, &due) {
                    let _ = said.send(Heard::Gone(number, error.to_string()));
                }
            })?,
            spawn("refreshes", move || {
                if let Err(error) = listener.hear(&more, &end) {
                    let _ = more.send(Heard::Gone(number, error.to_string()));
                }
            })?,
        ];
        Ok(Self {
            display,
            requests,
            threads: threads.into(),
            over,
            silent: false,
            gone: false,
        })
    }

    /// Sends a request unless the display hangs; returns whether it did.
    pub(super) fn ask(&mut self, request: Request) -> bool {
        match self.requests.try_send(request) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.silent = true;
                false
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.requests.try_send(Request::End);
        let last = Instant::now() + PATIENCE;
        while Instant::now() < last && !self.threads.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, WindowError> {
    let thread = std::thread::Builder::new().name(name.to_owned()).spawn(run);
    thread.map_err(|error| WindowError::gone(&error.to_string()))
}
