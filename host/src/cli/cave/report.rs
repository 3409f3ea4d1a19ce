//! The report of `shisen cave`.

use crate::cli::arguments::filling;
use crate::cli::arguments::source::Shown;
use crate::cli::arguments::tracing::TracingReport;
use crate::cli::output::ray_counts::RayCounts;
use crate::cli::prelude::*;
use crate::show::lod::Coverage;

/// A frame.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Time to trace.
    pub(super) seconds: f64,
    /// Rays by kind.
    pub(super) rays: RayCounts,
    /// Tree nodes visited and primitives tested.
    pub(super) steps: u64,
    /// Most stack entries in use.
    pub(super) deepest_stack: u32,
    /// Hash of all pixels, 16 hexadecimal digits.
    pub(super) frame_hash: String,
    #[serde(flatten)]
    pub(super) written: Written,
    #[serde(flatten)]
    pub(super) traced: TracingReport,
    /// Pixels along each side of a wall whose file does not say.
    pub(super) size: u32,
    #[serde(flatten)]
    pub(super) shown: Shown,
    /// What follows the gaze; null without --lod.
    pub(super) lod: Option<Lod>,
    #[serde(skip)]
    pub(super) folder: String,
    /// Numbers of walls and domes.
    #[serde(skip)]
    pub(super) screens: [usize; 3],
    #[serde(skip)]
    pub(super) eyes: usize,
}

