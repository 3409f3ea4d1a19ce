//! The material libraries of OBJ files (MTL), and the images that they name.

use super::super::{
    NOT_THERE, Textures, Unused, beside, bounded, bounded_colour, is_utf16, read_one_within,
    three_floats, without_comment,
};
use crate::files::MOST_OF_TEXT;
use crate::scene::material::{Alpha, Cover, Material, Microfacets};
use crate::scene::texture::{Pattern, Texture, Wrap};
use palette::{IntoColor as _, LinSrgb, Xyz};
use std::path::{Path, PathBuf};

/// A material with what its statements say of its texture.
pub(super) struct Described {
    pub(super) material: Material,
    pub(super) texture: Option<Map>,
    pub(super) emission_texture: Option<Map>,
    pub(super) normal_texture: Option<Map>,
    /// Its opacity.
    pub(super) alpha_texture: Option<Map>,
}

/// An image that a statement names, with its options.
#[derive(Clone)]
pub(super) struct Map {
    name: String,
    repeats: [f32; 2],
    origin: [f32; 2],
    clamps: bool,
}

impl Map {
    /// Returns the image on the surface, if it can be read: where its name says, else beside the
    /// library.
    pub(super) fn read(
        &self,
        library: &Path,
        textures: &mut Textures<String>,
        unused: &mut Unused,
    ) -> Option<Texture> {
        let image = textures.beside(library, &self.name, unused)?;
        let plain = Texture::new(Pattern::Image(image), self.repeats);
        let [across, up, _] = plain.map;
        Some(Texture {
            map: [across, up, self.origin],
            wrap: [if self.clamps {
                Wrap::Clamp
            } else {
                Wrap::Repeat
            }; 2],
            ..plain
        })
    }
}

/// Reads the libraries that `mtllib` statements name: each is one name, which may have blanks, or
/// several. Returns them in order, with their paths.
pub(super) fn read_all(
    path: &Path,
    statements: &[String],
    unused: &mut Unused,
) -> Vec<(PathBuf, String)> {
    let mut libraries = Vec::new();
    let mut read = |name: &str| {
        let paths = beside(path, name.trim_matches('"'));
        let bytes = read_one_within(&paths, MOST_OF_TEXT)?;
        if is_utf16(&bytes) {
            return Err("which is text in UTF-16: save it as UTF-8".to_owned());
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let found = paths.iter().find(|path| path.is_file());
        libraries.push((found.unwrap_or(&paths[0]).clone(), text));
        Ok(())
    };
    for statement in statements {
        let names: Vec<&str> = match read(statement) {
            Ok(()) => continue,
            Err(reason) if reason == NOT_THERE => statement.split_whitespace().collect(),
            Err(_) => vec![statement],
        };
        for name in names {
            if let Err::<(), String>(reason) = read(name) {
                unused.add(format!("the material library {name} ({reason})"), 1);
            }
        }
    }
    libraries
}

/// Reads a library. What is not legible counts as not there.
pub(super) fn parse(text: &str, unused: &mut Unused) -> Vec<Described> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut statements: Vec<Statements<'_>> = Vec::new();
    for line in text.lines() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = without_comment(rest);
        if keyword == "newmtl" {
            statements.push(Statements {
                name: rest,
                ..Statements::default()
            });
        } else if let Some(last) = statements.last_mut()
            && !keyword.starts_with('#')
            && !keyword.is_empty()
        {
            last.read(keyword, rest, unused);
        }
    }
    statements.iter().map(Statements::described).collect()
}

/// What a library says of a material.
#[derive(Default)]
struct Statements<'t> {
    name: &'t str,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    filter: Option<[f32; 3]>,
    shininess: Option<f32>,
    index: Option<f32>,
    dissolve: Option<f32>,
    transparency: Option<f32>,
    illumination: Option<f32>,
    map: Option<Map>,
    emission_map: Option<Map>,
    normal_map: Option<Map>,
    alpha_map: Option<Map>,
    metalness: Option<f32>,
    roughness: Option<f32>,
}

impl<'t> Statements<'t> {
    fn read(&mut self, keyword: &str, rest: &'t str, unused: &mut Unused) {
        let legible = |word: &str| word.parse().ok().filter(|number: &f32| !number.is_nan());
        let number = || legible(rest.split_whitespace().next()?);
        let is_legible = match keyword.to_ascii_lowercase().as_str() {
            "kd" => set(&mut self.diffuse, colour(rest)),
            "ks" => set(&mut self.specular, colour(rest)),
            "ke" => set(&mut self.emission, colour(rest)),
            "tf" => set(&mut self.filter, colour(rest)),
            "ns" => set(&mut self.shininess, number()),
            "ni" => set(&mut self.index, number()),
            "tr" => set(&mut self.transparency, number()),
            "illum" => set(&mut self.illumination, number()),
            "d" => {
                let rest = rest.strip_prefix("-halo").unwrap_or(rest);
                set(&mut self.dissolve, legible(rest.trim()))
            }
            "map_kd" => set(&mut self.map, map(rest)),
            "map_ke" => set(&mut self.emission_map, map(rest)),
            "norm" => set(&mut self.normal_map, map(rest)),
            "map_d" => set(&mut self.alpha_map, map(rest)),
            "pm" => set(&mut self.metalness, number()),
            "pr" => set(&mut self.roughness, number()),
            // The scene has its own ambient light, and samples as asked.
            "ka" | "map_ka" | "sharpness" | "map_aat" => true,
            _ => false,
        };
        if !is_legible {
            unused.add(format!("line{{s}} of {keyword}"), 1);
        }
    }

