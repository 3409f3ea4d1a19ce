//! The core in a page: a scene, the description of a frame, and its tiles.
//!
//! JavaScript writes bytes into the room that [`input`] gives it, calls [`open`] with a baked scene
//! of the compact layout, [`begin`] with a [frame](frame), and [`render`] for each tile. One instance
//! has one scene, and a worker has one instance.

extern crate alloc;

mod frame;
mod pixels;

use frame::Frame;
use shisen_core::frame::{Budget, Pixel, Tile, Workspace};
use shisen_core::scene::CompactScene;
use std::cell::RefCell;
use zerocopy::{FromZeros, Immutable, IntoBytes};

/// Why a call has failed: what it returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    Scene = 1,
    Frame = 2,
    Tile = 3,
}

/// Bytes as a scene's tables are aligned.
#[derive(Clone, IntoBytes, FromZeros, Immutable)]
#[repr(C, align(64))]
struct Block([u8; 64]);

/// What an instance holds.
#[derive(Default)]
struct State {
    input: Vec<Block>,
    scene: Option<CompactScene<'static>>,
    frame: Option<Frame>,
    workspace: Workspace,
    pixels: Vec<Pixel>,
    /// Red, green, blue and opacity as a canvas has them.
    shown: Vec<u8>,
    steps: u64,
    rays: u64,
    is_whole: bool,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

fn with<T>(act: impl FnOnce(&mut State) -> T) -> T {
    STATE.with_borrow_mut(act)
}

fn code(done: Result<(), Fault>) -> u32 {
    done.err().map_or(0, |fault| fault as u32)
}

/// Returns where to write so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    with(|state| {
        state.input.clear();
        state.input.resize(bytes.div_ceil(64), Block([0; 64]));
        state.input.as_mut_ptr().cast()
    })
}

/// Opens the scene that was written: 0, or 1 for bytes that are none.
#[unsafe(no_mangle)]
pub extern "C" fn open(bytes: usize) -> u32 {
    with(|state| {
        // It stays as long as the instance.
        let blocks: &'static [Block] = std::mem::take(&mut state.input).leak();
        let bytes = blocks.as_bytes().get(..bytes);
        let scene = bytes.and_then(|bytes| CompactScene::from_bytes(bytes).ok());
        state.frame = None;
        state.scene = scene;
        code(scene.map(|_| ()).ok_or(Fault::Scene))
    })
}

/// Takes the frame that was written: 0, or 2 for one that is none.
#[unsafe(no_mangle)]
pub extern "C" fn begin(bytes: usize) -> u32 {
    with(|state| {
        let bytes = state.input.as_bytes().get(..bytes);
        let frame = state.scene.zip(bytes);
        let old = state.frame.take();
        state.frame = frame.and_then(|(scene, bytes)| Frame::read(scene, bytes, old));
        code(state.frame.as_ref().map(|_| ()).ok_or(Fault::Frame))
    })
}

/// Renders a tile of a picture within some steps, 0 for no limit; gives up what they do not reach.
/// Returns 0, 2 where there is no frame, or 3 for a tile that is not in the picture.
#[unsafe(no_mangle)]
pub extern "C" fn render(picture: u32, x: u32, y: u32, width: u32, height: u32, steps: u32) -> u32 {
    with(|state| {
        code(state.render(
            picture,
            Tile {
                x,
                y,
                width,
                height,
            },
            steps,
        ))
    })
}

impl State {
    fn render(&mut self, picture: u32, tile: Tile, steps: u32) -> Result<(), Fault> {
        let frame = self.frame.as_ref().ok_or(Fault::Frame)?;
        let area = (tile.width as usize).saturating_mul(tile.height as usize);
        if area > 1 << 16 {
            return Err(Fault::Tile);
        }
        self.pixels.clear();
        self.pixels.resize(area, Pixel::default());
        let mut budget = match steps {
            0 => Budget::UNLIMITED,
            steps => Budget::steps(steps.into()).with_overrun(0),
        };
        let budgeted = budget.left();
        let before = self.workspace.statistics;
        let (pixels, workspace) = (&mut self.pixels, &mut self.workspace);
        let rendered = frame.render((picture, tile), pixels, &mut budget, workspace);
        self.is_whole = rendered.ok_or(Fault::Tile)?;
        let after = &self.workspace.statistics;
        self.steps = budgeted - budget.left();
        self.rays = after.rays().wrapping_sub(before.rays());
        pixels::show(&self.pixels, &mut self.shown);
        Ok(())
    }
}

/// Returns where the newest tile is, four bytes a pixel.
#[unsafe(no_mangle)]
pub extern "C" fn shown() -> *const u8 {
    with(|state| state.shown.as_ptr())
}

/// Returns the hash of the newest tile, as a record has it.
#[unsafe(no_mangle)]
pub extern "C" fn hash() -> u64 {
    with(|state| pixels::hash(&state.pixels))
}

/// Returns the steps of the newest tile.
#[unsafe(no_mangle)]
pub extern "C" fn steps() -> u64 {
    with(|state| state.steps)
}

/// Returns the rays of the newest tile.
#[unsafe(no_mangle)]
pub extern "C" fn rays() -> u64 {
    with(|state| state.rays)
}

/// Returns whether the newest tile was finished.
#[unsafe(no_mangle)]
pub extern "C" fn is_whole() -> bool {
    with(|state| state.is_whole)
}

/// Returns the detail of a pixel: with the paper's levels 0 to 1, with foveation the pixels a side
/// that have one colour.
#[unsafe(no_mangle)]
pub extern "C" fn detail(picture: u32, x: u32, y: u32) -> f32 {
    with(|state| {
        let frame = state.frame.as_ref();
        frame.map_or(1.0, |frame| frame.detail(picture, x, y))
    })
}

/// Returns the XXH3-64 of the bytes that were written.
#[unsafe(no_mangle)]
pub extern "C" fn hash_of(bytes: usize) -> u64 {
    with(|state| {
        let bytes = state.input.as_bytes().get(..bytes);
        xxhash_rust::xxh3::xxh3_64(bytes.unwrap_or_default())
    })
}
