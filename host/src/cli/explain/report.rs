//! What `shisen explain` prints.

use crate::cli::arguments::dispersion::DispersionReport;
use crate::cli::arguments::source::Shown;
use crate::cli::prelude::*;
use crate::scene::motion::Clip;
use shisen_core::scene::format::{Light, Material, effect, flag, light};
use shisen_core::scene::{EffectSet, Records};

/// Effects that no scene can ask for.
pub(super) const NOT_BUILT: &[&str] = &[
    "light from surface to surface (ambient light stands for it)",
    "light that mirrors and clear bodies focus",
    "what is in the room in rough reflections",
    "blur by motion or by a lens",
];

/// The effects of a scene and what they cost.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    #[serde(flatten)]
    pub(super) shown: Shown,
    /// Names of the walls and domes.
    pub(super) walls: Vec<String>,
    /// Number of eyes.
    pub(super) eyes: usize,
    /// Pixels along each side of a wall whose file does not say.
    pub(super) size: u32,
    /// Pixels of all pictures.
    pub(super) pixels: u64,
    /// off, paper or paper-ellipse.
    pub(super) lod: &'static str,
    /// Rays a pixel.
    pub(super) samples: u16,
    /// Reflections and refractions followed.
    pub(super) depth: u8,
    /// Dispersion, or null if it is not rendered.
    pub(super) dispersion: Option<DispersionReport>,
    /// Threads that traced.
    pub(super) threads: usize,
    /// How often each frame was rendered.
    pub(super) repeat: u32,
    /// Time of the frame with all effects.
    pub(super) seconds: Seconds,
    /// Rays from the eyes.
    pub(super) primary: Primary,
    /// Effects that were rendered.
    pub(super) effects: Vec<Asked>,
    /// Effects that the scene asks for and the command line leaves out.
    pub(super) left_out: Vec<Cause>,
    /// Animations of scene files and glTF files.
    pub(super) animations: Vec<Animation>,
    /// Effects of the compiled shading that was used.
    pub(super) compiled: Vec<&'static str>,
    /// Effects that the scene does not ask for.
    pub(super) not_simulated: Vec<NotSimulated>,
    /// What no scene can ask for.
    pub(super) not_built: &'static [&'static str],
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Primary {
    /// Number of rays.
    pub(super) rays: u64,
    /// Tree nodes visited and primitives tested.
    pub(super) steps: u64,
}

#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Seconds {
    /// The median of the runs.
    pub(super) median: f64,
    /// A quarter of the runs is below the first, a quarter above the second.
    pub(super) quartiles: [f64; 2],
}

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.quartiles.map(|seconds| 1e3 * seconds);
        let text = format!("{:.2} ms ({low:.2} to {high:.2})", 1e3 * self.median);
        f.pad(&text)
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Asked {
    #[serde(flatten)]
    pub(super) cause: Cause,
    /// Pixels in whose ray trees the effect was rendered.
    pub(super) pixels: u64,
    /// Rays traced for the effect alone.
    pub(super) rays: u64,
    /// Steps of these rays.
    pub(super) steps: u64,
    /// Time of the frame without the effect.
    pub(super) seconds_without: Seconds,
    /// Time that the effect adds, from frames one after the other.
    pub(super) seconds: Seconds,
}

/// An effect and what asks for it.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Cause {
    /// Name of the effect.
    effect: String,
    /// Materials that ask for it.
    materials: Vec<String>,
    /// Lights that ask for it, or the background.
    lights: Vec<String>,
}

