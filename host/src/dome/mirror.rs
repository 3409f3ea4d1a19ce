use super::search::bisect;
use glam::{DVec2, DVec3};
use shisen_core::capture::{self, SpheroidMirror};
use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Where a mirror is seen from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// From infinity: section 4 of the paper.
    Parallel,
    /// From a viewpoint: section 3.
    Perspective,
}

named!(Projection { Parallel => "parallel", Perspective => "perspective" });

/// A mirrored spheroid and its camera, by the axis ratio a and g = a·tan β₁: 0 for a viewpoint at
/// the pole, 1 for one at infinity. Next to infinity g rounds to 1, so 1/d₁ is kept too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    pub(super) a: f64,
    pub(super) g: f64,
    k: f64,
}

/// Lengths and angles that follow from a mirror's axis ratio and g.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// 1/d₁; 0 in parallel projection.
    pub k: f64,
    /// The screen's distance from the mirror's centre: equation 19.
    pub c1: f64,
    /// Half the screen's width: equations 20 and 40.
    pub b1: f64,
    /// The parametric angle of the edge: equation 39.
    pub beta1: f64,
}

/// Why there is no such mirror, and what to give instead.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct MirrorError(String);

impl Mirror {
    /// Least and greatest axis ratio: those of the core's mirrors.
    pub const AXIS_RATIOS: RangeInclusive<f64> = 0.01..=100.0;

    /// The least β₁ that [`from_edge`](Self::from_edge) takes, radians.
    pub const LEAST_EDGE: f64 = 1.0e-3;

    /// Parallel projection: equations 38 to 40.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS).
    pub fn parallel(a: f64) -> Result<Self, MirrorError> {
        if !Self::AXIS_RATIOS.contains(&a) {
            return Err(MirrorError(format!(
                "the mirror's axis ratio is {a}: give a number from {} to {}",
                Self::AXIS_RATIOS.start(),
                Self::AXIS_RATIOS.end()
            )));
        }
        Ok(Self::of(a, 1.0))
    }

    /// By the parametric angle β₁ of the edge, radians: equations 19 to 24. Parallel projection if
    /// a·tan β₁ is 1 within rounding.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), an edge
    /// outside [`LEAST_EDGE`](Self::LEAST_EDGE) to tan⁻¹(1/a).
    pub fn from_edge(a: f64, beta1: f64) -> Result<Self, MirrorError> {
        let parallel = Self::parallel(a)?;
        let most = libm::atan2(1.0, a);
        if !(Self::LEAST_EDGE..=most).contains(&beta1) {
            return Err(MirrorError(format!(
                "the edge is at a parametric angle of {beta1} rad: give a number from {} to \
                 {most}, which is parallel projection",
                Self::LEAST_EDGE
            )));
        }
        let g = a * libm::tan(beta1);
        // The rounding of g by that of β₁ and of its tangent.
        let unsure = f64::EPSILON * (beta1 * (a + 1.0 / a) + 2.0);
        if g >= 1.0 - unsure {
            return Ok(parallel);
        }
        Ok(Self::of(a, g))
    }

    /// By an axis ratio above 0 and a·tan β₁, above 0 to 1: equation 22.
    pub(super) fn of(a: f64, g: f64) -> Self {
        let k = (1.0 - g) * (1.0 + g) * libm::hypot(a, g) / (2.0 * g * g);
        Self { a, g, k }
    }

    /// Perspective from a viewpoint `p` radii from the centre: equation 24, solved for β₁.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), a viewpoint
    /// that is not finite and above the pole.
    pub fn perspective(a: f64, p: f64) -> Result<Self, MirrorError> {
        let Self { mut g, .. } = Self::parallel(a)?;
        if !(p > a && p.is_finite()) {
            return Err(MirrorError(format!(
                "the viewpoint is {p} radii from the mirror's centre: give a finite number above \
                 {a}, where its pole is, or parallel projection"
            )));
        }
        let mut k = 0.0;
        // Each step at least halves the error.
        for _ in 0..100 {
            let h = libm::hypot(a, g);
            k = 1.0 / ((p - a) + a * g * g / (h * (h + a)));
            g = 1.0 / (1.0 + 2.0 * k / h).sqrt();
        }
        Ok(Self { a, g, k })
    }

    /// Returns the same in the core's precision.
    ///
    /// # Errors
    /// A viewpoint that is at the pole in single precision.
    pub fn single(&self) -> Result<SpheroidMirror, capture::MirrorError> {
        let Parameters { k, c1, .. } = self.parameters();
        let p = (c1 + 1.0 / k) as f32;
        let a = self.a as f32;
        if p.is_finite() {
            SpheroidMirror::perspective(a, p)
        } else {
            SpheroidMirror::parallel(a)
        }
    }

