use super::*;
use crate::tracker::serve::{NetProtocol, relay};
use crate::tracker::{Feed, Spec};
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::sample::Sample;
use std::net::{TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// A mock that is served until it is dropped.
struct Served {
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    fn new(protocol: &str, to: &str) -> Self {
        let protocol: NetProtocol = protocol.parse().unwrap();
        let over = Arc::new(AtomicBool::new(false));
        let until = Arc::clone(&over);
        let (ready, made) = std::sync::mpsc::channel();
        let to = to.to_owned();
        let thread = std::thread::spawn(move || {
            let mut outlet = protocol.open(Some(&to)).unwrap();
            ready.send(()).unwrap();
            let spec: Spec = "mock:rate=200&still=0".parse().unwrap();
            let mut feed = Feed::open(&spec).unwrap();
            let clock = ClockEstimator::new(ClockConfig::default()).unwrap();
            let goes_on = &mut |_| !until.load(Ordering::Relaxed);
            relay(&mut feed, clock, outlet.as_mut(), &mut |_| {}, goes_on).unwrap();
        });
        made.recv().unwrap();
        Self {
            over,
            thread: Some(thread),
        }
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

fn open(spec: &str) -> Result<Feed, Fault> {
    Feed::open(&spec.parse().unwrap())
}

/// Polls for at most so many seconds, until `is_enough`; returns the samples, and what was said.
fn listen(
    feed: &mut Feed,
    seconds: u64,
    is_enough: impl Fn(&[Sample], &[String]) -> bool,
) -> (Vec<Sample>, Vec<String>) {
    let (mut samples, mut said) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    while begun.elapsed().as_secs() < seconds && !is_enough(&samples, &said) {
        feed.poll(feed.now(), &mut |notice| match notice {
            Notice::Decoded(Event::Sample(sample)) => samples.push(sample),
            Notice::Decoded(_) => {}
            Notice::Offset { .. } => said.push("offset".to_owned()),
            other => said.push(format!("{other:?}")),
        });
    }
    (samples, said)
}

/// What is served is read as it was measured, by each protocol.
#[test]
fn a_mock_goes_there_and_back() {
    let spec: Spec = "mock:rate=200".parse().unwrap();
    let mut mock = Feed::open(&spec).unwrap();
    let mut measured: Vec<Sample> = Vec::new();
    mock.poll(Micros::from_millis(30_000), &mut |notice| {
        if let Notice::Decoded(Event::Sample(sample)) = notice {
            measured.push(sample);
        }
    });
    let [vrpn, dtrack, opentrack] = [0; 3].map(|_| free_port());
    for (protocol, to, spec, has_gaze) in [
        (
            "vrpn?name=A",
            format!("127.0.0.1:{vrpn}"),
            format!("vrpn:A@127.0.0.1:{vrpn}"),
            false,
        ),
        (
            "dtrack",
            format!("127.0.0.1:{dtrack}"),
            format!("dtrack:{dtrack}?body=0"),
            false,
        ),
        (
            "opentrack",
            format!("127.0.0.1:{opentrack}"),
            format!("udp:{opentrack}?protocol=opentrack"),
            false,
        ),
        (
            "lsl?name=back",
            "127.0.0.1".to_owned(),
            "lsl:name=back".to_owned(),
            true,
        ),
    ] {
        let _served = Served::new(protocol, &to);
        let mut feed = open(&spec).unwrap_or_else(|fault| panic!("{spec}: {}", with_help(&fault)));
        let (samples, said) = listen(&mut feed, 10, |samples, said| {
            samples.len() >= 100 && (!has_gaze || said.iter().any(|one| one == "offset"))
        });
        assert!(samples.len() >= 100, "{spec}: {} {said:?}", samples.len());
        assert_eq!(feed.counts().dropped_bytes, 0, "{spec}");
        let mut seen = 0;
        for sample in &samples {
            if has_gaze {
                let Some(gaze) = sample.combined.direction.filter(|gaze| gaze.tracked) else {
                    continue;
                };
                seen += 1;
                let of = |one: &Sample| {
                    let both = one.left.direction.zip(one.right.direction);
                    both.map(|(left, right)| (left.value + right.value).normalize())
                };
                let off = |one: &Sample| of(one).map_or(9.0, |one| one.distance(gaze.value));
                let least = measured.iter().map(off).fold(9.0, f32::min);
                assert!(least < 1.0e-3, "{least}");
            } else if let (Some(place), Some(turn)) =
                (sample.head.position, sample.head.orientation)
            {
                seen += 1;
                let off = |one: &Sample| {
                    let head = one.head.position.zip(one.head.orientation);
                    head.map_or(9.0, |(other, other_turn)| {
                        place.value.distance(other.value)
                            + turn.value.angle_between(other_turn.value)
                    })
                };
                let least = measured.iter().map(off).fold(9.0, f32::min);
                assert!(least < 2.0e-3, "{spec}: {least}");
            }
        }
        assert!(seen > 50, "{spec}: {seen}");
        assert_eq!(has_gaze, said.iter().any(|one| one == "offset"), "{said:?}");
        let warns = said.iter().any(|one| one.contains("give delay=S"));
        assert_eq!(!has_gaze, warns, "{said:?}");
    }
}

#[test]
fn a_server_that_ends_is_waited_for() {
    let port = free_port();
    let to = format!("127.0.0.1:{port}");
    let served = Served::new("vrpn", &to);
    let mut feed = open(&format!("vrpn:Tracker0@{to}")).unwrap();
    assert!(
        !listen(&mut feed, 5, |samples, _| !samples.is_empty())
            .0
            .is_empty()
    );
    drop(served);
    let gone = |_: &[Sample], said: &[String]| said.iter().any(|one| one.contains("Unplugged"));
    let (_, said) = listen(&mut feed, 5, gone);
    assert!(gone(&[], &said), "{said:?}");
    let _served = Served::new("vrpn", &to);
    let (samples, said) = listen(&mut feed, 10, |samples, _| !samples.is_empty());
    assert!(
        !samples.is_empty() && said.iter().any(|one| one.contains("is back")),
        "{said:?}"
    );
    // Names that are not there, and those that are.
    let fault = open(&format!("vrpn:tracker0@{to}")).unwrap_err();
    assert!(with_help(&fault).contains("has no device tracker0; give one of its devices"));
    assert!(
        with_help(&fault).ends_with("matters: Tracker0"),
        "{}",
        with_help(&fault)
    );
    let server = Server::of_vrpn(&to).unwrap();
    assert_eq!(devices(&server, PATIENCE[1]).unwrap(), ["Tracker0"]);
}

#[test]
fn streams_that_are_no_one_are_named() {
    let _served = ["lsl?name=twice", "lsl?name=twice"].map(|one| Served::new(one, "127.0.0.1"));
    let fault = open("lsl:name=twice").unwrap_err();
    assert!(
        fault
            .to_string()
            .starts_with("2 LSL streams have name=twice"),
        "{fault}"
    );
    let fault = open("lsl:name=never").unwrap_err();
    let text = with_help(&fault);
    assert!(
        text.contains("no LSL stream with name=never") && text.contains("twice"),
        "{text}"
    );
}

/// A silent peer, and datagrams of another host than the one that is listened to.
#[test]
fn silence_and_strangers_are_told() {
    let port = free_port();
    let mut feed = open(&format!("udp:0.0.0.0:{port}?protocol=opentrack")).unwrap();
    let (_, said) = listen(&mut feed, 4, |_, said| said.len() > 1);
    assert!(
        said[1].contains("for 2 s: set the tracker to send to UDP port"),
        "{said:?}"
    );
    let own = UdpSocket::bind("127.0.0.1:0").unwrap();
    let head = [1.0_f64, 2.0, 3.0, 0.0, 0.0, 0.0].map(f64::to_le_bytes);
    let send = |socket: &UdpSocket| {
        socket
            .send_to(head.as_flattened(), ("127.0.0.1", port))
            .unwrap();
    };
    send(&own);
    let (samples, said) = listen(&mut feed, 4, |samples, _| !samples.is_empty());
    assert_eq!(samples.len(), 1);
    assert!(said[0].contains("sends again"), "{said:?}");
    let stranger = UdpSocket::bind("127.0.0.2:0").unwrap();
    send(&stranger);
    send(&own);
    let (samples, said) = listen(&mut feed, 4, |samples, _| !samples.is_empty());
    assert_eq!(samples.len(), 1);
    assert!(
        said[0].contains("datagrams of 127.0.0.2 are not taken"),
        "{said:?}"
    );
    // Millimetres taken for metres: 50 m.
    let far = [5_000.0_f64, 0.0, 0.0, 0.0, 0.0, 0.0].map(f64::to_le_bytes);
    own.send_to(far.as_flattened(), ("127.0.0.1", port))
        .unwrap();
    listen(&mut feed, 1, |_, _| false);
    assert_eq!(feed.counts().dropped.iter().sum::<u32>(), 1);
}

/// A server of `NatNet`, by what was written down of others.
#[test]
fn a_rigid_body_is_found_by_its_name() {
    let capture = include_bytes!("../../../../tracker-driver/src/net/captures/natnet-4.1-made.cap");
    let mut packets = Vec::new();
    let mut rest = &capture[..];
    while let Some((head, behind)) = rest.split_first_chunk::<12>() {
        let length = u32::from_le_bytes(*head.last_chunk().unwrap()) as usize;
        let (bytes, behind) = behind.split_at(length);
        packets.push((head[0] == b'<', bytes.to_vec()));
        rest = behind;
    }
    let server = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = server.local_addr().unwrap().port();
    let thread = std::thread::spawn(move || {
        let of = |kind: u8| {
            let mut all = packets.iter().filter(|(is_answer, _)| *is_answer);
            all.find(|(_, bytes)| bytes[0] == kind).unwrap().1.clone()
        };
        let mut info = of(1);
        // By unicast.
        let at = info.len() - 5;
        info[at] = 0;
        let send = |bytes: &[u8], to| assert_eq!(server.send_to(bytes, to).unwrap(), bytes.len());
        let mut buffer = [0; 2_048];
        let mut echoes = 0;
        while echoes < 20 {
            let (length, from) = server.recv_from(&mut buffer).unwrap();
            match buffer[0] {
                0 => send(&info, from),
                4 => send(&of(5), from),
                12 => {
                    echoes += 1;
                    let mut echo = buffer[..length].to_vec();
                    (echo[0], echo[2]) = (13, 16);
                    echo.extend_from_slice(&10_000_000_u64.to_le_bytes());
                    send(&echo, from);
                }
                _ => {
                    let frames = packets.iter().filter(|(_, bytes)| bytes[0] == 7);
                    frames.for_each(|(_, frame)| send(frame, from));
                }
            }
        }
    });
    let fault = open(&format!("natnet:127.0.0.1:{port}?body=Hat")).unwrap_err();
    assert!(
        with_help(&fault).contains("HeadTracker (1)"),
        "{}",
        with_help(&fault)
    );
    let mut feed = open(&format!("natnet:127.0.0.1:{port}?body=HeadTracker")).unwrap();
    let (samples, said) = listen(&mut feed, 8, |_, said| {
        said.iter().any(|one| one == "offset")
    });
    assert!(said.iter().any(|one| one == "offset"), "{said:?}");
    assert!(samples.len() > 5 && samples.iter().all(|sample| sample.sensor == 1));
    listen(&mut feed, 4, |_, _| thread.is_finished());
}
