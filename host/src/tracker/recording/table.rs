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
    let found = table.headers().cloned().unwrap_or_default();
    if !found.iter().eq(names.iter()) {
        let differs = |(found, name): (&str, &String)| found != name;
        let differing = found.iter().zip(&names).position(differs);
        let number = differing.unwrap_or(found.len().min(names.len()));
        let what = match names.get(number) {
            Some(name) => format!("column {} is not {name}", number + 1),
            None => format!("it has more than {number} columns"),
        };
        return Err(Fault::new(
            format!("{path}: line 1 is not the header of a recording: {what}"),
            "give a table that `shisen tracker record` wrote",
        ));
    }
    let mut events: Vec<(Event, Counts)> = Vec::new();
    let mut last = Micros(0);
    let mut record = csv::StringRecord::new();
    for line in 2.. {
        let wrong = |(what, help): Wrong| Fault::new(format!("{path}: line {line}: {what}"), help);
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
            Err(error) => {
                let what = match error.kind() {
                    csv::ErrorKind::UnequalLengths { len, .. } => {
                        let ending = if *len == 1 { "" } else { "s" };
                        format!("has {len} cell{ending}, not {}", names.len())
                    }
                    _ => "is not text in UTF-8".to_owned(),
                };
                let message = format!("{path}: line {line} {what}");
                return Err(Fault::new(message, "delete it, or record again"));
            }
        }
        let sample = Reader(names.iter().zip(&record)).sample().map_err(&wrong)?;
        if sample.arrival < last {
            let what = "arrival_us is below that of the line before";
            let help = "sort the lines by arrival_us, or delete this one";
            return Err(wrong((what.into(), help)));
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

/// What is wrong on a line, and what to do.
type Wrong = (String, &'static str);

/// Checks a sample by sending it over the link.
fn checked(sample: &Sample) -> Result<Sample, Wrong> {
    let frame = link::Encoder::new().sample(sample);
    let help = "numbers must be finite, and directions and quaternions of length 1";
    let mut found = Err(("the sample cannot be used".to_owned(), help));
    link::Link::new().feed(&frame, sample.arrival, &mut |event| {
        found = match event {
            Event::Sample(sample) => Ok(sample),
            Event::Dropped(dropped) => {
                Err((format!("the sample is {}", dropped.reason.name()), help))
            }
            _ => return,
        };
    });
    found
}

fn not_among(name: &str, text: &str, known: &str) -> Wrong {
    let what = format!("{name} is {text:?}, but it must be {known}");
    (what, "correct the cell, or delete the line")
}

/// Reads a cell, which may be empty.
fn parsed<T: FromStr>(name: &str, text: &str) -> Result<Option<T>, Wrong> {
    if text.is_empty() {
        return Ok(None);
    }
    let value = text.parse().map(Some);
    value.map_err(|_| match text.parse::<f64>() {
        // A number that T does not take: T is unsigned.
        Ok(_) => {
            let most = u64::MAX >> 64_usize.saturating_sub(8 * size_of::<T>());
            not_among(name, text, &format!("a whole number from 0 to {most}"))
        }
        Err(_) => not_among(name, text, "a number"),
    })
}

/// Names of columns with their cells.
struct Reader<I>(I);

impl<'a, I: Iterator<Item = (&'a String, &'a str)>> Reader<I> {
    fn one<T: FromStr>(&mut self) -> Result<Option<T>, Wrong> {
        let cell = self.0.next();
        cell.map_or(Ok(None), |(name, text)| parsed(name, text))
    }

    fn needed<T: FromStr>(&mut self, name: &str) -> Result<T, Wrong> {
        let help = "every line needs arrival_us, sensor and gaze_frame: fill it in, or delete the \
                    line";
        self.one()?
            .ok_or_else(|| (format!("{name} is empty"), help))
    }

    /// Reads a vector; all of its cells are empty or none.
    fn all<const N: usize>(&mut self) -> Result<Option<[f32; N]>, Wrong> {
        let mut values = [None; N];
        let mut empty = None;
        for value in &mut values {
            let Some((name, text)) = self.0.next() else {
                break;
            };
            *value = parsed(name, text)?;
            empty = value.map_or(Some(name), |_: f32| empty);
        }
        match empty {
            Some(_) if values.iter().all(Option::is_none) => Ok(None),
            Some(name) => Err((
                format!("{name} is empty, but not all of its vector"),
                "fill in all cells of a vector, or leave all of them empty",
            )),
            None => Ok(Some(values.map(Option::unwrap_or_default))),
        }
    }

    fn reading<const N: usize>(&mut self) -> Result<Option<([f32; N], bool)>, Wrong> {
        let values = self.all()?;
        let tracked = self.one::<u8>()?;
        Ok(values.map(|values| (values, tracked != Some(0))))
    }

    fn sample(&mut self) -> Result<Sample, Wrong> {
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
            other => return Err(not_among("gaze_frame", other, "head or tracker")),
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
                other => {
                    return Err(not_among("point_kind", other, "plane, normalized or raw"));
                }
            };
            sample.gaze_point = Some(Reading { value, tracked });
        }
        Ok(sample)
    }
}
