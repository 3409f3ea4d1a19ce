//! From samples to the bytes that a device would have sent for them.

use super::faults::{Chunk, Source};
use crate::decoder::Message;
use crate::estimate::{Screen, plane_of};
use crate::eye::{adhawk, asl, iscan};
use crate::head::hatire::{self, Translation};
use crate::head::polhemus::{self, Family, ItemList};
use crate::head::{fastrak, flock, liberty, osvr_hdk};
use crate::hid::eye_tracker::{self, documented};
use crate::link;
use crate::rotation::{compose, inverse, rotate};
use crate::sample::{GazePoint, Pupil, Reading, Sample};
use crate::time::Micros;
use glam::{Vec2, Vec3};
use shisen_core::numeric::normalize;

/// What raw units say of straight ahead, for trackers whose units mean
/// nothing without a calibration.
pub const RAW_CENTRE: Vec2 = Vec2::new(850.0, 850.0);
/// Raw units for each metre on the plane one metre ahead; y counts down.
pub const RAW_PER_METRE: f32 = 600.0;
/// A pupil in raw units.
const RAW_PUPIL: f32 = 400.0;

/// A protocol and how its device is set up.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
// One of them at a time, and it stays where it is.
#[allow(clippy::large_enum_variant)]
pub enum Format {
    /// Our own link: everything that a sample has.
    Link,
    /// Polhemus FASTRAK, IS-600, IS-900: the head.
    Fastrak(fastrak::Config),
    /// Polhemus Liberty, Patriot: the head.
    Liberty(liberty::Config),
    /// Ascension Flock of Birds: the head.
    Flock(flock::Config),
    /// Hatire: the head.
    Hatire(hatire::Config),
    /// The OSVR HDK's HID reports: how the head is turned.
    OsvrHdk,
    /// ISCAN: one eye, in raw units.
    Iscan(iscan::Config),
    /// ASL EYE-TRAC: one eye, in raw units.
    Asl(asl::Config),
    /// `AdHawk`: both eyes, and how the head is turned.
    AdHawk,
    /// A HID eye tracker of the [`documented`] layout: the head and a point on
    /// this screen, in coordinates that these axes take to the tracker's.
    EyeTracker(Screen, eye_tracker::Axes),
}

impl Format {
    /// The names that [`named`](Self::named) takes.
    pub const NAMES: [&'static str; 10] = [
        "link", "fastrak", "liberty", "flock", "hatire", "osvr-hdk", "iscan", "asl", "adhawk",
        "hid",
    ];

    /// A device by its name, set up as is usual: positions and quaternions,
    /// binary, timestamps where there are any; a screen of 2 m × 1 m, 1 m
    /// ahead of the origin. `None` for other names.
    pub fn named(name: &str) -> Option<Self> {
        let binary = polhemus::Format::Binary;
        Some(match name {
            "link" => Self::Link,
            "fastrak" => {
                let items = ItemList::new(Family::Fastrak, binary, &[2, 11, 0]);
                Self::Fastrak(fastrak::Config::new(items.ok()?))
            }
            "liberty" => {
                let items = ItemList::new(Family::Liberty, binary, &[2, 7, 8, 0]);
                Self::Liberty(liberty::Config::new(items.ok()?))
            }
            "flock" => Self::Flock(flock::Config::default()),
            "hatire" => Self::Hatire(hatire::Config::default()),
            "osvr-hdk" => Self::OsvrHdk,
            "iscan" => Self::Iscan(iscan::Config::default()),
            "asl" => Self::Asl(asl::Config::default()),
            "adhawk" => Self::AdHawk,
            "hid" => Self::EyeTracker(
                Screen {
                    corner: Vec3::new(-1.0, 0.5, -1.0),
                    right: Vec3::X,
                    down: Vec3::NEG_Y,
                    size: Vec2::new(2.0, 1.0),
                },
                eye_tracker::Axes::default(),
            ),
            _ => return None,
        })
    }

    /// Whether a sample has what this format's devices measure: the pose that
    /// their records hold, or where the eyes look.
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

    /// Whether its records can say that what they hold is not tracked; where
    /// not, a device has nothing to send of a sample that lacks it.
    pub const fn says_untracked(&self) -> bool {
        !matches!(self, Self::Flock(_) | Self::Hatire(_) | Self::OsvrHdk)
    }
}

/// A source of bytes, made of a source of samples.
#[derive(Debug, Clone)]
pub struct Wire<S> {
    source: S,
    format: Format,
    link: link::Encoder,
}

impl<S: Source<Item = Sample>> Wire<S> {
    /// Of samples in a format.
    pub fn new(source: S, format: Format) -> Self {
        Self {
            source,
            format,
            link: link::Encoder::new(),
        }
    }

    /// What the samples come from.
    pub fn source(&mut self) -> &mut S {
        &mut self.source
    }

    /// How they are written.
    pub const fn format(&self) -> &Format {
        &self.format
    }

    /// Writes them so from now on, as a device does that was told to.
    pub fn set_format(&mut self, format: Format) {
        self.format = format;
    }

    /// The bytes of a sample: one record, packet or report. `None` where the
    /// protocol has nothing to say of it.
    pub fn encode(&mut self, sample: &Sample) -> Option<Chunk> {
        if !self.format.says_untracked() && !self.format.carries(sample) {
            return None;
        }
        let chunk = |bytes: &[u8]| Some(Chunk::new(sample.arrival, bytes));
        match &self.format {
            Format::Link => chunk(&self.link.sample(sample)),
            Format::Fastrak(config) => chunk(&config.encode(sample)),
            Format::Liberty(config) => chunk(&config.encode(sample)),
            Format::Flock(config) => chunk(&config.encode(sample)),
            Format::Hatire(config) => chunk(&config.encode(sample)),
            Format::OsvrHdk => {
                let turn = sample.head.orientation?.value;
                let sequence = sample.sequence.unwrap_or(0) as u8;
                chunk(&osvr_hdk::encode(&osvr_hdk::Report::of_head(
                    sequence, turn,
                )))
            }
            Format::Iscan(config) => chunk(&iscan::encode(&raw(sample), config)),
            Format::Asl(config) => chunk(&asl::encode(&raw(sample), config.layout)),
            Format::AdHawk => chunk(&adhawk::encode(sample)?),
            Format::EyeTracker(screen, axes) => {
                let seen = in_axes(&on_screen(sample, screen), axes);
                chunk(&documented::tracking(&seen))
            }
        }
    }
}

impl<S> Wire<S> {
    /// The bytes of something that the device says beside its samples, at `now`; `None`
    /// where the protocol has none for it.
    pub(super) fn encode_message(&mut self, message: &Message, now: Micros) -> Option<Chunk> {
        match (&self.format, message) {
            (Format::Link, message) => Some(Chunk::new(now, &self.link.message(message))),
            (Format::AdHawk, Message::Eyes(event)) => {
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

/// Where both eyes together look, in their frame.
fn direction(sample: &Sample) -> Option<Vec3> {
    let of = |eye: &crate::sample::Eye| eye.direction.map(|direction| direction.value);
    of(&sample.combined).or_else(|| match (of(&sample.left), of(&sample.right)) {
        (Some(left), Some(right)) => normalize(left + right),
        (left, right) => left.or(right),
    })
}

/// The sample of a tracker that sees one eye and knows no directions.
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

/// The sample of a tracker that stands under a screen: places in its own frame
/// and a point on the screen, in place of directions.
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

/// Metres.
const FARTHEST: f32 = 2.0;

/// The sample in the coordinates of a device that has these axes.
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
