//! The viewer's eyes, and what follows their gaze.

use crate::cave::Eye;
use glam::{DVec3, Vec3};
use shisen_core::frame::{LevelOfDetail, Renderer};
use shisen_core::gaze::{Acuity, LineOfSight};
use shisen_core::{Runs, Simd};
use std::f32::consts::PI;

/// Detail as an eye sees it ([`Renderer::with_foveation`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foveation {
    /// Where it looks, in the room.
    pub sight: LineOfSight,
    /// How finely it sees beside its line of sight.
    pub acuity: Acuity,
}

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
    /// Where it looks and how finely it sees, where the size of detail follows its gaze; not used
    /// with `lod`.
    pub foveation: Option<Foveation>,
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
            foveation: None,
            ahead: None,
        }
    }

    /// Returns an eye that sees detail of an acuity around a line of sight that is known to within
    /// `widen` (radians); from π on that says nothing, and everything is traced.
    pub fn foveated(
        eye: Eye,
        place: DVec3,
        (sight, acuity): (LineOfSight, Acuity),
        widen: f32,
    ) -> Self {
        let acuity = acuity.around(widen);
        Self {
            foveation: (widen < PI).then_some(Foveation { sight, acuity }),
            ahead: Some(sight.forward()),
            ..Self::new(eye, place)
        }
    }

    /// Returns its line of sight, if that is known: a direction in the room.
    pub(crate) fn forward(&self) -> Option<Vec3> {
        let of_lod = self.lod.map(|lod| lod.gaze.line_of_sight().forward());
        let of_foveation = self.foveation.map(|foveation| foveation.sight.forward());
        of_lod.or(of_foveation).or(self.ahead)
    }

    pub(crate) fn follow<'a, const W: usize>(&self, renderer: &Renderer<'a, W>) -> Renderer<'a, W>
    where
        Simd: Runs<W>,
    {
        match (self.lod, self.foveation) {
            (Some(lod), _) => renderer.with_level_of_detail(lod),
            (None, Some(Foveation { sight, acuity })) => renderer.with_foveation(sight, acuity),
            (None, None) => *renderer,
        }
    }
}
