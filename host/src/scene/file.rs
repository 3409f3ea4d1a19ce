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
//! | colours of lights and background, `ambient`, `absorption`, `emission` | 0 to 1,000,000 |
//! | `colours` of a checker | 0 to 1 |
//! | `range_nm` | 10 to 1,000,000 nm, the shorter first, without a pole, the index from 1 to 100 |
//! | `coefficients` | A and up to four pairs of B and C, −1e9 to 1e9 |
//! | `repeats` | 0.001 to 10,000 |
//! | images | PNG, up to 8,192 × 8,192 texels, all of a scene up to 512 MiB at 4 bytes a texel |
//! | radii, `scale`, `size` of a light | 0.000001 to 1,000,000 |
//! | `samples` of a light | 1 to 64 |
//! | `position`, `direction`, `up`, `zenith`, `top` | −1,000,000 to 1,000,000; a direction is not zero |
//! | `divisions` | 1 to 900 |
//! | `width_degrees` | 0.001 to 28 |
//! | `frame` | 1 to 99,999, each after the one before |
//! | rotations | −360 to 360 |
//!
//! A positive yaw turns what points to −Z towards −X, a positive pitch
//! raises it ([`Placement`]). `normals` and `normalise`
//! are for meshes only. A texture multiplies `diffuse` and `emission`; meshes
//! say in their files where they are on it, the built-in `square` is from 0 to
//! 1 along x and against z, and on spheres and spheroids u goes round with the
//! longitude and v up with the latitude. A material has an `index_of_refraction`
//! or a `medium`: one of the file's or `fused-silica`, `quartz-o`, `quartz-e`,
//! `n-bk7`, `sf11`, `diamond` or `water`. `emission` is seen, but lights
//! nothing, and a rectangle lights, but is not seen. A scene has at least one object and may have no
//! light. Meshes and materials are numbered by name in the [`Scene`],
//! objects and lights by place in the file. A key that is not described here
//! is an error, not ignored.

mod entries;
mod fault;

pub use fault::{SceneFault, SceneFileError};

