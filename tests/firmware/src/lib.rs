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
    /// Nowhere: a firmware that may panic is not linked.
    safe fn a_path_leads_to_a_panic() -> !;
}

#[cfg(not(feature = "measure"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    a_path_leads_to_a_panic()
}

/// Says something by the log, where there is one.
#[macro_export]
macro_rules! say {
    ($level:ident, $($argument:tt)*) => {{
        #[cfg(feature = "log")]
        ::defmt::$level!($($argument)*);
    }};
}
