//! `shisen dome render` and `shisen dome compare`.

use serde_json::Value;
use shisen_tests::command::shisen;
use std::fs;
use std::path::Path;

fn run(folder: &Path, arguments: &[&str]) -> Value {
    let output = shisen(folder)
        .arg("dome")
        .args(arguments)
        .args(["--json", "--threads", "2"])
        .assert()
        .success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

fn fail(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = shisen(folder)
        .arg("dome")
        .args(arguments)
        .assert()
        .code(code);
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}

fn read(path: &Path) -> image::RgbaImage {
    let picture = image::open(path).unwrap();
    assert_eq!(picture.color(), image::ColorType::Rgba8);
    picture.into_rgba8()
}

#[test]
fn dome_masters_are_numbered_round_and_transparent_outside() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut hashes = Vec::new();
    for mapping in ["mirror", "exact", "true"] {
        let arguments = [
            "render",
            "--scene",
            "grid",
            "--size",
            "96",
            "--mapping",
            mapping,
        ];
        let report = run(
            folder,
            &[&arguments[..], &["--out", "shots/Grid.png"]].concat(),
        );
        let image = &report["images"][0];
        assert_eq!(image["path"], "shots/Grid_00001.png");
        assert_eq!(image["frame"], 1);
        assert_eq!(report["mapping"], mapping);
        assert_eq!(report["config"].is_null(), mapping == "true");
        assert_eq!(report["viewpoint"].is_null(), mapping == "true");
        assert_eq!(report["distance"], 100.0);
        let picture = read(&folder.join("shots/Grid_00001.png"));
        assert_eq!(picture.dimensions(), (96, 96));
        assert_eq!(picture.get_pixel(0, 0).0, [0; 4]);
        assert_eq!(picture.get_pixel(48, 48).0, [255; 4]);
        let inside = picture.pixels().filter(|pixel| pixel.0[3] == 255).count();
        assert_eq!(report["rays"]["primary"], inside);
        hashes.push(image["hash"].as_str().unwrap().to_owned());
    }
    hashes.dedup();
    assert_eq!(hashes.len(), 3);
}

#[test]
fn a_camera_path_gives_a_picture_a_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = r#"
        ambient = [1, 1, 1]
        [materials.red]
        diffuse = [1, 0, 0]
        [[object]]
        sphere = { radius = 0.5 }
        material = "red"
        position = [0, 2, 0]
        [[camera]]
        frame = 1
        position = [-8, 0, 0]
        [[camera]]
        frame = 3
        position = [8, 0, 0]
        [background]
        colour = [0, 0, 0]
        alpha = 0
    "#;
    fs::write(folder.join("red.toml"), scene).unwrap();
    let arguments = ["render", "--scene", "red.toml", "--size", "33", "--exr"];
    let report = run(folder, &arguments);
    assert_eq!(report["frames"], 3);
    assert_eq!(report["images"].as_array().unwrap().len(), 3);
    assert_eq!(report["exr"][2], "shisen-out/red_00003.exr");
    // Right of the camera, above it, left of it; nothing else is opaque.
    for (frame, columns) in [(1, 17..33), (2, 14..19), (3, 0..16)] {
        let path = folder.join(format!("shisen-out/red_{frame:05}.png"));
        let picture = read(&path);
        let red: Vec<u32> = picture
            .enumerate_pixels()
            .filter(|(_, _, pixel)| pixel.0[3] > 0)
            .map(|(x, _, pixel)| {
                assert_eq!(pixel.0, [255, 0, 0, 255]);
                x
            })
            .collect();
        assert!(
            !red.is_empty() && red.iter().all(|x| columns.contains(x)),
            "{frame}: {red:?}"
        );
    }
    // Another place, and fewer frames.
    let report = run(
        folder,
        &[&arguments[..5], &["--at", "0,0,0", "--tilt", "20"]].concat(),
    );
    assert_eq!(report["frames"], 1);
    let report = run(folder, &[&arguments[..5], &["--frames", "2"]].concat());
    assert_eq!(report["frames"], 2);
}

