//! Maps and weights against tables that another program made, and the light that projectors'
//! codes add up to.

use super::show::lights_of;
use super::*;
use crate::files::description::tests::check_faults;
use crate::picture::Picture;
use glam::{DVec2, DVec3};
use std::fmt::Write as _;

/// Places and weights of some pixels: set, projector, column, row, s, t (of domes in the unit disc,
/// upwards), weight. Empty off the screen.
const BLEND: &str = include_str!("tests/blend.csv");

/// Set, projector, position, yaw, pitch, roll, edges at distance 1, columns and rows.
const PROJECTORS: &str = include_str!("tests/projectors.csv");

const WALL: &str = "[[wall]]\nname = \"screen\"\nlower_left = [-1.8, 0, -2]\n\
                    lower_right = [1.8, 0, -2]\nupper_left = [-1.8, 1.5, -2]\n";
const DOME: &str = "[[dome]]\nname = \"screen\"\nradius = 2.5\ncentre = [0, 0, 0]\n";

/// A projector's name, position, yaw, pitch and roll (degrees), half width at distance 1, columns
/// and rows.
type Pose = (String, [f64; 3], [f64; 3], f64, [u32; 2]);

fn set(name: &str, scale: u32) -> Vec<Pose> {
    let lines = PROJECTORS
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>());
    let of_set = lines.filter(|cells| cells[0] == name);
    let pose = |cells: Vec<&str>| {
        let number = |cell: usize| cells[cell].parse::<f64>().unwrap();
        let place = |first: usize| [0, 1, 2].map(|axis| number(first + axis));
        let size = [12, 13].map(|cell| scale * number(cell) as u32);
        (cells[1].to_owned(), place(2), place(5), number(9), size)
    };
    of_set.map(pose).collect()
}

/// Returns a room of a screen of this size and these projectors, with more keys.
fn room(screen: &str, poses: &[Pose], size: [u32; 2], more: &str) -> Cave {
    let mut text = screen.to_owned();
    for (name, position, [yaw, pitch, roll], half, resolution) in poses {
        writeln!(
            text,
            "[[projector]]\nname = {name:?}\nposition = {position:?}\nyaw_degrees = {yaw:?}\n\
             pitch_degrees = {pitch:?}\nroll_degrees = {roll:?}\nthrow = {:?}\n\
             resolution = {resolution:?}\n{more}",
            0.5 / half
        )
        .unwrap();
    }
    Cave::from_toml(&text, "room.toml", size).unwrap()
}

const CYLINDER: &str = "[[cylinder]]\nname = \"screen\"\nradius = 3\ncentre = [0, 0, 0]\n\
                        azimuth_degrees = [-80, 80]\nheight = [0, 2.2]\n";

#[test]
fn places_and_weights_are_those_of_the_tables() {
    for (name, screen) in [
        ("flat2", WALL),
        ("keystone2", WALL),
        ("dome3", DOME),
        ("cylinder3", CYLINDER),
    ] {
        let room = room(screen, &set(name, 1), [16; 2], "");
        let blends = room.blends().unwrap();
        let [blend] = &blends[..] else { panic!() };
        let mut count = 0;
        for line in BLEND.lines() {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |cell: usize| cells[cell].parse::<f64>().unwrap();
            if cells[0] != name {
                continue;
            }
            let mut members = blend.members.iter();
            let member = members
                .position(|one| one.projector.name == cells[1])
                .unwrap();
            let at = (DVec2::new(number(2), number(3)) + 0.5) / DVec2::new(64.0, 48.0);
            let place = blend.members[member].map.place(at);
            assert_eq!(place.is_some(), !cells[4].is_empty(), "{line}");
            let Some(place) = place else { continue };
            let mut expected = DVec2::new(number(4), number(5));
            if name == "dome3" {
                expected = 0.5 * expected * DVec2::new(1.0, -1.0) + 0.5;
            }
            assert!(place.distance(expected) < 2e-9, "{line}: {place}");
            let back = blend.members[member].map.at(place).unwrap();
            assert!(back.distance(at) < 1e-12, "{line}: {back}");
            let [weight, lift] = blend.share(member, at, place);
            assert!(
                (weight - number(6)).abs() < 1e-8 * weight.max(0.1),
                "{line}: {weight}"
            );
            assert_eq!(lift, 0.0);
            count += 1;
        }
        assert!(count > 40, "{name}: {count}");
    }
}

