//! The plane of a wall and where its picture lies in it.

use super::{RoomError, Wall};
use glam::DVec3;

/// How far outside 0 to 1 a picture coordinate still counts as inside, so
/// that no ray slips through the seam of two walls.
const SEAM: f64 = 1e-9;

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
    pub(crate) fn new(wall: &Wall) -> Result<Self, RoomError> {
        wall.check_corners()?;
        let right = wall.lower_right - wall.lower_left;
        let down = wall.lower_left - wall.upper_left;
        // From directions and not edges, so that small walls are walls too.
        let normal = right.normalize().cross(down.normalize());
        Ok(Self {
            upper_left: wall.upper_left,
            right,
            down,
            normal: normal.normalize(),
        })
    }

    /// Lower left, lower right, upper right, upper left: against the clock as the viewer sees them.
    pub(crate) fn corners(&self) -> [DVec3; 4] {
        let lower_left = self.upper_left + self.down;
        [
            lower_left,
            lower_left + self.right,
            self.upper_left + self.right,
            self.upper_left,
        ]
    }

    /// Returns where a ray meets the wall: the ray's parameter, above 0, and the
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
