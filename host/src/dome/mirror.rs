use glam::{DVec2, DVec3};
use shisen_core::capture::{self, SpheroidMirror};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use thiserror::Error;

/// How a mirror is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// From infinity: section 4 of the paper.
    Parallel,
    /// From a viewpoint: section 3.
    Perspective,
}

/// A mirrored spheroid and what looks at it, by its axis ratio and by
/// g = a·tan β₁, which goes from 0 for a viewpoint at the pole to 1 for one at
/// infinity. Next to infinity g is 1 in f64 too, so 1/d₁ is kept beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    a: f64,
    g: f64,
    k: f64,
}

/// What follows from a mirror's axis ratio and g.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// 1/d₁; 0 in parallel projection.
    pub k: f64,
    /// Equation 19.
    pub c1: f64,
    /// Equations 20 and 40.
    pub b1: f64,
    /// The parametric angle of the edge: equation 39.
    pub beta1: f64,
}

/// Why there is no such mirror.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum MirrorError {
    /// The axis ratio is NaN or outside [`Mirror::AXIS_RATIOS`].
    #[error(
        "the mirror's axis ratio is {a}: give a number from {} to {}",
        Mirror::AXIS_RATIOS.0,
        Mirror::AXIS_RATIOS.1
    )]
    AxisRatio {
        /// The axis ratio.
        a: f64,
    },
    /// The viewpoint is NaN, infinite, in the mirror or on its pole.
    #[error(
        "the viewpoint is {p} radii from the mirror's centre: give a finite number above {a}, \
         where its pole is, or parallel projection"
    )]
    Viewpoint {
        /// Its distance from the mirror's centre, equatorial radii.
        p: f64,
        /// The mirror's axis ratio: the pole's distance.
        a: f64,
    },
    /// a·tan β₁ is NaN or out of range.
    #[error(
        "the mirror's slope at the edge is {g}: give a number from {} to 1, which is parallel \
         projection",
        Mirror::LEAST_SLOPE
    )]
    Slope {
        /// The slope.
        g: f64,
    },
    /// The edge is NaN, next to the pole or where not even parallel lines of
    /// sight leave at a right angle: a·tan β₁ > 1.
    #[error(
        "the edge is at a parametric angle of {beta1} rad: give a number from {} to {most}, which \
         is parallel projection",
        Mirror::LEAST_EDGE
    )]
    Edge {
        /// Its parametric angle, radians.
        beta1: f64,
        /// The most it can be, radians: tan⁻¹(1/a).
        most: f64,
    },
}

impl Mirror {
    /// Least and greatest axis ratio: those of the core's mirrors.
    pub const AXIS_RATIOS: (f64, f64) = (0.01, 100.0);

    /// The least β₁ that [`from_edge`](Self::from_edge) takes, radians.
    pub const LEAST_EDGE: f64 = 1.0e-3;

    /// The least a·tan β₁ that [`from_slope`](Self::from_slope) takes: towards 0,
    /// where the viewpoint is the pole, 1/d₁ has no end.
    pub const LEAST_SLOPE: f64 = 1.0e-6;

    /// Parallel projection: equations 38 to 40.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS).
    pub fn parallel(a: f64) -> Result<Self, MirrorError> {
        Self::from_slope(a, 1.0)
    }

    /// By a·tan β₁, [`LEAST_SLOPE`](Self::LEAST_SLOPE) to 1: equation 22's range
    /// and equation 38.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), a slope out of
    /// range.
    pub fn from_slope(a: f64, g: f64) -> Result<Self, MirrorError> {
        let (least, most) = Self::AXIS_RATIOS;
        if !(least..=most).contains(&a) {
            return Err(MirrorError::AxisRatio { a });
        }
        if !(Self::LEAST_SLOPE..=1.0).contains(&g) {
            return Err(MirrorError::Slope { g });
        }
        Ok(Self::of(a, g))
    }

    /// By β₁, radians: equations 19 to 24. Parallel projection where a·tan β₁
    /// is 1 but for the rounding of `beta1`.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), an edge
    /// outside [`LEAST_EDGE`](Self::LEAST_EDGE) to tan⁻¹(1/a).
    pub fn from_edge(a: f64, beta1: f64) -> Result<Self, MirrorError> {
        let parallel = Self::parallel(a)?;
        let most = libm::atan2(1.0, a);
        if !(Self::LEAST_EDGE..=most).contains(&beta1) {
            return Err(MirrorError::Edge { beta1, most });
        }
        let g = a * libm::tan(beta1);
        // How far an error of one unit of β₁ and of its tangent moves it.
        let unsure = f64::EPSILON * (beta1 * (a + 1.0 / a) + 2.0);
        if g >= 1.0 - unsure {
            return Ok(parallel);
        }
        Ok(Self::of(a, g))
    }

    /// An axis ratio above 0 and a slope above 0 to 1.
    pub(super) fn of(a: f64, g: f64) -> Self {
        let k = (1.0 - g) * (1.0 + g) * libm::hypot(a, g) / (2.0 * g * g);
        Self { a, g, k }
    }

