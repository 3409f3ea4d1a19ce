//! Clocks of devices, and budgets.

use super::input::Inputs;
use super::{Case, Effort, Errors};
use glam::Vec3;
use shisen::bake::Baked;
use shisen::scene::builtin::prism;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, Outcome, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace,
};
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::{DeviceTime, Micros};

const TRUTH: &str = "when the simulated device measured";
const OFFSET: &str = "the device's time plus what the first sample lacked to its arrival";

pub(super) const CASES: &[Case] = cases! {
    ["of the time of a sample, milliseconds", TRUTH, OFFSET]:
    "clock-wraps", 1.5, |effort| of_devices(1_000, effort, wraps),
        "32-bit microseconds that start again at 0, once in 71 minutes, and drift by 50 ppm";
    ["of the time of a sample, two or more after the restart, milliseconds", TRUTH, OFFSET]:
    "clock-goes-backwards", 1.5, |effort| of_devices(1_100, effort, backwards),
        "a device that is restarted in the middle of its stream";
    ["how much newer or older than it is a sample was said to be, milliseconds",
     TRUTH,
     "the time of arrival"]:
    "clock-freezes", 1.5, |effort| of_devices(1_200, effort, freezes),
        "a device whose clock stands still while its samples come";
    ["steps spent beyond the budget", "0", "looking at the budget after each pixel"]:
    "budget-of-0", 0.0, budget_of_0,
        "a frame that has no time at all";
    ["pixels that differ from the picture in one go",
     "the same picture without a budget",
     "giving a pixel up where the call's steps are spent, and beginning it anew in the next"]:
    "budget-of-1-at-a-time", 0.0, budget_of_1,
        "a picture rendered one step a call: what is left undone, or done twice";
    ["pixels that differ from the picture without a budget",
     "the same picture without a budget",
     "counting down in an i32, where it is −1"]:
    "budget-of-u32-max", 0.0, budget_of_most,
        "the largest budget of 32 bits";
};

/// A device that measures every 4 ms and says so 2 to 3 ms later.
struct Device {
    inputs: Inputs,
    clock: ClockEstimator,
    /// The naive way's offset, from the first sample.
    offset: Option<i64>,
}

impl Device {
    fn new(seed: u64) -> Option<Self> {
        let config = ClockConfig {
            least_delay: Micros(2_000),
            ..ClockConfig::default()
        };
        Some(Self {
            inputs: Inputs::new(seed),
            clock: ClockEstimator::new(config).ok()?,
            offset: None,
        })
    }

    /// Returns both ways' times of a sample measured at `time` with the device time `shown`, and
    /// its arrival.
    fn stamp(&mut self, time: u64, shown: DeviceTime) -> [i64; 3] {
        let arrival = time + 2_000 + self.inputs.below(1_000) as u64;
        let mut sample = Sample::arrived(Micros(arrival));
        sample.device_time = Some(shown);
        let stamp = self.clock.stamp(&sample, &mut |_| {});
        let shown = shown.microseconds as i64;
        let offset = *self.offset.get_or_insert(arrival as i64 - shown);
        [stamp.time.0 as i64, shown + offset, arrival as i64]
    }
}

fn milliseconds(found: i64, time: u64) -> f64 {
    (found - time as i64) as f64 / 1_000.0
}

/// Gathers the largest errors of several devices.
fn of_devices(seed: u64, effort: Effort, check: fn(&mut Device, &mut Errors)) -> Option<Errors> {
    let mut worst = Errors::NONE;
    for seed in seed..seed + effort.of(50) as u64 {
        let mut device = Device::new(seed)?;
        check(&mut device, &mut worst);
    }
    Some(worst)
}

fn wraps(device: &mut Device, worst: &mut Errors) {
    // The wrap is 5 to 15 s away.
    let start = (1u64 << 32) - 5_000_000 - device.inputs.below(10_000_000) as u64;
    for i in 0..7_500u64 {
        let time = 1_000_000 + i * 4_000;
        let shown = start + (time as f64 * (1.0 + 50.0e-6)) as u64;
        let [ours, naive, _] = device.stamp(time, DeviceTime::micros_u32(shown as u32));
        worst.ours(milliseconds(ours, time));
        worst.naive(milliseconds(naive, time));
    }
}

fn backwards(device: &mut Device, worst: &mut Errors) {
    let restart = 1_000 + device.inputs.below(1_000) as u64;
    let again = device.inputs.below(2_000_000) as u64;
    let first = 60_000_000 + device.inputs.below(60_000_000) as u64;
    for i in 0..4_000u64 {
        let time = 1_000_000 + i * 4_000;
        let shown = if i < restart {
            first + i * 4_000
        } else {
            again + (i - restart) * 4_000
        };
        let [ours, naive, _] = device.stamp(time, DeviceTime::unwrapped(shown));
        // The first wrong time may be an outlier.
        if i < restart || i >= restart + 2 {
            worst.ours(milliseconds(ours, time));
            worst.naive(milliseconds(naive, time));
        }
    }
}

