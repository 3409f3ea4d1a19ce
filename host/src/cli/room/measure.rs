//! `shisen room measure`: corners of walls from lengths that a tape gives.

use crate::cave::look::Point;
use crate::cave::measure::{Measurement, Odds, Quantity, Survey};
use crate::cli::prelude::*;
use crate::files::write_atomically;

/// Finds the corners of walls from lengths that a tape gives
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// TOML file of walls by their corners' names, and of lengths
    file: PathBuf,
    /// File of the room to write, for --walls
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Place of the room's origin, metres from the first wall's lower left corner: to the right,
    /// upwards, to the back. The head is there without --head [default: the middle of all corners]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    origin: Option<Point>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A measured room.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Corners, in the order in which walls name them.
    corners: Vec<CornerReport>,
    /// Walls, in the order of the file.
    walls: Vec<WallReport>,
    /// Lengths, heights and flatness, in the order of the file.
    measurements: Vec<MeasurementReport>,
    /// Number of unknown coordinates.
    unknowns: usize,
    /// Names of the measurements that stand out, the worst first.
    measure_again: Vec<String>,
    /// Standardised residual from which a measurement stands out.
    noticeable: f64,
    /// Slip in one length of the simulated trials, millimetres.
    slip_mm: f64,
    /// Share of trials in which the slipped length alone stands out.
    slip_named_alone: f64,
    /// Share of trials in which the slipped length stands out with others.
    slip_named_among: f64,
    /// Share of trials in which only other lengths stand out.
    slip_named_wrongly: f64,
    /// Place of the written room's origin, metres.
    origin_m: [f64; 3],
    /// File of the room, or null.
    path: Option<String>,
}

/// A corner.
#[derive(Debug, Serialize, JsonSchema)]
struct CornerReport {
    /// Name.
    name: String,
    /// To the right, upwards and to the back, metres from the first wall's lower left corner.
    position_m: [f64; 3],
    /// Standard deviation along each axis, millimetres.
    sigma_mm: f64,
}

/// A wall.
#[derive(Debug, Serialize, JsonSchema)]
struct WallReport {
    /// Name.
    name: String,
    /// Width of the parallelogram, metres.
    width_m: f64,
    /// Height of the parallelogram, metres.
    height_m: f64,
    /// Angle between its lower and its left edge, degrees.
    angle_degrees: f64,
    /// Distance of the upper right corner from where a parallelogram of the other three has it,
    /// millimetres. Each corner of the written wall is a quarter of it off.
    deviation_mm: f64,
    /// Name of the upper right corner.
    upper_right: String,
}

/// A measurement.
#[derive(Debug, Serialize, JsonSchema)]
struct MeasurementReport {
    /// length, height or flatness.
    kind: &'static str,
    /// Name.
    name: String,
    /// Measured value, metres.
    measured_m: f64,
    /// Standard deviation, millimetres.
    sigma_mm: f64,
    /// Value at the corners found less the measured value, millimetres.
    residual_mm: f64,
    /// Residual by its own standard deviation.
    standardised: f64,
    /// Share of an error that shows in this residual, 0 to 1.
    redundancy: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let survey = Survey::load(&arguments.file)?;
    let origin = arguments.origin.map_or(survey.middle(), |point| point.0);
    if let Some(path) = &arguments.out {
        let text = survey.to_toml(origin)?;
        write_atomically(path, |file| file.write_all(text.as_bytes()))
            .map_err(Fault::write(path))?;
    }
    let corners = survey.corners.iter().map(|corner| CornerReport {
        name: corner.name.clone(),
        position_m: corner.position.to_array(),
        sigma_mm: 1000.0 * corner.sigma,
    });
    // The sizes of walls do not depend on where the origin is.
    let cave = survey.cave(origin, [1; 2])?;
    let walls = cave.walls.iter().zip(&survey.walls);
    let walls = walls.map(|(wall, measured)| WallReport {
        name: wall.name.clone(),
        width_m: wall.lower_left.distance(wall.lower_right),
        height_m: wall.lower_left.distance(wall.upper_left),
        angle_degrees: wall.angle_degrees(),
        deviation_mm: 1000.0 * survey.deviation(measured),
        upper_right: survey.corners[measured.corners[2]].name.clone(),
    });
    let suspects = survey.suspects().into_iter();
    let suspects = suspects.map(|number| survey.measurements[number].name.clone());
    let report = Report {
        corners: corners.collect(),
        walls: walls.collect(),
        measurements: survey
            .measurements
            .iter()
            .map(MeasurementReport::new)
            .collect(),
        unknowns: survey.unknowns,
        measure_again: suspects.collect(),
        noticeable: Survey::NOTICEABLE,
        slip_mm: 1000.0 * Odds::SLIP,
        slip_named_alone: survey.odds.alone,
        slip_named_among: survey.odds.among,
        slip_named_wrongly: survey.odds.wrong,
        origin_m: origin.to_array(),
        path: arguments
            .out
            .as_ref()
            .map(|path| path.display().to_string()),
    };
    print(&report, arguments.json)
}