impl Cause {
    fn list(&self) -> String {
        [&self.materials[..], &self.lights].concat().join(", ")
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct NotSimulated {
    /// Name of the effect.
    effect: &'static str,
    /// Why nothing asks for it.
    reason: &'static str,
}

/// Returns the effects that a scene does not ask for.
pub(super) fn not_simulated(asked: EffectSet, records: &Records<'_>) -> Vec<NotSimulated> {
    let others = EffectSet::NAMED
        .iter()
        .filter(|(effect, _)| !asked.contains(*effect));
    let others = others.map(|&(effect, name)| NotSimulated {
        effect: name,
        reason: reason(effect, records),
    });
    others.collect()
}

/// Why nothing in a scene asks for an effect.
fn reason(effect: EffectSet, records: &Records<'_>) -> &'static str {
    let mut instances = records.instances.iter();
    match effect {
        EffectSet::SHADOWS if records.lights.is_empty() => "there is no light to keep out",
        EffectSet::SHADOWS if !instances.any(|one| one.flags & flag::OCCLUDES != 0) => {
            "nothing keeps light from anything"
        }
        EffectSet::REFLECTION => "no material is a mirror",
        EffectSet::REFRACTION => "no material lets light through",
        EffectSet::DISPERSION => "no clear material has an index that depends on the wavelength",
        EffectSet::ABSORPTION => "no material takes light away along its way",
        EffectSet::SOFT_LIGHT if !records.lights.iter().any(Light::is_large) => {
            "all lights are points or infinitely far"
        }
        EffectSet::SPOT_LIGHT if !records.lights.iter().any(Light::is_spot) => {
            "no light shines into a cone"
        }
        EffectSet::SHADOWS | EffectSet::SOFT_LIGHT | EffectSet::SPOT_LIGHT => {
            "no material shows the light of lights"
        }
        EffectSet::IMAGE_TEXTURE => "no material has an image",
        EffectSet::CHECKER_TEXTURE => "no material has a checker",
        EffectSet::EMISSION => "no material shines",
        EffectSet::MICROFACETS => "no material says how rough or metallic it is",
        EffectSet::VERTEX_COLOURS => "no mesh has colours at its vertices",
        EffectSet::CLEAR_SHADOWS => "nothing that casts a shadow lets light through",
        EffectSet::ALPHA => "no material has holes, or is more or less opaque by a texture",
        EffectSet::TEXTURE_LEVELS => {
            "no material has a checker, or an image with more than a texel"
        }
        EffectSet::ENVIRONMENT => "the background is no image",
        EffectSet::NORMAL_MAP => "no material has an image of normals",
        EffectSet::NESTED_MEDIA => "no clear material has a priority, and no clear bodies meet",
        EffectSet::GRATICULE => "no material has meridians and parallels",
        _ => "nothing in the scene asks for it",
    }
}

/// The materials and lights that rays can meet, and their names.
pub(super) struct Met<'r> {
    materials: Vec<(String, &'r Material)>,
    lights: Vec<(String, &'r Light)>,
}

impl<'r> Met<'r> {
    /// `names` are those of the first materials; the others are named by number.
    pub(super) fn new(records: &Records<'r>, names: &[String]) -> Self {
        let mut met = vec![false; records.materials.len()];
        records.materials_met(|number| {
            if let Some(met) = met.get_mut(number as usize) {
                *met = true;
            }
        });
        let name = |number: usize| {
            let name = names.get(number).filter(|name| !name.is_empty()).cloned();
            name.unwrap_or_else(|| format!("material {number}"))
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
                        _ if one.is_spot() => "spot",
                        light::POINT | light::POINT_INVERSE_SQUARE => "point",
                        _ => "rectangle",
                    };
                    (format!("light {number} ({kind})"), one)
                })
                .collect(),
        }
    }

    /// Returns what asks for an effect; for those of lights all lit materials, and for clear shadows
    /// all that let light through.
    pub(super) fn cause(&self, asked: EffectSet) -> Cause {
        let asks = |light: &Light| match asked {
            EffectSet::SHADOWS => true,
            EffectSet::SOFT_LIGHT => light.is_large(),
            EffectSet::SPOT_LIGHT => light.is_spot(),
            _ => false,
        };
        let of_lights = EffectSet::SHADOWS | EffectSet::SOFT_LIGHT | EffectSet::SPOT_LIGHT;
        let materials = self.materials.iter().filter(|(_, material)| {
            let lit = of_lights.contains(asked) && material.effects & effect::LIT != 0;
            let lets_by = material.effects & (effect::REFRACTION | effect::ALPHA) != 0;
            let is_clear = asked == EffectSet::CLEAR_SHADOWS && lets_by;
            lit || is_clear || EffectSet::of_material(material).contains(asked)
        });
        let lights = self.lights.iter();
        let lights = lights.filter(|(_, light)| asks(light));
        Cause {
            effect: asked.to_string(),
            materials: materials.map(|(name, _)| name.clone()).collect(),
            lights: if asked == EffectSet::ENVIRONMENT {
                vec!["the background".to_owned()]
            } else {
                lights.map(|(name, _)| name.clone()).collect()
            },
        }
    }
}

/// An animation, and what it moves.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Animation {
    /// Its name, or that of the object that it moves.
    name: String,
    /// After how many seconds it begins anew.
    seconds: f64,
    /// Number of nodes and objects that it moves.
    nodes: usize,
    /// Number of skins that it bends.
    skins: usize,
    /// Number of nodes whose morph targets it weighs.
    morphs: usize,
    /// Whether it plays.
    plays: bool,
}

