//! The log: `defmt` frames over a serial port of their own. The texts are on the host,
//! not in flash.

use crate::board::{self, LOG};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::RestoreState;

struct State {
    encoder: UnsafeCell<defmt::Encoder>,
    before: UnsafeCell<RestoreState>,
    taken: AtomicBool,
}

// SAFETY: used within a critical section only, on one core.
unsafe impl Sync for State {}

static STATE: State = State {
    encoder: UnsafeCell::new(defmt::Encoder::new()),
    before: UnsafeCell::new(RestoreState::invalid()),
    taken: AtomicBool::new(false),
};

#[defmt::global_logger]
struct Logger;

// SAFETY: between `acquire` and `release` interrupts are off.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: released below, in this order.
        let before = unsafe { critical_section::acquire() };
        // Logging inside logging cannot happen, and could not be handled here.
        if STATE.taken.swap(true, Ordering::Relaxed) {
            return;
        }
        // SAFETY: within the critical section.
        unsafe {
            *STATE.before.get() = before;
            (*STATE.encoder.get()).start_frame(|bytes| LOG.send(bytes));
        }
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: within the critical section of `acquire`.
        unsafe {
            (*STATE.encoder.get()).end_frame(|bytes| LOG.send(bytes));
            STATE.taken.store(false, Ordering::Relaxed);
            critical_section::release(*STATE.before.get());
        }
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: within the critical section of `acquire`.
        unsafe { (*STATE.encoder.get()).write(bytes, |bytes| LOG.send(bytes)) };
    }
}

defmt::timestamp!("{=u64:us}", board::micros(board::ticks()).0);
