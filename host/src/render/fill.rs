//! Fills pixels that the gaze skips.

use super::{
    Frame, Job, Observer, Options, RenderError, WallPicture, in_full, jobs, share_out, tiles,
    trace, write_back,
};
use crate::picture::Picture;
use glam::{DVec3, Mat3};
use rayon::ThreadPool;
use shisen_core::frame::{
    BLEND, Budget, DomePose, Fill, LevelOfDetail, Pixel, Renderer, Spectrum, Statistics,
    Surroundings, SurroundingsError, Tile, TileJob, View,
};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::f32::consts::PI;
use std::time::Instant;

/// What fills pixels that the gaze skips. At the border of the visual field
/// traced pixels blend into it.
#[derive(Debug, Clone, Copy, Default)]
pub enum Filling<'f> {
    /// The background, up to the border: the paper's choice.
    #[default]
    Background,
    /// The surroundings, captured once a frame through mirrored spheroids at the head.
    Capture(CaptureOptions),
    /// The pixels of another frame of the same walls, eyes and sizes, such as the
    /// frame before.
    Previous(&'f Frame),
}

/// How to capture the surroundings: with one ray a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaptureOptions {
    /// Pixels a side of each of the two hemispheres.
    pub size: u32,
    /// The level of detail of all its rays, 0 to 1.
    pub level: f32,
    /// Most steps to take, not counting the last ray of each tile of 16² pixels; pixels beyond
    /// them show the background. `None` for no limit.
    pub steps: Option<u64>,
}

impl Default for CaptureOptions {
    /// 128 pixels and a third of the detail: one of three bounces.
    fn default() -> Self {
        Self {
            size: 128,
            level: 0.34,
            steps: None,
        }
    }
}

/// The surroundings of a frame's viewer.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// The half that the viewer looks at, and the half behind; top up.
    pub hemispheres: [Picture; 2],
    /// Rays and steps; part of the frame's.
    pub statistics: Statistics,
    /// Wall-clock time; part of the frame's.
    pub seconds: f64,
}

/// Pixels a side of the tiles that steps are dealt out to.
const TILE: u32 = 16;

/// Steps that a tile gets in a round, if any.
const LEAST_PART: u64 = 256;

