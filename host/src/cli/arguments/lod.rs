//! Arguments of commands in which detail may follow the gaze.

use crate::bake::simplify::PolygonLevels;
use crate::bake::{BakedScene, Layout};
use crate::cave::Eye;
use crate::cave::look::Point;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source::{Loaded, bake};
use crate::cli::arguments::{LevelArguments, Without};
use crate::cli::output::failure::Failure;
use crate::cli::output::warn;
use crate::render::Observer;
use clap::{Arg, Args, ValueEnum};
use glam::DVec3;
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField};

/// How detail follows the gaze.
#[derive(Debug, Clone, Args)]
pub struct LodArguments {
    /// What follows the gaze: detail falls with the distance from the line of
    /// sight, and nothing outside the visual field is traced. Polygon levels
    /// are those that the scene was baked with, or else as --faces and --levels
    /// say [default: off]
    #[arg(long, value_enum, default_value = "off", hide_default_value = true,
          default_value_ifs = [("fill", "capture", "paper"), ("fill", "previous", "paper")])]
    lod: Choice,
    #[command(flatten)]
    levels: LevelArguments,
    /// What is up for the gaze that --lod follows [default: as --look and
    /// --head-report say]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<Point>,
    /// A point that both eyes look at, metres, in the room: with --lod each
    /// then has a line of sight of its own [default: one for both, along
    /// --look]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    fixate: Option<Point>,
}

/// `--lod`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Choice {
    /// Nothing: everything is traced in full
    Off,
    /// The paper's levels, with the border of the field as it prints it
    Paper,
    /// The paper's levels, with the border of the field as the half-ellipses
    /// that it describes
    PaperEllipse,
    /// How many pixels have a ray: in the periphery as few as acuity makes out, and
    /// more where they differ. Each is traced in full
    Foveated,
}

impl Choice {
    /// As it is written on a command line.
    const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Paper => "paper",
            Self::PaperEllipse => "paper-ellipse",
            Self::Foveated => "foveated",
        }
    }
}

/// The argument `--lod` of what counts the rays of every pixel.
pub fn of_every_pixel(lod: Arg) -> Arg {
    lod.value_parser(Without::<Choice>::new(&["foveated"]))
}

impl LodArguments {
    /// A scene, with the polygon levels that are asked for.
    ///
    /// # Errors
    /// Of usage: levels without a gaze that they could follow, or for a scene
    /// that has its own; a scene that cannot be baked.
    pub fn baked(&self, scene: Loaded, name: &str) -> Result<BakedScene, Failure> {
        match scene {
            Loaded::Baked(baked) => {
                self.accept(&baked, name)?;
                Ok(baked)
            }
            Loaded::Described(scene) => {
                let levels = self.polygon_levels()?;
                Ok(bake(&scene, name, Layout::Fast, levels.as_ref())?)
            }
        }
    }

    /// The polygon levels to bake in the layout for hosts, where any are asked
    /// for.
    ///
    /// # Errors
    /// Of usage: levels without a gaze that they could follow.
    fn polygon_levels(&self) -> Result<Option<PolygonLevels>, Failure> {
        match self.levels.given() {
            _ if self.is_on() => self.levels.polygon_levels(Layout::Fast).map(Some),
            Some(argument) => Err(Failure::usage(&format!(
                "{argument} is for --lod paper, paper-ellipse or foveated: with --lod off all rays \
                 see every face"
            ))),
            None => Ok(None),
        }
    }

    /// Whether a scene that was baked before, in the file `name`, can be
    /// rendered as asked. Warns where nothing in it has polygon levels.
    ///
    /// # Errors
    /// Of usage: levels for a scene that has its own.
    fn accept(&self, baked: &BakedScene, name: &str) -> Result<(), Failure> {
        if let Some(argument) = self.levels.given() {
            return Err(Failure::usage(&format!(
                "{argument} is for scenes that are not baked yet, and {name} is: its polygon \
                 levels are chosen when baking, with `shisen bake --faces MIN..MAX --levels N`"
            )));
        }
        let levels = Level::of(baked);
        let has_ladder = Level::by_mesh(&levels).any(|levels| levels.len() > 1);
        if self.is_on() && !has_ladder && !levels.is_empty() {
            warn(&format!(
                "all rays see the same polygons: {name} was baked without polygon levels. Bake it \
                 again with `shisen bake --levels N`"
            ));
        }
        Ok(())
    }

