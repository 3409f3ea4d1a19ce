//! Axes: where values are on them, and what is written beside them.

use std::ops::Range;

/// An axis of a chart.
#[derive(Debug, Clone)]
pub struct Axis {
    /// The column's name in the file of numbers.
    pub name: &'static str,
    /// The words beside the axis.
    pub label: &'static str,
    /// The range that is drawn; numbers outside are in the file, too.
    pub range: Range<f64>,
    /// Whether equal steps are equal ratios; the range is above 0 then.
    pub logarithmic: bool,
}

impl Axis {
    /// Returns a linear axis.
    pub const fn linear(name: &'static str, label: &'static str, range: Range<f64>) -> Self {
        Self {
            name,
            label,
            range,
            logarithmic: false,
        }
    }

    /// Returns the place of a value along the drawn axis.
    pub(super) fn place(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.log10()
        } else {
            value
        }
    }

    /// Returns a value between two, by places; the ends themselves at 0 and 1.
    pub(super) fn between(&self, low: f64, high: f64, part: f64) -> f64 {
        if part <= 0.0 {
            return low;
        }
        if part >= 1.0 {
            return high;
        }
        let (from, to) = (self.place(low), self.place(high));
        let place = from + (to - from) * part;
        let value = if self.logarithmic {
            10f64.powf(place)
        } else {
            place
        };
        value.clamp(self.range.start, self.range.end)
    }

    /// Returns the part, 0 to 1, of the way between two values that is in the range; reversed if
    /// none.
    pub(super) fn inside(&self, first: f64, last: f64) -> (f64, f64) {
        let (first, last) = (self.place(first), self.place(last));
        let (low, high) = (self.place(self.range.start), self.place(self.range.end));
        if first == last {
            return if (low..=high).contains(&first) {
                (0.0, 1.0)
            } else {
                (1.0, 0.0)
            };
        }
        let (a, b) = (
            (low - first) / (last - first),
            (high - first) / (last - first),
        );
        (a.min(b).max(0.0), a.max(b).min(1.0))
    }

    /// Returns whether a tick of a long logarithmic axis is not 1, 2 or 5 times a power of ten.
    fn is_crowded_at(&self, value: f64) -> bool {
        let digit = value / 10f64.powf(value.log10().floor());
        let is_round = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .any(|round: f64| (digit - round).abs() < 1.0e-6);
        let decades = (self.range.end / self.range.start).log10();
        decades > 0.5 && !is_round
    }

    pub(super) fn tick(&self, value: f64) -> String {
        if self.logarithmic && self.is_crowded_at(value) {
            return String::new();
        }
        if self.logarithmic && !(1.0e-3..1.0e5).contains(&value) {
            return format!("{value:.0e}");
        }
        let extent = self.range.end - self.range.start;
        if extent < 1.0e-3 {
            let zero = value.abs() < 1.0e-6 * extent;
            let digits = format!("{:.1e}", if zero { 0.0 } else { value });
            return if zero {
                "0".to_owned()
            } else {
                digits.replace(".0e", "e")
            };
        }
        // Ticks are round numbers; their sums are not.
        let digits = format!("{value:.6}");
        let short = digits.trim_end_matches('0').trim_end_matches('.');
        if short == "-0" { "0" } else { short }.to_owned()
    }
}
