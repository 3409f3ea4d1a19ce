//! Scenes that people write, in TOML.
//!
//! Lengths are metres, angles degrees; +X is right, +Y up, −Z forward.
//! Colours are linear red, green and blue. This describes a whole scene, and
//! the comments say what holds where a key is left out:
//!
#![doc = concat!("```toml\n", include_str!("example.toml"), "```")]
//!
//! | value | range |
//! |---|---|
//! | `diffuse`, `specular`, `mirror`, `transmission`, `alpha` | 0 to 1 |
//! | `shininess` | 1 to 10,000 |
//! | `index_of_refraction` | 0.01 to 100 |
//! | colours of lights and background, `strength`, `ambient`, `absorption`, `emission` | 0 to 1,000,000 |
//! | `colours` of a checker | 0 to 1 |
//! | `normal_scale` | −1,000 to 1,000 |
//! | `range_nm` | 10 to 1,000,000 nm, the shorter first, without a pole, the index from 1 to 100 |
//! | `coefficients` | A and up to four pairs of B and C, −1e9 to 1e9 |
//! | `repeats` | 0.001 to 10,000 |
//! | images | PNG or JPEG, up to 8,192 × 8,192 texels, all of a scene up to 512 MiB at 4 bytes a texel |
//! | radii, `scale`, `size` of a light | 0.000001 to 1,000,000 |
//! | `samples` of a light | 1 to 64 |
//! | `position`, `direction`, `up`, `zenith`, `top` | −1,000,000 to 1,000,000; a direction is not zero |
//! | `divisions` | 1 to 900 |
//! | `width_degrees` | 0.001 to 28 |
//! | `frame` | 1 to 99,999, each after the one before |
//! | rotations | −360 to 360 |
//! | `times` | seconds from 0, each at or after the one before |
//! | `seconds_per_turn` | ±0.001 to ±86,400 |
//!
//! A positive yaw turns what points to −Z towards −X, a positive pitch raises it.
//! `normals` and `normalise` are for meshes only. A texture multiplies `diffuse` and `emission`;
//! meshes say in their files where they are on it, the built-in `square` is from 0 to 1 along x and
//! against z, and on spheres and spheroids u goes round with the longitude and v up with the
//! latitude. A material has an `index_of_refraction` or a `medium`: one of the file's or
//! `fused-silica`, `quartz-o`, `quartz-e`, `n-bk7`, `sf11`, `diamond` or `water`; which have to be
//! known at
//! 587.56 nm; these and `absorption` are for materials
//! with a `transmission`. `emission` is seen, but lights nothing, and a rectangle lights, but is
//! not seen. An animation takes the place of the object's keys of the same names: between its times
//! values change evenly, each angle by itself, or along a smooth curve (`cubic`), or not (`step`);
//! after the last time it begins anew. A spin turns an object in its own frame, beside what else
//! moves it. A mesh of a glTF file moves by its own animations, too, below its object: parts that
//! move become meshes and objects after those of the scene file. A scene has at least one object and
//! may have no light. Meshes and materials are numbered by name in the [`Scene`], objects and lights
//! by place in the file. A key that is not described here is an error, not ignored.
//!
//! A background's `image` is a picture of all directions, as cameras for such and most programs write
//! it (equirectangular): `OpenEXR` or Radiance, up to 100 MiB and 8,192 × 8,192 pixels. It lights
//! nothing but by `ambient`, which is its mean where the file does not say otherwise. Programs without
//! the effect `environment` show a gradient of its means at the poles and the horizon.

#![allow(clippy::ref_option, reason = "a table's field is an option")]

mod animations;
mod entries;
mod fault;
mod lights;
mod materials;

pub use fault::SceneFault;

