//! Materials of a scene file, and what they name.

use super::entries::{GraticuleEntry, MaterialEntry, MediumEntry, SceneEntry, TextureEntry};
use super::fault::{
    ABSORPTION, Check, Checked, DIVISIONS, EXPONENT, FORM, INDEX_OF_REFRACTION, LINE_WIDTH,
    RADIANCE, REPEATS, SHARE, SceneFault, WAVELENGTH, span,
};
use super::{FOLDER, numbers};
use crate::scene::material::{Graticule, Material};
use crate::scene::texture::{Image, Pattern, Texture};
use shisen_core::spectrum::{Medium, MediumError, line};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

type TextureEntries = BTreeMap<Spanned<String>, Spanned<TextureEntry>>;

/// The materials in the order of their names, with the numbers of their textures.
pub(super) fn read_materials(
    check: &Check<'_>,
    entry: &SceneEntry,
) -> Checked<Vec<(Material, Option<usize>)>> {
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

/// Loads the textures into the materials.
pub(super) fn with_textures(
    check: &Check<'_>,
    entries: &TextureEntries,
    base_dir: &Path,
    materials: Vec<(Material, Option<usize>)>,
) -> Checked<Vec<Material>> {
    let textures = read_textures(check, entries, base_dir)?;
    let materials = materials.into_iter().map(|(material, texture)| Material {
        texture: texture.map(|number| textures[number].clone()),
        ..material
    });
    Ok(materials.collect())
}

fn read_material(
    check: &Check<'_>,
    entry: &MaterialEntry,
    textures: &BTreeMap<&str, usize>,
    media: &BTreeMap<&str, Medium>,
) -> Checked<(Material, Option<usize>)> {
    let default = Material::default();
    let colour = |key, value: &Option<_>, limits, default| {
        check.colour_or(key, value.as_ref(), limits, default)
    };
    let share = |key, value, default| colour(key, value, SHARE, default);
    let number = |key, value: &Option<_>, limits, default: f32| -> Checked<f32> {
        let number = value.as_ref().map(|value| check.number(key, value, limits));
        Ok(number.transpose()?.map_or(default, |number| number as f32))
    };
    let texture = entry.texture.as_ref();
    let texture = texture
        .map(|name| check.named("texture", name, textures))
        .transpose()?;
    if entry.transmission.is_none() {
        let owner = "materials with a `transmission`";
        check.only_for(owner, "medium", span(entry.medium.as_ref()))?;
        let index = span(entry.index_of_refraction.as_ref());
        check.only_for(owner, "index_of_refraction", index)?;
        check.only_for(owner, "absorption", span(entry.absorption.as_ref()))?;
    }
    let medium = match &entry.medium {
        None => None,
        Some(name) if entry.index_of_refraction.is_some() => {
            let choice = "at most one of `medium` and `index_of_refraction`";
            return check.refuse_choice("a material", choice, name.span());
        }
        Some(name) => Some(check.named("medium", name, media)?),
    };
    let lines = entry.graticule.as_ref();
    let material = Material {
        diffuse: share("diffuse", &entry.diffuse, default.diffuse)?,
        specular: share("specular", &entry.specular, default.specular)?,
        shininess: number("shininess", &entry.shininess, EXPONENT, default.shininess)?,
        mirror: share("mirror", &entry.mirror, default.mirror)?,
        transmission: share("transmission", &entry.transmission, default.transmission)?,
        index_of_refraction: number(
            "index_of_refraction",
            &entry.index_of_refraction,
            INDEX_OF_REFRACTION,
            default.index_of_refraction,
        )?,
        absorption: colour(
            "absorption",
            &entry.absorption,
            ABSORPTION,
            default.absorption,
        )?,
        graticule: lines
            .map(|lines| read_graticule(check, lines))
            .transpose()?,
        medium,
        texture: None,
        emission: colour("emission", &entry.emission, RADIANCE, default.emission)?,
    };
    Ok((material, texture))
}

fn read_medium(check: &Check<'_>, name: &Spanned<String>, entry: &MediumEntry) -> Checked<Medium> {
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
        let most = Medium::MOST_TERMS;
        return check.refuse(
            format!("the medium has {found} coefficients, which are not A and pairs of B and C"),
            format!("give A, B, C, B, C and so on, with up to {most} pairs"),
            entry.coefficients.span(),
        );
    };
    let medium = if form == 1 {
        Medium::form1(range, a, terms)
    } else {
        Medium::form2(range, a, terms)
    };
    let fault = |source: MediumError| {
        let message = format!("the medium \"{}\" cannot be used: {source}", name.as_ref());
        let fault = SceneFault::caused(message, None, source);
        check.fault(fault, Some(name.span()))
    };
    let medium = medium.map_err(fault)?;
    // Pictures without dispersion take its index there.
    medium.index_in(line::D).map_err(fault)?;
    Ok(medium)
}

fn read_textures(
    check: &Check<'_>,
    entries: &TextureEntries,
    base_dir: &Path,
) -> Checked<Vec<Texture>> {
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
                let image = Image::load(&base_dir.join(file), &mut left);
                let image = image.map_err(|source| {
                    let message = format!("the texture \"{}\" cannot be loaded", name.as_ref());
                    let fault = SceneFault::caused(message, Some(FOLDER), source);
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
                let choice = "one of `file` and `checker`";
                return check.refuse_choice("a texture", choice, name.span());
            }
        };
        textures.push(Texture { pattern, repeats });
    }
    Ok(textures)
}

fn read_graticule(check: &Check<'_>, entry: &GraticuleEntry) -> Checked<Graticule> {
    let width = check.number("width_degrees", &entry.width_degrees, LINE_WIDTH)?;
    Ok(Graticule {
        divisions: check.whole("divisions", &entry.divisions, DIVISIONS)?,
        width: width.to_radians() as f32,
    })
}
