//! A square of pixels: its samples are tested together, and its light is computed at fewer points.

mod fine;
mod light;
mod plane;
mod sizes;

use super::Renderer;
use super::begun::Work;
use super::tile::{Piece, Target, Tile, offset};
use crate::numeric::sqrt;
use crate::scene::format::Material;
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use crate::trace::apart::ShadeApart;
use crate::trace::beam::{
    Beam, Drawing, MOST_SURFACES, ROW_BLOCKS, SIDE, Samples, Seen, SurfaceId, Surfaces,
};
use crate::trace::facet::Fineness;
use crate::trace::{Hit, MeshHit, Pixel, RayDetail, Steps, Width};
use fine::Pixels;
use glam::Vec3;
use heapless::Vec;
use light::{Chart, Lights, Lit};
use plane::{LEAST_OF_PLANE, MOST_PLANES, PlaneLight};
pub use sizes::LARGEST_UNIT;
pub(super) use sizes::Sizes;

const PIXELS: usize = SIDE * SIDE;

/// Samples of a pixel in one pass.
const SAMPLES_OF_PIXEL: usize = 4;
const SAMPLES: u16 = SAMPLES_OF_PIXEL as u16;

/// Returns how many samples of a pixel [foveation](super::Renderer::with_foveation) traces where
/// this many are asked for: whole passes of four.
pub const fn foveated_samples(asked: u16) -> u16 {
    asked.div_ceil(SAMPLES).saturating_mul(SAMPLES)
}

/// Directions from one point over a square's picture: to the right, below, and of its first corner,
/// which is (0, 0).
#[derive(Debug, Clone, Copy)]
pub(super) struct Picture {
    pub(super) eye: Vec3,
    pub(super) directions: [Vec3; 3],
}

impl Picture {
    fn direction(&self, x: f32, y: f32) -> Vec3 {
        let [right, below, first] = self.directions;
        first + right * x + below * y
    }

    fn ray(&self, x: f32, y: f32) -> Option<Ray> {
        Ray::new(self.eye, self.direction(x, y))
    }

    /// Returns the width of one of the four samples of a pixel.
    fn width(&self) -> Width {
        let [right, ..] = self.directions;
        Width::new(0.5 * sqrt(right.dot(right)))
    }
}

/// The number of surfaces that are lit together: below [`MIXED`].
type GroupNumber = u8;

/// Samples see nothing.
const NOTHING: GroupNumber = u8::MAX;
/// Samples see more than one group, or a surface that belongs to none.
const MIXED: GroupNumber = u8::MAX - 1;
const MOST_GROUPS: usize = 64;

#[derive(Debug, Clone, Copy)]
struct Group<'a> {
    instance: u32,
    material: &'a Material,
    /// Which way its facets face; 0 for bent surfaces.
    facing: u8,
    /// Number of its plane, if it is one.
    plane: Option<u8>,
    /// Whether its light may change from a pixel to the next.
    is_busy: bool,
    /// Where its colours may change within a pixel.
    fineness: Fineness,
}

/// The number of samples that see a surface, the last of them, and the surface's group.
#[derive(Debug, Clone, Copy)]
struct Use {
    count: u16,
    sample: u16,
    group: GroupNumber,
}

