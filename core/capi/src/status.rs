//! Results of functions.

use core::ffi::{CStr, c_char};
use shisen_core::frame::{DomeError, FrameError, TileError, ViewError};
use shisen_core::gaze::LineOfSightError;
use shisen_core::scene::SceneError;
use shisen_tracker::command::Failure;

/// Least status that is a failure: the failed call has changed nothing, unless
/// its description says otherwise.
pub const SHISEN_FIRST_FAILURE: u32 = 16;

/// How a call went. From SHISEN_FIRST_FAILURE on it failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A tile's pixels are there.
    Tile = 1,
    /// The call's budget is spent; call again to go on.
    BudgetSpent = 2,
    /// All tiles of the frame have been handed over.
    Finished = 3,

    /// A pointer is NULL that may not be.
    NullPointer = 16,
    /// A pointer is not at a multiple of the alignment of what it points to.
    Misaligned = 17,
    /// The memory is less than what the functions and macros of sizes say.
    MemoryTooSmall = 18,
    /// A length is more than memory can be.
    TooLong = 19,
    /// The library was built without what is asked for.
    NotBuilt = 20,

    /// The scene is shorter than it says, or than a header. Number: bytes that
    /// it should have.
    SceneCutOff = 32,
    /// The scene is not at a multiple of SHISEN_BLOB_ALIGNMENT. Number: that.
    SceneMisaligned = 33,
    /// The bytes do not start like a scene.
    NotAScene = 34,
    /// The scene was baked by another version of the format. Number: which.
    SceneVersion = 35,
    /// The scene was baked in the fast layout for hosts, not in the compact one.
    /// Number: children of its nodes.
    SceneLayout = 36,
    /// The scene was damaged since it was baked. Number: its bytes' checksum.
    SceneChecksum = 37,
    /// A table is not inside the scene, or not aligned. Number: its byte.
    SceneTable = 38,
    /// A table has another length than the scene gives it. Number: its records.
    SceneCount = 39,
    /// A record names what is not there, or another's. Number: the record.
    SceneIndex = 40,
    /// Nodes are not a tree. Number: the node.
    SceneTree = 41,
    /// A tree is too deep for the traversal stack. Number: entries needed.
    SceneDepth = 42,
    /// A mesh does not fit its ladder of polygon levels. Number: the mesh.
    SceneLadder = 43,
    /// The scene says other effects than its records. Number: theirs.
    SceneEffects = 44,
    /// A record has a value that is out of range. Number: the record.
    SceneValue = 45,
    /// The scene is wrong in another way.
    SceneOther = 46,

    /// There is no protocol or eye of this number.
    UnknownChoice = 64,
    /// A tracker's pose is not finite or no rotation, or its delay out of range.
    TrackerSettings = 65,
    /// Nothing comes from the device, or nothing more: check that it is on and the
    /// cable is the right one, with its lines crossed or not.
    DeviceSilent = 66,
    /// Bytes come from the device, and no record among them: the line's speed or
    /// the protocol is not the device's.
    DeviceNoRecord = 67,
    /// Records come from the device, but not the one that was asked for.
    DeviceNoAnswer = 68,
    /// The device refused a command.
    DeviceRefused = 69,
    /// The commands do not fit the memory for them.
    DeviceCommands = 70,
    /// Most of what comes from the device is dropped: it speaks another protocol,
    /// has other settings, the line has another speed, or a sensor is not plugged
    /// in.
    DeviceUnlike = 71,

    /// The depth or the samples are out of range.
    FrameSettings = 96,
    /// Tiles have no pixels or more than 256 a side.
    TileSize = 97,
    /// A frame has no pictures or more than 65,535.
    Pictures = 98,
    /// A picture has no pixels or more than 65,536 a side.
    PictureSize = 99,
    /// The eye, or a dome master's place, is not finite or too far out.
    Eye = 100,
    /// The eye is behind a screen or in its plane.
    EyeBehindScreen = 101,
    /// A screen's steps are parallel, zero or not finite.
    Screen = 102,
    /// The gaze is not finite, zero, or its up is along it. Give NULL for a gaze
    /// that is not known.
    Gaze = 103,
    /// A dome master's axes are not of unit length at right angles,
    /// right-handed.
    DomeAxes = 104,
    /// A dome master's mirror, or its viewpoint, is out of range.
    DomeMirror = 105,
    /// Room for fewer pixels than a tile has.
    PixelsTooFew = 106,
    /// There is no such set of wavelengths.
    Wavelengths = 107,
    /// A medium of the scene is not known at all these wavelengths.
    WavelengthsOfMedium = 108,
}