#[test]
fn mirrors_differ_from_the_truth_as_far_as_they_are_near() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut before = 0;
    for (distance, mapping) in [
        ("1e6", "exact"),
        ("100", "mirror"),
        ("10", "mirror"),
        ("1", "mirror"),
    ] {
        let arguments = [
            "compare",
            "--size",
            "256",
            "--mapping",
            mapping,
            "--distance",
            distance,
        ];
        let report = run(folder, &arguments);
        let differing = report["differing"].as_u64().unwrap();
        assert!(differing >= before, "{distance}: {differing} {before}");
        assert_eq!(report["image"], "shisen-out/compare.png");
        before = differing;
        let picture = read(&folder.join("shisen-out/compare.png"));
        let colours: Vec<_> = picture.pixels().map(|pixel| pixel.0).collect();
        let count = |colour: [u8; 4]| colours.iter().filter(|&&c| c == colour).count() as u64;
        let (red, cyan) = (count([255, 0, 0, 255]), count([0, 255, 255, 255]));
        assert_eq!(red + cyan, differing);
        let white = count([255; 4]);
        assert_eq!(report["true_lines"], red + white);
        assert_eq!(report["simulated_lines"], cyan + white);
        if mapping == "exact" {
            assert!(differing < 10, "{differing}");
        }
    }
    // Taken from the best viewpoint, near surroundings are less far off.
    let near = ["compare", "--size", "256", "--distance", "1"];
    let best = run(folder, &[&near[..], &["--viewpoint", "best"]].concat());
    assert!(best["differing"].as_u64().unwrap() < before);
    assert!(best["viewpoint"].as_f64().unwrap() != 0.0);
}

#[test]
fn what_cannot_be_is_said_with_its_range() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (arguments, words) in [
        (&["--fov", "90"][..], "--mapping true"),
        (&["--mapping", "true", "--fov", "0"], "above 0, to 360"),
        (&["--mapping", "true", "--fov", "nan"], "above 0, to 360"),
        (&["--mapping", "true", "--mirrored"], "there is no mirror"),
        (
            &["--mapping", "true", "--config", "best"],
            "there is no mirror",
        ),
        (
            &["--mapping", "true", "--mirror-size", "1"],
            "--mirror-size is",
        ),
        (
            &["--mapping", "true", "--viewpoint", "best"],
            "--viewpoint is",
        ),
        (&["--nearest", "5"], "--viewpoint best"),
        (&["--mirror-size", "0"], "from 1e-9 to 1e6"),
        (&["--mirror-size", "nan"], "from 1e-9 to 1e6"),
        (&["--viewpoint", "1e9"], "-100 to 100"),
        (&["--viewpoint", "here"], "screen, best"),
        (&["--distance", "10"], "--scene grid"),
        (&["--scene", "grid", "--distance", "0"], "from 0.001"),
        (&["--scene", "grid", "--mesh", "a.obj"], "has no mesh"),
        (&["--size", "0"], "from 1 to 65536"),
        (&["--at", "1,nan,0"], "X,Y,Z"),
        (&["--at", "1e13,0,0"], "position is"),
        (&["--tilt", "400"], "-360 to 360"),
        (&["--frames", "0"], "from 1 to 99999"),
        (&["--config", "paper-4"], "paper-3"),
    ] {
        let says = fail(folder, 2, &[&["render"], arguments].concat());
        assert!(says.contains(words), "{arguments:?}: {says}");
    }
    let says = fail(folder, 1, &["render", "--scene", "grid", "--size", "65536"]);
    assert!(says.contains("too large"), "{says}");
    assert!(!folder.join("shisen-out/A_00001.png").exists());
}

#[test]
fn a_grid_in_the_mirror_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["dome", "compare", "--distance", "0.6", "--size", "32"][..],
        &[
            "dome",
            "render",
            "--scene",
            "grid",
            "--distance",
            "0.1",
            "--mapping",
            "mirror",
        ],
    ] {
        let output = shisen(folder.path())
            .args(arguments)
            .assert()
            .code(2)
            .get_output()
            .clone();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains("above 0.613"), "{arguments:?}: {error}");
    }
}