/// The files of a frame.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(in crate::cli) struct Written {
    /// Pictures of walls and domes, one for each eye.
    pub(in crate::cli) images: Vec<Image>,
    /// Files of the same pictures in linear colours; empty without --exr.
    pub(in crate::cli) exr: Vec<String>,
    /// File of the unfolded walls of one eye.
    pub(in crate::cli) cave: String,
    /// File of what that eye sees of them.
    pub(in crate::cli) viewer: String,
    /// Both eyes for a display of one picture; only with --stereo.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) stereo: Option<StereoReport>,
    /// File of the level of each pixel; only with --lod.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) levels: Option<String>,
    /// File of the faces that each pixel sees; only with --lod.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) polygons: Option<String>,
    /// File of the difference from full tracing; only with --lod.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) difference: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct StereoReport {
    /// sequential, side-by-side, top-bottom or anaglyph.
    pub(in crate::cli) format: &'static str,
    /// The eyes, the first one first.
    pub(in crate::cli) eye_order: [&'static str; 2],
    /// Files of the unfolded walls, then of what the eyes see; one an eye if sequential.
    pub(in crate::cli) images: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Lod {
    /// paper, paper-ellipse or foveated.
    pub(super) mode: &'static str,
    /// Faces of each mesh at each of its levels, the finest first.
    pub(super) faces: Vec<Vec<u32>>,
    /// The visual field on each wall, in the order of the images.
    pub(super) field: Vec<Field>,
    /// What shows outside the field.
    pub(super) fill: Fill,
    /// Time to trace the same frame in full.
    pub(super) full_seconds: f64,
    /// Steps of full tracing.
    pub(super) full_steps: u64,
    /// Rays of full tracing.
    pub(super) full_rays: RayCounts,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Fill {
    /// Source of the fill.
    pub(super) mode: filling::Fill,
    /// Pixels outside the visual field.
    pub(super) outside_pixels: u64,
    /// Their difference from full tracing, root mean square, of 255 codes; null without any.
    pub(super) outside_rms: Option<f64>,
    /// The same, decibels; null without a difference.
    pub(super) outside_psnr: Option<f64>,
    /// Captured surroundings, or null. Their time, rays and steps are part of the frame's.
    pub(super) capture: Option<Captured>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Captured {
    /// Pixels along each side of a hemisphere.
    pub(super) size: u32,
    /// Time to capture.
    pub(super) seconds: f64,
    /// Rays by kind.
    pub(super) rays: RayCounts,
    /// Steps taken.
    pub(super) steps: u64,
    /// Files of the hemispheres.
    pub(super) images: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Field {
    /// Name of the wall or dome.
    pub(super) wall: String,
    /// left, right or centre.
    pub(super) eye: &'static str,
    #[serde(flatten)]
    pub(super) coverage: Coverage,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Image {
    /// Name of the wall or dome.
    pub(in crate::cli) wall: String,
    /// left, right or centre.
    pub(in crate::cli) eye: &'static str,
    /// File of the picture.
    pub(in crate::cli) path: String,
    /// Hash of the linear pixels, 16 hexadecimal digits.
    pub(in crate::cli) hash: String,
    /// Its rays by kind, without those of a capture.
    pub(in crate::cli) rays: RayCounts,
}

/// Frames that followed a tracker.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct TrackedFrames {
    /// SPEC of the tracker.
    pub(super) tracker: String,
    /// Frames shown per second.
    pub(super) hz: u64,
    /// Frames.
    pub(super) frames: Vec<TrackedFrame>,
    /// Time to trace all frames.
    pub(super) seconds: f64,
    /// Threads that traced.
    pub(super) threads: usize,
    /// Pixels along each side of a wall whose file does not say.
    pub(super) size: u32,
    /// The scene's letter or name, or the path as given.
    pub(super) scene: String,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TrackedFrame {
    /// Number of the frame, from 0.
    pub(super) frame: u64,
    /// When the frame is shown, microseconds since the start.
    pub(super) shown_us: u64,
    /// The head in the room.
    pub(super) head: Head,
    /// Direction of the gaze.
    pub(super) gaze: [f32; 3],
    /// How far the gaze is known: fresh, hold, widened, head direction or full quality.
    pub(super) state: &'static str,
    /// Angle by which the visual field is wider, radians.
    pub(super) widen: f32,
    /// Whether the eyes are closed.
    pub(super) blink: bool,
    /// Age of the gaze, microseconds, or null.
    pub(super) gaze_age_us: Option<u64>,
    /// Hash of all pixels, 16 hexadecimal digits.
    pub(super) frame_hash: String,
    /// Files of the pictures.
    pub(super) images: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Head {
    /// Position, metres.
    pub(super) position: [f32; 3],
    /// Orientation x, y, z, w.
    pub(super) orientation: [f32; 4],
}

impl fmt::Display for TrackedFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for one in &self.frames {
            let (number, [x, y, z], hash) = (one.frame, one.gaze, &one.frame_hash);
            let state = one.state;
            write!(f, "frame {number}: gaze {x:.4} {y:.4} {z:.4}, ")?;
            writeln!(f, "{state}, {hash}")?;
        }
        let count = counted(self.frames.len() as u64, "frame");
        let (scene, tracker, hz) = (&self.scene, &self.tracker, self.hz);
        write!(f, "{count} of scene {scene} along {tracker} at {hz} Hz, ")?;
        write!(f, "traced in {:.3} s", self.seconds)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.shown)?;
        f.write_str(":")?;
        for (count, what) in self.screens.into_iter().zip(["wall", "dome", "cylinder"]) {
            if count > 0 {
                write!(f, " {},", counted(count as u64, what))?;
            }
        }
        let eyes = counted(self.eyes as u64, "eye");
        let threads = counted(self.traced.threads as u64, "thread");
        let (seconds, simd) = (self.seconds, self.traced.simd);
        writeln!(f, " {eyes}, traced in {seconds:.3} s on {threads} ({simd})")?;
        writeln!(f, "rays: {}", self.rays)?;
        if let Some(lod) = &self.lod {
            let percent = |part: u64, all: u64| 100.0 * part as f64 / all.max(1) as f64;
            let steps = percent(self.steps, lod.full_steps);
            let rays = percent(self.rays.all(), lod.full_rays.all());
            write!(
                f,
                "level of detail ({}): {steps:.0} % of the steps ",
                lod.mode
            )?;
            writeln!(f, "of full tracing, {rays:.0} % of its rays")?;
        }
        let fill = self.lod.as_ref().map(|lod| &lod.fill);
        if let Some((fill, error)) = fill.and_then(|fill| Some((fill, fill.outside_rms?))) {
            let mode = fill.mode.name();
            write!(f, "outside the field ({mode}) the picture differs ")?;
            write!(f, "from full tracing by {error:.1} of 255 levels (RMS)")?;
            if let Some(capture) = &fill.capture {
                let (ms, steps) = (1e3 * capture.seconds, capture.steps);
                write!(f, ", captured in {ms:.1} ms and {steps} steps")?;
            }
            writeln!(f)?;
        }
        let pictures = self.written.images.len() + self.written.exr.len();
        let folder = &self.folder;
        write!(f, "{pictures} pictures of single screens, ")?;
        write!(f, "cave.png and viewer.png in {folder}")?;
        if self.lod.is_some() {
            f.write_str(", levels.png, polygons.png, difference.png")?;
        }
        if let Some(stereo) = &self.written.stereo {
            write!(f, ", both eyes {}, the left one first", stereo.format)?;
        }
        Ok(())
    }
}
