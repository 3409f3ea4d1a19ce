//! The checks of `--backend kms`, on the kernel's virtual display: 1024 × 768 pixels at 60 Hz.

use super::{Result, SLOW};
use hidapi::HidApi;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The display's state for the kernel: `off` is unplugged, `detect` is plugged in.
const STATUS: &str = "/sys/class/drm/card0-Virtual-1/status";
const SECONDS: u64 = 8;

/// Returns the command that shows the pictures for some seconds.
fn show(seconds: u64, words: &str) -> Command {
    let words = format!("show /pictures --backend kms --seconds {seconds} --json {words}");
    let mut command = Command::new("/bin/shisen");
    command.args(words.split_whitespace());
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Returns what one output's report says, having checked that its refreshes are the display's.
fn report(output: &Output) -> Result<Value> {
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{said}");
    let mut report: Value = serde_json::from_slice(&output.stdout)?;
    let one = report["outputs"][0].take();
    println!("        {one}");
    let hz = one["hz"].as_f64().ok_or("no refreshes")?;
    ensure!((hz - 60.0).abs() < 0.1, "{hz} Hz; {said}");
    Ok(one)
}

fn count(report: &Value, key: &str) -> Result<u64> {
    Ok(report[key].as_u64().ok_or("no count")?)
}

pub fn presents_on_the_refresh(_: &mut HidApi) -> Result {
    let report = report(&show(SECONDS, "--outputs front=Virtual-1").output()?)?;
    let of = |key| count(&report, key);
    let (shown, late, repeated) = (of("shown")?, of("late")?, of("repeated")?);
    ensure!(shown + repeated > 58 * SECONDS, "{shown} + {repeated}");
    ensure!(100 * (late + repeated) <= shown, "{late} of {shown} late");
    ensure!(report["wrong_eyes"].is_null(), "{report}");
    Ok(())
}

/// Checks that eyes keep their turns, and that a program that is stopped for three refreshes
/// counts those that showed the wrong one.
pub fn alternates_eyes(_: &mut HidApi) -> Result {
    let words = "--outputs front=Virtual-1 --stereo sequential";
    let wrong = |report: &Value| count(report, "wrong_eyes");
    let begun = Instant::now();
    let report_of = report(&show(SECONDS, words).output()?)?;
    ensure!(100 * wrong(&report_of)? <= 60 * SECONDS, "{report_of}");
    let middle = begun.elapsed() - Duration::from_secs(SECONDS / 2);
    let child = show(SECONDS, words).spawn()?;
    thread::sleep(middle);
    for signal in ["-STOP", "-CONT"] {
        let mut kill = Command::new("/bin/busybox");
        kill.args(["kill", signal, &child.id().to_string()]);
        ensure!(kill.status()?.success(), "no kill {signal}");
        thread::sleep(Duration::from_millis(50));
    }
    let report_of = report(&child.wait_with_output()?)?;
    ensure!((1..=12).contains(&wrong(&report_of)?), "{report_of}");
    Ok(())
}

pub fn names_the_connectors(_: &mut HidApi) -> Result {
    for (words, expected) in [
        (
            "--outputs front=HDMI-A-1",
            "there are Virtual-1 (1024 × 768)",
        ),
        (
            "--outputs front=Virtual-1 --window managed",
            "there are no windows",
        ),
    ] {
        let output = show(1, words).output()?;
        let said = String::from_utf8(output.stderr)?;
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        ensure!(!output.status.success(), "{words} is shown");
        ensure!(said.contains(expected), "no {expected} in {said}");
    }
    Ok(())
}

/// Waits for a line of a program with these words.
fn wait_for(lines: &mut impl Iterator<Item = std::io::Result<String>>, words: &str) -> Result {
    for line in lines {
        if line?.contains(words) {
            return Ok(());
        }
    }
    Err(format!("it does not say \"{words}\"").into())
}

pub fn survives_unplugging(_: &mut HidApi) -> Result {
    let mut child = show(SLOW.as_secs(), "--outputs front=Virtual-1").spawn()?;
    let files = format!("/proc/{}/fd", child.id());
    let is_open = || {
        let mut links = fs::read_dir(&files).into_iter().flatten();
        links.any(|link| {
            let file = link.and_then(|link| fs::read_link(link.path()));
            file.is_ok_and(|file| file.ends_with("card0"))
        })
    };
    while !is_open() {
        ensure!(child.try_wait()?.is_none(), "it ended");
        thread::sleep(Duration::from_millis(100));
    }
    let mut said = BufReader::new(child.stderr.take().ok_or("no errors")?).lines();
    let second = show(1, "--outputs front=Virtual-1").output()?;
    let refusal = String::from_utf8_lossy(&second.stderr);
    ensure!(refusal.contains("is in use by"), "{refusal}");
    fs::write(STATUS, "off")?;
    wait_for(&mut said, "Virtual-1 has gone")?;
    fs::write(STATUS, "detect")?;
    wait_for(&mut said, "Virtual-1 is back")?;
    let report = report(&child.wait_with_output()?)?;
    let missed = count(&report, "missed")?;
    ensure!(missed > 0, "no frame was missed");
    Ok(())
}
