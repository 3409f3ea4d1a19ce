use super::*;
use crate::cave::Cave;
use crate::projection::warp::mpcdi::Version;
use crate::projection::warp::{self, Nodes, Warp};
use std::fs;
use std::io::{Cursor, Write as _};
use zip::write::{SimpleFileOptions, ZipWriter};

const WALL: &str = "[[wall]]\nname = \"front\"\nlower_left = [-1.8, 0, -2]\n\
                    lower_right = [1.8, 0, -2]\nupper_left = [-1.8, 1.5, -2]\n";

const RIGHT: &str = "[[projector]]\nname = \"right\"\nresolution = [64, 48]\n\
                     position = [0.8, 0.7, 0.1]\nyaw_degrees = -3\npitch_degrees = 2\nthrow = 1\n";

const LEFT: &str = "[[projector]]\nname = \"left\"\nresolution = [64, 48]\n";
const POSE: &str = "position = [-0.8, 0.75, 0]\nyaw_degrees = 1\npitch_degrees = 1\nthrow = 1\n";

fn room(folder: &Path, left: &str) -> Result<Cave, String> {
    let text = format!("{WALL}{RIGHT}{LEFT}{left}");
    let name = folder.join("room.toml");
    Cave::from_toml(&text, &name.to_string_lossy(), [64; 2]).map_err(|fault| fault.to_string())
}

#[test]
fn meshes_are_read_as_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let posed = room(folder, POSE).unwrap();
    let blends = posed.blends().unwrap();
    let warp = |grid, nodes| Warp::new(&blends[0], "left", grid, nodes).unwrap();
    let mut bytes = Vec::new();
    warp::bourke::write(&warp([40, 30], Nodes::Corners), &mut bytes).unwrap();
    fs::write(folder.join("left.data"), &bytes).unwrap();
    let written = [(Version::One, "left.mpcdi"), (Version::Two, "two.mpcdi")];
    let [archive, _] = written.map(|(version, name)| {
        let mut archive = Cursor::new(Vec::new());
        warp::mpcdi::write(&warp([64, 48], Nodes::Centres), version, &mut archive).unwrap();
        fs::write(folder.join(name), archive.get_ref()).unwrap();
        archive
    });
    let unpacked = folder.join("unpacked");
    zip::ZipArchive::new(archive)
        .unwrap()
        .extract(&unpacked)
        .unwrap();
    for (mesh, near, light) in [
        ("left.data", 2e-4, 2e-2),
        ("left.mpcdi", 1e-5, 6e-3),
        ("two.mpcdi", 1e-5, 6e-3),
        ("unpacked", 1e-5, 6e-3),
        ("unpacked/mpcdi.xml", 1e-5, 6e-3),
        ("unpacked/left.pfm", 1e-5, 1.0),
    ] {
        let meshed = format!("{WALL}{LEFT}mesh = {mesh:?}\n");
        let name = folder.join("room.toml");
        let meshed = Cave::from_toml(&meshed, &name.to_string_lossy(), [64; 2]).unwrap();
        let found = meshed.blends().unwrap();
        for (x, y) in (0..20).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / 20.0;
            let [expected, place] =
                [&blends[0].members[1], &found[0].members[0]].map(|member| member.map.place(at));
            let (Some(expected), Some(place)) = (expected, place) else {
                continue;
            };
            assert!(
                expected.distance(place) < near,
                "{mesh} {at}: {expected} {place}"
            );
            let back = found[0].members[0].map.at(place).unwrap();
            assert!(back.distance(at) < 1e-9, "{mesh} {at}: {back}");
            // At the edges the share jumps between nodes.
            let is_inside = at.min(1.0 - at).min_element() > 0.1;
            if is_inside && mesh != "unpacked/left.pfm" {
                let [expected, found] =
                    [blends[0].share(1, at, place), found[0].share(0, at, place)];
                assert!(
                    (expected[0] - found[0]).abs() < light,
                    "{mesh} {at}: {expected:?} {found:?}"
                );
            }
        }
    }
    // Its own weights leave to others what the others do not leave to it.
    let error = room(folder, "mesh = \"left.mpcdi\"\n").unwrap_err();
    assert!(
        error.contains("\"left\" and \"right\" overlap without blending"),
        "{error}"
    );
}

/// Two columns and rows, the upper right node half as bright, told from all others.
const BOURKE: &str = "2\n2 2\n-1.5 -1 0 0 1\n1.5 -1 0.8 0.1 1\n-1.5 1 0.2 0.7 1\n1.5 1 1 0.9 0.5\n";

