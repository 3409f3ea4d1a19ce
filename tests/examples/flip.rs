//! Prints how far pictures are from a true one, over the pixels of the object that they show:
//!
//! `flip EMPTY TRUE FOUND [FOUND...]` takes PNG files of one size. The object's pixels are those
//! that differ from EMPTY in TRUE or in the first FOUND. Prints their number, and the mean of FLIP
//! over them for each FOUND.

use image::{Rgb, RgbImage};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};

/// Most codes of 255 between pixels that show the same sky.
const SLACK: u8 = 2;

fn main() {
    let pictures: Vec<RgbImage> = std::env::args().skip(1).map(|path| read(&path)).collect();
    let [empty, truth, found @ ..] = pictures.as_slice() else {
        panic!("the arguments are PNG files: EMPTY TRUE FOUND...");
    };
    let first = found.first().expect("a third picture is needed");
    let differs = |one: &Rgb<u8>, other: &Rgb<u8>| {
        let codes = one.0.into_iter().zip(other.0);
        codes.map(|(a, b)| a.abs_diff(b)).any(|apart| apart > SLACK)
    };
    let pixels = truth.pixels().zip(first.pixels()).zip(empty.pixels());
    let object: Vec<bool> = pixels
        .map(|((truth, first), empty)| differs(truth, empty) || differs(first, empty))
        .collect();
    let count = object.iter().filter(|&&is_object| is_object).count();
    print!("{count}");
    let (width, height) = truth.dimensions();
    let flipped = |picture: &RgbImage| FlipImageRgb8::with_data(width, height, picture);
    for picture in found {
        assert_eq!(
            picture.dimensions(),
            (width, height),
            "pictures of one size"
        );
        let map = nv_flip::flip(flipped(truth), flipped(picture), DEFAULT_PIXELS_PER_DEGREE);
        let all = map.to_vec();
        let own = all.iter().zip(&object).filter(|(_, is_object)| **is_object);
        let sum: f32 = own.map(|(flip, _)| flip).sum();
        print!(" {}", sum / count as f32);
    }
    println!();
}

fn read(path: &str) -> RgbImage {
    let opened = image::open(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    opened.into_rgb8()
}
