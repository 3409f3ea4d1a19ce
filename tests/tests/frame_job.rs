//! Frames in tiles by eccentricity, within one budget.

use glam::Vec3;
use shisen::bake::{Baked, Layout};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, FlatScreen, FrameError, FrameJob, Mode, Part, Pixel, Place, Progress, Renderer, Tile,
    Workspace,
};
use shisen_tests::meshes::icosphere;
use shisen_tests::{scenes, ways};

/// Pixels a side of tiles, which cuts walls of [`SIZE`] off at their borders.
const SIDE: u32 = 16;
const SIZE: [u32; 2] = [40, 56];
const EYE: Vec3 = Vec3::new(0.1, 0.2, 0.3);

fn baked() -> Baked<4> {
    let scene = paper_scene(PaperScene::A, icosphere(3)).expect("a scene");
    let levels = scenes::levels(Layout::Compact.polygon_levels());
    Baked::with_levels(&scene, &levels).expect("a baked scene")
}

/// Returns a side of a 3 m cube, by the signs of its corners.
fn screen(lower_left: [f32; 3], lower_right: [f32; 3], upper_left: [f32; 3]) -> FlatScreen {
    let [a, b, c] = [lower_left, lower_right, upper_left].map(|at| 1.5 * Vec3::from_array(at));
    FlatScreen::from_corners(a, b, c, SIZE)
}

/// Front, right and floor.
fn screens() -> [FlatScreen; 3] {
    [
        screen([-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]),
        screen([1., -1., -1.], [1., -1., 1.], [1., 1., -1.]),
        screen([-1., -1., 1.], [1., -1., 1.], [-1., -1., -1.]),
    ]
}

/// Returns one eye's, along a line of sight or in full.
fn renderer(baked: &Baked<4>, forward: Option<Vec3>, mode: Mode) -> Renderer<'_, 4> {
    let settings = ways::settings(mode, 1);
    let mut renderer = Renderer::new(baked.scene(), Simd::detect(), settings);
    if let Some(forward) = forward {
        renderer = renderer.with_level_of_detail(scenes::lod(EYE, forward, Vec3::Y));
    }
    renderer
}

fn part<'r, 'a>(screen: &FlatScreen, renderer: &'r Renderer<'a, 4>) -> Part<'r, 'a, 4> {
    let view = screen.view_from(EYE).expect("a view");
    Part { view, renderer }
}

fn parts<'r, 'a>(renderer: &'r Renderer<'a, 4>) -> Vec<Part<'r, 'a, 4>> {
    let parts = screens().map(|screen| part(&screen, renderer));
    parts.into()
}

/// What a frame was handed over in.
struct Seen {
    tiles: Vec<(usize, Tile, bool)>,
    pictures: Vec<Vec<Pixel>>,
    calls: usize,
    steps: u64,
}

fn run(parts: &[Part<'_, '_, 4>], budget: Budget, slice: u64) -> Seen {
    let sizes = parts.iter().map(|_| SIZE);
    let mut places = vec![Place::default(); FrameJob::tiles_of(sizes, SIDE)];
    let mut job = FrameJob::new(parts, SIDE, budget, &mut places).expect("a frame");
    let unseen = Pixel {
        red: f32::NAN,
        ..Pixel::default()
    };
    let mut pictures = vec![vec![unseen; (SIZE[0] * SIZE[1]) as usize]; parts.len()];
    let mut pixels = [Pixel::default(); (SIDE * SIDE) as usize];
    let mut workspace = Workspace::new();
    let (mut tiles, mut calls) = (Vec::new(), 0);
    loop {
        calls += 1;
        let mut slice = Budget::steps(slice);
        let progress = job.render(parts, &mut pixels, &mut slice, &mut workspace);
        match progress.expect("a tile") {
            Progress::Finished => break,
            Progress::BudgetSpent => assert!(slice.is_spent()),
            Progress::Tile { part, tile, whole } => {
                tiles.push((part, tile, whole));
                let rows = pixels
                    .chunks(tile.width as usize)
                    .take(tile.height as usize);
                for (y, row) in (tile.y..).zip(rows) {
                    let start = (y * SIZE[0] + tile.x) as usize;
                    pictures[part][start..start + row.len()].copy_from_slice(row);
                }
            }
        }
    }
    let handed_over = job.tiles().whole + job.tiles().given_up;
    assert_eq!(handed_over as usize, tiles.len());
    Seen {
        tiles,
        pictures,
        calls,
        steps: workspace.statistics.steps,
    }
}

fn bits(pictures: &[Vec<Pixel>]) -> Vec<[u32; 4]> {
    scenes::bits(&pictures.concat())
}

#[test]
fn a_frame_is_its_views_rendered_whole() {
    let baked = baked();
    for forward in [None, Some(Vec3::NEG_Z), Some(Vec3::new(0.4, -1.0, -0.2))] {
        for mode in [Mode::Single, Mode::Tile] {
            let renderer = renderer(&baked, forward, mode);
            let parts = parts(&renderer);
            let seen = run(&parts, Budget::UNLIMITED, u64::MAX);
            let whole = parts
                .iter()
                .map(|Part { view, renderer }| scenes::pixels(renderer, view));
            let whole: Vec<Vec<Pixel>> = whole.collect();
            assert!(bits(&seen.pictures) == bits(&whole), "{forward:?} {mode:?}");
            assert_eq!(seen.tiles.len(), 3 * 3 * 4);
            // Without a gaze they go in rows.
            let order = seen
                .tiles
                .iter()
                .map(|(part, tile, _)| (part, tile.y, tile.x));
            assert_eq!(order.is_sorted(), forward.is_none());
            assert!(seen.tiles.iter().all(|&(.., whole)| whole));
        }
    }
}

