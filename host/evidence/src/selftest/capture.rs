//! Lines of sight off a mirrored spheroid, and the dome masters they make.

use super::input::Inputs;
use super::{Case, Effort, Errors, largest};
use crate::textbook::{angle, quadratic, traced, traced_mirror};
use glam::{DVec2, Mat3, Vec3};
use shisen::dome::Mirror;
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::frame::{DomePose, DomeProjection, MirrorCamera, View};
use std::f64::consts::{FRAC_PI_2, TAU};

const F64: &str = "equations 10 to 45 in f64";
const TRACED: &str = "a ray from the viewpoint through the screen, the textbook's quadratic, the \
                      gradient's normal and d − 2(d·n)n, all in f32";
const PIXELS: &str = "of the reflected ray, pixels of a picture of 4096²";

/// The bound that the documentation of the mirrors states: a thousandth of a pixel.
const BOUND: f64 = 1.0e-3;

pub(super) const CASES: &[Case] = cases! {
    [PIXELS, F64, TRACED]:
    "capture-at-the-rim", BOUND, |effort| { drawn(600, effort, named, |inputs| { 1.0 - inputs.magnitude(-7.0, -2.0) }) },
        "the last 10⁻⁷ to 10⁻² before the rim, where rays are level";
    "capture-at-the-centre", 5.0e-5, |effort| drawn(601, effort, named, |inputs| inputs.magnitude(-20.0, -2.0)),
        "the innermost 10⁻²⁰ to 10⁻², where rays come straight back";
    [PIXELS, F64, "d₁ = b₁·tan 2γ₁ in f32, and traced from there"]:
    "capture-next-to-parallel", BOUND, |effort| largest(604, effort.of(2_000), next_to_parallel),
        "edges with a·tan β₁ from 1 − 10⁻³ to 1: tan 2γ₁ has its pole";
    [PIXELS, F64, TRACED]:
    "capture-from-far", BOUND, |effort| drawn(602, effort, far, Inputs::unit),
        "viewpoints 10² to 10⁷ radii away, where a pixel is less than an f32 there";
    "capture-from-next-to-the-pole", BOUND, |effort| drawn(603, effort, near, Inputs::unit),
        "viewpoints 10⁻⁶ to 10⁻¹ of the polar radius above the pole";
    [PIXELS, F64, "the same ray traced where the mirror is"]:
    "capture-by-a-mirror-of-a-millionth", BOUND, small,
        "a mirror of a millionth of its distance from the origin";
    ["of the angle on the dome, and of the one in the picture, back there, parts of a pixel of a \
      picture of 4096²",
     "the dome's angle in f64; the picture's, where it started",
     "tan⁻¹(k·r) + 2·tan⁻¹(a·tan(sin⁻¹ b)) in f32, by halving"]:
    "capture-there-and-back", 2.0e-3, |effort| largest(606, effort.of(2_000), there_and_back),
        "from the picture's angle to the dome's and back, at any mirror";
};

fn pixels(angle: f64) -> f64 {
    angle / FRAC_PI_2 * 2048.0
}

fn place(inputs: &mut Inputs, radius: f64) -> [f32; 2] {
    let (sin, cos) = (TAU * inputs.unit()).sin_cos();
    let [u, v] = [radius * cos, radius * sin].map(|x| x as f32);
    if u * u + v * v <= 1.0 {
        [u, v]
    } else {
        [radius as f32, 0.0]
    }
}

fn compare(worst: &mut Errors, single: &SpheroidMirror, double: &Mirror, [u, v]: [f32; 2]) {
    let b1 = double.parameters().b1;
    let (_, exact) = double.reflect(DVec2::new(f64::from(u), f64::from(v)) * b1);
    let error = |found: Vec3| pixels(angle(found.as_dvec3(), exact));
    let ours = single.pixel(u, v, Mapping::Screen);
    worst.ours(ours.map_or(f64::NAN, |found| error(found.direction)));
    worst.naive(error(traced_mirror(single, [u, v])));
}

