//! Where a picture's rays start and where they go.

#[cfg(feature = "projectors")]
mod beam;
mod cylinder_screen;
mod dome;
mod dome_screen;
mod flat_screen;
mod screen;

#[cfg(feature = "projectors")]
pub use beam::Beam;
pub use cylinder_screen::CylinderScreen;
pub(super) use dome::{Dome, RayRow};
pub use dome::{DomeError, DomePose, DomeProjection, MirrorCamera};
pub use dome_screen::DomeScreen;
pub use flat_screen::FlatScreen;
pub(super) use screen::Screen;
pub use screen::ViewError;

use crate::numeric::sqrt;
use crate::shape::Ray;
use crate::simd::{Lanes, Simd};
use crate::trace::{Sample, Width};
use glam::Vec3;

/// The rays of a picture: from an eye through the pixels of a flat screen or of a
/// dome's or a cylinder's inside, or those of a dome master.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View(Kind);

/// The kinds of views, chosen once a block so that neither pays for the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Screen(Screen),
    Dome(Dome),
}

impl View {
    /// Most pixels a side: their numbers are exact in f32.
    pub const MOST_PIXELS: u32 = Sample::MOST_PIXELS;

    /// Returns the rays of a flat screen: an off-axis frustum (Kooima 2008). The ray through the
    /// centre of pixel (x, y) starts at `eye` (metres, in the room) along `first_pixel +
    /// x·column_step + y·row_step` (of any unit).
    ///
    /// # Errors
    /// Sizes, an eye or a screen that cannot be.
    pub fn new(
        eye: Vec3,
        first_pixel: Vec3,
        column_step: Vec3,
        row_step: Vec3,
        size: [u32; 2],
    ) -> Result<Self, ViewError> {
        Screen::new(eye, first_pixel, column_step, row_step, size).map(|s| Self(Kind::Screen(s)))
    }

    /// Returns the rays of a dome master of `size`² pixels in the axes of
    /// [`capture`](crate::capture), its rim touching the picture's sides. Outside the rim it is
    /// transparent and costs no ray.
    ///
    /// # Errors
    /// A size, a pose or a projection that cannot be.
    pub fn dome(projection: DomeProjection, pose: DomePose, size: u32) -> Result<Self, DomeError> {
        Dome::new(projection, pose, size).map(|dome| Self(Kind::Dome(dome)))
    }

    /// Returns the view of [`dome`](Self::dome), with the rim shown in the pixels next to its outside.
    pub(super) fn surroundings(
        projection: DomeProjection,
        pose: DomePose,
        size: u32,
    ) -> Result<Self, DomeError> {
        Dome::new(projection, pose, size).map(|dome| Self(Kind::Dome(dome.past_the_rim())))
    }

    /// Returns the rays from `eye` (metres, in the room) through the pixels of a dome screen: the
    /// dome master of `size`² pixels for an eye that need not be at the centre. Outside the rim it
    /// is transparent and costs no ray.
    ///
    /// # Errors
    /// A size, a screen or an eye that cannot be.
    pub fn dome_screen(screen: DomeScreen, eye: Vec3, size: u32) -> Result<Self, DomeError> {
        Dome::on_screen(screen, eye, size).map(|dome| Self(Kind::Dome(dome)))
    }

    /// Returns the rays from `eye` (metres, in the room) through `size` columns and rows of pixels of
    /// a cylinder screen.
    ///
    /// # Errors
    /// A size, a screen or an eye that cannot be.
    pub fn cylinder_screen(
        screen: CylinderScreen,
        eye: Vec3,
        size: [u32; 2],
    ) -> Result<Self, DomeError> {
        Dome::on_cylinder(screen, eye, size).map(|dome| Self(Kind::Dome(dome)))
    }

    /// Returns the rays from the same eye to the places that a projector's pixels light on the
    /// [dome](Self::dome_screen) or the [cylinder](Self::cylinder_screen) of this view. Pixels that
    /// miss it look past it: nothing is masked.
    ///
    /// # Errors
    /// A size or a beam that cannot be, a view of anything else.
    #[cfg(feature = "projectors")]
    pub fn lit_by(&self, beam: Beam) -> Result<Self, DomeError> {
        match &self.0 {
            Kind::Dome(dome) => Ok(Self(Kind::Dome(dome.lit_by(beam)?))),
            Kind::Screen(_) => Err(DomeError::Beam),
        }
    }

    /// Returns the same rays, turned about +Y and then moved. `turn` has the sine and the cosine of
    /// the angle, above 0 to the left (from −Z towards −X); `by` is in metres.
    #[must_use]
    pub fn moved(&self, turn: [f32; 2], by: Vec3) -> Self {
        let [sin, cos] = turn;
        let turned = |Vec3 { x, y, z }| Vec3::new(cos * x + sin * z, y, cos * z - sin * x);
        Self(match &self.0 {
            Kind::Screen(screen) => Kind::Screen(screen.moved(turned, by)),
            Kind::Dome(dome) => Kind::Dome(dome.moved(turned, by)),
        })
    }

