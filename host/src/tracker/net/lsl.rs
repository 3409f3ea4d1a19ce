//! Streams of the Lab Streaming Layer.

mod gaze;

use super::exchange::{Exchange, Exchanges};
use super::spec::LslSpec;
use super::{Peer, Server, socket};
use crate::files::Fault;
use crate::tracker::notice::Notice;
use gaze::Gaze;
use shisen_tracker::decoder::{Counts, Event, Message};
use shisen_tracker::net::lsl::{
    DISCOVERY_PORT, FIRST_PORT, FULL_INFO, Feed, GROUPS, Info, PORTS, Received, feed_request,
    labels, query, read_echo, read_reply, time_request,
};
use shisen_tracker::time::Micros;
use std::io::{Read as _, Write as _};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

/// From one question to the next.
const ASK: Duration = Duration::from_millis(250);

/// How long answers are waited for after the first stream that fits.
const OTHERS: Duration = Duration::from_millis(300);

/// Most streams, and most bytes of a description.
const MOST_STREAMS: usize = 64;
const MOST_DESCRIPTION: u64 = 1 << 18;

/// Silence after which a stream is looked for again.
const DEAD: Micros = Micros::from_millis(15_000);

/// How far multicast goes: this site.
const HOPS: u32 = 24;

/// A stream, and the host that said so.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    pub(crate) info: Info,
    pub(crate) host: IpAddr,
}

/// Returns the streams of this machine, of the local network and of `host` that answer: all within
/// `patience`, or, soon after there is one for which `fits` holds, those so far.
pub(crate) fn streams(
    host: Option<&str>,
    patience: Duration,
    fits: impl Fn(&Info) -> bool,
) -> Result<Vec<Stream>, Fault> {
    let failed = |error: std::io::Error| {
        let help = "see that UDP is allowed on this machine";
        Fault::new(format!("cannot ask for streams of LSL: {error}"), help)
    };
    let socket = socket::bind((Ipv4Addr::UNSPECIFIED, 0).into())?;
    socket.set_broadcast(true).map_err(failed)?;
    socket.set_multicast_ttl_v4(HOPS).map_err(failed)?;
    let port = socket.local_addr().map_err(failed)?.port();
    let id = std::process::id() ^ u32::from(port);
    let question = query("", port, id).unwrap_or_default();
    let mut asked: Vec<SocketAddr> = GROUPS
        .map(|group| (Ipv4Addr::from(group), DISCOVERY_PORT).into())
        .to_vec();
    let mut hosts = vec![IpAddr::V4(Ipv4Addr::LOCALHOST)];
    if let Some(host) = host {
        let server = Server {
            host: host.to_owned(),
            port: DISCOVERY_PORT,
        };
        hosts.extend(socket::addresses(&server)?.into_iter().map(|one| one.ip()));
    }
    for host in hosts {
        // One of a host's outlets answers at the port that they share.
        let ports = FIRST_PORT..FIRST_PORT + PORTS;
        asked.extend(
            ports
                .chain([DISCOVERY_PORT])
                .map(|port| SocketAddr::new(host, port)),
        );
    }
    let (begun, mut next, mut found) = (Instant::now(), Duration::ZERO, Vec::<Stream>::new());
    let mut end = patience;
    let mut buffer = vec![0; socket::LONGEST];
    while begun.elapsed() < end {
        if begun.elapsed() >= next {
            next += ASK;
            for address in &asked {
                // A network without a route to a group has no streams there.
                let _ = socket.send_to(question.as_bytes(), address);
            }
        }
        let read = socket::datagrams(&socket, &mut buffer, |bytes, from| {
            let Ok((answered, info)) = read_reply(bytes) else {
                return;
            };
            let is_new = found.iter().all(|one| one.info.uid != info.uid);
            if answered == id && is_new && found.len() < MOST_STREAMS {
                if fits(&info) {
                    end = end.min(begun.elapsed() + OTHERS);
                }
                let host = from.ip();
                found.push(Stream { info, host });
            }
        });
        read.map_err(failed)?;
    }
    found.sort_by(|one, other| one.info.name.cmp(&other.info.name));
    Ok(found)
}

/// An open stream.
pub(super) struct Inlet {
    stream: TcpStream,
    feed: Feed,
    gaze: Gaze,
    /// Where its clock is asked for.
    service: UdpSocket,
    wave: u32,
    exchanges: Exchanges,
    heard: Option<Micros>,
    buffer: Vec<u8>,
}