impl Animation {
    pub(in crate::cli) fn of(clips: &[Clip]) -> Vec<Self> {
        let of = |clip: &Clip| {
            let [nodes, morphs] = clip.counts();
            Self {
                name: clip.name.clone(),
                seconds: clip.seconds(),
                nodes,
                skins: clip.skins,
                morphs,
                plays: clip.plays,
            }
        };
        clips.iter().map(of).collect()
    }
}

impl fmt::Display for Animation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let things = [
            (self.nodes, "node"),
            (self.skins, "skin"),
            (self.morphs, "morph"),
        ];
        let things = things.into_iter().filter(|(count, _)| *count > 0);
        let things: Vec<String> = things.map(|(n, what)| counted(n as u64, what)).collect();
        let plays = if self.plays { "" } else { ", does not play" };
        let Self { name, seconds, .. } = self;
        write!(f, "{name}: {seconds:.2} s, {}{plays}", things.join(", "))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.shown)?;
        let (walls, eyes) = (self.walls.join(", "), counted(self.eyes as u64, "eye"));
        let threads = counted(self.threads as u64, "thread");
        write!(f, " on {walls} for {eyes}: {} pixels, ", self.pixels)?;
        writeln!(f, "{} on {threads}", self.seconds)?;
        write!(f, "{:16}{:>10}{:>10}", "effect", "pixels", "rays")?;
        write!(f, "{:>12}  {:32}", "steps", "adds (quartiles)")?;
        writeln!(f, "{:32}asked for by", "frame without it")?;
        let Primary { rays, steps } = self.primary;
        write!(f, "{:16}{:>10}", "(from the eyes)", self.pixels)?;
        writeln!(f, "{rays:>10}{steps:>12}")?;
        for one in &self.effects {
            let Cause { effect, .. } = &one.cause;
            let (pixels, rays, steps) = (one.pixels, one.rays, one.steps);
            write!(f, "{effect:16}{pixels:>10}{rays:>10}{steps:>12}  ")?;
            let (added, without) = (one.seconds, one.seconds_without);
            writeln!(f, "{added:32}{without:32}{}", one.cause.list())?;
        }
        if self.effects.is_empty() && self.left_out.is_empty() {
            writeln!(f, "the scene asks for no effect")?;
        }
        if !self.left_out.is_empty() {
            writeln!(f, "left out by the command line:")?;
            for one in &self.left_out {
                writeln!(f, "  {}: asked for by {}", one.effect, one.list())?;
            }
        }
        if !self.animations.is_empty() {
            writeln!(f, "animations:")?;
            for one in &self.animations {
                writeln!(f, "  {one}")?;
            }
        }
        if !self.not_simulated.is_empty() {
            writeln!(f, "not simulated, because nothing asks for it:")?;
        }
        for one in &self.not_simulated {
            writeln!(f, "  {}: {}", one.effect, one.reason)?;
        }
        write!(f, "not built: {}", self.not_built.join("; "))
    }
}
