//! Where the head is, and will be.

use super::trend::{History, seconds, steady_velocity};
use crate::rotation::{compose, from_vector, inverse, rotate, to_vector, unit};
use crate::time::Micros;
use glam::{Quat, Vec3};
use shisen_core::gaze::HeadPose;

/// How the head's movement is continued.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadConfig {
    /// Over how long its velocity is taken: 10 to 500 ms.
    pub window: Micros,
    /// The longest continuation, after which the head rests: up to 200 ms.
    pub horizon: Micros,
    /// Slower turns count as rest, radians per second; 0.001 to 1.
    pub least_turn: f32,
    /// Slower movements count as rest, metres per second; 0.001 to 1.
    pub least_speed: f32,
}

impl Default for HeadConfig {
    /// 40 ms, continued by 60 ms, from 1°/s and 10 mm/s on.
    fn default() -> Self {
        Self {
            window: Micros(40_000),
            horizon: Micros(60_000),
            least_turn: 0.017_45,
            least_speed: 0.01,
        }
    }
}

/// The newest poses in the room.
#[derive(Debug, Clone)]
pub(super) struct HeadTrack<const N: usize> {
    config: HeadConfig,
    resting: HeadPose,
    positions: History<Vec3, N>,
    /// The turn since the head was first seen: rotation vectors in the room, radians.
    turns: History<Vec3, N>,
    /// The newest.
    orientation: Quat,
    /// The newest of an earlier time, and how far it had turned then.
    earlier: Option<(Quat, Vec3)>,
    velocity: Vec3,
    /// The turn of the newest orientation, radians per second in the room.
    turn: Vec3,
}

/// Turns beyond this, radians, are counted anew: below, f32 keeps half a microradian.
const MOST_TURNED: f32 = 8.0;

impl<const N: usize> HeadTrack<N> {
    // Inlined: builds the state in its place, without a copy on the stack.
    #[inline(always)]
    pub(super) fn new(config: HeadConfig, resting: HeadPose) -> Self {
        Self {
            config,
            resting,
            positions: History::new(),
            turns: History::new(),
            orientation: Quat::IDENTITY,
            earlier: None,
            velocity: Vec3::ZERO,
            turn: Vec3::ZERO,
        }
    }

    /// False where the time is before the last one; at the same time the later call counts.
    pub(super) fn push_position(&mut self, time: Micros, position: Vec3) -> bool {
        let newer = self.positions.newest().is_none_or(|(last, _)| time >= last);
        if newer {
            self.positions.push(time, position);
            let window = self.config.window;
            let newest_first = self.positions.newest_first();
            let within = newest_first.take_while(|(t, _)| time.since(*t) <= window);
            let places = self.positions.places(within.count(), position);
            self.velocity = steady_velocity(&places, self.config.least_speed);
        }
        newer
    }

    /// Likewise; `turn` is about the room's axes, where the device says it.
    pub(super) fn push_orientation(
        &mut self,
        time: Micros,
        orientation: Quat,
        turn: Option<Vec3>,
    ) -> bool {
        let newest = self.turns.newest();
        let newer = newest.is_none_or(|(last, _)| time >= last);
        if newer {
            if let Some((_, turned)) = newest.filter(|(last, _)| *last < time) {
                self.earlier = Some((self.orientation, turned));
            }
            let turned = self.earlier.map_or(Vec3::ZERO, |(earlier, turned)| {
                turned + to_vector(compose(orientation, inverse(earlier)))
            });
            self.turns.push(time, turned);
            self.orientation = orientation;
            self.turn = turn.unwrap_or_else(|| self.measured_turn(time, turned));
            // One who turns around and around comes to numbers too coarse.
            if turned.abs().max_element() > MOST_TURNED {
                self.turns.shift(-turned);
                self.earlier = self
                    .earlier
                    .map(|(earlier, before)| (earlier, before - turned));
            }
        }
        newer
    }

    /// Returns when the newest position was measured.
    pub(super) fn position_time(&self) -> Option<Micros> {
        self.positions.newest().map(|(time, _)| time)
    }

    /// Returns when the newest orientation was measured.
    pub(super) fn orientation_time(&self) -> Option<Micros> {
        self.turns.newest().map(|(time, _)| time)
    }

    /// Returns when the newest of both was measured.
    pub(super) fn newest(&self) -> Option<Micros> {
        self.position_time().max(self.orientation_time())
    }

    /// Returns how fast the head turned up to its newest orientation.
    fn measured_turn(&self, newest: Micros, turned: Vec3) -> Vec3 {
        let window = self.config.window;
        let newest_first = self.turns.newest_first();
        let within = newest_first.take_while(|(t, _)| newest.since(*t) <= window);
        let places = self.turns.places(within.count(), turned);
        steady_velocity(&places, self.config.least_turn)
    }

