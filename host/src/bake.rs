//! From a scene in memory to the bytes that the core traces.

mod blob;
mod cover;
mod layout;
pub mod tree;

pub use layout::{BakedScene, Layout};

use crate::material::Material;
use crate::mesh::{MeshError, TriangleMesh};
use crate::scene::camera::CameraPath;
use crate::scene::{Background, Light, Object, Scene, Shape};
use crate::simplify::{Ladder, LadderError, PolygonLevels};
use crate::texture::{Image, Pattern, Texture};
use blob::{AlignedBytes, Tables};
use cover::Cover;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use shisen_core::scene::SceneError;
use shisen_core::scene::format::{
    self, IdLeaf, Instance, LeafBlock, NO_MATERIAL, NO_MEDIUM, NO_TEXTURE, Node, effect, flag,
    kind, light, texture,
};
use shisen_core::shape::Spheroid;
use shisen_core::spectrum::line;
use std::borrow::Cow;
use std::sync::Arc;
use thiserror::Error;
use tree::{Bounds, Effort, WideTree};

/// A baked scene: the bytes of `shisen_core::scene`, aligned for use in place.
#[derive(Debug, Clone, PartialEq)]
pub struct Baked<const W: usize = 8> {
    bytes: AlignedBytes,
}

/// Why a scene cannot be baked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BakeError {
    /// One of its meshes is not usable.
    #[error("mesh {mesh} (counted from 0) cannot be used")]
    Mesh {
        /// Its index.
        mesh: usize,
        /// What is wrong.
        #[source]
        source: MeshError,
    },
    /// One of its meshes has no polygon levels of the kind asked for.
    #[error("mesh {mesh} (counted from 0) cannot be baked at these polygon levels")]
    Ladder {
        /// Its index.
        mesh: usize,
        /// What is wrong.
        #[source]
        source: LadderError,
    },
    /// Nothing in it.
    #[error("the scene has no objects")]
    NoObjects,
    /// An object that names what is not there.
    #[error("object {object} (counted from 0) names {what} {index}, which the scene does not have")]
    Missing {
        /// The object.
        object: usize,
        /// What it names.
        what: &'static str,
        /// By this index.
        index: usize,
    },
    /// A texture on a mesh that does not say where its vertices are on it.
    #[error(
        "object {object} (counted from 0) has a texture, but its mesh has no texture coordinates"
    )]
    NoCoordinates {
        /// The object.
        object: usize,
    },
    /// A map that flattens, or that is not finite, or that moves things out
    /// of range.
    #[error(
        "object {object} (counted from 0) is placed by a map that cannot be undone, or too far away \
         (coordinates may be up to {limit:e} m)"
    )]
    Transform {
        /// The object.
        object: usize,
        /// The farthest coordinate, metres.
        limit: f32,
    },
    /// A radius out of range.
    #[error(
        "object {object} (counted from 0) has a radius outside {:e} to {:e} m",
        Spheroid::RADII.0,
        Spheroid::RADII.1
    )]
    Radius {
        /// The object.
        object: usize,
    },
    /// The scene does not pass the core's own check.
    #[error("the scene holds a value that the tracer refuses: {0}")]
    Refused(#[from] SceneError),
    /// More bytes than an offset of the format can name.
    #[error("the scene would take {bytes} bytes; a scene may have 4 GiB")]
    TooLarge {
        /// How many.
        bytes: u64,
    },
}

impl<const W: usize> Baked<W> {
    /// Bakes a scene for nodes of `W` children. The same scene always gives
    /// the same bytes.
    ///
    /// # Errors
    /// Whatever the core would refuse, found and named before it is asked.
    pub fn new(scene: &Scene) -> Result<Self, BakeError> {
        validate(scene)?;
        let meshes = shown(scene);
        let ladders: Vec<_> = meshes.iter().map(|mesh| Ladder::single(mesh)).collect();
        Self::with_ladders(scene, &ladders)
    }

    /// As [`new`](Self::new), with each mesh at several polygon levels.
    ///
    /// # Errors
    /// Also where a mesh cannot be simplified that far.
    pub fn with_levels(scene: &Scene, levels: &PolygonLevels) -> Result<Self, BakeError> {
        validate(scene)?;
        let meshes = shown(scene);
        let ladders: Vec<_> = meshes
            .par_iter()
            .enumerate()
            .map(|(mesh, source)| {
                Ladder::new(source, levels).map_err(|source| BakeError::Ladder { mesh, source })
            })
            .collect::<Result<_, _>>()?;
        Self::with_ladders(scene, &ladders)
    }

