//! Ladders of polygon levels: one mesh as ever coarser meshes.
//!
//! A ray of level v, 0 to 1, sees v·(MAX − MIN) + MIN faces (Mochizuki & Makino, equation 10).
//! Edges are collapsed by quadric error; what is left at evenly spaced numbers of faces is a
//! rung, with a tree of its own. A collapse moves a vertex onto its neighbour, so every rung uses
//! vertices of the file's own and is shaded by their normals.

#[cfg(test)]
mod tests;
mod topology;

pub use topology::Topology;

use crate::scene::mesh::TriangleMesh;
use glam::DVec3;
use meshopt::SimplifyOptions;
use shisen_core::frame::FACE_TOLERANCE;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::RangeInclusive;
use thiserror::Error;
use topology::Weld;

/// Which faces a ladder goes from and to, and in how many rungs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PolygonLevels {
    faces: RangeInclusive<u32>,
    rungs: u32,
}

/// Why there are no such polygon levels, and what to give instead.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct LevelsError(String);

impl PolygonLevels {
    /// How many rungs there may be.
    pub const RUNGS: RangeInclusive<u32> = 2..=64;
    /// The default for the fewest faces that a ray sees.
    pub const FEWEST_FACES: u32 = 500;

    /// Returns levels by which a ray sees `faces.start()` faces at level 0 and `faces.end()` at
    /// level 1, or as many as the mesh has. A mesh of no more than `faces.start()` stays as it is.
    ///
    /// # Errors
    /// An empty range, one that starts at 0, or rungs outside [`RUNGS`](Self::RUNGS).
    pub fn new(faces: RangeInclusive<u32>, rungs: u32) -> Result<Self, LevelsError> {
        let (min, max) = (*faces.start(), *faces.end());
        if min == 0 || min > max {
            return Err(LevelsError(format!(
                "{min}..{max} is not a range of faces: give 1 or more, the fewest first"
            )));
        }
        if !Self::RUNGS.contains(&rungs) {
            let (least, most) = (Self::RUNGS.start(), Self::RUNGS.end());
            return Err(LevelsError(format!(
                "there cannot be {rungs} polygon levels: it takes {least} to {most}"
            )));
        }
        Ok(Self { faces, rungs })
    }

    /// Returns whether a mesh has enough faces for coarser levels.
    pub fn apply_to(&self, mesh: &TriangleMesh) -> bool {
        mesh.triangles.len() > *self.faces.start() as usize
    }

    /// Returns how many levels a mesh gets.
    pub(super) fn rungs_of(&self, mesh: &TriangleMesh) -> u32 {
        if self.apply_to(mesh) { self.rungs } else { 1 }
    }

    /// Returns the faces that a mesh of `count` should have at its finest level, and at its
    /// coarsest.
    pub(crate) fn asked_of(&self, count: usize) -> [usize; 2] {
        [*self.faces.end(), *self.faces.start()].map(|faces| count.min(faces as usize))
    }

    /// Returns the largest |faces seen − equation 10| of any pixel, as a share of MAX − MIN: of
    /// rays that see the rung nearest to their level v, which is round((1 − v)·(rungs − 1)), and of
    /// pixels that share a rung with their block, [`FACE_TOLERANCE`] at most from their own.
    /// `faces` are those of each rung, the finest first; 0 where there is but one.
    pub fn largest_deviation(&self, faces: &[u32]) -> f64 {
        let (Some(&finest), true) = (faces.first(), faces.len() > 1) else {
            return 0.0;
        };
        let min = f64::from(*self.faces.start());
        let span = f64::from(finest.min(*self.faces.end())) - min;
        if span <= 0.0 {
            return 0.0;
        }
        let last = (faces.len() - 1) as f64;
        let farthest = f64::from(FACE_TOLERANCE).max(0.5 / last);
        let seen = |(rung, &faces): (usize, &u32)| {
            // The levels at most and at least that see this rung.
            [-farthest, farthest].map(|aside| {
                let level = (1.0 - rung as f64 / last + aside).clamp(0.0, 1.0);
                (f64::from(faces) - (level * span + min)).abs() / span
            })
        };
        let deviations = faces.iter().enumerate().flat_map(seen);
        deviations.fold(0.0, f64::max)
    }
}

/// One mesh at several levels, the finest first.
#[derive(Debug, Clone)]
pub struct Ladder<'m> {
    versions: Cow<'m, TriangleMesh>,
    rungs: Vec<Vec<u32>>,
}

impl<'m> Ladder<'m> {
    /// Returns the mesh itself as the only rung.
    pub fn single(mesh: &'m TriangleMesh) -> Self {
        Self {
            rungs: vec![(0..mesh.triangles.len() as u32).collect()],
            versions: Cow::Borrowed(mesh),
        }
    }