/// Renders tiles within a number of steps, dealt out in rounds in equal parts to unfinished tiles;
/// steps that a tile leaves go to the next round. The result does not depend on threads.
fn trace_within<const W: usize>(
    views: &[(View, Renderer<'_, W>)],
    jobs: &mut [Job<'_>],
    pool: &ThreadPool,
    steps: u64,
) -> (Statistics, f64)
where
    Simd: Runs<W>,
{
    let start = Instant::now();
    let mut statistics = Statistics::default();
    let mut pending: Vec<(TileJob, &mut Job<'_>)> = jobs
        .iter_mut()
        .map(|job| (TileJob::new(job.tile), job))
        .collect();
    loop {
        let left = steps.saturating_sub(statistics.steps);
        let served = pending.len().min((left / LEAST_PART) as usize);
        let Some(part) = left.checked_div(served as u64) else {
            break;
        };
        let served = pending[..served].iter_mut();
        statistics.add(&share_out(pool, served, |workspace, (tile, job)| {
            let (view, renderer) = &views[job.picture];
            let mut budget = Budget::steps(part);
            // Tiles of a view's own grid fit it.
            let outcome = tile.render(renderer, view, job.pixels, &mut budget, workspace);
            debug_assert!(outcome.is_ok());
        }));
        pending.retain(|(tile, _)| !tile.is_finished());
    }
    for (mut tile, job) in pending {
        let (view, renderer) = &views[job.picture];
        let given_up = tile.give_up(renderer, view, job.pixels);
        debug_assert!(given_up.is_ok());
    }
    (statistics, start.elapsed().as_secs_f64())
}

/// Returns the hemispheres of a capture, one ray a pixel: of several, some would pass the rim.
pub(crate) fn hemispheres<'a, const W: usize>(
    scene: &Scene<'a, W>,
    pose: DomePose,
    capture: CaptureOptions,
    frame: &Options,
    spectrum: Spectrum<'a>,
) -> Result<[(View, Renderer<'a, W>); 2], RenderError>
where
    Simd: Runs<W>,
{
    let mut options = *frame;
    options.settings.samples = 1;
    let renderer = in_full(scene, &options, spectrum)?.at_level(capture.level);
    let views = Surroundings::views(pose, capture.size).map_err(SurroundingsError::from)?;
    Ok(views.map(|view| (view, renderer)))
}

fn same_field(one: &LevelOfDetail, other: &LevelOfDetail) -> bool {
    let axes = |lod: &LevelOfDetail| {
        let sight = lod.gaze.line_of_sight();
        (sight.forward(), sight.up(), lod.gaze.visual_field())
    };
    axes(one) == axes(other)
}

/// Returns the level below which pixels of a capture are looked up: those of the blend,
/// and their neighbours.
fn needed_below(lod: &LevelOfDetail, size: u32) -> f32 {
    let limits = lod.gaze.visual_field().limits();
    let sides = [limits.down, limits.left, limits.right];
    let least = sides.into_iter().fold(limits.up, f32::min);
    // From a pixel to the far one of the four around a place.
    let across = 3.0 * PI / size as f32;
    BLEND + across / (least - limits.central)
}

/// The source of skipped pixels.
pub(super) enum Source<'s> {
    Nothing,
    Surroundings(Surroundings<'s>),
    /// By the number of the picture in the frame.
    Frame(&'s Frame),
}

impl Source<'_> {
    pub(super) fn fill<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        job: &mut Job<'_>,
    ) where
        Simd: Runs<W>,
    {
        let mut before = Vec::new();
        let fill = match self {
            Self::Nothing => return,
            Self::Surroundings(surroundings) => Fill::Surroundings(*surroundings),
            Self::Frame(frame) => {
                let Some(one) = frame.pictures.get(job.picture) else {
                    return;
                };
                pixels_of(&one.picture, job.tile, &mut before);
                Fill::Pixels(&before)
            }
        };
        // The tile is one of the view's, with its pixels.
        let outcome = renderer.fill(view, job.tile, &fill, job.pixels);
        debug_assert!(outcome.is_ok());
    }
}

/// Copies the pixels of a tile of a picture into `pixels`.
pub(crate) fn pixels_of(picture: &Picture, tile: Tile, pixels: &mut Vec<Pixel>) {
    let rows = picture.core_pixels().chunks_exact(picture.width as usize);
    pixels.clear();
    for row in rows.skip(tile.y as usize).take(tile.height as usize) {
        pixels.extend_from_slice(&row[tile.x as usize..][..tile.width as usize]);
    }
}

/// Captures the surroundings around the middle of the eyes; `None` where nothing follows their gaze.
pub(super) fn capture<'a, const W: usize>(
    scene: &Scene<'a, W>,
    spectrum: Spectrum<'a>,
    eyes: &[Observer],
    frame: &Options,
    options: CaptureOptions,
    pool: &ThreadPool,
) -> Result<Option<(DomePose, Capture)>, RenderError>
where
    Simd: Runs<W>,
{
    let mut gazes = eyes.iter().filter_map(|eye| eye.lod);
    let Some(lod) = gazes.next() else {
        return Ok(None);
    };
    let place = eyes.iter().map(|eye| eye.place).sum::<DVec3>() / eyes.len() as f64;
    let sight = lod.gaze.line_of_sight();
    let pose = DomePose {
        position: place.as_vec3(),
        room_from_capture: Mat3::from_cols(sight.right(), sight.up(), -sight.forward()),
    };
    let mut views = hemispheres(scene, pose, options, frame, spectrum)?;
    // Eyes with a gaze each need what either skips.
    if gazes.all(|other| same_field(&lod, &other)) {
        let level = needed_below(&lod, options.size);
        for (_, renderer) in &mut views {
            *renderer = renderer.below_level(lod.gaze, level);
        }
    }
    let tiles: Vec<_> = (0..)
        .zip(&views)
        .flat_map(|(number, (view, _))| tiles(view, TILE).map(move |tile| (number, tile)))
        .collect();
    let picture = || Picture::new(options.size, options.size);
    let mut hemispheres = [picture()?, picture()?];
    let area = 2 * options.size as usize * options.size as usize;
    let mut pixels = vec![Pixel::default(); area];
    let mut jobs = jobs(&tiles, &mut pixels);
    let (statistics, seconds) = match options.steps {
        Some(steps) => trace_within(&views, &mut jobs, pool, steps),
        None => trace(&views, &mut jobs, pool, &Source::Nothing, &|_, _| {}),
    };
    write_back(&jobs, hemispheres.iter_mut());
    let capture = Capture {
        hemispheres,
        statistics,
        seconds,
    };
    Ok(Some((pose, capture)))
}

/// Refuses a frame that has other pictures, places or sizes than `pictures`.
pub(super) fn check_previous(
    previous: &Frame,
    pictures: &[WallPicture],
) -> Result<(), RenderError> {
    let like = |one: &WallPicture| (one.wall, one.eye, one.picture.width, one.picture.height);
    let known = previous.pictures.iter().map(like);
    let is_alike = known.eq(pictures.iter().map(like));
    is_alike.then_some(()).ok_or(RenderError::Previous)
}
