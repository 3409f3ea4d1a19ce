//! Warps: how projectors have to show a dome master so that it is right on the dome.
//!
//! The light of each node of a grid over the picture of a [`Projector`] is followed to where it
//! meets the dome's inside: (u, v) in the dome master, (x, y, z) in the room. The dome's pictures
//! have the same geometry ([`DomeScreen`]), so they are right for a viewer anywhere in the dome.
//!
//! A warp is written as [`bourke`]'s mesh, for players of dome masters, or as [`mpcdi`], for
//! programs that know the viewer's eye. A node is drawn in full where its light meets the dome,
//! else not at all: edges are not blended.

pub mod bourke;
pub mod mpcdi;
mod projector;

pub use projector::Projector;

use crate::cave::{DomeScreen, RoomError};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Where light of a node meets a dome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// In the room: metres.
    pub point: DVec3,
    /// In the dome master: u to the right and v to the top, in the unit disc.
    pub place: DVec2,
}

/// Where the nodes of a grid are on a projector's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nodes {
    /// From edge to edge: a mesh to draw a picture on.
    Corners,
    /// In the middle of the grid's cells: with as many as pixels, in theirs.
    Centres,
}

/// A projector, a dome, and a grid of nodes between them.
#[derive(Debug, Clone, Copy)]
pub struct Warp<'a> {
    dome: &'a DomeScreen,
    projector: &'a Projector,
    grid: [u32; 2],
    nodes: Nodes,
}

impl<'a> Warp<'a> {
    /// Most nodes along a side.
    pub const MOST_NODES: u32 = 16_384;

    /// Follows the light of `grid` columns and rows of nodes.
    ///
    /// # Errors
    /// A grid of no nodes, of more than [`Self::MOST_NODES`] a side or, at
    /// [`Nodes::Corners`], of one; light that does not meet the dome.
    pub fn new(
        dome: &'a DomeScreen,
        projector: &'a Projector,
        grid: [u32; 2],
        nodes: Nodes,
    ) -> Result<Self, RoomError> {
        let least = match nodes {
            Nodes::Corners => 2,
            Nodes::Centres => 1,
        };
        if grid
            .iter()
            .any(|side| !(least..=Self::MOST_NODES).contains(side))
        {
            return Err(RoomError::new(
                "grid",
                format!("a grid of {} × {} nodes", grid[0], grid[1]),
                format!("give {least} to {} nodes a side", Self::MOST_NODES),
            ));
        }
        let warp = Self {
            dome,
            projector,
            grid,
            nodes,
        };
        if warp.drawn() == 0 {
            let (name, centre) = (&dome.name, dome.centre);
            return Err(RoomError::new(
                "look",
                format!(
                    "projector \"{}\" does not see dome \"{name}\": none of its light meets the \
                     inside",
                    projector.name
                ),
                format!(
                    "turn it towards the dome with look, or yaw_degrees and pitch_degrees, and \
                     place it inside or before the opening: the centre is at {}, {}, {}, the \
                     radius {} m",
                    centre.x, centre.y, centre.z, dome.radius
                ),
            ));
        }
        Ok(warp)
    }

    /// Returns where a node is on the projector's picture: 0 to 1 from its upper left
    /// corner, to the right and downwards.
    pub fn at(&self, column: u32, row: u32) -> DVec2 {
        let along = |number: u32, count: u32| match self.nodes {
            Nodes::Corners => f64::from(number) / f64::from(count - 1),
            Nodes::Centres => (f64::from(number) + 0.5) / f64::from(count),
        };
        DVec2::new(along(column, self.grid[0]), along(row, self.grid[1]))
    }

    /// Returns where a node's light meets the dome's inside; `None` where it does not.
    pub fn node(&self, column: u32, row: u32) -> Option<Node> {
        let direction = self.projector.direction(self.at(column, row));
        let place = self.dome.lit(self.projector.position, direction)?;
        Some(Node {
            point: self.dome.point(place),
            place,
        })
    }

    /// Returns how many nodes' light meets the dome.
    pub fn drawn(&self) -> u64 {
        let [columns, rows] = self.grid;
        let in_row = |row| {
            let nodes = (0..columns).filter_map(|column| self.node(column, row));
            nodes.count() as u64
        };
        (0..rows).into_par_iter().map(in_row).sum()
    }
}

#[cfg(test)]
mod tests;
