//! `OptiTrack` `NatNet` 3 and 4: rigid bodies, of Motive and others.
//!
//! # The connection
//!
//! Send [`CONNECT`] to UDP port [`COMMAND_PORT`]; the answer says the version, without which no frame
//! can be read, and the clock's rate. Frames come to UDP port [`DATA_PORT`] of the multicast group
//! [`GROUP`], or, with unicast, to the socket that sent [`CONNECT`], which then sends [`KEEP_ALIVE`] once
//! a second. Hand every datagram of either socket to [`NatNet`]. For the clock's offset send an
//! [`echo_request`] and read its answer by [`read_echo`]; for the bodies' names send
//! [`BODIES_REQUEST`] and read its answer by [`read_bodies`].
//!
//! # Wire format
//!
//! All numbers are little-endian. A datagram is u16 kind, u16 length of the rest; a frame, of kind
//! 7, is i32 number and sections of i32 count (from 4.1 on then i32 bytes) and items: marker sets,
//! markers, rigid bodies, skeletons, from 4.1 on assets, labelled markers, force plates, devices.
//! A rigid body is i32 id, f32 x, y, z, qx, qy, qz, qw, error, i16 whose bit 0 says that it is
//! tracked. Behind the sections are u32 timecode twice, f64 seconds, u64 ticks at mid exposure,
//! received, sent, from 4.0 or 4.1 on u64 precision time, i16 and i32.
//!
//! A body is a sample's sensor by its id; those above 255 are skipped. One that is not tracked is
//! a sample without a head. The time is that of mid exposure, or the software's where the cameras
//! do not know it. Metres; +Y is up unless Motive is set otherwise: [`Config::axes`].
//!
//! There is no check beside the lengths, which must agree to the byte.

use super::{Numbers, count_bytes, hand_over, rotation};
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::head::axes::Axes;
use crate::link::body::Body;
use crate::sample::{Reading, Sample};
use crate::time::{DeviceTime, Micros};
use crate::valid;
use glam::Quat;

/// The UDP port of commands.
pub const COMMAND_PORT: u16 = 1_510;
/// The UDP port of frames.
pub const DATA_PORT: u16 = 1_511;
/// The usual multicast group of frames.
pub const GROUP: [u8; 4] = [239, 255, 42, 99];
/// The datagram that asks the server for its version, and for frames by unicast.
pub const CONNECT: [u8; 4] = [0; 4];
/// The datagram that keeps frames coming by unicast.
pub const KEEP_ALIVE: [u8; 4] = [10, 0, 0, 0];

/// The datagram that asks for the names of rigid bodies.
pub const BODIES_REQUEST: [u8; 8] = [4, 0, 4, 0, 2, 0, 0, 0];

const SERVER_INFO: u16 = 1;
const MODELS: u16 = 5;
/// Kinds of models.
const MARKER_SET: u32 = 0;
const RIGID_BODY: u32 = 1;
const SKELETON: u32 = 2;
const FRAME: u16 = 7;
const ECHO_REQUEST: u8 = 12;
const ECHO_RESPONSE: u16 = 13;

/// How a server is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// The major and minor version, where it is known before the server says it.
    pub version: Option<[u8; 2]>,
    /// The server's axes, and the bodies'.
    pub axes: Axes,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            version: None,
            axes: Axes::SAME,
        }
    }
}

