//! The windows of outputs on X servers, or their connectors on graphics cards.

#[cfg_attr(not(target_os = "linux"), path = "windows/no_cards.rs")]
mod cards;
mod clock;
mod compose;
mod counts;
mod display;
mod monitors;
mod pane;
mod server;
mod turns;
mod window;

use super::{Backend, Output, OutputsReport, PaneReport, Placing};
use crate::cave::Eye;
use crate::live::{Refresh, lock};
use crate::picture::Picture;
use crate::projection::Projection;
use crate::show::stereo::Stereo;
use crate::show::window::WindowError;
use compose::{compose, patch};
use counts::Counts;
use display::{Display, Heard, MemoryWay, Request, Server};
use pane::{NewPane, Pane, Sheets};
use server::XServer;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use turns::Turn;

/// Periods after its time at which a frame is no longer waited for.
const PATIENCE: u32 = 6;

/// Windows on monitors.
#[expect(missing_debug_implementations, reason = "a connection has none")]
pub struct Outputs {
    servers: Vec<Server>,
    panes: Vec<Showing>,
    heard: Receiver<Heard>,
    stereo: Stereo,
    /// The number of the next frame.
    frame: u32,
    counts: Counts,
    said: Vec<String>,
}

/// A pane as the renderer of frames sees it.
struct Showing {
    server: usize,
    pane: usize,
    /// The numbers of the left eye's picture and of the right one's.
    pictures: [usize; 2],
    /// What a projector shows of them.
    projection: Option<Projection>,
    output: Output,
    /// The pixels of both eyes where it shows them by turns, else of one picture.
    pixels: Vec<Vec<u32>>,
    /// How often these have changed.
    version: u64,
    /// The monitor's size for which they were made.
    made_for: [u32; 2],
    /// The pixmaps that are filled, of those at the monitor's size.
    ready: Option<(Arc<Sheets>, Vec<usize>)>,
    /// Whether it was told why it shows nothing.
    is_told: bool,
    /// The refresh that the frame is for, until it was shown.
    awaited: Option<u64>,
    /// When the newest frame was shown, and at which refresh.
    newest: Option<(Instant, u64)>,
}

impl Outputs {
    /// Opens windows for those outputs whose screens are among `pictures`, which are of a screen
    /// and an eye each. Outputs that show none of these screens show one of the projectors.
    ///
    /// # Errors
    /// A server or card that cannot be reached or does not answer, a monitor that is not there or
    /// has another size than its projector.
    pub fn open(
        outputs: &[Output],
        pictures: &[(&str, Eye)],
        projections: &[Projection],
        stereo: Stereo,
        backend: Backend,
        placing: Placing,
    ) -> Result<Self, WindowError> {
        let (said, heard) = channel();
        let (mut here, lacking) = with_pictures(outputs, pictures, projections, stereo);
        if backend == Backend::Kms {
            cards::assign(here.iter_mut().map(|(output, _)| output))?;
        }
        let mut names: Vec<Option<String>> = Vec::new();
        for (output, _) in &here {
            if !names.contains(&output.server) {
                names.push(output.server.clone());
            }
        }
        let (mut servers, mut panes) = (Vec::new(), Vec::new());
        for (number, name) in names.iter().enumerate() {
            let of_server = here.iter().filter(|(one, _)| one.server == *name);
            let mut own = Vec::new();
            for (pane, (output, pictures)) in of_server.enumerate() {
                let projection = projection_of(output, projections);
                let takes_turns =
                    output.eye.is_none() && output.stereo.unwrap_or(stereo) == Stereo::Sequential;
                own.push(NewPane {
                    output: output.clone(),
                    resolution: projection.map(Projection::resolution),
                    takes_turns,
                });
                panes.push(Showing {
                    server: number,
                    pane,
                    pictures: *pictures,
                    projection: projection.cloned(),
                    output: output.clone(),
                    pixels: vec![Vec::new(); 1 + usize::from(takes_turns)],
                    version: 0,
                    made_for: [0; 2],
                    ready: None,
                    is_told: false,
                    awaited: None,
                    newest: None,
                });
            }
            let display: Arc<dyn Display> = match (backend, name) {
                (Backend::Kms, Some(card)) => cards::open(number, card, own, said.clone())?,
                _ => Arc::new(XServer::open(number, name.as_deref(), own, placing)?),
            };
            servers.push(Server::start(number, display, &said)?);
        }
        let mut all = Self {
            counts: Counts::new(panes.len()),
            servers,
            panes,
            heard,
            stereo,
            frame: 0,
            said: lacking,
        };
        all.tell_of_ways();
        Ok(all)
    }

