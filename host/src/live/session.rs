//! Frame after frame, each for a refresh of the display.

mod pacing;
mod report;
mod shares;
mod warm_up;

use super::budget::{FrameBudget, MOST_STEPS, Table2};
use super::engine::{Engine, Rendered};
use super::governor::{Allowance, Decision, Governor, Taken};
use super::latency::Stamps;
use super::quality::Quality;
use super::swap::{Done, Look, Order, Purpose, SwapError, SwapLock};
use super::tracking::{Latched, LiveTracker};
use crate::render::{Observer, RenderError};
use glam::Vec3;
use hdrhistogram::Histogram;
use miette::Diagnostic;
use pacing::Pacing;
pub use report::{FrameRecord, SessionReport};
use shares::Shares;
use shisen_core::{Runs, Simd};
use shisen_tracker::time::Micros;
use std::time::{Duration, Instant};
use thiserror::Error;

/// What a frame may take besides tracing, more than twice as much as others, before it
/// counts as held up: others take some tenths of a millisecond.
const HELD_UP: Duration = Duration::from_millis(2);

/// How a session goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionSettings {
    /// Refreshes per second, 1 or more.
    pub hz: u32,
    /// What a frame may take.
    pub budget: FrameBudget,
    /// The scene's row, where it is one of the paper's.
    pub table: Option<Table2>,
    /// When the gaze is taken.
    pub latch: Latch,
    /// How many frames, if not until somebody asks for an end.
    pub frames: Option<u64>,
}

impl Default for SessionSettings {
    /// 60 Hz without a budget, without an end, the gaze taken late.
    fn default() -> Self {
        Self {
            hz: 60,
            budget: FrameBudget::Off,
            table: None,
            latch: Latch::Late,
            frames: None,
        }
    }
}

/// When a frame takes the gaze.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Latch {
    /// As soon as the frame before is on the walls.
    Early,
    /// As late as the slowest of the last frames allows, or as soon as the last sample has
    /// come that is expected until then.
    Late,
}

/// Why a session does not begin.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum SessionError {
    /// A budget of the paper's for a scene that is not the paper's.
    #[error("the paper's Table 2 has no such scene, so there is no budget {0} for it")]
    #[diagnostic(help("give a time, a number of steps, or no budget"))]
    NotInTable(FrameBudget),
    /// A frame that cannot be rendered.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Render(#[from] RenderError),
    /// Machines that no longer show the same.
    #[error(transparent)]
    Swap(#[from] SwapError),
}

