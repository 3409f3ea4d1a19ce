//! Materials and textures as the core has them, each texture once.

use super::blob::Tables;
use super::levels::Levels;
use crate::scene::material::{Cover, Material};
use crate::scene::texture::{Image, Pattern, Texture, Wrap};
use shisen_core::scene::format::{
    self, MOST_NESTED, NO_MATERIAL, NO_MEDIUM, NO_TEXTURE, ROUGH, effect, kind, reading, texture,
    wrap,
};
use shisen_core::spectrum::line;
use std::sync::Arc;

impl<const W: usize> Tables<W> {
    /// Adds the default material, if a triangle or an instance names none.
    pub(super) fn add_default_material(&mut self) {
        let default = self.materials.len() as u32;
        let mut used = self.materials.is_empty();
        let triangles = self.triangles.iter_mut().map(|one| &mut one.material);
        let instances = self.instances.iter_mut();
        let others = instances.filter(|one| one.kind != kind::MESH);
        let all = triangles.chain(others.map(|one| &mut one.material));
        for material in all.filter(|material| **material == NO_MATERIAL) {
            *material = default;
            used = true;
        }
        if used {
            self.add_material(&Material::default(), &mut Textures::default());
        }
    }

    /// Makes clear bodies nest, all with the same priority.
    pub(super) fn nest_materials(&mut self) {
        for material in self.materials.iter_mut().take(MOST_NESTED) {
            if material.effects & effect::REFRACTION != 0 && material.index_of_refraction != 1.0 {
                material.priority = 1;
                material.effects |= effect::NESTED_MEDIA;
            }
        }
    }

    pub(super) fn add_material(&mut self, source: &Material, textures: &mut Textures) {
        let mut baked = material(source);
        let shows = |colour: [f32; 3]| colour.iter().any(|&c| c > 0.0);
        let facets = source.microfacets.as_ref();
        let images = [
            (
                &mut baked.texture,
                (source.texture.as_ref())
                    .filter(|_| shows(source.diffuse) || shows(source.transmission)),
                0,
            ),
            (
                &mut baked.emission_texture,
                source
                    .emission_texture
                    .as_ref()
                    .filter(|_| shows(source.emission)),
                0,
            ),
            (
                &mut baked.metal_texture,
                facets.and_then(|facets| facets.texture.as_ref()),
                reading::LINEAR,
            ),
            (
                &mut baked.alpha_texture,
                source
                    .alpha
                    .as_ref()
                    .and_then(|alpha| alpha.texture.as_ref()),
                0,
            ),
            (
                &mut baked.normal_texture,
                source.normal_map.as_ref().map(|map| &map.texture),
                reading::LINEAR,
            ),
        ];
        for (number, texture, of_data) in images {
            if let Some(texture) = texture {
                *number = textures.add(texture, of_data, self);
                baked.effects |= self.textures[*number as usize].effects();
            }
        }
        // Opaque materials need no medium, nor does a constant index.
        let is_clear = baked.effects & effect::REFRACTION != 0;
        let medium = source.medium.filter(|one| is_clear && one.is_dispersive());
        if let Some(medium) = medium {
            let known = self.media.iter().position(|known| *known == medium);
            let number = known.unwrap_or(self.media.len());
            if number == self.media.len() {
                self.media.push(medium);
            }
            baked.medium = number as u32;
            baked.effects |= effect::DISPERSION;
        }
        self.materials.push(baked);
    }
}

/// The textures and images that are already in the tables, each once.
#[derive(Default)]
pub(super) struct Textures {
    textures: Vec<(Texture, u32)>,
    /// Each image with its levels, which differ for colours and data, and the number of its first
    /// texel.
    images: Vec<(Arc<Image>, Levels, u32)>,
}