/// Returns the datagram that asks for the server's ticks; `sent` comes back with them.
pub fn echo_request(sent: Micros) -> [u8; 12] {
    let mut datagram = [ECHO_REQUEST, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let (_, time) = datagram.split_at_mut(4);
    for (to, from) in time.iter_mut().zip(sent.0.to_le_bytes()) {
        *to = from;
    }
    datagram
}

/// Reads an answer to [`echo_request`]: the time that was sent, and the server's ticks.
pub fn read_echo(datagram: &[u8]) -> Option<(Micros, u64)> {
    let (ECHO_RESPONSE, mut body) = payload(datagram).ok()? else {
        return None;
    };
    let (sent, ticks) = (body.u64().ok()?, body.u64().ok()?);
    body.end().ok()?;
    Some((Micros(sent), ticks))
}

/// Reads an answer to [`BODIES_REQUEST`] of a server of this version: hands each rigid body's name
/// and id to `sink`.
///
/// # Errors
/// A datagram of another kind, one that is cut, and models before the last body that are not read.
pub fn read_bodies(
    datagram: &[u8],
    version: [u8; 2],
    sink: &mut dyn FnMut(&str, u32),
) -> Result<(), DropReason> {
    let (MODELS, mut body) = payload(datagram)? else {
        return Err(DropReason::Unknown);
    };
    for _ in 0..count(&mut body, 4)? {
        let kind = body.u32()?;
        let sized = if version >= [4, 1] {
            let bytes = body.u32()? as usize;
            Some(Body(skip(&mut body, bytes)?))
        } else {
            None
        };
        let mut whole = sized;
        let model = whole.as_mut().unwrap_or(&mut body);
        match kind {
            MARKER_SET => {
                name(model)?;
                for _ in 0..count(model, 1)? {
                    name(model)?;
                }
            }
            RIGID_BODY => {
                let (name, id) = read_model(model, version)?;
                sink(name, id);
            }
            _ if version >= [4, 1] => {}
            SKELETON => {
                name(model)?;
                model.u32()?;
                for _ in 0..count(model, 1)? {
                    read_model(model, version)?;
                }
            }
            _ => return Err(DropReason::Unknown),
        }
    }
    Ok(())
}

/// Takes a rigid body's description; returns its name and id.
fn read_model<'a>(body: &mut Body<'a>, version: [u8; 2]) -> Result<(&'a str, u32), DropReason> {
    let own = name(body)?;
    let id = body.u32()?;
    // The parent and the offset from it.
    skip(body, if version >= [4, 2] { 32 } else { 16 })?;
    let markers = count(body, 16)?;
    skip(body, 16 * markers)?;
    if version >= [4, 0] {
        for _ in 0..markers {
            name(body)?;
        }
    }
    Ok((own, id))
}

/// Takes a text and the zero byte after it.
fn name<'a>(body: &mut Body<'a>) -> Result<&'a str, DropReason> {
    let end = body.0.iter().position(|&byte| byte == 0);
    let text = skip(body, end.ok_or(DropReason::Length)?)?;
    skip(body, 1)?;
    core::str::from_utf8(text).map_err(|_| DropReason::Field)
}

/// Returns a datagram's kind and the rest.
fn payload(datagram: &[u8]) -> Result<(u16, Body<'_>), DropReason> {
    let mut body = Body(datagram);
    let kind = u16::from_le_bytes(body.take()?);
    let length = u16::from_le_bytes(body.take()?);
    if usize::from(length) == body.0.len() {
        Ok((kind, body))
    } else {
        Err(DropReason::Length)
    }
}

/// Decodes the datagrams of one server.
#[derive(Debug, Clone, Default)]
pub struct NatNet {
    config: Config,
    counts: Counts,
    numbers: Numbers,
    version: Option<[u8; 2]>,
    ticks_per_second: u64,
    multicast: Option<([u8; 4], u16)>,
}

impl NatNet {
    /// Returns a decoder of a server that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            version: config.version,
            ..Self::default()
        }
    }

    /// Returns the major and minor version, once it is known.
    pub const fn version(&self) -> Option<[u8; 2]> {
        self.version
    }

    /// Returns the rate of the clock of [`read_echo`]; 0: not known.
    pub const fn ticks_per_second(&self) -> u64 {
        self.ticks_per_second
    }

    /// Returns the group and the UDP port to which frames are sent by multicast; `None` where they
    /// are sent to the socket that asked, or the server has not said it.
    pub const fn multicast(&self) -> Option<([u8; 4], u16)> {
        self.multicast
    }

    fn read_server(&mut self, mut body: Body<'_>) -> Result<(), DropReason> {
        let _: [u8; 260] = body.take()?;
        let [major, minor, _, _] = body.take()?;
        if !(3..=4).contains(&major) {
            return Err(DropReason::Unknown);
        }
        let ticks = body.u64()?;
        let port = u16::from_le_bytes(body.take()?);
        let [is_multicast] = body.take()?;
        let group = body.take()?;
        self.multicast = (is_multicast == 1).then_some((group, port));
        self.ticks_per_second = ticks;
        self.version = Some([major, minor]);
        Ok(())
    }

    fn device_time(&self, end: &End) -> Option<DeviceTime> {
        let known = self.ticks_per_second > 0 && end.exposure > 0;
        let seconds = if known {
            end.exposure as f64 / self.ticks_per_second as f64
        } else {
            end.seconds
        };
        let is_time = (0.0..9e9).contains(&seconds);
        is_time.then(|| DeviceTime::unwrapped((seconds * 1e6 + 0.5) as u64))
    }
}

