//! A reading that says the same to the last bit for too long: its tracker no
//! longer measures it.

use crate::time::Micros;

/// A hash of numbers' bits; lists that differ in one number never share it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fingerprint(u64);

impl Fingerprint {
    /// Returns the fingerprint of these numbers, bit for bit.
    pub(super) fn of(numbers: &[f32]) -> Self {
        Self(0xCBF2_9CE4_8422_2325).and(numbers)
    }

    /// Returns the fingerprint of all numbers so far, and then these.
    // Not inlined: a loop in each of its callers would cost flash.
    #[inline(never)]
    pub(super) fn and(self, numbers: &[f32]) -> Self {
        // FNV-1a's step, by words; the length parts a list from the next.
        let step = |sum: u64, word: u32| (sum ^ u64::from(word)).wrapping_mul(0x0100_0000_01B3);
        let words = numbers.iter().map(|number| number.to_bits());
        Self(step(words.fold(self.0, step), numbers.len() as u32))
    }
}

/// Since when a reading is what it is.
#[derive(Debug, Clone, Copy)]
struct Since {
    reading: Fingerprint,
    time: Micros,
    /// It was another one before.
    has_changed: bool,
    /// For too long.
    stuck: bool,
}

/// Follows one reading from sample to sample.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unchanged(Option<Since>);

impl Unchanged {
    /// For how long the reading at `time` has been what it is.
    #[inline(never)]
    pub(super) fn push(&mut self, reading: Fingerprint, time: Micros) -> Micros {
        match &self.0 {
            Some(since) if since.reading == reading => time.since(since.time),
            before => {
                self.0 = Some(Since {
                    reading,
                    time,
                    has_changed: before.is_some(),
                    stuck: false,
                });
                Micros(0)
            }
        }
    }

    /// Returns whether it has ever been another one.
    pub(super) fn has_changed(&self) -> bool {
        self.0.is_some_and(|since| since.has_changed)
    }

    /// Makes it count as measured when it last changed, until it changes again.
    pub(super) fn set_stuck(&mut self) {
        if let Some(since) = &mut self.0 {
            since.stuck = true;
        }
    }

    /// Takes a pause in which nothing was read: the next reading is new unless it is the one at
    /// which this was stuck.
    pub(super) fn interrupt(&mut self) {
        self.0 = self.0.filter(|since| since.stuck);
    }

    /// Returns when the reading was measured whose newest sample is of `newest`.
    pub(super) fn measured(&self, newest: Option<Micros>) -> Option<Micros> {
        let stuck = self.0.filter(|since| since.stuck);
        stuck.map_or(newest, |since| newest.min(Some(since.time)))
    }
}
