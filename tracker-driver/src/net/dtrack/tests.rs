use super::*;
use crate::net::capture::{assert_counted, faults, numbers, packets, rows};
use crate::testing::{dropped, events, samples, thrown};
use std::collections::BTreeMap;
use std::format;
use std::string::String;
use std::vec::Vec as List;

const CAPTURE: &[u8] = include_bytes!("../captures/dtrack.cap");

/// Returns how far numbers are from those of a table.
fn off(found: &[f32], expected: &[&str]) -> f32 {
    let numbers = expected.iter().map(|number| number.parse::<f32>().unwrap());
    let off = found.iter().zip(numbers).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f32::max)
}

/// Positions, angles and matrices as a manual has them.
#[test]
fn frames_are_written_as_they_are_read() {
    let frame = "fr 5\r\nts 10.250000\r\n6dcal 2\r\n\
                 6d 2 [0 1.000][261.103 116.520 41.085 19.6522 -57.3530 116.5992]\
                 [-0.241543 0.968868 -0.054332 -0.482366 -0.168461 -0.859619 -0.842010 \
                 -0.181427 0.508039] [3 1.000][-1.000 2.000 3.000 0.0000 0.0000 0.0000]\
                 [1.000000 0.000000 0.000000 -0.000000 1.000000 0.000000 0.000000 -0.000000 \
                 1.000000]\r\n";
    let seen = samples(&mut DTrack::default(), frame.as_bytes());
    let bodies: List<Body> = seen
        .iter()
        .map(|sample| {
            let (place, turn) = (sample.head.position, sample.head.orientation);
            (sample.sensor, place.unwrap().value, turn.unwrap().value)
        })
        .collect();
    let mut text = String::new();
    encode(&mut text, 5, Micros(DAY + 10_250_000), &bodies).unwrap();
    let numbers = |text: &str| -> List<f64> {
        let words = text.split(|c: char| !(c.is_ascii_digit() || "-.".contains(c)));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    let (found, expected) = (numbers(&text), numbers(frame));
    assert_eq!(found.len(), expected.len(), "{text}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1.1e-3, "{text}");
    }
}

#[test]
fn frames_are_those_that_were_sent() {
    let mut decoder = DTrack::default();
    let table = rows(include_str!("../captures/dtrack.csv"));
    let mut controls = BTreeMap::new();
    let mut seen: List<Sample> = List::new();
    let mut all = (0, List::new());
    for packet in packets(CAPTURE) {
        let found = events(&mut decoder, packet.bytes);
        all.0 += packet.bytes.len();
        all.1.extend(found.clone());
        let frame = samples(&mut DTrack::default(), packet.bytes)[0].sequence;
        for event in found {
            match event {
                Event::Sample(sample) => seen.push(sample),
                Event::Message(Message::Control(control)) => {
                    let is_axis = matches!(control.state, ControlState::Axis(_));
                    assert_eq!(control.sensor, FIRST_FLYSTICK);
                    controls.insert((is_axis, control.number), control.state);
                }
                other => panic!("{other:?}"),
            }
        }
        // What has not changed is what it was.
        let of = |row: &&List<&str>| row[0].parse().ok() == frame && row[3] == "flystick";
        let row = table.iter().find(of).unwrap();
        for (number, bit) in (0..).zip(row[13].chars()) {
            let button = ControlState::Button(bit == '1');
            assert_eq!(controls[&(false, number)], button, "{row:?}");
        }
        for (number, value) in (0..).zip(numbers(row[14])) {
            let axis = ControlState::Axis(value as f32);
            assert_eq!(controls[&(true, number)], axis, "{row:?}");
        }
    }
    assert_counted(&decoder, all.0, &all.1);
    let mut tracked = [0; 33];
    for row in table.iter().filter(|row| row[3] != "marker") {
        let id: u8 = row[4].parse().unwrap();
        let sensor = id + if row[3] == "body" { 0 } else { FIRST_FLYSTICK };
        let frame = row[0].parse().ok();
        let of = |sample: &&Sample| sample.sequence == frame && sample.sensor == sensor;
        let sample = seen.iter().find(of).unwrap();
        let (key, stamp) = row[1].split_once(' ').unwrap();
        let time = sample.device_time.unwrap();
        assert_eq!(time.microseconds, stamp.replace('.', "").parse().unwrap());
        assert_eq!(time.wraps_at, if key == "ts" { DAY } else { 0 });
        assert_eq!(sample.head.position.is_some(), row[5] == "1", "{row:?}");
        if let (Some(place), Some(turn)) = (sample.head.position, sample.head.orientation) {
            tracked[usize::from(sensor)] += 1;
            let (place, turn) = (place.value * 1e3, turn.value);
            assert!(off(&place.to_array(), &row[6..9]) < 1e-3, "{row:?}");
            let offs = [turn, -turn].map(|turn| off(&turn.to_array(), &row[9..13]));
            assert!(offs[0].min(offs[1]) < 5e-6, "{row:?}");
        }
    }
    assert_eq!((tracked[0], tracked[1], tracked[32]), (26, 13, 21));
    assert_eq!(decoder.latency(), Some(Micros(12_000)));
}

/// A body of the manual's, and its Flystick.
const BODY: &str = "[0 1.000][326.848 -187.216 109.503 -160.4704 -3.6963 -7.0913]\
    [-0.940508 -0.339238 -0.019025 0.333599 -0.932599 0.137735 -0.064467 0.123194 0.990286]";
const STICK: &str = "[0 1.000 34][261.103 116.520 41.085 19.6522 -57.3530 116.5992]\
    [-0.241543 0.968868 -0.054332 -0.482366 -0.168461 -0.859619 -0.842010 -0.181427 0.508039]";

#[test]
fn the_older_flystick_has_a_hat() {
    let text = format!("fr 7\n6df 1 {STICK}\r\n6d 1 {BODY}\r6d 1 {BODY}");
    let found = events(&mut DTrack::default(), text.as_bytes());
    let control = |event: &Event| match event {
        Event::Message(Message::Control(control)) => Some((control.number, control.state)),
        _ => None,
    };
    let controls: List<_> = found.iter().filter_map(control).collect();
    let button = |number| (number, ControlState::Button(number == 1));
    let axes = [(0, ControlState::Axis(1.0)), (1, ControlState::Axis(0.0))];
    assert_eq!(controls[..4], [0, 1, 2, 3].map(button));
    assert_eq!((found.len(), &controls[4..]), (8, &axes[..]));
}

#[test]
fn what_is_wrong_is_dropped_whole() {
    use DropReason::{Field, Length, NotUnit, OutOfRange, Unknown};
    let with = |from: &str, to: &str| format!("fr 7\n6d 1 {}", BODY.replace(from, to));
    let nested = format!("fr 7\n6d 1 {}", "[".repeat(8_000));
    let zero = format!("fr 7\n6d 1 [0 1.0][0 0 0]{}", "[0 0 0 0 0 0 0 0 0]");
    for (text, reason) in [
        (String::from("ts 1.0\nfr 7"), Unknown),
        (String::from("fr -1"), Field),
        (String::from("fr 7\nts 86400.0"), Field),
        (String::from("fr 7\nts nan"), Field),
        (String::from("fr 7\nts2 1 2"), Field),
        (String::from("fr 7\n6d 2147483647"), Field),
        (format!("fr 7\n6d 2 {BODY}"), Length),
        (nested, Length),
        (zero, NotUnit),
        (with("[0 1.000]", "[32 1.000]"), Field),
        (with("[0 1.000]", "[-1 1.000]"), Field),
        (with("[0 1.000]", "[0]"), Length),
        (with("326.848", "nan"), OutOfRange),
        (with("326.848", "1e999"), OutOfRange),
        (with("326.848", "326848000"), OutOfRange),
        (with("326.848", "326.\0"), Field),
        (with("0.990286", "-0.990286"), NotUnit),
        (with(" 0.990286]", "]"), Length),
        (
            String::from("fr 7\n6df2 1 1 [0 1 17 2][0 0 0][1 0 0 0 1 0 0 0 1][1 0 0]"),
            Field,
        ),
        (
            String::from("fr 7\n6df2 1 1 [0 1 4 2][0 0 0][1 0 0 0 1 0 0 0 1][1 0]"),
            Length,
        ),
        (format!("fr 7{}", "\n".repeat(LONGEST_DATAGRAM)), Length),
    ] {
        let found = events(&mut DTrack::default(), text.as_bytes());
        assert_eq!(found, [thrown(text.len() as u32, reason)], "{text:.200}");
    }
    let mut decoder = DTrack::default();
    let reasons = [7, 7, 9, 8].map(|n| dropped(&mut decoder, format!("fr {n}").as_bytes()));
    assert_eq!(reasons.concat(), [DropReason::Duplicate]);
    assert_eq!(decoder.counts().lost, 1);
}

#[test]
fn every_fault_costs_its_datagram() {
    let packets = packets(CAPTURE);
    let datagrams = [4, 5, 6].map(|n: usize| packets[n].bytes);
    faults(DTrack::default, &datagrams);
}