fn freezes(device: &mut Device, worst: &mut Errors) {
    let from = 1_000 + device.inputs.below(1_000) as u64;
    for i in 0..3_000u64 {
        let time = 1_000_000 + i * 4_000;
        // From then on it sends the same measurement again and again.
        let measured = 1_000_000 + i.min(from) * 4_000;
        let [ours, _, arrival] = device.stamp(time, DeviceTime::unwrapped(measured));
        worst.ours(milliseconds(ours, measured));
        worst.naive(milliseconds(arrival, measured));
    }
}

const SIDE: u32 = 40;

const WHOLE: Tile = Tile {
    x: 0,
    y: 0,
    width: SIDE,
    height: SIDE,
};

/// Glass before a wall: pixels of many rays.
fn baked() -> Option<Baked<8>> {
    Baked::new(&prism()).ok()
}

fn view() -> Option<View> {
    let step = 2.0 / SIDE as f32;
    let first = Vec3::new(-1.0 + 0.5 * step, 1.0 - 0.5 * step, -1.0);
    View::new(
        Vec3::ZERO,
        first,
        Vec3::X * step,
        Vec3::NEG_Y * step,
        [SIDE; 2],
    )
    .ok()
}

/// Renders in up to `calls` calls of `budget` steps; returns the pixels and the steps of the first
/// call.
fn render(budget: u64, calls: u64) -> Option<(Vec<Pixel>, u64)> {
    let (baked, view) = (baked()?, view()?);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let mut pixels = vec![Pixel::default(); (SIDE * SIDE) as usize];
    let mut workspace = Workspace::new();
    let mut job = TileJob::new(WHOLE);
    let mut first = None;
    for _ in 0..calls {
        let mut left = Budget::steps(budget);
        let outcome = job
            .render(&renderer, &view, &mut pixels, &mut left, &mut workspace)
            .ok()?;
        first.get_or_insert(workspace.statistics.steps);
        if outcome == Outcome::Finished {
            return Some((pixels, first?));
        }
    }
    Some((pixels, first?))
}

/// Returns the number of pixels that differ in a bit.
fn different(a: &[Pixel], b: &[Pixel]) -> f64 {
    let bits = |p: &Pixel| [p.red, p.green, p.blue, p.alpha].map(f32::to_bits);
    let unlike = a.iter().zip(b).filter(|(a, b)| bits(a) != bits(b));
    unlike.count() as f64
}

fn budget_of_0(_: Effort) -> Option<Errors> {
    let (_, steps) = render(0, 1)?;
    // The naive way looks after the first pixel that takes any.
    let spent = one_by_one()?.into_iter().map(|one| one.1);
    let spent = spent.into_iter().find(|&steps| steps > 0);
    Some(Errors::new(steps as f64, spent.unwrap_or(0) as f64))
}

fn one_by_one() -> Option<Vec<(Pixel, u64)>> {
    let (baked, view) = (baked()?, view()?);
    let renderer = Renderer::new(baked.scene(), Simd::detect(), Settings::default());
    let alone = |i: u32| {
        let mut workspace = Workspace::new();
        let tile = Tile {
            x: i % SIDE,
            y: i / SIDE,
            width: 1,
            height: 1,
        };
        let mut pixel = [Pixel::default()];
        let mut budget = Budget::UNLIMITED;
        let mut job = TileJob::new(tile);
        let outcome = job.render(&renderer, &view, &mut pixel, &mut budget, &mut workspace);
        (outcome == Ok(Outcome::Finished)).then_some((pixel[0], workspace.statistics.steps))
    };
    (0..SIDE * SIDE).map(alone).collect()
}

fn budget_of_1(_: Effort) -> Option<Errors> {
    let (whole, _) = render(u64::MAX, 1)?;
    let (in_steps, _) = render(1, u64::from(SIDE * SIDE) * 1_000)?;
    // Each call begins the first unfinished pixel, and gives it up if it takes more steps than
    // the call has.
    let mut begun = vec![Pixel::default(); whole.len()];
    let cheap = one_by_one()?.into_iter().take_while(|one| one.1 <= 1);
    for (place, (pixel, _)) in begun.iter_mut().zip(cheap) {
        *place = pixel;
    }
    Some(Errors::new(
        different(&whole, &in_steps),
        different(&whole, &begun),
    ))
}

fn budget_of_most(_: Effort) -> Option<Errors> {
    let (whole, _) = render(u64::MAX, 1)?;
    let (most, _) = render(u32::MAX.into(), 1)?;
    let mut drawn = vec![Pixel::default(); whole.len()];
    let mut left = u32::MAX as i32;
    for (place, (pixel, steps)) in drawn.iter_mut().zip(one_by_one()?) {
        if left <= 0 {
            break;
        }
        *place = pixel;
        left -= steps as i32;
    }
    Some(Errors::new(
        different(&whole, &most),
        different(&whole, &drawn),
    ))
}
