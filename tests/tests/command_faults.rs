//! Bad input: an exit code, one paragraph that says what to do, and no file
//! that was not there before.

use assert_cmd::Command;
use shisen_tests::command::{command_line, evidence, folder, shisen};
use std::fs;
use std::path::{Path, PathBuf};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// All files and folders below `folder`, and the files' contents.
fn contents(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path.clone());
                all.push((path, None));
            } else {
                let bytes = fs::read(&path).unwrap();
                all.push((path, Some(bytes)));
            }
        }
    }
    all.sort();
    all
}

/// Runs a command that must fail with `code`, name each of `expected` on
/// standard error, print nothing else and leave `folder` as it was.
fn refused(folder: &Path, command: &mut Command, code: i32, expected: &[&str]) {
    let before = contents(folder);
    let output = command.assert().code(code).get_output().clone();
    let message = String::from_utf8(output.stderr).unwrap();
    for expected in expected {
        assert!(
            message.contains(expected),
            "{expected:?} is not in: {message}"
        );
    }
    assert!(!message.contains("panicked"), "{message}");
    // A remedy is part of every message.
    assert!(message.len() > 60, "{message}");
    assert!(output.stdout.is_empty());
    assert_eq!(contents(folder), before);
}

/// What is wrong with arguments beside each other ends with the usage of the command
/// that they were given to.
#[test]
fn usage_is_that_of_the_command_asked_for() {
    let folder = folder();
    for (arguments, name) in [
        (&["run", "--scene", "grid"][..], "shisen run"),
        (&["run", "--stereo", "anaglyph"], "shisen run"),
        (
            &["cave", "--lod", "off", "--fill", "capture"],
            "shisen cave",
        ),
        (
            &["bench", "latency", "--scene", "grid", "--budget", "paper"],
            "shisen-evidence bench latency",
        ),
        (
            &["tracker", "mock", "--as", "hid", "--pty", "line"],
            "shisen tracker mock",
        ),
    ] {
        let output = command_line(folder.path(), arguments).assert().code(2);
        let message = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(message.starts_with("error: "), "{arguments:?}: {message}");
        let usage = format!("\n\nUsage: {name} [OPTIONS]\n\n");
        assert!(message.contains(&usage), "{arguments:?}: {message}");
        let hint = format!("try '{name} --help'.\n");
        assert!(message.ends_with(&hint), "{arguments:?}: {message}");
        // Nobody is told in colours who does not see any.
        assert!(!message.contains('\u{1b}'), "{arguments:?}: {message}");
    }
}

#[test]
fn what_would_do_nothing_is_usage() {
    let folder = folder();
    for (arguments, expected) in [
        (
            &["run", "--fill", "previous", "--lod", "off"][..],
            "with --lod off no ray is skipped",
        ),
        (
            &["run", "--fill", "previous"],
            "with --view none nothing is shown",
        ),
        (&["run", "--look", "floor"], "where the tracker says"),
        (
            &["bench", "latency", "--as", "hid"],
            "does not go over a serial line",
        ),
    ] {
        refused_by(&folder, arguments, expected);
    }
}

