//! A tile that is gone through to see what each effect does.

use super::begun::Sum;
use super::tile::{BLOCK, offset};
use super::{Renderer, Tile, TileError, View};
use crate::simd::{Runs, Simd};
use crate::trace::{Ledger, Pixel, Sample, Workspace};

impl<const W: usize> Renderer<'_, W>
where
    Simd: Runs<W>,
{
    /// Renders a tile of a view into `pixels` (rows, from the top), and enters into a ledger
    /// what each effect does in it. Pixels are those of
    /// [`TileJob::render`](super::TileJob::render), rays those of
    /// [`Mode::Single`](super::Mode::Single) without its test of blocks. Slow: for reports.
    ///
    /// # Errors
    /// A tile that is not inside the view; `pixels` of another length than the tile.
    pub fn account(
        &self,
        view: &View,
        tile: Tile,
        pixels: &mut [Pixel],
        ledger: &mut Ledger,
        workspace: &mut Workspace,
    ) -> Result<(), TileError>
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::account(self, view, tile, pixels, ledger, workspace)
    }

    pub(crate) fn enter(
        &self,
        view: &View,
        tile: Tile,
        pixels: &mut [Pixel],
        ledger: &mut Ledger,
        workspace: &mut Workspace,
    ) -> Result<(), TileError> {
        tile.check(view.size(), pixels.len())?;
        for part in tile.blocks() {
            let patch = self.patch_region(view, part.x, part.y);
            let detail = self.block_detail(patch, view, part.x, part.y);
            for y in part.y..part.y + part.height {
                for x in part.x..part.x + part.width {
                    let detail = detail.at(x % BLOCK, y % BLOCK);
                    let mut sum = Sum::NONE;
                    for index in 0..self.settings.samples {
                        let (dx, dy) = offset(index, self.settings.samples);
                        let (column, row) = (x as f32 + dx, y as f32 + dy);
                        let sample = Sample::new(x, y, index, self.settings.samples);
                        let seen = match (detail, view.ray(column, row)) {
                            (Some(detail), Some(ray)) => self
                                .tracer
                                .radiance_and_record(&ray, detail, sample, workspace, ledger),
                            _ => self.past(view, column, row),
                        };
                        sum.add(seen, workspace);
                    }
                    ledger.end_pixel();
                    if let Some(pixel) = pixels.get_mut(tile.index(x, y)) {
                        *pixel = sum.mean(self.settings.samples);
                    }
                }
            }
        }
        Ok(())
    }
}
