//! The live loop's frames: what they are, what they take, and what is never
//! missing.

use glam::{DQuat, DVec3, Vec3};
use shisen::bake::{AnyScene, Baked, Layout};
use shisen::cave::{Eye, Viewer};
use shisen::live::{
    Allowance, Engine, FrameCost, Governor, Quality, RoomPlace, Share, with_engine,
};
use shisen::picture::{Picture, colour_differences};
use shisen::render::{self, Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen_core::Simd;
use shisen_core::frame::{Renderer, Settings};
use shisen_tests::meshes::icosphere;
use shisen_tests::scenes::{self, three_walls};
use shisen_tests::sizes::cases;

const SIDE: u32 = 64;

fn baked() -> Baked<8> {
    let scene = paper_scene(PaperScene::A, icosphere(4)).expect("a scene");
    let levels = scenes::levels(Layout::Fast.polygon_levels());
    Baked::with_levels(&scene, &levels).expect("a baked scene")
}

/// Returns both eyes of one who looks from front to floor and to the right, over 60 frames.
fn eyes(frame: u32) -> Vec<Observer> {
    let part = (frame % 60) as f32 / 60.0 * std::f32::consts::TAU;
    let forward = Vec3::new(0.6 * part.sin(), -0.5 + 0.7 * part.cos(), -1.0);
    let viewer = Viewer::default();
    let observer = |eye: Eye| {
        let place = viewer.eye(eye);
        Observer {
            lod: Some(scenes::lod(place.as_vec3(), forward, Vec3::Y)),
            ..Observer::new(eye, place)
        }
    };
    Eye::STEREO.map(observer).to_vec()
}

fn options(threads: usize, tile: u32) -> Options {
    Options {
        threads,
        tile,
        ..Options::default()
    }
}

fn with<R>(baked: &Baked<8>, options: &Options, run: impl FnOnce(&mut dyn Engine) -> R) -> R {
    let scene = AnyScene::from(baked.scene());
    let (cave, eyes) = (three_walls(SIDE), eyes(0));
    with_engine(scene, &cave, &eyes, options, None, Share::ALL, run).expect("an engine")
}

/// Returns a millisecond for so many steps.
const fn taken(steps: u64) -> FrameCost {
    FrameCost {
        steps,
        seconds: 1.0e-3,
    }
}

#[test]
fn a_frame_without_a_budget_is_the_frame() {
    let baked = baked();
    let cave = three_walls(SIDE);
    with(&baked, &options(2, 24), |engine| {
        for number in [0, 17, 31] {
            let eyes = eyes(number);
            let frame = engine.render(&eyes, &Quality::FULL, None).expect("a frame");
            assert_eq!((frame.unfinished, frame.rounds), (0, 1));
            let whole = scenes::frame(baked.scene().into(), &cave, &eyes, &options(1, 32));
            assert_eq!(frame.statistics.rays(), whole.statistics.rays());
            let whole: Vec<u64> = whole
                .pictures
                .iter()
                .map(|one| one.picture.hash())
                .collect();
            assert_eq!(engine.hashes().expect("pictures"), whole);
        }
    });
}

/// Eyes behind the right wall still see the others, and all once they are back.
#[test]
fn a_wall_seen_from_behind_is_dark() {
    let baked = baked();
    let behind: Vec<Observer> = [Eye::Left, Eye::Right]
        .map(|eye| Observer::new(eye, DVec3::new(1.6, 0.1, 0.3)))
        .to_vec();
    let mut others = three_walls(SIDE);
    others.walls.retain(|wall| wall.name != "right");
    let seen = scenes::frame(baked.scene().into(), &others, &behind, &options(1, 32));
    let mut seen = seen.pictures.iter().map(|one| one.picture.hash());
    let dark = Picture::new(SIDE, SIDE).expect("a picture").hash();
    let expected: Vec<u64> = three_walls(SIDE)
        .walls
        .iter()
        .flat_map(|wall| [wall, wall])
        .map(|wall| match wall.name.as_str() {
            "right" => dark,
            _ => seen.next().expect("a picture"),
        })
        .collect();
    with(&baked, &options(2, 24), |engine| {
        let mut hashes = |eyes: &[Observer]| {
            engine.render(eyes, &Quality::FULL, None).expect("a frame");
            engine.hashes().expect("pictures")
        };
        let before = hashes(&eyes(0));
        assert_eq!(hashes(&behind), expected);
        assert_eq!(hashes(&eyes(0)), before);
    });
}

/// A room that was flown to a place shows what walls and eyes there would.
#[test]
fn a_room_that_flew_shows_what_is_seen_from_there() {
    let baked = baked();
    let place = RoomPlace {
        position: DVec3::new(-0.3, 0.4, 0.6),
        yaw: 0.4,
    };
    let turn = DQuat::from_rotation_y(place.yaw);
    let mut there = three_walls(SIDE);
    for wall in &mut there.walls {
        for corner in [
            &mut wall.lower_left,
            &mut wall.lower_right,
            &mut wall.upper_left,
        ] {
            *corner = place.point(*corner);
        }
    }
    let forward = Vec3::new(0.2, -0.3, -1.0);
    let observers = |moved: bool| {
        Eye::STEREO.map(|eye| {
            let mut at = Viewer::default().eye(eye);
            let mut ahead = forward;
            if moved {
                at = place.point(at);
                ahead = (turn * ahead.as_dvec3()).as_vec3();
            }
            Observer {
                lod: Some(scenes::lod(at.as_vec3(), ahead, Vec3::Y)),
                ..Observer::new(eye, at)
            }
        })
    };
    let whole = scenes::frame(
        baked.scene().into(),
        &there,
        &observers(true),
        &options(1, 32),
    );
    with(&baked, &options(2, 24), |engine| {
        let mut flown = Vec::new();
        engine.set_place(&place);
        engine
            .render(&observers(false), &Quality::FULL, None)
            .expect("a frame");
        engine.pictures(&mut flown, false).expect("pictures");
        for (one, other) in whole.pictures.iter().zip(&flown) {
            let apart = colour_differences(&one.picture, other);
            let far = apart.iter().filter(|one| **one > 0.02).count();
            // Edges round to the other side of a pixel's centre.
            assert!(far * 100 < apart.len(), "{far} of {}", apart.len());
        }
        let moved = engine.hashes().expect("hashes");
        engine.set_place(&RoomPlace::START);
        engine
            .render(&observers(false), &Quality::FULL, None)
            .expect("a frame");
        assert_ne!(engine.hashes().expect("hashes"), moved);
    });
}

/// What machines render of a frame is, put together, what one renders.
#[test]
fn shares_of_a_frame_are_the_frame() {
    let baked = baked();
    let cave = three_walls(SIDE);
    let whole = with(&baked, &options(2, 24), |engine| {
        engine
            .render(&eyes(17), &Quality::FULL, None)
            .expect("a frame");
        engine.hashes().expect("pictures")
    });
    for ranks in [2, 3, 6] {
        let mut together = Vec::new();
        for rank in 0..ranks {
            let share = Share::new(rank, ranks).expect("a share");
            let scene = AnyScene::from(baked.scene());
            let (eyes, options) = (eyes(17), options(1, 32));
            let own = with_engine(scene, &cave, &eyes, &options, None, share, |engine| {
                engine.render(&eyes, &Quality::FULL, None).expect("a frame");
                engine.hashes().expect("pictures")
            });
            together.extend(own.expect("an engine"));
        }
        assert_eq!(together, whole, "{ranks}");
    }
}

/// What a frame in a budget was: its steps, its tiles that are not finished, whether the fovea
/// was, and its pictures.
type Made = (u64, usize, bool, Vec<u64>);

/// Returns frames of one who looks around, whose fovea is finished always, or as far as steps go.
fn look_around(baked: &Baked<8>, threads: usize, steps: u64, whole_fovea: bool) -> Vec<Made> {
    with(baked, &options(threads, 16), |engine| {
        let mut one = |number: u32| {
            let eyes = eyes(7 * number);
            let frame = engine.render_frame(&eyes, &Quality::FULL, Some(steps), whole_fovea);
            let frame = frame.expect("a frame");
            assert_eq!(frame.steps, frame.statistics.steps);
            let hashes = engine.hashes().expect("pictures");
            (
                frame.steps,
                frame.unfinished,
                !frame.unfinished_fovea,
                hashes,
            )
        };
        (0..6).map(&mut one).collect()
    })
}

#[test]
fn a_budget_is_kept_and_threads_change_nothing() {
    let baked = baked();
    // From less than a tile's to more than all.
    for steps in [1, 3_000, 20_000, 60_000, 150_000, 10_000_000] {
        let one = look_around(&baked, 1, steps, false);
        for threads in [2, 5] {
            assert_eq!(one, look_around(&baked, threads, steps, false), "{steps}");
        }
        assert!(one.iter().all(|frame| frame.0 <= steps), "{steps}");
        // What is not finished is at the rim, and little or nothing where all fits.
        let all = one.iter().all(|frame| frame.1 == 0);
        assert_eq!(all, steps == 10_000_000);
    }
}

/// Where time is short, what is looked at is there all the same; and where steps are
/// enough, nothing is different.
#[test]
fn a_fovea_is_whole_whatever_there_is() {
    let baked = baked();
    for steps in [0, 1, 3_000, 20_000, 10_000_000] {
        let whole = look_around(&baked, 1, steps, true);
        assert_eq!(whole, look_around(&baked, 3, steps, true), "{steps}");
        assert!(whole.iter().all(|frame| frame.2), "{steps}");
        let as_far = look_around(&baked, 2, steps, false);
        if steps < 3_000 {
            assert!(as_far.iter().all(|frame| !frame.2), "{steps}");
            // No more than that.
            assert!(whole.iter().all(|frame| frame.1 > 0), "{steps}");
        }
        if steps > 1_000_000 {
            assert_eq!(whole, as_far);
        }
    }
}

/// Rounds cost time: threads wait for each other at the end of each.
#[test]
fn a_steady_gaze_needs_one_round() {
    let baked = baked();
    with(&baked, &options(2, 16), |engine| {
        let full = engine.render(&eyes(0), &Quality::FULL, None);
        let steps = full.expect("a frame").steps;
        let mut frame = |number: u32, quality: &Quality| {
            let frame = engine.render(&eyes(number), quality, Some(2 * steps));
            let frame = frame.expect("a frame");
            assert!(frame.unfinished == 0, "{number}: {frame:?}");
            frame.rounds
        };
        for _ in 0..4 {
            assert_eq!(frame(0, &Quality::FULL), 1);
        }
        // Elsewhere, or otherwise, what is looked at comes first.
        assert!(frame(20, &Quality::FULL) > 1);
        assert_eq!(frame(20, &Quality::FULL), 1);
        assert!(frame(20, &Quality::LADDER[2]) > 1);
        assert_eq!(frame(20, &Quality::LADDER[2]), 1);
    });
}

/// One who looks around, whose frames are governed by steps: from the qualities to the
/// pixels all is the same on any number of threads.
#[test]
fn half_of_what_is_needed_finishes_what_is_looked_at() {
    let baked = baked();
    let count = cases("frames at half of the need", 100, 500) as u32;
    let run = |threads: usize| {
        with(&baked, &options(threads, 16), |engine| {
            let need = |frame: u32, engine: &mut dyn Engine| {
                let frame = engine.render(&eyes(frame), &Quality::FULL, None);
                frame.expect("a frame").steps
            };
            let mut needs: Vec<u64> = (0..60)
                .step_by(4)
                .map(|frame| need(frame, engine))
                .collect();
            needs.sort_unstable();
            let steps = needs[7] / 2;
            let mut governor = Governor::default();
            let mut frames = Vec::new();
            for number in 0..count {
                let sight = eyes(number)[0].lod.map(|lod| lod.gaze.line_of_sight());
                governor.follow(sight.map(|sight| sight.forward()));
                let decision = governor.decide(Allowance::Steps(steps));
                let frame = engine.render(&eyes(number), decision.quality(), decision.steps);
                let frame = frame.expect("a frame");
                assert!(frame.steps <= steps, "frame {number}: {}", frame.steps);
                assert!(!frame.unfinished_fovea, "frame {number}: {frame:?}");
                governor.learn(&decision, frame.need, taken(frame.steps));
                let pictures = if number % 10 == 0 {
                    engine.hashes().expect("pictures")
                } else {
                    Vec::new()
                };
                frames.push((decision.rung, frame.steps, frame.unfinished, pictures));
            }
            frames
        })
    };
    let frames = run(2);
    assert_eq!(frames, run(3));
    // It binds, and quality seldom changes: the viewer looks around once in 60
    // frames, and needs twice as much at one place as at another.
    assert!(frames[frames.len() - 1].0 > 0);
    let changes = frames
        .windows(2)
        .filter(|pair| pair[0].0 != pair[1].0)
        .count();
    let unfinished = frames.iter().filter(|frame| frame.2 > 0).count();
    assert!(changes * 10 < frames.len(), "{changes} changes");
    assert!(unfinished * 20 < frames.len(), "{unfinished} unfinished");
}

#[test]
fn fewer_faces_are_those_of_a_level() {
    let baked = baked();
    let cave = three_walls(SIDE);
    let wall = cave.screens().next().expect("a wall");
    let left = &eyes(3)[0];
    let view = render::view(wall, left).expect("a view");
    let lod = left.lod.expect("a level of detail");
    let plain = Renderer::<8>::new(baked.scene(), Simd::detect(), Settings::default());
    let last = baked.scene().rungs() - 1;
    let half = last.div_ceil(2);
    for (level, fewest) in [(1.0, 0), (0.5, half), (0.0, last), (-1.0, last), (2.0, 0)] {
        let fewer = plain.with_faces_of_level(level);
        let [own, full] = [&fewer, &plain].map(|one| one.with_level_of_detail(lod));
        let mut lowered = 0;
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            assert_eq!(fewer.detail(&view, x, y).expect("a pixel").rung, fewest);
            let (own, full) = (own.detail(&view, x, y), full.detail(&view, x, y));
            let Some((own, full)) = own.zip(full) else {
                assert_eq!(own, full);
                continue;
            };
            assert_eq!((own.depth, own.rung), (full.depth, full.rung.max(fewest)));
            lowered += u32::from(own.rung > full.rung);
        }
        assert_eq!(lowered > 0, fewest > 0, "{lowered}");
    }
}