fn perspective(a: f32, p: f32) -> Option<(SpheroidMirror, Mirror)> {
    let double = Mirror::perspective(f64::from(a), f64::from(p));
    Some((SpheroidMirror::perspective(a, p).ok()?, double.ok()?))
}

/// Returns one of the paper's two mirrors with a viewpoint, or the best one.
fn named(inputs: &mut Inputs) -> Option<(SpheroidMirror, Mirror)> {
    let mirror = [
        SpheroidMirror::PAPER_SPHERE,
        SpheroidMirror::PAPER_SPHEROID,
        SpheroidMirror::BEST,
    ][inputs.below(3)];
    perspective(mirror.axis_ratio(), mirror.viewpoint()?)
}

fn drawn(
    seed: u64,
    effort: Effort,
    mut mirror: impl FnMut(&mut Inputs) -> Option<(SpheroidMirror, Mirror)>,
    mut radius: impl FnMut(&mut Inputs) -> f64,
) -> Option<Errors> {
    largest(seed, effort.of(2_000), |inputs, worst| {
        let Some((single, double)) = mirror(inputs) else {
            return worst.ours(f64::NAN);
        };
        for _ in 0..50 {
            let radius = radius(inputs);
            let place = place(inputs, radius);
            compare(worst, &single, &double, place);
        }
    })
}

fn far(inputs: &mut Inputs) -> Option<(SpheroidMirror, Mirror)> {
    let a = inputs.range(0.8, 5.0) as f32;
    perspective(a, a * inputs.magnitude(2.0, 7.0) as f32)
}

fn near(inputs: &mut Inputs) -> Option<(SpheroidMirror, Mirror)> {
    let a = inputs.range(0.8, 5.0) as f32;
    perspective(a, a * (1.0 + inputs.magnitude(-6.0, -1.0) as f32))
}

fn next_to_parallel(inputs: &mut Inputs, worst: &mut Errors) {
    let a = inputs.range(0.8, 5.0) as f32;
    let slope = 1.0 - inputs.magnitude(-7.0, -3.0);
    let beta1 = ((slope / f64::from(a)).atan() as f32).min(libm::atan2f(1.0, a));
    let Ok(single) = SpheroidMirror::from_edge(a, beta1) else {
        return worst.ours(f64::NAN);
    };
    // Rounded, the edge may be beyond the last there is.
    let last = f64::from(a).recip().atan();
    let Ok(double) = Mirror::from_edge(f64::from(a), f64::from(beta1).min(last)) else {
        return;
    };
    let b1 = double.parameters().b1;
    let gamma = (a * beta1.tan()).atan();
    let naive_d1 = beta1.sin() * (2.0 * gamma).tan();
    for _ in 0..50 {
        let radius = inputs.unit();
        let [u, v] = place(inputs, radius);
        let (_, exact) = double.reflect(DVec2::new(f64::from(u), f64::from(v)) * b1);
        let error = |found: Vec3| pixels(angle(found.as_dvec3(), exact));
        let ours = single.pixel(u, v, Mapping::Screen);
        worst.ours(ours.map_or(f64::NAN, |found| error(found.direction)));
        let c1 = a * beta1.cos();
        let screen = [u, v].map(|x| x * beta1.sin());
        let p = Some(c1 + naive_d1);
        worst.naive(error(traced(a, p, c1, screen, Vec3::ZERO)));
    }
}

