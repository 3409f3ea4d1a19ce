//! Which quality will fit, before a frame begins.
//!
//! What a frame will need is what the frames before it needed: the most of the
//! last few, and of those whose gaze was where its own is, at the quality they had,
//! times what the qualities are known to cost beside each other. Time becomes steps by
//! the rate of late, the median of it, less what every frame takes whatever its steps
//! are, and less what frames took longer than by that rate: not a part of their time, as
//! threads that are held up lose as much of a short frame as of a long one.
//! Quality falls at once, as far as it has to, and rises by one rung after a
//! while in which there was room for more; so it does not flicker.

mod ladder;
mod places;
mod speed;

use super::quality::Quality;
use glam::Vec3;
use ladder::Ladder;
use speed::Speed;
pub use speed::Taken;
use std::time::Duration;

/// The part of a time above which a delay is not provided for: no quality makes up for
/// that.
const LONGEST_DELAY: f64 = 0.5;

/// The part of a time that is kept for what changes from frame to frame.
const KEPT: f64 = 0.03;

/// Steps that no frame takes: with an end as far away as that a frame is all of its
/// quality, and no more, as the part of a capture that is taken anew is.
const MORE_THAN_NEEDED: u64 = 1 << 50;

/// Chooses qualities.
#[derive(Debug, Clone)]
pub struct Governor {
    /// Whether quality may be lowered at all.
    governs: bool,
    /// Of frames that follow a gaze.
    with_gaze: Ladder,
    /// Of those for a viewer of whom nobody knows where they look: these need more of
    /// everything, and have no field to be narrowed.
    without_gaze: Ladder,
    has_gaze: bool,
    speed: Speed,
}

/// What a frame may take and how good it is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// At most so many steps; `None` where there is no end.
    pub steps: Option<u64>,
    /// Whether what is looked at is finished all the same, with more steps: where these
    /// are what time is guessed to be, late is better than a hole where one looks.
    pub whole_fovea: bool,
    /// Which rung of [`Quality::LADDER`].
    pub rung: usize,
    /// That rung.
    pub quality: Quality,
}

impl Decision {
    /// All of a frame, whatever it takes.
    pub const FULL: Self = Self {
        steps: None,
        whole_fovea: false,
        rung: 0,
        quality: Quality::FULL,
    };

    /// All of a frame of the best quality, and all of one of the least, as frames are that
    /// have an end.
    pub const ENDS: [Self; 2] = [Self::whole(0), Self::whole(Quality::LADDER.len() - 1)];

    /// All of a frame of a rung.
    const fn whole(rung: usize) -> Self {
        Self {
            steps: Some(MORE_THAN_NEEDED),
            whole_fovea: false,
            rung,
            quality: Quality::LADDER[rung],
        }
    }
}

/// What a frame may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Allowance {
    /// Whatever it needs.
    Unlimited,
    /// So many steps.
    Steps(u64),
    /// So much time.
    Time(Duration),
}

impl Governor {
    /// One that knows nothing yet. Where nothing is limited it leaves quality as it
    /// is.
    pub fn new() -> Self {
        Self {
            governs: true,
            with_gaze: Ladder::new(),
            without_gaze: Ladder::new(),
            has_gaze: true,
            speed: Speed::UNKNOWN,
        }
    }

    /// One that never lowers quality.
    pub fn idle() -> Self {
        Self {
            governs: false,
            ..Self::new()
        }
    }

    /// For the next frame.
    pub fn decide(&mut self, allowance: Allowance) -> Decision {
        let steps = self.steps(allowance);
        if let (Some(steps), true) = (steps, self.governs) {
            self.ladder_mut().choose(steps as f64);
        }
        let rung = self.ladder().rung();
        // Late is better than a hole where one looks. Without a gaze the least quality is
        // of all walls.
        let is_time = matches!(allowance, Allowance::Time(_));
        let least = if is_time && self.has_gaze && self.governs {
            self.with_gaze.least()
        } else {
            0
        };
        Decision {
            steps: steps.map(|steps| steps.max(least)),
            whole_fovea: is_time,
            rung,
            quality: Quality::LADDER[rung],
        }
    }

    /// What is allowed, as steps.
    fn steps(&self, allowance: Allowance) -> Option<u64> {
        match allowance {
            Allowance::Unlimited => None,
            Allowance::Steps(steps) => Some(steps),
            Allowance::Time(time) => {
                let time = time.as_secs_f64() * (1.0 - KEPT);
                Some(self.speed.steps_in(time, LONGEST_DELAY * time))
            }
        }
    }

