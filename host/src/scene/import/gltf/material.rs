//! Materials of glTF files, and their images.

use super::super::{Textures, beside, bounded, bounded_colour, read_one_of};
use super::Importer;
use super::accessors::{data_of, is_below, percent_decoded};
use crate::scene::material::Material;
use crate::scene::texture::{Pattern, Texture};
use gltf::material::AlphaMode;
use gltf::texture::Info;
use gltf::{Document, image};
use std::borrow::Cow;

/// Metalness from which a smooth surface is a mirror.
const METALLIC: f32 = 0.5;
/// Roughness up to which a metallic surface is a mirror.
const SMOOTH: f32 = 0.3;

/// Extensions of materials that change no picture here, and what their uses are called.
const EXTENSIONS: [(&str, &str); 6] = [
    ("KHR_materials_anisotropy", "anisotropic highlight{s}"),
    ("KHR_materials_clearcoat", "clear coat{s}"),
    (
        "KHR_materials_diffuse_transmission",
        "diffuse transmission{s}",
    ),
    ("KHR_materials_dispersion", "dispersion{s}"),
    ("KHR_materials_iridescence", "iridescence{s}"),
    ("KHR_materials_sheen", "sheen{s}"),
];

impl Importer<'_> {
    /// Fills in the materials; triangles without one get the default, and a mesh without any stays
    /// without.
    pub(super) fn paint(&mut self, document: &Document) {
        let fallback = document.materials().len() as u32;
        if fallback == 0 {
            self.mesh.triangle_materials.clear();
            return;
        }
        let mut textures = Textures::new();
        for material in document.materials() {
            let mut painted = whitted(&material);
            let base = material.pbr_metallic_roughness().base_color_texture();
            if let Some(info) = base
                && !self.mesh.coordinates.is_empty()
            {
                painted.texture = self.texture(&info, &mut textures);
            }
            self.count_unused_of(&material);
            self.mesh.materials.push(painted);
        }
        let mut lacks = false;
        for material in &mut self.mesh.triangle_materials {
            *material = (*material).min(fallback);
            lacks |= *material == fallback;
        }
        if lacks {
            self.mesh.materials.push(Material::default());
        }
    }

    fn texture(&mut self, info: &Info<'_>, textures: &mut Textures<usize>) -> Option<Texture> {
        if info.tex_coord() != 0 {
            self.unused.add("texture{s} on further coordinates", 1);
            return None;
        }
        let source = info.texture().source()?;
        let name = match source.source() {
            image::Source::Uri { uri, .. } if !uri.starts_with("data:") => uri.to_owned(),
            _ => source.name().map_or_else(
                || format!("{} (counted from 0)", source.index()),
                |name| format!("\"{name}\""),
            ),
        };
        let mut unused = std::mem::take(&mut self.unused);
        let read = || self.image(&source);
        let image = textures.get(source.index(), &name, &mut unused, read);
        self.unused = unused;
        Some(Texture {
            pattern: Pattern::Image(image?),
            repeats: [1.0; 2],
        })
    }

    fn image(&self, image: &gltf::Image<'_>) -> Result<Cow<'_, [u8]>, String> {
        match image.source() {
            image::Source::View { view, .. } => {
                let bytes = self.buffers.view(&view);
                bytes.map(Cow::Borrowed).map_err(|fault| fault.to_string())
            }
            image::Source::Uri { uri, .. } => {
                if let Some(data) = data_of(uri) {
                    return Ok(Cow::Owned(data?));
                }
                let name = percent_decoded(uri).unwrap_or_else(|| uri.to_owned());
                let [named, beside] = beside(self.path, &name);
                let paths = if is_below(&name) {
                    vec![named, beside]
                } else {
                    vec![beside]
                };
                Ok(Cow::Owned(read_one_of(&paths)?))
            }
        }
    }

    fn count_unused_of(&mut self, material: &gltf::Material<'_>) {
        let pbr = material.pbr_metallic_roughness();
        let has_alpha = pbr.base_color_texture().is_some();
        for (kind, is_there) in [
            ("normal map{s}", material.normal_texture().is_some()),
            ("occlusion map{s}", material.occlusion_texture().is_some()),
            ("emission map{s}", material.emissive_texture().is_some()),
            (
                "alpha mask{s}",
                has_alpha && material.alpha_mode() == AlphaMode::Mask,
            ),
            (
                "map{s} of metal and roughness",
                pbr.metallic_roughness_texture().is_some(),
            ),
        ] {
            self.unused.add(kind, u64::from(is_there));
        }
        for (name, kind) in EXTENSIONS {
            let is_there = material.extension_value(name).is_some();
            self.unused.add(kind, u64::from(is_there));
        }
    }
}

