//! Materials of a scene file, and what they name.

use super::entries::{MaterialEntry, MediumEntry, SceneEntry, TextureEntry};
use super::fault::{
    ABSORPTION, Check, Checked, DIVISIONS, EXPONENT, FORM, INDEX_OF_REFRACTION, LINE_WIDTH,
    NORMAL_SCALE, PRIORITY, RADIANCE, REPEATS, SHARE, SceneFault, WAVELENGTH,
};
use super::{advice, numbers};
use crate::scene::material::{Alpha, Cover, Graticule, Material, Microfacets, NormalMap};
use crate::scene::texture::{Image, Pattern, Texture};
use shisen_core::spectrum::{Medium, MediumError, line};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;

/// The numbers of a material's textures.
pub(super) struct TexturesOf {
    pub(super) texture: Option<usize>,
    /// With the scale.
    pub(super) normals: Option<(usize, f32)>,
}

impl TexturesOf {
    /// Returns a material with its textures.
    pub(super) fn applied(&self, material: Material, textures: &[Texture]) -> Material {
        let named = |number: usize| textures[number].clone();
        let texture = self.texture.map(named);
        Material {
            normal_map: self.normals.map(|(number, scale)| NormalMap {
                texture: named(number),
                scale,
            }),
            emission_texture: texture.clone(),
            alpha: material.alpha.map(|alpha| Alpha {
                texture: texture.clone(),
                ..alpha
            }),
            texture,
            ..material
        }
    }
}

/// Returns the materials in the order of their names, with the numbers of their textures.
pub(super) fn read_materials(
    check: &Check<'_>,
    scene: &SceneEntry,
) -> Checked<Vec<(Material, TexturesOf)>> {
    let textures = numbers(&scene.textures);
    // A file's own media come before built-in ones of the same name.
    let mut media: BTreeMap<&str, Medium> = Medium::NAMED.into();
    for (name, entry) in &scene.media {
        media.insert(name.as_ref(), read_medium(check, name, entry.as_ref())?);
    }
    let materials = scene.materials.iter().map(|(name, entry)| {
        let material = read_material(check, entry, &media)?;
        let name = name.as_ref().clone();
        let textures = TexturesOf {
            texture: check.name("texture", &entry.texture, &textures)?,
            normals: read_normals(check, entry, &textures, scene)?,
        };
        Ok((Material { name, ..material }, textures))
    });
    materials.collect()
}

fn read_material(
    check: &Check<'_>,
    entry: &MaterialEntry,
    media: &BTreeMap<&str, Medium>,
) -> Checked<Material> {
    let index = &entry.index_of_refraction;
    if entry.transmission.is_none() {
        let owner = "materials with a `transmission`";
        check.only_for(owner, "medium", &entry.medium)?;
        check.only_for(owner, "index_of_refraction", index)?;
        check.only_for(owner, "absorption", &entry.absorption)?;
        check.only_for(owner, "priority", &entry.priority)?;
    }
    if let (Some(medium), Some(_)) = (&entry.medium, index) {
        let choice = "at most one of `medium` and `index_of_refraction`";
        return check.refuse_keys("a material", choice, medium.span());
    }
    let default = Material::default();
    let microfacets = read_microfacets(check, entry)?;
    let specular = microfacets.as_ref().map_or(default.specular, |_| [0.04; 3]);
    let colour = |key, value, limits, default| check.colour_or(key, value, limits, default);
    let share = |key, value, default| colour(key, value, SHARE, default);
    let number = |key, value, limits, default| check.number_or(key, value, limits, default);
    let glass = default.index_of_refraction;
    let alpha = read_alpha(check, entry)?;
    // A veil where it is seen as far as it is opaque.
    let is_blended = alpha
        .as_ref()
        .is_some_and(|alpha| alpha.cover == Cover::Blend);
    let (transmission, glass) = if is_blended {
        ([1.0; 3], 1.0)
    } else {
        (default.transmission, glass)
    };
    Ok(Material {
        name: String::new(),
        emission_texture: None,
        microfacets,
        normal_map: None,
        alpha,
        vertex_colours: false,
        medium: check.name("medium", &entry.medium, media)?,
        diffuse: share("diffuse", &entry.diffuse, default.diffuse)?,
        specular: share("specular", &entry.specular, specular)?,
        shininess: number("shininess", &entry.shininess, EXPONENT, default.shininess)?,
        mirror: share("mirror", &entry.mirror, default.mirror)?,
        transmission: share("transmission", &entry.transmission, transmission)?,
        index_of_refraction: number("index_of_refraction", index, INDEX_OF_REFRACTION, glass)?,
        priority: match &entry.priority {
            None => 0,
            Some(priority) => check.whole("priority", priority, PRIORITY)?,
        },
        absorption: colour("absorption", &entry.absorption, ABSORPTION, [0.0; 3])?,
        graticule: match &entry.graticule {
            None => None,
            Some(lines) => {
                let width = check.number("width_degrees", &lines.width_degrees, LINE_WIDTH)?;
                Some(Graticule {
                    divisions: check.whole("divisions", &lines.divisions, DIVISIONS)?,
                    width: width.to_radians() as f32,
                })
            }
        },
        texture: None,
        emission: colour("emission", &entry.emission, RADIANCE, default.emission)?,
    })
}