#[test]
fn what_there_is_not_is_usage() {
    let folder = folder();
    for (arguments, expected) in [
        (&["cave", "--size", "0"][..], "--size"),
        (&["cave", "--size", "16385"], "from 1 to 16384"),
        (&["cave", "--size", "-1"], "from 1 to 16384"),
        (&["cave", "--threads", "0"], "--threads"),
        (&["cave", "--samples", "0"], "--samples"),
        (&["cave", "--depth", "17"], "from 0 to 16"),
        (&["cave", "--eyes", "3"], "from 1 to 2"),
        (&["cave", "--colour", "red"], "--colour"),
        (&["cave", "--look", "sideways"], "YAW,PITCH"),
        (&["cave", "--look", "0,91"], "pitch of 91"),
        (&["cave", "--look", "0,0,0"], "points nowhere"),
        (&["cave", "--look", "-1,nan"], "-1,nan"),
        (&["cave", "--head", "0,0"], "X,Y,Z in metres"),
        (&["cave", "--head", "-1,-inf,0"], "X,Y,Z in metres"),
        (&["cave", "--ipd", "-0.1"], "metres from 0 to 1"),
        (&["cave", "--view-size", "0x10"], "1 to 16384"),
        (&["cave", "--view-fov", "180"], "degrees from 1 to 179"),
        (
            &["cave", "--head-report", "xyz"],
            "'x' is no hexadecimal digit",
        ),
        (&["cave", "--head-report", "010"], "3 hexadecimal digits"),
        (&["cave", "--head-report", "01 02"], "2 bytes, not 16 or 32"),
        (
            &["cave", "--head-report", "04000000000000000040000000000000"],
            "version 4",
        ),
        (
            &["cave", "--head-report", "01000000000000000020000000000000"],
            "norm 0.5",
        ),
        (&["cave", "--normals", "wavy"], "smooth, flat"),
        (&["cave", "--scene", "s.toml", "--mesh", "m.obj"], "--mesh"),
        (
            &["bake", "A", "-o", "x.shisen", "--faces", "5..4"],
            "5, is above the most, 4",
        ),
        (
            &["bake", "A", "-o", "x.shisen", "--faces", "500"],
            "500..5804",
        ),
        (
            &["bake", "A", "-o", "x.shisen", "--levels", "1"],
            "from 2 to 64",
        ),
        (
            &["cave", "--lod", "paper", "--faces", "5..4"],
            "5, is above the most, 4",
        ),
        (&["cave", "--lod", "paper", "--faces", "0.."], "at least 1"),
        (
            &["cave", "--lod", "paper", "--levels", "65"],
            "from 2 to 64",
        ),
        (&["cave", "--faces", "500.."], "--lod paper"),
        (&["cave", "--levels", "4"], "--lod paper"),
        (
            &["bench", "table2", "--faces", "5..4"],
            "5, is above the most, 4",
        ),
        (&["gaze", "--faces", "5..4"], "5, is above the most, 4"),
        (&["gaze", "--faces", "500.."], "500..5804"),
        (&["bake", "A"], "--output"),
        (&["bake", "-o", "x.shisen"], "INPUT"),
        (&["bake", "A", "B", "-o", "x.shisen"], "one scene at a time"),
        (
            &["bake", "a.obj", "--mesh", "b.obj", "-o", "x.shisen"],
            "--mesh",
        ),
        (
            &["bake", "A", "-o", "x.shisen", "--layout", "wide"],
            "fast, compact",
        ),
        (&["bench", "rays", "--mesh", "m.obj"], "--rays"),
        (
            &[
                "bench", "rays", "--mesh", "m.obj", "--rays", "r", "--repeat", "0",
            ],
            "--repeat",
        ),
        (&["bench", "table2", "--repeat", "0"], "--repeat"),
        (&["bench", "table2", "--size", "0"], "--size"),
        (&["bench", "table2", "--faces", "9..3"], "above the most, 3"),
        (&["bench", "sweep", "--directions", "0"], "--directions"),
        (&["bench", "sweep", "--levels", "65"], "from 2 to 64"),
        (&["bench"], "Usage"),
        (&["paint"], "paint"),
        (&[], "Usage"),
    ] {
        refused(
            folder.path(),
            &mut command_line(folder.path(), arguments),
            2,
            &[expected],
        );
    }
}

#[test]
fn a_gaze_that_no_detail_follows_is_usage() {
    let folder = folder();
    for gaze in [["--fixate", "0,0,-1"], ["--up", "1,1,0"]] {
        for lod in [&[][..], &["--lod", "off"]] {
            let mut command = shisen(folder.path());
            command.arg("cave").args(lod).args(gaze);
            let expected = [&format!("{} is for --lod paper", gaze[0]), "--lod off"];
            refused(folder.path(), &mut command, 2, &expected);
        }
    }
}

#[test]
fn commands_that_are_elsewhere_say_where() {
    let folder = folder();
    for (arguments, expected) in [
        (
            &["bench", "table2", "--size", "8"][..],
            "-p shisen-evidence -- bench table2 --size 8",
        ),
        (
            &["firmware", "run", "--frames", "1"],
            "tests/firmware/run --frames 1",
        ),
    ] {
        let mut command = shisen(folder.path());
        refused(folder.path(), command.args(arguments), 2, &[expected]);
    }
}

