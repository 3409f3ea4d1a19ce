//! What can be wrong in a scene file, and the checks that find it.

use super::entries::{Number, Numbers};
use crate::files::description::{Located, Source, suggestion};
use crate::scene::camera::CameraPathError;
use crate::scene::mesh::MeshError;
use crate::scene::texture::ImageError;
use glam::DVec3;
use miette::Diagnostic;
use shisen_core::spectrum::{Medium, MediumError};
use std::collections::BTreeMap;
use std::ops::Range;
use thiserror::Error;
use toml::Spanned;

/// What is wrong in a scene file.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneFault {
    /// Not TOML, or not the keys and types that a scene has.
    #[error("{message}")]
    #[diagnostic(help(
        "a scene file has name, ambient, [background], [materials.NAME], [media.NAME], [textures.NAME], [meshes.NAME], [[object]], [[light]] and [[camera]]"
    ))]
    Syntax { message: String },
    /// A scene without objects.
    #[error("the scene has no objects")]
    #[diagnostic(help("add an [[object]] with a mesh, a sphere or a spheroid"))]
    NoObjects,
    /// A number that is not finite or not within its limits.
    #[error("`{key}` is {value}, but it must be from {low} to {high}")]
    #[diagnostic(help("give a number from {low} to {high}"))]
    OutOfRange {
        key: Key,
        value: f64,
        low: f64,
        high: f64,
    },
    /// A name that is not described.
    #[error("there is no {kind} \"{given}\"")]
    UnknownName {
        kind: &'static str,
        given: String,
        #[help]
        suggestion: String,
    },
    /// Keys that exclude each other, or a choice of keys of which none is there.
    #[error("{owner} has {choice}")]
    #[diagnostic(help("leave out or add keys until it does"))]
    Choice {
        owner: &'static str,
        choice: &'static str,
    },
    /// A key that is not there.
    #[error("{owner} needs `{key}`")]
    #[diagnostic(help("add `{key} = {example}`"))]
    Missing {
        owner: &'static str,
        key: &'static str,
        example: &'static str,
    },
    /// A key in the wrong table.
    #[error("`{key}` is for {owner} only")]
    #[diagnostic(help("remove it here"))]
    NotHere {
        key: &'static str,
        owner: &'static str,
    },
    /// A direction that points nowhere.
    #[error("the light's `direction` is zero")]
    #[diagnostic(help("give the way the light travels, such as [0, -1, 0] for straight down"))]
    ZeroDirection,
    /// A light that could be turned any way about its direction.
    #[error("the light's `up` is zero or along its `direction`")]
    #[diagnostic(help("give the way to its upper side, or leave it out"))]
    LightUp,
    /// Coefficients that are no A and pairs of B and C.
    #[error("the medium has {found} coefficients, which are not A and pairs of B and C")]
    #[diagnostic(help(
        "give A, B, C, B, C and so on, with up to {} pairs",
        Medium::MOST_TERMS
    ))]
    Coefficients { found: usize },
    /// A medium whose numbers make no usable index.
    #[error("the medium \"{medium}\" cannot be used: {source}")]
    Medium { medium: String, source: MediumError },
    /// An image that cannot be loaded.
    #[error("the texture \"{texture}\" cannot be loaded")]
    #[diagnostic(help("relative paths start at the folder of the scene file"))]
    Texture { texture: String, source: ImageError },
    /// A texture on a mesh that does not say where it is on it.
    #[error("the object has a texture, but its mesh has no texture coordinates")]
    #[diagnostic(help(
        "export the mesh with coordinates (UVs), or take a material without a texture"
    ))]
    NoCoordinates,
    /// A number that has to be a whole one.
    #[error("`{key}` is {value}, but it must be a whole number")]
    #[diagnostic(help("give a number without a fraction"))]
    NotWhole { key: &'static str, value: f64 },
    /// One of several cameras without its place in time.
    #[error("a camera among others needs `frame`")]
    #[diagnostic(help("add `frame = N`, the picture that is taken from here, counted from 1"))]
    CameraFrame,
    /// Cameras that make no path.
    #[error(transparent)]
    #[diagnostic(transparent)]
    CameraPath(CameraPathError),
    /// A mesh that cannot be loaded.
    #[error("the mesh \"{mesh}\" cannot be loaded")]
    #[diagnostic(help("relative paths start at the folder of the scene file"))]
    Mesh {
        mesh: String,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A mesh that was loaded but cannot be traced.
    #[error("the mesh \"{mesh}\" cannot be used")]
    #[diagnostic(help("repair it in the program that wrote it, or use another"))]
    InvalidMesh { mesh: String, source: MeshError },
    /// A mesh without width, which no scale makes 1 m wide.
    #[error("the mesh is flat along x, so it cannot be normalised")]
    #[diagnostic(help("leave out `normalise` and give the `scale` itself, or turn the mesh"))]
    Flat,
}

/// The least and the most a number may be.
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
pub(super) const LINE_WIDTH: Limits = Limits(1.0e-3, 28.0);
pub(super) const FRAMES: Limits = Limits(1.0, 99_999.0);
pub(super) const DEGREES: Limits = Limits(-360.0, 360.0);
pub(super) const FORM: Limits = Limits(1.0, 2.0);
pub(super) const WAVELENGTH: Limits =
    Limits(Medium::WAVELENGTHS[0] as f64, Medium::WAVELENGTHS[1] as f64);
pub(super) const REPEATS: Limits = Limits(1.0e-3, 1.0e4);
pub(super) const LIGHT_SAMPLES: Limits = Limits(1.0, 64.0);

/// A checked value, or the fault and its place.
pub(super) type Checked<T> = Result<T, Located<SceneFault>>;

/// A key of a scene file.
type Key = &'static str;

/// Where a value is in the text, if it is there.
pub(super) fn span<T>(value: Option<&Spanned<T>>) -> Option<Range<usize>> {
    value.map(Spanned::span)
}

/// Checks values, and makes faults that point into the file.
pub(super) struct Check<'a> {
    pub(super) source: Source<'a>,
}

