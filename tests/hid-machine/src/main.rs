//! hidapi and the tracker driver against virtual devices of the Linux kernel:
//! an eye tracker of HID usage page 0x12, and an OSVR HDK; and a show on its virtual display.
//!
//! Prints a line for each check, and "N passed, N failed" at the end.

/// Fails a check, with the values.
macro_rules! ensure {
    ($condition:expr, $($why:tt)*) => {
        if $condition {
        } else {
            return Err(format!($($why)*).into());
        }
    };
}

mod command;
mod display;
mod uhid;

use hidapi::{HidApi, HidDevice};
use shisen_tracker::decoder::{Decoder, DropReason, Event, Message};
use shisen_tracker::head::osvr_hdk;
use shisen_tracker::hid::device;
use shisen_tracker::hid::eye_tracker::documented;
use shisen_tracker::hid::eye_tracker::{
    Axes, Capabilities, Configuration, EyeTracker, Mode, Status,
};
use shisen_tracker::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::{GazePoint, Sample};
use shisen_tracker::time::Micros;
use std::error::Error;
use std::thread;
use std::time::{Duration, Instant};
use uhid::{Description, Device};

type Result<T = ()> = std::result::Result<T, Box<dyn Error>>;

/// The machine is emulated: a process takes a while to start.
const SLOW: Duration = Duration::from_secs(20);
/// Longest wait for the kernel, milliseconds; it takes a few.
const PATIENCE: i32 = 2_000;
/// 16 bytes of the maker's own, without report ids, as the OSVR HDK sends them.
const HDK_DESCRIPTOR: [u8; 20] = [
    0x06, 0x00, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0x15, 0x80, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x10, 0x09,
    0x01, 0x81, 0x02, 0xC0,
];

/// A head tracker of usage page 0x12 that sends its place, in millimetres, as report 3.
const PLACE_ALONE: [u8; 41] = [
    0x05, 0x12, 0x09, 0x02, 0xA1, 0x01, // head tracker
    0x85, 0x03, 0x09, 0x10, 0xA1, 0x00, // tracking data
    0x09, 0x27, 0xA1, 0x00, // head position
    0x16, 0x00, 0x80, 0x26, 0xFF, 0x7F, // ±32,767
    0x65, 0x11, 0x55, 0x0F, // 10⁻¹ cm
    0x75, 0x10, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x02, // x, y, z
    0xC0, 0xC0, 0xC0, // ends
];

/// An eye tracker of usage page 0x12 without report ids: its head's place, as above, is the
/// one input report; how it is, how often it samples, and its control are the one feature
/// report.
const WITHOUT_IDS: [u8; 85] = [
    0x05, 0x12, 0x09, 0x01, 0xA1, 0x01, // eye tracker
    0x09, 0x10, 0xA1, 0x00, // tracking data
    0x09, 0x27, 0xA1, 0x00, // head position
    0x16, 0x00, 0x80, 0x26, 0xFF, 0x7F, // ±32,767
    0x65, 0x11, 0x55, 0x0F, // 10⁻¹ cm
    0x75, 0x10, 0x95, 0x03, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x02, // x, y, z
    0xC0, 0xC0, // ends
    0x09, 0x13, 0xA1, 0x02, // status
    0x65, 0x00, 0x55, 0x00, 0x15, 0x00, 0x25, 0x04, // no unit, 0 to 4
    0x75, 0x08, 0x95, 0x01, 0x0A, 0x01, 0x03, 0xB1, 0x02, // how it is
    0x66, 0x01, 0xF0, 0x25, 0x7F, 0x0A, 0x00, 0x03, 0xB1, 0x02, // samples per second
    0xC0, 0x09, 0x14, 0xA1, 0x02, // ends; control
    0x65, 0x00, 0x25, 0x07, 0x0A, 0x00, 0x04, 0xB1, 0x02, // what it is to send
    0xC0, 0xC0, // ends
];

const ABILITIES: Capabilities = Capabilities {
    quality: Some(1),
    nearest: Some(0.5),
    best: Some(0.65),
    furthest: Some(0.9),
    widest_screen: Some(0.7),
    highest_screen: Some(0.4),
};
const SET_UP: Configuration = Configuration {
    manufacturer: Some(0x10AC),
    product: Some(0xA0B1),
    serial_number: Some(123_456),
    manufacturer_date: Some(0x1E20),
    screen_width: Some(0.527),
    screen_height: Some(0.296),
};
const READY: Status = Status {
    configuration: Some(1),
    sampling_frequency: Some(100.0),
};