    /// Maps the material onto Whitted's terms, as [`crate::scene::import::load`] documents.
    fn described(&self) -> Described {
        let default = Material::default();
        let illumination = self.illumination.unwrap_or(2.0);
        let refracts = [4.0, 6.0, 7.0, 9.0].contains(&illumination);
        let reflects = [3.0, 5.0, 8.0].contains(&illumination);
        let opacity = self.dissolve.or(self.transparency.map(|share| 1.0 - share));
        let opacity = opacity.unwrap_or(if refracts { 0.0 } else { 1.0 });
        let opacity = bounded(opacity, 0.0, 1.0);
        let alpha = self.alpha_map.as_ref().map(|_| Alpha {
            opacity,
            texture: None,
            cover: Cover::Blend,
        });
        // A map says it from place to place.
        let opacity = if alpha.is_some() { 1.0 } else { opacity };
        let filter = self.filter.map_or([1.0; 3], bounded_colour);
        // A picture without a colour is shown as it is.
        let plain = self.map.as_ref().map_or(default.diffuse, |_| [1.0; 3]);
        let diffuse = bounded_colour(self.diffuse.unwrap_or(plain));
        // 0 and 1 have no highlights.
        let specular = match illumination {
            ..2.0 => [0.0; 3],
            _ => bounded_colour(self.specular.unwrap_or(default.specular)),
        };
        let shininess = self.shininess.unwrap_or(default.shininess);
        let index = match self.index {
            Some(index) if opacity < 1.0 && index > 0.0 => bounded(index, 0.01, 100.0),
            // Exporters write 0 for what does not bend light.
            Some(_) if opacity < 1.0 => 1.0,
            _ => default.index_of_refraction,
        };
        let (transmission, index) = match alpha {
            Some(_) => ([1.0; 3], 1.0),
            None => (filter.map(|channel| channel * (1.0 - opacity)), index),
        };
        let microfacets = (self.metalness.or(self.roughness)).map(|_| Microfacets {
            metalness: bounded(self.metalness.unwrap_or(0.0), 0.0, 1.0),
            roughness: bounded(self.roughness.unwrap_or(0.5), 0.0, 1.0),
            texture: None,
        });
        // Dielectrics reflect about 4 % head-on.
        let specular = microfacets.as_ref().map_or(specular, |_| [0.04; 3]);
        let shines = self.emission_map.as_ref().map_or([0.0; 3], |_| [1.0; 3]);
        let emission = self.emission.unwrap_or(shines);
        let material = Material {
            name: self.name.to_owned(),
            diffuse: diffuse.map(|channel| channel * opacity),
            specular,
            shininess: bounded(shininess, 1.0, 10_000.0),
            mirror: if reflects { specular } else { default.mirror },
            transmission,
            alpha,
            microfacets,
            index_of_refraction: index,
            emission: emission.map(|channel| bounded(channel, 0.0, 1.0e6)),
            ..default
        };
        Described {
            material,
            texture: self.map.clone(),
            emission_texture: self.emission_map.clone(),
            normal_texture: self.normal_map.clone(),
            alpha_texture: self.alpha_map.clone(),
        }
    }
}

/// Sets what a statement says; returns whether it says something.
fn set<T>(slot: &mut Option<T>, value: Option<T>) -> bool {
    let is_legible = value.is_some();
    *slot = value.or(slot.take());
    is_legible
}

/// Reads red, green and blue; red alone, which is all three; or `xyz` and CIE's coordinates.
fn colour(rest: &str) -> Option<[f32; 3]> {
    if let Some(rest) = rest.strip_prefix("xyz") {
        let [x, y, z] = three_floats(rest.split_whitespace())?;
        let linear: LinSrgb = Xyz::new(x, y, z).into_color();
        return Some(linear.into());
    }
    let first = rest.split_whitespace().next()?.parse().ok()?;
    Some(three_floats(rest.split_whitespace()).unwrap_or([first; 3]))
}

