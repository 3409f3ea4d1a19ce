//! Eye and head trackers of HID usage page 0x12 (HUTRR74), found and read by
//! their report descriptor.
//!
//! [`EyeTracker::new`] looks once for the input report of tracking data, the status, and the
//! feature reports of capabilities, configuration and control. In the layout of Microsoft's
//! sample (`MSREnable/GazeHid`, `inc/Tracker.h`; see [`mod@documented`]) these are:
//!
//! | Report | Byte | Content |
//! |---|---|---|
//! | input 0x10, tracking data | 1 | u64 timestamp, microseconds |
//! | | 9, 13 | i32 gaze point x, y on the screen |
//! | | 17, 29 | i32 x, y, z of the left eye, of the right eye |
//! | | 41, 53 | i32 x, y, z of the head, of the point that it is turned to |
//! | feature 0x11, capabilities | 1 | u8 quality, then u32 nearest, best, furthest distance, largest width, height of a screen |
//! | feature 0x12, configuration | 1 | u16 maker, u16 product, u32 serial number, u16 date of the display; u32 width, height of its calibrated part |
//! | feature and input 0x13, status | 1 | u8 status, u16 samples per second |
//! | feature 0x14, control | 1 | u8: 1 gaze, 2 eyes, 4 head, or 0 to stop |
//!
//! All are little-endian, and lengths in micrometres. Units and exponents are
//! the descriptor's; a length is handed over in metres.
//!
//! # What such devices do differently
//!
//! - The sample marks its values as constant, which they are not: constant
//!   elements with a usage are read.
//! - Its last six values, of the head, have no usage. Where a descriptor has
//!   exactly this in a report of 65 bytes, they are read as above.
//! - A value outside its logical range, such as 0x7FFFFFFF, is not there.
//!
//! # Axes
//!
//! A gaze point counts from the upper left corner of the calibrated part of the screen, to the
//! right and down, as the sample's drivers compute it. Neither the sample nor the usage tables
//! say where the eyes' and the head's coordinates start or which way they go: [`Axes`] takes
//! them to the tracker's frame of a [`Sample`], +Y up and +Z towards the user; its default
//! changes nothing. A head that is given by the point that it is turned to has no roll: its +X
//! is level. One that is given by angles is turned about Y, then about its own X, then about
//! its own Z; the usage tables name no order.

pub mod documented;
mod feature;
mod field;

pub use feature::{Capabilities, Configuration, Mode, ReportError, Status, status_name};

use super::descriptor::{DescriptorError, ReportKind, Reports, Usage, walk};
use super::usages as u;
use crate::decoder::{Counts, Decoder, DropReason, Event, Message};
use crate::head::axes::from_columns;
use crate::rotation::{compose, inverse, rotate, unit};
use crate::sample::{Eye, GazeFrame, GazePoint, Head, Reading, Sample};
use crate::time::Micros;
use crate::valid;
use field::{ANYWHERE, Field, Group, Key, anywhere};
use glam::{Quat, Vec2, Vec3};
use heapless::Vec;
use shisen_core::numeric;

/// Most bytes of the report that asks for a mode, its id included.
pub const LONGEST_CONTROL: usize = 64;

const TRACKING: [Key; 18] = [
    (ANYWHERE, u::SENSOR_TIMESTAMP),
    (u::GAZE_POINT, u::POSITION_X),
    (u::GAZE_POINT, u::POSITION_Y),
    (u::LEFT_EYE_POSITION, u::POSITION_X),
    (u::LEFT_EYE_POSITION, u::POSITION_Y),
    (u::LEFT_EYE_POSITION, u::POSITION_Z),
    (u::RIGHT_EYE_POSITION, u::POSITION_X),
    (u::RIGHT_EYE_POSITION, u::POSITION_Y),
    (u::RIGHT_EYE_POSITION, u::POSITION_Z),
    (u::HEAD_POSITION, u::POSITION_X),
    (u::HEAD_POSITION, u::POSITION_Y),
    (u::HEAD_POSITION, u::POSITION_Z),
    (u::HEAD_DIRECTION_POINT, u::POSITION_X),
    (u::HEAD_DIRECTION_POINT, u::POSITION_Y),
    (u::HEAD_DIRECTION_POINT, u::POSITION_Z),
    (ANYWHERE, u::ROTATION_X),
    (ANYWHERE, u::ROTATION_Y),
    (ANYWHERE, u::ROTATION_Z),
];

