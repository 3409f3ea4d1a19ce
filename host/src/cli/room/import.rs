//! `shisen room import`: another program's screens as a room file.

use crate::cave::{Wall, ndisplay};
use crate::cli::prelude::*;
use crate::files::{self, write_atomically};

/// Writes the screens of an nDisplay configuration as a room file
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// nDisplay's configuration: JSON, as .ndisplay
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Room file to write
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Pixels along each side of a screen that no viewport shows
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
    /// Room file.
    path: String,
    /// Names of its walls.
    walls: Vec<String>,
    /// What was not read: a sentence each.
    ignored: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = &arguments.file;
    let text = files::read_text(file).map_err(|reason| {
        let message = format!("{}: cannot read: {reason}", file.display());
        Fault::new(message, files::UNREAD)
    })?;
    let imported = ndisplay::read(&text, [arguments.size; 2])?;
    let walls = &imported.cave.walls;
    let path = &arguments.out;
    write_atomically(path, |to| {
        walls.iter().try_for_each(|wall| {
            let [lower_left, lower_right, upper_left] =
                [wall.lower_left, wall.lower_right, wall.upper_left].map(|c| c.to_array());
            writeln!(
                to,
                "[[wall]]\nname = {:?}\nlower_left = {lower_left:?}\nlower_right = \
                 {lower_right:?}\nupper_left = {upper_left:?}\npixels = {:?}\n",
                wall.name, wall.pixels
            )
        })
    })
    .map_err(Fault::write(path))?;
    let report = Report {
        path: path.display().to_string(),
        walls: walls.iter().map(|wall| wall.name.clone()).collect(),
        ignored: imported.ignored,
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path, self.walls.join(", "))?;
        self.ignored
            .iter()
            .try_for_each(|one| write!(f, "\nnot read: {one}"))
    }
}
