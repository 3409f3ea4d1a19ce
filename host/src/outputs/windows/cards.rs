//! Graphics cards without a desktop, by the kernel's mode setting: a flip of pages for each
//! connector.
//!
//! A flip is done at the next refresh. So a pixmap waits here until the refresh before its own, and
//! a refresh is asked for only while one waits.

use super::clock::{Epoch, RefreshClock};
use super::display::{Display, Heard};
use super::monitors::{Monitor, named};
use super::pane::{Memory, NewPane, Pane, Sheet, Sheets};
use super::turns::Turn;
use crate::live::lock;
use crate::outputs::Output;
use crate::show::window::WindowError;
use drm::buffer::{Buffer, DrmFourcc};
use drm::control::dumbbuffer::DumbBuffer;
use drm::control::{
    Device as _, Event, Mode, ModeFlags, ModeTypeFlags, PageFlipFlags, ResourceHandles, connector,
    crtc, framebuffer, from_u32,
};
use drm::{Device as _, VblankWaitFlags, VblankWaitTarget};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The time between two looks at what is plugged in.
const LOOKING: Duration = Duration::from_secs(1);

/// The longest wait for events, after which the end is looked for.
const WAITING: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};

const HELP: &str = "run it as root or from a text console, with no X server or Wayland on this \
    card; elsewhere take --backend x11. A card without vertical blanks, such as QEMU's, cannot \
    present";

/// A graphics card and the connectors that show panes.
pub(super) struct Card {
    device: Device,
    /// This card's number among displays, and its path.
    number: usize,
    name: String,
    heads: Vec<Head>,
    epoch: Epoch,
    heard: Sender<Heard>,
}

struct Device(File);

/// A connector.
struct Head {
    pane: Pane,
    connector: connector::Handle,
    crtc: crtc::Handle,
    /// The place of its CRTC among those of the card.
    pipe: u32,
    resolution: Option<[u32; 2]>,
    flips: Mutex<Flips>,
}

#[derive(Default)]
struct Flips {
    buffers: Vec<(framebuffer::Handle, DumbBuffer)>,
    /// What is to be shown, by refresh.
    queue: BTreeMap<u64, Turn>,
    /// What is shown from the next refresh on.
    pending: Option<Turn>,
    on_screen: u32,
    /// Whether the kernel tells of the next refresh.
    is_awaited: bool,
}

impl AsFd for Device {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

impl drm::Device for Device {}
impl drm::control::Device for Device {}

impl Device {
    fn open(path: &str) -> Result<Self, WindowError> {
        let file = File::options().read(true).write(true).open(path);
        let opened = file.map(Self);
        opened.map_err(|error| WindowError::refused(format!("{path}: {error}"), HELP))
    }

    fn connectors(&self, of: &ResourceHandles) -> io::Result<Vec<connector::Info>> {
        let all = of.connectors().iter();
        all.map(|&one| self.get_connector(one, true)).collect()
    }

    /// Returns a CRTC that can drive a connector and drives no other one.
    fn crtc(
        &self,
        of: &ResourceHandles,
        connector: &connector::Info,
        heads: &[Head],
    ) -> io::Result<Option<crtc::Handle>> {
        for &encoder in connector.encoders() {
            let possible = self.get_encoder(encoder)?.possible_crtcs();
            let mut all = of.filter_crtcs(possible).into_iter();
            let free = all.find(|&crtc| heads.iter().all(|head| head.crtc != crtc));
            if free.is_some() {
                return Ok(free);
            }
        }
        Ok(None)
    }
}

/// Has each output's card as its server: the one that has its connector.
pub(super) fn assign<'o>(outputs: impl Iterator<Item = &'o mut Output>) -> Result<(), WindowError> {
    let entries = std::fs::read_dir("/dev/dri").into_iter().flatten();
    let paths = entries.filter_map(|entry| entry.ok()?.path().to_str().map(str::to_owned));
    let mut paths: Vec<String> = paths.filter(|path| path.contains("/card")).collect();
    paths.sort();
    if paths.is_empty() {
        let message = "this machine has no graphics card that a program may use: there is no \
            /dev/dri/card0"
            .to_owned();
        return Err(WindowError::refused(message, HELP));
    }
    // The kernel gives each connector of a machine a name of its own.
    let (mut monitors, mut cards) = (Vec::new(), HashMap::new());
    for path in paths {
        let device = Device::open(&path)?;
        // Cards that only render have none.
        let Ok(resources) = device.resource_handles() else {
            continue;
        };
        for info in device.connectors(&resources)? {
            if let Some(mode) = mode_of(&info, None) {
                monitors.push(monitor(&info, &mode));
                cards.insert(info.to_string(), path.clone());
            }
        }
    }
    for output in outputs {
        if let Some(server) = &output.server {
            return Err(WindowError::refused(
                format!("\"{}\" is to be shown on X server {server}", output.show),
                "leave server out with --backend kms, or take --backend x11",
            ));
        }
        named(&monitors, &output.monitor, "this machine")?;
        output.server = cards.get(&output.monitor).cloned();
    }
    Ok(())
}

