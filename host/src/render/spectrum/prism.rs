/// The least angle by which a prism turns light, radians; `index` is the
/// prism's index of refraction, `apex` the angle between its two sides,
/// radians. `None` where it reflects all light.
///
/// Light then passes symmetrically: sin((δ + A)/2) = n·sin(A/2).
pub fn minimum_deviation(index: f64, apex: f64) -> Option<f64> {
    let sine = index * libm::sin(0.5 * apex);
    (sine.abs() <= 1.0).then(|| 2.0 * libm::asin(sine) - apex)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prisms_turn_light_until_they_reflect_all_of_it() {
        let sixty = 60f64.to_radians();
        let found = minimum_deviation(2f64.sqrt(), sixty).unwrap();
        assert!((found.to_degrees() - 30.0).abs() < 1.0e-12);
        assert!(minimum_deviation(1.0, sixty).unwrap().abs() < 1.0e-15);
        assert_eq!(minimum_deviation(2.01, sixty), None);
    }
}
