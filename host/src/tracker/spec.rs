//! `SPEC`: which tracker, in one word of a command line.

use super::protocol::{Protocol, UnknownProtocol};
use super::settings::{Options, set_axes};
use super::times::{self, Times};
use miette::Diagnostic;
use shisen_tracker::estimate::ConfigError;
use shisen_tracker::head::fastrak::BAUD_RATES;
use shisen_tracker::head::polhemus::ItemListError;
use shisen_tracker::hid::eye_tracker::Axes;
use shisen_tracker::mock::Format;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use thiserror::Error;

/// Which tracker.
#[derive(Debug, Clone, PartialEq)]
pub enum Spec {
    /// `mock`, `mock:seed=7&rate=200&as=fastrak`.
    Mock(MockSpec),
    /// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200&reset=1&units=cm`.
    Serial(SerialSpec),
    /// `hid:1532:0b00`, `hid:usage=0012`, `hid:/dev/hidraw0?origin=0,0.3,-0.5`.
    Hid(HidSpec),
    /// `replay:FILE`, `replay:FILE?head=2`.
    Replay(ReplaySpec),
}

impl Spec {
    /// The sensor that is the viewer's head, where somebody says so.
    pub const fn head(&self) -> Option<u8> {
        match self {
            Self::Mock(spec) => spec.head,
            Self::Serial(spec) => spec.head,
            Self::Hid(_) => None,
            Self::Replay(spec) => spec.head,
        }
    }

    /// After how long data are stale, and count as stuck, where somebody says so.
    pub const fn times(&self) -> &Times {
        match self {
            Self::Mock(spec) => &spec.times,
            Self::Serial(spec) => &spec.times,
            Self::Hid(spec) => &spec.times,
            Self::Replay(spec) => &spec.times,
        }
    }
}

/// A simulated viewer and tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct MockSpec {
    /// What decides all movements and all noise.
    pub seed: u64,
    /// Samples per second: 60 to 1000.
    pub rate: u32,
    /// The protocol that the samples pass through; none hands them on as they
    /// are.
    pub protocol: Option<Protocol>,
    /// The head is held still, as by a chin rest.
    pub still: bool,
    /// A table of what is looked at, and when: see
    /// [`read_script`](super::calibration::read_script).
    pub targets: Option<PathBuf>,
    /// The sensor that is the viewer's head, as its samples name it: 0 alone comes.
    pub head: Option<u8>,
    /// After how long its data are stale.
    pub times: Times,
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
            head: None,
            times: Times::default(),
        }
    }
}

/// A tracker on a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialSpec {
    /// The port.
    pub path: String,
    /// What the device speaks.
    pub protocol: Protocol,
    /// How fast.
    pub baud: u32,
    /// Whether the device is reset first, which can take 20 s.
    pub reset: bool,
    /// The speed that the line is changed to at both ends, once it is open.
    pub speed: Option<u32>,
    /// Whether the device is told to stop when nobody listens any more.
    pub stop: bool,
    /// The sensor that is the viewer's head, as its samples name it; the first
    /// that is seen where nobody says so.
    pub head: Option<u8>,
    /// Whether the line's RTS is to be high; where nobody says so it is as
    /// [`Protocol::rts`] has it.
    pub rts: Option<bool>,
    /// After how long its data are stale.
    pub times: Times,
}

/// A recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReplaySpec {
    /// What `shisen tracker record` wrote.
    pub path: PathBuf,
    /// The sensor that is the viewer's head, as its samples name it; the first
    /// that is seen where nobody says so.
    pub head: Option<u8>,
    /// After how long its data are stale.
    pub times: Times,
}

/// A human interface device.
#[derive(Debug, Clone, PartialEq)]
pub struct HidSpec {
    /// Which.
    pub name: HidName,
    /// The coordinates of an eye tracker; its descriptor does not say.
    pub axes: Axes,
    /// After how long its data are stale.
    pub times: Times,
}

