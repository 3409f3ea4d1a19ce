//! The viewer's eyes, and what follows their gaze.

use crate::cave::Eye;
use glam::{DVec3, Vec3};
use shisen_core::frame::{LevelOfDetail, Renderer};
use shisen_core::gaze::{Acuity, Gaze, LineOfSight, VisualField};
use shisen_core::{Runs, Simd};

/// One of the viewer's eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer {
    /// Left, right or centre.
    pub eye: Eye,
    /// Where it is: metres, in the room.
    pub place: DVec3,
    /// The detail that follows its gaze, if any does. The two eyes may have one
    /// line of sight, as in the paper, or one each.
    pub lod: Option<LevelOfDetail>,
    /// How finely it sees beside its line of sight, where sampling follows its gaze too
    /// ([`Renderer::with_foveation`]). Not used without `lod`.
    pub acuity: Option<Acuity>,
    /// Where it looks, if that is known without `lod`: a direction in the room, near which the
    /// [live loop](crate::live) finishes its pixels first.
    pub ahead: Option<Vec3>,
}

impl Observer {
    /// Returns an eye for which everything is traced in full.
    pub const fn new(eye: Eye, place: DVec3) -> Self {
        Self {
            eye,
            place,
            lod: None,
            acuity: None,
            ahead: None,
        }
    }

    /// Returns an eye whose periphery is sampled as finely as it sees ([`Acuity::GUENTER`]), every
    /// ray in full, in the widest field. The line of sight is known to within `widen` (radians);
    /// from π on that says nothing, and everything is traced.
    pub fn foveated(eye: Eye, place: DVec3, sight: LineOfSight, widen: f32) -> Self {
        let Some(field) = VisualField::WIDEST.wider(widen) else {
            return Self {
                ahead: Some(sight.forward()),
                ..Self::new(eye, place)
            };
        };
        Self {
            lod: Some(LevelOfDetail::in_full(Gaze::new(sight, field))),
            acuity: Some(Acuity::GUENTER.around(widen)),
            ..Self::new(eye, place)
        }
    }

    /// Returns its line of sight, if that is known: a direction in the room.
    pub(crate) fn forward(&self) -> Option<Vec3> {
        let gaze = self.lod.map(|lod| lod.gaze.line_of_sight().forward());
        gaze.or(self.ahead)
    }

    pub(crate) fn follow<'a, const W: usize>(&self, renderer: &Renderer<'a, W>) -> Renderer<'a, W>
    where
        Simd: Runs<W>,
    {
        match (self.lod, self.acuity) {
            (Some(lod), Some(acuity)) => renderer.with_foveation(lod, acuity),
            (Some(lod), None) => renderer.with_level_of_detail(lod),
            (None, _) => *renderer,
        }
    }
}
