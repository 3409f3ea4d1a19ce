//! Surfaces of a glTF file, and their poses.

use super::Importer;
use crate::scene::import::ImportError;
use crate::scene::motion::{Delta, morph, normal_matrix};
use glam::{Mat4, Vec3};
use gltf::accessor::Dimensions;
use gltf::material::AlphaMode;
use gltf::mesh::Mode;
use gltf::{Accessor, Node, Primitive, Semantic};
use std::collections::HashMap;

/// A primitive in its mesh's frame. Without normals each triangle has vertices of its own.
#[derive(Default)]
pub(super) struct Surface {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// First and second: v up.
    pub(super) coordinates: [Vec<[f32; 2]>; 2],
    pub(super) colours: Vec<[f32; 3]>,
    /// For normal maps, where there are normals.
    pub(super) tangents: Vec<[f32; 4]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material: Option<usize>,
    /// Sets of four joints and their weights for each vertex.
    pub(super) joints: Vec<Vec<([u32; 4], [f32; 4])>>,
    /// Its morph targets, where animations need them.
    pub(super) targets: Vec<Vec<Delta>>,
    /// Positions and normals without morph targets, if it has any.
    unmorphed: Option<[Vec<[f32; 3]>; 2]>,
}

impl Surface {
    /// Most morph targets that are read.
    const MOST_TARGETS: usize = 256;

    /// Reads a primitive with the weights of its morph targets; none without triangles. It keeps
    /// the targets if `is_weighed`.
    pub(super) fn read(
        importer: &mut Importer<'_>,
        primitive: &Primitive<'_>,
        weights: &[f32],
        is_weighed: bool,
    ) -> Result<Option<Self>, ImportError> {
        if matches!(
            primitive.mode(),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip
        ) {
            importer.unused.add("surface{s} of points or lines", 1);
            return Ok(None);
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            importer.unused.add("surface{s} without positions", 1);
            return Ok(None);
        };
        let material = primitive.material();
        if is_cut_away(&material) {
            return Ok(None);
        }
        let buffers = &importer.buffers;
        let count = accessor.count();
        let others = primitive.attributes().filter(|(_, of)| of.count() != count);
        let others = others.count() as u64;
        let kind = "attribute{s} of another number of vertices";
        importer.unused.add(kind, others);
        let with_all = |semantic| {
            let accessor: Option<Accessor<'_>> = primitive.get(&semantic);
            accessor.filter(|accessor| accessor.count() == count)
        };
        let mut surface = Self {
            positions: buffers.floats(&accessor)?,
            material: primitive.material().index(),
            ..Self::default()
        };
        let (unused, path) = (&mut importer.unused, importer.path);
        let mut unread = |error: ImportError| unused.add(error.without(path), 1);
        if let Some(accessor) = with_all(Semantic::Normals) {
            let read = buffers.floats(&accessor).map_err(&mut unread);
            surface.normals = read.unwrap_or_default();
        }
        if let Some(accessor) = with_all(Semantic::Tangents)
            && material.normal_texture().is_some()
        {
            let read = buffers.floats(&accessor).map_err(&mut unread);
            surface.tangents = read.unwrap_or_default();
        }
        for (set, places) in (0..).zip(&mut surface.coordinates) {
            if let Some(accessor) = with_all(Semantic::TexCoords(set)) {
                let read = buffers.floats::<2>(&accessor).map_err(&mut unread);
                let read = read.into_iter().flatten();
                // glTF counts v from the top.
                *places = read.map(|[u, v]| [u, 1.0 - v]).collect();
            }
        }
        if let Some(accessor) = with_all(Semantic::Colors(0)) {
            surface.colours = if accessor.dimensions() == Dimensions::Vec4 {
                let read = buffers.floats::<4>(&accessor).map_err(&mut unread);
                let colours = read.unwrap_or_default();
                let has_alpha = primitive.material().alpha_mode() != AlphaMode::Opaque
                    && colours.iter().any(|colour| colour[3] < 1.0);
                let kind = "surface{s} with alpha of vertices";
                importer.unused.add(kind, u64::from(has_alpha));
                colours.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
            } else {
                let read = buffers.floats(&accessor).map_err(&mut unread);
                read.unwrap_or_default()
            };
        }
        for set in 0.. {
            let (Some(joints), Some(weights)) = (
                with_all(Semantic::Joints(set)),
                with_all(Semantic::Weights(set)),
            ) else {
                break;
            };
            let joints = buffers.whole::<4>(&joints)?;
            let weights = buffers.floats::<4>(&weights)?;
            surface
                .joints
                .push(joints.into_iter().zip(weights).collect());
        }
        let odd = (0..count).filter(|&vertex| {
            let weights = surface.joints.iter().flat_map(|set| set[vertex].1);
            !surface.joints.is_empty() && (weights.sum::<f32>() - 1.0).abs() > 0.01
        });
        let odd = odd.count() as u64;
        importer
            .unused
            .add("set{s} of joint weights that do not add up to 1", odd);
        surface.read_targets(importer, primitive, weights, is_weighed)?;
        surface.read_triangles(importer, primitive)?;
        if surface.normals.is_empty() {
            surface.separate();
        }
        surface.morph(weights);
        Ok(Some(surface))
    }

