//! The JSON of a glTF file, without what is wrong in it and no geometry.

use crate::scene::import::{ImportError, Unused, fault, syntax};
use gltf::{Document, json};
use json::mesh::Semantic;
use json::validation::{Checked, Error, Validate as _};
use serde_json::Value;
use std::path::Path;

/// Most rounds of leaving out what is wrong: a part without another may be wrong, too.
const MOST_ROUNDS: usize = 64;

/// Extensions that are carried out, or counted where they are used.
const KNOWN: &str = "EXT_mesh_gpu_instancing EXT_meshopt_compression EXT_texture_avif \
    EXT_texture_webp KHR_animation_pointer KHR_draco_mesh_compression KHR_lights_punctual \
    KHR_materials_anisotropy KHR_materials_clearcoat KHR_materials_diffuse_transmission \
    KHR_materials_dispersion KHR_materials_emissive_strength KHR_materials_ior \
    KHR_materials_iridescence KHR_materials_pbrSpecularGlossiness KHR_materials_sheen \
    KHR_materials_specular KHR_materials_transmission KHR_materials_unlit KHR_materials_variants \
    KHR_materials_volume KHR_mesh_quantization KHR_meshopt_compression KHR_node_visibility \
    KHR_texture_basisu KHR_texture_transform KHR_xmp KHR_xmp_json_ld MSFT_texture_dds";

/// Tables, and parts of others, that geometry does without.
const DISPENSABLE: &str = "animations camera cameras extensions images light material materials mesh name \
    samplers scene scenes skin target textures";

/// Returns whether a name is one of several with blanks between.
fn is_among(names: &str, name: &str) -> bool {
    names.split(' ').any(|one| one == name)
}

/// Reads a description; what it says wrongly of other things than geometry is not used.
pub(super) fn read(path: &Path, json: &[u8], unused: &mut Unused) -> Result<Document, ImportError> {
    let wrong = |error: &str| syntax(path, format!("not a valid glTF 2.0 file: {error}"));
    let mut value: Value =
        serde_json::from_slice(json).map_err(|error| wrong(&error.to_string()))?;
    if let Some(version) = value["asset"]["version"].as_str()
        && !version.starts_with("2.")
    {
        return Err(outdated(path, version));
    }
    let named = |table: &str| value[table].as_array().into_iter().flatten();
    let names = |table| named(table).filter_map(Value::as_str);
    if names("extensionsRequired").any(|name| name == "KHR_draco_mesh_compression") {
        let problem = "it is compressed with Draco, which is not read";
        return Err(fault(path, problem, "export it without, or with meshopt"));
    }
    for name in names("extensionsUsed").filter(|name| !is_among(KNOWN, name)) {
        unused.add(format!("the extension {name}"), 1);
    }
    strip(&mut value, unused);
    for _ in 0..MOST_ROUNDS {
        let faults = match checked(&value) {
            Ok(root) => return Ok(Document::from_json_without_validation(root)),
            Err(faults) => faults,
        };
        // From the last: numbers of parts before stay.
        let mut left_out = faults.clone();
        left_out.reverse();
        left_out.retain(|(place, _)| leave_out(&mut value, place));
        if left_out.is_empty() {
            let (place, error) = &faults[0];
            return Err(wrong(&format!("{place}: {error}")));
        }
        for (place, error) in left_out.into_iter().rev() {
            unused.add(format!("{place} ({error})"), 1);
        }
    }
    Err(wrong("it has too many faults"))
}

/// Returns the error of a file of another glTF, whose tables are others.
pub(super) fn outdated(path: &Path, version: &str) -> ImportError {
    let problem = format!("this is glTF {version}, but glTF 2.0 is needed");
    fault(path, problem, "export the mesh again as glTF 2.0")
}

