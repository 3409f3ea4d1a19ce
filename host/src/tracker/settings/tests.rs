use super::super::protocol::ProtocolSpec;
use super::super::spec::Spec;
use super::*;
use miette::Diagnostic;
use shisen_tracker::decoder::Event;
use shisen_tracker::mock::{Source, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::sample::{GazePoint, Sample};

const SECONDS: u64 = 1;

/// What the mock sends in a second, and what a decoder makes of it.
fn heard(sent_as: &str, read_as: &str) -> (Vec<Sample>, Vec<Sample>, u64) {
    let protocol = |text: &str| text.parse::<ProtocolSpec>().unwrap();
    let tracker = || {
        let viewer = Viewer::new(ViewerConfig::default(), 3);
        Tracker::new(TrackerConfig::default(), viewer, 3).unwrap()
    };
    let mut wire = Wire::new(tracker(), protocol(sent_as).protocol().clone());
    let mut decoder = protocol(read_as).decoder().unwrap();
    let (mut found, mut truth, mut unlike) = (Vec::new(), tracker(), 0);
    let mut sent = Vec::new();
    while let Some(chunk) = wire.poll(Micros::from_millis(1_000 * SECONDS)) {
        sent.push(truth.next_sample().1);
        decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
            Event::Sample(sample) => found.push(sample),
            Event::Dropped(dropped) => unlike += u64::from(dropped.bytes),
            _ => {}
        });
    }
    (sent, found, unlike)
}

/// How far two samples are apart: metres, radians, raw units.
fn off(sent: &Sample, found: &Sample) -> f32 {
    let mut off = 0.0_f32;
    if let (Some(a), Some(b)) = (sent.head.position, found.head.position) {
        off = off.max(a.value.distance(b.value));
    }
    if let (Some(a), Some(b)) = (sent.head.orientation, found.head.orientation) {
        off = off.max(a.value.angle_between(b.value));
    }
    off
}

fn point(sample: &Sample) -> Option<glam::Vec2> {
    match sample.gaze_point?.value {
        GazePoint::Raw(point) | GazePoint::Plane(point) => Some(point),
        GazePoint::Normalized(_) => None,
    }
}

/// Each setting, and whether the bytes themselves show that it is another than
/// the usual one.
const SETTINGS: [(&str, bool); 52] = [
    ("fastrak?items=2,4,1", true),
    ("fastrak?items=11,1", true),
    ("fastrak?items=18,19", true),
    ("fastrak?items=2,5,6,7,0", true),
    ("fastrak?format=ascii", true),
    ("fastrak?items=52,61,51&format=ascii", true),
    ("fastrak?units=cm", false),
    ("fastrak?units=inches", false),
    ("fastrak?stations=1", false),
    ("fastrak?reset_s=20", false),
    ("fastrak?items=18,19&word_metres=1.5&word_degrees=360", true),
    ("fastrak?frame=back,left,down", false),
    ("fastrak?sensor=up,back,right", false),
    ("liberty?items=2,7,0", true),
    ("liberty?items=2,7,8,10,0", true),
    ("liberty?units=cm", false),
    ("liberty?stations=2", false),
    ("liberty?model=patriot", false),
    ("liberty?model=latus", false),
    // Another answer's letter: no record, and no damage.
    ("liberty?records=RQ", false),
    ("liberty?size=big", true),
    ("liberty?records=any&size=any", true),
    ("liberty?frame=right,up,back&sensor=right,up,back", false),
    ("flock?format=position-angles", true),
    ("flock?format=position-matrix", true),
    ("flock?format=quaternion", true),
    ("flock?format=angles", true),
    ("flock?format=matrix", true),
    ("flock?format=position", true),
    ("flock?range=72", false),
    ("flock?range=144", false),
    ("flock?group=1", true),
    ("flock?group=1&birds=2&first=2", true),
    ("flock?inverse=0", false),
    ("flock?confirm=1", false),
    ("flock?letter=q", false),
    ("flock?run=E", false),
    ("flock?format=position-angles&half_turn=360", true),
    ("flock?format=angles&half_turn=90.5", true),
    ("flock?frame=back,left,down", false),
    ("hatire?bytes=big", true),
    ("hatire?order=-pitch,yaw,-roll", false),
    ("hatire?position=cm", false),
    ("hatire?frame=right,up,back", false),
    ("iscan?outputs=gaze-y,gaze-x", true),
    (
        "iscan?outputs=other,gaze-x,gaze-y,pupil-diameter,pupil-x,pupil-y",
        true,
    ),
    ("iscan?zero=point", false),
    ("iscan?largest=1740", false),
    ("iscan?confirm=1", false),
    ("asl?layout=base", true),
    ("asl?zero=point", false),
    ("hid?axes=left,up,forward&origin=0,0.3,-0.5", false),
];

