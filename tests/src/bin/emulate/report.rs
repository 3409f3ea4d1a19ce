//! What the emulator's command line prints.

use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::output::picture_files::hexadecimal;
use shisen_core::scene::EffectSet;
use shisen_tests::firmware::{Image, ShownFrame, Watched};
use shisen_tracker::estimate::State;
use shisen_tracker::link::display::Subject;
use std::fmt;

#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FrameReport {
    number: u32,
    kind: &'static str,
    /// State of the gaze; null without one.
    state: Option<&'static str>,
    /// How far the visual field is widened, radians.
    widen: f32,
    /// Hash of its pixels on the board.
    hash: String,
    /// Hash of the same frame on the host.
    host_hash: String,
    tiles_whole: u32,
    /// Tiles that the budget did not finish.
    tiles_given_up: u32,
    /// Left because the viewer looked elsewhere: its first tiles are compared.
    cut_short: bool,
    steps: u64,
    primary_rays: u64,
    rays: u64,
    instructions: u64,
    /// Before the first tile.
    preparation_instructions: u32,
    /// From the last byte of a new gaze to the first tile.
    latency_instructions: Option<u32>,
    /// The part of it in which the frame before was finished.
    waiting_instructions: Option<u32>,
    /// From the last byte until the tile was sent.
    sent_instructions: Option<u32>,
}

impl FrameReport {
    pub(crate) fn new(frame: &ShownFrame, host_hash: u64) -> Self {
        let start = &frame.start;
        let done = frame.done;
        let latency = done.filter(|done| done.latency > 0);
        let state = start
            .state
            .and_then(|place| State::ALL.get(usize::from(place)));
        Self {
            number: start.number,
            kind: match start.subject {
                Subject::Screens => "walls",
                Subject::Capture { .. } => "dome master",
            },
            state: state.map(|state| state.name()),
            widen: start.widen,
            hash: hexadecimal(frame.hash()),
            host_hash: hexadecimal(host_hash),
            tiles_whole: done.map_or(0, |done| done.whole),
            tiles_given_up: done.map_or(0, |done| done.given_up),
            cut_short: done.is_some_and(|done| done.cut_short),
            steps: done.map_or(0, |done| done.steps),
            primary_rays: done.map_or(0, |done| done.primary),
            rays: done.map_or(0, |done| done.rays),
            instructions: done.map_or(0, |done| done.instructions),
            preparation_instructions: done.map_or(0, |done| done.preparation),
            latency_instructions: latency.map(|done| done.latency),
            waiting_instructions: latency.map(|done| done.age),
            sent_instructions: latency.map(|done| done.sent),
        }
    }

