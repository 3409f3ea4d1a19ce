//! Methods of what anybody can make of any numbers, because its fields are public: no
//! constructor has looked at them.

use super::frames::{picture, square};
use super::host::{mirror, wall};
use super::live::look;
use super::numbers::{Case, Numbers, finite, finite_or_error};
use super::records::{a_protocol, axes, items};
use super::tracker::{a_config, a_sample, a_screen};
use glam::{Quat, Vec2};
use shisen::cave::{Cave, Eye, Screen, Viewer, Wall};
use shisen::chart::{Axis, Chart, Corner, Line, Names, Note};
use shisen::dome::{Design, Displacement, Mapping, Viewpoint};
use shisen::firmware::ShownFrame;
use shisen::picture::Picture;
use shisen::render::{Frame, WallPicture, frame_hash};
use shisen::scene::camera::DomeCamera;
use shisen::selftest::{Errors, Outcome, selected};
use shisen::spectrum::Dispersion;
use shisen::tracker::calibration::{CalibrationFile, SeenTarget};
use shisen::tracker::{HidName, HidSpec, MockSpec, Recording, Spec, Times};
use shisen_core::scene::Records;
use shisen_core::scene::format::{self, NO_MATERIAL, Node};
use shisen_core::trace::Statistics;
use shisen_tracker::decoder::{Counts, Event};
use shisen_tracker::eye::adhawk::Request;
use shisen_tracker::head::polhemus::Family;
use shisen_tracker::head::{fastrak, flock, hatire, liberty, osvr_hdk};
use shisen_tracker::hid::eye_tracker;
use shisen_tracker::link::display::{FrameStart, Subject};
use shisen_tracker::mock::{Faults, FaultsConfig, Source};
use shisen_tracker::protocol::{Asked, Protocol};
use shisen_tracker::sample::{self, GazePoint, Sample};
use shisen_tracker::time::Micros;
use zerocopy::FromZeros;

