//! Lights of a scene file.

use super::entries::LightEntry;
use super::fault::{Check, Checked, LENGTH, LIGHT_SAMPLES, POSITION, RADIANCE, SceneFault, span};
use crate::scene::Light;
use glam::DVec3;
use toml::Spanned;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LightKind {
    Point,
    Directional,
    Rectangle,
}

pub(super) fn read_light(check: &Check<'_>, entry: &Spanned<LightEntry>) -> Checked<Light> {
    use LightKind::{Directional, Point, Rectangle};

    let light = entry.as_ref();
    let colour = check.colour_or("colour", light.colour.as_ref(), RADIANCE, [1.0; 3])?;
    let known = [
        ("point", Point),
        ("directional", Directional),
        ("rectangle", Rectangle),
    ];
    let kind = check.named("type of light", &light.kind, &known.into())?;
    check_keys(check, light, kind)?;
    let missing = |owner, key, example| {
        let fault = SceneFault::new(
            format!("{owner} needs `{key}`"),
            format!("add `{key} = {example}`"),
        );
        check.fault(fault, Some(light.kind.span()))
    };
    let owner = match kind {
        Point => "a point light",
        Directional => "a directional light",
        Rectangle => "a rectangle",
    };
    let vector = |key, written: &Option<Spanned<[f64; 3]>>| {
        let written = written
            .as_ref()
            .ok_or_else(|| missing(owner, key, "[x, y, z]"))?;
        let vector = check.numbers(key, written, POSITION)?;
        Ok((DVec3::from_array(vector), written.span()))
    };
    let direction = || {
        let (direction, span) = vector("direction", &light.direction)?;
        if direction == DVec3::ZERO {
            let help = "give the way the light travels, such as [0, -1, 0] for straight down";
            return check.refuse("the light's `direction` is zero", help, span);
        }
        Ok(direction)
    };
    match kind {
        Point => Ok(Light::Point {
            position: vector("position", &light.position)?.0,
            colour,
            inverse_square: light.inverse_square.as_ref().is_some_and(|on| *on.as_ref()),
        }),
        Directional => Ok(Light::Directional {
            direction: direction()?,
            colour,
        }),
        Rectangle => {
            let size = light.size.as_ref();
            let size = size.ok_or_else(|| missing(owner, "size", "[width, height]"))?;
            let [width, height] = check.numbers("size", size, LENGTH)?;
            let forward = direction()?.normalize();
            let right = right_of(check, light, forward)?;
            Ok(Light::Rectangle {
                centre: vector("position", &light.position)?.0,
                right: right * (0.5 * width),
                up: forward.cross(right) * (0.5 * height),
                colour,
                samples: match &light.samples {
                    None => DEFAULT_SAMPLES,
                    Some(samples) => check.whole("samples", samples, LIGHT_SAMPLES)?,
                },
                two_sided: light.two_sided.as_ref().is_some_and(|on| *on.as_ref()),
            })
        }
    }
}

/// The unit vector to the right of a rectangle, seen from where its light goes.
fn right_of(check: &Check<'_>, light: &LightEntry, forward: DVec3) -> Checked<DVec3> {
    let left = match &light.up {
        Some(up) => {
            let vector = DVec3::from_array(check.numbers("up", up, POSITION)?);
            let left = forward.cross(vector.normalize_or_zero());
            // A ten-thousandth of a degree.
            if left.length() < 2e-6 {
                let help = "give the way to its upper side, or leave it out";
                let message = "the light's `up` is zero or along its `direction`";
                return check.refuse(message, help, up.span());
            }
            left
        }
        // Straight up or down, its upper side is towards −Z or +Z.
        None if forward.y.abs() > 1.0 - 1e-12 => DVec3::X,
        None => forward.cross(DVec3::Y),
    };
    Ok(-left.normalize())
}

fn check_keys(check: &Check<'_>, light: &LightEntry, kind: LightKind) -> Checked<()> {
    use LightKind::{Directional, Point, Rectangle};

    for (kinds, key, span) in [
        (
            &[Point, Rectangle][..],
            "position",
            span(light.position.as_ref()),
        ),
        (
            &[Directional, Rectangle],
            "direction",
            span(light.direction.as_ref()),
        ),
        (
            &[Point],
            "inverse_square",
            span(light.inverse_square.as_ref()),
        ),
        (&[Rectangle], "size", span(light.size.as_ref())),
        (&[Rectangle], "up", span(light.up.as_ref())),
        (&[Rectangle], "samples", span(light.samples.as_ref())),
        (&[Rectangle], "two_sided", span(light.two_sided.as_ref())),
    ] {
        if !kinds.contains(&kind) {
            let owner = match kinds {
                [Point, _] => "point lights and rectangles",
                [Directional, _] => "directional lights and rectangles",
                [Point] => "point lights",
                _ => "rectangles",
            };
            check.only_for(owner, key, span)?;
        }
    }
    Ok(())
}

/// Points of a rectangle that each lit point looks at, unless the file says how many.
const DEFAULT_SAMPLES: u32 = 16;
