//! The plane of a wall and where its picture lies in it.

use super::Wall;
use glam::DVec3;
use thiserror::Error;

/// How far outside 0 to 1 a picture coordinate still counts as inside, so
/// that no ray slips through the seam of two walls.
const SEAM: f64 = 1e-9;

/// A wall whose corners span no plane.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "wall {name:?} has no area: give it three corners with finite coordinates that are not on one \
     line"
)]
pub struct DegenerateWall {
    /// The wall's name.
    pub name: String,
}

/// The parallelogram that a wall's picture fills.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WallPlane {
    /// Metres, in the room.
    pub upper_left: DVec3,
    /// The upper edge, from left to right: metres.
    pub right: DVec3,
    /// The left edge, from top to bottom: metres.
    pub down: DVec3,
    /// Unit vector away from the viewer.
    normal: DVec3,
}

impl WallPlane {
    pub(crate) fn new(wall: &Wall) -> Result<Self, DegenerateWall> {
        let right = wall.lower_right - wall.lower_left;
        let down = wall.lower_left - wall.upper_left;
        // Of the directions, not the edges: small walls are walls too.
        let normal = right.normalize_or_zero().cross(down.normalize_or_zero());
        let lengths = [right.length(), down.length(), wall.upper_left.length()];
        if normal.length() > 1e-9 && lengths.iter().all(|length| length.is_finite()) {
            Ok(Self {
                upper_left: wall.upper_left,
                right,
                down,
                normal: normal.normalize(),
            })
        } else {
            Err(DegenerateWall {
                name: wall.name.clone(),
            })
        }
    }

    /// Lower left, lower right, upper right, upper left: against the clock as
    /// the viewer sees them.
    pub(crate) fn corners(&self) -> [DVec3; 4] {
        let lower_left = self.upper_left + self.down;
        [
            lower_left,
            lower_left + self.right,
            self.upper_left + self.right,
            self.upper_left,
        ]
    }

    /// Where a ray meets the wall: the ray's parameter, above 0, and the
    /// picture coordinates from the upper left corner, each 0 to 1.
    pub(crate) fn intersect(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
        let parameter = (self.upper_left - origin).dot(self.normal) / direction.dot(self.normal);
        if !(parameter.is_finite() && parameter > 0.0) {
            return None;
        }
        let point = origin + parameter * direction - self.upper_left;
        let area = self.right.cross(self.down).dot(self.normal);
        let x = point.cross(self.down).dot(self.normal) / area;
        let y = self.right.cross(point).dot(self.normal) / area;
        let inside = |coordinate: f64| (-SEAM..=1.0 + SEAM).contains(&coordinate);
        (inside(x) && inside(y)).then(|| (parameter, x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(lower_left: DVec3, lower_right: DVec3, upper_left: DVec3) -> Wall {
        Wall {
            name: "wall".to_owned(),
            lower_left,
            lower_right,
            upper_left,
            pixels: [1, 1],
        }
    }

    #[test]
    fn ray_is_met_at_its_picture_coordinates() {
        let front = wall(
            DVec3::new(-2.0, 0.0, -3.0),
            DVec3::new(2.0, 0.0, -3.0),
            DVec3::new(-2.0, 1.0, -3.0),
        );
        let plane = WallPlane::new(&front).unwrap();
        let met = |x, y| plane.intersect(DVec3::ZERO, DVec3::new(x, y, -3.0));
        assert_eq!(met(1.0, 0.75), Some((1.0, 0.75, 0.25)));
        assert_eq!(met(-2.0, 1.0), Some((1.0, 0.0, 0.0)));
        assert_eq!(met(2.001, 0.5), None);
        assert_eq!(met(0.0, -0.001), None);
        let behind = plane.intersect(DVec3::ZERO, DVec3::new(0.0, -0.5, 3.0));
        assert_eq!(behind, None);
        let along = plane.intersect(DVec3::ZERO, DVec3::X);
        assert_eq!(along, None);
    }

    #[test]
    fn walls_without_area_are_refused() {
        for wall in [
            wall(DVec3::ZERO, DVec3::ZERO, DVec3::Y),
            wall(DVec3::ZERO, DVec3::X, 2.0 * DVec3::X),
            wall(DVec3::ZERO, DVec3::X, DVec3::NAN),
            wall(DVec3::ZERO, DVec3::X, DVec3::Y * f64::INFINITY),
        ] {
            assert!(WallPlane::new(&wall).is_err(), "{wall:?}");
        }
        let micrometre = wall(DVec3::ZERO, DVec3::X * 1e-6, DVec3::Y * 1e-6);
        assert!(WallPlane::new(&micrometre).is_ok());
    }
}