    fn with_ladders(scene: &Scene, ladders: &[Ladder<'_>]) -> Result<Self, BakeError> {
        let mut tables = Tables::<W>::default();
        let mut textures = Textures::default();
        for source in &scene.materials {
            tables.add_material(source, &mut textures);
        }
        let trees: Vec<Vec<WideTree<W>>> = ladders.par_iter().map(trees).collect();
        let covers: Vec<Cover<W>> = ladders
            .par_iter()
            .map(|ladder| Cover::new(ladder.versions()))
            .collect();
        // The tree over instances comes first, whose size is known only once
        // the instances are.
        let mut placed = Vec::new();
        for (number, object) in scene.objects.iter().enumerate() {
            let (mut instance, slack) = instance(scene, number, object)?;
            if let Shape::Mesh(mesh) = object.shape {
                // Past the rungs of all meshes before it.
                let before = trees[..mesh].iter().map(Vec::len).sum::<usize>();
                instance.geometry = before as u32;
            }
            placed.push((instance, slack));
        }
        if placed.is_empty() {
            return Err(BakeError::NoObjects);
        }
        let boxes: Vec<Bounds> = placed
            .iter()
            .map(|(i, _)| Bounds {
                low: i.low,
                high: i.high,
            })
            .collect();
        let top = tree::build::<W>(&boxes, 1, Effort::Great);
        let deepest = trees.iter().flatten().map(|tree| tree.stack_entries).max();
        let stack_entries = top.stack_entries + deepest.unwrap_or(0);
        tables.top_nodes = top.nodes.len() as u32;
        for mut node in top.nodes {
            // Leaves of this tree name instances, not leaf blocks.
            for child in &mut node.child {
                if *child & format::LEAF != 0 {
                    let leaf = (*child & format::INDEX) as usize;
                    *child = format::LEAF | top.leaves[leaf][0];
                }
            }
            tables.nodes.push(node);
        }
        for (object, (instance, slack)) in scene.objects.iter().zip(&mut placed) {
            if let Shape::Mesh(mesh) = object.shape {
                let positions = &ladders[mesh].versions().positions;
                let cover = covers[mesh].placed(positions, &object.world_from_object, *slack);
                (instance.cover, instance.cover_nodes) = tables.add_cover(cover);
            }
        }
        for (ladder, trees) in ladders.iter().zip(&trees) {
            tables.add_mesh(ladder, trees, &mut textures);
        }
        tables.rungs = trees.iter().map(Vec::len).max().unwrap_or(1) as u32;
        tables.lights = scene.lights.iter().map(baked_light).collect();
        tables.extent = extent(boxes.iter().flat_map(|b| [b.low, b.high]));
        tables.instances = placed.into_iter().map(|(instance, _)| instance).collect();
        tables.background = background(&scene.background);
        tables.ambient = scene.ambient;
        tables.stack_entries = stack_entries as u32;
        tables.add_default_material();
        let baked = Self {
            bytes: tables.into_bytes()?,
        };
        // Nothing leaves here that the core would not take back.
        baked.try_scene()?;
        Ok(baked)
    }

    /// The bytes, as they go to a file or to flash.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.as_bytes()
    }

    /// Takes the bytes of a scene file, aligning them.
    ///
    /// # Errors
    /// What the core finds wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneError> {
        let baked = Self {
            bytes: AlignedBytes::copy_of(bytes),
        };
        baked.try_scene()?;
        Ok(baked)
    }

    fn try_scene(&self) -> Result<shisen_core::scene::Scene<'_, W>, SceneError> {
        shisen_core::scene::Scene::from_bytes(self.as_bytes())
    }

    /// The scene in these bytes.
    ///
    /// # Panics
    /// Never: the bytes were checked when this value was made.
    pub fn scene(&self) -> shisen_core::scene::Scene<'_, W> {
        self.try_scene().expect("checked when it was made")
    }
}

