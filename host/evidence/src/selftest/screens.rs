//! Rays from an eye through the pixels of a wall.

use super::input::{Inputs, single};
use super::{Case, Effort, Errors, UNIT, largest, wrong};
use crate::textbook::angle;
use glam::{DVec3, Mat4, Vec3, Vec4};
use shisen_core::frame::{FlatScreen, View};

const F64: &str = "the pixel's place less the eye, in f64";
const MATRIX: &str = "an off-axis frustum (left, right, bottom, top at the near plane) and its \
                      inverse in f32";

/// The largest error of a ray by a wall's corners, in the units of its case.
const OF_A_WALL: f64 = 3.0;

pub(super) const CASES: &[Case] = cases! {
    ["of the ray, radians, 2⁻²⁴ of the wall's size over the pixel's distance", F64, MATRIX]:
    "screen-an-eye-next-to-it", OF_A_WALL, |effort| largest(800, effort.of(50_000), next_to_it),
        "an eye 1 to 100 µm before the plane of a wall";
    ["nearer eyes that have rays, and farther ones that have none",
     "the limit, as documented",
     MATRIX]:
    "screen-an-eye-in-it", 0.0, |effort| wrong(804, effort.of(10_000), 1.0, in_it),
        "an eye a millionth farther from the plane of a wall than 1 µm, or nearer by as much and \
         more, which is refused";
    ["of the ray, radians, 2⁻²⁴ of the wall's size over the pixel's distance", F64, MATRIX]:
    "screen-very-wide", OF_A_WALL, |effort| largest(801, effort.of(50_000), very_wide),
        "a wall a hundred to ten thousand times as wide as the eye is far";
    ["between both rays, 2⁻²⁴ rad", "a point has one direction", MATRIX]:
    "screen-seams", 8.0, |effort| seams(802, effort, square),
        "the same point of an edge where two walls meet, on both";
    ["between both rays, radians, 2⁻²⁴ of the farthest coordinate over the point's distance",
     "a point has one direction",
     MATRIX]:
    // The bounds of both walls' rays together.
    "screen-seams-of-any-room", 2.0 * OF_A_WALL, |effort| seams(805, effort, crooked),
        "the same where walls stand at 45° to 170°, lean, and are turned any way";
    ["of the ray, pixels", F64, "the first pixel's place and a step added for each column, in f32"]:
    "screen-of-many-pixels", 0.005, many_pixels,
        "walls of 16,384 columns: steps of a pixel added up";
};

/// A wall by three corners, as f32 has them: lower left, lower right, upper left.
#[derive(Clone, Copy)]
struct Wall([Vec3; 3], [u32; 2]);

impl Wall {
    fn view(&self, eye: Vec3) -> Option<View> {
        let Self([left, right, above], size) = *self;
        let screen = FlatScreen::from_corners(left, right, above, size);
        screen.view_from(eye).ok()
    }

    /// Returns the vector from the eye to a place of the wall; `x` and `y` are in pixels, (0, 0) is
    /// the middle of the first.
    fn exact(&self, eye: Vec3, x: f64, y: f64) -> DVec3 {
        let Self(corners, [columns, rows]) = self;
        let [ll, lr, ul] = corners.map(Vec3::as_dvec3);
        let u = (x + 0.5) / f64::from(*columns);
        let v = (y + 0.5) / f64::from(*rows);
        ul + (lr - ll) * u + (ll - ul) * v - eye.as_dvec3()
    }

    /// Returns the ray by the inverse of a projection (Kooima, "Generalized Perspective
    /// Projection", 2009), near 0.1 m and far 100 m.
    fn by_matrix(&self, eye: Vec3, x: f32, y: f32) -> Vec3 {
        let Self([lower_left, lower_right, upper_left], size) = *self;
        let right = (lower_right - lower_left).normalize();
        let up = (upper_left - lower_left).normalize();
        let normal = right.cross(up);
        let [va, vb, vc] = [lower_left, lower_right, upper_left].map(|c| c - eye);
        let distance = -va.dot(normal);
        let (near, far) = (0.1, 100.0);
        let scale = near / distance;
        let (l, r) = (right.dot(va) * scale, right.dot(vb) * scale);
        let (b, t) = (up.dot(va) * scale, up.dot(vc) * scale);
        let projection = Mat4::from_cols(
            Vec4::X * (2.0 * near / (r - l)),
            Vec4::Y * (2.0 * near / (t - b)),
            Vec4::new(
                (r + l) / (r - l),
                (t + b) / (t - b),
                -(far + near) / (far - near),
                -1.0,
            ),
            Vec4::Z * (-2.0 * far * near / (far - near)),
        );
        let room_from_wall = Mat4::from_cols(
            right.extend(0.0),
            up.extend(0.0),
            normal.extend(0.0),
            eye.extend(1.0),
        );
        let room_from_clip = room_from_wall * projection.inverse();
        let ndc = Vec3::new(
            (x + 0.5) / size[0] as f32 * 2.0 - 1.0,
            1.0 - (y + 0.5) / size[1] as f32 * 2.0,
            -1.0,
        );
        room_from_clip.project_point3(ndc) - eye
    }

