//! `shisen gaze`: the levels of directions.

use crate::cave::look::{LookError, Point, ViewDirection};
use crate::cli::arguments::face_range;
use crate::cli::output;
use crate::cli::prelude::*;
use crate::render::gaze_reference::{self, Limits};
use glam::{DVec3, Vec3};
use shisen_core::gaze::{
    Boundary, Detail, FaceRange, Gaze, LineOfSight, VisualField, VisualFieldError as Error,
    VisualFieldLimits, Zone,
};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};

/// Most bytes in a line, so that a line without an end does not fill the memory.
const LONGEST_LINE: u64 = 4096;

/// Computes the level of detail of directions by the viewer's gaze
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Where the viewer looks: X,Y,Z of any length but zero, or as in `shisen cave --look`
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,-1", allow_hyphen_values = true,
          value_parser = vector)]
    look: DVec3,
    /// Where the top of the viewer's head points, not parallel to --look [default: 0,1,0, or as in
    /// `shisen cave` for a look straight up or down]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    up: Option<DVec3>,
    /// Reflections and refractions at level 1
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u8>(0..=u8::MAX))]
    reflect_max: u8,
    /// Faces of a mesh at level 0 and at level 1
    #[arg(long, value_name = "MIN..MAX", default_value = "500..5804", value_parser = face_range)]
    faces: FaceRange,
    /// Curve that joins the limits of the visual field
    #[arg(long, value_enum, default_value = "printed")]
    boundary: BoundaryChoice,
    /// Radius of the central field, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, value_parser = up_to(180.0))]
    central: f64,
    /// Limit of the visual field upwards, at most 90 degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = up_to(90.0))]
    field_up: f64,
    /// Limit downwards, at most 90 degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 70.0, value_parser = up_to(90.0))]
    field_down: f64,
    /// Limit to the left, at most 180 degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 100.0, value_parser = up_to(180.0))]
    field_left: f64,
    /// Limit to the right, at most 180 degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 100.0, value_parser = up_to(180.0))]
    field_right: f64,
    /// Compute in double precision, by the reference for the tracer's single precision
    #[arg(long)]
    f64: bool,
    /// Print one JSON object a direction
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BoundaryChoice {
    /// Equation 7 as printed
    Printed,
    /// The ellipse through the limits
    Ellipse,
}

/// Returns the parser of a vector as given, not rounded to unit length.
fn vector(text: &str) -> Result<DVec3, LookError> {
    match text.parse() {
        Ok(Point(vector)) if vector != DVec3::ZERO => Ok(vector),
        _ => text.parse().map(|look: ViewDirection| look.vector()),
    }
}

/// Returns the parser of degrees above 0.
fn up_to(most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.trim().parse().ok();
        number
            .filter(|degrees| *degrees > 0.0 && *degrees <= most)
            .ok_or_else(|| format!("give more than 0 and at most {most} degrees"))
    }
}

/// Puts into words an error of the limits in degrees, with the names of the options.
fn in_degrees(error: Error) -> String {
    match error {
        Error::BelowCentral {
            side,
            limit,
            central,
        } => format!(
            "--field-{side} {:.4} is within the central field, --central {:.4}: give a larger \
             limit or a smaller central field",
            limit.to_degrees(),
            central.to_degrees()
        ),
        Error::TooFar { side, limit, most } => format!(
            "--field-{side} {:.4}: give at most {:.0} degrees",
            limit.to_degrees(),
            most.to_degrees()
        ),
        Error::Central { central } => format!(
            "--central {}: give 0.0001 degrees or more",
            central.to_degrees()
        ),
        other => other.to_string(),
    }
}

/// The level of detail of one direction.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Line<T> {
    /// Angle from the line of sight to the right, radians.
    m_alpha: T,
    /// Angle from the line of sight upwards, radians.
    m_beta: T,
    /// Distance of the direction from the line of sight, radians.
    l: T,
    /// Distance of the visual field's border in the same direction, radians.
    big_l: T,
    /// Level of detail, 0 to 1.
    level: T,
    /// central, peripheral or outside.
    zone: &'static str,
    /// Reflections and refractions that a ray follows.
    bounces: u8,
    /// Faces of the mesh that a ray sees.
    faces: u32,
}