impl Decoder for NatNet {
    /// Takes one whole datagram.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        let axes = self.config.axes;
        let read = match (payload(bytes), self.version) {
            (Err(reason), _) => Err(reason),
            (Ok((SERVER_INFO, body)), _) => self.read_server(body),
            (Ok((FRAME, _)), None) => Err(DropReason::Unknown),
            (Ok((FRAME, body)), Some(version)) => {
                let checked = read_frame(body.0, version, &mut |_| Ok(()));
                checked.and_then(|end| {
                    if !self.numbers.is_new(end.number, &mut self.counts) {
                        return Err(DropReason::Duplicate);
                    }
                    let sample = Sample {
                        device_time: self.device_time(&end),
                        sequence: Some(end.number),
                        ..Sample::arrived(arrival)
                    };
                    hand_over(&mut self.counts, bytes.len(), sink, |sink| {
                        read_frame(body.0, version, &mut |item| {
                            if let Some(sample) = read_body(item, sample, &axes)? {
                                sink(Event::Sample(sample));
                            }
                            Ok(())
                        })
                    });
                    Ok(())
                })
            }
            // Answers of other kinds.
            _ => Ok(()),
        };
        if let Err(reason) = read {
            hand_over(&mut self.counts, bytes.len(), sink, |_| {
                Err::<(), _>(reason)
            });
        }
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn reset(&mut self) {
        let counts = self.counts;
        *self = Self::new(self.config);
        self.counts = counts;
    }
}

/// The first and the last fields of a frame.
struct End {
    number: u32,
    seconds: f64,
    exposure: u64,
}

/// Reads a rigid body; `None` for one whose id is no sensor's.
fn read_body(item: &[u8], sample: Sample, axes: &Axes) -> Result<Option<Sample>, DropReason> {
    let mut item = Body(item);
    let Ok(sensor) = u8::try_from(item.u32()?) else {
        return Ok(None);
    };
    let mut sample = Sample { sensor, ..sample };
    let values = item.0.first_chunk::<28>().ok_or(DropReason::Length)?;
    let is_tracked = item.0.get(32).is_some_and(|flags| flags & 1 != 0);
    if is_tracked {
        let mut values = Body(values);
        let place = valid::position(values.vector()?)?;
        let turn = values.vector()?;
        let turn = rotation(Quat::from_xyzw(turn.x, turn.y, turn.z, values.number()?))?;
        sample.head.position = Some(Reading::tracked(axes.position(place)));
        sample.head.orientation = Some(Reading::tracked(axes.orientation(turn)));
    }
    Ok(Some(sample))
}

/// Takes so many bytes.
fn skip<'a>(body: &mut Body<'a>, bytes: usize) -> Result<&'a [u8], DropReason> {
    let (taken, rest) = body.0.split_at_checked(bytes).ok_or(DropReason::Length)?;
    body.0 = rest;
    Ok(taken)
}

/// Takes a count of items of at least `least` bytes each, which must be there.
fn count(body: &mut Body<'_>, least: usize) -> Result<usize, DropReason> {
    let count = body.u32()? as usize;
    if count <= body.0.len() / least {
        Ok(count)
    } else {
        Err(DropReason::Length)
    }
}

/// Takes a section: its bytes' number is known from version 4.1 on; before, `items` finds its end.
fn section<'a>(
    body: &mut Body<'a>,
    is_sized: bool,
    items: impl FnOnce(&mut Body<'a>, usize) -> Result<(), DropReason>,
) -> Result<(), DropReason> {
    if !is_sized {
        let count = count(body, 4)?;
        return items(body, count);
    }
    let (count, bytes) = (body.u32()? as usize, body.u32()? as usize);
    let mut section = Body(skip(body, bytes)?);
    if count > bytes / 4 {
        return Err(DropReason::Length);
    }
    items(&mut section, count)
}

