//! What shows where the gaze skips rays.

use super::block::BLOCK;
use super::detail::{BlockLevels, PATCH, region_of};
use super::view::{Directions, Kind, View};
use super::{DomeError, DomePose, DomeProjection, MirrorCamera, Part, Renderer, Tile, TileError};
use crate::capture::{Mapping, SpheroidMirror};
use crate::gaze::Region;
use crate::numeric::{arctangent, sqrt};
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::Pixel;
use core::f32::consts::FRAC_2_PI;
use core::fmt;
use glam::Vec3;

/// The level from which on a traced pixel is only itself; below, towards the
/// border of the visual field, it goes over into what fills the rest.
pub const BLEND: f32 = 0.1;

/// What to fill skipped pixels with.
#[derive(Debug, Clone, Copy)]
pub enum Fill<'p> {
    /// What is seen in their direction from the place of a capture.
    Surroundings(Surroundings<'p>),
    /// As many pixels as the tile has, in its rows, such as those of the frame
    /// before.
    Pixels(&'p [Pixel]),
}

/// All that is around a place, captured in two dome masters: one of the side
/// that its pose looks at, one of what is behind.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'p> {
    hemispheres: [&'p [Pixel]; 2],
    side: u32,
    /// The first dome master's axes in the room.
    axes: [Vec3; 3],
}

/// Why two pictures are no surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum SurroundingsError {
    /// There are no such dome masters.
    Dome(DomeError),
    /// Not as many pixels as a picture has.
    Pixels {
        /// How many it has.
        needed: usize,
        /// How many were given.
        given: usize,
    },
}

impl fmt::Display for SurroundingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dome(error) => error.fmt(f),
            Self::Pixels { needed, given } => {
                write!(f, "a hemisphere has {needed} pixels, {given} were given")
            }
        }
    }
}

impl core::error::Error for SurroundingsError {}

impl From<DomeError> for SurroundingsError {
    fn from(error: DomeError) -> Self {
        Self::Dome(error)
    }
}

impl<'p> Surroundings<'p> {
    /// The captures' mirror: metres. Small enough for all that anybody stands
    /// before to be far away, large enough for f32 to place its points.
    pub const MIRROR_RADIUS: f32 = 1.0e-4;

    /// The two dome masters to render, of `side`² pixels each: through the best
    /// mirror, in its exact mapping.
    ///
    /// # Errors
    /// A pose or a size that cannot be.
    pub fn views(pose: DomePose, side: u32) -> Result<[View; 2], DomeError> {
        let mirror = SpheroidMirror::BEST;
        let camera = MirrorCamera {
            mirror,
            mapping: Mapping::Exact,
            radius: Self::MIRROR_RADIUS,
            viewpoint: mirror.screen_distance(),
            mirrored: false,
        };
        let mut behind = pose;
        let axes = &mut behind.room_from_capture;
        (axes.x_axis, axes.z_axis) = (-axes.x_axis, -axes.z_axis);
        let view = |pose| View::dome(DomeProjection::Mirror(camera), pose, side);
        Ok([view(pose)?, view(behind)?])
    }

    /// Of the pixels of [`views`](Self::views), in rows from the top.
    ///
    /// # Errors
    /// As there; pictures of another size.
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

    /// What is seen along a direction, of any length that can be traced:
    /// between pixels as the four around it say, across the rim as both
    /// hemispheres do.
    fn at(&self, place: Place) -> Pixel {
        let side = self.side as f32;
        let mut sum = Sum::NONE;
        self.add(&mut sum, place);
        // From the pixel to the centre, in halves of the side.
        let last = side - 1.0;
        let (u, v) = ((2.0 * place.x - last) / side, (last - 2.0 * place.y) / side);
        let radius = sqrt(u * u + v * v);
        if radius > 1.0 - 3.0 / side {
            let beyond = (2.0 - radius) / radius;
            let (u, v) = (-u * beyond, v * beyond);
            let other = Place {
                x: 0.5 * (u * side + last),
                y: 0.5 * (last - v * side),
                behind: !place.behind,
            };
            self.add(&mut sum, other);
        }
        sum.mean()
    }

