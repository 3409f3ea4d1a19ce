//! Servers of `OptiTrack`'s `NatNet`.

use super::exchange::{Exchange, Exchanges};
use super::{Peer, Server, socket};
use crate::files::Fault;
use crate::tracker::notice::Notice;
use crate::tracker::raw::{Piece, Tap};
use shisen_tracker::decoder::{Counts, Decoder as _, Event};
use shisen_tracker::head::axes::Axes;
use shisen_tracker::net::natnet::{
    BODIES_REQUEST, CONNECT, Config, KEEP_ALIVE, NatNet, echo_request, read_bodies, read_echo,
};
use shisen_tracker::time::Micros;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// From one request to the next, until it is answered.
const AGAIN: Duration = Duration::from_millis(200);

/// From one word that this program still listens to the next.
const ALIVE: Micros = Micros::from_millis(1_000);

/// A server that was asked for its frames.
pub(super) struct Client {
    server: SocketAddr,
    commands: UdpSocket,
    /// Where frames come, if that is another one.
    frames: Option<UdpSocket>,
    decoder: NatNet,
    tap: Tap,
    /// The sensor that is handed over; `None`: all.
    only: Option<u8>,
    alive_at: Micros,
    exchanges: Exchanges,
    buffer: Vec<u8>,
}

impl Client {
    /// Asks a server for its version, and for a rigid body by its name.
    pub(super) fn open(
        server: &Server,
        body: Option<&str>,
        axes: Axes,
        patience: Duration,
        tap: &Tap,
    ) -> Result<Self, Fault> {
        let addresses = socket::addresses(server)?;
        let own = (Ipv4Addr::UNSPECIFIED, 0);
        // The protocol has IPv4 addresses alone.
        let address = addresses.into_iter().find(SocketAddr::is_ipv4);
        let mut client = Self {
            server: address.ok_or_else(|| {
                let message = format!("{server} has no IPv4 address");
                Fault::new(message, "give the server's IPv4 address")
            })?,
            commands: socket::bind(own.into())?,
            frames: None,
            tap: tap.clone(),
            decoder: NatNet::new(Config {
                version: None,
                axes,
            }),
            only: None,
            alive_at: Micros(0),
            exchanges: Exchanges::default(),
            buffer: vec![0; socket::LONGEST],
        };
        client.ask(&CONNECT, patience, |decoder, bytes| {
            decoder.feed(bytes, Micros(0), &mut |_| {});
            decoder.version().is_some()
        });
        let version = client.decoder.version().ok_or_else(|| {
            Fault::new(
                format!("no NatNet server of version 3 or 4 answers at UDP {server}"),
                "start streaming in Motive, check host and port, and see that no firewall is in the \
                 way",
            )
        })?;
        if let Some(body) = body {
            client.only = Some(client.number_of(body, version, patience)?);
        }
        let said = version.into_iter().chain(client.only).collect::<Vec<u8>>();
        tap.take(Piece::Opened, &said, Micros(0));
        if let Some((group, port)) = client.decoder.multicast() {
            let frames = socket::bind((Ipv4Addr::UNSPECIFIED, port).into())?;
            let joined = frames.join_multicast_v4(&group.into(), &Ipv4Addr::UNSPECIFIED);
            joined.map_err(|error| {
                let group = Ipv4Addr::from(group);
                let message = format!("cannot join the multicast group {group}: {error}");
                Fault::new(message, "set Motive to stream by unicast")
            })?;
            // Only the one of frames is waited for.
            let waits = client.commands.set_nonblocking(true);
            waits.map_err(|error| Fault::new(error.to_string(), "start it again"))?;
            client.frames = Some(frames);
        }
        Ok(client)
    }

    /// Sends a request until `take` has its answer, or for as long as `patience`.
    fn ask(
        &mut self,
        request: &[u8],
        patience: Duration,
        mut take: impl FnMut(&mut NatNet, &[u8]) -> bool,
    ) {
        let begun = Instant::now();
        let mut next = Duration::ZERO;
        let mut is_answered = false;
        while !is_answered && begun.elapsed() < patience {
            if begun.elapsed() >= next {
                next += AGAIN;
                // One that is lost is sent again.
                let _ = self.commands.send_to(request, self.server);
            }
            let decoder = &mut self.decoder;
            let read = socket::datagrams(&self.commands, &mut self.buffer, |bytes, _| {
                is_answered |= take(decoder, bytes);
            });
            is_answered |= read.is_err();
        }
    }

    /// Returns the number of a rigid body.
    fn number_of(&mut self, body: &str, version: [u8; 2], patience: Duration) -> Result<u8, Fault> {
        let mut found: Vec<(String, u32)> = Vec::new();
        self.ask(&BODIES_REQUEST, patience, |_, bytes| {
            found.clear();
            let take = &mut |name: &str, id| found.push((name.to_owned(), id));
            read_bodies(bytes, version, take).is_ok()
        });
        let number = found.iter().find(|(name, _)| name == body);
        if let Some(number) = number.and_then(|(_, id)| u8::try_from(*id).ok()) {
            return Ok(number);
        }
        let all = found.iter().map(|(name, id)| format!("{name} ({id})"));
        let all = all.collect::<Vec<_>>().join(", ");
        let message = format!("the NatNet server has no rigid body {body:?} with a number to 255");
        Err(Fault::new(
            message,
            if all.is_empty() {
                "it names none: give body=NUMBER, its streaming id".to_owned()
            } else {
                format!("give body= one of {all}, by name or number")
            },
        ))
    }
}

impl Peer for Client {
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String> {
        let (decoder, exchanges) = (&mut self.decoder, &mut self.exchanges);
        let (server, only, tap) = (self.server.ip(), self.only, &self.tap);
        let mut take = |bytes: &[u8], from: SocketAddr| {
            if from.ip() != server {
                return;
            }
            let now = now();
            if let Some((sent, ticks)) = read_echo(bytes) {
                let rate = decoder.ticks_per_second();
                if rate > 0 && sent <= now {
                    let theirs = (ticks as f64 / rate as f64 * 1.0e6) as i64;
                    exchanges.take(Exchange {
                        at: now,
                        offset: theirs - sent.0.midpoint(now.0) as i64,
                        round_trip: now.since(sent),
                    });
                }
                return;
            }
            tap.take(Piece::Came, bytes, now);
            decoder.feed(bytes, now, &mut |event| {
                let is_other = matches!(&event, Event::Sample(sample)
                    if only.is_some_and(|only| sample.sensor != only));
                if !is_other {
                    sink(Notice::Decoded(event));
                }
            });
        };
        let sockets = [Some(&self.commands), self.frames.as_ref()];
        for socket in sockets.into_iter().flatten() {
            let read = socket::datagrams(socket, &mut self.buffer, &mut take);
            read.map_err(|error| error.to_string())?;
        }
        let now = now();
        let send = |request: &[u8]| {
            let sent = self.commands.send_to(request, self.server);
            sent.map(|_| ()).map_err(|error| error.to_string())
        };
        if now >= self.alive_at {
            self.alive_at = now.after(ALIVE);
            send(if self.frames.is_none() {
                &KEEP_ALIVE
            } else {
                &CONNECT
            })?;
        }
        let (asks, found) = self.exchanges.poll(now);
        if asks {
            send(&echo_request(now))?;
        }
        found.into_iter().for_each(sink);
        Ok(())
    }

    fn counts(&self) -> Counts {
        *self.decoder.counts()
    }

    fn remedy(&self) -> String {
        "see that Motive streams rigid bodies, to this machine, and that body= is one of them"
            .to_owned()
    }
}
