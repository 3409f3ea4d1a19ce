//! Screens full-screen on the monitors of X servers without a screen.
//!
//! `tests/window/run` runs these: they need `Xvfb`.

use super::window::{Server, until};
use serde_json::Value;
use shisen_tests::command::{count, folder, line, list, refusal, run, shisen};
use shisen_tests::png_file::PngFile;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use x11rb::connection::Connection;
use x11rb::protocol::randr::{ConnectionExt as _, MonitorInfo};
use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// A connection to a server that has monitors side by side.
struct Wall {
    connection: RustConnection,
    root: u32,
    /// Columns and rows of each.
    size: [u16; 2],
}

impl Wall {
    fn new(server: &Server, size: [u16; 2], monitors: &[&str]) -> Self {
        let (connection, screen) = x11rb::connect(Some(&server.name)).expect("a server");
        let root = connection.setup().roots[screen].root;
        let wall = Self {
            connection,
            root,
            size,
        };
        for (number, name) in monitors.iter().enumerate() {
            wall.add(name, number);
        }
        wall
    }

    fn atom(&self, name: &str) -> u32 {
        let atom = self.connection.intern_atom(false, name.as_bytes());
        atom.expect("a request").reply().expect("an atom").atom
    }

    fn add(&self, name: &str, number: usize) {
        let monitor = MonitorInfo {
            name: self.atom(name),
            primary: false,
            automatic: false,
            x: number as i16 * self.size[0] as i16,
            y: 0,
            width: self.size[0],
            height: self.size[1],
            width_in_millimeters: 300,
            height_in_millimeters: 300,
            outputs: Vec::new(),
        };
        let set = self.connection.randr_set_monitor(self.root, monitor);
        set.expect("a request").check().expect("a monitor");
    }

    fn delete(&self, name: &str) {
        let gone = self
            .connection
            .randr_delete_monitor(self.root, self.atom(name));
        gone.expect("a request").check().expect("no monitor");
        self.connection.sync().expect("a server");
    }

    /// Returns what a monitor shows: 0xRRGGBB, row by row.
    fn seen(&self, number: usize) -> Vec<u32> {
        let ([width, height], x) = (self.size, number as i16 * self.size[0] as i16);
        let format = ImageFormat::Z_PIXMAP;
        let image = (self.connection).get_image(format, self.root, x, 0, width, height, !0);
        let bytes = image.expect("a request").reply().expect("a picture").data;
        let pixels = bytes.as_chunks().0.iter().copied().map(u32::from_le_bytes);
        pixels.map(|pixel| pixel & 0x00FF_FFFF).collect()
    }
}

/// Returns the pixels of a picture in a folder.
fn of_file(folder: &Path, name: &str) -> Vec<u32> {
    let pixels = PngFile::open(folder.join("shisen-out").join(name)).rgb();
    let code = |[red, green, blue]: [u8; 3]| u32::from_be_bytes([0, red, green, blue]);
    pixels.into_iter().map(code).collect()
}

fn start(folder: &Path, server: &Server, words: &str) -> Child {
    Command::new(shisen(folder).get_program())
        .current_dir(folder)
        .env("DISPLAY", &server.name)
        .args(words.split_whitespace())
        .arg("--json")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("shisen")
}

/// Waits for the end; returns the report and what was said.
fn finish(child: Child) -> (Value, String) {
    let output = child.wait_with_output().expect("its end");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (
        serde_json::from_slice(&output.stdout).expect("an object"),
        said,
    )
}

/// Returns a folder with the pictures of three walls.
fn pictures() -> tempfile::TempDir {
    let folder = folder();
    run(folder.path(), "cave --scene A --size 256");
    folder
}