/// One mesh as a scene of its own, in its own frame.
pub fn lone_mesh(mesh: TriangleMesh) -> Scene {
    Scene {
        name: "mesh".into(),
        meshes: vec![mesh],
        materials: Vec::new(),
        objects: vec![Object {
            shape: Shape::Mesh(0),
            material: None,
            world_from_object: DAffine3::IDENTITY,
            casts_shadow: true,
            smooth: false,
        }],
        lights: Vec::new(),
        background: Background::uniform([0.0; 3]),
        ambient: [0.0; 3],
        camera: CameraPath::default(),
    }
}

/// The meshes, without coordinates where no object shows a texture on them.
fn shown(scene: &Scene) -> Vec<Cow<'_, TriangleMesh>> {
    let meshes = scene.meshes.iter().enumerate();
    meshes
        .map(|(number, mesh)| {
            let places = |object: &&Object| object.shape == Shape::Mesh(number);
            let material = |object: &Object| scene.materials.get(object.material?);
            let mut objects = scene.objects.iter().filter(places);
            if mesh.coordinates.is_empty() || objects.any(|o| mesh.shows_texture(material(o))) {
                return Cow::Borrowed(mesh);
            }
            Cow::Owned(TriangleMesh {
                coordinates: Vec::new(),
                ..mesh.clone()
            })
        })
        .collect()
}

fn validate(scene: &Scene) -> Result<(), BakeError> {
    for (mesh, source) in scene.meshes.iter().enumerate() {
        source
            .validate()
            .map_err(|source| BakeError::Mesh { mesh, source })?;
    }
    Ok(())
}

/// One tree a rung.
fn trees<const W: usize>(ladder: &Ladder<'_>) -> Vec<WideTree<W>> {
    let mesh = ladder.versions();
    let tree = |rung: &Vec<u32>| {
        let bounds = |&triangle: &u32| {
            let corners = mesh.triangles[triangle as usize];
            Bounds::of_points(&corners.map(|c| mesh.positions[c as usize]))
        };
        let boxes: Vec<Bounds> = rung.iter().map(bounds).collect();
        let mut tree = tree::build(&boxes, W, Effort::Great);
        for number in tree.leaves.iter_mut().flatten() {
            *number = rung[*number as usize];
        }
        tree
    };
    ladder.rungs().par_iter().map(tree).collect()
}

fn extent(points: impl Iterator<Item = [f32; 3]>) -> f32 {
    points.flatten().fold(0.0, |extent, c| extent.max(c.abs()))
}

impl<const W: usize> Tables<W> {
    /// Adds the nodes of a cover: the number of the first, and how many.
    fn add_cover(&mut self, cover: Vec<Node<W>>) -> (u32, u32) {
        let (first, count) = (self.nodes.len() as u32, cover.len() as u32);
        for mut node in cover {
            for lane in 0..W {
                if node.child[lane] & format::LEAF == 0 && !node.is_empty_lane(lane) {
                    node.child[lane] += first;
                }
            }
            self.nodes.push(node);
        }
        (first, count)
    }

    /// Adds a ladder, of which `trees` has one tree a rung.
    fn add_mesh(&mut self, ladder: &Ladder<'_>, trees: &[WideTree<W>], textures: &mut Textures) {
        let mesh = ladder.versions();
        let first_triangle = self.triangles.len() as u32;
        let first_normal = self.normals.len() as u32;
        let first_coordinate = self.coordinates.len() as u32;
        let first_material = self.materials.len() as u32;
        for (number, &corners) in mesh.triangles.iter().enumerate() {
            // Resolved to the default material once all materials are there.
            let material = mesh
                .triangle_materials
                .get(number)
                .map_or(NO_MATERIAL, |m| first_material + m);
            self.triangles.push(format::Triangle { corners, material });
        }
        for source in &mesh.materials {
            self.add_material(source, textures);
        }
        self.normals.extend_from_slice(&mesh.vertex_normals());
        self.coordinates.extend_from_slice(&mesh.coordinates);
        if W == 4 {
            let positions = mesh.positions.iter();
            self.positions
                .extend(positions.map(|p| p.map(positive_zero)));
        }
        let extent = extent(mesh.positions.iter().copied());
        for (rung, tree) in trees.iter().enumerate() {
            let rungs = (trees.len() - rung) as u32;
            let faces = &ladder.rungs()[rung];
            // What could not be simplified further needs no second tree.
            if rung > 0 && *faces == ladder.rungs()[rung - 1] {
                let finer = *self.meshes.last().expect("the rung before");
                self.meshes.push(format::Mesh { rungs, ..finer });
                continue;
            }
            let first_node = self.nodes.len() as u32;
            let first_leaf = (self.leaves.len() + self.id_leaves.len()) as u32;
            for node in &tree.nodes {
                let mut node = *node;
                for lane in 0..W {
                    if node.child[lane] & format::LEAF != 0 {
                        node.child[lane] += first_leaf;
                    } else if !node.is_empty_lane(lane) {
                        node.child[lane] += first_node;
                    }
                }
                self.nodes.push(node);
            }
            for leaf in &tree.leaves {
                if W == 8 {
                    self.leaves.push(leaf_block(mesh, leaf));
                } else {
                    self.id_leaves.push(id_leaf(leaf));
                }
            }
            self.meshes.push(format::Mesh {
                root: first_node,
                first_node,
                node_count: tree.nodes.len() as u32,
                first_leaf,
                leaf_count: tree.leaves.len() as u32,
                first_triangle,
                triangle_count: mesh.triangles.len() as u32,
                first_normal,
                normal_count: mesh.positions.len() as u32,
                extent,
                rungs,
                faces: faces.len() as u32,
                first_coordinate,
                coordinate_count: mesh.coordinates.len() as u32,
                reserved: [0; 2],
            });
        }
    }