pub(super) const CASES: &[(&str, Case)] = &[
    ("core scene::effects::Records::materials_met", |n| {
        let instance = format::Instance {
            material: NO_MATERIAL,
            ..instance(n)
        };
        let mut met = Vec::new();
        Records {
            instances: &[instance, self::instance(n)],
            meshes: &[],
            triangles: &[],
            materials: &[],
            lights: &[],
        }
        .materials_met(|material| met.push(material));
        assert_eq!(met, [0]);
    }),
    ("core scene::format::Light::is_large", |n| {
        let mut light = format::Light::new_zeroed();
        (light.place, light.up) = (n.vec3([0.0; 3]).into(), n.vec3([0.0; 3]).into());
        assert!(!light.is_large());
        light.kind = format::light::RECTANGLE;
        assert!(light.is_large());
    }),
    ("core scene::format::Texture::effect", |n| {
        let mut texture = format::Texture::new_zeroed();
        texture.repeats = n.vec2([1.0; 2]).into();
        texture.kind = format::texture::IMAGE;
        assert_eq!(texture.effect(), format::effect::IMAGE_TEXTURE);
    }),
    ("core scene::format::Node::is_empty_lane", node),
    ("core scene::format::Node::order", node),
    ("host cave::Cave::screens", |n| {
        let room = Cave {
            walls: vec![any_wall(n), any_wall(n)],
            domes: Vec::new(),
        };
        let names: Vec<&str> = room.screens().map(Screen::name).collect();
        assert_eq!(names, ["wall", "wall"]);
    }),
    ("host cave::Screen::name", |n| {
        assert_eq!(Screen::Wall(&any_wall(n)).name(), "wall");
    }),
    ("host cave::Wall::validate", |n| {
        let wall = any_wall(n);
        let valid = finite_or_error(wall.validate()).is_some();
        assert!(valid || !n.are_sane());
        let corners = [wall.lower_left, wall.lower_right, wall.upper_left];
        assert!(!valid || corners.iter().all(|corner| corner.is_finite()));
    }),
    ("host cave::viewer::Viewer::eye", |n| {
        let viewer = Viewer {
            pose: look(n).head,
            interpupillary_distance: n.wide(0.064),
        };
        let place = viewer.eye(Eye::Left);
        // What is nowhere is refused by what it is to see.
        if let Some(wall) = wall(n) {
            let view = finite_or_error(wall.view_from(place));
            assert!(view.is_none() || place.is_finite());
        }
    }),
    ("host chart::Chart::circles", chart),
    ("host chart::Chart::strokes", chart),
    ("host chart::Chart::svg", chart),
    ("host chart::Chart::write_csv", chart),
    ("host chart::Chart::write_svg", chart),
    ("host dome::design::Design::mapped", |n| {
        if let Some(mirror) = mirror(n) {
            let mapped = Design {
                error_percent: n.wide(1.0),
                ..Design::of(mirror)
            }
            .mapped(Mapping::Exact);
            assert_eq!((mapped.error_percent, mapped.extrema.len()), (0.0, 0));
        }
    }),
    ("host dome::near_field::Displacement::px_4096", |n| {
        let (r_d, angle) = (n.wide(0.5), n.wide(0.1));
        let pixels = Displacement { r_d, angle }.px_4096();
        // 1,303.8 pixels a radian.
        assert_eq!(pixels.is_finite(), (angle * 1303.8).is_finite(), "{angle}");
    }),
    ("host dome::viewpoint::Viewpoint::gain", |n| {
        let seen = Viewpoint {
            offset: n.wide(0.0),
            largest: n.wide(0.1),
            from_screen: n.wide(0.2),
        };
        // A ratio of what is finite and of a size.
        if n.within(1.0e30) && !(0.0..1.0e-30).contains(&seen.largest) {
            finite(&seen.gain());
        }
    }),
    ("host firmware::ShownFrame::hash", |n| {
        let pictures = vec![picture(n)];
        let start = FrameStart {
            number: 1,
            orders: 2,
            pictures: 1,
            subject: Subject::Screens,
            state: Some(0),
            budget: 3,
            eyes: [n.vec3([0.0; 3]); 2],
            forward: n.vec3([0.0, 0.0, -1.0]),
            up: n.vec3([0.0, 1.0, 0.0]),
            widen: n.next(0.1),
        };
        let frame = ShownFrame {
            start,
            slices: Vec::new(),
            done: None,
            pictures,
        };
        assert_eq!(
            frame.hash(),
            frame_hash(frame.pictures.iter().map(Picture::hash))
        );
    }),
    ("host render::Frame::hash", |n| {
        let picture = picture(n);
        let frame = Frame {
            pictures: vec![WallPicture {
                wall: 0,
                eye: Eye::Left,
                picture: picture.clone(),
            }],
            statistics: Statistics::default(),
            seconds: n.wide(1.0),
            capture: None,
        };
        let alone = shisen::render::frame_hash([picture.hash()]);
        assert_eq!(frame.hash(), alone);
    }),
    ("host live::session::Stage::gaze", |n| {
        let look = look(n).towards(Some(n.vec3([0.2, 0.0, -1.0])));
        // A gaze that is none leaves the look as it was.
        assert!(look.forward.is_normalized() || !n.are_sane());
    }),
    ("host mesh::TriangleMesh::bounds", |n| {
        let (low, high) = square(n).bounds();
        assert!((0..3).all(|axis| low[axis] <= high[axis]) || !n.are_sane());
    }),
    ("host mesh::TriangleMesh::validate", |n| {
        let mesh = square(n);
        let valid = finite_or_error(mesh.validate()).is_some();
        assert!(valid || !n.are_sane());
        let numbers = mesh.positions.iter().flatten();
        assert!(!valid || numbers.copied().all(f32::is_finite));
    }),
    ("host mesh::TriangleMesh::vertex_normals", |n| {
        let mesh = square(n);
        if mesh.validate().is_ok() {
            finite(&mesh.vertex_normals());
        }
    }),
    ("host picture::Picture::core_pixels", pictures),
    ("host picture::Picture::hash", pictures),
    ("host picture::Picture::pixel", pictures),
    ("host picture::Picture::png_bytes", pictures),
    ("host picture::Picture::rows_mut", pictures),
    ("host picture::Picture::write_exr", pictures),
    ("host picture::Picture::write_png", pictures),
    ("host picture::Picture::write_png_with_alpha", pictures),
    ("host scene::camera::DomeCamera::is_usable", camera),
    ("host scene::camera::DomeCamera::pose", camera),
    ("host selftest::Outcome::is_control", outcome),
    ("host selftest::Outcome::passed", outcome),
    ("host selftest::Outcome::row", outcome),
    ("host spectrum::dispersion::Dispersion::wavelengths", |n| {
        assert!(Dispersion::Single(n.next(550.0)).wavelengths().is_none());
    }),
    (
        "host tracker::calibration::CalibrationFile::fit",
        calibration,
    ),
    (
        "host tracker::calibration::CalibrationFile::to_toml",
        calibration,
    ),
    ("host tracker::recording::Recording::begin", recording),
    ("host tracker::recording::Recording::samples", recording),
    ("host tracker::spec::MockSpec::delay", |n| {
        let delay = Micros(n.next(8_000.0) as _);
        let times = Times::late(delay);
        let mock = MockSpec {
            times,
            ..MockSpec::default()
        };
        assert_eq!(mock.delay(), delay);
    }),
    ("host tracker::spec::Spec::clock", spec),
    ("host tracker::spec::Spec::head", spec),
    ("host tracker::spec::Spec::times", spec),
    (
        "tracker estimate::config::check::EstimatorConfig::check",
        |n| {
            let config = a_config(n);
            let valid = finite_or_error(config.check()).is_some();
            assert!(valid || !n.are_sane());
            if valid {
                finite(&config);
            }
        },
    ),
    ("tracker eye::adhawk::request::Request::encode", |n| {
        let hertz = n.next(120.0);
        let request = Request::Rate { hertz };
        let packet = request.encode(7);
        // The number is sent as it is; the tracker answers whether it can.
        let bits = hertz.to_le_bytes();
        assert!(packet.windows(4).any(|four| four == bits), "{packet:?}");
    }),
    ("tracker eye::adhawk::request::Request::kind", |n| {
        let hertz = n.next(120.0);
        let enable = Request::Events {
            mask: 1,
            enable: true,
        };
        assert_eq!(Request::Rate { hertz }.kind(), enable.kind());
    }),
    ("tracker head::fastrak::Config::record_bytes", fastrak),
    ("tracker head::fastrak::Config::start", fastrak),
    ("tracker head::flock::Config::record_bytes", flock),
    ("tracker head::flock::command::Config::start", flock),
    ("tracker head::flock::Config::words", flock),
    ("tracker head::hatire::Config::decode", hatire),
    ("tracker head::hatire::Config::encode_text", hatire),
    ("tracker head::liberty::Config::record_bytes", liberty),
    ("tracker head::liberty::Config::start", liberty),
    ("tracker head::osvr_hdk::Report::head", osvr),
    ("tracker head::osvr_hdk::Report::head_orientation", osvr),
    ("tracker head::osvr_hdk::Report::sample", osvr),
    ("tracker mock::faults::Source::poll", |n| {
        let sample = a_sample(n);
        let config = FaultsConfig {
            drop: 0.0,
            ..FaultsConfig::default()
        };
        let mut faults = Faults::new(Once(Some(sample)), config, 1).expect("no faults");
        // As it is, whatever it holds.
        let passed = faults.poll(Micros(u64::MAX)).expect("the sample");
        assert_eq!(format!("{passed:?}"), format!("{sample:?}"));
    }),
    ("tracker mock::wire::Protocol::says_untracked", |n| {
        assert!(a_protocol(n).says_untracked());
    }),
    ("tracker protocol::Protocol::name", protocol),
    ("tracker protocol::Protocol::is_serial", protocol),
    ("tracker protocol::Protocol::has_sensors", protocol),
    ("tracker protocol::Protocol::has_head", protocol),
    ("tracker protocol::Protocol::has_eyes", protocol),
    ("tracker protocol::Protocol::start", protocol),
    ("tracker protocol::Protocol::stop", protocol),
    ("tracker protocol::Protocol::change_speed", protocol),
    ("tracker protocol::Protocol::baud", protocol),
    ("tracker protocol::Protocol::rts", protocol),
    ("tracker sample::Eye::is_empty", |n| {
        let eye = sample::Eye {
            direction: Some(sample::Reading::tracked(n.vec3([0.0, 0.0, -1.0]))),
            ..sample::Eye::default()
        };
        assert!(!eye.is_empty());
    }),
    ("tracker sample::GazePoint::numbers", |n| {
        let place = n.vec2([0.5; 2]);
        for point in [GazePoint::Plane, GazePoint::Normalized, GazePoint::Raw] {
            let found = point(place).numbers().to_array();
            assert_eq!(found.map(f32::to_bits), place.to_array().map(f32::to_bits));
        }
    }),
];