const THREE: &str = "--outputs front=wall0,right=wall1,floor=wall2";

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn each_monitor_shows_its_screen_and_all_show_a_frame_at_one_refresh() {
    let (folder, server) = (pictures(), Server::of("768x256"));
    let wall = Wall::new(&server, [256; 2], &["wall0", "wall1", "wall2"]);
    let shown = start(
        folder.path(),
        &server,
        &format!("show shisen-out {THREE} --seconds 5"),
    );
    for (number, name) in ["front", "right", "floor"].into_iter().enumerate() {
        let picture = of_file(folder.path(), &format!("{name}-left.png"));
        until(|| (wall.seen(number) == picture).then_some(()));
    }
    let (report, said) = finish(shown);
    assert_eq!(said, "");
    for output in list(&report, "outputs") {
        assert!(count(output, "shown") > 150, "{report}");
    }
    let (parted, compared) = (
        count(&report, "parted_frames"),
        count(&report, "compared_frames"),
    );
    assert!(compared > 150 && parted * 20 <= compared, "{report}");
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn a_monitor_that_goes_and_comes_back_and_a_server_that_dies_are_told_of() {
    let (folder, server) = (pictures(), Server::of("768x256"));
    let other = Server::of("256x256");
    let wall = Wall::new(&server, [256; 2], &["wall0", "wall1"]);
    let outputs = format!(
        "[[output]]\nshow = \"front\"\nmonitor = \"wall0\"\n\
         [[output]]\nshow = \"right\"\nmonitor = \"wall1\"\n\
         [[output]]\nshow = \"floor\"\nmonitor = \"screen\"\nserver = \"{}\"\n",
        other.name
    );
    std::fs::write(folder.path().join("outputs.toml"), outputs).expect("a file");
    let shown = start(
        folder.path(),
        &server,
        "show shisen-out --outputs outputs.toml --seconds 8",
    );
    let picture = of_file(folder.path(), "right-left.png");
    until(|| (wall.seen(1) == picture).then_some(()));
    wall.delete("wall1");
    until(|| wall.seen(1).iter().all(|&pixel| pixel == 0).then_some(()));
    other.signal("-KILL");
    // Back at another place.
    wall.add("wall1", 2);
    until(|| (wall.seen(2) == picture).then_some(()));
    let front = of_file(folder.path(), "front-left.png");
    assert_eq!(wall.seen(0), front);
    let (report, said) = finish(shown);
    for part in ["wall1 has gone", "wall1 is back", "others go on"] {
        assert!(said.contains(part), "{said}");
    }
    assert!(
        count(&list(&report, "outputs")[0], "shown") > 240,
        "{report}"
    );
}

/// A server without shared memory shows the same, and that is said once; one that stops answering in
/// mid-show is told of, and does not hold up the others.
#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn servers_that_lack_something_show_all_the_same() {
    let folder = pictures();
    let picture = of_file(folder.path(), "front-left.png");
    let server = Server::without("256x256", &["MIT-SHM"]);
    let wall = Wall::new(&server, [256; 2], &["wall0"]);
    let words = "show shisen-out --outputs front=wall0 --seconds 4";
    let shown = start(folder.path(), &server, words);
    until(|| (wall.seen(0) == picture).then_some(()));
    let (_, said) = finish(shown);
    assert_eq!(said.matches("shares no memory").count(), 1, "{said}");
    let [server, silent] = ["256x256"; 2].map(Server::of);
    let outputs = format!(
        "[[output]]\nshow = \"front\"\nmonitor = \"screen\"\n\
         [[output]]\nshow = \"floor\"\nmonitor = \"screen\"\nserver = \"{}\"\n",
        silent.name
    );
    std::fs::write(folder.path().join("outputs.toml"), outputs).expect("a file");
    let words = "show shisen-out --outputs outputs.toml --seconds 6";
    let shown = start(folder.path(), &server, words);
    let wall = Wall::new(&server, [256; 2], &[]);
    until(|| (wall.seen(0) == picture).then_some(()));
    silent.signal("-STOP");
    let (report, said) = finish(shown);
    silent.signal("-CONT");
    assert!(
        said.contains("does not say that frames are shown"),
        "{said}"
    );
    assert!(
        count(&list(&report, "outputs")[0], "shown") > 200,
        "{report}"
    );
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn frames_follow_the_refresh_and_eyes_take_turns() {
    let (folder, server) = (folder(), Server::of("120x40"));
    let wall = Wall::new(&server, [40; 2], &["wall0", "wall1", "wall2"]);
    let words = format!(
        "run --scene A --size 40 {THREE} --stereo sequential --view none --seconds 5 --lod off \
         --budget 8ms --report log"
    );
    let shown = start(folder.path(), &server, &words);
    let (report, said) = finish(shown);
    assert!(!said.contains("wrong eye"), "{said}");
    for output in list(&report["outputs"], "outputs") {
        let (frames, wrong) = (count(output, "shown"), count(output, "wrong_eyes"));
        assert!(frames > 60 && wrong <= 6, "{report}");
    }
    // A frame is a pair of refreshes, or more.
    let log = std::fs::read_to_string(folder.path().join("log")).expect("a log");
    let records = log
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("a record"));
    let times: Vec<u64> = records.map(|record| count(&record, "present_us")).collect();
    let gaps = times.windows(2).map(|pair| pair[1] - pair[0]);
    let short = gaps.filter(|gap| *gap < 25_000).count();
    assert!(times.len() > 60 && 20 * short < times.len(), "{times:?}");
    drop(wall);
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn a_monitor_that_is_not_there_is_named_beside_those_that_are() {
    let (folder, server) = (pictures(), Server::of("768x256"));
    let _wall = Wall::new(&server, [256; 2], &["wall0", "wall1"]);
    let mut command = line(folder.path(), "show shisen-out --outputs front=HDMI-7");
    let said = refusal(command.env("DISPLAY", &server.name), 1);
    for part in ["no monitor HDMI-7", "wall0 (256 × 256)", "wall1"] {
        assert!(said.contains(part), "{said}");
    }
    let mut command = line(
        folder.path(),
        "show shisen-out --outputs front=wall0,right=wall0",
    );
    let said = refusal(&mut command, 1);
    assert!(
        said.contains("wall0 is to show \"front\" and \"right\""),
        "{said}"
    );
}

/// Positions of four projectors before a wall of 3.6 × 1.5 m at z = −2 that look straight at it, and
/// half their picture's width at distance 1.
const POSITIONS: [[f64; 3]; 4] = [
    [-0.85, 1.1, 0.0],
    [0.85, 1.1, 0.1],
    [-0.85, 0.4, 0.05],
    [0.85, 0.4, -0.05],
];
const HALF: f64 = 0.55;

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb"]
fn the_light_of_what_monitors_are_given_adds_up() {
    let (folder, server) = (folder(), Server::of("1024x192"));
    let names = ["wall0", "wall1", "wall2", "wall3"];
    let wall = Wall::new(&server, [256, 192], &names);
    let screen = "[[wall]]\nname = \"front\"\nlower_left = [-1.8, 0, -2]\n\
                  lower_right = [1.8, 0, -2]\nupper_left = [-1.8, 1.5, -2]\n";
    let projectors = names.iter().zip(POSITIONS).map(|(name, position)| {
        format!(
            "[[projector]]\nname = \"{name}\"\nposition = {position:?}\nlook = [0, 0, -1]\n\
             throw = {}\nresolution = [256, 192]\ngamma = 2.2\n",
            0.5 / HALF
        )
    });
    let room = screen.to_owned() + &projectors.collect::<String>();
    std::fs::write(folder.path().join("room.toml"), room).expect("a file");
    let outputs = names.map(|name| format!("{name}={name}")).join(",");
    let words = format!("test-pattern grey-100 --walls room.toml --outputs {outputs} --seconds 6");
    let shown = start(folder.path(), &server, &words);
    let all = || {
        let all = [0, 1, 2, 3].map(|number| wall.seen(number));
        all.iter()
            .all(|one| one.contains(&0x00FF_FFFF))
            .then_some(all)
    };
    let codes = until(all);
    drop(finish(shown));
    // The light at points of the wall, bilinear between the pixels of each picture.
    let light = |number: usize, x: f64, y: f64| {
        let [px, py, pz] = POSITIONS[number];
        let half = HALF * (pz + 2.0);
        let place = [(x - px) / half, (py - y) / (half * 0.75)].map(|at| 0.5 * at + 0.5);
        let depth = place
            .map(|at| at.min(1.0 - at))
            .into_iter()
            .fold(1.0, f64::min);
        let [x, y] = [place[0] * 256.0 - 0.5, place[1] * 192.0 - 0.5];
        let pixel = |x: f64, y: f64| {
            let [x, y] = [x.clamp(0.0, 255.0), y.clamp(0.0, 191.0)];
            let code = codes[number][y as usize * 256 + x as usize] & 0xFF;
            (f64::from(code) / 255.0).powf(2.2)
        };
        let (left, above) = (x.floor(), y.floor());
        let row = |y| pixel(left, y) + (x - left) * (pixel(left + 1.0, y) - pixel(left, y));
        (
            row(above) + (y - above) * (row(above + 1.0) - row(above)),
            depth,
        )
    };
    let (mut worst, mut tried) = (0.0_f64, 0);
    for (column, row) in (0..180).flat_map(|x| (0..75).map(move |y| (x, y))) {
        let (x, y) = (
            0.02 * f64::from(column) - 1.79,
            0.02 * f64::from(row) + 0.01,
        );
        let lights = [0, 1, 2, 3].map(|number| light(number, x, y));
        let inside = lights.iter().filter(|(_, depth)| *depth > 0.02).count();
        let near = lights
            .iter()
            .filter(|(_, depth)| depth.abs() <= 0.02)
            .count();
        if inside > 0 && near < 2 {
            let lit = lights.iter().filter(|(_, depth)| *depth > 0.0);
            let sum: f64 = lit.map(|(light, _)| light).sum();
            worst = worst.max(255.0 * (sum.powf(1.0 / 2.2) - 1.0).abs());
            tried += 1;
        }
    }
    assert!(
        worst <= 1.0 && tried > 8_000,
        "{worst} codes at the worst of {tried} points"
    );
}
