//! The qualities of frames: the detail that each leaves out to be in time.

use crate::render::{Foveation, Observer};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shisen_core::frame::{LevelOfDetail, MAX_DEPTH};
use shisen_core::gaze::{VisualField, VisualFieldLimits};

/// The quality of a frame. It keeps the equations of the level of detail: only their constants
/// are smaller, and equation 10 is cut off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quality {
    /// The most bounces at level 1: the paper's Reflect max (eq. 9).
    pub depth: u8,
    /// The level, 0 to 1, at which the number of a mesh's faces (eq. 10) is cut off.
    pub faces: f32,
    /// The reach of the visual field beyond its centre as a part of the full reach, above 0 to
    /// 1.
    pub field: f32,
    /// The radius of the centre of the field, where everything is in full, as a part of the
    /// full radius, above 0 to 1; 5° around the line of sight always stay inside.
    pub centre: f32,
    /// The factor, 1 or more, by which detail beyond these 5° is larger than the eye sees it, on the
    /// slope of its acuity; from 6 on also within them. Only where the size of detail follows the
    /// gaze.
    pub sampling: f32,
    /// The part of a capture of the surroundings that a frame renews, above 0 to 1.
    pub capture: f32,
}

/// The radius around the line of sight that is never missing from a frame: radians (5°).
pub const FOVEA: f32 = 0.087_266_46;

/// The least radius of the central field, radians: eq. 7 as printed reaches 0.958 of it in full.
const LEAST_CENTRE: f32 = FOVEA / 0.95;

/// The sampling from which the fovea is coarser, too, rather than incomplete.
const LAST_RESORT: f32 = 6.0;

impl Quality {
    /// Leaves nothing out.
    pub const FULL: Self = Self {
        depth: MAX_DEPTH,
        faces: 1.0,
        field: 1.0,
        centre: 1.0,
        sampling: 1.0,
        capture: 1.0,
    };

    /// From the best to the least; what is noticed least goes first: bounces of bounces, faces,
    /// the rim of the field, the first bounce, and last the rim of the centre. Where the size of
    /// detail follows the gaze, the field stays whole and detail grows.
    pub const LADDER: [Self; 14] = {
        const fn rung(depth: u8, [faces, field, centre, sampling, capture]: [f32; 5]) -> Quality {
            Quality {
                depth,
                faces,
                field,
                centre,
                sampling,
                capture,
            }
        }
        [
            Self::FULL,
            rung(2, [1.0, 1.0, 1.0, 1.25, 0.5]),
            rung(1, [1.0, 1.0, 1.0, 1.5, 0.25]),
            rung(1, [0.5, 0.9, 1.0, 2.0, 0.25]),
            rung(1, [0.25, 0.75, 1.0, 3.0, 0.25]),
            rung(1, [0.25, 0.5, 0.8, 4.0, 0.125]),
            rung(0, [0.25, 0.5, 0.8, 4.0, 0.125]),
            rung(0, [0.1, 0.35, 0.7, 6.0, 0.0625]),
            rung(0, [0.0, 0.2, 0.6, 8.0, 0.0625]),
            rung(0, [0.0, 0.1, 0.45, 11.0, 0.03125]),
            rung(0, [0.0, 0.07, 0.37, 15.0, 0.03125]),
            rung(0, [0.0, 0.05, 0.3, 20.0, 0.03125]),
            rung(0, [0.0, 0.03, 0.23, 27.0, 0.03125]),
            rung(0, [0.0, 0.02, 0.18, 36.0, 0.03125]),
        ]
    };

    /// Narrows the field of a level of detail.
    #[must_use]
    pub fn narrow(&self, lod: LevelOfDetail) -> LevelOfDetail {
        if self.field >= 1.0 && self.centre >= 1.0 {
            return lod;
        }
        let field = lod.gaze.visual_field();
        let limits = self.narrowed(field.limits());
        // If rounding makes the limits equal to the centre's, the field stays.
        let field = VisualField::new(limits, field.boundary()).unwrap_or(field);
        let gaze = shisen_core::gaze::Gaze::new(lod.gaze.line_of_sight(), field);
        LevelOfDetail { gaze, ..lod }
    }

