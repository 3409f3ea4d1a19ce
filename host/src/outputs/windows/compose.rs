//! What a monitor shows of the pictures of its screen.

use crate::cave::Eye;
use crate::outputs::{Corner, Output};
use crate::picture::{Picture, srgb_of_pixel};
use crate::show::stereo::{Stereo, anaglyph};
use rayon::prelude::*;

/// The side of a sync patch as a part of the shorter side of the monitor.
const PATCH: u32 = 12;

/// The pictures of a screen: of one eye, or of the left one and the right one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eyes<'p> {
    pub(super) left: &'p Picture,
    pub(super) right: &'p Picture,
}

/// Puts pictures into rows of 0xRRGGBB, `size` columns and rows. `eye` is that of a monitor that
/// shows the eyes by turns.
pub(super) fn compose(
    output: &Output,
    stereo: Stereo,
    eyes: Eyes<'_>,
    eye: Eye,
    [columns, rows]: [u32; 2],
    pixels: &mut [u32],
) {
    let [left, right] = if output.swap_eyes {
        [eyes.right, eyes.left]
    } else {
        [eyes.left, eyes.right]
    };
    let of = |eye| if eye == Eye::Right { right } else { left };
    let width = columns.max(1) as usize;
    let bands = pixels.par_chunks_mut(width).enumerate();
    let [columns, rows] = [columns, rows].map(f64::from);
    let row = |picture: &Picture, y: f64, to: &mut [u32]| stretch(picture, y, to);
    match (output.eye, stereo) {
        (Some(_), _) => bands.for_each(|(y, to)| row(left, along(y, rows), to)),
        (None, Stereo::Mono | Stereo::Sequential) => {
            bands.for_each(|(y, to)| row(of(eye), along(y, rows), to));
        }
        (None, Stereo::SideBySide) => bands.for_each(|(y, to)| {
            let (first, second) = to.split_at_mut(to.len() / 2);
            row(left, along(y, rows), first);
            row(right, along(y, rows), second);
        }),
        (None, Stereo::TopBottom) => bands.for_each(|(y, to)| {
            let at = 2.0 * along(y, rows);
            let picture = if at < 1.0 { left } else { right };
            row(picture, at.fract(), to);
        }),
        (None, Stereo::Anaglyph) => bands.for_each(|(y, to)| {
            let at = along(y, rows);
            for (x, to) in to.iter_mut().enumerate() {
                let [left, right] = [left, right].map(|one| sample(one, along(x, columns), at));
                *to = code(anaglyph(left, right));
            }
        }),
    }
}

/// Returns the middle of a pixel, 0 to 1 along `count` of them.
fn along(number: usize, count: f64) -> f64 {
    (number as f64 + 0.5) / count
}

fn sample(picture: &Picture, x: f64, y: f64) -> [f32; 4] {
    picture.sample(x * f64::from(picture.width), y * f64::from(picture.height))
}

/// Puts a picture's line at a height, 0 to 1 from the top, into a row of any length.
fn stretch(picture: &Picture, y: f64, to: &mut [u32]) {
    let (width, row) = (picture.width as usize, y * f64::from(picture.height) - 0.5);
    let same = (row - row.round()).abs() < 1.0e-6 && to.len() == width;
    let line = (row.round().max(0.0) as usize).checked_mul(width);
    let line = line.and_then(|first| picture.pixels.get(first..first + width));
    if let Some(line) = line.filter(|_| same) {
        for (to, &pixel) in to.iter_mut().zip(line) {
            *to = code(pixel);
        }
        return;
    }
    let columns = to.len() as f64;
    for (x, to) in to.iter_mut().enumerate() {
        *to = code(sample(picture, along(x, columns), y));
    }
}

fn code(pixel: [f32; 4]) -> u32 {
    let [red, green, blue] = srgb_of_pixel(pixel);
    u32::from_be_bytes([0, red, green, blue])
}

/// Draws a square in a corner, white or black.
pub(super) fn patch(corner: Corner, white: bool, [columns, rows]: [u32; 2], pixels: &mut [u32]) {
    let side = columns.min(rows) / PATCH;
    let is_right = matches!(corner, Corner::UpperRight | Corner::LowerRight);
    let is_low = matches!(corner, Corner::LowerLeft | Corner::LowerRight);
    let left = if is_right { columns - side } else { 0 } as usize;
    let top = if is_low { rows - side } else { 0 } as usize;
    let lines = pixels.chunks_exact_mut(columns.max(1) as usize);
    for line in lines.skip(top).take(side as usize) {
        line[left..left + side as usize].fill(if white { 0x00FF_FFFF } else { 0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(text: &str) -> Output {
        let outputs = Output::from_toml(
            &format!("[[output]]\nscreen = \"front\"\nmonitor = \"A\"\n{text}"),
            "outputs",
        );
        outputs.expect("an output").remove(0)
    }

    #[test]
    fn each_format_has_each_eye_in_its_place() {
        let plain = |red: f32, green: f32| {
            let pixels = vec![[red, green, 0.0, 1.0]; 12];
            Picture::from_pixels(4, 3, pixels).expect("a picture")
        };
        let (left, right) = (plain(1.0, 0.0), plain(0.0, 1.0));
        let eyes = Eyes {
            left: &left,
            right: &right,
        };
        let (red, green) = (0x00FF_0000, 0x0000_FF00);
        let shown = |output: &Output, stereo, eye| {
            let mut pixels = vec![7; 8 * 6];
            compose(output, stereo, eyes, eye, [8, 6], &mut pixels);
            [0, 7, 5 * 8, 5 * 8 + 7].map(|at| pixels[at])
        };
        let (plain, swapped) = (output(""), output("swap_eyes = true"));
        let of = |stereo| shown(&plain, stereo, Eye::Left);
        assert_eq!(of(Stereo::Mono), [red; 4]);
        assert_eq!(of(Stereo::SideBySide), [red, green, red, green]);
        assert_eq!(of(Stereo::TopBottom), [red, red, green, green]);
        let by_turns = Stereo::Sequential;
        assert_eq!(shown(&plain, by_turns, Eye::Right), [green; 4]);
        assert_eq!(shown(&swapped, by_turns, Eye::Right), [red; 4]);
    }

    #[test]
    fn a_picture_of_the_monitors_size_keeps_its_codes() {
        let levels = (0..256_u32).map(|code| {
            let linear = (code as f32 / 255.0).powf(2.2);
            [linear, linear, linear, 1.0]
        });
        let picture = Picture::from_pixels(16, 16, levels.collect()).expect("a picture");
        let eyes = Eyes {
            left: &picture,
            right: &picture,
        };
        let mut pixels = vec![0; 256];
        compose(
            &output(""),
            Stereo::Mono,
            eyes,
            Eye::Left,
            [16, 16],
            &mut pixels,
        );
        let codes: Vec<u32> = picture.pixels.iter().map(|&pixel| code(pixel)).collect();
        assert_eq!(pixels, codes);
        patch(Corner::LowerRight, true, [16, 16], &mut pixels);
        assert_eq!(pixels[255], 0x00FF_FFFF);
        assert_eq!(pixels[..255], codes[..255]);
    }
}
