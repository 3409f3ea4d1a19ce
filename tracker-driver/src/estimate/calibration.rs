//! From what an eye tracker says to where the eye looks.

use super::least_squares::LeastSquares;
use glam::{Vec2, Vec3};
use shisen_core::numeric::{normalize, sqrt};

/// What a measured place is made of, before it is turned into a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Model {
    /// 1, x, y: shift, scale, turn and shear. At least 3 targets, not on a line.
    Affine,
    /// Also x², xy, y²: the bend of a cornea seen by a camera beside it. At
    /// least 6 targets, not on a conic; 9 in a square are usual.
    SecondOrder,
}

impl Model {
    /// Returns the fewest targets that it can be fitted to.
    pub const fn least_targets(self) -> usize {
        match self {
            Self::Affine => 3,
            Self::SecondOrder => 6,
        }
    }
}

/// A place that was looked at, and what the tracker said meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// A raw or a gaze point in the device's units, or [`plane_of`] a direction.
    pub measured: Vec2,
    /// Where the target was, from the eye: in the head's axes, of any length
    /// but zero, at most [`MOST_ECCENTRICITY`] from straight ahead.
    pub direction: Vec3,
}

/// How far from straight ahead a target can be: 80°, radians.
pub const MOST_ECCENTRICITY: f32 = 1.396_263_4;

/// Returns a direction in the head's axes as the place where it meets the plane one
/// metre ahead: x to the right and y up. `None` where it is not ahead.
pub fn plane_of(direction: Vec3) -> Option<Vec2> {
    let place = Vec2::new(direction.x, direction.y) / -direction.z;
    // NaN fails the comparison too.
    (direction.z < 0.0 && place.is_finite()).then_some(place)
}

/// Turns measured places into directions: polynomials for x and y one metre ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    model: Model,
    /// Subtracted from a measured place, then `scale` multiplies: targets are within ±1.
    centre: Vec2,
    scale: Vec2,
    x: [f32; 6],
    y: [f32; 6],
    residual: Residual,
}

/// How far a calibration's directions are from its targets, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// The root of the mean square.
    pub rms: f32,
    /// The largest residual.
    pub largest: f32,
    /// The target with the largest residual, counted from 0.
    pub worst: usize,
    /// The number of targets. With as few as the model needs, the residual is zero.
    pub targets: usize,
}

/// Why targets make no calibration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CalibrationError {
    /// Fewer targets than the model has terms.
    #[error(
        "this model needs {least} targets or more and got {found}: show more, or choose a model \
         with fewer terms"
    )]
    TooFew {
        /// How many there are.
        found: usize,
        /// How many it takes.
        least: usize,
    },
    /// A number of a target is NaN or infinite, or its direction is zero.
    #[error(
        "calibration target {target} has a number that is not finite or a direction of no length: \
         leave it out and show it again"
    )]
    NotFinite {
        /// The number of the target, counted from 0.
        target: usize,
    },
    /// A target is not ahead of the viewer.
    #[error(
        "calibration target {target} is more than 80° from straight ahead: give directions in \
         the head's axes, −Z ahead"
    )]
    NotAhead {
        /// The number of the target, counted from 0.
        target: usize,
    },
    /// The targets, or the measured places, do not tell the model's terms apart.
    #[error(
        "the targets, or what the eye tracker says of them, do not determine the calibration: {}",
        match .model {
            Model::Affine => "they lie on a line; show targets above one another too",
            Model::SecondOrder => "they lie on a line or a conic; show nine targets in a square",
        }
    )]
    Degenerate {
        /// The model.
        model: Model,
    },
}

