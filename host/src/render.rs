//! STUB for the command: the background as each wall sees it.

use crate::cave::{Cave, Eye, WallError};
use crate::picture::{Picture, PictureError};
use glam::{DVec3, Vec3};
use shisen_core::Simd;
use shisen_core::frame::Statistics;
use shisen_core::scene::Scene;
use thiserror::Error;

/// How to render.
#[derive(Debug, Clone)]
pub struct Options {
    /// Reflections and refractions one after another.
    pub depth: u8,
    /// Samples a pixel.
    pub samples: u16,
    /// Threads, 1 or more.
    pub threads: usize,
    /// Pixels along a tile's side.
    pub tile: u32,
    /// Instruction set.
    pub simd: Simd,
}

/// A wall as one eye sees it.
#[derive(Debug, Clone)]
pub struct WallPicture {
    /// Index into the walls.
    pub wall: usize,
    /// Whose picture it is.
    pub eye: Eye,
    /// The picture.
    pub picture: Picture,
}

/// All walls, all eyes.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Eye by eye, wall by wall.
    pub pictures: Vec<WallPicture>,
    /// What it took.
    pub statistics: Statistics,
    /// Time it took.
    pub seconds: f64,
}

impl Frame {
    /// Of all pixels.
    pub fn hash(&self) -> u64 {
        self.pictures.iter().fold(0, |hash, p| {
            hash.rotate_left(7) ^ p.picture.hash()
        })
    }
}

/// Why a frame cannot be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// An eye that does not see a wall.
    #[error(transparent)]
    Wall(#[from] WallError),
    /// A wall with too many pixels.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Renders.
///
/// # Errors
/// See [`RenderError`].
pub fn cave<const W: usize>(
    scene: &Scene<'_, W>,
    cave: &Cave,
    eyes: &[(Eye, DVec3)],
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError> {
    let start = std::time::Instant::now();
    let mut statistics = Statistics::default();
    let mut pictures = Vec::new();
    let total = eyes.len() * cave.walls.len();
    for &(eye, position) in eyes {
        for (wall, shape) in cave.walls.iter().enumerate() {
            let view = shape.view_from(position)?;
            let mut picture = Picture::new(view.columns, view.rows)?;
            for y in 0..view.rows {
                for x in 0..view.columns {
                    let d = Vec3::from(view.first_pixel)
                        + x as f32 * Vec3::from(view.column_step)
                        + y as f32 * Vec3::from(view.row_step);
                    let up = d.normalize().y;
                    let b = scene.background();
                    let end = Vec3::from(if up > 0.0 { b.zenith } else { b.nadir });
                    let c = Vec3::from(b.horizon).lerp(end, up.abs());
                    picture.set_pixel(x, y, [c.x, c.y, c.z, 1.0]);
                }
            }
            statistics.primary += u64::from(view.columns) * u64::from(view.rows);
            pictures.push(WallPicture { wall, eye, picture });
            progress(pictures.len(), total);
        }
    }
    statistics.primary *= u64::from(options.samples);
    Ok(Frame {
        pictures,
        statistics,
        seconds: start.elapsed().as_secs_f64(),
    })
}
