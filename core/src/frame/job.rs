//! A frame of several views within one budget: tiles in the order in which
//! the gaze wants them.

use super::{Budget, Outcome, Pixel, Renderer, Tile, TileError, TileJob, View, Workspace};
use crate::Runs;
use crate::gaze::LineOfSight;
use crate::simd::Simd;
use core::cmp::Ordering;
use glam::Vec3;

/// One picture of a frame: its rays and its renderer.
#[derive(Debug, Clone, Copy)]
pub struct Part<'r, 'a, const W: usize = 8> {
    /// The picture's rays.
    pub view: View,
    /// The picture's renderer, with the gaze of the eye that sees it.
    pub renderer: &'r Renderer<'a, W>,
}

/// The pictures of a frame: a slice of [`Part`]s, or a type that computes views on
/// demand, to save memory.
pub trait Pictures<'a, const W: usize> {
    /// Returns the number of pictures.
    fn count(&self) -> usize;

    /// Returns a picture's rays: always the same while a frame is rendered.
    fn view(&self, number: usize) -> Option<View>;

    /// Returns a picture's renderer.
    fn renderer(&self, number: usize) -> Option<&Renderer<'a, W>>;
}

impl<'a, const W: usize> Pictures<'a, W> for [Part<'_, 'a, W>] {
    fn count(&self) -> usize {
        self.len()
    }

    fn view(&self, number: usize) -> Option<View> {
        self.get(number).map(|part| part.view)
    }

    fn renderer(&self, number: usize) -> Option<&Renderer<'a, W>> {
        self.get(number).map(|part| part.renderer)
    }
}

/// Room for a tile of a frame in its order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// Cosine of the angle between the line of sight and the tile's centre.
    cosine: f32,
    part: u16,
    /// Row, counted in tiles.
    row: u16,
    /// Column, counted in tiles.
    column: u16,
}

impl Place {
    /// The place of no tile yet.
    pub const NONE: Self = Self {
        cosine: 0.0,
        part: 0,
        row: 0,
        column: 0,
    };

    /// Nearest to the line of sight first, then by picture, row and column.
    fn order(&self, other: &Self) -> Ordering {
        let of = |place: &Self| (place.part, place.row, place.column);
        other
            .cosine
            .total_cmp(&self.cosine)
            .then_with(|| of(self).cmp(&of(other)))
    }
}

/// Why a frame cannot be begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FrameError {
    /// Tiles of no pixels, or of more than [`FrameJob::LARGEST_TILE`] a side.
    #[error("tiles have 1 to {} pixels a side, not {side}", FrameJob::LARGEST_TILE)]
    TileSize { side: u32 },
    /// No pictures, or more than 65,535.
    #[error("a frame has 1 to 65535 pictures, not {count}")]
    Pictures { count: usize },
    /// There is room for fewer tiles than the frame has.
    #[error("the frame has {needed} tiles, but there is room for {given}")]
    Places { needed: usize, given: usize },
}

/// The result of a call of [`FrameJob::render`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Progress {
    /// A tile is finished.
    Tile {
        /// Index of its picture.
        part: usize,
        /// The tile's place in the picture.
        tile: Tile,
        /// Whether the budget lasted; if not, some pixels show the background.
        whole: bool,
    },
    /// The call's budget ran out; call again to go on where it stopped.
    BudgetSpent,
    /// All tiles have been handed over.
    Finished,
}

/// A frame on its way to being finished, tile by tile, from the line of sight outwards: a
/// frame whose budget runs out lacks its rim.
///
/// The scene, the views, the [`Settings`](super::Settings), the gaze, the size of tiles and the
/// frame's budget decide its pixels, not how it is cut into calls. For a frame whose budget
/// runs out this holds in [`Mode::Single`](super::Mode) without foveation of several samples a
/// pixel: an interrupted block or square takes more steps.
#[derive(Debug)]
pub struct FrameJob<'p> {
    places: &'p [Place],
    next: usize,
    job: Option<TileJob>,
    side: u32,
    budget: Budget,
    tiles: Tiles,
}

