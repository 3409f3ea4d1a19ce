use super::*;
use crate::memory::SHISEN_ALIGNMENT;
#[cfg(feature = "link")]
use shisen_tracker::{link, sample::Reading, sample::Sample, time::DeviceTime};

const WORDS: usize = SHISEN_TRACKER_SIZE.div_ceil(SHISEN_ALIGNMENT);

fn settings(protocol: Protocol) -> TrackerSettings {
    let mut settings = core::mem::MaybeUninit::uninit();
    // SAFETY: there is memory for them.
    let made = unsafe { shisen_tracker_settings_init(settings.as_mut_ptr(), protocol as u32) };
    assert_eq!(made, Status::Ok);
    // SAFETY: they were just made.
    unsafe { settings.assume_init() }
}

/// Runs `run` with a tracker in memory of the promised size.
fn with_tracker(settings: &TrackerSettings, run: impl FnOnce(Status, *mut Tracker)) {
    // C may put it at any multiple of 8 bytes.
    let mut memory = [0u64; WORDS + 1];
    let start = memory
        .as_mut_ptr()
        .wrapping_add(usize::from(settings.hertz > 0));
    let mut tracker = null_mut();
    // SAFETY: memory of the promised size.
    let status = unsafe {
        shisen_tracker_init(
            start.cast(),
            SHISEN_TRACKER_SIZE,
            settings,
            &raw mut tracker,
        )
    };
    run(status, tracker);
}

#[test]
fn every_protocol_that_is_built_is_set_up_in_the_buffer_that_is_promised() {
    for protocol in Protocol::ALL {
        for hertz in [0, 60] {
            let mut settings = settings(protocol);
            settings.hertz = hertz;
            with_tracker(&settings, |status, tracker| {
                if status == Status::NotBuilt {
                    return;
                }
                assert_eq!(status, Status::Ok, "{protocol:?}");
                assert!(set_up(tracker) >= usize::from(protocol != Protocol::Asl));
            });
        }
    }
}

/// Sets up a device that does not answer; returns how many times bytes were sent.
fn set_up(tracker: *mut Tracker) -> usize {
    let mut memory = [0u64; SHISEN_SETUP_SIZE.div_ceil(SHISEN_ALIGNMENT)];
    let mut buffer = [0u8; SHISEN_MOST_COMMAND_BYTES];
    let mut setup = Setup::default();
    // SAFETY: memory of the promised size.
    let begun =
        unsafe { shisen_tracker_set_up(tracker, memory.as_mut_ptr().cast(), SHISEN_SETUP_SIZE, 1) };
    assert_eq!(begun, Status::Ok);
    let (mut now, mut sent) = (0, 0);
    loop {
        // SAFETY: memory of the promised size.
        let status = unsafe {
            shisen_tracker_poll(
                tracker,
                now,
                buffer.as_mut_ptr(),
                buffer.len(),
                &raw mut setup,
            )
        };
        if status != Status::Ok {
            assert_eq!(status, Status::DeviceSilent);
            // Noise on the line does not hide that the device is silent.
            // SAFETY: the buffer has 9 bytes.
            let fed = unsafe { shisen_tracker_feed(tracker, buffer.as_ptr(), 9, now) };
            assert_eq!(fed, Status::Ok);
            return sent;
        }
        sent += usize::from(setup.action == SetupAction::Send as u32);
        assert!(setup.length <= buffer.len());
        now = now.max(setup.until_us);
    }
}

/// Returns a record of our link: the viewer looks straight ahead.
#[cfg(feature = "link")]
fn record(encoder: &mut link::Encoder, microseconds: u64) -> link::Frame {
    let mut sample = Sample::arrived(Micros(microseconds));
    sample.device_time = Some(DeviceTime::unwrapped(microseconds));
    sample.head.position = Some(Reading::tracked(Vec3::ZERO));
    sample.head.orientation = Some(Reading::tracked(Quat::IDENTITY));
    sample.combined.direction = Some(Reading::tracked(Vec3::NEG_Z));
    encoder.sample(&sample)
}

#[test]
#[cfg(feature = "link")]
fn samples_count_once_a_device_has_been_told_everything() {
    let mut memory = [0u64; SHISEN_SETUP_SIZE.div_ceil(SHISEN_ALIGNMENT)];
    let mut encoder = link::Encoder::new();
    with_tracker(&settings(Protocol::Link), |_, tracker| {
        let setup = memory.as_mut_ptr().cast();
        // SAFETY: memory of the promised size.
        let begun = unsafe { shisen_tracker_set_up(tracker, setup, SHISEN_SETUP_SIZE, 0) };
        assert_eq!(begun, Status::Ok);
        // SAFETY: a tracker that was made, nobody else's in what follows.
        let tracker = unsafe { &mut *tracker };
        let mut state = |tracker: &mut Tracker, at: u64| {
            tracker.feed(&record(&mut encoder, at), Micros(at));
            tracker.gaze.estimate(Micros(at), &mut |_| {}).state
        };
        assert_eq!(state(tracker, 1_000), State::FullQuality);
        tracker.setting_up.begin(Micros(2_000));
        let said = |tracker: &mut Tracker| {
            let session = tracker.setup.as_mut().unwrap();
            matches!(session.poll(Micros(2_000)), Action::Send(_))
        };
        assert!(said(tracker));
        assert_eq!(state(tracker, 3_000), State::Fresh);
    });
}