    /// Steps that a frame of full quality would take, by the newest frames; 0 where
    /// nothing is known.
    pub fn full_need(&self) -> f64 {
        self.ladder().of_best()
    }

    fn ladder(&self) -> &Ladder {
        if self.has_gaze {
            &self.with_gaze
        } else {
            &self.without_gaze
        }
    }

    fn ladder_mut(&mut self) -> &mut Ladder {
        if self.has_gaze {
            &mut self.with_gaze
        } else {
            &mut self.without_gaze
        }
    }

    /// Where the next frame's gaze goes, in the room; `None` where it follows none, while
    /// frames do at first. Where that changes, they have the quality that such frames had
    /// when there were some.
    pub fn follow(&mut self, gaze: Option<Vec3>) {
        self.has_gaze = gaze.is_some();
        if let Some(forward) = gaze {
            self.with_gaze.look(forward);
        }
    }

    /// The newest frames were a look around: what the next one needs is what is known of
    /// where its gaze is.
    pub fn look_back(&mut self) {
        self.with_gaze.forget_newest();
    }

    /// The rung above, whatever it takes, for a frame that nobody sees: as long as
    /// what it costs is a guess, it may be one that quality never rises above.
    pub fn better(&self) -> Option<Decision> {
        let rung = self.ladder().rung().checked_sub(1);
        rung.filter(|_| self.governs).map(Decision::whole)
    }

    /// This rung, the one above and the one below, whatever they take, for frames that
    /// nobody sees: what they take beside each other is not the same everywhere.
    pub fn around(&self) -> impl Iterator<Item = Decision> + use<> {
        let rung = self.ladder().rung();
        let rungs = [Some(rung), rung.checked_sub(1), Some(rung + 1)];
        let known = rungs.into_iter().flatten();
        known
            .filter(|&rung| rung < Quality::LADDER.len())
            .map(Decision::whole)
    }

    /// Takes the rung above at once where there is room for it; whether there was.
    pub fn rise(&mut self, allowance: Allowance) -> bool {
        let steps = self.steps(allowance).filter(|_| self.governs);
        steps.is_some_and(|steps| self.ladder_mut().rise(steps as f64))
    }

    /// What came of a decision: the steps that all of the frame would have taken, and
    /// what it took.
    pub fn learn(&mut self, decision: &Decision, need: u64, taken: Taken) {
        self.ladder_mut().learn(decision.rung, need as f64);
        self.speed.learn(taken);
    }

    /// What frames take whatever their steps are, from one of many steps and one of few.
    pub fn compare(&mut self, many: Taken, few: Taken) {
        self.speed.compare(many, few);
    }
}

impl Default for Governor {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::ladder::CALM;
    use super::*;

    /// What the rungs really cost.
    const TRUE: [f64; Quality::LADDER.len()] = [
        1.0, 0.9, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.085, 0.07, 0.055, 0.04,
    ];

    const fn taken(steps: u64, seconds: f64) -> Taken {
        Taken { steps, seconds }
    }

    /// Plays frames of such needs; rungs, and how many took more than there was.
    fn play(
        governor: &mut Governor,
        steps: u64,
        needs: impl Iterator<Item = f64>,
    ) -> (Vec<usize>, usize) {
        let (mut rungs, mut short) = (Vec::new(), 0);
        for need in needs {
            let decision = governor.decide(Allowance::Steps(steps));
            assert_eq!(decision.steps, Some(steps));
            let need = (need * TRUE[decision.rung]) as u64;
            short += usize::from(need > steps);
            governor.learn(&decision, need, taken(need.min(steps), 1.0e-3));
            rungs.push(decision.rung);
        }
        (rungs, short)
    }

