//! A first guess of corners, from lengths alone.

use super::adjust::Adjusted;
use super::eigen::Eigen;
use super::{Quantity, RoomError, Survey, middle};
use glam::{DMat3, DVec3};

/// Returns the corners about where they are, the first wall's lower left one at the origin, its
/// lower edge along +X, and upright.
///
/// # Errors
/// Corners between which there are no lengths.
pub(super) fn first_guess(survey: &Survey) -> Result<Vec<DVec3>, RoomError> {
    let lengths = survey.measurements.iter();
    let lengths = lengths.filter(|one| matches!(one.quantity, Quantity::Length(_)));
    let lengths: Vec<_> = lengths.cloned().collect();
    let count = survey.corners.len();
    let mut squares = vec![vec![f64::INFINITY; count]; count];
    for one in &lengths {
        if let Quantity::Length([a, b]) = one.quantity {
            squares[a][b] = one.measured.powi(2);
            squares[b][a] = squares[a][b];
        }
    }
    // Rooms have right angles, more or less: squares of lengths that are missing are sums.
    for through in 0..count {
        squares[through][through] = 0.0;
        for a in 0..count {
            for b in 0..count {
                let around = squares[a][through] + squares[through][b];
                squares[a][b] = squares[a][b].min(around);
            }
        }
    }
    if let Some(apart) = squares[0].iter().position(|square| square.is_infinite()) {
        let [first, apart] = [0, apart].map(|corner| &survey.corners[corner].name);
        return Err(RoomError::new(
            "lengths_m",
            format!("corner {apart} is not tied down: no lengths lead from {first} to it"),
            "measure edges and diagonals between the two groups of corners",
        ));
    }
    let free: Vec<usize> = (0..3 * count).collect();
    let places = Adjusted::new(&lengths, scaled(&squares), &free).places;
    Ok(oriented(survey, places))
}

/// Returns places whose distances have about the given squares (classical scaling).
fn scaled(squares: &[Vec<f64>]) -> Vec<DVec3> {
    let count = squares.len() as f64;
    let means = squares.iter().map(|row| row.iter().sum::<f64>() / count);
    let means: Vec<f64> = means.collect();
    let mean = means.iter().sum::<f64>() / count;
    let products = squares.iter().zip(&means).map(|(row, own)| {
        let both = row.iter().zip(&means);
        both.map(|(square, other)| -0.5 * (square - own - other + mean))
            .collect()
    });
    let eigen = Eigen::new(products.collect());
    let mut order: Vec<usize> = (0..squares.len()).collect();
    order.sort_by(|&a, &b| eigen.values[b].total_cmp(&eigen.values[a]));
    let axis = |place: usize, number: usize| {
        let along = order[number];
        eigen.vectors[along][place] * eigen.values[along].max(0.0).sqrt()
    };
    let places = (0..squares.len()).map(|i| DVec3::new(axis(i, 0), axis(i, 1), axis(i, 2)));
    places.collect()
}

/// Turns places so that the first wall is upright and faces +Z, and mirrors them so that walls
/// face one another.
fn oriented(survey: &Survey, mut places: Vec<DVec3>) -> Vec<DVec3> {
    let whole = middle(places.iter().copied());
    let walls = survey.walls.iter();
    let walls = walls.map(|wall| facing(wall.corners.map(|corner| places[corner]), whole));
    if walls.sum::<f64>() < 0.0 {
        for place in &mut *places {
            place.z = -place.z;
        }
    }
    let [origin, right, _, above] = survey.walls[0].corners.map(|corner| places[corner]);
    let x = (right - origin).normalize_or(DVec3::X);
    let z = x.cross(above - origin).normalize_or(DVec3::Z);
    let room_from_here = DMat3::from_cols(x, z.cross(x), z).transpose();
    let turned = places.iter().map(|place| room_from_here * (place - origin));
    turned.collect()
}

/// Returns how far a place is before a wall of these corners.
pub(super) fn facing(corners: [DVec3; 4], place: DVec3) -> f64 {
    let [lower_left, lower_right, upper_right, upper_left] = corners;
    let normal = (upper_right - lower_left).cross(upper_left - lower_right);
    normal
        .normalize_or_zero()
        .dot(place - middle(corners.into_iter()))
}
