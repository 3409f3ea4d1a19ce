//! Runs the display controller's firmware in its emulator and compares it with
//! the host: the paper's scenes along both of its gazes, a dome master, a prism,
//! and faults around a controller. `tests/firmware/run` builds the
//! images and starts this.
//!
//! ```text
//! cargo run -p shisen-tests --bin firmware -- \
//!     LIMITS MEASURED IMAGE IMAGE-WITH-DISPERSION [WORD...]
//! ```
//!
//! LIMITS is `tests/firmware/limits.toml`; measured values are added to the file
//! MEASURED, a name and a number in each line. With WORDs only those checks run whose
//! names contain one of them.

/// Returns an error from the function if a condition does not hold.
macro_rules! ensure {
    ($holds:expr, $($what:tt)+) => {
        if $holds {
        } else {
            return Err(format!($($what)+).into());
        }
    };
}

mod latency;
mod limits;
mod poses;
mod time;

use glam::{Quat, Vec3};
use limits::{Limits, Measured};
use shisen::bake::{Baked, Layout};
use shisen::cave::Wall;
use shisen::picture::Picture;
use shisen::render::frame_hash;
use shisen::scene::Scene;
use shisen::scene::builtin::{PaperScene, paper_scene, prism};
use shisen::scene::quadruped::quadruped;
use shisen::tracker::{Spec, TrackerKind, simulated};
use shisen_core::frame::FlatScreen;
use shisen_tests::firmware::{Image, Run, TrackerBytes, Watched, reference, watch};
use shisen_tests::meshes::cow;
use shisen_tests::scenes::{levels, three_walls};
use shisen_tracker::link::Encoder;
use shisen_tracker::link::display::Rendering;
use shisen_tracker::mock::{Chunk, Source, Wire};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::{Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::cell::Cell;
use std::path::Path;
use std::process::ExitCode;
use time::Slices;

/// Pixels a side of the walls.
const SIDE: u32 = 64;
/// Default time between a tracker's samples.
const STEP: Micros = Micros(2_000);

type Wrong = Box<dyn std::error::Error>;

type Check = fn(&Bench) -> Result<String, Wrong>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [limits, measured, plain, dispersive, words @ ..] = arguments.as_slice() else {
        eprintln!("give: LIMITS MEASURED and two images, without dispersion and with");
        return ExitCode::from(2);
    };
    let bench = match Bench::new(limits, measured, [plain, dispersive]) {
        Ok(bench) => bench,
        Err(wrong) => {
            eprintln!("{wrong}");
            return ExitCode::FAILURE;
        }
    };
    let checks: [(&str, Check); 16] = [
        ("scenes A to D, both gazes", Bench::paper_scenes),
        ("a dome master", Bench::dome_master),
        ("a prism by wavelengths", Bench::by_wavelengths),
        ("instances that move", Bench::poses),
        ("budgets and slices", Bench::budgets),
        ("two eyes that follow a moving viewer", Bench::moving_viewer),
        ("a scene cut off or damaged", Bench::damaged_scenes),
        ("a tracker of noise", Bench::noise),
        ("more bytes than there is room for", Bench::flood),
        (
            "a head where screens are not seen from",
            Bench::behind_a_wall,
        ),
        ("gazes that are none", Bench::no_gazes),
        ("scenes made to take long", Bench::bounded_time),
        ("latency", Bench::latency),
        ("a viewer who looks elsewhere", Bench::restarts),
        ("time of all slices", |bench| Ok(bench.slices())),
        ("memory", Bench::note_memory),
    ];
    let wanted =
        |what: &str| words.is_empty() || words.iter().any(|word| what.contains(word.as_str()));
    let (mut passed, mut failed) = (0, 0);
    for (what, check) in checks.into_iter().filter(|(what, _)| wanted(what)) {
        match check(&bench) {
            Ok(found) => {
                passed += 1;
                println!("{what}: {found}");
            }
            Err(wrong) => {
                failed += 1;
                println!("{what}: FAILED: {wrong}");
            }
        }
    }
    println!("{passed} passed, {failed} failed");
    if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn bake(scene: &Scene) -> Baked<4> {
    let levels = levels(Layout::Compact.polygon_levels());
    Baked::with_levels(scene, &levels).expect("a scene that can be baked")
}

fn paper(which: PaperScene) -> Baked<4> {
    let mesh = cow().unwrap_or_else(quadruped);
    bake(&paper_scene(which, mesh).expect("a scene"))
}

/// Returns a controller's default settings.
const RENDERING: Rendering = Rendering {
    budget: u64::MAX,
    slice: 10_000,
    depth: 3,
    wavelengths: 1,
    lod: true,
    eye_distance: 0.0,
    display_delay: 20_000,
    restart_angle: 0.0,
};

/// Returns the bytes of a viewer who looks one way, from one place.
fn looking(place: Vec3, turn: Quat, gaze: Vec3) -> TrackerBytes {
    let mut encoder = Encoder::new();
    sent(STEP, move |time| {
        record(&mut encoder, time, place, turn, gaze)
    })
}

fn record(encoder: &mut Encoder, time: Micros, place: Vec3, turn: Quat, gaze: Vec3) -> Vec<u8> {
    let mut sample = Sample::arrived(time);
    sample.device_time = Some(DeviceTime::unwrapped(time.0));
    sample.head.position = Some(Reading::tracked(place));
    sample.head.orientation = Some(Reading::tracked(turn));
    // A gaze that never changes by a bit counts as stuck.
    let sway = 1e-4 * ((time.0 / STEP.0 % 7) as f32 - 3.0);
    let gaze = (gaze + Vec3::X * sway).normalize();
    sample.combined.direction = Some(Reading::tracked(gaze));
    encoder.sample(&sample).to_vec()
}

fn ahead() -> TrackerBytes {
    looking(Vec3::ZERO, Quat::IDENTITY, Vec3::NEG_Z)
}

/// Returns the paper's other viewer: the head bowed, and the eyes lower still.
fn down() -> TrackerBytes {
    let bow = 70f32.to_radians();
    let rest = 20f32.to_radians();
    let gaze = Vec3::new(0.0, -rest.sin(), -rest.cos());
    looking(Vec3::ZERO, Quat::from_rotation_x(-bow), gaze)
}

fn mock(spec: &str) -> Result<TrackerBytes, Wrong> {
    let TrackerKind::Mock(spec) = spec.parse::<Spec>()?.kind else {
        return Err("no mock".into());
    };
    Ok(Box::new(Wire::new(simulated(&spec)?, Protocol::Link)))
}

/// Returns pieces of bytes at their times, a step apart.
struct Bytes<F> {
    next: Micros,
    step: Micros,
    send: F,
}

fn sent(step: Micros, send: impl FnMut(Micros) -> Vec<u8> + 'static) -> TrackerBytes {
    let next = Micros(0);
    Box::new(Bytes { next, step, send })
}

impl<F: FnMut(Micros) -> Vec<u8>> Source for Bytes<F> {
    type Item = Chunk;

    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        if self.next > until {
            return None;
        }
        let at = self.next;
        self.next = at.after(self.step);
        Some(Chunk::new(at, &(self.send)(at)))
    }
}

