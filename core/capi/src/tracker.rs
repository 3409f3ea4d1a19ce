//! Trackers: bytes in, the line of sight at the time of display out.

use crate::memory::{exclusive, needed, room, shared, slice, slice_mut, write};
use crate::protocol::{Device, Protocol};
use crate::status::{Status, settled};
use core::ffi::c_void;
use core::ptr::null_mut;
use glam::{Quat, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::command::{Action, MOST_COMMAND_BYTES, Session, SettingUp};
use shisen_tracker::decoder::{Decoder, DropReason, Event};
use shisen_tracker::estimate::{EstimatorConfig, Eyes, GazeEstimator, RoomFromTracker, State};
use shisen_tracker::time::Micros;

/// Bytes of memory for a tracker's handle, for every protocol.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_TRACKER_SIZE: usize = 6592;
/// Bytes of memory for a tracker's handle, for every protocol.
#[cfg(target_pointer_width = "64")]
pub const SHISEN_TRACKER_SIZE: usize = 6896;

/// Bytes of memory for setting a device up.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_SETUP_SIZE: usize = 1376;
/// Bytes of memory for setting a device up.
#[cfg(target_pointer_width = "64")]
pub const SHISEN_SETUP_SIZE: usize = 1400;

/// Most bytes that shisen_tracker_poll writes at once.
pub const SHISEN_MOST_COMMAND_BYTES: usize = 48;

/// Number of reasons to drop bytes: see shisen_drop_reason.
pub const SHISEN_DROP_REASONS: usize = 9;

/// The age of a gaze that never came.
pub const SHISEN_NEVER: u64 = u64::MAX;

const _: () = assert!(needed::<Tracker>() <= SHISEN_TRACKER_SIZE);
const _: () = assert!(needed::<Session>() <= SHISEN_SETUP_SIZE);
const _: () = assert!(MOST_COMMAND_BYTES == SHISEN_MOST_COMMAND_BYTES);
const _: () = assert!(DropReason::ALL.len() == SHISEN_DROP_REASONS);

/// A tracker, what is known of its clock, and where the viewer looks.
pub struct Tracker {
    device: Device,
    clock: ClockEstimator,
    gaze: GazeEstimator,
    hertz: Option<u16>,
    /// The set-up under way, in the caller's memory.
    setup: Option<&'static mut Session>,
    /// The time of the set-up, which begins with the first poll; a reset does not extend it.
    setting_up: SettingUp,
}

/// The eye whose line of sight is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum EyeChoice {
    /// The device's combined eye; without one, the mean of both eyes, or the one
    /// that the device sees.
    Combined = 0,
    /// The left eye alone.
    Left = 1,
    /// The right eye alone.
    Right = 2,
    /// No eye: the head's direction is used.
    None = 3,
}

/// Settings of a tracker: see shisen_tracker_settings_init.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrackerSettings {
    /// The device's protocol: a shisen_protocol.
    pub protocol: u32,
    /// The eye that is used: a shisen_eye_choice.
    pub eyes: u32,
    /// Whether the device measures the head (1); if not (0), the head rests at
    /// `position` and `orientation`.
    pub head_tracked: u32,
    /// Samples per second that set-up asks the device for, if its protocol has a
    /// command for that; at most 65,535. 0: the device's own rate.
    pub hertz: u32,
    /// Least time from a measurement to the arrival of its last byte:
    /// microseconds, at most 1,000,000.
    pub least_delay_us: u64,
    /// The tracker's origin in the room, metres.
    pub position: [f32; 3],
    /// The tracker's axes in the room: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// How far a gaze can be relied on; a greater number is worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum GazeState {
    /// Gaze and head are recent.
    Fresh = 0,
    /// The last gaze is held: a blink, a reflection, a few lost samples.
    Hold = 1,
    /// The gaze is near where it was: the field of full detail widens.
    Widened = 2,
    /// The eyes' direction is not known; the head's direction is used.
    HeadDirection = 3,
    /// Neither eyes nor head are known: full detail everywhere.
    FullQuality = 4,
}

/// Where the viewer looks.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Gaze {
    /// The point between the eyes: metres, in the room.
    pub position: [f32; 3],
    /// The line of sight: a unit vector, in the room. To begin a frame it may
    /// have any length but zero.
    pub forward: [f32; 3],
    /// Towards the top of the head: a unit vector at a right angle to `forward`.
    /// To begin a frame it may have any length but zero, at any angle but
    /// along `forward`.
    pub up: [f32; 3],
    /// Angle by which the field of full detail is widened: radians. From π on the
    /// field is everything.
    pub widen: f32,
    /// How far the gaze can be relied on: a shisen_gaze_state.
    pub state: u32,
    /// Whether the eyes were shut in the newest sample that says so: 0 or 1.
    pub blink: u32,
    /// Age of the newest gaze at the time of display: microseconds;
    /// SHISEN_NEVER if no gaze ever came.
    pub age_us: u64,
}

