//! The effects that a scene asks for.

use super::format::{
    Background, Instance, Light, Material, Mesh, NO_MATERIAL, NO_TEXTURE, Triangle, effect, flag,
    kind,
};
use core::fmt;

bitflags::bitflags! {
    /// A set of effects: those that a scene asks for, that a tracer is compiled
    /// for, or that it carries out. As a number ([`bits`](Self::bits)) it is a
    /// const parameter of shading. Bits of materials are those of [`effect`]; bits
    /// from 2¹⁶ up belong to the scene as a whole.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    #[repr(transparent)]
    pub struct EffectSet: u32 {
        /// Shadows. Without it, lights shine through everything.
        const SHADOWS = 1 << 16;
        /// Mirrors. Without it, nothing is added to what lights give them.
        const REFLECTION = effect::REFLECTION;
        /// Clear bodies and their reflections. Without it, they are opaque, lit by lights only.
        const REFRACTION = effect::REFRACTION;
        /// Clear bodies bend each wavelength its own way, if the renderer has wavelengths, too.
        /// Without it, they have the index of the d line for all.
        const DISPERSION = effect::DISPERSION;
        /// Clear bodies within one another. Without it, each is as if it were in the surroundings.
        const NESTED_MEDIA = effect::NESTED_MEDIA;
        /// Clear bodies take light away along the way. Without it, they do not.
        const ABSORPTION = effect::ABSORPTION;
        /// Lights with a size, in several places. Without it, they shine from their middles.
        const SOFT_LIGHT = 1 << 17;
        /// Spots, which shine into cones. Without it, they shine in all directions.
        const SPOT_LIGHT = 1 << 18;
        /// Shadows that light comes through: of glass, of veils, of masks. Without it, what lets light
        /// through casts no shadow, and masks cast dark ones.
        const CLEAR_SHADOWS = 1 << 19;
        /// A background that is an image. Without it, it is the gradient, which is much like it.
        const ENVIRONMENT = 1 << 20;
        /// Images on surfaces. Without it, those have their material's colours.
        const IMAGE_TEXTURE = effect::IMAGE_TEXTURE;
        /// Checkers on surfaces. Without it, those have their material's colours.
        const CHECKER_TEXTURE = effect::CHECKER_TEXTURE;
        /// Normals that images bend. Without it, or without images, they are those of the shape.
        const NORMAL_MAP = effect::NORMAL_MAP;
        /// Textures as coarse as what a pixel sees of them. Without it, they are read at points.
        const TEXTURE_LEVELS = effect::TEXTURE_LEVELS;
        /// Surfaces that shine. Without it, they do not.
        const EMISSION = effect::EMISSION;
        /// Surfaces of microfacets: metal, and what is more or less rough. Without it, they are
        /// lit by Blinn-Phong's highlight alone.
        const MICROFACETS = effect::MICROFACETS;
        /// Colours of vertices. Without it, surfaces have their material's colours.
        const VERTEX_COLOURS = effect::VERTEX_COLOURS;
        /// Surfaces with holes, or that are more or less opaque from place to place. Without it,
        /// they are opaque.
        const ALPHA = effect::ALPHA;
        /// Meridians and parallels. Without it, the surface is the same all over.
        const GRATICULE = effect::GRATICULE;
    }
}

/// The records of a scene that say what it asks for.
#[derive(Debug, Clone, Copy)]
pub struct Records<'r> {
    /// Placed shapes.
    pub instances: &'r [Instance],
    /// What they place.
    pub meshes: &'r [Mesh],
    /// What those consist of.
    pub triangles: &'r [Triangle],
    /// All materials, asked for or not.
    pub materials: &'r [Material],
    /// All lights.
    pub lights: &'r [Light],
    /// What is seen past all instances.
    pub background: &'r Background,
}

impl Records<'_> {
    /// Calls `met` with the number of each material that rays can meet, once or
    /// more often.
    pub fn materials_met(&self, mut met: impl FnMut(u32)) {
        let instances = self.instances.iter();
        for instance in instances.clone() {
            if instance.material != NO_MATERIAL {
                met(instance.material);
            }
        }
        for (number, mesh) in self.meshes.iter().enumerate() {
            let shows = |instance: &Instance| {
                let (own, of) = (instance.material == NO_MATERIAL, instance.geometry);
                own && instance.kind == kind::MESH && of as usize == number
            };
            if !instances.clone().any(shows) {
                continue;
            }
            let first = self.triangles.get(mesh.first_triangle as usize..);
            let triangles = first.unwrap_or_default().iter();
            for triangle in triangles.take(mesh.triangle_count as usize) {
                met(triangle.material);
            }
        }
    }
}

impl EffectSet {
    /// No effect: surfaces have ambient light and light from lights.
    pub const NONE: Self = Self::empty();

    /// All effects.
    pub const ALL: Self = Self::all();

