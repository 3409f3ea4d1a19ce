//! Lights of a scene file.

use super::entries::LightEntry;
use super::fault::{Check, LENGTH, LIGHT_SAMPLES, POSITION, RADIANCE, SceneFault};
use crate::files::description::Located;
use crate::scene::Light;
use glam::DVec3;
use toml::Spanned;

/// The types of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LightKind {
    Point,
    Directional,
    Rectangle,
}

pub(super) fn read_light(
    check: &Check<'_>,
    entry: &Spanned<LightEntry>,
) -> Result<Light, Located<SceneFault>> {
    use LightKind::{Directional, Point, Rectangle};

    let light = entry.as_ref();
    let colour = check.colour_or("colour", light.colour.as_ref(), RADIANCE, [1.0; 3])?;
    let kind = check.named(
        "type of light",
        &light.kind,
        &[
            ("point", Point),
            ("directional", Directional),
            ("rectangle", Rectangle),
        ]
        .into(),
    )?;
    check_keys(check, light, kind)?;
    let missing = |owner, key, example| {
        let fault = SceneFault::Missing {
            owner,
            key,
            example,
        };
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
            return Err(check.fault(SceneFault::ZeroDirection, Some(span)));
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

/// The unit vector to the right of a rectangle, as those see it whom it lights.
fn right_of(
    check: &Check<'_>,
    light: &LightEntry,
    forward: DVec3,
) -> Result<DVec3, Located<SceneFault>> {
    let left = match &light.up {
        Some(up) => {
            let vector = DVec3::from_array(check.numbers("up", up, POSITION)?);
            let left = forward.cross(vector.normalize_or_zero());
            // A ten-thousandth of a degree.
            if left.length() < 2e-6 {
                return Err(check.fault(SceneFault::LightUp, Some(up.span())));
            }
            left
        }
        // Straight up or down, its upper side is towards −Z or +Z.
        None if forward.y.abs() > 1.0 - 1e-12 => DVec3::X,
        None => forward.cross(DVec3::Y),
    };
    Ok(-left.normalize())
}

/// Whether a light has no keys of other types.
fn check_keys(
    check: &Check<'_>,
    light: &LightEntry,
    kind: LightKind,
) -> Result<(), Located<SceneFault>> {
    use LightKind::{Directional, Point, Rectangle};

    let not_point = "directional lights and rectangles";
    let not_directional = "point lights and rectangles";
    let large = "rectangles";
    let flag = |on: &Option<Spanned<bool>>| on.as_ref().map(Spanned::span);
    let keys: &[(_, _, &[LightKind], _)] = &[
        (
            "position",
            light.position.as_ref().map(Spanned::span),
            &[Point, Rectangle],
            not_directional,
        ),
        (
            "direction",
            light.direction.as_ref().map(Spanned::span),
            &[Directional, Rectangle],
            not_point,
        ),
        (
            "inverse_square",
            flag(&light.inverse_square),
            &[Point],
            "point lights",
        ),
        (
            "size",
            light.size.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        (
            "up",
            light.up.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        (
            "samples",
            light.samples.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        ("two_sided", flag(&light.two_sided), &[Rectangle], large),
    ];
    for (key, span, kinds, owner) in keys {
        if span.is_some() && !kinds.contains(&kind) {
            return Err(check.fault(SceneFault::NotHere { key, owner }, span.clone()));
        }
    }
    Ok(())
}

/// Points of a rectangle that are looked at where nothing else is asked for.
const DEFAULT_SAMPLES: u32 = 16;
