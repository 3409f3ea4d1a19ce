use super::*;
use crate::cave::{BuiltInCave, Eye, Viewer};
use crate::live::{Share, eyes_of};
use crate::show::stereo::anaglyph;
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};

const SIDE: u32 = 64;

fn light(screen: usize, eye: usize) -> [f32; 4] {
    [0.2 * screen as f32 + 0.1, 0.5 * eye as f32, 0.3, 1.0]
}

fn colour([red, green, blue, _]: [f32; 4]) -> Colour {
    place_map::colour([red, green, blue])
}

fn cave() -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).unwrap()
}

fn frame(forward: Vec3) -> Frame {
    let (cave, viewer) = (cave(), Viewer::default());
    let eyes = Eye::STEREO.map(|eye| {
        let place = viewer.eye(eye);
        let sight = LineOfSight::new(place.as_vec3(), forward, Vec3::Y).unwrap();
        let gaze = Gaze::new(sight, VisualField::PAPER);
        Observer {
            lod: Some(LevelOfDetail::new(gaze)),
            ..Observer::new(eye, place)
        }
    });
    let pictures = eyes_of(&cave, &eyes, Share::ALL).map(|(screen, eye)| {
        let eye = Eye::STEREO.iter().position(|one| *one == eye).unwrap();
        let pixels = vec![light(screen, eye); (SIDE * SIDE) as usize];
        Picture::from_pixels(SIDE, SIDE, pixels).unwrap()
    });
    let pictures: Vec<_> = pictures.collect();
    let tile = Tile {
        x: 32,
        y: 0,
        width: 32,
        height: 32,
    };
    let tiles = (0..pictures.len()).map(|picture| (picture, tile));
    Frame {
        about: Arc::new(About {
            hz: 50,
            ..About::default()
        }),
        tiles: tiles.collect(),
        pictures,
        eyes: eyes.to_vec(),
        head: HeadPose::IDENTITY,
        record: FrameRecord {
            forward: forward.to_array(),
            state: "fresh",
            budget_steps: Some(1_000),
            steps: 500,
            need_steps: 750,
            ..FrameRecord::default()
        },
        latencies: Vec::new(),
    }
}

fn drawn(dashboard: &mut Dashboard<'_>, frame: &Frame, turn: usize) -> Canvas {
    let [width, height] = Dashboard::SIZE;
    let mut canvas = Canvas::new(width, height);
    let status = Status::default();
    dashboard.draw(&mut canvas, frame, &status, turn).unwrap();
    canvas
}

fn count(canvas: &Canvas, wanted: Colour) -> usize {
    let pixels = canvas.pixels().iter();
    pixels.filter(|&&pixel| pixel == wanted).count()
}

#[test]
fn each_eye_is_where_its_format_has_it() {
    let (cave, frame) = (cave(), frame(Vec3::NEG_Z));
    let [width, height] = Dashboard::SIZE;
    let walls = height - HEADER - gauges::ROWS;
    let [left, right] = [0, 1].map(|eye| colour(light(0, eye)));
    let draw = |stereo, turn| drawn(&mut Dashboard::new(&cave, stereo).unwrap(), &frame, turn);
    let mono = draw(Stereo::Mono, 0);
    assert!(count(&mono, left) > 40_000 && count(&mono, right) == 0);
    for (stereo, half) in [
        (Stereo::SideBySide, [width / 2, height]),
        (Stereo::TopBottom, [width, HEADER + walls / 2]),
    ] {
        let canvas = draw(stereo, 0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let pixel = canvas.pixel(x, y).unwrap();
            let is_first = x < half[0] && y < half[1];
            let wrong = if is_first { right } else { left };
            assert_ne!(pixel, wrong, "{stereo}: {x} {y}");
        }
        let counts = [count(&canvas, left), count(&canvas, right)];
        assert!(counts[0] > 5_000 && counts[1].abs_diff(counts[0]) < counts[0] / 50);
    }
    let glasses = draw(Stereo::Anaglyph, 0);
    let both = colour(anaglyph(light(0, 0), light(0, 1)));
    assert!(count(&glasses, both) > 40_000 && count(&glasses, left) == 0);
    let turns = [0, 1].map(|turn| draw(Stereo::Sequential, turn));
    let counts = turns.map(|canvas| [left, right].map(|eye| count(&canvas, eye) > 0));
    assert_eq!(counts, [[true, false], [false, true]]);
}

#[test]
fn the_gaze_is_marked_and_the_mouse_points_at_it() {
    let cave = cave();
    let [width, height] = Dashboard::SIZE;
    for view in [ViewName::Net, ViewName::Viewer] {
        for forward in [Vec3::NEG_Z, Vec3::new(0.3, -0.2, -1.0)] {
            let frame = frame(forward);
            let mut dashboard = Dashboard::new(&cave, Stereo::Mono).unwrap();
            dashboard.view = view;
            let canvas = drawn(&mut dashboard, &frame, 0);
            // The cross is 21 pixels wide, and nothing else there is white.
            let white = |x: u32, y: u32| canvas.pixel(x, y) == Some(0xFF_FFFF);
            let line = |x: u32, y: u32| (x..x + 21).all(|x| white(x, y));
            let row = (HEADER + 20..height - gauges::ROWS - 20)
                .find(|&y| (0..width - 21).any(|x| line(x, y)));
            let row = row.expect("a cross");
            let left = (0..width).find(|&x| line(x, row)).unwrap();
            let direction = dashboard.direction(left + 10, row, &frame);
            let apart = direction.unwrap().angle_between(forward);
            assert!(apart < 0.02, "{view:?} {forward}: {apart}");
        }
    }
}

#[test]
fn any_window_and_any_frame_are_drawn() {
    let cave = cave();
    for stereo in Stereo::ALL {
        let mut dashboard = Dashboard::new(&cave, stereo).unwrap();
        (dashboard.levels, dashboard.tiles) = (true, true);
        let mut odd = frame(Vec3::NEG_Z);
        let (milliseconds, late) = (Some(f32::NAN), true);
        odd.latencies = vec![Latency { milliseconds, late }; 300];
        odd.record.rung = 99;
        Arc::make_mut(&mut odd.about).hz = 0;
        let status = Status {
            message: Some("ünïcode 床".to_owned()),
            ..Status::default()
        };
        for (width, height) in [(0, 0), (1, 1), (3, 200), (300, 90), (641, 333)] {
            for view in [ViewName::Net, ViewName::Viewer] {
                dashboard.view = view;
                let mut canvas = Canvas::new(width, height);
                dashboard.draw(&mut canvas, &odd, &status, 1).unwrap();
                Dashboard::wait(&mut canvas, &status);
                assert_eq!(dashboard.direction(5_000, 5_000, &odd), None);
            }
        }
        odd.pictures.clear();
        odd.eyes.clear();
        odd.tiles.clear();
        drawn(&mut dashboard, &odd, 0);
    }
}
