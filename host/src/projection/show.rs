//! The pixels of a projector, of each frame.

use super::blend::{Blend, Member};
use super::transfer::Codes;
use crate::cave::{Cave, Eye, RoomError};
use crate::picture::Picture;
use glam::{DVec2, Vec4};
use rayon::prelude::*;
use std::sync::Arc;

/// What a projector shows of its screen's pictures: a place and a weight for each of its pixels.
#[derive(Debug, Clone)]
pub struct Projection {
    name: String,
    screen: String,
    /// Whether its pictures are of its own pixels, not of its screen's.
    is_direct: bool,
    eye: Option<Eye>,
    resolution: [u32; 2],
    /// Columns and rows of the screen's picture.
    picture: [u32; 2],
    pixels: Vec<Pixel>,
    /// The light that is added to each pixel, 0 to 65 535; empty where none is.
    lifts: Vec<u16>,
    /// Red, green and blue light for a weight of 1, and for a lift of 1.
    units: [Vec4; 2],
    codes: [Arc<Codes>; 3],
}

/// One pixel of a projector: between four of its screen's picture.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    /// The upper left one.
    first: u32,
    /// How far it is from that to the right and below: 255ths.
    shares: [u8; 2],
    /// The factor on the picture's light, 0 to 65 535.
    weight: u16,
}

/// What a projector's pixel shows of its screen's picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Light {
    /// In the picture, 0 to 1 from its upper left corner.
    place: DVec2,
    /// The factor on the picture's light.
    pub(super) weight: f64,
    /// The light that is added: fewer projectors' black is lifted to that of most.
    pub(super) lift: f64,
    /// The light of all projectors' black.
    black: f64,
}

impl Projection {
    /// Returns what each of a room's projectors shows, in the order of its projectors. To show
    /// frames, pictures must have their screens' sizes, or that of a projector whose own pixels are
    /// traced ([`Cave::trace_directly`]).
    ///
    /// # Errors
    /// As [`Cave::blends`]; a screen of one column or row.
    pub fn all(cave: &Cave) -> Result<Vec<Self>, RoomError> {
        let mut found: Vec<(usize, Self)> = Vec::new();
        for blend in cave.blends()? {
            check_size(&blend)?;
            for (member, lights) in blend.members.iter().zip(lights_of(&blend)) {
                let mut direct = cave.direct.iter();
                let is_direct = direct.any(|one| one.name == member.projector.name);
                found.push((member.number, Self::new(member, &lights, is_direct)));
            }
        }
        found.sort_by_key(|(number, _)| *number);
        Ok(found
            .into_iter()
            .map(|(_, projection)| projection)
            .collect())
    }

    fn new(member: &Member<'_>, lights: &[Option<Light>], is_direct: bool) -> Self {
        let (projector, screen) = (member.projector, member.map.screen());
        let resolution = projector.resolution;
        let picture = if is_direct { resolution } else { screen.size() };
        let own = |number: usize| {
            let columns = resolution[0] as usize;
            let pixel = DVec2::new((number % columns) as f64, (number / columns) as f64);
            (pixel + 0.5) / DVec2::from(resolution.map(f64::from))
        };
        let lifts = lights.iter().flatten().map(|light| light.lift);
        let most = lifts.fold(0.0, f64::max);
        let fixed = |share: f64| (65_535.0 * share).round_ties_even().min(65_535.0) as u16;
        let pixel = |(number, light): (usize, &Option<Light>)| {
            light.map_or_else(Pixel::default, |light| {
                let place = if is_direct { own(number) } else { light.place };
                let [x, y] = [0, 1].map(|axis| between(place[axis], picture[axis]));
                Pixel {
                    first: y.0 * picture[0] + x.0,
                    shares: [x.1, y.1],
                    weight: fixed(light.weight),
                }
            })
        };
        let lift = |light: &Option<Light>| light.map_or(0, |light| fixed(light.lift / most));
        let lifts = if most > 0.0 { lights } else { &[] };
        let [red, green, blue] = projector.gain.map(|gain| gain as f32 / 65_535.0);
        let unit = Vec4::new(red, green, blue, 0.0);
        let [first, ..] = &projector.gamma;
        let shared = Arc::new(Codes::new(first));
        let codes = |gamma| {
            let is_shared = gamma == first;
            if is_shared {
                shared.clone()
            } else {
                Arc::new(Codes::new(gamma))
            }
        };
        Self {
            name: projector.name.clone(),
            screen: screen.name().to_owned(),
            is_direct,
            eye: projector.eye,
            resolution,
            picture,
            pixels: lights.iter().enumerate().map(pixel).collect(),
            lifts: lifts.iter().map(lift).collect(),
            units: [unit, unit * most as f32],
            codes: projector.gamma.each_ref().map(codes),
        }
    }

