//! The walls of a CAVE and the eyes before them.

use glam::DVec3;

/// A flat screen, by three corners as its viewer sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// For file names and messages.
    pub name: String,
    /// Metres, in the room.
    pub lower_left: DVec3,
    /// Metres, in the room.
    pub lower_right: DVec3,
    /// Metres, in the room. The picture's first pixel is at this corner.
    pub upper_left: DVec3,
    /// Columns and rows.
    pub pixels: [u32; 2],
}
