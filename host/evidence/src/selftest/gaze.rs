//! Levels of the gaze: equations 4 to 8 of Mochizuki and Makino.

use super::input::{Inputs, single};
use super::{Case, Effort, Errors, largest, wrong};
use crate::textbook::{printed, printed_level};
use glam::{DMat3, DVec3, Vec3};
use shisen::render::gaze_reference::{self, Limits};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI, TAU};

const F64: &str = "equations 4 to 8 in f64, by arc tangents";
const PRINTED: &str = "equations 4 to 8 as printed, arc cosines in f32";
const TURNED: &str = "the same in f32, the axes by cross products as they come";
const OF_L: &str = "of l, radians";
const OF_LEVEL: &str = "of the level, which goes from 0 to 1";

/// The bound that the documentation of the levels states.
const BOUND: f64 = 1.0e-6;

pub(super) const CASES: &[Case] = cases! {
    [OF_L, F64, PRINTED]:
    // So small an l has as many digits as any.
    "gaze-along-the-line-of-sight", 1.0e-8, |effort| compare(500, effort, true, along),
        "rays within 10⁻⁷ to 10⁻² rad of the line of sight: the cosine is 1";
    "gaze-opposite", BOUND, |effort| compare(501, effort, true, opposite),
        "rays straight back, and within 10⁻⁷ rad of it";
    "gaze-vertical", BOUND, |effort| compare(502, effort, true, poles),
        "rays straight up, down and to the side, where an equation is 0/0";
    [OF_LEVEL, F64, PRINTED]:
    "gaze-at-pi-6", BOUND, |effort| compare(503, effort, false, central_border),
        "rays at the border of the central field";
    "gaze-at-the-outer-border", BOUND, |effort| compare(504, effort, false, outer_border),
        "rays at the border of the visual field, on all sides";
    // Subnormal components have fewer digits: both are given the same.
    "gaze-of-any-length", BOUND, |effort| compare(505, effort, false, any_length),
        "directions 10⁻⁴⁴ to 10³⁸ long";
    ["of the level's change from a ray to its neighbour, and what of it is above the slope of the \
      level times the angle between the two",
     F64,
     PRINTED]:
    "gaze-without-steps", 2.0 * BOUND, continuity,
        "rays from one side to the other of every border of the formula, to the side and behind \
         the viewer, too";
    [OF_LEVEL, F64, TURNED]:
    "gaze-turned", BOUND, |effort| turned(507, effort, anywhere),
        "lines of sight in all directions, the head tilted down to 10⁻³ rad from them, and rays \
         along them, at both borders and anywhere";
    ["of the level, times the distance from the side, radians", F64, TURNED]:
    // The rounding of components along the turned axes.
    "gaze-turned-to-the-side", 1.0e-7, |effort| turned(508, effort, to_the_side),
        "the same viewers, and rays 10⁻⁶ to 10⁻¹ rad from straight to their side, where equation 5 \
         is 0/0 and the level has a step";
};

struct Both {
    single: Gaze,
    double: gaze_reference::Gaze,
}

impl Both {
    /// Returns a viewer who looks along −Z, so that no axis rounds anything. `None` is not reached.
    fn front() -> Option<Self> {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).ok()?;
        let double =
            gaze_reference::Gaze::new(DVec3::NEG_Z, DVec3::Y, Limits::PAPER, Boundary::Printed);
        Some(Self {
            single: Gaze::new(sight, VisualField::PAPER),
            double: double.ok()?,
        })
    }
}

/// Draws directions and compares l, or the level.
fn compare(
    seed: u64,
    effort: Effort,
    of_l: bool,
    mut draw: impl FnMut(&mut Inputs) -> Vec3,
) -> Option<Errors> {
    let both = Both::front()?;
    largest(seed, effort.of(500_000), |inputs, worst| {
        let direction = draw(inputs);
        let exact = both.double.sight(direction.as_dvec3())?;
        let found = both.single.sight(direction);
        let (naive_l, naive_level) = printed(direction);
        if of_l {
            let l = found.map_or(f64::NAN, |sight| sight.l.into());
            worst.ours(l - exact.l);
            worst.naive(f64::from(naive_l) - exact.l);
        } else {
            let level = both.single.level(direction).map_or(f64::NAN, f64::from);
            worst.ours(level - exact.level);
            worst.naive(f64::from(naive_level) - exact.level);
        }
        Some(())
    })
}

