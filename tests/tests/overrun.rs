//! Budgets of which not a step more is taken, whatever has been begun.

use crate::determinism::{SIDE, glass_and_mirrors, view};
use glam::{DVec3, Vec3};
use shisen::bake::Baked;
use shisen::scene::Light;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, DomePose, DomeProjection, FrameJob, Mode, Outcome, Part, Pixel, Place, Progress,
    Renderer, Settings, Spectrum, TileJob, View, Workspace,
};
use shisen_core::gaze::Acuity;
use shisen_core::spectrum::{Matching, Medium, SpectralSample, SpectralTable, Wavelengths};
use shisen_tests::{scenes, ways};
use std::f32::consts::PI;

/// Mirrors, glass that disperses, soft light.
fn scene() -> shisen::scene::Scene {
    let mut scene = glass_and_mirrors();
    for material in &mut scene.materials {
        if material.transmission != [0.0; 3] {
            material.medium = Some(Medium::SF11);
        }
    }
    scene.lights.push(Light::Rectangle {
        centre: DVec3::new(0.0, 1.4, 0.0),
        right: DVec3::X * 0.3,
        up: DVec3::Z * 0.3,
        colour: [1.0; 3],
        samples: 8,
        two_sided: true,
    });
    scene
}

fn views() -> [View; 2] {
    let fisheye = DomeProjection::Equidistant { field_of_view: PI };
    let dome = View::dome(
        fisheye,
        DomePose::over_room(Vec3::new(0.01, 0.02, 0.03)),
        SIDE,
    );
    [view(), dome.expect("a dome master")]
}

/// Returns all ways in which pixels are made.
fn renderers<'a>(baked: &'a Baked<8>, spectrum: Spectrum<'a>) -> Vec<Renderer<'a>> {
    let lod = scenes::lod(Vec3::ZERO, Vec3::new(0.3, -0.2, -1.0), Vec3::Y);
    let mut all = Vec::new();
    for (mode, samples) in [
        (Mode::Single, 1),
        (Mode::Tile, 1),
        (Mode::Single, 3),
        (Mode::Tile, 9),
    ] {
        let settings = ways::settings(mode, samples);
        let plain = Renderer::new(baked.scene(), Simd::detect(), settings);
        let plain = plain.with_spectrum(spectrum).expect("known media");
        let acuity = Acuity::GUENTER.steeper(6.0);
        all.extend([
            plain,
            plain.with_level_of_detail(lod),
            plain.with_foveation(lod.gaze.line_of_sight(), acuity),
        ]);
    }
    all
}

/// Returns the pixels of a tile that ends where a job is now.
fn same_cut_off(renderer: &Renderer<'_>, view: &View, job: &TileJob) -> Vec<Pixel> {
    let tile = job.tile();
    let mut pixels = vec![Pixel::default(); (tile.width * tile.height) as usize];
    let (mut cut, mut workspace) = (TileJob::cut(tile, job.kept()), Workspace::new());
    let mut unlimited = Budget::UNLIMITED;
    let outcome = cut.render(renderer, view, &mut pixels, &mut unlimited, &mut workspace);
    assert_eq!(outcome, Ok(Outcome::Finished));
    assert!(job.kept() > 0 || workspace.statistics.steps == 0);
    cut.give_up(renderer, view, &mut pixels).expect("a tile");
    pixels
}

