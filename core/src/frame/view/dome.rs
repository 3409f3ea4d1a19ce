mod blocks;
mod error;
mod projection;
mod ray_row;

pub use error::DomeError;
pub use projection::{DomePose, DomeProjection, MirrorCamera};
pub(crate) use ray_row::RayRow;

#[cfg(feature = "projectors")]
use super::Beam;
use super::{CylinderScreen, DomeScreen, View};
use crate::capture::{equidistant, fisheye_equisolid, mirror_ball};
use crate::numeric::{largest_magnitude, map3, sines_and_cosines, sqrt};
use crate::shape::Ray;
use crate::simd::{Kernel, Lanes, Portable, Runs, Simd};
use core::f32::consts::{PI, TAU};
use glam::{Mat3, Vec3};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dome {
    projection: DomeProjection,
    pub(super) pose: DomePose,
    /// The last column and row; as many for all but cylinders.
    pub(super) last: [u16; 2],
    screen: Shape,
    /// Largest distance from the centre at which pixels are seen; past 1 they show the rim.
    seen_to: f32,
}

/// What the picture is on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// Nothing: it is of directions, with the first guess for the exact mapping, from
    /// `SpheroidMirror::exact_start`.
    None([f32; 3]),
    /// A dome with this centre from the eye, in radii.
    Dome(Vec3),
    /// A cylinder, in place of the projection, the same way.
    Cylinder(Vec3, Unrolled),
    /// What a beam lights, whose steps are in place of the axes: the centre the same way, the lens
    /// from there, in radii, and whether it is a cylinder about the room's +Y.
    #[cfg_attr(not(feature = "projectors"), allow(dead_code))]
    Lit(Vec3, Vec3, bool),
}

impl Shape {
    /// Returns what a beam lights: its lens, and whether it is a cylinder.
    #[inline(always)]
    const fn lit(&self) -> Option<(Vec3, bool)> {
        match *self {
            // Without the feature, no code is left of it.
            Self::Lit(_, lens, is_cylinder) if cfg!(feature = "projectors") => {
                Some((lens, is_cylinder))
            }
            _ => None,
        }
    }
}

/// The pixels of a cylinder's inside.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Unrolled {
    /// The angle of a column's step: radians.
    column: f32,
    /// The height of the first row's pixels and of a row's step downwards: radii.
    top: f32,
    row: f32,
}

/// One ray for each lane, in the room.
struct Rays<F, M> {
    origin: [F; 3],
    direction: [F; 3],
    seen: M,
}

impl Dome {
    pub(super) fn new(
        projection: DomeProjection,
        pose: DomePose,
        side: u32,
    ) -> Result<Self, DomeError> {
        if !(1..=View::MOST_PIXELS).contains(&side) {
            return Err(DomeError::Size { size: side });
        }
        let (position, axes) = (pose.position, pose.room_from_capture);
        // `max` ignores NaN, so finiteness is checked apart.
        if !(position.is_finite() && largest_magnitude(position) <= DomeError::FARTHEST) {
            return Err(DomeError::Position { position });
        }
        if !is_rotation(&axes) {
            return Err(DomeError::Axes { axes });
        }
        let mut start = [0.0; 3];
        match projection {
            DomeProjection::Mirror(camera) => {
                let (least, most) = MirrorCamera::RADII;
                let (radius, viewpoint) = (camera.radius, camera.viewpoint);
                if !(least..=most).contains(&radius) {
                    return Err(DomeError::Radius { radius });
                }
                if !(viewpoint.abs() <= MirrorCamera::FARTHEST_VIEWPOINT) {
                    return Err(DomeError::Viewpoint { viewpoint });
                }
                start = camera.mirror.exact_start();
            }
            DomeProjection::Equidistant { field_of_view }
            | DomeProjection::Equisolid { field_of_view } => {
                if !(field_of_view > 0.0 && field_of_view <= TAU) {
                    return Err(DomeError::FieldOfView { field_of_view });
                }
            }
            DomeProjection::MirrorBall => {}
        }
        Ok(Self {
            projection,
            pose,
            // At most `View::MOST_PIXELS` less 1.
            last: [(side - 1) as u16; 2],
            screen: Shape::None(start),
            seen_to: 1.0,
        })
    }