#[test]
fn rays_through_a_projectors_pixels_go_to_the_places_that_they_light() {
    let eye = DVec3::new(0.2, 1.2, 0.3);
    for (name, screen) in [
        ("flat2", WALL),
        ("keystone2", WALL),
        ("dome3", DOME),
        ("cylinder3", CYLINDER),
    ] {
        let mut room = room(screen, &set(name, 16), [64; 2], "");
        let names: Vec<String> = room.projectors.iter().map(|one| one.name.clone()).collect();
        room.trace_directly(&names).unwrap();
        let pictured: Vec<_> = room.pictured().collect();
        assert_eq!(pictured.len(), names.len());
        let mut count = 0;
        for (pictured, projector) in pictured.iter().zip(&room.projectors) {
            let view = pictured.view_from(eye).unwrap();
            let screen = room.screen_of(projector).unwrap();
            let map = Map::new(screen, projector).unwrap();
            let towards = |x: f32, y: f32| view.direction(x, y).unwrap().as_dvec3().normalize();
            for (x, y) in (0..1024)
                .step_by(31)
                .flat_map(|x| (0..768).step_by(29).map(move |y| (x, y)))
            {
                let at = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / DVec2::new(1024.0, 768.0);
                let Some(place) = map.place(at) else { continue };
                let expected = (screen.point(place) - eye).normalize();
                let (x, y) = (x as f32, y as f32);
                let found = towards(x, y);
                let steps =
                    [towards(x + 1.0, y), towards(x, y + 1.0)].map(|one| one.distance(found));
                let apart = found.distance(expected) / steps[0].min(steps[1]);
                assert!(apart < 0.02, "{name} {} {x} {y}: {apart}", projector.name);
                count += 1;
            }
        }
        assert!(count > 300, "{name}: {count}");
        // A pixel shows the picture's pixel: where no other projector lights the place, its code.
        let (projections, mut picture) = (
            Projection::all(&room).unwrap(),
            Picture::new(1024, 768).unwrap(),
        );
        for (number, pixel) in picture.pixels.iter_mut().enumerate() {
            *pixel = [Transfer::Srgb.light((number % 251) as f64 / 255.0) as f32; 4];
        }
        let mut codes = vec![0; 1024 * 768];
        projections[0].show(&picture, &mut codes).unwrap();
        let is_own = |(number, code): (usize, &u32)| *code == (number % 251) as u32 * 0x0001_0101;
        let own = codes.iter().enumerate().filter(|one| is_own(*one)).count();
        assert!(own > codes.len() / 4, "{name}: {own}");
    }
    let pinned = "[[projector]]\nname = \"pinned\"\nresolution = [64, 48]\n\
                  corner_pins = [[[0, 0], [0, 0]], [[1, 0], [1, 0]], [[0, 1], [0, 1]], [[1, 1], [1, 1]]]\n";
    let room = Cave::from_toml(&format!("{CYLINDER}{pinned}"), "room.toml", [16; 2]).unwrap();
    let error = room.can_be_direct(&room.projectors[0]).unwrap_err();
    assert!(error.to_string().contains("pinned"), "{error}");
}

/// The light of projectors' codes at a place: by rays of this module, bilinear between pixels.
struct Simulation {
    /// Position; right, top and ahead; half width and half height at distance 1.
    lenses: Vec<(DVec3, [DVec3; 3], DVec2)>,
    lights: Vec<([u32; 2], Vec<f64>)>,
}

impl Simulation {
    fn new(room: &Cave, poses: &[Pose], picture: &Picture, gamma: f64) -> Self {
        let show = |projection: &Projection| {
            let size = projection.resolution();
            let mut codes = vec![0; (size[0] * size[1]) as usize];
            projection.show(picture, &mut codes).unwrap();
            let light = |code: u32| (f64::from((code >> 8) & 0xff) / 255.0).powf(gamma);
            (size, codes.into_iter().map(light).collect())
        };
        let lens = |(_, position, angles, half, size): &Pose| {
            let [yaw, pitch, roll] = angles.map(f64::to_radians);
            let turn = glam::DMat3::from_rotation_y(-yaw)
                * glam::DMat3::from_rotation_x(pitch)
                * glam::DMat3::from_rotation_z(-roll);
            let tall = half * f64::from(size[1]) / f64::from(size[0]);
            let axes = [turn.x_axis, turn.y_axis, -turn.z_axis];
            (DVec3::from(*position), axes, DVec2::new(*half, tall))
        };
        Self {
            lenses: poses.iter().map(lens).collect(),
            lights: Projection::all(room).unwrap().iter().map(show).collect(),
        }
    }

