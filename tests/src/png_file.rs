//! PNG files that were written.

use png::{ColorType, Decoder, Transformations};
use std::io::Cursor;
use std::path::Path;

/// A picture of eight bits a channel.
#[derive(Debug)]
pub struct PngFile {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What a pixel's bytes are.
    pub channels: ColorType,
    /// Row by row from the top.
    pub bytes: Vec<u8>,
}

impl PngFile {
    /// Reads a file.
    ///
    /// # Panics
    /// If there is no PNG file.
    pub fn open(path: impl AsRef<Path>) -> Self {
        Self::decode(&std::fs::read(path).expect("a picture"))
    }

    /// Decodes the bytes of a file.
    ///
    /// # Panics
    /// If they are no PNG file.
    pub fn decode(bytes: &[u8]) -> Self {
        let mut decoder = Decoder::new(Cursor::new(bytes));
        decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
        let mut reader = decoder.read_info().expect("a picture");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("a picture");
        Self {
            width: info.width,
            height: info.height,
            channels: info.color_type,
            bytes,
        }
    }

    /// Returns red, green and blue of all pixels.
    pub fn rgb(&self) -> Vec<[u8; 3]> {
        let pixels = self.bytes.chunks_exact(self.channels.samples());
        pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }
}