    /// Returns the projector's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the screen's name.
    pub fn screen(&self) -> &str {
        &self.screen
    }

    /// Returns whether its own pixels are traced.
    pub const fn is_direct(&self) -> bool {
        self.is_direct
    }

    /// Returns whose pictures it shows: the screen's name, or its own where its pixels are traced.
    pub fn source(&self) -> &str {
        if self.is_direct {
            &self.name
        } else {
            &self.screen
        }
    }

    /// Returns the eye whose pictures it shows; `None` for both.
    pub const fn eye(&self) -> Option<Eye> {
        self.eye
    }

    /// Returns the columns and rows of the pictures that it shows.
    pub const fn picture_size(&self) -> [u32; 2] {
        self.picture
    }

    /// Returns the projector's columns and rows.
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Writes the projector's codes, 0xRRGGBB, in rows from the top, of a picture of its screen, in
    /// rows on all threads. The picture is taken as before black, and clipped at 1; pixels that
    /// do not light the screen are black.
    ///
    /// # Errors
    /// A picture that has not the size of the screen's, or another number of pixels in `to` than the
    /// projector has.
    pub fn show(&self, picture: &Picture, to: &mut [u32]) -> Result<(), RoomError> {
        let size = [picture.width, picture.height];
        let count = u64::from(size[0]) * u64::from(size[1]);
        if size != self.picture
            || picture.pixels.len() as u64 != count
            || to.len() != self.pixels.len()
        {
            let [columns, rows] = self.picture;
            return Err(RoomError::new(
                "pixels",
                format!(
                    "projector \"{}\" cannot show {} × {} pixels with {} of its own",
                    self.name,
                    size[0],
                    size[1],
                    to.len()
                ),
                format!(
                    "give a picture of {columns} × {rows} pixels, as \"{}\" has, and {} pixels to \
                     fill",
                    self.source(),
                    self.pixels.len()
                ),
            ));
        }
        let columns = self.resolution[0] as usize;
        let rows = self
            .pixels
            .par_chunks(columns)
            .zip(to.par_chunks_mut(columns));
        if self.lifts.is_empty() {
            rows.for_each(|(pixels, to)| self.show_row::<false>(picture, pixels, &[], to));
        } else {
            let rows = rows.zip(self.lifts.par_chunks(columns));
            rows.for_each(|((pixels, to), lifts)| {
                self.show_row::<true>(picture, pixels, lifts, to);
            });
        }
        Ok(())
    }

    fn show_row<const LIFTED: bool>(
        &self,
        picture: &Picture,
        pixels: &[Pixel],
        lifts: &[u16],
        to: &mut [u32],
    ) {
        let columns = self.picture[0] as usize;
        // In this order NaN stays, and becomes black at the end.
        let clipped = |pixel: [f32; 4]| Vec4::ONE.min(Vec4::from_array(pixel));
        let [unit, lift_unit] = self.units;
        let [red, green, blue] = &self.codes;
        let mut lifts = lifts.iter();
        for (pixel, to) in pixels.iter().zip(to) {
            let lift = if LIFTED {
                lifts.next().copied().unwrap_or(0)
            } else {
                0
            };
            let first = pixel.first as usize;
            let square = picture.pixels.get(first..first + columns + 2);
            let Some(square) = square.filter(|_| pixel.weight > 0 || (LIFTED && lift > 0)) else {
                *to = 0;
                continue;
            };
            let [x, y] = pixel.shares.map(|share| f32::from(share) * (1.0 / 255.0));
            let corners = [square[0], square[1], square[columns], square[columns + 1]];
            let [a, b, c, d] = corners.map(clipped);
            let (left, right) = (a + (c - a) * y, b + (d - b) * y);
            let light = left + (right - left) * x;
            let mut light = light * (unit * Vec4::splat(f32::from(pixel.weight)));
            if LIFTED {
                light += lift_unit * Vec4::splat(f32::from(lift));
            }
            let light = light.max(Vec4::splat(Codes::LEAST)).min(Vec4::ONE);
            let [r, g, b, _] = light.to_array();
            let [r, g, b] = [red.of(r), green.of(g), blue.of(b)].map(u32::from);
            *to = (r << 16) | (g << 8) | b;
        }
    }
}

