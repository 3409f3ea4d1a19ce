//! Counts instructions by the emulator's clock: each takes a nanosecond.

use core::panic::PanicInfo;
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_semihosting::{debug, hprintln};

/// The clock of mps2-an500 counts at 25 MHz.
const INSTRUCTIONS_PER_TICK: u32 = 40;
/// The counter's range.
const RELOAD: u32 = 0x00FF_FFFF;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{info}");
    end(false)
}

/// Starts the clock.
pub fn start() {
    if let Some(mut peripherals) = cortex_m::Peripherals::take() {
        let clock = &mut peripherals.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(RELOAD);
        clock.clear_current();
        clock.enable_counter();
    }
}

/// Returns the mean instructions of a run, over `repeats` runs.
#[inline(never)]
pub fn instructions(repeats: u32, mut run: impl FnMut()) -> u32 {
    let start = SYST::get_current();
    for _ in 0..repeats {
        run();
    }
    let ticks = start.wrapping_sub(SYST::get_current()) & RELOAD;
    ticks * INSTRUCTIONS_PER_TICK / repeats
}

/// Ends the emulator, with an error code if a check failed.
pub fn end(well: bool) -> ! {
    debug::exit(if well {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
    loop {}
}