use super::camera::{CameraKey, CameraPath, DomeCamera};
use super::placement::{Normalisation, Placement};
use super::{Background, Object, Scene, Shape};
use crate::files::UNREAD;
use crate::files::description::{FileError, Located, read_description};
use crate::scene::environment::{Environment, Radiance};
use crate::scene::import::{ImportError, Model};
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::Motion;
use animations::{read_animation, read_names};
use entries::{BackgroundEntry, CameraEntry, MeshEntry, ObjectEntry, SceneEntry};
use fault::{Check, Checked, DEGREES, FRAMES, LENGTH, POSITION, RADIANCE, SHARE};
use glam::{DAffine3, DVec3};
use lights::read_light;
use materials::{read_materials, read_textures};
use miette::Diagnostic;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

const SYNTAX: &str = "a scene file has name, ambient, [background], [materials.NAME], \
                      [media.NAME], [textures.NAME], [meshes.NAME], [[object]], [[animation]], \
                      [[light]] and [[camera]]";

const FOLDER: &str = "check the file's name and permissions: relative paths start at the folder \
                      of the scene file";

/// Returns what to do about an error of a file that a scene file names.
fn advice(error: Option<&dyn Diagnostic>) -> String {
    let help = error.and_then(Diagnostic::help);
    let help = help.map_or(UNREAD.to_owned(), |help| help.to_string());
    if help == UNREAD {
        FOLDER.to_owned()
    } else {
        help
    }
}

/// Where a scene's mesh comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeshSource {
    /// A file: the path as written, from the scene file's folder.
    File(PathBuf),
    /// A built-in mesh.
    BuiltIn(BuiltInMesh),
}

/// A mesh that needs no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuiltInMesh {
    /// `quadruped`: an animal on four legs.
    Quadruped,
    /// `square`: 1 m along x and z about the origin, its front up.
    Square,
}