    /// Returns the farthest coordinate of its corners and the eye, metres.
    fn reach(&self, eye: Vec3) -> f64 {
        let all = self.0.into_iter().chain([eye]);
        let farthest = all.map(shisen_core::numeric::largest_magnitude);
        f64::from(farthest.fold(0.0, f32::max))
    }

    fn length(&self) -> f64 {
        let [left, right, above] = self.0;
        f64::from((right - left).length().max((above - left).length()))
    }
}

/// Compares both rays of a pixel, in units of the rounding of the wall's own corners.
fn compare(worst: &mut Errors, wall: &Wall, eye: Vec3, x: u32, y: u32) {
    let Some(view) = wall.view(eye) else {
        return worst.ours(f64::NAN);
    };
    let exact = wall.exact(eye, x.into(), y.into());
    let unit = UNIT * wall.length() / exact.length();
    let error = |found: Vec3| angle(found.as_dvec3(), exact) / unit;
    let (x, y) = (x as f32, y as f32);
    worst.ours(view.direction(x, y).map_or(f64::NAN, error));
    worst.naive(error(wall.by_matrix(eye, x, y)));
}

/// Returns a wall of 3 m × 2 m or so, turned any way, its lower left corner at the
/// origin; and its normal.
fn drawn(inputs: &mut Inputs, width: f64, height: f64, size: [u32; 2]) -> (Wall, [DVec3; 3]) {
    let normal = inputs.direction();
    let right = inputs.across(normal);
    let up = normal.cross(right);
    let corners = [Vec3::ZERO, single(right * width), single(up * height)];
    (Wall(corners, size), [right, up, normal])
}

/// Returns a wall whose plane is that of two axes, so that it is known to a micrometre; its width
/// and height.
fn level(inputs: &mut Inputs) -> (Wall, f64, f64) {
    let (width, height) = (inputs.range(1.0, 4.0), inputs.range(1.0, 4.0));
    let corners = [Vec3::ZERO, Vec3::X * width as f32, Vec3::Y * height as f32];
    (Wall(corners, [1024; 2]), width, height)
}

fn next_to_it(inputs: &mut Inputs, worst: &mut Errors) {
    let (wall, width, height) = level(inputs);
    // One in a thousand next to the limit.
    let least = f64::from(just_over());
    let off = match inputs.below(1_000) {
        0 => least,
        _ => inputs.range(least, 1.0e-4),
    };
    let (across, up) = (width * inputs.unit(), height * inputs.unit());
    let eye = single(DVec3::new(across, up, off));
    let (x, y) = (inputs.below(1024) as u32, inputs.below(1024) as u32);
    compare(worst, &wall, eye, x, y);
}

/// Returns a distance just above the limit: the wall's normal is rounded.
fn just_over() -> f32 {
    FlatScreen::CLOSEST * (1.0 + 1.0e-6)
}

fn in_it(inputs: &mut Inputs, verdicts: &mut Errors) {
    let (wall, width, height) = level(inputs);
    let limit = FlatScreen::CLOSEST;
    let (off, has_rays) = [
        (just_over(), true),
        (limit * (1.0 - 1.0e-6), false),
        (limit * 0.999 * inputs.unit() as f32, false),
        (0.0, false),
    ][inputs.below(4)];
    let (across, up) = (width * inputs.unit(), height * inputs.unit());
    let eye = Vec3::new(across as f32, up as f32, off);
    verdicts.wrong(
        wall.view(eye).is_some() != has_rays,
        wall.by_matrix(eye, 511.0, 511.0).is_finite() != has_rays,
    );
}

fn very_wide(inputs: &mut Inputs, worst: &mut Errors) {
    let width = inputs.magnitude(2.0, 4.0);
    let (wall, [right, up, normal]) = drawn(inputs, width, 2.0, [4096, 64]);
    let eye = single(right * width * inputs.unit() + up * inputs.unit() + normal);
    let (x, y) = (inputs.below(4096) as u32, inputs.below(64) as u32);
    compare(worst, &wall, eye, x, y);
}

