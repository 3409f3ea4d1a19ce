use super::*;
use glam::{Quat, Vec3};
use miette::Diagnostic;

#[test]
fn each_kind_is_read() {
    assert_eq!("mock".parse(), Ok(Spec::Mock(MockSpec::default())));
    let mock = MockSpec {
        seed: 7,
        rate: 200,
        protocol: Some("fastrak".parse().unwrap()),
        ..MockSpec::default()
    };
    assert_eq!(
        "mock:seed=7&rate=200&as=fastrak".parse(),
        Ok(Spec::Mock(mock))
    );
    let mock = MockSpec {
        still: true,
        targets: Some("a.csv".into()),
        ..MockSpec::default()
    };
    assert_eq!("mock:still=1&targets=a.csv".parse(), Ok(Spec::Mock(mock)));
    let serial = SerialSpec {
        path: "/dev/ttyUSB0".into(),
        protocol: "asl".parse().unwrap(),
        baud: 57_600,
        reset: false,
        speed: None,
        stop: false,
        head: None,
        rts: None,
        times: Times::default(),
    };
    let spec = "serial:/dev/ttyUSB0?protocol=asl";
    assert_eq!(spec.parse(), Ok(Spec::Serial(serial.clone())));
    let other = SerialSpec {
        baud: 9_600,
        reset: true,
        head: Some(2),
        rts: Some(true),
        protocol: "flock".parse().unwrap(),
        ..serial.clone()
    };
    let spec = "serial:/dev/ttyUSB0?protocol=flock&baud=9600&reset=1&head=2&rts=1";
    assert_eq!(spec.parse(), Ok(Spec::Serial(other)));
    let faster = SerialSpec {
        baud: 9_600,
        speed: Some(115_200),
        stop: true,
        protocol: "fastrak".parse().unwrap(),
        ..serial
    };
    let spec = "serial:/dev/ttyUSB0?protocol=fastrak&baud=9600&speed=115200&stop=1";
    assert_eq!(spec.parse(), Ok(Spec::Serial(faster)));
    let times = Times::default();
    let hid = |name, axes| Ok(Spec::Hid(HidSpec { name, axes, times }));
    let id = HidName::Id(0x1532, 0x0B00);
    assert_eq!("hid:1532:0b00".parse(), hid(id, Axes::default()));
    let path = HidName::Path("/dev/hidraw0".into());
    let spec = "hid:/dev/hidraw0".parse();
    assert_eq!(spec, hid(path.clone(), Axes::default()));
    for (spec, usage) in [("hid:usage=0012", None), ("hid:usage=0012:0001", Some(1))] {
        let name = HidName::Usage { page: 0x12, usage };
        assert_eq!(name.to_string(), spec[4..]);
        assert_eq!(spec.parse(), hid(name, Axes::default()));
    }
    let axes = Axes {
        rotation: Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
        origin: Vec3::new(0.0, 0.3, -0.5),
    };
    let spec = "hid:/dev/hidraw0?axes=left,up,forward&origin=0,0.3,-0.5";
    assert_eq!(spec.parse(), hid(path, axes));
    for (text, path, head) in [
        ("replay:a:b", "a:b", None),
        ("replay:a?b", "a?b", None),
        ("replay:a?b?head=7", "a?b", Some(7)),
    ] {
        let path = path.into();
        assert_eq!(
            text.parse(),
            Ok(Spec::Replay(ReplaySpec { path, head, times }))
        );
    }
}

#[test]
fn a_sensor_is_chosen_where_there_are_several() {
    for spec in [
        "serial:/dev/tty?protocol=fastrak&head=3",
        "serial:/dev/tty?protocol=liberty&head=3",
        "serial:/dev/tty?protocol=link&head=3",
        "replay:a.csv?head=3",
        "mock:as=flock&group=1&birds=4&head=3",
        "mock:as=flock&group=1&birds=2&first=3&head=3",
    ] {
        assert_eq!(spec.parse::<Spec>().unwrap().head(), Some(3), "{spec}");
    }
    for (spec, of) in [
        ("serial:/dev/tty?protocol=asl&head=3", "asl"),
        ("serial:/dev/tty?protocol=hatire&head=0", "hatire"),
        ("mock:head=0", "mock"),
        // It has sensor 0 alone.
        ("mock:as=flock&head=3", "mock"),
        ("mock:as=adhawk&head=0", "adhawk"),
        ("hid:1532:0b00?head=1", "hid"),
    ] {
        let error = spec.parse::<Spec>().unwrap_err();
        let expected = format!("{of} has one sensor");
        assert!(error.to_string().starts_with(&expected), "{error}");
    }
}

