//! An X server that shows outputs in windows.

use super::clock::Epoch;
use super::display::{Display, Heard, MemoryWay, Request};
use super::monitors::{self, Monitor};
use super::pane::{NewPane, Pane};
use super::turns::Turn;
use super::window::Window;
use crate::live::lock;
use crate::outputs::Placing;
use crate::show::window::{WindowError, in_time, screen};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::time::Duration;
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

/// How long monitors are left to settle after a change.
const SETTLING: Duration = Duration::from_millis(20);

/// An X server and the windows on it.
pub(super) struct XServer {
    pub(super) connection: RustConnection,
    pub(super) root: u32,
    pub(super) depth: u8,
    /// Whether pictures go by shared memory, and whether that memory is the pixmap.
    pub(super) memory: MemoryWay,
    has_present: bool,
    windows: Vec<Window>,
    /// This server's number and name.
    number: usize,
    name: String,
    epoch: Epoch,
}

/// Returns a connection to the server of a name, and the number of its screen.
fn connect(name: Option<&str>) -> Result<(RustConnection, usize), WindowError> {
    let owned = name.map(str::to_owned);
    in_time(move || Ok(x11rb::connect(owned.as_deref())?)).map_err(|error| error.of_server(name))
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

impl XServer {
    /// Opens a window for each pane on its monitor, on the server of a name and this number.
    pub(super) fn open(
        number: usize,
        name: Option<&str>,
        panes: Vec<NewPane>,
        placing: Placing,
    ) -> Result<Self, WindowError> {
        let (connection, of_screen) = connect(name)?;
        let shown = name.map_or_else(
            || std::env::var("DISPLAY").unwrap_or_default(),
            str::to_owned,
        );
        in_time(move || {
            let (root, depth) = screen(connection.setup(), of_screen)?;
            let mut server = Self {
                memory: memory_way(&connection)?,
                has_present: connection.extension_information("Present")?.is_some(),
                connection,
                root,
                depth,
                windows: Vec::new(),
                number,
                name: format!("X server {shown}"),
                epoch: Epoch::now(),
            };
            if server.has_present {
                server.connection.present_query_version(1, 2)?.reply()?;
            }
            let monitors = monitors::all(&server.connection, root)?;
            let windows = panes.into_iter().map(|new| {
                let monitor = monitors::named(&monitors, &new.output.monitor, &server.name)?;
                new.check_size(monitor)?;
                Window::new(&server, new, monitor, placing)
            });
            server.windows = windows.collect::<Result<_, _>>()?;
            server.listen()?;
            server.place_all(&monitors)?;
            Ok(server)
        })
    }

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
        for window in self.windows.iter().filter(|_| self.has_present) {
            let mask = PresentMask::COMPLETE_NOTIFY | PresentMask::IDLE_NOTIFY;
            let id = connection.generate_id()?;
            connection.present_select_input(id, window.number, mask)?;
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
        for window in &self.windows {
            let name = &window.pane.output.monitor;
            let monitor = monitors.iter().find(|one| one.name == *name);
            said.extend(window.place(self, monitor)?);
            if monitor.is_some() && self.has_present {
                self.connection
                    .present_notify_msc(window.number, 0, 0, 1, 0)?;
            }
        }
        self.connection.flush()?;
        Ok(said)
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

    /// Takes an event; returns whether monitors changed.
    fn take(&self, message: &Message, heard: &Sender<Heard>) -> Result<bool, WindowError> {
        let number_of = |window| {
            let mut windows = self.windows.iter();
            windows.position(|one| one.number == window)
        };
        match message {
            Message::PresentCompleteNotify(said) => {
                let Some(number) = number_of(said.window) else {
                    return Ok(false);
                };
                let at = self.epoch.instant(said.ust);
                let skipped = said.mode == CompleteMode::SKIP;
                if !skipped {
                    lock(&self.pane(number).clock).hear(at, said.msc);
                }
                if said.kind == CompleteKind::PIXMAP {
                    if !skipped {
                        self.take_turn(number, said.serial, said.msc, heard)?;
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
                    self.pane(number).note_reader(said.pixmap, false);
                }
                Ok(false)
            }
            Message::RandrNotify(_) | Message::RandrScreenChangeNotify(_) => Ok(true),
            Message::ConfigureNotify(of) => Ok(of.window == self.root),
            _ => Ok(false),
        }
    }
}

impl Display for XServer {
    fn name(&self) -> &str {
        &self.name
    }

    fn pane(&self, number: usize) -> &Pane {
        &self.windows[number].pane
    }

    fn memory(&self) -> MemoryWay {
        self.memory
    }

    fn has_present(&self) -> bool {
        self.has_present
    }

    fn has_one_clock(&self) -> bool {
        true
    }

    fn present(&self, number: usize, turn: Turn) -> Result<(), WindowError> {
        self.connection.present_pixmap(
            self.windows[number].number,
            turn.pixmap,
            turn.serial,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            0,
            turn.refresh,
            0,
            0,
            &[],
        )?;
        Ok(())
    }

    fn carry_out(&self, request: Request) -> Result<(), WindowError> {
        let connection = &self.connection;
        match request {
            Request::Fill(pane, sheets, number) => {
                sheets.fill(self, self.windows[pane].context, number)?;
            }
            Request::Copy {
                pane,
                pixmap,
                size: [width, height],
            } => {
                let Window {
                    number, context, ..
                } = self.windows[pane];
                connection.copy_area(pixmap, number, context, 0, 0, 0, 0, width, height)?;
            }
            Request::End => {
                connection.set_screen_saver(-1, -1, Blanking::DEFAULT, Exposures::DEFAULT)?;
                for window in &self.windows {
                    connection.destroy_window(window.number)?;
                }
                self.flush()?;
            }
            Request::Present(..) | Request::Pair { .. } => {}
        }
        Ok(())
    }

    fn flush(&self) -> Result<(), WindowError> {
        Ok(self.connection.flush()?)
    }

    fn hear(&self, heard: &Sender<Heard>, over: &AtomicBool) -> Result<(), WindowError> {
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
            if over.load(Ordering::Relaxed) {
                return Ok(());
            }
        }
    }
}
