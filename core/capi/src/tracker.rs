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

/// Bytes of memory for a tracker's handle, whatever its protocol.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_TRACKER_SIZE: usize = 6592;
/// Bytes of memory for a tracker's handle, whatever its protocol.
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

/// How many reasons there are to drop bytes: see shisen_drop_reason.
pub const SHISEN_DROP_REASONS: usize = 9;

/// An age of what never came.
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
    /// In the caller's memory, while the device is set up.
    setup: Option<&'static mut Session>,
    /// Begins with the first poll; a reset gets no longer time.
    setting_up: SettingUp,
}

/// Which eye's line of sight is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum EyeChoice {
    /// The device's combined eye; where there is none, the mean of both, or the
    /// one that is seen.
    Combined = 0,
    /// The left one alone.
    Left = 1,
    /// The right one alone.
    Right = 2,
    /// None: the head's direction counts.
    None = 3,
}

/// How a tracker is used: see shisen_tracker_settings_init.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrackerSettings {
    /// What it speaks: a shisen_protocol.
    pub protocol: u32,
    /// Which eye counts: a shisen_eye_choice.
    pub eyes: u32,
    /// Whether it measures the head; where not (0), the head rests at
    /// `position` and `orientation`.
    pub head_tracked: u32,
    /// Samples per second that it is asked for when it is set up, where its
    /// protocol has words for that; at most 65,535. 0: as the device likes.
    pub hertz: u32,
    /// From a measurement to the arrival of its last byte when nothing is in the
    /// way: microseconds, at most 1,000,000.
    pub least_delay_us: u64,
    /// The tracker's origin in the room, metres.
    pub position: [f32; 3],
    /// The tracker's axes in the room: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// How much of a gaze can be relied on. Worse is greater.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum GazeState {
    /// Gaze and head are new enough.
    Fresh = 0,
    /// The last gaze is held: a blink, a reflection, a few lost samples.
    Hold = 1,
    /// The gaze is where it was, more or less: the field of full detail widens.
    Widened = 2,
    /// Where the eyes look is not known; the head faces the line of sight.
    HeadDirection = 3,
    /// Nothing is known: full detail everywhere.
    FullQuality = 4,
}

/// Where the viewer looks.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Gaze {
    /// Between the eyes: metres, in the room.
    pub position: [f32; 3],
    /// The line of sight: a unit vector, in the room. To begin a frame it may
    /// have any length but zero.
    pub forward: [f32; 3],
    /// Towards the top of the head: a unit vector at a right angle to `forward`.
    /// To begin a frame it may have any length but zero, at any angle but
    /// along `forward`.
    pub up: [f32; 3],
    /// By how much the field of full detail has to be wider: radians. From π on
    /// it is everything.
    pub widen: f32,
    /// How much can be relied on: a shisen_gaze_state.
    pub state: u32,
    /// Whether the eyes are shut, or were when last heard of: 0 or 1.
    pub blink: u32,
    /// How old the newest gaze is at the time of display: microseconds;
    /// SHISEN_NEVER where none ever came.
    pub age_us: u64,
}

/// Why bytes were dropped: an index into `dropped` of shisen_tracker_counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum DropReasonNumber {
    /// Between records: what stands there starts none.
    OutOfStep = 0,
    /// A record broke off before its end.
    Truncated = 1,
    /// The record's length is not one that the protocol has.
    Length = 2,
    /// The record's checksum does not match.
    Checksum = 3,
    /// A field holds a value that the protocol does not allow.
    Field = 4,
    /// A number is infinite, NaN, or not one the sensor can measure.
    OutOfRange = 5,
    /// A direction or a quaternion has no length.
    NotUnit = 6,
    /// A version or a kind of record that is not known here.
    Unknown = 7,
    /// The record repeats the one before.
    Duplicate = 8,
}

