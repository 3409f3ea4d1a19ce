use super::*;
use crate::cave::{BuiltInCave, Eye, Viewer};
use crate::live::{Share, eyes_of};
use crate::picture::srgb_from_linear;
use crate::show::stereo::anaglyph;
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};

const SIDE: u32 = 64;

/// Both walls of each eye have a colour of their own.
fn light(screen: usize, eye: usize) -> [f32; 4] {
    [0.2 * screen as f32 + 0.1, 0.5 * eye as f32, 0.3, 1.0]
}

fn colour([red, green, blue, _]: [f32; 4]) -> Colour {
    [red, green, blue].into_iter().fold(0, |colour, channel| {
        (colour << 8) | Colour::from(srgb_from_linear(channel))
    })
}

fn cave() -> Cave {
    Cave::built_in(BuiltInCave::ThreeWall, [SIDE; 2]).unwrap()
}

/// Two eyes that look along `forward`.
fn frame(cave: &Cave, forward: Vec3) -> Frame {
    let viewer = Viewer::default();
    let eyes = Eye::STEREO.map(|eye| {
        let place = viewer.eye(eye);
        let sight = LineOfSight::new(place.as_vec3(), forward, Vec3::Y).unwrap();
        let gaze = Gaze::new(sight, VisualField::PAPER);
        Observer {
            lod: Some(LevelOfDetail::new(gaze)),
            ..Observer::new(eye, place)
        }
    });
    let pictures = eyes_of(cave, &eyes, Share::ALL).map(|(screen, eye)| {
        let eye = Eye::STEREO.iter().position(|one| *one == eye).unwrap();
        let pixels = vec![light(screen, eye); (SIDE * SIDE) as usize];
        Picture::from_pixels(SIDE, SIDE, pixels).unwrap()
    });
    let pictures: Vec<_> = pictures.collect();
    // From the middle of the first picture's first row of tiles on.
    let tile = |x, y| Tile {
        x,
        y,
        width: 32,
        height: 32,
    };
    let corners = [(32, 0), (0, 0), (0, 32), (32, 32)];
    let tiles = (0..pictures.len()).flat_map(|picture| {
        let tiles = corners.map(|(x, y)| (picture, tile(x, y)));
        tiles.into_iter()
    });
    Frame {
        about: Arc::new(About {
            scene: "A".to_owned(),
            lod: "paper".to_owned(),
            fill: "background".to_owned(),
            hz: 50,
            budget: "20ms".to_owned(),
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

struct Drawn {
    canvas: Canvas,
    cave: Cave,
}

/// Draws a frame in a window of the usual size.
fn drawn(stereo: Stereo, frame: &Frame, choose: impl FnOnce(&mut Dashboard<'_>)) -> Drawn {
    let cave = cave();
    let [width, height] = Dashboard::SIZE;
    let mut canvas = Canvas::new(width, height);
    let mut dashboard = Dashboard::new(&cave, stereo).unwrap();
    choose(&mut dashboard);
    let status = Status::default();
    dashboard.draw(&mut canvas, frame, &status, 0).unwrap();
    Drawn { canvas, cave }
}

impl Drawn {
    fn count(&self, wanted: Colour) -> usize {
        let pixels = self.canvas.pixels().iter();
        pixels.filter(|&&pixel| pixel == wanted).count()
    }
}

#[test]
fn a_net_shows_each_wall_of_the_left_eye() {
    let cave = cave();
    let drawn = drawn(Stereo::Mono, &frame(&cave, Vec3::NEG_Z), |_| {});
    // The net of two walls by two and its margins, as high as there is room.
    let room = Dashboard::SIZE[1] - HEADER - gauges::ROWS;
    let side = f64::from(room) * 64.0 / (2.0 * 64.0 + 34.0);
    for screen in 0..drawn.cave.screens().count() {
        let (left, right) = (colour(light(screen, 0)), colour(light(screen, 1)));
        let found = drawn.count(left) as f64 / (side * side);
        assert!((0.9..=1.01).contains(&found), "screen {screen}: {found}");
        assert_eq!(drawn.count(right), 0);
    }
}

#[test]
fn two_eyes_are_where_their_format_has_them() {
    let cave = cave();
    let frame = frame(&cave, Vec3::NEG_Z);
    let [width, height] = Dashboard::SIZE;
    let sides = |stereo: Stereo, first: &dyn Fn(u32, u32) -> bool| {
        let drawn = drawn(stereo, &frame, |_| {});
        let (left, right) = (colour(light(0, 0)), colour(light(0, 1)));
        let (mut of_left, mut of_right) = (0, 0);
        for y in 0..height {
            for x in 0..width {
                let pixel = drawn.canvas.pixel(x, y).unwrap();
                assert!(pixel != left || first(x, y), "{stereo}: {x} {y}");
                assert!(pixel != right || !first(x, y), "{stereo}: {x} {y}");
                of_left += u32::from(pixel == left);
                of_right += u32::from(pixel == right);
            }
        }
        assert!(of_left > 5_000 && of_right.abs_diff(of_left) < of_left / 50);
    };
    sides(Stereo::SideBySide, &|x, _| x < width / 2);
    let middle = HEADER + (height - HEADER - gauges::ROWS) / 2;
    sides(Stereo::TopBottom, &|_, y| y < middle);
    let glasses = drawn(Stereo::Anaglyph, &frame, |_| {});
    let both = colour(anaglyph(light(0, 0), light(0, 1)));
    assert!(glasses.count(both) > 40_000, "{}", glasses.count(both));
    assert_eq!(glasses.count(colour(light(0, 0))), 0);
}

#[test]
fn eyes_take_turns() {
    let cave = cave();
    let mut dashboard = Dashboard::new(&cave, Stereo::Sequential).unwrap();
    assert_eq!(dashboard.turns(), 2);
    let frame = frame(&cave, Vec3::NEG_Z);
    for turn in 0..2 {
        let mut canvas = Canvas::new(400, 400);
        let status = Status::default();
        dashboard.draw(&mut canvas, &frame, &status, turn).unwrap();
        let has = |eye: usize| canvas.pixels().contains(&colour(light(0, eye)));
        assert!(has(turn) && !has(1 - turn), "{turn}");
    }
}

#[test]
fn the_gaze_is_marked_and_the_mouse_points_at_it() {
    let cave = cave();
    let [width, height] = Dashboard::SIZE;
    for view in [ViewName::Net, ViewName::Viewer] {
        for forward in [Vec3::NEG_Z, Vec3::new(0.3, -0.2, -1.0)] {
            let frame = frame(&cave, forward);
            let mut canvas = Canvas::new(width, height);
            let mut dashboard = Dashboard::new(&cave, Stereo::Mono).unwrap();
            dashboard.view = view;
            let status = Status::default();
            dashboard.draw(&mut canvas, &frame, &status, 0).unwrap();
            // The cross is 21 pixels wide, and nothing else is white there.
            let white = |x: u32, y: u32| canvas.pixel(x, y) == Some(0xFF_FFFF);
            let row = (HEADER + 20..height - gauges::ROWS - 20)
                .find(|&y| (0..width - 21).any(|x| (x..x + 21).all(|x| white(x, y))));
            let row = row.expect("a cross");
            let left = (0..width).find(|&x| (x..x + 21).all(|x| white(x, row)));
            let middle = left.unwrap() + 10;
            let direction = dashboard.direction(middle, row, &frame);
            let apart = direction.unwrap().angle_between(forward);
            assert!(apart < 0.02, "{view:?} {forward}: {apart}");
        }
    }
}

#[test]
fn levels_are_shown_where_they_are() {
    let cave = cave();
    let frame = frame(&cave, Vec3::NEG_Z);
    let plain = drawn(Stereo::Mono, &frame, |_| {});
    let levels = drawn(Stereo::Mono, &frame, |dashboard| dashboard.levels = true);
    // All of the front wall has a level, so that none of it is as it was, but where a
    // block's middle is in a name or beyond the wall.
    let [before, after] = [&plain, &levels].map(|drawn| drawn.count(colour(light(0, 0))));
    assert!(before > 10_000 && after < before / 100, "{before} {after}");
    // Yellow is at the gaze, more blue than yellow at the other end of the wall.
    let dashboard = {
        let mut canvas = Canvas::new(960, 720);
        let mut dashboard = Dashboard::new(&cave, Stereo::Mono).unwrap();
        dashboard
            .draw(&mut canvas, &frame, &Status::default(), 0)
            .unwrap();
        dashboard
    };
    let mut checked = [0; 2];
    for y in (HEADER..620).step_by(7) {
        for x in (0..960).step_by(7) {
            let Some(direction) = dashboard.direction(x, y, &frame) else {
                continue;
            };
            let lod = frame.eyes[0].lod.unwrap();
            let level = lod.gaze.level(direction).unwrap();
            let pixel = levels.canvas.pixel(x, y).unwrap();
            let plain = plain.canvas.pixel(x, y).unwrap();
            let green = |pixel: Colour| (pixel >> 8) & 0xFF;
            // The cross and the names are over all.
            let on_wall = (0..3).any(|screen| plain == colour(light(screen, 0)));
            if on_wall && level == 1.0 {
                assert!(green(pixel) > 150, "{x} {y}: {pixel:06x}");
                checked[0] += 1;
            } else if on_wall && level < 0.2 {
                assert!(green(pixel) < 100, "{x} {y}: {pixel:06x} {level}");
                checked[1] += 1;
            }
        }
    }
    assert!(checked.iter().all(|&count| count > 100), "{checked:?}");
}

#[test]
fn the_first_tile_is_the_brightest() {
    let cave = cave();
    let mut frame = frame(&cave, Vec3::NEG_Z);
    let black = vec![[0.0, 0.0, 0.0, 1.0]; (SIDE * SIDE) as usize];
    for picture in &mut frame.pictures {
        picture.pixels.clone_from(&black);
    }
    let tiles = drawn(Stereo::Mono, &frame, |dashboard| dashboard.tiles = true);
    let mut seen = std::collections::BTreeMap::new();
    for &pixel in tiles.canvas.pixels() {
        *seen.entry(pixel).or_insert(0) += 1;
    }
    // Three walls of four tiles, each with a rank of its own.
    let large = seen.iter().filter(|(_, count)| **count > 8_000);
    let large: Vec<Colour> = large.map(|(colour, _)| *colour).collect();
    // The walls' twelve, the ground, the net's ground and the gauges' groove.
    assert!(large.len() >= 12 + 2, "{large:06x?}");
    let first = colorous::PLASMA.eval_continuous(1.0);
    let linear = |code: u8| (f32::from(code) / 255.0).powf(2.2) * 0.55;
    let first = colour([linear(first.r), linear(first.g), linear(first.b), 1.0]);
    assert!(large.contains(&first), "{first:06x} of {large:06x?}");
}

#[test]
fn the_budget_s_bar_is_in_proportion() {
    let cave = cave();
    let frame = frame(&cave, Vec3::NEG_Z);
    let drawn = drawn(Stereo::Mono, &frame, |_| {});
    let row = Dashboard::SIZE[1] - gauges::ROWS + 4 + 20;
    let of = |wanted: Colour| {
        let pixels = (0..480).filter(|&x| drawn.canvas.pixel(x, row) == Some(wanted));
        pixels.count()
    };
    // Of 464 columns half is spent, and a quarter would have been needed besides.
    assert_eq!(
        [of(0x50_C060), of(0xC0_A030), of(0x30_3030)],
        [232, 116, 116]
    );
}

#[test]
fn late_frames_are_red_in_the_strip() {
    let cave = cave();
    let mut frame = frame(&cave, Vec3::NEG_Z);
    let one = |milliseconds, late| Latency { milliseconds, late };
    frame.latencies = vec![
        one(Some(10.0), false),
        one(None, false),
        one(Some(80.0), true),
        one(Some(20.0), false),
    ];
    let drawn = drawn(Stereo::Mono, &frame, |_| {});
    let bottom = Dashboard::SIZE[1] - gauges::ROWS + 4 + 14 + 39;
    let row: Vec<_> = (936..952)
        .map(|x| drawn.canvas.pixel(x, bottom).unwrap())
        .collect();
    let (green, red, ground) = (0x50_C060, 0xE0_4040, 0x30_3030);
    let expected = [green, green, ground, ground, red, red, green, green];
    assert_eq!(row[8..], expected);
    // 80 ms of a scale of 80: all of it.
    let red = drawn.count(red);
    assert!((70..=80).contains(&red), "{red}");
}

#[test]
fn any_window_is_drawn_into() {
    let cave = cave();
    for stereo in Stereo::ALL {
        let mut dashboard = Dashboard::new(&cave, stereo).unwrap();
        dashboard.levels = true;
        dashboard.tiles = true;
        let mut odd = frame(&cave, Vec3::NEG_Z);
        odd.latencies = vec![
            Latency {
                milliseconds: Some(f32::NAN),
                late: true,
            };
            300
        ];
        odd.record.rung = 99;
        odd.about = Arc::new(About {
            hz: 0,
            ..(*odd.about).clone()
        });
        for (width, height) in [(0, 0), (1, 1), (3, 200), (300, 90), (641, 333)] {
            for view in [ViewName::Net, ViewName::Viewer] {
                dashboard.view = view;
                let mut canvas = Canvas::new(width, height);
                let status = Status {
                    message: Some("ünïcode 床".to_owned()),
                    ..Status::default()
                };
                dashboard.draw(&mut canvas, &odd, &status, 1).unwrap();
                dashboard.wait(&mut canvas, &status);
                assert_eq!(dashboard.direction(5_000, 5_000, &odd), None);
            }
        }
        // A frame with nothing in it.
        odd.pictures.clear();
        odd.eyes.clear();
        odd.tiles.clear();
        let mut canvas = Canvas::new(200, 200);
        dashboard
            .draw(&mut canvas, &odd, &Status::default(), 0)
            .unwrap();
    }
}
