//! Hashes of pictures, tile by tile.

use super::Setup;
use crate::picture::{Picture, tile_hash};
use crate::render::grid;
use xxhash_rust::xxh3::xxh3_64;

/// The hashes of a picture.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WallHash {
    /// The hash of the hashes of all its tiles, row by row.
    pub hash: u64,
    /// For each row of tiles, the low half of the hash of their hashes.
    pub rows: Vec<u32>,
}

/// Puts the hashes of a frame's pictures, by those of its tiles, into `walls`.
pub fn of_tiles(setup: &Setup, tiles: &[u64], walls: &mut Vec<WallHash>) {
    walls.resize(setup.pictures.len(), WallHash::default());
    let mut rest = tiles;
    for (picture, wall) in setup.pictures.iter().zip(walls) {
        let columns = picture.size[0].div_ceil(setup.tile.max(1)) as usize;
        let rows = setup.rows_of(picture);
        let own;
        (own, rest) = rest.split_at((columns * rows).min(rest.len()));
        wall.hash = xxh3_64(bytes(own).as_flattened());
        let rows = own.chunks(columns.max(1));
        wall.rows.clear();
        wall.rows
            .extend(rows.map(|row| xxh3_64(bytes(row).as_flattened()) as u32));
    }
}

fn bytes(hashes: &[u64]) -> Vec<[u8; 8]> {
    hashes.iter().map(|hash| hash.to_le_bytes()).collect()
}

/// Puts the hashes of pictures into `walls`.
pub fn of_pictures(setup: &Setup, pictures: &[Picture], walls: &mut Vec<WallHash>) {
    let mut tiles = Vec::new();
    for (picture, recorded) in pictures.iter().zip(&setup.pictures) {
        let width = recorded.size[0] as usize;
        let pixels = picture.core_pixels();
        tiles.extend(grid(recorded.size, setup.tile).map(|tile| {
            let rows = pixels.chunks_exact(width.max(1)).skip(tile.y as usize);
            let columns = tile.x as usize..(tile.x + tile.width) as usize;
            tile_hash(
                rows.take(tile.height as usize)
                    .map(|row| &row[columns.clone()]),
            )
        }));
    }
    of_tiles(setup, &tiles, walls);
}
