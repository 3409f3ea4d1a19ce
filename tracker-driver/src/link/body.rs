//! What is left of a body while it is read.

use super::frame::Content;
use crate::decoder::DropReason;
use crate::time::DeviceTime;
use crate::valid;
use glam::Vec3;

/// What is left of a body.
pub(crate) struct Body<'a>(pub(crate) &'a [u8]);

impl Body<'_> {
    pub(crate) fn take<const N: usize>(&mut self) -> Result<[u8; N], DropReason> {
        let (bytes, rest) = self.0.split_first_chunk().ok_or(DropReason::Length)?;
        self.0 = rest;
        Ok(*bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, DropReason> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Result<u64, DropReason> {
        self.take().map(u64::from_le_bytes)
    }

    /// Returns a finite number.
    pub(crate) fn number(&mut self) -> Result<f32, DropReason> {
        let number = f32::from_le_bytes(self.take()?);
        valid::within(number, f32::MAX)
    }

    pub(crate) fn vector(&mut self) -> Result<Vec3, DropReason> {
        Ok(Vec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// Returns a time, and when its clock wraps if it does.
    pub(crate) fn time(&mut self, wraps: bool) -> Result<DeviceTime, DropReason> {
        let microseconds = self.u64()?;
        let wraps_at = if wraps { self.u64()? } else { 0 };
        if wraps && microseconds >= wraps_at {
            return Err(DropReason::Field);
        }
        Ok(DeviceTime {
            microseconds,
            wraps_at,
        })
    }

    /// Checks that no byte is left over.
    pub(crate) fn end(&self) -> Result<(), DropReason> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(DropReason::Length)
        }
    }
}

/// Adds a time as [`Body::time`] reads it.
pub(super) fn write_time(content: &mut Content, time: DeviceTime) {
    content.push(&time.microseconds.to_le_bytes());
    if time.wraps_at != 0 {
        content.push(&time.wraps_at.to_le_bytes());
    }
}
