//! What the fuzz targets do with their bytes: nothing may panic, and what comes
//! out has to be usable.

pub(crate) mod line;
pub(crate) mod scenes;

use embedded_hal::i2c::{self, I2c, Operation};
use line::{Line, assert_usable, decoder, records};
use shisen::bake::Baked;
use shisen::record::Reader;
use shisen::scene::Scene;
use shisen::scene::mesh::TriangleMesh;
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::head::fastrak::{self, Fastrak};
use shisen_tracker::head::liberty::{self, Liberty};
use shisen_tracker::head::polhemus::{Family, Format, ItemList};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, Mode, documented};
use shisen_tracker::i2c::{I2cHid, Interrupt};
use shisen_tracker::mock::Device;
use shisen_tracker::net::dtrack::DTrack;
use shisen_tracker::net::lsl::{self, Feed, Received};
use shisen_tracker::net::natnet::NatNet;
use shisen_tracker::net::vrpn::{self, Vrpn};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::path::Path;

/// Runs the fuzz target of this name on bytes; a protocol's target has its name.
///
/// # Panics
///
/// Where what is fuzzed is wrong, and where no target is so named.
pub fn run(target: &str, bytes: &[u8]) {
    match target {
        "descriptor" => descriptor(bytes),
        "device" => device(bytes),
        "i2c" => i2c(bytes),
        "items" => items(bytes),
        "scene-blob" => drop(scenes::blob(bytes)),
        "scene-file" => scene_file(bytes),
        "record" => record(bytes),
        "dtrack" | "lsl" | "natnet" | "vrpn" => captured(target, bytes),
        protocol => stream(protocol, bytes),
    }
}

/// Returns the names of all targets.
pub fn targets() -> impl Iterator<Item = &'static str> {
    let others = [
        "descriptor",
        "device",
        "dtrack",
        "i2c",
        "items",
        "lsl",
        "natnet",
        "record",
        "scene-blob",
        "scene-file",
        "vrpn",
    ];
    Protocol::NAMES.into_iter().chain(others)
}

/// Records of each protocol, to start from.
pub fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let mut seeds: Vec<_> = Protocol::NAMES
        .iter()
        .map(|name| (*name, records(name, 1, 12).concat()))
        .collect();
    for (_, bytes) in &mut seeds {
        // In pieces of 97 bytes: see `stream`.
        bytes.insert(0, 96);
    }
    seeds.push(("descriptor", documented::DESCRIPTOR.to_vec()));
    seeds.push(("i2c", on_a_bus()));
    for (name, capture) in CAPTURES {
        seeds.push((name, capture.to_vec()));
    }
    seeds.push(("record", RECORD.to_vec()));
    seeds.push(("scene-file", SCENE.into()));
    seeds.push(("scene-blob", baked_scene()));
    seeds
}

/// Three frames of a session, one of which its budget cut off.
const RECORD: &[u8] = include_bytes!("record");

/// Reads a record; its entries are those of its bytes, once.
fn record(bytes: &[u8]) {
    let Ok(mut reader) = Reader::new(Path::new("record"), bytes) else {
        return;
    };
    let mut entries = 0;
    while let Some(entry) = reader.entry() {
        entries += 1;
        assert!(entries <= bytes.len(), "{entry:?}");
    }
}

/// What peers on the network sent.
const CAPTURES: [(&str, &[u8]); 4] = [
    (
        "dtrack",
        include_bytes!("../../../tracker-driver/src/net/captures/dtrack.cap"),
    ),
    (
        "lsl",
        include_bytes!("../../../tracker-driver/src/net/captures/lsl-float32-be-110.cap"),
    ),
    (
        "natnet",
        include_bytes!("../../../tracker-driver/src/net/captures/natnet-4.1-made.cap"),
    ),
    (
        "vrpn",
        include_bytes!("../../../tracker-driver/src/net/captures/vrpn-from-dtrack.cap"),
    ),
];

