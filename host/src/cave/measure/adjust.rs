//! Places of corners that fit measurements best: Gauss and Newton's steps, damped.

use super::eigen::{Eigen, dot};
use super::{Measurement, Quantity};
use glam::DVec3;

/// Corners that fit measurements best.
#[derive(Debug)]
pub(super) struct Adjusted {
    /// Metres.
    pub(super) places: Vec<DVec3>,
    /// Values at these places less the measured ones, by their standard deviations.
    pub(super) residuals: Vec<f64>,
    /// For each coordinate, x, y and z of each place, its column.
    columns: Vec<Option<usize>>,
    /// The derivatives of residuals by the free coordinates.
    rows: Vec<Vec<f64>>,
    /// The eigenvectors of the matrix of the rows' products.
    eigen: Eigen,
}

impl Adjusted {
    /// Most steps; damped ones from a poor start take tens.
    const STEPS: usize = 300;

    /// Moves the free coordinates, by their numbers 3 × corner + axis, from where they are.
    pub(super) fn new(measurements: &[Measurement], places: Vec<DVec3>, free: &[usize]) -> Self {
        let mut columns = vec![None; 3 * places.len()];
        for (column, &coordinate) in free.iter().enumerate() {
            columns[coordinate] = Some(column);
        }
        let mut best = Self::linearise(measurements, places, columns);
        let largest = best.eigen.values.iter().copied().fold(0.0, f64::max);
        let (least, most) = (1.0e-15 * largest, 1.0e6 * largest);
        let mut damping = 1.0e-3 * largest;
        for _ in 0..Self::STEPS {
            let step = best.step(damping);
            let places: Vec<DVec3> = best.moved(&step);
            let after = Self::residuals(measurements, &places);
            let (cost, new_cost) = (dot(&best.residuals, &best.residuals), dot(&after, &after));
            if new_cost <= cost {
                best = Self::linearise(measurements, places, best.columns);
                damping = (0.1 * damping).max(least);
                let longest = step.iter().map(|one| one.abs()).fold(0.0, f64::max);
                if longest < 1.0e-9
                    || cost - new_cost <= 1.0e-12 * cost && damping <= 1.0e-9 * largest
                {
                    break;
                }
            } else {
                damping *= 10.0;
                // Also where nothing is a number.
                if !(damping < most) {
                    break;
                }
            }
        }
        best
    }

    fn residuals(measurements: &[Measurement], places: &[DVec3]) -> Vec<f64> {
        let residual = |one: &Measurement| (one.quantity.value(places) - one.measured) / one.sigma;
        measurements.iter().map(residual).collect()
    }

    fn linearise(
        measurements: &[Measurement],
        places: Vec<DVec3>,
        columns: Vec<Option<usize>>,
    ) -> Self {
        let size = columns.iter().flatten().count();
        let rows = measurements.iter().map(|one| {
            let mut row = vec![0.0; size];
            for (corner, gradient) in one.quantity.gradient(&places) {
                let axes = columns[3 * corner..].iter().zip(gradient.to_array());
                for (column, along) in axes {
                    if let Some(column) = *column {
                        row[column] += along / one.sigma;
                    }
                }
            }
            row
        });
        let rows: Vec<Vec<f64>> = rows.collect();
        let product = |i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum();
        let products = (0..size).map(|i| (0..size).map(|j| product(i, j)).collect());
        Self {
            residuals: Self::residuals(measurements, &places),
            eigen: Eigen::new(products.collect()),
            places,
            columns,
            rows,
        }
    }

    fn step(&self, damping: f64) -> Vec<f64> {
        let slope = (0..self.eigen.values.len()).map(|column| {
            let rows = self.rows.iter().zip(&self.residuals);
            -rows
                .map(|(row, residual)| row[column] * residual)
                .sum::<f64>()
        });
        let slope: Vec<f64> = slope.collect();
        self.eigen
            .apply(|value| 1.0 / (value.max(0.0) + damping), &slope)
    }

    /// Returns the places after a step of the free coordinates.
    fn moved(&self, step: &[f64]) -> Vec<DVec3> {
        let places = self.places.iter().enumerate();
        let places = places.map(|(number, &place)| place + self.part(number, step));
        places.collect()
    }

    /// Returns the part of a vector of free coordinates that belongs to a corner.
    fn part(&self, corner: usize, vector: &[f64]) -> DVec3 {
        let axis =
            |axis: usize| self.columns[3 * corner + axis].map_or(0.0, |column| vector[column]);
        DVec3::new(axis(0), axis(1), axis(2))
    }

    /// Returns the standard deviation along the direction of all free coordinates that is known
    /// worst, metres, and how each corner moves along it.
    pub(super) fn loosest(&self) -> Option<(f64, Vec<DVec3>)> {
        let values = self.eigen.values.iter().zip(&self.eigen.vectors);
        let (value, vector) = values.min_by(|a, b| a.0.total_cmp(b.0))?;
        let corners = 0..self.places.len();
        let moves = corners.map(|corner| self.part(corner, vector)).collect();
        Some((1.0 / value.max(f64::MIN_POSITIVE).sqrt(), moves))
    }

    /// Returns a corner's standard deviation, metres.
    pub(super) fn sigma(&self, corner: usize) -> f64 {
        let values = self.eigen.values.iter().zip(&self.eigen.vectors);
        let variances = values.map(|(value, own)| self.part(corner, own).length_squared() / value);
        (variances.sum::<f64>() / 3.0).sqrt()
    }

    /// Returns the matrix that makes residuals of errors, both by their standard deviations.
    pub(super) fn propagation(&self) -> Vec<Vec<f64>> {
        let rows = self.rows.iter().enumerate().map(|(number, row)| {
            let solved = self.eigen.apply(|value| 1.0 / value, row);
            let other = self.rows.iter().enumerate();
            let other =
                other.map(|(i, other)| f64::from(u8::from(i == number)) - dot(&solved, other));
            other.collect()
        });
        rows.collect()
    }
}

impl Quantity {
    /// Returns the value of the quantity where corners are at `places`, metres.
    fn value(self, places: &[DVec3]) -> f64 {
        match self {
            Self::Length([a, b]) => places[a].distance(places[b]),
            Self::Height([from, to]) => places[to].y - places[from].y,
            Self::Flatness(corners) => {
                let [a, b, c, d] = corners.map(|corner| places[corner]);
                (b - a).cross(d - a).normalize_or_zero().dot(c - a)
            }
        }
    }

    /// Returns the derivatives of the value by the places of corners.
    fn gradient(self, places: &[DVec3]) -> Vec<(usize, DVec3)> {
        match self {
            Self::Length([a, b]) => {
                let along = (places[b] - places[a]).normalize_or_zero();
                vec![(a, -along), (b, along)]
            }
            Self::Height([from, to]) => vec![(from, -DVec3::Y), (to, DVec3::Y)],
            Self::Flatness(corners) => {
                let [a, b, c, d] = corners.map(|corner| places[corner]);
                let (across, upward, third) = (b - a, d - a, c - a);
                let normal = across.cross(upward);
                let area = normal.length_squared();
                // Where the third corner is in the plane, as parts of the two edges.
                let s = third.cross(upward).dot(normal) / area;
                let t = across.cross(third).dot(normal) / area;
                let normal = normal.normalize_or_zero();
                let parts = [s + t - 1.0, -s, 1.0, -t];
                let both = corners.into_iter().zip(parts);
                both.map(|(corner, part)| (corner, part * normal)).collect()
            }
        }
    }
}
