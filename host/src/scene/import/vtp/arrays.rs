//! The elements of a VTK XML file and the numbers of its arrays.

use super::super::number::{Number, parsed};
use super::super::{BASE64, ImportError, fault, syntax};
use base64::Engine as _;
use flate2::read::ZlibDecoder;
use roxmltree::{Document, Node, ParsingOptions};
use std::borrow::Cow;
use std::io::Read as _;
use std::path::Path;

/// Most elements and texts of a file.
const MOST: u32 = 1 << 20;

/// An element of the file.
#[derive(Clone, Copy)]
pub(super) struct Element<'d>(Node<'d, 'd>);

impl<'d> Element<'d> {
    /// Returns an attribute without blanks around it.
    pub(super) fn said(self, name: &str) -> Option<&'d str> {
        self.0.attribute(name).map(str::trim)
    }

    /// Returns an attribute's number; 0 if it is missing or no whole number.
    pub(super) fn count(self, name: &str) -> usize {
        let said = self.said(name).map(str::parse);
        said.and_then(Result::ok).unwrap_or(0)
    }

    /// Returns the elements of a kind inside.
    pub(super) fn all(self, kind: &str) -> impl Iterator<Item = Self> {
        let inside = self.0.children();
        inside.filter(move |one| one.has_tag_name(kind)).map(Self)
    }

    /// Returns the texts inside, one after another.
    fn texts(self) -> impl Iterator<Item = &'d str> {
        let inside = self.0.children().filter(Node::is_text);
        inside.filter_map(|one| one.text())
    }

    pub(super) fn name(self) -> &'d str {
        self.said("Name").unwrap_or_default()
    }

    /// Returns the type of an array's numbers; `None` where it has text or bits.
    pub(super) fn number(self) -> Option<Number> {
        Number::named(&self.said("type")?.to_ascii_lowercase())
    }

    /// Returns how many numbers of an array are for each point or cell.
    pub(super) fn components(self) -> usize {
        self.said("NumberOfComponents")
            .map_or(1, |_| self.count("NumberOfComponents"))
    }
}

/// Returns a file's elements as text, and its appended bytes, which are no text.
pub(super) fn without_appended(bytes: &[u8]) -> (Cow<'_, str>, &[u8]) {
    let tag = b"<AppendedData";
    let start = bytes.windows(tag.len()).position(|part| part == tag);
    let (text, appended) = bytes.split_at(start.unwrap_or(bytes.len()));
    let mut text = String::from_utf8_lossy(text);
    if start.is_some() {
        text.to_mut().push_str("</VTKFile>");
    }
    (text, appended)
}

/// Returns the elements of a file's text.
pub(super) fn document<'t>(path: &Path, text: &'t str) -> Result<Document<'t>, ImportError> {
    let options = ParsingOptions {
        nodes_limit: MOST,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
        .map_err(|error| syntax(path, format!("not a VTK XML file: {error}")))
}

pub(super) struct File<'b> {
    path: &'b Path,
    root: Element<'b>,
    /// The appended data, in base64 or not.
    appended: Option<(&'b [u8], bool)>,
    /// Where arrays begin in them, in order.
    offsets: Vec<usize>,
    is_big_endian: bool,
    /// Bytes of each number before an array's bytes.
    word: usize,
    is_compressed: bool,
}

impl<'b> File<'b> {
    /// Reads what a document says of its arrays, some of whose bytes may be appended.
    pub(super) fn read(
        path: &'b Path,
        document: &'b Document<'b>,
        appended: &'b [u8],
    ) -> Result<Self, ImportError> {
        let root = Element(document.root_element());
        let kind = root.said("type").unwrap_or("nothing");
        if kind != "PolyData" {
            let advice = "extract its surface in ParaView, and save that as .vtp";
            let problem = format!("not a surface of VTK: it has {kind}, not PolyData");
            return Err(fault(path, problem, advice));
        }
        let compressor = root.said("compressor").unwrap_or_default();
        if !["", "vtkZLibDataCompressor"].contains(&compressor) {
            let advice = "write it with vtkZLibDataCompressor, or without compression";
            let problem = format!("it is compressed by {compressor}, which is not read");
            return Err(fault(path, problem, advice));
        }
        let pieces = root
            .all("PolyData")
            .flat_map(|surface| surface.all("Piece"));
        let parts = pieces.flat_map(|piece| piece.0.children());
        let arrays = parts.flat_map(|part| Element(part).all("DataArray"));
        let mut offsets: Vec<usize> = arrays.map(|array| array.count("offset")).collect();
        offsets.sort_unstable();
        Ok(Self {
            path,
            offsets,
            appended: appended_data(appended),
            is_big_endian: root.said("byte_order") == Some("BigEndian"),
            word: if root.said("header_type") == Some("UInt64") {
                8
            } else {
                4
            },
            is_compressed: !compressor.is_empty(),
            root,
        })
    }

