//! Calls every function that takes numbers with hostile ones: it must return an error status or
//! finite results. Each test has the name of its function. Functions without a test only write
//! numbers, take handles whose numbers were checked, take bytes, which the fuzz programs damage,
//! or share the checks of `shisen_screen_check`.

use crate::dome::{self, Dome};
use crate::frame;
#[cfg(feature = "link")]
use crate::protocol::Protocol;
use crate::screen::{self, Screen};
use crate::spectrum;
use crate::status::Status;
#[cfg(feature = "link")]
use crate::tracker::{self, SHISEN_TRACKER_SIZE, TrackerSettings};
use core::mem::MaybeUninit;
use core::ptr::null_mut;

/// Numbers that break arithmetic.
const HOSTILE: [f32; 8] = [
    f32::NAN,
    f32::INFINITY,
    0.0,
    1e-45,
    1.0,
    1e18,
    1e30,
    f32::MAX,
];

/// Calls `check` with the sane numbers, then with each hostile number in each place, in each two
/// places, and in all.
fn with_hostile_numbers<const N: usize>(sane: [f32; N], check: impl Fn([f32; N], bool)) {
    check(sane, true);
    for number in HOSTILE.into_iter().flat_map(|number| [number, -number]) {
        check([number; N], false);
        for first in 0..N {
            for second in first..N {
                let mut numbers = sane;
                numbers[first] = number;
                numbers[second] = number;
                check(numbers, false);
            }
        }
    }
}

fn all_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|number| number.is_finite())
}

fn screen_of(numbers: &[f32; 9]) -> (Status, Screen) {
    let mut made = MaybeUninit::<Screen>::zeroed();
    let [a, b, c] = [0, 3, 6].map(|at| numbers[at..].as_ptr());
    // SAFETY: three numbers each, and room for a screen.
    let status = unsafe { screen::shisen_screen_from_corners(a, b, c, 16, 8, made.as_mut_ptr()) };
    // SAFETY: it is made of numbers, for which all bits zero will do.
    (status, unsafe { made.assume_init() })
}

const CORNERS: [f32; 9] = [-1.0, 0.0, -1.5, 1.0, 0.0, -1.5, -1.0, 2.0, -1.5];

/// Corners are not judged before somebody looks at them.
#[test]
fn shisen_screen_from_corners() {
    with_hostile_numbers(CORNERS, |numbers, _| {
        let (status, made) = screen_of(&numbers);
        assert_eq!(status, Status::Ok, "{numbers:?}");
        assert_eq!((made.columns, made.rows), (16, 8));
        let of = [made.first_pixel, made.column_step, made.row_step];
        let small = numbers.iter().all(|number| number.abs() <= 1.0e30);
        assert!(
            !small || all_finite(of.as_flattened()),
            "{numbers:?} {made:?}"
        );
    });
}

#[test]
fn shisen_screen_check() {
    let mut sane = [0.1; 12];
    sane[..9].copy_from_slice(&CORNERS);
    with_hostile_numbers(sane, |numbers, is_sane| {
        let mut corners = [0.0; 9];
        corners.copy_from_slice(&numbers[..9]);
        let (_, made) = screen_of(&corners);
        // SAFETY: a screen, and three numbers.
        let status = unsafe { frame::shisen_screen_check(&raw const made, numbers[9..].as_ptr()) };
        let is_seen = status == Status::Ok;
        assert!(is_seen || !is_sane, "{status:?}");
        assert!(!is_seen || all_finite(&numbers), "{numbers:?}");
    });
}

#[test]
fn shisen_dome_init() {
    with_hostile_numbers([0.1, 1.5, 0.2], |position, is_sane| {
        let mut made = MaybeUninit::<Dome>::zeroed();
        // SAFETY: room for a dome, and three numbers.
        let status = unsafe { dome::shisen_dome_init(made.as_mut_ptr(), position.as_ptr(), 64) };
        assert_eq!(status, Status::Ok);
        // SAFETY: it is made of numbers.
        let made = unsafe { made.assume_init() };
        // A bad place is refused when a view is made from it.
        let is_seen = made.view().is_ok();
        assert!(is_seen || !is_sane);
        assert!(!is_seen || all_finite(&position), "{position:?}");
    });
}

#[test]
fn shisen_spectrum_open() {
    with_hostile_numbers([400.0, 700.0], |[from, to], _| {
        let mut memory = [0u64; 1 << 11];
        let mut handle = null_mut();
        let (room, bytes) = (memory.as_mut_ptr().cast(), size_of_val(&memory));
        // SAFETY: `bytes` bytes of memory, and room for a handle.
        let status =
            unsafe { spectrum::shisen_spectrum_open(room, bytes, 6, from, to, &raw mut handle) };
        let is_open = status == Status::Ok;
        assert_eq!(is_open, !handle.is_null());
        assert!(
            !is_open || (360.0 <= from && from < to && to <= 830.0),
            "{from} {to}"
        );
    });
}

#[cfg(feature = "link")]
#[test]
fn shisen_tracker_init() {
    let sane = [0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 1.0];
    with_hostile_numbers(sane, |numbers, is_sane| {
        let mut settings = MaybeUninit::<TrackerSettings>::zeroed();
        let made = settings.as_mut_ptr();
        // SAFETY: room for settings.
        let status = unsafe { tracker::shisen_tracker_settings_init(made, Protocol::Link as u32) };
        assert_eq!(status, Status::Ok);
        // SAFETY: they were just written.
        let mut settings = unsafe { settings.assume_init() };
        settings.position.copy_from_slice(&numbers[..3]);
        settings.orientation.copy_from_slice(&numbers[3..]);
        let mut memory = [0u64; SHISEN_TRACKER_SIZE / 8];
        let mut handle = null_mut();
        let (room, bytes) = (memory.as_mut_ptr().cast(), size_of_val(&memory));
        // SAFETY: `bytes` bytes of memory, and room for a handle.
        let status = unsafe {
            tracker::shisen_tracker_init(room, bytes, &raw const settings, &raw mut handle)
        };
        let is_made = status == Status::Ok;
        assert!(is_made || !is_sane, "{status:?}");
        assert_eq!(is_made, !handle.is_null());
        assert!(!is_made || all_finite(&numbers), "{numbers:?}");
    });
}
