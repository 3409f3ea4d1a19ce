//! A full-screen window and the pixmaps that it presents.

use super::clock::RefreshClock;
use super::monitors::Monitor;
use super::server::{MemoryWay, Shared, clock_of};
use super::turns::Turns;
use crate::live::lock;
use crate::outputs::{Output, Placing};
use crate::show::window::WindowError;
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use x11rb::COPY_DEPTH_FROM_PARENT;
use x11rb::connection::Connection;
use x11rb::protocol::shm::ConnectionExt as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConfigureWindowAux, ConnectionExt as _, CreateGCAux, CreateWindowAux, ImageFormat,
    ImageOrder, PropMode, StackMode, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;
use zerocopy::IntoBytes;

/// Pixmaps of a pane: the one on the screen, and two on their way.
const SHEETS: usize = 3;

/// Pixmaps of a pane that shows the eyes by turns, and one that stays black.
const SHEETS_OF_TURNS: usize = 2 * SHEETS + 1;

pub(super) struct Pane {
    pub(super) output: Output,
    pub(super) window: u32,
    pub(super) context: u32,
    pub(super) clock: Mutex<RefreshClock>,
    placing: Placing,
    fullscreen: [u32; 2],
    /// The pixmaps at the monitor's size; `None` while the monitor is away.
    sheets: Mutex<Option<Arc<Sheets>>>,
    was_away: AtomicBool,
    /// The eyes by turns, where it shows them so.
    pub(super) turns: Option<Mutex<Turns>>,
}

/// Pixmaps of one size.
pub(super) struct Sheets {
    pub(super) size: [u16; 2],
    corner: [i16; 2],
    context: u32,
    pub(super) all: Vec<Sheet>,
}

pub(super) struct Sheet {
    pub(super) pixmap: u32,
    memory: Memory,
    /// How often the server may still read it.
    pub(super) readers: AtomicU32,
}

enum Memory {
    /// A segment that the server has mapped, and whether it is the pixmap.
    Shared {
        file: File,
        segment: u32,
        is_pixmap: bool,
    },
    /// Bytes that are sent.
    Own(Mutex<Vec<u8>>),
}