    /// Returns the same dome, with the rim shown in the pixels next to its outside.
    pub(super) fn past_the_rim(self) -> Self {
        // The diagonal of a pixel is 2·√2 over the side.
        let seen_to = 1.0 + 3.0 / self.side();
        Self { seen_to, ..self }
    }

    pub(super) fn on_screen(screen: DomeScreen, eye: Vec3, side: u32) -> Result<Self, DomeError> {
        let field_of_view = screen.field_of_view;
        let projection = DomeProjection::Equidistant { field_of_view };
        let dome = Self::new(projection, screen.pose, side)?;
        let radius = screen.radius;
        let (least, most) = DomeScreen::RADII;
        if !(least..=most).contains(&radius) {
            return Err(DomeError::ScreenRadius { radius });
        }
        // Lengths are in radii: from the centre, directions are a dome master's
        // to the bit.
        let centre = (screen.pose.position - eye) / radius;
        let distance = sqrt(centre.length_squared());
        if !(distance <= DomeScreen::FARTHEST_EYE && Ray::new(eye, Vec3::X).is_some()) {
            return Err(DomeError::Eye { eye, distance });
        }
        let pose = DomePose {
            position: eye,
            ..screen.pose
        };
        Ok(Self {
            pose,
            screen: Shape::Dome(centre),
            ..dome
        })
    }

    pub(super) fn on_cylinder(
        screen: CylinderScreen,
        eye: Vec3,
        size: [u32; 2],
    ) -> Result<Self, DomeError> {
        let [columns, rows] = size;
        let projection = DomeProjection::Equidistant { field_of_view: PI };
        Self::new(projection, screen.pose, rows)?;
        let dome = Self::new(projection, screen.pose, columns)?;
        let (radius, angle, [low, high]) = (screen.radius, screen.angle, screen.heights);
        let (least, most) = DomeScreen::RADII;
        if !(least..=most).contains(&radius) {
            return Err(DomeError::ScreenRadius { radius });
        }
        if !(angle > 0.0 && angle <= TAU) {
            return Err(DomeError::FieldOfView {
                field_of_view: angle,
            });
        }
        let (low, height) = (low / radius, (high - low) / radius);
        let are_heights = low.abs() <= CylinderScreen::HIGHEST;
        if !(are_heights && height > 0.0 && height <= 2.0 * CylinderScreen::HIGHEST) {
            return Err(DomeError::Heights { low, height });
        }
        let centre = (screen.pose.position - eye) / radius;
        let up = screen.pose.room_from_capture.y_axis;
        let aside = centre - up * centre.dot(up);
        let distance = sqrt(aside.length_squared());
        let is_near = centre.length_squared() <= CylinderScreen::HIGHEST * CylinderScreen::HIGHEST;
        let is_inside = distance <= DomeScreen::FARTHEST_EYE && is_near;
        if !(is_inside && Ray::new(eye, Vec3::X).is_some()) {
            return Err(DomeError::Eye { eye, distance });
        }
        let row = height / rows as f32;
        let pose = DomePose {
            position: eye,
            ..screen.pose
        };
        Ok(Self {
            pose,
            last: size.map(|side| (side - 1) as u16),
            screen: Shape::Cylinder(
                centre,
                Unrolled {
                    column: angle / columns as f32,
                    top: (low + height) - 0.5 * row,
                    row,
                },
            ),
            ..dome
        })
    }

    /// Returns the rays from the same eye to what a beam's pixels light of the screen.
    #[cfg(feature = "projectors")]
    pub(super) fn lit_by(&self, beam: Beam) -> Result<Self, DomeError> {
        let (centre, is_cylinder) = match self.screen {
            Shape::Dome(centre) => (centre, false),
            Shape::Cylinder(centre, _) if self.pose.room_from_capture.y_axis == Vec3::Y => {
                (centre, true)
            }
            _ => return Err(DomeError::Beam),
        };
        let mut sides = beam.size.into_iter();
        if let Some(size) = sides.find(|side| !(1..=View::MOST_PIXELS).contains(side)) {
            return Err(DomeError::Size { size });
        }
        let last = beam.size.map(|side| (side - 1) as u16);
        let axes = Mat3::from_cols(beam.column_step, beam.row_step, beam.first_pixel);
        let lines = axes.determinant();
        let is_traceable = largest_magnitude(beam.lens) <= CylinderScreen::HIGHEST;
        if !(is_traceable && beam.lens.is_finite() && lines.is_finite() && lines != 0.0) {
            return Err(DomeError::Beam);
        }
        let pose = DomePose {
            room_from_capture: axes,
            ..self.pose
        };
        Ok(Self {
            pose,
            last,
            screen: Shape::Lit(centre, beam.lens, is_cylinder),
            ..*self
        })
    }