use super::camera::{CameraKey, CameraPath, CameraPathError, DomeCamera};
use super::{Background, Light, Normalisation, Object, Placement, Scene, Shape};
use crate::description::{Located, Source};
use crate::mesh::{Graticule, Material, TriangleMesh};
use crate::texture::{Image, Pattern, Texture};
use entries::{
    BackgroundEntry, CameraEntry, GraticuleEntry, LightEntry, MaterialEntry, MediumEntry,
    MeshEntry, ObjectEntry, SceneEntry, TextureEntry,
};
use fault::{
    ABSORPTION, Check, DEGREES, DIVISIONS, EXPONENT, FORM, FRAMES, INDEX_OF_REFRACTION, LENGTH,
    LIGHT_SAMPLES, LINE_WIDTH, POSITION, RADIANCE, REPEATS, SHARE, WAVELENGTH,
};
use glam::DVec3;
use shisen_core::spectrum::Medium;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// Where a scene's mesh comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeshSource {
    /// A file: the path as written, from the scene file's folder.
    File(PathBuf),
    /// One that needs no file.
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
    /// Reads a scene file; `load_mesh` brings the meshes that it names.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load<E>(
        path: &Path,
        load_mesh: impl FnMut(&MeshSource) -> Result<TriangleMesh, E>,
    ) -> Result<Self, SceneFileError>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let text = crate::input::read_text(path).map_err(|source| SceneFileError::Read {
            path: path.to_owned(),
            source,
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Self::from_toml(
            &text,
            &path.to_string_lossy(),
            folder,
            load_mesh,
        )?)
    }

    /// A scene from the text of a scene file.
    ///
    /// `source_name` is what messages call the text, `base_dir` where its
    /// relative paths start. `load_mesh` is called once for each mesh, in
    /// the order of their names.
    ///
    /// # Errors
    /// The first fault found and its place: text that is not TOML, unknown
    /// or missing keys, values out of range, names that nothing has, meshes
    /// and images that cannot be loaded or used, no objects.
    pub fn from_toml<E>(
        text: &str,
        source_name: &str,
        base_dir: &Path,
        mut load_mesh: impl FnMut(&MeshSource) -> Result<TriangleMesh, E>,
    ) -> Result<Self, Located<SceneFault>>
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        let source = Source {
            name: source_name,
            text,
        };
        let entry: SceneEntry = source.parse(|message| SceneFault::Syntax { message })?;
        let check = Check { source };
        if entry.object.is_empty() {
            return Err(check.fault(SceneFault::NoObjects, None));
        }
        let material_numbers = numbers(&entry.materials);
        let mesh_numbers = numbers(&entry.meshes);
        let ambient = check.colour_or("ambient", entry.ambient.as_ref(), RADIANCE, [0.0; 3])?;
        let background = entry
            .background
            .as_ref()
            .map_or(Ok(Background::uniform([0.0; 3])), |entry| {
                read_background(&check, entry)
            })?;
        let texture_numbers = numbers(&entry.textures);
        // A file's own media come before built-in ones of the same name.
        let mut media: BTreeMap<&str, Medium> = Medium::NAMED.into();
        for (name, entry) in &entry.media {
            media.insert(name.as_ref(), read_medium(&check, name, entry.as_ref())?);
        }
        // Each with the number of its texture, if it has one.
        let mut materials = entry
            .materials
            .values()
            .map(|entry| read_material(&check, entry, &texture_numbers, &media))
            .collect::<Result<Vec<_>, _>>()?;
        let lights = entry
            .light
            .iter()
            .map(|entry| read_light(&check, entry))
            .collect::<Result<_, _>>()?;
        let camera = read_path(&check, &entry.camera)?;
        // What is written is checked before anything large is loaded.
        let mut placed = Vec::with_capacity(entry.object.len());
        for object in &entry.object {
            placed.push(read_object(
                &check,
                object,
                &mesh_numbers,
                &material_numbers,
            )?);
        }
        let textures = read_textures(&check, &entry.textures, base_dir)?;
        let materials: Vec<Material> = materials
            .drain(..)
            .map(|(material, texture)| Material {
                texture: texture.map(|number| textures[number].clone()),
                ..material
            })
            .collect();
        let meshes = entry
            .meshes
            .iter()
            .map(|(name, entry)| {
                let source = read_mesh_source(&check, name, entry, base_dir)?;
                let fault = |fault| check.fault(fault, Some(entry.span()));
                let name = || name.as_ref().clone();
                let mesh = load_mesh(&source).map_err(|error| {
                    fault(SceneFault::Mesh {
                        mesh: name(),
                        source: error.into(),
                    })
                })?;
                mesh.validate().map_err(|source| {
                    fault(SceneFault::InvalidMesh {
                        mesh: name(),
                        source,
                    })
                })?;
                Ok(mesh)
            })
            .collect::<Result<Vec<_>, _>>()?;
        for ((object, placement), entry) in placed.iter_mut().zip(&entry.object) {
            let normalisation = match (object.shape, &entry.as_ref().normalise) {
                (Shape::Mesh(mesh), Some(normalise)) if *normalise.as_ref() => {
                    Normalisation::of(&meshes[mesh])
                        .ok_or_else(|| check.fault(SceneFault::Flat, Some(normalise.span())))?
                }
                _ => Normalisation::NONE,
            };
            object.world_from_object = placement.world_from_object(&normalisation);
            let material = object.material.map(|number| &materials[number]);
            if let Shape::Mesh(mesh) = object.shape
                && !meshes[mesh].has_coordinates_for(material)
            {
                let name = entry.as_ref().material.as_ref();
                let span = name.map_or(entry.span(), Spanned::span);
                return Err(check.fault(SceneFault::NoCoordinates, Some(span)));
            }
        }
        let file_name = || {
            Path::new(source_name)
                .file_stem()
                .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
        };
        Ok(Self {
            name: entry.name.unwrap_or_else(file_name),
            meshes,
            materials,
            objects: placed.into_iter().map(|(object, _)| object).collect(),
            lights,
            background,
            ambient,
            camera,
        })
    }
}

