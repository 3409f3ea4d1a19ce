//! The numbers of a glTF file: buffers, their views, and accessors.

use super::compression::Compression;
use crate::scene::import::{BASE64, ImportError, claim, fault, read, syntax, unusable};
use crate::scene::mesh::{MeshError, TriangleMesh};
use base64::Engine as _;
use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, Document, buffer};
use std::cell::Cell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;
use std::rc::Rc;

/// The bytes of all buffers.
pub(super) struct Buffers<'p> {
    path: &'p Path,
    all: Vec<Rc<Vec<u8>>>,
    /// How each view is compressed.
    compressed: Vec<Option<Compression>>,
    /// Bytes that further views may take once they are decoded.
    left: Cell<u128>,
}

impl<'p> Buffers<'p> {
    /// Bytes that the compressed views of a file may take together once they are decoded.
    const MOST_DECODED: u128 = 1 << 32;

    /// Reads the buffers that are needed: without those that stand in for compressed ones. Those
    /// with the same URI share their bytes.
    pub(super) fn read(
        path: &'p Path,
        document: &Document,
        blob: Option<Vec<u8>>,
    ) -> Result<Self, ImportError> {
        let mut needed = vec![false; document.buffers().len()];
        let mut compressed = Vec::new();
        for view in document.views() {
            let compression = Compression::of(&view).transpose();
            let compression = compression.map_err(|problem| syntax(path, problem))?;
            let buffer = compression.as_ref().map(|of| of.buffer);
            if let Some(needed) = needed.get_mut(buffer.unwrap_or(view.buffer().index())) {
                *needed = true;
            }
            compressed.push(compression);
        }
        let mut blob = blob.map(Rc::new);
        let mut by_uri = HashMap::new();
        let mut all = Vec::new();
        for buffer in document.buffers() {
            let number = buffer.index();
            if !needed[number] {
                all.push(Rc::default());
                continue;
            }
            let bytes = match buffer.source() {
                buffer::Source::Bin => {
                    let problem = "has neither a URI nor a binary chunk";
                    let bytes = blob.take();
                    bytes.ok_or_else(|| syntax(path, format!("buffer {number} {problem}")))?
                }
                buffer::Source::Uri(uri) => match by_uri.entry(uri) {
                    Entry::Occupied(known) => Rc::clone(known.get()),
                    Entry::Vacant(new) => Rc::clone(new.insert(Rc::new(read_uri(path, uri)?))),
                },
            };
            if buffer.length() > bytes.len() {
                let what = format!("the length of buffer {number}");
                return Err(claim(path, &what, buffer.length() as u128, bytes.len()));
            }
            all.push(bytes);
        }
        Ok(Self {
            path,
            all,
            compressed,
            left: Cell::new(Self::MOST_DECODED),
        })
    }

    fn fault(&self, problem: impl AsRef<str>) -> ImportError {
        syntax(self.path, problem)
    }

