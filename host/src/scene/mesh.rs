//! A triangle mesh as imported or generated, before it is baked.

use crate::scene::material::Material;
use glam::DVec3;
use std::borrow::Cow;
use thiserror::Error;

/// Triangles with shared vertices, in the units of their file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals, one a position; empty where the file has none.
    pub normals: Vec<[f32; 3]>,
    /// Where vertices are on textures, one a position; empty where the file
    /// has none. u to the right and v up, 0 to 1 from the lower left corner of
    /// an image to the upper right one; up to [`Self::FARTHEST_COORDINATE`].
    pub coordinates: Vec<[f32; 2]>,
    /// The same for textures by second coordinates, where there are first ones.
    pub second_coordinates: Vec<[f32; 2]>,
    /// Unit vectors the way that u grows on normal maps, and 1, or −1 where v grows against normal ×
    /// tangent: one a position, or none at all. All zero where a vertex has none: baking makes those
    /// that are needed.
    pub tangents: Vec<[f32; 4]>,
    /// Colours of vertices, linear RGB from 0 to 1, one a position; may be empty.
    pub colours: Vec<[f32; 3]>,
    /// Three indices into `positions` a triangle, counter-clockwise from
    /// outside, in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// Materials that the file brings; may be empty.
    pub materials: Vec<Material>,
    /// One index into `materials` a triangle; empty where the file has none.
    pub triangle_materials: Vec<u32>,
}

/// Why a mesh cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct MeshError {
    message: String,
    /// The number of the triangle that is wrong, if one is.
    pub(super) triangle: Option<usize>,
}

impl MeshError {
    const fn new(message: String) -> Self {
        let triangle = None;
        Self { message, triangle }
    }

    /// Returns the error of more triangles than the scene format holds.
    pub(super) fn too_many(count: usize) -> Self {
        let limit = TriangleMesh::MOST_TRIANGLES;
        Self::new(format!(
            "{count} triangles are more than the {limit} that one mesh may have"
        ))
    }
}

impl TriangleMesh {
    /// Largest magnitude of a coordinate.
    pub const FARTHEST: f32 = 1.0e12;
    /// Largest magnitude of a coordinate on a texture.
    pub const FARTHEST_COORDINATE: f32 = 1.0e5;
    /// Most triangles in one mesh.
    pub const MOST_TRIANGLES: usize = 1 << 26;

