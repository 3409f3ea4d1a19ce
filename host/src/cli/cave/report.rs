//! What `shisen cave` prints.

use crate::cli::arguments::EffectReport;
use crate::cli::arguments::dispersion::DispersionReport;
use crate::cli::output::counted;
use crate::cli::output::ray_counts::RayCounts;
use serde::Serialize;
use std::fmt;

/// A frame: what it took and where it is.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// Of tracing alone.
    pub(super) seconds: f64,
    /// By kind.
    pub(super) rays: RayCounts,
    /// Tree nodes visited and primitives tested.
    pub(super) steps: u64,
    /// The most traversal stack entries in use.
    pub(super) deepest_stack: u32,
    /// Over all pixels, 16 hexadecimal digits.
    pub(super) frame_hash: String,
    /// The files.
    #[serde(flatten)]
    pub(super) written: Written,
    /// That traced.
    pub(super) threads: usize,
    /// Pixels along a side of walls that do not say themselves.
    pub(super) size: u32,
    /// A letter, or the path as given.
    pub(super) scene: String,
    /// The path as given, or the built-in one's name; none where the scene's
    /// file says.
    pub(super) mesh: Option<String>,
    /// The path taken.
    pub(super) simd: &'static str,
    /// Reflections and refractions followed.
    pub(super) depth: u8,
    /// Rays a pixel.
    pub(super) samples: u16,
    /// Carried out, and asked for.
    #[serde(flatten)]
    pub(super) effects: EffectReport,
    /// Where it is carried out.
    pub(super) dispersion: Option<DispersionReport>,
    /// Where detail follows the gaze.
    pub(super) lod: Option<Lod>,
    /// As given.
    #[serde(skip)]
    pub(super) folder: String,
    /// How many.
    #[serde(skip)]
    pub(super) walls: usize,
    /// How many.
    #[serde(skip)]
    pub(super) domes: usize,
    /// How many.
    #[serde(skip)]
    pub(super) eyes: usize,
}

/// Files, by their paths: the folder as given, and their names.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    /// One a wall or dome and eye.
    pub(super) images: Vec<Image>,
    /// The same pictures, linear; empty where nobody asked for them.
    pub(super) exr: Vec<String>,
    /// The walls of one eye, unfolded.
    pub(super) cave: String,
    /// What that eye sees of them.
    pub(super) viewer: String,
    /// With two eyes for a display of one picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) stereo: Option<StereoReport>,
    /// With a level of detail: that of each pixel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) levels: Option<String>,
    /// The faces that each pixel's rays see.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) polygons: Option<String>,
    /// What differs from full tracing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) difference: Option<String>,
}

/// Pictures of both eyes.
#[derive(Debug, Serialize)]
pub(super) struct StereoReport {
    /// How they are put together.
    pub(super) format: &'static str,
    /// Which comes first.
    pub(super) eye_order: [&'static str; 2],
    /// The walls unfolded, then as the eyes see them: paths, of sequential ones two
    /// each.
    pub(super) images: Vec<String>,
}

/// What a level of detail did.
#[derive(Debug, Serialize)]
pub(super) struct Lod {
    /// `paper` or `paper-ellipse`.
    pub(super) mode: &'static str,
    /// Faces of each mesh on each of its rungs, the finest first; one number
    /// where a mesh has no ladder.
    pub(super) faces: Vec<Vec<u32>>,
    /// Of each wall and eye, in the order of the images.
    pub(super) field: Vec<Field>,
    /// What shows outside it.
    pub(super) fill: Fill,
    /// Of full tracing in the same run.
    pub(super) full_seconds: f64,
    /// Of full tracing.
    pub(super) full_steps: u64,
    /// Of full tracing.
    pub(super) full_rays: RayCounts,
}

/// What shows where the gaze skips rays, and how far it is from what is there.
#[derive(Debug, Serialize)]
pub(super) struct Fill {
    /// `background`, `capture` or `previous`.
    pub(super) mode: &'static str,
    /// Outside the visual field, of all walls and eyes.
    pub(super) outside_pixels: u64,
    /// Codes of 255, root mean square.
    pub(super) outside_rms: Option<f64>,
    /// Decibels.
    pub(super) outside_psnr: Option<f64>,
    /// The surroundings, where they were captured.
    pub(super) capture: Option<Captured>,
}

/// What a capture of the surroundings took, as part of the frame.
#[derive(Debug, Serialize)]
pub(super) struct Captured {
    /// Pixels a side of a hemisphere.
    pub(super) size: u32,
    pub(super) seconds: f64,
    pub(super) rays: RayCounts,
    pub(super) steps: u64,
    /// Of the two hemispheres.
    pub(super) images: Vec<String>,
}

/// What share of a wall's pixels is in which zone, and what they get.
#[derive(Debug, Serialize)]
pub(super) struct Field {
    /// The wall's name.
    pub(super) wall: String,
    /// `left`, `right` or `centre`.
    pub(super) eye: &'static str,
    pub(super) central: f64,
    pub(super) peripheral: f64,
    pub(super) outside: f64,
    pub(super) mean_level: f64,
    pub(super) mean_bounces: f64,
}

/// A wall's picture for one eye.
#[derive(Debug, Serialize)]
pub(super) struct Image {
    /// The wall's name.
    pub(super) wall: String,
    /// `left`, `right` or `centre`.
    pub(super) eye: &'static str,
    /// Its PNG.
    pub(super) path: String,
    /// Over its linear pixels, 16 hexadecimal digits.
    pub(super) hash: String,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "scene {}", self.scene)?;
        if let Some(mesh) = &self.mesh {
            write!(f, " of {mesh}")?;
        }
        let Self {
            walls,
            domes,
            eyes,
            seconds,
            threads,
            simd,
            folder,
            ..
        } = self;
        f.write_str(":")?;
        for (count, what) in [(*walls, "wall"), (*domes, "dome")] {
            if count > 0 {
                write!(f, " {},", counted(count as u64, what))?;
            }
        }
        writeln!(
            f,
            " {}, traced in {seconds:.3} s on {} ({simd})",
            counted(*eyes as u64, "eye"),
            counted(*threads as u64, "thread"),
        )?;
        writeln!(f, "rays: {}", self.rays)?;
        if let Some(lod) = &self.lod {
            writeln!(
                f,
                "level of detail ({}): {:.0} % of the steps of full tracing, {:.0} % of its rays",
                lod.mode,
                100.0 * self.steps as f64 / lod.full_steps.max(1) as f64,
                100.0 * self.rays.all() as f64 / lod.full_rays.all().max(1) as f64,
            )?;
        }
        if let Some((fill, error)) = self.lod.as_ref().and_then(|lod| {
            let error = lod.fill.outside_rms?;
            Some((&lod.fill, error))
        }) {
            write!(
                f,
                "outside the field ({}): {error:.1} of 255 codes from full tracing",
                fill.mode
            )?;
            if let Some(capture) = &fill.capture {
                let ms = 1e3 * capture.seconds;
                write!(f, ", captured in {ms:.1} ms and {} steps", capture.steps)?;
            }
            writeln!(f)?;
        }
        write!(
            f,
            "pictures in {folder}: {} of single screens, cave.png, viewer.png",
            self.written.images.len() + self.written.exr.len()
        )?;
        if self.lod.is_some() {
            f.write_str(", levels.png, polygons.png, difference.png")?;
        }
        if let Some(stereo) = &self.written.stereo {
            write!(f, ", both eyes {}, the left first", stereo.format)?;
        }
        Ok(())
    }
}