    /// Returns the bytes of a view, decoded where it is compressed.
    pub(super) fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], ImportError> {
        let number = view.index();
        let Some(of) = self.compressed.get(number).and_then(Option::as_ref) else {
            let buffer = view.buffer().index();
            return self.part(number, buffer, view.offset(), view.length());
        };
        if let Some(decoded) = of.decoded.get() {
            return Ok(decoded);
        }
        let left = self.left.get().checked_sub(of.length()).ok_or_else(|| {
            let most = Self::MOST_DECODED;
            let problem = format!("the compressed buffer views take more than {most} bytes");
            unusable(self.path, problem)
        })?;
        let bytes = self.part(number, of.buffer, of.byte_offset, of.byte_length)?;
        let decoded = of.decode(bytes).ok_or_else(|| {
            let problem = "is not compressed in the way, and to as many items, as it says";
            self.fault(format!("buffer view {number} {problem}"))
        })?;
        self.left.set(left);
        Ok(of.decoded.get_or_init(|| decoded))
    }

    /// Returns bytes of a buffer, which a view names.
    fn part(
        &self,
        view: usize,
        buffer: usize,
        offset: usize,
        length: usize,
    ) -> Result<&[u8], ImportError> {
        let buffer = self.all.get(buffer).map_or(&[][..], |all| all.as_slice());
        let end = offset.checked_add(length);
        let bytes = end.and_then(|end| buffer.get(offset..end));
        bytes.ok_or_else(|| {
            let claimed = offset as u128 + length as u128;
            claim(
                self.path,
                &format!("buffer view {view}"),
                claimed,
                buffer.len(),
            )
        })
    }

    /// Reads rows of `N` numbers.
    pub(super) fn floats<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        let kind = accessor.data_type();
        let scale = match kind {
            _ if !accessor.normalized() => 1.0,
            DataType::I8 => f32::from(i8::MAX),
            DataType::U8 => f32::from(u8::MAX),
            DataType::I16 => f32::from(i16::MAX),
            DataType::U16 => f32::from(u16::MAX),
            DataType::U32 | DataType::F32 => 1.0,
        };
        let size = kind.size();
        let decode = |bytes: &[u8]| {
            std::array::from_fn(|component| {
                let value = number(kind, &bytes[component * size..]) as f32;
                (value / scale).max(if scale > 1.0 { -1.0 } else { f32::NEG_INFINITY })
            })
        };
        self.items(accessor, N, decode)
    }

    /// Reads whole numbers.
    pub(super) fn whole<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[u32; N]>, ImportError> {
        let kind = accessor.data_type();
        if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(self.fault(format!(
                "accessor {} is of {kind:?}, but has to be of whole numbers from 0",
                accessor.index()
            )));
        }
        let size = kind.size();
        let decode = |bytes: &[u8]| {
            std::array::from_fn(|component| number(kind, &bytes[component * size..]) as u32)
        };
        self.items(accessor, N, decode)
    }

    /// Reads an accessor, once it is certain that it has rows of as many components and that all
    /// of it is there.
    fn items<T: Clone>(
        &self,
        accessor: &Accessor<'_>,
        components: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, ImportError> {
        let number = accessor.index();
        if accessor.dimensions().multiplicity() != components {
            let found = accessor.dimensions();
            let asked = match components {
                1 => Dimensions::Scalar,
                2 => Dimensions::Vec2,
                3 => Dimensions::Vec3,
                4 => Dimensions::Vec4,
                _ => Dimensions::Mat4,
            };
            let problem = format!("accessor {number} is {found:?}, but has to be {asked:?}");
            return Err(self.fault(problem));
        }
        let (count, size) = (accessor.count(), accessor.size());
        let rows = |view: &buffer::View<'_>, offset: usize, count: usize, size: usize| {
            let bytes = self.view(view)?;
            let stride = view.stride().unwrap_or(size);
            if stride < size || count == 0 {
                return Err(self.fault(format!(
                    "accessor {number} has {count} items of {size} bytes every {stride} bytes"
                )));
            }
            let claimed = offset as u128 + (count as u128 - 1) * stride as u128 + size as u128;
            if claimed > bytes.len() as u128 {
                let what = format!("accessor {number}");
                return Err(claim(self.path, &what, claimed, bytes.len()));
            }
            Ok((0..count).map(move |row| &bytes[offset + row * stride..][..size]))
        };
        let mut items: Vec<T> = match accessor.view() {
            Some(view) => rows(&view, accessor.offset(), count, size)?
                .map(&decode)
                .collect(),
            // All zero but for the sparse items.
            None if count > 3 * TriangleMesh::MOST_TRIANGLES => {
                return Err(unusable(self.path, MeshError::too_many(count / 3)));
            }
            None => vec![decode(&[0; 64]); count],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind = kind_of(&indices.index_type());
            let places = rows(
                &indices.view(),
                indices.offset(),
                sparse.count(),
                kind.size(),
            )?;
            let values = rows(&values.view(), values.offset(), sparse.count(), size)?;
            for (place, value) in places.zip(values) {
                let place = self::number(kind, place) as usize;
                let item = items.get_mut(place);
                *item.ok_or_else(|| {
                    self.fault(format!(
                        "accessor {number} replaces item {place} (counted from 0), but has {count}"
                    ))
                })? = decode(value);
            }
        }
        Ok(items)
    }
}

const fn kind_of(index: &gltf::accessor::sparse::IndexType) -> DataType {
    use gltf::accessor::sparse::IndexType;
    match index {
        IndexType::U8 => DataType::U8,
        IndexType::U16 => DataType::U16,
        IndexType::U32 => DataType::U32,
    }
}

/// Returns the number that bytes begin with.
fn number(kind: DataType, bytes: &[u8]) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    match kind {
        DataType::I8 => f64::from(bytes[0] as i8),
        DataType::U8 => f64::from(bytes[0]),
        DataType::I16 => f64::from(i16::from_le_bytes(two())),
        DataType::U16 => f64::from(u16::from_le_bytes(two())),
        DataType::U32 => f64::from(u32::from_le_bytes(four())),
        DataType::F32 => f64::from(f32::from_le_bytes(four())),
    }
}

/// Reads a `data:` URI or a file beside the document or below it.
fn read_uri(path: &Path, uri: &str) -> Result<Vec<u8>, ImportError> {
    if let Some(data) = data_of(uri) {
        return data.map_err(|reason| syntax(path, format!("a buffer's data {reason}")));
    }
    let name = file_name(uri);
    if !is_below(&name) {
        let problem = format!("the buffer URI '{uri}' is neither data nor a file beside this one");
        let advice = "put the file there, and export the mesh again";
        return Err(fault(path, problem, advice));
    }
    read(&path.with_file_name(name))
}

/// Returns what a `data:` URI holds; none for other URIs.
pub(super) fn data_of(uri: &str) -> Option<Result<Vec<u8>, &'static str>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((_, data)) = rest.split_once(";base64,") else {
        return Some(Err("is not in base64"));
    };
    Some(BASE64.decode(data).map_err(|_| "is not in base64"))
}

/// Returns whether a path leads to nothing but a folder and what is below it.
pub(super) fn is_below(name: &str) -> bool {
    use std::path::Component::{CurDir, Normal, ParentDir};
    let mut depth = 0;
    let mut stays = |part| {
        depth += match part {
            Normal(_) => 1,
            CurDir => 0,
            ParentDir => -1,
            _ => return false,
        };
        depth >= 0
    };
    !name.contains("://") && Path::new(name).components().all(&mut stays)
}

/// Returns the name of the file that a URI means, also with what is no URI's.
pub(super) fn file_name(uri: &str) -> String {
    let name = percent_decoded(uri).unwrap_or_else(|| uri.to_owned());
    name.replace('\\', "/")
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2)?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend(part.get(2..)?.as_bytes());
    }
    String::from_utf8(bytes).ok()
}