impl Pane {
    /// Makes a window that is not shown yet.
    pub(super) fn new(
        shared: &Shared,
        output: Output,
        monitor: &Monitor,
        placing: Placing,
        takes_turns: bool,
    ) -> Result<Self, WindowError> {
        let connection = &shared.connection;
        let (window, context, bare) = (
            connection.generate_id()?,
            connection.generate_id()?,
            connection.generate_id()?,
        );
        let is_ours = u32::from(placing == Placing::Override);
        // A cursor of nothing.
        connection.create_pixmap(1, bare, shared.root, 1, 1)?;
        let cursor = connection.generate_id()?;
        connection.create_cursor(cursor, bare, bare, 0, 0, 0, 0, 0, 0, 0, 0)?;
        connection.create_window(
            COPY_DEPTH_FROM_PARENT,
            window,
            shared.root,
            monitor.corner[0],
            monitor.corner[1],
            monitor.size[0],
            monitor.size[1],
            0,
            WindowClass::INPUT_OUTPUT,
            0,
            &CreateWindowAux::new()
                .background_pixel(0)
                .override_redirect(is_ours)
                .cursor(cursor),
        )?;
        connection.free_pixmap(bare)?;
        let no_exposures = CreateGCAux::new().graphics_exposures(0);
        connection.create_gc(context, window, &no_exposures)?;
        let name = format!("Shisen: {} on {}", output.show, output.monitor);
        let (property, text) = (AtomEnum::WM_NAME, AtomEnum::STRING);
        connection.change_property8(PropMode::REPLACE, window, property, text, name.as_bytes())?;
        let class = b"shisen\0Shisen\0";
        connection.change_property8(PropMode::REPLACE, window, AtomEnum::WM_CLASS, text, class)?;
        let atom =
            |name: &[u8]| Ok::<_, WindowError>(connection.intern_atom(false, name)?.reply()?.atom);
        let bypass = atom(b"_NET_WM_BYPASS_COMPOSITOR")?;
        let cardinal = AtomEnum::CARDINAL;
        connection.change_property32(PropMode::REPLACE, window, bypass, cardinal, &[1])?;
        // Position and size by the user: managers leave the window where it is.
        let hints = [0x3_u32, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let normal = AtomEnum::WM_NORMAL_HINTS;
        let kind = AtomEnum::WM_SIZE_HINTS;
        connection.change_property32(PropMode::REPLACE, window, normal, kind, &hints)?;
        Ok(Self {
            output,
            window,
            context,
            clock: Mutex::new(clock_of(monitor)),
            placing,
            fullscreen: [atom(b"_NET_WM_STATE")?, atom(b"_NET_WM_STATE_FULLSCREEN")?],
            sheets: Mutex::new(None),
            was_away: AtomicBool::new(false),
            turns: takes_turns.then(Mutex::default),
        })
    }

    /// Covers the monitor, or hides where there is none. Returns what is to be told.
    pub(super) fn place(
        &self,
        shared: &Shared,
        monitor: Option<&Monitor>,
    ) -> Result<Option<String>, WindowError> {
        let connection = &shared.connection;
        let (name, screen) = (&self.output.monitor, &self.output.show);
        let Some(monitor) = monitor else {
            self.free(shared, None)?;
            connection.unmap_window(self.window)?;
            let is_news = !self.was_away.swap(true, Ordering::Relaxed);
            return Ok(is_news.then(|| {
                format!(
                    "monitor {name} has gone: \"{screen}\" is shown again when it is back under \
                     this name"
                )
            }));
        };
        let before = self.sheets().map(|sheets| (sheets.corner, sheets.size));
        if before == Some((monitor.corner, monitor.size)) {
            return Ok(None);
        }
        let place = ConfigureWindowAux::new()
            .x(i32::from(monitor.corner[0]))
            .y(i32::from(monitor.corner[1]))
            .width(u32::from(monitor.size[0]))
            .height(u32::from(monitor.size[1]))
            .stack_mode(StackMode::ABOVE);
        connection.configure_window(self.window, &place)?;
        if self.placing == Placing::Managed {
            let [state, fullscreen] = self.fullscreen;
            let atom = AtomEnum::ATOM;
            connection.change_property32(
                PropMode::REPLACE,
                self.window,
                state,
                atom,
                &[fullscreen],
            )?;
        }
        connection.map_window(self.window)?;
        *lock(&self.clock) = clock_of(monitor);
        self.free(shared, Some(Sheets::new(shared, self, monitor)?))?;
        let is_back = self.was_away.swap(false, Ordering::Relaxed);
        Ok(is_back.then(|| format!("monitor {name} is back and shows \"{screen}\"")))
    }

    /// Frees the pixmaps and has others. The server keeps those that it still shows.
    fn free(&self, shared: &Shared, others: Option<Sheets>) -> Result<(), WindowError> {
        let before = std::mem::replace(&mut *lock(&self.sheets), others.map(Arc::new));
        for sheet in before.iter().flat_map(|sheets| &sheets.all) {
            shared.connection.free_pixmap(sheet.pixmap)?;
            if let Memory::Shared { segment, .. } = sheet.memory {
                shared.connection.shm_detach(segment)?;
            }
        }
        Ok(())
    }

    /// Returns the pixmaps at the monitor's size; `None` while it is away.
    pub(super) fn sheets(&self) -> Option<Arc<Sheets>> {
        lock(&self.sheets).clone()
    }

    /// Notes that the server reads a pixmap once more, or once less.
    pub(super) fn note_reader(&self, pixmap: u32, more: bool) {
        let sheets = self.sheets();
        let mut all = sheets.iter().flat_map(|sheets| &sheets.all);
        if let Some(sheet) = all.find(|sheet| sheet.pixmap == pixmap) {
            let change = |count: u32| {
                if more {
                    Some(count + 1)
                } else {
                    count.checked_sub(1)
                }
            };
            let (set, get) = (Ordering::Release, Ordering::Acquire);
            let _ = sheet.readers.fetch_update(set, get, change);
        }
    }
}

impl Sheets {
    fn new(shared: &Shared, pane: &Pane, monitor: &Monitor) -> Result<Self, WindowError> {
        let sheet = |_| Sheet::new(shared, pane.window, monitor.size);
        let count = match pane.turns {
            Some(_) => SHEETS_OF_TURNS,
            None => SHEETS,
        };
        Ok(Self {
            size: monitor.size,
            corner: monitor.corner,
            context: pane.context,
            all: (0..count).map(sheet).collect::<Result<_, _>>()?,
        })
    }

