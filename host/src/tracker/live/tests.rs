use super::*;

#[test]
fn a_refusal_names_the_rules() {
    let error = LiveError::Open {
        path: "/dev/hidraw0".into(),
        reason: io::ErrorKind::PermissionDenied.into(),
    };
    let help = error.help().unwrap().to_string();
    assert!(help.contains("70-shisen-trackers.rules"), "{help}");
}

/// All that a FASTRAK is told within 60 s in which it says nothing.
#[cfg(unix)]
fn told_while_silent(reset: bool) -> Vec<u8> {
    use crate::tracker::Spec;
    use crate::tracker::pty::Pty;
    use std::time::Duration;
    let name = format!("shisen-live-{}-{reset}", std::process::id());
    let path = std::env::temp_dir().join(name);
    let mut pty = Pty::open(&path).unwrap();
    let spec = format!(
        "serial:{}?protocol=fastrak&reset={}",
        path.display(),
        u8::from(reset)
    );
    let Spec::Serial(spec) = spec.parse().unwrap() else {
        panic!("{spec}");
    };
    let mut live = Live::serial(spec).unwrap();
    let mut told = Vec::new();
    let mut buffer = [0; 256];
    // The clock is moved on by 50 ms a call.
    for step in 0..1_200 {
        let start = Instant::now()
            .checked_sub(Duration::from_millis(50 * step))
            .unwrap();
        live.poll(start, &mut |_| {});
        let read = pty.receive(&mut buffer).unwrap();
        told.extend_from_slice(&buffer[..read]);
    }
    told
}

/// What is plugged in where the device was and is none is said once, until it
/// is something else that is none.
#[cfg(unix)]
#[test]
fn a_device_that_cannot_be_used_again_is_told_once() {
    use crate::tracker::Spec;
    use crate::tracker::pty::Pty;
    use std::time::Duration;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line");
    let pty = Pty::open(&path).unwrap();
    let spec = format!("serial:{}?protocol=hatire", path.display());
    let Ok(Spec::Serial(spec)) = spec.parse() else {
        panic!("{spec}");
    };
    let mut live = Live::serial(spec).unwrap();
    let mut step = 0;
    // The clock is moved on by 50 ms a call, 5 s in all.
    let mut poll = || {
        let mut said = Vec::new();
        for _ in 0..100 {
            step += 1;
            let start = Instant::now()
                .checked_sub(Duration::from_millis(50 * step))
                .unwrap();
            live.poll(start, &mut |notice| said.push(notice));
        }
        said
    };
    poll();
    drop(pty);
    let [Notice::Unplugged { .. }] = poll()[..] else {
        panic!("it is gone");
    };
    assert_eq!(poll(), []);
    let reason = |said: Vec<Notice>| match &said[..] {
        [Notice::Refused { reason }] => reason.clone(),
        other => panic!("{other:?}"),
    };
    std::fs::write(&path, "no port").unwrap();
    let of_file = reason(poll());
    assert!(of_file.contains("line cannot be opened"), "{of_file}");
    assert!(of_file.contains("check the path"), "{of_file}");
    assert_eq!(poll(), []);
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    assert_ne!(reason(poll()), of_file);
    assert_eq!(poll(), []);
    std::fs::remove_dir(&path).unwrap();
    assert_eq!(poll(), []);
    std::fs::write(&path, "no port").unwrap();
    assert_eq!(reason(poll()), of_file);
    std::fs::remove_file(&path).unwrap();
    let _pty = Pty::open(&path).unwrap();
    assert_eq!(poll()[0], Notice::Plugged(path.display().to_string()));
}

#[cfg(unix)]
#[test]
fn a_silent_device_is_told_again_and_reset_once_at_most() {
    for reset in [false, true] {
        let told = told_while_silent(reset);
        let count = |byte| told.split(|&found| found == byte).count() - 1;
        // Continuous output is asked for.
        assert!(count(b'C') >= 6, "{told:?}");
        assert_eq!(count(0x19), usize::from(reset), "{told:?}");
    }
}