/// What a scene file calls its materials, in their order; none where the text
/// is no scene file.
pub fn material_names(text: &str) -> Vec<String> {
    let table: Option<toml::Table> = text.parse().ok();
    let materials = table.and_then(|mut table| table.remove("materials"));
    let Some(toml::Value::Table(materials)) = materials else {
        return Vec::new();
    };
    // As `numbers` has them.
    let names: BTreeMap<_, _> = materials.into_iter().collect();
    names.into_keys().collect()
}

/// Each name's place in the order of names.
fn numbers<T>(entries: &BTreeMap<Spanned<String>, T>) -> BTreeMap<&str, usize> {
    entries
        .keys()
        .map(|name| name.as_ref().as_str())
        .zip(0..)
        .collect()
}

fn read_background(
    check: &Check<'_>,
    entry: &Spanned<BackgroundEntry>,
) -> Result<Background, Located<SceneFault>> {
    let BackgroundEntry {
        colour,
        zenith,
        horizon,
        nadir,
        alpha,
    } = entry.as_ref();
    let mut background = match (colour, zenith, horizon, nadir) {
        (Some(colour), None, None, None) => {
            Background::uniform(check.colour("colour", colour, RADIANCE)?)
        }
        (None, Some(zenith), Some(horizon), Some(nadir)) => Background {
            zenith: check.colour("zenith", zenith, RADIANCE)?,
            horizon: check.colour("horizon", horizon, RADIANCE)?,
            nadir: check.colour("nadir", nadir, RADIANCE)?,
            alpha: 1.0,
        },
        _ => {
            let fault = SceneFault::Choice {
                owner: "the background",
                choice: "either `colour`, or `zenith`, `horizon` and `nadir`",
            };
            return Err(check.fault(fault, Some(entry.span())));
        }
    };
    background.alpha = check.number_or("alpha", alpha.as_ref(), SHARE, 1.0)? as f32;
    Ok(background)
}

/// A material but for its texture, and the number of that.
fn read_material(
    check: &Check<'_>,
    entry: &MaterialEntry,
    textures: &BTreeMap<&str, usize>,
    media: &BTreeMap<&str, Medium>,
) -> Result<(Material, Option<usize>), Located<SceneFault>> {
    let default = Material::default();
    let share = |key, value: &Option<Spanned<[f64; 3]>>, default| {
        check.colour_or(key, value.as_ref(), SHARE, default)
    };
    let texture = match &entry.texture {
        None => None,
        Some(name) => Some(check.named("texture", name, textures)?),
    };
    let medium = match &entry.medium {
        None => None,
        Some(name) if entry.index_of_refraction.is_some() => {
            let fault = SceneFault::Choice {
                owner: "a material",
                choice: "at most one of `medium` and `index_of_refraction`",
            };
            return Err(check.fault(fault, Some(name.span())));
        }
        Some(name) => Some(check.named("medium", name, media)?),
    };
    let material = Material {
        diffuse: share("diffuse", &entry.diffuse, default.diffuse)?,
        specular: share("specular", &entry.specular, default.specular)?,
        shininess: check.number_or(
            "shininess",
            entry.shininess.as_ref(),
            EXPONENT,
            default.shininess.into(),
        )? as f32,
        mirror: share("mirror", &entry.mirror, default.mirror)?,
        transmission: share("transmission", &entry.transmission, default.transmission)?,
        index_of_refraction: check.number_or(
            "index_of_refraction",
            entry.index_of_refraction.as_ref(),
            INDEX_OF_REFRACTION,
            default.index_of_refraction.into(),
        )? as f32,
        absorption: check.colour_or(
            "absorption",
            entry.absorption.as_ref(),
            ABSORPTION,
            default.absorption,
        )?,
        graticule: match &entry.graticule {
            None => None,
            Some(lines) => Some(read_graticule(check, lines)?),
        },
        medium,
        texture: None,
        emission: check.colour_or(
            "emission",
            entry.emission.as_ref(),
            RADIANCE,
            default.emission,
        )?,
    };
    Ok((material, texture))
}

