//! A block of pixels that go through the scene together.

use super::detail::BlockDetail;
use super::{Mode, Renderer, View};
use crate::gaze::Region;
use crate::scene::format::Background;
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::{self, Budget, NOT_TRACED, Pixel, TileRays, Workspace};
use glam::Vec3;

/// Pixels a side.
pub(super) const BLOCK: u32 = 8;

/// The part of a cell of the view's grid that a tile covers.
pub(super) struct Block {
    pub(super) x: u32,
    pub(super) y: u32,
    /// 1 to [`BLOCK`].
    pub(super) columns: u32,
    /// 1 to [`BLOCK`].
    pub(super) rows: u32,
    /// Where the patch that it belongs to lies in the visual field.
    pub(super) patch: Region,
}

/// Where the pixels of a block go.
pub(super) struct Target<'p> {
    /// Of the tile, in rows.
    pub(super) pixels: &'p mut [Pixel],
    /// Pixels of a row.
    pub(super) width: usize,
    /// Column of the block's first pixel.
    pub(super) x: usize,
    /// Row of the block's first pixel.
    pub(super) y: usize,
}

impl Target<'_> {
    /// Of the block's row, the first `columns` pixels.
    #[inline(always)]
    fn row(&mut self, row: u32, columns: u32) -> &mut [Pixel] {
        let start = (self.y + row as usize) * self.width + self.x;
        let pixels = self.pixels.get_mut(start..start + columns as usize);
        pixels.unwrap_or_default()
    }

    fn write(&mut self, column: u32, row: u32, pixel: Pixel) {
        if let Some(place) = self.row(row, column + 1).last_mut() {
            *place = pixel;
        }
    }
}

impl Block {
    /// Renders the pixels from number `first` on, in rows, and says how many
    /// it finished.
    pub(super) fn render<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        first: u32,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> u32
    where
        Simd: Runs<W>,
    {
        // What is left of a block that was interrupted goes ray by ray.
        if renderer.settings.mode == Mode::Tile && first == 0 {
            self.render_together(renderer, view, budget, workspace, target)
        } else {
            self.render_singly(renderer, view, first, budget, workspace, target)
        }
    }

