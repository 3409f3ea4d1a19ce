//! Light of planes: at the points of a lattice, apart from shadows, which are drawn.

use super::Square;
use super::light::{Lights, Lit};
use crate::frame::begun::Work;
use crate::numeric::{max, sqrt};
use crate::scene::format::{Light, light};
use crate::simd::{Runs, Simd};
use crate::trace::apart::{MOST_LIGHTS, Open, Part};
use crate::trace::beam::{
    BLOCKS, Drawing, LEAST_HEIGHT, ROW_BLOCKS, SelfShadow, Shadows, SurfaceId,
};
use crate::trace::facet::Facet;
use crate::trace::shading::Met;
use crate::trace::{Pixel, Sample, Steps};
use glam::Vec3;

pub(super) const MOST_PLANES: usize = 4;

/// Least samples of a plane for which shadows are drawn.
pub(super) const LEAST_OF_PLANE: u16 = 48;

/// Most points of the lattice along a side.
const POINTS: usize = 5;

/// A plane that the square sees.
pub(super) struct PlaneLight<'a> {
    pub(super) instance: u32,
    facet: Facet<'a>,
    /// 1/t by a linear function of column and row, and the least at which light is computed:
    /// beyond, the plane ends or is behind the eye.
    near: Vec3,
    least: f32,
    /// Samples in the shadow of each light, a bit for each.
    dark: [[u8; BLOCKS]; MOST_LIGHTS],
    lights: usize,
    points: [[Option<Open>; POINTS]; POINTS],
    /// A row of pixels, and its light in the lattice's columns: of each light, and all together.
    row: usize,
    rows: [[Part; POINTS]; MOST_LIGHTS],
    whole_row: [Part; POINTS],
}

