//! The budget of a frame: time, steps, or the paper's seconds.

use crate::scene::builtin::PaperScene;
use glam::Vec3;
use std::fmt;
use std::str::FromStr;
use std::time::Duration;
use thiserror::Error;

/// The budget of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameBudget {
    /// No limit: nothing is left out.
    Off,
    /// A number of steps: the same gazes give the same frames on every machine.
    Steps(u64),
    /// A time.
    Time(Duration),
    /// The paper's seconds (Table 2) for its scene and the state nearest to the gaze.
    Paper,
    /// This machine's time without level of detail times the paper's ratio of its times with
    /// and without, interpolated between the states by the angle of the gaze.
    PaperScaled,
}

/// The error for a text that is not a budget: what is wrong, and what to give.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct BudgetError(String);

pub(super) const MOST_STEPS: u64 = 1_000_000_000_000;

impl FromStr for FrameBudget {
    type Err = BudgetError;

    fn from_str(text: &str) -> Result<Self, BudgetError> {
        match text {
            "off" => return Ok(Self::Off),
            "paper" => return Ok(Self::Paper),
            "paper-scaled" => return Ok(Self::PaperScaled),
            _ => {}
        }
        let unknown = || {
            let give = "give off, paper, paper-scaled, 33ms or 2000000steps";
            BudgetError(format!("\"{text}\" is not a budget: {give}"))
        };
        let out_of_range = || {
            let give = format!("give 0.1ms to 60000ms, or 1steps to {MOST_STEPS}steps");
            BudgetError(format!("{text} is out of range: {give}"))
        };
        if let Some(number) = text.strip_suffix("steps") {
            let steps: u64 = number.trim().parse().map_err(|_| unknown())?;
            let known = (1..=MOST_STEPS).contains(&steps);
            return known.then_some(Self::Steps(steps)).ok_or_else(out_of_range);
        }
        if let Some(number) = text.strip_suffix("ms") {
            let milliseconds: f64 = number.trim().parse().map_err(|_| unknown())?;
            if !(0.1..=60_000.0).contains(&milliseconds) {
                return Err(out_of_range());
            }
            return Ok(Self::Time(Duration::from_secs_f64(milliseconds * 1.0e-3)));
        }
        Err(match text.parse::<f64>() {
            Ok(_) => BudgetError(format!("{text} has no unit: give {text}ms or {text}steps")),
            Err(_) => unknown(),
        })
    }
}

impl fmt::Display for FrameBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Steps(steps) => write!(f, "{steps}steps"),
            // To the microsecond.
            Self::Time(time) => write!(f, "{}ms", (time.as_secs_f64() * 1.0e6).round() / 1.0e3),
            Self::Paper => f.write_str("paper"),
            Self::PaperScaled => f.write_str("paper-scaled"),
        }
    }
}

/// A row of the paper's Table 2: seconds a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table2 {
    /// The scene.
    pub scene: PaperScene,
    /// Seconds with level of detail: the viewer looks at the front wall (state 1) and at the
    /// floor (state 2).
    pub lod: [f64; 2],
    /// Seconds without level of detail.
    pub plain: f64,
}

impl Table2 {
    /// All rows.
    pub const ROWS: [Self; 4] = [
        Self::row(PaperScene::A, [2.078, 0.751], 1.641),
        Self::row(PaperScene::B, [1.109, 0.547], 0.969),
        Self::row(PaperScene::C, [0.859, 0.243], 0.875),
        Self::row(PaperScene::D, [0.484, 0.203], 0.532),
    ];

    const fn row(scene: PaperScene, lod: [f64; 2], plain: f64) -> Self {
        Self { scene, lod, plain }
    }

    /// Returns the row of a scene.
    pub fn for_scene(scene: PaperScene) -> Option<Self> {
        Self::ROWS.into_iter().find(|row| row.scene == scene)
    }

    /// Returns the place of a line of sight between state 1 and state 2, 0 to 1, by its angles to
    /// both.
    fn between(forward: Vec3) -> f64 {
        let angle = |state: Vec3| f64::from(forward.angle_between(state));
        let (front, floor) = (angle(Vec3::NEG_Z), angle(Vec3::NEG_Y));
        if front + floor > 0.0 {
            front / (front + floor)
        } else {
            0.0
        }
    }

    /// Returns the paper's seconds for the state nearest to a line of sight.
    pub fn seconds(&self, forward: Vec3) -> f64 {
        let [front, floor] = self.lod;
        if Self::between(forward) <= 0.5 {
            front
        } else {
            floor
        }
    }

    /// Returns the ratio of the times with and without level of detail for a line of sight.
    pub fn part(&self, forward: Vec3) -> f64 {
        let [front, floor] = self.lod;
        let to = Self::between(forward);
        ((1.0 - to) * front + to * floor) / self.plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_read_as_they_are_written() {
        for (text, budget) in [
            ("off", FrameBudget::Off),
            ("paper", FrameBudget::Paper),
            ("paper-scaled", FrameBudget::PaperScaled),
            ("33ms", FrameBudget::Time(Duration::from_millis(33))),
            ("0.5ms", FrameBudget::Time(Duration::from_micros(500))),
            ("2000000steps", FrameBudget::Steps(2_000_000)),
        ] {
            assert_eq!(text.parse(), Ok(budget), "{text}");
            assert_eq!(budget.to_string(), text);
        }
        for (texts, says) in [
            ("33|2000000|1e6", "no unit"),
            (
                "0steps|0ms|-1ms|NaNms|infms|1e9ms|9000000000000steps",
                "out of range",
            ),
            ("|ms|steps|fast|-1steps|1.5steps", "not a budget"),
        ] {
            for text in texts.split('|') {
                let error = text.parse::<FrameBudget>().unwrap_err().to_string();
                assert!(error.contains(says), "{text}: {error}");
            }
        }
    }

    #[test]
    fn the_papers_states_are_met() {
        for row in Table2::ROWS {
            let [front, floor] = row.lod;
            let states = [Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X].map(|state| row.seconds(state));
            assert_eq!(states, [front, floor, front]);
            let between = (Vec3::NEG_Z + Vec3::NEG_Y).normalize();
            for (state, seconds) in [
                (Vec3::NEG_Z, front),
                (Vec3::NEG_Y, floor),
                (between, 0.5 * (front + floor)),
            ] {
                assert!((row.part(state) - seconds / row.plain).abs() < 1e-6);
            }
        }
    }
}
