//! What writes records of hostile samples, and the simulated tracker: whoever
//! reads such a record gets usable numbers or is told that there are none.

use super::numbers::{Case, Numbers, finite};
use super::tracker::a_sample;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};
use glam::Quat;
use shisen_core::frame::{FlatScreen, Pixel};
use shisen_core::gaze::HeadPose;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::Screen;
use shisen_tracker::eye::{adhawk, asl, iscan};
use shisen_tracker::head::axes::Axes;
use shisen_tracker::head::polhemus::{self, Family, ItemList};
use shisen_tracker::head::{fastrak, flock, hatire, liberty, osvr_hdk};
use shisen_tracker::hid::eye_tracker::{
    self, Capabilities, Configuration, EyeTracker, Status, documented,
};
use shisen_tracker::link;
use shisen_tracker::link::display::{
    FrameStart, Order, Orders, PixelRun, Rendering, Report, Reports, Subject,
};
use shisen_tracker::mock::{
    Device, Faults, FaultsConfig, Faulty, Line, Random, ScriptedTarget, Source, Tracker,
    TrackerConfig, Viewer, ViewerConfig, Wire,
};
use shisen_tracker::protocol::{Protocol, Reader};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use shisen_tracker::uart::{DeviceEnd, Due, HostEnd};
use std::convert::Infallible;

