//! What `shisen explain` prints.

use crate::cli::arguments::dispersion::DispersionReport;
use crate::cli::output::counted;
use serde::Serialize;
use shisen_core::scene::format::{Light, Material, effect, flag, light};
use shisen_core::scene::{EffectSet, Records};
use std::fmt;

/// What no scene can ask for.
pub(super) const NOT_BUILT: &[&str] = &[
    "light from surface to surface (ambient light stands for it)",
    "light that mirrors and clear bodies focus",
    "rough reflection",
    "blur by motion or by a lens",
];

/// What a scene asks for, and what that costs.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) scene: String,
    pub(super) mesh: Option<String>,
    pub(super) walls: Vec<String>,
    pub(super) eyes: usize,
    pub(super) size: u32,
    pub(super) pixels: u64,
    pub(super) lod: &'static str,
    pub(super) samples: u16,
    pub(super) depth: u8,
    pub(super) dispersion: Option<DispersionReport>,
    pub(super) threads: usize,
    pub(super) repeat: u32,
    pub(super) seconds: Seconds,
    pub(super) primary: Primary,
    pub(super) effects: Vec<Asked>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) compiled: Vec<&'static str>,
    pub(super) not_simulated: Vec<NotSimulated>,
    pub(super) not_built: &'static [&'static str],
}

/// Rays from the eyes.
#[derive(Debug, Serialize)]
pub(super) struct Primary {
    pub(super) rays: u64,
    pub(super) steps: u64,
}

/// What some runs of the same took.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Seconds {
    /// The middle one.
    pub(super) median: f64,
    /// A quarter of the runs is below the one, a quarter above the other.
    pub(super) quartiles: [f64; 2],
}

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.quartiles.map(|seconds| 1e3 * seconds);
        let text = format!("{:.2} ms ({low:.2} to {high:.2})", 1e3 * self.median);
        f.pad(&text)
    }
}

/// An effect that the scene asks for and that is carried out.
#[derive(Debug, Serialize)]
pub(super) struct Asked {
    pub(super) effect: String,
    pub(super) materials: Vec<String>,
    pub(super) lights: Vec<String>,
    pub(super) pixels: u64,
    pub(super) rays: u64,
    pub(super) steps: u64,
    pub(super) seconds_without: Seconds,
    pub(super) seconds: Seconds,
}

/// An effect that the scene asks for and the command line leaves out.
#[derive(Debug, Serialize)]
pub(super) struct LeftOut {
    pub(super) effect: String,
    pub(super) materials: Vec<String>,
    pub(super) lights: Vec<String>,
}

/// An effect that it does not ask for.
#[derive(Debug, Serialize)]
pub(super) struct NotSimulated {
    pub(super) effect: &'static str,
    pub(super) reason: &'static str,
}

