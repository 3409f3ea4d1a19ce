//! A picture for two eyes on a display that has one: after another, beside one
//! another, or in the colours of glasses.

use crate::cave::Eye;
use crate::picture::{Picture, PictureError};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// How a pair of pictures is shown. The left eye's is always the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stereo {
    /// One eye's alone: the first.
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

/// A picture and whom it is for.
#[derive(Debug, Clone, PartialEq)]
pub struct Presented {
    /// The eye; `None` where it is for both.
    pub eye: Option<Eye>,
    /// What is shown.
    pub picture: Picture,
}

/// Why two pictures make no pair.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StereoError {
    /// They are not of one size.
    #[error(
        "the left eye's picture is {} × {} pixels and the right eye's {} × {}: render both in one \
         size",
        left[0], left[1], right[0], right[1]
    )]
    Sizes {
        /// Columns and rows of the left eye's.
        left: [u32; 2],
        /// Of the right eye's.
        right: [u32; 2],
    },
    /// Both together are too large.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// A name of no way to show a pair.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "there is no stereo \"{given}\": use mono, sequential, side-by-side, top-bottom or anaglyph"
)]
pub struct UnknownStereo {
    /// What was given.
    pub given: String,
}

/// What each channel of an anaglyph takes of the left eye's red, green and blue, and
/// then of the right eye's, in linear light: the projection onto what red-cyan
/// glasses let through of a CRT's primaries that is nearest by least squares.
///
/// E. Dubois, "A projection method to generate anaglyph stereo images", Proc. IEEE
/// ICASSP 2001, vol. 3, pp. 1661–1664, with the numbers that he published for it. Each
/// row adds up to 1 within 10⁻⁵: greys that both eyes see stay the greys they are.
pub const DUBOIS: [[f32; 6]; 3] = [
    [
        0.456_1,
        0.500_484,
        0.176_381,
        -0.043_470_6,
        -0.087_938_8,
        -0.001_555_29,
    ],
    [
        -0.040_082_2,
        -0.037_824_6,
        -0.015_758_9,
        0.378_476,
        0.733_64,
        -0.018_450_3,
    ],
    [
        -0.015_216_1,
        -0.020_597_1,
        -0.005_468_56,
        -0.072_152_7,
        -0.112_961,
        1.226_4,
    ],
];

impl Stereo {
    /// All.
    pub const ALL: [Self; 5] = [
        Self::Mono,
        Self::Sequential,
        Self::SideBySide,
        Self::TopBottom,
        Self::Anaglyph,
    ];

    /// As it is written on a command line and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mono => "mono",
            Self::Sequential => "sequential",
            Self::SideBySide => "side-by-side",
            Self::TopBottom => "top-bottom",
            Self::Anaglyph => "anaglyph",
        }
    }

    /// The eyes in the order in which they are shown: by time, from the left, from
    /// above, or behind red and behind cyan.
    pub const fn eye_order(self) -> &'static [Eye] {
        match self {
            Self::Mono => &[],
            _ => &Eye::STEREO,
        }
    }

    /// What is shown of a pair: of [`Sequential`](Self::Sequential) two pictures, the
    /// left eye's first, else one. Of [`Mono`](Self::Mono) it is the left eye's.
    ///
    /// # Errors
    /// Pictures of different sizes; a pair that is too large for a picture.
    pub fn compose(self, left: &Picture, right: &Picture) -> Result<Vec<Presented>, StereoError> {
        let sizes = [left, right].map(|one| [one.width, one.height]);
        let counts = [left, right].map(|one| one.pixels.len());
        if sizes[0] != sizes[1] || counts[0] != counts[1] {
            return Err(StereoError::Sizes {
                left: sizes[0],
                right: sizes[1],
            });
        }
        let of = |eye: Eye, picture: &Picture| Presented {
            eye: Some(eye),
            picture: picture.clone(),
        };
        let together = |picture: Picture| Presented { eye: None, picture };
        Ok(match self {
            Self::Mono => vec![of(Eye::Left, left)],
            Self::Sequential => vec![of(Eye::Left, left), of(Eye::Right, right)],
            Self::SideBySide => vec![together(side_by_side(left, right)?)],
            Self::TopBottom => vec![together(top_bottom(left, right)?)],
            Self::Anaglyph => vec![together(paired(left, right)?)],
        })
    }

    /// What is noted in the file of a picture: `Stereo-Format`, with two eyes
    /// `Stereo-Eye-Order`, and where it is for one of them `Stereo-Eye`.
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
        Self::ALL
            .into_iter()
            .find(|one| one.name() == name)
            .ok_or_else(|| UnknownStereo { given: name.into() })
    }
}

/// A pixel of an anaglyph: [`DUBOIS`], within 0 and 1. What either eye's covers is
/// covered.
pub fn anaglyph(left: [f32; 4], right: [f32; 4]) -> [f32; 4] {
    let [lr, lg, lb, covered] = left;
    let [rr, rg, rb, also] = right;
    let eyes = [lr, lg, lb, rr, rg, rb];
    let [red, green, blue] = DUBOIS.map(|row| {
        let sum: f32 = row.iter().zip(eyes).map(|(part, light)| part * light).sum();
        // A NaN would go on into the file.
        if sum.is_nan() {
            0.0
        } else {
            sum.clamp(0.0, 1.0)
        }
    });
    [red, green, blue, covered.max(also)]
}

