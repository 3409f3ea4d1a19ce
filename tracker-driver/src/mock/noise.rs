use super::random::hash;

/// Octaves, the slowest of which has a lattice of [`SLOWEST`].
const OCTAVES: u32 = 11;
/// Microseconds between the values of the slowest octave; those of the
/// fastest are 1 ms apart.
const SLOWEST: u64 = 1 << 20;
/// The variance of one octave: uniform on ±1 at the lattice, and between its
/// values what the blend leaves of it, 26/35 on average.
const OCTAVE_VARIANCE: f32 = 26.0 / 105.0;

/// Pink noise at a time, of variance 1: a sum of octaves of equal power, so
/// that the power falls as 1/f from about 0.5 Hz to 500 Hz. It has no state
/// and can be asked for at any time.
pub(super) fn pink(seed: u64, lane: u32, time: u64) -> f32 {
    let mut sum = 0.0;
    for octave in 0..OCTAVES {
        let step = SLOWEST >> octave;
        let index = time / step;
        let part = (time % step) as f32 / step as f32;
        let lane = lane.wrapping_mul(OCTAVES).wrapping_add(octave);
        let at = |index| (hash(seed, lane, index) >> 8) as f32 / 8_388_608.0 - 1.0;
        let blend = part * part * (3.0 - 2.0 * part);
        let (from, to) = (at(index), at(index.wrapping_add(1)));
        sum += from + (to - from) * blend;
    }
    sum / shisen_core::numeric::sqrt(OCTAVE_VARIANCE * OCTAVES as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The power at a frequency, by its Fourier sum.
    fn power(values: &[f64], step: f64, frequency: f64) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in values.iter().enumerate() {
            let phase = std::f64::consts::TAU * frequency * step * i as f64;
            // Hann's window.
            let part = i as f64 / values.len() as f64;
            let weight = 0.5 - 0.5 * (std::f64::consts::TAU * part).cos();
            re += weight * v * phase.cos();
            im += weight * v * phase.sin();
        }
        re * re + im * im
    }

    #[test]
    fn the_power_falls_as_one_over_the_frequency() {
        if cfg!(miri) {
            assert!(pink(1, 2, 3).abs() < 8.0);
            return;
        }
        let step = 0.001;
        let (mut points, mut variance) = (Vec::new(), 0.0);
        let lanes = 24;
        let values: Vec<Vec<f64>> = (0..lanes)
            .map(|lane| {
                (0..16_000u64)
                    .map(|i| f64::from(pink(5, lane, 7_000_000 + i * 1_000)))
                    .collect()
            })
            .collect();
        for values in &values {
            variance += values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
        }
        variance /= f64::from(lanes);
        assert!((variance - 1.0).abs() < 0.1, "{variance}");
        for i in 0..24 {
            let frequency = 1.0 * 2f64.powf(f64::from(i) / 3.0) * 1.0;
            let sum: f64 = values.iter().map(|v| power(v, step, frequency)).sum();
            points.push((frequency.ln(), sum.ln()));
        }
        let n = points.len() as f64;
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
        assert!((slope + 1.0).abs() < 0.15, "{slope}");
    }
}
