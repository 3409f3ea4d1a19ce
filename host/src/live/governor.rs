//! Chooses a quality that fits the budget before a frame begins.
//!
//! A frame is expected to need the most of the last few frames and of those whose gaze was at the
//! same place. Time becomes steps by the median rate of recent frames, less the constant cost of a
//! frame and recent delays. Quality falls at once as far as it has to, and rises by one rung after
//! a while with room for more, so that it does not flicker.

mod ladder;
mod places;
mod speed;

use super::quality::Quality;
use glam::Vec3;
use ladder::Ladder;
pub use speed::FrameCost;
use speed::Speed;
use std::time::Duration;

/// The part of a frame's time up to which delays are provided for.
const LONGEST_DELAY: f64 = 0.5;

/// The part of a frame's time kept for variation from frame to frame.
const MARGIN: f64 = 0.03;

/// A budget of steps that no frame reaches: it renders all of a quality, but only the part of a
/// capture that the quality renews.
const MORE_THAN_NEEDED: u64 = 1 << 50;

/// Frames for which the needs at a place are remembered where things move.
const MEMORY: u64 = 120;

/// Chooses qualities.
#[derive(Debug, Clone)]
pub struct Governor {
    governs: bool,
    /// Without and with a known gaze: without one, frames need more and have no field to narrow.
    ladders: [Ladder; 2],
    has_gaze: bool,
    pub(super) speed: Speed,
}

/// The budget and quality of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// The most steps; `None` without a limit.
    pub steps: Option<u64>,
    /// Whether the fovea is finished with more steps than that: where the steps are an
    /// estimate of a time, late is better than a hole where the viewer looks.
    pub whole_fovea: bool,
    /// The rung of [`Quality::LADDER`].
    pub rung: usize,
}

impl Decision {
    /// All of a frame without a limit.
    pub const FULL: Self = Self {
        steps: None,
        whole_fovea: false,
        rung: 0,
    };

    /// All of a frame of the best and of the least quality.
    pub const ENDS: [Self; 2] = [Self::whole(0), Self::whole(Quality::LADDER.len() - 1)];

    /// Returns the quality of its rung.
    pub fn quality(&self) -> &'static Quality {
        Quality::LADDER.get(self.rung).unwrap_or(&Quality::FULL)
    }

    const fn whole(rung: usize) -> Self {
        Self {
            steps: Some(MORE_THAN_NEEDED),
            whole_fovea: false,
            rung,
        }
    }
}

/// The budget of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Allowance {
    /// No limit.
    #[default]
    Unlimited,
    /// A number of steps.
    Steps(u64),
    /// A time.
    Time(Duration),
}

impl Governor {
    /// Returns a governor that never lowers quality.
    pub fn idle() -> Self {
        Self {
            governs: false,
            ..Self::default()
        }
    }

    /// Returns the same governor for a scene that moves: what frames needed at a place of the gaze
    /// is forgotten after a while.
    #[must_use]
    pub fn forgetful(mut self) -> Self {
        self.forget();
        self
    }

    /// Forgets what frames needed at a place of the gaze after a while from now on.
    pub(super) fn forget(&mut self) {
        for ladder in &mut self.ladders {
            ladder.forget_in(MEMORY);
        }
    }

    /// Decides for the next frame.
    pub fn decide(&mut self, allowance: Allowance) -> Decision {
        let steps = self.steps(allowance);
        if let (Some(steps), true) = (steps, self.governs) {
            self.ladder_mut().choose(steps as f64);
        }
        let rung = self.ladder().rung;
        // Without a gaze the least quality covers all walls.
        let is_time = matches!(allowance, Allowance::Time(_));
        let least = if is_time && self.has_gaze && self.governs {
            self.ladder().least()
        } else {
            0
        };
        Decision {
            steps: steps.map(|steps| steps.max(least)),
            whole_fovea: is_time,
            rung,
        }
    }

    fn steps(&self, allowance: Allowance) -> Option<u64> {
        match allowance {
            Allowance::Unlimited => None,
            Allowance::Steps(steps) => Some(steps),
            Allowance::Time(time) => {
                let time = time.as_secs_f64() * (1.0 - MARGIN);
                Some(self.speed.steps_in(time, LONGEST_DELAY * time))
            }
        }
    }

