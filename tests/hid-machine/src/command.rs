//! The checks of the `shisen` command.

use super::within;
use super::{
    PLACE_ALONE, Result, SLOW, another, eye_tracker, eye_tracker_that, mock, path, wait_for,
};
use hidapi::HidApi;
use shisen_tracker::hid::eye_tracker::documented;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;

/// Returns the command `shisen tracker` with these arguments.
fn shisen(arguments: &[&str]) -> Command {
    let mut command = Command::new("/bin/shisen");
    command.arg("tracker").args(arguments).stdin(Stdio::null());
    command
}

fn lines(from: impl Read + Send + 'static) -> Receiver<String> {
    let (to, lines) = mpsc::channel();
    thread::spawn(move || {
        for line in BufReader::new(from)
            .lines()
            .map_while(std::result::Result::ok)
        {
            if to.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// A running `shisen tracker monitor --json`, which ends when this is dropped.
struct Monitor {
    child: Child,
    out: Receiver<String>,
    err: Receiver<String>,
}

impl Monitor {
    fn new(spec: &str) -> Result<Self> {
        let mut child = shisen(&["monitor", spec, "--json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let out = lines(child.stdout.take().ok_or("no output")?);
        let err = lines(child.stderr.take().ok_or("no errors")?);
        Ok(Self { child, out, err })
    }

    /// Checks that its next line of errors has these words.
    fn says(&self, words: &str) -> Result {
        let line = self.err.recv_timeout(SLOW)?;
        ensure!(line.contains(words), "no \"{words}\" in {line}");
        Ok(())
    }
}

impl Drop for Monitor {
    fn drop(&mut self) {
        let _ = self.child.kill().and_then(|()| self.child.wait());
    }
}

/// Checks the features of the virtual eye tracker that the command lists.
const FEATURES: &str = "tracks from 0.500 to 0.900 m (best 0.650), screens up to 0.700 by 0.400 m, \
    quality 1; set up for 0.527 by 0.296 m of display 0x10ac:0xa0b1, serial number 123456; \
    status 1 (ready), 100 Hz";

pub fn lists_it(api: &mut HidApi) -> Result {
    let _device = eye_tracker("ET-1")?;
    let devices = wait_for(api, documented::USB_ID, 1)?;
    let output = shisen(&["list", "--json"]).output()?;
    let found = String::from_utf8(output.stdout)?;
    let (vendor, product) = documented::USB_ID;
    for expected in [
        format!("\"path\":\"{}\"", devices[0][0]),
        format!("\"id\":\"{vendor:04x}:{product:04x}\""),
        "\"tracker\":true".into(),
        "\"features\":{\"capabilities\":{\"quality\":1,\"nearest_m\":0.5,".into(),
        // The conversion to metres rounds the last bit.
        "\"screen_width_m\":0.52".into(),
        "\"status\":{\"code\":1,\"meaning\":\"ready\",\"rate_hz\":100.0},\"unread\":[],\"refused\":null}"
            .into(),
    ] {
        ensure!(found.contains(&expected), "no {expected} in {found}");
    }
    let told = shisen(&["list"]).output()?;
    let told = String::from_utf8(told.stdout)?;
    let features = format!("  {FEATURES}");
    ensure!(told.lines().any(|line| line == features), "{told}");
    Ok(())
}

/// Checks that the command names both devices and chooses neither.
pub fn asks_which_of_two(api: &mut HidApi) -> Result {
    let _both = [eye_tracker("ET-1")?, eye_tracker("ET-2")?];
    let devices = wait_for(api, documented::USB_ID, 2)?;
    for spec in [&by_id()[..], "hid:usage=0012"] {
        let output = shisen(&["monitor", spec]).output()?;
        let told = String::from_utf8(output.stderr)?;
        let code = output.status.code();
        ensure!(code == Some(1), "{code:?}: {told}");
        for [path, _, _] in &devices {
            ensure!(told.contains(path.as_str()), "no {path} in {told}");
        }
    }
    Ok(())
}

pub fn says_that_a_request_is_refused(api: &mut HidApi) -> Result {
    let _device = eye_tracker_that("ET-1", false)?;
    let monitor = Monitor::new(&format!("hid:{}", path(api, documented::USB_ID)?))?;
    loop {
        let line = monitor.err.recv_timeout(SLOW)?;
        if line.contains("refused the request") {
            return Ok(());
        }
    }
}

fn by_id() -> String {
    let (vendor, product) = documented::USB_ID;
    format!("hid:{vendor:04x}:{product:04x}")
}

pub fn follows_it(api: &mut HidApi) -> Result {
    follows(api, &by_id())
}

pub fn finds_it_by_its_usage(api: &mut HidApi) -> Result {
    follows(api, "hid:usage=0012")?;
    wait_for(api, documented::USB_ID, 0)?;
    follows(api, "hid:usage=0012:0001")
}

/// Checks that the descriptor is read again, since another device may be at the same path.
pub fn reads_another_descriptor(api: &mut HidApi) -> Result {
    let first = eye_tracker("ET-1")?;
    let at = path(api, documented::USB_ID)?;
    let monitor = Monitor::new(&format!("hid:{at}"))?;
    monitor.says("")?;
    monitor.says("")?;
    drop(first);
    monitor.says("is gone")?;
    let id = documented::USB_ID;
    wait_for(api, id, 0)?;
    let mut second = another("Head Tracker", id, &PLACE_ALONE, Vec::new())?;
    let again = path(api, id)?;
    ensure!(device_file(&again)? == device_file(&at)?, "{again}, {at}");
    monitor.says("is plugged in")?;
    monitor.says("nothing of itself")?;
    // 0.1, −0.2 and 0.3 m in millimetres.
    let mut report = vec![3];
    report.extend([100_i16, -200, 300].into_iter().flat_map(i16::to_le_bytes));
    second.send(&report)?;
    let line = monitor.out.recv_timeout(SLOW)?;
    // The conversion to metres rounds the last bit.
    let place = "\"head\":{\"position\":{\"value\":[0.0999999";
    ensure!(line.contains(place), "{line}");
    Ok(())
}

fn device_file(path: &str) -> Result<&str> {
    Ok(path.rsplit('/').next().ok_or("no name")?)
}

fn follows(api: &mut HidApi, spec: &str) -> Result {
    let records = mock("hid", 40)?;
    let mut device = eye_tracker("ET-1")?;
    wait_for(api, documented::USB_ID, 1)?;
    let monitor = Monitor::new(spec)?;
    for (round, records) in records.chunks(20).enumerate() {
        if round > 0 {
            drop(device);
            monitor.says("is gone")?;
            device = eye_tracker("ET-1")?;
        }
        monitor.says("is plugged in")?;
        monitor.says(FEATURES)?;
        // The command asks for all data, then reads.
        within(SLOW, || Ok(!device.seen().set.is_empty()))?;
        ensure!(device.seen().set == [vec![0x14, 7]], "another mode");
        for (_, report) in records {
            device.send(report)?;
        }
        for i in 0..20 {
            let line = monitor.out.recv_timeout(SLOW)?;
            let number = format!("{{\"number\":{},", 20 * round + i);
            ensure!(line.starts_with(&number), "{line}");
            ensure!(line.contains("\"head\":{\"position\":{"), "{line}");
            let first = line.contains("\"device\":{\"capabilities\":{\"quality\":1,");
            ensure!(first == (i == 0), "{line}");
        }
    }
    Ok(())
}