fn small(effort: Effort) -> Option<Errors> {
    const SIZE: u32 = 4096;
    let distance = 100.0;
    let radius = 1.0e-6 * distance as f32;
    largest(605, effort.of(200), |inputs, worst| {
        let (single, double) = named(inputs)?;
        let position = (inputs.direction() * distance).as_vec3();
        let camera = MirrorCamera {
            mirror: single,
            mapping: Mapping::Screen,
            radius,
            viewpoint: 0.0,
            mirrored: false,
        };
        // The capture's own axes, so that nothing but the place is hard.
        let pose = DomePose {
            position,
            room_from_capture: Mat3::IDENTITY,
        };
        let Ok(view) = View::dome(DomeProjection::Mirror(camera), pose, SIZE) else {
            worst.ours(f64::NAN);
            return None;
        };
        let b1 = double.parameters().b1;
        for _ in 0..50 {
            let at = inputs.unit().sqrt() * 0.999;
            let [u, v] = place(inputs, at);
            // The pixel's own place.
            let pixel = [u, -v].map(|x| ((x + 1.0) * 0.5 * SIZE as f32 - 0.5).round());
            let [u, v] = pixel.map(|x| (f64::from(x) + 0.5) / f64::from(SIZE) * 2.0 - 1.0);
            let (_, exact) = double.reflect(DVec2::new(u, -v) * b1);
            let ours = view.direction(pixel[0], pixel[1]);
            let error = |found: Vec3| pixels(angle(found.as_dvec3(), exact));
            worst.ours(ours.map_or(f64::NAN, error));
            // The same mirror among the things of the scene.
            let screen = [u, -v].map(|x| (x * b1) as f32);
            worst.naive(error(in_place(&single, screen, radius, position)));
        }
        Some(())
    })
}

/// [`traced`], with everything in metres of the scene.
fn in_place(mirror: &SpheroidMirror, screen: [f32; 2], radius: f32, at: Vec3) -> Vec3 {
    let Some(p) = mirror.viewpoint() else {
        return Vec3::NAN;
    };
    let (a, c1) = (
        mirror.axis_ratio() * radius,
        mirror.screen_distance() * radius,
    );
    let origin = at - Vec3::Z * (p * radius);
    let through = at + Vec3::new(screen[0] * radius, screen[1] * radius, -c1);
    let direction = (through - origin).normalize();
    let weights = Vec3::new(1.0, 1.0, radius / a * (radius / a)) / (radius * radius);
    let t = quadratic(origin - at, direction, weights).map_or(f32::NAN, |t| t[0]);
    let normal = ((origin + direction * t - at) * weights).normalize();
    direction - normal * (2.0 * direction.dot(normal))
}

fn there_and_back(inputs: &mut Inputs, worst: &mut Errors) {
    let a = inputs.range(0.8, 5.0) as f32;
    let above = inputs.magnitude(-3.0, 6.0) as f32;
    let Some((mirror, double)) = perspective(a, a * (1.0 + above)) else {
        return worst.ours(f64::NAN);
    };
    for _ in 0..10 {
        let r_d = (FRAC_PI_2 * inputs.unit()) as f32;
        let theta = mirror.theta(r_d);
        let exact = double.theta(f64::from(r_d).min(FRAC_PI_2));
        worst.ours(theta.map_or(f64::NAN, |theta| pixels(f64::from(theta) - exact)));
        let back = theta.and_then(|theta| mirror.r_d(theta.min(std::f32::consts::FRAC_PI_2)));
        let error = |back: f32| pixels(f64::from(back) - f64::from(r_d));
        worst.ours(back.map_or(f64::NAN, error));
        if let Some(theta) = theta {
            worst.naive(error(halved(&mirror, theta)));
        }
    }
}

/// `r_d` of θ by the paper's formulas of β, as printed, in f32, by halving β.
fn halved(mirror: &SpheroidMirror, theta: f32) -> f32 {
    let a = mirror.axis_ratio();
    let Some(p) = mirror.viewpoint() else {
        return f32::NAN;
    };
    let of = |beta: f32| {
        let (b, c) = (beta.sin(), a * beta.cos());
        let gamma = (a * beta.tan()).atan();
        (b / (p - c), (b / (p - c)).atan() + 2.0 * gamma)
    };
    let (mut low, mut high) = (0.0, mirror.edge());
    for _ in 0..40 {
        let middle = f32::midpoint(low, high);
        if of(middle).1 < theta {
            low = middle;
        } else {
            high = middle;
        }
    }
    let r = of(low).0 / of(mirror.edge()).0;
    r * std::f32::consts::FRAC_PI_2
}