/// Removes what applications add for themselves, animations of what is no node, and attributes of
/// unknown names.
fn strip(value: &mut Value, unused: &mut Unused) {
    let nodes = value["nodes"].as_array().map_or(0, Vec::len) as u64;
    let animations = value.get_mut("animations").and_then(Value::as_array_mut);
    for animation in animations.into_iter().flatten() {
        let Some(Value::Array(channels)) = animation.get_mut("channels") else {
            continue;
        };
        let all = channels.len();
        channels.retain(|channel| {
            let target = &channel["target"];
            let path = target["path"].as_str().unwrap_or_default();
            let is_known = is_among("translation rotation scale weights", path);
            is_known && target["node"].as_u64().is_some_and(|node| node < nodes)
        });
        let left_out = all - channels.len();
        let kind = "animation channel{s} of unknown nodes or properties";
        unused.add(kind, left_out as u64);
    }
    let scenes = value.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene
                .entry("nodes")
                .or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let meshes = value.get_mut("meshes").and_then(Value::as_array_mut);
    for mesh in meshes.into_iter().flatten() {
        let primitives = mesh.get_mut("primitives").and_then(Value::as_array_mut);
        for primitive in primitives.into_iter().flatten() {
            let Some(Value::Object(attributes)) = primitive.get_mut("attributes") else {
                continue;
            };
            attributes.retain(|name, _| {
                let known = serde_json::from_value(name.as_str().into());
                let is_known = matches!(known, Ok(Checked::<Semantic>::Valid(_)));
                let is_told = !is_known && !name.starts_with('_');
                unused.add(format!("the attribute {name}"), u64::from(is_told));
                is_known
            });
        }
    }
    let mut open = vec![value];
    while let Some(value) = open.pop() {
        match value {
            Value::Array(items) => open.extend(items),
            Value::Object(members) => {
                members.remove("extras");
                open.extend(members.values_mut());
            }
            _ => {}
        }
    }
}

/// Returns the tables of a description, or the places of faults, and what is wrong.
fn checked(value: &Value) -> Result<json::Root, Vec<(String, String)>> {
    let root: json::Root = serde_path_to_error::deserialize(value)
        .map_err(|error| vec![(error.path().to_string(), error.inner().to_string())])?;
    // The validator looks positions up before it has checked their index.
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let accessors = root.accessors.len();
    if primitives.any(|p| p.attributes.values().any(|i| i.value() >= accessors)) {
        let problem = "a primitive names an accessor that is not among the file's";
        return Err(vec![(
            "meshes".to_owned(),
            format!("{problem} {accessors}"),
        )]);
    }
    let mut faults = Vec::new();
    root.validate(&root, json::Path::new, &mut |place, error| {
        let place = place().to_string();
        // Bounds are not needed; accessors without a view are zero, and primitives without
        // positions are not drawn; geometry does without what other extensions change.
        let field = place.rsplit('.').next();
        let is_needed = !matches!(field, Some("min" | "max")) && error != Error::Unsupported;
        let is_absent = error == Error::Missing
            && (field == Some("bufferView") || place.contains("primitives"));
        if is_needed && !is_absent {
            faults.push((place, error.to_string()));
        }
    });
    faults.dedup();
    if faults.is_empty() {
        return Ok(root);
    }
    Err(faults)
}

/// Removes a faulty part, or puts an empty one in its place; false for parts that geometry needs.
fn leave_out(value: &mut Value, place: &str) -> bool {
    let parts = place
        .split(['.', '['])
        .map(|part| part.trim_end_matches(']'));
    let mut parts: Vec<&str> = parts.collect();
    // An animation goes as a whole.
    if parts[0] == "animations" {
        parts.truncate(2);
    }
    // A reference to a texture is more than its index.
    if parts.last() == Some(&"index") {
        parts.pop();
    }
    let Some((last, parents)) = parts.split_last() else {
        return false;
    };
    let is_geometry = is_among("accessors bufferViews buffers", parts[0]);
    if is_geometry && !is_among("name target", last)
        || !parts.iter().any(|part| is_among(DISPENSABLE, part))
    {
        return false;
    }
    let mut at = value;
    for part in parents {
        let next = match at {
            Value::Array(items) => part.parse().ok().and_then(|n: usize| items.get_mut(n)),
            Value::Object(members) => {
                let mut all = members.iter_mut();
                all.find_map(|(name, member)| is_called(name, part).then_some(member))
            }
            _ => None,
        };
        let Some(next) = next else { return false };
        at = next;
    }
    match at {
        Value::Object(members) => {
            let count = members.len();
            members.retain(|name, _| !is_called(name, last));
            members.len() < count
        }
        Value::Array(items) => {
            let Some(item) = last.parse().ok().and_then(|n: usize| items.get_mut(n)) else {
                return false;
            };
            // Others count on their numbers.
            let empty = match parents.last() {
                Some(&"cameras") => {
                    serde_json::json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}})
                }
                Some(&"lights") => serde_json::json!({"type": "point", "intensity": 0}),
                Some(&"animations") => serde_json::json!({"channels": [], "samplers": []}),
                Some(&"scenes") => serde_json::json!({"nodes": []}),
                Some(&"nodes") => {
                    let number = last.parse().unwrap_or(0);
                    items.remove(number);
                    return true;
                }
                _ => serde_json::json!({}),
            };
            *item != empty && {
                *item = empty;
                true
            }
        }
        _ => false,
    }
}

/// Returns whether the validator calls a member so: it writes `khrLightsPunctual`.
fn is_called(name: &str, part: &str) -> bool {
    name == part || name.replace('_', "").eq_ignore_ascii_case(part)
}
