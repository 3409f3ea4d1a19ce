//! Shisen as a C library: `libshisen.a` and `include/shisen.h`.
//!
//! A display controller's firmware, or any program in C, opens a baked scene
//! where it lies, feeds a tracker's bytes, asks where the viewer looks, and
//! renders frames of several screens tile by tile within a budget. The header
//! says how; this crate adds nothing to the core and the tracker driver but
//! their border.
//!
//! - No global state, no callbacks, no allocation. All state is in the caller's
//!   memory, whose sizes are macros and functions.
//! - Every function can be called at any time, from any thread; a handle by one
//!   thread at a time, a scene by many.
//! - Pointers are checked for being there and aligned, lengths for making sense.
//!   What fails says why by a [`status::Status`].
//! - For targets without an operating system, a path that leads to a panic is an
//!   error of the linker: the symbol `a_path_leads_to_a_panic` is nowhere. Which
//!   paths are ruled out is the optimiser's work: none is left at `opt-level` 2
//!   and 3 with fat LTO in one codegen unit, as the profile `firmware` of the workspace
//!   has; some are at "s", and with the release profile's thin LTO.
//!
//! # Building it
//!
//! ```text
//! cargo build --profile firmware --package shisen-capi --target thumbv7em-none-eabihf
//! ```
//!
//! with `RUSTFLAGS=-Ctarget-cpu=cortex-m7` for that processor, and
//! `--no-default-features --features NAME` for another tracker than one that
//! speaks our link. A firmware links the decoders of the protocols that were
//! chosen, and dispersion where the feature `dispersion` is on.
//!
//! # The header
//!
//! `include/shisen.h` is made of this crate's public items by cbindgen. A test
//! compares it with what cbindgen makes now, and rewrites it with
//!
//! ```text
//! SHISEN_REWRITE=1 cargo test --package shisen-capi --test header
//! ```
#![no_std]
// Pointers come from C: each use of one stands next to the reason why it may be
// used, and the checks are in `memory`.
#![allow(unsafe_code)]
// The docs are read in the header, where names of C need no marks.
#![allow(clippy::doc_markdown)]
// Handles are C's, which sees nothing of what is in them.
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
