//! Contenders that are Rust: ours, and with the feature `crates` those that are crates.

#[cfg(feature = "crates")]
mod bvh;
mod library;
#[cfg(feature = "crates")]
mod obvhs;
mod ours;

use shisen_peers_interface::Contender;

#[cfg(feature = "crates")]
const COUNT: usize = 6;
#[cfg(not(feature = "crates"))]
const COUNT: usize = 3;

/// All of this library.
struct All([Contender; COUNT]);

// SAFETY: its pointers are to text that never changes, and to functions.
unsafe impl Sync for All {}

static ALL: All = All([
    ours::NEAREST,
    ours::ANY,
    ours::PICTURE,
    #[cfg(feature = "crates")]
    obvhs::CWBVH,
    #[cfg(feature = "crates")]
    obvhs::BVH2,
    #[cfg(feature = "crates")]
    bvh::ITERATOR,
]);

/// The list of contenders.
///
/// # Safety
/// `count` is to a number that may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_contenders(count: *mut usize) -> *const Contender {
    // SAFETY: as the caller promises.
    unsafe { count.write(COUNT) };
    ALL.0.as_ptr()
}
