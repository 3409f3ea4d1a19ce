//! The board: its serial ports, its clock and its memory. For another board, change
//! this file and `memory.x`.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m_rt::exception;
use shisen_tracker::time::Micros;

/// Address of the scene: the emulator loads it there, a real board has it in flash.
const SCENE: usize = 0x6000_0000;
/// Bytes of memory from that address on.
const SCENE_REGION: usize = 16 << 20;

/// Bytes below the top of the stack that are painted to measure its depth.
const PAINTED: usize = 16 << 10;
const PAINT: u32 = 0x5aa5_c33c;

/// Instructions for each tick: the clock counts at 25 MHz, and the emulator makes an instruction
/// take 1 ns.
pub const INSTRUCTIONS_PER_TICK: u32 = 40;
const TICKS_PER_MICROSECOND: u64 = 25;
/// The counter's range.
const RELOAD: u32 = 0x00FF_FFFF;

/// Returns all bytes from the scene's address to the end of that memory.
pub fn scene_region() -> &'static [u8] {
    // SAFETY: the board has this memory, and nothing writes to it.
    unsafe { core::slice::from_raw_parts(SCENE as *const u8, SCENE_REGION) }
}

/// A serial port of the board: an APB UART of Arm's CMSDK.
#[derive(Clone, Copy)]
pub struct Uart(usize);

/// The tracker's port.
pub const TRACKER: Uart = Uart(0x4000_4000);
/// The display's port: reports and pixels out, orders in.
pub const DISPLAY: Uart = Uart(0x4000_5000);
/// The log's port.
pub const LOG: Uart = Uart(0x4000_6000);

impl Uart {
    const DATA: usize = 0x00;
    const STATE: usize = 0x04;
    const CONTROL: usize = 0x08;
    const INTERRUPT: usize = 0x0C;
    const DIVIDER: usize = 0x10;

    const TRANSMITTER_FULL: u32 = 1 << 0;
    const RECEIVER_FULL: u32 = 1 << 1;
    const RECEIVER_OVERRUN: u32 = 1 << 3;
    const RECEIVER_INTERRUPT: u32 = 1 << 1;

    /// Number of looks at a full transmitter before the rest is dropped: about a second. The
    /// emulator's transmitter waits for its reader, which other programs may hold up; a port
    /// with DMA needs no such limit.
    const PATIENCE: u32 = 100_000_000;

    fn read(self, register: usize) -> u32 {
        // SAFETY: a register of the board.
        unsafe { ((self.0 + register) as *const u32).read_volatile() }
    }

    fn write(self, register: usize, value: u32) {
        // SAFETY: a register of the board.
        unsafe { ((self.0 + register) as *mut u32).write_volatile(value) }
    }

    /// Turns the port on, with an interrupt for each received byte if `receives`.
    pub fn enable(self, receives: bool) {
        self.write(Self::DIVIDER, 16);
        self.write(Self::CONTROL, if receives { 0b1011 } else { 0b0001 });
    }

    /// Returns the byte that has come in, and whether others were lost before it.
    pub fn receive(self) -> Option<(u8, bool)> {
        self.write(Self::INTERRUPT, Self::RECEIVER_INTERRUPT);
        let state = self.read(Self::STATE);
        if state & Self::RECEIVER_FULL == 0 {
            return None;
        }
        let lost = state & Self::RECEIVER_OVERRUN != 0;
        if lost {
            self.write(Self::STATE, Self::RECEIVER_OVERRUN);
        }
        Some((self.read(Self::DATA) as u8, lost))
    }

    /// Sends bytes one after another. If the transmitter stays full, the rest is dropped, so that
    /// the board never waits for ever.
    pub fn send(self, bytes: &[u8]) {
        for &byte in bytes {
            let mut left = Self::PATIENCE;
            while self.read(Self::STATE) & Self::TRANSMITTER_FULL != 0 && left > 0 {
                left -= 1;
            }
            if left == 0 {
                return;
            }
            self.write(Self::DATA, byte.into());
        }
    }
}

/// Number of times that the counter has wrapped.
static WRAPS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    WRAPS.fetch_add(1, Ordering::Relaxed);
}

/// The board with its clock running and both ports listening.
pub struct Board(());

impl Board {
    /// Returns the board once, and `None` afterwards.
    pub fn take() -> Option<Self> {
        let mut peripherals = cortex_m::Peripherals::take()?;
        paint();
        let clock = &mut peripherals.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(RELOAD);
        clock.clear_current();
        // SAFETY: interrupts are still off. The count of wraps has the highest priority.
        unsafe { peripherals.SCB.set_priority(SystemHandler::SysTick, 0) };
        clock.enable_interrupt();
        clock.enable_counter();
        TRACKER.enable(true);
        DISPLAY.enable(true);
        LOG.enable(false);
        Some(Self(()))
    }

    /// Turns on the interrupts for received bytes.
    pub fn listen(&self) {
        for line in [crate::line::TRACKER_RECEIVES, crate::line::DISPLAY_RECEIVES] {
            // SAFETY: the interrupts use statics only.
            unsafe { NVIC::unmask(line) };
        }
    }
}

/// Returns the ticks since the start.
pub fn ticks() -> u64 {
    loop {
        let wraps = WRAPS.load(Ordering::Relaxed);
        let count = SYST::get_current();
        let pending = SCB::is_pendst_pending();
        if wraps == WRAPS.load(Ordering::Relaxed) {
            // During another interrupt, a wrap may not be counted yet.
            let wraps = wraps + u32::from(pending && count > RELOAD / 2);
            return (u64::from(wraps) << 24) + u64::from(RELOAD - (count & RELOAD));
        }
    }
}

/// Returns the time at a number of [`ticks`].
pub fn micros(ticks: u64) -> Micros {
    Micros(ticks / TICKS_PER_MICROSECOND)
}

/// Returns the instructions between two times.
pub fn instructions(from: u64, to: u64) -> u64 {
    to.saturating_sub(from) * u64::from(INSTRUCTIONS_PER_TICK)
}

unsafe extern "C" {
    static _stack_start: u32;
    static __sdata: u32;
    static __edata: u32;
    static __ebss: u32;
    static __sidata: u32;
    static __vector_table: u32;
}

/// Returns the bytes of flash and of static memory.
pub fn sizes() -> (u32, u32) {
    // The linker gives these addresses; no memory is read.
    let at = |symbol: *const u32| symbol as u32;
    let (data, end) = (at(&raw const __sdata), at(&raw const __edata));
    let flash = at(&raw const __sidata) + (end - data) - at(&raw const __vector_table);
    (flash, at(&raw const __ebss) - data)
}

/// Returns the part of the stack that is painted.
fn stack() -> (*mut u32, *mut u32) {
    let top = &raw const _stack_start as *mut u32;
    (top.wrapping_byte_sub(PAINTED), top)
}

fn paint() {
    let (mut at, _) = stack();
    // Well below the callers' stack frames.
    let end = cortex_m::register::msp::read() as usize - 256;
    while (at as usize) < end {
        // SAFETY: memory below the stack pointer, which is not in use.
        unsafe { at.write_volatile(PAINT) };
        at = at.wrapping_add(1);
    }
}

/// Returns the bytes of the stack that have been used.
pub fn stack_used() -> u32 {
    let (mut at, top) = stack();
    // SAFETY: memory of the stack.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    top as u32 - at as u32
}
