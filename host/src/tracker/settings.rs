//! How a protocol's device is set up, as `key=value` of a `SPEC` says it.

use super::spec::SpecError;
use glam::{Mat3, Quat, Vec3};
use shisen_tracker::eye::asl;
use shisen_tracker::eye::iscan::{self, Output, Outputs};
use shisen_tracker::head::axes::Axes;
use shisen_tracker::head::flock::{self, Mode, Range};
use shisen_tracker::head::hatire::{self, Translation};
use shisen_tracker::head::liberty::{self, Model};
use shisen_tracker::head::polhemus::{Family, Format, ItemList, Units};
use shisen_tracker::head::{fastrak, polhemus};
use shisen_tracker::hid::eye_tracker;
use shisen_tracker::protocol::{Asked, Protocol};
use shisen_tracker::time::Micros;
use std::str::FromStr;

/// `key=value` between `&`, each key once, until they are taken.
pub(super) struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    /// # Errors
    /// A key that stands there twice.
    pub(super) fn read(text: &'a str) -> Result<Self, SpecError> {
        let mut options: Vec<(&str, &str)> = Vec::new();
        for part in text.split('&').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            if options.iter().any(|&(other, _)| other == key) {
                return Err(SpecError::Twice { key: key.into() });
            }
            options.push((key, value));
        }
        Ok(Self(options))
    }

    /// The value of a key, which then is gone.
    pub(super) fn take(&mut self, key: &str) -> Option<&'a str> {
        let at = self.0.iter().position(|&(other, _)| other == key)?;
        Some(self.0.remove(at).1)
    }

    /// A number within a range.
    ///
    /// # Errors
    /// Another value.
    pub(super) fn number<T: FromStr + PartialOrd>(
        &mut self,
        key: &'static str,
        range: (T, T),
        allowed: &'static str,
    ) -> Result<Option<T>, SpecError> {
        let (least, most) = range;
        self.one_of(key, allowed, |value| {
            let number = value.parse().ok();
            number.filter(|number| *number >= least && *number <= most)
        })
    }

    /// What `read` makes of a value.
    ///
    /// # Errors
    /// A value of which it makes nothing.
    pub(super) fn one_of<T>(
        &mut self,
        key: &'static str,
        allowed: &'static str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, SpecError> {
        let Some(value) = self.take(key) else {
            return Ok(None);
        };
        let known = read(value).ok_or_else(|| SpecError::Value {
            key,
            found: value.into(),
            allowed,
        });
        known.map(Some)
    }

    pub(super) fn flag(&mut self, key: &'static str) -> Result<Option<bool>, SpecError> {
        Ok(self
            .number(key, (0, 1), "0 or 1")?
            .map(|flag: u8| flag == 1))
    }

    /// Takes note that there should be no more.
    ///
    /// # Errors
    /// The first that is left, with those that there are: of the kind of
    /// tracker, and of its protocol.
    pub(super) fn end(
        self,
        kind: &'static str,
        allowed: &str,
        protocol: Option<&Protocol>,
    ) -> Result<(), SpecError> {
        let Some((key, _)) = self.0.first() else {
            return Ok(());
        };
        let (of, settings) = match protocol {
            Some(protocol) => (protocol.name(), allowed_for(protocol)),
            None => (kind, ""),
        };
        let lists = [allowed, settings]
            .into_iter()
            .filter(|list| !list.is_empty());
        let lists = lists.collect::<Vec<_>>().join("; ");
        Err(SpecError::Key {
            of,
            key: (*key).into(),
            allowed: if lists.is_empty() {
                "it without one".into()
            } else {
                lists
            },
        })
    }
}

const FRAME: &str = "where +X, +Y and +Z point, such as forward,right,down: forward, back, left, \
                     right, up or down each, right-handed";

