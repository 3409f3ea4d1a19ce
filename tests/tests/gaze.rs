//! The gaze's levels against double precision, and the share of a CAVE that
//! they trace.

use glam::{DVec3, Vec3};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::render::gaze_reference::{self, Limits};
use shisen_core::frame::View;
use shisen_core::gaze::{Boundary, Detail, Gaze, LineOfSight, VisualField, Zone};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;

/// Largest error allowed of l, radians, and of the level.
const BOUND: f64 = 1.0e-6;

/// A gaze in both precisions.
struct Both {
    single: Gaze,
    double: gaze_reference::Gaze,
}

impl Both {
    fn new(look: Vec3, up: Vec3, boundary: Boundary) -> Self {
        let sight = LineOfSight::new(Vec3::ZERO, look, up).unwrap();
        let field = VisualField::PAPER.with_boundary(boundary);
        let (look, up) = (look.as_dvec3(), up.as_dvec3());
        Self {
            single: Gaze::new(sight, field),
            double: gaze_reference::Gaze::new(look, up, Limits::PAPER, boundary).unwrap(),
        }
    }

    /// Axes that round nothing.
    fn front(boundary: Boundary) -> Self {
        Self::new(Vec3::NEG_Z, Vec3::Y, boundary)
    }
}

/// Compares both precisions on a direction: errors up to the bounds of l and of the level,
/// exact levels and equal bounces but next to where they jump.
fn check(both: &Both, direction: Vec3, l_bound: f64, level_bound: f64) {
    let found = both.single.sight(direction).unwrap();
    let exact = both.double.sight(direction.as_dvec3()).unwrap();
    let says = || format!("{direction:?}: {found:?}, not {exact:?}");
    let numbers = [
        found.m_alpha,
        found.m_beta,
        found.l,
        found.big_l,
        found.level,
    ];
    assert!(numbers.iter().all(|n| n.is_finite()), "{}", says());
    let l = (f64::from(found.l) - exact.l).abs();
    let level = (f64::from(found.level) - exact.level).abs();
    assert!(l <= l_bound, "{} l errs by {l:e}", says());
    assert!(
        level <= level_bound,
        "{} the level errs by {level:e}",
        says()
    );
    let zone = (found.level, found.zone);
    if exact.l <= Limits::PAPER.central - l_bound {
        assert_eq!(zone, (1.0, Zone::Central), "{}", says());
    }
    if exact.l >= exact.big_l + l_bound + level_bound {
        assert_eq!(zone, (0.0, Zone::Outside), "{}", says());
    }
    assert_eq!(found.level > 0.0, found.l < found.big_l, "{}", says());
    assert_eq!(found.level > 0.0, found.zone != Zone::Outside, "{}", says());
    assert_eq!(both.single.level(direction), Some(found.level));
    let is_near_a_jump =
        (1..=3).any(|k| (3.0 * exact.level - f64::from(k)).abs() <= 3.0 * level_bound);
    if !is_near_a_jump {
        let bounces = Detail::of_level(found.level).unwrap().bounces(3);
        assert_eq!(
            bounces,
            gaze_reference::bounces(exact.level, 3),
            "{}",
            says()
        );
    }
}

fn single(v: [f64; 3]) -> Vec3 {
    DVec3::from(v).as_vec3()
}

/// In the plane of the two angles, the way that a `turn` of 0 to 1 gives, as
/// far as `radius`; in front of the viewer.
fn at(radius: f64, turn: f64) -> Vec3 {
    let (along, across) = (turn * std::f64::consts::TAU).sin_cos();
    single([(radius * across).tan(), (radius * along).tan(), -1.0])
}

/// Returns directions that are hard, by their components: along and next to the axes,
/// the planes between them and the diagonals, at every distance; on the
/// borders of the zones and next to them.
fn hard(random: &mut Random) -> Vec3 {
    let small = |random: &mut Random| 10f64.powf(random.range(-40.0, 0.0)) * sign(random);
    let limit = |turn: f64| {
        let (along, across) = (turn * std::f64::consts::TAU).sin_cos();
        let up = if along < 0.0 { 70f64 } else { 60.0 };
        (100.0 * across).hypot(up * along).to_radians()
    };
    match random.below(6) {
        0 => {
            let mut v = [small(random), small(random), small(random)];
            v[random.below(3)] = sign(random);
            single(v)
        }
        1 => {
            let mut v = random.direction();
            v[random.below(3)] *= 10f64.powf(random.range(-40.0, 0.0));
            single(v)
        }
        2 => {
            let mut v = random.direction();
            let (i, j) = (random.below(3), random.below(3));
            v[i] = v[j] * (1.0 + small(random) * 1.0e-3);
            single(v)
        }
        3 => {
            let turn = random.unit();
            at(30f64.to_radians() + small(random) * 1.0e-3, turn)
        }
        4 => {
            let turn = random.unit();
            at(limit(turn) + small(random) * 1.0e-3, turn)
        }
        _ => {
            let v = [sign(random), sign(random), sign(random)];
            let mask = random.below(7) + 1;
            single([0, 1, 2].map(|i| if mask >> i & 1 == 1 { v[i] } else { 0.0 * v[i] }))
        }
    }
}

