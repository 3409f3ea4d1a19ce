//! `shisen room show`: a room drawn to scale.

use crate::cave::look::{Point, ViewDirection};
use crate::cave::plan::{Beam, Plan};
use crate::cave::{DEFAULT_INTERPUPILLARY_DISTANCE, Screen};
use crate::cli::arguments::WallsName;
use crate::cli::prelude::*;
use crate::files::write_atomically;
use glam::DVec3;

/// Draws a room to scale: plan, elevations, fields of view
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// three-wall, cube, dome, or a TOML file of walls, domes, cylinders and projectors
    #[arg(value_name = "NAME|FILE")]
    walls: WallsName,
    /// File of the drawing, SVG, an A4 page
    #[arg(short, long, value_name = "FILE", default_value = "room.svg")]
    out: PathBuf,
    /// Pixels along each side of a wall or dome whose file does not say
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = whole::<u32>(1..=crate::cave::Wall::MOST_PIXELS))]
    size: u32,
    /// Position of the head in the room, metres
    #[arg(
        long,
        value_name = "X,Y,Z",
        default_value = "0,0,0",
        allow_hyphen_values = true
    )]
    head: Point,
    /// Where the viewer looks: front, floor, right, left, back, ceiling, YAW,PITCH in degrees, or
    /// a direction X,Y,Z
    #[arg(
        long,
        value_name = "DIRECTION",
        default_value = "front",
        allow_hyphen_values = true
    )]
    look: ViewDirection,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A drawn room.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Screens, in the order of their pictures.
    screens: Vec<ScreenReport>,
    /// Projectors, in the order of the file.
    projectors: Vec<ProjectorReport>,
    /// What is unusual: skewed walls, open seams, screens that the viewer does not see.
    remarks: Vec<String>,
    /// File of the drawing.
    path: String,
}

/// A screen.
#[derive(Debug, Serialize, JsonSchema)]
struct ScreenReport {
    /// Name.
    name: String,
    /// Width of a wall, diameter of a dome, way along a cylinder: metres.
    width_m: f64,
    /// Height of a wall or a cylinder, diameter of a dome: metres.
    height_m: f64,
    /// Angle between its left and right edges from the viewer's place, degrees; null where the
    /// viewer does not see its front.
    horizontal_degrees: Option<f64>,
    /// Angle between its lower and upper edges, likewise.
    vertical_degrees: Option<f64>,
}

/// A projector.
#[derive(Debug, Serialize, JsonSchema)]
struct ProjectorReport {
    /// Name.
    name: String,
    /// Name of its screen.
    screen: String,
    /// Position of its lens in the room, metres; null where the room does not say.
    position_m: Option<[f64; 3]>,
    /// Share of its picture that lies on the screen, 0 to 1.
    share: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cave = arguments.walls.cave_without_remarks([arguments.size; 2])?;
    let (head, look) = (arguments.head.0, arguments.look.basis());
    let half = 0.5 * DEFAULT_INTERPUPILLARY_DISTANCE * look.right;
    let mut remarks: Vec<String> = cave.skewed().into_iter().chain(cave.open_seams()).collect();
    remarks.extend(cave.uneven_meshes()?);
    for screen in cave.screens() {
        // Not `check_eye`: that names the first screen alone.
        remarks.extend(screen.view_from(head).err().map(|fault| fault.to_string()));
    }
    let beams = Beam::all(&cave)?;
    let title = match &arguments.walls {
        WallsName::BuiltIn(which) => which.name().to_owned(),
        WallsName::File(path) | WallsName::Text(path, _) => path.display().to_string(),
    };
    let plan = Plan {
        title: &title,
        cave: &cave,
        eyes: [head - half, head + half],
        look,
        beams: &beams,
        remarks: &remarks,
    };
    let (path, svg) = (&arguments.out, plan.svg());
    write_atomically(path, |file| file.write_all(svg.as_bytes())).map_err(Fault::write(path))?;
    let report = Report {
        screens: cave
            .screens()
            .map(|screen| ScreenReport::new(screen, head))
            .collect(),
        projectors: beams.iter().map(ProjectorReport::new).collect(),
        remarks,
        path: path.display().to_string(),
    };
    print(&report, arguments.json)
}

impl ScreenReport {
    fn new(screen: Screen<'_>, head: DVec3) -> Self {
        let [width_m, height_m] = match screen {
            Screen::Wall(wall) => {
                let [lower_left, lower_right, _, upper_left] = wall.corners();
                [lower_right, upper_left].map(|corner| corner.distance(lower_left))
            }
            Screen::Dome(dome) => [2.0 * dome.radius; 2],
            Screen::Cylinder(cylinder) => {
                let [low, high] = cylinder.height;
                [cylinder.width(), high - low]
            }
        };
        let field = screen.field_from(head);
        Self {
            name: screen.name().to_owned(),
            width_m,
            height_m,
            horizontal_degrees: field.map(|[across, _]| across),
            vertical_degrees: field.map(|[_, upward]| upward),
        }
    }
}

impl ProjectorReport {
    fn new(beam: &Beam<'_>) -> Self {
        Self {
            name: beam.projector.name.clone(),
            screen: beam.screen.name().to_owned(),
            position_m: beam.lens().map(|place| place.to_array()),
            share: beam.share,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:<12}{:>10}{:>10}{:>13}{:>11}",
            "screen", "width", "height", "horizontal", "vertical"
        )?;
        for screen in &self.screens {
            let (name, width, height) = (&screen.name, screen.width_m, screen.height_m);
            write!(f, "\n{name:<12}{width:>8.3} m{height:>8.3} m")?;
            match (screen.horizontal_degrees, screen.vertical_degrees) {
                (Some(across), Some(upward)) => write!(f, "{across:>12.1}°{upward:>10.1}°")?,
                _ => write!(f, "{:>24}", "not from its front")?,
            }
        }
        for projector in &self.projectors {
            let (name, screen, percent) = (&projector.name, &projector.screen, projector.share);
            write!(
                f,
                "\nprojector {name}: {:.0} % on {screen}",
                100.0 * percent
            )?;
        }
        for remark in &self.remarks {
            write!(f, "\n{remark}")?;
        }
        write!(f, "\n{}: drawn to scale", self.path)
    }
}
