//! A session: frame after frame, each for a refresh of the display.

mod pacing;
mod report;
mod warm_up;

use super::budget::{FrameBudget, MOST_STEPS, Table2};
use super::engine::{Engine, Rendered};
use super::flight::RoomPlace;
use super::governor::{Allowance, Decision, FrameCost, Governor};
use super::latency::FrameRecord;
use super::swap::{FrameResult, Look, Order, Purpose, SwapError, SwapLock};
use super::tracking::{LatchedGaze, LiveTracker};
use crate::render::{Observer, RenderError};
use crate::tracker::{Flight, Steering};
use glam::Vec3;
use hdrhistogram::Histogram;
use miette::Diagnostic;
use pacing::Pacing;
pub use report::SessionReport;
use report::Shares;
use std::time::{Duration, Instant};
use thiserror::Error;

/// The time besides tracing, above twice the usual, from which a frame was held up.
const HELD_UP: Duration = Duration::from_millis(2);

/// The settings of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionSettings {
    /// Refreshes per second, 1 or more.
    pub hz: u32,
    /// The budget of a frame.
    pub budget: FrameBudget,
    /// The scene's row of the paper's table; `None` for other scenes.
    pub table: Option<Table2>,
    /// When the gaze is taken.
    pub latch: Latch,
    /// How fast the viewer flies.
    pub flight: Flight,
    /// The number of frames; `None`: until the display ends the session.
    pub frames: Option<u64>,
}

impl Default for SessionSettings {
    /// 60 Hz, no budget, no end, the gaze taken late.
    fn default() -> Self {
        Self {
            hz: 60,
            budget: FrameBudget::Off,
            table: None,
            latch: Latch::Late,
            flight: Flight::default(),
            frames: None,
        }
    }
}

/// When a frame takes the gaze.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Latch {
    /// As soon as the frame before is on the walls.
    Early,
    /// As late as the slowest recent frame allows, or at the last sample expected by then.
    Late,
}

named!(Latch { Early => "early", Late => "late" });

/// Why a session ends early.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum SessionError {
    /// The paper's budget for a scene that the paper does not have.
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

/// Puts the eyes and what follows their gaze into the list, which holds those of the frame before.
/// Returns false where they cannot see a screen.
pub type Observe<'a> = dyn FnMut(&Look, &mut Vec<Observer>) -> bool + 'a;

/// The refresh at which a display showed a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refresh {
    /// When the last of the display's monitors showed it.
    pub shown: Instant,
    /// The time of the refresh of its first monitor, by all refreshes so far.
    pub at: Instant,
    /// From a refresh to the next.
    pub period: Duration,
}

/// Receives finished frames: the display side of a session.
pub trait Display {
    /// Returns the line of sight in the room, if the display knows better than the tracker.
    fn gaze(&mut self) -> Option<Vec3> {
        None
    }

    /// Returns where keys steer the viewer.
    fn steering(&mut self) -> Steering {
        Steering::default()
    }

    /// Makes ready what [`present`](Self::present) shows: its time is a part of the frame's.
    fn prepare(&mut self, _: &dyn Engine) {}

    /// Returns whether [`present`](Self::present) waits for the refresh.
    fn waits(&self) -> bool {
        false
    }

    /// Shows a frame at a time, which is that of a refresh. Returns when it was shown, where the
    /// display says.
    fn present(
        &mut self,
        _: &dyn Engine,
        _: &Order,
        _: &[Observer],
        _: Instant,
    ) -> Option<Refresh> {
        None
    }

    /// Returns whether to end before the first frame is shown.
    fn is_over(&mut self) -> bool {
        false
    }

    /// Gets the record of a frame that was shown; returns whether the session continues.
    fn after(&mut self, record: &FrameRecord) -> bool;
}