    /// The four pixels around a place, as far as they are inside the rim.
    fn add(&self, sum: &mut Sum, place: Place) {
        let [ahead, behind] = self.hemispheres;
        let pixels = if place.behind { behind } else { ahead };
        // Past the border there is nothing inside the rim.
        let (left, top) = (place.x + 1.0, place.y + 1.0);
        let (column, row) = (left as u32, top as u32);
        let (right, below) = (left - column as f32, top - row as f32);
        for (column, row, weight) in [
            (column, row, (1.0 - right) * (1.0 - below)),
            (column + 1, row, right * (1.0 - below)),
            (column, row + 1, (1.0 - right) * below),
            (column + 1, row + 1, right * below),
        ] {
            // Counted from 1: 0 and the side's next are past the border.
            let (column, row) = (column.wrapping_sub(1), row.wrapping_sub(1));
            if self.is_inside(column, row) {
                let index = row as usize * self.side as usize + column as usize;
                if let Some(pixel) = pixels.get(index) {
                    sum.add(*pixel, weight);
                }
            }
        }
    }

    /// Whether the centre of a pixel is inside the rim, by more than rounding.
    fn is_inside(&self, column: u32, row: u32) -> bool {
        if column >= self.side || row >= self.side {
            return false;
        }
        let side = u64::from(self.side);
        let from_centre = |at: u32| (2 * u64::from(at) + 1).abs_diff(side);
        let (x, y) = (from_centre(column), from_centre(row));
        // All of one pixel, and of two.
        side <= 2 || x * x + y * y + side <= side * side
    }
}

/// A place in one of the hemispheres.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Pixels from the centre of the first.
    x: f32,
    y: f32,
    behind: bool,
}

/// Pixels and their weights.
struct Sum {
    pixel: Pixel,
    weight: f32,
}

impl Sum {
    const NONE: Self = Self {
        pixel: Pixel {
            red: 0.0,
            green: 0.0,
            blue: 0.0,
            alpha: 0.0,
        },
        weight: 0.0,
    };

    fn add(&mut self, pixel: Pixel, weight: f32) {
        self.pixel.red += pixel.red * weight;
        self.pixel.green += pixel.green * weight;
        self.pixel.blue += pixel.blue * weight;
        self.pixel.alpha += pixel.alpha * weight;
        self.weight += weight;
    }

    /// Nothing where there is no weight.
    fn mean(self) -> Pixel {
        if !(self.weight > 0.0) {
            return Pixel::default();
        }
        mixed(Pixel::default(), self.pixel, 1.0 / self.weight)
    }
}

/// From `none` at 0 to `all` at 1.
fn mixed(none: Pixel, all: Pixel, share: f32) -> Pixel {
    let mix = |none: f32, all: f32| none * (1.0 - share) + all * share;
    Pixel {
        red: mix(none.red, all.red),
        green: mix(none.green, all.green),
        blue: mix(none.blue, all.blue),
        alpha: mix(none.alpha, all.alpha),
    }
}

/// How much of a pixel of some level is its own: smooth from 0 to 1.
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
    /// Fills the pixels of a finished tile that the gaze skipped, and blends
    /// those that it nearly did. Without level of detail there are none.
    ///
    /// It traces nothing and takes no steps. Each pixel depends on itself, its
    /// place in the view and the fill only.
    ///
    /// # Errors
    /// A tile that is not inside the view; `pixels` or the fill's of another
    /// number than the tile has.
    pub fn fill(
        &self,
        view: &View,
        tile: Tile,
        fill: &Fill<'_>,
        pixels: &mut [Pixel],
    ) -> Result<(), TileError> {
        tile.check(view, pixels.len())?;
        if let Fill::Pixels(with) = fill {
            tile.check(view, with.len())?;
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
        for part in tile.parts() {
            let place = (part.x, part.y);
            let known = own(region_of(lod, view, place, PATCH))
                .or_else(|| own(region_of(lod, view, place, BLOCK)));
            let levels = match known {
                Some(true) => continue,
                Some(false) => BlockLevels::OUTSIDE,
                None => BlockLevels::new(lod, simd, view, place),
            };
            if levels.reaches_the_border() {
                part.fill(simd, view, tile, fill, &levels, pixels);
            }
        }
        Ok(())
    }
}

