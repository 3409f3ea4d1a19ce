//! Recordings: a table for people, or frames of our own link.
//!
//! A table (`.csv`) has a line a sample; a cell is empty where the device said
//! nothing. Any other file holds [`link`] frames, messages among them, each
//! sample behind a text `arrival N`, N being its time of arrival in
//! microseconds (`arrival N lost M` where M records of the device were missing until
//! then): a recording is what a bridge board could have sent, and what
//! one did send can be replayed, by the device's own times.

use glam::{Quat, Vec2, Vec3};
use miette::Diagnostic;
use shisen_tracker::decoder::{Counts, Decoder, Event, Message, Text};
use shisen_tracker::link;
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::fmt::Display;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use thiserror::Error;

/// Between samples of a recording without any time.
const UNTIMED_STEP: Micros = Micros(10_000);

/// How a recording is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordingFormat {
    /// A table.
    Csv,
    /// Frames of our link.
    Link,
}

impl RecordingFormat {
    /// By the file's extension: `.csv`, in any case, is a table.
    pub fn of(path: &Path) -> Self {
        let extension = path.extension();
        if extension.is_some_and(|found| found.eq_ignore_ascii_case("csv")) {
            Self::Csv
        } else {
            Self::Link
        }
    }
}

/// A recording that cannot be read or written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RecordingError {
    /// The system refuses it.
    #[error("{}: {reason}", path.display())]
    #[diagnostic(help("give the path of a file that you may read or write"))]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// No sample is in it.
    #[error("{} holds no sample", path.display())]
    #[diagnostic(help(
        "give a file that `shisen tracker record` wrote; a table needs the extension .csv"
    ))]
    Empty {
        /// Which.
        path: PathBuf,
    },
    /// The table has other columns.
    #[error("{}: line 1 is not the header of a recording", path.display())]
    #[diagnostic(help("give a table that `shisen tracker record` wrote; it has these columns: {}", header().join(",")))]
    Header {
        /// Which.
        path: PathBuf,
    },
    /// A cell cannot be used.
    #[error("{}: line {line}: {what}", path.display())]
    #[diagnostic(help(
        "numbers are finite, directions and quaternions have length 1, and a cell is empty where there is nothing"
    ))]
    Line {
        /// Which.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// What is wrong.
        what: String,
    },
}

/// What was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Samples, in the order of their arrival, messages, and what was damaged.
    pub events: Vec<Event>,
    /// What had become of the file when each of them came.
    pub counts: Vec<Counts>,
}

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, holds no sample, or a table with a cell
    /// that cannot be used. Damaged frames are [`Event::Dropped`].
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let bytes = std::fs::read(path).map_err(at(path))?;
        let recording = match RecordingFormat::of(path) {
            RecordingFormat::Csv => from_csv(path, &bytes)?,
            RecordingFormat::Link => from_link(&bytes),
        };
        if recording.samples().next().is_none() {
            return Err(RecordingError::Empty { path: path.into() });
        }
        Ok(recording)
    }

    /// The samples.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.events.iter().filter_map(|event| match event {
            Event::Sample(sample) => Some(sample),
            _ => None,
        })
    }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> RecordingError {
    let path = path.to_owned();
    move |reason| RecordingError::File { path, reason }
}

/// Writes a recording, event after event.
pub struct Recorder {
    path: PathBuf,
    to: To,
}

enum To {
    Csv(Box<csv::Writer<File>>),
    Link(BufWriter<File>, link::Encoder),
}

