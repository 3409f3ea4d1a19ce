//! The plan of a frame: its pictures, its tiles and their order.

use super::capture::LiveCapture;
use super::deal::Group;
use super::fovea::{SAME_PLACE, reaching_fovea, towards};
use super::threads::lock;
use super::{Engine, LAST_IN_ORDER};
use crate::cave::{Cave, Screen};
use crate::live::quality::Quality;
use crate::live::swap::Share;
use crate::render::{self, Observer, RenderError};
use glam::Vec3;
use shisen_core::frame::{Pixel, Renderer, Tile, TileJob, View};
use shisen_core::{Runs, Simd};
use std::sync::atomic::Ordering;

/// Expected steps of a pixel of which nothing is known.
const UNKNOWN_PIXEL: u64 = 16;

/// A frame.
pub(super) struct Plan<'s, const W: usize> {
    /// Pictures by screen, then eye; then the hemispheres of a capture.
    pub(super) parts: Vec<(View, Renderer<'s, W>)>,
    /// The line of sight of each picture's eye; `None` where it is not known.
    pub(super) sights: Vec<Option<Vec3>>,
    /// Tiles with the cosine of their angle to the line of sight, from there outwards; at the
    /// end the tiles of a capture that are traced again.
    pub(super) order: Vec<(f32, u32)>,
    /// How many tiles come first, as far as the [`FOVEA`](crate::live::FOVEA) reaches.
    pub(super) first: usize,
    /// Whether quality and line of sight are those of the frame before.
    pub(super) settled: bool,
    /// The work of a round; each thread takes the next group.
    pub(super) groups: Vec<Group>,
    pub(super) capture: Option<LiveCapture>,
    /// Whether the round fills tiles rather than tracing them.
    pub(super) fills: bool,
}

impl<'s, const W: usize> Plan<'s, W> {
    /// The pictures of screens.
    pub(super) fn screens(&self) -> &[(View, Renderer<'s, W>)] {
        let count = self.capture.as_ref().map(|capture| capture.part);
        let screens = self.parts.get(..count.unwrap_or(usize::MAX));
        screens.unwrap_or(&self.parts)
    }
}

/// A tile and its pixels.
pub(super) struct LiveTile {
    pub(super) part: usize,
    pub(super) job: TileJob,
    pub(super) pixels: Vec<Pixel>,
    /// Steps taken in this frame.
    pub(super) spent: u64,
    /// Steps expected in this frame.
    pub(super) expected: u64,
}

impl LiveTile {
    pub(super) fn new(part: usize, tile: Tile) -> Self {
        let area = tile.width as usize * tile.height as usize;
        Self {
            part,
            job: TileJob::new(tile),
            pixels: vec![Pixel::default(); area],
            spent: 0,
            expected: area as u64 * UNKNOWN_PIXEL,
        }
    }

    /// Steps still expected; as many as were taken where that was more than expected.
    pub(super) const fn expected_rest(&self) -> u64 {
        if self.spent < self.expected {
            self.expected - self.spent
        } else {
            self.spent
        }
    }
}

/// The screens and eyes of a share's pictures, with the number of the screen.
pub(super) fn pairs<'c>(
    cave: &'c Cave,
    eyes: &'c [Observer],
    share: Share,
) -> impl Iterator<Item = (usize, Screen<'c>, &'c Observer)> {
    let count = cave.screens().count() * eyes.len();
    let screens = cave.screens().enumerate();
    let pairs = screens.flat_map(move |(n, screen)| eyes.iter().map(move |eye| (n, screen, eye)));
    let own = pairs.enumerate();
    own.filter(move |(pair, _)| share.has(*pair, count))
        .map(|(_, pair)| pair)
}

impl<const W: usize> Engine<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Plans the next frame.
    pub(super) fn plan(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<(), RenderError> {
        let (shared, scene, spectrum) = (self.shared, &self.scene, self.spectrum);
        let mut options = self.options;
        options.settings.depth = options.settings.depth.min(quality.depth);
        let plan = &mut *shared.write();
        let (parts, sights, order) = (&mut plan.parts, &mut plan.sights, &mut plan.order);
        let (capture, settled) = (&mut plan.capture, &mut plan.settled);
        let screens = capture.as_ref().map(|capture| capture.part);
        let screens = screens.unwrap_or(parts.len());
        if pairs(self.cave, eyes, self.share).count() != screens {
            return Err(RenderError::Previous);
        }
        *settled = *quality == self.quality;
        self.quality = *quality;
        let own = parts.iter_mut().zip(sights.iter_mut());
        for ((_, screen, observer), (part, sight)) in pairs(self.cave, eyes, self.share).zip(own) {
            let was = std::mem::replace(sight, observer.forward());
            *settled &= match (was, *sight) {
                (Some(was), Some(sight)) => was.angle_between(sight) <= SAME_PLACE,
                (was, sight) => was == sight,
            };
            let renderer = render::in_full(scene, &options, spectrum)?;
            let renderer = renderer.with_faces_of_level(quality.faces);
            let renderer = quality.lower(*observer).follow(&renderer);
            *part = (render::view(screen, observer)?, renderer);
        }
        order.clear();
        shared.spent.store(0, Ordering::SeqCst);
        let own = capture.as_ref().map(|capture| capture.tile);
        for (number, tile) in shared.tiles.iter().enumerate() {
            let mut tile = lock(tile);
            tile.job = TileJob::new(tile.job.tile());
            tile.spent = 0;
            if own.is_none_or(|own| number < own) {
                let view = &parts[tile.part].0;
                let cosine = towards(sights[tile.part], view, tile.job.tile());
                order.push((cosine, number as u32));
            }
        }
        if let Some(capture) = capture {
            let views = capture.views(eyes, scene, &options, spectrum)?;
            parts.truncate(screens);
            parts.extend(views);
            let part = steps.map_or(1.0, |_| quality.capture);
            order.extend(capture.due(part).map(|tile| (LAST_IN_ORDER, tile as u32)));
        }
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        plan.first = reaching_fovea(order.iter().map_while(|&(cosine, number)| {
            let tile = lock(&shared.tiles[number as usize]);
            let sight = sights.get(tile.part).copied().flatten();
            let sight = sight.filter(|_| cosine > LAST_IN_ORDER)?;
            Some((sight, &parts[tile.part].0, tile.job.tile()))
        }));
        Ok(())
    }
}
