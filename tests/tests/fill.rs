//! What shows where the gaze skips rays.

use glam::{DVec3, Vec3};
use shisen::bake::simplify::PolygonLevels;
use shisen::bake::{AnyScene, Baked};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::live::{Engine, Quality, Share, with_engine};
use shisen::render::{self, CaptureOptions, Filling, Frame, Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::quadruped::quadruped;
use shisen_core::Simd;
use shisen_core::frame::{BLEND, Mode};
use shisen_tests::scenes;
use shisen_tests::ways::options;

const SIZE: u32 = 64;

struct Setting {
    baked: Baked<8>,
    cave: Cave,
    eyes: [Observer; 2],
}

impl Setting {
    fn new() -> Self {
        let scene = paper_scene(PaperScene::A, quadruped()).expect("a scene");
        let levels = PolygonLevels::new(200..=1_000, 4).expect("levels");
        Self {
            baked: Baked::with_levels(&scene, &levels).expect("a scene"),
            cave: Cave::built_in(BuiltInCave::Cube, [SIZE; 2]).expect("a room"),
            eyes: Self::eyes(Vec3::new(0.2, -0.3, -1.0)),
        }
    }

    fn eyes(forward: Vec3) -> [Observer; 2] {
        let lod = scenes::lod(Vec3::ZERO, forward, Vec3::Y);
        let viewer = Viewer::default();
        Eye::STEREO.map(|eye| Observer {
            lod: Some(lod),
            ..Observer::new(eye, viewer.eye(eye))
        })
    }

    fn frame(&self, options: &Options, filling: Filling<'_>) -> Frame {
        let scene = self.baked.scene().into();
        let (cave, eyes) = (&self.cave, &self.eyes);
        render::cave_filled(scene, cave, eyes, options, filling, &|_, _| {}).expect("a frame")
    }

    /// The level of each pixel and its colours in some frames.
    fn pixels<const N: usize>(&self, frames: [&Frame; N], mut of: impl FnMut(f32, [[f32; 4]; N])) {
        let views = self.cave.walls.iter().flat_map(|wall| {
            let eyes = self.eyes.iter();
            eyes.map(move |eye| (render::view(wall, eye).expect("a view"), eye))
        });
        for (number, (view, eye)) in views.enumerate() {
            for (x, y) in (0..SIZE * SIZE).map(|i| (i % SIZE, i / SIZE)) {
                let direction = view.direction(x as f32, y as f32).expect("a wall's");
                let level = eye.lod.and_then(|lod| lod.gaze.level(direction));
                let pixel = |frame: &Frame| frame.pictures[number].picture.pixel(x, y);
                let pixels = frames.map(|frame| pixel(frame).expect("a pixel"));
                of(level.expect("a level"), pixels);
            }
        }
    }
}

const HOW: CaptureOptions = CaptureOptions {
    size: 64,
    level: 0.34,
    steps: None,
};

const CAPTURE: Filling<'static> = Filling::Capture(HOW);

const fn capture(size: u32, level: f32, steps: Option<u64>) -> Filling<'static> {
    Filling::Capture(CaptureOptions { size, level, steps })
}

#[test]
fn only_what_the_gaze_skips_is_filled_and_its_border_blended() {
    let setting = Setting::new();
    let options = Options::default();
    let plain = setting.frame(&options, Filling::Background);
    let filled = setting.frame(&options, CAPTURE);
    let (mut kept, mut blended, mut changed) = (0, 0, 0);
    setting.pixels([&plain, &filled], |level, [plain, filled]| {
        if level >= BLEND {
            assert_eq!(plain, filled, "level {level}");
            kept += 1;
        } else if level > 0.0 {
            blended += u32::from(plain != filled);
        } else {
            changed += u32::from(plain != filled);
        }
    });
    assert!(
        kept > 1000 && blended > 100 && changed > 1000,
        "{kept} {blended} {changed}"
    );
    let capture = filled.capture.expect("a capture");
    assert!(capture.statistics.primary > 0 && plain.capture.is_none());
    let (with, without) = (filled.statistics, plain.statistics);
    assert_eq!(with.steps, without.steps + capture.statistics.steps);
    assert_eq!(with.primary, without.primary + capture.statistics.primary);
}