/// Each protocol that has settings, and these, for a person.
pub fn settings() -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = Protocol::NAMES.into_iter().filter_map(|name| {
        let protocol = Protocol::named(name)?;
        Some((name, allowed_for(&protocol)))
    });
    all.filter(|(_, settings)| !settings.is_empty())
}

/// The settings of a protocol, for a person.
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

/// Takes the options that are a protocol's settings.
///
/// # Errors
/// A value that its setting cannot have.
pub(super) fn set(
    protocol: &mut Protocol,
    asked: &mut Asked,
    options: &mut Options<'_>,
) -> Result<(), SpecError> {
    match protocol {
        Protocol::Link => {
            let rate = options.number("rate", (1, u16::MAX), "1 to 65535 Hz")?;
            asked.rate = rate.or(asked.rate);
        }
        Protocol::Fastrak(config) => set_fastrak(config, options)?,
        Protocol::Liberty(config) => set_liberty(config, options)?,
        Protocol::Flock(config) => set_flock(config, asked, options)?,
        Protocol::Hatire(config) => set_hatire(config, options)?,
        Protocol::Iscan(config) => set_iscan(config, options)?,
        Protocol::Asl(config) => {
            let layout = options.one_of("layout", "numbered or base", |value| match value {
                "numbered" => Some(asl::Layout::Numbered),
                "base" => Some(asl::Layout::Base),
                _ => None,
            })?;
            config.layout = layout.unwrap_or(config.layout);
            config.zero_is_lost = zero(options)?.unwrap_or(config.zero_is_lost);
        }
        Protocol::AdHawk => {
            let rate = options.number("rate", (1, 1_000), "1 to 1000 Hz")?;
            asked.rate = rate.or(asked.rate);
        }
        Protocol::EyeTracker(_, axes) => set_axes(axes, options)?,
        _ => {}
    }
    Ok(())
}

/// The axes of a HID eye tracker, of which the descriptor says nothing.
///
/// # Errors
/// A value that its setting cannot have.
pub(super) fn set_axes(
    axes: &mut eye_tracker::Axes,
    options: &mut Options<'_>,
) -> Result<(), SpecError> {
    if let Some(rotation) = options.one_of("axes", FRAME, directions)? {
        axes.rotation = rotation;
    }
    let metres = "three numbers of metres within ±10, such as 0,0.3,-0.5";
    if let Some(origin) = options.one_of("origin", metres, |value| {
        let parts: Result<Vec<f32>, _> = value.split(',').map(str::parse).collect();
        let place = Vec3::from_array(parts.ok()?.try_into().ok()?);
        // NaN fails the comparison.
        (place.is_finite() && place.abs().max_element() <= 10.0).then_some(place)
    })? {
        axes.origin = origin;
    }
    Ok(())
}

fn set_fastrak(config: &mut fastrak::Config, options: &mut Options<'_>) -> Result<(), SpecError> {
    let format = options.one_of("format", "binary or ascii", |value| match value {
        "binary" => Some(Format::Binary),
        "ascii" => Some(Format::Ascii),
        _ => None,
    })?;
    set_items(&mut config.items, Family::Fastrak, format, options)?;
    config.units = units(options)?.unwrap_or(config.units);
    let stations = options.number("stations", (1, fastrak::MOST_STATIONS), "1 to 12")?;
    config.stations = stations.unwrap_or(config.stations);
    let reset = options.number("reset_s", (0_u64, 60), "0 to 60 s")?;
    if let Some(seconds) = reset {
        config.reset_time = Micros::from_millis(1_000 * seconds);
    }
    let metres = "the metres that are 1 in item 18, 0.1 to 100";
    let metres = options.number("word_metres", (0.1, 100.0), metres)?;
    config.word_metres = metres.unwrap_or(config.word_metres);
    let degrees = "the degrees that are 1 in item 19, 1 to 360";
    let degrees = options.number("word_degrees", (1.0, 360.0), degrees)?;
    config.word_degrees = degrees.unwrap_or(config.word_degrees);
    config.axes = frames(config.axes, options)?;
    Ok(())
}