/// Returns the mode in which a connector shows something; `None` where nothing is plugged in.
fn mode_of(connector: &connector::Info, resolution: Option<[u32; 2]>) -> Option<Mode> {
    let is_plugged = connector.state() == connector::State::Connected;
    let modes = connector.modes().iter().filter(|_| is_plugged);
    // The first of the best.
    let best = modes.rev().max_by_key(|mode| {
        let (columns, rows) = mode.size();
        (
            resolution == Some([columns.into(), rows.into()]),
            !mode.flags().contains(ModeFlags::INTERLACE),
            mode.mode_type().contains(ModeTypeFlags::PREFERRED),
        )
    });
    best.copied()
}

fn monitor(connector: &connector::Info, mode: &Mode) -> Monitor {
    let (columns, rows) = mode.size();
    let pixels = f64::from(mode.hsync().2) * f64::from(mode.vsync().2);
    let hz = 1_000.0 * f64::from(mode.clock()) / pixels;
    Monitor {
        name: connector.to_string(),
        corner: [0; 2],
        size: [columns, rows],
        hz: (1.0..=1_000.0).contains(&hz).then_some(hz),
    }
}

/// Opens the card of a path and this number, and sets the mode of each pane's connector.
pub(super) fn open(
    number: usize,
    path: &str,
    panes: Vec<NewPane>,
    heard: Sender<Heard>,
) -> Result<Arc<dyn Display>, WindowError> {
    let device = Device::open(path)?;
    let refused = |what: &str, error: io::Error| {
        WindowError::refused(format!("{path} {what} ({error})"), HELP)
    };
    let used = "is in use by an X server, Wayland or another program";
    let owned = device.acquire_master_lock();
    owned.map_err(|error| refused(used, error))?;
    let resources = device.resource_handles()?;
    let connectors = device.connectors(&resources)?;
    let mut heads = Vec::new();
    for new in panes {
        let name = &new.output.monitor;
        let found = connectors.iter().find_map(|info| {
            let mode = mode_of(info, new.resolution)?;
            (info.to_string() == *name).then_some((info, mode))
        });
        let Some((info, mode)) = found else {
            return Err(WindowError::gone(&format!("{name} was unplugged")));
        };
        let monitor = monitor(info, &mode);
        new.check_size(&monitor)?;
        let Some(crtc) = device.crtc(&resources, info, &heads)? else {
            let message = format!("{path} cannot drive {name} beside the other monitors");
            let help = "leave one of its monitors out, or plug it into another card";
            return Err(WindowError::refused(message, help));
        };
        let pipe = resources.crtcs().iter().position(|one| *one == crtc);
        heads.push(Head {
            connector: info.handle(),
            crtc,
            pipe: pipe.unwrap_or_default() as u32,
            resolution: new.resolution,
            pane: Pane::new(new, &monitor),
            flips: Mutex::default(),
        });
    }
    let card = Card {
        device,
        number,
        name: path.to_owned(),
        heads,
        epoch: Epoch::now(),
        heard,
    };
    for (number, head) in card.heads.iter().enumerate() {
        let placed = card.place(number);
        placed.map_err(|error| {
            refused(
                &format!("cannot present on {}", head.pane.output.monitor),
                error,
            )
        })?;
    }
    Ok(Arc::new(card))
}