impl Recorder {
    /// Makes the file, or empties it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn create(path: &Path) -> Result<Self, RecordingError> {
        let file = File::create(path).map_err(at(path))?;
        let to = match RecordingFormat::of(path) {
            RecordingFormat::Csv => {
                let mut table = csv::Writer::from_writer(file);
                let written = table.write_record(header());
                written.map_err(|error| at(path)(error.into()))?;
                To::Csv(Box::new(table))
            }
            RecordingFormat::Link => To::Link(BufWriter::new(file), link::Encoder::new()),
        };
        let path = path.to_owned();
        Ok(Self { path, to })
    }

    /// Writes an event; a table takes samples alone. `lost` is how many of the
    /// device's records are missing so far, which a table does not say.
    ///
    /// # Errors
    /// Those of the system.
    pub fn push(&mut self, event: &Event, lost: u64) -> Result<(), RecordingError> {
        let written = match (&mut self.to, event) {
            (To::Csv(table), Event::Sample(sample)) => {
                table.write_record(Cells::of(sample).0).map_err(Into::into)
            }
            (To::Link(file, encoder), Event::Sample(sample)) => {
                let mut text = format!("{ARRIVAL}{}", sample.arrival.0);
                if lost > 0 {
                    let _ = write!(text, "{LOST}{lost}");
                }
                let text = Message::Text(Text::new(text.as_bytes()));
                let frames = [encoder.message(&text), encoder.sample(sample)];
                frames.iter().try_for_each(|frame| file.write_all(frame))
            }
            (To::Link(file, encoder), Event::Message(message)) => {
                file.write_all(&encoder.message(message))
            }
            _ => Ok(()),
        };
        written.map_err(at(&self.path))
    }

    /// Writes all that is still in memory.
    ///
    /// # Errors
    /// Those of the system.
    pub fn finish(mut self) -> Result<(), RecordingError> {
        let flushed = match &mut self.to {
            To::Csv(table) => table.flush(),
            To::Link(file, _) => file.flush(),
        };
        flushed.map_err(at(&self.path))
    }
}

const ARRIVAL: &str = "arrival ";
const LOST: &str = " lost ";

fn from_link(bytes: &[u8]) -> Recording {
    let mut decoder = link::Link::new();
    let mut times = Times::default();
    let (mut events, mut counts) = (Vec::new(), Vec::new());
    // Byte after byte, to know the counts at each event.
    for byte in bytes {
        decoder.feed(&[*byte], Micros(0), &mut |event| {
            events.extend(times.place(&event));
        });
        if counts.len() < events.len() {
            counts.push(times.without_own(*decoder.counts()));
        }
    }
    // The last frame may have been cut off.
    decoder.reset();
    if let Some(last) = counts.last_mut() {
        *last = times.without_own(*decoder.counts());
    }
    Recording { events, counts }
}

/// When the samples of a file of frames arrived.
#[derive(Default)]
struct Times {
    /// Of the next sample, as the text before it says.
    next: Option<Micros>,
    /// By the device's clock.
    first: Option<u64>,
    last: Option<Micros>,
    /// Such texts, which are no device's messages.
    own: u64,
    /// Records of the device that were missing when it was recorded.
    lost: u64,
}

impl Times {
    /// The event at its time; `None` of what only says a time.
    fn place(&mut self, event: &Event) -> Option<Event> {
        match *event {
            Event::Message(Message::Text(text)) if text.as_str().starts_with(ARRIVAL) => {
                let said = &text.as_str()[ARRIVAL.len()..];
                let (time, lost) = said.split_once(LOST).unwrap_or((said, "0"));
                self.next = time.parse().ok().map(Micros);
                self.lost = lost.parse().map_or(self.lost, |lost| self.lost.max(lost));
                self.own += 1;
                None
            }
            Event::Sample(mut sample) => {
                let device = sample.device_time.map(|time| time.microseconds);
                let by_device = device.map(|time| {
                    let first = *self.first.get_or_insert(time);
                    Micros(time.saturating_sub(first))
                });
                let untimed = self.last.map_or(Micros(0), |last| last.after(UNTIMED_STEP));
                let time = self.next.take().or(by_device).unwrap_or(untimed);
                // A recording does not go back.
                sample.arrival = self.last.map_or(time, |last| time.max(last));
                self.last = Some(sample.arrival);
                Some(Event::Sample(sample))
            }
            _ => Some(*event),
        }
    }

    fn without_own(&self, mut counts: Counts) -> Counts {
        counts.messages -= self.own;
        counts.lost = counts.lost.saturating_add(self.lost);
        counts
    }
}

const EYES: [&str; 3] = ["left", "right", "combined"];