pub(super) struct Square<'r, 'a, const W: usize> {
    renderer: &'r Renderer<'a, W>,
    shade: &'r ShadeApart<W>,
    corner: (u32, u32),
    sizes: Sizes,
    picture: Picture,
    beam: Beam,
    samples: Samples,
    /// The number of this pass, and of passes.
    pass: (u16, u16),
    seen: Seen,
    surfaces: Surfaces,
    uses: Vec<Use, MOST_SURFACES>,
    groups: Vec<Group<'a>, MOST_GROUPS>,
    planes: Vec<PlaneLight<'a>, MOST_PLANES>,
    /// The group that all samples of a pixel see, [`MIXED`] or [`NOTHING`].
    pure: [GroupNumber; PIXELS],
    /// The group that each sample of a pixel sees.
    seen_groups: [[GroupNumber; SAMPLES_OF_PIXEL]; PIXELS],
    lit: Vec<Lit, PIXELS>,
    /// Place in `lit` of a pixel's light, and 1; 0 where it is not known.
    lit_at: [u16; PIXELS],
    charts: [Option<Chart<'a>>; 16],
    /// Pixels each of whose samples is lit by itself.
    fine: Pixels,
}

impl<'r, 'a, const W: usize> Square<'r, 'a, W>
where
    Simd: Runs<W>,
{
    /// Renders the part of a square that is in a tile, in passes of four samples a pixel.
    pub(super) fn render(
        piece: &Piece,
        (sizes, picture): (Sizes, Picture),
        renderer: &'r Renderer<'a, W>,
        shade: &'r ShadeApart<W>,
        work: &mut Work<'_>,
    ) {
        let passes = renderer.settings.samples.div_ceil(SAMPLES);
        let side = sizes.side as f32;
        let corners = [(0.0, 0.0), (side, 0.0), (0.0, side), (side, side)];
        let corners = corners.map(|(x, y)| picture.direction(x, y));
        let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
        let leaves = (sizes.side * sizes.side) as u64;
        workspace.statistics.leaves += leaves;
        workspace.statistics.primary += leaves * u64::from(SAMPLES * passes);
        let tracer = &renderer.tracer;
        if !tracer.may_hit(picture.eye, &corners, budget, workspace) {
            return;
        }
        let Some(beam) = Beam::new(picture.eye, picture.directions, side) else {
            return;
        };
        let mut sums = [Pixel::NONE; PIXELS];
        for number in 0..passes {
            let pass = (number, passes);
            let corner = piece.corner;
            let mut square = Self::new((renderer, shade), (corner, sizes, picture, beam), pass);
            square.add_up(piece, &mut sums, work);
            if work.budget.is_exhausted() {
                return;
            }
            if number + 1 == passes {
                square.write(piece, &sums, work);
            }
        }
    }

    /// Returns the detail of its rays.
    fn detail(&self) -> RayDetail {
        let spread = if self.renderer.reads_levels() {
            self.picture.width()
        } else {
            Width::ZERO
        };
        RayDetail {
            spread,
            ..self.renderer.most
        }
    }

    fn new(
        (renderer, shade): (&'r Renderer<'a, W>, &'r ShadeApart<W>),
        (corner, sizes, picture, beam): ((u32, u32), Sizes, Picture, Beam),
        pass: (u16, u16),
    ) -> Self {
        let moved = match pass {
            (_, 1) => (0.0, 0.0),
            (number, count) => offset(number, count),
        };
        let moved = (0.25 * moved.0, 0.25 * moved.1);
        Self {
            renderer,
            shade,
            corner,
            sizes,
            picture,
            beam,
            samples: Samples::new(moved, sizes.side as u32),
            pass,
            seen: Seen::NOTHING,
            surfaces: Surfaces::new(),
            uses: Vec::new(),
            groups: Vec::new(),
            planes: Vec::new(),
            pure: [NOTHING; PIXELS],
            seen_groups: [[NOTHING; SAMPLES_OF_PIXEL]; PIXELS],
            lit: Vec::new(),
            lit_at: [0; PIXELS],
            charts: [const { None }; 16],
            fine: Pixels::NONE,
        }
    }

    /// Adds what this pass sees to the pixels' sums.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn add_up(&mut self, piece: &Piece, sums: &mut [Pixel; PIXELS], work: &mut Work<'_>) {
        self.draw(work);
        if self.surfaces.list().is_empty() && self.pass.1 == 1 {
            return;
        }
        self.sort(work);
        self.find_fine(work);
        self.light_pure(work);
        self.resolve(piece, sums, work);
    }

    /// Writes the pixels of a tile; a single pass leaves those that see nothing as they are.
    fn write(&self, piece: &Piece, sums: &[Pixel; PIXELS], work: &mut Work<'_>) {
        let passes = self.pass.1;
        let share = 1.0 / f32::from(SAMPLES * passes);
        let side = self.sizes.side;
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let place = SIDE * y + x;
            if let Some(part) = self.part_of(piece, x, y)
                && (passes > 1 || self.pure[place] != NOTHING)
            {
                let sum = sums[place];
                work.target.fill(part, sum.zip(sum, |sum, _| sum * share));
            }
        }
    }

    #[inline(never)]
    fn draw(&mut self, work: &mut Work<'_>) {
        let tracer = &self.renderer.tracer;
        let drawing = Drawing {
            scene: tracer.scene(),
            simd: tracer.simd(),
            beam: &self.beam,
            own: None,
            rung: self.renderer.most.rung,
            samples: &self.samples,
            surfaces: &mut self.surfaces,
            paper: &mut self.seen,
            stack: &mut work.workspace.stack,
            most: work.budget.most(),
            work: Steps::default(),
        };
        let steps = tracer.simd().run(drawing);
        work.workspace.account(steps, work.budget);
    }