fn eye_tracker(serial: &str) -> Result<Device> {
    eye_tracker_that(serial, true)
}

/// Returns one that takes requests, or not.
fn eye_tracker_that(serial: &str, settable: bool) -> Result<Device> {
    let features = vec![
        (0x11, documented::capabilities(&ABILITIES).to_vec()),
        (0x12, documented::configuration(&SET_UP).to_vec()),
        (0x13, documented::status(&READY).to_vec()),
    ];
    Ok(Device::new(&Description {
        name: "Virtual Eye Tracker",
        serial,
        id: documented::USB_ID,
        descriptor: &documented::DESCRIPTOR,
        features,
        settable,
    })?)
}

/// Returns a device that takes requests, with these feature reports.
fn another(
    name: &str,
    id: (u16, u16),
    descriptor: &[u8],
    features: Vec<(u8, Vec<u8>)>,
) -> Result<Device> {
    Ok(Device::new(&Description {
        name,
        serial: "1",
        id,
        descriptor,
        features,
        settable: true,
    })?)
}

/// Path, product and serial number of each device with this id. hidapi lists a
/// device once for each of its collections.
fn listed(api: &mut HidApi, id: (u16, u16)) -> Result<Vec<[String; 3]>> {
    api.refresh_devices()?;
    let mut devices: Vec<_> = api
        .device_list()
        .filter(|device| (device.vendor_id(), device.product_id()) == id)
        .map(|device| {
            [
                device.path().to_string_lossy().into_owned(),
                device.product_string().unwrap_or_default().to_owned(),
                device.serial_number().unwrap_or_default().to_owned(),
            ]
        })
        .collect();
    devices.sort();
    devices.dedup();
    Ok(devices)
}

fn wait_for(api: &mut HidApi, id: (u16, u16), count: usize) -> Result<Vec<[String; 3]>> {
    let mut devices = Vec::new();
    within(Duration::from_millis(PATIENCE as u64), || {
        devices = listed(api, id)?;
        Ok(devices.len() == count)
    })?;
    Ok(devices)
}

