use super::SpheroidMirror;
use crate::numeric::{max, min, sin_cos, sines_and_cosines, sqrt};
use crate::simd::{Lanes, Portable};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2};
use libm::{atan2f, atanf};

/// What figure 5 draws of a point of the mirror. Angles are radians, lengths
/// equatorial radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorPoint {
    /// Distance from the axis: equation 10.
    pub b: f32,
    /// Along the axis, from the mirror's centre: equation 12.
    pub c: f32,
    /// Angle of the tangent to the equator's plane: equation 16.
    pub gamma: f32,
    /// Angle of the line of sight to the tangent: equations 34 and 41.
    pub psi: f32,
    /// Distance of the screen's point from its centre: equations 29 and 44.
    pub r: f32,
    /// r, with π/2 at the edge: equations 32 and 45.
    pub r_d: f32,
    /// Angle of the reflected ray to the zenith: equations 37 and 43.
    pub theta: f32,
}

impl SpheroidMirror {
    /// Returns the point at a parametric angle β, radians, from 0 at the pole to β₁
    /// ([`edge`](Self::edge)); `None` outside and for NaN. Error of θ and of `r_d` ≤ 8 ulp, for
    /// axis ratios from 0.5.
    ///
    /// With k = 1/d₁ and W = d/d₁ nothing cancels: W = (p − a)/d₁ + k·a·(1 − cos β),
    /// r = sin β/W and θ = tan⁻¹(k·sin β/W) + 2·tan⁻¹(a·tan β).
    pub fn point(&self, beta: f32) -> Option<MirrorPoint> {
        if !(beta >= 0.0 && beta <= self.edge()) {
            return None;
        }
        let (sin, cos) = sin_cos(beta);
        let w = self.clearance + self.k * self.a * sin * sin / (1.0 + cos);
        let gamma = atan2f(self.a * sin, cos);
        let r = sin / w;
        Some(MirrorPoint {
            b: sin,
            c: self.a * cos,
            gamma,
            psi: atan2f(w, self.k * sin) - gamma,
            r,
            r_d: FRAC_PI_2 * (r / self.b1),
            theta: atan2f(self.k * sin, w) + 2.0 * gamma,
        })
    }

    /// θ, the angle to the zenith of what is seen at `r_d`, both radians, 0 to π/2: equations 37
    /// and 43, with 32 and 45 solved for β. `None` outside and for NaN. Error ≤ 8 ulp for the
    /// named mirrors, ≤ 10 for axis ratios from 0.5.
    pub fn theta(&self, r_d: f32) -> Option<f32> {
        if !(0.0..=FRAC_PI_2).contains(&r_d) {
            return None;
        }
        let r = r_d * FRAC_2_PI * self.b1;
        let m = r * self.clearance;
        let n = r * (1.0 + self.k * (self.a + self.c1));
        let t = m / (1.0 + sqrt(max(1.0 - m * n, 0.0)));
        let gamma = atan2f(2.0 * self.a * t, (1.0 - t) * (1.0 + t));
        Some(atanf(self.k * r) + 2.0 * gamma)
    }

    /// `r_d`, where what is at the angle θ to the zenith is seen, both radians, 0 to π/2: the
    /// inverse of [`theta`](Self::theta), with its errors. `None` outside and for NaN.
    pub fn r_d(&self, theta: f32) -> Option<f32> {
        if !(0.0..=FRAC_PI_2).contains(&theta) {
            return None;
        }
        let sin_cos = sines_and_cosines(Portable, [theta]);
        let [slope] = self.slopes(Portable, [theta], sin_cos, self.exact_start());
        let (r, _) = self.at_slope(slope);
        Some(FRAC_PI_2 * min(r / self.b1, 1.0))
    }

    /// Coefficients of an odd polynomial in θ/(π/2) that [`slopes`](Self::slopes) start from.
    pub(crate) fn exact_start(&self) -> [f32; 3] {
        if self.k == 0.0 {
            return [0.0; 3];
        }
        // dθ/d(a·tan β), which is 2/(1 + slope²) + k·(dr)/(1 + k²·r²).
        let (r, r_rise) = self.at_slope(self.slope);
        let kr = self.k * r;
        let at_edge = 2.0 / (1.0 + self.slope * self.slope) + self.k * r_rise / (1.0 + kr * kr);
        let at_zenith = 2.0 + self.k / (self.a * self.clearance);
        let first = FRAC_PI_2 / at_zenith;
        let left = self.slope - first;
        let rise = FRAC_PI_2 / at_edge - first;
        let fifth = 0.5 * (rise - 3.0 * left);
        [first, left - fifth, fifth]
    }

