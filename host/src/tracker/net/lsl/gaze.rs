//! What a stream's channels say of the gaze.

use crate::files::Fault;
use crate::tracker::net::spec::GazeSpec;
use glam::{DVec2, DVec3, Quat, Vec3};
use shisen_tracker::net::lsl::{Info, Record, Value};
use shisen_tracker::sample::{GazeFrame, GazePoint, Reading, Sample};

/// Labels of a direction's axes without their last letter, and whether they are a camera's: +X to
/// the right, +Y down and +Z ahead. Capitals and other signs than letters and digits do not count.
const DIRECTIONS: [(&str, bool); 4] = [
    ("gazepoint3d", true),
    ("gazedirection", false),
    ("direction", false),
    ("gazenormal", false),
];

/// Likewise of a point's.
const POINTS: [&str; 5] = ["gaze", "screen", "normpos", "gazepoint", ""];

/// The axes of a camera in ours.
const CAMERA: Quat = Quat::from_xyzw(1.0, 0.0, 0.0, 0.0);

/// The channels of the gaze.
#[derive(Debug, Clone)]
pub(super) struct Gaze {
    channels: Vec<usize>,
    confidence: Option<usize>,
    least_confidence: f64,
    is_zero_lost: bool,
    meaning: Meaning,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    /// A direction in these axes.
    Direction(Quat),
    /// Pixels of a camera of these focal lengths and this principal point.
    Camera([f64; 4]),
    /// A point of a screen of so many columns and rows.
    Screen { size: DVec2, is_upward: bool },
}

impl Gaze {
    /// Finds a stream's channels by their labels.
    pub(super) fn find(spec: &GazeSpec, info: &Info, labels: &[String]) -> Result<Self, Fault> {
        let channels = usize::from(info.channels);
        // With some labels missing it is not known which channels have the others.
        let labels = if labels.len() == channels {
            labels
        } else {
            &[]
        };
        let found = Labels { labels, channels };
        let confidence = match &spec.confidence {
            Some(label) => Some(found.given("confidence", label)?),
            None => found.usual("confidence"),
        };
        let is_point = spec.camera.is_some() || spec.screen.is_some();
        let (channels, meaning) = match found.axes(spec, is_point)? {
            Some((axes, is_camera)) if axes.len() == 3 => {
                let usual = if is_camera { CAMERA } else { Quat::IDENTITY };
                let directions = spec.directions.unwrap_or(usual);
                (axes, Meaning::Direction(directions))
            }
            Some((axes, _)) => match (spec.camera, &spec.screen) {
                (Some(camera), _) => (axes, Meaning::Camera(camera)),
                (None, Some(_)) => {
                    let size = spec.pixels.map_or(DVec2::ONE, DVec2::from);
                    let is_upward = spec.is_upward;
                    (axes, Meaning::Screen { size, is_upward })
                }
                (None, None) => {
                    return Err(Fault::new(
                        format!(
                            "the x and y of the stream {:?} may be pixels of a scene camera or a \
                             place on a screen",
                            info.name
                        ),
                        "give camera=FX,FY,CX,CY, or screen=WALL and, unless they are 0 to 1, \
                         pixels=COLUMNS,ROWS",
                    ));
                }
            },
            None => {
                return Err(Fault::new(
                    format!("the stream {:?} has no channels that are known", info.name),
                    format!(
                        "name them with x=, y= and, for a direction, z=: {}",
                        found.in_words()
                    ),
                ));
            }
        };
        Ok(Self {
            channels,
            confidence,
            least_confidence: spec.least_confidence,
            is_zero_lost: spec.is_zero_lost,
            meaning,
        })
    }

    /// Returns the gaze of a record.
    pub(super) fn sample(&self, record: &Record<'_>) -> Sample {
        let numbers: Vec<f64> = record.values().map(number).collect();
        let of = |channel: usize| numbers.get(channel).copied().unwrap_or(f64::NAN);
        let mut sample = Sample::arrived(record.arrival);
        sample.device_time = Some(record.device_time());
        sample.gaze_frame = GazeFrame::Head;
        let [x, y, z] = [0, 1, 2].map(|axis| self.channels.get(axis).map_or(0.0, |&at| of(at)));
        let is_sure = (self.confidence).is_none_or(|channel| of(channel) >= self.least_confidence);
        let is_zero = self.is_zero_lost && x == 0.0 && y == 0.0;
        let is_seen = is_sure && !is_zero && x.is_finite() && y.is_finite() && z.is_finite();
        match self.meaning {
            Meaning::Screen { size, is_upward } => {
                let mut place = DVec2::new(x, y) / size;
                if is_upward {
                    place.y = 1.0 - place.y;
                }
                let value = GazePoint::Normalized(if is_seen {
                    place.as_vec2()
                } else {
                    glam::Vec2::ZERO
                });
                let tracked = is_seen;
                sample.gaze_point = Some(Reading { value, tracked });
            }
            Meaning::Direction(axes) => {
                let direction = DVec3::new(x, y, z).normalize_or_zero().as_vec3();
                set(&mut sample, axes * direction, is_seen);
            }
            Meaning::Camera([fx, fy, cx, cy]) => {
                let ahead = DVec3::new((x - cx) / fx, (cy - y) / fy, -1.0);
                set(&mut sample, ahead.normalize_or_zero().as_vec3(), is_seen);
            }
        }
        sample
    }
}

