use super::*;
use std::fs;

fn gradient(width: u32, height: u32) -> Picture {
    let mut picture = Picture::new(width, height).unwrap();
    for y in 0..height {
        for x in 0..width {
            let value = (y * width + x) as f32 / (width * height) as f32;
            picture.set_pixel(x, y, [value, 1.5 - 2.0 * value, value * value, 0.5]);
        }
    }
    picture
}

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
fn sample_is_exact_at_centres_and_halfway_between_and_goes_on_at_the_edge() {
    let picture = gradient(4, 3);
    for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let sample = picture.sample(f64::from(x) + 0.5, f64::from(y) + 0.5);
        assert_eq!(Some(sample), picture.pixel(x, y));
    }
    let between = picture.sample(2.0, 1.0)[0];
    let corners = [(1, 0), (2, 0), (1, 1), (2, 1)];
    let mean: f32 = corners
        .map(|(x, y)| picture.pixel(x, y).unwrap()[0] / 4.0)
        .iter()
        .sum();
    assert!((between - mean).abs() < 1e-7);
    assert_eq!(Some(picture.sample(-9.0, 0.2)), picture.pixel(0, 0));
    assert_eq!(Some(picture.sample(1e300, 1e300)), picture.pixel(3, 2));
    assert_eq!(picture.sample(f64::NAN, 0.0), [0.0; 4]);
    assert_eq!(Picture::new(0, 0).unwrap().sample(0.0, 0.0), [0.0; 4]);
}

#[test]
fn hash_sees_every_bit_and_the_shape() {
    let picture = gradient(6, 4);
    assert_eq!(picture.hash(), picture.clone().hash());
    let mut negated_zero = picture.clone();
    negated_zero.pixels[0][0] = -0.0;
    assert_eq!(picture.pixels[0][0], 0.0);
    assert_ne!(picture.hash(), negated_zero.hash());
    let reshaped = Picture::from_pixels(4, 6, picture.pixels.clone()).unwrap();
    assert_ne!(picture.hash(), reshaped.hash());
    // Files of hashes are compared between machines and versions.
    let white = Picture::from_pixels(1, 1, vec![[1.0; 4]]).unwrap();
    assert_eq!(white.hash(), WHITE_PIXEL);
}

/// XXH3 64 of the reference implementation, 0.8.4, over the 24 bytes that are hashed.
const WHITE_PIXEL: u64 = 0x2f18_3d07_4f0b_0c31;

/// The bytes of a PNG file, and what its header and text say.
fn read_png(path: &Path) -> (Vec<u8>, png::Info<'static>) {
    let mut reader = png::Decoder::new(io::BufReader::new(fs::File::open(path).unwrap()))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let info = reader.info().clone();
    (bytes, info)
}

#[test]
fn png_holds_the_encoded_colours_and_the_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wall.png");
    let picture = gradient(7, 5);
    let metadata = [
        ("Scene", "cornell".to_owned()),
        ("Viewer", "頭 0.1 m".to_owned()),
    ];
    picture.write_png(&path, &metadata).unwrap();
    let (bytes, info) = read_png(&path);
    assert_eq!(info.size(), (7, 5));
    assert_eq!(info.color_type, ColorType::Rgb);
    let coded = |pixel: &[f32; 4]| [pixel[0], pixel[1], pixel[2]].map(srgb_from_linear);
    assert_eq!(
        bytes,
        picture.pixels.iter().flat_map(coded).collect::<Vec<u8>>()
    );
    assert!(info.srgb.is_some());
    assert_eq!(info.uncompressed_latin1_text[0].keyword, "Scene");
    assert_eq!(info.uncompressed_latin1_text[0].text, "cornell");
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "頭 0.1 m");
}

#[test]
fn failures_name_the_path_and_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let picture = gradient(2, 2);
    let missing = folder.path().join("missing").join("wall.png");
    for error in [
        picture.write_png(&missing, &[]).unwrap_err(),
        picture.write_exr(&missing, &[]).unwrap_err(),
    ] {
        let message = error.to_string();
        assert!(message.contains("missing/wall.png"), "{message}");
        assert!(message.contains("create it first"), "{message}");
    }
    // A folder in the file's place makes the rename fail at the very end.
    let taken = folder.path().join("taken.png");
    fs::create_dir(&taken).unwrap();
    let error = picture.write_png(&taken, &[]).unwrap_err();
    assert!(error.to_string().contains("choose another"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn failed_encoder_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wall.png");
    fs::write(&path, "old").unwrap();
    let error = write_file(&path, |file| {
        file.write_all(b"half")?;
        Err(io::ErrorKind::StorageFull.into())
    })
    .unwrap_err();
    assert!(error.to_string().contains("no space left"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_the_formats_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wall.png");
    let mut picture = gradient(2, 2);
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

#[cfg(unix)]
#[test]
fn files_are_readable_as_the_umask_allows() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    fs::write(&plain, "").unwrap();
    let path = folder.path().join("wall.png");
    gradient(2, 2).write_png(&path, &[]).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[test]
fn png_with_alpha_is_not_premultiplied() {
    let last = [0.2, 0.1, 0.0, f32::NAN];
    let pixels = vec![[0.25, 0.5, 0.0, 0.5], [0.0; 4], [1.0; 4], last];
    let picture = Picture::from_pixels(4, 1, pixels).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("alpha.png");
    picture.write_png_with_alpha(&path, &[]).unwrap();
    let (found, info) = read_png(&path);
    assert_eq!(info.color_type, ColorType::Rgba);
    let half = srgb_from_linear(0.5);
    let expected = [[half, 255, 0, 128], [0; 4], [255; 4], [0; 4]];
    assert_eq!(found, expected.as_flattened());
}
