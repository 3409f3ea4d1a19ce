//! `shisen explain`: what a scene asks for, and what that costs.

mod report;

use super::arguments::{Model, SceneName, WallsName, threads};
use super::bench::median;
use super::failure::Failure;
use super::print;
use super::source::{Loaded, Source, bake};
use clap::Args;
use report::{Asked, Met, NOT_BUILT, NotSimulated, Primary, Report, reason};
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::effects::{Effects, compiled_for};
use shisen::render::{self, Account, Observer, Options};
use shisen::scene::builtin::PaperScene;
use shisen::scene::file::material_names;
use shisen_core::frame::{MAX_DEPTH, MAX_SAMPLES};
use shisen_core::scene::{EffectSet, Records};
use std::num::NonZeroUsize;

/// Shows which effects a scene asks for, and what each costs
///
/// Renders the frame that `shisen cave` renders, with all effects that the scene
/// asks for and without each of them, in turns.
///
/// With --json, one object: scene, mesh (null where the scene file says),
/// walls, eyes, size, pixels (of all pictures), samples, depth, threads,
/// repeat, seconds (a frame as it is; times are medians), primary (rays and steps of
/// the rays from the eyes, ray by ray), effects (those asked for: effect,
/// materials and lights, the names of what asks for it, pixels, those in
/// whose ray trees it was carried out, rays and steps, of the rays that were traced
/// for it alone, `seconds_without`, the frame without it, and seconds, what it adds
/// to that), compiled (the effects of the shading that was used),
/// `not_simulated` (effect and reason, of each that the scene does not ask for)
/// and `not_built` (what no scene can ask for).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, grid, prism, spheres, a TOML description or a
    /// baked scene [default: A]
    #[arg(id = "explained", value_name = "SCENE", value_parser = SceneName::parser(),
          conflicts_with = "scene")]
    explained: Option<SceneName>,
    /// The same
    #[arg(long, value_name = "SCENE", value_parser = SceneName::parser())]
    scene: Option<SceneName>,
    #[command(flatten)]
    model: Model,
    /// three-wall (front, right and floor), cube, dome, or a TOML file of walls
    /// and domes
    #[arg(long, value_name = "NAME|FILE", default_value = "three-wall",
          value_parser = WallsName::parser())]
    walls: WallsName,
    /// Pixels along each side of a wall or dome that does not say itself
    #[arg(long, value_name = "PIXELS", default_value_t = 256,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(Wall::MOST_PIXELS)))]
    size: u32,
    /// One eye in the middle of the head, or two
    #[arg(long, value_name = "1|2", default_value_t = 2,
          value_parser = clap::value_parser!(u8).range(1..=2))]
    eyes: u8,
    /// Reflections and refractions to follow, one after another
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u8).range(0..=i64::from(MAX_DEPTH)))]
    depth: u8,
    /// Rays a pixel
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_SAMPLES)))]
    samples: u16,
    /// Threads to trace on [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// How often to render each frame
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..=1_000))]
    repeat: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.explained.as_ref().or(arguments.scene.as_ref());
    let name = name.unwrap_or(&SceneName::Paper(PaperScene::A));
    let cave = arguments.walls.cave([arguments.size; 2])?;
    let viewer = Viewer::default();
    let which: &[Eye] = if arguments.eyes == 1 {
        &[Eye::Centre]
    } else {
        &Eye::STEREO
    };
    let observer = |&eye| Observer::new(eye, viewer.eye(eye));
    let observers: Vec<Observer> = which.iter().map(observer).collect();
    for one in &observers {
        cave.check_eye(one.place)?;
    }
    let source = Source::load(name, &arguments.model)?;
    let baked = match source.scene {
        Loaded::Baked(baked) => baked,
        Loaded::Described(scene) => bake(&scene, &source.name, Layout::Fast, None)?,
    };
    let mut options = Options::default();
    options.settings.depth = arguments.depth;
    options.settings.samples = arguments.samples;
    if let Some(threads) = arguments.threads {
        options.threads = threads.get();
    }
    let frames = Frames {
        baked: &baked,
        cave: &cave,
        observers: &observers,
        options: &options,
    };
    let records = frames.records();
    let set = EffectSet::of_records(&records);
    let asked: Vec<EffectSet> = EffectSet::NAMED
        .iter()
        .filter_map(|&(effect, _)| set.contains(effect).then_some(effect))
        .collect();
    let account = frames.account()?;
    let (seconds, without) = frames.times(&asked, arguments.repeat)?;
    let met = Met::new(&records, &names(name));
    let ledger = &account.ledger;
    let all = ledger.entry(EffectSet::ALL);
    print(
        &Report {
            scene: source.name,
            mesh: source.mesh,
            walls: cave.screens().map(|one| one.name().to_owned()).collect(),
            eyes: observers.len(),
            size: arguments.size,
            pixels: account.pixels,
            samples: arguments.samples,
            depth: arguments.depth,
            threads: options.threads,
            repeat: arguments.repeat,
            seconds,
            primary: Primary {
                rays: account.statistics.primary,
                steps: account.statistics.steps - all.steps,
            },
            effects: asked
                .iter()
                .zip(without)
                .map(|(&effect, seconds_without)| {
                    let entry = ledger.entry(effect);
                    Asked {
                        effect: effect.to_string(),
                        materials: met.materials(effect),
                        lights: met.lights(effect),
                        pixels: entry.pixels,
                        rays: entry.rays,
                        steps: entry.steps,
                        seconds_without,
                        seconds: seconds - seconds_without,
                    }
                })
                .collect(),
            compiled: compiled_for(set).names().collect(),
            not_simulated: EffectSet::ALL
                .without(set)
                .names()
                .filter_map(|name| {
                    let reason = reason(EffectSet::named(name)?, &records);
                    Some(NotSimulated {
                        effect: name,
                        reason,
                    })
                })
                .collect(),
            not_built: NOT_BUILT,
        },
        arguments.json,
    )
}

