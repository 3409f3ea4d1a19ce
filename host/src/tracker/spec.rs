//! `SPEC`: which tracker, in one word of a command line.

use super::net::{self, NetSpec};
use super::protocol::ProtocolSpec;
use super::settings::{Options, set_axes, wrong};
use super::times::{TIMES, Times};
use crate::files::Fault;
use shisen_tracker::clock::ClockConfig;
use shisen_tracker::command::Script;
use shisen_tracker::head::fastrak::BAUD_RATES;
use shisen_tracker::hid::eye_tracker::Axes;
use shisen_tracker::mock::TrackerConfig;
use shisen_tracker::protocol::{Asked, Protocol};
use shisen_tracker::time::Micros;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Which tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// The tracker.
    pub kind: TrackerKind,
    /// The sensor on the viewer's head; `None`: the first that sends.
    pub head: Option<u8>,
    /// How late the tracker is, and after how long its data are stale or stuck.
    pub times: Times,
    /// A file of `shisen tracker calibrate`.
    pub calibration: Option<PathBuf>,
}

/// A kind of tracker.
#[derive(Debug, Clone, PartialEq)]
pub enum TrackerKind {
    /// `mock`, `mock:seed=7&rate=200&as=fastrak`.
    Mock(MockSpec),
    /// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200&reset=1&units=cm`.
    Serial(SerialSpec),
    /// `hid:1532:0b00`, `hid:usage=0012`, `hid:/dev/hidraw0?origin=0,0.3,-0.5`.
    Hid(HidSpec),
    /// `replay:FILE`, `replay:FILE?head=2`: a file that `shisen tracker record` wrote.
    Replay(PathBuf),
    /// `vrpn:Tracker0@host`, `lsl:type=Gaze`, `dtrack:5000` and others: on the network.
    Net(NetSpec),
}

impl From<TrackerKind> for Spec {
    /// Returns the first sensor, and the usual times.
    fn from(kind: TrackerKind) -> Self {
        Self {
            kind,
            head: None,
            times: Times::default(),
            calibration: None,
        }
    }
}

impl Spec {
    /// Returns how to read the tracker's clock, by the mock's delay or the specification's.
    pub fn clock(&self) -> ClockConfig {
        let usual = match &self.kind {
            TrackerKind::Mock(mock) => mock.delay,
            _ => Micros(0),
        };
        ClockConfig {
            least_delay: self.times.delay.unwrap_or(usual),
            ..ClockConfig::default()
        }
    }

    /// Returns the protocol; `None` where the specification does not name it.
    pub(super) const fn protocol(&self) -> Option<&ProtocolSpec> {
        match &self.kind {
            TrackerKind::Mock(mock) => mock.protocol.as_ref(),
            TrackerKind::Serial(serial) => Some(&serial.protocol),
            TrackerKind::Hid(_) | TrackerKind::Replay(_) | TrackerKind::Net(_) => None,
        }
    }
}

/// A simulated viewer and tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct MockSpec {
    /// The seed of all movements and all noise.
    pub seed: u64,
    /// Samples per second: 60 to 10,000.
    pub rate: u32,
    /// The protocol that the samples pass through; `None` hands them on unchanged.
    pub protocol: Option<ProtocolSpec>,
    /// Whether the head is held still, as by a chin rest.
    pub still: bool,
    /// A table of targets: `start_s,end_s,x,y,z`.
    pub targets: Option<PathBuf>,
    /// The time from a sample's measurement to its arrival.
    pub delay: Micros,
}

impl Default for MockSpec {
    /// Seed 1, 500 Hz, no protocol, looking around.
    fn default() -> Self {
        Self {
            seed: 1,
            rate: 500,
            protocol: None,
            still: false,
            targets: None,
            delay: TrackerConfig::default().latency,
        }
    }
}

/// A tracker on a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialSpec {
    /// The port.
    pub path: String,
    /// The device's protocol.
    pub protocol: ProtocolSpec,
    /// The line's speed, baud.
    pub baud: u32,
    /// Whether the device is reset first, which can take 20 s.
    pub reset: bool,
    /// The speed to which both ends change once the line is open, baud.
    pub speed: Option<u32>,
    /// Whether the device is told to stop at the end.
    pub stop: bool,
    /// Whether the line's RTS is high; `None`: as the protocol has it.
    pub rts: Option<bool>,
}