/// Each specification is refused, with this in the message and that in the help.
fn refused(slips: &[(&str, &str, &str)]) {
    for (spec, message, help) in slips {
        let error = spec.parse::<Spec>().unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        let said = Diagnostic::help(&error).unwrap().to_string();
        assert!(said.contains(help), "{spec}: {said}");
    }
}

#[test]
fn slips_say_what_is_allowed() {
    refused(&[
        ("mouse", "mouse", "serial:/dev/ttyUSB0"),
        ("serial:", "says not which", "serial:/dev"),
        ("serial:/dev/ttyUSB0", "protocol", "fastrak, liberty"),
        ("serial:/dev/tty?protocol=hid", "serial line", "hid:VENDOR"),
        ("serial:/dev/tty?protocol=asl&baud=0", "baud", "4000000"),
        (
            "serial:/dev/tty?protocol=asl&speed=1",
            "asl has no",
            "baud=N",
        ),
        ("serial:/dev/tty?protocol=fastrak&speed=1", "speed", "57600"),
        (
            "serial:/dev/tty?protocol=fastrak&speed=9600&reset=1",
            "undoes",
            "of its own",
        ),
        (
            "serial:/dev/tty?protocol=asl&stop=1",
            "asl has no command that stops",
            "link, fastrak, liberty, flock, hatire, iscan, adhawk",
        ),
        ("serial:/dev/tty?protocol=asl&reset=yes", "reset", "0 or 1"),
        (
            "serial:/dev/tty?protocol=asl&reset=1",
            "asl has no command for a reset",
            "fastrak, liberty, flock, hatire",
        ),
        (
            "serial:/dev/tty?protocol=iscan&reset=1",
            "iscan",
            "leave reset",
        ),
        (
            "serial:/dev/tty?protocol=link&reset=1",
            "link",
            "leave reset",
        ),
        ("serial:/dev/tty?protocol=adhawk&reset=1", "adhawk", "leave"),
        ("serial:/dev/tty?protocol=asl&rts=2", "rts", "0 or 1"),
        ("serial:/dev/tty?protocol=asd", "asd", "asl"),
        ("mock:rate=59", "59", "60 to 10000"),
        ("mock:rate=", "rate", "60 to 10000"),
        ("mock:speed=5", "speed", "rate=HZ"),
        ("mock:still=yes", "still", "0 or 1"),
        ("mock:targets=", "targets", "table"),
        ("mock:as=mouse", "mouse", "osvr-hdk"),
        ("hid:1:2", "1:2", "hexadecimal"),
        ("hid:0012", "0012", "hid:usage=0012"),
        ("hid:usage=12", "usage=12", "hid:usage=0012:0001"),
        ("hid:usage=0012:1", "usage=0012:1", "usage page"),
        ("hid:1532:0b00?units=cm", "units", "origin=X,Y,Z"),
        (
            "hid:1532:0b00?axes=right,up,forward",
            "axes",
            "right-handed",
        ),
        ("hid:1532:0b00?origin=1,2", "origin", "metres"),
        ("serial:?protocol=asl", "says not which", "serial:/dev"),
        (
            "serial:/dev/tty?protocol=asl&baud=1200&baud=50",
            "twice",
            "once",
        ),
        ("mock:seed=1&seed=1", "twice", "once"),
        ("mock:units=cm", "mock has no", "seed=N"),
        ("replay:", "replay", "replay:FILE"),
        ("replay:a?sensor=2", "sensor", "head=N"),
        ("replay:a?head=two", "head", "0 to 255"),
        ("mock:as=link&head=256", "head", "0 to 255"),
    ]);
}

#[test]
fn slips_of_times_say_what_is_allowed() {
    refused(&[
        (
            "mock:hold_after=soon",
            "hold_after=\"soon\"",
            "such as 0.25",
        ),
        ("mock:hold_after=", "hold_after", "such as 0.25"),
        ("mock:hold_after=never", "hold_after", "0 to 60"),
        ("mock:full_after=-1", "full_after", "0 to 60"),
        ("mock:full_after=nan", "full_after", "0 to 60"),
        ("mock:stuck_after=61", "stuck_after", "or never"),
        ("mock:stuck_after=0.01", "10000 µs", "stuck_after"),
        (
            "mock:hold_after=0.3",
            "the time to hold is above the time to widen",
            "widen_after",
        ),
        ("replay:a?longest_blink=6", "the longest blink", "seconds"),
        ("mock:hold=1", "no option \"hold\"", "hold_after=S"),
        ("hid:1532:0b00?stuck=1", "no option", "stuck_after=S|never"),
        ("replay:a?stuck=1", "no option", "stuck_after=S|never"),
        (
            "serial:/dev/tty?protocol=asl&stuck=1",
            "no option",
            "stuck_after=S|never",
        ),
    ]);
}