    /// Moves vertices as morph targets say.
    fn morph(&mut self, weights: &[f32]) {
        if self.targets.is_empty() {
            return;
        }
        self.unmorphed = Some([self.positions.clone(), self.normals.clone()]);
        morph(
            &self.targets,
            weights,
            &mut self.positions,
            &mut self.normals,
        );
        if weights.iter().any(|weight| *weight != 0.0) {
            // Baking makes those of the shape that it has now.
            self.tangents.clear();
        }
    }

    /// Returns positions and normals without morph targets.
    pub(super) fn unmorphed(&self) -> (&[[f32; 3]], &[[f32; 3]]) {
        let own = || (&*self.positions, &*self.normals);
        let kept = self.unmorphed.as_ref();
        kept.map_or_else(own, |[positions, normals]| (positions, normals))
    }

    /// Returns the joints of a vertex with their weights above 0.
    pub(super) fn influences(&self, vertex: usize) -> impl Iterator<Item = (u32, f32)> {
        let sets = self.joints.iter().map(move |set| set[vertex]);
        let all = sets.flat_map(|(joints, weights)| joints.into_iter().zip(weights));
        all.filter(|(_, weight)| *weight > 0.0)
    }

    /// Returns how many vertices name joints that a skin of `count` does not have.
    pub(super) fn lost(&self, count: usize) -> usize {
        let vertices = 0..self.joints.first().map_or(0, Vec::len);
        let is_lost = |(joint, _): (u32, f32)| joint as usize >= count;
        let lost = vertices.filter(|vertex| self.influences(*vertex).any(is_lost));
        lost.count()
    }

