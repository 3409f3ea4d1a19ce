//! What of a scene moves, and where it is at a time.
//!
//! A [`Motion`] has nodes in trees, clips that move nodes, objects that follow nodes, and meshes
//! that joints or morph targets deform. Each clip starts at 0 s and begins anew when it is over;
//! before its first key it is as at that key. [`Scene::pose`] has what is elsewhere at a time than
//! the scene says, and [`Scene::at`] the still scene of that time. A scene that moves stands as at
//! 0 s.

mod deform;
mod rig;
mod track;

pub use deform::{Deform, Deformed, Delta};
pub(super) use deform::{morph, normal_matrix};
pub(super) use rig::moving;
pub use rig::{Part, Playing, Rig};
pub use track::{Interpolation, Property, Track, TrackError};

use super::Scene;
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use std::mem::discriminant;

/// The least magnitude of a scale. A node of scale 0 is not seen, yet its map can be undone.
const LEAST_SCALE: f64 = 1.0e-6;

/// Where a node stands from its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Local {
    /// A map that nothing moves.
    Fixed(DAffine3),
    /// Scaled, then turned, then moved, while no clip says otherwise.
    Free {
        /// From the parent: metres, or units of the model.
        position: DVec3,
        /// Unit quaternion.
        rotation: DQuat,
        /// Factors along its own axes.
        scale: DVec3,
    },
}

impl Local {
    fn map(&self) -> DAffine3 {
        match *self {
            Self::Fixed(map) => map,
            Self::Free {
                position,
                rotation,
                scale,
            } => {
                let seen = |factor: f64| factor.abs().max(LEAST_SCALE).copysign(factor);
                let scale = DMat3::from_diagonal(DVec3::from_array(scale.to_array().map(seen)));
                DAffine3 {
                    matrix3: DMat3::from_quat(rotation) * scale,
                    translation: position,
                }
            }
        }
    }
}

/// A node of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// The number of the node that it hangs on, which is below its own.
    pub parent: Option<usize>,
    /// Where it stands while no clip moves it.
    pub rest: Local,
}

/// How a channel's value changes in time.
#[derive(Debug, Clone, PartialEq)]
pub enum Course {
    /// By keys.
    Track(Track),
    /// Further and further round, beside what else turns the node.
    Spin {
        /// In the node's own frame, of unit length.
        axis: DVec3,
        /// Seconds of one turn, right-handed about the axis; the other way below 0. Not 0.
        seconds: f64,
    },
}

/// What a clip does to one node.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// The number of the node.
    pub node: usize,
    /// How it is moved.
    pub course: Course,
}

/// A named animation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Clip {
    /// Its name in the file, or of the object that it moves.
    pub name: String,
    /// What it moves.
    pub channels: Vec<Channel>,
    /// How many skins it bends.
    pub skins: usize,
    /// Whether it plays.
    pub plays: bool,
}

impl Clip {
    /// Returns after how many seconds it begins anew.
    pub fn seconds(&self) -> f64 {
        let ends = self.channels.iter().map(|channel| match &channel.course {
            Course::Track(track) => track.duration(),
            Course::Spin { seconds, .. } => seconds.abs(),
        });
        ends.fold(0.0, f64::max)
    }

    /// Returns whether both change one property of one node by keys.
    pub(super) fn vies_with(&self, other: &Self) -> bool {
        let keys = |channel: &Channel| match &channel.course {
            Course::Track(track) => Some((channel.node, discriminant(&track.property()))),
            Course::Spin { .. } => None,
        };
        let mut own = self.channels.iter().filter_map(keys);
        own.any(|one| other.channels.iter().filter_map(keys).any(|two| two == one))
    }

    /// Returns how many nodes it moves, and of how many it changes the weights of morph targets.
    pub fn counts(&self) -> [usize; 2] {
        let mut nodes = [Vec::new(), Vec::new()];
        for Channel { node, course } in &self.channels {
            nodes[usize::from(course.is_of_weights())].push(*node);
        }
        nodes.map(|mut nodes| {
            nodes.sort_unstable();
            nodes.dedup();
            nodes.len()
        })
    }
}

