use super::mapping::Mapping;
use super::mirror::{Mirror, Parameters};
use super::search::{bisect, crossing, golden};
use glam::DVec2;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use thiserror::Error;

/// Rays along a dome master's radius: one a pixel of a picture of 4096². Between them a
/// displacement is at most 10⁻⁴ pixels larger.
const PLACES: usize = 2048;

/// A dome master of near surroundings: section 5.4.
///
/// A mirror has no single viewpoint: rays start on the mirror. A ray that passes the viewpoint at
/// the distance h shows a surface at the distance D displaced by sin⁻¹(h/D), always to the same
/// side and less farther away. So the displacement is largest at the nearest distance or at
/// infinity.
///
/// Distances are in equatorial radii, from the viewpoint.
#[derive(Debug, Clone)]
pub struct NearField {
    pub(super) mirror: Mirror,
    pub(super) mapping: Mapping,
    /// From the screen's centre towards the zenith: radii.
    pub(crate) offset: f64,
    /// Evenly by `r_d`, from the zenith to the rim.
    rays: Vec<Ray>,
}

/// Surroundings nearer than the mirror itself.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the nearest surface is {distance} radii from the viewpoint: give a number above {least}, \
     where the mirror is"
)]
pub struct NearestError {
    /// The distance, equatorial radii.
    pub distance: f64,
    /// The distance that it has to exceed.
    pub least: f64,
}

/// The largest displacement in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Displacement {
    /// Where in the picture, radians from the zenith.
    pub r_d: f64,
    /// The angle between what is seen there and what should be, radians.
    pub angle: f64,
}

impl Displacement {
    /// Returns the angle in pixels of a picture of 4096².
    pub fn px_4096(&self) -> f64 {
        px_4096(self.angle)
    }
}

/// Returns an angle in pixels of a picture of 4096².
pub fn px_4096(angle: f64) -> f64 {
    angle * FRAC_2_PI * 2048.0
}

/// A line of sight behind the mirror, in the plane of the axis.
#[derive(Debug, Clone, Copy)]
struct Ray {
    r_d: f64,
    /// Where it starts: from the axis, and from the screen towards the zenith.
    start: DVec2,
    /// Its angle to the zenith, and that angle's sine and cosine.
    theta: f64,
    sin: f64,
    cos: f64,
}

impl Ray {
    fn of(mirror: &Mirror, mapping: Mapping, r_d: f64) -> Self {
        let Parameters { c1, b1, .. } = mirror.parameters();
        let theta = mapping.theta(mirror, r_d);
        let reflected_at = |screen: f64| {
            let (point, _) = mirror.reflect(DVec2::new(screen * FRAC_2_PI * b1, 0.0));
            DVec2::new(point.x, -point.z - c1)
        };
        let (sin, cos) = libm::sincos(theta);
        Self {
            r_d,
            start: match mapping {
                Mapping::Mirror => reflected_at(r_d),
                Mapping::Exact => reflected_at(mirror.r_d(theta)),
                Mapping::True => DVec2::ZERO,
            },
            theta,
            sin,
            cos,
        }
    }

    /// h: its distance from a viewpoint, positive on the side away from the zenith.
    fn beside(&self, offset: f64) -> f64 {
        self.start.x * self.cos - (self.start.y - offset) * self.sin
    }

    /// Returns the angle to the zenith of its point at a distance from a viewpoint.
    fn angle(&self, offset: f64, distance: f64) -> f64 {
        self.theta + libm::asin(self.beside(offset) / distance)
    }
}

impl NearField {
    /// Returns a picture for the viewpoint at the screen's centre, S, as in the paper.
    pub fn new(mirror: Mirror, mapping: Mapping) -> Self {
        let ray = |i| Ray::of(&mirror, mapping, FRAC_PI_2 * i as f64 / PLACES as f64);
        Self {
            mirror,
            mapping,
            offset: 0.0,
            rays: (0..=PLACES).map(ray).collect(),
        }
    }

    /// Returns the same picture for a viewpoint `offset` radii from the screen's centre towards the
    /// zenith. A true fisheye keeps its only viewpoint.
    #[must_use]
    pub fn seen_from(mut self, offset: f64) -> Self {
        if self.mapping != Mapping::True {
            self.offset = offset;
        }
        self
    }

    /// Returns the distance from the viewpoint to the farthest point of the mirror.
    pub fn reach(&self) -> f64 {
        let from = DVec2::new(0.0, self.offset);
        let reach = |most: f64, ray: &Ray| most.max((ray.start - from).length());
        self.rays.iter().fold(0.0, reach)
    }