    pub(crate) fn is_equal(&self) -> bool {
        self.hash == self.host_hash
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct SliceReport {
    frame: u32,
    instructions: u32,
    steps: u32,
    ended_tile: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct TrackerReport {
    records: u32,
    dropped_bytes: u32,
    overrun_bytes: u32,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Report {
    image: String,
    scene: String,
    /// Effects that the scene asks for.
    effects: Vec<&'static str>,
    scene_bytes: u32,
    flash_bytes: u32,
    /// Static memory without room for pixels and the order of tiles.
    ram_bytes: u32,
    /// That room.
    picture_bytes: u32,
    stack_bytes: Option<u32>,
    /// Hash of the last frame on the board.
    frame_hash: String,
    /// Hash of the last frame on the host.
    host_frame_hash: String,
    /// Whether all frames are the host's.
    equal: bool,
    /// Mean of all frames of the screens, shading included.
    instructions_per_primary_ray: Option<f64>,
    /// Decoding and estimating; null without a record.
    instructions_per_record: Option<f64>,
    /// The longest from the last byte of a new gaze to the first tile.
    latency_instructions: Option<u32>,
    /// The longest part of one once the frame before was over.
    gaze_to_tile_instructions: Option<u32>,
    /// The longest of frames before which one was cut short.
    restart_latency_instructions: Option<u32>,
    tracker: Option<TrackerReport>,
    frames: Vec<FrameReport>,
    slices: Vec<SliceReport>,
    log: Vec<String>,
    /// Paths.
    images: Vec<String>,
}

impl Report {
    pub(crate) fn new(
        image: &Image,
        scene: String,
        watched: &Watched,
        frames: Vec<FrameReport>,
        images: Vec<String>,
    ) -> Self {
        let ready = &watched.ready;
        let ratio = |sum: u64, count: u64| (count > 0).then(|| sum as f64 / count as f64);
        let walls = || frames.iter().filter(|frame| frame.kind == "walls");
        let primary = walls().map(|frame| frame.primary_rays).sum();
        let instructions = walls().map(|frame| frame.instructions).sum();
        let last = frames.last();
        let hash = |of: fn(&FrameReport) -> &String| last.map(of).cloned().unwrap_or_default();
        Self {
            image: image.path().display().to_string(),
            scene,
            effects: EffectSet::from_bits_truncate(ready.effects)
                .names()
                .collect(),
            scene_bytes: ready.scene_bytes,
            flash_bytes: ready.flash_bytes,
            ram_bytes: ready.static_bytes.saturating_sub(ready.picture_bytes),
            picture_bytes: ready.picture_bytes,
            stack_bytes: watched.tracker.map(|tracker| tracker.stack_bytes),
            frame_hash: hash(|frame| &frame.hash),
            host_frame_hash: hash(|frame| &frame.host_hash),
            equal: frames.iter().all(FrameReport::is_equal),
            instructions_per_primary_ray: ratio(instructions, primary),
            instructions_per_record: watched
                .tracker
                .and_then(|tracker| ratio(tracker.instructions, tracker.records.into())),
            latency_instructions: walls().filter_map(|frame| frame.latency_instructions).max(),
            gaze_to_tile_instructions: walls()
                .filter_map(|frame| Some(frame.latency_instructions? - frame.waiting_instructions?))
                .max(),
            restart_latency_instructions: restarted(&frames).max(),
            tracker: watched.tracker.map(|tracker| TrackerReport {
                records: tracker.records,
                dropped_bytes: tracker.dropped,
                overrun_bytes: tracker.overrun,
            }),
            slices: watched
                .frames
                .iter()
                .flat_map(|frame| &frame.slices)
                .map(|slice| SliceReport {
                    frame: slice.frame,
                    instructions: slice.instructions,
                    steps: slice.steps,
                    ended_tile: slice.ended_tile,
                })
                .collect(),
            log: watched.log.clone(),
            frames,
            images,
        }
    }
}

/// Instructions from the last byte of a new gaze to the first tile, of the frames that
/// were begun before the one before was finished.
fn restarted(frames: &[FrameReport]) -> impl Iterator<Item = u32> {
    let pairs = frames.iter().zip(frames.iter().skip(1));
    pairs
        .filter(|(before, after)| before.cut_short && after.number == before.number + 1)
        .filter_map(|(_, after)| after.latency_instructions)
}

impl fmt::Display for Report {
    // Longer than 80 lines: a line of the report after another.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "scene {}, {} bytes; {} bytes of flash, {} of static memory and {} for pictures, {} of \
             stack",
            self.scene,
            self.scene_bytes,
            self.flash_bytes,
            self.ram_bytes,
            self.picture_bytes,
            self.stack_bytes.unwrap_or(0)
        )?;
        writeln!(
            f,
            "frame  what         gaze            tiles  given up      steps  instructions  hash"
        )?;
        for frame in &self.frames {
            let FrameReport {
                number,
                kind,
                tiles_whole,
                tiles_given_up,
                steps,
                instructions,
                hash,
                ..
            } = frame;
            let gaze = frame.state.unwrap_or("not followed");
            let verdict = match (frame.is_equal(), frame.cut_short) {
                (true, false) => "as the host's",
                (true, true) => "as the host's, cut short: the viewer looks elsewhere",
                (false, _) => "NOT THE HOST'S",
            };
            writeln!(
                f,
                "{number:>5}  {kind:<11}  {gaze:<14}  {tiles_whole:>5}  {tiles_given_up:>8}  \
                 {steps:>9}  {instructions:>12}  {hash} {verdict}"
            )?;
        }
        if let Some(instructions) = self.instructions_per_primary_ray {
            let what = "instructions a primary ray, shading included";
            writeln!(f, "{instructions:.0} {what}")?;
        }
        if let Some(tracker) = &self.tracker {
            let (records, each) = (tracker.records, self.instructions_per_record.unwrap_or(0.0));
            let (dropped, overrun) = (tracker.dropped_bytes, tracker.overrun_bytes);
            writeln!(
                f,
                "tracker: {records} records of {each:.0} instructions, {dropped} bytes dropped, \
                 {overrun} overrun"
            )?;
        }
        for (instructions, what) in [
            (
                self.latency_instructions,
                "from the last byte of a new gaze to the first tile",
            ),
            (
                self.gaze_to_tile_instructions,
                "of these once the frame before was over",
            ),
            (
                self.restart_latency_instructions,
                "where a frame was cut short for it",
            ),
        ] {
            if let Some(instructions) = instructions {
                let ms = f64::from(instructions) / 400e3;
                writeln!(
                    f,
                    "{what}: {instructions} instructions at most, {ms:.2} ms at 400 MHz"
                )?;
            }
        }
        if let Some(slowest) = self.slices.iter().max_by_key(|slice| slice.instructions) {
            let (instructions, steps) = (slowest.instructions, slowest.steps);
            let all = format!("{} slices", self.slices.len());
            writeln!(
                f,
                "{all}, the longest of {instructions} instructions for {steps} steps"
            )?;
        }
        for line in &self.log {
            writeln!(f, "log: {line}")?;
        }
        write!(f, "pictures: {}", self.images.join(", "))
    }
}