/// Each with its name and what to tell a person.
#[rustfmt::skip]
const ALL: &[(Status, &CStr, &CStr)] = &[
    (Status::Ok, c"SHISEN_STATUS_OK", c"done"),
    (Status::Tile, c"SHISEN_STATUS_TILE", c"a tile's pixels are there"),
    (Status::BudgetSpent, c"SHISEN_STATUS_BUDGET_SPENT", c"the call's budget is spent: call again to go on"),
    (Status::Finished, c"SHISEN_STATUS_FINISHED", c"all tiles have been handed over"),
    (Status::NullPointer, c"SHISEN_STATUS_NULL_POINTER", c"a pointer is NULL that may not be"),
    (Status::Misaligned, c"SHISEN_STATUS_MISALIGNED", c"a pointer is not aligned: put memory for handles at a multiple of SHISEN_ALIGNMENT"),
    (Status::MemoryTooSmall, c"SHISEN_STATUS_MEMORY_TOO_SMALL", c"the memory is too small: ask the function or macro of its size"),
    (Status::TooLong, c"SHISEN_STATUS_TOO_LONG", c"a length is more than memory can be"),
    (Status::NotBuilt, c"SHISEN_STATUS_NOT_BUILT", c"the library was built without it: build it with the cargo feature of that name"),
    (Status::SceneCutOff, c"SHISEN_STATUS_SCENE_CUT_OFF", c"the scene is cut off: write it whole"),
    (Status::SceneMisaligned, c"SHISEN_STATUS_SCENE_MISALIGNED", c"the scene is not at a multiple of 32 bytes: move it"),
    (Status::NotAScene, c"SHISEN_STATUS_NOT_A_SCENE", c"this is not a baked scene: bake one with shisen bake"),
    (Status::SceneVersion, c"SHISEN_STATUS_SCENE_VERSION", c"the scene has another version of the format: bake it again"),
    (Status::SceneLayout, c"SHISEN_STATUS_SCENE_LAYOUT", c"the scene is in the layout for hosts: bake it with --layout compact"),
    (Status::SceneChecksum, c"SHISEN_STATUS_SCENE_CHECKSUM", c"the scene is damaged: write it again"),
    (Status::SceneTable, c"SHISEN_STATUS_SCENE_TABLE", c"a table is not inside the scene: bake it again"),
    (Status::SceneCount, c"SHISEN_STATUS_SCENE_COUNT", c"a table has another length than the scene gives it: bake it again"),
    (Status::SceneIndex, c"SHISEN_STATUS_SCENE_INDEX", c"a record names what is not there: bake it again"),
    (Status::SceneTree, c"SHISEN_STATUS_SCENE_TREE", c"nodes are not a tree: bake it again"),
    (Status::SceneDepth, c"SHISEN_STATUS_SCENE_DEPTH", c"a tree is too deep for the traversal stack: simplify the scene"),
    (Status::SceneLadder, c"SHISEN_STATUS_SCENE_LADDER", c"a mesh does not fit its polygon levels: bake it again"),
    (Status::SceneEffects, c"SHISEN_STATUS_SCENE_EFFECTS", c"the scene says other effects than its records: bake it again"),
    (Status::SceneValue, c"SHISEN_STATUS_SCENE_VALUE", c"a record has a value out of range: bake it again"),
    (Status::SceneOther, c"SHISEN_STATUS_SCENE_OTHER", c"the scene cannot be used: bake it again"),
    (Status::UnknownChoice, c"SHISEN_STATUS_UNKNOWN_CHOICE", c"there is no protocol or eye of this number: give one of the header's"),
    (Status::TrackerSettings, c"SHISEN_STATUS_TRACKER_SETTINGS", c"the tracker's pose or delay is out of range: give metres, a unit quaternion and at most 1 s"),
    (Status::DeviceSilent, c"SHISEN_STATUS_DEVICE_SILENT", c"nothing comes from the device: check that it is on, and its cable"),
    (Status::DeviceNoRecord, c"SHISEN_STATUS_DEVICE_NO_RECORD", c"no record comes from the device: check the line's speed and the protocol"),
    (Status::DeviceUnlike, c"SHISEN_STATUS_DEVICE_UNLIKE", c"most of what the device sends is dropped: check the protocol, its settings and the line's speed"),
    (Status::DeviceNoAnswer, c"SHISEN_STATUS_DEVICE_NO_ANSWER", c"the device does not answer: check which sensors are plugged in"),
    (Status::DeviceRefused, c"SHISEN_STATUS_DEVICE_REFUSED", c"the device refused a command: check its settings"),
    (Status::DeviceCommands, c"SHISEN_STATUS_DEVICE_COMMANDS", c"the commands do not fit the memory for them: give the buffer more"),
    (Status::FrameSettings, c"SHISEN_STATUS_FRAME_SETTINGS", c"the depth is not 0 to 16, or the samples not 1 to 4096"),
    (Status::TileSize, c"SHISEN_STATUS_TILE_SIZE", c"tiles have 1 to 256 pixels a side"),
    (Status::Pictures, c"SHISEN_STATUS_PICTURES", c"a frame has 1 to 65535 pictures"),
    (Status::PictureSize, c"SHISEN_STATUS_PICTURE_SIZE", c"a picture has 1 to 65536 pixels a side"),
    (Status::Eye, c"SHISEN_STATUS_EYE", c"the eye's place is not finite or too far out: give metres in the room"),
    (Status::EyeBehindScreen, c"SHISEN_STATUS_EYE_BEHIND_SCREEN", c"the eye is behind a screen: leave the screen out, or turn it round"),
    (Status::Screen, c"SHISEN_STATUS_SCREEN", c"a screen's steps are parallel, zero or not finite"),
    (Status::Gaze, c"SHISEN_STATUS_GAZE", c"the gaze is no direction: give NULL where it is not known"),
    (Status::DomeAxes, c"SHISEN_STATUS_DOME_AXES", c"the dome master's axes are not of unit length at right angles"),
    (Status::DomeMirror, c"SHISEN_STATUS_DOME_MIRROR", c"the dome master's mirror is out of range: give metres above 0"),
    (Status::PixelsTooFew, c"SHISEN_STATUS_PIXELS_TOO_FEW", c"there is room for fewer pixels than a tile has: give its side squared"),
    (Status::Wavelengths, c"SHISEN_STATUS_WAVELENGTHS", c"there are 1 to 64 wavelengths from 360 to 830 nm"),
    (Status::WavelengthsOfMedium, c"SHISEN_STATUS_WAVELENGTHS_OF_MEDIUM", c"a medium is not known at all wavelengths: give a narrower range"),
];