impl Inlet {
    /// Finds the one stream that fits, and asks for its samples.
    pub(super) fn open(spec: &LslSpec, patience: Duration) -> Result<Self, Fault> {
        let fits = |info: &Info| {
            let is = |wanted: &Option<String>, found: &str| {
                wanted.as_ref().is_none_or(|wanted| wanted == found)
            };
            is(&spec.name, &info.name) && is(&spec.kind, &info.kind)
        };
        let all = streams(spec.host.as_deref(), patience, fits)?;
        let fitting: Vec<&Stream> = all.iter().filter(|one| fits(&one.info)).collect();
        let [one] = fitting[..] else {
            return Err(none_or_several(spec, &all, &fitting));
        };
        let (info, server) = (&one.info, |port| Server {
            host: one.host.to_string(),
            port,
        });
        let labels = description(&server(info.data_port), patience)?;
        let gaze = Gaze::find(&spec.gaze, info, &labels)?;
        let mut stream = socket::connect(&server(info.data_port), patience)?;
        let service = socket::bind((Ipv4Addr::UNSPECIFIED, 0).into())?;
        let request = feed_request(&info.uid).unwrap_or_default();
        let asked = stream
            .write_all(request.as_bytes())
            .and_then(|()| service.set_nonblocking(true))
            .and_then(|()| service.connect((one.host, info.service_port)));
        asked.map_err(|error| {
            let message = format!("the stream {:?} cannot be read: {error}", info.name);
            Fault::new(message, "start the program that sends it again")
        })?;
        Ok(Self {
            stream,
            feed: Feed::new(info.format, info.channels, info.rate),
            gaze,
            service,
            wave: 0,
            exchanges: Exchanges::default(),
            heard: None,
            buffer: vec![0; socket::LONGEST],
        })
    }
}

fn none_or_several(spec: &LslSpec, all: &[Stream], fitting: &[&Stream]) -> Fault {
    let parts = [("type", &spec.kind), ("name", &spec.name)];
    let parts = parts
        .iter()
        .filter_map(|(key, value)| Some(format!("{key}={}", value.as_ref()?)));
    let wanted = parts.collect::<Vec<_>>().join("&");
    let text = |one: &Stream| {
        let (info, host) = (&one.info, one.host);
        format!("{:?} of type {:?} at {host}", info.name, info.kind)
    };
    if fitting.is_empty() {
        let there: Vec<String> = all.iter().map(text).collect();
        let help = if there.is_empty() {
            "no stream is there: start one, and see that no firewall is in the way; a host of \
             another network is asked with ?host=HOST"
                .to_owned()
        } else {
            format!("those that are there: {}", there.join(", "))
        };
        return Fault::new(format!("there is no LSL stream with {wanted}"), help);
    }
    let there: Vec<String> = fitting.iter().map(|one| text(one)).collect();
    Fault::new(
        format!(
            "{} LSL streams have {wanted}: {}",
            there.len(),
            there.join(", ")
        ),
        "give both type and name, or stop the others",
    )
}

/// Returns the labels of a stream's channels.
fn description(server: &Server, patience: Duration) -> Result<Vec<String>, Fault> {
    let mut stream = socket::connect(server, patience)?;
    let mut text = Vec::new();
    let begun = Instant::now();
    let read = stream.write_all(FULL_INFO.as_bytes()).and_then(|()| {
        stream.set_read_timeout(Some(patience))?;
        let mut chunk = [0; 4_096];
        // Until it closes, or for as long as `patience`, also where it sends little by little.
        while begun.elapsed() < patience && text.len() as u64 <= MOST_DESCRIPTION {
            match stream.read(&mut chunk)? {
                0 => break,
                length => text.extend_from_slice(&chunk[..length]),
            }
        }
        Ok(())
    });
    let text = String::from_utf8_lossy(&text);
    if read.is_err() || !text.trim_ascii_end().ends_with("</info>") {
        let message = format!("the outlet at {server} does not describe its stream");
        return Err(Fault::new(message, "start the program that sends it again"));
    }
    Ok(labels(&text).map(|label| label.to_string()).collect())
}

impl Peer for Inlet {
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String> {
        let (feed, gaze, heard) = (&mut self.feed, &self.gaze, &mut self.heard);
        let mut refusal = None;
        let read = socket::bytes(&mut self.stream, &mut self.buffer, |bytes| {
            let now = now();
            *heard = Some(now);
            feed.feed(bytes, now, &mut |received| match received {
                Received::Record(record) => {
                    sink(Notice::Decoded(Event::Sample(gaze.sample(&record))));
                }
                Received::Event(event) => {
                    if let Event::Message(Message::Fault { code, meaning }) = &event {
                        refusal = Some(format!("it refuses: {meaning} ({code})"));
                    }
                    sink(Notice::Decoded(event));
                }
            });
        });
        if self.feed.is_lost() {
            return Err(refusal.unwrap_or_else(|| "it sends what no outlet sends".to_owned()));
        }
        read?;
        let exchanges = &mut self.exchanges;
        let answered = socket::datagrams(&self.service, &mut self.buffer, |bytes, _| {
            let at = now();
            if let Ok(echo) = read_echo(bytes, at) {
                exchanges.take(Exchange {
                    at,
                    offset: echo.offset,
                    round_trip: echo.round_trip,
                });
            }
        });
        answered.map_err(|error| error.to_string())?;
        let now = now();
        let (asks, found) = self.exchanges.poll(now);
        if asks {
            self.wave = self.wave.wrapping_add(1);
            let request = time_request(self.wave, now).unwrap_or_default();
            // One that is lost is not missed.
            let _ = self.service.send(request.as_bytes());
        }
        found.into_iter().for_each(sink);
        if now.since(*self.heard.get_or_insert(now)) > DEAD {
            return Err(format!("nothing has come for {:.0} s", DEAD.seconds()));
        }
        Ok(())
    }

    fn counts(&self) -> Counts {
        *self.feed.counts()
    }

    fn remedy(&self) -> String {
        "see that the program that sends the stream runs, and that its eye tracker records"
            .to_owned()
    }
}
