//! Descriptions of frames for programs that have the core alone, in a page or on a microcontroller.
//! `host/web/src/frame.rs` has the format and reads it.

use super::threads::pairs;
use super::{Cut, TileEngine, lock};
use crate::bake::Stage;
use crate::render::Observer;
use crate::render::spectrum::Dispersion;
use glam::{DAffine3, Vec3};
use miette::Diagnostic;
use shisen_core::gaze::{Acuity, Boundary, LineOfSight, VisualField};
use shisen_core::{Runs, Simd};
use thiserror::Error;

/// The format's version.
const VERSION: u32 = 2;

/// Why a frame has no description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, Diagnostic)]
#[allow(missing_docs, reason = "the messages are the docs")]
pub enum Undescribed {
    #[error("the scene is in the fast layout")]
    #[diagnostic(help("record with --layout compact: it is what pages and microcontrollers read"))]
    Layout,
    #[error("a screen is not flat, or its eye does not see it")]
    #[diagnostic(help(
        "descriptions have flat walls alone: render this frame with `shisen replay`"
    ))]
    Screen,
    #[error("a mesh deforms, or surroundings are captured")]
    #[diagnostic(help("record with --animation none and --fill background"))]
    Content,
    #[error("wavelengths are not taken by a comb")]
    #[diagnostic(help("record with --dispersion comb"))]
    Spectrum,
}

/// Words of four bytes, the lowest first.
#[derive(Default)]
struct Words(Vec<u8>);

impl Words {
    fn whole(&mut self, number: usize) {
        self.0.extend((number as u32).to_le_bytes());
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.0
            .extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    }

    fn vectors(&mut self, vectors: impl IntoIterator<Item = Vec3>) {
        self.numbers(vectors.into_iter().flat_map(|vector| vector.to_array()));
    }

    fn sight(&mut self, sight: LineOfSight) {
        self.vectors([sight.position(), sight.forward(), sight.right(), sight.up()]);
    }

    /// What follows the gaze.
    fn detail(&mut self, eye: Option<&Observer>, faces: f32, beyond: [f32; 2]) {
        let lod = eye.and_then(|eye| eye.lod);
        let field = lod.map_or(VisualField::PAPER, |lod| lod.gaze.visual_field());
        let foveation = eye.and_then(|eye| eye.foveation);
        self.whole(match (lod, field.boundary(), foveation) {
            (Some(_), Boundary::Printed, _) => 1,
            (Some(_), Boundary::Ellipse, _) => 2,
            (None, _, Some(_)) => 3,
            (None, _, None) => 0,
        });
        let limits = field.limits();
        self.numbers([
            faces,
            limits.central,
            limits.up,
            limits.down,
            limits.left,
            limits.right,
        ]);
        let acuity = foveation.map_or(Acuity::GUENTER, |foveation| foveation.acuity);
        self.numbers([acuity.slope(), acuity.fovea(), acuity.off()]);
        self.numbers(beyond);
    }

    fn dispersion(&mut self, dispersion: &Dispersion) -> Result<(), Undescribed> {
        let (count, range, each) = match dispersion {
            Dispersion::Off => (0, [0.0; 2], 0),
            Dispersion::Comb(wavelengths, each) => {
                (wavelengths.count(), wavelengths.range(), *each)
            }
            _ => return Err(Undescribed::Spectrum),
        };
        self.whole(count);
        self.numbers(range);
        self.whole(each.into());
        Ok(())
    }

    fn moved(&mut self, objects: &[(usize, DAffine3)]) {
        self.whole(objects.len());
        for (object, map) in objects {
            self.whole(*object);
            let numbers = map.to_cols_array().into_iter();
            self.0.extend(numbers.flat_map(f64::to_le_bytes));
        }
    }
}

impl<const W: usize> TileEngine<'_, '_, W>
where
    Simd: Runs<W>,
{
    pub(super) fn description(
        &self,
        eyes: &[Observer],
        cuts: &[Cut],
    ) -> Result<Vec<u8>, Undescribed> {
        if W != 4 {
            return Err(Undescribed::Layout);
        }
        let plan = self.shared.read();
        if plan.capture.is_some() {
            return Err(Undescribed::Content);
        }
        let (options, quality) = (&self.options, &self.quality);
        let mut words = Words::default();
        words.whole(VERSION as usize);
        words.whole(options.settings.depth.min(quality.depth).into());
        words.whole(options.settings.samples.into());
        words.whole(options.effects.of(self.scene.effects()).bits() as usize);
        let narrow = |eye: &Observer| Observer {
            lod: eye.lod.map(|lod| quality.narrow(lod)),
            ..*eye
        };
        let first = eyes.first().map(narrow);
        words.detail(
            first.as_ref(),
            quality.faces,
            [quality.sampling, quality.fine_within()],
        );
        words.dispersion(&options.dispersion)?;
        words.whole(plan.parts.len());
        let own = plan.parts.iter().zip(&plan.dark);
        for (((view, _), dark), (_, _, eye)) in own.zip(pairs(self.cave, eyes, self.share)) {
            let flat = view.flat().filter(|_| !dark);
            words.whole(0);
            words.vectors(flat.ok_or(Undescribed::Screen)?);
            words.whole(view.columns() as usize);
            words.whole(view.rows() as usize);
            let eye = self.place.observer(eye);
            let of_lod = eye.lod.map(|lod| lod.gaze.line_of_sight());
            let sight = of_lod.or(eye.foveation.map(|foveation| foveation.sight));
            match sight {
                Some(sight) => words.sight(sight),
                None => words.vectors([view.eye(), Vec3::NEG_Z, Vec3::X, Vec3::Y]),
            }
        }
        let objects = plan.stage.as_ref().map_or(Some(&[][..]), Stage::objects);
        words.moved(objects.ok_or(Undescribed::Content)?);
        let tiles = cuts.iter().filter_map(|cut| {
            let tile = lock(self.shared.tiles.get(cut.tile as usize)?);
            Some((cut, tile.part, tile.job.tile()))
        });
        let tiles: Vec<_> = tiles.collect();
        words.whole(tiles.len());
        for (cut, part, tile) in tiles {
            words.whole(part);
            for word in [tile.x, tile.y, tile.width, tile.height, cut.kept] {
                words.whole(word as usize);
            }
        }
        Ok(words.0)
    }
}
