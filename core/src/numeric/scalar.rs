//! Operations on single numbers, from which everything else is made.

use glam::Vec3;

/// Returns the correctly rounded square root; NaN below zero.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(target_arch = "arm", target_os = "none", target_abi = "eabihf"))]
    return hard_float_arm::sqrt(x);
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return vectors_of_wasm::sqrt(x);
    #[cfg(not(any(
        all(target_arch = "arm", target_os = "none", target_abi = "eabihf"),
        all(target_arch = "wasm32", target_feature = "simd128")
    )))]
    libm::sqrtf(x)
}

/// The square root instruction of WebAssembly, which stable Rust has for vectors alone.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod vectors_of_wasm {
    use core::arch::wasm32::{f32x4_extract_lane, f32x4_splat, f32x4_sqrt};

    #[inline(always)]
    pub(super) fn sqrt(x: f32) -> f32 {
        f32x4_extract_lane::<0>(f32x4_sqrt(f32x4_splat(x)))
    }
}

/// The square root instruction of Cortex-M4F and M7: the hard-float ABI implies it, and
/// stable Rust has no way to ask for it.
#[cfg(all(target_arch = "arm", target_os = "none", target_abi = "eabihf"))]
#[allow(unsafe_code)]
mod hard_float_arm {
    core::arch::global_asm!(
        ".pushsection .text.shisen_vsqrt,\"ax\",%progbits",
        ".global shisen_vsqrt",
        ".type shisen_vsqrt,%function",
        ".thumb",
        ".thumb_func",
        "shisen_vsqrt:",
        // vsqrt.f32 s0, s0 by its code: the assembler does not know of the floating-point
        // unit.
        ".inst.w 0xeeb10ac0",
        "bx lr",
        ".popsection",
    );

    unsafe extern "C" {
        fn shisen_vsqrt(x: f32) -> f32;
    }

    #[inline(always)]
    pub(super) fn sqrt(x: f32) -> f32 {
        // SAFETY: argument and result are in s0 by the hard-float ABI, and
        // nothing else is touched.
        unsafe { shisen_vsqrt(x) }
    }
}

/// Returns the greater of two numbers; `b` where either is NaN (as x86's `maxps`).
#[inline(always)]
pub const fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the lesser of two numbers; `b` where either is NaN (as x86's `minps`).
#[inline(always)]
pub const fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the greater of two numbers that are not NaN, either of −0 and 0: only for comparisons.
#[inline(always)]
pub(crate) const fn greater(a: f32, b: f32) -> f32 {
    #[cfg(feature = "fpv5")]
    return a.max(b);
    #[cfg(not(feature = "fpv5"))]
    max(a, b)
}

/// Returns the lesser, as [`greater`].
#[inline(always)]
pub(crate) const fn lesser(a: f32, b: f32) -> f32 {
    #[cfg(feature = "fpv5")]
    return a.min(b);
    #[cfg(not(feature = "fpv5"))]
    min(a, b)
}

/// Returns the largest magnitude among three components that are not NaN, by [`greater`].
#[inline(always)]
pub(crate) fn largest_number(v: Vec3) -> f32 {
    greater(v.x.abs(), greater(v.y.abs(), v.z.abs()))
}

/// Returns the smallest magnitude among three components that are not NaN, by [`lesser`].
#[inline(always)]
pub(crate) fn smallest_number(v: Vec3) -> f32 {
    lesser(v.x.abs(), lesser(v.y.abs(), v.z.abs()))
}

/// `f` of each of three values, always inlined to stay in the vectors' instruction set.
#[inline(always)]
pub(crate) fn map3<T: Copy, U>(values: [T; 3], f: impl Fn(T) -> U) -> [U; 3] {
    [f(values[0]), f(values[1]), f(values[2])]
}