/// Returns the ray whose angles are a and b: equations 4 and 5, read backwards, |a| up
/// to π and |b| below π/2.
fn of_angles(a: f64, b: f64) -> Vec3 {
    let (right, forward) = libm::sincos(a);
    single(DVec3::new(right, forward.abs() * libm::tan(b), -forward))
}

/// `radius` from the line of sight in the plane of the two angles, a turn of 0
/// to 1 around it.
fn at(radius: f64, turn: f64) -> Vec3 {
    let (along, across) = libm::sincos(turn * TAU);
    of_angles(radius * across, radius * along)
}

fn along(inputs: &mut Inputs) -> Vec3 {
    let radius = inputs.magnitude(-7.0, -2.0);
    at(radius, inputs.unit())
}

fn opposite(inputs: &mut Inputs) -> Vec3 {
    let away = if inputs.below(10) == 0 {
        0.0
    } else {
        inputs.magnitude(-9.0, -2.0)
    };
    let (x, y) = libm::sincos(TAU * inputs.unit());
    single(DVec3::new(x * away, y * away, 1.0))
}

fn poles(inputs: &mut Inputs) -> Vec3 {
    let mut v = [inputs.sign(), 0.0, 0.0];
    for part in &mut v[1..] {
        let size = [0.0, inputs.magnitude(-40.0, -1.0)][inputs.below(2)];
        *part = size * inputs.sign();
    }
    // Along x or y, the others next to nothing; −0 as well.
    v.rotate_right(inputs.below(2));
    single(DVec3::from_array(v))
}

fn central_border(inputs: &mut Inputs) -> Vec3 {
    let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
    at(FRAC_PI_6 + off, inputs.unit())
}

/// Returns the paper's border at a turn, radians.
fn outer(turn: f64) -> f64 {
    let (along, across) = libm::sincos(turn * TAU);
    let up = if along < 0.0 { 70f64 } else { 60.0 };
    libm::hypot(100.0 * across, up * along).to_radians()
}

fn outer_border(inputs: &mut Inputs) -> Vec3 {
    let turn = inputs.unit();
    let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
    at(outer(turn) + off, turn)
}

fn any_length(inputs: &mut Inputs) -> Vec3 {
    let length = inputs.magnitude(-44.0, 38.0);
    single(inputs.direction() * length)
}

fn continuity(effort: Effort) -> Option<Errors> {
    let both = Both::front()?;
    let tries = effort.of(500_000);
    let mut bounded = 0;
    let found = wrong(506, tries, 0.5, |inputs, worst| {
        let start = at_a_border(inputs);
        let mut next = start;
        let axis = inputs.below(3);
        next[axis] = match inputs.below(3) {
            0 => next[axis].next_up(),
            1 => next[axis].next_down(),
            _ => -next[axis],
        };
        // Across an axis only from next to it: else it is no neighbour.
        if (next - start).length() > 1.0e-6 {
            return;
        }
        worst.verdicts += 1;
        let change = |level: &dyn Fn(Vec3) -> f64| level(next) - level(start);
        let exact = change(&|v| {
            let sight = both.double.sight(v.as_dvec3());
            sight.map_or(f64::NAN, |sight| sight.level)
        });
        let ours = change(&|v| both.single.level(v).map_or(f64::NAN, f64::from));
        let naive = change(&|v| f64::from(printed(v).1));
        worst.ours(ours - exact);
        worst.naive(naive - exact);
        // The reference might have a step, too.
        let most = most_change(start, next);
        bounded += usize::from(most < BOUND * 10.0);
        worst.ours((ours.abs() - most).max(0.0));
        worst.naive((naive.abs() - most).max(0.0));
    });
    found.filter(|_| bounded >= tries / 3)
}

/// Returns a direction next to a border of the formula.
fn at_a_border(inputs: &mut Inputs) -> Vec3 {
    let turn = match inputs.below(3) {
        0 => inputs.unit(),
        // The planes between the quarters, where limits and signs change.
        _ => (inputs.below(4) as f64) / 4.0 + inputs.magnitude(-9.0, -3.0) * inputs.sign(),
    };
    let off = inputs.magnitude(-9.0, -3.0) * inputs.sign();
    let b = FRAC_PI_2 * inputs.range(-1.0, 1.0);
    match inputs.below(4) {
        0 => at(FRAC_PI_6 + off, turn),
        1 => at(outer(turn) + off, turn),
        // Neither before the viewer nor behind: b is folded there.
        2 => of_angles(FRAC_PI_2 * inputs.sign() + off, b),
        _ => of_angles(PI * inputs.range(-1.0, 1.0), b),
    }
}

