//! What is near the line of sight.

use crate::live::quality::FOVEA;
use glam::Vec3;
use shisen_core::frame::{Tile, View};

/// By how much a line of sight moves at most, from frame to frame, for a viewer to look at
/// the same: radians (1°). In between eyes are fast.
pub(super) const SETTLED: f32 = 0.017_453_292;

/// What angles may be off by: radians.
const ROUNDING: f32 = 1.0e-3;

/// Of the angle between the line of sight and a tile's centre.
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

/// Of tiles from the line of sight outwards, how many of the first reach as far as the
/// [`FOVEA`], or lie between those that do.
pub(super) fn reaching_fovea<'t>(tiles: impl Iterator<Item = (Vec3, &'t View, Tile)>) -> usize {
    let (mut first, mut widest) = (0, 0.0_f32);
    for (number, (sight, view, tile)) in tiles.enumerate() {
        widest = widest.max(across(view, tile).unwrap_or(0.0));
        let corner = view.direction(tile.x as f32, tile.y as f32);
        // Twice as far as one like those before reaches: others may be wider.
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

/// The angle that no two pixels of a tile of a screen are farther apart than: the most
/// between two of its corners. `None` where a corner is on no screen.
fn across(view: &View, tile: Tile) -> Option<f32> {
    let at = |x: u32, y: u32| view.direction((tile.x + x) as f32, (tile.y + y) as f32);
    let (right, bottom) = (tile.width - 1, tile.height - 1);
    let [a, b, c, d] = [at(0, 0)?, at(right, 0)?, at(0, bottom)?, at(right, bottom)?];
    let diagonals = a.angle_between(d).max(b.angle_between(c));
    let rows = a.angle_between(b).max(c.angle_between(d));
    Some(
        diagonals
            .max(rows)
            .max(a.angle_between(c))
            .max(b.angle_between(d)),
    )
}

/// Whether a pixel of a tile is within [`FOVEA`] of the line of sight. Where nobody
/// knows that, all are; a session whose gaze is lost has the head's direction.
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

/// Whether a direction of any length is within [`FOVEA`] of a line of sight, which has
/// length 1.
fn is_near(direction: Vec3, forward: Vec3) -> bool {
    /// The square of the angle's cosine.
    const SQUARE: f32 = 0.992_403_88;
    let along = direction.dot(forward);
    along > 0.0 && along * along >= SQUARE * direction.length_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cave::{BuiltInCave, Cave, Eye};
    use crate::render::{self, Observer};

    #[test]
    fn near_is_within_five_degrees() {
        let sight = Vec3::new(0.6, 0.0, -0.8);
        for turn in 0..360 {
            let about = glam::Quat::from_axis_angle(sight, turn as f32);
            let at = |angle: f32| about * (glam::Quat::from_rotation_y(angle) * sight) * 7.0;
            assert!(is_near(at(FOVEA - 1.0e-4), sight), "{turn}");
            assert!(!is_near(at(FOVEA + 1.0e-4), sight), "{turn}");
        }
        assert!(!is_near(-sight, sight) && is_near(sight, sight));
    }

    #[test]
    fn what_is_near_the_line_of_sight_is_found_without_looking_at_every_pixel() {
        let cave = Cave::built_in(BuiltInCave::Cube, [48; 2]).expect("a room");
        let observer = Observer::new(Eye::Left, glam::DVec3::new(0.4, 0.2, -0.7));
        let (mut near, mut all) = (0, 0);
        for screen in cave.screens() {
            let view = render::view(screen, &observer).expect("it sees the screen");
            for tile in [5, 16]
                .into_iter()
                .flat_map(|side| render::tiles(&view, side))
            {
                for number in 0..40 {
                    let angle = 0.7 * number as f32;
                    let height = number as f32 / 20.0 - 1.0;
                    let sight = Vec3::new(angle.cos(), height, angle.sin()).normalize();
                    let is_near = |x: u32, y: u32| {
                        let towards = view.direction(x as f32, y as f32);
                        towards.is_some_and(|towards| is_near(towards, sight))
                    };
                    let columns = tile.x..tile.x + tile.width;
                    let expected = columns
                        .flat_map(|x| (tile.y..tile.y + tile.height).map(move |y| (x, y)))
                        .any(|(x, y)| is_near(x, y));
                    assert_eq!(is_foveal(Some(sight), &view, tile), expected, "{tile:?}");
                    near += u32::from(expected);
                    all += 1;
                }
            }
        }
        assert!(near > 200 && all > 20 * near, "{near} of {all}");
    }
}
