//! The walls and the overlays on them.

use super::canvas::{Canvas, Colour, Rect};
use super::place_map::{Place, PlaceMap};
use super::{Frame, TEXT};
use crate::cave::Cave;
use crate::live::Quality;
use crate::picture::srgb_from_linear;
use crate::show::stereo::{Stereo, anaglyph};
use colorous::{Gradient, PLASMA, VIRIDIS};
use glam::Vec3;
use shisen_core::frame::View;
use shisen_core::gaze::Gaze;

/// Pixels on a side of a block that shares a direction and a level.
const BLOCK: u32 = 4;

const COVERED: f32 = 0.55;

const OUTSIDE: [f32; 3] = [0.02, 0.02, 0.02];

/// The cosine of the largest angle (2°) between the line of sight and the mark of the gaze.
const NEAR: f32 = 0.999_390_8;

pub(super) struct Codes {
    srgb: Vec<u8>,
    levels: Vec<[f32; 3]>,
    ranks: Vec<[f32; 3]>,
}

impl Codes {
    /// A step is a twentieth of the least step of a code, so codes are off by at most one.
    const STEPS: f32 = 65_535.0;

    pub(super) fn new() -> Self {
        let steps = 0..=Self::STEPS as u32;
        let srgb = steps.map(|step| srgb_from_linear(step as f32 / Self::STEPS));
        Self {
            srgb: srgb.collect(),
            levels: gradient(VIRIDIS),
            // The first tile is the brightest.
            ranks: gradient(PLASMA).into_iter().rev().collect(),
        }
    }

    fn code(&self, linear: f32) -> u8 {
        let step = (linear * Self::STEPS + 0.5).min(Self::STEPS) as usize;
        self.srgb.get(step).copied().unwrap_or_default()
    }

    fn colour(&self, linear: [f32; 3]) -> Colour {
        linear.into_iter().fold(0, |colour, channel| {
            (colour << 8) | Colour::from(self.code(channel))
        })
    }

    /// Returns the colour of a level: dark violet at 0 to yellow at 1, dark grey where nothing is
    /// traced.
    fn level(&self, level: f32) -> [f32; 3] {
        if level > 0.0 {
            at(&self.levels, level)
        } else {
            OUTSIDE
        }
    }
}

fn gradient(gradient: Gradient) -> Vec<[f32; 3]> {
    let light = |code: u8| (f32::from(code) / 255.0).powf(2.2);
    (0..256)
        .map(|step| gradient.eval_continuous(f64::from(step) / 255.0))
        .map(|colour| [light(colour.r), light(colour.g), light(colour.b)])
        .collect()
}

/// Returns the colour of a gradient at a part, 0 to 1.
fn at(gradient: &[[f32; 3]], part: f32) -> [f32; 3] {
    let step = (part * 255.0 + 0.5).min(255.0) as usize;
    gradient.get(step).copied().unwrap_or_default()
}

/// The rank of each tile in the order of dealing, 0 for the first to 1 for the last.
#[derive(Debug, Default)]
pub(super) struct Ranks {
    side: u32,
    /// By picture: the number of tiles in a row, and the ranks in rows.
    pictures: Vec<(u32, Vec<f32>)>,
}

impl Ranks {
    pub(super) fn set(&mut self, frame: &Frame) {
        let tiles = &frame.tiles;
        let side = tiles.iter().map(|(_, tile)| tile.width.max(tile.height));
        self.side = side.max().unwrap_or(1).max(1);
        self.pictures.clear();
        for picture in &frame.pictures {
            let columns = picture.width.div_ceil(self.side);
            let rows = picture.height.div_ceil(self.side);
            let none = vec![1.0; columns as usize * rows as usize];
            self.pictures.push((columns, none));
        }
        let last = tiles.len().saturating_sub(1).max(1) as f32;
        for (rank, (picture, tile)) in tiles.iter().enumerate() {
            if let Some((columns, ranks)) = self.pictures.get_mut(*picture) {
                let index = tile.y / self.side * *columns + tile.x / self.side;
                if let Some(one) = ranks.get_mut(index as usize) {
                    *one = rank as f32 / last;
                }
            }
        }
    }