fn read_medium(
    check: &Check<'_>,
    name: &Spanned<String>,
    entry: &MediumEntry,
) -> Result<Medium, Located<SceneFault>> {
    let form = check.whole("form", &entry.form, FORM)?;
    let range = check
        .numbers("range_nm", &entry.range_nm, WAVELENGTH)?
        .map(|nm| nm as f32);
    let coefficients = entry.coefficients.as_ref();
    let coefficients: Vec<f32> = coefficients.iter().map(|&c| c as f32).collect();
    let terms = coefficients
        .split_first()
        .map(|(a, rest)| (*a, rest.as_chunks()));
    let Some((a, (terms, []))) = terms else {
        let found = coefficients.len();
        let fault = SceneFault::Coefficients { found };
        return Err(check.fault(fault, Some(entry.coefficients.span())));
    };
    let medium = if form == 1 {
        Medium::form1(range, a, terms)
    } else {
        Medium::form2(range, a, terms)
    };
    medium.map_err(|source| {
        let medium = name.as_ref().clone();
        check.fault(SceneFault::Medium { medium, source }, Some(name.span()))
    })
}

/// The textures in the order of their names.
fn read_textures(
    check: &Check<'_>,
    entries: &BTreeMap<Spanned<String>, Spanned<TextureEntry>>,
    base_dir: &Path,
) -> Result<Vec<Texture>, Located<SceneFault>> {
    let mut left = Image::MOST_BYTES;
    let mut textures = Vec::with_capacity(entries.len());
    for (name, entry) in entries {
        let TextureEntry {
            file,
            checker,
            repeats,
        } = entry.as_ref();
        let repeats = match repeats {
            None => [1.0; 2],
            Some(repeats) => check
                .numbers("repeats", repeats, REPEATS)?
                .map(|number| number as f32),
        };
        let pattern = match (file, checker) {
            (Some(file), None) => {
                let image = Image::load_within(&base_dir.join(file), &mut left);
                let image = image.map_err(|source| {
                    let texture = name.as_ref().clone();
                    let fault = SceneFault::Texture { texture, source };
                    check.fault(fault, Some(entry.span()))
                })?;
                Pattern::Image(Arc::new(image))
            }
            (None, Some(checker)) => {
                let [first, second] = &checker.colours;
                Pattern::Checker([
                    check.colour("colours", first, SHARE)?,
                    check.colour("colours", second, SHARE)?,
                ])
            }
            _ => {
                let fault = SceneFault::Choice {
                    owner: "a texture",
                    choice: "one of `file` and `checker`",
                };
                return Err(check.fault(fault, Some(name.span())));
            }
        };
        textures.push(Texture { pattern, repeats });
    }
    Ok(textures)
}

fn read_graticule(
    check: &Check<'_>,
    entry: &GraticuleEntry,
) -> Result<Graticule, Located<SceneFault>> {
    let GraticuleEntry {
        divisions,
        width_degrees,
    } = entry;
    let width = check.number("width_degrees", width_degrees, LINE_WIDTH)?;
    Ok(Graticule {
        divisions: check.whole("divisions", divisions, DIVISIONS)?,
        width: width.to_radians() as f32,
    })
}

fn read_path(
    check: &Check<'_>,
    entries: &[Spanned<CameraEntry>],
) -> Result<CameraPath, Located<SceneFault>> {
    let mut keys = Vec::with_capacity(entries.len());
    for entry in entries {
        let entry = entry.as_ref();
        let frame = match &entry.frame {
            None if entries.len() == 1 => 1,
            None => {
                let fault = SceneFault::CameraFrame;
                return Err(check.fault(fault, Some(entry.position.span())));
            }
            Some(frame) => check.whole("frame", frame, FRAMES)?,
        };
        let upright = DomeCamera::UPRIGHT;
        let position = check.numbers("position", &entry.position, POSITION)?;
        keys.push(CameraKey {
            frame,
            camera: DomeCamera {
                position: DVec3::from_array(position),
                zenith: check.vector_or("zenith", entry.zenith.as_ref(), upright.zenith)?,
                top: check.vector_or("top", entry.top.as_ref(), upright.top)?,
            },
        });
    }
    CameraPath::new(keys).map_err(|error| {
        let (number, fault) = match error {
            CameraPathError::Order { key } => (key, SceneFault::CameraOrder),
            CameraPathError::Direction { key } => (key, SceneFault::CameraDirection),
            CameraPathError::Turn { key } => (key, SceneFault::CameraTurn),
        };
        check.fault(fault, entries.get(number).map(Spanned::span))
    })
}

