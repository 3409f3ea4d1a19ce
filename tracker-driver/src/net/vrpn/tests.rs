use super::*;
use crate::net::capture::{
    Packet, assert_counted, in_pieces, numbers, packets, rows, stream as received,
};
use crate::testing::{ARRIVAL, assert_usable, dropped, events, moving_head, thrown};
use std::format;
use std::string::String as Owned;
use std::vec::Vec as List;

const FROM_DTRACK: &[u8] = include_bytes!("../captures/vrpn-from-dtrack.cap");
const OVER_UDP: &[u8] = include_bytes!("../captures/vrpn-null-udp.cap");

fn decoder(device: &str) -> Vrpn {
    Vrpn::new(Config::new(device).unwrap())
}

/// A value that a device sent: its type, time, number and numbers.
type Value = (Owned, u64, u8, List<f64>);

/// Returns what a table says that the server sent of a device.
fn expected(table: &str, device: &str) -> List<Value> {
    let mut values = List::new();
    for row in rows(table) {
        let &["<", _, _, time, kind, sender, sensor, ref rest @ ..] = &row[..] else {
            continue;
        };
        let time = time.replace('.', "").parse().unwrap();
        let value = |number, values| (kind.into(), time, number, values);
        match kind {
            _ if sender != device => {}
            POSE | BUTTON => values.push(value(sensor.parse().unwrap(), numbers(rest[0]))),
            ANALOG => {
                let channels = numbers(rest[0]).into_iter().zip(0..);
                values.extend(channels.map(|(channel, number)| value(number, [channel].into())));
            }
            _ => {}
        }
    }
    values
}

fn found(events: &[Event]) -> List<Value> {
    let value = |event: &Event| match event {
        Event::Sample(Sample {
            device_time,
            sensor,
            head,
            ..
        }) => {
            let place = head.position.unwrap().value.to_array();
            let turn = head.orientation.unwrap().value.to_array();
            let numbers = place.into_iter().chain(turn).map(f64::from).collect();
            (
                POSE.into(),
                device_time.unwrap().microseconds,
                *sensor,
                numbers,
            )
        }
        Event::Message(Message::Control(control)) => {
            let (kind, number) = match control.state {
                ControlState::Button(state) => (BUTTON, f64::from(u8::from(state))),
                ControlState::Axis(value) => (ANALOG, f64::from(value)),
            };
            let time = control.device_time.unwrap().microseconds;
            (kind.into(), time, control.number, [number].into())
        }
        other => panic!("{other:?}"),
    };
    events.iter().map(value).collect()
}

fn assert_same(found: &[Value], expected: &[Value]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        let near = a.3.iter().zip(&b.3).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(
            near && (&a.0, a.1, a.2, a.3.len()) == (&b.0, b.1, b.2, b.3.len()),
            "{a:?} {b:?}"
        );
    }
}

/// Returns the messages of a stream behind its cookie, with their padding.
fn messages(stream: &[u8]) -> List<List<u8>> {
    let (mut rest, mut messages) = (&stream[COOKIE.len()..], List::new());
    while !rest.is_empty() {
        let (_, padded) = Header::read(rest).unwrap().body();
        messages.push(rest[..HEADER_BYTES + padded].to_vec());
        rest = &rest[HEADER_BYTES + padded..];
    }
    messages
}

