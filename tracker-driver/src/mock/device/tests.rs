use super::*;
use crate::command::{Action, Script, Session};
use crate::decoder::{Decoder, Event, Message, Text};
use crate::eye::adhawk;
use crate::head::flock::Mode;
use crate::head::polhemus::Units;
use crate::head::{fastrak, flock, liberty};
use crate::mock::{Line, Source, Tracker, TrackerConfig};
use crate::protocol::{Asked, Reader};
use crate::testing::{tracker, tracker_at};

/// Plays a script against the device to the script's end.
fn play(device: &mut Device, script: Script) {
    let mut session = Session::new(script);
    let mut adhawk = adhawk::AdHawk::new();
    let mut now = Micros(0);
    for _ in 0..100 {
        let mut heard = std::vec::Vec::new();
        match session.poll(now) {
            Action::Send(bytes) => device.feed(bytes, now, &mut |bytes| heard.extend(bytes)),
            Action::Wait(until) if device.streams() && until > now => {
                session.on_event(&Event::Sample(Sample::arrived(now)));
                now = until;
            }
            Action::Wait(until) => now = until,
            Action::Done => return,
            other => panic!("{other:?}"),
        }
        adhawk.feed(&heard, now, &mut |event| session.on_event(&event));
    }
    panic!("the script does not end");
}

#[test]
fn every_device_starts_and_stops_by_its_own_script() {
    for name in Protocol::NAMES {
        let protocol = Protocol::named(name).unwrap();
        if protocol.stop() == Script::new() {
            continue;
        }
        let asked = Asked {
            rate: Some(240),
            ..Asked::default()
        };
        let mut device = Device::new(&protocol);
        assert!(device.streams(), "{name}");
        play(&mut device, protocol.stop());
        assert!(!device.streams(), "{name}");
        play(&mut device, protocol.start(&asked, true));
        assert!(device.streams(), "{name}");
        let rate = matches!(name, "link" | "adhawk").then_some(240);
        assert_eq!(device.rate(), rate, "{name}");
    }
}

/// A start script sets the device's records, whatever they were before.
#[test]
fn a_device_streams_as_it_is_told() {
    let list = |family, format, items: &[u8]| ItemList::new(family, format, items).unwrap();
    let mut fastrak = fastrak::Config::new(list(Family::Fastrak, Format::Ascii, &[2, 4, 1]));
    fastrak.units = Units::Centimetres;
    let mut device = Device::new(&Protocol::named("fastrak").unwrap());
    for config in [fastrak, fastrak::Config::default()] {
        play(&mut device, config.start(false));
        assert_eq!(device.protocol(), &Protocol::Fastrak(config));
    }
    let mut liberty = liberty::Config::new(list(Family::Liberty, Format::Binary, &[2, 7, 0]));
    liberty.units = Units::Centimetres;
    let mut device = Device::new(&Protocol::named("liberty").unwrap());
    play(&mut device, liberty.start(false));
    assert_eq!(device.protocol(), &Protocol::Liberty(liberty));
    for mode in Mode::ALL {
        let config = flock::Config {
            mode,
            group: true,
            ..flock::Config::default()
        };
        let mut device = Device::new(&Protocol::named("flock").unwrap());
        play(&mut device, config.start(2, 1, false));
        assert_eq!(device.protocol(), &Protocol::Flock(config));
    }
    // A bad list changes nothing.
    let mut device = Device::new(&Protocol::named("fastrak").unwrap());
    device.feed(b"O1,2,11\rO1,999,0\rO1\r", Micros(0), &mut |_| {});
    assert_eq!(Some(device.protocol().clone()), Protocol::named("fastrak"));
}

/// A device, the samples that it measures and the bytes that it sends.
struct Bench {
    end: Line<Tracker<'static>>,
    now: Micros,
    line: std::vec::Vec<u8>,
}

