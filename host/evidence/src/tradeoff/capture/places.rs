//! Directions in which dome masters are compared.

use super::super::{Bench, Cause};
use super::{Mapping, Named, Optics, RADIUS};
use crate::quartz::mean;
use crate::selftest::Inputs;
use crate::textbook::angle;
use shisen::bake::Baked;
use shisen::dome::px_4096;
use shisen::live::quantiles::quantile_of;
use shisen::picture::{Picture, colour_differences};
use shisen_core::frame::View;

pub(super) struct Places {
    pub(super) truth: Optics,
    view: View,
    picture: Picture,
    /// Columns and rows of the truth.
    pub(super) at: Vec<[u32; 2]>,
}

impl Places {
    pub(super) fn new(bench: &Bench<'_>, scene: &Baked) -> Result<Self, Cause> {
        let truth = Optics {
            mirror: Named::Best,
            mapping: Mapping::True,
            radius: RADIUS,
            // No multiple of what it is the truth of: pixels do not coincide.
            size: bench.effort.pick(1_500, 3_300),
        };
        let view = truth.view()?;
        let mut draw = Inputs::new(55);
        let mut at = Vec::new();
        while at.len() < bench.effort.pick(20_000, 200_000) {
            let place = [0; 2].map(|_| draw.below(truth.size as usize) as u32);
            if view.direction(place[0] as f32, place[1] as f32).is_some() {
                at.push(place);
            }
        }
        Ok(Self {
            picture: truth.picture(bench, scene)?.picture,
            truth,
            view,
            at,
        })
    }

    /// Returns the errors of a picture in these directions: the largest angle, the angle that 95 %
    /// are below, the mean, and the share in another colour.
    pub(super) fn errors(
        &self,
        optics: &Optics,
        picture: &Picture,
    ) -> Result<Vec<Option<f64>>, Cause> {
        let view = optics.view()?;
        let ratio = f64::from(optics.size) / f64::from(self.truth.size);
        let mut angles = Vec::new();
        let mut colours = [Vec::new(), Vec::new()];
        for &[x, y] in &self.at {
            // Where the direction belongs in the picture.
            let pixel = |at: u32| {
                let pixel = ((f64::from(at) + 0.5) * ratio) as u32;
                pixel.min(optics.size - 1)
            };
            let (column, row) = (pixel(x), pixel(y));
            let truth = self.view.direction(x as f32, y as f32);
            let found = view.direction(column as f32, row as f32);
            // A pixel with its middle outside the rim shows nothing.
            let (Some(truth), Some(found)) = (truth, found) else {
                continue;
            };
            angles.push(px_4096(angle(truth.as_dvec3(), found.as_dvec3())));
            colours[0].push(self.picture.pixel(x, y).unwrap_or_default());
            colours[1].push(picture.pixel(column, row).unwrap_or_default());
        }
        let row = |pixels: &[[f32; 4]]| -> Result<Picture, Cause> {
            let mut row = Picture::new(pixels.len() as u32, 1)?;
            row.pixels.copy_from_slice(pixels);
            Ok(row)
        };
        let apart = colour_differences(&row(&colours[0])?, &row(&colours[1])?);
        let wrong = apart.iter().filter(|&&apart| apart > 1.0).count();
        let count = angles.len().max(1) as f64;
        Ok([
            quantile_of(angles.clone(), 1.0),
            quantile_of(angles.clone(), 0.95),
            mean(&angles),
            100.0 * wrong as f64 / count,
        ]
        .map(Some)
        .to_vec())
    }
}
