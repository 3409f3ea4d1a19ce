use super::Picture;
use palette::color_difference::Ciede2000;
use palette::{IntoColor, Lab, LinSrgb};
use rayon::prelude::*;

/// How far apart the colours of two pictures are, pixel by pixel, as a display
/// shows them: CIEDE2000 of the colours clipped to sRGB. A difference up to about 1 is not seen.
/// Compares as many pixels as the smaller picture has.
pub fn colour_differences(one: &Picture, other: &Picture) -> Vec<f32> {
    let pairs = one.pixels.par_iter().zip(&other.pixels);
    pairs
        .map(|(one, other)| shown(*one).difference(shown(*other)))
        .collect()
}

/// A linear colour clipped to what a display shows.
fn shown([red, green, blue, _]: [f32; 4]) -> Lab {
    let clip = |channel: f32| channel.clamp(0.0, 1.0);
    LinSrgb::new(clip(red), clip(green), clip(blue)).into_color()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[[f32; 3]]) -> Picture {
        let mut picture = Picture::new(pixels.len() as u32, 1).unwrap();
        for (pixel, [r, g, b]) in picture.pixels.iter_mut().zip(pixels) {
            *pixel = [*r, *g, *b, 1.0];
        }
        picture
    }

    #[test]
    fn differences_are_of_what_is_shown() {
        let one = picture(&[[0.0; 3], [1.0; 3], [0.5, 0.2, 0.1], [1.0, 0.0, 0.0]]);
        let other = picture(&[[-3.0, 0.0, 0.0], [7.0; 3], [0.5, 0.2, 0.1], [0.0; 3]]);
        let found = colour_differences(&one, &other);
        assert_eq!(found[..3], [0.0; 3]);
        // Lab 53.24 80.09 67.20 against black, by the formula's authors' sheet.
        assert!((found[3] - 50.41).abs() < 0.1, "{}", found[3]);
        let grey = colour_differences(&picture(&[[0.0; 3]]), &picture(&[[1.0; 3]]));
        assert!((grey[0] - 100.0).abs() < 0.01, "{grey:?}");
    }
}
