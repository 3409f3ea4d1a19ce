//! The walls of one eye unfolded into a net, to see all of them at once and across their seams.
//! A dome's master lies beside them, scaled to the net along its meridians, and an unrolled cylinder.

use crate::cave::{Screen, Wall, WallPlane};
use crate::picture::Picture;
use crate::picture::glyph::{GLYPH, dots};
use crate::show::ShowError;
use glam::{DAffine2, DMat2, DVec2, DVec3};
use std::collections::VecDeque;

/// Behind the walls: opaque linear dark grey.
pub const BACKGROUND: [f32; 4] = [0.02, 0.02, 0.02, 1.0];
const BORDER: [f32; 4] = [0.25, 0.25, 0.25, 1.0];
const BORDER_WIDTH: f64 = 1.0;
const MARGIN: f64 = 16.0;

/// The largest gap of a shared corner as a part of its edge: calibrated walls leave gaps.
const SHARED_CORNER: f64 = 0.01;
/// Rotations this near to a quarter turn, in radians, are snapped to it.
const QUARTER_TURN: f64 = 1e-6;
/// Points this near to a pixel centre, in pixels, are on it and are copied.
const PIXEL_CENTRE: f64 = 1e-3;
const MAX_SAMPLES: f64 = 16.0;

struct Sheet<'a> {
    name: &'a str,
    picture: &'a Picture,
    /// The corners in the room, counterclockwise; `None` for curved screens, which share no edge.
    corners: Option<[DVec3; 4]>,
    /// A dome's picture is a disc.
    is_round: bool,
    outline: [DVec2; 4],
}

impl<'a> Sheet<'a> {
    fn new(screen: Screen<'a>, picture: &'a Picture, scale: f64) -> Result<Self, ShowError> {
        match screen {
            Screen::Wall(wall) => Self::of_wall(wall, picture, scale),
            Screen::Dome(dome) => {
                let side = dome.width() * scale;
                Ok(Self::curved(screen, picture, [side; 2]))
            }
            Screen::Cylinder(cylinder) => {
                let [low, high] = cylinder.height;
                let size = [cylinder.width() * scale, (high - low) * scale];
                Ok(Self::curved(screen, picture, size))
            }
        }
    }

    fn curved(screen: Screen<'a>, picture: &'a Picture, [width, height]: [f64; 2]) -> Self {
        let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)];
        Self {
            name: screen.name(),
            picture,
            corners: None,
            is_round: matches!(screen, Screen::Dome(_)),
            outline: corners.map(DVec2::from),
        }
    }

    fn of_wall(wall: &'a Wall, picture: &'a Picture, scale: f64) -> Result<Self, ShowError> {
        let plane = WallPlane::new(wall)?;
        let along = plane.right.normalize();
        let width = plane.right.length() * scale;
        let skew = -plane.down.dot(along) * scale;
        let height = plane.down.reject_from_normalized(along).length() * scale;
        Ok(Self {
            name: &wall.name,
            picture,
            corners: Some(plane.corners()),
            is_round: false,
            outline: [
                DVec2::ZERO,
                DVec2::new(width, 0.0),
                DVec2::new(width + skew, height),
                DVec2::new(skew, height),
            ],
        })
    }

    /// Returns whether a place, 0 to 1, is in the picture grown by some pixels: a dome's is round.
    fn is_inside(&self, at: DVec2, grow: f64) -> bool {
        let side = self.outline[1].x;
        !self.is_round || (2.0 * at - 1.0).length() <= 1.0 + 2.0 * grow / side
    }

    fn edge_lengths(&self) -> impl Iterator<Item = f64> {
        edges().map(|(from, to)| self.outline[from].distance(self.outline[to]))
    }
}

fn edges() -> impl Iterator<Item = (usize, usize)> + Clone {
    (0..4).map(|corner| (corner, (corner + 1) % 4))
}

/// Where a sheet lies in the net: turned, then moved.
type Placement = DAffine2;

fn outline(placement: &Placement, sheet: &Sheet) -> [DVec2; 4] {
    sheet
        .outline
        .map(|corner| placement.transform_point2(corner))
}

