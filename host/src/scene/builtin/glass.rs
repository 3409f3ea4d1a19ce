//! Scenes of dispersive glass: a spectrum, and the balls of Kishioka's paper.

use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::{Pattern, Texture};
use crate::scene::{Background, Light, Object, Scene, Shape};
use glam::{DAffine3, DMat3, DVec3};
use shisen_core::spectrum::{Medium, line};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6, PI};

/// Returns the least angle by which a prism turns light, radians; `index` is the prism's index of
/// refraction, `apex` the angle between its two sides, radians. `None` where it reflects all light.
///
/// Light then passes symmetrically: sin((δ + A)/2) = n·sin(A/2).
pub fn minimum_deviation(index: f64, apex: f64) -> Option<f64> {
    let sine = index * libm::sin(0.5 * apex);
    (sine.abs() <= 1.0).then(|| 2.0 * libm::asin(sine) - apex)
}

/// A prism before a viewer at the origin who looks along −Z, and the slit of light seen through it.
/// Rays go from the eye, so a wall shows of the slit the spectrum that light through the prism
/// throws on it. Angles in the plane of the floor are from −Z towards −X.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrismBench {
    /// The angle by which it turns that wavelength: radians, the least that it can.
    deviation: f64,
}

impl PrismBench {
    /// The angle between the prism's two faces: radians.
    const APEX: f64 = FRAC_PI_3;
    /// The length of the prism's three edges across: metres.
    pub const SIDE: f64 = 0.5;
    /// From the eye to the middle of the face that it looks on: metres.
    const DISTANCE: f64 = 0.35;
    /// From the middle of the other face to the slit: metres.
    const TO_SLIT: f64 = 80.0;
    /// The slit's width: metres, nearly a degree. With 14 wavelengths most places of
    /// the spectrum then see one at least; the far blue takes more samples.
    const SLIT_WIDTH: f64 = 1.2;

    /// For a wavelength in nanometres, or the nearest that SF11 is known at: its
    /// light comes from straight ahead, turned by the least angle.
    pub fn new(nm: f32) -> Self {
        let index = f64::from(Medium::SF11.index_clamped(nm));
        // With an index of 2, which SF11 has nowhere, light would graze.
        let grazing = PI - Self::APEX;
        let deviation = minimum_deviation(index, Self::APEX).unwrap_or(grazing);
        Self { deviation }
    }

    /// Returns the angle by which light of its wavelength is turned: radians.
    pub const fn deviation(&self) -> f64 {
        self.deviation
    }

    /// Returns the unit vector at an angle.
    pub fn towards(angle: f64) -> DVec3 {
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        DVec3::new(-sine, 0.0, -cosine)
    }

    /// Returns the angles of the outward normals of the face that is looked on, and of the one
    /// beyond.
    pub fn faces(&self) -> [f64; 2] {
        let half = 0.5 * self.deviation;
        [half + 7.0 * FRAC_PI_6, half - FRAC_PI_6]
    }

    /// From an edge to the middle across: metres. Half of that is a face's distance.
    fn circumradius() -> f64 {
        Self::SIDE / libm::sqrt(3.0)
    }

    /// Returns its middle: metres.
    pub fn centre(&self) -> DVec3 {
        let [near, _] = self.faces();
        let inradius = 0.5 * Self::circumradius();
        Self::DISTANCE * DVec3::NEG_Z - inradius * Self::towards(near)
    }

    /// Returns the slit's middle: metres. The light of its wavelength that comes from
    /// there, through the middles of both faces, meets the origin along +Z.
    pub fn slit(&self) -> DVec3 {
        let [_, far] = self.faces();
        let leaves = self.centre() + 0.5 * Self::circumradius() * Self::towards(far);
        leaves + Self::TO_SLIT * Self::towards(self.deviation)
    }

    /// Returns the prism, about its own middle, as at no deviation.
    fn mesh() -> TriangleMesh {
        let edge = |number: u32| {
            let angle = -FRAC_PI_3 + 2.0 * FRAC_PI_3 * f64::from(number) - FRAC_PI_6;
            Self::circumradius() * Self::towards(angle)
        };
        let height = 0.5 * Self::SIDE * DVec3::Y;
        // Edge by edge, seen from above counter-clockwise: below, then above.
        let positions = (0..3)
            .flat_map(|number| [edge(number) - height, edge(number) + height])
            .map(|place| place.as_vec3().to_array())
            .collect();
        TriangleMesh {
            positions,
            triangles: vec![
                [1, 3, 5],
                [0, 4, 2],
                [0, 2, 3],
                [0, 3, 1],
                [2, 4, 5],
                [2, 5, 3],
                [4, 0, 1],
                [4, 1, 5],
            ],
            ..TriangleMesh::default()
        }
    }

