//! The path of x86-64 processors that have AVX2.

use super::{Avx2, Kernel, Lanes, RayKernel};
use crate::shape::Ray;
use core::arch::x86_64::{
    __m256, __m256i, _CMP_EQ_OQ, _CMP_LE_OQ, _MM_HINT_T0, _mm_cvtsi64_si128, _mm_prefetch,
    _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps, _mm256_blendv_ps, _mm256_castpd_ps,
    _mm256_castps_pd, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_ps,
    _mm256_cvtepu8_epi32, _mm256_div_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_max_ps,
    _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_ps, _mm256_permute2f128_ps,
    _mm256_permutevar8x32_epi32, _mm256_permutevar8x32_ps, _mm256_set1_epi32, _mm256_set1_ps,
    _mm256_setr_epi32, _mm256_sqrt_ps, _mm256_srlv_epi32, _mm256_storeu_ps, _mm256_storeu_si256,
    _mm256_sub_ps, _mm256_unpackhi_pd, _mm256_unpackhi_ps, _mm256_unpacklo_pd, _mm256_unpacklo_ps,
};
use core::ptr;
use glam::Vec3;

cpufeatures::new!(avx2_detected, "avx2", "bmi1", "bmi2", "popcnt");

/// For each mask of eight lanes, the numbers of its set lanes, packed to the front.
static PACKED: [[u8; 8]; 256] = packed();

const fn packed() -> [[u8; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u8;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}

impl Avx2 {
    /// Returns the proof that this machine has AVX2 and the bit operations that came with it.
    pub(crate) fn detect() -> Option<Self> {
        avx2_detected::get().then_some(Self(()))
    }

    #[inline(always)]
    pub(crate) fn run<K: Kernel<8>>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
        fn inner<K: Kernel<8>>(lanes: Avx2, kernel: K) -> K::Output {
            kernel.run(lanes)
        }
        // SAFETY: `self` exists, so `detect` has found all four.
        unsafe { inner(self, kernel) }
    }

    #[inline(always)]
    pub(crate) fn run_along<K: RayKernel<8>>(self, ray: &Ray, kernel: K) -> K::Output {
        // The ray goes over in registers: numbers just written one by one to memory cannot
        // be read back as a vector at once.
        #[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
        fn inner<K: RayKernel<8>>(
            lanes: Avx2,
            kernel: K,
            (x, dx): (f32, f32),
            (y, dy): (f32, f32),
            (z, dz): (f32, f32),
        ) -> K::Output {
            let ray = Ray::of_usable(Vec3::new(x, y, z), Vec3::new(dx, dy, dz));
            kernel.run(lanes, &ray)
        }
        let (o, d) = (ray.origin(), ray.direction());
        // SAFETY: `self` exists, so `detect` has found all four.
        unsafe { inner(self, kernel, (o.x, d.x), (o.y, d.y), (o.z, d.z)) }
    }
}

macro_rules! by_intrinsic {
    ($name:ident: $intrinsic:expr) => {
        #[inline(always)]
        fn $name(self, a: __m256, b: __m256) -> __m256 {
            unsafe { $intrinsic(a, b) }
        }
    };
}

