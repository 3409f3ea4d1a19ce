//! A display controller: tracker bytes in on UART0, tiles of pixels out on
//! UART1, its log on UART2.
//!
//! It links only without a path to a panic: the panic handler calls a function that
//! does not exist. It never allocates, and waits only for a port that sends. It renders a
//! frame slice by slice, and reads its ports between slices.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;
use cortex_m_rt::entry;
use glam::Vec3;
use heapless::Deque;
use shisen_core::frame::{
    Budget, CompactRenderer, DomePose, DomeProjection, FrameJob, MirrorCamera, Part, Pictures,
    Pixel, Place, Progress, Statistics, Tile, Tiles, View, Workspace,
};
use shisen_core::gaze::HeadPose;
use shisen_core::scene::CompactScene;
#[cfg(feature = "dispersion")]
use shisen_core::{
    frame::Spectrum,
    spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths},
};
use shisen_firmware::board::{self, Board, DISPLAY};
use shisen_firmware::display::{Display, Shown, TILE, level_of_detail};
use shisen_firmware::line::Line;
use shisen_firmware::restart::Restart;
use shisen_firmware::viewer::Viewer;
use shisen_firmware::{say, scene};
use shisen_tracker::estimate::State;
use shisen_tracker::link::Encoder;
use shisen_tracker::link::display::{
    FrameDone, FrameStart, MOST_PIXELS, Order, Orders, Ready, Rendering, Report, Slice, Subject,
};
use shisen_tracker::time::Micros;

/// Most tiles of a frame.
const MOST_TILES: usize = 768;
/// Number of pixels in a tile.
const TILE_PIXELS: usize = (TILE * TILE) as usize;

/// The sender of reports and pixels.
struct Out(Encoder);

impl Out {
    fn report(&mut self, report: &Report) {
        DISPLAY.send(&self.0.report(report));
    }

    fn tile(&mut self, picture: usize, tile: Tile, pixels: &[Pixel]) {
        let mut rest = pixels;
        for y in tile.y..tile.y + tile.height {
            let (row, below) = rest
                .split_at_checked(tile.width as usize)
                .unwrap_or((rest, &[]));
            rest = below;
            let mut x = tile.x;
            for run in row.chunks(MOST_PIXELS) {
                let at = (x as u16, y as u16);
                DISPLAY.send(&self.0.pixels(picture as u8, at, run));
                x += run.len() as u32;
            }
        }
    }
}

/// Most orders that wait for the end of a frame.
const MOST_ORDERS: usize = 16;

/// The tracker's port and the display's, in use while frames are rendered.
struct Ports {
    viewer: Viewer,
    line: Line,
    /// Bytes of orders lost for lack of room, as last logged.
    lost: u32,
    orders: Orders,
    waiting: Deque<Order, MOST_ORDERS>,
    out: Out,
}

impl Ports {
    /// Takes the bytes that have come in.
    fn listen(&mut self) {
        self.viewer.listen();
        let lost = self.line.lost();
        if lost != self.lost {
            self.lost = lost;
            say!(warn, "{} bytes of orders found no room", lost);
        }
        let mut buffer = [0; 64];
        let bytes = self.line.take(&mut buffer);
        let waiting = &mut self.waiting;
        self.orders.feed(bytes, &mut |order| {
            if waiting.push_back(order).is_err() {
                say!(warn, "an order too many");
            }
        });
    }
}

/// The caller's memory, in which frames are rendered.
struct Memory {
    pixels: [Pixel; TILE_PIXELS],
    places: [Place; MOST_TILES],
    workspace: Workspace,
    #[cfg(feature = "dispersion")]
    spectrum: [SpectralSample; SPECTRUM],
}

/// Spectral samples that the table of wavelengths has room for.
#[cfg(feature = "dispersion")]
const SPECTRUM: usize = 512;
#[cfg(feature = "dispersion")]
const NO_SAMPLE: SpectralSample = SpectralSample {
    nm: 0.0,
    weight: Vec3::ZERO,
};
/// Phases of the table of wavelengths.
#[cfg(feature = "dispersion")]
const PHASES: u32 = 8;

/// Decides the next frame: gaze, eyes, budget, and screens or a dome master.
#[inline(never)]
fn start(
    number: u32,
    display: &mut Display,
    viewer: &mut Viewer,
    eyes: &mut [Vec3; 2],
) -> FrameStart {
    let delay = Micros(display.rendering.display_delay.into());
    let estimate = viewer.estimate(board::micros(board::ticks()).after(delay));
    match display.eyes(&estimate.head) {
        Some(seeing) => *eyes = seeing,
        None => say!(warn, "the head is where screens are not seen from"),
    }
    let capture = display.capture.take();
    let lod = display.rendering.lod && capture.is_none();
    let sight = estimate.line_of_sight;
    let state = State::ALL.iter().position(|&state| state == estimate.state);
    FrameStart {
        number,
        orders: display.orders,
        pictures: 0,
        subject: capture.map_or(Subject::Screens, |(size, _)| Subject::Capture { size }),
        state: state.filter(|_| lod).map(|place| place as u8),
        budget: display.rendering.budget,
        eyes: capture.map_or(*eyes, |(_, place)| [place; 2]),
        forward: sight.forward(),
        up: sight.up(),
        widen: estimate.widen,
    }
}

