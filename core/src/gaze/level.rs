use super::{Boundary, LineOfSight, VisualField, VisualFieldLimits};
use crate::numeric::{arctangent, max, min, scale_to_one, sqrt, tangent};
use crate::simd::{Lanes, Portable, dot};
use core::f32::consts::{FRAC_1_SQRT_2, PI};
use glam::Vec3;

/// Gives rays their level of detail by where a viewer looks: equations 1 to 8, with arc
/// tangents, which keep their digits near the line of sight, for the printed arc cosines. The
/// elevation is folded as in equation 5: behind the viewer, around ±`right`, a small part of the
/// sphere is traced, at levels of 1/7 and below.
///
/// A ray is traced if and only if its level is above 0, that is if l < L. From exact components,
/// the errors of l (radians) and of the level are at most 1e-6. Straight sideways of a turned
/// viewer equation 5 is 0/0, the level has a step of up to 1/7, and its error is at most 1e-7
/// divided by the distance from there in radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaze {
    sight: LineOfSight,
    field: VisualField,
    scales: Scales,
    bands: Bands,
}

/// The limits' squares for the printed curve, reciprocals of them for the ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scales {
    up: f32,
    down: f32,
    left: f32,
    right: f32,
}

/// Bounds of squared components, [`Bands::SLACK`] inside their zones, that need no angles.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bands {
    /// In front, `r² + u² ≤ central·f²` is central.
    central: f32,
    /// `u² ≥ above·f²` is outside, up.
    above: f32,
    /// `u² ≥ below·f²` is outside, down.
    below: f32,
    /// Behind, `r² ≤ behind·f²` is outside.
    behind: f32,
}

impl Bands {
    /// Distance of the bounds from the zones' borders: radians.
    const SLACK: f32 = 1.0e-4;

    /// Added to the lesser side of a comparison: smaller squares may have underflowed.
    const LEAST_SQUARE: f32 = 1.0e-36;

    fn new(limits: VisualFieldLimits) -> Self {
        let tangent_squared = |angle: f32| {
            let tangent = tangent(angle);
            tangent * tangent
        };
        let side = max(limits.left, limits.right);
        let steepest = 1.57;
        // The printed curve is highest beside the axis where the sides reach
        // far: solve l⁴ = A²·m_α² + B²·m_β² for the greatest m_β.
        let highest = |height: f32| {
            let (a, b) = (side * side, height * height);
            let highest = if a > 2.0 * b {
                a / (2.0 * sqrt(a - b))
            } else {
                height
            };
            let highest = highest + Self::SLACK;
            if highest < steepest {
                tangent_squared(highest)
            } else {
                f32::INFINITY
            }
        };
        // Where hypot(r, u)/f is t, l lies between atan t, on the axes, and
        // √2·atan(t/√2), midway between them.
        let central = max(limits.central - Self::SLACK, 0.0) * FRAC_1_SQRT_2;
        // No direction in the boundary has a larger m_α than its largest limit.
        let widest = min(max(side, max(limits.up, limits.down)) + Self::SLACK, PI);
        Self {
            central: 2.0 * tangent_squared(central),
            above: highest(limits.up),
            below: highest(limits.down),
            behind: tangent_squared(min(PI - widest, steepest)),
        }
    }
}

/// Where a ray lies in the visual field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zone {
    /// l ≤ the central field's radius: level 1.
    Central,
    /// Between the central field and the boundary: l < L.
    Peripheral,
    /// On the boundary or beyond: level 0, not traced.
    Outside,
}

/// Where all directions of a patch lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Region {
    /// All are in the central field.
    Central,
    /// All are in front, in this rectangle, which is within the boundary.
    Traced(Rectangle),
    /// All are on the boundary or beyond.
    Outside,
    /// Each direction has to be tested.
    Mixed,
}

/// The position of a ray relative to the line of sight. Angles are radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// `m_α`: from straight ahead to either side, 0 to π (equation 4); 0 for
    /// rays along ±`up`.
    pub m_alpha: f32,
    /// `m_β`: elevation, folded: −π/2 to π/2 (equation 5); 0 for rays along
    /// ±`right`.
    pub m_beta: f32,
    /// l: the distance from the line of sight in the plane of the two
    /// (equation 6).
    pub l: f32,
    /// L: the boundary's distance in the same direction (equation 7); where
    /// there is no direction, l being 0, the right-hand limit.
    pub big_l: f32,
    /// 0 to 1 (equation 8).
    pub level: f32,
    /// Which case of equation 8 it is.
    pub zone: Zone,
}

impl Gaze {
    /// 2⁻¹⁰⁰: from here to [`Self::MOST_SQUARE`] no square overflows or underflows.
    const LEAST_SQUARE: f32 = 7.888_609e-31;

