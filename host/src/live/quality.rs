//! What a frame may leave out to be in time.

use shisen_core::frame::{LevelOfDetail, MAX_DEPTH};
use shisen_core::gaze::{VisualField, VisualFieldLimits};

/// How good a frame is made. The equations of the level of detail stay as they
/// are: only their constants are smaller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Bounces of level 1 at most: the paper's `Reflect_max` (eq. 9).
    pub depth: u8,
    /// No more faces of a mesh than this level has: the paper's `N_max` (eq. 10).
    pub faces: f32,
    /// How far the visual field reaches beyond its centre, as a part of how far it
    /// does as it is: above 0, at most 1.
    pub field: f32,
}

impl Quality {
    /// Nothing is left out.
    pub const FULL: Self = Self {
        depth: MAX_DEPTH,
        faces: 1.0,
        field: 1.0,
    };

    /// From the best to the least: what is noticed least goes first. Bounces of
    /// bounces, then faces, then the rim of the field, then the first bounce.
    pub const LADDER: [Self; 8] = {
        const fn of(depth: u8, faces: f32, field: f32) -> Quality {
            Quality {
                depth,
                faces,
                field,
            }
        }
        [
            Self::FULL,
            of(2, 1.0, 1.0),
            of(1, 1.0, 1.0),
            of(1, 0.5, 0.9),
            of(1, 0.25, 0.75),
            of(0, 0.25, 0.6),
            of(0, 0.1, 0.4),
            of(0, 0.0, 0.1),
        ]
    };

    /// A level of detail whose field reaches as far as this says.
    #[must_use]
    pub fn narrow(&self, lod: LevelOfDetail) -> LevelOfDetail {
        if self.field >= 1.0 {
            return lod;
        }
        let field = lod.gaze.visual_field();
        let limits = field.limits();
        let central = limits.central;
        let less = |limit: f32| central + (limit - central) * self.field;
        let limits = VisualFieldLimits {
            central,
            up: less(limits.up),
            down: less(limits.down),
            left: less(limits.left),
            right: less(limits.right),
        };
        // Limits that rounding makes equal to the centre's leave the field as it is.
        let field = VisualField::new(limits, field.boundary()).unwrap_or(field);
        let gaze = shisen_core::gaze::Gaze::new(lod.gaze.line_of_sight(), field);
        LevelOfDetail { gaze, ..lod }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use shisen_core::gaze::{Gaze, LineOfSight};

    #[test]
    fn rungs_leave_out_more_and_more() {
        for pair in Quality::LADDER.windows(2) {
            let [better, worse] = pair else {
                unreachable!()
            };
            assert!(worse.depth <= better.depth);
            assert!(worse.faces <= better.faces);
            assert!(worse.field <= better.field);
            assert_ne!(worse, better);
        }
        assert_eq!(Quality::LADDER[0], Quality::FULL);
    }

    #[test]
    fn the_centre_of_the_field_stays() {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        assert_eq!(Quality::FULL.narrow(lod), lod);
        for quality in Quality::LADDER {
            let narrow = quality.narrow(lod);
            for degrees in 0..30 {
                let angle = (degrees as f32).to_radians();
                let direction = Vec3::new(angle.sin(), 0.0, -angle.cos());
                assert_eq!(narrow.gaze.level(direction), Some(1.0));
            }
            // At the side the field ends at 100°, or that much nearer.
            let end = 30.0 + 70.0 * quality.field;
            let at = |degrees: f32| {
                let angle = degrees.to_radians();
                let direction = Vec3::new(angle.sin(), 0.0, -angle.cos());
                narrow.gaze.level(direction).unwrap_or(0.0)
            };
            assert!(at(end - 0.1) > 0.0 && at(end + 0.1) == 0.0, "{quality:?}");
        }
    }
}
