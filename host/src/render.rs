//! All screens and eyes of a frame, and dome masters, on all cores.

pub mod effects;
pub mod gaze_reference;
pub mod spectrum;

mod fill;
mod images;
mod ledger;

use crate::cave::{Cave, DomeScreenError, Eye, Screen, WallError};
use crate::picture::{Picture, PictureError};
use crate::render::spectrum::Dispersion;
use effects::Effects;
use fill::Source;
pub(crate) use fill::pixels_of;
pub use fill::{Capture, CaptureOptions, Filling};
use glam::{DVec3, Vec3};
use images::images;
pub use ledger::{Account, account};
use miette::Diagnostic;
use rayon::ThreadPool;
use shisen_core::frame::{
    Budget, DomeError, LevelOfDetail, Pixel, Renderer, Settings, Spectrum, SpectrumError,
    Statistics, SurroundingsError, Tile, TileJob, View, ViewError, Workspace,
};
use shisen_core::gaze::{Acuity, Gaze, LineOfSight, VisualField};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use thiserror::Error;
use xxhash_rust::xxh3::Xxh3;

/// How to render a frame. Only `settings`, `effects` and `dispersion` change
/// what is in it.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Bounces, samples, and how primary rays go.
    pub settings: Settings,
    /// What to carry out of what the scene asks for.
    pub effects: Effects,
    /// How to take wavelengths where the scene asks for dispersion.
    pub dispersion: Dispersion,
    /// Threads, 1 or more.
    pub threads: usize,
    /// Pixels a side of the tiles that threads take, 1 or more.
    pub tile: u32,
    /// The instruction set to use.
    pub simd: Simd,
}

impl Default for Options {
    /// All cores, tiles of 32 pixels.
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

/// One of the viewer's eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer {
    /// Which.
    pub eye: Eye,
    /// Where it is: metres, in the room.
    pub place: DVec3,
    /// The detail that follows its gaze, if any does. The two eyes may have one
    /// line of sight, as in the paper, or one each.
    pub lod: Option<LevelOfDetail>,
    /// How finely it sees beside its line of sight, where that too follows its
    /// gaze: see [`Renderer::with_foveation`]. Without `lod` it is of no use.
    pub acuity: Option<Acuity>,
    /// Where it looks, as far as anybody knows, where there is no `lod`: a direction in
    /// the room, near which nothing is to be missing in a frame of the
    /// [live loop](crate::live).
    pub ahead: Option<Vec3>,
}

impl Observer {
    /// An eye for which everything is traced in full.
    pub const fn new(eye: Eye, place: DVec3) -> Self {
        Self {
            eye,
            place,
            lod: None,
            acuity: None,
            ahead: None,
        }
    }
}

impl Observer {
    /// An eye whose periphery is sampled as finely as it sees ([`Acuity::GUENTER`]),
    /// every ray in full. The field is the widest there is: so far apart, the rays
    /// beyond the paper's cost little. The line of sight is known to within `widen`
    /// (radians); from π on that is nothing, and everything is traced.
    pub fn foveated(eye: Eye, place: DVec3, sight: LineOfSight, widen: f32) -> Self {
        let Some(field) = VisualField::WIDEST.wider(widen) else {
            return Self {
                ahead: Some(sight.forward()),
                ..Self::new(eye, place)
            };
        };
        Self {
            lod: Some(LevelOfDetail::in_full(Gaze::new(sight, field))),
            acuity: Some(Acuity::GUENTER.around(widen)),
            ..Self::new(eye, place)
        }
    }

    /// Where it looks, if anybody knows: a direction in the room.
    pub(crate) fn forward(&self) -> Option<Vec3> {
        let gaze = self.lod.map(|lod| lod.gaze.line_of_sight().forward());
        gaze.or(self.ahead)
    }

    /// A renderer that follows its gaze.
    pub(crate) fn follow<'a, const W: usize>(&self, renderer: &Renderer<'a, W>) -> Renderer<'a, W>
    where
        Simd: Runs<W>,
    {
        match (self.lod, self.acuity) {
            (Some(lod), Some(acuity)) => renderer.with_foveation(lod, acuity),
            (Some(lod), None) => renderer.with_level_of_detail(lod),
            (None, _) => *renderer,
        }
    }
}

