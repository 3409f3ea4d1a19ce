//! The wavelengths of a ray that enters a dispersive medium, one after another.

use super::{Arrival, Gathered, Shading};
use crate::scene::format::effect;
use crate::simd::{Runs, Simd};
use crate::spectrum::SpectralSample;
use crate::trace::dispersion::Part;
use crate::trace::ledger::Record;
use crate::trace::workspace::Workspace;
use glam::Vec3;

/// What goes on from where a ray enters a dispersive medium, by wavelength.
pub(super) struct Fan<'a> {
    /// Wavelengths that are still to come.
    part: Part<'a>,
    /// Rays that wait until all are through.
    waiting: usize,
    /// Whether none has been sent yet.
    is_new: bool,
    /// Whether what the border reflects goes with it.
    is_all: bool,
    at: Arrival<'a>,
}

impl<'a, const W: usize, const EFFECTS: u32> Shading<'_, 'a, W, EFFECTS>
where
    Simd: Runs<W>,
{
    /// Begins a fan where a ray of all wavelengths enters a dispersive medium; reflects once.
    #[inline(never)]
    pub(super) fn begin_fan<R: Record>(
        &self,
        mut at: Arrival<'a>,
        part: Part<'a>,
        gathered: &mut Gathered<'_, 'a, R>,
        workspace: &mut Workspace,
    ) {
        let share = 1.0 / part.count().max(1) as f32;
        let of = |sample: &SpectralSample| self.refraction(&at, sample.nm).reflectance;
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
        gathered.reflected = white;
        let mut missing = gathered.missing.unwrap_or(Vec3::ONE - white);
        at.is_tinted = true;
        let transmission = Vec3::from_array(at.surface.material.transmission);
        let sides = self.sides(&at, transmission * (Vec3::ONE - reflectance), reflectance);
        if let Some(share) = sides.back {
            Self::reflect_in_part(&at, share, gathered, workspace);
            if sides.through.is_some() {
                // What goes back has the colour of all, and what goes on is each
                // wavelength's own share.
                missing += at.weight * (reflected - white * reflectance);
            }
        }
        gathered.missing = Some(missing);
        if sides.through.is_none() {
            return;
        }
        gathered.record.touch(effect::DISPERSION);
        gathered.share = share;
        gathered.is_first = true;
        at.uncovered *= share;
        gathered.fan = Some(Fan {
            part,
            is_new: true,
            is_all: sides.back.is_none(),
            waiting: workspace.pending.len(),
            at,
        });
    }

    /// Once all rays of a fan's wavelength are through, its next.
    #[inline(always)]
    pub(super) fn advance_fan<R: Record>(
        &self,
        gathered: &mut Gathered<'_, 'a, R>,
        workspace: &mut Workspace,
    ) {
        if let Some(fan) = &gathered.fan
            && workspace.pending.len() <= fan.waiting
        {
            self.next_wavelength(gathered, workspace);
        }
    }

    #[inline(never)]
    fn next_wavelength<R: Record>(
        &self,
        gathered: &mut Gathered<'_, 'a, R>,
        workspace: &mut Workspace,
    ) {
        if let Some(fan) = &mut gathered.fan {
            while let Some(sample) = fan.part.next() {
                let refraction = self.refraction(&fan.at, sample.nm);
                let cause = if fan.is_new {
                    effect::REFRACTION
                } else {
                    effect::DISPERSION
                };
                let mut share = fan.at.let_through(&refraction);
                if fan.is_all {
                    share += refraction.reflectance;
                }
                if workspace.push(fan.at.refracted(&refraction, share, cause)) {
                    workspace.statistics.refracted += 1;
                    gathered.is_first = fan.is_new;
                    fan.is_new = false;
                    (gathered.nm, gathered.tint) = (sample.nm, sample.weight);
                    return;
                }
            }
        }
        gathered.fan = None;
        gathered.nm = 0.0;
    }
}
