//! A capture of the surroundings for pixels that the gaze skips, renewed tile by tile.

use super::deal::LiveTile;
use crate::live::flight::RoomPlace;
use crate::render::{self, CaptureOptions, Observer, Options, RenderError};
use glam::{DVec3, Mat3, Vec3};
use shisen_core::frame::{DomePose, Pixel, Renderer, Spectrum, Surroundings, View};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};

type Part<'s, const W: usize> = (View, Renderer<'s, W>);

/// A capture of all directions from between the eyes, along the scene's axes.
pub(super) struct LiveCapture {
    options: CaptureOptions,
    /// The number of the first hemisphere among the parts.
    pub(super) part: usize,
    /// The number of the first tile among the tiles.
    pub(super) tile: usize,
    count: usize,
    /// The first tile to renew next, counted from `tile`.
    next: usize,
    /// For each tile, whether it was never traced.
    missing: Vec<bool>,
    pose: DomePose,
    hemispheres: [Vec<Pixel>; 2],
}

const SIDE: u32 = 16;

impl LiveCapture {
    /// `part` and `tile` are the numbers of parts and tiles of screens, which come first.
    pub(super) fn new(options: CaptureOptions, part: usize, tile: usize) -> Self {
        let area = options.size as usize * options.size as usize;
        let count = 2 * (options.size.div_ceil(SIDE) as usize).pow(2);
        Self {
            options,
            part,
            tile,
            count,
            next: 0,
            missing: vec![true; count],
            pose: DomePose {
                position: Vec3::ZERO,
                room_from_capture: Mat3::IDENTITY,
            },
            hemispheres: [vec![Pixel::default(); area], vec![Pixel::default(); area]],
        }
    }

    pub(super) fn is_whole(&self) -> bool {
        !self.missing.contains(&true)
    }

    pub(super) fn tiles(&self) -> impl Iterator<Item = LiveTile> {
        let (size, part) = ([self.options.size; 2], self.part);
        (part..part + 2).flat_map(move |part| {
            render::grid(size, SIDE).map(move |tile| LiveTile::new(part, tile))
        })
    }

    pub(super) fn views<'s, const W: usize>(
        &self,
        eyes: &[Observer],
        place: &RoomPlace,
        scene: &Scene<'s, W>,
        options: &Options,
        spectrum: Spectrum<'s>,
    ) -> Result<[Part<'s, W>; 2], RenderError>
    where
        Simd: Runs<W>,
    {
        let middle = eyes.iter().map(|eye| eye.place).sum::<DVec3>() / eyes.len() as f64;
        let pose = DomePose {
            position: place.point(middle).as_vec3(),
            ..self.pose
        };
        render::hemispheres(scene, pose, self.options, options, spectrum)
    }

    /// Returns the tiles to renew next, a `part` of all in turns; all while one is missing.
    pub(super) fn due(&mut self, part: f32) -> impl Iterator<Item = usize> + use<> {
        let (tile, count, next) = (self.tile, self.count, self.next);
        let due = if self.is_whole() {
            ((part * count as f32).ceil() as usize).clamp(1, count)
        } else {
            count
        };
        self.next = (next + due) % count;
        (next..next + due).map(move |number| tile + number % count)
    }

    pub(super) fn take(&mut self, number: usize, tile: &LiveTile) {
        let place = tile.job.tile();
        let hemisphere = &mut self.hemispheres[tile.part - self.part];
        let rows = tile.pixels.chunks_exact(place.width as usize);
        for (y, row) in (place.y..).zip(rows) {
            let start = (y * self.options.size + place.x) as usize;
            hemisphere[start..start + row.len()].copy_from_slice(row);
        }
        if tile.job.is_finished() {
            self.missing[number - self.tile] = false;
        }
    }

    pub(super) fn surroundings(&self) -> Option<Surroundings<'_>> {
        let hemispheres = self.hemispheres.each_ref().map(Vec::as_slice);
        Surroundings::new(self.pose, self.options.size, hemispheres).ok()
    }
}
