//! What `shisen cave` prints.

use serde::Serialize;
use shisen_core::frame::Statistics;
use std::fmt;

/// A frame: what it took and where it is.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// Of tracing alone.
    pub(super) seconds: f64,
    /// By kind.
    pub(super) rays: Rays,
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
    /// As given.
    #[serde(skip)]
    pub(super) folder: String,
    /// How many.
    #[serde(skip)]
    pub(super) walls: usize,
    /// How many.
    #[serde(skip)]
    pub(super) eyes: usize,
}

/// How many rays of each kind were traced.
#[derive(Debug, Serialize)]
pub(super) struct Rays {
    primary: u64,
    reflected: u64,
    refracted: u64,
    shadow: u64,
}

impl From<Statistics> for Rays {
    fn from(statistics: Statistics) -> Self {
        let Statistics {
            primary,
            reflected,
            refracted,
            shadow,
            ..
        } = statistics;
        Self {
            primary,
            reflected,
            refracted,
            shadow,
        }
    }
}

/// Files, by their paths: the folder as given, and their names.
#[derive(Debug, Serialize)]
pub(super) struct Written {
    /// One a wall and eye.
    pub(super) images: Vec<Image>,
    /// The same pictures, linear; empty where nobody asked for them.
    pub(super) exr: Vec<String>,
    /// The walls of one eye, unfolded.
    pub(super) cave: String,
    /// What that eye sees of them.
    pub(super) viewer: String,
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

/// A hash as reports show it: 64 bits are more than a JSON number holds.
pub(super) fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "scene {}", self.scene)?;
        if let Some(mesh) = &self.mesh {
            write!(f, " of {mesh}")?;
        }
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let Self {
            walls,
            eyes,
            seconds,
            threads,
            simd,
            folder,
            ..
        } = self;
        writeln!(
            f,
            ": {walls} wall{}, {eyes} eye{}, traced in {seconds:.3} s on {threads} thread{} ({simd})",
            plural(*walls),
            plural(*eyes),
            plural(*threads),
        )?;
        let Rays {
            primary,
            reflected,
            refracted,
            shadow,
        } = self.rays;
        writeln!(
            f,
            "rays: {primary} primary, {reflected} reflected, {refracted} refracted, {shadow} shadow"
        )?;
        write!(
            f,
            "pictures in {folder}: {} of single walls, cave.png, viewer.png",
            self.written.images.len() + self.written.exr.len()
        )
    }
}