    /// Notes what a server lacks.
    fn tell_of_ways(&mut self) {
        for server in &self.servers {
            let (name, display) = (server.display.name(), &server.display);
            if !display.has_present() {
                self.said.push(format!(
                    "{name} has no Present: frames are shown when they are done, and \
                     when is not known"
                ));
            }
            if display.memory() == MemoryWay::Sent {
                self.said.push(format!(
                    "{name} shares no memory: each frame is sent, which takes longer; a \
                     server on this machine with MIT-SHM 1.2 shares it"
                ));
            }
        }
    }

    /// Returns what there is to be told, each sentence once.
    pub fn said(&mut self) -> impl Iterator<Item = String> + '_ {
        self.said.drain(..)
    }

    /// Returns the frames per second of the first output's monitor by its mode.
    pub fn hz(&self) -> f64 {
        let first = self.panes.first();
        let period = first.map(|shown| lock(&self.pane(shown).clock).period());
        period.map_or(60.0, |period| 1.0 / (period * self.turn()).as_secs_f64())
    }

    /// Returns the refreshes that a frame takes at least: two where eyes take turns.
    fn turn(&self) -> u32 {
        let mut panes = self.panes.iter();
        1 + u32::from(panes.any(|shown| shown.pixels.len() > 1))
    }

    fn pane(&self, shown: &Showing) -> &Pane {
        self.servers[shown.server].display.pane(shown.pane)
    }

    /// Fills a pixmap of each window with a frame's pictures, in the order of those it was opened
    /// with.
    pub fn prepare(&mut self, pictures: &[Picture]) {
        for number in 0..self.panes.len() {
            let shown = &self.panes[number];
            let Some(size) = self.pane(shown).sheets().map(|sheets| sheets.size) else {
                continue;
            };
            let shown = &mut self.panes[number];
            let [left, right] = shown.pictures.map(|number| pictures.get(number));
            let (Some(left), Some(right)) = (left, right) else {
                continue;
            };
            let size = size.map(u32::from);
            let stereo = shown.output.stereo.unwrap_or(self.stereo);
            let projection = shown.projection.as_ref();
            shown.version += 1;
            shown.made_for = size;
            for (pixels, eye) in shown.pixels.iter_mut().zip(Eye::STEREO) {
                pixels.resize(size[0] as usize * size[1] as usize, 0);
                let (output, eyes) = (&shown.output, [left, right]);
                let made = compose(output, projection, stereo, eyes, eye, size, pixels);
                if let Err(error) = made {
                    pixels.fill(0);
                    if !std::mem::replace(&mut shown.is_told, true) {
                        self.said
                            .push(format!("monitor {}: {error}", output.monitor));
                    }
                }
            }
        }
        self.prepare_again();
    }

    /// Fills a pixmap of each window with pixels of its own, 0xRRGGBB in rows, which `draw` makes for
    /// an output, the size of its monitor and the refresh at which it is shown, as far as that is
    /// known.
    pub fn prepare_own(&mut self, mut draw: impl FnMut(&Output, [u32; 2], u64) -> Vec<u32>) {
        for number in 0..self.panes.len() {
            let shown = &self.panes[number];
            let Some(size) = self.pane(shown).sheets().map(|sheets| sheets.size) else {
                continue;
            };
            let next = lock(&self.pane(shown).clock).first_after(Instant::now());
            let size = size.map(u32::from);
            let pixels = draw(&shown.output, size, next.unwrap_or_default());
            let shown = &mut self.panes[number];
            shown.version += 1;
            shown.made_for = size;
            shown.pixels.fill(pixels);
        }
        self.prepare_again();
    }

    /// Fills a pixmap of each window with the newest pictures once more. Returns whether a monitor
    /// has another size since they were prepared: it is dark until they are prepared anew.
    pub fn prepare_again(&mut self) -> bool {
        let mut is_outdated = false;
        self.frame = self.frame.wrapping_add(1);
        for shown in &mut self.panes {
            shown.ready = None;
            let server = &mut self.servers[shown.server];
            let sheets = server.display.pane(shown.pane).sheets();
            let Some(sheets) = sheets.filter(|_| !server.gone) else {
                continue;
            };
            let (output, size) = (&shown.output, sheets.size.map(u32::from));
            let free: Vec<usize> = sheets.free().take(shown.pixels.len()).collect();
            if free.len() < shown.pixels.len() {
                continue;
            }
            if shown.made_for != size {
                (shown.made_for, is_outdated) = (size, true);
                shown.version += 1;
                for pixels in &mut shown.pixels {
                    pixels.clear();
                    pixels.resize(size[0] as usize * size[1] as usize, 0);
                }
            }
            let is_lit = output.sync_patch.is_some() && self.frame.is_multiple_of(2);
            let first = 4 * shown.version + 2 * u64::from(is_lit) + 1;
            for (content, (pixels, &number)) in (first..).zip(shown.pixels.iter_mut().zip(&free)) {
                if !sheets.all[number].lacks(content) {
                    continue;
                }
                if let Some(corner) = output.sync_patch {
                    patch(corner, is_lit, size, pixels);
                }
                match sheets.all[number].write(pixels) {
                    Ok(()) => {
                        server.ask(Request::Fill(shown.pane, Arc::clone(&sheets), number));
                    }
                    Err(error) => self.said.push(format!(
                        "\"{}\" is not shown: its memory cannot be written ({error})",
                        output.show
                    )),
                }
            }
            shown.ready = Some((sheets, free));
        }
        is_outdated
    }

    /// Shows what was prepared, on each monitor at its first refresh at or after a time, and waits
    /// until that was done. Returns when; `None` where no server says.
    pub fn present(&mut self, at: Instant) -> Option<Refresh> {
        self.listen();
        let mut period = Duration::ZERO;
        for number in 0..self.panes.len() {
            let shown = &mut self.panes[number];
            let server = &mut self.servers[shown.server];
            let Some((sheets, free)) = shown.ready.take() else {
                self.counts.note_hidden(number);
                continue;
            };
            let (number, display) = (shown.pane, &server.display);
            let pane = display.pane(number);
            let pixmaps: Vec<u32> = free.iter().map(|&free| sheets.all[free].pixmap).collect();
            let clock = *lock(&pane.clock);
            period = period.max(clock.period());
            // Without a clock yet: at once.
            let refresh = clock.first_after(at).unwrap_or(0);
            let (request, refresh) = match (pixmaps.as_slice(), display.has_present()) {
                (&[left, right], true) => {
                    let (from, frame) = (refresh.next_multiple_of(2), self.frame);
                    let request = Request::Pair {
                        pane: number,
                        pair: [left, right],
                        frame,
                        from,
                    };
                    (request, Some(from))
                }
                (&[pixmap, ..], true) => {
                    pane.note_reader(pixmap, true);
                    let turn = Turn {
                        pixmap,
                        serial: turns::serial(self.frame, 0),
                        refresh,
                    };
                    (Request::Present(number, turn), Some(refresh))
                }
                (&[pixmap, ..], false) => {
                    let request = Request::Copy {
                        pane: number,
                        pixmap,
                        size: sheets.size,
                    };
                    (request, None)
                }
                ([], _) => continue,
            };
            let is_single = matches!(request, Request::Present(..));
            if server.ask(request) {
                shown.awaited = refresh;
            } else if is_single {
                // It was not sent, and no server will say that it has been read.
                server.display.pane(number).note_reader(pixmaps[0], false);
            }
        }
        self.wait(at + period * PATIENCE);
        let has_one_clock = self.servers.len() == 1 && self.servers[0].display.has_one_clock();
        self.counts.count(&self.panes, period, has_one_clock);
        let Some(first) = self.panes.iter().find(|shown| shown.newest.is_some()) else {
            // Frames do not go on faster for that.
            std::thread::sleep(at.saturating_duration_since(Instant::now()));
            return None;
        };
        let (_, refresh) = first.newest?;
        let clock = *lock(&self.pane(first).clock);
        let times = self.panes.iter().filter_map(|shown| shown.newest);
        Some(Refresh {
            shown: times.map(|(at, _)| at).max()?,
            at: clock.at(refresh)?,
            period: clock.period() * self.turn(),
        })
    }

    /// Waits until all servers that answer have shown the frame.
    fn wait(&mut self, last: Instant) {
        for shown in &mut self.panes {
            shown.newest = None;
        }
        let awaits = |all: &Self| {
            let mut panes = all.panes.iter();
            panes.any(|shown| {
                let server = &all.servers[shown.server];
                shown.awaited.is_some() && !server.silent && !server.gone
            })
        };
        while awaits(self) {
            let left = last.saturating_duration_since(Instant::now());
            match self.heard.recv_timeout(left) {
                Ok(heard) => self.take(heard),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => break,
            }
        }
        for shown in &self.panes {
            let server = &mut self.servers[shown.server];
            if shown.awaited.is_some() && !server.silent && !server.gone {
                server.silent = true;
                self.said.push(format!(
                    "{} does not say that frames are shown: they go on without waiting for it",
                    server.display.name()
                ));
            }
        }
    }

    /// Takes what came in the meantime.
    fn listen(&mut self) {
        while let Ok(heard) = self.heard.try_recv() {
            self.take(heard);
        }
    }

    fn take(&mut self, heard: Heard) {
        match heard {
            Heard::Shown {
                server,
                pane,
                serial,
                at,
                refresh,
                skipped,
            } => {
                self.servers[server].silent = false;
                let mut panes = self.panes.iter_mut();
                let shown = panes.find(|one| one.server == server && one.pane == pane);
                let shown = shown.filter(|_| serial == turns::serial(self.frame, 0));
                // An eye that comes too late for its turn has another.
                if let Some(shown) = shown.filter(|one| !skipped || one.pixels.len() == 1) {
                    let wanted = shown.awaited.take();
                    if !skipped {
                        shown.newest = Some((at, refresh));
                        let late = wanted.is_some_and(|wanted| refresh > wanted && wanted > 0);
                        let number = self
                            .panes
                            .iter()
                            .position(|one| one.server == server && one.pane == pane);
                        self.counts
                            .note_shown(number.unwrap_or_default(), refresh, late);
                    }
                }
            }
            Heard::Said(text) => self.said.push(text),
            Heard::Gone(server, why) => {
                let server = &mut self.servers[server];
                if !std::mem::replace(&mut server.gone, true) {
                    let name = server.display.name();
                    self.said.push(format!(
                        "{name} has gone ({why}): its monitors show nothing more, others \
                         go on"
                    ));
                }
            }
        }
    }

    /// Returns whether any server is still there.
    pub fn is_open(&self) -> bool {
        self.servers.iter().any(|server| !server.gone)
    }

    /// Returns what was shown.
    pub fn report(&self) -> OutputsReport {
        let panes = self.panes.iter().enumerate().map(|(number, shown)| {
            let hz = 1.0 / lock(&self.pane(shown).clock).period().as_secs_f64();
            let turns = self.pane(shown).turns.as_ref();
            let wrong_eyes = turns.map(|turns| lock(turns).wrong_count);
            let report = self.counts.report(number, &shown.output, hz);
            PaneReport {
                wrong_eyes,
                direct: shown.projection.as_ref().map(Projection::is_direct),
                ..report
            }
        });
        self.counts.all(panes.collect())
    }
}

