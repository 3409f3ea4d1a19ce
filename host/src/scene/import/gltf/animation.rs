//! Animations of glTF files, and the parts of the mesh that they move.

use super::surface::{Bound, Surface};
use super::{Importer, Placed};
use crate::scene::import::ImportError;
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::{
    Channel, Clip, Course, Deform, Delta, Interpolation, Local, Part, Property, Rig, Track, moving,
};
use glam::{DAffine3, DQuat, DVec3, DVec4, Mat4, Vec3};
use gltf::animation::Property as Path;
use gltf::scene::Transform;
use gltf::{Document, Node, animation};

/// What the animations of a file move.
#[derive(Default)]
pub(super) struct Movement {
    pub(super) rig: Rig,
    /// The rig's nodes, by the document's numbers.
    nodes: Vec<Option<usize>>,
    /// Whether nodes of the rig move, and whether clips change the weights of their morph targets.
    moves: Vec<bool>,
    is_weighed: Vec<bool>,
}

impl Movement {
    /// Reads all animations.
    pub(super) fn read(
        importer: &mut Importer<'_>,
        document: &Document,
        placed: &[Placed<'_>],
    ) -> Result<Self, ImportError> {
        if document.animations().len() == 0 {
            return Ok(Self::default());
        }
        let mut nodes = vec![None; document.nodes().len()];
        for (number, Placed { node, .. }) in placed.iter().enumerate() {
            nodes[node.index()] = Some(number);
        }
        let mut rig = Rig {
            nodes: placed.iter().map(Placed::rest).collect(),
            ..Rig::default()
        };
        let mut is_weighed = vec![false; placed.len()];
        for animation in document.animations() {
            let mut clip = Clip {
                name: name(&animation),
                plays: rig.clips.is_empty(),
                ..Clip::default()
            };
            for channel in animation.channels() {
                let node = channel.target().node();
                let Some(number) = nodes[node.index()] else {
                    let kind = "animation channel{s} of nodes outside the scene";
                    importer.unused.add(kind, 1);
                    continue;
                };
                let Some(track) = track(importer, &animation, &channel, &rig.nodes[number].rest)?
                else {
                    continue;
                };
                let is_of_weights = matches!(track.property(), Property::Weights(_));
                let one = Clip {
                    channels: vec![Channel {
                        node: number,
                        course: Course::Track(track),
                    }],
                    ..Clip::default()
                };
                if clip.vies_with(&one) {
                    let kind = "animation channel{s} of a property that another one moves";
                    importer.unused.add(kind, 1);
                    continue;
                }
                is_weighed[number] |= is_of_weights;
                clip.channels.extend(one.channels);
            }
            if clip.channels.is_empty() {
                importer.unused.add("animation{s} that can move nothing", 1);
                continue;
            }
            let bent = moving(&rig.nodes, &clip.channels);
            let moves = |joint: Node<'_>| nodes[joint.index()].is_some_and(|joint| bent[joint]);
            let skins = document.skins();
            clip.skins = skins.filter(|skin| skin.joints().any(moves)).count();
            rig.clips.push(clip);
        }
        let channels = rig.clips.iter().flat_map(|clip| &clip.channels);
        let moves = moving(&rig.nodes, channels);
        Ok(Self {
            rig,
            nodes,
            moves,
            is_weighed,
        })
    }

    /// Returns whether a node moves, and whether its weights change.
    pub(super) fn of(&self, node: &Node<'_>) -> [bool; 2] {
        let number = self.nodes.get(node.index()).copied().flatten();
        number.map_or([false; 2], |n| [self.moves[n], self.is_weighed[n]])
    }

    /// Returns a part without vertices for the mesh of a node that stands at `place`, if an
    /// animation moves it.
    pub(super) fn part(
        &self,
        node: &Node<'_>,
        place: Mat4,
        skin: Option<&[Bound]>,
        weights: &[f32],
    ) -> Option<Part> {
        let number = self.nodes.get(node.index()).copied().flatten()?;
        let [moves, is_weighed] = self.of(node);
        let joints = skin.unwrap_or_default().iter();
        let joints = joints.map(|bound| (self.nodes[bound.node], bound.joint_from_mesh));
        let joints: Vec<(Option<usize>, Mat4)> = joints.collect();
        let bends = joints
            .iter()
            .any(|(joint, _)| joint.is_some_and(|j| self.moves[j]));
        let follows = skin.is_none();
        (is_weighed || bends || (follows && moves)).then(|| Part {
            vertices: 0..0,
            node: follows.then_some(number),
            is_mirrored: follows && place.determinant() < 0.0,
            deform: Deform {
                joints,
                weights: weights.to_vec(),
                weighed_by: is_weighed.then_some(number),
                ..Deform::default()
            },
        })
    }
}

fn name(animation: &gltf::Animation<'_>) -> String {
    let numbered = || format!("animation {}", animation.index() + 1);
    animation.name().map_or_else(numbered, str::to_owned)
}

impl Placed<'_> {
    fn rest(&self) -> crate::scene::motion::Node {
        let rest = match self.node.transform() {
            Transform::Matrix { matrix } => {
                let matrix = Mat4::from_cols_array_2d(&matrix).as_dmat4();
                Local::Fixed(DAffine3::from_mat4(matrix))
            }
            Transform::Decomposed {
                translation,
                rotation,
                scale,
            } => Local::Free {
                position: DVec3::from(translation.map(f64::from)),
                rotation: DQuat::from_vec4(
                    DVec4::from(rotation.map(f64::from)).normalize_or(DVec4::W),
                ),
                scale: DVec3::from(scale.map(f64::from)),
            },
        };
        crate::scene::motion::Node {
            parent: self.parent,
            rest,
        }
    }
}

