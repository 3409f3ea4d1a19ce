//! Pictures of what the level of detail does.

use super::{level, places};
use crate::picture::{Picture, PictureError, srgb_from_linear};
use colorous::VIRIDIS;
use shisen_core::frame::{Budget, LARGEST_STRIDE, LevelOfDetail, Renderer, View, Workspace};
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

/// How far apart the samples of a renderer are around each pixel, before they are
/// refined: yellow where every pixel has its own, a quarter of the way to dark
/// violet (viridis) for each doubling.
///
/// # Errors
/// A picture that there is no memory for.
pub fn sampling<const W: usize>(
    renderer: &Renderer<'_, W>,
    view: &View,
) -> Result<Picture, PictureError>
where
    Simd: Runs<W>,
{
    let mut picture = Picture::new(view.columns(), view.rows())?;
    let doublings = LARGEST_STRIDE.ilog2() as f32;
    for (x, y) in places(view) {
        let stride = renderer.stride(view, x, y);
        let share = 1.0 - stride.ilog2() as f32 / doublings;
        picture.set_pixel(x, y, viridis(share, 1.0));
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

/// How far two pictures are apart as a display shows them: black where their
/// 8-bit codes are equal; else, by the channel that is farthest apart, from a
/// grey of a quarter for a single code to white for a quarter of the range and
/// more.
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

/// A colour of the scale, 0 to 1, at a brightness, 0 to 1: linear.
fn viridis(value: f32, brightness: f32) -> [f32; 4] {
    let colour = VIRIDIS.eval_continuous(f64::from(value.clamp(0.0, 1.0)));
    let linear = |channel: u8| (f32::from(channel) / 255.0).powf(2.2) * brightness;
    [linear(colour.r), linear(colour.g), linear(colour.b), 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_code_shows_and_nothing_else_is_black() {
        // The middle of a code's range, so that rounding finds it again.
        let linear = |code: u8| {
            let encoded = f64::from(code) / 255.0;
            let linear = if encoded <= 0.040_45 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            };
            linear as f32
        };
        let picture = |channel: usize, codes: &[u8]| {
            let pixels = codes.iter().map(|&code| {
                let mut pixel = [0.0, 0.0, 0.0, 1.0];
                pixel[channel] = linear(code);
                pixel
            });
            Picture::from_pixels(codes.len() as u32, 1, pixels.collect()).unwrap()
        };
        for channel in 0..3 {
            for base in [0, 1, 100, 191] {
                let all: Vec<u8> = (base..=base + 64).collect();
                let a = picture(channel, &vec![base; all.len()]);
                let seen = difference(&a, &picture(channel, &all)).unwrap();
                assert_eq!(seen, difference(&picture(channel, &all), &a).unwrap());
                let codes: Vec<u8> = seen
                    .pixels
                    .iter()
                    .map(|&[red, green, blue, alpha]| {
                        assert_eq!((red, green, alpha), (green, blue, 1.0));
                        srgb_from_linear(red)
                    })
                    .collect();
                assert_eq!((codes[0], codes[64]), (0, 255), "{base}");
                assert!((55..80).contains(&codes[1]), "{codes:?}");
                assert!(codes.is_sorted_by(|a, b| a < b), "{codes:?}");
            }
            let ends = difference(&picture(channel, &[0, 255]), &picture(channel, &[255, 0]));
            assert_eq!(ends.unwrap().pixels, [[1.0; 4]; 2]);
        }
        // What no display shows is no difference.
        let within = Picture::from_pixels(1, 1, vec![[1e-6, 2.0, 0.0, 1.0]]).unwrap();
        let other = Picture::from_pixels(1, 1, vec![[0.0, 1.0, -1.0, 0.0]]).unwrap();
        assert_eq!(
            difference(&within, &other).unwrap().pixels,
            [[0.0, 0.0, 0.0, 1.0]]
        );
    }
}
