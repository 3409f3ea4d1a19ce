use super::*;
use glam::{Quat, Vec3};
use miette::Diagnostic;

#[test]
fn each_kind_is_read() {
    let kind = |text: &str| text.parse::<Spec>().unwrap().kind;
    assert_eq!(kind("mock"), TrackerKind::Mock(MockSpec::default()));
    let mock = MockSpec {
        seed: 7,
        rate: 200,
        protocol: Some("fastrak".parse().unwrap()),
        still: true,
        targets: Some("a.csv".into()),
        ..MockSpec::default()
    };
    let text = "mock:seed=7&rate=200&as=fastrak&still=1&targets=a.csv";
    assert_eq!(kind(text), TrackerKind::Mock(mock));
    let plain = SerialSpec {
        path: "/dev/ttyUSB0".into(),
        protocol: "asl".parse().unwrap(),
        baud: 57_600,
        reset: false,
        speed: None,
        stop: false,
        rts: None,
    };
    let reset = SerialSpec {
        protocol: "flock".parse().unwrap(),
        baud: 9_600,
        reset: true,
        rts: Some(true),
        ..plain.clone()
    };
    let faster = SerialSpec {
        protocol: "fastrak".parse().unwrap(),
        baud: 9_600,
        speed: Some(115_200),
        stop: true,
        ..plain.clone()
    };
    for (options, spec, head) in [
        ("protocol=asl", plain, None),
        (
            "protocol=flock&baud=9600&reset=1&head=2&rts=1",
            reset,
            Some(2),
        ),
        (
            "protocol=fastrak&baud=9600&speed=115200&stop=1",
            faster,
            None,
        ),
    ] {
        let found: Spec = format!("serial:/dev/ttyUSB0?{options}").parse().unwrap();
        assert_eq!((found.kind, found.head), (TrackerKind::Serial(spec), head));
    }
    let usage = |usage| HidName::Usage { page: 0x12, usage };
    for (text, name) in [
        ("1532:0b00", HidName::Id(0x1532, 0x0B00)),
        ("/dev/hidraw0", HidName::Path("/dev/hidraw0".into())),
        ("usage=0012", usage(None)),
        ("usage=0012:0001", usage(Some(1))),
    ] {
        assert_eq!(name.to_string(), text);
        let axes = Axes {
            rotation: Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            origin: Vec3::new(0.0, 0.3, -0.5),
        };
        let text = format!("hid:{text}?axes=left,up,forward&origin=0,0.3,-0.5");
        assert_eq!(kind(&text), TrackerKind::Hid(HidSpec { name, axes }));
    }
    for (text, path, head) in [
        ("replay:a:b", "a:b", None),
        ("replay:a?b", "a?b", None),
        ("replay:a?b?head=7", "a?b", Some(7)),
    ] {
        let found: Spec = text.parse().unwrap();
        assert_eq!(
            (found.kind, found.head),
            (TrackerKind::Replay(path.into()), head)
        );
    }
}

/// A specification, its message and its help; a leading `?` is a serial port's.
#[test]
fn faults_say_what_is_allowed() {
    for (spec, message, help) in [
        ("mouse", "mouse", "serial:/dev/ttyUSB0"),
        ("serial:", "names no port", "serial:/dev"),
        ("serial:?protocol=asl", "names no port", "serial:/dev"),
        ("serial:/dev/ttyUSB0", "protocol", "fastrak, liberty"),
        ("?protocol=hid", "serial line", "hid:VENDOR"),
        ("?protocol=asd", "asd", "asl"),
        ("?protocol=asl&baud=0", "baud", "4000000"),
        ("?protocol=asl&baud=1200&baud=50", "twice", "once"),
        ("?protocol=asl&speed=1", "asl has no", "baud=N"),
        ("?protocol=fastrak&speed=1", "speed", "57600"),
        ("?protocol=fastrak&speed=9600&reset=1", "undoes", "own"),
        ("?protocol=asl&stop=1", "no command that stops", "adhawk"),
        ("?protocol=asl&reset=yes", "reset", "0 or 1"),
        ("?protocol=asl&reset=1", "no command", "liberty, flock"),
        ("?protocol=link&reset=1", "link", "leave reset"),
        ("?protocol=asl&rts=2", "rts", "0 or 1"),
        ("?protocol=asl&stuck=1", "no option", "stuck_after=S|never"),
        ("?protocol=asl&head=3", "asl has one sensor", "leave head"),
        ("mock:head=0", "mock has one sensor", "leave head"),
        ("mock:as=flock&head=3", "mock has one sensor", "leave head"),
        ("mock:as=adhawk&head=0", "adhawk has one", "leave head"),
        ("mock:as=link&head=256", "head", "0 to 255"),
        ("mock:as=flock&group=1&birds=2&head=3", "0 to 1", "birds"),
        ("mock:rate=59", "59", "60 to 10000"),
        ("mock:rate=", "rate", "60 to 10000"),
        ("mock:speed=5", "speed", "rate=HZ"),
        ("mock:still=yes", "still", "0 or 1"),
        ("mock:targets=", "targets", "table"),
        ("mock:as=mouse", "mouse", "osvr-hdk"),
        ("mock:hold_after=soon", "hold_after=\"soon\"", "as 0.25"),
        ("mock:full_after=-1", "full_after", "0 to 60"),
        ("mock:full_after=nan", "full_after", "0 to 60"),
        ("mock:hold_after=never", "hold_after", "0 to 60"),
        ("mock:stuck_after=61", "stuck_after", "or never"),
        ("mock:stuck_after=0.01", "10000 µs", "stuck_after"),
        ("mock:hold_after=0.3", "time to widen", "widen_after"),
        ("mock:hold=1", "no option \"hold\"", "hold_after=S"),
        ("hid:1:2", "1:2", "hexadecimal"),
        ("hid:0012", "0012", "hid:usage=0012"),
        ("hid:usage=12", "usage=12", "hid:usage=0012:0001"),
        ("hid:usage=0012:1", "usage=0012:1", "usage page"),
        ("hid:1532:0b00?units=cm", "units", "origin=X,Y,Z"),
        ("hid:1532:0b00?head=1", "hid has one sensor", "leave head"),
        ("hid:1:2?axes=right,up,forward", "axes", "right-handed"),
        ("hid:1532:0b00?origin=1,2", "origin", "metres"),
        ("replay:", "replay", "replay:FILE"),
        ("replay:a?sensor=2", "sensor", "head=N"),
        ("replay:a?head=two", "head", "0 to 255"),
        ("replay:a?longest_blink=6", "longest blink", "seconds"),
    ] {
        let serial = spec.strip_prefix('?');
        let spec = serial.map_or(spec.into(), |rest| format!("serial:/dev/tty?{rest}"));
        let error = spec.parse::<Spec>().unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        let said = Diagnostic::help(&error).unwrap().to_string();
        assert!(said.contains(help), "{spec}: {said}");
    }
}
