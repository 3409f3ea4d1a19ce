use super::random::hash;

/// Octaves, the slowest of which has a lattice of [`SLOWEST`].
const OCTAVES: u32 = 11;
/// Microseconds between the values of the slowest octave; the fastest's are 1 ms apart.
const SLOWEST: u64 = 1 << 20;
/// The variance of one octave: 1/3 at its lattice, times 26/35 for the blend between.
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
