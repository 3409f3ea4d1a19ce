//! What a monitor shows of the pictures of its screen.

use crate::cave::Eye;
use crate::outputs::{Corner, Output};
use crate::picture::{Picture, srgb_of_pixel};
use crate::projection::Projection;
use crate::show::ShowError;
use crate::show::stereo::Stereo;
use rayon::prelude::*;

/// The side of a sync patch as a part of the shorter side of the monitor.
const PATCH: u32 = 12;

/// Puts the pictures of the left eye and of the right one into rows of 0xRRGGBB, as a projector has
/// to show them or stretched over the monitor. `eye` is that of a monitor that shows the eyes by
/// turns.
///
/// # Errors
/// Pictures of another size than the projector's screen has, or the other eye's.
pub(super) fn compose(
    output: &Output,
    projection: Option<&Projection>,
    stereo: Stereo,
    [left, right]: [&Picture; 2],
    eye: Eye,
    size: [u32; 2],
    pixels: &mut [u32],
) -> Result<(), ShowError> {
    let fill = |picture: &Picture, to: &mut [u32]| {
        if let Some(projection) = projection {
            return projection.show(picture, to).map_err(ShowError::from);
        }
        stretch(picture, size, to);
        Ok(())
    };
    let [first, second] = if output.swap_eyes {
        [right, left]
    } else {
        [left, right]
    };
    match stereo {
        _ if output.eye.is_some() => fill(left, pixels),
        Stereo::Mono => fill(first, pixels),
        Stereo::Sequential => fill(if eye == Eye::Right { second } else { first }, pixels),
        Stereo::Anaglyph => {
            let both = stereo.compose(first, second)?;
            fill(&both[0].picture, pixels)
        }
        Stereo::SideBySide | Stereo::TopBottom => {
            let mut other = vec![0; pixels.len()];
            fill(first, pixels)?;
            fill(second, &mut other)?;
            pack(stereo, pixels, &mut other, size[0] as usize);
            Ok(())
        }
    }
}

/// Puts two pictures of the monitor's size into one, each with half of its columns or rows.
fn pack(stereo: Stereo, first: &mut [u32], second: &mut [u32], columns: usize) {
    if stereo == Stereo::SideBySide {
        let rows = first
            .par_chunks_mut(columns)
            .zip(second.par_chunks(columns));
        rows.for_each(|(first, second)| {
            let half = columns / 2;
            for x in 0..half {
                first[x] = mean(first[2 * x], first[2 * x + 1]);
            }
            for (x, pair) in second.chunks_exact(2).enumerate() {
                first[half + x] = mean(pair[0], pair[1]);
            }
        });
        return;
    }
    let half = first.len() / columns / 2;
    for y in 0..half {
        for x in 0..columns {
            let [above, below] = [2 * y, 2 * y + 1].map(|row| row * columns + x);
            first[y * columns + x] = mean(first[above], first[below]);
            second[y * columns + x] = mean(second[above], second[below]);
        }
    }
    let packed = half * columns;
    first[packed..2 * packed].copy_from_slice(&second[..packed]);
}

/// Returns the mean of two codes, channel by channel.
const fn mean(one: u32, other: u32) -> u32 {
    // Carries of a channel's lowest bit must not go into the next.
    (one & other) + (((one ^ other) & 0x00FE_FEFE) >> 1)
}

/// Stretches a picture over columns and rows, bilinearly.
fn stretch(picture: &Picture, [columns, rows]: [u32; 2], to: &mut [u32]) {
    let part = |x| between(x, columns, picture.width);
    let across: Vec<_> = (0..columns).map(part).collect();
    let width = picture.width as usize;
    let lines = to.par_chunks_mut((columns as usize).max(1)).zip(0..rows);
    lines.for_each(|(to, y)| {
        let (first, second, down) = between(y, rows, picture.height);
        let line = |row: usize| picture.pixels.get(row * width..).unwrap_or_default();
        let lines = [line(first), line(second)];
        for (to, &(left, right, along)) in to.iter_mut().zip(&across) {
            let [above, below] = lines.map(|line| {
                let at = |x: usize| line.get(x).copied().unwrap_or_default();
                mixed(at(left), at(right), along)
            });
            let [red, green, blue] = srgb_of_pixel(mixed(above, below, down));
            *to = u32::from_be_bytes([0, red, green, blue]);
        }
    });
}

