//! The device's end of a line: records out, as a device writes them, and the
//! host's commands in.

use super::device::Device;
use super::faults::{Chunk, Source};
use super::wire::{Format, Wire};
use crate::sample::Sample;
use crate::time::Micros;

/// A simulated tracker that is told by a host what to send, and how.
#[derive(Debug, Clone)]
pub struct Line<S> {
    wire: Wire<S>,
    device: Device,
}

impl<S: Source<Item = Sample>> Line<S> {
    /// A device that measures `source` and streams records of this format.
    pub fn new(source: S, format: &Format) -> Self {
        Self {
            wire: Wire::new(source, format.clone()),
            device: Device::new(format),
        }
    }

    /// What it is told, and what it makes of that.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// Takes what the host said by `now`, and hands over the answers.
    pub fn hear(&mut self, bytes: &[u8], now: Micros, answer: &mut dyn FnMut(&[u8])) {
        self.device.feed(bytes, now, answer);
        if self.device.format() != self.wire.format() {
            self.wire.set_format(self.device.format().clone());
        }
    }
}

impl<S: Source<Item = Sample>> Source for Line<S> {
    type Item = Chunk;

    /// The next record that it sends at `until` or before.
    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        while let Some(sample) = self.wire.source().poll(until) {
            let measured = self.device.measure(&sample);
            if let Some(chunk) = measured.and_then(|sample| self.wire.encode(&sample)) {
                return Some(chunk);
            }
        }
        None
    }
}