    /// Returns what [`new`](Self::new) has taken, but for the size: the eye, the first pixel, the
    /// steps of a column and of a row; `None` where the screen is not flat.
    pub const fn flat(&self) -> Option<[Vec3; 4]> {
        match &self.0 {
            Kind::Screen(screen) => Some(screen.vectors()),
            Kind::Dome(_) => None,
        }
    }

    pub(super) const fn kind(&self) -> &Kind {
        &self.0
    }

    /// Returns pixels in a row.
    pub const fn columns(&self) -> u32 {
        match &self.0 {
            Kind::Screen(screen) => screen.columns,
            Kind::Dome(dome) => dome.last[0] as u32 + 1,
        }
    }

    /// Returns pixels in a column.
    pub const fn rows(&self) -> u32 {
        match &self.0 {
            Kind::Screen(screen) => screen.rows,
            Kind::Dome(dome) => dome.last[1] as u32 + 1,
        }
    }

    pub(super) const fn size(&self) -> [u32; 2] {
        [self.columns(), self.rows()]
    }

    /// Returns where the rays of a screen start, flat, dome or cylinder, and where a dome master
    /// is taken: metres. Rays off a mirror start all around it.
    pub const fn eye(&self) -> Vec3 {
        match &self.0 {
            Kind::Screen(screen) => screen.eye,
            Kind::Dome(dome) => dome.pose.position,
        }
    }

    /// Towards a point of the picture, in pixels from the centre of the first;
    /// of any length. `None` outside a dome master's rim.
    #[inline]
    pub fn direction(&self, x: f32, y: f32) -> Option<Vec3> {
        match &self.0 {
            Kind::Screen(screen) => Some(screen.direction(x, y)),
            Kind::Dome(dome) => dome.ray(x, y).map(|ray| ray.direction()),
        }
    }

    /// Returns whether all rays start at the [eye](Self::eye).
    pub(super) const fn is_from_one_point(&self) -> bool {
        match &self.0 {
            Kind::Screen(_) => true,
            Kind::Dome(dome) => dome.is_from_one_point(),
        }
    }

    /// Returns whether a pixel shows anything: not outside a dome master's rim.
    pub(super) fn has(&self, column: u32, row: u32) -> bool {
        match &self.0 {
            Kind::Screen(_) => true,
            Kind::Dome(dome) => dome.ray(column as f32, row as f32).is_some(),
        }
    }

    /// Returns the width of a pixel's rays in the middle, after a unit of their directions: metres.
    pub(super) fn pixel_width(&self, samples: u16) -> Width {
        let [x, y] = self.size().map(|pixels| (pixels / 2) as f32);
        let beside = self.direction(x - 1.0, y).zip(self.direction(x, y));
        beside.map_or(Width::ZERO, |(left, right)| {
            let step = right - left;
            Width::new(sqrt(step.dot(step) / f32::from(samples)))
        })
    }

    /// Returns the ray through a point of the picture, in pixels from the centre of the first;
    /// `None` outside a dome master's rim and where its direction cannot be traced.
    #[inline]
    pub fn ray(&self, x: f32, y: f32) -> Option<Ray> {
        match &self.0 {
            Kind::Screen(screen) => screen.ray(x, y),
            Kind::Dome(dome) => dome.ray(x, y),
        }
    }
}

/// Pixels that are all seen from one point.
pub(super) trait OnePoint {
    /// Values of eight columns that are the same in all rows.
    type Columns<F: Copy>;

    fn eye(&self) -> Vec3;

    /// Towards a point of the picture, in pixels from the centre of the first.
    fn towards(&self, x: f32, y: f32) -> Vec3;

    /// Eight columns from `x` on, at an offset from the centres; past the border any.
    fn columns_at<L: Lanes<8>>(&self, l: L, x: u32, dx: f32) -> Self::Columns<L::F>;

    /// Towards a row's pixels: the bits of [`towards`](Self::towards).
    fn towards_row<L: Lanes<8>>(
        &self,
        l: L,
        columns: &Self::Columns<L::F>,
        y: u32,
        dy: f32,
    ) -> [L::F; 3];

    /// Returns four directions between whose components those of a block's pixels are, at an
    /// offset.
    fn corners(
        &self,
        simd: Simd,
        first: (u32, u32),
        last: (u32, u32),
        offset: (f32, f32),
    ) -> [Vec3; 4];
}

/// Directions of pixels, eight at a time.
pub(super) trait Directions {
    /// Returns directions of eight pixels of a row from `(x, y)` on. Borders repeat; outside a rim
    /// its nearest point counts.
    fn directions<L: Lanes<8>>(&self, l: L, place: (u32, u32)) -> [L::F; 3];

    fn direction(&self, place: (u32, u32)) -> Vec3;
}