fn read_mesh_source(
    check: &Check<'_>,
    name: &Spanned<String>,
    entry: &Spanned<MeshEntry>,
    base_dir: &Path,
) -> Result<MeshSource, Located<SceneFault>> {
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
        _ => {
            let fault = SceneFault::Choice {
                owner: "a mesh",
                choice: "one of `file` and `builtin`",
            };
            Err(check.fault(fault, Some(name.span())))
        }
    }
}

/// An object but for its map to the world, which its mesh has a part in.
fn read_object(
    check: &Check<'_>,
    entry: &Spanned<ObjectEntry>,
    meshes: &BTreeMap<&str, usize>,
    materials: &BTreeMap<&str, usize>,
) -> Result<(Object, Placement), Located<SceneFault>> {
    let object = entry.as_ref();
    let choice = |choice| {
        let owner = "an object";
        check.fault(SceneFault::Choice { owner, choice }, Some(entry.span()))
    };
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
        _ => return Err(choice("one of `mesh`, `sphere` and `spheroid`")),
    };
    if object.mesh.is_none() {
        let spans = [
            ("normals", object.normals.as_ref().map(Spanned::span)),
            ("normalise", object.normalise.as_ref().map(Spanned::span)),
        ];
        for (key, span) in spans {
            if span.is_some() {
                let owner = "objects with a mesh";
                return Err(check.fault(SceneFault::NotHere { key, owner }, span));
            }
        }
    }
    let rotation_degrees = match (&object.yaw_degrees, &object.rotation_degrees) {
        (None, None) => [0.0; 3],
        (Some(yaw), None) => [check.number("yaw_degrees", yaw, DEGREES)?, 0.0, 0.0],
        (None, Some(rotation)) => check.numbers("rotation_degrees", rotation, DEGREES)?,
        (Some(_), Some(_)) => {
            return Err(choice(
                "at most one of `yaw_degrees` and `rotation_degrees`",
            ));
        }
    };
    let placement = Placement {
        position: check.vector_or("position", object.position.as_ref(), DVec3::ZERO)?,
        rotation_degrees,
        scale: match &object.scale {
            None => DVec3::ONE,
            Some(scale) => {
                let factors = Spanned::new(scale.span(), scale.as_ref().0);
                DVec3::from_array(check.numbers("scale", &factors, LENGTH)?)
            }
        },
    };
    let smooth = match &object.normals {
        None => true,
        Some(normals) => {
            let known = [("smooth", true), ("flat", false)];
            check.named("kind of normals", normals, &known.into())?
        }
    };
    let material = match &object.material {
        None => None,
        Some(name) => Some(check.named("material", name, materials)?),
    };
    let object = Object {
        shape,
        material,
        world_from_object: placement.world_from_object(&Normalisation::NONE),
        casts_shadow: object.casts_shadow.unwrap_or(true),
        smooth,
    };
    Ok((object, placement))
}

/// The types of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LightKind {
    Point,
    Directional,
    Rectangle,
}