impl Card {
    /// Sets the mode of a connector into which a monitor was plugged, and frees one from which it was
    /// unplugged. Returns what is to be told.
    fn place(&self, number: usize) -> io::Result<Option<String>> {
        let head = &self.heads[number];
        let is_shown = head.pane.sheets().is_some();
        // Asking the monitor itself can make it flicker.
        let info = self.device.get_connector(head.connector, !is_shown)?;
        let mut flips = lock(&head.flips);
        match (is_shown, mode_of(&info, head.resolution)) {
            (true, None) => {
                head.pane.replace(None);
                let before = std::mem::take(&mut *flips);
                for turn in before.pending.into_iter().chain(before.queue.into_values()) {
                    self.pass_over(number, turn);
                }
                self.device.set_crtc(head.crtc, None, (0, 0), &[], None)?;
                for (frame, buffer) in before.buffers {
                    self.device.destroy_framebuffer(frame)?;
                    self.device.destroy_dumb_buffer(buffer)?;
                }
                Ok(head.pane.note_monitor(false))
            }
            (false, Some(mode)) => {
                let monitor = monitor(&info, &mode);
                *lock(&head.pane.clock) = RefreshClock::of(&monitor);
                let mut all = Vec::new();
                for _ in 0..head.pane.sheet_count() {
                    all.push(self.sheet(&mut flips, monitor.size)?);
                }
                let frame = flips.buffers.last().map(|(frame, _)| *frame);
                let connectors = [head.connector];
                self.device
                    .set_crtc(head.crtc, frame, (0, 0), &connectors, Some(mode))?;
                let (size, corner) = (monitor.size, monitor.corner);
                head.pane.replace(Some(Sheets { size, corner, all }));
                flips.on_screen = frame.map_or(0, u32::from);
                head.pane.note_reader(flips.on_screen, true);
                // The refreshes until now tell the clock.
                let (newest, time) = self.newest(head)?;
                lock(&head.pane.clock).hear(self.epoch.instant(time.as_micros() as u64), newest);
                Ok(head.pane.note_monitor(true))
            }
            _ => Ok(None),
        }
    }

    fn sheet(&self, flips: &mut Flips, [columns, rows]: [u16; 2]) -> io::Result<Sheet> {
        let (size, format) = ((columns.into(), rows.into()), DrmFourcc::Xrgb8888);
        let buffer = self.device.create_dumb_buffer(size, format, 32)?;
        let frame = self.device.add_framebuffer(&buffer, 24, 32)?;
        flips.buffers.push((frame, buffer));
        // A mapping borrows the buffer's description: these bytes are never freed.
        let mapping = self.device.map_dumb_buffer(Box::leak(Box::new(buffer)))?;
        let memory = Memory::Mapped {
            bytes: Mutex::new(Box::new(mapping)),
            row: 4 * usize::from(columns),
            pitch: buffer.pitch() as usize,
        };
        Ok(Sheet::new(
            frame.into(),
            memory,
            cfg!(target_endian = "big"),
        ))
    }

    /// Tells that a pixmap is not shown.
    fn pass_over(&self, number: usize, turn: Turn) {
        let _ = self.heard.send(Heard::Shown {
            server: self.number,
            pane: number,
            serial: turn.serial,
            at: Instant::now(),
            refresh: turn.refresh,
            skipped: true,
        });
    }

    /// Returns the number of the newest refresh, and its time on the monotonic clock.
    fn newest(&self, head: &Head) -> io::Result<(u64, Duration)> {
        let (now, at_once) = (VblankWaitTarget::Relative(0), VblankWaitFlags::empty());
        let reply = self.device.wait_vblank(now, at_once, head.pipe, 0)?;
        Ok((reply.frame().into(), reply.time().unwrap_or_default()))
    }

