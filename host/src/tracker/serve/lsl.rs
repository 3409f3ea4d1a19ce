//! An outlet of the Lab Streaming Layer: gaze and head in one stream.

use super::outlet::{self, Time};
use crate::files::Fault;
use rustix::net::sockopt::set_socket_reuseaddr;
use rustix::net::{AddressFamily, SocketType, bind, socket};
use shisen_tracker::decoder::Event;
use shisen_tracker::net::lsl::{DISCOVERY_PORT, FIRST_PORT, GROUPS, PORTS};
use shisen_tracker::sample::{Eye, Pupil, Sample};
use shisen_tracker::time::Micros;
use std::fmt::Write as _;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4, TcpListener, TcpStream, UdpSocket};

/// The channels: label, type and unit.
const CHANNELS: [(&str, &str, &str); 13] = [
    ("gaze_direction_x", "DirectionX", "normalized"),
    ("gaze_direction_y", "DirectionY", "normalized"),
    ("gaze_direction_z", "DirectionZ", "normalized"),
    ("confidence", "Confidence", "normalized"),
    ("left_pupil_diameter", "Diameter", "meters"),
    ("right_pupil_diameter", "Diameter", "meters"),
    ("head_position_x", "PositionX", "meters"),
    ("head_position_y", "PositionY", "meters"),
    ("head_position_z", "PositionZ", "meters"),
    ("head_orientation_x", "OrientationX", "quaternion"),
    ("head_orientation_y", "OrientationY", "quaternion"),
    ("head_orientation_z", "OrientationZ", "quaternion"),
    ("head_orientation_w", "OrientationW", "quaternion"),
];

/// The time of both test patterns, and what their numbers begin at.
const PATTERN_TIME: f64 = 123_456.789;
const PATTERN_BASE: i64 = 16_777_217;
const PATTERN_OFFSETS: [i64; 2] = [4, 2];

/// Most connections at a time, and most bytes of a request.
const MOST_CLIENTS: usize = 16;
const LONGEST_REQUEST: usize = 4_096;

/// A stream.
pub(super) struct Outlet {
    name: String,
    uid: String,
    /// When it was opened, seconds since 1970; readers ask again while it is 0.
    created: f64,
    port: u16,
    listener: TcpListener,
    /// Where its description and its time are asked for: by port, and by all streams' port.
    asked: Vec<UdpSocket>,
    clients: Vec<Client>,
}

struct Client {
    stream: TcpStream,
    request: Vec<u8>,
    /// Whether it gets samples.
    is_fed: bool,
}

impl Outlet {
    pub(super) fn open(name: &str, address: IpAddr) -> Result<Self, Fault> {
        let failed = |what: &str, error: &io::Error| {
            let help = "give an address of this machine with --to: 0.0.0.0 is all of them";
            Fault::new(format!("cannot serve LSL at {what}: {error}"), help)
        };
        let IpAddr::V4(address) = address else {
            return Err(Fault::new(
                "LSL is served over IPv4",
                "give an IPv4 address with --to",
            ));
        };
        let own = |port: u16| {
            let listener = TcpListener::bind((address, port))?;
            let service = UdpSocket::bind((address, port))?;
            listener.set_nonblocking(true)?;
            service.set_nonblocking(true)?;
            Ok((listener, service))
        };
        let mut free = (FIRST_PORT..FIRST_PORT + PORTS).map(|port| (port, own(port)));
        let found = free.find_map(|(port, opened)| Some((port, opened.ok()?)));
        let Some((port, (listener, service))) = found else {
            let error = own(FIRST_PORT)
                .err()
                .unwrap_or_else(|| ErrorKind::AddrInUse.into());
            return Err(failed(&address.to_string(), &error));
        };
        let shared = shared(address)
            .map_err(|error| failed(&format!("UDP {address}:{DISCOVERY_PORT}"), &error))?;
        let since = std::time::SystemTime::UNIX_EPOCH
            .elapsed()
            .unwrap_or_default();
        Ok(Self {
            name: name.to_owned(),
            created: since.as_secs_f64(),
            uid: format!("{:x}-{:x}", std::process::id(), since.as_nanos()),
            port,
            listener,
            asked: vec![service, shared],
            clients: Vec::new(),
        })
    }