/// What one eye sees on one wall or dome.
#[derive(Debug, Clone, PartialEq)]
pub struct WallPicture {
    /// Index of the screen among [`Cave::screens`]: walls come first.
    pub wall: usize,
    /// The eye.
    pub eye: Eye,
    /// Linear light; transparent outside a dome's rim.
    pub picture: Picture,
}

/// A tile to render: of which picture, and into which pixels.
type Job<'p> = (usize, Tile, &'p mut [Pixel]);

/// All screens for all eyes.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Screen by screen, and eye by eye in each.
    pub pictures: Vec<WallPicture>,
    /// Rays and steps.
    pub statistics: Statistics,
    /// From the first ray to the last pixel, wall-clock time.
    pub seconds: f64,
    /// The surroundings, where they were captured.
    pub capture: Option<Capture>,
}

impl Frame {
    /// XXH3-64 over the pictures' hashes, in order: the same for any number
    /// of threads, any size of tiles and any instruction set.
    pub fn hash(&self) -> u64 {
        frame_hash(self.pictures.iter().map(|one| one.picture.hash()))
    }
}

/// Of a frame, by its pictures' hashes in order: [`Frame::hash`].
pub fn frame_hash(pictures: impl IntoIterator<Item = u64>) -> u64 {
    let mut hash = Xxh3::new();
    for picture in pictures {
        hash.update(&picture.to_le_bytes());
    }
    hash.digest()
}

/// Why a frame cannot be rendered. What is to be done about it is in the message or, as
/// a [`Diagnostic`], in the help.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RenderError {
    /// An eye that does not see a wall.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wall(#[from] WallError),
    /// A wall's rays that cannot be traced.
    #[error("wall \"{wall}\" cannot be traced")]
    #[diagnostic(help(
        "move the head away from the wall's plane, to the side that it is seen from"
    ))]
    View {
        /// Its name.
        wall: String,
        /// Why.
        #[source]
        source: ViewError,
    },
    /// An eye that is not inside a dome.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Dome(#[from] DomeScreenError),
    /// A dome's rays that cannot be traced.
    #[error("dome \"{dome}\" cannot be traced")]
    #[diagnostic(help("move the head towards the dome's centre"))]
    DomeView {
        /// Its name.
        dome: String,
        /// Why.
        #[source]
        source: DomeError,
    },
    /// A picture that cannot be kept in memory.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A dome master that cannot be traced.
    #[error("the surroundings cannot be captured")]
    #[diagnostic(help(
        "capture 1 to {limit} pixels a side, from a head that is in the room",
        limit = View::MOST_PIXELS
    ))]
    Surroundings(#[from] SurroundingsError),
    /// A frame that cannot have been the one before.
    #[error(
        "the frame before has other walls, eyes or sizes: fill from a frame of the same walls, \
         for the same eyes"
    )]
    Previous,
    /// A wavelength at which a medium of the scene is not known.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// No threads to be had.
    #[error("the threads could not be started: {0}; ask for fewer of them")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Renders what each eye sees on each wall and dome. All threads share all tiles, so
