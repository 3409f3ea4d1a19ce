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

/// Quality; nearest, best and furthest distance; width and height of the largest screen.
pub(super) const CAPABILITIES: [u16; 6] = [0x100, 0x101, 0x102, 0x103, 0x104, 0x105];
/// The display's maker, product, serial number and date; its width and height.
pub(super) const CONFIGURATION: [u16; 6] = [0x200, 0x201, 0x202, 0x203, 0x204, 0x205];
/// How the device is, and samples per second.
pub(super) const STATUS: [u16; 2] = [0x301, 0x300];
/// What the device is asked to send.
pub(super) const CONTROL: [u16; 1] = [0x400];
