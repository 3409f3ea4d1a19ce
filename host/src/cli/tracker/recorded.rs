//! What a recording's samples are sent from.

use shisen_tracker::mock::Source;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::iter::Peekable;
use std::vec::IntoIter;

/// Recorded samples, at their times.
pub struct Recorded(Peekable<IntoIter<Sample>>);

impl Recorded {
    /// Those of a recording, in the order in which they arrived.
    pub fn new(samples: Vec<Sample>) -> Self {
        Self(samples.into_iter().peekable())
    }
}

impl Source for Recorded {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        self.0.next_if(|sample| sample.arrival <= until)
    }
}