/// What a scene's materials are called, as far as anybody says.
fn names(scene: &SceneName) -> Vec<String> {
    match scene {
        SceneName::Paper(PaperScene::A | PaperScene::C) => vec!["chrome".to_owned()],
        SceneName::Paper(PaperScene::B | PaperScene::D) => vec!["clay".to_owned()],
        SceneName::Grid => vec!["lines".to_owned()],
        SceneName::Prism => ["glass", "slit", "floor"].map(str::to_owned).into(),
        SceneName::Spheres => ["quartz", "floor", "lamp"].map(str::to_owned).into(),
        // It was read a moment ago; a baked scene is no text.
        SceneName::File(path) => shisen::input::read_text(path)
            .map(|text| material_names(&text))
            .unwrap_or_default(),
    }
}

/// Frames of one scene for one viewer.
struct Frames<'r> {
    baked: &'r BakedScene,
    cave: &'r Cave,
    observers: &'r [Observer],
    options: &'r Options,
}

impl<'r> Frames<'r> {
    fn records(&self) -> Records<'r> {
        match self.baked {
            BakedScene::Fast(baked) => baked.scene().records(),
            BakedScene::Compact(baked) => baked.scene().records(),
        }
    }

    fn account(&self) -> Result<Account, Failure> {
        let Self {
            cave,
            observers,
            options,
            ..
        } = self;
        match self.baked {
            BakedScene::Fast(baked) => render::account(&baked.scene(), cave, observers, options),
            BakedScene::Compact(baked) => render::account(&baked.scene(), cave, observers, options),
        }
        .map_err(Failure::from_error)
    }

    /// Seconds of a frame.
    fn seconds(&self, effects: Effects) -> Result<f64, Failure> {
        let Self {
            cave, observers, ..
        } = self;
        let options = Options {
            effects,
            ..*self.options
        };
        let quiet = |_, _| {};
        let frame = match self.baked {
            BakedScene::Fast(baked) => {
                render::cave(&baked.scene(), cave, observers, &options, &quiet)
            }
            BakedScene::Compact(baked) => {
                render::cave(&baked.scene(), cave, observers, &options, &quiet)
            }
        };
        Ok(frame.map_err(Failure::from_error)?.seconds)
    }

    /// Medians of a frame's seconds, and of those without each effect, in turns.
    fn times(&self, asked: &[EffectSet], repeat: u32) -> Result<(f64, Vec<f64>), Failure> {
        let mut whole = Vec::new();
        let mut without = vec![Vec::new(); asked.len()];
        for _ in 0..repeat {
            whole.push(self.seconds(Effects::AUTO)?);
            for (&effect, seconds) in asked.iter().zip(&mut without) {
                seconds.push(self.seconds(Effects::AUTO.less(effect))?);
            }
        }
        Ok((median(whole), without.into_iter().map(median).collect()))
    }
}
