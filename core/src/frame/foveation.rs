//! Fewer rays where the eye resolves less.
//!
//! The acuity at a square of the view's grid determines its stride, the distance
//! of its samples in pixels; [`lattice`](super::lattice) fills the pixels between
//! them. The stride depends on the view and the gaze only: not on tiles, the budget
//! or the frame before.

use super::begun::Work;
use super::block::Rendering;
use super::lattice::SquareRenderer;
use super::past::CopyPast;
use super::tile::{BLOCK, Piece, Target};
use super::view::{Kind, View};
use super::{LevelOfDetail, Outcome, Pixels, Renderer, Tile, TileJob};
use crate::gaze::{Acuity, Gaze, Region};
use crate::numeric::{max, normalize, sqrt};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, Workspace};
use glam::Vec3;

/// Most pixels between two samples next to each other.
pub const LARGEST_STRIDE: u32 = 16;

/// Pixels a side of the squares, each of which has a stride of its own.
const SQUARE: u32 = 32;
const QUARTER: u32 = SQUARE / 2;

/// Least stride at which a square is not divided into quarters.
const WHOLE_SQUARE: u32 = 4;

/// Functions for foveation: pointers, so that programs without foveation have no code for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foveation<const W: usize> {
    acuity: Acuity,
    pub(super) render: RenderTile<W>,
    pub(super) give_up: GiveUpTile<W>,
}