/// Whatever is done with frames.
pub trait Stage<const W: usize> {
    /// Where the eyes are and what follows their gaze, into `eyes`, which holds
    /// those of the frame before. False where they cannot see a screen.
    fn observe(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> bool;

    /// Where the viewer looks, if the stage knows better than the tracker: in the room.
    fn gaze(&mut self) -> Option<Vec3> {
        None
    }

    /// Puts a frame on the walls.
    fn present(&mut self, engine: &Engine<'_, '_, W>, look: &Look, eyes: &[Observer]);

    /// Whether there is to be an end before the first frame is shown.
    fn is_over(&mut self) -> bool {
        false
    }

    /// Hears of a frame after it was shown; whether the session goes on.
    fn after(&mut self, record: &FrameRecord) -> bool;
}

/// Renders frames until their number is reached or the stage asks for an end.
///
/// # Errors
/// A budget that the scene has not; a frame that cannot be rendered.
pub fn run<const W: usize>(
    engine: &mut Engine<'_, '_, W>,
    tracker: &LiveTracker,
    settings: &SessionSettings,
    stage: &mut dyn Stage<W>,
    lock: &mut dyn SwapLock,
) -> Result<SessionReport, SessionError>
where
    Simd: Runs<W>,
{
    if let (FrameBudget::Paper | FrameBudget::PaperScaled, None) = (settings.budget, settings.table)
    {
        return Err(SessionError::NotInTable(settings.budget));
    }
    let mut eyes = Vec::new();
    let first = match settings.budget {
        // What has come by now is the clock's matter, which is to change no frame.
        FrameBudget::Steps(_) => *tracker.home(),
        _ => tracker.latch(tracker.now()).estimate,
    };
    // As if the gaze were known: it may not have come yet, and will.
    let first = Look {
        widen: 0.0,
        ..Look::from(&first)
    };
    stage.observe(&first, &mut eyes);
    let period = Duration::from_secs_f64(1.0 / f64::from(settings.hz.max(1)));
    let mut session = Session {
        settings,
        lock,
        order: 0,
        governor: match settings.budget {
            FrameBudget::Off => Governor::idle(),
            _ => Governor::new(),
        },
        pacing: Pacing::new(period),
        besides: Duration::ZERO,
        steps: Histogram::new_with_bounds(1, MOST_STEPS, 3).ok(),
        spent: Shares::new(),
        needed: Shares::new(),
        report: SessionReport::new(),
        rung: 0,
    };
    // What is not known yet is found out before anything is shown.
    if settings.budget == FrameBudget::PaperScaled {
        session.report.plain_seconds = Some(session.plain(engine, (&first, &eyes), stage)?);
    }
    session.warm_up(engine, (&first, &mut eyes), stage)?;
    session.play(engine, tracker, stage, &mut eyes)?;
    session.compare(engine, &mut eyes, stage)?;
    session.lock.end()?;
    if let Some(waits) = session.lock.waits() {
        session.report.waited = Some(waits.waited.clone());
        session.report.spread = Some(waits.spread.clone());
    }
    session.report.median_steps = session
        .steps
        .map_or(0, |steps| steps.value_at_quantile(0.5));
    session.report.spent_share = session.spent.median();
    session.report.needed_share = session.needed.median();
    Ok(session.report)
}

/// Renders a share of what another machine orders, until there is nothing more.
///
/// # Errors
/// A machine that orders nothing; a frame that cannot be rendered.
pub fn follow<const W: usize>(
    engine: &mut Engine<'_, '_, W>,
    stage: &mut dyn Stage<W>,
    lock: &mut dyn SwapLock,
) -> Result<(), SessionError>
where
    Simd: Runs<W>,
{
    let mut eyes = Vec::new();
    while let Some(order) = lock.obey()? {
        stage.observe(&order.look, &mut eyes);
        let (done, _) = carry_out(engine, &eyes, &order)?;
        lock.gather(&done)?;
        if order.purpose == Purpose::Shown {
            lock.swap(order.frame)?;
            stage.present(engine, &order.look, &eyes);
        }
    }
    Ok(())
}

/// Renders what is ordered.
fn carry_out<const W: usize>(
    engine: &mut Engine<'_, '_, W>,
    eyes: &[Observer],
    order: &Order,
) -> Result<(Done, Rendered), RenderError>
where
    Simd: Runs<W>,
{
    let full: Vec<_>;
    let eyes = if order.purpose == Purpose::Plain {
        let plain = eyes.iter().map(|one| Observer {
            ahead: one.forward(),
            ..Observer::new(one.eye, one.place)
        });
        full = plain.collect();
        &full
    } else {
        eyes
    };
    let quality = Quality::LADDER.get(order.rung).unwrap_or(&Quality::FULL);
    let rendered = if order.whole_fovea {
        engine.render_whole_fovea(eyes, quality, order.steps)
    } else {
        engine.render(eyes, quality, order.steps)
    }?;
    let done = Done {
        frame: order.frame,
        steps: rendered.steps,
        need: rendered.need,
        tracing: rendered.tracing,
        tiles: rendered.tiles,
        unfinished: rendered.unfinished,
        unfinished_fovea: rendered.unfinished_fovea,
        hashes: if order.purpose == Purpose::Compared {
            engine.hashes()?
        } else {
            Vec::new()
        },
    };
    Ok((done, rendered))
}

/// Where a look goes, if eyes follow it.
fn gaze_of(look: &Look, eyes: &[Observer]) -> Option<Vec3> {
    let follow = eyes.iter().any(|eye| eye.lod.is_some());
    follow.then_some(look.forward)
}

struct Session<'s> {
    settings: &'s SessionSettings,
    lock: &'s mut dyn SwapLock,
    /// Frames that were ordered.
    order: u64,
    governor: Governor,
    pacing: Pacing,
    /// What frames take besides tracing, of late: one that was held up counts for
    /// little.
    besides: Duration,
    steps: Option<Histogram<u64>>,
    /// Of the budget, what frames took.
    spent: Shares,
    /// Of its steps, what frames of full quality would have taken.
    needed: Shares,
    report: SessionReport,
    rung: usize,
}

