//! PLY, ASCII and binary.

use super::number::{Number, parsed};
use super::polygon::{Faces, split};
use super::{ImportError, Model, Place, Textures, Unused, claim, decoded, fault, finished, syntax};
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::texture::{Pattern, Texture};
use std::path::Path;

/// Names of texture coordinates: across, and up.
const COORDINATES: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

/// Names of the list of a face's corners.
const CORNER_LISTS: [&str; 2] = ["vertex_indices", "vertex_index"];

struct Property {
    name: String,
    /// The type of a list's length, if it is a list.
    length: Option<Number>,
    number: Number,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// Returns the place of the first property of a name.
    fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|one| one.name == name)
    }

    /// Returns the places of scalars, if they are all there.
    fn scalars<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = self.find(name)?;
            if self.properties[*place].length.is_some() {
                return None;
            }
        }
        Some(places)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Bytes before the numbers.
    length: usize,
    /// Names of files with textures.
    textures: Vec<String>,
}

impl Header {
    // Longer than 80 lines: an arm for each statement.
    fn read(path: &Path, bytes: &[u8]) -> Result<Self, ImportError> {
        let mut header = Self {
            encoding: Encoding::Ascii,
            elements: Vec::new(),
            length: 0,
            textures: Vec::new(),
        };
        let mut is_named = false;
        for line in 1.. {
            let at = Place {
                path,
                line: Some(line),
            };
            let rest = &bytes[header.length..];
            let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
                let problem = "not a whole PLY file: the header has no end_header";
                return Err(syntax(at, problem));
            };
            header.length += end + 1;
            let text = String::from_utf8_lossy(&rest[..end]);
            let words: Vec<&str> = text.split_whitespace().collect();
            let problem = match (line, words.as_slice()) {
                (1, ["ply"]) => continue,
                (1, _) => "not a PLY file: it does not begin with 'ply'",
                (_, ["end_header"]) if is_named => return Ok(header),
                (_, ["end_header"]) => "the header names no format",
                (_, ["comment", "TextureFile", ..]) => {
                    let name = text.split_once("TextureFile").map(|(_, name)| name.trim());
                    header.textures.extend(name.map(str::to_owned));
                    continue;
                }
                (_, [] | ["comment" | "obj_info", ..]) => continue,
                (_, ["format", name, "1.0"]) => {
                    is_named = true;
                    header.encoding = match *name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(syntax(at, format!("'{name}' is no format of PLY"))),
                    };
                    continue;
                }
                (_, ["element", name, count]) => match count.parse() {
                    Ok(count) => {
                        header.elements.push(Element {
                            name: (*name).to_owned(),
                            count,
                            properties: Vec::new(),
                        });
                        continue;
                    }
                    Err(_) => "an element needs a name and a count",
                },
                (_, ["property", types @ .., name]) => {
                    let property = match types {
                        ["list", length, number] => {
                            let length = Number::named(length).filter(|length| length.is_whole());
                            length.zip(Number::named(number)).map(|(l, n)| (Some(l), n))
                        }
                        [number] => Number::named(number).map(|number| (None, number)),
                        _ => None,
                    };
                    match (header.elements.last_mut(), property) {
                        (Some(element), Some((length, number))) => {
                            element.properties.push(Property {
                                name: (*name).to_owned(),
                                length,
                                number,
                            });
                            continue;
                        }
                        (None, _) => "a property comes before any element",
                        (_, None) => "a property needs a type and a name",
                    }
                }
                _ => "not a statement of a PLY header",
            };
            return Err(syntax(at, problem));
        }
        Err(syntax(path, "the header is too long"))
    }

    /// Refuses counts that the numbers cannot be enough for, before anything is allocated by them.
    fn check(&self, path: &Path, available: usize) -> Result<(), ImportError> {
        let mut claimed = 0;
        for Element {
            name,
            count,
            properties,
        } in &self.elements
        {
            let least = properties.iter().map(|property| match self.encoding {
                // A digit and a blank or a line break.
                Encoding::Ascii => 2,
                _ => property.length.unwrap_or(property.number).size(),
            });
            let least = least.sum::<usize>().max(1);
            claimed += u128::from(*count) * least as u128;
            // The last line may lack its break.
            if claimed > available as u128 + 1 {
                let what = format!("the header's element count of {count} for '{name}'");
                return Err(claim(path, &what, claimed, available));
            }
        }
        Ok(())
    }
}

