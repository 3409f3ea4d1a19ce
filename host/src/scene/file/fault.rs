//! What can be wrong in a scene file, and the checks that find it.

use super::entries::{Number, Numbers};
use crate::files::description::{Located, Source, suggestion};
use glam::DVec3;
use miette::Diagnostic;
use shisen_core::spectrum::Medium;
use std::collections::BTreeMap;
use std::error::Error as StdError;
use std::ops::Range;
use thiserror::Error;
use toml::Spanned;

/// What is wrong in a scene file, and what to do about it.
#[derive(Debug, Error, Diagnostic)]
#[error("{message}")]
pub struct SceneFault {
    message: String,
    #[help]
    help: Option<String>,
    source: Option<Box<dyn StdError + Send + Sync>>,
}

impl SceneFault {
    pub(super) fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            help: Some(help.into()),
            source: None,
        }
    }

    pub(super) fn caused(
        message: String,
        help: Option<&str>,
        source: impl Into<Box<dyn StdError + Send + Sync>>,
    ) -> Self {
        Self {
            message,
            help: help.map(String::from),
            source: Some(source.into()),
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Limits(f64, f64);

pub(super) const SHARE: Limits = Limits(0.0, 1.0);
pub(super) const RADIANCE: Limits = Limits(0.0, 1.0e6);
pub(super) const ABSORPTION: Limits = Limits(0.0, 1.0e6);
pub(super) const EXPONENT: Limits = Limits(1.0, 1.0e4);
pub(super) const INDEX_OF_REFRACTION: Limits = Limits(0.01, 100.0);
pub(super) const LENGTH: Limits = Limits(1.0e-6, 1.0e6);
pub(super) const POSITION: Limits = Limits(-1.0e6, 1.0e6);
pub(super) const DIVISIONS: Limits = Limits(1.0, 900.0);
pub(super) const PRIORITY: Limits = Limits(1.0, 100.0);
pub(super) const LINE_WIDTH: Limits = Limits(1.0e-3, 28.0);
pub(super) const FRAMES: Limits = Limits(1.0, 99_999.0);
pub(super) const DEGREES: Limits = Limits(-360.0, 360.0);
/// Seconds of a turn.
pub(super) const TURN: Limits = Limits(-86_400.0, 86_400.0);
pub(super) const FORM: Limits = Limits(1.0, 2.0);
pub(super) const WAVELENGTH: Limits =
    Limits(Medium::WAVELENGTHS[0] as f64, Medium::WAVELENGTHS[1] as f64);
pub(super) const REPEATS: Limits = Limits(1.0e-3, 1.0e4);
pub(super) const NORMAL_SCALE: Limits = Limits(-1.0e3, 1.0e3);
pub(super) const CONE: Limits = Limits(0.0, 90.0);
pub(super) const LIGHT_SAMPLES: Limits = Limits(1.0, 64.0);

pub(super) type Checked<T> = Result<T, Located<SceneFault>>;

pub(super) type Check<'a> = Source<'a>;

impl Check<'_> {
    pub(super) fn fault(&self, fault: SceneFault, at: Option<Range<usize>>) -> Located<SceneFault> {
        Located::new(fault, self, at)
    }

    /// Refuses a value: what is wrong with it, and what to do.
    pub(super) fn refuse<T>(
        &self,
        message: impl Into<String>,
        help: impl Into<String>,
        at: Range<usize>,
    ) -> Checked<T> {
        Err(self.fault(SceneFault::new(message, help), Some(at)))
    }

    /// Refuses keys that exclude each other, or a choice of keys of which none is there.
    pub(super) fn refuse_keys<T>(&self, owner: &str, choice: &str, at: Range<usize>) -> Checked<T> {
        let help = "leave out or add keys until it does";
        self.refuse(format!("{owner} has {choice}"), help, at)
    }

    /// Refuses a key, if it is there, that is for others only.
    pub(super) fn only_for<T>(
        &self,
        owner: &str,
        key: &str,
        value: &Option<Spanned<T>>,
    ) -> Checked<()> {
        value.as_ref().map_or(Ok(()), |value| {
            let message = format!("`{key}` is for {owner} only");
            self.refuse(message, "remove it here", value.span())
        })
    }

    pub(super) fn numbers<const N: usize>(
        &self,
        key: &str,
        values: &Spanned<[f64; N]>,
        Limits(low, high): Limits,
    ) -> Checked<[f64; N]> {
        let checked = *values.as_ref();
        let Some(value) = checked
            .into_iter()
            .find(|value| !(low..=high).contains(value))
        else {
            return Ok(checked);
        };
        self.refuse(
            format!("`{key}` is {value}, but it must be from {low} to {high}"),
            format!("give a number from {low} to {high}"),
            values.span(),
        )
    }

    pub(super) fn number(&self, key: &str, value: &Number, limits: Limits) -> Checked<f64> {
        let one = Spanned::new(value.span(), [*value.as_ref()]);
        Ok(self.numbers(key, &one, limits)?[0])
    }

    pub(super) fn whole(&self, key: &str, value: &Number, limits: Limits) -> Checked<u32> {
        let number = self.number(key, value, limits)?;
        if number.fract() == 0.0 {
            return Ok(number as u32);
        }
        let message = format!("`{key}` is {number}, but it must be a whole number");
        self.refuse(message, "give a number without a fraction", value.span())
    }

    pub(super) fn colour(&self, key: &str, value: &Numbers, limits: Limits) -> Checked<[f32; 3]> {
        let channels = self.numbers(key, value, limits)?;
        Ok(channels.map(|channel| channel as f32))
    }

    pub(super) fn colour_or(
        &self,
        key: &str,
        value: &Option<Numbers>,
        limits: Limits,
        default: [f32; 3],
    ) -> Checked<[f32; 3]> {
        let read = |value| self.colour(key, value, limits);
        value.as_ref().map_or(Ok(default), read)
    }

    pub(super) fn number_or(
        &self,
        key: &str,
        value: &Option<Number>,
        limits: Limits,
        default: f32,
    ) -> Checked<f32> {
        let read = |value| Ok(self.number(key, value, limits)? as f32);
        value.as_ref().map_or(Ok(default), read)
    }

    pub(super) fn vector_or(
        &self,
        key: &str,
        value: &Option<Numbers>,
        default: DVec3,
    ) -> Checked<DVec3> {
        let read = |value| self.numbers(key, value, POSITION).map(DVec3::from_array);
        value.as_ref().map_or(Ok(default), read)
    }

    pub(super) fn name<T: Copy>(
        &self,
        kind: &str,
        name: &Option<Spanned<String>>,
        known: &BTreeMap<&str, T>,
    ) -> Checked<Option<T>> {
        let name = name.as_ref();
        name.map(|name| self.named(kind, name, known)).transpose()
    }

    pub(super) fn named<T: Copy>(
        &self,
        kind: &str,
        name: &Spanned<String>,
        known: &BTreeMap<&str, T>,
    ) -> Checked<T> {
        let given = name.as_ref();
        if let Some(&known) = known.get(given.as_str()) {
            return Ok(known);
        }
        let help = suggestion(given, known.keys().copied()).unwrap_or_else(|| {
            let tables = match kind {
                "object" => return format!("give an [[object]] the key name = \"{given}\""),
                "mesh" => "meshes".to_owned(),
                "medium" => "media".to_owned(),
                other => format!("{other}s"),
            };
            format!("the file describes no {kind}: add [{tables}.{given}] with its keys")
        });
        self.refuse(format!("there is no {kind} \"{given}\""), help, name.span())
    }
}
