//! Prints how far pictures are from a true one, over the pixels of the object that they show:
//!
//! `flip EMPTY TRUE FOUND [FOUND...]` takes PNG files of one size. The object's pixels are those
//! that differ from EMPTY in TRUE or in the first FOUND. Prints their number, and the mean of FLIP
//! over them for each FOUND.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8};
use shisen_tests::png_file::PngFile;

/// Most codes of 255 between pixels that show the same sky.
const SLACK: u8 = 2;

fn main() {
    let pictures = std::env::args().skip(1).map(PngFile::open);
    let rgb = |picture: PngFile| ((picture.width, picture.height), picture.rgb());
    let pictures: Vec<_> = pictures.map(rgb).collect();
    let [(_, empty), (size, truth), found @ ..] = pictures.as_slice() else {
        panic!("the arguments are PNG files: EMPTY TRUE FOUND...");
    };
    let (_, first) = found.first().expect("a third picture is needed");
    let differs = |one: &[u8; 3], other: &[u8; 3]| {
        let codes = one.iter().zip(other);
        codes
            .map(|(a, b)| a.abs_diff(*b))
            .any(|apart| apart > SLACK)
    };
    let pixels = truth.iter().zip(first).zip(empty);
    let object: Vec<bool> = pixels
        .map(|((truth, first), empty)| differs(truth, empty) || differs(first, empty))
        .collect();
    let count = object.iter().filter(|&&is_object| is_object).count();
    print!("{count}");
    let flipped =
        |picture: &[[u8; 3]]| FlipImageRgb8::with_data(size.0, size.1, picture.as_flattened());
    for (own, picture) in found {
        assert_eq!(own, size, "pictures of one size");
        let map = nv_flip::flip(flipped(truth), flipped(picture), DEFAULT_PIXELS_PER_DEGREE);
        let all = map.to_vec();
        let own = all.iter().zip(&object).filter(|(_, is_object)| **is_object);
        let sum: f32 = own.map(|(flip, _)| flip).sum();
        print!(" {}", sum / count as f32);
    }
    println!();
}