impl Part {
    fn fill(
        &self,
        simd: Simd,
        view: &View,
        tile: Tile,
        fill: &Fill<'_>,
        levels: &BlockLevels,
        pixels: &mut [Pixel],
    ) {
        for row in self.y..self.y + self.rows {
            let places = match fill {
                Fill::Surroundings(surroundings) => {
                    Some(surroundings.places(simd, view, row, self.x))
                }
                Fill::Pixels(_) => None,
            };
            for column in self.x..self.x + self.columns {
                let level = levels.at(column % BLOCK, row % BLOCK);
                if level >= BLEND || !view.has(column, row) {
                    continue;
                }
                let index = tile.index(column, row);
                let filled = match (fill, &places) {
                    (Fill::Surroundings(surroundings), Some(places)) => {
                        surroundings.at(places.at((column - self.x) as usize))
                    }
                    (Fill::Pixels(pixels), _) => pixels.get(index).copied().unwrap_or_default(),
                    (Fill::Surroundings(_), None) => continue,
                };
                if let Some(pixel) = pixels.get_mut(index) {
                    *pixel = mixed(filled, *pixel, own_share(level));
                }
            }
        }
    }
}

/// Places of eight pixels.
struct Places {
    x: [f32; 8],
    y: [f32; 8],
    /// A bit for each.
    behind: u32,
}

impl Places {
    fn at(&self, lane: usize) -> Place {
        let lane = lane % 8;
        Place {
            x: self.x[lane],
            y: self.y[lane],
            behind: self.behind >> lane & 1 != 0,
        }
    }
}

impl Surroundings<'_> {
    /// Of eight pixels of a view's row, from `x` on.
    fn places(&self, simd: Simd, view: &View, y: u32, x: u32) -> Places {
        let (axes, side) = (self.axes, self.side as f32);
        let place = (x, y);
        match view.kind() {
            Kind::Screen(view) => <Simd as Runs<8>>::run(
                simd,
                Find {
                    axes,
                    side,
                    view,
                    place,
                },
            ),
            Kind::Dome(view) => <Simd as Runs<8>>::run(
                simd,
                Find {
                    axes,
                    side,
                    view,
                    place,
                },
            ),
        }
    }
}

struct Find<'r, V> {
    axes: [Vec3; 3],
    side: f32,
    view: &'r V,
    place: (u32, u32),
}

impl<V: Directions> Kernel<8> for Find<'_, V> {
    type Output = Places;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Places {
        let direction = self.view.directions(l, self.place);
        let [right, top, back] = self.axes;
        let right = along(l, right, direction);
        let top = along(l, top, direction);
        let back = along(l, back, direction);
        let aside = l.sqrt(l.add(l.mul(right, right), l.mul(top, top)));
        let angle = arctangent(l, aside, l.abs(back));
        // The distance from the centre is the angle: equation 1.
        let radius = l.mul(angle, l.splat(FRAC_2_PI));
        let share = l.div(radius, l.max(aside, l.splat(f32::MIN_POSITIVE)));
        let ahead = l.le(back, l.splat(0.0));
        let outwards = l.mul(right, share);
        let u = l.select(ahead, outwards, l.sub(l.splat(0.0), outwards));
        let v = l.mul(top, share);
        let (side, last) = (l.splat(self.side), l.splat(self.side - 1.0));
        let half = l.splat(0.5);
        Places {
            x: l.store(l.mul(half, l.add(l.mul(u, side), last))),
            y: l.store(l.mul(half, l.sub(last, l.mul(v, side)))),
            behind: !l.bits(ahead) & 0xff,
        }
    }
}

#[inline(always)]
fn along<L: Lanes<8>>(l: L, axis: Vec3, [x, y, z]: [L::F; 3]) -> L::F {
    let x = l.mul(l.splat(axis.x), x);
    let y = l.mul(l.splat(axis.y), y);
    let z = l.mul(l.splat(axis.z), z);
    l.add(l.add(x, y), z)
}