    /// Flips to the pixmap that is due at the next refresh, or waits for that refresh.
    fn flip(&self, head: &Head, flips: &mut Flips) -> io::Result<()> {
        if flips.pending.is_some() || flips.queue.is_empty() {
            return Ok(());
        }
        let next = self.newest(head)?.0 + 1;
        let mut due: Option<Turn> = None;
        while let Some(entry) = flips.queue.first_entry()
            && *entry.key() <= next
        {
            if let Some(late) = due.replace(entry.remove()) {
                head.pane.note_reader(late.pixmap, false);
            }
        }
        // A late eye must not take the other one's turn.
        let late = due.take_if(|due| head.pane.turns.is_some() && due.refresh < next);
        if let Some(late) = late {
            head.pane.note_reader(late.pixmap, false);
        }
        if let Some(turn) = due
            && let Some(frame) = from_u32(turn.pixmap)
        {
            let flags = PageFlipFlags::EVENT;
            match self.device.page_flip(head.crtc, frame, flags, None) {
                Ok(()) => {
                    flips.pending = Some(turn);
                    return Ok(());
                }
                // The flip before is not over.
                Err(error) if error.kind() == io::ErrorKind::ResourceBusy => {
                    flips.queue.insert(turn.refresh, turn);
                }
                Err(error) => return Err(error),
            }
        }
        if !flips.queue.is_empty() && !flips.is_awaited {
            let (next, flags) = (VblankWaitTarget::Relative(1), VblankWaitFlags::EVENT);
            self.device.wait_vblank(next, flags, head.pipe, 0)?;
            flips.is_awaited = true;
        }
        Ok(())
    }

    fn take(&self, event: Event) -> Result<(), WindowError> {
        let (crtc, frame, time, is_flip) = match event {
            Event::PageFlip(one) => (one.crtc, one.frame, one.duration, true),
            Event::Vblank(one) => (one.crtc, one.frame, one.time, false),
            Event::Unknown(_) => return Ok(()),
        };
        let Some(number) = self.heads.iter().position(|head| head.crtc == crtc) else {
            return Ok(());
        };
        let head = &self.heads[number];
        let at = self.epoch.instant(time.as_micros() as u64);
        let refresh = u64::from(frame);
        lock(&head.pane.clock).hear(at, refresh);
        let mut flips = lock(&head.flips);
        flips.is_awaited &= is_flip;
        if is_flip && let Some(turn) = flips.pending.take() {
            let before = std::mem::replace(&mut flips.on_screen, turn.pixmap);
            head.pane.note_reader(before, false);
            drop(flips);
            self.take_turn(number, turn.serial, refresh, &self.heard)?;
            let _ = self.heard.send(Heard::Shown {
                server: self.number,
                pane: number,
                serial: turn.serial,
                at,
                refresh,
                skipped: false,
            });
            flips = lock(&head.flips);
        }
        Ok(self.flip(head, &mut flips)?)
    }
}

impl Display for Card {
    fn name(&self) -> &str {
        &self.name
    }

    fn pane(&self, number: usize) -> &Pane {
        &self.heads[number].pane
    }

    fn has_one_clock(&self) -> bool {
        false
    }

    fn present(&self, number: usize, turn: Turn) -> Result<(), WindowError> {
        let head = &self.heads[number];
        let mut flips = lock(&head.flips);
        let mut frames = flips.buffers.iter();
        // Those of a monitor that has gone are no more.
        if !frames.any(|(frame, _)| u32::from(*frame) == turn.pixmap) {
            self.pass_over(number, turn);
            return Ok(());
        }
        if let Some(older) = flips.queue.insert(turn.refresh, turn) {
            head.pane.note_reader(older.pixmap, false);
        }
        Ok(self.flip(head, &mut flips)?)
    }

    fn hear(&self, heard: &Sender<Heard>, over: &AtomicBool) -> Result<(), WindowError> {
        let mut looked = Instant::now();
        while !over.load(Ordering::Relaxed) {
            let mut waited = [PollFd::new(&self.device, PollFlags::IN)];
            match poll(&mut waited, Some(&WAITING)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => {}
                Ok(_) => {
                    for event in self.device.receive_events()? {
                        self.take(event)?;
                    }
                }
                Err(error) => return Err(io::Error::from(error).into()),
            }
            if looked.elapsed() >= LOOKING {
                looked = Instant::now();
                for number in 0..self.heads.len() {
                    if let Some(said) = self.place(number)? {
                        let _ = heard.send(Heard::Said(said));
                    }
                }
            }
        }
        Ok(())
    }
}
