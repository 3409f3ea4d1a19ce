//! A frame in bytes.

use super::{Setup, WallHash};
use crate::live::{Cut, Decision, Look, RoomPlace};
use glam::{DVec3, Quat, Vec3};
use shisen_core::gaze::HeadPose;

/// What decides a frame, and hashes of what it was.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedFrame {
    /// Its number, from 0.
    pub number: u64,
    /// When it was shown, since the first frame's gaze was taken: microseconds.
    pub shown_us: u64,
    /// Seconds of the scene's animations.
    pub time: f64,
    /// Where the room was in the scene.
    pub place: RoomPlace,
    /// The head and the line of sight that were used. The position is the head's.
    pub look: Look,
    /// The budget in steps, and the quality.
    pub decision: Decision,
    /// The tiles that the budget cut off, in the order of their numbers.
    pub cuts: Vec<Cut>,
    /// The hashes of its pictures.
    pub walls: Vec<WallHash>,
}

// The bits of a frame's first byte.
const IS_LIMITED: u8 = 1;
const WHOLE_FOVEA: u8 = 2;
const HAS_FLOWN: u8 = 4;
const IS_WIDENED: u8 = 8;

/// The longest number in bytes of seven bits.
const LONGEST: u32 = 63;

fn write_number(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

/// The bytes of a frame that are not read yet.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..=LONGEST).step_by(7) {
            let [byte] = self.take()?;
            let part = u64::from(byte & 0x7F);
            if shift == LONGEST && part > 1 {
                return None;
            }
            number |= part << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    fn double(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut floats = [0.0; N];
        for float in &mut floats {
            *float = self.take().map(f32::from_le_bytes)?;
        }
        Some(floats)
    }
}

impl RecordedFrame {
    pub(super) fn write(&self, bytes: &mut Vec<u8>) {
        let (look, decision, place) = (&self.look, &self.decision, &self.place);
        let flag = |is: bool, bit: u8| if is { bit } else { 0 };
        bytes.push(
            flag(decision.steps.is_some(), IS_LIMITED)
                | flag(decision.whole_fovea, WHOLE_FOVEA)
                | flag(*place != RoomPlace::START, HAS_FLOWN)
                | flag(look.widen != 0.0, IS_WIDENED),
        );
        write_number(bytes, self.number);
        write_number(bytes, self.shown_us);
        write_number(bytes, decision.rung as u64);
        if let Some(steps) = decision.steps {
            write_number(bytes, steps);
        }
        bytes.extend_from_slice(&self.time.to_le_bytes());
        if *place != RoomPlace::START {
            let numbers = place.position.extend(place.yaw).to_array();
            bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        }
        let head = look.head;
        let floats = head.position.to_array().into_iter();
        let floats = floats.chain(head.orientation.to_array());
        let floats = floats.chain(look.forward.to_array());
        let floats = floats.chain(look.up.to_array());
        let widen = Some(look.widen).filter(|widen| *widen != 0.0);
        bytes.extend(floats.chain(widen).flat_map(f32::to_le_bytes));
        write_number(bytes, self.cuts.len() as u64);
        let mut before = 0;
        for cut in &self.cuts {
            write_number(bytes, u64::from(cut.tile.wrapping_sub(before)));
            write_number(bytes, cut.kept.into());
            before = cut.tile;
        }
        for wall in &self.walls {
            bytes.extend_from_slice(&wall.hash.to_le_bytes());
        }
        let rows = self.walls.iter().flat_map(|wall| &wall.rows);
        bytes.extend(rows.flat_map(|row| row.to_le_bytes()));
    }

    /// Returns the frame that these bytes are, all of them.
    pub(super) fn read(bytes: &[u8], setup: &Setup) -> Option<Self> {
        let mut rest = Rest(bytes);
        let [flags] = rest.take()?;
        let has = |bit: u8| flags & bit != 0;
        let number = rest.number()?;
        let shown_us = rest.number()?;
        let rung = usize::try_from(rest.number()?).ok()?;
        setup.rungs.get(rung)?;
        let steps = if has(IS_LIMITED) {
            Some(rest.number()?)
        } else {
            None
        };
        let time = rest.double()?;
        let place = if has(HAS_FLOWN) {
            let position = DVec3::new(rest.double()?, rest.double()?, rest.double()?);
            let yaw = rest.double()?;
            RoomPlace { position, yaw }
        } else {
            RoomPlace::START
        };
        let position = Vec3::from_array(rest.floats()?);
        let look = Look {
            head: HeadPose {
                position,
                orientation: Quat::from_array(rest.floats()?),
            },
            position,
            forward: Vec3::from_array(rest.floats()?),
            up: Vec3::from_array(rest.floats()?),
            widen: if has(IS_WIDENED) {
                rest.floats::<1>()?[0]
            } else {
                0.0
            },
        };
        let mut cuts = Vec::new();
        let mut before = 0_u32;
        for _ in 0..rest.number()? {
            let tile = before.checked_add(u32::try_from(rest.number()?).ok()?)?;
            let kept = u32::try_from(rest.number()?).ok()?;
            cuts.push(Cut { tile, kept });
            before = tile;
        }
        let mut walls = Vec::new();
        for _ in &setup.pictures {
            let hash = rest.take().map(u64::from_le_bytes)?;
            walls.push(WallHash {
                hash,
                rows: Vec::new(),
            });
        }
        for (wall, picture) in walls.iter_mut().zip(&setup.pictures) {
            for _ in 0..setup.rows_of(picture) {
                wall.rows.push(rest.take().map(u32::from_le_bytes)?);
            }
        }
        let is_all = rest.0.is_empty();
        is_all.then_some(Self {
            number,
            shown_us,
            time,
            place,
            look,
            decision: Decision {
                steps,
                whole_fovea: has(WHOLE_FOVEA),
                rung,
            },
            cuts,
            walls,
        })
    }
}