impl Scene {
    /// Reads a scene file; `load_mesh` brings the meshes that it names, alone or with what of their
    /// models moves.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load<M, E>(
        path: &Path,
        load_mesh: impl FnMut(&MeshSource) -> Result<M, E>,
    ) -> Result<Self, FileError<SceneFault>>
    where
        M: Into<Model>,
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let help = "give the path of a TOML file that describes a scene";
        let text = read_description(path, "the scene", help)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.to_string_lossy();
        Ok(Self::from_toml(&text, &name, folder, load_mesh)?)
    }

    /// Returns a scene from the text of a scene file. `name` is what messages call it, `base_dir`
    /// where its relative paths start; `load_mesh` is called once for each mesh, in order of names.
    ///
    /// # Errors
    /// The first fault and its place: text that is not TOML, unknown or missing keys, values out of
    /// range, names that nothing has, meshes and images that cannot be loaded or used, no objects,
    /// animations whose times go back.
    pub fn from_toml<M, E>(
        text: &str,
        name: &str,
        base_dir: &Path,
        mut load_mesh: impl FnMut(&MeshSource) -> Result<M, E>,
    ) -> Result<Self, Located<SceneFault>>
    where
        M: Into<Model>,
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let check = Check { name, text };
        let entry: SceneEntry = check.parse(SYNTAX, SceneFault::new)?;
        if entry.object.is_empty() {
            let help = "add an [[object]] with a mesh, a sphere or a spheroid";
            let fault = SceneFault::new("the scene has no objects", help);
            return Err(check.fault(fault, None));
        }
        let material_numbers = numbers(&entry.materials);
        let mesh_numbers = numbers(&entry.meshes);
        let ambient = check.colour_or("ambient", &entry.ambient, RADIANCE, [0.0; 3])?;
        let background = match &entry.background {
            None => Background::default(),
            Some(entry) => read_background(&check, entry)?,
        };
        let (mut ambient, mut background) = (ambient, background);
        let materials = read_materials(&check, &entry)?;
        let lights = entry.light.iter().map(|entry| read_light(&check, entry));
        let lights = lights.collect::<Result<_, _>>()?;
        let camera = read_path(&check, &entry.camera)?;
        // The text is checked before anything large is loaded.
        let objects = entry.object.iter();
        let objects = objects.map(|one| read_object(&check, one, &mesh_numbers, &material_numbers));
        let mut objects = objects.collect::<Result<Vec<_>, _>>()?;
        let names = read_names(&check, &entry.object)?;
        let animations = entry.animation.iter();
        let animations = animations.map(|one| read_animation(&check, one, &names));
        let animations = animations.collect::<Result<Vec<_>, _>>()?;
        for (number, (object, clip)) in animations.iter().enumerate() {
            let mut before = animations[..number].iter();
            if before.any(|(other, before)| other == object && before.vies_with(clip)) {
                let message = format!("\"{}\" has two animations of one property", clip.name);
                let help = "write all keys of a property into one [[animation]]";
                return check.refuse(message, help, entry.animation[number].span());
            }
        }
        let textures = read_textures(&check, &entry.textures, base_dir)?;
        let environment = read_environment(&check, &entry, base_dir)?;
        if let Some(environment) = &environment {
            let mean = |heights| environment.mean(heights);
            background.zenith = mean([0.8, 1.0]);
            background.horizon = mean([-0.2, 0.2]);
            background.nadir = mean([-1.0, -0.8]);
            if entry.ambient.is_none() {
                ambient = mean([-1.0, 1.0]);
            }
        }
        let materials = materials.into_iter();
        let materials = materials.map(|(material, of)| of.applied(material, &textures));
        let materials: Vec<Material> = materials.collect();
        let mut meshes = Vec::with_capacity(entry.meshes.len());
        let mut rigs = Vec::with_capacity(entry.meshes.len());
        for (name, entry) in &entry.meshes {
            let source = read_mesh_source(&check, name, entry, base_dir)?;
            let fault = |done, help: &str, source: Box<dyn std::error::Error + Send + Sync>| {
                let message = format!("the mesh \"{}\" cannot be {done}", name.as_ref());
                let fault = SceneFault::caused(message, Some(help), source);
                check.fault(fault, Some(entry.span()))
            };
            let loaded = load_mesh(&source).map_err(|error| {
                let error = error.into();
                let known = error.downcast_ref::<ImportError>();
                let help = advice(known.map(|known| known as &dyn Diagnostic));
                fault("loaded", &help, error)
            })?;
            let Model { mesh, rig, .. } = loaded.into();
            let repair = "repair it in the program that wrote it, or use another";
            let checked = mesh.validate();
            checked.map_err(|error| fault("used", repair, error.into()))?;
            meshes.push(mesh);
            rigs.push(rig);
        }
        for (placed, entry) in objects.iter_mut().zip(&entry.object) {
            placed.fit(&check, entry, &meshes, &materials)?;
        }
        let file_name = || {
            let stem = Path::new(name).file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        };
        let mut motion = Motion::default();
        for (object, clip) in animations {
            let Placed { placement, fit, .. } = &objects[object];
            motion.move_object(object, placement.local(), *fit, clip);
        }
        let mut scene = Self {
            name: entry.name.unwrap_or_else(file_name),
            meshes,
            materials,
            objects: objects.into_iter().map(|placed| placed.object).collect(),
            lights,
            background,
            environment,
            ambient,
            camera,
            motion,
        };
        for (mesh, rig) in rigs.into_iter().enumerate() {
            scene.animate(mesh, rig);
        }
        Ok(scene)
    }
}

fn numbers<T>(entries: &BTreeMap<Spanned<String>, T>) -> BTreeMap<&str, usize> {
    entries
        .keys()
        .map(|name| name.as_ref().as_str())
        .zip(0..)
        .collect()
}

