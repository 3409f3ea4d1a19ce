//! Frames: all screens of a room for all eyes, and dome masters, on all cores.
//!
//! [`cave`] renders a room, [`dome`] one picture; the example on the [crate's front page](crate)
//! is a whole frame. Results are the same bits for any number of threads and any size of tiles.
//!
//! **Gaze.** An [`Observer`] may have a level of detail that follows its line of sight, by
//! Mochizuki & Makino: 1 within 30°, falling to 0 at the border of the visual field (60° up, 70°
//! down, 100° to the sides). The level says how often a ray is reflected or refracted and how
//! many faces of a mesh it sees; beyond the border nothing is traced. [`Observer::foveated`]
//! makes detail as large as the eye sees it instead, by Guenter et al. (2012), and leaves nothing
//! out.
//!
//! **Fills.** What shows where the gaze skips rays is a [`Filling`]: the background; the
//! surroundings, captured once a frame through two mirrored spheroids at the head; or another
//! frame. A capture knows directions and not distances, so near things are seen from the middle
//! of the head; it pays for scenes that take long.
//!
//! **Effects.** A scene asks for effects by its materials and lights: shadows, reflection,
//! refraction, dispersion and more. [`effects`] adds to them or takes from them; [`account`]
//! counts what each does in a frame. [`spectrum`] has the ways to take wavelengths.

pub mod effects;
pub mod gaze_reference;
pub mod spectrum;

mod fill;
mod images;
mod ledger;
mod observer;

use crate::bake::AnyScene;
use crate::cave::{Cave, Eye, Pictured, RoomError};
use crate::picture::{Picture, PictureError};
use crate::render::spectrum::Dispersion;
use crate::with_scene;
use effects::Effects;
use fill::Source;
pub use fill::{Capture, CaptureOptions, Filling};
pub(crate) use fill::{hemispheres, pixels_of};
use images::images;
pub use ledger::{Account, account};
use miette::Diagnostic;
pub use observer::{Foveation, Observer};
use rayon::ThreadPool;
use shisen_core::frame::{
    Budget, LevelOfDetail, Pixel, Renderer, Settings, Spectrum, SpectrumError, Statistics,
    Surroundings, SurroundingsError, Tile, TileJob, View, Workspace, foveated_samples,
};
use shisen_core::scene::{EffectSet, PoseError, Scene};
use shisen_core::{Runs, Simd};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use thiserror::Error;
use xxhash_rust::xxh3::Xxh3;

/// How to render a frame. Only `settings`, `effects` and `dispersion` change its pixels.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Bounces, samples, and the mode of primary rays.
    pub settings: Settings,
    /// The effects to carry out.
    pub effects: Effects,
    /// The choice of wavelengths if the scene asks for dispersion.
    pub dispersion: Dispersion,
    /// Threads, 1 or more.
    pub threads: usize,
    /// Pixels a side of the tiles that threads take, 1 or more.
    pub tile: u32,
    /// The instruction set to use.
    pub simd: Simd,
}

impl Default for Options {
    /// Returns all cores, tiles of 32 pixels.
    fn default() -> Self {
        Self {
            settings: Settings::default(),
            effects: Effects::AUTO,
            dispersion: Dispersion::default(),
            threads: std::thread::available_parallelism().map_or(1, Into::into),
            tile: 32,
            simd: Simd::detect(),
        }
    }
}

impl Options {
    /// Returns how many rays a pixel has where an observer has a foveation.
    pub fn foveated_samples(&self) -> u16 {
        let samples = self.settings.samples;
        match self.dispersion {
            Dispersion::Images(wavelengths, _) => {
                let shares = images::shares(samples, wavelengths.count());
                shares.map(foveated_samples).sum()
            }
            _ => foveated_samples(samples),
        }
    }
}

/// The picture of one wall or dome for one eye.
#[derive(Debug, Clone, PartialEq)]
pub struct WallPicture {
    /// Index of the screen among [`Cave::pictured`]: walls come first.
    pub wall: usize,
    /// The eye.
    pub eye: Eye,
    /// Linear light; transparent outside a dome's rim.
    pub picture: Picture,
    /// Its rays and steps, without those of a capture.
    pub statistics: Statistics,
}

struct Job<'p> {
    picture: usize,
    tile: Tile,
    pixels: &'p mut [Pixel],
    statistics: Statistics,
}

