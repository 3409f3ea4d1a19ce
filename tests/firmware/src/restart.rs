//! When a frame is cut short, and the next begun: the viewer looks elsewhere by now.

use crate::board;
use crate::viewer::Viewer;
use glam::Vec3;
use shisen_core::gaze::VisualField;
use shisen_core::numeric;
use shisen_tracker::link::display::{FrameStart, Rendering};
use shisen_tracker::time::Micros;

/// Frames that are cut short one after the other, at most: the next one is finished,
/// whatever the tracker says.
const MOST_IN_A_ROW: u8 = 3;

/// The line of sight of a frame, and how far the viewer's may be from it.
pub struct Restart {
    forward: Vec3,
    /// Cosine of the greatest angle between both.
    cosine: f32,
    display_delay: Micros,
    /// Records of the tracker that have been looked at.
    records: u32,
}

impl Restart {
    /// For a frame whose detail follows the gaze; `in_a_row` were cut short before it.
    pub fn new(
        start: &FrameStart,
        rendering: &Rendering,
        viewer: &Viewer,
        in_a_row: u8,
    ) -> Option<Self> {
        let angle = rendering.restart_angle;
        start.state?;
        // What is shown in full everywhere is so, too, where the viewer looks now.
        VisualField::PAPER.wider(start.widen)?;
        (angle > 0.0 && in_a_row < MOST_IN_A_ROW).then(|| Self {
            forward: start.forward,
            cosine: numeric::sin_cos(angle.min(core::f32::consts::PI)).1,
            display_delay: Micros(rendering.display_delay.into()),
            records: viewer.records(),
        })
    }

    /// Whether the viewer looks elsewhere; each record of the tracker is asked once.
    pub fn is_due(&mut self, viewer: &mut Viewer) -> bool {
        let records = viewer.records();
        if records == self.records {
            return false;
        }
        self.records = records;
        let shown = board::micros(board::ticks()).after(self.display_delay);
        let sight = viewer.estimate(shown).line_of_sight;
        sight.forward().dot(self.forward) < self.cosine
    }
}
