//! Structural similarity, pixel by pixel.

/// The window, as in the paper: a Gaussian of this standard deviation, and its pixels to each
/// side.
const DEVIATION: f64 = 1.5;
const REACH: usize = 5;

/// The paper's constants for a range of 255: K1 = 0.01, K2 = 0.03.
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Returns the similarity of two pictures around each pixel, −1 to 1: equation 13 of Wang et al.
/// (2004). Rows have `width` lumas, 0 to 255; at the border the window ends.
pub(super) fn similarities(one: &[f64], other: &[f64], width: usize) -> Vec<f64> {
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        let pairs = one.iter().zip(other);
        blurred(&pairs.map(|(&x, &y)| of(x, y)).collect::<Vec<_>>(), width)
    };
    let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
    let (xx, yy, xy) = (
        mean(&|x, _| x * x),
        mean(&|_, y| y * y),
        mean(&|x, y| x * y),
    );
    (0..x.len())
        .map(|i| {
            let (squares, product) = (x[i] * x[i] + y[i] * y[i], x[i] * y[i]);
            let variances = (xx[i] + yy[i] - squares).max(0.0);
            let covariance = xy[i] - product;
            (2.0 * product + C1) * (2.0 * covariance + C2) / ((squares + C1) * (variances + C2))
        })
        .collect()
}

fn blurred(pixels: &[f64], width: usize) -> Vec<f64> {
    let height = pixels.len() / width.max(1);
    let tap = |off: usize| {
        let off = off as f64 / DEVIATION;
        libm::exp(-0.5 * off * off)
    };
    let taps: Vec<f64> = (0..=REACH).map(tap).collect();
    let along = |from: &[f64], place: usize, count: usize, index: &dyn Fn(usize) -> usize| {
        let near = place.saturating_sub(REACH)..(place + REACH + 1).min(count);
        let (mut sum, mut weight) = (0.0, 0.0);
        for at in near {
            let tap = taps[at.abs_diff(place)];
            sum += tap * from[index(at)];
            weight += tap;
        }
        sum / weight
    };
    let all = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rows: Vec<f64> = all()
        .map(|(x, y)| along(pixels, x, width, &|at| y * width + at))
        .collect();
    all()
        .map(|(x, y)| along(&rows, y, height, &|at| at * width + x))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_are_alike_and_inverse_ones_are_not() {
        let stripes: Vec<f64> = (0..400).map(|i| f64::from(i % 2) * 255.0).collect();
        let inverse: Vec<f64> = stripes.iter().map(|one| 255.0 - one).collect();
        assert!(
            similarities(&stripes, &stripes, 20)
                .iter()
                .all(|&one| (one - 1.0).abs() < 1e-12)
        );
        // The middle: means equal, covariance the negative variance.
        let found = similarities(&stripes, &inverse, 20)[10 * 20 + 10];
        assert!((-1.0..-0.98).contains(&found), "{found}");
    }
}
