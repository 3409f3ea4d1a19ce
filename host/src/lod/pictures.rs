//! Pictures of what the level of detail does.

use super::{level, places};
use crate::picture::{Picture, PictureError};
use colorous::VIRIDIS;
use shisen_core::frame::{Budget, LevelOfDetail, Renderer, View, Workspace};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};

/// Of pixels that are not traced.
const OUTSIDE: [f32; 4] = [0.02, 0.02, 0.02, 1.0];

/// Of the borders of the central and of the whole field.
const BORDER: [f32; 4] = [1.0, 1.0, 1.0, 1.0];

/// The level of each pixel: dark violet at 0 to yellow at 1 (viridis), dark
/// grey where nothing is traced, the borders of the central and of the whole
/// field white.
///
/// # Errors
/// A picture that there is no memory for.
pub fn levels(view: &View, lod: &LevelOfDetail) -> Result<Picture, PictureError> {
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

/// The faces that each pixel's rays see: those of meshes each with a
/// brightness of its own, coloured by the share of the meshes' faces there are
/// on its rung (violet none to yellow all); dimmed where no mesh is hit, dark
/// grey where nothing is traced.
///
/// # Errors
/// A picture that there is no memory for.
pub fn polygons<const W: usize>(
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

/// How far two pictures are apart as a display shows them: black where they
/// are equal, white where a channel is farther apart than a quarter of its
/// range.
///
/// # Errors
/// A picture that there is no memory for.
pub fn difference(a: &Picture, b: &Picture) -> Result<Picture, PictureError> {
    let mut picture = Picture::new(a.width, a.height)?;
    for (pixel, (a, b)) in picture
        .pixels
        .iter_mut()
        .zip(a.pixels.iter().zip(&b.pixels))
    {
        let apart = (0..3).map(|c| {
            let shown = |linear: f32| f32::from(crate::picture::srgb_from_linear(linear)) / 255.0;
            (shown(a[c]) - shown(b[c])).abs()
        });
        let grey = (4.0 * apart.fold(0.0, f32::max)).min(1.0);
        let linear = grey.powf(2.2);
        *pixel = [linear, linear, linear, 1.0];
    }
    Ok(picture)
}

/// A colour of the scale, 0 to 1, at a brightness, 0 to 1: linear.
fn viridis(value: f32, brightness: f32) -> [f32; 4] {
    let colour = VIRIDIS.eval_continuous(f64::from(value.clamp(0.0, 1.0)));
    let linear = |channel: u8| (f32::from(channel) / 255.0).powf(2.2) * brightness;
    [linear(colour.r), linear(colour.g), linear(colour.b), 1.0]
}
