//! `shisen room import`: walls from rooms of nDisplay.

use crate::cave::Wall;
use crate::cave::import::ImportedRoom;
use crate::cli::prelude::*;
use crate::files::{UNREAD, read_text, write_atomically};

/// Takes the walls from a room of nDisplay
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The .ndisplay file
    file: PathBuf,
    /// File of the room to write, for --walls
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Pixels along each side of a screen whose file does not say
    #[arg(long, value_name = "PIXELS", default_value_t = 1024,
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    size: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// An imported room.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Walls.
    walls: Vec<WallReport>,
    /// What the file has besides, which is not taken.
    ignored: Vec<String>,
    /// Sentences about walls not at right angles and open seams.
    remarks: Vec<String>,
    /// File of the room.
    path: String,
}

/// An imported wall.
#[derive(Debug, Serialize, JsonSchema)]
struct WallReport {
    /// Name.
    name: String,
    /// Columns and rows.
    pixels: [u32; 2],
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = &arguments.file;
    let text = read_text(file).map_err(|reason| {
        Fault::new(format!("{}: cannot read: {reason}", file.display()), UNREAD)
    })?;
    let room = ImportedRoom::from_ndisplay(&text, [arguments.size; 2])?;
    let path = &arguments.out;
    write_atomically(path, |out| out.write_all(room.to_toml().as_bytes()))
        .map_err(Fault::write(path))?;
    let cave = Cave::new(room.walls)?;
    let walls = cave.walls.iter().map(|wall| WallReport {
        name: wall.name.clone(),
        pixels: wall.pixels,
    });
    let report = Report {
        walls: walls.collect(),
        ignored: room.ignored,
        remarks: cave.skewed().into_iter().chain(cave.open_seams()).collect(),
        path: path.display().to_string(),
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.walls.iter().map(|wall| wall.name.as_str()).collect();
        write!(f, "{}: the walls {}", self.path, names.join(", "))?;
        if !self.ignored.is_empty() {
            write!(f, "\nnot taken: {}", self.ignored.join("; "))?;
        }
        self.remarks
            .iter()
            .try_for_each(|remark| write!(f, "\n{remark}"))
    }
}
