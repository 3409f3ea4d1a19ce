//! Materials of a scene file, and what they name.

use super::entries::{GraticuleEntry, MaterialEntry, MediumEntry, SceneEntry, TextureEntry};
use super::fault::{
    ABSORPTION, Check, DIVISIONS, EXPONENT, FORM, INDEX_OF_REFRACTION, LINE_WIDTH, RADIANCE,
    REPEATS, SHARE, SceneFault, WAVELENGTH,
};
use super::numbers;
use crate::files::description::Located;
use crate::scene::material::{Graticule, Material};
use crate::scene::texture::{Image, Pattern, Texture};
use shisen_core::spectrum::{Medium, line};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

type TextureEntries = BTreeMap<Spanned<String>, Spanned<TextureEntry>>;

/// The materials in the order of their names, each with the number of its
/// texture, if it has one.
pub(super) fn read_materials(
    check: &Check<'_>,
    entry: &SceneEntry,
) -> Result<Vec<(Material, Option<usize>)>, Located<SceneFault>> {
    let textures = numbers(&entry.textures);
    // A file's own media come before built-in ones of the same name.
    let mut media: BTreeMap<&str, Medium> = Medium::NAMED.into();
    for (name, entry) in &entry.media {
        media.insert(name.as_ref(), read_medium(check, name, entry.as_ref())?);
    }
    let materials = entry.materials.values();
    materials
        .map(|entry| read_material(check, entry, &textures, &media))
        .collect()
}

/// The materials with their textures, which are loaded for it.
pub(super) fn with_textures(
    check: &Check<'_>,
    entries: &TextureEntries,
    base_dir: &Path,
    materials: Vec<(Material, Option<usize>)>,
) -> Result<Vec<Material>, Located<SceneFault>> {
    let textures = read_textures(check, entries, base_dir)?;
    let materials = materials.into_iter().map(|(material, texture)| Material {
        texture: texture.map(|number| textures[number].clone()),
        ..material
    });
    Ok(materials.collect())
}

/// A material but for its texture, and the number of that.
fn read_material(
    check: &Check<'_>,
    entry: &MaterialEntry,
    textures: &BTreeMap<&str, usize>,
    media: &BTreeMap<&str, Medium>,
) -> Result<(Material, Option<usize>), Located<SceneFault>> {
    let default = Material::default();
    let share = |key, value: &Option<Spanned<[f64; 3]>>, default| {
        check.colour_or(key, value.as_ref(), SHARE, default)
    };
    let texture = match &entry.texture {
        None => None,
        Some(name) => Some(check.named("texture", name, textures)?),
    };
    if entry.transmission.is_none() {
        let medium = entry.medium.as_ref().map(Spanned::span);
        let index = entry.index_of_refraction.as_ref().map(Spanned::span);
        let absorption = entry.absorption.as_ref().map(Spanned::span);
        for (key, span) in [
            ("medium", medium),
            ("index_of_refraction", index),
            ("absorption", absorption),
        ] {
            if span.is_some() {
                let owner = "materials with a `transmission`";
                return Err(check.fault(SceneFault::NotHere { key, owner }, span));
            }
        }
    }
    let medium = match &entry.medium {
        None => None,
        Some(name) if entry.index_of_refraction.is_some() => {
            let fault = SceneFault::Choice {
                owner: "a material",
                choice: "at most one of `medium` and `index_of_refraction`",
            };
            return Err(check.fault(fault, Some(name.span())));
        }
        Some(name) => Some(check.named("medium", name, media)?),
    };
    let material = Material {
        diffuse: share("diffuse", &entry.diffuse, default.diffuse)?,
        specular: share("specular", &entry.specular, default.specular)?,
        shininess: check.number_or(
            "shininess",
            entry.shininess.as_ref(),
            EXPONENT,
            default.shininess.into(),
        )? as f32,
        mirror: share("mirror", &entry.mirror, default.mirror)?,
        transmission: share("transmission", &entry.transmission, default.transmission)?,
        index_of_refraction: check.number_or(
            "index_of_refraction",
            entry.index_of_refraction.as_ref(),
            INDEX_OF_REFRACTION,
            default.index_of_refraction.into(),
        )? as f32,
        absorption: check.colour_or(
            "absorption",
            entry.absorption.as_ref(),
            ABSORPTION,
            default.absorption,
        )?,
        graticule: match &entry.graticule {
            None => None,
            Some(lines) => Some(read_graticule(check, lines)?),
        },
        medium,
        texture: None,
        emission: check.colour_or(
            "emission",
            entry.emission.as_ref(),
            RADIANCE,
            default.emission,
        )?,
    };
    Ok((material, texture))
}