/// that a wall that is looked at does not wait for its own. `progress` is
/// called with the tiles finished so far and their total.
///
/// # Errors
/// See [`RenderError`].
pub fn cave<const W: usize>(
    scene: &Scene<'_, W>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Frame, RenderError>
where
    Simd: Runs<W>,
{
    cave_filled(scene, cave, eyes, options, Filling::Background, progress)
}

/// As [`cave`], with something else than the background where the gaze skips
/// rays.
///
/// # Errors
/// See [`RenderError`].
pub fn cave_filled<const W: usize>(
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
        let of_wavelength = |one: &Options| cave_filled(scene, cave, eyes, one, filling, progress);
        if let Some(frame) = images::sum(&images, of_wavelength)? {
            return Ok(frame);
        }
    }
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let mut views = Vec::new();
    let mut pictures = Vec::new();
    for (number, screen) in cave.screens().enumerate() {
        for observer in eyes {
            let view = view(screen, observer)?;
            pictures.push(WallPicture {
                wall: number,
                eye: observer.eye,
                picture: Picture::new(view.columns(), view.rows())?,
            });
            views.push((view, renderer(scene, observer, options, spectrum)?));
        }
    }
    // Eyes see nearly the same through a tile of a screen: one after the other, what
    // the first has brought near is still there for the next.
    let of_screen = eyes.len().max(1);
    let places: Vec<(usize, Tile)> = (0..views.len())
        .step_by(of_screen)
        .flat_map(|first| {
            let of_tile = move |tile| (first..first + of_screen).map(move |eye| (eye, tile));
            tiles(&views[first].0, options.tile).flat_map(of_tile)
        })
        .collect();
    let area = |tile: &Tile| tile.width as usize * tile.height as usize;
    // A frame's memory is there before the frame begins.
    let mut pixels = vec![Pixel::default(); places.iter().map(|(_, tile)| area(tile)).sum()];
    let mut jobs = jobs(&places, &mut pixels);
    let pool = pool(options.threads)?;
    let capture = match filling {
        Filling::Capture(how) => fill::capture((scene, spectrum), eyes, options, how, &pool)?,
        Filling::Background | Filling::Previous(_) => None,
    };
    let source = match (&capture, filling) {
        (Some((plan, capture)), _) => {
            Source::Surroundings(plan.surroundings(&capture.hemispheres)?)
        }
        (None, Filling::Previous(frame)) => {
            fill::check_previous(frame, &pictures)?;
            Source::Frame(frame)
        }
        (None, Filling::Background | Filling::Capture(_)) => Source::Nothing,
    };
    let (mut statistics, mut seconds) = trace(&views, &mut jobs, &pool, &source, progress);
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

/// Each tile with its own part of the pixels of all.
fn jobs<'p>(places: &[(usize, Tile)], pixels: &'p mut [Pixel]) -> Vec<Job<'p>> {
    let mut rest = pixels;
    let mut jobs = Vec::with_capacity(places.len());
    for &(picture, tile) in places {
        let (own, others) = rest.split_at_mut(tile.width as usize * tile.height as usize);
        rest = others;
        jobs.push((picture, tile, own));
    }
    jobs
}

/// Puts finished tiles into their pictures.
fn write_back<'p>(jobs: &[Job<'_>], pictures: impl Iterator<Item = &'p mut Picture>) {
    let mut pictures: Vec<_> = pictures.collect();
    for (picture, tile, pixels) in jobs {
        put(pictures[*picture], *tile, pixels);
    }
}

/// Puts a tile into its picture.
pub(crate) fn put(picture: &mut Picture, tile: Tile, pixels: &[Pixel]) {
    for (row, from) in (tile.y..).zip(pixels.chunks_exact(tile.width as usize)) {
        for (column, pixel) in (tile.x..).zip(from) {
            picture.set_pixel(
                column,
                row,
                [pixel.red, pixel.green, pixel.blue, pixel.alpha],
            );
        }
    }
}

/// Threads to render with.
///
/// # Errors
/// Where the system does not give so many.
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

