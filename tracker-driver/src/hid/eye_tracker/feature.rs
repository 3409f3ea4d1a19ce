//! Feature reports: a device's capabilities, configuration and status, and its output.

/// Capabilities of a device, in metres; `None` if the device does not report one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Capabilities {
    /// 1 if the gaze is accurate enough for fine work.
    pub quality: Option<u32>,
    /// Least distance of the user.
    pub nearest: Option<f32>,
    /// Best distance of the user.
    pub best: Option<f32>,
    /// Greatest distance of the user.
    pub furthest: Option<f32>,
    /// Greatest width of the screen.
    pub widest_screen: Option<f32>,
    /// Greatest height of the screen.
    pub highest_screen: Option<f32>,
}

/// Configuration of a device: the display, and its calibrated part in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Configuration {
    /// The display's manufacturer code, from its EDID.
    pub manufacturer: Option<u32>,
    /// The display's product number.
    pub product: Option<u32>,
    /// The display's serial number.
    pub serial_number: Option<u32>,
    /// The display's date of manufacture.
    pub manufacturer_date: Option<u32>,
    /// Width of the calibrated part.
    pub screen_width: Option<f32>,
    /// Height of the calibrated part.
    pub screen_height: Option<f32>,
}

/// Status of a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// The status's number: [`status_name`] has its meaning.
    pub configuration: Option<u32>,
    /// Samples per second.
    pub sampling_frequency: Option<f32>,
}

/// Returns the meaning of a device's status; empty if it is not known.
pub fn status_name(status: u32) -> &'static str {
    match status {
        1 => "ready",
        2 => "configuring",
        3 => "the screen has to be set up",
        4 => "the user has to be calibrated",
        _ => "",
    }
}

/// The data that a device is asked to send; no data asks it to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Mode {
    /// The gaze point.
    pub gaze_point: bool,
    /// Positions of the eyes.
    pub eye_positions: bool,
    /// Pose of the head.
    pub head_position: bool,
}

impl Mode {
    /// No data: a request to stop.
    pub const STOP: Self = Self {
        gaze_point: false,
        eye_positions: false,
        head_position: false,
    };

    /// All data.
    pub const ALL: Self = Self {
        gaze_point: true,
        eye_positions: true,
        head_position: true,
    };

    /// Returns the bits of the feature report.
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
    /// The report begins with another report id.
    #[error("a report with id {found:#04x} where {expected:#04x} was asked for")]
    ReportId {
        /// The requested report's id.
        expected: u8,
        /// The id that came.
        found: u8,
    },
    /// The report is shorter than the descriptor says.
    #[error("a report of {found} bytes where the descriptor says {expected}")]
    Length {
        /// Bytes of the report, with its id.
        expected: usize,
        /// Bytes that came.
        found: usize,
    },
}