/// Makes a line of a direction's sight in either precision.
macro_rules! line {
    ($sight:expr, $bounces:expr, $faces:expr) => {
        Line {
            m_alpha: $sight.m_alpha,
            m_beta: $sight.m_beta,
            l: $sight.l,
            big_l: $sight.big_l,
            level: $sight.level,
            zone: match $sight.zone {
                Zone::Central => "central",
                Zone::Peripheral => "peripheral",
                Zone::Outside => "outside",
            },
            bounces: $bounces,
            faces: $faces,
        }
    };
}

/// The visual field in both precisions, and the largest bounces and faces.
struct Levels {
    single: Gaze,
    double: gaze_reference::Gaze,
    most_bounces: u8,
    faces: FaceRange,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let levels = Levels::new(arguments)?;
    let mut fault = None;
    let written = output::write(|stdout| {
        let mut output = BufWriter::new(stdout);
        fault = levels.of_input(arguments, &mut output)?;
        output.flush()
    });
    // A wrong line counts even if nobody reads the output.
    if let Some(fault) = fault {
        return Err(fault.into());
    }
    written?;
    Ok(())
}

impl Levels {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let boundary = match arguments.boundary {
            BoundaryChoice::Printed => Boundary::Printed,
            BoundaryChoice::Ellipse => Boundary::Ellipse,
        };
        let limits = Limits {
            central: arguments.central.to_radians(),
            up: arguments.field_up.to_radians(),
            down: arguments.field_down.to_radians(),
            left: arguments.field_left.to_radians(),
            right: arguments.field_right.to_radians(),
        };
        let field = VisualFieldLimits {
            central: limits.central as f32,
            up: limits.up as f32,
            down: limits.down as f32,
            left: limits.left as f32,
            right: limits.right as f32,
        };
        let field = VisualField::new(field, boundary);
        let field = field.map_err(|error| Failure::usage(&in_degrees(error)))?;
        let look = arguments.look;
        let up = match arguments.up {
            Some(up) => up,
            // As if the viewer had bowed, or leaned back.
            None if look.x.hypot(look.z) <= 1.0e-6 * look.y.abs() => DVec3::new(0.0, 0.0, look.y),
            None => DVec3::Y,
        };
        let sight = LineOfSight::new(Vec3::ZERO, single(look), single(up)).or_misuse()?;
        Ok(Self {
            single: Gaze::new(sight, field),
            double: gaze_reference::Gaze::new(look, up, limits, boundary).or_misuse()?,
            most_bounces: arguments.reflect_max,
            faces: arguments.faces,
        })
    }

    /// Prints a line for each direction, up to a wrong one.
    fn of_input(
        &self,
        arguments: &Arguments,
        output: &mut impl Write,
    ) -> io::Result<Option<Fault>> {
        if !arguments.json {
            writeln!(output, "{HEADING}")?;
        }
        let mut input = BufReader::new(io::stdin().lock());
        let mut bytes = Vec::new();
        for line in 1.. {
            // A program that sends one direction at a time waits for the answer.
            if input.buffer().is_empty() {
                output.flush()?;
            }
            bytes.clear();
            let mut limited = input.by_ref().take(LONGEST_LINE);
            let read = match limited.read_until(b'\n', &mut bytes) {
                Ok(0) => break,
                Ok(read) => read as u64,
                Err(reason) => {
                    return Ok(Some(Fault::new(
                        format!("cannot read line {line} from standard input: {reason}"),
                        "send the directions through a pipe or from a file: shisen gaze < FILE",
                    )));
                }
            };
            let given = String::from_utf8_lossy(&bytes);
            let given = given.split('#').next().unwrap_or_default().trim();
            let direction = if read == LONGEST_LINE && bytes.last() != Some(&b'\n') {
                Err(format!("is longer than {LONGEST_LINE} bytes"))
            } else if given.is_empty() {
                continue;
            } else {
                direction(given)
            };
            let json = arguments.json;
            let printed = direction.and_then(|direction| {
                let printed = if arguments.f64 {
                    self.double(direction).map(|line| line.print(json, output))
                } else {
                    self.single(direction).map(|line| line.print(json, output))
                };
                printed.ok_or_else(|| "points nowhere".to_owned())
            });
            match printed {
                Ok(printed) => printed?,
                Err(reason) => {
                    let given: String = given.chars().take(80).collect();
                    let given = given.escape_debug();
                    return Ok(Some(Fault::new(
                        format!("line {line} of the input, \"{given}\", {reason}"),
                        "write one direction a line: three finite numbers, not all 0, separated by \
                         blanks or commas, such as 0.5 0 -1",
                    )));
                }
            }
        }
        Ok(None)
    }

    fn single(&self, direction: DVec3) -> Option<Line<f32>> {
        let sight = self.single.sight(single(direction))?;
        let detail = Detail::of_level(sight.level)?;
        let bounces = detail.bounces(self.most_bounces);
        Some(line!(sight, bounces, detail.faces(self.faces)))
    }

    fn double(&self, direction: DVec3) -> Option<Line<f64>> {
        let sight = self.double.sight(direction)?;
        let bounces = gaze_reference::bounces(sight.level, self.most_bounces);
        let (min, max) = (self.faces.min(), self.faces.max());
        let faces = gaze_reference::faces(sight.level, min, max);
        Some(line!(sight, bounces, faces))
    }
}

