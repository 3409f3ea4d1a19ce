//! Eigenvalues of symmetric matrices, by Jacobi's rotations.

/// The eigenvalues of a symmetric matrix and their vectors.
#[derive(Debug)]
pub(super) struct Eigen {
    /// In no order.
    pub(super) values: Vec<f64>,
    /// Unit vectors, one a value.
    pub(super) vectors: Vec<Vec<f64>>,
}

impl Eigen {
    /// Rotations of all pairs end after so many rounds; they converge in about ten.
    const ROUNDS: usize = 60;

    pub(super) fn new(mut matrix: Vec<Vec<f64>>) -> Self {
        let size = matrix.len();
        let unit = |row| (0..size).map(|i| f64::from(u8::from(i == row))).collect();
        let mut vectors: Vec<Vec<f64>> = (0..size).map(unit).collect();
        let sizes = (0..size).map(|i| matrix[i][i].abs());
        let least = f64::EPSILON * 0.1 * sizes.sum::<f64>();
        for _ in 0..Self::ROUNDS {
            let mut is_diagonal = true;
            for p in 0..size {
                for q in p + 1..size {
                    let off = matrix[p][q];
                    // Also where it is not a number.
                    if !(off.abs() > least) {
                        continue;
                    }
                    is_diagonal = false;
                    let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
                    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
                    let cosine = 1.0 / tangent.hypot(1.0);
                    let rotate = |a: &mut f64, b: &mut f64| {
                        let sine = tangent * cosine;
                        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
                    };
                    for row in &mut matrix {
                        let (left, right) = row.split_at_mut(q);
                        rotate(&mut left[p], &mut right[0]);
                    }
                    for rows in [&mut matrix, &mut vectors] {
                        let (above, below) = rows.split_at_mut(q);
                        let pairs = above[p].iter_mut().zip(&mut below[0]);
                        pairs.for_each(|(a, b)| rotate(a, b));
                    }
                }
            }
            if is_diagonal {
                break;
            }
        }
        let values = (0..size).map(|i| matrix[i][i]).collect();
        Self { values, vectors }
    }

    /// Returns the product of a vector with the matrix whose eigenvalues `change` makes of these.
    pub(super) fn apply(&self, change: impl Fn(f64) -> f64, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; vector.len()];
        for (value, own) in self.values.iter().zip(&self.vectors) {
            let part = change(*value) * dot(own, vector);
            let both = product.iter_mut().zip(own);
            both.for_each(|(sum, along)| *sum += part * along);
        }
        product
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
