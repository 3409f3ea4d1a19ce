//! Lights of a scene file.

use super::entries::{LightEntry, Numbers};
use super::fault::{CONE, Check, Checked, LENGTH, LIGHT_SAMPLES, POSITION, RADIANCE, SceneFault};
use crate::scene::Light;
use LightKind::{Directional, Point, Rectangle, Spot};
use glam::DVec3;
use toml::Spanned;

/// Points of a rectangle that each lit point looks at, unless the file says how many.
const DEFAULT_SAMPLES: u32 = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LightKind {
    Point,
    Spot,
    Directional,
    Rectangle,
}

pub(super) fn read_light(check: &Check<'_>, entry: &Spanned<LightEntry>) -> Checked<Light> {
    let light = entry.as_ref();
    let colour = check.colour_or("colour", &light.colour, RADIANCE, [1.0; 3])?;
    let known = [
        ("point", Point),
        ("spot", Spot),
        ("directional", Directional),
        ("rectangle", Rectangle),
    ];
    let kind = check.named("type of light", &light.kind, &known.into())?;
    check_keys(check, light, kind)?;
    let missing = |key, example| {
        let owner = match kind {
            Point => "a point light",
            Spot => "a spot",
            Directional => "a directional light",
            Rectangle => "a rectangle",
        };
        let help = format!("add `{key} = {example}`");
        let fault = SceneFault::new(format!("{owner} needs `{key}`"), help);
        check.fault(fault, Some(light.kind.span()))
    };
    let vector = |key, written: &Option<Numbers>| {
        let written = written.as_ref();
        let written = written.ok_or_else(|| missing(key, "[x, y, z]"))?;
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
    let is_on = |flag: &Option<Spanned<bool>>| flag.as_ref().is_some_and(|on| *on.as_ref());
    match kind {
        Point => Ok(Light::Point {
            position: vector("position", &light.position)?.0,
            colour,
            inverse_square: is_on(&light.inverse_square),
        }),
        Spot => {
            let cone = light.cone_degrees.as_ref();
            let cone = cone.ok_or_else(|| missing("cone_degrees", "[full, none]"))?;
            let [full, none] = check.numbers("cone_degrees", cone, CONE)?;
            if full >= none {
                let help = "give the angle from the axis up to which light is full, and a larger \
                    one from which on there is none, such as [20, 30]";
                let message = format!("the spot's `cone_degrees` are {full} and {none}");
                return check.refuse(message, help, cone.span());
            }
            Ok(Light::Spot {
                position: vector("position", &light.position)?.0,
                direction: direction()?,
                cone: [full.to_radians(), none.to_radians()],
                colour,
                inverse_square: is_on(&light.inverse_square),
            })
        }
        Directional => Ok(Light::Directional {
            direction: direction()?,
            colour,
        }),
        Rectangle => {
            let size = light.size.as_ref();
            let size = size.ok_or_else(|| missing("size", "[width, height]"))?;
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
                two_sided: is_on(&light.two_sided),
            })
        }
    }
}

/// Refuses keys that are for other kinds of light.
fn check_keys(check: &Check<'_>, light: &LightEntry, kind: LightKind) -> Checked<()> {
    if kind == Directional {
        let owner = "point lights, spots and rectangles";
        check.only_for(owner, "position", &light.position)?;
    }
    if kind == Point {
        let owner = "spots, directional lights and rectangles";
        check.only_for(owner, "direction", &light.direction)?;
    }
    if kind != Spot {
        check.only_for("spots", "cone_degrees", &light.cone_degrees)?;
    }
    if !matches!(kind, Point | Spot) {
        let owner = "point lights and spots";
        check.only_for(owner, "inverse_square", &light.inverse_square)?;
    }
    if kind != Rectangle {
        check.only_for("rectangles", "size", &light.size)?;
        check.only_for("rectangles", "up", &light.up)?;
        check.only_for("rectangles", "samples", &light.samples)?;
        check.only_for("rectangles", "two_sided", &light.two_sided)?;
    }
    Ok(())
}

/// Returns the unit vector to the right of a rectangle, seen from where its light goes.
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