    /// Returns the same dome and eye after a turn about +Y and a move.
    pub(super) fn moved(&self, turned: impl Fn(Vec3) -> Vec3, by: Vec3) -> Self {
        let DomePose {
            position,
            room_from_capture: axes,
        } = self.pose;
        let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(&turned);
        Self {
            pose: DomePose {
                position: turned(position) + by,
                room_from_capture: Mat3::from_cols(x, y, z),
            },
            screen: match self.screen {
                Shape::None(start) => Shape::None(start),
                Shape::Dome(centre) => Shape::Dome(turned(centre)),
                Shape::Cylinder(centre, unrolled) => Shape::Cylinder(turned(centre), unrolled),
                Shape::Lit(centre, lens, is_cylinder) => {
                    Shape::Lit(turned(centre), turned(lens), is_cylinder)
                }
            },
            ..*self
        }
    }

    fn side(&self) -> f32 {
        let [last, _] = self.last;
        f32::from(last) + 1.0
    }

    /// Returns the ray through a point of the picture, in pixels; `None` outside the rim.
    pub(crate) fn ray(&self, x: f32, y: f32) -> Option<Ray> {
        let rays = self.rays_of_one(x, y);
        let vector = |[[x], [y], [z]]: [[f32; 1]; 3]| Vec3::new(x, y, z);
        if rays.seen == 0 {
            return None;
        }
        Ray::new(vector(rays.origin), vector(rays.direction))
    }

    #[inline(never)]
    fn rays_of_one(&self, x: f32, y: f32) -> Rays<[f32; 1], u32> {
        self.rays(Portable, [x], [y])
    }

    /// Returns the rays through eight points of the picture, in pixels.
    pub(crate) fn row(&self, simd: Simd, x: &[f32; 8], y: &[f32; 8]) -> RayRow {
        <Simd as Runs<8>>::run(simd, Row(self, x, y))
    }

    /// Returns the rays through points of the picture, one for each lane.
    #[inline(always)]
    fn rays<const W: usize, L: Lanes<W>>(&self, l: L, x: L::F, y: L::F) -> Rays<L::F, L::M> {
        let mut pixel = self.place(l, x, y);
        let seen = l.le(pixel[2], l.splat(self.seen_to));
        if self.seen_to > 1.0 {
            pixel = back_inside(l, pixel);
        }
        let (origin, direction) = self.lines(l, pixel);
        let axes = self.axes();
        let [x, y, z] = self.pose.position.to_array();
        let direction = self.in_room(l, axes, direction);
        let origin = match origin {
            None => [l.splat(x), l.splat(y), l.splat(z)],
            Some(origin) => [
                l.add(l.splat(x), turned(l, axes, 0, origin)),
                l.add(l.splat(y), turned(l, axes, 1, origin)),
                l.add(l.splat(z), turned(l, axes, 2, origin)),
            ],
        };
        Rays {
            origin,
            direction,
            seen,
        }
    }

    /// Returns the directions of places; outside the rim, those of the nearest points inside.
    #[inline(always)]
    fn nearest_directions<const W: usize, L: Lanes<W>>(&self, l: L, x: L::F, y: L::F) -> [L::F; 3] {
        let (_, direction) = self.lines(l, back_inside(l, self.place(l, x, y)));
        self.in_room(l, self.axes(), direction)
    }

    /// Returns the axes of the capture in the room: right, top and back.
    #[inline(always)]
    fn axes(&self) -> [[f32; 3]; 3] {
        self.pose.room_from_capture.to_cols_array_2d()
    }

