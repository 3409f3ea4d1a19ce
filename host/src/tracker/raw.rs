//! The bytes of a tracker as they came, in a file, and through its decoder again.
//!
//! A file begins with the line `shisen raw 1` and a line with the tracker's SPEC. Pieces follow: a
//! byte that says what it is ([`Piece`]), the microseconds of its arrival in eight bytes, its length
//! in four, the lowest first, and its bytes.

use super::net::NetSpec;
use super::protocol::ProtocolSpec;
use super::spec::{Spec, TrackerKind};
use crate::files::Fault;
use shisen_tracker::decoder::{Counts, Decoder, DropReason, Dropped, Event};
use shisen_tracker::head::osvr_hdk::OsvrHdk;
use shisen_tracker::hid::eye_tracker::EyeTracker;
use shisen_tracker::net::natnet::{self, NatNet};
use shisen_tracker::net::vrpn::Vrpn;
use shisen_tracker::time::Micros;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

const FIRST_LINE: &[u8] = b"shisen raw 1\n";

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Piece {
    /// The device was opened: a HID device's report descriptor, or the version of `NatNet` and, where
    /// a body was named, its sensor.
    Opened,
    /// Bytes of the device.
    Came,
    /// The same while it is set up: their samples count for nothing.
    Early,
    /// Bytes that were sent to it.
    Sent,
}

impl Piece {
    const ALL: [Self; 4] = [Self::Opened, Self::Came, Self::Early, Self::Sent];
}

fn lock(taken: &Mutex<Vec<u8>>) -> MutexGuard<'_, Vec<u8>> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the bytes of a tracker, or none.
#[derive(Debug, Clone, Default)]
pub(super) struct Tap(Option<Arc<Mutex<Vec<u8>>>>);

impl Tap {
    pub(super) fn take(&self, piece: Piece, bytes: &[u8], at: Micros) {
        if let Self(Some(taken)) = self {
            let mut taken = lock(taken);
            taken.push(piece as u8);
            taken.extend_from_slice(&at.0.to_le_bytes());
            taken.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
            taken.extend_from_slice(bytes);
        }
    }
}

/// The bytes of a tracker until they are written.
#[derive(Debug)]
pub struct RawBytes(Arc<Mutex<Vec<u8>>>);

impl RawBytes {
    /// Returns the start of a file of a tracker's bytes, and the two ends of what follows.
    ///
    /// # Errors
    /// A tracker that is recorded in another way.
    pub(super) fn new(name: &str, spec: &Spec) -> Result<(Self, Tap), Fault> {
        let help = match &spec.kind {
            TrackerKind::Mock(mock) if mock.protocol.is_none() => {
                "give it a protocol, as in mock:as=fastrak, or leave --raw out"
            }
            TrackerKind::Replay(_) => "it is a recording already: copy it",
            TrackerKind::Net(NetSpec::Lsl(_)) => {
                "LabRecorder keeps streams of LSL; or leave --raw out"
            }
            TrackerKind::Net(NetSpec::Stdin | NetSpec::Lines(_)) => {
                "lines of text are kept by `tee`; or leave --raw out"
            }
            _ => "",
        };
        if !help.is_empty() {
            return Err(Fault::new(format!("{name} has no bytes to keep"), help));
        }
        let start = [FIRST_LINE, name.as_bytes(), b"\n"].concat();
        let taken = Arc::new(Mutex::new(start));
        Ok((Self(Arc::clone(&taken)), Tap(Some(taken))))
    }

    /// Returns what has come since the last call.
    pub fn take(&self) -> Vec<u8> {
        std::mem::take(&mut *lock(&self.0))
    }

    /// Writes what has come since the last call.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, to: &mut dyn Write) -> io::Result<()> {
        to.write_all(&self.take())
    }
}

/// Returns whether a file holds raw bytes.
pub(super) fn is_raw(bytes: &[u8]) -> bool {
    bytes.starts_with(b"shisen raw ")
}

