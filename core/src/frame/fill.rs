//! Fills the pixels that the gaze skips.

use super::detail::{BLEND, BlockLevels, PATCH, region_of};
use super::tile::BLOCK;
use super::view::{Directions, Kind, View};
use super::{DomeError, DomePose, DomeProjection, MirrorCamera, Renderer, Tile, TileError};
use crate::gaze::Region;
use crate::numeric::{arctangent, max, min, sqrt};
use crate::simd::{Kernel, Lanes, Runs, Simd, dot};
use crate::trace::Pixel;
use core::f32::consts::FRAC_2_PI;
use glam::Vec3;

/// The source of skipped pixels.
#[derive(Debug, Clone, Copy)]
pub enum Fill<'p> {
    /// A capture: the pixel in the same direction from its place.
    Surroundings(Surroundings<'p>),
    /// The tile's pixels, in rows, from elsewhere, such as the frame before.
    Pixels(&'p [Pixel]),
}

/// The surroundings of a place, captured in two dome masters: one of the half that its
/// pose looks at, one of the half behind.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'p> {
    hemispheres: [&'p [Pixel]; 2],
    side: u32,
    /// The first dome master's axes in the room.
    axes: [Vec3; 3],
}

/// Why two pictures cannot be surroundings.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SurroundingsError {
    /// The pose or the size of the dome masters is not valid.
    #[error(transparent)]
    Dome(#[from] DomeError),
    /// The number of pixels is not that of a picture.
    #[error("a hemisphere has {needed} pixels, {given} were given")]
    Pixels { needed: usize, given: usize },
}

impl<'p> Surroundings<'p> {
    /// The captures' mirror: metres. Small enough for all that is around to be far away, large
    /// enough for f32 to place its points.
    pub const MIRROR_RADIUS: f32 = 1.0e-4;

    /// Returns the two dome masters to render, of `side`² pixels each: through the best
    /// mirror, in its exact mapping. Pixels next to the rim's outside show what is
    /// at the rim, so that all four around a place show something.
    ///
    /// # Errors
    /// A pose or a size that cannot be.
    pub fn views(pose: DomePose, side: u32) -> Result<[View; 2], DomeError> {
        let camera = MirrorCamera::best(Self::MIRROR_RADIUS);
        let mut behind = pose;
        let axes = &mut behind.room_from_capture;
        (axes.x_axis, axes.z_axis) = (-axes.x_axis, -axes.z_axis);
        let view = |pose| View::surroundings(DomeProjection::Mirror(camera), pose, side);
        Ok([view(pose)?, view(behind)?])
    }

    /// Surroundings from the rendered pixels of [`views`](Self::views), in rows from the top.
    ///
    /// # Errors
    /// A pose or a size that cannot be; pictures of another size.
    pub fn new(
        pose: DomePose,
        side: u32,
        hemispheres: [&'p [Pixel]; 2],
    ) -> Result<Self, SurroundingsError> {
        Self::views(pose, side)?;
        let needed = side as usize * side as usize;
        for hemisphere in hemispheres {
            if hemisphere.len() != needed {
                return Err(SurroundingsError::Pixels {
                    needed,
                    given: hemisphere.len(),
                });
            }
        }
        let axes = pose.room_from_capture;
        Ok(Self {
            hemispheres,
            side,
            axes: [axes.x_axis, axes.y_axis, axes.z_axis],
        })
    }

    /// Returns what is seen at a place: four pixels interpolated, blended into the other at the
    /// rim.
    #[inline]
    fn at(&self, place: Place) -> Pixel {
        let own = self.inside(place);
        if place.near_rim {
            self.across_rim(place, own)
        } else {
            own
        }
    }

    /// Interpolates the four pixels around a place.
    #[inline]
    fn inside(&self, place: Place) -> Pixel {
        let last = self.side - 1;
        let within = |at: f32| max(min(at, last as f32), 0.0);
        let (x, y) = (within(place.x), within(place.y));
        let (column, row) = (x as u32, y as u32);
        let (right, below) = (x - column as f32, y - row as f32);
        let index = row as usize * self.side as usize + column as usize;
        let next = usize::from(column < last);
        let pixels = self.hemisphere(place);
        let above = pixels.get(index..).unwrap_or_default();
        let under = if row < last {
            above.get(self.side as usize..).unwrap_or_default()
        } else {
            above
        };
        let at = |row: &[Pixel], number: usize| row.get(number).copied().unwrap_or_default();
        mixed(
            mixed(at(above, 0), at(above, next), right),
            mixed(at(under, 0), at(under, next), right),
            below,
        )
    }

    #[inline(never)]
    fn across_rim(&self, place: Place, own: Pixel) -> Pixel {
        let side = self.side as f32;
        let last = side - 1.0;
        // From the centre, in halves of the side.
        let (u, v) = ((2.0 * place.x - last) / side, (last - 2.0 * place.y) / side);
        let radius = sqrt(u * u + v * v);
        let pixels_inside = max(0.5 * side * (1.0 - radius), 0.0);
        if !(pixels_inside < 1.0 && radius > 0.0) {
            return own;
        }
        let other = Place {
            x: 0.5 * (last - u / radius * side),
            y: 0.5 * (last - v / radius * side),
            behind: !place.behind,
            near_rim: false,
        };
        mixed(own, self.inside(other), 0.5 * (1.0 - pixels_inside))
    }

    fn hemisphere(&self, place: Place) -> &'p [Pixel] {
        let [ahead, behind] = self.hemispheres;
        if place.behind { behind } else { ahead }
    }
}

/// A place in one of the hemispheres.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Pixels from the centre of the first.
    x: f32,
    y: f32,
    behind: bool,
    /// Within three halves of a pixel of the rim.
    near_rim: bool,
}

