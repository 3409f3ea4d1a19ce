//! A window on an X server (on Wayland `XWayland`): shows pixels and reads keys and the mouse.
//!
//! It speaks the X protocol over its own socket, so that a server that goes away is an error rather
//! than the end of the program.

use crate::show::dashboard::{Canvas, Colour};
use miette::Diagnostic;
use std::sync::mpsc::sync_channel;
use std::time::Duration;
use thiserror::Error;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::errors::{ConnectError, ConnectionError, ReplyError, ReplyOrIdError};
use x11rb::protocol::Event as Message;
use x11rb::protocol::randr::ConnectionExt as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConnectionExt as _, CreateGCAux, CreateWindowAux, EventMask, ImageFormat, ImageOrder,
    PropMode, Setup, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

x11rb::atom_manager! {
    Atoms: AtomsCookie {
        WM_PROTOCOLS,
        WM_DELETE_WINDOW,
        _NET_WM_NAME,
        UTF8_STRING,
    }
}

pub(crate) struct Window {
    connection: RustConnection,
    number: u32,
    context: u32,
    depth: u8,
    order: ImageOrder,
    atoms: Atoms,
    first_key: u8,
    symbols: Vec<u32>,
    bytes: Vec<u8>,
}

#[derive(Clone, Copy)]
pub(crate) enum Event {
    /// A key, as the small letter that it writes, or `'\u{1b}'` for Escape.
    Key(char),
    /// Whether a key that steers is held: by number, Home, Left, Up, Right, Down, Page Up, Page
    /// Down.
    Steering(usize, bool),
    /// Keys that are let go from now on go to another window.
    Unfocused,
    /// The column and the row of the mouse; 0 where it is left of the window or above it.
    Mouse(u32, u32),
    /// Whether the first button is held.
    Button(bool),
    /// Columns and rows.
    Size(u32, u32),
    Exposed,
    Closed,
}

/// Why a window does not open, or has gone, and what to do.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
pub struct WindowError {
    message: String,
    #[help]
    help: Option<&'static str>,
}

impl WindowError {
    pub(crate) fn no_window(reason: &str, help: &'static str) -> Self {
        let (message, help) = (format!("there is no window: {reason}"), Some(help));
        Self { message, help }
    }

    pub(crate) const fn refused(message: String, help: &'static str) -> Self {
        let help = Some(help);
        Self { message, help }
    }

    /// Says which of several servers it was.
    pub(crate) fn of_server(mut self, name: Option<&str>) -> Self {
        if let Some(name) = name {
            self.message = format!("X server {name}: {}", self.message);
        }
        self
    }

    pub(crate) fn gone(reason: &str) -> Self {
        let (message, help) = (format!("the window system has gone: {reason}"), None);
        Self { message, help }
    }
}

impl From<ConnectError> for WindowError {
    fn from(reason: ConnectError) -> Self {
        let text = match reason {
            ConnectError::DisplayParsingError(_) => match std::env::var_os("DISPLAY") {
                Some(name) => format!("DISPLAY is {}, which names no X server", name.display()),
                None => "DISPLAY is not set".to_owned(),
            },
            other => format!("the X server cannot be reached ({other})"),
        };
        Self::no_window(
            &text,
            "set DISPLAY to that of an X server, such as :0 (Xvfb is one without a screen), or take \
             --view png, which writes the frames to files",
        )
    }
}

/// Errors of the protocol's library after which the server counts as gone.
macro_rules! gone {
    ($($error:ty),*) => {
        $(impl From<$error> for WindowError {
            fn from(reason: $error) -> Self {
                Self::gone(&reason.to_string())
            }
        })*
    };
}

gone!(ConnectionError, ReplyError, ReplyOrIdError, std::io::Error);

const ANSWER_SECONDS: u64 = 5;

/// The symbol of Escape; those of letters are their codes.
const ESCAPE: u32 = 0xFF1B;

/// Returns the number of a key that steers.
fn steering_key(symbol: u32) -> Option<usize> {
    const HOME: u32 = 0xFF50;
    const PAGE_DOWN: u32 = 0xFF56;
    (HOME..=PAGE_DOWN)
        .contains(&symbol)
        .then(|| (symbol - HOME) as usize)
}

impl Window {
    /// Shows a window of some columns and rows on the server that `DISPLAY` names.
    pub(crate) fn open(title: &str, size: [u32; 2]) -> Result<Self, WindowError> {
        let title = title.to_owned();
        in_time(move || Self::on_server(&title, size))
    }

