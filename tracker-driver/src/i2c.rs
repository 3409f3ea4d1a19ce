//! HID over I²C on `embedded-hal`, for any device; what its reports mean is
//! for [`hid`](crate::hid).
//!
//! After "HID over I²C Protocol Specification" 1.0 and the order in which
//! Linux brings a device up (`drivers/hid/i2c-hid/i2c-hid-core.c`). All words
//! are little-endian.
//!
//! | What | Written | Read |
//! |---|---|---|
//! | HID descriptor | its register | 30 bytes |
//! | report descriptor | its register | as many bytes as the HID descriptor says |
//! | input report | – | u16 length, itself included, then the report |
//! | power on, sleep | command register, 0x00 or 0x01, 0x08 | – |
//! | reset | command register, 0x00, 0x01 | – |
//! | get feature | command register, 0x30 + id, 0x02, data register | as an input report |
//! | set feature | command register, 0x30 + id, 0x03, data register, u16 length, report | – |
//!
//! An id of 15 or more is a byte of its own before the data register, and 15
//! stands in its first place.
//!
//! Bringing a device up takes it a while. [`I2cHid::poll`] does the next step
//! and says when to come back; it never waits itself, beyond the transfers on
//! the bus.

use crate::time::Micros;
use embedded_hal::i2c::{I2c, SevenBitAddress};
use heapless::Vec;

/// Bytes of the HID descriptor.
const DESCRIPTOR_LENGTH: usize = 30;

/// The version of the protocol.
const VERSION: u16 = 0x0100;

/// How long a device may take to wake up; as Linux.
pub const WAKE_TIME: Micros = Micros::from_millis(60);

/// How long a device may take to reset.
pub const RESET_TIMEOUT: Micros = Micros::from_millis(1_000);

/// The wait before a device that has not come back is read again, its interrupt line low.
pub const READ_AGAIN: Micros = Micros::from_millis(1);

/// How long a reset is waited for where the interrupt line is not wired.
pub const BLIND_RESET_TIME: Micros = Micros::from_millis(100);

/// Most bytes of a report that is set, its id included.
pub const LONGEST_SET: usize = 128;

/// Before a report that is read: its length.
const LENGTH_BYTES: usize = 2;
/// Before a report that is set.
const LONGEST_SET_HEADER: usize = 9;

const FEATURE: u8 = 0x30;
const LONG_ID: u8 = 0x0F;

const RESET: u8 = 1;
const GET_REPORT: u8 = 2;
const SET_REPORT: u8 = 3;
const SET_POWER: u8 = 8;

const POWER_ON: u8 = 0;
const POWER_SLEEP: u8 = 1;

/// What a device says about itself, as far as it is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct HidDescriptor {
    report_descriptor_length: u16,
    report_descriptor_register: u16,
    /// Most bytes of an input report, with the two of its length.
    longest_input: u16,
    command_register: u16,
    /// Where reports of commands are.
    data_register: u16,
}

impl HidDescriptor {
    /// Reads the 30 bytes; `None` where they are not a descriptor of version 1.0.
    fn from_bytes(bytes: &[u8; DESCRIPTOR_LENGTH]) -> Option<Self> {
        let mut words = [0; DESCRIPTOR_LENGTH / 2];
        for (word, pair) in words.iter_mut().zip(bytes.as_chunks().0) {
            *word = u16::from_le_bytes(*pair);
        }
        let [
            length,
            VERSION,
            descriptor_length,
            register,
            _,
            longest_input,
            _,
            _,
            rest @ ..,
        ] = words
        else {
            return None;
        };
        let [command_register, data_register, ..] = rest;
        (usize::from(length) == DESCRIPTOR_LENGTH).then_some(Self {
            report_descriptor_length: descriptor_length,
            report_descriptor_register: register,
            longest_input,
            command_register,
            data_register,
        })
    }

    fn ready(&self) -> Progress {
        Progress::Ready(self.report_descriptor_length.into())
    }
}

/// What the device's interrupt line says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interrupt {
    /// It is low: the device has something to say.
    Asserted,
    /// It is high.
    Idle,
    /// Nobody looks at it.
    NotWired,
}

/// How far a device has been brought up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// Call again: at once, at this time, or when the interrupt line is low.
    Again(Micros),
    /// It can be used, and its report descriptor is this many bytes of the buffer.
    Ready(usize),
}