/// All screens for all eyes.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Screen by screen, and eye by eye in each.
    pub pictures: Vec<WallPicture>,
    /// Rays and steps.
    pub statistics: Statistics,
    /// From the first ray to the last pixel, wall-clock time.
    pub seconds: f64,
    /// The captured surroundings, if the filling needs them.
    pub capture: Option<Capture>,
}

impl Frame {
    /// XXH3-64 over the pictures' hashes, in order: the same for any number
    /// of threads, any size of tiles and any instruction set.
    pub fn hash(&self) -> u64 {
        frame_hash(self.pictures.iter().map(|one| one.picture.hash()))
    }
}

/// Returns the hash of a frame from its pictures' hashes, in order: see [`Frame::hash`].
pub fn frame_hash(pictures: impl IntoIterator<Item = u64>) -> u64 {
    let mut hash = Xxh3::new();
    for picture in pictures {
        hash.update(&picture.to_le_bytes());
    }
    hash.digest()
}

/// Why a frame cannot be rendered. The message, or the help of the [`Diagnostic`], says what to do
/// about it.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages are the docs")]
pub enum RenderError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Screen(#[from] RoomError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error("the surroundings cannot be captured")]
    #[diagnostic(help(
        "capture 1 to {limit} pixels a side, from a head that is in the room",
        limit = View::MOST_PIXELS
    ))]
    Surroundings(#[from] SurroundingsError),
    #[error(
        "the frame before has other walls, eyes or sizes: fill from a frame of the same walls, \
         for the same eyes"
    )]
    Previous,
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error("the scene cannot move")]
    #[diagnostic(help("change the animation so that every object stays within 1e12 m"))]
    Pose(#[from] PoseError),
    #[error("the threads could not be started: {0}; ask for fewer of them")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Renders each wall and dome for each eye. All threads share all tiles, so that an
/// expensive wall does not finish later than the others. `progress` is called with
/// the tiles finished so far and their total.
///
/// # Errors
/// See [`RenderError`].
pub fn cave(
    scene: AnyScene<'_>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError> {
    cave_filled(scene, cave, eyes, options, Filling::Background, progress)
}

/// Does what [`cave`] does, with a choice of what fills the pixels that the gaze skips.
///
/// # Errors
/// See [`RenderError`].
pub fn cave_filled(
    scene: AnyScene<'_>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    filling: Filling<'_>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError> {
    with_scene!(scene, |scene| filled(
        &scene, cave, eyes, options, filling, progress
    ))
}

fn filled<const W: usize>(
    scene: &Scene<'_, W>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    filling: Filling<'_>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError>
where
    Simd: Runs<W>,
{
    if let Some(images) = images(scene, options) {
        let of_wavelength = |one: &Options| filled(scene, cave, eyes, one, filling, progress);
        if let Some(frame) = images::sum(&images, of_wavelength, Frame::parts)? {
            return Ok(frame);
        }
    }
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let mut views = Vec::new();
    let mut pictures = Vec::new();
    for (number, pictured) in cave.pictured().enumerate() {
        for observer in eyes {
            let view = view(pictured, observer)?;
            pictures.push(WallPicture {
                wall: number,
                eye: observer.eye,
                picture: Picture::new(view.columns(), view.rows())?,
                statistics: Statistics::default(),
            });
            views.push((view, renderer(scene, observer, options, spectrum)?));
        }
    }
    // Both eyes see nearly the same through a tile: one after the other, they share caches.
    let of_screen = eyes.len().max(1);
    let places: Vec<(usize, Tile)> = (0..views.len())
        .step_by(of_screen)
        .flat_map(|first| {
            let of_tile = move |tile| (first..first + of_screen).map(move |eye| (eye, tile));
            tiles(&views[first].0, options.tile).flat_map(of_tile)
        })
        .collect();
    let area = |tile: &Tile| tile.width as usize * tile.height as usize;
    // All memory of the frame is allocated before it begins.
    let mut pixels = vec![Pixel::default(); places.iter().map(|(_, tile)| area(tile)).sum()];
    let mut jobs = jobs(&places, &mut pixels);
    let pool = pool(options.threads)?;
    let capture = match filling {
        Filling::Capture(how) => fill::capture(scene, spectrum, eyes, options, how, &pool)?,
        Filling::Background | Filling::Previous(_) => None,
    };
    let source = match (&capture, filling) {
        (Some((pose, capture)), _) => {
            let pictures = capture.hemispheres.each_ref();
            let (size, pixels) = (pictures[0].width, pictures.map(Picture::core_pixels));
            Source::Surroundings(Surroundings::new(*pose, size, pixels)?)
        }
        (None, Filling::Previous(frame)) => {
            fill::check_previous(frame, &pictures)?;
            Source::Frame(frame)
        }
        (None, Filling::Background | Filling::Capture(_)) => Source::Nothing,
    };
    let (mut statistics, mut seconds) = trace(&views, &mut jobs, &pool, &source, progress);
    for job in &jobs {
        pictures[job.picture].statistics.add(&job.statistics);
    }
    write_back(&jobs, pictures.iter_mut().map(|one| &mut one.picture));
    let capture = capture.map(|(_, capture)| capture);
    if let Some(capture) = &capture {
        statistics.add(&capture.statistics);
        seconds += capture.seconds;
    }
    Ok(Frame {
        pictures,
        statistics,
        seconds,
        capture,
    })
}

/// Returns a job for each tile, with its own part of the memory for pixels.
fn jobs<'p>(places: &[(usize, Tile)], pixels: &'p mut [Pixel]) -> Vec<Job<'p>> {
    let mut rest = pixels;
    let mut jobs = Vec::with_capacity(places.len());
    for &(picture, tile) in places {
        let (pixels, others) = rest.split_at_mut(tile.width as usize * tile.height as usize);
        rest = others;
        jobs.push(Job {
            picture,
            tile,
            pixels,
            statistics: Statistics::default(),
        });
    }
    jobs
}

fn write_back<'p>(jobs: &[Job<'_>], pictures: impl Iterator<Item = &'p mut Picture>) {
    let mut pictures: Vec<_> = pictures.collect();
    for job in jobs {
        put(pictures[job.picture], job.tile, job.pixels);
    }
}