    /// Returns the refreshes per second of the first screen on the server that is in use; none
    /// where it does not say.
    pub(crate) fn refresh() -> Option<u32> {
        let all = in_time(|| {
            let (connection, number) = x11rb::connect(None)?;
            let (root, _) = screen(connection.setup(), number)?;
            let all = connection.randr_get_screen_resources_current(root)?;
            let all = all.reply()?;
            let mut mode = 0;
            for crtc in &all.crtcs {
                let about = connection.randr_get_crtc_info(*crtc, all.config_timestamp)?;
                mode = about.reply()?.mode;
                if mode != 0 {
                    break;
                }
            }
            Ok(all.modes.into_iter().find(|one| one.id == mode))
        });
        let mode = all.ok().flatten()?;
        let pixels = f64::from(mode.htotal) * f64::from(mode.vtotal);
        let hz = (f64::from(mode.dot_clock) / pixels).round();
        (1.0..=1_000.0).contains(&hz).then_some(hz as u32)
    }

    fn on_server(title: &str, [width, height]: [u32; 2]) -> Result<Self, WindowError> {
        let (connection, number) = x11rb::connect(None)?;
        let setup = connection.setup();
        let (first_key, last_key) = (setup.min_keycode, setup.max_keycode);
        let order = setup.image_byte_order;
        let (root, depth) = screen(setup, number)?;
        let atoms = Atoms::new(&connection)?.reply()?;
        let count = (last_key - first_key).saturating_add(1);
        let keys = connection.get_keyboard_mapping(first_key, count)?.reply()?;
        let each = usize::from(keys.keysyms_per_keycode).max(1);
        let symbols = keys.keysyms.chunks(each).map(|key| key[0]).collect();
        let window = connection.generate_id()?;
        let mask = EventMask::EXPOSURE
            | EventMask::STRUCTURE_NOTIFY
            | EventMask::KEY_PRESS
            | EventMask::KEY_RELEASE
            | EventMask::FOCUS_CHANGE
            | EventMask::BUTTON_PRESS
            | EventMask::BUTTON_RELEASE
            | EventMask::POINTER_MOTION;
        connection.create_window(
            depth,
            window,
            root,
            0,
            0,
            width.clamp(1, Canvas::MOST) as u16,
            height.clamp(1, Canvas::MOST) as u16,
            0,
            WindowClass::INPUT_OUTPUT,
            0,
            &CreateWindowAux::new().event_mask(mask),
        )?;
        let name = title.as_bytes();
        let (text, string) = (AtomEnum::STRING, atoms.UTF8_STRING);
        for (property, kind) in [
            (u32::from(AtomEnum::WM_NAME), u32::from(text)),
            (atoms._NET_WM_NAME, string),
        ] {
            connection.change_property8(PropMode::REPLACE, window, property, kind, name)?;
        }
        let class = b"shisen\0Shisen\0";
        connection.change_property8(PropMode::REPLACE, window, AtomEnum::WM_CLASS, text, class)?;
        connection.change_property32(
            PropMode::REPLACE,
            window,
            atoms.WM_PROTOCOLS,
            AtomEnum::ATOM,
            &[atoms.WM_DELETE_WINDOW],
        )?;
        let context = connection.generate_id()?;
        let no_exposures = CreateGCAux::new().graphics_exposures(0);
        connection.create_gc(context, window, &no_exposures)?;
        connection.map_window(window)?;
        connection.flush()?;
        Ok(Self {
            connection,
            number: window,
            context,
            depth,
            order,
            atoms,
            first_key,
            symbols,
            bytes: Vec::new(),
        })
    }

