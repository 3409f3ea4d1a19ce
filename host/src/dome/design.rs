use super::mapping::Mapping;
use super::mirror::{Mirror, MirrorError, Parameters, Projection};
use super::search::{crossing, golden};
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// A mirror and the errors of its dome master.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Design {
    /// The mirror itself.
    #[serde(skip)]
    pub mirror: Mirror,
    /// Polar by equatorial radius.
    pub a: f64,
    /// The viewpoint's distance from the mirror's centre (eq. 24); null in parallel projection.
    pub p: Option<f64>,
    /// The screen's distance from the mirror's centre: equation 19.
    pub c1: f64,
    /// Half the screen's width: equations 20 and 40.
    pub b1: f64,
    /// The viewpoint's distance from the screen (eq. 22); null in parallel projection.
    pub d1: Option<f64>,
    /// The parametric angle of the mirror at the picture's edge, radians.
    pub beta1: f64,
    /// The full angle of view across the picture, radians; 0 in parallel projection.
    #[serde(skip)]
    pub field_of_view: f64,
    /// The largest difference between angle and place, percent of the picture's radius.
    pub error_percent: f64,
    /// The same, pixels of a picture of 4096².
    pub error_px_4096: f64,
    /// The places of the largest errors on either side, from the zenith outwards.
    #[serde(skip)]
    pub extrema: Vec<Extremum>,
}

/// A local extremum of θ − `r_d`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremum {
    /// The parametric angle of the mirror's point, radians.
    pub beta: f64,
    /// The point's distance from the middle of the picture, radians.
    pub r_d: f64,
    /// θ − `r_d`, radians.
    pub error: f64,
}

/// Steps from 0 to β₁; within each the error's slope changes its sign at most once.
const PLACES: usize = 64;

/// Steps of slopes and of axis ratios; within each the largest error has at most one minimum.
const CANDIDATES: usize = 128;

impl Design {
    /// Evaluates a given mirror.
    pub fn of(mirror: Mirror) -> Self {
        let Parameters { k, c1, b1, beta1 } = mirror.parameters();
        let d1 = (k > 0.0).then(|| 1.0 / k);
        let extrema = extrema(&mirror);
        let error = largest(&extrema);
        Self {
            mirror,
            a: mirror.a,
            p: d1.map(|d1| c1 + d1),
            c1,
            b1,
            d1,
            beta1,
            field_of_view: 2.0 * libm::atan(k * b1),
            error_percent: error / FRAC_PI_2 * 100.0,
            error_px_4096: error / FRAC_PI_2 * 2048.0,
            extrema,
        }
    }

    /// Returns the same mirror with another mapping: only [`Mapping::Mirror`] has errors.
    #[must_use]
    pub fn mapped(self, mapping: Mapping) -> Self {
        match mapping {
            Mapping::Mirror => self,
            Mapping::Exact | Mapping::True => Self {
                error_percent: 0.0,
                error_px_4096: 0.0,
                extrema: Vec::new(),
                ..self
            },
        }
    }
}

/// Returns the viewpoint with the smallest largest |θ − `r_d`| for an axis ratio: figures 10 to 16.
/// By perspective that may be the limit of parallel projection. There can be two local minima by
/// perspective, so the whole range of viewpoints is searched.
///
/// # Errors
/// An axis ratio outside [`Mirror::AXIS_RATIOS`].
pub fn optimum(a: f64, projection: Projection) -> Result<Design, MirrorError> {
    Mirror::parallel(a)?;
    Ok(best_viewpoint(a, projection))
}

/// [`optimum`] for an axis ratio that is known to be one.
pub(super) fn best_viewpoint(a: f64, projection: Projection) -> Design {
    let mut best = Design::of(Mirror::of(a, 1.0));
    if projection == Projection::Perspective {
        for slope in local_slopes(a) {
            let design = Design::of(Mirror::of(a, slope));
            if design.error_percent < best.error_percent {
                best = design;
            }
        }
    }
    best
}

/// Returns the local minima of the largest error over viewpoints: one or two, the nearest first.
/// Parallel projection is one of them if the error falls up to it.
///
/// # Errors
/// An axis ratio outside [`Mirror::AXIS_RATIOS`].
pub fn local_optima(a: f64) -> Result<Vec<Design>, MirrorError> {
    Mirror::parallel(a)?;
    let of = |slope| Design::of(Mirror::of(a, slope));
    Ok(local_slopes(a).into_iter().map(of).collect())
}

/// Returns the slopes at which the largest error has a local minimum; 1 is parallel projection.
fn local_slopes(a: f64) -> Vec<f64> {
    let error = |g: f64| largest(&extrema(&Mirror::of(a, g)));
    let slopes = |i: usize| (i as f64 / CANDIDATES as f64).max(1.0e-3);
    // Next to the limit errors differ by their rounding only.
    let settled = |(_, g): (f64, f64)| if g > 1.0 - 1.0e-9 { 1.0 } else { g };
    minima(slopes, error).into_iter().map(settled).collect()
}