const CAPABILITIES: [Key; 6] = anywhere(u::CAPABILITIES);
const CONFIGURATION: [Key; 6] = anywhere(u::CONFIGURATION);
const STATUS: [Key; 2] = anywhere(u::STATUS);
const CONTROL: [Key; 1] = anywhere(u::CONTROL);

/// Where the six values of the head are that the sample does not name.
const UNNAMED_HEAD: u32 = 320;
const UNNAMED_BITS: u32 = 32;
/// The whole report of the sample, without its id.
const DOCUMENTED_BITS: u32 = 512;

/// From a device's coordinates to the tracker's frame of a [`Sample`]: turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Unit quaternion, `tracker_from_device`.
    pub rotation: Quat,
    /// Where the device's coordinates start: metres, in the tracker's frame.
    pub origin: Vec3,
}

impl Default for Axes {
    fn default() -> Self {
        Self {
            rotation: Quat::IDENTITY,
            origin: Vec3::ZERO,
        }
    }
}

/// Why a descriptor is not that of an eye or head tracker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LayoutError {
    /// It is no descriptor at all.
    #[error(transparent)]
    Descriptor(DescriptorError),
    /// It has no input report of tracking data.
    #[error(
        "the HID report descriptor has no input report with tracking data (usage page 0x12): this \
         is no eye or head tracker, or one that needs its maker's driver"
    )]
    NoTrackingData,
    /// The [`Axes`] are no rotation, or their origin is not finite or farther
    /// out than 10⁹ m.
    #[error(
        "the eye tracker's axes are not a unit quaternion and a finite origin: give a rotation of \
         length 1 and metres"
    )]
    Axes,
}

/// A decoder for one device; each [`Decoder::feed`] takes one input report.
#[derive(Debug, Clone)]
pub struct EyeTracker {
    axes: Axes,
    tracking: Group<18>,
    capabilities: Group<6>,
    configuration: Group<6>,
    status: Group<2>,
    status_input: Group<2>,
    control: Group<1>,
    counts: Counts,
}

/// Farther out an origin leaves nothing of what is measured: metres.
const FARTHEST_ORIGIN: f32 = 1.0e9;

impl EyeTracker {
    /// Returns a decoder for the device with this report descriptor.
    ///
    /// # Errors
    /// Where that is of no eye or head tracker, and for axes that are none.
    pub fn new(descriptor: &[u8], axes: Axes) -> Result<Self, LayoutError> {
        let origin = valid::place(axes.origin, FARTHEST_ORIGIN);
        if origin.is_err() || valid::rotation(axes.rotation, valid::UNIT_TOLERANCE).is_err() {
            return Err(LayoutError::Axes);
        }
        let mut tracker = Self {
            axes,
            tracking: Group::new(ReportKind::Input),
            capabilities: Group::new(ReportKind::Feature),
            configuration: Group::new(ReportKind::Feature),
            status: Group::new(ReportKind::Feature),
            status_input: Group::new(ReportKind::Input),
            control: Group::new(ReportKind::Feature),
            counts: Counts::default(),
        };
        let mut unnamed = [None; 6];
        let reports = walk(descriptor, |element| {
            let (page, id) = (u::PAGE, u::TRACKING_DATA);
            if element.collections.contains(&Some(Usage { page, id })) {
                tracker.tracking.offer(element, &TRACKING);
                if element.usage.is_none()
                    && element.kind == ReportKind::Input
                    && element.bits == UNNAMED_BITS
                    && let Some(beyond) = element.bit_offset.checked_sub(UNNAMED_HEAD)
                    && let Some(place) = unnamed.get_mut((beyond / UNNAMED_BITS) as usize)
                    && beyond.is_multiple_of(UNNAMED_BITS)
                {
                    *place = Some((element.report_id, Field::new(element)));
                }
            }
            tracker.capabilities.offer(element, &CAPABILITIES);
            tracker.configuration.offer(element, &CONFIGURATION);
            tracker.status.offer(element, &STATUS);
            tracker.status_input.offer(element, &STATUS);
            tracker.control.offer(element, &CONTROL);
        })
        .map_err(LayoutError::Descriptor)?;
        tracker.measure(&reports);
        let size = tracker.tracking.size().ok_or(LayoutError::NoTrackingData)?;
        if size.bits == DOCUMENTED_BITS {
            tracker.name_head(size.report_id, &unnamed);
        }
        Ok(tracker)
    }

