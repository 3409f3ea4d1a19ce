use super::output::{CROSSING, GAMMAS, PATCH, gamma_field};
use super::screen::{BACKGROUND, CELL, LADDER, RADII};
use super::*;
use crate::cave::{BuiltInCave, Cave};
use crate::show::overview::viewer::{ViewerCamera, render};
use fast_srgb8::srgb8_to_f32;
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

fn room(which: BuiltInCave, size: [u32; 2]) -> Cave {
    Cave::built_in(which, size).unwrap()
}

fn view(screen: Screen<'_>, eye: Eye) -> ScreenView<'_> {
    let viewer = Viewer::default();
    ScreenView {
        screen,
        viewer,
        eye,
    }
}

fn drawn(name: &str, view: &ScreenView<'_>) -> Picture {
    match Pattern::named(name).unwrap().drawing {
        Drawing::Screen { draw, .. } => draw(view).unwrap(),
        Drawing::Output { .. } => panic!("{name} is of an output"),
    }
}

fn output(size: [u32; 2], neighbours: &[Vec<DVec2>]) -> OutputView<'_> {
    OutputView {
        name: "front",
        number: 0,
        size,
        neighbours,
    }
}

#[test]
fn circles_are_round_from_the_viewers_place_across_a_corner() {
    let room = room(BuiltInCave::ThreeWall, [300; 2]);
    let mut viewer = Viewer::default();
    viewer.pose.position = Vec3::new(0.3, 0.1, 0.4);
    let eye = Eye::Left;
    let draw = |screen| {
        let view = ScreenView {
            screen,
            viewer,
            eye,
        };
        (screen, drawn("circles", &view))
    };
    let pictures: Vec<_> = room.screens().map(draw).collect();
    let screens: Vec<_> = pictures
        .iter()
        .map(|(screen, one)| (*screen, one))
        .collect();
    let (centre, size) = (DVec3::new(1.0, 0.0, -1.0).normalize(), 400);
    let view = 0.7;
    let camera = ViewerCamera::new(viewer.eye(eye), centre, DVec3::Y, view, [size; 2]).unwrap();
    let seen = render(&camera, &screens).unwrap();
    // The mean angle of the line in each of many directions around, by its colour.
    let mut bins = [[0.0; 2]; 36];
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        let (x, y, [red, _, blue, _]) = (x, y, seen.pixel(x, y).unwrap());
        let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        let angle = camera.ray(at.x, at.y).dot(centre).acos().to_degrees();
        let light = f64::from((red - blue).max(0.0));
        if (angle - RADII[1]).abs() < 2.0 && light > 0.0 {
            let around = (at - 0.5 * f64::from(size)).to_angle().rem_euclid(TAU) / TAU;
            let bin = &mut bins[(around * 36.0) as usize % 36];
            bin[0] += light;
            bin[1] += light * angle;
        }
    }
    let radii = bins.map(|[light, sum]| sum / light);
    let [least, most] = [radii.map(|one| -one), radii].map(|all| {
        let most = all.into_iter().fold(f64::NEG_INFINITY, f64::max);
        most.abs()
    });
    assert!(
        most / least < 1.01 && (most / RADII[1] - 1.0).abs() < 0.01,
        "{radii:?}"
    );
    // It does cross a corner.
    let corner = DVec3::new(1.5, 0.1, -1.5) - viewer.eye(eye);
    assert!(corner.normalize().dot(centre).acos().to_degrees() < RADII[1] - 1.0);
}

#[test]
fn lines_of_the_grid_are_a_cell_apart() {
    let room = room(BuiltInCave::ThreeWall, [500, 400]);
    let picture = drawn("grid", &view(room.screens().next().unwrap(), Eye::Left));
    // A line covers more than half of its column, which numbers do not.
    let is_line = |lights: &mut dyn Iterator<Item = [f32; 4]>| {
        let (lit, all) = lights.fold((0, 0), |(lit, all), light| {
            (lit + u32::from(light[0] > 0.1), all + 1)
        });
        2 * lit > all
    };
    let light = |x, y| picture.pixel(x, y).unwrap();
    let columns = (0..500).filter(|&x| is_line(&mut (0..400).map(|y| light(x, y))));
    let rows = (0..400).filter(|&y| is_line(&mut (0..500).map(|x| light(x, 399 - y))));
    for (lines, count) in [
        (columns.collect::<Vec<_>>(), 500.0),
        (rows.collect(), 400.0),
    ] {
        assert_eq!(lines.len(), 13, "{lines:?}");
        for (number, line) in lines.into_iter().enumerate() {
            let metres = (f64::from(line) + 0.5) / count * 3.0;
            let off = (metres - number as f64 * CELL) * count / 3.0;
            assert!(off.abs() <= 1.0, "line {number} is {off} pixels off");
        }
    }
}

#[test]
fn outermost_pixels_are_lit_on_all_sides() {
    let lit = |picture: &Picture, x, y| picture.pixel(x, y).unwrap()[1] == 1.0;
    let walls = room(BuiltInCave::ThreeWall, [97, 64]);
    for screen in walls.screens() {
        let picture = drawn("edges", &view(screen, Eye::Centre));
        assert!((0..97).all(|x| lit(&picture, x, 0) && lit(&picture, x, 63)));
        assert!((0..64).all(|y| lit(&picture, 0, y) && lit(&picture, 96, y)));
    }
    let dome = room(BuiltInCave::Dome, [97; 2]);
    let picture = drawn("edges", &view(dome.screens().next().unwrap(), Eye::Centre));
    assert!(
        [(0, 48), (96, 48), (48, 0), (48, 96)]
            .iter()
            .all(|&(x, y)| lit(&picture, x, y))
    );
}

