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
