//! Arguments of commands in which detail may follow the gaze.

use crate::bake::Layout;
use crate::cave::Eye;
use crate::cave::look::Point;
use crate::cli::arguments::cache::CacheArguments;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source::{Loaded, Ready, Source};
use crate::cli::arguments::{LevelArguments, ModelArguments, SceneName, without};
use crate::cli::numbers::whole;
use crate::cli::output::progress::Ticker;
use crate::cli::prelude::*;
use crate::render::Observer;
use clap::Arg;
use glam::DVec3;
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Acuity, Boundary, Gaze, LineOfSight, VisualField};
use std::str::FromStr;

#[derive(Debug, Clone, Args)]
pub struct LodArguments {
    /// What follows the gaze: detail falls with the distance from the line of sight. Polygon levels
    /// are those of the baked scene, or else those of --faces and --levels [default: off]
    #[arg(long, value_enum, default_value = "off", hide_default_value = true)]
    lod: Choice,
    #[command(flatten)]
    levels: LevelArguments,
    /// Direction of the top of the head, for --lod [default: as --look and --head-report say]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<Point>,
    /// Point in the room, in metres, that both eyes look at. With --lod each eye then has its
    /// own line of sight [default: one for both, along --look]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    fixate: Option<Point>,
    /// How much detail --lod foveated keeps, from 1 (coarse) to 5 (fine). By a model of human
    /// vision, pictures of thin things score 8.4, 9.0, 9.4, 9.5 and 9.5 of 10: at 10 nobody sees a
    /// difference, at 9 three of four people do [default: 3]
    #[arg(long, value_name = "N", value_parser = whole::<u8>(1..=5))]
    quality: Option<u8>,
    /// How finely the eye sees, instead of --quality: the least angle that it tells apart is
    /// W0 degrees, and M more for each degree from the line of sight
    /// [default: 0.0275,0.0208]
    #[arg(
        long,
        value_name = "M,W0",
        conflicts_with = "quality",
        allow_hyphen_values = true
    )]
    acuity: Option<AcuityArgument>,
}

/// `--acuity`.
#[derive(Debug, Clone, Copy)]
struct AcuityArgument(Acuity);

impl FromStr for AcuityArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once(',').and_then(|(slope, fovea)| {
            let number = |text: &str| text.trim().parse::<f32>().ok();
            Some((number(slope)?, number(fovea)?))
        });
        let (slope, fovea) = numbers.ok_or("give two numbers, such as 0.0275,0.0208")?;
        let acuity = Acuity::new(slope, fovea.to_radians());
        acuity.map(Self).map_err(|_| {
            format!(
                "give an M of 0 to {} and a W0 of {:.5} to {:.0}",
                Acuity::STEEPEST,
                Acuity::FINEST.to_degrees(),
                Acuity::COARSEST.to_degrees().floor()
            )
        })
    }
}

/// `--lod`.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Choice {
    /// Nothing: everything is traced in full
    #[default]
    Off,
    /// The paper's levels, with the border of the field as printed
    Paper,
    /// The paper's levels, with the border of the field as half-ellipses
    PaperEllipse,
    /// The size of detail: farther out several pixels are one, and light is computed at fewer
    /// points; edges are antialiased, and all of the picture is there, behind the viewer, too. It
    /// saves time from about 512² pixels a wall on
    Foveated,
}

named!(Choice {
    Off => "off",
    Paper => "paper",
    PaperEllipse => "paper-ellipse",
    Foveated => "foveated",
});

/// `--lod` for commands that can fill what the gaze skips.
pub fn to_be_filled(lod: Arg) -> Arg {
    lod.default_value_ifs([("fill", "capture", "paper"), ("fill", "previous", "paper")])
}

/// `--lod` for commands that count the rays of every pixel.
pub fn of_every_pixel(lod: Arg) -> Arg {
    lod.value_parser(without::<Choice>(&["foveated"]))
}

impl LodArguments {
    /// Returns a scene with the polygon levels that are asked for: as it was kept, or else loaded
    /// and, unless it is, baked.
    pub fn ready(
        &self,
        name: &SceneName,
        model: &ModelArguments,
        cache: &CacheArguments,
        layout: Layout,
        quiet: bool,
    ) -> Result<Ready, Failure> {
        let request = format!(
            "{name:?} {model:?} {:?} {:?} {layout:?}",
            self.has_levels(),
            self.levels
        );
        cache.kept(&request, || {
            let ticker = Ticker::start(format!("reading {name}"), quiet);
            self.baked(Source::load(name, model)?, layout, &ticker)
        })
    }