/// Why a device could not be spoken to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum I2cHidError<E> {
    /// The bus failed.
    #[error("the I²C bus: {0:?}")]
    Bus(E),
    /// What is at the register is no HID descriptor of version 1.0.
    #[error(
        "no HID descriptor of 30 bytes and version 0x0100 but {length} and {version:#06x}: check \
         the device's address and the descriptor's register"
    )]
    NotHid {
        /// Its first word; it should be 30.
        length: u16,
        /// Its second word; it should be 0x0100.
        version: u16,
    },
    /// The device did not come back from its reset in [`RESET_TIMEOUT`].
    #[error("the device did not come back from its reset in 1 s")]
    ResetTimeout,
    /// The length in front of a report cannot be right.
    #[error("a report that says it has {found} bytes, not 2 to {most}")]
    Length {
        /// How many it says, with the two of the length.
        found: u16,
        /// How many there can be.
        most: usize,
    },
    /// The caller's buffer is too small.
    #[error("{needed} bytes do not fit a buffer of {found}")]
    Buffer {
        /// Bytes that are needed.
        needed: usize,
        /// Bytes that it has.
        found: usize,
    },
    /// The device is not ready, or gone: call [`I2cHid::poll`].
    #[error("the device has not been brought up")]
    NotReady,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Down,
    /// The power was switched on; it wakes until then.
    Waking(HidDescriptor, Micros),
    /// It was reset, and that has to be over by then.
    Resetting(HidDescriptor, Micros),
    Up(HidDescriptor),
}

/// A device on a bus.
#[derive(Debug, Clone)]
pub struct I2cHid<B> {
    bus: B,
    address: SevenBitAddress,
    descriptor_register: u16,
    state: State,
}

impl<B: I2c> I2cHid<B> {
    /// Returns a device whose HID descriptor is at a register of its board: 0x0001 or 0x0020
    /// usually.
    pub fn new(bus: B, address: SevenBitAddress, descriptor_register: u16) -> Self {
        Self {
            bus,
            address,
            descriptor_register,
            state: State::Down,
        }
    }

    /// Gives the bus back.
    pub fn release(self) -> B {
        self.bus
    }

    /// Brings the device up, step by step: power, reset, and its report descriptor into
    /// `buffer`. Once it is ready this does nothing.
    ///
    /// # Errors
    /// Where the bus fails (power is tried twice: some devices wake up over the first), the
    /// device is none or does not reset, or `buffer` is too small. The next call begins anew.
    pub fn poll(
        &mut self,
        now: Micros,
        interrupt: Interrupt,
        buffer: &mut [u8],
    ) -> Result<Progress, I2cHidError<B::Error>> {
        let progress = self.step(now, interrupt, buffer);
        if progress.is_err() {
            self.state = State::Down;
        }
        progress
    }

    fn step(
        &mut self,
        now: Micros,
        interrupt: Interrupt,
        buffer: &mut [u8],
    ) -> Result<Progress, I2cHidError<B::Error>> {
        match self.state {
            State::Down => {
                let descriptor = self.read_descriptor()?;
                room(buffer, descriptor.report_descriptor_length.into())?;
                if self.power(descriptor, POWER_ON).is_err() {
                    self.power(descriptor, POWER_ON)?;
                }
                let until = now.after(WAKE_TIME);
                self.state = State::Waking(descriptor, until);
                Ok(Progress::Again(until))
            }
            State::Waking(_, until) if now < until => Ok(Progress::Again(until)),
            State::Waking(descriptor, _) => {
                let register = descriptor.command_register.to_le_bytes();
                self.write(&[register[0], register[1], 0, RESET])?;
                let into = room(buffer, descriptor.report_descriptor_length.into())?;
                let register = descriptor.report_descriptor_register.to_le_bytes();
                self.write_read(&register, into)?;
                let until = now.after(match interrupt {
                    Interrupt::NotWired => BLIND_RESET_TIME,
                    Interrupt::Asserted | Interrupt::Idle => RESET_TIMEOUT,
                });
                self.state = State::Resetting(descriptor, until);
                Ok(Progress::Again(until))
            }
            State::Resetting(descriptor, until) => {
                let late = now >= until;
                match interrupt {
                    Interrupt::Idle if late => return Err(I2cHidError::ResetTimeout),
                    Interrupt::NotWired | Interrupt::Idle if !late => {
                        return Ok(Progress::Again(until));
                    }
                    _ => (),
                }
                let mut length = [0; LENGTH_BYTES];
                self.read(&mut length)?;
                // Anything but 0 was still on its way from before the reset, or is what a
                // device says that does not come back.
                if length != [0; LENGTH_BYTES] && interrupt == Interrupt::Asserted {
                    return if late {
                        Err(I2cHidError::ResetTimeout)
                    } else {
                        Ok(Progress::Again(now.after(READ_AGAIN)))
                    };
                }
                self.power(descriptor, POWER_ON)?;
                self.state = State::Up(descriptor);
                Ok(descriptor.ready())
            }
            State::Up(descriptor) => Ok(descriptor.ready()),
        }
    }

    fn ready_descriptor(&self) -> Result<HidDescriptor, I2cHidError<B::Error>> {
        match self.state {
            State::Up(descriptor) => Ok(descriptor),
            _ => Err(I2cHidError::NotReady),
        }
    }