#[test]
fn numbers_of_files_go_where_their_formats_say() {
    let mesh = bourke::read(BOURKE.as_bytes(), [3, 2]).unwrap();
    assert_eq!(mesh.at, [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE]);
    let Targets::Places(places) = &mesh.targets else {
        panic!()
    };
    let upper = [DVec2::new(0.2, 1.0 - 0.7), DVec2::new(1.0, 1.0 - 0.9)];
    assert_eq!(places[..2], upper);
    assert_eq!(mesh.shares, Shares::Nodes(vec![1.0, 0.5, 1.0, 1.0]));
    // The lowest row first; flat ones are places from the upper left corner, whatever the third is.
    let values: [[f32; 3]; 4] = [
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.25, 0.0, 0.0],
        [1.0, 0.0, f32::NAN],
    ];
    let mut file = b"PF\n2 2\n-1.0\n".to_vec();
    file.extend(
        values
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_le_bytes()),
    );
    let mesh = pfm::Points::read(&file)
        .and_then(|points| points.mesh(true, 1.0, None))
        .unwrap();
    let Targets::Places(places) = &mesh.targets else {
        panic!()
    };
    assert_eq!(mesh.at[5], DVec2::splat(0.25));
    assert_eq!(places[5], DVec2::new(0.25, 0.0));
    assert_eq!(places[6], DVec2::new(1.0, 0.0));
    assert_eq!(places[0], DVec2::new(0.0, -0.5));
}

#[test]
fn holes_and_folds_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let nodes = (0..25).map(|node| {
        let (x, y) = (f64::from(node % 5) / 4.0, f64::from(node / 5) / 4.0);
        let u = if node == 18 { 1.3 } else { x };
        let drawn = if node == 12 { -1 } else { 1 };
        let (across, up) = (64.0 / 48.0 * (2.0 * x - 1.0), 2.0 * y - 1.0);
        format!("{across} {up} {u} {y} {drawn}\n")
    });
    let file = format!("2\n5 5\n{}", nodes.collect::<String>());
    fs::write(folder.path().join("left.data"), file).unwrap();
    let text = format!("{WALL}{LEFT}mesh = \"left.data\"\n");
    let name = folder.path().join("room.toml");
    let room = Cave::from_toml(&text, &name.to_string_lossy(), [64; 2]).unwrap();
    let remarks = room.uneven_meshes().unwrap();
    let says =
        "(nodes inside it that are not drawn, and stay dark: 1; cells folded over others: 2)";
    assert!(remarks[0].contains(says), "{remarks:?}");
}

#[test]
fn files_that_are_no_meshes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let archive = |files: &[(&str, &[u8])]| {
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in files {
            archive
                .start_file(*name, SimpleFileOptions::default())
                .unwrap();
            archive.write_all(bytes).unwrap();
        }
        archive.finish().unwrap().into_inner()
    };
    let xml = |path: &str, profile: &str| {
        format!(
            "<MPCDI profile=\"{profile}\"><region id=\"left\"/><fileset region=\"left\">\
             <geometryWarpFile><path>{path}</path></geometryWarpFile></fileset></MPCDI>"
        )
    };
    let described =
        |path: &str, profile: &str| archive(&[("mpcdi.xml", xml(path, profile).as_bytes())]);
    let of_bourke = |from: &str, to: &str| BOURKE.replacen(from, to, 1).into_bytes();
    // Little when packed.
    let bomb = vec![0; (MOST_MIB as usize + 1) << 20];
    let bomb = archive(&[
        ("mpcdi.xml", xml("a.pfm", "a3").as_bytes()),
        ("a.pfm", &bomb),
    ]);
    for (bytes, says) in [
        (of_bourke("0.8", "nan"), "line 4 does not have 5 finite"),
        (of_bourke("1.5 1 1 0.9 0.5\n", ""), "nodes are missing"),
        (of_bourke("2 2", "1 2"), "1 × 2 nodes"),
        (of_bourke("2\n", "1\n"), "of type 1"),
        (
            BOURKE
                .replace(" 1\n", " -1\n")
                .replace("0.5\n", "-1\n")
                .into_bytes(),
            "nothing of it is drawn",
        ),
        (b"PF\n2 2\n-1\nxxxx".to_vec(), "too short or too long"),
        (described("../a.pfm", "a3"), "leads out of it"),
        (described("/etc/passwd", "a3"), "leads out of it"),
        (described("c:\\a.pfm", "a3"), "leads out of it"),
        (described("a.pfm", "3d"), "profile is \"3d\""),
        (described("a.pfm", "a3"), "a.pfm"),
        (archive(&[]), "mpcdi.xml"),
        (bomb, "more than 4 MiB, unpacked"),
        (vec![0xff, 0xfe], "neither Bourke's text, PFM nor MPCDI"),
    ] {
        fs::write(folder.join("mesh"), bytes).unwrap();
        let error = room(folder, "mesh = \"mesh\"\n").unwrap_err();
        assert!(error.contains(says), "{says}: {error}");
    }
    let error = room(folder, "mesh = \"none\"\n").unwrap_err();
    assert!(
        error.contains("none") && error.contains("no such file"),
        "{error}"
    );
}
