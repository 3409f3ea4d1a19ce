//! A room drawn to scale: plan, elevations, and a table of its screens.
//!
//! [`Plan::svg`] draws an A4 page. Angles are the fields of view of the screens from the middle of
//! the viewer's eyes.

mod beam;
mod shape;
mod sheet;
mod table;

pub use beam::Beam;

use super::look::ViewBasis;
use super::{Cave, Screen};
use glam::{DVec2, DVec3};
use shape::{Layer, surface};
use sheet::{Anchor, Sheet};
use table::Table;

/// A room, its viewer, and what is to be said of them.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The title.
    pub title: &'a str,
    /// The room.
    pub cave: &'a Cave,
    /// The viewer's eyes, left and right: metres, in the room.
    pub eyes: [DVec3; 2],
    /// Where the viewer looks.
    pub look: ViewBasis,
    /// The room's projectors.
    pub beams: &'a [Beam<'a>],
    /// Sentences below the table.
    pub remarks: &'a [String],
}

/// A direction from which the room is drawn.
#[derive(Debug, Clone, Copy)]
struct Side {
    name: &'static str,
    /// To the page's right.
    right: DVec3,
    /// To the page's top.
    up: DVec3,
}

impl Side {
    const PLAN: Self = Self {
        name: "Plan: from above, the front is up",
        right: DVec3::X,
        up: DVec3::NEG_Z,
    };
    const FRONT: Self = Self {
        name: "Elevation: looking to the front",
        right: DVec3::X,
        up: DVec3::Y,
    };
    const RIGHT: Self = Self {
        name: "Elevation: looking to the right, the front is left",
        right: DVec3::Z,
        up: DVec3::Y,
    };

    fn place(self, point: DVec3) -> DVec2 {
        DVec2::new(point.dot(self.right), point.dot(self.up))
    }

    /// Returns how much a direction points to who looks at the page: 1 straight, −1 away.
    fn towards(self, direction: DVec3) -> f64 {
        direction.dot(self.right.cross(self.up))
    }

    /// Returns the largest coordinates of points and the smallest.
    fn extent(self, points: &[DVec3]) -> [DVec2; 2] {
        let places = points.iter().map(|&point| self.place(point));
        places.fold(
            [DVec2::INFINITY, DVec2::NEG_INFINITY],
            |[least, most], place| [least.min(place), most.max(place)],
        )
    }
}

/// Where a side of the room is on the page.
#[derive(Debug, Clone, Copy)]
struct Frame {
    side: Side,
    /// The room's extent, metres.
    extent: [DVec2; 2],
    /// The extent's upper left corner on the page, millimetres.
    corner: DVec2,
    /// Millimetres a metre.
    scale: f64,
}

impl Frame {
    fn at(&self, point: DVec3) -> DVec2 {
        self.on_page(self.side.place(point))
    }

    fn on_page(&self, place: DVec2) -> DVec2 {
        let [least, most] = self.extent;
        self.corner + self.scale * DVec2::new(place.x - least.x, most.y - place.y)
    }

    fn size(&self) -> DVec2 {
        self.scale * (self.extent[1] - self.extent[0])
    }
}

