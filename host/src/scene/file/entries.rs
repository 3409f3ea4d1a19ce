//! The tables of a scene file as they are written, not yet checked. Values
//! keep their place in the text where a check may have to point at it.

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

type Number = Spanned<f64>;
type Numbers = Spanned<[f64; 3]>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    pub(super) name: Option<String>,
    pub(super) ambient: Option<Numbers>,
    pub(super) background: Option<Spanned<BackgroundEntry>>,
    #[serde(default)]
    pub(super) materials: BTreeMap<Spanned<String>, MaterialEntry>,
    #[serde(default)]
    pub(super) media: BTreeMap<Spanned<String>, Spanned<MediumEntry>>,
    #[serde(default)]
    pub(super) textures: BTreeMap<Spanned<String>, Spanned<TextureEntry>>,
    #[serde(default)]
    pub(super) meshes: BTreeMap<Spanned<String>, Spanned<MeshEntry>>,
    #[serde(default)]
    pub(super) object: Vec<Spanned<ObjectEntry>>,
    #[serde(default)]
    pub(super) light: Vec<Spanned<LightEntry>>,
    #[serde(default)]
    pub(super) camera: Vec<Spanned<CameraEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    pub(super) frame: Option<Number>,
    pub(super) position: Numbers,
    pub(super) zenith: Option<Numbers>,
    pub(super) top: Option<Numbers>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BackgroundEntry {
    pub(super) colour: Option<Numbers>,
    pub(super) zenith: Option<Numbers>,
    pub(super) horizon: Option<Numbers>,
    pub(super) nadir: Option<Numbers>,
    pub(super) alpha: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialEntry {
    pub(super) diffuse: Option<Numbers>,
    pub(super) specular: Option<Numbers>,
    pub(super) shininess: Option<Number>,
    pub(super) mirror: Option<Numbers>,
    pub(super) transmission: Option<Numbers>,
    pub(super) index_of_refraction: Option<Number>,
    pub(super) absorption: Option<Numbers>,
    pub(super) graticule: Option<GraticuleEntry>,
    pub(super) medium: Option<Spanned<String>>,
    pub(super) texture: Option<Spanned<String>>,
    pub(super) emission: Option<Numbers>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MediumEntry {
    pub(super) form: Number,
    pub(super) range_nm: Spanned<[f64; 2]>,
    pub(super) coefficients: Spanned<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TextureEntry {
    pub(super) file: Option<String>,
    pub(super) checker: Option<CheckerEntry>,
    pub(super) repeats: Option<Spanned<[f64; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CheckerEntry {
    pub(super) colours: [Numbers; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GraticuleEntry {
    pub(super) divisions: Number,
    pub(super) width_degrees: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshEntry {
    pub(super) file: Option<String>,
    pub(super) builtin: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectEntry {
    pub(super) mesh: Option<Spanned<String>>,
    pub(super) sphere: Option<SphereEntry>,
    pub(super) spheroid: Option<SpheroidEntry>,
    pub(super) material: Option<Spanned<String>>,
    pub(super) position: Option<Numbers>,
    pub(super) yaw_degrees: Option<Number>,
    pub(super) rotation_degrees: Option<Numbers>,
    pub(super) scale: Option<Spanned<Scale>>,
    pub(super) normalise: Option<Spanned<bool>>,
    pub(super) casts_shadow: Option<bool>,
    pub(super) normals: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereEntry {
    pub(super) radius: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpheroidEntry {
    pub(super) equatorial_radius: Number,
    pub(super) polar_radius: Number,
}

// One table for both types: serde's tagged enums lose the places of values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightEntry {
    #[serde(rename = "type")]
    pub(super) kind: Spanned<String>,
    pub(super) position: Option<Numbers>,
    pub(super) direction: Option<Numbers>,
    pub(super) colour: Option<Numbers>,
    pub(super) inverse_square: Option<Spanned<bool>>,
    pub(super) size: Option<Spanned<[f64; 2]>>,
    pub(super) up: Option<Numbers>,
    pub(super) samples: Option<Number>,
    pub(super) two_sided: Option<Spanned<bool>>,
}

/// One factor for all axes, or one for each.
pub(super) struct Scale(pub(super) [f64; 3]);

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ScaleVisitor;

        impl<'de> Visitor<'de> for ScaleVisitor {
            type Value = Scale;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or [x, y, z]")
            }

            fn visit_f64<E>(self, factor: f64) -> Result<Scale, E> {
                Ok(Scale([factor; 3]))
            }

            fn visit_i64<E>(self, factor: i64) -> Result<Scale, E> {
                Ok(Scale([factor as f64; 3]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut factors: A) -> Result<Scale, A::Error> {
                let mut scale = [0.0; 3];
                for (i, factor) in scale.iter_mut().enumerate() {
                    *factor = factors
                        .next_element()?
                        .ok_or_else(|| serde::de::Error::invalid_length(i, &self))?;
                }
                if factors.next_element::<f64>()?.is_some() {
                    return Err(serde::de::Error::invalid_length(4, &self));
                }
                Ok(Scale(scale))
            }
        }

        deserializer.deserialize_any(ScaleVisitor)
    }
}