    /// Returns the sum of all light at a point, and how far inside the picture that is deepest there
    /// the point is, 0 to ½; `None` where no light falls.
    fn at(&self, point: DVec3) -> Option<(f64, f64)> {
        let (mut sum, mut deepest) = (0.0, None);
        for ((position, [right, top, ahead], half), (size, lights)) in
            self.lenses.iter().zip(&self.lights)
        {
            let way = point - *position;
            let seen = DVec2::new(way.dot(*right), -way.dot(*top)) / way.dot(*ahead);
            let at = 0.5 * seen / *half + 0.5;
            let depth = at.min(1.0 - at).min_element();
            if way.dot(*ahead) <= 0.0 || depth < 0.0 {
                continue;
            }
            deepest = Some(deepest.map_or(depth, |deepest: f64| deepest.max(depth)));
            let pixel = |x: i64, y: i64| {
                let [x, y] = [(x, size[0]), (y, size[1])]
                    .map(|(at, count)| at.clamp(0, i64::from(count) - 1));
                lights[(y * i64::from(size[0]) + x) as usize]
            };
            let at = at * DVec2::new(f64::from(size[0]), f64::from(size[1])) - 0.5;
            let (low, share) = (at.floor(), at - at.floor());
            let (x, y) = (low.x as i64, low.y as i64);
            sum += (1.0 - share.y) * ((1.0 - share.x) * pixel(x, y) + share.x * pixel(x + 1, y))
                + share.y * ((1.0 - share.x) * pixel(x, y + 1) + share.x * pixel(x + 1, y + 1));
        }
        deepest.map(|depth| (sum, depth))
    }
}

fn ring(count: u32, size: [u32; 2]) -> Vec<Pose> {
    let pose = |number: u32| {
        let yaw = 360.0 * f64::from(number) / f64::from(count);
        let (sin, cos) = yaw.to_radians().sin_cos();
        let position = [-1.4 * sin, -0.2, 1.4 * cos];
        (format!("p{number}"), position, [yaw, 35.0, 0.0], 1.1, size)
    };
    (0..count).map(pose).collect()
}

fn wall_of(columns: u32, rows: u32, size: [u32; 2]) -> Vec<Pose> {
    let pose = |number: u32| {
        let (x, y) = (f64::from(number % columns), f64::from(number / columns));
        let place = |at: f64, count: u32, width: f64| {
            (at - 0.5 * f64::from(count - 1)) * width / f64::from(count)
        };
        let position = [place(x, columns, 3.4), 0.75 + place(y, rows, 1.4), 0.1 * x];
        let angles = [2.0 * x - 1.0, 1.0 - y, x - 0.5];
        (format!("p{number}"), position, angles, 0.55, size)
    };
    (0..columns * rows).map(pose).collect()
}