    /// 2¹⁰⁰.
    const MOST_SQUARE: f32 = 1.267_650_6e30;

    /// Returns the gaze of a viewer with this line of sight and visual field.
    pub fn new(sight: LineOfSight, field: VisualField) -> Self {
        let limits = field.limits();
        let scale = |limit: f32| match field.boundary() {
            Boundary::Printed => limit * limit,
            Boundary::Ellipse => 1.0 / (limit * limit),
        };
        Self {
            sight,
            field,
            scales: Scales {
                up: scale(limits.up),
                down: scale(limits.down),
                left: scale(limits.left),
                right: scale(limits.right),
            },
            bands: Bands::new(limits),
        }
    }

    /// Returns where the viewer looks.
    pub const fn line_of_sight(&self) -> LineOfSight {
        self.sight
    }

    /// Returns what the viewer sees.
    pub const fn visual_field(&self) -> VisualField {
        self.field
    }

    /// Returns the level of a ray, 0 to 1, by its direction in the room, of any length;
    /// `None` where that is zero or not finite.
    #[inline]
    pub fn level(&self, direction: Vec3) -> Option<f32> {
        let components = self.components(direction)?;
        let [level] = self.level_of_components(Portable, components);
        Some(level)
    }

    /// Returns the angles that lead to the level of a ray, by its direction in the room, of
    /// any length; `None` where that is zero or not finite.
    pub fn sight(&self, direction: Vec3) -> Option<Sight> {
        let components = self.components(direction)?;
        let [_, right, up] = components;
        let (alpha, beta) = angles(Portable, components);
        // The squares of angles next to nothing would underflow.
        let scale = if alpha[0] + beta[0] < 1.0e-15 {
            1.267_650_6e30
        } else {
            1.0
        };
        let scaled = [alpha, beta].map(|[angle]| [angle * scale]);
        let ([l], [big_l]) = self.radii(Portable, scaled, [right, up]);
        let l = l / scale;
        let limits = self.field.limits();
        let [level] = self.level_of_components(Portable, components);
        Some(Sight {
            m_alpha: alpha[0],
            m_beta: if up[0] < 0.0 { -beta[0] } else { beta[0] },
            l,
            big_l: if l == 0.0 { limits.right } else { big_l },
            level,
            zone: if l <= limits.central {
                Zone::Central
            } else if l < big_l {
                Zone::Peripheral
            } else {
                Zone::Outside
            },
        })
    }

    /// Returns the region of all directions between four: regions are convex cones.
    pub(crate) fn region_between(&self, corners: &[Vec3; 4]) -> Region {
        const ALL: u32 = 0b1111;
        let l = Portable;
        let axis = |axis: usize| corners.map(|corner| corner.to_array()[axis % 3]);
        let ([f, r, u], square) = self.rotate(l, [axis(0), axis(1), axis(2)]);
        let least = l.le([Self::LEAST_SQUARE; 4], square);
        if least & l.le(square, [Self::MOST_SQUARE; 4]) != ALL {
            return Region::Mixed;
        }
        let (ff, rr, uu) = (l.mul(f, f), l.mul(r, r), l.mul(u, u));
        let bound = |slope: f32| l.mul([slope; 4], ff);
        let above = |square| l.add(square, [Bands::LEAST_SQUARE; 4]);
        // Numbers, as their squares are.
        let is_above_zero = |x| l.le(x, [0.0; 4]) == 0;
        let is_below_zero = |x| l.le([0.0; 4], x) == 0;
        let in_front = is_above_zero(f);
        if in_front && l.le(l.add(rr, uu), bound(self.bands.central)) == ALL {
            return Region::Central;
        }
        let is_steep = |slope| l.le(above(bound(slope)), uu) == ALL;
        if is_above_zero(u) && is_steep(self.bands.above)
            || is_below_zero(u) && is_steep(self.bands.below)
            || is_below_zero(f) && l.le(above(rr), bound(self.bands.behind)) == ALL
        {
            return Region::Outside;
        }
        if !in_front {
            return Region::Mixed;
        }
        let (right, up) = (l.div(r, f), l.div(u, f));
        let range = |x: [f32; 4]| {
            let [first, rest @ ..] = x;
            (
                rest.into_iter().fold(first, min),
                rest.into_iter().fold(first, max),
            )
        };
        let ((left, right), (below, above)) = (range(right), range(up));
        let slopes = [left, right, below, above];
        let angles = arctangent(l, slopes.map(f32::abs), [1.0; 4]);
        let signed = |at: usize| angles[at].copysign(slopes[at]);
        let field = Rectangle {
            left: signed(0) - Bands::SLACK,
            right: signed(1) + Bands::SLACK,
            below: signed(2) - Bands::SLACK,
            above: signed(3) + Bands::SLACK,
        };
        if self.holds(&field) {
            Region::Traced(field)
        } else {
            Region::Mixed
        }
    }