fn projection_of<'p>(output: &Output, projections: &'p [Projection]) -> Option<&'p Projection> {
    projections.iter().find(|one| one.name() == output.show)
}

/// Returns the outputs whose pictures this machine has, each with the numbers of those for the left
/// eye and for the right one, and what is to be told of others.
fn with_pictures(
    outputs: &[Output],
    pictures: &[(&str, Eye)],
    projections: &[Projection],
    stereo: Stereo,
) -> (Vec<(Output, [usize; 2])>, Vec<String>) {
    let (mut here, mut lacking) = (Vec::new(), Vec::new());
    for output in outputs {
        let projection = projection_of(output, projections);
        let source = projection.map_or(output.show.as_str(), Projection::source);
        let mut output = output.clone();
        output.eye = output.eye.or(projection.and_then(Projection::eye));
        let of = |wanted: Eye| {
            let mut all = pictures.iter();
            all.position(|&(name, eye)| name == source && (eye == wanted || eye == Eye::Centre))
        };
        let [left, right] = [of(Eye::Left), of(Eye::Right)];
        let is_mono = output.stereo.unwrap_or(stereo) == Stereo::Mono;
        let found = match output.eye {
            Some(Eye::Right) => right.map(|one| [one; 2]),
            Some(_) => left.map(|one| [one; 2]),
            None if is_mono => left.map(|one| [one; 2]),
            None => left.zip(right).map(|(left, right)| [left, right]),
        };
        if let Some(pictures) = found {
            here.push((output, pictures));
        } else if pictures.iter().any(|(name, _)| *name == source) {
            lacking.push(format!(
                "monitor {} shows nothing: there is no picture of \"{source}\" for each eye that it \
                 shows",
                output.monitor
            ));
        }
        // Else another machine has its pictures.
    }
    (here, lacking)
}
