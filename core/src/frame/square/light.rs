//! Light of bent surfaces, and the colours of textures.

use super::{Group, PIXELS, SIDE, Square, hit_of, index};
use crate::frame::begun::{Sum, Work};
use crate::numeric::{max, min, sqrt};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use crate::trace::apart::Open;
use crate::trace::beam::{ROW_BLOCKS, SurfaceId};
use crate::trace::facet::Facet;
use crate::trace::shading::Met;
use crate::trace::surface::Surface;
use crate::trace::{Pixel, Sample, texture};
use glam::Vec3;
use heapless::Vec;

/// Difference of √light between points up to which light between them is interpolated, and how far
/// the fourth of them may be from what the other three say.
const MOST_DIFFERENCE: f32 = 0.2;
const MOST_BEND: f32 = 0.05;

/// Light of a place: with a white texture, and the part that the texture colours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    pub(super) pixel: Pixel,
    pub(super) diffuse: Vec3,
    pub(super) lights: Lights,
}

/// Lights that are known to reach a place, and those that are known not to: a bit for each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lights {
    reaching: u8,
    hidden: u8,
}

impl Lights {
    pub(super) const UNKNOWN: Self = Self {
        reaching: 0,
        hidden: 0,
    };

    const fn is_any(self) -> bool {
        self.reaching | self.hidden != 0
    }

    /// Returns what is known of both.
    const fn and(self, other: Self) -> Self {
        Self {
            reaching: self.reaching & other.reaching,
            hidden: self.hidden & other.hidden,
        }
    }
}

impl Lit {
    pub(super) const NONE: Self = Self {
        pixel: Pixel::NONE,
        diffuse: Vec3::ZERO,
        lights: Lights::UNKNOWN,
    };

    #[inline(always)]
    fn between(&self, other: &Self, share: f32) -> Self {
        Self {
            pixel: self.pixel.zip(other.pixel, |a, b| a + (b - a) * share),
            diffuse: self.diffuse + (other.diffuse - self.diffuse) * share,
            lights: self.lights.and(other.lights),
        }
    }

    pub(super) fn times(self, count: f32) -> Self {
        Self {
            pixel: self.pixel.zip(self.pixel, |light, _| light * count),
            diffuse: self.diffuse * count,
            ..self
        }
    }

    pub(super) fn coloured(&self, colour: Vec3) -> Pixel {
        let more = Pixel::new((colour - Vec3::ONE) * self.diffuse, 0.0);
        self.pixel.zip(more, |light, more| light + more)
    }
}

/// A triangle over the square's picture: the weights of its corners times 1/t by linear functions of
/// column and row, and 1/t, their sum.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chart<'a> {
    surface: usize,
    facet: Facet<'a>,
    weights: [Vec3; 3],
    near: Vec3,
}

/// A part of the square that may be interpolated, and what is known of it.
#[derive(Clone, Copy)]
struct Cell {
    x: u8,
    y: u8,
    step: u8,
    lights: Lights,
}

