use crate::numeric::{UNIT_ROUNDOFF, min, sin_cos, sqrt};
use libm::{atan2f, atanf};

/// A mirrored spheroid of equatorial radius 1 about −Z, centred on the origin, and what looks
/// at it: figures 5 and 8. Relative error of all lengths ≤ 8 ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpheroidMirror {
    /// Polar radius.
    pub(super) a: f32,
    /// Viewpoint's distance from the centre.
    p: Option<f32>,
    /// a·tan β₁, the slope at the edge: 1 in parallel projection.
    pub(super) slope: f32,
    /// 1/d₁: 0 in parallel projection.
    pub(super) k: f32,
    pub(super) c1: f32,
    pub(super) b1: f32,
    /// (p − a)/d₁: 1 in parallel projection, and 3/4 at least.
    pub(super) clearance: f32,
}

/// Why a mirror cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum MirrorError {
    /// The axis ratio is NaN or outside [`SpheroidMirror::AXIS_RATIOS`].
    #[error(
        "the mirror's axis ratio is {a}: give a number from {} to {}",
        SpheroidMirror::AXIS_RATIOS.0, SpheroidMirror::AXIS_RATIOS.1
    )]
    AxisRatio { a: f32 },
    /// The viewpoint is NaN, infinite, in the mirror or on its pole.
    #[error(
        "the viewpoint is {p} radii from the mirror's centre: give a finite number above {a}, where \
         its pole is, or parallel projection"
    )]
    Viewpoint { p: f32, a: f32 },
    /// An edge that is NaN, next to the pole, or past parallel projection: a·tan β₁ > 1.
    #[error(
        "the edge is at a parametric angle of {beta1} rad: give a number from {} to {most}, which is \
         parallel projection",
        SpheroidMirror::LEAST_EDGE
    )]
    Edge { beta1: f32, most: f32 },
}

impl SpheroidMirror {
    /// Least and greatest polar by equatorial radius: beyond, the hemisphere is too small for f32.
    pub const AXIS_RATIOS: (f32, f32) = (0.01, 100.0);

    /// The least β₁ that [`from_edge`](Self::from_edge) takes, radians: the
    /// viewpoint is then 1.5·10⁻⁶·a over the pole.
    pub const LEAST_EDGE: f32 = 1.0e-3;

    /// Table 1 (1): parallel projection, a = 1.288. Largest error 0.1254 % of
    /// the picture's radius, 2.57 pixels at 4096.
    pub const PAPER_PARALLEL: Self = Self {
        a: 1.288,
        p: None,
        slope: 1.0,
        k: 0.0,
        c1: 1.017_365_7,
        b1: 0.613_261_04,
        clearance: 1.0,
    };

    /// Table 1 (2): perspective, a sphere, p = 1.277, here with all digits of
    /// its best viewpoint. Largest error 1.0485 %, 21.47 pixels at 4096.
    pub const PAPER_SPHERE: Self = Self {
        a: 1.0,
        p: Some(1.276_709_7),
        slope: 0.396_686_23,
        k: 2.880_395,
        c1: 0.929_535_1,
        b1: 0.368_733_76,
        clearance: 0.797_033_13,
    };

    /// Table 1 (3): perspective, a = 2.35, p = 3.374, here with all digits of
    /// its best viewpoint. Largest error 0.1087 %, 2.23 pixels at 4096.
    pub const PAPER_SPHEROID: Self = Self {
        a: 2.35,
        p: Some(3.374_106_2),
        slope: 0.764_659_7,
        k: 0.877_631_3,
        c1: 2.234_675_4,
        b1: 0.309_419,
        clearance: 0.898_787_74,
    };

    /// The least error by parallel projection: 0.1238 %, 2.54 pixels at 4096.
    pub const BEST_PARALLEL: Self = Self {
        a: 1.288_248_3,
        p: None,
        slope: 1.0,
        k: 0.0,
        c1: 1.017_635_7,
        b1: 0.613_187_3,
        clearance: 1.0,
    };

    /// The least error by perspective, and of all: 0.1058 %, 2.17 pixels at
    /// 4096. (The paper's errors fall on beyond its a = 2.35.)
    pub const BEST: Self = Self {
        a: 4.504_15,
        p: Some(4.892_703_5),
        slope: 0.708_989_9,
        k: 2.255_615_2,
        c1: 4.449_365_6,
        b1: 0.155_493_59,
        clearance: 0.876_427_4,
    };