/// Time of one step: at 100 Hz each brings one sample.
const STEP: Micros = Micros::from_millis(10);

impl Bench {
    fn new(name: &str, settings: impl Fn(&mut Protocol)) -> Self {
        let mut protocol = Protocol::named(name).unwrap();
        settings(&mut protocol);
        let config = TrackerConfig {
            rate: 100,
            losses: 0.0,
            latency: Micros(0),
            ..TrackerConfig::default()
        };
        Self {
            end: Line::new(tracker(config, 5), &protocol),
            now: Micros(0),
            line: std::vec::Vec::new(),
        }
    }

    fn tell(&mut self, bytes: &[u8]) {
        let line = &mut self.line;
        self.end
            .hear(bytes, self.now, &mut |bytes| line.extend_from_slice(bytes));
    }

    fn run(&mut self, steps: u64) {
        for _ in 0..steps {
            while let Some(chunk) = self.end.poll(self.now) {
                self.line.extend_from_slice(chunk.bytes());
            }
            self.now = self.now.after(STEP);
        }
    }

    /// Decodes the bytes sent since the last call, by the device's present protocol.
    fn heard(&mut self) -> std::vec::Vec<Event> {
        let mut reader = Reader::new(self.end.device().protocol()).unwrap();
        let mut events = std::vec::Vec::new();
        let line = core::mem::take(&mut self.line);
        reader.feed(&line, self.now, &mut |event| events.push(event));
        events
    }

    fn samples(&mut self) -> usize {
        let events = self.heard();
        let is_dropped = |event: &Event| matches!(event, Event::Dropped(_));
        assert!(!events.iter().any(is_dropped), "{events:?}");
        let is_sample = |event: &&Event| matches!(event, Event::Sample(_));
        events.iter().filter(is_sample).count()
    }

    fn replies(&mut self) -> std::vec::Vec<(u32, u32)> {
        let of = |event: Event| match event {
            Event::Message(Message::Reply(reply)) => Some((reply.to, reply.result)),
            _ => None,
        };
        self.heard().into_iter().filter_map(of).collect()
    }
}

/// Each demand gets one record, also from a stopped device; it stops a Liberty and a Flock.
#[test]
fn a_record_is_sent_on_demand() {
    for (name, stop, demand, still_streams) in [
        ("fastrak", &b"c"[..], &b"P"[..], true),
        ("liberty", b"P", b"P", false),
        ("flock", b"B", b"B", false),
    ] {
        let mut bench = Bench::new(name, |_| {});
        bench.run(5);
        assert_eq!(bench.samples(), 5, "{name}");
        bench.tell(demand);
        bench.run(5);
        assert_eq!(bench.samples(), if still_streams { 5 } else { 1 }, "{name}");
        bench.tell(stop);
        bench.run(2);
        bench.line.clear();
        bench.run(5);
        assert_eq!(bench.samples(), 0, "{name}");
        for _ in 0..3 {
            bench.tell(demand);
            bench.run(5);
            assert_eq!(bench.samples(), 1, "{name}");
        }
    }
}

#[test]
fn a_fastrak_refuses_what_it_does_not_know() {
    let mut bench = Bench::new("fastrak", |_| {});
    bench.tell(b"c");
    let too_long = [&b"O1,"[..], &[b'2'; 300], b"\r"].concat();
    for (command, code) in [
        (&b"O1\r"[..], 1),
        (b"O1,2,x,0\r", 2),
        (b"O9,2,11,0\r", 3),
        (b"O1,2,11,999,0\r", 3),
        (b"O1,0,0,0,0,0,0,0,0,0,0,0,0,2,0\r", 5),
        (b"o37,N,8,0\r", 3),
        (b"x0.2,0.2\r", 1),
        (b"v0.2,a,0.8,0.8\r", 2),
        (b"H7,0,0,1\r", 3),
        (b"z", 99),
        // A line that is too long is refused once.
        (&too_long, 5),
    ] {
        bench.tell(command);
        let letter = command.first().filter(|letter| letter.is_ascii_graphic());
        let letter = u32::from(*letter.unwrap_or(&b'?'));
        assert_eq!(bench.replies(), [(letter, code)], "{command:?}");
        // Ends the line that was too long.
        bench.tell(b"\r");
        bench.line.clear();
    }
    let usual = Protocol::named("fastrak");
    assert_eq!(Some(bench.end.device().protocol()), usual.as_ref());
}

