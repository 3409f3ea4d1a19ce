//! Materials and textures as the core has them, each texture once.

use super::blob::Tables;
use crate::scene::material::Material;
use crate::scene::texture::{Image, Pattern, Texture, Wrap};
use shisen_core::scene::format::{
    self, NO_MATERIAL, NO_MEDIUM, NO_TEXTURE, effect, kind, reading, texture, wrap,
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

    pub(super) fn add_material(&mut self, source: &Material, textures: &mut Textures) {
        let mut baked = material(source);
        let shows = |colour: [f32; 3]| colour.iter().any(|&c| c > 0.0);
        let metal = source.metal.as_ref();
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
                metal.and_then(|metal| metal.texture.as_ref()),
                reading::LINEAR,
            ),
        ];
        for (number, texture, of_data) in images {
            if let Some(texture) = texture {
                *number = textures.add(texture, of_data, self);
                baked.effects |= self.textures[*number as usize].effect();
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
    /// Each image with the number of its first texel.
    images: Vec<(Arc<Image>, u32)>,
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
            reserved: [0; 5],
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
                baked.first_texel = self.first_texel(image, tables);
            }
        }
        tables.textures.push(baked);
        self.textures.push((source.clone(), of_data));
        tables.textures.len() as u32 - 1
    }

    fn first_texel<const W: usize>(&mut self, image: &Arc<Image>, tables: &mut Tables<W>) -> u32 {
        let known = self
            .images
            .iter()
            .find(|(known, _)| Arc::ptr_eq(known, image));
        if let Some(&(_, first)) = known {
            return first;
        }
        let first = tables.texels;
        // The images of a scene are limited to fewer bytes than a scene.
        tables.texels += image.texels().len() as u32;
        tables.images.push(Arc::clone(image));
        self.images.push((Arc::clone(image), first));
        first
    }
}

/// Returns a material without its textures.
fn material(m: &Material) -> format::Material {
    let any = |colour: [f32; 3]| colour.iter().any(|&c| c > 0.0);
    let is_clear = any(m.transmission);
    let metal = m.metal.as_ref().filter(|metal| metal.metalness > 0.0);
    // A texture can make it smooth somewhere; from one half on metal mirrors nothing.
    let mirrors = metal.is_some_and(|metal| metal.roughness < 0.5 || metal.texture.is_some());
    let asked = [
        (any(m.emission), effect::EMISSION),
        (any(m.diffuse) || any(m.specular), effect::LIT),
        (is_clear, effect::REFRACTION),
        (is_clear && any(m.absorption), effect::ABSORPTION),
        (!is_clear && (any(m.mirror) || mirrors), effect::REFLECTION),
        (m.graticule.is_some(), effect::GRATICULE),
        (m.metal.is_some(), effect::METAL),
        (m.vertex_colours, effect::VERTEX_COLOURS),
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
        metalness: m.metal.as_ref().map_or(0.0, |metal| metal.metalness),
        roughness: m.metal.as_ref().map_or(0.0, |metal| metal.roughness),
        reserved2: [0; 3],
    }
}
