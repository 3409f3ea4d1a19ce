/// The least angle by which a prism turns light, radians; `index` is the prism's index of
/// refraction, `apex` the angle between its two sides, radians. `None` where it reflects all light.
///
/// Light then passes symmetrically: sin((δ + A)/2) = n·sin(A/2).
pub fn minimum_deviation(index: f64, apex: f64) -> Option<f64> {
    let sine = index * libm::sin(0.5 * apex);
    (sine.abs() <= 1.0).then(|| 2.0 * libm::asin(sine) - apex)
}