impl Textures {
    /// Adds a texture, whose codes are read as `of_data` says, if it is not known; returns its
    /// number.
    fn add<const W: usize>(
        &mut self,
        source: &Texture,
        of_data: u32,
        tables: &mut Tables<W>,
    ) -> u32 {
        let rest = |texture: &Texture| {
            let Texture {
                map,
                wrap,
                nearest,
                second_coordinates,
                ..
            } = texture;
            (*map, *wrap, *nearest, *second_coordinates)
        };
        let same = |(known, read): &(Texture, u32)| {
            *read == of_data
                && rest(known) == rest(source)
                && match (&known.pattern, &source.pattern) {
                    (Pattern::Image(known), Pattern::Image(image)) => Arc::ptr_eq(known, image),
                    (known, pattern) => known == pattern,
                }
        };
        if let Some(number) = self.textures.iter().position(same) {
            return number as u32;
        }
        let mut baked = format::Texture {
            kind: texture::CHECKER,
            width: 0,
            height: 0,
            first_texel: 0,
            map: source.map,
            colours: [[0.0; 3]; 2],
            wrap: [0; 2],
            reading: if source.second_coordinates {
                reading::SECOND
            } else {
                0
            },
            levels: 0,
            reserved: [0; 4],
        };
        match &source.pattern {
            Pattern::Checker(colours) => baked.colours = *colours,
            Pattern::Image(image) => {
                baked.kind = texture::IMAGE;
                baked.wrap = source.wrap.map(|way| match way {
                    Wrap::Repeat => wrap::REPEAT,
                    Wrap::Mirror => wrap::MIRROR,
                    Wrap::Clamp => wrap::CLAMP,
                });
                baked.reading |= of_data;
                if source.nearest {
                    baked.reading |= reading::NEAREST;
                }
                (baked.width, baked.height) = (image.width(), image.height());
                let levels = match (source.nearest, of_data) {
                    (true, _) => Levels::None,
                    (false, reading::LINEAR) => Levels::OfData,
                    (false, _) => Levels::OfColours,
                };
                baked.levels = levels.count(image);
                baked.first_texel = self.first_texel(image, levels, tables);
            }
        }
        tables.textures.push(baked);
        self.textures.push((source.clone(), of_data));
        tables.textures.len() as u32 - 1
    }

    fn first_texel<const W: usize>(
        &mut self,
        image: &Arc<Image>,
        levels: Levels,
        tables: &mut Tables<W>,
    ) -> u32 {
        let same = |(known, of, _): &&(Arc<Image>, Levels, u32)| {
            Arc::ptr_eq(known, image) && (*of == levels || levels == Levels::None)
        };
        if let Some(&(_, _, first)) = self.images.iter().find(same) {
            return first;
        }
        let first = tables.texels;
        // The images of a scene are limited to fewer bytes than a scene.
        let texels = levels.of(image);
        tables.texels += (image.texels().len() + texels.len()) as u32;
        tables.images.push((Some(Arc::clone(image)), texels));
        self.images.push((Arc::clone(image), levels, first));
        first
    }
}

/// Returns a material without its textures.
fn material(m: &Material) -> format::Material {
    let any = |colour: [f32; 3]| colour.iter().any(|&c| c > 0.0);
    let is_clear = any(m.transmission);
    let alpha = m.alpha.as_ref();
    let is_veil = alpha.is_some() && m.index_of_refraction == 1.0;
    let facets = m.microfacets.as_ref();
    let mirrors = facets.map_or(any(m.mirror), |facets| {
        // A texture can make it smooth somewhere.
        let is_smooth = facets.roughness < ROUGH || facets.texture.is_some();
        is_smooth && (any(m.specular) || facets.metalness > 0.0)
    });
    let asked = [
        (any(m.emission), effect::EMISSION),
        (any(m.diffuse) || any(m.specular), effect::LIT),
        (is_clear, effect::REFRACTION),
        (is_clear && any(m.absorption), effect::ABSORPTION),
        ((!is_clear || is_veil) && mirrors, effect::REFLECTION),
        (m.graticule.is_some(), effect::GRATICULE),
        (facets.is_some(), effect::MICROFACETS),
        (m.vertex_colours, effect::VERTEX_COLOURS),
        (m.alpha.is_some(), effect::ALPHA),
        (is_clear && m.priority > 0, effect::NESTED_MEDIA),
        (m.normal_map.is_some(), effect::NORMAL_MAP),
    ];
    let asked = asked.into_iter().filter(|(is_asked, _)| *is_asked);
    let effects = asked.fold(0, |all, (_, effect)| all | effect);
    format::Material {
        diffuse: m.diffuse,
        shininess: m.shininess,
        specular: m.specular,
        index_of_refraction: match m.medium {
            Some(medium) => medium.index_clamped(line::D),
            None => m.index_of_refraction,
        },
        mirror: m.mirror,
        effects,
        transmission: m.transmission,
        texture: NO_TEXTURE,
        absorption: m.absorption,
        graticule_divisions: m.graticule.map_or(0, |lines| lines.divisions),
        graticule_width: m.graticule.map_or(0.0, |lines| lines.width),
        emission: m.emission,
        medium: NO_MEDIUM,
        emission_texture: NO_TEXTURE,
        metal_texture: NO_TEXTURE,
        metalness: facets.map_or(0.0, |facets| facets.metalness),
        roughness: facets.map_or(0.0, |facets| facets.roughness),
        alpha_texture: NO_TEXTURE,
        alpha_cutoff: match alpha.map(|alpha| alpha.cover) {
            Some(Cover::Mask(cutoff)) => cutoff,
            _ => 0.0,
        },
        opacity: alpha.map_or(0.0, |alpha| alpha.opacity),
        priority: if is_clear { m.priority } else { 0 },
        normal_texture: NO_TEXTURE,
        normal_scale: m.normal_map.as_ref().map_or(0.0, |map| map.scale),
        reserved2: [0; 5],
    }
}
