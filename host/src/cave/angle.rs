//! Angles in degrees, the same bits on every platform.

/// Sine and cosine of an angle in degrees, any finite value.
///
/// Multiples of 90 are exact, so that 90° is straight to the side and not
/// 6e-17 off it. From `libm`, because the platform's own functions differ
/// in the last place from one to the next.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_of_ninety_are_exact() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (180.0, (0.0, -1.0)),
            (270.0, (-1.0, 0.0)),
            (360.0, (0.0, 1.0)),
            (-90.0, (-1.0, 0.0)),
            (-180.0, (0.0, -1.0)),
            (-270.0, (1.0, 0.0)),
            (3690.0, (1.0, 0.0)),
        ] {
            assert_eq!(sin_cos_degrees(degrees), expected, "{degrees} degrees");
        }
    }

    #[test]
    fn agrees_with_radians_all_round() {
        for degrees in -720..=720 {
            let (sin, cos) = sin_cos_degrees(degrees as f64);
            let radians = (degrees as f64).to_radians();
            assert!((sin - radians.sin()).abs() < 1e-14, "sin {degrees}");
            assert!((cos - radians.cos()).abs() < 1e-14, "cos {degrees}");
        }
    }
}
