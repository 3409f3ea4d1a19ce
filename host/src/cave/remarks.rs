//! What is unusual about a room, in sentences: skewed walls, gaps at seams; and the fields of view.

use super::{Cave, CylinderScreen, DomeScreen, Screen, Wall};
use glam::{DVec2, DVec3};

impl Wall {
    /// Returns the angle between the lower and the left edge, degrees: 90 for a rectangle.
    pub fn angle_degrees(&self) -> f64 {
        self.across().angle_between(self.upward()).to_degrees()
    }

    /// Returns lower left, lower right, upper right and upper left: metres, in the room.
    pub(crate) fn corners(&self) -> [DVec3; 4] {
        let upper_right = self.lower_right + self.upward();
        [
            self.lower_left,
            self.lower_right,
            upper_right,
            self.upper_left,
        ]
    }

    pub(crate) fn normal(&self) -> DVec3 {
        self.across()
            .normalize()
            .cross(self.upward().normalize())
            .normalize()
    }

    fn middle(&self) -> DVec3 {
        self.lower_left + 0.5 * (self.across() + self.upward())
    }

    fn field_from(&self, eye: DVec3) -> Option<[f64; 2]> {
        let from = self.lower_left - eye;
        let distance = -from.dot(self.normal());
        (distance > Self::CLOSEST).then(|| {
            [self.across(), self.upward()].map(|edge| {
                let start = from.dot(edge.normalize());
                let angle = |along: f64| along.atan2(distance);
                (angle(start + edge.length()) - angle(start)).to_degrees()
            })
        })
    }
}

impl DomeScreen {
    fn field_from(&self, eye: DVec3) -> Option<[f64; 2]> {
        let seen = |u, v| self.point(DVec2::new(u, v)) - eye;
        let over = |one: DVec3, other: DVec3| {
            let zenith = seen(0.0, 0.0);
            (one.angle_between(zenith) + zenith.angle_between(other)).to_degrees()
        };
        self.view_from(eye).is_ok().then(|| {
            [
                over(seen(-1.0, 0.0), seen(1.0, 0.0)),
                over(seen(0.0, -1.0), seen(0.0, 1.0)),
            ]
        })
    }
}

impl CylinderScreen {
    fn field_from(&self, eye: DVec3) -> Option<[f64; 2]> {
        let seen = |s, t| self.point(DVec2::new(s, t)) - eye;
        let [left, middle, right] =
            [0.0, 0.5, 1.0].map(|s| seen(s, 0.5) * DVec3::new(1.0, 0.0, 1.0));
        self.view_from(eye).is_ok().then(|| {
            [
                (left.angle_between(middle) + middle.angle_between(right)).to_degrees(),
                seen(0.5, 0.0).angle_between(seen(0.5, 1.0)).to_degrees(),
            ]
        })
    }
}

impl Screen<'_> {
    /// Returns the angles that the screen fills as seen from `eye` (metres, in the room), degrees:
    /// between the left and right edges, and between the lower and upper ones; over the zenith of a
    /// dome, in the middle of a cylinder. `None` where the eye does not see its front.
    pub fn field_from(self, eye: DVec3) -> Option<[f64; 2]> {
        match self {
            Self::Wall(wall) => wall.field_from(eye),
            Self::Dome(dome) => dome.field_from(eye),
            Self::Cylinder(cylinder) => cylinder.field_from(eye),
        }
    }
}

impl Cave {
    /// Shares of the shorter of two edges up to which they count as neighbours: how far apart they
    /// are, and how much of the shorter one has to lie along the other.
    const NEIGHBOURS: [f64; 2] = [0.1, 0.5];
    /// Largest difference of a rectangle's angle from 90°, degrees.
    const SQUARE: f64 = 0.1;
    /// Smallest gap at a seam that is worth a remark, metres.
    const GAP: f64 = 0.001;

    /// Returns a sentence about the walls that are not rectangles, if there are any.
    pub fn skewed(&self) -> Option<String> {
        let walls = self
            .walls
            .iter()
            .map(|wall| (&wall.name, wall.angle_degrees()));
        let skewed = walls.filter(|(_, angle)| (angle - 90.0).abs() > Self::SQUARE);
        let named: Vec<String> = skewed
            .map(|(name, angle)| format!("\"{name}\" ({angle:.2}°)"))
            .collect();
        (!named.is_empty()).then(|| {
            format!(
                "not at right angles, and therefore shown as parallelograms: {}; where a wall is \
                 a rectangle, correct its upper_left",
                named.join(", ")
            )
        })
    }

