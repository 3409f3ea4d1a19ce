//! A VRPN server with one device.

use super::outlet::{Outlet, Time};
use crate::files::Fault;
use shisen_tracker::decoder::{Control, ControlState, Decoder as _, Event, Message};
use shisen_tracker::net::vrpn::{ANALOG, BUTTON, COOKIE, Config, Encoder, PING, PONG, POSE, Vrpn};
use shisen_tracker::time::Micros;
use std::collections::BTreeSet;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

/// The device's sender, and its types.
const DEVICE: i32 = 0;
const TYPES: [&str; 5] = [POSE, BUTTON, ANALOG, PING, PONG];

const BUTTON_IDS: [i32; 2] = [DEVICE, 1];
const ANALOG_IDS: [i32; 2] = [DEVICE, 2];

fn button_body(number: u8, is_pressed: bool) -> Vec<u8> {
    let words = [i32::from(number), i32::from(is_pressed)];
    words.into_iter().flat_map(i32::to_be_bytes).collect()
}

fn analog_body(axes: &[f64]) -> Vec<u8> {
    let count = [axes.len() as f64];
    let numbers = count.iter().chain(axes);
    numbers.flat_map(|number| number.to_be_bytes()).collect()
}

/// Most clients at a time, and calls.
const MOST_CLIENTS: usize = 16;

/// How long a client that asked by UDP is called.
const CALL: Duration = Duration::from_millis(500);

/// Most axes of a device.
const MOST_AXES: usize = 128;

/// A server.
pub(super) struct Server {
    name: String,
    listener: TcpListener,
    /// Where clients ask to be called.
    lobs: UdpSocket,
    called: (Sender<TcpStream>, Receiver<TcpStream>),
    clients: Vec<Client>,
    axes: Vec<f64>,
    /// The buttons that are pressed.
    pressed: BTreeSet<u8>,
    /// Calls that are being made.
    calls: Arc<AtomicUsize>,
}

struct Client {
    stream: TcpStream,
    /// What the client says, among which are its pings.
    decoder: Vrpn,
    encoder: Encoder,
}

