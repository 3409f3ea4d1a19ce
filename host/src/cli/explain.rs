//! `shisen explain`: what a scene asks for, and what that costs.

mod report;

use crate::bake::BakedScene;
use crate::cave::Cave;
use crate::cli::arguments::dispersion::{in_one_frame, range_in_one_frame};
use crate::cli::arguments::lod::{LodArguments, of_every_pixel};
use crate::cli::arguments::room::RoomArguments;
use crate::cli::arguments::source::Source;
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{Model, SceneName, whole};
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::live::quantiles::{median, quartiles};
use crate::render::effects::{Effects, compiled_for};
use crate::render::spectrum::Dispersion;
use crate::render::{self, Account, Observer, Options};
use crate::scene::builtin::PaperScene;
use crate::scene::file::material_names;
use crate::with_scene;
use clap::Args;
use report::{Asked, LeftOut, Met, NOT_BUILT, NotSimulated, Primary, Report, Seconds, reason};
use shisen_core::scene::EffectSet;

/// Shows which effects a scene asks for, and what each costs
///
/// Renders the frame that `shisen cave` renders, with all effects that the scene
/// asks for, or those that --effects and --wavelengths leave of them, and without
/// each of these, in turns.
///
/// With --json, one object: scene, mesh (null where the scene file says),
/// walls, eyes, size, pixels (of all pictures), lod (off, paper or
/// paper-ellipse), samples, depth, dispersion (as `shisen cave --json` has it),
/// threads, repeat, seconds (a frame as it is: median and quartiles), primary (rays
/// and steps of the rays from the eyes, ray by ray), effects (those carried out:
/// effect, materials and lights, the names of what asks for it, pixels, those in
/// whose ray trees it was carried out, rays and steps, of the rays that were traced
/// for it alone, `seconds_without`, the frame without it, and seconds, what it adds
/// to that, from frames one after the other: both median and quartiles), `left_out`
/// (effect, materials and lights, of each that the scene asks for and the command
/// line leaves out), compiled (the effects of the shading that was used),
/// `not_simulated` (effect and reason, of each that the scene does not ask for)
/// and `not_built` (what no scene can ask for).
#[derive(Debug, Args)]
#[command(
    mut_arg("lod", of_every_pixel),
    mut_arg("dispersion", in_one_frame),
    mut_arg("range", range_in_one_frame)
)]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, grid, prism, spheres, a TOML description or a
    /// baked scene [default: A]
    #[arg(id = "explained", value_name = "SCENE", value_parser = SceneName::parser(),
          conflicts_with = "scene")]
    explained: Option<SceneName>,
    /// The same scene, as other commands have it
    #[arg(long, value_name = "SCENE", value_parser = SceneName::parser())]
    scene: Option<SceneName>,
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    room: RoomArguments,
    #[command(flatten)]
    lod: LodArguments,
    #[command(flatten)]
    tracing: TracingArguments,
    /// How often to render each frame
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = whole::<u32>(1..=1_000))]
    repeat: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.explained.as_ref().or(arguments.scene.as_ref());
    let name = name.unwrap_or(&SceneName::Paper(PaperScene::A));
    let cave = arguments.room.cave()?;
    let pose = arguments.room.head();
    let eyes = arguments.room.eyes(pose);
    let directions = arguments.room.directions(pose);
    arguments.lod.check_that_every_pixel_has_rays()?;
    let observers = arguments.lod.observers(eyes.clone(), directions, 0.0)?;
    for (_, place) in eyes {
        cave.check_eye(place)?;
    }
    let source = Source::load(name, &arguments.model)?;
    let baked = arguments.lod.baked(source.scene, &source.name)?;
    let (options, dispersion) = arguments.tracing.options(&baked)?;
    if matches!(options.dispersion, Dispersion::Images(..)) {
        return Err(Failure::usage(
            "--dispersion paper and fixed are whole pictures one after the other, in which no \
             ray is traced for dispersion alone: explain comb or split",
        ));
    }
    let frames = Frames {
        baked: &baked,
        cave: &cave,
        observers: &observers,
        options: &options,
    };
    let records = baked.records();
    let asked = EffectSet::of_records(&records);
    let carried_out = options.effects.of(asked).intersection(asked);
    let named = |set: EffectSet| {
        let all = EffectSet::NAMED.iter();
        all.filter_map(move |&(effect, _)| set.contains(effect).then_some(effect))
    };
    let account = frames.account()?;
    let effects: Vec<EffectSet> = named(carried_out).collect();
    let (seconds, times) = frames.times(&effects, arguments.repeat)?;
    let met = Met::new(&records, &names(name));
    let ledger = &account.ledger;
    let all = ledger.entry(EffectSet::ALL);
    print(
        &Report {
            scene: source.name,
            mesh: source.mesh,
            walls: cave.screens().map(|one| one.name().to_owned()).collect(),
            eyes: observers.len(),
            size: arguments.room.size,
            pixels: account.pixels,
            lod: arguments.lod.name(),
            samples: arguments.tracing.samples,
            depth: arguments.tracing.depth,
            dispersion,
            threads: options.threads,
            repeat: arguments.repeat,
            seconds,
            primary: Primary {
                rays: account.statistics.primary,
                steps: account.statistics.steps - all.steps,
            },
            effects: effects
                .iter()
                .zip(times)
                .map(|(&effect, (seconds_without, seconds))| {
                    let entry = ledger.entry(effect);
                    Asked {
                        effect: effect.to_string(),
                        materials: met.materials(effect),
                        lights: met.lights(effect),
                        pixels: entry.pixels,
                        rays: entry.rays,
                        steps: entry.steps,
                        seconds_without,
                        seconds,
                    }
                })
                .collect(),
            left_out: named(asked.difference(carried_out))
                .map(|effect| LeftOut {
                    effect: effect.to_string(),
                    materials: met.materials(effect),
                    lights: met.lights(effect),
                })
                .collect(),
            compiled: compiled_for(options.effects.of(asked)).names().collect(),
            not_simulated: EffectSet::ALL
                .difference(asked)
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
        SceneName::File(path) => crate::files::read_text(path)
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

impl Frames<'_> {
    fn account(&self) -> Result<Account, Failure> {
        let Self {
            cave,
            observers,
            options,
            ..
        } = self;
        Ok(with_scene!(self.baked, |scene| render::account(
            &scene, cave, observers, options
        ))?)
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
        let frame = with_scene!(self.baked, |scene| render::cave(
            &scene, cave, observers, &options, &quiet
        ));
        Ok(frame?.seconds)
    }

    /// A frame's seconds; and of each effect, those without it and what it adds to
    /// them. Frames take turns, and each is compared with the one just before.
    fn times(
        &self,
        effects: &[EffectSet],
        repeat: u32,
    ) -> Result<(Seconds, Vec<(Seconds, Seconds)>), Failure> {
        let all = self.options.effects;
        let mut whole = Vec::new();
        let mut of_each = vec![(Vec::new(), Vec::new()); effects.len()];
        for _ in 0..repeat {
            for (&effect, (without, added)) in effects.iter().zip(&mut of_each) {
                let with = self.seconds(all)?;
                let less = self.seconds(all.less(effect))?;
                whole.push(with);
                without.push(less);
                added.push(with - less);
            }
            if effects.is_empty() {
                whole.push(self.seconds(all)?);
            }
        }
        let of = |times: Vec<f64>| Seconds {
            median: median(times.clone()),
            quartiles: quartiles(times),
        };
        let each = of_each.into_iter().map(|(a, b)| (of(a), of(b))).collect();
        Ok((of(whole), each))
    }
}
