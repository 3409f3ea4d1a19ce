//! The few vector operations that traversal is made of, on each instruction
//! set.
//!
//! [`Lanes`] has one implementation a path, and the traversal kernels are
//! written once over it. A lane computes exactly what the scalar formula
//! computes: no fused multiply-add, no approximate reciprocal, `min` and `max`
//! with x86's rule for NaN. Which path runs is therefore a matter of speed
//! only, and a test compares them bit for bit.
//!
//! `avx2` has nearly all of the core's `unsafe`: calls of intrinsics, sound because an
//! [`Avx2`] value exists only after the processor has been asked.

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod avx2;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;

use crate::numeric::scalar;
use crate::shape::Ray;
use glam::Vec3;

/// Vectors of `W` f32 and what can be done with them. A value of the
/// implementing type is the proof that its instructions may be used.
pub trait Lanes<const W: usize>: Copy {
    /// `W` numbers.
    type F: Copy;
    /// `W` truth values.
    type M: Copy;

    fn splat(self, x: f32) -> Self::F;
    fn load(self, x: &[f32; W]) -> Self::F;
    fn store(self, x: Self::F) -> [f32; W];
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a < b ? a : b`
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a > b ? a : b`
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns the lesser of numbers that are not NaN, either of −0 and 0.
    fn lesser(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns the greater of numbers that are not NaN, either of −0 and 0.
    fn greater(self, a: Self::F, b: Self::F) -> Self::F;
    /// Correctly rounded; NaN below zero.
    fn sqrt(self, x: Self::F) -> Self::F;
    /// Without its sign.
    fn abs(self, x: Self::F) -> Self::F;
    /// `m ? a : b`
    fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// `a <= b`, false for NaN.
    fn le(self, a: Self::F, b: Self::F) -> Self::M;
    /// `a == b`, false for NaN.
    fn eq(self, a: Self::F, b: Self::F) -> Self::M;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Lane 0 in the lowest bit.
    fn bits(self, m: Self::M) -> u32;
    /// Has a record brought near that will be read soon; changes no result.
    fn prefetch<T>(self, record: &T);
    /// Returns four numbers of each lane, lane by lane.
    fn interleave(self, of_lanes: [Self::F; 4]) -> [[f32; 4]; W];
    /// Writes the lanes set in `hit` to the fronts, in the sequence of `order` (lane numbers of
    /// three bits for eight lanes, two for four, lowest first); returns their number and the last
    /// lane.
    fn compress(
        self,
        hit: Self::M,
        order: u32,
        near: Self::F,
        child: &[u32; W],
        distances: &mut [f32; W],
        children: &mut [u32; W],
    ) -> (usize, usize);
}

/// Returns the dot product with a vector that is the same in all lanes, summed from x to z.
#[inline(always)]
pub(crate) fn dot<const W: usize, L: Lanes<W>>(l: L, axis: Vec3, [x, y, z]: [L::F; 3]) -> L::F {
    let x = l.mul(l.splat(axis.x), x);
    let y = l.mul(l.splat(axis.y), y);
    let z = l.mul(l.splat(axis.z), z);
    l.add(l.add(x, y), z)
}

/// Plain Rust on any target; compilers vectorise much of it.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

/// The lanes of every processor of this target.
#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
const LANES: Portable = Portable;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
const LANES: simd128::Simd128 = simd128::Simd128;

/// Bits of `order` a lane.
const fn order_bits(width: usize) -> u32 {
    if width == 8 { 3 } else { 2 }
}

#[inline(always)]
fn zip<const W: usize>(a: [f32; W], b: [f32; W], f: impl Fn(f32, f32) -> f32) -> [f32; W] {
    let mut out = [0.0; W];
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = f(a, b);
    }
    out
}

#[inline(always)]
fn test<const W: usize>(a: [f32; W], b: [f32; W], f: impl Fn(f32, f32) -> bool) -> u32 {
    let mut out = 0;
    for (lane, (a, b)) in a.into_iter().zip(b).enumerate() {
        out |= u32::from(f(a, b)) << lane;
    }
    out
}

macro_rules! lane_by_lane {
    ($name:ident: $operation:expr) => {
        #[inline(always)]
        fn $name(self, a: [f32; W], b: [f32; W]) -> [f32; W] {
            zip(a, b, $operation)
        }
    };
}