impl MeasurementReport {
    fn new(one: &Measurement) -> Self {
        Self {
            kind: match one.quantity {
                Quantity::Length(_) => "length",
                Quantity::Height(_) => "height",
                Quantity::Flatness(_) => "flatness",
            },
            name: one.name.clone(),
            measured_m: one.measured,
            sigma_mm: 1000.0 * one.sigma,
            residual_mm: 1000.0 * one.residual,
            standardised: one.standardised,
            redundancy: one.redundancy,
        }
    }
}

impl Report {
    /// Says what to measure again, and how sure that is.
    fn advice(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sizes: Vec<&MeasurementReport> = self.measurements.iter().collect();
        sizes.sort_by(|a, b| b.standardised.abs().total_cmp(&a.standardised.abs()));
        let (largest, limit) = (sizes[0], self.noticeable);
        match self.measure_again.as_slice() {
            [] => write!(
                f,
                "\nNothing stands out: the largest standardised residual is {:.1} ({}), and good \
                 sets stay under {limit}.",
                largest.standardised, largest.name
            )?,
            [name] => write!(
                f,
                "\nMeasure {name} again: it stands out with {:.1}, the next ({}) with {:.1}; good \
                 sets stay under {limit}. Its value is kept until you change it.",
                largest.standardised, sizes[1].name, sizes[1].standardised
            )?,
            names => write!(
                f,
                "\nMeasure {} again: they stand out about equally (up to {:.1}; good sets stay \
                 under {limit}), so one of them is wrong and fits badly with the others. Their \
                 values are kept until you change them.",
                names.join(", "),
                largest.standardised
            )?,
        }
        let percent = |share: f64| (100.0 * share).round();
        let missed = 1.0 - self.slip_named_alone - self.slip_named_among - self.slip_named_wrongly;
        write!(
            f,
            "\nHow sure that is, of simulated slips of {} mm in one length: {} % are named alone, \
             {} % with others, {} % not at all, and in {} % only wrong lengths are named.",
            self.slip_mm,
            percent(self.slip_named_alone),
            percent(self.slip_named_among),
            percent(missed.max(0.0)),
            percent(self.slip_named_wrongly)
        )?;
        let unchecked = self.measurements.iter();
        let unchecked = unchecked.filter(|one| one.redundancy < Survey::UNCHECKED);
        let unchecked: Vec<&str> = unchecked.map(|one| one.name.as_str()).collect();
        if !unchecked.is_empty() {
            let names = unchecked.join(", ");
            write!(
                f,
                "\nNothing checks {names}: add diagonals through the room, or flat_mm."
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:<9}{:>10}{:>10}{:>10}{:>9}",
            "corner", "right", "up", "back", "sigma"
        )?;
        for corner in &self.corners {
            // Tenths of a millimetre, and no minus before a zero.
            let [x, y, z] = corner
                .position_m
                .map(|metres| (1e4 * metres).round() / 1e4 + 0.0);
            let (name, sigma) = (&corner.name, corner.sigma_mm);
            write!(
                f,
                "\n{name:<9}{x:>8.4} m{y:>8.4} m{z:>8.4} m{sigma:>6.1} mm"
            )?;
        }
        write!(
            f,
            "\n\n{:<9}{:>10}{:>10}{:>10}  off a parallelogram",
            "wall", "width", "height", "angle"
        )?;
        for wall in &self.walls {
            let (name, width, height) = (&wall.name, wall.width_m, wall.height_m);
            let (angle, off, corner) = (wall.angle_degrees, wall.deviation_mm, &wall.upper_right);
            write!(f, "\n{name:<9}{width:>8.4} m{height:>8.4} m{angle:>9.2}°")?;
            write!(f, "{off:>6.1} mm at {corner}")?;
        }
        write!(
            f,
            "\n\n{:<9}{:<9}{:>10}{:>9}{:>10}{:>13}{:>9}",
            "kind", "name", "measured", "sigma", "residual", "standardised", "checked"
        )?;
        for one in &self.measurements {
            let (kind, name, sigma) = (one.kind, &one.name, one.sigma_mm);
            let (measured, residual) = (one.measured_m, one.residual_mm);
            write!(
                f,
                "\n{kind:<9}{name:<9}{measured:>8.4} m{sigma:>6.1} mm{residual:>7.1} mm"
            )?;
            let (standardised, percent) = (one.standardised, 100.0 * one.redundancy);
            write!(f, "{standardised:>13.2}{percent:>7.0} %")?;
        }
        let (count, unknowns) = (self.measurements.len(), self.unknowns);
        write!(
            f,
            "\n\n{count} measurements for {unknowns} unknown coordinates."
        )?;
        self.advice(f)?;
        if let Some(path) = &self.path {
            let [x, y, z] = self.origin_m;
            write!(
                f,
                "\n{path}: the room, its origin {x:.3} m to the right, {y:.3} m above and "
            )?;
            write!(f, "{z:.3} m behind {}", self.corners[0].name)?;
        }
        Ok(())
    }
}