#[test]
fn help_and_version_are_no_failure() {
    let folder = folder();
    for arguments in [
        &["--help"][..],
        &["--version"],
        &["cave", "--help"],
        &["bench", "rays", "-h"],
    ] {
        let output = command_line(folder.path(), arguments)
            .assert()
            .success()
            .get_output()
            .clone();
        assert!(
            !output.stdout.is_empty() && output.stderr.is_empty(),
            "{arguments:?}"
        );
    }
}

#[test]
fn broken_meshes_are_named() {
    let folder = folder();
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 178956970\n\
                  property float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let face = |face: &str| format!("{TRIANGLE}{face}\n");
    for (name, text, expected) in [
        ("text.txt", "hello".to_owned(), ".obj, .ply, .gltf or .glb"),
        ("words.obj", "this is not a mesh".to_owned(), "words.obj"),
        ("words.ply", "this is not a mesh".to_owned(), "words.ply"),
        ("words.glb", "this is not a mesh".to_owned(), "words.glb"),
        ("empty.obj", String::new(), "no triangles"),
        ("points.obj", TRIANGLE.to_owned(), "no triangles"),
        ("nan.obj", face("v nan 0 0\nf 1 2 3"), "nan.obj"),
        ("infinite.obj", face("v 0 inf 0\nf 1 2 4"), "infinite.obj"),
        ("range.obj", face("f 1 2 4"), "1 to 3"),
        ("twice.obj", face("f 1 2 2"), "twice"),
        // 2 GiB of vertices, of which there are none.
        ("claim.ply", header.to_owned(), "2147483640"),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
        let out = ["--out", "new"];
        let mut cave = shisen(folder.path());
        refused(
            folder.path(),
            cave.args(["cave", "--mesh", name]).args(out),
            1,
            &[name, expected],
        );
        let mut bake = shisen(folder.path());
        bake.args(["bake", "A", "--mesh", name, "-o", "new.shisen"]);
        refused(folder.path(), &mut bake, 1, &[name, expected]);
    }
    let mut missing = shisen(folder.path());
    refused(
        folder.path(),
        missing.args(["cave", "--mesh", "no.obj"]),
        1,
        &["no.obj", "check"],
    );
    fs::write(
        folder.path().join("flat.obj"),
        "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n",
    )
    .unwrap();
    let mut flat = shisen(folder.path());
    refused(
        folder.path(),
        flat.args(["cave", "--mesh", "flat.obj"]),
        1,
        &["flat.obj", "turn it"],
    );
}

#[test]
fn polygon_levels_that_cannot_be_reached_are_named() {
    // A tetrahedron whose faces have a material each, so that no edge can go.
    let folder = folder();
    let mesh = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                usemtl a\nf 1 3 2\nusemtl b\nf 1 2 4\nusemtl c\nf 1 4 3\nusemtl d\nf 2 3 4\n";
    let materials = ["newmtl a\n", "newmtl b\n", "newmtl c\n", "newmtl d\n"].concat();
    fs::write(folder.path().join("m.mtl"), materials).unwrap();
    fs::write(folder.path().join("m.obj"), mesh).unwrap();
    for arguments in [
        &["bake", "m.obj", "-o", "m.shisen"][..],
        &["bake", "A", "--mesh", "m.obj", "-o", "m.shisen"],
        &["cave", "--mesh", "m.obj", "--lod", "paper"],
        &["bench", "table2", "--mesh", "m.obj"],
    ] {
        let mut command = command_line(folder.path(), arguments);
        command.args(["--faces", "1..", "--levels", "2"]);
        let expected = [
            "mesh 0",
            "as few faces as 1 ",
            "4 is the least that it gets to",
            "--faces MIN..MAX",
        ];
        refused(folder.path(), &mut command, 1, &expected);
    }
}

