//! What a frame lacks with fewer steps than it needs.

use super::frames::{Room, Way, baked, pictures};
use super::gaze::{NOT_MISSED, UNSEEN};
use super::metrics::MEASURES;
use super::{Bench, Cause, Comparison, Point, Section, TilePrice, measure, timed};
use colorous::VIRIDIS;
use shisen::picture::Picture;
use shisen::render::{self, Frame};
use shisen_core::frame::{
    Budget, FrameJob, Part, Pixel, Place, Progress, Renderer, Spectrum, View, Workspace,
};
use std::collections::BTreeMap;

/// Pixels a side of a tile.
const TILE: u32 = 16;

// Longer than 80 lines: half of it is the report.
pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let size = bench.effort.pick(128, 256);
    let room = Room::new(bench, size)?;
    let baked = baked(bench)?;
    let truth = room.frame(&baked, &Way::PAPER)?;
    let mut views = Vec::new();
    for (view, observer) in room.views(Way::PAPER.lod)? {
        let scene = baked.scene();
        views.push((
            view,
            render::renderer(&scene, &observer, &room.options, Spectrum::Rgb)?,
        ));
    }
    let need = render(&views, Budget::UNLIMITED, u64::MAX)?.steps;
    let dearest = dearest(&views)?;
    let shares: &[u32] = bench.effort.pick(
        &[1, 5, 10, 20, 35, 50, 70, 90, 100, 102, 200],
        &[
            1, 2, 5, 10, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90, 95, 100, 101, 102, 110, 150, 200,
        ],
    );
    let steps = |share: u32| need * u64::from(share) / 100;
    let measured = bench.in_turns(shares, (0.0, 1.0), |&share| {
        let (seconds, done) = timed(|| render_within(&views, steps(share), dearest));
        Ok((seconds, done?))
    })?;
    let mut points = Vec::new();
    // The least share with which each tile was whole.
    let mut whole: BTreeMap<TilePlace, u32> = BTreeMap::new();
    for (&share, time) in shares.iter().zip(measured) {
        let done = &time.first;
        let mut lacking = 0.0;
        for &tile in &done.tiles {
            if is_equal(done, &truth, tile) {
                whole.entry(tile).or_insert(share);
            } else {
                lacking += 1.0 / done.tiles.len() as f64;
            }
        }
        let mut errors = room.error(done.pictures.iter(), &truth).errors();
        errors.push(Some(100.0 * lacking));
        errors.push(Some(100.0 * done.steps as f64 / steps(share).max(1) as f64));
        let settings = [
            ("budget_percent", share.into()),
            ("budget_steps", steps(share).into()),
            ("set_aside_steps", set_aside(dearest).into()),
        ];
        let point = Point::new("share of what is needed", format!("{share} %"), settings);
        points.push(point.measured(errors, &time, Some(done.steps)));
    }
    let mut measures = MEASURES.to_vec();
    measures.push(measure("lacking_percent", "tiles that lack something, %"));
    measures.push(measure("spent_percent", "taken of what it may, %"));
    let comparison = Comparison::new(
        ("budgets", "How many steps a frame may take"),
        "A budget ends at the first pixel beyond it; the rest of the frame costs next to nothing. \
         Above the need and the steps set aside nothing changes: at 100 % the last pixels may still \
         be missing.",
        measures,
        UNSEEN,
        points,
    )
    .with_other_limit(NOT_MISSED)
    .logarithmic();
    let about = about(size, need, dearest);
    let mut section = Section::new("budget", "Steps of a frame", about, vec![comparison]);
    let price = |(&(picture, x, y), &percent): (&TilePlace, &u32)| TilePrice {
        picture,
        x,
        y,
        percent,
    };
    section.tiles = whole.iter().map(price).collect();
    let cut = render_within(&views, steps(35), dearest)?;
    let truth: Vec<Picture> = pictures(&truth).cloned().collect();
    for (caption, pictures) in [
        (
            "Which tiles pay, the left eye's walls unfolded: the share of the steps with which a \
             tile shows all that it should, from dark violet, 1 %, to yellow, 100 %. Where there \
             is nothing but background it never lacks anything",
            map(&views, &whole)?,
        ),
        ("With 35 % of the steps", cut.pictures),
        ("With all of them", truth),
    ] {
        let picture = room.unfold(&pictures)?;
        section.pictures.push((caption.to_owned(), picture));
    }
    Ok(section)
}

fn about(size: u32, need: u64, dearest: u64) -> String {
    format!(
        "The frame of the first section by the paper's levels, {size}² pixels a wall, on one \
         thread. It needs {need} steps and may take a share of them, tiles of {TILE}² pixels from \
         the line of sight outwards; tiles that get no steps show the background. A pixel once \
         begun is finished, with up to {dearest} steps here (the dearest pixel with the rays of its \
         block). All but one of these are set aside, {:.2} % of the need, so that no frame takes \
         more than it may. The truth is the same frame with all steps. Rings are those of the \
         walls' own pixels.",
        100.0 * set_aside(dearest) as f64 / need.max(1) as f64,
    )
}

