//! The settings of a protocol: `key=value` of a `SPEC`.

use crate::files::Fault;
use glam::{Mat3, Quat, Vec3};
use shisen_tracker::eye::asl::Layout;
use shisen_tracker::eye::iscan::{self, Output, Outputs};
use shisen_tracker::head::axes::Axes;
use shisen_tracker::head::fastrak;
use shisen_tracker::head::flock::{self, Mode, Range};
use shisen_tracker::head::hatire::{self, Translation};
use shisen_tracker::head::liberty::{self, Model, Size};
use shisen_tracker::head::polhemus::{Family, Format, ItemList, Units};
use shisen_tracker::hid::eye_tracker;
use shisen_tracker::protocol::{Asked, Protocol};
use shisen_tracker::time::Micros;
use std::str::FromStr;

/// The options of a `SPEC`, `key=value` between `&`, until they are taken.
pub(super) struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    pub(super) fn read(text: &'a str) -> Result<Self, Fault> {
        let mut options: Vec<(&str, &str)> = Vec::new();
        for part in text.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            if options.iter().any(|&(other, _)| other == key) {
                let message = format!("{key:?} is given twice");
                return Err(Fault::new(message, "give it once"));
            }
            options.push((key, value));
        }
        Ok(Self(options))
    }

    pub(super) fn take(&mut self, key: &str) -> Option<&'a str> {
        let at = self.0.iter().position(|&(other, _)| other == key)?;
        Some(self.0.remove(at).1)
    }

    /// Sets `to` to what `read` makes of a key's value; `None` is an error.
    pub(super) fn set<T, To: From<T>>(
        &mut self,
        to: &mut To,
        key: &str,
        allowed: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<(), Fault> {
        if let Some(value) = self.take(key) {
            let read = read(value).ok_or_else(|| wrong(key, value, allowed))?;
            *to = read.into();
        }
        Ok(())
    }

    pub(super) fn number<T: FromStr + PartialOrd, To: From<T>>(
        &mut self,
        to: &mut To,
        key: &str,
        (least, most): (T, T),
        allowed: &str,
    ) -> Result<(), Fault> {
        self.set(to, key, allowed, |value| {
            let number = value.parse().ok();
            number.filter(|number| *number >= least && *number <= most)
        })
    }

    pub(super) fn flag<To: From<bool>>(&mut self, to: &mut To, key: &str) -> Result<(), Fault> {
        self.word(to, key, "0 1", [false, true])
    }

    /// Sets the meaning of one of some words.
    pub(super) fn word<T: Copy, To: From<T>, const N: usize>(
        &mut self,
        to: &mut To,
        key: &str,
        words: &str,
        meanings: [T; N],
    ) -> Result<(), Fault> {
        let (others, last) = words.rsplit_once(' ').unwrap_or_default();
        let allowed = format!("{} or {last}", others.replace(' ', ", "));
        self.set(to, key, &allowed, |value| {
            let mut words = words.split(' ').zip(meanings);
            words
                .find(|(word, _)| *word == value)
                .map(|(_, meaning)| meaning)
        })
    }

    /// Returns the options that are left, as they were given.
    pub(super) fn rest(self) -> String {
        let rest = self.0.iter().map(|(key, value)| format!("{key}={value}"));
        rest.collect::<Vec<_>>().join("&")
    }

    /// Checks that no option is left; an error lists the known ones.
    pub(super) fn end(
        self,
        kind: &'static str,
        allowed: &str,
        protocol: Option<&Protocol>,
    ) -> Result<(), Fault> {
        let Some((key, _)) = self.0.first() else {
            return Ok(());
        };
        let settings = protocol.map_or("", allowed_for);
        let allowed = match (allowed, settings) {
            ("", "") => "it without one".to_owned(),
            (one, "") | ("", one) => one.to_owned(),
            _ => format!("{allowed}; {settings}"),
        };
        let of = protocol.map_or(kind, Protocol::name);
        let message = format!("{of} has no option {key:?}");
        Err(Fault::new(message, format!("give {allowed}")))
    }
}

pub(super) fn wrong(key: &str, found: &str, allowed: &str) -> Fault {
    let message = format!("{key}={found:?} is not possible");
    Fault::new(message, format!("give {allowed}"))
}

pub(super) const FRAME: &str = "where +X, +Y and +Z point, such as forward,right,down: forward, back, left, \
                     right, up or down each, right-handed";

