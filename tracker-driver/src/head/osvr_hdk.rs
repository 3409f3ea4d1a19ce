//! The head tracker of the OSVR Hacker Dev Kit: a USB HID device that sends
//! its orientation without being asked, 400 times a second; early units send fewer, and none
//! come while the video input changes state.
//!
//! # Report
//!
//! From the maker's [description]; all 16-bit values are little-endian two's
//! complement.
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | bits 0 to 3: version, 1 to 3; version 3 only, passed over: bit 4 video detected, bit 5 portrait |
//! | 1 | sequence number |
//! | 2, 4, 6, 8 | unit quaternion i, j, k, real: 14 fractional bits |
//! | 10, 12, 14 | version 2 and 3: angular velocity x, y, z in rad/s, about the sensor's axes: 9 fractional bits |
//! | 16 to 31 | reserved, or not sent |
//!
//! [description]: https://github.com/OSVR/OSVR-Docs/blob/master/Developing/OSVRhdk.md
//!
//! # Axes
//!
//! The description is silent about axes. OSVR-Core (its descriptor
//! `com_osvr_Multiserver_OSVRHackerDevKit.json`, applied as in `JSONTransformVisitor.cpp`) and
//! Monado (`hdk_device.cpp`) agree: the quaternion turns the sensor's axes into a right-handed
//! reference frame with +Z up; in the worn device the sensor's +X points to the right, +Y down
//! and +Z forward. [`Report::sample`] changes both to the axes of [`Head`]; a [`Report`] keeps
//! the device's. Where the reference's other two axes point depends on how the device woke up;
//! Monado turns them a quarter further, which is left to the program that knows the room.

use super::axes::NORM_TOLERANCE;
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::rotation::{compose, inverse};
use crate::sample::{Head, Reading, Sample};
use crate::time::Micros;
use crate::valid;
use glam::{Quat, Vec3};

/// USB vendor and product ids: the regular ones, then those of early units.
pub const USB_IDS: [(u16, u16); 2] = [(0x1532, 0x0B00), (0x03EB, 0x2421)];

/// Bytes that every report has.
pub const REPORT_LENGTH: usize = 16;

/// Bytes of a report that is sent with its reserved half.
pub const PADDED_REPORT_LENGTH: usize = 32;

/// One in the quaternion's fixed-point format.
const QUATERNION_ONE: f32 = 16_384.0;
/// One rad/s in the angular velocity's fixed-point format.
const ANGULAR_VELOCITY_ONE: f32 = 512.0;

const VERSION_MASK: u8 = 0x0F;

/// `head_from_sensor`: half a turn about X.
const HEAD_FROM_SENSOR: Quat = Quat::from_xyzw(1.0, 0.0, 0.0, 0.0);
/// A quarter turn about −X: from +Z up to +Y up.
const Y_UP_FROM_Z_UP: Quat = Quat::from_xyzw(
    -core::f32::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
    core::f32::consts::FRAC_1_SQRT_2,
);

/// One report, in the device's own axes (see the [module](self)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// Counts the reports; wraps at 256.
    pub sequence: u8,
    /// Unit quaternion, `reference_from_sensor`.
    pub orientation: Quat,
    /// Radians per second about the sensor's axes, within ±64; `None` in version 1.
    pub angular_velocity: Option<Vec3>,
}

impl Report {
    /// Returns a report of version 1: the inverse of [`Report::head_orientation`].
    pub fn of_head(sequence: u8, head: Quat) -> Self {
        Self {
            sequence,
            orientation: compose(compose(inverse(Y_UP_FROM_Z_UP), head), HEAD_FROM_SENSOR),
            angular_velocity: None,
        }
    }

    /// Returns how the head is turned: `tracker_from_head`, both with +Y up.
    pub fn head_orientation(&self) -> Quat {
        let y_up_from_sensor = compose(Y_UP_FROM_Z_UP, self.orientation);
        compose(y_up_from_sensor, inverse(HEAD_FROM_SENSOR))
    }

    /// Returns the sample of a report that came in at `arrival`.
    pub fn sample(&self, arrival: Micros) -> Sample {
        Sample {
            sequence: Some(u32::from(self.sequence)),
            head: Head {
                position: None,
                orientation: Some(Reading::tracked(self.head_orientation())),
                // Half a turn about X, without the products' rounding.
                angular_velocity: self.angular_velocity.map(|v| Vec3::new(v.x, -v.y, -v.z)),
            },
            ..Sample::arrived(arrival)
        }
    }
}

/// Why a report was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReportError {
    /// Neither 16 nor 32 bytes.
    #[error(
        "an OSVR HDK report of {found} bytes, not {REPORT_LENGTH} or {PADDED_REPORT_LENGTH}: check \
         that the HID device is the head tracker and that no report id byte was put before the \
         report"
    )]
    Length {
        /// Bytes handed in.
        found: usize,
    },
    /// A version other than 1, 2 and 3.
    #[error(
        "an OSVR HDK report of version {version} in byte 0, where 1 to 3 are known: update the \
         head tracker's firmware, or this decoder"
    )]
    UnknownVersion {
        /// The version, 0 to 15.
        version: u8,
    },
    /// The quaternion's norm is further than [`NORM_TOLERANCE`] from 1.
    #[error(
        "the quaternion in bytes 2 to 9 of OSVR HDK report {sequence} has norm {norm}, not 1 ± \
         {NORM_TOLERANCE}: the report is damaged, or not from the head tracker"
    )]
    NotUnit {
        /// The report's sequence number.
        sequence: u8,
        /// The norm found.
        norm: f32,
    },
}

