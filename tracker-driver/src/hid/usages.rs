//! Usages of the page "Eye and Head Trackers", 0x12, from the HID Usage Tables 1.5 (HUTRR74).

/// The page.
pub(super) const PAGE: u16 = 0x12;

// The collection of tracking data.
pub(super) const TRACKING_DATA: u16 = 0x10;

// Tracking data; a coordinate is one of the collection around it.
pub(super) const SENSOR_TIMESTAMP: u16 = 0x20;
pub(super) const POSITION_X: u16 = 0x21;
pub(super) const POSITION_Y: u16 = 0x22;
pub(super) const POSITION_Z: u16 = 0x23;
pub(super) const GAZE_POINT: u16 = 0x24;
pub(super) const LEFT_EYE_POSITION: u16 = 0x25;
pub(super) const RIGHT_EYE_POSITION: u16 = 0x26;
pub(super) const HEAD_POSITION: u16 = 0x27;
pub(super) const HEAD_DIRECTION_POINT: u16 = 0x28;
pub(super) const ROTATION_X: u16 = 0x29;
pub(super) const ROTATION_Y: u16 = 0x2A;
pub(super) const ROTATION_Z: u16 = 0x2B;

// Capabilities; distances and sizes are lengths.
pub(super) const TRACKER_QUALITY: u16 = 0x100;
pub(super) const MINIMUM_TRACKING_DISTANCE: u16 = 0x101;
pub(super) const OPTIMUM_TRACKING_DISTANCE: u16 = 0x102;
pub(super) const MAXIMUM_TRACKING_DISTANCE: u16 = 0x103;
pub(super) const MAXIMUM_SCREEN_PLANE_WIDTH: u16 = 0x104;
pub(super) const MAXIMUM_SCREEN_PLANE_HEIGHT: u16 = 0x105;

// The display that the device is calibrated for.
pub(super) const DISPLAY_MANUFACTURER_ID: u16 = 0x200;
pub(super) const DISPLAY_PRODUCT_ID: u16 = 0x201;
pub(super) const DISPLAY_SERIAL_NUMBER: u16 = 0x202;
pub(super) const DISPLAY_MANUFACTURER_DATE: u16 = 0x203;
pub(super) const CALIBRATED_SCREEN_WIDTH: u16 = 0x204;
pub(super) const CALIBRATED_SCREEN_HEIGHT: u16 = 0x205;

// Status and control.
pub(super) const SAMPLING_FREQUENCY: u16 = 0x300;
pub(super) const CONFIGURATION_STATUS: u16 = 0x301;
pub(super) const DEVICE_MODE_REQUEST: u16 = 0x400;