/// Returns the status with this number, its name and what it says.
fn described(status: u32) -> Option<&'static (Status, &'static CStr, &'static CStr)> {
    ALL.iter().find(|(known, ..)| *known as u32 == status)
}

/// Returns a status' name, such as "SHISEN_STATUS_OK"; "SHISEN_STATUS_?" for numbers
/// that are none. The text is the library's and stays.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_status_name(status: u32) -> *const c_char {
    described(status)
        .map_or(c"SHISEN_STATUS_?", |(_, name, _)| name)
        .as_ptr()
}

/// Returns what a status means and what to do, in one line without a full stop.
/// The library owns the text, which stays valid.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_status_message(status: u32) -> *const c_char {
    described(status)
        .map_or(c"there is no such status", |(.., message)| message)
        .as_ptr()
}

/// Carries a call out, and says how it went.
#[inline(always)]
pub(crate) fn settled(call: impl FnOnce() -> Result<Status, Status>) -> Status {
    match call() {
        Ok(status) | Err(status) => status,
    }
}

impl From<ViewError> for Status {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Size => Self::PictureSize,
            ViewError::Eye => Self::Eye,
            ViewError::Behind => Self::EyeBehindScreen,
            _ => Self::Screen,
        }
    }
}

impl From<DomeError> for Status {
    fn from(error: DomeError) -> Self {
        match error {
            DomeError::Size { .. } => Self::PictureSize,
            DomeError::Position { .. } => Self::Eye,
            DomeError::Axes { .. } => Self::DomeAxes,
            _ => Self::DomeMirror,
        }
    }
}