    /// Parallel projection under the given axis ratio: equations 38 to 40.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS).
    pub fn parallel(a: f32) -> Result<Self, MirrorError> {
        check_axis_ratio(a)?;
        Ok(Self::seen(a, None, (1.0, sqrt(a * a + 1.0)), 0.0, 1.0))
    }

    /// Perspective from a viewpoint `p` from the mirror's centre: equations 19 to 24, solved for
    /// β₁ by g² = 1/(1 + 2/(d₁·h)) with g = a·tan β₁ and h = √(a² + g²), an iteration that halves
    /// its error at least.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), a viewpoint that is not finite or
    /// not above the pole.
    pub fn perspective(a: f32, p: f32) -> Result<Self, MirrorError> {
        check_axis_ratio(a)?;
        if !(p > a && p.is_finite()) {
            return Err(MirrorError::Viewpoint { p, a });
        }
        let above = p - a;
        let mut slope = 1.0;
        for _ in 0..32 {
            let (h, sagitta) = section(a, slope);
            let next = 1.0 / sqrt(1.0 + 2.0 / ((above + sagitta) * h));
            if next == slope {
                break;
            }
            slope = next;
        }
        let (h, sagitta) = section(a, slope);
        let d1 = above + sagitta;
        Ok(Self::seen(a, Some(p), (slope, h), 1.0 / d1, above / d1))
    }

    /// Returns the viewpoint that shows the dome's rim at the parametric angle `beta1` of the
    /// mirror, radians: equations 19 to 24. Parallel projection where a·tan β₁ is 1 but for
    /// rounding.
    ///
    /// # Errors
    /// An axis ratio outside [`AXIS_RATIOS`](Self::AXIS_RATIOS), an edge outside
    /// [`LEAST_EDGE`](Self::LEAST_EDGE) to tan⁻¹(1/a).
    pub fn from_edge(a: f32, beta1: f32) -> Result<Self, MirrorError> {
        check_axis_ratio(a)?;
        let most = atan2f(1.0, a);
        if !(Self::LEAST_EDGE..=most).contains(&beta1) {
            return Err(MirrorError::Edge { beta1, most });
        }
        let (sin, cos) = sin_cos(beta1);
        let slope = a * sin / cos;
        // How far an error of one unit of β₁ and of its sine and cosine each
        // moves the slope.
        let unsure = UNIT_ROUNDOFF * (beta1 * (a + 1.0 / a) + 3.0);
        if slope >= 1.0 - unsure {
            return Self::parallel(a);
        }
        let (h, sagitta) = section(a, slope);
        // Equation 22, tan 2γ₁ written out.
        let lift = (1.0 - slope) * (1.0 + slope);
        let d1 = 2.0 * slope * slope / (lift * h);
        let (p, clearance) = (a - sagitta + d1, 1.0 - 0.5 * a * lift / (h + a));
        Ok(Self::seen(a, Some(p), (slope, h), 1.0 / d1, clearance))
    }

    /// Returns the mirror whose edge has a slope, and h = a/cos β₁.
    fn seen(a: f32, p: Option<f32>, (slope, h): (f32, f32), k: f32, clearance: f32) -> Self {
        Self {
            a,
            p,
            slope,
            k,
            c1: a * (a / h),
            b1: slope / h,
            clearance,
        }
    }

    /// a: the polar radius, the equatorial being 1.
    pub const fn axis_ratio(&self) -> f32 {
        self.a
    }

    /// p: the viewpoint's distance from the mirror's centre, along −Z, in equatorial radii; `None`
    /// in parallel projection.
    pub const fn viewpoint(&self) -> Option<f32> {
        self.p
    }

    /// β₁: the parametric angle of the mirror where the dome's rim is seen,
    /// radians. Equations 22 and 39.
    pub fn edge(&self) -> f32 {
        atan2f(self.slope, self.a)
    }

    /// c₁: the distance from the mirror's centre, along −Z, in equatorial radii, of the screen,
    /// whose centre a dome near the mirror should have, too (equation 19).
    pub const fn screen_distance(&self) -> f32 {
        self.c1
    }

