//! Patterns in a screen's picture.

mod circles;
mod grid;

pub(super) use circles::circles;
pub(super) use grid::grid;

#[cfg(test)]
pub(super) use {circles::RADII, grid::CELL};

use super::ScreenView;
use super::sheet::{BLACK, Colour, LINE, Sheet, WHITE, stroke};
use crate::cave::Eye;
use crate::picture::{Picture, PictureError};
use fast_srgb8::srgb8_to_f32;
use glam::DVec2;

/// Returns the light of a colour's sRGB codes.
fn light(codes: [u8; 3]) -> Colour {
    codes.map(srgb8_to_f32)
}

/// Draws a field of sRGB codes.
pub(super) fn flat(view: &ScreenView<'_>, codes: [u8; 3]) -> Result<Picture, PictureError> {
    let colour = light(codes);
    Sheet::new(view).paint(|_| colour)
}

/// Writes the screen's name under an arrow up, and a line below.
fn write_title(sheet: &Sheet<'_>, picture: &mut Picture, view: &ScreenView<'_>, line: &str) {
    let name = format!("↑ {}", view.screen.name());
    let top = if sheet.dome().is_some() { 0.55 } else { 0.3 };
    for (text, share, y) in [(name.as_str(), 0.4, top), (line, 0.8, top + 0.1)] {
        if let Some(dot) = sheet.fit(text, DVec2::new(share, 0.08) * sheet.span()) {
            let sign = sheet.centred(text, sheet.place(0.5, y), dot);
            sheet.show(picture, &sign, sheet.head);
        }
    }
}

/// Returns the picture's columns and rows as text.
fn resolution(sheet: &Sheet<'_>) -> String {
    format!("{}×{}", sheet.size.x, sheet.size.y)
}

pub(super) fn edges(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    let sheet = Sheet::new(view);
    let size = sheet.size;
    let is_dome = sheet.dome().is_some();
    let mut picture = sheet.paint(|at| {
        let from_edge = if is_dome {
            0.5 * size.x - at.distance(0.5 * size)
        } else {
            at.min(size - at).min_element()
        };
        let from_middle = at - 0.5 * size;
        // The middle of an even number of pixels is the edge between two.
        let crosshair = from_middle.abs().min_element() < 1.0;
        let across = [DVec2::new(size.y, size.x), DVec2::new(size.y, -size.x)];
        let diagonals = across.map(|normal| stroke(from_middle.dot(normal.normalize()), 1.0));
        let line = diagonals[0].max(diagonals[1]).max(f32::from(crosshair));
        let line = line.max(f32::from(from_edge < 1.0));
        WHITE.map(|channel| line * channel)
    })?;
    let span = sheet.span();
    let extent = sheet.dome().map_or_else(
        || format!("{:.3}×{:.3} m", span.x, span.y),
        |dome| format!("{}°", dome.field_of_view_degrees),
    );
    let line = format!("{}, {extent}", resolution(&sheet));
    write_title(&sheet, &mut picture, view, &line);
    Ok(picture)
}

/// The part of the picture that all of a pattern is in: the square inside a dome's disc.
struct Inset {
    low: DVec2,
    size: DVec2,
}

impl Inset {
    fn new(sheet: &Sheet<'_>) -> Self {
        let is_dome = sheet.dome().is_some();
        let part = if is_dome {
            std::f64::consts::FRAC_1_SQRT_2
        } else {
            1.0
        };
        Self {
            low: 0.5 * (1.0 - part) * sheet.size,
            size: part * sheet.size,
        }
    }

    /// Returns the shares of width and height at a place in the picture, 0 to 1 inside.
    fn share(&self, at: DVec2) -> DVec2 {
        (at - self.low) / self.size
    }

    /// Returns the place in the picture of shares of width and height.
    fn place(&self, share: DVec2) -> DVec2 {
        self.low + share * self.size
    }
}

/// Draws codes 0 to 16 in fields on black, with numbers that are dark themselves.
pub(super) fn near_black(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    const CELLS: DVec2 = DVec2::new(6.0, 3.0);
    const DARK: [u8; 3] = [48; 3];
    let sheet = Sheet::new(view);
    let inset = Inset::new(&sheet);
    let mut picture = sheet.paint(|at| {
        let cell = inset.share(at) * CELLS;
        let code = cell.floor().dot(DVec2::new(1.0, CELLS.x));
        let inside = (cell.fract() - 0.5).abs().max_element() < 0.4;
        let on_cells = cell.cmpge(DVec2::ZERO).all() && cell.cmplt(CELLS).all();
        if inside && on_cells && code <= 16.0 {
            light([code as u8; 3])
        } else {
            BLACK
        }
    })?;
    let Some(dot) = sheet.fit("16", 0.08 * sheet.span()) else {
        return Ok(picture);
    };
    for code in 0..=16 {
        let text = code.to_string();
        let cell = DVec2::new(f64::from(code % 6), f64::from(code / 6));
        let at = inset.place((cell + 0.5) / CELLS);
        let mut sign = sheet.centred(&text, at, dot);
        (sign.ink, sign.paper) = (light(DARK), None);
        sheet.show(&mut picture, &sign, sheet.head);
    }
    Ok(picture)
}

