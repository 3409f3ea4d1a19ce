//! Where the built-in scene `spheres` is looked at from, and details of it.

use shisen::cave::{RoomError, Wall};
use shisen::picture::{Picture, PictureError};

/// A square window 1 m before the eye.
pub(super) struct View {
    /// Right of and above straight ahead: metres.
    lower_left: [f64; 2],
    /// Metres.
    side: f64,
}

/// All balls, filling the picture.
pub(super) const MAIN: View = View {
    lower_left: [-0.44, -0.66],
    side: 0.8,
};

/// All balls, a tenth of the picture.
pub(super) const WIDE: View = View {
    lower_left: [-0.83, -1.02],
    side: 1.58,
};

/// The largest ball, from edge to edge.
pub(super) const CLOSE: View = View {
    lower_left: [-0.414, -0.370],
    side: 0.404,
};

impl View {
    /// As a wall of so many pixels a side.
    pub(super) fn wall(&self, size: u32) -> Result<Wall, RoomError> {
        let [x, y] = self.lower_left;
        let corner = |right, up| [x + right * self.side, y + up * self.side, -1.0].into();
        Wall::new(
            "front",
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(0.0, 1.0),
            [size; 2],
        )
    }
}

/// The detail that a strip shows: its middle and its side, in sides of the
/// picture.
const DETAIL: ([f64; 2], f64) = ([0.52, 0.83], 0.16);

/// Pixels a side of a detail in a strip, at least.
const DETAIL_PIXELS: u32 = 256;

/// Pixels between details.
const GAP: u32 = 4;

/// Rows of pictures' details, enlarged by whole pixels, on white.
///
/// # Errors
/// More pixels than there is memory for.
pub(super) fn strip(rows: &[Vec<&Picture>]) -> Result<Picture, PictureError> {
    let width = rows.iter().flatten().next().map_or(1, |one| one.width);
    let ([x, y], side) = DETAIL;
    let pixels = |share: f64| (share * f64::from(width)) as u32;
    let side = pixels(side).max(1);
    let first = [pixels(x), pixels(y)].map(|middle| middle.saturating_sub(side / 2));
    let scale = DETAIL_PIXELS.div_ceil(side);
    let cell = side * scale + GAP;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let mut strip = Picture::new(columns * cell + GAP, rows.len() as u32 * cell + GAP)?;
    strip.pixels.fill([1.0; 4]);
    for (row, pictures) in (0..).zip(rows) {
        for (column, picture) in (0..).zip(pictures) {
            for y in 0..side * scale {
                for x in 0..side * scale {
                    let from = picture.pixel(first[0] + x / scale, first[1] + y / scale);
                    let to = (column * cell + GAP + x, row * cell + GAP + y);
                    strip.set_pixel(to.0, to.1, from.unwrap_or_default());
                }
            }
        }
    }
    Ok(strip)
}
