//! Renders a controller's frame again on the host, for comparison.

use super::{FirmwareError, ShownFrame, TILE};
use glam::Vec3;
use shisen::picture::Picture;
use shisen::render::spectrum::Method;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, FlatScreen, FrameJob, LevelOfDetail, MirrorCamera, Mode,
    Part, Pixel, Place, Progress, Renderer, Settings, Spectrum, View, Workspace,
};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_core::scene::{CompactScene, EffectSet};
use shisen_core::spectrum::{SpectralSample, SpectralTable, Wavelengths};
use shisen_tracker::link::display::{FrameStart, Rendering, Subject};
use std::fmt::Display;

/// Phases of the controller's table of wavelengths.
const PHASES: u32 = 8;
/// Radius of the mirror of the controller's dome masters: metres.
const MIRROR_RADIUS: f32 = 0.01;

fn impossible(error: impl Display) -> FirmwareError {
    FirmwareError::other_sources(format!(
        "the firmware's frame cannot be made again: {error}"
    ))
}

/// Renders the pictures of a controller's frame from its scene, its screens and its
/// report of the frame's start. A frame that was cut short gets its first tiles only.
/// `without_dispersion`: the controller has no code for wavelengths.
///
/// # Errors
/// A screen, a dome master, a gaze or wavelengths that are not valid.
pub fn reference(
    scene: CompactScene<'_>,
    screens: &[FlatScreen],
    rendering: &Rendering,
    shown: &ShownFrame,
    without_dispersion: bool,
) -> Result<Vec<Picture>, FirmwareError> {
    let start = &shown.start;
    let settings = Settings {
        depth: rendering.depth,
        mode: Mode::Single,
        ..Settings::default()
    };
    let renderer = Renderer::new(scene, Simd::detect(), settings);
    // The firmware has no code for the others.
    let mut renderer = renderer.without(EffectSet::ALL.difference(EffectSet::WHITTED));
    if without_dispersion {
        renderer = renderer.without(EffectSet::DISPERSION);
    }
    let mut samples = Vec::new();
    if !without_dispersion && let Some(spectrum) = spectrum(rendering.wavelengths, &mut samples) {
        renderer = renderer.with_spectrum(spectrum).map_err(impossible)?;
    }
    let [left, right] = start.eyes;
    let renderers = [
        follow(&renderer, start, left)?,
        follow(&renderer, start, right)?,
    ];
    let parts = match start.subject {
        Subject::Screens => {
            let eyes = if rendering.eye_distance == 0.0 { 1 } else { 2 };
            let eyes: Vec<_> = start.eyes.iter().zip(&renderers).take(eyes).collect();
            let parts = screens.iter().flat_map(|screen| {
                let part = |&(&eye, renderer): &(&Vec3, _)| {
                    let view = screen.view_from(eye).map_err(impossible)?;
                    Ok(Part { view, renderer })
                };
                eyes.iter().map(part).collect::<Vec<_>>()
            });
            parts.collect::<Result<Vec<_>, FirmwareError>>()?
        }
        Subject::Capture { size } => vec![Part {
            view: dome(left, size)?,
            renderer: &renderers[0],
        }],
    };
    let cut = shown.done.filter(|done| done.cut_short);
    let tiles = cut.map_or(u32::MAX, |done| done.whole.saturating_add(done.given_up));
    render(&parts, Budget::steps(start.budget), tiles)
}

/// Returns the level of detail for an eye's gaze, if it follows the gaze.
fn follow<'a>(
    renderer: &Renderer<'a, 4>,
    start: &FrameStart,
    eye: Vec3,
) -> Result<Renderer<'a, 4>, FirmwareError> {
    let field = start
        .state
        .and_then(|_| VisualField::PAPER.wider(start.widen));
    let Some(field) = field else {
        return Ok(*renderer);
    };
    let sight = LineOfSight::new(eye, start.forward, start.up).map_err(impossible)?;
    Ok(renderer.with_level_of_detail(LevelOfDetail::new(Gaze::new(sight, field))))
}

fn spectrum(count: u8, samples: &mut Vec<SpectralSample>) -> Option<Spectrum<'_>> {
    let wavelengths = Wavelengths::new(count.into(), Wavelengths::RANGE).ok()?;
    if count < 2 {
        return None;
    }
    samples.resize(
        SpectralTable::samples(wavelengths, PHASES),
        SpectralSample::default(),
    );
    let matching = Method::Comb.matching();
    let table = SpectralTable::new(wavelengths, PHASES, matching, samples).ok()?;
    Some(Spectrum::Comb { table, each: 1 })
}

fn dome(place: Vec3, size: u16) -> Result<View, FirmwareError> {
    let camera = MirrorCamera::best(MIRROR_RADIUS);
    let pose = DomePose::over_room(place);
    View::dome(DomeProjection::Mirror(camera), pose, size.into()).map_err(impossible)
}

/// Renders the given number of tiles of a frame, or all.
fn render(
    parts: &[Part<'_, '_, 4>],
    budget: Budget,
    tiles_wanted: u32,
) -> Result<Vec<Picture>, FirmwareError> {
    let size = |part: &Part<'_, '_, 4>| [part.view.columns(), part.view.rows()];
    let tiles = FrameJob::tiles_of(parts.iter().map(size), TILE);
    let mut places = vec![Place::default(); tiles];
    let mut pictures = parts
        .iter()
        .map(|part| Picture::new(part.view.columns(), part.view.rows()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(impossible)?;
    let mut pixels = [Pixel::default(); (TILE * TILE) as usize];
    let mut workspace = Workspace::new();
    let mut job = FrameJob::new(parts, TILE, budget, &mut places).map_err(impossible)?;
    let mut tiles_left = tiles_wanted;
    while tiles_left > 0 {
        let mut slice = Budget::UNLIMITED;
        let progress = job.render(parts, &mut pixels, &mut slice, &mut workspace);
        match progress.map_err(impossible)? {
            Progress::Finished => break,
            Progress::BudgetSpent => {}
            Progress::Tile { part, tile, .. } => {
                tiles_left -= 1;
                let picture = &mut pictures[part];
                let rows = pixels.chunks_exact(tile.width as usize);
                for (y, row) in (tile.y..tile.y + tile.height).zip(rows) {
                    for (x, pixel) in (tile.x..).zip(row) {
                        let pixel = [pixel.red, pixel.green, pixel.blue, pixel.alpha];
                        picture.set_pixel(x, y, pixel);
                    }
                }
            }
        }
    }
    Ok(pictures)
}
