//! A slice takes at most its budget and one sample, however many samples a pixel has, and
//! changes no bit.

use super::tile::offset;
use super::*;
use crate::gaze::{Acuity, LineOfSight};
use core::f32::consts::PI;
use glam::{Mat3, Vec3};
use zerocopy::IntoBytes as _;

// Fewer under Miri, which is slow.
const MOST: u16 = if cfg!(miri) { 20 } else { MAX_SAMPLES };
// Columns and rows of a tile: one with whole blocks, and a small one for many samples.
const BLOCKS: [u32; 2] = [16, 16];
const SMALL: [u32; 2] = [3, 2];
const PIXELS: usize = (BLOCKS[0] * BLOCKS[1]) as usize;

/// Renders a tile in slices; its pixels, and the most steps of a slice.
fn in_slices(
    renderer: &Renderer<'_, 4>,
    view: &View,
    tile: Tile,
    steps: u64,
) -> ([Pixel; PIXELS], u64) {
    let (mut pixels, mut most) = ([Pixel::default(); PIXELS], 0);
    let room = (tile.width * tile.height) as usize;
    let (mut job, mut workspace) = (TileJob::new(tile), Workspace::new());
    loop {
        workspace.statistics.steps = 0;
        let mut budget = Budget::steps(steps);
        let outcome = job.render(
            renderer,
            view,
            &mut pixels[..room],
            &mut budget,
            &mut workspace,
        );
        most = most.max(workspace.statistics.steps);
        match outcome.unwrap() {
            Outcome::Finished => return (pixels, most),
            Outcome::BudgetSpent => assert!(budget.is_spent()),
        }
    }
}

/// Returns the pixels of a tile.
fn pixels(tile: Tile) -> impl Iterator<Item = [u32; 2]> {
    let columns = tile.x..tile.x + tile.width;
    (tile.y..tile.y + tile.height).flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// Returns the most steps of the ray tree of a sample, and of the primary rays of one sample of all
/// pixels of a block of the tile.
fn dearest(tracer: &Tracer<'_, 4>, view: &View, tile: Tile, samples: u16) -> [u64; 2] {
    let mut workspace = Workspace::new();
    let mut steps_of = |[x, y]: [u32; 2], sample, whole| {
        workspace.statistics.steps = 0;
        let (dx, dy) = offset(sample, samples);
        let Some(ray) = view.ray(x as f32 + dx, y as f32 + dy) else {
            return 0;
        };
        if whole {
            tracer.radiance(&ray, &mut { Budget::UNLIMITED }, &mut workspace);
        } else {
            tracer.nearest(&ray, &mut { Budget::UNLIMITED }, &mut workspace);
        }
        workspace.statistics.steps
    };
    let each = || pixels(tile).flat_map(|at| (0..samples).map(move |sample| (at, sample)));
    let tree = each().map(|(at, sample)| steps_of(at, sample, true)).max();
    let sum = |sample| pixels(tile).map(|at| steps_of(at, sample, false)).sum();
    let primaries: Option<u64> = (0..samples).map(sum).max();
    [tree.unwrap(), primaries.unwrap()]
}

fn views() -> [View; 2] {
    let pose = DomePose {
        position: Vec3::ZERO,
        room_from_capture: Mat3::IDENTITY,
    };
    let fisheye = DomeProjection::Equidistant { field_of_view: PI };
    let step = 1.2 / 64.0;
    let (first, right, down) = (
        Vec3::new(-0.6, 0.6, -2.0),
        Vec3::X * step,
        Vec3::NEG_Y * step,
    );
    let screen = View::new(Vec3::ZERO, first, right, down, [64; 2]).unwrap();
    [screen, View::dome(fisheye, pose, 64).unwrap()]
}

/// Returns a tile across the right edge of the ball, and across a border of blocks.
fn tile(tracer: &Tracer<'_, 4>, view: &View, [width, height]: [u32; 2]) -> Tile {
    let hits = |x: u32| {
        let ray = view.ray(x as f32, 31.0).unwrap();
        let hit = tracer.nearest(&ray, &mut { Budget::UNLIMITED }, &mut Workspace::new());
        hit.is_some()
    };
    let x = (1..63).rev().find(|&x| hits(x)).unwrap() - 1;
    Tile {
        x: x.min(64 - width),
        y: 31,
        width,
        height,
    }
}

#[test]
fn slices_end_between_samples_and_change_no_bit() {
    let bytes = crate::ball::scene();
    let scene = Scene::<4>::from_bytes(bytes.as_bytes()).unwrap();
    let sight = LineOfSight::new(Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), Vec3::Y).unwrap();
    let kinds = [(1, BLOCKS), (1, SMALL), (MOST, SMALL)];
    let ways = [Mode::Single, Mode::Tile].map(|mode| kinds.map(|kind| (mode, kind)));
    let ways = ways.as_flattened().iter();
    for (&(mode, (samples, size)), view) in ways.flat_map(|way| views().map(|view| (way, view))) {
        let settings = Settings {
            depth: 3,
            samples,
            mode,
        };
        let plain = Renderer::new(scene, Simd::detect(), settings);
        let coarsest = Acuity::new(Acuity::STEEPEST, Acuity::COARSEST).unwrap();
        let foveated = plain.with_foveation(sight, coarsest);
        let tile = tile(plain.tracer(), &view, size);
        assert!(foveated.unit(&view, tile.x, tile.y) > 1);
        let [tree, primaries] = dearest(plain.tracer(), &view, tile, samples);
        let (whole, all) = in_slices(&plain, &view, tile, u64::MAX);
        let (sparse, _) = in_slices(&foveated, &view, tile, u64::MAX);
        assert!(samples == 1 || all > 100 * tree);
        assert!(whole != sparse, "{settings:?}");
        // Its block's test; in tile mode, too, the primary rays of the block.
        let dearest = match mode {
            Mode::Single => 16 + tree,
            Mode::Tile => 16 + tree + primaries,
        };
        for steps in [1, 2, 16, 500, 20_000] {
            let (pixels, most) = in_slices(&plain, &view, tile, steps);
            assert!(pixels == whole, "{settings:?}, {view:?}, {steps}");
            assert!(
                most < steps + dearest,
                "{settings:?}, {view:?}: {most} of {steps} + {dearest}"
            );
            let (pixels, most) = in_slices(&foveated, &view, tile, steps);
            assert!(pixels == sparse, "{settings:?}, {view:?}, {steps}");
            let square = 1024 * dearest;
            assert!(
                most <= steps + square,
                "{settings:?}, {view:?}: {most} of {steps} + {dearest}"
            );
        }
    }
}
