//! Light of bent surfaces, and the colours of textures.

use super::{Group, PIXELS, SIDE, Square, hit_of, index};
use crate::frame::begun::{Sum, Work};
use crate::numeric::{max, min, sqrt};
use crate::simd::{Runs, Simd};
use crate::trace::beam::ROW_BLOCKS;
use crate::trace::{Pixel, Sample, texture};
use glam::Vec3;
use heapless::Vec;

/// Difference of √light between points up to which light between them is interpolated, and how far
/// the fourth of them may be from what the other three say.
const MOST_DIFFERENCE: f32 = 0.12;
const MOST_BEND: f32 = 0.03;

/// Light of a place: with a white texture, and the part that the texture colours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    pub(super) pixel: Pixel,
    pub(super) diffuse: Vec3,
}

impl Lit {
    pub(super) const NONE: Self = Self {
        pixel: Pixel::NONE,
        diffuse: Vec3::ZERO,
    };

    #[inline(always)]
    fn between(&self, other: &Self, share: f32) -> Self {
        Self {
            pixel: self.pixel.zip(other.pixel, |a, b| a + (b - a) * share),
            diffuse: self.diffuse + (other.diffuse - self.diffuse) * share,
        }
    }

    pub(super) fn times(self, count: f32) -> Self {
        Self {
            pixel: self.pixel.zip(self.pixel, |light, _| light * count),
            diffuse: self.diffuse * count,
        }
    }

    pub(super) fn coloured(&self, colour: Vec3) -> Pixel {
        let more = Pixel::new((colour - Vec3::ONE) * self.diffuse, 0.0);
        self.pixel.zip(more, |light, more| light + more)
    }
}

/// A surface's texture over the square's picture: 1/t, and places on it times 1/t, by linear
/// functions of column and row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coat {
    surface: usize,
    texture: Option<u32>,
    near: Vec3,
    u: Vec3,
    v: Vec3,
}

/// A part of the square that may be interpolated.
#[derive(Clone, Copy)]
struct Cell {
    x: u8,
    y: u8,
    step: u8,
}