/// Why bytes were dropped: an index into `dropped` of shisen_tracker_counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum DropReasonNumber {
    /// Bytes between records that do not start a record.
    OutOfStep = 0,
    /// A record broke off before its end.
    Truncated = 1,
    /// The protocol has no record of this length.
    Length = 2,
    /// The record's checksum does not match.
    Checksum = 3,
    /// A field holds a value that the protocol does not allow.
    Field = 4,
    /// A number is infinite, NaN, or not one the sensor can measure.
    OutOfRange = 5,
    /// A direction or a quaternion has no length.
    NotUnit = 6,
    /// An unknown version or kind of record.
    Unknown = 7,
    /// The record repeats the one before.
    Duplicate = 8,
}

/// Counts of a tracker's bytes and records. A count stops at its largest value.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrackerCounts {
    /// Bytes received.
    pub bytes: u64,
    /// Records with a sample.
    pub samples: u64,
    /// Records without a sample, such as a fault or an answer.
    pub messages: u64,
    /// Records that the device's own count says are missing.
    pub lost: u64,
    /// Bytes dropped.
    pub dropped_bytes: u64,
    /// Number of times that bytes were dropped, by shisen_drop_reason.
    pub dropped: [u32; SHISEN_DROP_REASONS],
}

/// The caller's next step in setting a device up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SetupAction {
    /// Send the bytes in the buffer, `length` of them, then poll again at once.
    Send = 0,
    /// Change the line to `baud` once all bytes are sent, then poll again at once.
    Speed = 1,
    /// Poll again at `until_us`, and after each call of shisen_tracker_feed.
    Wait = 2,
    /// The device is set up, or needs no set-up. The set-up's memory is free again.
    Done = 3,
}

/// The answer of shisen_tracker_poll.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct Setup {
    /// The next step: a shisen_setup_action.
    pub action: u32,
    /// The line's speed, bits per second, for SPEED.
    pub baud: u32,
    /// Number of bytes in the buffer, for SEND.
    pub length: usize,
    /// Time of the next poll by the caller's clock, microseconds, for WAIT.
    pub until_us: u64,
}

/// Returns SHISEN_TRACKER_SIZE, the bytes of memory for a tracker's handle.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_tracker_size() -> usize {
    SHISEN_TRACKER_SIZE
}

/// Returns SHISEN_SETUP_SIZE, the bytes of memory for setting a device up.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_setup_size() -> usize {
    SHISEN_SETUP_SIZE
}

/// Writes the default settings for `protocol`, a shisen_protocol: the tracker's
/// origin and axes are the room's, and it measures all that the protocol can send.
///
/// # Safety
/// `settings` is NULL, misaligned, or points to memory for one TrackerSettings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_settings_init(
    settings: *mut TrackerSettings,
    protocol: u32,
) -> Status {
    settled(|| {
        let known = Protocol::of_number(protocol)?;
        let eyes = if known.has_eyes() {
            EyeChoice::Combined
        } else {
            EyeChoice::None
        };
        let usual = TrackerSettings {
            protocol,
            eyes: eyes as u32,
            head_tracked: known.has_head().into(),
            hertz: 0,
            least_delay_us: 0,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
        };
        // SAFETY: as promised above.
        unsafe { write(settings, usual) }
    })
}

/// Makes a tracker that has received no bytes yet.
///
/// `memory`, `memory_size`: for the handle, which needs SHISEN_TRACKER_SIZE bytes
/// at a multiple of SHISEN_ALIGNMENT. A tracker may be abandoned at any time.
/// `tracker`: receives the handle; NULL after a failure.
///
/// # Safety
/// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
/// the others for one value. Nobody else uses that memory during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_init(
    memory: *mut c_void,
    memory_size: usize,
    settings: *const TrackerSettings,
    tracker: *mut *mut Tracker,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        unsafe { write(tracker, null_mut()) }?;
        let handle = room::<Tracker>(memory, memory_size, 0)?;
        // SAFETY: as promised above.
        let settings = unsafe { shared(settings) }?;
        let protocol = Protocol::of_number(settings.protocol)?;
        // Each is written in place in turn, so that the stack never holds all of them.
        // SAFETY: there is room.
        unsafe {
            place(&raw mut (*handle).hertz, || hertz(settings))?;
            place(&raw mut (*handle).clock, || clock(settings))?;
            place(&raw mut (*handle).gaze, || estimator(settings))?;
            place(&raw mut (*handle).device, || Device::new(protocol))?;
            (&raw mut (*handle).setup).write(None);
            (&raw mut (*handle).setting_up).write(SettingUp::new());
        }
        // SAFETY: as promised above.
        unsafe { write(tracker, handle) }
    })
}

