use super::super::protocol::ProtocolSpec;
use super::super::spec::Spec;
use super::*;
use miette::Diagnostic;
use shisen_tracker::decoder::Event;
use shisen_tracker::mock::{Source, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};

/// Returns the mock's samples of a second, what a decoder reads of them, and the bytes that it
/// drops.
fn read(sent_as: &str, read_as: &str) -> [u64; 3] {
    let protocol = |text: &str| text.parse::<ProtocolSpec>().unwrap();
    let viewer = Viewer::new(ViewerConfig::default(), 3);
    let tracker = Tracker::new(TrackerConfig::default(), viewer, 3).unwrap();
    let mut wire = Wire::new(tracker, protocol(sent_as).protocol().clone());
    let mut decoder = protocol(read_as).decoder().unwrap();
    let (mut sent, mut found, mut dropped) = (0, 0, 0);
    while let Some(chunk) = wire.poll(Micros::from_millis(1_000)) {
        sent += 1;
        decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
            Event::Sample(_) => found += 1,
            Event::Dropped(of) => dropped += u64::from(of.bytes),
            _ => {}
        });
    }
    [sent, found, dropped]
}

/// Settings by protocol; a decoder with the usual ones drops the bytes of those with `!`.
const SETTINGS: [(&str, &str); 7] = [
    (
        "fastrak",
        "!items=2,4,1 !items=11,1 !items=18,19 !items=2,5,6,7,0 !format=ascii \
         !items=52,61,51&format=ascii units=cm units=inches stations=1 reset_s=20 \
         !items=18,19&word_metres=1.5&word_degrees=360 frame=back,left,down sensor=up,back,right",
    ),
    (
        "liberty",
        // records=RQ is another answer: no record, and no damage.
        "!items=2,7,0 !items=2,7,8,10,0 units=cm stations=2 model=patriot model=latus records=RQ \
         !size=big !records=any&size=any frame=right,up,back&sensor=right,up,back",
    ),
    (
        "flock",
        "!format=position-angles !format=position-matrix !format=quaternion !format=angles \
         !format=matrix !format=position range=72 range=144 !group=1 !group=1&birds=2&first=2 \
         inverse=0 confirm=1 letter=q run=E !format=position-angles&half_turn=360 \
         !format=angles&half_turn=90.5 frame=back,left,down",
    ),
    (
        "hatire",
        "!bytes=big order=-pitch,yaw,-roll position=cm frame=right,up,back",
    ),
    (
        "iscan",
        "!outputs=gaze-y,gaze-x !outputs=other,gaze-x,gaze-y,pupil-diameter,pupil-x,pupil-y \
         zero=point largest=1740 confirm=1",
    ),
    ("asl", "!layout=base zero=point"),
    ("hid", "axes=left,up,forward&origin=0,0.3,-0.5"),
];

#[test]
fn what_is_set_at_both_ends_is_read() {
    for (name, settings) in SETTINGS {
        for setting in settings.split(' ') {
            let shows = setting.starts_with('!');
            let setting = format!("{name}?{}", setting.trim_start_matches('!'));
            let [sent, found, dropped] = read(&setting, &setting);
            assert!(
                found + 1 >= sent && dropped == 0,
                "{setting}: {found} {dropped}"
            );
            if shows {
                let [.., dropped] = read(&setting, name);
                assert!(10 * dropped >= 9 * sent, "{setting}: {dropped}");
            }
        }
    }
}

#[test]
fn a_wrong_setting_says_what_is_allowed() {
    for (spec, message, help) in [
        (
            "fastrak&range=36",
            "has no option \"range\"",
            "items=2,11,0",
        ),
        ("liberty&format=ascii", "has no option", "model=liberty"),
        ("flock&units=cm", "has no option", "range=36|72|144"),
        ("hatire&outputs=gaze-x", "has no option", "bytes=little|big"),
        ("iscan&layout=base", "has no option", "outputs=pupil-x"),
        ("asl&confirm=1", "has no option", "layout=numbered|base"),
        ("adhawk&items=2", "has no option", "rate=HZ"),
        ("fastrak&items=2,11", "the last item is no end", "manual"),
        ("fastrak&items=two", "items=\"two\"", "2,4,1"),
        ("fastrak&items=18,20&format=ascii", "binary form", "manual"),
        ("fastrak&format=hex", "format=\"hex\"", "binary or ascii"),
        ("fastrak&units=mm", "units=\"mm\"", "inches or cm"),
        ("fastrak&stations=13", "stations", "1 to 12"),
        ("fastrak&frame=up,up,up", "frame", "right-handed"),
        ("fastrak&frame=up,left", "frame", "forward,right,down"),
        ("flock&birds=3", "birds", "group=1"),
        ("flock&range=100", "range", "36, 72 or 144"),
        ("flock&letter=", "letter", "one character"),
        ("flock&half_turn=NaN", "half_turn", "1 to 360"),
        ("liberty&records=CPR", "records", "byte 3"),
        ("liberty&size=none", "size", "big or any"),
        ("hatire&order=yaw,yaw,roll", "order", "pitch,-yaw,roll"),
        ("iscan&outputs=nose", "outputs", "gaze-x"),
        ("iscan&largest=2000", "largest", "1 to 1740"),
        ("adhawk&rate=0", "rate", "1 to 1000 Hz"),
        ("asl&zero=1", "zero", "lost or point"),
    ] {
        let error = format!("serial:/dev/tty?protocol={spec}").parse::<Spec>();
        let error = error.unwrap_err();
        assert!(error.to_string().contains(message), "{spec}: {error}");
        let said = Diagnostic::help(&error).unwrap().to_string();
        assert!(said.contains(help), "{spec}: {said}");
        let (name, settings) = spec.split_once('&').unwrap();
        if !settings.starts_with("rate") {
            let error = format!("mock:as={name}&{settings}").parse::<Spec>();
            assert!(error.unwrap_err().to_string().contains(message), "{spec}");
        }
        let error = format!("{name}?{settings}").parse::<ProtocolSpec>();
        assert!(error.unwrap_err().to_string().contains(message), "{spec}");
    }
    let plain = "osvr-hdk?units=cm".parse::<ProtocolSpec>().unwrap_err();
    let said = Diagnostic::help(&plain).unwrap().to_string();
    assert!(said.contains("without one"), "{said}");
}
