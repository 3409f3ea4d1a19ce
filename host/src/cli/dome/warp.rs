//! `shisen dome warp`: the picture that a projector has to show on a dome.

use crate::cave::DomeScreen;
use crate::cave::warp::{Nodes, Projector, Warp, WarpError, bourke, mpcdi};
use crate::cli::arguments::{WallsName, picture_size};
use crate::cli::prelude::*;
use crate::files::write_atomically;

/// Writes the warp with which a projector shows its part of a dome master
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// dome (a hemisphere of 2.5 m on the floor, whose centre is 1.5 m below the origin), or a
    /// TOML file of walls and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "dome")]
    walls: WallsName,
    /// Name of the dome [default: the only one]
    #[arg(long, value_name = "NAME")]
    dome: Option<String>,
    /// TOML file of the projector
    #[arg(long, value_name = "FILE")]
    projector: PathBuf,
    /// Columns and rows of nodes [default: 80x60 for bourke, the projector's resolution for mpcdi]
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = picture_size)]
    grid: Option<[u32; 2]>,
    /// Format of the file
    #[arg(long, value_enum)]
    format: Format,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Format {
    /// Bourke's mesh for image warping
    Bourke,
    /// MPCDI 1.0, profile a3
    Mpcdi,
}

/// A warp.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// File of the warp.
    path: String,
    /// bourke or mpcdi.
    format: Format,
    /// Profile of MPCDI; null for bourke.
    profile: Option<&'static str>,
    /// Name of the dome.
    dome: String,
    /// Name of the projector.
    projector: String,
    /// Columns of nodes.
    columns: u32,
    /// Rows of nodes.
    rows: u32,
    /// Nodes whose light meets the dome.
    drawn: u64,
    /// Share of these nodes.
    share: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A warp does not depend on the dome's pixels.
    let cave = arguments.walls.cave([1; 2])?;
    let dome = dome(arguments, &cave)?;
    let projector = Projector::load(&arguments.projector)?;
    let (nodes, grid) = match arguments.format {
        Format::Bourke => (Nodes::Corners, [80, 60]),
        Format::Mpcdi => (Nodes::Centres, projector.resolution()),
    };
    let grid = arguments.grid.unwrap_or(grid);
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
        format: arguments.format,
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

fn dome<'a>(arguments: &Arguments, cave: &'a Cave) -> Result<&'a DomeScreen, Failure> {
    let names: Vec<&str> = cave.domes.iter().map(DomeScreen::name).collect();
    let found = match (&arguments.dome, cave.domes.as_slice()) {
        (None, [only]) => Some(only),
        (None, _) => None,
        (Some(name), domes) => domes.iter().find(|dome| dome.name() == name),
    };
    found.ok_or_else(|| {
        let names = names.join(", ");
        match (&arguments.dome, cave.domes.is_empty()) {
            (_, true) => misuse!("there is no dome in --walls: give a file with a [[dome]]"),
            (None, _) => misuse!("there are several domes: give --dome, one of {names}"),
            (Some(name), _) => misuse!("there is no dome \"{name}\": give --dome, one of {names}"),
        }
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, columns, rows) = (&self.path, self.columns, self.rows);
        let (projector, dome, percent) = (&self.projector, &self.dome, 100.0 * self.share);
        write!(f, "{path}: {columns} × {rows} nodes of projector ")?;
        write!(f, "{projector} on dome {dome}, {percent:.1} % on the dome")
    }
}
