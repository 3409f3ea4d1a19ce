//! Levels of the gaze: equations 4 to 8 of Mochizuki and Makino.

use super::input::{Inputs, single};
use super::{BROKEN, Case, Effort, Errors, Worst, worse};
use crate::gaze_reference::{self, Limits};
use glam::{DMat3, DVec3, Vec3};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField};
use std::f64::consts::{FRAC_PI_6, TAU};

const F64: &str = "equations 4 to 8 in f64, by arc tangents";
const PRINTED: &str = "equations 4 to 8 as printed, arc cosines in f32";
const OF_L: &str = "of l, radians";
const OF_LEVEL: &str = "of the level, which goes from 0 to 1";

/// What the documentation of the levels promises.
const BOUND: f64 = 1.0e-6;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "gaze-along-the-line-of-sight",
        hard: "rays within 10⁻⁷ to 10⁻² rad of the line of sight: the cosine is 1",
        error: OF_L,
        reference: F64,
        naive: PRINTED,
        // So small an l has as many digits as any.
        bound: 1.0e-8,
        measure: along,
    },
    Case {
        name: "gaze-opposite",
        hard: "rays straight back, and within 10⁻⁷ rad of it",
        error: OF_L,
        reference: F64,
        naive: PRINTED,
        bound: BOUND,
        measure: opposite,
    },
    Case {
        name: "gaze-vertical",
        hard: "rays straight up, down and to the side, where an equation is 0/0",
        error: OF_L,
        reference: F64,
        naive: PRINTED,
        bound: BOUND,
        measure: poles,
    },
    Case {
        name: "gaze-at-pi-6",
        hard: "rays at the border of the central field",
        error: OF_LEVEL,
        reference: F64,
        naive: PRINTED,
        bound: BOUND,
        measure: central_border,
    },
    Case {
        name: "gaze-at-the-outer-border",
        hard: "rays at the border of the visual field, on all sides",
        error: OF_LEVEL,
        reference: F64,
        naive: PRINTED,
        bound: BOUND,
        measure: outer_border,
    },
    Case {
        name: "gaze-of-any-length",
        hard: "directions 10⁻⁴⁴ to 10³⁸ long",
        error: OF_LEVEL,
        reference: F64,
        naive: PRINTED,
        // Subnormal components have fewer digits: both are given the same.
        bound: BOUND,
        measure: any_length,
    },
    Case {
        name: "gaze-without-steps",
        hard: "rays from one side to the other of every border of the formula",
        error: "of the level's change from a ray to its neighbour",
        reference: F64,
        naive: PRINTED,
        bound: 2.0 * BOUND,
        measure: continuity,
    },
    Case {
        name: "gaze-turned",
        hard: "lines of sight in all directions, the head tilted down to 10⁻³ rad from them, and \
               rays along them, at both borders and anywhere",
        error: OF_LEVEL,
        reference: F64,
        naive: "the same in f32, the axes by cross products as they come",
        bound: BOUND,
        measure: turned,
    },
];

struct Both {
    single: Gaze,
    double: gaze_reference::Gaze,
}

