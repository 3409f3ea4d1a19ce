//! Where a function of one number crosses zero or is least.

/// Returns where `f`, of one sign at `low` and the other at `high`, changes it.
pub(super) fn crossing(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let sign = f(low) > 0.0;
    bisect(low, high, |x| (f(x) > 0.0) == sign)
}

/// Returns the last number on the way from `good` to `bad` that `is_good`, which holds at `good`
/// only.
pub(super) fn bisect(mut good: f64, mut bad: f64, is_good: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = good.midpoint(bad);
        // The midpoint of neighbours is one of them.
        if middle == good || middle == bad {
            return good;
        }
        if is_good(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
}

/// Returns where `f`, which falls and then rises, is least.
pub(super) fn golden(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_x, mut at_y) = (f(x), f(y));
    for _ in 0..80 {
        if at_x < at_y {
            (high, y, at_y) = (y, x, at_x);
            x = high - ratio * (high - low);
            at_x = f(x);
        } else {
            (low, x, at_x) = (x, y, at_y);
            y = low + ratio * (high - low);
            at_y = f(y);
        }
    }
    low.midpoint(high)
}
