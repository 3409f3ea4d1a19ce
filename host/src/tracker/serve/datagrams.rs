//! Datagrams that are sent without being asked for.

use super::outlet::{Outlet, Time};
use crate::files::Fault;
use shisen_tracker::decoder::Event;
use shisen_tracker::net::dtrack::{self, BODIES, Body};
use shisen_tracker::net::opentrack;
use shisen_tracker::time::Micros;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};

/// A socket and who is sent to.
pub(super) struct Sender {
    socket: UdpSocket,
    to: SocketAddr,
}

impl Sender {
    pub(super) fn open(to: SocketAddr) -> Result<Self, Fault> {
        let own: SocketAddr = match to {
            SocketAddr::V4(_) => ([0; 4], 0).into(),
            SocketAddr::V6(_) => ([0; 16], 0).into(),
        };
        let opened = UdpSocket::bind(own).and_then(|socket| {
            socket.set_broadcast(true)?;
            Ok(socket)
        });
        let socket = opened.map_err(|error| {
            Fault::new(
                format!("cannot send to UDP {to}: {error}"),
                "give another address",
            )
        })?;
        Ok(Self { socket, to })
    }

    fn send(&self, bytes: &[u8]) -> io::Result<()> {
        match self.socket.send_to(bytes, self.to) {
            // Nobody listens there now.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => Ok(()),
            sent => sent.map(|_| ()),
        }
    }
}

/// How long a body is in frames after it was seen.
const KEPT: Micros = Micros::from_millis(50);

/// Frames of ART `DTrack`: one for each sample, with all bodies seen of late.
pub(super) struct Frames {
    sender: Sender,
    number: u32,
    bodies: BTreeMap<u8, (Micros, Body)>,
    text: String,
}

impl Frames {
    pub(super) const fn new(sender: Sender) -> Self {
        Self {
            sender,
            number: 0,
            bodies: BTreeMap::new(),
            text: String::new(),
        }
    }
}

impl Outlet for Frames {
    fn send(&mut self, event: &Event, at: Time) -> io::Result<()> {
        let Event::Sample(sample) = event else {
            return Ok(());
        };
        if let (Some(place), Some(turn)) = (sample.head.position, sample.head.orientation)
            && sample.sensor < BODIES
            && place.tracked
            && turn.tracked
        {
            let body = (sample.sensor, place.value, turn.value);
            self.bodies.insert(sample.sensor, (at.feed, body));
        } else {
            self.bodies.remove(&sample.sensor);
        }
        self.bodies
            .retain(|_, (seen, _)| at.feed.since(*seen) <= KEPT);
        let bodies: Vec<Body> = self.bodies.values().map(|(_, body)| *body).collect();
        self.number = self.number.wrapping_add(1);
        self.text.clear();
        // A string takes everything.
        let _ = dtrack::encode(&mut self.text, self.number, at.utc, &bodies);
        self.sender.send(self.text.as_bytes())
    }

    fn attend(&mut self, _now: Micros) -> io::Result<()> {
        Ok(())
    }

    fn readers(&self) -> Option<usize> {
        None
    }

    fn description(&self) -> String {
        format!("frames of DTrack go to UDP {}", self.sender.to)
    }
}

/// opentrack's datagrams.
pub(super) struct Numbers {
    sender: Sender,
}

impl Numbers {
    pub(super) const fn new(sender: Sender) -> Self {
        Self { sender }
    }
}

impl Outlet for Numbers {
    fn send(&mut self, event: &Event, _at: Time) -> io::Result<()> {
        if let Event::Sample(sample) = event
            && let Some(datagram) = opentrack::encode(&sample.head)
        {
            return self.sender.send(&datagram);
        }
        Ok(())
    }

    fn attend(&mut self, _now: Micros) -> io::Result<()> {
        Ok(())
    }

    fn readers(&self) -> Option<usize> {
        None
    }

    fn description(&self) -> String {
        format!("opentrack's datagrams go to UDP {}", self.sender.to)
    }
}
