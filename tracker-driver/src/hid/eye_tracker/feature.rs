//! What feature reports say and ask for.

/// What a device can do, in metres; `None` where it does not say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Capabilities {
    /// 1 where the gaze is good enough for fine work.
    pub quality: Option<u32>,
    /// The nearest that a user may be.
    pub nearest: Option<f32>,
    /// The best distance.
    pub best: Option<f32>,
    /// The furthest that a user may be.
    pub furthest: Option<f32>,
    /// The widest screen that it can serve.
    pub widest_screen: Option<f32>,
    /// The highest screen that it can serve.
    pub highest_screen: Option<f32>,
}

/// How a device was set up: the display, and its calibrated part in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Configuration {
    /// The display's maker, as in its EDID.
    pub manufacturer: Option<u32>,
    /// The display's product number.
    pub product: Option<u32>,
    /// The display's serial number.
    pub serial_number: Option<u32>,
    /// When the display was made.
    pub manufacturer_date: Option<u32>,
    /// How wide the calibrated part is.
    pub screen_width: Option<f32>,
    /// How high the calibrated part is.
    pub screen_height: Option<f32>,
}

/// How a device is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// By number, see [`status_name`].
    pub configuration: Option<u32>,
    /// Samples per second.
    pub sampling_frequency: Option<f32>,
}

/// What a device's status means; empty where that is not known.
pub fn status_name(status: u32) -> &'static str {
    match status {
        1 => "ready",
        2 => "configuring",
        3 => "the screen has to be set up",
        4 => "the user has to be calibrated",
        _ => "",
    }
}

/// What a device is asked to send; nothing of it is a request to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Mode {
    /// The gaze point.
    pub gaze_point: bool,
    /// Where the eyes are.
    pub eye_positions: bool,
    /// Where the head is.
    pub head_position: bool,
}

impl Mode {
    /// Nothing.
    pub const STOP: Self = Self {
        gaze_point: false,
        eye_positions: false,
        head_position: false,
    };

    /// Everything.
    pub const ALL: Self = Self {
        gaze_point: true,
        eye_positions: true,
        head_position: true,
    };

    /// As the device takes it.
    pub const fn bits(self) -> u8 {
        self.gaze_point as u8 | (self.eye_positions as u8) << 1 | (self.head_position as u8) << 2
    }
}

/// Why a feature report cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReportError {
    /// The device's descriptor has no such report.
    #[error("the device's descriptor has no such report")]
    NotDescribed,
    /// It begins with another report id.
    #[error("a report with id {found:#04x} where {expected:#04x} was asked for")]
    ReportId {
        /// The id of the report that was asked for.
        expected: u8,
        /// The id found.
        found: u8,
    },
    /// It is shorter than the descriptor says.
    #[error("a report of {found} bytes where the descriptor says {expected}")]
    Length {
        /// Bytes of the report, with its id.
        expected: usize,
        /// Bytes found.
        found: usize,
    },
}