/// Renders frames until their number is reached or the display ends the session.
///
/// # Errors
/// The paper's budget for another scene; a frame that cannot be rendered; machines that do
/// not keep up.
pub fn run(
    engine: &mut dyn Engine,
    tracker: &LiveTracker,
    settings: &SessionSettings,
    observe: &mut Observe<'_>,
    display: &mut dyn Display,
    lock: &mut dyn SwapLock,
) -> Result<SessionReport, SessionError> {
    if let (FrameBudget::Paper | FrameBudget::PaperScaled, None) = (settings.budget, settings.table)
    {
        return Err(SessionError::NotInTable(settings.budget));
    }
    let first = match settings.budget {
        // Which samples have come by now depends on the clock, and must change no frame.
        FrameBudget::Steps(_) => *tracker.home(),
        _ => tracker.latch(tracker.now()).estimate,
    };
    // The gaze may not have come yet, and will: the field is not widened for that.
    let first = Look {
        widen: 0.0,
        ..Look::from(&first)
    };
    let mut eyes = Vec::new();
    observe(&first, &mut eyes);
    let period = Duration::from_secs_f64(1.0 / f64::from(settings.hz.max(1)));
    let governor = match settings.budget {
        FrameBudget::Off => Governor::idle(),
        _ if engine.moves() => Governor::default().forgetful(),
        _ => Governor::default(),
    };
    let mut session = Session {
        engine,
        observe,
        display,
        eyes,
        settings,
        lock,
        order: 0,
        time: 0.0,
        time_at: 0,
        place: RoomPlace::START,
        nominal: period,
        governor,
        pacing: Pacing::new(period),
        other_time: Duration::ZERO,
        steps: Histogram::new_with_bounds(1, MOST_STEPS, 3).ok(),
        spent: Shares::new(),
        needed: Shares::new(),
        report: SessionReport::default(),
        rung: 0,
    };
    if session.display.waits() {
        session.pacing.keep_lead();
    }
    // Measures before anything is shown.
    if settings.budget == FrameBudget::PaperScaled {
        session.report.plain_seconds = Some(session.plain(&first)?);
    }
    session.warm_up(&first)?;
    session.play(tracker)?;
    session.compare()?;
    session.lock.end()?;
    let (mut report, steps) = (session.report, session.steps);
    report.waits = session.lock.waits().cloned();
    report.median_steps = steps.map_or(0, |steps| steps.value_at_quantile(0.5));
    report.spent_share = session.spent.median();
    report.needed_share = session.needed.median();
    Ok(report)
}

/// Renders a share of what another machine orders, until that ends the session.
///
/// # Errors
/// A machine that is silent; a frame that cannot be rendered.
pub fn follow(
    engine: &mut dyn Engine,
    observe: &mut Observe<'_>,
    display: &mut dyn Display,
    lock: &mut dyn SwapLock,
) -> Result<(), SessionError> {
    let mut eyes = Vec::new();
    while let Some(order) = lock.obey()? {
        observe(&order.look, &mut eyes);
        let (done, _) = render_order(engine, &eyes, &order)?;
        let is_shown = order.purpose == Purpose::Shown;
        if is_shown {
            display.prepare(engine);
        }
        lock.gather(&done)?;
        if is_shown {
            lock.swap(order.frame)?;
            let agreed = Instant::now();
            let refresh = display.present(engine, &order, &eyes, agreed);
            lock.note_shown(refresh.map(|refresh| refresh.shown.saturating_duration_since(agreed)));
        }
    }
    Ok(())
}

