//! The wavelengths of a ray that enters a dispersive medium, one after another.

use super::{Arrival, RayTree};
use crate::scene::format::effect;
use crate::simd::{Runs, Simd};
use crate::spectrum::SpectralSample;
use crate::trace::dispersion::Part;
use crate::trace::ledger::Record;
use glam::Vec3;

/// What goes on from where a ray enters a dispersive medium, by wavelength.
pub(super) struct Fan<'a> {
    part: Part<'a>,
    /// Rays that wait until all are through.
    waiting: usize,
    /// Whether none has been sent yet.
    is_new: bool,
    /// Whether what the border reflects goes with it.
    is_all: bool,
    at: Arrival<'a>,
}

impl<'a, const W: usize, const EFFECTS: u32, R: Record> RayTree<'_, 'a, W, EFFECTS, R>
where
    Simd: Runs<W>,
{
    /// Begins a fan where a ray of all wavelengths enters a dispersive medium; reflects once.
    #[inline(never)]
    pub(super) fn begin_fan(&mut self, mut at: Arrival<'a>, part: Part<'a>) {
        let shading = self.shading;
        let share = 1.0 / part.count().max(1) as f32;
        let of = |sample: &SpectralSample| shading.refraction(&at, sample.nm).reflectance;
        // The colour of all of the sample's wavelengths, and that of what they
        // reflect.
        let (white, reflected, reflectance) = if part.is_whole() {
            let broad = part.broad.iter();
            let reflected = broad.map(|sample| sample.weight * of(sample)).sum();
            let white = part.rest().map(|sample| sample.weight).sum();
            (white, reflected, reflected)
        } else {
            let (mut white, mut reflected, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0);
            for sample in part.rest() {
                let reflectance = of(&sample);
                white += sample.weight;
                reflected += sample.weight * reflectance;
                sum += reflectance;
            }
            (white, reflected, Vec3::splat(sum * share))
        };
        // The same for all fans of a sample: all of them have its wavelengths.
        self.reflected = white;
        let mut missing = self.missing.unwrap_or(Vec3::ONE - white);
        at.is_tinted = true;
        let transmission = Vec3::from_array(at.surface.material.transmission) * at.stain;
        let sides = shading.sides(&at, transmission * (Vec3::ONE - reflectance), reflectance);
        if let Some(share) = sides.back {
            self.reflect_in_part(&at, share);
            if sides.through.is_some() {
                // What goes back has the colour of all, and what goes on is each
                // wavelength's own share.
                missing += at.weight * (reflected - white * reflectance);
            }
        }
        self.missing = Some(missing);
        if sides.through.is_none() {
            return;
        }
        self.record.touch(effect::DISPERSION);
        self.share = share;
        self.is_first = true;
        at.uncovered *= share;
        self.fan = Some(Fan {
            part,
            is_new: true,
            is_all: sides.back.is_none(),
            waiting: self.workspace.pending.len(),
            at,
        });
    }

    /// Goes to a fan's next wavelength once all rays of this one are through.
    #[inline(always)]
    pub(super) fn advance_fan(&mut self) {
        if let Some(fan) = &self.fan
            && self.workspace.pending.len() <= fan.waiting
        {
            self.next_wavelength();
        }
    }

    #[inline(never)]
    fn next_wavelength(&mut self) {
        let scene = &self.shading.searcher.scene;
        if let Some(fan) = &mut self.fan {
            while let Some(sample) = fan.part.next() {
                let refraction = self.shading.refraction(&fan.at, sample.nm);
                let cause = if fan.is_new {
                    effect::REFRACTION
                } else {
                    effect::DISPERSION
                };
                let mut share = fan.at.let_through(&refraction);
                if fan.is_all {
                    share += refraction.reflectance;
                }
                if self.workspace.push(fan.at.refracted(
                    scene,
                    &refraction,
                    share,
                    (cause, self.shading.beyond(&fan.at)),
                )) {
                    self.workspace.statistics.refracted += 1;
                    self.is_first = fan.is_new;
                    fan.is_new = false;
                    (self.nm, self.tint) = (sample.nm, sample.weight);
                    return;
                }
            }
        }
        self.fan = None;
        self.nm = 0.0;
    }
}