/// A source of one sample.
struct Once(Option<Sample>);

impl Source for Once {
    type Item = Sample;

    fn poll(&mut self, _: Micros) -> Option<Sample> {
        self.0.take()
    }
}

fn instance(n: &mut Numbers) -> format::Instance {
    let mut instance = format::Instance::new_zeroed();
    for number in instance.object_from_world.iter_mut().flatten() {
        *number = n.next(1.0);
    }
    instance
}

/// A node with one child.
fn node(n: &mut Numbers) {
    let mut node = Node::<8>::new_zeroed();
    for plane in &mut node.planes {
        plane[0] = n.next(1.0);
    }
    for (number, plane) in node.planes.iter_mut().enumerate() {
        plane[1] = [f32::INFINITY, f32::NEG_INFINITY][number & 1];
    }
    assert!(node.is_empty_lane(1) && (!node.is_empty_lane(0) || !n.are_sane()));
    for octant in 0..16 {
        assert_eq!(node.order(octant), 0);
    }
}

fn any_wall(n: &mut Numbers) -> Wall {
    Wall {
        name: "wall".to_owned(),
        lower_left: n.dvec3([-1.0, 0.0, -1.0]),
        lower_right: n.dvec3([1.0, 0.0, -1.0]),
        upper_left: n.dvec3([-1.0, 2.0, -1.0]),
        pixels: [3; 2],
    }
}