    /// Finds out which surfaces are lit together, and which pixels see one such group alone.
    #[inline(never)]
    fn sort(&mut self, work: &mut Work<'_>) {
        let unused = Use {
            count: 0,
            sample: 0,
            group: MIXED,
        };
        for _ in self.surfaces.list() {
            let _ = self.uses.push(unused);
        }
        for (block, numbers) in self.seen.number.iter().enumerate() {
            let first = numbers[0];
            if *numbers == [first; 8] {
                if let Some(used) = index(first).and_then(|n| self.uses.get_mut(n)) {
                    used.count += 8;
                    used.sample = 8 * block as u16;
                }
                continue;
            }
            for (lane, number) in numbers.iter().enumerate() {
                if let Some(used) = index(*number).and_then(|n| self.uses.get_mut(n)) {
                    used.count += 1;
                    used.sample = (8 * block + lane) as u16;
                }
            }
        }
        // In the order of their numbers in the scene, which the tree's width does not change.
        let mut seen: Vec<u16, MOST_SURFACES> = Vec::new();
        for (number, used) in (0..).zip(&self.uses) {
            if used.count > 0 {
                let _ = seen.push(number);
            }
        }
        let list = self.surfaces.list();
        seen.sort_unstable_by_key(|number| {
            let id = list.get(usize::from(*number));
            id.map(|id| (id.instance, id.triangle))
        });
        // Large ones first: small parts of their planes join them.
        for is_large in [true, false] {
            for &number in &seen {
                let number = usize::from(number);
                let (Some(used), Some(id)) =
                    (self.uses.get(number), self.surfaces.list().get(number))
                else {
                    continue;
                };
                let (
                    Use {
                        count,
                        sample,
                        group,
                    },
                    id,
                ) = (*used, *id);
                if is_large != (count >= LEAST_OF_PLANE) || group != MIXED {
                    continue;
                }
                let may_join = self
                    .planes
                    .iter()
                    .any(|plane| plane.instance == id.instance);
                let plane = if is_large || may_join {
                    self.plane(&id, sample, is_large, work)
                } else {
                    None
                };
                let group = self.group(&id, plane);
                if let Some(used) = self.uses.get_mut(number) {
                    used.group = group;
                }
            }
        }
        let side = self.sizes.side;
        for (y, block) in (0..side).flat_map(|y| (0..side.div_ceil(2)).map(move |block| (y, block)))
        {
            let numbers = &self.seen.number[ROW_BLOCKS * y + block];
            let place = SIDE * y + 2 * block;
            let groups = if *numbers == [numbers[0]; 8] {
                [self.group_of(numbers[0]); 8]
            } else {
                numbers.map(|number| self.group_of(number))
            };
            for (pixel, groups) in groups.as_chunks::<SAMPLES_OF_PIXEL>().0.iter().enumerate() {
                let first = groups[0];
                self.seen_groups[place + pixel] = *groups;
                self.pure[place + pixel] = if *groups == [first; SAMPLES_OF_PIXEL] {
                    first
                } else {
                    MIXED
                };
            }
        }
    }

    #[inline(always)]
    fn group_of(&self, number: f32) -> GroupNumber {
        let used = index(number).map(|n| self.uses.get(n));
        used.map_or(NOTHING, |used| used.map_or(MIXED, |used| used.group))
    }