    /// Returns how much of a visual field is left, 0 to 1.
    pub fn field_left(&self, field: VisualField) -> f64 {
        let area = |of: VisualFieldLimits| f64::from((of.up + of.down) * (of.left + of.right));
        let limits = field.limits();
        area(self.narrowed(limits)) / area(limits)
    }

    fn narrowed(&self, limits: VisualFieldLimits) -> VisualFieldLimits {
        let central = (limits.central * self.centre).max(LEAST_CENTRE.min(limits.central));
        let less = |limit: f32| central + (limit - limits.central) * self.field;
        VisualFieldLimits {
            central,
            up: less(limits.up),
            down: less(limits.down),
            left: less(limits.left),
            right: less(limits.right),
        }
    }

    /// Returns the eccentricity beyond which detail is larger: radians.
    pub(super) const fn fine_within(&self) -> f32 {
        if self.sampling < LAST_RESORT {
            FOVEA
        } else {
            0.0
        }
    }

    /// Lowers the detail that an eye sees.
    #[must_use]
    pub fn lower(&self, eye: Observer) -> Observer {
        Observer {
            lod: eye.lod.map(|lod| self.narrow(lod)),
            foveation: eye.foveation.map(|foveation| Foveation {
                acuity: foveation
                    .acuity
                    .steeper_beyond(self.sampling, self.fine_within()),
                ..foveation
            }),
            ..eye
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cave::Eye;
    use glam::{DVec3, Vec3};
    use shisen_core::gaze::{Acuity, Gaze, LineOfSight};

    #[test]
    fn each_rung_leaves_out_more_and_none_the_fovea() {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        let foveated = Observer::foveated(Eye::Left, DVec3::ZERO, (sight, Acuity::GUENTER), 0.0);
        let paper = Observer {
            lod: Some(lod),
            ..Observer::new(Eye::Left, DVec3::ZERO)
        };
        assert_eq!(Quality::FULL.lower(foveated), foveated);
        assert_eq!(Quality::FULL.narrow(lod), lod);
        let mut better = Quality::FULL;
        for quality in Quality::LADDER {
            let (worse, sampling, centre) = (quality, quality.sampling, quality.centre);
            assert!(worse.depth <= better.depth && worse.faces <= better.faces);
            assert!(worse.field <= better.field && centre <= better.centre);
            assert!(sampling >= better.sampling && worse.capture <= better.capture);
            better = quality;
            // Sampling is coarser only where it follows the gaze.
            let lowered = quality.lower(paper);
            let narrow = Some(quality.narrow(lod));
            assert_eq!((lowered.foveation, lowered.lod), (None, narrow));
            let acuity = quality.lower(foveated).foveation.unwrap().acuity;
            for e in [0.0, 0.5 * FOVEA, FOVEA] {
                let coarser = acuity.least_angle(e) > Acuity::GUENTER.least_angle(e);
                assert_eq!(coarser, e > 0.0 && sampling >= LAST_RESORT);
            }
            // The centre must be whole all around: by the printed equation it is not a circle.
            let level = |degrees: f32, around: f32| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let direction = Vec3::new(sin * around.cos(), sin * around.sin(), -cos);
                let narrow = quality.narrow(lod).gaze.level(direction);
                narrow.unwrap_or(0.0)
            };
            let inner = (0.95 * 30.0 * centre).max(FOVEA.to_degrees());
            for around in 0..72 {
                let around = (5.0 * around as f32).to_radians();
                for part in 0..=20 {
                    let degrees = inner * part as f32 / 20.0;
                    assert_eq!(level(degrees, around), 1.0, "{quality:?}");
                }
            }
            // At the side the field ends at 100°, or that much nearer.
            let end = (30.0 * centre).max(LEAST_CENTRE.to_degrees()) + 70.0 * quality.field;
            let ends = (level(end - 0.1, 0.0) > 0.0, level(end + 0.1, 0.0));
            assert_eq!(ends, (true, 0.0), "{quality:?}");
            let left = quality.field_left(VisualField::PAPER);
            let bounds = quality.field.powi(2)..=quality.field.sqrt();
            assert!(bounds.contains(&(left as f32)), "{quality:?}: {left}");
        }
    }
}
