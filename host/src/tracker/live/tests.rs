use super::*;
use crate::tracker::Spec;
use crate::tracker::pty::Pty;
use shisen_tracker::mock::{Line, Source, Tracker, TrackerConfig, Viewer, ViewerConfig};
use std::path::PathBuf;
use std::time::Duration;

/// A line in a folder of its own, and a device on it whose clock moves on by 50 ms a call.
struct Bench {
    folder: tempfile::TempDir,
    pty: Option<Pty>,
    live: Option<Live>,
    step: u32,
}

impl Bench {
    fn new(options: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let pty = Some(Pty::open(&path).unwrap());
        let spec = spec(&format!("{}?{options}", path.display()));
        let live = Live::open(TrackerKind::Serial(spec), Tap::default()).ok();
        let step = 0;
        Self {
            folder,
            pty,
            live,
            step,
        }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("line")
    }

    fn poll(&mut self) -> Vec<Notice> {
        let mut notices = Vec::new();
        let start = Instant::now().checked_sub(Duration::from_millis(50) * self.step);
        self.step += 1;
        let live = self.live.as_mut().unwrap();
        live.poll(start.unwrap(), &mut |notice| notices.push(notice));
        notices
    }

    fn poll_long(&mut self) -> Vec<Notice> {
        (0..100).flat_map(|_| self.poll()).collect()
    }

    /// Returns what the device was told, each byte with the line's speed.
    fn received(&mut self) -> Vec<(u32, u8)> {
        let pty = self.pty.as_mut().unwrap();
        let mut buffer = [0; 256];
        let count = pty.receive(&mut buffer).unwrap();
        let speed = pty.speed().unwrap();
        buffer[..count].iter().map(|&byte| (speed, byte)).collect()
    }
}

fn spec(text: &str) -> SerialSpec {
    match format!("serial:{text}").parse::<Spec>().unwrap().kind {
        TrackerKind::Serial(spec) => spec,
        other => panic!("{other:?}"),
    }
}

/// Another file in the device's place is reported once, until it is another kind of file.
#[test]
fn a_device_that_does_not_open_again_is_reported_once() {
    let mut bench = Bench::new("protocol=hatire");
    let path = bench.path();
    bench.poll_long();
    bench.pty = None;
    assert!(matches!(bench.poll_long()[..], [Notice::Unplugged { .. }]));
    assert_eq!(bench.poll_long(), []);
    let reason = |bench: &mut Bench| match &bench.poll_long()[..] {
        [Notice::Refused(reason)] => reason.clone(),
        other => panic!("{other:?}"),
    };
    std::fs::write(&path, "no port").unwrap();
    let of_file = reason(&mut bench);
    assert!(of_file.contains("line cannot be opened"), "{of_file}");
    assert!(of_file.contains("check the path"), "{of_file}");
    assert_eq!(bench.poll_long(), []);
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    assert_ne!(reason(&mut bench), of_file);
    assert_eq!(bench.poll_long(), []);
    std::fs::remove_dir(&path).unwrap();
    assert_eq!(bench.poll_long(), []);
    std::fs::write(&path, "no port").unwrap();
    assert_eq!(reason(&mut bench), of_file);
    std::fs::remove_file(&path).unwrap();
    bench.pty = Some(Pty::open(&path).unwrap());
    let plugged = Notice::Plugged(path.display().to_string());
    assert_eq!(bench.poll_long()[0], plugged);
}

/// A FASTRAK that is silent for 60 s.
#[test]
fn a_silent_device_is_set_up_again_and_reset_once_at_most() {
    for reset in [false, true] {
        let mut bench = Bench::new(&format!("protocol=fastrak&reset={}", u8::from(reset)));
        let mut told = Vec::new();
        for _ in 0..1_200 {
            bench.poll();
            told.extend(bench.received());
        }
        let count = |wanted| told.iter().filter(|&&(_, byte)| byte == wanted).count();
        // Continuous output is asked for.
        assert!(count(b'C') >= 6, "{told:?}");
        assert_eq!(count(0x19), usize::from(reset), "{told:?}");
    }
}

/// A FASTRAK at 9,600 baud goes on at 57,600, is set up there, and stopped at the end.
#[test]
fn a_line_is_changed_to_another_speed_and_left_silent() {
    let mut bench = Bench::new("protocol=fastrak&baud=9600&speed=57600&stop=1");
    let viewer = Viewer::new(ViewerConfig::default(), 1);
    let tracker = Tracker::new(TrackerConfig::default(), viewer, 1).unwrap();
    let protocol = spec("a?protocol=fastrak").protocol;
    let mut line = Line::new(tracker, protocol.protocol());
    let mut told = Vec::new();
    for step in 0..40 {
        bench.poll();
        let (now, received) = (Micros::from_millis(50 * step), bench.received());
        let bytes: Vec<u8> = received.iter().map(|&(_, byte)| byte).collect();
        told.extend(received);
        let mut answers = Vec::new();
        line.hear(&bytes, now, &mut |answer| answers.extend_from_slice(answer));
        while let Some(record) = line.poll(now) {
            answers.extend_from_slice(record.bytes());
        }
        bench.pty.as_mut().unwrap().send(&answers).unwrap();
    }
    let at = |speed| -> Vec<u8> {
        let told = told.iter().filter(|(at, _)| *at == speed);
        told.map(|&(_, byte)| byte).collect()
    };
    assert_eq!(at(9_600), b"co576,N,8,0\r");
    let fast = String::from_utf8(at(57_600)).unwrap();
    assert!(fast.starts_with("ScfU") && fast.ends_with('C'), "{fast}");
    bench.live = None;
    assert_eq!(bench.received(), [(57_600, b'c')]);
}

#[test]
fn a_flock_is_taken_out_of_reset() {
    for (options, expected) in [
        ("protocol=flock", Some(false)),
        ("protocol=flock&rts=1", Some(true)),
        ("protocol=fastrak", None),
        ("protocol=fastrak&rts=0", Some(false)),
    ] {
        let spec = format!("serial:/dev/ttyS0?{options}").parse::<Spec>();
        let TrackerKind::Serial(spec) = spec.unwrap().kind else {
            panic!("{options}");
        };
        let mut level = None;
        let set = crate::tracker::port::set_rts(&spec, |high| {
            level = Some(high);
            Err(io::ErrorKind::Unsupported.into())
        });
        assert_eq!(level, expected, "{options}");
        assert_eq!(set.is_err(), options.contains("rts"), "{options}");
    }
}