    fn changes(rungs: &[usize]) -> usize {
        rungs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn half_of_the_need_is_met_and_quality_settles() {
        let mut governor = Governor::new();
        let (rungs, short) = play(&mut governor, 500_000, (0..1_000).map(|_| 1.0e6));
        // The first frame was not known.
        assert!(short <= 2, "{short}");
        let settled = &rungs[100..];
        assert!(changes(settled) <= 1, "{settled:?}");
        assert!(
            settled.iter().all(|&rung| (5..=6).contains(&rung)),
            "{settled:?}"
        );
    }

    #[test]
    fn all_of_the_need_leaves_quality_alone() {
        let mut governor = Governor::new();
        let (rungs, short) = play(&mut governor, 1_200_000, (0..300).map(|_| 1.0e6));
        assert_eq!((short, changes(&rungs), rungs[0]), (0, 0, 0));
    }

    #[test]
    fn needs_that_tremble_make_nothing_flicker() {
        let mut governor = Governor::new();
        let noise = |frame: u32| (f64::from(frame) * 1.7).sin() * 0.08;
        let needs = (0..2_000).map(|frame| 1.0e6 * (1.0 + noise(frame)));
        let (rungs, short) = play(&mut governor, 900_000, needs);
        assert!(short <= 2, "{short}");
        assert!(changes(&rungs[100..]) <= 4, "{}", changes(&rungs[100..]));
    }

    /// A viewer who looks from what needs little to what needs much, again and again.
    #[test]
    fn who_looks_back_finds_it_finished() {
        let mut governor = Governor::new();
        let steps = 600_000;
        let (mut short, mut rungs) = (Vec::new(), Vec::new());
        for frame in 0..1_200_u32 {
            let is_dear = frame / 60 % 2 == 1;
            let gaze = if is_dear { Vec3::NEG_Z } else { Vec3::X };
            governor.follow(Some(gaze));
            let decision = governor.decide(Allowance::Steps(steps));
            let of_best = if is_dear { 1.2e6 } else { 0.3e6 };
            let need = (of_best * TRUE[decision.rung]) as u64;
            if need > steps {
                short.push(frame);
            }
            governor.learn(&decision, need, taken(need.min(steps), 1.0e-3));
            rungs.push(decision.rung);
        }
        // The first time nobody knew, nor what the rung after it costs.
        assert!(short.iter().all(|&frame| frame < 65), "{short:?}");
        // In between quality rises, as far as there is time.
        let best = |dear: usize| rungs[600 + 60 * dear..660 + 60 * dear].iter().min();
        assert!(best(0) < best(1), "{:?} and {:?}", best(0), best(1));
    }

    /// What a better quality takes more than a worse one is not the same everywhere.
    #[test]
    fn what_did_not_fit_somewhere_is_not_tried_there_again() {
        let mut governor = Governor::new();
        let steps = 500_000;
        // Above the seventh rung all is dear where the viewer looks seldom.
        let need = |is_steep: bool, rung: usize| {
            let times = if is_steep && rung < 7 { 2.5 } else { 1.0 };
            (1.0e6 * TRUE[rung] * times) as u64
        };
        let (mut short, mut rungs) = (Vec::new(), [0; 2]);
        for frame in 0..4_000_u32 {
            let is_steep = frame / 50 % 2 == 1;
            governor.follow(Some(if is_steep { Vec3::NEG_Z } else { Vec3::X }));
            let decision = governor.decide(Allowance::Steps(steps));
            let need = need(is_steep, decision.rung);
            if need > steps {
                short.push(frame);
            }
            governor.learn(&decision, need, taken(need.min(steps), 1.0e-3));
            rungs[usize::from(is_steep)] = decision.rung;
        }
        assert!(short.iter().all(|&frame| frame < 1_000), "{short:?}");
        assert!(short.len() <= 8, "{short:?}");
        assert!(rungs[0] <= 6 && rungs[1] == 7, "{rungs:?}");
    }

    /// What other places have made of the ratios between rungs is no matter where these were
    /// seen.
    #[test]
    fn what_was_seen_here_counts_for_more_than_ratios_of_elsewhere() {
        let mut governor = Governor::new();
        let whole = Decision::whole;
        let seen = |governor: &mut Governor, gaze: Vec3, rung: usize, need: u64| {
            governor.follow(Some(gaze));
            governor.learn(&whole(rung), need, taken(need, 1.0e-3));
        };
        // Elsewhere the eighth rung takes five times as much as the ninth, here little more.
        for aside in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
            seen(&mut governor, aside, 0, 900_000);
            seen(&mut governor, aside, 9, 20_000);
            seen(&mut governor, aside, 8, 100_000);
        }
        seen(&mut governor, Vec3::NEG_Z, 8, 110_000);
        seen(&mut governor, Vec3::NEG_Z, 9, 83_000);
        // In all places there are, or have been, frames of the best rung take as much.
        assert!((governor.full_need() / 9.0e5 - 1.0).abs() < 0.01);
        governor.with_gaze.choose(100_000.0);
        assert_eq!(governor.decide(Allowance::Steps(250_000)).rung, 9);
        for _ in 0..CALM {
            seen(&mut governor, Vec3::NEG_Z, 9, 83_000);
            governor.decide(Allowance::Steps(250_000));
        }
        assert_eq!(governor.decide(Allowance::Steps(250_000)).rung, 8);
    }

