//! `shisen dome warp`: the picture that a projector has to show on a dome or a wall.

use crate::cli::arguments::{WallsName, picture_size};
use crate::cli::prelude::*;
use crate::files::write_atomically;
use crate::projection::warp::{Nodes, Warp, bourke, mpcdi};
use crate::projection::{Blend, Projector};

/// Writes the warp with which a projector shows its part of a screen's picture
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// dome (a hemisphere of 2.5 m on the floor, whose centre is 1.5 m below the origin), or a
    /// TOML file of walls and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "dome")]
    walls: WallsName,
    /// Name of the dome or wall [default: the projector's, or the only one]
    #[arg(long, value_name = "NAME", alias = "dome")]
    screen: Option<String>,
    /// Name of a projector of --walls, which is blended with its neighbours, or a TOML file of one
    #[arg(long, value_name = "NAME|FILE")]
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
    /// MPCDI 2.0, profile a3
    Mpcdi2,
}

/// A warp.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// File of the warp.
    path: String,
    /// bourke, mpcdi or mpcdi2.
    format: Format,
    /// Profile of MPCDI; null for bourke.
    profile: Option<&'static str>,
    /// Name of the dome or wall.
    screen: String,
    /// Name of the projector.
    projector: String,
    /// Columns of nodes.
    columns: u32,
    /// Rows of nodes.
    rows: u32,
    /// Nodes whose light meets the screen.
    drawn: u64,
    /// Share of these nodes.
    share: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    // A warp does not depend on the screen's pixels.
    let mut cave = arguments.walls.cave([1; 2])?;
    let name = projector_of(arguments, &mut cave)?;
    let blends = cave.blends()?;
    let named = |blend: &&Blend<'_>| blend.projectors().any(|one| one.name == name);
    let blend = blends.iter().find(named);
    let blend = blend.ok_or_else(|| misuse!("there is no projector \"{name}\""))?;
    let projector = blend.projectors().find(|one| one.name == name);
    let resolution = projector.map_or([1; 2], |one| one.resolution);
    let (nodes, grid) = match arguments.format {
        Format::Bourke => (Nodes::Corners, [80, 60]),
        Format::Mpcdi | Format::Mpcdi2 => (Nodes::Centres, resolution),
    };
    let grid = arguments.grid.unwrap_or(grid);
    let warp = Warp::new(blend, &name, grid, nodes).map_err(|error| match error.key {
        "grid" => Failure::usage(&error.to_string()),
        _ => error.into(),
    })?;
    let path = &arguments.out;
    write_atomically(path, |file| match arguments.format {
        Format::Bourke => bourke::write(&warp, file),
        Format::Mpcdi => mpcdi::write(&warp, mpcdi::Version::One, file),
        Format::Mpcdi2 => mpcdi::write(&warp, mpcdi::Version::Two, file),
    })
    .map_err(Fault::write(path))?;
    let drawn = warp.drawn();
    let [columns, rows] = grid;
    let report = Report {
        path: path.display().to_string(),
        format: arguments.format,
        profile: (arguments.format != Format::Bourke).then_some("a3"),
        screen: warp.screen().name().to_owned(),
        projector: name,
        columns,
        rows,
        drawn,
        share: drawn as f64 / (f64::from(columns) * f64::from(rows)),
    };
    print(&report, arguments.json)
}

/// Returns the projector's name, which the room has then: with its neighbours, or alone from a file.
fn projector_of(arguments: &Arguments, cave: &mut Cave) -> Result<String, Failure> {
    let file = &arguments.projector;
    let is_named = |one: &&Projector| Some(one.name.as_str()) == file.to_str();
    if let Some(projector) = cave.projectors.iter().find(is_named) {
        return Ok(projector.name.clone());
    }
    let mut projector = Projector::load(file)?;
    if arguments.screen.is_some() {
        projector.screen.clone_from(&arguments.screen);
    }
    let name = projector.name.clone();
    cave.projectors.clear();
    let added = cave.add_projector(projector);
    added.map_err(
        |error| match (error.key, error.help().map(|help| help.to_string())) {
            ("screen", Some(help)) => misuse!("{error}: {help}"),
            _ => error.into(),
        },
    )?;
    Ok(name)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, columns, rows) = (&self.path, self.columns, self.rows);
        let (projector, screen, percent) = (&self.projector, &self.screen, 100.0 * self.share);
        write!(f, "{path}: {columns} × {rows} nodes of projector ")?;
        write!(f, "{projector} on {screen}, {percent:.1} % on the screen")
    }
}