/// Returns the protocols that have settings, each with its settings for people.
pub fn settings() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = Protocol::NAMES.into_iter().filter_map(|name| {
        let protocol = Protocol::named(name)?;
        Some((name, allowed_for(&protocol)))
    });
    all.filter(|(_, settings)| !settings.is_empty())
}

const fn allowed_for(protocol: &Protocol) -> &'static str {
    match protocol {
        Protocol::Link | Protocol::AdHawk => "rate=HZ",
        Protocol::Fastrak(_) => {
            "items=2,11,0, format=binary|ascii, units=inches|cm, stations=N, reset_s=S, \
             word_metres=3, word_degrees=180, \
             frame=forward,right,down, sensor=forward,right,down"
        }
        Protocol::Liberty(_) => {
            "items=2,7,8,0, units=inches|cm, stations=N, model=liberty|patriot|latus, \
             records=CP|any, size=little|big|any, \
             frame=forward,right,down, sensor=forward,right,down"
        }
        Protocol::Flock(_) => {
            "format=position-quaternion|position-angles|position-matrix|quaternion|angles|matrix|\
             position, range=36|72|144, group=0|1, birds=N, first=N, inverse=1|0, confirm=0|1, \
             letter=C, run=F, half_turn=180, \
             frame=forward,right,down, sensor=forward,right,down"
        }
        Protocol::Hatire(_) => {
            "bytes=little|big, order=yaw,pitch,roll, position=none|cm, \
             frame=forward,right,down, sensor=forward,right,down"
        }
        Protocol::Iscan(_) => {
            "outputs=pupil-x,pupil-y,pupil-diameter,gaze-x,gaze-y (or other), largest=N, \
             zero=lost|point, confirm=0|1"
        }
        Protocol::Asl(_) => "layout=numbered|base, zero=lost|point",
        Protocol::EyeTracker(..) => "axes=right,up,back, origin=X,Y,Z",
        _ => "",
    }
}

pub(super) fn set(
    protocol: &mut Protocol,
    asked: &mut Asked,
    options: &mut Options<'_>,
) -> Result<(), Fault> {
    match protocol {
        Protocol::Link => options.number(&mut asked.rate, "rate", (1, u16::MAX), "1 to 65535 Hz"),
        Protocol::Fastrak(config) => set_fastrak(config, options),
        Protocol::Liberty(config) => set_liberty(config, options),
        Protocol::Flock(config) => set_flock(config, asked, options),
        Protocol::Hatire(config) => set_hatire(config, options),
        Protocol::Iscan(config) => set_iscan(config, options),
        Protocol::Asl(config) => {
            let layouts = [Layout::Numbered, Layout::Base];
            options.word(&mut config.layout, "layout", "numbered base", layouts)?;
            options.word(&mut config.zero_is_lost, "zero", "lost point", ZEROS)
        }
        Protocol::AdHawk => options.number(&mut asked.rate, "rate", (1_u16, 1_000), "1 to 1000 Hz"),
        Protocol::EyeTracker(_, axes) => set_axes(axes, options),
        _ => Ok(()),
    }
}

/// Whether zeros mean a lost eye, by the words lost and point.
const ZEROS: [bool; 2] = [true, false];

const UNITS: [Units; 2] = [Units::Inches, Units::Centimetres];

/// Sets the axes of a HID eye tracker, which its descriptor does not say.
pub(super) fn set_axes(
    axes: &mut eye_tracker::Axes,
    options: &mut Options<'_>,
) -> Result<(), Fault> {
    options.set(&mut axes.rotation, "axes", FRAME, directions)?;
    let metres = "three numbers of metres within ±10, such as 0,0.3,-0.5";
    options.set(&mut axes.origin, "origin", metres, |value| {
        let parts: Result<Vec<f32>, _> = value.split(',').map(str::parse).collect();
        let place = Vec3::from_array(parts.ok()?.try_into().ok()?);
        // NaN fails the comparison.
        (place.is_finite() && place.abs().max_element() <= 10.0).then_some(place)
    })
}

