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
    /// Three indices into `positions` a triangle, counter-clockwise from
    /// outside, in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// Materials that the file brings; may be empty.
    pub materials: Vec<Material>,
    /// One index into `materials` a triangle; empty where the file has none.
    pub triangle_materials: Vec<u32>,
}

/// Why a mesh cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum MeshError {
    /// Nothing to trace.
    #[error("the mesh has no triangles")]
    NoTriangles,
    /// A coordinate that is NaN or infinite.
    #[error(
        "vertex {vertex} (counted from 0) has a coordinate that is not finite: {}, {}, {}",
        .position[0], .position[1], .position[2]
    )]
    NotFinite { vertex: usize, position: [f32; 3] },
    /// A coordinate too large for f32 arithmetic on it to stay finite.
    #[error("vertex {vertex} (counted from 0) is farther out than {limit:e} units")]
    TooFar { vertex: usize, limit: f32 },
    /// An index past the last vertex.
    #[error(
        "triangle {triangle} (counted from 0) names vertex {index}, but the mesh has {vertices}"
    )]
    IndexOutOfRange {
        triangle: usize,
        index: u32,
        vertices: usize,
    },
    /// A place on a texture that is NaN, infinite or far beyond it.
    #[error(
        "vertex {vertex} (counted from 0) is at {}, {} on its texture, but coordinates may be up \
         to {limit:e}",
        .coordinate[0], .coordinate[1]
    )]
    Coordinate {
        vertex: usize,
        coordinate: [f32; 2],
        limit: f32,
    },
    /// The same vertex twice in one triangle.
    #[error("triangle {triangle} (counted from 0) names vertex {index} twice")]
    RepeatedVertex { triangle: usize, index: u32 },
    /// Side tables of the wrong length, or a material that is not there.
    #[error("{what}: {found} entries where {expected} belong")]
    Length {
        what: &'static str,
        found: usize,
        expected: usize,
    },
    /// More than the scene format holds.
    #[error("{count} triangles are more than the {limit} that one mesh may have")]
    TooMany { count: usize, limit: usize },
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
        if self.triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        if self.triangles.len() > Self::MOST_TRIANGLES {
            return Err(MeshError::TooMany {
                count: self.triangles.len(),
                limit: Self::MOST_TRIANGLES,
            });
        }
        for (vertex, &position) in self.positions.iter().enumerate() {
            Self::check_position(vertex, position)?;
        }
        let vertices = self.positions.len();
        for (triangle, &[a, b, c]) in self.triangles.iter().enumerate() {
            if let Some(index) = [a, b, c].into_iter().find(|&i| i as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange {
                    triangle,
                    index,
                    vertices,
                });
            }
            if a == b || b == c || a == c {
                let index = if a == b || a == c { a } else { b };
                return Err(MeshError::RepeatedVertex { triangle, index });
            }
        }
        let expect = |what, found: usize, expected: usize| {
            if found == 0 || found == expected {
                Ok(())
            } else {
                Err(MeshError::Length {
                    what,
                    found,
                    expected,
                })
            }
        };
        expect("normals", self.normals.len(), vertices)?;
        expect("coordinates", self.coordinates.len(), vertices)?;
        let limit = Self::FARTHEST_COORDINATE;
        let usable = |c: &[f32; 2]| c.iter().all(|c| c.abs() <= limit);
        if let Some(vertex) = self.coordinates.iter().position(|c| !usable(c)) {
            return Err(MeshError::Coordinate {
                vertex,
                coordinate: self.coordinates[vertex],
                limit,
            });
        }
        expect(
            "triangle materials",
            self.triangle_materials.len(),
            self.triangles.len(),
        )?;
        if let Some(&index) = self
            .triangle_materials
            .iter()
            .find(|&&index| index as usize >= self.materials.len())
        {
            return Err(MeshError::Length {
                what: "materials",
                found: self.materials.len(),
                expected: index as usize + 1,
            });
        }
        Ok(())
    }

    /// Checks one position.
    pub(super) fn check_position(vertex: usize, position: [f32; 3]) -> Result<(), MeshError> {
        let limit = Self::FARTHEST;
        if position.iter().any(|c| !c.is_finite()) {
            Err(MeshError::NotFinite { vertex, position })
        } else if position.iter().any(|c| c.abs() > limit) {
            Err(MeshError::TooFar { vertex, limit })
        } else {
            Ok(())
        }
    }

    /// Whether it shows a texture: that of `material`, or without one those of its own materials.
    pub fn shows_texture(&self, material: Option<&Material>) -> bool {
        let has_texture = |material: &Material| material.texture.is_some();
        material.map_or_else(|| self.materials.iter().any(has_texture), has_texture)
    }

    /// Whether it has texture coordinates, if it needs them for `material`.
    pub fn has_coordinates_for(&self, material: Option<&Material>) -> bool {
        !self.coordinates.is_empty() || !self.shows_texture(material)
    }

    /// The mesh's own normals, or for each vertex the mean of the faces around it, weighted by
    /// their areas.
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

    /// One metre along x and z about the origin, its front up, with u along x
    /// and v against z.
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

    /// The least and the greatest corner of the vertices' box.
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
