//! How the faces of a mesh are connected, with vertices at the same place as one.

use crate::scene::mesh::TriangleMesh;
use std::collections::HashMap;

/// How the faces of a mesh are connected. Vertices at the same place are one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Sides of faces that no other face closes.
    pub open_edges: usize,
    /// Edges of more than two faces.
    pub crowded_edges: usize,
}

impl Topology {
    /// Examines a mesh whose indices are in range.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let weld = Weld::new(mesh);
        let sides = weld.sides(&weld.faces);
        Self {
            open_edges: Side::edges(&sides).map(Side::open).sum(),
            crowded_edges: Side::edges(&sides).filter(|edge| edge.len() > 2).count(),
        }
    }

    /// Returns whether no ray gets inside other than through a face.
    pub const fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// A mesh with one vertex for all that share a place, a material and texture coordinates, so that
/// seams between normals do not separate its faces. Seams between materials or parts of a texture
/// stay, and the simplifier collapses both sides of them alike.
pub(super) struct Weld {
    pub(super) places: Vec<[f32; 3]>,
    /// Their material; 0 where the mesh has none.
    pub(super) materials: Vec<u32>,
    /// The first vertex at the same place.
    first_at_place: Vec<u32>,
    /// The faces whose corners are at three places.
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) triangles: Vec<u32>,
    /// Pairs of a vertex and one of the mesh's that it stands for, ascending.
    stands_for: Vec<(u32, u32)>,
}

impl Weld {
    pub(super) fn new(mesh: &TriangleMesh) -> Self {
        let mut weld = Self {
            places: Vec::new(),
            materials: Vec::new(),
            first_at_place: Vec::new(),
            faces: Vec::with_capacity(mesh.triangles.len()),
            triangles: Vec::with_capacity(mesh.triangles.len()),
            stands_for: Vec::with_capacity(mesh.positions.len()),
        };
        let mut of_material = HashMap::with_capacity(mesh.positions.len());
        let mut at_place = HashMap::with_capacity(mesh.positions.len());
        for (triangle, &corners) in mesh.triangles.iter().enumerate() {
            let material = mesh.triangle_materials.get(triangle).copied().unwrap_or(0);
            let face = corners.map(|corner| {
                // + 0.0 leaves no −0 behind.
                let place = mesh.positions[corner as usize].map(|c| c + 0.0);
                let bits = place.map(f32::to_bits);
                let looks = [&mesh.coordinates, &mesh.second_coordinates];
                let looks = looks.map(|set| {
                    let place = set.get(corner as usize);
                    place.map(|place| place.map(|c| (c + 0.0).to_bits()))
                });
                let colour = mesh.colours.get(corner as usize);
                let colour = colour.map(|colour| colour.map(f32::to_bits));
                // A texture that is mirrored there.
                let side = mesh.tangents.get(corner as usize).map(|of| of[3] < 0.0);
                let key = (bits, material, looks, colour, side);
                let vertex = *of_material.entry(key).or_insert_with(|| {
                    let new = weld.places.len() as u32;
                    weld.places.push(place);
                    weld.materials.push(material);
                    weld.first_at_place
                        .push(*at_place.entry(bits).or_insert(new));
                    new
                });
                weld.stands_for.push((vertex, corner));
                vertex
            });
            let [a, b, c] = face;
            if a != b && b != c && c != a {
                weld.faces.push(face);
                weld.triangles.push(triangle as u32);
            }
        }
        weld.stands_for.sort_unstable();
        weld.stands_for.dedup();
        weld
    }

    /// Sides of some faces, those of the same edge beside each other, materials or not.
    fn sides(&self, faces: &[[u32; 3]]) -> Vec<Side> {
        let at = |vertex: u32| self.first_at_place[vertex as usize];
        let mut sides: Vec<Side> = faces
            .iter()
            .flat_map(|corners| {
                (0..3).map(move |slot| {
                    let (from, to) = (at(corners[slot]), at(corners[(slot + 1) % 3]));
                    Side {
                        ends: [from.min(to), from.max(to)],
                        ascends: from < to,
                    }
                })
            })
            .collect();
        sides.sort_unstable();
        sides
    }

    /// Sides of some faces that no other of them closes.
    pub(super) fn open_edges(&self, faces: &[[u32; 3]]) -> usize {
        Side::edges(&self.sides(faces)).map(Side::open).sum()
    }

    pub(super) fn originals(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let first = self.stands_for.partition_point(|&(v, _)| v < vertex);
        let rest = self.stands_for[first..].iter();
        rest.take_while(move |&&(v, _)| v == vertex)
            .map(|&(_, o)| o)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// In ascending order.
    ends: [u32; 2],
    /// Whether it leads from the lesser end to the greater.
    ascends: bool,
}

impl Side {
    fn edges(sides: &[Self]) -> impl Iterator<Item = &[Self]> {
        sides.chunk_by(|a, b| a.ends == b.ends)
    }

    /// Returns how many of an edge's sides have no opposite.
    fn open(edge: &[Self]) -> usize {
        let ascending = edge.iter().filter(|side| side.ascends).count();
        ascending.abs_diff(edge.len() - ascending)
    }
}