/// A chart of any numbers, on axes of any range.
fn chart(n: &mut Numbers) {
    let mut axis = |name| Axis {
        name,
        label: name,
        range: n.wide(0.5)..n.wide(2.0),
        logarithmic: name == "y",
    };
    let (x, y) = (axis("x"), axis("y"));
    let mut line = |dots| Line {
        name: "line".to_owned(),
        points: (0..3)
            .map(|at| (n.wide(f64::from(at)), Some(n.wide(1.0))))
            .collect(),
        colour: 0,
        faint: false,
        dots,
    };
    let lines = vec![line(false), line(true)];
    let chart = Chart {
        title: "title".to_owned(),
        x,
        y,
        lines,
        names: Names::In(Corner::UpperLeft),
        notes: vec![Note {
            at: (n.wide(1.0), n.wide(1.0)),
            text: "note".to_owned(),
            side: Corner::LowerRight,
        }],
    };
    assert_eq!((chart.circles(), chart.strokes()), (4, 1));
    let picture = chart.svg((300, 200));
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    assert_eq!(chart.write_svg(&path("a.svg")).is_ok(), picture.is_ok());
    match picture {
        Ok(picture) => assert!(!picture.contains("NaN"), "{picture}"),
        Err(error) => assert!(!n.are_sane() && !error.to_string().is_empty()),
    }
    chart.write_csv(&path("a.csv")).expect("a table");
}

/// A picture of any light, on screens and in files.
fn pictures(n: &mut Numbers) {
    let mut shown = picture(n);
    assert_eq!(shown.core_pixels().len(), 4);
    assert_eq!(shown.rows_mut(1).count(), 2);
    assert_eq!(shown.hash(), shown.clone().hash());
    let first = shown.pixel(0, 0).expect("a pixel");
    assert_eq!(first.map(f32::to_bits), shown.pixels[0].map(f32::to_bits));
    assert_eq!(shown.pixel(2, 0), None);
    let bytes = shown.png_bytes().expect("a picture");
    let decoded = png::Decoder::new(std::io::Cursor::new(bytes)).read_info();
    assert_eq!(decoded.expect("a PNG").info().size(), (2, 2));
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    shown.write_png(&path("a.png"), &[]).expect("a PNG");
    shown
        .write_png_with_alpha(&path("b.png"), &[])
        .expect("a PNG");
    shown.write_exr(&path("a.exr"), &[]).expect("an EXR");
}

fn camera(n: &mut Numbers) {
    let camera = DomeCamera {
        position: n.dvec3([0.0, 1.0, 0.0]),
        zenith: n.dvec3([0.0, 1.0, 0.0]),
        top: n.dvec3([0.0, 0.0, 1.0]),
    };
    assert!(camera.is_usable() || !n.are_sane());
    let far = camera.position.abs().max_element() > f64::from(f32::MAX);
    if camera.is_usable() && !far {
        finite(&camera.pose());
    }
}

fn outcome(n: &mut Numbers) {
    let case = selected("").next().expect("a case");
    let errors = Errors {
        ours: n.wide(0.1),
        naive: n.wide(1.0e9),
    };
    let outcome = Outcome { case, errors };
    // What is no number passes nothing.
    assert!(!outcome.passed() || errors.ours <= case.bound);
    assert!(!outcome.is_control() || errors.naive <= case.bound);
    let row = outcome.row();
    assert_eq!(
        (row.passed, row.control),
        (outcome.passed(), outcome.is_control())
    );
}

fn calibration(n: &mut Numbers) {
    let mut seen = |x: f32, y: f32| SeenTarget {
        place: Some(n.vec3([x, y, -1.0])),
        direction: n.vec3([x, y, -1.0]),
        samples: Some(3),
        measured: [0; 3].map(|_| Some(Vec2::new(n.next(x), n.next(y)))),
    };
    let targets = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (-0.3, 0.1), (0.1, -0.3)];
    let targets: Vec<_> = targets.map(|(x, y)| seen(x, y)).into();
    let file = CalibrationFile {
        head: n.vec3([0.0; 3]),
        screen: Some(a_screen(n)),
        targets,
        ..CalibrationFile::default()
    };
    let fitted = finite_or_error(file.fit());
    assert!(fitted.is_some() || !n.are_sane());
    // What it writes is read again.
    if let Some(text) = finite_or_error(file.to_toml()) {
        assert!(fitted.is_some());
        let read = CalibrationFile::from_toml(&text, "a.toml");
        assert_eq!(read.expect("a file").targets.len(), 5);
    } else {
        assert!(!n.are_sane());
    }
}