/// Returns the two of `count` centres between which one of `of` is, and its part of the second.
fn between(number: u32, of: u32, count: u32) -> (usize, usize, f32) {
    let last = f64::from(count.saturating_sub(1));
    let place = (f64::from(number) + 0.5) / f64::from(of);
    let at = (place * f64::from(count) - 0.5).clamp(0.0, last);
    // A picture of the same size is shown as it is.
    let whole = at.round();
    let at = if (at - whole).abs() < 1.0e-6 {
        whole
    } else {
        at
    };
    let first = at.floor();
    (
        first as usize,
        (first + 1.0).min(last) as usize,
        (at - first) as f32,
    )
}

fn mixed(one: [f32; 4], other: [f32; 4], part: f32) -> [f32; 4] {
    // A neighbour without weight must not turn infinity into NaN.
    if part == 0.0 {
        return one;
    }
    std::array::from_fn(|channel| one[channel] + (other[channel] - one[channel]) * part)
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
    use crate::show::stereo::anaglyph;

    fn output(text: &str) -> Output {
        let text = format!("[[output]]\nshow = \"front\"\nmonitor = \"A\"\n{text}");
        let outputs = Output::from_toml(&text, "outputs");
        outputs.expect("an output").remove(0)
    }

    #[test]
    fn each_format_has_each_eye_in_its_place() {
        let plain = |red: f32, green: f32| {
            let pixels = vec![[red, green, 0.0, 1.0]; 12];
            Picture::from_pixels(4, 3, pixels).expect("a picture")
        };
        let (left, right) = (plain(1.0, 0.0), plain(0.0, 1.0));
        let (red, green) = (0x00FF_0000, 0x0000_FF00);
        let shown = |output: &Output, stereo, eye| {
            let mut pixels = vec![7; 8 * 6];
            let eyes = [&left, &right];
            let made = compose(output, None, stereo, eyes, eye, [8, 6], &mut pixels);
            made.expect("pixels");
            [0, 7, 5 * 8, 5 * 8 + 7].map(|at| pixels[at])
        };
        let (plain, swapped) = (output(""), output("swap_eyes = true"));
        let of = |stereo| shown(&plain, stereo, Eye::Left);
        assert_eq!(of(Stereo::Mono), [red; 4]);
        assert_eq!(of(Stereo::SideBySide), [red, green, red, green]);
        assert_eq!(of(Stereo::TopBottom), [red, red, green, green]);
        let [red_part, ..] = srgb_of_pixel(anaglyph([1., 0., 0., 1.], [0., 1., 0., 1.]));
        assert_eq!(
            of(Stereo::Anaglyph).map(|pixel| pixel >> 16),
            [u32::from(red_part); 4]
        );
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
        let (size, eyes) = ([16, 16], [&picture, &picture]);
        let mut pixels = vec![0; 256];
        let made = compose(
            &output(""),
            None,
            Stereo::Mono,
            eyes,
            Eye::Left,
            size,
            &mut pixels,
        );
        made.expect("pixels");
        let codes: Vec<u32> = (picture.pixels.iter())
            .map(|&pixel| srgb_of_pixel(pixel))
            .map(|[red, green, blue]| u32::from_be_bytes([0, red, green, blue]))
            .collect();
        assert_eq!(pixels, codes);
        patch(Corner::LowerRight, true, size, &mut pixels);
        assert_eq!(pixels[255], 0x00FF_FFFF);
        assert_eq!(pixels[..255], codes[..255]);
    }
}