    fn add_default_material(&mut self) {
        let default = self.materials.len() as u32;
        let mut used = self.materials.is_empty();
        for triangle in &mut self.triangles {
            if triangle.material == NO_MATERIAL {
                triangle.material = default;
                used = true;
            }
        }
        for instance in &mut self.instances {
            if instance.material == NO_MATERIAL && instance.kind != kind::MESH {
                instance.material = default;
                used = true;
            }
        }
        if used {
            self.add_material(&Material::default(), &mut Textures::default());
        }
    }

    fn add_material(&mut self, source: &Material, textures: &mut Textures) {
        let (mut baked, texture) = material(source);
        if let Some(texture) = texture {
            baked.texture = textures.add(texture, self);
        }
        // What is no clear body needs none, and a constant index is as good as one.
        let is_clear = baked.effects & effect::REFRACTION != 0;
        let medium = source.medium.filter(|one| is_clear && one.is_dispersive());
        if let Some(medium) = medium {
            let known = self.media.iter().position(|known| *known == medium);
            let number = known.unwrap_or(self.media.len());
            if number == self.media.len() {
                self.media.push(medium);
            }
            baked.medium = number as u32;
            baked.effects |= effect::DISPERSION;
        }
        self.materials.push(baked);
    }
}

/// What was put into the tables of textures and texels, each once.
#[derive(Default)]
struct Textures {
    textures: Vec<Texture>,
    /// With the number of each image's first texel.
    images: Vec<(Arc<Image>, u32)>,
}

impl Textures {
    /// The number of a texture in the tables.
    fn add<const W: usize>(&mut self, source: &Texture, tables: &mut Tables<W>) -> u32 {
        let same = |known: &Texture| {
            known.repeats == source.repeats
                && match (&known.pattern, &source.pattern) {
                    (Pattern::Image(known), Pattern::Image(image)) => Arc::ptr_eq(known, image),
                    (known, pattern) => known == pattern,
                }
        };
        if let Some(number) = self.textures.iter().position(same) {
            return number as u32;
        }
        let mut baked = format::Texture {
            kind: texture::CHECKER,
            width: 0,
            height: 0,
            first_texel: 0,
            repeats: source.repeats,
            colours: [[0.0; 3]; 2],
            reserved: [0; 4],
        };
        match &source.pattern {
            Pattern::Checker(colours) => baked.colours = *colours,
            Pattern::Image(image) => {
                baked.kind = texture::IMAGE;
                (baked.width, baked.height) = (image.width(), image.height());
                baked.first_texel = self.first_texel(image, tables);
            }
        }
        tables.textures.push(baked);
        self.textures.push(source.clone());
        tables.textures.len() as u32 - 1
    }

    fn first_texel<const W: usize>(&mut self, image: &Arc<Image>, tables: &mut Tables<W>) -> u32 {
        let known = self
            .images
            .iter()
            .find(|(known, _)| Arc::ptr_eq(known, image));
        if let Some(&(_, first)) = known {
            return first;
        }
        let first = tables.texels.len() as u32;
        tables.texels.extend_from_slice(image.texels());
        self.images.push((Arc::clone(image), first));
        first
    }
}