/// Returns the placement of a sheet beside a placed one; `None` where they share no edge.
fn folded(from: &Placement, placed: &Sheet, sheet: &Sheet) -> Option<Placement> {
    let (placed_corners, corners) = (placed.corners?, sheet.corners?);
    let placed_outline = outline(from, placed);
    edges().find_map(|(from, to)| {
        let along = placed_corners[to] - placed_corners[from];
        let slack = SHARED_CORNER * along.length();
        // The place of a corner along the edge, 0 to 1; `None` off its line.
        let place = |corner: DVec3| {
            let from_start = corner - placed_corners[from];
            let place = from_start.dot(along) / along.length_squared();
            ((from_start - place * along).length() <= slack).then_some(place)
        };
        // Seen from inside, two walls run along their edge in opposite directions.
        let (first, last, begin, end) = edges().find_map(|(first, last)| {
            let (begin, end) = (place(corners[last])?, place(corners[first])?);
            let shared = end.min(1.0) - begin.max(0.0);
            (shared > SHARED_CORNER).then_some((first, last, begin, end))
        })?;
        // Snaps corners that nearly coincide.
        let snapped = |place: f64, to: f64| {
            let is_near = (place - to).abs() <= SHARED_CORNER;
            if is_near { to } else { place }
        };
        let on_edge = |place: f64| placed_outline[from].lerp(placed_outline[to], place);
        let (start, end) = (on_edge(snapped(begin, 0.0)), on_edge(snapped(end, 1.0)));
        let edge = sheet.outline[first] - sheet.outline[last];
        let turn = DVec2::new(edge.x, -edge.y).rotate(end - start);
        let rotation = snapped_to_quarter(turn.normalize_or(DVec2::X));
        let middle = 0.5 * (sheet.outline[first] + sheet.outline[last]);
        let origin = 0.5 * (start + end) - rotation.rotate(middle);
        let matrix = DMat2::from_cols(rotation, rotation.perp());
        Some(Placement::from_mat2_translation(matrix, origin))
    })
}

fn snapped_to_quarter(rotation: DVec2) -> DVec2 {
    let mut quarters = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].into_iter();
    let near = quarters.find(|quarter| quarter.distance(rotation) < QUARTER_TURN);
    near.unwrap_or(rotation)
}

