//! Measures before anything is shown.

use super::{Session, SessionError, render_order};
use crate::live::governor::{Allowance, Decision, FrameCost};
use crate::live::quantiles::median;
use crate::live::swap::{Look, Purpose};

const PLAIN_FRAMES: usize = 5;

/// The tangent of the angle (27°) to the places beside the first look that are measured.
const GLANCE: f32 = 0.5;

/// Frames of the best and of the least quality whose fastest times are compared.
const COMPARED_FRAMES: usize = 3;

impl Session<'_> {
    /// Returns the median seconds of a frame without level of detail.
    pub(super) fn plain(&mut self, look: &Look) -> Result<f64, SessionError> {
        let mut seconds = Vec::new();
        while seconds.is_empty() || seconds.len() < PLAIN_FRAMES && !self.display.is_over() {
            let order = self.next(look, &Decision::FULL, Purpose::Plain);
            self.lock.order(&order)?;
            let (done, frame) = render_order(self.engine, &self.eyes, &order)?;
            let slowest = self.lock.gather(&done)?.slowest.tracing;
            let other_time = (frame.done - frame.first_ray).saturating_sub(frame.tracing);
            seconds.push((slowest + other_time).as_secs_f64());
        }
        Ok(median(seconds))
    }

    /// Renders frames that are not shown, to learn speed, steps of tiles and costs of qualities.
    pub(super) fn warm_up(&mut self, look: &Look) -> Result<(), SessionError> {
        for _ in 0..2 {
            self.measure(look, &Decision::FULL, Purpose::WarmUp)?;
        }
        self.report.allowance = self.allowance(look.forward);
        if matches!(self.report.allowance, Allowance::Time(_)) {
            self.compare_ends(look)?;
        }
        if self.report.allowance != Allowance::Unlimited {
            let gaze = self.gaze(look);
            if gaze.is_some() {
                self.governor.follow(None);
                self.settle(look, Purpose::Plain)?;
            }
            self.governor.follow(gaze);
            self.settle(look, Purpose::WarmUp)?;
            if gaze.is_some() {
                self.look_around(look)?;
                (self.observe)(look, &mut self.eyes);
                self.governor.follow(self.gaze(look));
                self.governor.look_back();
                self.climb(look, Purpose::WarmUp)?;
            }
        }
        // The first gaze is taken by the times of frames like the first.
        self.pacing.forget();
        for _ in 0..2 {
            self.rung = self.measure_decided(look, Purpose::WarmUp)?;
        }
        Ok(())
    }

    /// Renders a frame; returns its cost, or `None` where the session is to end.
    fn measure(
        &mut self,
        look: &Look,
        decision: &Decision,
        purpose: Purpose,
    ) -> Result<Option<FrameCost>, SessionError> {
        if self.display.is_over() {
            return Ok(None);
        }
        let (_, _, cost, _) = self.render(look, decision, purpose)?;
        Ok(Some(cost))
    }

    fn measure_decided(&mut self, look: &Look, purpose: Purpose) -> Result<usize, SessionError> {
        let decision = self.governor.decide(self.tracing_allowance());
        self.measure(look, &decision, purpose)?;
        Ok(decision.rung)
    }

    fn compare_ends(&mut self, look: &Look) -> Result<(), SessionError> {
        let mut fastest: [Option<FrameCost>; 2] = [None; 2];
        for _ in 0..COMPARED_FRAMES {
            for (decision, fastest) in Decision::ENDS.iter().zip(&mut fastest) {
                let cost = self.measure(look, decision, Purpose::WarmUp)?;
                let costs = [*fastest, cost].into_iter().flatten();
                *fastest = costs.min_by(|a, b| a.seconds.total_cmp(&b.seconds));
            }
        }
        if let [Some(many), Some(few)] = fastest {
            self.governor.speed.compare(many, few);
        }
        Ok(())
    }

    fn settle(&mut self, look: &Look, purpose: Purpose) -> Result<(), SessionError> {
        self.measure(look, &Decision::FULL, purpose)?;
        for _ in 0..3 {
            self.measure_decided(look, purpose)?;
        }
        self.climb(look, purpose)
    }

    /// Measures qualities where the viewer may look next: their ratios differ from place to place.
    fn look_around(&mut self, look: &Look) -> Result<(), SessionError> {
        let across = look.forward.cross(look.up);
        for aside in [across, -across, look.up, -look.up] {
            let glance = look.towards(Some(look.forward + GLANCE * aside));
            if !(self.observe)(&glance, &mut self.eyes) {
                continue;
            }
            self.governor.follow(self.gaze(&glance));
            self.measure(&glance, &Decision::FULL, Purpose::WarmUp)?;
            for decision in self.governor.around() {
                self.measure(&glance, &decision, Purpose::WarmUp)?;
            }
        }
        Ok(())
    }

    fn climb(&mut self, look: &Look, purpose: Purpose) -> Result<(), SessionError> {
        while let Some(better) = self.governor.better() {
            let ended = self.measure(look, &better, purpose)?.is_none();
            if ended || !self.governor.rise(self.tracing_allowance()) {
                break;
            }
        }
        Ok(())
    }
}