/// Which human interface device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HidName {
    /// By USB's vendor and product.
    Id(u16, u16),
    /// By its path.
    Path(String),
    /// By what it says that it is: a usage page and, where one is given, a usage of
    /// one of its collections. 0x12 is that of eye and head trackers.
    Usage {
        /// The page.
        page: u16,
        /// The usage; any of the page where there is none.
        usage: Option<u16>,
    },
}

impl fmt::Display for HidName {
    /// As in a specification.
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

/// A `SPEC` that names no tracker.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum SpecError {
    /// Another word in front.
    #[error("{found:?} is no kind of tracker")]
    #[diagnostic(help(
        "give mock, mock:seed=7&rate=200&as=fastrak, serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:usage=0012 or replay:FILE"
    ))]
    Kind {
        /// What stands there.
        found: String,
    },
    /// Nothing after the word.
    #[error("{kind}: says not which")]
    #[diagnostic(help(
        "give serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:/dev/hidraw0 or replay:FILE"
    ))]
    Nothing {
        /// The word.
        kind: &'static str,
    },
    /// An option that there is not.
    #[error("{of} has no option {key:?}")]
    #[diagnostic(help("give {allowed}"))]
    Key {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The option.
        key: String,
        /// Those that there are.
        allowed: String,
    },
    /// An option that is given twice.
    #[error("{key:?} is given twice")]
    #[diagnostic(help("give it once"))]
    Twice {
        /// The option.
        key: String,
    },
    /// A list of items that no device can send.
    #[error("items: {0}")]
    #[diagnostic(help(
        "the items are those of the device's manual, in the order that it is to send"
    ))]
    Items(#[from] ItemListError),
    /// An option's value that it cannot have.
    #[error("{key}={found:?} is not possible")]
    #[diagnostic(help("give {allowed}"))]
    Value {
        /// The option.
        key: &'static str,
        /// Its value.
        found: String,
        /// Those that it can have.
        allowed: &'static str,
    },
    /// A time of the estimator's that it refuses.
    #[error("{0}")]
    #[diagnostic(help("the times are seconds: {}", times::ALLOWED))]
    Times(ConfigError),
    /// A sensor is chosen where there is one.
    #[error("{of} has one sensor: head={head} chooses none")]
    #[diagnostic(help(
        "leave head out; those with several are link, fastrak, liberty and flock, and recordings"
    ))]
    OneSensor {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The sensor.
        head: u8,
    },
    /// A reset is asked for where there is none.
    #[error("{of} has no command for a reset: reset=1 does nothing")]
    #[diagnostic(help("leave reset out; those with one are {}", names(Protocol::has_reset)))]
    NoReset {
        /// The protocol.
        of: &'static str,
    },
    /// A change of speed is asked for where there is none.
    #[error("{of} has no command that changes the line's speed: speed does nothing")]
    #[diagnostic(help(
        "leave speed out, and give baud=N as the device is set; that with one is fastrak"
    ))]
    NoSpeed {
        /// The protocol.
        of: &'static str,
    },
    /// A reset and a change of speed.
    #[error("a reset undoes a change of speed")]
    #[diagnostic(help("reset the device in a run of its own, and give speed in the next"))]
    ResetAndSpeed,
    /// A stop is asked for where there is none.
    #[error("{of} has no command that stops it: stop=1 does nothing")]
    #[diagnostic(help("leave stop out; those with one are {}", names(Protocol::has_stop)))]
    NoStop {
        /// The protocol.
        of: &'static str,
    },
    /// A protocol that there is not.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Protocol(#[from] UnknownProtocol),
    /// A protocol that goes over no serial line.
    #[error("{name} does not go over a serial line")]
    #[diagnostic(help(
        "plug the device in and give hid:VENDOR:PRODUCT, or one of {}",
        names(Protocol::is_serial)
    ))]
    NotSerial {
        /// The protocol.
        name: &'static str,
    },
    /// A serial port without a protocol.
    #[error("serial:{path} says not which protocol its device speaks")]
    #[diagnostic(help(
        "append ?protocol=NAME, NAME being one of {}",
        names(Protocol::is_serial)
    ))]
    NoProtocol {
        /// The port.
        path: String,
    },
}