/// Tiles handed over so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tiles {
    /// Tiles all of whose pixels were traced.
    pub whole: u32,
    /// Tiles that the frame's budget did not finish.
    pub given_up: u32,
}

impl<'p> FrameJob<'p> {
    /// Most pixels a side of a tile.
    pub const LARGEST_TILE: u32 = 256;

    /// Returns how many tiles of `side`² pixels the pictures of these sizes (columns and
    /// rows) have together: as many [`Place`]s a frame needs.
    pub fn tiles_of(sizes: impl Iterator<Item = [u32; 2]>, side: u32) -> usize {
        let side = side.max(1);
        sizes
            .map(|size| size.map(|pixels| pixels.div_ceil(side) as usize))
            // Pixels of the largest view are more than a usize of 32 bits counts.
            .map(|[columns, rows]| columns.saturating_mul(rows))
            .fold(0, usize::saturating_add)
    }

    /// Returns a frame of some pictures, in tiles of `side`² pixels, that begins no sample when
    /// `budget` is spent: with P as in [`render`](Self::render), give N − (P − 1) to take N steps
    /// at most, or N − P with [foveation](Renderer::with_foveation). `places` keeps the order
    /// of tiles, which takes time for each.
    ///
    /// # Errors
    /// A size of tiles out of range; no pictures, or too many; `places` for fewer tiles than there
    /// are.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    pub fn new<'a, const W: usize>(
        pictures: &(impl Pictures<'a, W> + ?Sized),
        side: u32,
        budget: Budget,
        places: &'p mut [Place],
    ) -> Result<Self, FrameError>
    where
        Simd: Runs<W>,
    {
        if !(1..=Self::LARGEST_TILE).contains(&side) {
            return Err(FrameError::TileSize { side });
        }
        let count = pictures.count();
        if !(1..=usize::from(u16::MAX)).contains(&count) {
            return Err(FrameError::Pictures { count });
        }
        let views = (0..count).map_while(|number| pictures.view(number));
        let sizes = views.clone().map(|view| view.size());
        let (needed, given) = (Self::tiles_of(sizes, side), places.len());
        let Some(places) = places.get_mut(..needed) else {
            return Err(FrameError::Places { needed, given });
        };
        let mut rest = places.iter_mut();
        for (number, view) in (0..count).zip(views) {
            let sight = pictures.renderer(number).and_then(Renderer::line_of_sight);
            let [columns, rows] = view
                .size()
                .map(|pixels| pixels.div_ceil(side.max(1)) as u16);
            for row in 0..rows {
                for (column, place) in (0..columns).zip(&mut rest) {
                    *place = Place {
                        cosine: sight
                            .map_or(1.0, |sight| cosine(&sight, &view, side, (column, row))),
                        part: number as u16,
                        row,
                        column,
                    };
                }
            }
        }
        sort(places);
        Ok(Self {
            places,
            next: 0,
            job: None,
            side,
            budget,
            tiles: Tiles::default(),
        })
    }

    /// Returns the rest of the frame's budget.
    pub const fn budget(&self) -> Budget {
        self.budget
    }

    /// Counts of the tiles handed over.
    pub const fn tiles(&self) -> Tiles {
        self.tiles
    }