fn set_fastrak(config: &mut fastrak::Config, options: &mut Options<'_>) -> Result<(), Fault> {
    let mut format = config.items.format();
    let formats = [Format::Binary, Format::Ascii];
    options.word(&mut format, "format", "binary ascii", formats)?;
    set_items(&mut config.items, Family::Fastrak, format, options)?;
    options.word(&mut config.units, "units", "inches cm", UNITS)?;
    let range = (1, fastrak::MOST_STATIONS);
    options.number(&mut config.stations, "stations", range, "1 to 12")?;
    options.set(&mut config.reset_time, "reset_s", "0 to 60 s", |value| {
        let seconds: u64 = value.parse().ok()?;
        (seconds <= 60).then(|| Micros::from_millis(1_000 * seconds))
    })?;
    let (metres, degrees) = ((0.1_f32, 100.0), (1.0_f32, 360.0));
    let allowed = "the metres that are 1 in item 18, 0.1 to 100";
    options.number(&mut config.word_metres, "word_metres", metres, allowed)?;
    let allowed = "the degrees that are 1 in item 19, 1 to 360";
    options.number(&mut config.word_degrees, "word_degrees", degrees, allowed)?;
    set_frames(&mut config.axes, Some("forward,right,down"), options)
}

fn set_liberty(config: &mut liberty::Config, options: &mut Options<'_>) -> Result<(), Fault> {
    let format = config.items.format();
    set_items(&mut config.items, Family::Liberty, format, options)?;
    options.word(&mut config.units, "units", "inches cm", UNITS)?;
    let range = (1, liberty::MOST_STATIONS);
    options.number(&mut config.stations, "stations", range, "1 to 16")?;
    let models = [Model::Liberty, Model::Patriot, Model::Latus];
    options.word(&mut config.model, "model", "liberty patriot latus", models)?;
    let letters = "any, or the one or two printable characters that byte 3 of a record's header \
                   can be, such as CP";
    let read = |value: &str| match value.as_bytes() {
        b"any" => Some(None),
        &[one] if one.is_ascii_graphic() => Some(Some([one; 2])),
        &[one, two] if one.is_ascii_graphic() && two.is_ascii_graphic() => Some(Some([one, two])),
        _ => None,
    };
    options.set(&mut config.records, "records", letters, read)?;
    let sizes = [Size::LittleEndian, Size::BigEndian, Size::Unused];
    options.word(&mut config.size, "size", "little big any", sizes)?;
    set_frames(&mut config.axes, Some("forward,right,down"), options)
}

fn set_flock(
    config: &mut flock::Config,
    asked: &mut Asked,
    options: &mut Options<'_>,
) -> Result<(), Fault> {
    let modes = [
        Mode::PositionQuaternion,
        Mode::PositionAngles,
        Mode::PositionMatrix,
        Mode::Quaternion,
        Mode::Angles,
        Mode::Matrix,
        Mode::Position,
    ];
    let words =
        "position-quaternion position-angles position-matrix quaternion angles matrix position";
    options.word(&mut config.mode, "format", words, modes)?;
    let ranges = [Range::Inches36, Range::Inches72, Range::Inches144];
    options.word(&mut config.range, "range", "36 72 144", ranges)?;
    options.flag(&mut config.group, "group")?;
    let (most, allowed) = if config.group {
        (flock::MOST_BIRDS, "1 to 14")
    } else {
        (1, "1, or up to 14 with group=1")
    };
    options.number(&mut asked.birds, "birds", (1, most), allowed)?;
    options.number(&mut asked.first_bird, "first", (1, most), allowed)?;
    options.flag(&mut config.reversed, "inverse")?;
    let allowed = "the one character that chooses the format";
    options.set(&mut config.letter, "letter", allowed, character)?;
    let allowed = "the one character that wakes the birds";
    options.set(&mut config.run, "run", allowed, character)?;
    let allowed = "the degrees that an angle's 32768 stands for, 1 to 360";
    let degrees = (1.0_f32, 360.0);
    options.number(&mut config.half_turn, "half_turn", degrees, allowed)?;
    options.flag(&mut config.confirm, "confirm")?;
    set_frames(&mut config.axes, Some("forward,right,down"), options)
}

fn character(value: &str) -> Option<u8> {
    match *value.as_bytes() {
        [one] if one.is_ascii_graphic() => Some(one),
        _ => None,
    }
}

fn set_hatire(config: &mut hatire::Config, options: &mut Options<'_>) -> Result<(), Fault> {
    options.word(&mut config.big_endian, "bytes", "little big", [false, true])?;
    let allowed = "yaw, pitch and roll in the order of the frame, with - before those that grow \
                   the other way, such as pitch,-yaw,roll";
    let mut both = (config.order, config.reversed);
    options.set(&mut both, "order", allowed, angles)?;
    (config.order, config.reversed) = both;
    let translations = [Translation::None, Translation::Centimetres];
    options.word(&mut config.translation, "position", "none cm", translations)?;
    set_frames(&mut config.axes, Some("forward,right,down"), options)
}