fn read_light(
    check: &Check<'_>,
    entry: &Spanned<LightEntry>,
) -> Result<Light, Located<SceneFault>> {
    use LightKind::{Directional, Point, Rectangle};

    let light = entry.as_ref();
    let colour = check.colour_or("colour", light.colour.as_ref(), RADIANCE, [1.0; 3])?;
    let kind = check.named(
        "type of light",
        &light.kind,
        &[
            ("point", Point),
            ("directional", Directional),
            ("rectangle", Rectangle),
        ]
        .into(),
    )?;
    let not_point = "directional lights and rectangles";
    let not_directional = "point lights and rectangles";
    let large = "rectangles";
    let flag = |on: &Option<Spanned<bool>>| on.as_ref().map(Spanned::span);
    let keys: &[(_, _, &[LightKind], _)] = &[
        (
            "position",
            light.position.as_ref().map(Spanned::span),
            &[Point, Rectangle],
            not_directional,
        ),
        (
            "direction",
            light.direction.as_ref().map(Spanned::span),
            &[Directional, Rectangle],
            not_point,
        ),
        (
            "inverse_square",
            flag(&light.inverse_square),
            &[Point],
            "point lights",
        ),
        (
            "size",
            light.size.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        (
            "up",
            light.up.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        (
            "samples",
            light.samples.as_ref().map(Spanned::span),
            &[Rectangle],
            large,
        ),
        ("two_sided", flag(&light.two_sided), &[Rectangle], large),
    ];
    for (key, span, kinds, owner) in keys {
        if span.is_some() && !kinds.contains(&kind) {
            return Err(check.fault(SceneFault::NotHere { key, owner }, span.clone()));
        }
    }
    let missing = |owner, key, example| {
        let fault = SceneFault::Missing {
            owner,
            key,
            example,
        };
        check.fault(fault, Some(light.kind.span()))
    };
    let owner = match kind {
        Point => "a point light",
        Directional => "a directional light",
        Rectangle => "a rectangle",
    };
    let vector = |key, written: &Option<Spanned<[f64; 3]>>| {
        let written = written
            .as_ref()
            .ok_or_else(|| missing(owner, key, "[x, y, z]"))?;
        let vector = check.numbers(key, written, POSITION)?;
        Ok((DVec3::from_array(vector), written.span()))
    };
    let direction = || {
        let (direction, span) = vector("direction", &light.direction)?;
        if direction == DVec3::ZERO {
            return Err(check.fault(SceneFault::ZeroDirection, Some(span)));
        }
        Ok(direction)
    };
    match kind {
        Point => Ok(Light::Point {
            position: vector("position", &light.position)?.0,
            colour,
            inverse_square: light.inverse_square.as_ref().is_some_and(|on| *on.as_ref()),
        }),
        Directional => Ok(Light::Directional {
            direction: direction()?,
            colour,
        }),
        Rectangle => {
            let size = light.size.as_ref();
            let size = size.ok_or_else(|| missing(owner, "size", "[width, height]"))?;
            let [width, height] = check.numbers("size", size, LENGTH)?;
            let forward = direction()?.normalize();
            let right = match &light.up {
                Some(up) => {
                    let vector = DVec3::from_array(check.numbers("up", up, POSITION)?);
                    let right = forward.cross(vector.normalize_or_zero());
                    // A ten-thousandth of a degree.
                    if right.length() < 2e-6 {
                        return Err(check.fault(SceneFault::LightUp, Some(up.span())));
                    }
                    right
                }
                // As for lines of sight: straight up or down, it is +X.
                None if forward.y.abs() > 1.0 - 1e-12 => DVec3::X,
                None => forward.cross(DVec3::Y),
            };
            // Seen from where it shines, left and right change places.
            let right = -right.normalize();
            Ok(Light::Rectangle {
                centre: vector("position", &light.position)?.0,
                right: right * (0.5 * width),
                up: forward.cross(right) * (0.5 * height),
                colour,
                samples: match &light.samples {
                    None => DEFAULT_LIGHT_SAMPLES,
                    Some(samples) => check.whole("samples", samples, LIGHT_SAMPLES)?,
                },
                two_sided: light.two_sided.as_ref().is_some_and(|on| *on.as_ref()),
            })
        }
    }
}

/// Points of a rectangle that are looked at where nothing else is asked for.
const DEFAULT_LIGHT_SAMPLES: u32 = 16;

#[cfg(test)]
mod tests;