#[test]
fn bars_of_the_ladder_have_the_parallax_of_their_distances() {
    const PIXELS: u32 = 600;
    let room = room(BuiltInCave::ThreeWall, [PIXELS; 2]);
    let front = room.screens().next().unwrap();
    let pictures = Eye::STEREO.map(|eye| drawn("depth", &view(front, eye)));
    let ipd = Viewer::default().interpupillary_distance;
    for (name, distance, place, _) in LADDER {
        // The middle of each bar's light in a row below its letters.
        let [left, right] = pictures.each_ref().map(|picture| {
            let lights = (0..PIXELS).map(|x| {
                let light = picture.pixel(x, PIXELS / 2 + 40).unwrap();
                let share = f64::from(x) / f64::from(PIXELS);
                let is_near = (share - place).abs() < 0.15;
                let light = light[..3].iter().sum::<f32>() - BACKGROUND.iter().sum::<f32>();
                (f64::from(x), if is_near { f64::from(light) } else { 0.0 })
            });
            let sums = lights.fold([0.0; 2], |[sum, all], (x, light)| {
                [sum + x * light, all + light]
            });
            sums[0] / sums[1]
        });
        let metres = (left - right) * 3.0 / f64::from(PIXELS);
        let expected = ipd * (1.0 / distance - 1.0);
        assert!(
            (metres - expected).abs() < 0.25 * 3.0 / f64::from(PIXELS),
            "{name}: {metres} m"
        );
    }
}

#[test]
fn fields_of_gamma_match_the_lines_around() {
    let size = [900, 600];
    let canvas = output::gamma(&output(size, &[]), Refresh::default());
    for ((code, name), column) in GAMMAS.into_iter().zip(0..) {
        let field = gamma_field(size, column, 0);
        assert_eq!(
            canvas.pixel(field.x, field.y),
            Some(u32::from(code) * 0x01_0101)
        );
        let beside = (0..16).map(|row| canvas.pixel(field.x - 2, field.y + row).unwrap());
        let codes: Vec<u32> = beside.map(|pixel| pixel & 0xFF).collect();
        assert!(
            codes
                .chunks(2)
                .all(|pair| pair == [0, 255] || pair == [255, 0])
        );
        let part = f64::from(code) / 255.0;
        let light = name
            .parse()
            .map_or(f64::from(srgb8_to_f32(code)), |gamma| part.powf(gamma));
        assert!((light - 0.5).abs() < 0.004, "{name}: {light}");
    }
}

#[test]
fn border_pairs_of_aligned_projectors_are_yellow() {
    let rectangle = |left: f64| {
        let corners = [(0.0, 0.0), (64.0, 0.0), (64.0, 48.0), (0.0, 48.0)];
        vec![corners.map(|(x, y)| DVec2::new(left + x, y)).to_vec()]
    };
    let draw = |neighbours: &[Vec<DVec2>]| {
        output::border_pair(&output([64, 48], neighbours), Refresh::default())
    };
    let (left, right) = (draw(&rectangle(48.0)), draw(&rectangle(-48.0)));
    let sum = |x| left.pixel(48 + x, 9).unwrap() + right.pixel(x, 9).unwrap();
    assert_eq!([0, 1, 14, 15].map(sum), [0xFF_FF00; 4]);
    assert_eq!([2, 13].map(sum), [0; 2]);
}

#[test]
fn every_pattern_shows_something_and_differs_between_eyes_only_for_its_purpose() {
    let walls = room(BuiltInCave::ThreeWall, [120, 100]);
    let domes = room(BuiltInCave::Dome, [120; 2]);
    let screens = [
        walls.screens().next().unwrap(),
        domes.screens().next().unwrap(),
    ];
    for pattern in PATTERNS {
        let name = pattern.name;
        match pattern.drawing {
            Drawing::Screen { draw, is_stereo } => {
                for screen in screens {
                    let [left, right] = Eye::STEREO.map(|eye| draw(&view(screen, eye)).unwrap());
                    let is_lit = |pixel: &[f32; 4]| pixel[..3].iter().any(|light| *light > 0.0);
                    assert!(left.pixels.iter().any(is_lit), "{name}");
                    assert_eq!(left != right, is_stereo || name == "circles", "{name}");
                }
            }
            Drawing::Output { draw, is_moving } => {
                let at = |msc, is_event| draw(&output([160, 120], &[]), Refresh { msc, is_event });
                assert!(
                    at(3, true).pixels().iter().any(|pixel| *pixel > 0),
                    "{name}"
                );
                assert_eq!(at(3, true) != at(4, false), is_moving, "{name}");
            }
        }
    }
    let dark = output::latency(&output([160, 120], &[]), Refresh::default());
    assert!(dark.pixels().iter().all(|pixel| *pixel == 0));
    let msc = CROSSING + 2;
    let is_event = true;
    let lit = output::latency(&output([160, 120], &[]), Refresh { msc, is_event });
    let count = lit.pixels().iter().filter(|pixel| **pixel > 0).count();
    assert_eq!(count, (PATCH * PATCH) as usize);
}

#[test]
fn patterns_fit_into_the_smallest_pictures() {
    for size in [[1, 1], [3, 2], [1, 40]] {
        let walls = room(BuiltInCave::ThreeWall, size);
        let domes = room(BuiltInCave::Dome, size);
        for pattern in PATTERNS {
            match pattern.drawing {
                Drawing::Screen { draw, .. } => {
                    for screen in walls.screens().chain(domes.screens()) {
                        draw(&view(screen, Eye::Right)).unwrap();
                    }
                }
                Drawing::Output { draw, .. } => {
                    draw(&output(size, &[]), Refresh::default());
                }
            }
        }
    }
}