/// Leaves no −0 behind, so that equal vertices have equal bits.
fn positive_zero(coordinate: f32) -> f32 {
    coordinate + 0.0
}

fn id_leaf(triangles: &[u32]) -> IdLeaf {
    let mut leaf = [u32::MAX; 4];
    leaf[..triangles.len()].copy_from_slice(triangles);
    leaf
}

fn leaf_block<const W: usize>(mesh: &TriangleMesh, triangles: &[u32]) -> LeafBlock<W> {
    let mut block = LeafBlock {
        corners: [[[f32::NAN; W]; 3]; 3],
        ids: [u32::MAX; W],
    };
    for (lane, &triangle) in triangles.iter().enumerate() {
        block.ids[lane] = triangle;
        for corner in 0..3 {
            let vertex = mesh.triangles[triangle as usize][corner] as usize;
            for axis in 0..3 {
                let position = mesh.positions[vertex][axis];
                block.corners[corner][axis][lane] = positive_zero(position);
            }
        }
    }
    block
}

/// A material but for the number of its texture, and that where it shows.
fn material(m: &Material) -> (format::Material, Option<&Texture>) {
    let any = |colour: [f32; 3]| colour.iter().any(|&c| c > 0.0);
    let mut effects = 0;
    if any(m.emission) {
        effects |= effect::EMISSION;
    }
    let shows = any(m.diffuse) || any(m.emission);
    let texture = m.texture.as_ref().filter(|_| shows);
    effects |= match texture.map(|texture| &texture.pattern) {
        None => 0,
        Some(Pattern::Checker(_)) => effect::CHECKER_TEXTURE,
        Some(Pattern::Image(_)) => effect::IMAGE_TEXTURE,
    };
    if any(m.diffuse) || any(m.specular) {
        effects |= effect::LIT;
    }
    if any(m.transmission) {
        effects |= effect::REFRACTION;
        if any(m.absorption) {
            effects |= effect::ABSORPTION;
        }
    } else if any(m.mirror) {
        effects |= effect::REFLECTION;
    }
    if m.graticule.is_some() {
        effects |= effect::GRATICULE;
    }
    let baked = format::Material {
        diffuse: m.diffuse,
        shininess: m.shininess,
        specular: m.specular,
        index_of_refraction: match m.medium {
            Some(medium) => medium.index_clamped(line::D),
            None => m.index_of_refraction,
        },
        mirror: m.mirror,
        effects,
        transmission: m.transmission,
        texture: NO_TEXTURE,
        absorption: m.absorption,
        graticule_divisions: m.graticule.map_or(0, |lines| lines.divisions),
        graticule_width: m.graticule.map_or(0.0, |lines| lines.width),
        emission: m.emission,
        medium: NO_MEDIUM,
        reserved2: [0; 7],
    };
    (baked, texture)
}

fn baked_light(source: &Light) -> format::Light {
    let vector = |v: DVec3| v.as_vec3().to_array();
    let small = |place, kind, colour| format::Light {
        place: vector(place),
        kind,
        colour,
        samples: 0,
        right: [0.0; 3],
        reserved: 0,
        up: [0.0; 3],
        reserved2: 0,
    };
    match *source {
        Light::Point {
            position,
            colour,
            inverse_square,
        } => {
            let kind = if inverse_square {
                light::POINT_INVERSE_SQUARE
            } else {
                light::POINT
            };
            small(position, kind, colour)
        }
        Light::Directional { direction, colour } => small(
            -direction.normalize_or(DVec3::NEG_Y),
            light::DIRECTIONAL,
            colour,
        ),
        Light::Rectangle {
            centre,
            right,
            up,
            colour,
            samples,
            two_sided,
        } => {
            let kind = if two_sided {
                light::TWO_SIDED_RECTANGLE
            } else {
                light::RECTANGLE
            };
            format::Light {
                samples,
                right: vector(right),
                up: vector(up),
                ..small(centre, kind, colour)
            }
        }
    }
}

fn background(source: &Background) -> format::Background {
    format::Background {
        zenith: source.zenith,
        alpha: source.alpha,
        horizon: source.horizon,
        reserved: 0,
        nadir: source.nadir,
        reserved2: 0,
    }
}