impl Server {
    pub(super) fn open(name: &str, address: SocketAddr) -> Result<Self, Fault> {
        let opened = TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let lobs = UdpSocket::bind(listener.local_addr()?)?;
            lobs.set_nonblocking(true)?;
            Ok((listener, lobs))
        });
        let (listener, lobs) = opened.map_err(|error| {
            let help = "end the program that serves there, or give another address with --to";
            Fault::new(format!("cannot serve VRPN at {address}: {error}"), help)
        })?;
        Ok(Self {
            name: name.to_owned(),
            listener,
            lobs,
            called: channel(),
            clients: Vec::new(),
            axes: Vec::new(),
            pressed: BTreeSet::new(),
            calls: Arc::default(),
        })
    }

    /// Greets a client, and describes the device.
    fn greet(&mut self, stream: TcpStream) {
        let Some(config) = Config::new(&self.name) else {
            return;
        };
        if self.clients.len() >= MOST_CLIENTS || stream.set_nonblocking(true).is_err() {
            return;
        }
        let _ = stream.set_nodelay(true);
        let mut encoder = Encoder::new();
        let mut hello = COOKIE.to_vec();
        hello.extend_from_slice(&encoder.sender(Micros(0), DEVICE, &self.name));
        for (id, kind) in (0..).zip(TYPES) {
            hello.extend_from_slice(&encoder.kind(Micros(0), id, kind));
        }
        // What is held already.
        for button in &self.pressed {
            hello.extend_from_slice(&encoder.message(
                Micros(0),
                BUTTON_IDS,
                &button_body(*button, true),
            ));
        }
        if !self.axes.is_empty() {
            hello.extend_from_slice(&encoder.message(
                Micros(0),
                ANALOG_IDS,
                &analog_body(&self.axes),
            ));
        }
        let mut client = Client {
            stream,
            decoder: Vrpn::new(config),
            encoder,
        };
        if client.stream.write_all(&hello).is_ok() {
            self.clients.push(client);
        }
    }

    /// Calls a client that asks so. It is the sender of the datagram, whatever that names.
    fn call(&self) {
        let mut text = [0; 200];
        while let Ok((length, from)) = self.lobs.recv_from(&mut text) {
            let words = std::str::from_utf8(&text[..length]).unwrap_or_default();
            let words = words.trim_end_matches('\0');
            let port = words
                .split_once(' ')
                .and_then(|(_, port)| port.parse().ok());
            let is_busy = self.calls.load(Ordering::Relaxed) >= MOST_CLIENTS;
            if let Some(port) = port.filter(|port| *port >= 1_024 && !is_busy) {
                let (to, called) = (SocketAddr::new(from.ip(), port), self.called.0.clone());
                let calls = Arc::clone(&self.calls);
                calls.fetch_add(1, Ordering::Relaxed);
                let call = move || {
                    if let Ok(stream) = TcpStream::connect_timeout(&to, CALL) {
                        // Fails where the server has ended.
                        let _ = called.send(stream);
                    }
                    calls.fetch_sub(1, Ordering::Relaxed);
                };
                if std::thread::Builder::new().spawn(call).is_err() {
                    self.calls.fetch_sub(1, Ordering::Relaxed);
                }
            }
        }
    }

    /// Sends a message to all clients; those that do not read are left.
    fn send_to_all(&mut self, time: Micros, kind: &str, body: &[u8]) {
        let kind = TYPES.iter().position(|one| *one == kind).unwrap_or(0) as i32;
        self.clients.retain_mut(|client| {
            let message = client.encoder.message(time, [DEVICE, kind], body);
            client.stream.write_all(&message).is_ok()
        });
    }

    fn send_control(&mut self, time: Micros, control: &Control) {
        match control.state {
            ControlState::Button(is_pressed) => {
                if is_pressed {
                    self.pressed.insert(control.number);
                } else {
                    self.pressed.remove(&control.number);
                }
                let body = button_body(control.number, is_pressed);
                self.send_to_all(time, BUTTON, &body);
            }
            ControlState::Axis(value) => {
                let number = usize::from(control.number);
                if number < MOST_AXES {
                    self.axes.resize(self.axes.len().max(number + 1), 0.0);
                    self.axes[number] = f64::from(value);
                }
                let body = analog_body(&self.axes);
                self.send_to_all(time, ANALOG, &body);
            }
        }
    }
}

impl Outlet for Server {
    fn send(&mut self, event: &Event, at: Time) -> io::Result<()> {
        match event {
            Event::Sample(sample) => {
                let head = &sample.head;
                let is_seen = head.position.is_none_or(|place| place.tracked)
                    && head.orientation.is_some_and(|turn| turn.tracked);
                // A head that is not seen is not sent.
                if is_seen {
                    self.clients.retain_mut(|client| {
                        let message = client.encoder.pose(at.utc, [DEVICE, 0], sample);
                        client.stream.write_all(&message).is_ok()
                    });
                }
            }
            Event::Message(Message::Control(control)) => self.send_control(at.utc, control),
            _ => {}
        }
        Ok(())
    }

    fn attend(&mut self, now: Micros) -> io::Result<()> {
        while let Ok((stream, _)) = self.listener.accept() {
            self.greet(stream);
        }
        self.call();
        while let Ok(stream) = self.called.1.try_recv() {
            self.greet(stream);
        }
        let pong = TYPES.len() as i32 - 1;
        self.clients.retain_mut(|client| {
            let mut bytes = [0; 4_096];
            match client.stream.read(&mut bytes) {
                Ok(0) => return false,
                Ok(length) => client.decoder.feed(&bytes[..length], now, &mut |_| {}),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => return false,
            }
            let pings = client.decoder.take_pings();
            let is_answered = pings == 0 || {
                let message = client.encoder.message(Micros(0), [DEVICE, pong], &[]);
                client.stream.write_all(&message).is_ok()
            };
            is_answered && !client.decoder.is_lost()
        });
        Ok(())
    }

    fn readers(&self) -> Option<usize> {
        Some(self.clients.len())
    }

    fn description(&self) -> String {
        let at = self.listener.local_addr();
        let at = at.map_or_else(|_| String::new(), |at| at.to_string());
        format!("a VRPN server has the device {} at {at}", self.name)
    }
}