impl Calibration {
    /// Fits a model to targets by least squares of the places on the plane.
    ///
    /// # Errors
    /// Too few targets, targets that do not determine the model, numbers that
    /// are not finite, and directions that are not ahead.
    pub fn fit(model: Model, targets: &[Target]) -> Result<Self, CalibrationError> {
        let least = model.least_targets();
        if targets.len() < least {
            return Err(CalibrationError::TooFew {
                found: targets.len(),
                least,
            });
        }
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for (
            target,
            &Target {
                measured,
                direction,
            },
        ) in targets.iter().enumerate()
        {
            let unit = normalize(direction).filter(|_| measured.is_finite());
            let unit = unit.ok_or(CalibrationError::NotFinite { target })?;
            // cos 80°.
            if !(-unit.z >= 0.173_648_18) {
                return Err(CalibrationError::NotAhead { target });
            }
            low = low.min(measured);
            high = high.max(measured);
        }
        let determined = match model {
            Model::Affine => tell_apart::<3>(model, targets),
            Model::SecondOrder => tell_apart::<6>(model, targets),
        };
        if !determined {
            return Err(CalibrationError::Degenerate { model });
        }
        let span = (high - low) * 0.5;
        if !(span.x > 0.0 && span.y > 0.0 && span.is_finite()) {
            return Err(CalibrationError::Degenerate { model });
        }
        let mut calibration = Self {
            model,
            centre: low + span,
            scale: span.recip(),
            x: [0.0; 6],
            y: [0.0; 6],
            residual: Residual::default(),
        };
        let solved = match model {
            Model::Affine => calibration.solve::<3>(targets),
            Model::SecondOrder => calibration.solve::<6>(targets),
        };
        let Some([x, y]) = solved else {
            return Err(CalibrationError::Degenerate { model });
        };
        (calibration.x, calibration.y) = (x, y);
        calibration.residual = calibration.residual_of(targets);
        Ok(calibration)
    }

    /// Returns how well it fits the targets that it was made of.
    pub const fn residual(&self) -> Residual {
        self.residual
    }

    /// Returns which model it is.
    pub const fn model(&self) -> Model {
        self.model
    }

    /// Returns the direction of a gaze: a unit vector in the head's axes; `None` if not finite.
    pub fn direction(&self, measured: Vec2) -> Option<Vec3> {
        let terms = self.terms(measured);
        let sum = |factors: &[f32; 6]| {
            let products = terms
                .iter()
                .zip(factors)
                .map(|(term, factor)| term * factor);
            products.fold(0.0, |sum, product| sum + product)
        };
        normalize(Vec3::new(sum(&self.x), sum(&self.y), -1.0))
    }

    /// Returns the residual at other targets, such as some that were kept back.
    pub fn residual_of(&self, targets: &[Target]) -> Residual {
        let mut residual = Residual {
            targets: targets.len(),
            ..Residual::default()
        };
        let mut squares = 0.0;
        for (index, target) in targets.iter().enumerate() {
            let aimed = normalize(target.direction);
            let Some((found, aimed)) = self.direction(target.measured).zip(aimed) else {
                continue;
            };
            let off = crate::rotation::angle(found, aimed);
            squares += off * off;
            if off > residual.largest {
                residual.largest = off;
                residual.worst = index;
            }
        }
        residual.rms = sqrt(squares / targets.len().max(1) as f32);
        residual
    }

    fn terms(&self, measured: Vec2) -> [f32; 6] {
        terms(self.model, (measured - self.centre) * self.scale)
    }

    fn solve<const N: usize>(&self, targets: &[Target]) -> Option<[[f32; 6]; 2]> {
        let mut equations = LeastSquares::<N>::new();
        for target in targets {
            let place = plane_of(target.direction)?;
            let terms = self.terms(target.measured);
            equations.add(*terms.first_chunk()?, [place.x, place.y]);
        }
        let solved = equations.solve()?;
        Some(solved.map(|factors| {
            let mut all = [0.0; 6];
            for (to, from) in all.iter_mut().zip(factors) {
                *to = from;
            }
            all
        }))
    }
}

fn terms(model: Model, Vec2 { x, y }: Vec2) -> [f32; 6] {
    match model {
        Model::Affine => [1.0, x, y, 0.0, 0.0, 0.0],
        Model::SecondOrder => [1.0, x, y, x * x, x * y, y * y],
    }
}

/// How far off a line or conic targets have to be for noise not to decide, of their extent.
const LEAST_ASIDE: f32 = 0.02;

