//! Checks bad input: it gives an exit code and one paragraph that says what to do, and creates no
//! file.

use shisen_tests::command::{self, folder, line, refusal, run, shisen};
use std::fs;
use std::path::{Path, PathBuf};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// Returns all files and folders below `folder`, and the files' contents.
fn contents(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(contents(&path));
        }
        let bytes = fs::read(&path).ok();
        all.push((path, bytes));
    }
    all.sort();
    all
}

/// Checks what [`command::refused`] checks, and that `folder` does not change.
fn refused(folder: &Path, code: i32, table: &str) {
    let before = contents(folder);
    command::refused(folder, code, table);
    assert_eq!(contents(folder), before);
}

/// Writes files, and checks that commands on each are refused with its name and some words.
fn files_refused(folder: &Path, commands: &[&str], files: &[(&str, &[u8], &str)]) {
    for (name, bytes, expected) in files {
        fs::write(folder.join(name), bytes).unwrap();
        for words in commands {
            refused(folder, 1, &format!("{words} {name} => {name} & {expected}"));
        }
    }
}

/// Checks that an error about arguments that exclude each other ends with their command's usage.
#[test]
fn usage_is_that_of_the_command_asked_for() {
    let folder = folder();
    for (words, name) in [
        ("run --scene grid --budget paper", "shisen run"),
        ("cave --lod off --fill capture", "shisen cave"),
        (
            "bench latency --scene grid --budget paper",
            "shisen-evidence bench latency",
        ),
        (
            "tracker serve mock --as hid --to line",
            "shisen tracker serve",
        ),
    ] {
        let output = line(folder.path(), words).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8_lossy(&output.stderr);
        let usage = format!("\n\nUsage: {name} [OPTIONS]");
        let hint = format!("try '{name} --help'.\n");
        assert!(
            message.starts_with("error: ") && message.contains(&usage),
            "{message}"
        );
        // Only a terminal gets colours.
        assert!(
            message.ends_with(&hint) && !message.contains('\u{1b}'),
            "{message}"
        );
    }
}