fn side_by_side(left: &Picture, right: &Picture) -> Result<Picture, PictureError> {
    let width = left.width as usize;
    let mut both = Picture::new(left.width.saturating_mul(2), left.height)?;
    let rows = left.pixels.chunks(width.max(1));
    let rows = rows.zip(right.pixels.chunks(width.max(1)));
    for (both, (left, right)) in both.pixels.chunks_mut(2 * width.max(1)).zip(rows) {
        let (first, second) = both.split_at_mut(left.len());
        first.copy_from_slice(left);
        second.copy_from_slice(right);
    }
    Ok(both)
}

fn top_bottom(left: &Picture, right: &Picture) -> Result<Picture, PictureError> {
    let mut both = Picture::new(left.width, left.height.saturating_mul(2))?;
    let (above, below) = both.pixels.split_at_mut(left.pixels.len());
    above.copy_from_slice(&left.pixels);
    below.copy_from_slice(&right.pixels);
    Ok(both)
}

fn paired(left: &Picture, right: &Picture) -> Result<Picture, PictureError> {
    let pairs = left.pixels.iter().zip(&right.pixels);
    let pixels = pairs.map(|(&left, &right)| anaglyph(left, right)).collect();
    Picture::from_pixels(left.width, left.height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each pixel says where it is and whose.
    fn picture(width: u32, height: u32, eye: f32) -> Picture {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x as f32, y as f32)));
        let pixels = places.map(|(x, y)| [x, y, eye, 1.0]).collect();
        Picture::from_pixels(width, height, pixels).unwrap()
    }

    fn one(stereo: Stereo, left: &Picture, right: &Picture) -> Picture {
        let mut shown = stereo.compose(left, right).unwrap();
        assert_eq!((shown.len(), shown[0].eye), (1, None));
        shown.remove(0).picture
    }

    #[test]
    fn left_comes_first() {
        let (left, right) = (picture(3, 2, 0.0), picture(3, 2, 1.0));
        let both = one(Stereo::SideBySide, &left, &right);
        assert_eq!((both.width, both.height), (6, 2));
        for (x, y) in [(0, 0), (2, 1), (1, 1)] {
            assert_eq!(both.pixel(x, y), left.pixel(x, y));
            assert_eq!(both.pixel(x + 3, y), right.pixel(x, y));
        }
        let both = one(Stereo::TopBottom, &left, &right);
        assert_eq!((both.width, both.height), (3, 4));
        for (x, y) in [(0, 0), (2, 1), (1, 1)] {
            assert_eq!(both.pixel(x, y), left.pixel(x, y));
            assert_eq!(both.pixel(x, y + 2), right.pixel(x, y));
        }
        let shown = Stereo::Sequential.compose(&left, &right).unwrap();
        let eyes: Vec<_> = shown.iter().map(|one| one.eye).collect();
        assert_eq!(eyes, [Some(Eye::Left), Some(Eye::Right)]);
        assert_eq!((&shown[0].picture, &shown[1].picture), (&left, &right));
        let shown = Stereo::Mono.compose(&left, &right).unwrap();
        assert_eq!((shown.len(), &shown[0].picture), (1, &left));
    }

    #[test]
    fn glasses_see_greys_as_they_are_and_each_its_eye() {
        for grey in [0.0, 0.2, 0.7, 1.0] {
            let same = [grey, grey, grey, 1.0];
            for channel in &anaglyph(same, same)[..3] {
                assert!((channel - grey).abs() < 2.0e-5, "{channel} of {grey}");
            }
        }
        let (white, black) = ([1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0]);
        // The left eye's light is red, the right eye's cyan; what would be below
        // nothing or above all is cut off.
        assert_eq!(anaglyph(white, black), [1.0, 0.0, 0.0, 1.0]);
        let [red, green, blue, alpha] = anaglyph(black, white);
        assert_eq!((red, green, blue, alpha), (0.0, 1.0, 1.0, 1.0));
        // Green in the left eye alone is what the source says it is.
        let green = anaglyph([0.0, 1.0, 0.0, 1.0], black);
        assert_eq!(green, [0.500_484, 0.0, 0.0, 1.0]);
        let dark = anaglyph([f32::NAN; 4], white);
        assert!(dark.iter().all(|channel| !channel.is_nan()), "{dark:?}");
    }

    #[test]
    fn eyes_and_format_are_noted() {
        assert_eq!(
            Stereo::Sequential.metadata(Some(Eye::Right)),
            [
                ("Stereo-Format", "sequential".to_owned()),
                ("Stereo-Eye-Order", "left right".to_owned()),
                ("Stereo-Eye", "right".to_owned()),
            ]
        );
        let mono = Stereo::Mono.metadata(None);
        assert_eq!(mono, [("Stereo-Format", "mono".to_owned())]);
        for stereo in Stereo::ALL {
            assert_eq!(stereo.name().parse(), Ok(stereo));
        }
        assert!("both".parse::<Stereo>().is_err());
    }

    #[test]
    fn pictures_of_different_sizes_are_no_pair() {
        let (left, right) = (picture(3, 2, 0.0), picture(2, 3, 1.0));
        for stereo in Stereo::ALL {
            let error = stereo.compose(&left, &right).unwrap_err();
            assert!(error.to_string().contains("3 × 2 pixels and"), "{error}");
        }
        let none = picture(0, 0, 0.0);
        for stereo in Stereo::ALL {
            assert!(stereo.compose(&none, &none).is_ok());
        }
    }
}