    /// Turns directions along the capture's axes into the room's; for a screen, into those from
    /// the eye.
    #[inline(always)]
    fn in_room<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        axes: [[f32; 3]; 3],
        direction: [L::F; 3],
    ) -> [L::F; 3] {
        let turned = map3([0, 1, 2], |axis| turned(l, axes, axis, direction));
        let [x, y, z] = match self.screen.lit() {
            Some((lens, is_cylinder)) => inside(l, lens, turned, is_cylinder),
            None => turned,
        };
        match self.screen {
            Shape::None(_) => [x, y, z],
            Shape::Dome(centre) | Shape::Cylinder(centre, _) | Shape::Lit(centre, ..) => {
                let [cx, cy, cz] = centre.to_array();
                [
                    l.add(l.splat(cx), x),
                    l.add(l.splat(cy), y),
                    l.add(l.splat(cz), z),
                ]
            }
        }
    }

    /// Returns (u, v) for points of the picture, and their distances from its centre; on a cylinder
    /// angles from the middle, heights, and 0; of a beam pixels and 0.
    #[inline(always)]
    fn place<const W: usize, L: Lanes<W>>(&self, l: L, x: L::F, y: L::F) -> [L::F; 3] {
        if self.screen.lit().is_some() {
            return [x, y, l.splat(0.0)];
        }
        let (side, two) = (l.splat(self.side()), l.splat(2.0));
        let last = l.splat(self.side() - 1.0);
        if let Shape::Cylinder(_, cylinder) = &self.screen {
            let middle = l.mul(l.splat(0.5), last);
            let angle = l.mul(l.sub(x, middle), l.splat(cylinder.column));
            let height = l.sub(l.splat(cylinder.top), l.mul(y, l.splat(cylinder.row)));
            return [angle, height, l.splat(0.0)];
        }
        let u = l.div(l.sub(l.mul(two, x), last), side);
        let v = l.div(l.sub(last, l.mul(two, y)), side);
        let radius = l.sqrt(l.add(l.mul(u, u), l.mul(v, v)));
        [u, v, radius]
    }

    /// Returns the starts of lines of sight in metres (`None`: the position), and their directions.
    #[inline(always)]
    fn lines<const W: usize, L: Lanes<W>>(
        &self,
        l: L,
        pixel: [L::F; 3],
    ) -> (Option<[L::F; 3]>, [L::F; 3]) {
        if self.screen.lit().is_some() {
            let [x, y, _] = pixel;
            return (None, [x, y, l.splat(1.0)]);
        }
        let start = match self.screen {
            Shape::None(start) => start,
            Shape::Dome(_) | Shape::Lit(..) => [0.0; 3],
            Shape::Cylinder(..) => {
                let [angle, height, zero] = pixel;
                let (sin, cos) = sines_and_cosines(l, l.min(l.abs(angle), l.splat(PI)));
                let sin = l.select(l.le(angle, zero), l.sub(zero, sin), sin);
                return (None, [sin, height, l.sub(zero, cos)]);
            }
        };
        match &self.projection {
            DomeProjection::Mirror(camera) => {
                let [u, v, radius] = pixel;
                let u = if camera.mirrored {
                    l.mul(l.splat(-1.0), u)
                } else {
                    u
                };
                let pixel = [u, v, radius];
                let lines = camera.mirror.pixels(l, pixel, camera.mapping, start);
                let [x, y, z] = lines.point;
                let scale = l.splat(camera.radius);
                // The position is added last, in the room, since the mirror may be far
                // from the room's origin.
                let z = l.add(z, l.splat(camera.viewpoint));
                let point = [l.mul(scale, x), l.mul(scale, y), l.mul(scale, z)];
                (Some(point), lines.direction)
            }
            DomeProjection::Equidistant { field_of_view } => {
                (None, equidistant(l, pixel, *field_of_view))
            }
            DomeProjection::Equisolid { .. } | DomeProjection::MirrorBall => {
                (None, self.one_by_one(l, pixel))
            }
        }
    }

    /// Returns directions whose computation needs more precision than f32, lane by lane.
    #[inline(always)]
    fn one_by_one<const W: usize, L: Lanes<W>>(&self, l: L, [u, v, _]: [L::F; 3]) -> [L::F; 3] {
        let (u, v) = (l.store(u), l.store(v));
        let mut directions = [[0.0; W]; 3];
        for lane in 0..W {
            let direction = match self.projection {
                DomeProjection::Equisolid { field_of_view } => {
                    fisheye_equisolid(u[lane], v[lane], field_of_view)
                }
                _ => mirror_ball(u[lane], v[lane]),
            };
            let direction = direction.unwrap_or(Vec3::ZERO);
            for (axis, component) in direction.to_array().into_iter().enumerate() {
                directions[axis][lane] = component;
            }
        }
        let [x, y, z] = &directions;
        [l.load(x), l.load(y), l.load(z)]
    }
}

