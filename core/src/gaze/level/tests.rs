use super::*;
use core::f32::consts::FRAC_PI_2;

fn gaze(direction: Vec3, up: Vec3) -> Gaze {
    let sight = LineOfSight::new(Vec3::ZERO, direction, up).unwrap();
    Gaze::new(sight, VisualField::PAPER)
}

/// Axes that round nothing: right, up and back are x, y and z.
fn front() -> Gaze {
    gaze(Vec3::NEG_Z, Vec3::Y)
}

#[test]
fn along_the_line_of_sight_all_is_there() {
    for z in [-1.0, -1.0e-45, -3.0e38] {
        let sight = front().sight(Vec3::new(0.0, -0.0, z)).unwrap();
        assert_eq!((sight.m_alpha, sight.m_beta, sight.l), (0.0, 0.0, 0.0));
        assert_eq!(sight.big_l, VisualField::PAPER.limits().right);
        assert_eq!((sight.level, sight.zone), (1.0, Zone::Central));
    }
}

#[test]
fn next_to_the_line_of_sight_the_boundary_is_known() {
    let limits = VisualField::PAPER.limits();
    for small in [1.0e-7, 1.0e-20, 1.0e-30, 1.0e-40] {
        for (direction, expected) in [
            (Vec3::new(small, 0.0, -1.0), limits.right),
            (Vec3::new(0.0, small, -1.0), limits.up),
            (Vec3::new(0.0, -small, -1.0), limits.down),
        ] {
            let sight = front().sight(direction).unwrap();
            assert!(
                (sight.big_l - expected).abs() < 5e-7,
                "{direction}: {sight:?}"
            );
            assert!(
                (sight.l / small - 1.0).abs() < 1e-3,
                "{direction}: {sight:?}"
            );
            assert_eq!((sight.level, sight.zone), (1.0, Zone::Central));
        }
    }
}

#[test]
fn what_has_no_direction_has_no_level() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let direction = Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(bad), Vec3::ONE);
            assert_eq!(front().level(direction), None);
            assert_eq!(front().sight(direction), None);
        }
    }
    assert_eq!(front().level(Vec3::ZERO), None);
    assert_eq!(front().level(-Vec3::ZERO), None);
}

#[test]
fn sides_and_halves_have_their_own_limits() {
    let limits = VisualFieldLimits {
        central: 0.1,
        up: 0.3,
        down: 0.4,
        left: 0.5,
        right: 0.6,
    };
    for boundary in [Boundary::Printed, Boundary::Ellipse] {
        let field = VisualField::new(limits, boundary).unwrap();
        let gaze = Gaze::new(front().line_of_sight(), field);
        for (x, y, limit) in [
            (0.0, 0.2, 0.3),
            (0.0, -0.2, 0.4),
            (-0.2, 0.0, 0.5),
            (0.2, 0.0, 0.6),
        ] {
            let sight = gaze.sight(Vec3::new(x, y, -1.0)).unwrap();
            assert!((sight.big_l - limit).abs() < 2e-7, "{sight:?}");
            let expected = (limit - 0.2f32.atan()) / (limit - 0.1);
            assert!((sight.level - expected).abs() < 1e-6, "{sight:?}");
        }
    }
}

#[test]
fn length_does_not_matter() {
    let gaze = gaze(Vec3::new(1.0, 2.0, -3.0), Vec3::new(0.1, 1.0, 0.2));
    let direction = Vec3::new(0.3, -0.75, -1.5);
    let sight = gaze.sight(direction).unwrap();
    assert_eq!(sight.zone, Zone::Peripheral);
    for power in (-120..=120).step_by(8) {
        assert_eq!(
            gaze.sight(direction * 2f32.powi(power)),
            Some(sight),
            "{power}"
        );
    }
}

/// Uses one combination of components in this many: Miri is slow.
const STEP: usize = if cfg!(miri) { 79 } else { 1 };

/// How many [`directions`] are.
const COUNT: usize = (13 * 13 * 13usize).div_ceil(STEP);

