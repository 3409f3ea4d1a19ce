use core::f32::consts::{LN_2, TAU};
use shisen_core::numeric::{sin_cos, sqrt};

/// Random numbers that are the same everywhere: PCG-XSH-RR 64/32 (O'Neill, "PCG", 2014).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Random {
    state: u64,
    increment: u64,
}

impl Random {
    const FACTOR: u64 = 6_364_136_223_846_793_005;

    /// Returns one of 2⁶³ independent sequences from one of 2⁶⁴ seeds.
    pub fn new(seed: u64, sequence: u64) -> Self {
        let mut random = Self {
            state: 0,
            increment: sequence << 1 | 1,
        };
        random.bits();
        random.state = random.state.wrapping_add(seed);
        random.bits();
        random
    }

    /// 32 bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(Self::FACTOR).wrapping_add(self.increment);
        let shifted = ((old >> 18 ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// From 0 up to, but not including, 1.
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// Returns whether something of this probability happens.
    pub fn chance(&mut self, probability: f32) -> bool {
        self.uniform() < probability
    }

    /// From `least` to `most`.
    pub fn between(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * self.uniform()
    }

    /// Returns a normal number of mean 0 and standard deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f32 {
        let radius = sqrt(2.0 * self.exponential());
        let (_, cos) = sin_cos(TAU * self.uniform());
        radius * cos
    }

    /// Returns an exponential number of mean 1.
    pub fn exponential(&mut self) -> f32 {
        // Never the logarithm of 0.
        let rest = 1.0 - self.uniform();
        (-libm::logf(rest)).clamp(0.0, 24.0 * LN_2)
    }

    /// Returns a log-normal number: its median, and its logarithm's standard deviation.
    pub fn log_normal(&mut self, median: f32, deviation: f32) -> f32 {
        median * libm::expf(deviation * self.normal())
    }
}

/// Mixes a place in a lattice into 32 random bits (`MurmurHash3`'s finalizer, twice).
pub(super) fn hash(seed: u64, lane: u32, index: u64) -> u32 {
    let mix = |mut x: u64| {
        x = (x ^ x >> 33).wrapping_mul(0xff51_afd7_ed55_8ccd);
        x = (x ^ x >> 33).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        x ^ x >> 33
    };
    let lane = u64::from(lane).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mix(mix(seed ^ lane) ^ index) >> 32) as u32
}
