//! Where a viewer has flown: the room is moved through its scene, and stays level.

use crate::render::{Foveation, Observer};
use crate::tracker::{Flight, Steering};
use glam::{DVec3, Vec3};
use shisen_core::frame::{LevelOfDetail, View};
use shisen_core::gaze::{Gaze, HeadPose, LineOfSight};

/// Where a room is in its scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomPlace {
    /// The room's origin in the scene: metres.
    pub position: DVec3,
    /// The room's turn about +Y, above 0 to the left: radians.
    pub yaw: f64,
}

impl RoomPlace {
    /// The room and its scene have the same axes.
    pub const START: Self = Self {
        position: DVec3::ZERO,
        yaw: 0.0,
    };

    /// The largest coordinate to which the viewer flies, metres.
    pub const FARTHEST: f64 = 10_000.0;

    fn turned(&self, v: DVec3) -> DVec3 {
        let (sin, cos) = libm::sincos(self.yaw);
        DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x)
    }

    /// Returns where a point of the room is in the scene.
    #[must_use]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.turned(point) + self.position
    }

    /// Returns rays of the room in the scene.
    pub(super) fn view(&self, view: &View) -> View {
        if *self == Self::START {
            return *view;
        }
        let (sin, cos) = libm::sincos(self.yaw);
        view.moved([sin as f32, cos as f32], self.position.as_vec3())
    }

    /// Returns an eye of the room in the scene.
    pub(super) fn observer(&self, observer: &Observer) -> Observer {
        if *self == Self::START {
            return *observer;
        }
        let turned = |v: Vec3| self.turned(v.as_dvec3()).as_vec3();
        let sight = |sight: LineOfSight| {
            let place = self.point(sight.position().as_dvec3()).as_vec3();
            let moved = LineOfSight::new(place, turned(sight.forward()), turned(sight.up()));
            // Turned unit vectors at right angles are a line of sight.
            moved.unwrap_or(sight)
        };
        Observer {
            eye: observer.eye,
            place: self.point(observer.place),
            lod: observer.lod.map(|lod| LevelOfDetail {
                gaze: Gaze::new(sight(lod.gaze.line_of_sight()), lod.gaze.visual_field()),
                ..lod
            }),
            foveation: observer.foveation.map(|foveation| Foveation {
                sight: sight(foveation.sight),
                ..foveation
            }),
            ahead: observer.ahead.map(turned),
        }
    }

    /// Returns where the room is after a viewer steered for some seconds: forwards along the wand,
    /// or along the head where the wand does not tell, and turned about the head.
    #[must_use]
    pub(super) fn flown(
        self,
        flight: &Flight,
        steering: &Steering,
        head: &HeadPose,
        seconds: f64,
    ) -> Self {
        if steering.is_homeward {
            return Self::START;
        }
        if steering.is_still() {
            return self;
        }
        let along = steering.pointing.unwrap_or(head.orientation * Vec3::NEG_Z);
        let head = head.position.as_dvec3();
        let before = self.point(head);
        let turn = -f64::from(steering.turn) * flight.turn * seconds;
        let turned = Self {
            yaw: (self.yaw + turn) % std::f64::consts::TAU,
            position: DVec3::ZERO,
        };
        let way = turned.turned(along.as_dvec3()) * f64::from(steering.forward)
            + DVec3::Y * f64::from(steering.rise);
        let position = before + way * flight.speed * seconds - turned.point(head);
        let next = Self {
            position: position.clamp(DVec3::splat(-Self::FARTHEST), DVec3::splat(Self::FARTHEST)),
            ..turned
        };
        if next.position.is_finite() && next.yaw.is_finite() {
            next
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn a_viewer_turns_about_the_head_and_flies_along_the_wand() {
        let flight = Flight {
            speed: 3.0,
            turn: std::f64::consts::FRAC_PI_2,
        };
        let head = HeadPose {
            position: Vec3::new(0.5, 1.7, -0.25),
            orientation: Quat::from_rotation_y(-FRAC_PI_2),
        };
        let [place, eye] = [RoomPlace::START, RoomPlace::START].map(|place| {
            let steering = Steering {
                turn: 1.0,
                ..Steering::default()
            };
            place.flown(&flight, &steering, &head, 1.0)
        });
        let same = |a: DVec3, b: [f64; 3]| a.distance(DVec3::from_array(b)) < 1.0e-6;
        // What was in front is to the left now; the head stays where it was.
        assert!(same(place.turned(DVec3::NEG_Z), [1.0, 0.0, 0.0]));
        assert!(same(eye.point(head.position.as_dvec3()), [0.5, 1.7, -0.25]));
        let mut steering = Steering {
            forward: 0.5,
            ..Steering::default()
        };
        // Along the head, which looks to the room's right.
        let next = place.flown(&flight, &steering, &head, 2.0);
        assert!(same(next.position - place.position, [0.0, 0.0, 3.0]));
        steering.pointing = Some(Vec3::Y);
        let next = place.flown(&flight, &steering, &head, 2.0);
        assert!(same(next.position - place.position, [0.0, 3.0, 0.0]));
        let end = next.flown(&flight, &steering, &head, 1.0e9);
        assert_eq!(end.position.y, RoomPlace::FARTHEST);
        assert_eq!(end.flown(&flight, &steering, &head, f64::NAN), end);
        steering.is_homeward = true;
        let home = end.flown(&flight, &steering, &head, 1.0);
        assert_eq!(home, RoomPlace::START);
    }
}
