//! Which pixel of which screen's picture is shown where.
//!
//! Pictures whose pixels are their own coordinates are unfolded into a net, or seen
//! from the eye, once in place of the pictures themselves: so a frame is shown by
//! looking up its pixels, what a mouse points at is known, and anything that is known
//! of a pixel can be shown over it.

use super::canvas::{Canvas, Colour};
use crate::cave::{Cave, Screen};
use crate::picture::{Picture, PictureError, srgb_from_linear};
use crate::show::overview::net::{self, NetError};
use crate::show::overview::viewer::{self, ViewError, ViewerCamera};
use thiserror::Error;

/// Coordinates of a picture are kept at so many places a side at most: a window shows
/// no more.
const FINEST: u32 = 256;

/// What is shown at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// No picture: a border, a name, the background.
    Plain(Colour),
    /// A pixel of a screen's picture.
    Pixel {
        /// The number of the screen.
        screen: u16,
        /// Its column.
        x: u16,
        /// Its row.
        y: u16,
    },
}

/// What is shown at each place of a rectangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlaceMap {
    width: u32,
    height: u32,
    places: Vec<Place>,
}

/// Why there is none.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlaceMapError {
    /// The walls have no net.
    #[error(transparent)]
    Net(#[from] NetError),
    /// The walls cannot be looked at.
    #[error(transparent)]
    View(#[from] ViewError),
    /// There is no memory for it.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// The coordinates of a room's screens.
#[derive(Debug)]
pub struct Coordinates<'c> {
    screens: Vec<(Screen<'c>, Picture)>,
    sizes: Vec<[u32; 2]>,
}

impl<'c> Coordinates<'c> {
    /// Of all screens of a room.
    ///
    /// # Errors
    /// A picture that there is no memory for.
    pub fn new(cave: &'c Cave) -> Result<Self, PictureError> {
        let (mut screens, mut sizes) = (Vec::new(), Vec::new());
        for (number, screen) in cave.screens().enumerate() {
            let size = match screen {
                Screen::Wall(wall) => wall.pixels,
                Screen::Dome(dome) => [dome.size(); 2],
            };
            screens.push((screen, coordinates(number, size)?));
            sizes.push(size);
        }
        Ok(Self { screens, sizes })
    }

    /// All screens unfolded: [`net::unfold`].
    ///
    /// # Errors
    /// As of the net.
    pub fn net(&self) -> Result<PlaceMap, PlaceMapError> {
        Ok(self.places_of(&net::unfold(&self.seen())?))
    }

    /// All screens as an eye sees them: [`viewer::render`].
    ///
    /// # Errors
    /// As of the view.
    pub fn view(&self, camera: &ViewerCamera) -> Result<PlaceMap, PlaceMapError> {
        Ok(self.places_of(&viewer::render(camera, &self.seen())?))
    }

    fn seen(&self) -> Vec<(Screen<'c>, &Picture)> {
        let screens = self.screens.iter();
        screens
            .map(|(screen, picture)| (*screen, picture))
            .collect()
    }

    fn places_of(&self, picture: &Picture) -> PlaceMap {
        let place = |&[x, y, number, alpha]: &[f32; 4]| {
            // Names and borders are no brighter than 0.9, and screens are numbered
            // from 1.
            let screen = (number.round() as usize).checked_sub(1);
            let size = screen.and_then(|screen| self.sizes.get(screen));
            match (screen, size) {
                (Some(screen), Some(&[columns, rows])) if number > 0.95 && alpha > 0.5 => {
                    Place::Pixel {
                        screen: screen as u16,
                        x: (x as u32).min(columns.saturating_sub(1)) as u16,
                        y: (y as u32).min(rows.saturating_sub(1)) as u16,
                    }
                }
                _ => Place::Plain(colour([x, y, number])),
            }
        };
        PlaceMap {
            width: picture.width,
            height: picture.height,
            places: picture.pixels.iter().map(place).collect(),
        }
    }
}

/// Columns, rows, and the number of the screen from 1.
fn coordinates(number: usize, [columns, rows]: [u32; 2]) -> Result<Picture, PictureError> {
    let (width, height) = (columns.min(FINEST), rows.min(FINEST));
    let along = |place: u32, count: u32, of: u32| {
        let part = (f64::from(place) + 0.5) / f64::from(count);
        (part * f64::from(of)) as f32
    };
    let mut picture = Picture::new(width, height)?;
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = (index as u32 % width, index as u32 / width);
        *pixel = [
            along(x, width, columns),
            along(y, height, rows),
            (number + 1) as f32,
            1.0,
        ];
    }
    Ok(picture)
}

fn colour(linear: [f32; 3]) -> Colour {
    linear.into_iter().fold(0, |colour, channel| {
        (colour << 8) | Colour::from(srgb_from_linear(channel))
    })
}

impl PlaceMap {
    /// Columns and rows.
    pub const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Row by row.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// What is shown there; `None` outside.
    pub fn place(&self, x: u32, y: u32) -> Option<Place> {
        let inside = x < self.width && y < self.height;
        let index = y as usize * self.width as usize + x as usize;
        inside.then(|| self.places.get(index).copied()).flatten()
    }

    /// As large as it fits into so many columns and rows, in its middle, on
    /// `background`: each place shows the nearest. No larger than a
    /// [`Canvas`](Canvas::MOST) may be.
    #[must_use]
    pub fn fitted(&self, width: u32, height: u32, background: Colour) -> Self {
        let [width, height] = [width, height].map(|pixels| pixels.min(Canvas::MOST));
        let [own_width, own_height] = self.size().map(f64::from);
        let scale = (f64::from(width) / own_width).min(f64::from(height) / own_height);
        let offset = |count: u32, own: f64| 0.5 * (f64::from(count) - own * scale);
        let (left, top) = (offset(width, own_width), offset(height, own_height));
        let place = |x: u32, y: u32| {
            let from = |at: u32, start: f64| (f64::from(at) + 0.5 - start) / scale;
            let (x, y) = (from(x, left), from(y, top));
            // A cast would make 0 of what is left of it.
            let inside = x >= 0.0 && y >= 0.0;
            let found = inside.then(|| self.place(x as u32, y as u32)).flatten();
            found.unwrap_or(Place::Plain(background))
        };
        let rows = 0..height;
        Self {
            width,
            height,
            places: rows
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| place(x, y))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cave::BuiltInCave;
    use glam::DVec3;

    /// Pictures of noise, each its own.
    fn pictures(coordinates: &Coordinates<'_>) -> Vec<Picture> {
        let sizes = coordinates.sizes.iter().enumerate();
        sizes
            .map(|(number, &[width, height])| {
                let mut picture = Picture::new(width, height).unwrap();
                for (index, pixel) in picture.pixels.iter_mut().enumerate() {
                    let part = |by: usize| ((index * by + number * 7) % 61) as f32 / 61.0;
                    *pixel = [part(3), part(17), part(29), 1.0];
                }
                picture
            })
            .collect()
    }

    fn looked_up(shown: &PlaceMap, pictures: &[Picture]) -> Vec<Option<Colour>> {
        let places = shown.places().iter();
        places
            .map(|place| match *place {
                Place::Plain(_) => None,
                Place::Pixel { screen, x, y } => {
                    let [red, green, blue, _] =
                        pictures[usize::from(screen)].pixel(x.into(), y.into())?;
                    Some(colour([red, green, blue]))
                }
            })
            .collect()
    }

    #[test]
    fn a_net_of_coordinates_shows_what_the_net_of_pictures_does() {
        for which in [BuiltInCave::ThreeWall, BuiltInCave::Cube] {
            let cave = Cave::built_in(which, [40; 2]).unwrap();
            let coordinates = Coordinates::new(&cave).unwrap();
            let pictures = pictures(&coordinates);
            let shown = coordinates.net().unwrap();
            let seen: Vec<_> = cave.screens().zip(&pictures).collect();
            let net = net::unfold(&seen).unwrap();
            assert_eq!(shown.size(), [net.width, net.height]);
            let mut pixels = 0;
            let all = looked_up(&shown, &pictures).into_iter().zip(&net.pixels);
            for (place, (found, &[red, green, blue, _])) in shown.places().iter().zip(all) {
                let wanted = colour([red, green, blue]);
                match place {
                    Place::Plain(plain) => assert_eq!(*plain, wanted),
                    Place::Pixel { .. } => {
                        assert_eq!(found, Some(wanted));
                        pixels += 1;
                    }
                }
            }
            // All but the names.
            let all = 1_600 * cave.screens().count();
            assert!(pixels > all * 6 / 10 && pixels <= all, "{pixels} of {all}");
        }
    }

    #[test]
    fn an_eye_sees_the_pixel_that_a_ray_meets() {
        let cave = Cave::built_in(BuiltInCave::Cube, [64; 2]).unwrap();
        let coordinates = Coordinates::new(&cave).unwrap();
        let (ahead, up) = (DVec3::new(0.3, 0.1, -1.0), DVec3::Y);
        let camera = ViewerCamera::new(DVec3::ZERO, ahead, up, 1.2, [32, 24]).unwrap();
        let shown = coordinates.view(&camera).unwrap();
        assert_eq!(shown.size(), [32, 24]);
        for y in 0..24 {
            for x in 0..32 {
                let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(Place::Pixel { screen, x, y }) = shown.place(x, y) else {
                    panic!("a cube is all around");
                };
                let wall = &cave.walls[usize::from(screen)];
                let view = wall.view_from(DVec3::ZERO).unwrap();
                let [first, column, row] = [view.first_pixel, view.column_step, view.row_step]
                    .map(|one| glam::Vec3::from(one).as_dvec3());
                let pixel = first + f64::from(x) * column + f64::from(y) * row;
                // Half a pixel's diagonal of 64 over 90°.
                assert!(pixel.angle_between(ray) < 0.03, "{ray} {pixel}");
            }
        }
    }

    #[test]
    fn large_pictures_are_known_at_fewer_places() {
        let cave = Cave::built_in(BuiltInCave::Dome, [1_000; 2]).unwrap();
        let coordinates = Coordinates::new(&cave).unwrap();
        let shown = coordinates.net().unwrap();
        let [width, _] = shown.size();
        assert!(width < 2 * FINEST, "{width}");
        let columns: Vec<u16> = shown
            .places()
            .iter()
            .filter_map(|place| match place {
                Place::Pixel { x, .. } => Some(*x),
                Place::Plain(_) => None,
            })
            .collect();
        assert!(columns.iter().max() > Some(&990) && columns.iter().min() < Some(&10));
    }

    #[test]
    fn fitting_keeps_the_shape() {
        let places = (0..6).map(Place::Plain).collect();
        let small = PlaceMap {
            width: 3,
            height: 2,
            places,
        };
        let fitted = small.fitted(6, 6, 99);
        let plain = |x, y| match fitted.place(x, y) {
            Some(Place::Plain(colour)) => colour,
            other => panic!("{other:?}"),
        };
        let rows: Vec<Vec<Colour>> = (0..6)
            .map(|y| (0..6).map(|x| plain(x, y)).collect())
            .collect();
        assert_eq!(rows[0], [99; 6]);
        assert_eq!(rows[1], [0, 0, 1, 1, 2, 2]);
        assert_eq!(rows[2], rows[1]);
        assert_eq!(rows[3], [3, 3, 4, 4, 5, 5]);
        assert_eq!(rows[5], [99; 6]);
        assert_eq!(fitted.place(6, 0), None);
        assert_eq!(small.fitted(0, 0, 1).places().len(), 0);
    }
}