/// Rounds a vector to single precision. Scales it by a power of two if its components do not fit.
fn single(v: DVec3) -> Vec3 {
    let largest = v.abs().max_element();
    if (1.0e-30..=1.0e30).contains(&largest) {
        return v.as_vec3();
    }
    let (_, exponent) = libm::frexp(largest);
    DVec3::from_array(v.to_array().map(|x| libm::scalbn(x, -exponent))).as_vec3()
}

fn direction(text: &str) -> Result<DVec3, String> {
    let parts: Vec<&str> = text.split(',').collect();
    if parts.len() > 1 && parts.iter().any(|part| part.trim().is_empty()) {
        return Err("has no number beside a comma".into());
    }
    let mut numbers = Vec::new();
    for word in parts.into_iter().flat_map(str::split_whitespace) {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => numbers.push(number),
            Ok(_) => return Err(format!("has {word}, which is not finite")),
            Err(_) => return Err(format!("has {word:?}, which is no number")),
        }
    }
    match numbers[..] {
        [0.0, 0.0, 0.0] => Err("is zero and points nowhere".into()),
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("has {} numbers, not 3", numbers.len())),
    }
}

const HEADING: &str =
    "  m_alpha    m_beta         l         L     level  zone        bounces  faces";

impl<T: Copy + Into<f64> + Serialize> Line<T> {
    /// Prints a JSON object, or a row of the table with angles in degrees.
    fn print(&self, json: bool, output: &mut impl Write) -> io::Result<()> {
        if json {
            serde_json::to_writer(&mut *output, self)?;
            return writeln!(output);
        }
        for angle in [self.m_alpha, self.m_beta, self.l, self.big_l] {
            write!(output, "{:>8.3}° ", angle.into().to_degrees())?;
        }
        let (zone, bounces, faces) = (self.zone, self.bounces, self.faces);
        let level: f64 = self.level.into();
        writeln!(output, "{level:>9.6}  {zone:<10} {bounces:>8} {faces:>6}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_of_any_length_fit_single_precision() {
        let v = DVec3::new(0.1, -0.7, 0.3);
        assert_eq!(single(v), v.as_vec3());
        for power in [-1000, -200, 200, 1000] {
            let scaled = single(v * 2f64.powi(power));
            let ratio = scaled / single(v);
            assert!(scaled.is_finite() && ratio.x == ratio.y && ratio.y == ratio.z);
        }
    }
}
