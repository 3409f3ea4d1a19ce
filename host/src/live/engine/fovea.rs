//! Tiles near the line of sight.

use crate::live::quality::FOVEA;
use glam::Vec3;
use shisen_core::frame::{Tile, View};

/// The most that a line of sight moves a frame on the same place: radians (1°).
pub(super) const SAME_PLACE: f32 = 0.017_453_292;

const ROUNDING: f32 = 1.0e-3;

/// Returns the cosine of the angle between the line of sight and a tile's centre.
pub(super) fn towards(sight: Option<Vec3>, view: &View, tile: Tile) -> f32 {
    let Some(sight) = sight else {
        return 1.0;
    };
    let (x, y) = (
        tile.x as f32 + 0.5 * (tile.width - 1) as f32,
        tile.y as f32 + 0.5 * (tile.height - 1) as f32,
    );
    let towards = view.direction(x, y).map(Vec3::normalize_or_zero);
    towards.map_or(-2.0, |towards| towards.dot(sight))
}

/// Counts the first tiles up to the last that reaches into the [`FOVEA`].
pub(super) fn reaching_fovea<'t>(tiles: impl Iterator<Item = (Vec3, &'t View, Tile)>) -> usize {
    let (mut first, mut widest) = (0, 0.0_f32);
    for (number, (sight, view, tile)) in tiles.enumerate() {
        widest = widest.max(across(view, tile).unwrap_or(0.0));
        let corner = view.direction(tile.x as f32, tile.y as f32);
        // Twice the width of the tiles so far: others may be wider.
        let is_near = |corner: Vec3| corner.angle_between(sight) <= FOVEA + 2.0 * widest;
        if !corner.is_some_and(is_near) {
            break;
        }
        if is_foveal(Some(sight), view, tile) {
            first = number + 1;
        }
    }
    first
}

/// Returns the largest angle between two corners of a tile. `None` where a corner is off the
/// screen.
fn across(view: &View, tile: Tile) -> Option<f32> {
    let at = |x: u32, y: u32| view.direction((tile.x + x) as f32, (tile.y + y) as f32);
    let (right, bottom) = (tile.width - 1, tile.height - 1);
    let [a, b, c, d] = [at(0, 0)?, at(right, 0)?, at(0, bottom)?, at(right, bottom)?];
    let pairs = [(a, d), (b, c), (a, b), (c, d), (a, c), (b, d)];
    let angles = pairs.map(|(one, other)| one.angle_between(other));
    Some(angles.into_iter().fold(0.0, f32::max))
}

/// Returns whether a pixel of a tile is within [`FOVEA`] of the line of sight; true if the line of
/// sight is unknown.
pub(super) fn is_foveal(sight: Option<Vec3>, view: &View, tile: Tile) -> bool {
    let Some(forward) = sight else {
        return true;
    };
    let at = |x: u32, y: u32| view.direction((tile.x + x) as f32, (tile.y + y) as f32);
    // Most tiles are too far off.
    if let (Some(corner), Some(across)) = (at(0, 0), across(view, tile))
        && corner.angle_between(forward) > FOVEA + across + ROUNDING
    {
        return false;
    }
    (0..tile.height).any(|y| {
        (0..tile.width).any(|x| at(x, y).is_some_and(|direction| is_near(direction, forward)))
    })
}

/// Returns whether a direction of any length is within [`FOVEA`] of a line of sight of length 1.
fn is_near(direction: Vec3, forward: Vec3) -> bool {
    const SQUARE: f32 = 0.992_403_88;
    let along = direction.dot(forward);
    along > 0.0 && along * along >= SQUARE * direction.length_squared()
}