    fn render_singly<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        first: u32,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let detail = self.detail(renderer, view);
        for number in first..self.columns * self.rows {
            if budget.is_spent() {
                return number - first;
            }
            let at = (number % self.columns, number / self.columns);
            let pixel = self.pixel(renderer, view, at, &detail, budget, workspace);
            target.write(at.0, at.1, pixel);
        }
        self.columns * self.rows - first
    }

    /// Of its pixels, by its own columns and rows.
    fn detail<const W: usize>(&self, renderer: &Renderer<'_, W>, view: &View) -> BlockDetail
    where
        Simd: Runs<W>,
    {
        renderer
            .block_detail(self.patch, view, self.x, self.y)
            .of_part((self.x % BLOCK, self.y % BLOCK), (self.columns, self.rows))
    }

    /// All samples of a pixel, one ray after the other.
    fn pixel<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        (column, row): (u32, u32),
        detail: &BlockDetail,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel
    where
        Simd: Runs<W>,
    {
        let samples = renderer.settings.samples;
        let detail = detail.at(column, row);
        let tracer = &renderer.tracer;
        let mut sum = Sum::default();
        for sample in 0..samples {
            let (x, y) = self.at(column, row, offset(sample, samples));
            match (detail, view.ray(x, y)) {
                (Some(detail), Some(ray)) => {
                    sum.add(tracer.radiance_with(&ray, detail, budget, workspace));
                }
                _ => sum.add(tracer.missed(view.direction(x, y))),
            }
        }
        sum.mean(samples)
    }

    fn render_together<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let samples = renderer.settings.samples;
        let offset = offset(0, samples);
        let reaches = self.reaches(renderer, view, offset, budget, workspace);
        if samples == 1 && !reaches {
            // Its mean is the sample itself.
            let past = self.past(renderer, view, offset);
            let copied = <Simd as Runs<8>>::run(renderer.tracer.simd(), CopyPast { past, target });
            if copied.is_some() {
                let traced = renderer.block_traced(self.patch, view, self.x, self.y);
                workspace.statistics.primary += self.count(traced);
                return self.columns * self.rows;
            }
        }
        self.render_samples(renderer, view, reaches, budget, workspace, target)
    }

    /// Whether a sample of any pixel is traced and may hit anything.
    fn reaches<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        offset: (f32, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        self.patch != Region::Outside && {
            let corners = self.corners(view, offset);
            let tracer = &renderer.tracer;
            tracer.may_hit(view.eye(), &corners, budget, workspace)
        }
    }

    /// Sample by sample, of which the first is known to reach something or not.
    fn render_samples<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        mut reaches: bool,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let Renderer {
            tracer, settings, ..
        } = renderer;
        let samples = settings.samples;
        let mut detail = None;
        let mut sums = [[Sum::default(); BLOCK as usize]; BLOCK as usize];
        for sample in 0..samples {
            let offset = offset(sample, samples);
            let last = sample + 1 == samples;
            if sample > 0 {
                reaches = self.reaches(renderer, view, offset, budget, workspace);
            }
            let found = reaches.then(|| {
                let detail = &*detail.get_or_insert_with(|| self.detail(renderer, view));
                let rays = self.rays(renderer, view, offset, detail);
                let hits = tracer.nearest_of_tile(&rays, budget, workspace);
                (detail, rays, hits)
            });
            let past = self.past(renderer, view, offset);
            let past = <Simd as Runs<8>>::run(tracer.simd(), past);
            for (row, sums) in (0..self.rows).zip(&mut sums) {
                for (column, sum) in (0..self.columns).zip(sums) {
                    let first = (column, row) == (0, 0);
                    if budget.is_spent() && !last {
                        // No pixel has all its samples yet, and none would by
                        // starting over: one is finished alone, and the block
                        // is no longer whole.
                        let detail = self.detail(renderer, view);
                        let pixel = self.pixel(renderer, view, (0, 0), &detail, budget, workspace);
                        target.write(0, 0, pixel);
                        return 1;
                    }
                    let mut traced = false;
                    let hit = found.as_ref().and_then(|(detail, rays, hits)| {
                        let own = detail.at(column, row)?;
                        traced = true;
                        let (column, row) = (column as usize, row as usize);
                        Some((own, rays.at(column, row)?, hits.at(column, row)?))
                    });
                    if let Some((own, ray, hit)) = hit {
                        if budget.is_spent() && !first {
                            return row * self.columns + column;
                        }
                        sum.add(tracer.radiance_from(&ray, Some(hit), own, budget, workspace));
                    } else {
                        workspace.statistics.primary += u64::from(traced);
                        sum.add(if let Some(past) = &past {
                            past.pixel(column, row)
                        } else {
                            let (x, y) = self.at(column, row, offset);
                            tracer.missed(view.direction(x, y))
                        });
                    }
                    if last {
                        target.write(column, row, sum.mean(samples));
                    }
                }
            }
            if found.is_none() {
                let traced = renderer.block_traced(self.patch, view, self.x, self.y);
                workspace.statistics.primary += self.count(traced);
            }
        }
        self.columns * self.rows
    }

    /// How many of its pixels are in a set of the view's grid block, which has
    /// a bit for each by row, then column.
    fn count(&self, set: u64) -> u64 {
        let (x, y) = (self.x % BLOCK, self.y % BLOCK);
        let columns = (0xff >> (BLOCK - self.columns)) << x;
        let mut count = 0;
        for row in y..y + self.rows {
            count += u64::from((set >> (BLOCK * row) & columns).count_ones());
        }
        count
    }

    /// What its pixels show that see past everything.
    fn past<'r, const W: usize>(
        &'r self,
        renderer: &'r Renderer<'_, W>,
        view: &'r View,
        offset: (f32, f32),
    ) -> SeePast<'r>
    where
        Simd: Runs<W>,
    {
        SeePast {
            block: self,
            background: renderer.tracer.scene().background(),
            view,
            offset,
        }
    }

    /// A point of a pixel of this block, in pixels of the view.
    fn at(&self, column: u32, row: u32, (dx, dy): (f32, f32)) -> (f32, f32) {
        ((self.x + column) as f32 + dx, (self.y + row) as f32 + dy)
    }

    /// Towards the four pixels at the block's corners.
    fn corners(&self, view: &View, offset: (f32, f32)) -> [Vec3; 4] {
        let (right, below) = (self.columns - 1, self.rows - 1);
        let corner = |column, row| {
            let (x, y) = self.at(column, row, offset);
            view.direction(x, y)
        };
        [
            corner(0, 0),
            corner(right, 0),
            corner(0, below),
            corner(right, below),
        ]
    }

    /// All 64 rays; those past a cut-off block's borders are not traced.
    fn rays<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        offset: (f32, f32),
        detail: &BlockDetail,
    ) -> TileRays
    where
        Simd: Runs<W>,
    {
        let directions = Directions {
            block: self,
            view,
            offset,
        };
        let rays = <Simd as Runs<8>>::run(renderer.tracer.simd(), directions);
        match detail {
            BlockDetail::Equal(detail) => rays.on_rung(detail.rung),
            BlockDetail::Own(own) => rays.on_rungs(&own.rungs),
            BlockDetail::Outside => rays.on_rungs(&[[NOT_TRACED; 8]; 8]),
        }
    }
}