/// A human interface device.
#[derive(Debug, Clone, PartialEq)]
pub struct HidSpec {
    /// Which device.
    pub name: HidName,
    /// The axes of an eye tracker, which its descriptor does not say.
    pub axes: Axes,
}

/// Which human interface device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HidName {
    /// By USB vendor and product.
    Id(u16, u16),
    /// By its path.
    Path(String),
    /// By a usage of one of its collections; page 0x12 is eye and head trackers.
    Usage {
        /// The page.
        page: u16,
        /// The usage; `None`: any of the page.
        usage: Option<u16>,
    },
}

impl fmt::Display for HidName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(vendor, product) => write!(f, "{vendor:04x}:{product:04x}"),
            Self::Path(path) => f.write_str(path),
            Self::Usage { page, usage: None } => write!(f, "usage={page:04x}"),
            Self::Usage {
                page,
                usage: Some(usage),
            } => write!(f, "usage={page:04x}:{usage:04x}"),
        }
    }
}

impl FromStr for Spec {
    type Err = Fault;

    fn from_str(text: &str) -> Result<Self, Fault> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let split = match name {
            "mock" => Some((name, rest)),
            "serial" | "hid" => rest.split_once('?'),
            // A file's name may hold a `?`, but options have a `=` behind it.
            "replay" => rest.rsplit_once('?').filter(|split| split.1.contains('=')),
            // The name of a stream may go on with its settings.
            "lsl" => lsl(rest),
            name if net::KINDS.contains(&name) => rest.split_once('?'),
            _ => {
                return Err(Fault::new(
                    format!("{name:?} is not a kind of tracker"),
                    "give mock, mock:seed=7&rate=200&as=fastrak, \
                     serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:usage=0012, \
                     vrpn:Tracker0@HOST, lsl:type=Gaze, dtrack:5000, natnet:HOST, \
                     udp:4242?protocol=opentrack, tcp:HOST:PORT, stdin: or replay:FILE",
                ));
            }
        };
        let (target, rest) = split.unwrap_or((rest, ""));
        if target.is_empty() && name != "stdin" {
            return Err(Fault::new(
                format!("{name}: names no port, device or file"),
                "give serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:/dev/hidraw0, \
                 vrpn:Tracker0@HOST, lsl:type=Gaze, dtrack:5000, natnet:HOST or replay:FILE",
            ));
        }
        let mut options = Options::read(rest)?;
        let mut head = None;
        options.number(&mut head, "head", (0, u8::MAX), "a sensor from 0 to 255")?;
        let times = Times::take(&mut options)?;
        let mut calibration = None;
        options.set(
            &mut calibration,
            "calibration",
            "the path of a calibration",
            |value| (!value.is_empty()).then(|| PathBuf::from(value)),
        )?;
        let kind = match name {
            "mock" => TrackerKind::Mock(mock(options, head, &times)?),
            "serial" => TrackerKind::Serial(serial(target, options, head)?),
            "hid" => TrackerKind::Hid(hid(target, options, head)?),
            name if net::KINDS.contains(&name) => {
                let spec = NetSpec::read(name, target, &mut options, &mut head)?;
                if let Some(head) = head.filter(|_| !spec.has_sensors()) {
                    return Err(lone_sensor(spec.kind(), head));
                }
                options.end(spec.kind(), &with_times(spec.options()), None)?;
                TrackerKind::Net(spec)
            }
            _ => {
                options.end("replay", &with_times("head=N"), None)?;
                TrackerKind::Replay(target.into())
            }
        };
        Ok(Self {
            kind,
            head,
            times,
            calibration,
        })
    }
}