    /// Simplifies a valid mesh to evenly spaced numbers of faces. From where it cannot have fewer
    /// without changing how it hangs together, all coarser rungs are alike. Every rung of a closed
    /// mesh is closed. The same mesh always gives the same ladder.
    pub fn new(mesh: &'m TriangleMesh, levels: &PolygonLevels) -> Self {
        Self::with_each(mesh, Some(levels), |_, _, _| ())
    }

    /// As [`new`](Self::new), or the mesh itself as the only rung; hands on each rung as soon as it
    /// is made, the finest first: its number, the [`versions`](Self::versions) so far, and its
    /// triangles. It leaves out rungs that are like the one before.
    pub(crate) fn with_each(
        mesh: &'m TriangleMesh,
        levels: Option<&PolygonLevels>,
        mut each: impl FnMut(usize, &TriangleMesh, &[u32]),
    ) -> Self {
        let levels = levels.filter(|levels| levels.apply_to(mesh));
        let versions = levels.map(|levels| (levels, Versions::new(mesh)));
        // Where all faces are lines or points there is nothing to collapse.
        let versions = versions.filter(|(_, versions)| !versions.indices.is_empty());
        let Some((levels, mut versions)) = versions else {
            let single = Self::single(mesh);
            each(0, mesh, &single.rungs[0]);
            return single;
        };
        let (min, max) = (*levels.faces.start(), *levels.faces.end());
        if mesh.triangles.len() > max as usize {
            let (faces, _) = versions.simplify(max);
            versions = Versions::new(&versions.mesh.part(&faces));
        }
        let full = versions.mesh.triangles.len() as u32;
        let mut rungs = vec![(0..full).collect::<Vec<u32>>()];
        each(0, &versions.mesh, &rungs[0]);
        let steps = levels.rungs - 1;
        let mut is_stuck = false;
        for rung in 1..=steps {
            // A closed mesh loses two faces a collapse. Half of them goes
            // down, so that the last rung never falls below `min`.
            let lost = u64::from(rung) * u64::from(full.saturating_sub(min));
            let pairs = lost
                .saturating_sub(u64::from(steps))
                .div_ceil(2 * u64::from(steps));
            let finer = &rungs[rung as usize - 1];
            let mut coarser = finer.clone();
            if !is_stuck {
                (coarser, is_stuck) = versions.simplify(full - 2 * pairs as u32);
            }
            if coarser != *finer {
                each(rung as usize, &versions.mesh, &coarser);
            }
            rungs.push(coarser);
        }
        Self {
            versions: Cow::Owned(versions.mesh),
            rungs,
        }
    }

    /// Returns all triangles that occur in a rung, each once, the finest rung's first and in its
    /// order, with the vertices, normals and materials of the finest rung.
    pub fn versions(&self) -> &TriangleMesh {
        &self.versions
    }

    /// Returns the triangles of each rung, ascending numbers into [`versions`](Self::versions). A
    /// rung may be the same as the one before it.
    pub fn rungs(&self) -> &[Vec<u32>] {
        &self.rungs
    }
}

impl TriangleMesh {
    fn part(&self, triangles: &[u32]) -> Self {
        // Where the mesh has none of something, none are found.
        fn of<T: Copy>(all: &[T], kept: &[usize]) -> Vec<T> {
            let found = kept.iter().filter_map(|&old| all.get(old));
            found.copied().collect()
        }
        let mut used = vec![false; self.positions.len()];
        for &triangle in triangles {
            for corner in self.triangles[triangle as usize] {
                used[corner as usize] = true;
            }
        }
        let kept: Vec<usize> = (0..used.len()).filter(|&vertex| used[vertex]).collect();
        let mut renamed = vec![0; used.len()];
        for (new, &old) in kept.iter().enumerate() {
            renamed[old] = new as u32;
        }
        let renamed =
            |triangle: &u32| self.triangles[*triangle as usize].map(|c| renamed[c as usize]);
        let materials = triangles.iter();
        let materials = materials.filter_map(|&t| self.triangle_materials.get(t as usize));
        Self {
            positions: of(&self.positions, &kept),
            normals: of(&self.normals, &kept),
            coordinates: of(&self.coordinates, &kept),
            second_coordinates: of(&self.second_coordinates, &kept),
            tangents: of(&self.tangents, &kept),
            colours: of(&self.colours, &kept),
            triangles: triangles.iter().map(renamed).collect(),
            materials: self.materials.clone(),
            triangle_materials: materials.copied().collect(),
        }
    }
}

const ATTEMPTS: usize = 4;

/// The versions of a mesh's triangles while it is simplified.
struct Versions {
    mesh: TriangleMesh,
    weld: Weld,
    closed: bool,
    indices: Vec<u32>,
    triangle_of: HashMap<[u32; 3], u32>,
    /// The rung in which a triangle was last used, and the rung at hand: a
    /// face that a rung has twice needs two triangles.
    last_rung: Vec<u32>,
    rung: u32,
}

