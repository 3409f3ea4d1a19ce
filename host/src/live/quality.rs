//! What a frame may leave out to be in time.

use crate::render::Observer;
use shisen_core::frame::{LevelOfDetail, MAX_DEPTH};
use shisen_core::gaze::{VisualField, VisualFieldLimits};

/// How good a frame is made. The equations of the level of detail stay as they
/// are: only their constants are smaller, and what equation 10 gives is cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Bounces of level 1 at most: the paper's `Reflect_max` (eq. 9).
    pub depth: u8,
    /// No more faces of a mesh than this level has: the paper's equation 10 goes on
    /// below, and is cut off there.
    pub faces: f32,
    /// How far the visual field reaches beyond its centre, as a part of how far it
    /// does as it is: above 0, at most 1.
    pub field: f32,
    /// How far the centre of the field reaches, in which everything is in full, as a
    /// part of how far it does as it is: above 0, at most 1, and never so near that
    /// the [`FOVEA`] is not in it.
    pub centre: f32,
    /// How much coarser the periphery is sampled than the eye sees, 1 or more: times
    /// the slope of its acuity, beyond the [`FOVEA`]; from 6 on within it, too:
    /// rather than that some of it is not there. Only where sampling follows the gaze at all.
    pub sampling: f32,
    /// The part of a capture of the surroundings that is taken anew in a frame, above 0,
    /// at most 1. Only where there is a capture.
    pub capture: f32,
}

/// The part of a frame that is never to be missing: this close to the line of
/// sight, radians (5°).
pub const FOVEA: f32 = 0.087_266_46;

/// The least radius of the central field: radians. By equation 7 as it is printed a
/// field of so much has all its detail to 0.958 of that at least.
const LEAST_CENTRE: f32 = FOVEA / 0.95;

/// The sampling from which on what is looked at is coarser, too: rather than that some of
/// it is not there.
const LAST_RESORT: f32 = 6.0;

impl Quality {
    /// Nothing is left out.
    pub const FULL: Self = Self {
        depth: MAX_DEPTH,
        faces: 1.0,
        field: 1.0,
        centre: 1.0,
        sampling: 1.0,
        capture: 1.0,
    };

    /// From the best to the least: what is noticed least goes first. Bounces of
    /// bounces, then faces, then the rim of the field, then the first bounce, and at
    /// last the centre's own rim; and, where the gaze says which pixels have rays, fewer
    /// of these from rung to rung.
    pub const LADDER: [Self; 14] = {
        const fn of(depth: u8, faces: f32, [field, centre]: [f32; 2], sampling: f32) -> Quality {
            Quality {
                depth,
                faces,
                field,
                centre,
                sampling,
                // The surroundings stay where they are: what is older is nearly as good.
                capture: if depth > 1 { 0.5 } else { 0.25 },
            }
        }
        const fn seldom(quality: Quality, capture: f32) -> Quality {
            Quality { capture, ..quality }
        }
        [
            Self::FULL,
            of(2, 1.0, [1.0, 1.0], 1.25),
            of(1, 1.0, [1.0, 1.0], 1.5),
            of(1, 0.5, [0.9, 1.0], 2.0),
            of(1, 0.25, [0.75, 1.0], 3.0),
            seldom(of(1, 0.25, [0.5, 0.8], 4.0), 0.125),
            seldom(of(0, 0.25, [0.5, 0.8], 4.0), 0.125),
            seldom(of(0, 0.1, [0.35, 0.7], 6.0), 0.0625),
            seldom(of(0, 0.0, [0.2, 0.6], 8.0), 0.0625),
            seldom(of(0, 0.0, [0.1, 0.45], 8.0), 0.03125),
            seldom(of(0, 0.0, [0.07, 0.37], 8.0), 0.03125),
            seldom(of(0, 0.0, [0.05, 0.3], 8.0), 0.03125),
            seldom(of(0, 0.0, [0.03, 0.23], 8.0), 0.03125),
            seldom(of(0, 0.0, [0.02, 0.18], 8.0), 0.03125),
        ]
    };