/// Returns the design with the smallest largest |θ − `r_d`| among axis ratios from 0.5 to 8.
pub fn best(projection: Projection) -> Design {
    let ratios = |i: usize| 0.5 * 16f64.powf(i as f64 / CANDIDATES as f64);
    let design = |a: f64| best_viewpoint(a, projection);
    let minima = minima(ratios, |a| design(a).error_percent).into_iter();
    let least = minima.min_by(|a, b| a.0.total_cmp(&b.0));
    let a = least.map_or(ratios(0), |(_, a)| a);
    match projection {
        Projection::Parallel => design(a),
        Projection::Perspective => level(a, design),
    }
}

/// Returns the exact minimum next to axis ratio `a`. The minimum is flat, so values alone find half
/// of its digits; at the minimum the gradients of the positive and of the negative error by (a, g)
/// are parallel.
fn level(a: f64, design: impl Fn(f64) -> Design) -> Design {
    let turn = |a: f64| {
        let design = design(a);
        let [first, second] =
            [0, design.extrema.len() - 1].map(|i| gradient(&design.mirror, design.extrema[i].beta));
        first[0] * second[1] - first[1] * second[0]
    };
    design(crossing(a * 0.99, a * 1.01, turn))
}

/// Returns how θ − `r_d` changes with a and with g at the parametric angle β.
fn gradient(mirror: &Mirror, beta: f64) -> [f64; 2] {
    let (a, g) = (mirror.a, mirror.g);
    let Parameters { k, c1, b1, .. } = mirror.parameters();
    let (sin, cos) = libm::sincos(beta);
    let h = libm::hypot(a, g);
    let drop = c1 - a * cos;
    let w = 1.0 + k * drop;
    let r_d = FRAC_PI_2 * sin / (b1 * w);
    let change = |k_by: f64, c1_by: f64, b1_by: f64, cos_by: f64, gamma_by: f64| {
        let w_by = k_by * drop + k * (c1_by - cos_by);
        let sight = sin * (w * k_by - k * w_by) / (w * w + k * k * sin * sin);
        sight + 2.0 * gamma_by + r_d * (b1_by / b1 + w_by / w)
    };
    let (a2, g2, h3) = (a * a, g * g, h * h * h);
    let lift = (1.0 - g) * (1.0 + g) / (2.0 * g2);
    [
        change(
            lift * a / h,
            2.0 * a / h - a2 * a / h3,
            -g * a / h3,
            cos,
            sin * cos / (cos * cos + a2 * sin * sin),
        ),
        change(lift * g / h - h / (g2 * g), -a2 * g / h3, a2 / h3, 0.0, 0.0),
    ]
}

fn extrema(mirror: &Mirror) -> Vec<Extremum> {
    let a = mirror.a;
    let Parameters { k, c1, b1, beta1 } = mirror.parameters();
    // The derivative by β.
    let rise = |beta: f64| {
        let (sin, cos) = libm::sincos(beta);
        let w = 1.0 + k * (c1 - a * cos);
        let shrink = cos * w - k * a * sin * sin;
        k * shrink / (w * w + k * k * sin * sin) + 2.0 * a / (cos * cos + a * a * sin * sin)
            - FRAC_PI_2 * shrink / (b1 * w * w)
    };
    let place = |i: usize| beta1 * i as f64 / PLACES as f64;
    let mut found = Vec::new();
    let mut before = rise(0.0);
    for i in 1..=PLACES {
        let after = rise(place(i));
        if (before > 0.0) != (after > 0.0) {
            let beta = crossing(place(i - 1), place(i), rise);
            let (theta, r_d) = mirror.at(beta);
            found.push(Extremum {
                beta,
                r_d,
                error: theta - r_d,
            });
        }
        before = after;
    }
    found
}

fn largest(extrema: &[Extremum]) -> f64 {
    extrema.iter().fold(0.0, |most, e| most.max(e.error.abs()))
}