    /// Reads the input report when the interrupt line is low. `None` where there is none, or
    /// the device has reset itself.
    ///
    /// # Errors
    /// Where the bus fails, the report's length is impossible, or the buffer is smaller than
    /// the longest one and two bytes.
    pub fn input<'a>(
        &mut self,
        buffer: &'a mut [u8],
    ) -> Result<Option<&'a [u8]>, I2cHidError<B::Error>> {
        let descriptor = self.ready_descriptor()?;
        let into = room(buffer, descriptor.longest_input.into())?;
        self.read(into)?;
        report(into)
    }

    /// Asks for the feature report with this id, 0 without ids. `length` is the report's, with
    /// its id; the buffer has two bytes more.
    ///
    /// # Errors
    /// Where the bus fails, the buffer is too small, or the report's length is impossible.
    pub fn get_feature<'a>(
        &mut self,
        id: u8,
        length: usize,
        buffer: &'a mut [u8],
    ) -> Result<Option<&'a [u8]>, I2cHidError<B::Error>> {
        let descriptor = self.ready_descriptor()?;
        let into = room(buffer, length.saturating_add(LENGTH_BYTES))?;
        self.write_read(&command(&descriptor, id, GET_REPORT), into)?;
        report(into)
    }

    /// Sets the feature report with this id, 0 without ids; it begins with its id if any.
    ///
    /// # Errors
    /// Where the bus fails, or the report has more than [`LONGEST_SET`] bytes.
    pub fn set_feature(&mut self, id: u8, report: &[u8]) -> Result<(), I2cHidError<B::Error>> {
        let descriptor = self.ready_descriptor()?;
        let mut bytes = command(&descriptor, id, SET_REPORT);
        let length = (report.len() + LENGTH_BYTES) as u16;
        let written = bytes
            .extend_from_slice(&length.to_le_bytes())
            .and_then(|()| bytes.extend_from_slice(report));
        if report.len() > LONGEST_SET || written.is_err() {
            let (needed, found) = (report.len(), LONGEST_SET);
            return Err(I2cHidError::Buffer { needed, found });
        }
        self.write(&bytes)
    }

    /// Puts the device to sleep; [`poll`](Self::poll) brings it up again.
    ///
    /// # Errors
    /// Where the bus fails.
    pub fn sleep(&mut self) -> Result<(), I2cHidError<B::Error>> {
        let descriptor = self.ready_descriptor()?;
        self.state = State::Down;
        self.power(descriptor, POWER_SLEEP)
    }

    fn read_descriptor(&mut self) -> Result<HidDescriptor, I2cHidError<B::Error>> {
        let mut bytes = [0; DESCRIPTOR_LENGTH];
        let register = self.descriptor_register.to_le_bytes();
        self.write_read(&register, &mut bytes)?;
        HidDescriptor::from_bytes(&bytes).ok_or({
            let [l0, l1, v0, v1, ..] = bytes;
            I2cHidError::NotHid {
                length: u16::from_le_bytes([l0, l1]),
                version: u16::from_le_bytes([v0, v1]),
            }
        })
    }

    fn power(&mut self, descriptor: HidDescriptor, state: u8) -> Result<(), I2cHidError<B::Error>> {
        let [low, high] = descriptor.command_register.to_le_bytes();
        self.write(&[low, high, state, SET_POWER])
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), I2cHidError<B::Error>> {
        self.bus
            .write(self.address, bytes)
            .map_err(I2cHidError::Bus)
    }

    fn write_read(&mut self, bytes: &[u8], into: &mut [u8]) -> Result<(), I2cHidError<B::Error>> {
        self.bus
            .write_read(self.address, bytes, into)
            .map_err(I2cHidError::Bus)
    }

    fn read(&mut self, into: &mut [u8]) -> Result<(), I2cHidError<B::Error>> {
        self.bus.read(self.address, into).map_err(I2cHidError::Bus)
    }
}

/// Returns the first bytes of a buffer.
fn room<E>(buffer: &mut [u8], needed: usize) -> Result<&mut [u8], I2cHidError<E>> {
    let found = buffer.len();
    let room = buffer.get_mut(..needed);
    room.ok_or(I2cHidError::Buffer { needed, found })
}

/// Returns a command about a feature report, up to the data register. All of it fits.
fn command(
    descriptor: &HidDescriptor,
    id: u8,
    opcode: u8,
) -> Vec<u8, { LONGEST_SET + LONGEST_SET_HEADER }> {
    let mut bytes = Vec::new();
    let _ = bytes.extend_from_slice(&descriptor.command_register.to_le_bytes());
    let _ = bytes.extend_from_slice(&[FEATURE | id.min(LONG_ID), opcode]);
    if id >= LONG_ID {
        let _ = bytes.push(id);
    }
    let _ = bytes.extend_from_slice(&descriptor.data_register.to_le_bytes());
    bytes
}

/// Returns the report behind its length.
fn report<E>(bytes: &[u8]) -> Result<Option<&[u8]>, I2cHidError<E>> {
    let most = bytes.len();
    let length = bytes
        .first_chunk()
        .map_or(0, |bytes| u16::from_le_bytes(*bytes));
    match length {
        // A reset is over, or there is nothing; an interrupt for nothing.
        0 | 0xFFFF => Ok(None),
        found => bytes
            .get(LENGTH_BYTES..usize::from(found))
            .map(Some)
            .ok_or(I2cHidError::Length { found, most }),
    }
}

#[cfg(test)]
mod tests;