impl Plan<'_> {
    /// Margin of the page, and between what is drawn, millimetres.
    const MARGIN: f64 = 12.0;
    const GAP: f64 = 24.0;
    /// Where the drawings begin below the title, and end.
    const TOP: f64 = 36.0;
    const BOTTOM: f64 = 192.0;
    /// Least width of the table.
    const TABLE: f64 = 104.0;
    /// Denominators of the page's scale, times powers of ten.
    const SCALES: [f64; 9] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5];

    /// Returns the page.
    pub fn svg(&self) -> String {
        let points = self.points();
        let sides = [Side::PLAN, Side::FRONT, Side::RIGHT];
        let [plan, front, right] = sides.map(|side| side.extent(&points));
        let [width, depth] = (plan[1] - plan[0]).to_array();
        let height = front[1].y - front[0].y;
        let denominator = denominator(width, depth, height);
        let scale = 1000.0 / denominator;
        let mut sheet = Sheet::new();
        let left = Self::MARGIN + 8.0;
        let below = Self::TOP + scale * depth + Self::GAP;
        let beside = left + scale * width + Self::GAP;
        for (side, extent, corner) in [
            (Side::PLAN, plan, DVec2::new(left, Self::TOP)),
            (Side::FRONT, front, DVec2::new(left, below)),
            (Side::RIGHT, right, DVec2::new(beside, below)),
        ] {
            let frame = Frame {
                side,
                extent,
                corner,
                scale,
            };
            self.draw(&frame, &mut sheet);
        }
        let title = DVec2::new(Self::MARGIN, 17.0);
        sheet.text(title, Anchor::Start, "title", self.title);
        let table = beside.max(Sheet::SIZE.x - Self::MARGIN - 1.35 * Self::TABLE);
        let corner = DVec2::new(table, Self::TOP - 8.0);
        Table::new(corner, below - 14.0, &mut sheet).write(self);
        scale_bar(denominator, &mut sheet);
        sheet.finish()
    }

    /// Returns points that the drawings have to hold.
    fn points(&self) -> Vec<DVec3> {
        let mut points: Vec<DVec3> = self.eyes.to_vec();
        for screen in self.cave.screens() {
            points.extend(surface(screen));
        }
        points.extend(self.beams.iter().filter_map(Beam::lens));
        points
    }

    fn middle(&self) -> DVec3 {
        self.eyes[0].midpoint(self.eyes[1])
    }

    fn draw(&self, frame: &Frame, sheet: &mut Sheet) {
        let [size, corner] = [frame.size(), frame.corner];
        let name = corner + DVec2::new(0.5 * size.x, -9.0);
        sheet.text(name, Anchor::Middle, "side", frame.side.name);
        grid(frame, sheet);
        let colours: Vec<_> = self.cave.screens().zip(sheet::colours()).collect();
        // What is cut away lies below, edges above.
        for layer in [Layer::Cut, Layer::Face, Layer::Edge] {
            for (screen, colour) in &colours {
                shape::draw(*screen, frame, layer, colour, sheet);
            }
        }
        for (screen, colour) in &colours {
            self.field(*screen, frame, colour, sheet);
        }
        for (screen, colour) in &colours {
            shape::write_name(*screen, frame, colour, sheet);
        }
        for beam in self.beams {
            beam.draw(frame, sheet);
        }
        self.viewer(frame, sheet);
    }

    /// Draws the field of a screen that is seen from its edge.
    fn field(&self, screen: Screen<'_>, frame: &Frame, colour: &str, sheet: &mut Sheet) {
        let field = screen.field_from(self.middle());
        let (Some([across, upward]), Some(seen)) = (field, shape::edge_on(screen, frame)) else {
            return;
        };
        let eye = frame.at(self.middle());
        let degrees = if seen.is_width { across } else { upward };
        sheet.wedge(eye, seen.ends, colour);
        let reach = seen.middle - eye;
        if reach.length() > 8.0 {
            let place = eye + (0.45 * reach).clamp_length_max(13.0) + DVec2::Y;
            let text = format!("{degrees:.1}°");
            sheet.coloured_text(place, Anchor::Middle, colour, 0.0, &text);
        }
    }

    fn viewer(&self, frame: &Frame, sheet: &mut Sheet) {
        let middle = frame.at(self.middle());
        let nose = frame.side.place(self.look.forward) * DVec2::new(1.0, -1.0);
        let radius = (0.1 * frame.scale).max(1.5);
        sheet.circle(middle, radius, "head");
        sheet.line(middle + radius * nose, middle + 2.2 * radius * nose, "look");
        for eye in self.eyes {
            sheet.circle(frame.at(eye), (0.012 * frame.scale).max(0.35), "eye");
        }
    }
}

/// Returns the denominator of the scale at which a room fits the page: its size is in metres.
fn denominator(width: f64, depth: f64, height: f64) -> f64 {
    let high = Plan::BOTTOM - Plan::TOP - Plan::GAP;
    let wide = Sheet::SIZE.x - 2.0 * Plan::MARGIN - 16.0;
    let beside = (wide - Plan::GAP) / (width + depth);
    let table = (wide - Plan::GAP - Plan::TABLE) / width;
    let most = (high / (depth + height)).min(beside).min(table);
    let least = 1000.0 / most.min(1.0e6);
    let power = 10f64.powf(least.log10().floor());
    let scales = Plan::SCALES.into_iter().chain([10.0]);
    let mut fitting = scales.map(|scale| scale * power);
    fitting
        .find(|&scale| scale >= least)
        .unwrap_or(10.0 * power)
}

/// Returns the least length of a grid that is 8 mm on the page: metres.
fn grid_step(millimetres_a_metre: f64) -> f64 {
    let least = 8.0 / millimetres_a_metre;
    let power = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let mut steps = steps.into_iter();
    steps.find(|&step| step >= least).unwrap_or(10.0 * power)
}

fn grid(frame: &Frame, sheet: &mut Sheet) {
    let step = grid_step(frame.scale);
    let [least, most] = frame.extent;
    for axis in 0..2 {
        let (first, last) = ((least[axis] / step).floor(), (most[axis] / step).ceil());
        for number in first as i64..=last as i64 {
            let mut ends = [least, most];
            let along = step * number as f64;
            if !(least[axis] - 1.0e-6..=most[axis] + 1.0e-6).contains(&along) {
                continue;
            }
            for end in &mut ends {
                end[axis] = along;
            }
            let class = if number == 0 { "axis" } else { "grid" };
            let [from, to] = ends.map(|end| frame.on_page(end));
            sheet.line(from, to, class);
        }
    }
}

/// Draws a bar whose length on the page stands for a whole length in the room.
fn scale_bar(denominator: f64, sheet: &mut Sheet) {
    let scale = 1000.0 / denominator;
    let step = grid_step(scale);
    let start = DVec2::new(Plan::MARGIN, Sheet::SIZE.y - Plan::MARGIN);
    let at = |part: f64| start + part * step * scale * DVec2::X;
    // Steps are 1, 2 or 5 times a power of ten: without the last bits of products.
    let length = |part: f64| (part * step * 1.0e9).round() / 1.0e9;
    for part in 0..4 {
        sheet.bar(at(f64::from(part)), step * scale, part % 2 == 0);
    }
    for (part, unit) in [(0.0, ""), (2.0, ""), (4.0, " m")] {
        let text = format!("{}{unit}", length(part));
        sheet.text(at(part) - 1.6 * DVec2::Y, Anchor::Middle, "note", &text);
    }
    let text = format!("1 : {denominator} on A4, grid {} m", length(1.0));
    sheet.text(at(4.0) + DVec2::new(7.0, 1.2), Anchor::Start, "note", &text);
}
