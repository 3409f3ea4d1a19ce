//! Servers and senders on the network.

use super::{datagrams, lsl, vrpn};
use crate::files::Fault;
use crate::tracker::feed::Feed;
use crate::tracker::notice::Notice;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::decoder::Event;
use shisen_tracker::net::{dtrack, opentrack, vrpn as vrpn_wire};
use shisen_tracker::time::Micros;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::str::FromStr;
use std::time::{Duration, SystemTime};

/// What other programs are served by.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NetProtocol {
    /// A VRPN server with a device of this name.
    Vrpn(String),
    /// An outlet of LSL: a stream of this name.
    Lsl(String),
    /// Frames of ART `DTrack`.
    DTrack,
    /// opentrack's datagrams.
    Opentrack,
}

impl NetProtocol {
    /// Names that it is read from; a `?name=NAME` may follow the first two.
    pub const NAMES: [&str; 4] = ["vrpn", "lsl", "dtrack", "opentrack"];

    /// Returns whether programs ask for what it sends, which others wait for.
    pub const fn has_readers(&self) -> bool {
        matches!(self, Self::Vrpn(_) | Self::Lsl(_))
    }

    /// Opens it: a server at an address of this machine, or a sender to one of another.
    ///
    /// # Errors
    /// An address that is wrong or in use.
    pub fn open(&self, to: Option<&str>) -> Result<Box<dyn Outlet>, Fault> {
        Ok(match self {
            Self::Vrpn(name) => Box::new(vrpn::Server::open(name, address(to, vrpn_wire::PORT)?)?),
            Self::Lsl(name) => Box::new(lsl::Outlet::open(name, address(to, 0)?.ip())?),
            Self::DTrack => {
                let sender = datagrams::Sender::open(address(to, dtrack::PORT)?)?;
                Box::new(datagrams::Frames::new(sender))
            }
            Self::Opentrack => {
                let sender = datagrams::Sender::open(address(to, opentrack::PORT)?)?;
                Box::new(datagrams::Numbers::new(sender))
            }
        })
    }
}

impl FromStr for NetProtocol {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (protocol, name) = match text.split_once("?name=") {
            Some((protocol, name)) => (protocol, Some(name)),
            None => (text, None),
        };
        let is_name = |name: &&str| !name.is_empty() && name.len() < vrpn_wire::MOST_NAME_BYTES;
        if name.is_some_and(|name| !is_name(&name)) {
            return Err(());
        }
        match (protocol, name) {
            ("vrpn", name) => Ok(Self::Vrpn(name.unwrap_or("Tracker0").to_owned())),
            ("lsl", name) => Ok(Self::Lsl(name.unwrap_or("shisen").to_owned())),
            ("dtrack", None) => Ok(Self::DTrack),
            ("opentrack", None) => Ok(Self::Opentrack),
            _ => Err(()),
        }
    }
}

/// Reads `address:port`, `address` or `port`; what is not given is this machine alone, and `port`.
fn address(to: Option<&str>, port: u16) -> Result<SocketAddr, Fault> {
    let own = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let Some(text) = to else {
        return Ok(SocketAddr::new(own, port));
    };
    let whole = text.parse().ok();
    let host = || Some(SocketAddr::new(text.parse().ok()?, port));
    let alone = || Some(SocketAddr::new(own, text.parse().ok()?));
    whole.or_else(host).or_else(alone).ok_or_else(|| {
        let help = "give an address and a port, such as 0.0.0.0:3883 or 192.168.1.5:5000";
        Fault::new(format!("--to {text}: no address and port"), help)
    })
}

/// Sends a tracker's events to whoever reads them.
pub trait Outlet {
    /// Sends an event of the time `at`, and answers those that ask.
    ///
    /// # Errors
    /// Why nothing more can be sent.
    fn send(&mut self, event: &Event, at: Time) -> io::Result<()>;

    /// Answers those that ask; `now` is since 1970.
    ///
    /// # Errors
    /// Why nothing more can be sent.
    fn attend(&mut self, now: Micros) -> io::Result<()>;

    /// Returns how many programs read now, if that is known.
    fn readers(&self) -> Option<usize>;

    /// Returns what other programs are to be told, in a sentence.
    fn description(&self) -> String;
}

/// A time by two clocks.
#[derive(Debug, Clone, Copy)]
pub struct Time {
    /// On the feed's clock.
    pub feed: Micros,
    /// Since 1970.
    pub utc: Micros,
}

/// Returns the time since 1970.
pub fn utc() -> Micros {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    Micros(since.map_or(0, |since| since.as_micros() as u64))
}

/// What [`relay`] has done so far.
#[derive(Debug, Clone, Copy)]
pub struct Relayed {
    /// The time on the feed's clock.
    pub now: Micros,
    /// Samples sent.
    pub samples: u64,
}

/// Sends a feed's samples and controls through an outlet, as long as `keep_going` returns true.
/// Other notices go to `sink`.
///
/// # Errors
/// Those of the outlet.
pub fn relay(
    feed: &mut Feed,
    mut clock: ClockEstimator,
    outlet: &mut dyn Outlet,
    sink: &mut dyn FnMut(Notice),
    keep_going: &mut dyn FnMut(Relayed) -> bool,
) -> io::Result<()> {
    let (mut events, mut samples) = (Vec::new(), 0);
    loop {
        let now = feed.now();
        if feed.is_over() || !keep_going(Relayed { now, samples }) {
            return Ok(());
        }
        feed.poll(now, &mut |notice| match notice {
            Notice::Decoded(event) => events.push(event),
            Notice::Offset { at, offset } => clock.set_offset(at, offset),
            other => sink(other),
        });
        let (now, clock_time) = (feed.now(), utc());
        for event in events.drain(..) {
            let feed = match &event {
                Event::Sample(sample) => {
                    samples += 1;
                    clock.stamp(sample, &mut |_| {}).time
                }
                _ => now,
            };
            let utc = clock_time.since(now.since(feed));
            outlet.send(&event, Time { feed, utc })?;
        }
        outlet.attend(clock_time)?;
        if !feed.is_live() {
            std::thread::sleep(Duration::from_micros(500));
        }
    }
}