fn read_background(check: &Check<'_>, entry: &Spanned<BackgroundEntry>) -> Checked<Background> {
    let BackgroundEntry {
        colour,
        zenith,
        horizon,
        nadir,
        image,
        yaw_degrees,
        strength,
        alpha,
    } = entry.as_ref();
    if image.is_none() {
        let owner = "a background with an `image`";
        check.only_for(owner, "yaw_degrees", yaw_degrees)?;
        check.only_for(owner, "strength", strength)?;
    }
    let gradient = [zenith, horizon, nadir];
    let mut background = match (colour, zenith, horizon, nadir) {
        _ if image.is_some() && colour.is_none() && gradient == [&None; 3] => Background::default(),
        (Some(colour), None, None, None) if image.is_none() => {
            Background::uniform(check.colour("colour", colour, RADIANCE)?)
        }
        (None, Some(zenith), Some(horizon), Some(nadir)) if image.is_none() => Background {
            zenith: check.colour("zenith", zenith, RADIANCE)?,
            horizon: check.colour("horizon", horizon, RADIANCE)?,
            nadir: check.colour("nadir", nadir, RADIANCE)?,
            alpha: 1.0,
        },
        _ => {
            let choice = "either `image`, `colour`, or `zenith`, `horizon` and `nadir`";
            return check.refuse_keys("the background", choice, entry.span());
        }
    };
    if let Some(alpha) = alpha {
        background.alpha = check.number("alpha", alpha, SHARE)? as f32;
    }
    Ok(background)
}

/// Reads the background's image, whose other keys are checked already.
fn read_environment(
    check: &Check<'_>,
    scene: &SceneEntry,
    base_dir: &Path,
) -> Checked<Option<Environment>> {
    let Some((entry, image)) = scene.background.as_ref().and_then(|entry| {
        let image = entry.as_ref().image.as_ref()?;
        Some((entry, image))
    }) else {
        return Ok(None);
    };
    let BackgroundEntry {
        yaw_degrees,
        strength,
        ..
    } = entry.as_ref();
    let image = Radiance::load(&base_dir.join(image)).map_err(|source| {
        let help = advice(Some(&source));
        let message = "the background's image cannot be loaded".to_owned();
        let fault = SceneFault::caused(message, Some(&help), source);
        check.fault(fault, Some(entry.span()))
    })?;
    Ok(Some(Environment {
        image: Arc::new(image),
        yaw: check
            .number_or("yaw_degrees", yaw_degrees, DEGREES, 0.0)?
            .to_radians(),
        strength: check.number_or("strength", strength, RADIANCE, 1.0)?,
    }))
}

fn read_path(check: &Check<'_>, entries: &[Spanned<CameraEntry>]) -> Checked<CameraPath> {
    let mut keys = Vec::with_capacity(entries.len());
    for entry in entries {
        let entry = entry.as_ref();
        let frame = match &entry.frame {
            None if entries.len() == 1 => 1,
            None => {
                let message = "a camera among others needs `frame`";
                let help = "add `frame = N`, the picture that is taken from here, counted from 1";
                return check.refuse(message, help, entry.position.span());
            }
            Some(frame) => check.whole("frame", frame, FRAMES)?,
        };
        let upright = DomeCamera::UPRIGHT;
        let position = check.numbers("position", &entry.position, POSITION)?;
        keys.push(CameraKey {
            frame,
            camera: DomeCamera {
                position: DVec3::from_array(position),
                zenith: check.vector_or("zenith", &entry.zenith, upright.zenith)?,
                top: check.vector_or("top", &entry.top, upright.top)?,
            },
        });
    }
    CameraPath::new(keys).map_err(|error| {
        let span = entries.get(error.key).map(Spanned::span);
        let fault = SceneFault::new(error.to_string(), error.help);
        check.fault(fault, span)
    })
}

fn read_mesh_source(
    check: &Check<'_>,
    name: &Spanned<String>,
    entry: &Spanned<MeshEntry>,
    base_dir: &Path,
) -> Checked<MeshSource> {
    let MeshEntry { file, builtin } = entry.as_ref();
    match (file, builtin) {
        (Some(file), None) => Ok(MeshSource::File(base_dir.join(file))),
        (None, Some(builtin)) => {
            let known = [
                ("quadruped", BuiltInMesh::Quadruped),
                ("square", BuiltInMesh::Square),
            ];
            check
                .named("built-in mesh", builtin, &known.into())
                .map(MeshSource::BuiltIn)
        }
        _ => check.refuse_keys("a mesh", "one of `file` and `builtin`", name.span()),
    }
}

/// An object whose map to the world still has to be fitted to its mesh.
struct Placed {
    object: Object,
    placement: Placement,
    /// Map of the mesh that comes before the placement.
    fit: DAffine3,
}

