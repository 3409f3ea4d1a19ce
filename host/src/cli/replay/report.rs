//! The report of `shisen replay`.

use crate::cli::prelude::*;
use crate::record::{RecordedFrame, Setup};

/// Most differences that are listed.
const MOST_LISTED: usize = 20;

/// What a record holds, and what its frames are when they are rendered again.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// The file.
    file: String,
    /// Its sessions: another begins where a key changed scene, detail or fill.
    pub(super) sessions: Vec<Session>,
    /// What decided the frames of --frame, --from and --to where they are not rendered.
    pub(super) frames: Vec<Decided>,
    #[serde(flatten)]
    pub(super) damaged: Damaged,
    /// Frames that were rendered and compared with the record, or null without --verify.
    pub(super) verified: Option<Verified>,
    /// Frames that were rendered by two code paths, or null without --against.
    pub(super) against: Option<Against>,
    /// Frames as they would have been, or null without --what-if.
    pub(super) what_if: Option<Changed>,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Damaged {
    /// Frames that are not what was written.
    #[serde(rename = "damaged_frames")]
    pub(super) frames: Vec<u64>,
    /// Frames before which, or in whose place, something else is not what was written: a session, a
    /// tracker's bytes, the end.
    #[serde(rename = "damaged_before_frames")]
    pub(super) before: Vec<u64>,
    /// Frames that build on a damaged one, and are not rendered again.
    pub(super) baseless_frames: usize,
    /// Whether what comes behind cannot be read.
    pub(super) rest_is_lost: bool,
    /// Whether the record has no end: the program was stopped.
    pub(super) is_cut_off: bool,
}

impl Damaged {
    /// Returns whether anything is not what was written.
    pub(super) const fn is_altered(&self) -> bool {
        !self.frames.is_empty() || !self.before.is_empty()
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Session {
    /// The version that recorded it.
    program: String,
    /// The arguments of the run.
    arguments: Vec<String>,
    /// The scene.
    scene: String,
    /// The hash of the baked scene.
    scene_hash: String,
    /// The number of the first frame; null without frames.
    first_frame: Option<u64>,
    /// Number of frames.
    frames: usize,
    /// From the first frame shown to the last, seconds.
    seconds: f64,
    /// Pictures of a frame: walls by eyes.
    pictures: usize,
    /// Frames that a budget cut off.
    cut_frames: usize,
    /// Whether a frame builds on those before it, so that a replay begins at the first.
    builds_on_earlier: bool,
}

/// What decided a frame.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Decided {
    /// The frame.
    frame: u64,
    /// When it was shown, since the first: seconds.
    shown: f64,
    /// The head's place in the room, metres.
    head: [f32; 3],
    /// The line of sight in the room.
    forward: [f32; 3],
    /// The place of its quality among all, from 0, the best.
    rung: usize,
    /// Its budget, or null without one.
    steps: Option<u64>,
    /// Tiles that the budget cut off.
    cut_tiles: usize,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Verified {
    /// Frames.
    pub(super) frames: u64,
    /// Frames of the same hashes.
    pub(super) equal: u64,
    /// The first differences, at most twenty.
    pub(super) different: Vec<Difference>,
    /// Time of rendering and hashing, seconds.
    pub(super) seconds: f64,
}

/// A picture that is not the record's.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Difference {
    /// The frame.
    pub(super) frame: u64,
    /// The wall.
    pub(super) wall: String,
    /// The eye.
    pub(super) eye: String,
    /// The first row of pixels of the first row of tiles that differs; null where none does.
    pub(super) row: Option<u32>,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Against {
    /// Frames.
    pub(super) frames: u64,
    /// Frames of the same bits.
    pub(super) equal: u64,
    /// The first pixel that differs, or null.
    pub(super) first: Option<Unequal>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Unequal {
    /// The frame.
    pub(super) frame: u64,
    /// The wall.
    pub(super) wall: String,
    /// The eye.
    pub(super) eye: String,
    /// Column and row.
    pub(super) pixel: [u32; 2],
    /// Red, green, blue and alpha by --device.
    pub(super) one: [f32; 4],
    /// The same by --against.
    pub(super) other: [f32; 4],
}

#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Changed {
    /// Frames.
    pub(super) frames: u64,
    /// Frames of these that their budget cut off: what would have been is whole.
    pub(super) cut_frames: u64,
    /// Mean difference of colours (CIEDE2000, of which about 1 is seen).
    pub(super) mean_difference: f64,
    /// The same, each pixel weighted by how finely the eye sees there.
    pub(super) seen_difference: f64,
    /// The largest of a pixel.
    pub(super) largest: f64,
    /// Steps beside those of the pixels that the frame had.
    pub(super) steps: f64,
}

impl Session {
    pub(super) fn of(setup: &Setup, frames: &[RecordedFrame]) -> Self {
        let ends = frames.first().zip(frames.last());
        Self {
            program: setup.program.clone(),
            arguments: setup.arguments.clone(),
            scene: setup.scene.clone(),
            scene_hash: setup.scene_hash.clone(),
            first_frame: frames.first().map(|frame| frame.number),
            frames: frames.len(),
            seconds: ends.map_or(0.0, |(first, last)| {
                last.shown_us.saturating_sub(first.shown_us) as f64 * 1.0e-6
            }),
            pictures: setup.pictures.len(),
            cut_frames: frames.iter().filter(|frame| !frame.cuts.is_empty()).count(),
            builds_on_earlier: setup.fill == "previous",
        }
    }
}

impl Decided {
    pub(super) fn of(frame: &RecordedFrame) -> Self {
        Self {
            frame: frame.number,
            shown: frame.shown_us as f64 * 1.0e-6,
            head: frame.look.head.position.to_array(),
            forward: frame.look.forward.to_array(),
            rung: frame.decision.rung,
            steps: frame.decision.steps,
            cut_tiles: frame.cuts.len(),
        }
    }
}

impl fmt::Display for Decided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([x, y, z], [right, up, back]) = (self.head, self.forward);
        write!(
            f,
            "\n  frame {} at {:.3} s: head at {x:.3},{y:.3},{z:.3} m, looks along \
             {right:.3},{up:.3},{back:.3}, quality {} (0 is the best)",
            self.frame, self.shown, self.rung
        )?;
        match (self.steps, self.cut_tiles) {
            (None, _) => Ok(()),
            (Some(steps), 0) => write!(f, ", within {steps} steps"),
            (Some(steps), cut) => write!(f, ", {cut} tiles cut off after {steps} steps"),
        }
    }
}

