//! `shisen dome warp`: what a projector has to show on a dome.

use crate::cave::warp::{Nodes, Projector, Warp, WarpError, bourke, mpcdi};
use crate::cave::{Cave, DomeScreen};
use crate::cli::arguments::{PictureSize, WallsName};
use crate::cli::output::failure::{Failure, Fault};
use crate::cli::output::print;
use crate::files::write_atomically;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// Writes the warp that a projector needs to carry its part of a dome master
///
/// The projector's light is followed to the dome's inside. The dome master is
/// the one that `shisen cave` renders for the same dome; a viewer anywhere in
/// it sees it right. Where light misses the dome nothing is drawn, elsewhere
/// everything in full: there is no edge blending.
///
/// bourke is Bourke's mesh, type 2: nodes from the lower left one, row by row,
/// each x, y (−1 to 1 upwards, x by the picture's width by height), u, v (the
/// dome master's square, 0 to 1 from the lower left) and i, 1 on the dome and −1
/// where nothing is drawn. mpcdi is MPCDI 1.0, profile a3: the points of the
/// dome, metres in the room, as a PFM, and a PNG of where they are.
///
/// The projector's TOML file has name, position (metres), look and, if wanted,
/// up, or else any of `yaw_degrees` (to the right), `pitch_degrees` (upwards)
/// and `roll_degrees` (clockwise), `horizontal_degrees` or throw (distance by
/// width), `vertical_degrees` if pixels are not square, `lens_shift` (widths to
/// the right, heights upwards) and resolution (columns and rows).
///
/// With --json, one object: path, format, profile (of mpcdi, else null), dome,
/// projector, columns and rows (of nodes), drawn (nodes that meet the dome) and
/// share (drawn of all).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// dome (a hemisphere of 2.5 m over the floor, its centre 1.5 m under the
    /// origin), or a TOML file of walls and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "dome",
          value_parser = WallsName::parser())]
    walls: WallsName,
    /// Which dome [default: the only one]
    #[arg(long, value_name = "NAME")]
    dome: Option<String>,
    /// TOML file of the projector
    #[arg(long, value_name = "FILE")]
    projector: PathBuf,
    /// Columns and rows of nodes [default: 80x60 for bourke, the projector's
    /// resolution for mpcdi]
    #[arg(long, value_name = "COLUMNSxROWS")]
    grid: Option<PictureSize>,
    /// What to write
    #[arg(long, value_enum)]
    format: Format,
    /// The file
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--format`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Bourke's mesh for image warping
    Bourke,
    /// MPCDI 1.0, profile a3
    Mpcdi,
}

impl Format {
    const fn name(self) -> &'static str {
        match self {
            Self::Bourke => "bourke",
            Self::Mpcdi => "mpcdi",
        }
    }
}

/// What was written.
#[derive(Debug, Serialize)]
struct Report {
    path: String,
    format: &'static str,
    profile: Option<&'static str>,
    dome: String,
    projector: String,
    columns: u32,
    rows: u32,
    drawn: u64,
    share: f64,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A warp has no pixels of the dome.
    let cave = arguments.walls.cave([1; 2])?;
    let dome = dome(arguments, &cave)?;
    let projector = Projector::load(&arguments.projector)?;
    let (nodes, grid) = match arguments.format {
        Format::Bourke => (Nodes::Corners, [80, 60]),
        Format::Mpcdi => (Nodes::Centres, projector.resolution()),
    };
    let grid = arguments.grid.map_or(grid, |grid| grid.0);
    let warp = Warp::new(dome, &projector, grid, nodes).map_err(|error| match error {
        WarpError::Grid { .. } => Failure::usage(&error.to_string()),
        other => other.into(),
    })?;
    let path = &arguments.out;
    write_atomically(path, |file| match arguments.format {
        Format::Bourke => bourke::write(&warp, file),
        Format::Mpcdi => mpcdi::write(&warp, file),
    })
    .map_err(Fault::write(path))?;
    let drawn = warp.drawn();
    let [columns, rows] = grid;
    let report = Report {
        path: path.display().to_string(),
        format: arguments.format.name(),
        profile: (arguments.format == Format::Mpcdi).then_some("a3"),
        dome: dome.name().to_owned(),
        projector: projector.name().to_owned(),
        columns,
        rows,
        drawn,
        share: drawn as f64 / (f64::from(columns) * f64::from(rows)),
    };
    print(&report, arguments.json)
}

/// The dome that is asked for.
fn dome<'a>(arguments: &Arguments, cave: &'a Cave) -> Result<&'a DomeScreen, Failure> {
    let names: Vec<&str> = cave.domes.iter().map(DomeScreen::name).collect();
    let found = match (&arguments.dome, cave.domes.as_slice()) {
        (None, [only]) => Some(only),
        (None, _) => None,
        (Some(name), domes) => domes.iter().find(|dome| dome.name() == name),
    };
    found.ok_or_else(|| {
        let names = names.join(", ");
        Failure::usage(&match (&arguments.dome, cave.domes.is_empty()) {
            (_, true) => "there is no dome in --walls: give a file with a [[dome]]".to_owned(),
            (None, _) => format!("there are several domes: give --dome, one of {names}"),
            (Some(name), _) => format!("there is no dome \"{name}\": give --dome, one of {names}"),
        })
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} × {} nodes of projector {} on dome {}, {:.1} % on the dome",
            self.path,
            self.columns,
            self.rows,
            self.projector,
            self.dome,
            100.0 * self.share
        )
    }
}
