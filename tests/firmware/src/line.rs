//! Queues that take received bytes from interrupts to the main loop.

use crate::board::{self, DISPLAY, TRACKER, Uart};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::interrupt::InterruptNumber;
use heapless::spsc::Queue;

/// Size of a queue, of which one place stays free.
const ROOM: usize = 256;

/// An interrupt of the board.
#[derive(Clone, Copy)]
pub struct Interrupt(u16);

/// A byte from the tracker.
pub const TRACKER_RECEIVES: Interrupt = Interrupt(0);
/// A byte from the display's port.
pub const DISPLAY_RECEIVES: Interrupt = Interrupt(2);

// SAFETY: these are the numbers of the board's interrupts, as in its vector table below.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self.0
    }
}

/// A port and its received bytes that wait.
struct Receiver {
    port: Uart,
    /// Not split into producer and consumer, which divide by the queue's length at run time.
    queue: UnsafeCell<Queue<u8, ROOM>>,
    /// Number of bytes lost for lack of room.
    lost: AtomicU32,
    /// Low half of the newest byte's arrival, ticks.
    newest: AtomicU32,
}

// SAFETY: the queue is used with interrupts off, on the only core.
unsafe impl Sync for Receiver {}

impl Receiver {
    const fn new(port: Uart) -> Self {
        Self {
            port,
            queue: UnsafeCell::new(Queue::new()),
            lost: AtomicU32::new(0),
            newest: AtomicU32::new(0),
        }
    }

    fn with_queue<T>(&self, act: impl FnOnce(&mut Queue<u8, ROOM>) -> T) -> T {
        cortex_m::interrupt::free(|_| {
            // SAFETY: interrupts are off, and `act` is not given the receiver.
            act(unsafe { &mut *self.queue.get() })
        })
    }

    fn interrupt(&self) {
        while let Some((byte, overrun)) = self.port.receive() {
            self.newest.store(board::ticks() as u32, Ordering::Relaxed);
            let taken = self.with_queue(|queue| queue.enqueue(byte).is_ok());
            let lost = u32::from(overrun) + u32::from(!taken);
            self.lost.fetch_add(lost, Ordering::Relaxed);
        }
    }
}

static FROM_TRACKER: Receiver = Receiver::new(TRACKER);
static FROM_DISPLAY: Receiver = Receiver::new(DISPLAY);

extern "C" fn tracker_receives() {
    FROM_TRACKER.interrupt();
}

extern "C" fn display_receives() {
    FROM_DISPLAY.interrupt();
}

unsafe extern "C" {
    fn DefaultHandler();
}

/// The handler of the board's interrupts.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
    table[TRACKER_RECEIVES.0 as usize] = tracker_receives;
    table[DISPLAY_RECEIVES.0 as usize] = display_receives;
    table
};

/// The main loop's end of a line.
pub struct Line(&'static Receiver);

impl Line {
    /// Returns the tracker's line.
    pub const TRACKER: Self = Self(&FROM_TRACKER);
    /// Returns the line of the display's port.
    pub const DISPLAY: Self = Self(&FROM_DISPLAY);

    /// Takes the next received bytes into the start of a buffer, and returns them.
    pub fn take<'b>(&self, buffer: &'b mut [u8; 64]) -> &'b [u8] {
        let mut count = 0;
        for place in buffer.iter_mut() {
            let Some(byte) = self.0.with_queue(Queue::dequeue) else {
                break;
            };
            *place = byte;
            count += 1;
        }
        buffer.get(..count).unwrap_or_default()
    }

    /// Returns the number of bytes lost because they were not taken in time.
    pub fn lost(&self) -> u32 {
        self.0.lost.load(Ordering::Relaxed)
    }

    /// Returns when the newest byte came, in ticks.
    pub fn newest(&self) -> u64 {
        // The order matters, since a byte may come in between.
        let low = self.0.newest.load(Ordering::Relaxed);
        let now = board::ticks();
        now - u64::from((now as u32).wrapping_sub(low))
    }
}