fn within(time: Duration, mut so: impl FnMut() -> Result<bool>) -> Result {
    let start = Instant::now();
    while !so()? {
        ensure!(start.elapsed() < time, "nothing came of it in {time:?}");
        thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn path(api: &mut HidApi, id: (u16, u16)) -> Result<String> {
    let [device] = &wait_for(api, id, 1)?[..] else {
        return Err("more than one device".into());
    };
    Ok(device[0].clone())
}

fn open(api: &HidApi, path: &str) -> Result<HidDevice> {
    Ok(api.open_path(&std::ffi::CString::new(path)?)?)
}

/// Returns an eye tracker, its handle, and what decodes its reports.
fn plugged(api: &mut HidApi) -> Result<(Device, HidDevice, EyeTracker)> {
    let device = eye_tracker("ET-1")?;
    let path = path(api, documented::USB_ID)?;
    let opened = open(api, &path)?;
    let tracker = EyeTracker::new(&descriptor(&opened)?, Axes::default())?;
    Ok((device, opened, tracker))
}

fn descriptor(device: &HidDevice) -> Result<Vec<u8>> {
    let mut bytes = vec![0; 4096];
    let length = device.get_report_descriptor(&mut bytes)?;
    bytes.truncate(length);
    Ok(bytes)
}

fn feature(device: &HidDevice, id: u8) -> Result<Vec<u8>> {
    let mut bytes = vec![0; 256];
    bytes[0] = id;
    let length = device.get_feature_report(&mut bytes)?;
    bytes.truncate(length);
    Ok(bytes)
}

/// Sends a report and feeds what the host reads of it.
fn pass(
    from: &mut Device,
    report: &[u8],
    to: &HidDevice,
    decoder: &mut impl Decoder,
    arrival: Micros,
) -> Result<Event> {
    from.send(report)?;
    let mut bytes = [0; 256];
    let length = to.read_timeout(&mut bytes, PATIENCE)?;
    ensure!(
        length == report.len(),
        "read {length} of {} bytes",
        report.len()
    );
    let mut events = Vec::new();
    decoder.feed(&bytes[..length], arrival, &mut |event| events.push(event));
    ensure!(events.len() == 1, "{events:?}");
    Ok(events[0])
}

fn sample(event: Event) -> Result<Sample> {
    match event {
        Event::Sample(sample) => Ok(sample),
        other => Err(format!("{other:?}").into()),
    }
}

/// Returns samples of the simulated tracker, and their reports.
fn mock(protocol: &str, count: usize) -> Result<Vec<(Sample, Vec<u8>)>> {
    let viewer = Viewer::new(ViewerConfig::default(), 5);
    let mut tracker = Tracker::new(TrackerConfig::default(), viewer, 5)?;
    let protocol = Protocol::named(protocol).ok_or("the mock does not know the protocol")?;
    let mut wire = Wire::new(tracker.clone(), protocol);
    let samples = (0..count).map(|_| {
        let (_, sample) = tracker.next_sample();
        let chunk = wire.encode(&sample).ok_or("no report of a sample")?;
        Ok((sample, chunk.bytes().to_vec()))
    });
    samples.collect()
}

fn lists_and_opens(api: &mut HidApi) -> Result {
    let device = eye_tracker("ET-1")?;
    let devices = wait_for(api, documented::USB_ID, 1)?;
    let [path, product, serial] = &devices[0];
    let named = product == "Virtual Eye Tracker" && serial == "ET-1";
    ensure!(named, "{devices:?}");
    let has_page =
        |device: &&hidapi::DeviceInfo| (device.usage_page(), device.usage()) == (0x12, 1);
    let found = api.device_list().find(has_page);
    let found = found.ok_or("no device of usage page 0x12")?;
    ensure!(found.path().to_str()? == path, "{found:?}");
    let opened = open(api, path)?;
    let bytes = descriptor(&opened)?;
    ensure!(bytes == documented::DESCRIPTOR, "descriptor {bytes:02x?}");
    let tracker = EyeTracker::new(&bytes, Axes::default())?;
    ensure!(tracker.report_id() == 0x10, "id {}", tracker.report_id());
    drop(opened);
    let seen = device.seen();
    ensure!(seen.opened == 1, "opened {} times", seen.opened);
    Ok(())
}

fn reads_features(api: &mut HidApi) -> Result {
    let (_device, opened, tracker) = plugged(api)?;
    let reports = tracker
        .feature_reports()
        .map(|report| report.map(|(id, _)| id));
    ensure!(reports == [0x11, 0x12, 0x13, 0x14].map(Some), "{reports:?}");
    let capabilities = tracker.capabilities(&feature(&opened, 0x11)?)?;
    // As bytes: in metres the last bit is rounded.
    let same = documented::capabilities(&capabilities) == documented::capabilities(&ABILITIES);
    ensure!(same, "{capabilities:?}");
    let configuration = tracker.configuration(&feature(&opened, 0x12)?)?;
    let same = documented::configuration(&configuration) == documented::configuration(&SET_UP);
    ensure!(same, "{configuration:?}");
    let status = tracker.status(&feature(&opened, 0x13)?)?;
    ensure!(status == READY, "{status:?}");
    // What the device refuses is an error, and soon.
    let refused = feature(&opened, 0x14);
    ensure!(refused.is_err(), "{refused:?}");
    Ok(())
}

/// Where there are no ids, the system has a 0 before every report that it is asked for or
/// told to set, and the device's driver may hand one back or not.
fn features_without_ids(api: &mut HidApi) -> Result {
    for answer in [&[0, 1, 100, 0][..], &[1, 100, 0]] {
        let features = vec![(0, answer.to_vec())];
        let id = documented::USB_ID;
        let mut device = another("Eye Tracker without ids", id, &WITHOUT_IDS, features)?;
        let mut opened = device::Device::open(&path(api, id)?)?;
        let mut tracker = EyeTracker::new(&opened.descriptor()?, Axes::default())?;
        let reports = tracker.feature_reports();
        let expected = [None, None, Some((0, 3)), Some((0, 3))];
        ensure!(reports == expected, "{reports:?}");
        let report = opened.feature(0, 3)?;
        ensure!(report == [1, 100, 0], "{report:?} of {answer:?}");
        let status = tracker.status(&report)?;
        ensure!(status == READY, "{status:?}");
        let request = tracker.mode_request(Mode::ALL).ok_or("no control report")?;
        opened.set_feature(0, &request)?;
        let set = device.seen().set;
        ensure!(set == [[0, 0, 0, 7]], "{set:02x?}");
        // And an input report, all of which is data.
        device.send(&[100, 0, 200, 0, 0x2C, 0x01])?;
        let mut bytes = [0; 64];
        let mut length = 0;
        within(SLOW, || {
            length = opened.read(&mut bytes)?;
            Ok(length > 0)
        })?;
        let mut place = None;
        tracker.feed(&bytes[..length], Micros(1), &mut |event| {
            if let Event::Sample(sample) = event {
                place = sample.head.position.map(|place| place.value.to_array());
            }
        });
        let off = place.map(|[x, y, z]| (x - 0.1).abs() + (y - 0.2).abs() + (z - 0.3).abs());
        ensure!(off.is_some_and(|off| off < 1e-6), "{place:?}");
        drop(opened);
        drop(device);
        wait_for(api, documented::USB_ID, 0)?;
    }
    Ok(())
}

fn asks_for_a_mode(api: &mut HidApi) -> Result {
    let (device, opened, tracker) = plugged(api)?;
    for mode in [Mode::ALL, Mode::STOP] {
        let request = tracker.mode_request(mode).ok_or("no control report")?;
        opened.send_feature_report(&request)?;
    }
    let set = device.seen().set;
    ensure!(set == [vec![0x14, 7], vec![0x14, 0]], "{set:02x?}");
    Ok(())
}

fn decodes_tracking_data(api: &mut HidApi) -> Result {
    let (mut device, opened, mut tracker) = plugged(api)?;
    let (mut gazes, records) = (0, mock("hid", 500)?);
    for (sent, report) in &records {
        let event = pass(&mut device, report, &opened, &mut tracker, sent.arrival)?;
        let found = sample(event)?;
        ensure!(found.device_time == sent.device_time, "{found:?}");
        let place = |sample: &Sample| sample.head.position.map(|place| place.value);
        let (there, here) = (place(sent), place(&found));
        let off = there.zip(here).map(|(there, here)| there.distance(here));
        ensure!(
            off.is_some_and(|off| off < 2e-6),
            "{here:?}, sent {there:?}"
        );
        // Lost eyes have no point; what is seen has one.
        let seen = sent.left.direction.is_some();
        gazes += usize::from(found.gaze_point.is_some());
        ensure!(seen || found.gaze_point.is_none(), "{found:?}");
    }
    ensure!(gazes > 300, "{gazes} gaze points");
    // By hand: 0.123456 m to the right, 0.0987 m down; no eyes, no head.
    let mut report = vec![0x10];
    report.extend(5_000_000_u64.to_le_bytes());
    report.extend([123_456, 98_700].into_iter().flat_map(i32::to_le_bytes));
    report.extend([i32::MAX; 12].into_iter().flat_map(i32::to_le_bytes));
    let event = pass(&mut device, &report, &opened, &mut tracker, Micros(1))?;
    let found = sample(event)?;
    let Some(GazePoint::Plane(point)) = found.gaze_point.map(|point| point.value) else {
        return Err(format!("{found:?}").into());
    };
    ensure!((point.x - 0.123_456).abs() < 1e-7, "{point:?}");
    ensure!((point.y - 0.098_7).abs() < 1e-7, "{point:?}");
    let nothing = found.left.is_empty() && found.head.position.is_none();
    ensure!(nothing, "{found:?}");
    // A status in between.
    let report = documented::status(&Status {
        configuration: Some(4),
        ..READY
    });
    let event = pass(&mut device, &report, &opened, &mut tracker, Micros(1))?;
    let calibrate = matches!(event, Event::Message(Message::State { code: 4, .. }));
    ensure!(calibrate, "{event:?}");
    ensure!(tracker.counts().samples == 501, "{:?}", tracker.counts());
    Ok(())
}

fn survives_replugging(api: &mut HidApi) -> Result {
    let records = mock("hid", 2)?;
    let (mut device, opened, mut tracker) = plugged(api)?;
    pass(&mut device, &records[0].1, &opened, &mut tracker, Micros(1))?;
    // Out while the host waits.
    let waiting = thread::spawn(move || {
        let read = opened.read_timeout(&mut [0; 256], PATIENCE);
        (opened, read)
    });
    thread::sleep(Duration::from_millis(20));
    drop(device);
    let (opened, read) = waiting.join().map_err(|_| "the reader panicked")?;
    ensure!(read.is_err(), "a read of what is gone gave {read:?}");
    let sent = opened.send_feature_report(&[0x14, 7]);
    ensure!(sent.is_err(), "a write to what is gone went well");
    wait_for(api, documented::USB_ID, 0)?;
    // In again, while the old handle is still there.
    let (mut device, again, _) = plugged(api)?;
    tracker.reset();
    let event = pass(&mut device, &records[1].1, &again, &mut tracker, Micros(2))?;
    ensure!(matches!(event, Event::Sample(_)), "{event:?}");
    ensure!(tracker.counts().samples == 2, "{:?}", tracker.counts());
    Ok(())
}

fn tells_two_apart(api: &mut HidApi) -> Result {
    let _both = [eye_tracker("ET-1")?, eye_tracker("ET-2")?];
    let devices = wait_for(api, documented::USB_ID, 2)?;
    let serials: Vec<&str> = devices.iter().map(|[_, _, serial]| &serial[..]).collect();
    let both = serials.contains(&"ET-1") && serials.contains(&"ET-2");
    ensure!(both, "{devices:?}");
    ensure!(devices[0][0] != devices[1][0], "{devices:?}");
    Ok(())
}

fn decodes_a_head_tracker(api: &mut HidApi) -> Result {
    let id = osvr_hdk::USB_IDS[0];
    let mut device = another("OSVR HDK", id, &HDK_DESCRIPTOR, Vec::new())?;
    let path = path(api, id)?;
    let opened = open(api, &path)?;
    let mut decoder = osvr_hdk::OsvrHdk::new();
    for (sent, report) in mock("osvr-hdk", 400)? {
        let event = pass(&mut device, &report, &opened, &mut decoder, sent.arrival)?;
        let found = sample(event)?;
        let turn = |sample: &Sample| sample.head.orientation.map(|turn| turn.value);
        let pair = turn(&sent).zip(turn(&found));
        // 14 bits, and either sign.
        let off = pair.map(|(a, b)| (a - b).length().min((a + b).length()));
        ensure!(
            off.is_some_and(|off| off < 2e-4),
            "{found:?}, sent {sent:?}"
        );
    }
    // Two are missing, and one comes twice.
    let mut report = [0; 16];
    (report[0], report[1], report[9]) = (1, 146_u8, 0x40);
    pass(&mut device, &report, &opened, &mut decoder, Micros(1))?;
    pass(&mut device, &report, &opened, &mut decoder, Micros(1))?;
    let counts = decoder.counts();
    ensure!(counts.samples == 401 && counts.lost == 2, "{counts:?}");
    let twice = counts.dropped_for(DropReason::Duplicate);
    ensure!(twice == 1, "{counts:?}");
    Ok(())
}

macro_rules! checks {
    ($($name:literal => $check:path,)*) => {
        [$(($name, $check as fn(&mut HidApi) -> Result)),*]
    };
}

fn main() -> Result {
    let mut api = HidApi::new()?;
    let checks = checks! {
        "an eye tracker is listed, opened and described" => lists_and_opens,
        "its features are read" => reads_features,
        "its mode is set" => asks_for_a_mode,
        "features without report ids are read and set" => features_without_ids,
        "its tracking data are decoded" => decodes_tracking_data,
        "it is unplugged and plugged in again" => survives_replugging,
        "two of them are told apart" => tells_two_apart,
        "an OSVR HDK's reports are decoded" => decodes_a_head_tracker,
        "the command lists it" => command::lists_it,
        "the command asks which of two is meant" => command::asks_which_of_two,
        "the command says that a request is refused" => command::says_that_a_request_is_refused,
        "the command follows it, unplugged and plugged in again" => command::follows_it,
        "the command finds it by its usage page" => command::finds_it_by_its_usage,
        "the command reads the descriptor of another at the same path" =>
            command::reads_another_descriptor,
        "a display without a desktop shows frames on its refresh" =>
            display::presents_on_the_refresh,
        "it shows the eyes by turns" => display::alternates_eyes,
        "a connector that is not there is told, with those that are" =>
            display::names_the_connectors,
        "a display is in use, unplugged and plugged in again" => display::survives_unplugging,
    };
    let mut failed = 0;
    for (name, check) in checks {
        // Devices of the check before go away.
        wait_for(&mut api, documented::USB_ID, 0)?;
        let start = Instant::now();
        match check(&mut api) {
            Ok(()) => println!("ok      {name} ({} ms)", start.elapsed().as_millis()),
            Err(error) => {
                failed += 1;
                println!("FAILED  {name}: {error}");
            }
        }
    }
    println!("{} passed, {failed} failed", checks.len() - failed);
    Ok(())
}
