//! Ladders of polygon levels: one mesh as ever coarser meshes.
//!
//! A ray of level v, 0 to 1, sees v·(MAX − MIN) + MIN faces (Mochizuki & Makino,
//! equation 10). Which those are is decided ahead: edges are collapsed by
//! quadric error until fewer and fewer faces are left, and what is left at
//! evenly spaced numbers is a rung. A collapse moves a vertex onto its
//! neighbour, so every rung uses vertices of the file's own and is shaded by
//! their normals.

use crate::mesh::TriangleMesh;
use glam::DVec3;
use meshopt::SimplifyOptions;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::RangeInclusive;
use thiserror::Error;

/// Which faces a ladder goes from and to, and in how many rungs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PolygonLevels {
    faces: RangeInclusive<u32>,
    rungs: u32,
}

/// Polygon levels that there cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum LevelsError {
    /// From more to fewer, or from none.
    #[error("{min}..{max} is no range of faces: it takes 1 or more, and the fewest first")]
    Faces {
        /// The fewest.
        min: u32,
        /// The most.
        max: u32,
    },
    /// Too few rungs to be a ladder, or more than the format holds.
    #[error(
        "there cannot be {found} polygon levels: it takes {} to {}",
        PolygonLevels::RUNGS.start(),
        PolygonLevels::RUNGS.end()
    )]
    Rungs {
        /// What was asked for.
        found: u32,
    },
}

impl PolygonLevels {
    /// How many rungs there may be.
    pub const RUNGS: RangeInclusive<u32> = 2..=64;
    /// The fewest faces that a ray sees where nothing else is asked for.
    pub const FEWEST_FACES: u32 = 500;

    /// A ray sees `faces.start()` at level 0 and `faces.end()` at level 1, or
    /// as many as the mesh has where that is less. A mesh of no more than
    /// `faces.start()` stays as it is.
    ///
    /// # Errors
    /// An empty range, one that starts at 0, or rungs outside
    /// [`RUNGS`](Self::RUNGS).
    pub fn new(faces: RangeInclusive<u32>, rungs: u32) -> Result<Self, LevelsError> {
        let (min, max) = (*faces.start(), *faces.end());
        if min == 0 || min > max {
            return Err(LevelsError::Faces { min, max });
        }
        if !Self::RUNGS.contains(&rungs) {
            return Err(LevelsError::Rungs { found: rungs });
        }
        Ok(Self { faces, rungs })
    }

    /// The largest |faces seen − equation 10| of any level, as a share of
    /// MAX − MIN, where a ray of level v sees rung round((1 − v)·(rungs − 1)). `faces` are those of each rung, the finest
    /// first; 0 where there is but one.
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
        let seen = |(rung, &faces): (usize, &u32)| {
            // 1 − v where this rung begins and ends to be the nearest.
            [rung as f64 - 0.5, rung as f64 + 0.5].map(|edge| {
                let level = 1.0 - (edge / last).clamp(0.0, 1.0);
                (f64::from(faces) - (level * span + min)).abs() / span
            })
        };
        let deviations = faces.iter().enumerate().flat_map(seen);
        deviations.fold(0.0, f64::max)
    }
}

/// How the faces of a mesh hang together. Vertices at the same place are one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topology {
    /// Sides of faces that no other face closes.
    pub open_edges: usize,
    /// Edges of more than two faces.
    pub crowded_edges: usize,
    /// Vertices at which more than one fan of faces meets.
    pub pinched_vertices: usize,
}

impl Topology {
    /// That of a mesh whose indices are in range.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let weld = Weld::new(mesh);
        let sides = weld.sides(&weld.faces);
        let (mut open_edges, mut crowded_edges) = (0, 0);
        // The corners at a vertex, joined where their faces share an edge.
        let mut fans = Fans::new(3 * weld.faces.len());
        for edge in Side::edges(&sides) {
            open_edges += Side::open(edge);
            crowded_edges += usize::from(edge.len() > 2);
            for side in &edge[1..] {
                for (a, b) in edge[0].corners().into_iter().zip(side.corners()) {
                    fans.join(a, b);
                }
            }
        }
        let mut fans_at = vec![0u32; weld.places.len()];
        for (corner, &vertex) in weld.faces.as_flattened().iter().enumerate() {
            let place = weld.first_at_place[vertex as usize];
            fans_at[place as usize] += u32::from(fans.root(corner) == corner);
        }
        Self {
            open_edges,
            crowded_edges,
            pinched_vertices: fans_at.into_iter().filter(|&fans| fans > 1).count(),
        }
    }

    /// Whether no ray gets inside other than through a face.
    pub const fn is_closed(&self) -> bool {
        self.open_edges == 0
    }
}

