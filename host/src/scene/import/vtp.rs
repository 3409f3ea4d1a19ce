//! VTK's XML files of surfaces (`PolyData`).

mod arrays;

use super::number::Number;
use super::polygon::{Faces, split};
use super::{
    ImportError, Model, Scalar, Unused, decoded, fault, finished, no_vertex, syntax, unusable,
};
use crate::scene::mesh::TriangleMesh;
use arrays::{Element, File, document, without_appended};
use colorous::VIRIDIS;
use std::path::Path;

/// Most points, and most corners of all faces.
const MOST: usize = 3 * TriangleMesh::MOST_TRIANGLES;

/// The colour of a scalar that is no number.
const NO_NUMBER: [f32; 3] = [0.5; 3];

pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Model, ImportError> {
    let (text, appended) = without_appended(bytes);
    let document = document(path, &text)?;
    let file = File::read(path, &document, appended)?;
    let mut reader = Reader {
        path,
        shown: Shown::of(&file),
        file: &file,
        mesh: TriangleMesh::default(),
        faces: Faces::default(),
        values: Vec::new(),
        unused: Unused::default(),
    };
    for piece in file.pieces() {
        reader.piece(piece)?;
    }
    reader.finish()
}

/// The array that colours show.
#[derive(Clone, Copy, PartialEq)]
struct Shown<'b> {
    is_of_cells: bool,
    name: &'b str,
    number: Number,
    components: usize,
}

impl<'b> Shown<'b> {
    /// Returns the active scalar of points, else of cells; else the first that can be shown.
    fn of(file: &File<'b>) -> Option<Self> {
        let find = |is_of_cells: bool, is_active: bool| {
            let part = if is_of_cells { "CellData" } else { "PointData" };
            let mut parts = file.pieces().flat_map(|piece| piece.all(part));
            parts.find_map(|part| {
                part.all("DataArray").find_map(|array| {
                    let shown = Self::from(is_of_cells, array)?;
                    let is_meant = part.said("Scalars") == Some(shown.name);
                    // VTK has numbers of its own.
                    let fits = is_meant || !is_active && !shown.name.starts_with("vtk");
                    fits.then_some(shown)
                })
            })
        };
        let order = [(false, true), (true, true), (false, false), (true, false)];
        order
            .into_iter()
            .find_map(|(is_of_cells, is_active)| find(is_of_cells, is_active))
    }

    /// Describes an array that colours can show.
    fn from(is_of_cells: bool, array: Element<'b>) -> Option<Self> {
        let (number, components) = (array.number()?, array.components());
        let is_colour = number == Number::U8 && matches!(components, 3 | 4);
        (components == 1 || is_colour).then_some(Self {
            is_of_cells,
            name: array.name(),
            number,
            components,
        })
    }
}

struct Reader<'b> {
    path: &'b Path,
    file: &'b File<'b>,
    shown: Option<Shown<'b>>,
    mesh: TriangleMesh,
    faces: Faces,
    /// The numbers that colours show, for each point or each face.
    values: Vec<f64>,
    unused: Unused,
}