    fn rank(&self, picture: usize, x: u32, y: u32) -> Option<f32> {
        let (columns, ranks) = self.pictures.get(picture)?;
        let index = y / self.side * columns + x / self.side;
        ranks.get(index as usize).copied()
    }
}

#[derive(Clone, Copy)]
pub(super) struct Overlay<'r> {
    pub(super) levels: bool,
    pub(super) ranks: Option<&'r Ranks>,
}

pub(super) struct Area {
    pub(super) rect: Rect,
    eye: usize,
    shown: PlaceMap,
    is_net: bool,
    blocks: Vec<Option<(Vec3, f32)>>,
}

impl Area {
    pub(super) fn new(rect: Rect, eye: usize, shown: PlaceMap, is_net: bool) -> Self {
        Self {
            rect,
            eye,
            shown,
            is_net,
            blocks: Vec::new(),
        }
    }

    pub(super) fn is_net(&self, rect: Rect, eye: usize) -> bool {
        self.is_net && self.rect == rect && self.eye == eye
    }

    pub(super) fn contains(&self, x: u32, y: u32) -> bool {
        let within = |at: u32, start: u32, count: u32| at >= start && at - start < count;
        within(x, self.rect.x, self.rect.width) && within(y, self.rect.y, self.rect.height)
    }

    const fn columns(&self) -> u32 {
        self.rect.width.div_ceil(BLOCK)
    }

    pub(super) fn look(&mut self, cave: &Cave, frame: &Frame) {
        let views = (0..cave.screens().count()).map(|screen| frame.view_of(cave, screen, self.eye));
        let views: Vec<_> = views.collect();
        let view = |screen: usize| views.get(screen).copied().flatten();
        let gaze = gaze_of(frame, self.eye);
        let (columns, rows) = (self.columns(), self.rect.height.div_ceil(BLOCK));
        self.blocks.clear();
        let middle =
            |block: u32, count: u32| (block * BLOCK + BLOCK / 2).min(count.saturating_sub(1));
        self.blocks.extend((0..rows * columns).map(|block| {
            let x = middle(block % columns, self.rect.width);
            let y = middle(block / columns, self.rect.height);
            let direction = towards(view, self.shown.place(x, y)?)?;
            let level = |gaze: &Gaze| gaze.level(direction).unwrap_or(0.0);
            Some((direction, gaze.as_ref().map_or(1.0, level)))
        }));
    }

    fn level(&self, x: u32, y: u32) -> Option<f32> {
        let index = y / BLOCK * self.columns() + x / BLOCK;
        let block = self.blocks.get(index as usize).copied().flatten();
        block.map(|(_, level)| level)
    }

    /// Returns the place on the canvas that shows a direction, to a block; `None` where none does.
    pub(super) fn place_of(&self, direction: Vec3) -> Option<(u32, u32)> {
        let wanted = direction.normalize_or_zero();
        let cosines = self.blocks.iter().enumerate().filter_map(|(index, block)| {
            let (direction, _) = (*block)?;
            Some((direction.dot(wanted), index as u32))
        });
        let (cosine, index) = cosines.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let middle = |block: u32| block * BLOCK + BLOCK / 2;
        let (column, row) = (index % self.columns(), index / self.columns());
        (cosine >= NEAR).then(|| (self.rect.x + middle(column), self.rect.y + middle(row)))
    }

    pub(super) fn direction(&self, cave: &Cave, frame: &Frame, x: u32, y: u32) -> Option<Vec3> {
        let (x, y) = (x.checked_sub(self.rect.x)?, y.checked_sub(self.rect.y)?);
        let place = self.shown.place(x, y)?;
        towards(|screen| frame.view_of(cave, screen, self.eye), place)
    }

