//! direct SCENE STREAM: the frame and the dome master of core/capi/examples, by
//! the core and the driver without the C library between them.

use glam::Vec3;
use shisen_capi_tests::pieces;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, FlatScreen, LevelOfDetail, MirrorCamera, Mode, Outcome,
    Pixel, Renderer, Settings, Tile, TileJob, View, Workspace,
};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_core::scene::Scene;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{Estimate, EstimatorConfig, GazeEstimator};
use shisen_tracker::link::Link;
use shisen_tracker::time::Micros;
use std::error::Error;

const SIDE: u32 = 64;
/// The display shows a frame so long after the tracker's last byte.
const DISPLAY_DELAY: Micros = Micros(20_000);

/// At a multiple of 32 bytes.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct Aligned([u8; 32]);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [scene, stream] = arguments.as_slice() else {
        return Err("usage: direct SCENE STREAM".into());
    };
    let bytes = std::fs::read(scene)?;
    let mut blob = vec![Aligned([0; 32]); bytes.len().div_ceil(32)];
    for (to, from) in blob.iter_mut().zip(bytes.chunks(32)) {
        to.0[..from.len()].copy_from_slice(from);
    }
    // SAFETY: arrays of bytes without gaps.
    let blob = unsafe { std::slice::from_raw_parts(blob.as_ptr().cast::<u8>(), blob.len() * 32) };
    let scene: Scene<4> = Scene::from_bytes(blob)?;
    let stream = std::fs::read(stream)?;
    let (gaze, samples) = gaze(&stream)?;

    let settings = Settings {
        mode: Mode::Single,
        ..Settings::default()
    };
    let renderer = Renderer::new(scene, Simd::PORTABLE, settings);
    let eye = gaze.line_of_sight.position();
    let sight = gaze.line_of_sight;
    let sight = LineOfSight::new(eye, sight.forward(), sight.up())?;
    let following = match VisualField::PAPER.wider(gaze.widen) {
        Some(field) => renderer.with_level_of_detail(LevelOfDetail::new(Gaze::new(sight, field))),
        None => renderer,
    };
    // Lower left, lower right and upper left, in half sides of a cube of 3 m.
    let corners = [
        [[-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]],
        [[-1., -1., 1.], [-1., -1., -1.], [-1., 1., 1.]],
        [[1., -1., -1.], [1., -1., 1.], [1., 1., -1.]],
    ];
    let mut workspace = Workspace::new();
    let mut hash = FNV_START;
    for corners in corners {
        let [lower_left, lower_right, upper_left] = corners.map(|corner| 1.5 * Vec3::from_array(corner));
        let screen = FlatScreen::from_corners(lower_left, lower_right, upper_left, [SIDE, SIDE]);
        let view = screen.view_from(eye)?;
        hash = fnv1a(hash, &picture(&following, &view, &mut workspace)?);
    }
    let projection = DomeProjection::Mirror(MirrorCamera::best(0.001));
    let view = View::dome(projection, DomePose::over_room(Vec3::ZERO), SIDE)?;
    let steps = workspace.statistics.steps;
    let dome = fnv1a(FNV_START, &picture(&renderer, &view, &mut workspace)?);
    println!("samples {samples}");
    println!("gaze state {}", gaze.state as u32);
    println!("steps {steps}");
    println!("frame {hash:016x}");
    println!("dome {dome:016x}");
    Ok(())
}

/// Returns where the viewer looks after a stream, and how many samples there were.
fn gaze(stream: &[u8]) -> Result<(Estimate, u64), Box<dyn Error>> {
    let mut link = Link::new();
    let mut clock = ClockEstimator::new(ClockConfig::default())?;
    let mut gaze = GazeEstimator::new(EstimatorConfig::default())?;
    let mut last = Micros(0);
    for (arrival, bytes) in pieces(stream) {
        link.feed(bytes, arrival, &mut |event| {
            if let Event::Sample(sample) = event {
                let stamp = clock.stamp(&sample, &mut |_| {});
                gaze.push(&sample, stamp.time, &mut |_| {});
            }
        });
        last = arrival;
    }
    let estimate = gaze.estimate(last.after(DISPLAY_DELAY), &mut |_| {});
    Ok((estimate, link.counts().samples))
}

/// Returns all pixels of a view at once.
fn picture(
    renderer: &Renderer<'_, 4>,
    view: &View,
    workspace: &mut Workspace,
) -> Result<Vec<Pixel>, Box<dyn Error>> {
    let (width, height) = (view.columns(), view.rows());
    let mut pixels = vec![Pixel::default(); (width * height) as usize];
    let tile = Tile {
        x: 0,
        y: 0,
        width,
        height,
    };
    let mut budget = Budget::UNLIMITED;
    let outcome = TileJob::new(tile).render(renderer, view, &mut pixels, &mut budget, workspace)?;
    assert_eq!(outcome, Outcome::Finished);
    Ok(pixels)
}

const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

fn fnv1a(hash: u64, pixels: &[Pixel]) -> u64 {
    let numbers = pixels
        .iter()
        .flat_map(|p| [p.red, p.green, p.blue, p.alpha]);
    numbers.flat_map(f32::to_le_bytes).fold(hash, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