    fn group(&mut self, id: &SurfaceId, plane: Option<u8>) -> GroupNumber {
        let tracer = &self.renderer.tracer;
        let Some(material) = tracer.material(id) else {
            return MIXED;
        };
        let (instance, facing) = (id.instance, tracer.facing(id));
        let same = |group: &Group<'_>| {
            let is_same = core::ptr::eq(group.material, material);
            is_same && (group.instance, group.plane, group.facing) == (instance, plane, facing)
        };
        if let Some(known) = self.groups.iter().rposition(same) {
            return known as u8;
        }
        let is_busy = plane.is_none() && tracer.is_busy(id);
        let fineness = tracer.fineness(id);
        let group = Group {
            instance,
            material,
            facing,
            plane,
            is_busy,
            fineness,
        };
        match self.groups.push(group) {
            Ok(()) => self.groups.len() as u8 - 1,
            Err(_) => MIXED,
        }
    }

    /// Returns the part of a pixel of the square that is in a piece's tile.
    #[inline]
    fn part_of(&self, piece: &Piece, x: usize, y: usize) -> Option<Tile> {
        let (unit, tile) = (self.sizes.unit, piece.tile);
        let (px, py) = (
            piece.corner.0 + x as u32 * unit,
            piece.corner.1 + y as u32 * unit,
        );
        let (left, top) = (px.max(tile.x), py.max(tile.y));
        let (right, bottom) = (
            (px + unit).min(tile.x + tile.width),
            (py + unit).min(tile.y + tile.height),
        );
        (left < right && top < bottom).then(|| Tile {
            x: left - tile.x,
            y: top - tile.y,
            width: right - left,
            height: bottom - top,
        })
    }

    /// Adds up what each pixel's samples see.
    #[inline(never)]
    fn resolve(&mut self, piece: &Piece, sums: &mut [Pixel; PIXELS], work: &mut Work<'_>) {
        let side = self.sizes.side;
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let place = SIDE * y + x;
            let pure = self.pure[place];
            if pure == NOTHING && self.pass.1 == 1 || self.part_of(piece, x, y).is_none() {
                continue;
            }
            let number = self.seen.number[ROW_BLOCKS * y + x / 2][4 * (x & 1)];
            let seen = match pure {
                MIXED => self.mixed((x, y), work),
                _ => self.light((x, y), number, pure, 0xf, work),
            };
            sums[place] = sums[place].zip(seen, |a, b| a + b);
        }
    }

    /// Returns what the samples of a pixel see, by groups, summed up.
    fn mixed(&mut self, (x, y): (usize, usize), work: &mut Work<'_>) -> Pixel {
        let groups = self.seen_groups[SIDE * y + x];
        let numbers = self.seen.number[ROW_BLOCKS * y + x / 2];
        let numbers = [0, 1, 2, 3].map(|sample| numbers[4 * (x & 1) + sample]);
        let mut sum = Pixel::NONE;
        let mut left = 0xf_u8;
        while left != 0 {
            let sample = left.trailing_zeros() as usize & 3;
            let group = groups[sample];
            let mut mask = 1u8 << sample;
            for other in sample + 1..SAMPLES_OF_PIXEL {
                // A surface without a group is lit by itself.
                let same =
                    groups[other] == group && (group != MIXED || numbers[other] == numbers[sample]);
                mask |= u8::from(same) << other;
            }
            mask &= left;
            left &= !mask;
            let seen = self.light((x, y), numbers[sample], group, mask, work);
            sum = sum.zip(seen, |a, b| a + b);
        }
        sum
    }

    /// Returns the light of some samples of a pixel, which see one group, summed up.
    #[inline]
    fn light(
        &mut self,
        (x, y): (usize, usize),
        number: f32,
        group: GroupNumber,
        mask: u8,
        work: &mut Work<'_>,
    ) -> Pixel {
        let middle = (x as f32 + 0.5, y as f32 + 0.5);
        if group == NOTHING {
            let direction = self.picture.direction(middle.0, middle.1);
            let past = self
                .renderer
                .tracer
                .missed(direction, || self.detail().spread);
            return past.zip(past, |light, _| light * mask.count_ones() as f32);
        }
        let plane = self
            .groups
            .get(usize::from(group))
            .and_then(|group| group.plane);
        let lit = match (plane, mask) {
            (Some(plane), _) => self.light_of_plane(plane, (x, y), mask, work),
            (None, 0xf) if group != MIXED => {
                self.light_of_pixel(x, y, Lights::UNKNOWN, work).times(4.0)
            }
            (None, _) => self
                .light_of((x, y), mask, Lights::UNKNOWN, work)
                .times(mask.count_ones() as f32),
        };
        if lit.diffuse == Vec3::ZERO {
            return lit.pixel;
        }
        match index(number).and_then(|surface| self.colour(surface, middle)) {
            Some(colour) => lit.coloured(colour),
            None => lit.pixel,
        }
    }
}

/// Returns a ray's hit on a surface, by 1/t.
fn hit_of(surface: &SurfaceId, near: f32) -> Hit {
    Hit {
        instance: surface.instance,
        on: MeshHit {
            t: 1.0 / near,
            triangle: surface.triangle,
            leaf: surface.leaf,
            lane: surface.lane,
        },
    }
}

/// Returns a surface's place in the list of those seen.
fn index(number: f32) -> Option<usize> {
    (number as usize).checked_sub(1)
}

impl Target<'_> {
    /// Gives a part of the block a pixel.
    fn fill(&mut self, part: Tile, pixel: Pixel) {
        for row in part.y..part.y + part.height {
            let pixels = self.row(row, part.x + part.width);
            if let Some(pixels) = pixels.get_mut(part.x as usize..) {
                pixels.fill(pixel);
            }
        }
    }
}
