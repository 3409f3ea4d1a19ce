//! What is found out before anything is shown.

use super::{Session, SessionError, Stage, carry_out, gaze_of};
use crate::live::engine::Engine;
use crate::live::governor::{Allowance, Decision, Taken};
use crate::live::swap::{Look, Purpose};
use crate::quantiles::median;
use crate::render::Observer;
use shisen_core::{Runs, Simd};

/// Frames without level of detail that a scaled budget is measured by.
const PLAIN_FRAMES: usize = 5;

/// How far beside where the viewer looks first they are taken to look next: the tangent
/// of that angle, 27°.
const GLANCE: f32 = 0.5;

/// Frames of the best and of the least quality whose time is compared: of each the
/// fastest counts, as what holds frames up is no matter of theirs.
const COMPARED_FRAMES: usize = 3;

impl Session<'_> {
    /// Seconds of a frame with everything in full: the median of some.
    pub(super) fn plain<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        (look, eyes): (&Look, &[Observer]),
        stage: &mut dyn Stage<W>,
    ) -> Result<f64, SessionError>
    where
        Simd: Runs<W>,
    {
        let mut seconds = Vec::new();
        while seconds.is_empty() || seconds.len() < PLAIN_FRAMES && !stage.is_over() {
            let order = self.next(look, &Decision::FULL, Purpose::Plain);
            self.lock.order(&order)?;
            let (done, frame) = carry_out(engine, eyes, &order)?;
            let slowest = self.lock.gather(&done)?.slowest.tracing;
            let besides = (frame.done - frame.first_ray).saturating_sub(frame.tracing);
            seconds.push((slowest + besides).as_secs_f64());
        }
        Ok(median(seconds))
    }

    /// Frames that nobody sees: how fast this machine is, what tiles take, and what the
    /// qualities near the one that fits cost; without a gaze to follow, as well, as there
    /// may be none later on.
    pub(super) fn warm_up<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        (look, eyes): (&Look, &mut Vec<Observer>),
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        for _ in 0..2 {
            if stage.is_over() {
                return Ok(());
            }
            self.render(engine, (look, eyes), &Decision::FULL, Purpose::WarmUp)?;
        }
        self.report.allowance = self.allowance(look.forward);
        if matches!(self.report.allowance, Allowance::Time(_)) {
            self.compare_ends(engine, (look, eyes), stage)?;
        }
        if self.report.allowance != Allowance::Unlimited {
            if gaze_of(look, eyes).is_some() {
                self.governor.follow(None);
                self.settle(engine, (look, eyes), Purpose::Plain, stage)?;
            }
            self.governor.follow(gaze_of(look, eyes));
            self.settle(engine, (look, eyes), Purpose::WarmUp, stage)?;
            if gaze_of(look, eyes).is_some() {
                self.look_around(engine, (look, eyes), stage)?;
                stage.observe(look, eyes);
                self.governor.follow(gaze_of(look, eyes));
                self.climb(engine, (look, eyes), Purpose::WarmUp, stage)?;
            }
        }
        // When the first gaze is taken depends on frames like the first.
        self.pacing.forget();
        for _ in 0..2 {
            if stage.is_over() {
                return Ok(());
            }
            let decision = self.governor.decide(self.for_tracing());
            self.render(engine, (look, eyes), &decision, Purpose::WarmUp)?;
            self.rung = decision.rung;
        }
        Ok(())
    }

    /// Finds out what of a frame's time is no matter of its steps.
    fn compare_ends<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        seen: (&Look, &[Observer]),
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        let mut fastest: [Option<Taken>; 2] = [None; 2];
        for _ in 0..COMPARED_FRAMES {
            for (decision, fastest) in Decision::ENDS.iter().zip(&mut fastest) {
                if stage.is_over() {
                    return Ok(());
                }
                let (_, taken) = self.render(engine, seen, decision, Purpose::WarmUp)?;
                if fastest.is_none_or(|fastest| taken.seconds < fastest.seconds) {
                    *fastest = Some(taken);
                }
            }
        }
        if let [Some(many), Some(few)] = fastest {
            self.governor.compare(many, few);
        }
        Ok(())
    }

    /// Finds the quality that fits.
    fn settle<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        seen: (&Look, &[Observer]),
        purpose: Purpose,
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        if stage.is_over() {
            return Ok(());
        }
        self.render(engine, seen, &Decision::FULL, purpose)?;
        for _ in 0..3 {
            if stage.is_over() {
                return Ok(());
            }
            let decision = self.governor.decide(self.for_tracing());
            self.render(engine, seen, &decision, purpose)?;
        }
        self.climb(engine, seen, purpose, stage)
    }

    /// Sees what the qualities around the one that fits take where a viewer may look
    /// next: how much less one takes than another is not the same everywhere.
    fn look_around<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        (look, eyes): (&Look, &mut Vec<Observer>),
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        let across = look.forward.cross(look.up);
        for aside in [across, -across, look.up, -look.up] {
            let glance = look.towards(Some(look.forward + GLANCE * aside));
            if !stage.observe(&glance, eyes) {
                continue;
            }
            self.governor.follow(gaze_of(&glance, eyes));
            for decision in self.governor.around() {
                if stage.is_over() {
                    return Ok(());
                }
                self.render(engine, (&glance, eyes), &decision, Purpose::WarmUp)?;
            }
        }
        Ok(())
    }

    /// Takes better qualities as long as they fit.
    fn climb<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        seen: (&Look, &[Observer]),
        purpose: Purpose,
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        while let Some(better) = self.governor.better().filter(|_| !stage.is_over()) {
            self.render(engine, seen, &better, purpose)?;
            if !self.governor.rise(self.for_tracing()) {
                break;
            }
        }
        Ok(())
    }
}
