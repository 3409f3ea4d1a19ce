//! The interface of a library of contenders: it exports [`SYMBOL`], a function of type [`List`].
//! `contender.h` beside this crate says the same for C++.

use std::ffi::{c_char, c_void};

/// The name of the exported function.
pub const SYMBOL: &[u8] = b"shisen_contenders\0";

/// Returns the contenders, and writes their count.
pub type List = unsafe extern "C" fn(count: *mut usize) -> *const Contender;

/// The triangle of a ray that hits none.
pub const NONE: u32 = u32::MAX;

/// The task of a contender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Task {
    /// Finds the nearest hit of each ray.
    Nearest = 0,
    /// Says whether anything is hit: triangle 0 at distance 0, or none.
    Any = 1,
    /// As `Nearest`, for the pixels of a picture alone, row by row; all rays start in one point.
    Picture = 2,
}

/// One way of tracing.
#[derive(Debug)]
#[repr(C)]
pub struct Contender {
    /// The contender's name, as text that ends in 0.
    pub name: *const c_char,
    /// The mode.
    pub mode: *const c_char,
    /// The version; empty if the lock file has it.
    pub version: *const c_char,
    /// Instructions and lanes.
    pub simd: *const c_char,
    /// The task.
    pub task: Task,
    /// Builds the tree; null if it cannot be built.
    pub open: unsafe extern "C" fn(*const Mesh) -> *mut c_void,
    /// Traces rays, and writes a hit for each.
    pub trace: unsafe extern "C" fn(*const c_void, *const Rays, *mut Hit),
    /// Frees the tree of `open`.
    pub close: unsafe extern "C" fn(*mut c_void),
}

/// Triangles; they stay where they are while they are traced.
#[derive(Debug)]
#[repr(C)]
pub struct Mesh {
    /// Nine numbers a triangle.
    pub corners: *const f32,
    /// The number of triangles.
    pub triangles: usize,
    /// The same mesh as a baked scene, for ours alone.
    pub baked: *const u8,
    /// The number of bytes of `baked`.
    pub baked_bytes: usize,
}

/// Rays to trace.
#[derive(Debug)]
#[repr(C)]
pub struct Rays {
    /// Origin and direction, six numbers a ray.
    pub rays: *const [f32; 6],
    /// The number of rays.
    pub count: usize,
    /// Pixels a row of a picture; 0 for other rays. Rows and pixels a row are multiples of 8.
    pub side: usize,
}

/// The hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// The triangle in the order given; [`NONE`] for a miss.
    pub triangle: u32,
    /// The distance in units of the direction; infinity for a miss.
    pub t: f32,
}

impl Hit {
    /// A miss.
    pub const MISS: Self = Self {
        triangle: NONE,
        t: f32::INFINITY,
    };
}
