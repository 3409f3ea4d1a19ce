//! From samples to the bytes that a device would have sent for them.

use super::faults::{Chunk, Source};
use crate::decoder::Message;
use crate::estimate::{Screen, plane_of};
use crate::eye::{adhawk, asl, iscan};
use crate::head::hatire::Translation;
use crate::head::{fastrak, liberty, osvr_hdk};
use crate::hid::eye_tracker::{self, documented};
use crate::link;
use crate::protocol::Protocol;
use crate::rotation::{compose, inverse, rotate};
use crate::sample::{GazePoint, Pupil, Reading, Sample};
use crate::time::Micros;
use glam::{Vec2, Vec3};
use shisen_core::numeric::normalize;

/// Raw units of straight ahead, for trackers that need a calibration.
pub const RAW_CENTRE: Vec2 = Vec2::new(850.0, 850.0);
/// Raw units for each metre on the plane one metre ahead; y counts down.
pub const RAW_PER_METRE: f32 = 600.0;
/// A pupil in raw units.
const RAW_PUPIL: f32 = 400.0;

impl Protocol {
    /// Returns whether a sample has the pose or the gaze that this protocol's records hold.
    pub fn carries(&self, sample: &Sample) -> bool {
        let head = &sample.head;
        let pose = |position: bool, orientation: bool| {
            (head.position.is_some() || !position) && (head.orientation.is_some() || !orientation)
        };
        let looks = || direction(sample).is_some() || sample.gaze_point.is_some();
        match self {
            Self::Link => true,
            Self::Fastrak(fastrak::Config { items, .. })
            | Self::Liberty(liberty::Config { items, .. }) => {
                pose(items.has_position(), items.has_orientation())
            }
            Self::Flock(config) => pose(config.mode.has_position(), config.mode.has_orientation()),
            Self::Hatire(config) => pose(config.translation != Translation::None, true),
            Self::OsvrHdk => pose(false, true),
            Self::Iscan(_) | Self::Asl(_) => looks(),
            Self::AdHawk => direction(sample).is_some(),
            Self::EyeTracker(..) => looks() || head.position.is_some(),
        }
    }

    /// Returns whether its records can say that a value is not tracked; otherwise none is sent.
    pub const fn says_untracked(&self) -> bool {
        !matches!(self, Self::Flock(_) | Self::Hatire(_) | Self::OsvrHdk)
    }
}

/// A source of bytes, made of a source of samples.
#[derive(Debug, Clone)]
pub struct Wire<S> {
    source: S,
    protocol: Protocol,
    link: link::Encoder,
}

impl<S: Source<Item = Sample>> Wire<S> {
    /// Returns the bytes of `source`'s samples in a protocol.
    pub fn new(source: S, protocol: Protocol) -> Self {
        Self {
            source,
            protocol,
            link: link::Encoder::new(),
        }
    }

    /// Returns the source of the samples.
    pub fn source(&mut self) -> &mut S {
        &mut self.source
    }

    /// Returns how they are written.
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Writes them so from now on, as a device does that was told to.
    pub fn set_protocol(&mut self, protocol: Protocol) {
        self.protocol = protocol;
    }

    /// Returns the bytes of a sample: a record, packet or report. `None`: the protocol has none for
    /// it.
    pub fn encode(&mut self, sample: &Sample) -> Option<Chunk> {
        if !self.protocol.says_untracked() && !self.protocol.carries(sample) {
            return None;
        }
        let chunk = |bytes: &[u8]| Some(Chunk::new(sample.arrival, bytes));
        match &self.protocol {
            Protocol::Link => chunk(&self.link.sample(sample)),
            Protocol::Fastrak(config) => chunk(&config.encode(sample)),
            Protocol::Liberty(config) => chunk(&config.encode(sample)),
            Protocol::Flock(config) => chunk(&config.encode(sample)),
            Protocol::Hatire(config) => chunk(&config.encode(sample)),
            Protocol::OsvrHdk => {
                let turn = sample.head.orientation?.value;
                let sequence = sample.sequence.unwrap_or(0) as u8;
                chunk(&osvr_hdk::encode(&osvr_hdk::Report::of_head(
                    sequence, turn,
                )))
            }
            Protocol::Iscan(config) => chunk(&iscan::encode(&raw(sample), config)),
            Protocol::Asl(config) => chunk(&asl::encode(&raw(sample), config.layout)),
            Protocol::AdHawk => chunk(&adhawk::encode(sample)?),
            Protocol::EyeTracker(screen, axes) => {
                let seen = in_axes(&on_screen(sample, screen), axes);
                chunk(&documented::tracking(&seen))
            }
        }
    }
}