/// Maps a material onto Whitted's terms, as [`super::load`] documents.
fn whitted(material: &gltf::Material<'_>) -> Material {
    let default = Material::default();
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = pbr.base_color_factor();
    let base = bounded_colour([r, g, b]);
    let name = material.name().unwrap_or_default().to_owned();
    let emission = material.emissive_strength().unwrap_or(1.0);
    let emission = material.emissive_factor().map(|channel| channel * emission);
    let emission = emission.map(|channel| bounded(channel, 0.0, 1.0e6));
    if material.unlit() {
        return Material {
            name,
            diffuse: [0.0; 3],
            emission: base,
            ..default
        };
    }
    let opacity = match material.alpha_mode() {
        AlphaMode::Blend => bounded(alpha, 0.0, 1.0),
        AlphaMode::Opaque | AlphaMode::Mask => 1.0,
    };
    // A factor of its map, which says where the metal is.
    let metalness = match pbr.metallic_roughness_texture() {
        Some(_) => 0.0,
        None => bounded(pbr.metallic_factor(), 0.0, 1.0),
    };
    let roughness = bounded(pbr.roughness_factor(), 0.0, 1.0);
    let transmission = material
        .transmission()
        .map_or(0.0, |t| bounded(t.transmission_factor(), 0.0, 1.0));
    let is_mirror = metalness >= METALLIC && roughness <= SMOOTH;
    // Dielectrics reflect about 4 % head-on, metals their own colour.
    let specular = base.map(|channel| 0.04 + (channel - 0.04) * metalness);
    // The exponent whose lobe is as wide as the microfacets' of this roughness.
    let alpha = roughness * roughness;
    let shininess = 2.0 / (alpha * alpha).max(f32::MIN_POSITIVE) - 2.0;
    // 0 is the extension's mark for a surface without Fresnel's terms.
    let index = material.ior();
    let index = index.filter(|index| *index > 0.0 && index.is_finite());
    let index = index.map_or(default.index_of_refraction, |index| {
        bounded(index, 0.01, 100.0)
    });
    if opacity < 1.0 && transmission == 0.0 {
        // A veil: what is behind it is seen straight through.
        return Material {
            name,
            diffuse: base.map(|channel| channel * opacity),
            specular: [0.04 * opacity; 3],
            shininess: bounded(shininess, 1.0, 10_000.0),
            transmission: [1.0 - opacity; 3],
            index_of_refraction: 1.0,
            emission,
            ..default
        };
    }
    Material {
        name,
        emission,
        diffuse: if is_mirror {
            [0.0; 3]
        } else {
            base.map(|channel| channel * (1.0 - transmission))
        },
        specular,
        shininess: bounded(shininess, 1.0, 10_000.0),
        mirror: if is_mirror { base } else { default.mirror },
        transmission: base.map(|channel| channel * transmission),
        index_of_refraction: index,
        absorption: material
            .volume()
            .filter(|volume| volume.thickness_factor() > 0.0)
            .map_or(default.absorption, |volume| absorption(&volume)),
        ..default
    }
}

/// Beer's coefficients from the colour that white light has after a distance.
fn absorption(volume: &gltf::material::Volume<'_>) -> [f32; 3] {
    let distance = volume.attenuation_distance();
    if distance.is_finite() && distance > 0.0 {
        // Black would be absorbed without end.
        let colour = volume.attenuation_color();
        colour.map(|channel| bounded(-bounded(channel, 1.0e-4, 1.0).ln() / distance, 0.0, 1.0e6))
    } else {
        [0.0; 3]
    }
}