impl From<FrameError> for Status {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::TileSize { .. } => Self::TileSize,
            FrameError::Pictures { .. } => Self::Pictures,
            _ => Self::MemoryTooSmall,
        }
    }
}

impl From<TileError> for Status {
    fn from(_: TileError) -> Self {
        // A frame's tiles are inside its pictures.
        Self::PixelsTooFew
    }
}

impl From<LineOfSightError> for Status {
    fn from(error: LineOfSightError) -> Self {
        match error {
            LineOfSightError::Position => Self::Eye,
            _ => Self::Gaze,
        }
    }
}

impl From<Failure> for Status {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Silent | Failure::BrokenOff { .. } => Self::DeviceSilent,
            Failure::Unlike { .. } | Failure::Unusable { .. } => Self::DeviceUnlike,
            Failure::NoRecord { .. } => Self::DeviceNoRecord,
            Failure::NoAnswer { .. } => Self::DeviceNoAnswer,
            Failure::Refused { .. } => Self::DeviceRefused,
            Failure::TooLong => Self::DeviceCommands,
        }
    }
}

/// Returns the status of a scene that cannot be used, its number, and what it is about.
pub(crate) fn of_scene(error: SceneError) -> (Status, u64, &'static str) {
    match error {
        SceneError::Truncated { needed, .. } => (Status::SceneCutOff, needed, ""),
        SceneError::Misaligned { needed } => (Status::SceneMisaligned, needed as u64, ""),
        SceneError::NotAScene => (Status::NotAScene, 0, ""),
        SceneError::Version { found, .. } => (Status::SceneVersion, found.into(), ""),
        SceneError::Width { found, .. } => (Status::SceneLayout, found.into(), ""),
        SceneError::Checksum { computed, .. } => (Status::SceneChecksum, computed.into(), ""),
        SceneError::Table { name, offset, .. } => (Status::SceneTable, offset.into(), name),
        SceneError::Count { name, found, .. } => (Status::SceneCount, found.into(), name),
        SceneError::Index { what, record, .. } => (Status::SceneIndex, record.into(), what),
        SceneError::NotATree { node } => (Status::SceneTree, node.into(), ""),
        SceneError::TooDeep { needed, .. } => (Status::SceneDepth, needed.into(), ""),
        SceneError::Ladder { mesh } => (Status::SceneLadder, mesh.into(), ""),
        SceneError::Effects { asked, .. } => (Status::SceneEffects, asked.into(), ""),
        SceneError::Value { what, record } => (Status::SceneValue, record.into(), what),
        _ => (Status::SceneOther, 0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_status_has_a_name_and_a_message_of_its_own() {
        for (place, (status, name, message)) in ALL.iter().enumerate() {
            let same = ALL.iter().position(|(other, other_name, _)| {
                (*other, *other_name) == (*status, *name) || *other_name == *name
            });
            assert_eq!(same, Some(place), "{name:?}");
            assert!(name.to_bytes().starts_with(b"SHISEN_STATUS_"), "{name:?}");
            assert!(message.to_bytes().len() > 3, "{name:?}");
        }
        let name = |status: u32| {
            // SAFETY: text of the library's.
            unsafe { CStr::from_ptr(shisen_status_name(status)) }
        };
        assert_eq!(name(Status::SceneTree as u32), c"SHISEN_STATUS_SCENE_TREE");
        assert_eq!(name(u32::MAX), c"SHISEN_STATUS_?");
        assert!(!shisen_status_message(u32::MAX).is_null());
    }
}
