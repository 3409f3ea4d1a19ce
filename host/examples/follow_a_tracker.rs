//! A budgeted loop: frames that follow a simulated tracker, none of which takes more
//! steps than it may.
//!
//! ```sh
//! cargo run --release -p shisen --example follow_a_tracker
//! ```
//!
//! For each frame the gaze is estimated for the time of display, the governor chooses
//! how good the frame is to be, and the engine renders it on all cores. All times are
//! simulated, so that it prints the same on every machine. `shisen run` does this with
//! real trackers and clocks.

use shisen::bake::{BakedScene, Layout};
use shisen::cave::{BuiltInCave, Cave, Eye, Viewer};
use shisen::live::{Allowance, FrameCost, Governor, Share, with_engine};
use shisen::render::{Observer, Options};
use shisen::scene::builtin::{PaperScene, paper_scene};
use shisen::scene::quadruped::quadruped;
use shisen_core::gaze::Acuity;
use shisen_tracker::estimate::{Estimate, EstimatorConfig, GazeEstimator};
use shisen_tracker::mock::{self, Tracker, TrackerConfig, ViewerConfig};
use shisen_tracker::time::Micros;
use std::error::Error;

/// Steps that a frame may take.
const BUDGET: u64 = 300_000;

fn main() -> Result<(), Box<dyn Error>> {
    let baked = BakedScene::new(
        &paper_scene(PaperScene::A, quadruped())?,
        None,
        Layout::Fast,
    )?;
    let room = Cave::built_in(BuiltInCave::ThreeWall, [96; 2])?;
    let viewer = mock::Viewer::new(ViewerConfig::default(), 7);
    let mut tracker = Tracker::new(TrackerConfig::default(), viewer, 7)?;
    let mut gaze = GazeEstimator::new(EstimatorConfig::default())?;
    let mut governor = Governor::default();

    // Detail as large as each eye sees it: coarse beside what it looks at.
    let eyes = |estimate: &Estimate| {
        let viewer = Viewer {
            pose: estimate.head,
            ..Viewer::default()
        };
        Eye::STEREO.map(|eye| {
            let sight = estimate.line_of_sight;
            Observer::foveated(
                eye,
                viewer.eye(eye),
                (sight, Acuity::GUENTER),
                estimate.widen,
            )
        })
    };
    let latency = TrackerConfig::default().latency;
    let first = eyes(&gaze.estimate(Micros(0), &mut |_| {}));
    let options = Options::default();
    with_engine(
        baked.scene(),
        &room,
        &first,
        &options,
        None,
        Share::ALL,
        |engine| {
            for frame in 1..=60 {
                let now = Micros(frame * 1_000_000 / 60);
                while tracker.next_time().after(latency) <= now {
                    let (measured, sample) = tracker.next_sample();
                    gaze.push(&sample, measured, &mut |_| {});
                }
                let shown = now.after(Micros::from_millis(16));
                let estimate = gaze.estimate(shown, &mut |_| {});
                let decision = governor.decide(Allowance::Steps(BUDGET));
                let done = engine.render(&eyes(&estimate), decision.quality(), decision.steps)?;
                let taken = FrameCost {
                    steps: done.steps,
                    seconds: done.tracing.as_secs_f64(),
                };
                governor.learn(&decision, done.need, taken);
                assert!(done.steps <= BUDGET);
                if frame % 10 == 0 {
                    let [x, y, z] = estimate.line_of_sight.forward().to_array();
                    println!(
                        "frame {frame}: looking along {x:.2} {y:.2} {z:.2}, quality {}, {} steps, \
                     {} of {} tiles unfinished",
                        decision.rung, done.steps, done.unfinished, done.tiles
                    );
                }
            }
            Ok(())
        },
    )?
}