    /// Perspective from `p` off the centre: equation 24, solved for β₁.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), a viewpoint
    /// that is not finite and above the pole.
    pub fn perspective(a: f64, p: f64) -> Result<Self, MirrorError> {
        let Self { mut g, .. } = Self::parallel(a)?;
        if !(p > a && p.is_finite()) {
            return Err(MirrorError::Viewpoint { p, a });
        }
        let mut k = 0.0;
        // Halves the error at least with each step.
        for _ in 0..100 {
            let h = libm::hypot(a, g);
            k = 1.0 / ((p - a) + a * g * g / (h * (h + a)));
            g = 1.0 / (1.0 + 2.0 * k / h).sqrt();
        }
        Ok(Self { a, g, k })
    }

    /// The same in the core's precision.
    ///
    /// # Errors
    /// A viewpoint that single precision cannot tell from the pole.
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

    /// a.
    pub const fn axis_ratio(&self) -> f64 {
        self.a
    }

    /// a·tan β₁.
    pub const fn slope(&self) -> f64 {
        self.g
    }

    /// What follows.
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

    /// β where `value` of [`at`](Self::at) is `wanted`, by halving: slow, and
    /// right whatever the curve. 0 is exact.
    fn solve(&self, wanted: f64, value: impl Fn((f64, f64)) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, self.parameters().beta1);
        loop {
            let middle = f64::midpoint(low, high);
            if middle <= low || middle >= high || wanted <= 0.0 {
                return low;
            }
            if value(self.at(middle)) < wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
    }

    /// θ of what is seen at `r_d`, 0 to π/2.
    pub fn theta(&self, r_d: f64) -> f64 {
        self.at(self.solve(r_d, |(_, r_d)| r_d)).0
    }

    /// Where what is at the angle `theta` to the zenith, 0 to π/2, is seen.
    pub fn r_d(&self, theta: f64) -> f64 {
        self.at(self.solve(theta, |(theta, _)| theta)).1
    }

    /// Where the line of sight through a point of the screen, at most b₁ from
    /// its centre, hits the mirror and where it goes from there, as vectors,
    /// in the axes of [`shisen_core::capture`].
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

    /// The angle to the zenith, from the screen's centre, of what is seen at
    /// `r_d` on a sphere of `radius` about that centre: section 5.4.
    ///
    /// At infinity it is θ.
    pub fn near_theta(&self, r_d: f64, radius: f64) -> f64 {
        let Parameters { c1, b1, .. } = self.parameters();
        let (point, direction) = self.reflect(DVec2::new(r_d * FRAC_2_PI * b1, 0.0));
        let from_centre = point + DVec3::Z * c1;
        let half = from_centre.dot(direction);
        let inside = radius * radius - from_centre.length_squared();
        let seen = from_centre + direction * ((half * half + inside).sqrt() - half);
        libm::atan2(seen.x, -seen.z)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Projection, optimum};
    use super::*;

    /// The three mirrors of Table 1 with the best viewpoints there are.
    fn mirrors() -> [Mirror; 3] {
        [
            (1.288, Projection::Parallel),
            (1.0, Projection::Perspective),
            (2.35, Projection::Perspective),
        ]
        .map(|(a, projection)| optimum(a, projection).unwrap().mirror)
    }