impl Verified {
    pub(super) fn differ(&mut self, difference: Difference) {
        if self.different.len() < MOST_LISTED {
            self.different.push(difference);
        }
    }
}

impl Report {
    pub(super) fn new(file: &Path, damaged: Damaged) -> Self {
        Self {
            file: file.display().to_string(),
            sessions: Vec::new(),
            frames: Vec::new(),
            damaged,
            verified: None,
            against: None,
            what_if: None,
        }
    }

    /// Returns what is wrong with the record or its frames.
    pub(super) fn fault(&self) -> Option<String> {
        if let Some(frame) = self.damaged.frames.first() {
            return Some(format!(
                "{}: frame {frame} is not what was recorded",
                self.file
            ));
        }
        if let Some(frame) = self.damaged.before.first() {
            return Some(format!(
                "{}: what comes before frame {frame}, or is in its place, is not what was recorded",
                self.file
            ));
        }
        let verified = self.verified.as_ref();
        let different = verified.map_or(0, |verified| verified.frames - verified.equal);
        let against = self.against.as_ref();
        let apart = against.map_or(0, |against| against.frames - against.equal);
        match (different, apart) {
            (0, 0) => None,
            (0, _) => Some(format!("{apart} frames differ by the two paths")),
            _ => Some(format!("{different} frames are not those of the record")),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file)?;
        for session in &self.sessions {
            let first = session.first_frame.unwrap_or(0);
            write!(
                f,
                "\n  {} frames from {first} of scene {} ({}), {} pictures, {:.2} s",
                session.frames,
                session.scene,
                session.scene_hash,
                session.pictures,
                session.seconds
            )?;
            if session.cut_frames > 0 {
                write!(f, "; {} cut off by their budget", session.cut_frames)?;
            }
            if session.builds_on_earlier {
                f.write_str("; each builds on those before it")?;
            }
            let (program, words) = (&session.program, session.arguments.join(" "));
            write!(f, "\n    by {program}: {words}")?;
        }
        for frame in &self.frames {
            frame.fmt(f)?;
        }
        for frame in &self.damaged.frames {
            write!(f, "\nframe {frame} is not what was written")?;
        }
        for frame in &self.damaged.before {
            write!(
                f,
                "\nwhat comes before frame {frame}, or is in its place, is not what was written"
            )?;
        }
        if self.damaged.baseless_frames > 0 {
            let count = self.damaged.baseless_frames;
            write!(
                f,
                "\n{count} frames build on a damaged one: they are not rendered again"
            )?;
        }
        if self.damaged.rest_is_lost {
            f.write_str("\nwhat comes behind cannot be read")?;
        }
        if self.damaged.is_cut_off {
            f.write_str("\nthe record was cut off: the program was stopped before its end")?;
        }
        if let Some(verified) = &self.verified {
            let Verified {
                frames,
                equal,
                different,
                seconds,
            } = verified;
            write!(f, "\n{equal} of {frames} frames are the same, bit for bit")?;
            write!(
                f,
                " ({:.1} frames a second)",
                *frames as f64 / seconds.max(1.0e-9)
            )?;
            for one in different {
                write!(f, "\n  frame {}, {}, {} eye", one.frame, one.wall, one.eye)?;
                if let Some(row) = one.row {
                    write!(f, ": from row {row} of pixels on")?;
                }
            }
        }
        if let Some(against) = &self.against {
            let (equal, frames) = (against.equal, against.frames);
            write!(f, "\n{equal} of {frames} frames are the same by both paths")?;
            if let Some(first) = &against.first {
                let [x, y] = first.pixel;
                write!(
                    f,
                    "; the first that is not: frame {}, {}, {} eye, pixel {x}, {y}: {:?}, {:?}",
                    first.frame, first.wall, first.eye, first.one, first.other
                )?;
            }
        }
        if let Some(changed) = &self.what_if {
            write!(
                f,
                "\n{} frames as they would have been: {:.2} times the steps; colours differ by {:.2} \
                 (ΔE00) in the mean, by {:.2} where the viewer looked, at most by {:.2}",
                changed.frames,
                changed.steps,
                changed.mean_difference,
                changed.seen_difference,
                changed.largest
            )?;
            if changed.cut_frames > 0 {
                write!(
                    f,
                    "; {} of the frames were cut off by their budget",
                    changed.cut_frames
                )?;
            }
        }
        Ok(())
    }
}
