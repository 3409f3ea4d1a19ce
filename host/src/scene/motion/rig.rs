//! What of a model's file moves, before and as it is taken apart into a scene.

use super::{Channel, Clip, Deform, Deformed, Follower, Node, Scene};
use crate::scene::mesh::TriangleMesh;
use crate::scene::{Object, Shape};
use std::collections::BTreeMap;
use std::ops::Range;
use std::str::FromStr;

/// Which animations of a model play.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Playing {
    /// The first, as viewers do.
    #[default]
    First,
    /// All at once.
    All,
    /// None: the model stands as its file has it.
    None,
    /// Those of a name.
    Named(String),
}

impl FromStr for Playing {
    type Err = std::convert::Infallible;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Ok(match name {
            "all" => Self::All,
            "none" => Self::None,
            name => Self::Named(name.to_owned()),
        })
    }
}

/// A part of a model's mesh that moves by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its vertices in the mesh.
    pub vertices: Range<usize>,
    /// The node that it follows.
    pub node: Option<usize>,
    /// Whether the mesh has the corners of its triangles swapped, because the node mirrors them.
    pub is_mirrored: bool,
    /// How it deforms. Positions and normals are those in the node's frame.
    pub deform: Deform,
}

/// What of a model moves, in the model's frame; nothing by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    /// The nodes of its scene, each after its parent.
    pub nodes: Vec<Node>,
    /// Its animations.
    pub clips: Vec<Clip>,
    /// Parts that some animation moves, in the order of their vertices.
    pub parts: Vec<Part>,
}

impl Rig {
    /// Chooses the animations that play.
    pub fn play(&mut self, playing: &Playing) {
        for (number, clip) in self.clips.iter_mut().enumerate() {
            clip.plays = match playing {
                Playing::First => number == 0,
                Playing::All => true,
                Playing::None => false,
                Playing::Named(name) => clip.name == *name,
            };
        }
    }
}

/// Returns for each node whether channels move it or a node above it.
pub(in crate::scene) fn moving<'c>(
    nodes: &[Node],
    channels: impl IntoIterator<Item = &'c Channel>,
) -> Vec<bool> {
    let mut moves = vec![false; nodes.len()];
    for channel in channels
        .into_iter()
        .filter(|one| !one.course.is_of_weights())
    {
        moves[channel.node] = true;
    }
    for (number, node) in nodes.iter().enumerate() {
        moves[number] |= node.parent.is_some_and(|parent| moves[parent]);
    }
    moves
}

impl Scene {
    /// Takes a mesh apart into what stands still in its frame and the parts that play: these become
    /// meshes and objects after all others, or its own where nothing stands still. The scene then
    /// stands as at 0 s.
    pub(in crate::scene) fn animate(&mut self, mesh: usize, rig: Rig) {
        let Rig {
            nodes,
            clips,
            parts,
        } = rig;
        let playing = clips.iter().filter(|clip| clip.plays);
        let channels: Vec<Channel> = playing.flat_map(|clip| clip.channels.clone()).collect();
        let moves = moving(&nodes, &channels);
        let is_weighed = |node| {
            channels
                .iter()
                .any(|one| one.node == node && one.course.is_of_weights())
        };
        let bends = |deform: &Deform| {
            let mut joints = deform.joints.iter();
            joints.any(|(joint, _)| joint.is_some_and(|joint| moves[joint]))
                || deform.weighed_by.is_some_and(is_weighed)
        };
        let parts = parts.into_iter();
        let parts = parts.map(|part| (bends(&part.deform), part));
        let parts: Vec<(bool, Part)> = parts
            .filter(|(bends, part)| *bends || part.node.is_some_and(|node| moves[node]))
            .collect();
        let first = self.motion.add(nodes, clips);
        if parts.is_empty() {
            return self.start();
        }
        let mut maps = Vec::new();
        self.motion.place_nodes(0.0, &mut maps);
        let ranges: Vec<Range<usize>> = parts
            .iter()
            .map(|(_, part)| part.vertices.clone())
            .collect();
        let mut pieces = cut(&self.meshes[mesh], &ranges).into_iter();
        let still = pieces.next().filter(|still| !still.triangles.is_empty());
        let mut is_free = still.is_none();
        if let Some(still) = still {
            self.meshes[mesh] = still;
        }
        let copies = self.copies(mesh);
        for ((bends, part), mut piece) in parts.into_iter().zip(pieces) {
            if piece.triangles.is_empty() {
                continue;
            }
            if part.is_mirrored {
                piece
                    .triangles
                    .iter_mut()
                    .for_each(|corners| corners.swap(1, 2));
            }
            let Part {
                node, mut deform, ..
            } = part;
            for (joint, _) in &mut deform.joints {
                *joint = joint.map(|joint| joint + first);
            }
            deform.weighed_by = deform.weighed_by.map(|node| node + first);
            let mut rest = Deformed::default();
            deform.apply(&maps, &deform.weights, &mut rest);
            (piece.positions, piece.normals) = (rest.positions, rest.normals);
            let own = std::mem::take(&mut is_free);
            let number = if own { mesh } else { self.meshes.len() };
            if own {
                self.meshes[mesh] = piece;
            } else {
                self.meshes.push(piece);
            }
            for follower in &copies {
                let mut follower = Follower {
                    node: node.map(|node| node + first),
                    ..follower.clone()
                };
                if own {
                    let object = follower.object;
                    self.motion.followers.retain(|one| one.object != object);
                } else {
                    let object = Object {
                        shape: Shape::Mesh(number),
                        ..self.objects[follower.object].clone()
                    };
                    follower.object = self.objects.len();
                    self.objects.push(object);
                }
                if follower.node.or(follower.mover).is_some() {
                    self.motion.followers.push(follower);
                }
            }
            if bends {
                self.motion.deforms.push((number, deform));
            }
        }
        self.start();
    }

