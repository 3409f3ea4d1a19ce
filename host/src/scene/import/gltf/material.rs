//! Materials of glTF files, and their images.

use super::Importer;
use super::accessors::{data_of, file_name, is_below};
use crate::scene::import::{Textures, beside, bounded, bounded_colour, read_one_of};
use crate::scene::material::{Alpha, Cover, Material, Microfacets, NormalMap};
use crate::scene::texture::{Pattern, Texture, Wrap};
use gltf::Document;
use gltf::json::extensions::texture::TextureTransform;
use gltf::material::{AlphaMode, NormalTexture, PbrSpecularGlossiness};
use gltf::texture::{Info, MagFilter, WrappingMode};
use serde::Deserialize as _;
use shisen_core::spectrum::{Medium, line};
use std::borrow::Cow;

/// Extensions of materials that change no picture here, and what their uses are called.
const EXTENSIONS: [(&str, &str); 5] = [
    ("KHR_materials_anisotropy", "anisotropic highlight{s}"),
    ("KHR_materials_clearcoat", "clear coat{s}"),
    (
        "KHR_materials_diffuse_transmission",
        "diffuse transmission{s}",
    ),
    ("KHR_materials_iridescence", "iridescence{s}"),
    ("KHR_materials_sheen", "sheen{s}"),
];

/// Extensions of textures in formats that are not read.
const FORMATS: [(&str, &str); 4] = [
    ("KHR_texture_basisu", "KTX2"),
    ("EXT_texture_webp", "WebP"),
    ("EXT_texture_avif", "AVIF"),
    ("MSFT_texture_dds", "DDS"),
];