/// Feeds the packets of a capture to the decoder of this name: u8 `<` for those that its client
/// received, u8 `U` for datagrams, 6 bytes, u32 length.
fn captured(name: &str, mut bytes: &[u8]) {
    let vrpn_config = vrpn::Config::new("DTrack").expect("a short name");
    let mut vrpn = Vrpn::new(vrpn_config);
    let (mut dtrack, mut natnet) = (DTrack::default(), NatNet::default());
    let mut lsl = Feed::new(lsl::Format::Float32, 6, 200.0);
    let now = Micros(1);
    let mut take = |event| {
        if let Event::Sample(sample) = event {
            assert_usable(name, &sample);
        }
    };
    while let Some((head, rest)) = bytes.split_first_chunk::<12>() {
        let length = u32::from_le_bytes([head[8], head[9], head[10], head[11]]) as usize;
        let (packet, rest) = rest.split_at(length.min(rest.len()));
        match name {
            _ if head[0] != b'<' => {}
            "vrpn" if head[1] == b'U' => vrpn.datagram(packet, now, &mut take),
            "vrpn" => vrpn.feed(packet, now, &mut take),
            "lsl" => lsl.feed(packet, now, &mut |received| {
                if let Received::Record(record) = received {
                    assert!(record.time.is_finite() && record.values().count() == 6);
                }
            }),
            "dtrack" => dtrack.feed(packet, now, &mut take),
            _ => natnet.feed(packet, now, &mut take),
        }
        bytes = rest;
    }
    for counts in [
        vrpn.counts(),
        lsl.counts(),
        dtrack.counts(),
        natnet.counts(),
    ] {
        assert!(counts.dropped_bytes <= counts.bytes, "{name}: {counts:?}");
    }
    if let Ok(text) = str::from_utf8(bytes) {
        let _ = lsl::read_info(text);
    }
}

/// A little of everything that a scene file can say.
const SCENE: &str = include_str!("scene.toml");

fn baked_scene() -> Vec<u8> {
    let square = |_: &_| Ok::<_, std::io::Error>(TriangleMesh::square());
    let scene = Scene::from_toml(SCENE, "scene.toml", Path::new(""), square);
    let baked = Baked::<8>::new(&scene.expect("a scene")).expect("a scene that can be baked");
    baked.as_bytes().to_vec()
}

/// Returns a device's HID descriptor, its report descriptor, that it has reset itself, and
/// a report.
fn on_a_bus() -> Vec<u8> {
    let report = records("hid", 1, 1).concat();
    let descriptor = documented::DESCRIPTOR;
    let [long, most] = [descriptor.len(), report.len() + 2].map(|length| length as u16);
    let words = [
        30, 0x0100, long, 2, 3, most, 4, 0, 5, 6, 0xDEED, 0xFEED, 1, 0, 0,
    ];
    let mut bytes: Vec<u8> = words.into_iter().flat_map(u16::to_le_bytes).collect();
    bytes.extend(descriptor);
    bytes.extend([0, 0]);
    bytes.extend(most.to_le_bytes());
    bytes.extend(report);
    bytes
}

/// Decodes a stream, whose first byte is the size of its pieces less one, and two records behind it.
fn stream(name: &str, bytes: &[u8]) {
    let Some((&size, bytes)) = bytes.split_first() else {
        return;
    };
    let known = Protocol::NAMES.iter().find(|known| **known == name);
    let name = *known.expect("a fuzz target's name");
    let mut line = Line::new(name);
    // A question, which few decoders make something of, and none that is asked for too
    // long: pieces are 2 ms apart.
    let question = [b'O', size % 40];
    let question = &question[..if bytes.len() / (usize::from(size) + 1) < 400 {
        2
    } else {
        0
    }];
    line.decoder.on_sent(question, line.now);
    for piece in bytes.chunks(usize::from(size) + 1) {
        line.feed(piece);
    }
    let intact = records(name, 1, 2).concat();
    line.feed(&intact);
    line.finish(bytes.len() + intact.len());
    // Cut otherwise, it says the same; only reports depend on where they end.
    if !matches!(name, "osvr-hdk" | "hid") {
        let mut samples = 0;
        let mut whole = decoder(&Protocol::named(name).expect("a name of the list"));
        whole.on_sent(question, Micros(1));
        let mut count = |event| samples += u64::from(matches!(event, Event::Sample(_)));
        whole.feed(bytes, Micros(1), &mut count);
        whole.feed(&intact, Micros(1), &mut count);
        assert_eq!(samples, line.samples, "{name}");
    }
}

