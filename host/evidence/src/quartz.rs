//! The built-in scene `spheres`, balls of quartz on a checkered floor, before one wall and one
//! eye, and how far its pictures are off.

use miette::{IntoDiagnostic, Report};
use shisen::bake::Baked;
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::picture::{Picture, colour_differences};
use shisen::render::effects::Effects;
use shisen::render::spectrum::Dispersion;
use shisen::render::{self, Frame, Observer, Options, RenderError};
use shisen::scene::builtin::spheres;
use shisen_core::scene::EffectSet;

/// A square window 1 m before the eye: its lower left corner, right of and above straight
/// ahead, and its side, metres.
pub(crate) struct Window(pub(crate) [f64; 2], pub(crate) f64);

pub(crate) struct Quartz {
    baked: Baked,
    cave: Cave,
    pub(crate) options: Options,
}

impl Quartz {
    /// `size` is in pixels a side.
    ///
    /// # Errors
    /// More pixels than a wall may have.
    pub(crate) fn new(window: &Window, size: u32, options: Options) -> Result<Self, Report> {
        let &Window([x, y], side) = window;
        let corner = |right, up| [side * right + x, side * up + y, -1.0].into();
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        let [left, right, above] = corners;
        let wall = Wall::new("front", left, right, above, [size; 2]).into_diagnostic()?;
        Ok(Self {
            baked: Baked::new(&spheres()).into_diagnostic()?,
            cave: Cave::new(vec![wall]).into_diagnostic()?,
            options,
        })
    }

    /// Renders the frame; `samples` is in rays a pixel.
    ///
    /// # Errors
    /// Threads or memory that cannot be had, as below.
    pub(crate) fn frame(&self, way: Dispersion, samples: u16) -> Result<Frame, RenderError> {
        self.render(way, samples, self.options.effects)
    }

    fn render(
        &self,
        dispersion: Dispersion,
        samples: u16,
        effects: Effects,
    ) -> Result<Frame, RenderError> {
        let mut options = Options {
            dispersion,
            effects,
            ..self.options
        };
        options.settings.samples = samples;
        let eye = [Observer::new(
            Eye::Centre,
            Viewer::default().eye(Eye::Centre),
        )];
        render::cave(
            self.baked.scene().into(),
            &self.cave,
            &eye,
            &options,
            &|_, _| {},
        )
    }

    /// Returns which pixels meet glass: those that change where no glass lets light through.
    pub(crate) fn glass(&self) -> Result<Vec<bool>, RenderError> {
        let with = self.render(self.options.dispersion, 4, self.options.effects)?;
        let effects = Effects::AUTO.less(EffectSet::REFRACTION);
        let without = self.render(self.options.dispersion, 4, effects)?;
        let pixels = picture(&with).pixels.iter();
        let pairs = pixels.zip(&picture(&without).pixels);
        Ok(pairs.map(|(a, b)| a != b).collect())
    }
}

pub(crate) fn picture(frame: &Frame) -> &Picture {
    &frame.pictures[0].picture
}

/// Returns the share of the pixels that meet glass.
pub(crate) fn share(glass: &[bool]) -> f64 {
    glass.iter().filter(|&&glass| glass).count() as f64 / glass.len() as f64
}

pub(crate) fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len().max(1) as f64
}

pub(crate) struct Truth {
    pub(crate) picture: Picture,
    pub(crate) glass: Vec<bool>,
}

impl Truth {
    /// Returns the differences of a picture, CIEDE2000: of all pixels, and of those that meet
    /// glass.
    pub(crate) fn differences(&self, found: &Picture) -> [Vec<f64>; 2] {
        let all = colour_differences(found, &self.picture).into_iter();
        let all: Vec<f64> = all.map(f64::from).collect();
        let glass = all.iter().zip(&self.glass).filter(|one| *one.1);
        let glass = glass.map(|one| *one.0).collect();
        [all, glass]
    }
}
