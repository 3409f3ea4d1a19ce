//! Warps: what a projector has to show, for other programs.
//!
//! The light of each node of a grid over the picture of a [`Projector`] is followed to its screen:
//! to a place of the screen's picture and a point of the room. The screens' pictures are right for a
//! viewer anywhere, so the warps are.
//!
//! A warp is written as [`bourke`]'s mesh, for players of pictures, or as [`mpcdi`], for programs
//! that know the viewer's eye. Both have the projector's share of light in overlaps.

pub mod bourke;
pub mod mpcdi;

use super::{Blend, Map, Projector};
use crate::cave::{RoomError, Screen};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Where light of a node meets a screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// In the room: metres.
    pub point: DVec3,
    /// In the screen's picture: 0 to 1 from its upper left corner, to the right and downwards.
    pub place: DVec2,
    /// The projector's share of the light there, 0 to 1.
    pub weight: f64,
}

/// Where the nodes of a grid are on a projector's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nodes {
    /// From edge to edge: a mesh to draw a picture on.
    Corners,
    /// In the middle of the grid's cells: with as many as pixels, in theirs.
    Centres,
}

/// A projector beside the others of its screen, and a grid of nodes over its picture.
#[derive(Debug, Clone, Copy)]
pub struct Warp<'a> {
    blend: &'a Blend<'a>,
    member: usize,
    grid: [u32; 2],
    nodes: Nodes,
}

impl<'a> Warp<'a> {
    /// Most nodes along a side.
    pub const MOST_NODES: u32 = 16_384;

    /// Follows the light of `grid` columns and rows of nodes, of one of the projectors that light a
    /// screen together.
    ///
    /// # Errors
    /// A name that none of them has; a grid of no nodes, of more than [`Self::MOST_NODES`] a side
    /// or, at [`Nodes::Corners`], of one.
    pub fn new(
        blend: &'a Blend<'a>,
        projector: &str,
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
        let mut members = blend.members.iter();
        let member = members.position(|member| member.projector.name == projector);
        let member = member.ok_or_else(|| {
            let names = blend.projectors().map(|one| one.name.as_str());
            let names = names.collect::<Vec<_>>().join(", ");
            let message = format!("there is no projector \"{projector}\" on this screen");
            RoomError::new("name", message, format!("name one of: {names}"))
        })?;
        Ok(Self {
            blend,
            member,
            grid,
            nodes,
        })
    }

    /// Returns the projector's screen.
    pub fn screen(&self) -> Screen<'a> {
        self.map().screen()
    }

    fn map(&self) -> &Map<'a> {
        &self.blend.members[self.member].map
    }

    fn projector(&self) -> &'a Projector {
        self.blend.members[self.member].projector
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

    /// Returns where a node's light meets the screen; `None` where it does not.
    pub fn node(&self, column: u32, row: u32) -> Option<Node> {
        let at = self.at(column, row);
        let place = self.map().place(at)?;
        Some(Node {
            point: self.map().screen().point(place),
            place,
            weight: self.blend.share(self.member, at, place)[0],
        })
    }

    /// Returns how many nodes' light meets the screen.
    pub fn drawn(&self) -> u64 {
        let [columns, rows] = self.grid;
        let in_row = |row| {
            let nodes =
                (0..columns).filter(|column| self.map().place(self.at(*column, row)).is_some());
            nodes.count() as u64
        };
        (0..rows).into_par_iter().map(in_row).sum()
    }
}