    /// Returns whether l < L in all of a rectangle: by eq. 7 the corners decide.
    fn holds(&self, field: &Rectangle) -> bool {
        let limits = self.field.limits();
        let square = |(angle, limit): (f32, f32)| {
            // Not 0, where l and its bound would be equal.
            let angle = max(angle, Bands::SLACK);
            (angle * angle, limit * limit)
        };
        let sides = [(-field.left, limits.left), (field.right, limits.right)].map(square);
        let heights = [(-field.below, limits.down), (field.above, limits.up)].map(square);
        sides.into_iter().all(|(a, side)| {
            heights.into_iter().all(|(b, height)| {
                let corner = match self.field.boundary() {
                    Boundary::Printed => (a + b) * (a + b) < side * a + height * b,
                    Boundary::Ellipse => a / side + b / height < 1.0,
                };
                a < side && b < height && corner
            })
        })
    }

    /// Bounds of the levels in a rectangle, from its corners: levels fall with l and grow with L.
    pub(crate) fn levels_within(&self, field: &Rectangle) -> (f32, f32) {
        let limits = self.field.limits();
        let (least_alpha, most_alpha) = magnitudes(field.left, field.right);
        let (least_beta, most_beta) = magnitudes(field.below, field.above);
        let sides = touched((field.left, limits.left), (field.right, limits.right));
        let heights = touched((field.below, limits.down), (field.above, limits.up));
        let boundary = |alpha: f32, beta: f32, side: f32, height: f32| {
            let (a, b) = (alpha * alpha, beta * beta);
            let (side, height) = (side * side, height * height);
            sqrt(match self.field.boundary() {
                Boundary::Printed => (a * side + b * height) / (a + b),
                Boundary::Ellipse => (a + b) / (a / side + b / height),
            })
        };
        let farthest = max(
            boundary(most_alpha, least_beta, sides.1, heights.1),
            boundary(least_alpha, most_beta, sides.1, heights.1),
        );
        let nearest = min(
            boundary(most_alpha, least_beta, sides.0, heights.0),
            boundary(least_alpha, most_beta, sides.0, heights.0),
        );
        let level = |l: f32, boundary: f32| (boundary - l) / (boundary - limits.central);
        let length = |alpha: f32, beta: f32| sqrt(alpha * alpha + beta * beta);
        (
            min(level(length(most_alpha, most_beta), nearest), 1.0),
            level(length(least_alpha, least_beta), farthest),
        )
    }

    /// [`level`](Self::level) in every lane; 0 where it gives none.
    #[inline(always)]
    pub(crate) fn levels<L: Lanes<8>>(&self, l: L, direction: [L::F; 3]) -> L::F {
        let (components, square) = self.rotate(l, direction);
        let least = l.le(l.splat(Self::LEAST_SQUARE), square);
        let most = l.le(square, l.splat(Self::MOST_SQUARE));
        if l.bits(l.and(least, most)) == 0xff {
            self.level_of_components(l, components)
        } else {
            let [x, y, z] = direction;
            l.load(&self.levels_one_by_one(l.store(x), l.store(y), l.store(z)))
        }
    }

    #[cold]
    #[inline(never)]
    fn levels_one_by_one(&self, x: [f32; 8], y: [f32; 8], z: [f32; 8]) -> [f32; 8] {
        let mut levels = [0.0; 8];
        for (((level, x), y), z) in levels.iter_mut().zip(x).zip(y).zip(z) {
            *level = self.level(Vec3::new(x, y, z)).unwrap_or(0.0);
        }
        levels
    }

    /// Returns the direction along the axes of sight, scaled where it must be.
    #[inline]
    fn components(&self, direction: Vec3) -> Option<[[f32; 1]; 3]> {
        let (components, [square]) = self.rotate(Portable, direction.to_array().map(|x| [x]));
        // One comparison for two: bits of floats not below zero are in their
        // order, NaN last.
        let (least, most) = (Self::LEAST_SQUARE.to_bits(), Self::MOST_SQUARE.to_bits());
        if square.to_bits().wrapping_sub(least) <= most - least {
            Some(components)
        } else {
            self.scaled_components(direction.x, direction.y, direction.z)
        }
    }

    #[cold]
    #[inline(never)]
    fn scaled_components(&self, x: f32, y: f32, z: f32) -> Option<[[f32; 1]; 3]> {
        let direction = scale_to_one(Vec3::new(x, y, z))?;
        Some(self.rotate(Portable, direction.to_array().map(|x| [x])).0)
    }