    /// Renders pixels until a tile is finished, the frame's budget spent or `slice` spent,
    /// whichever is first. `pixels` is room for a tile, `side`² pixels, of which a tile at a
    /// picture's border uses the first; they are kept from call to call until the tile is handed
    /// over. Tiles that the frame's budget did not finish are handed over all the same.
    ///
    /// `pictures` are those that the frame was begun with. A call renders at most one tile, and
    /// takes at most `slice` and what [`TileJob::render`] says of one sample more. An
    /// [overrun](Budget::with_overrun) of either budget holds.
    ///
    /// In time: with S the steps of `slice` and P those of the dearest sample of the scene, a call
    /// takes at most (S + P) · C1 + C0. P is the most that slices of one step take. C0 is a tile's
    /// fixed costs without steps: levels of detail, the background, a dome master's rays. C1 = 600
    /// and C0 = 400,000 instructions for tiles of 16² pixels, one ray a pixel, on a Cortex-M7 in
    /// [`Mode::Single`](super::Mode::Single); fixed costs grow with pixels and samples.
    ///
    /// # Errors
    /// Fewer `pixels`, other pictures.
    #[inline(never)]
    pub fn render<'a, const W: usize>(
        &mut self,
        pictures: &(impl Pictures<'a, W> + ?Sized),
        pixels: &mut [Pixel],
        slice: &mut Budget,
        workspace: &mut Workspace,
    ) -> Result<Progress, TileError>
    where
        Simd: Runs<W>,
    {
        let Some(place) = self.places.get(self.next) else {
            return Ok(Progress::Finished);
        };
        let part = usize::from(place.part);
        let (Some(view), Some(renderer)) = (pictures.view(part), pictures.renderer(part)) else {
            return Err(TileError::Outside);
        };
        let view = &view;
        let tile = self.tile(place, view).ok_or(TileError::Outside)?;
        let job = self.job.get_or_insert(TileJob::new(tile));
        let needed = tile.width as usize * tile.height as usize;
        let given = pixels.len();
        let pixels = pixels.get_mut(..needed);
        let pixels = pixels.ok_or(TileError::Pixels { needed, given })?;

        let mut budget = slice.within(self.budget);
        let before = workspace.statistics.steps;
        let outcome = job.render(renderer, view, pixels, &mut budget, workspace)?;
        // What a sample took above the call's budget counts for the frame's, so
        // that it runs out at the same sample however the frame is cut.
        let spent = workspace.statistics.steps.wrapping_sub(before);
        self.budget.spend(spent);
        slice.spend(spent);
        let whole = outcome == Outcome::Finished;
        if !whole && !self.budget.is_spent() {
            return Ok(Progress::BudgetSpent);
        }
        if whole {
            self.tiles.whole += 1;
        } else {
            job.give_up(renderer, view, pixels)?;
            self.tiles.given_up += 1;
        }
        self.job = None;
        self.next += 1;
        Ok(Progress::Tile { part, tile, whole })
    }

    fn tile(&self, place: &Place, view: &View) -> Option<Tile> {
        let [columns, rows] = view.size();
        let (x, y) = (
            u32::from(place.column) * self.side,
            u32::from(place.row) * self.side,
        );
        Some(Tile {
            x,
            y,
            width: columns.checked_sub(x)?.min(self.side),
            height: rows.checked_sub(y)?.min(self.side),
        })
    }
}

/// Returns the cosine between the line of sight and a tile's centre; −2 outside a dome's rim.
fn cosine(sight: &LineOfSight, view: &View, side: u32, (column, row): (u16, u16)) -> f32 {
    // A tile that the picture's border cuts off counts as a full square.
    let middle = |tile: u16| (u32::from(tile) * side) as f32 + 0.5 * (side - 1) as f32;
    let towards = view.direction(middle(column), middle(row));
    let towards = towards.map(Vec3::normalize_or_zero);
    towards.map_or(-2.0, |towards| towards.dot(sight.forward()))
}

/// Sorts places by a heap: no recursion, and a time bounded by their number.
fn sort(places: &mut [Place]) {
    let count = places.len();
    for root in (0..count / 2).rev() {
        sink(places, root);
    }
    let mut heap = places;
    while let Some((last, rest)) = heap.split_last_mut() {
        if let Some(first) = rest.first_mut() {
            core::mem::swap(first, last);
        }
        sink(rest, 0);
        heap = rest;
    }
}

/// Moves a heap's entry down to below all that come after it.
fn sink(heap: &mut [Place], mut at: usize) {
    loop {
        let left = 2 * at + 1;
        let last = match (heap.get(left), heap.get(left + 1)) {
            (Some(first), Some(second)) if second.order(first) == Ordering::Greater => left + 1,
            (Some(_), _) => left,
            (None, _) => return,
        };
        match heap.get_disjoint_mut([at, last]) {
            Ok([own, child]) if child.order(own) == Ordering::Greater => {
                core::mem::swap(own, child);
            }
            _ => return,
        }
        at = last;
    }
}