/// A rate that does not divide the tracker's is kept on average.
#[test]
fn a_device_sends_at_the_rate_that_it_was_told() {
    for (of, asked) in [(1_000_u32, 120), (500, 500), (240, 100)] {
        let mut device = Device::new(&Protocol::Link);
        device.rate = Some(asked);
        let sent = (0..10 * of).filter(|&i| {
            let time = Micros(u64::from(i) * 1_000_000 / u64::from(of));
            device.measure(&Sample::arrived(time)).is_some()
        });
        let sent = sent.count() as u32;
        assert!(sent.abs_diff(10 * asked) <= 1, "{asked} of {of}: {sent}");
    }
}

/// `^K` keeps the set-up over a reset; `W` is the factory's: inches, ASCII, items 2, 4, 1.
#[test]
fn a_fastrak_is_saved_and_forgets() {
    let mut bench = Bench::new("fastrak", |protocol| {
        let Protocol::Fastrak(config) = protocol else {
            panic!("it is one");
        };
        config.reset_time = Micros::from_millis(100);
    });
    bench.tell(b"cuO1,2,4,0\r\x0B");
    let saved = bench.end.device().protocol().clone();
    bench.tell(b"UO1,2,11,0\r\x19");
    bench.run(20);
    assert_eq!(bench.line, b"");
    assert!(!bench.end.device().streams());
    assert_eq!(bench.end.device().protocol(), &saved);
    bench.tell(b"WP");
    bench.run(2);
    assert_eq!(bench.line.len(), 47);
    assert_eq!(bench.samples(), 1);
    // As the manual has it: 55 bytes, six flags that are always set, and `F3`.
    bench.tell(b"S");
    assert_eq!(bench.line.len(), 55);
    assert!(bench.line.starts_with(b"21S3F0    F3"));
}

#[test]
fn a_liberty_zeroes_its_clock() {
    let mut bench = Bench::new("liberty", |_| {});
    bench.run(50);
    bench.line.clear();
    bench.tell(b"Q0\r");
    bench.run(3);
    let times = bench.heard().into_iter().map(|event| match event {
        Event::Sample(sample) => sample.device_time.unwrap().microseconds,
        other => panic!("{other:?}"),
    });
    assert!(times.eq([0, 10_000, 20_000]));
}

/// Bare bytes, which are no records: the decoder passes over them.
#[test]
fn a_flock_is_examined() {
    let mut bench = Bench::new("flock", |_| {});
    let units = |first| [&[first][..], &[0; 13]].concat();
    for (command, answer) in [
        // Master, initialised, running; position and quaternion, then angles; it streams.
        (&b"O\x00"[..], &0xD011_u16.to_le_bytes()[..]),
        (b"YO\x00", &0xD009_u16.to_le_bytes()),
        (b"O\x02", &[40, 0]),
        (b"O\x24", &units(0xE0)),
        (b"O\x0A", &[0]),
        (b"?O\x00", &0xF009_u16.to_le_bytes()),
        (b"O\x0A", &[6]),
        (b"?O\x10", &[6, 0]),
        // A hemisphere, a parameter, and the unit that the next command is for.
        (b"L\x06\x01P\x32\x01\xF1]O\x0A", &[0]),
        (b"GO\x00", &0xC030_u16.to_le_bytes()),
        (b"O\x24", &units(0xA0)),
    ] {
        bench.tell(command);
        assert_eq!(core::mem::take(&mut bench.line), answer, "{command:?}");
    }
    // Asleep it measures nothing.
    for (command, count) in [(&b"B"[..], 0), (b"FB", 1)] {
        bench.tell(command);
        bench.run(3);
        assert_eq!(bench.samples(), count);
    }
}

