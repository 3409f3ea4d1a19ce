//! Reads Bourke's meshes; [`warp::bourke`](super::super::warp::bourke) describes and writes them.

use super::{Mesh, Shares, Targets, Unreadable};
use glam::DVec2;

const HELP: &str = "Bourke's format is a line with the type 2, a line with columns and rows, and a \
                    line x y u v i for each node, from the lower left one";

/// Reads a mesh for a picture of this resolution.
pub(super) fn read(bytes: &[u8], resolution: [u32; 2]) -> Result<Mesh, Unreadable> {
    let fault = |message: String| (message, HELP);
    let text = std::str::from_utf8(bytes)
        .map_err(|_| fault("it is neither Bourke's text, PFM nor MPCDI".to_owned()))?;
    let mut lines = text
        .lines()
        .zip(1..)
        .filter(|(line, _)| !line.trim().is_empty());
    let mut numbers = |count: usize| {
        let (line, number) = lines
            .next()
            .ok_or_else(|| fault("nodes are missing at its end".to_owned()))?;
        let found: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match found {
            Ok(found) if found.len() == count && found.iter().all(|value| value.is_finite()) => {
                Ok(found)
            }
            _ => Err(fault(format!(
                "line {number} does not have {count} finite numbers"
            ))),
        }
    };
    let kind = numbers(1)?[0];
    if kind != 2.0 {
        let help = "only rectangular grids, type 2, are read";
        return Err((format!("it is of type {kind}"), help));
    }
    let size = numbers(2)?;
    let size = [size[0] as usize, size[1] as usize];
    Mesh::check_size(size)?;
    let [columns, rows] = size;
    // A node has at least five digits and as many blanks.
    if 10 * columns * rows > bytes.len() + 1 {
        return Err(fault("nodes are missing at its end".to_owned()));
    }
    let aspect = f64::from(resolution[0]) / f64::from(resolution[1]);
    let mut at = vec![DVec2::NAN; columns * rows];
    let mut places = at.clone();
    let mut factors = vec![1.0; columns * rows];
    for row in (0..rows).rev() {
        for index in row * columns..(row + 1) * columns {
            let node = numbers(5)?;
            at[index] = DVec2::new(0.5 * (node[0] / aspect + 1.0), 0.5 * (1.0 - node[1]));
            if node[4] >= 0.0 {
                places[index] = DVec2::new(node[2], 1.0 - node[3]);
                factors[index] = node[4].min(1.0);
            }
        }
    }
    if lines.next().is_some() {
        return Err(fault(format!("it has more than {columns} × {rows} nodes")));
    }
    let is_blended = factors.iter().all(|factor| *factor == 1.0);
    Ok(Mesh {
        size,
        at,
        targets: Targets::Places(places),
        shares: if is_blended {
            Shares::Blended
        } else {
            Shares::Nodes(factors)
        },
    })
}