    /// Bakes a scene with the polygon levels that are asked for, unless it is baked already.
    pub fn baked(&self, source: Source, layout: Layout, ticker: &Ticker) -> Result<Ready, Failure> {
        let (given, name) = (self.levels.given(), &source.shown.scene);
        match (&source.scene, given) {
            (Loaded::Baked(_), Some(argument)) => {
                return Err(misuse!(
                    "{argument} is for scenes that are not baked yet, and {name} is: its polygon \
                     levels are chosen when baking, with `shisen bake --faces MIN..MAX --levels N`"
                ));
            }
            (Loaded::Baked(baked), None) if self.has_levels() => {
                let levels = Level::of(baked);
                let has_ladder = Level::by_mesh(&levels).any(|levels| levels.len() > 1);
                if !has_ladder && !levels.is_empty() {
                    warn(&format!(
                        "all rays see the same polygons: {name} was baked without polygon levels. \
                         Bake it again with `shisen bake --levels N`"
                    ));
                }
            }
            (Loaded::Described(_), Some(argument)) if !self.has_levels() => {
                let lod = self.name();
                return Err(misuse!(
                    "{argument} is for --lod paper or paper-ellipse: with --lod {lod} all rays see \
                     every face"
                ));
            }
            _ => {}
        }
        let levels = self.has_levels();
        let levels = levels.then(|| self.levels.polygon_levels(layout));
        source.baked(layout, levels.transpose()?.as_ref(), ticker)
    }

    /// Returns whether rays see polygon levels.
    const fn has_levels(&self) -> bool {
        matches!(self.lod, Choice::Paper | Choice::PaperEllipse)
    }

    /// Returns the eyes with their lines of sight and levels of detail. `directions` are forward
    /// and up, for a viewer without `--fixate` and `--up`. The visual field is wider by `widen`,
    /// radians; from π on it has no border, and nothing follows the gaze.
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

    /// Does the same into `observers`, without allocating if there are as many already. An error
    /// leaves them unchanged.
    pub fn observe(
        &self,
        eyes: impl Iterator<Item = (Eye, DVec3)> + Clone,
        (forward, up): (DVec3, DVec3),
        widen: f32,
        observers: &mut Vec<Observer>,
    ) -> Result<(), Failure> {
        let given = self.fixate.map(|_| "--fixate");
        if let (Some(argument), false) = (given.or(self.up.map(|_| "--up")), self.is_on()) {
            return Err(misuse!(
                "{argument} is for --lod paper, paper-ellipse or foveated: with --lod off nothing \
                 follows the gaze"
            ));
        }
        let given = self
            .quality
            .map(|_| "--quality")
            .or(self.acuity.map(|_| "--acuity"));
        if let (Some(argument), false) = (given, self.is_foveated()) {
            let lod = self.name();
            return Err(misuse!(
                "{argument} is for --lod foveated, not for --lod {lod}"
            ));
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
            let (from, forward) = (place.as_vec3(), forward.as_vec3());
            let line = LineOfSight::new(from, forward, up.as_vec3()).or_misuse()?;
            let lod = boundary.zip(field).map(|(boundary, field)| {
                LevelOfDetail::new(Gaze::new(line, field.with_boundary(boundary)))
            });
            Ok(match self.lod {
                Choice::Foveated => Observer::foveated(eye, place, (line, self.acuity()), widen),
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

    /// Returns these arguments with the next value of `--lod`.
    #[must_use]
    pub fn next(&self) -> Self {
        let all = Choice::ALL;
        let at = all.iter().position(|one| *one == self.lod).unwrap_or(0);
        Self {
            lod: all[(at + 1) % all.len()],
            ..self.clone()
        }
    }

    pub fn is_on(&self) -> bool {
        self.lod != Choice::Off
    }

    /// Returns whether detail is as large as the eye sees.
    pub fn is_foveated(&self) -> bool {
        self.lod == Choice::Foveated
    }

    /// Returns how finely the eye sees, for foveation.
    fn acuity(&self) -> Acuity {
        let of_quality = self.quality.and_then(Acuity::of_quality);
        let given = self.acuity.map(|given| given.0);
        given.or(of_quality).unwrap_or(Acuity::GUENTER)
    }

    /// Returns the same with another choice, without the arguments that do not go with it, and the
    /// names of these.
    pub fn with(&self, lod: Choice) -> (Self, Vec<&'static str>) {
        let (mut with, mut dropped) = (
            Self {
                lod,
                ..self.clone()
            },
            Vec::new(),
        );
        if lod == Choice::Off {
            dropped.extend(with.fixate.take().map(|_| "--fixate"));
            dropped.extend(with.up.take().map(|_| "--up"));
        }
        if lod != Choice::Foveated {
            dropped.extend(with.quality.take().map(|_| "--quality"));
            dropped.extend(with.acuity.take().map(|_| "--acuity"));
        }
        if !with.has_levels() {
            dropped.extend(with.levels.given());
            with.levels = LevelArguments::default();
        }
        (with, dropped)
    }

    /// Checks that the picture follows the viewer's line of sight.
    pub fn check_gaze(&self) -> Result<(), Failure> {
        if self.fixate.is_some() {
            return Err(misuse!(
                "with --fixate the eyes look at a point, whatever the gaze: record without it"
            ));
        }
        if !self.is_on() {
            return Err(misuse!("with --lod off nothing follows the gaze"));
        }
        Ok(())
    }

    pub const fn choice(&self) -> Choice {
        self.lod
    }

    pub const fn name(&self) -> &'static str {
        self.lod.name()
    }
}