/// Two walls with a common edge, an eye, and the unit of errors, radians.
struct Seam {
    walls: [Wall; 2],
    eye: Vec3,
    unit: fn(&Wall, Vec3, DVec3) -> f64,
}

/// Front and right wall of a room of any size, anywhere.
fn square(inputs: &mut Inputs) -> Seam {
    let size = inputs.magnitude(0.0, 1.0);
    let middle = inputs.in_ball() * 2.0;
    let corner = |x: f64, y: f64, z: f64| single(middle + DVec3::new(x, y, z) * size);
    let size_px = [1 << (6 + inputs.below(6)); 2];
    let [left, far, right] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
    let wall = |(x, z), (to_x, to_z)| {
        let (left, right) = (corner(x, -1.0, z), corner(to_x, -1.0, to_z));
        Wall([left, right, corner(x, 1.0, z)], size_px)
    };
    Seam {
        walls: [wall(left, far), wall(far, right)],
        eye: single(middle + inputs.in_ball() * 0.6 * size),
        unit: |_, _, _| UNIT,
    }
}

/// Returns walls on both sides of an edge in any direction.
fn crooked(inputs: &mut Inputs) -> Seam {
    let size = inputs.magnitude(0.0, 1.0);
    let foot = inputs.in_ball() * 2.0;
    let up = inputs.direction();
    let away = inputs.across(up);
    let side = away.cross(up);
    // Half the angle between the walls, on the eye's side.
    let half = inputs.range(45.0, 170.0).to_radians() / 2.0;
    let mut wall = |to: f64| {
        let lean = up * inputs.range(-0.3, 0.3);
        (side * half.sin() * to - away * half.cos() + lean) * 2.0 * size
    };
    let [left, right] = [wall(-1.0), wall(1.0)];
    let top = foot + up * 2.0 * size;
    let size_px = [1 << (6 + inputs.below(6)); 2];
    let before = Wall([foot + left, foot, top + left].map(single), size_px);
    let after = Wall([foot, foot + right, top].map(single), size_px);
    let before_both = foot + up * size - away * inputs.range(0.5, 1.5) * size;
    Seam {
        walls: [before, after],
        eye: single(before_both + inputs.in_ball() * 0.2 * size),
        unit: |wall, eye, exact| UNIT * wall.reach(eye) / exact.length(),
    }
}

fn seams(seed: u64, effort: Effort, draw: fn(&mut Inputs) -> Seam) -> Option<Errors> {
    largest(seed, effort.of(50_000), |inputs, worst| {
        let seam = draw(inputs);
        let ([before, after], eye, unit) = (seam.walls, seam.eye, seam.unit);
        let row = inputs.below(before.1[1] as usize) as f32;
        // Half a pixel beyond the last, and before the first.
        let (last, first) = (before.1[0] as f32 - 0.5, -0.5);
        let unit = unit(&before, eye, before.exact(eye, last.into(), row.into()));
        let between = |a: Vec3, b: Vec3| angle(a.as_dvec3(), b.as_dvec3()) / unit;
        let rays =
            [(before, last), (after, first)].map(|(wall, x)| wall.view(eye)?.direction(x, row));
        let [Some(a), Some(b)] = rays else {
            return worst.ours(f64::NAN);
        };
        worst.ours(between(a, b));
        worst.naive(between(
            before.by_matrix(eye, last, row),
            after.by_matrix(eye, first, row),
        ));
    })
}

fn many_pixels(effort: Effort) -> Option<Errors> {
    const COLUMNS: u32 = 16_384;
    largest(803, effort.of(500), |inputs, worst| {
        let (wall, [right, up, normal]) = drawn(inputs, 3.0, 3.0, [COLUMNS, 4]);
        let eye = single((right + up) * inputs.range(0.5, 2.5) + normal * inputs.range(0.5, 2.0));
        let Some(view) = wall.view(eye) else {
            return worst.ours(f64::NAN);
        };
        let step = (wall.0[1] - wall.0[0]) / COLUMNS as f32;
        let mut place = wall.exact(eye, 0.0, 1.0).as_vec3();
        for x in 0..COLUMNS {
            let exact = wall.exact(eye, x.into(), 1.0);
            // A pixel's angle from here, where it is looked at squarely.
            let pixel = 3.0 / f64::from(COLUMNS) / exact.length();
            let error = |found: Vec3| angle(found.as_dvec3(), exact) / pixel;
            worst.ours(view.direction(x as f32, 1.0).map_or(f64::NAN, error));
            worst.naive(error(place));
            place += step;
        }
    })
}
