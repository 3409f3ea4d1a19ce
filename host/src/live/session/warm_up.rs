//! What is found out before anything is shown.

use super::{Session, SessionError, Stage, carry_out, gaze_of};
use crate::live::engine::Engine;
use crate::live::governor::{Allowance, Decision, Taken};
use crate::live::quantiles::median;
use crate::live::swap::{Look, Purpose};
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
        WarmUp {
            session: self,
            engine,
            stage,
        }
        .frames(look, eyes)
    }
}

/// What is seen in a frame, and by whom.
type Seen<'l> = (&'l Look, &'l [Observer]);

/// What renders frames that nobody sees.
struct WarmUp<'w, 's, 'e, 'c, const W: usize> {
    session: &'w mut Session<'s>,
    engine: &'w mut Engine<'e, 'c, W>,
    stage: &'w mut dyn Stage<W>,
}

impl<const W: usize> WarmUp<'_, '_, '_, '_, W>
where
    Simd: Runs<W>,
{
    /// All of them.
    fn frames(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> Result<(), SessionError> {
        for _ in 0..2 {
            self.render((look, eyes), &Decision::FULL, Purpose::WarmUp)?;
        }
        self.session.report.allowance = self.session.allowance(look.forward);
        let allowance = self.session.report.allowance;
        if matches!(allowance, Allowance::Time(_)) {
            self.compare_ends((look, eyes))?;
        }
        if allowance != Allowance::Unlimited {
            let gaze = gaze_of(look, eyes);
            if gaze.is_some() {
                self.session.governor.follow(None);
                self.settle((look, eyes), Purpose::Plain)?;
            }
            self.session.governor.follow(gaze);
            self.settle((look, eyes), Purpose::WarmUp)?;
            if gaze.is_some() {
                self.look_around(look, eyes)?;
                self.stage.observe(look, eyes);
                self.session.governor.follow(gaze_of(look, eyes));
                self.session.governor.look_back();
                self.climb((look, eyes), Purpose::WarmUp)?;
            }
        }
        // When the first gaze is taken depends on frames like the first.
        self.session.pacing.forget();
        for _ in 0..2 {
            self.session.rung = self.render_decided((look, eyes), Purpose::WarmUp)?;
        }
        Ok(())
    }

    /// Has all render a frame, and says what it took; `None` where an end was asked for
    /// instead.
    fn render(
        &mut self,
        seen: Seen<'_>,
        decision: &Decision,
        purpose: Purpose,
    ) -> Result<Option<Taken>, SessionError> {
        if self.stage.is_over() {
            return Ok(None);
        }
        let (_, taken) = self.session.render(self.engine, seen, decision, purpose)?;
        Ok(Some(taken))
    }

    /// The same of the quality that fits, whose rung it is.
    fn render_decided(&mut self, seen: Seen<'_>, purpose: Purpose) -> Result<usize, SessionError> {
        let allowance = self.session.for_tracing();
        let decision = self.session.governor.decide(allowance);
        self.render(seen, &decision, purpose)?;
        Ok(decision.rung)
    }

    /// Finds out what of a frame's time is no matter of its steps.
    fn compare_ends(&mut self, seen: Seen<'_>) -> Result<(), SessionError> {
        let mut fastest: [Option<Taken>; 2] = [None; 2];
        for _ in 0..COMPARED_FRAMES {
            for (decision, fastest) in Decision::ENDS.iter().zip(&mut fastest) {
                let taken = self.render(seen, decision, Purpose::WarmUp)?;
                *fastest = [*fastest, taken]
                    .into_iter()
                    .flatten()
                    .min_by(|a, b| a.seconds.total_cmp(&b.seconds));
            }
        }
        if let [Some(many), Some(few)] = fastest {
            self.session.governor.compare(many, few);
        }
        Ok(())
    }

    /// Finds the quality that fits.
    fn settle(&mut self, seen: Seen<'_>, purpose: Purpose) -> Result<(), SessionError> {
        self.render(seen, &Decision::FULL, purpose)?;
        for _ in 0..3 {
            self.render_decided(seen, purpose)?;
        }
        self.climb(seen, purpose)
    }

    /// Sees what the qualities around the one that fits, and the best, take where a viewer
    /// may look next: how much less one takes than another is not the same everywhere.
    fn look_around(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> Result<(), SessionError> {
        let across = look.forward.cross(look.up);
        for aside in [across, -across, look.up, -look.up] {
            let glance = look.towards(Some(look.forward + GLANCE * aside));
            if !self.stage.observe(&glance, eyes) {
                continue;
            }
            self.session.governor.follow(gaze_of(&glance, eyes));
            self.render((&glance, eyes), &Decision::FULL, Purpose::WarmUp)?;
            for decision in self.session.governor.around() {
                self.render((&glance, eyes), &decision, Purpose::WarmUp)?;
            }
        }
        Ok(())
    }

    /// Takes better qualities as long as they fit.
    fn climb(&mut self, seen: Seen<'_>, purpose: Purpose) -> Result<(), SessionError> {
        while let Some(better) = self.session.governor.better() {
            if self.render(seen, &better, purpose)?.is_none() {
                break;
            }
            let allowance = self.session.for_tracing();
            if !self.session.governor.rise(allowance) {
                break;
            }
        }
        Ok(())
    }
}
