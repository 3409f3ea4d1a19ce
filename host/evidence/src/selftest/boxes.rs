//! Rays and boxes: a box whose contents a ray meets must never be missed.

use super::input::{Inputs, single};
use super::{Case, Effort, Errors, UNIT, wrong};
use glam::{DVec3, Vec3};
use shisen_core::numeric::largest_magnitude;
use shisen_core::shape::{Ray, Slabs};

const LOST: &str = "boxes missed that the ray meets";
const SMITS: &str = "Smits' test of 1998: (low − o)/d and (high − o)/d, by the sign of d";
const GRID: &str = "points of the box that the ray goes through, on a grid where f32 is exact";

pub(super) const CASES: &[Case] = cases! {
    [LOST, GRID, SMITS]:
    "box-along-its-axes", 0.0, |effort| missed(300, effort, along_axes),
        "directions with components that are 0, or −0";
    "box-from-its-planes", 0.0, |effort| missed(301, effort, from_planes),
        "origin on the plane of a face, or on the face, and along it: 0·∞";
    "box-without-thickness", 0.0, |effort| missed(302, effort, flat),
        "boxes around level triangles, edges and points";
    ["boxes missed that the ray meets, and nothings that it meets", GRID, SMITS]:
    "box-without-end", 0.0, |effort| wrong(303, effort.of(500_000), 0.5, infinite),
        "boxes from −∞ to ∞ on some axes; and one of ∞ to −∞, which is nothing";
    [LOST, GRID, SMITS]:
    "box-by-subnormal-directions", 0.0, |effort| missed(304, effort, subnormal),
        "components of 10⁻⁴⁵ to 10⁻³⁰ beside others of 1: reciprocals that are no number";
    [LOST, "slabs in f64", SMITS]:
    "box-at-its-corners-from-far", 0.0, |effort| missed(305, effort, corners_from_far),
        "rays through corners and edges from 10 to 10⁶ m, boxes of up to 16 m";
    ["how far beside a box is still entered, 2⁻²⁴ of the farthest coordinate",
     "slabs in f64",
     SMITS]:
    // A box is widened by the rounding of the worst ray: some boxes are entered in vain so
    // that none is missed. Smits' test, exact here, misses boxes of the cases above.
    "box-beside-the-ray", 40.0, |effort| wrong(306, effort.of(200_000), 0.1, beside),
        "rays that pass a box by: what the caution costs that misses none";
};

fn ours(ray: &Ray, low: Vec3, high: Vec3) -> bool {
    let finite = |v: Vec3| Vec3::select(v.is_finite_mask(), v, Vec3::ZERO);
    let extent = largest_magnitude(finite(low)).max(largest_magnitude(finite(high)));
    let (near, far) = Slabs::new(ray, extent).interval(low, high);
    near <= far && far >= 0.0
}

fn smits(ray: &Ray, low: Vec3, high: Vec3) -> bool {
    let (o, d) = (ray.origin(), ray.direction());
    let slab = |axis: usize| {
        let t = [low, high].map(|plane| (plane[axis] - o[axis]) / d[axis]);
        if d[axis] >= 0.0 { t } else { [t[1], t[0]] }
    };
    let [mut near, mut far] = slab(0);
    for axis in [1, 2] {
        let [first, last] = slab(axis);
        if near > last || first > far {
            return false;
        }
        if first > near {
            near = first;
        }
        if last < far {
            far = last;
        }
    }
    far >= 0.0 && near <= far
}

/// Returns whether the half-line meets the box with `more` metres added around, in f64.
fn truth(ray: &Ray, low: Vec3, high: Vec3, more: f64) -> bool {
    let (o, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let (low, high) = (low.as_dvec3() - more, high.as_dvec3() + more);
    let (mut near, mut far) = (0.0, f64::INFINITY);
    for axis in 0..3 {
        if d[axis] == 0.0 {
            if o[axis] < low[axis] || o[axis] > high[axis] {
                return false;
            }
            continue;
        }
        let t = [low[axis], high[axis]].map(|plane| (plane - o[axis]) / d[axis]);
        near = t[0].min(t[1]).max(near);
        far = t[0].max(t[1]).min(far);
    }
    near <= far
}

/// Eighths from −8 to 8.
fn on_grid(inputs: &mut Inputs) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| inputs.range(-64.0, 64.0).round() / 8.0))
}

/// Returns a box, and one of its points: inside, on a face, on an edge or a corner.
fn a_box(inputs: &mut Inputs) -> (Corners, DVec3) {
    let (a, b) = (on_grid(inputs), on_grid(inputs));
    let (low, high) = (a.min(b), a.max(b));
    let place = DVec3::from_array([0; 3].map(|_| [0.0, 0.25, 0.5, 1.0][inputs.below(4)]));
    ([low, high], low + (high - low) * place)
}

fn a_zero(inputs: &mut Inputs) -> f32 {
    if inputs.sign() < 0.0 { -0.0 } else { 0.0 }
}

/// Returns a ray through the point, with `zeros` components of the direction exactly 0.
fn through(inputs: &mut Inputs, point: DVec3, zeros: usize) -> Option<Ray> {
    let mut direction = single(on_grid(inputs));
    let first = inputs.below(3);
    for axis in 0..zeros {
        direction[(first + axis) % 3] = a_zero(inputs);
    }
    let back = inputs.below(4) as f32;
    Ray::new(single(point) - direction * back, direction)
}

