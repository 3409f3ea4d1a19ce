//! The device's end of a line: records out, as a device writes them, and the
//! host's commands in.

use super::device::Device;
use super::eye_events::{EyeEvents, MOST_AT_ONCE};
use super::faults::{Chunk, Source};
use super::wire::Wire;
use crate::decoder::{EyeEvent, Message};
use crate::protocol::Protocol;
use crate::sample::Sample;
use crate::time::Micros;
use heapless::Deque;

/// A simulated tracker that obeys a host's commands.
#[derive(Debug, Clone)]
pub struct Line<S> {
    wire: Wire<S>,
    device: Device,
    eyes: EyeEvents,
    /// Events of the eyes that are not sent yet.
    events: Deque<EyeEvent, MOST_AT_ONCE>,
    /// A sample, and the first of the sensors that have not sent theirs of it.
    due: Option<(Sample, u8)>,
    now: Micros,
}

impl<S: Source<Item = Sample>> Line<S> {
    /// Returns a device that measures `source` and streams records of this protocol.
    pub fn new(source: S, protocol: &Protocol) -> Self {
        Self::of(source, Device::new(protocol))
    }

    /// This device, measuring `source`.
    pub fn of(source: S, device: Device) -> Self {
        Self {
            wire: Wire::new(source, device.protocol().clone()),
            device,
            eyes: EyeEvents::default(),
            events: Deque::new(),
            due: None,
            now: Micros(0),
        }
    }

    /// Returns the device that obeys the commands.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// Takes what the host said by `now`, and hands over the answers.
    pub fn hear(&mut self, bytes: &[u8], now: Micros, answer: &mut dyn FnMut(&[u8])) {
        self.device.feed(bytes, now, answer);
        if self.device.protocol() != self.wire.protocol() {
            self.wire.set_protocol(self.device.protocol().clone());
        }
    }

    /// Returns the next record of what was measured last.
    fn due(&mut self) -> Option<Chunk> {
        while let Some(event) = self.events.pop_front() {
            let message = Message::Eyes(event);
            if let Some(chunk) = self.wire.encode_message(&message, self.now) {
                return Some(chunk);
            }
        }
        while let Some((sample, n)) = self.due.take() {
            let Some(measured) = self.device.nth_sensor(&sample, n) else {
                break;
            };
            self.due = Some((sample, n.saturating_add(1)));
            if let Some(chunk) = self.wire.encode(&measured) {
                return Some(chunk);
            }
        }
        None
    }
}

impl<S: Source<Item = Sample>> Source for Line<S> {
    type Item = Chunk;

    /// Returns the next record that it sends at `until` or before.
    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        loop {
            if let Some(chunk) = self.due() {
                return Some(chunk);
            }
            let sample = self.wire.source().poll(until)?;
            self.now = sample.arrival;
            let (device, events) = (&self.device, &mut self.events);
            self.eyes.see(&sample, &mut |event| {
                if device.tells(event.kind, sample.arrival) {
                    // There is room for all that one sample can say.
                    let _ = events.push_back(event);
                }
            });
            let measured = self.device.measure(&sample);
            self.due = measured.map(|sample| (sample, 0));
        }
    }
}