impl Reader<'_> {
    fn piece(&mut self, piece: Element<'_>) -> Result<(), ImportError> {
        let (file, first) = (self.file, self.mesh.positions.len());
        let count = piece.count("NumberOfPoints");
        if count > MOST - first {
            let problem = format!("it has more than {MOST} points");
            return Err(unusable(self.path, problem));
        }
        let floats = |array, each| file.numbers(array, each * count, |x| x as f32);
        let mut points = piece.all("Points").flat_map(|part| part.all("DataArray"));
        if let Some(points) = points.next().filter(|_| count > 0) {
            let numbers = floats(points, 3)?;
            self.mesh.positions.extend(numbers.as_chunks::<3>().0);
        }
        let arrays = |part| {
            piece
                .all(part)
                .flat_map(|part| part.all("DataArray").map(move |array| (part, array)))
        };
        for (part, array) in arrays("PointData") {
            let is_for = |role| part.said(role).unwrap_or(role) == array.name();
            let shown = Shown::from(false, array).filter(|shown| Some(*shown) == self.shown);
            let read = if is_for("Normals") && array.components() == 3 {
                floats(array, 3).map(|numbers| {
                    self.mesh.normals.resize(first, [0.0; 3]);
                    self.mesh.normals.extend(numbers.as_chunks::<3>().0);
                })
            } else if is_for("TCoords") && array.components() == 2 {
                floats(array, 2).map(|numbers| {
                    self.mesh.coordinates.resize(first, [0.0; 2]);
                    self.mesh.coordinates.extend(numbers.as_chunks::<2>().0);
                })
            } else if let Some(Shown { components, .. }) = shown {
                let numbers = file.numbers(array, components * count, |x| x);
                numbers.map(|numbers| {
                    self.values.resize(components * first, f64::NAN);
                    self.values.extend(numbers);
                })
            } else {
                self.unused.add(format!("the points' {}", array.name()), 1);
                continue;
            };
            if let Err(error) = read {
                self.unused.add(error.without(self.path), 1);
            }
        }
        let mut of_cells = None;
        for (_, array) in arrays("CellData") {
            let shown = Shown::from(true, array);
            if shown.is_some() && shown == self.shown {
                of_cells = Some(array);
            } else {
                self.unused.add(format!("the cells' {}", array.name()), 1);
            }
        }
        self.cells(piece, first, of_cells)?;
        self.unused
            .add("point{s}", piece.count("NumberOfVerts") as u64);
        self.unused
            .add("line{s}", piece.count("NumberOfLines") as u64);
        Ok(())
    }

    /// Adds a piece's polygons and strips with their numbers. Its points come after the `first`.
    fn cells(
        &mut self,
        piece: Element<'_>,
        first: usize,
        numbers: Option<Element<'_>>,
    ) -> Result<(), ImportError> {
        let parts = ["Verts", "Lines", "Polys", "Strips"];
        let counts = parts.map(|part| piece.count(&format!("NumberOf{part}")));
        // Cells are counted over all parts, in this order.
        let mut cell = counts[0].saturating_add(counts[1]);
        let cells = counts.into_iter().fold(0, usize::saturating_add);
        let points = self.mesh.positions.len() - first;
        let each = numbers.map_or(0, Element::components);
        let count = each.saturating_mul(cells);
        let numbers = numbers.map(|array| self.file.numbers(array, count, |x| x));
        let numbers = numbers.transpose()?.unwrap_or_default();
        for (part, count) in parts.into_iter().zip(counts).skip(2) {
            if count == 0 {
                continue;
            }
            let wrong = |what: String| syntax(self.path, format!("{part} {what}"));
            let array = |name: &str| {
                let arrays = piece.all(part).flat_map(|part| part.all("DataArray"));
                let array = { arrays }.find(|array| array.name() == name);
                array.ok_or_else(|| wrong(format!("has no array '{name}'")))
            };
            let ends = array("offsets")?;
            let ends = self.file.numbers(ends, count, |x| x as usize)?;
            let corners = ends.last().copied().filter(|corners| *corners <= MOST);
            let corners = corners.ok_or_else(|| wrong(format!("has more than {MOST} corners")))?;
            let connectivity = array("connectivity")?;
            let mut corners = self.file.numbers(connectivity, corners, |x| x as i64)?;
            for corner in &mut corners {
                if !(0..points as i64).contains(corner) {
                    return Err(no_vertex(self.path, part, *corner, [0, points as i64 - 1]));
                }
                *corner += first as i64;
            }
            let mut start = 0;
            for end in ends {
                let face = corners.get(start..end);
                let face = face.ok_or_else(|| wrong("has offsets that do not ascend".into()))?;
                let before = self.faces.len();
                match part {
                    "Strips" => self.faces.push_strip(face),
                    _ => self.faces.push(face.iter().copied()),
                }
                let own = numbers.get(each * cell..each * (cell + 1));
                if let Some(own) = own.filter(|own| !own.is_empty()) {
                    self.values.resize(each * before, f64::NAN);
                    (before..self.faces.len()).for_each(|_| self.values.extend(own));
                }
                start = end;
                cell += 1;
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Model, ImportError> {
        let (path, faces, mut mesh, mut unused) = (self.path, self.faces, self.mesh, self.unused);
        if faces.len() == 0 {
            let problem = "it has no polygons and no strips: these are points and lines alone";
            let advice = "extract a surface in ParaView, and save that as .vtp";
            return Err(fault(path, problem, advice));
        }
        let points = mesh.positions.len();
        if !mesh.normals.is_empty() {
            mesh.normals.resize(points, [0.0; 3]);
        }
        if !mesh.coordinates.is_empty() {
            mesh.coordinates.resize(points, [0.0; 2]);
        }
        let mut of_triangles = Vec::new();
        faces.cut(path, &mut mesh, &mut unused, |[corner, ..]| {
            of_triangles.push(corner);
        })?;
        let mut scalar = None;
        if let Some(shown) = self.shown {
            let (mut colours, range) = colours(&self.values, shown.components);
            mesh.colours = if shown.is_of_cells {
                colours.resize(faces.len(), NO_NUMBER);
                let colour = |triangle: usize| colours[faces.face_of(of_triangles[triangle])];
                split(&mut mesh, |triangle| [colour(triangle); 3])
            } else {
                colours.resize(points, NO_NUMBER);
                colours
            };
            mesh.paint_by_vertices();
            scalar = range.map(|[least, greatest]| Scalar {
                name: shown.name.to_owned(),
                least,
                greatest,
            });
        }
        Ok(Model {
            scalar,
            ..finished(path, mesh, unused)?
        })
    }
}

/// Returns a colour for each point or face, and the range of numbers that colours show: `None` where
/// the numbers are colours.
fn colours(values: &[f64], components: usize) -> (Vec<[f32; 3]>, Option<[f32; 2]>) {
    let coded = |code: f64| decoded(code as f32 / 255.0);
    if components > 1 {
        let each = values.chunks_exact(components);
        let colours = each.map(|codes| [codes[0], codes[1], codes[2]].map(coded));
        return (colours.collect(), None);
    }
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let least = finite().fold(f64::INFINITY, f64::min);
    let greatest = finite().fold(f64::NEG_INFINITY, f64::max);
    // Halves: the difference of two finite numbers may be infinite.
    let span = (greatest / 2.0 - least / 2.0).max(f64::MIN_POSITIVE);
    let colour = |value: &f64| {
        if !value.is_finite() {
            return NO_NUMBER;
        }
        let colour = VIRIDIS.eval_continuous((value / 2.0 - least / 2.0) / span);
        [colour.r, colour.g, colour.b].map(|code| coded(f64::from(code)))
    };
    let range = (least <= greatest).then_some([least as f32, greatest as f32]);
    (values.iter().map(colour).collect(), range)
}

#[cfg(test)]
pub(super) mod tests;