/// Why a mesh has no ladder of the kind asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum LadderError {
    /// It does not get that coarse.
    #[error(
        "it cannot be simplified to {asked} faces without changing how it hangs together: \
         {reached} is the least that it gets to, so ask for no fewer"
    )]
    Unreachable {
        /// Faces asked for.
        asked: u32,
        /// The fewest that it can have.
        reached: u32,
    },
    /// A closed mesh came out with holes.
    #[error("it is closed, and simplified to {faces} faces it would have {open_edges} open edges")]
    Opened {
        /// Faces of the rung.
        faces: u32,
        /// Sides of them that no other face closes.
        open_edges: usize,
    },
}

impl LadderError {
    fn for_fewest(self, min: u32) -> Self {
        match self {
            Self::Unreachable { reached, .. } => Self::Unreachable {
                asked: min,
                reached,
            },
            opened @ Self::Opened { .. } => opened,
        }
    }
}

/// One mesh at several levels, the finest first.
#[derive(Debug, Clone)]
pub struct Ladder<'m> {
    versions: Cow<'m, TriangleMesh>,
    rungs: Vec<Vec<u32>>,
}

impl<'m> Ladder<'m> {
    /// A mesh as it is, alone.
    pub fn single(mesh: &'m TriangleMesh) -> Self {
        Self {
            rungs: vec![(0..mesh.triangles.len() as u32).collect()],
            versions: Cow::Borrowed(mesh),
        }
    }

    /// Simplifies a valid mesh again and again, to evenly spaced numbers of
    /// faces. Every rung of a closed mesh is closed. The same mesh always
    /// gives the same ladder.
    ///
    /// # Errors
    /// Where the mesh cannot be simplified that far.
    pub fn new(mesh: &'m TriangleMesh, levels: &PolygonLevels) -> Result<Self, LadderError> {
        let (min, max) = (*levels.faces.start(), *levels.faces.end());
        if mesh.triangles.len() <= min as usize {
            return Ok(Self::single(mesh));
        }
        let mut finest = Cow::Borrowed(mesh);
        let mut versions = Versions::new(mesh);
        if mesh.triangles.len() > max as usize {
            let faces = versions.simplify(max)?;
            finest = Cow::Owned(versions.mesh.part(&faces));
            versions = Versions::new(&finest);
        }
        let full = finest.triangles.len() as u32;
        let mut rungs = vec![(0..full).collect()];
        let steps = levels.rungs - 1;
        for rung in 1..=steps {
            // A closed mesh loses two faces a collapse. Half of them goes
            // down, so that the last rung never falls below `min`.
            let lost = u64::from(rung) * u64::from(full.saturating_sub(min));
            let pairs = lost
                .saturating_sub(u64::from(steps))
                .div_ceil(2 * u64::from(steps));
            let coarser = versions.simplify(full - 2 * pairs as u32);
            // It stays where it is stuck, so it does not get to `min` either.
            rungs.push(coarser.map_err(|error| error.for_fewest(min))?);
        }
        Ok(Self {
            versions: Cow::Owned(versions.mesh),
            rungs,
        })
    }

    /// All triangles that occur in a rung, each once, with the vertices,
    /// normals and materials of the finest rung. The first are the finest
    /// rung's in its order, which is the file's where the ladder starts with
    /// all of its faces.
    pub fn versions(&self) -> &TriangleMesh {
        &self.versions
    }

    /// The triangles of each rung, ascending numbers into
    /// [`versions`](Self::versions). A rung may be the same as the one before
    /// it.
    pub fn rungs(&self) -> &[Vec<u32>] {
        &self.rungs
    }
}

impl TriangleMesh {
    /// The mesh of some of the triangles, with the vertices that they use.
    fn part(&self, triangles: &[u32]) -> Self {
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
        let materials = if self.triangle_materials.is_empty() {
            &[][..]
        } else {
            triangles
        };
        Self {
            positions: kept.iter().map(|&old| self.positions[old]).collect(),
            normals: kept.iter().map(|&old| self.normals[old]).collect(),
            triangles: triangles.iter().map(renamed).collect(),
            materials: self.materials.clone(),
            triangle_materials: materials
                .iter()
                .map(|&triangle| self.triangle_materials[triangle as usize])
                .collect(),
        }
    }
}

/// A mesh whose vertices at the same place and of the same material are one,
/// so that seams between normals do not hold its faces apart. Where materials
/// meet stays a seam, along which the simplifier collapses both sides alike.
struct Weld {
    /// Where the vertices are.
    places: Vec<[f32; 3]>,
    /// Their material; 0 where the mesh has none.
    materials: Vec<u32>,
    /// The first vertex at the same place.
    first_at_place: Vec<u32>,
    /// The faces whose corners are at three places.
    faces: Vec<[u32; 3]>,
    /// Which triangle each of them is.
    triangles: Vec<u32>,
    /// Pairs of a vertex and one of the mesh's that it stands for, ascending.
    stands_for: Vec<(u32, u32)>,
}

