//! Least squares by Givens rotations: each row turns into a triangle as it
//! comes, so that any number of rows needs the memory of the triangle, and
//! the normal equations, which square the condition, are never formed.

use shisen_core::numeric::sqrt;

/// The triangle of all rows so far, for `N` unknowns of two right-hand sides.
pub(super) struct LeastSquares<const N: usize> {
    triangle: [[f32; N]; N],
    right: [[f32; 2]; N],
}

impl<const N: usize> LeastSquares<N> {
    /// A diagonal element this much smaller than the largest may be rounding: taken for zero.
    const SINGULAR: f32 = 1.0e-4;

    pub(super) fn new() -> Self {
        Self {
            triangle: [[0.0; N]; N],
            right: [[0.0; 2]; N],
        }
    }

    /// Adds an equation: `row · unknowns = right`.
    pub(super) fn add(&mut self, mut row: [f32; N], mut right: [f32; 2]) {
        for i in 0..N {
            let (a, b) = (self.triangle[i][i], row[i]);
            if b == 0.0 {
                continue;
            }
            let length = sqrt(a * a + b * b);
            let (cos, sin) = (a / length, b / length);
            for j in i..N {
                let (upper, lower) = (self.triangle[i][j], row[j]);
                self.triangle[i][j] = cos * upper + sin * lower;
                row[j] = cos * lower - sin * upper;
            }
            for side in 0..2 {
                let (upper, lower) = (self.right[i][side], right[side]);
                self.right[i][side] = cos * upper + sin * lower;
                right[side] = cos * lower - sin * upper;
            }
        }
    }

    /// Returns whether rows within ±1 tell all unknowns apart by this much of the best one.
    pub(super) fn is_determined(&self, least: f32) -> bool {
        let diagonal = |i: usize| self.triangle[i][i].abs();
        let largest = (0..N).fold(0f32, |most, i| most.max(diagonal(i)));
        (0..N).all(|i| diagonal(i) > largest * least)
    }

    /// Returns the unknowns of each right-hand side; `None` where they are not determined.
    pub(super) fn solve(&self) -> Option<[[f32; N]; 2]> {
        let largest = (0..N).fold(0f32, |most, i| most.max(self.triangle[i][i].abs()));
        let mut unknowns = [[0.0; N]; 2];
        for i in (0..N).rev() {
            let diagonal = self.triangle[i][i];
            if !(diagonal.abs() > largest * Self::SINGULAR) {
                return None;
            }
            for (side, unknowns) in unknowns.iter_mut().enumerate() {
                let mut rest = self.right[i][side];
                for j in i + 1..N {
                    rest -= self.triangle[i][j] * unknowns[j];
                }
                unknowns[i] = rest / diagonal;
            }
        }
        let finite = unknowns.iter().flatten().all(|u| u.is_finite());
        finite.then_some(unknowns)
    }
}
