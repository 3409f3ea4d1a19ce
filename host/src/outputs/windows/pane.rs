//! What an output shows on its monitor, and the pixmaps for it.

use super::clock::RefreshClock;
use super::monitors::Monitor;
use super::turns::Turns;
use crate::live::lock;
use crate::outputs::Output;
use crate::show::window::WindowError;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use zerocopy::IntoBytes;

/// Pixmaps of a pane: the one on the screen, and two on their way.
const SHEETS: usize = 3;

/// Pixmaps of a pane that shows the eyes by turns, and one that stays black.
const SHEETS_OF_TURNS: usize = 2 * SHEETS + 1;

pub(super) struct Pane {
    pub(super) output: Output,
    pub(super) clock: Mutex<RefreshClock>,
    /// The pixmaps at the monitor's size; `None` while the monitor is away.
    sheets: Mutex<Option<Arc<Sheets>>>,
    was_away: AtomicBool,
    /// The eyes by turns, where it shows them so.
    pub(super) turns: Option<Mutex<Turns>>,
}

/// Pixmaps of one size.
pub(super) struct Sheets {
    pub(super) size: [u16; 2],
    /// The monitor's upper left corner.
    pub(super) corner: [i16; 2],
    pub(super) all: Vec<Sheet>,
}

pub(super) struct Sheet {
    /// The pixmap of an X server, or the frame buffer of a card.
    pub(super) pixmap: u32,
    pub(super) memory: Memory,
    /// How often the display may still read it.
    readers: AtomicU32,
    /// The number of what was written last; 0 for nothing.
    holds: AtomicU64,
    /// Whether the display has another order of bytes.
    is_swapped: bool,
}

pub(super) enum Memory {
    /// A segment that the server has mapped, and whether it is the pixmap.
    Shared {
        file: File,
        segment: u32,
        is_pixmap: bool,
    },
    /// Bytes that are sent.
    Own(Mutex<Vec<u8>>),
    /// A frame buffer, its bytes a row, and those from row to row.
    Mapped {
        bytes: Mutex<Box<dyn AsMut<[u8]> + Send>>,
        row: usize,
        pitch: usize,
    },
}

/// A pane to be made.
pub(super) struct NewPane {
    pub(super) output: Output,
    /// The resolution of the projector that it shows.
    pub(super) resolution: Option<[u32; 2]>,
    pub(super) takes_turns: bool,
}

impl NewPane {
    /// Refuses a monitor on which a projector's pixels would not be its own.
    pub(super) fn check_size(&self, monitor: &Monitor) -> Result<(), WindowError> {
        let size = monitor.size.map(u32::from);
        let Some([columns, rows]) = self.resolution.filter(|resolution| *resolution != size) else {
            return Ok(());
        };
        Err(WindowError::refused(
            format!(
                "projector {} has {columns} × {rows} pixels, and monitor {} {} × {}",
                self.output.show, self.output.monitor, size[0], size[1]
            ),
            "give the monitor this mode, by xrandr on an X server, or write its size as the \
             projector's resolution",
        ))
    }
}

impl Pane {
    pub(super) fn new(new: NewPane, monitor: &Monitor) -> Self {
        Self {
            output: new.output,
            clock: Mutex::new(RefreshClock::of(monitor)),
            sheets: Mutex::new(None),
            was_away: AtomicBool::new(false),
            turns: new.takes_turns.then(Mutex::default),
        }
    }

    /// Returns how many pixmaps it takes.
    pub(super) const fn sheet_count(&self) -> usize {
        match self.turns {
            Some(_) => SHEETS_OF_TURNS,
            None => SHEETS,
        }
    }

    /// Returns the pixmaps at the monitor's size; `None` while it is away.
    pub(super) fn sheets(&self) -> Option<Arc<Sheets>> {
        lock(&self.sheets).clone()
    }

    /// Has other pixmaps, and returns those before.
    pub(super) fn replace(&self, others: Option<Sheets>) -> Option<Arc<Sheets>> {
        std::mem::replace(&mut *lock(&self.sheets), others.map(Arc::new))
    }

    /// Takes whether its monitor is there. Returns what is to be told.
    pub(super) fn note_monitor(&self, is_there: bool) -> Option<String> {
        let was_away = self.was_away.swap(!is_there, Ordering::Relaxed);
        let (name, screen) = (&self.output.monitor, &self.output.show);
        match (was_away, is_there) {
            (false, false) => Some(format!(
                "monitor {name} has gone: \"{screen}\" is shown again when it is back under this \
                 name"
            )),
            (true, true) => Some(format!("monitor {name} is back and shows \"{screen}\"")),
            _ => None,
        }
    }

    /// Notes that the display reads a pixmap once more, or once less.
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
    /// Returns the numbers of pixmaps that the display does not read.
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
}

impl Sheet {
    pub(super) const fn new(pixmap: u32, memory: Memory, is_swapped: bool) -> Self {
        Self {
            pixmap,
            memory,
            readers: AtomicU32::new(0),
            holds: AtomicU64::new(0),
            is_swapped,
        }
    }

    /// Returns whether it holds something else than what has a number, which it does from now on.
    pub(super) fn lacks(&self, number: u64) -> bool {
        self.holds.swap(number, Ordering::Relaxed) != number
    }

    /// Writes rows of pixels, 0xRRGGBB each, in the display's order of bytes.
    pub(super) fn write(&self, pixels: &[u32]) -> std::io::Result<()> {
        let mut swapped = Vec::new();
        if self.is_swapped {
            swapped.extend(pixels.iter().map(|pixel| pixel.swap_bytes()));
        }
        let pixels = if swapped.is_empty() { pixels } else { &swapped };
        match &self.memory {
            Memory::Shared { file, .. } => file.write_all_at(pixels.as_bytes(), 0)?,
            Memory::Own(bytes) => lock(bytes).copy_from_slice(pixels.as_bytes()),
            Memory::Mapped { bytes, row, pitch } => {
                let mut bytes = lock(bytes);
                let to = (**bytes).as_mut().chunks_mut(*pitch);
                for (to, from) in to.zip(pixels.as_bytes().chunks_exact(*row)) {
                    to[..*row].copy_from_slice(from);
                }
            }
        }
        Ok(())
    }
}