impl Course {
    const fn is_of_weights(&self) -> bool {
        matches!(self, Self::Track(track) if matches!(track.property(), Property::Weights(_)))
    }
}

/// An object that moves: its map to the world is the mover's, then the place, then the node's.
#[derive(Debug, Clone, PartialEq)]
struct Follower {
    object: usize,
    mover: Option<usize>,
    place: DAffine3,
    node: Option<usize>,
}

/// What of a scene moves; nothing by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    nodes: Vec<Node>,
    clips: Vec<Clip>,
    followers: Vec<Follower>,
    /// Meshes by their numbers.
    deforms: Vec<(usize, Deform)>,
}

impl Motion {
    /// Returns whether nothing moves.
    pub const fn is_empty(&self) -> bool {
        self.followers.is_empty() && self.deforms.is_empty()
    }

    /// Returns the animations of the scene, also those that do not play.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

    /// Returns the numbers of the meshes that deform, in the order of a pose.
    pub fn deforming(&self) -> impl Iterator<Item = usize> {
        self.deforms.iter().map(|(mesh, _)| *mesh)
    }

    fn playing(&self) -> impl Iterator<Item = &Clip> {
        self.clips.iter().filter(|clip| clip.plays)
    }

    /// Adds a tree's nodes and clips; returns the number of its first node.
    fn add(&mut self, nodes: Vec<Node>, clips: Vec<Clip>) -> usize {
        let first = self.nodes.len();
        self.nodes.extend(nodes.into_iter().map(|node| Node {
            parent: node.parent.map(|parent| parent + first),
            ..node
        }));
        for mut clip in clips {
            for channel in &mut clip.channels {
                channel.node += first;
            }
            self.clips.push(clip);
        }
        first
    }

    /// Lets a clip of one node move an object, which stands at `rest` without it. `fit` maps the
    /// object into the node's frame.
    pub(super) fn move_object(
        &mut self,
        object: usize,
        rest: Local,
        fit: DAffine3,
        mut clip: Clip,
    ) {
        let known = self.followers.iter().find(|one| one.object == object);
        let mover = known.and_then(|known| known.mover).unwrap_or_else(|| {
            self.nodes.push(Node { parent: None, rest });
            let mover = Some(self.nodes.len() - 1);
            self.followers.push(Follower {
                object,
                mover,
                place: fit,
                node: None,
            });
            self.nodes.len() - 1
        });
        for channel in &mut clip.channels {
            channel.node = mover;
        }
        self.clips.push(clip);
    }

    /// Writes where all nodes stand in their trees' frames at a time.
    fn place_nodes(&self, time: f64, maps: &mut Vec<DAffine3>) {
        let mut locals: Vec<Local> = self.nodes.iter().map(|node| node.rest).collect();
        // Spins turn further what keys have turned.
        for spins in [false, true] {
            for clip in self.playing() {
                let now = looped(time, clip.seconds());
                let channels = clip.channels.iter();
                for channel in channels.filter(|one| one.course.is_spin() == spins) {
                    channel.course.apply(now, &mut locals[channel.node]);
                }
            }
        }
        maps.clear();
        for (node, local) in self.nodes.iter().zip(&locals) {
            let parent = node
                .parent
                .map_or(DAffine3::IDENTITY, |parent| maps[parent]);
            maps.push(parent * local.map());
        }
    }

    /// Writes the weights of a node's morph targets at a time, where a clip changes them.
    fn weigh(&self, node: usize, time: f64, weights: &mut [f64]) {
        for clip in self.playing() {
            let now = looped(time, clip.seconds());
            for channel in clip.channels.iter().filter(|one| one.node == node) {
                if let Course::Track(track) = &channel.course
                    && track.property() == Property::Weights(weights.len())
                {
                    track.sample(now, weights);
                }
            }
        }
    }
}

/// Returns the time within a clip that begins anew after `seconds`.
fn looped(time: f64, seconds: f64) -> f64 {
    if seconds > 0.0 {
        time.rem_euclid(seconds)
    } else {
        0.0
    }
}

impl Course {
    const fn is_spin(&self) -> bool {
        matches!(self, Self::Spin { .. })
    }

