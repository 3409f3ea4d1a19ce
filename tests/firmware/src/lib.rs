//! A display controller on the emulated board mps2-an500, in parts.
#![no_std]

#[cfg(feature = "controller")]
pub mod board;
#[cfg(feature = "controller")]
pub mod display;
#[cfg(feature = "controller")]
pub mod line;
#[cfg(feature = "log")]
mod log;
#[cfg(feature = "measure")]
pub mod measure;
#[cfg(feature = "controller")]
pub mod restart;
#[cfg(feature = "controller")]
pub mod scene;
#[cfg(feature = "controller")]
pub mod viewer;

#[cfg(not(feature = "measure"))]
unsafe extern "C" {
    /// Defined nowhere: firmware with a path to a panic does not link.
    safe fn a_path_leads_to_a_panic() -> !;
}

#[cfg(not(feature = "measure"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    a_path_leads_to_a_panic()
}

/// Writes to the log, if the firmware has one.
#[macro_export]
macro_rules! say {
    ($level:ident, $($argument:tt)*) => {{
        #[cfg(feature = "log")]
        ::defmt::$level!($($argument)*);
    }};
}