    /// Returns the objects of a mesh, with what moves them and where they stand.
    fn copies(&self, mesh: usize) -> Vec<Follower> {
        let objects = self.objects.iter().enumerate();
        let objects = objects.filter(|(_, object)| object.shape == Shape::Mesh(mesh));
        let copies = objects.map(|(number, object)| {
            let mut known = self.motion.followers.iter();
            let known = known.find(|one| one.object == number).cloned();
            known.unwrap_or(Follower {
                object: number,
                mover: None,
                place: object.world_from_object,
                node: None,
            })
        });
        copies.collect()
    }
}

/// Cuts a mesh, no triangle of which is in several parts, into what is in no part, and each part.
fn cut(mesh: &TriangleMesh, parts: &[Range<usize>]) -> Vec<TriangleMesh> {
    fn copy<T: Copy>(from: &[T], number: usize, to: &mut Vec<T>) {
        to.extend(from.get(number));
    }
    let count = mesh.positions.len();
    let mut owners = vec![0; count];
    for (number, part) in (1..).zip(parts) {
        owners[part.clone()].fill(number);
    }
    let mut pieces = vec![TriangleMesh::default(); 1 + parts.len()];
    let mut numbers = Vec::with_capacity(count);
    for (vertex, &owner) in owners.iter().enumerate() {
        let piece: &mut TriangleMesh = &mut pieces[owner];
        numbers.push(piece.positions.len() as u32);
        copy(&mesh.positions, vertex, &mut piece.positions);
        copy(&mesh.normals, vertex, &mut piece.normals);
        copy(&mesh.coordinates, vertex, &mut piece.coordinates);
        copy(
            &mesh.second_coordinates,
            vertex,
            &mut piece.second_coordinates,
        );
        copy(&mesh.colours, vertex, &mut piece.colours);
        if owner == 0 {
            // Those of parts are not in their frames: baking makes them.
            copy(&mesh.tangents, vertex, &mut piece.tangents);
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let piece = &mut pieces[owners[corners[0] as usize]];
        piece
            .triangles
            .push(corners.map(|corner| numbers[corner as usize]));
        copy(
            &mesh.triangle_materials,
            triangle,
            &mut piece.triangle_materials,
        );
    }
    for piece in &mut pieces {
        let mut used = BTreeMap::new();
        for material in &mut piece.triangle_materials {
            let next = used.len() as u32;
            let number = *used.entry(*material).or_insert(next);
            if number == next {
                piece
                    .materials
                    .push(mesh.materials[*material as usize].clone());
            }
            *material = number;
        }
    }
    pieces
}
