//! A model from a file as a scene of its own: where it stands, and in what light.

use super::import::{Camera, Model};
use super::mesh::TriangleMesh;
use super::placement::Normalisation;
use super::{Background, Light, Object, Scene, Shape};
use glam::{DAffine3, DMat3, DVec3};

/// Metres of a model's largest side.
const SIDE: f64 = 2.0;

/// Height of the floor of the built-in rooms: metres.
const FLOOR: f64 = -1.5;

/// Metres from the origin to the middle of a model's foot: behind the front wall of the built-in
/// rooms.
const AHEAD: f64 = 2.5;

impl Scene {
    /// Returns a scene of one model, which stands before the viewer on a floor at the height `floor`
    /// (metres, in the room), or on that of the built-in rooms. Its largest side is 2 m, or `metres` to a unit of its file. It is in its own light,
    /// or without any in that of [`Self::of_meshes`].
    ///
    /// With a camera the model stands upright so that the camera is at the origin and its heading
    /// is the front; a unit of its file is then 1 m, or `metres`.
    pub fn of_model(
        model: Model,
        metres: Option<f64>,
        floor: Option<f64>,
        camera: Option<&Camera>,
    ) -> Self {
        let place = camera.map_or_else(
            || placed(&model.mesh, metres, floor.unwrap_or(FLOOR)),
            |camera| {
                let turn = DMat3::from_diagonal(DVec3::splat(metres.unwrap_or(1.0)))
                    * camera.front_from_model();
                DAffine3::from_mat3_translation(turn, turn * -camera.position)
            },
        );
        let mut mesh = model.mesh;
        let metres = place.matrix3.x_axis.length() as f32;
        for material in &mut mesh.materials {
            material.absorption = material.absorption.map(|of_unit| of_unit / metres);
        }
        let mut scene = Self::of_meshes(vec![mesh]);
        scene.objects[0].world_from_object = place;
        scene.animate(0, model.rig);
        if !model.lights.is_empty() {
            let lights = model.lights.into_iter();
            scene.lights = lights.map(|light| moved(light, &place)).collect();
            scene.ambient = [0.05; 3];
            // The sky is not the file's: the exposure that its lights need is to leave it as it is.
            let share = libm::exp2(-scene.suitable_exposure()) as f32;
            let sky = &mut scene.background;
            for colour in [
                &mut scene.ambient,
                &mut sky.zenith,
                &mut sky.horizon,
                &mut sky.nadir,
            ] {
                *colour = colour.map(|channel| channel * share);
            }
        }
        scene
    }

    /// Returns a scene of meshes where their files place them, under a sun and a sky.
    pub fn of_meshes(meshes: Vec<TriangleMesh>) -> Self {
        let objects = (0..meshes.len()).map(|mesh| Object::new(Shape::Mesh(mesh)));
        Self {
            name: "model".to_owned(),
            objects: objects.collect(),
            meshes,
            lights: vec![Light::Directional {
                direction: DVec3::new(-0.4, -1.0, -0.6),
                colour: [0.8; 3],
            }],
            background: Background {
                zenith: [0.30, 0.50, 0.85],
                horizon: [0.90, 0.90, 0.87],
                nadir: [0.17, 0.14, 0.11],
                alpha: 1.0,
            },
            ambient: [0.2; 3],
            ..Self::default()
        }
    }
}

fn placed(mesh: &TriangleMesh, metres: Option<f64>, floor: f64) -> DAffine3 {
    let (low, high) = mesh.bounds();
    let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
    let fitted = || Normalisation::of(mesh).map_or(1.0, |of| SIDE / of.largest_side);
    let scale = metres.unwrap_or_else(fitted);
    let middle = 0.5 * (low + high);
    let foot = DVec3::new(middle.x, low.y, middle.z);
    DAffine3 {
        translation: DVec3::new(0.0, floor, -AHEAD) - scale * foot,
        ..DAffine3::from_scale(DVec3::splat(scale))
    }
}

/// Returns a light that moves and grows with a model: its surfaces stay as bright.
fn moved(light: Light, place: &DAffine3) -> Light {
    let scale = place.matrix3.x_axis.length();
    let brighter = |colour: [f32; 3], inverse_square| {
        let share = if inverse_square { scale * scale } else { 1.0 };
        colour.map(|channel| (f64::from(channel) * share) as f32)
    };
    match light {
        Light::Point {
            position,
            colour,
            inverse_square,
        } => Light::Point {
            position: place.transform_point3(position),
            colour: brighter(colour, inverse_square),
            inverse_square,
        },
        Light::Spot {
            position,
            direction,
            cone,
            colour,
            inverse_square,
        } => Light::Spot {
            position: place.transform_point3(position),
            direction: place.transform_vector3(direction),
            cone,
            colour: brighter(colour, inverse_square),
            inverse_square,
        },
        Light::Directional { direction, colour } => Light::Directional {
            direction: place.transform_vector3(direction),
            colour,
        },
        // A model's file has no others.
        other @ Light::Rectangle { .. } => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::import::Unused;
    use crate::scene::material::Material;
    use crate::scene::motion::Rig;

    #[test]
    fn a_model_stands_on_the_floor_with_its_light() {
        let mut mesh = TriangleMesh::square();
        for position in &mut mesh.positions {
            *position = [position[0] * 10.0 + 3.0, position[2] * 40.0, 7.0];
        }
        mesh.materials = vec![Material {
            absorption: [1.0; 3],
            ..Material::default()
        }];
        let lamp = Light::Point {
            position: DVec3::new(3.0, -20.0, 7.0),
            colour: [400.0; 3],
            inverse_square: true,
        };
        let model = Model {
            mesh,
            lights: vec![lamp],
            cameras: Vec::new(),
            scalar: None,
            rig: Rig::default(),
            unused: Unused::default(),
        };
        let corners = |scene: &Scene| {
            let (low, high) = scene.meshes[0].bounds();
            [low, high].map(|corner| {
                let corner = DVec3::from(corner.map(f64::from));
                scene.objects[0].world_from_object.transform_point3(corner)
            })
        };
        let scene = Scene::of_model(model.clone(), None, None, None);
        let expected = [DVec3::new(-0.25, -1.5, -2.5), DVec3::new(0.25, 0.5, -2.5)];
        for (found, expected) in corners(&scene).into_iter().zip(expected) {
            assert!((found - expected).length() < 1e-12, "{found}");
        }
        // It is a twentieth as large: what it absorbs in a unit, it absorbs in 5 cm.
        assert_eq!(scene.meshes[0].materials[0].absorption, [20.0; 3]);
        let foot = Light::Point {
            position: DVec3::new(0.0, FLOOR, -AHEAD),
            colour: [1.0; 3],
            inverse_square: true,
        };
        assert_eq!(scene.lights, [foot]);
        let mut bright = Scene::of_model(
            Model {
                lights: vec![Light::Directional {
                    direction: DVec3::NEG_Z,
                    colour: [1000.0; 3],
                }],
                ..model.clone()
            },
            None,
            None,
            None,
        );
        let stops = bright.suitable_exposure();
        assert!(stops < -9.0, "{stops}");
        bright.expose(stops);
        let sky = Scene::of_meshes(Vec::new()).background.zenith;
        let error = bright.background.zenith[0] / sky[0];
        assert!((0.7..1.5).contains(&error), "{error}");
        let [low, high] = corners(&Scene::of_model(model, Some(1.0), Some(0.25), None));
        assert_eq!((high - low).y, 40.0);
        assert_eq!(low.y, 0.25);
    }
}