/// Reads the keys of a channel; none if its node cannot be moved so.
fn track(
    importer: &mut Importer<'_>,
    animation: &gltf::Animation<'_>,
    channel: &animation::Channel<'_>,
    rest: &Local,
) -> Result<Option<Track>, ImportError> {
    let target = channel.target();
    let property = match target.property() {
        Path::Translation => Property::Position,
        Path::Rotation => Property::Rotation,
        Path::Scale => Property::Scale,
        Path::MorphTargetWeights => Property::Weights(targets(&target.node())),
    };
    let is_fixed = matches!(rest, Local::Fixed(_)) && !matches!(property, Property::Weights(_));
    if is_fixed || property == Property::Weights(0) {
        let kind = "animation channel{s} of nodes that have a matrix or no morph targets";
        importer.unused.add(kind, 1);
        return Ok(None);
    }
    let sampler = channel.sampler();
    let (times, values) = (sampler.input(), sampler.output());
    let buffers = &importer.buffers;
    let mut seconds = Vec::new();
    // Without items an accessor is no rows of its view.
    if times.count() > 0 {
        seconds = buffers.floats::<1>(&times)?.into_flattened();
    }
    let values = match property {
        _ if values.count() == 0 => Vec::new(),
        Property::Rotation => buffers.floats::<4>(&values)?.into_flattened(),
        Property::Weights(_) => buffers.floats::<1>(&values)?.into_flattened(),
        _ => buffers.floats::<3>(&values)?.into_flattened(),
    };
    let interpolation = match sampler.interpolation() {
        animation::Interpolation::Step => Interpolation::Step,
        animation::Interpolation::Linear => Interpolation::Linear,
        animation::Interpolation::CubicSpline => Interpolation::Cubic,
    };
    let [times, values] = [seconds, values].map(|all| all.into_iter().map(f64::from).collect());
    let track = Track::new(property, interpolation, times, values);
    track.map(Some).map_err(|error| {
        let (name, number) = (name(animation), channel.index());
        importer.fault(format!("animation \"{name}\": channel {number} {error}"))
    })
}

/// Returns the number of morph targets of a node's mesh.
pub(super) fn targets(node: &Node<'_>) -> usize {
    let primitives = node.mesh().into_iter().flat_map(|mesh| mesh.primitives());
    let counts = primitives.map(|primitive| primitive.morph_targets().count());
    counts.max().unwrap_or(0)
}

/// Adds a surface to a part, moved by `own` within the node's frame. Its triangles are inside out
/// for `is_mirrored`.
pub(super) fn extend(part: &mut Part, surface: &Surface, own: Mat4, is_mirrored: bool) {
    let Part { node, deform, .. } = part;
    let first = deform.positions.len();
    let is_skinned = node.is_none();
    let (positions, normals) = surface.unmorphed();
    deform.positions.extend(positions.iter().map(|position| {
        let position = own.transform_point3(Vec3::from_array(*position)).to_array();
        let is_place = TriangleMesh::check_position(position).is_ok();
        if is_place { position } else { [0.0; 3] }
    }));
    let end = deform.positions.len();
    if normals.is_empty() {
        deform.flat.push((first..end, is_mirrored));
    }
    let turn = crate::scene::motion::normal_matrix(own);
    let normals = normals
        .iter()
        .map(|normal| (turn * Vec3::from_array(*normal)).to_array());
    deform.normals.extend(normals);
    deform.normals.resize(end, [0.0; 3]);
    if deform.targets.len() < surface.targets.len() {
        deform.targets.resize(surface.targets.len(), Vec::new());
    }
    for (all, target) in deform.targets.iter_mut().zip(&surface.targets) {
        all.extend(target.iter().map(|delta| Delta {
            vertex: first as u32 + delta.vertex,
            position: own.transform_vector3(delta.position.into()).to_array(),
            normal: (turn * Vec3::from_array(delta.normal)).to_array(),
        }));
    }
    if !is_skinned {
        return;
    }
    for vertex in 0..positions.len() {
        let before = deform.influences.len();
        let joints = deform.joints.len();
        let influences = surface.influences(vertex);
        (deform.influences).extend(influences.filter(|(joint, _)| (*joint as usize) < joints));
        let own = &mut deform.influences[before..];
        let sum: f32 = own.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in own {
            *weight /= sum;
        }
        if deform.influences.len() == before {
            deform.influences.push((0, 1.0));
        }
        deform.ends.push(deform.influences.len() as u32);
    }
}

#[cfg(test)]
mod tests;