    /// Returns the scene.
    pub fn scene(&self) -> Scene {
        // Its floor ends below the slit.
        let floor = DAffine3::from_translation(1.6 * DVec3::NEG_Y)
            * DAffine3::from_scale(DVec3::splat(20.0));
        let back = -Self::towards(self.deviation);
        let across = Self::SLIT_WIDTH * DVec3::Y.cross(back);
        let slit = DMat3::from_cols(across, back, 20.0 * DVec3::NEG_Y);
        let slit = DAffine3::from_mat3_translation(slit, self.slit());
        let prism = DAffine3::from_translation(self.centre())
            * DAffine3::from_rotation_y(0.5 * self.deviation);
        let object = |mesh, material, world_from_object| Object {
            material: Some(material),
            world_from_object,
            casts_shadow: false,
            smooth: false,
            ..Object::new(Shape::Mesh(mesh))
        };
        Scene {
            name: "prism".into(),
            meshes: vec![Self::mesh(), TriangleMesh::square()],
            // The slit's light, spread over a spectrum, is as bright as white.
            materials: vec![
                clear("glass", Medium::SF11),
                lamp("slit", [2.0; 3]),
                checker("floor", [0.5, 0.2], 40.0),
            ],
            objects: vec![object(0, 0, prism), object(1, 1, slit), object(1, 2, floor)],
            ambient: [0.06; 3],
            ..Scene::default()
        }
    }
}

fn clear(name: &str, medium: Medium) -> Material {
    Material {
        name: name.to_owned(),
        diffuse: [0.0; 3],
        transmission: [1.0; 3],
        medium: Some(medium),
        ..Material::default()
    }
}

fn lamp(name: &str, emission: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        diffuse: [0.0; 3],
        emission,
        ..Material::default()
    }
}

fn checker(name: &str, greys: [f32; 2], repeats: f32) -> Material {
    Material {
        name: name.to_owned(),
        texture: Some(Texture::new(
            Pattern::Checker(greys.map(|grey| [grey; 3])),
            [repeats; 2],
        )),
        ..Material::default()
    }
}

/// Returns a slit of light seen through a 60° prism of SF11, turned so that the d line is straight
/// ahead.
pub fn prism() -> Scene {
    PrismBench::new(line::D).scene()
}

const BALLS: [([f64; 3], f64); 3] = [
    ([-0.70, -0.55, -3.3], 0.65),
    ([0.50, -0.80, -2.8], 0.40),
    ([-0.05, -0.97, -2.1], 0.23),
];

/// Returns three balls of crystal quartz on a checkered floor under a lamp and the sky:
/// what Kishioka's paper shows of dispersion.
pub fn spheres() -> Scene {
    let object = |shape, material, world_from_object| Object {
        material: Some(material),
        world_from_object,
        casts_shadow: false,
        ..Object::new(shape)
    };
    let mut objects: Vec<Object> = BALLS
        .into_iter()
        .map(|(centre, radius)| {
            let radius = radius as f32;
            let place = DAffine3::from_translation(DVec3::from_array(centre));
            object(Shape::Sphere { radius }, 0, place)
        })
        .collect();
    let floor = DAffine3::from_translation(1.2 * DVec3::NEG_Y)
        * DAffine3::from_rotation_y(0.4)
        * DAffine3::from_scale(DVec3::splat(40.0));
    objects.push(object(Shape::Mesh(0), 1, floor));
    let (centre, right, up) = (DVec3::new(1.2, 2.6, -2.2), 0.5 * DVec3::X, 0.5 * DVec3::Z);
    // Its front looks down, where the light goes.
    let place = DMat3::from_cols(2.0 * right, right.cross(up).normalize(), 2.0 * up);
    let place = DAffine3::from_mat3_translation(place, centre);
    objects.push(object(Shape::Mesh(0), 2, place));
    let white = lamp("lamp", [12.0, 11.4, 10.5]);
    Scene {
        name: "spheres".into(),
        meshes: vec![TriangleMesh::square()],
        materials: vec![
            clear("quartz", Medium::QUARTZ_O),
            checker("floor", [0.85, 0.04], 80.0),
            white,
        ],
        objects,
        // Clear bodies keep no light away, so there is no shadow whose edge would
        // tell the lamp from a point.
        lights: vec![Light::Point {
            position: centre,
            colour: [3.8, 3.6, 3.3],
            inverse_square: true,
        }],
        background: Background {
            zenith: [0.25, 0.45, 0.85],
            horizon: [0.85, 0.90, 0.95],
            nadir: [0.2; 3],
            alpha: 1.0,
        },
        ambient: [0.3; 3],
        ..Scene::default()
    }
}