// SAFETY, of every block here: `self` is the proof that AVX2 is there, and loads and stores go
// through references of exactly their size.
impl Lanes<8> for Avx2 {
    type F = __m256;
    type M = __m256;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        unsafe { _mm256_set1_ps(x) }
    }
    #[inline(always)]
    fn load(self, x: &[f32; 8]) -> __m256 {
        unsafe { _mm256_loadu_ps(x.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, x: __m256) -> [f32; 8] {
        let mut out = [0.0; 8];
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), x) };
        out
    }
    by_intrinsic!(add: _mm256_add_ps);
    by_intrinsic!(sub: _mm256_sub_ps);
    by_intrinsic!(mul: _mm256_mul_ps);
    by_intrinsic!(div: _mm256_div_ps);
    by_intrinsic!(min: _mm256_min_ps);
    by_intrinsic!(max: _mm256_max_ps);
    by_intrinsic!(lesser: _mm256_min_ps);
    by_intrinsic!(greater: _mm256_max_ps);
    by_intrinsic!(le: _mm256_cmp_ps::<_CMP_LE_OQ>);
    by_intrinsic!(eq: _mm256_cmp_ps::<_CMP_EQ_OQ>);
    by_intrinsic!(and: _mm256_and_ps);
    by_intrinsic!(or: _mm256_or_ps);
    #[inline(always)]
    fn sqrt(self, x: __m256) -> __m256 {
        unsafe { _mm256_sqrt_ps(x) }
    }
    #[inline(always)]
    fn abs(self, x: __m256) -> __m256 {
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), x) }
    }
    #[inline(always)]
    fn select(self, m: __m256, a: __m256, b: __m256) -> __m256 {
        unsafe { _mm256_blendv_ps(b, a, m) }
    }
    #[inline(always)]
    fn bits(self, m: __m256) -> u32 {
        unsafe { _mm256_movemask_ps(m) as u32 }
    }
    #[inline(always)]
    fn prefetch<T>(self, record: &T) {
        const LINE: usize = 64;
        let start = ptr::from_ref(record).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(LINE) {
            // Within the record, and nothing is read.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(offset)) };
        }
    }
    #[inline(always)]
    fn interleave(self, [a, b, c, d]: [__m256; 4]) -> [[f32; 4]; 8] {
        let mut out = [[0.0; 4]; 8];
        let (pairs, _) = out.as_chunks_mut::<2>();
        unsafe {
            let ab = _mm256_castps_pd(_mm256_unpacklo_ps(a, b));
            let cd = _mm256_castps_pd(_mm256_unpacklo_ps(c, d));
            // Each of these has two lanes of eight, four apart.
            let lane0 = _mm256_castpd_ps(_mm256_unpacklo_pd(ab, cd));
            let lane1 = _mm256_castpd_ps(_mm256_unpackhi_pd(ab, cd));
            let ab = _mm256_castps_pd(_mm256_unpackhi_ps(a, b));
            let cd = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
            let lane2 = _mm256_castpd_ps(_mm256_unpacklo_pd(ab, cd));
            let lane3 = _mm256_castpd_ps(_mm256_unpackhi_pd(ab, cd));
            let rows = [
                _mm256_permute2f128_ps::<0x20>(lane0, lane1),
                _mm256_permute2f128_ps::<0x20>(lane2, lane3),
                _mm256_permute2f128_ps::<0x31>(lane0, lane1),
                _mm256_permute2f128_ps::<0x31>(lane2, lane3),
            ];
            for (pair, row) in pairs.iter_mut().zip(rows) {
                _mm256_storeu_ps(pair.as_flattened_mut().as_mut_ptr(), row);
            }
        }
        out
    }
    #[inline(always)]
    fn compress(
        self,
        hit: __m256,
        order: u32,
        near: __m256,
        child: &[u32; 8],
        distances: &mut [f32; 8],
        children: &mut [u32; 8],
    ) -> (usize, usize) {
        unsafe {
            // permutevar8x32 looks at the lowest three bits only.
            let lanes: __m256i = _mm256_srlv_epi32(
                _mm256_set1_epi32(order as i32),
                _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21),
            );
            let hit =
                _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_castps_si256(hit), lanes));
            let hit = _mm256_movemask_ps(hit) as u32;
            let packed = i64::from_le_bytes(PACKED[hit as usize & 255]);
            let packed = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(packed));
            let source = _mm256_permutevar8x32_epi32(lanes, packed);
            let child = _mm256_loadu_si256(child.as_ptr().cast());
            _mm256_storeu_si256(
                children.as_mut_ptr().cast(),
                _mm256_permutevar8x32_epi32(child, source),
            );
            _mm256_storeu_ps(
                distances.as_mut_ptr(),
                _mm256_permutevar8x32_ps(near, source),
            );
            // Three bits a place, the last one's.
            let last = order >> (3 * (31 ^ (hit | 1).leading_zeros())) & 7;
            (hit.count_ones() as usize, last as usize)
        }
    }
}