/// Reads a frame of this version and hands the bytes of each rigid body to `sink`.
fn read_frame(
    frame: &[u8],
    version: [u8; 2],
    sink: &mut dyn FnMut(&[u8]) -> Result<(), DropReason>,
) -> Result<End, DropReason> {
    /// Bytes of a position, a rigid body, a labelled marker.
    const POINT: usize = 12;
    const BODY: usize = 38;
    const LABELLED: usize = 26;
    let is_sized = version >= [4, 1];
    let mut body = Body(frame);
    let number = body.u32()?;
    section(&mut body, is_sized, |sets, sets_count| {
        for _ in 0..sets_count {
            name(sets)?;
            let markers = count(sets, POINT)?;
            skip(sets, markers * POINT)?;
        }
        Ok(())
    })?;
    section(&mut body, is_sized, |points, count| {
        skip(points, count.saturating_mul(POINT)).map(|_| ())
    })?;
    section(&mut body, is_sized, |bodies, count| {
        for _ in 0..count {
            sink(skip(bodies, BODY)?)?;
        }
        // Without its size a section ends with its last item.
        if is_sized { bodies.end() } else { Ok(()) }
    })?;
    section(&mut body, is_sized, |skeletons, all| {
        for _ in 0..all {
            skip(skeletons, 4)?;
            let bones = count(skeletons, BODY)?;
            skip(skeletons, bones * BODY)?;
        }
        Ok(())
    })?;
    if is_sized {
        // The assets.
        section(&mut body, is_sized, |_, _| Ok(()))?;
    }
    section(&mut body, is_sized, |markers, count| {
        skip(markers, count.saturating_mul(LABELLED)).map(|_| ())
    })?;
    for _plates_then_devices in 0..2 {
        section(&mut body, is_sized, |devices, all| {
            for _ in 0..all {
                skip(devices, 4)?;
                for _ in 0..count(devices, 4)? {
                    let values = count(devices, 4)?;
                    skip(devices, values * 4)?;
                }
            }
            Ok(())
        })?;
    }
    skip(&mut body, 8)?;
    let seconds = f64::from_le_bytes(body.take()?);
    let exposure = body.u64()?;
    skip(&mut body, 16)?;
    // With the precision time, or without.
    match body.0.len() {
        6 | 14 => Ok(End {
            number,
            seconds,
            exposure,
        }),
        _ => Err(DropReason::Length),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::net::capture::{faults, packets, rows};
    use crate::testing::{dropped, samples};
    use std::string::ToString;
    use std::vec::Vec;

    macro_rules! capture {
        ($version:literal) => {
            (
                &include_bytes!(concat!("captures/natnet-", $version, "-made.cap"))[..],
                include_str!(concat!("captures/natnet-", $version, "-made.csv")),
            )
        };
    }

    #[test]
    fn frames_of_each_version_are_read() {
        for ((capture, table), version) in [
            (capture!("3.1"), [3, 1]),
            (capture!("4.0"), [4, 0]),
            (capture!("4.1"), [4, 1]),
        ] {
            let packets = packets(capture);
            let received = packets.iter().filter(|packet| packet.to_client);
            let mut decoder = NatNet::default();
            let (mut seen, mut named) = (Vec::new(), Vec::new());
            for packet in received {
                if let Some((_, ticks)) = read_echo(packet.bytes) {
                    assert!(ticks > 0);
                }
                let mut bodies = Vec::new();
                let models = read_bodies(packet.bytes, version, &mut |name, id| {
                    bodies.push((name.to_string(), id));
                });
                if models.is_ok() {
                    named = bodies;
                    let cut = &packet.bytes[..packet.bytes.len() - 1];
                    assert!(read_bodies(cut, version, &mut |_, _| {}).is_err());
                }
                seen.extend(samples(&mut decoder, packet.bytes));
            }
            assert_eq!(decoder.version(), Some(version));
            assert_eq!(named, [("HeadTracker".to_string(), 1)]);
            assert_eq!(decoder.counts().dropped_bytes, 0);
            let table = rows(table);
            assert_eq!(seen.len(), table.len());
            for (sample, row) in seen.iter().zip(table) {
                let numbers: Vec<f64> = row.iter().map(|field| field.parse().unwrap()).collect();
                let ids = (sample.sequence, f64::from(sample.sensor));
                assert_eq!(ids, (Some(numbers[0] as u32), numbers[5]));
                let time = numbers[2] / decoder.ticks_per_second() as f64 * 1e6;
                let device_time = sample.device_time.unwrap().microseconds as f64;
                assert!((device_time - time).abs() < 1.0, "{row:?}");
                assert_eq!(sample.head.position.is_some(), numbers[6] == 1.0);
                if let (Some(place), Some(turn)) = (sample.head.position, sample.head.orientation) {
                    let found = place
                        .value
                        .to_array()
                        .into_iter()
                        .chain(turn.value.to_array());
                    let off = found.zip(&numbers[7..]);
                    assert!(
                        off.map(|(a, b)| (f64::from(a) - b).abs())
                            .all(|off| off < 1e-6)
                    );
                }
            }
            // Frames without a version, of another, twice, and with any one fault.
            let frames = packets
                .iter()
                .filter(|packet| packet.to_client && packet.flow == 1);
            let frames: Vec<&[u8]> = frames.map(|packet| packet.bytes).collect();
            assert_eq!(
                dropped(&mut NatNet::default(), frames[0]),
                [DropReason::Unknown]
            );
            let new = |version| {
                let version = Some(version);
                NatNet::new(Config {
                    version,
                    ..Config::default()
                })
            };
            let other = if version == [4, 1] { [4, 0] } else { [4, 1] };
            assert_eq!(dropped(&mut new(other), frames[0]), [DropReason::Length]);
            let mut twice = new(version);
            let reasons = [0, 0].map(|n: usize| dropped(&mut twice, frames[n]));
            assert_eq!(reasons.concat(), [DropReason::Duplicate]);
            faults(|| new(version), &frames[3..6]);
        }
    }
}
