//! Flat screens.

use crate::memory::{shared, write};
use crate::status::{Status, settled};
use glam::Vec3;
use shisen_core::frame::FlatScreen;

/// A flat screen: the places of its pixels, for any eye. Metres, in the room.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Screen {
    /// The centre of its first pixel: upper left, seen from in front of it.
    pub first_pixel: [f32; 3],
    /// Step from a pixel to its right-hand neighbour.
    pub column_step: [f32; 3],
    /// Step from a pixel to the one below it.
    pub row_step: [f32; 3],
    /// Pixels in a row, 1 to 65,536.
    pub columns: u32,
    /// Pixels in a column, 1 to 65,536.
    pub rows: u32,
}

impl Screen {
    pub(crate) fn flat(&self) -> FlatScreen {
        FlatScreen {
            first_pixel: Vec3::from_array(self.first_pixel),
            column_step: Vec3::from_array(self.column_step),
            row_step: Vec3::from_array(self.row_step),
            size: [self.columns, self.rows],
        }
    }
}

/// Computes a screen from three of its corners, seen from in front of it:
/// metres, in the room.
/// cbindgen:ptrs-as-arrays=[[lower_left;3], [lower_right;3], [upper_left;3]]
///
/// # Safety
/// Each pointer is NULL, misaligned, or points to three numbers; `screen` to
/// memory for a screen.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_screen_from_corners(
    lower_left: *const f32,
    lower_right: *const f32,
    upper_left: *const f32,
    columns: u32,
    rows: u32,
    screen: *mut Screen,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let corner = |corner: *const f32| unsafe { shared(corner.cast::<[f32; 3]>()) };
        let [lower_left, lower_right, upper_left] = [
            Vec3::from_array(*corner(lower_left)?),
            Vec3::from_array(*corner(lower_right)?),
            Vec3::from_array(*corner(upper_left)?),
        ];
        let size = [columns, rows];
        if size.contains(&0) {
            return Err(Status::PictureSize);
        }
        let flat = FlatScreen::from_corners(lower_left, lower_right, upper_left, size);
        let made = Screen {
            first_pixel: flat.first_pixel.to_array(),
            column_step: flat.column_step.to_array(),
            row_step: flat.row_step.to_array(),
            columns,
            rows,
        };
        // SAFETY: as promised above.
        unsafe { write(screen, made) }
    })
}