#[test]
fn a_real_servers_stream_is_read() {
    let stream = received(FROM_DTRACK);
    let seen = in_pieces(|| decoder("DTrack"), &stream);
    let expected = expected(include_str!("../captures/vrpn-from-dtrack.csv"), "DTrack");
    assert_eq!(expected.iter().filter(|value| value.0 == POSE).count(), 60);
    assert_same(&found(&seen), &expected);

    // Ids are the peer's, and may change.
    let mut again = stream.clone();
    for mut message in messages(&stream) {
        for at in [12, 16] {
            let id = i32::from_be_bytes(*message[at..].first_chunk().unwrap());
            let other = if id < 0 { id } else { 40 - id };
            message[at..at + 4].copy_from_slice(&other.to_be_bytes());
        }
        again.extend(message);
    }
    let mut both = decoder("DTrack");
    assert_eq!(events(&mut both, &again), [&seen[..], &seen].concat());
    let senders: List<&str> = both.senders().collect();
    assert!(
        senders.contains(&"DTrack") && both.is_greeted() && both.has_device(),
        "{senders:?}"
    );
    // A device that is not there says nothing.
    let mut other = decoder("dtrack");
    assert_eq!(
        (events(&mut other, &stream), other.has_device()),
        ([].into(), false)
    );
}

#[test]
fn poses_come_by_udp_as_well() {
    let mut vrpn = decoder("Tracker0");
    let mut seen = events(&mut vrpn, &received(OVER_UDP));
    let datagrams: List<Packet<'_>> = packets(OVER_UDP);
    for packet in datagrams.iter().filter(|packet| packet.flow == 2) {
        vrpn.datagram(packet.bytes, ARRIVAL, &mut |event| seen.push(event));
    }
    let table = include_str!("../captures/vrpn-null-udp.csv");
    assert_same(&found(&seen), &expected(table, "Tracker0"));
    assert_eq!((vrpn.counts().samples, vrpn.counts().lost), (38, 0));
    // One that is missing, one that is cut.
    let last = datagrams.last().unwrap().bytes;
    vrpn.datagram(&last[..last.len() - 1], ARRIVAL, &mut |_| {});
    assert_eq!(vrpn.counts().dropped_for(DropReason::Length), 1);
}

#[test]
fn a_client_is_read_as_well() {
    let sent = packets(FROM_DTRACK)
        .into_iter()
        .filter(|packet| !packet.to_client);
    let mut vrpn = decoder("DTrack");
    for packet in sent {
        assert_eq!(events(&mut vrpn, packet.bytes), []);
    }
    assert_eq!((vrpn.take_pings(), vrpn.take_pings()), (5, 0));
}

/// Returns a server's descriptions, with its cookie, and poses.
fn server() -> (List<u8>, List<List<u8>>) {
    let mut encoder = Encoder::new();
    let mut start = COOKIE.to_vec();
    start.extend(encoder.sender(ARRIVAL, 3, "Head"));
    for (kind, id) in TYPES.iter().zip(10..) {
        start.extend(encoder.kind(ARRIVAL, id, kind));
    }
    let poses = moving_head(6).into_iter();
    let pose = |sample| encoder.pose(ARRIVAL, [3, 10], &sample).to_vec();
    (start, poses.map(pose).collect())
}

#[test]
fn every_fault_costs_one_pose_or_ends_the_stream() {
    let (start, poses) = server();
    let stream = [&start[..], &poses.concat()].concat();
    let good = events(&mut decoder("Head"), &stream);
    let sent = moving_head(6);
    assert_eq!(good.len(), sent.len());
    for (event, sent) in good.iter().zip(sent) {
        let Event::Sample(sample) = event else {
            panic!("{event:?}");
        };
        assert_eq!(sample.device_time, Some(DeviceTime::unwrapped(ARRIVAL.0)));
        assert_eq!(sample.head.position, sent.head.position);
        let turn = sent.head.orientation.unwrap().value;
        assert!((sample.head.orientation.unwrap().value - turn).length() < 1e-6);
    }
    let step = if cfg!(miri) { 29 } else { 1 };
    for at in (0..stream.len()).step_by(step) {
        for fault in 0..5 {
            let mut bytes = stream.clone();
            match fault {
                0 => bytes.truncate(at),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, bytes[at]),
                3 => bytes[at] ^= 0x80,
                _ => bytes[at] ^= 1 << (at % 7),
            }
            let mut vrpn = decoder("Head");
            let seen = events(&mut vrpn, &bytes);
            assert_counted(&vrpn, bytes.len(), &seen);
            for event in &seen {
                if let Event::Sample(sample) = event {
                    assert_usable(sample);
                }
            }
            let Some(body) = at.checked_sub(start.len()) else {
                continue;
            };
            let (pose, place) = (body / poses[0].len(), body % poses[0].len());
            assert_eq!(seen[..pose], good[..pose], "{at} {fault}");
            if fault > 2 && place >= 4 {
                let behind = good.len() - pose - 1;
                let seen = &seen[seen.len() - behind..];
                assert_eq!(seen, &good[pose + 1..], "{at} {fault}");
            }
        }
    }
}