/// Wrong arguments, and words of the error for each.
const USAGE: &str = r#"
    run --fill previous --lod off => with --lod off no ray is skipped
    cave --fill previous --lod foveated => with --lod foveated no ray is skipped
    run --scene A --fill previous => --outputs: nothing is shown
    run --look floor => where the tracker says
    bench latency --as hid => does not go over a serial line
    cave --size 0 => --size
    cave --size 16385 => from 1 to 16384
    cave --size -1 => from 1 to 16384
    cave --threads 0 => --threads
    cave --samples 0 => --samples
    cave --depth 17 => from 0 to 16
    cave --eyes 3 => from 1 to 2
    cave --colour red => --colour
    cave --look sideways => YAW,PITCH
    cave --look 0,91 => pitch of 91
    cave --look 0,0,0 => points nowhere
    cave --look -1,nan => -1,nan
    cave --head 0,0 => X,Y,Z in metres
    cave --head -1,-inf,0 => X,Y,Z in metres
    cave --ipd -0.1 => metres from 0 to 1
    cave --view-size 0x10 => 1 to 16384
    cave --view-fov 180 => degrees from 1 to 179
    cave --head-report xyz => 'x' is not a hexadecimal digit
    cave --head-report 010 => 3 hexadecimal digits
    cave --head-report 0102 => 2 bytes, not 16 or 32
    cave --head-report 04000000000000000040000000000000 => version 4
    cave --head-report 01000000000000000020000000000000 => norm 0.5
    cave --normals wavy => smooth, flat
    cave --scene s.toml --mesh m.obj => --mesh
    cave --wavelengths 3 --each 4 => there are 3 wavelengths: give at most 3
    bake A -o x.shisen --faces 5..4 => 5, is above the most, 4
    bake A -o x.shisen --faces 500 => 500..5804
    bake A -o x.shisen --levels 1 => from 2 to 64
    cave --lod paper --faces 5..4 => 5, is above the most, 4
    cave --lod paper --faces 0.. => at least 1
    cave --lod paper --faces many => 500..5804
    cave --lod paper --levels 65 => from 2 to 64
    cave --faces 500.. => --lod paper
    cave --lod off --levels 4 => --lod paper
    cave --lod foveated --faces 500.. => with --lod foveated all rays see every face
    cave --fixate 0,0,-1 => --fixate is for --lod paper
    cave --lod off --up 1,1,0 => --up is for --lod paper
    cave --lod paper --up 0,0,-1 => parallel
    cave --lod paper --up 0,0,0 => nowhere
    cave --lod paper --fixate 0,nan,0 => not a position
    cave --lod paper --eyes 1 --fixate 0,0,0 => points nowhere
    cave --lod full => paper-ellipse
    cave --lod paper --fill-size 64 => --fill capture
    cave --lod paper --fill previous => --previous-look
    cave --lod paper --previous-look front => --fill previous
    cave --lod paper --fill capture --fill-level 1.5 => from 0 to 1
    cave --lod paper --fill capture --fill-size 0 => --fill-size
    cave --effects -shadow => did you mean "shadows"?
    cave --effects +caustics => use one of: shadows, reflection
    cave --effects shadows => write +shadows or -shadows
    cave --stereo both => there is no stereo "both"
    cave --stereo anaglyph --eyes 1 => takes two eyes: leave --eyes 1 out
    run --view png --stereo anaglyph --eyes 1 => takes two eyes: leave --eyes 1 out
    run --stereo anaglyph => is for --view png or window
    explain A --scene B => --scene
    explain --lod foveated => pixels share light: take --lod paper
    explain prism --dispersion fixed => explain comb or split
    run --scene prism --hz 60 --dispersion paper => take comb or split
    gaze --faces 500.. => 500..5804
    bake A => --output
    bake -o x.shisen => INPUT
    bake A B -o x.shisen => one scene at a time
    bake a.obj --mesh b.obj -o x.shisen => --mesh
    bake A -o x.shisen --layout wide => fast, compact
    bench rays --mesh m.obj => --rays
    bench rays --mesh m.obj --rays r --repeat 0 => --repeat
    bench table2 --size 0 => --size
    bench table2 --faces 9..3 => above the most, 3
    bench sweep --directions 0 => --directions
    bench sweep --levels 65 => from 2 to 64
    bench table2 --mesh A --repeat 0 => --repeat
    bench => Usage
    test-pattern paint => near-black
    test-pattern depth --eyes 1 => --eyes 1
    test-pattern focus --stereo anaglyph => --stereo
    test-pattern => NAME
    completions tcsh => zsh
    paint => paint
    => Usage
"#;

#[test]
fn arguments_out_of_range_are_usage() {
    refused(folder().path(), 2, USAGE);
}

#[test]
fn commands_that_are_elsewhere_say_where() {
    let folder = folder();
    for (words, place) in [
        ("bench table2 --size 8", "-p shisen-evidence -- bench"),
        ("firmware run --frames 1", "tests/firmware/run"),
    ] {
        let said = refusal(shisen(folder.path()).args(words.split(' ')), 2);
        let (_, rest) = words.split_once(" --").unwrap();
        assert!(said.contains(place) && said.contains(rest), "{said}");
        assert!(!said.contains("Usage"), "{said}");
    }
}

#[test]
fn help_and_version_are_no_failure() {
    let folder = folder();
    let commands = ["--help", "--version", "bench rays -h", "completions zsh"];
    for words in commands {
        let said = run(folder.path(), words);
        assert!(!said.out.is_empty() && said.err.is_empty(), "{words}");
    }
}

#[test]
fn broken_meshes_are_named() {
    let folder = folder();
    let folder = folder.path();
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 178956970\n\
                  property float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let face = |face: &str| format!("{TRIANGLE}{face}\n").into_bytes();
    let commands = ["cave --out new --mesh", "bake A -o new.shisen --mesh"];
    files_refused(
        folder,
        &commands,
        &[
            (
                "text.txt",
                b"hello",
                ".obj, .ply, .stl, .vtp, .gltf or .glb",
            ),
            ("words.obj", b"this is not a mesh", "is this an OBJ file"),
            ("words.ply", b"this is not a mesh", "words.ply"),
            ("words.glb", b"this is not a mesh", "words.glb"),
            ("empty.obj", b"", "no line describes"),
            ("points.obj", TRIANGLE.as_bytes(), "no triangles"),
            ("nan.obj", &face("v nan 0 0\nf 1 2 4"), "nan.obj"),
            ("infinite.obj", &face("v 0 inf 0\nf 1 2 4"), "infinite.obj"),
            ("range.obj", &face("f 1 2 4"), "1 to 3"),
            ("twice.obj", &face("f 1 2 2"), "no triangles"),
            // A header that promises 2 GiB of vertices, and no vertex.
            ("claim.ply", header.as_bytes(), "2147483640"),
        ],
    );
    let point = b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n";
    files_refused(
        folder,
        &commands[..1],
        &[("point.obj", point, "the mesh is a point")],
    );
    refused(folder, 1, "cave --mesh no.obj => no.obj & check");
}