fn set_liberty(config: &mut liberty::Config, options: &mut Options<'_>) -> Result<(), SpecError> {
    set_items(&mut config.items, Family::Liberty, None, options)?;
    config.units = units(options)?.unwrap_or(config.units);
    let stations = options.number("stations", (1, liberty::MOST_STATIONS), "1 to 16")?;
    config.stations = stations.unwrap_or(config.stations);
    let model = options.one_of("model", "liberty, patriot or latus", |value| match value {
        "liberty" => Some(Model::Liberty),
        "patriot" => Some(Model::Patriot),
        "latus" => Some(Model::Latus),
        _ => None,
    })?;
    config.model = model.unwrap_or(config.model);
    let letters = "any, or the one or two printable characters that byte 3 of a record's header \
                   can be, such as CP";
    let records = options.one_of("records", letters, |value| match value.as_bytes() {
        b"any" => Some(None),
        &[one] if one.is_ascii_graphic() => Some(Some([one; 2])),
        &[one, two] if one.is_ascii_graphic() && two.is_ascii_graphic() => Some(Some([one, two])),
        _ => None,
    })?;
    config.records = records.unwrap_or(config.records);
    let size = options.one_of("size", "little, big or any", |value| match value {
        "little" => Some(liberty::Size::LittleEndian),
        "big" => Some(liberty::Size::BigEndian),
        "any" => Some(liberty::Size::Unused),
        _ => None,
    })?;
    config.size = size.unwrap_or(config.size);
    config.axes = frames(config.axes, options)?;
    Ok(())
}

fn set_flock(
    config: &mut flock::Config,
    asked: &mut Asked,
    options: &mut Options<'_>,
) -> Result<(), SpecError> {
    let modes = "position-quaternion, position-angles, position-matrix, quaternion, angles, matrix \
                 or position";
    let mode = options.one_of("format", modes, |value| {
        Some(match value {
            "position-quaternion" => Mode::PositionQuaternion,
            "position-angles" => Mode::PositionAngles,
            "position-matrix" => Mode::PositionMatrix,
            "quaternion" => Mode::Quaternion,
            "angles" => Mode::Angles,
            "matrix" => Mode::Matrix,
            "position" => Mode::Position,
            _ => return None,
        })
    })?;
    config.mode = mode.unwrap_or(config.mode);
    let range = options.one_of("range", "36, 72 or 144 (inches)", |value| match value {
        "36" => Some(Range::Inches36),
        "72" => Some(Range::Inches72),
        "144" => Some(Range::Inches144),
        _ => None,
    })?;
    config.range = range.unwrap_or(config.range);
    config.group = options.flag("group")?.unwrap_or(config.group);
    let (most, allowed) = if config.group {
        (flock::MOST_BIRDS, "1 to 14")
    } else {
        (1, "1, or up to 14 with group=1")
    };
    let birds = options.number("birds", (1, most), allowed)?;
    asked.birds = birds.unwrap_or(asked.birds);
    let first = options.number("first", (1, most), allowed)?;
    asked.first_bird = first.unwrap_or(asked.first_bird);
    config.reversed = options.flag("inverse")?.unwrap_or(config.reversed);
    let letter = options.one_of(
        "letter",
        "the one character that chooses the format",
        character,
    )?;
    config.letter = letter.or(config.letter);
    let run = options.one_of("run", "the one character that wakes the birds", character)?;
    config.run = run.unwrap_or(config.run);
    let degrees = "the degrees that an angle's 32768 stands for, 1 to 360";
    let half_turn = options.number("half_turn", (1.0, 360.0), degrees)?;
    config.half_turn = half_turn.unwrap_or(config.half_turn);
    config.confirm = options.flag("confirm")?.unwrap_or(config.confirm);
    config.axes = frames(config.axes, options)?;
    Ok(())
}

