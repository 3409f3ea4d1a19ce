//! Time, and what is made of times.

use rustix::time::{ClockId, clock_gettime};

/// Seconds that this process's threads have run.
pub fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1.0e-9 * time.tv_nsec as f64
}

/// Processor seconds of each of these, who take turns, round after round: by contender,
/// then round.
pub fn interleaved(contenders: &mut [Box<dyn FnMut() + '_>], rounds: usize) -> Vec<Vec<f64>> {
    let mut seconds = vec![Vec::new(); contenders.len()];
    for _ in 0..rounds {
        for (contender, seconds) in contenders.iter_mut().zip(&mut seconds) {
            let start = cpu_seconds();
            contender();
            seconds.push(cpu_seconds() - start);
        }
    }
    seconds
}

/// The middle of some numbers; NaN of none.
pub fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        count => f64::midpoint(sorted[(count - 1) / 2], sorted[count / 2]),
    }
}

/// How many times as fast as another one is, by the median of the rounds.
pub fn faster(ours: &[f64], theirs: &[f64]) -> f64 {
    let ratios: Vec<_> = ours
        .iter()
        .zip(theirs)
        .map(|(us, them)| them / us)
        .collect();
    median(&ratios)
}

/// The geometric mean of numbers above 0; NaN of none.
pub fn geometric_mean(numbers: &[f64]) -> f64 {
    let sum: f64 = numbers.iter().map(|number| number.ln()).sum();
    (sum / numbers.len() as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&[]).is_nan());
        assert!((geometric_mean(&[0.5, 2.0, 8.0]) - 2.0).abs() < 1.0e-12);
        // Twice, three times and half as fast.
        assert_eq!(faster(&[1.0, 1.0, 2.0], &[2.0, 3.0, 1.0]), 2.0);
    }

    #[test]
    fn work_takes_processor_time() {
        let mut sum = 0.0f64;
        let mut none: Vec<Box<dyn FnMut() + '_>> = vec![
            Box::new(|| {}),
            Box::new(|| {
                for i in 0..3_000_000 {
                    sum = std::hint::black_box(sum + f64::from(i).sqrt());
                }
            }),
        ];
        let seconds = interleaved(&mut none, 3);
        assert_eq!([seconds.len(), seconds[0].len()], [2, 3]);
        assert!(
            seconds[1].iter().all(|&s| s > median(&seconds[0])),
            "{seconds:?}"
        );
    }
}
