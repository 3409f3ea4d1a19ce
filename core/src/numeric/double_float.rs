use super::sqrt;

/// A number as the unevaluated sum of two f32, good to 46 bits without overflow (Dekker, "A
/// Floating-Point Technique for Extending the Available Precision", 1971).
#[derive(Clone, Copy)]
pub(crate) struct DoubleFloat {
    /// The nearest f32 to the number, which is all but for the last digits.
    pub(crate) high: f32,
    pub(crate) low: f32,
}

impl From<f32> for DoubleFloat {
    fn from(x: f32) -> Self {
        Self { high: x, low: 0.0 }
    }
}

impl DoubleFloat {
    /// a + b, exactly.
    pub(crate) fn sum(a: f32, b: f32) -> Self {
        let high = a + b;
        let of_b = high - a;
        let low = (a - (high - of_b)) + (b - of_b);
        Self { high, low }
    }

    /// a·b, exactly.
    pub(crate) fn product(a: f32, b: f32) -> Self {
        let high = a * b;
        let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
        let low = ((a_high * b_high - high) + a_high * b_low + a_low * b_high) + a_low * b_low;
        Self { high, low }
    }

    pub(crate) fn add(self, other: Self) -> Self {
        let sum = Self::sum(self.high, other.high);
        // Low parts of numbers that cancel are all that is left of them.
        let low = Self::sum(self.low, other.low);
        let sum = Self::sum(sum.high, sum.low + low.high);
        Self::sum(sum.high, sum.low + low.low)
    }

    pub(crate) fn negate(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }

    pub(crate) fn multiply(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        Self::sum(product.high, product.low + cross)
    }

    /// 1/√self for numbers above zero: one Newton step from the f32 value.
    pub(crate) fn reciprocal_sqrt(self) -> Self {
        let estimate = Self::from(1.0 / sqrt(self.high));
        let residue = Self::from(1.0).add(estimate.multiply(estimate).multiply(self).negate());
        estimate.add(estimate.multiply(residue).multiply(Self::from(0.5)))
    }

    /// Returns the sum of some numbers within an ulp, however many digits cancel (Ogita, Rump &
    /// Oishi, "Accurate Sum and Dot Product", 2005).
    pub(crate) fn exact_sum<const N: usize>(numbers: [Self; N]) -> f32 {
        let mut carried = Self::from(0.0);
        let mut left = numbers;
        for _ in 0..4 {
            let mut above = 0.0;
            for number in &mut left {
                // All that is above goes up, and the rest stays.
                let high = Self::sum(above, number.high);
                let low = Self::sum(high.high, number.low);
                above = low.high;
                *number = Self::sum(high.low, low.low);
            }
            carried = carried.add(Self::from(above));
        }
        let rest = left.iter().fold(0.0, |sum, number| sum + number.rounded());
        carried.add(Self::from(rest)).rounded()
    }

    /// Returns the nearest f32.
    pub(crate) fn rounded(self) -> f32 {
        self.high + self.low
    }
}

/// x as the sum of two numbers of twelve significant bits (Veltkamp 1968).
fn halves(x: f32) -> (f32, f32) {
    let scaled = x * 4097.0;
    let high = scaled - (scaled - x);
    (high, x - high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn exact(x: DoubleFloat) -> f64 {
        f64::from(x.high) + f64::from(x.low)
    }

    fn double(x: f64) -> DoubleFloat {
        let high = x as f32;
        let low = (x - f64::from(high)) as f32;
        DoubleFloat { high, low }
    }

    proptest! {
        #[test]
        fn double_floats_have_45_bits(a in -2f64..2.0, b in -2f64..2.0) {
            let (x, y) = (double(a), double(b));
            let (a, b) = (exact(x), exact(y));
            let near = |found: DoubleFloat, expected: f64, scale: f64| {
                (exact(found) - expected).abs() <= scale * 2f64.powi(-45)
            };
            prop_assert!(near(x.multiply(y), a * b, (a * b).abs()));
            prop_assert!(near(x.add(y), a + b, (a + b).abs().max(1e-9)));
            prop_assert!(near(x.add(y.negate()), a - b, (a - b).abs().max(1e-9)));
            if a > 1e-6 {
                prop_assert!(near(x.reciprocal_sqrt(), 1.0 / a.sqrt(), 1.0 / a.sqrt()));
            }
            prop_assert_eq!(x.rounded(), a as f32);
            // What is left of numbers that cancel but for their last digits.
            let tiny = double(b * 2f64.powi(-80));
            let sum = DoubleFloat::exact_sum([x, y, tiny, x.negate(), y.negate()]);
            prop_assert!((f64::from(sum) - exact(tiny)).abs() <= exact(tiny).abs() * 1.2e-7);
        }
    }
}