/// Calls a job with more and more steps until it is finished, and looks at what each call
/// took and left.
fn finish(renderer: &Renderer<'_>, view: &View, (steps, overrun): (u64, u64)) -> (Vec<Pixel>, u64) {
    let tile = scenes::tile([3, 2, SIDE - 5, SIDE - 2]);
    let count = (tile.width * tile.height) as usize;
    let mut nothing = vec![Pixel::default(); count];
    let given_up = TileJob::new(tile).give_up(renderer, view, &mut nothing);
    given_up.expect("a tile");
    let mut pixels = vec![Pixel::default(); count];
    let mut seen = Vec::new();
    let (mut job, mut workspace) = (TileJob::new(tile), Workspace::new());
    let (mut broken_off, mut more) = (0, 0);
    loop {
        let before = (job, workspace.statistics.steps);
        let mut budget = Budget::steps(steps).with_overrun(overrun + more);
        let allowed = steps.saturating_add(overrun + more);
        let outcome = job.render(renderer, view, &mut pixels, &mut budget, &mut workspace);
        let spent = workspace.statistics.steps - before.1;
        assert!(spent <= allowed, "{spent} of {allowed}");
        assert_eq!(budget.left(), steps.saturating_sub(spent));
        assert_eq!(budget.is_exhausted(), spent == allowed);
        let outcome = outcome.expect("a tile of the view");
        broken_off += u64::from(budget.is_exhausted());
        // What there is when it is given up here.
        let mut now = pixels.clone();
        let mut rest = job;
        let given_up = rest.give_up(renderer, view, &mut now);
        given_up.expect("a tile");
        if seen.len().is_power_of_two() {
            assert!(same_cut_off(renderer, view, &job) == now, "{job:?}");
        }
        seen.push(now);
        if outcome == Outcome::Finished {
            break;
        }
        assert!(budget.is_spent(), "stopped with budget left");
        // What takes more than there is is begun anew, with more.
        more = if job == before.0 { 2 * more + 50 } else { 0 };
    }
    for now in seen {
        for ((now, whole), nothing) in now.iter().zip(&pixels).zip(&nothing) {
            assert!(now == whole || now == nothing, "a part of a pixel");
        }
    }
    (pixels, broken_off)
}

#[test]
fn not_a_step_more_is_taken_and_no_pixel_is_a_part_of_itself() {
    let baked = Baked::<8>::new(&scene()).expect("a scene");
    // Wavelengths for glass.
    let mut storage = vec![SpectralSample::default(); SpectralTable::MOST_SAMPLES];
    let wavelengths = Wavelengths::new(5, Wavelengths::RANGE).expect("a range");
    let table = SpectralTable::new(wavelengths, 4, Matching::Wyman, &mut storage);
    let table = table.expect("a table");
    let spectrum = Spectrum::Comb { table, each: 5 };
    let mut broken_off = 0;
    for (number, renderer) in renderers(&baked, spectrum).iter().enumerate() {
        for view in views() {
            let (whole, none) = finish(renderer, &view, (u64::MAX, 0));
            assert_eq!(none, 0);
            for budget in [(1, 40), (300, 17), (5_000, 0)] {
                let (pixels, broken) = finish(renderer, &view, budget);
                assert!(pixels == whole, "{number}, {view:?}, {budget:?}");
                broken_off += broken;
            }
        }
    }
    assert!(broken_off > 500, "{broken_off}");
}

/// A frame's budget is kept, too, and a slice's.
#[test]
fn frames_and_slices_take_not_a_step_more() {
    let baked = Baked::<8>::new(&glass_and_mirrors()).expect("a scene");
    let [screen, dome] = views();
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let parts = [screen, dome].map(|view| Part {
        view,
        renderer: &renderer,
    });
    let sizes = [[SIDE; 2]; 2];
    let frame = |budget: Budget, slice: Budget| {
        let mut places = vec![Place::default(); FrameJob::tiles_of(sizes.into_iter(), 16)];
        let mut job = FrameJob::new(&parts[..], 16, budget, &mut places).expect("a frame");
        let mut pixels = [Pixel::default(); 256];
        let mut workspace = Workspace::new();
        loop {
            let before = workspace.statistics.steps;
            let mut left = slice;
            let progress = job.render(&parts[..], &mut pixels, &mut left, &mut workspace);
            let spent = workspace.statistics.steps - before;
            let most = slice.left().saturating_add(100);
            assert!(spent <= most, "{spent} in a slice");
            if progress.expect("a tile") == Progress::Finished {
                return (workspace.statistics.steps, job.tiles());
            }
        }
    };
    let slice = Budget::steps(3_000).with_overrun(100);
    let (all, tiles) = frame(Budget::UNLIMITED, Budget::UNLIMITED);
    assert_eq!(tiles.given_up, 0);
    for share in 1..10 {
        let steps = all * share / 10;
        let budget = Budget::steps(steps).with_overrun(50);
        let (spent, tiles) = frame(budget, slice);
        assert!(spent <= steps + 50, "{spent} of {steps}");
        assert!(
            tiles.given_up > 0 && (tiles.whole > 0 || share < 3),
            "{tiles:?}"
        );
    }
}