    #[test]
    fn a_look_around_keeps_no_quality_down() {
        let mut governor = Governor::new();
        let (ahead, aside) = (Some(Vec3::NEG_Z), Some(Vec3::X));
        governor.follow(ahead);
        for (rung, need) in [(13, 40_000), (12, 60_000)] {
            governor.learn(&Decision::whole(rung), need, taken(need, 1.0e-3));
        }
        governor.with_gaze.choose(1.0);
        governor.follow(aside);
        let dear = 400_000;
        governor.learn(&Decision::whole(13), dear, taken(dear, 1.0e-3));
        governor.follow(ahead);
        let allowance = Allowance::Steps(100_000);
        assert!(!governor.rise(allowance));
        governor.look_back();
        assert!(governor.rise(allowance));
        assert_eq!(governor.decide(allowance).rung, 12);
        // There it still does not fit.
        governor.follow(aside);
        assert_eq!(governor.decide(allowance).rung, 13);
    }

    #[test]
    fn quality_comes_back_rung_by_rung() {
        let mut governor = Governor::new();
        let needs = (0..600).map(|frame| if frame < 100 { 4.0e6 } else { 0.5e6 });
        let (rungs, _) = play(&mut governor, 1_000_000, needs);
        assert!(rungs[99] >= 5, "{}", rungs[99]);
        assert_eq!(rungs[599], 0);
        for (frame, pair) in rungs.windows(2).enumerate() {
            assert!(
                pair[1] + 1 >= pair[0],
                "frame {frame} rises by more than one"
            );
        }
        let rises: Vec<usize> = (1..600).filter(|&at| rungs[at] < rungs[at - 1]).collect();
        assert!(
            rises
                .windows(2)
                .all(|pair| pair[1] - pair[0] >= CALM as usize),
            "{rises:?}"
        );
    }

    #[test]
    fn what_guesses_keep_quality_from_is_tried_before_anybody_looks() {
        // Rungs are cheaper than is known.
        let of_best = |rung: usize| TRUE[rung] * TRUE[rung];
        let allowance = Allowance::Steps(900_000);
        let begun = |climbs: bool| {
            let mut governor = Governor::new();
            governor.learn(&Decision::FULL, 1_000_000, taken(1_000_000, 1.0e-3));
            let seen = |governor: &mut Governor, decision: Decision| {
                let need = (1.0e6 * of_best(decision.rung)) as u64;
                governor.learn(&decision, need, taken(need, 1.0e-3));
            };
            let decision = governor.decide(allowance);
            seen(&mut governor, decision);
            while let Some(better) = governor.better().filter(|_| climbs) {
                seen(&mut governor, better);
                if !governor.rise(allowance) {
                    break;
                }
            }
            let begun = governor.decide(allowance).rung;
            for _ in 0..400 {
                let decision = governor.decide(allowance);
                assert!(of_best(decision.rung) <= 0.9, "it fits");
                assert!(decision.rung == begun || !climbs, "it stays");
                seen(&mut governor, decision);
            }
            governor.decide(allowance).rung
        };
        // That is the best that there is room to rise to.
        let room = |rung: usize| of_best(rung) <= 0.75 * 0.9;
        assert!(room(2) && !room(1));
        assert_eq!(begun(true), 2);
        // It is found out later on as well, where the guess is not too far off.
        assert_eq!(begun(false), 2);
        assert_eq!(Governor::idle().better(), None);
    }

    #[test]
    fn what_the_best_would_need_stays_near_what_it_needed() {
        let mut governor = Governor::new();
        assert_eq!(governor.full_need(), 0.0);
        governor.learn(&Decision::FULL, 1_000_000, taken(1_000_000, 1.0e-3));
        assert_eq!(governor.full_need(), 1.0e6);
        // Where there is nearly nothing to see for the least quality.
        let [_, least] = Decision::ENDS;
        governor.learn(&least, 50_000, taken(50_000, 1.0e-3));
        for _ in 0..20 {
            governor.learn(&least, 10, taken(10, 1.0e-3));
        }
        assert_eq!(governor.full_need(), 0.5e6);
        for _ in 0..20 {
            governor.learn(&least, 1_000_000, taken(1_000_000, 1.0e-3));
        }
        assert_eq!(governor.full_need(), 2.0e6);
    }