fn names(of: fn(&Protocol) -> bool) -> String {
    let named = Format::NAMES
        .into_iter()
        .filter(|name| Protocol::named(name).is_ok_and(|protocol| of(&protocol)));
    named.collect::<Vec<_>>().join(", ")
}

impl FromStr for Spec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let named = |kind| {
            let some = (!rest.is_empty()).then_some(rest);
            some.ok_or(SpecError::Nothing { kind })
        };
        match kind {
            "mock" => mock(rest).map(Self::Mock),
            "serial" => serial(named("serial")?).map(Self::Serial),
            "hid" => hid(named("hid")?).map(Self::Hid),
            "replay" => replay(named("replay")?).map(Self::Replay),
            _ => Err(SpecError::Kind { found: kind.into() }),
        }
    }
}

fn mock(text: &str) -> Result<MockSpec, SpecError> {
    let mut options = Options::read(text)?;
    let mut spec = MockSpec::default();
    let whole = "a whole number from 0 to 18446744073709551615";
    if let Some(seed) = options.number("seed", (0, u64::MAX), whole)? {
        spec.seed = seed;
    }
    if let Some(rate) = options.number("rate", (60, 1_000), "60 to 1000 Hz")? {
        spec.rate = rate;
    }
    if let Some(still) = options.number("still", (0_u8, 1), "0 or 1")? {
        spec.still = still == 1;
    }
    spec.targets = options.one_of("targets", "the path of a table of targets", |value| {
        (!value.is_empty()).then(|| value.into())
    })?;
    if let Some(name) = options.take("as") {
        let mut protocol = Protocol::named(name)?;
        protocol.set(&mut options)?;
        spec.protocol = Some(protocol);
    }
    spec.head = head(&mut options)?;
    spec.times = Times::take(&mut options)?;
    one_sensor(spec.head, spec.protocol.as_ref(), "mock")?;
    // Whatever it speaks, it has sensor 0.
    if let Some(head @ 1..) = spec.head {
        return Err(SpecError::OneSensor { of: "mock", head });
    }
    let protocol = spec.protocol.as_ref();
    let protocol = protocol.map(|protocol| (protocol.name(), protocol.format()));
    let allowed = "seed=N, rate=HZ, as=PROTOCOL, still=1, targets=FILE, head=N";
    options.end("mock", &with_times(allowed), protocol)?;
    Ok(spec)
}

fn serial(text: &str) -> Result<SerialSpec, SpecError> {
    let (path, rest) = text.split_once('?').unwrap_or((text, ""));
    if path.is_empty() {
        return Err(SpecError::Nothing { kind: "serial" });
    }
    let mut options = Options::read(rest)?;
    let baud = options.number("baud", (50, 4_000_000), "50 to 4000000 baud")?;
    let reset = options.number("reset", (0_u8, 1), "0 or 1")? == Some(1);
    let head = head(&mut options)?;
    let rts = options.flag("rts")?;
    let times = Times::take(&mut options)?;
    let Some(name) = options.take("protocol") else {
        return Err(SpecError::NoProtocol { path: path.into() });
    };
    let mut protocol = Protocol::named(name)?;
    if !protocol.is_serial() {
        return Err(SpecError::NotSerial {
            name: protocol.name(),
        });
    }
    one_sensor(head, Some(&protocol), "serial")?;
    if reset && !protocol.has_reset() {
        return Err(SpecError::NoReset {
            of: protocol.name(),
        });
    }
    let speed = match options.take("speed") {
        None => None,
        Some(_) if protocol.change_speed(BAUD_RATES[0]).is_none() => {
            return Err(SpecError::NoSpeed {
                of: protocol.name(),
            });
        }
        Some(_) if reset => return Err(SpecError::ResetAndSpeed),
        Some(found) => {
            let baud = found.parse().ok();
            let wrong = || SpecError::Value {
                key: "speed",
                found: found.into(),
                allowed: "2400, 4800, 9600, 19200, 38400, 57600 or 115200 baud",
            };
            Some(
                baud.filter(|baud| BAUD_RATES.contains(baud))
                    .ok_or_else(wrong)?,
            )
        }
    };
    let stop = options.number("stop", (0_u8, 1), "0 or 1")? == Some(1);
    if stop && !protocol.has_stop() {
        return Err(SpecError::NoStop {
            of: protocol.name(),
        });
    }
    protocol.set(&mut options)?;
    let named = Some((protocol.name(), protocol.format()));
    let allowed = "protocol=NAME, baud=N, speed=N, reset=1, stop=1, head=N, rts=0|1";
    options.end("serial", &with_times(allowed), named)?;
    Ok(SerialSpec {
        path: path.into(),
        baud: baud.unwrap_or(protocol.baud()),
        protocol,
        reset,
        speed,
        stop,
        head,
        rts,
        times,
    })
}

