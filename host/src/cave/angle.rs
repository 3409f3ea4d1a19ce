//! Angles in degrees, the same bits on every platform.

/// Sine and cosine of an angle in degrees, any finite value. Multiples of 90 are exact. From `libm`,
/// because the platform's own functions differ in the last place from one to the next.
pub(crate) fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    // The remainder of a float division is exact.
    let turn = degrees % 360.0;
    let quadrant = libm::round(turn / 90.0);
    let (sin, cos) = libm::sincos((turn - quadrant * 90.0).to_radians());
    match quadrant as i32 {
        1 | -3 => (cos, -sin),
        2 | -2 => (-sin, -cos),
        3 | -1 => (-cos, sin),
        _ => (sin, cos),
    }
}