#[test]
fn polygon_levels_of_a_baked_scene_are_chosen_when_baking() {
    let folder = folder();
    shisen(folder.path())
        .args(["bake", "A", "-o", "a.shisen", "--levels", "2"])
        .assert()
        .success();
    for levels in [["--faces", "600..3000"], ["--levels", "3"]] {
        for lod in ["off", "paper", "paper-ellipse"] {
            let mut command = shisen(folder.path());
            command.args(["cave", "--scene", "a.shisen", "--lod", lod]);
            let expected = [
                levels[0],
                "a.shisen",
                "chosen when baking",
                "shisen bake --faces MIN..MAX --levels N",
            ];
            refused(folder.path(), command.args(levels), 2, &expected);
        }
    }
}

#[test]
fn broken_scenes_are_named() {
    let folder = folder();
    let object = "[[object]]\nsphere = { radius = 1 }\n";
    for (name, text, expected) in [
        (
            "syntax.toml",
            "[[object]\n".to_owned(),
            &["syntax.toml:1"][..],
        ),
        ("empty.toml", String::new(), &["empty.toml", "no objects"]),
        (
            "key.toml",
            format!("colour = 1\n{object}"),
            &["key.toml:1", "colour"],
        ),
        (
            "radius.toml",
            object.replace('1', "-1"),
            &["radius.toml:2", "radius"],
        ),
        (
            "mesh.toml",
            "[meshes.cow]\nfile = \"no.obj\"\n[[object]]\nmesh = \"cow\"\n".to_owned(),
            &["no.obj", "mesh.toml:1"],
        ),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
        let mut cave = shisen(folder.path());
        refused(
            folder.path(),
            cave.args(["cave", "--scene", name]),
            1,
            expected,
        );
        let mut bake = shisen(folder.path());
        refused(
            folder.path(),
            bake.args(["bake", name, "-o", "new.shisen"]),
            1,
            expected,
        );
    }
    let far = format!("v 1e11 0 0\n{TRIANGLE}f 1 2 3\n");
    fs::write(folder.path().join("far.obj"), far).unwrap();
    let text = "[meshes.far]\nfile = \"far.obj\"\n[[object]]\nmesh = \"far\"\nscale = 1e3\n";
    fs::write(folder.path().join("far.toml"), text).unwrap();
    let mut cave = shisen(folder.path());
    let expected = ["far.toml cannot be baked", "object 0", "too far"];
    refused(
        folder.path(),
        cave.args(["cave", "--scene", "far.toml"]),
        1,
        &expected,
    );
    fs::write(folder.path().join("bytes"), [0xFF, 0xFE, 0x00]).unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    for (name, expected) in [
        ("no.toml", "no.toml"),
        ("E", "give A, B, C, D, grid, prism or spheres"),
        ("bytes", "neither a TOML description nor a baked scene"),
        ("folder", "cannot read the scene in folder"),
        ("cow.obj", "--mesh FILE"),
    ] {
        let mut cave = shisen(folder.path());
        refused(
            folder.path(),
            cave.args(["cave", "--scene", name]),
            1,
            &[name, expected],
        );
    }
}

#[test]
fn damaged_blobs_are_named() {
    let folder = folder();
    fs::write(
        folder.path().join("one.obj"),
        format!("{TRIANGLE}f 1 2 3\n"),
    )
    .unwrap();
    let mut bake = shisen(folder.path());
    bake.args(["bake", "one.obj", "-o", "whole.shisen"])
        .assert()
        .success();
    let whole = fs::read(folder.path().join("whole.shisen")).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0x10;
    let mut newer = whole.clone();
    newer[12] = 0xFF;
    for (bytes, expected) in [
        (&whole[..whole.len() - 1], "cut off"),
        (&whole[..20], "cut off"),
        (&flipped, "checksum"),
        (&newer, "version 255"),
    ] {
        let name = "damaged.shisen";
        fs::write(folder.path().join(name), bytes).unwrap();
        for arguments in [&["cave", "--scene", name][..], &["inspect", name]] {
            let mut command = shisen(folder.path());
            refused(
                folder.path(),
                command.args(arguments),
                1,
                &[name, expected, "bake"],
            );
        }
    }
    for (name, expected) in [("one.obj", "not a baked scene"), ("no.shisen", "no.shisen")] {
        let mut command = shisen(folder.path());
        refused(
            folder.path(),
            command.args(["inspect", name]),
            1,
            &[name, expected],
        );
    }
    let mut again = shisen(folder.path());
    again.args(["bake", "whole.shisen", "-o", "again.shisen"]);
    refused(
        folder.path(),
        &mut again,
        1,
        &["whole.shisen is baked already"],
    );
}