fn check_size(blend: &Blend<'_>) -> Result<(), RoomError> {
    let screen = blend.members[0].map.screen();
    if screen.size().iter().all(|side| *side >= 2) {
        return Ok(());
    }
    Err(RoomError::new(
        "pixels",
        format!(
            "screen \"{}\" has one column or row of pixels",
            screen.name()
        ),
        "give it two or more for its projectors",
    ))
}

/// Returns what the pixels of each of a screen's projectors show, in rows; `None` off the screen.
///
/// With black β, a pixel that shows d gives β + (1 − β) d. Where projectors' black adds up to b and
/// B at most anywhere, a picture's light L becomes B + (1 − B) L everywhere with
/// d = w ((B − b) + (1 − B) L) / (1 − β), w being the projector's share.
pub(super) fn lights_of(blend: &Blend<'_>) -> Vec<Vec<Option<Light>>> {
    let members = 0..blend.members.len();
    let mut all: Vec<_> = members.map(|member| unlifted(blend, member)).collect();
    let blacks = all.iter().flatten().flatten().map(|light| light.black);
    let blackest = blacks.fold(0.0, f64::max);
    if blackest > 0.0 {
        for (lights, member) in all.iter_mut().zip(&blend.members) {
            let own = 1.0 - member.projector.black;
            let blacks = blurred(lights, member.projector.resolution[0] as usize);
            for (light, black) in lights.iter_mut().zip(blacks) {
                if let Some(light) = light.as_mut().filter(|light| light.lift == 0.0) {
                    light.lift = light.weight * (blackest - black) / own;
                    light.weight *= (1.0 - blackest) / own;
                }
            }
        }
    }
    all
}

fn unlifted(blend: &Blend<'_>, number: usize) -> Vec<Option<Light>> {
    let member = &blend.members[number];
    let [columns, rows] = member.projector.resolution;
    let size = DVec2::new(f64::from(columns), f64::from(rows));
    let light = |column: u32, row: u32| {
        let at = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / size;
        let place = member.map.place(at)?;
        let [weight, lift] = blend.share(number, at, place);
        Some(Light {
            place,
            weight,
            lift,
            black: blend.black(place),
        })
    };
    let rows = (0..rows).into_par_iter();
    rows.flat_map_iter(|row| (0..columns).map(move |column| light(column, row)))
        .collect()
}

/// Returns the light of all projectors' black at each pixel as a mean with its neighbours', so that
/// the edges of other pictures need not be met to the pixel: binomial, over five columns and rows.
fn blurred(lights: &[Option<Light>], columns: usize) -> Vec<f64> {
    const WEIGHTS: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
    let black = |light: &Option<Light>| light.as_ref().map_or(f64::NAN, |light| light.black);
    let mut blacks: Vec<f64> = lights.iter().map(black).collect();
    let rows = lights.len() / columns;
    // Along rows, then along columns.
    for (step, count) in [(1, columns), (columns, rows)] {
        let mean = |index: usize| {
            let at = index / step % count;
            let near = WEIGHTS.into_iter().zip(0..).filter_map(|(weight, offset)| {
                let place = (at + offset)
                    .checked_sub(2)
                    .filter(|place| *place < count)?;
                let black = blacks[index + place * step - at * step];
                (!black.is_nan()).then_some((weight * black, weight))
            });
            let add = |(sum, all), (black, weight)| (sum + black, all + weight);
            let (sum, weights) = near.fold((0.0, 0.0), add);
            if blacks[index].is_nan() {
                f64::NAN
            } else {
                sum / weights
            }
        };
        blacks = (0..blacks.len()).into_par_iter().map(mean).collect();
    }
    blacks
}

/// Returns the pixel before a place, 0 to 1 along a side of the picture, and how far it is from that
/// pixel's centre to the next one's: 255ths. Outside the centres the outermost ones go on.
fn between(share: f64, pixels: u32) -> (u32, u8) {
    let place = (share * f64::from(pixels) - 0.5).clamp(0.0, f64::from(pixels - 1));
    let first = (place as u32).min(pixels - 2);
    let share = 255.0 * (place - f64::from(first));
    (first, share.round_ties_even() as u8)
}