    /// Returns the stream's description, in full or in short.
    fn describe(&self, is_full: bool) -> String {
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<info>\n<name>{}</name>\n<type>Gaze</type>\n\
             <channel_count>{}</channel_count>\n<channel_format>double64</channel_format>\n\
             <source_id>shisen-{}</source_id>\n<nominal_srate>0.0</nominal_srate>\n\
             <version>1.1</version>\n<created_at>{}</created_at>\n<uid>{}</uid>\n\
             <session_id>default</session_id>\n<hostname>{}</hostname>\n<v4address></v4address>\n\
             <v4data_port>{port}</v4data_port>\n<v4service_port>{port}</v4service_port>\n\
             <v6address></v6address>\n<v6data_port>0</v6data_port>\n\
             <v6service_port>0</v6service_port>\n<desc>",
            escaped(&self.name),
            CHANNELS.len(),
            escaped(&self.name),
            self.created,
            self.uid,
            escaped(&rustix::system::uname().nodename().to_string_lossy()),
            port = self.port,
        );
        if is_full {
            text += "<channels>";
            for (label, kind, unit) in CHANNELS {
                // Writing to a string does not fail.
                let _ = write!(
                    text,
                    "<channel><label>{label}</label><type>{kind}</type><unit>{unit}</unit></channel>"
                );
            }
            text += "</channels>";
        }
        text + "</desc>\n</info>\n"
    }

    /// Returns whether a query means this stream: conditions joined by `and`. Others than those of
    /// the usual forms get no answer.
    fn fits(&self, query: &str) -> bool {
        let channels = CHANNELS.len().to_string();
        let source = format!("shisen-{}", self.name);
        let own = [
            ("session_id", "default"),
            ("name", &self.name),
            ("type", "Gaze"),
            ("source_id", &source),
            ("channel_count", &channels),
            ("channel_format", "double64"),
        ];
        let is_own = |condition: &str| {
            let condition = condition.split_once('=');
            let condition = condition.map(|(key, value)| (key.trim(), value.trim()));
            condition.is_some_and(|(key, value)| {
                let value = value.trim_matches('\'').trim_matches('"');
                own.contains(&(key, value))
            })
        };
        query.trim().is_empty() || query.split(" and ").all(is_own)
    }

    /// Returns the answer to a datagram, and the port that it goes to if that is another.
    fn answer(&self, datagram: &str, now: Micros) -> Option<(String, Option<u16>)> {
        let mut lines = datagram.lines();
        match lines.next()? {
            "LSL:shortinfo" => {
                let (query, back) = (lines.next()?, lines.next()?);
                let (port, id) = back.split_once(' ')?;
                let answer = format!("{id}\r\n{}", self.describe(false));
                self.fits(query)
                    .then_some((answer, Some(port.parse().ok()?)))
            }
            "LSL:timedata" => {
                let (wave, sent) = lines.next()?.split_once(' ')?;
                let now = seconds(now);
                Some((format!(" {wave} {sent} {now:.9} {now:.9}"), None))
            }
            _ => None,
        }
    }

    /// Answers a whole request; returns whether the connection stays.
    fn serve(&self, client: &mut Client) -> bool {
        let text = String::from_utf8_lossy(&client.request).into_owned();
        let mut lines = text.split_inclusive('\n');
        let first = lines.next().unwrap_or_default();
        if !first.ends_with('\n') {
            return client.request.len() < LONGEST_REQUEST;
        }
        let first = first.trim_end();
        if first == "LSL:fullinfo" {
            let _ = client.stream.write_all(self.describe(true).as_bytes());
            return false;
        }
        if first == "LSL:shortinfo" {
            let query = lines.next().unwrap_or_default();
            if query.ends_with('\n') && self.fits(query) {
                let _ = client.stream.write_all(self.describe(false).as_bytes());
            }
            return !query.ends_with('\n');
        }
        let Some(wanted) = first.strip_prefix("LSL:streamfeed/") else {
            return false;
        };
        if !text.contains("\r\n\r\n") {
            return client.request.len() < LONGEST_REQUEST;
        }
        let (version, uid) = wanted.split_once(' ').unwrap_or((wanted, ""));
        let refusal = match version.parse::<u32>() {
            Ok(100..200) if uid.is_empty() || uid == self.uid => None,
            Ok(100..200) => Some("404 Not found"),
            _ => Some("505 Version not supported"),
        };
        if let Some(refusal) = refusal {
            let _ = write!(client.stream, "LSL/110 {refusal}");
            return false;
        }
        let mut bytes = format!(
            "LSL/110 200 OK\r\nUID: {}\r\nByte-Order: 1234\r\nSuppress-Subnormals: 0\r\n\
             Data-Protocol-Version: 110\r\n\r\n",
            self.uid
        )
        .into_bytes();
        for offset in PATTERN_OFFSETS {
            let number = |channel: usize| {
                let sign = if channel.is_multiple_of(2) { 1 } else { -1 };
                (sign * (PATTERN_BASE + offset + channel as i64)) as f64
            };
            encode(PATTERN_TIME, (0..CHANNELS.len()).map(number), &mut bytes);
        }
        client.request.clear();
        client.is_fed = true;
        client.stream.write_all(&bytes).is_ok()
    }
}