/// Directions that leave no lane, no length and no axis out.
fn directions() -> impl Iterator<Item = Vec3> {
    let components = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.37,
        -0.61,
        2.9,
        1.0e-3,
        1.0e-25,
        -1.0e-40,
        3.0e38,
        f32::NAN,
        f32::INFINITY,
    ];
    let of = move |i: usize| components[i % components.len()];
    let all = (0..COUNT).map(|i| i * STEP);
    all.map(move |i| Vec3::new(of(i), of(i / 13), of(i / 169)))
}

#[test]
fn lanes_are_the_scalar_form_bit_for_bit() {
    let gazes = [
        front(),
        gaze(Vec3::new(0.2, -0.9, 0.3), Vec3::X),
        Gaze::new(
            front().line_of_sight(),
            VisualField::PAPER.with_boundary(Boundary::Ellipse),
        ),
    ];
    let (mut x, mut y, mut z) = ([0.0; COUNT], [0.0; COUNT], [0.0; COUNT]);
    for (i, direction) in directions().enumerate() {
        [x[i], y[i], z[i]] = direction.to_array();
    }
    for gaze in gazes {
        for simd in [Simd::PORTABLE, Simd::detect()] {
            let mut levels = [f32::NAN; COUNT];
            gaze.levels_of_row(simd, &x, &y, &z, &mut levels);
            for (direction, level) in directions().zip(levels) {
                let expected = gaze.level(direction).unwrap_or(0.0);
                assert_eq!(level.to_bits(), expected.to_bits(), "{direction} {simd:?}");
            }
        }
    }
}

#[test]
fn rows_are_as_long_as_their_shortest_slice() {
    let ahead = [-1.0; 19];
    let mut levels = [0.5; 21];
    front().levels_of_row(Simd::detect(), &[0.0; 20], &[0.0; 30], &ahead, &mut levels);
    assert_eq!(levels[..19], [1.0; 19]);
    assert_eq!(levels[19..], [0.5; 2]);
}

fn field(central: f32, up: f32, down: f32, left: f32, right: f32) -> VisualField {
    let limits = VisualFieldLimits {
        central,
        up,
        down,
        left,
        right,
    };
    VisualField::new(limits, Boundary::Printed).unwrap()
}

/// Fields that are narrow, wide, flat and uneven; fewer under Miri, which is slow.
fn fields() -> impl Iterator<Item = VisualField> {
    let all = [
        VisualField::PAPER,
        field(1.0e-6, 2.0e-4, 3.0e-4, 4.0e-4, 5.0e-4),
        field(0.1, FRAC_PI_2, 1.0, PI, 0.5),
        field(1.2, 1.3, 1.56, 1.55, 1.571),
        field(0.2, 1.5, 0.3, 0.25, 0.3),
        field(0.5, 0.6, 0.7, 3.1, 3.0),
    ];
    all.into_iter().step_by(if cfg!(miri) { 5 } else { 1 })
}

#[test]
fn bands_change_no_bit() {
    // Fewer under Miri, which is slow.
    let steps = if cfg!(miri) { 1 } else { 400 };
    for field in fields() {
        for boundary in [Boundary::Printed, Boundary::Ellipse] {
            let gaze = Gaze::new(front().line_of_sight(), field.with_boundary(boundary));
            let check = |f: f32, r: f32, u: f32| {
                let components = [[f], [r], [u]];
                let [expected] = gaze.level_by_angles(Portable, components);
                let [found] = gaze.level_of_components(Portable, components);
                assert_eq!(found.to_bits(), expected.to_bits(), "{f} {r} {u}: {gaze:?}");
            };
            for i in 0..=steps {
                for j in 0..=steps {
                    let (yaw, pitch) = (i as f32 / steps as f32 * PI, j as f32 / steps as f32 * PI);
                    let (sin, cos) = (pitch - FRAC_PI_2).sin_cos();
                    check(yaw.cos() * cos, yaw.sin() * cos, sin);
                    check(yaw.cos() * cos, -yaw.sin() * cos, 0.01 * sin);
                }
                // What lies around the bands themselves.
                let Bands {
                    central,
                    above,
                    below,
                    behind,
                } = gaze.bands;
                let part = i as f32 / steps as f32;
                for nudge in [1.0 - 1.0e-3, 1.0 - 1.0e-7, 1.0, 1.0 + 1.0e-7, 1.0 + 1.0e-3] {
                    let radius = central.sqrt() * nudge;
                    check(1.0, radius * part.sqrt(), radius * (1.0 - part).sqrt());
                    check(1.0, part * 9.0, min(above, 1.0e12).sqrt() * nudge);
                    check(1.0, part * 9.0, -min(below, 1.0e12).sqrt() * nudge);
                    check(-1.0, behind.sqrt() * nudge, part * 9.0);
                }
                // What underflows when squared.
                let tiny = 2f32.powi(-((part * 148.0) as i32));
                check(tiny, 1.0, tiny * 0.7);
                check(-tiny, 1.0, tiny * 1.9);
                check(-tiny * 0.1, tiny, -1.0);
            }
        }
    }
}