#[test]
fn what_is_set_at_both_ends_is_read() {
    for (setting, shown) in SETTINGS {
        let (sent, found, dropped) = heard(setting, setting);
        assert!(found.len() + 1 >= sent.len(), "{setting}: {}", found.len());
        assert_eq!(dropped, 0, "{setting}");
        let plain = setting.split('?').next().unwrap();
        // The head of a HID eye tracker is sent without its roll.
        let most = if plain == "hid" { 0.2 } else { 3e-3 };
        for (sent, found) in sent.iter().zip(&found) {
            assert!(off(sent, found) < most, "{setting}: {}", off(sent, found));
        }
        let (_, usual, _) = heard(plain, plain);
        for (a, b) in found.iter().zip(&usual) {
            if let (Some(a), Some(b)) = (point(a), point(b)) {
                assert!(a.distance(b) < 1e-3, "{setting}: {a} {b}");
            }
        }
        // Read as the usual one, it is dropped where its bytes show it.
        let (_, _, dropped) = heard(setting, plain);
        let of = sent.len() as u64;
        assert!(
            !shown || 10 * dropped >= 9 * of,
            "{setting}: {dropped} bytes dropped of {of} records"
        );
    }
}

#[test]
fn what_cannot_be_set_says_what_can() {
    for (spec, message, help) in [
        (
            "fastrak&range=36",
            "fastrak has no option \"range\"",
            "items=2,11,0",
        ),
        (
            "liberty&format=ascii",
            "liberty has no option",
            "model=liberty",
        ),
        ("flock&units=cm", "flock has no option", "range=36|72|144"),
        (
            "hatire&outputs=gaze-x",
            "hatire has no option",
            "bytes=little|big",
        ),
        (
            "iscan&layout=base",
            "iscan has no option",
            "outputs=pupil-x",
        ),
        ("asl&confirm=1", "asl has no option", "layout=numbered|base"),
        ("adhawk&items=2", "adhawk has no option", "rate=HZ"),
        ("link&units=cm", "link has no option", "rate=HZ"),
        (
            "fastrak&items=2,11",
            "items: the last item is no end",
            "manual",
        ),
        ("fastrak&items=two", "items=\"two\"", "2,4,1"),
        (
            "fastrak&items=18,20&format=ascii",
            "binary form only",
            "manual",
        ),
        ("fastrak&format=hex", "format=\"hex\"", "binary or ascii"),
        ("fastrak&units=mm", "units=\"mm\"", "inches or cm"),
        ("fastrak&stations=13", "stations", "1 to 12"),
        ("fastrak&frame=up,up,up", "frame", "right-handed"),
        ("fastrak&frame=up,left", "frame", "forward,right,down"),
        ("flock&birds=3", "birds", "group=1"),
        ("flock&range=100", "range", "144"),
        ("flock&letter=", "letter", "one character"),
        ("flock&half_turn=NaN", "half_turn", "1 to 360"),
        ("liberty&records=CPR", "records", "byte 3"),
        ("liberty&size=none", "size", "big or any"),
        ("hatire&order=yaw,yaw,roll", "order", "pitch,-yaw,roll"),
        ("iscan&outputs=nose", "outputs", "gaze-x"),
        ("iscan&largest=2000", "largest", "1 to 1740"),
        ("adhawk&rate=0", "rate", "1 to 1000 Hz"),
        ("asl&zero=1", "zero", "lost or point"),
        ("asl&zero=lost&zero=lost", "\"zero\" is given twice", "once"),
    ] {
        let error = format!("serial:/dev/tty?protocol={spec}");
        let error = error.parse::<Spec>().unwrap_err();
        assert!(error.to_string().contains(message), "{spec}: {error}");
        let said = Diagnostic::help(&error).unwrap().to_string();
        assert!(said.contains(help), "{spec}: {said}");
        if spec.contains("rate") {
            continue;
        }
        let (name, settings) = spec.split_once('&').unwrap();
        let error = format!("mock:as={name}&{settings}").parse::<Spec>();
        assert!(error.unwrap_err().to_string().contains(message), "{spec}");
        let error = format!("{name}?{settings}").parse::<ProtocolSpec>();
        assert!(error.unwrap_err().to_string().contains(message), "{spec}");
    }
    let plain = "osvr-hdk?units=cm".parse::<ProtocolSpec>().unwrap_err();
    let said = Diagnostic::help(&plain).unwrap().to_string();
    assert!(said.contains("without one"), "{said}");
}
