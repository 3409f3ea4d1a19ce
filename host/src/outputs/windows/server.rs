//! An X server that shows outputs: a connection, a thread that sends to it, and one that listens.
//!
//! Who renders frames waits for neither: a server that hangs or goes away is told of, and the
//! frames of other servers go on.

use super::clock::RefreshClock;
use super::monitors::{self, Monitor};
use super::pane::{Pane, Sheets};
use super::turns::{Change, Turn};
use crate::live::lock;
use crate::show::window::{WindowError, in_time, screen};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::Event as Message;
use x11rb::protocol::present::{
    CompleteKind, CompleteMode, ConnectionExt as _, EventMask as PresentMask,
};
use x11rb::protocol::randr::{ConnectionExt as _, NotifyMask};
use x11rb::protocol::shm::ConnectionExt as _;
use x11rb::protocol::xproto::{
    Blanking, ChangeWindowAttributesAux, ConnectionExt as _, EventMask, Exposures, ImageFormat,
};
use x11rb::rust_connection::RustConnection;

/// Messages that wait to be sent: more mean that the server hangs.
const WAITING: usize = 64;

/// How long monitors are left to settle after a change.
const SETTLING: Duration = Duration::from_millis(20);

/// How long the end of a thread is waited for.
const PATIENCE: Duration = Duration::from_millis(500);

/// What to send.
pub(super) enum Request {
    /// Puts rows of pixels into a pixmap, by the shared segment or else in the message.
    Fill(Arc<Sheets>, usize),
    /// Presents a pixmap at a refresh.
    Present {
        window: u32,
        pixmap: u32,
        serial: u32,
        refresh: u64,
    },
    /// Presents two pixmaps by turns, from an even refresh on.
    Pair {
        pane: usize,
        pair: [u32; 2],
        frame: u32,
        from: u64,
    },
    /// Copies a pixmap to a window now: for servers without Present.
    Copy {
        window: u32,
        pixmap: u32,
        size: [u16; 2],
    },
    End,
}

/// What a server says.
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
    /// The server has gone.
    Gone(usize, String),
}

/// A connection and what its threads share.
pub(super) struct Shared {
    pub(super) connection: RustConnection,
    pub(super) root: u32,
    pub(super) depth: u8,
    /// Whether pictures go by shared memory, and whether that memory is the pixmap.
    pub(super) memory: MemoryWay,
    pub(super) has_present: bool,
    pub(super) panes: Vec<Pane>,
    /// This server's number and name.
    number: usize,
    pub(super) name: String,
    /// A time of the system's monotonic clock in two forms.
    epoch: (Instant, u64),
    over: AtomicBool,
}

/// How pixels get to a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MemoryWay {
    /// In shared memory that is the pixmap.
    Pixmap,
    /// In shared memory that is copied to the pixmap.
    Copied,
    /// In messages.
    Sent,
}

pub(super) struct Server {
    pub(super) shared: Arc<Shared>,
    pub(super) requests: SyncSender<Request>,
    threads: Vec<JoinHandle<()>>,
    /// Whether it did not answer in time.
    pub(super) silent: bool,
    pub(super) gone: bool,
}

/// Returns a connection to the server of a name, and the number of its screen.
pub(super) fn connect(name: Option<&str>) -> Result<(RustConnection, usize), WindowError> {
    let name = name.map(str::to_owned);
    in_time(move || Ok(x11rb::connect(name.as_deref())?))
}

impl Server {
    /// Opens a window for each pane on its monitor. What happens to them goes to `heard`, with this
    /// server's number.
    pub(super) fn open(
        number: usize,
        name: Option<&str>,
        make: impl FnOnce(&Shared, &[Monitor]) -> Result<Vec<Pane>, WindowError> + Send + 'static,
        heard: Sender<Heard>,
    ) -> Result<Self, WindowError> {
        let (connection, of_screen) = connect(name)?;
        let shown = name.map_or_else(
            || std::env::var("DISPLAY").unwrap_or_default(),
            str::to_owned,
        );
        let shared = in_time(move || {
            let (root, depth) = screen(connection.setup(), of_screen)?;
            let mut shared = Shared {
                memory: memory_way(&connection)?,
                has_present: connection.extension_information("Present")?.is_some(),
                connection,
                root,
                depth,
                panes: Vec::new(),
                number,
                name: shown,
                epoch: (Instant::now(), monotonic_microseconds()),
                over: AtomicBool::new(false),
            };
            if shared.has_present {
                shared.connection.present_query_version(1, 2)?.reply()?;
            }
            let monitors = monitors::all(&shared.connection, root)?;
            shared.panes = make(&shared, &monitors)?;
            shared.listen()?;
            shared.place_all(&monitors)?;
            Ok(shared)
        })?;
        let shared = Arc::new(shared);
        let (requests, due) = sync_channel(WAITING);
        let (sender, listener) = (Arc::clone(&shared), Arc::clone(&shared));
        let (said, more) = (heard.clone(), heard);
        let threads = [
            spawn("display", move || {
                if let Err(error) = sender.send(&due) {
                    let _ = said.send(Heard::Gone(number, error.to_string()));
                }
            })?,
            spawn("refreshes", move || {
                if let Err(error) = listener.hear(&more) {
                    let _ = more.send(Heard::Gone(number, error.to_string()));
                }
            })?,
        ];
        Ok(Self {
            shared,
            requests,
            threads: threads.into(),
            silent: false,
            gone: false,
        })
    }