    /// Equations 1 to 3, and the length's square.
    #[inline(always)]
    fn rotate<const W: usize, L: Lanes<W>>(&self, l: L, d: [L::F; 3]) -> ([L::F; 3], L::F) {
        let f = dot(l, self.sight.forward(), d);
        let r = dot(l, self.sight.right(), d);
        let u = dot(l, self.sight.up(), d);
        let aside = l.add(l.mul(r, r), l.mul(u, u));
        ([f, r, u], l.add(l.mul(f, f), aside))
    }

    /// Equations 4 to 8, without angles where no lane needs them.
    #[inline(always)]
    fn level_of_components<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        components: [L::F; 3],
    ) -> L::F {
        let [f, r, u] = components;
        let (ff, rr, uu) = (l.mul(f, f), l.mul(r, r), l.mul(u, u));
        let all = (1 << W) - 1;
        let zero = l.splat(0.0);
        let bound = |slope: f32| l.mul(l.splat(slope), ff);
        let above = |square| l.add(square, l.splat(Bands::LEAST_SQUARE));
        let front = l.bits(l.le(zero, f));
        if front == all {
            if l.bits(l.le(l.add(rr, uu), bound(self.bands.central))) == all {
                return l.splat(1.0);
            }
        } else if front == 0 && l.bits(l.le(above(rr), bound(self.bands.behind))) == all {
            return zero;
        }
        if l.bits(l.le(above(bound(max(self.bands.above, self.bands.below))), uu)) == all {
            return zero;
        }
        self.level_by_angles(l, components)
    }

    /// Equations 4 to 8.
    #[inline(always)]
    fn level_by_angles<const W: usize, L: Lanes<W>>(&self, l: L, components: [L::F; 3]) -> L::F {
        let [_, right, up] = components;
        let (alpha, beta) = angles(l, components);
        let (radius, boundary) = self.radii(l, [alpha, beta], [right, up]);
        let central = l.splat(self.field.limits().central);
        // Above 0 wherever the difference is, and at most 1: rounding keeps
        // the order. Where l is 0 and L is none, the ray is central.
        let level = l.div(l.sub(boundary, radius), l.sub(boundary, central));
        let level = l.select(l.le(boundary, radius), l.splat(0.0), level);
        l.select(l.le(radius, central), l.splat(1.0), level)
    }

    /// Equations 6 and 7: l and L, which is NaN where l is 0.
    #[inline(always)]
    fn radii<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        [alpha, beta]: [L::F; 2],
        [right, up]: [L::F; 2],
    ) -> (L::F, L::F) {
        let (to, zero) = (self.scales, l.splat(0.0));
        let across = l.select(l.le(zero, right), l.splat(to.right), l.splat(to.left));
        let along = l.select(l.le(zero, up), l.splat(to.up), l.splat(to.down));
        let (alpha, beta) = (l.mul(alpha, alpha), l.mul(beta, beta));
        let square = l.add(alpha, beta);
        let weighted = l.add(l.mul(alpha, across), l.mul(beta, along));
        let ratio = match self.field.boundary() {
            Boundary::Printed => l.div(weighted, square),
            Boundary::Ellipse => l.div(square, weighted),
        };
        (l.sqrt(square), l.sqrt(ratio))
    }
}

/// Directions in front with angles in between: radians, negative to the left and below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rectangle {
    left: f32,
    right: f32,
    below: f32,
    above: f32,
}

/// Returns the least and the greatest magnitude from `low` to `high`.
fn magnitudes(low: f32, high: f32) -> (f32, f32) {
    (max(max(low, -high), 0.0), max(-low, high))
}

/// Returns the least and the greatest limit of the sides that an interval reaches.
fn touched((low, below): (f32, f32), (high, above): (f32, f32)) -> (f32, f32) {
    if low >= 0.0 {
        (above, above)
    } else if high <= 0.0 {
        (below, below)
    } else {
        (min(below, above), max(below, above))
    }
}

/// Equations 4 and 5: `m_α`, and `m_β` without its sign.
#[inline(always)]
fn angles<const W: usize, L: Lanes<W>>(l: L, [f, r, u]: [L::F; 3]) -> (L::F, L::F) {
    let ahead = l.abs(f);
    let alpha = arctangent(l, l.abs(r), ahead);
    let beta = arctangent(l, l.abs(u), ahead);
    let behind = l.sub(l.splat(PI), alpha);
    (l.select(l.le(l.splat(0.0), f), alpha, behind), beta)
}

#[cfg(test)]
mod tests;