    /// Returns the steps of a frame of full quality, by the newest frames; 0 before the first.
    pub fn full_need(&self) -> f64 {
        self.ladder().best_need()
    }

    fn ladder(&self) -> &Ladder {
        &self.ladders[usize::from(self.has_gaze)]
    }

    fn ladder_mut(&mut self) -> &mut Ladder {
        &mut self.ladders[usize::from(self.has_gaze)]
    }

    /// Takes the next frame's line of sight in the room; `None` without a gaze.
    pub fn follow(&mut self, gaze: Option<Vec3>) {
        self.has_gaze = gaze.is_some();
        if let Some(forward) = gaze {
            self.ladder_mut().look(forward);
        }
    }

    /// Forgets the newest frames, which looked elsewhere.
    pub fn look_back(&mut self) {
        self.ladder_mut().forget_newest();
    }

    /// Returns all of a frame at the rung above, to learn its cost: quality may never rise to a
    /// guess.
    pub fn better(&self) -> Option<Decision> {
        let rung = self.ladder().rung.checked_sub(1);
        rung.filter(|_| self.governs).map(Decision::whole)
    }

    /// Returns all of a frame at this rung and its neighbours: their ratios differ from place to
    /// place.
    pub fn around(&self) -> impl Iterator<Item = Decision> + use<> {
        let rung = self.ladder().rung;
        let rungs = [Some(rung), rung.checked_sub(1), Some(rung + 1)];
        let known = rungs.into_iter().flatten();
        known
            .filter(|&rung| rung < Quality::LADDER.len())
            .map(Decision::whole)
    }

    /// Takes the rung above at once if there is room for it; returns whether there was.
    pub fn rise(&mut self, allowance: Allowance) -> bool {
        let steps = self.steps(allowance).filter(|_| self.governs);
        steps.is_some_and(|steps| self.ladder_mut().rise(steps as f64))
    }

    /// Learns from a frame: the steps that all of it would have taken, and its cost.
    pub fn learn(&mut self, decision: &Decision, need: u64, cost: FrameCost) {
        self.ladder_mut().learn(decision.rung, need as f64);
        self.speed.learn(cost);
    }
}