impl Weld {
    fn new(mesh: &TriangleMesh) -> Self {
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
                let vertex = *of_material.entry((bits, material)).or_insert_with(|| {
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

    /// Sides of some faces, those of the same edge beside each other,
    /// materials or not.
    fn sides(&self, faces: &[[u32; 3]]) -> Vec<Side> {
        let at = |vertex: u32| self.first_at_place[vertex as usize];
        let mut sides: Vec<Side> = faces
            .iter()
            .enumerate()
            .flat_map(|(face, corners)| {
                (0..3).map(move |slot| {
                    let (from, to) = (at(corners[slot]), at(corners[(slot + 1) % 3]));
                    Side {
                        ends: [from.min(to), from.max(to)],
                        face: face as u32,
                        slot: slot as u8,
                        ascends: from < to,
                    }
                })
            })
            .collect();
        sides.sort_unstable();
        sides
    }

    /// Sides of some faces that no other of them closes.
    fn open_edges(&self, faces: &[[u32; 3]]) -> usize {
        Side::edges(&self.sides(faces)).map(Side::open).sum()
    }

    /// The vertices of the mesh that one stands for.
    fn originals(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let first = self.stands_for.partition_point(|&(v, _)| v < vertex);
        let rest = self.stands_for[first..].iter();
        rest.take_while(move |&&(v, _)| v == vertex)
            .map(|&(_, o)| o)
    }
}

/// How often the simplifier is asked again where it goes too far.
const ATTEMPTS: usize = 4;

/// The versions of a mesh's triangles while it is simplified.
struct Versions {
    mesh: TriangleMesh,
    weld: Weld,
    closed: bool,
    /// The faces that are left, as the simplifier takes them.
    indices: Vec<u32>,
    /// The triangle that stands for a face, by [`least_first`].
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

    /// The triangles of the mesh when it has about `target` faces: as many,
    /// or one more or less, wherever that can be.
    fn simplify(&mut self, target: u32) -> Result<Vec<u32>, LadderError> {
        self.collapse(target);
        if self.indices.len() > 3 * (target as usize + 1) {
            // What many small steps leave can be stuck where one from the
            // start is not.
            let start = self.weld.faces.as_flattened().to_vec();
            let stuck = std::mem::replace(&mut self.indices, start);
            self.collapse(target);
            if stuck.len() < self.indices.len() {
                self.indices = stuck;
            }
        }
        let faces = self.indices.as_chunks::<3>().0.to_vec();
        let reached = faces.len() as u32;
        if reached == 0 || reached > target + 1 {
            return Err(LadderError::Unreachable {
                asked: target,
                reached,
            });
        }
        self.rung += 1;
        let mut triangles: Vec<u32> = faces.iter().map(|&face| self.triangle(face)).collect();
        triangles.sort_unstable();
        if self.closed {
            let open_edges = self.weld.open_edges(&faces);
            if open_edges > 0 {
                return Err(LadderError::Opened {
                    faces: reached,
                    open_edges,
                });
            }
        }
        Ok(triangles)
    }

    /// Collapses edges until `target` faces are left.
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
            if best.as_ref().is_none_or(|best| off(&found) < off(best)) {
                best = Some(found);
            }
            if done {
                break;
            }
        }
        self.indices = best.unwrap_or_else(|| std::mem::take(&mut self.indices));
    }

    /// The triangle that stands for a face, made where there is none.
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

/// The same corners in the same sense, the least one first.
fn least_first(face: [u32; 3]) -> [u32; 3] {
    match face {
        [a, b, c] if b < a && b < c => [b, c, a],
        [a, b, c] if c < a && c < b => [c, a, b],
        whole => whole,
    }
}

/// A side of a face: its ends in ascending order, and which corner of which
/// face it starts at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    ends: [u32; 2],
    face: u32,
    slot: u8,
    /// Whether it leads from the lesser end to the greater.
    ascends: bool,
}

impl Side {
    /// By edge.
    fn edges(sides: &[Self]) -> impl Iterator<Item = &[Self]> {
        sides.chunk_by(|a, b| a.ends == b.ends)
    }

    /// How many of an edge's sides have no opposite.
    fn open(edge: &[Self]) -> usize {
        let ascending = edge.iter().filter(|side| side.ascends).count();
        ascending.abs_diff(edge.len() - ascending)
    }

    /// Numbers of the face's corners at the lesser and at the greater end.
    fn corners(&self) -> [usize; 2] {
        let first = 3 * self.face as usize;
        let ends = [self.slot, (self.slot + 1) % 3].map(|slot| first + slot as usize);
        if self.ascends {
            ends
        } else {
            [ends[1], ends[0]]
        }
    }
}

/// Corners that belong together: each knows another, or is the root.
struct Fans(Vec<usize>);

impl Fans {
    fn new(corners: usize) -> Self {
        Self((0..corners).collect())
    }

    fn root(&mut self, mut corner: usize) -> usize {
        while self.0[corner] != corner {
            self.0[corner] = self.0[self.0[corner]];
            corner = self.0[corner];
        }
        corner
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