/// Returns the texture that bends a material's normals, and its scale.
fn read_normals(
    check: &Check<'_>,
    entry: &MaterialEntry,
    textures: &BTreeMap<&str, usize>,
    scene: &SceneEntry,
) -> Checked<Option<(usize, f32)>> {
    let number = check.name("texture", &entry.normal_texture, textures)?;
    if let Some(name) = &entry.normal_texture
        && let Some(texture) = scene.textures.get(name)
        && texture.as_ref().checker.is_some()
    {
        let message = format!(
            "the texture \"{}\" is a checker, not an image",
            name.as_ref()
        );
        let help = "give a texture with a `file` that shows normals";
        return check.refuse(message, help, name.span());
    }
    if number.is_none() {
        let owner = "materials with a `normal_texture`";
        check.only_for(owner, "normal_scale", &entry.normal_scale)?;
    }
    let scale = check.number_or("normal_scale", &entry.normal_scale, NORMAL_SCALE, 1.0)?;
    Ok(number.map(|number| (number, scale)))
}

/// Returns what a material says of its texture's alpha; `None` if nothing.
fn read_alpha(check: &Check<'_>, entry: &MaterialEntry) -> Checked<Option<Alpha>> {
    if entry.alpha_cutoff.is_none() {
        return Ok(None);
    }
    let owner = "materials without `alpha_cutoff`";
    check.only_for(owner, "transmission", &entry.transmission)?;
    let cutoff = check.number_or("alpha_cutoff", &entry.alpha_cutoff, SHARE, 0.0)?;
    Ok(Some(Alpha {
        opacity: 1.0,
        texture: None,
        cover: if cutoff > 0.0 {
            Cover::Mask(cutoff)
        } else {
            Cover::Blend
        },
    }))
}

/// Returns what a material says of metal and roughness; `None` if nothing.
fn read_microfacets(check: &Check<'_>, entry: &MaterialEntry) -> Checked<Option<Microfacets>> {
    if entry.metalness.is_none() && entry.roughness.is_none() {
        return Ok(None);
    }
    let owner = "materials without `metalness` and `roughness`";
    check.only_for(owner, "mirror", &entry.mirror)?;
    check.only_for(owner, "shininess", &entry.shininess)?;
    Ok(Some(Microfacets {
        metalness: check.number_or("metalness", &entry.metalness, SHARE, 0.0)?,
        roughness: check.number_or("roughness", &entry.roughness, SHARE, 0.5)?,
        texture: None,
    }))
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

pub(super) fn read_textures(
    check: &Check<'_>,
    entries: &BTreeMap<Spanned<String>, Spanned<TextureEntry>>,
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
                    let help = advice(Some(&source));
                    let fault = SceneFault::caused(message, Some(&help), source);
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
                return check.refuse_keys("a texture", choice, name.span());
            }
        };
        textures.push(Texture::new(pattern, repeats));
    }
    Ok(textures)
}