    /// A level of detail whose field reaches as far as this says.
    #[must_use]
    pub fn narrow(&self, lod: LevelOfDetail) -> LevelOfDetail {
        if self.field >= 1.0 && self.centre >= 1.0 {
            return lod;
        }
        let field = lod.gaze.visual_field();
        let limits = field.limits();
        let central = (limits.central * self.centre).max(LEAST_CENTRE.min(limits.central));
        let less = |limit: f32| central + (limit - limits.central) * self.field;
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

    /// An eye that sees as much as this says.
    #[must_use]
    pub fn lower(&self, eye: Observer) -> Observer {
        let inner = if self.sampling < LAST_RESORT {
            FOVEA
        } else {
            0.0
        };
        Observer {
            lod: eye.lod.map(|lod| self.narrow(lod)),
            acuity: eye
                .acuity
                .map(|acuity| acuity.steeper_beyond(self.sampling, inner)),
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
    fn rungs_leave_out_more_and_more() {
        for pair in Quality::LADDER.windows(2) {
            let [better, worse] = pair else {
                unreachable!()
            };
            assert!(worse.depth <= better.depth);
            assert!(worse.faces <= better.faces);
            assert!(worse.field <= better.field);
            assert!(worse.centre <= better.centre);
            assert!(worse.sampling >= better.sampling);
            assert!(worse.capture <= better.capture && worse.capture > 0.0);
            assert_ne!(worse, better);
        }
        assert_eq!(Quality::LADDER[0], Quality::FULL);
    }

    #[test]
    fn sampling_is_lowered_only_where_it_follows_the_gaze() {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        let paper = Observer {
            lod: Some(lod),
            ..Observer::new(Eye::Left, DVec3::ZERO)
        };
        let foveated = Observer::foveated(Eye::Left, DVec3::ZERO, sight, 0.0);
        let [_, worse @ ..] = Quality::LADDER;
        for quality in worse {
            let lowered = quality.lower(paper);
            assert_eq!(lowered.acuity, None);
            assert_eq!(lowered.lod, Some(quality.narrow(lod)));
            let acuity = quality.lower(foveated).acuity;
            let least = |e| acuity.map_or(0.0, |acuity| acuity.least_angle(e));
            for e in [0.0, 0.5 * FOVEA, FOVEA] {
                let coarser = least(e) > Acuity::GUENTER.least_angle(e);
                assert_eq!(coarser, e > 0.0 && quality.sampling >= LAST_RESORT);
            }
            let slope = (least(1.0) - least(FOVEA)) / (1.0 - FOVEA);
            let expected = Acuity::GUENTER.slope() * quality.sampling;
            assert!((slope - expected).abs() < 1e-6, "{slope} {expected}");
        }
        assert_eq!(Quality::FULL.lower(foveated), foveated);
    }

    #[test]
    fn what_is_looked_at_stays() {
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        assert_eq!(Quality::FULL.narrow(lod), lod);
        for quality in Quality::LADDER {
            let narrow = quality.narrow(lod);
            let at = |degrees: f32, around: f32| {
                let angle = degrees.to_radians();
                let (x, y) = (angle.sin() * around.cos(), angle.sin() * around.sin());
                let direction = Vec3::new(x, y, -angle.cos());
                narrow.gaze.level(direction).unwrap_or(0.0)
            };
            // All around: by the printed equation the centre is no circle.
            let centre = (0.95 * 30.0 * quality.centre).max(FOVEA.to_degrees());
            for around in 0..72 {
                let around = (5.0 * around as f32).to_radians();
                for part in 0..=20 {
                    assert_eq!(at(centre * part as f32 / 20.0, around), 1.0, "{quality:?}");
                }
            }
            // At the side the field ends at 100°, or that much nearer.
            let centre = (30.0 * quality.centre).max(LEAST_CENTRE.to_degrees());
            let end = centre + 70.0 * quality.field;
            let (before, after) = (at(end - 0.1, 0.0), at(end + 0.1, 0.0));
            assert!(before > 0.0 && after == 0.0, "{quality:?}");
        }
    }
}