    /// Changes where a node stands, unless that is fixed.
    fn apply(&self, time: f64, local: &mut Local) {
        let Local::Free {
            position,
            rotation,
            scale,
        } = local
        else {
            return;
        };
        let track = match self {
            Self::Spin { axis, seconds } => {
                let angle = std::f64::consts::TAU * (time / seconds);
                *rotation *= DQuat::from_axis_angle(*axis, angle);
                return;
            }
            Self::Track(track) => track,
        };
        if self.is_of_weights() {
            return;
        }
        let mut value = [0.0; 4];
        let width = track.property().width();
        track.sample(time, &mut value[..width]);
        let three = DVec3::from_slice(&value);
        match track.property() {
            Property::Position => *position = three,
            Property::Scale => *scale = three,
            Property::Rotation => *rotation = DQuat::from_array(value),
            Property::Angles => *rotation = turn(three.to_array()),
            Property::Weights(_) => {}
        }
    }
}

/// Returns the turn by yaw, pitch and roll in degrees.
pub(super) fn turn(degrees: [f64; 3]) -> DQuat {
    let [yaw, pitch, roll] = degrees.map(f64::to_radians);
    DQuat::from_euler(EulerRot::YXZ, yaw, pitch, roll)
}

/// What moves, at one time. The objects and the meshes are the same at all times, in the same order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pose {
    /// Objects that move, by their numbers, with their `world_from_object`.
    pub objects: Vec<(usize, DAffine3)>,
    /// Meshes that deform, by their numbers.
    pub meshes: Vec<(usize, Deformed)>,
    nodes: Vec<DAffine3>,
}

impl Scene {
    /// Returns after how many seconds the longest animation begins anew; 0 if nothing moves.
    pub fn duration(&self) -> f64 {
        let seconds = self.motion.playing().map(Clip::seconds);
        seconds.fold(0.0, f64::max)
    }

    /// Returns what moves, at a time in seconds.
    pub fn pose(&self, time: f64) -> Pose {
        let mut pose = Pose::default();
        self.pose_into(time, &mut pose);
        pose
    }

    /// Writes the same into a pose of this scene, whose memory is used again.
    pub fn pose_into(&self, time: f64, pose: &mut Pose) {
        let motion = &self.motion;
        motion.place_nodes(time, &mut pose.nodes);
        let maps = &pose.nodes;
        let map = |node: Option<usize>| node.map_or(DAffine3::IDENTITY, |node| maps[node]);
        pose.objects.clear();
        pose.objects.extend(motion.followers.iter().map(|one| {
            let placed = map(one.mover) * one.place * map(one.node);
            (one.object, placed)
        }));
        pose.meshes
            .resize_with(motion.deforms.len(), Default::default);
        for ((mesh, deform), (number, deformed)) in motion.deforms.iter().zip(&mut pose.meshes) {
            *number = *mesh;
            let weights = deform.weights.iter().map(|weight| f64::from(*weight));
            let mut weights: Vec<f64> = weights.collect();
            if let Some(node) = deform.weighed_by {
                motion.weigh(node, time, &mut weights);
            }
            let weights: Vec<f32> = weights.into_iter().map(|weight| weight as f32).collect();
            deform.apply(maps, &weights, deformed);
        }
    }

    /// Returns the scene as it stands at a time in seconds, in which nothing moves.
    #[must_use]
    pub fn at(&self, time: f64) -> Self {
        let mut still = self.clone();
        still.take(self.pose(time));
        still.motion = Motion::default();
        still
    }

    /// Lets nothing move: what moved stands where it does without animations.
    pub fn stop(&mut self) {
        for clip in &mut self.motion.clips {
            clip.plays = false;
        }
        self.start();
        self.motion.followers.clear();
        self.motion.deforms.clear();
    }

    /// Puts what moves where it is at 0 s.
    fn start(&mut self) {
        self.take(self.pose(0.0));
    }

    /// Puts what moves where a pose has it.
    fn take(&mut self, pose: Pose) {
        for (object, map) in pose.objects {
            self.objects[object].world_from_object = map;
        }
        for (mesh, deformed) in pose.meshes {
            let mesh = &mut self.meshes[mesh];
            mesh.positions = deformed.positions;
            mesh.normals = deformed.normals;
        }
    }
}

#[cfg(test)]
mod tests;
