//! Scenes that need no file: the four of Mochizuki and Makino's Table 2 with any mesh, the grid of
//! Miura's figures, glass that disperses light, and a gallery of all effects.
//!
//! The paper gives a picture of each of its scenes: eight animals around a 3 m CAVE, or behind its
//! front wall. Places and yaws are those of `tests/reference/cave-scenes.json`.

mod gallery;
mod glass;

pub use gallery::gallery;
pub use glass::{PrismBench, minimum_deviation, prism, spheres};

use super::placement::{Normalisation, Placement};
use super::{Background, Light, Object, Scene, Shape};
use crate::files::description::UnknownName;
use crate::scene::material::{Graticule, Material};
use crate::scene::mesh::TriangleMesh;
use glam::DVec3;
use std::str::FromStr;
use thiserror::Error;

/// One of the paper's scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PaperScene {
    /// Mirrors behind the front, right and floor walls.
    A,
    /// Diffuse, behind the front, right and floor walls.
    B,
    /// Mirrors behind the front wall only.
    C,
    /// Diffuse, behind the front wall only.
    D,
}

named!(PaperScene { A => "A", B => "B", C => "C", D => "D" });

/// A mesh all of whose vertices are in one place, which cannot be scaled to a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the mesh is a point, so it cannot be scaled to the scene")]
pub struct PointMesh;

/// Where an animal stands, metres, and its yaw, degrees.
type Stand = ([f64; 3], f64);

const AROUND: [Stand; 8] = [
    ([-1.7, -0.85, -3.0], 20.0),
    ([0.0, 1.05, -3.0], -15.0),
    ([1.7, -0.85, -3.0], 35.0),
    ([3.0, -0.85, -1.7], 110.0),
    ([3.0, 1.05, 0.0], 75.0),
    ([3.0, -0.85, 1.7], 125.0),
    ([-0.95, -2.35, -0.75], 20.0),
    ([0.95, -2.35, 0.75], -30.0),
];

const IN_FRONT: [Stand; 8] = [
    ([-2.223, -0.936, -3.9], 20.0),
    ([-0.741, -0.936, -3.9], -15.0),
    ([0.741, -0.936, -3.9], 35.0),
    ([2.223, -0.936, -3.9], -25.0),
    ([-2.223, 0.936, -3.9], -30.0),
    ([-0.741, 0.936, -3.9], 10.0),
    ([0.741, 0.936, -3.9], -20.0),
    ([2.223, 0.936, -3.9], 25.0),
];

/// An animal's largest side before it is turned, metres.
const LENGTH: f64 = 2.0;

const LIGHT: [f64; 3] = [0.0, 2.5, 0.5];

impl PaperScene {
    const fn stands(self) -> &'static [Stand; 8] {
        match self {
            Self::A | Self::B => &AROUND,
            Self::C | Self::D => &IN_FRONT,
        }
    }

    const fn is_mirror(self) -> bool {
        matches!(self, Self::A | Self::C)
    }

    /// Chrome with a cold tint, or clay.
    fn material(self) -> Material {
        let (name, diffuse, specular, shininess, mirror) = if self.is_mirror() {
            (
                "chrome",
                [0.10, 0.11, 0.13],
                [0.6; 3],
                200.0,
                [0.80, 0.81, 0.83],
            )
        } else {
            ("clay", [0.74, 0.44, 0.26], [0.15; 3], 40.0, [0.0; 3])
        };
        Material {
            name: name.to_owned(),
            diffuse,
            specular,
            shininess,
            mirror,
            ..Material::default()
        }
    }
}

impl FromStr for PaperScene {
    type Err = UnknownName;

    /// Reads its letter, of either case.
    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let mut all = Self::ALL.into_iter();
        let found = all.find(|scene| scene.name().eq_ignore_ascii_case(text));
        found.ok_or_else(|| UnknownName {
            kind: "scene",
            given: text.into(),
            known: "A, B, C or D",
        })
    }
}

/// Returns one of the paper's scenes with eight of `mesh`, which is centred and its largest side scaled to
/// 2 m.
///
/// # Errors
/// [`PointMesh`] where the mesh has no vertices or all in one place.
pub fn paper_scene(which: PaperScene, mesh: TriangleMesh) -> Result<Scene, PointMesh> {
    let normalisation = Normalisation::of(&mesh).ok_or(PointMesh)?;
    let objects = which
        .stands()
        .iter()
        .map(|&(position, yaw)| {
            let placement = Placement {
                position: DVec3::from_array(position),
                rotation_degrees: [yaw, 0.0, 0.0],
                scale: DVec3::splat(LENGTH),
            };
            Object {
                material: Some(0),
                world_from_object: placement.world_from_object(&normalisation),
                ..Object::new(Shape::Mesh(0))
            }
        })
        .collect();
    Ok(Scene {
        name: which.name().into(),
        meshes: vec![mesh],
        materials: vec![which.material()],
        objects,
        lights: vec![Light::Point {
            position: DVec3::from_array(LIGHT),
            colour: [1.0; 3],
            inverse_square: false,
        }],
        // Chrome shows nothing but what it mirrors: a bright band between a
        // light sky and a darker ground draws its shape.
        background: Background {
            zenith: [0.30, 0.50, 0.85],
            horizon: [0.90, 0.90, 0.87],
            nadir: [0.17, 0.14, 0.11],
            alpha: 1.0,
        },
        ambient: [0.12; 3],
        ..Scene::default()
    })
}

/// Meridians and parallels every 10°, 0.3° wide, white on black, on a sphere about the origin: what
/// Miura's figures show. Its poles are straight up and down.
pub fn grid(radius: f32) -> Scene {
    let white = Material {
        name: "lines".to_owned(),
        diffuse: [1.0; 3],
        graticule: Some(Graticule {
            divisions: 9,
            width: 0.3f32.to_radians(),
        }),
        ..Material::default()
    };
    Scene {
        name: "grid".into(),
        materials: vec![white],
        objects: vec![Object {
            material: Some(0),
            ..Object::new(Shape::Sphere { radius })
        }],
        ambient: [1.0; 3],
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    const REFERENCE: &str = include_str!("../../../tests/reference/cave-scenes.json");

    #[test]
    fn places_are_those_of_the_reference() {
        let reference: Value = serde_json::from_str(REFERENCE).unwrap();
        let vector = |value: &Value| [0, 1, 2].map(|i| value[i].as_f64().unwrap());
        for which in PaperScene::ALL {
            let expected = &reference["scenes"][which.name()];
            assert_eq!(which.is_mirror(), expected["material"] == "mirror");
            let objects = expected["objects"].as_array().unwrap();
            assert_eq!(objects.len(), which.stands().len());
            for (&(position, yaw), expected) in which.stands().iter().zip(objects) {
                assert_eq!(position, vector(&expected["pos"]));
                assert_eq!(Some(yaw), expected["yaw"].as_f64());
                assert_eq!(Some(LENGTH), expected["scale"].as_f64());
            }
        }
        assert_eq!(LIGHT, vector(&reference["light"]["pos"]));
    }
}