/// The numbers after a header, one after another.
struct Numbers<'b> {
    path: &'b Path,
    bytes: &'b [u8],
    at: usize,
    encoding: Encoding,
}

impl<'b> Numbers<'b> {
    fn fault(&self, problem: impl AsRef<str>) -> ImportError {
        let line = self.bytes[..self.at].split(|byte| *byte == b'\n').count();
        let line = (self.encoding == Encoding::Ascii).then_some(line);
        let path = self.path;
        syntax(Place { path, line }, problem)
    }

    fn word(&mut self) -> Result<&'b [u8], ImportError> {
        let blanks = self.bytes[self.at..].iter();
        self.at += blanks.take_while(|byte| byte.is_ascii_whitespace()).count();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace());
        let word = &rest[..length.count()];
        if word.is_empty() {
            return Err(self.fault("the file is cut off: numbers are missing at its end"));
        }
        self.at += word.len();
        Ok(word)
    }

    fn skip(&mut self, number: Number) -> Result<(), ImportError> {
        if self.encoding == Encoding::Ascii {
            self.word()?;
            return Ok(());
        }
        self.next(number)?;
        Ok(())
    }

    fn next(&mut self, number: Number) -> Result<f64, ImportError> {
        if self.encoding == Encoding::Ascii {
            let word = String::from_utf8_lossy(self.word()?);
            return parsed(&word).ok_or_else(|| self.fault(format!("'{word}' is no number")));
        }
        let size = number.size();
        let Some(bytes) = self.bytes.get(self.at..self.at + size) else {
            return Err(self.fault("the file is cut off: numbers are missing at its end"));
        };
        self.at += size;
        let mut little = [0; 8];
        little[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            little[..size].reverse();
        }
        Ok(number.decoded(little))
    }

    fn length(&mut self, number: Number) -> Result<u64, ImportError> {
        let length = self.next(number)?;
        if length.is_nan() || length < 0.0 {
            return Err(self.fault(format!("a list has {length} entries")));
        }
        Ok(length as u64)
    }

    /// Skips an element but for some properties, whose entries `each` gets, once for each element.
    fn entries<const N: usize>(
        &mut self,
        element: &Element,
        wanted: [Option<usize>; N],
        mut each: impl FnMut([&[f64]; N]),
    ) -> Result<(), ImportError> {
        let mut entries = [const { Vec::new() }; N];
        let slot = |place| wanted.iter().position(|wanted| *wanted == Some(place));
        let slots: Vec<_> = (0..element.properties.len()).map(slot).collect();
        for _ in 0..element.count {
            entries.iter_mut().for_each(Vec::clear);
            for (property, &slot) in element.properties.iter().zip(&slots) {
                let length = property.length.map(|length| self.length(length));
                for _ in 0..length.transpose()?.unwrap_or(1) {
                    match slot {
                        Some(slot) => entries[slot].push(self.next(property.number)?),
                        None => self.skip(property.number)?,
                    }
                }
            }
            each(entries.each_ref().map(Vec::as_slice));
        }
        Ok(())
    }
}

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Model, ImportError> {
    let header = Header::read(path, bytes)?;
    header.check(path, bytes.len() - header.length)?;
    let mut reader = Reader {
        path,
        mesh: TriangleMesh::default(),
        faces: Faces::default(),
        places: Vec::new(),
        numbers: Vec::new(),
        colours: Vec::new(),
        unused: Unused::default(),
    };
    let vertex = header.elements.iter().find(|one| one.name == "vertex");
    let faces = header.elements.iter().find_map(|one| {
        let is_faces = matches!(one.name.as_str(), "face" | "tristrips");
        is_faces.then(|| corner_list(one))
    });
    let missing = |what: &str| {
        let problem = format!("the header declares no {what}, as a triangle mesh needs");
        syntax(path, problem)
    };
    let vertex = vertex.ok_or_else(|| missing("element 'vertex'"))?;
    for name in ["x", "y", "z"] {
        if vertex.scalars([name]).is_none() {
            return Err(missing(&format!("property '{name}' of 'vertex'")));
        }
    }
    match faces {
        None => {
            let problem = "the header declares no element 'face': these are points alone";
            return Err(fault(path, problem, "make a mesh of them, and export that"));
        }
        Some(None) => return Err(missing("list 'vertex_indices' of 'face'")),
        Some(Some(_)) => {}
    }
    let mut numbers = Numbers {
        path,
        bytes,
        at: header.length,
        encoding: header.encoding,
    };
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => reader.vertices(&mut numbers, element)?,
            "face" => {
                let places = element.find("texcoord");
                let [red, green, blue] = colour(element).map_or([None; 3], |all| all.map(Some));
                let full = red.map_or(1.0, |red| full(element.properties[red].number));
                let number = element.find("texnumber");
                let wanted = [corner_list(element), places, number, red, green, blue];
                numbers.entries(element, wanted, |[corners, places, number, r, g, b]| {
                    if let ([r], [g], [b]) = (r, g, b) {
                        reader.colours.resize(reader.faces.len(), [1.0; 3]);
                        let seen = [r, g, b].map(|code| decoded(*code as f32 / full));
                        reader.colours.push(seen);
                    }
                    reader.face([corners, places, number]);
                })?;
            }
            "tristrips" => {
                numbers.entries(element, [corner_list(element)], |[entries]| {
                    let entries: Vec<i64> = entries.iter().map(|entry| *entry as i64).collect();
                    // -1 is between strips.
                    let strips = entries.split(|entry| *entry == -1);
                    strips.for_each(|strip| reader.faces.push_strip(strip));
                })?;
            }
            other => {
                numbers.entries(element, [], |_| {})?;
                reader
                    .unused
                    .add(format!("{other} element{{s}}"), element.count);
            }
        }
    }
    reader.finish(&header.textures)
}

