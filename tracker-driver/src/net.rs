//! Trackers on the network: byte streams over TCP, datagrams over UDP. Sockets are the caller's.
//!
//! | Protocol | Module | Transport | Device time | Tested with |
//! |---|---|---|---|---|
//! | VRPN 07: poses, buttons, analogs | [`vrpn`] | TCP, and UDP for poses | the server's UTC | what its server 07.38 sent |
//! | ART `DTrack`: bodies, Flysticks | [`dtrack`] | UDP | UTC: of the day, or since 1970 | frames that were made, and what VRPN's driver made of them |
//! | `OptiTrack` `NatNet` 3 and 4: rigid bodies | [`natnet`] | UDP | the cameras' clock | frames that were made, on which public parsers agree |
//! | opentrack: one head | [`opentrack`] | UDP | – | vectors |
//! | `FreeD` D1: cameras | [`freed`] | UDP | – | vectors |
//! | Lab Streaming Layer: any channels | [`lsl`] | UDP to find, TCP to read | the sender's steady clock | what liblsl 1.18 sent, and liblsl |
//!
//! A decoder of datagrams takes one whole datagram a call, and hands over all of its events or,
//! where any part of it is damaged, none.
//! A decoder of a TCP stream cannot find the next record behind a wrong length: it drops
//! everything from there on until it is [`reset`](crate::decoder::Decoder::reset) for a new
//! connection, and says so by `is_lost`.

pub mod dtrack;
pub mod freed;
pub mod lsl;
pub mod natnet;
pub mod opentrack;
pub mod vrpn;

#[cfg(test)]
mod capture;

use crate::decoder::{Counts, DropReason, Event};
use glam::Quat;

/// How far the norm of a quaternion from the network may be from 1.
const NORM_TOLERANCE: f32 = 0.1;

/// Returns the quaternion that a peer sent, normalised.
fn rotation(value: Quat) -> Result<Quat, DropReason> {
    crate::valid::rotation(value, NORM_TOLERANCE)
}

/// Hands over the events that `read` finds in a record of this many bytes, or, where it fails,
/// none of them but the reason. It runs twice: to check the record, then to read it.
fn hand_over<T>(
    counts: &mut Counts,
    bytes: usize,
    sink: &mut dyn FnMut(Event),
    read: impl Fn(&mut dyn FnMut(Event)) -> Result<T, DropReason>,
) -> Option<T> {
    let mut noted = |event: Event| {
        counts.note(&event);
        sink(event);
    };
    let checked = read(&mut |_| {}).and_then(|_| read(&mut noted));
    match checked {
        Ok(found) => Some(found),
        Err(reason) => {
            noted(Event::dropped(bytes as u32, reason));
            None
        }
    }
}

/// Adds a datagram's bytes to the counts.
fn count_bytes(counts: &mut Counts, bytes: &[u8]) {
    counts.bytes = counts.bytes.saturating_add(bytes.len() as u64);
}

/// A peer's count of its datagrams.
#[derive(Debug, Clone, Default)]
struct Numbers(Option<u32>);

/// More datagrams than this cannot be missing: the peer began to count anew.
const LARGEST_GAP: u32 = 1_000;

impl Numbers {
    /// Returns whether `number` is another than the last; adds those in between to the lost ones.
    fn is_new(&mut self, number: u32, counts: &mut Counts) -> bool {
        let step = self.0.map_or(1, |last| number.wrapping_sub(last));
        self.0 = Some(number);
        let lost = step.saturating_sub(1);
        if lost <= LARGEST_GAP {
            counts.lost = counts.lost.saturating_add(u64::from(lost));
        }
        step != 0
    }
}