impl Default for Governor {
    /// Returns a governor that has seen no frame. It keeps the best quality without a limit.
    fn default() -> Self {
        Self {
            governs: true,
            ladders: [Ladder::new(), Ladder::new()],
            has_gaze: true,
            speed: Speed::UNKNOWN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ladder::FRAMES_TO_RISE;
    use super::*;

    const TRUE: [f64; Quality::LADDER.len()] = [
        1.0, 0.9, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.085, 0.07, 0.055, 0.04,
    ];

    /// Learns from a frame at a rung that is rendered whole.
    fn show(governor: &mut Governor, rung: usize, steps: u64) {
        let seconds = 1.0e-3;
        governor.learn(&Decision::whole(rung), steps, FrameCost { steps, seconds });
    }

    /// Plays frames of these needs at full quality; returns their rungs, and the short ones.
    fn play(
        governor: &mut Governor,
        steps: u64,
        needs: impl Iterator<Item = f64>,
    ) -> (Vec<usize>, Vec<usize>) {
        let (mut rungs, mut short) = (Vec::new(), Vec::new());
        for (frame, need) in needs.enumerate() {
            let decision = governor.decide(Allowance::Steps(steps));
            assert_eq!(decision.steps, Some(steps));
            let need = (need * TRUE[decision.rung]) as u64;
            if need > steps {
                short.push(frame);
            }
            let seconds = 1.0e-3;
            let steps = need.min(steps);
            governor.learn(&decision, need, FrameCost { steps, seconds });
            rungs.push(decision.rung);
        }
        (rungs, short)
    }

    fn constant(need: f64, frames: usize) -> impl Iterator<Item = f64> {
        std::iter::repeat_n(need, frames)
    }

    fn changes(rungs: &[usize]) -> usize {
        rungs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn half_of_the_need_is_met_and_quality_settles() {
        let mut governor = Governor::default();
        let (rungs, short) = play(&mut governor, 500_000, constant(1.0e6, 1_000));
        // Nothing was known of the first frame.
        assert!(short.len() <= 2, "{short:?}");
        let settled = &rungs[100..];
        assert!(changes(settled) <= 1, "{settled:?}");
        assert!(settled.iter().all(|rung| (5..=6).contains(rung)));
        // Enough steps leave quality alone, and far too few take the least.
        let (rungs, short) = play(&mut Governor::default(), 1_200_000, constant(1.0e6, 300));
        assert_eq!((short.len(), changes(&rungs), rungs[0]), (0, 0, 0));
        let (rungs, _) = play(&mut Governor::default(), 10, constant(1.0e6, 50));
        assert_eq!(rungs[49], Quality::LADDER.len() - 1);
        let (rungs, _) = play(&mut Governor::idle(), 10, constant(1.0e6, 50));
        assert!(rungs.iter().all(|&rung| rung == 0));
    }

    #[test]
    fn needs_that_vary_make_nothing_flicker() {
        let noise = |frame: u32| (f64::from(frame) * 1.7).sin() * 0.08;
        let needs = (0..2_000).map(|frame| 1.0e6 * (1.0 + noise(frame)));
        let (rungs, short) = play(&mut Governor::default(), 900_000, needs);
        assert!(short.len() <= 2, "{short:?}");
        assert!(changes(&rungs[100..]) <= 4, "{}", changes(&rungs[100..]));
    }

    #[test]
    fn quality_comes_back_rung_by_rung() {
        let needs = constant(4.0e6, 100).chain(constant(0.5e6, 500));
        let (rungs, _) = play(&mut Governor::default(), 1_000_000, needs);
        assert!(rungs[99] >= 5 && rungs[599] == 0, "{rungs:?}");
        assert!(rungs.windows(2).all(|pair| pair[1] + 1 >= pair[0]));
        let rises: Vec<usize> = (1..600).filter(|&at| rungs[at] < rungs[at - 1]).collect();
        let gaps = rises.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(gaps.min() >= Some(FRAMES_TO_RISE as usize), "{rises:?}");
    }

    /// A viewer who looks in turns where a frame needs little and where it needs much.
    #[test]
    fn what_was_seen_at_a_place_is_known_when_the_gaze_returns() {
        let mut governor = Governor::default();
        let mut rungs = Vec::new();
        for turn in 0..20 {
            let is_dear = turn % 2 == 1;
            governor.follow(Some(if is_dear { Vec3::NEG_Z } else { Vec3::X }));
            let need = if is_dear { 1.2e6 } else { 0.3e6 };
            let (played, short) = play(&mut governor, 600_000, constant(need, 60));
            // Nothing is known of the first turn, nor of the rung after it.
            assert!(short.is_empty() || turn == 1, "{turn}: {short:?}");
            rungs.push(played.into_iter().min());
        }
        // In between quality rises as far as there is time.
        assert!(rungs[10] < rungs[11], "{rungs:?}");
    }

    /// What was dear at a place has moved away while the viewer looked elsewhere.
    #[test]
    fn where_things_move_needs_are_forgotten() {
        let back = |mut governor: Governor| {
            for (gaze, need, frames) in [(Vec3::NEG_Z, 4.0e6, 60), (Vec3::X, 0.3e6, 400)] {
                governor.follow(Some(gaze));
                play(&mut governor, 600_000, constant(need, frames));
            }
            governor.follow(Some(Vec3::NEG_Z));
            play(&mut governor, 600_000, constant(0.3e6, 1)).0[0]
        };
        assert!(back(Governor::default()) > 3);
        assert_eq!(back(Governor::default().forgetful()), 0);
    }

    #[test]
    fn a_rung_that_did_not_fit_at_a_place_is_not_tried_there_again() {
        let mut governor = Governor::default();
        let steps = 500_000;
        let (mut short, mut rungs) = (Vec::new(), [0; 2]);
        for frame in 0..4_000_u32 {
            let is_steep = frame / 50 % 2 == 1;
            governor.follow(Some(if is_steep { Vec3::NEG_Z } else { Vec3::X }));
            let decision = governor.decide(Allowance::Steps(steps));
            // Above the seventh rung all is dear at one of the places.
            let times = if is_steep && decision.rung < 7 {
                2.5
            } else {
                1.0
            };
            let need = (1.0e6 * TRUE[decision.rung] * times) as u64;
            if need > steps {
                short.push(frame);
            }
            show(&mut governor, decision.rung, need);
            rungs[usize::from(is_steep)] = decision.rung;
        }
        assert!(short.iter().all(|&frame| frame < 1_000), "{short:?}");
        assert!(short.len() <= 8, "{short:?}");
        assert!(rungs[0] <= 6 && rungs[1] == 7, "{rungs:?}");
    }

    #[test]
    fn a_look_around_keeps_no_quality_down() {
        let mut governor = Governor::default();
        let (ahead, aside) = (Some(Vec3::NEG_Z), Some(Vec3::X));
        governor.follow(ahead);
        show(&mut governor, 13, 40_000);
        show(&mut governor, 12, 60_000);
        governor.ladder_mut().choose(1.0);
        governor.follow(aside);
        show(&mut governor, 13, 400_000);
        governor.follow(ahead);
        let allowance = Allowance::Steps(100_000);
        assert!(!governor.rise(allowance));
        governor.look_back();
        let around: Vec<usize> = governor.around().map(|decision| decision.rung).collect();
        assert_eq!(around, [13, 12]);
        assert_eq!(governor.better(), Some(Decision::whole(12)));
        assert!(governor.rise(allowance));
        assert_eq!(governor.decide(allowance).rung, 12);
        governor.follow(aside);
        assert_eq!(governor.decide(allowance).rung, 13);
        assert_eq!(Governor::idle().better(), None);
    }

    #[test]
    fn the_full_need_stays_near_what_the_best_rung_needed() {
        let mut governor = Governor::default();
        assert_eq!(governor.full_need(), 0.0);
        show(&mut governor, 0, 1_000_000);
        assert_eq!(governor.full_need(), 1.0e6);
        show(&mut governor, 13, 50_000);
        for (need, full) in [(10, 0.5e6), (1_000_000, 2.0e6)] {
            for _ in 0..20 {
                show(&mut governor, 13, need);
            }
            assert_eq!(governor.full_need(), full);
        }
    }

    #[test]
    fn a_gaze_that_is_lost_and_found_has_its_quality_back() {
        let mut governor = Governor::default();
        let mut play = |gaze, need| {
            governor.follow(gaze);
            let (rungs, short) = play(&mut governor, 1_300_000, constant(need, 100));
            (rungs[0], rungs[99], short.len())
        };
        let ahead = Some(Vec3::NEG_Z);
        assert_eq!(play(ahead, 1.0e6), (0, 0, 0));
        let (first, lost, short) = play(None, 4.0e6);
        assert!(first == 0 && lost > 5 && short == 1, "{lost} {short}");
        assert_eq!(play(ahead, 1.0e6), (0, 0, 0));
        assert_eq!(play(None, 4.0e6), (lost, lost, 0));
    }

    #[test]
    fn the_fovea_is_whole_where_time_is_too_short() {
        let mut governor = Governor::default();
        let tiny = Allowance::Time(Duration::from_micros(10));
        let last = Quality::LADDER.len() - 1;
        for (rung, need) in [(0, 1_000_000), (last, 40_000)] {
            let seconds = 1.0e-8 * need as f64;
            let cost = FrameCost {
                steps: need,
                seconds,
            };
            governor.learn(&Decision::whole(rung), need, cost);
        }
        let decision = governor.decide(tiny);
        assert!(decision.whole_fovea && decision.steps >= Some(40_000));
        assert_eq!(decision.rung, last);
        // Not without a gaze, and not for a budget of steps.
        governor.follow(None);
        assert!(governor.decide(tiny).steps < Some(10_000));
        governor.follow(Some(Vec3::NEG_Z));
        assert_eq!(governor.decide(Allowance::Steps(100)).steps, Some(100));
    }

    /// Frames take 1 ms for each 100,000 steps, and every tenth 3 ms more whatever its size. If
    /// that lowered the rate, each frame would get fewer steps than the one before.
    #[test]
    fn delays_do_not_feed_on_themselves() {
        let mut governor = Governor::default();
        let allowance = Allowance::Time(Duration::from_millis(16));
        let mut last = 0;
        for frame in 0..400u32 {
            let decision = governor.decide(allowance);
            let need = (8.0e6 * TRUE[decision.rung]) as u64;
            last = decision.steps.unwrap();
            let steps = need.min(last);
            let delay = if frame.is_multiple_of(10) {
                3.0e-3
            } else {
                0.0
            };
            let seconds = steps as f64 * 1.0e-8 + delay;
            governor.learn(&decision, need, FrameCost { steps, seconds });
        }
        assert!((1.15e6..1.3e6).contains(&(last as f64)), "{last}");
    }
}