/// The columns of a table.
fn header() -> Vec<String> {
    let mut names: Vec<String> = [
        "arrival_us",
        "device_us",
        "wraps_at_us",
        "sensor",
        "sequence",
        "gaze_frame",
        "head_x",
        "head_y",
        "head_z",
        "head_place_tracked",
        "head_qx",
        "head_qy",
        "head_qz",
        "head_qw",
        "head_turn_tracked",
        "head_wx",
        "head_wy",
        "head_wz",
    ]
    .map(String::from)
    .into();
    for eye in EYES {
        for name in [
            "origin_x",
            "origin_y",
            "origin_z",
            "origin_tracked",
            "direction_x",
            "direction_y",
            "direction_z",
            "direction_tracked",
            "pupil_m",
            "pupil_raw",
            "openness",
        ] {
            names.push(format!("{eye}_{name}"));
        }
    }
    names.extend(["point_kind", "point_x", "point_y", "point_tracked"].map(String::from));
    names
}

/// A line of a table.
struct Cells(Vec<String>);

impl Cells {
    fn of(sample: &Sample) -> Self {
        let mut cells = Self(Vec::new());
        cells.one(Some(sample.arrival.0));
        cells.one(sample.device_time.map(|time| time.microseconds));
        cells.one(sample.device_time.map(|time| time.wraps_at));
        cells.one(Some(sample.sensor));
        cells.one(sample.sequence);
        cells.one(Some(match sample.gaze_frame {
            GazeFrame::Head => "head",
            GazeFrame::Tracker => "tracker",
        }));
        let head = sample.head;
        cells.reading(head.position.map(|r| (r.value.to_array(), r.tracked)));
        cells.reading(head.orientation.map(|r| (r.value.to_array(), r.tracked)));
        cells.all(head.angular_velocity.map(|turn| turn.to_array()));
        for eye in [&sample.left, &sample.right, &sample.combined] {
            cells.reading(eye.origin.map(|r| (r.value.to_array(), r.tracked)));
            cells.reading(eye.direction.map(|r| (r.value.to_array(), r.tracked)));
            let (metres, raw) = match eye.pupil {
                Some(Pupil::Diameter(metres)) => (Some(metres), None),
                Some(Pupil::Raw(raw)) => (None, Some(raw)),
                None => (None, None),
            };
            cells.one(metres);
            cells.one(raw);
            cells.one(eye.openness);
        }
        let point = sample.gaze_point.map(|point| match point.value {
            GazePoint::Plane(p) => ("plane", p),
            GazePoint::Normalized(p) => ("normalized", p),
            GazePoint::Raw(p) => ("raw", p),
        });
        cells.one(point.map(|(kind, _)| kind));
        let tracked = sample.gaze_point.map(|point| point.tracked);
        cells.reading(
            point
                .zip(tracked)
                .map(|((_, p), tracked)| (p.to_array(), tracked)),
        );
        cells
    }

    fn one(&mut self, value: Option<impl Display>) {
        self.0
            .push(value.map_or(String::new(), |value| value.to_string()));
    }

    fn all<const N: usize>(&mut self, values: Option<[f32; N]>) {
        for i in 0..N {
            self.one(values.map(|values| values[i]));
        }
    }

    fn reading<const N: usize>(&mut self, reading: Option<([f32; N], bool)>) {
        self.all(reading.map(|(values, _)| values));
        self.one(reading.map(|(_, tracked)| u8::from(tracked)));
    }
}

fn from_csv(path: &Path, bytes: &[u8]) -> Result<Recording, RecordingError> {
    let mut table = csv::Reader::from_reader(bytes);
    let names = header();
    let same = table
        .headers()
        .is_ok_and(|found| found.iter().eq(names.iter()));
    if !same {
        return Err(RecordingError::Header { path: path.into() });
    }
    let (mut events, mut counts) = (Vec::new(), Vec::new());
    let mut last = Micros(0);
    for (number, record) in table.records().enumerate() {
        let line = number as u64 + 2;
        let wrong = |what: String| RecordingError::Line {
            path: path.into(),
            line,
            what,
        };
        let record = record.map_err(|error| wrong(error.to_string()))?;
        let mut cells = Reader {
            cells: record.iter(),
            names: names.iter(),
        };
        let sample = cells.sample().map_err(&wrong)?;
        if sample.arrival < last {
            return Err(wrong("arrival_us is below that of the line before".into()));
        }
        last = sample.arrival;
        events.push(Event::Sample(checked(&sample).map_err(&wrong)?));
        counts.push(Counts {
            samples: events.len() as u64,
            ..Counts::new()
        });
    }
    Ok(Recording { events, counts })
}