/// Returns the events of a file, each with the counts then.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Vec<(Event, Counts)>, Fault> {
    let wrong = |what: &str, help: &str| Fault::new(format!("{}: {what}", path.display()), help);
    let other = || {
        wrong(
            "raw bytes of another version than 1",
            "record it again, or take the program that recorded it",
        )
    };
    let rest = bytes.strip_prefix(FIRST_LINE).ok_or_else(other)?;
    let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(0);
    let (name, rest) = rest.split_at(end);
    let spec: Spec = String::from_utf8_lossy(name).parse()?;
    let mut rest = rest.get(1..).unwrap_or_default();
    let mut events = Vec::new();
    let mut device: Option<Device> = None;
    let (mut before, mut last) = (Counts::new(), Micros(0));
    while let Some((piece, at, bytes, behind)) = next(rest) {
        last = at.max(last);
        match piece {
            Piece::Opened => {
                before = device.map_or(before, |device| before.plus(device.decoder.counts()));
                device = Some(Device::new(&spec, bytes)?);
            }
            Piece::Sent => {
                if let Some(device) = &mut device {
                    device.decoder.on_sent(bytes, last);
                }
            }
            Piece::Came | Piece::Early => {
                let device = device.get_or_insert(Device::new(&spec, &[])?);
                let mut came = Vec::new();
                device.feed(bytes, last, &mut came);
                let counts = before.plus(device.decoder.counts());
                came.retain(|event| piece == Piece::Came || !matches!(event, Event::Sample(_)));
                events.extend(came.into_iter().map(|event| (event, counts)));
            }
        }
        rest = behind;
    }
    if !rest.is_empty() {
        // The last piece was cut off.
        let mut counts = events.last().map_or(before, |(_, counts)| *counts);
        let (bytes, reason) = (rest.len() as u32, DropReason::Length);
        counts.dropped[reason as usize] += 1;
        counts.dropped_bytes += u64::from(bytes);
        events.push((Event::Dropped(Dropped { bytes, reason }), counts));
    }
    Ok(events)
}

/// Returns the first piece, when it came, its bytes, and those behind it.
fn next(bytes: &[u8]) -> Option<(Piece, Micros, &[u8], &[u8])> {
    let (&[kind], rest) = bytes.split_first_chunk()?;
    let (at, rest) = rest.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (bytes, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    let piece = *Piece::ALL.get(usize::from(kind))?;
    Some((piece, Micros(u64::from_le_bytes(*at)), bytes, rest))
}

/// A device whose bytes are decoded.
struct Device {
    decoder: Box<dyn Decoder + Send>,
    /// The sensor that is handed over; `None`: all.
    only: Option<u8>,
}

impl Device {
    /// Returns a device by its SPEC and by what it said of itself when it was opened.
    fn new(spec: &Spec, said: &[u8]) -> Result<Self, Fault> {
        let mut only = None;
        let decoder: Box<dyn Decoder + Send> = match &spec.kind {
            TrackerKind::Hid(_) if said.is_empty() => Box::new(OsvrHdk::new()),
            TrackerKind::Hid(hid) => {
                let tracker = EyeTracker::new(said, hid.axes);
                Box::new(tracker.map_err(|reason| {
                    let message = format!("the device's descriptor: {reason}");
                    Fault::new(message, "record it again")
                })?)
            }
            TrackerKind::Net(NetSpec::Vrpn { device, .. }) => Box::new(Vrpn::new(device.clone())),
            TrackerKind::Net(NetSpec::NatNet { axes, .. }) => {
                let (version, rest) = said.split_first_chunk::<2>().unzip();
                only = rest.and_then(|rest| rest.first().copied());
                Box::new(NatNet::new(natnet::Config {
                    version: version.copied(),
                    axes: *axes,
                }))
            }
            TrackerKind::Net(NetSpec::Datagrams { protocol, .. }) => protocol.decoder(),
            _ => {
                let protocol = spec.protocol().and_then(ProtocolSpec::decoder);
                protocol.ok_or_else(|| {
                    let help = "give a file that `shisen tracker record --raw` wrote";
                    Fault::new("the recorded SPEC has no bytes", help)
                })?
            }
        };
        Ok(Self { decoder, only })
    }

    fn feed(&mut self, bytes: &[u8], at: Micros, came: &mut Vec<Event>) {
        let only = self.only;
        self.decoder.feed(bytes, at, &mut |event| {
            let is_other = matches!(&event, Event::Sample(sample)
                if only.is_some_and(|only| only != sample.sensor));
            if !is_other {
                came.push(event);
            }
        });
    }
}