/// Unfolds screens as the viewer inside sees them, with their pictures.
///
/// The wall named `front`, or else the first, lies upright. Every wall that touches a placed one
/// along an edge or part of it is folded flat about that edge, nearest walls first. A wall that
/// touches none, or whose place is taken, and curved screens lie upright to the right of the others.
///
/// The net has the pixels per metre of the first placed screen. Pictures of that scale at whole
/// pixels and quarter turns are copied bit for bit. Names stand in the walls' upper left corners.
///
/// # Errors
/// No wall, a wall without area, a picture without pixels, or a net larger than a picture may be.
pub fn unfold<'a, S>(screens: &[(S, &'a Picture)]) -> Result<Picture, ShowError>
where
    S: Into<Screen<'a>> + Copy,
{
    let screens: Vec<(Screen<'_>, _)> = screens.iter().map(|one| (one.0.into(), one.1)).collect();
    let mut names = screens.iter().map(|(screen, _)| screen.name());
    let first = names.position(|name| name == "front").unwrap_or(0);
    let &(screen, picture) = screens.get(first).ok_or(ShowError::NoWalls)?;
    let across = match screen {
        Screen::Wall(wall) => WallPlane::new(wall)?.right.length(),
        Screen::Dome(dome) => dome.width(),
        Screen::Cylinder(cylinder) => cylinder.width(),
    };
    let scale = f64::from(picture.width) / across;
    let sheets = screens.iter().map(|&(screen, picture)| {
        if picture.width == 0 || picture.height == 0 || picture.pixels.is_empty() {
            return Err(ShowError::EmptyPicture(screen.name().to_owned()));
        }
        Sheet::new(screen, picture, scale)
    });
    let sheets = sheets.collect::<Result<Vec<_>, _>>()?;
    draw(&sheets, &arrange(&sheets, first))
}

fn arrange(sheets: &[Sheet], first: usize) -> Vec<Placement> {
    let mut placements: Vec<Option<Placement>> = vec![None; sheets.len()];
    let mut bounds: Option<(DVec2, DVec2)> = None;
    for root in std::iter::once(first).chain(0..sheets.len()) {
        if placements[root].is_some() {
            continue;
        }
        let piece = unfold_piece(sheets, root, &placements);
        let corners = piece
            .iter()
            .flat_map(|(index, place)| outline(place, &sheets[*index]));
        let (low, high) = bounds_of(corners);
        // By whole pixels, so that pictures can still be copied.
        let shift = bounds.map_or(DVec2::ZERO, |(_, taken)| {
            DVec2::new(taken.x - low.x + MARGIN, taken.y - high.y).round()
        });
        for (index, mut placement) in piece {
            placement.translation += shift;
            placements[index] = Some(placement);
        }
        let (low, high) = (low + shift, high + shift);
        bounds = Some(bounds.map_or((low, high), |(lowest, highest)| {
            (lowest.min(low), highest.max(high))
        }));
    }
    placements
        .into_iter()
        .map(Option::unwrap_or_default)
        .collect()
}

/// Returns the sheets that are connected with `root`, breadth first.
fn unfold_piece(
    sheets: &[Sheet],
    root: usize,
    taken: &[Option<Placement>],
) -> Vec<(usize, Placement)> {
    let mut piece = vec![(root, Placement::IDENTITY)];
    let mut queue = VecDeque::from(piece.clone());
    while let Some((parent, placed)) = queue.pop_front() {
        for (index, sheet) in sheets.iter().enumerate() {
            if taken[index].is_some() || piece.iter().any(|&(other, _)| other == index) {
                continue;
            }
            let Some(placement) = folded(&placed, &sheets[parent], sheet) else {
                continue;
            };
            let mut others = piece.iter().map(|(other, place)| (&sheets[*other], place));
            if others.all(|other| !overlap((sheet, &placement), other)) {
                piece.push((index, placement));
                queue.push_back((index, placement));
            }
        }
    }
    piece
}

fn bounds_of(corners: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    corners.fold(
        (DVec2::INFINITY, DVec2::NEG_INFINITY),
        |(low, high), corner| (low.min(corner), high.max(corner)),
    )
}

/// Returns whether two sheets overlap by more than the gap of a shared corner.
fn overlap(a: (&Sheet, &Placement), b: (&Sheet, &Placement)) -> bool {
    let shortest = a.0.edge_lengths().chain(b.0.edge_lengths());
    let slack = SHARED_CORNER * shortest.fold(f64::INFINITY, f64::min);
    let outlines = [outline(a.1, a.0), outline(b.1, b.0)];
    let separated = outlines.iter().any(|outline| {
        edges().any(|(from, to)| {
            let normal = (outline[to] - outline[from]).perp().normalize_or_zero();
            let [(low_a, high_a), (low_b, high_b)] = outlines.map(|corners| {
                let along = corners.map(|corner| corner.dot(normal));
                let low = along.into_iter().fold(f64::INFINITY, f64::min);
                (low, along.into_iter().fold(f64::NEG_INFINITY, f64::max))
            });
            high_a <= low_b + slack || high_b <= low_a + slack
        })
    });
    !separated
}

struct Canvas {
    picture: Picture,
    upper_left: DVec2,
}

impl Canvas {
    fn pixel_from_net(&self, point: DVec2) -> DVec2 {
        DVec2::new(point.x - self.upper_left.x, self.upper_left.y - point.y)
    }

    fn net_from_pixel(&self, point: DVec2) -> DVec2 {
        DVec2::new(self.upper_left.x + point.x, self.upper_left.y - point.y)
    }

    /// Colours every pixel whose centre is in a sheet's outline grown by some pixels, by its place.
    fn fill(
        &mut self,
        sheet: &Sheet,
        placement: &Placement,
        grow: f64,
        colour: impl Fn(DVec2) -> [f32; 4],
    ) {
        let [_, right, _, up] = sheet.outline;
        let slack = DVec2::new(grow / right.x, grow / up.y) + 1e-9;
        let corners = outline(placement, sheet).map(|corner| self.pixel_from_net(corner));
        let (low, high) = bounds_of(corners.into_iter());
        // Turned sheets grow past the bounds of their outline by at most their diagonal.
        let reach = 2.0 * grow;
        let columns =
            (low.x - reach) as u32..((high.x + reach).ceil() as u32).min(self.picture.width);
        let rows =
            (low.y - reach) as u32..((high.y + reach).ceil() as u32).min(self.picture.height);
        for y in rows {
            for x in columns.clone() {
                let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                // A rotation's transpose is its inverse.
                let point = self.net_from_pixel(centre) - placement.translation;
                let point = placement.matrix2.transpose() * point;
                let y_up = point.y / up.y;
                let at = DVec2::new((point.x - y_up * up.x) / right.x, 1.0 - y_up);
                let inside = at.cmpge(-slack).all() && at.cmple(1.0 + slack).all();
                if inside && sheet.is_inside(at, grow) {
                    self.picture.set_pixel(x, y, colour(at));
                }
            }
        }
    }
}

fn draw(sheets: &[Sheet], placements: &[Placement]) -> Result<Picture, ShowError> {
    let placed = || sheets.iter().zip(placements);
    let corners = placed().flat_map(|(sheet, placement)| outline(placement, sheet));
    let (low, high) = bounds_of(corners);
    // Whole pixels from the first wall's corner, without one more for a rounding error.
    let low = (low + PIXEL_CENTRE).floor() - MARGIN;
    let high = (high - PIXEL_CENTRE).ceil() + MARGIN;
    let size = high - low;
    let mut canvas = Canvas {
        picture: Picture::new(size.x as u32, size.y as u32)?,
        upper_left: DVec2::new(low.x, high.y),
    };
    canvas.picture.pixels.fill(BACKGROUND);
    // Borders first, so that pictures meet without a line.
    for (sheet, placement) in placed() {
        canvas.fill(sheet, placement, BORDER_WIDTH, |_| BORDER);
    }
    for (sheet, placement) in placed() {
        canvas.fill(sheet, placement, 0.0, resample(sheet));
    }
    for (sheet, placement) in placed() {
        let outline = outline(placement, sheet).map(|corner| canvas.pixel_from_net(corner));
        let (low, high) = bounds_of(outline.into_iter());
        // The corner of an oblique wall's bounds is outside the wall.
        let oblique = outline.iter().any(|corner| {
            let from_low = (*corner - low).abs();
            let from_high = (*corner - high).abs();
            from_low.min(from_high).max_element() > 1.0
        });
        label(&mut canvas.picture, sheet.name, low, high, oblique);
    }
    Ok(canvas.picture)
}

/// Returns the colours of a sheet's picture by place, 0 to 1 from the upper left corner.
fn resample<'a>(sheet: &Sheet<'a>) -> impl Fn(DVec2) -> [f32; 4] + use<'a> {
    let picture = sheet.picture;
    let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
    let [_, right, _, up] = sheet.outline;
    // Columns and rows of the picture in one pixel of the net.
    let footprint = size / DVec2::new(right.x, up.length());
    let samples = (footprint - PIXEL_CENTRE).ceil();
    let samples = samples.clamp(DVec2::ONE, DVec2::splat(MAX_SAMPLES));
    move |at| {
        let at = at * size;
        if samples == DVec2::ONE {
            let centre = at.floor() + 0.5;
            return if (at - centre).abs().max_element() < PIXEL_CENTRE {
                picture.pixel(at.x as u32, at.y as u32).unwrap_or_default()
            } else {
                picture.sample(at.x, at.y)
            };
        }
        let mut sum = [0.0_f64; 4];
        for row in 0..samples.y as u32 {
            for column in 0..samples.x as u32 {
                let step = DVec2::new(f64::from(column), f64::from(row)) + 0.5;
                let point = at + (step / samples - 0.5) * footprint;
                let pixel = picture.sample(point.x, point.y);
                for (sum, channel) in sum.iter_mut().zip(pixel) {
                    *sum += f64::from(channel);
                }
            }
        }
        sum.map(|sum| (sum / (samples.x * samples.y)) as f32)
    }
}