    fn measure(&mut self, reports: &Reports) {
        self.tracking.measure(reports);
        self.capabilities.measure(reports);
        self.configuration.measure(reports);
        self.status.measure(reports);
        self.status_input.measure(reports);
        self.control.measure(reports);
    }

    /// Takes the six values without a usage for the head, where none are named.
    fn name_head(&mut self, report_id: u8, unnamed: &[Option<(u8, Field)>; 6]) {
        let Some((_, head)) = self.tracking.fields.split_at_mut_checked(9) else {
            return;
        };
        let theirs = |field: &Option<(u8, Field)>| field.is_some_and(|(id, _)| id == report_id);
        if head.iter().all(Option::is_none) && unnamed.iter().all(theirs) {
            for (to, from) in head.iter_mut().zip(unnamed) {
                *to = from.map(|(_, field)| field);
            }
        }
    }

    /// Returns the id of the tracking data's reports; 0 where there are none.
    pub fn report_id(&self) -> u8 {
        self.tracking.size().map_or(0, |size| size.report_id)
    }

    /// Returns the ids and bytes, id included, of the feature reports that there are: capabilities,
    /// configuration, status and control.
    pub fn feature_reports(&self) -> [Option<(u8, usize)>; 4] {
        [
            self.capabilities.size(),
            self.configuration.size(),
            self.status.size(),
            self.control.size(),
        ]
        .map(|size| size.map(|size| (size.report_id, size.bytes())))
    }

    /// Reads a feature report.
    ///
    /// # Errors
    /// Where the device has no such report, or this is another.
    pub fn capabilities(&self, report: &[u8]) -> Result<Capabilities, ReportError> {
        let body = self.capabilities.body(report)?;
        let [quality, nearest, best, furthest, width, height] = self.capabilities.fields;
        Ok(Capabilities {
            quality: Field::read_number(quality, body),
            nearest: Field::read_metres(nearest, body),
            best: Field::read_metres(best, body),
            furthest: Field::read_metres(furthest, body),
            widest_screen: Field::read_metres(width, body),
            highest_screen: Field::read_metres(height, body),
        })
    }

    /// Reads a feature report.
    ///
    /// # Errors
    /// Where the device has no such report, or this is another.
    pub fn configuration(&self, report: &[u8]) -> Result<Configuration, ReportError> {
        let body = self.configuration.body(report)?;
        let [maker, product, serial, date, width, height] = self.configuration.fields;
        Ok(Configuration {
            manufacturer: Field::read_number(maker, body),
            product: Field::read_number(product, body),
            serial_number: Field::read_number(serial, body),
            manufacturer_date: Field::read_number(date, body),
            screen_width: Field::read_metres(width, body),
            screen_height: Field::read_metres(height, body),
        })
    }

    /// Reads a feature report, or an input report of the same content.
    ///
    /// # Errors
    /// Where the device has no such report, or this is another.
    pub fn status(&self, report: &[u8]) -> Result<Status, ReportError> {
        read_status(&self.status, report).or_else(|error| match error {
            ReportError::NotDescribed => read_status(&self.status_input, report),
            error => Err(error),
        })
    }

    /// Returns the report that asks for a mode; `None` without one of [`LONGEST_CONTROL`] bytes or
    /// fewer.
    pub fn mode_request(&self, mode: Mode) -> Option<Vec<u8, LONGEST_CONTROL>> {
        let size = self.control.size()?;
        let [field] = self.control.fields;
        let mut report = Vec::new();
        if size.report_id != 0 {
            report.push(size.report_id).ok()?;
        }
        let id_length = report.len();
        report.resize(size.bytes(), 0).ok()?;
        field?.write(report.get_mut(id_length..)?, u64::from(mode.bits()));
        Some(report)
    }

