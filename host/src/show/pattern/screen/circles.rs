//! Circles of constant angle about directions from the eye.

use crate::picture::{Picture, PictureError};
use crate::show::pattern::ScreenView;
use crate::show::pattern::sheet::{BLACK, Colour, Sheet, Sign, WHITE, mixed, stroke};
use glam::{DVec2, DVec3};

/// The angles from the middle of each circle to its line: degrees.
pub(crate) const RADII: [f64; 2] = [8.0, 16.0];

/// The angle of a further circle about each axis of the room: degrees.
const WIDE: f64 = 35.0;

/// The colours about the room's axes, and about directions halfway between two and three of them.
const COLOURS: [Colour; 3] = [WHITE, [0.9, 0.8, 0.0], [0.0, 0.7, 0.9]];

/// The dots of a circle's direction: radians.
const DOT: f64 = 0.0065;

/// Returns the axes of the room and the directions halfway between them, with their colours.
fn centres() -> Vec<(DVec3, Colour)> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(|x| {
        let rest = steps
            .into_iter()
            .flat_map(move |y| steps.map(move |z| (y, z)));
        rest.map(move |(y, z)| DVec3::new(x, y, z))
    });
    let all = all.filter(|direction| *direction != DVec3::ZERO);
    let coloured = all.map(|direction| {
        let parts = direction.length_squared() as usize;
        (direction.normalize(), COLOURS[parts - 1])
    });
    coloured.collect()
}

pub(crate) fn circles(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    let sheet = Sheet::new(view);
    let eye = view.viewer.eye(view.eye);
    let width = (sheet.size.min_element() / 350.0).max(1.5);
    let centres = centres();
    let nearest = |sight: DVec3| {
        let pairs = centres
            .iter()
            .map(|&(centre, colour)| (sight.dot(centre), centre, colour));
        pairs.max_by(|one, other| one.0.total_cmp(&other.0))
    };
    let mut picture = sheet.paint(|at| {
        let sight = |at: DVec2| (sheet.point(at) - eye).normalize();
        let middle = sight(at);
        // How far it is to a line follows from how fast the angle grows from pixel to pixel.
        let sights = [
            middle,
            sight(at + 0.5 * DVec2::X),
            sight(at + 0.5 * DVec2::Y),
        ];
        let circle = |centre: DVec3, degrees: f64| {
            let [angle, right, down] = sights.map(|sight| sight.dot(centre).min(1.0).acos());
            let per_pixel = 2.0 * libm::hypot(right - angle, down - angle);
            stroke((angle - degrees.to_radians()) / per_pixel, width)
        };
        let mut light = BLACK;
        let axis = middle.abs().cmpeq(DVec3::splat(middle.abs().max_element()));
        let axis = (middle.signum() * DVec3::select(axis, DVec3::ONE, DVec3::ZERO)).normalize();
        light = mixed(light, COLOURS[0], circle(axis, WIDE));
        if let Some((_, centre, colour)) = nearest(middle) {
            for degrees in RADII {
                light = mixed(light, colour, circle(centre, degrees));
            }
        }
        light
    })?;
    for (centre, colour) in centres {
        let level = libm::hypot(centre.x, centre.z);
        let yaw = libm::atan2(centre.x, -centre.z) * f64::from(u8::from(level > 1.0e-9));
        let pitch = libm::atan2(centre.y, level);
        for (angle, lines) in [(yaw, -0.6), (pitch, 0.6)] {
            let text = format!("{:.0}°", angle.to_degrees() + 0.0);
            let mut sign = Sign::across(&text, eye, centre, lines, DOT);
            sign.ink = colour;
            sheet.show(&mut picture, &sign, eye);
        }
    }
    Ok(picture)
}