/// Writes what `make` returns to `room`.
///
/// # Safety
/// `room` is memory for a `T`.
// Not inlined: keeps its stack frame out of the caller's.
#[inline(never)]
unsafe fn place<T>(room: *mut T, make: impl FnOnce() -> Result<T, Status>) -> Result<(), Status> {
    let made = make()?;
    // SAFETY: as promised above.
    unsafe { room.write(made) };
    Ok(())
}

fn clock(settings: &TrackerSettings) -> Result<ClockEstimator, Status> {
    ClockEstimator::new(ClockConfig {
        least_delay: Micros(settings.least_delay_us),
        ..ClockConfig::default()
    })
    .map_err(|_| Status::TrackerSettings)
}

#[inline(always)]
fn estimator(settings: &TrackerSettings) -> Result<GazeEstimator, Status> {
    let position = Vec3::from_array(settings.position);
    let orientation = Quat::from_array(settings.orientation);
    let eyes = [
        (EyeChoice::Combined, Eyes::Combined),
        (EyeChoice::Left, Eyes::Left),
        (EyeChoice::Right, Eyes::Right),
        (EyeChoice::None, Eyes::HeadOnly),
    ];
    let eyes = eyes
        .iter()
        .find(|(number, _)| *number as u32 == settings.eyes);
    let (_, eyes) = *eyes.ok_or(Status::UnknownChoice)?;
    GazeEstimator::new(EstimatorConfig {
        room_from_tracker: RoomFromTracker {
            position,
            orientation,
        },
        resting_head: HeadPose {
            position,
            orientation,
        },
        head_tracked: settings.head_tracked != 0,
        eyes,
        ..EstimatorConfig::default()
    })
    .map_err(|_| Status::TrackerSettings)
}

fn hertz(settings: &TrackerSettings) -> Result<Option<u16>, Status> {
    match u16::try_from(settings.hertz) {
        Ok(0) => Ok(None),
        Ok(hertz) => Ok(Some(hertz)),
        Err(_) => Err(Status::TrackerSettings),
    }
}

/// Takes the next bytes of the tracker's stream, in pieces of any length. The last
/// byte came in at `arrival_us` by the caller's clock, which must never go back:
/// microseconds. Noise is dropped and counted.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, used by nobody else during the call; `bytes`
/// is NULL or points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_feed(
    tracker: *mut Tracker,
    bytes: *const u8,
    length: usize,
    arrival_us: u64,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let (tracker, bytes) = unsafe { (exclusive(tracker)?, slice(bytes, length)?) };
        tracker.feed(bytes, Micros(arrival_us));
        Ok(Status::Ok)
    })
}

impl Tracker {
    fn feed(&mut self, bytes: &[u8], arrival: Micros) {
        let Self {
            device,
            clock,
            gaze,
            setup,
            setting_up,
            hertz: _,
        } = self;
        if let Some(session) = setup {
            session.on_bytes(bytes.len());
        }
        let is_complete = setup.as_ref().is_none_or(|session| session.is_complete());
        let is_set_up = setting_up.is_over(is_complete, arrival);
        device.feed(bytes, arrival, &mut |event| {
            if let Some(session) = setup {
                session.on_event(&event);
            }
            match &event {
                Event::Sample(sample) if is_set_up => {
                    let stamp = clock.stamp(sample, &mut |_| {});
                    gaze.push(sample, stamp.time, &mut |_| {});
                }
                Event::Message(message) => gaze.on_message(message, &mut |_| {}),
                _ => {}
            }
        });
    }
}

/// Estimates where the viewer looks at `display_us`, when the frame will be seen,
/// by the clock of shisen_tracker_feed: microseconds. There is always an answer;
/// its `state` says how far it can be relied on.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, used by nobody else during the call; `gaze`
/// is NULL, misaligned, or points to memory for a gaze.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_gaze(
    tracker: *mut Tracker,
    display_us: u64,
    gaze: *mut Gaze,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let tracker = unsafe { exclusive(tracker) }?;
        let estimate = tracker.gaze.estimate(Micros(display_us), &mut |_| {});
        let sight = estimate.line_of_sight;
        let state = match estimate.state {
            State::Fresh => GazeState::Fresh,
            State::Hold => GazeState::Hold,
            State::Widened => GazeState::Widened,
            State::HeadDirection => GazeState::HeadDirection,
            State::FullQuality => GazeState::FullQuality,
        };
        let found = Gaze {
            position: sight.position().to_array(),
            forward: sight.forward().to_array(),
            up: sight.up().to_array(),
            widen: estimate.widen,
            state: state as u32,
            blink: estimate.blink.into(),
            age_us: estimate.gaze_age.map_or(SHISEN_NEVER, |age| age.0),
        };
        // SAFETY: as promised above.
        unsafe { write(gaze, found) }
    })
}