/// Splits a stream's `type=` and `name=` from its settings.
fn lsl(text: &str) -> Option<(&str, &str)> {
    let is_setting = |part: &str| !(part.starts_with("type=") || part.starts_with("name="));
    let mut at = 0;
    while let Some(end) = text[at..].find(['?', '&']).map(|end| at + end) {
        at = end + 1;
        if text.as_bytes()[end] == b'?' || is_setting(&text[at..]) {
            return Some((&text[..end], &text[at..]));
        }
    }
    None
}

/// Returns the names of the protocols for which `has` holds.
fn names(has: fn(&Protocol) -> bool) -> String {
    let named = Protocol::NAMES.into_iter();
    let named = named.filter(|name| Protocol::named(name).is_some_and(|protocol| has(&protocol)));
    named.collect::<Vec<_>>().join(", ")
}

fn has_reset(protocol: &Protocol) -> bool {
    let asked = Asked::default();
    protocol.start(&asked, true) != protocol.start(&asked, false)
}

fn has_stop(protocol: &Protocol) -> bool {
    protocol.stop() != Script::new()
}

fn mock(mut options: Options<'_>, head: Option<u8>, times: &Times) -> Result<MockSpec, Fault> {
    let mut spec = MockSpec::default();
    let whole = "a whole number from 0 to 18446744073709551615";
    options.number(&mut spec.seed, "seed", (0, u64::MAX), whole)?;
    options.number(&mut spec.rate, "rate", (60_u32, 10_000), "60 to 10000 Hz")?;
    options.flag(&mut spec.still, "still")?;
    let path = "the path of a table of targets";
    options.set(&mut spec.targets, "targets", path, |value| {
        (!value.is_empty()).then(|| PathBuf::from(value))
    })?;
    if let Some(name) = options.take("as") {
        let mut protocol = ProtocolSpec::named(name)?;
        protocol.set(&mut options)?;
        spec.protocol = Some(protocol);
    }
    spec.delay = times.delay.unwrap_or(spec.delay);
    let protocol = spec.protocol.as_ref();
    one_sensor(head, protocol, "mock")?;
    let sensors = protocol.map_or(0..=0, ProtocolSpec::simulated_sensors);
    if let Some(head) = head.filter(|head| !sensors.contains(head)) {
        let (first, last) = (sensors.start(), sensors.end());
        if first == last {
            return Err(lone_sensor("mock", head));
        }
        return Err(Fault::new(
            format!("the mock's sensors are {first} to {last}, so head={head} does not exist"),
            "choose one of them, or give more birds",
        ));
    }
    let protocol = protocol.map(ProtocolSpec::protocol);
    let allowed = "seed=N, rate=HZ, as=PROTOCOL, still=1, targets=FILE, head=N";
    options.end("mock", &with_times(allowed), protocol)?;
    Ok(spec)
}

fn serial(path: &str, mut options: Options<'_>, head: Option<u8>) -> Result<SerialSpec, Fault> {
    let (mut baud, mut reset, mut stop) = (None, false, false);
    options.number(&mut baud, "baud", (50_u32, 4_000_000), "50 to 4000000 baud")?;
    options.flag(&mut reset, "reset")?;
    let mut rts = None;
    options.flag(&mut rts, "rts")?;
    let all = || names(Protocol::is_serial);
    let Some(name) = options.take("protocol") else {
        return Err(Fault::new(
            format!("serial:{path} does not name the protocol of its device"),
            format!("append ?protocol=NAME, NAME being one of {}", all()),
        ));
    };
    let mut protocol = ProtocolSpec::named(name).map_err(|unknown| {
        let help = format!("give one of {}", all());
        Fault::new(unknown.to_string(), help)
    })?;
    let name = protocol.name();
    if !protocol.protocol().is_serial() {
        return Err(Fault::new(
            format!("{name} does not go over a serial line"),
            format!(
                "plug the device in and give hid:VENDOR:PRODUCT, or one of {}",
                all()
            ),
        ));
    }
    one_sensor(head, Some(&protocol), "serial")?;
    if reset && !has_reset(protocol.protocol()) {
        return Err(Fault::new(
            format!("{name} has no command for a reset: reset=1 does nothing"),
            format!("leave reset out; those with one are {}", names(has_reset)),
        ));
    }
    let speed = match options.take("speed") {
        None => None,
        Some(_) if protocol.protocol().change_speed(BAUD_RATES[0]).is_none() => {
            return Err(Fault::new(
                format!("{name} has no command that changes the line's speed: speed does nothing"),
                "leave speed out, and give baud=N as the device is set; that with one is fastrak",
            ));
        }
        Some(_) if reset => {
            return Err(Fault::new(
                "a reset undoes a change of speed",
                "reset the device in a run of its own, and give speed in the next",
            ));
        }
        Some(found) => {
            let baud = found.parse().ok().filter(|baud| BAUD_RATES.contains(baud));
            let allowed = "2400, 4800, 9600, 19200, 38400, 57600 or 115200 baud";
            Some(baud.ok_or_else(|| wrong("speed", found, allowed))?)
        }
    };
    options.flag(&mut stop, "stop")?;
    if stop && !has_stop(protocol.protocol()) {
        return Err(Fault::new(
            format!("{name} has no command that stops it: stop=1 does nothing"),
            format!("leave stop out; those with one are {}", names(has_stop)),
        ));
    }
    protocol.set(&mut options)?;
    let allowed = "protocol=NAME, baud=N, speed=N, reset=1, stop=1, head=N, rts=0|1";
    options.end("serial", &with_times(allowed), Some(protocol.protocol()))?;
    Ok(SerialSpec {
        path: path.into(),
        baud: baud.unwrap_or(protocol.protocol().baud()),
        protocol,
        reset,
        speed,
        stop,
        rts,
    })
}