    fn read_targets(
        &mut self,
        importer: &mut Importer<'_>,
        primitive: &Primitive<'_>,
        weights: &[f32],
        is_weighed: bool,
    ) -> Result<(), ImportError> {
        let count = self.positions.len();
        for (number, target) in primitive.morph_targets().enumerate() {
            let mut deltas = Vec::new();
            let is_used = is_weighed || weights.get(number).is_some_and(|weight| *weight != 0.0);
            if is_used && number >= Self::MOST_TARGETS {
                let kind = format!("morph target{{s}} beyond the first {}", Self::MOST_TARGETS);
                importer.unused.add(kind, 1);
            } else if is_used {
                let all = [target.positions(), target.normals()];
                let others = all.iter().flatten().filter(|of| of.count() != count);
                let others = others.count() as u64;
                let kind = "morph target attribute{s} of another number of vertices";
                importer.unused.add(kind, others);
                let read = |accessor: Option<Accessor<'_>>| {
                    let accessor = accessor.filter(|accessor| accessor.count() == count);
                    let read = accessor.map(|accessor| importer.buffers.floats::<3>(&accessor));
                    Ok(read.transpose()?.unwrap_or_default())
                };
                let (positions, normals) = (read(target.positions())?, read(target.normals())?);
                deltas.extend((0..count).filter_map(|vertex| {
                    let of = |all: &[[f32; 3]]| all.get(vertex).copied().unwrap_or_default();
                    let (position, normal) = (of(&positions), of(&normals));
                    ([position, normal] != [[0.0; 3]; 2]).then_some(Delta {
                        vertex: vertex as u32,
                        position,
                        normal,
                    })
                }));
            }
            self.targets.push(deltas);
        }
        Ok(())
    }

    fn read_triangles(
        &mut self,
        importer: &mut Importer<'_>,
        primitive: &Primitive<'_>,
    ) -> Result<(), ImportError> {
        let count = self.positions.len();
        let indices: Vec<u32> = match primitive.indices() {
            None => (0..count as u32).collect(),
            Some(accessor) => importer.buffers.whole::<1>(&accessor)?.into_flattened(),
        };
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= count) {
            return Err(importer.fault(format!(
                "a primitive names vertex {index} (counted from 0), but has {count}"
            )));
        }
        self.triangles = match primitive.mode() {
            Mode::TriangleStrip => {
                let threes = indices.windows(3).zip(0..);
                let turned = threes.map(|(three, number)| match number % 2 {
                    0 => [three[0], three[1], three[2]],
                    _ => [three[1], three[0], three[2]],
                });
                turned.collect()
            }
            Mode::TriangleFan => {
                let edges = indices.get(1..).unwrap_or_default().windows(2);
                edges.map(|edge| [indices[0], edge[0], edge[1]]).collect()
            }
            _ => {
                let (corners, rest) = indices.as_chunks::<3>();
                importer.unused.add(
                    "triangle{s} without three corners",
                    u64::from(!rest.is_empty()),
                );
                corners.to_vec()
            }
        };
        let before = self.triangles.len();
        let has_area = |&[a, b, c]: &[u32; 3]| a != b && b != c && a != c;
        self.triangles.retain(has_area);
        // Strips are joined by such triangles.
        if primitive.mode() != Mode::TriangleStrip {
            let without = before - self.triangles.len();
            importer.unused.add("face{s} without area", without as u64);
        }
        Ok(())
    }

    /// Gives each triangle vertices of its own.
    fn separate(&mut self) {
        fn of<T: Copy>(all: &[T], corners: &[u32]) -> Vec<T> {
            let known = corners.iter().filter(|_| !all.is_empty());
            known.map(|&corner| all[corner as usize]).collect()
        }
        let corners = self.triangles.as_flattened();
        self.positions = of(&self.positions, corners);
        self.coordinates = [0, 1].map(|set| of(&self.coordinates[set], corners));
        self.colours = of(&self.colours, corners);
        self.tangents.clear();
        self.joints = self.joints.iter().map(|set| of(set, corners)).collect();
        for target in &mut self.targets {
            let known: HashMap<u32, Delta> = target.iter().map(|of| (of.vertex, *of)).collect();
            let moved = (0..).zip(corners).filter_map(|(vertex, corner)| {
                let delta = *known.get(corner)?;
                Some(Delta { vertex, ..delta })
            });
            *target = moved.collect();
        }
        let count = self.triangles.len() as u32;
        self.triangles = (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    }
}

/// Returns whether a material's mask hides all surfaces in it.
pub(super) fn is_cut_away(material: &gltf::Material<'_>) -> bool {
    let [.., alpha] = material.pbr_metallic_roughness().base_color_factor();
    let cutoff = material.alpha_cutoff().unwrap_or(0.5);
    material.alpha_mode() == AlphaMode::Mask && alpha < cutoff
}

/// A joint of a skin.
pub(super) struct Bound {
    /// The document's number of its node.
    pub(super) node: usize,
    pub(super) joint_from_mesh: Mat4,
}