#[test]
fn there_is_no_hole_and_no_seam_in_a_capture() {
    // A sky of one colour: whatever shows is that colour.
    let mut setting = Setting::new();
    let mut scene = paper_scene(PaperScene::A, quadruped()).expect("a scene");
    scene.objects.truncate(1);
    scene.objects[0].world_from_object.translation = DVec3::new(0.0, 0.0, -50.0);
    scene.background = shisen::scene::Background::uniform([0.25, 0.5, 0.75]);
    setting.baked = Baked::new(&scene).expect("a scene");
    for size in [8, 33, 64] {
        let capture = CaptureOptions {
            size,
            ..CaptureOptions::default()
        };
        let frame = setting.frame(&Options::default(), Filling::Capture(capture));
        setting.pixels([&frame], |level, [pixel]| {
            if level < BLEND {
                let off = [0.25, 0.5, 0.75, 1.0];
                let off = pixel.iter().zip(off).map(|(a, b)| (a - b).abs());
                assert!(off.fold(0.0, f32::max) < 1e-5, "{size}: {pixel:?}");
            }
        });
    }
}

#[test]
fn a_filled_frame_is_the_same_bits_however_it_is_made() {
    let setting = Setting::new();
    for steps in [None, Some(20_000)] {
        let capture = capture(48, 0.5, steps);
        let first = setting.frame(&options(1, 32, Mode::Tile, Simd::detect()), capture);
        let mut others = vec![
            options(3, 32, Mode::Tile, Simd::detect()),
            options(1, 19, Mode::Tile, Simd::detect()),
            options(1, 32, Mode::Tile, Simd::PORTABLE),
        ];
        if steps.is_none() {
            others.push(options(1, 32, Mode::Single, Simd::detect()));
        }
        for other in others {
            let found = setting.frame(&other, capture);
            assert_eq!(found.hash(), first.hash(), "{other:?}");
        }
    }
}

/// With all the steps that it takes; and again after frames in which only parts of the
/// surroundings were taken, and those with less detail. Along the room's axes, which
/// the live loop captures along whatever the gaze.
#[test]
fn the_live_loop_fills_as_one_frame_does() {
    let setting = Setting {
        eyes: Setting::eyes(Vec3::NEG_Z),
        ..Setting::new()
    };
    let options = Options::default();
    let once = setting.frame(&options, CAPTURE);
    let once: Vec<u64> = once.pictures.iter().map(|one| one.picture.hash()).collect();
    let scene = AnyScene::from(setting.baked.scene());
    let (cave, eyes) = (&setting.cave, &setting.eyes);
    let live = |engine: &mut dyn Engine| {
        for (quality, steps, same) in [
            (Quality::FULL, None, true),
            (Quality::LADDER[4], Some(u64::MAX), false),
            (Quality::LADDER[13], Some(u64::MAX), false),
            (Quality::FULL, Some(u64::MAX), true),
            (Quality::LADDER[13], Some(40_000), false),
            (Quality::FULL, None, true),
        ] {
            let frame = engine.render(eyes, &quality, steps).expect("a frame");
            assert!(steps.is_none_or(|steps| frame.steps <= steps));
            let hashes = engine.hashes().expect("pictures");
            assert_eq!(hashes == once, same, "{quality:?}, {steps:?}");
        }
    };
    with_engine(scene, cave, eyes, &options, Some(HOW), Share::ALL, live).expect("an engine");
}

#[test]
fn a_capture_keeps_to_its_steps() {
    let setting = Setting::new();
    let options = Options::default();
    let steps = |steps| {
        let frame = setting.frame(&options, capture(64, 0.34, steps));
        frame.capture.expect("a capture").statistics.steps
    };
    let needed = steps(None);
    // What tiles leave is passed on: most of a limit is used, and little more.
    for share in [4, 2] {
        let limit = needed / share;
        let used = steps(Some(limit));
        let range = limit * 9 / 10..limit * 5 / 4;
        assert!(range.contains(&used), "{used} of {limit}");
    }
    let enough = steps(Some(2 * needed));
    // A block that was interrupted goes on ray by ray.
    assert!(enough.abs_diff(needed) < needed / 10, "{enough} {needed}");
    assert_eq!(steps(Some(0)), 0);
}
