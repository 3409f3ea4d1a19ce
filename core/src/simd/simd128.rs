//! The path of WebAssembly with 128-bit vectors: in it all programs are built with them, and none asks.

use super::{Lanes, Portable};
use core::arch::wasm32::{
    f32x4, f32x4_abs, f32x4_add, f32x4_div, f32x4_eq, f32x4_extract_lane, f32x4_le, f32x4_mul,
    f32x4_pmax, f32x4_pmin, f32x4_splat, f32x4_sqrt, f32x4_sub, i32x4_bitmask, v128, v128_and,
    v128_bitselect, v128_or,
};
use core::array;

/// Vectors of four numbers.
#[derive(Clone, Copy)]
pub(crate) struct Simd128;

macro_rules! vector_by_vector {
    ($name:ident: $operation:expr) => {
        #[inline(always)]
        fn $name(self, a: Self::F, b: Self::F) -> Self::F {
            array::from_fn(|part| $operation(a[part], b[part]))
        }
    };
}

macro_rules! lanes {
    ($width:literal in $parts:literal) => {
        impl Lanes<$width> for Simd128 {
            type F = [v128; $parts];
            type M = [v128; $parts];

            #[inline(always)]
            fn splat(self, x: f32) -> Self::F {
                [f32x4_splat(x); $parts]
            }
            #[inline(always)]
            fn load(self, x: &[f32; $width]) -> Self::F {
                array::from_fn(|part| {
                    let at = 4 * part;
                    f32x4(x[at], x[at + 1], x[at + 2], x[at + 3])
                })
            }
            #[inline(always)]
            fn store(self, x: Self::F) -> [f32; $width] {
                let mut out = [0.0; $width];
                for (out, x) in out.as_chunks_mut::<4>().0.iter_mut().zip(x) {
                    *out = [
                        f32x4_extract_lane::<0>(x),
                        f32x4_extract_lane::<1>(x),
                        f32x4_extract_lane::<2>(x),
                        f32x4_extract_lane::<3>(x),
                    ];
                }
                out
            }
            vector_by_vector!(add: f32x4_add);
            vector_by_vector!(sub: f32x4_sub);
            vector_by_vector!(mul: f32x4_mul);
            vector_by_vector!(div: f32x4_div);
            // The second operand is what NaN leaves.
            vector_by_vector!(min: |a, b| f32x4_pmin(b, a));
            vector_by_vector!(max: |a, b| f32x4_pmax(b, a));
            vector_by_vector!(lesser: f32x4_pmin);
            vector_by_vector!(greater: f32x4_pmax);
            vector_by_vector!(le: f32x4_le);
            vector_by_vector!(eq: f32x4_eq);
            vector_by_vector!(and: v128_and);
            vector_by_vector!(or: v128_or);
            #[inline(always)]
            fn sqrt(self, x: Self::F) -> Self::F {
                x.map(|x| f32x4_sqrt(x))
            }
            #[inline(always)]
            fn abs(self, x: Self::F) -> Self::F {
                x.map(|x| f32x4_abs(x))
            }
            #[inline(always)]
            fn select(self, m: Self::M, a: Self::F, b: Self::F) -> Self::F {
                array::from_fn(|part| v128_bitselect(a[part], b[part], m[part]))
            }
            #[inline(always)]
            fn bits(self, m: Self::M) -> u32 {
                let parts = m.iter().enumerate();
                parts.fold(0, |bits, (part, m)| {
                    bits | u32::from(i32x4_bitmask(*m)) << (4 * part)
                })
            }
            #[inline(always)]
            fn prefetch<T>(self, _: &T) {}
            #[inline(always)]
            fn interleave(self, of_lanes: [Self::F; 4]) -> [[f32; 4]; $width] {
                Portable.interleave(of_lanes.map(|x| Lanes::<$width>::store(self, x)))
            }
            #[inline(always)]
            fn compress(
                self,
                hit: Self::M,
                order: u32,
                near: Self::F,
                child: &[u32; $width],
                distances: &mut [f32; $width],
                children: &mut [u32; $width],
            ) -> (usize, usize) {
                let hit = Lanes::<$width>::bits(self, hit);
                let near = Lanes::<$width>::store(self, near);
                Portable.compress(hit, order, near, child, distances, children)
            }
        }
    };
}

lanes!(4 in 1);
lanes!(8 in 2);