    /// Returns the next event, if there is one.
    pub(crate) fn event(&mut self) -> Result<Option<Event>, WindowError> {
        while let Some(message) = self.connection.poll_for_event()? {
            if let Some(event) = self.read(&message) {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    fn symbol(&self, key: u8) -> Option<u32> {
        let number = key.checked_sub(self.first_key)?;
        self.symbols.get(usize::from(number)).copied()
    }

    fn read(&self, message: &Message) -> Option<Event> {
        let inside = |at: i16| u32::try_from(at).unwrap_or(0);
        match message {
            Message::KeyPress(key) => match self.symbol(key.detail)? {
                ESCAPE => Some(Event::Key('\u{1b}')),
                code @ 0x20..=0x7E => {
                    let letter = char::from(code as u8);
                    Some(Event::Key(letter.to_ascii_lowercase()))
                }
                symbol => Some(Event::Steering(steering_key(symbol)?, true)),
            },
            Message::KeyRelease(key) => {
                let symbol = self.symbol(key.detail)?;
                Some(Event::Steering(steering_key(symbol)?, false))
            }
            Message::FocusOut(_) => Some(Event::Unfocused),
            Message::MotionNotify(mouse) => {
                Some(Event::Mouse(inside(mouse.event_x), inside(mouse.event_y)))
            }
            Message::ButtonPress(button) if button.detail == 1 => Some(Event::Button(true)),
            Message::ButtonRelease(button) if button.detail == 1 => Some(Event::Button(false)),
            Message::ConfigureNotify(to) => Some(Event::Size(to.width.into(), to.height.into())),
            Message::Expose(_) => Some(Event::Exposed),
            Message::DestroyNotify(of) if of.window == self.number => Some(Event::Closed),
            Message::ClientMessage(said) => {
                let asked = said.data.as_data32()[0] == self.atoms.WM_DELETE_WINDOW;
                asked.then_some(Event::Closed)
            }
            _ => None,
        }
    }

    /// Shows a canvas in the upper left corner, waiting for a slow server.
    pub(crate) fn show(&mut self, canvas: &Canvas) -> Result<(), WindowError> {
        let [width, height] = canvas.size();
        // Less the header of a request.
        let most = self.connection.maximum_request_bytes().saturating_sub(64);
        let rows = (most / (4 * width.max(1) as usize)).max(1);
        let bytes = match self.order {
            ImageOrder::MSB_FIRST => Colour::to_be_bytes,
            _ => Colour::to_le_bytes,
        };
        let bands = canvas.pixels().chunks(rows * width.max(1) as usize);
        for (pixels, y) in bands.zip((0..height).step_by(rows)) {
            self.bytes.clear();
            self.bytes.extend(pixels.iter().copied().flat_map(bytes));
            self.connection.put_image(
                ImageFormat::Z_PIXMAP,
                self.number,
                self.context,
                width as u16,
                (pixels.len() / width.max(1) as usize) as u16,
                0,
                y as i16,
                0,
                self.depth,
                &self.bytes,
            )?;
        }
        self.connection.flush()?;
        Ok(())
    }
}

/// Returns what is asked of a server. The protocol's library waits for answers without a limit:
/// without one, the thread is left behind.
pub(crate) fn in_time<T: Send + 'static>(
    ask: impl FnOnce() -> Result<T, WindowError> + Send + 'static,
) -> Result<T, WindowError> {
    let (send, receive) = sync_channel(1);
    std::thread::Builder::new()
        .name("window".to_owned())
        .spawn(move || {
            // Fails where the wait has ended.
            let _ = send.send(ask());
        })
        .map_err(|error| WindowError::gone(&error.to_string()))?;
    receive
        .recv_timeout(Duration::from_secs(ANSWER_SECONDS))
        .unwrap_or_else(|_| {
            Err(WindowError::no_window(
                &format!("the X server does not answer for {ANSWER_SECONDS} s"),
                "restart the server, set DISPLAY to that of another, or take --view png, which \
                 writes the frames to files",
            ))
        })
}

/// Returns the root window and the depth of a screen whose pixels are 0xRRGGBB in four bytes.
pub(crate) fn screen(setup: &Setup, number: usize) -> Result<(u32, u8), WindowError> {
    let gone = || WindowError::gone(&format!("it has no screen {number}"));
    let screen = setup.roots.get(number).ok_or_else(gone)?;
    let depth = screen.root_depth;
    let visuals = screen.allowed_depths.iter().flat_map(|one| &one.visuals);
    let ours = visuals
        .filter(|visual| visual.visual_id == screen.root_visual)
        .any(|visual| [visual.red_mask, visual.green_mask, visual.blue_mask] == MASKS);
    let formats = setup.pixmap_formats.iter();
    let words = formats
        .filter(|format| format.depth == depth)
        .any(|format| format.bits_per_pixel == 32);
    if ours && words {
        Ok((screen.root, depth))
    } else {
        Err(WindowError::no_window(
            &format!("the X server's screen has {depth} bits a pixel, not 24"),
            "start the server with 24 (Xvfb :99 -screen 0 1280x1024x24), or take --view png",
        ))
    }
}

const MASKS: [u32; 3] = [0xFF_0000, 0x00_FF00, 0x00_00FF];