    /// Returns the pose at a time: between those around it, or by constant velocity from the newest.
    pub(super) fn at(&self, time: Micros) -> HeadPose {
        let most = self.config.horizon.seconds();
        let mut pose = self.resting;
        if let Some((newest, position)) = self.positions.newest() {
            let ahead = seconds(newest, time).min(most);
            pose.position = match self.positions.before(time) {
                Some(before) if ahead < 0.0 => before,
                _ => position + self.velocity * ahead,
            };
        }
        if let Some((newest, turned)) = self.turns.newest() {
            let ahead = seconds(newest, time).min(most);
            let turn = match self.turns.before(time) {
                Some(before) if ahead < 0.0 => before - turned,
                _ => self.turn * ahead,
            };
            let turned = compose(from_vector(turn), self.orientation);
            pose.orientation = unit(turned).unwrap_or(self.orientation);
        }
        pose
    }
}

/// Returns the way that a head faces.
pub(super) fn forward(pose: &HeadPose) -> Vec3 {
    rotate(pose.orientation, Vec3::NEG_Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_velocity_up_to_the_horizon() {
        let mut head = HeadTrack::<64>::new(HeadConfig::default(), HeadPose::IDENTITY);
        assert_eq!(
            (head.position_time(), head.orientation_time()),
            (None, None)
        );
        assert_eq!(head.at(Micros(5)), HeadPose::IDENTITY);
        // 0.5 m/s and 1 rad/s.
        for i in 0..50u64 {
            let t = i as f32 * 0.0025;
            let time = Micros(1_000_000 + i * 2_500);
            assert!(head.push_position(time, Vec3::X * 0.5 * t));
            assert!(head.push_orientation(time, from_vector(Vec3::Y * t), None));
        }
        let last = 49.0 * 0.0025;
        let newest = Micros(1_122_500);
        assert_eq!(head.position_time(), Some(newest));
        assert_eq!(head.orientation_time(), Some(newest));
        assert!(!head.push_position(Micros(1_122_499), Vec3::ONE));
        // The later of two at one time counts.
        let place = head.at(newest).position;
        assert!(head.push_position(newest, Vec3::ONE));
        assert_eq!(head.at(newest).position, Vec3::ONE);
        assert!(head.push_position(newest, place));
        for (ahead, counted) in [(20_000, 0.02), (60_000, 0.06), (900_000, 0.06)] {
            let pose = head.at(newest.after(Micros(ahead)));
            assert!((pose.position.x - 0.5 * (last + counted)).abs() < 1e-4);
            let turned = to_vector(pose.orientation).y;
            assert!((turned - (last + counted)).abs() < 1e-4, "{turned}");
        }
        // Earlier times have the poses that were measured around them.
        head.push_orientation(Micros(1_123_500), from_vector(Vec3::Y * last), None);
        let half = head.at(Micros(1_121_250));
        assert!((half.position.x - 0.5 * 48.5 * 0.0025).abs() < 1e-5);
        let turned = to_vector(half.orientation).y;
        assert!((turned - 48.5 * 0.0025).abs() < 1e-4, "{turned}");
        assert!((head.at(Micros(0)).position).length() < 1e-6);
        // What the device says about the turn counts.
        let time = Micros(1_125_000);
        head.push_orientation(time, Quat::IDENTITY, Some(Vec3::Z));
        let pose = head.at(time.after(Micros(10_000)));
        assert!((to_vector(pose.orientation) - Vec3::Z * 0.01).length() < 1e-6);
    }

    #[test]
    fn one_who_turns_for_long_is_followed_as_at_first() {
        let mut head = HeadTrack::<64>::new(HeadConfig::default(), HeadPose::IDENTITY);
        // Two hundred times around, at half a turn per second, and back from one
        // to the next two at one time.
        let speed = core::f64::consts::PI;
        let mut worst = 0.0f32;
        let count: u64 = if cfg!(miri) { 200 } else { 100_000 };
        for i in 0..count {
            let half = 0.5 * speed * i as f64 * 0.004;
            let (sin, cos) = (half.sin() as f32, half.cos() as f32);
            let time = Micros(i * 4_000);
            assert!(head.push_orientation(time, Quat::from_xyzw(0.1, 0.0, 0.0, 0.995), None));
            assert!(head.push_orientation(time, Quat::from_xyzw(0.0, sin, 0.0, cos), None));
            if i > 20 {
                worst = worst.max((head.turn - Vec3::Y * speed as f32).length());
            }
        }
        // A rounding of 1e-6 radians over 40 ms.
        assert!(worst < 3e-4, "{worst}");
    }
}
