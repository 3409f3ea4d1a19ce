//! Tangents of meshes with normal maps, by Mikkelsen's rule (2008), which the programs that make
//! such maps follow.

use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::Texture;
use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::Vec3;
use std::borrow::Cow;
use std::collections::HashMap;

/// The tangent of a vertex that no normal map needs.
const UNUSED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];

/// Returns a mesh with tangents where the materials of its objects, or its own where an object has
/// none, have normal maps. A vertex whose tangents differ from face to face becomes several; faces
/// keep their numbers.
pub(super) fn with_tangents<'m>(
    mesh: &'m TriangleMesh,
    materials: &[Option<&'m Material>],
) -> Cow<'m, TriangleMesh> {
    let map = |material: &'m Material| Some(&material.normal_map.as_ref()?.texture);
    let of_objects = materials
        .iter()
        .flatten()
        .find_map(|material| map(material));
    let takes_own = materials.iter().any(Option::is_none);
    let texture = |triangle: usize| {
        let own = mesh.triangle_materials.get(triangle);
        let own = own.and_then(|&number| map(mesh.materials.get(number as usize)?));
        own.filter(|_| takes_own).or(of_objects)
    };
    let mapped = (0..mesh.triangles.len()).filter_map(|one| Some((one, texture(one)?)));
    let mapped: Vec<(usize, &Texture)> = mapped.collect();
    if mapped.is_empty() {
        return Cow::Borrowed(mesh);
    }
    let given = |vertex: u32| mesh.tangents.get(vertex as usize).filter(|of| of[3] != 0.0);
    let lacks = |&(one, _): &(usize, _)| mesh.triangles[one].iter().any(|&v| given(v).is_none());
    let mut faces = Faces {
        mesh,
        normals: mesh.vertex_normals(),
        mapped: mapped.into_iter().filter(lacks).collect(),
        tangents: Vec::new(),
    };
    faces.tangents = vec![[UNUSED; 3]; faces.mapped.len()];
    let Ok(()) = generate_tangents::<_, SameEverywhere>(&mut faces) else {
        unreachable!("it has no errors");
    };
    let mut whole = TriangleMesh {
        normals: faces.normals.into_owned(),
        tangents: vec![UNUSED; mesh.positions.len()],
        ..mesh.clone()
    };
    let mut taken = vec![false; mesh.positions.len()];
    for (vertex, taken) in taken.iter_mut().enumerate() {
        if let Some(tangent) = given(vertex as u32) {
            (whole.tangents[vertex], *taken) = (*tangent, true);
        }
    }
    let mut known = HashMap::new();
    for (&(triangle, _), tangents) in faces.mapped.iter().zip(faces.tangents) {
        for (corner, tangent) in tangents.into_iter().enumerate() {
            let vertex = mesh.triangles[triangle][corner];
            let key = (vertex, tangent.map(f32::to_bits));
            whole.triangles[triangle][corner] = *known.entry(key).or_insert_with(|| {
                if std::mem::replace(&mut taken[vertex as usize], true) {
                    return again(&mut whole, vertex as usize, tangent);
                }
                whole.tangents[vertex as usize] = tangent;
                vertex
            });
        }
    }
    Cow::Owned(whole)
}

/// Adds a vertex like another, with a tangent of its own; returns its number.
fn again(mesh: &mut TriangleMesh, vertex: usize, tangent: [f32; 4]) -> u32 {
    fn add<T: Copy>(all: &mut Vec<T>, vertex: usize) {
        all.extend(all.get(vertex).copied());
    }
    add(&mut mesh.positions, vertex);
    add(&mut mesh.normals, vertex);
    add(&mut mesh.coordinates, vertex);
    add(&mut mesh.second_coordinates, vertex);
    add(&mut mesh.colours, vertex);
    mesh.tangents.push(tangent);
    mesh.tangents.len() as u32 - 1
}

/// Triangles whose corners get tangents.
struct Faces<'m> {
    mesh: &'m TriangleMesh,
    normals: Cow<'m, [[f32; 3]]>,
    /// Their numbers and their normal maps.
    mapped: Vec<(usize, &'m Texture)>,
    tangents: Vec<[[f32; 4]; 3]>,
}

impl Faces<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.mapped[face].0][corner] as usize
    }
}

/// Mathematics with the same bits on all machines.
struct SameEverywhere;

impl Ops for SameEverywhere {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        libm::acos(f64::from(x)) as f32
    }
}

impl Geometry<SameEverywhere> for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.mapped.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)]
    }

    /// Those of the image, which may be turned.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let texture = self.mapped[face].1;
        let second = &self.mesh.second_coordinates;
        let set = match second {
            second if texture.second_coordinates && !second.is_empty() => second,
            _ => &self.mesh.coordinates,
        };
        let [u, v] = set[self.vertex(face, corner)];
        let [of_u, of_v, origin] = texture.map;
        [0, 1].map(|axis| of_u[axis] * u + of_v[axis] * v + origin[axis])
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let [x, y, z, side] = space.map_or([0.0; 4], |space| space.tangent_encoded());
        // A face without an area on the image has none.
        let tangent = Vec3::new(x, y, z).try_normalize().unwrap_or_else(|| {
            let normal = Vec3::from_array(self.normal(face, corner));
            normal.any_orthonormal_vector()
        });
        let side = if side < 0.0 { -1.0 } else { 1.0 };
        self.tangents[face][corner] = tangent.extend(side).to_array();
    }
}