type RenderTile<const W: usize> =
    fn(&Renderer<'_, W>, &mut TileJob, &View, &mut [Pixel], &mut Budget, &mut Workspace) -> Outcome;

type GiveUpTile<const W: usize> = fn(&Renderer<'_, W>, &mut TileJob, &View, &mut [Pixel]);

impl<const W: usize> Rendering<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Gives its pixels from number `first` on the background.
    fn show_background(&self, first: u32, target: &mut Target<'_>) {
        if let (Kind::Screen(screen), 0) = (self.view.kind(), first) {
            let past = self.past(screen, (0.0, 0.0));
            let copy = CopyPast { past, target };
            if <Simd as Runs<8>>::run(self.renderer.tracer.simd(), copy).is_some() {
                return;
            }
        }
        for (column, row) in self.block.places_from(first) {
            let (x, y) = self.block.at(column, row, (0.0, 0.0));
            target.write(column, row, self.renderer.past(self.view, x, y));
        }
    }
}

impl<const W: usize> Renderer<'_, W>
where
    Simd: Runs<W>,
{
    /// Returns the same renderer with a [level of detail](Self::with_level_of_detail), and with
    /// samples as far apart as `acuity` resolves: in the periphery not every pixel has a ray.
    ///
    /// Samples are 1, 2, 4, 8 or at most [`LARGEST_STRIDE`] pixels apart, on the view's own grid,
    /// by squares of 32 pixels a side or their quarters. Where neighbouring samples show different
    /// things or light, two more halvings of their distance follow. Pixels between samples of one
    /// instance are interpolated; others take the nearest sample's. Where samples are a pixel
    /// apart, around the line of sight, every pixel is the same as without foveation.
    #[must_use]
    pub fn with_foveation(self, lod: LevelOfDetail, acuity: Acuity) -> Self
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::foveated(self, lod, acuity)
    }

    pub(crate) fn foveated(self, lod: LevelOfDetail, acuity: Acuity) -> Self {
        Self {
            pixels: Pixels::Foveated(Foveation {
                acuity,
                render: |renderer, job, view, pixels, budget, workspace| {
                    renderer.render_squares(job, view, pixels, budget, workspace)
                },
                give_up: |renderer, job, view, pixels| renderer.give_up_squares(job, view, pixels),
            }),
            ..self.with_level_of_detail(lod)
        }
    }

    /// Returns the stride around pixel (x, y) of a view, before refinement: a power of two; 1 if
    /// every pixel has a sample, or the view has no such pixel.
    pub fn stride(&self, view: &View, x: u32, y: u32) -> u32 {
        let (width, height) = (1, 1);
        let tile = Tile {
            x,
            y,
            width,
            height,
        };
        let mut stride = 1;
        if tile.check(view.size(), 1).is_ok() {
            self.pieces(view, tile, |piece| {
                stride = piece.stride;
                true
            });
        }
        stride
    }

    /// Calls `each` with the pieces of a tile until it returns false.
    fn pieces(&self, view: &View, tile: Tile, mut each: impl FnMut(Piece) -> bool) -> bool {
        let (Pixels::Foveated(foveation), Some(lod)) = (&self.pixels, &self.lod) else {
            return true;
        };
        let of = |square: Tile, side: u32| {
            let corner = (square.x / side * side, square.y / side * side);
            Piece {
                tile: square,
                corner,
                side,
                stride: stride(&foveation.acuity, &lod.gaze, view, corner, side),
            }
        };
        tile.squares(SQUARE).all(|square| {
            let whole = of(square, SQUARE);
            if whole.stride >= WHOLE_SQUARE {
                return each(whole);
            }
            square.squares(QUARTER).all(|square| {
                let quarter = of(square, QUARTER);
                if quarter.stride > 1 {
                    return each(quarter);
                }
                square.blocks().all(|tile| {
                    each(Piece {
                        tile,
                        side: BLOCK,
                        ..quarter
                    })
                })
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
        let mut before = 0;
        let finished = self.pieces(view, job.tile, |piece| {
            let tile = piece.tile;
            before += tile.area();
            if job.finished >= before {
                return true;
            }
            if budget.is_spent() {
                return false;
            }
            let mut work = Work {
                begun: &mut job.begun,
                budget,
                workspace,
                target: Target::new(pixels, job.tile, tile),
            };
            let is_finished = if piece.stride == 1 {
                let patch = self.patch_region(view, tile.x, tile.y);
                self.rendering(view, tile, patch).render(&mut work);
                work.begun.pixels == tile.area()
            } else {
                SquareRenderer::render(piece, self, view, &mut work)
            };
            if is_finished {
                job.end_part(before);
            }
            is_finished
        });
        if finished {
            Outcome::Finished
        } else {
            Outcome::BudgetSpent
        }
    }

    fn give_up_squares(&self, job: &mut TileJob, view: &View, pixels: &mut [Pixel]) {
        let mut before = 0;
        self.pieces(view, job.tile, |piece| {
            let area = piece.tile.area();
            if job.finished < before + area {
                let target = &mut Target::new(pixels, job.tile, piece.tile);
                if piece.stride == 1 {
                    let rendering = self.rendering(view, piece.tile, Region::Outside);
                    rendering.show_background(job.begun.pixels, target);
                } else {
                    self.show_background(view, piece.tile, target);
                }
                job.end_part(before + area);
            }
            before += area;
            true
        });
    }

    /// Gives the pixels of a square the background.
    pub(super) fn show_background(&self, view: &View, square: Tile, target: &mut Target<'_>) {
        // In blocks as high as the square.
        for column in (0..square.width).step_by(BLOCK as usize) {
            let part = Tile {
                x: square.x + column,
                width: BLOCK.min(square.width - column),
                ..square
            };
            let mut target = Target {
                pixels: &mut *target.pixels,
                x: target.x + column as usize,
                ..*target
            };
            let rendering = self.rendering(view, part, Region::Outside);
            rendering.show_background(0, &mut target);
        }
    }
}

/// Returns the largest stride that the acuity does not resolve; 1 at a dome master's rim.
fn stride(acuity: &Acuity, gaze: &Gaze, view: &View, (x, y): (u32, u32), side: u32) -> u32 {
    let towards = |right: u32, below: u32| {
        let place = |first: u32, by: u32| (first + by) as f32 - 0.5;
        view.direction(place(x, right), place(y, below))
            .and_then(normalize)
    };
    let (Some(first), Some(right), Some(below), Some(last), Some(middle)) = (
        towards(0, 0),
        towards(side, 0),
        towards(0, side),
        towards(side, side),
        towards(side / 2, side / 2),
    ) else {
        return 1;
    };
    let corners = [first, right, last, below];
    let reach = corners
        .iter()
        .map(|corner| angle(middle, *corner))
        .fold(0.0, max);
    let eccentricity = angle(middle, gaze.line_of_sight().forward()) - reach;
    // Sides span a few degrees: a chord equals its angle to a few thousandths.
    let sides = corners.into_iter().zip([right, last, below, first]);
    let longest = sides
        .map(|(from, to)| (to - from).dot(to - from))
        .fold(0.0, max);
    let pixel = sqrt(longest) / side as f32;
    let seen = acuity.least_angle(eccentricity);
    let mut stride = 1;
    while stride < LARGEST_STRIDE.min(side / 2) && (2 * stride) as f32 * pixel <= seen {
        stride *= 2;
    }
    stride
}

/// Returns the angle between two unit vectors, radians.
fn angle(a: Vec3, b: Vec3) -> f32 {
    let across = a.cross(b);
    libm::atan2f(sqrt(across.dot(across)), a.dot(b))
}