fn sign(random: &mut Random) -> f64 {
    if random.unit() < 0.5 { -1.0 } else { 1.0 }
}

#[test]
fn errors_from_components_are_below_a_millionth() {
    let count = cases("directions by their components", 20_000, 400_000);
    for boundary in [Boundary::Printed, Boundary::Ellipse] {
        let both = Both::front(boundary);
        let mut random = Random::new(1);
        for i in 0..count {
            let direction = if i % 2 == 0 {
                single(random.direction())
            } else {
                hard(&mut random)
            };
            check(&both, direction, BOUND, BOUND);
        }
    }
}

#[test]
fn errors_from_rays_in_the_world_are_below_their_bounds() {
    let count = cases("directions in the world", 20_000, 400_000);
    for boundary in [Boundary::Printed, Boundary::Ellipse] {
        let mut random = Random::new(2);
        let mut both = Both::front(boundary);
        for i in 0..count {
            if i % 1000 == 0 {
                let (look, up) = (single(random.direction()), single(random.direction()));
                both = Both::new(look, up, boundary);
            }
            let axes = both.single.line_of_sight();
            let room_from_sight =
                |v: Vec3| axes.right() * v.x + axes.up() * v.y - axes.forward() * v.z;
            let direction = match i % 4 {
                0 => room_from_sight(hard(&mut random)),
                // Next to the line of sight, as the eye's own pixels are.
                1 => axes.forward() + single(random.direction()) * 0.01,
                _ => single(random.direction()),
            };
            let unit = direction.as_dvec3().normalize();
            let part = |axis: Vec3| axis.as_dvec3().dot(unit);
            let (f, r, u) = (part(axes.forward()), part(axes.right()), part(axes.up()));
            // Near the axes to the side and up, one of the angles is that of
            // two components that are next to nothing. Upwards the level is 0.
            let level_bound = BOUND + 2.0e-7 / f.hypot(u);
            let l_bound = level_bound + 2.0e-7 / f.hypot(r);
            check(&both, direction, l_bound, level_bound);
        }
    }
}

/// Returns what pixels see, summed: central, peripheral and outside, the level, bounces, and their
/// number.
fn sums(gaze: &Gaze, view: &View) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for (x, y) in (0..view.rows()).flat_map(|y| (0..view.columns()).map(move |x| (x, y))) {
        let direction = view.direction(x as f32, y as f32).unwrap();
        let sight = gaze.sight(direction).unwrap();
        let zones = [Zone::Central, Zone::Peripheral, Zone::Outside];
        let [central, peripheral, outside] = zones.map(|zone| f64::from(sight.zone == zone));
        let level = f64::from(sight.level);
        let bounces = f64::from(Detail::of_level(sight.level).unwrap().bounces(3));
        sums = add(sums, [central, peripheral, outside, level, bounces, 1.0]);
    }
    sums
}

fn add(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Means to four digits, as a table has them.
fn row(sums: [f64; 6]) -> [String; 5] {
    std::array::from_fn(|i| format!("{:.4}", sums[i] / sums[5]))
}

#[test]
fn the_cave_is_traced_as_far_as_is_known() {
    let scenes: serde_json::Value =
        serde_json::from_str(include_str!("../reference/cave-scenes.json")).unwrap();
    let pixels = [0, 1].map(|i| scenes["cave"]["pixels"][i].as_u64().unwrap() as u32);
    let cave = Cave::built_in(BuiltInCave::ThreeWall, pixels).unwrap();
    // Walls that the viewer looks at, and those beside, below and above the line of sight.
    let ahead = [["0.2487", "0.7513", "0.0000", "0.7994", "1.9873"]; 2];
    let beside = [
        ["0.0000", "0.3303", "0.6697", "0.1279", "0.2288"],
        ["0.0000", "0.3321", "0.6679", "0.1319", "0.2410"],
    ];
    let below = [["0.0000", "0.2762", "0.7238", "0.0820", "0.1219"]; 2];
    let above = [["0.0000", "0.2211", "0.7789", "0.0544", "0.0687"]; 2];
    let means = [
        ["0.0829", "0.4529", "0.4642", "0.3371", "0.7814"],
        ["0.0829", "0.4345", "0.4826", "0.3279", "0.7636"],
    ];
    for (state, expected, mean) in [
        ("1", [ahead, beside, below], means[0]),
        ("2", [above, beside, ahead], means[1]),
    ] {
        let axis = |name: &str| {
            Vec3::from([0, 1, 2].map(|i| scenes["states"][state][name][i].as_f64().unwrap() as f32))
        };
        let sight = LineOfSight::new(Vec3::ZERO, axis("Ef"), axis("Eu")).unwrap();
        assert_eq!(sight.right(), axis("Er"));
        let gaze = Gaze::new(sight, VisualField::PAPER);
        let mut all = [0.0; 6];
        for (wall, expected) in cave.walls.iter().zip(expected) {
            for (eye, expected) in Eye::STEREO.into_iter().zip(expected) {
                let view = wall.view_from(Viewer::default().eye(eye)).unwrap();
                let share = sums(&gaze, &view);
                assert_eq!(row(share), expected, "{state} {} {eye}", wall.name);
                all = add(all, share);
            }
        }
        assert_eq!(row(all), mean, "{state}");
    }
}