impl Importer<'_> {
    /// Fills in the materials; triangles without one get the format's default, and a mesh without
    /// any stays without.
    pub(super) fn paint(&mut self, document: &Document) {
        let fallback = document.materials().len() as u32;
        if fallback == 0 {
            self.mesh.triangle_materials.clear();
            if !self.mesh.colours.is_empty() {
                self.mesh.paint_by_vertices();
            }
            return;
        }
        let mut textures = Textures::new();
        for material in document.materials() {
            let painted = self.painted(document, &material, &mut textures);
            self.count_unused_of(&material, &painted);
            self.mesh.materials.push(painted);
        }
        let mut lacks = false;
        for material in &mut self.mesh.triangle_materials {
            *material = (*material).min(fallback);
            lacks |= *material == fallback;
        }
        if lacks {
            // White rough metal, as the format demands.
            let default = Material {
                diffuse: [1.0; 3],
                specular: [0.04; 3],
                microfacets: Some(Microfacets {
                    metalness: 1.0,
                    roughness: 1.0,
                    texture: None,
                }),
                vertex_colours: !self.mesh.colours.is_empty(),
                ..Material::default()
            };
            self.mesh.materials.push(default);
        }
    }

    /// Maps a material onto ours, as [`crate::scene::import::load`] documents.
    fn painted(
        &mut self,
        document: &Document,
        material: &gltf::Material<'_>,
        textures: &mut Textures<usize>,
    ) -> Material {
        let pbr = material.pbr_metallic_roughness();
        let older = material.pbr_specular_glossiness();
        let base = match &older {
            Some(older) => older.diffuse_texture(),
            None => pbr.base_color_texture(),
        };
        let base = base.and_then(|info| self.texture(document, &info.into(), textures));
        let has_alpha = matches!(base.as_ref().map(|base| &base.pattern),
            Some(Pattern::Image(image)) if !image.is_opaque());
        let mut painted = whitted(material, has_alpha);
        if painted.transmission != [0.0; 3]
            && volume(material).is_some()
            && let Some(dispersion) = dispersion(material)
        {
            painted.medium = medium(painted.index_of_refraction, dispersion);
            self.unused.add(
                "dispersion{s} beyond what a medium can have",
                u64::from(painted.medium.is_none()),
            );
        }
        // Vertices colour what a lit surface scatters or lets through, not its emission.
        let scatters = painted.diffuse != [0.0; 3] || painted.transmission != [0.0; 3];
        painted.vertex_colours = !self.mesh.colours.is_empty() && (scatters || material.unlit());
        if let Some(alpha) = &mut painted.alpha
            && has_alpha
        {
            alpha.texture.clone_from(&base);
        }
        let mut texture = |info: Option<Reference<'_>>| self.texture(document, &info?, textures);
        if material.unlit() {
            painted.emission_texture = base;
            return painted;
        }
        painted.texture = base;
        painted.emission_texture = texture(material.emissive_texture().map(Reference::from));
        if let Some(facets) = &mut painted.microfacets {
            facets.texture = texture(pbr.metallic_roughness_texture().map(Reference::from));
        }
        if let Some(map) = material.normal_texture() {
            painted.normal_map = texture(Some(Reference::from(&map))).map(|texture| NormalMap {
                texture,
                scale: bounded(map.scale(), -1.0e3, 1.0e3),
            });
        }
        painted
    }

    fn texture(
        &mut self,
        document: &Document,
        of: &Reference<'_>,
        textures: &mut Textures<usize>,
    ) -> Option<Texture> {
        if self.mesh.coordinates.is_empty() {
            self.unused
                .add("texture{s} of faces without texture coordinates", 1);
            return None;
        }
        if of.set >= 2 {
            self.unused
                .add("texture{s} on further coordinates than two", 1);
            return None;
        }
        let Some(image) = of.texture.source() else {
            self.unused.add(unread(document, &of.texture), 1);
            return None;
        };
        let name = name(document, &image);
        let mut unused = std::mem::take(&mut self.unused);
        let read = || self.image(document, &image);
        let image = textures.get(image.index(), &name, &mut unused, read);
        self.unused = unused;
        let sampler = of.texture.sampler();
        let plain = Texture::new(Pattern::Image(image?), [1.0; 2]);
        Some(Texture {
            map: of.map.unwrap_or(plain.map),
            wrap: [sampler.wrap_s(), sampler.wrap_t()].map(|way| match way {
                WrappingMode::Repeat => Wrap::Repeat,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::ClampToEdge => Wrap::Clamp,
            }),
            nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
            second_coordinates: of.set == 1,
            ..plain
        })
    }

    fn image(&self, document: &Document, image: &gltf::Image<'_>) -> Result<Cow<'_, [u8]>, String> {
        match source(document, image) {
            None => Err("has neither a URI nor a buffer view".to_owned()),
            Some(Source::View(view)) => {
                let bytes = self.buffers.view(&view);
                bytes.map(Cow::Borrowed).map_err(|fault| fault.to_string())
            }
            Some(Source::Uri(uri)) => {
                if let Some(data) = data_of(uri) {
                    return Ok(Cow::Owned(data?));
                }
                let name = file_name(uri);
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

    fn count_unused_of(&mut self, material: &gltf::Material<'_>, painted: &Material) {
        let older = material.pbr_specular_glossiness();
        let pbr = material.pbr_metallic_roughness();
        for (kind, is_there) in [
            ("occlusion map{s}", material.occlusion_texture().is_some()),
            (
                "map{s} of specular colour and glossiness",
                older.is_some_and(|older| older.specular_glossiness_texture().is_some()),
            ),
            (
                "rough transmission{s}",
                painted.transmission != [0.0; 3]
                    && material.transmission().is_some()
                    && pbr.roughness_factor() > 0.0,
            ),
            (
                "map{s} of transmission",
                material
                    .transmission()
                    .is_some_and(|of| of.transmission_texture().is_some()),
            ),
            (
                "map{s} of specular colour",
                material.specular().is_some_and(|of| {
                    of.specular_texture().is_some() || of.specular_color_texture().is_some()
                }),
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

/// A texture that a material names.
struct Reference<'d> {
    texture: gltf::Texture<'d>,
    /// Its set of coordinates.
    set: u32,
    /// From coordinates that go up to those on it; `None` where it does not say.
    map: Option<[[f32; 2]; 3]>,
}

impl<'d> From<Info<'d>> for Reference<'d> {
    fn from(info: Info<'d>) -> Self {
        let moved = info.texture_transform();
        let set = moved
            .as_ref()
            .and_then(gltf::texture::TextureTransform::tex_coord);
        Self {
            texture: info.texture(),
            set: set.unwrap_or(info.tex_coord()),
            map: moved.map(|moved| map(moved.offset(), moved.rotation(), moved.scale())),
        }
    }
}

impl<'d> From<&NormalTexture<'d>> for Reference<'d> {
    fn from(info: &NormalTexture<'d>) -> Self {
        let moved = info.extension_value("KHR_texture_transform");
        let moved = moved.and_then(|value| TextureTransform::deserialize(value).ok());
        let set = moved.as_ref().and_then(|moved| moved.tex_coord);
        Self {
            texture: info.texture(),
            set: set.unwrap_or(info.tex_coord()),
            map: moved.map(|moved| map(moved.offset.0, moved.rotation.0, moved.scale.0)),
        }
    }
}

/// Where the bytes of an image are.
enum Source<'d> {
    View(gltf::buffer::View<'d>),
    Uri(&'d str),
}

/// Returns where an image is: the parser panics where a file does not say it, or leaves out a
/// type.
fn source<'d>(document: &'d Document, image: &gltf::Image<'_>) -> Option<Source<'d>> {
    let image = document.as_json().images.get(image.index())?;
    let uri = image.uri.as_deref().map(Source::Uri);
    uri.or_else(|| {
        let view = image.buffer_view?.value();
        document.views().nth(view).map(Source::View)
    })
}

/// Returns what messages call an image.
fn name(document: &Document, image: &gltf::Image<'_>) -> String {
    match source(document, image) {
        Some(Source::Uri(uri)) if !uri.starts_with("data:") => uri.to_owned(),
        _ => image.name().map_or_else(
            || format!("{} (counted from 0)", image.index()),
            |name| format!("\"{name}\""),
        ),
    }
}

/// Returns the kind of unused things of a texture without a PNG or JPEG image.
fn unread(document: &Document, texture: &gltf::Texture<'_>) -> String {
    for (extension, format) in FORMATS {
        let value = texture.extension_value(extension);
        let number = value.and_then(|value| value.get("source")?.as_u64());
        let image = number.and_then(|number| document.images().nth(number as usize));
        if let Some(image) = image {
            let name = name(document, &image);
            return format!("the texture {name} (in {format}, which is not read)");
        }
    }
    "texture{s} without an image".to_owned()
}

/// Returns the map that `KHR_texture_transform` describes for coordinates that go down, for such as
/// go up.
fn map([x, y]: [f32; 2], rotation: f32, [across, down]: [f32; 2]) -> [[f32; 2]; 3] {
    let (sin, cos) = (libm::sinf(rotation), libm::cosf(rotation));
    let map = [
        [cos * across, sin * across],
        [-sin * down, cos * down],
        [x + sin * down, 1.0 - y - cos * down],
    ];
    map.map(|axis| axis.map(|number| bounded(number, -1.0e6, 1.0e6)))
}

/// The index of refraction of walls without thickness: light goes straight on, and unlike behind a
/// veil of index 1 it takes their colour.
const THIN: f32 = 1.0 + 1.0e-6;

/// Maps a material onto ours, without its textures; `has_alpha` says whether that of its base colour
/// has alpha.
fn whitted(material: &gltf::Material<'_>, has_alpha: bool) -> Material {
    let default = Material::default();
    let pbr = material.pbr_metallic_roughness();
    let older = material.pbr_specular_glossiness();
    let base = older.as_ref().map(PbrSpecularGlossiness::diffuse_factor);
    let [r, g, b, alpha] = base.unwrap_or(pbr.base_color_factor());
    let base = older.as_ref().map_or([r, g, b], |older| metal_of(older).0);
    let base = bounded_colour(base);
    let share = |value: f32| bounded(value, 0.0, 1.0);
    let strength = material.emissive_strength().unwrap_or(1.0);
    let emission = material.emissive_factor();
    let emission = emission.map(|channel| bounded(channel * strength, 0.0, 1.0e6));
    let named = Material {
        name: material.name().unwrap_or_default().to_owned(),
        emission,
        ..default.clone()
    };
    let transmission = material.transmission();
    let transmission = transmission.map_or(0.0, |one| share(one.transmission_factor()));
    let is_veil = transmission == 0.0 && (has_alpha || share(alpha) < 1.0);
    let (opacity, cover) = match material.alpha_mode() {
        AlphaMode::Blend if is_veil => (1.0, Some(Cover::Blend)),
        AlphaMode::Blend => (share(alpha), None),
        AlphaMode::Mask => {
            let cutoff = share(material.alpha_cutoff().unwrap_or(0.5));
            let has_holes = cutoff > 0.0 && (has_alpha || share(alpha) < cutoff);
            (1.0, has_holes.then_some(Cover::Mask(cutoff)))
        }
        AlphaMode::Opaque => (1.0, None),
    };
    let named = Material {
        alpha: cover.map(|cover| Alpha {
            opacity: share(alpha),
            texture: None,
            cover,
        }),
        ..named
    };
    let is_blended = cover == Some(Cover::Blend);
    if material.unlit() {
        return Material {
            diffuse: [0.0; 3],
            emission: base.map(|channel| channel * opacity),
            transmission: [if is_blended { 1.0 } else { 1.0 - opacity }; 3],
            index_of_refraction: 1.0,
            ..named
        };
    }
    let (metalness, roughness, specular) = reflection(material);
    let lit = Material {
        specular: specular.map(|channel| channel * opacity),
        microfacets: Some(Microfacets {
            metalness,
            roughness,
            texture: None,
        }),
        ..named
    };
    if is_blended {
        // A veil: what is behind it is seen straight through.
        return Material {
            diffuse: base,
            transmission: [1.0; 3],
            index_of_refraction: 1.0,
            ..lit
        };
    }
    let volume = volume(material);
    // 0 is the extension's mark for a surface without Fresnel's terms.
    let index = material.ior();
    let index = index.filter(|index| *index > 0.0 && index.is_finite());
    let index = match index {
        _ if transmission > 0.0 && volume.is_none() => THIN,
        Some(index) => bounded(index, 0.01, 100.0),
        None => default.index_of_refraction,
    };
    Material {
        diffuse: base.map(|channel| channel * (1.0 - transmission)),
        transmission: base.map(|channel| channel * transmission),
        index_of_refraction: index,
        absorption: volume.map_or(default.absorption, |volume| absorption(&volume)),
        ..lit
    }
}

/// Returns what fills a material's surface, if that is not a thin wall.
fn volume<'d>(material: &gltf::Material<'d>) -> Option<gltf::material::Volume<'d>> {
    let volume = material.volume();
    volume.filter(|volume| volume.thickness_factor() > 0.0)
}

/// Returns a material's metalness, roughness and reflectance where it is no metal.
fn reflection(material: &gltf::Material<'_>) -> (f32, f32, [f32; 3]) {
    let share = |value: f32| bounded(value, 0.0, 1.0);
    if let Some(older) = material.pbr_specular_glossiness() {
        let roughness = 1.0 - share(older.glossiness_factor());
        let (_, metalness) = metal_of(&older);
        let specular = bounded_colour(older.specular_factor());
        return (metalness, roughness, specular);
    }
    let pbr = material.pbr_metallic_roughness();
    let [metalness, roughness] = [pbr.metallic_factor(), pbr.roughness_factor()].map(share);
    let tint = material.specular().map_or([1.0; 3], |specular| {
        let colour = specular.specular_color_factor();
        colour.map(|channel| channel * specular.specular_factor())
    });
    // Dielectrics reflect about 4 % head-on.
    let specular = bounded_colour(tint.map(|channel| 0.04 * channel));
    (metalness, roughness, specular)
}

/// Returns the base colour and the share of metal that a surface of the older kind has, by the
/// conversion of the Khronos Group's 3D working group: dielectrics reflect 4 %.
fn metal_of(older: &PbrSpecularGlossiness<'_>) -> ([f32; 3], f32) {
    const DIELECTRIC: f32 = 0.04;
    let ([r, g, b, _], specular) = (older.diffuse_factor(), older.specular_factor());
    let scattered = 1.0 - specular.into_iter().fold(0.0, f32::max);
    let diffuse = [r, g, b].map(|channel| channel * scattered / (1.0 - DIELECTRIC));
    let seen = |[r, g, b]: [f32; 3]| (0.299 * r * r + 0.587 * g * g + 0.114 * b * b).sqrt();
    let excess = seen(specular) - DIELECTRIC;
    let half = 0.5 * (seen(diffuse) + excess - DIELECTRIC);
    let root = (half * half + DIELECTRIC * excess).max(0.0).sqrt();
    let metal = bounded((root - half) / DIELECTRIC, 0.0, 1.0);
    let base = std::array::from_fn(|channel| {
        let matt = diffuse[channel] / (1.0 - metal).max(1.0e-6);
        let shiny = (specular[channel] - DIELECTRIC * (1.0 - metal)) / metal.max(1.0e-6);
        matt + (shiny - matt) * metal * metal
    });
    (base, if excess > 0.0 { metal } else { 0.0 })
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

/// Returns 20 times the reciprocal of Abbe's number, by `KHR_materials_dispersion`; none where it
/// is 0.
fn dispersion(material: &gltf::Material<'_>) -> Option<f32> {
    let extension = material.extension_value("KHR_materials_dispersion")?;
    let dispersion = extension.get("dispersion")?.as_f64()? as f32;
    Some(dispersion).filter(|dispersion| *dispersion > 0.0)
}

/// Returns a medium of this index at the d line and this dispersion, or none if there is no such.
///
/// The extension takes Cauchy's equation, n = a + b/λ². A term of Sellmeier's has the same square
/// up to 1/λ⁴: a² + 2ab/λ² + b²/λ⁴.
fn medium(index: f32, dispersion: f32) -> Option<Medium> {
    // 1/λ² in square micrometres.
    let [f, d, c] = [line::F, line::D, line::C].map(|nm| 1.0e6 / (nm * nm));
    let b = (index - 1.0) * dispersion / 20.0 / (f - c);
    let a = index - b * d;
    let term = [4.0 * a * a, 0.5 * b / a];
    Medium::form2([360.0, 830.0], -3.0 * a * a - 1.0, &[term]).ok()
}

#[cfg(test)]
mod tests;