    #[test]
    fn the_mapping_has_the_digits_of_its_table() {
        let rows = [
            (
                10f64,
                [
                    (10.054_614_7, 9.945_655_78),
                    (10.480_273_5, 9.539_857_06),
                    (10.047_857_2, 9.952_351_56),
                ],
            ),
            (
                30.0,
                [
                    (30.109_462_6, 29.890_525_1),
                    (30.942_808_9, 29.056_354_1),
                    (30.097_860_8, 29.902_146_6),
                ],
            ),
            (
                50.0,
                [
                    (50.041_344_5, 49.958_393_5),
                    (50.359_941_8, 49.620_393_0),
                    (50.041_872_9, 49.957_899_9),
                ],
            ),
            (
                70.0,
                [
                    (69.906_278_5, 70.094_182_5),
                    (69.241_865_2, 70.790_802_0),
                    (69.921_720_0, 70.078_643_8),
                ],
            ),
            (90.0, [(90.0, 90.0), (90.0, 90.0), (90.0, 90.0)]),
        ];
        for (at, row) in rows {
            for (mirror, (theta, r_d)) in mirrors().into_iter().zip(row) {
                let found = [
                    mirror.theta(at.to_radians()).to_degrees(),
                    mirror.r_d(at.to_radians()).to_degrees(),
                ];
                for (found, exact) in found.into_iter().zip([theta, r_d]) {
                    // Nine digits, cut off and not rounded.
                    let unit = if exact < 10.0 { 1.0e-8 } else { 1.0e-7 };
                    assert!((found - exact).abs() <= unit, "{at}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn domes_near_the_mirror_have_the_errors_of_their_table() {
        let rows: [(f64, [f64; 3]); 5] = [
            (1.0, [92.850, 99.190, 48.743]),
            (3.0, [31.656, 45.461, 17.066]),
            (10.0, [10.655, 28.309, 6.355]),
            (100.0, [3.217, 22.139, 2.605]),
            (1.0e9, [2.569, 21.474, 2.227]),
        ];
        for (radius, row) in rows {
            for (mirror, exact) in mirrors().into_iter().zip(row) {
                let worst = (0..=20_000).fold(0f64, |worst, i| {
                    let r_d = FRAC_PI_2 * f64::from(i) / 20_000.0;
                    worst.max((mirror.near_theta(r_d, radius) - r_d).abs())
                });
                let found = worst / FRAC_PI_2 * 2048.0;
                assert!((found - exact).abs() <= 5.1e-4, "{radius}: {found} {exact}");
            }
        }
    }

    #[test]
    fn rings_near_the_mirror_are_where_their_table_says() {
        let [mirror, ..] = mirrors();
        let exact = [24.84, 48.14, 68.29, 83.54, 91.92, 91.10, 78.21, 49.55];
        for (i, exact) in exact.into_iter().enumerate() {
            let ring = (10.0 * (i + 1) as f64).to_radians();
            // Where the ring is seen.
            let (mut low, mut high) = (0.0, FRAC_PI_2);
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if mirror.near_theta(middle, 1.0) < ring {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let found = (low - ring).abs() / FRAC_PI_2 * 2048.0;
            assert!((found - exact).abs() <= 5.1e-3, "{i}: {found} {exact}");
        }
    }

    #[test]
    fn reflection_and_mapping_agree() {
        for mirror in mirrors() {
            let Parameters { b1, c1, .. } = mirror.parameters();
            for i in 0..=100 {
                let r_d = FRAC_PI_2 * f64::from(i) / 100.0;
                let r = r_d * FRAC_2_PI * b1;
                let (point, direction) = mirror.reflect(DVec2::new(0.6 * r, -0.8 * r));
                let across = direction.truncate().length();
                let theta = libm::atan2(across, -direction.z);
                assert!((theta - mirror.theta(r_d)).abs() < 1.0e-13);
                let on =
                    point.truncate().length_squared() + (point.z / mirror.axis_ratio()).powi(2);
                assert!((on - 1.0).abs() < 1.0e-14);
                if i == 100 {
                    assert!((point + DVec3::Z * c1).z.abs() < 1.0e-14);
                    assert!(direction.z.abs() < 1.0e-14);
                }
            }
        }
    }

    #[test]
    fn viewpoints_and_slopes_agree() {
        for a in [0.1, 1.0, 2.35, 10.0] {
            for g in [1.0e-3, 0.1, 0.5, 0.9, 0.999_999, 1.0 - 1.0e-12] {
                let Parameters { k, c1, .. } = Mirror::from_slope(a, g).unwrap().parameters();
                let found = Mirror::perspective(a, c1 + 1.0 / k).unwrap();
                // The viewpoint's own rounding, next to the pole.
                let bound = 1.0e-15 * (1.0 + a * a / g);
                assert!((found.slope() - g).abs() <= bound, "{a} {g} {found:?}");
            }
        }
    }

    #[test]
    fn mirrors_that_are_none_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Mirror::parallel(bad).is_err());
        }
        for bad in [f64::NAN, f64::INFINITY, 1.0, 0.5, -2.0] {
            assert!(Mirror::perspective(1.0, bad).is_err());
        }
        for bad in [f64::NAN, 0.0, 1.0 + f64::EPSILON] {
            assert!(Mirror::from_slope(1.0, bad).is_err());
        }
        for bad in [f64::NAN, 0.0, -0.1, 9.0e-4, FRAC_PI_2 / 2.0 + 1.0e-15, 2.0] {
            assert!(Mirror::from_edge(1.0, bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn edges_give_the_mirror_that_has_them() {
        for a in [0.01, 0.5, 1.0, 1.288, 2.35, 4.5, 100.0] {
            let most = libm::atan2(1.0, a);
            assert_eq!(Mirror::from_edge(a, most), Mirror::parallel(a));
            assert!(Mirror::from_edge(a, most.next_up()).is_err());
            for g in [0.2, 0.7, 0.999] {
                let mirror = Mirror::from_slope(a, g).unwrap();
                let found = Mirror::from_edge(a, mirror.parameters().beta1).unwrap();
                assert!((found.slope() - g).abs() < 1.0e-13 * a.max(1.0 / a));
            }
        }
    }

    #[test]
    fn errors_name_the_value_and_its_range() {
        for (error, words) in [
            (Mirror::parallel(-1.0), ["is -1:", "0.01 to 100"]),
            (Mirror::perspective(2.5, 2.0), ["is 2 radii", "above 2.5"]),
            (Mirror::from_slope(1.0, 1.5), ["is 1.5:", "0.000001 to 1"]),
            (
                Mirror::from_edge(1.0, 1.5),
                ["of 1.5 rad", "0.001 to 0.785398163"],
            ),
        ] {
            let says = error.unwrap_err().to_string();
            for words in words {
                assert!(says.contains(words), "{says}");
            }
        }
    }
}
