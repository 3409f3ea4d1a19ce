use super::*;
use shisen_tracker::estimate::EstimatorConfig;

/// A head that turns to and fro by 200° a second, eyes that rest on one place meanwhile, and
/// trackers that are 15 ms apart.
#[test]
fn a_head_that_turns_fast_is_met_in_time() {
    const TURN: f32 = std::f32::consts::FRAC_PI_6;
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut noise = |size: f32| size * Vec3::new(random(), random(), random());
    let mut measured = Vec::new();
    let target = Vec3::new(0.2, 0.1, -1.0).normalize();
    for step in 0..4_000_u64 {
        let now = Micros(4_000 * step);
        let angle = TURN * (3.490_659 / TURN * now.seconds()).sin();
        let mut sample = Sample::arrived(now);
        let turn = Quat::from_rotation_y(angle) * Quat::from_scaled_axis(noise(0.000_5));
        sample.head.position = Some(Reading::tracked(noise(0.000_2)));
        sample.head.orientation = Some(Reading::tracked(turn));
        let gaze = Quat::from_rotation_y(-angle) * target + noise(0.003);
        sample.combined.direction = Some(Reading::tracked(gaze.normalize()));
        measured.push(sample);
    }
    let median = |late: [Micros; 2]| {
        let config = EstimatorConfig::default();
        let mut viewer = ComposedGaze::new(GazeEstimator::new(config).unwrap());
        let mut arrivals = Vec::new();
        for sample in &measured {
            let at = sample.arrival;
            if late[0] == late[1] {
                arrivals.push((at.after(late[0]), Role::All, *sample));
            } else {
                let (mut head, mut gaze) = (*sample, *sample);
                head.combined = Eye::default();
                gaze.head = Head::default();
                arrivals.push((at.after(late[0]), Role::Head, head));
                arrivals.push((at.after(late[1]), Role::Gaze, gaze));
            }
        }
        arrivals.sort_by_key(|(at, ..)| *at);
        let mut errors = Vec::new();
        for (now, role, sample) in arrivals {
            viewer.push(role, &sample, sample.arrival, &mut |_| {});
            let estimate = viewer
                .estimator
                .estimate(now.after(Micros(5_000)), &mut |_| {});
            if now > Micros::from_millis(2_000) {
                let sight = estimate.line_of_sight.forward();
                errors.push(sight.angle_between(target).to_degrees());
            }
        }
        errors.sort_by(f32::total_cmp);
        errors[errors.len() / 2]
    };
    let [none, late] = [0, 15].map(Micros::from_millis);
    let one = median([late, late]);
    for apart in [[late, none], [none, late]] {
        let two = median(apart);
        println!("{apart:?}: {two:.4}°, one tracker {one:.4}°");
        assert!(
            two <= 0.3 && two <= 1.1 * one + 0.001,
            "{apart:?}: {two} {one}"
        );
    }
}