/// Moves places outside the rim to its nearest point: (u, v) and the distance.
#[inline(always)]
fn back_inside<const W: usize, L: Lanes<W>>(l: L, [u, v, radius]: [L::F; 3]) -> [L::F; 3] {
    /// Factor on the radius that a place is divided by, so that rounding leaves it inside the rim.
    const BACK_INSIDE: f32 = 1.0 + 4.0 * f32::EPSILON;
    // Places inside the rim are divided by 1.
    let past = l.mul(radius, l.splat(BACK_INSIDE));
    let past = l.select(l.le(radius, l.splat(1.0)), l.splat(1.0), past);
    [l.div(u, past), l.div(v, past), l.div(radius, past)]
}

/// Returns where lines from a lens leave the unit sphere, or the unit cylinder about +Y; for lines
/// past it about where they come nearest. Lines along the axis end far away.
#[inline(always)]
fn inside<const W: usize, L: Lanes<W>>(
    l: L,
    lens: Vec3,
    line: [L::F; 3],
    is_cylinder: bool,
) -> [L::F; 3] {
    /// Least square of a line's length across the axis.
    const ACROSS: f32 = 1.0e-12;
    let along = l.splat(if is_cylinder { 0.0 } else { 1.0 });
    let lens = map3(lens.to_array(), |part| l.splat(part));
    let dot = |[ax, ay, az]: [L::F; 3], [bx, by, bz]: [L::F; 3]| {
        let level = l.add(l.mul(ax, bx), l.mul(az, bz));
        l.add(level, l.mul(along, l.mul(ay, by)))
    };
    let length = l.max(dot(line, line), l.splat(ACROSS));
    let half = dot(lens, line);
    let outside = l.sub(dot(lens, lens), l.splat(1.0));
    let left = l.sub(l.mul(half, half), l.mul(length, outside));
    let root = l.sqrt(l.max(left, l.splat(0.0)));
    let t = l.div(l.sub(root, half), length);
    map3([0, 1, 2], |axis: usize| {
        let axis = axis % 3;
        l.add(lens[axis], l.mul(t, line[axis]))
    })
}

/// Returns one component of a vector along the axes.
#[inline(always)]
fn turned<const W: usize, L: Lanes<W>>(
    l: L,
    [right, top, back]: [[f32; 3]; 3],
    component: usize,
    [x, y, z]: [L::F; 3],
) -> L::F {
    let component = component % 3;
    let x = l.mul(l.splat(right[component]), x);
    let y = l.mul(l.splat(top[component]), y);
    let z = l.mul(l.splat(back[component]), z);
    l.add(l.add(x, y), z)
}

/// Returns whether axes are of unit length, at right angles and right-handed.
fn is_rotation(axes: &Mat3) -> bool {
    let (x, y, z) = (axes.x_axis, axes.y_axis, axes.z_axis);
    // NaN fails each comparison.
    let off = |found: f32, expected: f32| (found - expected).abs() <= DomeError::SKEW;
    [x, y, z].iter().all(|axis| off(axis.dot(*axis), 1.0))
        && off(x.dot(y), 0.0)
        && off(y.dot(z), 0.0)
        && off(z.dot(x), 0.0)
        && x.cross(y).dot(z) > 0.0
}

struct Row<'r>(&'r Dome, &'r [f32; 8], &'r [f32; 8]);

impl Kernel<8> for Row<'_> {
    type Output = RayRow;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> RayRow {
        let Self(dome, x, y) = self;
        let rays = dome.rays(l, l.load(x), l.load(y));
        let [ox, oy, oz] = rays.origin;
        let [dx, dy, dz] = rays.direction;
        RayRow {
            origins: [l.store(ox), l.store(oy), l.store(oz)],
            directions: [l.store(dx), l.store(dy), l.store(dz)],
            seen: l.bits(rays.seen),
        }
    }
}