    /// The eyes, with what follows their gaze. Without `--up` and `--fixate`
    /// the viewer looks along `forward` and holds `up` up. The field is wider
    /// by `widen`, radians; from π on there is no end to it, and nothing
    /// follows the gaze.
    ///
    /// # Errors
    /// Of usage: a line of sight that is none, or a gaze that nothing follows.
    pub fn observers(
        &self,
        eyes: impl Iterator<Item = (Eye, DVec3)> + Clone,
        directions: (DVec3, DVec3),
        widen: f32,
    ) -> Result<Vec<Observer>, Failure> {
        let mut observers = Vec::new();
        self.observe(eyes, directions, widen, &mut observers)?;
        Ok(observers)
    }

    /// The same in place of what is in `observers`, which takes no memory where as many
    /// are there already, and stays where there is an error.
    ///
    /// # Errors
    /// As there.
    pub fn observe(
        &self,
        eyes: impl Iterator<Item = (Eye, DVec3)> + Clone,
        (forward, up): (DVec3, DVec3),
        widen: f32,
        observers: &mut Vec<Observer>,
    ) -> Result<(), Failure> {
        let given = self.fixate.map(|_| "--fixate");
        if let (Some(argument), false) = (given.or(self.up.map(|_| "--up")), self.is_on()) {
            return Err(Failure::usage(&format!(
                "{argument} is for --lod paper, paper-ellipse or foveated: with --lod off nothing \
                 follows the gaze"
            )));
        }
        let up = self.up.map_or(up, |up| up.0);
        let boundary = match self.lod {
            Choice::Off | Choice::Foveated => None,
            Choice::Paper => Some(Boundary::Printed),
            Choice::PaperEllipse => Some(Boundary::Ellipse),
        };
        let field = VisualField::PAPER.wider(widen);
        let observer = |(eye, place): (Eye, DVec3)| -> Result<Observer, Failure> {
            let forward = self.fixate.map_or(forward, |point| point.0 - place);
            let line = LineOfSight::new(place.as_vec3(), forward.as_vec3(), up.as_vec3())
                .map_err(|error| Failure::usage(&error.to_string()))?;
            let lod = boundary.zip(field).map(|(boundary, field)| {
                LevelOfDetail::new(Gaze::new(line, field.with_boundary(boundary)))
            });
            Ok(match self.lod {
                Choice::Foveated => Observer::foveated(eye, place, line, widen),
                _ => Observer {
                    lod,
                    ahead: Some(line.forward()),
                    ..Observer::new(eye, place)
                },
            })
        };
        eyes.clone().try_for_each(|eye| observer(eye).map(drop))?;
        observers.clear();
        observers.extend(eyes.flat_map(observer));
        Ok(())
    }

    /// The same with what comes after it in the list of what may follow the gaze.
    #[must_use]
    pub fn next(&self) -> Self {
        let all = Choice::value_variants();
        let at = all.iter().position(|one| *one == self.lod).unwrap_or(0);
        Self {
            lod: all[(at + 1) % all.len()],
            ..self.clone()
        }
    }

    /// Whether anything follows the gaze.
    pub fn is_on(&self) -> bool {
        self.lod != Choice::Off
    }

    /// For what counts the rays of every pixel.
    ///
    /// # Errors
    /// Of usage: pixels without rays of their own.
    pub fn check_that_every_pixel_has_rays(&self) -> Result<(), Failure> {
        if self.is_foveated() {
            return Err(Failure::usage(
                "explain counts the rays of every pixel, of which --lod foveated leaves some out: \
                 take --lod paper, paper-ellipse or off",
            ));
        }
        Ok(())
    }

    /// Whether not every pixel has a ray of its own.
    pub fn is_foveated(&self) -> bool {
        self.lod == Choice::Foveated
    }

    /// As it is written on a command line.
    pub const fn name(&self) -> &'static str {
        self.lod.name()
    }
}
