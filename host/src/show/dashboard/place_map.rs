//! A map from places of the canvas to pixels of screens: pictures whose pixels hold their own
//! coordinates are unfolded, or seen from the eye, once; frames are drawn by looking up pixels.

use super::canvas::{Canvas, Colour};
use crate::cave::{Cave, Screen};
use crate::picture::{Picture, PictureError, srgb_from_linear};
use crate::show::ShowError;
use crate::show::overview::net;
use crate::show::overview::viewer::{self, ViewerCamera};

/// The most coordinates on a side of a picture: a window shows no more.
const FINEST: u32 = 256;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Plain(Colour),
    Pixel { screen: u16, x: u16, y: u16 },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PlaceMap {
    width: u32,
    height: u32,
    pub(super) places: Vec<Place>,
}

pub(super) struct Coordinates<'c> {
    screens: Vec<(Screen<'c>, Picture)>,
    sizes: Vec<[u32; 2]>,
}

impl<'c> Coordinates<'c> {
    pub(super) fn new(cave: &'c Cave) -> Result<Self, PictureError> {
        let (mut screens, mut sizes) = (Vec::new(), Vec::new());
        for (number, screen) in cave.screens().enumerate() {
            let size = screen.size();
            screens.push((screen, coordinates(number, size)?));
            sizes.push(size);
        }
        Ok(Self { screens, sizes })
    }

    pub(super) fn net(&self) -> Result<PlaceMap, ShowError> {
        Ok(self.places_of(&net::unfold(&self.seen())?))
    }

    pub(super) fn view(&self, camera: &ViewerCamera) -> Result<PlaceMap, ShowError> {
        Ok(self.places_of(&viewer::render(camera, &self.seen())?))
    }

    fn seen(&self) -> Vec<(Screen<'c>, &Picture)> {
        self.screens
            .iter()
            .map(|(screen, picture)| (*screen, picture))
            .collect()
    }

    fn places_of(&self, picture: &Picture) -> PlaceMap {
        let place = |&[x, y, number, alpha]: &[f32; 4]| {
            // Names and borders are at most 0.9 bright, and screens are numbered from 1.
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

/// Returns a picture of its own columns and rows and the number of the screen, from 1.
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

pub(super) fn colour(linear: [f32; 3]) -> Colour {
    linear.into_iter().fold(0, |colour, channel| {
        (colour << 8) | Colour::from(srgb_from_linear(channel))
    })
}

impl PlaceMap {
    pub(super) fn place(&self, x: u32, y: u32) -> Option<Place> {
        let inside = x < self.width && y < self.height;
        let index = y as usize * self.width as usize + x as usize;
        inside.then(|| self.places.get(index).copied()).flatten()
    }

    /// Scales the map to fit, centred on `background`; at most [`Canvas::MOST`] on each side.
    pub(super) fn fitted(&self, width: u32, height: u32, background: Colour) -> Self {
        let [width, height] = [width, height].map(|pixels| pixels.min(Canvas::MOST));
        let [own_width, own_height] = [self.width, self.height].map(f64::from);
        let scale = (f64::from(width) / own_width).min(f64::from(height) / own_height);
        let offset = |count: u32, own: f64| 0.5 * (f64::from(count) - own * scale);
        let (left, top) = (offset(width, own_width), offset(height, own_height));
        let place = |x: u32, y: u32| {
            let from = |at: u32, start: f64| (f64::from(at) + 0.5 - start) / scale;
            let (x, y) = (from(x, left), from(y, top));
            // A cast would turn negative numbers into 0.
            let inside = x >= 0.0 && y >= 0.0;
            let found = inside.then(|| self.place(x as u32, y as u32)).flatten();
            found.unwrap_or(Place::Plain(background))
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            width,
            height,
            places: places.map(|(x, y)| place(x, y)).collect(),
        }
    }
}
