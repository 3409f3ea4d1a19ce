//! Gazes of any numbers, for tests.

use super::{Boundary, Gaze, LineOfSight, VisualField, VisualFieldLimits};
use crate::hostile::{Numbers, finite, finite_or_error, is_unit, with_hostile_numbers};
use crate::simd::{Kernel, Lanes, Runs, Simd};
use glam::Vec3;
use std::vec::Vec;

/// Returns the paper's field straight ahead, and what the numbers make.
pub(crate) fn gazes(n: &mut Numbers) -> Vec<Gaze> {
    let ahead = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
    let mut gazes = Vec::from([Gaze::new(ahead, VisualField::PAPER)]);
    let sight = finite_or_error(LineOfSight::new(
        n.vector([0.0, 0.1, 0.0]),
        n.vector([0.1, 0.0, -1.0]),
        n.vector([0.0, 1.0, 0.1]),
    ));
    let limits = VisualFieldLimits {
        central: n.next(0.3),
        up: n.next(1.0),
        down: n.next(1.1),
        left: n.next(1.6),
        right: n.next(1.7),
    };
    let by = n.next(0.1);
    finite(&VisualField::PAPER.wider(by));
    for boundary in [Boundary::Ellipse, Boundary::Printed] {
        let field = finite_or_error(VisualField::new(limits, boundary));
        finite(&field.map(|field| field.wider(by)));
        gazes.extend(
            sight
                .zip(field)
                .map(|(sight, field)| Gaze::new(sight, field)),
        );
    }
    if let Some(sight) = sight {
        [sight.forward(), sight.right(), sight.up()]
            .iter()
            .for_each(is_unit);
    }
    gazes
}

/// The levels of eight directions.
struct Levels<'g>(&'g Gaze, [[f32; 8]; 3]);

impl Kernel<8> for Levels<'_> {
    type Output = [f32; 8];

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> [f32; 8] {
        l.store(self.0.levels(l, self.1.map(|axis| l.load(&axis))))
    }
}

#[test]
fn gazes_of_any_numbers_have_levels_from_0_to_1() {
    with_hostile_numbers(|n| {
        let direction = n.vector([0.1, 0.2, -1.0]);
        let [x, y, z] = [0.1, 0.2, -1.0].map(|usual| [(); 8].map(|()| n.next(usual)));
        for gaze in gazes(n) {
            finite(&(gaze, gaze.sight(direction)));
            let level = gaze.level(direction);
            assert_eq!(
                level.is_some(),
                direction.is_finite() && direction != Vec3::ZERO
            );
            assert!(level.is_none_or(|level| (0.0..=1.0).contains(&level)));
            let levels = <Simd as Runs<8>>::run(Simd::detect(), Levels(&gaze, [x, y, z]));
            for (lane, level) in levels.into_iter().enumerate() {
                let own = gaze.level(Vec3::new(x[lane], y[lane], z[lane]));
                assert_eq!(level.to_bits(), own.unwrap_or(0.0).to_bits());
            }
        }
    });
}
