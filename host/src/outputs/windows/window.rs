//! A full-screen window on an X server and the pixmaps that it presents.

use super::clock::RefreshClock;
use super::display::MemoryWay;
use super::monitors::Monitor;
use super::pane::{Memory, NewPane, Pane, Sheet, Sheets};
use super::server::XServer;
use crate::live::lock;
use crate::outputs::Placing;
use crate::show::window::WindowError;
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use std::fs::File;
use std::sync::Mutex;
use x11rb::COPY_DEPTH_FROM_PARENT;
use x11rb::connection::Connection;
use x11rb::protocol::shm::ConnectionExt as _;
use x11rb::protocol::xproto::{
    AtomEnum, ConfigureWindowAux, ConnectionExt as _, CreateGCAux, CreateWindowAux, ImageFormat,
    ImageOrder, PropMode, StackMode, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;

/// A window for a pane.
pub(super) struct Window {
    pub(super) pane: Pane,
    /// The server's number for it.
    pub(super) number: u32,
    pub(super) context: u32,
    placing: Placing,
    fullscreen: [u32; 2],
}

impl Window {
    /// Makes a window that is not shown yet.
    pub(super) fn new(
        server: &XServer,
        new: NewPane,
        monitor: &Monitor,
        placing: Placing,
    ) -> Result<Self, WindowError> {
        let connection = &server.connection;
        let (number, context, bare) = (
            connection.generate_id()?,
            connection.generate_id()?,
            connection.generate_id()?,
        );
        let is_ours = u32::from(placing == Placing::Override);
        // A cursor of nothing.
        connection.create_pixmap(1, bare, server.root, 1, 1)?;
        let cursor = connection.generate_id()?;
        connection.create_cursor(cursor, bare, bare, 0, 0, 0, 0, 0, 0, 0, 0)?;
        connection.create_window(
            COPY_DEPTH_FROM_PARENT,
            number,
            server.root,
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
        connection.create_gc(context, number, &no_exposures)?;
        let name = format!("Shisen: {} on {}", new.output.show, new.output.monitor);
        let (property, text) = (AtomEnum::WM_NAME, AtomEnum::STRING);
        connection.change_property8(PropMode::REPLACE, number, property, text, name.as_bytes())?;
        let class = b"shisen\0Shisen\0";
        connection.change_property8(PropMode::REPLACE, number, AtomEnum::WM_CLASS, text, class)?;
        let atom =
            |name: &[u8]| Ok::<_, WindowError>(connection.intern_atom(false, name)?.reply()?.atom);
        let bypass = atom(b"_NET_WM_BYPASS_COMPOSITOR")?;
        let cardinal = AtomEnum::CARDINAL;
        connection.change_property32(PropMode::REPLACE, number, bypass, cardinal, &[1])?;
        // Position and size by the user: managers leave the window where it is.
        let hints = [0x3_u32, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let normal = AtomEnum::WM_NORMAL_HINTS;
        let kind = AtomEnum::WM_SIZE_HINTS;
        connection.change_property32(PropMode::REPLACE, number, normal, kind, &hints)?;
        Ok(Self {
            pane: Pane::new(new, monitor),
            number,
            context,
            placing,
            fullscreen: [atom(b"_NET_WM_STATE")?, atom(b"_NET_WM_STATE_FULLSCREEN")?],
        })
    }

    /// Covers the monitor, or hides where there is none. Returns what is to be told.
    pub(super) fn place(
        &self,
        server: &XServer,
        monitor: Option<&Monitor>,
    ) -> Result<Option<String>, WindowError> {
        let connection = &server.connection;
        let Some(monitor) = monitor else {
            self.free(server, None)?;
            connection.unmap_window(self.number)?;
            return Ok(self.pane.note_monitor(false));
        };
        let before = self.pane.sheets();
        let before = before.map(|sheets| (sheets.corner, sheets.size));
        if before == Some((monitor.corner, monitor.size)) {
            return Ok(None);
        }
        let place = ConfigureWindowAux::new()
            .x(i32::from(monitor.corner[0]))
            .y(i32::from(monitor.corner[1]))
            .width(u32::from(monitor.size[0]))
            .height(u32::from(monitor.size[1]))
            .stack_mode(StackMode::ABOVE);
        connection.configure_window(self.number, &place)?;
        if self.placing == Placing::Managed {
            let [state, fullscreen] = self.fullscreen;
            let atom = AtomEnum::ATOM;
            connection.change_property32(
                PropMode::REPLACE,
                self.number,
                state,
                atom,
                &[fullscreen],
            )?;
        }
        connection.map_window(self.number)?;
        *lock(&self.pane.clock) = RefreshClock::of(monitor);
        let sheet = |_| self.sheet(server, monitor.size);
        let sheets = Sheets {
            size: monitor.size,
            corner: monitor.corner,
            all: (0..self.pane.sheet_count())
                .map(sheet)
                .collect::<Result<_, _>>()?,
        };
        self.free(server, Some(sheets))?;
        Ok(self.pane.note_monitor(true))
    }

    /// Frees the pixmaps and has others. The server keeps those that it still shows.
    fn free(&self, server: &XServer, others: Option<Sheets>) -> Result<(), WindowError> {
        let before = self.pane.replace(others);
        for sheet in before.iter().flat_map(|sheets| &sheets.all) {
            server.connection.free_pixmap(sheet.pixmap)?;
            if let Memory::Shared { segment, .. } = sheet.memory {
                server.connection.shm_detach(segment)?;
            }
        }
        Ok(())
    }

    fn sheet(&self, server: &XServer, [width, height]: [u16; 2]) -> Result<Sheet, WindowError> {
        let connection = &server.connection;
        let bytes = 4 * usize::from(width) * usize::from(height);
        let pixmap = connection.generate_id()?;
        let is_pixmap = server.memory == MemoryWay::Pixmap;
        let memory = if server.memory == MemoryWay::Sent {
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
                let depth = server.depth;
                connection.shm_create_pixmap(
                    pixmap,
                    self.number,
                    width,
                    height,
                    depth,
                    *segment,
                    0,
                )?;
            }
            _ => {
                connection.create_pixmap(server.depth, pixmap, self.number, width, height)?;
            }
        }
        let is_big = connection.setup().image_byte_order == ImageOrder::MSB_FIRST;
        let is_swapped = is_big != cfg!(target_endian = "big");
        Ok(Sheet::new(pixmap, memory, is_swapped))
    }
}

impl Sheets {
    /// Puts what was written into the pixmap, as far as that is not done.
    pub(super) fn fill(
        &self,
        server: &XServer,
        context: u32,
        number: usize,
    ) -> Result<(), WindowError> {
        let Some(sheet) = self.all.get(number) else {
            return Ok(());
        };
        let (size, [width, height]) = (self.size, self.size);
        match &sheet.memory {
            Memory::Own(bytes) => server.put(sheet.pixmap, context, size, &lock(bytes)),
            Memory::Shared {
                is_pixmap: true, ..
            }
            | Memory::Mapped { .. } => Ok(()),
            Memory::Shared { segment, .. } => {
                let format = ImageFormat::Z_PIXMAP.into();
                server.connection.shm_put_image(
                    sheet.pixmap,
                    context,
                    width,
                    height,
                    0,
                    0,
                    width,
                    height,
                    0,
                    0,
                    server.depth,
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
