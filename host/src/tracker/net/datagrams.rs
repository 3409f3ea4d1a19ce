//! Datagrams that come without being asked for.

use super::spec::Datagrams;
use super::{Peer, SILENCE, socket};
use crate::files::Fault;
use crate::tracker::notice::Notice;
use crate::tracker::raw::{Piece, Tap};
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::net::{dtrack, freed, opentrack};
use shisen_tracker::time::Micros;
use std::net::{IpAddr, SocketAddr, UdpSocket};

/// The silence after which a sender of many datagrams a second is not there.
const ABSENT: Micros = Micros::from_millis(500);

/// Listens to the first host that sends what can be read.
pub(super) struct Listener {
    listen: SocketAddr,
    socket: UdpSocket,
    decoder: Box<dyn Decoder + Send>,
    tap: Tap,
    /// The host that is listened to, and when it was heard last.
    sender: Option<(IpAddr, Micros)>,
    /// When the newest datagram of that host came.
    heard: Option<Micros>,
    is_stranger_told: bool,
    buffer: Vec<u8>,
}

impl Listener {
    pub(super) fn open(listen: SocketAddr, protocol: &Datagrams, tap: Tap) -> Result<Self, Fault> {
        Ok(Self {
            listen,
            socket: socket::bind(listen)?,
            decoder: protocol.decoder(),
            tap,
            sender: None,
            heard: None,
            is_stranger_told: false,
            buffer: vec![0; socket::LONGEST],
        })
    }
}

impl Datagrams {
    pub(in crate::tracker) fn decoder(&self) -> Box<dyn Decoder + Send> {
        match self {
            Self::DTrack(config) => Box::new(dtrack::DTrack::new(*config)),
            Self::Opentrack(config) => Box::new(opentrack::Opentrack::new(*config)),
            Self::FreeD => Box::new(freed::FreeD::new()),
        }
    }
}

impl Peer for Listener {
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String> {
        let Self {
            decoder,
            sender,
            tap,
            heard,
            ..
        } = self;
        let mut stranger = None;
        let read = socket::datagrams(&self.socket, &mut self.buffer, |bytes, from| {
            let (now, from) = (now(), from.ip());
            let other = sender.filter(|(host, at)| *host != from && now.since(*at) < SILENCE);
            if let Some((host, _)) = other {
                stranger = Some((from, host));
                return;
            }
            *heard = Some(now);
            tap.take(Piece::Came, bytes, now);
            decoder.feed(bytes, now, &mut |event| {
                if matches!(event, Event::Sample(_)) {
                    *sender = Some((from, now));
                }
                sink(Notice::Decoded(event));
            });
        });
        if let Some((stranger, host)) = stranger
            && !std::mem::replace(&mut self.is_stranger_told, true)
        {
            sink(Notice::Said(format!(
                "datagrams of {stranger} are not taken: the tracker at UDP {} is {host}",
                self.listen
            )));
        }
        read.map_err(|error| error.to_string())
    }

    fn counts(&self) -> Counts {
        *self.decoder.counts()
    }

    fn is_present(&self, now: Micros) -> bool {
        self.heard.is_none_or(|heard| now.since(heard) < ABSENT)
    }

    fn remedy(&self) -> String {
        let port = self.listen.port();
        let from = if self.listen.ip().is_loopback() {
            format!("it hears this machine alone; 0.0.0.0:{port} in place of {port} hears others")
        } else {
            "see that no firewall is in the way".to_owned()
        };
        format!("set the tracker to send to UDP port {port} of this machine ({from})")
    }
}
