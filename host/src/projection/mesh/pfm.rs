//! Portable float maps: three numbers a node, the lowest row first.

use super::{Mesh, Shares, Targets, Unreadable};
use glam::{DVec2, DVec3};

const HELP: &str = "a PFM is the lines PF, columns and rows, and -1, then three floats a node";

/// The values of a map, in rows from the upper left one.
pub(super) struct Points {
    size: [usize; 2],
    values: Vec<[f32; 3]>,
}

/// A rectangle of an image's picture: its left and upper edge, its width and its height.
pub(super) type Region = [f64; 4];

impl Points {
    pub(super) fn read(bytes: &[u8]) -> Result<Self, Unreadable> {
        let fault = |message: &str| (message.to_owned(), HELP);
        let mut rest = bytes;
        let mut word = || {
            let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
            let length = rest[start..].iter().position(u8::is_ascii_whitespace)?;
            let (word, after) = rest[start..].split_at(length);
            // One blank ends a word: the next byte may be a float's.
            rest = &after[1..];
            std::str::from_utf8(word).ok()
        };
        let header = (|| {
            let kind = word()?;
            let size = [word()?.parse().ok()?, word()?.parse().ok()?];
            let scale: f64 = word()?.parse().ok()?;
            (kind == "PF").then_some((size, scale))
        })();
        let (size, scale): ([usize; 2], f64) =
            header.ok_or_else(|| fault("its header is wrong"))?;
        Mesh::check_size(size)?;
        let [columns, rows] = size;
        if rest.len() != 12 * columns * rows {
            return Err(fault(
                "it is too short or too long for its columns and rows",
            ));
        }
        let float = |bytes: &[u8]| {
            let bytes = <[u8; 4]>::try_from(bytes).unwrap_or_default();
            if scale > 0.0 {
                f32::from_be_bytes(bytes)
            } else {
                f32::from_le_bytes(bytes)
            }
        };
        let node = |bytes: &[u8]| [float(&bytes[..4]), float(&bytes[4..8]), float(&bytes[8..])];
        let lines = rest.chunks_exact(12 * columns).rev();
        let values = lines
            .flat_map(|line| line.chunks_exact(12).map(node))
            .collect();
        Ok(Self { size, values })
    }

    /// Returns whether no node has a third number.
    pub(super) fn are_flat(&self) -> bool {
        self.values.iter().all(|value| value[2].is_nan())
    }

    /// Returns the mesh of nodes in the middles of cells, continued to the picture's edges: points in
    /// units of `unit` metres, or, where they are flat, places in the screen's picture, of which
    /// `region` is the part that 0 to 1 stand for.
    pub(super) fn mesh(
        &self,
        is_flat: bool,
        unit: f64,
        region: Option<Region>,
    ) -> Result<Mesh, Unreadable> {
        let is_infinite = self
            .values
            .iter()
            .flatten()
            .any(|value| value.is_infinite());
        if is_infinite {
            return Err(("it has infinite numbers".to_owned(), HELP));
        }
        let [left, top, width, height] = region.unwrap_or([0.0, 0.0, 1.0, 1.0]);
        let along =
            |number: usize, count: usize| ((number as f64 - 0.5) / count as f64).clamp(0.0, 1.0);
        let size = self.size.map(|side| side + 2);
        let nodes = || (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| [column, row]));
        let at = nodes().map(|[x, y]| DVec2::new(along(x, self.size[0]), along(y, self.size[1])));
        let at = at.collect();
        let places = |value: DVec3| DVec2::new(left + width * value.x, top + height * value.y);
        let targets = if is_flat {
            Targets::Places(nodes().map(|node| places(self.continued(node))).collect())
        } else {
            Targets::Points(nodes().map(|node| unit * self.continued(node)).collect())
        };
        Ok(Mesh {
            size,
            at,
            targets,
            shares: Shares::Blended,
        })
    }

    /// Returns a node of the grid with a border: half a step past the outermost nodes, along the line
    /// of the two next to it.
    fn continued(&self, [column, row]: [usize; 2]) -> DVec3 {
        let [columns, rows] = self.size;
        let value = |x: usize, y: usize| DVec3::from(self.values[y * columns + x].map(f64::from));
        let inner = |number: usize, count: usize| number.clamp(1, count) - 1;
        let (x, y) = (inner(column, columns), inner(row, rows));
        let step = |number: usize, count: usize, place: usize| match number {
            0 => Some(place + 1),
            _ if number > count => Some(place - 1),
            _ => None,
        };
        let here = value(x, y);
        let across = step(column, columns, x).map(|next| 0.5 * (here - value(next, y)));
        let down = step(row, rows, y).map(|next| 0.5 * (here - value(x, next)));
        here + across.unwrap_or(DVec3::ZERO) + down.unwrap_or(DVec3::ZERO)
    }
}
