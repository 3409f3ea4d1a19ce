//! The board: its serial ports, its clock and its memory. On another board this
//! file and `memory.x` are what changes.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m_rt::exception;
use shisen_tracker::time::Micros;

/// Where a scene is: the emulator puts it there, a real board has it in flash.
const SCENE: usize = 0x6000_0000;
/// How much there is behind it.
const SCENE_REGION: usize = 16 << 20;

/// Bytes under the top of the stack in which its depth is looked for.
const PAINTED: usize = 16 << 10;
const PAINT: u32 = 0x5aa5_c33c;

/// The clock counts at 25 MHz, and the emulator makes an instruction take 1 ns.
pub const INSTRUCTIONS_PER_TICK: u32 = 40;
const TICKS_PER_MICROSECOND: u64 = 25;
/// The counter's range.
const RELOAD: u32 = 0x00FF_FFFF;

/// All bytes from where the scene is to the end of that memory.
pub fn scene_region() -> &'static [u8] {
    // SAFETY: the board has this memory, and nothing writes to it.
    unsafe { core::slice::from_raw_parts(SCENE as *const u8, SCENE_REGION) }
}

/// A serial port of the board: an APB UART of Arm's CMSDK.
#[derive(Clone, Copy)]
pub struct Uart(usize);

/// From the tracker.
pub const TRACKER: Uart = Uart(0x4000_4000);
/// Reports and pixels out, orders in.
pub const DISPLAY: Uart = Uart(0x4000_5000);
/// The log.
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

    /// How often a full transmitter is looked at before what is to be sent is given up:
    /// about a second. The emulator's goes on when its reader does, whom other programs
    /// can keep waiting; a port with DMA needs none.
    const PATIENCE: u32 = 100_000_000;

    fn read(self, register: usize) -> u32 {
        // SAFETY: a register of the board.
        unsafe { ((self.0 + register) as *const u32).read_volatile() }
    }

    fn write(self, register: usize, value: u32) {
        // SAFETY: a register of the board.
        unsafe { ((self.0 + register) as *mut u32).write_volatile(value) }
    }

    /// On, with an interrupt for each byte that comes in where that is wanted.
    pub fn enable(self, receives: bool) {
        self.write(Self::DIVIDER, 16);
        self.write(Self::CONTROL, if receives { 0b1011 } else { 0b0001 });
    }

    /// The byte that has come in, and whether others were lost before it.
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

    /// Sends bytes one after another. If nobody takes one, the rest is given up, so that
    /// nothing waits for ever.
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

/// How often the counter has wrapped.
static WRAPS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    WRAPS.fetch_add(1, Ordering::Relaxed);
}

/// The board with its clock running and both ports listening.
pub struct Board(());

impl Board {
    /// Once: `None` afterwards.
    pub fn take() -> Option<Self> {
        let mut peripherals = cortex_m::Peripherals::take()?;
        paint();
        let clock = &mut peripherals.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(RELOAD);
        clock.clear_current();
        // SAFETY: before anything is interrupted. The count of wraps goes first.
        unsafe { peripherals.SCB.set_priority(SystemHandler::SysTick, 0) };
        clock.enable_interrupt();
        clock.enable_counter();
        TRACKER.enable(true);
        DISPLAY.enable(true);
        LOG.enable(false);
        Some(Self(()))
    }

    /// From now on bytes interrupt.
    pub fn listen(&self) {
        for line in [crate::line::TRACKER_RECEIVES, crate::line::DISPLAY_RECEIVES] {
            // SAFETY: what the interrupts use is there from the start.
            unsafe { NVIC::unmask(line) };
        }
    }
}

/// Ticks since the start.
pub fn ticks() -> u64 {
    loop {
        let wraps = WRAPS.load(Ordering::Relaxed);
        let count = SYST::get_current();
        let pending = SCB::is_pendst_pending();
        if wraps == WRAPS.load(Ordering::Relaxed) {
            // Within another interrupt a wrap may not have been counted yet.
            let wraps = wraps + u32::from(pending && count > RELOAD / 2);
            return (u64::from(wraps) << 24) + u64::from(RELOAD - (count & RELOAD));
        }
    }
}

/// The time of [`ticks`].
pub fn micros(ticks: u64) -> Micros {
    Micros(ticks / TICKS_PER_MICROSECOND)
}

/// Instructions between two times.
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

/// Bytes of flash and of static memory.
pub fn sizes() -> (u32, u32) {
    // Addresses that the linker gives; nothing is read.
    let at = |symbol: *const u32| symbol as u32;
    let (data, end) = (at(&raw const __sdata), at(&raw const __edata));
    let flash = at(&raw const __sidata) + (end - data) - at(&raw const __vector_table);
    (flash, at(&raw const __ebss) - data)
}

/// The part of the stack that is painted.
fn stack() -> (*mut u32, *mut u32) {
    let top = &raw const _stack_start as *mut u32;
    (top.wrapping_byte_sub(PAINTED), top)
}

fn paint() {
    let (mut at, _) = stack();
    // Well below the frames of those who call.
    let end = cortex_m::register::msp::read() as usize - 256;
    while (at as usize) < end {
        // SAFETY: memory under the stack pointer, that nobody uses.
        unsafe { at.write_volatile(PAINT) };
        at = at.wrapping_add(1);
    }
}

/// Bytes of the stack that have been used.
pub fn stack_used() -> u32 {
    let (mut at, top) = stack();
    // SAFETY: memory of the stack.
    while at < top && unsafe { at.read_volatile() } == PAINT {
        at = at.wrapping_add(1);
    }
    top as u32 - at as u32
}