fn corner_list(element: &Element) -> Option<usize> {
    let is_list = |place: &usize| element.properties[*place].length.is_some();
    let mut names = CORNER_LISTS.iter();
    names.find_map(|name| element.find(name).filter(is_list))
}

/// Returns the places of an element's red, green and blue.
fn colour(element: &Element) -> Option<[usize; 3]> {
    let named = element.scalars(["red", "green", "blue"]);
    named.or_else(|| element.scalars(["r", "g", "b"]))
}

/// Returns the number that stands for a full channel of a colour.
fn full(number: Number) -> f32 {
    match number {
        Number::U16 => f32::from(u16::MAX),
        Number::F32 | Number::F64 => 1.0,
        _ => f32::from(u8::MAX),
    }
}

struct Reader<'p> {
    path: &'p Path,
    mesh: TriangleMesh,
    faces: Faces,
    /// Places on a texture of the faces' corners, as far as they have some of their own.
    places: Vec<[f32; 2]>,
    /// Numbers of the faces' textures, as far as they are said.
    numbers: Vec<u32>,
    /// Colours of the faces, as far as they have some.
    colours: Vec<[f32; 3]>,
    unused: Unused,
}

impl Reader<'_> {
    fn vertices(
        &mut self,
        numbers: &mut Numbers<'_>,
        element: &Element,
    ) -> Result<(), ImportError> {
        let position = element.scalars(["x", "y", "z"]).unwrap_or_default();
        let normal = element.scalars(["nx", "ny", "nz"]);
        let mut pairs = COORDINATES.iter();
        let coordinate = pairs.find_map(|pair| element.scalars(*pair));
        let colour = colour(element);
        let full = colour.map_or(1.0, |[red, ..]| full(element.properties[red].number));
        let places = |of: Option<[usize; 3]>| of.map_or([None; 3], |all| all.map(Some));
        let [x, y, z] = position.map(Some);
        let ([nx, ny, nz], [r, g, b]) = (places(normal), places(colour));
        let [u, v] = coordinate.map_or([None; 2], |pair| pair.map(Some));
        let used = [x, y, z, nx, ny, nz, r, g, b, u, v];
        let mesh = &mut self.mesh;
        numbers.entries(element, used, |all| {
            let has = |from: usize| !all[from].is_empty();
            let at = |from: usize| [0, 1, 2].map(|n| all[from + n][0] as f32);
            mesh.positions.push(at(0));
            mesh.normals.extend(has(3).then(|| at(3)));
            let seen = has(6).then(|| at(6).map(|code| decoded(code / full)));
            mesh.colours.extend(seen);
            let place = has(9).then(|| [9, 10].map(|n| all[n][0] as f32));
            mesh.coordinates.extend(place);
        })?;
        for (place, property) in element.properties.iter().enumerate() {
            if !used.contains(&Some(place)) {
                self.unused
                    .add(format!("the vertices' {}", property.name), 1);
            }
        }
        Ok(())
    }

    fn face(&mut self, [corners, places, number]: [&[f64]; 3]) {
        if !places.is_empty() {
            let places = places.as_chunks::<2>().0.iter();
            self.places.resize(self.faces.corners(), [0.0; 2]);
            let own = places.map(|place| place.map(|x| x as f32));
            self.places.extend(own.take(corners.len()));
        }
        if let Some(&number) = number.first() {
            self.numbers.resize(self.faces.len(), 0);
            // -1 is no texture.
            let number = if number < 0.0 {
                u32::MAX
            } else {
                number as u32
            };
            self.numbers.push(number);
        }
        // What is no whole number names no vertex.
        let whole = |corner: &f64| Some(*corner as i64).filter(|whole| *whole as f64 == *corner);
        self.faces
            .push(corners.iter().map(|corner| whole(corner).unwrap_or(-1)));
    }

    fn finish(mut self, names: &[String]) -> Result<Model, ImportError> {
        let (path, mesh) = (self.path, &mut self.mesh);
        let mut corners = Vec::new();
        self.faces
            .cut(path, mesh, &mut self.unused, |three| corners.push(three))?;
        if !self.places.is_empty() {
            let place = |corner: u32| self.places.get(corner as usize).copied();
            let places = |triangle: usize| corners[triangle].map(|c| place(c).unwrap_or_default());
            mesh.coordinates = split(mesh, places);
        }
        if !mesh.colours.is_empty() {
            let count = self.colours.len() as u64;
            let kind = "colour{s} of faces, whose vertices have colours";
            self.unused.add(kind, count);
        } else if !self.colours.is_empty() {
            let colour = |corner| self.colours.get(self.faces.face_of(corner));
            let colours =
                |triangle: usize| [colour(corners[triangle][0]).map_or([1.0; 3], |c| *c); 3];
            mesh.colours = split(mesh, colours);
        }
        if mesh.coordinates.is_empty() {
            let kind = "texture{s} of faces without texture coordinates";
            self.unused.add(kind, names.len() as u64);
        } else if !names.is_empty() {
            let mut textures = Textures::new();
            let plain = Material {
                vertex_colours: !mesh.colours.is_empty(),
                ..Material::default()
            };
            let painted = names.iter().map(|name| {
                let image = textures.beside(path, name, &mut self.unused);
                Material {
                    name: name.clone(),
                    diffuse: [1.0; 3],
                    texture: image.map(|image| Texture::new(Pattern::Image(image), [1.0; 2])),
                    ..plain.clone()
                }
            });
            mesh.materials = painted.chain([plain.clone()]).collect();
            let number = |&[corner, ..]: &[u32; 3]| {
                let number = self.numbers.get(self.faces.face_of(corner));
                number.map_or(0, |number| (names.len() as u32).min(*number))
            };
            mesh.triangle_materials = corners.iter().map(number).collect();
            if !mesh.triangle_materials.contains(&(names.len() as u32)) {
                mesh.materials.pop();
            }
        }
        if mesh.materials.is_empty() && !mesh.colours.is_empty() {
            mesh.paint_by_vertices();
        }
        finished(self.path, self.mesh, self.unused)
    }
}

#[cfg(test)]
mod tests;