/// Returns the renderers of a frame, one for each eye.
#[inline(never)]
fn renderers<'a>(
    scene: CompactScene<'a>,
    start: &FrameStart,
    rendering: &Rendering,
    #[cfg(feature = "dispersion")] samples: &'a mut [SpectralSample],
) -> [CompactRenderer<'a>; 2] {
    let renderer = scene::renderer(scene, rendering.depth);
    #[cfg(feature = "dispersion")]
    let renderer = spectrum(rendering.wavelengths, samples)
        .and_then(|spectrum| renderer.with_spectrum(spectrum).ok())
        .unwrap_or(renderer);
    start.eyes.map(|eye| {
        let lod = start
            .state
            .and_then(|_| level_of_detail(eye, start.forward, start.up, start.widen));
        lod.map_or(renderer, |lod| renderer.with_level_of_detail(lod))
    })
}

#[cfg(feature = "dispersion")]
fn spectrum(count: u8, samples: &mut [SpectralSample]) -> Option<Spectrum<'_>> {
    let wavelengths = Wavelengths::new(count.into(), Wavelengths::RANGE).ok()?;
    if count < 2 {
        return None;
    }
    let table = SpectralTable::new(wavelengths, PHASES, Matching::Wyman, samples).ok()?;
    Some(Spectrum::Comb { table, each: 1 })
}

/// Renders a frame slice by slice, and reads the ports in between. Returns whether it was cut short.
// Longer than 80 lines: the steps between two slices, in order.
#[inline(never)]
fn frame(
    start: &FrameStart,
    newest: Option<u64>,
    began: u64,
    shown: &Shown<'_, '_>,
    (slice, mut restart): (u32, Option<Restart>),
    (pixels, places, workspace): (&mut [Pixel], &mut [Place], &mut Workspace),
    ports: &mut Ports,
) -> bool {
    let budget = Budget::steps(start.budget);
    let mut job = match FrameJob::new(shown, TILE, budget, places) {
        Ok(job) => job,
        Err(_error) => {
            say!(error, "no frame: {}", _error);
            ports.listen();
            return false;
        }
    };
    let ordered = board::ticks();
    ports.out.report(&Report::Frame(FrameStart {
        pictures: shown.count() as u8,
        ..*start
    }));
    let mut done = FrameDone {
        number: start.number,
        cut_short: false,
        whole: 0,
        given_up: 0,
        steps: 0,
        primary: 0,
        rays: 0,
        instructions: 0,
        preparation: board::instructions(began, ordered) as u32,
        latency: 0,
        age: 0,
        sent: 0,
    };
    workspace.statistics = Statistics::default();
    let mut first = true;
    loop {
        let before = board::ticks();
        let steps = workspace.statistics.steps;
        let mut slice = Budget::steps(slice.into());
        let progress = job.render(shown, pixels, &mut slice, workspace);
        let after = board::ticks();
        let taken = board::instructions(before, after);
        done.instructions += taken;
        let tile = match progress {
            Ok(Progress::Tile { part, tile, .. }) => Some((part, tile)),
            Ok(Progress::BudgetSpent) => None,
            Ok(Progress::Finished) => break,
            Err(_error) => {
                say!(error, "no tile: {}", _error);
                break;
            }
        };
        ports.out.report(&Report::Slice(Slice {
            frame: start.number,
            instructions: taken as u32,
            steps: (workspace.statistics.steps - steps) as u32,
            ended_tile: tile.is_some(),
            time: board::micros(after),
        }));
        if let Some((part, tile)) = tile {
            ports.out.tile(part, tile, pixels);
            if first && let Some(newest) = newest {
                let since = |time| board::instructions(newest, time) as u32;
                done.latency = since(after);
                done.age = since(began);
                done.sent = since(board::ticks());
            }
            first = false;
        }
        ports.listen();
        if let Some(restart) = &mut restart
            && restart.is_due(&mut ports.viewer)
        {
            done.cut_short = true;
            break;
        }
    }
    let Tiles { whole, given_up } = job.tiles();
    ports.out.report(&Report::FrameDone(FrameDone {
        whole,
        given_up,
        steps: workspace.statistics.steps,
        primary: workspace.statistics.primary,
        rays: workspace.statistics.rays(),
        ..done
    }));
    ports.out.report(&Report::Tracker(ports.viewer.state()));
    done.cut_short
}

/// Equatorial radius of a dome master's mirror: metres.
const MIRROR_RADIUS: f32 = 0.01;

