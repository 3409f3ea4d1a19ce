//! What a library of contenders exports: [`SYMBOL`], a function of the type [`List`].
//! `contender.h` beside this crate says the same for C++.

use std::ffi::{c_char, c_void};

/// The name of the exported function.
pub const SYMBOL: &[u8] = b"shisen_contenders\0";

/// Says how many contenders there are, and where.
pub type List = unsafe extern "C" fn(count: *mut usize) -> *const Contender;

/// The triangle of a ray that hits none.
pub const NONE: u32 = u32::MAX;

/// What a contender does with rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Task {
    /// Finds the nearest hit of each ray.
    Nearest = 0,
    /// Says whether anything is hit: triangle 0 at distance 0, or none.
    Any = 1,
    /// As `Nearest`, for pictures alone: rays are the pixels of one, row by row, and
    /// start in one point.
    Picture = 2,
}

/// One way of tracing.
#[derive(Debug)]
#[repr(C)]
pub struct Contender {
    /// Who, as text that ends in 0.
    pub name: *const c_char,
    /// How.
    pub mode: *const c_char,
    /// Which version; empty where the lock file says.
    pub version: *const c_char,
    /// Instructions and lanes.
    pub simd: *const c_char,
    /// What it does.
    pub task: Task,
    /// Builds what is traced; null where it cannot be built.
    pub open: unsafe extern "C" fn(*const Mesh) -> *mut c_void,
    /// Traces rays, and writes as many hits. The sizes are those of both.
    pub trace: unsafe extern "C" fn(*const c_void, *const Rays, *mut Hit),
    /// Takes back what `open` gave.
    pub close: unsafe extern "C" fn(*mut c_void),
}

/// Triangles; they stay where they are while they are traced.
#[derive(Debug)]
#[repr(C)]
pub struct Mesh {
    /// Nine numbers a triangle.
    pub corners: *const f32,
    /// How many triangles.
    pub triangles: usize,
    /// The same as a baked scene of one mesh, which only ours reads.
    pub baked: *const u8,
    /// Its bytes.
    pub baked_bytes: usize,
}

/// Rays to trace.
#[derive(Debug)]
#[repr(C)]
pub struct Rays {
    /// Origin and direction, six numbers a ray.
    pub rays: *const [f32; 6],
    /// How many.
    pub count: usize,
    /// Pixels a row, a multiple of 8 that divides `count` evenly into rows, which are
    /// a multiple of 8, too; 0 where the rays are no picture.
    pub side: usize,
}

/// What a ray hit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Counted as they were given; [`NONE`].
    pub triangle: u32,
    /// In units of the direction; infinite where there is none.
    pub t: f32,
}

impl Hit {
    /// Nothing.
    pub const MISS: Self = Self {
        triangle: NONE,
        t: f32::INFINITY,
    };
}
