//! Arguments of commands that trace a scene.

use crate::cli::arguments::dispersion::{DispersionArguments, DispersionReport};
use crate::cli::arguments::{EffectArguments, threads};
use crate::cli::prelude::*;
use crate::render::Options;
use shisen_core::frame::{MAX_DEPTH, MAX_SAMPLES};
use std::num::NonZeroUsize;

#[derive(Debug, Clone, Args)]
pub struct TracingArguments {
    #[command(flatten)]
    effects: EffectArguments,
    #[command(flatten)]
    dispersion: DispersionArguments,
    /// Reflections and refractions to follow, one after another; with the paper's --lod, in the
    /// centre of the field
    #[arg(long, visible_alias = "reflect-max", value_name = "N", default_value_t = 3,
          value_parser = whole::<u8>(0..=MAX_DEPTH))]
    pub depth: u8,
    /// Rays a pixel; with --lod foveated, a multiple of four of them [default: 1, or 4 with --lod
    /// foveated]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=MAX_SAMPLES))]
    samples: Option<u16>,
    /// Threads to trace with [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
}

impl TracingArguments {
    pub const fn set_threads(&mut self, threads: NonZeroUsize) {
        self.threads = Some(threads);
    }

    /// Returns the options to render a scene with, and a report of them.
    pub fn options(&self, baked: &BakedScene) -> Result<(Options, TracingReport), Failure> {
        let mut options = Options {
            effects: self.effects.effects,
            ..Options::default()
        };
        options.settings.depth = self.depth;
        if let Some(samples) = self.samples {
            options.settings.samples = samples;
        }
        if let Some(threads) = self.threads {
            options.threads = threads.get();
        }
        let dispersion = self.dispersion.set(baked, &mut options)?;
        let asked = baked.effects();
        let report = TracingReport {
            threads: options.threads,
            simd: baked.layout().simd(options.simd).name(),
            depth: self.depth,
            samples: options.settings.samples,
            effects: options.effects.of(asked).names().collect(),
            effects_asked: asked.names().collect(),
            dispersion,
        };
        Ok((options, report))
    }

    /// Returns how many rays a pixel has with foveation. Warns if another number was asked for.
    pub fn foveated_samples(&self, options: &Options) -> u16 {
        let traced = options.foveated_samples();
        if let Some(asked) = self.samples.filter(|asked| *asked != traced) {
            warn(&format!(
                "--lod foveated traces {traced} rays a pixel instead of {asked}, for it takes them \
                 in fours: give a multiple of four, such as --samples {traced}"
            ));
        }
        traced
    }
}

/// How a scene was traced, for reports.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TracingReport {
    /// Threads that traced.
    pub threads: usize,
    /// The code path taken: avx2 or portable.
    pub simd: &'static str,
    /// Reflections and refractions followed.
    depth: u8,
    /// Rays a pixel that were traced.
    pub samples: u16,
    /// Effects that were rendered.
    effects: Vec<&'static str>,
    /// Effects that the scene asks for.
    effects_asked: Vec<&'static str>,
    /// Dispersion, or null if it is not rendered.
    pub dispersion: Option<DispersionReport>,
}