impl Placed {
    /// Normalises the object if its entry asks for it, and checks its texture coordinates.
    fn fit(
        &mut self,
        check: &Check<'_>,
        entry: &Spanned<ObjectEntry>,
        meshes: &[TriangleMesh],
        materials: &[Material],
    ) -> Checked<()> {
        let Shape::Mesh(mesh) = self.object.shape else {
            return Ok(());
        };
        let (mesh, object) = (&meshes[mesh], entry.as_ref());
        if let Some(normalise) = object.normalise.as_ref().filter(|on| *on.get_ref()) {
            let Some(normalisation) = Normalisation::of(mesh) else {
                let message = "the mesh is a point, so it cannot be normalised";
                let help = "leave out `normalise` and give the `scale` itself";
                return check.refuse(message, help, normalise.span());
            };
            self.object.world_from_object = self.placement.world_from_object(&normalisation);
            self.fit = normalisation.map();
        }
        let material = self.object.material.map(|number| &materials[number]);
        if mesh.has_coordinates_for(material) {
            return Ok(());
        }
        let span = object.material.as_ref();
        let span = span.map_or_else(|| entry.span(), Spanned::span);
        let message = "the object has a texture, but its mesh has no texture coordinates";
        let help = "export the mesh with coordinates (UVs), or take a material without a texture";
        check.refuse(message, help, span)
    }
}

fn read_object(
    check: &Check<'_>,
    entry: &Spanned<ObjectEntry>,
    meshes: &BTreeMap<&str, usize>,
    materials: &BTreeMap<&str, usize>,
) -> Checked<Placed> {
    let object = entry.as_ref();
    let choice = |choice| check.refuse_keys("an object", choice, entry.span());
    let length = |key, value| Ok(check.number(key, value, LENGTH)? as f32);
    let shape = match (&object.mesh, &object.sphere, &object.spheroid) {
        (Some(name), None, None) => Shape::Mesh(check.named("mesh", name, meshes)?),
        (None, Some(sphere), None) => Shape::Sphere {
            radius: length("radius", &sphere.radius)?,
        },
        (None, None, Some(spheroid)) => Shape::Spheroid {
            equatorial_radius: length("equatorial_radius", &spheroid.equatorial_radius)?,
            polar_radius: length("polar_radius", &spheroid.polar_radius)?,
        },
        _ => return choice("one of `mesh`, `sphere` and `spheroid`"),
    };
    if object.mesh.is_none() {
        let owner = "objects with a mesh";
        check.only_for(owner, "normals", &object.normals)?;
        check.only_for(owner, "normalise", &object.normalise)?;
    }
    let rotation_degrees = match (&object.yaw_degrees, &object.rotation_degrees) {
        (None, None) => [0.0; 3],
        (Some(yaw), None) => [check.number("yaw_degrees", yaw, DEGREES)?, 0.0, 0.0],
        (None, Some(rotation)) => check.numbers("rotation_degrees", rotation, DEGREES)?,
        (Some(_), Some(_)) => {
            return choice("at most one of `yaw_degrees` and `rotation_degrees`");
        }
    };
    let placement = Placement {
        position: check.vector_or("position", &object.position, DVec3::ZERO)?,
        rotation_degrees,
        scale: match &object.scale {
            None => DVec3::ONE,
            Some(scale) => {
                let factors = Spanned::new(scale.span(), scale.as_ref().0);
                DVec3::from_array(check.numbers("scale", &factors, LENGTH)?)
            }
        },
    };
    let normals = [("smooth", true), ("flat", false)].into();
    let smooth = check.name("kind of normals", &object.normals, &normals)?;
    let object = Object {
        shape,
        material: check.name("material", &object.material, materials)?,
        world_from_object: placement.world_from_object(&Normalisation::NONE),
        casts_shadow: object.casts_shadow.unwrap_or(true),
        smooth: smooth.unwrap_or(true),
    };
    let fit = DAffine3::IDENTITY;
    Ok(Placed {
        object,
        placement,
        fit,
    })
}

#[cfg(test)]
mod tests;
