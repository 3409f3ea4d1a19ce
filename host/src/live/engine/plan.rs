//! The plan of a frame: its pictures, its tiles and their order.

use super::capture::LiveCapture;
use super::deal::Group;
use crate::cave::{Cave, Screen};
use crate::live::swap::Share;
use crate::render::Observer;
use glam::Vec3;
use shisen_core::frame::{Renderer, View};

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
    pub(super) fn screens(&self) -> &[(View, Renderer<'s, W>)] {
        let count = self.capture.as_ref().map(|capture| capture.part);
        let screens = self.parts.get(..count.unwrap_or(usize::MAX));
        screens.unwrap_or(&self.parts)
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