fn number(value: Value<'_>) -> f64 {
    match value {
        Value::Number(number) => number,
        Value::Integer(number) => number as f64,
        Value::Text(_) => f64::NAN,
    }
}

fn set(sample: &mut Sample, direction: Vec3, is_seen: bool) {
    let is_unit = (direction.length_squared() - 1.0).abs() < 1.0e-3;
    sample.combined.direction = Some(if is_seen && is_unit {
        Reading::tracked(direction.normalize())
    } else {
        Reading::held(Vec3::NEG_Z)
    });
}

/// The labels of a stream's channels, if it has them.
struct Labels<'a> {
    labels: &'a [String],
    channels: usize,
}

impl Labels<'_> {
    /// Returns the channel of a label, or of a number that is no label.
    fn given(&self, key: &str, label: &str) -> Result<usize, Fault> {
        let mut same = (0..self.labels.len()).filter(|at| self.labels[*at] == label);
        let fault = |message: String| Err(Fault::new(message, self.in_words()));
        match (same.next(), same.next()) {
            (Some(one), None) => Ok(one),
            (Some(_), Some(_)) => fault(format!(
                "{key}={label:?}: several channels have this label; give the number of one"
            )),
            _ => match label.parse() {
                Ok(number) if number < self.channels => Ok(number),
                _ => fault(format!("{key}={label:?}: no channel has this label")),
            },
        }
    }

    /// Returns the only channel of a usual label.
    fn usual(&self, label: &str) -> Option<usize> {
        let plain = |text: &String| {
            let letters = text.chars().filter(char::is_ascii_alphanumeric);
            letters.collect::<String>().to_ascii_lowercase()
        };
        let mut same = (0..self.labels.len()).filter(|at| plain(&self.labels[*at]) == label);
        let one = same.next()?;
        same.next().is_none().then_some(one)
    }

    /// Returns the channels of x, y and, for a direction, z, and whether they are a camera's.
    fn axes(&self, spec: &GazeSpec, is_point: bool) -> Result<Option<(Vec<usize>, bool)>, Fault> {
        let given = spec.axes.iter().zip(["x", "y", "z"]);
        let given = given.filter_map(|(label, key)| Some(self.given(key, label.as_ref()?)));
        let given = given.collect::<Result<Vec<usize>, Fault>>()?;
        let (count, is_in_order) = (
            given.len(),
            spec.axes[0].is_some() && spec.axes[1].is_some(),
        );
        if count > 0 {
            return if is_in_order && (count == 2 || !is_point) {
                Ok(Some((given, false)))
            } else {
                let help =
                    "a direction has x=, y= and z=, a point of a camera or a screen x= and y=";
                Err(Fault::new("x, y and z do not go together", help))
            };
        }
        let all = |stem: &str, axes: &[&str]| {
            let channels = axes.iter().map(|axis| self.usual(&format!("{stem}{axis}")));
            channels.collect::<Option<Vec<usize>>>()
        };
        if !is_point {
            for (stem, is_camera) in DIRECTIONS {
                if let Some(found) = all(stem, &["x", "y", "z"]) {
                    return Ok(Some((found, is_camera)));
                }
            }
        }
        let points = POINTS.iter().find_map(|stem| all(stem, &["x", "y"]));
        Ok(points.map(|found| (found, false)))
    }

    fn in_words(&self) -> String {
        if self.labels.is_empty() {
            return format!(
                "its {} channels have no labels: give their numbers, from 0",
                self.channels
            );
        }
        format!("its channels are {}", self.labels.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::with_help;
    use crate::tracker::{LslSpec, NetSpec, Spec, TrackerKind};
    use shisen_tracker::net::lsl::{Feed, Format, Received, read_info};
    use shisen_tracker::time::Micros;

    fn spec(options: &str) -> GazeSpec {
        let spec: Spec = format!("lsl:type=Gaze?{options}").parse().unwrap();
        match spec.kind {
            TrackerKind::Net(NetSpec::Lsl(LslSpec { gaze, .. })) => gaze,
            _ => panic!("it is a stream"),
        }
    }

    fn info(channels: usize) -> Info {
        let field = |tag: &str, text: &str| format!("<{tag}>{text}</{tag}>");
        let text = [
            field("name", "eyes"),
            field("type", "Gaze"),
            field("channel_count", &channels.to_string()),
            field("channel_format", "double64"),
            field("nominal_srate", "0"),
            field("uid", "1"),
            field("v4data_port", "1"),
            field("v4service_port", "1"),
        ];
        read_info(&format!("<info>{}</info>", text.concat())).unwrap()
    }

    /// Returns the gaze of one record.
    fn gaze(options: &str, labels: &str, numbers: &[f64]) -> Result<Sample, String> {
        let labels: Vec<String> = labels.split_whitespace().map(str::to_owned).collect();
        let found = Gaze::find(&spec(options), &info(numbers.len()), &labels);
        let found = found.map_err(|fault| with_help(&fault))?;
        let mut bytes = b"LSL/110 200 OK\r\nByte-Order: 1234\r\n\r\n".to_vec();
        for offset in [4, 2] {
            bytes.push(2);
            bytes.extend_from_slice(&123_456.789_f64.to_le_bytes());
            for channel in 0..numbers.len() {
                let sign = if channel.is_multiple_of(2) { 1.0 } else { -1.0 };
                let number = sign * (16_777_217.0 + f64::from(offset) + channel as f64);
                bytes.extend_from_slice(&number.to_le_bytes());
            }
        }
        bytes.push(2);
        bytes.extend_from_slice(&2.5_f64.to_le_bytes());
        for number in numbers {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        let mut sample = None;
        let mut feed = Feed::new(Format::Double64, numbers.len() as u8, 0.0);
        feed.feed(&bytes, Micros(7), &mut |received| {
            if let Received::Record(record) = received {
                sample = Some(found.sample(&record));
            }
        });
        Ok(sample.unwrap())
    }

    #[test]
    fn channels_are_found_by_labels_or_settings() {
        let direction = |options: &str, labels: &str, numbers: &[f64]| {
            gaze(options, labels, numbers)
                .unwrap()
                .combined
                .direction
                .unwrap()
        };
        let near = |found: Reading<Vec3>, x: f32, y: f32| {
            let expected = Vec3::new(x, y, -1.0).normalize();
            assert!(
                found.tracked && found.value.distance(expected) < 1e-6,
                "{found:?}"
            );
        };
        // Pupil Capture: millimetres before the scene camera, +Y down.
        let pupil =
            "confidence norm_pos_x norm_pos_y gaze_point_3d_x gaze_point_3d_y gaze_point_3d_z";
        near(
            direction("", pupil, &[0.9, 0.5, 0.5, 100.0, -200.0, 1_000.0]),
            0.1,
            0.2,
        );
        for lost in [
            [0.5, 0.5, 0.5, 100.0, -200.0, 1_000.0],
            [0.9, 0.5, 0.5, f64::NAN, -200.0, 1_000.0],
            [0.9, 0.5, 0.5, 0.0, 0.0, 0.0],
        ] {
            assert!(!direction("", pupil, &lost).tracked, "{lost:?}");
        }
        near(
            direction(
                "least_confidence=0.4",
                pupil,
                &[0.5, 0.5, 0.5, 0.0, 0.0, 9.0],
            ),
            0.0,
            0.0,
        );
        let axes = "x=a&y=b&z=2&axes=right,down,forward";
        near(direction(axes, "a b c", &[0.1, -0.2, 1.0]), 0.1, 0.2);
        // Neon: pixels of the scene camera.
        let camera = "camera=800,400,800,600";
        near(direction(camera, "x y", &[880.0, 520.0]), 0.1, 0.2);
        // A screen in pixels and in parts.
        let place = |options: &str, labels: &str, numbers: &[f64]| {
            let point = gaze(options, labels, numbers).unwrap().gaze_point.unwrap();
            (point.value.numbers().to_array(), point.tracked)
        };
        let screen = "screen=front&pixels=1000,500";
        let eyelink = "screen=front&pixels=1000,500&x=rightEyeX&y=rightEyeY";
        assert_eq!(
            place(screen, "gaze_x gaze_y", &[250.0, 250.0]),
            ([0.25, 0.5], true)
        );
        let labels = "leftEyeX leftEyeY rightEyeX rightEyeY";
        assert_eq!(
            place(eyelink, labels, &[0.0, 0.0, 500.0, 125.0]),
            ([0.5, 0.25], true)
        );
        let upward = "screen=front&origin=bottom";
        assert_eq!(
            place(upward, "norm_pos_x norm_pos_y", &[0.25, 0.25]),
            ([0.25, 0.75], true)
        );
        let zero = "screen=front&lost=zero";
        assert!(!place(zero, "x y", &[0.0, 0.0]).1 && place(screen, "x y", &[0.0, 0.0]).1);
        for (options, labels, says) in [
            ("", "x y", "give camera=FX,FY,CX,CY, or screen=WALL"),
            (
                "",
                "left right",
                "name them with x=, y= and, for a direction, z=: its channels are",
            ),
            ("", "", "its 2 channels have no labels: give their numbers"),
            (
                "x=up&y=down",
                "left right",
                "x=\"up\": no channel has this label; its channels are",
            ),
            ("x=a&y=1", "a a", "several channels have this label"),
            ("x=a", "a b", "x, y and z do not go together"),
        ] {
            let error = gaze(options, labels, &[0.0, 0.0]).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
    }
}
