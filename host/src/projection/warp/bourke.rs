//! Bourke's mesh for image warping: text that players of dome masters read
//! ("Mesh format for image warping", 2006).
//!
//! The first line is the mesh's type, 2 for a grid of rows and columns; the second its columns and
//! rows; then a line a node, from the lower left one, row by row: x y u v i. (x, y) is on the
//! projector's picture, y from −1 at its lower edge to 1 and x from minus to plus its width by
//! height; (u, v) is on the screen's picture, 0 to 1 from its lower left corner; i is the factor on
//! codes, so the code of the projector's share of the light, and −1 for nodes that are not drawn,
//! nor the cells around them. The lift of black levels has no place in this format.

use super::Warp;
use std::io::{self, Write};

const RECTANGULAR: u32 = 2;

/// Writes the mesh.
///
/// # Errors
/// What writing reports.
pub fn write(warp: &Warp<'_>, to: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let [columns, rows] = warp.grid;
    let size = warp.projector().resolution.map(f64::from);
    let aspect = size[0] / size[1];
    let [gamma, ..] = &warp.projector().gamma;
    writeln!(to, "{RECTANGULAR}\n{columns} {rows}")?;
    for row in (0..rows).rev() {
        for column in 0..columns {
            let at = warp.at(column, row);
            let (x, y) = (aspect * (2.0 * at.x - 1.0), 1.0 - 2.0 * at.y);
            match warp.node(column, row) {
                Some(node) => {
                    let (u, v) = (node.place.x, 1.0 - node.place.y);
                    let factor = gamma.code(node.weight);
                    if factor == 1.0 {
                        writeln!(to, "{x:.7} {y:.7} {u:.7} {v:.7} 1")?;
                    } else {
                        writeln!(to, "{x:.7} {y:.7} {u:.7} {v:.7} {factor:.7}")?;
                    }
                }
                None => writeln!(to, "{x:.7} {y:.7} 0 0 -1")?,
            }
        }
    }
    Ok(())
}
