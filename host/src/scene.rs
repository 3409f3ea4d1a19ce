//! Scenes in memory: meshes, materials, lights and a background, read from files or built in.
//!
//! [`Scene::load`] reads a scene file ([`mod@file`] describes it), [`import`] meshes,
//! [`builtin`] has the papers' scenes. [`bake`](crate::bake) makes bytes of a scene, which the core traces.

pub mod environment;
pub mod import;
pub mod material;
pub mod mesh;
pub mod motion;
pub mod quadruped;
pub mod texture;

pub mod builtin;
pub mod camera;
mod exposure;
pub mod file;
mod model;
mod placement;

use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use camera::CameraPath;
use environment::Environment;
use glam::{DAffine3, DVec3};
use motion::Motion;

/// Everything a frame shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Its name in reports.
    pub name: String,
    /// Meshes that objects share.
    pub meshes: Vec<TriangleMesh>,
    /// Materials that objects share.
    pub materials: Vec<Material>,
    /// The placed shapes.
    pub objects: Vec<Object>,
    /// The lights.
    pub lights: Vec<Light>,
    /// The colours past all objects.
    pub background: Background,
    /// A picture that is seen instead of these colours.
    pub environment: Option<Environment>,
    /// Light from all directions, linear RGB; multiplies the diffuse reflectance.
    pub ambient: [f32; 3],
    /// The way of the camera of dome masters.
    pub camera: CameraPath,
    /// What of it moves.
    pub motion: Motion,
}

impl Scene {
    /// Returns the names of its materials and of its meshes' own, in their order.
    pub fn material_names(&self) -> Vec<String> {
        let meshes = self.meshes.iter().flat_map(|mesh| &mesh.materials);
        let all = self.materials.iter().chain(meshes);
        all.map(|material| material.name.clone()).collect()
    }
}

/// One placed shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// Its shape.
    pub shape: Shape,
    /// Index into the scene's materials; `None` takes the mesh's own, or the
    /// default material where it has none.
    pub material: Option<usize>,
    /// Where it stands: an invertible affine map, metres.
    pub world_from_object: DAffine3,
    /// Whether it blocks light. Objects that let light through never do.
    pub casts_shadow: bool,
    /// Whether normals are interpolated between vertices.
    pub smooth: bool,
}

impl Object {
    /// Returns a shape at the origin with its own material, smooth, that blocks light.
    pub const fn new(shape: Shape) -> Self {
        Self {
            shape,
            material: None,
            world_from_object: DAffine3::IDENTITY,
            casts_shadow: true,
            smooth: true,
        }
    }
}

/// The shape of an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Index into the scene's meshes.
    Mesh(usize),
    /// About the object's origin.
    Sphere {
        /// Metres, above 0.
        radius: f32,
    },
    /// An ellipsoid of revolution about the object's Y axis.
    Spheroid {
        /// Across the axis: metres, above 0.
        equatorial_radius: f32,
        /// Along the axis: metres, above 0.
        polar_radius: f32,
    },
}

/// A light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// From a point.
    Point {
        /// Metres, in the world.
        position: DVec3,
        /// Linear RGB: irradiance at any distance, or at 1 m where `inverse_square` is set.
        colour: [f32; 3],
        /// Whether it falls off with distance (Whitted's does not).
        inverse_square: bool,
    },
    /// From a point into a cone.
    Spot {
        /// Metres, in the world.
        position: DVec3,
        /// The way the middle of its light travels; any length but zero.
        direction: DVec3,
        /// Angles from the direction up to which light is full, and from which on there is none:
        /// radians, 0 ≤ first < second ≤ π/2. Between, it falls off as `KHR_lights_punctual` says.
        cone: [f64; 2],
        /// Linear RGB: irradiance within the first angle, as a point light's.
        colour: [f32; 3],
        /// Whether it falls off with distance.
        inverse_square: bool,
    },
    /// From infinitely far.
    Directional {
        /// The way the light travels; any length but zero.
        direction: DVec3,
        /// Linear RGB irradiance.
        colour: [f32; 3],
    },
    /// From all over a rectangle or parallelogram, which is not itself seen. For a lamp that is
    /// seen, add an object in its place with the same colour as its emission that casts no shadow.
    Rectangle {
        /// Its middle: metres, in the world.
        centre: DVec3,
        /// From there to the middle of its right side: metres.
        right: DVec3,
        /// From there to the middle of its upper side: metres. Light goes towards right × up.
        up: DVec3,
        /// Linear RGB radiance, which falls off by the inverse square of the distance. A
        /// surface in a surrounding of radiance 1 shows its reflectance.
        colour: [f32; 3],
        /// Points of it that each lit point looks at, 1 to 64, spread evenly;
        /// further samples of a pixel look at further points.
        samples: u32,
        /// Whether light goes to both sides.
        two_sided: bool,
    },
}

/// The colours that rays see past all objects: a vertical gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Background {
    /// Linear RGB straight up (+Y).
    pub zenith: [f32; 3],
    /// Linear RGB at the horizon.
    pub horizon: [f32; 3],
    /// Linear RGB straight down.
    pub nadir: [f32; 3],
    /// Coverage it counts for, 0 (transparent) to 1.
    pub alpha: f32,
}

impl Default for Background {
    /// Opaque black.
    fn default() -> Self {
        Self::uniform([0.0; 3])
    }
}

impl Background {
    /// Returns the same colour everywhere, opaque.
    pub const fn uniform(colour: [f32; 3]) -> Self {
        Self {
            zenith: colour,
            horizon: colour,
            nadir: colour,
            alpha: 1.0,
        }
    }
}