/// Blends from `none` (share 0) to `all` (share 1).
#[inline(always)]
fn mixed(none: Pixel, all: Pixel, share: f32) -> Pixel {
    none.zip(all, |none, all| none * (1.0 - share) + all * share)
}

/// Share of a pixel's own colour at a level: smooth from 0 to 1.
fn own_share(level: f32) -> f32 {
    if level >= BLEND {
        return 1.0;
    }
    let share = level / BLEND;
    share * share * (3.0 - 2.0 * share)
}

impl<const W: usize> Renderer<'_, W>
where
    Simd: Runs<W>,
{
    /// Fills the pixels of a finished tile that the gaze skipped, and blends those that it nearly
    /// did: none without level of detail. It takes no steps. Each pixel depends on itself, its
    /// place in the view and the fill only.
    ///
    /// # Errors
    /// A tile that is not inside the view; `pixels` or the fill's of another number than the tile
    /// has.
    pub fn fill(
        &self,
        view: &View,
        tile: Tile,
        fill: &Fill<'_>,
        pixels: &mut [Pixel],
    ) -> Result<(), TileError> {
        tile.check(view.size(), pixels.len())?;
        if let Fill::Pixels(with) = fill {
            tile.check(view.size(), with.len())?;
        }
        let Some(lod) = &self.lod else {
            return Ok(());
        };
        let own = |region: Region| match region {
            Region::Central => Some(true),
            Region::Outside => Some(false),
            Region::Traced(part) => (lod.gaze.levels_within(&part).0 >= BLEND).then_some(true),
            Region::Mixed => None,
        };
        let simd = self.tracer.simd();
        for part in tile.blocks() {
            let place = (part.x, part.y);
            let known = own(region_of(lod, view, place, PATCH))
                .or_else(|| own(region_of(lod, view, place, BLOCK)));
            let levels = match known {
                Some(true) => continue,
                Some(false) => BlockLevels::OUTSIDE,
                None => BlockLevels::new(lod, simd, view, place),
            };
            if levels.reaches_the_border() {
                fill.apply(simd, view, (tile, part), &levels, pixels);
            }
        }
        Ok(())
    }
}

impl Fill<'_> {
    /// Fills the part of a block that lies in a tile.
    fn apply(
        &self,
        simd: Simd,
        view: &View,
        (tile, block): (Tile, Tile),
        levels: &BlockLevels,
        pixels: &mut [Pixel],
    ) {
        for row in block.y..block.y + block.height {
            let places = match self {
                Fill::Surroundings(surroundings) => {
                    Some(surroundings.places(simd, view, row, block.x))
                }
                Fill::Pixels(_) => None,
            };
            for column in block.x..block.x + block.width {
                let level = levels.at(column % BLOCK, row % BLOCK);
                if level >= BLEND || !view.has(column, row) {
                    continue;
                }
                let index = tile.index(column, row);
                let filled = match (self, &places) {
                    (Fill::Surroundings(surroundings), Some(places)) => {
                        surroundings.at(places.at((column - block.x) as usize))
                    }
                    (Fill::Pixels(pixels), _) => pixels.get(index).copied().unwrap_or_default(),
                    (Fill::Surroundings(_), None) => continue,
                };
                if let Some(pixel) = pixels.get_mut(index) {
                    *pixel = if level > 0.0 {
                        mixed(filled, *pixel, own_share(level))
                    } else {
                        filled
                    };
                }
            }
        }
    }
}

