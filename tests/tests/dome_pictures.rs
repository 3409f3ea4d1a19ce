//! `shisen dome render` and `shisen dome compare`.

use serde_json::json;
use shisen_tests::command::{folder, refused, report, says};
use std::fs;
use std::path::Path;

fn read(path: &Path) -> image::RgbaImage {
    let picture = image::open(path).unwrap();
    assert_eq!(picture.color(), image::ColorType::Rgba8);
    picture.into_rgba8()
}

#[test]
fn dome_masters_are_numbered_round_and_transparent_outside() {
    let folder = folder();
    let mut hashes = Vec::new();
    for mapping in ["mirror", "exact", "true"] {
        let words =
            format!("dome render --scene grid --size 96 --mapping {mapping} --out shots/Grid.png");
        let report = report(folder.path(), &words);
        let image = &report["images"][0];
        says(image, json!({ "path": "shots/Grid_00001.png", "frame": 1 }));
        says(&report, json!({ "mapping": mapping, "distance": 100.0 }));
        for key in ["config", "viewpoint"] {
            assert_eq!(report[key].is_null(), mapping == "true");
        }
        let picture = read(&folder.path().join("shots/Grid_00001.png"));
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
    let folder = folder();
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
    let render = |words: &str| {
        report(
            folder,
            &format!("dome render --scene red.toml --size 33 {words}"),
        )
    };
    let found = render("--exr");
    assert_eq!(found["frames"], 3);
    assert_eq!(found["images"].as_array().unwrap().len(), 3);
    assert_eq!(found["exr"][2], "shisen-out/red_00003.exr");
    // Right of the camera, above it, left of it; nothing else is opaque.
    for (frame, columns) in [(1, 17..33), (2, 14..19), (3, 0..16)] {
        let picture = read(&folder.join(format!("shisen-out/red_{frame:05}.png")));
        let mut red = picture
            .enumerate_pixels()
            .filter(|(.., pixel)| pixel.0[3] > 0)
            .peekable();
        assert!(red.peek().is_some());
        for (x, _, pixel) in red {
            assert_eq!(pixel.0, [255, 0, 0, 255]);
            assert!(columns.contains(&x), "{frame}: {x}");
        }
    }
    assert_eq!(render("--at 0,0,0 --tilt 20")["frames"], 1);
    assert_eq!(render("--frames 2")["frames"], 2);
}

#[test]
fn mirrors_differ_from_the_truth_as_far_as_they_are_near() {
    let folder = folder();
    let mut before = 0;
    for (distance, mapping) in [
        ("1e6", "exact"),
        ("100", "mirror"),
        ("10", "mirror"),
        ("1", "mirror"),
    ] {
        let words = format!("dome compare --size 256 --mapping {mapping} --distance {distance}");
        let report = report(folder.path(), &words);
        let differing = report["differing"].as_u64().unwrap();
        assert!(differing >= before, "{distance}: {differing} {before}");
        assert_eq!(report["image"], "shisen-out/compare.png");
        before = differing;
        let picture = read(&folder.path().join("shisen-out/compare.png"));
        let count =
            |colour: [u8; 4]| picture.pixels().filter(|pixel| pixel.0 == colour).count() as u64;
        let (red, cyan) = (count([255, 0, 0, 255]), count([0, 255, 255, 255]));
        let white = count([255; 4]);
        assert_eq!(red + cyan, differing);
        assert_eq!(report["true_lines"], red + white);
        assert_eq!(report["simulated_lines"], cyan + white);
        assert!(mapping == "mirror" || differing < 10, "{differing}");
    }
    // Taken from the best viewpoint, near surroundings are less far off.
    let best = report(
        folder.path(),
        "dome compare --size 256 --distance 1 --viewpoint best",
    );
    assert!(best["differing"].as_u64().unwrap() < before);
    assert!(best["viewpoint"].as_f64().unwrap() != 0.0);
}

#[test]
fn impossible_dome_masters_are_refused() {
    let folder = folder();
    refused(
        folder.path(),
        2,
        "
        dome render --fov 90 --mapping mirror => --mapping true
        dome render --mapping true --fov 0 => above 0, to 360
        dome render --mapping true --fov nan => above 0, to 360
        dome render --mapping true --mirrored => there is no mirror
        dome render --mapping true --config best => there is no mirror
        dome render --mapping true --mirror-size 1 => --mirror-size is
        dome render --mapping true --viewpoint best => --viewpoint is
        dome render --nearest 5 => --viewpoint best
        dome render --mirror-size 0 => from 1e-9 to 1e6
        dome render --mirror-size nan => from 1e-9 to 1e6
        dome render --viewpoint 1e9 => -100 to 100
        dome render --viewpoint here => screen, best
        dome render --distance 10 => --scene grid
        dome render --scene grid --distance 0 => from 0.001
        dome render --scene grid --distance 0.1 --mapping mirror => above 0.613
        dome render --scene grid --mesh a.obj => has no mesh
        dome render --size 0 => from 1 to 65536
        dome render --at 1,nan,0 => X,Y,Z
        dome render --at 1e13,0,0 => position is
        dome render --tilt 400 => -360 to 360
        dome render --frames 0 => from 1 to 99999
        dome render --config paper-4 => paper-3
        dome compare --distance 0.6 --size 32 => above 0.613",
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let large = "dome render --scene grid --size 65536 => too large";
    refused(folder.path(), 1, large);
}