    /// Returns the light of a pixel; `Err` with a colour that is no light of a screen.
    fn light(
        &self,
        index: usize,
        frame: &Frame,
        overlay: Overlay<'_>,
        codes: &Codes,
    ) -> Result<[f32; 4], Colour> {
        let (screen, x, y) = match self.shown.places.get(index) {
            Some(&Place::Pixel { screen, x, y }) => (screen, u32::from(x), u32::from(y)),
            Some(&Place::Plain(colour)) => return Err(colour),
            None => return Err(0),
        };
        let number = usize::from(screen) * frame.eyes.len() + self.eye;
        let picture = frame.pictures.get(number);
        let [red, green, blue, alpha] = picture.and_then(|one| one.pixel(x, y)).unwrap_or_default();
        let mut light = [red, green, blue];
        let (index, width) = (index as u32, self.rect.width);
        if let Some(level) = self
            .level(index % width, index / width)
            .filter(|_| overlay.levels)
        {
            light = covered(light, codes.level(level));
        }
        if let Some(rank) = overlay.ranks.and_then(|ranks| ranks.rank(number, x, y)) {
            light = covered(light, at(&codes.ranks, rank));
        }
        let [red, green, blue] = light;
        Ok([red, green, blue, alpha])
    }
}

fn gaze_of(frame: &Frame, eye: usize) -> Option<Gaze> {
    let lod = frame.eyes.get(eye)?.lod?;
    let quality = Quality::LADDER.get(frame.record.rung);
    let lod = quality.map_or(lod, |quality| quality.narrow(lod));
    Some(lod.gaze)
}

fn towards(view: impl Fn(usize) -> Option<View>, place: Place) -> Option<Vec3> {
    let Place::Pixel { screen, x, y } = place else {
        return None;
    };
    let direction = view(usize::from(screen))?.direction(f32::from(x), f32::from(y))?;
    direction.try_normalize()
}

fn covered(light: [f32; 3], cover: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|channel| {
        let light = light[channel].clamp(0.0, 1.0);
        light + (cover[channel] - light) * COVERED
    })
}

pub(super) fn draw(
    canvas: &mut Canvas,
    areas: &[Area],
    frame: &Frame,
    overlay: Overlay<'_>,
    stereo: Stereo,
    codes: &Codes,
) {
    let light = |area: &Area, index| area.light(index, frame, overlay, codes);
    if let (Stereo::Anaglyph, [left, right]) = (stereo, areas) {
        let both = |index| Ok(anaglyph(light(left, index)?, light(right, index)?));
        each_pixel(canvas, left.rect, both, codes);
        return;
    }
    for area in areas {
        each_pixel(canvas, area.rect, |index| light(area, index), codes);
    }
}

fn each_pixel(
    canvas: &mut Canvas,
    rect: Rect,
    light: impl Fn(usize) -> Result<[f32; 4], Colour>,
    codes: &Codes,
) {
    let mut index = 0;
    for y in rect.y..rect.y + rect.height {
        for x in rect.x..rect.x + rect.width {
            let colour = match light(index) {
                Ok([red, green, blue, _]) => codes.colour([red, green, blue]),
                Err(plain) => plain,
            };
            canvas.set(x, y, colour);
            index += 1;
        }
    }
}

/// Marks the gaze with a white cross with a black border, clipped to a rectangle.
pub(super) fn mark(canvas: &mut Canvas, within: Rect, x: u32, y: u32) {
    for (reach, thick, colour) in [(11, 2, 0), (10, 1, 0xFF_FFFF)] {
        for (across, down) in [(reach, thick), (thick, reach)] {
            let left = x.saturating_sub(across).max(within.x);
            let top = y.saturating_sub(down).max(within.y);
            let right = (x + across + 1).min(within.x + within.width);
            let bottom = (y + down + 1).min(within.y + within.height);
            let (width, height) = (right.saturating_sub(left), bottom.saturating_sub(top));
            canvas.fill(Rect::new(left, top, width, height), colour);
        }
    }
}

pub(super) fn legend(canvas: &mut Canvas, within: Rect, codes: &Codes) {
    let y = (within.y + within.height).saturating_sub(16);
    let start = canvas.write(within.x + 8, y + 2, "level 0 ", TEXT);
    for step in 0..128 {
        let colour = codes.colour(at(&codes.levels, step as f32 / 127.0));
        canvas.fill(Rect::new(start + step, y, 1, 12), colour);
    }
    canvas.write(start + 136, y + 2, "1", TEXT);
}