fn hid(text: &str) -> Result<HidSpec, SpecError> {
    let (name, rest) = text.split_once('?').unwrap_or((text, ""));
    let mut options = Options::read(rest)?;
    let mut axes = Axes::default();
    set_axes(&mut axes, &mut options)?;
    one_sensor(head(&mut options)?, None, "hid")?;
    let times = Times::take(&mut options)?;
    let allowed = with_times("axes=right,up,back, origin=X,Y,Z");
    options.end("hid", &allowed, None)?;
    let name = hid_name(name)?;
    Ok(HidSpec { name, axes, times })
}

/// A file's name may hold a `?`: options have a `=` behind it.
fn replay(text: &str) -> Result<ReplaySpec, SpecError> {
    let split = text.rsplit_once('?');
    let (path, rest) = split
        .filter(|(path, rest)| !path.is_empty() && rest.contains('='))
        .unwrap_or((text, ""));
    let mut options = Options::read(rest)?;
    let head = head(&mut options)?;
    let times = Times::take(&mut options)?;
    options.end("replay", &with_times("head=N"), None)?;
    let path = path.into();
    Ok(ReplaySpec { path, head, times })
}

/// The keys of a kind of tracker, and those that all have.
fn with_times(allowed: &str) -> String {
    format!("{allowed}, {}", times::ALLOWED)
}

fn head(options: &mut Options<'_>) -> Result<Option<u8>, SpecError> {
    options.number("head", (0, u8::MAX), "a sensor from 0 to 255")
}

/// Refuses the choice of a sensor where there is one.
fn one_sensor(
    head: Option<u8>,
    protocol: Option<&Protocol>,
    kind: &'static str,
) -> Result<(), SpecError> {
    let several = protocol.is_some_and(Protocol::has_sensors);
    match head.filter(|_| !several) {
        None => Ok(()),
        Some(head) => Err(SpecError::OneSensor {
            of: protocol.map_or(kind, Protocol::name),
            head,
        }),
    }
}

