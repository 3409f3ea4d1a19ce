//! Walls from rooms of other programs: nDisplay, Vrui, VR Juggler, MiddleVR.

mod middlevr;
mod ndisplay;
mod vr_juggler;
mod vrui;

use super::{Cave, Wall};
use crate::files::Fault;
use glam::DVec3;
use roxmltree::Document;

/// Walls of another program's room.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedRoom {
    /// The program.
    pub program: &'static str,
    /// In the order of the file.
    pub walls: Vec<Wall>,
    /// What the file has and a room's file has not: words for a message.
    pub ignored: Vec<String>,
}

impl ImportedRoom {
    /// Farthest that a fourth corner may be from the other three's parallelogram, metres.
    const FOURTH_CORNER: f64 = 0.001;

    /// Reads a file of nDisplay (`.ndisplay`), Vrui (`.cfg`), VR Juggler (`.jconf`) or MiddleVR
    /// (`.vrx`). `section` is the root section of a Vrui file that has several with screens. Screens
    /// have `size` pixels, those of nDisplay what the file says.
    ///
    /// # Errors
    /// Text that is none of these or has no screens; screens without a size or a place; four
    /// corners that are no parallelogram; walls as [`Cave::new`].
    pub fn from_text(text: &str, section: Option<&str>, size: [u32; 2]) -> Result<Self, Fault> {
        let start = text.trim_start();
        let mut room = if start.starts_with('{') {
            let room = ndisplay::read(text, size);
            return room.map_err(|fault| Fault::of(&fault));
        } else if start.starts_with('<') {
            let document = Document::parse(text).map_err(|error| {
                Fault::new(
                    format!("this is not valid XML: {error}"),
                    "export the file again",
                )
            })?;
            match document.root_element().tag_name().name() {
                "MiddleVR" => middlevr::read(&document)?,
                _ => vr_juggler::read(&document)?,
            }
        } else {
            vrui::read(text, section)?
        };
        if room.walls.is_empty() {
            return Err(Fault::new(
                "the file has no flat screens that stand in the room",
                "give the file that describes the screens: Vrui.cfg, a .jconf of VR Juggler's \
                 displays, or a .vrx of MiddleVR",
            ));
        }
        room.walls.iter_mut().for_each(|wall| wall.pixels = size);
        // Two of one name cannot be in a room.
        Cave::new(room.walls.clone()).map_err(|fault| Fault::of(&fault))?;
        Ok(room)
    }
}

impl ImportedRoom {
    /// Returns the text of a room's file.
    pub fn to_toml(&self) -> String {
        let entries = self
            .walls
            .iter()
            .map(|wall| wall.to_toml(Some(wall.pixels)));
        entries.collect::<Vec<_>>().join("\n")
    }
}

/// Returns a wall of four corners: lower left, lower right, upper right, upper left.
fn wall(name: &str, corners: [DVec3; 4]) -> Result<Wall, Fault> {
    let [lower_left, lower_right, upper_right, upper_left] = corners;
    let off = (lower_left - lower_right + upper_right - upper_left).length();
    if off > ImportedRoom::FOURTH_CORNER {
        return Err(Fault::new(
            format!(
                "screen \"{name}\" is no parallelogram: its upper right corner is {:.1} mm off",
                1000.0 * off
            ),
            "a wall has three corners: correct the fourth, or measure the wall with `shisen room \
             measure`",
        ));
    }
    Ok(Wall {
        name: name.to_owned(),
        lower_left,
        lower_right,
        upper_left,
        pixels: [1; 2],
    })
}

/// Reads numbers between commas, with or without brackets around them.
fn numbers<const N: usize>(text: &str, of: &str) -> Result<[f64; N], Fault> {
    let inner = text.trim().trim_start_matches('(').trim_end_matches(')');
    let numbers: Option<Vec<f64>> = inner
        .split(',')
        .map(|one| one.trim().parse().ok())
        .collect();
    let numbers = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| {
        let message = format!("{of}: \"{}\" is not {N} numbers", text.escape_debug());
        Fault::new(message, "correct it in the program that wrote the file")
    })
}

#[cfg(test)]
mod tests;
