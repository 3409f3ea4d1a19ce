//! Pictures for two eyes on one display: one after the other, beside each other, or in the
//! colours of glasses.

use crate::cave::Eye;
use crate::picture::{Picture, PictureError};
use crate::show::ShowError;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// How a pair of pictures is shown. The left eye's always comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stereo {
    /// The first eye's picture alone.
    #[default]
    Mono,
    /// One after the other, for shutter glasses: the paper's.
    Sequential,
    /// The left eye's on the left.
    SideBySide,
    /// The left eye's above.
    TopBottom,
    /// One picture for red-cyan glasses, the left eye behind red.
    Anaglyph,
}

named!(Stereo {
    Mono => "mono",
    Sequential => "sequential",
    SideBySide => "side-by-side",
    TopBottom => "top-bottom",
    Anaglyph => "anaglyph",
});

/// A picture and the eye that it is for.
#[derive(Debug, Clone, PartialEq)]
pub struct Presented {
    /// The eye; `None` for both.
    pub eye: Option<Eye>,
    /// The picture.
    pub picture: Picture,
}

/// A name that no format has.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no stereo \"{0}\": use mono, sequential, side-by-side, top-bottom or anaglyph")]
pub struct UnknownStereo(pub String);

/// The weights of the left eye's red, green and blue, then of the right eye's, in each channel of
/// an anaglyph, in linear light: the least-squares projection onto what red-cyan glasses let
/// through of a CRT's primaries.
///
/// E. Dubois, "A projection method to generate anaglyph stereo images", Proc. IEEE ICASSP
/// 2001, vol. 3, pp. 1661–1664, with the numbers that he published. Each row adds up to 1
/// within 10⁻⁵, so that greys seen by both eyes stay the same.
const DUBOIS: [[[f32; 3]; 2]; 3] = [
    [
        [0.456_1, 0.500_484, 0.176_381],
        [-0.043_470_6, -0.087_938_8, -0.001_555_29],
    ],
    [
        [-0.040_082_2, -0.037_824_6, -0.015_758_9],
        [0.378_476, 0.733_64, -0.018_450_3],
    ],
    [
        [-0.015_216_1, -0.020_597_1, -0.005_468_56],
        [-0.072_152_7, -0.112_961, 1.226_4],
    ],
];

impl Stereo {
    /// Returns the eyes in the order in which they are shown, or behind red and behind cyan.
    pub const fn eye_order(self) -> &'static [Eye] {
        match self {
            Self::Mono => &[],
            _ => &Eye::STEREO,
        }
    }

    /// Composes a pair: two pictures for [`Sequential`](Self::Sequential), the left eye's for
    /// [`Mono`](Self::Mono), or else one of both.
    ///
    /// # Errors
    /// Pictures of different sizes; a pair that is too large for a picture.
    pub fn compose(self, left: &Picture, right: &Picture) -> Result<Vec<Presented>, ShowError> {
        let sizes = [left, right].map(|one| [one.width, one.height]);
        let counts = [left, right].map(|one| one.pixels.len());
        if sizes[0] != sizes[1] || counts[0] != counts[1] {
            return Err(ShowError::Sizes(sizes[0], sizes[1]));
        }
        let single = |eye: Eye, picture: &Picture| Presented {
            eye: Some(eye),
            picture: picture.clone(),
        };
        let [width, height] = sizes[0];
        let picture = match self {
            Self::Mono => return Ok(vec![single(Eye::Left, left)]),
            Self::Sequential => {
                return Ok(vec![single(Eye::Left, left), single(Eye::Right, right)]);
            }
            Self::SideBySide => {
                let size = [width.saturating_mul(2), height];
                joined(left, right, size, width as usize)?
            }
            Self::TopBottom => {
                let size = [width, height.saturating_mul(2)];
                joined(left, right, size, counts[0])?
            }
            Self::Anaglyph => {
                let pairs = left.pixels.iter().zip(&right.pixels);
                let pixels = pairs.map(|(&left, &right)| anaglyph(left, right)).collect();
                Picture::from_pixels(width, height, pixels)?
            }
        };
        Ok(vec![Presented { eye: None, picture }])
    }

    /// Returns the notes in a picture's file: `Stereo-Format`, with two eyes `Stereo-Eye-Order`,
    /// and for a picture of one eye `Stereo-Eye`.
    pub fn metadata(self, eye: Option<Eye>) -> Vec<(&'static str, String)> {
        let mut notes = vec![("Stereo-Format", self.name().to_owned())];
        if let [first, second] = self.eye_order() {
            notes.push(("Stereo-Eye-Order", format!("{first} {second}")));
        }
        notes.extend(eye.map(|eye| ("Stereo-Eye", eye.name().to_owned())));
        notes
    }
}