impl Both {
    /// Forward, so that no axis rounds anything. `None` is not reached.
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

/// l and the level as printed.
fn printed(v: Vec3) -> (f32, f32) {
    use std::f32::consts::{FRAC_PI_3, FRAC_PI_6, PI};
    let (f, r, u) = (-v.z, v.x, v.y);
    let alpha = (f / (f * f + r * r).sqrt()).acos();
    let beta = (f / (f * f + u * u).sqrt()).abs().acos();
    let l = (alpha * alpha + beta * beta).sqrt();
    let (across, along) = if u < 0.0 {
        (5.0 * PI / 9.0, 7.0 * PI / 18.0)
    } else {
        (5.0 * PI / 9.0, FRAC_PI_3)
    };
    let (x, y) = (across * alpha / l, along * beta / l);
    let big_l = (x * x + y * y).sqrt();
    let level = if l <= FRAC_PI_6 {
        1.0
    } else if l < big_l {
        (big_l - l) / (big_l - FRAC_PI_6)
    } else if l >= big_l {
        0.0
    } else {
        f32::NAN
    };
    (l, level)
}

/// The level as printed, of a viewer who looks along −Z.
pub(crate) fn printed_level(v: Vec3) -> f32 {
    printed(v).1
}

/// Draws directions and compares l, or the level.
fn compare(
    seed: u64,
    effort: Effort,
    of_l: bool,
    mut draw: impl FnMut(&mut Inputs) -> Vec3,
) -> Errors {
    let (mut inputs, mut worst) = (Inputs::new(seed), Worst::NONE);
    let Some(both) = Both::front() else {
        return BROKEN;
    };
    for _ in 0..effort.of(500_000) {
        let direction = draw(&mut inputs);
        let Some(exact) = both.double.sight(direction.as_dvec3()) else {
            continue;
        };
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
    }
    worst.0
}

/// In front of the viewer: `radius` from the line of sight in the plane of
/// the two angles, a turn of 0 to 1 around it.
fn at(radius: f64, turn: f64) -> Vec3 {
    let (along, across) = (turn * TAU).sin_cos();
    single(DVec3::new(
        (radius * across).tan(),
        (radius * along).tan(),
        -1.0,
    ))
}

fn along(effort: Effort) -> Errors {
    compare(500, effort, true, |inputs| {
        let radius = inputs.magnitude(-7.0, -2.0);
        at(radius, inputs.unit())
    })
}

fn opposite(effort: Effort) -> Errors {
    compare(501, effort, true, |inputs| {
        let away = if inputs.below(10) == 0 {
            0.0
        } else {
            inputs.magnitude(-9.0, -2.0)
        };
        let (x, y) = (TAU * inputs.unit()).sin_cos();
        single(DVec3::new(x * away, y * away, 1.0))
    })
}

fn poles(effort: Effort) -> Errors {
    compare(502, effort, true, |inputs| {
        let mut v = [inputs.sign(), 0.0, 0.0];
        for part in &mut v[1..] {
            let size = [0.0, inputs.magnitude(-40.0, -1.0)][inputs.below(2)];
            *part = size * inputs.sign();
        }
        // Along x or y, the others next to nothing; −0 as well.
        v.rotate_right(inputs.below(2));
        single(DVec3::from_array(v))
    })
}

fn central_border(effort: Effort) -> Errors {
    compare(503, effort, false, |inputs| {
        let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
        at(FRAC_PI_6 + off, inputs.unit())
    })
}

/// The paper's border at a turn, radians.
fn outer(turn: f64) -> f64 {
    let (along, across) = (turn * TAU).sin_cos();
    let up = if along < 0.0 { 70f64 } else { 60.0 };
    (100.0 * across).hypot(up * along).to_radians()
}

fn outer_border(effort: Effort) -> Errors {
    compare(504, effort, false, |inputs| {
        let turn = inputs.unit();
        let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
        let radius = outer(turn) + off;
        // Beyond a right angle to the side it is not in front any more.
        let (along, across) = (turn * TAU).sin_cos();
        let (a, b) = (radius * across, radius * along);
        let forward = if a.abs() > TAU / 4.0 { 1.0 } else { -1.0 };
        single(DVec3::new(a.tan().abs().copysign(a), b.tan(), forward))
    })
}

fn any_length(effort: Effort) -> Errors {
    compare(505, effort, false, |inputs| {
        let length = inputs.magnitude(-44.0, 38.0);
        single(inputs.direction() * length)
    })
}

fn continuity(effort: Effort) -> Errors {
    let (mut inputs, mut worst) = (Inputs::new(506), Worst::NONE);
    let Some(both) = Both::front() else {
        return BROKEN;
    };
    let borders = |inputs: &mut Inputs| {
        let turn = match inputs.below(3) {
            0 => inputs.unit(),
            // The planes between the quarters, where limits and signs change.
            _ => (inputs.below(4) as f64) / 4.0 + inputs.magnitude(-9.0, -3.0) * inputs.sign(),
        };
        let radius = match inputs.below(3) {
            0 => FRAC_PI_6,
            1 => outer(turn).min(1.5),
            _ => inputs.range(0.0, 1.5),
        };
        at(radius + inputs.magnitude(-9.0, -3.0) * inputs.sign(), turn)
    };
    for _ in 0..effort.of(500_000) {
        let start = borders(&mut inputs);
        let mut next = start;
        let axis = inputs.below(2);
        next[axis] = match inputs.below(3) {
            0 => next[axis].next_up(),
            1 => next[axis].next_down(),
            _ => -next[axis],
        };
        // Across an axis only from next to it: else it is no neighbour.
        if (next - start).length() > 1.0e-6 {
            continue;
        }
        let exact = |v: Vec3| {
            both.double
                .sight(v.as_dvec3())
                .map_or(f64::NAN, |s| s.level)
        };
        let change = exact(next) - exact(start);
        let level = |v: Vec3| both.single.level(v).map_or(f64::NAN, f64::from);
        worst.ours(level(next) - level(start) - change);
        let naive = |v: Vec3| f64::from(printed(v).1);
        worst.0.naive = worse(worst.0.naive, naive(next) - naive(start) - change);
    }
    worst.0
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

    /// In the axes of a viewer who looks along −Z, without care.
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

fn turned(effort: Effort) -> Errors {
    let (mut inputs, mut worst) = (Inputs::new(507), Worst::NONE);
    for _ in 0..effort.of(500_000) {
        let Some(turned) = Turned::new(&mut inputs) else {
            continue;
        };
        let turn = inputs.unit();
        let off = inputs.magnitude(-9.0, -2.0) * inputs.sign();
        let ahead = match inputs.below(4) {
            0 => at(inputs.magnitude(-7.0, -2.0), turn),
            1 => at(FRAC_PI_6 + off, turn),
            2 => at((outer(turn) + off).min(1.5), turn),
            _ => single(inputs.direction()),
        };
        let direction = single(turned.axes * ahead.as_dvec3());
        let Some(exact) = turned.both.double.sight(direction.as_dvec3()) else {
            continue;
        };
        let level = turned.both.single.level(direction);
        worst.ours(level.map_or(f64::NAN, f64::from) - exact.level);
        let naive = printed_level(turned.seen(direction));
        worst.naive(f64::from(naive) - exact.level);
    }
    worst.0
}