#[test]
fn a_hatire_says_what_it_is_and_where_its_front_is() {
    let mut bench = Bench::new("hatire", |_| {});
    bench.tell(b"V");
    let events = bench.heard();
    let says = |text: &Text| text.as_str() == "SHISEN MOCK 0";
    assert!(matches!(&events[..], [Event::Message(Message::Text(text))] if says(text)));
    let turn = |bench: &mut Bench| {
        bench.run(1);
        match bench.heard()[..] {
            [Event::Sample(sample)] => sample.head.orientation.unwrap().value,
            ref other => panic!("{other:?}"),
        }
    };
    bench.run(300);
    bench.line.clear();
    let off = |turn: Quat| crate::rotation::to_vector(turn).length();
    assert!(off(turn(&mut bench)) > 0.01);
    bench.tell(b"C");
    assert!(off(turn(&mut bench)) < 1e-6);
}

#[test]
fn an_adhawk_answers_each_request() {
    let mut bench = Bench::new("adhawk", |_| {});
    let ask = |bench: &mut Bench, kind: u8, arguments: &[u8]| {
        let payload = [&[7, 0, kind], arguments].concat();
        let packet = [&[0xAA, payload.len() as u8, 0], &payload[..]].concat();
        // Out of step the decoder believes no answer with data.
        bench.line = adhawk::encode_response(6, 0x90, 0, &[]).to_vec();
        let before = bench.line.len();
        bench.tell(&packet);
        let line = bench.line.split_off(before);
        bench.line.extend_from_slice(&line);
        let result = (u32::from(kind), u32::from(line[6]));
        assert_eq!(&line[3..6], [7, 0, kind]);
        assert_eq!(bench.replies(), [(0x90, 0), result]);
        line[6..].to_vec()
    };
    let [fast, slow] = [50_f32, 25.0].map(f32::to_le_bytes);
    for (kind, arguments, answer) in [
        (0x90, &[][..], &[0][..]),
        (0x9A, &[14], &[0, 255, 255, 255, 255]),
        (0x9B, &[&[13], &fast[..]].concat(), &[0]),
        (0x9A, &[13], &[&[0], &fast[..]].concat()),
        (0x9B, &[&[2, 2, 0, 0, 0], &slow[..]].concat(), &[0]),
        // Blinks.
        (0x9B, &[5, 1, 0, 0, 0, 1], &[0]),
        (0x9A, &[5], &[0, 1, 0, 0, 0]),
        (0x9C, &[1, 2], &[2]),
        (0x9A, &[], &[2]),
        (0x9B, &[13, 0, 0, 0xC0, 0x7F], &[2]),
        (0x9B, &[14, 0], &[2]),
        (0x9B, &[77, 0], &[8]),
        (0x80, &[], &[8]),
    ] {
        assert_eq!(ask(&mut bench, kind, arguments), answer, "{kind:x}");
    }
    assert_eq!(bench.end.device().rate(), Some(25));
    // Not the pupils.
    assert_eq!(ask(&mut bench, 0x9B, &[14, 32, 0, 0, 0, 0]), [0]);
    bench.run(100);
    let pupils = bench.heard().into_iter().filter_map(|event| match event {
        Event::Sample(sample) => Some(sample.left.pupil),
        _ => None,
    });
    let pupils: std::vec::Vec<_> = pupils.collect();
    assert!((25..=26).contains(&pupils.len()) && pupils.iter().all(Option::is_none));
}

