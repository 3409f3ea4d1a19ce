//! Usages of the page "Eye and Head Trackers", 0x12, from the HID Usage
//! Tables 1.5 (HUTRR74).

/// The page.
pub const PAGE: u16 = 0x12;

/// An eye tracker; an application collection.
pub const EYE_TRACKER: u16 = 0x01;
/// A head tracker; an application collection.
pub const HEAD_TRACKER: u16 = 0x02;
/// The collection of what was measured.
pub const TRACKING_DATA: u16 = 0x10;
/// The collection of what the device can do.
pub const CAPABILITIES: u16 = 0x11;
/// The collection of how the device was set up.
pub const CONFIGURATION: u16 = 0x12;
/// The collection of how the device is.
pub const STATUS: u16 = 0x13;
/// The collection of what the device is asked to do.
pub const CONTROL: u16 = 0x14;

/// When it was measured.
pub const SENSOR_TIMESTAMP: u16 = 0x20;
/// A coordinate; the collection around it says of what.
pub const POSITION_X: u16 = 0x21;
/// See [`POSITION_X`].
pub const POSITION_Y: u16 = 0x22;
/// See [`POSITION_X`].
pub const POSITION_Z: u16 = 0x23;
/// The collection of a point on the screen that is looked at.
pub const GAZE_POINT: u16 = 0x24;
/// The collection of where the left eye is.
pub const LEFT_EYE_POSITION: u16 = 0x25;
/// The collection of where the right eye is.
pub const RIGHT_EYE_POSITION: u16 = 0x26;
/// The collection of where the head is.
pub const HEAD_POSITION: u16 = 0x27;
/// The collection of the point that the head is turned to.
pub const HEAD_DIRECTION_POINT: u16 = 0x28;
/// How far the head is turned about the axis X.
pub const ROTATION_X: u16 = 0x29;
/// See [`ROTATION_X`].
pub const ROTATION_Y: u16 = 0x2A;
/// See [`ROTATION_X`].
pub const ROTATION_Z: u16 = 0x2B;

/// How good the gaze is; 1 is good enough for fine work.
pub const TRACKER_QUALITY: u16 = 0x100;
/// The nearest that a user may be.
pub const MINIMUM_TRACKING_DISTANCE: u16 = 0x101;
/// The best distance of a user.
pub const OPTIMUM_TRACKING_DISTANCE: u16 = 0x102;
/// The furthest that a user may be.
pub const MAXIMUM_TRACKING_DISTANCE: u16 = 0x103;
/// The widest screen that the device can serve.
pub const MAXIMUM_SCREEN_PLANE_WIDTH: u16 = 0x104;
/// The highest screen that the device can serve.
pub const MAXIMUM_SCREEN_PLANE_HEIGHT: u16 = 0x105;

/// The display that the device is calibrated for.
pub const DISPLAY_MANUFACTURER_ID: u16 = 0x200;
/// See [`DISPLAY_MANUFACTURER_ID`].
pub const DISPLAY_PRODUCT_ID: u16 = 0x201;
/// See [`DISPLAY_MANUFACTURER_ID`].
pub const DISPLAY_SERIAL_NUMBER: u16 = 0x202;
/// See [`DISPLAY_MANUFACTURER_ID`].
pub const DISPLAY_MANUFACTURER_DATE: u16 = 0x203;
/// The width of the calibrated part of the screen.
pub const CALIBRATED_SCREEN_WIDTH: u16 = 0x204;
/// The height of the calibrated part of the screen.
pub const CALIBRATED_SCREEN_HEIGHT: u16 = 0x205;

/// Samples per second.
pub const SAMPLING_FREQUENCY: u16 = 0x300;
/// Whether the device is ready.
pub const CONFIGURATION_STATUS: u16 = 0x301;

/// What the device is asked to send.
pub const DEVICE_MODE_REQUEST: u16 = 0x400;
