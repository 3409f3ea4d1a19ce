use super::*;
use std::f64::consts::FRAC_1_SQRT_2;

fn sampled(track: &Track, time: f64) -> [f64; 4] {
    let mut value = [0.0; 4];
    track.sample(time, &mut value[..track.property().width()]);
    value
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64]) {
    let mut errors = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(
        errors.all(|error| error < 1.0e-12),
        "{found:?}, not {expected:?}"
    );
}

#[test]
fn tracks_have_their_closed_forms_at_keys_and_between() {
    let times = || vec![1.0, 3.0];
    let values = vec![0.0, 0.0, 1.0, 4.0, 2.0, 1.0];
    let track =
        |interpolation, values| Track::new(Property::Position, interpolation, times(), values);
    let step = track(Interpolation::Step, values.clone()).unwrap();
    let linear = track(Interpolation::Linear, values.clone()).unwrap();
    for (time, of_step, of_linear) in [
        (0.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (2.5, 0.0, 3.0),
        (3.0, 4.0, 4.0),
        (9.0, 4.0, 4.0),
    ] {
        assert_near(&sampled(&step, time)[..1], &[of_step]);
        assert_near(&sampled(&linear, time)[..1], &[of_linear]);
    }
    // Cubics go through cubics: x = t³ - t + 2 with its own slopes, and any line by `smooth`.
    let (x, slope) = (|t: f64| t * t * t - t + 2.0, |t: f64| 3.0 * t * t - 1.0);
    let key = |t| [slope(t), 0.0, 0.0, x(t), 0.0, 0.0, slope(t), 0.0, 0.0];
    let cubic = track(Interpolation::Cubic, [key(1.0), key(3.0)].concat()).unwrap();
    let line = Track::smooth(
        Property::Scale,
        vec![0.0, 1.0, 4.0],
        (0..3).flat_map(|i| [f64::from(i * i); 3]).collect(),
    );
    for time in [1.0, 1.25, 2.0, 3.0] {
        assert_near(&sampled(&cubic, time)[..1], &[x(time)]);
    }
    assert_near(&sampled(&line.unwrap(), 1.0)[..3], &[1.0; 3]);
    // A quarter turn the short way, whose end is written as the opposite quaternion.
    let ends = [0.0, 0.0, 0.0, 2.0, 0.0, -FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2];
    let slerp = Track::new(
        Property::Rotation,
        Interpolation::Linear,
        times(),
        ends.to_vec(),
    );
    let slerp = slerp.unwrap();
    for (time, degrees) in [(1.0, 0.0), (1.5, 22.5), (2.0, 45.0), (3.0, 90.0)] {
        let [x, y, z, w] = DQuat::from_rotation_y(f64::to_radians(degrees)).to_array();
        let [.., sign] = sampled(&slerp, time);
        assert_near(
            &sampled(&slerp, time),
            &[x, y, z, w].map(|c| c * sign.signum()),
        );
    }
    for (times, values, says) in [
        (vec![], vec![], "has no keys"),
        (
            vec![0.0, 2.0, 1.0],
            vec![0.0; 9],
            "key 2 at 1 s, and not at 2 s or later",
        ),
        (vec![f64::NAN], vec![0.0; 3], "key 0"),
        (
            vec![0.0],
            vec![0.0; 4],
            "has 4 numbers for its keys, which need 3",
        ),
        (vec![0.0], vec![0.0, f64::INFINITY, 0.0], "not finite"),
    ] {
        let track = Track::new(Property::Position, Interpolation::Step, times, values);
        let error = track.unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}