fn hid_name(text: &str) -> Result<HidName, SpecError> {
    if text.starts_with('/') {
        return Ok(HidName::Path(text.into()));
    }
    let id = |digits: &str| {
        let plain = digits.len() == 4;
        plain
            .then(|| u16::from_str_radix(digits, 16).ok())
            .flatten()
    };
    if let Some(usage) = text.strip_prefix("usage=") {
        let (page, usage) = match usage.split_once(':') {
            Some((page, usage)) => (id(page), id(usage).map(Some)),
            None => (id(usage), Some(None)),
        };
        let both = page.zip(usage);
        return both
            .map(|(page, usage)| HidName::Usage { page, usage })
            .ok_or_else(|| SpecError::Value {
                key: "hid",
                found: text.into(),
                allowed: "four hexadecimal digits of a usage page, and of a usage if one is meant, \
                          such as hid:usage=0012 or hid:usage=0012:0001",
            });
    }
    let both = text.split_once(':');
    let both = both.and_then(|(vendor, product)| Some((id(vendor)?, id(product)?)));
    let (vendor, product) = both.ok_or_else(|| SpecError::Value {
        key: "hid",
        found: text.into(),
        allowed: "four hexadecimal digits each of vendor and product, such as hid:1532:0b00, a \
                  usage page, such as hid:usage=0012, or a path, such as hid:/dev/hidraw0",
    })?;
    Ok(HidName::Id(vendor, product))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    #[test]
    fn each_kind_is_read() {
        assert_eq!("mock".parse(), Ok(Spec::Mock(MockSpec::default())));
        let mock = MockSpec {
            seed: 7,
            rate: 200,
            protocol: Some("fastrak".parse().unwrap()),
            ..MockSpec::default()
        };
        assert_eq!(
            "mock:seed=7&rate=200&as=fastrak".parse(),
            Ok(Spec::Mock(mock))
        );
        let mock = MockSpec {
            still: true,
            targets: Some("a.csv".into()),
            ..MockSpec::default()
        };
        assert_eq!("mock:still=1&targets=a.csv".parse(), Ok(Spec::Mock(mock)));
        let serial = SerialSpec {
            path: "/dev/ttyUSB0".into(),
            protocol: "asl".parse().unwrap(),
            baud: 57_600,
            reset: false,
            speed: None,
            stop: false,
            head: None,
            rts: None,
            times: Times::default(),
        };
        let spec = "serial:/dev/ttyUSB0?protocol=asl";
        assert_eq!(spec.parse(), Ok(Spec::Serial(serial.clone())));
        let other = SerialSpec {
            baud: 9_600,
            reset: true,
            head: Some(2),
            rts: Some(true),
            protocol: "flock".parse().unwrap(),
            ..serial.clone()
        };
        let spec = "serial:/dev/ttyUSB0?protocol=flock&baud=9600&reset=1&head=2&rts=1";
        assert_eq!(spec.parse(), Ok(Spec::Serial(other)));
        let faster = SerialSpec {
            baud: 9_600,
            speed: Some(115_200),
            stop: true,
            protocol: "fastrak".parse().unwrap(),
            ..serial
        };
        let spec = "serial:/dev/ttyUSB0?protocol=fastrak&baud=9600&speed=115200&stop=1";
        assert_eq!(spec.parse(), Ok(Spec::Serial(faster)));
        let times = Times::default();
        let hid = |name, axes| Ok(Spec::Hid(HidSpec { name, axes, times }));
        let id = HidName::Id(0x1532, 0x0B00);
        assert_eq!("hid:1532:0b00".parse(), hid(id, Axes::default()));
        let path = HidName::Path("/dev/hidraw0".into());
        let spec = "hid:/dev/hidraw0".parse();
        assert_eq!(spec, hid(path.clone(), Axes::default()));
        for (spec, usage) in [("hid:usage=0012", None), ("hid:usage=0012:0001", Some(1))] {
            let name = HidName::Usage { page: 0x12, usage };
            assert_eq!(name.to_string(), spec[4..]);
            assert_eq!(spec.parse(), hid(name, Axes::default()));
        }
        let axes = Axes {
            rotation: Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            origin: Vec3::new(0.0, 0.3, -0.5),
        };
        let spec = "hid:/dev/hidraw0?axes=left,up,forward&origin=0,0.3,-0.5";
        assert_eq!(spec.parse(), hid(path, axes));
        for (text, path, head) in [
            ("replay:a:b", "a:b", None),
            ("replay:a?b", "a?b", None),
            ("replay:a?b?head=7", "a?b", Some(7)),
        ] {
            let path = path.into();
            assert_eq!(
                text.parse(),
                Ok(Spec::Replay(ReplaySpec { path, head, times }))
            );
        }
    }

    #[test]
    fn a_sensor_is_chosen_where_there_are_several() {
        for spec in [
            "serial:/dev/tty?protocol=fastrak&head=3",
            "serial:/dev/tty?protocol=liberty&head=3",
            "serial:/dev/tty?protocol=link&head=3",
            "replay:a.csv?head=3",
        ] {
            assert_eq!(spec.parse::<Spec>().unwrap().head(), Some(3), "{spec}");
        }
        for (spec, of) in [
            ("serial:/dev/tty?protocol=asl&head=3", "asl"),
            ("serial:/dev/tty?protocol=hatire&head=0", "hatire"),
            ("mock:head=0", "mock"),
            // It has sensor 0 alone.
            ("mock:as=flock&head=3", "mock"),
            ("mock:as=adhawk&head=0", "adhawk"),
            ("hid:1532:0b00?head=1", "hid"),
        ] {
            let error = spec.parse::<Spec>().unwrap_err();
            let expected = format!("{of} has one sensor");
            assert!(error.to_string().starts_with(&expected), "{error}");
        }
    }

    #[test]
    fn slips_say_what_is_allowed() {
        for (spec, message, help) in [
            ("mouse", "mouse", "serial:/dev/ttyUSB0"),
            ("serial:", "says not which", "serial:/dev"),
            ("serial:/dev/ttyUSB0", "protocol", "fastrak, liberty"),
            ("serial:/dev/tty?protocol=hid", "serial line", "hid:VENDOR"),
            ("serial:/dev/tty?protocol=asl&baud=0", "baud", "4000000"),
            (
                "serial:/dev/tty?protocol=asl&speed=1",
                "asl has no",
                "baud=N",
            ),
            ("serial:/dev/tty?protocol=fastrak&speed=1", "speed", "57600"),
            (
                "serial:/dev/tty?protocol=fastrak&speed=9600&reset=1",
                "undoes",
                "of its own",
            ),
            (
                "serial:/dev/tty?protocol=asl&stop=1",
                "asl has no command that stops",
                "link, fastrak, liberty, flock, hatire, iscan, adhawk",
            ),
            ("serial:/dev/tty?protocol=asl&reset=yes", "reset", "0 or 1"),
            (
                "serial:/dev/tty?protocol=asl&reset=1",
                "asl has no command for a reset",
                "fastrak, liberty, flock, hatire",
            ),
            (
                "serial:/dev/tty?protocol=iscan&reset=1",
                "iscan",
                "leave reset",
            ),
            (
                "serial:/dev/tty?protocol=link&reset=1",
                "link",
                "leave reset",
            ),
            ("serial:/dev/tty?protocol=adhawk&reset=1", "adhawk", "leave"),
            ("serial:/dev/tty?protocol=asl&rts=2", "rts", "0 or 1"),
            ("serial:/dev/tty?protocol=asd", "asd", "asl"),
            ("mock:rate=59", "59", "60 to 1000"),
            ("mock:rate=", "rate", "60 to 1000"),
            ("mock:speed=5", "speed", "rate=HZ"),
            ("mock:still=yes", "still", "0 or 1"),
            ("mock:targets=", "targets", "table"),
            ("mock:as=mouse", "mouse", "osvr-hdk"),
            ("hid:1:2", "1:2", "hexadecimal"),
            ("hid:0012", "0012", "hid:usage=0012"),
            ("hid:usage=12", "usage=12", "hid:usage=0012:0001"),
            ("hid:usage=0012:1", "usage=0012:1", "usage page"),
            ("hid:1532:0b00?units=cm", "units", "origin=X,Y,Z"),
            (
                "hid:1532:0b00?axes=right,up,forward",
                "axes",
                "right-handed",
            ),
            ("hid:1532:0b00?origin=1,2", "origin", "metres"),
            ("serial:?protocol=asl", "says not which", "serial:/dev"),
            (
                "serial:/dev/tty?protocol=asl&baud=1200&baud=50",
                "twice",
                "once",
            ),
            ("mock:seed=1&seed=1", "twice", "once"),
            ("mock:units=cm", "mock has no", "seed=N"),
            ("replay:", "replay", "replay:FILE"),
            ("replay:a?sensor=2", "sensor", "head=N"),
            ("replay:a?head=two", "head", "0 to 255"),
            ("mock:as=link&head=256", "head", "0 to 255"),
        ] {
            let error = spec.parse::<Spec>().unwrap_err();
            assert!(error.to_string().contains(message), "{error}");
            let said = Diagnostic::help(&error).unwrap().to_string();
            assert!(said.contains(help), "{spec}: {said}");
        }
    }
}