impl<S> Wire<S> {
    /// Returns the bytes of a message at `now`; `None` where the protocol has none for it.
    pub(super) fn encode_message(&mut self, message: &Message, now: Micros) -> Option<Chunk> {
        match (&self.protocol, message) {
            (Protocol::Link, message) => Some(Chunk::new(now, &self.link.message(message))),
            (Protocol::AdHawk, Message::Eyes(event)) => {
                Some(Chunk::new(now, &adhawk::encode_event(event)))
            }
            _ => None,
        }
    }
}

impl<S: Source<Item = Sample>> Source for Wire<S> {
    type Item = Chunk;

    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        while let Some(sample) = self.source.poll(until) {
            if let Some(chunk) = self.encode(&sample) {
                return Some(chunk);
            }
        }
        None
    }
}

/// Returns where both eyes together look, in their frame.
fn direction(sample: &Sample) -> Option<Vec3> {
    let of = |eye: &crate::sample::Eye| eye.direction.map(|direction| direction.value);
    of(&sample.combined).or_else(|| match (of(&sample.left), of(&sample.right)) {
        (Some(left), Some(right)) => normalize(left + right),
        (left, right) => left.or(right),
    })
}

/// Returns the sample of a tracker that sees one eye and knows no directions.
fn raw(sample: &Sample) -> Sample {
    let mut raw = *sample;
    if raw.gaze_point.is_none() {
        raw.gaze_point = direction(sample).and_then(plane_of).map(|place| {
            let turned = Vec2::new(place.x, -place.y);
            Reading::tracked(GazePoint::Raw(RAW_CENTRE + turned * RAW_PER_METRE))
        });
    }
    raw.combined.pupil = raw.gaze_point.map(|_| Pupil::Raw(RAW_PUPIL));
    raw
}

/// Returns the sample of a tracker under a screen: eyes in its own frame, and a point on the
/// screen.
fn on_screen(sample: &Sample, screen: &Screen) -> Sample {
    let mut seen = *sample;
    let head = sample.head.position.zip(sample.head.orientation);
    let Some((position, orientation)) = head else {
        return seen;
    };
    let place = |of_head: Vec3| position.value + rotate(orientation.value, of_head);
    for eye in [&mut seen.left, &mut seen.right] {
        eye.origin = eye.origin.map(|origin| Reading {
            value: place(origin.value),
            ..origin
        });
    }
    seen.gaze_point = direction(sample).and_then(|direction| {
        let way = rotate(orientation.value, direction);
        let normal = screen.right.cross(screen.down);
        let distance = normal.dot(screen.corner - position.value) / normal.dot(way);
        let place = position.value + way * distance - screen.corner;
        let point = Vec2::new(place.dot(screen.right), place.dot(screen.down));
        // Farther than this the report has no numbers.
        let there = distance > 0.0 && point.abs().max_element() < FARTHEST;
        there.then_some(Reading::tracked(GazePoint::Plane(point)))
    });
    seen
}

/// The farthest point that a report has numbers for: metres.
const FARTHEST: f32 = 2.0;

/// Returns the sample in the coordinates of a device that has these axes.
fn in_axes(sample: &Sample, axes: &eye_tracker::Axes) -> Sample {
    let back = inverse(axes.rotation);
    let place = |reading: Reading<Vec3>| Reading {
        value: rotate(back, reading.value - axes.origin),
        ..reading
    };
    let mut seen = *sample;
    seen.head.position = seen.head.position.map(place);
    seen.head.orientation = seen.head.orientation.map(|turn| Reading {
        value: compose(back, turn.value),
        ..turn
    });
    for eye in [&mut seen.left, &mut seen.right] {
        eye.origin = eye.origin.map(place);
    }
    seen
}

#[cfg(test)]
mod tests;