#[test]
fn every_bird_of_a_group_sends() {
    let config = flock::Config {
        group: true,
        ..flock::Config::default()
    };
    for (birds, first, there, first_there) in [(1, 1, 1, 1), (2, 2, 2, 2), (200, 9, 14, 1)] {
        let device = Device::new(&Protocol::Flock(config)).with_birds(first, birds);
        let mut line = Line::of(tracker_at(100, 5), device);
        let mut decoder = flock::Flock::new(config);
        let mut samples = std::vec::Vec::new();
        while let Some(chunk) = line.poll(Micros::from_millis(1_000)) {
            decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
                Event::Sample(sample) => samples.push(sample),
                other => panic!("{other:?}"),
            });
        }
        assert_eq!(samples.len(), 100 * there);
        let place = |sample: &Sample| sample.head.position.unwrap().value.x;
        for group in samples.chunks(there) {
            for (n, sample) in (0..).zip(group) {
                assert_eq!(sample.sensor, first_there - 1 + n, "{birds} {first}");
                assert_eq!(sample.arrival, group[0].arrival);
                // Farther than 36 inches a bird's words do not reach.
                let expected = (place(&group[0]) + 0.1 * f32::from(n)).min(0.9144);
                assert!((place(sample) - expected).abs() < 1e-3, "{expected}");
            }
        }
    }
    let mut units: std::vec::Vec<u8> = std::vec::Vec::new();
    let mut device = Device::new(&Protocol::named("flock").unwrap()).with_birds(2, 3);
    device.feed(b"O\x24", Micros(0), &mut |answer| units.extend(answer));
    assert_eq!(units[..5], [0xC0, 0xE0, 0xE0, 0xE0, 0]);
}

/// Our own link reports all events, an `AdHawk` those that the host asked for.
#[test]
fn a_device_tells_what_the_eyes_do() {
    use crate::decoder::EyeEventKind::{self, Blink, Closed, Found, Lost, Opened};
    use crate::decoder::Side;
    let heard = |protocol: &Protocol, mask: u32| {
        let tracker = tracker(TrackerConfig::default(), 5);
        let mut line = Line::new(tracker, protocol);
        let enable = true;
        let ask = adhawk::Request::Events { mask, enable }.encode(1);
        line.hear(&ask, Micros(0), &mut |_| {});
        let mut reader = Reader::new(protocol).unwrap();
        let mut kinds = std::vec::Vec::new();
        while let Some(chunk) = line.poll(Micros::from_millis(30_000)) {
            reader.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
                Event::Message(Message::Eyes(event)) => kinds.push((event.kind, event.eye)),
                Event::Sample(_) | Event::Message(Message::Unmeasured(_)) => {}
                other => panic!("{other:?}"),
            });
        }
        kinds
    };
    let all = heard(&Protocol::AdHawk, u32::MAX);
    // Each eye closes before it opens, and is lost before it is found.
    for eye in [Side::Left, Side::Right] {
        for pair in [[Closed, Opened], [Lost, Found]] {
            let mut expected = pair.into_iter().cycle();
            let of_eye = all.iter().filter(|(_, of)| *of == Some(eye));
            let mut kinds = of_eye
                .map(|(kind, _)| *kind)
                .filter(|kind| pair.contains(kind));
            assert!(kinds.all(|kind| Some(kind) == expected.next()), "{all:?}");
        }
    }
    assert_eq!(heard(&Protocol::Link, 0), all);
    let of = |kinds: &[EyeEventKind]| {
        let mut some = all.clone();
        some.retain(|(kind, _)| kinds.contains(kind));
        some
    };
    // 15 a minute.
    assert!((3..20).contains(&of(&[Blink]).len()) && !of(&[Lost]).is_empty());
    for (mask, kinds) in [
        (0, &[][..]),
        (1, &[Blink]),
        (2, &[Closed, Opened]),
        (4, &[Lost, Found]),
    ] {
        assert_eq!(heard(&Protocol::AdHawk, mask), of(kinds), "{mask}");
    }
}
