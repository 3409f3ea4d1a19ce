//! Times: the caller's clock and the device's.

/// A time on the caller's clock, which never goes back, or a span: microseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Micros(pub u64);

impl Micros {
    /// Returns a span of this many milliseconds.
    pub const fn from_millis(milliseconds: u64) -> Self {
        Self(milliseconds.saturating_mul(1_000))
    }

    /// Returns the span from `earlier` to this time; zero where `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }

    /// This time and a span after it.
    #[must_use]
    pub const fn after(self, span: Self) -> Self {
        Self(self.0.saturating_add(span.0))
    }

    /// In seconds.
    pub fn seconds(self) -> f32 {
        self.0 as f32 * 1.0e-6
    }
}

/// A time on a device's clock, as its protocol writes it down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DeviceTime {
    /// Microseconds from wherever the device's clock starts.
    pub microseconds: u64,
    /// Microseconds after which the clock is back at zero; 0: never.
    pub wraps_at: u64,
}

impl DeviceTime {
    /// Returns a clock of 64 bits, which does not wrap.
    pub const fn unwrapped(microseconds: u64) -> Self {
        Self {
            microseconds,
            wraps_at: 0,
        }
    }

    /// Returns a clock that counts microseconds in 32 bits: it wraps after 72 minutes.
    pub const fn micros_u32(microseconds: u32) -> Self {
        Self {
            microseconds: microseconds as u64,
            wraps_at: 1 << 32,
        }
    }

    /// Returns a clock that counts milliseconds in 32 bits: it wraps after 50 days.
    pub const fn millis_u32(milliseconds: u32) -> Self {
        Self {
            microseconds: milliseconds as u64 * 1_000,
            wraps_at: (1 << 32) * 1_000,
        }
    }
}
