//! All screens in one picture: unfolded into a [`net`], or as the [`viewer`] sees them.

pub mod net;
pub mod viewer;

#[cfg(test)]
mod walls {
    use crate::cave::{BuiltInCave, Cave, Wall};

    /// Returns walls of a cube from −1 to 1 along each axis.
    pub(super) fn cube<const N: usize>(names: [&str; N]) -> [Wall; N] {
        let cave = Cave::built_in(BuiltInCave::Cube, [1; 2]).unwrap();
        names.map(|name| {
            let mut wall = cave
                .walls
                .iter()
                .find(|wall| wall.name == name)
                .unwrap()
                .clone();
            wall.lower_left /= 1.5;
            wall.lower_right /= 1.5;
            wall.upper_left /= 1.5;
            wall
        })
    }
}