/// The least and the greatest corner of a box.
type Corners = [DVec3; 2];

/// A ray and a box that it meets.
type Drawn = Option<(Ray, Corners)>;

/// Counts the boxes that the tests miss; `draw` is given a box and one of its points.
fn missed(
    seed: u64,
    effort: Effort,
    draw: fn(&mut Inputs, Corners, DVec3) -> Drawn,
) -> Option<Errors> {
    wrong(seed, effort.of(500_000), 0.5, |inputs, verdicts| {
        let (corners, point) = a_box(inputs);
        let (ray, corners) = draw(inputs, corners, point)?;
        let [low, high] = corners.map(single);
        verdicts.wrong(!ours(&ray, low, high), !smits(&ray, low, high));
        Some(())
    })
}

fn along_axes(inputs: &mut Inputs, [low, high]: Corners, _: DVec3) -> Drawn {
    // Inside: its faces are the next case.
    let point = (low + high) / 2.0;
    let zeros = 1 + inputs.below(2);
    let has_room = low.cmplt(high).all();
    let ray = has_room.then(|| through(inputs, point, zeros))?;
    Some((ray?, [low, high]))
}

fn from_planes(inputs: &mut Inputs, [low, high]: Corners, mut point: DVec3) -> Drawn {
    let axis = inputs.below(3);
    point[axis] = [high, low][usize::from(inputs.sign() < 0.0)][axis];
    let zeros = inputs.below(3);
    let mut direction = single(on_grid(inputs));
    for i in 0..zeros {
        direction[(axis + i) % 3] = a_zero(inputs);
    }
    let back = inputs.below(4) as f32;
    let ray = Ray::new(single(point) - direction * back, direction);
    let ray = ray.filter(|_| low.cmplt(high).all());
    Some((ray?, [low, high]))
}

fn flat(inputs: &mut Inputs, [low, mut high]: Corners, point: DVec3) -> Drawn {
    let first = inputs.below(3);
    for axis in 0..=inputs.below(3) {
        high[(first + axis) % 3] = low[(first + axis) % 3];
    }
    let zeros = inputs.below(3);
    let ray = through(inputs, point.min(high), zeros)?;
    Some((ray, [low, high]))
}

fn infinite(inputs: &mut Inputs, verdicts: &mut Errors) {
    let ([low, high], point) = a_box(inputs);
    let (mut low, mut high) = (single(low), single(high));
    let first = inputs.below(3);
    for axis in 0..=inputs.below(3) {
        low[(first + axis) % 3] = f32::NEG_INFINITY;
        high[(first + axis) % 3] = f32::INFINITY;
    }
    let zeros = inputs.below(3);
    if let Some(ray) = through(inputs, point, zeros) {
        verdicts.wrong(!ours(&ray, low, high), !smits(&ray, low, high));
        let (nothing, at_all) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        verdicts.wrong(ours(&ray, nothing, at_all), smits(&ray, nothing, at_all));
    }
}

fn subnormal(inputs: &mut Inputs, [low, high]: Corners, point: DVec3) -> Drawn {
    let main = inputs.below(3);
    // Within the box: on a face, the least step leads out.
    let point = point
        .max(low + (high - low) * 0.25)
        .min(low + (high - low) * 0.75);
    let mut direction = Vec3::ZERO;
    direction[main] = inputs.sign() as f32;
    for i in 1..3 {
        let size = inputs.magnitude(-45.0, -30.0) * inputs.sign();
        direction[(main + i) % 3] = size as f32;
    }
    let mut from = single(point);
    from[main] -= direction[main] * 4.0;
    let ray = Ray::new(from, direction).filter(|_| low.cmplt(high).all());
    Some((ray?, [low, high]))
}

fn corners_from_far(inputs: &mut Inputs, [low, high]: Corners, point: DVec3) -> Drawn {
    let from = single(inputs.direction() * inputs.magnitude(1.0, 6.0));
    let ray = Ray::new(from, single(point - from.as_dvec3()))?;
    let is_met = truth(&ray, single(low), single(high), 0.0);
    is_met.then_some((ray, [low, high]))
}

fn beside(inputs: &mut Inputs, worst: &mut Errors) -> Option<()> {
    let ([low, high], point) = a_box(inputs);
    let from = single(inputs.direction() * inputs.magnitude(1.0, 4.0));
    let farthest = f64::from(largest_magnitude(from)).max(8.0);
    let past = point + inputs.direction() * farthest * UNIT * inputs.magnitude(0.0, 3.0);
    let ray = Ray::new(from, single(past - from.as_dvec3()))?;
    let (low, high) = (single(low), single(high));
    // Finds by halving how much the box would have to grow to be met.
    let needed = || {
        let (mut least, mut most) = (0.0, 4096.0);
        for _ in 0..24 {
            let middle = f64::midpoint(least, most);
            if truth(&ray, low, high, middle * farthest * UNIT) {
                most = middle;
            } else {
                least = middle;
            }
        }
        most
    };
    if !truth(&ray, low, high, 0.0) {
        worst.verdicts += 1;
        if ours(&ray, low, high) {
            worst.ours(needed());
        }
        if smits(&ray, low, high) {
            worst.naive(needed());
        }
    }
    Some(())
}