/// The primaries and their mixtures, from bright to dark.
const BARS: [(&str, [u8; 3]); 8] = [
    ("white", [255, 255, 255]),
    ("yellow", [255, 255, 0]),
    ("cyan", [0, 255, 255]),
    ("green", [0, 255, 0]),
    ("magenta", [255, 0, 255]),
    ("red", [255, 0, 0]),
    ("blue", [0, 0, 255]),
    ("black", [0, 0, 0]),
];

/// Draws bars of full colours, and below them a ramp of all codes for each channel and for grey.
pub(super) fn bars(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    const RAMPS: [[u8; 3]; 4] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]];
    const BARS_END: f64 = 0.7;
    let sheet = Sheet::new(view);
    let inset = Inset::new(&sheet);
    let mut picture = sheet.paint(|at| {
        let share = inset.share(at);
        let column = share.x.clamp(0.0, 1.0);
        if share.y < BARS_END {
            let bar = (column * BARS.len() as f64) as usize;
            return light(BARS[bar.min(BARS.len() - 1)].1);
        }
        let ramp = (share.y - BARS_END) / (1.0 - BARS_END) * RAMPS.len() as f64;
        let code = (column * 256.0).min(255.0) as u8;
        light(RAMPS[(ramp as usize).min(RAMPS.len() - 1)].map(|on| on * code))
    })?;
    let Some(dot) = sheet.fit("magenta", DVec2::new(0.11, 0.1) * sheet.span()) else {
        return Ok(picture);
    };
    for (number, (name, codes)) in BARS.into_iter().enumerate() {
        let x = (number as f64 + 0.5) / BARS.len() as f64;
        let at = inset.place(DVec2::new(x, 0.35));
        let mut sign = sheet.centred(name, at, dot);
        let is_bright = codes[1] > 0;
        (sign.ink, sign.paper) = (if is_bright { BLACK } else { WHITE }, None);
        sheet.show(&mut picture, &sign, sheet.head);
    }
    Ok(picture)
}

const RED: Colour = [0.6, 0.0, 0.0];
const CYAN: Colour = [0.0, 0.4, 0.4];

/// Draws a red left half with an L for the left eye, and a cyan right half with an R for the right
/// one. A single eye sees both.
pub(super) fn stereo(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    let sheet = Sheet::new(view);
    let shown = |eye| view.eye == eye || view.eye == Eye::Centre;
    let halves = [(Eye::Left, RED, "L", 0.25), (Eye::Right, CYAN, "R", 0.75)];
    let mut picture = sheet.paint(|at| {
        let half = halves[usize::from(at.x >= 0.5 * sheet.size.x)];
        if shown(half.0) { half.1 } else { BLACK }
    })?;
    for (_, paper, letter, x) in halves.into_iter().filter(|half| shown(half.0)) {
        let dot = 0.35 * sheet.span().min_element() / LINE;
        let mut sign = sheet.centred(letter, sheet.place(x, 0.5), dot);
        sign.paper = Some(paper);
        sheet.show(&mut picture, &sign, sheet.head);
    }
    Ok(picture)
}

/// The bars of the depth ladder: the part of the screen's distance, from the far one on.
pub(super) const LADDER: [(&str, f64, f64, Colour); 3] = [
    ("farther", 2.0, 0.8, [0.1, 0.2, 0.8]),
    ("screen", 1.0, 0.5, [0.5, 0.5, 0.5]),
    ("nearer", 0.5, 0.2, [0.8, 0.6, 0.0]),
];

/// The light around the bars.
pub(super) const BACKGROUND: Colour = [0.02; 3];

/// Draws bars of one apparent size at several distances, each eye's from its own place.
pub(super) fn depth(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    // Dots across a bar.
    const WIDTH: f64 = 60.0;
    let sheet = Sheet::new(view);
    let mut picture = sheet.paint(|_| BACKGROUND)?;
    for (name, distance, x, paper) in LADDER {
        let at = sheet.place(x, 0.5);
        let letters = name.len() as f64;
        let dot = 0.2 * sheet.span().min_element() / WIDTH;
        let mut sign = sheet.centred(name, at, dot);
        (sign.ink, sign.paper) = (BLACK, Some(paper));
        sign.margin = 0.5 * (WIDTH * DVec2::new(1.0, 3.0) - LINE * DVec2::new(letters, 1.0));
        let sign = sign.at_distance(sheet.head, distance);
        sheet.show(&mut picture, &sign, view.viewer.eye(view.eye));
    }
    Ok(picture)
}

/// Draws white for the left eye, or a single one, and black for the right eye.
pub(super) fn eye_swap(view: &ScreenView<'_>) -> Result<Picture, PictureError> {
    let code = if view.eye == Eye::Right { 0 } else { 255 };
    flat(view, [code; 3])
}