struct Places {
    x: [f32; 8],
    y: [f32; 8],
    /// A bit for each.
    behind: u32,
    near_rim: u32,
}

impl Places {
    fn at(&self, lane: usize) -> Place {
        let lane = lane % 8;
        Place {
            x: self.x[lane],
            y: self.y[lane],
            behind: self.behind >> lane & 1 != 0,
            near_rim: self.near_rim >> lane & 1 != 0,
        }
    }
}

impl Surroundings<'_> {
    /// Returns the places in the hemispheres of eight pixels of a view's row, from `x` on.
    fn places(&self, simd: Simd, view: &View, y: u32, x: u32) -> Places {
        let place = (x, y);
        match view.kind() {
            Kind::Screen(view) => <Simd as Runs<8>>::run(simd, Find(self, view, place)),
            Kind::Dome(view) => <Simd as Runs<8>>::run(simd, Find(self, view, place)),
        }
    }
}

struct Find<'r, V>(&'r Surroundings<'r>, &'r V, (u32, u32));

impl<V: Directions> Kernel<8> for Find<'_, V> {
    type Output = Places;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Places {
        let Self(surroundings, view, place) = self;
        let direction = view.directions(l, place);
        let [right, top, back] = surroundings.axes;
        let right = dot(l, right, direction);
        let top = dot(l, top, direction);
        let back = dot(l, back, direction);
        let aside = l.sqrt(l.add(l.mul(right, right), l.mul(top, top)));
        let angle = arctangent(l, aside, l.abs(back));
        // The distance from the centre is the angle: equation 1.
        let radius = l.mul(angle, l.splat(FRAC_2_PI));
        let share = l.div(radius, l.max(aside, l.splat(f32::MIN_POSITIVE)));
        let ahead = l.le(back, l.splat(0.0));
        let outwards = l.mul(right, share);
        let u = l.select(ahead, outwards, l.sub(l.splat(0.0), outwards));
        let v = l.mul(top, share);
        let side = surroundings.side as f32;
        let near_rim = l.splat(1.0 - 3.0 / side);
        let (side, last) = (l.splat(side), l.splat(side - 1.0));
        let half = l.splat(0.5);
        Places {
            x: l.store(l.mul(half, l.add(l.mul(u, side), last))),
            y: l.store(l.mul(half, l.sub(last, l.mul(v, side)))),
            behind: !l.bits(ahead) & 0xff,
            near_rim: !l.bits(l.le(radius, near_rim)) & 0xff,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    const POSE: DomePose = DomePose::over_room(Vec3::ZERO);

    #[test]
    fn pictures_of_another_size_are_refused() {
        let pixels = [Pixel::default(); 16];
        let new = |side, behind| Surroundings::new(POSE, side, [&pixels, behind]).unwrap_err();
        assert_eq!(
            new(4, &pixels[..15]),
            SurroundingsError::Pixels {
                needed: 16,
                given: 15
            }
        );
        assert!(matches!(new(0, &pixels), SurroundingsError::Dome(_)));
    }

    #[test]
    fn places_next_to_a_pole_are_inside_pictures_of_a_single_pixel() {
        let opaque = Pixel::new(Vec3::ZERO, 1.0);
        let pixels = [opaque; 9];
        for side in 1..=3 {
            let pixels = &pixels[..(side * side) as usize];
            let surroundings = Surroundings::new(POSE, side, [pixels, pixels]).unwrap();
            for tiny in [0.0, 1.0e-45, 1.0e-30, 1.0e-10] {
                for right in [tiny, -tiny] {
                    let eye = Vec3::ZERO;
                    let first = Vec3::new(right, 1.0, tiny);
                    let view = View::new(eye, first, Vec3::X, Vec3::Z, [8, 1]).unwrap();
                    let places = surroundings.places(Simd::PORTABLE, &view, 0, 0);
                    assert_eq!(surroundings.at(places.at(0)), opaque);
                }
            }
        }
    }
}