    #[test]
    fn what_is_around_a_rung_is_on_the_ladder() {
        let mut governor = Governor::new();
        let rungs = |governor: &Governor| -> Vec<usize> {
            governor.around().map(|decision| decision.rung).collect()
        };
        assert_eq!(rungs(&governor), [0, 1]);
        let (played, _) = play(&mut governor, 400_000, (0..50).map(|_| 1.0e6));
        let rung = played[49];
        assert_eq!(rungs(&governor), [rung, rung - 1, rung + 1]);
        play(&mut governor, 10, (0..50).map(|_| 1.0e6));
        let last = Quality::LADDER.len() - 1;
        assert_eq!(rungs(&governor), [last, last - 1]);
    }

    #[test]
    fn a_gaze_that_is_lost_and_found_has_its_quality_back() {
        let mut governor = Governor::new();
        let (rungs, _) = play(&mut governor, 1_300_000, (0..100).map(|_| 1.0e6));
        assert_eq!(rungs[99], 0);
        // All around the viewer there is more.
        governor.follow(None);
        let (rungs, short) = play(&mut governor, 1_300_000, (0..100).map(|_| 4.0e6));
        assert_eq!((rungs[0], short), (0, 1));
        assert!(rungs[99] > 5, "{rungs:?}");
        let lost = rungs[99];
        governor.follow(Some(Vec3::NEG_Z));
        let (rungs, short) = play(&mut governor, 1_300_000, (0..100).map(|_| 1.0e6));
        assert_eq!((changes(&rungs), rungs[0], short), (0, 0, 0));
        governor.follow(None);
        let (rungs, short) = play(&mut governor, 1_300_000, (0..10).map(|_| 4.0e6));
        assert_eq!((changes(&rungs), rungs[0], short), (0, lost, 0));
    }

    #[test]
    fn what_never_fits_gets_the_least() {
        let mut governor = Governor::new();
        let (rungs, _) = play(&mut governor, 10, (0..50).map(|_| 1.0e6));
        assert_eq!(rungs[49], Quality::LADDER.len() - 1);
        let mut idle = Governor::idle();
        let (rungs, _) = play(&mut idle, 10, (0..50).map(|_| 1.0e6));
        assert!(rungs.iter().all(|&rung| rung == 0));
    }

    /// Plays frames of a million steps that take so many seconds each.
    fn timed(seconds: impl Iterator<Item = f64>) -> Governor {
        let mut governor = Governor::new();
        let decision = governor.decide(Allowance::Unlimited);
        assert_eq!(decision.steps, None);
        for seconds in seconds {
            governor.learn(&decision, 1_000_000, taken(1_000_000, seconds));
        }
        governor
    }

    #[test]
    fn what_is_looked_at_is_whole_where_time_is_too_short() {
        let mut governor = timed((0..10).map(|_| 1.0e-2));
        let tiny = Allowance::Time(Duration::from_micros(10));
        let last = Quality::LADDER.len() - 1;
        let [_, least] = Decision::ENDS;
        governor.learn(&least, 40_000, taken(40_000, 4.0e-4));
        for _ in 0..10 {
            let decision = governor.decide(tiny);
            let need = (1.0e6 * TRUE[decision.rung]) as u64;
            assert!(decision.steps.is_some_and(|steps| steps >= need));
            assert_eq!(decision.rung, last);
            governor.learn(&decision, need, taken(need, 1.0e-8 * need as f64));
        }
        // Nobody knows where that would be; and steps are steps.
        governor.follow(None);
        assert!(governor.decide(tiny).steps < Some(10_000));
        governor.follow(Some(Vec3::NEG_Z));
        let few = governor.decide(Allowance::Steps(100));
        assert_eq!(few.steps, Some(100));
    }

    #[test]
    fn delays_do_not_feed_on_themselves() {
        // Frames take 1 ms for each 100,000 steps, and every tenth 3 ms more, whatever
        // their size. Where that made the rate, each frame would get fewer steps than
        // the one before.
        let mut governor = Governor::new();
        let allowance = Allowance::Time(Duration::from_millis(16));
        let mut last = 0;
        for frame in 0..400u32 {
            let decision = governor.decide(allowance);
            let need = (8.0e6 * TRUE[decision.rung]) as u64;
            let steps = need.min(decision.steps.unwrap());
            let delay = if frame.is_multiple_of(10) {
                3.0e-3
            } else {
                0.0
            };
            governor.learn(&decision, need, taken(steps, steps as f64 * 1.0e-8 + delay));
            last = decision.steps.unwrap();
        }
        assert!((1.15e6..1.3e6).contains(&(last as f64)), "{last}");
    }
}