fn render_order(
    engine: &mut dyn Engine,
    eyes: &[Observer],
    order: &Order,
) -> Result<(FrameResult, Rendered), RenderError> {
    let plain: Vec<_>;
    let mut eyes = eyes;
    if order.purpose == Purpose::Plain {
        let without_detail = eyes.iter().map(|one| Observer {
            ahead: one.forward(),
            ..Observer::new(one.eye, one.place)
        });
        plain = without_detail.collect();
        eyes = &plain;
    }
    let Decision {
        steps, whole_fovea, ..
    } = order.decision;
    engine.set_time(order.time)?;
    engine.set_place(&order.place);
    let rendered = engine.render_frame(eyes, order.decision.quality(), steps, whole_fovea)?;
    let done = FrameResult {
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

struct Session<'s> {
    engine: &'s mut dyn Engine,
    observe: &'s mut Observe<'s>,
    display: &'s mut dyn Display,
    eyes: Vec<Observer>,
    settings: &'s SessionSettings,
    lock: &'s mut dyn SwapLock,
    order: u64,
    /// Seconds of the scene's animations at the next frame, and its refresh.
    time: f64,
    time_at: u64,
    /// Where the viewer has flown.
    place: RoomPlace,
    /// The refresh that the settings name. A budget of one is one of the display's.
    nominal: Duration,
    governor: Governor,
    pacing: Pacing,
    /// The mean time of recent frames besides tracing; frames that were held up count little.
    other_time: Duration,
    steps: Option<Histogram<u64>>,
    spent: Shares,
    /// The need of a frame of full quality as a part of the budget's steps.
    needed: Shares,
    report: SessionReport,
    rung: usize,
}

impl Session<'_> {
    fn allowance(&self, forward: Vec3) -> Allowance {
        let seconds = |seconds: f64| Allowance::Time(Duration::from_secs_f64(seconds));
        match (self.settings.budget, self.settings.table) {
            (FrameBudget::Steps(steps), _) => {
                Allowance::Steps(steps / self.lock.share().ranks() as u64)
            }
            (FrameBudget::Time(time), _) if time == self.nominal => {
                Allowance::Time(self.pacing.period)
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

    /// Returns the line of sight of a look; `None` where no eye's detail follows it.
    fn gaze(&self, look: &Look) -> Option<Vec3> {
        let mut eyes = self.eyes.iter();
        let follows = eyes.any(|eye| eye.lod.is_some() || eye.foveation.is_some());
        follows.then_some(look.forward)
    }

    /// Returns the refreshes that a frame's budget lasts. 1 % slack does not count as another
    /// refresh.
    fn refreshes(&self) -> u64 {
        match self.report.allowance {
            Allowance::Time(time) => {
                let part = time.as_secs_f64() / self.pacing.period.as_secs_f64();
                ((part - 0.01).ceil() as u64).max(1)
            }
            Allowance::Unlimited | Allowance::Steps(_) => 1,
        }
    }

    fn tracing_allowance(&self) -> Allowance {
        match self.report.allowance {
            Allowance::Time(time) => {
                let time = time.min(self.pacing.time(self.refreshes()));
                Allowance::Time(time.saturating_sub(self.other_time))
            }
            other => other,
        }
    }

    fn next(&mut self, look: &Look, decision: &Decision, purpose: Purpose) -> Order {
        let frame = self.order;
        self.order += 1;
        let (look, decision) = (*look, *decision);
        Order {
            frame,
            time: self.time,
            place: self.place,
            look,
            decision,
            purpose,
        }
    }

    /// Renders a frame on all machines; returns the sums of all and the slowest one's cost.
    fn render(
        &mut self,
        look: &Look,
        decision: &Decision,
        purpose: Purpose,
    ) -> Result<(Rendered, FrameResult, FrameCost, Order), SessionError> {
        let begun = Instant::now();
        let order = self.next(look, decision, purpose);
        self.lock.order(&order)?;
        let (done, mut rendered) = render_order(self.engine, &self.eyes, &order)?;
        if purpose == Purpose::Shown {
            self.display.prepare(self.engine);
        }
        let gathered = self.lock.gather(&done)?;
        if self.lock.share().ranks() > 1 || self.display.waits() {
            rendered.done = Instant::now();
        }
        let traced = rendered.done - begun;
        if purpose == Purpose::Shown {
            self.report.last = Some(order);
            self.record_spent(gathered.slowest.steps, traced);
        }
        self.pacing.learn(traced);
        // Time besides tracing must not count as steps: short frames would seem slow. Nor does
        // the time to replace unfinished pixels: it would leave less for tracing, and so more
        // pixels unfinished.
        let slowest = &gathered.slowest;
        let other_time = traced.saturating_sub(slowest.tracing + rendered.giving_up);
        let other_time = other_time.min(self.other_time * 2 + HELD_UP);
        self.other_time = (self.other_time * 15 + other_time) / 16;
        let cost = FrameCost {
            steps: slowest.steps,
            seconds: slowest.tracing.as_secs_f64(),
        };
        self.governor.learn(decision, slowest.need, cost);
        if let (Purpose::Shown, Some(steps)) = (purpose, decision.steps) {
            let need = self.governor.full_need();
            self.needed.record(need / steps.max(1) as f64);
        }
        Ok((rendered, gathered.all, cost, order))
    }

    fn record_spent(&mut self, steps: u64, time: Duration) {
        let share = match self.report.allowance {
            Allowance::Unlimited => return,
            Allowance::Steps(allowed) => steps as f64 / allowed as f64,
            Allowance::Time(allowed) => time.as_secs_f64() / allowed.as_secs_f64(),
        };
        self.spent.record(share);
    }

    /// Renders the last frame again on all machines without a limit, to compare it with one.
    fn compare(&mut self) -> Result<(), SessionError> {
        let last = self.report.last.filter(|_| self.lock.share().ranks() > 1);
        let Some(last) = last else {
            return Ok(());
        };
        let order = Order {
            frame: self.order,
            decision: Decision {
                steps: None,
                ..last.decision
            },
            purpose: Purpose::Compared,
            ..last
        };
        (self.observe)(&order.look, &mut self.eyes);
        self.lock.order(&order)?;
        let (done, _) = render_order(self.engine, &self.eyes, &order)?;
        self.report.hashes = self.lock.gather(&done)?.all.hashes;
        Ok(())
    }

    fn play(&mut self, tracker: &LiveTracker) -> Result<(), SessionError> {
        self.pacing.begin(Instant::now());
        let mut keep_going = !self.display.is_over();
        while keep_going && self.settings.frames != Some(self.report.frames) {
            let schedule = self.pacing.schedule();
            if self.settings.latch == Latch::Late {
                wait_until(schedule.begin, tracker);
            }
            let latched = tracker.latch(tracker.at(schedule.display));
            let look = Look::from(&latched.estimate).towards(self.display.gaze());
            if !(self.observe)(&look, &mut self.eyes) {
                self.report.blind_frames += 1;
            }
            self.report.allowance = self.allowance(look.forward);
            self.report.record_part();
            self.governor.follow(self.gaze(&look));
            let decision = self.governor.decide(self.tracing_allowance());
            let due = self.pacing.next + self.refreshes() - 1;
            // A shorter budget may be due before the last one was.
            let since = (due as f64 - self.time_at as f64) * self.pacing.period.as_secs_f64();
            self.time = if let FrameBudget::Steps(_) = self.settings.budget {
                // Steps give the same frames, whatever the clock says.
                self.report.frames as f64 * self.nominal.as_secs_f64()
            } else {
                self.time + since
            };
            let steering = tracker.steering().with(&self.display.steering());
            let flight = &self.settings.flight;
            let place = self.place.flown(flight, &steering, &look.head, since);
            if std::mem::replace(&mut self.place, place) != place {
                // What frames needed from elsewhere says little.
                self.governor.forget();
            }
            self.time_at = due;
            let (rendered, all, _, order) = self.render(&look, &decision, Purpose::Shown)?;
            let shown = self.pacing.shown(rendered.done);
            if !self.display.waits() {
                sleep_until(self.pacing.at(shown));
            }
            self.lock.swap(self.order - 1)?;
            // Waiting for other machines misses refreshes, too.
            let shown = self.pacing.shown_late(shown, Instant::now());
            let now = Instant::now();
            // Machines agree on the time at which all are done.
            let at = match self.lock.share().ranks() {
                1 => self.pacing.at(shown).max(now),
                _ => now,
            };
            let possible = self.pacing.shown(now);
            let refresh = self.display.present(self.engine, &order, &self.eyes, at);
            let after = refresh.map(|refresh| refresh.shown.saturating_duration_since(now));
            self.lock.note_shown(after);
            let (shown, present) = match refresh {
                Some(refresh) => {
                    let number = self.pacing.follow(refresh);
                    self.pacing.learn_lead(number > possible);
                    (number.max(shown), refresh.shown)
                }
                None => (shown, Instant::now()),
            };
            let at = |instant| tracker.at(instant).0;
            let (done_us, record) = (
                at(rendered.done),
                self.record(&latched, &look, &decision, &all),
            );
            let took = done_us.saturating_sub(record.latch_us);
            let record = FrameRecord {
                due_us: at(self.pacing.at(due)),
                due_refresh: due,
                refresh: shown,
                first_ray_us: at(rendered.first_ray),
                done_us,
                present_us: at(present),
                late: shown > due,
                over_time: record.budget_us.is_some_and(|budget| took > budget),
                ..record
            };
            self.report.count(&record);
            self.report.quality_changes += u64::from(record.rung != self.rung);
            self.rung = record.rung;
            if let Some(steps) = &mut self.steps {
                steps.saturating_record(record.steps);
            }
            keep_going = self.display.after(&record);
            self.pacing.advance(shown, Instant::now());
        }
        self.report.seconds = self.pacing.elapsed(Instant::now()).as_secs_f64();
        Ok(())
    }

    /// Returns the record of a frame without its refresh and the times after the gaze.
    fn record(
        &mut self,
        latched: &LatchedGaze,
        look: &Look,
        decision: &Decision,
        all: &FrameResult,
    ) -> FrameRecord {
        self.report.samples = latched.samples;
        self.report.passed_over_samples = latched.passed_over;
        let ranks = self.lock.share().ranks() as u64;
        let budget = match self.report.allowance {
            Allowance::Time(time) => Some(time.as_micros() as u64),
            Allowance::Unlimited | Allowance::Steps(_) => None,
        };
        FrameRecord {
            frame: self.report.frames,
            sample_us: latched.sample.map(|time| time.0),
            arrive_us: latched.arrive.map(|time| time.0),
            latch_us: latched.latch.0,
            place: self.place.position.extend(self.place.yaw).to_array(),
            position: look.position.to_array(),
            forward: look.forward.to_array(),
            state: latched.estimate.state.name(),
            follows_gaze: latched.follows,
            budget_us: budget,
            budget_steps: decision.steps.map(|steps| steps * ranks),
            steps: all.steps,
            need_steps: all.need,
            rung: decision.rung,
            tiles: all.tiles,
            unfinished_tiles: all.unfinished,
            unfinished_fovea: all.unfinished_fovea,
            ..FrameRecord::default()
        }
    }
}

/// Systems wake up to some tenths of a millisecond late: that much is spun.
const SPIN: Duration = Duration::from_micros(300);

/// Waits until a time, or until the last sample that is expected before it.
fn wait_until(time: Instant, tracker: &LiveTracker) {
    let asleep = time.checked_sub(SPIN).unwrap_or(time);
    if !tracker.wait(asleep) {
        sleep_until(time);
    }
}

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
