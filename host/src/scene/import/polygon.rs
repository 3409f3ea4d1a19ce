//! Polygons to triangles.

use super::{ImportError, Unused, no_vertex};
use crate::scene::mesh::TriangleMesh;
use earcut::Earcut;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;

/// Faces by the vertices of their corners, as a file numbers them.
#[derive(Default)]
pub(super) struct Faces {
    /// Vertices of all faces' corners.
    corners: Vec<i64>,
    /// For each face, where its corners end.
    ends: Vec<usize>,
}

impl Faces {
    pub(super) fn push(&mut self, corners: impl IntoIterator<Item = i64>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Adds the triangles of a strip.
    pub(super) fn push_strip(&mut self, strip: &[i64]) {
        for (three, number) in strip.windows(3).zip(0..) {
            let [a, b, c] = [three[0], three[1], three[2]];
            let turned = if number % 2 == 0 {
                [a, b, c]
            } else {
                [b, a, c]
            };
            self.push(turned);
        }
    }

    /// Returns the number of faces.
    pub(super) const fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns the number of all faces' corners.
    pub(super) const fn corners(&self) -> usize {
        self.corners.len()
    }

    /// Returns the face of a corner.
    pub(super) fn face_of(&self, corner: u32) -> usize {
        self.ends.partition_point(|end| *end <= corner as usize)
    }

    /// Adds the faces' triangles to a mesh. `each` gets the corners of each triangle, counted over
    /// all faces.
    pub(super) fn cut(
        &self,
        path: &Path,
        mesh: &mut TriangleMesh,
        unused: &mut Unused,
        mut each: impl FnMut([u32; 3]),
    ) -> Result<(), ImportError> {
        let vertices = mesh.positions.len();
        // Vertices with the corners that they are at.
        let mut corners: Vec<(u32, u32)> = Vec::with_capacity(self.corners.len());
        let mut ends = Vec::with_capacity(self.ends.len());
        let mut first = 0;
        for (number, &end) in self.ends.iter().enumerate() {
            let start = corners.len();
            for (&index, corner) in self.corners[first..end].iter().zip(first..) {
                match u32::try_from(index) {
                    Ok(vertex) if (vertex as usize) < vertices => {
                        corners.push((vertex, corner as u32));
                    }
                    _ => {
                        let face = format!("face {number} (counted from 0)");
                        return Err(no_vertex(path, &face, index, [0, vertices as i64 - 1]));
                    }
                }
            }
            first = end;
            without_repeats(&mut corners, start);
            if corners.len() - start < 3 {
                corners.truncate(start);
                unused.add("face{s} without area", 1);
            } else {
                ends.push(corners.len());
            }
        }
        let twins = if mesh.normals.is_empty() {
            twins(&corners, &ends, |corner| corner.0)
        } else {
            vec![false; ends.len()]
        };
        let mut polygons = Polygons::default();
        let mut first = 0;
        for (end, is_twin) in ends.into_iter().zip(twins) {
            if !is_twin {
                let place = |(vertex, _): (u32, u32)| mesh.positions[vertex as usize];
                polygons.cut(&corners[first..end], place, |three| {
                    mesh.triangles.push(three.map(|(vertex, _)| vertex));
                    each(three.map(|(_, corner)| corner));
                });
            }
            first = end;
        }
        Ok(())
    }
}

/// Leaves one of equal vertices beside each other, in a face that begins at `start`.
fn without_repeats(corners: &mut Vec<(u32, u32)>, start: usize) {
    let mut kept = start;
    for at in start..corners.len() {
        if kept == start || corners[kept - 1].0 != corners[at].0 {
            corners[kept] = corners[at];
            kept += 1;
        }
    }
    if kept > start + 1 && corners[kept - 1].0 == corners[start].0 {
        kept -= 1;
    }
    corners.truncate(kept);
}

/// Gives each vertex of a mesh one value, of those that `values` has for the corners of each
/// triangle: a vertex with several becomes several, whose normals stay as they were. Returns the
/// values of the vertices.
pub(super) fn split<const N: usize>(
    mesh: &mut TriangleMesh,
    values: impl Fn(usize) -> [[f32; N]; 3],
) -> Vec<[f32; N]> {
    fn picked<T: Copy>(all: &[T], sources: &[u32]) -> Vec<T> {
        let known = |source: &u32| all.get(*source as usize).copied();
        sources.iter().filter_map(known).collect()
    }
    let normals = mesh.vertex_normals().into_owned();
    let (mut sources, mut own) = (Vec::new(), Vec::new());
    let mut known = HashMap::new();
    for (triangle, number) in mesh.triangles.iter_mut().zip(0..) {
        for (vertex, value) in triangle.iter_mut().zip(values(number)) {
            let source = *vertex;
            *vertex = *known
                .entry((source, value.map(f32::to_bits)))
                .or_insert_with(|| {
                    sources.push(source);
                    own.push(value);
                    own.len() as u32 - 1
                });
        }
    }
    mesh.normals = picked(&normals, &sources);
    mesh.positions = picked(&mesh.positions, &sources);
    mesh.colours = picked(&mesh.colours, &sources);
    mesh.coordinates = picked(&mesh.coordinates, &sources);
    own
}

/// Cuts polygons into triangles, one after another.
#[derive(Default)]
pub(super) struct Polygons {
    cutter: Earcut<f64>,
    places: Vec<DVec3>,
    cut: Vec<u32>,
}

impl Polygons {
    /// Calls `each` with the triangles of a polygon, turned as it is: around its first corner where
    /// it is convex, else without its notches, in the plane that fits it best.
    pub(super) fn cut<C: Copy>(
        &mut self,
        corners: &[C],
        place: impl Fn(C) -> [f32; 3],
        mut each: impl FnMut([C; 3]),
    ) {
        let count = corners.len();
        let places = corners
            .iter()
            .map(|&c| DVec3::from(place(c).map(f64::from)));
        self.places.clear();
        self.places.extend(places);
        let notched = count > 3 && self.is_notched();
        if notched && self.cut_ears() {
            for ear in self.cut.chunks_exact(3) {
                each([0, 1, 2].map(|corner| corners[ear[corner] as usize]));
            }
            return;
        }
        for second in 1..count.saturating_sub(1) {
            each([corners[0], corners[second], corners[second + 1]]);
        }
    }