/// A wall's shorter side in pixels of a glyph.
const GLYPH_SIDE: f64 = 240.0;
const MAX_SCALE: f64 = 8.0;

const TEXT: [f32; 4] = [0.9, 0.9, 0.9, 1.0];
const OUTLINE: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Writes a name into the upper left corner of a rectangle, or its middle, as far as it fits.
fn label(picture: &mut Picture, name: &str, low: DVec2, high: DVec2, centred: bool) {
    let size = high - low;
    let scale = (size.min_element() / GLYPH_SIDE)
        .round()
        .clamp(1.0, MAX_SCALE) as u32;
    let advance = f64::from(GLYPH * scale);
    // The outline stays inside, too.
    let margin = f64::from(scale);
    let fitting = ((size.x - 2.0 * margin) / advance).max(0.0) as usize;
    let name: String = name.chars().take(fitting).collect();
    let text = DVec2::new(advance * name.chars().count() as f64, advance);
    let start = if centred {
        0.5 * (low + high - text)
    } else {
        low + 3.0 * margin
    };
    let start = start.min(high - text - margin).max(low);
    let (left, top) = (start.x.round() as u32, start.y.round() as u32);

    // The outlines first: letters are not to cover each other.
    let reach = scale.div_ceil(2);
    for (grow, colour) in [(reach, OUTLINE), (0, TEXT)] {
        for (column, row) in dots(&name) {
            let place = [left + column * scale, top + row * scale];
            let [x, y] = place.map(|start| start.saturating_sub(grow));
            square(picture, x, y, scale + 2 * grow, colour);
        }
    }
}

fn square(picture: &mut Picture, left: u32, top: u32, side: u32, colour: [f32; 4]) {
    for y in top..top.saturating_add(side) {
        for x in left..left.saturating_add(side) {
            picture.set_pixel(x, y, colour);
        }
    }
}

#[cfg(test)]
mod tests;