/// Returns the view of a dome master around a place, through the best mirror.
#[inline(never)]
fn dome(place: Vec3, size: u16) -> Option<View> {
    View::dome(
        DomeProjection::Mirror(MirrorCamera::best(MIRROR_RADIUS)),
        DomePose::over_room(place),
        size.into(),
    )
    .ok()
}

/// Shows that there is no usable scene.
#[inline(never)]
fn nothing(start: &FrameStart, display: &Display, pixels: &mut [Pixel], ports: &mut Ports) {
    ports.out.report(&Report::Frame(FrameStart {
        pictures: display.screens().len() as u8,
        ..*start
    }));
    pixels.fill(scene::NO_SCENE);
    for (number, screen) in display.screens().iter().enumerate() {
        for tile in tiles(screen.size) {
            ports.out.tile(number, tile, pixels);
            ports.listen();
        }
    }
}

/// Returns the tiles of a picture, row by row.
fn tiles([columns, rows]: [u32; 2]) -> impl Iterator<Item = Tile> {
    (0..rows).step_by(TILE as usize).flat_map(move |y| {
        (0..columns).step_by(TILE as usize).map(move |x| Tile {
            x,
            y,
            width: (columns - x).min(TILE),
            height: (rows - y).min(TILE),
        })
    })
}

fn run(scene: Result<CompactScene<'static>, u32>, ports: &mut Ports, memory: &mut Memory) -> ! {
    let mut display = Display::new();
    let mut eyes = [HeadPose::IDENTITY.position; 2];
    let mut number = 0u32;
    let mut cut_short = 0u8;
    loop {
        while let Some(order) = ports.waiting.pop_front() {
            display.obey(&order);
        }
        let began = board::ticks();
        let newest = ports.viewer.take_newest();
        let start = start(number, &mut display, &mut ports.viewer, &mut eyes);
        number = number.wrapping_add(1);
        let Memory {
            pixels,
            places,
            workspace,
            #[cfg(feature = "dispersion")]
            spectrum,
        } = &mut *memory;
        let Ok(scene) = scene else {
            nothing(&start, &display, pixels, ports);
            continue;
        };
        let renderers = renderers(
            scene,
            &start,
            &display.rendering,
            #[cfg(feature = "dispersion")]
            spectrum,
        );
        let shown = match start.subject {
            Subject::Screens => Shown::Screens(display.seen(start.eyes, &renderers)),
            Subject::Capture { size } => {
                let Some(view) = dome(start.eyes[0], size) else {
                    say!(warn, "no such dome master");
                    continue;
                };
                let [renderer, _] = &renderers;
                Shown::Capture([Part { view, renderer }])
            }
        };
        let restart = Restart::new(&start, &display.rendering, &ports.viewer, cut_short);
        let was_cut = frame(
            &start,
            newest,
            began,
            &shown,
            (display.rendering.slice, restart),
            (pixels, places, workspace),
            ports,
        );
        cut_short = if was_cut {
            cut_short.saturating_add(1)
        } else {
            0
        };
    }
}

/// Returns the ports of a board whose interrupts are on.
// Not inlined: `main` never returns, so this function's stack would never be freed there.
#[inline(never)]
fn set_up(ports: &mut MaybeUninit<Ports>) -> Option<&mut Ports> {
    let board = Board::take()?;
    let ports = ports.write(Ports {
        viewer: Viewer::new(Line::TRACKER)?,
        line: Line::DISPLAY,
        lost: 0,
        orders: Orders::new(),
        waiting: Deque::new(),
        out: Out(Encoder::new()),
    });
    board.listen();
    Some(ports)
}

/// Checks the scene, and reports the result to the display.
#[inline(never)]
fn open(ports: &mut Ports, picture_bytes: usize) -> Result<CompactScene<'static>, u32> {
    let scene = scene::open(board::scene_region());
    let (flash_bytes, static_bytes) = board::sizes();
    ports.out.report(&Report::Ready(Ready {
        scene_bytes: scene.as_ref().map_or(0, CompactScene::byte_len),
        effects: scene.as_ref().map_or(0, |scene| scene.effects().bits()),
        linked: scene::EFFECTS,
        fault: scene.as_ref().err().copied().unwrap_or(0),
        flash_bytes,
        static_bytes,
        picture_bytes: picture_bytes as u32,
    }));
    say!(info, "ready");
    scene
}

#[entry]
fn main() -> ! {
    static mut PORTS: MaybeUninit<Ports> = MaybeUninit::uninit();
    static mut MEMORY: Memory = Memory {
        pixels: [Pixel::NONE; TILE_PIXELS],
        places: [Place::NONE; MOST_TILES],
        workspace: Workspace::new(),
        #[cfg(feature = "dispersion")]
        spectrum: [NO_SAMPLE; SPECTRUM],
    };
    let Some(ports) = set_up(PORTS) else { halt() };
    let scene = open(
        ports,
        size_of_val(&MEMORY.pixels) + size_of_val(&MEMORY.places),
    );
    run(scene, ports, MEMORY)
}

/// Waits for ever: the board cannot be used.
fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
