use super::*;
use std::fs;

#[test]
fn srgb_codes_are_within_their_bound_and_rise() {
    let mut last = 0;
    for step in 0..=1_000_000 {
        let linear = step as f32 / 1.0e6;
        let exact = f64::from(linear);
        let encoded = if exact <= 0.003_130_8 {
            12.92 * exact
        } else {
            1.055 * exact.powf(1.0 / 2.4) - 0.055
        };
        let code = srgb_from_linear(linear);
        let off = (f64::from(code) - encoded * 255.0).abs();
        assert!(
            off < 0.545 && (code == last || code == last + 1),
            "{linear}: {off}"
        );
        last = code;
    }
    for value in [-1.0, -0.0, f32::NEG_INFINITY, f32::NAN] {
        assert_eq!(srgb_from_linear(value), 0, "{value}");
    }
    for value in [1.0, 1.001, 1e30, f32::INFINITY] {
        assert_eq!(srgb_from_linear(value), 255, "{value}");
    }
}

#[test]
fn pixels_have_the_codes_of_their_colours() {
    let no_colours = [-1.0, f32::NAN, 1.5, f32::INFINITY, f32::NEG_INFINITY, -0.0];
    let steps = (0..=10_000).map(|step| step as f32 / 9_999.0);
    for value in steps.chain(no_colours) {
        let colours = [value, 0.25, 1.0 - value];
        let [red, green, blue] = colours;
        let found = srgb_of_pixel([red, green, blue, value]);
        assert_eq!(found, colours.map(srgb_from_linear), "{value}");
    }
}

#[test]
fn pixel_count_is_checked() {
    assert!(Picture::from_pixels(2, 3, vec![[0.0; 4]; 6]).is_ok());
    let error = Picture::from_pixels(2, 3, vec![[0.0; 4]; 5]).unwrap_err();
    assert!(error.to_string().contains("2 × 3"), "{error}");
    assert!(error.to_string().contains("given 5"), "{error}");
    let error = Picture::new(u32::MAX, u32::MAX).unwrap_err();
    assert!(error.to_string().contains("too large"), "{error}");
}

#[test]
fn a_file_is_written_whole_or_left_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let [path, taken, missing] =
        ["wall.png", "taken.png", "missing/wall.png"].map(|name| folder.path().join(name));
    let picture = Picture::new(2, 2).unwrap();
    fs::write(&path, "old").unwrap();
    let as_the_umask_allows = fs::metadata(&path).unwrap().permissions();
    let full = write_file(&path, |file| {
        file.write_all(b"half")?;
        Err(io::ErrorKind::StorageFull.into())
    });
    assert_eq!(fs::read(&path).unwrap(), b"old");
    picture.write_png(&path, &[]).unwrap();
    let permissions = fs::metadata(&path).unwrap().permissions();
    assert_eq!(permissions, as_the_umask_allows);
    // A folder in the file's place makes the rename fail at the very end.
    fs::create_dir(&taken).unwrap();
    for (written, says) in [
        (full, "no space left"),
        (picture.write_png(&taken, &[]), "choose another"),
        (picture.write_png(&missing, &[]), "missing/wall.png"),
        (picture.write_exr(&missing, &[]), "create it first"),
    ] {
        let error = written.unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn what_the_formats_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wall.png");
    let mut picture = Picture::new(2, 2).unwrap();
    let refused = |written: Result<(), PictureError>, says: &str| {
        let error = written.unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    for bad in ["", " a", "a ", "a  b", "a\n", "é", &"k".repeat(80)] {
        let written = picture.write_png(&path, &[(bad, String::new())]);
        refused(written, &format!("metadata key {bad:?} cannot"));
    }
    let value = picture.write_exr(&path, &[("key", "a\0b".to_owned())]);
    refused(value, "NUL characters");
    for (width, height) in [(0, 0), (0, 4), (4, 0)] {
        let empty = Picture::new(width, height).unwrap();
        refused(empty.write_png(&path, &[]), "cannot be written");
    }
    picture.pixels.pop();
    refused(picture.write_exr(&path, &[]), "given 3 pixels");
    assert!(!path.exists());
}

#[test]
fn differences_are_of_what_is_shown() {
    let picture = |pixels: &[[f32; 3]]| {
        let pixels: Vec<_> = pixels.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        Picture::from_pixels(pixels.len() as u32, 1, pixels).unwrap()
    };
    let one = picture(&[
        [0.0; 3],
        [1.0; 3],
        [0.5, 0.2, 0.1],
        [1.0, 0.0, 0.0],
        [0.0; 3],
    ]);
    let other = picture(&[
        [-3.0, 0.0, 0.0],
        [7.0; 3],
        [0.5, 0.2, 0.1],
        [0.0; 3],
        [1.0; 3],
    ]);
    let found = colour_differences(&one, &other);
    assert_eq!(found[..3], [0.0; 3]);
    // Lab 53.24 80.09 67.20 against black, by the formula's authors' sheet.
    assert!(
        (found[3] - 50.41).abs() < 0.1 && (found[4] - 100.0).abs() < 0.01,
        "{found:?}"
    );
}