/// What became of a tracker's bytes. The counts stop at their largest value.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct TrackerCounts {
    /// Bytes taken.
    pub bytes: u64,
    /// Records with a sample.
    pub samples: u64,
    /// Records with something else, such as a fault or an answer.
    pub messages: u64,
    /// Records that the device's own count says are missing.
    pub lost: u64,
    /// Bytes thrown away.
    pub dropped_bytes: u64,
    /// Times that bytes were thrown away, by shisen_drop_reason.
    pub dropped: [u32; SHISEN_DROP_REASONS],
}

/// What is to be done to set a device up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SetupAction {
    /// Send the bytes in the buffer, `length` of them, then poll again at once.
    Send = 0,
    /// Change the line to `baud` once what was sent is out, then poll again at
    /// once.
    Speed = 1,
    /// Poll again at `until_us`, and whenever bytes were fed.
    Wait = 2,
    /// It is set up, or nothing has to be. The memory for setting it up is free.
    Done = 3,
}

/// What shisen_tracker_poll says.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct Setup {
    /// What to do: a shisen_setup_action.
    pub action: u32,
    /// Bits per second.
    pub baud: u32,
    /// Bytes in the buffer.
    pub length: usize,
    /// On the caller's clock: microseconds.
    pub until_us: u64,
}

/// Bytes of memory for a tracker's handle, as SHISEN_TRACKER_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_tracker_size() -> usize {
    SHISEN_TRACKER_SIZE
}

/// Bytes of memory for setting a device up, as SHISEN_SETUP_SIZE.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_setup_size() -> usize {
    SHISEN_SETUP_SIZE
}

/// The settings of a tracker with this protocol (a shisen_protocol) whose origin
/// and axes are the room's, and which measures what devices of the protocol do.
///
/// # Safety
/// `settings` is NULL, misaligned, or points to memory for them.
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

/// Makes a tracker that has heard nothing yet.
///
/// `memory`, `memory_size`: for the handle, which needs SHISEN_TRACKER_SIZE bytes
/// at a multiple of SHISEN_ALIGNMENT. What is in it may be given up at any time.
/// `tracker`: the handle; NULL after a failure.
///
/// # Safety
/// Each pointer is NULL, misaligned, or points to as much memory as is said,
/// which nobody else uses meanwhile.
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
        // One after another, in place: the stack would have to hold them all.
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

/// Makes something where it is to be.
///
/// # Safety
/// There is room for it.
// Not a part of its caller, who would keep the room of each of them.
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

/// Takes the next bytes of the tracker's stream, of which the last came in at
/// `arrival_us` on the caller's clock, which never goes back: microseconds. In
/// pieces of any length; noise is thrown away and counted.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, nobody else's meanwhile; `bytes`
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
        let has_said_all = setup.as_ref().is_none_or(|session| session.has_said_all());
        let is_set_up = setting_up.is_over(has_said_all, arrival);
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

/// Says where the viewer looks at `display_us`, which is when the frame will be
/// seen, on the clock of shisen_tracker_feed: microseconds. Whatever has been
/// fed, there is an answer; its `state` says what it is worth.
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, nobody else's meanwhile; `gaze`
/// is NULL, misaligned, or points to memory for one.
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
/// `tracker` is NULL or a tracker that was made, nobody else's meanwhile.
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
/// device that sends without being asked needs none of it. Until the device has
/// been told everything, but at most for 800 ms, its samples count for nothing:
/// they may be in other units than it is asked for.
///
/// `memory`, `memory_size`: SHISEN_SETUP_SIZE bytes at a multiple of SHISEN_ALIGNMENT,
/// which stay the tracker's until polling it says SHISEN_SETUP_ACTION_DONE or
/// fails.
/// `reset`: whether the device is reset first (1), which with some takes ten
/// seconds, or not (0).
///
/// # Safety
/// `tracker` is NULL or a tracker that was made, nobody else's meanwhile;
/// `memory` is NULL, misaligned, or points to `memory_size` bytes, nobody else's
/// for as long as is said.
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
/// `tracker` is NULL or a tracker that was made, nobody else's meanwhile;
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
