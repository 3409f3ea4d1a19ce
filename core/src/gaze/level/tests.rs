use super::*;
use core::f32::consts::FRAC_PI_2;

/// Returns a gaze along the axes, free of rounding: right, up and back are x, y and z.
fn front() -> Gaze {
    let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
    Gaze::new(sight, VisualField::PAPER)
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

/// Returns narrow, wide, flat and uneven fields; fewer under Miri, which is slow.
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
                // From patches of half the view to nearly a point.
                let size = 0.5f32.powi(number % 12);
                let (right, down) = (vector() * size, vector() * size);
                let first = if number % 3 == 0 {
                    // Around the line of sight.
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
}

#[test]
fn regions_of_what_has_no_direction_are_not_known() {
    for bad in [0.0, 1.0e-30, 1.0e30, f32::NAN, f32::INFINITY] {
        let corner = Vec3::NEG_Z;
        let corners = [corner, corner, corner, corner * bad];
        assert_eq!(front().region_between(&corners), Region::Mixed, "{bad}");
    }
}
