//! Renders frames by their descriptions, as `shisen replay --describe` writes them, and prints the
//! hash of each picture: `FRAME PICTURE HASH` a line, in hexadecimal.
//!
//! The emulator's loader puts into memory, in words of four bytes, the lowest first: the bytes of the
//! scene, the number of frames, the bytes of each frame; from the next multiple of 64 bytes on the
//! scene, then, from a multiple of four, the frames. Tiles have 32 pixels a side, as a record's.
#![no_std]
#![no_main]

extern crate alloc;

#[expect(dead_code, reason = "the page alone shows where detail is")]
#[path = "../../../../host/web/src/frame.rs"]
mod frame;

use alloc::vec::Vec;
use core::mem::MaybeUninit;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use embedded_alloc::LlffHeap;
use frame::Frame;
use shisen_core::frame::{Budget, Pixel, Tile, Workspace};
use shisen_core::scene::CompactScene;
use shisen_firmware::measure;
use xxhash_rust::xxh3::xxh3_64;
use zerocopy::IntoBytes as _;

/// Address of what the loader has put there, and the bytes of memory from there on.
const LOADED: (usize, usize) = (0x6000_0000, 16 << 20);

const HEAP: usize = 3 << 20;

/// Pixels a side of the tiles that are hashed.
const TILE: u32 = 32;

#[global_allocator]
static ALLOCATOR: LlffHeap = LlffHeap::empty();

#[entry]
fn main() -> ! {
    static mut MEMORY: [MaybeUninit<u8>; HEAP] = [MaybeUninit::uninit(); HEAP];
    let memory: &'static mut [MaybeUninit<u8>] = MEMORY;
    // SAFETY: nothing else uses this memory, and this is done once.
    unsafe { ALLOCATOR.init(memory.as_mut_ptr() as usize, HEAP) };
    // SAFETY: there is this much memory from here on, and nothing writes to it.
    let loaded = unsafe { core::slice::from_raw_parts(LOADED.0 as *const u8, LOADED.1) };
    let replayed = replay(loaded);
    if replayed.is_none() {
        hprintln!("the scene or a frame cannot be read");
    }
    measure::end(replayed.is_some())
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let bytes = bytes.get(4 * at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes) as usize)
}

fn replay(loaded: &'static [u8]) -> Option<()> {
    let (scene_bytes, count) = (word(loaded, 0)?, word(loaded, 1)?);
    let start = (4 * (2 + count)).next_multiple_of(64);
    let scene = loaded.get(start..)?.get(..scene_bytes)?;
    let scene = CompactScene::from_bytes(scene).ok()?;
    let mut at = start + scene_bytes.next_multiple_of(4);
    let (mut old, mut workspace) = (None, Workspace::new());
    for number in 0..count {
        let length = word(loaded, 2 + number)?;
        let frame = Frame::read(scene, loaded.get(at..)?.get(..length)?, old)?;
        at += length;
        for picture in 0.. {
            let Some((view, _)) = frame.picture(picture) else {
                break;
            };
            let size = [view.columns(), view.rows()];
            let hash = picture_hash(&frame, picture, size, &mut workspace)?;
            hprintln!("{} {} {:016x}", number, picture, hash);
        }
        old = Some(frame);
    }
    Some(())
}

/// Returns the hash of a picture as a record has it.
fn picture_hash(
    frame: &Frame,
    picture: u32,
    [columns, rows]: [u32; 2],
    workspace: &mut Workspace,
) -> Option<u64> {
    let (mut hashes, mut pixels) = (Vec::new(), Vec::new());
    for y in (0..rows).step_by(TILE as usize) {
        for x in (0..columns).step_by(TILE as usize) {
            let (width, height) = (TILE.min(columns - x), TILE.min(rows - y));
            let tile = Tile {
                x,
                y,
                width,
                height,
            };
            pixels.clear();
            pixels.resize((width * height) as usize, Pixel::default());
            let mut budget = Budget::UNLIMITED;
            frame.render((picture, tile), &mut pixels, &mut budget, workspace)?;
            hashes.push(xxh3_64(pixels.as_bytes()));
        }
    }
    Some(xxh3_64(hashes.as_bytes()))
}
