//! The window of `shisen run --view window`, on an X server without a screen.
//!
//! `tests/window/run` runs these: they need `Xvfb` and `xdotool`.

use serde_json::Value;
use shisen_tests::command::{line, refusal, shisen};
use shisen_tests::png_file::PngFile;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest wait for a window, a file or an end, on a busy machine.
const PATIENCE: Duration = Duration::from_mins(1);

/// An X server.
pub(super) struct Server {
    child: Child,
    pub(super) name: String,
}

impl Server {
    fn start() -> Self {
        Self::of("1280x1024")
    }

    /// Starts a server whose screen has so many columns and rows.
    pub(super) fn of(size: &str) -> Self {
        Self::without(size, &[])
    }

    /// Does the same without some extensions.
    pub(super) fn without(size: &str, extensions: &[&str]) -> Self {
        // Without -noreset a server restarts when its last client leaves, and drops a client that
        // connects just then: xdotool connects and leaves many times before the window is there.
        let mut child = Command::new("Xvfb")
            .args("-displayfd 1 -noreset -screen 0".split(' '))
            .arg(format!("{size}x24"))
            .args(extensions.iter().flat_map(|name| ["-extension", name]))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb");
        let mut number = String::new();
        let said = child.stdout.take().expect("what it says");
        let read = BufReader::new(said).read_line(&mut number);
        assert!(read.is_ok() && !number.trim().is_empty(), "no display");
        Self {
            child,
            name: format!(":{}", number.trim()),
        }
    }

