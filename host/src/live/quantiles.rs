//! Quantiles of repeated measurements.

/// Returns the median.
pub fn median(of: Vec<f64>) -> f64 {
    quantile_of(of, 0.5)
}

/// Returns the median ratio of pairs measured in turns: the machine's speed affects both of a pair.
pub fn median_ratio(of: &[f64], to: &[f64]) -> f64 {
    median(of.iter().zip(to).map(|(of, to)| of / to).collect())
}

/// Returns the lower and the upper quartile.
pub fn quartiles(of: Vec<f64>) -> [f64; 2] {
    [quantile_of(of.clone(), 0.25), quantile_of(of, 0.75)]
}

/// Returns the quantile of a part, 0 to 1, interpolated linearly (Hyndman and Fan's seventh
/// definition, 1996); 0 for no numbers.
pub fn quantile_of(mut of: Vec<f64>, part: f64) -> f64 {
    of.sort_by(f64::total_cmp);
    let place = part * of.len().saturating_sub(1) as f64;
    let at = |index: f64| of.get(index as usize).copied().unwrap_or_default();
    let (low, high) = (at(place.floor()), at(place.ceil()));
    low + (high - low) * place.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_between_neighbours() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(quartiles(vec![5.0, 1.0, 4.0, 2.0, 3.0]), [2.0, 4.0]);
        assert_eq!(quartiles(vec![1.0, 2.0]), [1.25, 1.75]);
        assert_eq!(quartiles(vec![7.0]), [7.0, 7.0]);
        assert_eq!(quantile_of(vec![2.0, 0.0, 1.0], 0.75), 1.5);
        assert_eq!(median(Vec::new()), 0.0);
        // Twice as slow in between: the medians, 2 and 5, say nothing.
        assert_eq!(median_ratio(&[1.0, 2.0, 2.0], &[5.0, 10.0, 4.0]), 0.2);
        assert_eq!(median_ratio(&[], &[]), 0.0);
    }
}
