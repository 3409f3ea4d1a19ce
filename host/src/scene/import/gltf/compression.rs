//! Buffer views that `EXT_meshopt_compression` or `KHR_meshopt_compression` compresses.

use gltf::buffer::View;
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer,
};
use serde::Deserialize;
use std::cell::OnceCell;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Bytes that one compressed byte stands for at most: 256 rows of zeros take a byte for four
/// columns.
const MOST_RATIO: u128 = 1024;

/// A compressed view, as its extension describes it.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compression {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
    /// Its rows, once they are asked for.
    #[serde(skip)]
    pub(super) decoded: OnceCell<Vec<u8>>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Compression {
    /// Returns how a view is compressed, or what its extension lacks.
    pub(super) fn of(view: &View<'_>) -> Option<Result<Self, String>> {
        let names = ["KHR_meshopt_compression", "EXT_meshopt_compression"];
        let value = names
            .iter()
            .find_map(|name| Some((name, view.extension_value(name)?)));
        let (name, value) = value?;
        let number = view.index();
        let read = Self::deserialize(value);
        Some(read.map_err(|lack| format!("buffer view {number}: {name} is wrong: {lack}")))
    }

    /// Returns the length of its rows in bytes.
    pub(super) const fn length(&self) -> u128 {
        self.count as u128 * self.byte_stride as u128
    }

    /// Decodes its rows; none if the bytes are no such rows.
    pub(super) fn decode(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let (count, filter) = (self.count, self.filter);
        if self.length() > MOST_RATIO * bytes.len() as u128 {
            return None;
        }
        if self.mode == Mode::Attributes {
            return decoder(self.byte_stride)?(bytes, count, filter);
        }
        if filter != Filter::None || (self.mode == Mode::Triangles && !count.is_multiple_of(3)) {
            return None;
        }
        match (self.byte_stride, self.mode) {
            (2, Mode::Triangles) => bytes_of(decode_index_buffer::<u16>(bytes, count)),
            (2, _) => bytes_of(decode_index_sequence::<u16>(bytes, count)),
            (4, Mode::Triangles) => bytes_of(decode_index_buffer::<u32>(bytes, count)),
            (4, _) => bytes_of(decode_index_sequence::<u32>(bytes, count)),
            _ => None,
        }
    }
}

fn bytes_of<T: IntoBytes + Immutable>(indices: meshopt::Result<Vec<T>>) -> Option<Vec<u8>> {
    Some(indices.ok()?.as_bytes().to_vec())
}

/// A row of vertices' attributes: words of four bytes.
#[derive(Clone, FromBytes, IntoBytes, Immutable)]
#[repr(transparent)]
struct Row<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Default for Row<WORDS> {
    fn default() -> Self {
        Self([0; WORDS])
    }
}

type Decoder = fn(&[u8], usize, Filter) -> Option<Vec<u8>>;

/// Returns the decoder of rows of this length in bytes; none for lengths that are not compressed.
fn decoder(stride: usize) -> Option<Decoder> {
    macro_rules! of_words {
        ($($words:literal)*) => {
            match stride {
                $(_ if stride == 4 * $words => Some(attributes::<$words>),)*
                _ => None,
            }
        };
    }
    of_words!(
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62
        63 64
    )
}

fn attributes<const WORDS: usize>(bytes: &[u8], count: usize, filter: Filter) -> Option<Vec<u8>> {
    let mut rows: Vec<Row<WORDS>> = decode_vertex_buffer(bytes, count).ok()?;
    unfilter(rows.as_mut_slice().as_mut_bytes(), 4 * WORDS, filter)?;
    Some(rows.as_bytes().to_vec())
}

/// Undoes a filter of rows of `stride` bytes, which begin where a word may; none if it has no such
/// rows.
fn unfilter(rows: &mut [u8], stride: usize, filter: Filter) -> Option<()> {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => decode_filter_oct(<[[i8; 4]]>::mut_from_bytes(rows).ok()?),
        (Filter::Octahedral, 8) => decode_filter_oct(<[[i16; 4]]>::mut_from_bytes(rows).ok()?),
        (Filter::Quaternion, 8) => decode_filter_quat(<[[i16; 4]]>::mut_from_bytes(rows).ok()?),
        (Filter::Color, 4) => decode_filter_color(<[[u8; 4]]>::mut_from_bytes(rows).ok()?),
        (Filter::Color, 8) => decode_filter_color(<[[u16; 4]]>::mut_from_bytes(rows).ok()?),
        (Filter::Exponential, _) => decode_filter_exp(<[[u32; 1]]>::mut_from_bytes(rows).ok()?),
        _ => return None,
    }
    Some(())
}
