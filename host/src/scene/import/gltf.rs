//! glTF 2.0, as JSON with external or embedded buffers and as GLB.

mod accessors;
mod animation;
mod compression;
mod description;
mod material;
mod surface;

use super::{
    Camera, ImportError, Model, Unused, bounded, claim, finished, flat_normal, syntax, unusable,
};
use crate::scene::Light;
use crate::scene::mesh::{MeshError, TriangleMesh};
use accessors::Buffers;
use animation::Movement;
use glam::{DMat3, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf::khr_lights_punctual::Kind;
use gltf::{Document, Node};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::f32::consts::FRAC_1_PI;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;
use surface::{Bound, Pose, Surface, is_cut_away};

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Model, ImportError> {
    let (json, blob) = split(path, bytes)?;
    let mut unused = Unused::default();
    let document = description::read(path, &json, &mut unused)?;
    let mut importer = Importer {
        path,
        buffers: Buffers::read(path, &document, blob)?,
        mesh: TriangleMesh::default(),
        lights: Vec::new(),
        cameras: Vec::new(),
        movement: Movement::default(),
        unused,
    };
    importer.scene(&document)?;
    if importer.mesh.triangles.is_empty() && document.materials().any(|of| is_cut_away(&of)) {
        return Err(importer.fault("the alphaCutoff of its materials hides all of it"));
    }
    importer.complete();
    importer.paint(&document);
    importer.count_unused(&document);
    let model = finished(path, importer.mesh, importer.unused)?;
    Ok(Model {
        lights: importer.lights,
        cameras: importer.cameras,
        rig: importer.movement.rig,
        ..model
    })
}

type Chunks<'a> = (Cow<'a, [u8]>, Option<Vec<u8>>);

fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Chunks<'a>, ImportError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    if bytes.get(4..8) == Some(&[1, 0, 0, 0]) {
        return Err(description::outdated(path, "1.0"));
    }
    // The parser subtracts the header's length unchecked.
    let claimed = bytes
        .get(8..)
        .and_then(|rest| rest.first_chunk())
        .map_or(0, |&length| u32::from_le_bytes(length));
    if claimed < 12 {
        return Err(syntax(path, "the GLB header is cut off"));
    }
    if u64::from(claimed) > bytes.len() as u64 {
        let what = "the GLB header's length";
        return Err(claim(path, what, claimed.into(), bytes.len()));
    }
    let glb = gltf::Glb::from_slice(bytes)
        .map_err(|error| syntax(path, format!("not a valid GLB file: {error}")))?;
    Ok((glb.json, glb.bin.map(Cow::into_owned)))
}

struct Importer<'a> {
    path: &'a Path,
    buffers: Buffers<'a>,
    mesh: TriangleMesh,
    lights: Vec<Light>,
    cameras: Vec<Camera>,
    movement: Movement,
    unused: Unused,
}

/// A node of the scene.
struct Placed<'d> {
    node: Node<'d>,
    /// The place of its parent among all.
    parent: Option<usize>,
    /// In the world.
    place: Mat4,
}

