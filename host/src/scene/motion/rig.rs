//! What of a model's file moves, before and as it is taken apart into a scene.

use super::{Clip, Deform, Follower, Node, Scene};
use crate::scene::Shape;
use crate::scene::mesh::TriangleMesh;
use glam::DAffine3;
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