impl outlet::Outlet for Outlet {
    fn send(&mut self, event: &Event, at: Time) -> io::Result<()> {
        if let Event::Sample(sample) = event {
            let mut bytes = Vec::new();
            encode(seconds(at.utc), channels(sample).into_iter(), &mut bytes);
            let sent =
                |client: &mut Client| !client.is_fed || client.stream.write_all(&bytes).is_ok();
            self.clients.retain_mut(sent);
        }
        Ok(())
    }

    fn attend(&mut self, now: Micros) -> io::Result<()> {
        let mut buffer = [0; LONGEST_REQUEST];
        for socket in &self.asked {
            while let Ok((length, from)) = socket.recv_from(&mut buffer) {
                let text = String::from_utf8_lossy(&buffer[..length]);
                if let Some((answer, port)) = self.answer(&text, now) {
                    let to = SocketAddr::new(from.ip(), port.unwrap_or(from.port()));
                    // Who does not hear it asks again.
                    let _ = self.asked[0].send_to(answer.as_bytes(), to);
                }
            }
        }
        while let Ok((stream, _)) = self.listener.accept() {
            let _ = stream.set_nodelay(true);
            if self.clients.len() < MOST_CLIENTS && stream.set_nonblocking(true).is_ok() {
                self.clients.push(Client {
                    stream,
                    request: Vec::new(),
                    is_fed: false,
                });
            }
        }
        let mut clients = std::mem::take(&mut self.clients);
        clients.retain_mut(|client| match client.stream.read(&mut buffer) {
            Ok(0) => false,
            Ok(_) if client.is_fed => true,
            Ok(length) => {
                client.request.extend_from_slice(&buffer[..length]);
                self.serve(client)
            }
            Err(error) => error.kind() == ErrorKind::WouldBlock,
        });
        self.clients = clients;
        Ok(())
    }

    fn readers(&self) -> Option<usize> {
        Some(self.clients.iter().filter(|client| client.is_fed).count())
    }

    fn description(&self) -> String {
        let (name, port) = (&self.name, self.port);
        format!("an LSL stream {name} of type Gaze is at TCP and UDP {port}")
    }
}

/// Opens the port that all outlets of a machine share.
fn shared(address: Ipv4Addr) -> io::Result<UdpSocket> {
    let shared = socket(AddressFamily::INET, SocketType::DGRAM, None)?;
    set_socket_reuseaddr(&shared, true)?;
    // Queries of the network come to groups, which a socket of one address does not hear.
    let own = if address.is_loopback() {
        address
    } else {
        Ipv4Addr::UNSPECIFIED
    };
    bind(&shared, &SocketAddrV4::new(own, DISCOVERY_PORT))?;
    let shared = UdpSocket::from(shared);
    shared.set_nonblocking(true)?;
    if !address.is_loopback() {
        for group in GROUPS.map(Ipv4Addr::from) {
            if group.is_multicast() {
                // A network without multicast has the host's address.
                let _ = shared.join_multicast_v4(&group, &address);
            }
        }
    }
    Ok(shared)
}

fn seconds(time: Micros) -> f64 {
    time.0 as f64 * 1.0e-6
}

fn encode(time: f64, numbers: impl Iterator<Item = f64>, to: &mut Vec<u8>) {
    to.push(2);
    to.extend_from_slice(&time.to_le_bytes());
    numbers.for_each(|number| to.extend_from_slice(&number.to_le_bytes()));
}

/// Returns the numbers of [`CHANNELS`]; NaN where a sample has none.
fn channels(sample: &Sample) -> [f64; CHANNELS.len()] {
    let direction = |eye: &Eye| eye.direction.filter(|one| one.tracked).map(|one| one.value);
    let both = [&sample.left, &sample.right].map(direction);
    let mean = match both {
        [Some(left), Some(right)] => (left + right).try_normalize(),
        [left, right] => left.or(right),
    };
    let gaze = direction(&sample.combined).or(mean);
    let pupil = |eye: &Eye| match eye.pupil {
        Some(Pupil::Diameter(metres)) => metres,
        _ => f32::NAN,
    };
    let [x, y, z] = gaze.map_or([f32::NAN; 3], |gaze| gaze.to_array());
    let head = &sample.head;
    let place = head
        .position
        .filter(|one| one.tracked)
        .map(|one| one.value.to_array());
    let turn = head
        .orientation
        .filter(|one| one.tracked)
        .map(|one| one.value.to_array());
    let ([px, py, pz], [qx, qy, qz, qw]) = (
        place.unwrap_or([f32::NAN; 3]),
        turn.unwrap_or([f32::NAN; 4]),
    );
    let confidence = if gaze.is_some() { 1.0 } else { 0.0 };
    let pupils = [pupil(&sample.left), pupil(&sample.right)];
    let all = [
        x, y, z, confidence, pupils[0], pupils[1], px, py, pz, qx, qy, qz, qw,
    ];
    all.map(f64::from)
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;")
}
