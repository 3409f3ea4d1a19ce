//! The tables of a scene file as they are written, not yet checked. Values
//! keep their place in the text where a check may have to point at it.

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

pub(super) type Number = Spanned<f64>;
pub(super) type Numbers = Spanned<[f64; 3]>;

/// Tables that know no other keys than their fields.
macro_rules! tables {
    ($($(#[$note:meta])* struct $name:ident { $($(#[$of_field:meta])* $field:ident: $value:ty,)* })*) => {
        $(
            $(#[$note])*
            #[derive(Deserialize)]
            #[serde(deny_unknown_fields)]
            pub(super) struct $name { $($(#[$of_field])* pub(super) $field: $value,)* }
        )*
    };
}

tables! {
    struct SceneEntry {
        name: Option<String>,
        ambient: Option<Numbers>,
        background: Option<Spanned<BackgroundEntry>>,
        #[serde(default)]
        materials: BTreeMap<Spanned<String>, MaterialEntry>,
        #[serde(default)]
        media: BTreeMap<Spanned<String>, Spanned<MediumEntry>>,
        #[serde(default)]
        textures: BTreeMap<Spanned<String>, Spanned<TextureEntry>>,
        #[serde(default)]
        meshes: BTreeMap<Spanned<String>, Spanned<MeshEntry>>,
        #[serde(default)]
        object: Vec<Spanned<ObjectEntry>>,
        #[serde(default)]
        light: Vec<Spanned<LightEntry>>,
        #[serde(default)]
        animation: Vec<Spanned<AnimationEntry>>,
        #[serde(default)]
        camera: Vec<Spanned<CameraEntry>>,
    }

    struct CameraEntry {
        frame: Option<Number>,
        position: Numbers,
        zenith: Option<Numbers>,
        top: Option<Numbers>,
    }

    struct BackgroundEntry {
        colour: Option<Numbers>,
        zenith: Option<Numbers>,
        horizon: Option<Numbers>,
        nadir: Option<Numbers>,
        image: Option<String>,
        yaw_degrees: Option<Number>,
        strength: Option<Number>,
        alpha: Option<Number>,
    }

    struct MaterialEntry {
        diffuse: Option<Numbers>,
        specular: Option<Numbers>,
        shininess: Option<Number>,
        mirror: Option<Numbers>,
        metalness: Option<Number>,
        roughness: Option<Number>,
        transmission: Option<Numbers>,
        index_of_refraction: Option<Number>,
        absorption: Option<Numbers>,
        graticule: Option<GraticuleEntry>,
        medium: Option<Spanned<String>>,
        priority: Option<Number>,
        texture: Option<Spanned<String>>,
        normal_texture: Option<Spanned<String>>,
        normal_scale: Option<Number>,
        alpha_cutoff: Option<Number>,
        emission: Option<Numbers>,
    }

    struct MediumEntry {
        form: Number,
        range_nm: Spanned<[f64; 2]>,
        coefficients: Spanned<Vec<f64>>,
    }

    struct TextureEntry {
        file: Option<String>,
        checker: Option<CheckerEntry>,
        repeats: Option<Spanned<[f64; 2]>>,
    }

    struct CheckerEntry {
        colours: [Numbers; 2],
    }

    struct GraticuleEntry {
        divisions: Number,
        width_degrees: Number,
    }

    struct MeshEntry {
        file: Option<String>,
        builtin: Option<Spanned<String>>,
    }

    struct AnimationEntry {
        object: Spanned<String>,
        times: Option<Spanned<Vec<f64>>>,
        position: Option<Vec<Numbers>>,
        rotation_degrees: Option<Vec<Numbers>>,
        scale: Option<Vec<Numbers>>,
        interpolation: Option<Spanned<String>>,
        spin: Option<SpinEntry>,
    }

    struct SpinEntry {
        axis: Option<Numbers>,
        seconds_per_turn: Number,
    }

    struct ObjectEntry {
        name: Option<Spanned<String>>,
        mesh: Option<Spanned<String>>,
        sphere: Option<SphereEntry>,
        spheroid: Option<SpheroidEntry>,
        material: Option<Spanned<String>>,
        position: Option<Numbers>,
        yaw_degrees: Option<Number>,
        rotation_degrees: Option<Numbers>,
        scale: Option<Spanned<Scale>>,
        normalise: Option<Spanned<bool>>,
        casts_shadow: Option<bool>,
        normals: Option<Spanned<String>>,
    }

    struct SphereEntry {
        radius: Number,
    }

    struct SpheroidEntry {
        equatorial_radius: Number,
        polar_radius: Number,
    }

    // One table for both types: serde's tagged enums lose the places of values.
    struct LightEntry {
        #[serde(rename = "type")]
        kind: Spanned<String>,
        position: Option<Numbers>,
        direction: Option<Numbers>,
        colour: Option<Numbers>,
        inverse_square: Option<Spanned<bool>>,
        cone_degrees: Option<Spanned<[f64; 2]>>,
        size: Option<Spanned<[f64; 2]>>,
        up: Option<Numbers>,
        samples: Option<Number>,
        two_sided: Option<Spanned<bool>>,
    }
}

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