impl<const W: usize> Square<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Lights the pixels that see one bent surface alone: at points first, and between them where
    /// light differs.
    #[inline(never)]
    pub(super) fn light_pure(&mut self, work: &mut Work<'_>) {
        if self
            .groups
            .iter()
            .all(|group| group.plane.is_some() || group.is_busy)
        {
            return;
        }
        let (side, step) = (self.sizes.side, self.sizes.bent);
        if step == 1 {
            return;
        }
        // Depth first: three wait on each level, and the last level's four.
        let mut cells: Vec<Cell, 16> = Vec::new();
        for (y, x) in (0..side)
            .step_by(step)
            .flat_map(|y| (0..side).step_by(step).map(move |x| (y, x)))
        {
            let _ = cells.push(Cell {
                x: x as u8,
                y: y as u8,
                step: step as u8,
            });
            while let Some(cell) = cells.pop() {
                if !self.light_cell(cell, work) && cell.step > 2 {
                    let half = cell.step / 2;
                    for (right, below) in [(0, 0), (half, 0), (0, half), (half, half)] {
                        let _ = cells.push(Cell {
                            x: cell.x + right,
                            y: cell.y + below,
                            step: half,
                        });
                    }
                }
            }
        }
    }

    /// Returns the group of a pixel, if it sees a bent surface alone whose light changes slowly.
    fn slow(&self, x: usize, y: usize) -> Option<&Group<'_>> {
        let group = self.groups.get(usize::from(self.pure[SIDE * y + x]))?;
        (group.plane.is_none() && !group.is_busy).then_some(group)
    }

    /// Interpolates the light of a cell between its corners; false if it is to be divided.
    fn light_cell(&mut self, cell: Cell, work: &mut Work<'_>) -> bool {
        let (x, y, step) = (
            usize::from(cell.x),
            usize::from(cell.y),
            usize::from(cell.step),
        );
        let group = self.pure[SIDE * y + x];
        let is_alike = (y..y + step).all(|row| {
            let pure = self.pure.get(SIDE * row + x..SIDE * row + x + step);
            pure.is_some_and(|pure| pure.iter().all(|other| *other == group))
        });
        if !is_alike {
            return false;
        }
        if self.slow(x, y).is_none() {
            return true;
        }
        // Corners are shared with the next cells where these see the same.
        let sees = |x: usize, y: usize| {
            x < self.sizes.side && y < self.sizes.side && self.pure[SIDE * y + x] == group
        };
        let (mut right, mut below) = (x + step, y + step);
        if !sees(right, y) || !sees(right, y + step - 1) {
            right -= 1;
        }
        if !sees(x, below) || !sees(right, below) {
            below -= 1;
        }
        let corners = [(x, y), (right, y), (x, below), (right, below)];
        let [a, b, c, d] = corners.map(|(x, y)| self.light_of_pixel(x, y, work));
        if step > self.sizes.bent_least && differ([&a, &b, &c, &d]) {
            return false;
        }
        let (across, down) = (1.0 / (right - x) as f32, 1.0 / (below - y) as f32);
        for row in y..y + step {
            let share = (row - y) as f32 * down;
            let (first, last) = (a.between(&c, share), b.between(&d, share));
            for column in x..x + step {
                if self.lit_at[SIDE * row + column] == 0 {
                    self.keep(
                        column,
                        row,
                        first.between(&last, (column - x) as f32 * across),
                    );
                }
            }
        }
        true
    }

    fn keep(&mut self, x: usize, y: usize, lit: Lit) {
        if self.lit.push(lit).is_ok() {
            self.lit_at[(SIDE * y + x) % PIXELS] = self.lit.len() as u16;
        }
    }

    /// Returns the light of a pixel all of whose samples see one surface or group.
    pub(super) fn light_of_pixel(&mut self, x: usize, y: usize, work: &mut Work<'_>) -> Lit {
        let known = usize::from(self.lit_at[(SIDE * y + x) % PIXELS]).checked_sub(1);
        if let Some(lit) = known.and_then(|known| self.lit.get(known)) {
            return *lit;
        }
        let lit = self.light_of(x, y, 0xf, work);
        self.keep(x, y, lit);
        lit
    }

    /// Returns the light of the part of a pixel in which some samples see one surface or group: at
    /// their middle.
    #[inline(never)]
    pub(super) fn light_of(&mut self, x: usize, y: usize, mask: u8, work: &mut Work<'_>) -> Lit {
        let (block, first) = (ROW_BLOCKS * y + x / 2, 4 * (x & 1));
        let places = [0, 1, 2, 3].map(|sample| self.samples.at(block, first + sample));
        let (mut middle, mut count) = ((0.0, 0.0), 0.0);
        for (sample, place) in places.iter().enumerate() {
            if mask >> sample & 1 != 0 {
                middle = (middle.0 + place.0, middle.1 + place.1);
                count += 1.0;
            }
        }
        let middle = (middle.0 / count, middle.1 / count);
        let (mut nearest, mut sample) = (f32::INFINITY, 0);
        for (number, place) in places.iter().enumerate() {
            let (dx, dy) = (place.0 - middle.0, place.1 - middle.1);
            if mask >> number & 1 != 0 && dx * dx + dy * dy < nearest {
                (nearest, sample) = (dx * dx + dy * dy, number);
            }
        }
        let lane = first + sample;
        let number = self.seen.number[block % self.seen.number.len()][lane % 8];
        let Some((surface, id)) =
            index(number).and_then(|n| Some((n, *self.surfaces.list().get(n)?)))
        else {
            return Lit::NONE;
        };
        let tracer = &self.renderer.tracer;
        let mut hit = hit_of(&id, self.seen.near[block % self.seen.near.len()][lane % 8]);
        let mut ray = self.picture.ray(middle.0, middle.1);
        match ray.and_then(|ray| tracer.on_spheroid(id.instance, &ray)) {
            // What lies between places on a spheroid is on it.
            Some(t) => hit.on.t = t,
            None => ray = self.picture.ray(places[sample].0, places[sample].1),
        }
        let Some(ray) = ray else {
            return Lit::NONE;
        };
        let unit = self.sizes.unit;
        let (column, row) = (
            self.corner.0 + x as u32 * unit,
            self.corner.1 + y as u32 * unit,
        );
        let seed = Sample::new(column, row, self.pass.0, self.pass.1);
        let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
        let (pixel, apart) = tracer.light_apart(
            self.shade,
            (&ray, hit),
            (self.renderer.most, seed),
            budget,
            workspace,
        );
        let mut sum = Sum::NONE;
        sum.add(pixel, workspace);
        let lit = Lit {
            pixel: sum.mean(1),
            diffuse: apart.diffuse,
        };
        let plain = |pixel: Pixel| Lit {
            pixel,
            diffuse: Vec3::ZERO,
        };
        match apart.coat {
            None => plain(lit.pixel),
            Some(_) if self.coat(surface).texture.is_some() => lit,
            Some((texture, place)) => {
                let scene = self.renderer.tracer.scene();
                plain(lit.coloured(texture::mean(scene, texture, place, [0.0; 2])))
            }
        }
    }

    /// Returns the texture of a surface.
    fn coat(&mut self, surface: usize) -> Coat {
        let place = surface % self.coats.len();
        match self.coats[place].filter(|coat| coat.surface == surface) {
            Some(coat) => coat,
            None => *self.coats[place].insert(self.new_coat(surface)),
        }
    }

    #[inline(never)]
    fn new_coat(&self, surface: usize) -> Coat {
        let none = Coat {
            surface,
            texture: None,
            near: Vec3::ZERO,
            u: Vec3::ZERO,
            v: Vec3::ZERO,
        };
        let id = self.surfaces.list().get(surface);
        let facet = id.and_then(|id| self.renderer.tracer.facet(id));
        let Some((corners, (texture, places))) =
            facet.and_then(|facet| Some((facet.corners, facet.texture?)))
        else {
            return none;
        };
        let [p, q, r] = corners.map(|corner| self.beam.place(corner));
        let weights = [q.cross(r), r.cross(p), p.cross(q)];
        let determinant = weights[0].dot(p);
        if !(determinant.abs() > 0.0) {
            return none;
        }
        let sum = |of: [f32; 3]| {
            (weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2]) / determinant
        };
        Coat {
            texture: Some(texture),
            near: sum([1.0; 3]),
            u: sum(places.map(|place| place[0])),
            v: sum(places.map(|place| place[1])),
            ..none
        }
    }

    /// Returns the mean colour of a surface's texture over a pixel around a place.
    pub(super) fn colour(&mut self, surface: usize, (x, y): (f32, f32)) -> Option<Vec3> {
        let coat = self.coat(surface);
        let texture = coat.texture?;
        let at = |form: Vec3| form.x * x + form.y * y + form.z;
        let near = at(coat.near);
        if !(near.abs() > 0.0) {
            return None;
        }
        let t = 1.0 / near;
        let of = |form: Vec3| {
            let place = at(form) * t;
            let slope = |own: f32, near: f32| ((own - place * near) * t).abs();
            (
                place,
                slope(form.x, coat.near.x) + slope(form.y, coat.near.y),
            )
        };
        let ((u, du), (v, dv)) = (of(coat.u), of(coat.v));
        Some(texture::mean(
            self.renderer.tracer.scene(),
            texture,
            [u, v],
            [du, dv],
        ))
    }
}

/// Returns whether light between four corners may differ from its interpolation, as seen: by √.
fn differ(lit: [&Lit; 4]) -> bool {
    let [a, b, c, d] = lit.map(|lit| {
        let Pixel {
            red, green, blue, ..
        } = lit.pixel;
        [red, green, blue].map(|light| sqrt(max(light, 0.0)))
    });
    (0..3).any(|n| {
        let least = min(min(a[n], b[n]), min(c[n], d[n]));
        let most = max(max(a[n], b[n]), max(c[n], d[n]));
        most - least > MOST_DIFFERENCE || ((a[n] + d[n]) - (b[n] + c[n])).abs() > MOST_BEND
    })
}
