//! A scene in memory: what a scene file or a built-in scene describes and
//! what is baked.

pub mod import;
pub mod material;
pub mod mesh;
pub mod quadruped;
pub mod texture;

pub mod builtin;
pub mod camera;
pub mod file;
mod placement;

pub use placement::{Normalisation, Placement};

use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use camera::CameraPath;
use glam::{DAffine3, DVec3};

/// Everything a frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// For reports.
    pub name: String,
    /// Meshes that objects share.
    pub meshes: Vec<TriangleMesh>,
    /// Materials that objects share.
    pub materials: Vec<Material>,
    /// What stands in the scene.
    pub objects: Vec<Object>,
    /// What lights it.
    pub lights: Vec<Light>,
    /// What is seen past all objects.
    pub background: Background,
    /// Light from everywhere, linear RGB; multiplies the diffuse reflectance.
    pub ambient: [f32; 3],
    /// Where dome masters of it are taken.
    pub camera: CameraPath,
}

/// One placed shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    /// What it is.
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

/// What an object is.
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
        /// Linear RGB: irradiance at any distance, or at 1 m where
        /// `inverse_square` is set.
        colour: [f32; 3],
        /// Whether it falls off with distance (Whitted's does not).
        inverse_square: bool,
    },
    /// From infinitely far.
    Directional {
        /// The way the light travels; any length but zero.
        direction: DVec3,
        /// Linear RGB irradiance.
        colour: [f32; 3],
    },
    /// From all over a rectangle or parallelogram, which is not itself seen: a
    /// lamp to look at is an object in its place whose material has the same
    /// colour as its emission, and which casts no shadow.
    Rectangle {
        /// Its middle: metres, in the world.
        centre: DVec3,
        /// From there to the middle of its right side: metres.
        right: DVec3,
        /// From there to the middle of its upper side: metres. Light goes to
        /// the side from which `right` and `up` are so: that of right × up.
        up: DVec3,
        /// Linear RGB radiance. It lights by the inverse square of the
        /// distance; white of 1 all round a surface would give it the colour
        /// of its reflectance.
        colour: [f32; 3],
        /// Points of it that each lit point looks at, 1 to 64, spread evenly;
        /// further samples of a pixel look at further points.
        samples: u32,
        /// Whether light goes to both sides.
        two_sided: bool,
    },
}

/// What a ray sees that meets nothing: a vertical gradient.
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

impl Background {
    /// The same colour everywhere, opaque.
    pub const fn uniform(colour: [f32; 3]) -> Self {
        Self {
            zenith: colour,
            horizon: colour,
            nadir: colour,
            alpha: 1.0,
        }
    }
}