/// Why it is right to leave an effect out that nothing asks for.
pub(super) fn reason(effect: EffectSet, records: &Records<'_>) -> &'static str {
    match effect {
        EffectSet::SHADOWS if records.lights.is_empty() => "there is no light to keep out",
        EffectSet::SHADOWS if !records.instances.iter().any(occludes) => {
            "nothing keeps light from anything"
        }
        EffectSet::REFLECTION => "no material is a mirror",
        EffectSet::REFRACTION => "no material lets light through",
        EffectSet::DISPERSION => "no clear material has an index that depends on the wavelength",
        EffectSet::ABSORPTION => "no material takes light away along its way",
        EffectSet::SOFT_LIGHT if !records.lights.iter().any(Light::is_large) => {
            "all lights are points or infinitely far"
        }
        EffectSet::SHADOWS | EffectSet::SOFT_LIGHT => "no material shows the light of lights",
        EffectSet::IMAGE_TEXTURE => "no material has an image",
        EffectSet::CHECKER_TEXTURE => "no material has a checker",
        EffectSet::EMISSION => "no material shines",
        EffectSet::GRATICULE => "no material has meridians and parallels",
        _ => "nothing in the scene asks for it",
    }
}

fn occludes(instance: &shisen_core::scene::format::Instance) -> bool {
    instance.flags & flag::OCCLUDES != 0
}

/// What rays can meet, and what it is called.
pub(super) struct Met<'r> {
    materials: Vec<(String, &'r Material)>,
    /// With whether they have a size.
    lights: Vec<(String, bool)>,
}

impl<'r> Met<'r> {
    /// `names` are those of the first materials; others go by their numbers.
    pub(super) fn new(records: &Records<'r>, names: &[String]) -> Self {
        let mut met = vec![false; records.materials.len()];
        records.materials_met(|number| {
            if let Some(met) = met.get_mut(number as usize) {
                *met = true;
            }
        });
        let name = |number: usize| match names.get(number) {
            Some(name) => name.clone(),
            None => format!("material {number}"),
        };
        let materials = records.materials.iter().enumerate();
        let lights = records.lights.iter().zip(0..);
        Self {
            materials: materials
                .filter(|&(number, _)| met[number])
                .map(|(number, material)| (name(number), material))
                .collect(),
            lights: lights
                .map(|(one, number)| {
                    let kind = match one.kind {
                        light::DIRECTIONAL => "directional",
                        light::POINT | light::POINT_INVERSE_SQUARE => "point",
                        _ => "rectangle",
                    };
                    (format!("light {number} ({kind})"), one.is_large())
                })
                .collect(),
        }
    }

    /// The materials that ask for an effect. For shadows and soft light those are
    /// the materials that lights light.
    pub(super) fn materials(&self, asked: EffectSet) -> Vec<String> {
        let asks = |material: &Material| {
            let by_lights = asked == EffectSet::SHADOWS || asked == EffectSet::SOFT_LIGHT;
            let lit = by_lights && material.effects & effect::LIT != 0;
            lit || EffectSet::of_material(material).contains(asked)
        };
        let materials = self.materials.iter();
        materials
            .filter(|(_, material)| asks(material))
            .map(|(name, _)| name.clone())
            .collect()
    }

    /// The lights that do.
    pub(super) fn lights(&self, asked: EffectSet) -> Vec<String> {
        let asks = |is_large: bool| {
            asked == EffectSet::SHADOWS || (asked == EffectSet::SOFT_LIGHT && is_large)
        };
        let lights = self.lights.iter().filter(|(_, is_large)| asks(*is_large));
        lights.map(|(name, _)| name.clone()).collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "scene {}", self.scene)?;
        if let Some(mesh) = &self.mesh {
            write!(f, " of {mesh}")?;
        }
        writeln!(
            f,
            " on {} for {}: {} pixels, {} on {}",
            self.walls.join(", "),
            counted(self.eyes as u64, "eye"),
            self.pixels,
            self.seconds,
            counted(self.threads as u64, "thread"),
        )?;
        writeln!(
            f,
            "{:16}{:>10}{:>10}{:>12}  {:32}{:32}asked for by",
            "effect", "pixels", "rays", "steps", "adds (quartiles)", "frame without it",
        )?;
        writeln!(
            f,
            "{:16}{:>10}{:>10}{:>12}",
            "(from the eyes)", self.pixels, self.primary.rays, self.primary.steps,
        )?;
        for one in &self.effects {
            writeln!(
                f,
                "{:16}{:>10}{:>10}{:>12}  {:32}{:32}{}",
                one.effect,
                one.pixels,
                one.rays,
                one.steps,
                one.seconds,
                one.seconds_without,
                list(&one.materials, &one.lights),
            )?;
        }
        if self.effects.is_empty() && self.left_out.is_empty() {
            writeln!(f, "the scene asks for no effect")?;
        }
        if !self.left_out.is_empty() {
            writeln!(f, "left out, as the command line says:")?;
            for one in &self.left_out {
                let by = list(&one.materials, &one.lights);
                writeln!(f, "  {}: asked for by {by}", one.effect)?;
            }
        }
        writeln!(f, "not simulated, since nothing asks for it:")?;
        for one in &self.not_simulated {
            writeln!(f, "  {}: {}", one.effect, one.reason)?;
        }
        write!(f, "not built: {}", self.not_built.join("; "))
    }
}

fn list(materials: &[String], lights: &[String]) -> String {
    [materials, lights].concat().join(", ")
}
