//! What surfaces are made of, as described or imported, before it is baked.

use crate::scene::texture::Texture;
use shisen_core::spectrum::Medium;

/// How a surface answers light: Whitted's terms (1980), linear RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// What its file calls it; may be empty.
    pub name: String,
    /// Lambertian reflectance per channel, 0 to 1.
    pub diffuse: [f32; 3],
    /// Blinn-Phong highlight per channel, 0 to 1.
    pub specular: [f32; 3],
    /// Blinn-Phong exponent, 1 to 10,000.
    pub shininess: f32,
    /// Mirror reflectance per channel, 0 to 1. Where `transmission` is not
    /// zero, Fresnel's equations split the light and this is unused.
    pub mirror: [f32; 3],
    /// Share of refracted light that is let through per channel, 0 to 1.
    pub transmission: [f32; 3],
    /// Index of refraction relative to the surroundings, above 0.
    pub index_of_refraction: f32,
    /// What it is made of: its index, which depends on the wavelength, is used
    /// instead of `index_of_refraction`.
    pub medium: Option<Medium>,
    /// Which of several clear bodies fills the place that they share: that of the highest number, 1
    /// to 100, or the one entered last. 0, in a scene without such numbers, is for bodies that do not
    /// meet.
    pub priority: u32,
    /// Beer's absorption inside the body, per metre and channel, 0 or more.
    pub absorption: [f32; 3],
    /// Where the surface is this material; between the lines it is black.
    pub graticule: Option<Graticule>,
    /// What `diffuse` is multiplied by.
    pub texture: Option<Texture>,
    /// What `emission` is multiplied by.
    pub emission_texture: Option<Texture>,
    /// Microfacets, instead of `shininess` and `mirror`: `diffuse` is then the colour of its metal,
    /// too, and `specular` the share that what is no metal reflects head-on.
    pub microfacets: Option<Microfacets>,
    /// How its normals are bent.
    pub normal_map: Option<NormalMap>,
    /// Where it has holes, or how opaque it is.
    pub alpha: Option<Alpha>,
    /// Whether the colours of a mesh's vertices multiply `diffuse`, or `emission` where `diffuse`
    /// is black.
    pub vertex_colours: bool,
    /// Light of its own per channel, 0 or more: as bright outside from all
    /// directions. It lights nothing else.
    pub emission: [f32; 3],
}

impl Material {
    /// Returns its textures.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let facets = self.microfacets.as_ref();
        let facets = facets.and_then(|facets| facets.texture.as_ref());
        let alpha = self.alpha.as_ref().and_then(|alpha| alpha.texture.as_ref());
        let others = [self.texture.as_ref(), self.emission_texture.as_ref(), alpha];
        let normals = self.normal_map.as_ref().map(|map| &map.texture);
        others.into_iter().chain([facets, normals]).flatten()
    }
}

/// Opacity from place to place. With [`Cover::Blend`] the material's `index_of_refraction` is 1 and
/// its `transmission` white.
#[derive(Debug, Clone, PartialEq)]
pub struct Alpha {
    /// Opacity, 0 to 1.
    pub opacity: f32,
    /// What it is multiplied by: the texture's alpha.
    pub texture: Option<Texture>,
    /// What it stands for.
    pub cover: Cover,
}

/// What an opacity between 0 and 1 stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cover {
    /// A hole under this opacity, above 0 to 1, and an opaque surface from it on.
    Mask(f32),
    /// Seen as far as it is opaque.
    Blend,
}

/// Metal and roughness, as glTF has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Microfacets {
    /// Share of metal, 0 to 1.
    pub metalness: f32,
    /// The square root of GGX's α, 0 (a mirror) to 1.
    pub roughness: f32,
    /// Data whose blue multiplies `metalness`, and its green `roughness`.
    pub texture: Option<Texture>,
}

/// An image of normals, as glTF has it: +X along u, +Y along v.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMap {
    /// Data: an image.
    pub texture: Texture,
    /// Factor for X and Y, −1,000 to 1,000.
    pub scale: f32,
}

/// Meridians and parallels about a shape's own Y axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Graticule {
    /// Lines of a quarter turn, 1 to 900: 9 are 10° apart.
    pub divisions: u32,
    /// The width of each line, seen from the shape's origin: radians, above 0 to 0.5.
    pub width: f32,
}

impl Default for Material {
    /// Matt light grey.
    fn default() -> Self {
        Self {
            name: String::new(),
            diffuse: [0.8; 3],
            specular: [0.0; 3],
            shininess: 32.0,
            mirror: [0.0; 3],
            transmission: [0.0; 3],
            index_of_refraction: 1.5,
            medium: None,
            priority: 0,
            absorption: [0.0; 3],
            graticule: None,
            texture: None,
            emission_texture: None,
            microfacets: None,
            normal_map: None,
            alpha: None,
            vertex_colours: false,
            emission: [0.0; 3],
        }
    }
}
