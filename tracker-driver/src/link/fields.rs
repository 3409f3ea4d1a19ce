//! The body of a sample.

use super::NORM_TOLERANCE;
use super::body::{Body, write_time};
use super::frame::Content;
use crate::decoder::DropReason;
use crate::sample::{Eye, GazeFrame, GazePoint, Head, Pupil, Reading, Sample};
use crate::time::Micros;
use crate::valid;
use glam::{Quat, Vec2, Vec3};

pub(super) const TIME: u32 = 1 << 0;
pub(super) const TIME_WRAPS: u32 = 1 << 1;
pub(super) const SEQUENCE: u32 = 1 << 2;
pub(super) const POSITION: u32 = 1 << 3;
pub(super) const ORIENTATION: u32 = 1 << 4;
pub(super) const ANGULAR_VELOCITY: u32 = 1 << 5;
/// The left eye's bits; those of the right and the combined eye are 4 and 8 places higher.
pub(super) const ORIGIN: u32 = 1 << 6;
pub(super) const DIRECTION: u32 = 1 << 7;
pub(super) const PUPIL: u32 = 1 << 8;
pub(super) const OPENNESS: u32 = 1 << 9;
pub(super) const BITS_PER_EYE: u32 = 4;
pub(super) const GAZE_POINT: u32 = 1 << 18;
pub(super) const TRACKER_FRAME: u32 = 1 << 19;
/// The left eye's bit; those of the right and the combined eye are 1 and 2 places higher.
pub(super) const RAW_PUPIL: u32 = 1 << 20;
pub(super) const GAZE_POINT_KIND: u32 = 23;
pub(super) const UNUSED: u32 = !0 << 25;
/// The fields that can be tracked.
pub(super) const TRACKABLE: u32 = POSITION
    | ORIENTATION
    | GAZE_POINT
    | ((ORIGIN | DIRECTION) * (1 | (1 << BITS_PER_EYE) | (1 << (2 * BITS_PER_EYE))));

/// Returns the eyes of a sample, each with the number of places its bits are above the left eye's.
fn eyes(sample: &Sample) -> [(u32, &Eye); 3] {
    [(0, &sample.left), (1, &sample.right), (2, &sample.combined)]
}

/// Adds the body of a sample.
pub(super) fn write_sample(content: &mut Content, sample: &Sample) {
    let mut bits = Bits::default();
    let time = sample.device_time;
    bits.field(TIME, time.is_some());
    bits.field(TIME_WRAPS, time.is_some_and(|time| time.wraps_at != 0));
    bits.field(SEQUENCE, sample.sequence.is_some());
    bits.reading(POSITION, sample.head.position.as_ref());
    bits.reading(ORIENTATION, sample.head.orientation.as_ref());
    bits.field(ANGULAR_VELOCITY, sample.head.angular_velocity.is_some());
    for (n, eye) in eyes(sample) {
        let shift = n * BITS_PER_EYE;
        bits.reading(ORIGIN << shift, eye.origin.as_ref());
        bits.reading(DIRECTION << shift, eye.direction.as_ref());
        bits.field(PUPIL << shift, eye.pupil.is_some());
        bits.field(RAW_PUPIL << n, matches!(eye.pupil, Some(Pupil::Raw(_))));
        bits.field(OPENNESS << shift, eye.openness.is_some());
    }
    bits.reading(GAZE_POINT, sample.gaze_point.as_ref());
    bits.field(TRACKER_FRAME, sample.gaze_frame == GazeFrame::Tracker);
    let point = sample.gaze_point.map(|point| match point.value {
        GazePoint::Plane(point) => (0, point),
        GazePoint::Normalized(point) => (1, point),
        GazePoint::Raw(point) => (2, point),
    });
    bits.valid |= point.map_or(0, |(kind, _)| kind << GAZE_POINT_KIND);

    content.push(&bits.valid.to_le_bytes());
    content.push(&bits.tracked.to_le_bytes());
    content.push(&[sample.sensor]);
    if let Some(time) = time {
        write_time(content, time);
    }
    if let Some(sequence) = sample.sequence {
        content.push(&sequence.to_le_bytes());
    }
    let Head {
        position,
        orientation,
        angular_velocity,
    } = sample.head;
    let mut push = |number: f32| content.push(&number.to_le_bytes());
    let place = position.iter().flat_map(|p| p.value.to_array());
    let turn = orientation.iter().flat_map(|o| o.value.to_array());
    let velocity = angular_velocity.iter().flat_map(Vec3::to_array);
    place.chain(turn).chain(velocity).for_each(&mut push);
    for (_, eye) in eyes(sample) {
        let vectors = [eye.origin, eye.direction].into_iter().flatten();
        vectors.flat_map(|v| v.value.to_array()).for_each(&mut push);
        let pupil = eye
            .pupil
            .map(|(Pupil::Diameter(size) | Pupil::Raw(size))| size);
        pupil.into_iter().chain(eye.openness).for_each(&mut push);
    }
    let point = point.iter().flat_map(|(_, point)| point.to_array());
    point.for_each(&mut push);
}

