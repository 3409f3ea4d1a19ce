//! Lights and the background as the core has them.

use crate::scene::{Background, Light};
use glam::DVec3;
use shisen_core::scene::format::{self, NO_TEXTURE, light};

pub(super) fn light(source: &Light) -> format::Light {
    let vector = |v: DVec3| v.as_vec3().to_array();
    let small = |place, kind, colour| format::Light {
        place: vector(place),
        kind,
        colour,
        samples: 0,
        right: [0.0; 3],
        reserved: 0,
        up: [0.0; 3],
        reserved2: 0,
    };
    match *source {
        Light::Point {
            position,
            colour,
            inverse_square: true,
        } => small(position, light::POINT_INVERSE_SQUARE, colour),
        Light::Point {
            position, colour, ..
        } => small(position, light::POINT, colour),
        Light::Spot {
            position,
            direction,
            cone: [full, none],
            colour,
            inverse_square,
        } => {
            let kinds = [light::POINT, light::POINT_INVERSE_SQUARE];
            let factor = 1.0 / (libm::cos(full) - libm::cos(none)).max(1.0e-3);
            format::Light {
                right: vector(direction.normalize_or(DVec3::NEG_Y)),
                up: vector(DVec3::new(factor, -libm::cos(none) * factor, 0.0)),
                ..small(position, kinds[usize::from(inverse_square)], colour)
            }
        }
        Light::Directional { direction, colour } => small(
            -direction.normalize_or(DVec3::NEG_Y),
            light::DIRECTIONAL,
            colour,
        ),
        Light::Rectangle {
            centre,
            right,
            up,
            colour,
            samples,
            two_sided,
        } => {
            let kinds = [light::RECTANGLE, light::TWO_SIDED_RECTANGLE];
            let kind = kinds[usize::from(two_sided)];
            format::Light {
                samples,
                right: vector(right),
                up: vector(up),
                ..small(centre, kind, colour)
            }
        }
    }
}

pub(super) fn background(source: &Background) -> format::Background {
    format::Background {
        zenith: source.zenith,
        alpha: source.alpha,
        horizon: source.horizon,
        image: NO_TEXTURE,
        nadir: source.nadir,
        turn: 0.0,
    }
}
