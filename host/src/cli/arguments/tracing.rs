//! Arguments of commands that trace a scene.

use crate::bake::BakedScene;
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
    /// Reflections and refractions to follow, one after another; with --lod, in the centre of the
    /// field
    #[arg(long, visible_alias = "reflect-max", value_name = "N", default_value_t = 3,
          value_parser = whole::<u8>(0..=MAX_DEPTH))]
    pub depth: u8,
    /// Rays a pixel
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = whole::<u16>(1..=MAX_SAMPLES))]
    pub samples: u16,
    /// Threads to trace with [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
}

impl TracingArguments {
    /// The options to render a scene with, and its dispersion if that is rendered.
    pub fn options(
        &self,
        baked: &BakedScene,
    ) -> Result<(Options, Option<DispersionReport>), Failure> {
        let mut options = Options {
            effects: self.effects.effects,
            ..Options::default()
        };
        options.settings.depth = self.depth;
        options.settings.samples = self.samples;
        if let Some(threads) = self.threads {
            options.threads = threads.get();
        }
        let dispersion = self.dispersion.set(baked, &mut options)?;
        Ok((options, dispersion))
    }
}