impl<const W: usize> Square<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Returns the plane of a surface that a sample sees; a new one only if asked for. `None` if it
    /// is bent or not dull, or if the scene has lights whose shadows cannot be drawn.
    pub(super) fn plane(
        &mut self,
        id: &SurfaceId,
        sample: u16,
        is_new: bool,
        work: &mut Work<'_>,
    ) -> Option<u8> {
        let tracer = &self.renderer.tracer;
        let lights = tracer.scene().lights();
        if lights.len() > MOST_LIGHTS
            || tracer.has_clear_shadows()
            || lights
                .iter()
                .any(|light| light.is_large() || light.is_spot())
        {
            return None;
        }
        let facet = tracer
            .facet(id)
            .filter(|facet| facet.is_flat() && facet.is_dull)?;
        let (block, lane) = (usize::from(sample / 8), usize::from(sample % 8));
        let near = self.seen.near.get(block)?[lane];
        let (normal, point) = (facet.normal, facet.corners[0]);
        let (x, y) = self.samples.at(block, lane);
        let direction = self.picture.direction(x, y);
        // Lower than what casts a shadow: no facet of a plane casts one on it.
        let most_height = 0.5 * LEAST_HEIGHT * sqrt(direction.dot(direction)) / near;
        let same = |plane: &PlaneLight<'_>| {
            let (own, start) = (plane.facet.normal, plane.facet.corners[0]);
            let height = |corner: &Vec3| (*corner - start).dot(own).abs();
            plane.instance == id.instance
                && core::ptr::eq(plane.facet.material, facet.material)
                && own.dot(normal) > 0.9999
                && facet.corners.iter().all(|p| height(p) < most_height)
        };
        if let Some(known) = self.planes.iter().position(same) {
            return Some(known as u8);
        }
        if !is_new || self.planes.is_full() {
            return None;
        }
        let height = normal.dot(point - self.picture.eye);
        let mut plane = PlaneLight {
            instance: id.instance,
            facet,
            near: Vec3::from_array(
                self.picture
                    .directions
                    .map(|direction| normal.dot(direction) / height),
            ),
            least: 0.25 * near,
            dark: [[0; BLOCKS]; MOST_LIGHTS],
            lights: lights.len(),
            points: [[None; POINTS]; POINTS],
            row: usize::MAX,
            rows: [[Part::default(); POINTS]; MOST_LIGHTS],
            whole_row: [Part::default(); POINTS],
        };
        for (light, dark) in lights.iter().zip(&mut plane.dark) {
            *dark = self.shadows(light, (normal, point), None, work)?;
        }
        self.planes.push(plane).ok()?;
        Some(self.planes.len() as u8 - 1)
    }

    /// Returns the shadows on a plane, a bit for each sample; `None` where they cannot be drawn.
    #[inline(never)]
    pub(super) fn shadows(
        &mut self,
        source: &Light,
        (normal, point): (Vec3, Vec3),
        own: Option<SelfShadow>,
        work: &mut Work<'_>,
    ) -> Option<[u8; BLOCKS]> {
        let mut shadows = Shadows { dark: [0; BLOCKS] };
        let place = Vec3::from_array(source.place);
        let is_directional = source.kind == light::DIRECTIONAL;
        let towards = if is_directional { place } else { place - point };
        if !self.renderer.tracer.casts_shadows()
            || normal.dot(towards) * normal.dot(self.picture.eye - point) <= 0.0
        {
            // It is on the other side.
            return Some(shadows.dark);
        }
        let side = self.sizes.side as f32;
        let beam = self
            .beam
            .shadows((normal, point), (place, is_directional), side)?;
        let tracer = &self.renderer.tracer;
        let drawing = Drawing {
            scene: tracer.scene(),
            simd: tracer.simd(),
            beam: &beam,
            own,
            rung: self.renderer.most.rung,
            samples: &self.samples,
            surfaces: &mut self.surfaces,
            paper: &mut shadows,
            stack: &mut work.workspace.stack,
            most: work.budget.most(),
            work: Steps::default(),
        };
        let steps = tracer.simd().run(drawing);
        work.workspace.account(steps, work.budget);
        Some(shadows.dark)
    }

    /// Returns the light of some samples of a pixel that see a plane, summed up.
    #[inline]
    pub(super) fn light_of_plane(
        &mut self,
        number: u8,
        (x, y): (usize, usize),
        mask: u8,
        work: &mut Work<'_>,
    ) -> Lit {
        let step = self.sizes.plane;
        if self
            .planes
            .get(usize::from(number))
            .is_none_or(|plane| plane.row != y)
        {
            self.light_row(number, y, work);
        }
        let Some(plane) = self.planes.get(usize::from(number)) else {
            return Lit::NONE;
        };
        let column = x / step;
        let share = ((x % step) as f32 + 0.5) / step as f32;
        let at =
            |of: &[Part; POINTS]| of[column % POINTS].between(&of[(column + 1) % POINTS], share);
        let count = mask.count_ones() as f32;
        let Part {
            mut whole,
            mut diffuse,
        } = at(&plane.whole_row).times(count);
        for (dark, row) in plane.dark.iter().zip(&plane.rows).take(plane.lights) {
            let dark = mask & dark[(ROW_BLOCKS * y + x / 2) % BLOCKS] >> (4 * (x & 1));
            if dark != 0 {
                let less = at(row).times(dark.count_ones() as f32);
                (whole, diffuse) = (whole - less.whole, diffuse - less.diffuse);
            }
        }
        Lit {
            pixel: Pixel::new(whole.max(Vec3::ZERO), count),
            diffuse: diffuse.max(Vec3::ZERO),
            lights: Lights::UNKNOWN,
        }
    }

    /// Interpolates a plane's light for a row of pixels, down the lattice's columns.
    #[inline(never)]
    fn light_row(&mut self, number: u8, y: usize, work: &mut Work<'_>) {
        let step = self.sizes.plane;
        let points = self.sizes.side / step + 1;
        let row = y / step;
        for column in 0..points {
            self.light_point(number, (column, row), work);
            self.light_point(number, (column, row + 1), work);
        }
        let Some(plane) = self.planes.get_mut(usize::from(number)) else {
            return;
        };
        plane.row = y;
        let share = ((y % step) as f32 + 0.5) / step as f32;
        for column in 0..points.min(POINTS) {
            let [Some(a), Some(b)] =
                [row, row + 1].map(|row| plane.points[row % POINTS][column].as_ref())
            else {
                continue;
            };
            let mut whole = a.own.between(&b.own, share);
            for (light, row) in plane.rows.iter_mut().enumerate().take(plane.lights) {
                row[column] = a.sources[light].between(&b.sources[light], share);
                whole = whole.and(&row[column]);
            }
            plane.whole_row[column] = whole;
        }
    }

    /// Computes the light of a point of a plane's lattice, once.
    fn light_point(&mut self, number: u8, (column, row): (usize, usize), work: &mut Work<'_>) {
        let (column, row) = (column % POINTS, row % POINTS);
        let Some(plane) = self
            .planes
            .get(usize::from(number))
            .filter(|plane| plane.points[row][column].is_none())
        else {
            return;
        };
        let (x, y) = (
            (column * self.sizes.plane) as f32,
            (row * self.sizes.plane) as f32,
        );
        let near = max(
            plane.near.x * x + plane.near.y * y + plane.near.z,
            plane.least,
        );
        let Some(ray) = self.picture.ray(x, y) else {
            return;
        };
        let met = Met {
            ray: &ray,
            surface: plane.facet.at(ray.at(1.0 / near)),
            t: 1.0 / near,
            detail: self.detail(),
            sample: Sample::ALONE,
        };
        let tracer = &self.renderer.tracer;
        let (_, open) = tracer.light_apart(self.shade, &met, work.budget, work.workspace);
        if let Some(plane) = self.planes.get_mut(usize::from(number)) {
            plane.points[row][column] = Some(open);
        }
    }
}