#[test]
fn regions_hold_what_lies_between_their_corners() {
    let mut state = 1u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    let mut vector = move || Vec3::new(random(), random(), random());
    // Fewer under Miri, which is slow.
    let (count, side) = if cfg!(miri) { (2, 2) } else { (20_000, 6) };
    for field in fields() {
        for boundary in [Boundary::Printed, Boundary::Ellipse] {
            let gaze = Gaze::new(front().line_of_sight(), field.with_boundary(boundary));
            let mut found = [0; 4];
            for number in 0..count {
                // From patches of half the view to what is next to a point.
                let size = 0.5f32.powi(number % 12);
                let (right, down) = (vector() * size, vector() * size);
                let first = if number % 3 == 0 {
                    // About the line of sight.
                    Vec3::NEG_Z - (right + down) * 0.5 + vector() * 0.01
                } else {
                    vector()
                };
                let at = |x: f32, y: f32| first + right * x + down * y;
                let corners = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)];
                let region = gaze.region_between(&corners);
                found[match region {
                    Region::Central => 0,
                    Region::Traced(_) => 1,
                    Region::Outside => 2,
                    Region::Mixed => 3,
                }] += 1;
                for i in 0..=side {
                    for j in 0..=side {
                        let direction = at(i as f32 / side as f32, j as f32 / side as f32);
                        let level = gaze.level(direction).unwrap_or(0.0);
                        let holds = match region {
                            Region::Central => level == 1.0,
                            Region::Traced(part) => {
                                let (least, most) = gaze.levels_within(&part);
                                level > 0.0 && least <= level && level <= most
                            }
                            Region::Outside => level == 0.0,
                            Region::Mixed => true,
                        };
                        assert!(holds, "{region:?}, {level}: {corners:?}, {gaze:?}");
                    }
                }
            }
            let [_, traced, outside, mixed] = found;
            let met = mixed > 0 && traced + outside > 0;
            assert!(met || cfg!(miri), "{found:?} {gaze:?}");
        }
    }
    // The paper's field contains each region.
    let region = |x: f32, y: f32, size: f32| {
        let at = |right: f32, down: f32| Vec3::new(x + right * size, y - down * size, -1.0);
        front().region_between(&[at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)])
    };
    assert_eq!(region(-0.05, 0.05, 0.1), Region::Central);
    assert!(matches!(region(1.0, 0.05, 0.1), Region::Traced(_)));
    assert!(matches!(region(-0.05, -2.3, 0.1), Region::Traced(_)));
    assert_eq!(region(-0.05, 2.3, 0.1), Region::Outside);
    assert_eq!(region(-0.05, 9.0, 0.1), Region::Outside);
    assert!(matches!(region(0.5, 0.05, 0.2), Region::Traced(_)));
    assert_eq!(region(-0.05, 1.8, 0.2), Region::Mixed);
}

#[test]
fn regions_of_what_has_no_direction_are_not_known() {
    for bad in [0.0, 1.0e-30, 1.0e30, f32::NAN, f32::INFINITY] {
        let corner = Vec3::NEG_Z;
        let corners = [corner, corner, corner, corner * bad];
        assert_eq!(front().region_between(&corners), Region::Mixed, "{bad}");
    }
}