    /// b₁: half the screen's width, in equatorial radii. Equations 20 and 40.
    pub const fn screen_radius(&self) -> f32 {
        self.b1
    }

    /// d₁: the viewpoint's distance from the screen (equation 22); `None` in parallel projection.
    pub fn viewpoint_to_screen(&self) -> Option<f32> {
        // The reciprocal's own rounding can be too much for the farthest.
        self.p.map(|_| min(1.0 / self.k, f32::MAX))
    }

    /// Returns the full angle of view that just holds the screen, radians, above 0 and below π; 0
    /// in parallel projection, which has the width of twice the
    /// [`screen_radius`](Self::screen_radius).
    pub fn field_of_view(&self) -> f32 {
        2.0 * atanf(self.k * self.b1)
    }
}

fn check_axis_ratio(a: f32) -> Result<(), MirrorError> {
    let (least, most) = SpheroidMirror::AXIS_RATIOS;
    let is_within = (least..=most).contains(&a).then_some(());
    is_within.ok_or(MirrorError::AxisRatio { a })
}

/// h = a/cos β and a − c of the place where a·tan β is `slope`.
fn section(a: f32, slope: f32) -> (f32, f32) {
    let h = sqrt(a * a + slope * slope);
    (h, a * slope * slope / (h * (h + a)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Mapping;
    use crate::hostile::{finite, finite_or_error, is_unit, with_hostile_numbers};
    use core::f32::consts::FRAC_PI_2;

    #[test]
    fn mirrors_that_are_none_are_refused() {
        use std::string::ToString as _;
        let says = |made: Result<SpheroidMirror, MirrorError>, words: &str| {
            let error = made.unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let nan = f32::NAN;
        for a in [0.0, -1.0, 0.009, 101.0, f32::INFINITY, nan] {
            says(SpheroidMirror::parallel(a), "0.01 to 100");
            says(SpheroidMirror::perspective(a, 2.0), "0.01 to 100");
            says(SpheroidMirror::from_edge(a, 0.1), "0.01 to 100");
        }
        for p in [2.0, 1.999, 0.0, -3.0, f32::INFINITY, f32::NEG_INFINITY, nan] {
            says(SpheroidMirror::perspective(2.0, p), "above 2");
        }
        for beta1 in [0.0, -0.1, 9.0e-4, 0.786, 2.0, f32::INFINITY, nan] {
            says(SpheroidMirror::from_edge(1.0, beta1), "0.001 to 0.7853982");
        }
    }

    #[test]
    fn mirrors_of_any_numbers_are_finite_and_reflect_finite_rays() {
        with_hostile_numbers(|n| {
            let (a, p, beta) = (n.next(0.7), n.next(5.0), n.next(0.5));
            let (u, v) = (n.next(0.3), n.next(-0.4));
            let mirrors = [
                SpheroidMirror::parallel(a),
                SpheroidMirror::perspective(a, p),
                SpheroidMirror::from_edge(a, beta),
                Ok(SpheroidMirror::PAPER_SPHERE),
                Ok(SpheroidMirror::BEST),
            ];
            for mirror in mirrors.into_iter().filter_map(finite_or_error) {
                finite(&(mirror, mirror.edge(), mirror.field_of_view()));
                finite(&mirror.viewpoint_to_screen());
                finite(&(mirror.point(beta), mirror.theta(u), mirror.r_d(u)));
                let is_angle = (0.0..=FRAC_PI_2).contains(&u);
                assert_eq!(mirror.theta(u).is_some(), is_angle);
                assert_eq!(mirror.r_d(u).is_some(), is_angle);
                let on_mirror = (0.0..=mirror.edge()).contains(&beta);
                assert_eq!(mirror.point(beta).is_some(), on_mirror);
                let seen = [Mapping::Exact, Mapping::Screen].map(|by| mirror.pixel(u, v, by));
                let inside = u.abs() <= 1.0 && v.abs() <= 1.0;
                assert!(inside || seen == [None; 2]);
                for seen in seen.iter().flatten() {
                    finite(seen);
                    is_unit(&seen.direction);
                }
            }
        });
    }
}