/// Returns every local minimum, refined by golden section: its value and its place.
fn minima(candidate: impl Fn(usize) -> f64, f: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let values: Vec<f64> = (0..=CANDIDATES).map(|i| f(candidate(i))).collect();
    let mut found = Vec::new();
    for i in 0..=CANDIDATES {
        let (left, right) = (i.saturating_sub(1), (i + 1).min(CANDIDATES));
        if values[i] <= values[left] && values[i] <= values[right] {
            let x = golden(candidate(left), candidate(right), &f);
            found.push((f(x), x));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts that `found` rounds to `digits`, as written in a table.
    fn rounds_to(found: f64, digits: &str) {
        let exact: f64 = digits.parse().unwrap();
        let places = digits.split_once('.').map_or(0, |(_, places)| places.len());
        let unit = 10f64.powi(-(places as i32));
        // Half a unit of the last place, and one in a thousand for its own rounding.
        assert!((found - exact).abs() <= 0.501 * unit, "{found}: {digits}");
    }

    fn perspective(a: f64) -> Design {
        optimum(a, Projection::Perspective).unwrap()
    }

    fn degrees(design: &Design) -> Vec<f64> {
        let degrees = |e: &Extremum| e.r_d.to_degrees();
        design.extrema.iter().map(degrees).collect()
    }

    #[test]
    fn every_axis_ratio_has_the_digits_of_its_best_viewpoint() {
        // a, error %, β₁, c₁, p and the places of the extrema, degrees.
        let table = "\
            0.5  1.83419173934  0.612109638831 0.409218825675 0.869316069640 29.173 78.263
            0.8  1.23314386232  0.446935778437 0.721420562949 1.10998065289  29.193 77.795
            1.2  0.934330849829 0.326351847566 1.13666184460  1.44851437131  29.236 77.583
            1.25 0.466524952257 0.674740942224 0.976086011804 inf            65.498
            1.35 0.123931444647 0.619446967098 1.09916954606  16.3480025965  29.807 77.156
            1.5  0.121287430070 0.539282252037 1.28711622070  6.03535744088  29.911 77.245
            1.8  0.114834882866 0.429557609201 1.63647014495  3.78198680932  30.060 77.366
            2.5  0.107945632983 0.293436550073 2.39313882485  3.41087229024  30.246 77.512
            3.0  0.106503289038 0.240103867321 2.91393984023  3.67245183712  30.309 77.560";
        for row in table.lines() {
            let digits: Vec<&str> = row.split_whitespace().collect();
            let design = perspective(digits[0].parse().unwrap());
            rounds_to(design.error_percent, digits[1]);
            rounds_to(design.beta1, digits[2]);
            rounds_to(design.c1, digits[3]);
            match design.p {
                Some(p) => rounds_to(p, digits[4]),
                None => assert_eq!(digits[4], "inf"),
            }
            let places = degrees(&design);
            assert_eq!(places.len(), digits.len() - 5);
            for (found, digits) in places.into_iter().zip(&digits[5..]) {
                rounds_to(found, digits);
            }
        }
    }

    #[test]
    fn parallel_projection_has_the_digits_of_its_errors() {
        let table = "0.5 21.41809, 0.9 6.33625, 1.1 2.48303, 1.2 1.05963, 1.25 0.466525, \
            1.28 0.183617, 1.287 0.132204, 1.29 0.139002, 1.35 0.72018, 1.5 2.03881, 2.1 5.16001";
        for (a, error) in table.split(", ").filter_map(|row| row.split_once(' ')) {
            let design = optimum(a.parse().unwrap(), Projection::Parallel).unwrap();
            rounds_to(design.error_percent, error);
        }
    }

    #[test]
    fn perspective_has_two_local_minima_that_change_places() {
        // The nearer one at 2.35 is the worse, at 1 the better, and the other is the limit.
        let [near, far] = &local_optima(2.35).unwrap()[..] else {
            panic!("not two");
        };
        rounds_to(near.error_percent, "0.705");
        assert_eq!(*far, perspective(2.35));
        let parallel = optimum(1.0, Projection::Parallel).unwrap();
        assert_eq!(local_optima(1.0).unwrap(), [perspective(1.0), parallel]);
        // Rounding next to the limit finds no other viewpoint.
        for i in 0..=10 {
            let a = 1.2105 + 0.0077 * f64::from(i);
            assert_eq!(perspective(a).p, None, "{a}");
        }
        for (a, nearest) in [(1.2102, 0), (1.2104, 1)] {
            assert_eq!(local_optima(a).unwrap()[nearest], perspective(a), "{a}");
        }
        assert!(perspective(1.2102).p.unwrap() < 1.5);
        assert!(perspective(1.2883).p.unwrap() > 1.0e4);
    }

    #[test]
    fn the_best_mirrors_are_better_than_the_papers() {
        let parallel = best(Projection::Parallel);
        rounds_to(parallel.a, "1.288248331186");
        rounds_to(parallel.error_percent, "0.123784174756");
        rounds_to(parallel.error_px_4096, "2.535100");
        let perspective = best(Projection::Perspective);
        rounds_to(perspective.a, "4.50414971");
        rounds_to(perspective.p.unwrap(), "4.8927036");
        rounds_to(perspective.error_percent, "0.105759211320");
        rounds_to(perspective.error_px_4096, "2.165949");
        // The optimum is inside the range that is looked through.
        for a in [0.01, 4.4, 4.6, 100.0] {
            assert!(self::perspective(a).error_percent > perspective.error_percent);
        }
    }
}