fn hid(name: &str, mut options: Options<'_>, head: Option<u8>) -> Result<HidSpec, Fault> {
    let mut axes = Axes::default();
    set_axes(&mut axes, &mut options)?;
    one_sensor(head, None, "hid")?;
    options.end("hid", &with_times("axes=right,up,back, origin=X,Y,Z"), None)?;
    let name = hid_name(name)?;
    Ok(HidSpec { name, axes })
}

fn with_times(allowed: &str) -> String {
    format!("{allowed}, calibration=FILE, {TIMES}")
}

/// Refuses the choice of a sensor where there is only one.
fn one_sensor(
    head: Option<u8>,
    protocol: Option<&ProtocolSpec>,
    kind: &'static str,
) -> Result<(), Fault> {
    let several = protocol.is_some_and(|spec| spec.protocol().has_sensors());
    match head.filter(|_| !several) {
        None => Ok(()),
        Some(head) => Err(lone_sensor(protocol.map_or(kind, ProtocolSpec::name), head)),
    }
}

fn lone_sensor(of: &str, head: u8) -> Fault {
    Fault::new(
        format!("{of} has one sensor, so head={head} cannot choose one"),
        "leave head out; those with several are link, fastrak, liberty, flock, vrpn, dtrack and natnet, \
         and recordings",
    )
}

fn hid_name(text: &str) -> Result<HidName, Fault> {
    if text.starts_with('/') {
        return Ok(HidName::Path(text.into()));
    }
    let id = |digits: &str| {
        let digits = (digits.len() == 4).then_some(digits)?;
        u16::from_str_radix(digits, 16).ok()
    };
    if let Some(usage) = text.strip_prefix("usage=") {
        let (page, usage) = match usage.split_once(':') {
            Some((page, usage)) => (id(page), id(usage).map(Some)),
            None => (id(usage), Some(None)),
        };
        let name = page.zip(usage);
        let name = name.map(|(page, usage)| HidName::Usage { page, usage });
        let allowed = "four hexadecimal digits of a usage page, and of a usage if one is meant, \
                       such as hid:usage=0012 or hid:usage=0012:0001";
        return name.ok_or_else(|| wrong("hid", text, allowed));
    }
    let both = text.split_once(':');
    let both = both.and_then(|(vendor, product)| Some(HidName::Id(id(vendor)?, id(product)?)));
    let allowed = "four hexadecimal digits each of vendor and product, such as hid:1532:0b00, a \
                   usage page, such as hid:usage=0012, or a path, such as hid:/dev/hidraw0";
    both.ok_or_else(|| wrong("hid", text, allowed))
}

#[cfg(test)]
mod tests;