    /// Checks everything that baking relies on.
    ///
    /// # Errors
    /// The first fault found, with where it is.
    pub fn validate(&self) -> Result<(), MeshError> {
        let (vertices, triangles) = (self.positions.len(), self.triangles.len());
        if triangles == 0 {
            return Err(MeshError::new("the mesh has no triangles".to_owned()));
        }
        if triangles > Self::MOST_TRIANGLES {
            return Err(MeshError::too_many(triangles));
        }
        for (vertex, &position) in self.positions.iter().enumerate() {
            Self::check_position(position).map_err(|fault| {
                MeshError::new(format!("vertex {vertex} (counted from 0) {fault}"))
            })?;
        }
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            let beyond = [a, b, c].into_iter().find(|&i| i as usize >= vertices);
            let fault = if let Some(index) = beyond {
                format!("names vertex {index}, but the mesh has {vertices}")
            } else if a == b || b == c || a == c {
                format!("names vertex {} twice", if b == c { b } else { a })
            } else {
                continue;
            };
            return Err(MeshError {
                message: format!("triangle {triangle} (counted from 0) {fault}"),
                triangle: Some(triangle),
            });
        }
        let materials = self.triangle_materials.len();
        for (what, found, expected) in [
            ("normals", self.normals.len(), vertices),
            ("coordinates", self.coordinates.len(), vertices),
            (
                "second coordinates",
                self.second_coordinates.len(),
                self.coordinates.len(),
            ),
            ("tangents", self.tangents.len(), vertices),
            ("colours", self.colours.len(), vertices),
            ("triangle materials", materials, triangles),
        ] {
            if found != 0 && found != expected {
                return Err(MeshError::new(format!(
                    "{what}: {found} entries where {expected} belong"
                )));
            }
        }
        let limit = Self::FARTHEST_COORDINATE;
        let shares = |colour: &[f32; 3]| colour.iter().all(|c| (0.0..=1.0).contains(c));
        if let Some(vertex) = self.colours.iter().position(|colour| !shares(colour)) {
            return Err(MeshError::new(format!(
                "vertex {vertex} (counted from 0) has a colour outside 0 to 1"
            )));
        }
        let sets = [&self.coordinates, &self.second_coordinates];
        for (vertex, [u, v]) in sets.into_iter().flat_map(|set| set.iter().enumerate()) {
            if !(u.abs() <= limit && v.abs() <= limit) {
                return Err(MeshError::new(format!(
                    "vertex {vertex} (counted from 0) is at {u}, {v} on its texture, but \
                     coordinates may be up to {limit:e}"
                )));
            }
        }
        let (materials, last) = (self.materials.len(), self.triangle_materials.iter().max());
        match last {
            Some(&last) if last as usize >= materials => Err(MeshError::new(format!(
                "materials: {materials} entries where {} belong",
                last as usize + 1
            ))),
            _ => Ok(()),
        }
    }

    /// Checks the place of a vertex. The error is what it does wrong.
    pub(super) fn check_position(position: [f32; 3]) -> Result<(), String> {
        let (limit, [x, y, z]) = (Self::FARTHEST, position);
        if position.iter().any(|c| !c.is_finite()) {
            Err(format!(
                "has a coordinate that is not finite: {x}, {y}, {z}"
            ))
        } else if position.iter().any(|c| c.abs() > limit) {
            Err(format!("is farther out than {limit:e} units"))
        } else {
            Ok(())
        }
    }

    /// Returns whether it shows a texture: that of `material`, or without one those of its own
    /// materials.
    pub fn shows_texture(&self, material: Option<&Material>) -> bool {
        let has_texture = |material: &Material| material.textures().next().is_some();
        material.map_or_else(|| self.materials.iter().any(has_texture), has_texture)
    }

    /// Returns whether it has texture coordinates, if it needs them for `material`.
    pub fn has_coordinates_for(&self, material: Option<&Material>) -> bool {
        !self.coordinates.is_empty() || !self.shows_texture(material)
    }

    /// Returns the mesh's own normals, or for each vertex the mean of the faces around it, weighted
    /// by their areas.
    pub fn vertex_normals(&self) -> Cow<'_, [[f32; 3]]> {
        if !self.normals.is_empty() {
            return Cow::Borrowed(&self.normals);
        }
        let position = |vertex: u32| DVec3::from(self.positions[vertex as usize].map(f64::from));
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for &[a, b, c] in &self.triangles {
            let normal = (position(b) - position(a)).cross(position(c) - position(a));
            for corner in [a, b, c] {
                sums[corner as usize] += normal;
            }
        }
        sums.into_iter()
            .map(|sum| sum.normalize_or(DVec3::Y).as_vec3().to_array())
            .collect()
    }

    /// Gives it one white material, which the colours of its vertices multiply.
    pub(super) fn paint_by_vertices(&mut self) {
        self.materials = vec![Material {
            diffuse: [1.0; 3],
            vertex_colours: true,
            ..Material::default()
        }];
        self.triangle_materials = vec![0; self.triangles.len()];
    }

    /// Returns one metre along x and z about the origin, its front up, with u along x and v against
    /// z.
    pub fn square() -> Self {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        Self {
            positions: corners.map(|[u, v]| [u - 0.5, 0.0, 0.5 - v]).to_vec(),
            normals: vec![[0.0, 1.0, 0.0]; 4],
            coordinates: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Self::default()
        }
    }

    /// Returns the least and the greatest corner of the vertices' box.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for position in &self.positions {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        (low, high)
    }
}