/// Returns whether the targets themselves tell the model's terms apart.
fn tell_apart<const N: usize>(model: Model, targets: &[Target]) -> bool {
    let places = || targets.iter().filter_map(|t| plane_of(t.direction));
    let count = targets.len() as f32;
    let middle = places().fold(Vec2::ZERO, |sum, place| sum + place) / count;
    let extent = places().fold(0f32, |most, p| most.max((p - middle).abs().max_element()));
    let mut equations = LeastSquares::<N>::new();
    for place in places() {
        if let Some(terms) = terms(model, (place - middle) / extent).first_chunk() {
            equations.add(*terms, [0.0; 2]);
        }
    }
    equations.is_determined(LEAST_ASIDE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Returns a tracker's units, as a camera beside the eye would make them.
    fn camera(direction: Vec3, bend: f32) -> Vec2 {
        let Vec2 { x, y } = plane_of(direction).unwrap();
        Vec2::new(
            320.0 + 410.0 * x + 25.0 * y + bend * x * x,
            240.0 - 15.0 * x - 380.0 * y + bend * (x * y - 0.5 * y * y),
        )
    }

    fn grid(n: i32) -> impl Iterator<Item = Vec3> {
        (-n..=n).flat_map(move |i| {
            (-n..=n).map(move |j| {
                Vec3::new(0.4 * i as f32 / n as f32, 0.3 * j as f32 / n as f32, -1.0) * 2.0
            })
        })
    }

    fn targets(bend: f32, noise: f32) -> Vec<Target> {
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise * ((state >> 8) as f32 / 16_777_216.0 - 0.5)
        };
        grid(1)
            .map(|direction| Target {
                measured: camera(direction, bend) + Vec2::new(random(), random()),
                direction,
            })
            .collect()
    }

    #[test]
    fn an_affine_tracker_is_recovered() {
        let fitted = Calibration::fit(Model::Affine, &targets(0.0, 0.0)).unwrap();
        assert!(fitted.residual().largest < 1e-6, "{:?}", fitted.residual());
        for direction in grid(5) {
            let found = fitted.direction(camera(direction, 0.0)).unwrap();
            assert!(crate::rotation::angle(found, direction.normalize()) < 2e-6);
        }
    }

    #[test]
    fn a_bend_takes_the_second_order() {
        let bent = targets(60.0, 0.0);
        let affine = Calibration::fit(Model::Affine, &bent).unwrap().residual();
        let second = Calibration::fit(Model::SecondOrder, &bent).unwrap();
        // Radians: 0.4° against 0.04°.
        assert!(affine.rms > 0.007, "{affine:?}");
        assert!(second.residual().rms < 0.0007, "{:?}", second.residual());
        // Between the targets too.
        for direction in grid(5) {
            let found = second.direction(camera(direction, 60.0)).unwrap();
            assert!(crate::rotation::angle(found, direction.normalize()) < 0.003);
        }
    }

    #[test]
    fn what_makes_no_calibration_says_why() {
        use CalibrationError as Error;
        let good = targets(0.0, 0.0);
        let fit = |model, targets: &[Target]| Calibration::fit(model, targets).unwrap_err();
        let too_few = Error::TooFew { found: 5, least: 6 };
        assert_eq!(fit(Model::SecondOrder, &good[..5]), too_few);
        let mut bad = good.clone();
        bad[4].measured.x = f32::NAN;
        assert_eq!(fit(Model::Affine, &bad), Error::NotFinite { target: 4 });
        bad[4] = good[4];
        bad[2].direction = Vec3::ZERO;
        assert_eq!(fit(Model::Affine, &bad), Error::NotFinite { target: 2 });
        bad[2].direction = Vec3::Z;
        assert_eq!(fit(Model::Affine, &bad), Error::NotAhead { target: 2 });
        // On a line, and six on a conic.
        let line: Vec<_> = good
            .iter()
            .enumerate()
            .map(|(i, &t)| Target {
                measured: Vec2::splat(i as f32),
                ..t
            })
            .collect();
        let model = Model::Affine;
        assert_eq!(fit(model, &line), Error::Degenerate { model });
        // Seen with noise, targets on a line seem to be off it.
        let noisy: Vec<_> = targets(0.0, 4.0)
            .iter()
            .filter(|t| t.direction.y == 0.0)
            .copied()
            .collect();
        assert_eq!(noisy.len(), 3);
        assert_eq!(fit(model, &noisy), Error::Degenerate { model });
        let circle: Vec<_> = (0..8)
            .map(|i| Target {
                measured: Vec2::from_angle(i as f32 * 0.785),
                direction: Vec3::NEG_Z,
            })
            .collect();
        let model = Model::SecondOrder;
        assert_eq!(fit(model, &circle), Error::Degenerate { model });
    }
}