/// Decodes a report of [`REPORT_LENGTH`] or [`PADDED_REPORT_LENGTH`] bytes, without a HID id.
///
/// # Errors
/// When the length is another, the version unknown, or the quaternion no rotation.
pub fn decode(report: &[u8]) -> Result<Report, ReportError> {
    let length = ReportError::Length {
        found: report.len(),
    };
    if report.len() != REPORT_LENGTH && report.len() != PADDED_REPORT_LENGTH {
        return Err(length);
    }
    let Some(&[flags, sequence, ref values @ ..]) = report.first_chunk::<REPORT_LENGTH>() else {
        return Err(length);
    };
    let version = flags & VERSION_MASK;
    if !(1..=3).contains(&version) {
        return Err(ReportError::UnknownVersion { version });
    }
    let [i0, i1, j0, j1, k0, k1, r0, r1, x0, x1, y0, y1, z0, z1] = *values;
    let turn = [[i0, i1], [j0, j1], [k0, k1], [r0, r1]];
    let turn = turn.map(|part| fixed_point(part, QUATERNION_ONE));
    let orientation = valid::unit(Quat::from_array(turn), NORM_TOLERANCE)
        .map_err(|norm| ReportError::NotUnit { sequence, norm })?;
    let velocity = [[x0, x1], [y0, y1], [z0, z1]];
    let velocity = velocity.map(|part| fixed_point(part, ANGULAR_VELOCITY_ONE));
    let angular_velocity = (version > 1).then_some(Vec3::from_array(velocity));
    Ok(Report {
        sequence,
        orientation,
        angular_velocity,
    })
}

/// Returns the report's first [`REPORT_LENGTH`] bytes: of version 2 with an angular velocity, else
/// of version 1. Parts of the quaternion stop at ±2, velocities at ±64 rad/s; NaN becomes 0.
pub fn encode(report: &Report) -> [u8; REPORT_LENGTH] {
    let version = if report.angular_velocity.is_some() {
        2
    } else {
        1
    };
    let q = report.orientation;
    let turn = [q.x, q.y, q.z, q.w].map(|part| bytes(part, QUATERNION_ONE));
    let velocity = report.angular_velocity.unwrap_or_default().to_array();
    let velocity = velocity.map(|part| bytes(part, ANGULAR_VELOCITY_ONE));
    let mut encoded = [0; REPORT_LENGTH];
    let values = turn.as_flattened().iter().chain(velocity.as_flattened());
    let all = [version, report.sequence]
        .into_iter()
        .chain(values.copied());
    for (to, from) in encoded.iter_mut().zip(all) {
        *to = from;
    }
    encoded
}

fn fixed_point(bytes: [u8; 2], one: f32) -> f32 {
    f32::from(i16::from_le_bytes(bytes)) / one
}

fn bytes(value: f32, one: f32) -> [u8; 2] {
    (libm::roundf(value * one) as i16).to_le_bytes()
}

/// Decodes the reports of one device.
#[derive(Debug, Clone, Default)]
pub struct OsvrHdk {
    last_sequence: Option<u8>,
    counts: Counts,
}

impl OsvrHdk {
    /// Returns a decoder that has seen no report.
    pub fn new() -> Self {
        Self::default()
    }

    /// Notes a sequence number and the gap before it, modulo 256; false for the last one again.
    fn arrived(&mut self, sequence: u8) -> bool {
        let step = self
            .last_sequence
            .replace(sequence)
            .map_or(1, |last| sequence.wrapping_sub(last));
        let lost = u64::from(step.saturating_sub(1));
        self.counts.lost = self.counts.lost.saturating_add(lost);
        step != 0
    }
}

impl Decoder for OsvrHdk {
    /// Takes one whole report; one that only repeats the one before is dropped.
    fn feed(&mut self, report: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        self.counts.bytes = self.counts.bytes.saturating_add(report.len() as u64);
        let found = decode(report).map_err(|error| match error {
            ReportError::Length { .. } => DropReason::Length,
            ReportError::UnknownVersion { .. } => DropReason::Unknown,
            ReportError::NotUnit { sequence, .. } => {
                // It did arrive: without this the next good report would
                // count it a second time, as lost.
                self.arrived(sequence);
                DropReason::NotUnit
            }
        });
        let found = found.and_then(|found| {
            let is_new = self.arrived(found.sequence);
            is_new.then_some(found).ok_or(DropReason::Duplicate)
        });
        let event = match found {
            Ok(found) => Event::Sample(found.sample(arrival)),
            Err(reason) => Event::dropped(report.len() as u32, reason),
        };
        self.counts.note(&event);
        sink(event);
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Forgets the last sequence number: a device that is plugged in again leaves no gap.
    fn reset(&mut self) {
        self.last_sequence = None;
    }
}

#[cfg(test)]
mod tests;
