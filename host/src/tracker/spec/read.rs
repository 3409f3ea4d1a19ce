//! Reads a `SPEC`.

use super::{HidName, HidSpec, MockSpec, ReplaySpec, SerialSpec, Spec};
use crate::tracker::fault::{SpecError, TIMES, has_reset, has_stop};
use crate::tracker::protocol::ProtocolSpec;
use crate::tracker::settings::{Options, assign, set_axes};
use crate::tracker::times::Times;
use shisen_tracker::head::fastrak::BAUD_RATES;
use shisen_tracker::hid::eye_tracker::Axes;
use std::str::FromStr;

impl FromStr for Spec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let named = |kind| {
            let some = (!rest.is_empty()).then_some(rest);
            some.ok_or(SpecError::Nothing(kind))
        };
        match kind {
            "mock" => mock(rest).map(Self::Mock),
            "serial" => serial(named("serial")?).map(Self::Serial),
            "hid" => hid(named("hid")?).map(Self::Hid),
            "replay" => replay(named("replay")?).map(Self::Replay),
            _ => Err(SpecError::Kind(kind.into())),
        }
    }
}

fn mock(text: &str) -> Result<MockSpec, SpecError> {
    let mut options = Options::read(text)?;
    let mut spec = MockSpec::default();
    let whole = "a whole number from 0 to 18446744073709551615";
    let seed = options.number("seed", (0, u64::MAX), whole)?;
    assign(&mut spec.seed, seed);
    let rate = options.number("rate", (60, 10_000), "60 to 10000 Hz")?;
    assign(&mut spec.rate, rate);
    assign(&mut spec.still, options.flag("still")?);
    spec.targets = options.one_of("targets", "the path of a table of targets", |value| {
        (!value.is_empty()).then(|| value.into())
    })?;
    if let Some(name) = options.take("as") {
        let mut protocol = ProtocolSpec::named(name)?;
        protocol.set(&mut options)?;
        spec.protocol = Some(protocol);
    }
    spec.head = head(&mut options)?;
    spec.times = Times::take(&mut options)?;
    one_sensor(spec.head, spec.protocol.as_ref(), "mock")?;
    let protocol = spec.protocol.as_ref();
    let sensors = protocol.map_or(0..=0, ProtocolSpec::simulated_sensors);
    match spec.head.filter(|head| !sensors.contains(head)) {
        None => {}
        Some(head) if sensors.start() == sensors.end() => {
            return Err(SpecError::OneSensor { of: "mock", head });
        }
        Some(head) => return Err(SpecError::NoSensor { head, sensors }),
    }
    let protocol = protocol.map(ProtocolSpec::protocol);
    let allowed = "seed=N, rate=HZ, as=PROTOCOL, still=1, targets=FILE, head=N";
    options.end("mock", &with_times(allowed), protocol)?;
    Ok(spec)
}

fn serial(text: &str) -> Result<SerialSpec, SpecError> {
    let (path, rest) = text.split_once('?').unwrap_or((text, ""));
    if path.is_empty() {
        return Err(SpecError::Nothing("serial"));
    }
    let mut options = Options::read(rest)?;
    let baud = options.number("baud", (50, 4_000_000), "50 to 4000000 baud")?;
    let reset = options.flag("reset")? == Some(true);
    let head = head(&mut options)?;
    let rts = options.flag("rts")?;
    let times = Times::take(&mut options)?;
    let Some(name) = options.take("protocol") else {
        return Err(SpecError::NoProtocol(path.into()));
    };
    let mut protocol =
        ProtocolSpec::named(name).map_err(|_| SpecError::UnknownOnSerial(name.into()))?;
    if !protocol.protocol().is_serial() {
        return Err(SpecError::NotSerial(protocol.name()));
    }
    one_sensor(head, Some(&protocol), "serial")?;
    if reset && !has_reset(protocol.protocol()) {
        return Err(SpecError::NoReset(protocol.name()));
    }
    let speed = match options.take("speed") {
        None => None,
        Some(_) if protocol.protocol().change_speed(BAUD_RATES[0]).is_none() => {
            return Err(SpecError::NoSpeed(protocol.name()));
        }
        Some(_) if reset => return Err(SpecError::ResetAndSpeed),
        Some(found) => {
            let baud = found.parse().ok().filter(|baud| BAUD_RATES.contains(baud));
            let allowed = "2400, 4800, 9600, 19200, 38400, 57600 or 115200 baud";
            Some(baud.ok_or_else(|| wrong("speed", found, allowed))?)
        }
    };
    let stop = options.flag("stop")? == Some(true);
    if stop && !has_stop(protocol.protocol()) {
        return Err(SpecError::NoStop(protocol.name()));
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

/// Reads `FILE?options`: a file's name may hold a `?`, but options have a `=` behind it.
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

/// The options of a kind of tracker, and those that all have.
fn with_times(allowed: &str) -> String {
    format!("{allowed}, {TIMES}")
}

fn wrong(key: &'static str, found: &str, allowed: &str) -> SpecError {
    SpecError::Value {
        key,
        found: found.into(),
        allowed: allowed.into(),
    }
}

fn head(options: &mut Options<'_>) -> Result<Option<u8>, SpecError> {
    options.number("head", (0, u8::MAX), "a sensor from 0 to 255")
}

/// Refuses the choice of a sensor where there is only one.
fn one_sensor(
    head: Option<u8>,
    protocol: Option<&ProtocolSpec>,
    kind: &'static str,
) -> Result<(), SpecError> {
    let several = protocol.is_some_and(|spec| spec.protocol().has_sensors());
    match head.filter(|_| !several) {
        None => Ok(()),
        Some(head) => Err(SpecError::OneSensor {
            of: protocol.map_or(kind, ProtocolSpec::name),
            head,
        }),
    }
}

fn hid_name(text: &str) -> Result<HidName, SpecError> {
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