    fn sample(&self, body: &[u8], arrival: Micros) -> Sample {
        let [time, gaze_x, gaze_y, vectors @ .., x, y, z] = &self.tracking.fields;
        let mut vectors = vectors.chunks_exact(3).map(|fields| {
            let mut place = [0.0; 3];
            for (part, field) in place.iter_mut().zip(fields) {
                *part = Field::read_metres(*field, body)?;
            }
            Some(rotate(self.axes.rotation, Vec3::from_array(place)) + self.axes.origin)
        });
        let mut next = || vectors.next().flatten();
        let (left, right, head, towards) = (next(), next(), next(), next());
        let eye = |place: Option<Vec3>| Eye {
            origin: place.map(Reading::tracked),
            ..Eye::default()
        };
        let faces = head.zip(towards);
        let faces = faces.and_then(|(head, towards)| facing(towards - head));
        let turn = self.turned([*x, *y, *z], body).or(faces);
        Sample {
            device_time: Field::read_time(*time, body),
            head: Head {
                position: head.map(Reading::tracked),
                orientation: turn.map(Reading::tracked),
                angular_velocity: None,
            },
            gaze_frame: GazeFrame::Tracker,
            left: eye(left),
            right: eye(right),
            gaze_point: gaze_point(*gaze_x, *gaze_y, body),
            ..Sample::arrived(arrival)
        }
    }

    /// Returns the turn by angles: one that the device lacks is 0, with one out of range there is
    /// none.
    fn turned(&self, fields: [Option<Field>; 3], body: &[u8]) -> Option<Quat> {
        if fields.iter().all(Option::is_none) {
            return None;
        }
        let mut halves = [0.0; 3];
        for (half, field) in halves.iter_mut().zip(fields) {
            if field.is_some() {
                *half = 0.5 * Field::read_radians(field, body)?;
            }
        }
        let [(sx, cx), (sy, cy), (sz, cz)] = halves.map(numeric::sin_cos);
        let pitch = Quat::from_xyzw(sx, 0.0, 0.0, cx);
        let yaw = Quat::from_xyzw(0.0, sy, 0.0, cy);
        let roll = Quat::from_xyzw(0.0, 0.0, sz, cz);
        let turn = compose(compose(yaw, pitch), roll);
        let rotation = self.axes.rotation;
        unit(compose(compose(rotation, turn), inverse(rotation)))
    }

    fn event(&self, report: &[u8], arrival: Micros) -> Event {
        let error = match self.tracking.body(report) {
            Ok(body) => return Event::Sample(self.sample(body, arrival)),
            Err(error) => error,
        };
        if let Ok(status) = read_status(&self.status_input, report) {
            let code = status.configuration.unwrap_or(0);
            return Event::Message(Message::State {
                code,
                meaning: status_name(code),
            });
        }
        let reason = match error {
            ReportError::Length { .. } => DropReason::Length,
            ReportError::NotDescribed | ReportError::ReportId { .. } => DropReason::Unknown,
        };
        Event::dropped(report.len() as u32, reason)
    }
}

impl Decoder for EyeTracker {
    /// Takes one report, with its id if it has one; hosts may pad it.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        if bytes.is_empty() {
            return;
        }
        self.counts.bytes = self.counts.bytes.saturating_add(bytes.len() as u64);
        let event = self.event(bytes, arrival);
        self.counts.note(&event);
        sink(event);
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Does nothing: no report is ever cut in two.
    fn reset(&mut self) {}
}

fn read_status(group: &Group<2>, report: &[u8]) -> Result<Status, ReportError> {
    let body = group.body(report)?;
    let [configuration, frequency] = group.fields;
    Ok(Status {
        configuration: Field::read_number(configuration, body),
        sampling_frequency: Field::read_value(frequency, body),
    })
}

/// Returns the gaze point; raw where it has no length, not tracked where it has no value.
fn gaze_point(x: Option<Field>, y: Option<Field>, body: &[u8]) -> Option<Reading<GazePoint>> {
    let is_length = x?.is_length();
    if y?.is_length() != is_length {
        return None;
    }
    let (point, place): (fn(Vec2) -> GazePoint, _) = if is_length {
        let place = Field::read_metres(x, body).zip(Field::read_metres(y, body));
        (GazePoint::Plane, place)
    } else {
        let place = Field::read_value(x, body).zip(Field::read_value(y, body));
        (GazePoint::Raw, place)
    };
    let (x, y) = place.unwrap_or_default();
    Some(Reading {
        value: point(Vec2::new(x, y)),
        tracked: place.is_some(),
    })
}

/// Returns a head that faces this way, +X level; `None` for straight up and down.
fn facing(towards: Vec3) -> Option<Quat> {
    let forward = numeric::normalize(towards)?;
    let right = numeric::normalize(forward.cross(Vec3::Y)).filter(|_| forward.y.abs() < 0.999)?;
    let up = right.cross(forward);
    from_columns([right, up, -forward]).ok()
}

#[cfg(test)]
mod tests;