    /// Runs xdotool and returns its output; `None` if it fails or prints nothing.
    fn xdotool(&self, arguments: &[&str]) -> Option<String> {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.name)
            .output()
            .expect("xdotool");
        let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        (output.status.success() && !said.is_empty()).then_some(said)
    }

    /// Sends a signal to the server.
    pub(super) fn signal(&self, signal: &str) {
        let kill = Command::new("kill")
            .args([signal, &self.child.id().to_string()])
            .status();
        assert!(kill.expect("kill").success());
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // Kills a stopped server, too.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A run with a window.
struct Run {
    folder: TempDir,
    child: Child,
    window: String,
    screenshots: u32,
}

impl Run {
    fn start(server: &Server, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let program = shisen(folder.path()).get_program().to_owned();
        let mut child = Command::new(program)
            .current_dir(folder.path())
            .env("DISPLAY", &server.name)
            .args("run --scene A --view window --size 48 --json --hz 30".split(' '))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("shisen");
        let search = ["search", "--onlyvisible", "--name", "^Shisen$"];
        let window = until(|| {
            if let Some(status) = child.try_wait().expect("a state") {
                let mut said = String::new();
                let stderr = child.stderr.take().expect("what it says");
                let _ = BufReader::new(stderr).read_to_string(&mut said);
                panic!("it has ended ({status}): {said}");
            }
            server.xdotool(&search)
        });
        let mut run = Self {
            folder,
            child,
            window,
            screenshots: 0,
        };
        // Waits for the first frame: before it the window shows only text, in few colours.
        run.shows(server, |picture| colours(picture) > 20);
        run
    }

    fn key(&self, server: &Server, key: &str) {
        server.xdotool(&["key", "--window", &self.window, key]);
    }

    /// Takes a screenshot of a frame after the keys pressed before.
    fn screenshot(&mut self, server: &Server) -> PngFile {
        std::thread::sleep(Duration::from_millis(400));
        self.key(server, "s");
        self.screenshots += 1;
        let name = format!("shisen-out/window-{:06}.png", self.screenshots);
        let path = self.folder.path().join(name);
        until(|| path.is_file().then_some(()));
        PngFile::open(path)
    }

    /// Takes screenshots until one shows what it should, and returns that.
    fn shows(&mut self, server: &Server, is: impl Fn(&PngFile) -> bool) -> PngFile {
        until(|| Some(self.screenshot(server)).filter(&is))
    }

    /// Waits for the run's end; returns its output and its report.
    fn finish(self) -> (Output, Value) {
        let pid = self.child.id().to_string();
        let watchdog = std::thread::spawn(move || self.child.wait_with_output());
        let last = Instant::now() + PATIENCE;
        while !watchdog.is_finished() {
            if Instant::now() > last {
                let _ = Command::new("kill").args(["-9", &pid]).status();
                panic!("it does not end");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = watchdog.join().expect("a thread").expect("its output");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let report = serde_json::from_slice(&output.stdout).expect("an object");
        (output, report)
    }
}

pub(super) fn until<T>(mut is_there: impl FnMut() -> Option<T>) -> T {
    let last = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = is_there() {
            return found;
        }
        assert!(Instant::now() < last, "it does not come");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn colours(picture: &PngFile) -> usize {
    let colours: std::collections::BTreeSet<_> = picture.rgb().into_iter().collect();
    colours.len()
}

/// Counts the walls' yellow pixels: the colour of full detail.
fn yellow(picture: &PngFile) -> usize {
    let pixels = picture.rgb();
    let row = picture.width as usize;
    let is_yellow = |&&[red, green, blue]: &&[u8; 3]| {
        red > 150 && green > 150 && u16::from(blue) + 40 < u16::from(green)
    };
    let walls = pixels[20 * row..600 * row].iter();
    walls.filter(is_yellow).count()
}

/// Returns whether the middle of the gaze's cross is at a place, give or take a block or two.
fn is_marked(picture: &PngFile, x: u32, y: u32) -> bool {
    let pixels = picture.rgb();
    let white = |x: u32, y: u32| pixels[(y * picture.width + x) as usize] == [255; 3];
    let crosses = |x: u32, y: u32| (x - 10..=x + 10).all(|x| white(x, y));
    (y - 6..=y + 6).any(|y| (x - 6..=x + 6).any(|x| crosses(x, y)))
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb and xdotool"]
fn keys_change_what_is_seen_and_a_closed_window_ends_only_the_showing() {
    let server = Server::start();
    let mut run = Run::start(&server, &["--seconds", "40", "--threads", "1"]);
    let plain = run.screenshot(&server);
    assert_eq!((plain.width, plain.height), (960, 720));
    run.key(&server, "h");
    assert!(yellow(&plain) < 2_000);
    run.shows(&server, |picture| yellow(picture) > 20_000);
    run.key(&server, "h");
    run.key(&server, "m");
    // On the front wall, away from its middle.
    server.xdotool(&["mousemove", "--window", &run.window, "400", "200"]);
    run.shows(&server, |picture| is_marked(picture, 400, 200));
    run.key(&server, "v");
    run.shows(&server, |viewer| {
        let both = viewer.rgb().into_iter().zip(plain.rgb());
        both.filter(|(a, b)| a != b).count() > 100_000
    });
    run.key(&server, "f");
    // Each of these keys changes the scene or its detail, and so begins another run of frames.
    run.key(&server, "b");
    run.screenshot(&server);
    run.key(&server, "l");
    run.screenshot(&server);
    server.xdotool(&["windowclose", &run.window]);
    let (_, report) = run.finish();
    assert_eq!(report["scene"], "B");
    assert_eq!(report["lod"], "paper-ellipse");
    assert!(report["earlier_frames"].as_u64() > Some(30), "{report}");
    assert!(report["frames"].as_u64() > Some(30), "{report}");
    assert_eq!(report["window"]["is_open"], false);
    assert!(report["window"]["shown"].as_u64() > Some(4), "{report}");
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb and xdotool"]
fn a_run_without_an_end_of_its_own_ends_with_its_window() {
    let server = Server::start();
    let run = Run::start(&server, &[]);
    server.xdotool(&["windowclose", &run.window]);
    let (_, report) = run.finish();
    assert_eq!(report["window"]["is_open"], false);
    let run = Run::start(&server, &[]);
    run.key(&server, "q");
    let (_, report) = run.finish();
    assert_eq!(report["window"]["is_open"], true);
    assert!(report["frames"].as_u64() > Some(0), "{report}");
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb and xdotool"]
fn frames_outlive_the_window_system() {
    let server = Server::start();
    let run = Run::start(&server, &["--seconds", "10"]);
    server.signal("-KILL");
    let killed = Instant::now();
    let (output, report) = run.finish();
    assert!(
        killed.elapsed() > Duration::from_secs(1),
        "it ended at once"
    );
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("the window system has gone"), "{said}");
    assert!(said.contains("frames go on without a window"), "{said}");
    assert!(report["frames"].as_u64() > Some(60), "{report}");
    assert_eq!(report["window"]["is_open"], false);
}

#[test]
#[ignore = "tests/window/run runs it: it needs Xvfb and xdotool"]
fn a_window_system_that_hangs_holds_nothing_up() {
    let server = Server::start();
    let run = Run::start(&server, &["--seconds", "6"]);
    server.signal("-STOP");
    let (_, report) = run.finish();
    server.signal("-CONT");
    let frames = report["frames"].as_u64().expect("frames");
    let window = &report["window"];
    let [shown, dropped] = ["shown", "dropped"].map(|key| window[key].as_u64().expect("a count"));
    // The last frame handed over may be neither shown nor dropped.
    assert!(frames > 60 && shown + dropped + 1 >= frames, "{report}");
    assert!(dropped > frames / 3, "{report}");
}

#[test]
fn without_a_window_system_there_is_a_way_out() {
    let folder = tempfile::tempdir().expect("a folder");
    for (display, expected) in [
        (None, "DISPLAY is not set"),
        (Some(":47111"), "cannot be reached"),
    ] {
        let mut command = line(
            folder.path(),
            "run --view window --size 8 --lod off --frames 2",
        );
        command.env_remove("DISPLAY");
        command.envs(display.map(|display| ("DISPLAY", display)));
        let said = refusal(&mut command, 1);
        for expected in ["there is no window", "--view png", expected] {
            assert!(said.contains(expected), "{expected}: {said}");
        }
        assert!(!folder.path().join("shisen-out").exists());
    }
}