fn read_medium(
    check: &Check<'_>,
    name: &Spanned<String>,
    entry: &MediumEntry,
) -> Result<Medium, Located<SceneFault>> {
    let form = check.whole("form", &entry.form, FORM)?;
    let range = check
        .numbers("range_nm", &entry.range_nm, WAVELENGTH)?
        .map(|nm| nm as f32);
    let coefficients = entry.coefficients.as_ref();
    let coefficients: Vec<f32> = coefficients.iter().map(|&c| c as f32).collect();
    let terms = coefficients
        .split_first()
        .map(|(a, rest)| (*a, rest.as_chunks()));
    let Some((a, (terms, []))) = terms else {
        let found = coefficients.len();
        let fault = SceneFault::Coefficients { found };
        return Err(check.fault(fault, Some(entry.coefficients.span())));
    };
    let medium = if form == 1 {
        Medium::form1(range, a, terms)
    } else {
        Medium::form2(range, a, terms)
    };
    let fault = |source| {
        let medium = name.as_ref().clone();
        check.fault(SceneFault::Medium { medium, source }, Some(name.span()))
    };
    let medium = medium.map_err(fault)?;
    // Pictures without dispersion take its index there.
    medium.index_in(line::D).map_err(fault)?;
    Ok(medium)
}

/// The textures in the order of their names.
fn read_textures(
    check: &Check<'_>,
    entries: &TextureEntries,
    base_dir: &Path,
) -> Result<Vec<Texture>, Located<SceneFault>> {
    let mut left = Image::MOST_BYTES;
    let mut textures = Vec::with_capacity(entries.len());
    for (name, entry) in entries {
        let TextureEntry {
            file,
            checker,
            repeats,
        } = entry.as_ref();
        let repeats = match repeats {
            None => [1.0; 2],
            Some(repeats) => check
                .numbers("repeats", repeats, REPEATS)?
                .map(|number| number as f32),
        };
        let pattern = match (file, checker) {
            (Some(file), None) => {
                let image = Image::load_within(&base_dir.join(file), &mut left);
                let image = image.map_err(|source| {
                    let texture = name.as_ref().clone();
                    let fault = SceneFault::Texture { texture, source };
                    check.fault(fault, Some(entry.span()))
                })?;
                Pattern::Image(Arc::new(image))
            }
            (None, Some(checker)) => {
                let [first, second] = &checker.colours;
                Pattern::Checker([
                    check.colour("colours", first, SHARE)?,
                    check.colour("colours", second, SHARE)?,
                ])
            }
            _ => {
                let fault = SceneFault::Choice {
                    owner: "a texture",
                    choice: "one of `file` and `checker`",
                };
                return Err(check.fault(fault, Some(name.span())));
            }
        };
        textures.push(Texture { pattern, repeats });
    }
    Ok(textures)
}

fn read_graticule(
    check: &Check<'_>,
    entry: &GraticuleEntry,
) -> Result<Graticule, Located<SceneFault>> {
    let GraticuleEntry {
        divisions,
        width_degrees,
    } = entry;
    let width = check.number("width_degrees", width_degrees, LINE_WIDTH)?;
    Ok(Graticule {
        divisions: check.whole("divisions", divisions, DIVISIONS)?,
        width: width.to_radians() as f32,
    })
}