/// Reads the places of yaw, pitch and roll, and whether each is reversed.
fn angles(value: &str) -> Option<([u8; 3], [bool; 3])> {
    let words: Vec<&str> = value.split(',').collect();
    let (mut order, mut reversed) = ([0; 3], [false; 3]);
    for (i, name) in ["yaw", "pitch", "roll"].into_iter().enumerate() {
        let of = |word: &&str| word.strip_prefix('-').unwrap_or(word) == name;
        let at = words.iter().position(of)?;
        (order[i], reversed[i]) = (at as u8, words[at].starts_with('-'));
    }
    (words.len() == 3).then_some((order, reversed))
}

fn set_iscan(config: &mut iscan::Config, options: &mut Options<'_>) -> Result<(), Fault> {
    let allowed = "1 to 6 of pupil-x, pupil-y, pupil-diameter, gaze-x, gaze-y and other, in the \
                   order of the record";
    options.set(&mut config.outputs, "outputs", allowed, |value| {
        let outputs: Option<Vec<Output>> = value.split(',').map(output).collect();
        Outputs::new(&outputs?).ok()
    })?;
    options.set(&mut config.largest_word, "largest", "1 to 1740", |value| {
        let largest: u16 = value.parse().ok()?;
        (1..=1_740).contains(&largest).then_some(10 * largest)
    })?;
    options.word(&mut config.zero_is_lost, "zero", "lost point", ZEROS)?;
    options.flag(&mut config.confirm, "confirm")
}

fn output(name: &str) -> Option<Output> {
    Some(match name {
        "pupil-x" => Output::PupilHorizontal,
        "pupil-y" => Output::PupilVertical,
        "pupil-diameter" => Output::PupilDiameter,
        "gaze-x" => Output::GazeHorizontal,
        "gaze-y" => Output::GazeVertical,
        "other" => Output::Other,
        _ => return None,
    })
}

fn set_items(
    items: &mut ItemList,
    family: Family,
    format: Format,
    options: &mut Options<'_>,
) -> Result<(), Fault> {
    let mut numbers: Vec<u8> = items.numbers().collect();
    let allowed = "numbers of items, such as 2,4,1";
    options.set(&mut numbers, "items", allowed, |value| {
        let numbers: Result<Vec<u8>, _> = value.split(',').map(str::parse).collect();
        numbers.ok()
    })?;
    *items = ItemList::new(family, format, &numbers).map_err(|reason| {
        let help = "the items are those of the device's manual, in the order that it is to send";
        Fault::new(format!("items: {reason}"), help)
    })?;
    Ok(())
}

/// Sets a device's axes. Without usual ones a frame is ours, and a sensor's are those of its frame.
pub(super) fn set_frames(
    axes: &mut Axes,
    usual: Option<&str>,
    options: &mut Options<'_>,
) -> Result<(), Fault> {
    let [mut frame, mut sensor] = [None, None];
    options.set(&mut frame, "frame", FRAME, directions)?;
    options.set(&mut sensor, "sensor", FRAME, directions)?;
    if frame.is_some() || sensor.is_some() {
        let usual = usual.and_then(directions);
        let frame: Quat = frame.or(usual).unwrap_or_default();
        let sensor = sensor.or(usual).unwrap_or(frame);
        // Both are rotations.
        *axes = Axes::new(frame, sensor).unwrap_or(*axes);
    }
    Ok(())
}

/// Reads the rotation that takes +X, +Y and +Z to three named directions.
pub(super) fn directions(value: &str) -> Option<Quat> {
    let word = |word: &str| {
        Some(match word {
            "right" => Vec3::X,
            "left" => Vec3::NEG_X,
            "up" => Vec3::Y,
            "down" => Vec3::NEG_Y,
            "back" => Vec3::Z,
            "forward" => Vec3::NEG_Z,
            _ => return None,
        })
    };
    let words: Option<Vec<Vec3>> = value.split(',').map(word).collect();
    let &[x, y, z] = words?.as_slice() else {
        return None;
    };
    (x.cross(y) == z && x.dot(y) == 0.0).then(|| Quat::from_mat3(&Mat3::from_cols(x, y, z)))
}

#[cfg(test)]
mod tests;