impl Importer<'_> {
    fn fault(&self, problem: impl AsRef<str>) -> ImportError {
        syntax(self.path, problem)
    }

    fn too_many(&self, count: usize) -> ImportError {
        unusable(self.path, MeshError::too_many(count))
    }

    /// Adds the surfaces of the default scene, or of the first.
    fn scene(&mut self, document: &Document) -> Result<(), ImportError> {
        let nodes = self.placed(document)?;
        self.movement = Movement::read(self, document, &nodes)?;
        let mut places = vec![None; document.nodes().len()];
        for Placed { node, place, .. } in &nodes {
            places[node.index()] = Some(*place);
        }
        // What a light or a mesh has that is not used, counts once for all of its nodes.
        let mut lights = BTreeSet::new();
        let mut read = vec![false; document.meshes().len()];
        for Placed { node, place, .. } in &nodes {
            let [moves, _] = self.movement.of(node);
            if let Some(light) = node.light() {
                let before = (!lights.insert(light.index())).then(|| self.unused.clone());
                self.add_light(&light, *place);
                if let Some(before) = before {
                    self.unused = before;
                }
                self.unused.add("movement{s} of lights", moves.into());
            }
            if let Some(camera) = node.camera() {
                self.add_camera([node.name(), camera.name()], *place);
                self.unused.add("movement{s} of cameras", moves.into());
            }
            let Some(mesh) = node.mesh() else { continue };
            let is_known = std::mem::replace(&mut read[mesh.index()], true);
            let before = is_known.then(|| self.unused.clone());
            self.add_mesh(document, node, *place, &places)?;
            if let Some(before) = before {
                self.unused = before;
            }
        }
        Ok(())
    }

    /// Adds the mesh of a node that stands at `place`, among nodes at `places`.
    fn add_mesh(
        &mut self,
        document: &Document,
        node: &Node<'_>,
        place: Mat4,
        places: &[Option<Mat4>],
    ) -> Result<(), ImportError> {
        let Some(mesh) = node.mesh() else {
            return Ok(());
        };
        let skin = node.skin().map(|skin| Bound::of_skin(self, &skin));
        let skin = skin.transpose()?;
        // Each with its map within the node's frame.
        let poses = match &skin {
            Some(skin) => vec![(Pose::of_skin(skin, places), Mat4::IDENTITY)],
            None => self.instances(document, node, place)?,
        };
        let weights = node.weights().or(mesh.weights()).unwrap_or_default();
        let mut all_weights = weights.to_vec();
        all_weights.resize(animation::targets(node), 0.0);
        let mut part = (self.movement).part(node, place, skin.as_deref(), &all_weights);
        let [_, is_weighed] = self.movement.of(node);
        let first = self.mesh.positions.len();
        for primitive in mesh.primitives() {
            let surface = Surface::read(self, &primitive, weights, is_weighed)?;
            let Some(surface) = surface else { continue };
            if let Some(skin) = &skin {
                let kind = "joint{s} of vertices beyond those of their skin";
                self.unused.add(kind, surface.lost(skin.len()) as u64);
                let kind = "surface{s} on a skeleton without joints and weights";
                self.unused.add(kind, surface.joints.is_empty().into());
            }
            for (pose, own) in &poses {
                self.add(&surface, pose)?;
                if let Some(part) = &mut part {
                    let is_mirrored = match pose {
                        Pose::Rigid(_) => own.determinant() < 0.0,
                        Pose::Skinned(_) => pose.is_mirrored(),
                    };
                    animation::extend(part, &surface, *own, is_mirrored);
                }
            }
        }
        if let Some(mut part) = part {
            part.vertices = first..self.mesh.positions.len();
            self.movement.rig.parts.push(part);
        }
        Ok(())
    }

    /// Returns the nodes of the scene in the document's order, with their places in the world.
    fn placed<'d>(&self, document: &'d Document) -> Result<Vec<Placed<'d>>, ImportError> {
        let scene = document.default_scene().or(document.scenes().next());
        let roots: Vec<Node<'_>> = scene.map_or_else(
            || {
                let children = document.nodes().flat_map(|node| node.children());
                let children: BTreeSet<usize> = children.map(|node| node.index()).collect();
                let is_root = |node: &Node<'_>| !children.contains(&node.index());
                document.nodes().filter(is_root).collect()
            },
            |scene| scene.nodes().collect(),
        );
        let roots = roots.into_iter();
        let root = |node| (node, None, Mat4::IDENTITY);
        let mut open: Vec<(Node<'_>, Option<usize>, Mat4)> = roots.map(root).collect();
        // The last is taken first: this keeps the document's order.
        open.reverse();
        let mut visited = vec![false; document.nodes().len()];
        let mut placed = Vec::new();
        while let Some((node, parent, origin)) = open.pop() {
            let number = node.index();
            if std::mem::replace(&mut visited[number], true) {
                let problem = "has more than one parent, but nodes must form trees";
                return Err(self.fault(format!("node {number} {problem}")));
            }
            if is_hidden(&node) {
                continue;
            }
            let place = origin * Mat4::from_cols_array_2d(&node.transform().matrix());
            if !place.is_finite() {
                return Err(self.fault(format!("node {number} is placed by what is no number")));
            }
            let first_child = open.len();
            let own = Some(placed.len());
            open.extend(node.children().map(|child| (child, own, place)));
            open[first_child..].reverse();
            placed.push(Placed {
                node,
                parent,
                place,
            });
        }
        Ok(placed)
    }

    /// Returns where a node's mesh stands: in one place, or in those that
    /// `EXT_mesh_gpu_instancing` names. Each pose has its map within the node's frame.
    fn instances(
        &self,
        document: &Document,
        node: &Node<'_>,
        place: Mat4,
    ) -> Result<Vec<(Pose, Mat4)>, ImportError> {
        let instancing = node.extension_value("EXT_mesh_gpu_instancing");
        let Some(attributes) = instancing.and_then(|value| value.get("attributes")) else {
            return Ok(vec![(Pose::Rigid(place), Mat4::IDENTITY)]);
        };
        let accessor = |name: &str| {
            let number = attributes.get(name)?.as_u64()? as usize;
            document.accessors().nth(number)
        };
        let moved = accessor("TRANSLATION").map(|a| self.buffers.floats::<3>(&a));
        let turned = accessor("ROTATION").map(|a| self.buffers.floats::<4>(&a));
        let scaled = accessor("SCALE").map(|a| self.buffers.floats::<3>(&a));
        let (moved, turned, scaled) = (
            moved.transpose()?.unwrap_or_default(),
            turned.transpose()?.unwrap_or_default(),
            scaled.transpose()?.unwrap_or_default(),
        );
        let count = moved.len().max(turned.len()).max(scaled.len());
        if count == 0 {
            return Ok(vec![(Pose::Rigid(place), Mat4::IDENTITY)]);
        }
        let poses = (0..count).map(|number| {
            let own = Mat4::from_scale_rotation_translation(
                scaled
                    .get(number)
                    .map_or(Vec3::ONE, |s| Vec3::from_array(*s)),
                turned
                    .get(number)
                    .map_or(Quat::IDENTITY, |r| Quat::from_array(*r).normalize()),
                moved
                    .get(number)
                    .map_or(Vec3::ZERO, |t| Vec3::from_array(*t)),
            );
            (Pose::Rigid(place * own), own)
        });
        Ok(poses.collect())
    }

    /// Adds a surface in a pose.
    fn add(&mut self, surface: &Surface, pose: &Pose) -> Result<(), ImportError> {
        let first = self.mesh.positions.len();
        let count = surface.positions.len();
        let triangles = self.mesh.triangles.len() + surface.triangles.len();
        // Any number of nodes may share the accessors.
        if triangles > TriangleMesh::MOST_TRIANGLES
            || first + count > 3 * TriangleMesh::MOST_TRIANGLES
        {
            return Err(self.too_many(triangles.max((first + count) / 3)));
        }
        let mesh = &mut self.mesh;
        mesh.positions.extend(pose.positions(surface));
        let is_mirrored = pose.is_mirrored();
        let corners = surface.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| first as u32 + corner);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        });
        let first_triangle = mesh.triangles.len();
        mesh.triangles.extend(corners);
        if surface.normals.is_empty() {
            // The corners of its triangles are vertices of their own.
            mesh.normals.resize(first + count, [0.0; 3]);
            for corners in &mesh.triangles[first_triangle..] {
                let normal = flat_normal(corners.map(|c| mesh.positions[c as usize]));
                for corner in corners {
                    mesh.normals[*corner as usize] = normal;
                }
            }
        } else {
            mesh.normals.extend(pose.normals(surface));
        }
        let [first_set, second_set] = &surface.coordinates;
        extend(&mut mesh.coordinates, first_set, first, count, [0.0; 2]);
        extend(
            &mut mesh.second_coordinates,
            second_set,
            first,
            count,
            [0.0; 2],
        );
        extend(&mut mesh.colours, &surface.colours, first, count, [1.0; 3]);
        let tangents: Vec<[f32; 4]> = pose.tangents(surface).collect();
        extend(&mut mesh.tangents, &tangents, first, count, [0.0; 4]);
        let material = surface.material.map_or(u32::MAX, |number| number as u32);
        mesh.triangle_materials.resize(triangles, material);
        Ok(())
    }

    /// Adds a light of `KHR_lights_punctual`. Its candelas and lux are π times ours: a white
    /// surface shows the irradiance that it gets.
    fn add_light(&mut self, light: &gltf::khr_lights_punctual::Light<'_>, place: Mat4) {
        let colour = light
            .color()
            .map(|channel| bounded(channel * light.intensity() * FRAC_1_PI, 0.0, 1.0e12));
        let reaches = light.range().is_some_and(f32::is_finite);
        self.unused.add("range{s} of lights", u64::from(reaches));
        let is_negative = |channel: f32| channel * light.intensity() < 0.0;
        let negative = light.color().into_iter().any(is_negative);
        let kind = "light{s} of negative intensity";
        self.unused.add(kind, negative.into());
        if colour == [0.0; 3] {
            return;
        }
        let ahead = place.transform_vector3(Vec3::NEG_Z).as_dvec3();
        let position = place.transform_point3(Vec3::ZERO).as_dvec3();
        let light = match light.kind() {
            Kind::Directional => Light::Directional {
                direction: ahead.normalize_or(DVec3::NEG_Z),
                colour,
            },
            Kind::Point => Light::Point {
                position,
                colour,
                inverse_square: true,
            },
            Kind::Spot {
                inner_cone_angle,
                outer_cone_angle,
            } => Light::Spot {
                position,
                direction: ahead.normalize_or(DVec3::NEG_Z),
                cone: self.cone([inner_cone_angle, outer_cone_angle]),
                colour,
                inverse_square: true,
            },
        };
        self.lights.push(light);
    }

    /// Returns the angles of a spot's cone; those that cannot be are the format's default.
    fn cone(&mut self, angles: [f32; 2]) -> [f64; 2] {
        let [full, none] = angles.map(f64::from);
        if (0.0..none).contains(&full) && none <= FRAC_PI_2 + 1.0e-6 {
            return [full, none.min(FRAC_PI_2)];
        }
        let kind = "cone{s} of spot lights whose angles are not 0 <= inner < outer <= π/2";
        self.unused.add(kind, 1);
        [0.0, FRAC_PI_4]
    }

    fn add_camera(&mut self, [node, own]: [Option<&str>; 2], place: Mat4) {
        let axis = |axis: Vec3| place.transform_vector3(axis).as_dvec3();
        let back = axis(Vec3::Z).normalize_or(DVec3::Z);
        let right = axis(Vec3::Y).cross(back).normalize_or(DVec3::X);
        let axes = DMat3::from_cols(right, back.cross(right), back);
        let number = self.cameras.len() + 1;
        self.cameras.push(Camera {
            name: node
                .or(own)
                .map_or_else(|| format!("camera {number}"), str::to_owned),
            own_name: own.map(str::to_owned),
            position: place.transform_point3(Vec3::ZERO).as_dvec3(),
            orientation: DQuat::from_mat3(&axes).normalize(),
        });
    }

    /// Lets all vertices have what only some have.
    fn complete(&mut self) {
        let mesh = &mut self.mesh;
        let count = mesh.positions.len();
        if !(mesh.coordinates.is_empty() && mesh.second_coordinates.is_empty()) {
            mesh.coordinates.resize(count, [0.0; 2]);
        }
        if !mesh.second_coordinates.is_empty() {
            mesh.second_coordinates.resize(count, [0.0; 2]);
        }
        if !mesh.colours.is_empty() {
            mesh.colours.resize(count, [1.0; 3]);
        }
        if !mesh.tangents.is_empty() {
            mesh.tangents.resize(count, [0.0; 4]);
        }
    }

    fn count_unused(&mut self, document: &Document) {
        let root = document.as_json();
        let variants = root.extensions.as_ref();
        let variants = variants.and_then(|all| all.khr_materials_variants.as_ref());
        let variants = variants.map_or(0, |all| all.variants.len());
        self.unused.add("variant{s} of materials", variants as u64);
        let others = root.scenes.len().saturating_sub(1);
        self.unused.add("scene{s} besides the first", others as u64);
    }
}

/// Returns whether `KHR_node_visibility` hides a node and those below it.
fn is_hidden(node: &Node<'_>) -> bool {
    let visibility = node.extension_value("KHR_node_visibility");
    visibility.and_then(|of| of.get("visible")?.as_bool()) == Some(false)
}

/// Appends what a surface has of something to what the vertices before it have.
fn extend<T: Copy>(all: &mut Vec<T>, own: &[T], first: usize, count: usize, without: T) {
    if !own.is_empty() {
        all.resize(first, without);
        all.extend_from_slice(own);
    } else if !all.is_empty() {
        all.resize(first + count, without);
    }
}

#[cfg(test)]
pub(super) mod tests;