    /// Sends a request unless the server hangs; returns whether it did.
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
        self.shared.over.store(true, Ordering::Relaxed);
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

fn monotonic_microseconds() -> u64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    let [seconds, nanoseconds] =
        [time.tv_sec, time.tv_nsec].map(|part| u64::try_from(part).unwrap_or(0));
    seconds * 1_000_000 + nanoseconds / 1_000
}

fn memory_way(connection: &RustConnection) -> Result<MemoryWay, WindowError> {
    if connection.extension_information("MIT-SHM")?.is_none() {
        return Ok(MemoryWay::Sent);
    }
    let version = connection.shm_query_version()?.reply()?;
    let by_descriptor = (version.major_version, version.minor_version) >= (1, 2);
    // The socket of another machine carries no descriptors.
    let is_local = rustix::net::getsockname(connection.stream())
        .is_ok_and(|address| address.address_family() == rustix::net::AddressFamily::UNIX);
    Ok(match (by_descriptor && is_local, version.shared_pixmaps) {
        (false, _) => MemoryWay::Sent,
        (true, true) => MemoryWay::Pixmap,
        (true, false) => MemoryWay::Copied,
    })
}

impl Shared {
    /// Asks to be told of changes of monitors and of what panes show.
    fn listen(&self) -> Result<(), WindowError> {
        let (connection, root) = (&self.connection, self.root);
        let changes = NotifyMask::SCREEN_CHANGE
            | NotifyMask::CRTC_CHANGE
            | NotifyMask::OUTPUT_CHANGE
            | NotifyMask::RESOURCE_CHANGE;
        connection.randr_select_input(root, changes)?;
        // Monitors without outputs change with no other sign.
        let structure = ChangeWindowAttributesAux::new().event_mask(EventMask::STRUCTURE_NOTIFY);
        connection.change_window_attributes(root, &structure)?;
        for pane in self.panes.iter().filter(|_| self.has_present) {
            let mask = PresentMask::COMPLETE_NOTIFY | PresentMask::IDLE_NOTIFY;
            let id = connection.generate_id()?;
            connection.present_select_input(id, pane.window, mask)?;
        }
        // Nobody touches the keys of a show.
        connection.set_screen_saver(0, 0, Blanking::DEFAULT, Exposures::DEFAULT)?;
        connection.flush()?;
        Ok(())
    }

    /// Puts each pane on its monitor, and hides those whose monitor is not there. Returns what is
    /// to be told.
    fn place_all(&self, monitors: &[Monitor]) -> Result<Vec<String>, WindowError> {
        let mut said = Vec::new();
        for pane in &self.panes {
            let monitor = monitors.iter().find(|one| one.name == pane.output.monitor);
            said.extend(pane.place(self, monitor)?);
            if monitor.is_some() && self.has_present {
                self.connection
                    .present_notify_msc(pane.window, 0, 0, 1, 0)?;
            }
        }
        self.connection.flush()?;
        Ok(said)
    }

    fn send(&self, due: &Receiver<Request>) -> Result<(), WindowError> {
        let connection = &self.connection;
        while let Ok(request) = due.recv() {
            match request {
                Request::Fill(sheets, number) => sheets.fill(self, number)?,
                Request::Present {
                    window,
                    pixmap,
                    serial,
                    refresh,
                } => {
                    self.present(window, pixmap, serial, refresh)?;
                }
                Request::Pair {
                    pane,
                    pair,
                    frame,
                    from,
                } => {
                    if let Some(pane) = self.panes.get(pane)
                        && let Some(turns) = &pane.turns
                    {
                        let mut turns = lock(turns);
                        let queued = turns.renew(pair, frame, from);
                        self.queue(pane, &queued, turns.is_blank)?;
                    }
                }
                Request::Copy {
                    window,
                    pixmap,
                    size: [width, height],
                } => {
                    let pane = self.panes.iter().find(|pane| pane.window == window);
                    if let Some(pane) = pane {
                        connection.copy_area(
                            pixmap,
                            window,
                            pane.context,
                            0,
                            0,
                            0,
                            0,
                            width,
                            height,
                        )?;
                    }
                }
                Request::End => {
                    connection.set_screen_saver(-1, -1, Blanking::DEFAULT, Exposures::DEFAULT)?;
                    for pane in &self.panes {
                        connection.destroy_window(pane.window)?;
                    }
                    connection.flush()?;
                    return Ok(());
                }
            }
            connection.flush()?;
        }
        Ok(())
    }