/// The table that things of a kind are in.
fn plural(kind: &str) -> String {
    match kind {
        "mesh" => "meshes".to_owned(),
        "medium" => "media".to_owned(),
        other => format!("{other}s"),
    }
}

impl Check<'_> {
    pub(super) fn fault(&self, fault: SceneFault, at: Option<Range<usize>>) -> Located<SceneFault> {
        Located::new(fault, &self.source, at)
    }

    pub(super) fn numbers<const N: usize>(
        &self,
        key: Key,
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
        let fault = SceneFault::OutOfRange {
            key,
            value,
            low,
            high,
        };
        Err(self.fault(fault, Some(values.span())))
    }

    pub(super) fn number(&self, key: Key, value: &Number, limits: Limits) -> Checked<f64> {
        let one = Spanned::new(value.span(), [*value.as_ref()]);
        Ok(self.numbers(key, &one, limits)?[0])
    }

    pub(super) fn whole(&self, key: Key, value: &Number, limits: Limits) -> Checked<u32> {
        let number = self.number(key, value, limits)?;
        if number.fract() == 0.0 {
            return Ok(number as u32);
        }
        let fault = SceneFault::NotWhole { key, value: number };
        Err(self.fault(fault, Some(value.span())))
    }

    pub(super) fn colour(&self, key: Key, value: &Numbers, limits: Limits) -> Checked<[f32; 3]> {
        let channels = self.numbers(key, value, limits)?;
        Ok(channels.map(|channel| channel as f32))
    }

    pub(super) fn colour_or(
        &self,
        key: Key,
        value: Option<&Numbers>,
        limits: Limits,
        default: [f32; 3],
    ) -> Checked<[f32; 3]> {
        value.map_or(Ok(default), |value| self.colour(key, value, limits))
    }

    pub(super) fn vector_or(
        &self,
        key: Key,
        value: Option<&Numbers>,
        default: DVec3,
    ) -> Checked<DVec3> {
        let read = |value| self.numbers(key, value, POSITION).map(DVec3::from_array);
        value.map_or(Ok(default), read)
    }

    /// Returns the entry of a name.
    pub(super) fn named<T: Copy>(
        &self,
        kind: &'static str,
        name: &Spanned<String>,
        known: &BTreeMap<&str, T>,
    ) -> Checked<T> {
        let given = name.as_ref();
        known.get(given.as_str()).copied().ok_or_else(|| {
            let suggestion = suggestion(given, known.keys().copied()).unwrap_or_else(|| {
                let tables = plural(kind);
                format!("the file describes no {kind}: add [{tables}.{given}] with its keys")
            });
            let fault = SceneFault::UnknownName {
                kind,
                given: given.clone(),
                suggestion,
            };
            self.fault(fault, Some(name.span()))
        })
    }
}