impl fmt::Display for Stereo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Stereo {
    type Err = UnknownStereo;

    fn from_str(name: &str) -> Result<Self, UnknownStereo> {
        let mut all = Self::ALL.into_iter();
        let known = all.find(|one| one.name() == name);
        known.ok_or_else(|| UnknownStereo(name.into()))
    }
}

/// Returns a pixel of an anaglyph by Dubois's weights, clamped to 0 to 1. It is covered where
/// either eye's is.
pub fn anaglyph(left: [f32; 4], right: [f32; 4]) -> [f32; 4] {
    let [lr, lg, lb, left_alpha] = left;
    let [rr, rg, rb, right_alpha] = right;
    let eyes = [lr, lg, lb, rr, rg, rb];
    let [red, green, blue] = DUBOIS.map(|row| {
        let weights = row.as_flattened().iter();
        let sum: f32 = weights.zip(eyes).map(|(part, light)| part * light).sum();
        // A NaN would go on into the file.
        let is_number = !sum.is_nan();
        if is_number { sum.clamp(0.0, 1.0) } else { 0.0 }
    });
    [red, green, blue, left_alpha.max(right_alpha)]
}

/// Joins two pictures by turns of `run` pixels of each.
fn joined(
    left: &Picture,
    right: &Picture,
    [width, height]: [u32; 2],
    run: usize,
) -> Result<Picture, PictureError> {
    let mut both = Picture::new(width, height)?;
    let [left, right] = [left, right].map(|picture| picture.pixels.chunks(run.max(1)));
    let pixels = left
        .zip(right)
        .flat_map(|(left, right)| left.iter().chain(right));
    for (to, from) in both.pixels.iter_mut().zip(pixels) {
        *to = *from;
    }
    Ok(both)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_have_names_and_pictures_of_one_size() {
        let picture = |width, height| Picture::new(width, height).unwrap();
        for stereo in Stereo::ALL {
            assert_eq!(stereo.name().parse(), Ok(stereo));
            let error = stereo.compose(&picture(3, 2), &picture(2, 3)).unwrap_err();
            assert!(error.to_string().contains("3 × 2 pixels and"), "{error}");
            assert!(stereo.compose(&picture(0, 0), &picture(0, 0)).is_ok());
        }
        assert!("both".parse::<Stereo>().is_err());
    }

    #[test]
    fn glasses_see_greys_as_they_are_and_each_its_eye() {
        for grey in [0.0, 0.2, 0.7, 1.0] {
            let same = [grey, grey, grey, 1.0];
            for channel in &anaglyph(same, same)[..3] {
                assert!((channel - grey).abs() < 2.0e-5, "{channel} of {grey}");
            }
        }
        // The left eye's light is red, the right eye's cyan; green in the left eye alone is as
        // the source says.
        let (white, black) = ([1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]);
        assert_eq!(anaglyph(white, black), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(anaglyph(black, white), [0.0, 1.0, 1.0, 1.0]);
        let green = anaglyph([0.0, 1.0, 0.0, 1.0], black);
        assert_eq!(green, [0.500_484, 0.0, 0.0, 1.0]);
        let dark = anaglyph([f32::NAN; 4], white);
        assert!(dark.iter().all(|channel| !channel.is_nan()), "{dark:?}");
    }
}