    fn present(
        &self,
        window: u32,
        pixmap: u32,
        serial: u32,
        refresh: u64,
    ) -> Result<(), WindowError> {
        let connection = &self.connection;
        connection.present_pixmap(
            window,
            pixmap,
            serial,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            refresh,
            0,
            0,
            &[],
        )?;
        Ok(())
    }

    /// Presents an eye's picture at its turn, or black.
    fn queue(&self, pane: &Pane, queued: &[Turn], is_blank: bool) -> Result<(), WindowError> {
        let black = pane
            .sheets()
            .and_then(|sheets| Some(sheets.all.last()?.pixmap));
        for turn in queued {
            let pixmap = black.filter(|_| is_blank).unwrap_or(turn.pixmap);
            pane.note_reader(pixmap, true);
            self.present(pane.window, pixmap, turn.serial, turn.refresh)?;
        }
        self.connection.flush()?;
        Ok(())
    }

    /// Takes that an eye was shown at its turn, and queues the next ones.
    fn take_turn(
        &self,
        pane: &Pane,
        serial: u32,
        refresh: u64,
        heard: &Sender<Heard>,
    ) -> Result<(), WindowError> {
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
        self.queue(pane, &queued, turns.is_blank)
    }

    /// Puts rows of pixels into a pixmap by messages.
    pub(super) fn put(
        &self,
        pixmap: u32,
        context: u32,
        [width, height]: [u16; 2],
        bytes: &[u8],
    ) -> Result<(), WindowError> {
        let row = 4 * usize::from(width).max(1);
        // Less the header of a request.
        let most = self.connection.maximum_request_bytes().saturating_sub(64);
        let rows = (most / row).max(1);
        let bands = bytes.chunks(rows * row);
        for (band, y) in bands.zip((0..height).step_by(rows)) {
            let rows = (band.len() / row) as u16;
            self.connection.put_image(
                ImageFormat::Z_PIXMAP,
                pixmap,
                context,
                width,
                rows,
                0,
                y as i16,
                0,
                self.depth,
                band,
            )?;
        }
        Ok(())
    }

    fn hear(&self, heard: &Sender<Heard>) -> Result<(), WindowError> {
        loop {
            let mut next = Some(self.connection.wait_for_event()?);
            let mut changed = false;
            while let Some(message) = next {
                changed |= self.take(&message, heard)?;
                next = self.connection.poll_for_event()?;
                if next.is_none() && std::mem::take(&mut changed) {
                    // A change comes as several events.
                    std::thread::sleep(SETTLING);
                    next = self.connection.poll_for_event()?;
                    changed = next.is_some();
                    if next.is_none() {
                        let monitors = monitors::all(&self.connection, self.root)?;
                        for said in self.place_all(&monitors)? {
                            let _ = heard.send(Heard::Said(said));
                        }
                    }
                }
            }
            if self.over.load(Ordering::Relaxed) {
                return Ok(());
            }
        }
    }

    /// Takes an event; returns whether monitors changed.
    fn take(&self, message: &Message, heard: &Sender<Heard>) -> Result<bool, WindowError> {
        let number_of = |window| self.panes.iter().position(|pane| pane.window == window);
        match message {
            Message::PresentCompleteNotify(said) => {
                let Some(number) = number_of(said.window) else {
                    return Ok(false);
                };
                let at = self.instant(said.ust);
                let skipped = said.mode == CompleteMode::SKIP;
                let pane = &self.panes[number];
                if !skipped {
                    lock(&pane.clock).hear(at, said.msc);
                }
                if said.kind == CompleteKind::PIXMAP {
                    if !skipped {
                        self.take_turn(pane, said.serial, said.msc, heard)?;
                    }
                    let _ = heard.send(Heard::Shown {
                        server: self.number,
                        pane: number,
                        serial: said.serial,
                        at,
                        refresh: said.msc,
                        skipped,
                    });
                }
                Ok(false)
            }
            Message::PresentIdleNotify(said) => {
                if let Some(number) = number_of(said.window) {
                    self.panes[number].note_reader(said.pixmap, false);
                }
                Ok(false)
            }
            Message::RandrNotify(_) | Message::RandrScreenChangeNotify(_) => Ok(true),
            Message::ConfigureNotify(of) => Ok(of.window == self.root),
            _ => Ok(false),
        }
    }

    /// Returns the time of a server's clock, which is the system's monotonic one.
    fn instant(&self, microseconds: u64) -> Instant {
        let (epoch, of) = self.epoch;
        let span = Duration::from_micros(microseconds.abs_diff(of));
        if microseconds >= of {
            epoch + span
        } else {
            epoch.checked_sub(span).unwrap_or(epoch)
        }
    }
}

/// Returns a clock of the rate of a monitor's mode, or of 60 Hz.
pub(super) fn clock_of(monitor: &Monitor) -> RefreshClock {
    RefreshClock::new(monitor.hz.unwrap_or(60.0))
}