pub(super) const CASES: &[(&str, Case)] = &[
    ("tracker eye::adhawk::request::start", |n| {
        finite(&adhawk::start(0xff, n.next(120.0)));
    }),
    ("tracker eye::adhawk::encode::encode", |n| {
        let sample = a_sample(n);
        if let Some(packet) = adhawk::encode(&sample) {
            reads(&Protocol::AdHawk, &packet);
        }
    }),
    ("tracker eye::asl::encode", |n| {
        let sample = a_sample(n);
        for layout in [asl::Layout::Base, asl::Layout::Numbered] {
            let config = asl::Config {
                layout,
                ..asl::Config::default()
            };
            reads(&Protocol::Asl(config), &asl::encode(&sample, layout));
        }
    }),
    ("tracker eye::iscan::encode", |n| {
        let config = iscan::Config::default();
        reads(
            &Protocol::Iscan(config),
            &iscan::encode(&a_sample(n), &config),
        );
    }),
    ("tracker head::fastrak::Config::new", |n| {
        let config = fastrak::Config {
            axes: axes(n),
            ..fastrak::Config::new(items(Family::Fastrak))
        };
        finite(&config);
        reads(
            &Protocol::Fastrak(config.clone()),
            &config.encode(&a_sample(n)),
        );
    }),
    ("tracker head::fastrak::Config::encode", |n| {
        let config = fastrak::Config::new(items(Family::Fastrak));
        reads(
            &Protocol::Fastrak(config.clone()),
            &config.encode(&a_sample(n)),
        );
    }),
    ("tracker head::fastrak::Fastrak::new", |n| {
        let config = fastrak::Config {
            axes: axes(n),
            ..fastrak::Config::new(items(Family::Fastrak))
        };
        let record = config.encode(&a_sample(n));
        takes(&mut fastrak::Fastrak::new(config), &record);
    }),
    ("tracker head::flock::Config::encode", |n| {
        let sample = a_sample(n);
        for mode in flock_modes() {
            let config = flock::Config {
                mode,
                ..flock::Config::default()
            };
            reads(&Protocol::Flock(config), &config.encode(&sample));
        }
    }),
    ("tracker head::flock::Flock::new", |n| {
        let config = flock::Config {
            axes: axes(n),
            confirm: false,
            ..flock::Config::default()
        };
        let record = config.encode(&a_sample(n));
        takes(&mut flock::Flock::new(config), &record);
    }),
    ("tracker head::hatire::Config::encode_frame", |n| {
        for translation in [hatire::Translation::None, hatire::Translation::Centimetres] {
            let config = hatire::Config {
                translation,
                ..hatire::Config::default()
            };
            let frame = hatire::Frame {
                code: 5,
                rotation: n.vec3([10.0, 20.0, 30.0]).to_array(),
                translation: n.vec3([1.0, 2.0, 3.0]).to_array(),
            };
            reads(&Protocol::Hatire(config), &config.encode_frame(&frame));
        }
    }),
    ("tracker head::hatire::Config::encode", |n| {
        let config = hatire::Config::default();
        reads(&Protocol::Hatire(config), &config.encode(&a_sample(n)));
    }),
    ("tracker head::hatire::Hatire::new", |n| {
        let config = hatire::Config {
            axes: axes(n),
            ..hatire::Config::default()
        };
        let record = config.encode(&a_sample(n));
        takes(&mut hatire::Hatire::new(config), &record);
    }),
    ("tracker head::liberty::Config::new", |n| {
        let config = liberty::Config {
            axes: axes(n),
            ..liberty::Config::new(items(Family::Liberty))
        };
        finite(&config);
        reads(
            &Protocol::Liberty(config.clone()),
            &config.encode(&a_sample(n)),
        );
    }),
    ("tracker head::liberty::Config::encode", |n| {
        let config = liberty::Config::new(items(Family::Liberty));
        reads(
            &Protocol::Liberty(config.clone()),
            &config.encode(&a_sample(n)),
        );
    }),
    ("tracker head::liberty::Liberty::new", |n| {
        let config = liberty::Config {
            axes: axes(n),
            ..liberty::Config::new(items(Family::Liberty))
        };
        let record = config.encode(&a_sample(n));
        takes(&mut liberty::Liberty::new(config), &record);
    }),
    ("tracker head::osvr_hdk::Report::of_head", |n| {
        let report = osvr_hdk::Report::of_head(3, n.quat());
        reads(&Protocol::OsvrHdk, &osvr_hdk::encode(&report));
    }),
    ("tracker head::osvr_hdk::encode", |n| {
        let mut report = osvr_hdk::Report::of_head(3, Quat::IDENTITY);
        report.orientation = n.quat();
        report.payload = osvr_hdk::Payload::Version2 {
            angular_velocity: n.vec3([0.1, 0.2, 0.3]),
        };
        reads(&Protocol::OsvrHdk, &osvr_hdk::encode(&report));
    }),
    ("tracker hid::eye_tracker::documented::tracking", |n| {
        let report = documented::tracking(&a_sample(n));
        takes(&mut eye_tracker(eye_tracker::Axes::default()), &report);
    }),
    ("tracker hid::eye_tracker::documented::capabilities", |n| {
        let mut some = || Some(n.next(0.6));
        let report = documented::capabilities(&Capabilities {
            quality: Some(1),
            nearest: some(),
            best: some(),
            furthest: some(),
            widest_screen: some(),
            highest_screen: some(),
        });
        let tracker = eye_tracker(eye_tracker::Axes::default());
        finite(&tracker.capabilities(&report).expect("its own report"));
    }),
    ("tracker hid::eye_tracker::documented::configuration", |n| {
        let report = documented::configuration(&Configuration {
            manufacturer: Some(1),
            product: Some(2),
            serial_number: Some(3),
            manufacturer_date: Some(4),
            screen_width: Some(n.next(0.5)),
            screen_height: Some(n.next(0.3)),
        });
        let tracker = eye_tracker(eye_tracker::Axes::default());
        finite(&tracker.configuration(&report).expect("its own report"));
    }),
    ("tracker hid::eye_tracker::documented::status", |n| {
        let report = documented::status(&Status {
            configuration: Some(1),
            sampling_frequency: Some(n.next(60.0)),
        });
        let tracker = eye_tracker(eye_tracker::Axes::default());
        finite(&tracker.status(&report).expect("its own report"));
    }),
    ("tracker hid::eye_tracker::EyeTracker::new", |n| {
        let axes = eye_tracker::Axes {
            rotation: n.quat(),
            origin: n.vec3([0.1, 0.2, 0.3]),
        };
        let mut wire = Wire::new(nothing(), Protocol::named("hid").expect("a protocol"));
        let mut sound = tracker(Viewer::new(ViewerConfig::default(), 1));
        let record = wire.encode(&sound.next_sample().1).expect("a record");
        match EyeTracker::new(&documented::DESCRIPTOR, axes) {
            Ok(mut tracker) => takes(&mut tracker, record.bytes()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }),
    ("tracker link::Encoder::sample", |n| {
        let frame = link::Encoder::new().sample(&a_sample(n));
        reads(&Protocol::Link, &frame);
    }),
    ("tracker link::display::Encoder::report", |n| {
        let frame = Report::Frame(FrameStart {
            number: 1,
            orders: 2,
            pictures: 2,
            subject: Subject::Screens,
            state: Some(0),
            budget: 3,
            eyes: [n.vec3([0.0, 1.6, 0.0]), n.vec3([0.06, 1.6, 0.0])],
            forward: n.vec3([0.0, 0.0, -1.0]),
            up: n.vec3([0.0, 1.0, 0.0]),
            widen: n.next(0.1),
        });
        let pixel = pixel(n);
        let pixels = Report::Pixels(PixelRun {
            picture: 0,
            column: 1,
            row: 2,
            pixels: [pixel].into_iter().collect(),
        });
        for report in [frame, pixels] {
            says(&link::Encoder::new().report(&report), &report);
        }
    }),
    ("tracker link::display::Encoder::pixels", |n| {
        let pixels = [pixel(n), pixel(n)];
        let frame = link::Encoder::new().pixels(1, (2, 3), &pixels);
        let report = Report::Pixels(PixelRun {
            picture: 1,
            column: 2,
            row: 3,
            pixels: pixels.into_iter().collect(),
        });
        says(&frame, &report);
    }),
    ("tracker link::display::Encoder::order", |n| {
        let orders = [
            Order::Screen {
                index: 1,
                screen: FlatScreen {
                    first_pixel: n.vec3([-1.0, 1.0, -1.0]),
                    column_step: n.vec3([0.1, 0.0, 0.0]),
                    row_step: n.vec3([0.0, -0.1, 0.0]),
                    size: [20, 20],
                },
            },
            Order::Rendering(Rendering {
                budget: 1,
                slice: 2,
                depth: 3,
                wavelengths: 1,
                lod: true,
                eye_distance: n.next(0.064),
                display_delay: 5,
                restart_angle: n.next(0.1),
            }),
            Order::Capture {
                size: 64,
                place: n.vec3([0.0, 1.6, 0.0]),
            },
        ];
        for order in orders {
            let frame = link::Encoder::new().order(&order);
            let mut heard = 0;
            let mut reader = Orders::new();
            reader.feed(&frame, &mut |read| {
                // The same bits, NaN too: whoever obeys it makes views of it.
                assert_eq!(format!("{read:?}"), format!("{order:?}"));
                heard += 1;
            });
            assert_eq!(heard + reader.dropped(), 1);
        }
    }),
    ("tracker mock::device::Device::new", |n| {
        let protocol = a_protocol(n);
        let mut device = Device::new(&protocol);
        let sample = Sample::arrived(Micros(1));
        assert!(device.measure(&sample).is_some());
    }),
    ("tracker mock::device::Device::measure", |n| {
        for name in Protocol::NAMES {
            let protocol = Protocol::named(name).expect("a protocol");
            let sample = a_sample(n);
            if let Some(measured) = Device::new(&protocol).measure(&sample) {
                let mut wire = Wire::new(nothing(), protocol.clone());
                if let Some(record) = wire.encode(&measured) {
                    reads(&protocol, record.bytes());
                }
            }
        }
    }),
    ("tracker mock::faults::Faulty::repeat", |n| {
        let (earlier, mut sample) = (a_sample(n), Sample::arrived(Micros(9)));
        sample.repeat(&earlier);
        assert_eq!(sample.arrival, Micros(9));
    }),
    ("tracker mock::faults::Faults::new", |n| {
        let mut part = || n.next(0.1);
        let config = FaultsConfig {
            drop: part(),
            duplicate: part(),
            reorder: part(),
            corrupt: part(),
            stuck: part(),
            disconnect: part(),
            ..FaultsConfig::default()
        };
        let source = tracker(Viewer::new(ViewerConfig::default(), 1));
        match Faults::new(source, config, 1) {
            Ok(mut faults) => drop(faults.poll(Micros(50_000))),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }),
    ("tracker mock::movement::Viewer::new", |n| {
        watches(Viewer::new(a_viewer(n), 1));
    }),
    ("tracker mock::movement::Viewer::with_script", |n| {
        let script = [100_000, 300_000].map(|at| ScriptedTarget {
            at: Micros(at),
            direction: n.vec3([0.1, 0.0, -1.0]),
        });
        watches(Viewer::with_script(a_viewer(n), 1, &script));
    }),
    ("tracker mock::random::Random::chance", |n| {
        let probability = n.next(0.5);
        let happens = Random::new(1, 1).chance(probability);
        assert!(!happens || probability > 0.0);
    }),
    ("tracker mock::random::Random::between", |n| {
        let (least, most) = (n.next(1.0), n.next(2.0));
        let drawn = Random::new(1, 1).between(least, most);
        if n.within(1.0e30) {
            finite(&drawn);
        }
    }),
    ("tracker mock::random::Random::log_normal", |n| {
        let (median, deviation) = (n.next(1.0), n.next(0.3));
        let drawn = Random::new(1, 1).log_normal(median, deviation);
        if n.within(1.0) {
            finite(&drawn);
        }
    }),
    ("tracker mock::line::Line::new", |n| {
        let protocol = a_protocol(n);
        let mut line = Line::new(Once(Some(a_sample(n))), &protocol);
        if let Some(record) = line.poll(Micros(2)) {
            reads(&protocol, record.bytes());
        }
        assert_eq!(line.poll(Micros(2)), None);
    }),
    ("tracker mock::line::Line::of", |n| {
        let protocol = a_protocol(n);
        let device = Device::new(&protocol).with_birds(2, 3);
        let mut line = Line::of(Once(Some(a_sample(n))), device);
        while let Some(record) = line.poll(Micros(2)) {
            reads(&protocol, record.bytes());
        }
    }),
    ("tracker uart::device_end::DeviceEnd::new", |n| {
        let device = DeviceEnd::new(Line::new(Once(Some(a_sample(n))), &a_protocol(n)));
        assert_eq!((device.sent(), device.dropped()), (0, 0));
    }),
    ("tracker uart::device_end::DeviceEnd::serve", |n| {
        for name in Protocol::NAMES {
            let protocol = Protocol::named(name).expect("a protocol");
            let mut device = DeviceEnd::new(Line::new(Once(Some(a_sample(n))), &protocol));
            let mut port = Port::default();
            let Ok(()) = device.serve(&mut port, Micros(2), 64);
            // Before the sample, what has happened to the eyes: each changes once.
            let least = u64::from(!port.0.is_empty());
            assert!((least..=3 * least).contains(&device.sent()), "{name}");
            reads(&protocol, &port.0);
        }
    }),
    ("tracker uart::host_end::HostEnd::new", |n| {
        let script = adhawk::start(2, n.next(120.0));
        let tracker = HostEnd::new(adhawk::AdHawk::new(), script);
        assert!(!tracker.has_said_all());
    }),
    ("tracker uart::host_end::HostEnd::say", |n| {
        let mut tracker = HostEnd::new(adhawk::AdHawk::new(), Script::new());
        assert!(tracker.has_said_all());
        tracker.say(adhawk::start(2, n.next(120.0)));
        assert!(!tracker.has_said_all());
    }),
    ("tracker uart::host_end::HostEnd::serve", |n| {
        let script = adhawk::start(2, n.next(120.0));
        let mut tracker = HostEnd::new(adhawk::AdHawk::new(), script);
        let mut port = Port::default();
        let Ok(due) = tracker.serve(&mut port, Micros(2), 64, &mut |_| {});
        assert!(matches!(due, Due::Wait(_)), "{due:?}");
        assert!(!port.0.is_empty());
    }),
    ("tracker protocol::reader::Reader::new", |n| {
        let protocol = a_protocol(n);
        let mut wire = Wire::new(nothing(), protocol.clone());
        let mut sound = tracker(Viewer::new(ViewerConfig::default(), 1));
        if let Some(record) = wire.encode(&sound.next_sample().1) {
            reads(&protocol, record.bytes());
        }
    }),
    ("tracker mock::tracker::Tracker::new", |n| {
        let default = TrackerConfig::default();
        let config = TrackerConfig {
            eye_noise: n.next(default.eye_noise),
            turn_noise: n.next(default.turn_noise),
            place_noise: n.next(default.place_noise),
            losses: n.next(default.losses),
            ..default
        };
        let viewer = Viewer::new(ViewerConfig::default(), 1);
        match Tracker::new(config, viewer, 1) {
            Ok(mut tracker) => {
                for _ in 0..4 {
                    finite(&tracker.next_sample());
                }
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }),
    ("tracker mock::wire::Protocol::carries", |n| {
        let sample = a_sample(n);
        for name in Protocol::NAMES {
            let protocol = Protocol::named(name).expect("a protocol");
            assert!(protocol.carries(&sample), "{name}");
        }
    }),
    ("tracker mock::wire::Wire::new", |n| {
        let mut wire = Wire::new(
            tracker(Viewer::new(ViewerConfig::default(), 1)),
            a_protocol(n),
        );
        finite(&wire.poll(Micros(20_000)));
    }),
    ("tracker mock::wire::Wire::set_protocol", |n| {
        let mut wire = Wire::new(nothing(), Protocol::Link);
        let protocol = a_protocol(n);
        wire.set_protocol(protocol.clone());
        if let Some(record) = wire.encode(&a_sample(n)) {
            reads(&protocol, record.bytes());
        }
    }),
    ("tracker mock::wire::Wire::encode", |n| {
        let sample = a_sample(n);
        for name in Protocol::NAMES {
            let protocol = Protocol::named(name).expect("a protocol");
            let mut wire = Wire::new(nothing(), protocol.clone());
            if let Some(record) = wire.encode(&sample) {
                reads(&protocol, record.bytes());
            }
        }
    }),
];

/// A source that has nothing.
struct Nothing;

impl Source for Nothing {
    type Item = Sample;

    fn poll(&mut self, _: Micros) -> Option<Sample> {
        None
    }
}

/// A source of one sample.
struct Once(Option<Sample>);

impl Source for Once {
    type Item = Sample;

    fn poll(&mut self, _: Micros) -> Option<Sample> {
        self.0.take()
    }
}

/// A port that hears nothing and takes everything.
#[derive(Default)]
pub(super) struct Port(Vec<u8>);

impl ErrorType for Port {
    type Error = Infallible;
}

impl ReadReady for Port {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(false)
    }
}

impl Read for Port {
    fn read(&mut self, _: &mut [u8]) -> Result<usize, Infallible> {
        Ok(0)
    }
}

impl WriteReady for Port {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }
}

impl Write for Port {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

fn nothing() -> Nothing {
    Nothing
}

fn tracker(viewer: Viewer<'_>) -> Tracker<'_> {
    Tracker::new(TrackerConfig::default(), viewer, 1).expect("the default")
}

/// What a device's reader makes of it is usable; axes that are none have no
/// reader.
fn reads(protocol: &Protocol, record: &[u8]) {
    if let Some(mut reader) = Reader::new(protocol) {
        takes(&mut reader, record);
    }
}

#[track_caller]
fn takes(decoder: &mut dyn Decoder, record: &[u8]) {
    decoder.feed(record, Micros(1), &mut |event| match event {
        Event::Sample(sample) => finite(&sample),
        other => assert!(!format!("{other:?}").is_empty()),
    });
}

pub(super) fn items(family: Family) -> ItemList {
    let numbers: &[u8] = match family {
        Family::Fastrak => &[2, 11, 0],
        Family::Liberty => &[2, 7, 0],
    };
    ItemList::new(family, polhemus::Format::Binary, numbers).expect("a list")
}

fn flock_modes() -> [flock::Mode; 7] {
    use flock::Mode;
    [
        Mode::Angles,
        Mode::Position,
        Mode::Matrix,
        Mode::Quaternion,
        Mode::PositionAngles,
        Mode::PositionMatrix,
        Mode::PositionQuaternion,
    ]
}

/// Of these numbers where they are rotations.
pub(super) fn axes(n: &mut Numbers) -> Axes {
    Axes::new(n.quat(), n.quat()).unwrap_or(Axes::FORWARD_RIGHT_DOWN)
}

fn eye_tracker(axes: eye_tracker::Axes) -> EyeTracker {
    EyeTracker::new(&documented::DESCRIPTOR, axes).expect("the documented descriptor")
}

/// A HID eye tracker on any screen, in any axes.
pub(super) fn a_protocol(n: &mut Numbers) -> Protocol {
    let screen = Screen {
        corner: n.vec3([-1.0, 0.5, -1.0]),
        right: n.vec3([1.0, 0.0, 0.0]),
        down: n.vec3([0.0, -1.0, 0.0]),
        size: n.vec2([2.0, 1.0]),
    };
    let axes = eye_tracker::Axes {
        rotation: n.quat(),
        origin: n.vec3([0.1, 0.2, 0.3]),
    };
    Protocol::EyeTracker(screen, axes)
}

fn pixel(n: &mut Numbers) -> Pixel {
    Pixel {
        red: n.next(0.1),
        green: n.next(0.2),
        blue: n.next(0.3),
        alpha: n.next(1.0),
    }
}

/// A controller's word arrives as it was said, bit for bit, or not at all.
#[track_caller]
fn says(frame: &[u8], report: &Report) {
    let mut heard = 0;
    let mut reader = Reports::new();
    reader.feed(frame, &mut |read| {
        assert_eq!(format!("{read:?}"), format!("{report:?}"));
        heard += 1;
    });
    assert_eq!(heard + reader.dropped(), 1);
}

fn a_viewer(n: &mut Numbers) -> ViewerConfig {
    let default = ViewerConfig::default();
    ViewerConfig {
        resting_head: HeadPose {
            position: n.vec3([0.0, 1.6, 0.0]),
            orientation: n.quat(),
        },
        head_sway: n.next(default.head_sway),
        head_turn: n.next(default.head_turn),
        field: n.next(default.field),
        fixation: n.next(default.fixation),
        fixation_deviation: n.next(default.fixation_deviation),
        amplitude: n.next(default.amplitude),
        base_duration: n.next(default.base_duration),
        duration_per_amplitude: n.next(default.duration_per_amplitude),
        duration_deviation: n.next(default.duration_deviation),
        pursuit: n.next(default.pursuit),
        pursuit_speed: n.next(default.pursuit_speed),
        microsaccades: n.next(default.microsaccades),
        blinks: n.next(default.blinks),
        blink: n.next(default.blink),
        blink_deviation: n.next(default.blink_deviation),
        jitter: n.next(default.jitter),
    }
}

/// Two seconds of a viewer.
fn watches(mut viewer: Viewer<'_>) {
    for step in 0..200 {
        if let Some(truth) = viewer.truth(Micros(10_000 * step)) {
            finite(&truth);
            let way = truth.direction;
            assert!((way.length() - 1.0).abs() < 1.0e-4, "{way}");
            assert!((0.0..=1.0).contains(&truth.openness));
        }
    }
}