    pub(super) fn pieces(&self) -> impl Iterator<Item = Element<'b>> {
        self.root
            .all("PolyData")
            .flat_map(|surface| surface.all("Piece"))
    }

    /// Returns the first `count` numbers of an array.
    pub(super) fn numbers<T>(
        &self,
        array: Element<'_>,
        count: usize,
        convert: impl Fn(f64) -> T,
    ) -> Result<Vec<T>, ImportError> {
        let wrong = |what: &str| syntax(self.path, format!("the array '{}' {what}", array.name()));
        let number = array.number().ok_or_else(|| wrong("has no numbers"))?;
        let numbers: Vec<T> = if matches!(array.said("format"), None | Some("ascii")) {
            let words = array.texts().flat_map(str::split_ascii_whitespace);
            let words = words.take(count);
            let numbers = words.map(|word| {
                let value = parsed(word).map(&convert);
                value.ok_or_else(|| wrong(&format!("has '{word}', no number")))
            });
            numbers.collect::<Result<_, _>>()?
        } else {
            let size = number.size();
            let bytes = self.bytes(array, count.saturating_mul(size));
            let bytes = bytes.ok_or_else(|| wrong("is cut off or damaged"))?;
            let numbers = bytes.chunks_exact(size).take(count);
            numbers
                .map(|bytes| convert(number.decoded(self.little(bytes))))
                .collect()
        };
        if numbers.len() < count {
            return Err(wrong(&format!("has {} of {count} numbers", numbers.len())));
        }
        Ok(numbers)
    }

    /// Returns up to eight bytes of a number in little-endian order.
    fn little(&self, bytes: &[u8]) -> [u8; 8] {
        let mut little = [0; 8];
        let own = &mut little[..bytes.len()];
        own.copy_from_slice(bytes);
        if self.is_big_endian {
            own.reverse();
        }
        little
    }

    /// Returns the bytes of an array: where it is compressed up to `most`, and the rest of a block.
    fn bytes(&self, array: Element<'_>, most: usize) -> Option<Cow<'b, [u8]>> {
        let stream = self.stream(array)?;
        let word = |place: usize| {
            let start = place.checked_mul(self.word)?;
            let bytes = stream.get(start..start.checked_add(self.word)?)?;
            usize::try_from(u64::from_le_bytes(self.little(bytes))).ok()
        };
        if !self.is_compressed {
            let own = self.word..self.word.checked_add(word(0)?)?;
            return match stream {
                Cow::Borrowed(bytes) => bytes.get(own).map(Cow::Borrowed),
                Cow::Owned(bytes) => Some(bytes.get(own)?.to_vec().into()),
            };
        }
        // The number of blocks, bytes of each, bytes of a shorter last one, and for each its bytes
        // when compressed.
        let [blocks, size, last] = [word(0)?, word(1)?, word(2)?];
        let mut start = blocks.checked_add(3)?.checked_mul(self.word)?;
        let mut whole = Vec::new();
        for block in 0..blocks {
            let is_last = block + 1 == blocks && last > 0;
            let size = if is_last { last } else { size };
            let end = start.checked_add(word(3 + block)?)?;
            let inflated = ZlibDecoder::new(stream.get(start..end)?);
            let read = inflated.take(size.min(most) as u64).read_to_end(&mut whole);
            if whole.len() >= most {
                break;
            }
            read.ok().filter(|read| *read == size)?;
            start = end;
        }
        Some(whole.into())
    }

    /// Returns the bytes from the beginning of an array on.
    fn stream(&self, array: Element<'_>) -> Option<Cow<'b, [u8]>> {
        if array.said("format") == Some("binary") {
            let text: String = array.texts().collect();
            return from_base64(text.as_bytes()).map(Cow::Owned);
        }
        let (data, is_base64) = self.appended?;
        let start = array.count("offset");
        if !is_base64 {
            return data.get(start..).map(Cow::Borrowed);
        }
        let next = self.offsets.partition_point(|other| *other <= start);
        let end = self.offsets.get(next).map_or(data.len(), |end| *end);
        from_base64(data.get(start..end.min(data.len()))?).map(Cow::Owned)
    }
}

/// Decodes base64 with blanks. Its padding may be inside: the bytes before an array's may be coded
/// by themselves.
fn from_base64(text: &[u8]) -> Option<Vec<u8>> {
    let text: Vec<u8> = text
        .iter()
        .copied()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    let mut bytes = Vec::new();
    for part in text.split(|byte| *byte == b'=') {
        BASE64.decode_vec(part, &mut bytes).ok()?;
    }
    Some(bytes)
}

/// Returns what follows the underscore in an element of appended data, and whether it is base64.
fn appended_data(element: &[u8]) -> Option<(&[u8], bool)> {
    let (tag, data) = element.split_at(element.iter().position(|byte| *byte == b'>')?);
    let is_base64 = tag.windows(6).any(|part| part == b"base64");
    let data = &data[data.iter().position(|byte| *byte == b'_')? + 1..];
    let end = data.iter().position(|byte| *byte == b'<' && is_base64);
    Some((&data[..end.unwrap_or(data.len())], is_base64))
}
