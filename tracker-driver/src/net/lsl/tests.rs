use super::*;
use crate::decoder::{Event, Message};
use crate::net::capture::{packets, rows, stream};
use crate::testing::ARRIVAL;
use std::format;
use std::string::String as Text;
use std::vec::Vec as List;

/// Returns the bytes and the table of a capture.
macro_rules! capture {
    ($name:literal) => {
        (
            &include_bytes!(concat!("../captures/lsl-", $name, ".cap"))[..],
            include_str!(concat!("../captures/lsl-", $name, ".csv")),
        )
    };
}

/// A record: its time, whether that was deduced, and its values in words.
type Row = (f64, bool, List<Text>);

/// Feeds pieces of `size`; returns the records and all else.
fn read(feed: &mut Feed, stream: &[u8], size: usize) -> (List<Row>, List<Event>) {
    let (mut records, mut others) = (List::new(), List::new());
    for piece in stream.chunks(size) {
        feed.feed(piece, ARRIVAL, &mut |received| match received {
            Received::Record(record) => {
                assert!(record.time.is_finite() && record.arrival == ARRIVAL);
                let words = record.values().map(|value| match value {
                    Value::Number(number) => format!("{number:?}"),
                    Value::Integer(number) => format!("{number}"),
                    Value::Text(text) => Text::from_utf8_lossy(text).into(),
                });
                records.push((record.time, record.is_deduced, words.collect()));
            }
            Received::Event(event) => others.push(event),
        });
    }
    (records, others)
}

