//! A room drawn to scale: plan, elevations, and a table of its screens.
//!
//! [`Plan::svg`] draws an A4 page. Angles are the fields of view of the screens from the middle of
//! the viewer's eyes.

mod sheet;

use super::look::ViewBasis;
use super::{Cave, Screen};
use glam::{DVec2, DVec3};
use sheet::{Anchor, Sheet};

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
        self.table(DVec2::new(table, Self::TOP - 8.0), below - 14.0, &mut sheet);
        scale_bar(denominator, &mut sheet);
        sheet.finish()
    }

    /// Returns points that the drawings have to hold.
    fn points(&self) -> Vec<DVec3> {
        let mut points: Vec<DVec3> = self.eyes.to_vec();
        for screen in self.cave.screens() {
            points.extend(surface(screen));
        }
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
                shape(*screen, frame, layer, colour, sheet);
            }
        }
        for (screen, colour) in &colours {
            self.field(*screen, frame, colour, sheet);
        }
        for (screen, colour) in &colours {
            name_of(*screen, frame, colour, sheet);
        }
        self.viewer(frame, sheet);
    }

    /// Draws the field of a wall that is seen from its edge.
    fn field(&self, screen: Screen<'_>, frame: &Frame, colour: &str, sheet: &mut Sheet) {
        let (Screen::Wall(wall), Some([across, upward])) =
            (screen, screen.field_from(self.middle()))
        else {
            return;
        };
        let eye = frame.at(self.middle());
        let Some((ends, is_width)) = edge_on(wall, frame) else {
            return;
        };
        let degrees = if is_width { across } else { upward };
        let directions = ends.map(|end| (end - eye).normalize_or_zero());
        sheet.wedge(eye, ends, colour);
        let middle = (directions[0] + directions[1]).normalize_or_zero();
        let reach = (ends[0].midpoint(ends[1]) - eye).length();
        let radius = (0.45 * reach).min(13.0);
        if reach > 8.0 {
            let place = eye + radius * middle + DVec2::new(0.0, 1.0);
            sheet.coloured_text(
                place,
                Anchor::Middle,
                colour,
                0.0,
                &format!("{degrees:.1}°"),
            );
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

    /// Draws the table of the screens with its upper left corner at `corner`, and the remarks, down
    /// to `bottom`.
    fn table(&self, corner: DVec2, bottom: f64, sheet: &mut Sheet) {
        let right = Sheet::SIZE.x - Self::MARGIN;
        let width = right - corner.x;
        let columns = [0.0, 0.46, 0.7, 1.0].map(|share| corner.x + share * width);
        let anchors = [Anchor::Start, Anchor::End, Anchor::End, Anchor::End];
        let mut y = corner.y;
        let mut row = |y: f64, cells: [&str; 4], class: &str| {
            for ((x, anchor), cell) in columns.into_iter().zip(anchors).zip(cells) {
                sheet.text(DVec2::new(x, y), anchor, class, cell);
            }
        };
        row(
            y,
            ["screen", "size", "pixels", "field from the eyes"],
            "heading",
        );
        let screens = self.cave.screens().count();
        let height = (0.7 * (bottom - y) / (screens as f64 + 1.0)).min(5.5);
        for screen in self.cave.screens() {
            y += height;
            let field = match screen.field_from(self.middle()) {
                Some([across, upward]) => format!("{across:.1}° × {upward:.1}°"),
                None => "not from its front".to_owned(),
            };
            let (size, pixels) = match screen {
                Screen::Wall(wall) => {
                    let [width, height] = [wall.across(), wall.upward()].map(DVec3::length);
                    let [columns, rows] = wall.pixels;
                    (
                        format!("{width:.3} × {height:.3} m"),
                        format!("{columns} × {rows}"),
                    )
                }
                Screen::Dome(dome) => (
                    format!("radius {:.3} m", dome.radius),
                    format!("{0} × {0}", dome.size),
                ),
            };
            row(y, [screen.name(), &size, &pixels, &field], "cell");
        }
        let rule = corner.y + 1.8;
        sheet.line(DVec2::new(corner.x, rule), DVec2::new(right, rule), "rule");
        let mut y = corner.y;
        for colour in sheet::colours().take(screens) {
            y += height;
            sheet.patch(DVec2::new(corner.x - 4.5, y - 2.2), &colour);
        }
        y += 3.0;
        let [x, up, z] = self
            .middle()
            .to_array()
            .map(|metres| (1e3 * metres).round() / 1e3 + 0.0);
        let viewer = format!("Viewer's eyes: {x:.3}, {up:.3}, {z:.3} m (right, up, back)");
        let letters = (width / 1.55) as usize;
        for remark in [viewer].iter().chain(self.remarks) {
            y += 1.5;
            for line in wrapped(remark, letters) {
                y += 3.9;
                if y > bottom {
                    let place = DVec2::new(corner.x, y);
                    sheet.text(
                        place,
                        Anchor::Start,
                        "note",
                        "… more in the command's report",
                    );
                    return;
                }
                sheet.text(DVec2::new(corner.x, y), Anchor::Start, "note", &line);
            }
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
            ends.iter_mut().for_each(|end| end[axis] = along);
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

/// Returns points all over a screen: metres, in the room.
fn surface(screen: Screen<'_>) -> Vec<DVec3> {
    match screen {
        Screen::Wall(wall) => wall.corners().to_vec(),
        Screen::Dome(dome) => {
            let rings = (0..=16).flat_map(|ring| around(f64::from(ring) / 16.0));
            rings.map(|place| dome.point(place)).collect()
        }
    }
}

/// Returns places on a ring of the unit disc, once round.
fn around(radius: f64) -> impl Iterator<Item = DVec2> {
    (0..=72).map(move |step| radius * DVec2::from_angle(f64::from(step).to_radians() * 5.0))
}

/// How a wall is seen, in the order of drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layer {
    /// From behind.
    Cut,
    /// From the front.
    Face,
    /// From its edge.
    Edge,
}

fn shape(screen: Screen<'_>, frame: &Frame, layer: Layer, colour: &str, sheet: &mut Sheet) {
    match screen {
        Screen::Wall(wall) => {
            let corners = wall.corners().map(|corner| frame.at(corner));
            let own = match frame.side.towards(wall.normal()) {
                ..-0.05 => Layer::Cut,
                0.05.. => Layer::Face,
                _ => Layer::Edge,
            };
            match layer {
                _ if layer != own => {}
                Layer::Cut => sheet.outline(&corners, colour, "cut"),
                Layer::Face => sheet.filled(&corners, colour),
                Layer::Edge => sheet.outline(&corners, colour, "edge"),
            }
        }
        Screen::Dome(_) if layer != Layer::Face => {}
        Screen::Dome(dome) => {
            let places: Vec<DVec2> = surface(screen).iter().map(|&one| frame.at(one)).collect();
            sheet.filled(&hull(places), colour);
            for ring in [1.0, 2.0 / 3.0, 1.0 / 3.0] {
                let line: Vec<DVec2> = around(ring).map(|at| frame.at(dome.point(at))).collect();
                let class = if ring == 1.0 { "edge" } else { "thin" };
                sheet.outline(&line, colour, class);
            }
            for meridian in 0..4 {
                let way = DVec2::from_angle(f64::from(meridian) * 45f64.to_radians());
                let along = (-16..=16).map(|step| f64::from(step) / 16.0 * way);
                let line: Vec<DVec2> = along.map(|at| frame.at(dome.point(at))).collect();
                sheet.open_line(&line, colour);
            }
        }
    }
}

/// Returns the ends of a wall that is seen from its edge, and whether its width is seen.
fn edge_on(wall: &super::Wall, frame: &Frame) -> Option<([DVec2; 2], bool)> {
    if frame.side.towards(wall.normal()).abs() > 0.5 {
        return None;
    }
    let [lower_left, lower_right, _, upper_left] = wall.corners();
    let middles = [
        [lower_left, lower_right].map(|corner| corner + 0.5 * wall.upward()),
        [lower_left, upper_left].map(|corner| corner + 0.5 * wall.across()),
    ];
    let [width, height] = middles.map(|ends| ends.map(|end| frame.at(end)));
    let is_width = width[0].distance(width[1]) >= height[0].distance(height[1]);
    Some((if is_width { width } else { height }, is_width))
}

/// Writes a screen's name and size beside it, or in its lower left corner.
fn name_of(screen: Screen<'_>, frame: &Frame, colour: &str, sheet: &mut Sheet) {
    let name = screen.name();
    match screen {
        Screen::Wall(wall) => {
            if let Some((ends, is_width)) = edge_on(wall, frame) {
                let edge = if is_width {
                    wall.across()
                } else {
                    wall.upward()
                };
                let text = format!("{name}  {:.2} m", edge.length());
                let middle = ends[0].midpoint(ends[1]);
                let outwards = frame.side.place(-wall.normal()) * DVec2::new(1.0, -1.0);
                let mut along = (ends[1] - ends[0]).normalize_or(DVec2::X);
                if along.x < -0.1 || along.x < 0.1 && along.y > 0.0 {
                    along = -along;
                }
                // Letters stand on a line, so below one they are farther away.
                let up = DVec2::new(along.y, -along.x);
                let distance = if up.dot(outwards) > 0.0 { 1.6 } else { 4.0 };
                let place = middle + distance * outwards.normalize_or_zero();
                let turn = along.to_angle().to_degrees();
                sheet.coloured_text(place, Anchor::Middle, colour, turn, &text);
            } else if frame.side.towards(wall.normal()) > 0.0 {
                let corners = wall.corners().map(|corner| frame.at(corner));
                let lowest = |at: DVec2| at.y - at.x;
                let corner = corners
                    .into_iter()
                    .max_by(|a, b| lowest(*a).total_cmp(&lowest(*b)));
                let place = corner.unwrap_or_default() + DVec2::new(2.0, -2.0);
                sheet.coloured_text(place, Anchor::Start, colour, 0.0, name);
            }
        }
        Screen::Dome(dome) => {
            let [least, most] = frame.side.extent(&surface(screen));
            let below = DVec2::new(0.5 * (least.x + most.x), least.y);
            let text = format!("{name}  radius {:.2} m", dome.radius);
            let place = frame.on_page(below) + 4.5 * DVec2::Y;
            sheet.coloured_text(place, Anchor::Middle, colour, 0.0, &text);
        }
    }
}

/// Returns the convex hull of points, once round.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., before, last] = chain.as_slice()
                && (last - before).perp_dot(point - last) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut round = half(&mut points.iter().copied());
    round.append(&mut half(&mut points.iter().rev().copied()));
    round
}

/// Breaks a text into lines of at most so many letters, where words allow.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < letters => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