pub(crate) fn put(picture: &mut Picture, tile: Tile, pixels: &[Pixel]) {
    let (x, width) = (tile.x as usize, tile.width as usize);
    let rows = picture.rows_mut(1).skip(tile.y as usize);
    for (row, from) in rows.zip(pixels.chunks_exact(width)) {
        row[x..x + width].copy_from_slice(from);
    }
}

/// Works on all items with all threads of a pool, and returns the rays and steps taken. Each thread
/// takes the next item left, since expensive items are neighbours.
fn share_out<T: Send>(
    pool: &ThreadPool,
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(&mut Workspace, T) + Sync,
) -> Statistics {
    let next = Mutex::new(items);
    let done = pool.broadcast(|_| {
        let mut workspace = Workspace::new();
        while let Some(item) = next.lock().ok().and_then(|mut next| next.next()) {
            work(&mut workspace, item);
        }
        workspace.statistics
    });
    let mut statistics = Statistics::default();
    for part in &done {
        statistics.add(part);
    }
    statistics
}

/// Returns a pool of threads to render with.
///
/// # Errors
/// If the system does not start that many threads.
pub fn pool(threads: usize) -> Result<ThreadPool, RenderError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    Ok(pool.build()?)
}

/// A dome master.
#[derive(Debug, Clone, PartialEq)]
pub struct DomePicture {
    /// Linear light; transparent outside the rim.
    pub picture: Picture,
    /// Rays and steps.
    pub statistics: Statistics,
    /// From the first ray to the last pixel, wall-clock time.
    pub seconds: f64,
}