#[test]
fn tiles_go_from_the_line_of_sight_outwards() {
    let baked = baked();
    let forward = Vec3::new(0.4, -1.0, -0.2).normalize();
    let renderer = renderer(&baked, Some(forward), Mode::Single);
    let parts = parts(&renderer);
    let seen = run(&parts, Budget::UNLIMITED, u64::MAX);
    let angle = |&(part, tile, _): &(usize, Tile, bool)| {
        let middle = |first: u32| (2 * first + SIDE - 1) as f32 / 2.0;
        let at = (middle(tile.x), middle(tile.y));
        let towards = parts[part].view.direction(at.0, at.1).expect("a direction");
        f64::from(towards.normalize().dot(forward))
            .clamp(-1.0, 1.0)
            .acos()
    };
    let angles: Vec<f64> = seen.tiles.iter().map(angle).collect();
    assert!(angles.is_sorted_by(|a, b| *a <= b + 1e-4), "{angles:?}");
    // The one that is looked at is the first: of the floor, in pixels.
    let at = EYE + forward * ((-1.5 - EYE.y) / forward.y);
    let pixel = [(at.x, SIZE[0]), (at.z, SIZE[1])];
    let [x, y] = pixel.map(|(at, all)| ((at + 1.5) / 3.0 * all as f32) as u32);
    let (part, tile, _) = seen.tiles[0];
    assert_eq!(part, 2);
    assert_eq!((x / SIDE * SIDE, y / SIDE * SIDE), (tile.x, tile.y));
}

#[test]
fn how_a_frame_is_cut_into_calls_changes_no_bit_of_it() {
    let baked = baked();
    let renderer = renderer(&baked, Some(Vec3::NEG_Z), Mode::Single);
    let parts = parts(&renderer);
    let full = run(&parts, Budget::UNLIMITED, u64::MAX);
    for share in [100, 40, 5, 0] {
        let budget = Budget::steps(full.steps * share / 100);
        let first = run(&parts, budget, u64::MAX);
        for slice in [1, 37, 1_000, 40_000] {
            let other = run(&parts, budget, slice);
            assert!(
                bits(&other.pictures) == bits(&first.pictures),
                "{share} {slice}"
            );
            assert_eq!(other.tiles, first.tiles);
            assert_eq!(other.steps, first.steps);
            assert!(slice > 1 || share == 0 || other.calls > first.calls);
        }
    }
}

#[test]
fn a_budget_that_runs_out_costs_the_rim() {
    let baked = baked();
    let renderer = renderer(&baked, Some(Vec3::NEG_Z), Mode::Single);
    let parts = parts(&renderer);
    let full = run(&parts, Budget::UNLIMITED, u64::MAX);
    let half = run(&parts, Budget::steps(full.steps / 2), 10_000);
    // One pixel more than the budget at most.
    assert!((full.steps / 2..full.steps / 2 + 5_000).contains(&half.steps));
    let whole = half.tiles.iter().filter(|(.., whole)| *whole).count();
    assert!(half.tiles[..whole].iter().all(|(.., whole)| *whole));
    assert!(whole > 0 && whole < half.tiles.len());
    let order = |seen: &Seen| {
        let places = seen.tiles.iter().map(|&(part, tile, _)| (part, tile));
        places.collect::<Vec<_>>()
    };
    assert_eq!(order(&half), order(&full));
    for &(part, tile, _) in &half.tiles[..whole] {
        for y in tile.y..tile.y + tile.height {
            let row = (y * SIZE[0] + tile.x) as usize..(y * SIZE[0] + tile.x + tile.width) as usize;
            assert_eq!(half.pictures[part][row.clone()], full.pictures[part][row]);
        }
    }
    let nothing = run(&parts, Budget::steps(0), u64::MAX);
    assert_eq!(nothing.steps, 0);
    assert!(nothing.pictures.iter().flatten().all(|p| !p.red.is_nan()));
}

#[test]
fn what_is_no_frame_is_refused() {
    let baked = baked();
    let renderer = renderer(&baked, None, Mode::Single);
    let parts = parts(&renderer);
    let mut places = [Place::default(); 36];
    let mut new = |parts: &[Part<'_, '_, 4>], side, room: usize| {
        FrameJob::new(parts, side, Budget::UNLIMITED, &mut places[..room]).err()
    };
    assert_eq!(new(&parts, SIDE, 36), None);
    for side in [0, FrameJob::LARGEST_TILE + 1, u32::MAX] {
        assert_eq!(new(&parts, side, 36), Some(FrameError::TileSize { side }));
    }
    assert_eq!(new(&[], SIDE, 36), Some(FrameError::Pictures { count: 0 }));
    let places = FrameError::Places {
        needed: 36,
        given: 35,
    };
    assert_eq!(new(&parts, SIDE, 35), Some(places));
    assert!(places.to_string().contains("36 tiles"));
}