/// A sample that our link takes.
fn checked(sample: &Sample) -> Result<Sample, String> {
    let frame = link::Encoder::new().sample(sample);
    let mut found = Err("is no sample".to_owned());
    link::Link::new().feed(&frame, sample.arrival, &mut |event| {
        found = match event {
            Event::Sample(sample) => Ok(sample),
            Event::Dropped(dropped) => Err(format!("the sample is {}", dropped.reason.name())),
            _ => return,
        };
    });
    found
}

struct Reader<C, N> {
    cells: C,
    names: N,
}

impl<'a, C: Iterator<Item = &'a str>, N: Iterator<Item = &'a String>> Reader<C, N> {
    fn one<T: FromStr>(&mut self) -> Result<Option<T>, String> {
        let name = self.names.next().map_or("", |name| name);
        match self.cells.next() {
            None | Some("") => Ok(None),
            Some(text) => match text.parse() {
                Ok(value) => Ok(Some(value)),
                Err(_) => Err(format!("{name} is {text:?}")),
            },
        }
    }

    fn needed<T: FromStr>(&mut self, name: &str) -> Result<T, String> {
        self.one()?.ok_or_else(|| format!("{name} is empty"))
    }

    /// All of them or none.
    fn all<const N2: usize>(&mut self) -> Result<Option<[f32; N2]>, String> {
        let mut values = [None; N2];
        for value in &mut values {
            *value = self.one()?;
        }
        if values.iter().all(Option::is_none) {
            return Ok(None);
        }
        if values.contains(&None) {
            return Err("a vector has an empty part".into());
        }
        Ok(Some(values.map(Option::unwrap_or_default)))
    }

    fn reading<const N2: usize>(&mut self) -> Result<Option<([f32; N2], bool)>, String> {
        let values = self.all()?;
        let tracked = self.one::<u8>()?;
        Ok(values.map(|values| (values, tracked != Some(0))))
    }

    fn sample(&mut self) -> Result<Sample, String> {
        let arrival = self.needed("arrival_us")?;
        let mut sample = Sample::arrived(Micros(arrival));
        let (time, wraps_at) = (self.one()?, self.one()?);
        sample.device_time = time.map(|microseconds| DeviceTime {
            microseconds,
            wraps_at: wraps_at.unwrap_or(0),
        });
        sample.sensor = self.needed("sensor")?;
        sample.sequence = self.one()?;
        sample.gaze_frame = match self.needed::<String>("gaze_frame")?.as_str() {
            "head" => GazeFrame::Head,
            "tracker" => GazeFrame::Tracker,
            other => return Err(format!("gaze_frame is {other:?}, not head or tracker")),
        };
        let vector = |(value, tracked)| Reading {
            value: Vec3::from_array(value),
            tracked,
        };
        sample.head.position = self.reading()?.map(vector);
        let turn = self.reading()?;
        sample.head.orientation = turn.map(|(value, tracked)| Reading {
            value: Quat::from_array(value),
            tracked,
        });
        sample.head.angular_velocity = self.all()?.map(Vec3::from_array);
        for eye in [&mut sample.left, &mut sample.right, &mut sample.combined] {
            *eye = Eye {
                origin: self.reading()?.map(vector),
                direction: self.reading()?.map(vector),
                pupil: {
                    let metres = self.one()?.map(Pupil::Diameter);
                    let raw = self.one()?.map(Pupil::Raw);
                    metres.or(raw)
                },
                openness: self.one()?,
            };
        }
        let kind: Option<String> = self.one()?;
        let point = self.reading()?;
        if let Some((kind, (place, tracked))) = kind.zip(point) {
            let place = Vec2::from_array(place);
            let value = match kind.as_str() {
                "plane" => GazePoint::Plane(place),
                "normalized" => GazePoint::Normalized(place),
                "raw" => GazePoint::Raw(place),
                other => return Err(format!("point_kind is {other:?}")),
            };
            sample.gaze_point = Some(Reading { value, tracked });
        }
        Ok(sample)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::{Feed, Notice, Spec};

    fn recorded(spec: &str, name: &str) -> (Vec<Event>, Vec<Event>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let mut feed = Feed::open(&spec.parse::<Spec>().unwrap()).unwrap();
        let mut recorder = Recorder::create(&path).unwrap();
        let mut events = Vec::new();
        feed.poll(Micros::from_millis(2_000), &mut |notice| {
            if let Notice::Decoded(event) = notice {
                recorder.push(&event, 0).unwrap();
                events.push(*event);
            }
        });
        recorder.finish().unwrap();
        assert!(events.len() > 100, "{spec}");
        (events, Recording::read(&path).unwrap().events)
    }

    #[test]
    fn recordings_are_what_was_recorded() {
        for spec in [
            "mock",
            "mock:as=fastrak",
            "mock:as=iscan",
            "mock:as=hid",
            "mock:as=adhawk",
        ] {
            for name in ["a.csv", "a.CSV", "a.link"] {
                let (written, read) = recorded(spec, name);
                assert_eq!(written, read, "{spec} {name}");
            }
        }
    }

    /// Damage is counted as a line's would be that the frames came over.
    #[test]
    fn damage_in_a_recording_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.link");
        let spec = Spec::Replay(crate::tracker::ReplaySpec {
            path: path.clone(),
            head: None,
        });
        let mut recorder = Recorder::create(&path).unwrap();
        for i in 0..200 {
            let sample = Sample::arrived(Micros(1_000 * i));
            recorder.push(&Event::Sample(sample), 0).unwrap();
        }
        recorder.finish().unwrap();
        let intact = std::fs::read(&path).unwrap();
        let counts = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let mut feed = Feed::open(&spec).unwrap();
            let mut events = 0;
            feed.poll(Micros(u64::MAX), &mut |_| events += 1);
            assert!(feed.is_over());
            (feed.counts(), events)
        };
        let (all, events) = counts(&intact);
        assert_eq!((all.samples, all.messages, events), (200, 0, 200));
        assert_eq!((all.lost, all.dropped_bytes), (0, 0));
        let mut damaged = intact.clone();
        let length = damaged.len();
        for at in [length / 4, length / 2, length - 3] {
            damaged[at] ^= 0x10;
        }
        // Before the end, half a frame.
        damaged.truncate(length - 2);
        let mut live = link::Link::new();
        live.feed(&damaged, Micros(0), &mut |_| {});
        live.reset();
        let (found, events) = counts(&damaged);
        assert_eq!(found.dropped, live.counts().dropped);
        assert_eq!(found.dropped_bytes, live.counts().dropped_bytes);
        assert_eq!(found.lost, live.counts().lost);
        assert_eq!(found.bytes, damaged.len() as u64);
        assert!(found.dropped.iter().sum::<u32>() >= 3, "{found:?}");
        assert!(found.samples >= 195 && events > found.samples);
    }

    #[test]
    fn tables_that_cannot_be_used_say_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Recording::read(&path).unwrap_err().to_string()
        };
        assert!(read("x,y\n1,2\n").contains("line 1"));
        let head = header().join(",");
        assert!(read(&head).contains("holds no sample"));
        let mut cells = Cells::of(&Sample::arrived(Micros(5))).0;
        cells[5] = "mouse".into();
        let said = read(&format!("{head}\n{}\n", cells.join(",")));
        assert!(said.contains("line 2: gaze_frame is \"mouse\""), "{said}");
        cells[5] = "head".into();
        cells[10..14].clone_from_slice(&["0", "0", "0", "2"].map(String::from));
        let said = read(&format!("{head}\n{}\n", cells.join(",")));
        assert!(
            said.contains("line 2: the sample is no direction"),
            "{said}"
        );
    }
}