/// Says what became of the bytes so far.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made; `counts` is NULL, misaligned, or
/// points to memory for them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_count(
    tracker: *const Tracker,
    counts: *mut TrackerCounts,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let found = unsafe { shared(tracker) }?.device.counts();
        let found = TrackerCounts {
            bytes: found.bytes,
            samples: found.samples,
            messages: found.messages,
            lost: found.lost,
            dropped_bytes: found.dropped_bytes,
            dropped: found.dropped,
        };
        // SAFETY: as promised above.
        unsafe { write(counts, found) }
    })
}

/// Forgets the piece of a record that has come in, as after bytes were lost: an
/// overrun of the line, or a device that was unplugged. What is known of the
/// gaze, and the counts, stay.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, used by nobody else during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_resync(tracker: *mut Tracker) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let tracker = unsafe { exclusive(tracker) }?;
        tracker.device.reset();
        Ok(Status::Ok)
    })
}

/// Begins to set the device up: shisen_tracker_poll then says what to send. A
/// device that sends without being asked needs no set-up. Until the device has
/// got all commands, but for at most 800 ms, its samples are ignored: their units
/// may be wrong.
///
/// `memory`, `memory_size`: SHISEN_SETUP_SIZE bytes at a multiple of SHISEN_ALIGNMENT,
/// which stay the tracker's until polling it says SHISEN_SETUP_ACTION_DONE or
/// fails.
/// `reset`: whether the device is reset first (1), which takes some devices ten
/// seconds, or not (0).
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, used by nobody else during the call;
/// `memory` is NULL, misaligned, or points to `memory_size` bytes, which nobody
/// else uses until the set-up is done or has failed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_set_up(
    tracker: *mut Tracker,
    memory: *mut c_void,
    memory_size: usize,
    reset: u32,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let tracker = unsafe { exclusive(tracker) }?;
        let session = room::<Session>(memory, memory_size, 0)?;
        let script = tracker.device.start(tracker.hertz, reset != 0);
        // SAFETY: there is room.
        unsafe { session.write(Session::new(script)) };
        // SAFETY: it was just written, and is the tracker's from now on.
        tracker.setup = Some(unsafe { exclusive(session) }?);
        tracker.setting_up = SettingUp::new();
        Ok(Status::Ok)
    })
}

/// Says what is to be done to set the device up, at `now_us` on the clock of
/// shisen_tracker_feed: microseconds. It never waits.
///
/// A failure of the device (SHISEN_STATUS_DEVICE_...) is said once; then setting
/// it up is over, and what it sends is believed.
///
/// `buffer`, `buffer_size`: for bytes to be sent; SHISEN_MOST_COMMAND_BYTES.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, used by nobody else during the call;
/// `buffer` is NULL or points to `buffer_size` bytes; `setup` is NULL,
/// misaligned, or points to memory for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_tracker_poll(
    tracker: *mut Tracker,
    now_us: u64,
    buffer: *mut u8,
    buffer_size: usize,
    setup: *mut Setup,
) -> Status {
    settled(|| {
        let mut found = Setup {
            action: SetupAction::Done as u32,
            ..Setup::default()
        };
        // SAFETY: as promised above.
        let (tracker, buffer) = unsafe {
            write(setup, found)?;
            (exclusive(tracker)?, slice_mut(buffer, buffer_size)?)
        };
        if buffer.len() < SHISEN_MOST_COMMAND_BYTES {
            return Err(Status::MemoryTooSmall);
        }
        let Some(session) = &mut tracker.setup else {
            return Ok(Status::Ok);
        };
        let now = Micros(now_us);
        tracker.setting_up.begin(now);
        match session.poll(now) {
            Action::Send(bytes) => {
                let room = buffer.get_mut(..bytes.len());
                let room = room.ok_or(Status::DeviceCommands)?;
                for (to, from) in room.iter_mut().zip(bytes) {
                    *to = *from;
                }
                found.action = SetupAction::Send as u32;
                found.length = bytes.len();
                tracker.device.on_sent(room, now);
            }
            Action::Speed(baud) => {
                found.action = SetupAction::Speed as u32;
                found.baud = baud;
            }
            Action::Wait(until) => {
                found.action = SetupAction::Wait as u32;
                found.until_us = until.0;
            }
            Action::Done => tracker.setup = None,
            Action::Failed(failure) => {
                tracker.setup = None;
                return Err(failure.into());
            }
        }
        // SAFETY: as promised above.
        unsafe { write(setup, found) }
    })
}

#[cfg(test)]
mod tests;