fn recording(n: &mut Numbers) {
    let sample = a_sample(n);
    let recording = Recording {
        events: vec![Event::Sample(sample)],
        counts: vec![Counts::new()],
    };
    assert_eq!(recording.samples().count(), 1);
    assert_eq!(recording.begin(), sample.arrival);
}

fn spec(n: &mut Numbers) {
    let spec = Spec::Hid(HidSpec {
        name: HidName::Id(1, 2),
        axes: eye_tracker::Axes {
            rotation: n.quat(),
            origin: n.vec3([0.0; 3]),
        },
        times: Times::default(),
    });
    assert_eq!((spec.head(), spec.times()), (None, &Times::default()));
    assert_eq!(spec.clock(), Times::default().clock(Micros(0)));
}

/// What a protocol is like does not hang on its settings' numbers.
fn protocol(n: &mut Numbers) {
    let (found, asked) = (a_protocol(n), Asked::default());
    assert_eq!(found.name(), "hid");
    let is = [
        found.is_serial(),
        found.has_sensors(),
        found.rts().is_some(),
    ];
    assert_eq!(is, [false; 3]);
    assert!(found.has_head() && found.has_eyes() && found.baud() > 0);
    let silent = !found.start(&asked, true).says_anything() && !found.stop().says_anything();
    assert!(silent && found.change_speed(115_200).is_none());
    let sane = fastrak::Config::default();
    let config = fastrak::Config {
        axes: axes(n),
        ..sane.clone()
    };
    let script = Protocol::Fastrak(config).start(&asked, true);
    assert_eq!(script, sane.start(true));
}

fn fastrak(n: &mut Numbers) {
    let sane = fastrak::Config::new(items(Family::Fastrak));
    let config = fastrak::Config {
        axes: axes(n),
        ..sane.clone()
    };
    assert_eq!(config.record_bytes(), sane.record_bytes());
    assert_eq!(config.start(true), sane.start(true));
}

fn liberty(n: &mut Numbers) {
    let sane = liberty::Config::new(items(Family::Liberty));
    let config = liberty::Config {
        axes: axes(n),
        ..sane.clone()
    };
    assert_eq!(config.record_bytes(), sane.record_bytes());
    assert_eq!(config.start(true), sane.start(true));
}

fn flock(n: &mut Numbers) {
    let sane = flock::Config::default();
    let config = flock::Config {
        axes: axes(n),
        ..sane
    };
    assert_eq!(config.record_bytes(), sane.record_bytes());
    assert_eq!(config.start(1, 1, true), sane.start(1, 1, true));
    let record = sane.encode(&Sample::arrived(Micros(1)));
    assert_eq!(config.words(&record), sane.words(&record));
}

fn hatire(n: &mut Numbers) {
    let sane = hatire::Config::default();
    let config = hatire::Config {
        axes: axes(n),
        ..sane
    };
    let text = config.encode_text(5, &[b'v'; hatire::TEXT_BYTES]);
    assert_eq!(text, sane.encode_text(5, &[b'v'; hatire::TEXT_BYTES]));
    let frame = hatire::Frame {
        code: 3,
        rotation: n.vec3([1.0, 2.0, 3.0]).to_array(),
        translation: [0.0; 3],
    };
    // The reader is what refuses numbers; a frame has those that were sent.
    let bytes = config.encode_frame(&frame);
    let read = config.decode(&bytes).expect("a frame");
    assert_eq!(config.encode_frame(&read), bytes);
}

fn osvr(n: &mut Numbers) {
    let mut report = osvr_hdk::Report::of_head(3, Quat::IDENTITY);
    report.orientation = n.quat();
    report.payload = osvr_hdk::Payload::Version2 {
        angular_velocity: n.vec3([0.1, 0.2, 0.3]),
    };
    let (turned, sample) = (report.head_orientation(), report.sample(Micros(1)));
    assert_eq!(format!("{:?}", report.head()), format!("{:?}", sample.head));
    // Reports hold fractions of a turn; what is none stays none.
    if n.within(4.0) {
        finite(&(turned, sample));
    }
    assert!(turned.is_normalized() || !n.are_sane());
}