/// Rounding of the map into the object's frame and back, in units of the
/// largest number involved: a box widened by this holds what the mapped ray
/// can hit.
const MAP_SLACK: f64 = 64.0 * 5.960_464_477_539_063e-8;

/// What an object becomes, and by how many metres its boxes are wider than it.
fn instance(scene: &Scene, number: usize, object: &Object) -> Result<(Instance, f64), BakeError> {
    let missing = |what, index| BakeError::Missing {
        object: number,
        what,
        index,
    };
    let (kind, geometry, radii, (low, high)) = match object.shape {
        Shape::Mesh(index) => {
            let mesh = scene.meshes.get(index).ok_or(missing("mesh", index))?;
            (kind::MESH, index as u32, [0.0; 2], mesh.bounds())
        }
        Shape::Sphere { radius } => (kind::SPHEROID, 0, [radius; 2], cube(radius, radius)),
        Shape::Spheroid {
            equatorial_radius: e,
            polar_radius: p,
        } => (kind::SPHEROID, 0, [e, p], cube(e, p)),
    };
    if kind == kind::SPHEROID && Spheroid::new(radii[0], radii[1]).is_none() {
        return Err(BakeError::Radius { object: number });
    }
    if let Some(index) = object.material.filter(|&m| m >= scene.materials.len()) {
        return Err(missing("material", index));
    }
    if let Shape::Mesh(index) = object.shape
        && !scene.meshes[index].has_coordinates_for(object.material.map(|m| &scene.materials[m]))
    {
        return Err(BakeError::NoCoordinates { object: number });
    }
    let bad_map = BakeError::Transform {
        object: number,
        limit: TriangleMesh::FARTHEST,
    };
    let world_from_object = object.world_from_object;
    let object_from_world = world_from_object.inverse();
    let determinant = world_from_object.matrix3.determinant();
    if !world_from_object.is_finite() || !object_from_world.is_finite() || !determinant.is_normal()
    {
        return Err(bad_map);
    }
    let corners: Vec<DVec3> = (0..8)
        .map(|i| {
            let pick = |axis: usize| f64::from(if i >> axis & 1 == 0 { low } else { high }[axis]);
            world_from_object.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
        })
        .collect();
    let least = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let most = corners
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let farthest = least.abs().max(most.abs()).max_element();
    if !(farthest <= f64::from(TriangleMesh::FARTHEST)) {
        return Err(bad_map);
    }
    // An ill-conditioned map magnifies what rounding does in its other frame.
    let norm = |m: glam::DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
    let condition = norm(world_from_object.matrix3) * norm(object_from_world.matrix3);
    let translation = world_from_object.translation.abs().max_element();
    let slack = MAP_SLACK * condition * farthest.max(translation);
    let opaque = |m: &Material| m.transmission == [0.0; 3];
    let lets_light_through = match (object.material, object.shape) {
        (Some(index), _) => !opaque(&scene.materials[index]),
        (None, Shape::Mesh(index)) => {
            let materials = &scene.meshes[index].materials;
            !materials.is_empty() && !materials.iter().any(opaque)
        }
        (None, _) => false,
    };
    let mut flags = 0;
    if object.casts_shadow && !lets_light_through {
        flags |= flag::OCCLUDES;
    }
    if object.smooth {
        flags |= flag::SMOOTH;
    }
    let instance = Instance {
        kind,
        geometry,
        material: object.material.map_or(NO_MATERIAL, |m| m as u32),
        flags,
        radii,
        condition: condition as f32,
        cover: 0,
        object_from_world: columns(object_from_world),
        world_from_object: columns(world_from_object),
        low: (least - slack).to_array().map(|c| (c as f32).next_down()),
        high: (most + slack).to_array().map(|c| (c as f32).next_up()),
        cover_nodes: 0,
        reserved: 0,
    };
    Ok((instance, slack))
}

fn cube(equatorial: f32, polar: f32) -> ([f32; 3], [f32; 3]) {
    (
        [-equatorial, -polar, -equatorial],
        [equatorial, polar, equatorial],
    )
}

fn columns(map: DAffine3) -> [[f32; 3]; 4] {
    map.to_cols_array_2d()
        .map(|column| column.map(|c| c as f32))
}