#[test]
fn flat_fields_add_up_to_within_a_code() {
    let size = [256, 192];
    for (name, screen, poses) in [
        ("2 on a wall", WALL, set("keystone2", 4)),
        ("3 on a wall", WALL, wall_of(3, 1, size)),
        ("4 on a wall", WALL, wall_of(2, 2, size)),
        ("3 on a cylinder", CYLINDER, set("cylinder3", 4)),
        ("5 on a dome", DOME, ring(5, size)),
    ] {
        let room = room(screen, &poses, [64; 2], "gamma = 2.2\n");
        let white = Picture::from_pixels(64, 64, vec![[1.0; 4]; 64 * 64]).unwrap();
        let simulation = Simulation::new(&room, &poses, &white, 2.2);
        let blends = room.blends().unwrap();
        let screen = room.screens().next().unwrap();
        let (mut worst, mut outside, mut overlaps) = ((0.0, DVec2::ZERO), (0.0, DVec2::ZERO), 0);
        let points =
            (0..220).flat_map(|y| (0..220).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
        for place in points.map(|point| (point + 0.5) / 220.0) {
            let from_middle = (place - 0.5).abs();
            let is_inside = match screen {
                Screen::Dome(_) => from_middle.length() < 0.48,
                Screen::Wall(_) | Screen::Cylinder(_) => from_middle.max_element() < 0.48,
            };
            let Some((light, depth)) = simulation.at(screen.point(place)).filter(|_| is_inside)
            else {
                continue;
            };
            let off = 255.0 * (light.powf(1.0 / 2.2) - 1.0).abs();
            if depth > Blend::CROSSING && !blends[0].is_at_crossing(place) {
                worst = if off > worst.0 { (off, place) } else { worst };
                overlaps += 1;
            } else {
                outside = if off > outside.0 {
                    (off, place)
                } else {
                    outside
                };
            }
        }
        let report = format!("{name}: {worst:?} codes; outside {outside:?}, of {overlaps}");
        assert!(worst.0 <= 1.0 && overlaps > 20_000, "{report}");
    }
}

#[test]
fn lines_are_straight_across_projectors() {
    let size = [512, 384];
    let poses: Vec<Pose> = set("keystone2", 8);
    assert_eq!(poses[0].4, size);
    let room = room(WALL, &poses, [720, 300], "gamma = 2.2\n");
    // Half a pixel below the middle of a row, and sloping.
    let line = |x: f64| 148.3 + 0.02 * x;
    let mut picture = Picture::new(720, 300).unwrap();
    for (x, y) in (0..300).flat_map(|y| (0..720).map(move |x| (x, y))) {
        let off = f64::from(y) + 0.5 - line(f64::from(x) + 0.5);
        let light = (-0.5 * (off / 1.5).powi(2)).exp() as f32;
        picture.set_pixel(x, y, [light, light, light, 1.0]);
    }
    let simulation = Simulation::new(&room, &poses, &picture, 2.2);
    let screen = room.screens().next().unwrap();
    for x in (40..680).step_by(7).map(f64::from) {
        let (mut sum, mut moment) = (0.0, 0.0);
        for step in -60..=60 {
            let y = line(x) + 0.1 * f64::from(step);
            let (light, _) = simulation
                .at(screen.point(DVec2::new(x / 720.0, y / 300.0)))
                .unwrap();
            sum += light;
            moment += light * (y - line(x));
        }
        let off = moment / sum;
        assert!(off.abs() < 0.25, "column {x}: {off} pixels");
    }
}

#[test]
fn black_is_lifted_where_fewer_projectors_overlap() {
    // Light at black 0.0005 each, two at most: drives of 0.00050025 for black where one is alone,
    // of 1 for white; in overlaps weights of 0.99949975 without lift.
    let room = room(WALL, &set("flat2", 1), [16; 2], "black = 0.0005\n");
    let blends = room.blends().unwrap();
    let lights = lights_of(&blends[0]);
    let row: Vec<_> = (0..64)
        .map(|column| lights[0][24 * 64 + column].unwrap())
        .collect();
    assert!((row[10].lift - 0.000_500_250).abs() < 1e-9, "{:?}", row[10]);
    assert!(
        (row[10].weight + row[10].lift - 1.0).abs() < 1e-12,
        "{:?}",
        row[10]
    );
    let at = DVec2::new(60.5 / 64.0, 24.5 / 48.0);
    let [weight, _] = blends[0].share(0, at, blends[0].members[0].map.place(at).unwrap());
    assert!(
        (row[60].weight / weight - 0.999_499_75).abs() < 1e-9,
        "{:?}",
        row[60]
    );
    assert_eq!(row[60].lift, 0.0);
    // Softly, over the edge of the other picture at column 51.
    let falls = row
        .windows(2)
        .all(|pair| pair[1].lift <= pair[0].lift + 1e-15);
    assert!(
        falls && row[50].lift > 0.0 && row[50].lift < row[10].lift,
        "{row:?}"
    );
}

#[test]
fn gains_and_gammas_are_a_channels_own() {
    let text = format!(
        "{WALL}[[projector]]\nname = \"one\"\npart = [0, 0, 1, 1]\nresolution = [4, 2]\n\
         gain = [1, 0.5, 1]\n\
         gamma = {{ red = 1, green = \"srgb\", blue = [0, 0.25, 1] }}\n"
    );
    let room = Cave::from_toml(&text, "room.toml", [4, 2]).unwrap();
    let projections = Projection::all(&room).unwrap();
    let mut picture = Picture::new(4, 2).unwrap();
    picture.set_pixel(3, 1, [0.2, 1.0, 0.25, 1.0]);
    picture.set_pixel(0, 0, [f32::NAN, 7.0, f32::INFINITY, 1.0]);
    let mut codes = [1; 8];
    projections[0].show(&picture, &mut codes).unwrap();
    assert_eq!(codes, [0x00_bc_ff, 0, 0, 0, 0, 0, 0, 0x33_bc_80]);
    let error = projections[0].show(&picture, &mut codes[1..]).unwrap_err();
    assert!(error.to_string().contains("4 × 2 pixels with 7"), "{error}");
}

const ROOM: &str = r#"
[[wall]]
name = "front"
lower_left = [-1, -1, -1]
lower_right = [1, -1, -1]
upper_left = [-1, 1, -1]

[[wall]]
name = "floor"
lower_left = [-1, -1, 1]
lower_right = [1, -1, 1]
upper_left = [-1, -1, -1]

[[projector]]
name = "pinned"
screen = "floor"
resolution = [100, 80]
corner_pins = [[[0, 0], [0, 0.1]], [[100, 0], [0.9, 0]], [[98, 80], [1, 1]], [[2, 80], [0.1, 0.9]]]
gamma = [0, 0.2, 1]
black = 0.001

[[projector]]
name = "posed"
screen = "front"
resolution = [90, 60]
position = [0, 0, 1]
look = [0, 0, -1]
throw = 1
"#;

/// As `check_faults` reads them.
const FAULTS: &str = r#"
"posed" | "Pinned" | two projectors are named
screen = "front" | screen = "back" | "back", which is not there
screen = "front" | | none of several screens | name = "posed"
throw = 1 | throw = 1\neye = "left"\n[[projector]]\nname = "both"\nscreen = "front"\npart = [0, 0, 1, 1]\nresolution = [9, 9] | only some are for one eye | *
[0, 0, -1] | [0, 0, 1] | none of its light meets it | position = [0, 0, 1]
position = [0, 0, 1] | position = [0, 0, -1] | in the plane of wall "front"
throw = 1 | throw = 1\npart = [0, 0, 1, 1] | both of position and part | part =
position = [0, 0, 1] | part = [0, 0, 1, 1] | `look` is for projectors | look
position = [0, 0, 1] | | none of position, corner_pins | name = "posed"
throw = 1 | throw = 1\nblend = 0 | blend is 0 | blend = 0
throw = 1 | throw = 1\ngain = 2 | gain is 2 | gain = 2
[100, 0], [0.9, 0]] | [100, 0], [0.9, 1]] | cross, or are not convex
[100, 0], [0.9, 0]] | [100, 0], [0.3, 0.7]] | cross, or are not convex
[0, 0.1]], [[100, 0], [0.9, 0]], [[98, 80], [1, 1]], [[2, 80], [0.1, 0.9]] | [0, 0]], [[100, 0], [1, 0]], [[100, 80], [0, 1]], [[0, 80], [1, 1]] | cross, or are not convex
[98, 80] | [98, 81] | pin 3 is outside
, [[2, 80], [0.1, 0.9]] | | there are 3
[[2, 80], [0.1, 0.9]] | [[2, 80], [0.1, 0.9]], [[50, 40], [0.2, 0.5]] | away from where the others
[0, 0.2, 1] | [0, 1.2, 1] | does not rise
[0, 0.2, 1] | "rec709" | no gamma "rec709"
[0, 0.2, 1] | 0.5 | gamma is 0.5
[0, 0.2, 1] | true | `gamma` must be
0.001 | 0.9 | black is 0.9
corner_pins | pins | unknown key `pins`
"#;

#[test]
fn faults_of_projectors_in_rooms_point_at_their_line() {
    check_faults(ROOM, FAULTS, |text| {
        Cave::from_toml(text, "room.toml", [9, 9])
    });
}