    /// Returns the numbers of pixmaps that the server does not read.
    pub(super) fn free(&self) -> impl Iterator<Item = usize> + '_ {
        // The last one of those of turns stays black.
        let written = self
            .all
            .iter()
            .take(self.all.len().min(SHEETS_OF_TURNS - 1));
        let free = written.enumerate();
        free.filter(|(_, sheet)| sheet.readers.load(Ordering::Acquire) == 0)
            .map(|(number, _)| number)
    }

    /// Puts what was written into the pixmap, as far as that is not done.
    pub(super) fn fill(&self, shared: &Shared, number: usize) -> Result<(), WindowError> {
        let Some(sheet) = self.all.get(number) else {
            return Ok(());
        };
        let (size, [width, height]) = (self.size, self.size);
        match &sheet.memory {
            Memory::Own(bytes) => shared.put(sheet.pixmap, self.context, size, &lock(bytes)),
            Memory::Shared {
                is_pixmap: true, ..
            } => Ok(()),
            Memory::Shared { segment, .. } => {
                let format = ImageFormat::Z_PIXMAP.into();
                shared.connection.shm_put_image(
                    sheet.pixmap,
                    self.context,
                    width,
                    height,
                    0,
                    0,
                    width,
                    height,
                    0,
                    0,
                    shared.depth,
                    format,
                    false,
                    *segment,
                    0,
                )?;
                Ok(())
            }
        }
    }
}

impl Sheet {
    fn new(shared: &Shared, window: u32, [width, height]: [u16; 2]) -> Result<Self, WindowError> {
        let connection = &shared.connection;
        let bytes = 4 * usize::from(width) * usize::from(height);
        let pixmap = connection.generate_id()?;
        let is_pixmap = shared.memory == MemoryWay::Pixmap;
        let memory = if shared.memory == MemoryWay::Sent {
            Memory::Own(Mutex::new(vec![0; bytes]))
        } else {
            let failed = |error: rustix::io::Errno| WindowError::gone(&error.to_string());
            let file = memfd_create("shisen", MemfdFlags::CLOEXEC).map_err(failed)?;
            ftruncate(&file, bytes as u64).map_err(failed)?;
            let segment = connection.generate_id()?;
            let theirs = file
                .try_clone()
                .map_err(|error| WindowError::gone(&error.to_string()))?;
            connection.shm_attach_fd(segment, theirs, false)?;
            let file = File::from(file);
            Memory::Shared {
                file,
                segment,
                is_pixmap,
            }
        };
        match &memory {
            Memory::Shared { segment, .. } if is_pixmap => {
                let depth = shared.depth;
                connection.shm_create_pixmap(pixmap, window, width, height, depth, *segment, 0)?;
            }
            _ => {
                connection.create_pixmap(shared.depth, pixmap, window, width, height)?;
            }
        }
        Ok(Self {
            pixmap,
            memory,
            readers: AtomicU32::new(0),
        })
    }

    /// Writes rows of pixels, 0xRRGGBB each, in the server's order of bytes.
    pub(super) fn write(&self, shared: &Shared, pixels: &[u32]) -> std::io::Result<()> {
        let is_big = shared.connection.setup().image_byte_order == ImageOrder::MSB_FIRST;
        let mut swapped = Vec::new();
        if is_big != cfg!(target_endian = "big") {
            swapped.extend(pixels.iter().map(|pixel| pixel.swap_bytes()));
        }
        let pixels = if swapped.is_empty() { pixels } else { &swapped };
        match &self.memory {
            Memory::Shared { file, .. } => file.write_all_at(pixels.as_bytes(), 0),
            Memory::Own(bytes) => {
                lock(bytes).copy_from_slice(pixels.as_bytes());
                Ok(())
            }
        }
    }
}
