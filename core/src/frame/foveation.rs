//! Detail where the eye sees it.
//!
//! The acuity at a square of the view's grid says how many of its pixels are one, and how far apart
//! light is computed; [`square`](super::square) does the rest. Sizes depend on the view and the gaze
//! only: not on tiles, the budget or the frame before.

use super::begun::Work;
use super::past::CopyPast;
use super::square::{Picture, Sizes, Square};
use super::tile::{BLOCK, Piece, Target};
use super::view::{Kind, View};
use super::{Outcome, Pixels, Renderer, Tile, TileJob};
use crate::gaze::{Acuity, LineOfSight, Region};
use crate::scene::EffectSet;
use crate::simd::{Runs, Simd};
use crate::trace::apart::ShadeApart;
use crate::trace::{Budget, Pixel, Sample, Workspace};

/// Pixels a side of the squares that have one size, and of their quarters, which have sizes of
/// their own where every pixel is rendered or where a dome bends; blocks do where it bends more.
const SQUARE: u32 = 32;
const QUARTER: u32 = SQUARE / 2;

/// Functions for foveation: pointers, so that programs without foveation have no code for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foveation<const W: usize> {
    pub(super) sight: LineOfSight,
    acuity: Acuity,
    shade: ShadeApart<W>,
    pub(super) render: RenderTile<W>,
    pub(super) give_up: GiveUpTile<W>,
}