    /// Returns a sentence about each seam at which walls leave a gap or overlap.
    pub fn open_seams(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        for (number, one) in self.walls.iter().enumerate() {
            for other in &self.walls[number + 1..] {
                let seams = edges(one).into_iter().flat_map(|edge| {
                    let others = edges(other).into_iter();
                    others.filter_map(move |other_edge| gap(edge, one, other_edge, other))
                });
                let Some(gap) = seams.min_by(|a, b| a.abs().total_cmp(&b.abs())) else {
                    continue;
                };
                if gap.abs() > Self::GAP {
                    let (what, size) = match gap {
                        0.0.. => ("leave a gap of", gap),
                        _ => ("overlap by", -gap),
                    };
                    let (one, other) = (&one.name, &other.name);
                    remarks.push(format!(
                        "walls \"{one}\" and \"{other}\" {what} up to {:.1} mm at their seam",
                        1000.0 * size
                    ));
                }
            }
        }
        remarks
    }
}

/// Returns the edges of a wall, each from corner to corner.
fn edges(wall: &Wall) -> [[DVec3; 2]; 4] {
    let corners = wall.corners();
    [0, 1, 2, 3].map(|i| [corners[i], corners[(i + 1) % 4]])
}

/// Returns the greatest distance of two edges along the part that they share: negative where the
/// walls overlap. `None` where the edges are no neighbours.
fn gap(edge: [DVec3; 2], wall: &Wall, other: [DVec3; 2], other_wall: &Wall) -> Option<f64> {
    let is_shorter = edge[0].distance(edge[1]) < other[0].distance(other[1]);
    let (short, long) = if is_shorter {
        (edge, other)
    } else {
        (other, edge)
    };
    let along = (long[1] - long[0]).normalize();
    let length = long[0].distance(long[1]);
    let places = short.map(|end| (end - long[0]).dot(along));
    let parts = places.map(|place| place.clamp(0.0, length));
    let size = short[0].distance(short[1]);
    let [apart, shared] = Cave::NEIGHBOURS;
    if (parts[1] - parts[0]).abs() < shared * size {
        return None;
    }
    // From the long edge to the short one, at both ends of the part that they share.
    let offsets = parts.map(|part| {
        let share = (part - places[0]) / (places[1] - places[0]);
        short[0].lerp(short[1], share) - (long[0] + part * along)
    });
    let farthest = offsets.map(DVec3::length).into_iter().fold(0.0, f64::max);
    if farthest > apart * size {
        return None;
    }
    let middles = [edge, other].map(|[from, to]| from.midpoint(to));
    let outwards = (middles[0] - wall.middle()).normalize_or_zero()
        - (middles[1] - other_wall.middle()).normalize_or_zero();
    let between = if short == edge { -1.0 } else { 1.0 } * (offsets[0] + offsets[1]);
    Some(if between.dot(outwards) < 0.0 {
        -farthest
    } else {
        farthest
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cave::BuiltInCave;

    #[test]
    fn skewed_walls_and_open_seams_are_named_with_their_sizes() {
        let cave = Cave::built_in(BuiltInCave::Cube, [4; 2]).unwrap();
        assert_eq!((cave.skewed(), cave.open_seams()), (None, Vec::new()));
        let [mut gap, mut overlap, mut skewed] = [cave.clone(), cave.clone(), cave];
        // The front wall ends 12 mm before the right one.
        gap.walls[0].lower_right.x -= 0.012;
        let remarks = gap.open_seams();
        assert!(remarks[0].contains("\"front\" and \"right\" leave a gap of up to 12.0 mm"));
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        // The floor reaches 5 mm behind the front wall's plane.
        overlap.walls[4].upper_left.z -= 0.005;
        let remarks = overlap.open_seams();
        assert!(remarks[0].contains("\"front\" and \"floor\" overlap by up to 5.0 mm"));
        assert_eq!(remarks.len(), 1, "{remarks:?}");
        skewed.walls[1].upper_left.z += 0.0053;
        assert_eq!(skewed.skewed(), None);
        skewed.walls[1].upper_left.z += 0.0947;
        let remark = skewed.skewed().unwrap();
        assert!(remark.contains("\"left\" (91.91°);"), "{remark}");
    }

    #[test]
    fn fields_of_view_are_angles_at_the_eye() {
        let cave = Cave::built_in(BuiltInCave::ThreeWall, [4; 2]).unwrap();
        let eye = DVec3::new(1.5 - 1e-3, 0.0, 0.0);
        let [across, upward] = cave.screens().next().unwrap().field_from(eye).unwrap();
        assert!((across - 63.4).abs() < 0.1 && (upward - 90.0).abs() < 1e-9);
        let behind = DVec3::new(0.0, 0.0, -2.0);
        assert_eq!(cave.screens().next().unwrap().field_from(behind), None);
        let dome = Cave::built_in(BuiltInCave::Dome, [4; 2]).unwrap();
        let field = dome
            .screens()
            .next()
            .unwrap()
            .field_from(dome.domes[0].centre);
        let [across, upward] = field.unwrap();
        assert!((across - 180.0).abs() < 1e-9 && (upward - 180.0).abs() < 1e-9);
    }
}