impl Versions {
    fn new(mesh: &TriangleMesh) -> Self {
        let weld = Weld::new(mesh);
        let mut triangle_of = HashMap::with_capacity(4 * weld.faces.len());
        for (&face, &triangle) in weld.faces.iter().zip(&weld.triangles) {
            triangle_of.entry(least_first(face)).or_insert(triangle);
        }
        Self {
            mesh: TriangleMesh {
                normals: mesh.vertex_normals().into_owned(),
                ..mesh.clone()
            },
            indices: weld.faces.as_flattened().to_vec(),
            triangle_of,
            closed: weld.open_edges(&weld.faces) == 0,
            last_rung: vec![0; mesh.triangles.len()],
            rung: 0,
            weld,
        }
    }

    /// Returns the triangles of the mesh when it has about `target` faces: as many, or one more or
    /// less; and whether it cannot have so few.
    fn simplify(&mut self, target: u32) -> (Vec<u32>, bool) {
        let before = self.indices.clone();
        self.collapse(target);
        if self.indices.len() > 3 * (target as usize + 1) {
            // What many small steps leave can be stuck where one from the start is not.
            let start = self.weld.faces.as_flattened().to_vec();
            let stuck = std::mem::replace(&mut self.indices, start);
            self.collapse(target);
            if stuck.len() < self.indices.len() {
                self.indices = stuck;
            }
        }
        let is_open = |indices: &[u32]| self.weld.open_edges(indices.as_chunks::<3>().0) > 0;
        let is_opened = self.closed && is_open(&self.indices);
        if is_opened {
            self.indices = before;
        }
        let faces = self.indices.as_chunks::<3>().0.to_vec();
        self.rung += 1;
        let mut triangles: Vec<u32> = faces.iter().map(|&face| self.triangle(face)).collect();
        triangles.sort_unstable();
        (triangles, is_opened || faces.len() > target as usize + 1)
    }

    fn collapse(&mut self, target: u32) {
        let target = 3 * target as usize;
        let mut aim = target;
        let mut best: Option<Vec<u32>> = None;
        let off = |indices: &Vec<u32>| indices.len().abs_diff(target);
        for _ in 0..ATTEMPTS {
            if self.indices.len() <= aim {
                break;
            }
            let found = meshopt::simplify_decoder(
                &self.indices,
                &self.weld.places,
                aim,
                // No limit: the number of faces alone ends the collapse.
                f32::MAX,
                SimplifyOptions::empty(),
                None,
            );
            // Some edges take more than two faces with them.
            aim += target.saturating_sub(found.len());
            let done = found.len() + 3 >= target;
            let better = best.as_ref().is_none_or(|best| off(&found) < off(best));
            // Some meshes would rather vanish.
            if better && !found.is_empty() {
                best = Some(found);
            }
            if done {
                break;
            }
        }
        if let Some(best) = best {
            self.indices = best;
        }
    }

    fn triangle(&mut self, face: [u32; 3]) -> u32 {
        let key = least_first(face);
        if let Some(&known) = self.triangle_of.get(&key)
            && self.last_rung[known as usize] != self.rung
        {
            self.last_rung[known as usize] = self.rung;
            return known;
        }
        let new = self.mesh.triangles.len() as u32;
        let corners = self.corners(face);
        self.mesh.triangles.push(corners);
        if !self.mesh.triangle_materials.is_empty() {
            let material = self.weld.materials[face[0] as usize];
            self.mesh.triangle_materials.push(material);
        }
        self.last_rung.push(self.rung);
        self.triangle_of.insert(key, new);
        new
    }

    /// Vertices of the mesh at the corners of a face: of those at one place,
    /// the one whose normal is most like the face's.
    fn corners(&self, face: [u32; 3]) -> [u32; 3] {
        let place = |vertex: u32| DVec3::from(self.weld.places[vertex as usize].map(f64::from));
        let [a, b, c] = face.map(place);
        let normal = (b - a).cross(c - a);
        let along = |vertex: &u32| {
            let own = DVec3::from(self.mesh.normals[*vertex as usize].map(f64::from));
            own.dot(normal)
        };
        face.map(|vertex| {
            let originals = self.weld.originals(vertex);
            originals
                .max_by(|a, b| along(a).total_cmp(&along(b)))
                .expect("every vertex stands for one of the mesh's")
        })
    }
}

/// Returns the same corners in the same sense, the least one first.
fn least_first(face: [u32; 3]) -> [u32; 3] {
    match face {
        [a, b, c] if b < a && b < c => [b, c, a],
        [a, b, c] if c < a && c < b => [c, a, b],
        whole => whole,
    }
}
