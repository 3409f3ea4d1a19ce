use super::design::{bisect, golden};
use super::near_field::{NearField, NearestError, Ray};

/// The best place of an eye for a mirror's picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// Equatorial radii from the screen's centre towards the zenith; negative into the mirror.
    pub offset: f64,
    /// The largest displacement seen from there, radians.
    pub largest: f64,
    /// The largest displacement seen from the screen's centre, radians.
    pub from_screen: f64,
}

impl Viewpoint {
    /// The displacement from the screen's centre divided by that from here; 1 if both are 0.
    pub fn gain(&self) -> f64 {
        if self.largest > 0.0 {
            self.from_screen / self.largest
        } else {
            1.0
        }
    }
}

/// The point of the axis with the smallest largest displacement, over the whole picture and over
/// surroundings from `nearest` radii to infinity.
///
/// The mirror's rays, extended backwards, cross the axis at different points: those of the rim at
/// the screen's centre, the others farther in. The viewpoint changes nothing at infinity; among
/// points that are equally good, the one nearest to the screen's centre is taken. Along the axis
/// each ray's h ([`NearField`]) changes monotonically, so the largest displacement falls and then
/// rises, and golden section finds its minimum.
///
/// # Errors
/// A distance that is NaN, or within the mirror as seen from the screen's centre.
pub fn effective_viewpoint(near: &NearField, nearest: f64) -> Result<Viewpoint, NearestError> {
    let near = near.clone().seen_from(0.0);
    near.check(nearest)?;
    let far = near.largest(f64::INFINITY).angle;
    let at = |offset: f64| near.largest_from(offset, nearest).angle;
    let from_screen = at(0.0).max(far);
    let mut offset = 0.0;
    if from_screen > far {
        let (low, high) = bracket(&near.rays, nearest, far);
        let best = golden(low, high, at);
        if at(best) < from_screen {
            offset = best;
        }
        if at(offset) < far {
            // The nearest to the screen of those as good.
            offset = bisect(offset, 0.0, |offset| at(offset) <= far);
        }
    }
    Ok(Viewpoint {
        offset,
        largest: at(offset).max(far),
        from_screen,
    })
}

/// Offsets between which the best one is: beyond them all rays pass on one side
/// by more than `far`, or the mirror reaches beyond the nearest surface.
fn bracket(rays: &[Ray], nearest: f64, far: f64) -> (f64, f64) {
    let mut crossings = (0f64, 0f64);
    let mut inside = (f64::NEG_INFINITY, f64::INFINITY);
    for &Ray {
        start, sin, cos, ..
    } in rays
    {
        if sin > 0.0 {
            let at = start.y - start.x * cos / sin;
            // Moves a ray by twice the mapping's own error.
            let margin = 2.0 * far * nearest / sin;
            crossings = (crossings.0.min(at - margin), crossings.1.max(at + margin));
        }
        let half = (nearest * nearest - start.x * start.x).max(0.0).sqrt();
        inside = (inside.0.max(start.y - half), inside.1.min(start.y + half));
    }
    (crossings.0.max(inside.0), crossings.1.min(inside.1))
}

#[cfg(test)]
mod tests {
    use super::super::{Mapping, Named};
    use super::*;

    #[test]
    fn no_other_viewpoint_is_better_and_it_is_as_good_as_it_says() {
        for (named, mapping, nearest) in [
            (Named::Paper1, Mapping::Mirror, 1.0),
            (Named::Paper2, Mapping::Exact, 2.0),
            (Named::Paper3, Mapping::Mirror, 10.0),
            (Named::BestParallel, Mapping::Exact, 100.0),
            (Named::Best, Mapping::Mirror, 1.0e5),
        ] {
            let near = NearField::new(named.mirror(), mapping);
            let found = effective_viewpoint(&near, nearest).unwrap();
            let from = |offset| near.clone().seen_from(offset);
            let at = |offset, distance| from(offset).largest(distance).angle;
            let largest = |offset| at(offset, nearest).max(at(offset, f64::INFINITY));
            assert_eq!(largest(found.offset), found.largest);
            assert_eq!(largest(0.0), found.from_screen);
            let is_gain = found.gain() >= 1.0 && found.offset <= 0.0;
            assert!(is_gain, "{named:?} {found:?}");
            let least = found.largest * (1.0 - 1.0e-12);
            for other in (-200..=200).map(|i| f64::from(i) * 0.01) {
                let is_worse = from(other).check(nearest).is_err() || largest(other) >= least;
                assert!(is_worse, "{named:?} {nearest} {other}: {found:?}");
            }
        }
    }
}
