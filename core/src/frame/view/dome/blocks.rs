//! Blocks of a dome's pixels, and the directions of pixels.

use super::{Dome, DomeProjection};
use crate::frame::tile::BLOCK;
use crate::frame::view::{Directions, OnePoint};
use crate::numeric::{map3, max, min};
use crate::simd::{Kernel, Lanes, Portable, Runs, Simd};
use glam::Vec3;

impl Dome {
    /// Returns whether all rays of the block with first pixel (x, y) start at one point.
    pub(crate) fn sees_all_from(&self, x: u32, y: u32) -> bool {
        if let DomeProjection::Mirror(_) = self.projection {
            return false;
        }
        // If the block's corners are inside the circle, so are all its places.
        let (left, above) = (x as f32 - 0.5, y as f32 - 0.5);
        let (right, below) = (left + BLOCK as f32, above + BLOCK as f32);
        let [.., distances] = self.place(
            Portable,
            [left, right, left, right],
            [above, above, below, below],
        );
        distances.into_iter().all(|distance| distance <= 1.0)
    }

    pub(in crate::frame::view) const fn is_from_one_point(&self) -> bool {
        !matches!(self.projection, DomeProjection::Mirror(_))
    }

    /// Returns whether the whole block with first pixel (x, y) is outside the rim.
    pub(crate) fn sees_nothing_from(&self, x: u32, y: u32) -> bool {
        // Tests the place nearest to the centre: rounding keeps the order of distances.
        let centre = (self.side() - 1.0) / 2.0;
        let nearest = |first: u32| {
            let low = first as f32 - 0.5;
            max(low, min(centre, low + BLOCK as f32))
        };
        let [.., [distance]] = self.place(Portable, [nearest(x)], [nearest(y)]);
        distance > self.seen_to
    }
}

/// A dome whose rays all start at one point, for blocks inside its rim.
impl OnePoint for Dome {
    /// In pixels from the centre of the first.
    type Columns<F: Copy> = F;

    fn eye(&self) -> Vec3 {
        self.pose.position
    }

    fn towards(&self, x: f32, y: f32) -> Vec3 {
        let [[x], [y], [z]] = self.rays_of_one(x, y).direction;
        Vec3::new(x, y, z)
    }

    #[inline(always)]
    fn columns_at<L: Lanes<8>>(&self, l: L, x: u32, dx: f32) -> L::F {
        let mut columns = [0.0; 8];
        for (column, place) in (x..).zip(&mut columns) {
            *place = column as f32 + dx;
        }
        l.load(&columns)
    }

    #[inline(always)]
    fn towards_row<L: Lanes<8>>(&self, l: L, columns: &L::F, y: u32, dy: f32) -> [L::F; 3] {
        self.rays(l, *columns, l.splat(y as f32 + dy)).direction
    }

    fn corners(
        &self,
        simd: Simd,
        first: (u32, u32),
        _: (u32, u32),
        offset: (f32, f32),
    ) -> [Vec3; 4] {
        let [least, most] = <Simd as Runs<8>>::run(simd, Extremes(self, first, offset));
        [least, most, least, most]
    }
}

/// Computes the least and the greatest components of a whole block's directions.
struct Extremes<'r>(&'r Dome, (u32, u32), (f32, f32));

impl Kernel<8> for Extremes<'_> {
    type Output = [Vec3; 2];

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> [Vec3; 2] {
        let Self(dome, (x, y), offset) = self;
        let columns = dome.columns_at(l, x, offset.0);
        let mut extremes = [(l.splat(f32::INFINITY), l.splat(f32::NEG_INFINITY)); 3];
        for row in y..y + BLOCK {
            let directions = dome.towards_row(l, &columns, row, offset.1);
            for (extremes, component) in extremes.iter_mut().zip(directions) {
                let (least, most) = *extremes;
                *extremes = (l.min(component, least), l.max(component, most));
            }
        }
        let least = map3(extremes, |(least, _)| {
            l.store(least).into_iter().fold(f32::INFINITY, min)
        });
        let most = map3(extremes, |(_, most)| {
            l.store(most).into_iter().fold(f32::NEG_INFINITY, max)
        });
        [Vec3::from_array(least), Vec3::from_array(most)]
    }
}

impl Directions for Dome {
    #[inline(always)]
    fn directions<L: Lanes<8>>(&self, l: L, (x, y): (u32, u32)) -> [L::F; 3] {
        let [last, lowest] = self.last.map(u32::from);
        let mut columns = [0.0; 8];
        for (column, place) in (x..).zip(&mut columns) {
            *place = column.min(last) as f32;
        }
        let (x, y) = (l.load(&columns), l.splat(y.min(lowest) as f32));
        self.nearest_directions(l, x, y)
    }

    fn direction(&self, (x, y): (u32, u32)) -> Vec3 {
        let [last, lowest] = self.last.map(u32::from);
        let (x, y) = ([x.min(last) as f32], [y.min(lowest) as f32]);
        let [[x], [y], [z]] = self.nearest_directions(Portable, x, y);
        Vec3::new(x, y, z)
    }
}