/// A command of one character.
fn character(value: &str) -> Option<u8> {
    match *value.as_bytes() {
        [one] if one.is_ascii_graphic() => Some(one),
        _ => None,
    }
}

fn set_hatire(config: &mut hatire::Config, options: &mut Options<'_>) -> Result<(), SpecError> {
    let order = options.one_of("bytes", "little or big", |value| match value {
        "little" => Some(false),
        "big" => Some(true),
        _ => None,
    })?;
    config.big_endian = order.unwrap_or(config.big_endian);
    let allowed = "yaw, pitch and roll in the order of the frame, with - before those that grow \
                   the other way, such as pitch,-yaw,roll";
    if let Some((order, reversed)) = options.one_of("order", allowed, angles)? {
        (config.order, config.reversed) = (order, reversed);
    }
    let translation = options.one_of("position", "none or cm", |value| match value {
        "none" => Some(Translation::None),
        "cm" => Some(Translation::Centimetres),
        _ => None,
    })?;
    config.translation = translation.unwrap_or(config.translation);
    config.axes = frames(config.axes, options)?;
    Ok(())
}

/// At which place yaw, pitch and roll stand, and whether they are reversed.
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

fn set_iscan(config: &mut iscan::Config, options: &mut Options<'_>) -> Result<(), SpecError> {
    let allowed = "1 to 6 of pupil-x, pupil-y, pupil-diameter, gaze-x, gaze-y and other, in the \
                   order of the record";
    let outputs = options.one_of("outputs", allowed, |value| {
        let outputs: Option<Vec<Output>> = value.split(',').map(output).collect();
        Outputs::new(&outputs?).ok()
    })?;
    config.outputs = outputs.unwrap_or(config.outputs);
    let largest = options.number("largest", (1_u16, 1_740), "1 to 1740")?;
    config.largest_word = largest.map_or(config.largest_word, |largest| 10 * largest);
    config.zero_is_lost = zero(options)?.unwrap_or(config.zero_is_lost);
    config.confirm = options.flag("confirm")?.unwrap_or(config.confirm);
    Ok(())
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

fn zero(options: &mut Options<'_>) -> Result<Option<bool>, SpecError> {
    options.one_of("zero", "lost or point", |value| match value {
        "lost" => Some(true),
        "point" => Some(false),
        _ => None,
    })
}

fn units(options: &mut Options<'_>) -> Result<Option<Units>, SpecError> {
    options.one_of("units", "inches or cm", |value| match value {
        "inches" => Some(Units::Inches),
        "cm" => Some(Units::Centimetres),
        _ => None,
    })
}

fn set_items(
    items: &mut ItemList,
    family: Family,
    format: Option<polhemus::Format>,
    options: &mut Options<'_>,
) -> Result<(), SpecError> {
    let numbers = options.one_of("items", "numbers of items, such as 2,4,1", |value| {
        let numbers: Result<Vec<u8>, _> = value.split(',').map(str::parse).collect();
        numbers.ok()
    })?;
    let numbers = numbers.unwrap_or_else(|| items.numbers().collect());
    let format = format.unwrap_or(items.format());
    *items = ItemList::new(family, format, &numbers)?;
    Ok(())
}

/// Where the axes of the device and of its sensor point.
fn frames(usual: Axes, options: &mut Options<'_>) -> Result<Axes, SpecError> {
    let frame = options.one_of("frame", FRAME, directions)?;
    let sensor = options.one_of("sensor", FRAME, directions)?;
    if frame.is_none() && sensor.is_none() {
        return Ok(usual);
    }
    let forward_right_down = || directions("forward,right,down").unwrap_or_default();
    let [frame, sensor] = [frame, sensor].map(|turn| turn.unwrap_or_else(forward_right_down));
    // Both are rotations.
    Ok(Axes::new(frame, sensor).unwrap_or(usual))
}

/// The rotation that takes +X, +Y and +Z to three named directions.
fn directions(value: &str) -> Option<Quat> {
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
