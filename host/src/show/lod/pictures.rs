//! Pictures of the level of detail.

use super::{level, places};
use crate::picture::{Picture, PictureError, srgb_from_linear};
use colorous::VIRIDIS;
use shisen_core::frame::{Budget, LARGEST_UNIT, LevelOfDetail, Renderer, View, Workspace};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};

const OUTSIDE: [f32; 4] = [0.02, 0.02, 0.02, 1.0];

const BORDER: [f32; 4] = [1.0, 1.0, 1.0, 1.0];

/// Draws the level of each pixel from dark violet at 0 to yellow at 1 (viridis), dark grey where
/// nothing is traced, and the borders of the central and of the whole field white.
pub(crate) fn levels(view: &View, lod: &LevelOfDetail) -> Result<Picture, PictureError> {
    let mut picture = Picture::new(view.columns(), view.rows())?;
    let zone = |x: u32, y: u32| match level(view, lod, x, y) {
        1.0 => 2,
        0.0 => 0,
        _ => 1,
    };
    for (x, y) in places(view) {
        let own = zone(x, y);
        let right = (x + 1).min(view.columns() - 1);
        let below = (y + 1).min(view.rows() - 1);
        let colour = if zone(right, y) != own || zone(x, below) != own {
            BORDER
        } else if own == 0 {
            OUTSIDE
        } else {
            viridis(level(view, lod, x, y), 1.0)
        };
        picture.set_pixel(x, y, colour);
    }
    Ok(picture)
}

/// Draws how many pixels are one: yellow where each is alone, and a third of the way to dark violet
/// (viridis) for each doubling of their side.
pub(crate) fn units<const W: usize>(
    renderer: &Renderer<'_, W>,
    view: &View,
) -> Result<Picture, PictureError>
where
    Simd: Runs<W>,
{
    let mut picture = Picture::new(view.columns(), view.rows())?;
    let doublings = LARGEST_UNIT.ilog2() as f32;
    for (x, y) in places(view) {
        let unit = renderer.unit(view, x, y);
        let share = 1.0 - unit.ilog2() as f32 / doublings;
        picture.set_pixel(x, y, viridis(share, 1.0));
    }
    Ok(picture)
}

/// Draws the faces that each pixel's rays see: each face of a mesh with its own brightness, and
/// coloured by the share of faces on its rung (violet none to yellow all); dimmed where no
/// mesh is hit, dark grey where nothing is traced.
pub(crate) fn polygons<const W: usize>(
    scene: &Scene<'_, W>,
    renderer: &Renderer<'_, W>,
    view: &View,
) -> Result<Picture, PictureError>
where
    Simd: Runs<W>,
{
    let mut picture = Picture::new(view.columns(), view.rows())?;
    let mut workspace = Workspace::new();
    let steps = f32::from(scene.rungs().max(2) - 1);
    for (x, y) in places(view) {
        let Some(detail) = renderer.detail(view, x, y) else {
            picture.set_pixel(x, y, OUTSIDE);
            continue;
        };
        let ray = view.ray(x as f32, y as f32);
        let hit = ray.and_then(|ray| {
            let tracer = renderer.tracer().at_rung(detail.rung);
            tracer.nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace)
        });
        let brightness = hit.map_or(0.15, |hit| {
            // The golden ratio's multiples spread any run of numbers evenly.
            let number = hit.on.triangle.wrapping_add(hit.instance * 7_919);
            0.45 + 0.55 * (number as f64 * 0.618_033_988_749_895).fract() as f32
        });
        let share = 1.0 - f32::from(detail.rung) / steps;
        picture.set_pixel(x, y, viridis(share, brightness));
    }
    Ok(picture)
}

/// Draws the difference of two pictures in the codes that a display shows, by the channel that is
/// farthest apart: black where codes are equal, from a quarter grey for a single code to white
/// for a quarter of the range and more.
///
/// # Errors
/// Not enough memory.
pub fn difference(a: &Picture, b: &Picture) -> Result<Picture, PictureError> {
    let mut picture = Picture::new(a.width, a.height)?;
    let pairs = a.pixels.iter().zip(&b.pixels);
    for (pixel, (a, b)) in picture.pixels.iter_mut().zip(pairs) {
        let apart = (0..3).map(|c| srgb_from_linear(a[c]).abs_diff(srgb_from_linear(b[c])));
        let grey = match apart.max() {
            // Displays and eyes do not tell the darkest greys from black.
            Some(codes @ 1..) => 0.25 + 0.75 * (f32::from(codes - 1) / 63.0).min(1.0),
            _ => 0.0,
        };
        let linear = grey.powf(2.2);
        *pixel = [linear, linear, linear, 1.0];
    }
    Ok(picture)
}

fn viridis(value: f32, brightness: f32) -> [f32; 4] {
    let colour = VIRIDIS.eval_continuous(f64::from(value.clamp(0.0, 1.0)));
    let linear = |channel: u8| (f32::from(channel) / 255.0).powf(2.2) * brightness;
    [linear(colour.r), linear(colour.g), linear(colour.b), 1.0]
}