impl<const W: usize> Lanes<W> for Portable {
    type F = [f32; W];
    type M = u32;

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; W] {
        [x; W]
    }
    #[inline(always)]
    fn load(self, x: &[f32; W]) -> [f32; W] {
        *x
    }
    #[inline(always)]
    fn store(self, x: [f32; W]) -> [f32; W] {
        x
    }
    lane_by_lane!(add: |a, b| a + b);
    lane_by_lane!(sub: |a, b| a - b);
    lane_by_lane!(mul: |a, b| a * b);
    lane_by_lane!(div: |a, b| a / b);
    lane_by_lane!(min: scalar::min);
    lane_by_lane!(max: scalar::max);
    lane_by_lane!(lesser: scalar::lesser);
    lane_by_lane!(greater: scalar::greater);
    #[inline(always)]
    fn sqrt(self, x: [f32; W]) -> [f32; W] {
        zip(x, x, |x, _| scalar::sqrt(x))
    }
    #[inline(always)]
    fn abs(self, x: [f32; W]) -> [f32; W] {
        zip(x, x, |x, _| x.abs())
    }
    #[inline(always)]
    fn select(self, m: u32, a: [f32; W], b: [f32; W]) -> [f32; W] {
        let mut out = b;
        for lane in 0..W {
            if m >> lane & 1 != 0 {
                out[lane] = a[lane];
            }
        }
        out
    }
    #[inline(always)]
    fn le(self, a: [f32; W], b: [f32; W]) -> u32 {
        test(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn eq(self, a: [f32; W], b: [f32; W]) -> u32 {
        test(a, b, |a, b| a == b)
    }
    #[inline(always)]
    fn and(self, a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: u32, b: u32) -> u32 {
        a | b
    }
    #[inline(always)]
    fn bits(self, m: u32) -> u32 {
        m
    }
    #[inline(always)]
    fn prefetch<T>(self, _: &T) {}
    #[inline(always)]
    fn interleave(self, of_lanes: [[f32; W]; 4]) -> [[f32; 4]; W] {
        let [a, b, c, d] = of_lanes;
        let mut out = [[0.0; 4]; W];
        for (lane, out) in out.iter_mut().enumerate() {
            let lane = lane % W;
            *out = [a[lane], b[lane], c[lane], d[lane]];
        }
        out
    }
    #[inline(always)]
    fn compress(
        self,
        hit: u32,
        order: u32,
        near: [f32; W],
        child: &[u32; W],
        distances: &mut [f32; W],
        children: &mut [u32; W],
    ) -> (usize, usize) {
        let (mut count, mut last) = (0, 0);
        if hit == 0 {
            return (0, 0);
        }
        for place in 0..W {
            let lane = (order >> (place as u32 * order_bits(W))) as usize & (W - 1);
            if hit >> lane & 1 != 0 {
                // `count` stays below W; the mask lets the compiler see it.
                distances[count & (W - 1)] = near[lane];
                children[count & (W - 1)] = child[lane];
                count += 1;
                last = lane;
            }
        }
        (count, last)
    }
}

#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

/// Code written once over [`Lanes`] and compiled for each path.
pub trait Kernel<const W: usize> {
    type Output;
    /// Must be `#[inline(always)]`, with all that it calls over `lanes`.
    fn run<L: Lanes<W>>(self, lanes: L) -> Self::Output;
}

/// A [`Kernel`] that follows a ray.
pub trait RayKernel<const W: usize> {
    type Output;
    /// Must be `#[inline(always)]`, like [`Kernel::run`].
    fn run<L: Lanes<W>>(self, lanes: L, ray: &Ray) -> Self::Output;
}

/// The instruction set that traversal uses. It changes speed, never results.
#[derive(Clone, Copy)]
pub struct Simd(Path);

#[derive(Clone, Copy)]
enum Path {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Simd {
    /// What any machine of the target runs: plain Rust, or WebAssembly's vectors.
    pub const PORTABLE: Self = Self(Path::Portable);

    /// Whether the target has vector registers that compilers put lanes in.
    pub(crate) const HAS_VECTORS: bool = cfg!(not(any(
        target_arch = "arm",
        target_arch = "riscv32",
        target_arch = "xtensa"
    )));

    /// Returns the fastest that this processor has. Asks it once; keep the value.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::detect() {
            return Self(Path::Avx2(avx2));
        }
        Self::PORTABLE
    }

    /// `portable` or `avx2`.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Path::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Path::Avx2(_) => "avx2",
        }
    }
}