    /// The effects of Whitted's ray trees (1980), with textures, dispersion and lights with a size:
    /// what a firmware is compiled for that has no room for all effects.
    pub const WHITTED: Self = Self::ALL
        .difference(Self::MICROFACETS)
        .difference(Self::SPOT_LIGHT)
        .difference(Self::CLEAR_SHADOWS)
        .difference(Self::ALPHA)
        .difference(Self::NESTED_MEDIA)
        .difference(Self::NORMAL_MAP)
        .difference(Self::ENVIRONMENT)
        .difference(Self::TEXTURE_LEVELS);

    /// Number of bits that a set has room for.
    pub(crate) const PLACES: usize = 32;

    /// Each effect with the name that command lines and reports give it, in the order of
    /// reports.
    pub const NAMED: &'static [(Self, &'static str)] = &[
        (Self::SHADOWS, "shadows"),
        (Self::REFLECTION, "reflection"),
        (Self::REFRACTION, "refraction"),
        (Self::DISPERSION, "dispersion"),
        (Self::ABSORPTION, "absorption"),
        (Self::NESTED_MEDIA, "nested-media"),
        (Self::SOFT_LIGHT, "soft-light"),
        (Self::SPOT_LIGHT, "spot-light"),
        (Self::CLEAR_SHADOWS, "clear-shadows"),
        (Self::ENVIRONMENT, "environment"),
        (Self::IMAGE_TEXTURE, "image-texture"),
        (Self::CHECKER_TEXTURE, "checker-texture"),
        (Self::NORMAL_MAP, "normal-map"),
        (Self::TEXTURE_LEVELS, "texture-levels"),
        (Self::EMISSION, "emission"),
        (Self::MICROFACETS, "microfacets"),
        (Self::VERTEX_COLOURS, "vertex-colours"),
        (Self::ALPHA, "alpha"),
        (Self::GRATICULE, "graticule"),
    ];

    /// Returns the effect of a name.
    pub fn named(name: &str) -> Option<Self> {
        let mut all = Self::NAMED.iter();
        all.find(|(_, known)| *known == name).map(|&(of, _)| of)
    }

    /// Returns the names of its effects, in the order of reports.
    pub fn names(self) -> impl Iterator<Item = &'static str> + Clone {
        let own = move |&&(effect, _): &&(Self, &str)| self.contains(effect);
        Self::NAMED.iter().filter(own).map(|&(_, name)| name)
    }

    /// Returns what a material asks for, wherever it is.
    pub const fn of_material(material: &Material) -> Self {
        Self::from_bits_truncate(material.effects & 0xffff)
    }

    /// Returns what a scene of these records asks for: the effects of the materials that rays can
    /// meet, shadows where a light, a lit surface and an occluding instance come together, clear
    /// ones where the instance lets light through, soft light where a light with a size and a lit
    /// surface do, and spots likewise.
    pub fn of_records(records: &Records<'_>) -> Self {
        let mut asked = 0;
        records.materials_met(|number| {
            let material = records.materials.get(number as usize);
            asked |= material.map_or(0, |material| material.effects);
        });
        let mut set = Self::from_bits_truncate(asked & 0xffff);
        let is_lit = asked & effect::LIT != 0 && !records.lights.is_empty();
        let has = |flag: u32| records.instances.iter().any(|one| one.flags & flag != 0);
        if is_lit && has(flag::OCCLUDES | flag::VEILS) {
            set = set.union(Self::SHADOWS);
        }
        if is_lit && has(flag::VEILS) {
            set = set.union(Self::CLEAR_SHADOWS);
        }
        if is_lit && records.lights.iter().any(Light::is_large) {
            set = set.union(Self::SOFT_LIGHT);
        }
        if is_lit && records.lights.iter().any(Light::is_spot) {
            set = set.union(Self::SPOT_LIGHT);
        }
        if records.background.image != NO_TEXTURE {
            set = set.union(Self::ENVIRONMENT);
        }
        set
    }
}

impl fmt::Display for EffectSet {
    /// Returns the names, or "none".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        for (number, name) in self.names().enumerate() {
            f.write_str(if number == 0 { "" } else { ", " })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_effect_has_a_bit_and_a_name_of_its_own() {
        let mut seen = EffectSet::NONE;
        for &(effect, name) in EffectSet::NAMED {
            assert_eq!(effect.bits().count_ones(), 1, "{name}");
            assert!(!seen.contains(effect), "{name}");
            assert_eq!(EffectSet::named(name), Some(effect));
            assert_ne!(effect.bits(), effect::LIT, "{name}");
            seen |= effect;
        }
        assert_eq!(seen, EffectSet::ALL);
        assert_eq!(EffectSet::named("Shadows"), None);
        assert_eq!(EffectSet::from_bits_truncate(u32::MAX), EffectSet::ALL);
    }
}