struct Bench {
    plain: Image,
    dispersive: Image,
    screens: Vec<FlatScreen>,
    limits: Limits,
    measured: Measured,
    slices: Slices,
    /// Static memory without the buffers of pictures, bytes.
    ram: Cell<u64>,
    /// Deepest use of the painted stack, bytes.
    stack: Cell<u64>,
}

impl Bench {
    fn new(limits: &str, measured: &str, images: [&String; 2]) -> Result<Self, Wrong> {
        let [plain, dispersive] = images.map(Path::new);
        let walls = three_walls(SIDE).walls;
        Ok(Self {
            plain: Image::open(plain)?,
            dispersive: Image::open(dispersive)?,
            screens: walls.iter().map(Wall::flat_screen).collect(),
            limits: Limits::read(limits)?,
            measured: Measured(measured.to_owned()),
            slices: Slices::default(),
            ram: Cell::default(),
            stack: Cell::default(),
        })
    }

    fn run<'a>(&'a self, scene: &'a [u8], tracker: Option<TrackerBytes>) -> Run<'a> {
        Run {
            image: &self.plain,
            scene,
            screens: &self.screens,
            rendering: RENDERING,
            frames: 2,
            capture: None,
            tracker,
            patience: 60.0,
        }
    }

    /// Runs scene A with this tracker, and checks that its frames are the host's.
    fn scene_a(
        &self,
        tracker: TrackerBytes,
        change: impl FnOnce(&mut Run<'_>),
    ) -> Result<Watched, Wrong> {
        let scene = paper(PaperScene::A);
        let mut run = self.run(scene.as_bytes(), Some(tracker));
        change(&mut run);
        self.same(&scene, run)
    }

    /// Runs a controller, checks that its frames are the host's, and returns its reports.
    fn same(&self, scene: &Baked<4>, run: Run<'_>) -> Result<Watched, Wrong> {
        let (rendering, screens) = (run.rendering, run.screens);
        let plain = run.image == &self.plain;
        let watched = watch(run)?;
        ensure!(watched.ready.fault == 0, "the scene is refused");
        if plain {
            self.memory(&watched);
        }
        ensure!(watched.damaged == 0, "pixels were damaged");
        for frame in &watched.frames {
            self.in_time(frame, rendering.slice)?;
            let host = reference(scene.scene(), screens, &rendering, frame, plain)?;
            ensure!(
                frame.hash() == frame_hash(host.iter().map(Picture::hash)),
                "frame {} is not the host's",
                frame.start.number
            );
            let varied = host.iter().any(|picture| {
                let pixels = picture.core_pixels();
                pixels.windows(2).any(|pair| pair[0] != pair[1])
            });
            let cut_short = frame.done.is_some_and(|done| done.cut_short);
            ensure!(varied || cut_short, "a frame of one colour");
        }
        Ok(watched)
    }

    fn memory(&self, watched: &Watched) {
        let ready = watched.ready;
        self.ram
            .set((ready.static_bytes - ready.picture_bytes).into());
        let stack = watched.tracker.map_or(0, |tracker| tracker.stack_bytes);
        self.stack.set(self.stack.get().max(stack.into()));
    }

    fn note_memory(&self) -> Result<String, Wrong> {
        let (ram, stack) = (self.ram.get(), self.stack.get());
        ensure!(ram > 0 && stack > 0, "nothing was said of memory");
        self.measured.add("ram", ram)?;
        self.measured.add("stack_painted", stack)?;
        Ok(format!(
            "{ram} static bytes without pictures, {stack} of stack painted over"
        ))
    }

    fn paper_scenes(&self) -> Result<String, Wrong> {
        let mut said = Vec::new();
        for which in [PaperScene::A, PaperScene::B, PaperScene::C, PaperScene::D] {
            let scene = paper(which);
            for (gaze, tracker) in [("1", ahead()), ("2", down())] {
                let run = self.run(scene.as_bytes(), Some(tracker));
                let watched = self.same(&scene, run)?;
                let last = watched.frames.last().ok_or("no frame")?;
                ensure!(last.start.state == Some(0), "the gaze is not fresh");
                let looked = if gaze == "1" {
                    Vec3::NEG_Z
                } else {
                    Vec3::NEG_Y
                };
                let along = last.start.forward.dot(looked);
                ensure!(along > 0.999, "looked along {}", last.start.forward);
                let done = last.done.ok_or("a frame without an end")?;
                let rays = done.instructions / done.primary.max(1);
                said.push(format!("{}{gaze} {rays}", which.name()));
            }
        }
        Ok(format!(
            "the host's, bit for bit; instructions a primary ray: {}",
            said.join(", ")
        ))
    }

    fn dome_master(&self) -> Result<String, Wrong> {
        let capture = Some((96, Vec3::new(0.1, 0.2, 0.0)));
        let watched = self.scene_a(ahead(), |run| run.capture = capture)?;
        let last = watched.frames.last().ok_or("no frame")?;
        ensure!(last.pictures.len() == 1, "no dome master came");
        ensure!(last.pictures[0].core_pixels().len() == 96 * 96, "its size");
        Ok("the host's".to_owned())
    }

    fn by_wavelengths(&self) -> Result<String, Wrong> {
        let scene = bake(&prism());
        let mut run = self.run(scene.as_bytes(), None);
        run.image = &self.dispersive;
        run.rendering.wavelengths = 7;
        run.frames = 1;
        let watched = self.same(&scene, run)?;
        // An image without dispersion renders another picture, equal to the host's without it.
        let plain = self.run(scene.as_bytes(), None);
        let plain = self.same(&scene, plain)?;
        ensure!(
            plain.frames[0].hash() != watched.frames[0].hash(),
            "wavelengths change nothing"
        );
        Ok("the host's".to_owned())
    }

    fn budgets(&self) -> Result<String, Wrong> {
        let scene = paper(PaperScene::A);
        for (budget, slice) in [(u64::MAX, 900), (15_000, 1), (1, 100), (0, 10_000)] {
            let mut run = self.run(scene.as_bytes(), Some(ahead()));
            (run.rendering.budget, run.rendering.slice) = (budget, slice);
            run.frames = 1;
            let rendering = run.rendering;
            let watched = watch(run)?;
            let frame = watched.frames.first().ok_or("no frame")?;
            self.in_time(frame, slice)?;
            let host = reference(scene.scene(), &self.screens, &rendering, frame, true)?;
            ensure!(
                frame.hash() == frame_hash(host.iter().map(Picture::hash)),
                "budget {budget}, slice {slice}"
            );
            let done = frame.done.ok_or("a frame without an end")?;
            if budget == 0 {
                logged(&watched, "no steps for a frame")?;
            }
            let ran_out = done.given_up > 0;
            ensure!(ran_out == (budget < 20_000), "tiles given up");
            ensure!(
                done.steps < budget.saturating_add(5_000),
                "more steps than given"
            );
        }
        Ok("the host's, from 0 steps to all, in slices from 1 on".to_owned())
    }

    fn moving_viewer(&self) -> Result<String, Wrong> {
        let scene = paper(PaperScene::B);
        let mut run = self.run(scene.as_bytes(), Some(mock("mock:seed=5&rate=250")?));
        run.rendering.eye_distance = 0.064;
        run.frames = 4;
        let watched = self.same(&scene, run)?;
        let forward = |frame: usize| watched.frames[frame].start.forward;
        ensure!(forward(0) != forward(3), "nothing moved");
        ensure!(watched.frames[0].pictures.len() == 6, "two eyes");
        let tracker = watched.tracker.ok_or("nothing said of the tracker")?;
        ensure!(tracker.records > 10 && tracker.dropped == 0, "records");
        let each = tracker.instructions / u64::from(tracker.records);
        self.measured.add("record", each)?;
        Ok(format!("the host's; {each} instructions a record"))
    }

    fn damaged_scenes(&self) -> Result<String, Wrong> {
        let scene = paper(PaperScene::C);
        let bytes = scene.as_bytes();
        let mut damaged = vec![
            bytes[..bytes.len() / 2].to_vec(),
            Vec::new(),
            vec![0xff; 4096],
        ];
        for at in [0, 5, 100, bytes.len() / 3, bytes.len() - 1] {
            let mut flipped = bytes.to_vec();
            flipped[at] ^= 0x10;
            damaged.push(flipped);
        }
        for (number, bytes) in damaged.iter().enumerate() {
            let watched = watch(self.run(bytes, Some(ahead())));
            let watched = watched.map_err(|error| format!("scene {number}: {error}"))?;
            ensure!(watched.ready.fault != 0, "scene {number} is not refused");
            ensure!(watched.frames.len() == 2, "frames go on");
            logged(&watched, "no scene").map_err(|error| format!("scene {number}: {error}"))?;
            let picture = &watched.frames[0].pictures[0];
            ensure!(
                picture.pixel(0, 0) == Some([1.0, 0.0, 1.0, 1.0]),
                "what shows without a scene"
            );
        }
        let count = damaged.len();
        Ok(format!("{count} refused and logged, frames go on"))
    }

    fn noise(&self) -> Result<String, Wrong> {
        let mut random = shisen_tests::rays::Random::new(7);
        let bytes = sent(STEP, move |_| {
            (0..20).map(|_| random.bits() as u8).collect()
        });
        let watched = self.scene_a(bytes, |_| {})?;
        ensure!(is_everywhere(&watched), "full quality everywhere");
        let tracker = watched.tracker.ok_or("nothing said of the tracker")?;
        ensure!(
            tracker.records == 0 && tracker.dropped > 0,
            "noise is dropped"
        );
        logged(&watched, "tracker: ")?;
        logged(&watched, "no record of the tracker yet")?;
        let dropped = tracker.dropped;
        Ok(format!("{dropped} bytes dropped, full quality everywhere"))
    }

    fn flood(&self) -> Result<String, Wrong> {
        let mut still = ahead();
        let bytes = sent(STEP, move |at| {
            let mut burst = vec![0x55; 200];
            while let Some(chunk) = still.poll(at) {
                burst.extend_from_slice(chunk.bytes());
            }
            burst
        });
        // Slices so long that the line is not read in time.
        let watched = self.scene_a(bytes, |run| run.rendering.slice = 1_000_000)?;
        let tracker = watched.tracker.ok_or("nothing said of the tracker")?;
        ensure!(tracker.overrun > 0, "nothing was lost");
        logged(&watched, "bytes of the tracker found no room")?;
        Ok(format!("{} bytes lost and counted", tracker.overrun))
    }

    fn behind_a_wall(&self) -> Result<String, Wrong> {
        let place = Vec3::new(0.0, 0.0, -4.0);
        let tracker = looking(place, Quat::IDENTITY, Vec3::NEG_Z);
        let watched = self.scene_a(tracker, |_| {})?;
        let mut eyes = watched.frames.iter().map(|frame| frame.start.eyes[0]);
        ensure!(eyes.all(|eye| eye == Vec3::ZERO), "eyes");
        logged(&watched, "not seen")?;
        Ok("the eyes stay where they were".to_owned())
    }

    fn no_gazes(&self) -> Result<String, Wrong> {
        for gaze in [Vec3::splat(f32::NAN), Vec3::ZERO, Vec3::Z, Vec3::X * 1e30] {
            let mut encoder = Encoder::new();
            let bytes = sent(STEP, move |at| {
                let mut sample = Sample::arrived(at);
                sample.device_time = Some(DeviceTime::unwrapped(at.0));
                sample.combined.direction = Some(Reading::tracked(gaze));
                encoder.sample(&sample).to_vec()
            });
            let watched = self.scene_a(bytes, |_| {})?;
            ensure!(is_everywhere(&watched), "{gaze} is taken for a gaze");
        }
        Ok("full quality everywhere".to_owned())
    }
}

/// Returns whether the last frame has full detail everywhere.
fn is_everywhere(watched: &Watched) -> bool {
    let last = watched.frames.last();
    last.is_some_and(|frame| frame.start.widen >= std::f32::consts::PI)
}

fn logged(watched: &Watched, words: &str) -> Result<(), Wrong> {
    let said = watched.log.iter().any(|line| line.contains(words));
    ensure!(said, "its log has no \"{words}\"");
    Ok(())
}
