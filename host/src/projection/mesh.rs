//! Meshes of projectors: where the nodes of a grid over a projector's picture lie on its screen.
//!
//! [`Mesh::load`] reads Bourke's text, a PFM, and MPCDI as an archive, a folder or its XML alone.
//! Between the nodes of a cell, both ways are bilinear. Cells with a node that is not drawn are not
//! drawn.

mod bourke;
mod cells;
mod mpcdi;
mod pfm;

pub(super) use cells::{Cells, Flaws};

use crate::cave::RoomError;
use crate::files;
use glam::{DVec2, DVec3};
use std::io;
use std::path::Path;

/// A grid of nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Columns and rows of nodes.
    pub(super) size: [usize; 2],
    /// Where they are on the projector's picture: 0 to 1 to the right and downwards. In rows, from
    /// the upper left one.
    pub(super) at: Vec<DVec2>,
    pub(super) targets: Targets,
    pub(super) shares: Shares,
}

/// Where nodes lie; NaN for nodes that are not drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Targets {
    /// In the screen's picture: 0 to 1 from its upper left corner.
    Places(Vec<DVec2>),
    /// In the room, metres.
    Points(Vec<DVec3>),
}

/// Which share of its screen's light the mesh's file gives to the projector.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shares {
    /// The file does not say: the projector is blended with its neighbours.
    Blended,
    /// Factors on the codes of each node.
    Nodes(Vec<f64>),
    /// Linear factors on the light, and the light that is added.
    Maps(Grey, Option<Grey>),
}

/// A map of numbers over a projector's picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grey {
    pub(super) size: [usize; 2],
    /// In rows, from the upper left one.
    pub(super) values: Vec<f32>,
}

impl Grey {
    /// Returns the value at a point of the picture, 0 to 1: bilinear between the middles of values.
    pub(super) fn at(&self, at: DVec2) -> f64 {
        let [x, y] = [0, 1].map(|axis| {
            let last = (self.size[axis] - 1) as f64;
            let place = (at[axis] * (last + 1.0) - 0.5).clamp(0.0, last);
            let low = place as usize;
            (low, (low + 1).min(last as usize), place - low as f64)
        });
        let value = |x: usize, y: usize| f64::from(self.values[y * self.size[0] + x]);
        let row = |y| value(x.0, y) + x.2 * (value(x.1, y) - value(x.0, y));
        row(y.0) + y.2 * (row(y.1) - row(y.0))
    }
}

impl Mesh {
    /// Most nodes along a side.
    const MOST_NODES: usize = 16_384;

    /// Reads the mesh of the projector `name`, whose picture has `resolution` columns and rows.
    pub(super) fn load(path: &Path, name: &str, resolution: [u32; 2]) -> Result<Self, RoomError> {
        let fault = |message: &str, help: &str| {
            let message = format!("the mesh {}: {message}", path.display());
            RoomError::new("mesh", message, help)
        };
        let unread = |reason: io::Error| fault(&reason.to_string(), files::UNREAD);
        if path.is_dir() {
            return mpcdi::of_folder(path, name).map_err(|(message, help)| fault(&message, help));
        }
        let bytes = files::read_within(path, MOST_MIB).map_err(unread)?;
        let read = if bytes.starts_with(b"PK") {
            mpcdi::of_archive(&bytes, name)
        } else if bytes.starts_with(b"PF") {
            pfm::Points::read(&bytes).and_then(|points| {
                let is_flat = points.are_flat();
                points.mesh(is_flat, 1.0, None)
            })
        } else if bytes.trim_ascii_start().starts_with(b"<") {
            mpcdi::of_xml(&bytes, path.parent().unwrap_or(Path::new("")), name)
        } else {
            bourke::read(&bytes, resolution)
        };
        let mesh = read.map_err(|(message, help)| fault(&message, help))?;
        let is_drawn = match &mesh.targets {
            Targets::Places(places) => places.iter().any(|place| !place.is_nan()),
            Targets::Points(points) => points.iter().any(|point| !point.is_nan()),
        };
        if is_drawn {
            return Ok(mesh);
        }
        Err(fault(
            "nothing of it is drawn",
            "export it again, with the projector's area",
        ))
    }

    /// Refuses grids without cells and those too large.
    fn check_size(size: [usize; 2]) -> Result<(), Unreadable> {
        let mut sides = size.iter();
        if sides.all(|side| (2..=Self::MOST_NODES).contains(side)) {
            return Ok(());
        }
        let message = format!("it has {} × {} nodes", size[0], size[1]);
        Err((message, "a mesh has 2 to 16384 nodes a side"))
    }
}

/// Most MiB of a file of a mesh, unpacked; few in tests, which make larger ones.
const MOST_MIB: u64 = if cfg!(test) { 4 } else { 512 };

/// Why a file cannot be read, and what to do.
type Unreadable = (String, &'static str);

#[cfg(test)]
mod tests;