impl Session<'_> {
    /// Of each machine.
    fn allowance(&self, forward: Vec3) -> Allowance {
        let seconds = |seconds: f64| Allowance::Time(Duration::from_secs_f64(seconds));
        match (self.settings.budget, self.settings.table) {
            (FrameBudget::Steps(steps), _) => {
                Allowance::Steps(steps / self.lock.share().ranks() as u64)
            }
            (FrameBudget::Time(time), _) => Allowance::Time(time),
            (FrameBudget::Paper, Some(row)) => seconds(row.seconds(forward)),
            (FrameBudget::PaperScaled, Some(row)) => {
                seconds(row.part(forward) * self.report.plain_seconds.unwrap_or_default())
            }
            (FrameBudget::Off | FrameBudget::Paper | FrameBudget::PaperScaled, _) => {
                Allowance::Unlimited
            }
        }
    }

    /// In how many refreshes a frame is to be there: those of its time, where it has
    /// one. A hundredth more is no refresh more.
    fn refreshes(&self) -> u64 {
        match self.report.allowance {
            Allowance::Time(time) => {
                let part = time.as_secs_f64() / self.pacing.period().as_secs_f64();
                ((part - 0.01).ceil() as u64).max(1)
            }
            Allowance::Unlimited | Allowance::Steps(_) => 1,
        }
    }

    /// What of the allowance is left for tracing.
    fn for_tracing(&self) -> Allowance {
        match self.report.allowance {
            Allowance::Time(time) => Allowance::Time(time.saturating_sub(self.besides)),
            other => other,
        }
    }

    /// The next frame for all.
    fn next(&mut self, look: &Look, decision: &Decision, purpose: Purpose) -> Order {
        let frame = self.order;
        self.order += 1;
        Order {
            frame,
            look: *look,
            rung: decision.rung,
            steps: decision.steps,
            whole_fovea: decision.whole_fovea,
            purpose,
        }
    }

    /// Has all render a frame, of which the numbers are; and what the slowest took.
    fn render<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        (look, eyes): (&Look, &[Observer]),
        decision: &Decision,
        purpose: Purpose,
    ) -> Result<(Rendered, Taken), SessionError>
    where
        Simd: Runs<W>,
    {
        let begun = Instant::now();
        let order = self.next(look, decision, purpose);
        self.lock.order(&order)?;
        let (done, mut rendered) = carry_out(engine, eyes, &order)?;
        let gathered = self.lock.gather(&done)?;
        if self.lock.share().ranks() > 1 {
            rendered.done = Instant::now();
        }
        if purpose == Purpose::Shown {
            self.report.last = Some(order);
        }
        let traced = rendered.done - begun;
        if purpose == Purpose::Shown {
            self.note_spent(gathered.slowest.steps, traced);
        }
        self.pacing.learn(traced);
        // What a frame takes besides is no matter of steps: the fewer it has, the
        // slower they would seem. And what is given up would leave less to trace
        // the next time, and more to be given up.
        let slowest = &gathered.slowest;
        let besides = traced.saturating_sub(slowest.tracing + rendered.giving_up);
        let besides = besides.min(self.besides * 2 + HELD_UP);
        self.besides = (self.besides * 15 + besides) / 16;
        let taken = Taken {
            steps: slowest.steps,
            seconds: slowest.tracing.as_secs_f64(),
        };
        self.governor.learn(decision, slowest.need, taken);
        if let (Purpose::Shown, Some(steps)) = (purpose, decision.steps) {
            self.needed
                .record(self.governor.full_need() / steps.max(1) as f64);
        }
        let all = &gathered.all;
        rendered.steps = all.steps;
        rendered.need = all.need;
        rendered.tiles = all.tiles;
        rendered.unfinished = all.unfinished;
        rendered.unfinished_fovea = all.unfinished_fovea;
        Ok((rendered, taken))
    }

    /// Notes what a frame took of its budget: its steps, and its time.
    fn note_spent(&mut self, steps: u64, time: Duration) {
        let share = match self.report.allowance {
            Allowance::Unlimited => return,
            Allowance::Steps(allowed) => steps as f64 / allowed as f64,
            Allowance::Time(allowed) => time.as_secs_f64() / allowed.as_secs_f64(),
        };
        self.spent.record(share);
    }

    /// Has all machines render the last frame once more, without an end of steps, for
    /// whoever wants to compare it with one machine's.
    fn compare<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        eyes: &mut Vec<Observer>,
        stage: &mut dyn Stage<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        if self.lock.share().ranks() == 1 {
            return Ok(());
        }
        let Some(last) = self.report.last else {
            return Ok(());
        };
        let order = Order {
            frame: self.order,
            steps: None,
            purpose: Purpose::Compared,
            ..last
        };
        stage.observe(&order.look, eyes);
        self.lock.order(&order)?;
        let (done, _) = carry_out(engine, eyes, &order)?;
        self.report.hashes = self.lock.gather(&done)?.all.hashes;
        Ok(())
    }

    fn play<const W: usize>(
        &mut self,
        engine: &mut Engine<'_, '_, W>,
        tracker: &LiveTracker,
        stage: &mut dyn Stage<W>,
        eyes: &mut Vec<Observer>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        self.pacing.begin(Instant::now());
        let mut goes_on = !stage.is_over();
        while goes_on && self.settings.frames != Some(self.report.frames) {
            let aim = self.pacing.aim();
            if self.settings.latch == Latch::Late {
                wait_until(aim.begin, tracker);
            }
            let latched = tracker.latch(tracker.at(aim.display));
            let look = Look::from(&latched.estimate).towards(stage.gaze());
            if !stage.observe(&look, eyes) {
                self.report.blind_frames += 1;
            }
            self.report.allowance = self.allowance(look.forward);
            self.report.note_part();
            self.governor.follow(gaze_of(&look, eyes));
            let decision = self.governor.decide(self.for_tracing());
            let due = self.pacing.next() + self.refreshes() - 1;
            let (rendered, _) = self.render(engine, (&look, eyes), &decision, Purpose::Shown)?;
            let shown = self.pacing.shown(rendered.done);
            sleep_until(self.pacing.at(shown));
            self.lock.swap(self.order - 1)?;
            // Who waits for others misses refreshes, too.
            let shown = self.pacing.shown_late(shown, Instant::now());
            stage.present(engine, &look, eyes);
            let present = Instant::now();
            let record = self.record(
                tracker,
                (&latched, &look),
                &decision,
                &rendered,
                (due, shown),
                present,
            );
            goes_on = stage.after(&record);
            self.pacing.go_on(shown, Instant::now());
        }
        self.report.seconds = self.pacing.elapsed(Instant::now()).as_secs_f64();
        Ok(())
    }

    fn record(
        &mut self,
        tracker: &LiveTracker,
        (latched, look): (&Latched, &Look),
        decision: &Decision,
        rendered: &Rendered,
        (due, shown): (u64, u64),
        present: Instant,
    ) -> FrameRecord {
        let nanos = |time: Micros| Duration::from_micros(time.0);
        let at = |instant: Instant| nanos(tracker.at(instant));
        let stamps = Stamps {
            sample: latched.sample.filter(|_| latched.follows).map(nanos),
            arrive: latched.arrive.filter(|_| latched.follows).map(nanos),
            latch: nanos(latched.latch),
            first_ray: at(rendered.first_ray),
            done: at(rendered.done),
            present: at(present),
        };
        let ranks = self.lock.share().ranks() as u64;
        let budget = match self.report.allowance {
            Allowance::Time(time) => Some(time),
            Allowance::Unlimited | Allowance::Steps(_) => None,
        };
        let traced = stamps.done.saturating_sub(stamps.latch);
        let record = FrameRecord {
            frame: self.report.frames,
            due_us: tracker.at(self.pacing.at(due)).0,
            due_refresh: due,
            refresh: shown,
            sample_us: latched.sample.map(|time| time.0),
            arrive_us: latched.arrive.map(|time| time.0),
            latch_us: latched.latch.0,
            first_ray_us: tracker.at(rendered.first_ray).0,
            done_us: tracker.at(rendered.done).0,
            present_us: tracker.at(present).0,
            late: shown > due,
            position: look.position.to_array(),
            forward: look.forward.to_array(),
            state: latched.estimate.state.name(),
            follows_gaze: latched.follows,
            budget_us: budget.map(|time| time.as_micros() as u64),
            over_time: budget.is_some_and(|time| traced > time),
            budget_steps: decision.steps.map(|steps| steps * ranks),
            steps: rendered.steps,
            need_steps: rendered.need,
            rung: decision.rung,
            tiles: rendered.tiles,
            unfinished_tiles: rendered.unfinished,
            unfinished_fovea: rendered.unfinished_fovea,
        };
        let report = &mut self.report;
        report.count(&record);
        report.latencies.record(&stamps);
        report.samples = latched.samples;
        report.passed_over = latched.passed_over;
        report.quality_changes += u64::from(decision.rung != self.rung);
        self.rung = decision.rung;
        if let Some(steps) = &mut self.steps {
            steps.saturating_record(rendered.steps);
        }
        record
    }
}

/// Systems wake late by some tenths of a millisecond, for which is spun.
const SPIN: Duration = Duration::from_micros(300);

/// Waits for the last sample until then, but for the time that is spun: a frame that began
/// later would know no more. Where none is the last by then, what comes while it is spun
/// counts, too.
fn wait_until(time: Instant, tracker: &LiveTracker) {
    let asleep = time.checked_sub(SPIN).unwrap_or(time);
    if !tracker.wait(asleep) {
        sleep_until(time);
    }
}

/// Sleeps, and spins at the end.
fn sleep_until(time: Instant) {
    let left = time.saturating_duration_since(Instant::now());
    if let Some(asleep) = left.checked_sub(SPIN) {
        std::thread::sleep(asleep);
    }
    while Instant::now() < time {
        std::hint::spin_loop();
    }
}

#[cfg(test)]
mod tests;
