//! Devices of VRPN servers.

use super::{Peer, Server, socket};
use crate::files::Fault;
use crate::tracker::notice::Notice;
use crate::tracker::raw::{Piece, Tap};
use shisen_tracker::decoder::{Counts, Decoder as _, Event};
use shisen_tracker::net::vrpn::{COOKIE, Config, Encoder, PING, Vrpn};
use shisen_tracker::time::Micros;
use std::io::Write as _;
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// From one question whether the server lives to the next, and the silence after which it does not.
const ASK: Micros = Micros::from_millis(1_000);
const DEAD: Micros = Micros::from_millis(10_000);

/// The silence after which it may not be there: it answers each question.
const ABSENT: Micros = Micros::from_millis(2_500);

/// A connection to a server.
pub(super) struct Client {
    stream: TcpStream,
    decoder: Vrpn,
    tap: Tap,
    encoder: Encoder,
    /// What came with the descriptions.
    early: Vec<Event>,
    ask_at: Micros,
    heard: Option<Micros>,
    buffer: Vec<u8>,
}

impl Client {
    /// Connects, and waits until the server describes the device.
    pub(super) fn open(
        device: &Config,
        server: &Server,
        patience: Duration,
        tap: Tap,
    ) -> Result<Self, Fault> {
        let mut client = Self::greet(device, server, patience)?;
        client.tap = tap;
        client.wait(patience, Vrpn::has_device);
        if client.decoder.has_device() {
            return Ok(client);
        }
        let mut senders = names(&client.decoder).peekable();
        let name = device.device.as_str();
        Err(if !client.decoder.is_greeted() {
            not_vrpn(server)
        } else if senders.peek().is_none() {
            let message = format!("the VRPN server {server} has no device so far");
            Fault::new(message, "start its devices, and look at what it prints")
        } else {
            let all = senders.collect::<Vec<_>>().join(", ");
            Fault::new(
                format!("the VRPN server {server} has no device {name}"),
                format!("give one of its devices, in which case matters: {all}"),
            )
        })
    }

    /// Connects and says what a client says first.
    fn greet(device: &Config, server: &Server, patience: Duration) -> Result<Self, Fault> {
        let mut stream = socket::connect(server, patience)?;
        let mut encoder = Encoder::new();
        let mut hello = COOKIE.to_vec();
        hello.extend_from_slice(&encoder.sender(Micros(0), 0, &device.device));
        hello.extend_from_slice(&encoder.kind(Micros(0), 0, PING));
        stream.write_all(&hello).map_err(|error| {
            let message = format!("the server {server} takes nothing: {error}");
            Fault::new(message, "start it again")
        })?;
        Ok(Self {
            stream,
            decoder: Vrpn::new(device.clone()),
            tap: Tap::default(),
            encoder,
            early: Vec::new(),
            ask_at: Micros(0),
            heard: None,
            buffer: vec![0; 4_096],
        })
    }

    /// Reads until `is_enough`, or for as long as `patience`.
    fn wait(&mut self, patience: Duration, is_enough: impl Fn(&Vrpn) -> bool) {
        let begun = Instant::now();
        let mut goes_on = true;
        while goes_on && !is_enough(&self.decoder) && begun.elapsed() < patience {
            let (decoder, early, tap) = (&mut self.decoder, &mut self.early, &self.tap);
            early.clear();
            let read = socket::bytes(&mut self.stream, &mut self.buffer, |bytes| {
                tap.take(Piece::Came, bytes, Micros(0));
                decoder.feed(bytes, Micros(0), &mut |event| early.push(event));
            });
            goes_on = read.is_ok() && !self.decoder.is_lost();
        }
    }
}

fn not_vrpn(server: &Server) -> Fault {
    let message = format!("{server} does not answer as a VRPN server of version 7");
    Fault::new(
        message,
        "check host and port: a server's usual port is 3883",
    )
}

impl Peer for Client {
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String> {
        let mut hand_over = |event, arrival| {
            let mut event = event;
            if let Event::Sample(sample) = &mut event {
                sample.arrival = arrival;
            }
            sink(Notice::Decoded(event));
        };
        for event in self.early.drain(..) {
            hand_over(event, now());
        }
        let (decoder, heard, tap) = (&mut self.decoder, &mut self.heard, &self.tap);
        let read = socket::bytes(&mut self.stream, &mut self.buffer, |bytes| {
            let now = now();
            *heard = Some(now);
            tap.take(Piece::Came, bytes, now);
            decoder.feed(bytes, now, &mut |event| hand_over(event, now));
        });
        if self.decoder.is_lost() {
            return Err("it sends what no VRPN server sends".to_owned());
        }
        read?;
        let now = now();
        if now.since(*self.heard.get_or_insert(now)) > DEAD {
            return Err(format!("it has not answered for {:.0} s", DEAD.seconds()));
        }
        if now >= self.ask_at {
            self.ask_at = now.after(ASK);
            let ping = self.encoder.message(Micros(0), [0, 0], &[]);
            let sent = self.stream.write_all(&ping);
            return sent.map_err(|error| error.to_string());
        }
        Ok(())
    }

    fn counts(&self) -> Counts {
        *self.decoder.counts()
    }

    fn is_present(&self, now: Micros) -> bool {
        self.heard.is_none_or(|heard| now.since(heard) < ABSENT)
    }

    fn remedy(&self) -> String {
        "the server answers, but does not see the device move: see that the tracker is on, and the \
         head in its field"
            .to_owned()
    }
}

/// Returns the devices that a server describes within `patience`.
pub(crate) fn devices(server: &Server, patience: Duration) -> Result<Vec<String>, Fault> {
    // No device has an empty name: it waits for all.
    let none = Config::new("").ok_or_else(|| not_vrpn(server))?;
    let mut client = Client::greet(&none, server, patience)?;
    client.wait(patience, |_| false);
    if !client.decoder.is_greeted() {
        return Err(not_vrpn(server));
    }
    Ok(names(&client.decoder).map(str::to_owned).collect())
}

/// Returns the names of devices: not what every server has of itself, nor what this client said.
fn names(decoder: &Vrpn) -> impl Iterator<Item = &str> {
    let own = ["VRPN Control", "vrpn_Forwarder_Brain", ""];
    decoder.senders().filter(move |name| !own.contains(name))
}
