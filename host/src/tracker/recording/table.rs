//! Recordings as tables, one line a sample.

use super::Recording;
use crate::files::Fault;
use glam::{Quat, Vec2, Vec3};
use shisen_tracker::decoder::{Counts, Decoder, DropReason, Event};
use shisen_tracker::link;
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

const EYES: [&str; 3] = ["left", "right", "combined"];

/// The columns before those of the eyes, those of each eye, and those after them.
const COLUMNS: [&str; 3] = [
    "arrival_us device_us wraps_at_us sensor sequence gaze_frame head_x head_y head_z \
     head_place_tracked head_qx head_qy head_qz head_qw head_turn_tracked head_wx head_wy head_wz",
    "origin_x origin_y origin_z origin_tracked direction_x direction_y direction_z \
     direction_tracked pupil_m pupil_raw openness",
    "point_kind point_x point_y point_tracked",
];

pub(super) fn header() -> Vec<String> {
    let [before, of_eye, after] = COLUMNS.map(str::split_whitespace);
    let eyes = EYES.into_iter();
    let eyes = eyes.flat_map(|eye| of_eye.clone().map(move |name| format!("{eye}_{name}")));
    let before = before.map(String::from);
    before.chain(eyes).chain(after.map(String::from)).collect()
}

pub(super) fn cells(sample: &Sample) -> Vec<String> {
    Cells::new(sample).0
}

struct Cells(Vec<String>);

impl Cells {
    fn new(sample: &Sample) -> Self {
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
        let point = sample.gaze_point.map(|point| {
            let (kind, place) = match point.value {
                GazePoint::Plane(place) => ("plane", place),
                GazePoint::Normalized(place) => ("normalized", place),
                GazePoint::Raw(place) => ("raw", place),
            };
            (kind, (place.to_array(), point.tracked))
        });
        cells.one(point.map(|(kind, _)| kind));
        cells.reading(point.map(|(_, reading)| reading));
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

/// Reads the table of a file; a last line that was cut off is dropped and counted.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Recording, Fault> {
    let mut table = csv::Reader::from_reader(bytes);
    let (path, names) = (path.display(), header());
    let found = table.headers();
    if !found.is_ok_and(|found| found.iter().eq(names.iter())) {
        let columns = names.join(",");
        return Err(Fault::new(
            format!("{path}: line 1 is not the header of a recording"),
            format!("give a table that `shisen tracker record` wrote, with the columns {columns}"),
        ));
    }
    let mut events: Vec<(Event, Counts)> = Vec::new();
    let mut last = Micros(0);
    let mut record = csv::StringRecord::new();
    for line in 2.. {
        let wrong = |what: String| {
            Fault::new(
                format!("{path}: line {line}: {what}"),
                "each line has a cell for each column, empty where there is nothing; numbers are \
                 finite, directions and quaternions have length 1",
            )
        };
        match table.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(_)
                if table.position().byte() == bytes.len() as u64
                    && !bytes.ends_with(b"\n")
                    && !events.is_empty() =>
            {
                let begin = bytes.iter().rposition(|&byte| byte == b'\n');
                let cut = bytes.len() - begin.map_or(0, |begin| begin + 1);
                if let Some((_, last)) = events.last_mut() {
                    last.dropped[DropReason::Truncated as usize] += 1;
                    last.dropped_bytes += cut as u64;
                }
                break;
            }
            Err(error) => return Err(wrong(error.to_string())),
        }
        let sample = Reader(names.iter().zip(&record)).sample().map_err(&wrong)?;
        if sample.arrival < last {
            return Err(wrong("arrival_us is below that of the line before".into()));
        }
        last = sample.arrival;
        let counts = Counts {
            samples: events.len() as u64 + 1,
            ..Counts::new()
        };
        events.push((Event::Sample(checked(&sample).map_err(&wrong)?), counts));
    }
    Ok(Recording { events })
}

/// Checks a sample by sending it over the link.
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

/// Names of columns with their cells.
struct Reader<I>(I);

impl<'a, I: Iterator<Item = (&'a String, &'a str)>> Reader<I> {
    fn one<T: FromStr>(&mut self) -> Result<Option<T>, String> {
        let Some((name, text)) = self.0.next().filter(|(_, text)| !text.is_empty()) else {
            return Ok(None);
        };
        let value = text.parse().map(Some);
        value.map_err(|_| format!("{name} is {text:?}"))
    }

    fn needed<T: FromStr>(&mut self, name: &str) -> Result<T, String> {
        self.one()?.ok_or_else(|| format!("{name} is empty"))
    }

    /// Reads a vector; all of its cells are empty or none.
    fn all<const N: usize>(&mut self) -> Result<Option<[f32; N]>, String> {
        let mut values = [None; N];
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

    fn reading<const N: usize>(&mut self) -> Result<Option<([f32; N], bool)>, String> {
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