/// The widths that scenes are baked in.
pub trait Runs<const W: usize>: Copy {
    fn run<K: Kernel<W>>(self, kernel: K) -> K::Output;
    fn run_along<K: RayKernel<W>>(self, ray: &Ray, kernel: K) -> K::Output;
}

impl Runs<8> for Simd {
    #[inline(always)]
    fn run<K: Kernel<8>>(self, kernel: K) -> K::Output {
        match self.0 {
            Path::Portable => kernel.run(LANES),
            #[cfg(target_arch = "x86_64")]
            Path::Avx2(avx2) => avx2.run(kernel),
        }
    }
    #[inline(always)]
    fn run_along<K: RayKernel<8>>(self, ray: &Ray, kernel: K) -> K::Output {
        match self.0 {
            Path::Portable => kernel.run(LANES, ray),
            #[cfg(target_arch = "x86_64")]
            Path::Avx2(avx2) => avx2.run_along(ray, kernel),
        }
    }
}

impl Runs<4> for Simd {
    #[inline(always)]
    fn run<K: Kernel<4>>(self, kernel: K) -> K::Output {
        kernel.run(LANES)
    }
    #[inline(always)]
    fn run_along<K: RayKernel<4>>(self, ray: &Ray, kernel: K) -> K::Output {
        kernel.run(LANES, ray)
    }
}

impl core::fmt::Debug for Simd {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs every operation on awkward operands and returns all bits.
    struct Everything;

    impl Kernel<8> for Everything {
        type Output = (
            [[u32; 8]; 9],
            [u32; 2],
            [[f32; 4]; 8],
            [([u32; 8], [u32; 8], usize, usize); 5],
        );
        #[inline(always)]
        fn run<L: Lanes<8>>(self, l: L) -> Self::Output {
            let a = l.load(&[1.0, -0.0, f32::NAN, f32::INFINITY, 1e-45, -3.5, 0.0, 7.25]);
            let b = l.load(&[3.0, 0.0, 1.0, f32::INFINITY, 1e-45, f32::NAN, -0.0, -7.25]);
            let bits_of = |x: f32| if x.is_nan() { 0x7fc0_0000 } else { x.to_bits() };
            let bits = |x| l.store(x).map(bits_of);
            let child = [10, 11, 12, 13, 14, 15, 16, 17];
            let near = l.load(&[0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
            let reversed = 0o0123_4567;
            let rows = [
                (1.0, 0o7654_3210),
                (4.0, reversed),
                (-1.0, reversed),
                (9.0, reversed),
                (4.0, 0o7654_3210),
            ];
            let compressed = rows.map(|(limit, order)| {
                let hit = l.le(near, l.splat(limit));
                let (mut distances, mut children) = ([0.0; 8], [0; 8]);
                let (n, last) = l.compress(hit, order, near, &child, &mut distances, &mut children);
                distances[n..].fill(0.0);
                children[n..].fill(0);
                (distances.map(f32::to_bits), children, n, last.min(7 * n))
            });
            (
                [
                    bits(l.add(a, b)),
                    bits(l.sub(a, b)),
                    bits(l.mul(a, b)),
                    bits(l.div(a, b)),
                    bits(l.min(a, b)),
                    bits(l.max(a, b)),
                    bits(l.sqrt(a)),
                    bits(l.abs(a)),
                    bits(l.select(l.le(a, b), a, b)),
                ],
                [
                    l.bits(l.or(l.le(a, b), l.eq(a, a))),
                    l.bits(l.and(l.le(a, b), l.eq(b, b))),
                ],
                l.interleave([0.0, 100.0, 200.0, 300.0].map(|first| l.add(near, l.splat(first)))),
                compressed,
            )
        }
    }

    #[test]
    fn every_path_computes_the_same_bits() {
        let portable = Simd::PORTABLE.run(Everything);
        assert_eq!(Simd::detect().run(Everything), portable);
    }
}
