//! Textures of a scene, made smaller for a small memory.

use super::environment;
use super::levels::Levels;
use crate::scene::Scene;
use crate::scene::environment::Radiance;
use crate::scene::texture::{Image, Pattern, Texture};
use std::collections::HashMap;
use std::sync::Arc;

impl Scene {
    /// Halves the images of textures, and the picture around the scene, until no side has more than
    /// `most` pixels.
    pub fn fit_textures(&mut self, most: u32) {
        let mut fitted: HashMap<(*const Image, bool), Arc<Image>> = HashMap::new();
        let mut fit = |texture: &mut Texture, levels: Levels| {
            if let Pattern::Image(image) = &mut texture.pattern {
                let key = (Arc::as_ptr(image), levels == Levels::OfData);
                let small = fitted
                    .entry(key)
                    .or_insert_with(|| smaller(image, levels, most));
                *image = Arc::clone(small);
            }
        };
        let of_meshes = self.meshes.iter_mut().flat_map(|mesh| &mut mesh.materials);
        for material in self.materials.iter_mut().chain(of_meshes) {
            let alpha = material.alpha.as_mut().and_then(|one| one.texture.as_mut());
            let colours = [
                material.texture.as_mut(),
                material.emission_texture.as_mut(),
                alpha,
            ];
            for texture in colours.into_iter().flatten() {
                fit(texture, Levels::OfColours);
            }
            let facets = material.microfacets.as_mut();
            let facets = facets.and_then(|facets| facets.texture.as_mut());
            let normals = material.normal_map.as_mut().map(|map| &mut map.texture);
            for texture in facets.into_iter().chain(normals) {
                fit(texture, Levels::OfData);
            }
        }
        if let Some(environment) = &mut self.environment {
            let image = &environment.image;
            let (mut pixels, mut sides) = (image.pixels().to_vec(), image.sides());
            while sides.iter().any(|side| *side > most.max(1) as usize) {
                (pixels, sides) = environment::halved(&pixels, sides);
            }
            if let Some(image) = Radiance::new(sides, pixels) {
                environment.image = Arc::new(image);
            }
        }
    }
}

fn smaller(image: &Arc<Image>, levels: Levels, most: u32) -> Arc<Image> {
    let mut sides = [image.width() as usize, image.height() as usize];
    let mut texels = image.texels().to_vec();
    while sides.iter().any(|side| *side > most.max(1) as usize) {
        texels = levels.halved(&texels, sides);
        sides = sides.map(|side| (side / 2).max(1));
    }
    let [width, height] = sides.map(|side| side as u32);
    let small = if image.is_opaque() {
        let texels: Vec<[u8; 3]> = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Image::new(width, height, &texels)
    } else {
        Image::with_alpha(width, height, &texels)
    };
    small.map_or_else(|| Arc::clone(image), Arc::new)
}
