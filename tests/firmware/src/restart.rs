//! Decides when a frame is cut short and the next begun: the viewer looks elsewhere by then.

use crate::board;
use crate::viewer::Viewer;
use glam::Vec3;
use shisen_core::gaze::VisualField;
use shisen_core::numeric;
use shisen_tracker::link::display::{FrameStart, Rendering};
use shisen_tracker::time::Micros;

/// Most frames that are cut short in a row: the next one is finished, even if the gaze
/// moves.
const MOST_IN_A_ROW: u8 = 3;

/// The line of sight of a frame, and the largest angle of the viewer's from it.
pub struct Restart {
    forward: Vec3,
    /// Cosine of the greatest angle between both.
    cosine: f32,
    display_delay: Micros,
    /// Number of the tracker's records that have been checked.
    records: u32,
}

impl Restart {
    /// Returns the rule for a frame; `None` if its detail does not follow the gaze, or if `in_a_row`,
    /// the number of frames cut short just before it, is at its limit.
    pub fn new(
        start: &FrameStart,
        rendering: &Rendering,
        viewer: &Viewer,
        in_a_row: u8,
    ) -> Option<Self> {
        let angle = rendering.restart_angle;
        start.state?;
        // A frame of full detail everywhere has it where the viewer looks now, too.
        VisualField::PAPER.wider(start.widen)?;
        (angle > 0.0 && in_a_row < MOST_IN_A_ROW).then(|| Self {
            forward: start.forward,
            cosine: numeric::sin_cos(angle.min(core::f32::consts::PI)).1,
            display_delay: Micros(rendering.display_delay.into()),
            records: viewer.records(),
        })
    }

    /// Returns whether the viewer looks elsewhere; checks each record of the tracker once.
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
