//! Shisen as a C library: `libshisen.a` and `include/shisen.h`.
//!
//! A display controller's firmware, or any program in C, opens a baked scene
//! in place, feeds a tracker's bytes, asks where the viewer looks, and renders
//! frames of several screens tile by tile within a budget. The header documents
//! each function; this crate only makes the core and the tracker driver callable
//! from C.
//!
//! - No global state, no callbacks, no allocation. All state is in the caller's
//!   memory; macros and functions give its sizes.
//! - Every function can be called at any time, from any thread. One thread at a
//!   time may use a handle, any number a scene.
//! - Pointers are checked for NULL and alignment, lengths for overflow. A function
//!   that fails returns a [`status::Status`] that says why.
//! - For targets without an operating system, a path to a panic is a linker error:
//!   no library defines the symbol `a_path_leads_to_a_panic`. The optimiser removes
//!   all such paths at `opt-level` 2 and 3 with fat LTO in one codegen unit, as in
//!   the workspace's profile `firmware`; at "s", and with the thin LTO of the release
//!   profile, some are left.
//!
//! # Building it
//!
//! ```text
//! cargo build --profile firmware --package shisen-capi --target thumbv7em-none-eabihf
//! ```
//!
//! with `RUSTFLAGS=-Ctarget-cpu=cortex-m7` for that processor. The default feature
//! is our own link; `--no-default-features --features NAME` chooses another
//! protocol. Firmware links only the decoders of the chosen protocols, and code for
//! dispersion only with the feature `dispersion`.
//!
//! # The header
//!
//! cbindgen makes `include/shisen.h` from this crate's public items. A test compares
//! the file with cbindgen's output, and rewrites it with
//!
//! ```text
//! SHISEN_REWRITE=1 cargo test --package shisen-capi --test header
//! ```
#![no_std]
// Pointers come from C: each use of one stands next to the reason why it may be
// used, and the checks are in `memory`.
#![allow(unsafe_code)]
// The docs are read in the header, where C names need no backticks.
#![allow(clippy::doc_markdown)]
// C holds the handles and never sees what is in them.
#![allow(missing_debug_implementations)]

#[cfg(not(target_os = "none"))]
extern crate std;

pub mod dome;
pub mod frame;
#[cfg(test)]
mod hostile;
pub mod memory;
pub mod protocol;
pub mod scene;
pub mod screen;
pub mod spectrum;
pub mod status;
pub mod tracker;

#[cfg(target_os = "none")]
mod panic {
    unsafe extern "C" {
        /// Nowhere: a firmware that may panic is not linked.
        safe fn a_path_leads_to_a_panic() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        a_path_leads_to_a_panic()
    }
}
