//! `shisen explain`: what a scene asks for, and what that costs.

pub(super) mod report;

use crate::bake::Layout;
use crate::cli::arguments::dispersion::{in_one_frame, range_in_one_frame};
use crate::cli::arguments::lod::{LodArguments, of_every_pixel};
use crate::cli::arguments::room::RoomArguments;
use crate::cli::arguments::source::{Loaded, Ready, Source};
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{ModelArguments, SceneName};
use crate::cli::output::progress::Ticker;
use crate::cli::prelude::*;
use crate::live::quantiles::{median, quartiles};
use crate::render::effects::{Effects, compiled_for};
use crate::render::spectrum::Dispersion;
use crate::render::{self, Options};
use crate::scene::builtin::PaperScene;
pub(super) use report::Animation;
use report::{Asked, Met, NOT_BUILT, Primary, Report, Seconds, not_simulated};
use shisen_core::scene::EffectSet;

/// Shows which effects a scene asks for, and what each costs
#[derive(Debug, Args)]
#[command(
    mut_arg("lod", of_every_pixel),
    mut_arg("dispersion", in_one_frame),
    mut_arg("range", range_in_one_frame)
)]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, gallery, grid, prism, spheres, a model, a TOML description or a
    /// baked scene [default: A]
    #[arg(id = "explained", value_name = "SCENE", conflicts_with = "scene")]
    explained: Option<SceneName>,
    /// The scene, as other commands take it
    #[arg(long, value_name = "SCENE")]
    scene: Option<SceneName>,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    room: RoomArguments,
    #[command(flatten)]
    lod: LodArguments,
    #[command(flatten)]
    tracing: TracingArguments,
    /// How often to render each frame
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole::<u32>(1..=1_000))]
    repeat: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

// Longer than 80 lines: the report takes a line a field.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.explained.as_ref().or(arguments.scene.as_ref());
    let name = name.unwrap_or(&SceneName::Paper(PaperScene::A));
    let cave = arguments.room.cave()?;
    let pose = arguments.room.head();
    let eyes = arguments.room.eyes(pose);
    let directions = arguments.room.directions(pose);
    (arguments.room).check_camera(arguments.model.camera.as_deref())?;
    if arguments.lod.is_foveated() {
        return Err(misuse!(
            "explain counts the rays of each pixel, and with --lod foveated pixels share light: take \
             --lod paper, paper-ellipse or off"
        ));
    }
    let mut observers = arguments.lod.observers(eyes, directions, 0.0)?;
    arguments.room.check_eyes(&cave, pose)?;
    let source = Source::load(name, &arguments.model)?;
    let (names, animations) = match &source.scene {
        Loaded::Described(scene) => (scene.material_names(), Animation::of(scene.motion.clips())),
        Loaded::Baked(_) => Default::default(),
    };
    let ticker = Ticker::start(format!("baking {name}"), false);
    let ready = arguments.lod.baked(source, Layout::Fast, &ticker)?;
    drop(ticker);
    if let Some(look) = ready.look() {
        let pose = arguments.room.head_towards(Some(look));
        arguments.room.check_eyes(&cave, pose)?;
        let eyes = arguments.room.eyes(pose);
        observers = (arguments.lod).observers(eyes, look.directions(), 0.0)?;
    }
    let Ready { baked, shown, .. } = ready;
    let (options, traced) = arguments.tracing.options(&baked)?;
    if matches!(options.dispersion, Dispersion::Images(..)) {
        return Err(misuse!(
            "--dispersion paper and fixed render whole pictures one after the other, in which no \
             ray is traced for dispersion alone: explain comb or split"
        ));
    }
    let quiet = |_, _| {};
    let seconds = |effects| {
        let options = Options { effects, ..options };
        let frame = render::cave(baked.scene(), &cave, &observers, &options, &quiet);
        Ok(frame?.seconds)
    };
    let records = baked.records();
    let asked = EffectSet::of_records(&records);
    let carried_out = options.effects.of(asked).intersection(asked);
    let named = |set: EffectSet| {
        let all = EffectSet::NAMED.iter();
        all.filter_map(move |&(effect, _)| set.contains(effect).then_some(effect))
    };
    let account = render::account(baked.scene(), &cave, &observers, &options)?;
    let effects: Vec<EffectSet> = named(carried_out).collect();
    let (whole, times) = times(seconds, options.effects, &effects, arguments.repeat)?;
    let met = Met::new(&records, &names);
    let asked_for = effects
        .into_iter()
        .zip(times)
        .map(|(effect, [seconds_without, seconds])| {
            let entry = account.ledger.entry(effect);
            Asked {
                cause: met.cause(effect),
                pixels: entry.pixels,
                rays: entry.rays,
                steps: entry.steps,
                seconds_without,
                seconds,
            }
        });
    let left_out = named(asked.difference(carried_out)).map(|effect| met.cause(effect));
    let report = Report {
        shown,
        walls: cave.screens().map(|one| one.name().to_owned()).collect(),
        eyes: observers.len(),
        size: arguments.room.size,
        pixels: account.pixels,
        lod: arguments.lod.name(),
        samples: traced.samples,
        depth: arguments.tracing.depth,
        dispersion: traced.dispersion,
        threads: traced.threads,
        repeat: arguments.repeat,
        seconds: whole,
        primary: Primary {
            rays: account.statistics.primary,
            steps: account.statistics.steps - account.ledger.entry(EffectSet::ALL).steps,
        },
        effects: asked_for.collect(),
        left_out: left_out.collect(),
        animations,
        compiled: compiled_for(options.effects.of(asked)).names().collect(),
        not_simulated: not_simulated(asked, &records),
        not_built: NOT_BUILT,
    };
    print(&report, arguments.json)
}

/// Returns the seconds of a frame, and for each effect those without it and those it adds. Frames
/// take turns, and each is compared with the one just before.
fn times(
    seconds: impl Fn(Effects) -> Result<f64, Failure>,
    all: Effects,
    effects: &[EffectSet],
    repeat: u32,
) -> Result<(Seconds, Vec<[Seconds; 2]>), Failure> {
    let mut whole = Vec::new();
    let mut of_each = vec![[Vec::new(), Vec::new()]; effects.len()];
    for _ in 0..repeat {
        for (&effect, [without, added]) in effects.iter().zip(&mut of_each) {
            let with = seconds(all)?;
            let less = seconds(all.less(effect))?;
            whole.push(with);
            without.push(less);
            added.push(with - less);
        }
        if effects.is_empty() {
            whole.push(seconds(all)?);
        }
    }
    let of = |times: Vec<f64>| Seconds {
        median: median(times.clone()),
        quartiles: quartiles(times),
    };
    let each = of_each.into_iter().map(|times| times.map(of)).collect();
    Ok((of(whole), each))
}