/// Reads a list of items of FASTRAK or Liberty, and a stream of such records.
fn items(bytes: &[u8]) {
    let Some((&[kind, count], bytes)) = bytes.split_first_chunk() else {
        return;
    };
    let (numbers, bytes) = bytes.split_at(usize::from(count).min(bytes.len()));
    let format = if kind & 1 == 0 {
        Format::Binary
    } else {
        Format::Ascii
    };
    let family = if kind & 2 == 0 {
        Family::Fastrak
    } else {
        Family::Liberty
    };
    let Ok(items) = ItemList::new(family, format, numbers) else {
        return;
    };
    let mut take = |event| {
        if let Event::Sample(sample) = event {
            assert_usable("items", &sample);
        }
    };
    match family {
        Family::Fastrak => {
            let mut decoder = Fastrak::new(fastrak::Config::new(items));
            decoder.feed(bytes, Micros(1), &mut take);
        }
        Family::Liberty => {
            let mut decoder = Liberty::new(liberty::Config::new(items));
            decoder.feed(bytes, Micros(1), &mut take);
        }
    }
}

/// Reads a report descriptor, and reports of 66 bytes behind the documented one's
/// length.
fn descriptor(bytes: &[u8]) {
    let length = documented::DESCRIPTOR.len().min(bytes.len());
    let (head, reports) = bytes.split_at(length);
    for descriptor in [head, bytes] {
        let Ok(mut tracker) = EyeTracker::new(descriptor, Axes::default()) else {
            continue;
        };
        let intact = records("hid", 1, 1).concat();
        for report in reports.chunks(66).chain([&intact[..]]) {
            tracker.feed(report, Micros(1), &mut |event| {
                if let Event::Sample(sample) = event {
                    assert_usable("hid", &sample);
                }
            });
            let _ = tracker.capabilities(report);
            let _ = tracker.configuration(report);
            let _ = tracker.status(report);
        }
        if let Some(request) = tracker.mode_request(Mode::ALL) {
            let (_, size) = tracker.feature_reports()[3].expect("it has one");
            assert_eq!(request.len(), size);
        }
    }
}

/// Sends a host's bytes to the mock device of the protocol that the first byte chooses.
fn device(bytes: &[u8]) {
    let Some((&which, bytes)) = bytes.split_first() else {
        return;
    };
    let name = Protocol::NAMES[usize::from(which) % Protocol::NAMES.len()];
    let mut device = Device::new(&Protocol::named(name).expect("a name of the list"));
    for (piece, millis) in bytes.chunks(16).zip(0..) {
        let now = Micros::from_millis(1_000 * millis);
        device.feed(piece, now, &mut |answer| assert!(!answer.is_empty()));
        let _ = device.measure(&Sample::arrived(now));
    }
}

/// A bus on which these bytes come, and then an error.
struct Bus<'a>(&'a [u8]);

impl i2c::ErrorType for Bus<'_> {
    type Error = i2c::ErrorKind;
}

impl I2c for Bus<'_> {
    fn transaction(
        &mut self,
        _: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), i2c::ErrorKind> {
        for operation in operations {
            if let Operation::Read(into) = operation {
                let (read, rest) = self
                    .0
                    .split_at_checked(into.len())
                    .ok_or(i2c::ErrorKind::Bus)?;
                into.copy_from_slice(read);
                self.0 = rest;
            }
        }
        Ok(())
    }
}

/// Reads a scene file.
fn scene_file(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        scenes::file(text);
    }
}

/// Reads from a device over I²C.
fn i2c(bytes: &[u8]) {
    let mut hid = I2cHid::new(Bus(bytes), 0x2C, 0x0001);
    let mut buffer = [0; 512];
    for step in 0..16 {
        let now = Micros::from_millis(200 * step);
        let _ = hid.poll(now, Interrupt::Asserted, &mut buffer);
        if let Ok(Some(report)) = hid.input(&mut buffer) {
            assert!(report.len() <= 512);
        }
        let _ = hid.get_feature(0x11, 22, &mut buffer);
        let _ = hid.set_feature(0x14, &[0x14, 1]);
    }
}