/// Renders one picture, such as a dome master, in place: threads take bands of
/// [`Options::tile`] rows of it. `progress` is called with the bands finished so
/// far and their total.
///
/// # Errors
/// A picture that is too large, threads that cannot be started.
pub fn dome<const W: usize>(
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
        let of_wavelength = |one: &Options| dome(scene, view, lod, one, progress);
        if let Some(picture) = images::sum(&images, of_wavelength)? {
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
        .map(|(pixels, y)| {
            let tile = Tile {
                x: 0,
                y,
                width: columns,
                height: height.min(rows - y),
            };
            (0, tile, pixels)
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

/// Does all jobs, fills what they skipped, and says what it took.
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
    let render = |workspace: &mut Workspace, job: &mut Job<'_>| {
        let (picture, tile, pixels) = job;
        let (view, renderer) = &views[*picture];
        // Tiles of a view's own grid fit it, and no budget ends this one.
        let outcome = TileJob::new(*tile).render(
            renderer,
            view,
            pixels,
            &mut { Budget::UNLIMITED },
            workspace,
        );
        debug_assert!(outcome.is_ok());
        source.fill(renderer, view, job);
        progress(finished.fetch_add(1, Ordering::Relaxed) + 1, total);
    };
    let start = Instant::now();
    // Tiles differ by a factor of a hundred in what they cost, and the dear
    // ones are neighbours: each thread takes the next one that nobody has.
    let next = Mutex::new(jobs.iter_mut());
    let done = pool.broadcast(|_| {
        let mut workspace = Workspace::new();
        while let Some(job) = next.lock().ok().and_then(|mut next| next.next()) {
            render(&mut workspace, job);
        }
        workspace.statistics
    });
    let seconds = start.elapsed().as_secs_f64();
    let mut statistics = Statistics::default();
    for part in &done {
        statistics.add(part);
    }
    (statistics, seconds)
}

/// The renderer for what an eye sees, of [`Dispersion::spectrum`].
///
/// # Errors
/// A wavelength at which a medium of the scene is not known.
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

/// The renderer for everything in full.
pub(crate) fn in_full<'a, const W: usize>(
    scene: &Scene<'a, W>,
    options: &Options,
    spectrum: Spectrum<'a>,
) -> Result<Renderer<'a, W>, SpectrumError>
where
    Simd: Runs<W>,
{
    let (simd, settings) = (options.simd, options.settings);
    effects::renderer(*scene, simd, settings, &options.effects, spectrum)
}

/// The rays through a screen's pixels from an eye.
///
/// # Errors
/// [`RenderError::Wall`] and [`RenderError::View`], [`RenderError::Dome`] and
/// [`RenderError::DomeView`].
pub fn view<'a>(screen: impl Into<Screen<'a>>, observer: &Observer) -> Result<View, RenderError> {
    match screen.into() {
        Screen::Wall(wall) => {
            let view = wall.view_from(observer.place)?;
            View::new(
                view.eye.into(),
                view.first_pixel.into(),
                view.column_step.into(),
                view.row_step.into(),
                [view.columns, view.rows],
            )
            .map_err(|source| RenderError::View {
                wall: wall.name.clone(),
                source,
            })
        }
        Screen::Dome(dome) => {
            let seen = dome.view_from(observer.place)?;
            View::dome_screen(seen, observer.place.as_vec3(), dome.size()).map_err(|source| {
                RenderError::DomeView {
                    dome: dome.name().to_owned(),
                    source,
                }
            })
        }
    }
}

/// The tiles of a view, in rows.
pub(crate) fn tiles(view: &View, side: u32) -> impl Iterator<Item = Tile> + use<> {
    let (columns, rows) = (view.columns(), view.rows());
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cave::BuiltInCave;

    #[test]
    fn errors_name_the_next_step() {
        let limit = View::MOST_PIXELS.to_string();
        let behind = |cave, wall, place| {
            let cave = Cave::built_in(cave, [8; 2]).unwrap();
            let screen = cave.screens().nth(wall).unwrap();
            view(screen, &Observer::new(Eye::Centre, place)).unwrap_err()
        };
        let wall = "front".to_owned();
        for (error, step) in [
            (
                behind(BuiltInCave::ThreeWall, 0, DVec3::NEG_Z * 9.0),
                "move the head",
            ),
            (
                behind(BuiltInCave::Dome, 0, DVec3::Y * 9.0),
                "move the head",
            ),
            (
                RenderError::View {
                    wall,
                    source: ViewError::Screen,
                },
                "move the head",
            ),
            (
                RenderError::Surroundings(DomeError::Size { size: 0 }.into()),
                &limit,
            ),
        ] {
            let help = Diagnostic::help(&error).unwrap().to_string();
            assert!(help.contains(step), "{error}: {help}");
        }
        // What other crates' errors say it in is the message.
        let said = RenderError::Previous.to_string();
        assert!(
            said.contains("fill from a frame of the same walls"),
            "{said}"
        );
    }
}