#[test]
fn unreachable_polygon_levels_are_named() {
    // A tetrahedron with a material for each face, so that no edge can be removed.
    let folder = folder();
    let folder = folder.path();
    let mesh = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n\
                usemtl a\nf 1 3 2\nusemtl b\nf 1 2 4\nusemtl c\nf 1 4 3\nusemtl d\nf 2 3 4\n";
    let materials = "newmtl a\nnewmtl b\nnewmtl c\nnewmtl d\n";
    fs::write(folder.join("m.mtl"), materials).unwrap();
    fs::write(folder.join("m.obj"), mesh).unwrap();
    let said = run(folder, "bake m.obj -o m.shisen --faces 1.. --levels 2");
    let expected = "mesh 0 (counted from 0) has 4 faces at its coarsest level, not 1:";
    assert!(said.err.contains(expected), "{}", said.err);
}

#[test]
fn polygon_levels_of_a_baked_scene_are_chosen_when_baking() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("one.obj"), format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    run(folder, "bake one.obj -o a.shisen");
    for levels in ["--faces 600..3000", "--levels 3"] {
        for lod in ["off", "paper-ellipse"] {
            let expected = "chosen when baking & shisen bake --faces MIN..MAX --levels N";
            let words = format!("cave --scene a.shisen --lod {lod} {levels}");
            refused(folder, 2, &format!("{words} => a.shisen & {expected}"));
        }
    }
}

#[test]
fn broken_scenes_are_named() {
    let folder = folder();
    let folder = folder.path();
    let object = "[[object]]\nsphere = { radius = 1 }\n";
    let missing = "[meshes.cow]\nfile = \"no.obj\"\n[[object]]\nmesh = \"cow\"\n";
    let (key, radius) = (format!("colour = 1\n{object}"), object.replace('1', "-1"));
    files_refused(
        folder,
        &["cave --scene", "bake -o new.shisen"],
        &[
            ("syntax.toml", b"[[object]\n", "syntax.toml:1"),
            ("empty.toml", b"", "no objects"),
            ("key.toml", key.as_bytes(), "key.toml:1"),
            ("radius.toml", radius.as_bytes(), "radius.toml:2"),
            ("mesh.toml", missing.as_bytes(), "no.obj"),
        ],
    );
    let far = format!("v 1e11 0 0\n{TRIANGLE}f 1 2 3\n");
    fs::write(folder.join("far.obj"), far).unwrap();
    let text = "[meshes.far]\nfile = \"far.obj\"\n[[object]]\nmesh = \"far\"\nscale = 1e3\n";
    fs::write(folder.join("far.toml"), text).unwrap();
    fs::write(folder.join("bytes"), [0xFF, 0xFE, 0x00]).unwrap();
    fs::create_dir(folder.join("folder")).unwrap();
    refused(
        folder,
        1,
        "
        cave --scene far.toml => far.toml cannot be baked & object 0 & too far
        cave --scene no.toml => no.toml
        cave --scene E => E & give A, B, C, D, gallery, grid, prism or spheres
        cave --scene bytes => bytes & neither a TOML description nor a baked scene
        cave --scene folder => cannot read the scene in folder
        cave --scene cow.obj => cow.obj & no such file",
    );
}

