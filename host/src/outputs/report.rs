//! Counts of what monitors showed.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// What monitors showed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OutputsReport {
    /// Each output.
    pub outputs: Vec<PaneReport>,
    /// Frames that all outputs showed, where there are several.
    pub compared_frames: u64,
    /// Frames of these that some outputs showed half a refresh or more after others.
    pub parted_frames: u64,
    /// Time from the first to the last output that showed a frame: median, 99 % and longest,
    /// milliseconds; null with one output.
    pub spread_ms: Option<[f64; 3]>,
}

/// What a monitor showed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PaneReport {
    /// The screen or the projector.
    pub shows: String,
    /// The monitor.
    pub monitor: String,
    /// Whether rays went through its own pixels; null for a screen.
    pub direct: Option<bool>,
    /// Refreshes per second, as measured from the server's times.
    pub hz: f64,
    /// Frames shown.
    pub shown: u64,
    /// Frames shown later than at the refresh that they were for.
    pub late: u64,
    /// Refreshes between frames at which the frame before was shown again.
    pub repeated: u64,
    /// Frames not shown: the monitor was away or its server did not answer.
    pub missed: u64,
    /// Refreshes that showed the wrong eye; null where eyes take no turns.
    pub wrong_eyes: Option<u64>,
}

impl fmt::Display for OutputsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:20} {:>12} {:>9} {:>7} {:>7} {:>9} {:>7}",
            "shows", "monitor", "Hz", "shown", "late", "repeated", "missed"
        )?;
        for one in &self.outputs {
            let PaneReport {
                shows,
                monitor,
                direct,
                hz,
                shown,
                late,
                repeated,
                missed,
                wrong_eyes,
            } = one;
            write!(
                f,
                "\n{shows:20} {monitor:>12} {hz:9.3} {shown:7} {late:7} {repeated:9} {missed:7}"
            )?;
            if let Some(is_direct) = direct {
                let way = if *is_direct {
                    "traced directly"
                } else {
                    "warped"
                };
                write!(f, ", {way}")?;
            }
            if let Some(wrong) = wrong_eyes {
                write!(f, ", the wrong eye at {wrong} refreshes")?;
            }
        }
        if let Some([median, most, longest]) = self.spread_ms {
            let (parted, compared) = (self.parted_frames, self.compared_frames);
            write!(
                f,
                "\n{parted} of {compared} frames were on some screens a refresh before others; \
                 from the first to the last screen {median:.2} ms, 99 % within {most:.2} ms, at \
                 most {longest:.2} ms"
            )?;
        }
        Ok(())
    }
}