    /// Refuses surroundings in the mirror.
    ///
    /// # Errors
    /// A distance that is NaN or not above [`reach`](Self::reach).
    pub fn check(&self, distance: f64) -> Result<(), NearestError> {
        let least = self.reach();
        if distance > least {
            Ok(())
        } else {
            Err(NearestError { distance, least })
        }
    }

    /// Returns the angle to the zenith of what is seen at `r_d`, both radians, 0 to
    /// π/2, at a distance above [`reach`](Self::reach), which may be infinite.
    pub fn angle(&self, r_d: f64, distance: f64) -> f64 {
        Ray::of(&self.mirror, self.mapping, r_d).angle(self.offset, distance)
    }

    /// `r_d` where a ring at the angle `ring` to the zenith is seen, both
    /// radians; `None` where it is outside the picture.
    pub fn ring(&self, ring: f64, distance: f64) -> Option<f64> {
        let beyond = |r_d: f64| self.angle(r_d, distance) - ring;
        if ring <= 0.0 {
            return (ring == 0.0).then_some(0.0);
        }
        (beyond(FRAC_PI_2) > 0.0).then(|| crossing(0.0, FRAC_PI_2, beyond))
    }

    /// Returns the largest displacement of what is at one distance, which may be infinite.
    pub fn largest(&self, distance: f64) -> Displacement {
        self.largest_from(self.offset, distance)
    }

    fn largest_from(&self, offset: f64, distance: f64) -> Displacement {
        let seen = self.rays.iter().map(|ray| Displacement {
            r_d: ray.r_d,
            angle: (ray.angle(offset, distance) - ray.r_d).abs(),
        });
        seen.fold(Displacement::default(), |most, one| {
            if one.angle > most.angle { one } else { most }
        })
    }
}

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
    /// Returns the displacement from the screen's centre divided by that from here; 1 if both are
    /// 0.
    pub fn gain(&self) -> f64 {
        if self.largest > 0.0 {
            self.from_screen / self.largest
        } else {
            1.0
        }
    }
}

/// Returns the point of the axis with the smallest largest displacement, over the whole picture and
/// over surroundings from `nearest` radii to infinity.
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
    use super::super::Named;
    use super::*;

    const PAPER: [Named; 3] = [Named::Paper1, Named::Paper2, Named::Paper3];

    #[test]
    fn domes_near_the_mirror_have_the_displacements_of_their_table() {
        for (distance, row) in [
            (1.0, [92.850, 99.190, 48.743]),
            (3.0, [31.656, 45.461, 17.066]),
            (10.0, [10.655, 28.309, 6.355]),
            (100.0, [3.217, 22.139, 2.605]),
            (f64::INFINITY, [2.569, 21.474, 2.227]),
        ] {
            for (named, exact) in PAPER.into_iter().zip(row) {
                let near = NearField::new(named.mirror(), Mapping::Mirror);
                let found = near.largest(distance).px_4096();
                let off = (found - exact).abs();
                assert!(off <= 6.0e-4, "{distance}: {found} {exact}");
            }
        }
    }

    #[test]
    fn rings_are_where_they_are_seen() {
        let near = NearField::new(Named::Paper1.mirror(), Mapping::Mirror);
        // Pixels off at a distance of one radius, every 10 degrees.
        let table = [24.84, 48.14, 68.29, 83.54, 91.92, 91.10, 78.21, 49.55];
        for (ring, exact) in (1..).map(|i| f64::from(10 * i).to_radians()).zip(table) {
            let off = px_4096((near.ring(ring, 1.0).unwrap() - ring).abs());
            assert!((off - exact).abs() <= 5.1e-3, "{ring}: {off} {exact}");
        }
        assert_eq!(near.ring(2.0, 2.0), None);
        assert_eq!(near.ring(-0.1, 2.0), None);
    }

    #[test]
    fn surroundings_in_the_mirror_are_refused() {
        let near = NearField::new(Named::Paper1.mirror(), Mapping::Mirror);
        let least = near.reach();
        // The rim, which is farther from S than the pole.
        assert!((least - 0.613_261_081_588).abs() < 1.0e-11);
        for distance in [f64::NAN, -1.0, 0.0, least] {
            let error = near.check(distance).unwrap_err();
            assert!(error.to_string().contains("above 0.61326108"), "{error}");
        }
        assert_eq!(near.check(least.next_up()), Ok(()));
        assert_eq!(near.check(f64::INFINITY), Ok(()));
    }

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