impl Bound {
    pub(super) fn of_skin(
        importer: &mut Importer<'_>,
        skin: &gltf::Skin<'_>,
    ) -> Result<Vec<Self>, ImportError> {
        let inverse = skin.inverse_bind_matrices();
        let inverse = inverse.map(|accessor| importer.buffers.floats::<16>(&accessor));
        let inverse = inverse.transpose()?;
        let read = inverse.as_ref().map_or(usize::MAX, Vec::len);
        let without = skin.joints().count().saturating_sub(read) as u64;
        let kind = "joint{s} without an inverse bind matrix";
        importer.unused.add(kind, without);
        let inverse = inverse.unwrap_or_default();
        let joints = skin.joints().enumerate();
        let bound = joints.map(|(number, joint): (_, Node<'_>)| {
            let inverse = inverse.get(number).map(Mat4::from_cols_array);
            Self {
                node: joint.index(),
                joint_from_mesh: inverse.unwrap_or(Mat4::IDENTITY),
            }
        });
        Ok(bound.collect())
    }
}

/// Where a surface stands in the world.
pub(super) enum Pose {
    Rigid(Mat4),
    /// From the mesh's frame to the world, for each joint of a skin.
    Skinned(Vec<Mat4>),
}

impl Pose {
    /// Returns the pose of a skin whose joints stand at `places`, by the numbers of their nodes.
    pub(super) fn of_skin(skin: &[Bound], places: &[Option<Mat4>]) -> Self {
        let joints = skin.iter().map(|bound| {
            let place = places[bound.node].unwrap_or(Mat4::IDENTITY);
            place * bound.joint_from_mesh
        });
        Self::Skinned(joints.collect())
    }

    /// Returns the map of a vertex: of a skin the mean of its joints' by their weights.
    fn map(&self, surface: &Surface, vertex: usize) -> Mat4 {
        let joints = match self {
            Self::Rigid(map) => return *map,
            Self::Skinned(joints) => joints,
        };
        let (mut sum, mut all) = (Mat4::ZERO, 0.0);
        for (number, weight) in surface.influences(vertex) {
            if let Some(joint) = joints.get(number as usize) {
                sum += *joint * weight;
                all += weight;
            }
        }
        if all > 0.0 {
            sum * (1.0 / all)
        } else {
            joints.first().copied().unwrap_or(Mat4::IDENTITY)
        }
    }

    pub(super) fn positions(&self, surface: &Surface) -> impl Iterator<Item = [f32; 3]> {
        let all = surface.positions.iter().enumerate();
        all.map(|(vertex, position)| {
            let map = self.map(surface, vertex);
            map.transform_point3(Vec3::from_array(*position)).to_array()
        })
    }

    pub(super) fn normals(&self, surface: &Surface) -> impl Iterator<Item = [f32; 3]> {
        let all = surface.normals.iter().enumerate();
        all.map(|(vertex, normal)| {
            let map = normal_matrix(self.map(surface, vertex));
            (map * Vec3::from_array(*normal)).to_array()
        })
    }

    /// Returns tangents of unit length; all zero where they have no direction.
    pub(super) fn tangents(&self, surface: &Surface) -> impl Iterator<Item = [f32; 4]> {
        let all = surface.tangents.iter().enumerate();
        all.map(|(vertex, &[x, y, z, side])| {
            let map = self.map(surface, vertex);
            let tangent = map.transform_vector3(Vec3::new(x, y, z)).try_normalize();
            let is_turned = (map.determinant() < 0.0) != (side < 0.0);
            let side = if is_turned { -1.0 } else { 1.0 };
            tangent.map_or([0.0; 4], |tangent| tangent.extend(side).to_array())
        })
    }

    /// Returns whether it turns surfaces inside out.
    pub(super) fn is_mirrored(&self) -> bool {
        match self {
            Self::Rigid(map) => map.determinant() < 0.0,
            Self::Skinned(joints) => joints.first().is_some_and(|map| map.determinant() < 0.0),
        }
    }
}
