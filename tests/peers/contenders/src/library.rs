//! Wraps a Rust contender in the interface's C functions: pointers become references.

use shisen_peers_interface::{Contender, Hit, Mesh, Rays, Task};
use std::ffi::{CStr, c_void};

/// A ray tracer that competes.
pub(crate) trait Trace: Sized {
    /// Builds the tree; `None` if it cannot.
    fn open(corners: &'static [[[f32; 3]; 3]], baked: &'static [u8]) -> Option<Self>;
    /// Traces rays; `side` is the number of pixels a row of a picture, or 0.
    fn trace(&self, rays: &[[f32; 6]], side: usize, hits: &mut [Hit]);
}

/// Returns the contender that a type implements.
pub(crate) const fn contender<T: Trace>(
    name: &'static CStr,
    mode: &'static CStr,
    simd: &'static CStr,
    task: Task,
) -> Contender {
    Contender {
        name: name.as_ptr(),
        mode: mode.as_ptr(),
        version: c"".as_ptr(),
        simd: simd.as_ptr(),
        task,
        open: open::<T>,
        trace: trace::<T>,
        close: close::<T>,
    }
}

unsafe extern "C" fn open<T: Trace>(mesh: *const Mesh) -> *mut c_void {
    // SAFETY: the interface promises that both live until `close`.
    let opened = unsafe {
        let mesh = &*mesh;
        T::open(
            std::slice::from_raw_parts(mesh.corners.cast(), mesh.triangles),
            std::slice::from_raw_parts(mesh.baked, mesh.baked_bytes),
        )
    };
    opened.map_or(std::ptr::null_mut(), |opened| {
        Box::into_raw(Box::new(opened)).cast()
    })
}

unsafe extern "C" fn trace<T: Trace>(opened: *const c_void, rays: *const Rays, hits: *mut Hit) {
    // SAFETY: `opened` comes from `open`, and `hits` has a hit for each ray.
    unsafe {
        let rays = &*rays;
        (*opened.cast::<T>()).trace(
            std::slice::from_raw_parts(rays.rays, rays.count),
            rays.side,
            std::slice::from_raw_parts_mut(hits, rays.count),
        );
    }
}

unsafe extern "C" fn close<T: Trace>(opened: *mut c_void) {
    // SAFETY: `opened` comes from `open`, and is not used any more.
    drop(unsafe { Box::from_raw(opened.cast::<T>()) });
}
