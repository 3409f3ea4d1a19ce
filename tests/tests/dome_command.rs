//! `shisen dome`: mappings without error, cameras that move, and bad input.

use serde_json::json;
use shisen_tests::command::{folder, list, number, refused, report, says};
use shisen_tests::png_file::PngFile;
use std::fs;

#[test]
fn the_other_mappings_have_no_error() {
    let folder = folder();
    for words in ["exact", "true", "exact --f32", "true --f32"] {
        let map = format!("dome map --config best --step 7.5 --mapping {words}");
        let map = report(folder.path(), &map);
        for rows in ["r_d_to_theta", "theta_to_r_d"].map(|key| list(&map, key)) {
            assert_eq!(rows.len(), 13);
            for row in rows {
                let off = number(row, "theta_deg") - number(row, "r_d_deg");
                assert!(
                    off.abs() < 4.0e-5 && number(row, "error_px").abs() <= 1.0e-3,
                    "{row}"
                );
            }
        }
    }
    let same = report(folder.path(), "dome compare --mapping true --size 64");
    assert_eq!(same["differing"], 0);
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
        let words = format!("dome render --scene red.toml --size 33 {words}");
        report(folder, &words)
    };
    let found = render("--exr");
    says(&found, json!({ "frames": 3 }));
    assert_eq!(list(&found, "images").len(), 3);
    assert_eq!(found["exr"][2], "shisen-out/red_00003.exr");
    // Right of the camera, above it, left of it; nothing else is opaque.
    for (frame, columns) in [(1, 17..33_usize), (2, 14..19), (3, 0..16)] {
        let picture = folder.join(format!("shisen-out/red_{frame:05}.png"));
        let picture = PngFile::open(picture).bytes;
        let pixels = picture.as_chunks::<4>().0.iter().enumerate();
        let seen: Vec<_> = pixels.filter(|(_, pixel)| pixel[3] > 0).collect();
        let red = |&(place, pixel): &(usize, &[u8; 4])| {
            *pixel == [255, 0, 0, 255] && columns.contains(&(place % 33))
        };
        assert!(
            !seen.is_empty() && seen.iter().all(red),
            "{frame}: {seen:?}"
        );
    }
    assert_eq!(render("--at 0,0,0 --tilt 20")["frames"], 1);
    assert_eq!(render("--frames 2")["frames"], 2);
}

/// Domes and mirrors that there cannot be, and what is said of them.
const USAGE: &str = "
    dome design --projection perspective --a 0 => ratio is 0: give a number from 0.01 to 100
    dome design --projection perspective --a -1 => ratio is -1: give
    dome design --projection perspective --a 2 --p 1.5 => viewpoint is 1.5 radii
    dome design --projection perspective --a 2 --p 2 => finite number above 2,
    dome design --projection perspective --a 2 --p nan => viewpoint is NaN
    dome design --projection perspective --a 1 --beta1 0.79 => of 0.79 rad: give a number from 0.001 to 0.785398163
    dome design --projection perspective --a 1 --beta1 nan => of NaN rad
    dome design --projection perspective --p 3 => --a <RATIO>
    dome design --projection perspective --a 1 --p 3 --beta1 0.2 => --beta1
    dome design --projection perspective --config best => --config
    dome design --projection parallel --a nan => ratio is NaN: give
    dome design --projection parallel --a 101 => 0.01 to 100
    dome design --projection parallel --a 1 --p 3 => --p is 3
    dome design --projection parallel --a 1 --beta1 0.2 => --beta1 is 0.2
    dome design => --projection
    dome design --config paper-4 => paper-3
    dome map --step 0 => degrees from 0.001 to 90
    dome map --mapping round => exact
    dome nearfield --distance 0.6 => is 0.6 radii
    dome nearfield --distance 1,nan => is NaN radii
    dome nearfield --distance -1 => above 0.61326
    dome nearfield --world-offset 1e7 => 0 to 1e6
    dome curve --points 1 => from 2 to 10000
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
    dome compare --distance 0.6 --size 32 => above 0.613
";

#[test]
fn impossible_mirrors_and_dome_masters_are_refused() {
    let folder = folder();
    refused(folder.path(), 2, USAGE);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let large = "dome render --scene grid --size 65536 => too large";
    refused(folder.path(), 1, large);
}