/// Returns the most that a level without a step may change between two directions.
///
/// With l and L of equations 6 and 7 and φ the turn around the line of sight,
/// the level falls by 1/(L − π/6) a radian of l, and changes by at most as much
/// a radian of L, which changes by at most the difference of the field's limits,
/// 100° − 60°, a radian of φ. L is 60° at least, and l 30° where there is a
/// slope.
fn most_change(start: Vec3, next: Vec3) -> f64 {
    let slope = (1.0 + 40.0 / 30.0) / 30f64.to_radians();
    let step = (next - start).as_dvec3().length();
    // Each angle turns about an axis, on which it has no value.
    let angle = |x: f32, y: f32| {
        let away = libm::hypot(x.into(), y.into()) - step;
        if away > 0.0 { step / away } else { PI }
    };
    slope * libm::hypot(angle(start.z, start.x), angle(start.z, start.y))
}

/// A line of sight in the room, up to `away` from its top of the head.
struct Turned {
    forward: Vec3,
    up: Vec3,
    both: Both,
    /// Right, up and back, exactly.
    axes: DMat3,
}

impl Turned {
    fn new(inputs: &mut Inputs) -> Option<Self> {
        let forward = single(inputs.direction());
        let beside = inputs.across(forward.as_dvec3());
        let away = [1.0, inputs.magnitude(-3.0, 0.0)][inputs.below(2)];
        let up = single(forward.as_dvec3() * inputs.sign() + beside * away);
        let sight = LineOfSight::new(Vec3::ZERO, forward, up).ok()?;
        let (f, u) = (forward.as_dvec3(), up.as_dvec3());
        let double = gaze_reference::Gaze::new(f, u, Limits::PAPER, Boundary::Printed);
        let right = f.cross(u).try_normalize()?;
        let back = -f.try_normalize()?;
        Some(Self {
            forward,
            up,
            both: Both {
                single: Gaze::new(sight, VisualField::PAPER),
                double: double.ok()?,
            },
            axes: DMat3::from_cols(right, back.cross(right), back),
        })
    }

    /// Returns the direction in the axes of a viewer who looks along −Z, by plain cross products.
    fn seen(&self, direction: Vec3) -> Vec3 {
        let forward = self.forward.normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        Vec3::new(
            direction.dot(right),
            direction.dot(up),
            -direction.dot(forward),
        )
    }
}

/// Levels of turned viewers, for rays given in their own axes.
fn turned(seed: u64, effort: Effort, draw: fn(&mut Inputs) -> Vec3) -> Option<Errors> {
    largest(seed, effort.of(500_000), |inputs, worst| {
        let turned = Turned::new(inputs)?;
        let ahead = draw(inputs).as_dvec3();
        let direction = single(turned.axes * ahead);
        let exact = turned.both.double.sight(direction.as_dvec3())?;
        // Nearer to the side the same turn of a ray changes its angles by more.
        let away = libm::hypot(ahead.y, ahead.z) / ahead.length();
        let weight = if away < SIDE { away } else { 1.0 };
        let level = turned.both.single.level(direction);
        worst.ours((level.map_or(f64::NAN, f64::from) - exact.level) * weight);
        let naive = printed_level(turned.seen(direction));
        worst.naive((f64::from(naive) - exact.level) * weight);
        Some(())
    })
}

/// The largest angle that counts as next to the side, radians.
const SIDE: f64 = 0.1;

/// Makes a direction on a border, along the line of sight or anywhere but next to the side.
fn anywhere(inputs: &mut Inputs) -> Vec3 {
    loop {
        let turn = inputs.unit();
        let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
        let ahead = match inputs.below(4) {
            0 => at(inputs.magnitude(-7.0, -2.0), turn),
            1 => at(FRAC_PI_6 + off, turn),
            2 => at(outer(turn) + off, turn),
            _ => single(inputs.direction()),
        };
        let exact = ahead.as_dvec3();
        if libm::hypot(exact.y, exact.z) > SIDE * exact.length() {
            return ahead;
        }
    }
}

fn to_the_side(inputs: &mut Inputs) -> Vec3 {
    let (up, back) = libm::sincos(TAU * inputs.unit());
    let away = inputs.magnitude(-6.0, libm::log10(SIDE));
    single(DVec3::new(inputs.sign(), up * away, back * away))
}