#[test]
fn real_streams_are_read() {
    use Format::{Double64, Float32, Int8, Int16, Int32, Int64};
    for ((bytes, table), (format, channels, rate)) in [
        (capture!("float32-be-110"), (Float32, 6, 200.0)),
        (capture!("double64-100"), (Double64, 7, 0.0)),
        (capture!("string-110"), (Format::Text, 1, 0.0)),
        (capture!("string-100"), (Format::Text, 1, 0.0)),
        (capture!("int8-100"), (Int8, 3, 100.0)),
        (capture!("int16-110"), (Int16, 3, 100.0)),
        (capture!("int32-100"), (Int32, 3, 100.0)),
        (capture!("int64-110"), (Int64, 3, 100.0)),
    ] {
        let stream = stream(bytes);
        let table = rows(table);
        for size in [usize::MAX, 1, 7, 64] {
            let mut feed = Feed::new(format, channels, rate);
            let (records, others) = read(&mut feed, &stream, size);
            assert_eq!((records.len(), others), (table.len(), [].into()));
            assert_eq!(feed.counts().samples, table.len() as u64);
            for (record, row) in records.iter().zip(&table) {
                let time: f64 = row[0].parse().unwrap();
                assert!((record.0 - time).abs() < 2e-9, "{record:?} {row:?}");
                assert_eq!(record.1, row[1] == "1", "{record:?} {row:?}");
                for (value, expected) in record.2.iter().zip(&row[2..]) {
                    let expected = expected.get(..MOST_TEXT).unwrap_or(expected);
                    let same = value.eq_ignore_ascii_case(expected);
                    let number = |text: &str| text.parse::<f64>().ok();
                    assert!(
                        same || number(value) == number(expected),
                        "{record:?} {row:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn refusals_and_other_protocols_are_told_apart() {
    let found: List<_> = (0..8)
        .map(|flow| {
            let of = |packet: &&_| {
                let packet: &crate::net::capture::Packet<'_> = packet;
                packet.flow == flow && packet.to_client
            };
            let packets = packets(capture!("odd-110").0);
            let answer = packets.iter().find(of).map(|packet| packet.bytes);
            let mut feed = Feed::new(Format::Float32, 6, 200.0);
            let (records, others) = read(&mut feed, answer.unwrap_or_default(), 7);
            let code = match others[..] {
                [Event::Message(Message::Fault { code, .. }), ..] => code,
                [] => 0,
                _ => panic!("{others:?}"),
            };
            assert_eq!(feed.is_lost(), code != 0);
            (records.len(), code)
        })
        .collect();
    let codes = [0, 404, 505, 0, 0, 0, 0, 0];
    let records = [0, 0, 0, 0, 0, 1, 0, 0];
    assert_eq!(found, records.into_iter().zip(codes).collect::<List<_>>());
}

#[test]
fn a_stream_with_a_fault_ends_or_goes_on_within_its_bounds() {
    for ((bytes, _), (format, channels, rate)) in [
        (capture!("float32-be-110"), (Format::Float32, 6, 200.0)),
        (capture!("string-100"), (Format::Text, 1, 0.0)),
        (capture!("int64-110"), (Format::Int64, 3, 100.0)),
    ] {
        let stream = stream(bytes);
        let good = read(&mut Feed::new(format, channels, rate), &stream, 64).0;
        let step = if cfg!(miri) { 37 } else { 1 };
        for at in (0..stream.len()).step_by(step) {
            let before = read(&mut Feed::new(format, channels, rate), &stream[..at], 64)
                .0
                .len();
            for fault in 0..4 {
                let mut bytes = stream.clone();
                match fault {
                    0 => drop(bytes.remove(at)),
                    1 => bytes.insert(at, bytes[at]),
                    2 => bytes[at] ^= 0x80,
                    _ => bytes[at] ^= 1 << (at % 7),
                }
                let mut feed = Feed::new(format, channels, rate);
                let (records, others) = read(&mut feed, &bytes, 64);
                let dropped: u64 = others
                    .iter()
                    .map(|event| match event {
                        Event::Dropped(dropped) => u64::from(dropped.bytes),
                        _ => 0,
                    })
                    .sum();
                assert_eq!(feed.counts().dropped_bytes, dropped);
                assert_eq!(feed.counts().bytes, bytes.len() as u64);
                assert_eq!(records[..before], good[..before], "{at} {fault}");
                assert!(!feed.is_lost() || !others.is_empty(), "{at} {fault}");
            }
        }
    }
}

#[test]
fn what_no_outlet_sends_ends_the_stream() {
    use DropReason::{Field, Length, Unknown};
    let ok = "LSL/110 200 OK\r\n";
    let text = |head: &str, bytes: &[u8]| [head.as_bytes(), bytes].concat();
    let archive = b"\x7F\x01\x09";
    for (stream, reason) in [
        (text("HTTP/1.1 200 OK\r\n", b""), Unknown),
        (text("LSL/110 2x0 OK\r\n", b""), Unknown),
        (text("LSL\r\n", b""), Unknown),
        (text(ok, "x".repeat(20_000).as_bytes()), Length),
        (text(ok, b"Byte-Order: 2134\r\n"), Field),
        (text(ok, b"data-protocol-version: 120\r\n"), Unknown),
        (text(ok, b"\r\n\x00"), Field),
        (text(ok, b"\r\n\xFF"), Field),
        (text(ok, &[b"\r\n\x02", &[0; 32][..]].concat()), Field),
        (b"\x7F\x01\x08".to_vec(), Unknown),
        (b"\x7F\x09\x09".to_vec(), Field),
        (
            text("", &[&archive[..], b"\x04\xFF\xFF\xFF\x7F"].concat()),
            Length,
        ),
        (
            text("", &[&archive[..], b"\x01\x01x\x01\x01"].concat()),
            Field,
        ),
    ] {
        let mut feed = Feed::new(Format::Float32, 6, 200.0);
        let (records, others) = read(&mut feed, &stream, usize::MAX);
        let first = others.first();
        assert!(
            matches!(first, Some(Event::Dropped(dropped)) if dropped.reason == reason),
            "{} {others:?}",
            stream.escape_ascii()
        );
        assert!(records.is_empty() && feed.is_lost());
    }
    // A text of 2⁶³ bytes, and a time that is none: only that record is lost.
    let (bytes, _) = capture!("string-110");
    let mut stream = stream(bytes);
    let mut feed = Feed::new(Format::Text, 1, 0.0);
    stream.extend(b"\x02\0\0\0\0\0\0\xF8\x7F\x01\x02no");
    stream.extend(b"\x01\x01\x03yes");
    stream.extend(b"\x02\0\0\0\0\0\0\xF0\x3F\x01\x03yes");
    stream.extend(b"\x02\0\0\0\0\0\0\xF0\x3F\x08\0\0\0\0\0\0\0\x80");
    let (records, others) = read(&mut feed, &stream, 7);
    let reasons = others.iter().filter_map(|event| match event {
        Event::Dropped(dropped) => Some(dropped.reason),
        _ => None,
    });
    assert_eq!((records.len(), &records[3].2[0][..]), (4, "yes"));
    let expected = [DropReason::OutOfRange, DropReason::OutOfRange, Length];
    assert_eq!(reasons.collect::<List<_>>(), expected);
    feed.reset();
    assert!(!feed.is_lost());
}

#[test]
fn outlets_are_found_and_their_clocks_asked() {
    let (bytes, _) = capture!("discovery");
    let packets = packets(bytes);
    let (mut sent, mut wave) = (List::new(), 0);
    for packet in &packets {
        let text = str::from_utf8(packet.bytes).unwrap();
        match (packet.flow, packet.to_client) {
            (10, false) => sent.push(text),
            (10, true) => {
                let words: List<f64> = text
                    .split_whitespace()
                    .map(|w| w.parse().unwrap())
                    .collect();
                let [number, t0, t1, t2] = words[..] else {
                    panic!("{text}");
                };
                // The answer comes 40 µs after it was sent.
                let t3 = t2 + 40e-6;
                let echo = read_echo(packet.bytes, Micros((t3 * 1e6) as u64)).unwrap();
                let offset = f64::midpoint(t1 - t0, t2 - t3) * 1e6;
                assert!((echo.offset as f64 - offset).abs() < 2.0, "{echo:?}");
                let trip = ((t3 - t0) - (t2 - t1)) * 1e6;
                assert!((echo.round_trip.0 as f64 - trip).abs() < 3.0, "{echo:?}");
                assert_eq!(f64::from(echo.wave), number);
                wave = echo.wave;
            }
            (20, true) => {
                let labels: List<_> = labels(text).collect();
                let expected = ["gaze_x", "gaze_y", "diam_l", "diam_r", "conf", "blink"];
                assert_eq!(labels, expected);
                assert_eq!(read_info(text).unwrap().channels, 6);
            }
            (_, true) => {
                // The query's number is another program's, of 64 bits.
                let (_, xml) = text.split_once('\n').unwrap();
                let reply = format!("17\r\n{xml}");
                let (id, info) = read_reply(reply.as_bytes()).unwrap();
                assert_eq!((id, info.format, info.rate), (17, Format::Float32, 200.0));
                assert_eq!((&*info.name, &*info.kind), ("gaze", "Gaze"));
                assert_eq!(info.uid, "83c0c80a-7086-4b50-bf10-df57bbfadac0");
                assert_eq!((info.data_port, info.service_port), (16_572, 16_572));
                for cut in 0..reply.len() - "</info>\n".len() {
                    assert!(read_reply(&reply.as_bytes()[..cut]).is_err());
                }
                for (from, to, reason) in [
                    (">6<", ">0<", DropReason::Field),
                    (">6<", ">1000000000<", DropReason::Field),
                    (">gaze<", "><", DropReason::Field),
                    (">float32<", ">float16<", DropReason::Unknown),
                    (">16572<", ">0<", DropReason::Field),
                    (">16572<", ">65536<", DropReason::Field),
                    (">200.0", ">inf", DropReason::Field),
                    (">200.0", ">-1", DropReason::Field),
                    (">Gaze<", &format!(">{:65}<", "x"), DropReason::Length),
                    ("<desc />", &"<a>".repeat(2_000), DropReason::Length),
                ] {
                    let other = reply.replace(from, to);
                    assert_eq!(read_reply(other.as_bytes()), Err(reason), "{to}");
                }
                let other = reply.replace(">gaze<", ">a &lt;b&gt; &amp;amp; c<");
                assert_eq!(
                    read_reply(other.as_bytes()).unwrap().1.name,
                    "a <b> &amp; c"
                );
            }
            _ => {}
        }
    }
    let first = time_request(wave, Micros(4_140_349_350)).unwrap();
    let (expected, _) = sent[0].rsplit_once('.').unwrap();
    assert_eq!(first.rsplit_once('.').unwrap(), (expected, "349350\r\n"));
    let asked = query("session_id='default' and name='gaze'", 16_575, 9).unwrap();
    let expected = str::from_utf8(packets[0].bytes).unwrap();
    assert_eq!(
        asked,
        expected.replace("14894834137191266255", "9").as_str()
    );
    assert!(query(&"x".repeat(300), 1, 1).is_none());
    for wrong in ["", "1 2 3", "1 nan 3 4", "1 -2 3 4", "1 9 3 4", "1 1 4 3"] {
        assert!(
            read_echo(wrong.as_bytes(), Micros(5_000_000)).is_err(),
            "{wrong}"
        );
    }
}