#[test]
fn damaged_blobs_are_named() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("one.obj"), format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    run(folder, "bake one.obj -o whole.shisen");
    let whole = fs::read(folder.join("whole.shisen")).unwrap();
    let [mut flipped, mut newer] = [whole.clone(), whole.clone()];
    flipped[whole.len() / 2] ^= 0x10;
    newer[12] = 0xFF;
    files_refused(
        folder,
        &["cave --scene", "inspect"],
        &[
            ("cut.shisen", &whole[..whole.len() - 1], "cut off & bake"),
            ("short.shisen", &whole[..20], "cut off & bake"),
            ("flipped.shisen", &flipped, "checksum & bake"),
            ("newer.shisen", &newer, "version 255 & bake"),
        ],
    );
    refused(
        folder,
        1,
        "
        inspect not.obj => not.obj
        inspect no.shisen => no.shisen
        bake whole.shisen -o new => whole.shisen is baked already",
    );
}

#[test]
fn unusable_walls_are_named() {
    let folder = folder();
    let folder = folder.path();
    let wall = "[[wall]]\nname = \"screen\"\nlower_left = [-1, -1, -1]\n";
    for (name, text, expected) in [
        ("width", "[-1, -1, -1] | [-1, 1, -1]", "no width"),
        ("height", "[1, -1, -1] | [-1, -1, -1]", "no height"),
        ("line", "[1, -1, -1] | [3, -1, -1]", "on one line"),
        ("turned", "[-1, 1, -1] | [1, -1, -1]", "behind its plane"),
        ("nan", "[nan, -1, -1] | [-1, 1, -1]", "NaN"),
        (
            "pixels",
            "[1, -1, -1] | [-1, 1, -1]\npixels = [0, 9]",
            "0 × 9",
        ),
    ] {
        let text = format!(
            "{wall}lower_right = {}\n",
            text.replace(" | ", "\nupper_left = ")
        );
        fs::write(folder.join(format!("{name}.toml")), text).unwrap();
        refused(
            folder,
            1,
            &format!("cave --walls {name}.toml --out new => screen & {expected}"),
        );
    }
    fs::write(folder.join("none.toml"), "").unwrap();
    refused(
        folder,
        1,
        "
        cave --walls no.toml => no.toml
        cave --walls none.toml => none.toml & [[wall]]
        cave --eyes 1 --head 0,0,-1.5 --out new => front & in its plane
        cave --eyes 1 --head -0.5,0,-2 --out new => front & behind its plane
        cave --eyes 1 --head 1.6,0,0 --out new => right & behind its plane
        cave --eyes 1 --head 0,-7,0 --out new => floor & behind its plane
        cave --eyes 1 --head 1e30,0,0 --out new => front & cannot be seen",
    );
}

#[test]
fn unwritable_outputs_are_named_and_nothing_is_left() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("file"), "kept").unwrap();
    fs::create_dir_all(folder.join("out/front-left.png")).unwrap();
    // An old file stays if the new one cannot be written.
    refused(
        folder,
        1,
        "
        cave --size 8 --scene grid --out file => file
        cave --size 8 --scene grid --out file/below => --out
        cave --size 8 --scene grid --out out => front-left.png
        dome curve --out file => --out
        dome nearfield --out file => --out
        bake grid -o file/below.shisen => not a folder
        bake grid -o no/folder.shisen => create it first
        bake grid -o out => out: cannot write
        bake no.toml -o file => no.toml",
    );
}

#[test]
fn unusable_files_of_rays_are_named() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("one.obj"), format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    for (name, bytes) in [("rays.bin", 24), ("odd.bin", 25), ("empty.bin", 0)] {
        fs::write(folder.join(name), vec![0; bytes]).unwrap();
    }
    refused(
        folder,
        1,
        "
        bench rays --mesh one.obj --rays odd.bin --hits hits.bin => 25 bytes
        bench rays --mesh one.obj --rays empty.bin --hits hits.bin => 0 bytes
        bench rays --mesh one.obj --rays no.bin --hits hits.bin => no.bin
        bench rays --mesh no.obj --rays rays.bin --hits hits.bin => no.obj
        bench rays --mesh one.obj --rays rays.bin --hits no/hits.bin => no/hits.bin",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_that_cannot_be_printed_is_a_failure() {
    let folder = folder();
    for words in [
        "cave --scene grid --size 8 --json",
        "cave --help",
        "--version",
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full");
        let output = std::process::Command::new(shisen(folder.path()).get_program())
            .current_dir(folder.path())
            .args(words.split(' '))
            .stdout(full.unwrap())
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{words}: {message}");
        assert!(message.contains("standard output"), "{message}");
    }
}
