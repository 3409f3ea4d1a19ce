//! The offset of a peer's clock, from exchanges of times.

use crate::tracker::notice::Notice;
use shisen_tracker::time::Micros;

/// Exchanges of one round, the one of the least round trip among which counts.
const ROUND: u32 = 8;

/// From one request to the next, and from one round's end to the next round.
const STEP: Micros = Micros::from_millis(64);
const PAUSE: Micros = Micros::from_millis(2_000);

/// Rounds of exchanges with a peer.
#[derive(Debug, Default)]
pub(super) struct Exchanges {
    next: Micros,
    asked: u32,
    best: Option<Exchange>,
}

/// One request and its answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exchange {
    /// When the answer came.
    pub(super) at: Micros,
    /// The peer's clock less ours, microseconds.
    pub(super) offset: i64,
    /// The time that both were under way.
    pub(super) round_trip: Micros,
}

impl Exchanges {
    /// Returns whether a request is to be sent now, and what the round before has found.
    pub(super) fn poll(&mut self, now: Micros) -> (bool, Option<Notice>) {
        if now < self.next {
            return (false, None);
        }
        if self.asked < ROUND {
            self.asked += 1;
            self.next = now.after(STEP);
            return (true, None);
        }
        self.asked = 0;
        self.next = now.after(PAUSE);
        let found = self.best.take();
        (
            false,
            found.map(|best| Notice::Offset {
                at: best.at,
                offset: best.offset,
            }),
        )
    }

    /// Takes an answer.
    pub(super) fn take(&mut self, exchange: Exchange) {
        let is_better = |best: Exchange| exchange.round_trip < best.round_trip;
        if self.best.is_none_or(is_better) {
            self.best = Some(exchange);
        }
    }
}