#[test]
fn a_flocks_line_is_out_of_reset() {
    use crate::tracker::Spec;
    for (options, expected) in [
        ("protocol=flock", Some(false)),
        ("protocol=flock&rts=1", Some(true)),
        ("protocol=fastrak", None),
        ("protocol=fastrak&rts=0", Some(false)),
    ] {
        let Ok(Spec::Serial(spec)) = format!("serial:/dev/ttyS0?{options}").parse() else {
            panic!("{options}");
        };
        let mut told = None;
        set_rts(&spec, |high| {
            told = Some(high);
            Ok(())
        })
        .unwrap();
        assert_eq!(told, expected, "{options}");
        let without = || io::Error::from(io::ErrorKind::Unsupported);
        let set = set_rts(&spec, |_| Err(without()));
        assert_eq!(set.is_err(), options.contains("rts"), "{options}");
    }
}

/// A FASTRAK at 9,600 baud is told to go on at 57,600, is set up there, and told
/// to stop at the end.
#[cfg(unix)]
#[test]
fn a_line_is_changed_to_another_speed_and_left_silent() {
    use crate::tracker::Spec;
    use crate::tracker::pty::Pty;
    use shisen_tracker::mock::{Line, Source, Tracker, TrackerConfig, Viewer, ViewerConfig};
    use std::time::Duration;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line");
    let mut pty = Pty::open(&path).unwrap();
    let spec = format!(
        "serial:{}?protocol=fastrak&baud=9600&speed=57600&stop=1",
        path.display()
    );
    let Ok(Spec::Serial(spec)) = spec.parse() else {
        panic!("{spec}");
    };
    let viewer = Viewer::new(ViewerConfig::default(), 1);
    let tracker = Tracker::new(TrackerConfig::default(), viewer, 1).unwrap();
    let mut line = Line::new(tracker, spec.protocol.protocol());
    let mut live = Live::serial(spec).unwrap();
    let (mut told, mut buffer) = (Vec::new(), [0; 256]);
    let mut serve = |now, told: &mut Vec<(u32, u8)>| {
        let count = pty.receive(&mut buffer).unwrap();
        let speed = pty.speed().unwrap();
        told.extend(buffer[..count].iter().map(|&byte| (speed, byte)));
        let mut answers = Vec::new();
        line.hear(&buffer[..count], now, &mut |answer| {
            answers.extend_from_slice(answer);
        });
        while let Some(record) = line.poll(now) {
            answers.extend_from_slice(record.bytes());
        }
        pty.send(&answers).unwrap();
    };
    // The clock is moved on by 50 ms a call.
    for step in 0..40 {
        let start = Instant::now()
            .checked_sub(Duration::from_millis(50 * step))
            .unwrap();
        live.poll(start, &mut |_| {});
        serve(Micros::from_millis(50 * step), &mut told);
    }
    let at = |speed| -> Vec<u8> {
        let told = told.iter().filter(|(at, _)| *at == speed);
        told.map(|&(_, byte)| byte).collect()
    };
    assert_eq!(at(9_600), b"co576,N,8,0\r");
    let fast = String::from_utf8(at(57_600)).unwrap();
    assert!(fast.starts_with("ScfU"), "{fast}");
    assert!(fast.ends_with('C'), "{fast}");
    told.clear();
    drop(live);
    serve(Micros::from_millis(2_000), &mut told);
    assert_eq!(told, [(57_600, b'c')]);
}

#[test]
fn a_device_is_believed_after_its_reset() {
    use crate::tracker::Spec;
    let wanted = |spec: &str| match spec.parse() {
        Ok(Spec::Serial(spec)) => Wanted::Serial(Box::new(spec)),
        other => panic!("{other:?}"),
    };
    let now = Micros(7);
    let usual = wanted("serial:/dev/ttyS0?protocol=fastrak");
    assert_eq!(setting_up(&usual, now), SettingUp::since(now, Micros(0)));
    let reset = wanted("serial:/dev/ttyS0?protocol=fastrak&reset=1");
    let away = Micros::from_millis(10_000);
    assert_eq!(setting_up(&reset, now), SettingUp::since(now, away));
    let faster = wanted("serial:/dev/ttyS0?protocol=fastrak&speed=115200");
    assert!(!setting_up(&faster, now).is_over(false, now.after(SettingUp::MOST)));
}