    /// Returns the sum of the areas that the edges span with the first corner: along the normal.
    fn area(&self) -> DVec3 {
        let first = self.places[0];
        let edges = self.places.windows(2);
        edges
            .map(|edge| (edge[0] - first).cross(edge[1] - first))
            .sum()
    }

    /// Returns whether some corner turns against the polygon.
    fn is_notched(&self) -> bool {
        let (area, count) = (self.area(), self.places.len());
        (0..count).any(|corner| {
            let [before, here, after] = [0, 1, 2].map(|step| self.places[(corner + step) % count]);
            (here - before).cross(after - here).dot(area) < 0.0
        })
    }

    /// Leaves triangles in `cut`; returns whether they cover the polygon.
    fn cut_ears(&mut self) -> bool {
        let normal = self.area().normalize_or_zero();
        if normal == DVec3::ZERO {
            return false;
        }
        let (across, up) = normal.any_orthonormal_pair();
        let flat: Vec<DVec2> = self
            .places
            .iter()
            .map(|place| DVec2::new(place.dot(across), place.dot(up)))
            .collect();
        let points = flat.iter().map(DVec2::to_array);
        self.cutter.earcut(points, &[], &mut self.cut);
        for ear in self.cut.chunks_exact_mut(3) {
            let [a, b, c] = [0, 1, 2].map(|corner| flat[ear[corner] as usize]);
            if (b - a).perp_dot(c - a) < 0.0 {
                ear.swap(1, 2);
            }
        }
        !self.cut.is_empty()
    }
}

/// Returns for each face whether an earlier one is the same, turned over: programs write both where
/// a surface is seen from both sides, and normals of their vertices would cancel. Faces follow each
/// other in `corners` up to their `ends`.
pub(super) fn twins<C: Copy>(
    corners: &[C],
    ends: &[usize],
    vertex: impl Fn(C) -> u32,
) -> Vec<bool> {
    // Around from the least vertex towards the lesser of its neighbours.
    let around = |number: usize| {
        let first = number.checked_sub(1).map_or(0, |before| ends[before]);
        let face = &corners[first..ends[number]];
        let count = face.len();
        let vertex = &vertex;
        let at = move |step: usize| vertex(face[step % count]);
        let least = (0..count).min_by_key(|&step| at(step)).unwrap_or(0);
        let forward = at(least + 1) < at(least + count - 1);
        let step = if forward { 1 } else { count - 1 };
        let all = (0..count).map(move |n| at(least + n * step));
        (forward, all)
    };
    let mut all: Vec<(u64, usize)> = Vec::with_capacity(ends.len());
    for number in 0..ends.len() {
        let mut hasher = DefaultHasher::new();
        around(number).1.for_each(|vertex| vertex.hash(&mut hasher));
        all.push((hasher.finish(), number));
    }
    all.sort_unstable();
    let mut twins = vec![false; ends.len()];
    for same in all
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() > 1)
    {
        let (forward, first) = around(same[0].1);
        for &(_, number) in &same[1..] {
            let (other, face) = around(number);
            twins[number] = other != forward && face.eq(first.clone());
        }
    }
    twins
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(outline: &[[f32; 2]]) -> (f64, usize) {
        let corners: Vec<usize> = (0..outline.len()).collect();
        let place = |corner: usize| [outline[corner][0], 5.0, -outline[corner][1]];
        let (mut sum, mut count) = (0.0, 0);
        Polygons::default().cut(&corners, place, |triangle| {
            let [a, b, c] = triangle.map(|corner| DVec2::from(outline[corner].map(f64::from)));
            let own = 0.5 * (b - a).perp_dot(c - a);
            assert!(own >= 0.0, "{triangle:?} is turned over");
            sum += own;
            count += 1;
        });
        (sum, count)
    }

    #[test]
    fn notches_stay_open() {
        let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        let arrow = [[0., 0.], [2., 1.], [0., 2.], [1., 1.]];
        for (outline, expected) in [(&l[..], 3.0), (&arrow, 1.0)] {
            for first in 0..outline.len() {
                let mut turned = outline.to_vec();
                turned.rotate_left(first);
                assert_eq!(area(&turned), (expected, outline.len() - 2), "from {first}");
            }
        }
    }

    #[test]
    fn a_face_turned_over_is_a_twin_of_an_earlier_one() {
        let faces: [&[u32]; 6] = [
            &[1, 2, 3, 4],
            &[2, 1, 4, 3],
            &[1, 2, 3, 4],
            &[1, 3, 2, 4],
            &[5, 6, 7],
            &[7, 6, 5],
        ];
        let mut end = 0;
        let ends = faces.map(|face| {
            end += face.len();
            end
        });
        let expected = [false, true, false, false, false, true];
        assert_eq!(twins(&faces.concat(), &ends, |vertex| vertex), expected);
    }

    #[test]
    fn what_is_convex_or_has_no_plane_is_a_fan() {
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        assert_eq!(area(&square), (1.0, 2));
        assert_eq!(area(&[[0., 0.], [1., 0.], [2., 0.], [1., 0.]]).1, 2);
    }
}
