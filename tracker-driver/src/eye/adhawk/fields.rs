//! The stream of the eyes: its fields.

use super::{BOTH, LEFT, MILLIMETRE, NANOSECONDS_PER_MICROSECOND, RIGHT};
use crate::decoder::DropReason;
use crate::sample::{GazePoint, Part, Parts, Pupil, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use crate::valid;
use glam::{Quat, Vec2, Vec3};

/// Nothing of a face is further from the tracker: metres.
const LARGEST_DISTANCE: f32 = 10.0;
/// No pupil is wider: metres.
const LARGEST_PUPIL: f32 = 0.05;
/// No gaze is further outside a screen: screens.
const LARGEST_SCREEN: f32 = 100.0;

/// Returns how many numbers a field holds for this many eyes.
pub(super) fn field_numbers(field: u8, eyes: usize) -> Option<usize> {
    Some(match field {
        1 | 6 | 8 => 4,
        2..=4 => 3 * eyes,
        5 => eyes,
        7 => 2,
        _ => return None,
    })
}

/// Returns the stream of the eyes after its first byte.
pub(super) fn eye_fields(payload: &[u8], arrival: Micros) -> Result<(Sample, Parts), DropReason> {
    let Some((time, [eyes, fields @ ..])) = payload.split_first_chunk() else {
        return Err(DropReason::Length);
    };
    let eyes = *eyes;
    let count = match eyes {
        RIGHT | LEFT => 1,
        BOTH => 2,
        _ => return Err(DropReason::Field),
    };
    let mut sample = Sample {
        device_time: Some(DeviceTime::unwrapped(
            u64::from_le_bytes(*time) / NANOSECONDS_PER_MICROSECOND,
        )),
        ..Sample::arrived(arrival)
    };
    let mut rest = fields;
    let mut seen = 0_u16;
    let mut unmeasured = Parts::NONE;
    while let [field, numbers @ ..] = rest {
        let wanted = 4 * field_numbers(*field, count).ok_or(DropReason::Field)?;
        if seen >> field & 1 != 0 {
            return Err(DropReason::Field);
        }
        seen |= 1 << field;
        let (numbers, behind) = numbers.split_at_checked(wanted).ok_or(DropReason::Length)?;
        unmeasured = read_field(&mut sample, *field, eyes, numbers, unmeasured)?;
        rest = behind;
    }
    // A packet without fields says when it was and nothing else.
    if seen == 0 {
        return Err(DropReason::Length);
    }
    // Either of the two fields for an eye's origin is enough.
    for (eye, part) in [
        (&sample.left, Part::LeftOrigin),
        (&sample.right, Part::RightOrigin),
    ] {
        if eye.origin.is_some() {
            unmeasured = unmeasured.without(part);
        }
    }
    Ok((sample, unmeasured))
}

/// Returns the nth number of a field; its length was checked.
pub(super) fn number(numbers: &[u8], n: usize) -> f32 {
    let bytes = numbers.get(4 * n..).and_then(<[u8]>::first_chunk);
    bytes.map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes))
}

/// Puts a field into the sample; returns `unmeasured` with the parts of this field that are.
// Longer than 80 lines: an arm for each field of a packet.
fn read_field(
    sample: &mut Sample,
    field: u8,
    eyes: u8,
    numbers: &[u8],
    mut unmeasured: Parts,
) -> Result<Parts, DropReason> {
    let [right, left] = [&mut sample.right, &mut sample.left];
    let both = [
        (
            RIGHT,
            [Part::RightOrigin, Part::RightDirection, Part::RightPupil],
            right,
        ),
        (
            LEFT,
            [Part::LeftOrigin, Part::LeftDirection, Part::LeftPupil],
            left,
        ),
    ];
    let present = both.into_iter().filter(|(side, ..)| eyes & side != 0);
    let present = present.map(|(_, parts, eye)| (parts, eye)).enumerate();
    let mut miss = |part| unmeasured = unmeasured.with(part);
    match field {
        1 => {
            let vergence = numbers.get(12..).unwrap_or_default();
            let _ = measured::<1>(vergence, 0, f32::MAX)?;
            let direction = direction(numbers, 0)?;
            if !direction.tracked {
                miss(Part::CombinedDirection);
            }
            sample.combined.direction = Some(direction);
        }
        2 => {
            for (n, ([_, part, _], eye)) in present {
                let direction = direction(numbers, n)?;
                if !direction.tracked {
                    miss(part);
                }
                eye.direction = Some(direction);
            }
        }
        3 | 4 => {
            for (n, ([part, ..], eye)) in present {
                let Some(place) = measured(numbers, n, LARGEST_DISTANCE / MILLIMETRE)? else {
                    miss(part);
                    continue;
                };
                let place = Reading::tracked(Vec3::from_array(place) * MILLIMETRE);
                eye.origin = eye.origin.filter(|_| field == 4).or(Some(place));
            }
        }
        5 => {
            for (n, ([.., part], eye)) in present {
                let Some([diameter]) = measured(numbers, n, LARGEST_PUPIL / MILLIMETRE)? else {
                    miss(part);
                    continue;
                };
                if diameter < 0.0 {
                    return Err(DropReason::OutOfRange);
                }
                let diameter = diameter * MILLIMETRE;
                eye.pupil = (diameter > 0.0).then_some(Pupil::Diameter(diameter));
            }
        }
        7 => {
            let point = measured(numbers, 0, LARGEST_SCREEN)?;
            if point.is_none() {
                miss(Part::GazePoint);
            }
            let place = point.map_or(Vec2::ZERO, Vec2::from_array);
            sample.gaze_point = Some(Reading {
                value: GazePoint::Normalized(place),
                tracked: point.is_some(),
            });
        }
        8 => match measured(numbers, 0, f32::MAX)? {
            Some(turn) => {
                let turn = valid::rotation(Quat::from_array(turn), valid::NORM_TOLERANCE)?;
                sample.head.orientation = Some(Reading::tracked(turn));
            }
            None => miss(Part::HeadOrientation),
        },
        // The scene camera's picture has no place in a sample.
        _ => (),
    }
    Ok(unmeasured)
}

/// Returns the nth `N` numbers of a field, up to `limit` from zero; `None` where one is not
/// measured.
fn measured<const N: usize>(
    numbers: &[u8],
    n: usize,
    limit: f32,
) -> Result<Option<[f32; N]>, DropReason> {
    let mut found = [0.0; N];
    let mut all = true;
    for (i, found) in found.iter_mut().enumerate() {
        let number = number(numbers, N * n + i);
        if number.to_bits() & !SIGN == NOT_MEASURED {
            all = false;
        } else {
            *found = valid::within(number, limit)?;
        }
    }
    Ok(all.then_some(found))
}

/// NaN as C has it; any other is damage, which a byte too many makes of every sixth packet.
pub(super) const NOT_MEASURED: u32 = 0x7FC0_0000;
const SIGN: u32 = 1 << 31;

/// Returns the nth direction of a field; straight ahead and held where it is not measured.
fn direction(numbers: &[u8], n: usize) -> Result<Reading<Vec3>, DropReason> {
    Ok(match measured(numbers, n, f32::MAX)? {
        Some(sent) => Reading::tracked(valid::direction(Vec3::from_array(sent))?),
        None => Reading::held(Vec3::NEG_Z),
    })
}