    /// Returns its lengths and angles.
    pub fn parameters(&self) -> Parameters {
        let Self { a, g, k } = *self;
        let h = libm::hypot(a, g);
        Parameters {
            k,
            c1: a * a / h,
            b1: g / h,
            beta1: libm::atan2(g, a),
        }
    }

    /// θ and `r_d` at the parametric angle β: equations 37 and 32, 43 and 45.
    pub fn at(&self, beta: f64) -> (f64, f64) {
        let Parameters { k, b1, beta1, .. } = self.parameters();
        let (sin, cos) = libm::sincos(beta);
        // cos β − cos β₁, written out.
        let drop = 2.0 * libm::sin(beta1.midpoint(beta)) * libm::sin((beta1 - beta) / 2.0);
        let w = 1.0 - k * self.a * drop;
        let theta = libm::atan2(k * sin, w) + 2.0 * libm::atan2(self.a * sin, cos);
        (theta, FRAC_PI_2 * sin / (b1 * w))
    }

    /// β where `value` of [`at`](Self::at) is `wanted`, by halving. 0 is exact.
    fn solve(&self, wanted: f64, value: impl Fn((f64, f64)) -> f64) -> f64 {
        if wanted <= 0.0 {
            return 0.0;
        }
        let is_below = |beta| value(self.at(beta)) < wanted;
        bisect(0.0, self.parameters().beta1, is_below)
    }

    /// θ of what is seen at `r_d`, 0 to π/2.
    pub fn theta(&self, r_d: f64) -> f64 {
        self.at(self.solve(r_d, |(_, r_d)| r_d)).0
    }

    /// Returns where what is at the angle `theta` to the zenith, 0 to π/2, is seen.
    pub fn r_d(&self, theta: f64) -> f64 {
        self.at(self.solve(theta, |(theta, _)| theta)).1
    }

    /// Returns the point where the line of sight through `screen`, at most b₁ from the screen's
    /// centre, meets the mirror, and its unit direction from there, in the axes of
    /// [`shisen_core::capture`].
    pub fn reflect(&self, screen: DVec2) -> (DVec3, DVec3) {
        let Parameters { k, c1, .. } = self.parameters();
        let squeeze = DVec3::new(1.0, 1.0, 1.0 / self.a);
        let origin = screen.extend(-c1);
        let sight = (screen * k).extend(1.0);
        let (o, d) = (origin * squeeze, sight * squeeze);
        let (half, length) = (o.dot(d), d.dot(d));
        let root = (half * half - length * (o.dot(o) - 1.0)).max(0.0).sqrt();
        let point = origin - sight * ((half + root) / length);
        let normal = (point * squeeze * squeeze).normalize();
        let sight = sight.normalize();
        (point, sight - 2.0 * sight.dot(normal) * normal)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Named;
    use super::*;

    /// Returns the three mirrors of Table 1 with the best viewpoints there are.
    fn mirrors() -> [Mirror; 3] {
        [Named::Paper1, Named::Paper2, Named::Paper3].map(Named::mirror)
    }

    #[test]
    fn the_mapping_has_the_digits_of_its_table() {
        // Degrees: where, then θ and r_d of each mirror.
        let table = "\
            10 10.0546147 9.94565578 10.4802735 9.53985706 10.0478572 9.95235156
            30 30.1094626 29.8905251 30.9428089 29.0563541 30.0978608 29.9021466
            50 50.0413445 49.9583935 50.3599418 49.6203930 50.0418729 49.9578999
            70 69.9062785 70.0941825 69.2418652 70.7908020 69.9217200 70.0786438
            90 90 90 90 90 90 90";
        for row in table.lines() {
            let numbers: Vec<f64> = row.split_whitespace().map(|n| n.parse().unwrap()).collect();
            let at = numbers[0].to_radians();
            let found = mirrors().map(|mirror| [mirror.theta(at), mirror.r_d(at)]);
            for (found, &exact) in found.as_flattened().iter().zip(&numbers[1..]) {
                // Nine digits, cut off and not rounded.
                let unit = if exact < 10.0 { 1.0e-8 } else { 1.0e-7 };
                let off = (found.to_degrees() - exact).abs();
                assert!(off <= unit, "{at}: {found} {exact}");
            }
        }
    }

    #[test]
    fn mirrors_that_are_none_are_refused() {
        let refused = |made: Result<Mirror, MirrorError>, words: &str| {
            let says = made.unwrap_err().to_string();
            assert!(says.contains(words), "{says}");
        };
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            refused(Mirror::parallel(bad), "give a number from 0.01 to 100");
        }
        for bad in [f64::NAN, f64::INFINITY, 1.0] {
            refused(Mirror::perspective(1.0, bad), &format!("is {bad} radii"));
        }
        for bad in [f64::NAN, 9.0e-4, FRAC_PI_2 / 2.0 + 1.0e-15] {
            refused(Mirror::from_edge(1.0, bad), "0.001 to 0.785398163");
        }
    }
}