/// The two words of bits before a sample's fields.
#[derive(Debug, Clone, Copy, Default)]
struct Bits {
    valid: u32,
    tracked: u32,
}

impl Bits {
    fn has(self, bit: u32) -> bool {
        self.valid & bit != 0
    }

    /// Returns a reading whose `tracked` is this bit.
    fn read<T>(self, bit: u32, value: T) -> Reading<T> {
        let tracked = self.tracked & bit != 0;
        Reading { value, tracked }
    }

    fn field(&mut self, bit: u32, there: bool) {
        self.valid |= if there { bit } else { 0 };
    }

    fn reading<T>(&mut self, bit: u32, reading: Option<&Reading<T>>) {
        self.field(bit, reading.is_some());
        self.tracked |= match reading {
            Some(reading) if reading.tracked => bit,
            _ => 0,
        };
    }
}

/// Returns the vector unchanged if its length is 1.
fn unit(vector: Vec3) -> Result<Vec3, DropReason> {
    let norm = valid::length(&valid::place(vector, 2.0)?.to_array());
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(DropReason::NotUnit);
    }
    Ok(vector)
}

/// Reads the sample in a body.
#[inline(never)]
pub(super) fn read_sample(body: &[u8], arrival: Micros) -> Result<Sample, DropReason> {
    let mut body = Body(body);
    let (valid, tracked) = (body.u32()?, body.u32()?);
    if valid & UNUSED != 0 || tracked & !(valid & TRACKABLE) != 0 {
        return Err(DropReason::Field);
    }
    let bits = Bits { valid, tracked };
    let has = |bit| bits.has(bit);
    let [sensor] = body.take()?;
    let mut sample = Sample {
        sensor,
        ..Sample::arrived(arrival)
    };
    if has(TIME) {
        sample.device_time = Some(body.time(has(TIME_WRAPS))?);
    } else if has(TIME_WRAPS) {
        return Err(DropReason::Field);
    }
    if has(SEQUENCE) {
        sample.sequence = Some(body.u32()?);
    }
    if has(POSITION) {
        sample.head.position = Some(bits.read(POSITION, body.vector()?));
    }
    if has(ORIENTATION) {
        let [x, y, z, w] = [
            body.number()?,
            body.number()?,
            body.number()?,
            body.number()?,
        ];
        let value = Quat::from_xyzw(x, y, z, w);
        valid::rotation(value, NORM_TOLERANCE)?;
        sample.head.orientation = Some(bits.read(ORIENTATION, value));
    }
    if has(ANGULAR_VELOCITY) {
        sample.head.angular_velocity = Some(body.vector()?);
    }
    if has(TRACKER_FRAME) {
        sample.gaze_frame = GazeFrame::Tracker;
    }
    let sides = [&mut sample.left, &mut sample.right, &mut sample.combined];
    for (n, eye) in (0..).zip(sides) {
        read_eye(&mut body, bits, n, eye)?;
    }
    let kind = (valid >> GAZE_POINT_KIND) & 0b11;
    if has(GAZE_POINT) {
        let point = Vec2::new(body.number()?, body.number()?);
        let value = match kind {
            0 => GazePoint::Plane(point),
            1 => GazePoint::Normalized(point),
            2 => GazePoint::Raw(point),
            _ => return Err(DropReason::Field),
        };
        sample.gaze_point = Some(bits.read(GAZE_POINT, value));
    } else if kind != 0 {
        return Err(DropReason::Field);
    }
    body.end()?;
    Ok(sample)
}

/// Reads eye `n` of the three.
fn read_eye(body: &mut Body<'_>, bits: Bits, n: u32, eye: &mut Eye) -> Result<(), DropReason> {
    let shift = n * BITS_PER_EYE;
    if bits.has(ORIGIN << shift) {
        eye.origin = Some(bits.read(ORIGIN << shift, body.vector()?));
    }
    if bits.has(DIRECTION << shift) {
        eye.direction = Some(bits.read(DIRECTION << shift, unit(body.vector()?)?));
    }
    if bits.has(PUPIL << shift) {
        let size = body.number()?;
        if size < 0.0 {
            return Err(DropReason::OutOfRange);
        }
        let raw = bits.has(RAW_PUPIL << n);
        eye.pupil = Some(if raw {
            Pupil::Raw(size)
        } else {
            Pupil::Diameter(size)
        });
    } else if bits.has(RAW_PUPIL << n) {
        return Err(DropReason::Field);
    }
    if bits.has(OPENNESS << shift) {
        let openness = body.number()?;
        if !(0.0..=1.0).contains(&openness) {
            return Err(DropReason::OutOfRange);
        }
        eye.openness = Some(openness);
    }
    Ok(())
}