type RenderTile<const W: usize> =
    fn(&Renderer<'_, W>, &mut TileJob, &View, &mut [Pixel], &mut Budget, &mut Workspace) -> Outcome;

type GiveUpTile<const W: usize> = fn(&Renderer<'_, W>, &mut TileJob, &View, &mut [Pixel]);

impl<const W: usize> Renderer<'_, W>
where
    Simd: Runs<W>,
{
    /// Returns the same renderer with the detail that an eye of an acuity sees around a line of
    /// sight. There is no border: all of a view is rendered, behind the viewer, too.
    ///
    /// Each pixel has four samples, at the same places in each frame; in the periphery 2², 4² or 8²
    /// pixels are one. Samples of a square are tested against each shape together. Light is
    /// computed at fewer points: on planes at those of a lattice, apart from shadows, which are
    /// found for each sample; on other surfaces at each, or as far apart as light changes little.
    /// Textures of dull meshes are averaged over pixels; other textures, graticules, and borders of
    /// shadows on bent surfaces are lit at each sample.
    ///
    /// Where rays have no common start, off a mirror into a dome, every pixel is rendered as
    /// without foveation; so it is next to a dome's rim, and where a square bends too much.
    #[must_use]
    pub fn with_foveation(self, sight: LineOfSight, acuity: Acuity) -> Self
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::foveated(self, sight, acuity)
    }

    pub(crate) fn foveated(self, sight: LineOfSight, acuity: Acuity) -> Self {
        Self {
            lod: None,
            pixels: Pixels::Foveated(Foveation {
                sight,
                acuity,
                shade: ShadeApart::for_effects::<{ EffectSet::ALL.bits() }>(),
                render: |renderer, job, view, pixels, budget, workspace| {
                    renderer.render_squares(job, view, pixels, budget, workspace)
                },
                give_up: |renderer, job, view, pixels| renderer.give_up_squares(job, view, pixels),
            }),
            ..self
        }
    }

    /// Returns how many pixels a side have one colour around pixel (x, y) of a view: a power of
    /// two, at most [`LARGEST_UNIT`](super::LARGEST_UNIT); 1 if the view has no such pixel.
    pub fn unit(&self, view: &View, x: u32, y: u32) -> u32 {
        let (width, height) = (1, 1);
        let tile = Tile {
            x,
            y,
            width,
            height,
        };
        let mut unit = 1;
        if tile.check(view.size(), 1).is_ok() {
            self.pieces(view, tile, |_, how| {
                unit = how.map_or(1, |(sizes, _)| sizes.unit);
                true
            });
        }
        unit
    }

    /// Returns whether the eye resolves each pixel of a view: then foveation leaves nothing out.
    pub fn resolves_all(&self, view: &View) -> bool {
        let [width, height] = view.size();
        let (x, y) = (0, 0);
        let all = Tile {
            x,
            y,
            width,
            height,
        };
        let Pixels::Foveated(Foveation { sight, acuity, .. }) = &self.pixels else {
            return true;
        };
        all.squares(QUARTER).all(|part| {
            let sizes = Sizes::new(acuity, sight, view, part.corner_of(QUARTER), QUARTER);
            sizes.is_none_or(|sizes| sizes.is_of_pixels())
        })
    }

    /// Calls `each` with the pieces of a tile, and how they are rendered, until it returns false:
    /// squares, or blocks in which every pixel has its own rays.
    fn pieces(
        &self,
        view: &View,
        tile: Tile,
        mut each: impl FnMut(Piece, Option<(Sizes, Picture)>) -> bool,
    ) -> bool {
        let Pixels::Foveated(Foveation { sight, acuity, .. }) = &self.pixels else {
            return true;
        };
        let how = |corner, pixels| {
            let sizes = Sizes::new(acuity, sight, view, corner, pixels)?;
            Some((sizes, Picture::new(view, corner, &sizes)?))
        };
        tile.squares(SQUARE).all(|square| {
            let corner = square.corner_of(SQUARE);
            if let Some(how) = how(corner, SQUARE).filter(|(sizes, _)| sizes.unit > 1) {
                return each(
                    Piece {
                        tile: square,
                        corner,
                    },
                    Some(how),
                );
            }
            square.squares(QUARTER).all(|part| {
                let corner = part.corner_of(QUARTER);
                match how(corner, QUARTER) {
                    Some(how) => each(Piece { tile: part, corner }, Some(how)),
                    None => part.blocks().all(|tile| {
                        let corner = tile.corner_of(BLOCK);
                        each(Piece { tile, corner }, how(corner, BLOCK))
                    }),
                }
            })
        })
    }

    fn render_squares(
        &self,
        job: &mut TileJob,
        view: &View,
        pixels: &mut [Pixel],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Outcome {
        let Pixels::Foveated(foveation) = &self.pixels else {
            return Outcome::Finished;
        };
        let mut before = 0;
        let finished = self.pieces(view, job.tile, |piece, how| {
            let tile = piece.tile;
            before += tile.area();
            if job.finished >= before {
                return true;
            }
            if job.is_finished() || budget.is_spent() {
                return false;
            }
            let mut work = Work {
                begun: &mut job.begun,
                budget,
                workspace,
                target: Target::new(pixels, job.tile, tile),
            };
            let is_finished = if let Some(how) = how {
                self.show_background(view, tile, &mut work.target);
                Square::render(&piece, how, self, &foveation.shade, &mut work);
                !work.budget.is_exhausted()
            } else {
                self.rendering(view, tile, Region::Central)
                    .render(&mut work);
                work.begun.pixels == tile.area()
            };
            if is_finished {
                job.end_part(before);
            }
            is_finished
        });
        if finished || job.is_finished() {
            Outcome::Finished
        } else {
            Outcome::BudgetSpent
        }
    }

    /// Gives each unfinished piece the colour of its middle.
    fn give_up_squares(&self, job: &mut TileJob, view: &View, pixels: &mut [Pixel]) {
        let mut workspace = Workspace::new();
        let mut before = 0;
        self.pieces(view, job.tile, |piece, _| {
            let tile = piece.tile;
            before += tile.area();
            if job.finished.min(job.end) < before {
                let target = &mut Target::new(pixels, job.tile, tile);
                self.show_background(view, tile, target);
                let middle = |first: u32, count: u32| first as f32 + 0.5 * count as f32 - 0.5;
                let ray = view.ray(middle(tile.x, tile.width), middle(tile.y, tile.height));
                let budget = &mut { Budget::UNLIMITED };
                let hit = ray.and_then(|ray| {
                    let searcher = &self.tracer.searcher;
                    let hit = searcher.nearest_on(self.most.rung, &ray, budget, &mut workspace)?;
                    Some((ray, hit))
                });
                if let Some((ray, hit)) = hit {
                    let of = Sample::new(tile.x, tile.y, 0, 1);
                    let seen = self.tracer.radiance_from(
                        &ray,
                        Some(hit),
                        self.most,
                        of,
                        budget,
                        &mut workspace,
                    );
                    for row in 0..tile.height {
                        target.row(row, tile.width).fill(seen);
                    }
                }
                job.end_part(before);
            }
            true
        });
    }

    /// Gives the pixels of a square what is seen past everything.
    fn show_background(&self, view: &View, square: Tile, target: &mut Target<'_>) {
        let spread = self.most_of(view).spread;
        for part in square.blocks() {
            let (x, y) = (
                target.x + (part.x - square.x) as usize,
                target.y + (part.y - square.y) as usize,
            );
            let mut target = Target {
                pixels: &mut *target.pixels,
                x,
                y,
                ..*target
            };
            let rendering = self.rendering(view, part, Region::Outside);
            if let Kind::Screen(screen) = view.kind() {
                let past = rendering.past(screen, (0.0, 0.0));
                let copy = CopyPast {
                    past,
                    target: &mut target,
                };
                if <Simd as Runs<8>>::run(self.tracer.simd(), copy).is_some() {
                    continue;
                }
            }
            for (column, row) in rendering.block.places_from(0) {
                let (x, y) = rendering.block.at(column, row, (0.0, 0.0));
                let past = view
                    .direction(x, y)
                    .map(|direction| self.tracer.missed(direction, || spread));
                target.write(column, row, past.unwrap_or_default());
            }
        }
    }
}

impl Tile {
    /// Returns the first pixel of the square of the view's grid that it is a part of.
    const fn corner_of(&self, side: u32) -> (u32, u32) {
        (self.x / side * side, self.y / side * side)
    }
}

const _: () = assert!(SQUARE.is_multiple_of(BLOCK) && QUARTER.is_multiple_of(BLOCK));