impl<'a, const W: usize> Square<'_, 'a, W>
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
                lights: Lights::UNKNOWN,
            });
            while let Some(mut cell) = cells.pop() {
                if self.light_cell(&mut cell, work) {
                    continue;
                }
                let (half, lights) = (cell.step / 2, cell.lights);
                for (right, below) in [(0, 0), (half, 0), (0, half), (half, half)] {
                    let (x, y) = (cell.x + right, cell.y + below);
                    if half > 1 {
                        let _ = cells.push(Cell {
                            x,
                            y,
                            step: half,
                            lights,
                        });
                    } else if lights.is_any() {
                        self.light_of_pixel(usize::from(x), usize::from(y), lights, work);
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
    fn light_cell(&mut self, cell: &mut Cell, work: &mut Work<'_>) -> bool {
        let (x, y, step) = (
            usize::from(cell.x),
            usize::from(cell.y),
            usize::from(cell.step),
        );
        if self.fine.cross((x, y), step) {
            cell.lights = Lights::UNKNOWN;
            return false;
        }
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
        let [a, b, c, d] = corners.map(|(x, y)| self.light_of_pixel(x, y, cell.lights, work));
        cell.lights = a.lights.and(b.lights).and(c.lights).and(d.lights);
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
    pub(super) fn light_of_pixel(
        &mut self,
        x: usize,
        y: usize,
        lights: Lights,
        work: &mut Work<'_>,
    ) -> Lit {
        let known = usize::from(self.lit_at[(SIDE * y + x) % PIXELS]).checked_sub(1);
        if let Some(lit) = known.and_then(|known| self.lit.get(known)) {
            return *lit;
        }
        let lit = if self.fine.has(x, y) {
            let [a, b, c, d] =
                [1, 2, 4, 8].map(|mask| self.light_of((x, y), mask, Lights::UNKNOWN, work));
            a.between(&b, 0.5).between(&c.between(&d, 0.5), 0.5)
        } else {
            self.light_of((x, y), 0xf, lights, work)
        };
        self.keep(x, y, lit);
        lit
    }

    /// Returns the light of the part of a pixel in which some samples see one surface or group: at
    /// their middle.
    #[inline(never)]
    pub(super) fn light_of(
        &mut self,
        (x, y): (usize, usize),
        mask: u8,
        lights: Lights,
        work: &mut Work<'_>,
    ) -> Lit {
        let (block, first) = (ROW_BLOCKS * y + x / 2, 4 * (x & 1));
        let (middle, sample) = self.middle(block, first, mask);
        let lane = first + sample;
        let number = self.seen.number[block % self.seen.number.len()][lane % 8];
        let Some((surface, id)) =
            index(number).and_then(|n| Some((n, *self.surfaces.list().get(n)?)))
        else {
            return Lit::NONE;
        };
        let tracer = &self.renderer.tracer;
        let mut hit = hit_of(&id, self.seen.near[block % self.seen.near.len()][lane % 8]);
        let between = self.picture.ray(middle.0, middle.1);
        // What lies between places on one facet, or on a spheroid, is on it.
        let (on_facet, t, is_coated) = match self.chart(surface, &id) {
            Some(chart) if chart.facet.is_plain => {
                (chart.surface(middle), None, chart.facet.texture.is_some())
            }
            Some(chart) => (None, chart.distance(middle), false),
            None => {
                let on_spheroid = |ray: Ray| tracer.on_spheroid(id.instance, &ray);
                (None, between.and_then(on_spheroid), false)
            }
        };
        let (ray, found) = if on_facet.is_some() {
            (between, on_facet)
        } else {
            let ray = if let Some(t) = t {
                hit.on.t = t;
                between
            } else {
                let (x, y) = self.samples.at(block, lane);
                self.picture.ray(x, y)
            };
            (
                ray,
                ray.and_then(|ray| tracer.surface(self.shade, &ray, &hit)),
            )
        };
        let Some((ray, found)) = ray.zip(found) else {
            return Lit::NONE;
        };
        let unit = self.sizes.unit;
        let (column, row) = (
            self.corner.0 + x as u32 * unit,
            self.corner.1 + y as u32 * unit,
        );
        let met = Met {
            ray: &ray,
            surface: found,
            t: hit.on.t,
            detail: self.detail(),
            sample: Sample::new(column, row, self.pass.0, self.pass.1),
        };
        let (mut lit, coat) = self.light_of_surface(&met, lights, work);
        if let Some((texture, at)) = coat.filter(|_| !is_coated) {
            let tracer = &self.renderer.tracer;
            let colour = texture::mean(tracer.scene(), tracer.effects(), texture, at, [0.0; 2]);
            lit.pixel = lit.coloured(colour);
            lit.diffuse = Vec3::ZERO;
        }
        lit
    }

    /// Returns the middle of some samples of a pixel, and the number of the one next to it.
    fn middle(&self, block: usize, first: usize, mask: u8) -> ((f32, f32), usize) {
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
        (middle, sample)
    }

    /// Returns the light of a surface that a ray meets, and the place on its texture, if that is
    /// kept apart.
    fn light_of_surface(
        &self,
        met: &Met<'_, 'a>,
        mut lights: Lights,
        work: &mut Work<'_>,
    ) -> (Lit, Option<(u32, [f32; 2])>) {
        let tracer = &self.renderer.tracer;
        let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
        let (pixel, Open { own, sources, coat }) =
            tracer.light_apart(self.shade, met, budget, workspace);
        let mut sum = Sum::NONE;
        sum.add(pixel, workspace);
        let (mut pixel, mut diffuse) = (sum.mean(1), own.diffuse);
        for (number, source) in sources.iter().enumerate() {
            if source.whole == Vec3::ZERO {
                continue;
            }
            let bit = 1 << number;
            if (lights.reaching | lights.hidden) & bit == 0 {
                if tracer.is_reached(met, number, budget, workspace) {
                    lights.reaching |= bit;
                } else {
                    lights.hidden |= bit;
                }
            }
            if lights.reaching & bit != 0 {
                pixel = pixel.zip(Pixel::new(source.whole, 0.0), |a, b| a + b);
                diffuse += source.diffuse;
            }
        }
        let lit = Lit {
            pixel,
            diffuse: if coat.is_some() { diffuse } else { Vec3::ZERO },
            lights,
        };
        (lit, coat)
    }

    /// Returns a surface over the picture, if it is a triangle.
    fn chart(&mut self, surface: usize, id: &SurfaceId) -> Option<&Chart<'a>> {
        let place = surface % self.charts.len();
        if self.charts[place].is_none_or(|chart| chart.surface != surface) {
            self.charts[place] = self.new_chart(surface, id);
        }
        self.charts[place].as_ref()
    }

    #[inline(never)]
    fn new_chart(&self, surface: usize, id: &SurfaceId) -> Option<Chart<'a>> {
        let facet = self.renderer.tracer.facet(id)?;
        let [p, q, r] = facet.corners.map(|corner| self.beam.place(corner));
        let weights = [q.cross(r), r.cross(p), p.cross(q)];
        let determinant = weights[0].dot(p);
        if !(determinant.abs() > 0.0) {
            return None;
        }
        let weights = weights.map(|weight| weight / determinant);
        Some(Chart {
            surface,
            facet,
            weights,
            near: weights[0] + weights[1] + weights[2],
        })
    }

    /// Returns the mean colour of a surface's texture over a pixel around a place.
    pub(super) fn colour(&mut self, surface: usize, at: (f32, f32)) -> Option<Vec3> {
        let id = *self.surfaces.list().get(surface)?;
        let tracer = &self.renderer.tracer;
        let (scene, effects) = (tracer.scene(), tracer.effects());
        let chart = self.chart(surface, &id)?;
        let (texture, places) = chart.facet.texture?;
        let (place, slope) = chart.place_on_texture(&places, at)?;
        Some(texture::mean(scene, effects, texture, place, slope))
    }
}

impl<'a> Chart<'a> {
    /// Returns the surface at a place of the picture; `None` where it is seen edge-on.
    fn surface(&self, (x, y): (f32, f32)) -> Option<Surface<'a>> {
        let weights = self.weights.map(|form| max(value(form, (x, y)), 0.0));
        let sum = weights[0] + weights[1] + weights[2];
        (sum > 0.0).then(|| self.facet.surface(weights.map(|weight| weight / sum)))
    }

    /// Returns the t of a place of the picture; `None` off the triangle.
    fn distance(&self, at: (f32, f32)) -> Option<f32> {
        let is_on = self.weights.iter().all(|form| value(*form, at) >= 0.0);
        is_on.then(|| 1.0 / value(self.near, at))
    }

    /// Returns the place on the triangle's texture, given by its corners' places, that a place of
    /// the picture sees, and how far it moves over a pixel.
    fn place_on_texture(
        &self,
        places: &[[f32; 2]; 3],
        at: (f32, f32),
    ) -> Option<([f32; 2], [f32; 2])> {
        let near = value(self.near, at);
        if !(near.abs() > 0.0) {
            return None;
        }
        let t = 1.0 / near;
        let of = |axis: usize| {
            let [a, b, c] = places.map(|place| place[axis]);
            let form = self.weights[0] * a + self.weights[1] * b + self.weights[2] * c;
            let place = value(form, at) * t;
            let slope = |own: f32, near: f32| ((own - place * near) * t).abs();
            (
                place,
                slope(form.x, self.near.x) + slope(form.y, self.near.y),
            )
        };
        let ((u, du), (v, dv)) = (of(0), of(1));
        Some(([u, v], [du, dv]))
    }
}

/// Returns the value of a linear function of column and row.
fn value(form: Vec3, (x, y): (f32, f32)) -> f32 {
    form.x * x + form.y * y + form.z
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