/// Renders one picture, such as a dome master, in place: threads take bands of [`Options::tile`]
/// rows of it. `progress` is called with the bands finished so far and their total.
///
/// # Errors
/// A picture that is too large, threads that cannot be started.
pub fn dome(
    scene: AnyScene<'_>,
    view: &View,
    lod: Option<LevelOfDetail>,
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<DomePicture, RenderError> {
    with_scene!(scene, |scene| in_place(
        &scene, view, lod, options, progress
    ))
}

fn in_place<const W: usize>(
    scene: &Scene<'_, W>,
    view: &View,
    lod: Option<LevelOfDetail>,
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<DomePicture, RenderError>
where
    Simd: Runs<W>,
{
    if let Some(images) = images(scene, options) {
        let of_wavelength = |one: &Options| in_place(scene, view, lod, one, progress);
        if let Some(picture) = images::sum(&images, of_wavelength, DomePicture::parts)? {
            return Ok(picture);
        }
    }
    let (columns, rows) = (view.columns(), view.rows());
    let mut picture = Picture::new(columns, rows)?;
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let renderer = in_full(scene, options, spectrum)?;
    let renderer = match lod {
        Some(lod) => renderer.with_level_of_detail(lod),
        None => renderer,
    };
    let height = options.tile.max(1);
    let mut jobs: Vec<Job<'_>> = picture
        .rows_mut(height)
        .zip((0..rows).step_by(height as usize))
        .map(|(pixels, y)| Job {
            picture: 0,
            tile: Tile {
                x: 0,
                y,
                width: columns,
                height: height.min(rows - y),
            },
            pixels,
            statistics: Statistics::default(),
        })
        .collect();
    let views = [(*view, renderer)];
    let (statistics, seconds) = trace(
        &views,
        &mut jobs,
        &pool(options.threads)?,
        &Source::Nothing,
        progress,
    );
    Ok(DomePicture {
        picture,
        statistics,
        seconds,
    })
}

/// Does all jobs, fills the pixels that they skipped, and returns counts and time.
fn trace<const W: usize>(
    views: &[(View, Renderer<'_, W>)],
    jobs: &mut [Job<'_>],
    pool: &ThreadPool,
    source: &Source<'_>,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> (Statistics, f64)
where
    Simd: Runs<W>,
{
    let (finished, total) = (AtomicUsize::new(0), jobs.len());
    let start = Instant::now();
    let statistics = share_out(pool, jobs.iter_mut(), |workspace, job| {
        let (view, renderer) = &views[job.picture];
        let before = std::mem::take(&mut workspace.statistics);
        // Tiles of the view's grid fit it, and the budget has no end.
        let mut budget = Budget::UNLIMITED;
        let mut tile = TileJob::new(job.tile);
        let outcome = tile.render(renderer, view, job.pixels, &mut budget, workspace);
        debug_assert!(outcome.is_ok());
        job.statistics = workspace.statistics;
        workspace.statistics.add(&before);
        source.fill(renderer, view, job);
        progress(finished.fetch_add(1, Ordering::Relaxed) + 1, total);
    });
    (statistics, start.elapsed().as_secs_f64())
}

/// Returns the renderer for an observer, with the smallest shading that has the effects wanted;
/// `spectrum` is [`Dispersion::spectrum`].
///
/// # Errors
/// A wavelength at which the index of a medium of the scene is not known.
#[doc(hidden)]
pub fn renderer<'a, const W: usize>(
    scene: &Scene<'a, W>,
    observer: &Observer,
    options: &Options,
    spectrum: Spectrum<'a>,
) -> Result<Renderer<'a, W>, SpectrumError>
where
    Simd: Runs<W>,
{
    let renderer = in_full(scene, options, spectrum)?;
    Ok(observer.follow(&renderer))
}

/// Returns the renderer for all rays at full detail.
pub(crate) fn in_full<'a, const W: usize>(
    scene: &Scene<'a, W>,
    options: &Options,
    spectrum: Spectrum<'a>,
) -> Result<Renderer<'a, W>, SpectrumError>
where
    Simd: Runs<W>,
{
    let wanted = options.effects.of(scene.effects());
    let renderer = Renderer::smallest(*scene, options.simd, options.settings, wanted);
    let others = EffectSet::ALL.difference(wanted);
    renderer.without(others).with_spectrum(spectrum)
}

/// Returns the rays through a picture's pixels from an eye.
///
/// # Errors
/// An eye that does not see the screen, or too near to it to trace its rays.
pub fn view<'a>(of: impl Into<Pictured<'a>>, observer: &Observer) -> Result<View, RoomError> {
    of.into().view_from(observer.place)
}

/// Returns the tiles of a view, in rows.
pub(crate) fn tiles(view: &View, side: u32) -> impl Iterator<Item = Tile> + use<> {
    grid([view.columns(), view.rows()], side)
}

/// Returns the tiles of a picture of `columns` by `rows` pixels, in rows.
pub(crate) fn grid([columns, rows]: [u32; 2], side: u32) -> impl Iterator<Item = Tile> {
    let step = side.max(1) as usize;
    (0..rows).step_by(step).flat_map(move |y| {
        (0..columns).step_by(step).map(move |x| Tile {
            x,
            y,
            width: side.max(1).min(columns - x),
            height: side.max(1).min(rows - y),
        })
    })
}
