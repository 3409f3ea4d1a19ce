//! Animations of objects.

use super::entries::{AnimationEntry, ObjectEntry};
use super::fault::{Check, Checked, DEGREES, LENGTH, POSITION, TURN};
use crate::scene::motion::{Channel, Clip, Course, Interpolation, Property, Track};
use glam::DVec3;
use std::collections::BTreeMap;
use toml::Spanned;

/// Returns the objects that have names, by these.
pub(super) fn read_names<'e>(
    check: &Check<'_>,
    objects: &'e [Spanned<ObjectEntry>],
) -> Checked<BTreeMap<&'e str, usize>> {
    let mut names = BTreeMap::new();
    for (number, entry) in objects.iter().enumerate() {
        let Some(name) = &entry.as_ref().name else {
            continue;
        };
        if names.insert(name.as_ref().as_str(), number).is_some() {
            let message = format!("two objects are called \"{}\"", name.as_ref());
            return check.refuse(message, "give each a name of its own", name.span());
        }
    }
    Ok(names)
}

/// Returns the number of the object that moves, and how.
pub(super) fn read_animation(
    check: &Check<'_>,
    entry: &Spanned<AnimationEntry>,
    objects: &BTreeMap<&str, usize>,
) -> Checked<(usize, Clip)> {
    let animation = entry.as_ref();
    let object = check.named("object", &animation.object, objects)?;
    let known = Interpolation::ALL.map(|one| (one.name(), one)).into();
    let interpolation = check.name("interpolation", &animation.interpolation, &known)?;
    let interpolation = interpolation.unwrap_or(Interpolation::Linear);
    let keys = [
        (
            "position",
            Property::Position,
            &animation.position,
            POSITION,
        ),
        (
            "rotation_degrees",
            Property::Angles,
            &animation.rotation_degrees,
            DEGREES,
        ),
        ("scale", Property::Scale, &animation.scale, LENGTH),
    ];
    let mut courses = Vec::new();
    for (key, property, values, limits) in keys {
        let (Some(values), Some(times)) = (values, &animation.times) else {
            continue;
        };
        let seconds = times.as_ref();
        if values.len() != seconds.len() {
            let message = format!(
                "`{key}` has {} keys, `times` {}",
                values.len(),
                seconds.len()
            );
            return check.refuse(message, "give one for each time", times.span());
        }
        let values = values.iter().map(|value| check.numbers(key, value, limits));
        let values: Vec<[f64; 3]> = values.collect::<Checked<_>>()?;
        let seconds = seconds.clone();
        let track = match interpolation {
            Interpolation::Cubic => Track::smooth(property, seconds, values.into_flattened()),
            _ => Track::new(property, interpolation, seconds, values.into_flattened()),
        };
        let track = track.or_else(|error| {
            let message = format!("the animation of \"{}\" {error}", animation.object.as_ref());
            let help = "give times in seconds from 0 on, none before the one before it";
            check.refuse(message, help, times.span())
        })?;
        courses.push(Course::Track(track));
    }
    let has_keys = !courses.is_empty();
    if let Some(spin) = &animation.spin {
        let seconds = check.number("seconds_per_turn", &spin.seconds_per_turn, TURN)?;
        let axis = check.vector_or("axis", &spin.axis, DVec3::Y)?;
        let Some(axis) = axis.try_normalize().filter(|_| seconds.abs() >= 1.0e-3) else {
            let help = "give an axis such as [0, 1, 0], and 0.001 seconds at least";
            let message = "a spin has an `axis` and `seconds_per_turn`, and neither is zero";
            return check.refuse(message, help, entry.span());
        };
        courses.push(Course::Spin { axis, seconds });
    }
    if has_keys == animation.spin.is_some() || has_keys != animation.times.is_some() {
        let choice = "either `spin`, or `times` with `position`, `rotation_degrees` or `scale`";
        return check.refuse_keys("an animation", choice, entry.span());
    }
    let channels = courses
        .into_iter()
        .map(|course| Channel { node: 0, course });
    let clip = Clip {
        name: animation.object.as_ref().clone(),
        channels: channels.collect(),
        plays: true,
        ..Clip::default()
    };
    Ok((object, clip))
}