struct Directions<'r> {
    block: &'r Block,
    view: &'r View,
    offset: (f32, f32),
}

impl Kernel<8> for Directions<'_> {
    type Output = TileRays;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> TileRays {
        TileRays::from_rows(self.view.eye(), |row| {
            let place = (self.block.x, self.block.y + row as u32);
            let [x, y, z] = self.view.directions(l, place, self.offset);
            [l.store(x), l.store(y), l.store(z)]
        })
    }
}

/// What is seen past all objects, by row, then column.
struct Past([[Pixel; BLOCK as usize]; BLOCK as usize]);

impl Past {
    #[inline(always)]
    fn row(&self, row: u32) -> &[Pixel; BLOCK as usize] {
        &self.0[(row % BLOCK) as usize]
    }

    #[inline(always)]
    fn pixel(&self, column: u32, row: u32) -> Pixel {
        self.row(row)[(column % BLOCK) as usize]
    }
}

/// What pixels of a block show that see past everything.
struct SeePast<'r> {
    block: &'r Block,
    background: &'r Background,
    view: &'r View,
    offset: (f32, f32),
}

impl SeePast<'_> {
    /// Of a row; `None` where that cannot be computed for all together.
    #[inline(always)]
    fn row<L: Lanes<8>>(&self, l: L, row: u32) -> Option<[Pixel; BLOCK as usize]> {
        let place = (self.block.x, self.block.y + row);
        let directions = self.view.directions(l, place, self.offset);
        let [red, green, blue] = trace::colours(l, self.background, directions)?;
        let (red, green, blue) = (l.store(red), l.store(green), l.store(blue));
        let alpha = 1.0 - (1.0 - self.background.alpha);
        let mut pixels = [Pixel::default(); BLOCK as usize];
        for (column, pixel) in pixels.iter_mut().enumerate() {
            *pixel = Pixel {
                red: red[column],
                green: green[column],
                blue: blue[column],
                alpha,
            };
        }
        Some(pixels)
    }
}

impl Kernel<8> for SeePast<'_> {
    type Output = Option<Past>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<Past> {
        let mut past = Past(Default::default());
        for row in 0..self.block.rows {
            past.0[(row % BLOCK) as usize] = self.row(l, row)?;
        }
        Some(past)
    }
}

/// The same, straight to where the pixels go: `None` where some are not there.
struct CopyPast<'r, 't, 'p> {
    past: SeePast<'r>,
    target: &'t mut Target<'p>,
}

impl Kernel<8> for CopyPast<'_, '_, '_> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<()> {
        let block = self.past.block;
        for row in 0..block.rows {
            let pixels = self.past.row(l, row)?;
            let places = self.target.row(row, block.columns);
            for (place, pixel) in places.iter_mut().zip(&pixels) {
                *place = *pixel;
            }
        }
        Some(())
    }
}

/// Samples of a pixel, in their order.
#[derive(Clone, Copy, Default)]
struct Sum(Pixel);

impl Sum {
    fn add(&mut self, pixel: Pixel) {
        self.0.red += pixel.red;
        self.0.green += pixel.green;
        self.0.blue += pixel.blue;
        self.0.alpha += pixel.alpha;
    }

    fn mean(self, samples: u16) -> Pixel {
        let share = 1.0 / f32::from(samples);
        Pixel {
            red: self.0.red * share,
            green: self.0.green * share,
            blue: self.0.blue * share,
            alpha: self.0.alpha * share,
        }
    }
}

/// Where in its pixel a sample lies, from the centre: Hammersley's points,
/// centred.
fn offset(sample: u16, samples: u16) -> (f32, f32) {
    let x = (f32::from(sample) + 0.5) / f32::from(samples) - 0.5;
    // The radical inverse: the bits of the number behind the binary point.
    let bits = samples.next_power_of_two().trailing_zeros();
    let reversed = u32::from(sample).reverse_bits().checked_shr(32 - bits);
    let steps = (1u32 << bits) as f32;
    let y = (reversed.unwrap_or(0) as f32 + 0.5) / steps - 0.5;
    (x, y)
}