#[test]
fn unusable_walls_are_named() {
    let folder = folder();
    let wall = |lower_right: &str, upper_left: &str| {
        format!(
            "[[wall]]\nname = \"screen\"\nlower_left = [-1, -1, -1]\n\
             lower_right = {lower_right}\nupper_left = {upper_left}\n"
        )
    };
    for (name, text, expected) in [
        (
            "width.toml",
            wall("[-1, -1, -1]", "[-1, 1, -1]"),
            "no width",
        ),
        (
            "height.toml",
            wall("[1, -1, -1]", "[-1, -1, -1]"),
            "no height",
        ),
        (
            "line.toml",
            wall("[1, -1, -1]", "[3, -1, -1]"),
            "on one line",
        ),
        (
            "behind.toml",
            wall("[-1, -1, 1]", "[-1, -1, -3]"),
            "on one line",
        ),
        (
            "turned.toml",
            wall("[-1, 1, -1]", "[1, -1, -1]"),
            "behind its plane",
        ),
        ("nan.toml", wall("[nan, -1, -1]", "[-1, 1, -1]"), "NaN"),
        (
            "pixels.toml",
            wall("[1, -1, -1]", "[-1, 1, -1]") + "pixels = [0, 9]\n",
            "0 × 9",
        ),
        ("none.toml", String::new(), "[[wall]]"),
    ] {
        fs::write(folder.path().join(name), &text).unwrap();
        let wall = if text.is_empty() { name } else { "screen" };
        let mut command = shisen(folder.path());
        let command = command.args(["cave", "--walls", name, "--out", "new"]);
        refused(folder.path(), command, 1, &[wall, expected]);
    }
    let mut missing = shisen(folder.path());
    refused(
        folder.path(),
        missing.args(["cave", "--walls", "no.toml"]),
        1,
        &["no.toml"],
    );
    for (head, wall, expected) in [
        ("0,0,-1.5", "front", "in its plane"),
        ("-0.5,0,-2", "front", "behind its plane"),
        ("1.6,0,0", "right", "behind its plane"),
        ("0,-7,0", "floor", "behind its plane"),
        ("1e30,0,0", "front", "cannot be seen"),
    ] {
        let mut command = shisen(folder.path());
        let command = command.args(["cave", "--eyes", "1", "--head", head, "--out", "new"]);
        refused(folder.path(), command, 1, &[wall, expected]);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_named_and_nothing_is_left() {
    let folder = folder();
    fs::write(folder.path().join("file"), "kept").unwrap();
    fs::create_dir_all(folder.path().join("out/front-left.png")).unwrap();
    for (out, expected) in [
        ("file", "file"),
        ("file/below", "--out"),
        ("out", "front-left.png"),
    ] {
        let mut command = shisen(folder.path());
        command.args(["cave", "--size", "8", "--out", out]);
        refused(folder.path(), &mut command, 1, &[out, expected]);
    }
    for (output, expected) in [
        ("file/below.shisen", "not a folder"),
        ("no/folder.shisen", "create it first"),
        ("out", "out: cannot write"),
    ] {
        let mut command = shisen(folder.path());
        command.args(["bake", "A", "-o", output]);
        refused(folder.path(), &mut command, 1, &[output, expected]);
    }
    // What was there stays where its successor cannot be made.
    let mut command = shisen(folder.path());
    command.args(["bake", "no.toml", "-o", "file"]);
    refused(folder.path(), &mut command, 1, &["no.toml"]);
}

#[test]
fn rays_that_are_none_are_named() {
    let folder = folder();
    fs::write(
        folder.path().join("one.obj"),
        format!("{TRIANGLE}f 1 2 3\n"),
    )
    .unwrap();
    fs::write(folder.path().join("rays.bin"), [0; 24]).unwrap();
    fs::write(folder.path().join("odd.bin"), [0; 25]).unwrap();
    fs::write(folder.path().join("empty.bin"), []).unwrap();
    for (mesh, rays, expected) in [
        ("one.obj", "odd.bin", "25 bytes"),
        ("one.obj", "empty.bin", "0 bytes"),
        ("one.obj", "no.bin", "no.bin"),
        ("no.obj", "rays.bin", "no.obj"),
    ] {
        let mut command = evidence(folder.path());
        command.args([
            "bench", "rays", "--mesh", mesh, "--rays", rays, "--hits", "hits.bin",
        ]);
        refused(folder.path(), &mut command, 1, &[expected]);
    }
    let mut command = evidence(folder.path());
    command.args(["bench", "rays", "--mesh", "one.obj", "--rays", "rays.bin"]);
    refused(
        folder.path(),
        command.args(["--hits", "no/hits.bin"]),
        1,
        &["no/hits.bin"],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_printed_is_a_failure() {
    let folder = folder();
    let program = shisen(folder.path()).get_program().to_owned();
    let full = |arguments: &[&str]| {
        let full = fs::OpenOptions::new().write(true).open("/dev/full");
        std::process::Command::new(&program)
            .current_dir(folder.path())
            .args(arguments)
            .stdout(full.unwrap())
            .output()
            .unwrap()
    };
    for arguments in [
        &["cave", "--size", "8", "--json"][..],
        &["cave", "--help"],
        &["--version"],
    ] {
        let full = full(arguments);
        let message = String::from_utf8(full.stderr).unwrap();
        assert_eq!(full.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(message.contains("standard output"), "{message}");
    }
}

/// What help says of an argument: all up to the next one.
fn help_of(folder: &Path, command: &[&str], argument: &str) -> String {
    let output = command_line(folder, command)
        .arg("--help")
        .assert()
        .success();
    let help = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    let (_, after) = help.split_once(&format!("      {argument} <")).unwrap();
    let (own, _) = after.split_once("\n      --").unwrap();
    own.to_owned()
}

/// Who gives one of them nevertheless is told why there is none.
#[test]
fn values_that_a_command_refuses_are_not_in_its_help() {
    let folder = folder();
    let (all, live) = (["comb", "split", "paper", "fixed"], &["paper", "fixed"]);
    for (command, argument, values, refused) in [
        (
            &["explain"][..],
            "--lod",
            &["off", "paper", "foveated"][..],
            &["foveated"][..],
        ),
        (&["explain"], "--dispersion", &all, live),
        (&["run"], "--dispersion", &all, live),
        (&["bench", "budget"], "--dispersion", &all, live),
        (&["bench", "latency"], "--dispersion", &all, live),
        (&["cave"], "--dispersion", &all, &[]),
        (&["run"], "--lod", &["off", "paper", "foveated"], &[]),
    ] {
        let help = help_of(folder.path(), command, argument);
        for value in values {
            let is_there = help.contains(&format!("- {value}:"));
            assert_ne!(is_there, refused.contains(value), "{command:?}: {help}");
        }
    }
    for (arguments, expected) in [
        (
            &["explain", "--lod", "foveated"][..],
            "leaves some out: take --lod paper",
        ),
        (
            &["explain", "prism", "--dispersion", "fixed"],
            "explain comb or split",
        ),
        (
            &[
                "run",
                "--scene",
                "prism",
                "--hz",
                "60",
                "--dispersion",
                "paper",
            ],
            "take comb or split",
        ),
        (
            &["cave", "--wavelengths", "3", "--each", "4"],
            "there are 3 wavelengths: give at most 3",
        ),
    ] {
        refused_by(&folder, arguments, expected);
    }
}

/// Fails as wrong usage does.
fn refused_by(folder: &tempfile::TempDir, arguments: &[&str], expected: &str) {
    refused(
        folder.path(),
        &mut command_line(folder.path(), arguments),
        2,
        &[expected],
    );
}