    /// a·tan β at `theta`, 0 to π/2: equation 37 as tan(θ − 2γ) = k·r, by Newton steps.
    #[inline(always)]
    pub(super) fn slopes<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        theta: L::F,
        (sin, cos): (L::F, L::F),
        start: [f32; 3],
    ) -> L::F {
        const STEPS: usize = 12;
        /// Relative length of a step that changes nothing: 2⁻¹³.
        const NOTHING: f32 = 1.0 / 8192.0;
        let (one, two) = (l.splat(1.0), l.splat(2.0));
        if self.k == 0.0 {
            // Equation 43.
            return l.div(sin, l.add(one, cos));
        }
        let x = l.mul(theta, l.splat(FRAC_2_PI));
        let xx = l.mul(x, x);
        let [first, third, fifth] = start;
        let slope = l.add(l.mul(l.splat(fifth), xx), l.splat(third));
        let slope = l.add(l.mul(slope, xx), l.splat(first));
        let mut slope = l.mul(slope, x);
        let (mut low, mut high) = (l.splat(0.0), l.splat(self.slope));
        let mut done = l.le(one, l.splat(0.0));
        for _ in 0..STEPS {
            let (beyond, rise) = self.beyond(l, slope, (sin, cos));
            let short = l.le(beyond, l.splat(0.0));
            low = l.select(short, slope, low);
            high = l.select(short, high, slope);
            let next = l.sub(slope, l.div(beyond, rise));
            let between = l.and(l.le(low, next), l.le(next, high));
            let middle = l.div(l.add(low, high), two);
            let next = l.select(between, next, middle);
            let step = l.abs(l.sub(next, slope));
            // Only a step of Newton's own.
            let small = l.and(between, l.le(step, l.mul(l.splat(NOTHING), slope)));
            slope = l.select(done, slope, next);
            done = l.or(done, small);
            if l.bits(done) == (1 << W) - 1 {
                break;
            }
        }
        slope
    }

    /// k·r·cos(θ − 2γ) − sin(θ − 2γ), times what is above zero, and its derivative by the slope.
    #[inline(always)]
    fn beyond<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        slope: L::F,
        (sin, cos): (L::F, L::F),
    ) -> (L::F, L::F) {
        let (one, two) = (l.splat(1.0), l.splat(2.0));
        let (a, k) = (l.splat(self.a), l.splat(self.k));
        let (clearance, ka) = (l.splat(self.clearance), l.splat(self.k * self.a));
        let squared = l.mul(slope, slope);
        let hh = l.add(l.splat(self.a * self.a), squared);
        let h = l.sqrt(hh);
        let (twice, h_rise) = (l.mul(two, slope), l.div(slope, h));
        let over = l.mul(k, l.mul(slope, l.add(h, a)));
        let over_rise = l.mul(k, l.add(l.add(h, a), l.mul(slope, h_rise)));
        let under = l.mul(clearance, l.add(hh, l.mul(a, h)));
        let under = l.add(under, l.mul(ka, squared));
        let under_rise = l.mul(clearance, l.add(twice, l.mul(a, h_rise)));
        let under_rise = l.add(under_rise, l.mul(ka, twice));
        let flat = l.mul(l.sub(one, slope), l.add(one, slope));
        let along = l.add(l.mul(cos, flat), l.mul(twice, sin));
        let across = l.sub(l.mul(sin, flat), l.mul(twice, cos));
        let along_rise = l.mul(two, l.sub(sin, l.mul(slope, cos)));
        let across_fall = l.mul(two, l.add(cos, l.mul(slope, sin)));
        let rise = l.add(l.mul(over_rise, along), l.mul(over, along_rise));
        let rise = l.add(rise, l.mul(under, across_fall));
        (
            l.sub(l.mul(over, along), l.mul(under, across)),
            l.sub(rise, l.mul(under_rise, across)),
        )
    }

    /// r where a·tan β is `slope`, and how fast it grows with it.
    fn at_slope(&self, slope: f32) -> (f32, f32) {
        let a = self.a;
        let h = sqrt(a * a + slope * slope);
        let (sin, cos) = (slope / h, a / h);
        let ka = self.k * a;
        let w = self.clearance + ka * slope * slope / (h * (h + a));
        let rise = (cos * w - ka * sin * sin) * a / (w * h * w * h);
        (sin / w, rise)
    }
}
