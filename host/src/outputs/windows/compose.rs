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
    let halves = |count: f64| Across::new(count as usize, left.width);
    match (output.eye, stereo) {
        (Some(_), _) | (None, Stereo::Mono) => {
            let across = halves(columns);
            bands.for_each(|(y, to)| across.line(left, along(y, rows), to));
        }
        (None, Stereo::Sequential) => {
            let across = halves(columns);
            bands.for_each(|(y, to)| across.line(of(eye), along(y, rows), to));
        }
        (None, Stereo::SideBySide) => {
            let [first, second] = [columns / 2.0, columns - (columns / 2.0).floor()].map(halves);
            bands.for_each(|(y, to)| {
                let (to_left, to_right) = to.split_at_mut(to.len() / 2);
                first.line(left, along(y, rows), to_left);
                second.line(right, along(y, rows), to_right);
            });
        }
        (None, Stereo::TopBottom) => {
            let across = halves(columns);
            bands.for_each(|(y, to)| {
                let at = 2.0 * along(y, rows);
                let picture = if at < 1.0 { left } else { right };
                across.line(picture, at.fract(), to);
            });
        }
        (None, Stereo::Anaglyph) => {
            let across = halves(columns);
            bands.for_each(|(y, to)| {
                let [left, right] = [left, right].map(|one| across.lights(one, along(y, rows)));
                for (to, (left, right)) in to.iter_mut().zip(left.zip(right)) {
                    *to = code(anaglyph(left, right));
                }
            });
        }
    }
}

/// Returns the middle of a pixel, 0 to 1 along `count` of them.
fn along(number: usize, count: f64) -> f64 {
    (number as f64 + 0.5) / count
}

/// Which columns of a picture, and how much of the second, each pixel of a row shows.
struct Across(Vec<(u32, u32, f32)>);

impl Across {
    /// Stretches so many columns of a picture over a row.
    fn new(row: usize, columns: u32) -> Self {
        let part = |x| {
            let (first, second, part) = between(along(x, row as f64), columns);
            (first as u32, second as u32, part)
        };
        Self((0..row).map(part).collect())
    }

    /// Returns the light of a line at a height, 0 to 1 from the top, bilinearly.
    fn lights<'p>(&'p self, picture: &'p Picture, y: f64) -> impl Iterator<Item = [f32; 4]> + 'p {
        let (first, second, down) = between(y, picture.height);
        let width = picture.width as usize;
        let line = move |row: usize| picture.pixels.get(row * width..).unwrap_or_default();
        let lines = [line(first), line(second)];
        self.0.iter().map(move |&(left, right, along)| {
            let [above, below] = lines.map(|line| {
                let at = |x: u32| line.get(x as usize).copied().unwrap_or_default();
                mixed(at(left), at(right), along)
            });
            mixed(above, below, down)
        })
    }

    fn line(&self, picture: &Picture, y: f64, to: &mut [u32]) {
        for (to, light) in to.iter_mut().zip(self.lights(picture, y)) {
            *to = code(light);
        }
    }
}

/// Returns the two of `count` centres between which a place is, 0 to 1 along them, and how much of
/// the second it has.
fn between(place: f64, count: u32) -> (usize, usize, f32) {
    let last = f64::from(count.saturating_sub(1));
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
