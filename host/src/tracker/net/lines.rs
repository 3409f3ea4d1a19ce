//! Lines of JSON, as `shisen tracker monitor --json` prints them: what is not there is left out.

use super::{Peer, Server, socket};
use crate::files::Fault;
use crate::tracker::notice::Notice;
use glam::{Quat, Vec2, Vec3};
use serde::Deserialize;
use serde_json::Value;
use shisen_tracker::decoder::{Counts, DropReason, Dropped, Event};
use shisen_tracker::head::axes::FARTHEST_POSITION;
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Head, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::io::Read as _;
use std::net::TcpStream;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

/// Most bytes of a line.
const LONGEST: usize = 1 << 16;

/// Pieces of standard input that wait to be read.
const PIECES: usize = 16;

/// Samples in lines.
pub(super) struct Lines {
    from: From,
    line: Vec<u8>,
    /// Whether the line is too long: the rest of it is dropped.
    is_too_long: bool,
    number: u64,
    is_told: bool,
    is_over: bool,
    counts: Counts,
}

enum From {
    Stdin(Receiver<Vec<u8>>),
    Server(TcpStream, Vec<u8>),
}

impl Lines {
    pub(super) fn of_stdin() -> Self {
        let (send, receive) = sync_channel(PIECES);
        // It ends with its input or the program: nothing else stops a read.
        std::thread::spawn(move || {
            let mut chunk = [0; 4_096];
            let mut stdin = std::io::stdin().lock();
            while let Ok(length @ 1..) = stdin.read(&mut chunk) {
                if send.send(chunk[..length].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self::new(From::Stdin(receive))
    }

    pub(super) fn connect(server: &Server, patience: Duration) -> Result<Self, Fault> {
        let stream = socket::connect(server, patience)?;
        Ok(Self::new(From::Server(stream, vec![0; 4_096])))
    }

    const fn new(from: From) -> Self {
        Self {
            from,
            line: Vec::new(),
            is_too_long: false,
            number: 0,
            is_told: false,
            is_over: false,
            counts: Counts {
                bytes: 0,
                samples: 0,
                messages: 0,
                lost: 0,
                dropped: [0; DropReason::ALL.len()],
                dropped_bytes: 0,
            },
        }
    }

    fn take(&mut self, bytes: &[u8], now: Micros, sink: &mut dyn FnMut(Notice)) {
        self.counts.bytes += bytes.len() as u64;
        for &byte in bytes {
            if byte != b'\n' {
                self.is_too_long |= self.line.len() >= LONGEST;
                if !self.is_too_long {
                    self.line.push(byte);
                }
                continue;
            }
            self.number += 1;
            let is_too_long = std::mem::take(&mut self.is_too_long);
            let read = read(&self.line, now);
            let length = self.line.len();
            self.line.clear();
            match read {
                _ if is_too_long => {
                    self.refuse(length, &format!("it has more than {LONGEST} bytes"), sink);
                }
                Ok(Some(sample)) => {
                    self.counts.samples += 1;
                    sink(Notice::Decoded(Event::Sample(sample)));
                }
                Ok(None) => {}
                Err(reason) => self.refuse(length, &reason, sink),
            }
        }
    }

    fn refuse(&mut self, bytes: usize, why: &str, sink: &mut dyn FnMut(Notice)) {
        let reason = DropReason::Field;
        self.counts.dropped[reason as usize] += 1;
        self.counts.dropped_bytes += bytes as u64;
        let bytes = bytes as u32;
        sink(Notice::Decoded(Event::Dropped(Dropped { bytes, reason })));
        if !std::mem::replace(&mut self.is_told, true) {
            sink(Notice::Said(format!(
                "line {} is no sample ({why}), and is dropped, as others like it will be; lines are \
                 as `shisen tracker monitor --json` prints them",
                self.number
            )));
        }
    }
}

impl Peer for Lines {
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String> {
        let mut pieces = Vec::new();
        let read = match &mut self.from {
            From::Stdin(receive) => {
                match receive.recv_timeout(socket::WAIT) {
                    Ok(piece) => pieces.push((piece, now())),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => self.is_over = true,
                }
                Ok(())
            }
            From::Server(stream, buffer) => socket::bytes(stream, buffer, |bytes| {
                pieces.push((bytes.to_vec(), now()));
            }),
        };
        for (piece, at) in pieces {
            self.take(&piece, at, sink);
        }
        read
    }

    fn counts(&self) -> Counts {
        self.counts
    }

    fn remedy(&self) -> String {
        "see that the program that sends the lines runs, and ends each with a line feed, at once \
         (many programs hold lines back unless told otherwise: flush)"
            .to_owned()
    }

    fn is_over(&self) -> bool {
        self.is_over
    }
}

/// A sample as it is written. Keys of which nothing is needed are let pass.
#[derive(Deserialize)]
struct Line {
    #[serde(default)]
    sensor: u8,
    device_us: Option<u64>,
    sequence: Option<u32>,
    #[serde(default)]
    head: HeadLine,
    gaze_frame: Option<FrameName>,
    left: Option<EyeLine>,
    right: Option<EyeLine>,
    combined: Option<EyeLine>,
    gaze_point: Option<PointLine>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum FrameName {
    Head,
    Tracker,
}

/// Numbers with whether the tracker sees them, or numbers alone.
#[derive(Deserialize)]
#[serde(try_from = "Value")]
struct Numbers<const N: usize> {
    value: [f32; N],
    tracked: bool,
}

impl<const N: usize> TryFrom<Value> for Numbers<N> {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let (value, tracked) = match value {
            Value::Object(mut marked) => {
                let tracked = marked.get("tracked").and_then(Value::as_bool);
                (marked.remove("value").unwrap_or_default(), tracked)
            }
            alone => (alone, None),
        };
        let numbers: Vec<f32> = serde_json::from_value(value).map_err(|error| error.to_string())?;
        let found = numbers.len();
        let value = numbers.try_into();
        Ok(Self {
            value: value.map_err(|_| format!("{found} numbers in place of {N}"))?,
            tracked: tracked.unwrap_or(true),
        })
    }
}

#[derive(Deserialize, Default)]
struct HeadLine {
    position: Option<Numbers<3>>,
    orientation: Option<Numbers<4>>,
    angular_velocity: Option<[f32; 3]>,
}

#[derive(Deserialize)]
struct EyeLine {
    origin: Option<Numbers<3>>,
    direction: Option<Numbers<3>>,
    pupil_m: Option<f32>,
    pupil_raw: Option<f32>,
    openness: Option<f32>,
}

#[derive(Deserialize)]
struct PointLine {
    kind: PointKind,
    value: [f32; 2],
    tracked: Option<bool>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum PointKind {
    Plane,
    Normalized,
    Raw,
}

impl<const N: usize> Numbers<N> {
    fn reading<T>(self, make: impl Fn([f32; N]) -> Option<T>) -> Result<Reading<T>, String> {
        let Self { value, tracked } = self;
        check(&value)?;
        let value = make(value).ok_or("a direction or a rotation is 0")?;
        Ok(Reading { value, tracked })
    }
}

/// Returns the sample of a line; `None` for an empty one.
fn read(line: &[u8], arrival: Micros) -> Result<Option<Sample>, String> {
    if line.trim_ascii().is_empty() {
        return Ok(None);
    }
    let line: Line = serde_json::from_slice(line).map_err(|error| error.to_string())?;
    let mut sample = Sample::arrived(arrival);
    sample.sensor = line.sensor;
    sample.device_time = line.device_us.map(DeviceTime::unwrapped);
    sample.sequence = line.sequence;
    sample.head = Head {
        position: place(line.head.position)?,
        orientation: line
            .head
            .orientation
            .map(|turn| {
                turn.reading(|turn| {
                    let turn = Quat::from_array(turn);
                    (turn.length() > 1.0e-3).then(|| turn.normalize())
                })
            })
            .transpose()?,
        angular_velocity: line
            .head
            .angular_velocity
            .map(|about| check(&about).map(|()| Vec3::from_array(about)))
            .transpose()?,
    };
    if let Some(FrameName::Tracker) = line.gaze_frame {
        sample.gaze_frame = GazeFrame::Tracker;
    }
    sample.left = eye(line.left)?;
    sample.right = eye(line.right)?;
    sample.combined = eye(line.combined)?;
    sample.gaze_point = line.gaze_point.map(|point| {
        let place = Vec2::from_array(point.value);
        Reading {
            value: match point.kind {
                PointKind::Plane => GazePoint::Plane(place),
                PointKind::Normalized => GazePoint::Normalized(place),
                PointKind::Raw => GazePoint::Raw(place),
            },
            tracked: point.tracked.unwrap_or(true) && place.is_finite(),
        }
    });
    Ok(Some(sample))
}

/// Refuses numbers that are none, or larger than anything that is measured.
fn check(numbers: &[f32]) -> Result<(), String> {
    const LARGEST: f32 = 1.0e6;
    match numbers.iter().find(|number| !(number.abs() <= LARGEST)) {
        None => Ok(()),
        Some(number) => Err(format!("{number} is not finite, or out of range")),
    }
}

fn place(numbers: Option<Numbers<3>>) -> Result<Option<Reading<Vec3>>, String> {
    let place = |numbers: Numbers<3>| numbers.reading(|place| Some(Vec3::from_array(place)));
    let place = numbers.map(place).transpose()?;
    let far = place.filter(|place| place.value.abs().max_element() > FARTHEST_POSITION);
    match far {
        None => Ok(place),
        Some(far) => Err(format!("{} is farther than 100 m", far.value)),
    }
}

fn eye(line: Option<EyeLine>) -> Result<Eye, String> {
    let Some(line) = line else {
        return Ok(Eye::default());
    };
    let others = [line.pupil_m, line.pupil_raw, line.openness];
    for number in others.into_iter().flatten() {
        check(&[number])?;
    }
    let direction = line.direction.map(|direction| {
        direction.reading(|direction| Vec3::from_array(direction).try_normalize())
    });
    Ok(Eye {
        origin: place(line.origin)?,
        direction: direction.transpose()?,
        pupil: line
            .pupil_m
            .map(Pupil::Diameter)
            .or(line.pupil_raw.map(Pupil::Raw)),
        openness: line.openness,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_whole_or_refused() {
        let monitored =
            br#"{"number":3,"arrival_us":5,"device_us":70,"late_us":null,"clock":"runs",
            "sensor":2,"sequence":9,"head":{"position":{"value":[1.0,2.0,3.0],"tracked":false},
            "orientation":[0,0,0,2],"angular_velocity":null},"gaze_frame":"tracker","left":null,
            "right":{"origin":null,"direction":{"value":[0,0,-2],"tracked":true},"pupil_m":0.004,
            "pupil_raw":null,"openness":1.0},"gaze_point":{"kind":"plane","value":[0.5,0.25],
            "tracked":true},"said":[]}"#;
        let sample = read(monitored, Micros(11)).unwrap().unwrap();
        assert_eq!(
            (sample.arrival, sample.sensor, sample.sequence),
            (Micros(11), 2, Some(9))
        );
        assert_eq!(sample.device_time, Some(DeviceTime::unwrapped(70)));
        assert_eq!(
            sample.head.position,
            Some(Reading::held(Vec3::new(1.0, 2.0, 3.0)))
        );
        assert_eq!(
            sample.head.orientation,
            Some(Reading::tracked(Quat::IDENTITY))
        );
        assert_eq!(sample.gaze_frame, GazeFrame::Tracker);
        assert_eq!(sample.right.direction, Some(Reading::tracked(Vec3::NEG_Z)));
        assert_eq!(sample.right.pupil, Some(Pupil::Diameter(0.004)));
        let point = GazePoint::Plane(Vec2::new(0.5, 0.25));
        assert_eq!(sample.gaze_point, Some(Reading::tracked(point)));
        assert_eq!(read(b" \r", Micros(0)), Ok(None));
        assert_eq!(read(b"{}", Micros(4)), Ok(Some(Sample::arrived(Micros(4)))));
        for (line, says) in [
            (&b"{"[..], "EOF"),
            (br#"{"head":{"orientation":[0,0,0,0]}}"#, "is 0"),
            (br#"{"head":{"position":[1e39,0,0]}}"#, "not finite"),
            (br#"{"head":{"position":[1700,0,0]}}"#, "farther than 100 m"),
            (
                br#"{"head":{"angular_velocity":[1e39,0,0]}}"#,
                "out of range",
            ),
            (br#"{"left":{"openness":1e39}}"#, "out of range"),
            (br#"{"head":{"position":[1,2]}}"#, "2 numbers in place of 3"),
            (br#"{"sensor":256}"#, "256"),
            (br#"{"gaze_frame":"room"}"#, "room"),
        ] {
            let error = read(line, Micros(0)).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
        // A line without an end takes no more memory than the longest one.
        let mut lines = Lines::new(From::Stdin(sync_channel(1).1));
        for _ in 0..1_000 {
            lines.take(&[b'x'; 4_096], Micros(0), &mut |_| {
                panic!("no line has ended")
            });
        }
        assert!(lines.line.capacity() <= 2 * LONGEST);
        let mut said = Vec::new();
        lines.take(b"\n{}\n{\n", Micros(0), &mut |notice| said.push(notice));
        assert!(matches!(&said[1], Notice::Said(text) if text.contains("more than 65536 bytes")));
        assert_eq!(
            (
                lines.counts.samples,
                lines.counts.dropped.iter().sum::<u32>()
            ),
            (1, 2)
        );
        assert_eq!(said.len(), 4, "{said:?}");
    }
}
