//! Dome masters through a mirrored spheroid.

use crate::memory::{shared, write};
use crate::status::{Status, settled};
use glam::{Mat3, Vec3};
use shisen_core::frame::{DomePose, DomeProjection, MirrorCamera, View};

/// A dome master: a square picture of half of all directions, reflected at the
/// spheroid of least error, each pixel its own exact direction. Pixels outside
/// its rim are transparent and cost nothing.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Dome {
    /// The screen's centre in the room, metres.
    pub position: [f32; 3],
    /// The picture's right, in the room: a unit vector.
    pub right: [f32; 3],
    /// The picture's top, in the room: a unit vector.
    pub top: [f32; 3],
    /// Against the zenith, in the room: a unit vector. The three are at right
    /// angles and right-handed.
    pub behind: [f32; 3],
    /// The mirror's equatorial radius: metres, 1e-9 to 1e6.
    pub radius: f32,
    /// Pixels a side, 1 to 65,536.
    pub size: u32,
}

impl Dome {
    pub(crate) fn view(&self) -> Result<View, Status> {
        let projection = DomeProjection::Mirror(MirrorCamera::best(self.radius));
        let [right, top, behind] = [self.right, self.top, self.behind].map(Vec3::from_array);
        let pose = DomePose {
            position: Vec3::from_array(self.position),
            room_from_capture: Mat3::from_cols(right, top, behind),
        };
        Ok(View::dome(projection, pose, self.size)?)
    }
}

/// Returns a dome over a room, whose front is at the bottom of the picture of `size`²
/// pixels, with a mirror of 1 mm. `position`: metres, in the room.
/// cbindgen:ptrs-as-arrays=[[position;3]]
///
/// # Safety
/// `dome` is NULL, misaligned, or points to memory for one; `position` is NULL,
/// misaligned, or points to three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_dome_init(
    dome: *mut Dome,
    position: *const f32,
    size: u32,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let position = *unsafe { shared(position.cast::<[f32; 3]>()) }?;
        let pose = DomePose::over_room(Vec3::from_array(position)).room_from_capture;
        let made = Dome {
            position,
            right: pose.x_axis.to_array(),
            top: pose.y_axis.to_array(),
            behind: pose.z_axis.to_array(),
            radius: 0.001,
            size,
        };
        // SAFETY: as promised above.
        unsafe { write(dome, made) }
    })
}