fn map(
    views: &[(View, Renderer<'_>)],
    whole: &BTreeMap<TilePlace, u32>,
) -> Result<Vec<Picture>, Cause> {
    let mut map = Vec::new();
    for (number, (view, _)) in views.iter().enumerate() {
        let mut picture = Picture::new(view.columns(), view.rows())?;
        for (&(part, x, y), &share) in whole.range((number, 0, 0)..(number + 1, 0, 0)) {
            debug_assert_eq!(part, number);
            let colour = viridis(f64::from(share.min(100)) / 100.0);
            for (x, y) in (y..y + TILE).flat_map(|y| (x..x + TILE).map(move |x| (x, y))) {
                picture.set_pixel(x, y, colour);
            }
        }
        map.push(picture);
    }
    Ok(map)
}

/// A tile by its picture and its first column and row.
type TilePlace = (usize, u32, u32);

fn is_equal(done: &Done, truth: &Frame, (part, x, y): TilePlace) -> bool {
    let (found, truth) = (&done.pictures[part], &truth.pictures[part].picture);
    let mut pixels = (y..y + TILE).flat_map(|y| (x..x + TILE).map(move |x| (x, y)));
    pixels.all(|(x, y)| found.pixel(x, y) == truth.pixel(x, y))
}

struct Done {
    pictures: Vec<Picture>,
    tiles: Vec<TilePlace>,
    steps: u64,
    /// The most steps of a call.
    dearest: u64,
}

/// Returns the steps that a frame leaves untouched, for the work that it finishes after the others.
const fn set_aside(dearest: u64) -> u64 {
    dearest.saturating_sub(1)
}

/// Renders a frame that takes no more than `steps`.
fn render_within(views: &[(View, Renderer<'_>)], steps: u64, dearest: u64) -> Result<Done, Cause> {
    let budget = Budget::steps(steps.saturating_sub(set_aside(dearest)));
    render(views, budget, u64::MAX)
}

/// Returns the most steps from the end of a budget to the end of the work begun: in slices of one
/// step each pixel has a call of its own, with the rays of its block where it is the first.
fn dearest(views: &[(View, Renderer<'_>)]) -> Result<u64, Cause> {
    Ok(render(views, Budget::UNLIMITED, 1)?.dearest)
}

/// Renders a frame on this thread as firmware does, tile by tile, in calls of `slice` steps.
fn render(views: &[(View, Renderer<'_>)], budget: Budget, slice: u64) -> Result<Done, Cause> {
    let parts: Vec<Part<'_, '_>> = views
        .iter()
        .map(|(view, renderer)| Part {
            view: *view,
            renderer,
        })
        .collect();
    let sizes = views.iter().map(|(view, _)| [view.columns(), view.rows()]);
    let mut pictures = Vec::new();
    for [columns, rows] in sizes.clone() {
        pictures.push(Picture::new(columns, rows)?);
    }
    let mut places = vec![Place::NONE; FrameJob::tiles_of(sizes, TILE)];
    let mut pixels = vec![Pixel::default(); (TILE * TILE) as usize];
    let mut workspace = Workspace::new();
    let mut job = FrameJob::new(&parts[..], TILE, budget, &mut places)?;
    let mut tiles = Vec::new();
    let mut dearest = 0;
    loop {
        let (mut slice, before) = (Budget::steps(slice), workspace.statistics.steps);
        let progress = job.render(&parts[..], &mut pixels, &mut slice, &mut workspace)?;
        dearest = dearest.max(workspace.statistics.steps - before);
        match progress {
            Progress::Tile { part, tile, .. } => {
                tiles.push((part, tile.x, tile.y));
                let rows = pixels.chunks_exact(tile.width as usize);
                for (y, row) in (tile.y..tile.y + tile.height).zip(rows) {
                    for (x, pixel) in (tile.x..).zip(row) {
                        let colour = [pixel.red, pixel.green, pixel.blue, pixel.alpha];
                        pictures[part].set_pixel(x, y, colour);
                    }
                }
            }
            Progress::BudgetSpent => {}
            Progress::Finished => break,
        }
    }
    Ok(Done {
        pictures,
        tiles,
        steps: workspace.statistics.steps,
        dearest,
    })
}

/// Returns the linear colour of a value from 0 to 1.
fn viridis(value: f64) -> [f32; 4] {
    let colour = VIRIDIS.eval_continuous(value);
    let linear = |channel: u8| (f32::from(channel) / 255.0).powf(2.2);
    [linear(colour.r), linear(colour.g), linear(colour.b), 1.0]
}
