//! The material libraries of OBJ files (MTL), and the images that they name.

use super::super::{ImportError, Place, Textures, bounded, bounded_colour, read, syntax, unread};
use super::three_floats;
use crate::scene::material::Material;
use crate::scene::texture::Texture;
use std::path::Path;

/// Returns what a `map_Kd` of a library names, if it is a PNG file.
pub(super) fn texture(
    textures: &mut Textures<String>,
    library: &Path,
    map: &str,
) -> Result<Option<Texture>, ImportError> {
    // Options, if any, come first.
    let name = if map.starts_with('-') {
        map.split_whitespace().last().unwrap_or_default()
    } else {
        map.trim()
    };
    let path = library.with_file_name(name.replace('\\', "/"));
    textures.get(name.to_owned(), &path, || Ok(read(&path)?.into()))
}

pub(super) fn load_library(path: &Path) -> Result<Vec<tobj::Material>, ImportError> {
    match crate::files::read(path) {
        Ok(bytes) => parse_library(path, &String::from_utf8_lossy(&bytes)),
        Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(fault) => Err(unread(path, &fault)),
    }
}

fn parse_library(path: &Path, text: &str) -> Result<Vec<tobj::Material>, ImportError> {
    for (line, number) in text.lines().zip(1..) {
        let mut words = line.split_whitespace();
        let colour = matches!(words.next(), Some("Ka" | "Kd" | "Ks" | "Ke"));
        // `tobj` panics on a colour with fewer words. It reads each line by
        // itself, so that a line which fails alone is the one at fault.
        if (colour && words.count() < 3) || tobj::load_mtl_buf(&mut line.as_bytes()).is_err() {
            let problem = format!("'{}' is no material property with its numbers", line.trim());
            let line = Some(number);
            return Err(syntax(Place { path, line }, problem));
        }
    }
    tobj::load_mtl_buf(&mut text.as_bytes())
        .map(|(materials, _)| materials)
        .map_err(|error| syntax(path, error.to_string()))
}

/// Maps a material onto Whitted's terms, as [`crate::scene::import::load`] documents.
pub(super) fn whitted(material: &tobj::Material) -> Material {
    let default = Material::default();
    let unknown = |key: &str| material.unknown_param.get(key);
    let opacity = material.dissolve.or_else(|| {
        let transparency: f32 = unknown("Tr")?.split_whitespace().next()?.parse().ok()?;
        Some(1.0 - transparency)
    });
    let illumination = material.illumination_model.unwrap_or(2);
    let refracts = matches!(illumination, 4 | 6 | 7 | 9);
    let reflects = matches!(illumination, 3 | 5 | 8);
    let opacity = opacity.unwrap_or(if refracts { 0.0 } else { 1.0 });
    let opacity = bounded(opacity, 0.0, 1.0);
    let filter = unknown("Tf")
        .and_then(|value| three_floats(value.split_whitespace()))
        .map_or([1.0; 3], bounded_colour);
    let diffuse = bounded_colour(material.diffuse.unwrap_or(default.diffuse));
    let specular = bounded_colour(material.specular.unwrap_or(default.specular));
    let shininess = material.shininess.unwrap_or(default.shininess);
    let index = material.optical_density;
    let index = index.unwrap_or(default.index_of_refraction);
    Material {
        diffuse: diffuse.map(|channel| channel * opacity),
        specular,
        shininess: bounded(shininess, 1.0, 10_000.0),
        mirror: if reflects { specular } else { default.mirror },
        transmission: filter.map(|channel| channel * (1.0 - opacity)),
        // The format's own range.
        index_of_refraction: bounded(index, 0.001, 10.0),
        ..default
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_materials_onto_whitted_terms() {
        let text = "newmtl mirror\nKd .2 .2 .2\nKs 2 1 .5\nNs 90\nillum 3\n\
                    newmtl glass\nKd 1 1 1\nNi 1.33\nillum 7\nTf .5 1 1\n\
                    newmtl veil\nKd 1 1 1\nTr 0.75\n\
                    newmtl odd\nKd nan -1 7\nNs 1e9\nd nan\n";
        let library = parse_library(Path::new("a.mtl"), text).unwrap();
        let [mirror, glass, veil, odd] = &library[..] else {
            panic!("{library:?}")
        };
        let mirror = whitted(mirror);
        assert_eq!(mirror.mirror, [1.0, 1.0, 0.5]);
        assert_eq!(mirror.shininess, 90.0);
        let glass = whitted(glass);
        assert_eq!(glass.transmission, [0.5, 1.0, 1.0]);
        assert_eq!(glass.diffuse, [0.0; 3]);
        assert_eq!(glass.index_of_refraction, 1.33);
        let veil = whitted(veil);
        assert_eq!((veil.diffuse, veil.transmission), ([0.25; 3], [0.75; 3]));
        assert_eq!(whitted(odd).diffuse, [0.0; 3]);
        assert_eq!(whitted(odd).shininess, 10_000.0);
    }

    #[test]
    fn a_broken_library_is_told_with_its_line() {
        for line in ["Kd 1 1", "Ks", "Ns x", "illum 300", "newmtl", "map_Kd"] {
            let text = format!("newmtl a\n{line}\n");
            let error = parse_library(Path::new("a.mtl"), &text).unwrap_err();
            assert!(error.to_string().starts_with("a.mtl:2: "), "{error}");
        }
    }
}