/// Reads the options and the name of an image.
fn map(rest: &str) -> Option<Map> {
    let mut map = Map {
        name: String::new(),
        repeats: [1.0; 2],
        origin: [0.0; 2],
        clamps: false,
    };
    let mut rest = rest.trim();
    while rest.starts_with('-') {
        let (option, after) = rest.split_once(char::is_whitespace)?;
        rest = after.trim_start();
        let most = match option {
            "-o" | "-s" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        for place in 0..most {
            // -o, -s and -t take one to three numbers.
            let may_end = most == 3 && place > 0;
            let Some((word, after)) = rest.split_once(char::is_whitespace) else {
                if may_end {
                    break;
                }
                return None;
            };
            let number = word.parse::<f32>().ok();
            if number.is_none() && may_end {
                break;
            }
            match (option, place) {
                ("-s", 0 | 1) => map.repeats[place] = bounded(number?, -1.0e4, 1.0e4),
                ("-o", 0 | 1) => map.origin[place] = bounded(number?, -1.0e4, 1.0e4),
                ("-clamp", _) => map.clamps = word == "on",
                _ => {}
            }
            rest = after.trim_start();
        }
    }
    rest.trim_matches('"').clone_into(&mut map.name);
    (!rest.is_empty()).then_some(map)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(text: &str) -> (Vec<Described>, Vec<String>) {
        let mut unused = Unused::default();
        let all = parse(text, &mut unused);
        (all, unused.names())
    }

    #[test]
    fn maps_materials_onto_whitted_terms() {
        let text = "\u{feff}newmtl mirror\nKd .2 .2 .2\nKs 2 1 .5 # shiny\nNs 90\nillum 3\n\
                    newmtl glass\nKd 1 1 1\nNi 1.33\nillum 7\nTf .5 1 1\n\
                    newmtl veil\nKd 1\nTr 0.75\nNi 0\nKe 3 0 0\n\
                    newmtl odd\nKd nan -1 7\nNs 1e9\nd nan\n\
                    newmtl plain\nNi 0\nd -halo 1\nKs 1\nillum 1\n";
        let (library, unused) = described(text);
        let library: Vec<Material> = library.into_iter().map(|one| one.material).collect();
        let [mirror, glass, veil, odd, plain] = &library[..] else {
            panic!("{library:?}")
        };
        assert_eq!((mirror.mirror, mirror.shininess), ([1.0, 1.0, 0.5], 90.0));
        assert_eq!(mirror.name, "mirror");
        assert_eq!(glass.transmission, [0.5, 1.0, 1.0]);
        assert_eq!(glass.diffuse, [0.0; 3]);
        assert_eq!(glass.index_of_refraction, 1.33);
        assert_eq!((veil.diffuse, veil.transmission), ([0.25; 3], [0.75; 3]));
        assert_eq!((veil.index_of_refraction, veil.emission[0]), (1.0, 3.0));
        assert_eq!((odd.diffuse, odd.shininess), ([0.0, 0.0, 1.0], 10_000.0));
        assert_eq!(
            (plain.index_of_refraction, plain.transmission),
            (1.5, [0.0; 3])
        );
        assert_eq!(plain.specular, [0.0; 3]);
        assert_eq!(unused, ["1 line of d"]);
    }

    #[test]
    fn what_is_odd_is_told_and_refuses_nothing() {
        let text = "newmtl a\nKd\nNs x\nillum 300\nmap_Kd\nbump a.png\nbump b.png\nKd 0.5\n\
                    Kd spectral a.rfl 1\nKs xyz 0.9505 1 1.089\n";
        let (library, unused) = described(text);
        let material = &library[0].material;
        assert_eq!(material.diffuse, [0.5; 3]);
        assert!(
            material.specular.iter().all(|c| (c - 1.0).abs() < 1.0e-3),
            "{material:?}"
        );
        let lines = [
            "2 lines of Kd",
            "1 line of Ns",
            "1 line of map_Kd",
            "2 lines of bump",
        ];
        assert_eq!(unused, lines);
    }

    #[test]
    fn options_come_before_the_name_of_an_image() {
        for (line, name, repeats, origin) in [
            ("my wood.png", "my wood.png", [1.0; 2], [0.0; 2]),
            ("\"a.png\" # new", "a.png", [1.0; 2], [0.0; 2]),
            ("-s 2 a.png", "a.png", [2.0, 1.0], [0.0; 2]),
            (
                "-s 2 3 1 -o 0.5 -clamp on -mm 0 1 -bm 2 a b.png",
                "a b.png",
                [2.0, 3.0],
                [0.5, 0.0],
            ),
        ] {
            let read = map(without_comment(line)).unwrap();
            assert_eq!(read.name, name);
            assert_eq!((read.repeats, read.origin), (repeats, origin), "{line}");
            assert_eq!(read.clamps, line.contains("-clamp"));
        }
        for line in ["", "-s", "-clamp on"] {
            assert!(map(line).is_none(), "{line}");
        }
    }
}