#[test]
fn what_is_wrong_is_dropped_with_its_reason() {
    let (start, poses) = server();
    let mut encoder = Encoder::new();
    let mut message = |kind, body: &[u8]| encoder.message(ARRIVAL, [3, kind], body).to_vec();
    let doubles = |numbers: &[f64]| numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
    let pose = |numbers: &[f64]| -> List<u8> { [[0; 8].into(), doubles(numbers)].concat() };
    let far: List<u8> = pose(&[1_700.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let nan = pose(&[0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let zero = pose(&[0.0; 7]);
    let endless: List<u8> = doubles(&[1e300, 1.0]);
    let name = |length: u32, name: &[u8]| [&length.to_be_bytes(), name].concat();
    for (message, reason) in [
        (message(10, &far), DropReason::OutOfRange),
        (message(10, &nan), DropReason::OutOfRange),
        (message(10, &zero), DropReason::NotUnit),
        (message(10, &zero[..60]), DropReason::Length),
        (message(10, &[127; 64]), DropReason::Field),
        (message(11, &[0, 0, 1, 0, 0, 0, 0, 1]), DropReason::Field),
        (message(11, &[0, 0, 0, 0, 0, 0, 0, 2]), DropReason::Field),
        (message(12, &[255; 4]), DropReason::Field),
        (message(12, &[0, 0, 0, 1]), DropReason::Field),
        (message(13, &endless), DropReason::Field),
        (message(13, &[]), DropReason::Length),
        (message(SENDER, &name(900, b"Head\0")), DropReason::Length),
        (message(TYPE, &name(97, &[b'x'; 97])), DropReason::Length),
        (
            message(TYPE, &name(4, b"\xFF\xFE\xFD\0")),
            DropReason::Field,
        ),
    ] {
        let stream = [&start[..], &message, &poses[0]].concat();
        let seen = events(&mut decoder("Head"), &stream);
        let length = Header::read(&message).unwrap().length as u32;
        assert_eq!(seen[..seen.len() - 1], [thrown(length, reason)]);
        assert!(matches!(seen.last(), Some(Event::Sample(_))), "{seen:?}");
    }
    // A long one is skipped.
    let mut long = message(77, &[]);
    long[..4].copy_from_slice(&50_001_u32.to_be_bytes());
    long.resize(50_008, 7);
    let stream = [&start[..], &long, &poses[0]].concat();
    assert_eq!(events(&mut decoder("Head"), &stream).len(), 1);
    // Nothing is found again behind a wrong length, nor behind another version's cookie.
    for length in [23_u32, 64_001] {
        let stream = [&start[..], &length.to_be_bytes(), &poses.concat()].concat();
        let mut vrpn = decoder("Head");
        let reasons = [DropReason::Length, DropReason::OutOfStep];
        assert_eq!(dropped(&mut vrpn, &stream), reasons, "{length}");
        assert!(vrpn.is_lost());
        vrpn.reset();
        assert_eq!(
            events(&mut vrpn, &[start.clone(), poses[1].clone()].concat()).len(),
            1
        );
    }
    let mut vrpn = decoder("Head");
    let other = dropped(&mut vrpn, b"vrpn: ver. 08.00  0\0\0\0\0\0");
    assert!(vrpn.is_lost() && other == [DropReason::Unknown]);
    assert!(Config::new(&format!("{:96}", "")).is_none());
}
